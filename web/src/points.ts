// Inputs, outputs and registers: seen, and set by hand.

import { ask, byId, fixed, make, setText, toast } from "./dom";
import type { Frame } from "./frame";
import type { Link } from "./link";
import { onLanguage, t, translate, type Word } from "./words";

const DIGITAL = [
  { group: "standard_digital", word: "standard", first: 0, count: 16 },
  { group: "configurable_digital", word: "configurable", first: 16, count: 8 },
  { group: "tool_digital", word: "tool_io", first: 24, count: 4 },
] as const;
const ANALOG = [
  { input: "standard_analog_in[0]", output: "standard_analog_out[0]", short: "A0" },
  { input: "standard_analog_in[1]", output: "standard_analog_out[1]", short: "A1" },
  { input: "tool_analog_in", output: "tool_analog_out", short: "AT" },
] as const;

export interface Bank {
  boolean: number[];
  integer: number[];
  float: (number | null)[];
}
export interface Registers {
  input: Bank;
  output: Bank;
}

/** What the cell file says of inputs and outputs. */
export interface PointWords {
  names?: Record<string, string>;
  wires?: { from: string; to: string }[];
  safety_inputs?: { points: string[]; function: string }[];
}

const FUNCTIONS: Record<string, Word> = {
  emergency_stop: "fn_emergency_stop",
  safeguard_stop: "fn_safeguard_stop",
  safeguard_reset: "fn_safeguard_reset",
  reduced_mode: "fn_reduced_mode",
};

export class Points {
  private readonly levels: { element: HTMLElement; bit: number; isInput: boolean }[] = [];
  private readonly analogs: { element: HTMLInputElement; index: number; isInput: boolean }[] = [];
  private readonly controls: (HTMLButtonElement | HTMLInputElement | HTMLSelectElement)[] = [];
  private readonly registers = make("div", { class: "registers", "data-testid": "registers" });
  private last = [-1, -1];
  private latest: Registers | null = null;
  /** What people have been asked once and have agreed to: outputs move what hangs on them. */
  private maySetOutputs = false;
  private words: PointWords = {};
  private readonly named = make("ul", { class: "named", "data-testid": "io-names" });

  constructor(private readonly link: Link) {
    const host = byId("io");
    for (const isInput of [true, false]) {
      const box = make("div", { class: "bank" }, make("h3", { "data-t": isInput ? "inputs" : "outputs" }));
      for (const { group, word, first, count } of DIGITAL) {
        const row = make("div", { class: count > 8 ? "bits long" : "bits" }, make("span", { "data-t": word }));
        for (let n = 0; n < count; n++)
          row.append(this.bit(`${group}_${isInput ? "in" : "out"}[${n}]`, n, first + n, isInput));
        box.append(row);
      }
      const row = make("div", { class: "bits analogs" }, make("span", { "data-t": "analog" }));
      ANALOG.forEach((port, index) =>
        row.append(this.analog(isInput ? port.input : port.output, port.short, index, isInput)),
      );
      box.append(row);
      host.append(box);
    }
    host.append(
      make("h3", { "data-t": "io_names" }),
      this.named,
      this.setter(),
      make("h3", { "data-t": "registers" }),
      this.registers,
    );
    translate(host);
    onLanguage(() => {
      this.showRegisters(this.latest);
      this.showNames();
    });
    this.showRegisters(null);
    this.showNames();
  }

  /** Names, wires and safety functions of the cell. */
  setWords(words: PointWords): void {
    this.words = words;
    this.showNames();
  }

  /** What people call a point, and what it is connected to; "" for nothing. */
  private wordsOf(name: string): string {
    const { names = {}, wires = [], safety_inputs: inputs = [] } = this.words;
    const called = (other: string): string => names[other] ?? other;
    const safety = inputs.find((one) => one.points.includes(name));
    const word = safety && FUNCTIONS[safety.function];
    return [
      names[name] ?? "",
      ...wires.filter((wire) => wire.from === name).map((wire) => `→ ${called(wire.to)}`),
      ...wires.filter((wire) => wire.to === name).map((wire) => `← ${called(wire.from)}`),
      word ? t(word) : "",
    ]
      .filter((text) => text !== "")
      .join(" ");
  }

  private showNames(): void {
    const rows: HTMLElement[] = [];
    for (const row of byId("io").querySelectorAll(".named-bits")) row.classList.remove("named-bits");
    for (const element of [...this.levels, ...this.analogs].map((one) => one.element)) {
      const name = element.dataset["testid"] ?? "";
      const words = this.wordsOf(name);
      const own = this.words.names?.[name];
      element.title = words === "" ? name : `${name}: ${words}`;
      element.setAttribute("aria-label", element.title);
      const caption = element.querySelector(".caption");
      if (caption) setText(caption, own ?? "");
      if (own !== undefined) element.closest(".bits")?.classList.add("named-bits");
      if (words !== "") rows.push(make("li", { "data-point": name }, make("span", {}, name), make("b", {}, words)));
    }
    this.named.replaceChildren(...rows);
    this.named.hidden = rows.length === 0;
    const heading = this.named.previousElementSibling as HTMLElement | null;
    if (heading) heading.hidden = rows.length === 0;
    // Levels are told with the names.
    this.last = [-1, -1];
  }

