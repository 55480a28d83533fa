// What lives in the cell, drawn: parts, cups and fingers, belts, detectors, sinks. The view owns camera, arm and
// obstacles.

// prettier-ignore
import {
  BoxGeometry, type BufferGeometry, type Camera, CylinderGeometry, DoubleSide, EdgesGeometry, Group, LineBasicMaterial,
  LineSegments, type Material, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial, type Object3D, Plane, Quaternion,
  Raycaster, Shape, ShapeGeometry, Vector2, Vector3,
} from "three";
import { fromPose, type Matrix } from "./kinematics";
import { bodyOf, type MeshStore, shapeOf, type Solid, solidOf } from "./shapes";
import {
  type ConveyorTable,
  type DetectorTable,
  type GripperTable,
  partMatrix,
  type PartTable,
  tableOf,
  type WorldMoment,
  type WorldScene,
} from "./world";

/** A part whose table gives no colour. */
const PART = "#7fa7d1";
const CUP = 0x3a424e;
const CUP_SEALED = 0x1fae74;
const BELT = 0x39424e;
const ARROW = 0xf2f4f7;
const LIGHT = 0xff3b30;
const SINK = 0x4f8fd9;
const CUP_DEPTH = 0.015;
const TURNTABLE_HEIGHT = 0.05;
/** A beam that is cut is drawn thicker as well: colour alone does not tell everybody. */
const BEAM_RADIUS = 0.0025;

export interface CellTheme {
  outline: number;
  ghost: number;
}

/** What is under the pointer. */
export interface Pointed {
  name: string;
  isPart: boolean;
}

/** For tests: where things are, and what is lit. */
export interface CellFigures {
  parts: Record<string, number[]>;
  lit: Record<string, boolean>;
  running: Record<string, boolean>;
  sealed: Record<string, boolean[]>;
  width: Record<string, number>;
  ghost: string | null;
}

function place(object: Object3D, m: Matrix): void {
  object.matrixAutoUpdate = false;
  const a = (k: number): number => m[k] ?? 0;
  object.matrix.set(a(0), a(1), a(2), a(3), a(4), a(5), a(6), a(7), a(8), a(9), a(10), a(11), 0, 0, 0, 1);
  object.matrixWorldNeedsUpdate = true;
}

/** A thin rod from one point to another. */
function rod(from: Vector3, until: Vector3, material: Material): Mesh {
  const way = until.clone().sub(from);
  const mesh = new Mesh(new CylinderGeometry(BEAM_RADIUS, BEAM_RADIUS, way.length(), 8), material);
  mesh.position.copy(from).add(until).multiplyScalar(0.5);
  mesh.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), way.normalize());
  return mesh;
}

/** A flat arrow head in the x-y plane that points along x. */
function chevron(size: number): ShapeGeometry {
  const head = new Shape();
  head.moveTo(-size / 2, -size / 2);
  head.lineTo(-size / 6, -size / 2);
  head.lineTo(size / 2, 0);
  head.lineTo(-size / 6, size / 2);
  head.lineTo(-size / 2, size / 2);
  head.lineTo(size / 6, 0);
  return new ShapeGeometry(head);
}

interface DrawnPart {
  group: Group;
  base: number[];
}

export class CellView {
  readonly root = new Group();
  /** Moves with the arm. */
  private readonly flange = new Group();
  private readonly shapes = new Map<PartTable, Solid & { material: MeshStandardMaterial }>();
  private readonly parts = new Map<string, DrawnPart>();
  private readonly cups: MeshStandardMaterial[][] = [];
  private readonly fingers: { gripper: number; axis: Vector3; meshes: [Mesh, Mesh] }[] = [];
  private readonly arrows: MeshBasicMaterial[] = [];
  private readonly lights: { material: MeshBasicMaterial; rods: Mesh[]; dim: number; bright: number }[] = [];
  private readonly edges: LineBasicMaterial;
  private readonly pickables: Object3D[] = [];
  private readonly ray = new Raycaster();
  private ghost: { name: string; group: Group } | null = null;
  private moment: WorldMoment | null = null;
  private frame: Matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

  constructor(
    private readonly scene: WorldScene,
    private readonly theme: CellTheme,
    private readonly meshes: MeshStore,
  ) {
    this.edges = new LineBasicMaterial({ color: theme.outline, transparent: true, opacity: 0.7 });
    this.root.add(this.flange);
    // Parts that a source makes later have their shape at once.
    for (const one of scene.parts) if (one.mesh !== undefined) meshes.solid(one.mesh);
    for (const one of scene.conveyors) this.conveyor(one);
    for (const one of scene.detectors) this.detector(one);
    for (const one of scene.sinks) this.sink(one);
    scene.grippers.forEach((one, number) => this.gripper(one, number));
  }

