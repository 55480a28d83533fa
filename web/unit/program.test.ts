import assert from "node:assert/strict";
import { test } from "node:test";
import { fixed } from "../src/dom";

test("numbers have a point and no minus before nothing", () => {
  assert.deepEqual([fixed(-0.00001, 3), fixed(1.23456, 3), fixed(-1.5, 1)], ["0.000", "1.235", "-1.5"]);
});
