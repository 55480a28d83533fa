//! The controller of a recording as the ports see it: the state of the moment, and a polite no to whoever wants more.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use controller::recording_observer::PROGRAM_ENDED;
use elite_runtime::CompilePool;
use kinematics::RobotModel;
use messages::{Text, text};
use motion::histogram::Histogram;
use motion_api::{RegisterImages, Registers, RingFull, RobotState};
use parking_lot::Mutex;
use recorder::{
    CommandMessage, LogLevel, LogMessage, RecordingEntry, ScriptMessage, Setup, VariableMessage,
};
use serde_json::{Value, json};
use supervision::ThreadSupervisor;
use tokio::sync::{broadcast, watch};

use super::time_line::PageContent;
use crate::ports::ClientId;
use crate::ports::description::{Peripherals, RobotDescription, TaskStatus, ToolSerial};
use crate::ports::foxglove::LogLine;
use crate::ports::http::metrics::Figures;
use crate::ports::http::{self, SetInputsError};
use crate::ports::primary::framing::ControlPhrase;
use crate::ports::primary::{self, StateHub, Submission};
use crate::ports::rtsi;
use crate::ports::rtsi::inputs::{Change, InputVariable};
use crate::ports::sample::{Sample, SampleDecimator};
use crate::sample_feed::elbow_velocity;
use controller::register_write::RegisterWrite;
use wire::primary::{ErrorData, Exception, ExceptionLevel, ExceptionSource};

/// How many samples and messages a listener may be behind before it loses some.
const WAITING_MAX: usize = 256;
/// Global variables that are kept for `/panel`.
const VARIABLES_MAX: usize = 1000;
/// What clients are told that want to change something.
pub(super) static READ_ONLY: Text = text!(
    "this is a replay of a recording, it takes no programs and no inputs",
    "这是记录的重放，不接受程序和输入"
);

/// What is played, at the moment.
pub(super) struct Playback {
    name: String,
    model: RobotModel,
    description: RobotDescription,
    epoch_ns: u64,
    hub: StateHub,
    samples: broadcast::Sender<Arc<Sample>>,
    beats: SampleDecimator,
    log_lines: broadcast::Sender<LogLine>,
    durations: Histogram,
    latencies: Histogram,
    registers: Registers,
    now: Mutex<PlaybackState>,
    shown: Arc<PageContent>,
    /// Checks texts beside the ports.
    pub(super) pool: CompilePool,
}

struct PlaybackState {
    state: RobotState,
    task: TaskStatus,
    program: String,
    program_number: u32,
    line: u32,
    /// Number and label of the node of the pendant's task.
    node: Option<(u32, Option<String>)>,
    variables: BTreeMap<String, (String, String)>,
    errors: u64,
}

impl Playback {
    /// Before its first message. `name` is the file, for people.
    pub(super) fn new(
        name: &str,
        model: RobotModel,
        description: RobotDescription,
        setup: &Setup,
    ) -> Self {
        let now = PlaybackState {
            state: RobotState::at_start(setup.home, setup.step_time),
            task: TaskStatus::Stopped,
            program: String::new(),
            program_number: 0,
            line: 0,
            node: None,
            variables: BTreeMap::new(),
            errors: 0,
        };
        Self {
            name: name.to_owned(),
            description,
            model,
            epoch_ns: setup.epoch_ns,
            hub: StateHub::default(),
            samples: broadcast::channel(WAITING_MAX).0,
            beats: SampleDecimator::default(),
            log_lines: broadcast::channel(WAITING_MAX).0,
            durations: Histogram::default(),
            latencies: Histogram::default(),
            registers: Registers::default(),
            now: Mutex::new(now),
            shown: Arc::default(),
            pool: CompilePool::new(ThreadSupervisor::default()),
        }
    }

    /// This playback with what the pendant page shows.
    pub(super) fn with_page(self, shown: Arc<PageContent>) -> Self {
        Self { shown, ..self }
    }

