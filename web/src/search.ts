// When a condition held: what is typed is looked for in the recording, and the time line jumps between what was found.

import { byId, setText } from "./dom";
import { api } from "./link";
import { onLanguage, t } from "./words";

export interface Stretch {
  from: number;
  to: number;
  cycles: number;
  program: string;
  line: number;
  command: string;
}
interface Found {
  stretches: Stretch[];
  found: number;
  cycles: number;
  complete: boolean;
}

type State = { is: "nothing" } | { is: "searching" } | { is: "failed"; text: string } | { is: "found"; found: Found };

export class Search {
  /** What was found; null while nothing is looked for. */
  stretches: Stretch[] | null = null;
  onFound: () => void = () => undefined;
  private readonly input = byId<HTMLInputElement>("find");
  private readonly result = byId("find-result");
  private asked: AbortController | null = null;
  private state: State = { is: "nothing" };

  constructor() {
    byId("find-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.look();
    });
    this.input.addEventListener("input", () => {
      if (this.input.value === "") this.clear();
    });
    onLanguage(() => this.show());
  }

  private clear(): void {
    this.asked?.abort();
    this.asked = null;
    this.stretches = null;
    this.state = { is: "nothing" };
    this.show();
    this.onFound();
  }

  private async look(): Promise<void> {
    const condition = this.input.value.trim();
    this.clear();
    if (condition === "") return;
    const asked = new AbortController();
    this.asked = asked;
    this.state = { is: "searching" };
    this.show();
    try {
      const found = await api<Found>("/api/v1/find", { body: { condition }, signal: asked.signal });
      if (this.asked !== asked) return;
      this.stretches = found.stretches;
      this.state = { is: "found", found };
      this.show();
      this.onFound();
    } catch (error) {
      if (this.asked !== asked) return;
      this.state = { is: "failed", text: error instanceof Error ? error.message : String(error) };
      this.show();
    }
  }

  private show(): void {
    const isFailed = this.state.is === "failed";
    this.input.setAttribute("aria-invalid", String(isFailed));
    this.result.classList.toggle("failed", isFailed);
    setText(this.result, this.text());
  }

  private text(): string {
    switch (this.state.is) {
      case "nothing":
        return "";
      case "searching":
        return t("searching");
      case "failed":
        return this.state.text;
      case "found": {
        const { stretches, complete, found, cycles } = this.state.found;
        return `${stretches.length}${complete ? "" : "+"} ${t("times")}, ${found} / ${cycles} ${t("cycles")}`;
      }
    }
  }
}
