// The arm in 3D: its shapes with edges, what stands around it, the way of the TCP, force, target and ghost.
// Draws only when something has changed, and coarser where drawing is slow (software rendering).

// prettier-ignore
import {
  AmbientLight, ArrowHelper, AxesHelper, BackSide, Box3, BoxGeometry, type BufferGeometry, CapsuleGeometry,
  CylinderGeometry, DirectionalLight, DoubleSide, EdgesGeometry, GridHelper, Group, HemisphereLight, LineBasicMaterial,
  LineSegments, NotEqualStencilFunc, ReplaceStencilOp, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial,
  type Object3D, PerspectiveCamera, PlaneGeometry, Quaternion, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { type CellFigures, CellView, type Pointed } from "./cellview";
import { forward, fromPose, type Matrix } from "./kinematics";
import type { Piece } from "./path";
import { PathView } from "./pathview";
import { bodyOf, type MeshLoader, MeshStore, type ShapeRow, type Solid, solidOf, topOf } from "./shapes";
import type { WorldMoment, WorldScene } from "./world";

export interface SceneData {
  model: string;
  joints: number[][];
  flange: number[];
  links: { from: number[]; to: number[]; radius: number }[][];
  position_min: number[];
  position_max: number[];
  obstacles: (ShapeRow & { name: string; pose: number[]; stiffness: number | null })[];
  /** What hangs on the flange, in its frame. */
  tool?: (ShapeRow & { pose: number[] }) | null;
  planes: { name: string; point: number[]; normal: number[]; mode: string }[];
  /** Where the arm stands at the start, rad. */
  home?: number[];
  names?: Record<string, string>;
  wires?: { from: string; to: string }[];
  safety_inputs?: { points: string[]; function: string }[];
  /** What lives in the cell. */
  world?: WorldScene | null;
}

export interface Shown {
  actualQ: readonly number[];
  targetQ: readonly number[];
  tcpOffset: readonly number[];
  tcpForce: readonly number[];
  time: number;
}

/** Marks on a path that have a text: more of them would cover what they are about. */
const MARK_TEXTS = 3;
/** Joints that are nearer to each other have one ring, m. */
const RING_APART = 0.03;
/** Where the light for the shadow on the ground stands: far above, a little aside. */
const LIGHT = [0.28, -0.22, 1] as const;
/** The name of the tool where it needs one. */
const TOOL = "tool";
const NEWTON_LENGTH = 0.004;
const ARROW_MAX = 0.6;

// prettier-ignore
const themes = {
  dark: {
    ground: 0x2a313b, ground2: 0x20262e, light: 0xdfe4ea, dark: 0x6a7688, tool: 0x566173, accent: 0xff7a2f,
    outline: 0x0b0e12, driven: 0x46b1ff, old: 0x28506e, planned: 0xf2c14e, touch: 0xff5a60, ghost: 0x37d0a0,
    shadow: 0.42,
  },
  light: {
    ground: 0xb8c0ca, ground2: 0xd4dae1, light: 0xf4f6f8, dark: 0x7f8c9e, tool: 0x6b7789, accent: 0xe8590c,
    outline: 0x39424e, driven: 0x0b62d6, old: 0x9dbbdc, planned: 0xa86e00, touch: 0xc81e2a, ghost: 0x0c9b6f,
    shadow: 0.16,
  },
};

function matrix4(m: Matrix): Matrix4 {
  const a = (k: number): number => m[k] ?? 0;
  return new Matrix4().set(a(0), a(1), a(2), a(3), a(4), a(5), a(6), a(7), a(8), a(9), a(10), a(11), 0, 0, 0, 1);
}

function place(object: Object3D, m: Matrix): void {
  object.matrixAutoUpdate = false;
  object.matrix.copy(matrix4(m));
  object.matrixWorldNeedsUpdate = true;
}

/**
 * A text that floats at a place: an element over the picture, so that it is as sharp as any other text, whatever lies
 * behind.
 */
interface Label {
  element: HTMLElement;
  at: Vector3;
}

/** A movement of the mouse below this is a click, px. */
const CLICK_PX = 4;

/** What people do with the things of the cell. */
export interface CellHands {
  /** What is said of a thing under the pointer. */
  describe: (pointed: Pointed) => string;
  /** A part was clicked. */
  pick: (part: string) => void;
  /** The part that may be moved by the mouse now. */
  movable: () => string | null;
  drag: (x: number, y: number) => void;
}

/** A mesh that could not be fetched, and why. */
export interface MissingMesh {
  number: number;
  reason: unknown;
}

/** For tests: a thing with a shape, and the box around it in the base frame. */
export interface ShapeFigures {
  name: string;
  triangles: number;
  low: number[];
  high: number[];
  isMirrored: boolean;
}

class Arm {
  readonly root = new Group();
  /** The arm pressed flat on the ground along the light. */
  readonly shadow = new Group();
  private readonly links: Group[] = [];
  private readonly shadows: Group[] = [];
  /** Goes along with the flange. */
  private readonly flange = new Group();

  constructor(data: SceneData, ghost: number | null, theme: (typeof themes)["dark"], tool: Solid | null) {
    this.root.add(this.flange);
    if (data.tool && tool) this.flange.add(this.tool(data.tool.pose, tool, ghost, theme));
    const outline = new MeshBasicMaterial({ color: theme.outline, side: BackSide });
    // Each place of the ground is darkened once, whatever lies above it.
    const dark = new MeshBasicMaterial({
      color: 0x000000,
      transparent: true,
      opacity: theme.shadow,
      depthWrite: false,
      stencilWrite: true,
      stencilRef: 1,
      stencilFunc: NotEqualStencilFunc,
      stencilZPass: ReplaceStencilOp,
    });
    const [lx, ly, lz] = LIGHT;
    this.shadow.matrixAutoUpdate = false;
    this.shadow.matrix.set(1, 0, -lx / lz, 0, 0, 1, -ly / lz, 0, 0, 0, 0, 0.0005, 0, 0, 0, 1);
    data.links.forEach((capsules, index) => {
      const group = new Group();
      const flat = new Group();
      const material =
        ghost === null
          ? new MeshStandardMaterial({
              color: index % 2 === 0 ? theme.light : theme.dark,
              roughness: 0.45,
              metalness: 0.12,
            })
          : new MeshStandardMaterial({ color: ghost, transparent: true, opacity: 0.32, depthWrite: false });
      for (const { from, to, radius } of capsules) {
        const [a, b] = [new Vector3(...from), new Vector3(...to)];
        const axis = b.clone().sub(a);
        const length = axis.length();
        const turn = new Quaternion().setFromUnitVectors(
          new Vector3(0, 1, 0),
          length > 1e-9 ? axis.normalize() : new Vector3(0, 1, 0),
        );
        const add = (to: Group, r: number, m: MeshStandardMaterial | MeshBasicMaterial, sides = 28): void => {
          const mesh = new Mesh(new CapsuleGeometry(r, length, sides === 28 ? 8 : 4, sides), m);
          mesh.position.copy(a).add(b).multiplyScalar(0.5);
          mesh.quaternion.copy(turn);
          to.add(mesh);
        };
        add(group, radius, material);
        if (ghost === null) {
          add(group, radius + 0.0035, outline);
          add(flat, radius, dark, 12);
        }
      }
      const [x = 0, y = 0, z = 0] = [3, 7, 11].map((k) => data.joints[index - 1]?.[k] ?? 0);
      if (ghost === null && index > 0 && Math.hypot(x, y, z) > RING_APART) {
        // A ring where the joint turns; two joints at one place have one.
        const radius = Math.max(0.04, ...capsules.map((capsule) => capsule.radius)) * 1.02;
        const ring = new Mesh(
          new CylinderGeometry(radius, radius, 0.016, 40, 1, true),
          new MeshStandardMaterial({ color: theme.accent, roughness: 0.5, side: DoubleSide }),
        );
        ring.rotation.x = Math.PI / 2;
        group.add(ring);
      }
      this.links.push(group);
      this.root.add(group);
      this.shadows.push(flat);
      this.shadow.add(flat);
    });
  }

  private tool(pose: Matrix, shape: Solid, ghost: number | null, theme: (typeof themes)["dark"]): Group {
    const look =
      ghost === null
        ? { color: theme.tool, roughness: 0.5, metalness: 0.12 }
        : { color: ghost, transparent: true, opacity: 0.32, depthWrite: false };
    const group = new Group();
    const body = bodyOf(shape, new MeshStandardMaterial({ ...look, flatShading: shape.isMesh }));
    body.userData["name"] = TOOL;
    group.add(body);
    if (ghost === null)
      group.add(
        new LineSegments(shape.edges, new LineBasicMaterial({ color: theme.outline, transparent: true, opacity: 0.6 })),
      );
    place(group, pose);
    return group;
  }

  show(frames: number[][]): void {
    place(this.flange, frames[7] ?? []);
    this.links.forEach((link, k) => place(link, frames[k] ?? []));
    this.shadows.forEach((link, k) => place(link, frames[k] ?? []));
  }
}

export class View {
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(38, 1, 0.02, 40);
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private world = new Group();
  private arm: Arm | null = null;
  private ghost: Arm | null = null;
  private ghostQ: readonly number[] | null = null;
  private readonly tcpAxes = new AxesHelper(0.12);
  private readonly targetAxes = new AxesHelper(0.06);
  private readonly force = new ArrowHelper(new Vector3(0, 0, 1), new Vector3(), 0.1, 0xe5484d, 0.04, 0.024);
  private readonly paths = new PathView(themes.dark);
  private marks: Label[] = [];
  private data: SceneData | null = null;
  private labels: Label[] = [];
  private cell: CellView | null = null;
  private moment: WorldMoment | null = null;
  /** Obstacles by name, with their text: actuators move them. */
  private readonly obstacles = new Map<string, { group: Group; label: Label; top: Vector3; rest: number[] }>();
  private moved = new Set<string>();
  private flange: number[] = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
  private pointed: { label: Label; name: string } | null = null;
  private placing: { part: string; pose: readonly number[] } | null = null;
  private meshes: MeshStore | null = null;
  private missing: MissingMesh[] = [];
  /** What happens to things of the cell. */
  hands: CellHands | null = null;
  /** The meshes that could not be fetched are others now. */
  onMissing: (missing: readonly MissingMesh[]) => void = () => undefined;
  private shown: Shown | null = null;
  private dirty = true;
  private readonly isSoft: boolean;
  private slowness = 0;
  private drawnAt = 0;
  private theme = themes.dark;
  frames = 0;

  constructor(
    private readonly host: HTMLElement,
    private readonly loadMesh: MeshLoader,
  ) {
    const drawer = drawerName();
    if (drawer === null) throw new Error("WebGL is off");
    this.isSoft = /swiftshader|llvmpipe|software|basic render/i.test(drawer);
    this.renderer = new WebGLRenderer({
      antialias: !this.isSoft,
      alpha: true,
      stencil: true,
      powerPreference: "low-power",
    });
    this.renderer.setPixelRatio(this.isSoft ? 0.85 : Math.min(devicePixelRatio, 2));
    this.host.prepend(this.renderer.domElement);
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    this.listen();
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => (this.dirty = true));
    this.controls.maxDistance = 12;
    this.controls.minDistance = 0.25;
    const sun = new DirectionalLight(0xffffff, 2.1);
    sun.position.set(2.5, -2, 4);
    const fill = new DirectionalLight(0xffffff, 0.6);
    fill.position.set(-3, 2, 1.5);
    this.force.visible = false;
    this.scene.add(new HemisphereLight(0xffffff, 0x667788, 0.9), new AmbientLight(0xffffff, 0.35), sun, fill);
    this.scene.add(this.world, this.paths.root, this.tcpAxes, this.targetAxes, this.force);
    this.resetCamera();
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
    requestAnimationFrame(() => this.draw());
  }

  resetCamera(): void {
    const reach = this.reach();
    this.camera.position.set(reach * 1.15, -reach * 1.75, reach * 1.05);
    this.controls.target.set(-reach * 0.22, 0, reach * 0.36);
    this.controls.update();
    this.dirty = true;
  }

  setTheme(name: "dark" | "light"): void {
    this.theme = themes[name];
    this.paths.setColors(this.theme);
    if (this.data) this.setScene(this.data);
    this.dirty = true;
  }

  setScene(data: SceneData): void {
    const isFirst = this.data?.model !== data.model;
    // In other colours the scene is the same, and so are its meshes.
    const meshes = this.meshes !== null && this.data === data ? this.meshes : this.otherMeshes();
    this.data = data;
    this.scene.remove(this.world);
    this.world.traverse((object) => {
      if (object instanceof Mesh || object instanceof LineSegments) (object.geometry as BufferGeometry).dispose();
    });
    this.world = new Group();
    const grid = new GridHelper(3, 30, this.theme.ground, this.theme.ground2);
    grid.rotation.x = Math.PI / 2;
    grid.position.z = -0.001;
    // It fades into the distance instead of ending.
    (grid.material as LineBasicMaterial).transparent = true;
    (grid.material as LineBasicMaterial).opacity = 0.75;
    const base = new AxesHelper(0.25);
    const tool = data.tool ? solidOf(data.tool, meshes) : null;
    this.arm = new Arm(data, null, this.theme, tool);
    this.ghost = new Arm(data, this.theme.ghost, this.theme, tool);
    this.ghost.root.visible = this.ghostQ !== null;
    this.world.add(grid, base, this.arm.shadow, this.arm.root, this.ghost.root);
    for (const label of this.labels) if (!this.marks.includes(label)) label.element.remove();
    this.labels = [...this.marks];
    this.pointed = null;
    this.obstacles.clear();
    this.moved.clear();
    for (const obstacle of data.obstacles) this.world.add(this.obstacle(obstacle, meshes));
    this.cell?.dispose();
    this.cell = data.world ? new CellView(data.world, this.theme, meshes) : null;
    if (this.cell) this.world.add(this.cell.root);
    for (const plane of data.planes) if (plane.mode !== "off") this.world.add(this.plane(plane));
    this.scene.add(this.world);
    if (isFirst) this.resetCamera();
    if (this.shown) this.show(this.shown, true);
    this.showWorld(this.moment);
    if (this.placing) this.setPartGhost(this.placing.part, this.placing.pose);
    if (this.ghostQ) this.setGhost(this.ghostQ);
    this.dirty = true;
  }

  /** The meshes of a scene that is another one. */
  private otherMeshes(): MeshStore {
    this.meshes?.dispose();
    const filled = (): void => {
      this.dirty = true;
    };
    this.meshes = new MeshStore(this.loadMesh, filled, (number, reason) => {
      this.missing.push({ number, reason });
      this.onMissing(this.missing);
    });
    this.missing = [];
    this.onMissing(this.missing);
    return this.meshes;
  }

  private reach(): number {
    const joints = this.data?.joints ?? [];
    const sum = joints.reduce((total, m) => total + Math.hypot(m[3] ?? 0, m[7] ?? 0, m[11] ?? 0), 0);
    return sum > 0.2 ? sum * 0.78 : 0.9;
  }

  private obstacle(one: SceneData["obstacles"][number], meshes: MeshStore): Group {
    const group = new Group();
    place(group, one.pose);
    const label = this.label(one.name, new Vector3());
    const obstacle = { group, label, top: new Vector3(), rest: one.pose };
    const putLabel = (solid: BufferGeometry): void => {
      obstacle.top = topOf(solid);
      label.at.copy(obstacle.top).applyMatrix4(group.matrix);
    };
    const isPlane = one.shape === "plane";
    const slab = isPlane ? new BoxGeometry(3, 3, 0.004).translate(0, 0, -0.002) : null;
    const shape: Solid = slab
      ? { solid: slab, edges: new EdgesGeometry(slab, 30), isMesh: false }
      : solidOf(one, meshes, putLabel);
    if (!shape.isMesh) putLabel(shape.solid);
    const soft = one.stiffness !== null;
    // Behind a face of a mesh others may lie, in any order: those that are seen through would flicker.
    const look = shape.isMesh ? { flatShading: true } : { transparent: true, opacity: isPlane ? 0.35 : 0.85 };
    const body = bodyOf(
      shape,
      new MeshStandardMaterial({ color: soft ? 0x7aa06a : 0x9d8f6f, roughness: 0.8, ...look }),
    );
    body.userData["name"] = one.name;
    group.add(
      body,
      new LineSegments(
        shape.edges,
        new LineBasicMaterial({ color: this.theme.outline, transparent: true, opacity: 0.6 }),
      ),
    );
    this.obstacles.set(one.name, obstacle);
    return group;
  }

  private plane(one: SceneData["planes"][number]): Group {
    const group = new Group();
    const color = one.mode === "reduced" ? 0xf5a524 : 0xe5484d;
    const shape = new PlaneGeometry(1.6, 1.6, 8, 8);
    group.add(
      new Mesh(
        shape,
        new MeshBasicMaterial({ color, transparent: true, opacity: 0.06, side: DoubleSide, depthWrite: false }),
      ),
    );
    group.add(
      new LineSegments(
        new EdgesGeometry(new PlaneGeometry(1.6, 1.6)),
        new LineBasicMaterial({ color, transparent: true, opacity: 0.65 }),
      ),
    );
    group.add(new ArrowHelper(new Vector3(0, 0, 1), new Vector3(), 0.2, color, 0.06, 0.03));
    group.position.set(...(one.point as [number, number, number]));
    group.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...one.normal).normalize());
    group.updateMatrix();
    this.label(one.name, new Vector3(0, 0.7, 0.02).applyMatrix4(group.matrix));
    return group;
  }

  private label(text: string, at: Vector3, most = 40): Label {
    const element = document.createElement("span");
    element.className = "label";
    element.textContent = text.slice(0, most);
    document.getElementById("labels")?.append(element);
    const label = { element, at };
    this.labels.push(label);
    return label;
  }

  /** Parts and what handles them at a moment; null where nothing is known of one. */
  showWorld(moment: WorldMoment | null): void {
    const isOther = moment !== this.moment;
    this.moment = moment;
    if (!this.cell) return;
    if (this.cell.show(moment, this.flange)) this.dirty = true;
    if (!isOther && this.moved.size > 0) return;
    const moved = new Map((moment?.obstacles ?? []).map((one) => [one.name, one.pose]));
    for (const name of new Set([...moved.keys(), ...this.moved])) {
      const obstacle = this.obstacles.get(name);
      if (!obstacle) continue;
      const pose = moved.get(name);
      place(obstacle.group, pose ? fromPose(pose) : obstacle.rest);
      obstacle.label.at.copy(obstacle.top).applyMatrix4(obstacle.group.matrix);
      this.dirty = true;
    }
    this.moved = new Set(moved.keys());
  }

  /** Where a part would be put; null hides it. */
  setPartGhost(part: string | null, pose: readonly number[] = []): void {
    this.placing = part === null ? null : { part, pose };
    this.cell?.setGhost(part, pose);
    this.dirty = true;
  }

  /** For tests: what is drawn of the cell, and where a part is in the picture, px. */
  figures(): CellFigures | null {
    return this.cell?.figures() ?? null;
  }

  /** For tests: everything with a name and a shape. */
  shapeFigures(): ShapeFigures[] {
    const rows: ShapeFigures[] = [];
    this.world.updateMatrixWorld(true);
    for (const root of [this.arm?.root, this.cell?.root, ...[...this.obstacles.values()].map(({ group }) => group)]) {
      root?.traverse((object) => {
        const name: unknown = object.userData["name"];
        if (!(object instanceof Mesh) || typeof name !== "string") return;
        const solid = object.geometry as BufferGeometry;
        const { min, max } = new Box3().setFromObject(object, true);
        const triangles = (solid.index?.count ?? solid.getAttribute("position")?.count ?? 0) / 3;
        rows.push({
          name,
          triangles,
          low: min.toArray(),
          high: max.toArray(),
          isMirrored: object.matrixWorld.determinant() < 0,
        });
      });
    }
    return rows;
  }

  pixelOf(part: string): [number, number] | null {
    const middle = this.cell?.middleOf(part);
    return middle ? this.pixelAt(middle.toArray()) : null;
  }

  /** For tests: where a point of the base frame is in the picture, px. */
  pixelAt(point: readonly number[]): [number, number] {
    const seen = new Vector3(point[0], point[1], point[2]).project(this.camera);
    const box = this.renderer.domElement.getBoundingClientRect();
    return [box.left + ((seen.x + 1) / 2) * box.width, box.top + ((1 - seen.y) / 2) * box.height];
  }

  /** Names under the pointer, parts that are clicked, and the chosen one dragged over its level. */
  private listen(): void {
    const canvas = this.renderer.domElement;
    const at = (event: PointerEvent): [number, number] => {
      const box = canvas.getBoundingClientRect();
      return [((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2];
    };
    let pressed: { x: number; y: number; on: Pointed | null } | null = null;
    let drag: { z: number; dx: number; dy: number } | null = null;
    // Before the camera's controls, which would turn the view.
    this.host.addEventListener(
      "pointerdown",
      (event) => {
        if (event.target !== canvas || event.button !== 0) return;
        const on = this.cell?.at(...at(event), this.camera) ?? null;
        pressed = { x: event.clientX, y: event.clientY, on };
        const middle = on?.isPart && on.name === this.hands?.movable() ? this.cell?.middleOf(on.name) : null;
        const level = middle ? this.cell?.onLevel(...at(event), middle.z, this.camera) : null;
        if (!middle || !level) return;
        drag = { z: middle.z, dx: middle.x - level.x, dy: middle.y - level.y };
        event.stopPropagation();
        canvas.setPointerCapture(event.pointerId);
      },
      { capture: true },
    );
    canvas.addEventListener("pointermove", (event) => {
      if (drag) {
        const level = this.cell?.onLevel(...at(event), drag.z, this.camera);
        const isDragged =
          pressed !== null && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > CLICK_PX;
        if (level && isDragged) this.hands?.drag(level.x + drag.dx, level.y + drag.dy);
        return;
      }
      if (event.buttons === 0) this.point(this.cell?.at(...at(event), this.camera) ?? null, event);
    });
    const end = (event: PointerEvent): void => {
      const isClick = pressed !== null && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) <= CLICK_PX;
      if (isClick && event.type === "pointerup") {
        if (pressed?.on?.isPart) this.hands?.pick(pressed.on.name);
        // A finger has no pointer that hovers.
        if (event.pointerType !== "mouse") this.point(pressed?.on ?? null, event);
      }
      pressed = null;
      drag = null;
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("pointerleave", () => this.point(null, null));
  }

  /** The name of what is under the pointer, beside it. */
  private point(pointed: Pointed | null, event: PointerEvent | null): void {
    if (this.pointed?.name === pointed?.name) return;
    if (this.pointed) {
      this.pointed.label.element.remove();
      this.labels = this.labels.filter((label) => label !== this.pointed?.label);
      this.pointed = null;
    }
    this.host.classList.toggle("on-part", pointed?.isPart ?? false);
    if (!pointed || !event) return;
    const box = this.renderer.domElement.getBoundingClientRect();
    const [x, y] = [
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top - 26) / box.height) * 2,
    ];
    const label = this.label(
      this.hands?.describe(pointed) ?? pointed.name,
      new Vector3(x, y, 0.9).unproject(this.camera),
    );
    label.element.setAttribute("data-testid", "view-name");
    this.pointed = { label, name: pointed.name };
    this.placeLabels();
  }

  /** Moves the texts to where their things are seen; those beside the picture or behind the camera are not shown. */
  private placeLabels(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    for (const { element, at } of this.labels) {
      const seen = at.clone().project(this.camera);
      const isSeen = Math.abs(seen.x) < 0.98 && Math.abs(seen.y) < 0.98 && seen.z < 1;
      element.hidden = !isSeen;
      const [x, y] = [((seen.x + 1) / 2) * width, ((1 - seen.y) / 2) * height];
      if (isSeen) element.style.transform = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  }

  /** The arm at a moment. After a jump in time the way begins anew. */
  show(shown: Shown, jumped = false): void {
    const before = this.shown;
    this.shown = shown;
    if (!this.data || !this.arm) return;
    const isSame =
      !jumped && before !== null && before.actualQ.every((q, k) => Math.abs(q - (shown.actualQ[k] ?? 0)) < 1e-6);
    const forceChanged =
      before === null || before.tcpForce.some((f, k) => Math.abs(f - (shown.tcpForce[k] ?? 0)) > 0.5);
    const targetChanged =
      before === null || before.targetQ.some((q, k) => Math.abs(q - (shown.targetQ[k] ?? 0)) > 1e-6);
    if (isSame && !forceChanged && !targetChanged) return;
    const frames = forward(this.data.joints, this.data.flange, shown.actualQ, shown.tcpOffset);
    this.arm.show(frames);
    this.flange = frames[7] ?? this.flange;
    this.showWorld(this.moment);
    const tcp = frames[8] ?? [];
    place(this.tcpAxes, tcp);
    const target = forward(this.data.joints, this.data.flange, shown.targetQ, shown.tcpOffset)[8] ?? [];
    place(this.targetAxes, target);
    this.showForce(tcp, shown.tcpForce);
    this.paths.setTip(jumped ? null : [tcp[3] ?? 0, tcp[7] ?? 0, tcp[11] ?? 0]);
    this.dirty = true;
  }

  private showForce(tcp: Matrix, wrench: readonly number[]): void {
    const [x = 0, y = 0, z = 0] = wrench;
    const force = new Vector3(x, y, z);
    const newtons = force.length();
    this.force.visible = newtons >= 1;
    if (!this.force.visible) return;
    const frame = matrix4(tcp);
    const direction = force.transformDirection(frame);
    const length = Math.min(newtons * NEWTON_LENGTH, ARROW_MAX);
    this.force.position.setFromMatrixPosition(frame);
    this.force.setDirection(direction);
    this.force.setLength(Math.max(length, 0.02), Math.min(0.05, length * 0.4), 0.03);
  }

  /** The path that the TCP has driven; none hides it. */
  setDriven(pieces: Piece[], now: number, isLive: boolean): void {
    this.paths.setDriven(pieces, now, isLive);
    this.dirty = true;
  }

  /** The path that a program would drive, and where it comes near to something, the nearest first. */
  setPlanned(pieces: Piece[], places: readonly { at: readonly number[]; touches: boolean; text: string }[]): void {
    this.paths.setPlanned(pieces);
    this.paths.setMarks(places.map(({ at, touches }) => ({ at, touches })));
    for (const { element } of this.marks) element.remove();
    this.labels = this.labels.filter((label) => !this.marks.includes(label));
    this.marks = places.slice(0, MARK_TEXTS).map(({ at, touches, text }) => {
      const label = this.label(text, new Vector3(at[0], at[1], at[2]), 80);
      label.element.classList.add("mark");
      label.element.classList.toggle("touch", touches);
      label.element.setAttribute("data-testid", "path-mark");
      return label;
    });
    this.dirty = true;
  }

  /** For tests: what is drawn of the paths. */
  pathFigures(): ReturnType<PathView["figures"]> {
    return this.paths.figures();
  }

  /** Where the arm would go; null hides it. */
  setGhost(q: readonly number[] | null): void {
    this.ghostQ = q;
    if (!this.data || !this.ghost) return;
    this.ghost.root.visible = q !== null;
    if (q) this.ghost.show(forward(this.data.joints, this.data.flange, q, this.shown?.tcpOffset ?? []));
    this.dirty = true;
  }

  get ghostShown(): boolean {
    return this.ghost?.root.visible ?? false;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  /** Where drawing is slow it is done less often, so that buttons and signs of life are never late for it. */
  private draw(): void {
    requestAnimationFrame(() => this.draw());
    const now = performance.now();
    const pause = this.isSoft ? Math.min(200, Math.max(45, this.slowness * 2.5)) : this.slowness > 25 ? 30 : 0;
    if (!this.dirty || document.visibilityState === "hidden" || now - this.drawnAt < pause) return;
    this.dirty = false;
    this.drawnAt = now;
    this.renderer.render(this.scene, this.camera);
    this.placeLabels();
    this.frames += 1;
    // What drawing has cost shows in how late the next turn of the page comes.
    setTimeout(() => (this.slowness = 0.85 * this.slowness + 0.15 * (performance.now() - now)), 0);
  }
}

/** What draws here, as the browser names it; null where nothing does. */
function drawerName(): string | null {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return null;
  const info = context.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(context.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return name;
}
