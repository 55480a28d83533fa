// A named list of points: positions that somebody has saved, to go to again or to put into a program. This browser
// keeps it.

import { choiceOf, keepChoice } from "./choices";
import { byId, make, toast } from "./dom";
import { onLanguage, t } from "./words";

export interface Waypoint {
  name: string;
  q: number[];
}

const POINTS_MAX = 100;
const NAME_MAX = 40;

/** What is remembered; anything else than points is passed over. */
export function waypointsOf(text: string | null): Waypoint[] {
  let read: unknown;
  try {
    read = JSON.parse(text ?? "[]");
  } catch {
    return [];
  }
  const isPoint = (one: unknown): one is Waypoint => {
    const { name, q } = (one ?? {}) as Partial<Waypoint>;
    return (
      typeof name === "string" &&
      Array.isArray(q) &&
      q.length === 6 &&
      q.every((x) => typeof x === "number" && Number.isFinite(x))
    );
  };
  return Array.isArray(read)
    ? read
        .filter(isPoint)
        .slice(0, POINTS_MAX)
        .map(({ name, q }) => ({ name: name.slice(0, NAME_MAX), q }))
    : [];
}

/** A name that no point has yet: P1, P2, … */
export function freshName(points: readonly Waypoint[]): string {
  for (let n = 1; ; n++) if (!points.some((point) => point.name === `P${n}`)) return `P${n}`;
}

export interface WaypointActions {
  position: () => readonly number[] | null;
  go: (q: readonly number[]) => void;
  insert: (point: Waypoint) => void;
}

export class Waypoints {
  private points: Waypoint[] = waypointsOf(choiceOf("waypoints"));
  private may = false;
  private mayInsert = false;

  constructor(private readonly actions: WaypointActions) {
    byId("waypoint-save").addEventListener("click", () => this.save());
    onLanguage(() => this.show());
    this.show();
  }

  private save(): void {
    const q = this.actions.position();
    if (!q) return;
    if (this.points.length >= POINTS_MAX) return toast(t("waypoints_full", { n: POINTS_MAX }), "error");
    this.points.push({ name: freshName(this.points), q: [...q] });
    this.keep();
    this.show();
  }

  private keep(): void {
    keepChoice("waypoints", JSON.stringify(this.points));
  }

  private show(): void {
    const rows = this.points.map((point) => this.row(point));
    byId("waypoints").replaceChildren(...(rows.length > 0 ? rows : [make("li", { class: "hint" }, t("no_waypoints"))]));
    this.enable(this.may, this.mayInsert);
  }

  private row(point: Waypoint): HTMLElement {
    const name = make("input", {
      "data-testid": "waypoint-name",
      "aria-label": t("name"),
      value: point.name,
      maxlength: NAME_MAX,
      spellcheck: "false",
      autocomplete: "off",
    });
    name.addEventListener("change", () => {
      point.name = name.value.trim() || point.name;
      name.value = point.name;
      this.keep();
    });
    const button = (testid: string, text: string, act: () => void): HTMLButtonElement => {
      const made = make("button", { type: "button", "data-testid": testid }, text);
      made.addEventListener("click", act);
      return made;
    };
    const go = button("waypoint-go", t("waypoint_go"), () => this.actions.go(point.q));
    const insert = button("waypoint-insert", t("waypoint_insert"), () => this.actions.insert(point));
    const remove = button("waypoint-remove", "✕", () => {
      this.points = this.points.filter((one) => one !== point);
      this.keep();
      this.show();
    });
    remove.setAttribute("aria-label", t("waypoint_remove", { name: point.name }));
    remove.title = t("waypoint_remove", { name: point.name });
    return make("li", { class: "waypoint" }, name, go, insert, remove);
  }

  enable(may: boolean, mayInsert: boolean): void {
    [this.may, this.mayInsert] = [may, mayInsert];
    for (const button of byId("waypoints").querySelectorAll<HTMLButtonElement>("[data-testid=waypoint-go]"))
      button.disabled = !may;
    for (const button of byId("waypoints").querySelectorAll<HTMLButtonElement>("[data-testid=waypoint-insert]"))
      button.disabled = !mayInsert;
  }
}
