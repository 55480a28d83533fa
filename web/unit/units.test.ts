import assert from "node:assert/strict";
import { test } from "node:test";
import { quantityText, readQuantity } from "../src/units";

test("angles and lengths are read as people write them", () => {
  for (const [text, kind, units, value] of [
    ["-70°", "angle", "si", (-70 * Math.PI) / 180],
    ["−70 °", "angle", "si", (-70 * Math.PI) / 180],
    ["-70", "angle", "practical", (-70 * Math.PI) / 180],
    ["-1.2", "angle", "si", -1.2],
    ["- 1,2 rad", "angle", "practical", -1.2],
    ["90 deg", "angle", "si", Math.PI / 2],
    ["90度", "angle", "si", Math.PI / 2],
    ["350 mm", "length", "si", 0.35],
    ["350", "length", "practical", 0.35],
    ["0.35m", "length", "practical", 0.35],
    [".5", "length", "si", 0.5],
    ["１２", "length", "practical", 0.012],
  ] as const)
    assert.ok(Math.abs((readQuantity(text, kind, units) ?? NaN) - value) < 1e-12, text);
  for (const text of ["", "abc", "1 2", "1.2.3", "70 mm", "1e999", "--1", "°"])
    assert.equal(readQuantity(text, "angle", "si"), null, text);
});

test("what is shown has its unit", () => {
  assert.equal(quantityText("angle", Math.PI / 2, "practical"), "90.00°");
  assert.equal(quantityText("length", 0.1234, "practical"), "123.4 mm");
  assert.equal(quantityText("length", 0.1234, "si"), "0.1234 m");
});
