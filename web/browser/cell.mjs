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

/** The outline of an L in the x-y plane, counterclockwise, in mm, from the corner at the origin. */
const L = [
  [0, 0],
  [400, 0],
  [400, 100],
  [100, 100],
  [100, 400],
  [0, 400],
];
/** Triangles of the same outline, as a fan from its inner corner. */
const FAN = [
  [3, 4, 5],
  [3, 5, 0],
  [3, 0, 1],
  [3, 1, 2],
];

/** An L of a height as STL text. */
function bracket(height) {
  const facet = (...corners) => {
    const vertices = corners.map((corner) => `vertex ${corner.join(" ")}`).join("\n");
    return `facet normal 0 0 0\nouter loop\n${vertices}\nendloop\nendfacet\n`;
  };
  const at = (k, z) => [...L[k % L.length], z];
  const caps = FAN.map(
    ([a, b, c]) => facet(at(a, height), at(b, height), at(c, height)) + facet(at(c, 0), at(b, 0), at(a, 0)),
  );
  const sides = L.map(
    (_, k) => facet(at(k, 0), at(k + 1, 0), at(k + 1, height)) + facet(at(k, 0), at(k + 1, height), at(k, height)),
  );
  return `solid bracket\n${caps.join("")}${sides.join("")}endsolid bracket\n`;
}

// The corners of the two large ones are open to the camera.
const MESHES = `
[[obstacle]]
name = "bracket"
shape = "mesh"
file = "bracket.stl"
scale = 0.001
pose = [0.15, 0.8, 0, 0, 0, -1.5707963267948966]

[tool]
shape = "mesh"
file = "bracket.stl"
scale = 0.0003
pose = [-0.015, -0.015, 0, 0, 0, 0]

[world]
floor = 0

[[part]]
name = "angle"
shape = "mesh"
file = "bracket.stl"
scale = 0.0005
mass = 1
pose = [-0.75, -0.25, 0, 0, 0, -1.5707963267948966]
color = "#c0392b"

[[gripper]]
name = "hand"
kind = "fingers"
stroke = 0.1
axis = [0, 1, 0]
force = 50
speed = 0.1
close = "standard_digital_out[0]"
[gripper.finger]
shape = "mesh"
file = "bracket.stl"
scale = 0.0001
pose = [0, 0.01, 0.06, 0, 0, 0]
`;

