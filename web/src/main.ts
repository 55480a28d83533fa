// The page: brings the parts together and shows the state at a glance.

import "./app.css";
import { choiceOf, keepChoice } from "./choices";
import { CellPanel } from "./cell";
import { type Channel, Debugger } from "./debugger";
import { DebugPanel } from "./debugpanel";
import { ask, byId, fixed, make, setText, toast } from "./dom";
import type { Frame } from "./frame";
import { Jog } from "./jog";
import { forward } from "./kinematics";
import { api, Link, type ServerEvent } from "./link";
import { fetchMesh, MeshFault, meshUsers } from "./mesh";
import { Notices, type Panel, setChip } from "./notices";
import { Paths } from "./paths";
import { Points, type Registers } from "./points";
import { Programs, type RunningProgram } from "./program";
import { TimeLine } from "./timeline";
import { currentUnits, numberText, onUnits, unitOf } from "./units";
import type { MissingMesh, SceneData, View } from "./view";
import { Waypoints } from "./waypoints";
import type { WorldMoment } from "./world";
import { currentLanguage, isWord, onLanguage, setLanguage, t, translate, type Language, type Word } from "./words";

// prettier-ignore
const ROBOT: Record<number, string> = {
  [-1]: "NO_CONTROLLER", 0: "DISCONNECTED", 1: "CONFIRM_SAFETY", 2: "BOOTING", 3: "POWER_OFF", 4: "POWER_ON", 5: "IDLE",
  6: "BACKDRIVE", 7: "RUNNING", 8: "UPDATING_FIRMWARE", 9: "WAITING_CALIBRATION",
};
// prettier-ignore
const SAFETY: Record<number, string> = {
  1: "NORMAL", 2: "REDUCED", 3: "PROTECTIVE_STOP", 4: "RECOVERY", 5: "SAFEGUARD_STOP", 6: "SYSTEM_EMERGENCY_STOP",
  7: "ROBOT_EMERGENCY_STOP", 8: "VIOLATION", 9: "FAULT", 10: "VALIDATE_JOINT_ID", 11: "UNDEFINED",
};
// prettier-ignore
const MOTION: Record<number, Word> = {
  0: "m_idle", 1: "m_movej", 2: "m_movel", 3: "m_stopping", 4: "m_paused", 5: "m_protective", 6: "m_off", 7: "m_movec",
  8: "m_moveml", 9: "m_movep", 20: "m_servoj", 21: "m_speedj", 22: "m_speedl", 23: "m_freedrive", 24: "m_conveyor",
  25: "m_force",
};
/** Safety modes in which the arm may move. */
const SAFE = new Set(["NORMAL", "REDUCED"]);
const TASK: Word[] = ["stopped", "running", "paused"];

