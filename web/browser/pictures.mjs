// Makes the pictures of docs/pendant.md: `node browser/pictures.mjs FOLDER [NAME]`.
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { BINARY, Server, edit, launch, open, sleep, take, until } from "./harness.mjs";

const out = process.argv[2];
if (!out) {
  console.error("usage: node browser/pictures.mjs FOLDER [NAME]");
  process.exit(2);
}
const wanted = process.argv[3] ?? "";
mkdirSync(out, { recursive: true });
const here = path.dirname(new URL(import.meta.url).pathname);
const browser = await launch();

/** Picks parts from a tray and puts them on a table: what most pictures show. */
const PICK = `def palletise():
  def above(at):
    return [at[0], at[1], at[2] + 0.16, at[3], at[4], at[5]]
  end
  def fetch(at, closed):
    movej(get_inverse_kin(above(at)), a=3, v=1.6)
    movel(at, a=1.2, v=0.25)
    set_standard_digital_out(0, closed)
    sleep(0.2)
    movel(above(at), a=1.2, v=0.25)
  end
  global placed
  placed = 0
  $ LINE: (1, "Above the tray")
  movej([0, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=2, v=1.5)
  while True:
    $ LINE: (2, "Pick")
    fetch([-0.45, -0.35, 0.16, 3.1416, 0, 0], True)
    $ LINE: (3, "Place")
    fetch([-0.35, 0.38, 0.14, 3.1416, 0, 0], False)
    placed = placed + 1
    textmsg("parts placed: ", placed)
  end
end
`;
/** Around the place of a post, and then through it. */
const THROUGH = `def around():
  movej([0.8, -1.4, 1.4, -1.57, -1.57, 0], a=2, v=1)
  movel(pose_add(get_target_tcp_pose(), [0, 0, -0.2, 0, 0, 0]), a=1, v=0.3)
  movej([0.5, -1.9, 1.9, -1.57, -1.57, 0], a=2, v=1)
  movej([-0.9, -1.5, 1.6, -1.67, -1.57, 0], a=2, v=1)
end
`;
/** Comes down too far. */
const LOWER = `def lower():
  movej([0, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=2, v=1.5)
  movej(get_inverse_kin([-0.4, 0.3, 0.3, 3.1416, 0, 0]), a=2, v=1.5)
  while True:
    speedl([0, 0, -0.15, 0, 0, 0], 1, 0.1)
  end
end
`;
const LINES = PICK.split("\n");
const lineOf = (text) => LINES.findIndex((line) => line.includes(text)) + 1;

async function shot(page, name) {
  await page.mouse.move(640, 5);
  await sleep(400);
  await page.screenshot({ path: path.join(out, `${name}.png`) });
  console.log(name);
}
const panel = (page, id) =>
  page.evaluate((name) => document.getElementById(name).scrollIntoView({ block: "start" }), id);
