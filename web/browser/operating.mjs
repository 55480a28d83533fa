// For the people in front of it: nothing moves under a hand, what can be done now is lit, numbers and names are theirs.
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { execFile } from "node:child_process";
import { tmpdir } from "node:os";
import path from "node:path";
import { promisify } from "node:util";
import {
  attribute,
  BINARY,
  check,
  edit,
  hold,
  mode,
  MOVES,
  near,
  open,
  Server,
  sleep,
  stands,
  take,
  until,
} from "./harness.mjs";

/** The two sizes that are promised, and the tablet the other way. */
const SCREENS = [
  { width: 1280, height: 720 },
  { width: 820, height: 1180 },
  { width: 1180, height: 820 },
];
const FENCE = path.join(path.dirname(new URL(import.meta.url).pathname), "fence.toml");
/** Runs into the table. */
const CRASH =
  "def p():\n" +
  "  movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n" +
  "  while True:\n" +
  "    speedl([0, 0, -0.2, 0, 0, 0], 1, 0.1)\n" +
  "  end\n" +
  "end\n";

const box = (page, name) => page.id(name).first().boundingBox();
/** Where something is painted: a box that is asked for between a change and its frame is one that nobody sees. */
const painted = (page, name) =>
  page
    .id(name)
    .first()
    .evaluate(
      (element) =>
        new Promise((done) => {
          const observer = new globalThis.IntersectionObserver(([entry]) => {
            observer.disconnect();
            const { x, y, width, height } = entry.boundingClientRect;
            done({ x, y, width, height });
          });
          observer.observe(element);
        }),
    );
const same = (a, b) => ["x", "y", "width", "height"].every((side) => Math.abs(a[side] - b[side]) < 0.6);
const lights = (page, name) => page.id(name).evaluate((element) => getComputedStyle(element).color);
/** What moves the arm by hand. */
const BY_HAND = ["jog-j1-plus", "jog-x-minus", "freedrive", "move-to", "home"];
/** The things that a hand is at. */
const HANDLES = ["stop", "run", "pause", "take-control", "power-off"];
async function places(page) {
  const found = {};
  for (const name of HANDLES) found[name] = await box(page, name);
  found.tabs = await page.locator("#tabs").boundingBox();
  return found;
}
/** Every size in both languages; the page is brought to each by `look`. */
async function sides(page) {
  return SCREENS.flatMap((viewport) =>
    ["en", "zh-CN"].map((language) => ({
      name: `${viewport.width}×${viewport.height}, ${language}`,
      async look() {
        await page.setViewportSize(viewport);
        if ((await page.evaluate(() => document.documentElement.lang)) !== language) await page.id("language").click();
        await page.evaluate(
          () => new Promise((done) => globalThis.requestAnimationFrame(() => globalThis.requestAnimationFrame(done))),
        );
      },
    })),
  );
}
const tab = (page, id) => page.locator(`#tabs a[href="#${id}"]`).click();

