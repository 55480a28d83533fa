// The paths of the TCP beside the arm: which are shown, what the program in the editor would drive, and how near it
// comes to something.

import { choiceOf, keepChoice } from "./choices";
import { byId, setText, toast } from "./dom";
import type { Frame } from "./frame";
import { api, type Link } from "./link";
import { pathFrom, pathOf, type Piece, type Place } from "./path";
import type { Programs } from "./program";
import { onUnits, quantityText } from "./units";
import type { View } from "./view";
import { isWord, onLanguage, t, type Word } from "./words";

interface Planned {
  pieces: number[][][];
  end: "finished" | "not_compiled" | "failed" | "waits" | "goes_on";
  line: number;
  time: number;
  places: Place[];
}

/** So long nothing is typed before a path is asked for, ms. */
const PAUSE_MS = 700;
/** Joints that are farther from where the path begins begin another one, rad. */
const ELSEWHERE = 1e-3;
/** Slower joints stand, rad/s. */
const STANDS = 1e-3;

type Kind = "driven" | "planned";

/**
 * Follows where the arm stands at rest, and whether a hand has moved it since: a program leaves it elsewhere, too, but
 * its path was planned from where it began.
 */
export class RestWatch {
  /** Where the arm has come to rest last, rad. */
  rest: readonly number[] | null = null;
  private byHand = false;
  private before: "rest" | "moves" | "program" = "moves";

  /** True when the arm has come to rest after a hand has moved it. */
  take(frame: Pick<Frame, "task" | "targetQ" | "targetQd">): boolean {
    if (frame.task !== 0) {
      this.before = "program";
      this.byHand = false;
      return false;
    }
    if (frame.targetQd.some((speed) => Math.abs(speed) > STANDS)) {
      if (this.before === "rest") this.byHand = true;
      this.before = "moves";
      return false;
    }
    const isMoved = this.byHand && this.rest !== null && farthest(frame.targetQ, this.rest) > ELSEWHERE;
    this.rest = frame.targetQ;
    this.before = "rest";
    this.byHand = false;
    return isMoved;
  }
}

function farthest(a: readonly number[], b: readonly number[]): number {
  return Math.max(...a.map((value, k) => Math.abs(value - (b[k] ?? 0))));
}

/** The place where a program comes near to something, in words. */
export function placeText(place: Place): string {
  const name = (one: string): string => {
    const word = `part_${one}`;
    return isWord(word) ? t(word) : one;
  };
  const [a, b] = [name(place.a), name(place.b)];
  return place.distance < 0
    ? t("path_touch", { a, b, distance: quantityText("length", -place.distance) })
    : t("path_near", { a, b, distance: quantityText("length", place.distance) });
}

/**
 * A distance between parts of the arm, which are always near to each other: it says only that nothing else is nearer.
 */
export function isOwn(place: Place): boolean {
  return place.distance >= 0 && isWord(`part_${place.a}`) && isWord(`part_${place.b}`);
}

export class Paths {
  /** The 3D view, once it is there. */
  private view: View | null = null;
  private readonly shown: Record<Kind, boolean> = {
    driven: choiceOf("path-driven") !== "false",
    planned: choiceOf("path-planned") === "true",
  };
  private frames: readonly Frame[] = [];
  private at = Infinity;
  private drivenKey = "";
  private planned: Planned | null = null;
  /** What `planned` was asked for. */
  private plannedFor: { text: string; start: readonly number[] | null } | null = null;
  private pieces: Piece[] = [];
  private timer: ReturnType<typeof setTimeout> | null = null;
  private asking: AbortController | null = null;
  private readonly rest = new RestWatch();
  private task = 0;

  constructor(
    private readonly link: Link,
    private readonly programs: Programs,
  ) {
    for (const kind of ["driven", "planned"] as const) {
      this.button(kind).addEventListener("click", () => this.toggle(kind));
    }
    byId("path-place").addEventListener("click", () => {
      const line = this.planned?.places[0]?.line ?? 0;
      if (line > 0) this.programs.goTo(line);
    });
    const retell = (): void => (this.tell(), this.drawPlanned());
    onLanguage(retell);
    onUnits(retell);
    this.buttons();
  }

  private button(kind: Kind): HTMLElement {
    return byId(`path-${kind}`);
  }

  setView(view: View): void {
    this.view = view;
    byId("paths").hidden = false;
    this.redraw();
    this.plan(0);
  }

  private toggle(kind: Kind): void {
    this.shown[kind] = !this.shown[kind];
    keepChoice(`path-${kind}`, String(this.shown[kind]));
    this.buttons();
    this.redraw();
    if (kind === "planned") this.plan(0);
  }

  private buttons(): void {
    for (const kind of ["driven", "planned"] as const)
      this.button(kind).setAttribute("aria-pressed", String(this.shown[kind]));
    const word: Word = this.isRecording ? "path_target_long" : "path_planned_long";
    const button = this.button("planned");
    button.dataset["label"] = word;
    button.setAttribute("aria-label", t(word));
    button.title = t(word);
  }

  private get isRecording(): boolean {
    return this.link.readOnly !== null;
  }

  /** A connection has begun, perhaps to another server. */
  begin(): void {
    this.buttons();
    this.forget();
    this.plan(0);
  }

