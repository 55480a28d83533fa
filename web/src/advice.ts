// What the editor is told about the text: completions, the thing under the pointer, the call around the cursor. The
// answers are those of the language server, asked for over /api/v1.

import {
  autocompletion,
  closeCompletion,
  type Completion,
  type CompletionContext,
  type CompletionResult,
  completionStatus,
} from "@codemirror/autocomplete";
import { type EditorState, type Extension, Prec, StateEffect, StateField, type Text } from "@codemirror/state";
import {
  EditorView,
  hoverTooltip,
  keymap,
  showTooltip,
  type Tooltip,
  ViewPlugin,
  type ViewUpdate,
} from "@codemirror/view";
import { make } from "./dom";
import { api } from "./link";
import { markdown } from "./markdown";
import { currentLanguage } from "./words";

interface Item {
  label: string;
  kind: string;
  detail: string;
  rank: number;
}
interface Completions {
  from: number;
  to: number;
  complete: boolean;
  items: Item[];
}
interface About {
  from: number;
  to: number;
  text: string;
}
export interface Call {
  label: string;
  text: string;
  parameters: { written: string; text: string }[];
  active: number | null;
}

/** A call is looked for when the cursor has rested for so long. */
const CALL_MS = 120;
/** So far back an open parenthesis is looked for before the server is asked about a call. */
const LOOK_BACK = 2000;

/** The server counts characters, the editor UTF-16 units: both ways. */
export function charactersBefore(doc: Text, units: number): number {
  let characters = 0;
  for (const part of doc.iterRange(0, units)) characters += [...part].length;
  return characters;
}
export function unitsBefore(doc: Text, characters: number): number {
  let left = characters;
  let units = 0;
  for (const part of doc.iter()) {
    for (const letter of part) {
      if (left === 0) return units;
      left -= 1;
      units += letter.length;
    }
  }
  return units;
}

/** Whether a parenthesis before the place is open. Strings and comments may deceive it; the server knows better. */
export function mayBeInCall(before: string): boolean {
  let closed = 0;
  for (let k = before.length - 1; k >= 0; k--) {
    if (before[k] === ")") closed += 1;
    else if (before[k] === "(" && closed-- === 0) return true;
  }
  return false;
}

/** Of names that begin alike the motions that every program has come first. */
const FIRST = ["movej", "movel"];
/** How much nearer than anything else those are. */
const FIRST_BOOST = 40;

export function boostOf(label: string, rank: number): number {
  const place = FIRST.indexOf(label);
  return 10 - rank + (place < 0 ? 0 : FIRST_BOOST - place);
}

type Name = () => string;

function ask<T>(state: EditorState, at: number, name: Name, what: string, signal?: AbortSignal): Promise<T> {
  const body = {
    name: name(),
    text: state.doc.toString(),
    at: charactersBefore(state.doc, at),
    language: currentLanguage(),
  };
  return api<T>(`/api/v1/${what}`, { body, ...(signal ? { signal } : {}) });
}

/** The long text about a function, when one is looked at. */
async function info(label: string): Promise<Node | null> {
  try {
    const { text } = await api<{ text: string }>(
      `/api/v1/builtins/${encodeURIComponent(label)}?language=${currentLanguage()}`,
    );
    return make("div", { class: "hover" }, ...markdown(text));
  } catch {
    return null;
  }
}

