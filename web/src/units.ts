// Angles and lengths as people write and read them: rad and m, or degrees and mm. Inside the page everything is SI.

import { choiceOf, keepChoice } from "./choices";
import { fixed } from "./dom";

export type Kind = "angle" | "length";
export type Units = "si" | "practical";

/** Names of units, and how many rad or m one is. */
// prettier-ignore
const FACTORS: Record<Kind, Record<string, number>> = {
  angle: {
    rad: 1, "弧度": 1, "°": Math.PI / 180, "º": Math.PI / 180, deg: Math.PI / 180, degree: Math.PI / 180,
    degrees: Math.PI / 180, "度": Math.PI / 180,
  },
  length: { m: 1, "米": 1, cm: 0.01, "厘米": 0.01, mm: 0.001, "毫米": 0.001 },
};
const OWN: Record<Units, Record<Kind, string>> = {
  si: { angle: "rad", length: "m" },
  practical: { angle: "°", length: "mm" },
};
const DIGITS: Record<Units, Record<Kind, number>> = { si: { angle: 4, length: 4 }, practical: { angle: 2, length: 1 } };

let chosen: Units = choiceOf("units") === "practical" ? "practical" : "si";
const listeners = new Set<() => void>();

export function currentUnits(): Units {
  return chosen;
}

export function setUnits(next: Units): void {
  chosen = next;
  keepChoice("units", next);
  for (const listener of listeners) listener();
}

export function onUnits(listener: () => void): void {
  listeners.add(listener);
}

export function unitOf(kind: Kind, units: Units = chosen): string {
  return OWN[units][kind];
}

/** A number without its unit, as a field shows it. */
export function numberText(kind: Kind, si: number, units: Units = chosen): string {
  return fixed(si / (FACTORS[kind][OWN[units][kind]] ?? 1), DIGITS[units][kind]);
}

/** A number with its unit. */
export function quantityText(kind: Kind, si: number, units: Units = chosen): string {
  const unit = unitOf(kind, units);
  return `${numberText(kind, si, units)}${unit === "°" ? "" : " "}${unit}`;
}

/**
 * What somebody has typed, in rad or m: "-70°", "−1,2 rad", "350 mm"; without a unit it has that of the field. Null
 * where it is no number.
 */
export function readQuantity(text: string, kind: Kind, units: Units = chosen): number | null {
  const match = /^([+-]?)\s*(\d+(?:\.\d*)?|\.\d+)(e[+-]?\d+)?\s*(.*)$/i.exec(
    text
      .normalize("NFKC")
      .trim()
      .replace(/^[−–—]/, "-")
      .replace(/^([+-]?\s*\d*),/, "$1."),
  );
  if (!match) return null;
  const [, sign = "", digits = "", exponent = "", unit = ""] = match;
  const factor = FACTORS[kind][unit === "" ? OWN[units][kind] : unit.toLowerCase()];
  const value = Number(`${sign}${digits}${exponent}`);
  return factor === undefined || !Number.isFinite(value) ? null : value * factor;
}
