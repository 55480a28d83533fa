// Elements by name, and made: text is only ever set as text.

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no #${id}`);
  return element as T;
}

type Props = Record<string, string | boolean | number | null>;

/** An element with attributes and children; strings become text nodes. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  props: Props = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (value === null || value === false) continue;
    element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children);
  return element;
}

/** Sets a text if it is another one, so that nothing is laid out anew for nothing. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

const toasts = (): HTMLElement => byId("toasts");

/** A short notice that goes by itself. */
export function toast(text: string, kind: "info" | "error" = "info"): void {
  const item = make("div", { class: `toast ${kind}` }, text);
  toasts().append(item);
  while (toasts().childElementCount > 4) toasts().firstElementChild?.remove();
  setTimeout(() => item.remove(), kind === "error" ? 7000 : 3500);
}

interface Choice {
  text: string;
  value: string;
  primary?: boolean;
}

/** Asks a question; the value of the choice, or "" when the dialog was closed. */
export function ask(content: (Node | string)[], choices: Choice[], label: string): Promise<string> {
  const dialog = byId<HTMLDialogElement>("dialog");
  let resolve: (value: string) => void = () => undefined;
  const promise = new Promise<string>((done) => (resolve = done));
  const buttons = choices.map((choice) => {
    const button = make(
      "button",
      { type: "button", class: choice.primary ? "primary" : null, "data-choice": choice.value },
      choice.text,
    );
    button.addEventListener("click", () => dialog.close(choice.value));
    return button;
  });
  // The dialog has a stop of its own beneath: everything behind a question is out of reach of pointer and touch.
  byId("question").replaceChildren(
    make("div", { class: "body" }, ...content),
    make("div", { class: "row end" }, ...buttons),
  );
  dialog.setAttribute("aria-label", label);
  dialog.returnValue = "";
  dialog.addEventListener("close", () => resolve(dialog.returnValue), { once: true });
  if (!dialog.open) dialog.showModal();
  return promise;
}

/** A number with so many digits behind the point, without "-0.000". */
export function fixed(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}