  /** The frames that the time line shows, and the moment of them; the present is infinite. */
  showSpan(frames: readonly Frame[], at: number): void {
    [this.frames, this.at] = [frames, at];
    this.draw();
  }

  /** A live frame. */
  take(frame: Frame): void {
    const before = this.task;
    this.task = frame.task;
    const start = this.rest.rest;
    if (this.rest.take(frame)) this.plan(PAUSE_MS);
    const isFirst = start === null && this.rest.rest !== null;
    if (isFirst) this.plan(0);
    // What was planned from elsewhere is not what is driven now.
    if (before === 0 && frame.task !== 0 && this.isStale()) this.plan(0, true);
  }

  private isStale(): boolean {
    const { plannedFor } = this;
    const start = this.rest.rest;
    return (
      plannedFor?.text !== this.programs.text ||
      (start !== null && (plannedFor.start === null || farthest(start, plannedFor.start) > ELSEWHERE))
    );
  }

  /** The text in the editor has changed. */
  textChanged(): void {
    if (this.plannedFor?.text === this.programs.text) return;
    // A path of another text would be taken for that of this one.
    this.forget();
    this.plan(PAUSE_MS);
  }

  private forget(): void {
    this.asking?.abort();
    this.asking = null;
    const isShown = this.pieces.length > 0 || this.planned !== null;
    this.planned = null;
    this.plannedFor = null;
    this.pieces = [];
    if (isShown) this.drawPlanned();
    this.tell();
  }

  /** Asks for the path of the program soon, or now while its program begins. */
  private plan(pause: number, isRunning = false): void {
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.ask(isRunning), pause);
  }

  private async ask(isRunning: boolean): Promise<void> {
    const mayAsk =
      this.view !== null &&
      this.shown.planned &&
      this.link.state === "connected" &&
      !this.isRecording &&
      this.rest.rest !== null;
    if (!mayAsk) return;
    if (this.programs.isEmpty) return this.forget();
    if (!isRunning && this.task !== 0 && this.plannedFor?.text === this.programs.text) return;
    const { text } = this.programs;
    const start = this.rest.rest;
    this.asking?.abort();
    const asking = new AbortController();
    this.asking = asking;
    this.tell();
    try {
      await this.link.ready();
      const body = { name: this.programs.name.slice(0, 60), text, start };
      const planned = await api<Planned>("/api/v1/path", { body, token: this.link.token, signal: asking.signal });
      if (this.asking !== asking) return;
      this.planned = planned;
      this.plannedFor = { text, start };
      this.pieces = pathFrom(planned.pieces);
    } catch (error) {
      if (asking.signal.aborted) return;
      this.planned = null;
      this.pieces = [];
      toast((error as Error).message, "error");
    }
    if (this.asking === asking) this.asking = null;
    this.drawPlanned();
    this.tell();
  }

  private redraw(): void {
    this.drivenKey = "-";
    this.draw();
    this.drawPlanned();
    this.tell();
  }

  private draw(): void {
    const isLive = this.at === Infinity;
    const pieces = this.shown.driven ? pathOf(this.frames, "actualPose") : [];
    const key = [
      isLive ? "" : this.at,
      ...pieces.map(({ times }) => `${times.length} ${times[0]} ${times.at(-1)}`),
    ].join();
    if (key === this.drivenKey) return;
    this.drivenKey = key;
    this.view?.setDriven(pieces, isLive ? (this.frames.at(-1)?.time ?? 0) : this.at, isLive);
    if (this.isRecording) this.drawPlanned();
  }

  /** In a recording what was planned are the targets of its cycles. */
  private drawPlanned(): void {
    if (!this.shown.planned) return this.view?.setPlanned([], []);
    if (this.isRecording) return this.view?.setPlanned(pathOf(this.frames, "targetPose"), []);
    const places = (this.planned?.places ?? [])
      .filter((place) => !isOwn(place))
      .map((place) => ({ at: place.tcp, touches: place.distance < 0, text: placeText(place) }));
    this.view?.setPlanned(this.pieces, places);
  }

  /** What is known of the planned path, in words. */
  private tell(): void {
    const { planned } = this;
    const isShown = this.shown.planned && !this.isRecording;
    const place = isShown ? planned?.places[0] : undefined;
    const button = byId("path-place");
    button.hidden = !place;
    if (place) {
      button.classList.toggle("touch", place.distance < 0);
      const text = isOwn(place)
        ? t("path_clear", { distance: quantityText("length", place.distance) })
        : placeText(place);
      setText(button, isOwn(place) ? text : `${text}, ${t("line", { line: place.line })}`);
    }
    const note = byId("path-note");
    const text = isShown ? this.noteText() : "";
    note.hidden = text === "";
    setText(note, text);
  }

  private noteText(): string {
    const { planned } = this;
    if (this.asking !== null) return t("path_asked");
    if (this.programs.isEmpty) return t("path_no_program");
    if (!planned || planned.end === "finished") return "";
    // An error within a library has the line of the library.
    const isElsewhere = planned.line === 0 || planned.line > this.programs.text.split("\n").length;
    if (planned.end === "failed" && isElsewhere) return t("path_fails");
    const word: Word = `path_${planned.end}`;
    return t(word, { line: planned.line, time: planned.time.toFixed(0) });
  }
}