    /// What the pendant page shows.
    pub(super) fn shown(&self) -> &PageContent {
        &self.shown
    }

    /// The file, for people.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The arm.
    pub(super) const fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The arm's name for people.
    pub(super) fn robot_name(&self) -> &str {
        &self.description.name
    }

    /// Line and node of the moment.
    pub(super) fn place_now(&self) -> (u32, u32) {
        let now = self.now.lock();
        (now.line, now.node.as_ref().map_or(0, |(number, _)| *number))
    }

    /// Number of the program of the moment.
    pub(super) fn program_now(&self) -> u32 {
        self.now.lock().program_number
    }

    /// The clients of port 30001.
    pub(super) fn hub(&self) -> &StateHub {
        &self.hub
    }

    /// Every cycle from now on.
    pub(super) fn samples(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.samples.subscribe()
    }

    /// Every message for people from now on.
    pub(super) fn log_lines(&self) -> broadcast::Receiver<LogLine> {
        self.log_lines.subscribe()
    }

    /// One message of the recording; its time has come.
    pub(super) fn take(&self, time: f64, entry: RecordingEntry) {
        match entry {
            RecordingEntry::Cycle(cycle) => match cycle.to_state() {
                Ok(state) => self.cycle(state),
                // A file of a newer version: what can be shown goes on.
                Err(error) => tracing::debug!("a cycle is left out: {error}"),
            },
            RecordingEntry::Script(script) => self.script(script),
            RecordingEntry::Command(command) => self.command(&command),
            RecordingEntry::Log(message) => self.log(time, message),
            RecordingEntry::Io(change) => {
                if let Some(write) = RegisterWrite::from_message(&change) {
                    write.apply(&self.registers);
                }
            }
            RecordingEntry::Variable(variable) => self.variable(variable),
        }
    }

    fn cycle(&self, state: RobotState) {
        let micros = |value: f64| Duration::try_from_secs_f64(value / 1e6).unwrap_or_default();
        if state.step_duration_us > 0.0 {
            self.durations.record(micros(state.step_duration_us));
            self.latencies.record(micros(state.wakeup_latency_us));
        }
        self.now.lock().state = state;
        let sample = Arc::new(self.sample());
        if self.beats.is_due(state.time) {
            self.beats.publish(sample.clone());
        }
        // Nobody listening is fine.
        let _ = self.samples.send(sample);
    }

    fn sample(&self) -> Sample {
        let now = self.now.lock();
        Sample {
            state: now.state,
            task: now.task,
            script_line: now.line,
            elbow_velocity: elbow_velocity(&self.model, &now.state),
            registers: self.registers.images(),
            peripherals: Peripherals::of(&now.state),
        }
    }

    fn script(&self, script: ScriptMessage) {
        let mut now = self.now.lock();
        if script.text.is_some() {
            now.task = TaskStatus::Running;
            now.program.clone_from(&script.program);
            now.program_number = script.program_id;
            now.variables.clear();
        }
        if let (Some(0), Some(line)) = (script.thread, script.line) {
            now.line = line;
            now.node = script.node.map(|node| (node, script.label));
        }
    }

    fn command(&self, command: &CommandMessage) {
        let mut now = self.now.lock();
        now.task = match (command.name.as_str(), now.task) {
            ("pause", TaskStatus::Running) => TaskStatus::Paused,
            ("resume", TaskStatus::Paused) => TaskStatus::Running,
            (_, task) => task,
        };
    }

