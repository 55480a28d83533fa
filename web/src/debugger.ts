// The debugger's side of the page: breakpoints are set, a held program is looked at and led on. Speaks the Debug
// Adapter Protocol over `/api/v1/debug`. Knows no elements; what it finds is told to whoever shows it.

export interface Breakpoint {
  line: number;
  condition?: string;
  hitCondition?: string;
  logMessage?: string;
}
/** What has become of a breakpoint. */
export interface Placed {
  line: number;
  verified: boolean;
  message: string;
}
export interface StackFrame {
  id: number;
  name: string;
  line: number;
  column: number;
  source: string;
}
export interface Scope {
  name: string;
  reference: number;
}
export interface DebugVariable {
  name: string;
  value: string;
  type: string;
  reference: number;
}
/** Where a program is held. */
export interface Held {
  thread: number;
  reason: string;
  text: string;
}

type Json = Record<string, unknown>;
interface Message {
  seq: number;
  type: "request" | "response" | "event";
  command?: string;
  event?: string;
  request_seq?: number;
  success?: boolean;
  message?: string;
  body?: Json;
}
interface Waiting {
  resolve: (body: Json) => void;
  reject: (reason: Error) => void;
}
/** The part of a WebSocket that is used. */
export interface Channel {
  send(text: string): void;
  close(): void;
  onopen: (() => void) | null;
  onmessage: ((message: { data: unknown }) => void) | null;
  onclose: (() => void) | null;
}

const text = (value: unknown): string => (typeof value === "string" ? value : "");
const number = (value: unknown): number => (typeof value === "number" ? value : 0);
const list = (value: unknown): Json[] => (Array.isArray(value) ? (value as Json[]) : []);

export class Debugger {
  held: Held | null = null;
  isAttached = false;
  /** Something has changed: attached or not, held or not. */
  onChange: () => void = () => undefined;
  /** What became of the breakpoints that were set. */
  onPlaced: (placed: Placed[]) => void = () => undefined;
  /** Something went wrong that nobody waits for. */
  onError: (reason: string) => void = () => undefined;

  private channel: Channel | null = null;
  private opening: Promise<void> | null = null;
  private placing: Promise<void> | null = null;
  private next = 1;
  private readonly waiting = new Map<number, Waiting>();
  private wanted: { program: string; breakpoints: Breakpoint[] } = { program: "", breakpoints: [] };

  constructor(private readonly open: () => Channel) {}

  /** Attaches to the program that runs, or will run, as the one who leads it. */
  attach(token: string): Promise<void> {
    this.opening ??= this.begin(token).catch((error: unknown) => {
      this.detach();
      throw error;
    });
    return this.opening;
  }

  private async begin(token: string): Promise<void> {
    const channel = this.open();
    this.channel = channel;
    await new Promise<void>((resolve, reject) => {
      channel.onopen = () => resolve();
      channel.onclose = () => reject(new Error("the debugger's channel cannot be opened"));
    });
    channel.onmessage = (message) => this.take(text(message.data));
    channel.onclose = () => this.lost();
    channel.send(JSON.stringify({ token }));
    await this.request("initialize", {
      adapterID: "eliteserver",
      clientID: "page",
      linesStartAt1: true,
      columnsStartAt1: true,
      pathFormat: "path",
    });
    await this.request("attach", { drive: true });
    await this.sendBreakpoints();
    await this.request("configurationDone");
    this.isAttached = true;
    this.onChange();
  }

  /** What is being done for breakpoints is done, or has failed. */
  async settled(): Promise<void> {
    await Promise.allSettled([this.opening, this.placing]);
  }

  /** Leaves: breakpoints are gone and a held program goes on. */
  detach(): void {
    const channel = this.channel;
    this.lost();
    channel?.close();
  }

  private lost(): void {
    if (this.channel) this.channel.onclose = this.channel.onmessage = null;
    this.channel = null;
    this.opening = null;
    this.isAttached = false;
    this.held = null;
    for (const waiting of this.waiting.values()) waiting.reject(new Error("the debugger's channel was closed"));
    this.waiting.clear();
    this.onChange();
  }

