// Figures of docs/BENCHMARKS.md: bytes, time to the first frame, how late frames come with eight pages, how long a jog takes to stop.
import { Server, launch, open, sleep, take, until } from "./harness.mjs";

const quantile = (values, q) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * q))];
const server = await Server.start();
const flat = await launch(["--disable-3d-apis"]);
const sizes = [];
const context = await flat.newContext();
const first = await context.newPage();
first.on("response", async (response) => {
  const bytes = await response.request().sizes().then((sizes) => sizes.responseBodySize, () => 0);
  sizes.push([new URL(response.url()).pathname, bytes]);
});
await first.goto(server.base);
await first.waitForFunction(() => performance.getEntriesByName("first-frame").length > 0);
console.log("first frame after", await first.evaluate(() => Math.round(performance.getEntriesByName("first-frame")[0].startTime)), "ms");
await sleep(500);
console.log("files:", sizes.filter(([name]) => !name.startsWith("/api")).map(([name, bytes]) => `${name} ${bytes}`).join(", "), "in all", sizes.filter(([name]) => !name.startsWith("/api")).reduce((sum, [, bytes]) => sum + bytes, 0));
await context.close();

const before = await (await fetch(`${server.base}/metrics`)).text();
const pages = [];
for (let k = 0; k < 8; k++) pages.push(await open(flat, server));
await server.run("def p():\n  while True:\n    movej([0.5, -1.2, 1.4, -1.77, -1.57, 0], a=2, v=1)\n    movej([-0.5, -1.2, 1.4, -1.77, -1.57, 0], a=2, v=1)\n  end\nend\n");
const late = (await Promise.all(pages.map((page) => page.evaluate(async () => {
  const found = [];
  let last = 0;
  const end = performance.now() + 8000;
  while (performance.now() < end) {
    const frame = globalThis.eliteserver.latest();
    if (frame && frame.sequence !== last) {
      last = frame.sequence;
      found.push(performance.timeOrigin + performance.now() - frame.wallMs);
    }
    await new Promise((done) => setTimeout(done, 2));
  }
  return found;
})))).flat();
console.log(`frames with 8 pages: ${late.length}, late by p50 ${quantile(late, 0.5).toFixed(1)} ms, p99 ${quantile(late, 0.99).toFixed(1)} ms`);
const after = await (await fetch(`${server.base}/metrics`)).text();
const figure = (text, name) => Number(new RegExp(`^${name}(?:\\{[^}]*\\})? (\\S+)`, "m").exec(text)?.[1]);
for (const name of ["elite_cycle_overruns_total", "elite_cycles_missed_total"]) console.log(name, figure(before, name), "before,", figure(after, name), "after");
await server.order({ do: "stop" });
await sleep(1000);
const page = pages[0];
for (const other of pages.slice(1)) await other.close();
await take(page);
await page.id("jog-speed").fill("100");
const stops = [];
for (let k = 0; k < 6; k++) {
  await page.id(k % 2 ? "jog-j1-plus" : "jog-j1-minus").hover();
  await page.mouse.down();
  await until(async () => Math.abs((await server.state()).actual_qd[0]) > 0.4, "the jog");
  const begin = performance.now();
  await page.mouse.up();
  await until(async () => Math.abs((await server.state()).actual_qd[0]) < 1e-3, "rest");
  stops.push(performance.now() - begin);
}
console.log("jog: at rest after release within", stops.map((ms) => ms.toFixed(0)).join(", "), "ms (looked at every 25 ms)");
await flat.close();
await server.end();
