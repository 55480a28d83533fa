// Figures of docs/BENCHMARKS.md: bytes, time to the first frame (a first and a later visit), how late frames come with
// eight pages, the control cycle with and without them, how long a jog takes to stop. Says the load of the machine and
// which build was measured: `ELITESERVER=target/release/eliteserver node browser/measure.mjs`.
import { cpus, loadavg } from "node:os";
import { BINARY, MOVES, Server, launch, open, stands, take, until } from "./harness.mjs";

const PAGES = 8;
const WATCHED_MS = 8000;
const STOPS = 12;
/** Bytes of a frame. */
const FRAME = 392;

const quantile = (values, q) =>
  [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * q))];
const ms = (value) => `${value.toFixed(1)} ms`;
const say = (what, value, bound = "") => console.log(`${what.padEnd(52)} ${value}${bound && `   (bound ${bound})`}`);

say("build", BINARY);
say(
  "processors; load of 1, 5, 15 minutes",
  `${cpus().length}; ${loadavg()
    .map((load) => load.toFixed(1))
    .join(", ")}`,
);
const server = await Server.start();
// The 3D view is left out: in software it would be measured instead of what is asked for.
const flat = await launch({ flat: true });

async function visit(context) {
  const page = await context.newPage();
  const files = new Map();
  page.on("response", async (response) => {
    const name = new URL(response.url()).pathname;
    const bytes = await response
      .request()
      .sizes()
      .then(
        (sizes) => sizes.responseBodySize,
        () => 0,
      );
    if (!name.startsWith("/api")) files.set(name, bytes);
  });
  await page.goto(server.base);
  await page.waitForFunction(() => performance.getEntriesByName("first-frame").length > 0);
  await page.waitForLoadState("networkidle").catch(() => undefined);
  const firstFrame = await page.evaluate(() => performance.getEntriesByName("first-frame")[0].startTime);
  await page.close();
  return { firstFrame, files };
}
const context = await flat.newContext();
// The browser's own beginning is not the page's.
await (await context.newPage()).goto("about:blank");
const first = await visit(context);
const later = await visit(context);
await context.close();
for (const [name, bytes] of first.files) say(`bytes of ${name}`, String(bytes));
say("bytes of the page in all", String([...first.files.values()].reduce((sum, bytes) => sum + bytes, 0)), "700000");
say("first frame of a first visit after", ms(first.firstFrame));
say("first frame of a later visit after", ms(later.firstFrame));

const metrics = async () => (await fetch(`${server.base}/metrics`)).text();
const figure = (text, name) => Number(new RegExp(`^${name}(?:\\{[^}]*\\})? (\\S+)`, "m").exec(text)?.[1]);
/** Seconds below which so many of the cycles lay between two looks at the histogram, as far as its buckets tell. */
function cycleQuantile(before, after, q) {
  const buckets = (text) =>
    [...text.matchAll(/^elite_cycle_duration_seconds_bucket\{[^}]*le="([^"]+)"[^}]*\} (\S+)/gm)].map(
      ([, le, count]) => [Number(le.replace("+Inf", "Infinity")), Number(count)],
    );
  const [old, now] = [buckets(before), buckets(after)];
  const counts = now.map(([le, count], k) => [le, count - (old[k]?.[1] ?? 0)]);
  const all = counts.at(-1)?.[1] ?? 0;
  return counts.find(([, count]) => count >= all * q)?.[0];
}
/**
 * Durations of cycles, ms, of the frames that the server keeps of a span of time: 20 a second, and 60 while a page
 * looks.
 */
async function sampledCycles(from, to) {
  const frames = new DataView(
    await (await fetch(`${server.base}/api/v1/history?from=${from}&to=${to}&points=4000`)).arrayBuffer(),
  );
  return Array.from(
    { length: Math.floor(frames.byteLength / FRAME) },
    (_, k) => frames.getFloat32(k * FRAME + 388, true) / 1000,
  );
}
/** The cycles while something is done. */
async function cyclesWhile(what, act) {
  const [before, from] = [await metrics(), (await server.state()).time];
  const value = await act();
  const [after, to] = [await metrics(), (await server.state()).time];
  const sampled = await sampledCycles(from, to);
  const fine = (q) => `${quantile(sampled, q).toFixed(3)} ms`;
  say(`cycles ${what}: p50; p90; p99`, `${fine(0.5)}; ${fine(0.9)}; ${fine(0.99)}   of ${sampled.length} sampled`);
  say(`99 % of the cycles ${what} within`, ms(1000 * cycleQuantile(before, after, 0.99)));
  const grown = (name) => figure(after, name) - figure(before, name);
  say(
    `overruns; missed cycles ${what}`,
    `${grown("elite_cycle_overruns_total")}; ${grown("elite_cycles_missed_total")}`,
    "0; 0",
  );
  return value;
}

await server.run(MOVES);
await cyclesWhile("without a page", () => new Promise((done) => setTimeout(done, WATCHED_MS)));
const pages = await cyclesWhile(`while ${PAGES} pages are opened`, async () => {
  const opened = [];
  for (let k = 0; k < PAGES; k++) opened.push(await open(flat, server));
  return opened;
});
const watched = (milliseconds) =>
  pages.map((page) =>
    page.evaluate(async (end) => {
      const found = [];
      let last = 0;
      end += performance.now();
      while (performance.now() < end) {
        const frame = globalThis.eliteserver.latest();
        if (frame && frame.sequence !== last) {
          last = frame.sequence;
          found.push(performance.timeOrigin + performance.now() - frame.wallMs);
        }
        await new Promise((done) => setTimeout(done, 2));
      }
      return found;
    }, milliseconds),
  );
const late = (await cyclesWhile(`with ${PAGES} pages`, () => Promise.all(watched(WATCHED_MS)))).flat();
say(
  `a pose is seen by one of ${PAGES} pages after: p50; p99`,
  `${ms(quantile(late, 0.5))}; ${ms(quantile(late, 0.99))}   of ${late.length} frames`,
);

await server.order({ do: "stop" });
await stands(server);
const [page, ...others] = pages;
for (const other of others) await other.close();
await take(page);
await page.id("jog-speed").fill("100");
const stops = [];
for (let k = 0; k < STOPS; k++) {
  const button = page.id(k % 2 ? "jog-j1-plus" : "jog-j1-minus");
  await until(() => button.isEnabled(), "the button");
  await button.hover();
  await page.mouse.down();
  await until(async () => Math.abs((await server.state()).actual_qd[0]) > 0.4, "the jog");
  const begin = performance.now();
  const released = page.mouse.up();
  while (Math.abs((await server.state()).actual_qd[0]) > 1e-3);
  stops.push(performance.now() - begin);
  await released;
}
say(
  `arm at rest after a full jog is let go, ${STOPS} times: p50; most`,
  `${ms(quantile(stops, 0.5))}; ${ms(Math.max(...stops))}`,
  "150 ms",
);
await flat.close();
await server.end();