/** A cell with meshes in a folder of its own, and what is to be done with it. */
async function withMeshes(act) {
  const folder = mkdtempSync(path.join(tmpdir(), "page-"));
  try {
    writeFileSync(path.join(folder, "bracket.stl"), bracket(200));
    const cell = path.join(folder, "cell.toml");
    writeFileSync(cell, MESHES);
    await act(cell, folder);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

const shapes = (page, name) =>
  page.evaluate((wanted) => globalThis.eliteserver.shapes().filter((one) => one.name === wanted), name);
/** Waits for what is drawn of a thing, and gives it once its mesh is there. */
const drawnShapes = (page, name, count) =>
  until(async () => {
    const rows = await shapes(page, name);
    return rows.length === count && rows.every((row) => row.triangles === 20) && rows;
  }, `the mesh of ${name}`);

/** Colours of points of the base frame in the picture, each of 0 to 255. */
async function colors(page, points) {
  // Names lie over the picture.
  const places = await page.evaluate((all) => {
    for (const id of ["labels", "paths", "facts", "notices"]) document.getElementById(id).style.visibility = "hidden";
    return all.map((point) => globalThis.eliteserver.pixelAt(point));
  }, points);
  const picture = (await page.screenshot()).toString("base64");
  return page.evaluate(
    async ([text, at]) => {
      const bytes = Uint8Array.from(globalThis.atob(text), (one) => one.charCodeAt(0));
      const image = await globalThis.createImageBitmap(new globalThis.Blob([bytes], { type: "image/png" }));
      const canvas = new globalThis.OffscreenCanvas(image.width, image.height).getContext("2d");
      canvas.drawImage(image, 0, 0);
      return at.map(([x, y]) => [...canvas.getImageData(Math.round(x), Math.round(y), 1, 1).data].slice(0, 3));
    },
    [picture, places],
  );
}

/** Where PICTURES names a folder, what the scenario has seen is kept there. */
async function keepPicture(page, name) {
  if (process.env.PICTURES) await page.screenshot({ path: path.join(process.env.PICTURES, `${name}.png`) });
}

/** Own servers, with the 3D view or without. */
export const scenarios = {
  async "meshes of obstacle, tool, part and fingers are drawn where they are"({ drawing }) {
    await withMeshes(async (cell) => {
      const server = await Server.start(["--cell", cell]);
      for (const [name, width, height] of [
        ["wide", 1280, 720],
        ["tablet", 1024, 768],
      ]) {
        const page = await open(await drawing(), server, { viewport: { width, height } });
        const [standing] = await drawnShapes(page, "bracket", 1);
        [
          [0.15, 0.55],
          [0.4, 0.8],
          [0, 0.2],
        ].forEach(([low, high], axis) => {
          near(standing.low[axis], low, 1e-5, `low end ${axis} of the bracket`);
          near(standing.high[axis], high, 1e-5, `high end ${axis} of the bracket`);
        });
        await drawnShapes(page, "tool", 1);
        const [part] = await drawnShapes(page, "angle", 1);
        near(part.high[0] - part.low[0], 0.2, 1e-3, "length of the part");
        const fingers = await drawnShapes(page, "hand", 2);
        check(fingers.filter((one) => one.isMirrored).length === 1, "one finger is the mirror image");
        // Each mesh once, whatever has it, and none of what is not there.
        const asked = page.requests.filter((url) => url.includes("/meshes/")).map((url) => url.split("/").pop());
        check(asked.length === 4 && new Set(asked).size === 4, `asked for ${asked}`);
        await keepPicture(page, `meshes-${name}`);
        await page.mouse.move(
          ...(await page.evaluate(
            ([low, high]) => globalThis.eliteserver.pixelAt([low[0] + 0.02, low[1] + 0.02, high[2]]),
            [part.low, part.high],
          )),
        );
        await until(async () => (await page.text("view-name")) === "angle", "the name of the part under the pointer");
        await page.mouse.move(
          ...(await page.evaluate(
            ([low, high]) => globalThis.eliteserver.pixelAt([high[0] - 0.02, low[1] + 0.02, low[2]]),
            [part.low, part.high],
          )),
        );
        await until(async () => (await page.id("view-name").count()) === 0, "no name within the corner of the L");
        const [leg, other, notch, red] = await colors(page, [
          [0.45, 0.75, 0.2],
          [0.2, 0.5, 0.2],
          [0.45, 0.5, 0],
          [part.low[0] + 0.02, part.low[1] + 0.1, part.high[2]],
        ]);
        // Both legs of the L have one colour, that of sand: less blue than red. Ground is seen in its corner.
        check(
          leg[0] - leg[2] > 20 && Math.max(...leg.map((x, k) => Math.abs(x - other[k]))) < 12,
          `legs ${leg} ${other}`,
        );
        check(Math.max(...leg.map((x, k) => Math.abs(x - notch[k]))) > 30, `the corner of the L is filled: ${notch}`);
        check(red[0] - red[2] > 60 && red[0] - red[1] > 60, `the part is not red: ${red}`);
      }
    });
  },
  async "a mesh that does not come is named in both languages"({ drawing }) {
    await withMeshes(async (cell) => {
      const server = await Server.start(["--cell", cell]);
      const context = await (await drawing()).newContext({ viewport: { width: 1280, height: 720 }, locale: "en-US" });
      await context.route("**/api/v1/meshes/*", (route) => {
        const number = Number(route.request().url().split("/").pop());
        if (number === 0) return route.fulfill({ status: 404, body: "{}" });
        return number === 1 ? route.fulfill({ body: "\0".repeat(9) }) : route.continue();
      });
      const page = await context.newPage();
      try {
        await page.goto(server.base);
        const note = page.getByTestId("mesh-missing");
        await until(
          async () =>
            (await note.innerText()).includes("bracket: not drawn. The server refused to send the mesh (status 404)."),
          "the refusal",
        );
        await until(
          async () =>
            (await note.innerText()).includes("tool: not drawn. The mesh has 9 bytes; by its counts it would have 8."),
          "the cut mesh",
        );
        await drawnShapes(page, "angle", 1);
        await keepPicture(page, "meshes-missing");
        await page.getByTestId("language").click();
        await until(
          async () => (await note.innerText()).includes("bracket：未绘制。服务器拒绝发送网格（状态 404）。"),
          "Chinese",
        );
        check((await note.innerText()).includes("工具：未绘制。"), "the tool in Chinese");
      } finally {
        await context.close();
      }
    });
  },
  async "meshes of a recording are drawn, and of a scene that is shown again"({ drawing }) {
    await withMeshes(async (cell, folder) => {
      const program = path.join(folder, "wait.script");
      writeFileSync(program, "def p():\n  sleep(0.5)\nend\n");
      const file = path.join(folder, "wait.mcap");
      const ran = spawnSync(BINARY, ["run", program, "--cell", cell, "--record", file], { encoding: "utf8" });
      check(ran.status === 0, ran.stderr);
      rmSync(path.join(folder, "bracket.stl"));
      const page = await open(await drawing(), await Server.replay(file));
      await drawnShapes(page, "bracket", 1);
      await drawnShapes(page, "tool", 1);
      const asked = page.requests.length;
      await page.id("theme").click();
      await drawnShapes(page, "bracket", 1);
      check(
        !page.requests.slice(asked).some((url) => url.includes("/meshes/")),
        "other colours ask for the meshes again",
      );
    });
  },
  async "parts, belt, beam and cups of a cell are drawn and named"({ drawing }) {
    const server = await Server.start(["--cell", cellOf("palletising")]);
    const page = await open(await drawing(), server);
    const before = await until(() => figures(page), "the cell");
    check(before.running.belt === false && before.lit["box at the stop"] === false, JSON.stringify(before));
    check(
      before.sealed.cups.length === 2 && before.sealed.cups.every((sealed) => !sealed),
      "two cups that seal nothing",
    );
    check(
      (await page.text("conveyor-belt")) === "stands still" &&
        (await page.text("gripper-cups")).startsWith("holds nothing"),
      "the panel",
    );
    await outputs(server, { "standard_digital_out[1]": true });
    await until(async () => (await figures(page)).running.belt, "the belt to run");
    await until(async () => (await page.text("conveyor-belt")) === "0.200 m/s", "its speed");
    const first = await until(async () => (await figures(page)).parts["box#1"], "a box of the source");
    await until(
      async () => ((await figures(page)).parts["box#1"] ?? [])[7] > first[7] + 0.05,
      "the box to move along y",
    );
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
    await until(
      async () => (await page.locator(".toast").allInnerTexts()).join().includes("raw[2] was placed"),
      "the notice",
    );
    // It falls onto the tray again, turned.
    await until(
      async () => Math.abs((await page.value("place-rz")) - Math.PI / 4) < 0.05 && (await page.value("place-z")) < 0.15,
      "the part to lie there",
    );
    // Nothing may be placed under a program.
    await page.id("editor").fill(MOVES);
    await page.id("run").click();
    await until(
      async () => (await page.id("place").isDisabled()) && (await page.id("place-x").isDisabled()),
      "no placing while a program runs",
    );
    await page.id("take-control").click();
    const order = { do: "place_part", part: "raw[2]", pose: [0, 0, 1, 0, 0, 0] };
    const refused = await until(async () => {
      const answer = await server.order(order);
      return answer.error?.includes("a program runs") && answer;
    }, "the refusal");
    check(refused.status === 409 && refused.texts.zh.includes("程序正在运行"), JSON.stringify(refused));
    await server.order({ do: "stop" });
    await until(
      async () => (await server.order({ ...order, part: "nobody" })).error === 'there is no part "nobody"',
      "the refusal of a name",
    );
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
    check(
      Math.hypot(dragged[0] - before[0], dragged[1] - before[1]) > 0.03,
      `it was not dragged: ${before} ${dragged}`,
    );
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
      const ran = spawnSync(BINARY, ["run", program, "--cell", cellOf("palletising"), "--record", file], {
        encoding: "utf8",
      });
      check(ran.status === 0, ran.stderr);
      const server = await Server.replay(file);
      const page = await open(browser, server);
      await until(
        async () =>
          (await (await fetch(`${server.base}/api/v1/history?points=1`)).headers.get("x-complete")) === "true",
        "the time line",
      );
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
