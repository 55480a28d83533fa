// Paths of the TCP as polylines, from the frames of the time line. Pure.

import type { Frame } from "./frame";

/**
 * A stretch of a path without a break: places in the base frame, m, three numbers each, and when the TCP was there, s.
 */
export interface Piece {
  places: number[];
  times: number[];
}

/** Where a program comes near to something, or into it. */
export interface Place {
  distance: number;
  a: string;
  b: string;
  line: number;
  time: number;
  tcp: number[];
}

/** Places that are nearer to each other are one, m. */
const APART = 0.001;
/** TCPs that differ by more are different ones, m and rad. */
const OTHER_TCP = 1e-6;

type Seen = Pick<Frame, "time" | "tcpOffset" | "actualPose" | "targetPose">;

/**
 * The path that was driven, or commanded, in frames in order of time. A new piece begins where the TCP is another one,
 * which is no way, and where time begins anew.
 */
export function pathOf(frames: readonly Seen[], which: "actualPose" | "targetPose"): Piece[] {
  const pieces: Piece[] = [];
  let piece: Piece | null = null;
  let before: Seen | null = null;
  let last = [NaN, NaN, NaN];
  for (const frame of frames) {
    const [x = 0, y = 0, z = 0] = frame[which];
    const { tcpOffset } = frame;
    const isOther: boolean =
      before === null ||
      frame.time < before.time ||
      tcpOffset.some((value, k) => Math.abs(value - (before?.tcpOffset[k] ?? 0)) > OTHER_TCP);
    if (piece === null || isOther) {
      piece = { places: [], times: [] };
      pieces.push(piece);
      last = [NaN, NaN, NaN];
    }
    before = frame;
    if (Math.hypot(x - (last[0] ?? 0), y - (last[1] ?? 0), z - (last[2] ?? 0)) < APART) continue;
    last = [x, y, z];
    piece.places.push(x, y, z);
    piece.times.push(frame.time);
  }
  return pieces.filter((one) => one.times.length > 1);
}

/** A path that the server tells: when its places are passed is not known. */
export function pathFrom(pieces: readonly (readonly (readonly number[])[])[]): Piece[] {
  return pieces
    .map((points) => ({ places: points.flatMap((point) => [...point]), times: points.map(() => 0) }))
    .filter((one) => one.times.length > 1);
}

/** Both ends of every line of a path, one line behind the other, as they are drawn. */
export function linesOf(pieces: readonly Piece[], most = Infinity): Float32Array {
  const all = pieces.reduce((sum, piece) => sum + piece.times.length - 1, 0);
  // Of what is too much the latest is drawn.
  let skip = Math.max(0, all - most);
  const lines = new Float32Array(6 * (all - skip));
  let at = 0;
  for (const { places, times } of pieces) {
    for (let k = 0; k + 1 < times.length; k++) {
      if (skip > 0) {
        skip -= 1;
        continue;
      }
      for (let n = 0; n < 6; n++) lines[at++] = places[3 * k + n] ?? 0;
    }
  }
  return lines;
}

/**
 * How strong every line of a path is drawn, 0 to 1: what has just been driven most; what comes after the moment that is
 * shown is faint.
 */
export function strengthsOf(pieces: readonly Piece[], now: number, isLive: boolean, most = Infinity): number[] {
  const first = pieces[0]?.times[0] ?? now;
  const span = Math.max(now - first, 1e-6);
  const strengths = pieces.flatMap(({ times }) =>
    times.slice(1).map((time) => (time > now + 1e-9 ? 0.15 : isLive ? 1 - 0.65 * Math.min(1, (now - time) / span) : 1)),
  );
  return strengths.slice(Math.max(0, strengths.length - most));
}
