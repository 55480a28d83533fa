import assert from "node:assert/strict";
import { test } from "node:test";
import { creases, fetchMesh, MeshFault, meshUsers, readMesh } from "../src/mesh";

/** A corner of a cube, 1 m along the axes. */
const POINTS = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1];
const TRIANGLES = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2];

function sample(
  points = POINTS,
  triangles = TRIANGLES,
  counts = [points.length / 3, triangles.length / 3],
): ArrayBuffer {
  const view = new DataView(new ArrayBuffer(8 + 4 * (points.length + triangles.length)));
  counts.forEach((count, k) => view.setUint32(4 * k, count, true));
  points.forEach((x, k) => view.setFloat32(8 + 4 * k, x, true));
  triangles.forEach((corner, k) => view.setUint32(8 + 4 * (points.length + k), corner, true));
  return view.buffer;
}

function faultOf(act: () => unknown): { word: string; values: Record<string, number> } {
  try {
    act();
  } catch (error) {
    assert.ok(error instanceof MeshFault);
    return { word: error.word, values: error.values };
  }
  throw new Error("there is no fault");
}

test("points and triangles are read where the layout puts them", () => {
  const { points, triangles } = readMesh(sample());
  assert.deepEqual([...points], POINTS);
  assert.deepEqual([...triangles], TRIANGLES);
  const empty = readMesh(sample([], []));
  assert.deepEqual([empty.points.length, empty.triangles.length], [0, 0]);
});

test("what is cut anywhere is refused with both lengths", () => {
  const whole = sample();
  for (let bytes = 8; bytes < whole.byteLength; bytes++) {
    assert.deepEqual(
      faultOf(() => readMesh(whole.slice(0, bytes))),
      { word: "mesh_cut", values: { bytes, needed: whole.byteLength } },
    );
  }
  for (let bytes = 0; bytes < 8; bytes++)
    assert.deepEqual(faultOf(() => readMesh(whole.slice(0, bytes))).word, "mesh_cut");
});

test("counts that lie are refused before anything is read", () => {
  assert.deepEqual(
    faultOf(() => readMesh(sample(POINTS, TRIANGLES, [4, 0xffffffff]))),
    { word: "mesh_cut", values: { bytes: 104, needed: 8 + 12 * (4 + 0xffffffff) } },
  );
  assert.equal(faultOf(() => readMesh(sample(POINTS, TRIANGLES, [5, 4]))).word, "mesh_cut");
  assert.equal(faultOf(() => readMesh(sample(POINTS, TRIANGLES, [0, 0]))).word, "mesh_cut");
  // The sum is right, so a point is taken for a triangle: its corners are no indices.
  assert.equal(faultOf(() => readMesh(sample(POINTS, TRIANGLES, [3, 5]))).word, "mesh_corner");
});

test("corners without a point and coordinates that are no numbers are named", () => {
  assert.deepEqual(
    faultOf(() => readMesh(sample(POINTS, [...TRIANGLES.slice(0, 10), 4, 2]))),
    { word: "mesh_corner", values: { n: 3, point: 4, count: 4 } },
  );
  assert.deepEqual(
    faultOf(() => readMesh(sample([...POINTS.slice(0, 7), NaN, ...POINTS.slice(8)]))),
    { word: "mesh_coordinate", values: { n: 2 } },
  );
});

test("creases are the edges of a shape, and its open ends", () => {
  // A roof: two slopes that meet at a ridge over the y axis, each of two triangles.
  const roof = (height: number): number[][] => {
    const points = new Float32Array([-1, 0, 0, 0, 0, height, 0, 1, height, -1, 1, 0, 1, 0, 0, 1, 1, 0]);
    const triangles = new Uint32Array([0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2]);
    const lines = creases({ points, triangles }, Math.cos(Math.PI / 6));
    return Array.from({ length: lines.length / 6 }, (_, k) => [...lines.slice(6 * k, 6 * k + 6)]);
  };
  const ridge = (lines: number[][], height: number): boolean =>
    lines.some((line) => line.join() === [0, 0, height, 0, 1, height].join());
  // Twice 14° at the ridge is no crease, twice 27° is one; six open edges are there anyway, the diagonals never.
  assert.deepEqual([roof(0.25).length, ridge(roof(0.25), 0.25)], [6, false]);
  assert.deepEqual([roof(0.5).length, ridge(roof(0.5), 0.5)], [7, true]);
  assert.equal(creases(readMesh(sample()), Math.cos(Math.PI / 6)).length, 6 * 6);
  assert.equal(creases({ points: new Float32Array(), triangles: new Uint32Array() }, 0).length, 0);
});

test("a mesh is fetched by its number; a refusal and a lost connection are told apart", async () => {
  const before = globalThis.fetch;
  const asked: string[] = [];
  const answers: (() => Response)[] = [
    () => new Response(sample()),
    () => new Response("{}", { status: 404 }),
    () => {
      throw new TypeError("failed to fetch");
    },
  ];
  globalThis.fetch = (async (where: string) => {
    asked.push(where);
    return (answers.shift() as () => Response)();
  }) as typeof fetch;
  try {
    const ending = new AbortController();
    assert.equal((await fetchMesh(7, ending.signal)).points.length, 12);
    await assert.rejects(
      fetchMesh(8, ending.signal),
      (error: MeshFault) => error.word === "mesh_refused" && error.values["status"] === 404,
    );
    await assert.rejects(fetchMesh(9, ending.signal), (error: MeshFault) => error.word === "mesh_unreachable");
    assert.deepEqual(asked, ["/api/v1/meshes/7", "/api/v1/meshes/8", "/api/v1/meshes/9"]);
  } finally {
    globalThis.fetch = before;
  }
});

test("everything that has a mesh is named", () => {
  const scene = {
    obstacles: [{ name: "bench", mesh: 0 }, { name: "box" }, { name: "bracket", mesh: 1 }],
    tool: { mesh: 1 },
    world: { parts: [{ name: "nut", mesh: 1 }], grippers: [{ name: "hand", mesh: 2 }] },
  };
  assert.deepEqual(meshUsers(scene, 1, "tool"), ["bracket", "tool", "nut"]);
  assert.deepEqual(meshUsers(scene, 2, "tool"), ["hand"]);
  assert.deepEqual(meshUsers({ obstacles: [], tool: null, world: null }, 0, "tool"), []);
});
