// The connection to the controller: frames and events in, orders out; found again when it is lost.

import { type Frame, readFrame } from "./frame";
import { currentLanguage } from "./words";

export interface ServerEvent {
  event: string;
  [name: string]: unknown;
}

interface Waiting {
  resolve: (value: unknown) => void;
  reject: (reason: Error) => void;
}

export type LinkState = "connecting" | "connected" | "disconnected";

/** Signs of life while something is held. The arm stops after 150 ms without one. */
const ALIVE_MS = 40;
/** A connection over which nothing comes for so long is taken for lost. */
const SILENT_MS = 3000;

export class Link {
  state: LinkState = "connecting";
  page = 0;
  control: number | null = null;
  readOnly: string | null = null;
  token: string | null = null;
  onFrame: (frame: Frame) => void = () => undefined;
  onEvent: (event: ServerEvent) => void = () => undefined;
  onChange: () => void = () => undefined;
  /** Called for a token that a person has to give. */
  onTokenAsked: () => Promise<string | null> = async () => null;

  private socket: WebSocket | null = null;
  private next = 1;
  private waiting = new Map<number, Waiting>();
  private pause = 250;
  private heard = 0;
  private holding = 0;
  private alive: ReturnType<typeof setInterval> | null = null;
  private asking = false;
  /**
   * The token was shown: what is clicked in the first moments of a connection waits for it instead of being refused.
   */
  private introduced: Promise<void> = Promise.resolve();
  private signedAt = 0;

  start(): void {
    this.connect();
    setInterval(() => {
      const isSilent = this.state === "connected" && performance.now() - this.heard > SILENT_MS;
      if (isSilent && document.visibilityState === "visible") this.socket?.close();
    }, 1000);
  }

  get hasControl(): boolean {
    return this.state === "connected" && this.control !== null && this.control === this.page;
  }

  /** Gives an order; the promise ends with the server's answer. */
  async order(order: Record<string, unknown>): Promise<unknown> {
    await this.introduced;
    return this.ask({ order });
  }

  async takeControl(take: boolean): Promise<unknown> {
    await this.introduced;
    return this.ask({ control: take });
  }

  /** When the token is there, if it comes at all. */
  async ready(): Promise<void> {
    await this.introduced;
  }

  /** Begins something that goes on while signs of life come; ends with the answer. */
  async hold(order: Record<string, unknown>): Promise<unknown> {
    const number = ++this.holding;
    this.signedAt = performance.now();
    this.alive ??= setInterval(() => this.sign(), ALIVE_MS / 2);
    try {
      return await this.order(order);
    } finally {
      if (this.holding === number) this.endSigns();
    }
  }

  /** Ends what is held. */
  release(): void {
    this.endSigns();
    if (this.state === "connected") void this.order({ do: "release" }).catch(() => undefined);
  }

  /** A sign of life, if one is due: a busy page gives it at the first opportunity. */
  private sign(): void {
    if (this.alive === null || performance.now() - this.signedAt < ALIVE_MS - 5) return;
    this.signedAt = performance.now();
    this.send({ alive: true });
  }

  private endSigns(): void {
    if (this.alive !== null) clearInterval(this.alive);
    this.alive = null;
  }

  private send(message: Record<string, unknown>): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  private ask(message: Record<string, unknown>): Promise<unknown> {
    if (this.state !== "connected") return Promise.reject(new Error("not connected"));
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.send({ id, ...message });
    });
  }

  private connect(): void {
    this.change("connecting");
    // The token is looked for while the connection is made; it is not needed to look on.
    const finding = this.findToken();
    finding.catch(() => undefined);
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/v1/live`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.addEventListener("message", (message: MessageEvent<ArrayBuffer | string>) => {
      this.heard = performance.now();
      if (typeof message.data === "string") this.take(message.data, finding);
      else {
        const frame = readFrame(message.data);
        if (frame) this.onFrame(frame);
        this.sign();
      }
    });
    socket.addEventListener("close", () => {
      if (this.socket !== socket) return;
      this.socket = null;
      this.endSigns();
      for (const waiting of this.waiting.values()) waiting.reject(new Error("the connection was lost"));
      this.waiting.clear();
      this.control = null;
      this.change("disconnected");
      this.retry();
    });
  }

  private retry(): void {
    if (this.state !== "disconnected") this.change("disconnected");
    setTimeout(() => this.connect(), this.pause);
    this.pause = Math.min(this.pause * 1.6, 2000);
  }

  /** A server that was started again has another token. */
  private async findToken(): Promise<void> {
    const answer = await fetch("/api/v1/session", { cache: "no-store" });
    const session = (await answer.json()) as { token: string | null; asks_for_token: boolean };
    if (session.token !== null) this.token = session.token;
    else if (!session.asks_for_token) this.token = null;
    else this.token = sessionStorage.getItem("token");
    this.asking = session.asks_for_token;
  }

  private take(text: string, finding: Promise<void>): void {
    const message = JSON.parse(text) as ServerEvent & {
      answer?: number;
      ok?: boolean;
      value?: unknown;
      error?: string;
      texts?: Record<string, string>;
    };
    if (typeof message.answer === "number") {
      const waiting = this.waiting.get(message.answer);
      this.waiting.delete(message.answer);
      if (message.ok) waiting?.resolve(message.value);
      else waiting?.reject(new Error(refusalText(message)));
      return;
    }
    if (message.event === "welcome") {
      this.page = message["you"] as number;
      this.control = message["control"] as number | null;
      this.readOnly = message["read_only"] as string | null;
      this.pause = 250;
      this.introduced = finding.then(
        () => this.introduce(),
        () => this.socket?.close(),
      );
      this.change("connected");
    } else if (message.event === "control") {
      this.control = message["page"] as number | null;
      if (!this.hasControl) this.endSigns();
      this.onChange();
    }
    this.onEvent(message);
  }

  /** Shows the token; asks a person for it where the server does not give it. */
  private async introduce(): Promise<void> {
    if (this.readOnly !== null) return;
    for (let tries = 0; tries < 3; tries++) {
      if (this.token === null) {
        if (!this.asking) return;
        this.token = await this.onTokenAsked();
        if (this.token === null) return;
      }
      try {
        await this.ask({ token: this.token });
        if (this.asking) sessionStorage.setItem("token", this.token);
        return;
      } catch {
        this.token = null;
      }
    }
  }

  private change(state: LinkState): void {
    this.state = state;
    this.onChange();
  }
}

/** Why something was refused, in the language of the page where the server has told it. */
function refusalText(answer: { error?: string; texts?: Record<string, string> }): string {
  return answer.texts?.[currentLanguage()] ?? answer.error ?? "refused";
}

/** An answer of /api/v1 as JSON; what is refused is an error with the server's sentence. */
export async function api<T>(
  path: string,
  init: { method?: string; body?: unknown; token?: string | null; signal?: AbortSignal } = {},
): Promise<T> {
  const headers: Record<string, string> = {};
  if (init.body !== undefined) headers["content-type"] = "application/json";
  if (init.token) headers["authorization"] = `Bearer ${init.token}`;
  const answer = await fetch(path, {
    method: init.method ?? (init.body === undefined ? "GET" : "POST"),
    headers,
    cache: "no-store",
    ...(init.signal ? { signal: init.signal } : {}),
    ...(init.body === undefined ? {} : { body: JSON.stringify(init.body) }),
  });
  const value = (await answer.json()) as T & { error?: string; texts?: Record<string, string> };
  if (!answer.ok)
    throw Object.assign(new Error(value.error === undefined ? answer.statusText : refusalText(value)), {
      status: answer.status,
    });
  return value;
}
