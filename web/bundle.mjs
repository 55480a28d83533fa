// Bundles the page into the folder that is named: index.html, app.js.gz, view.js.gz, app.css.gz, icon.svg.gz.
// The 3D view is a file of its own, so that the state is there before it is.
import { build } from "esbuild";
import { readFile, writeFile, mkdir } from "node:fs/promises";
import { gzipSync } from "node:zlib";
import path from "node:path";

const out = process.argv[2];
if (!out) {
  console.error("usage: node bundle.mjs FOLDER");
  process.exit(2);
}
const here = path.dirname(new URL(import.meta.url).pathname);
const result = await build({
  entryPoints: { app: path.join(here, "src/main.ts"), view: path.join(here, "src/view.ts") },
  bundle: true,
  minify: true,
  format: "esm",
  target: ["chrome110", "firefox110", "safari16"],
  outdir: ".",
  write: false,
  legalComments: "eof",
  logLevel: "error",
});
await mkdir(out, { recursive: true });
const pack = (bytes) => gzipSync(bytes, { level: 9 });
for (const file of result.outputFiles) {
  const name = path.basename(file.path);
  if (["app.js", "view.js", "app.css"].includes(name)) {
    await writeFile(path.join(out, `${name}.gz`), pack(file.contents));
  }
}
await writeFile(path.join(out, "icon.svg.gz"), pack(await readFile(path.join(here, "src/icon.svg"))));
await writeFile(path.join(out, "index.html"), await readFile(path.join(here, "src/index.html")));
