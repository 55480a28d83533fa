//! The whole recording as the page's time line: read once from its beginning, on a thread of its own, while it is
//! shown.
//!
//! A second [`Playback`] that nobody listens to follows the messages, so that each moment shows what it would show
//! live.

use std::iter::Peekable;
use std::sync::Arc;

use controller::cell_world::WorldScene;
use controller::cell_world::topic::{self, WorldMessage};
use kinematics::RobotModel;
use motion_api::RobotState;
use parking_lot::Mutex;
use pendant::frame::{FrameContext, encode};
use pendant::{History, PageScene, living_cell};
use recorder::{ReadError, Recording, RecordingEntry, Topic};
use serde_json::{Value, json};
use supervision::{ThreadRole, ThreadSupervisor};

use super::playback::Playback;
use crate::ports::description::TaskStatus;
use crate::ports::http::HttpBackend as _;
use crate::ports::http::page::{
    ALARM_LEVEL, MODE_LEVEL, ModeTracker, PageBackend as _, ShownProgram, add_load, line_event,
    registers_text, texts_of,
};

/// Programs whose text is kept.
const PROGRAMS_MAX: usize = 64;
/// Bytes of all their texts.
const PROGRAM_BYTES_MAX: usize = 16 << 20;
/// Panel and registers are looked at so often, s.
const PANEL_PERIOD: f64 = 0.1;
/// The world is looked at so often, s.
const WORLD_PERIOD: f64 = 1.0 / 30.0;

/// What the page shows of a recording, beside what all ports show.
pub(super) struct PageContent {
    /// The arm and its cell.
    pub(super) scene: PageScene,
    /// The parts of the cell and what handles them, before the first message.
    pub(super) world: Option<WorldScene>,
    /// Everything that was.
    pub(super) history: Arc<Mutex<History>>,
    /// What is played; none where no page shows it.
    pub(super) recording: Option<Recording>,
    /// The programs.
    pub(super) programs: Mutex<Vec<ShownProgram>>,
}

impl Default for PageContent {
    /// The page before anything is shown.
    fn default() -> Self {
        Self {
            scene: PageScene::default(),
            world: None,
            history: Arc::new(Mutex::new(History::of_recording())),
            recording: None,
            programs: Mutex::default(),
        }
    }
}

/// Reads the recording into the history of `shown`; `shadow` follows it.
pub(super) fn read(
    recording: Recording,
    shadow: Playback,
    shown: Arc<PageContent>,
) -> std::io::Result<()> {
    ThreadSupervisor::default().start(ThreadRole::Service, "time line", move || {
        let mut reading = HistoryReader {
            shadow,
            shown: &shown,
            modes: ModeTracker::default(),
            next_panel: f64::NEG_INFINITY,
            world: shown.world.clone().map(|scene| WorldReader {
                messages: topic::messages(&recording).ok().map(Iterator::peekable),
                scene,
                is_stale: false,
                next_moment: f64::NEG_INFINITY,
            }),
            panel: Arc::from(""),
            registers: Arc::from(""),
            sequence: 0,
        };
        match recording.entries(&Topic::ALL) {
            Ok(entries) => entries
                .map_while(Result::ok)
                .for_each(|(time, entry)| reading.take(time, entry)),
            Err(error) => tracing::warn!("the page has no time line: {error}"),
        }
        shown.history.lock().complete();
    })?;
    Ok(())
}

/// The world of the cell, read beside the cycles.
struct WorldReader<M: Iterator> {
    messages: Option<Peekable<M>>,
    scene: WorldScene,
    /// Something has changed since the last moment.
    is_stale: bool,
    next_moment: f64,
}

impl<M: Iterator<Item = Result<WorldMessage, ReadError>>> WorldReader<M> {
    /// Goes on to a cycle; the moment as JSON when something has changed and the last one is old enough.
    fn go_on(&mut self, state: &RobotState, model: &RobotModel) -> Option<Arc<str>> {
        let messages = self.messages.as_mut()?;
        let is_due = |message: &Result<WorldMessage, _>| {
            message
                .as_ref()
                .map_or(true, |message| message.cycle <= state.cycle)
        };
        while let Some(message) = messages.next_if(is_due) {
            match message {
                Ok(message) => {
                    let base_from_flange = model.flange_pose(&state.actual_q);
                    self.scene.apply(&message, &base_from_flange);
                    self.is_stale = true;
                }
                Err(error) => {
                    tracing::warn!("the page shows no more of the world: {error}");
                    self.messages = None;
                    break;
                }
            }
        }
        if !self.is_stale || state.time < self.next_moment {
            return None;
        }
        self.is_stale = false;
        self.next_moment = state.time + WORLD_PERIOD;
        Some(living_cell::moment(self.scene.picture()).to_string().into())
    }
}

