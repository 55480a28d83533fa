// What needs a server of its own kind: started again, bound to the network, a recording; and the 3D view.
import { execFile } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { promisify } from "node:util";
import { BINARY, Server, check, open, sleep, take, until } from "./harness.mjs";

/** The recording that those of the time line share. */
let recording;
/** Made once: a program that moves, says and sets something, and ends by an error. */
async function recorded() {
  recording ??= record();
  return recording;
}
async function record() {
  const folder = mkdtempSync(path.join(tmpdir(), "page-"));
  process.once("exit", () => rmSync(folder, { recursive: true, force: true }));
  const [script, file] = [path.join(folder, "r.script"), path.join(folder, "r.mcap")];
  writeFileSync(
    script,
    "def r():\n" +
      "  movej([0.5, -1.2, 1.4, -1.77, -1.57, 0], a=2, v=1)\n" +
      "  global n\n" +
      "  n = 7\n" +
      "  textmsg('half way')\n" +
      "  set_standard_digital_out(2, True)\n" +
      "  movej([-0.5, -1.2, 1.4, -1.77, -1.57, 0], a=2, v=1)\n" +
      "  x = 1 / 0\n" +
      "end\n",
  );
  // The last line is an error on purpose.
  await promisify(execFile)(BINARY, ["run", script, "--record", file]).catch(() => undefined);
  return file;
}

