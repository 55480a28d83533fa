import assert from "node:assert/strict";
import { test } from "node:test";
import { firstTarget, pointLine, spotFor } from "../src/taught";

/** The program after a line was taught at the bar. */
function taughtAt(text: string): string {
  const lines = text.replace("|", "").split("\n");
  const cursor = text.slice(0, text.indexOf("|")).split("\n").length - 1;
  const spot = spotFor(lines, cursor);
  lines.splice(spot.replaces ? spot.line : spot.line + 1, spot.replaces ? 1 : 0, `${spot.indent}POINT`);
  return lines.join("\n");
}

test("a taught line fits where it stands", () => {
  for (const [before, after] of [
    ["|", "POINT"],
    ["sync()|\n", "sync()\nPOINT\n"],
    ["sync()\n|", "sync()\nPOINT"],
    ["  |", "POINT"],
    ["# only words\n  |", "# only words\nPOINT"],
    ["def p():|\nend\n", "def p():\n  POINT\nend\n"],
    ["def p():|\n    sync()\nend\n", "def p():\n    POINT\n    sync()\nend\n"],
    ["def p():\n  sync()|\nend\n", "def p():\n  sync()\n  POINT\nend\n"],
    ["def p():\n  sync()\n|\nend\n", "def p():\n  sync()\n  POINT\nend\n"],
    ["def p():\n  sync()\nend|\n", "def p():\n  sync()\nend\nPOINT\n"],
    ["def p():\n  sync()\nend\n|", "def p():\n  sync()\nend\nPOINT"],
    ["def p():\n  while True:  # round\n|\n  end\nend", "def p():\n  while True:  # round\n    POINT\n  end\nend"],
    ["def p():\n  while True:\n    sync()\n  end|\nend", "def p():\n  while True:\n    sync()\n  end\n  POINT\nend"],
    ["movej([0, 0,|\n  0, 0, 0, 0])\nsync()", "movej([0, 0,\n  0, 0, 0, 0])\nPOINT\nsync()"],
    ["movej([0, 0,\n  0, 0, |0, 0])\nsync()", "movej([0, 0,\n  0, 0, 0, 0])\nPOINT\nsync()"],
    ["s = '#:'|\n", "s = '#:'\nPOINT\n"],
  ] as const)
    assert.equal(taughtAt(before), after, JSON.stringify(before));
});

test("a taught line has a name where the point has one", () => {
  assert.equal(
    pointLine([0, -1.5, 1, 0, 0, 0]),
    "movej([0.00000, -1.50000, 1.00000, 0.00000, 0.00000, 0.00000], a=1.4, v=1.0)",
  );
  assert.ok(pointLine([0, 0, 0, 0, 0, 0], "above\ntray").endsWith("  # above tray"));
});

test("the first target of a program is found where it is written in numbers", () => {
  assert.deepEqual(firstTarget("# movej([9,9,9,9,9,9])\ndef p():\n  movej([0, -1.5, 1.5, -1.5, -1.5, 1e-1], a=1)\n"), {
    joints: [0, -1.5, 1.5, -1.5, -1.5, 0.1],
  });
  assert.deepEqual(firstTarget("movel([0.4, 0, 0.3, 3.14, 0, 0])"), { pose: [0.4, 0, 0.3, 3.14, 0, 0] });
  assert.deepEqual(firstTarget("up = [0, 1, 2, 3, 4, 5]\nmovej(up, v=1)"), { joints: [0, 1, 2, 3, 4, 5] });
  assert.equal(firstTarget("movej(get_target_joint_positions())"), null);
  assert.equal(firstTarget("sync()"), null);
});
