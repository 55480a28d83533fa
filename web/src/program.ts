// Programs: the list, the editor with the findings of `check`, completion and hover, saving with a guard, the running line.

import { autocompletion, type CompletionContext, type CompletionResult, completeAnyWord } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { bracketMatching, HighlightStyle, indentUnit, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { python } from "@codemirror/legacy-modes/mode/python";
import { type Diagnostic, lintGutter, linter, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState, RangeSetBuilder, StateEffect, StateField } from "@codemirror/state";
import { Decoration, type DecorationSet, drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, hoverTooltip, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { ask, byId, fixed, make, setText, toast } from "./dom";
import { api, type Link } from "./link";
import { onLanguage, t } from "./words";

interface Builtin {
  name: string;
  signature: string;
  summary: string;
  section: string;
  category: string;
  params: { name: string; unit: string; meaning: string; range: string | null }[];
}
interface Finding {
  line: number;
  column: number;
  end_line: number;
  end_column: number;
  code: string;
  message: string;
  help: string | null;
}
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

const KEYWORDS = ["def", "end", "if", "elif", "else", "while", "for", "in", "return", "break", "continue", "thread", "global", "try", "except", "finally", "raise", "True", "False", "None", "and", "or", "not", "import", "from", "class", "lambda", "pass", "sec"];
const CHECK_MS = 300;
export const START_TEXT = "def program():\n  movej([0, -1.2, 1.4, -1.77, -1.57, 0], a=1.4, v=1.0)\n  sleep(0.5)\nend\n";

const setRunning = StateEffect.define<number>();
const runningLine = Decoration.line({ class: "cm-running", attributes: { "aria-current": "step", "data-testid": "running-line" } });
const runningField = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(lines, transaction) {
    let shown = lines.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (!effect.is(setRunning)) continue;
      const builder = new RangeSetBuilder<Decoration>();
      const line = effect.value;
      if (line >= 1 && line <= transaction.state.doc.lines) {
        const at = transaction.state.doc.line(line).from;
        builder.add(at, at, runningLine);
      }
      shown = builder.finish();
    }
    return shown;
  },
  provide: (field) => EditorView.decorations.from(field),
});

const colors = HighlightStyle.define([
  { tag: tags.keyword, color: "var(--code-keyword)" },
  { tag: tags.comment, color: "var(--code-comment)", fontStyle: "italic" },
  { tag: tags.string, color: "var(--code-string)" },
  { tag: tags.number, color: "var(--code-number)" },
  { tag: [tags.standard(tags.name), tags.definition(tags.variableName)], color: "var(--code-name)" },
]);

/** Nodes of the pendant's task: lines `$ LINE: (number, "label", …)`. */
export function nodesOf(text: string): { number: number; label: string; line: number }[] {
  const found: { number: number; label: string; line: number }[] = [];
  text.split("\n").forEach((line, k) => {
    const match = /^\s*\$ LINE: \((\d+), "((?:[^"\\]|\\.)*)"/.exec(line);
    if (match) found.push({ number: Number(match[1]), label: match[2] ?? "", line: k + 1 });
  });
  return found;
}

/** `movej([…])` of a taught point. */
export function taught(q: readonly number[], indent: string): string {
  return `${indent}movej([${q.map((x) => fixed(x, 5)).join(", ")}], a=1.4, v=1.0)\n`;
}

export class Programs {
  private readonly view: EditorView;
  private etag: string | null = null;
  private saved = START_TEXT;
  private builtins: Builtin[] = [];
  private timer: ReturnType<typeof setTimeout> | null = null;
  private asked = 0;
  private running: RunningProgram | null = null;
  private line = 0;
  private node = 0;
  private findings: Finding[] = [];
  private readOnly = false;

