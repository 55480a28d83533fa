//! What all pages are shown: one frame 60 times a second for whoever looks, changes of the panel and of the cell's
//! world, and what is told.
//!
//! Looks at the latest snapshot and never at the cycle, so pages cost the control cycle nothing, however many they are.
//! The latest frame and the latest world are all that waits for a page; events wait in one queue that all share, from
//! which a slow page loses the oldest.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use elite_runtime::message::{Message, Severity};
use messages::{Language, Text};
use parking_lot::Mutex;

use motion_api::{RegisterImages, RobotMode, RobotState, SafetyMode};
use pendant::frame::{FrameContext, encode};
use pendant::{FRAME_BYTES, History};
use recorder::LogLevel;
use recorder::lengths::truncate_marked;
use serde_json::{Value, json};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, watch};
use tokio::time::{MissedTickBehavior, interval};
use tokio_util::sync::CancellationToken;

use super::PageBackend;
use crate::language;
use crate::ports::description::TaskStatus;

/// Time between two frames.
const FRAME_PERIOD: Duration = Duration::from_micros(16_667);
/// The panel is looked at with every so many frames.
const FRAMES_PER_PANEL: u32 = 6;
/// Without a page, with every so many frames one is made, for the time line.
const FRAMES_PER_IDLE: u32 = 3;
/// Events that wait for pages that are behind.
const BACKLOG: usize = 512;
/// Longest text of an event, bytes.
const TEXT_BYTES_MAX: usize = 16 << 10;

/// Level of a change of mode, and of a command, among the lines of the log.
pub const MODE_LEVEL: u8 = 3;
/// Level of an alarm.
pub const ALARM_LEVEL: u8 = 4;

/// The stage.
pub struct PageBroadcast {
    frames: watch::Sender<Arc<[u8]>>,
    events: broadcast::Sender<Arc<str>>,
    panel: watch::Sender<Arc<str>>,
    registers: watch::Sender<Arc<str>>,
    world: watch::Sender<Arc<str>>,
    history: Arc<Mutex<History>>,
    pages: AtomicUsize,
}

impl PageBroadcast {
    /// Nobody looks yet.
    pub fn new(history: Arc<Mutex<History>>) -> Self {
        Self {
            frames: watch::Sender::new(Arc::from(&[][..])),
            events: broadcast::Sender::new(BACKLOG),
            panel: watch::Sender::new(Arc::from("null")),
            registers: watch::Sender::new(Arc::from("null")),
            world: watch::Sender::new(Arc::from("null")),
            history,
            pages: AtomicUsize::new(0),
        }
    }

    /// The latest frame, and those that come.
    pub(super) fn frames(&self) -> watch::Receiver<Arc<[u8]>> {
        self.frames.subscribe()
    }

    /// The world of the cell as it is, and every change of it: a page that is behind gets the latest.
    pub(super) fn world(&self) -> watch::Receiver<Arc<str>> {
        self.world.subscribe()
    }

    /// Every event from now on.
    pub(super) fn events(&self) -> broadcast::Receiver<Arc<str>> {
        self.events.subscribe()
    }

    /// The panel and the registers as they are.
    pub(super) fn now(&self) -> [Arc<str>; 2] {
        [self.panel.borrow().clone(), self.registers.borrow().clone()]
    }

    /// What was.
    pub(super) const fn history(&self) -> &Arc<Mutex<History>> {
        &self.history
    }

    /// Pages that look.
    pub fn pages(&self) -> usize {
        self.pages.load(Ordering::Relaxed)
    }

    /// One page more, until what is given back is dropped.
    pub(super) fn enter(self: &Arc<Self>) -> PageGuard {
        self.pages.fetch_add(1, Ordering::Relaxed);
        PageGuard(Arc::clone(self))
    }

    /// Tells every page.
    pub(super) fn tell(&self, event: Arc<str>) {
        // Nobody looking is fine.
        let _ = self.events.send(event);
    }

