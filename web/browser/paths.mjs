// The paths of the TCP in the 3D view: what was driven, what the program in the editor would drive, and how near it
// comes to something.
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { attribute, BINARY, check, edit, mode, near, open, Server, sleep, stands, take, until } from "./harness.mjs";

const POST = path.join(path.dirname(new URL(import.meta.url).pathname), "post.toml");
const SCREENS = [
  { width: 1280, height: 720 },
  { width: 820, height: 1180 },
];
/** Away from the post, and through it. */
const BESIDE =
  "def p():\n" +
  "  movej([0.7, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n" +
  "  movej([0.3, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n" +
  "end\n";
const THROUGH = BESIDE.replace("0.3, -1.57", "-0.9, -1.57");

const figures = (page) => page.evaluate(() => globalThis.eliteserver.paths());
/** The answer of the server to a program that is written into the editor. */
async function planned(page, act) {
  const [answer] = await Promise.all([
    page.waitForResponse((response) => response.url().endsWith("/api/v1/path") && response.ok()),
    act(),
  ]);
  const found = await answer.json();
  await until(async () => (await page.id("path-note").isHidden()) || found.end !== "finished", "the page to have it");
  return found;
}
const last = (found) => found.pieces.at(-1).at(-1);

export const scenarios = {
  async "the path that was driven is drawn, hidden and remembered"({ drawing }) {
    const server = await Server.start();
    const page = await open(await drawing(), server);
    const drawn = async () => (await figures(page)).driven;
    await until(() => figures(page), "the view");
    check((await drawn()) === 0, "a path of an arm that stands");
    await page.id("window").selectOption("60");
    await server.run(BESIDE);
    await until(async () => (await drawn()) > 30, "the path");
    await stands(server);
    check((await attribute(page, "path-driven", "aria-pressed")) === "true", "the button");
    await page.id("path-driven").click();
    await until(async () => (await drawn()) === 0, "the path to go");
    await page.reload();
    await page.connected();
    await until(() => figures(page), "the view");
    await sleep(500);
    check(
      (await drawn()) === 0 && (await attribute(page, "path-driven", "aria-pressed")) === "false",
      "the choice is forgotten",
    );
    await page.id("path-driven").click();
    await page.id("window").selectOption("60");
    await until(async () => (await drawn()) > 30, "what was driven before the page was opened");
  },
  async "the planned path is drawn before anything moves, with what it runs into, at both sizes and in both languages"({
    drawing,
  }) {
    const server = await Server.start(["--cell", POST]);
    for (const viewport of SCREENS) {
      const page = await open(await drawing(), server, { viewport });
      await until(() => figures(page), "the view");
      await page.id("path-planned").click();
      await until(async () => (await page.text("path-note")).startsWith("No program"), "that there is none");
      const before = (await server.state()).actual_q;
      const beside = await planned(page, () => edit(page, BESIDE));
      await until(async () => (await figures(page)).planned > 5, "the path");
      check(
        beside.end === "finished" && beside.places.length === 1 && beside.places[0].distance > 0,
        JSON.stringify(beside.places),
      );
      await until(
        async () =>
          /^0\.\d{4} m from .* to post, line \d$|^Nothing is nearer than 0\.\d{4} m$/.test(
            await page.text("path-place"),
          ),
        "the distance, in words",
      );
      const through = await planned(page, () => edit(page, THROUGH));
      const { distance, a, b, line } = through.places[0];
      check(distance < 0 && b === "post" && line === 3, JSON.stringify(through.places));
      await until(async () => (await page.text("path-place")).includes("deep in post, line 3"), "the post");
      check(
        (await page.id("path-mark").first().innerText()).includes("deep in post") && (await figures(page)).marks > 0,
        "the text at its place",
      );
      await page.id("units").click();
      await until(
        async () => (await page.text("path-place")).includes(`${(-distance * 1000).toFixed(1)} mm deep`),
        "millimetres",
      );
      await page.id("units").click();
      await page.id("language").click();
      await until(async () => /^\S.* 进入 post 0\.\d{4} m, 第 3 行$/.test(await page.text("path-place")), "Chinese");
      check(!/[a-z]/i.test((await page.text("path-place")).replace("post", "").replace(" m", "")), `a mixture: ${a}`);
      check(
        (await page.text("path-planned")) === "规划路径" && (await page.text("path-driven")) === "实际路径",
        "the legend",
      );
      await page.id("language").click();
      // What is pressed is large enough, lies in the picture, and covers neither figures nor the other button.
      const boxes = await page.evaluate(() =>
        ["#view", "#facts", "#reset-view", "#path-driven", "#path-planned", "#path-place"].map((name) => {
          const { left, right, top, bottom } = document.querySelector(name).getBoundingClientRect();
          return { name, left, right, top, bottom };
        }),
      );
      const [view, ...things] = boxes;
      for (const [k, one] of things.entries()) {
        check(
          one.left >= view.left && one.right <= view.right && one.top >= view.top && one.bottom <= view.bottom,
          `${one.name} leaves the picture: ${JSON.stringify(boxes)}`,
        );
        if (one.name !== "#facts")
          check(
            one.bottom - one.top > 35.5 && one.right - one.left > 35.5,
            `${one.name} is small: ${JSON.stringify(one)}`,
          );
        for (const other of things.slice(k + 1))
          check(
            one.right <= other.left || other.right <= one.left || one.bottom <= other.top || other.bottom <= one.top,
            `${one.name} covers ${other.name}: ${JSON.stringify([one, other])}`,
          );
      }
      await page.id("path-place").click();
      await until(async () => (await page.locator(".cm-activeLine").innerText()).includes("-0.9"), "the line");
      const after = await server.state();
      check(
        after.actual_q.every((q, k) => Math.abs(q - before[k]) < 1e-4) && after.panel.program === 0,
        "looking at a path moves nothing",
      );
      await page.context().close();
    }
  },
  async "what is driven is what was planned"({ drawing }) {
    const server = await Server.start(["--cell", POST]);
    const page = await open(await drawing(), server);
    await take(page);
    await until(() => figures(page), "the view");
    await page.id("path-planned").click();
    const found = await planned(page, () => edit(page, BESIDE));
    const { actual_tcp_pose: start } = await server.state();
    for (let k = 0; k < 3; k++) near(found.pieces[0][0][k], start[k], 2e-3, "where the path begins");
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await mode(page, "program-state", "stopped");
    await stands(server);
    const { actual_tcp_pose: end } = await server.state();
    for (let k = 0; k < 3; k++) near(last(found)[k], end[k], 2e-3, "where the path ends");
    // It stays beside what was driven: the arm was moved by its program. A hand that moves it asks for another one.
    const frames = await page.evaluate(async () => [
      ...new Uint8Array(await (await fetch("/api/v1/history?points=4000")).arrayBuffer()),
    ]);
    const bytes = new DataView(Uint8Array.from(frames).buffer);
    const off = (x, y, z) =>
      Math.min(
        ...found.pieces.flatMap((piece) =>
          piece.slice(1).map((to, k) => {
            const from = piece[k];
            const line = to.map((value, n) => value - from[n]);
            const out = [x, y, z].map((value, n) => value - from[n]);
            const square = line.reduce((sum, value) => sum + value * value, 0);
            const part =
              square > 0
                ? Math.min(1, Math.max(0, line.reduce((sum, value, n) => sum + value * out[n], 0) / square))
                : 0;
            return Math.hypot(...out.map((value, n) => value - part * line[n]));
          }),
        ),
      );
    let most = 0;
    for (let at = 0; at < bytes.byteLength; at += 392)
      most = Math.max(most, off(...[0, 4, 8].map((n) => bytes.getFloat32(at + 264 + n, true))));
    check(most < 5e-3, `the arm was ${most} m beside the planned path`);
    check((await figures(page)).planned > 5, "the path is gone after the run");
    const again = await planned(page, async () => {
      await page.id("jog-j1-plus").hover();
      await page.mouse.down();
      await until(
        async () =>
          (await server.state()).actual_tcp_pose[1] < end[1] - 0.02 ||
          Math.abs((await server.state()).actual_q[0] - 0.35) < 0.03,
        "the jog",
      );
      await page.mouse.up();
    });
    check(
      Math.hypot(...again.pieces[0][0].map((value, k) => value - last(found)[k])) > 5e-3,
      "the path begins where the arm was",
    );
  },
  async "a path is planned as far as the program can be followed, and says so"({ drawing }) {
    const server = await Server.start();
    const page = await open(await drawing(), server);
    await until(() => figures(page), "the view");
    await page.id("path-planned").click();
    const note = (text) => until(async () => new RegExp(text).test(await page.text("path-note")), text);
    await edit(
      page,
      "def p():\n" +
        "  movej([0.7, -1.57, 1.57, -1.57, -1.57, 0])\n" +
        "  while not get_standard_digital_in(0):\n" +
        "    sync()\n" +
        "  end\n" +
        "end\n",
    );
    // A machine with much to do is at its bound before the program has stood still for long enough.
    await note("line [34], where the program waits|goes on; its path is planned for");
    check((await figures(page)).planned > 2, "the path up to there");
    await edit(page, "movej([0.7, -1.57, 1.57, -1.57, -1.57, 0])\n1 / 0\n");
    await note("Planned up to line 2, where the program fails");
    await edit(page, "movej([\n");
    await note("error in line 1");
    check((await figures(page)).planned === 0, "a path of a program that is none");
    // Nothing outside is reached: what a program sends or writes it does when it runs.
    await edit(
      page,
      "movej([0.7, -1.57, 1.57, -1.57, -1.57, 0])\n" +
        "open('written.txt', 'w').write('x')\n" +
        "movej([0.2, -1.57, 1.57, -1.57, -1.57, 0])\n",
    );
    await note("as far as the program runs; then it fails|line 2, where the program fails");
    await page.id("path-planned").click();
    check(await page.id("path-note").isHidden(), "a note about a path that is not shown");
  },
  async "who has no token is not told a path"({ browser }) {
    const server = await Server.start();
    const page = await open(browser, server);
    check(await page.id("paths").isHidden(), "a legend without the 3D view");
    const ask = (headers, body) =>
      fetch(`${server.base}/api/v1/path`, {
        method: "POST",
        headers: { "content-type": "application/json", ...headers },
        body: JSON.stringify(body),
      });
    check((await ask({}, { text: BESIDE })).status === 401, "no token");
    const answer = await ask({ authorization: `Bearer ${server.token}` }, { text: BESIDE, start: [9, 0, 0, 0, 0, 0] });
    check(answer.status === 422, `a start out of reach: ${answer.status}`);
    check(
      (await ask({ authorization: `Bearer ${server.token}` }, { text: BESIDE, begin: 1 })).status === 422,
      "an unknown field",
    );
  },
  async "a recording shows the path that was driven, and its targets"({ drawing }) {
    const folder = mkdtempSync(path.join(tmpdir(), "page-"));
    try {
      writeFileSync(path.join(folder, "r.script"), BESIDE);
      const ran = spawnSync(BINARY, ["run", "r.script", "--record", "r.mcap"], { cwd: folder, encoding: "utf8" });
      check(ran.status === 0, ran.stderr);
      const server = await Server.replay(path.join(folder, "r.mcap"));
      const page = await open(await drawing(), server);
      await until(async () => ((await figures(page))?.driven ?? 0) > 30, "the driven path");
      check((await figures(page)).planned === 0, "targets that nobody wanted");
      await page.id("path-planned").click();
      await until(async () => (await figures(page)).planned > 30, "the targets");
      check((await attribute(page, "path-planned", "title")) === "Target path of the recording", "what they are");
      check(await page.id("path-place").isHidden(), "distances of a recording");
      // A stretch that is zoomed to in the plot is the stretch of the path that is drawn.
      const whole = (await figures(page)).driven;
      const plot = await page.locator("#plot .u-over").boundingBox();
      await page.mouse.move(plot.x + plot.width * 0.3, plot.y + 20);
      await page.mouse.down();
      await page.mouse.move(plot.x + plot.width * 0.45, plot.y + 20, { steps: 5 });
      await page.mouse.up();
      await until(async () => (await figures(page)).driven !== whole, "the stretch");
    } finally {
      rmSync(folder, { recursive: true, force: true });
    }
  },
};