/** What was made in a folder of tests is not in pictures. */
const views = {
  async running(server) {
    const page = await open(browser, server, { colorScheme: "dark" });
    await take(page);
    await page.id("program-name").fill("palletise.script");
    await edit(page, PICK);
    await page.id("run").click();
    await panel(page, "code");
    await page.id("plot-qd").click();
    await until(async () => (await page.text("variables")).includes("placed"), "the variable");
    await sleep(9000);
    await shot(page, "running");
    return page;
  },
  async light(server) {
    const page = await open(browser, server, { colorScheme: "light" });
    await take(page);
    await server.run(PICK, "palletise.script").catch(() => undefined);
    await sleep(3000);
    await shot(page, "light");
    return page;
  },
  /** The page in a cell with parts: a box cuts the light barrier, and another place for it has been typed. */
  async cell() {
    const server = await Server.start(["--cell", path.join(here, "../../examples/cells/palletising/cell.toml")]);
    const page = await open(browser, server, { colorScheme: "light" });
    await server.order({ do: "outputs", values: { "standard_digital_out[1]": true } });
    await until(async () => (await page.text("detector-box at the stop")) === "sees something", "the box at the stop");
    await take(page);
    await page.id("place-part").selectOption("box#1");
    await page.id("place-x").fill("-0.6");
    await page.id("place-y").fill("0.15");
    await panel(page, "ios");
    await sleep(500);
    await shot(page, "cell");
    await page.context().close();
    await server.end();
    return null;
  },
  async ghost(server) {
    const page = await open(browser, server, { colorScheme: "dark" });
    await take(page);
    await page.id("q-1").fill("1.1");
    await page.id("q-3").fill("0.9");
    await until(() => page.evaluate(() => document.getElementById("view").dataset.ghost === "true"), "the ghost");
    await sleep(600);
    await page.id("move-to").click();
    await shot(page, "ghost");
    return page;
  },
  /** What was driven, and a program that would run into a post: both sizes, colours and languages. */
  async paths() {
    const server = await Server.start(["--cell", path.join(here, "post.toml")]);
    let page;
    for (const [colorScheme, locale, viewport, name] of [
      ["dark", "en-US", { width: 1280, height: 720 }, "paths"],
      ["light", "zh-CN", { width: 1280, height: 720 }, "paths-light"],
      ["light", "en-US", { width: 820, height: 1180 }, "paths-tablet"],
      ["dark", "zh-CN", { width: 820, height: 1180 }, "paths-tablet-dark"],
    ]) {
      page = await open(browser, server, { colorScheme, locale, viewport });
      await take(page);
      await page.id("program-name").fill("around.script");
      await page.id("window").selectOption("60");
      await page.id("path-planned").click();
      await edit(page, THROUGH.replace(/-0\.9,.*/, "0.35, -1.9, 1.3, -0.97, -1.57, 0], a=2, v=1)"));
      await until(() => page.evaluate(() => globalThis.eliteserver.paths().planned > 5), "the first path");
      await page.id("run").click();
      await until(async () => (await server.state()).program_state !== "stopped", "the run");
      await until(async () => (await server.state()).program_state === "stopped", "its end");
      await edit(page, THROUGH);
      await until(async () => /post/.test(await page.text("path-place")), "the post");
      await panel(page, "code");
      await sleep(800);
      await shot(page, name);
      await page.context().close();
    }
    await server.end();
    return null;
  },
  async editor(server) {
    const page = await open(browser, server, { colorScheme: "light" });
    await take(page);
    await panel(page, "code");
    await edit(page, PICK);
    await page.id("editor").click();
    await page.keyboard.press("Control+End");
    await page.keyboard.type("moveJ(home)\nspeed_now = 3\nmov", { delay: 30 });
    await page.locator(".cm-tooltip-autocomplete li").first().waitFor();
    await sleep(1200);
    await shot(page, "editor");
    return page;
  },
  async call(server) {
    const page = await open(browser, server, { colorScheme: "dark" });
    await take(page);
    await panel(page, "code");
    await edit(page, "def p():\n  sync()\n  \nend\n");
    await page.id("editor").click();
    await page.keyboard.press("Control+End");
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("ArrowUp");
    await page.keyboard.type("  movel([0.4, 0, 0.3, 3.14, 0, 0], a=1.2, v=", { delay: 20 });
    await page.id("call").waitFor();
    await shot(page, "call");
    return page;
  },
  async debugger(server) {
    const page = await open(browser, server, { colorScheme: "dark" });
    await take(page);
    await page.id("program-name").fill("palletise.script");
    await edit(page, PICK);
    await panel(page, "code");
    await page
      .locator(`.cm-lineNumbers .cm-gutterElement`, { hasText: new RegExp(`^${lineOf("sleep(0.2)")}$`) })
      .scrollIntoViewIfNeeded();
    await breakpoint(page, lineOf("sleep(0.2)"));
    await page.id("run").click();
    await page.locator("[data-held]").waitFor();
    await until(async () => (await page.text("scopes")).includes("at"), "the variables");
    await panel(page, "code");
    await shot(page, "debugger");
    await page.id("stop").click();
    return page;
  },
  async io(server) {
    const page = await open(browser, server, { colorScheme: "light" });
    await take(page);
    await page.id("standard_digital_in[2]").click();
    await page.id("configurable_digital_in[1]").click();
    await panel(page, "ios");
    await shot(page, "io");
    return page;
  },
  async popup(server) {
    const page = await open(browser, server, { colorScheme: "dark" });
    await take(page);
    await server.order({ do: "stop" });
    await page.id("program-name").fill("gripper.script");
    await edit(page, "def p():\n  popup('Is the gripper empty?', 'Gripper', warning=True, blocking=True)\nend\n");
    await page.id("run").click();
    await page.id("popup").waitFor();
    await shot(page, "popup");
    await page.id("popup-ok").click();
    return page;
  },
  async alarm(server) {
    const page = await open(browser, server, { colorScheme: "dark" });
    await take(page);
    await page.id("program-name").fill("weld.script");
    await edit(
      page,
      "def weld():\n" +
        "  count = 3\n" +
        "  seam = [0.2, 0.4]\n" +
        "  textmsg('seam ', count)\n" +
        "  movel(seam[count], a=1.2, v=0.25)\n" +
        "end\n",
    );
    await page.id("run").click();
    await page.id("alarm").waitFor();
    await panel(page, "code");
    await shot(page, "alarm");
    return page;
  },
  async tablet(server) {
    const page = await open(browser, server, {
      colorScheme: "light",
      viewport: { width: 820, height: 1180 },
      hasTouch: true,
    });
    await take(page);
    await shot(page, "tablet");
    return page;
  },
  async landscape(server) {
    const page = await open(browser, server, {
      colorScheme: "dark",
      viewport: { width: 1180, height: 820 },
      hasTouch: true,
      locale: "zh-CN",
    });
    await take(page);
    await shot(page, "landscape");
    return page;
  },
  /** A protective stop, and how it is left. */
  async stop(server) {
    const page = await open(browser, server, { colorScheme: "dark" });
    await take(page);
    await page.id("program-name").fill("lower.script");
    await edit(page, LOWER);
    await panel(page, "code");
    await page.id("run").click();
    await page.id("alarm-unlock").waitFor();
    await sleep(800);
    await shot(page, "stop");
    return page;
  },
  /** Points and units, with what is to be done first. */
  async first(server) {
    await server.order({ do: "power_off" });
    const page = await open(browser, server, { colorScheme: "light" });
    await page.evaluate(() => globalThis.localStorage.setItem("units", "practical"));
    await page.reload();
    await page.connected();
    await page.id("first-step-go").click();
    await until(async () => (await page.text("first-step-go")) === "Power on", "the next step");
    for (const name of ["above tray", "tray", "table"]) {
      await page.id("waypoint-save").click();
      await page.id("waypoint-name").last().fill(name);
    }
    await shot(page, "first");
    await page.evaluate(() => globalThis.localStorage.clear());
    return page;
  },
  /** Both sizes, colours and languages, in a stop: what every one of them has to have room for. */
  async sides(server) {
    let page;
    for (const viewport of [
      { width: 1280, height: 720 },
      { width: 820, height: 1180 },
    ]) {
      for (const colorScheme of ["dark", "light"]) {
        for (const locale of ["en-US", "zh-CN"]) {
          await page?.context().close();
          page = await open(browser, server, { colorScheme, viewport, locale });
          await take(page);
          if (await page.id("unlock").isEnabled()) await page.id("unlock").click();
          await until(async () => (await server.state()).safety_mode === "NORMAL", "no stop");
          await page.id("program-name").fill("lower.script");
          await edit(page, LOWER);
          await panel(page, "code");
          await until(() => page.id("run").isEnabled(), "run");
          await page.id("run").click();
          await page.id("alarm-unlock").waitFor();
          await sleep(1500);
          await shot(page, `stop-${viewport.width}-${colorScheme}-${locale.slice(0, 2)}`);
          await panel(page, "move");
          await sleep(300);
          await shot(page, `move-${viewport.width}-${colorScheme}-${locale.slice(0, 2)}`);
        }
      }
    }
    return page;
  },
  async recording() {
    // A recording names the files as they were given.
    const folder = mkdtempSync(path.join(tmpdir(), "page-"));
    writeFileSync(path.join(folder, "palletise.script"), PICK.replace("while True:", "while placed < 3:"));
    const recording = path.join(folder, "palletise.mcap");
    execFileSync(BINARY, ["run", "palletise.script", "--cell", path.join(here, "table.toml"), "--record", recording], {
      cwd: folder,
      stdio: "ignore",
    });
    const server = await Server.replay(recording);
    const page = await open(browser, server, { colorScheme: "light", locale: "zh-CN" });
    await until(async () => Number(await page.id("timeline").getAttribute("max")) > 10, "the time line");
    await sleep(2500);
    await page.id("find").fill("norm(actual_tcp_speed[0:3]) > 0.3");
    await page.id("find").press("Enter");
    await until(async () => /^\d/.test(await page.text("find-result")), "the places where it held");
    await page.id("plot-qd").click();
    await page.id("timeline").fill("9.3");
    await panel(page, "code");
    await sleep(1500);
    await shot(page, "recording");
    await page.context().close();
    await server.end();
    rmSync(folder, { recursive: true, force: true });
    return null;
  },
};

async function breakpoint(page, line) {
  const row = page.locator(".cm-lineNumbers .cm-gutterElement", { hasText: new RegExp(`^${line}$`) });
  await page.locator(".cm-breakpoints").waitFor();
  const [box, column] = [await row.boundingBox(), await page.locator(".cm-breakpoints").boundingBox()];
  await page.mouse.click(column.x + column.width / 2, box.y + box.height / 2);
  await until(async () => (await page.id("breakpoint").count()) > 0, "the breakpoint");
}

for (const [name, view] of Object.entries(views)) {
  if (!new RegExp(wanted).test(name)) continue;
  const server = ["recording", "cell", "paths"].includes(name)
    ? null
    : await Server.start(["--cell", path.join(here, "table.toml")]);
  try {
    const page = await view(server);
    for (const complaint of page?.complaints ?? []) console.log(`      ${name}: ${complaint}`);
    await page?.context().close();
  } catch (error) {
    console.log(`FAIL ${name}: ${error.message.split("\n")[0]}`);
  }
  await server?.end();
}
await browser.close();
