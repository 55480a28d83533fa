// Programs: the list, the editor with its findings, saving with a guard, breakpoints, the running line and node.

import type { EditorView } from "@codemirror/view";
import { advice } from "./advice";
import { breakpointGutter, breakpointsOf, putBreakpoints, showHeld } from "./breakpoints";
import type { Breakpoint, Placed } from "./debugger";
import { askForCondition } from "./debugpanel";
import { ask, byId, make, setText, toast } from "./dom";
import { applyFix, type Finding, makeEditor, markFindings, showAlarmLines, showHint, showRunning } from "./editor";
import { api, type Link } from "./link";
import { firstTarget, pointLine, spotFor } from "./taught";
import { currentLanguage, onLanguage, t } from "./words";

interface Opened {
  name: string;
  etag: string;
  text: string;
}
export interface RunningProgram {
  number: number;
  name: string;
  text: string;
}

const CHECK_MS = 300;
/** Programs whose breakpoints are kept while others are in the editor. */
const PUT_BY_MAX = 20;
/** There is no program at first: what runs by a click is always what somebody has written or opened. */
const START_TEXT = "";

/** Nodes of the pendant's task: lines `$ LINE: (number, "label", …)`. */
export function nodesOf(text: string): { number: number; label: string; line: number }[] {
  const found: { number: number; label: string; line: number }[] = [];
  text.split("\n").forEach((line, k) => {
    const match = /^\s*\$ LINE: \((\d+), "((?:[^"\\]|\\.)*)"/.exec(line);
    if (match) found.push({ number: Number(match[1]), label: match[2] ?? "", line: k + 1 });
  });
  return found;
}

export class Programs {
  private readonly view: EditorView;
  private etag: string | null = null;
  private saved = START_TEXT;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private asked = 0;
  private running: RunningProgram | null = null;
  /** The line at which the running program is held; 0 where it is not. */
  private held = 0;
  private line = 0;
  private node = 0;
  /** There is nothing to run. */
  isEmpty = true;
  private findings: Finding[] = [];
  private readOnly = false;

  /** Somebody has changed breakpoints, or opened a program with others. */
  onBreakpoints: () => void = () => undefined;
  /** The text has changed: whether there is one to run, and what its alarms name. */
  onText: () => void = () => undefined;
  /** Breakpoints of programs that are not in the editor. */
  private readonly putBy = new Map<string, Breakpoint[]>();

  constructor(private readonly link: Link) {
    const edited = (view: EditorView, line: number): void => void this.editBreakpoint(view, line);
    this.view = makeEditor({
      host: byId("editor"),
      label: t("editor"),
      hint: t("no_program"),
      text: START_TEXT,
      extensions: [breakpointGutter(() => this.onBreakpoints(), edited), advice(() => this.name)],
      onChange: () => this.changed(),
      onSave: () => void this.save(),
    });
    byId("new").addEventListener("click", () => void this.fresh());
    byId("open").addEventListener("click", () => void this.choose());
    byId("save").addEventListener("click", () => void this.save());
    byId("show-running").addEventListener("click", () => {
      if (this.running) void this.showText(this.running.name, this.running.text, null);
    });
    byId("program-name").addEventListener("input", () => (this.etag = null));
    onLanguage(() => {
      this.view.contentDOM.setAttribute("aria-label", t("editor"));
      showHint(this.view, t("no_program"));
      void this.check();
      this.mark();
    });
    this.changed();
  }

  get text(): string {
    return this.view.state.doc.toString();
  }

  get name(): string {
    return byId<HTMLInputElement>("program-name").value.trim();
  }

  get isDirty(): boolean {
    return this.text !== this.saved;
  }

  private replace(text: string): void {
    this.view.dispatch({ changes: { from: 0, to: this.view.state.doc.length, insert: text } });
  }