    fn log(&self, time: f64, message: LogMessage) {
        let LogMessage {
            level,
            source,
            message,
        } = message;
        let text = message.english().to_owned();
        let line = {
            let mut now = self.now.lock();
            if text == PROGRAM_ENDED && source == now.program {
                now.task = TaskStatus::Stopped;
                now.line = 0;
                now.node = None;
            }
            now.errors += u64::from(level >= LogLevel::Error);
            now.line
        };
        if level >= LogLevel::Error {
            let exception = if source == "controller" {
                Exception::Robot {
                    code: 0,
                    sub_code: 0,
                    level: ExceptionLevel::Error,
                    data: ErrorData::Text(text.clone()),
                }
            } else {
                Exception::Script {
                    line: i32::try_from(line).unwrap_or(i32::MAX),
                    column: 1,
                    text: text.clone(),
                }
            };
            self.announce(&exception);
        }
        // Nobody listening is fine.
        let _ = self.log_lines.send(LogLine {
            time,
            level,
            source,
            text,
        });
    }

    fn variable(&self, variable: VariableMessage) {
        let VariableMessage {
            name,
            type_name,
            value,
            ..
        } = variable;
        let variables = &mut self.now.lock().variables;
        if variables.len() < VARIABLES_MAX || variables.contains_key(&name) {
            variables.insert(name, (type_name, value));
        }
    }

    fn announce(&self, exception: &Exception) {
        let millis = primary::PrimaryBackend::unix_millis(self);
        self.hub
            .announce(millis, ExceptionSource::Controller, exception);
    }

    /// Tells every client of port 30001 that something it sent is not done.
    fn refuse(&self, client: ClientId, what: &str) {
        tracing::warn!(%client, "{what} was refused: {READ_ONLY}");
        self.announce(&Exception::Script {
            line: 1,
            column: 1,
            text: format!("RuntimeError: {what} was refused: {READ_ONLY}"),
        });
    }
}

impl primary::PrimaryBackend for Playback {
    /// A recording has no control mode.
    fn closed_to_clients(&self) -> impl Future<Output = ()> + Send {
        std::future::pending()
    }

    fn beats(&self) -> watch::Receiver<Option<Arc<Sample>>> {
        self.beats.subscribe()
    }

    fn sample(&self) -> Sample {
        self.sample()
    }

    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn tool_serial(&self) -> Option<ToolSerial> {
        None // recordings do not tell
    }

    fn unix_millis(&self) -> u64 {
        self.epoch_ns / 1_000_000 + (self.now.lock().state.time * 1e3) as u64
    }

    async fn is_whole_program(&self, _text: String) -> bool {
        // Whatever it is, it is refused now rather than after more of it.
        true
    }

    async fn submit(&self, submission: Submission) {
        self.refuse(submission.sender.client, "a program");
    }

    /// Nothing runs that could end.
    fn preempt(&self, _: ControlPhrase) {}

    async fn control(&self, client: ClientId, phrase: ControlPhrase) {
        self.refuse(client, &format!("the order {phrase:?}"));
    }
}

impl rtsi::RtsiBackend for Playback {
    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn samples(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.samples.subscribe()
    }

    fn sample(&self) -> Sample {
        self.sample()
    }

    fn read_only(&self) -> Option<&'static str> {
        Some(READ_ONLY.english())
    }

    fn apply(
        &self,
        client: ClientId,
        _changes: &[Change],
        _written: &[InputVariable],
    ) -> Result<u64, RingFull> {
        // Inputs are refused when they are set up; without a recipe no values come.
        tracing::debug!(%client, "rtsi: values were refused: {READ_ONLY}");
        Ok(self.now.lock().state.cycle)
    }
}

impl http::HttpBackend for Playback {
    fn state(&self) -> RobotState {
        self.now.lock().state
    }

    fn task_status(&self) -> TaskStatus {
        self.now.lock().task
    }

    fn panel(&self) -> Value {
        let now = self.now.lock();
        let variables = now.variables.iter();
        let variables = variables
            .map(|(name, (kind, value))| json!({"name": name, "type": kind, "value": value}));
        json!({
            "replay": self.name,
            "task": now.task.name(),
            "program": now.program,
            "line": now.line,
            "node": now.node.as_ref().map(|(number, _)| *number),
            "label": now.node.as_ref().and_then(|(_, label)| label.as_deref()),
            "variables": variables.collect::<Vec<Value>>(),
        })
    }

