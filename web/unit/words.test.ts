import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { TABLES, isWord } from "../src/words";

declare const PAGE: string;

test("every language has every word, and the same places for what is given", () => {
  for (const [word, english] of Object.entries(TABLES.en)) {
    for (const table of Object.values(TABLES)) {
      const text = (table as Record<string, string>)[word];
      assert.ok(text !== undefined && text.trim() !== "", word);
      const places = (one: string): string[] => [...one.matchAll(/\{\w+\}/g)].map((match) => match[0]).sort();
      assert.deepEqual(places(text), places(english), word);
    }
  }
});

test("every word of the markup and of the code is in the table", () => {
  const html = readFileSync(path.join(PAGE, "index.html"), "utf8");
  const asked = [...html.matchAll(/data-(?:t|label)="(\w+)"/g)].map((match) => match[1] ?? "");
  assert.ok(asked.length > 50);
  for (const name of readdirSync(PAGE).filter((file) => file.endsWith(".ts") && file !== "words.ts")) {
    const code = readFileSync(path.join(PAGE, name), "utf8");
    for (const match of code.matchAll(/"data-(?:t|label)": "(\w+)"/g)) asked.push(match[1] ?? "");
    for (const match of code.matchAll(/[^\w.]t\("(\w+)"/g)) asked.push(match[1] ?? "");
  }
  assert.deepEqual(
    asked.filter((word) => !isWord(word)),
    [],
  );
});

test("the markup has no words of its own", () => {
  const html = readFileSync(path.join(PAGE, "index.html"), "utf8").replace(
    /<noscript>.*<\/noscript>|<title>.*<\/title>|<option[^>]*>[^<]*<\/option>/g,
    "",
  );
  const own = [...html.matchAll(/>([^<>]*[A-Za-z]{3,}[^<>]*)</g)]
    .map((match) => match[1]?.trim())
    .filter((text) => text !== "eliteserver" && text !== "connecting …");
  assert.deepEqual(own, []);
});
