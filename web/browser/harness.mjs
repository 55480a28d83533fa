// Servers, browsers and waiting for the tests in a real browser.
import { AsyncLocalStorage } from "node:async_hooks";
import { spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { gunzipSync } from "node:zlib";
import { chromium } from "playwright-core";

const here = path.dirname(new URL(import.meta.url).pathname);
export const BINARY = process.env.ELITESERVER ?? path.join(here, "../../target/debug/eliteserver");
export const CHROMIUM =
  process.env.CHROMIUM ??
  ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((file) => existsSync(file));
const PATIENCE = Number(process.env.PATIENCE_MS ?? 30000);

export const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

/** Waits until `look` gives something true, and gives it. */
export async function until(look, what, patience = PATIENCE) {
  const end = Date.now() + patience;
  let last;
  for (;;) {
    try {
      last = await look();
      if (last) return last;
    } catch (error) {
      last = error;
    }
    if (Date.now() > end)
      throw new Error(
        `${what} did not come (last: ${last instanceof Error ? last.message.slice(0, 200) : JSON.stringify(last)})`,
      );
    await sleep(25);
  }
}

export function check(condition, what) {
  if (!condition) throw new Error(what);
}

export function near(a, b, tolerance, what) {
  check(Math.abs(a - b) <= tolerance, `${what}: ${a} is not ${b} ± ${tolerance}`);
}

/** A program that moves without end. */
export const MOVES =
  "def p():\n" +
  "  while True:\n" +
  "    movej([0.3, -1.4, 1.5, -1.6, -1.57, 0], a=2, v=1)\n" +
  "    movej([-0.3, -1.4, 1.5, -1.6, -1.57, 0], a=2, v=1)\n" +
  "  end\n" +
  "end\n";
/** The largest difference of two rows of numbers. */
export const moved = (a, b) => Math.max(...a.map((x, k) => Math.abs(x - b[k])));
export const attribute = (page, id, name) => page.id(id).first().getAttribute(name);
/** Waits until a sign on the page has a value. */
export const mode = (page, id, value) =>
  until(async () => (await attribute(page, id, "data-value")) === value, `${id} ${value}`);
export const stands = async (server) =>
  until(async () => moved((await server.state()).actual_qd, [0, 0, 0, 0, 0, 0]) < 1e-3, "the arm to stand");

const owner = new AsyncLocalStorage();
/** What `act` starts and opens ends with it. */
export async function belonging(act) {
  const own = { servers: [], contexts: [], pages: [] };
  try {
    return await owner.run(own, () => act(own));
  } finally {
    await Promise.all(own.pages.map((page) => page.close()));
    await Promise.all(own.contexts.map((context) => context.close()));
    await Promise.all(own.servers.map((server) => server.end()));
    for (const { folder } of own.servers) rmSync(folder, { recursive: true, force: true });
  }
}

/** A server on free ports. */
export class Server {
  constructor(command, options, folder) {
    this.command = command;
    this.options = options;
    this.folder = folder ?? mkdtempSync(path.join(tmpdir(), "page-"));
    mkdirSync(path.join(this.folder, "tasks"), { recursive: true });
    owner.getStore()?.servers.push(this);
  }

  static async start(options = [], folder) {
    const services = ["primary", "interpreter", "rtsi", "dashboard", "modbus"].flatMap((name) => [
      `--${name}-port`,
      "0",
    ]);
    const server = new Server("serve", [...services, "--task-dir", "tasks", "--record", "off", ...options], folder);
    await server.begin("0");
    return server;
  }

  static async replay(file, options = []) {
    const server = new Server("replay", [file, "--serve", "--primary-port", "off", "--rtsi-port", "off", ...options]);
    await server.begin("0");
    return server;
  }

  async begin(port) {
    const ready = path.join(this.folder, "ready.json");
    rmSync(ready, { force: true });
    this.stderr = "";
    this.process = spawn(BINARY, [this.command, ...this.options, "--http-port", port, "--ready-file", ready], {
      cwd: this.folder,
      stdio: ["ignore", "ignore", "pipe"],
    });
    this.process.stderr.on("data", (bytes) => (this.stderr += bytes));
    await until(() => existsSync(ready), `the ready file of ${this.command} (${this.stderr})`);
    this.ports = JSON.parse(readFileSync(ready)).ports;
    this.base = `http://127.0.0.1:${this.ports.http}`;
    this.token = (await this.get("/api/v1/session")).token;
  }

  async get(where) {
    return (await fetch(this.base + where)).json();
  }

  async state() {
    return this.get("/api/v1/state");
  }

  async order(order) {
    const answer = await fetch(`${this.base}/api/v1/orders`, {
      method: "POST",
      headers: { "content-type": "application/json", authorization: `Bearer ${this.token}` },
      body: JSON.stringify(order),
    });
    return { status: answer.status, ...(await answer.json()) };
  }

  async run(text, name = "t.script") {
    const answer = await this.order({ do: "run", name, text });
    check(answer.ok, `run: ${answer.error}`);
  }

  async end(signal = "SIGTERM") {
    if (this.process.exitCode !== null) return;
    const gone = new Promise((done) => this.process.once("exit", done));
    this.process.kill(signal);
    await gone;
  }
}

/** A page that a test hands out comes from nowhere, for Chromium, and may not connect to this machine. */
const ROUTED = process.env.PAGE_BUNDLE ? ["--disable-features=LocalNetworkAccessChecks"] : [];
/** Draws in software, as a machine without a graphics card does: all that it shows costs much of a small one. */
const DRAWING = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
/** Shows pages without any of that, so there is no 3D view. */
const FLAT = ["--disable-gpu", "--disable-3d-apis"];

/** A browser with the 3D view, or a flat one, which needs a tenth of the time. */
export async function launch({ flat = false } = {}) {
  return chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", ...(flat ? FLAT : DRAWING), ...ROUTED] });
}

/** A page that is connected; what it complains of is kept. */
export async function open(browser, server, options = {}) {
  // What a browser keeps it keeps by server, and each has a port of its own: pages without wishes share one process
  // that shows them.
  const isPlain = Object.keys(options).length === 0;
  const made = () => browser.newContext({ viewport: { width: 1280, height: 720 }, locale: "en-US", ...options });
  const context = await (isPlain ? (browser.plain ??= made()) : made());
  const page = await context.newPage();
  if (!isPlain) owner.getStore()?.contexts.push(context);
  owner.getStore()?.pages.push(page);
  page.setDefaultTimeout(PATIENCE);
  page.complaints = [];
  page.requests = [];
  page.on("pageerror", (error) => page.complaints.push(error.message));
  page.on("console", (message) => {
    // Chromium itself styles what `fill` puts into an editor, and refuses that to itself.
    if (message.type() === "error" && !/WebSocket|Failed to load resource|Applying inline style/.test(message.text()))
      page.complaints.push(
        `${message.text().slice(0, 300)} ${message.location().url}:${message.location().columnNumber}`,
      );
  });
  page.on("request", (request) => page.requests.push(request.url()));
  page.on("dialog", (dialog) => page.complaints.push(`dialog: ${dialog.message()}`));
  page.id = (name) => page.getByTestId(name);
  page.text = async (name) => (await page.getByTestId(name).first().innerText()).trim();
  page.value = async (name) => Number(await page.getByTestId(name).inputValue());
  page.connected = () =>
    until(async () => (await page.id("connection").getAttribute("data-value")) === "connected", "the connection");
  // A bundle of `node bundle.mjs dist` is tried without building the program anew.
  const bundle = process.env.PAGE_BUNDLE;
  if (bundle) {
    await page.route(server.base + "/", async (route) => {
      const response = await route.fetch();
      const nonce = /name="style-nonce" content="([^"]*)"/.exec(await response.text())?.[1] ?? "";
      await route.fulfill({
        response,
        body: readFileSync(path.join(bundle, "index.html"), "utf8").replaceAll("__NONCE__", nonce),
      });
    });
    for (const [name, contentType] of [
      ["app.js", "text/javascript"],
      ["view.js", "text/javascript"],
      ["app.css", "text/css"],
    ]) {
      await page.route(`**/${name}`, (route) =>
        route.fulfill({ contentType, body: gunzipSync(readFileSync(path.join(bundle, `${name}.gz`))) }),
      );
    }
  }
  await page.goto(server.base);
  if (!options.stranger) {
    await page.connected();
    await until(
      () => page.evaluate(() => document.querySelector("[data-testid=robot-mode]").dataset.value),
      "the first frame",
    );
  }
  return page;
}

