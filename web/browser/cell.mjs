// The cell that lives: drawn, told in the panel, looked at in a recording, and a part placed by hand.
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { BINARY, MOVES, Server, check, near, open, take, until } from "./harness.mjs";

const examples = path.join(path.dirname(new URL(import.meta.url).pathname), "../../examples/cells");
const cellOf = (name) => path.join(examples, name, "cell.toml");
const figures = (page) => page.evaluate(() => globalThis.eliteserver.cell());
const outputs = async (server, values) => {
  const answer = await server.order({ do: "outputs", values });
  check(answer.ok, `outputs: ${answer.error}`);
};
/** The numbers in the fields of the part that is chosen. */
const pose = async (page) => Promise.all(["x", "y", "z", "rx", "ry", "rz"].map((axis) => page.value(`place-${axis}`)));

/** Own servers, with the 3D view or without. */
export const scenarios = {
  async "parts, belt, beam and cups of a cell are drawn and named"({ drawing }) {
    const server = await Server.start(["--cell", cellOf("palletising")]);
    const page = await open(await drawing(), server);
    const before = await until(() => figures(page), "the cell");
    check(before.running.belt === false && before.lit["box at the stop"] === false, JSON.stringify(before));
    check(before.sealed.cups.length === 2 && before.sealed.cups.every((sealed) => !sealed), "two cups that seal nothing");
    check((await page.text("conveyor-belt")) === "stands still" && (await page.text("gripper-cups")).startsWith("holds nothing"), "the panel");
    await outputs(server, { "standard_digital_out[1]": true });
    await until(async () => (await figures(page)).running.belt, "the belt to run");
    await until(async () => (await page.text("conveyor-belt")) === "0.200 m/s", "its speed");
    const first = await until(async () => (await figures(page)).parts["box#1"], "a box of the source");
    await until(async () => ((await figures(page)).parts["box#1"] ?? [])[7] > first[7] + 0.05, "the box to move along y");
    await until(async () => (await figures(page)).lit["box at the stop"], "the beam to be cut");
    await until(async () => (await page.text("detector-box at the stop")) === "sees something", "the panel to say so");
    await outputs(server, { "standard_digital_out[1]": false });
    await until(async () => (await page.text("conveyor-belt")) === "stands still", "the belt to stand");
    const [x, y] = await page.evaluate(() => globalThis.eliteserver.pixelOf("box#1"));
    await page.mouse.move(x, y);
    await until(async () => (await page.text("view-name")) === "box#1", "its name under the pointer");
    await page.mouse.move(x, 5);
    await until(async () => (await page.id("view-name").count()) === 0, "the name to go");
  },
  async "obstacles go along with their actuators, and fingers close"({ drawing }) {
    const server = await Server.start(["--cell", cellOf("tending")]);
    const page = await open(await drawing(), server);
    const label = () => page.locator("#labels .label", { hasText: "door" }).first().boundingBox();
    const { width } = await until(() => figures(page), "the cell");
    near(width.fingers, 0.06, 1e-3, "open fingers");
    const before = await until(label, "the name of the door");
    await outputs(server, { "standard_digital_out[1]": true, "standard_digital_out[3]": true });
    await until(async () => Math.abs((await label()).x - before.x) > 20, "the door to move");
    await until(async () => (await figures(page)).width.fingers < 1e-3, "the fingers to close");
    await until(async () => (await page.text("gripper-fingers")).includes("0.0000 m"), "the panel to say so");
  },
  async "a part is placed by hand: typed"({ browser }) {
    const server = await Server.start(["--cell", cellOf("tending")]);
    const page = await open(browser, server);
    await page.id("place-part").selectOption("raw[2]");
    await until(async () => Math.abs((await page.value("place-x")) + 0.41) < 1e-3, "where it is");
    check(await page.id("place").isDisabled(), "it may be placed without control");
    await take(page);
    await page.id("place-z").fill("high");
    check(await page.id("place").isDisabled(), "a word is taken for a number");
    await page.id("place-z").fill("0.2");
    await page.id("place-rz").fill("45°");
    await page.id("place").click();
    await until(async () => (await page.locator(".toast").allInnerTexts()).join().includes("raw[2] was placed"), "the notice");
    // It falls onto the tray again, turned.
    await until(async () => Math.abs((await page.value("place-rz")) - Math.PI / 4) < 0.05 && (await page.value("place-z")) < 0.15, "the part to lie there");
    // Nothing may be placed under a program.
    await page.id("editor").fill(MOVES);
    await page.id("run").click();
    await until(async () => (await page.id("place").isDisabled()) && (await page.id("place-x").isDisabled()), "no placing while a program runs");
    await page.id("take-control").click();
    const order = { do: "place_part", part: "raw[2]", pose: [0, 0, 1, 0, 0, 0] };
    const refused = await until(async () => {
      const answer = await server.order(order);
      return answer.error?.includes("a program runs") && answer;
    }, "the refusal");
    check(refused.status === 409 && refused.texts.zh.includes("程序正在运行"), JSON.stringify(refused));
    await server.order({ do: "stop" });
    await until(async () => (await server.order({ ...order, part: "nobody" })).error === 'there is no part "nobody"', "the refusal of a name");
  },
  async "a part is placed by hand: clicked and dragged"({ drawing }) {
    const server = await Server.start(["--cell", cellOf("tending")]);
    const page = await open(await drawing(), server);
    await until(() => figures(page), "the cell");
    await take(page);
    const [x, y] = await page.evaluate(() => globalThis.eliteserver.pixelOf("raw[3]"));
    await page.mouse.click(x, y);
    await until(async () => (await page.id("place-part").inputValue()) === "raw[3]", "the part to be chosen");
    const before = await pose(page);
    await until(() => page.id("place-x").isEnabled(), "the fields");
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y, { steps: 5 });
    await page.mouse.up();
    const dragged = await pose(page);
    check(Math.hypot(dragged[0] - before[0], dragged[1] - before[1]) > 0.03, `it was not dragged: ${before} ${dragged}`);
    near(dragged[2], before[2], 1e-4, "the height");
    check((await figures(page)).ghost === "raw[3]", "the ghost");
    await page.id("place").click();
    await until(async () => {
      const [, , , px, , , , py] = (await figures(page)).parts["raw[3]"];
      return Math.hypot(px - dragged[0], py - dragged[1]) < 0.01;
    }, "the part to be there");
    check((await figures(page)).ghost === null, "the ghost stays");
  },
  async "the cell of a recording goes back in time, in both languages"({ browser }) {
    const folder = mkdtempSync(path.join(tmpdir(), "page-"));
    try {
      const program = path.join(folder, "belt.script");
      writeFileSync(program, "def p():\n  sleep(1)\n  set_standard_digital_out(1, True)\n  sleep(6)\nend\n");
      const file = path.join(folder, "belt.mcap");
      const ran = spawnSync(BINARY, ["run", program, "--cell", cellOf("palletising"), "--record", file], { encoding: "utf8" });
      check(ran.status === 0, ran.stderr);
      const server = await Server.replay(file);
      const page = await open(browser, server);
      await until(async () => (await (await fetch(`${server.base}/api/v1/history?points=1`)).headers.get("x-complete")) === "true", "the time line");
      const at = async (time, look, what) => {
        await page.id("timeline").fill(String(time));
        await until(look, what);
      };
      const says = (id, text) => async () => (await page.text(id)) === text;
      await until(async () => Number(await page.id("timeline").getAttribute("max")) > 6, "its end");
      await at(6.5, says("detector-box at the stop", "sees something"), "the box at the end");
      await at(2.5, says("conveyor-belt", "0.200 m/s"), "the running belt");
      await until(says("detector-box at the stop", "free"), "no box yet");
      await at(0.5, says("conveyor-belt", "stands still"), "the belt before");
      check(await page.id("place-form").isHidden(), "a part of a recording may be placed");
      await page.id("language").click();
      await until(says("conveyor-belt", "静止"), "Chinese");
      await until(says("gripper-cups", "未夹持"), "Chinese cups");
    } finally {
      rmSync(folder, { recursive: true, force: true });
    }
  },
};
