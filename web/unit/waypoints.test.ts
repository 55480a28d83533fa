import assert from "node:assert/strict";
import { test } from "node:test";
import { freshName, waypointsOf } from "../src/waypoints";

test("what is no list of points is passed over", () => {
  for (const text of [
    null,
    "",
    "{",
    "7",
    "null",
    '[{"name": 3}]',
    '[null, {"name": "a", "q": [1, 2]}]',
    '[{"name": "a", "q": [1, 2, 3, 4, 5, null]}]',
  ])
    assert.deepEqual(waypointsOf(text), []);
  assert.deepEqual(waypointsOf('[{"name": "a", "q": [1, 2, 3, 4, 5, 6], "x": 1}]'), [
    { name: "a", q: [1, 2, 3, 4, 5, 6] },
  ]);
  assert.equal(
    waypointsOf(JSON.stringify(Array.from({ length: 500 }, () => ({ name: "x".repeat(99), q: [0, 0, 0, 0, 0, 0] }))))
      .length,
    100,
  );
});

test("a new point has a name of its own", () => {
  assert.equal(freshName([]), "P1");
  assert.equal(
    freshName([
      { name: "P1", q: [] },
      { name: "P3", q: [] },
    ]),
    "P2",
  );
});
