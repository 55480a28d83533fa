// Which time a plot shows: within what there is, and as the wheel turns. Pure.

/** The least that the plot shows, s: some cycles. */
const ZOOM_MIN = 0.02;

/** The range of values that is plotted: what there is with some room, and never so little that noise looks large. */
export function spread(min: number | null, max: number | null): [number, number] {
  const [low, high] = [min ?? 0, max ?? 0];
  const room = Math.max((high - low) * 0.1, 0.05);
  return [low - room, high + room];
}

/** A span within what there is, and not too short. */
export function zoomed([from, to]: [number, number], first: number, last: number): [number, number] {
  const length = Math.min(Math.max(to - from, ZOOM_MIN), Math.max(last - first, ZOOM_MIN));
  const begin = Math.min(Math.max(from, first), Math.max(first, last - length));
  return [begin, begin + length];
}

/** A span after the wheel has turned: `zoom` scales it about `at`, `along` moves it, both as the browser tells them. */
export function wheeled([from, to]: [number, number], at: number, along: number, zoom: number): [number, number] {
  const scale = Math.exp(Math.max(-2, Math.min(2, zoom * 0.0015)));
  const shift = (to - from) * Math.max(-1, Math.min(1, along * 0.001));
  return [at + (from - at) * scale + shift, at + (to - at) * scale + shift];
}
