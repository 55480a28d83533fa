import assert from "node:assert/strict";
import { test } from "node:test";
import { forward, fromPose, multiply, turnZ } from "../src/kinematics";

const near = (a: readonly number[], b: readonly number[]): void =>
  a.forEach((x, k) => assert.ok(Math.abs(x - (b[k] ?? NaN)) < 1e-12, `${a} ${b}`));
const at = (x: number, y: number, z: number): number[] => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z];

test("a turn about z and a way", () => {
  near(
    multiply(turnZ(Math.PI / 2), at(1, 0, 0)).filter((_, k) => k % 4 === 3),
    [0, 1, 0],
  );
  near(fromPose([1, 2, 3, 0, 0, Math.PI / 2]), [0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3]);
  near(fromPose([0, 0, 0, Math.PI, 0, 0]), [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0]);
});

test("the chain ends at the TCP", () => {
  const joints = [at(0, 0, 0.2), at(0.5, 0, 0), at(0.4, 0, 0), at(0, 0, 0), at(0, 0, 0), at(0, 0, 0)];
  const frames = forward(joints, at(0.1, 0, 0), [Math.PI / 2, 0, 0, 0, 0, 0], [0.05, 0, 0, 0, 0, 0]);
  assert.equal(frames.length, 9);
  near(
    (frames[8] ?? []).filter((_, k) => k % 4 === 3),
    [0, 1.05, 0.2],
  );
});
