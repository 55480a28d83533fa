// Meshes of the scene as /api/v1/meshes gives them: read, fetched, and what a thing without one is told to be missing.

import type { Word } from "./words";

export interface MeshData {
  /** x, y and z of each point, m. */
  points: Float32Array;
  /** Three indices of points for each triangle, counterclockwise from outside. */
  triangles: Uint32Array;
}

/** Why a mesh cannot be drawn: a sentence of the table of words, so that the page says it in either language. */
export class MeshFault extends Error {
  constructor(
    readonly word: Word,
    readonly values: Record<string, number> = {},
  ) {
    super(word);
  }
}

const COUNTS_BYTES = 8;
/** Of a point as of a triangle: three numbers of four bytes. */
const ROW_BYTES = 12;

/** A mesh from its bytes, little endian as every machine with a browser: two counts, points, triangles. */
export function readMesh(bytes: ArrayBuffer): MeshData {
  const view = new DataView(bytes);
  const count = (at: number): number => (bytes.byteLength >= COUNTS_BYTES ? view.getUint32(at, true) : 0);
  const [pointCount, triangleCount] = [count(0), count(4)];
  const needed = COUNTS_BYTES + ROW_BYTES * (pointCount + triangleCount);
  if (bytes.byteLength !== needed) throw new MeshFault("mesh_cut", { bytes: bytes.byteLength, needed });
  const points = new Float32Array(bytes, COUNTS_BYTES, 3 * pointCount);
  const triangles = new Uint32Array(bytes, COUNTS_BYTES + ROW_BYTES * pointCount, 3 * triangleCount);
  const wild = points.findIndex((x) => !Number.isFinite(x));
  if (wild >= 0) throw new MeshFault("mesh_coordinate", { n: Math.floor(wild / 3) });
  const lost = triangles.findIndex((corner) => corner >= pointCount);
  if (lost >= 0)
    throw new MeshFault("mesh_corner", { n: Math.floor(lost / 3), point: triangles[lost] ?? 0, count: pointCount });
  return { points, triangles };
}

/**
 * Both ends of every edge whose triangles differ by an angle of at least this cosine, or that has one triangle alone.
 * Triangles share their points, so edges are found by numbers of points: EdgesGeometry compares their coordinates as
 * texts, which takes ten times as long.
 */
export function creases({ points, triangles }: MeshData, cosine: number): Float32Array {
  const at = (point: number, axis: number): number => points[3 * point + axis] ?? 0;
  const normals = new Float64Array(triangles.length);
  for (let first = 0; first < triangles.length; first += 3) {
    const [a, b, c] = [triangles[first] ?? 0, triangles[first + 1] ?? 0, triangles[first + 2] ?? 0];
    const [ux, uy, uz] = [at(b, 0) - at(a, 0), at(b, 1) - at(a, 1), at(b, 2) - at(a, 2)];
    const [vx, vy, vz] = [at(c, 0) - at(a, 0), at(c, 1) - at(a, 1), at(c, 2) - at(a, 2)];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const length = Math.hypot(x, y, z) || 1;
    normals.set([x / length, y / length, z / length], first);
  }
  const lines: number[] = [];
  const count = points.length / 3;
  /** The first triangle of each edge that no second one has been found for. */
  const open = new Map<number, number>();
  const add = (edge: number): void => {
    for (const point of [Math.floor(edge / count), edge % count]) lines.push(at(point, 0), at(point, 1), at(point, 2));
  };
  for (let corner = 0; corner < triangles.length; corner++) {
    const first = corner - (corner % 3);
    const [a, b] = [triangles[corner] ?? 0, triangles[first + ((corner + 1) % 3)] ?? 0];
    const edge = Math.min(a, b) * count + Math.max(a, b);
    const other = open.get(edge);
    if (other === undefined) {
      open.set(edge, first);
      continue;
    }
    open.delete(edge);
    const alike = [0, 1, 2].reduce((sum, axis) => sum + (normals[first + axis] ?? 0) * (normals[other + axis] ?? 0), 0);
    if (alike <= cosine) add(edge);
  }
  for (const edge of open.keys()) add(edge);
  return new Float32Array(lines);
}

/** Asks for a mesh; a browser that has the same one already is not sent it again. */
export async function fetchMesh(number: number, signal: AbortSignal): Promise<MeshData> {
  let answer: Response;
  let bytes: ArrayBuffer;
  try {
    answer = await fetch(`/api/v1/meshes/${number}`, { cache: "no-cache", signal });
    bytes = await answer.arrayBuffer();
  } catch (error) {
    throw signal.aborted ? error : new MeshFault("mesh_unreachable");
  }
  if (!answer.ok) throw new MeshFault("mesh_refused", { status: answer.status });
  return readMesh(bytes);
}

interface Shaped {
  name: string;
  mesh?: number;
}

/** Names of what has a mesh for its shape; the tool has no name of its own. */
export function meshUsers(
  scene: {
    obstacles: Shaped[];
    tool?: { mesh?: number } | null;
    world?: { parts: Shaped[]; grippers: Shaped[] } | null;
  },
  number: number,
  tool: string,
): string[] {
  const tools = scene.tool ? [{ name: tool, ...scene.tool }] : [];
  const all: Shaped[] = [...scene.obstacles, ...tools, ...(scene.world?.parts ?? []), ...(scene.world?.grippers ?? [])];
  return all.filter((one) => one.mesh === number).map((one) => one.name);
}
