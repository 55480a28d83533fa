// What the settings mean: which program is started, with which arguments. Knows nothing of the editor, so that the
// tests start the very same commands.

/** The settings `elitescript.…`. */
export interface Settings {
  readonly path: string;
  readonly language: "auto" | "en" | "zh";
  readonly robotAddress: string;
  readonly runOptions: readonly string[];
}

/** A program and its arguments, without a shell. */
export interface CommandLine {
  readonly command: string;
  readonly args: readonly string[];
}

const DEFAULT_PATH = "eliteserver";

/** Reads the settings; what is not of its type counts as not set. */
export function settingsFrom(get: (key: string) => unknown): Settings {
  const path = get("path");
  const language = get("language");
  const address = get("robot.address");
  const options = get("run.options");
  return {
    path: typeof path === "string" && path.trim() !== "" ? path.trim() : DEFAULT_PATH,
    language: language === "en" || language === "zh" ? language : "auto",
    robotAddress: typeof address === "string" ? address.trim() : "",
    runOptions: Array.isArray(options) ? options.filter((option) => typeof option === "string") : [],
  };
}

/** The language server, on standard input and output. */
export function languageServer(settings: Settings): CommandLine {
  const language = settings.language === "auto" ? [] : ["--language", settings.language];
  return { command: settings.path, args: ["lsp", ...language] };
}

/** The debugger, on standard input and output. */
export function debugAdapter(settings: Settings): CommandLine {
  return { command: settings.path, args: ["debug"] };
}

/** A program on a simulated arm. */
export function run(settings: Settings, file: string, record?: string): CommandLine {
  const recording = record === undefined ? [] : ["--record", record];
  return { command: settings.path, args: ["run", ...settings.runOptions, ...recording, "--", file] };
}

/** A program on a robot, followed to its end. Whoever calls has asked whether the arm may move. */
export function send(settings: Settings, address: string, file: string): CommandLine {
  return { command: settings.path, args: ["send", `--robot=${address}`, "--yes", "--", file] };
}

/** What a robot does, until it is interrupted. */
export function recordRobot(settings: Settings, address: string, recording: string): CommandLine {
  return { command: settings.path, args: ["record", `--robot=${address}`, "--yes", "--out", recording] };
}

/** The tests of a file. */
export function test(settings: Settings, file: string): CommandLine {
  return { command: settings.path, args: ["test", "--", file] };
}

/** A recording as a page; ports are free ones, written into `readyFile`. */
export function showRecording(settings: Settings, recording: string, readyFile: string): CommandLine {
  const ports = ["primary", "rtsi"].flatMap((name) => [`--${name}-port`, "off"]);
  return {
    command: settings.path,
    args: ["replay", "--serve", ...ports, "--http-port", "0", "--ready-file", readyFile, "--", recording],
  };
}

/** Options of `run` as keys of a launch configuration: those of debugging have the same names. */
export function launchKeys(options: readonly string[]): Record<string, string | string[] | boolean> {
  const keys: Record<string, string | string[] | boolean> = {};
  for (let index = 0; index < options.length; index += 1) {
    const [name, inline] = split(options[index] ?? "");
    if (name === undefined) continue;
    const next = options[index + 1];
    const takesNext = inline === undefined && next !== undefined && !next.startsWith("--");
    if (takesNext) index += 1;
    const value = inline ?? (takesNext ? next : true);
    if (value === undefined) continue;
    const key = name === "set" || name === "allow" ? [...asList(keys[name]), String(value)] : value;
    keys[name] = key;
  }
  return keys;
}

function split(option: string): [string | undefined, string | undefined] {
  if (!option.startsWith("--")) return [undefined, undefined];
  const at = option.indexOf("=");
  return at < 0 ? [option.slice(2), undefined] : [option.slice(2, at), option.slice(at + 1)];
}

function asList(value: string | string[] | boolean | undefined): string[] {
  return Array.isArray(value) ? value : [];
}

/** Where the recording of a program goes: beside it. */
export function recordingBeside(file: string): string {
  return `${file.replace(/\.[^./\\]*$/, "")}.mcap`;
}

/** The address of a page from the ready file, once it is there. */
export function pageFrom(readyFile: string): string | undefined {
  try {
    const ready = JSON.parse(readyFile) as { ports?: { http?: unknown } };
    const port = ready.ports?.http;
    return typeof port === "number" ? `http://127.0.0.1:${String(port)}/` : undefined;
  } catch {
    return undefined;
  }
}