  private named(object: Object3D, name: string, isGlass = false): void {
    object.userData["name"] = name;
    object.userData["glass"] = isGlass;
    this.pickables.push(object);
  }

  private conveyor(one: ConveyorTable): void {
    const group = new Group();
    const isBelt = one.kind === "belt";
    const solid = isBelt
      ? shapeOf("box", one.size)
      : shapeOf("cylinder", [one.radius, TURNTABLE_HEIGHT]).translate(0, 0, -TURNTABLE_HEIGHT / 2);
    const mesh = new Mesh(solid, new MeshStandardMaterial({ color: BELT, roughness: 0.9 }));
    this.named(mesh, one.name);
    group.add(mesh, new LineSegments(new EdgesGeometry(solid, 30), this.edges));
    place(group, one.pose);
    const material = new MeshBasicMaterial({ color: ARROW, transparent: true, side: DoubleSide, depthWrite: false });
    const backwards = one.speed < 0 ? Math.PI : 0;
    if (isBelt) {
      const [x = 0.1, y = 0.1, z = 0.1] = one.size;
      const frame = new Matrix4().copy(group.matrix);
      const way = new Vector3(...(one.direction as [number, number, number])).transformDirection(frame.invert());
      const angle = Math.atan2(way.y, way.x);
      const [long, across] = Math.abs(way.x) > Math.abs(way.y) ? [x, y] : [y, x];
      const size = Math.min(0.6 * across, 0.2);
      const count = Math.max(1, Math.min(40, Math.floor(long / (2.2 * size))));
      for (let k = 0; k < count; k++) {
        const head = new Mesh(chevron(size), material);
        const along = ((k + 0.5) / count - 0.5) * long;
        head.position.set(Math.cos(angle) * along, Math.sin(angle) * along, z / 2 + 0.001);
        head.rotation.z = angle + backwards;
        group.add(head);
      }
    } else {
      for (let k = 0; k < 6; k++) {
        const angle = (k * Math.PI) / 3;
        const head = new Mesh(chevron(0.25 * one.radius), material);
        head.position.set(0.75 * one.radius * Math.cos(angle), 0.75 * one.radius * Math.sin(angle), 0.001);
        head.rotation.z = angle + Math.PI / 2 + backwards;
        group.add(head);
      }
    }
    this.arrows.push(material);
    this.root.add(group);
  }

  private detector(one: DetectorTable): void {
    const material = new MeshBasicMaterial({ color: LIGHT, transparent: true, depthWrite: false });
    const rods: Mesh[] = [];
    if (one.kind === "presence") {
      const solid = shapeOf("box", one.size);
      const mesh = new Mesh(solid, material);
      place(mesh, one.pose);
      const edges = new LineSegments(new EdgesGeometry(solid), new LineBasicMaterial({ color: LIGHT }));
      place(edges, one.pose);
      this.named(mesh, one.name, true);
      this.root.add(mesh, edges);
      this.lights.push({ material, rods, dim: 0.06, bright: 0.45 });
      return;
    }
    const group = new Group();
    if (one.kind === "distance") place(group, one.pose);
    const vector = (point: readonly number[]): Vector3 =>
      new Vector3(...(point as [number, number, number])).applyMatrix4(group.matrix);
    const [from, until] =
      one.kind === "beam" ? [vector(one.from), vector(one.until)] : [vector([0, 0, 0]), vector([0, 0, one.range])];
    const housing = new MeshStandardMaterial({ color: BELT, roughness: 0.6 });
    for (const end of one.kind === "beam" ? [from, until] : [from]) {
      const eye = new Mesh(new BoxGeometry(0.02, 0.02, 0.02), housing);
      eye.position.copy(end);
      this.named(eye, one.name);
      this.root.add(eye);
    }
    const mesh = rod(from, until, material);
    this.named(mesh, one.name);
    rods.push(mesh);
    this.root.add(mesh);
    this.lights.push({ material, rods, dim: 0.4, bright: 1 });
  }

  private sink(one: WorldScene["sinks"][number]): void {
    const solid = shapeOf("box", one.size);
    const mesh = new Mesh(
      solid,
      new MeshBasicMaterial({ color: SINK, transparent: true, opacity: 0.1, depthWrite: false, side: DoubleSide }),
    );
    const edges = new LineSegments(
      new EdgesGeometry(solid),
      new LineBasicMaterial({ color: SINK, transparent: true, opacity: 0.7 }),
    );
    place(mesh, one.pose);
    place(edges, one.pose);
    this.named(mesh, one.name, true);
    this.root.add(mesh, edges);
  }

