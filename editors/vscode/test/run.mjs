// Bundles and runs the tests: `npm run unit`. ELITESERVER names the program; without it that of a debug build is used.
import { build } from "esbuild";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import path from "node:path";

const here = path.dirname(new URL(import.meta.url).pathname);
const root = path.join(here, "..");
const target = process.env.CARGO_TARGET_DIR ?? path.join(root, "../../target");
const eliteserver = process.env.ELITESERVER ?? path.join(target, "debug/eliteserver");
if (!existsSync(eliteserver)) {
  console.error(`${eliteserver} is not there; build it, or name one with ELITESERVER`);
  process.exit(2);
}
// Beside the packages, so that what is not bundled is found.
const out = mkdtempSync(path.join(root, "node_modules", ".unit-"));
const entryPoints = readdirSync(here)
  .filter((name) => name.endsWith(".test.ts"))
  .map((name) => path.join(here, name));
await build({
  entryPoints,
  bundle: true,
  packages: "external",
  platform: "node",
  format: "cjs",
  outdir: out,
  outExtension: { ".js": ".cjs" },
  logLevel: "error",
});
const files = readdirSync(out).map((name) => path.join(out, name));
const ran = spawnSync(process.execPath, ["--test", ...files], {
  stdio: "inherit",
  env: { ...process.env, ELITESERVER: eliteserver, EXTENSION: root },
});
rmSync(out, { recursive: true });
process.exit(ran.status ?? 1);
