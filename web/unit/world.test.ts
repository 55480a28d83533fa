import assert from "node:assert/strict";
import { test } from "node:test";
import { fromPose } from "../src/kinematics";
import { partMatrix, tableOf, toPose, type WorldScene } from "../src/world";

const near = (a: readonly number[], b: readonly number[]): void =>
  a.forEach((x, k) => assert.ok(Math.abs(x - (b[k] ?? NaN)) < 1e-9, `${a} ${b}`));

test("a pose comes back from its frame", () => {
  for (const pose of [
    [1, -2, 3, 0.1, -0.4, 2.5],
    [0, 0, 0, -3, 1.2, -0.7],
    [0.5, 0, 0, 0, 0, 0],
  ])
    near(toPose(fromPose(pose)), pose);
});

test("a frame that looks straight down has one of its poses", () => {
  for (const pose of [
    [0, 0, 0, 0.7, Math.PI / 2, 0.2],
    [0, 0, 0, 0.7, -Math.PI / 2, 0.2],
  ])
    near(fromPose(toPose(fromPose(pose))), fromPose(pose));
});

test("a part that is held goes along with the flange", () => {
  const flange = fromPose([1, 0, 0.5, 0, 0, Math.PI / 2]);
  near(toPose(partMatrix({ name: "box", pose: [0.1, 0, 0, 0, 0, 0], held_by: 0 }, flange)), [
    1,
    0.1,
    0.5,
    0,
    0,
    Math.PI / 2,
  ]);
  near(toPose(partMatrix({ name: "box", pose: [0.1, 0, 0, 0, 0, 0] }, flange)), [0.1, 0, 0, 0, 0, 0]);
});

test("copies and parts of sources have the table of their name", () => {
  const parts = ["box", "box of nails"].map((name) => ({ name, shape: "box", size: [1, 1, 1], color: null }));
  const scene: WorldScene = {
    floor: null,
    parts,
    grippers: [],
    conveyors: [],
    detectors: [],
    sinks: [],
    actuators: [],
  };
  assert.equal(tableOf(scene, "box[3]"), parts[0]);
  assert.equal(tableOf(scene, "box of nails#12"), parts[1]);
  assert.equal(tableOf(scene, "ball"), undefined);
});
