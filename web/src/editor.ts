// The editor: CodeMirror with what the server tells about the text, the running line and breakpoints. Knows no files
// and no arm.

import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { bracketMatching, HighlightStyle, indentUnit, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { python } from "@codemirror/legacy-modes/mode/python";
import { type Diagnostic, lintGutter, linter, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { Compartment, EditorState, type Extension, StateEffect, StateField } from "@codemirror/state";
import {
  Decoration,
  type DecorationSet,
  drawSelection,
  EditorView,
  highlightActiveLine,
  highlightActiveLineGutter,
  keymap,
  lineNumbers,
  placeholder,
  tooltips,
} from "@codemirror/view";
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
const runningLine = Decoration.line({
  class: "cm-running",
  attributes: { "aria-current": "step", "data-testid": "running-line" },
});
const runningField = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(lines, transaction) {
    let shown = lines.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (!effect.is(setRunning)) continue;
      const isLine = effect.value >= 1 && effect.value <= transaction.state.doc.lines;
      shown = isLine
        ? Decoration.set(runningLine.range(transaction.state.doc.line(effect.value).from))
        : Decoration.none;
    }
    return shown;
  },
  provide: (field) => EditorView.decorations.from(field),
});

const setAlarms = StateEffect.define<readonly number[]>();
const alarmLine = Decoration.line({ class: "cm-alarm", attributes: { "data-testid": "alarm-line" } });
const alarmField = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(lines, transaction) {
    let shown = lines.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (!effect.is(setAlarms)) continue;
      const { doc } = transaction.state;
      const there = [...new Set(effect.value)].filter((line) => line >= 1 && line <= doc.lines).sort((a, b) => a - b);
      shown = Decoration.set(there.map((line) => alarmLine.range(doc.line(line).from)));
    }
    return shown;
  },
  provide: (field) => EditorView.decorations.from(field),
});

const hint = new Compartment();

const colors = HighlightStyle.define([
  { tag: tags.keyword, color: "var(--code-keyword)" },
  { tag: tags.comment, color: "var(--code-comment)", fontStyle: "italic" },
  { tag: tags.string, color: "var(--code-string)" },
  { tag: tags.number, color: "var(--code-number)" },
  { tag: [tags.standard(tags.name), tags.definition(tags.variableName)], color: "var(--code-name)" },
]);

/** `def … end`: the words of the language that Python does not have. */
const script = StreamLanguage.define({
  ...python,
  token: (stream, state) => (stream.match(/^(?:end|thread|sec)\b/) ? "keyword" : python.token(stream, state)),
});

export interface EditorOptions {
  host: HTMLElement;
  label: string;
  hint: string;
  text: string;
  extensions: Extension[];
  onChange: () => void;
  onSave: () => void;
}

export function makeEditor({
  host,
  label,
  hint: words,
  text,
  extensions,
  onChange,
  onSave,
}: EditorOptions): EditorView {
  const nonce = document.querySelector<HTMLMetaElement>("meta[name=style-nonce]")?.content ?? "";
  return new EditorView({
    parent: host,
    state: EditorState.create({
      doc: text,
      extensions: [
        nonce ? EditorView.cspNonce.of(nonce) : [],
        extensions,
        lineNumbers(),
        highlightActiveLine(),
        highlightActiveLineGutter(),
        drawSelection(),
        history(),
        bracketMatching(),
        highlightSelectionMatches(),
        indentUnit.of("  "),
        EditorState.tabSize.of(8),
        script,
        syntaxHighlighting(colors),
        // All style sheets at once: one that came later would be refused by the policy of the page.
        linter(null),
        lintGutter(),
        runningField,
        alarmField,
        hint.of(placeholder(words)),
        // What floats over the text stays over it: buttons beside the editor are never covered.
        tooltips({ tooltipSpace: (view) => spaceOf(view) }),
        keymap.of([
          { key: "Mod-s", run: () => (onSave(), true) },
          { key: "Escape", run: (view) => (view.contentDOM.blur(), true) },
          ...defaultKeymap,
          ...historyKeymap,
          ...searchKeymap,
          indentWithTab,
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
  view.dispatch({
    changes: fix.edits.map((edit) => ({
      from: unitsBefore(doc, edit.from),
      to: unitsBefore(doc, edit.to),
      insert: edit.text,
    })),
    userEvent: "input.fix",
  });
}

/** The editor, as far as it is seen. */
function spaceOf(view: EditorView): { top: number; left: number; bottom: number; right: number } {
  const own = view.dom.getBoundingClientRect();
  return {
    top: Math.max(own.top, 0),
    left: Math.max(own.left, 0),
    bottom: Math.min(own.bottom, innerHeight),
    right: Math.min(own.right, innerWidth),
  };
}

/** What stands in an empty editor, in the language of the page. */
export function showHint(view: EditorView, words: string): void {
  view.dispatch({ effects: hint.reconfigure(placeholder(words)) });
}

/**
 * Scrolls the text to a line, and nothing around it: `EditorView.scrollIntoView` would scroll the panel as well, away
 * from what a hand is at.
 */
export function revealLine(view: EditorView, line: number, margin = 20): void {
  if (line < 1 || line > view.state.doc.lines) return;
  view.requestMeasure({
    read: () => view.lineBlockAt(view.state.doc.line(line).from),
    write: (block) => {
      const { scrollDOM } = view;
      const [top, bottom] = [block.top - margin, block.bottom + margin];
      if (top < scrollDOM.scrollTop) scrollDOM.scrollTop = top;
      else if (bottom > scrollDOM.scrollTop + scrollDOM.clientHeight)
        scrollDOM.scrollTop = bottom - scrollDOM.clientHeight;
    },
  });
}

/** Marks the running line; 0 for none. */
export function showRunning(view: EditorView, line: number): void {
  view.dispatch({ effects: setRunning.of(line) });
  revealLine(view, line);
}

/** Marks the lines that alarms name. */
export function showAlarmLines(view: EditorView, lines: readonly number[]): void {
  view.dispatch({ effects: setAlarms.of(lines) });
}