struct HistoryReader<'s, M: Iterator> {
    shadow: Playback,
    world: Option<WorldReader<M>>,
    shown: &'s PageContent,
    modes: ModeTracker,
    next_panel: f64,
    panel: Arc<str>,
    registers: Arc<str>,
    sequence: u32,
}

impl<M: Iterator<Item = Result<WorldMessage, ReadError>>> HistoryReader<'_, M> {
    fn take(&mut self, time: f64, entry: RecordingEntry) {
        match &entry {
            RecordingEntry::Script(script) => {
                if let Some(text) = &script.text {
                    self.keep(ShownProgram {
                        number: script.program_id,
                        name: script.program.clone(),
                        text: text.as_str().into(),
                    });
                }
            }
            RecordingEntry::Log(message) => {
                let event = line_event(
                    time,
                    message.level,
                    &message.source,
                    message.message.english(),
                );
                self.event(time, message.level.number() as u8, &event);
                if message.level >= recorder::LogLevel::Error {
                    let mut alarm = event;
                    alarm["event"] = "alarm".into();
                    alarm["texts"] = texts_of(&message.message);
                    alarm["kind"] = "recorded".into();
                    self.event(time, ALARM_LEVEL, &alarm);
                }
            }
            RecordingEntry::Command(command) => {
                let event = json!({
                    "event": "command",
                    "time": time,
                    "name": command.name,
                    "program": command.program,
                    "line": command.line,
                });
                self.event(time, MODE_LEVEL, &event);
            }
            RecordingEntry::Cycle(_) | RecordingEntry::Io(_) | RecordingEntry::Variable(_) => {}
        }
        let is_cycle = matches!(entry, RecordingEntry::Cycle(_));
        self.shadow.take(time, entry);
        if is_cycle {
            self.cycle();
        }
    }

    fn cycle(&mut self) {
        let state = self.shadow.state();
        let (line, node) = self.shadow.place();
        self.sequence = self.sequence.wrapping_add(1);
        let beside = FrameContext {
            sequence: self.sequence,
            wall_ms: 0.0,
            task: match self.shadow.task_status() {
                TaskStatus::Stopped => 0,
                TaskStatus::Running => 1,
                TaskStatus::Paused => 2,
            },
            line,
            node,
            program: self.shadow.program_number(),
        };
        self.shown
            .history
            .lock()
            .frame(state.time, &encode(&state, &beside));
        if let Some(world) = &mut self.world
            && let Some(moment) = world.go_on(&state, self.shadow.model())
        {
            self.shown.history.lock().world(state.time, moment);
        }
        if let Some(event) = self.modes.changes(&state, beside.task) {
            self.event(state.time, MODE_LEVEL, &event);
        }
        if state.time >= self.next_panel {
            self.next_panel = state.time + PANEL_PERIOD;
            self.beside(&state);
        }
    }

    fn beside(&mut self, state: &RobotState) {
        let mut panel = self.shadow.panel();
        add_load(&mut panel, state);
        panel["name"] = panel["program"].clone();
        // Those change with every line and are in the frame.
        for name in ["line", "node"] {
            panel[name] = Value::Null;
        }
        let panel: Arc<str> = panel.to_string().into();
        let registers = registers_text(&self.shadow.registers());
        let mut history = self.shown.history.lock();
        if panel != self.panel {
            history.panel(state.time, panel.clone());
            self.panel = panel;
        }
        if registers != self.registers {
            history.registers(state.time, registers.clone());
            self.registers = registers;
        }
    }

    fn event(&self, time: f64, level: u8, event: &Value) {
        self.shown
            .history
            .lock()
            .event(time, level, event.to_string().into());
    }

    fn keep(&self, program: ShownProgram) {
        let mut programs = self.shown.programs.lock();
        let bytes: usize = programs.iter().map(|program| program.text.len()).sum();
        // The first ones: those of a recording that began with them.
        if programs.len() < PROGRAMS_MAX && bytes + program.text.len() <= PROGRAM_BYTES_MAX {
            programs.push(program);
        }
    }
}
