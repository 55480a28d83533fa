// Bundles and runs the unit tests: `npm run unit`.
import { build } from "esbuild";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";

const here = path.dirname(new URL(import.meta.url).pathname);
const out = mkdtempSync(path.join(tmpdir(), "unit-"));
const entryPoints = readdirSync(path.join(here, "unit")).map((name) => path.join(here, "unit", name));
await build({
  entryPoints,
  bundle: true,
  platform: "node",
  format: "esm",
  outdir: out,
  outExtension: { ".js": ".mjs" },
  logLevel: "error",
  loader: { ".css": "empty" },
  banner: { js: `const PAGE = ${JSON.stringify(path.join(here, "src"))};` },
});
const files = readdirSync(out).map((name) => path.join(out, name));
const ran = spawnSync(process.execPath, ["--test", ...files], { stdio: "inherit" });
rmSync(out, { recursive: true });
process.exit(ran.status ?? 1);
