// Points, popups, alarms, programs that run: each with a page of its own on a server where nothing runs.
import { writeFileSync } from "node:fs";
import path from "node:path";
import { attribute, check, edit, mode, MOVES, open, stands, take, until } from "./harness.mjs";

export const scenarios = {
  async "an input is set and seen on another page"({ page, server, browser }) {
    await take(page);
    const other = await open(browser, server);
    await page.id("standard_digital_in[3]").click();
    await until(async () => (await attribute(other, "standard_digital_in[3]", "data-value")) === "1", "the input");
    await page.id("standard_digital_in[3]").click();
    await until(async () => (await attribute(other, "standard_digital_in[3]", "data-value")) === "0", "the input");
    await other.close();
  },
  async "an analog input is set"({ page, server }) {
    await take(page);
    await page.id("standard_analog_in[0]").fill("2.5");
    await page.id("standard_analog_in[0]").press("Enter");
    await until(
      async () => Math.abs((await server.get("/api/io")).points["standard_analog_in[0]"] - 2.5) < 1e-6,
      "the input",
    );
  },
  async "a register is set and shown"({ page, server }) {
    await take(page);
    await page.id("register-kind").selectOption("integer");
    await page.id("register-index").fill("7");
    await page.id("register-value").fill("-42");
    await page.id("register-set").click();
    await until(async () => (await server.get("/api/io")).points["input_integer_register[7]"] === -42, "the register");
    await until(async () => (await page.text("input-integer")).includes("[7] -42"), "the text");
  },
  async "an output that a program sets is seen"({ page, server }) {
    await server.run(
      "def p():\n  set_standard_digital_out(5, True)\n  sleep(2)\n  set_standard_digital_out(5, False)\nend\n",
    );
    await until(async () => (await attribute(page, "standard_digital_out[5]", "data-value")) === "1", "the output");
  },
  async "a popup is answered and the program goes on"({ page, server }) {
    await take(page);
    await edit(page, "def p():\n  popup('ready?', 'Question', blocking=True)\n  textmsg('went on')\nend\n");
    await page.id("run").click();
    await until(async () => (await page.text("popup")).includes("ready?"), "the popup");
    await page.id("popup-ok").click();
    await until(async () => (await page.text("log")).includes("went on"), "the log");
    await until(async () => (await page.id("popup").count()) === 0, "the popup to be closed");
    check((await server.state()).panel.popups.length === 0, "it is closed");
  },
  async "a popup is answered by stopping the program"({ page, server }) {
    await take(page);
    await edit(page, "def p():\n  popup('ready?', blocking=True)\n  textmsg('must not come')\nend\n");
    await page.id("run").click();
    await page.id("popup-cancel").click();
    await until(async () => (await server.state()).program_state === "stopped", "the end");
    check(!(await page.text("log")).includes("must not come"), "it went on");
  },
  async "popups are texts, whatever they say"({ page, server }) {
    await server.run(
      "def p():\n  popup('<img src=x onerror=alert(1)><b>bold</b>', '<script>alert(2)</script>')\nend\n",
    );
    await until(async () => (await page.text("popup")).includes("<img src=x onerror=alert(1)>"), "the popup");
    check((await page.id("popup").locator("img, b, script").count()) === 0, "markup");
    check(page.complaints.length === 0, page.complaints.join());
    await server
      .get("/api/v1/state")
      .then((state) =>
        Promise.all(state.panel.popups.map((popup) => server.order({ do: "close_popup", popup: popup.id }))),
      );
  },
  async "an error of a program is an alarm with its place"({ page }) {
    await take(page);
    await edit(page, "def p():\n  sync()\n  x = 1 / 0\nend\n");
    await page.id("run").click();
    await until(async () => (await page.text("alarm")).includes("ZeroDivisionError"), "the alarm");
    const text = await page.text("alarm");
    check(text.includes("line 3") && text.includes("run it again"), text);
    await page.id("alarm-go").click();
    await until(async () => (await page.locator(".cm-activeLine").innerText()).includes("1 / 0"), "the line");
    await page.id("alarm-dismiss").click();
    check(await page.id("alarm").isHidden(), "it stays");
  },
  async "a text that does not compile is an alarm and replaces nothing"({ page }) {
    await take(page);
    await edit(page, "def p(:\nend\n");
    await page.id("run").click();
    await until(async () => (await page.text("alarm")).includes("SyntaxError"), "the alarm");
  },
  async "alarms, logs, variables and names are texts"({ page, server }) {
    const evil = "<img src=x onerror=alert(1)>";
    await server.run(
      `def p():\n  global v\n  v = '${evil}'\n  textmsg('${evil}')\n  sleep(0.3)\n  raise ValueError('${evil}')\nend\n`,
      "<b>x</b>.script",
    );
    await until(async () => (await page.text("alarm")).includes(evil), "the alarm");
    await until(async () => (await page.text("log")).includes(evil), "the log");
    await until(async () => (await page.text("variables")).includes("onerror"), "the variable");
    check((await page.locator("#alarm img, #log img, #variables img, #alarm b b").count()) === 0, "markup");
    check(page.complaints.length === 0, page.complaints.join());
  },
  async "a program's file name is a text"({ page, server }) {
    writeFileSync(path.join(server.folder, "tasks", "<img src=x onerror=alert(9)>.script"), "sync()\n");
    await page.id("open").click();
    await until(
      async () => (await page.locator(".file").allInnerTexts()).some((name) => name.startsWith("<img")),
      "the name",
    );
    check((await page.locator("dialog img").count()) === 0, "markup");
    await page.locator(".file", { hasText: "<img" }).click();
    await until(async () => (await page.id("program-name").inputValue()).startsWith("<img"), "the program");
  },
  async "an emergency stop, and the way back"({ page, server }) {
    await server.order({ do: "emergency_stop", pressed: true });
    await mode(page, "safety-mode", "ROBOT_EMERGENCY_STOP");
    await until(async () => (await page.text("alarm")).includes("Release the emergency stop"), "what to do");
    await server.order({ do: "emergency_stop", pressed: false });
    await take(page);
    await until(() => page.id("power-on").isEnabled(), "power on");
    await page.id("power-on").click();
    await mode(page, "robot-mode", "IDLE");
    await page.id("brake-release").click();
    await mode(page, "robot-mode", "RUNNING");
    await until(() => page.id("alarm").isHidden(), "the alarm to go");
  },
  async "a protective stop, and unlock"({ page, server }) {
    await server.run(
      "def p():\n" +
        "  movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n" +
        "  while True:\n" +
        "    speedl([0, 0, -0.2, 0, 0, 0], 1, 0.1)\n" +
        "  end\n" +
        "end\n",
    );
    await mode(page, "safety-mode", "PROTECTIVE_STOP");
    await until(async () => (await page.text("alarm")).includes("protective stop"), "the alarm");
    check((await page.text("alarm")).includes("press Unlock"), "what to do");
    await take(page);
    await until(() => page.id("unlock").isEnabled(), "unlock");
    await page.id("unlock").click();
    await mode(page, "safety-mode", "NORMAL");
    await until(() => page.id("alarm").isHidden(), "the alarm to go");
  },
  async "a program runs from the editor and its line is marked"({ page }) {
    await take(page);
    await edit(page, MOVES);
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await until(async () => (await page.id("running-line").innerText()).includes("movej"), "the line");
    await page.id("stop").click();
    await mode(page, "program-state", "stopped");
    await until(async () => (await page.id("running-line").count()) === 0, "the mark to go");
  },
  async "a program is held and goes on"({ page, server }) {
    await take(page);
    await edit(page, MOVES);
    await page.id("play").click();
    await mode(page, "program-state", "running");
    await page.id("pause").click();
    await mode(page, "program-state", "paused");
    await stands(server);
    await page.id("play").click();
    await mode(page, "program-state", "running");
    await page.id("stop").click();
    await mode(page, "program-state", "stopped");
  },
  async "what would end a program is asked about first"({ page, server }) {
    await take(page);
    await edit(page, MOVES);
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await page.id("power-off").click();
    await until(async () => (await page.locator("dialog").innerText()).includes("Power off ends it"), "the question");
    await page.locator("dialog [data-choice='']").click();
    check((await server.state()).program_state === "running", "it was ended");
    const newest = async () => (await server.get("/api/v1/program")).number;
    const first = await newest();
    await page.id("run").click();
    await page.locator("dialog [data-choice=ok]").click();
    await until(async () => (await newest()) !== first, "the other program");
    await page.id("power-off").click();
    await page.locator("dialog [data-choice=ok]").click();
    await mode(page, "robot-mode", "POWER_OFF");
    await mode(page, "program-state", "stopped");
  },
  async "a program is stopped while a question is open"({ page, server }) {
    await take(page);
    await edit(page, MOVES);
    await page.id("run").click();
    await mode(page, "program-state", "running");
    await page.id("power-off").click();
    await until(async () => (await page.locator("dialog").innerText()).includes("Power off ends it"), "the question");
    await page.id("dialog-stop").click();
    await mode(page, "program-state", "stopped");
    await stands(server);
    check(await page.locator("dialog").evaluate((dialog) => dialog.open), "the question was answered by the stop");
    check((await attribute(page, "robot-mode", "data-value")) !== "POWER_OFF", "the stop has switched the power off");
  },
  async "a program is stepped line by line"({ page }) {
    await take(page);
    await edit(page, "def p():\n  sleep(0.05)\n  sleep(0.06)\n  sleep(0.07)\n  sleep(0.08)\nend\n");
    await page.id("step").click();
    await mode(page, "program-state", "paused");
    const first = await page.id("running-line").innerText();
    await page.id("step").click();
    await until(async () => (await page.id("running-line").innerText()) !== first, "the next line");
    await mode(page, "program-state", "paused");
    await page.id("stop").click();
    await mode(page, "program-state", "stopped");
  },
  async "a breakpoint holds the program; its variables are seen, set, and led on"({ page, server }) {
    if (!(await hasDebugger(server))) return;
    await take(page);
    await page.id("program-name").fill("held.script");
    await edit(
      page,
      "def p():\n  n = 1\n  while n < 100:\n    n = n + 1\n    sleep(0.02)\n  end\n  textmsg('n is ', n)\nend\n",
    );
    await breakpointAt(page, 5);
    await until(() => page.id("debugger").isVisible(), "the debugger");
    await page.id("run").click();
    await until(
      async () => (await page.locator("[data-held]").innerText()).includes("sleep(0.02)"),
      "the line at which it is held",
    );
    const value = page.id("scopes").locator("[data-variable=n]");
    await until(async () => (await value.innerText()) === "2", "the variable");
    check((await page.text("stack")).includes("p"), "the stack");
    await page.id("debug-continue").click();
    await until(async () => (await value.innerText()) === "3", "the next turn");
    await page.id("watch").fill("n * 100");
    await page.id("watch").press("Enter");
    await until(async () => (await page.text("watch-result")) === "300", "the expression");
    await value.click();
    await page.id("new-value").fill("99");
    await page.id("new-value").press("Enter");
    await until(async () => (await value.innerText()) === "99", "the new value");
    await breakpointAt(page, 5);
    await until(
      async () => (await page.text("log")).includes("n is 100"),
      "the program to go on, without its breakpoint",
    );
    await until(() => page.id("debugger").isHidden(), "the debugger to leave");
  },
  async "a breakpoint with a condition, and steps"({ page, server }) {
    if (!(await hasDebugger(server))) return;
    await take(page);
    await edit(
      page,
      "def p():\n" +
        "  def twice(x):\n" +
        "    y = 2 * x\n" +
        "    return y\n" +
        "  end\n" +
        "  for k in range(10):\n" +
        "    z = twice(k)\n" +
        "    sleep(0.01)\n" +
        "  end\n" +
        "end\n",
    );
    await page.id("editor").focus();
    await gutter(page, 7, { button: "right" });
    await page.id("bp-condition").fill("k == 4");
    await page.id("bp-condition").press("Enter");
    await until(async () => (await page.id("breakpoint").count()) === 1, "the breakpoint");
    await until(() => page.id("debugger").isVisible(), "the debugger");
    await page.id("run").click();
    await until(async () => (await page.locator("[data-held]").innerText()).includes("twice(k)"), "the line");
    await until(async () => (await page.id("scopes").locator("[data-variable=k]").innerText()) === "4", "the turn");
    await page.keyboard.press("F11");
    await until(async () => (await page.locator("[data-held]").innerText()).includes("2 * x"), "the callee");
    await page.id("debug-out").click();
    await until(async () => /twice\(k\)|sleep/.test(await page.locator("[data-held]").innerText()), "the caller");
    // Who gives control up debugs no more: the program goes on to its end.
    await page.id("take-control").click();
    await until(async () => (await server.state()).program_state === "stopped", "the end");
  },
};

/**
 * Servers that were built without the debugger's channel have no breakpoints, and their pages show no gutter for them.
 */
async function hasDebugger(server) {
  const { ok } = await fetch(`${server.base}/api/v1/debug`);
  if (!ok) console.log("      skipped: this server has no debugger's channel");
  return ok;
}

/** Clicks left of a line number. */
async function gutter(page, line, options = {}) {
  const row = page.locator(".cm-lineNumbers .cm-gutterElement", { hasText: new RegExp(`^${line}$`) });
  await row.scrollIntoViewIfNeeded();
  const [box, column] = [await row.boundingBox(), await page.locator(".cm-breakpoints").boundingBox()];
  await page.mouse.click(column.x + column.width / 2, box.y + box.height / 2, options);
}

async function breakpointAt(page, line) {
  const before = await page.id("breakpoint").count();
  await gutter(page, line);
  await until(async () => (await page.id("breakpoint").count()) !== before, "the breakpoint");
}
