// Runs every scenario; `node browser/run.mjs PATTERN` those whose name has the pattern.
//
// Each has a server and a context of the browser to itself, so that none knows of another; LANES of them go on side by
// side.
import { existsSync } from "node:fs";
import path from "node:path";
import { scenarios as withServers } from "./alone.mjs";
import { scenarios as living } from "./cell.mjs";
import { BINARY, CHROMIUM, Server, belonging, check, launch, open } from "./harness.mjs";
import { scenarios as moving } from "./moving.mjs";
import { scenarios as operating, special } from "./operating.mjs";
import { scenarios as paths } from "./paths.mjs";
import { scenarios as running } from "./running.mjs";
import { scenarios as working } from "./working.mjs";

if (!CHROMIUM || !existsSync(BINARY)) {
  console.error(
    CHROMIUM
      ? `there is no ${BINARY}; build it or set ELITESERVER`
      : "there is no Chromium; install it or set CHROMIUM",
  );
  process.exit(2);
}
/** A table that can be run into, soft enough to be felt. */
const CELL = path.join(path.dirname(new URL(import.meta.url).pathname), "cell.toml");
const alone = { ...withServers, ...living, ...special, ...paths };
const LANES = Number(process.env.LANES ?? 3);
const wanted = new RegExp(process.argv[2] ?? "");
const begin = Date.now();

// Those that take long come first, so that no lane ends alone.
const queue = [...Object.entries(alone), ...Object.entries({ ...operating, ...working, ...running, ...moving })].filter(
  ([name]) => wanted.test(name),
);
const browser = await launch({ flat: true });
let drawn;
/** Drawing in software takes most of a small machine: only what is about the 3D view is tried with it. */
const drawing = () => (drawn ??= launch());
const failed = [];
let passed = 0;

async function scenario(name, act) {
  const started = Date.now();
  const seconds = () => ((Date.now() - started) / 1000).toFixed(1).padStart(5);
  try {
    await belonging(async (own) => {
      if (name in alone) await act({ browser, drawing });
      else {
        const server = await Server.start(["--cell", CELL]);
        await act({ page: await open(browser, server), server, browser });
      }
      const complaints = own.pages.flatMap((page) => page.complaints);
      check(complaints.length === 0, `the page complains: ${complaints.join("; ")}`);
    });
    passed += 1;
    console.log(`ok    ${seconds()} s  ${name}`);
  } catch (error) {
    failed.push(name);
    console.log(`FAIL  ${seconds()} s  ${name}\n      ${error.message.split("\n")[0]}`);
  }
}

async function lane() {
  for (let next = queue.shift(); next; next = queue.shift()) await scenario(...next);
}
await Promise.all(Array.from({ length: LANES }, lane));
await Promise.all([browser.close(), drawn?.then((one) => one.close())]);
console.log(`${passed} passed, ${failed.length} failed in ${((Date.now() - begin) / 1000).toFixed(0)} s`);
process.exit(failed.length === 0 ? 0 : 1);