  private changed(): void {
    byId("dirty").hidden = !this.isDirty;
    this.isEmpty = this.text.trim() === "";
    this.showNodes();
    this.mark();
    this.onText();
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.check(), CHECK_MS);
  }

  private async check(): Promise<void> {
    const number = ++this.asked;
    const text = this.text;
    try {
      const findings = await api<Finding[]>("/api/v1/check", {
        body: { name: this.name, text, language: currentLanguage() },
      });
      if (number !== this.asked || text !== this.text) return;
      this.findings = findings;
      this.showFindings();
      markFindings(this.view, findings);
    } catch {
      // The next change asks again.
    }
  }

  private showFindings(): void {
    const list = byId("problems");
    if (this.findings.length === 0) {
      list.replaceChildren(make("li", { class: "hint" }, t("no_problems")));
      return;
    }
    list.replaceChildren(
      ...this.findings.map((finding) => {
        const button = make(
          "button",
          { type: "button", class: "quiet" },
          `${finding.line}:${finding.column} ${finding.message}${finding.help ? ` – ${finding.help}` : ""}`,
        );
        button.addEventListener("click", () => this.goTo(finding.line, finding.column));
        const fixes = finding.fixes.slice(0, 3).map((fix) => {
          const apply = make("button", { type: "button", class: "fix", "data-testid": "fix" }, fix.title);
          apply.addEventListener("click", () => applyFix(this.view, fix));
          return apply;
        });
        return make("li", { "data-code": finding.code, class: finding.severity }, button, ...fixes);
      }),
    );
  }

  goTo(line: number, column = 1): void {
    const doc = this.view.state.doc;
    const found = doc.line(Math.min(Math.max(line, 1), doc.lines));
    const at = found.from + [...found.text].slice(0, Math.max(column - 1, 0)).join("").length;
    this.view.dispatch({ selection: { anchor: at }, scrollIntoView: true });
    byId("code").scrollIntoView({ block: "start" });
    this.view.focus();
  }

  private showNodes(): void {
    const nodes = nodesOf(this.text);
    byId("nodes-box").hidden = nodes.length === 0;
    byId("nodes").replaceChildren(
      ...nodes.slice(0, 500).map((node) => {
        const button = make("button", { type: "button", class: "quiet" }, `${node.number} ${node.label}`);
        button.addEventListener("click", () => this.goTo(node.line));
        return make("li", { "data-node": String(node.number) }, button);
      }),
    );
    this.markNode();
  }

  private markNode(): void {
    for (const item of byId("nodes").children) {
      const isHere = this.node > 0 && (item as HTMLElement).dataset["node"] === String(this.node);
      item.classList.toggle("here", isHere);
      if (isHere) item.setAttribute("aria-current", "step");
      else item.removeAttribute("aria-current");
    }
  }

  get breakpoints(): Breakpoint[] {
    return breakpointsOf(this.view.state);
  }

  /** Says what has become of the breakpoints. */
  showPlaced(placed: readonly Placed[]): void {
    const { breakpoints } = this;
    if (placed.length === breakpoints.length) putBreakpoints(this.view, breakpoints, placed);
  }

  /** The line at which the program is held; 0 for none. */
  showHeld(line: number): void {
    this.held = line;
    this.markHeld();
  }

  /** Which program runs is told on another channel than where it is held, so either may come first. */
  private markHeld(): void {
    const isOwn = this.running === null || this.running.text === this.text;
    showHeld(this.view, isOwn ? this.held : 0);
  }

  private async editBreakpoint(view: EditorView, line: number): Promise<void> {
    const all = breakpointsOf(view.state);
    const answer = await askForCondition(all.find((point) => point.line === line) ?? { line });
    if (answer === null) return;
    const left = all.filter((point) => point.line !== line);
    putBreakpoints(view, answer === "remove" ? left : [...left, answer].sort((a, b) => a.line - b.line));
    this.onBreakpoints();
  }

  private async maySwap(): Promise<boolean> {
    if (!this.isDirty) return true;
    const answer = await ask(
      [t("discard")],
      [
        { text: t("cancel"), value: "" },
        { text: t("yes_discard"), value: "yes", primary: true },
      ],
      t("discard"),
    );
    return answer === "yes";
  }

  private async fresh(): Promise<void> {
    if (await this.maySwap()) this.put("untitled.script", START_TEXT, null);
  }

  private async choose(): Promise<void> {
    try {
      const list = await api<{ name: string; bytes: number }[]>("/api/v1/tasks");
      const dialog = byId<HTMLDialogElement>("dialog");
      const rows = list.map((entry) => {
        const button = make("button", { type: "button", class: "file" }, entry.name);
        button.addEventListener("click", () => dialog.close(`open:${entry.name}`));
        return button;
      });
      const content = [
        make("h2", {}, t("programs")),
        make("div", { class: "files" }, ...(rows.length > 0 ? rows : [make("p", { class: "hint" }, t("no_programs"))])),
      ];
      const answer = await ask(content, [{ text: t("close"), value: "" }], t("programs"));
      if (answer.startsWith("open:") && (await this.maySwap())) await this.open(answer.slice(5));
    } catch (error) {
      toast((error as Error).message, "error");
    }
  }

  private async open(name: string): Promise<void> {
    try {
      const path = name.split("/").map(encodeURIComponent).join("/");
      const before = this.text;
      const opened = await api<Opened>(`/api/v1/tasks/${path}`);
      // What was typed while the file was on its way is nobody's to discard unasked.
      if (this.text !== before && !(await this.maySwap())) return;
      this.put(opened.name, opened.text, opened.etag);
    } catch (error) {
      toast((error as Error).message, "error");
    }
  }

  private put(name: string, text: string, etag: string | null): void {
    this.putBy.set(this.name, this.breakpoints);
    if (this.putBy.size > PUT_BY_MAX) this.putBy.delete([...this.putBy.keys()][0] ?? "");
    byId<HTMLInputElement>("program-name").value = name;
    this.saved = text;
    this.etag = etag;
    this.replace(text);
    putBreakpoints(this.view, this.putBy.get(name) ?? []);
    this.onBreakpoints();
    this.changed();
  }

  private async showText(name: string, text: string, etag: string | null): Promise<void> {
    if (await this.maySwap()) this.put(name, text, etag);
  }

  async save(): Promise<boolean> {
    const { name, text } = this;
    if (!/\.(script|task)$/.test(name)) {
      toast(t("name_needed"), "error");
      return false;
    }
    const path = `/api/v1/tasks/${name.split("/").map(encodeURIComponent).join("/")}`;
    try {
      const { etag } = await api<{ etag: string }>(path, {
        method: "PUT",
        body: { text, before: this.etag },
        token: this.link.token,
      });
      // Another program may be in the editor by now: this is not its state.
      if (this.name === name) {
        this.etag = etag;
        this.saved = text;
        byId("dirty").hidden = !this.isDirty;
      }
      toast(t("saved"));
      return true;
    } catch (error) {
      if ((error as { status?: number }).status !== 409) {
        toast((error as Error).message, "error");
        return false;
      }
      return this.conflict(path);
    }
  }

  private async conflict(path: string): Promise<boolean> {
    const choices = [
      { text: t("cancel"), value: "" },
      { text: t("load_theirs"), value: "theirs" },
      { text: t("overwrite"), value: "mine", primary: true },
    ];
    const answer = await ask([t("conflict")], choices, t("conflict"));
    if (answer === "") return false;
    const now = await api<Opened>(path).catch(() => null);
    if (answer === "theirs") {
      if (now) this.put(now.name, now.text, now.etag);
      return false;
    }
    this.etag = now?.etag ?? null;
    return this.save();
  }

  async run(step: boolean): Promise<void> {
    try {
      await this.link.order({ do: "run", name: this.name || "untitled.script", text: this.text, step });
    } catch (error) {
      toast((error as Error).message, "error");
    }
  }

  /** Where the program goes first, if that is written in numbers. */
  get start(): ReturnType<typeof firstTarget> {
    return firstTarget(this.text);
  }

  teach(q: readonly number[], name = ""): void {
    const { doc, selection } = this.view.state;
    const spot = spotFor(doc.toString().split("\n"), doc.lineAt(selection.main.head).number - 1);
    const line = doc.line(spot.line + 1);
    const text = spot.indent + pointLine(q, name);
    const insert = spot.replaces ? text : `\n${text}`;
    const from = spot.replaces ? line.from : line.to;
    this.view.dispatch({ changes: { from, to: line.to, insert }, selection: { anchor: from + insert.length } });
    toast(t("taught"));
  }

  /** Shows a line of a program; another one in the editor is left only when that is no loss. */
  async showLine(program: RunningProgram | null, line: number): Promise<void> {
    if (program && program.text !== this.text) await this.showText(program.name, program.text, null);
    if (!program || program.text === this.text) this.goTo(line);
  }

  /** Marks the lines of alarms that are about the text in the editor. */
  markAlarms(alarms: readonly { text: string; line: number }[]): void {
    const lines = alarms.filter((one) => one.text === this.text).map((one) => one.line);
    // Called from an update listener as well, in which nothing may be dispatched.
    queueMicrotask(() => showAlarmLines(this.view, lines));
  }

  /** Another program is shown as the running one. */
  setProgram(program: RunningProgram | null): void {
    this.running = program;
    if (this.held > 0) this.markHeld();
    if (program && this.readOnly && this.text !== program.text) this.put(program.name, program.text, null);
    this.mark();
  }

  /** A recording is shown: its program is, and nothing can be saved. */
  setReadOnly(readOnly: boolean): void {
    this.readOnly = readOnly;
  }

  setPlace(line: number, node: number): void {
    if (line === this.line && node === this.node) return;
    this.line = line;
    this.node = node;
    this.mark();
  }

  private shown = -1;

  private mark(): void {
    const isOwn = this.running !== null && this.running.text === this.text;
    const line = isOwn ? this.line : 0;
    if (line !== this.shown) {
      this.shown = line;
      // Called from an update listener as well, in which nothing may be dispatched.
      queueMicrotask(() => showRunning(this.view, this.shown));
    }
    const other = byId("running-other");
    other.hidden = isOwn || this.running === null || this.line === 0;
    const text = other.querySelector("span");
    if (text && this.running) setText(text, t("running_other", { name: this.running.name, line: this.line }));
    this.markNode();
  }

  /** A recording is looked at: nothing is opened, made or taught into its program. */
  enable(mayEdit: boolean, maySave: boolean): void {
    for (const id of ["new", "open", "teach"]) byId<HTMLButtonElement>(id).disabled = !mayEdit;
    byId<HTMLButtonElement>("save").disabled = !maySave;
  }
}
