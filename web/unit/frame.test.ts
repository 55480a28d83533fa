import assert from "node:assert/strict";
import { test } from "node:test";
import { FRAME_BYTES, indexAt, readFrame, readFrames } from "../src/frame";

function sample(time: number): ArrayBuffer {
  const view = new DataView(new ArrayBuffer(FRAME_BYTES));
  view.setUint16(0, 1, true);
  view.setUint16(2, FRAME_BYTES, true);
  view.setFloat64(8, time, true);
  view.setBigUint64(16, 3125n, true);
  view.setInt8(32, -1);
  view.setUint8(33, 3);
  view.setUint8(35, 2);
  view.setUint32(36, 17, true);
  view.setFloat32(56, 0.5, true);
  view.setUint32(68, 1 << 27, true);
  view.setFloat32(92, 9.5, true);
  view.setFloat32(96 + 24, 1.25, true);
  view.setFloat32(96 + 9 * 24 + 20, -3.5, true);
  return view.buffer;
}

test("fields are read where the layout puts them", () => {
  const frame = readFrame(sample(12.5));
  assert.ok(frame);
  assert.deepEqual(
    [frame.time, frame.cycle, frame.robotMode, frame.safetyMode, frame.task, frame.line],
    [12.5, 3125, -1, 3, 2, 17],
  );
  assert.deepEqual(
    [frame.speedFraction, frame.digitalOut, frame.analogOut[2], frame.actualQ[0], frame.tcpForce[5]],
    [0.5, 1 << 27, 9.5, 1.25, -3.5],
  );
});

test("what is none of this version, or cut, is no frame", () => {
  const other = sample(1);
  new DataView(other).setUint16(0, 2, true);
  assert.equal(readFrame(other), null);
  assert.equal(readFrame(sample(1).slice(0, 100)), null);
});

test("many frames, and the one of a moment", () => {
  const bytes = new Uint8Array(FRAME_BYTES * 3 + 10);
  [1, 2, 4].forEach((time, k) => bytes.set(new Uint8Array(sample(time)), k * FRAME_BYTES));
  const frames = readFrames(bytes.buffer);
  assert.deepEqual(
    frames.map((frame) => frame.time),
    [1, 2, 4],
  );
  assert.deepEqual(
    [0, 1, 1.9, 2, 3.9, 4, 9].map((time) => indexAt(frames, time)),
    [0, 0, 0, 1, 1, 2, 2],
  );
  assert.equal(indexAt([], 1), 0);
});
