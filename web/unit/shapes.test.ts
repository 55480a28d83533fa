import assert from "node:assert/strict";
import { test } from "node:test";
import { Group, Mesh, MeshBasicMaterial, Raycaster, Vector3 } from "three";
import { CellView } from "../src/cellview";
import type { MeshData } from "../src/mesh";
import { bodyOf, MeshStore, solidOf, topOf } from "../src/shapes";
import type { WorldScene } from "../src/world";

/** A corner of a cube, 1 m along the axes, away from the origin. */
function corner(): MeshData {
  const points = new Float32Array([1, 2, 3, 2, 2, 3, 1, 3, 3, 1, 2, 4]);
  return { points, triangles: new Uint32Array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]) };
}

/** So many triangles of one size in the plane z = 0, side by side. */
function row(count: number): MeshData {
  const points = new Float32Array(9 * count);
  for (let k = 0; k < count; k++) points.set([k, 0, 0, k + 1, 0, 0, k, 1, 0], 9 * k);
  return { points, triangles: Uint32Array.from({ length: 3 * count }, (_, k) => k) };
}

const turn = (): Promise<void> => new Promise((done) => setTimeout(done));

function store(load: (number: number) => Promise<MeshData>): {
  meshes: MeshStore;
  filled: () => number;
  missing: [number, unknown][];
} {
  let filled = 0;
  const missing: [number, unknown][] = [];
  return {
    meshes: new MeshStore(
      load,
      () => (filled += 1),
      (number, reason) => missing.push([number, reason]),
    ),
    filled: () => filled,
    missing,
  };
}

test("a mesh is asked for once, and everything that has it shares its geometry", async () => {
  const asked: number[] = [];
  const { meshes, filled } = store(async (number) => {
    asked.push(number);
    return corner();
  });
  const tops: number[] = [];
  const first = solidOf({ shape: "mesh", size: [], mesh: 3 }, meshes, (solid) => tops.push(topOf(solid).z));
  assert.equal(first.solid.getAttribute("position"), undefined);
  await turn();
  const later = solidOf({ shape: "mesh", size: [], mesh: 3 }, meshes, (solid) => tops.push(topOf(solid).z));
  assert.equal(later.solid, first.solid);
  assert.deepEqual(
    [asked, filled(), first.solid.index?.count, first.edges.getAttribute("position").count],
    [[3], 1, 12, 12],
  );
  assert.equal(tops.length, 2);
  assert.ok(
    tops.every((z) => Math.abs(z - 4.03) < 1e-6),
    String(tops),
  );
});

test("a mesh of many triangles has no lines, a flat neighbour none either", async () => {
  const { meshes } = store(async (number) => row(number));
  const [few, many] = [meshes.solid(20_000), meshes.solid(20_001)];
  await turn();
  assert.equal(few.edges.getAttribute("position").count, 2 * 3 * 20_000);
  assert.equal(many.edges.getAttribute("position"), undefined);
  const flat = store(async () => ({
    points: new Float32Array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0]),
    triangles: new Uint32Array([0, 1, 2, 0, 2, 3]),
  })).meshes.solid(0);
  await turn();
  assert.equal(flat.edges.getAttribute("position").count, 8);
});

test("a fault is told once, and nothing is told or drawn after the end", async () => {
  const failing = store(async () => Promise.reject(new Error("no")));
  failing.meshes.solid(1);
  failing.meshes.solid(1);
  await turn();
  assert.deepEqual(
    failing.missing.map(([number]) => number),
    [1],
  );
  for (const load of [async () => corner(), async () => Promise.reject(new Error("no"))]) {
    const ended = store(load);
    const { solid } = ended.meshes.solid(1);
    let given = 0;
    solid.addEventListener("dispose", () => (given += 1));
    ended.meshes.dispose();
    await turn();
    assert.deepEqual([ended.filled(), ended.missing, given, solid.getAttribute("position")], [0, [], 1, undefined]);
  }
});

test("the pointer finds a mesh by its triangles, one of very many by the box around it", async () => {
  const { meshes } = store(async (number) => row(number));
  const look = (count: number, x: number, y: number): number[] => {
    const body = bodyOf(meshes.solid(count), new MeshBasicMaterial());
    body.position.set(0, 0, 1);
    const root = new Group().add(body);
    root.updateMatrixWorld(true);
    return new Raycaster(new Vector3(x, y, 3), new Vector3(0, 0, -1))
      .intersectObjects([body], false)
      .map((hit) => hit.distance);
  };
  const [few, many] = [10, 200_001];
  look(few, 0, 0);
  look(many, 0, 0);
  await turn();
  assert.deepEqual(look(few, 3.2, 0.2), [2]);
  assert.deepEqual(look(few, 3.9, 0.9), []);
  assert.deepEqual(look(many, 3.9, 0.9), [2]);
  assert.deepEqual(look(many, 3.9, 1.1), []);
});

test("of two fingers with a mesh the other one is a true mirror image", async () => {
  const { meshes } = store(async () => corner());
  const pose = [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3];
  const scene: WorldScene = {
    floor: null,
    parts: [],
    grippers: [{ name: "hand", kind: "fingers", axis: [0, 2, 0], shape: "mesh", size: [], mesh: 0, pose }],
    conveyors: [],
    detectors: [],
    sinks: [],
    actuators: [],
  };
  const view = new CellView(scene, { outline: 0, ghost: 0 }, meshes);
  await turn();
  view.show(
    {
      parts: [],
      obstacles: [],
      grippers: [{ sealed: [], width: 0.5, holding: null }],
      conveyors: [],
      detectors: [],
      counts: [],
    },
    [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0],
  );
  view.root.updateMatrixWorld(true);
  const fingers: Mesh[] = [];
  view.root.traverse((object) => object instanceof Mesh && object.userData["name"] === "hand" && fingers.push(object));
  const [one, other] = fingers as [Mesh, Mesh];
  assert.equal(fingers.length, 2);
  assert.ok(one.matrixWorld.determinant() > 0 && other.matrixWorld.determinant() < 0);
  for (const [x, y, z] of [
    [1, 2, 3],
    [2, 2, 3],
    [1, 3, 3],
    [1, 2, 4],
  ] as [number, number, number][]) {
    const [a, b] = [one, other].map((finger) => new Vector3(x, y, z).applyMatrix4(finger.matrixWorld)) as [
      Vector3,
      Vector3,
    ];
    // Across the plane through the origin of the flange that the axis stands on.
    assert.ok(a.distanceTo(new Vector3(b.x, -b.y, b.z)) < 1e-6, `${a.toArray()} ${b.toArray()}`);
  }
});