export async function take(page) {
  await page.id("take-control").click();
  await until(async () => (await page.id("take-control").getAttribute("aria-pressed")) === "true", "control");
}

/**
 * The arm stops where a busy machine has kept the page silent for 150 ms; whoever holds the button sees it and presses
 * again.
 */
const HELD_MS = 5000;

/** Presses a button, by the mouse or by a key, until something is so; it is held then. */
export async function press(page, name, look, what, key) {
  await until(() => page.id(name).isEnabled(), `${name} to be enabled`);
  for (const end = Date.now() + PATIENCE; ;) {
    await (key ? page.id(name).focus() : page.id(name).hover());
    await (key ? page.keyboard.down(key) : page.mouse.down());
    try {
      return await until(look, what, HELD_MS);
    } catch (error) {
      await (key ? page.keyboard.up(key) : page.mouse.up());
      if (Date.now() > end) throw error;
    }
  }
}

/** Holds a button until something is so. */
export async function hold(page, name, look) {
  await press(page, name, look, `what ${name} does`);
  await page.mouse.up();
}

/**
 * Holds answers of the server back: `held.asked()` waits for a question, `held.answer()` answers all and waits until
 * the page has it.
 */
export async function holdBack(page, url) {
  const waiting = [];
  await page.route(url, (route) => new Promise((go) => waiting.push(go)).then(() => route.continue()));
  return {
    asked: (count = 1) => until(() => waiting.length >= count, `question ${count} of ${url}`),
    async answer() {
      const answered = waiting.map(() => page.waitForResponse(url));
      waiting.forEach((go) => go());
      await Promise.all(answered);
      await page.unroute(url);
      // Longer than the page needs to do something with it.
      await sleep(300);
    },
  };
}

export async function edit(page, text) {
  await page.id("editor").fill(text);
}