const link = new Link();
let view: View | null = null;
let scene: SceneData | null = null;
/** The 3D view comes behind the rest, which says at a glance what there is to know. */
async function openView(): Promise<void> {
  try {
    const file = "/view.js";
    const { View: Drawn } = (await import(file)) as typeof import("./view");
    view = new Drawn(byId("view"), fetchMesh);
    view.onMissing = (meshes) => {
      missing = meshes;
      showMissing();
    };
    view.setTheme(theme());
    view.hands = {
      describe: ({ name }) => {
        const gripper = scene?.world?.grippers[world?.parts.find((part) => part.name === name)?.held_by ?? -1];
        return gripper ? t("held_by", { part: name, gripper: gripper.name }) : name;
      },
      pick: (part) => cell.choose(part),
      movable: () => (cell.canPlace ? cell.selected : null),
      drag: (x, y) => cell.drag(x, y),
    };
    view.showWorld(world);
    if (scene) view.setScene(scene);
    if (shown) view.show(shown, true);
    paths.setView(view);
  } catch {
    byId("no-webgl").hidden = false;
  }
}
/** Meshes that could not be fetched. */
let missing: readonly MissingMesh[] = [];
/** Says which things are there and not drawn, and why. */
function showMissing(): void {
  const box = byId("mesh-missing");
  const lines = missing.map(({ number, reason }) => {
    const names = scene ? meshUsers(scene, number, t("part_tool")) : [];
    return t("mesh_missing", {
      names: names.join(", "),
      reason: reason instanceof MeshFault ? t(reason.word, reason.values) : String(reason),
    });
  });
  box.hidden = lines.length === 0;
  box.replaceChildren(...lines.map((line) => make("p", {}, line)));
}
onLanguage(showMissing);
const programs = new Programs(link);
const paths = new Paths(link, programs);
const jog = new Jog(
  link,
  (q) => {
    view?.setGhost(q);
    byId("view").dataset["ghost"] = String(q !== null);
  },
  (q) => programs.teach(q),
);
const points = new Points(link);
const cell = new CellPanel(link, (part, pose) => view?.setPartGhost(part, pose));
const timeline = new TimeLine();
const names = new Map<number, RunningProgram>();
const notices = new Notices(
  link,
  (number, line) => void goToPlace(number, line),
  (number) => names.get(number) ?? null,
  () => programs.markAlarms(notices.places),
);
programs.onText = () => {
  programs.markAlarms(notices.places);
  paths.textChanged();
  enable();
};
const waypoints = new Waypoints({
  position: () => shown?.actualQ ?? null,
  go: (q) => void jog.propose(q),
  insert: (point) => programs.teach(point.q, point.name),
});

