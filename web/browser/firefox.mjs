// The page in Firefox, over WebDriver BiDi: it loads, draws, shows the arm, jogs, and complains of nothing.
// `node browser/firefox.mjs`.
import { existsSync } from "node:fs";
import puppeteer from "puppeteer-core";
import { Server, check, sleep, until } from "./harness.mjs";

const FIREFOX = process.env.FIREFOX ?? ["/usr/bin/firefox-esr", "/usr/bin/firefox"].find((file) => existsSync(file));
if (!FIREFOX) {
  console.log("skipped: there is no Firefox; install firefox-esr or set FIREFOX");
  process.exit(0);
}
const server = await Server.start();
const browser = await puppeteer.launch({
  browser: "firefox",
  executablePath: FIREFOX,
  headless: true,
  protocolTimeout: 120000,
  extraPrefsFirefox: { "webgl.force-enabled": true },
});
try {
  const page = await browser.newPage();
  await page.setViewport({ width: 1280, height: 720 });
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("console", (message) => {
    // Without a graphics card Firefox says that WebGL is slow; that is the machine's, not the page's.
    if (message.type() === "error" && !/WebGL|WebSocket/.test(message.text())) complaints.push(message.text());
  });
  await page.goto(server.base);
  const value = (id, name) =>
    page.$eval(`[data-testid=${id}]`, (element, key) => element.dataset[key] ?? element.value, name);
  await until(async () => (await value("connection", "value")) === "connected", "the connection");
  await until(async () => (await value("robot-mode", "value")) === "RUNNING", "the state");
  const isDrawn = await until(
    () => page.evaluate(() => globalThis.eliteserver.drawn() > 0 || !document.getElementById("no-webgl").hidden),
    "the 3D view",
  );
  check(isDrawn, "no 3D view and no word about it");
  await page.click("[data-testid=take-control]");
  await page.waitForSelector("[data-testid=jog-j1-plus]:not([disabled])");
  const before = (await server.state()).actual_q[0];
  const box = await (await page.$("[data-testid=jog-j1-plus]")).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await until(async () => (await server.state()).actual_q[0] > before + 0.02, "the jog");
  await page.mouse.up();
  await until(async () => Math.abs((await server.state()).actual_qd[0]) < 1e-3, "the arm to stand");
  // A program is written with completion, run, and followed.
  await page.click("[data-testid=editor]");
  await page.keyboard.down("Control");
  await page.keyboard.press("a");
  await page.keyboard.up("Control");
  await page.keyboard.type("global n\nn = 42\nsle");
  await page.waitForSelector(".cm-tooltip-autocomplete");
  await page.keyboard.press("Enter");
  await page.keyboard.type("(0.5)");
  await page.click("[data-testid=run]");
  await until(
    () => page.$eval("[data-testid=variables]", (element) => element.textContent.includes("42")),
    "the variable",
  );
  await page.$eval(
    "[data-testid=timeline]",
    (element) => ((element.value = String(Number(element.min))), element.dispatchEvent(new Event("input"))),
  );
  await until(() => page.evaluate(() => document.body.classList.contains("past")), "the past");
  await page.click("[data-testid=live]");
  const drawn = await page.evaluate(() =>
    document.getElementById("no-webgl").hidden ? "drawn in 3D" : "without WebGL",
  );
  if (process.argv[2]) await page.screenshot({ path: process.argv[2] });
  await sleep(200);
  check(complaints.length === 0, `Firefox complains: ${complaints.join("; ")}`);
  console.log(`ok    the page in ${await browser.version()}, ${drawn}`);
} catch (error) {
  console.log(`FAIL  the page in Firefox: ${error.message}`);
  process.exitCode = 1;
} finally {
  await browser.close();
  await server.end();
}
