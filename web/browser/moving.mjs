// At a glance, power, moving by hand: each with a page of its own on a server where nothing runs.
import {
  attribute,
  check,
  edit,
  hold,
  holdBack,
  mode,
  moved,
  MOVES,
  near,
  press,
  sleep,
  stands,
  take,
  until,
} from "./harness.mjs";

// prettier-ignore
const NAMES = [
  "connection", "robot-mode", "safety-mode", "program-state", "speed", "power-on", "brake-release", "unlock", "play",
  "pause", "stop", "step", "open", "save", "editor", "run", "problems", "take-control", "jog-frame", "move-to", "io",
  "variables", "log", "timeline", "time", "language", "view-3d",
];

/** A move to another place, confirmed and under way. */
async function setOff(page, server) {
  await page.id("q-1").fill("2.5");
  await page.id("move-to").click();
  await until(async () => (await page.text("move-to")).includes("Confirm"), "the question");
  await page.id("move-to").click();
  await until(async () => Math.abs((await server.state()).actual_qd[0]) > 0.05, "the motion");
}

/**
 * Confirms a move and waits for its end. A machine with other work may keep a page silent, which stops the arm and is
 * said: it is sent again.
 */
async function sendThere(page, isThere) {
  const isOver = async () =>
    !(await page.text("move-to")).includes("Moving") &&
    (await page.locator(".toast.error", { hasText: "no sign of life" }).count()) > 0;
  for (let tries = 0; tries < 4; tries++) {
    await page.id("move-to").click();
    await until(async () => (await page.text("move-to")).includes("Confirm"), "the question");
    await page.id("move-to").click();
    await until(async () => (await isThere()) || (await isOver()), "the target");
    if (await isThere()) return;
  }
  throw new Error("the arm was stopped again and again");
}