    /// Shows what happens until `shutdown`.
    pub(super) async fn run<C: PageBackend>(&self, cockpit: &C, shutdown: &CancellationToken) {
        let (mut lines, mut alarms) = cockpit.subscribe_messages();
        let mut ticks = interval(FRAME_PERIOD);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut show = PagePublisher {
            stage: self,
            cockpit,
            sequence: 0,
            fills_history: cockpit.recorded().is_none(),
            modes: ModeTracker::default(),
        };
        // What is there at the start, so that the first change is one.
        show.look();
        loop {
            tokio::select! {
                () = shutdown.cancelled() => return,
                _ = ticks.tick() => show.tick(),
                line = lines.recv() => match line {
                    Ok(line) => show.line(&line),
                    Err(RecvError::Lagged(missed)) => {
                        tracing::debug!(missed, "pages were not told of some lines of the log");
                    }
                    Err(RecvError::Closed) => return,
                },
                alarm = next(&mut alarms) => match alarm {
                    Ok(message) => show.alarm(&message),
                    Err(RecvError::Lagged(missed)) => {
                        tracing::warn!("pages were not told of {missed} messages");
                    }
                    Err(RecvError::Closed) => alarms = None,
                },
            }
        }
    }
}

/// The next message, or never one.
async fn next(alarms: &mut Option<broadcast::Receiver<Message>>) -> Result<Message, RecvError> {
    match alarms {
        Some(alarms) => alarms.recv().await,
        None => std::future::pending().await,
    }
}

/// A page that looks.
pub(super) struct PageGuard(Arc<PageBroadcast>);

impl Drop for PageGuard {
    fn drop(&mut self) {
        self.0.pages.fetch_sub(1, Ordering::Relaxed);
    }
}

struct PagePublisher<'s, C> {
    stage: &'s PageBroadcast,
    cockpit: &'s C,
    sequence: u32,
    fills_history: bool,
    modes: ModeTracker,
}

