// The cell that lives, as the server tells it: what there is (with /api/v1/scene), and a moment of it.

import { fromPose, type Matrix, multiply } from "./kinematics";

export interface PartTable {
  name: string;
  shape: string;
  size: number[];
  /** Number of the mesh that is its shape. */
  mesh?: number;
  color: string | null;
}
export type GripperTable =
  | { name: string; kind: "vacuum"; cups: number[][]; direction: number[]; radius: number }
  | { name: string; kind: "fingers"; axis: number[]; shape: string; size: number[]; mesh?: number; pose: number[] };
export type ConveyorTable =
  | { name: string; kind: "belt"; pose: number[]; size: number[]; direction: number[]; speed: number }
  | { name: string; kind: "turntable"; pose: number[]; radius: number; speed: number };
export type DetectorTable =
  | { name: string; kind: "beam"; from: number[]; until: number[] }
  | { name: string; kind: "presence"; pose: number[]; size: number[] }
  | { name: string; kind: "distance"; pose: number[]; range: number };

/** Shapes, places and names. */
export interface WorldScene {
  floor: number | null;
  parts: PartTable[];
  grippers: GripperTable[];
  conveyors: ConveyorTable[];
  detectors: DetectorTable[];
  sinks: { name: string; pose: number[]; size: number[] }[];
  actuators: { name: string; moves: string[] }[];
}

export interface PartMoment {
  name: string;
  /** In the frame of the flange while a gripper holds it, else in the base frame. */
  pose: number[];
  /** Number of the gripper. */
  held_by?: number;
}

/** How everything is; lists are in the order of the scene. */
export interface WorldMoment {
  parts: PartMoment[];
  obstacles: { name: string; pose: number[] }[];
  grippers: { sealed: boolean[]; width: number; holding: string | null }[];
  conveyors: number[];
  detectors: boolean[];
  counts: number[];
}

/** The table of a part: that of `box[3]` and of `box#7` is `box`. */
export function tableOf(scene: WorldScene, part: string): PartTable | undefined {
  const name = part.split(/[[#]/, 1)[0];
  return scene.parts.find((table) => table.name === name);
}

/** Where a part is in the base frame. */
export function partMatrix(part: PartMoment, flange: Matrix): number[] {
  const own = fromPose(part.pose);
  return part.held_by === undefined ? own : multiply(flange, own);
}

/** The pose of a frame: position, then rotation about x, y and z of the base, in this order. */
export function toPose(m: Matrix): number[] {
  const at = (k: number): number => m[k] ?? 0;
  const lean = Math.hypot(at(9), at(10));
  // Straight up or down only the sum of two turns is known: the last one is 0.
  if (lean < 1e-9) return [at(3), at(7), at(11), Math.atan2(-at(6), at(5)), Math.atan2(-at(8), lean), 0];
  return [at(3), at(7), at(11), Math.atan2(at(9), at(10)), Math.atan2(-at(8), lean), Math.atan2(at(4), at(0))];
}
