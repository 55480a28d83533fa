// What is seen of a program that the debugger holds: why and where, the stack, variables, an expression; and what leads
// it on.

import { ask, byId, make, setText, toast } from "./dom";
import type { Breakpoint, Debugger, DebugVariable, StackFrame } from "./debugger";
import { isWord, onLanguage, t } from "./words";

/** Deeper values are not unfolded. */
const DEPTH_MAX = 8;

export class DebugPanel {
  private frames: StackFrame[] = [];
  private frame = 0;
  private shownFor: object | null = null;
  /** Scopes and values that somebody has unfolded or folded stay so from stop to stop. */
  private readonly unfolded = new Map<string, boolean>();

  /** The line of the frame that is looked at; 0 when nothing is held. */
  onLine: (line: number, source: string) => void = () => undefined;

  constructor(private readonly debug: Debugger) {
    const act = (id: string, what: () => Promise<void>): void =>
      byId(id).addEventListener("click", () => void this.lead(what));
    act("debug-continue", () => debug.resume());
    act("debug-over", () => debug.step("next"));
    act("debug-into", () => debug.step("stepIn"));
    act("debug-out", () => debug.step("stepOut"));
    byId("watch-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.evaluate();
    });
    document.addEventListener("keydown", (event) => {
      const how =
        event.key === "F8"
          ? () => debug.resume()
          : event.key === "F10"
            ? () => debug.step("next")
            : event.key === "F11"
              ? () => debug.step(event.shiftKey ? "stepOut" : "stepIn")
              : null;
      if (!how || !debug.held) return;
      event.preventDefault();
      void this.lead(how);
    });
    onLanguage(() => this.showReason());
  }

  /** Something has changed: attached or not, held or not. */
  refresh(): void {
    const { held } = this.debug;
    byId("debugger").hidden = !this.debug.isAttached;
    byId("debug-held").hidden = held === null;
    for (const id of ["debug-continue", "debug-over", "debug-into", "debug-out"])
      byId<HTMLButtonElement>(id).disabled = held === null;
    this.showReason();
    if (held === this.shownFor) return;
    this.shownFor = held;
    if (held) void this.look();
    else this.onLine(0, "");
  }

  private showReason(): void {
    const { held } = this.debug;
    if (!held) return setText(byId("debug-reason"), t("debug_runs"));
    const word = `stopped_${held.reason.replace(/ /g, "_")}`;
    const reason = isWord(word) ? t(word) : held.reason;
    const line = this.frames[0]?.line;
    const place = line === undefined ? reason : `${reason} · ${t("line", { line })}`;
    setText(byId("debug-reason"), held.text && held.text !== held.reason ? `${place} · ${held.text}` : place);
  }

  private async lead(what: () => Promise<void>): Promise<void> {
    try {
      await what();
    } catch (error) {
      toast((error as Error).message, "error");
    }
  }

  private async look(): Promise<void> {
    const held = this.debug.held;
    try {
      this.frames = await this.debug.stack();
      if (this.debug.held !== held) return;
      this.showReason();
      this.showStack();
      await this.choose(0);
    } catch (error) {
      if (this.debug.held === held) toast((error as Error).message, "error");
    }
  }

  private showStack(): void {
    byId("stack").replaceChildren(
      ...this.frames.map((frame, k) => {
        const button = make(
          "button",
          { type: "button", class: "quiet" },
          make("b", {}, frame.name),
          ` ${frame.source}:${frame.line}`,
        );
        button.addEventListener("click", () => void this.choose(k));
        return make("li", {}, button);
      }),
    );
  }

  private async choose(k: number): Promise<void> {
    const frame = this.frames[k];
    if (!frame) return;
    this.frame = k;
    [...byId("stack").children].forEach((item, n) => {
      item.classList.toggle("here", n === k);
      if (n === k) item.setAttribute("aria-current", "true");
      else item.removeAttribute("aria-current");
    });
    this.onLine(frame.line, frame.source);
    const held = this.debug.held;
    const scopes = await this.debug.scopes(frame.id);
    const rows = await Promise.all(
      scopes.map(async (scope, n) => this.scope(scope.name, scope.reference, this.unfolded.get(scope.name) ?? n === 0)),
    );
    if (this.debug.held === held && this.frame === k) byId("scopes").replaceChildren(...rows);
  }

  private async scope(name: string, reference: number, isOpen: boolean): Promise<HTMLElement> {
    const body = make("div", { class: "values" });
    const details = make("details", { open: isOpen, "data-scope": name }, make("summary", {}, name), body);
    const fill = async (): Promise<void> => this.fill(body, reference, name, 0);
    details.addEventListener("toggle", () => {
      this.unfolded.set(name, details.open);
      if (details.open && body.childElementCount === 0)
        void fill().catch((error: Error) => toast(error.message, "error"));
    });
    if (isOpen) await fill();
    return details;
  }

  private async fill(host: HTMLElement, reference: number, path: string, depth: number): Promise<void> {
    const variables = await this.debug.variables(reference);
    host.replaceChildren(
      ...(variables.length === 0
        ? [make("p", { class: "hint" }, t("none"))]
        : variables.map((variable) => this.value(variable, reference, path, depth))),
    );
  }

  private value(variable: DebugVariable, owner: number, path: string, depth: number): HTMLElement {
    const shown = make(
      "button",
      { type: "button", class: "quiet value", title: variable.type, "data-variable": variable.name },
      variable.value,
    );
    shown.addEventListener("click", () => void this.change(variable, owner, shown));
    const name = make("span", { class: "name" }, variable.name);
    if (variable.reference === 0 || depth >= DEPTH_MAX) return make("div", { class: "entry" }, name, shown);
    const body = make("div", { class: "values" });
    const key = `${path}.${variable.name}`;
    const details = make("details", {}, make("summary", {}, name, ` ${variable.value}`), body);
    details.addEventListener("toggle", () => {
      this.unfolded.set(key, details.open);
      if (details.open && body.childElementCount === 0)
        void this.fill(body, variable.reference, key, depth + 1).catch((error: Error) => toast(error.message, "error"));
    });
    if (this.unfolded.get(key)) details.open = true;
    return details;
  }

  private async change(variable: DebugVariable, owner: number, shown: HTMLElement): Promise<void> {
    const input = make("input", {
      "data-testid": "new-value",
      "aria-label": t("new_value", { name: variable.name }),
      value: variable.value,
      spellcheck: "false",
      autocomplete: "off",
      maxlength: "4096",
    });
    input.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      byId<HTMLDialogElement>("dialog").close("set");
    });
    const answer = await ask(
      [make("p", {}, t("new_value", { name: variable.name })), input],
      [
        { text: t("cancel"), value: "" },
        { text: t("set"), value: "set", primary: true },
      ],
      t("new_value", { name: variable.name }),
    );
    if (answer !== "set") return;
    await this.lead(async () => {
      setText(shown, await this.debug.assign(owner, variable.name, input.value));
    });
  }

  private async evaluate(): Promise<void> {
    const input = byId<HTMLInputElement>("watch");
    const frame = this.frames[this.frame];
    if (!frame || input.value.trim() === "") return;
    const result = byId("watch-result");
    try {
      const value = await this.debug.evaluate(input.value, frame.id);
      result.classList.remove("failed");
      setText(result, value.value);
      // What was evaluated may have changed something.
      await this.choose(this.frame);
    } catch (error) {
      result.classList.add("failed");
      setText(result, (error as Error).message);
    }
  }
}