    fn registers(&self) -> RegisterImages {
        self.registers.images()
    }

    fn set_inputs(&self, _changes: &http::io::IoChanges) -> Result<(), SetInputsError> {
        Err(SetInputsError::ReadOnly(READ_ONLY.clone()))
    }

    fn figures(&self) -> Figures {
        Figures {
            cycle_durations: self.durations.snapshot(),
            wakeup_latencies: self.latencies.snapshot(),
            errors: crate::event_broadcast::ERROR_KINDS.map(|kind| match kind {
                "other" => (kind, self.now.lock().errors),
                kind => (kind, 0),
            }),
            ..Figures::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use recorder::{IoMessage, IoValue};

    fn playback() -> Playback {
        let model = RobotModel::built_in("cs66").unwrap();
        Playback::new("a.mcap", model, RobotDescription::cs66(), &Setup::default())
    }

    fn io(name: &str, value: IoValue) -> RecordingEntry {
        RecordingEntry::Io(IoMessage {
            cycle: 1,
            name: name.to_owned(),
            value,
        })
    }

    #[test]
    fn registers_are_where_their_names_say_and_nonsense_changes_nothing() {
        let playback = playback();
        let mut samples = playback.samples();
        for entry in [
            io("output_boolean_register[127]", IoValue::Level(true)),
            io("input_integer_register[3]", IoValue::Integer(-7)),
            io("output_float_register[47]", IoValue::Integer(2)),
            io("output_float_register[48]", IoValue::Number(1.0)),
            io("output_boolean_register[128]", IoValue::Level(true)),
            io("input_integer_register[x]", IoValue::Integer(1)),
            io("standard_digital_out[3]", IoValue::Level(true)),
            io("[", IoValue::Level(true)),
        ] {
            playback.take(0.0, entry);
        }
        let state = RobotState::at_start(Setup::default().home, 0.004);
        playback.take(0.004, RecordingEntry::Cycle(Box::new((&state).into())));
        let sample = samples.try_recv().unwrap();
        let (inputs, outputs) = (&sample.registers.input, &sample.registers.output);
        assert_eq!(outputs.booleans(), [0, 1 << 63]);
        assert_eq!(outputs.float(47), 2.0);
        let set: Vec<u8> = (0..48).filter(|n| inputs.integer(*n) != 0).collect();
        assert_eq!((set, inputs.integer(3)), (vec![3], -7));
    }

    #[test]
    fn the_task_runs_from_its_start_to_its_end_and_is_held_in_between() {
        let playback = playback();
        let status = || http::HttpBackend::task_status(&playback);
        let script = |text: Option<&str>, line: Option<u32>| {
            RecordingEntry::Script(ScriptMessage {
                program: "p".to_owned(),
                program_id: 1,
                text: text.map(str::to_owned),
                thread: line.map(|_| 0),
                line,
                rounds: None,
                node: line,
                label: line.map(|line| format!("at {line}")),
            })
        };
        assert_eq!(status(), TaskStatus::Stopped);
        playback.take(0.0, script(Some("sync()"), None));
        playback.take(0.0, script(None, Some(4)));
        assert_eq!(status(), TaskStatus::Running);
        let panel = http::HttpBackend::panel(&playback);
        assert_eq!(
            (&panel["line"], &panel["node"], &panel["label"]),
            (&json!(4), &json!(4), &json!("at 4"))
        );
        playback.take(
            1.0,
            RecordingEntry::Log(LogMessage {
                level: LogLevel::Info,
                source: "p".to_owned(),
                message: Text::verbatim(PROGRAM_ENDED),
            }),
        );
        assert_eq!(status(), TaskStatus::Stopped);
        let panel = http::HttpBackend::panel(&playback);
        assert_eq!((&panel["line"], &panel["node"]), (&json!(0), &json!(null)));
    }
}
