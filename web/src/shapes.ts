// Shapes of obstacles, tool, parts and fingers as geometries. A mesh is one geometry for everything that has it: empty
// while it is fetched, filled when it is there.

// prettier-ignore
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, EdgesGeometry, type Intersection, type Material,
  Matrix4, Mesh, type Raycaster, SphereGeometry, Vector3,
} from "three";
import { creases, type MeshData } from "./mesh";

/** A shape as the scene tells it; `mesh` is the number of one. */
export interface ShapeRow {
  shape: string;
  size: number[];
  mesh?: number;
}

/** What is drawn of a shape. */
export interface Solid {
  solid: BufferGeometry;
  edges: BufferGeometry;
  isMesh: boolean;
}

/** Neighbours that differ by more have an edge between them, degrees. */
const CREASE = 30;
/** A mesh of more triangles has no lines for its edges: they would cover it. */
const EDGES_TRIANGLES_MAX = 20_000;
/** A mesh of more triangles is found under the pointer by the box around it. */
const POINTED_TRIANGLES_MAX = 200_000;

export type MeshLoader = (number: number, signal: AbortSignal) => Promise<MeshData>;

/** The meshes of one scene, each asked for once. */
export class MeshStore {
  private readonly solids = new Map<number, Solid & { waiting: ((solid: BufferGeometry) => void)[] | null }>();
  private readonly end = new AbortController();

  constructor(
    private readonly load: MeshLoader,
    private readonly onFilled: () => void,
    private readonly onMissing: (number: number, reason: unknown) => void,
  ) {}

  /** The geometries of a mesh; `whenFilled` is called as soon as they are not empty. */
  solid(number: number, whenFilled: (solid: BufferGeometry) => void = () => undefined): Solid {
    let known = this.solids.get(number);
    if (!known) {
      known = { solid: new BufferGeometry(), edges: new BufferGeometry(), isMesh: true, waiting: [] };
      this.solids.set(number, known);
      void this.fill(number);
    }
    if (known.waiting) known.waiting.push(whenFilled);
    else whenFilled(known.solid);
    return known;
  }

  private async fill(number: number): Promise<void> {
    try {
      const data = await this.load(number, this.end.signal);
      const known = this.solids.get(number);
      if (!known || this.end.signal.aborted) return;
      fillSolid(known, data);
      for (const whenFilled of known.waiting ?? []) whenFilled(known.solid);
      known.waiting = null;
      this.onFilled();
    } catch (error) {
      if (!this.end.signal.aborted) this.onMissing(number, error);
    }
  }

  /** Gives back what the graphics card keeps, and waits for nothing any more. */
  dispose(): void {
    this.end.abort();
    for (const { solid, edges } of this.solids.values()) for (const one of [solid, edges]) one.dispose();
    this.solids.clear();
  }
}

function fillSolid({ solid, edges }: Solid, { points, triangles }: MeshData): void {
  solid.setAttribute("position", new BufferAttribute(points, 3));
  solid.setIndex(new BufferAttribute(triangles, 1));
  solid.computeBoundingBox();
  solid.computeBoundingSphere();
  if (triangles.length > 3 * EDGES_TRIANGLES_MAX) return;
  const lines = creases({ points, triangles }, Math.cos((CREASE * Math.PI) / 180));
  edges.setAttribute("position", new BufferAttribute(lines, 3));
  edges.computeBoundingSphere();
}

/** The geometry of a shape that is no mesh. */
export function shapeOf(shape: string, size: readonly number[]): BufferGeometry {
  const [a = 0.1, b = 0.1, c = 0.1] = size;
  if (shape === "cylinder") return new CylinderGeometry(a, a, b, 40).rotateX(Math.PI / 2);
  if (shape === "sphere") return new SphereGeometry(a, 32, 20);
  return new BoxGeometry(a, b, c);
}

/** What is drawn of any shape. */
export function solidOf(row: ShapeRow, meshes: MeshStore, whenFilled?: (solid: BufferGeometry) => void): Solid {
  if (row.mesh !== undefined) return meshes.solid(row.mesh, whenFilled);
  const solid = shapeOf(row.shape, row.size);
  return { solid, edges: new EdgesGeometry(solid, CREASE), isMesh: false };
}

/** Where a text stands above a geometry, in its frame. */
export function topOf(solid: BufferGeometry): Vector3 {
  if (!solid.boundingBox) solid.computeBoundingBox();
  const box = solid.boundingBox;
  return box && !box.isEmpty()
    ? new Vector3((box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2, box.max.z + 0.03)
    : new Vector3(0, 0, 0.03);
}

/** A thing of a shape that the pointer finds, however many triangles it has. */
export function bodyOf({ solid, isMesh }: Solid, material: Material): Mesh {
  const body = new Mesh(solid, material);
  if (isMesh) body.raycast = (ray, hits) => pointedMesh(body, ray, hits);
  return body;
}

function pointedMesh(body: Mesh, ray: Raycaster, hits: Intersection[]): void {
  const { index, boundingBox } = body.geometry;
  if ((index?.count ?? 0) <= 3 * POINTED_TRIANGLES_MAX || !boundingBox) {
    Mesh.prototype.raycast.call(body, ray, hits);
    return;
  }
  const own = ray.ray.clone().applyMatrix4(new Matrix4().copy(body.matrixWorld).invert());
  const point = own.intersectBox(boundingBox, new Vector3())?.applyMatrix4(body.matrixWorld);
  if (!point) return;
  const distance = ray.ray.origin.distanceTo(point);
  if (distance >= ray.near && distance <= ray.far) hits.push({ distance, point, object: body });
}
