// What the controller tells: popups that are answered, alarms with what to do, the log, variables.

import { byId, fixed, make, setText, toast } from "./dom";
import type { Link, ServerEvent } from "./link";
import type { RunningProgram } from "./program";
import { currentLanguage, onLanguage, t, type Word } from "./words";

export interface Popup {
  id: number;
  title: string;
  text: string;
  style: string;
  blocking: boolean;
}
export interface Variable {
  name: string;
  type: string;
  value: string;
}
export interface Panel {
  task: string;
  name?: string | null;
  line?: number | null;
  label?: string | null;
  popups?: Popup[];
  variables?: Variable[];
  payload?: { mass: number; cog: number[] };
}

const LOG_LINES = 500;
/** Longer texts of the log are folded, characters and lines. */
const FOLD_CHARS = 220;
const FOLD_LINES = 4;
const LEVELS = ["", "debug", "info", "warning", "error", "fatal"];

interface Alarm {
  event: ServerEvent;
  program: RunningProgram | null;
}

/** What an alarm says, in the language of the page where the server has told it. */
export function alarmText(event: ServerEvent, language: string): string {
  const texts = event["texts"] as Record<string, string> | undefined;
  return texts?.[language] ?? String(event["text"]);
}

export class Notices {
  private panel: Panel | null = null;
  private alarms: Alarm[] = [];
  private stays = true;

  constructor(
    private readonly link: Link,
    private readonly onPlace: (program: number, line: number) => void,
    private readonly programOf: (number: number) => RunningProgram | null,
    private readonly onAlarms: () => void,
  ) {
    const log = byId("log");
    log.addEventListener("scroll", () => (this.stays = log.scrollTop + log.clientHeight >= log.scrollHeight - 20));
    onLanguage(() => {
      this.showAlarms();
      if (this.panel) this.showPanel(this.panel);
      else this.showVariables([]);
    });
    this.showVariables([]);
  }

  showPanel(panel: Panel): void {
    const before = JSON.stringify(this.panel?.popups ?? []);
    this.panel = panel;
    const popups = panel.popups ?? [];
    if (JSON.stringify(popups) !== before || byId("popups").childElementCount !== popups.length)
      this.showPopups(popups);
    this.showVariables(panel.variables ?? []);
  }

  private showPopups(popups: Popup[]): void {
    const hadFocus = byId("popups").contains(document.activeElement);
    const cards = popups.map((popup) => {
      const word: Word = popup.style === "error" ? "error" : popup.style === "warning" ? "warning" : "message";
      const answer = (stop: boolean): void => {
        this.link
          .order({ do: "close_popup", popup: popup.id, stop })
          .catch((error: Error) => toast(error.message, "error"));
      };
      const ok = make("button", { type: "button", class: "primary", "data-testid": "popup-ok" }, t("popup_ok"));
      const cancel = make("button", { type: "button", "data-testid": "popup-cancel" }, t("popup_stop"));
      ok.addEventListener("click", () => answer(false));
      cancel.addEventListener("click", () => answer(true));
      ok.disabled = cancel.disabled = !this.link.hasControl;
      return make(
        "div",
        { class: `popup ${word}`, role: "alertdialog", "data-testid": "popup", "aria-label": t(word) },
        make("h2", {}, popup.title || t(word)),
        make("p", {}, popup.text),
        make("div", { class: "row end" }, cancel, ok),
      );
    });
    byId("popups").replaceChildren(...cards);
    const first = byId("popups").querySelector<HTMLElement>("[data-testid=popup-ok]");
    if (first && (hadFocus || document.activeElement === document.body)) first.focus();
  }

  /** Who has control has changed. */
  refresh(): void {
    for (const button of byId("popups").querySelectorAll<HTMLButtonElement>("button"))
      button.disabled = !this.link.hasControl;
  }

  private showVariables(variables: Variable[]): void {
    const host = byId("variables");
    if (variables.length === 0) {
      if (host.dataset["empty"] !== t("no_variables"))
        host.replaceChildren(make("p", { class: "hint" }, t("no_variables")));
      host.dataset["empty"] = t("no_variables");
      return;
    }
    delete host.dataset["empty"];
    const rows = variables.map((variable) =>
      make(
        "tr",
        { "data-name": variable.name },
        make("th", { scope: "row" }, variable.name),
        make("td", {}, variable.value),
        make("td", { class: "hint" }, variable.type),
      ),
    );
    host.replaceChildren(make("table", {}, make("tbody", {}, ...rows)));
  }

  /** An event of the controller; true when it was one for people. */
  take(event: ServerEvent): void {
    if (event.event === "log") this.line(event);
    else if (event.event === "alarm") {
      this.alarms.push({ event, program: this.programOf(Number(event["program"] ?? 0)) });
      this.alarms.splice(0, Math.max(0, this.alarms.length - 5));
      this.showAlarms();
    } else if (event.event === "missed") toast(t("missed", { n: Number(event["events"]) }));
  }

