// Paths of the TCP in the 3D view: the one that was driven, the one that is planned, and where it comes near to
// something.

import { Color, Group, type InterleavedBufferAttribute, Mesh, MeshBasicMaterial, SphereGeometry } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { linesOf, type Piece, strengthsOf } from "./path";

export interface PathColors {
  driven: number;
  /** What of it is long ago. */
  old: number;
  planned: number;
  touch: number;
}

/** Lines of the driven path that are drawn at most. */
const LINES_MAX = 3000;
const MARK_RADIUS = 0.011;

/** Lines with a width, which the thin ones of WebGL do not have; behind things they shimmer through. */
class Lines {
  readonly root = new Group();
  private geometry = new LineSegmentsGeometry();
  private readonly front: LineSegments2;
  private readonly behind: LineSegments2;

  constructor(look: { width: number; color: number; hasColors?: boolean; isDashed?: boolean; order: number }) {
    const common = {
      linewidth: look.width,
      color: look.hasColors ? 0xffffff : look.color,
      vertexColors: look.hasColors ?? false,
      dashed: look.isDashed ?? false,
      dashSize: 0.02,
      gapSize: 0.012,
    };
    // The later one lies over the other where both are at one place.
    const near = {
      transparent: true,
      polygonOffset: true,
      polygonOffsetFactor: -look.order,
      polygonOffsetUnits: -4 * look.order,
    };
    this.front = new LineSegments2(this.geometry, new LineMaterial({ ...common, ...near }));
    this.behind = new LineSegments2(
      this.geometry,
      new LineMaterial({ ...common, transparent: true, opacity: 0.28, depthTest: false, depthWrite: false }),
    );
    for (const [k, one] of [this.behind, this.front].entries()) {
      one.frustumCulled = false;
      one.renderOrder = look.order + k;
      this.root.add(one);
    }
    this.root.visible = false;
  }

  show(lines: Float32Array, colors: Float32Array | null): void {
    this.root.visible = lines.length > 0;
    this.geometry.dispose();
    this.geometry = new LineSegmentsGeometry();
    if (lines.length > 0) this.geometry.setPositions(lines);
    if (colors && colors.length > 0) this.geometry.setColors(colors);
    for (const one of [this.front, this.behind]) one.geometry = this.geometry;
    if (this.front.material.dashed && lines.length > 0) this.front.computeLineDistances();
  }

  /** Moves the ends of a single line. */
  stretch(from: readonly number[], to: readonly number[]): void {
    if (!this.geometry.hasAttribute("instanceStart")) this.show(new Float32Array(6), null);
    const { data } = this.geometry.getAttribute("instanceStart") as InterleavedBufferAttribute;
    [...from, ...to].forEach((value, k) => (data.array[k] = value));
    data.needsUpdate = true;
  }

  dispose(): void {
    this.geometry.dispose();
    this.front.material.dispose();
    this.behind.material.dispose();
  }
}

export class PathView {
  readonly root = new Group();
  private colors: PathColors;
  private drivenLines: Lines;
  private plannedLines: Lines;
  /** From the newest frame of the path to where the arm is drawn. */
  private tip: Lines;
  private readonly marks = new Group();
  private driven: Piece[] = [];
  private planned: Piece[] = [];
  private places: { at: readonly number[]; touches: boolean }[] = [];
  private now = 0;
  private isLive = true;

  constructor(colors: PathColors) {
    this.colors = colors;
    [this.plannedLines, this.drivenLines, this.tip] = this.make();
    this.root.add(this.marks);
  }

  private make(): [Lines, Lines, Lines] {
    const made: [Lines, Lines, Lines] = [
      new Lines({ width: 4.5, color: this.colors.planned, isDashed: true, order: 1 }),
      new Lines({ width: 2.5, color: this.colors.driven, hasColors: true, order: 3 }),
      new Lines({ width: 2.5, color: this.colors.driven, order: 3 }),
    ];
    this.root.add(...made.map((lines) => lines.root));
    return made;
  }

  setColors(colors: PathColors): void {
    this.colors = colors;
    for (const lines of [this.plannedLines, this.drivenLines, this.tip]) {
      this.root.remove(lines.root);
      lines.dispose();
    }
    [this.plannedLines, this.drivenLines, this.tip] = this.make();
    this.setDriven(this.driven, this.now, this.isLive);
    this.setPlanned(this.planned);
    this.setMarks(this.places);
  }

  /** The path that was driven up to a moment, and goes on after it where the moment is past. */
  setDriven(pieces: Piece[], now: number, isLive: boolean): void {
    [this.driven, this.now, this.isLive] = [pieces, now, isLive];
    const strengths = strengthsOf(pieces, now, isLive, LINES_MAX);
    const [old, fresh, color] = [new Color(this.colors.old), new Color(this.colors.driven), new Color()];
    const colors = new Float32Array(6 * strengths.length);
    strengths.forEach((strength, k) => {
      color.lerpColors(old, fresh, strength).toArray(colors, 6 * k);
      color.toArray(colors, 6 * k + 3);
    });
    this.drivenLines.show(linesOf(pieces, LINES_MAX), colors);
    this.setTip(null);
  }

  /** The arm is drawn more often than its path: up to here the path has got. */
  setTip(place: readonly number[] | null): void {
    const piece = this.driven.at(-1);
    const from = piece?.places.slice(-3);
    const isShown = this.isLive && place !== null && from?.length === 3;
    this.tip.root.visible = isShown;
    if (isShown) this.tip.stretch(from, place.slice(0, 3));
  }

  setPlanned(pieces: Piece[]): void {
    this.planned = pieces;
    this.plannedLines.show(linesOf(pieces), null);
  }

  setMarks(places: { at: readonly number[]; touches: boolean }[]): void {
    this.places = places;
    for (const mark of this.marks.children as Mesh<SphereGeometry, MeshBasicMaterial>[]) {
      mark.geometry.dispose();
      mark.material.dispose();
    }
    this.marks.clear();
    for (const { at, touches } of places) {
      const mark = new Mesh(
        new SphereGeometry(MARK_RADIUS, 20, 14),
        new MeshBasicMaterial({
          color: touches ? this.colors.touch : this.colors.planned,
          depthTest: false,
          transparent: true,
          opacity: 0.9,
        }),
      );
      mark.position.set(at[0] ?? 0, at[1] ?? 0, at[2] ?? 0);
      mark.renderOrder = 5;
      this.marks.add(mark);
    }
  }

  /** For tests: lines that are drawn of each path, and marks. */
  figures(): { driven: number; planned: number; marks: number } {
    const lines = (pieces: Piece[], one: Lines): number =>
      one.root.visible ? pieces.reduce((sum, piece) => sum + piece.times.length - 1, 0) : 0;
    return {
      driven: lines(this.driven, this.drivenLines),
      planned: lines(this.planned, this.plannedLines),
      marks: this.marks.children.length,
    };
  }
}
