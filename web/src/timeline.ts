// The time line: live is its right end; everything before can be gone to, played and plotted.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { choiceOf, keepChoice } from "./choices";
import { byId, fixed, make, setText } from "./dom";
import { type Frame, indexAt, readFrame, readFrames } from "./frame";
import { api } from "./link";
import type { Panel } from "./notices";
import type { Registers } from "./points";
import { Search } from "./search";
import { spread, wheeled, zoomed } from "./span";
import { onLanguage, t, type Word } from "./words";
import type { WorldMoment } from "./world";

interface Moment {
  time: number;
  frame: string | null;
  panel: Panel | null;
  registers: Registers | null;
  world?: WorldMoment | null;
}
export interface TimedEvent {
  event: string;
  time: number;
  [name: string]: unknown;
}

const PLOTS: { word: Word; unit: string; names: string[]; values: (frame: Frame) => number[] }[] = [
  { word: "plot_q", unit: "rad", names: ["J1", "J2", "J3", "J4", "J5", "J6"], values: (frame) => frame.actualQ },
  { word: "plot_qd", unit: "rad/s", names: ["J1", "J2", "J3", "J4", "J5", "J6"], values: (frame) => frame.actualQd },
  {
    word: "plot_torque",
    unit: "Nm",
    names: ["J1", "J2", "J3", "J4", "J5", "J6"],
    values: (frame) => frame.actualTorque,
  },
  { word: "plot_force", unit: "N, Nm", names: ["Fx", "Fy", "Fz", "Mx", "My", "Mz"], values: (frame) => frame.tcpForce },
];
const POINTS = 1200;
const LIVE_FRAMES = 1400;
/** So long a time is plotted from the frames that came, s. */
const RECENT_SECS = 10;
/** Events from this level on are marked and jumped to. */
const MARK_LEVEL = 3;
const MARKS = 500;
/** Times that differ by less are the same, s. */
const SAME_TIME = 1e-4;
/** The slider has steps of a millisecond, so its right end may lie a little before the end of the time. */
const SLIDER_STEP = 0.001;
/** A click so near to the right edge of the plot means the present, px. */
const EDGE_PX = 4;
/** Half of the widest time under the plot, so that the one at the right edge is not cut off, px. */
const LABEL_ROOM = 28;
/** Where events are marked, above the data, px. */
const MARK_ROOM = 12;
export class TimeLine {
  isLive = true;
  private first = 0;
  private last = 0;
  private at = 0;
  private recent: Frame[] = [];
  private past: Frame[] = [];
  private span: [number, number] = [0, 0];
  /** Alarms and changes of mode in the span that is plotted. */
  private marks: TimedEvent[] = [];
  /** What somebody has zoomed to, s; at the live end it goes along. */
  private zoom: [number, number] | null = null;
  private plotted = 0;
  private plot: uPlot | null = null;
  private isPlaying = false;
  private playedAt = 0;
  private drawnAt = 0;
  private asking = false;
  private askAgain = false;
  private isRecording = false;
  private readonly search = new Search();
  private readonly slider = byId<HTMLInputElement>("timeline");

  /** A moment of the past: its frame, with a jump or played on. */
  onFrame: (frame: Frame, jumped: boolean) => void = () => undefined;
  onMoment: (moment: Moment) => void = () => undefined;
  onLive: () => void = () => undefined;
  /** Other frames are plotted, or another moment of them is shown. */
  onSpan: (frames: readonly Frame[], at: number) => void = () => undefined;
  private spanShown = "";

  constructor() {
    const choice = byId("plot-choice");
    PLOTS.forEach((plot, k) => {
      const button = make(
        "button",
        {
          type: "button",
          class: "quiet",
          role: "radio",
          "aria-checked": String(k === 0),
          "data-t": plot.word,
          "data-testid": plot.word.replace("_", "-"),
        },
        t(plot.word),
      );
      button.addEventListener("click", () => this.choose(k));
      choice.append(button);
    });
    this.slider.addEventListener("input", () => this.slide());
    byId("plot-size").addEventListener("click", () => this.resizePlot(!document.body.classList.contains("large-plot")));
    this.resizePlot(choiceOf("large-plot") === "true");
    byId("live").addEventListener("click", () => this.goLive());
    byId("replay-play").addEventListener("click", () => this.playOrPause());
    byId("event-before").addEventListener("click", () => this.jump(-1));
    byId("event-after").addEventListener("click", () => this.jump(1));
    byId("window").addEventListener("change", () => this.zoomTo(null));
    this.search.onFound = () => {
      this.drawnAt = 0;
      const first = this.search.stretches?.[0];
      if (first) this.goTo(first.from);
    };
    onLanguage(() => this.build());
    new ResizeObserver(() => this.resize()).observe(byId("plot"));
    this.build();
    requestAnimationFrame(() => this.tick());
    setInterval(() => void this.refresh(), 1000);
  }

