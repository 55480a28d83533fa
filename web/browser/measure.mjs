// Figures of docs/BENCHMARKS.md: bytes, time to the first frame (a first and a later visit), how late frames come with eight pages,
// the control cycle with and without them, how long a jog takes to stop. Says the load of the machine and which build was measured.
import { loadavg } from "node:os";
import { BINARY, Server, launch, open, sleep, take, until } from "./harness.mjs";

const quantile = (values, q) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * q))];
console.log(`load ${loadavg().map((load) => load.toFixed(1)).join(" ")}, ${BINARY}`);
const server = await Server.start();
const flat = await launch({ flat: true });
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
const again = await context.newPage();
await again.goto(server.base);
await again.waitForFunction(() => performance.getEntriesByName("first-frame").length > 0);
console.log("first frame of a later visit after", await again.evaluate(() => Math.round(performance.getEntriesByName("first-frame")[0].startTime)), "ms");
await context.close();

/** Seconds below which so many of the cycles lay between two looks at the histogram, as far as its buckets tell. */
function cycleQuantile(before, after, q) {
  const buckets = (text) => [...text.matchAll(/^elite_cycle_duration_seconds_bucket\{[^}]*le="([^"]+)"[^}]*\} (\S+)/gm)].map(([, le, count]) => [Number(le.replace("+Inf", "Infinity")), Number(count)]);
  const [old, now] = [buckets(before), buckets(after)];
  const counts = now.map(([le, count], k) => [le, count - (old[k]?.[1] ?? 0)]);
  const all = counts.at(-1)?.[1] ?? 0;
  return counts.find(([, count]) => count >= all * q)?.[0];
}
const metrics = async () => (await fetch(`${server.base}/metrics`)).text();
await server.run("def p():\n  while True:\n    movej([0.5, -1.2, 1.4, -1.77, -1.57, 0], a=2, v=1)\n    movej([-0.5, -1.2, 1.4, -1.77, -1.57, 0], a=2, v=1)\n  end\nend\n");
const alone = await metrics();
await sleep(8000);
const aloneAfter = await metrics();
console.log("cycle without a page: p99 at most", cycleQuantile(alone, aloneAfter, 0.99), "s");
await server.order({ do: "stop" });

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
console.log("cycle with 8 pages: p99 at most", cycleQuantile(before, after, 0.99), "s");
await server.order({ do: "stop" });
await until(async () => Math.abs((await server.state()).actual_qd[0]) < 1e-3, "rest");
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
