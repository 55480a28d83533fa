import assert from "node:assert/strict";
import { test } from "node:test";
import { linesOf, pathFrom, pathOf, strengthsOf } from "../src/path";
import { isOwn, placeText, RestWatch } from "../src/paths";

const NO_TCP = [0, 0, 0, 0, 0, 0];
const frame = (time: number, x: number, tcpOffset = NO_TCP): Parameters<typeof pathOf>[0][number] => ({
  time,
  tcpOffset,
  actualPose: [x, 0, 0.3, 0, 0, 0],
  targetPose: [x + 1, 0, 0.3, 0, 0, 0],
});

test("a path has a place a millimetre, and none for an arm that stands", () => {
  const stands = Array.from({ length: 50 }, (_, k) => frame(k, 0.2));
  assert.deepEqual(pathOf(stands, "actualPose"), []);
  const moves = Array.from({ length: 50 }, (_, k) => frame(k, k * 0.0004));
  const [piece] = pathOf(moves, "actualPose");
  assert.ok(piece && piece.times.length > 10 && piece.times.length < 20, JSON.stringify(piece));
  assert.equal(pathOf(moves, "targetPose")[0]?.places[0], 1);
});

test("another tool is no way, and neither is a time that begins anew", () => {
  const long = [0, 0, 0.2, 0, 0, 0];
  const frames = [
    frame(1, 0),
    frame(2, 0.1),
    frame(3, 0.3, long),
    frame(4, 0.4, long),
    frame(0, 0.9, long),
    frame(1, 1, long),
  ];
  const pieces = pathOf(frames, "actualPose");
  assert.deepEqual(
    pieces.map(({ times }) => times),
    [
      [1, 2],
      [3, 4],
      [0, 1],
    ],
  );
  assert.equal(linesOf(pieces).length, 18);
});

test("of too many lines the latest are drawn, each with its strength", () => {
  const pieces = pathOf(
    [0, 1, 2, 3, 4].map((k) => frame(k, k)),
    "actualPose",
  );
  const lines = linesOf(pieces, 2);
  assert.deepEqual(
    [...lines].filter((_, k) => k % 3 === 0),
    [2, 3, 3, 4],
  );
  assert.equal(strengthsOf(pieces, 4, true, 2).length, 2);
  const live = strengthsOf(pieces, 4, true);
  assert.ok(live.every((strength, k) => strength > (live[k - 1] ?? 0)) && live.at(-1) === 1, live.join());
  // In the past what is to come is faint.
  assert.deepEqual(
    strengthsOf(pieces, 2, false).map((strength) => strength > 0.5),
    [true, true, false, false],
  );
});

test("a planned path keeps the pieces of the server", () => {
  // prettier-ignore
  const pieces = pathFrom([[[0, 0, 0], [1, 0, 0]], [[5, 0, 0]], [[2, 0, 0], [3, 0, 0], [4, 0, 0]]]);
  assert.deepEqual(
    pieces.map(({ times }) => times.length),
    [2, 3],
  );
  assert.equal(linesOf(pieces).length, 18);
});

test("a place is told in words of the language, a depth as one", () => {
  const place = { distance: 0.0123, a: "forearm", b: "post", line: 3, time: 1, tcp: [0, 0, 0, 0, 0, 0] };
  assert.equal(placeText(place), "0.0123 m from forearm to post");
  // Neighbours within the arm are always near; only where they touch it is worth a mark.
  assert.deepEqual(
    [isOwn(place), isOwn({ ...place, b: "wrist_2" }), isOwn({ ...place, b: "wrist_2", distance: -0.001 })],
    [false, true, false],
  );
  assert.equal(placeText({ ...place, distance: -0.0956, a: "upper_arm" }), "upper arm 0.0956 m deep in post");
});

test("the path is asked for anew when a hand has moved the arm, not when its program has", () => {
  const watch = new RestWatch();
  const at = (task: number, q: number, speed = 0): boolean =>
    watch.take({ task, targetQ: [q, 0, 0, 0, 0, 0], targetQd: [speed, 0, 0, 0, 0, 0] });
  assert.equal(at(0, 0.1), false);
  assert.deepEqual(watch.rest, [0.1, 0, 0, 0, 0, 0]);
  // Its program moves it, and it comes to rest after the end.
  assert.deepEqual([at(1, 0.2, 1), at(1, 0.3), at(0, 0.4, 1), at(0, 0.5)], [false, false, false, false]);
  assert.equal(watch.rest?.[0], 0.5);
  assert.deepEqual([at(0, 0.6, 1), at(0, 0.7, 1), at(0, 0.8)], [false, false, true]);
  // A touch that moves nothing is none.
  assert.deepEqual([at(0, 0.8, 1), at(0, 0.8)], [false, false]);
});
