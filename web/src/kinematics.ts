// The arm's frames from its joint positions: twelve numbers a frame, three rows of rotation and translation.

export type Matrix = readonly number[];

export function multiply(a: Matrix, b: Matrix): number[] {
  const out: number[] = [];
  const at = (m: Matrix, k: number): number => m[k] ?? 0;
  for (let row = 0; row < 3; row++) {
    for (let column = 0; column < 4; column++) {
      let sum = column === 3 ? at(a, row * 4 + 3) : 0;
      for (let k = 0; k < 3; k++) sum += at(a, row * 4 + k) * at(b, k * 4 + column);
      out.push(sum);
    }
  }
  return out;
}

export function turnZ(angle: number): number[] {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return [c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0];
}

/** A pose of the controller: position, then rotation about x, y and z of the base, in this order. */
export function fromPose(pose: readonly number[]): number[] {
  const [x = 0, y = 0, z = 0, rx = 0, ry = 0, rz = 0] = pose;
  const [cx, sx, cy, sy, cz, sz] = [Math.cos(rx), Math.sin(rx), Math.cos(ry), Math.sin(ry), Math.cos(rz), Math.sin(rz)];
  // prettier-ignore
  return [
    cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx, x,
    sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx, y,
    -sy, cy * sx, cy * cx, z,
  ];
}

/** Frames of the base, the six joints, the flange and the TCP in the base frame. */
export function forward(
  joints: readonly Matrix[],
  flange: Matrix,
  q: readonly number[],
  tcp: readonly number[],
): number[][] {
  const frames: number[][] = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]];
  let frame = frames[0] as number[];
  joints.forEach((joint, k) => {
    frame = multiply(multiply(frame, joint), turnZ(q[k] ?? 0));
    frames.push(frame);
  });
  frame = multiply(frame, flange);
  frames.push(frame);
  frames.push(multiply(frame, fromPose(tcp)));
  return frames;
}