const debug = new Debugger(
  () => new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/v1/debug`) as Channel,
);
const debugPanel = new DebugPanel(debug);

/** Whether this server has a debugger. A recording has none. */
let hasDebugger = false;
async function findDebugger(): Promise<void> {
  const answer = link.readOnly === null ? await fetch("/api/v1/debug", { cache: "no-store" }).catch(() => null) : null;
  hasDebugger = answer?.ok ?? false;
  document.body.classList.toggle("has-debugger", hasDebugger);
  wantDebugger();
}

/** With breakpoints and control the debugger is attached; without either it leaves. */
function wantDebugger(): void {
  const { breakpoints } = programs;
  const isWanted = hasDebugger && link.hasControl && link.token !== null && breakpoints.length > 0;
  if (!isWanted) {
    if (debug.isAttached) debug.detach();
    return;
  }
  const fail = (error: Error): void => toast(error.message, "error");
  void debug.setBreakpoints(programs.name, breakpoints).catch(fail);
  if (!debug.isAttached && link.token !== null) void debug.attach(link.token).catch(fail);
}
let breakpointsTimer: ReturnType<typeof setTimeout> | null = null;
programs.onBreakpoints = () => {
  // Lines that are typed move breakpoints with every key.
  if (breakpointsTimer !== null) clearTimeout(breakpointsTimer);
  breakpointsTimer = setTimeout(wantDebugger, 100);
};
debug.onPlaced = (placed) => programs.showPlaced(placed);
debug.onError = (reason) => toast(reason, "error");
debug.onChange = () => {
  document.body.classList.toggle("held", debug.held !== null);
  debugPanel.refresh();
  enable();
};
debugPanel.onLine = (line) => programs.showHeld(line);

let latest: Frame | null = null;
let shown: Frame | null = null;
let livePanel: Panel | null = null;
/** What the arm is told to carry, at the moment that is shown. */
let load: Panel["payload"];
let liveRegisters: Registers | null = null;
/** The world of the cell now, and at the moment that is shown. */
let liveWorld: WorldMoment | null = null;
let world: WorldMoment | null = null;
let framesSeen = 0;

async function goToPlace(number: number, line: number): Promise<void> {
  await programs.showLine(await programOf(number), line);
}

async function programOf(number: number): Promise<RunningProgram | null> {
  if (number === 0) return null;
  const known = names.get(number);
  if (known) return known;
  const program = await api<RunningProgram | null>(`/api/v1/program?number=${number}`).catch(() => null);
  if (program) {
    names.set(number, program);
    if (names.size > 20) names.delete([...names.keys()][0] ?? -1);
  }
  return program;
}

let programShown = -1;
async function showProgram(number: number): Promise<void> {
  if (number === programShown) return;
  programShown = number;
  const program = await programOf(number);
  if (programShown !== number) return;
  programs.setProgram(program);
  // It has its number before it runs, and its text when it does.
  if (!program && number !== 0) setTimeout(() => programShown === number && (programShown = -1), 250);
}

function label(prefix: "r_" | "s_", name: string): string {
  const word = prefix + name;
  return isWord(word) ? t(word) : name;
}

/** Shows a moment, live or past. */
function show(frame: Frame, jumped: boolean): void {
  shown = frame;
  view?.show(frame, jumped);
  jog.show(frame);
  points.show(frame);
  if (timeline.isLive) world = liveWorld;
  showWorld(world);
  programs.setPlace(frame.line, frame.node);
  void showProgram(frame.program);
  const robot = ROBOT[frame.robotMode] ?? String(frame.robotMode);
  const safety = SAFETY[frame.safetyMode] ?? String(frame.safetyMode);
  const task = TASK[frame.task] ?? "stopped";
  const isSafe = SAFE.has(safety);
  setChip(
    "chip-robot",
    label("r_", robot),
    robot === "RUNNING" && isSafe
      ? "good"
      : robot === "RUNNING" || robot === "IDLE" || robot === "POWER_ON"
        ? "warn"
        : "bad",
    robot,
  );
  setChip(
    "chip-safety",
    label("s_", safety),
    safety === "NORMAL" ? "good" : safety === "REDUCED" ? "warn" : "bad",
    safety,
  );
  setChip("chip-program", t(task), task === "running" && isSafe ? "good" : task === "stopped" ? "" : "warn", task);
  showFacts(frame);
}

/** The parts of the cell; those that a gripper holds are where the arm is shown. */
function showWorld(moment: WorldMoment | null): void {
  world = moment;
  view?.showWorld(moment);
  const flange = scene?.world && shown ? forward(scene.joints, scene.flange, shown.actualQ, [])[7] : null;
  if (flange) cell.show(moment, flange);
}

/** What can be read beside the arm, in the units that are chosen. */
function showFacts(frame: Frame): void {
  const three = (values: readonly number[]): string =>
    values
      .slice(0, 3)
      .map((value) => numberText("length", value))
      .join("  ");
  const place = (pose: readonly number[]): string => `${three(pose)} ${unitOf("length")}`;
  const tcp = frame.tcpOffset.slice(3).some((angle) => Math.abs(angle) > 1e-6)
    ? `${place(frame.tcpOffset)}  ${frame.tcpOffset
        .slice(3)
        .map((angle) => numberText("angle", angle))
        .join("  ")} ${unitOf("angle")}`
    : place(frame.tcpOffset);
  const speed = Math.hypot(frame.tcpSpeed[0] ?? 0, frame.tcpSpeed[1] ?? 0, frame.tcpSpeed[2] ?? 0);
  const force = Math.hypot(frame.tcpForce[0] ?? 0, frame.tcpForce[1] ?? 0, frame.tcpForce[2] ?? 0);
  const motion = t(MOTION[frame.motionMode] ?? "m_unknown");
  const speedText = currentUnits() === "si" ? `${fixed(speed, 3)} m/s` : `${fixed(speed * 1000, 0)} mm/s`;
  const payload = load
    ? `${fixed(load.mass, 2)} kg${load.cog.some((x) => x !== 0) ? ` (${place(load.cog)})` : ""}`
    : "–";
  facts([
    [t("doing"), motion],
    ["X Y Z", place(frame.actualPose)],
    [t("target"), place(frame.targetPose)],
    [t("tcp_speed"), speedText],
    [t("force"), `${fixed(force, 1)} N`],
    ["TCP", tcp],
    [t("payload"), payload],
  ]);
}
onUnits(() => shown && showFacts(shown));

const factCells: [HTMLElement, HTMLElement][] = [];
function facts(rows: [string, string][]): void {
  rows.forEach(([name, value], k) => {
    let cell = factCells[k];
    if (!cell) {
      cell = [make("span"), make("b")];
      factCells.push(cell);
      byId("facts").append(make("div", {}, ...cell));
    }
    setText(cell[0], name);
    setText(cell[1], value);
  });
}

const slider = document.querySelector<HTMLInputElement>("[data-testid=speed]") as HTMLInputElement;
let slidAt = 0;
function showSpeed(fraction: number): void {
  if (performance.now() - slidAt < 600) return;
  const text = String(Math.round(fraction * 100));
  if (slider.value !== text) slider.value = text;
  setText(byId("speed-text"), `${text} %`);
}
slider.addEventListener("input", () => {
  slidAt = performance.now();
  setText(byId("speed-text"), `${slider.value} %`);
  order({ do: "speed", fraction: Number(slider.value) / 100 });
});

function order(what: Record<string, unknown>): void {
  link.order(what).catch((error: Error) => toast(error.message, "error"));
}

function enable(): void {
  const isConnected = link.state === "connected";
  const may = link.hasControl && timeline.isLive;
  const frame = latest;
  const robot = frame ? ROBOT[frame.robotMode] : "";
  const safety = frame ? SAFETY[frame.safetyMode] : "";
  const set = (testid: string, on: boolean): void => {
    const button = document.querySelector<HTMLButtonElement>(`[data-testid=${testid}]`);
    if (button && button.disabled === on) button.disabled = !on;
  };
  const isPaused = frame?.task === 2 || debug.held !== null;
  const isStopped = frame?.task === 0;
  const isReady = robot === "RUNNING" && SAFE.has(safety ?? "");
  const mayEdit = link.readOnly === null;
  set("power-on", may && (robot === "POWER_OFF" || safety === "FAULT"));
  set("power-off", may && robot !== "POWER_OFF");
  set("brake-release", may && robot === "IDLE" && safety !== "PROTECTIVE_STOP");
  set("unlock", may && safety === "PROTECTIVE_STOP");
  notices.enableUnlock(may && safety === "PROTECTIVE_STOP");
  const mayStart = may && isReady && (isPaused || !programs.isEmpty);
  set("run", mayStart);
  set("step", mayStart && (isPaused || isStopped));
  const run = byId("run");
  run.classList.toggle("primary", mayStart && (isPaused || isStopped));
  const runWord = byId("run-word");
  runWord.dataset["t"] = isPaused ? "debug_continue" : "run";
  setText(runWord, t(isPaused ? "debug_continue" : "run"));
  set("pause", isConnected && link.readOnly === null && frame?.task === 1);
  // Never taken away while there is somebody to hear it.
  set("stop", isConnected && link.readOnly === null);
  set("dialog-stop", isConnected && link.readOnly === null);
  if (slider.disabled === may) slider.disabled = !may;
  // Out of a place where it must not be the arm is led by hand.
  const mayJog = isReady || (robot === "RUNNING" && safety === "RECOVERY");
  jog.enable(may && isStopped, may && isStopped && mayJog, may && isStopped && isReady);
  set("approach", may && isStopped && isReady && !programs.isEmpty);
  waypoints.enable(may && isStopped && isReady, mayEdit);
  points.enable(may);
  cell.enable(may && isStopped);
  programs.enable(mayEdit, isConnected && mayEdit);
  showFirstStep(robot ?? "", safety ?? "");
}

/** What leads to an arm that moves, one step after the other: control, power, brakes. */
function showFirstStep(robot: string, safety: string): void {
  const steps: { word: Word; done: boolean; button: string }[] = [
    { word: "take_control", done: link.hasControl, button: "take-control" },
    { word: "power_on", done: robot !== "POWER_OFF", button: "power-on" },
    { word: "brake_release", done: robot === "RUNNING" || robot === "BACKDRIVE", button: "brake-release" },
  ];
  const now = steps.find((step) => !step.done);
  const isOthers = link.control !== null && !link.hasControl;
  const box = byId("first-step");
  box.hidden =
    !now ||
    isOthers ||
    !latest ||
    link.state !== "connected" ||
    link.readOnly !== null ||
    !timeline.isLive ||
    !SAFE.has(safety);
  if (box.hidden || !now) return;
  const key = `${steps.map((step) => Number(step.done)).join("")}${t(now.word)}`;
  const go = byId<HTMLButtonElement>("first-step-go");
  go.disabled = document.querySelector<HTMLButtonElement>(`[data-testid=${now.button}]`)?.disabled ?? true;
  if (box.dataset["key"] === key) return;
  box.dataset["key"] = key;
  box
    .querySelector("ol")
    ?.replaceChildren(
      ...steps.map((step) =>
        make(
          "li",
          { class: step.done ? "done" : step === now ? "now" : null, "aria-current": step === now ? "step" : null },
          t(step.word),
        ),
      ),
    );
  setText(go, t(now.word));
  go.dataset["button"] = now.button;
}
byId("first-step-go").addEventListener("click", () => {
  document
    .querySelector<HTMLButtonElement>(`[data-testid=${byId("first-step-go").dataset["button"] ?? "take-control"}]`)
    ?.click();
});

byId("home").addEventListener("click", () => {
  if (scene?.home) void jog.propose(scene.home);
});
byId("approach").addEventListener("click", () => {
  const start = programs.start;
  if (start === null) toast(t("no_start"), "error");
  else if ("joints" in start) void jog.propose(start.joints);
  else void jog.proposePose(start.pose);
});

function showControl(): void {
  const button = byId<HTMLButtonElement>("control");
  button.disabled = link.state !== "connected" || link.readOnly !== null;
  button.setAttribute("aria-pressed", String(link.hasControl));
  button.classList.toggle("primary", !link.hasControl && !button.disabled);
  const text = link.readOnly !== null ? t("read_only") : link.hasControl ? t("give_up") : t("take_control");
  setText(button, text);
  button.title =
    link.control === null ? t("nobody_has") : link.hasControl ? t("give_up") : t("other_has", { n: link.control });
  notices.refresh();
}

function showLink(): void {
  const word: Word = link.state;
  setChip(
    "chip-connection",
    t(word),
    link.state === "connected" ? "good" : link.state === "connecting" ? "warn" : "bad",
    link.state,
  );
  document.body.classList.toggle("offline", link.state !== "connected");
  showControl();
  enable();
  wantDebugger();
}

let hadConnection = false;
link.onChange = () => {
  if (link.state === "disconnected" && hadConnection) {
    hadConnection = false;
    toast(t("lost"), "error");
  }
  showLink();
};
link.onFrame = (frame) => {
  const before = latest;
  latest = frame;
  takeFrame(frame);
  framesSeen += 1;
  if (framesSeen === 1) performance.mark("first-frame");
  timeline.push(frame);
  if (link.readOnly === null) paths.take(frame);
  if (before && frame.program !== before.program)
    notices.clearAlarms((event) => event["kind"] === "script" && Number(event["program"]) < frame.program);
  if (before && SAFETY[before.safetyMode] === "PROTECTIVE_STOP" && SAFETY[frame.safetyMode] !== "PROTECTIVE_STOP")
    notices.clearAlarms((event) => Number(event["code"]) === 100);
  if (before && (before.safetyMode === 6 || before.safetyMode === 7) && frame.safetyMode === 1)
    notices.clearAlarms((event) => Number(event["code"]) === 101);
  if (timeline.isLive && link.readOnly === null) {
    pending = frame;
    showSpeed(frame.speedFraction);
  }
  enable();
};

/** Frames come faster than some screens are drawn: only the latest is shown. */
let pending: Frame | null = null;
function paint(): void {
  requestAnimationFrame(paint);
  if (!pending) return;
  const frame = pending;
  pending = null;
  // Somebody may have gone back in time since it came.
  if (timeline.isLive) show(frame, false);
}
requestAnimationFrame(paint);

link.onEvent = (event: ServerEvent) => {
  if (event.event === "welcome") void welcome();
  else if (event.event === "panel") {
    livePanel = event["panel"] as Panel | null;
    if (livePanel && timeline.isLive) showPanel(livePanel);
  } else if (event.event === "registers") {
    liveRegisters = event["registers"] as Registers | null;
    if (timeline.isLive) points.showRegisters(liveRegisters);
  } else if (event.event === "world") {
    liveWorld = event["world"] as WorldMoment | null;
    if (timeline.isLive && link.readOnly === null) showWorld(liveWorld);
  } else if (event.event === "alarm") {
    void programOf(Number(event["program"])).then(() => notices.take(event));
  } else if (event.event === "debug") debugElsewhere(event["debug"] as DebugNews | null);
  else notices.take(event);
};

function showPanel(panel: Panel): void {
  load = panel.payload;
  notices.showPanel(panel);
}

interface DebugNews {
  driver: boolean;
  watched: boolean;
  held: { reason: string; line: number } | null;
}
/** What another one debugs is seen here as well; and that a program runs which has no places to be held at. */
function debugElsewhere(news: DebugNews | null): void {
  if (!debug.isAttached) programs.showHeld(news?.held?.line ?? 0);
  const isDeaf = debug.isAttached && news !== null && !news.watched && latest?.task !== 0;
  byId("debug-unwatched").hidden = !isDeaf;
  const other = byId("debug-elsewhere");
  other.hidden = debug.isAttached || !news?.held;
  setText(other, news?.held ? t("held_elsewhere", { line: news.held.line }) : "");
}

/** Takes the next frame that comes. */
let takeFrame: (frame: Frame) => void = () => undefined;

async function welcome(): Promise<void> {
  hadConnection = true;
  const firstFrame = new Promise<Frame>((take) => {
    takeFrame = take;
  });
  names.clear();
  programShown = -1;
  programs.setReadOnly(link.readOnly !== null);
  document.body.classList.toggle("read-only", link.readOnly !== null);
  try {
    const [about, data] = await Promise.all([
      api<{ robot: string; replay?: string }>("/api/v1"),
      api<SceneData>("/api/v1/scene"),
    ]);
    scene = data;
    void findDebugger();
    setText(
      byId("robot-name"),
      about.replay ? `${about.robot} · ${about.replay.split(/[\\/]/).pop() ?? ""}` : about.robot,
    );
    byId("robot-name").title = about.replay ?? "";
    document.title = `${about.robot} – eliteserver`;
    view?.setScene(scene);
    jog.setLimits(data.position_min, data.position_max);
    points.setWords(data);
    cell.setScene(data.world ?? null);
    paths.begin();
    await timeline.begin(link.readOnly !== null);
    notices.clearLog();
    const events = await api<ServerEvent[]>("/api/v1/events");
    for (const event of events) if (event.event === "log") notices.take(event);
    await showStop(events, firstFrame);
  } catch (error) {
    toast((error as Error).message, "error");
  }
}

/** Whoever opens the page during a stop is told why, as if it had been open. */
async function showStop(events: readonly ServerEvent[], firstFrame: Promise<Frame>): Promise<void> {
  if (link.readOnly !== null) return;
  // On a busy machine the log is here before the first frame.
  const { safetyMode } = await firstFrame;
  if (SAFE.has(SAFETY[safetyMode] ?? "")) return;
  const alarm = events.findLast((event) => event.event === "alarm" && event["kind"] === "robot");
  if (!alarm || notices.knows(alarm)) return;
  await programOf(Number(alarm["program"]));
  notices.take(alarm);
}

timeline.onFrame = (frame, jumped) => {
  show(frame, jumped);
  enable();
};
timeline.onMoment = (moment) => {
  if (moment.panel) showPanel({ ...moment.panel, popups: link.readOnly === null ? (livePanel?.popups ?? []) : [] });
  points.showRegisters(moment.registers);
  showWorld(moment.world ?? null);
};
timeline.onSpan = (frames, at) => paths.showSpan(frames, at);
timeline.onLive = () => {
  if (latest) show(latest, true);
  if (livePanel) showPanel(livePanel);
  points.showRegisters(liveRegisters);
  enable();
};

link.onTokenAsked = async () => {
  const input = make("input", {
    type: "password",
    "data-testid": "token",
    "aria-label": t("token"),
    autocomplete: "off",
  });
  input.addEventListener("keydown", (event) => {
    if (event.key === "Enter") {
      event.preventDefault();
      byId<HTMLDialogElement>("dialog").close("ok");
    }
  });
  const answer = await ask(
    [make("p", {}, t("token_asked")), input],
    [
      { text: t("cancel"), value: "" },
      { text: t("ok"), value: "ok", primary: true },
    ],
    t("token"),
  );
  return answer === "ok" ? input.value.trim() : null;
};

byId("control").addEventListener("click", () => {
  link.takeControl(!link.hasControl).catch((error: Error) => toast(error.message, "error"));
});
for (const button of document.querySelectorAll<HTMLButtonElement>("[data-order]")) {
  button.addEventListener("click", async () => {
    const name = button.dataset["order"] ?? "";
    if (name === "power_off" && !(await endsProgram("power_off_ends", "power_off"))) return;
    const isFault = name === "power_on" && latest && SAFETY[latest.safetyMode] === "FAULT";
    order({ do: isFault ? "restart_safety" : name });
  });
}
/** Whether a program may be ended that is under way; nothing is asked while none is. */
async function endsProgram(question: Word, answer: Word): Promise<boolean> {
  if (!latest || latest.task === 0) return true;
  return (
    (await ask(
      [make("p", {}, t(question))],
      [
        { text: t("cancel"), value: "" },
        { text: t(answer), value: "ok", primary: true },
      ],
      t(question),
    )) === "ok"
  );
}
const led = (what: Promise<void>): void => void what.catch((error: Error) => toast(error.message, "error"));
byId("run").addEventListener("click", () => {
  if (debug.held) led(debug.resume());
  else if (latest?.task === 2) order({ do: "play" });
  else void run(false);
});
byId("step").addEventListener("click", () => {
  if (debug.held) led(debug.step("next"));
  else if (latest?.task === 2) order({ do: "step" });
  else void run(true);
});

/** Runs what is in the editor, with its breakpoints. */
async function run(step: boolean): Promise<void> {
  if (!(await endsProgram("run_ends", "run"))) return;
  if (breakpointsTimer !== null) clearTimeout(breakpointsTimer);
  wantDebugger();
  await debug.settled();
  await programs.run(step);
}
byId("pause").addEventListener("click", () => order({ do: "pause" }));
for (const id of ["stop", "dialog-stop"]) byId(id).addEventListener("click", () => order({ do: "stop" }));
byId("reset-view").addEventListener("click", () => view?.resetCamera());

/** Shift+Escape stops from anywhere, also while a text is edited. */
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && event.shiftKey) {
    event.preventDefault();
    order({ do: "stop" });
  }
});

type Theme = "dark" | "light";
const system = matchMedia("(prefers-color-scheme: light)");
function theme(): Theme {
  const chosen = choiceOf("theme");
  return chosen === "dark" || chosen === "light" ? chosen : system.matches ? "light" : "dark";
}
function applyTheme(): void {
  document.documentElement.dataset["theme"] = theme();
  view?.setTheme(theme());
  timeline.rebuild();
}
byId("theme").addEventListener("click", () => {
  keepChoice("theme", theme() === "dark" ? "light" : "dark");
  applyTheme();
});
system.addEventListener("change", applyTheme);

byId("language").addEventListener("click", () => {
  const next: Language = currentLanguage() === "en" ? "zh" : "en";
  keepChoice("language", next);
  setLanguage(next);
});
onLanguage(() => {
  showLink();
  if (shown) show(shown, false);
});

for (const anchor of byId("tabs").querySelectorAll<HTMLAnchorElement>("a")) {
  anchor.addEventListener("click", (event) => {
    event.preventDefault();
    const section = byId(anchor.hash.slice(1));
    keepPlace();
    section.scrollIntoView({ block: "start" });
    markTab();
    section
      .querySelector<HTMLElement>("button:not([disabled]), input:not([disabled]), [tabindex]")
      ?.focus({ preventScroll: true });
  });
}
const panels = byId("panels");
const sections = [...panels.querySelectorAll<HTMLElement>(":scope > section")];
/** The panel that is looked at, where it begins among the panels, and how far what holds them is scrolled. */
let looked: { section: HTMLElement; top: number; scroller: Element; scroll: number } | null = null;

function panelScroller(): Element {
  return getComputedStyle(panels).overflowY === "visible" ? (document.scrollingElement ?? panels) : panels;
}

/** The panel that is looked at is marked among the tabs. */
function markTab(): void {
  const top = Math.max(panels.getBoundingClientRect().top, 0) + 90;
  const current = sections.findLast((section) => section.getBoundingClientRect().top <= top) ?? sections[0];
  const scroller = panelScroller();
  looked = current ? { section: current, top: current.offsetTop, scroller, scroll: scroller.scrollTop } : null;
  for (const anchor of byId("tabs").querySelectorAll("a")) {
    const isHere = anchor.hash === `#${current?.id}`;
    anchor.classList.toggle("here", isHere);
    if (isHere) anchor.setAttribute("aria-current", "true");
    else anchor.removeAttribute("aria-current");
  }
}

