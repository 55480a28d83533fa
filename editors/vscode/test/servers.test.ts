// Both servers, started with the extension's own command lines and spoken to through the libraries that the editor
// uses.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import path from "node:path";
import { test, type TestContext } from "node:test";
import { DebugClient } from "@vscode/debugadapter-testsupport";
import {
  createProtocolConnection,
  StreamMessageReader,
  StreamMessageWriter,
  type Diagnostic,
  type ProtocolConnection,
} from "vscode-languageserver-protocol/node";
import {
  debugAdapter,
  languageServer,
  pageFrom,
  recordingBeside,
  run,
  settingsFrom,
  showRecording,
} from "../src/settings";
import { ELITESERVER, file, folder } from "./common";

const settings = settingsFrom((key) => (key === "path" ? ELITESERVER : undefined));
const PATIENCE_MS = 60_000;

/** A language server that ends with the test. */
function languageClient(context: TestContext): ProtocolConnection {
  const { command, args } = languageServer(settings);
  const child = spawn(command, [...args], { stdio: ["pipe", "pipe", "inherit"] });
  const connection = createProtocolConnection(
    new StreamMessageReader(child.stdout),
    new StreamMessageWriter(child.stdin),
  );
  connection.listen();
  context.after(() => {
    connection.dispose();
    child.kill();
  });
  return connection;
}