impl<C: PageBackend> PagePublisher<'_, C> {
    fn tick(&mut self) {
        self.sequence = self.sequence.wrapping_add(1);
        let is_seen = self.stage.pages() > 0;
        if !is_seen && !self.sequence.is_multiple_of(FRAMES_PER_IDLE) {
            return;
        }
        self.look();
    }

    /// What there is now.
    fn look(&mut self) {
        let is_seen = self.stage.pages() > 0;
        let state = self.cockpit.state();
        let (line, node) = self.cockpit.place();
        let beside = FrameContext {
            sequence: self.sequence,
            wall_ms: wall_ms(),
            task: match self.cockpit.task_status() {
                TaskStatus::Stopped => 0,
                TaskStatus::Running => 1,
                TaskStatus::Paused => 2,
            },
            line,
            node,
            program: self.cockpit.program_number(),
        };
        if let Some(event) = self.modes.changes(&state, beside.task) {
            self.event(state.time, MODE_LEVEL, event);
        }
        let frame = encode(&state, &beside);
        if self.fills_history {
            self.stage.history.lock().frame(state.time, &frame);
        }
        if is_seen {
            self.stage
                .frames
                .send_replace(Arc::from(&frame[..FRAME_BYTES]));
        }
        if let Some(world) = self.cockpit.world()
            && replace_if_changed(&self.stage.world, &world)
            && self.fills_history
        {
            self.stage.history.lock().world(state.time, world);
        }
        if self.sequence.is_multiple_of(FRAMES_PER_PANEL) {
            self.panel(&state);
        }
    }

    /// What has changed in the panel and the registers.
    fn panel(&self, state: &RobotState) {
        let time = state.time;
        let mut panel = self.cockpit.panel();
        add_load(&mut panel, state);
        if let Some(program) = self.cockpit.program(self.cockpit.program_number()) {
            panel["name"] = program.name.into();
        }
        let panel: Arc<str> = panel.to_string().into();
        let registers = registers_text(&self.cockpit.registers());
        let stage = self.stage;
        if replace_if_changed(&stage.panel, &panel) {
            stage.tell(format!(r#"{{"event":"panel","panel":{panel}}}"#).into());
            if self.fills_history {
                stage.history.lock().panel(time, panel);
            }
        }
        if replace_if_changed(&stage.registers, &registers) {
            stage.tell(format!(r#"{{"event":"registers","registers":{registers}}}"#).into());
            if self.fills_history {
                stage.history.lock().registers(time, registers);
            }
        }
    }

    fn line(&self, line: &controller::LogLine) {
        self.event(
            line.time,
            line.level.number() as u8,
            line_event(line.time, line.level, &line.source, &line.text),
        );
    }

    fn alarm(&self, message: &Message) {
        let time = self.cockpit.state().time;
        if let Some(event) = alarm_event(time, message) {
            self.event(time, ALARM_LEVEL, event);
        }
    }

    fn event(&self, time: f64, level: u8, event: Value) {
        let event: Arc<str> = event.to_string().into();
        if self.fills_history {
            self.stage.history.lock().event(time, level, event.clone());
        }
        self.stage.tell(event);
    }
}

/// The payload is no part of a frame, because it seldom changes: the panel has it.
pub fn add_load(panel: &mut Value, state: &RobotState) {
    let payload = &state.payload;
    panel["payload"] = json!({"mass": payload.mass, "cog": payload.cog.as_slice()});
}

/// Robot, safety and program states, for events of their changes.
#[derive(Debug, Default)]
pub struct ModeTracker(Option<(RobotMode, SafetyMode, u8)>);

impl ModeTracker {
    /// An event of what has changed since the last look.
    pub fn changes(&mut self, state: &RobotState, task: u8) -> Option<Value> {
        let now = (state.robot_mode, state.safety_mode, task);
        let before = self.0.replace(now);
        before.filter(|before| *before != now)?;
        Some(json!({
            "event": "mode",
            "time": state.time,
            "robot_mode": now.0.name(),
            "safety_mode": now.1.name(),
            "task": now.2,
        }))
    }
}

/// Puts a text in its place; true when it is another one.
fn replace_if_changed(place: &watch::Sender<Arc<str>>, text: &Arc<str>) -> bool {
    place.send_if_modified(|old| {
        let is_new = old != text;
        if is_new {
            *old = text.clone();
        }
        is_new
    })
}

/// A line of the log as an event.
pub fn line_event(time: f64, level: LogLevel, source: &str, text: &str) -> Value {
    json!({
        "event": "log",
        "time": time,
        "level": level.number(),
        "source": short(source),
        "text": short(text),
    })
}

/// What people must see, as an event: `text` in the language of this process, `texts` in each.
fn alarm_event(time: f64, message: &Message) -> Option<Value> {
    let chosen = language::chosen();
    let (text, mut event) = match message {
        Message::ScriptError {
            program,
            line,
            column,
            summary,
            report,
        } => (
            summary,
            json!({
                "kind": "script",
                "program": program.0,
                "line": line,
                "column": column,
                "report": short(report.in_language(chosen)),
            }),
        ),
        Message::Robot {
            origin,
            code,
            sub_code,
            severity,
            text,
        } => (
            text,
            json!({
                "kind": "robot",
                "program": origin.program.0,
                "line": origin.line,
                "code": code,
                "sub_code": sub_code,
                "severity": match severity {
                    Severity::Info => "info",
                    Severity::Warning => "warning",
                    Severity::Error => "error",
                },
            }),
        ),
        Message::Print { .. } | Message::Log { .. } => return None,
    };
    event["event"] = "alarm".into();
    event["time"] = time.into();
    event["text"] = short(text.in_language(chosen)).into();
    event["texts"] = texts_of(text);
    Some(event)
}

/// A text in each language, as events have it.
pub fn texts_of(text: &Text) -> Value {
    json!({
        "en": short(text.english()),
        "zh": short(text.in_language(Language::Chinese)),
    })
}

/// A text that is cut with a mark where it is too long for an event.
pub fn short(text: &str) -> String {
    truncate_marked(text, TEXT_BYTES_MAX).unwrap_or_else(|| text.to_owned())
}

/// All registers as JSON.
pub fn registers_text(registers: &RegisterImages) -> Arc<str> {
    let banks = json!({"input": bank(&registers.input), "output": bank(&registers.output)});
    banks.to_string().into()
}

/// Registers as arrays; floats that are no numbers are null.
fn bank(bank: &motion_api::registers::RegisterImage) -> Value {
    json!({
        "boolean": (0..128).filter(|n| bank.boolean(*n)).collect::<Vec<u8>>(),
        "integer": (0..48).map(|n| bank.integer(n)).collect::<Vec<i32>>(),
        "float": (0..48).map(|n| bank.float(n)).collect::<Vec<f64>>(),
    })
}

/// The clock of this machine, ms since 1970.
pub(super) fn wall_ms() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0.0, |since| since.as_secs_f64() * 1e3)
}