  private set(values: Record<string, unknown>): void {
    this.link.order({ do: "inputs", values }).catch((error: Error) => toast(error.message, "error"));
  }

  /** Outputs move grippers and doors: whoever sets the first one by hand says so once. */
  private async setOutput(name: string, value: boolean | number): Promise<void> {
    if (!this.maySetOutputs) {
      const answer = await ask(
        [make("p", {}, t("outputs_ask", { name: this.wordsOf(name) || name }))],
        [
          { text: t("cancel"), value: "" },
          { text: t("outputs_yes"), value: "ok", primary: true },
        ],
        t("outputs"),
      );
      if (answer !== "ok") return;
      this.maySetOutputs = true;
    }
    this.link
      .order({ do: "outputs", values: { [name]: value } })
      .catch((error: Error) => toast(error.message, "error"));
  }

  private bit(name: string, n: number, bit: number, isInput: boolean): HTMLElement {
    const props = {
      class: isInput ? "bit" : "bit output",
      type: "button",
      "data-testid": name,
      "data-name": name,
      title: name,
      "aria-label": name,
      "aria-pressed": "false",
      disabled: true,
      "data-value": "0",
    };
    const element = make("button", props, make("span", {}, String(n)), make("small", { class: "caption" }));
    element.addEventListener("click", () => {
      const next = element.getAttribute("aria-pressed") !== "true";
      if (isInput) this.set({ [name]: next });
      else void this.setOutput(name, next);
    });
    this.controls.push(element);
    this.levels.push({ element, bit, isInput });
    return element;
  }

  private analog(name: string, short: string, index: number, isInput: boolean): HTMLElement {
    const element = make("input", {
      type: "number",
      step: "0.1",
      min: "0",
      max: "20",
      "data-testid": name,
      title: name,
      "aria-label": name,
      disabled: true,
      value: "0",
    });
    element.addEventListener("change", () => {
      if (isInput) this.set({ [name]: Number(element.value) });
      else void this.setOutput(name, Number(element.value));
    });
    this.controls.push(element);
    this.analogs.push({ element, index, isInput });
    return make("label", { class: "analog" }, `${short} `, element);
  }

  private setter(): HTMLElement {
    const kind = make(
      "select",
      { "data-testid": "register-kind", "aria-label": "register" },
      ...["boolean", "integer", "float"].map((name) => make("option", {}, name)),
    );
    const index = make("input", {
      type: "number",
      min: "0",
      max: "127",
      value: "0",
      "data-testid": "register-index",
      "aria-label": "index",
    });
    const value = make("input", {
      type: "number",
      step: "any",
      value: "1",
      "data-testid": "register-value",
      "data-label": "value",
    });
    const button = make("button", { type: "button", "data-t": "set", "data-testid": "register-set", disabled: true });
    button.addEventListener("click", () => {
      const name = `input_${kind.value}_register[${index.value}]`;
      this.set({ [name]: kind.value === "boolean" ? Number(value.value) !== 0 : Number(value.value) });
    });
    this.controls.push(kind, index, value, button);
    return make(
      "div",
      { class: "row setter" },
      make("span", {}, "input_"),
      kind,
      make("span", {}, "_register["),
      index,
      make("span", {}, "] ="),
      value,
      button,
    );
  }

  show(frame: Frame): void {
    if (frame.digitalIn !== this.last[0] || frame.digitalOut !== this.last[1]) {
      this.last = [frame.digitalIn, frame.digitalOut];
      for (const { element, bit, isInput } of this.levels) {
        const high = (((isInput ? frame.digitalIn : frame.digitalOut) >>> bit) & 1) === 1;
        element.classList.toggle("high", high);
        element.dataset["value"] = high ? "1" : "0";
        element.setAttribute("aria-pressed", String(high));
      }
    }
    for (const { element, index, isInput } of this.analogs) {
      const text = fixed((isInput ? frame.analogIn : frame.analogOut)[index] ?? 0, 3);
      if (document.activeElement !== element && element.value !== text) element.value = text;
    }
  }

  showRegisters(registers: Registers | null): void {
    this.latest = registers;
    const rows: HTMLElement[] = [];
    for (const side of ["input", "output"] as const) {
      const bank = registers?.[side];
      const list = (name: string, word: "booleans" | "integers" | "floats", items: string[]): HTMLElement =>
        make(
          "div",
          { class: "register", "data-testid": `${side}-${name}` },
          make("span", {}, `${t(side === "input" ? "inputs" : "outputs")} · ${t(word)}: `),
          items.length > 0 ? items.join("  ") : t("none"),
        );
      const numbers = (values: (number | null)[]): string[] =>
        values.flatMap((value, n) => (value === 0 ? [] : [`[${n}] ${value ?? "NaN"}`]));
      rows.push(
        list(
          "boolean",
          "booleans",
          (bank?.boolean ?? []).map((n) => `[${n}]`),
        ),
      );
      rows.push(list("integer", "integers", numbers(bank?.integer ?? [])));
      rows.push(list("float", "floats", numbers(bank?.float ?? [])));
    }
    this.registers.replaceChildren(...rows);
  }

  enable(may: boolean): void {
    for (const control of this.controls) control.disabled = !may;
  }
}
