// Bundles the extension into dist/extension.js; `vscode` is what the editor provides.
import { build } from "esbuild";

await build({
  entryPoints: ["src/extension.ts"],
  bundle: true,
  platform: "node",
  format: "cjs",
  target: "node20",
  external: ["vscode"],
  outfile: "dist/extension.js",
  minify: true,
  legalComments: "eof",
  logLevel: "error",
});