  /** A recording: there is no live end, so its beginning is shown. */
  async begin(isRecording: boolean): Promise<void> {
    this.isRecording = isRecording;
    byId("live").hidden = isRecording;
    if (isRecording) {
      this.isLive = true;
      byId<HTMLSelectElement>("window").value = "0";
    }
    this.zoom = null;
    this.recent = [];
    this.past = [];
    // Whatever there is is news, also if it was asked for before it was known to be a recording.
    this.last = -1;
    await this.refresh();
    if (!isRecording) await this.fetchRecent();
    // Somebody may have gone to a moment while the plot was fetched; otherwise it begins at the beginning.
    else if (this.isLive) this.goTo(this.first);
  }

  /** A live frame. */
  push(frame: Frame): void {
    if (this.isRecording) return;
    const latest = this.recent.at(-1);
    if (latest && frame.time < latest.time) {
      this.recent = [];
      this.first = frame.time;
      this.last = frame.time;
    }
    if (!latest || frame.time > latest.time) this.recent.push(frame);
    if (this.recent.length > LIVE_FRAMES) this.recent.splice(0, this.recent.length - LIVE_FRAMES);
    this.last = Math.max(this.last, frame.time);
    if (this.isLive) this.at = frame.time;
  }

  private async refresh(): Promise<void> {
    try {
      const answer = await fetch("/api/v1/history?points=1", { cache: "no-store" });
      this.first = Number(answer.headers.get("x-first-time"));
      const last = Number(answer.headers.get("x-last-time"));
      const hasGrown = last !== this.last;
      this.last = this.isRecording ? last : Math.max(last, this.recent.at(-1)?.time ?? 0);
      if (this.isRecording ? hasGrown || this.past.length === 0 : !this.isRecent()) await this.fetchSpan(false);
    } catch {
      // The connection says so itself.
    }
  }

  /** What was before the page was opened: a plot that begins in the middle looks as if nothing had been. */
  private async fetchRecent(): Promise<void> {
    try {
      const answer = await fetch(
        `/api/v1/history?from=${Math.max(this.first, this.last - RECENT_SECS)}&to=${this.last}&points=${POINTS}`,
        { cache: "no-store" },
      );
      if (!answer.ok) return;
      const before = readFrames(await answer.arrayBuffer());
      const since = this.recent[0]?.time ?? Infinity;
      this.recent.unshift(...before.filter((frame) => frame.time < since));
      this.drawnAt = 0;
    } catch {
      // The connection says so itself.
    }
  }

  private windowSecs(): number {
    return Number(byId<HTMLSelectElement>("window").value);
  }

  /** What the plot shows, s. */
  private wanted(): [number, number] {
    if (this.zoom) {
      const [from, to] = this.zoom;
      return this.isLive ? [this.last - (to - from), this.last] : [from, to];
    }
    const secs = this.windowSecs();
    if (secs === 0) return [this.first, this.last];
    if (this.isLive) return [Math.max(this.first, this.last - secs), this.last];
    const from = Math.min(Math.max(this.first, this.at - secs / 2), Math.max(this.first, this.last - secs));
    return [from, Math.min(this.last, from + secs)];
  }

  /** What the plot shows came while the page was open. */
  private isRecent(): boolean {
    const [from, to] = this.wanted();
    return this.isLive && to - from <= RECENT_SECS;
  }

  private zoomTo(span: [number, number] | null): void {
    this.zoom = span && zoomed(span, this.first, this.last);
    const select = byId<HTMLSelectElement>("window");
    if (this.zoom) select.value = "zoom";
    else if (select.value === "zoom") select.value = this.isRecording ? "0" : "10";
    this.drawnAt = 0;
    if (!this.isRecent()) void this.fetchSpan(true);
  }