  /** The breakpoints of a program; those of before are replaced. */
  async setBreakpoints(program: string, breakpoints: Breakpoint[]): Promise<void> {
    this.wanted = { program, breakpoints };
    if (!this.isAttached) return;
    this.placing = this.sendBreakpoints();
    await this.placing;
  }

  private async sendBreakpoints(): Promise<void> {
    const { program, breakpoints } = this.wanted;
    const body = await this.request("setBreakpoints", { source: { name: program, path: program }, breakpoints });
    const placed = list(body["breakpoints"]).map((one, k) => ({
      line: number(one["line"]) || (breakpoints[k]?.line ?? 0),
      verified: one["verified"] === true,
      message: text(one["message"]),
    }));
    this.onPlaced(placed);
  }

  async resume(): Promise<void> {
    await this.lead("continue");
  }

  /** On to the next line: over calls, into them, or out of the function. */
  async step(how: "next" | "stepIn" | "stepOut"): Promise<void> {
    await this.lead(how);
  }

  private async lead(command: string): Promise<void> {
    const held = this.held;
    if (!held) throw new Error("nothing is held");
    await this.request(command, { threadId: held.thread });
    // A stop that has come meanwhile is another one.
    if (this.held === held) this.release();
  }

  async stack(): Promise<StackFrame[]> {
    if (!this.held) return [];
    const body = await this.request("stackTrace", { threadId: this.held.thread, startFrame: 0, levels: 50 });
    return list(body["stackFrames"]).map((frame) => ({
      id: number(frame["id"]),
      name: text(frame["name"]),
      line: number(frame["line"]),
      column: number(frame["column"]),
      source: text((frame["source"] as Json | undefined)?.["name"]),
    }));
  }

  async scopes(frame: number): Promise<Scope[]> {
    const body = await this.request("scopes", { frameId: frame });
    return list(body["scopes"]).map((scope) => ({
      name: text(scope["name"]),
      reference: number(scope["variablesReference"]),
    }));
  }

  async variables(reference: number): Promise<DebugVariable[]> {
    const body = await this.request("variables", { variablesReference: reference, start: 0, count: 200 });
    return list(body["variables"]).map(variableOf);
  }

  async evaluate(expression: string, frame: number): Promise<DebugVariable> {
    const body = await this.request("evaluate", { expression, frameId: frame, context: "repl" });
    return variableOf({ ...body, name: expression, value: body["result"] });
  }

  /** Gives a variable another value; what it is then. */
  async assign(reference: number, name: string, value: string): Promise<string> {
    const body = await this.request("setVariable", { variablesReference: reference, name, value });
    return text(body["value"]);
  }

  private request(command: string, given: Json = {}): Promise<Json> {
    const channel = this.channel;
    if (!channel) return Promise.reject(new Error("no debugger is attached"));
    const seq = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(seq, { resolve, reject });
      channel.send(JSON.stringify({ seq, type: "request", command, arguments: given }));
    });
  }

  private take(data: string): void {
    const message = JSON.parse(data) as Message;
    if (message.type === "response") {
      const waiting = this.waiting.get(message.request_seq ?? 0);
      this.waiting.delete(message.request_seq ?? 0);
      if (message.success) waiting?.resolve(message.body ?? {});
      else waiting?.reject(new Error(reasonOf(message)));
      return;
    }
    const body = message.body ?? {};
    if (message.event === "stopped") {
      const reason = text(body["reason"]);
      this.held = { thread: number(body["threadId"]), reason, text: text(body["text"]) || text(body["description"]) };
      this.onChange();
    } else if (message.event === "continued" || message.event === "terminated" || message.event === "exited")
      this.release();
    else if (message.event === "process") {
      // Another program: the places of breakpoints are looked for anew.
      this.release();
      void this.sendBreakpoints().catch((error: Error) => this.onError(error.message));
    }
  }

  private release(): void {
    if (!this.held) return;
    this.held = null;
    this.onChange();
  }
}

function variableOf(one: Json): DebugVariable {
  return {
    name: text(one["name"]),
    value: text(one["value"]),
    type: text(one["type"]),
    reference: number(one["variablesReference"]),
  };
}

/** Why a request was refused: the sentence for people, where there is one. */
function reasonOf(message: Message): string {
  const error = message.body?.["error"] as Json | undefined;
  return text(error?.["format"]) || text(message.message) || "the debugger refused it";
}