export const scenarios = {
  async "the page has a strict policy and asks nobody else"({ page, server }) {
    const answer = await fetch(server.base);
    const policy = answer.headers.get("content-security-policy");
    check(policy.includes("default-src 'self'") && !policy.includes("unsafe"), policy);
    await edit(page, "x = 1 / 0 +\n");
    await until(async () => (await page.id("problems").locator("button").count()) > 0, "the findings");
    const foreign = page.requests.filter((url) => !url.startsWith(server.base));
    check(foreign.length === 0, foreign.join());
    check(page.complaints.length === 0, page.complaints.join());
  },
  async "the first look tells connected, powered, safe, stopped"({ page }) {
    check((await page.text("connection")) === "connected", await page.text("connection"));
    check((await page.text("robot-mode")) === "RUNNING", await page.text("robot-mode"));
    check((await page.text("safety-mode")) === "NORMAL", await page.text("safety-mode"));
    check((await page.text("program-state")) === "stopped", await page.text("program-state"));
  },
  async "everything that has a name for tests is there"({ page }) {
    const jogs = ["j1", "j2", "j3", "j4", "j5", "j6", "x", "y", "z", "rx", "ry", "rz"].flatMap((axis) => [
      `jog-${axis}-plus`,
      `jog-${axis}-minus`,
    ]);
    const fields = [1, 2, 3, 4, 5, 6]
      .map((n) => `q-${n}`)
      .concat(["x", "y", "z", "rx", "ry", "rz"].map((axis) => `tcp-${axis}`));
    for (const name of [...NAMES, ...jogs, ...fields]) check((await page.id(name).count()) === 1, name);
  },
  async "joints and pose are those of the arm"({ page, server }) {
    const state = await server.state();
    for (let k = 0; k < 6; k++) near(await page.value(`q-${k + 1}`), state.actual_q[k], 2e-3, `q-${k + 1}`);
    const axes = ["x", "y", "z"];
    for (let k = 0; k < 3; k++) near(await page.value(`tcp-${axes[k]}`), state.actual_tcp_pose[k], 2e-3, axes[k]);
  },
  async "without control nothing can be ordered but to stop"({ page }) {
    for (const name of [
      "jog-j1-plus",
      "jog-x-minus",
      "move-to",
      "run",
      "play",
      "power-off",
      "freedrive",
      "speed",
      "standard_digital_in[0]",
    ])
      check(await page.id(name).isDisabled(), name);
    check(await page.id("stop").isEnabled(), "stop");
  },
  async "control is taken and given up"({ page, server }) {
    await take(page);
    check(await page.id("jog-j1-plus").isEnabled(), "jog");
    check((await server.state()).control !== null, "control");
    await page.id("take-control").click();
    await until(() => page.id("jog-j1-plus").isDisabled(), "the jog buttons to be off");
    await until(async () => (await server.state()).control === null, "the desk to be free");
  },
  async "power off, power on, release the brakes"({ page }) {
    await take(page);
    await page.id("power-off").click();
    await mode(page, "robot-mode", "POWER_OFF");
    await until(() => page.id("jog-j1-plus").isDisabled(), "the jog buttons to be off");
    await page.id("power-on").click();
    await mode(page, "robot-mode", "IDLE");
    await page.id("brake-release").click();
    await mode(page, "robot-mode", "RUNNING");
  },
  async "an order that is refused says why"({ page }) {
    await take(page);
    // As on a page that has not heard yet that the power is gone.
    await page.id("jog-j1-plus").evaluate((button) => {
      Object.defineProperty(button, "disabled", { get: () => false, set() {} });
    });
    await page.id("power-off").click();
    await mode(page, "robot-mode", "POWER_OFF");
    await hold(page, "jog-j1-plus", async () =>
      (await page.locator(".toast.error").allInnerTexts()).join().includes("POWER_OFF"),
    );
  },
  async "the speed slider sets the speed"({ page, server }) {
    await take(page);
    await page.id("speed").fill("35");
    await until(async () => Math.abs((await server.state()).speed - 0.35) < 1e-6, "the speed");
  },
  async "a speed that somebody else sets is seen"({ page, server }) {
    await server.order({ do: "speed", fraction: 0.6 });
    await until(async () => (await page.id("speed").inputValue()) === "60", "the slider");
  },
  async "a joint moves while its button is held and stands after"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_q[0];
    await hold(page, "jog-j1-plus", async () => (await server.state()).actual_q[0] > before + 0.03);
    await stands(server);
    const after = (await server.state()).actual_q[0];
    await sleep(200);
    near((await server.state()).actual_q[0], after, 1e-3, "joint 1 stays");
  },
  async "a joint moves the other way"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_q[5];
    await hold(page, "jog-j6-minus", async () => (await server.state()).actual_q[5] < before - 0.03);
    await stands(server);
  },
  async "the TCP moves along the base's x"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_tcp_pose;
    await hold(page, "jog-x-plus", async () => (await server.state()).actual_tcp_pose[0] > before[0] + 0.01);
    await stands(server);
    const after = (await server.state()).actual_tcp_pose;
    near(after[1], before[1], 1e-3, "y");
    near(after[2], before[2], 1e-3, "z");
  },
  async "the TCP moves along its own z, which points down"({ page, server }) {
    await take(page);
    await page.id("jog-frame").selectOption("tool");
    const before = (await server.state()).actual_tcp_pose;
    await hold(page, "jog-z-plus", async () => (await server.state()).actual_tcp_pose[2] < before[2] - 0.01);
    await stands(server);
  },
  async "the TCP turns about the base's z"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_tcp_pose;
    await hold(
      page,
      "jog-rz-plus",
      async () => moved((await server.state()).actual_tcp_pose.slice(3), before.slice(3)) > 0.02,
    );
    await stands(server);
    const after = (await server.state()).actual_tcp_pose;
    near(after[0], before[0], 2e-3, "x");
  },
  async "a jog by the keyboard"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_q[1];
    await press(
      page,
      "jog-j2-minus",
      async () => (await server.state()).actual_q[1] < before - 0.02,
      "the jog",
      "Space",
    );
    await page.keyboard.up("Space");
    await stands(server);
  },
  async "a jog ends when the focus leaves"({ page, server }) {
    await take(page);
    await press(page, "jog-j2-minus", async () => (await server.state()).actual_qd[1] < -0.02, "the jog", "Enter");
    await page.id("stop").focus();
    await stands(server);
    await page.keyboard.up("Enter");
  },
  async "a page that is killed while it jogs stops the arm"({ page, server }) {
    await take(page);
    await press(page, "jog-j1-minus", async () => (await server.state()).actual_qd[0] < -0.05, "the jog");
    await page.close();
    await until(async () => Math.abs((await server.state()).actual_qd[0]) < 1e-3, "the arm to stand", 1500);
    await until(async () => (await server.state()).control === null, "the desk to be free");
  },
  async "a page that falls silent while it jogs stops the arm"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_q[0];
    await press(
      page,
      "jog-j1-plus",
      async () => Math.abs((await server.state()).actual_q[0] - before) > 0.01,
      "the jog",
    );
    await page.evaluate(() => {
      const end = performance.now() + 700;
      while (performance.now() < end);
    });
    near((await server.state()).actual_qd[0], 0, 1e-3, "the speed of joint 1");
    await page.mouse.up();
    await until(
      async () => (await page.locator(".toast.error").allInnerTexts()).join().includes("no sign of life"),
      "the reason",
    );
  },
  async "while a program runs nothing is jogged"({ page, server }) {
    await take(page);
    await edit(page, MOVES);
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await until(() => page.id("jog-j1-plus").isDisabled(), "the jog buttons to be off");
    check(await page.id("move-to").isDisabled(), "move-to");
    await server.order({ do: "stop" });
  },
  async "a typed target is shown by a ghost and nothing moves yet"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_q;
    await page.id("q-1").fill("0.4");
    await until(async () => (await attribute(page, "view-3d", "data-ghost")) === "true", "the ghost");
    await page.id("move-to").click();
    await sleep(300);
    check(moved((await server.state()).actual_q, before) < 2e-3, "the arm moved");
    await page.id("move-reset").click();
    check((await attribute(page, "view-3d", "data-ghost")) === "false", "the ghost is gone");
  },
  async "what was typed before is no target, however late its answer comes"({ page }) {
    await take(page);
    const held = await holdBack(page, "**/api/v1/reach");
    await page.id("q-1").fill("0.4");
    await held.asked();
    await page.id("move-to").click();
    await held.asked(2);
    await page.id("move-reset").click();
    await held.answer();
    check((await attribute(page, "view-3d", "data-ghost")) === "false", "a ghost of what was taken back");
    check(!(await page.text("move-to")).includes("Confirm"), "a question about what was taken back");
  },
  async "confirmed, the arm goes there"({ page, server }) {
    await take(page);
    await page.id("q-1").fill("0.2");
    await sendThere(page, async () => Math.abs((await server.state()).actual_q[0] - 0.2) < 2e-3);
    await until(async () => Math.abs((await page.value("q-1")) - 0.2) < 3e-3, "the field");
  },
  async "a typed pose is gone to"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_tcp_pose;
    await page.id("tcp-z").fill(String((before[2] + 0.05).toFixed(4)));
    await sendThere(page, async () => Math.abs((await server.state()).actual_tcp_pose[2] - before[2] - 0.05) < 3e-3);
  },
  async "a pose out of reach is said to be so"({ page }) {
    await take(page);
    await page.id("tcp-x").fill("5");
    await until(async () => (await page.locator("#target-text").innerText()).includes("out of reach"), "the sentence");
    await page.id("move-to").click();
    await sleep(200);
    check(!(await page.text("move-to")).includes("Confirm"), "it is offered all the same");
  },
  async "a joint beyond its range is named"({ page }) {
    await page.id("q-3").fill("9");
    await until(async () => (await page.locator("#target-text").innerText()).includes("joint 3"), "the sentence");
  },
  async "what is no number is marked"({ page }) {
    await page.id("q-2").fill("abc");
    check((await page.id("q-2").getAttribute("class")).includes("wrong"), "the mark");
  },
  async "a move is stopped by another click"({ page, server }) {
    await take(page);
    await setOff(page, server);
    await page.id("move-to").click();
    await stands(server);
    check((await server.state()).actual_q[0] < 2.3, "it went on");
  },
  async "the stop button ends a move"({ page, server }) {
    await take(page);
    await setOff(page, server);
    await page.id("stop").click();
    await stands(server);
  },
  async "in freedrive the arm follows a push"({ page, server }) {
    await take(page);
    const before = (await server.state()).actual_q;
    await press(
      page,
      "freedrive",
      async () => (await server.state()).motion_mode === "freedrive",
      "freedrive",
      "Space",
    );
    await page.evaluate(() => document.querySelector("[data-testid=push]").click());
    await until(async () => moved((await server.state()).actual_q, before) > 0.01, "the arm to give way");
    await page.keyboard.up("Space");
    await until(async () => (await server.state()).motion_mode !== "freedrive", "the end of freedrive");
  },
};
