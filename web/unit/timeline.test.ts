import assert from "node:assert/strict";
import { test } from "node:test";
import { spread, wheeled, zoomed } from "../src/span";

test("the wheel zooms about the time under the pointer and moves along", () => {
  const [from, to] = wheeled([10, 20], 12, 0, -400);
  assert.ok(to - from < 10 && from > 10 && to < 20);
  assert.ok(Math.abs((12 - from) / (to - from) - 0.2) < 1e-9, "the time under the pointer stays there");
  const [back, forth] = wheeled(wheeled([10, 20], 12, 0, -400), 12, 0, 400);
  assert.ok(Math.abs(back - 10) < 1e-9 && Math.abs(forth - 20) < 1e-9);
  assert.deepEqual(wheeled([10, 20], 12, 500, 0), [15, 25]);
});

test("a span stays within what there is and is never empty", () => {
  assert.deepEqual(zoomed([-5, 5], 0, 100), [0, 10]);
  assert.deepEqual(zoomed([95, 105], 0, 100), [90, 100]);
  assert.deepEqual(zoomed([-500, 500], 0, 100), [0, 100]);
  const [from, to] = zoomed([50, 50], 0, 100);
  assert.ok(to > from);
});

test("noise is not shown large", () => {
  assert.deepEqual(spread(null, null), [-0.05, 0.05]);
  assert.deepEqual(spread(0, 1), [-0.1, 1.1]);
});
