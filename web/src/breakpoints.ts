// The gutter in which breakpoints are set, and the line at which a program is held.

import { type EditorState, type Extension, RangeSet, StateEffect, StateField } from "@codemirror/state";
import { Decoration, type DecorationSet, EditorView, gutter, GutterMarker, keymap } from "@codemirror/view";
import type { Breakpoint, Placed } from "./debugger";
import { revealLine } from "./editor";
import { t } from "./words";

class Mark extends GutterMarker {
  constructor(
    readonly spec: Omit<Breakpoint, "line">,
    readonly verified: boolean | null,
    readonly message: string,
  ) {
    super();
  }

  override eq(other: GutterMarker): boolean {
    return (
      other instanceof Mark &&
      this.verified === other.verified &&
      this.message === other.message &&
      JSON.stringify(this.spec) === JSON.stringify(other.spec)
    );
  }

  override toDOM(): HTMLElement {
    const element = document.createElement("div");
    const { condition, hitCondition, logMessage } = this.spec;
    const kind =
      logMessage !== undefined
        ? "logs"
        : condition !== undefined || hitCondition !== undefined
          ? "conditional"
          : "plain";
    element.className = `cm-breakpoint ${kind}${this.verified === false ? " unverified" : ""}`;
    element.dataset["testid"] = "breakpoint";
    element.title =
      [condition, hitCondition, logMessage, this.message]
        .filter((part) => part !== undefined && part !== "")
        .join(" · ") || t("breakpoint");
    return element;
  }
}

/** Room for a mark, so that the gutter has its width. */
const room = new (class extends GutterMarker {
  override toDOM(): HTMLElement {
    const element = document.createElement("div");
    element.className = "cm-breakpoint";
    return element;
  }
})();

const setPoints = StateEffect.define<{ point: Breakpoint; verified: boolean | null; message: string }[]>();
const setHeld = StateEffect.define<number>();

const points = StateField.define<RangeSet<Mark>>({
  create: () => RangeSet.empty,
  update(marks, transaction) {
    let shown = marks.map(transaction.changes);
    if (transaction.docChanged) shown = atLineStarts(shown, transaction.state);
    for (const effect of transaction.effects) {
      if (!effect.is(setPoints)) continue;
      const { doc } = transaction.state;
      const ranges = effect.value
        .filter(({ point }) => point.line >= 1 && point.line <= doc.lines)
        .map(({ point: { line, ...rest }, verified, message }) =>
          new Mark(rest, verified, message).range(doc.line(line).from),
        );
      shown = RangeSet.of(ranges, true);
    }
    return shown;
  },
});

/** Lines that were joined leave one mark; a mark stays at the beginning of its line. */
function atLineStarts(marks: RangeSet<Mark>, state: EditorState): RangeSet<Mark> {
  const found = new Map<number, Mark>();
  for (const cursor = marks.iter(); cursor.value; cursor.next())
    found.set(state.doc.lineAt(cursor.from).from, cursor.value);
  return RangeSet.of(
    [...found].map(([from, mark]) => mark.range(from)),
    true,
  );
}

// No test id: the line that runs has one, usually of the same line, and a line has one only.
const heldLine = Decoration.line({ class: "cm-held", attributes: { "data-held": "" } });
const held = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(lines, transaction) {
    let shown = lines.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (!effect.is(setHeld)) continue;
      const isLine = effect.value >= 1 && effect.value <= transaction.state.doc.lines;
      shown = isLine ? Decoration.set(heldLine.range(transaction.state.doc.line(effect.value).from)) : Decoration.none;
    }
    return shown;
  },
  provide: (field) => EditorView.decorations.from(field),
});

/** Breakpoints by line. */
export function breakpointsOf(state: EditorState): Breakpoint[] {
  const found: Breakpoint[] = [];
  for (const cursor = state.field(points).iter(); cursor.value; cursor.next())
    found.push({ line: state.doc.lineAt(cursor.from).number, ...cursor.value.spec });
  return found;
}

/** Puts breakpoints in place of those of before; `placed` says what has become of them. */
export function putBreakpoints(
  view: EditorView,
  breakpoints: readonly Breakpoint[],
  placed: readonly Placed[] = [],
): void {
  const value = breakpoints.map((point, k) => ({
    point,
    verified: placed[k]?.verified ?? null,
    message: placed[k]?.message ?? "",
  }));
  view.dispatch({ effects: setPoints.of(value) });
}

/** Marks the line at which the program is held; 0 for none. */
export function showHeld(view: EditorView, line: number): void {
  view.dispatch({ effects: setHeld.of(line) });
  revealLine(view, line, 40);
}

/**
 * The gutter. `onChange` is called when somebody has changed a breakpoint, `onEdit` when one is to have a condition.
 */
export function breakpointGutter(
  onChange: (view: EditorView) => void,
  onEdit: (view: EditorView, line: number) => void,
): Extension {
  const toggle = (view: EditorView, line: number): void => {
    const all = breakpointsOf(view.state);
    const left = all.filter((point) => point.line !== line);
    putBreakpoints(view, left.length === all.length ? [...all, { line }].sort((a, b) => a.line - b.line) : left);
    onChange(view);
  };
  const lineAt = (view: EditorView, from: number): number => view.state.doc.lineAt(from).number;
  const here = (view: EditorView): number => lineAt(view, view.state.selection.main.head);
  return [
    points,
    held,
    gutter({
      class: "cm-breakpoints",
      markers: (view) => view.state.field(points),
      initialSpacer: () => room,
      domEventHandlers: {
        mousedown(view, line, event) {
          if ((event as MouseEvent).button !== 0) return false;
          if ((event as MouseEvent).shiftKey) onEdit(view, lineAt(view, line.from));
          else toggle(view, lineAt(view, line.from));
          return true;
        },
        contextmenu(view, line, event) {
          event.preventDefault();
          onEdit(view, lineAt(view, line.from));
          return true;
        },
      },
    }),
    keymap.of([
      { key: "F9", run: (view) => (toggle(view, here(view)), true) },
      { key: "Shift-F9", run: (view) => (onEdit(view, here(view)), true) },
    ]),
    EditorView.updateListener.of((update) => {
      // Lines that move take their breakpoints along.
      if (update.docChanged && update.state.field(points).size > 0) onChange(update.view);
    }),
  ];
}
