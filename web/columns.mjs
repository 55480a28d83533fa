// No line of sources has more columns than the formatter aims at, which leaves comments, texts, styles and markup as
// long as they are: `node columns.mjs FOLDER`.
import { readdirSync, readFileSync } from "node:fs";
import path from "node:path";

const COLUMNS = 120;
const SOURCES = new Set([".ts", ".mjs", ".js", ".css", ".html"]);
const OTHERS = new Set(["node_modules", "dist"]);

/** The sources of a folder and of those in it. */
function sources(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const found = path.join(folder, entry.name);
    if (entry.isDirectory()) return OTHERS.has(entry.name) ? [] : sources(found);
    return SOURCES.has(path.extname(entry.name)) ? [found] : [];
  });
}

const folder = process.argv[2];
if (!folder) {
  console.error("usage: node columns.mjs FOLDER");
  process.exit(2);
}
const files = sources(folder);
if (files.length === 0) {
  console.error(`${folder} has no sources`);
  process.exit(2);
}
let isLong = false;
for (const file of files) {
  readFileSync(file, "utf8")
    .split("\n")
    .forEach((line, index) => {
      // Characters, as people count them, not units of UTF-16.
      const columns = [...line].length;
      if (columns <= COLUMNS) return;
      isLong = true;
      console.error(`${file}:${index + 1}: ${columns} columns, at most ${COLUMNS} are allowed`);
    });
}
process.exit(isLong ? 1 : 0);