test("the language server finds, completes, explains and formats", { timeout: PATIENCE_MS }, async (context) => {
  const connection = languageClient(context);
  const made = folder((end) => context.after(end));
  const uri = `file://${path.join(made, "a.script")}`;
  const findings: Diagnostic[][] = [];
  const waiting: ((found: Diagnostic[]) => void)[] = [];
  connection.onNotification("textDocument/publishDiagnostics", (told: { diagnostics: Diagnostic[] }) => {
    const next = waiting.shift();
    if (next) next(told.diagnostics);
    else findings.push(told.diagnostics);
  });
  const found = () =>
    Promise.resolve(findings.shift() ?? new Promise<Diagnostic[]>((resolve) => waiting.push(resolve)));
  const ready = await connection.sendRequest<{ capabilities: Record<string, unknown> }>("initialize", {
    processId: process.pid,
    rootUri: `file://${made}`,
    locale: "en",
    capabilities: {
      textDocument: {
        publishDiagnostics: {},
        completion: { completionItem: { snippetSupport: true } },
        hover: { contentFormat: ["markdown"] },
      },
    },
  });
  assert(ready.capabilities["hoverProvider"]);
  await connection.sendNotification("initialized", {});
  const text = "def f():\n    movej(spee)\nend\nf()\n";
  await connection.sendNotification("textDocument/didOpen", {
    textDocument: { uri, languageId: "elitescript", version: 1, text },
  });
  assert.deepEqual(
    (await found()).map((finding) => finding.code),
    ["undefined-name"],
  );
  await connection.sendNotification("textDocument/didChange", {
    textDocument: { uri, version: 2 },
    contentChanges: [
      {
        range: { start: { line: 1, character: 10 }, end: { line: 1, character: 14 } },
        text: "[0, -1.57, 1.57, -1.57, -1.57, 0]",
      },
    ],
  });
  assert.deepEqual(await found(), []);
  const place = { textDocument: { uri }, position: { line: 1, character: 6 } };
  const hover = await connection.sendRequest<{ contents: { value: string } }>("textDocument/hover", place);
  assert.match(hover.contents.value, /movej\(q,/);
  const completion = await connection.sendRequest<{ items?: { label: string }[] } | { label: string }[]>(
    "textDocument/completion",
    place,
  );
  const items = Array.isArray(completion) ? completion : (completion.items ?? []);
  assert(items.some((item) => item.label === "movej"));
  const edits = await connection.sendRequest<unknown[]>("textDocument/formatting", {
    textDocument: { uri },
    options: { tabSize: 4, insertSpaces: true },
  });
  assert(Array.isArray(edits));
  const symbols = await connection.sendRequest<{ name: string }[]>("textDocument/documentSymbol", {
    textDocument: { uri },
  });
  assert.deepEqual(
    symbols.map((symbol) => symbol.name),
    ["f"],
  );
  await connection.sendRequest("shutdown");
  await connection.sendNotification("exit");
});

test("the debugger holds, looks, goes back and on", { timeout: PATIENCE_MS }, async (context) => {
  const made = folder((end) => context.after(end));
  const program = file(
    made,
    "sum.script",
    "total = 0\nfor i in range(3):\n    total = total + i\nprint('total', total)\n",
  );
  const { command, args } = debugAdapter(settings);
  const client = new DebugClient(command, args[0] ?? "", "eliteserver");
  context.after(() => client.stop());
  client.defaultTimeout = PATIENCE_MS;
  await client.start();
  const said: string[] = [];
  client.on("output", (event: { body: { output: string } }) => said.push(event.body.output));
  await Promise.all([
    client.configurationSequence(),
    client.launch({ program, stopAtEnd: true } as never),
    client.waitForEvent("stopped"),
  ]).catch((error: unknown) => assert.fail(String(error)));
  // Held at the end: backwards to the last statement of the loop.
  await client.setBreakpointsRequest({ source: { path: program }, breakpoints: [{ line: 3, condition: "i == 2" }] });
  const [back] = await Promise.all([
    client.waitForEvent("stopped"),
    client.customRequest("reverseContinue", { threadId: 1 }),
  ]);
  assert.equal((back.body as { reason: string }).reason, "breakpoint");
  const { body } = await client.stackTraceRequest({ threadId: 1 });
  assert.equal(body.stackFrames[0]?.line, 3);
  const total = await client.evaluateRequest({
    expression: "total",
    context: "hover",
    frameId: body.stackFrames[0]?.id ?? 0,
  });
  assert.equal(total.body.result, "1");
  const [step] = await Promise.all([client.waitForEvent("stopped"), client.nextRequest({ threadId: 1 })]);
  assert.equal((step.body as { reason: string }).reason, "step");
  assert.equal(said.join("").match(/total 3/g)?.length, 1, "output is not repeated");
});

test(
  "a run is recorded beside its program, and the recording opens as a page and in the debugger",
  { timeout: PATIENCE_MS },
  async (context) => {
    const made = folder((end) => context.after(end));
    const program = file(made, "wave.script", "movej([0.2, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n");
    const recording = recordingBeside(program);
    const ran = run({ ...settings, runOptions: ["--plant", "ideal"] }, program, recording);
    const status = await new Promise((resolve) =>
      spawn(ran.command, [...ran.args], { cwd: made, stdio: "inherit" }).once("exit", resolve),
    );
    assert.equal(status, 0);
    assert(existsSync(recording));

    const ready = path.join(made, "ready.json");
    const shown = showRecording(settings, recording, ready);
    const server = spawn(shown.command, [...shown.args], { cwd: made, stdio: ["ignore", "ignore", "inherit"] });
    context.after(() => server.kill());
    let page: string | undefined;
    while (page === undefined) {
      await new Promise((resolve) => setTimeout(resolve, 20));
      page = existsSync(ready) ? pageFrom(readFileSync(ready, "utf8")) : undefined;
    }
    const answer = await fetch(page);
    assert.equal(answer.status, 200);
    assert.match(await answer.text(), /<html/);

    const { command, args } = debugAdapter(settings);
    const client = new DebugClient(command, args[0] ?? "", "eliteserver");
    context.after(() => client.stop());
    client.defaultTimeout = PATIENCE_MS;
    await client.start();
    await Promise.all([
      client.configurationSequence(),
      client.launch({ recording, stopAtEnd: true } as never),
      client.waitForEvent("stopped"),
    ]);
  },
);
