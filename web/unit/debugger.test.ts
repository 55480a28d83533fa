import assert from "node:assert/strict";
import { test } from "node:test";
import { type Channel, Debugger } from "../src/debugger";

interface Asked {
  seq: number;
  command: string;
  arguments: Record<string, unknown>;
}

/** A server of the protocol that answers everything at once, unless a test answers for it. */
class Server implements Channel {
  onopen: (() => void) | null = null;
  onmessage: ((message: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;
  asked: Asked[] = [];
  first: Record<string, unknown> | null = null;
  answers: Record<string, (asked: Asked) => unknown> = {};
  isClosed = false;

  send(text: string): void {
    const message = JSON.parse(text) as Asked & { token?: string };
    if (message.token !== undefined) {
      this.first = { token: message.token };
      return;
    }
    this.asked.push(message);
    let body: unknown = {};
    let success = true;
    try {
      body = this.answers[message.command]?.(message) ?? {};
    } catch (error) {
      success = false;
      body = { error: { format: (error as Error).message } };
    }
    queueMicrotask(() =>
      this.tell({ type: "response", request_seq: message.seq, command: message.command, success, body }),
    );
  }

  close(): void {
    this.isClosed = true;
    this.onclose?.();
  }

  tell(message: unknown): void {
    this.onmessage?.({ data: JSON.stringify({ seq: 0, ...(message as object) }) });
  }

  event(event: string, body: unknown = {}): void {
    this.tell({ type: "event", event, body });
  }
}

async function attached(answers: Server["answers"] = {}): Promise<{ debug: Debugger; server: Server }> {
  const server = new Server();
  server.answers = answers;
  const debug = new Debugger(() => (queueMicrotask(() => server.onopen?.()), server));
  await debug.setBreakpoints("a.script", [{ line: 3, condition: "n > 2" }]);
  await debug.attach("secret");
  return { debug, server };
}

test("the debugger shows its token, attaches to lead, and sets breakpoints before it says it is ready", async () => {
  const placed: unknown[] = [];
  const server = new Server();
  server.answers["setBreakpoints"] = () => ({ breakpoints: [{ verified: false, line: 4, message: "no statement" }] });
  const debug = new Debugger(() => (queueMicrotask(() => server.onopen?.()), server));
  debug.onPlaced = (found) => placed.push(...found);
  await debug.setBreakpoints("a.script", [{ line: 3, condition: "n > 2" }]);
  await Promise.all([debug.attach("secret"), debug.attach("secret")]);
  assert.deepEqual(server.first, { token: "secret" });
  assert.deepEqual(
    server.asked.map((asked) => asked.command),
    ["initialize", "attach", "setBreakpoints", "configurationDone"],
  );
  assert.deepEqual(server.asked[1]?.arguments, { drive: true });
  assert.deepEqual(server.asked[2]?.arguments["breakpoints"], [{ line: 3, condition: "n > 2" }]);
  assert.deepEqual(placed, [{ line: 4, verified: false, message: "no statement" }]);
  assert.ok(debug.isAttached);
});

test("a program that is held is looked at and led on; the next stop is another one", async () => {
  const { debug, server } = await attached({
    stackTrace: () => ({ stackFrames: [{ id: 7, name: "p", line: 3, column: 1, source: { name: "a.script" } }] }),
    scopes: () => ({ scopes: [{ name: "Locals", variablesReference: 9 }] }),
    variables: () => ({ variables: [{ name: "n", value: "3", type: "int", variablesReference: 0 }] }),
    // It is held again before the answer comes.
    next: () => (
      server.event("continued", { threadId: 1 }),
      server.event("stopped", { reason: "step", threadId: 1 }),
      {}
    ),
  });
  server.event("stopped", { reason: "breakpoint", threadId: 1 });
  assert.deepEqual(debug.held, { thread: 1, reason: "breakpoint", text: "" });
  assert.deepEqual(await debug.stack(), [{ id: 7, name: "p", line: 3, column: 1, source: "a.script" }]);
  assert.deepEqual(await debug.scopes(7), [{ name: "Locals", reference: 9 }]);
  assert.equal((await debug.variables(9))[0]?.value, "3");
  await debug.step("next");
  assert.equal(debug.held?.reason, "step");
  await debug.resume();
  assert.equal(debug.held, null);
  await assert.rejects(debug.resume(), /nothing is held/);
});

test("what is refused is told in the server's words, and a channel that breaks leaves nothing waiting", async () => {
  const { debug, server } = await attached({
    evaluate: () => {
      throw new Error("NameError: name 'x' is not defined");
    },
  });
  server.event("stopped", { reason: "pause", threadId: 1 });
  await assert.rejects(debug.evaluate("x", 7), /NameError/);
  server.send = () => undefined;
  const waiting = debug.stack();
  server.close();
  await assert.rejects(waiting, /closed/);
  assert.equal(debug.held, null);
  assert.equal(debug.isAttached, false);
});

test("an attachment that is refused can be tried again", async () => {
  let tries = 0;
  const servers: Server[] = [];
  const debug = new Debugger(() => {
    const server = new Server();
    server.answers["attach"] = () => {
      if (++tries === 1) throw new Error("another client drives already");
    };
    servers.push(server);
    queueMicrotask(() => server.onopen?.());
    return server;
  });
  await assert.rejects(debug.attach("t"), /another client drives/);
  assert.ok(servers[0]?.isClosed);
  await debug.attach("t");
  assert.ok(debug.isAttached);
});