  private gripper(one: GripperTable, number: number): void {
    this.cups[number] = [];
    if (one.kind === "vacuum") {
      const direction = new Vector3(...(one.direction as [number, number, number])).normalize();
      for (const rim of one.cups) {
        const material = new MeshStandardMaterial({ color: CUP, roughness: 0.7 });
        const cup = new Mesh(new CylinderGeometry(one.radius, 0.6 * one.radius, CUP_DEPTH, 20), material);
        cup.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), direction);
        cup.position.set(...(rim as [number, number, number])).addScaledVector(direction, -CUP_DEPTH / 2);
        this.named(cup, one.name);
        this.cups[number].push(material);
        this.flange.add(cup);
      }
      return;
    }
    const axis = new Vector3(...(one.axis as [number, number, number])).normalize();
    const shape = solidOf(one, this.meshes);
    const material = new MeshStandardMaterial({ color: CUP, roughness: 0.6, flatShading: shape.isMesh });
    const finger = (): Mesh => {
      const mesh = bodyOf(shape, material);
      mesh.add(new LineSegments(shape.edges, this.edges));
      this.named(mesh, one.name);
      this.flange.add(mesh);
      return mesh;
    };
    const meshes: [Mesh, Mesh] = [finger(), finger()];
    // Half a turn makes the mirror image of a box, a cylinder and a ball; that of a mesh needs a point mirror as well.
    if (shape.isMesh) meshes[1].scale.set(-1, -1, -1);
    this.fingers.push({ gripper: number, axis, meshes });
  }

  private shapesOf(table: PartTable): Solid & { material: MeshStandardMaterial } {
    let made = this.shapes.get(table);
    if (!made) {
      const shape = solidOf(table, this.meshes);
      made = {
        ...shape,
        material: new MeshStandardMaterial({ color: table.color ?? PART, roughness: 0.75, flatShading: shape.isMesh }),
      };
      this.shapes.set(table, made);
    }
    return made;
  }

  private drawn(name: string): DrawnPart | null {
    const known = this.parts.get(name);
    if (known) return known;
    const table = tableOf(this.scene, name);
    if (!table) return null;
    const shape = this.shapesOf(table);
    const group = new Group();
    const mesh = bodyOf(shape, shape.material);
    mesh.userData["name"] = name;
    mesh.userData["part"] = true;
    group.add(mesh, new LineSegments(shape.edges, this.edges));
    const part = { group, base: [] };
    this.parts.set(name, part);
    this.root.add(group);
    return part;
  }

  /** Everything at a moment, with the flange where the arm is drawn; true when something is otherwise. */
  show(moment: WorldMoment | null, flange: Matrix): boolean {
    const isSame = moment === this.moment;
    const stays = isSame && flange.every((x, k) => Math.abs(x - (this.frame[k] ?? 0)) < 1e-7);
    if (stays) return false;
    this.moment = moment;
    this.frame = flange;
    place(this.flange, flange);
    const seen = new Set<string>();
    for (const part of moment?.parts ?? []) {
      const drawn = this.drawn(part.name);
      if (!drawn) continue;
      seen.add(part.name);
      if (isSame && part.held_by === undefined) continue;
      drawn.base = partMatrix(part, flange);
      place(drawn.group, drawn.base);
    }
    if (isSame) return true;
    for (const [name, { group }] of this.parts) {
      if (seen.has(name)) continue;
      this.root.remove(group);
      this.parts.delete(name);
    }
    this.arrows.forEach((material, k) => (material.opacity = (moment?.conveyors[k] ?? 0) === 0 ? 0.25 : 0.95));
    this.lights.forEach((light, k) => {
      const isCut = moment?.detectors[k] ?? false;
      light.material.opacity = isCut ? light.bright : light.dim;
      for (const one of light.rods) one.scale.set(isCut ? 2.2 : 1, 1, isCut ? 2.2 : 1);
    });
    this.cups.forEach((cups, k) =>
      cups.forEach((material, n) => material.color.set(moment?.grippers[k]?.sealed[n] ? CUP_SEALED : CUP)),
    );
    for (const { gripper, axis, meshes } of this.fingers) {
      const table = this.scene.grippers[gripper];
      if (table?.kind !== "fingers") continue;
      const half = (moment?.grippers[gripper]?.width ?? 0) / 2;
      const closed = new Matrix4();
      const m = table.pose;
      const a = (k: number): number => m[k] ?? 0;
      closed.set(a(0), a(1), a(2), a(3), a(4), a(5), a(6), a(7), a(8), a(9), a(10), a(11), 0, 0, 0, 1);
      const [position, turn] = [new Vector3(), new Quaternion()];
      closed.decompose(position, turn, new Vector3());
      meshes[0].position.copy(position).addScaledVector(axis, half);
      meshes[0].quaternion.copy(turn);
      // The other finger is the mirror image: turned by half a turn about the axis, and mirrored at its origin where
      // that shows.
      const across = position.dot(axis);
      meshes[1].position.copy(position).addScaledVector(axis, -2 * across - half);
      meshes[1].quaternion.copy(mirrored(turn, axis));
    }
    return true;
  }

  /** Where a part would be put; null for none. */
  setGhost(name: string | null, pose: readonly number[] = []): void {
    if (this.ghost && this.ghost.name !== name) {
      this.root.remove(this.ghost.group);
      this.ghost = null;
    }
    if (name === null) return;
    if (!this.ghost) {
      const table = tableOf(this.scene, name);
      if (!table) return;
      const shape = this.shapesOf(table);
      const group = new Group();
      group.add(
        bodyOf(
          shape,
          new MeshStandardMaterial({
            color: this.theme.ghost,
            transparent: true,
            opacity: 0.45,
            depthWrite: false,
            flatShading: shape.isMesh,
          }),
        ),
      );
      group.add(new LineSegments(shape.edges, new LineBasicMaterial({ color: this.theme.ghost })));
      this.root.add(group);
      this.ghost = { name, group };
      (group.children[0] as Object3D).userData["name"] = name;
      (group.children[0] as Object3D).userData["part"] = true;
    }
    place(this.ghost.group, fromPose(pose));
  }

  /** What is under a place of the picture, -1 to 1 in both directions. */
  at(x: number, y: number, camera: Camera): Pointed | null {
    this.root.updateMatrixWorld();
    this.ray.setFromCamera(new Vector2(x, y), camera);
    const parts = [...this.parts.values()].flatMap(({ group }) => group.children.slice(0, 1));
    const ghost = this.ghost?.group.children.slice(0, 1) ?? [];
    const hits = this.ray.intersectObjects([...ghost, ...parts, ...this.pickables], false).map(({ object }) => object);
    // What is seen through is pointed at only where nothing lies behind it.
    const hit = hits.find((object) => object.userData["glass"] !== true) ?? hits[0];
    return hit ? { name: String(hit.userData["name"]), isPart: hit.userData["part"] === true } : null;
  }

  /** The point of the level at height `z` under a place of the picture. */
  onLevel(x: number, y: number, z: number, camera: Camera): Vector3 | null {
    this.ray.setFromCamera(new Vector2(x, y), camera);
    return this.ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), -z), new Vector3());
  }

  /** Where a part is drawn, its middle. */
  middleOf(name: string): Vector3 | null {
    if (this.ghost?.name === name) return new Vector3().setFromMatrixPosition(this.ghost.group.matrix);
    const part = this.parts.get(name);
    return part ? new Vector3().setFromMatrixPosition(part.group.matrix) : null;
  }

  figures(): CellFigures {
    const of = <T, V>(
      rows: readonly T[],
      named: readonly { name: string }[],
      value: (row: T) => V,
    ): Record<string, V> => Object.fromEntries(rows.map((row, k) => [named[k]?.name ?? String(k), value(row)]));
    return {
      parts: Object.fromEntries([...this.parts].map(([name, part]) => [name, part.base])),
      lit: of(this.lights, this.scene.detectors, (light) => light.material.opacity === light.bright),
      running: of(this.arrows, this.scene.conveyors, (material) => material.opacity > 0.5),
      sealed: of(this.cups, this.scene.grippers, (cups) =>
        cups.map((material) => material.color.getHex() === CUP_SEALED),
      ),
      width: of(this.moment?.grippers ?? [], this.scene.grippers, (gripper) => gripper.width),
      ghost: this.ghost?.name ?? null,
    };
  }

  /** Gives back what the graphics card keeps. */
  dispose(): void {
    this.root.traverse((object) => {
      if (object instanceof Mesh || object instanceof LineSegments) (object.geometry as BufferGeometry).dispose();
    });
    // Of parts that are gone now the shapes are still there.
    for (const { solid, edges } of this.shapes.values()) for (const one of [solid, edges]) one.dispose();
  }
}

/** The turn of the mirror image of a shape across an axis. */
function mirrored(turn: Quaternion, axis: Vector3): Quaternion {
  // A mirror is half a turn about its axis and a reflection at the origin, which only a mesh shows.
  return new Quaternion().setFromAxisAngle(axis, Math.PI).multiply(turn);
}
