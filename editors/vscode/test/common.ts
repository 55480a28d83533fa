// What the tests share: where things are, and a folder of their own.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";

export const EXTENSION = process.env["EXTENSION"] ?? ".";
export const ELITESERVER = process.env["ELITESERVER"] ?? "eliteserver";

/** A file of the extension, as JSON. */
export function json(name: string): Record<string, unknown> {
  return JSON.parse(readFileSync(path.join(EXTENSION, name), "utf8")) as Record<string, unknown>;
}

/** A folder that goes with the test. */
export function folder(after: (end: () => void) => void): string {
  const made = mkdtempSync(path.join(tmpdir(), "elitescript-test-"));
  after(() => rmSync(made, { recursive: true, force: true }));
  return made;
}

/** A file with a text; its path. */
export function file(inFolder: string, name: string, text: string): string {
  const made = path.join(inFolder, name);
  writeFileSync(made, text);
  return made;
}