  /** The wheel: nearer or farther around the time under the pointer; sideways, or with Shift, along the time. */
  private wheel(event: WheelEvent): void {
    const at = this.plot?.posToVal(event.offsetX, "x");
    if (at === undefined || !Number.isFinite(at)) return;
    event.preventDefault();
    const sideways = event.shiftKey && event.deltaX === 0 ? event.deltaY : event.deltaX;
    const lines = event.deltaMode === 1 ? 30 : 1;
    this.zoomTo(
      wheeled(this.wanted(), this.isLive ? this.last : at, sideways * lines, event.shiftKey ? 0 : event.deltaY * lines),
    );
  }

  private async fetchSpan(force: boolean): Promise<void> {
    if (this.asking) {
      this.askAgain ||= force;
      return;
    }
    const [from, to] = this.wanted();
    if (!force && this.span[0] === from && this.span[1] === to) return;
    this.asking = true;
    try {
      const answer = await fetch(`/api/v1/history?from=${from}&to=${to}&points=${POINTS}`, { cache: "no-store" });
      this.past = readFrames(await answer.arrayBuffer());
      this.span = [from, to];
      const marks = await api<TimedEvent[]>(`/api/v1/events?level=${MARK_LEVEL}&from=${from}&to=${to}&most=${MARKS}`);
      this.marks = marks.filter((one) => one.event !== "command");
      this.drawnAt = 0;
    } finally {
      this.asking = false;
      if (this.askAgain) {
        this.askAgain = false;
        void this.fetchSpan(true);
      }
    }
  }

  goLive(): void {
    if (this.isRecording) return;
    this.isLive = true;
    this.isPlaying = false;
    this.at = this.last;
    this.onLive();
    this.buttons();
  }

  /** The right end is the present, which has gone on since the slider was drawn. */
  private slide(): void {
    const time = Number(this.slider.value);
    if (!this.isRecording && time >= Number(this.slider.max) - 2 * SLIDER_STEP) return this.goLive();
    this.goTo(time);
  }

  private resizePlot(isLarge: boolean): void {
    keepChoice("large-plot", String(isLarge));
    document.body.classList.toggle("large-plot", isLarge);
    const button = byId("plot-size");
    const word: Word = isLarge ? "plot_smaller" : "plot_larger";
    button.setAttribute("aria-pressed", String(isLarge));
    button.dataset["label"] = word;
    button.setAttribute("aria-label", t(word));
    button.title = t(word);
  }

  /** A moment of the past. */
  goTo(time: number): void {
    if (!this.isRecording && time >= this.last - 1e-6 && !this.isPlaying) return this.goLive();
    this.isLive = false;
    this.seek(Math.min(Math.max(time, this.first), this.last), true);
    this.buttons();
  }

  private momentAsked = false;
  private momentAgain = false;

  private seek(time: number, jumped: boolean): void {
    this.at = time;
    const near =
      this.past.length > 0 && time >= this.span[0] && time <= this.span[1]
        ? this.past[indexAt(this.past, time)]
        : undefined;
    if (near) this.onFrame(near, jumped);
    void this.moment(jumped);
    const [from, to] = this.wanted();
    const isOutside =
      time < this.span[0] ||
      time > this.span[1] ||
      Math.abs(from - this.span[0]) + Math.abs(to - this.span[1]) > (to - from) * 0.5;
    if (isOutside) void this.fetchSpan(true);
  }

  /** Everything of the moment; while one is asked for, only the latest wish is kept. */
  private async moment(jumped: boolean): Promise<void> {
    if (this.momentAsked) {
      this.momentAgain = true;
      return;
    }
    this.momentAsked = true;
    try {
      const moment = await api<Moment>(`/api/v1/moment?time=${this.at}`);
      if (this.isLive) return;
      if (moment.frame) {
        const bytes = Uint8Array.from(atob(moment.frame), (letter) => letter.charCodeAt(0));
        const frame = readFrame(bytes.buffer);
        if (frame) this.onFrame(frame, jumped && !this.isPlaying);
      }
      this.onMoment(moment);
    } catch {
      // The connection says so itself.
    } finally {
      this.momentAsked = false;
      if (this.momentAgain) {
        this.momentAgain = false;
        if (!this.isLive) void this.moment(jumped);
      }
    }
  }

  private playOrPause(): void {
    this.isPlaying = !this.isPlaying;
    if (this.isPlaying) {
      if (this.isLive || this.at >= this.last - 1e-6) this.at = this.first;
      this.isLive = false;
      this.playedAt = performance.now();
    }
    this.buttons();
  }