export const scenarios = {
  async "while a program runs the panel stays where somebody has put it"({ page, server }) {
    await take(page);
    // Longer than the editor, so that its text has to be scrolled; and a variable that comes and grows.
    const body = Array.from({ length: 80 }, (_, k) => `    sleep(0.02${k})\n    n = "x" * ${k}\n`).join("");
    await edit(page, `def p():\n  global n\n  while True:\n${body}  end\nend\n`);
    await page.id("run").click();
    await mode(page, "program-state", "running");
    for (const [id, name] of [
      ["logs", "log"],
      ["ios", "io"],
      ["move", "move-to"],
    ]) {
      await tab(page, id);
      // The panel comes to rest first. Less than a pixel is no motion: lines are no whole pixels high, scroll positions
      // are.
      let place = NaN;
      await until(async () => {
        const was = place;
        place = (await painted(page, name)).y;
        await sleep(200);
        return Math.abs(place - was) < 1;
      }, `${name} at rest`);
      const before = await painted(page, name);
      // What is out of sight draws no line: the controller says where the program is.
      const { line } = (await server.state()).panel;
      await until(async () => (await server.state()).panel.line !== line, "another line");
      // The text of `n` goes through all its lengths meanwhile.
      await sleep(2600);
      const after = await painted(page, name);
      near(after.y, before.y, 1, `the place of ${name}`);
      check((await page.locator(`#tabs a[href="#${id}"]`).getAttribute("aria-current")) === "true", `${id} is left`);
    }
    // The text itself goes along with the program.
    await tab(page, "code");
    await until(
      async () =>
        page.evaluate(() => {
          const [line, editor] = [
            document.querySelector("[data-testid=running-line]"),
            document.querySelector(".cm-scroller"),
          ];
          const [a, b] = [line?.getBoundingClientRect(), editor.getBoundingClientRect()];
          return a && a.top >= b.top - 1 && a.bottom <= b.bottom + 1;
        }),
      "the running line to be seen",
    );
    await server.order({ do: "stop" });
  },
  async "an alarm moves nothing that a hand is at, in both languages and sizes"({ page }) {
    await take(page);
    await edit(
      page,
      "def p():\n" +
        "  sync()\n" +
        "  raise ValueError('a long reason, which is told with all its words, " +
        "so that the alarm needs several lines ' * 3)\n" +
        "end\n",
    );
    for (const where of await sides(page)) {
      await where.look();
      await until(() => page.id("run").isEnabled(), "run");
      const before = await places(page);
      await page.id("run").click();
      await page.id("alarm").waitFor();
      await mode(page, "program-state", "stopped");
      const after = await places(page);
      for (const [name, place] of Object.entries(before))
        check(same(place, after[name]), `${name} moves, ${where.name}: ${JSON.stringify([place, after[name]])}`);
      // Nor does it lie over them.
      const alarm = await box(page, "alarm");
      for (const [name, place] of Object.entries(after)) {
        const apart =
          alarm.x >= place.x + place.width ||
          place.x >= alarm.x + alarm.width ||
          alarm.y >= place.y + place.height ||
          place.y >= alarm.y + alarm.height;
        check(apart, `the alarm covers ${name}, ${where.name}`);
      }
      await page.id("alarm-dismiss").click();
    }
  },
  async "the header is one row, whatever it says"({ page, server }) {
    const look = async (what) => {
      for (const where of await sides(page)) {
        await where.look();
        const found = await page.evaluate(() => {
          const header = document.querySelector("header");
          const outer = header.getBoundingClientRect();
          const shown = [...header.querySelectorAll("button, .chip")].filter(
            (one) => getComputedStyle(one).visibility === "visible",
          );
          const out = shown.filter((one) => {
            const inner = one.getBoundingClientRect();
            return (
              inner.top < outer.top - 0.5 ||
              inner.bottom > outer.bottom + 0.5 ||
              inner.right > outer.right + 0.5 ||
              inner.left < outer.left - 0.5
            );
          });
          const safety = document.querySelector("[data-testid=safety-mode]");
          return {
            height: outer.height,
            out: out.map((one) => one.textContent),
            isCut: safety.scrollWidth > safety.clientWidth + 1,
          };
        });
        check(found.height <= 52, `the header is ${found.height} px high: ${what}, ${where.name}`);
        check(found.out.length === 0, `out of the header: ${found.out.join()}: ${what}, ${where.name}`);
        check(!found.isCut, `the safety mode is cut: ${what}, ${where.name}`);
      }
    };
    await take(page);
    await look("running");
    await edit(page, CRASH);
    await page.id("run").click();
    await mode(page, "safety-mode", "PROTECTIVE_STOP");
    await look("in a protective stop");
    await server.order({ do: "stop" });
  },
  async "a protective stop is left from its alarm, and its line is marked"({ page, server }) {
    await take(page);
    await edit(page, CRASH);
    check((await lights(page, "robot-mode")) === (await lights(page, "safety-mode")), "both are green at first");
    await page.id("run").click();
    await mode(page, "safety-mode", "PROTECTIVE_STOP");
    await page.id("alarm-unlock").waitFor();
    const text = await page.text("alarm");
    check(text.includes("line 4") && text.includes("untitled.script"), text);
    await until(async () => (await page.id("alarm-line").innerText()).includes("speedl"), "the mark of the line");
    check((await page.text("safety-mode")) === "PROTECTIVE STOP", await page.text("safety-mode"));
    const green = await page.evaluate(() => getComputedStyle(document.documentElement).getPropertyValue("--good"));
    const colors = await page.evaluate((value) => {
      const probe = document.createElement("b");
      probe.style.color = value;
      document.body.append(probe);
      const wanted = getComputedStyle(probe).color;
      probe.remove();
      return [...document.querySelectorAll("header b")]
        .filter((one) => one.dataset.testid !== "connection" && getComputedStyle(one).color === wanted)
        .map((one) => one.textContent);
    }, green);
    check(colors.length === 0, `green in a stop: ${colors.join()}`);
    await page.id("language").click();
    check((await page.text("safety-mode")) === "保护性停止", await page.text("safety-mode"));
    await page.id("language").click();
    for (const name of ["run", "play", "step"]) check(await page.id(name).isDisabled(), `${name} in a stop`);
    // Go to line leads to the program from wherever the panel is.
    await tab(page, "logs");
    await page.id("alarm-go").click();
    await until(async () => (await page.locator(".cm-activeLine").innerText()).includes("speedl"), "the line");
    await page.id("alarm-unlock").click();
    await mode(page, "safety-mode", "NORMAL");
    await until(() => page.id("alarm").isHidden(), "the alarm to go");
    await until(async () => (await page.id("alarm-line").count()) === 0, "the mark to go");
    check(await page.id("run").isEnabled(), "run");
    check((await server.state()).safety_mode === "NORMAL", "the stop");
  },
  async "whoever opens the page during a stop is told why"({ page, server, browser }) {
    await server.run(CRASH);
    await mode(page, "safety-mode", "PROTECTIVE_STOP");
    const late = await open(browser, server);
    await until(async () => (await late.text("alarm")).includes("protective stop"), "the alarm");
    check((await late.text("alarm")).includes("line 4"), "its place");
    await late.close();
  },
  async "what cannot be done now is not lit"({ page }) {
    await take(page);
    for (const name of ["run", "play", "step"]) check(await page.id(name).isDisabled(), `${name} without a program`);
    await edit(page, MOVES);
    for (const name of ["run", "play", "step"]) await until(() => page.id(name).isEnabled(), name);
    check(
      (await page.id("brake-release").isDisabled()) &&
        (await page.id("power-on").isDisabled()) &&
        (await page.id("unlock").isDisabled()),
      "what is done already",
    );
    await page.id("power-off").click();
    await mode(page, "robot-mode", "POWER_OFF");
    for (const name of ["run", "play", "step", ...BY_HAND])
      await until(() => page.id(name).isDisabled(), `${name} without power to be off`);
    await page.id("power-on").click();
    await mode(page, "robot-mode", "IDLE");
    for (const name of ["run", "play", "step", ...BY_HAND])
      check(await page.id(name).isDisabled(), `${name} with engaged brakes`);
    await page.id("brake-release").click();
    for (const name of ["run", "play", "step", ...BY_HAND])
      await until(() => page.id(name).isEnabled(), `${name} with released brakes`);
    await edit(page, CRASH);
    await page.id("run").click();
    await page.id("alarm-unlock").waitFor();
    for (const name of ["run", "play", "step", ...BY_HAND])
      await until(() => page.id(name).isDisabled(), `${name} in a stop to be off`);
  },
  async "the plot has data whatever its length becomes, and no time under it is cut off"({ page, server }) {
    await until(async () => (await server.state()).time > 10.5, "more than the plot has from live frames", 20_000);
    await page.context().route(/history\?from/, async (route) => {
      await sleep(3000);
      await route.continue();
    });
    await page.id("window").selectOption("60");
    const found = await page.evaluate(
      () =>
        new Promise((done) => {
          const begin = performance.now();
          const found = { least: Infinity, edge: 0, frames: 0 };
          const look = () => {
            const canvas = document.querySelector("#plot canvas");
            const { width, height } = canvas;
            const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
            let coloured = 0;
            for (let at = 0; at < data.length; at += 4) {
              const [r, g, b] = data.subarray(at, at + 3);
              if (data[at + 3] > 100 && Math.max(r, g, b) - Math.min(r, g, b) > 60) coloured += 1;
            }
            for (let y = height - Math.round(20 * globalThis.devicePixelRatio); y < height; y += 1)
              found.edge = Math.max(found.edge, data[(y * width + width - 1) * 4 + 3]);
            if (performance.now() - begin > 300) found.least = Math.min(found.least, coloured);
            found.frames += 1;
            if (performance.now() - begin > 6000) done(found);
            else setTimeout(look, 40);
          };
          look();
        }),
    );
    check(found.frames > 20, `only ${found.frames} looks`);
    check(found.least > 100, `at a moment the plot had ${found.least} points of colour`);
    check(found.edge === 0, `a time is cut off at the right edge (${found.edge})`);
  },
  async "one button runs, and goes on with what is paused"({ page }) {
    await take(page);
    await edit(page, MOVES);
    check((await page.getByRole("button", { name: /^(▶ )?(Run|Play)$/ }).count()) === 1, "one button");
    const triangles = await page.evaluate(
      () =>
        [...document.querySelectorAll("button")].filter(
          (one) =>
            one.checkVisibility({ visibilityProperty: true }) &&
            one.textContent.includes("▶") &&
            !one.textContent.includes("|"),
        ).length,
    );
    check(triangles === 1, `${triangles} triangles`);
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await page.id("pause").click();
    await mode(page, "program-state", "paused");
    await until(async () => (await page.text("run")).includes("Continue"), "the word");
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await page.id("stop").click();
    await mode(page, "program-state", "stopped");
    await until(async () => (await page.text("run")).includes("Run"), "the word");
  },
  async "the right end of the time line is the present"({ page, server }) {
    const end = async () => {
      await until(async () => (await attribute(page, "live", "aria-pressed")) === "true", "the present");
      const before = Number(await page.text("time"));
      await until(async () => Number(await page.text("time")) > before + 0.2, "time to go on");
    };
    const back = async () => {
      await page.id("timeline").fill("0.5");
      await until(async () => (await attribute(page, "live", "aria-pressed")) === "false", "the past");
    };
    await server.run(MOVES);
    await until(async () => Number(await page.id("timeline").getAttribute("max")) > 2, "some time");
    await back();
    await page.id("timeline").focus();
    await sleep(400);
    await page.keyboard.press("End");
    await end();
    await back();
    const place = await box(page, "timeline");
    const y = place.y + place.height / 2;
    await page.mouse.move(place.x + place.width * 0.3, y);
    await page.mouse.down();
    await page.mouse.move(place.x + place.width * 0.6, y, { steps: 4 });
    await sleep(300);
    check((await attribute(page, "live", "aria-pressed")) === "false", "the middle is the past");
    await page.mouse.move(place.x + place.width - 1, y, { steps: 6 });
    await page.mouse.move(place.x + place.width + 40, y, { steps: 3 });
    await page.mouse.up();
    await end();
  },
  async "an angle is read as it is written, and what is none is told in words"({ page }) {
    await take(page);
    await page.id("q-1").fill("-70°");
    await until(async () => (await attribute(page, "view-3d", "data-ghost")) === "true", "the ghost");
    check(!(await page.id("q-1").getAttribute("class"))?.includes("wrong"), "it is marked");
    await page.id("q-1").fill("far left");
    await until(
      async () => (await page.locator("#target-text").innerText()).includes("“far left” is no angle"),
      "the words",
    );
    check((await page.id("q-1").getAttribute("class")).includes("wrong"), "the mark");
    await page.id("tcp-x").fill("1 furlong");
    await until(
      async () => (await page.locator("#target-text").innerText()).includes("“1 furlong” is no length"),
      "the words",
    );
    await page.id("language").click();
    await page.id("q-3").fill("999°");
    await until(
      async () => (await page.locator("#target-text").innerText()).includes("关节 3"),
      "the range, in Chinese",
    );
    await page.id("language").click();
  },
  async "variables of a program without a function around it are shown"({ page, server }) {
    await server.run(
      "import math\n" +
        "def half(x):\n" +
        "  return x / 2\n" +
        "end\n" +
        "parts = 41\n" +
        "sleep(0.3)\n" +
        "parts = parts + 1\n" +
        "rest = half(parts)\n" +
        "sleep(1)\n",
    );
    const value = (name) => page.id("variables").locator(`tr[data-name=${name}] td`).first().innerText();
    await until(async () => (await value("parts")) === "42", "the variable");
    await until(async () => (await value("rest")) === "21.0", "the other");
    check((await page.id("variables").locator("tr").count()) === 2, "functions and modules are none");
  },
  async "a point is taught where it fits"({ page }) {
    await edit(page, "");
    await page.id("teach").click();
    await until(async () => (await page.text("editor")).startsWith("movej(["), "the line, at the top level");
    await edit(page, "def p():\n  while True:\n    sync()\n  end\nend");
    await page.id("editor").focus();
    await page.keyboard.press("Control+End");
    await page.id("teach").click();
    await page.id("editor").focus();
    await page.keyboard.press("Control+Home");
    await page.keyboard.press("ArrowDown");
    await page.id("teach").click();
    const lines = (await page.locator(".cm-line").allInnerTexts()).map((line) => line.slice(0, 11));
    check(
      JSON.stringify(lines) ===
        JSON.stringify(
          ["def p():", "  while True", "    movej([", "    sync()", "  end", "end", "movej([0.00"].map((line) =>
            line.slice(0, 11),
          ),
        ),
      JSON.stringify(lines),
    );
    await until(async () => (await page.text("problems")).includes("No problems"), "a text without findings");
  },
  async "an output is set by hand after one question"({ page, server }) {
    check(await page.id("standard_digital_out[4]").isDisabled(), "without control");
    await take(page);
    await page.id("standard_digital_out[4]").click();
    await until(
      async () => (await page.locator("dialog").innerText()).includes("standard_digital_out[4]"),
      "the question",
    );
    await page.locator("dialog [data-choice='']").click();
    await sleep(200);
    check((await server.get("/api/io")).points["standard_digital_out[4]"] === false, "it is set all the same");
    await page.id("standard_digital_out[4]").click();
    await page.locator("dialog [data-choice=ok]").click();
    await until(async () => (await server.get("/api/io")).points["standard_digital_out[4]"] === true, "the output");
    await page.id("standard_digital_out[4]").click();
    await until(
      async () => (await server.get("/api/io")).points["standard_digital_out[4]"] === false,
      "the output, unasked",
    );
    await page.id("standard_analog_out[0]").fill("2.5");
    await page.id("standard_analog_out[0]").press("Enter");
    await until(
      async () => Math.abs((await server.get("/api/io")).points["standard_analog_out[0]"] - 2.5) < 1e-6,
      "the analog output",
    );
    const refused = await (
      await fetch(`${server.base}/api/v1/orders`, {
        method: "POST",
        headers: { "content-type": "application/json", authorization: `Bearer ${server.token}` },
        body: '{"do":"outputs","values":{"standard_digital_in[1]":true}}',
      })
    ).json();
    check(/has control|is an input/.test(refused.error), JSON.stringify(refused));
  },
  async "degrees and millimetres go in and out, and stay"({ page, server }) {
    await take(page);
    await page.id("units").click();
    check((await page.text("units")) === "° · mm", await page.text("units"));
    const state = await server.state();
    await until(
      async () => Math.abs((await page.value("q-2")) - (state.actual_q[1] * 180) / Math.PI) < 0.02,
      "degrees",
    );
    near(await page.value("tcp-z"), state.actual_tcp_pose[2] * 1000, 0.2, "mm");
    check((await page.locator("#facts").innerText()).includes("mm/s"), "the speed");
    await page.id("q-1").fill("20");
    for (let tries = 0; tries < 4 && Math.abs((await server.state()).actual_q[0] - Math.PI / 9) > 2e-3; tries++) {
      await page.id("move-to").click();
      await until(async () => (await page.text("move-to")).includes("Confirm"), "the question");
      await page.id("move-to").click();
      await until(async () => !/Moving|Confirm/.test(await page.text("move-to")), "the end");
    }
    near((await server.state()).actual_q[0], Math.PI / 9, 2e-3, "joint 1");
    await page.reload();
    await page.connected();
    check((await page.text("units")) === "° · mm", "they are forgotten");
    await page.id("units").click();
    await until(async () => Math.abs((await page.value("q-1")) - Math.PI / 9) < 3e-3, "rad again");
  },
  async "TCP and payload are shown, and follow the program"({ page, server }) {
    await server.run(
      "def p():\n  set_tcp([0, 0, 0.123, 0, 0, 0])\n  set_payload(1.75, [0, 0, 0.05])\n  sleep(0.5)\nend\n",
    );
    await until(async () => {
      const text = await page.locator("#facts").innerText();
      return text.includes("0.1230") && text.includes("1.75 kg") && text.includes("0.0500");
    }, "the facts");
  },
  async "home and the start of the program are gone to, after a look"({ page, server }) {
    await take(page);
    await edit(page, "def p():\n  movej([0.2, -1.4, 1.5, -1.6, -1.57, 0.1], a=1)\nend\n");
    const home = (await server.get("/api/v1/scene")).home;
    const go = async (name, q) => {
      for (let tries = 0; tries < 4; tries++) {
        await page.id(name).click();
        await until(async () => (await attribute(page, "view-3d", "data-ghost")) === "true", "the ghost");
        await until(async () => (await page.text("move-to")).includes("Confirm"), "the question");
        await page.id("move-to").click();
        await until(async () => !/Moving|Confirm/.test(await page.text("move-to")), "the end");
        const state = await server.state();
        if (state.actual_q.every((value, k) => Math.abs(value - q[k]) < 2e-3)) return;
      }
      throw new Error(`${name} is not reached`);
    };
    await go("approach", [0.2, -1.4, 1.5, -1.6, -1.57, 0.1]);
    await go("home", home);
    await edit(page, "sync()\n");
    await page.id("approach").click();
    await until(
      async () => (await page.locator(".toast.error").allInnerTexts()).join().includes("not written in numbers"),
      "the reason",
    );
  },
  async "points have names, are gone to, put into the program, and kept"({ page, server }) {
    await page.evaluate(() => globalThis.localStorage.removeItem("waypoints"));
    await page.reload();
    await page.connected();
    await take(page);
    await edit(page, "");
    await page.id("waypoint-save").click();
    await page.id("waypoint-name").fill("above tray");
    await page.id("waypoint-name").press("Enter");
    const before = (await server.state()).actual_q;
    await hold(page, "jog-j1-plus", async () => (await server.state()).actual_q[0] > before[0] + 0.1);
    await stands(server);
    await page.id("waypoint-save").click();
    check((await page.id("waypoint-name").nth(1).inputValue()) === "P1", "the next name");
    await page.id("waypoint-insert").first().click();
    await until(async () => /movej\(\[.*# above tray/.test(await page.text("editor")), "the line");
    for (let tries = 0; tries < 4 && Math.abs((await server.state()).actual_q[0] - before[0]) > 2e-3; tries++) {
      await page.id("waypoint-go").first().click();
      await until(async () => (await page.text("move-to")).includes("Confirm"), "the question");
      await page.id("move-to").click();
      await until(async () => !/Moving|Confirm/.test(await page.text("move-to")), "the end");
    }
    near((await server.state()).actual_q[0], before[0], 2e-3, "joint 1");
    await page.reload();
    await page.connected();
    check((await page.id("waypoint-name").first().inputValue()) === "above tray", "it is forgotten");
    for (let k = 0; k < 2; k++) await page.id("waypoint-remove").first().click();
    check((await page.id("waypoint-name").count()) === 0, "they stay");
  },
  async "what a page that is gone costs is said"({ page }) {
    check((await page.text("gone")).includes("150 ms"), await page.text("gone"));
    await page.id("language").click();
    check(
      (await page.text("gone")).includes("150 ms") && /[一-鿿]/.test(await page.text("gone")),
      await page.text("gone"),
    );
    await page.id("language").click();
  },
  async "at first there is no program"({ page }) {
    await take(page);
    check((await page.locator(".cm-content").innerText()).includes("No program"), await page.text("editor"));
    check(await page.id("run").isDisabled(), "run");
    await edit(page, MOVES);
    await until(() => page.id("run").isEnabled(), "run");
    await page.id("new").click();
    await page.locator("dialog [data-choice=yes]").click();
    await until(() => page.id("run").isDisabled(), "nothing to run");
  },
  async "the log has columns, and long texts are folded"({ page, server }) {
    await server.run(
      "def p():\n" +
        "  textmsg('short')\n" +
        `  textmsg('${"long words and more of them ".repeat(20)}')\n` +
        "  textmsg('end')\n" +
        "end\n",
    );
    await until(async () => (await page.text("log")).includes("end"), "the log");
    await tab(page, "logs");
    const lefts = await page.evaluate(() =>
      [...document.querySelectorAll("#log .line")].map((line) =>
        [...line.querySelectorAll("time, b, .said")].map((part) => Math.round(part.getBoundingClientRect().left)),
      ),
    );
    check(
      lefts.every((row) => row.join() === lefts[0].join()),
      `columns: ${JSON.stringify(lefts)}`,
    );
    const line = page.locator("#log .line", { hasText: "long words" });
    const folded = (await line.boundingBox()).height;
    await line.getByTestId("unfold").click();
    check((await line.boundingBox()).height > folded + 20, "it stays folded");
  },
  async "texts are large enough, and so is what is pressed"({ browser, server }) {
    for (const viewport of SCREENS) {
      const page = await open(browser, server, { viewport });
      await take(page);
      await edit(page, 'def p():\n  $ LINE: (1, "Approach")\n  movejj(1)\nend\n');
      await until(async () => (await page.text("problems")).includes("movejj"), "a finding");
      await page.id("waypoint-save").click();
      const found = await page.evaluate(() => {
        const isSeen = (one) =>
          one.checkVisibility({ visibilityProperty: true }) &&
          one.getClientRects().length > 0 &&
          !one.closest(".sr, .cm-editor");
        const texts = [...document.querySelectorAll("body *")].filter(
          (one) =>
            isSeen(one) && [...one.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim() !== ""),
        );
        const small = texts
          .filter((one) => parseFloat(getComputedStyle(one).fontSize) < 12)
          .map((one) => `${one.tagName}.${one.className} ${one.textContent.slice(0, 20)}`);
        const targets = [...document.querySelectorAll("button, select, input, summary, nav a")].filter(isSeen);
        const low = targets
          .map((one) => ({ name: one.dataset.testid ?? one.textContent, size: one.getBoundingClientRect() }))
          .filter(({ size }) => size.height < 35.5 || size.width < 35.5)
          .map(({ name, size }) => `${name} ${Math.round(size.width)}×${Math.round(size.height)}`);
        return { small, low, wide: document.documentElement.scrollWidth - innerWidth };
      });
      check(found.small.length === 0, `small at ${viewport.width}: ${found.small.join("; ")}`);
      check(found.low.length === 0, `less than 36 px at ${viewport.width}: ${found.low.join("; ")}`);
      check(found.wide <= 0, `${found.wide} px too wide at ${viewport.width}`);
      await page.context().close();
    }
  },
  async "the plot is made larger and smaller, and its legend lies beside it"({ page, server }) {
    await server.run(MOVES);
    const before = await box(page, "plot");
    await page.id("plot-size").click();
    const after = await box(page, "plot");
    check(after.height > before.height * 2, `${before.height} to ${after.height}`);
    await until(
      async () => (await page.locator("#plot canvas").boundingBox()).height > before.height * 1.8,
      "the drawing",
    );
    const [legend, stop] = [await box(page, "plot-legend"), await box(page, "stop")];
    check(legend.y + legend.height <= after.y + 1, "the legend covers the plot");
    check(stop.y > 0 && stop.y + stop.height < 720, "stop is seen");
    await page.id("plot-size").click();
    near((await box(page, "plot")).height, before.height, 1, "the height again");
  },
  async "completion offers movej and movel first, and covers nothing beside the editor"({ page }) {
    await edit(page, "def p():\n  \nend\n");
    await page.id("editor").focus();
    await page.keyboard.press("Control+Home");
    await page.keyboard.press("ArrowDown");
    await page.keyboard.press("End");
    await page.keyboard.type("mov", { delay: 5 });
    const first = async (n) => page.locator(".cm-tooltip-autocomplete li .cm-completionLabel").nth(n).innerText();
    await until(async () => (await first(0)) === "movej" && (await first(1)) === "movel", "the order");
    await sleep(900);
    const [list, editor] = [
      await page.locator(".cm-tooltip-autocomplete").boundingBox(),
      await page.locator(".cm-editor").boundingBox(),
    ];
    check(
      list.y >= editor.y - 1 && list.y + list.height <= editor.y + editor.height + 1,
      `the list leaves the editor: ${JSON.stringify([list, editor])}`,
    );
    const info = page.locator(".cm-completionInfo");
    if ((await info.count()) > 0) {
      const about = await info.boundingBox();
      check(
        about.y >= editor.y - 1 && about.y + about.height <= editor.y + editor.height + 1,
        `the text about it leaves the editor: ${JSON.stringify([about, editor])}`,
      );
    }
  },
  async "at the end of a long text completion stays in the editor, too"({ page }) {
    await edit(page, `${"sync()\n".repeat(60)}`);
    await page.id("editor").focus();
    await page.keyboard.press("Control+End");
    await page.keyboard.type("mov", { delay: 5 });
    const info = page.locator(".cm-completionInfo");
    await info.waitFor();
    // A list whose line is not measured yet waits above the window, at -10000: it is placed as soon as the editor has
    // scrolled.
    for (const shown of [page.locator(".cm-tooltip-autocomplete"), info])
      await until(async () => (await shown.boundingBox()).y > -5000, "the list in its place");
    await sleep(300);
    const editor = await page.locator(".cm-editor").boundingBox();
    for (const shown of [page.locator(".cm-tooltip-autocomplete"), info]) {
      const place = await shown.boundingBox();
      check(
        place.y >= editor.y - 1 && place.y + place.height <= editor.y + editor.height + 1,
        `it leaves the editor: ${JSON.stringify([place, editor])}`,
      );
    }
  },
  async "an alarm is told in the language of the page"({ page }) {
    await take(page);
    await edit(page, "def p():\n  sync()\n  movej(1)\nend\n");
    await page.id("run").click();
    await until(async () => (await page.text("alarm")).includes("must be"), "the alarm in English");
    await page.id("language").click();
    await until(async () => (await page.text("alarm")).includes("必须是"), "the alarm in Chinese");
    check(!(await page.text("alarm")).includes("must be"), "a mixture");
    await page.id("language").click();
  },
};

/** Those need a server of their own kind. */
export const special = {
  async "inputs and outputs have the names of the cell"({ browser }) {
    const server = await Server.start(["--cell", FENCE]);
    const page = await open(browser, server);
    await until(async () => (await attribute(page, "standard_digital_out[1]", "title")).includes("vacuum"), "the name");
    check((await page.text("standard_digital_out[1]")).includes("vacuum"), "the name on the button");
    const names = await page.text("io-names");
    for (const words of ["vacuum → part held", "part held ← vacuum", "reduced mode"])
      check(names.includes(words), names);
    await take(page);
    await page.id("standard_digital_out[1]").click();
    await until(async () => (await page.locator("dialog").innerText()).includes("vacuum"), "the question, by its name");
    await page.locator("dialog [data-choice=ok]").click();
    await until(async () => (await attribute(page, "standard_digital_in[2]", "data-value")) === "1", "the wire");
  },
  async "a plane that would be crossed is called by its name, with the place"({ browser }) {
    const server = await Server.start(["--cell", FENCE]);
    const page = await open(browser, server);
    await take(page);
    await edit(page, CRASH);
    await page.id("run").click();
    await mode(page, "safety-mode", "PROTECTIVE_STOP");
    await until(async () => (await page.text("alarm")).includes('safety plane "fence"'), "the name");
    const text = await page.text("alarm");
    check(text.includes("line 4") && text.includes("untitled.script"), text);
    await page.id("language").click();
    await until(async () => (await page.text("alarm")).includes('安全平面 "fence"'), "the name in Chinese");
    await page.id("language").click();
    await page.id("alarm-go").click();
    await until(async () => (await page.locator(".cm-activeLine").innerText()).includes("speedl"), "the line");
    await page.id("alarm-unlock").click();
    await mode(page, "safety-mode", "NORMAL");
    await edit(page, "def p():\n  movel([-0.5, -0.2, 0.1, 3.14, 0, 0])\nend\n");
    await page.id("run").click();
    await until(async () => /behind safety plane "fence"/.test(await page.text("alarm")), "the name in the error");
  },
  async "the first step leads through control, power and brakes"({ browser }) {
    const server = await Server.start(["--powered-off"]);
    const page = await open(browser, server);
    for (const [words, step] of [
      ["Take control", "take_control"],
      ["Power on", "power_on"],
      ["Release brakes", "brake_release"],
    ]) {
      await until(
        async () => (await page.text("first-step-go")) === words && (await page.id("first-step-go").isEnabled()),
        step,
      );
      await page.id("first-step-go").click();
    }
    await mode(page, "robot-mode", "RUNNING");
    await until(() => page.id("first-step").isHidden(), "it to go");
  },
  async "in a recording nothing is opened, made, taught or run"({ browser }) {
    const folder = mkdtempSync(path.join(tmpdir(), "page-"));
    writeFileSync(path.join(folder, "r.script"), "parts = 3\nmovej([0.2, -1.4, 1.5, -1.6, -1.57, 0.1], a=2, v=1)\n");
    await promisify(execFile)(BINARY, ["run", "r.script", "--record", "r.mcap"], { cwd: folder });
    const server = await Server.replay(path.join(folder, "r.mcap"));
    const page = await open(browser, server);
    await until(async () => (await page.text("editor")).includes("parts = 3"), "the program");
    for (const name of [
      "teach",
      "new",
      "open",
      "save",
      "run",
      "step",
      "home",
      "approach",
      "standard_digital_out[0]",
      "standard_digital_in[0]",
    ])
      check(await page.id(name).isDisabled(), name);
    await until(async () => (await page.locator("#facts").innerText()).includes("kg"), "the payload");
    rmSync(folder, { recursive: true, force: true });
  },
  async "labels are texts of the page, without figures, and follow the picture"({ drawing }) {
    const server = await Server.start(["--cell", FENCE]);
    for (const colorScheme of ["dark", "light"]) {
      const page = await open(await drawing(), server, { colorScheme });
      const label = page.locator("#labels .label", { hasText: "table" });
      await label.waitFor();
      check((await label.innerText()) === "table", await label.innerText());
      await until(async () => (await page.locator("#labels .label", { hasText: "fence" }).count()) === 1, "the plane");
      const contrast = await label.evaluate((element) => {
        const light = (color) => {
          const [r, g, b] = /(\d+), (\d+), (\d+)/
            .exec(color)
            .slice(1)
            .map((x) =>
              Number(x) / 255 <= 0.03928 ? Number(x) / 255 / 12.92 : ((Number(x) / 255 + 0.055) / 1.055) ** 2.4,
            );
          return 0.2126 * r + 0.7152 * g + 0.0722 * b;
        };
        const { color, backgroundColor } = getComputedStyle(element);
        const [a, b] = [light(color), light(backgroundColor)].sort((x, y) => y - x);
        return (a + 0.05) / (b + 0.05);
      });
      check(contrast > 10, `contrast ${contrast} in ${colorScheme}`);
      const before = await label.boundingBox();
      const view = await box(page, "view-3d");
      await page.mouse.move(view.x + view.width * 0.7, view.y + 60);
      await page.mouse.down();
      await page.mouse.move(view.x + view.width * 0.5, view.y + 90, { steps: 5 });
      await page.mouse.up();
      await until(async () => {
        const after = await label.boundingBox();
        return !after || Math.abs(after.x - before.x) > 4;
      }, "the label to follow");
      await page.context().close();
    }
  },
  async "taught, run and recovered from a collision without a keyboard"({ browser }) {
    // Written in docs/pendant.md as a task. Everything is done by the pointer: no key is pressed, no text typed.
    const server = await Server.start(["--powered-off", "--cell", path.join(path.dirname(FENCE), "cell.toml")]);
    const page = await open(browser, server);
    const key = (name) => {
      throw new Error(`${name} is no pointer`);
    };
    page.keyboard.press = page.keyboard.type = page.keyboard.down = () => key("the keyboard");
    // 1. What the page offers first: control, power, brakes.
    for (const words of ["Take control", "Power on", "Release brakes"]) {
      await until(
        async () => (await page.text("first-step-go")) === words && (await page.id("first-step-go").isEnabled()),
        words,
      );
      await page.id("first-step-go").click();
    }
    await mode(page, "robot-mode", "RUNNING");
    // 2. Three points, each after a jog.
    const teach = async (jog, isThere) => {
      await hold(page, jog, isThere);
      await stands(server);
      await page.id("teach").click();
    };
    const q = async (joint) => (await server.state()).actual_q[joint];
    const start = await q(0);
    await teach("jog-j1-plus", async () => (await q(0)) > start + 0.15);
    const height = (await server.state()).actual_tcp_pose[2];
    await teach("jog-z-minus", async () => (await server.state()).actual_tcp_pose[2] < height - 0.03);
    await teach("jog-j1-minus", async () => (await q(0)) < start - 0.05);
    check((await page.text("editor")).match(/movej\(\[/g)?.length === 3, "three points");
    await until(async () => (await page.text("problems")).includes("No problems"), "a program without findings");
    // 3. It runs to its end.
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await mode(page, "program-state", "stopped");
    check(await page.id("alarm").isHidden(), await page.text("alarm"));
    near(await q(0), start - 0.05, 0.1, "joint 1 at the third point");
    // 4. A point in the table: the arm is led down until it touches, and stops by itself.
    await page.id("jog-speed").click({ position: { x: 100, y: 18 } });
    // A jog ends by itself at a limit of the page's reach: it is held again until the arm has touched.
    const stopped = async () => (await server.state()).safety_mode !== "NORMAL";
    for (let tries = 0; tries < 30 && !(await stopped()); tries++) {
      let moved = false;
      await hold(page, "jog-z-minus", async () => {
        const speed = Math.abs((await server.state()).actual_qd[1]);
        moved ||= speed > 5e-3;
        return (await stopped()) || (moved && speed < 1e-3);
      });
    }
    await mode(page, "safety-mode", "PROTECTIVE_STOP");
    await page.id("alarm-unlock").waitFor();
    check(await page.id("run").isDisabled(), "run in a stop");
    // 5. Unlock, away from the table, run again.
    await page.id("alarm-unlock").click();
    await mode(page, "safety-mode", "NORMAL");
    const low = (await server.state()).actual_tcp_pose[2];
    await hold(page, "jog-z-plus", async () => (await server.state()).actual_tcp_pose[2] > low + 0.05);
    await stands(server);
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await mode(page, "program-state", "stopped");
    check(await page.id("alarm").isHidden(), "an alarm");
  },
};