  private line(event: ServerEvent): void {
    const level = LEVELS[Number(event["level"])] ?? "info";
    const log = byId("log");
    const time = Number(event["time"]);
    const source = String(event["source"]);
    const said = String(event["text"]);
    const text = make("span", { class: "said" }, said);
    const line = make(
      "div",
      { class: `line ${level}` },
      make("time", {}, fixed(time, 3)),
      make("b", { title: source }, source),
      text,
    );
    if (said.length > FOLD_CHARS || said.split("\n").length > FOLD_LINES) line.append(this.unfolder(text));
    log.append(line);
    while (log.childElementCount > LOG_LINES) log.firstElementChild?.remove();
    if (this.stays) log.scrollTop = log.scrollHeight;
  }

  /** What is long shows its beginning; a click shows all of it. */
  private unfolder(text: HTMLElement): HTMLElement {
    text.classList.add("folded");
    const button = make(
      "button",
      { type: "button", class: "quiet unfold", "data-testid": "unfold", "aria-expanded": "false", "data-t": "unfold" },
      t("unfold"),
    );
    button.addEventListener("click", () => {
      const isFolded = text.classList.toggle("folded");
      button.setAttribute("aria-expanded", String(!isFolded));
      button.dataset["t"] = isFolded ? "unfold" : "fold";
      setText(button, t(isFolded ? "unfold" : "fold"));
    });
    return button;
  }

  clearLog(): void {
    byId("log").replaceChildren();
  }

  private showAlarms(): void {
    const host = byId("alarm");
    host.hidden = this.alarms.length === 0;
    // The newest is read first.
    host.replaceChildren(...this.alarms.map((alarm) => this.card(alarm)).reverse());
    this.onAlarms();
  }

  /** Whether an alarm is shown already. */
  knows(event: ServerEvent): boolean {
    return this.alarms.some((alarm) => alarm.event["time"] === event["time"] && alarm.event["text"] === event["text"]);
  }

  /** Programs and lines that alarms name. */
  get places(): { text: string; line: number }[] {
    return this.alarms.flatMap(({ event, program }) =>
      program && Number(event["line"] ?? 0) > 0 ? [{ text: program.text, line: Number(event["line"]) }] : [],
    );
  }

  private card(alarm: Alarm): HTMLElement {
    const { event, program } = alarm;
    const isScript = event["kind"] === "script";
    const code = Number(event["code"] ?? 0);
    const isStop = !isScript && code === 100;
    const todo: Word = isScript
      ? "do_script"
      : isStop
        ? "do_protective"
        : code === 101
          ? "do_emergency"
          : code === 120
            ? "do_recording"
            : code === 130
              ? "do_fault"
              : "do_other";
    const close = make("button", { type: "button", class: "quiet", "data-testid": "alarm-dismiss" }, t("dismiss"));
    close.addEventListener("click", () => {
      this.alarms = this.alarms.filter((one) => one !== alarm);
      this.showAlarms();
    });
    const buttons: HTMLElement[] = [close];
    const place: HTMLElement[] = [];
    const line = Number(event["line"] ?? 0);
    if (line > 0) {
      place.push(make("span", { class: "place" }, t("place", { name: program?.name ?? "", line })));
      const go = make("button", { type: "button", "data-testid": "alarm-go" }, t("go_line"));
      go.addEventListener("click", () => this.onPlace(Number(event["program"]), line));
      buttons.unshift(go);
    }
    if (isStop) {
      const unlock = make(
        "button",
        {
          type: "button",
          class: "primary",
          "data-testid": "alarm-unlock",
          disabled: byId<HTMLButtonElement>("unlock").disabled,
        },
        t("unlock"),
      );
      unlock.addEventListener("click", () => byId("unlock").click());
      buttons.unshift(unlock);
    }
    return make(
      "div",
      { class: "card" },
      make(
        "div",
        { class: "what" },
        make("b", {}, t("alarm")),
        make("strong", {}, alarmText(event, currentLanguage())),
        ...place,
        make("span", { class: "todo" }, t(todo)),
      ),
      make("div", { class: "row" }, ...buttons),
    );
  }

  /** Whether a protective stop can be left now. */
  enableUnlock(may: boolean): void {
    for (const button of byId("alarm").querySelectorAll<HTMLButtonElement>("[data-testid=alarm-unlock]"))
      button.disabled = !may;
  }

  /** A protective stop was unlocked, a program begins: what was told before is over. */
  clearAlarms(which: (event: ServerEvent) => boolean): void {
    const left = this.alarms.filter((alarm) => !which(alarm.event));
    if (left.length === this.alarms.length) return;
    this.alarms = left;
    this.showAlarms();
  }
}

export function setChip(id: string, text: string, kind: string, raw: string): void {
  const chip = byId(id);
  const value = chip.querySelector("b");
  if (!value) return;
  setText(value, text);
  value.dataset["value"] = raw;
  if (chip.title !== text) chip.title = text;
  chip.className = `chip ${kind}`;
}
