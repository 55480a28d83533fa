// Moving by hand: hold to jog, a typed target with a ghost before, freedrive, push, teach.

import { byId, make, setText, toast } from "./dom";
import type { Frame } from "./frame";
import { api, type Link } from "./link";
import { currentUnits, type Kind, numberText, onUnits, quantityText, readQuantity, setUnits, unitOf } from "./units";
import { onLanguage, t, type Word } from "./words";

const JOINTS = ["j1", "j2", "j3", "j4", "j5", "j6"] as const;
const AXES = ["x", "y", "z", "rx", "ry", "rz"] as const;
/** A confirmation is waited for so long. */
const CONFIRM_MS = 8000;

interface Field {
  axis: string;
  kind: Kind;
  input: HTMLInputElement;
  other: HTMLElement;
  edited: boolean;
  /** What a button has put there, not rounded as the text is; rad or m. */
  exact: number | null;
}

/** Sentences of the server that have words of the page's language. */
const REASONS: Record<string, Word> = { "the pose is out of reach": "out_of_reach" };

/** What a button does while it is held: by pointer, Space or Enter. Everything else lets it go. */
export function holdable(button: HTMLButtonElement, begin: () => void, end: () => void): void {
  let isHeld = false;
  const start = (): void => {
    if (isHeld || button.disabled) return;
    isHeld = true;
    button.classList.add("held");
    begin();
  };
  const stop = (): void => {
    if (!isHeld) return;
    isHeld = false;
    button.classList.remove("held");
    end();
  };
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    start();
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture", "blur", "contextmenu"])
    button.addEventListener(name, stop);
  button.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (!event.repeat) start();
  });
  button.addEventListener("keyup", (event) => {
    if (event.key === " " || event.key === "Enter") stop();
  });
  window.addEventListener("blur", stop);
  document.addEventListener("visibilitychange", stop);
}

export class Jog {
  private readonly q: Field[] = [];
  private readonly tcp: Field[] = [];
  private readonly buttons: HTMLButtonElement[] = [];
  private target: number[] | null = null;
  private armed: ReturnType<typeof setTimeout> | null = null;
  private isMoving = false;
  private frame: Frame | null = null;
  private preview: ReturnType<typeof setTimeout> | null = null;
  /** Counts what was typed and asked for: an answer to something before is too late. */
  private looks = 0;
  private limits: { min: readonly number[]; max: readonly number[] } | null = null;

  constructor(
    private readonly link: Link,
    private readonly onGhost: (q: number[] | null) => void,
    onTeach: (q: readonly number[]) => void,
  ) {
    JOINTS.forEach((axis, k) => byId("jog-joints").append(this.row(axis, `q-${k + 1}`, this.q, "angle")));
    AXES.forEach((axis, k) =>
      byId("jog-tcp").append(this.row(axis, `tcp-${axis}`, this.tcp, k < 3 ? "length" : "angle")),
    );
    const moveTo = byId<HTMLButtonElement>("move-to");
    moveTo.addEventListener("click", () => this.moveTo());
    byId("move-reset").addEventListener("click", () => this.reset());
    byId("teach").addEventListener("click", () => {
      if (this.frame) onTeach(this.frame.actualQ);
    });
    const freedrive = byId<HTMLButtonElement>("freedrive");
    holdable(
      freedrive,
      () => this.hold({ do: "freedrive" }),
      () => this.link.release(),
    );
    byId("push").addEventListener("click", () => this.push());
    const speed = byId<HTMLInputElement>("jog-speed");
    speed.addEventListener("input", () => setText(byId("jog-speed-text"), `${speed.value} %`));
    byId("units").addEventListener("click", () => setUnits(currentUnits() === "si" ? "practical" : "si"));
    onUnits(() => this.changeUnits());
    onLanguage(() => {
      this.words();
      this.nameFields();
    });
  }

  /** The ranges of the joints, rad. */
  setLimits(min: readonly number[], max: readonly number[]): void {
    this.limits = { min, max };
  }

  private nameFields(): void {
    for (const field of [...this.q, ...this.tcp])
      field.input.setAttribute("aria-label", `${field.axis.toUpperCase()} (${unitOf(field.kind)})`);
    const button = byId("units");
    setText(button, `${unitOf("angle")} · ${unitOf("length")}`);
    button.setAttribute("aria-pressed", String(currentUnits() === "practical"));
  }

  /** Numbers are those of the other unit now; what was typed is read no more, for it meant something else. */
  private changeUnits(): void {
    this.nameFields();
    this.reset();
  }

