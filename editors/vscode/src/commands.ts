// What the buttons and the command palette do.
import { spawn } from "node:child_process";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import * as vscode from "vscode";
import { current } from "./current";
import { DEBUG_TYPE, launch } from "./debugger";
import { notFound, type LanguageServer } from "./server";
import { pageFrom, recordRobot, recordingBeside, run, send, showRecording, test, type CommandLine } from "./settings";

/** A page has so long to open. */
const PAGE_PATIENCE_MS = 10_000;
const PAGE_POLL_MS = 50;

export function registerCommands(
  context: vscode.ExtensionContext,
  output: vscode.LogOutputChannel,
  server: LanguageServer,
): void {
  const pages = new Pages(output);
  const commands: Record<string, (resource?: vscode.Uri) => Promise<void>> = {
    "elitescript.run": async (resource) => {
      await withProgram(resource, (file) => inTerminal("Run", run(current(file), file.fsPath), file));
    },
    "elitescript.record": async (resource) => {
      await withProgram(resource, (file) => {
        inTerminal("Run and record", run(current(file), file.fsPath, recordingBeside(file.fsPath)), file);
      });
    },
    "elitescript.test": async (resource) => {
      await withProgram(resource, (file) => inTerminal("Test", test(current(file), file.fsPath), file));
    },
    "elitescript.debug": async (resource) => {
      await withProgram(resource, async (file) => {
        await vscode.debug.startDebugging(vscode.workspace.getWorkspaceFolder(file), launch(file));
      });
    },
    "elitescript.send": async (resource) => {
      await withProgram(resource, async (file) => {
        const address = await robot(file);
        if (address === undefined) return;
        const go = "Send";
        const name = path.basename(file.fsPath);
        const asked = await vscode.window.showWarningMessage(
          `Send ${name} to ${address}? If that is a real robot, its arm moves.`,
          { modal: true },
          go,
        );
        if (asked === go) inTerminal("Send", send(current(file), address, file.fsPath), file);
      });
    },
    "elitescript.recordRobot": async () => {
      const address = await robot();
      if (address === undefined) return;
      const chosen = await vscode.window.showSaveDialog({ filters: { Recordings: ["mcap"] }, title: "Record to" });
      if (chosen !== undefined) inTerminal("Record robot", recordRobot(current(), address, chosen.fsPath), chosen);
    },
    "elitescript.debugRecording": async (resource) => {
      const recording = await recordingOf(resource);
      if (recording === undefined) return;
      await vscode.debug.startDebugging(vscode.workspace.getWorkspaceFolder(recording), {
        type: DEBUG_TYPE,
        request: "launch",
        name: path.basename(recording.fsPath),
        recording: recording.fsPath,
        stopAtEnd: true,
      });
    },
    "elitescript.showRecording": async (resource) => {
      const recording = await recordingOf(resource);
      if (recording !== undefined) await pages.open(recording);
    },
    "elitescript.restart": async () => server.restart(),
  };
  context.subscriptions.push(pages);
  for (const [name, action] of Object.entries(commands)) {
    context.subscriptions.push(vscode.commands.registerCommand(name, action));
  }
}

/** The program that is meant, written to its file. */
async function withProgram(resource: vscode.Uri | undefined, action: (file: vscode.Uri) => unknown): Promise<void> {
  const file = resource ?? vscode.window.activeTextEditor?.document.uri;
  if (file?.scheme !== "file") {
    await vscode.window.showErrorMessage("EliteScript: open a program that is a file first.");
    return;
  }
  const document = vscode.workspace.textDocuments.find((open) => open.uri.toString() === file.toString());
  if (document?.isDirty === true && !(await document.save())) return;
  await action(file);
}

async function robot(file?: vscode.Uri): Promise<string | undefined> {
  const set = current(file).robotAddress;
  if (set !== "") return set;
  const given = await vscode.window.showInputBox({
    title: "Name or address of the robot",
    placeHolder: "192.168.1.100",
    validateInput: (text) =>
      /^[\w.:-]+$/.test(text.trim()) && !text.startsWith("-") ? undefined : "A host name or an address is needed.",
  });
  return given?.trim();
}

async function recordingOf(resource: vscode.Uri | undefined): Promise<vscode.Uri | undefined> {
  if (resource !== undefined) return resource;
  const chosen = await vscode.window.showOpenDialog({ filters: { Recordings: ["mcap"] }, title: "Open recording" });
  return chosen?.[0];
}

/** Runs a command where its output is seen and it can be interrupted; no shell reads its arguments. */
function inTerminal(name: string, { command, args }: CommandLine, beside: vscode.Uri): void {
  const folder = vscode.workspace.getWorkspaceFolder(beside)?.uri.fsPath ?? path.dirname(beside.fsPath);
  const task = new vscode.Task(
    { type: "process" },
    vscode.TaskScope.Workspace,
    `${name} ${path.basename(beside.fsPath)}`,
    "EliteScript",
    new vscode.ProcessExecution(command, [...args], { cwd: folder }),
  );
  task.presentationOptions = {
    reveal: vscode.TaskRevealKind.Always,
    panel: vscode.TaskPanelKind.Dedicated,
    clear: true,
  };
  void vscode.tasks.executeTask(task).then(undefined, (error: unknown) => notFound(command, error));
}

/** Servers that show recordings; they end with the editor. */
class Pages implements vscode.Disposable {
  private readonly running = new Set<() => void>();

  constructor(private readonly output: vscode.LogOutputChannel) {}

  async open(recording: vscode.Uri): Promise<void> {
    const folder = await mkdtemp(path.join(tmpdir(), "elitescript-"));
    const ready = path.join(folder, "ready.json");
    const { command, args } = showRecording(current(recording), recording.fsPath, ready);
    const child = spawn(command, [...args], { stdio: ["ignore", "ignore", "pipe"] });
    const end = () => child.kill();
    this.running.add(end);
    let said = "";
    child.stderr.setEncoding("utf8").on("data", (text: string) => {
      said = (said + text).slice(-4000);
      this.output.info(text.trimEnd());
    });
    const over = new Promise<Error>((resolve) => {
      child.once("error", resolve);
      child.once("exit", () => resolve(new Error(said.trim() || "it ended at once")));
    });
    void over.then(async () => {
      this.running.delete(end);
      await rm(folder, { recursive: true, force: true });
    });
    const page = await Promise.race([pageOf(ready), over]);
    if (typeof page === "string") {
      await vscode.env.openExternal(vscode.Uri.parse(page));
    } else {
      end();
      await notFound(command, page ?? new Error("the page did not open"));
    }
  }

  dispose(): void {
    for (const end of this.running) end();
    this.running.clear();
  }
}

/** The address of the page, once its server has written it. */
async function pageOf(ready: string): Promise<string | undefined> {
  for (let waited = 0; waited < PAGE_PATIENCE_MS; waited += PAGE_POLL_MS) {
    const page = pageFrom(await readFile(ready, "utf8").catch(() => ""));
    if (page !== undefined) return page;
    await new Promise((resolve) => setTimeout(resolve, PAGE_POLL_MS));
  }
  return undefined;
}
