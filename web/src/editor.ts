// The editor: CodeMirror with what the server tells about the text, the running line and breakpoints. Knows no files and no arm.

import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { bracketMatching, HighlightStyle, indentUnit, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { python } from "@codemirror/legacy-modes/mode/python";
import { type Diagnostic, lintGutter, linter, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState, type Extension, StateEffect, StateField } from "@codemirror/state";
import { Decoration, type DecorationSet, drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { unitsBefore } from "./advice";

/** What `check` finds. */
export interface Finding {
  line: number;
  column: number;
  end_line: number;
  end_column: number;
  severity: "error" | "warning";
  code: string;
  message: string;
  help: string | null;
  fixes: { title: string; edits: { from: number; to: number; text: string }[] }[];
}

const setRunning = StateEffect.define<number>();
const runningLine = Decoration.line({ class: "cm-running", attributes: { "aria-current": "step", "data-testid": "running-line" } });
const runningField = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(lines, transaction) {
    let shown = lines.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (!effect.is(setRunning)) continue;
      const isLine = effect.value >= 1 && effect.value <= transaction.state.doc.lines;
      shown = isLine ? Decoration.set(runningLine.range(transaction.state.doc.line(effect.value).from)) : Decoration.none;
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

/** `def … end`: the words of the language that Python does not have. */
const script = StreamLanguage.define({ ...python, token: (stream, state) => (stream.match(/^(?:end|thread|sec)\b/) ? "keyword" : python.token(stream, state)) });

export interface EditorOptions {
  host: HTMLElement;
  label: string;
  text: string;
  extensions: Extension[];
  onChange: () => void;
  onSave: () => void;
}

export function makeEditor({ host, label, text, extensions, onChange, onSave }: EditorOptions): EditorView {
  const nonce = document.querySelector<HTMLMetaElement>("meta[name=style-nonce]")?.content ?? "";
  return new EditorView({
    parent: host,
    state: EditorState.create({
      doc: text,
      extensions: [
        nonce ? EditorView.cspNonce.of(nonce) : [],
        extensions,
        lineNumbers(), highlightActiveLine(), highlightActiveLineGutter(), drawSelection(), history(), bracketMatching(), highlightSelectionMatches(),
        indentUnit.of("  "), EditorState.tabSize.of(8), script, syntaxHighlighting(colors),
        // All style sheets at once: one that came later would be refused by the policy of the page.
        linter(null), lintGutter(), runningField,
        keymap.of([
          { key: "Mod-s", run: () => (onSave(), true) },
          { key: "Escape", run: (view) => (view.contentDOM.blur(), true) },
          ...defaultKeymap, ...historyKeymap, ...searchKeymap, indentWithTab,
        ]),
        EditorView.contentAttributes.of({ "data-testid": "editor", "aria-label": label }),
        EditorView.updateListener.of((update) => {
          if (update.docChanged) onChange();
        }),
      ],
    }),
  });
}

/** Marks what was found in the text. */
export function markFindings(view: EditorView, findings: readonly Finding[]): void {
  const { doc } = view.state;
  const at = (line: number, column: number): number => {
    const found = doc.line(Math.min(Math.max(line, 1), doc.lines));
    // Columns count characters, places of the editor count UTF-16 units.
    const before = [...found.text].slice(0, Math.max(column - 1, 0)).join("").length;
    return Math.min(found.from + before, found.to);
  };
  const marks = findings.map((finding): Diagnostic => {
    const from = at(finding.line, finding.column);
    return {
      from,
      to: Math.max(from, at(finding.end_line, finding.end_column)),
      severity: finding.severity,
      message: finding.help ? `${finding.message} (${finding.help})` : finding.message,
      source: finding.code,
      actions: finding.fixes.map((fix) => ({ name: fix.title, apply: (target: EditorView) => applyFix(target, fix) })),
    };
  });
  view.dispatch(setDiagnostics(view.state, marks));
}

/** Makes a change that does away with a finding; the text must be the one in which it was found. */
export function applyFix(view: EditorView, fix: Finding["fixes"][number]): void {
  const { doc } = view.state;
  view.dispatch({ changes: fix.edits.map((edit) => ({ from: unitsBefore(doc, edit.from), to: unitsBefore(doc, edit.to), insert: edit.text })), userEvent: "input.fix" });
}

/** Marks the running line; 0 for none. */
export function showRunning(view: EditorView, line: number): void {
  const effects: StateEffect<unknown>[] = [setRunning.of(line)];
  if (line > 0 && line <= view.state.doc.lines) effects.push(EditorView.scrollIntoView(view.state.doc.line(line).from, { y: "nearest" }));
  view.dispatch({ effects });
}