  constructor(private readonly link: Link) {
    const nonce = document.querySelector<HTMLMetaElement>("meta[name=style-nonce]")?.content ?? "";
    this.view = new EditorView({
      parent: byId("editor"),
      state: EditorState.create({
        doc: START_TEXT,
        extensions: [
          nonce ? EditorView.cspNonce.of(nonce) : [],
          lineNumbers(), highlightActiveLine(), highlightActiveLineGutter(), drawSelection(), history(), bracketMatching(), highlightSelectionMatches(),
          indentUnit.of("  "), EditorState.tabSize.of(8), StreamLanguage.define(python), syntaxHighlighting(colors),
          // All style sheets at once: one that came later would be refused by the policy of the page.
          linter(null), lintGutter(), runningField,
          autocompletion({ override: [(context) => this.complete(context)] }),
          hoverTooltip((view, at) => this.hover(view, at)),
          keymap.of([
            { key: "Mod-s", run: () => (void this.save(), true) },
            { key: "Escape", run: (view) => (view.contentDOM.blur(), true) },
            ...defaultKeymap, ...historyKeymap, ...searchKeymap, indentWithTab,
          ]),
          EditorView.contentAttributes.of({ "data-testid": "editor", "aria-label": "Program text" }),
          EditorView.updateListener.of((update) => {
            if (update.docChanged) this.changed();
          }),
        ],
      }),
    });
    byId("new").addEventListener("click", () => void this.fresh());
    byId("open").addEventListener("click", () => void this.choose());
    byId("save").addEventListener("click", () => void this.save());
    byId("run").addEventListener("click", () => void this.run(false));
    byId("show-running").addEventListener("click", () => {
      if (this.running) void this.showText(this.running.name, this.running.text, null);
    });
    byId("program-name").addEventListener("input", () => (this.etag = null));
    onLanguage(() => (this.showFindings(), this.mark()));
    void api<Builtin[]>("/api/v1/builtins").then((list) => (this.builtins = list)).catch(() => undefined);
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
    this.showNodes();
    this.mark();
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.check(), CHECK_MS);
  }

  private async check(): Promise<void> {
    const number = ++this.asked;
    const text = this.text;
    try {
      const findings = await api<Finding[]>("/api/v1/check", { body: { name: this.name, text } });
      if (number !== this.asked) return;
      this.findings = findings;
      this.showFindings();
      const doc = this.view.state.doc;
      const at = (line: number, column: number): number => {
        const found = doc.line(Math.min(Math.max(line, 1), doc.lines));
        // Columns count characters, places of the editor count UTF-16 units.
        const before = [...found.text].slice(0, Math.max(column - 1, 0)).join("").length;
        return Math.min(found.from + before, found.to);
      };
      const marks = findings.map((finding): Diagnostic => {
        const from = at(finding.line, finding.column);
        const text = finding.help ? `${finding.message} (${finding.help})` : finding.message;
        return { from, to: Math.max(from, at(finding.end_line, finding.end_column)), severity: /^(unused|unreachable|degrees)/.test(finding.code) ? "warning" : "error", message: text, source: finding.code };
      });
      this.view.dispatch(setDiagnostics(this.view.state, marks));
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
    list.replaceChildren(...this.findings.map((finding) => {
      const button = make("button", { type: "button", class: "quiet" }, `${finding.line}:${finding.column} ${finding.message}${finding.help ? ` – ${finding.help}` : ""}`);
      button.addEventListener("click", () => this.goTo(finding.line));
      return make("li", { "data-code": finding.code }, button);
    }));
  }

  goTo(line: number): void {
    const doc = this.view.state.doc;
    const at = doc.line(Math.min(Math.max(line, 1), doc.lines)).from;
    this.view.dispatch({ selection: { anchor: at }, effects: EditorView.scrollIntoView(at, { y: "center" }) });
    byId("code").scrollIntoView({ block: "start" });
    this.view.focus();
  }

  private showNodes(): void {
    const nodes = nodesOf(this.text);
    byId("nodes-box").hidden = nodes.length === 0;
    byId("nodes").replaceChildren(...nodes.slice(0, 500).map((node) => {
      const button = make("button", { type: "button", class: "quiet" }, `${node.number} ${node.label}`);
      button.addEventListener("click", () => this.goTo(node.line));
      return make("li", { "data-node": String(node.number) }, button);
    }));
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

  private complete(context: CompletionContext): CompletionResult | null | Promise<CompletionResult | null> {
    const word = context.matchBefore(/[A-Za-z_]\w*/);
    if (!word && !context.explicit) return null;
    const own = completeAnyWord(context) as CompletionResult | null;
    const known = new Set(this.builtins.map((builtin) => builtin.name));
    return {
      from: word?.from ?? context.pos,
      options: [
        ...this.builtins.map((builtin) => ({ label: builtin.name, type: "function", detail: builtin.signature.slice(builtin.name.length), info: builtin.summary, boost: 1 })),
        ...KEYWORDS.map((label) => ({ label, type: "keyword" })),
        ...(own?.options ?? []).filter((option) => !known.has(option.label) && !KEYWORDS.includes(option.label)),
      ],
      validFor: /^\w*$/,
    };
  }

  private hover(view: EditorView, at: number): { pos: number; end: number; create: () => { dom: HTMLElement } } | null {
    const word = view.state.wordAt(at);
    const name = word ? view.state.sliceDoc(word.from, word.to) : "";
    const builtin = this.builtins.find((one) => one.name === name);
    if (!word || !builtin) return null;
    const rows = builtin.params.map((p) => make("div", {}, make("b", {}, p.name), ` ${[p.unit, p.range ?? "", p.meaning].filter((text) => text !== "").join(" · ")}`));
    const section = builtin.section ? `  §${builtin.section}` : "";
    return { pos: word.from, end: word.to, create: () => ({ dom: make("div", { class: "hover" }, make("code", {}, builtin.signature), make("p", {}, builtin.summary + section), ...rows) }) };
  }

  private async maySwap(): Promise<boolean> {
    if (!this.isDirty) return true;
    const answer = await ask([t("discard")], [{ text: t("cancel"), value: "" }, { text: t("yes_discard"), value: "yes", primary: true }], t("discard"));
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
      const content = [make("h2", {}, t("programs")), make("div", { class: "files" }, ...(rows.length > 0 ? rows : [make("p", { class: "hint" }, t("no_programs"))]))];
      const answer = await ask(content, [{ text: t("close"), value: "" }], t("programs"));
      if (answer.startsWith("open:") && (await this.maySwap())) await this.open(answer.slice(5));
    } catch (error) {
      toast((error as Error).message, "error");
    }
  }

  private async open(name: string): Promise<void> {
    try {
      const path = name.split("/").map(encodeURIComponent).join("/");
      const opened = await api<Opened>(`/api/v1/tasks/${path}`);
      this.put(opened.name, opened.text, opened.etag);
    } catch (error) {
      toast((error as Error).message, "error");
    }
  }

  private put(name: string, text: string, etag: string | null): void {
    byId<HTMLInputElement>("program-name").value = name;
    this.saved = text;
    this.etag = etag;
    this.replace(text);
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
      const { etag } = await api<{ etag: string }>(path, { method: "PUT", body: { text, before: this.etag }, token: this.link.token });
      this.etag = etag;
      this.saved = text;
      byId("dirty").hidden = !this.isDirty;
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
    const choices = [{ text: t("cancel"), value: "" }, { text: t("load_theirs"), value: "theirs" }, { text: t("overwrite"), value: "mine", primary: true }];
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

  teach(q: readonly number[]): void {
    const { state } = this.view;
    const line = state.doc.lineAt(state.selection.main.head);
    const indent = /^\s*/.exec(line.text)?.[0] ?? "";
    const isBlank = line.text.trim() === "";
    const own = isBlank ? indent || "  " : indent || (line.number === 1 ? "  " : indent);
    const insert = isBlank ? taught(q, own).trimEnd() : `\n${taught(q, own).trimEnd()}`;
    const at = line.to;
    this.view.dispatch({ changes: isBlank ? { from: line.from, to: line.to, insert } : { from: at, insert }, selection: { anchor: (isBlank ? line.from : at) + insert.length } });
    toast(t("taught"));
  }

  /** Another program is shown as the running one. */
  setProgram(program: RunningProgram | null): void {
    this.running = program;
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
      const effects: StateEffect<unknown>[] = [setRunning.of(line)];
      if (line > 0 && line <= this.view.state.doc.lines) effects.push(EditorView.scrollIntoView(this.view.state.doc.line(line).from, { y: "nearest" }));
      // Called from an update listener as well, in which nothing may be dispatched.
      queueMicrotask(() => this.view.dispatch({ effects }));
    }
    const other = byId("running-other");
    other.hidden = isOwn || this.running === null || this.line === 0;
    const text = other.querySelector("span");
    if (text && this.running) setText(text, t("running_other", { name: this.running.name, line: this.line }));
    this.markNode();
  }

  enable(may: boolean, maySave: boolean): void {
    byId<HTMLButtonElement>("run").disabled = !may;
    byId<HTMLButtonElement>("save").disabled = !maySave;
  }
}