/** What is looked at stays where it is, whatever grows or shrinks above it: variables come, a debugger opens. */
function keepPlace(): void {
  const moved = looked === null ? 0 : looked.section.offsetTop - looked.top;
  if (looked !== null && moved !== 0 && looked.scroller === panelScroller() && looked.scroll > 0) {
    const { scroller, scroll } = looked;
    // What shrinks at the end has taken the scroll position along, which is no wish of anybody.
    const isAtEnd = scroller.scrollTop + scroller.clientHeight >= scroller.scrollHeight - 1;
    scroller.scrollTop = (isAtEnd && moved < 0 ? scroll : scroller.scrollTop) + moved;
  }
  markTab();
}
// The page itself is what is scrolled on a low and narrow screen.
document.addEventListener(
  "scroll",
  (event) => {
    // Texts and lists that scroll inside a panel are not the panel. What has grown since the last frame is made good
    // here: a scroll event comes before the layout is observed, and would take the new place for the one that was
    // looked at.
    if (event.target === panels || event.target === document) keepPlace();
  },
  { capture: true, passive: true },
);
const layout = new ResizeObserver(keepPlace);
for (const one of [panels, ...sections]) layout.observe(one);

setInterval(() => {
  if (!shown) return;
  const [x = 0, y = 0, z = 0] = shown.actualPose;
  const text = t("view_text", {
    mode: t(MOTION[shown.motionMode] ?? "m_unknown"),
    x: fixed(x, 2),
    y: fixed(y, 2),
    z: fixed(z, 2),
  });
  byId("view").setAttribute("aria-label", text);
}, 1000);

translate(document.body);
const language = choiceOf("language");
setLanguage(
  language === "zh" || (language === null && navigator.language.toLowerCase().startsWith("zh")) ? "zh" : "en",
);
applyTheme();
showLink();
link.start();
void openView();

// For measurements: how often the page and the arm were drawn, and how late frames came.
Object.assign(window, {
  eliteserver: {
    frames: () => framesSeen,
    drawn: () => view?.frames ?? 0,
    latest: () => latest,
    cell: () => view?.figures() ?? null,
    paths: () => view?.pathFigures() ?? null,
    shapes: () => view?.shapeFigures() ?? [],
    pixelOf: (part: string) => view?.pixelOf(part) ?? null,
    pixelAt: (point: number[]) => view?.pixelAt(point) ?? null,
  },
});