export const scenarios = {
  async "the page finds a server that was started again"({ browser }) {
    const server = await Server.start();
    const page = await open(browser, server);
    await take(page);
    const port = String(server.ports.http);
    await server.end("SIGKILL");
    await until(async () => (await page.id("connection").getAttribute("data-value")) !== "connected", "the loss");
    check(await page.id("jog-j1-plus").isDisabled(), "jog without a connection");
    await server.begin(port);
    await page.connected();
    await take(page);
    check(await page.id("jog-j1-plus").isEnabled(), "jog");
  },
  async "beyond loopback the page asks for the token"({ browser }) {
    const server = await Server.start(["--bind", "0.0.0.0"]);
    check(server.token === null, "it is given away");
    const printed = await until(() => /token of the pendant page is ([0-9a-f]{32})/.exec(server.stderr), "the token");
    const page = await open(browser, server, { stranger: true });
    await page.id("token").fill("wrong");
    await page.id("token").press("Enter");
    await until(async () => (await page.id("token").inputValue()) === "", "the question again");
    await page.id("token").fill(printed[1]);
    await page.id("token").press("Enter");
    await until(() => page.id("take-control").isEnabled(), "the page");
    await take(page);
  },
  async "a page of another server looks at nothing and orders nothing"({ browser }) {
    const [server, other] = await Promise.all([Server.start(), Server.start()]);
    const page = await open(browser, other);
    const found = await page.evaluate(async (base) => {
      const token = await fetch(`${base}/api/v1/session`).then(
        (answer) => answer.text(),
        () => "unreadable",
      );
      const socket = new WebSocket(`${base.replace("http", "ws")}/api/v1/live`);
      const live = await new Promise(
        (done) => ((socket.onopen = () => done("open")), (socket.onerror = () => done("refused"))),
      );
      return { token, live };
    }, server.base);
    check(found.token === "unreadable" && found.live === "refused", JSON.stringify(found));
    // What the browser itself complains of is what was tried.
    page.complaints.length = 0;
  },
  async "a recording is shown, gone through and not touched"({ browser }) {
    const server = await Server.replay(await recorded());
    const page = await open(browser, server);
    await until(() => page.id("take-control").isDisabled(), "no control of a recording");
    await until(() => page.id("stop").isHidden(), "no stop of a recording");
    const end = await until(async () => {
      const read = await fetch(`${server.base}/api/v1/history?points=1`);
      const last = Number(read.headers.get("x-last-time"));
      const max = Number(await page.id("timeline").getAttribute("max"));
      return read.headers.get("x-complete") === "true" && Math.abs(max - last) < 1e-6 && max;
    }, "the time line");
    await page.id("timeline").fill(String(end));
    await until(async () => Math.abs((await page.value("q-1")) + 0.5) < 0.02, "the end of the recording");
    await until(async () => (await page.text("editor")).includes("half way"), "the program");
    await until(async () => (await page.text("variables")).includes("7"), "the variable");
    check((await page.id("standard_digital_out[2]").getAttribute("data-value")) === "1", "the output");
    await page.id("timeline").fill("0.3");
    await until(async () => (await page.id("running-line").innerText()).includes("movej([0.5"), "the line");
    await until(async () => Math.abs(Number(await page.text("time")) - 0.3) < 0.01, "the time");
    check((await page.id("standard_digital_out[2]").getAttribute("data-value")) === "0", "the output then");
  },
  async "a condition is looked for in a recording and jumped to"({ browser }) {
    const server = await Server.replay(await recorded());
    const page = await open(browser, server);
    await until(async () => Number(await page.id("timeline").getAttribute("max")) > 2, "the time line");
    await page.id("find").fill("actual_qd[0] < -0.9");
    await page.id("find").press("Enter");
    await until(async () => (await page.text("find-result")).startsWith("1 times"), "one stretch of time");
    await until(async () => (await page.id("running-line").innerText()).includes("movej([-0.5"), "the line there");
    const body = JSON.stringify({ condition: "actual_qd[0] < -0.9" });
    const answer = await fetch(`${server.base}/api/v1/find`, {
      method: "POST",
      headers: { "content-type": "application/json" },
      body,
    });
    const there = (await answer.json()).stretches[0].from;
    await until(async () => Math.abs(Number(await page.text("time")) - there) < 0.01, "the time of the first one");
    await page.id("timeline").fill("0.1");
    await page.id("event-after").click();
    await until(async () => Math.abs(Number(await page.text("time")) - there) < 0.01, "the jump");
    await page.id("find").fill("no_such_name > 1");
    await page.id("find").press("Enter");
    await until(async () => (await page.text("find-result")).includes("no_such_name"), "what is wrong with it");
    check((await page.id("find").getAttribute("aria-invalid")) === "true", "the field says so");
    await page.id("find").fill("");
    await until(async () => (await page.text("find-result")) === "", "events again");
  },
  async "events of a recording are jumped to, and it is played"({ browser }) {
    const server = await Server.replay(await recorded());
    const page = await open(browser, server);
    await until(async () => Number(await page.id("timeline").getAttribute("max")) > 2, "the time line");
    // Before the page knows that it is a recording, frames are taken as live ones.
    await until(async () => (await page.text("time")) === "0.004", "the beginning");
    let at = 0.004;
    // Two at least, so that there is one to go back to.
    for (let clicks = 0; clicks < 40 && (at <= 0.5 || clicks < 2); clicks += 1) {
      await page.id("event-after").click();
      // What is shown follows the click a little later; the next click goes on from where this one led.
      const before = at;
      at = await until(
        async () => Number(await page.text("time")) > before && Number(await page.text("time")),
        "the next event",
      );
    }
    check(at > 0.5, "no later event");
    await page.id("event-before").click();
    await until(async () => Number(await page.text("time")) < at, "an earlier event");
    const from = Number(await page.text("time"));
    await page.id("replay-play").click();
    await until(async () => Number(await page.text("time")) > from + 0.3, "time to pass");
  },
  async "the arm is drawn, moves, and the drawing rests when nothing does"({ drawing }) {
    const server = await Server.start();
    const page = await open(await drawing(), server);
    const drawn = () => page.evaluate(() => globalThis.eliteserver.drawn());
    await until(async () => (await drawn()) > 0, "the first drawing");
    await until(async () => {
      const before = await drawn();
      await sleep(300);
      return (await drawn()) === before;
    }, "the drawing to rest");
    const still = await drawn();
    await sleep(600);
    check((await drawn()) - still <= 2, "it draws though nothing moves");
    const before = await page.id("view-3d").screenshot();
    await server.run("def p():\n  movej([1.2, -1.2, 1.4, -1.77, -1.57, 0], a=2, v=1)\nend\n");
    await until(async () => (await drawn()) > still + 5, "drawings of the motion");
    check(!before.equals(await page.id("view-3d").screenshot()), "the picture is the same");
  },
  async "without WebGL everything else works"({ browser }) {
    const server = await Server.start();
    const page = await open(browser, server);
    // The view comes after the first frame, and so does word of what it lacks.
    await until(() => page.locator("#no-webgl").isVisible(), "the notice");
    await take(page);
    check(await page.id("jog-j1-plus").isEnabled(), "jog");
  },
};
