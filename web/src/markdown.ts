// The small part of Markdown that texts about functions use: code, headings, lists, bold, italic. Text stays text.

import { make } from "./dom";

/** Code, bold and italic within a line. */
function inline(text: string): (Node | string)[] {
  const parts: (Node | string)[] = [];
  let at = 0;
  for (const match of text.matchAll(/`([^`]+)`|\*\*([^*]+)\*\*|\*([^*\s][^*]*)\*/g)) {
    if (match.index > at) parts.push(text.slice(at, match.index));
    const [whole, code, bold, italic] = match;
    if (code !== undefined) parts.push(make("code", {}, code));
    else if (bold !== undefined) parts.push(make("b", {}, bold));
    else parts.push(make("i", {}, italic ?? ""));
    at = match.index + whole.length;
  }
  if (at < text.length) parts.push(text.slice(at));
  return parts;
}

/** Elements for a text. */
export function markdown(text: string): HTMLElement[] {
  const found: HTMLElement[] = [];
  const lines = text.split("\n");
  let paragraph: string[] = [];
  let list: HTMLElement | null = null;
  const close = (): void => {
    if (paragraph.length > 0) found.push(make("p", {}, ...inline(paragraph.join(" "))));
    paragraph = [];
    list = null;
  };
  for (let k = 0; k < lines.length; k++) {
    const line = lines[k] ?? "";
    const item = /^\s*[-*] (.*)$/.exec(line);
    if (line.startsWith("```")) {
      close();
      const code: string[] = [];
      for (k += 1; k < lines.length && !lines[k]?.startsWith("```"); k++) code.push(lines[k] ?? "");
      found.push(make("pre", {}, code.join("\n")));
    } else if (item) {
      if (!list) {
        close();
        list = make("ul");
        found.push(list);
      }
      list.append(make("li", {}, ...inline(item[1] ?? "")));
    } else if (line.trim() === "" || line.trim() === "---") close();
    else {
      if (list) close();
      paragraph.push(line.replace(/^#+ /, ""));
    }
  }
  close();
  return found;
}
