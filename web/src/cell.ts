// The cell in the panel: what grippers hold, what sinks have counted, how belts run; and a part placed by hand.

import { byId, fixed, make, setText, toast } from "./dom";
import type { Matrix } from "./kinematics";
import type { Link } from "./link";
import { currentUnits, type Kind, numberText, onUnits, readQuantity, unitOf } from "./units";
import { onLanguage, t } from "./words";
import { partMatrix, toPose, type WorldMoment, type WorldScene } from "./world";

const AXES = ["x", "y", "z", "rx", "ry", "rz"] as const;

interface Field {
  axis: string;
  kind: Kind;
  input: HTMLInputElement;
  /** What a button or the mouse has put there, not rounded as the text is; m or rad. */
  exact: number | null;
}

export class CellPanel {
  private scene: WorldScene | null = null;
  private moment: WorldMoment | null = null;
  private flange: Matrix = [];
  private readonly rows = new Map<string, [HTMLElement, HTMLElement]>();
  private readonly fields: Field[] = [];
  private readonly list = make("ul", { class: "cell-rows", "data-testid": "cell-rows" });
  private readonly select = make("select", { "data-testid": "place-part", "data-label": "place_part" });
  private readonly button = make("button", {
    type: "button",
    class: "primary",
    "data-testid": "place",
    "data-t": "place_there",
    disabled: true,
  });
  private readonly reset = make("button", { type: "button", "data-testid": "place-reset", "data-t": "reset" });
  private readonly form = make("div", { class: "place", "data-testid": "place-form" });
  private names = "";
  private isEdited = false;
  private may = false;

  constructor(
    private readonly link: Link,
    private readonly onGhost: (part: string | null, pose: readonly number[]) => void,
  ) {
    const values = make("div", { class: "place-values" });
    AXES.forEach((axis, k) => {
      const kind: Kind = k < 3 ? "length" : "angle";
      const input = make("input", {
        "data-testid": `place-${axis}`,
        inputmode: "text",
        autocomplete: "off",
        spellcheck: "false",
      });
      const field: Field = { axis, kind, input, exact: null };
      input.addEventListener("input", () => {
        field.exact = null;
        this.edit();
      });
      input.addEventListener("keydown", (event) => {
        if (event.key === "Escape") this.choose(this.select.value);
        if (event.key === "Enter") void this.place();
      });
      this.fields.push(field);
      values.append(make("label", {}, make("b", {}, axis.toUpperCase()), input));
    });
    this.select.addEventListener("change", () => this.choose(this.select.value));
    this.button.addEventListener("click", () => void this.place());
    this.reset.addEventListener("click", () => this.choose(this.select.value));
    this.form.append(
      make("h3", { "data-t": "place_part" }),
      make("p", { class: "hint", "data-t": "place_hint" }),
      make("div", { class: "row" }, this.select),
      values,
      make("div", { class: "actions" }, this.button, this.reset),
    );
    byId("cell").append(make("h3", { "data-t": "cell" }), this.list, this.form);
    onLanguage(() => this.show(this.moment, this.flange, true));
    onUnits(() => {
      this.nameFields();
      this.choose(this.select.value);
      this.show(this.moment, this.flange, true);
    });
    this.nameFields();
  }

  private nameFields(): void {
    for (const { axis, kind, input } of this.fields)
      input.setAttribute("aria-label", `${axis.toUpperCase()} (${unitOf(kind)})`);
  }

  setScene(scene: WorldScene | null): void {
    this.scene = scene;
    this.rows.clear();
    this.list.replaceChildren();
    byId("cell").hidden = scene === null;
    this.form.hidden = scene === null || scene.parts.length === 0 || this.link.readOnly !== null;
    this.names = "";
    this.show(this.moment, this.flange, true);
  }

  /** Whether a part may be placed: under control, live, and while no program runs. */
  enable(may: boolean): void {
    if (may === this.may) return;
    this.may = may;
    if (!may && this.isEdited) this.choose(this.select.value);
    this.settle();
  }

  get canPlace(): boolean {
    return this.may && !this.form.hidden;
  }

  get selected(): string | null {
    return this.select.value === "" ? null : this.select.value;
  }

