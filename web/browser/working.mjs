// Several pages, files, the editor, languages, time, and what must not be possible.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import {
  attribute,
  check,
  edit,
  hold,
  holdBack,
  mode,
  MOVES,
  near,
  open,
  press,
  sleep,
  stands,
  take,
  until,
} from "./harness.mjs";

export const scenarios = {
  async "another page looks on"({ page, server, browser }) {
    await take(page);
    const other = await open(browser, server);
    check(await other.id("jog-j1-plus").isDisabled(), "it may jog");
    const before = await other.value("q-1");
    await hold(page, "jog-j1-plus", async () => Math.abs((await other.value("q-1")) - before) > 0.01);
    await other.close();
  },
  async "another page takes control"({ page, server, browser }) {
    await take(page);
    const other = await open(browser, server);
    await take(other);
    await until(
      async () => (await attribute(page, "take-control", "aria-pressed")) === "false",
      "the first to lose it",
    );
    check(await page.id("jog-j1-plus").isDisabled(), "it may jog");
    check((await attribute(page, "take-control", "title")).includes("has control"), "who has it");
    await other.close();
  },
  async "who loses control while jogging stops"({ page, server, browser }) {
    await take(page);
    const other = await open(browser, server);
    await press(page, "jog-j1-plus", async () => (await server.state()).actual_qd[0] > 0.05, "the jog");
    await take(other);
    await stands(server);
    await page.mouse.up();
    await other.close();
  },
  async "a program is saved, listed and opened"({ page, server }) {
    await edit(page, "def saved():\n  sync()\nend\n");
    await page.id("program-name").fill("sub/saved.script");
    await page.id("save").click();
    await until(async () => (await page.locator(".toast").allInnerTexts()).join().includes("Saved"), "the notice");
    check(readFileSync(path.join(server.folder, "tasks/sub/saved.script"), "utf8").includes("saved"), "the file");
    await page.id("new").click();
    await page.id("open").click();
    await page.locator(".file", { hasText: "sub/saved.script" }).click();
    await until(async () => (await page.text("editor")).includes("def saved"), "the text");
  },
  async "a name that leads out of the folder is refused"({ page }) {
    await page.id("program-name").fill("../out.script");
    await page.id("save").click();
    await until(async () => (await page.locator(".toast.error").allInnerTexts()).join().length > 0, "the reason");
  },
  async "what somebody else has saved is not overwritten unseen"({ page, server, browser }) {
    const file = path.join(server.folder, "tasks/shared.script");
    writeFileSync(file, "sync()\n");
    const other = await open(browser, server);
    for (const one of [page, other]) {
      await one.id("open").click();
      await one.locator(".file", { hasText: "shared.script" }).click();
      await until(async () => (await one.text("editor")).includes("sync"), "the text");
    }
    await edit(page, "first = 1\n");
    await page.id("save").click();
    await until(() => readFileSync(file, "utf8").includes("first"), "the first");
    await edit(other, "second = 2\n");
    await other.id("save").click();
    await until(async () => (await other.locator("dialog").innerText()).includes("Somebody else"), "the question");
    check(readFileSync(file, "utf8").includes("first"), "it was overwritten");
    await other.locator("[data-choice=theirs]").click();
    await until(async () => (await other.text("editor")).includes("first"), "their text");
    await edit(other, "third = 3\n");
    writeFileSync(file, "fourth = 4\n");
    await other.id("save").click();
    await other.locator("[data-choice=mine]").click();
    await until(() => readFileSync(file, "utf8").includes("third"), "the overwriting");
    await other.close();
  },
  async "unsaved text is not lost without a question"({ page, server }) {
    writeFileSync(path.join(server.folder, "tasks/a.script"), "sync()\n");
    await edit(page, "mine = 1\n");
    await page.id("open").click();
    await page.locator(".file", { hasText: "a.script" }).first().click();
    await until(async () => (await page.locator("dialog").innerText()).includes("Discard it?"), "the question");
    await page.locator("dialog [data-choice='']").click();
    check((await page.text("editor")).includes("mine"), "it is gone");
  },
  async "findings are shown in place and go when corrected"({ page }) {
    await edit(page, "def p():\n  movejj([0, 0, 0, 0, 0, 0])\nend\n");
    await until(async () => (await page.text("problems")).includes("movejj"), "the finding");
    await until(async () => (await page.locator(".cm-lintRange").count()) > 0, "the mark");
    await edit(page, "def p():\n  sync()\nend\n");
    await until(async () => (await page.text("problems")).includes("No problems"), "the list to be empty");
  },
  async "completion offers the robot's functions"({ page }) {
    await edit(page, "");
    await page.id("editor").focus();
    await page.keyboard.type("get_inverse_k", { delay: 5 });
    await until(
      async () => (await page.locator(".cm-tooltip-autocomplete").innerText()).includes("get_inverse_kin"),
      "the offer",
    );
    await sleep(120);
    await page.keyboard.press("Enter");
    await until(async () => (await page.text("editor")).startsWith("get_inverse_kin"), "the text");
  },
  async "completion knows attributes and names of the program"({ page }) {
    await edit(page, "parts = []\nparts.app");
    await page.id("editor").focus();
    await page.keyboard.press("Control+End");
    await page.keyboard.type("e");
    await until(
      async () => (await page.locator(".cm-tooltip-autocomplete").innerText()).includes("append"),
      "the method",
    );
  },
  async "a call that is being written is explained, and Escape takes it away"({ page }) {
    await edit(page, "");
    await page.id("editor").focus();
    await page.keyboard.type("movej([0, 0, 0, 0, 0, 0], a=1.4, v=", { delay: 2 });
    await until(async () => (await page.id("call").locator("pre b").innerText()).startsWith("v"), "the parameter");
    await page.keyboard.press("Escape");
    await until(async () => (await page.id("call").count()) === 0, "it to go");
    check((await page.text("editor")).startsWith("movej("), "the text");
  },
  async "a call whose explanation comes late stays away after Escape"({ page }) {
    await edit(page, "");
    await page.id("editor").focus();
    await page.keyboard.type("movej([0, 0, 0, 0, 0, 0], a=", { delay: 2 });
    await until(async () => (await page.id("call").locator("pre b").innerText()).startsWith("a"), "the parameter");
    const held = await holdBack(page, "**/api/v1/call");
    await page.keyboard.type("1");
    await held.asked();
    await page.keyboard.press("Escape");
    await held.answer();
    check((await page.id("call").count()) === 0, "it came back");
    await page.keyboard.type("4");
    await until(async () => (await page.id("call").count()) === 1, "the explanation, asked anew");
  },
  async "a finding is corrected by a click"({ page }) {
    await edit(page, "# 🤖\nmvoej([0, 0, 0, 0, 0, 0])\n");
    await page.id("fix").first().click();
    await until(async () => (await page.text("editor")).includes("movej(["), "the correction");
    await until(async () => (await page.text("problems")).includes("No problems"), "no finding");
  },
  async "the wheel and a box zoom the plot, a double click ends it"({ page, server }) {
    await server.run(MOVES);
    await until(async () => Number(await page.id("timeline").getAttribute("max")) > 2, "some time");
    const over = page.locator("#plot .u-over");
    await over.hover({ position: { x: 300, y: 40 } });
    await page.mouse.wheel(0, -600);
    await until(async () => (await page.id("window").inputValue()) === "zoom", "the zoom");
    await over.dblclick({ position: { x: 300, y: 40 } });
    await until(async () => (await page.id("window").inputValue()) !== "zoom", "its end");
    const box = await over.boundingBox();
    await page.mouse.move(box.x + box.width * 0.5, box.y + 30);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.8, box.y + 40, { steps: 5 });
    await page.mouse.up();
    await until(async () => (await page.id("window").inputValue()) === "zoom", "the zoom by a box");
    check((await attribute(page, "live", "aria-pressed")) === "false", "a box is a look at the past");
  },
  async "a function tells its signature"({ page }) {
    await edit(page, "movej([0, 0, 0, 0, 0, 0])\n");
    await until(async () => {
      // Somebody who points at a word does not hold quite still.
      for (const x of [12, 24])
        await page
          .locator(".cm-line")
          .first()
          .hover({ position: { x, y: 8 } });
      await sleep(500);
      return (
        (await page.locator(".hover").count()) > 0 && (await page.locator(".hover").innerText()).includes("movej(")
      );
    }, "the signature");
  },
  async "a point is taught into the program"({ page, server }) {
    await edit(page, "");
    await page.id("teach").click();
    const q = (await server.state()).actual_q;
    await until(
      async () =>
        (await page.text("editor")).includes(
          `movej([${q[0].toFixed(2) === "-0.00" ? "0.0" : q[0].toFixed(2).slice(0, 3)}`,
        ),
      "the point",
    );
  },
  async "nodes of a task are an outline, and the node is marked"({ page }) {
    await take(page);
    await edit(page, 'def p():\n  $ LINE: (1, "Approach")\n  sleep(3)\n  $ LINE: (2, "Grip <b>")\n  sleep(3)\nend\n');
    await until(async () => (await page.text("nodes")).length > 0, "the outline");
    check((await page.text("nodes")).includes("Grip <b>"), await page.text("nodes"));
    await page.id("run").click();
    await until(async () => (await page.locator("#nodes .here").innerText()).includes("Approach"), "the node");
    await page.id("stop").click();
  },
  async "variables of the program are shown"({ page, server }) {
    await server.run("def p():\n  global parts\n  parts = 41\n  sleep(0.3)\n  parts = parts + 1\n  sleep(0.3)\nend\n");
    await until(
      async () => (await page.text("variables")).includes("parts") && (await page.text("variables")).includes("42"),
      "the variable",
    );
  },
  async "Chinese, remembered"({ page }) {
    await page.id("language").click();
    check((await page.text("connection")) === "已连接", await page.text("connection"));
    check((await page.text("take-control")) === "获取控制权", await page.text("take-control"));
    check((await page.text("robot-mode")) === "正常运行", await page.text("robot-mode"));
    const left = await page.evaluate(() =>
      [...document.querySelectorAll("[data-t]")]
        .filter((e) => e.textContent && /^[A-Za-z ]{4,}$/.test(e.textContent) && e.dataset.t !== "language")
        .map((e) => e.dataset.t),
    );
    check(left.length === 0, left.join());
    await page.reload();
    await page.connected();
    check((await page.text("connection")) === "已连接", "it is forgotten");
    await page.id("language").click();
    check((await page.text("connection")) === "connected", "and back");
  },
  async "light and dark"({ page }) {
    const before = await page.evaluate(() => document.documentElement.dataset.theme);
    await page.id("theme").click();
    check((await page.evaluate(() => document.documentElement.dataset.theme)) !== before, "the theme");
  },
  async "back in time, and live again"({ page, server }) {
    await take(page);
    const before = (await server.state()).time;
    const first = (await server.state()).actual_q[0];
    await hold(page, "jog-j1-plus", async () => (await server.state()).actual_q[0] > first + 0.05);
    await stands(server);
    const now = (await server.state()).actual_q[0];
    await until(
      async () => Math.abs((await page.value("q-1")) - now) < 1e-3,
      "the page to have seen the end of the jog",
    );
    await page.id("timeline").fill(String(Math.max(0, before - 0.05)));
    await until(async () => Math.abs((await page.value("q-1")) - now) > 0.01, "the earlier moment");
    check(await page.id("jog-j1-plus").isDisabled(), "the past is jogged");
    await until(async () => Math.abs(Number(await page.text("time")) - before) < 0.5, "the time of that moment");
    await page.id("live").click();
    await until(async () => Math.abs((await page.value("q-1")) - now) < 5e-3, "the present");
  },
  async "what came before somebody went back in time is not shown after"({ page, server }) {
    await take(page);
    const first = (await server.state()).actual_q[0];
    const before = (await server.state()).time;
    await hold(page, "jog-j1-plus", async () => (await server.state()).actual_q[0] > first + 0.05);
    await stands(server);
    // A page that is drawn late.
    await page.evaluate(() => {
      const draw = globalThis.requestAnimationFrame.bind(globalThis);
      globalThis.requestAnimationFrame = (act) => setTimeout(() => draw(act), 400);
    });
    await sleep(500);
    await page.id("timeline").fill(String(Math.max(0, before - 0.05)));
    await until(async () => Math.abs((await page.value("q-1")) - first) < 0.01, "the earlier moment");
    await sleep(600);
    near(await page.value("q-1"), first, 0.01, "joint 1 in the past");
  },
  async "the past is played, at a rate"({ page }) {
    await page.id("rate").selectOption("5");
    // Played faster than it comes to be, the past soon ends.
    await until(async () => Number(await page.id("timeline").getAttribute("max")) > 2, "a past to play");
    await page.id("timeline").fill("0.5");
    await until(async () => Math.abs(Number(await page.text("time")) - 0.5) < 0.01, "the beginning");
    const first = Number(await page.text("time"));
    await page.id("replay-play").click();
    await until(async () => Number(await page.text("time")) > first + 1, "time to pass");
    await page.id("live").click();
  },
  async "speeds, torques and force are plotted"({ page }) {
    for (const name of ["plot-qd", "plot-torque", "plot-force", "plot-q"]) {
      await page.id(name).click();
      check((await attribute(page, name, "aria-checked")) === "true", name);
      check((await page.locator("#plot canvas").count()) === 1, "a canvas");
    }
  },
  async "everything by keyboard alone: control, run, stop"({ page }) {
    await page.id("take-control").focus();
    await page.keyboard.press("Enter");
    await until(async () => (await attribute(page, "take-control", "aria-pressed")) === "true", "control");
    await edit(page, MOVES);
    await page.id("editor").press("Escape");
    await page.id("run").focus();
    await page.keyboard.press("Enter");
    await mode(page, "program-state", "running");
    await page.keyboard.press("Shift+Escape");
    await mode(page, "program-state", "stopped");
  },
  async "every button can be reached and has a name"({ page }) {
    await take(page);
    const nameless = await page.evaluate(() =>
      [...document.querySelectorAll("button, input, select")]
        .filter(
          (e) => !(e.textContent?.trim() || e.getAttribute("aria-label") || e.closest("label")?.textContent?.trim()),
        )
        .map((e) => e.outerHTML.slice(0, 80)),
    );
    check(nameless.length === 0, nameless.join());
    const seen = new Set();
    for (let k = 0; k < 46; k++) {
      // Back over what stands before it, then on.
      await page.keyboard.press(k < 6 ? "Shift+Tab" : "Tab");
      seen.add(await page.evaluate(() => document.activeElement?.getAttribute("data-testid")));
    }
    for (const name of ["power-off", "stop", "language", "speed"]) check(seen.has(name), `${name} is not reached`);
  },
  async "no rule of accessibility is broken, light and dark"({ server, browser }) {
    const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
    for (const colorScheme of ["dark", "light"]) {
      const page = await open(browser, server, { colorScheme, reducedMotion: "reduce" });
      await take(page);
      // Something of everything: findings, an alarm, a popup.
      await edit(page, "x = undefined_name\n");
      await until(async () => (await page.text("problems")).includes("undefined_name"), "the finding");
      await server
        .order({ do: "run", name: "a.script", text: "popup('ready?', 'Question')\n1 / 0\n" })
        .catch(() => undefined);
      await page.id("run").click();
      await page.id("alarm").waitFor();
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() =>
        globalThis.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21aa", "best-practice"] }),
      );
      const told = violations.map(
        (one) =>
          `${one.id}: ${one.nodes
            .slice(0, 3)
            .map((node) => `${node.target.join(" ")} ${(node.any[0] ?? node.all[0] ?? node.none[0])?.message ?? ""}`)
            .join(" | ")}`,
      );
      check(told.length === 0, `${colorScheme}: ${told.join("; ")}`);
      await page.context().close();
    }
  },
  async "nothing is cut off on a tablet"({ browser, server }) {
    for (const viewport of [
      { width: 820, height: 1180 },
      { width: 1024, height: 768 },
      { width: 820, height: 600 },
    ]) {
      const page = await open(browser, server, { viewport });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      check(wide <= 0, `${wide} px too wide at ${viewport.width}`);
      const box = await page.id("stop").boundingBox();
      check(box.height >= 40 && box.width >= 80, "the stop button is small");
      // Also where the panels are scrolled to their end.
      await page.id("log").scrollIntoViewIfNeeded();
      const still = await page.id("stop").boundingBox();
      check(still.y >= 0 && still.y + still.height <= viewport.height, "the stop button is scrolled away");
      await page.context().close();
    }
  },
  async "a page that sends rubbish is answered and goes on"({ page, server }) {
    const said = await page.evaluate(async (base) => {
      const socket = new WebSocket(`${base.replace("http", "ws")}/api/v1/live`);
      const answers = [];
      socket.onmessage = (message) =>
        typeof message.data === "string" && message.data.includes("answer") && answers.push(JSON.parse(message.data));
      await new Promise((done) => (socket.onopen = done));
      socket.send("{");
      socket.send(JSON.stringify({ id: 4, order: { do: "dance" } }));
      socket.send(JSON.stringify({ id: 5, order: { do: "power_off" } }));
      socket.send(JSON.stringify({ id: 6, token: "wrong" }));
      for (let k = 0; k < 100 && answers.length < 4; k++) await new Promise((done) => setTimeout(done, 20));
      socket.close();
      return answers;
    }, server.base);
    check(said.length === 4 && said.every((answer) => !answer.ok), JSON.stringify(said));
    check(said[2].error.includes("token"), said[2].error);
    check((await server.state()).robot_mode === "RUNNING", "it was done");
  },
  async "a program's order needs the token and a free desk"({ page, server }) {
    const bare = await fetch(`${server.base}/api/v1/orders`, {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: '{"do":"power_off"}',
    });
    check(bare.status === 401, `${bare.status}`);
    await take(page);
    const busy = await server.order({ do: "speed", fraction: 0.5 });
    check(busy.status === 409 && busy.error.includes("has control"), JSON.stringify(busy));
    check((await server.order({ do: "stop" })).ok, "stop is always free");
  },
};