  /** The next thing to jump to in a direction: where the condition begins to hold, and without one an event. */
  private async nextTime(direction: 1 | -1): Promise<number | undefined> {
    const times = this.search.stretches?.map((stretch) => stretch.from);
    if (times)
      return direction > 0
        ? times.find((time) => time > this.at + SAME_TIME)
        : times.findLast((time) => time < this.at - SAME_TIME);
    const where = direction > 0 ? `from=${this.at + SAME_TIME}&first=1` : `to=${this.at - SAME_TIME}`;
    const found = await api<TimedEvent[]>(`/api/v1/events?level=${MARK_LEVEL}&most=1&${where}`).catch(() => []);
    return found[0]?.time;
  }

  private jumps: Promise<void> = Promise.resolve();

  /** To the next of these in this direction, from where the jump before it led: clicks may come faster than answers. */
  private jump(direction: 1 | -1): void {
    const next = (): Promise<void> => this.jumpOnce(direction);
    this.jumps = this.jumps.then(next, next);
  }

  private async jumpOnce(direction: 1 | -1): Promise<void> {
    const next = await this.nextTime(direction);
    this.isPlaying = false;
    if (next !== undefined) this.goTo(next);
    else if (direction > 0) this.goLive();
    this.buttons();
  }

  private buttons(): void {
    byId("live").setAttribute("aria-pressed", String(this.isLive));
    document.body.classList.toggle("past", !this.isLive);
    const play = byId("replay-play");
    setText(play, this.isPlaying ? "❚❚" : "▶");
    const word: Word = this.isPlaying ? "replay_pause" : "replay_play";
    play.dataset["label"] = word;
    play.setAttribute("aria-label", t(word));
    play.title = t(word);
  }

  private tick(): void {
    requestAnimationFrame(() => this.tick());
    const now = performance.now();
    if (this.isPlaying) {
      const rate = Number(byId<HTMLSelectElement>("rate").value);
      const next = this.at + ((now - this.playedAt) / 1000) * rate;
      this.playedAt = now;
      if (next >= this.last) {
        this.isPlaying = false;
        this.seek(this.last, false);
        this.buttons();
      } else this.seek(next, false);
    }
    if (now - this.drawnAt < 100 || document.visibilityState === "hidden") return;
    this.drawnAt = now;
    this.slider.min = String(this.first);
    this.slider.max = String(this.last);
    if (document.activeElement !== this.slider || this.isLive || this.isPlaying) this.slider.value = String(this.at);
    this.slider.setAttribute("aria-valuetext", `${fixed(this.at, 2)} s`);
    setText(byId("time"), fixed(this.at, 3));
    this.draw();
  }

  private choose(k: number): void {
    this.plotted = k;
    [...byId("plot-choice").children].forEach((button, n) => button.setAttribute("aria-checked", String(n === k)));
    this.build();
  }

  private build(): void {
    const host = byId("plot");
    const plot = PLOTS[this.plotted];
    if (!plot) return;
    this.plot?.destroy();
    const legend = plot.names.map((name, k) => make("span", { class: `series s${k}` }, name));
    byId("plot-legend").replaceChildren(...legend);
    const style = getComputedStyle(document.documentElement);
    const line = style.getPropertyValue("--line").trim() || "#888";
    const ink = style.getPropertyValue("--ink2").trim() || "#888";
    const alarm = style.getPropertyValue("--bad").trim() || "#d33";
    const axis = {
      stroke: ink,
      grid: { stroke: line, width: 1 },
      ticks: { stroke: line, width: 1 },
      font: "12px system-ui",
    };
    this.plot = new uPlot(
      {
        width: Math.max(host.clientWidth, 200),
        height: Math.max(host.clientHeight, 80),
        scales: { x: { time: false }, y: { range: (_: uPlot, min: number, max: number) => spread(min, max) } },
        legend: { show: false },
        padding: [MARK_ROOM, LABEL_ROOM, 0, 0],
        cursor: { drag: { x: true, y: false, setScale: false, dist: 6 }, points: { show: false } },
        axes: [
          { ...axis, size: 24, values: (_: uPlot, values: number[]) => values.map((value) => `${value} s`) },
          { ...axis, size: 46, space: 17, label: plot.unit, labelSize: 14, labelFont: "12px system-ui" },
        ],
        series: [
          {},
          ...plot.names.map((label, k) => ({
            label,
            stroke: getComputedStyle(legend[k] ?? host).color,
            width: 1.5,
            points: { show: false },
          })),
        ],
        hooks: {
          drawClear: [(self: uPlot) => this.drawFound(self, ink)],
          draw: [(self: uPlot) => (this.drawMarks(self, ink, alarm), this.drawCursor(self, ink))],
          setSelect: [(self: uPlot) => this.selected(self)],
        },
      },
      [[], ...plot.names.map(() => [])] as unknown as uPlot.AlignedData,
      host,
    );
    const over = this.plot.over;
    over.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    over.addEventListener("dblclick", () => this.zoomTo(null));
    over.addEventListener("click", (event) => {
      if (performance.now() - this.selectedAt < 200) return;
      const time = this.plot?.posToVal(event.offsetX, "x");
      const isEdge = event.offsetX >= over.clientWidth - EDGE_PX && Math.abs(this.wanted()[1] - this.last) < 0.2;
      if (isEdge && !this.isRecording) this.goLive();
      else if (time !== undefined && Number.isFinite(time)) this.goTo(time);
    });
    this.drawnAt = 0;
  }

