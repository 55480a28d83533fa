// package.json is whole: every file it names is there, every command is registered, every snippet is a program.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import path from "node:path";
import { test } from "node:test";
import yauzl from "yauzl";
import { ELITESERVER, EXTENSION, file, folder, json } from "./common";

interface Contributions {
  languages: { id: string; extensions: string[]; configuration: string }[];
  grammars: { language: string; scopeName: string; path: string }[];
  snippets: { language: string; path: string }[];
  commands: { command: string; title: string }[];
  menus: Record<string, { command: string; when?: string }[]>;
  keybindings: { command: string }[];
  configuration: {
    properties: Record<string, { default: unknown; description?: string; markdownDescription?: string }>;
  };
  debuggers: { type: string; configurationAttributes: { launch: { properties: Record<string, unknown> } } }[];
  breakpoints: { language: string }[];
}

const manifest = json("package.json") as { contributes: Contributions; main: string };
const { contributes } = manifest;
const sources = readdirSync(path.join(EXTENSION, "src")).map((name) =>
  readFileSync(path.join(EXTENSION, "src", name), "utf8"),
);
const code = sources.join("\n");

test("files that are named are there", () => {
  const named = [
    ...contributes.languages.map((l) => l.configuration),
    ...contributes.grammars.map((g) => g.path),
    ...contributes.snippets.map((s) => s.path),
  ];
  for (const name of named) assert(existsSync(path.join(EXTENSION, name)), name);
  const [grammar] = contributes.grammars;
  assert.equal(json(grammar?.path ?? "")["scopeName"], grammar?.scopeName);
});

test("one language, everywhere", () => {
  const [language] = contributes.languages;
  const used = [...contributes.grammars, ...contributes.snippets, ...contributes.breakpoints].map(
    (entry) => entry.language,
  );
  for (const id of used) assert.equal(id, language?.id);
  assert(language?.extensions.includes(".script"));
});

test("commands: declared, registered and in menus are the same", () => {
  const declared = contributes.commands.map((command) => command.command).sort();
  const registered = [...code.matchAll(/^ {4}"(elitescript\.\w+)": async/gm)].map((match) => match[1]).sort();
  assert.deepEqual(registered, declared);
  const shown = [...Object.values(contributes.menus).flat(), ...contributes.keybindings].map((entry) => entry.command);
  for (const command of shown) assert(declared.includes(command), command);
});

test("settings: what is read is declared, and the other way round", () => {
  const declared = Object.keys(contributes.configuration.properties).map((key) => key.replace("elitescript.", ""));
  const read = [...code.matchAll(/get\("([\w.]+)"\)/g)].map((match) => match[1]);
  // The language client reads how much it is to log by itself.
  assert.deepEqual([...read, "trace.server"].sort(), declared.sort());
  for (const [key, setting] of Object.entries(contributes.configuration.properties)) {
    assert((setting.description ?? setting.markdownDescription ?? "").length > 10, key);
    assert(setting.default !== undefined, key);
  }
});

test("keys of a launch are options of run, by their names", () => {
  const [contributed] = contributes.debuggers;
  const keys = Object.keys(contributed?.configurationAttributes.launch.properties ?? {});
  const own = ["program", "recording", "stopOnEntry", "stopAtEnd"];
  const help = spawnSync(ELITESERVER, ["run", "--help"], { encoding: "utf8" }).stdout;
  for (const key of keys.filter((key) => !own.includes(key))) assert.match(help, new RegExp(`--${key} `), key);
  assert.match(code, /DEBUG_TYPE = "eliteserver"/);
  assert.equal(contributed?.type, "eliteserver");
});

/** A snippet with its defaults. */
function expanded(body: string | string[]): string {
  const defaults = new Map<string, string>();
  const text = [body]
    .flat()
    .join("\n")
    .replace(/\$\{(\d+):([^{}]*)\}/g, (_, number: string, value: string) => {
      if (!defaults.has(number)) defaults.set(number, value);
      return value;
    });
  return text.replace(/\$(\d+)/g, (_, number: string) => defaults.get(number) ?? "");
}

test("every snippet is a program without findings", (context) => {
  const made = folder((end) => context.after(end));
  const snippets = json("snippets/elitescript.json") as Record<
    string,
    { prefix: string; body: string | string[]; description: string }
  >;
  const files = Object.values(snippets).map((snippet, index) => {
    const name = snippet.prefix === "test" ? "test_snippet.script" : `${String(index)}.script`;
    return file(made, name, `${expanded(snippet.body)}\n`);
  });
  assert(files.length >= 12);
  const checked = spawnSync(ELITESERVER, ["check", ...files], { encoding: "utf8" });
  assert.equal(checked.status, 0, checked.stdout + checked.stderr);
  const prefixes = Object.values(snippets).map((snippet) => snippet.prefix);
  assert.equal(new Set(prefixes).size, prefixes.length);
});

test("the language configuration's expressions are ones, and indent what is to be indented", () => {
  const { indentationRules } = json("language-configuration.json") as { indentationRules: Record<string, string> };
  const increase = new RegExp(indentationRules["increaseIndentPattern"] ?? "", "u");
  const decrease = new RegExp(indentationRules["decreaseIndentPattern"] ?? "", "u");
  for (const line of ["def f():", "  sec s():  # lamp", "else:", "with a as b:"]) assert(increase.test(line), line);
  for (const line of ["end", "  end  # of f", "elif x:", "except E:"]) assert(decrease.test(line), line);
  for (const line of ["ending = 1", "x = {1: 2}", "definitely:"])
    assert(!increase.test(line) && !decrease.test(line), line);
});

test("the lock file names no machine", () => {
  assert.doesNotMatch(
    readFileSync(path.join(EXTENSION, "package-lock.json"), "utf8"),
    /"resolved": "(?!https:\/\/registry\.npmjs\.org\/)/,
  );
});

test("the package holds what is used and nothing else", async (context) => {
  const made = path.join(
    folder((end) => context.after(end)),
    "elitescript.vsix",
  );
  const npm = (args: string[]) => spawnSync("npm", args, { cwd: EXTENSION, encoding: "utf8" });
  const packed = npm(["run", "--silent", "package", "--", "--out", made]);
  assert.equal(packed.status, 0, packed.stdout + packed.stderr);
  const names = await namesIn(made);
  const wanted = [
    "package.json",
    "README.md",
    "readme.md",
    "LICENSE.txt",
    "language-configuration.json",
    "snippets/elitescript.json",
    "syntaxes/elitescript.tmLanguage.json",
    "dist/extension.js",
  ];
  const inside = names.filter((name) => name.startsWith("extension/")).map((name) => name.slice("extension/".length));
  for (const name of inside) assert(wanted.includes(name), `${name} of ${inside.join(", ")}`);
  for (const name of ["package.json", "dist/extension.js", "syntaxes/elitescript.tmLanguage.json", "LICENSE.txt"])
    assert(inside.includes(name), name);
  const bundle = readFileSync(path.join(EXTENSION, manifest.main), "utf8");
  assert(bundle.length < 1_500_000, `${String(bundle.length)} bytes`);
});

function namesIn(zip: string): Promise<string[]> {
  return new Promise((resolve, reject) => {
    yauzl.open(zip, { lazyEntries: false }, (error, opened) => {
      if (error !== null && error !== undefined) return reject(error);
      const names: string[] = [];
      opened.on("entry", (entry: { fileName: string }) => names.push(entry.fileName));
      opened.on("end", () => resolve(names));
      opened.on("error", reject);
    });
  });
}