  private row(axis: string, testid: string, fields: Field[], kind: Kind): HTMLElement {
    const button = (sign: 1 | -1): HTMLButtonElement => {
      const name = sign > 0 ? "plus" : "minus";
      const made = make(
        "button",
        {
          class: "jog",
          "data-testid": `jog-${axis}-${name}`,
          "data-label": name,
          "data-axis": axis.toUpperCase(),
          disabled: true,
          type: "button",
        },
        sign > 0 ? "+" : "−",
      );
      holdable(
        made,
        () => this.jog(axis, sign),
        () => this.link.release(),
      );
      this.buttons.push(made);
      return made;
    };
    const input = make("input", {
      "data-testid": testid,
      inputmode: "text",
      autocomplete: "off",
      spellcheck: "false",
      value: "0.0000",
    });
    const other = make("small", { "aria-hidden": "true" });
    const field: Field = { axis, kind, input, other, edited: false, exact: null };
    input.addEventListener("input", () => this.edit(field, fields));
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.reset();
      if (event.key === "Enter") this.moveTo();
    });
    fields.push(field);
    return make(
      "div",
      { class: "axis" },
      make("b", {}, axis.toUpperCase()),
      button(-1),
      make("span", { class: "value" }, input, other),
      button(1),
    );
  }

  private words(): void {
    if (this.isMoving) return;
    setText(byId("move-to"), t(this.armed === null ? "move_to" : "move_confirm"));
  }

  private jog(axis: string, sign: 1 | -1): void {
    const share = Number(byId<HTMLInputElement>("jog-speed").value) / 100;
    const frame = byId<HTMLSelectElement>("jog-frame").value;
    this.hold({ do: "jog", axis, frame, speed: sign * share });
  }

  private hold(order: Record<string, unknown>): void {
    this.link.hold(order).catch((error: Error) => toast(error.message, "error"));
  }

  private edit(field: Field, fields: Field[]): void {
    field.edited = true;
    field.exact = null;
    // Joints or a pose, not both.
    const others = fields === this.q ? this.tcp : this.q;
    for (const other of others) other.edited = false;
    this.disarm();
    this.forgetTarget();
    this.preview = setTimeout(() => void this.look(), 120);
    field.input.classList.toggle("wrong", this.valueOf(field) === null);
  }

  /** What a field says, rad or m. */
  private valueOf(field: Field): number | null {
    return field.exact ?? readQuantity(field.input.value, field.kind);
  }

  /** What keeps the arm from joint positions as far as the page knows, in words of its language and units. */
  private outOfRange(q: readonly number[]): string | null {
    const k = q.findIndex(
      (value, joint) => value < (this.limits?.min[joint] ?? -Infinity) || value > (this.limits?.max[joint] ?? Infinity),
    );
    if (k < 0) return null;
    const text = (value: number): string => quantityText("angle", value);
    return t("joint_range", {
      joint: k + 1,
      value: text(q[k] ?? 0),
      min: text(this.limits?.min[k] ?? 0),
      max: text(this.limits?.max[k] ?? 0),
    });
  }

  private editedFields(): Field[] | null {
    if (this.q.some((field) => field.edited)) return this.q;
    if (this.tcp.some((field) => field.edited)) return this.tcp;
    return null;
  }

  /** Nothing that was asked for before is a target any more, also where its answer is still to come. */
  private forgetTarget(): number {
    if (this.preview !== null) clearTimeout(this.preview);
    this.preview = null;
    this.target = null;
    return ++this.looks;
  }

  /** Looks where the arm would go. Tells whether it can, unless something else has been typed meanwhile. */
  private async look(): Promise<boolean> {
    const number = this.forgetTarget();
    const fields = this.editedFields();
    const note = byId("target-text");
    if (!fields) return false;
    const values: number[] = [];
    for (const field of fields) {
      const value = this.valueOf(field);
      if (value === null)
        return this.refuse(
          t(field.kind === "angle" ? "no_angle" : "no_length", {
            text: field.input.value.trim().slice(0, 30),
            axis: field.axis.toUpperCase(),
          }),
        );
      values.push(value);
    }
    const reason = fields === this.q ? this.outOfRange(values) : null;
    if (reason !== null) return this.refuse(reason);
    try {
      const body = fields === this.q ? { joints: values } : { pose: values };
      const { joints } = await api<{ joints: number[] }>("/api/v1/reach", { body });
      if (number !== this.looks) return false;
      this.target = joints;
      this.onGhost(joints);
      setText(note, t("ghost_ok"));
      note.className = "row ok";
      return true;
    } catch (error) {
      if (number !== this.looks) return false;
      const word = REASONS[(error as Error).message];
      return this.refuse(word === undefined ? (error as Error).message : t(word));
    }
  }

  /** Says why there is no target. */
  private refuse(reason: string): false {
    this.onGhost(null);
    const note = byId("target-text");
    setText(note, reason);
    note.className = "row bad";
    return false;
  }

  /** Puts joint positions into the fields and asks whether the arm is to go there. */
  async propose(q: readonly number[]): Promise<void> {
    if (this.isMoving) return;
    this.disarm();
    for (const field of this.tcp) field.edited = false;
    this.q.forEach((field, k) => {
      field.exact = q[k] ?? 0;
      field.edited = true;
      field.input.classList.remove("wrong");
      field.input.value = numberText("angle", field.exact);
    });
    if (this.link.hasControl && !byId<HTMLButtonElement>("move-to").disabled) await this.moveTo();
    else await this.look();
  }

  /** The same for a pose. */
  async proposePose(pose: readonly number[]): Promise<void> {
    try {
      const { joints } = await api<{ joints: number[] }>("/api/v1/reach", { body: { pose } });
      await this.propose(joints);
    } catch (error) {
      const word = REASONS[(error as Error).message];
      toast(word === undefined ? (error as Error).message : t(word), "error");
    }
  }

  private async moveTo(): Promise<void> {
    if (this.isMoving) return this.link.release();
    if (!this.link.hasControl) return;
    if (this.armed === null) {
      if (!this.editedFields()) return toast(t("type_target"));
      if (!(await this.look())) return;
      this.armed = setTimeout(() => this.disarm(), CONFIRM_MS);
      const button = byId("move-to");
      button.classList.add("armed");
      return this.words();
    }
    const target = this.target;
    this.disarm();
    if (!target) return;
    const share = Number(byId<HTMLInputElement>("jog-speed").value) / 100;
    const button = byId("move-to");
    this.isMoving = true;
    button.classList.add("held");
    setText(button, t("moving"));
    try {
      await this.link.hold({ do: "move_to", joints: target, speed: Math.max(share, 0.05) });
      this.reset();
    } catch (error) {
      toast((error as Error).message, "error");
    } finally {
      this.isMoving = false;
      button.classList.remove("held");
      this.words();
    }
  }

  private disarm(): void {
    if (this.armed !== null) clearTimeout(this.armed);
    this.armed = null;
    byId("move-to").classList.remove("armed");
    this.words();
  }

  /** Fields follow the arm again. */
  reset(): void {
    for (const field of [...this.q, ...this.tcp]) {
      field.edited = false;
      field.exact = null;
      field.input.classList.remove("wrong");
    }
    this.forgetTarget();
    this.disarm();
    this.onGhost(null);
    setText(byId("target-text"), "");
    if (this.frame) this.show(this.frame);
  }

  private push(): void {
    const text = byId<HTMLSelectElement>("push-axis").value;
    const newtons = Number(byId<HTMLInputElement>("push-force").value) * (text.startsWith("-") ? -1 : 1);
    const wrench = ["x", "y", "z"].map((axis) => (text.endsWith(axis) ? newtons : 0)).concat(0, 0, 0);
    const frame = byId<HTMLSelectElement>("jog-frame").value;
    this.link
      .order({ do: "push", wrench, duration: 0.5, frame })
      .catch((error: Error) => toast(error.message, "error"));
  }

  show(frame: Frame): void {
    this.frame = frame;
    const fill = (fields: Field[], values: readonly number[]): void => {
      const isEdited = fields.some((field) => field.edited);
      const others = currentUnits() === "si" ? "practical" : "si";
      fields.forEach((field, k) => {
        const value = (isEdited ? this.valueOf(field) : null) ?? values[k] ?? 0;
        if (!isEdited && document.activeElement !== field.input) {
          const text = numberText(field.kind, value);
          if (field.input.value !== text) field.input.value = text;
        }
        setText(field.other, quantityText(field.kind, value, others));
      });
    };
    fill(this.q, frame.actualQ);
    fill(this.tcp, frame.actualPose);
  }

  /** A button that is held stays on in a stop, which may come meanwhile: it must hear that it is let go. */
  enable(mayOrder: boolean, mayJog: boolean, mayMove: boolean): void {
    const freedrive = byId<HTMLButtonElement>("freedrive");
    for (const button of [...this.buttons, freedrive]) {
      const isHeld = button.classList.contains("held");
      button.disabled = !mayJog && !(mayOrder && isHeld);
    }
    byId<HTMLButtonElement>("push").disabled = !mayOrder;
    // A move that is under way can be ended by its button.
    byId<HTMLButtonElement>("move-to").disabled = !mayMove && !this.isMoving;
    byId<HTMLButtonElement>("home").disabled = !mayMove;
  }
}
