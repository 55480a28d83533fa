// Where a taught point goes in a program, and its line. Pure.

import { fixed } from "./dom";

/** `movej([…])` of a taught point. */
export function pointLine(q: readonly number[], name = ""): string {
  const comment = name.trim() === "" ? "" : `  # ${name.replace(/\s+/g, " ").trim()}`;
  return `movej([${q.map((x) => fixed(x, 5)).join(", ")}], a=1.4, v=1.0)${comment}`;
}

/** The code of a line: without its comment and blanks at its end. Quotes keep a `#`. */
function codeOf(line: string): string {
  let quote = "";
  for (let k = 0; k < line.length; k++) {
    const letter = line[k] ?? "";
    if (quote !== "") {
      if (letter === "\\") k += 1;
      else if (letter === quote) quote = "";
    } else if (letter === '"' || letter === "'") quote = letter;
    else if (letter === "#") return line.slice(0, k).trimEnd();
  }
  return line.trimEnd();
}

const indentOf = (line: string): string => /^[ \t]*/.exec(line)?.[0] ?? "";
const isBlank = (line: string): boolean => codeOf(line).trim() === "";

/**
 * Brackets that a line opens more often than it closes. Those in texts count as well, which does no harm where they are
 * balanced.
 */
function opened(line: string): number {
  const code = codeOf(line);
  return [...code].reduce((sum, letter) => sum + ("([{".includes(letter) ? 1 : ")]}".includes(letter) ? -1 : 0), 0);
}

export interface Spot {
  /** The line, from 0, that the new one replaces or follows. */
  line: number;
  replaces: boolean;
  indent: string;
}

/** Where a statement goes that is to stand at the cursor: in a blank line, or behind the statement of the line. */
export function spotFor(lines: readonly string[], cursor: number): Spot {
  const here = lines[cursor] ?? "";
  if (isBlank(here)) {
    let above = cursor - 1;
    while (above >= 0 && isBlank(lines[above] ?? "")) above -= 1;
    const replaces = here.trim() === "";
    return { line: cursor, replaces, indent: above < 0 ? "" : inside(lines, above) };
  }
  // A statement of several lines is not torn apart.
  let last = cursor;
  let depth = 0;
  for (let k = first(lines, cursor); k < lines.length; k++) {
    depth += opened(lines[k] ?? "");
    if (k >= cursor && depth <= 0) {
      last = k;
      break;
    }
  }
  return { line: last, replaces: false, indent: inside(lines, last) };
}

/** The first line of the statement that goes on in a line. */
function first(lines: readonly string[], line: number): number {
  let start = line;
  for (let k = line - 1, depth = 0; k >= 0 && !isBlank(lines[k] ?? ""); k--) {
    depth += opened(lines[k] ?? "");
    if (depth > 0) {
      start = k;
      depth = 0;
    }
  }
  return start;
}

/** The indentation of what comes behind a line: deeper after one that begins a block. */
function inside(lines: readonly string[], line: number): string {
  const start = lines[first(lines, line)] ?? "";
  const own = indentOf(start);
  if (!codeOf(lines[line] ?? "").endsWith(":")) return own;
  const next = lines.slice(line + 1).find((one) => !isBlank(one)) ?? "";
  const deeper = indentOf(next);
  return deeper.length > own.length && deeper.startsWith(own) ? deeper : `${own}  `;
}

const NUMBER = String.raw`[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?`;
const SIX = String.raw`\[\s*((?:${NUMBER}\s*,\s*){5}${NUMBER})\s*,?\s*\]`;

/**
 * Where a program goes first: the joints or the pose of its first motion that is written in numbers, or as a name with
 * numbers.
 */
export function firstTarget(text: string): { joints: number[] } | { pose: number[] } | null {
  const code = text.split("\n").map(codeOf).join("\n");
  const motion = new RegExp(String.raw`\bmove(j|l|p)\s*\(\s*(?:${SIX}|([A-Za-z_]\w*)\s*[,)])`).exec(code);
  if (!motion) return null;
  const [, kind, written, name] = motion;
  const value =
    written ??
    (name === undefined
      ? undefined
      : new RegExp(String.raw`^\s*(?:global\s+)?${name}\s*=\s*${SIX}`, "m").exec(code)?.[1]);
  if (value === undefined) return null;
  const six = value.split(",").map(Number);
  return kind === "j" ? { joints: six } : { pose: six };
}