/** Asks for the condition of a breakpoint; null when it stays as it was, "remove" when it goes. */
export async function askForCondition(point: Breakpoint): Promise<Breakpoint | "remove" | null> {
  const field = (name: "condition" | "hitCondition" | "logMessage", hint: string): [HTMLElement, HTMLInputElement] => {
    const input = make("input", {
      value: point[name] ?? "",
      placeholder: hint,
      spellcheck: "false",
      autocomplete: "off",
      maxlength: "4096",
      "data-testid": `bp-${name}`,
    });
    input.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      byId<HTMLDialogElement>("dialog").close("set");
    });
    return [make("label", { class: "stacked" }, t(`bp_${name}`), input), input];
  };
  const [conditionRow, condition] = field("condition", "n > 3");
  const [hitsRow, hits] = field("hitCondition", ">= 4");
  const [logRow, log] = field("logMessage", "n is {n}");
  const title = t("breakpoint_at", { line: point.line });
  const choices = [
    { text: t("remove"), value: "remove" },
    { text: t("cancel"), value: "" },
    { text: t("set"), value: "set", primary: true },
  ];
  const answer = await ask([make("h2", {}, title), conditionRow, hitsRow, logRow], choices, title);
  if (answer === "remove") return "remove";
  if (answer !== "set") return null;
  const changed: Breakpoint = { line: point.line };
  if (condition.value.trim() !== "") changed.condition = condition.value.trim();
  if (hits.value.trim() !== "") changed.hitCondition = hits.value.trim();
  if (log.value.trim() !== "") changed.logMessage = log.value;
  return changed;
}