async function complete(context: CompletionContext, name: Name): Promise<CompletionResult | null> {
  const before = context.matchBefore(/[\w.[\]"']+/);
  if (!before && !context.explicit) return null;
  const asked = new AbortController();
  context.addEventListener("abort", () => asked.abort());
  try {
    const found = await ask<Completions>(context.state, context.pos, name, "complete", asked.signal);
    if (found.items.length === 0) return null;
    const { doc } = context.state;
    const options = found.items.map((item): Completion => {
      const isLibrary = item.kind === "function" || item.kind === "class";
      const detail = item.detail.startsWith(item.label) ? item.detail.slice(item.label.length) : item.detail;
      return {
        label: item.label,
        type: item.kind,
        detail,
        boost: boostOf(item.label, item.rank),
        ...(isLibrary ? { info: () => info(item.label) } : {}),
      };
    });
    const isText = found.items[0]?.kind === "text";
    const result: CompletionResult = { from: unitsBefore(doc, found.from), options };
    if (found.complete) result.validFor = isText ? /^[\w[\]]*$/ : /^\w*$/;
    return result;
  } catch {
    return null;
  }
}

async function hover(view: EditorView, at: number, name: Name): Promise<Tooltip | null> {
  if (!view.state.wordAt(at)) return null;
  try {
    const about = await ask<About | null>(view.state, at, name, "hover");
    if (!about) return null;
    const { doc } = view.state;
    return {
      pos: unitsBefore(doc, about.from),
      end: unitsBefore(doc, about.to),
      above: true,
      create: () => ({ dom: make("div", { class: "hover", "data-testid": "hover" }, ...markdown(about.text)) }),
    };
  } catch {
    return null;
  }
}

const setCall = StateEffect.define<{ call: Call; at: number } | null>();

function callTooltip({ call, at }: { call: Call; at: number }): Tooltip {
  const active = call.active === null ? undefined : call.parameters[call.active];
  const begin = active ? call.label.indexOf(active.written, call.label.indexOf("(")) : -1;
  const label =
    active && begin >= 0
      ? [call.label.slice(0, begin), make("b", {}, active.written), call.label.slice(begin + active.written.length)]
      : [call.label];
  const about = active?.text ? markdown(active.text) : [];
  return {
    pos: at,
    above: true,
    create: () => ({
      dom: make("div", { class: "hover call", "data-testid": "call" }, make("pre", {}, ...label), ...about),
    }),
  };
}

const callField = StateField.define<Tooltip | null>({
  create: () => null,
  update(shown, transaction) {
    for (const effect of transaction.effects)
      if (effect.is(setCall)) return effect.value ? callTooltip(effect.value) : null;
    return shown && transaction.docChanged ? { ...shown, pos: transaction.changes.mapPos(shown.pos) } : shown;
  },
  provide: (field) => showTooltip.from(field),
});

/** Shows how the function is called whose call is being written. */
function callWatcher(name: Name): Extension {
  const watcher = ViewPlugin.fromClass(
    class {
      private timer: ReturnType<typeof setTimeout> | null = null;
      private asked = 0;

      update(update: ViewUpdate): void {
        if (update.focusChanged && !update.view.hasFocus) return this.hide(update.view);
        if (!update.docChanged && !update.selectionSet) return;
        // Only what is typed calls for it; the cursor that goes somewhere takes it away.
        const isTyped = update.transactions.some((one) => one.isUserEvent("input") || one.isUserEvent("delete"));
        const isShown = update.state.field(callField) !== null;
        if (!isTyped && !isShown) return;
        if (this.timer !== null) clearTimeout(this.timer);
        this.timer = setTimeout(() => void this.look(update.view), CALL_MS);
      }

      destroy(): void {
        this.forget();
      }

      /** What is still looked for is not shown any more either: it was typed before. */
      private forget(): void {
        if (this.timer !== null) clearTimeout(this.timer);
        this.timer = null;
        this.asked += 1;
      }

      private hide(view: EditorView): void {
        this.forget();
        if (view.state.field(callField) === null) return;
        queueMicrotask(() => view.dispatch({ effects: setCall.of(null) }));
      }

      /** Whether there was something to take away. */
      dismiss(view: EditorView): boolean {
        this.forget();
        if (view.state.field(callField) === null) return false;
        view.dispatch({ effects: setCall.of(null) });
        return true;
      }

      private async look(view: EditorView): Promise<void> {
        const { state } = view;
        const at = state.selection.main.head;
        if (!mayBeInCall(state.sliceDoc(Math.max(0, at - LOOK_BACK), at))) return this.hide(view);
        const number = ++this.asked;
        const call = await ask<Call | null>(state, at, name, "call").catch(() => null);
        if (number === this.asked && view.hasFocus && view.state.selection.main.head === at)
          view.dispatch({ effects: setCall.of(call && { call, at }) });
      }
    },
  );
  const escape = (view: EditorView): boolean => {
    // A list that is seen goes first, with an Escape of its own; one that is only thought about takes none.
    if (completionStatus(view.state) === "active" || !view.plugin(watcher)?.dismiss(view)) return false;
    closeCompletion(view);
    return true;
  };
  return [watcher, Prec.highest(keymap.of([{ key: "Escape", run: escape }]))];
}

/**
 * The text about a completion stands below the list or above it, where there is more room in the editor: it covers no
 * button beside it.
 */
function placeInfo(
  view: EditorView,
  list: { left: number; top: number; right: number; bottom: number },
  _option: unknown,
  info: { top: number; bottom: number },
  space: { top: number; bottom: number },
): { style: string } {
  const below = space.bottom - list.bottom - 6;
  const above = space.top < list.top ? list.top - space.top - view.defaultLineHeight - 6 : 0;
  const isBelow = below >= Math.min(info.bottom - info.top, 120) || below >= above;
  const width = `width: ${Math.round(list.right - list.left)}px; max-width: none;`;
  const room = Math.max(40, Math.min(Math.round(isBelow ? below : above), 260));
  const place = isBelow ? "top: 100%;" : `bottom: calc(100% + ${Math.round(view.defaultLineHeight)}px);`;
  return { style: `left: 0; ${place} ${width} max-height: ${room}px; overflow: auto;` };
}

/** Everything that the editor is told while somebody writes. `name` is the program's. */
export function advice(name: Name): Extension {
  return [
    // Before the completions, whose Escape is as urgent.
    callWatcher(name),
    autocompletion({
      positionInfo: placeInfo,
      override: [(context) => complete(context, name)],
      icons: true,
      maxRenderedOptions: 60,
    }),
    hoverTooltip((view, at) => hover(view, at, name), { hoverTime: 250 }),
    callField,
  ];
}