  /** A moment, live or past, with the flange where the arm is shown. */
  show(moment: WorldMoment | null, flange: Matrix, again = false): void {
    const isSame = moment === this.moment && !again;
    this.moment = moment;
    this.flange = flange;
    if (!this.scene) return;
    if (isSame) {
      // A part that is held goes on with the arm.
      if (!this.isEdited && this.select.value !== "") this.fill();
      return;
    }
    const { grippers, sinks, conveyors, detectors } = this.scene;
    grippers.forEach(({ name, kind }, k) => {
      const now = moment?.grippers[k];
      const width = kind === "fingers" && now ? ` · ${numberText("length", now.width)} ${unitOf("length")}` : "";
      const sealed =
        kind === "vacuum" && now && now.sealed.length > 1
          ? ` · ${now.sealed.filter(Boolean).length}/${now.sealed.length}`
          : "";
      this.row(
        `gripper-${name}`,
        name,
        now?.holding ? t("gripper_holds", { part: now.holding }) + width + sealed : t("gripper_empty") + width,
      );
    });
    sinks.forEach(({ name }, k) => this.row(`sink-${name}`, name, t("sink_count", { n: moment?.counts[k] ?? 0 })));
    conveyors.forEach(({ name, kind }, k) =>
      this.row(`conveyor-${name}`, name, speedText(moment?.conveyors[k] ?? 0, kind === "belt")),
    );
    detectors.forEach(({ name }, k) =>
      this.row(`detector-${name}`, name, moment?.detectors[k] ? t("detector_sees") : t("detector_free")),
    );
    this.showParts(moment);
  }

  private row(id: string, name: string, value: string): void {
    let cells = this.rows.get(id);
    if (!cells) {
      cells = [make("span", {}, name), make("b", { "data-testid": id })];
      this.rows.set(id, cells);
      this.list.append(make("li", {}, ...cells));
    }
    setText(cells[1], value);
  }

  private showParts(moment: WorldMoment | null): void {
    const names = (moment?.parts ?? [])
      .map((part) => part.name)
      .sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
    const key = names.join("\n") + t("choose_part");
    if (key !== this.names) {
      this.names = key;
      const before = this.select.value;
      this.select.replaceChildren(
        make("option", { value: "" }, t("choose_part")),
        ...names.map((name) => make("option", { value: name }, name)),
      );
      this.select.value = names.includes(before) ? before : "";
      if (this.select.value !== before) this.choose(this.select.value);
    }
    if (!this.isEdited) this.fill();
    this.settle();
  }

  private settle(): void {
    const isChosen = this.select.value !== "";
    this.button.disabled = !(this.may && isChosen && this.pose() !== null);
    this.reset.disabled = !this.isEdited;
    for (const { input } of this.fields) input.disabled = !(this.may && isChosen);
  }

  /** Where the chosen part is. */
  private fill(): void {
    const part = this.moment?.parts.find((one) => one.name === this.select.value);
    const pose = part ? toPose(partMatrix(part, this.flange)) : null;
    this.fields.forEach((field, k) => {
      field.exact = pose?.[k] ?? null;
      const text = field.exact === null ? "" : numberText(field.kind, field.exact);
      if (field.input.value !== text) field.input.value = text;
      field.input.classList.remove("wrong");
    });
  }

  /** A part is chosen, here or in the picture; what was typed for another is forgotten. */
  choose(name: string): void {
    this.select.value = name;
    this.isEdited = false;
    this.fill();
    this.settle();
    this.onGhost(null, []);
  }

  /** The mouse has the chosen part over another place. */
  drag(x: number, y: number): void {
    [x, y].forEach((value, k) => {
      const field = this.fields[k];
      if (!field) return;
      field.exact = value;
      field.input.value = numberText("length", value);
    });
    this.edit();
  }

  private edit(): void {
    this.isEdited = true;
    for (const field of this.fields) field.input.classList.toggle("wrong", valueOf(field) === null);
    const pose = this.pose();
    this.onGhost(pose && this.select.value !== "" ? this.select.value : null, pose ?? []);
    this.settle();
  }

  /** The pose in the fields; null while one of them is no number. */
  private pose(): number[] | null {
    const pose = this.fields.map(valueOf);
    return pose.some((value) => value === null) ? null : (pose as number[]);
  }

  private async place(): Promise<void> {
    const pose = this.pose();
    if (this.button.disabled || !pose) return;
    const part = this.select.value;
    try {
      await this.link.order({ do: "place_part", part, pose });
      toast(t("placed", { part }));
      this.choose(part);
    } catch (error) {
      toast((error as Error).message, "error");
    }
  }
}

function valueOf(field: Field): number | null {
  return field.exact ?? readQuantity(field.input.value, field.kind);
}

/** The speed of a belt or a turntable, or that it stands. */
function speedText(speed: number, isBelt: boolean): string {
  if (speed === 0) return t("belt_stands");
  if (isBelt) return currentUnits() === "si" ? `${fixed(speed, 3)} m/s` : `${fixed(speed * 1000, 0)} mm/s`;
  return currentUnits() === "si" ? `${fixed(speed, 3)} rad/s` : `${fixed((speed * 180) / Math.PI, 1)} °/s`;
}
