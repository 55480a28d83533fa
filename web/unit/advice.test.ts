import assert from "node:assert/strict";
import { test } from "node:test";
import { Text } from "@codemirror/state";
import { charactersBefore, mayBeInCall, unitsBefore } from "../src/advice";

test("characters of the server and units of the editor are told apart", () => {
  const doc = Text.of(["# 🤖 中", "movej()"]);
  for (const [units, characters] of [
    [0, 0],
    [2, 2],
    [4, 3],
    [6, 5],
    [7, 6],
    [9, 8],
  ] as const) {
    assert.equal(charactersBefore(doc, units), characters);
    assert.equal(unitsBefore(doc, characters), units);
  }
});

test("a call is asked about only where a parenthesis is open", () => {
  assert.ok(mayBeInCall("movej([0, 0], a="));
  assert.ok(mayBeInCall("f(g(1), "));
  assert.ok(!mayBeInCall("f(g(1))"));
  assert.ok(!mayBeInCall("x = 1"));
});
