// Reads the binary frame of /api/v1/live: the layout is in docs/api.md and crates/pendant/src/frame.rs.

export const FRAME_VERSION = 1;
export const FRAME_BYTES = 392;

export interface Frame {
  sequence: number;
  time: number;
  cycle: number;
  wallMs: number;
  robotMode: number;
  safetyMode: number;
  motionMode: number;
  /** 0 stopped, 1 running, 2 paused. */
  task: number;
  line: number;
  node: number;
  program: number;
  forceMode: boolean;
  stopCode: number;
  speedFraction: number;
  speedScaling: number;
  digitalIn: number;
  digitalOut: number;
  analogIn: number[];
  analogOut: number[];
  targetQ: number[];
  actualQ: number[];
  targetQd: number[];
  actualQd: number[];
  targetTorque: number[];
  actualTorque: number[];
  targetPose: number[];
  actualPose: number[];
  tcpSpeed: number[];
  tcpForce: number[];
  tcpOffset: number[];
  temperatures: number[];
}

/** The frame at an offset of a buffer; null for what is none of this version. */
export function readFrame(buffer: ArrayBuffer, offset = 0): Frame | null {
  if (buffer.byteLength < offset + FRAME_BYTES) return null;
  const view = new DataView(buffer, offset, FRAME_BYTES);
  if (view.getUint16(0, true) !== FRAME_VERSION) return null;
  const floats = (at: number, count: number): number[] =>
    Array.from({ length: count }, (_, k) => view.getFloat32(at + 4 * k, true));
  const six = (group: number): number[] => floats(96 + 24 * group, 6);
  return {
    sequence: view.getUint32(4, true),
    time: view.getFloat64(8, true),
    cycle: Number(view.getBigUint64(16, true)),
    wallMs: view.getFloat64(24, true),
    robotMode: view.getInt8(32),
    safetyMode: view.getUint8(33),
    motionMode: view.getUint8(34),
    task: view.getUint8(35),
    line: view.getUint32(36, true),
    node: view.getUint32(40, true),
    program: view.getUint32(44, true),
    forceMode: (view.getUint32(48, true) & 1) !== 0,
    stopCode: view.getUint32(52, true),
    speedFraction: view.getFloat32(56, true),
    speedScaling: view.getFloat32(60, true),
    digitalIn: view.getUint32(64, true),
    digitalOut: view.getUint32(68, true),
    analogIn: floats(72, 3),
    analogOut: floats(84, 3),
    targetQ: six(0),
    actualQ: six(1),
    targetQd: six(2),
    actualQd: six(3),
    targetTorque: six(4),
    actualTorque: six(5),
    targetPose: six(6),
    actualPose: six(7),
    tcpSpeed: six(8),
    tcpForce: six(9),
    tcpOffset: six(10),
    temperatures: six(11),
  };
}

/** Every frame of an answer of /api/v1/history. */
export function readFrames(buffer: ArrayBuffer): Frame[] {
  const frames: Frame[] = [];
  for (let at = 0; at + FRAME_BYTES <= buffer.byteLength; at += FRAME_BYTES) {
    const frame = readFrame(buffer, at);
    if (frame) frames.push(frame);
  }
  return frames;
}

/** The index of the latest frame at or before a time; 0 before the first. */
export function indexAt(frames: readonly { time: number }[], time: number): number {
  let low = 0;
  let high = frames.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((frames[middle]?.time ?? Infinity) <= time) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}