  private selectedAt = 0;

  /** A box was drawn: its time is zoomed to. */
  private selected(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < 6) return;
    const span: [number, number] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.selectedAt = performance.now();
    if (this.isLive) this.goTo(span[1]);
    this.zoomTo(span);
  }

  /** Alarms and changes of mode, above the data. */
  private drawMarks(plot: uPlot, ink: string, alarm: string): void {
    const { ctx, bbox } = plot;
    const size = 4 * devicePixelRatio;
    ctx.save();
    for (const mark of this.marks) {
      const x = plot.valToPos(mark.time, "x", true);
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      ctx.fillStyle = mark.event === "alarm" || Number(mark["level"]) >= 4 ? alarm : ink;
      ctx.beginPath();
      const bottom = bbox.top - devicePixelRatio;
      ctx.moveTo(x - size, bottom - 1.6 * size);
      ctx.lineTo(x + size, bottom - 1.6 * size);
      ctx.lineTo(x, bottom);
      ctx.fill();
    }
    ctx.restore();
  }

  /** Where the condition holds. */
  private drawFound(plot: uPlot, ink: string): void {
    const stretches = this.search.stretches;
    if (!stretches) return;
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.fillStyle = ink;
    ctx.globalAlpha = 0.25;
    for (const { from, to } of stretches) {
      const left = Math.max(plot.valToPos(from, "x", true), bbox.left);
      const right = Math.min(plot.valToPos(to, "x", true), bbox.left + bbox.width);
      if (right >= left) ctx.fillRect(left, bbox.top, Math.max(right - left, 1), bbox.height);
    }
    ctx.restore();
  }

  private drawCursor(plot: uPlot, ink: string): void {
    const x = plot.valToPos(this.at, "x", true);
    const { ctx, bbox } = plot;
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.save();
    ctx.strokeStyle = ink;
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  private resize(): void {
    const host = byId("plot");
    if (host.clientWidth > 0) this.plot?.setSize({ width: host.clientWidth, height: Math.max(host.clientHeight, 80) });
  }

  private draw(): void {
    const plot = PLOTS[this.plotted];
    if (!plot || !this.plot) return;
    // A longer span is asked for once a second: until it comes for the first time, what came while the page was open is
    // shown.
    const isRecent = this.isRecent() || (this.isLive && !this.zoom && this.past.length === 0);
    let frames = isRecent ? this.recent : this.past;
    const [from, to] = isRecent || this.zoom ? this.wanted() : this.span;
    if (isRecent) frames = frames.slice(indexAt(frames, from));
    this.tellSpan(frames);
    const data: number[][] = [
      frames.map((frame) => frame.time),
      ...plot.names.map((_, k) => frames.map((frame) => plot.values(frame)[k] ?? 0)),
    ];
    this.plot.setData(data as unknown as uPlot.AlignedData, true);
    if (to > from) this.plot.setScale("x", { min: from, max: to });
  }

  /** Tells which frames are plotted, with those that have come since a longer span was asked for. */
  private tellSpan(frames: readonly Frame[]): void {
    const end = frames.at(-1)?.time ?? -Infinity;
    const since = this.isLive ? this.recent.slice(this.recent.findLastIndex((frame) => frame.time <= end) + 1) : [];
    const key = [
      frames.length + since.length,
      frames[0]?.time,
      since.at(-1)?.time ?? end,
      this.isLive ? "" : this.at,
    ].join();
    if (key === this.spanShown) return;
    this.spanShown = key;
    this.onSpan([...frames, ...since], this.isLive ? Infinity : this.at);
  }

  /** Colours have changed. */
  rebuild(): void {
    this.build();
  }
}
