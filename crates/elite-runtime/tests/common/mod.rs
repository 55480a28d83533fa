//! What tests of whole programs share: an arm that stands still behind the real border, and programs run to their end.
//!
//! The arm takes every command and does nothing, so the tests need neither planner nor physics.

#![allow(dead_code, reason = "each test binary uses a part of this")]
#![allow(
    clippy::unwrap_used,
    reason = "a test helper that fails fails the test"
)]

use elite_runtime::panel::{Operator, Panel};
use elite_runtime::robot::ScriptChannels;
use elite_runtime::{Message, Observer, ProgramText, Robot, Supervisor, TaskEnd, TaskSettings};
use kinematics::{JointPositions, RobotModel, RpyPose, SafetyBounds};
use motion_api::{
    CommandId, CommandKind, Event, MotionCommand, MotionEndpoint, Outcome, ProgramId,
    RingCapacities, RobotState, SettingCommand, ThreadNumber, Timeline, motion_channel,
};
use std::sync::{Arc, Mutex};

/// Which arm, and how it stands.
pub struct Standing {
    pub model: &'static str,
    pub q: [f64; 6],
    pub tcp: [f64; 6],
    pub digital_in: u64,
    pub safety_bounds: SafetyBounds,
    /// What programs may reach.
    pub permissions: elite_runtime::Permissions,
    /// Cycles until a motion with a radius enters its zone; the next one may follow at once.
    pub blend_cycles: u64,
}

impl Default for Standing {
    fn default() -> Self {
        Self {
            model: "cs66",
            q: [0.1, -1.2, 1.3, -1.4, -1.5, 0.6],
            tcp: [0.0; 6],
            digital_in: 0,
            safety_bounds: SafetyBounds::default(),
            permissions: elite_runtime::Permissions::default(),
            blend_cycles: 0,
        }
    }
}

/// What a program did.
pub struct Ran {
    pub end: TaskEnd,
    /// Standard output.
    pub printed: String,
    /// Texts of log lines.
    pub log: Vec<String>,
    /// `Type: message` of the uncaught exception.
    pub error: String,
    /// The whole report of it.
    pub report: String,
    /// The report in Chinese.
    pub chinese: String,
    /// Line and column of it.
    pub error_at: (u32, u32),
    /// What the arm was told.
    pub commands: Vec<CommandKind>,
    /// What its memory account said at each `print`, bytes.
    pub held: Vec<isize>,
    /// Where its threads stood, as they were told.
    pub places: Vec<(u32, Place)>,
}

/// Time that passes when it is asked to.
struct Still(Mutex<StillArm>);

struct StillArm {
    end: MotionEndpoint,
    state: RobotState,
    commands: Vec<CommandKind>,
    blend_cycles: u64,
    /// Motions that have not entered their zones, and when they do.
    on_their_way: Vec<(CommandId, u64)>,
}

impl StillArm {
    fn ends(&mut self, id: CommandId) {
        let (outcome, cycle) = (Outcome::Done, self.state.cycle);
        let ended = Event::Ended { id, outcome, cycle };
        self.end.events.push(ended).unwrap();
    }
}

impl Timeline for Still {
    fn is_virtual(&self) -> bool {
        true
    }

    fn advance(&self) -> bool {
        let arm = &mut *self.0.lock().unwrap();
        arm.state.cycle += 1;
        arm.state.time += arm.state.step_time;
        let cycle = arm.state.cycle;
        while let Ok(command) = arm.end.commands.pop() {
            arm.commands.push(command.kind);
            if let CommandKind::Setting(SettingCommand::EncoderEnableSetTickCount {
                encoder,
                range,
            }) = command.kind
            {
                arm.state.encoder_ranges[usize::from(encoder)] = range.number();
            }
            let id = command.id;
            let is_blended = matches!(command.kind, CommandKind::Motion(MotionCommand::MoveJ { radius,
                .. }) if radius > 0.0);
            if is_blended && arm.blend_cycles > 0 {
                let zone_in = cycle + arm.blend_cycles;
                arm.on_their_way.push((id, zone_in));
                let ready = Event::ReadyForNext { id, cycle };
                arm.end.events.push(ready).unwrap();
                arm.end.events.push(Event::Due { id, cycle }).unwrap();
            } else {
                arm.ends(id);
            }
        }
        let due: Vec<_> = arm
            .on_their_way
            .extract_if(.., |(_, zone_in)| *zone_in <= cycle)
            .collect();
        due.into_iter().for_each(|(id, _)| arm.ends(id));
        let state = arm.state;
        arm.end.snapshot.publish(&state);
        true
    }

    fn set_driven(&self, _on: bool) {}
}

/// A line, and number and label of a node of the pendant's task.
pub type Place = (u32, Option<(u32, String)>);

#[derive(Default)]
struct Listener {
    heard: Mutex<(String, Vec<String>, String, String)>,
    /// Where its threads stood, as they were told.
    places: Mutex<Vec<(u32, Place)>>,
    /// The report of the error in Chinese.
    chinese: Mutex<String>,
    /// Line and column of the error.
    error_at: Mutex<(u32, u32)>,
    /// What the task's thread held at each `print`.
    held: Mutex<Vec<isize>>,
}

impl Observer for Listener {
    fn message(&self, message: &Message) {
        let (printed, log, error, full) = &mut *self.heard.lock().unwrap();
        match message {
            Message::Print { text, .. } => {
                self.held.lock().unwrap().push(task_memory::live_bytes());
                printed.push_str(text);
            }
            Message::Log { text, .. } | Message::Robot { text, .. } => log.push(text.to_string()),
            Message::ScriptError {
                summary,
                report,
                line,
                column,
                ..
            } => {
                *self.error_at.lock().unwrap() = (*line, *column);
                summary.english().clone_into(error);
                report.english().clone_into(full);
                let chinese = report.in_language(messages::Language::Chinese);
                chinese.clone_into(&mut self.chinese.lock().unwrap());
            }
        }
    }

    fn line_changed(
        &self,
        _: ProgramId,
        thread: ThreadNumber,
        line: u32,
        node: Option<&elite_syntax::TaskNode>,
    ) {
        let node = node.map(|node| (node.number, node.label.to_string()));
        self.places.lock().unwrap().push((thread.0, (line, node)));
    }
}

/// Runs a program to its end.
pub fn run(standing: &Standing, text: &str) -> Ran {
    run_while(standing, text, async |_, _| {})
}

/// What a program has printed so far.
pub struct Printed(Arc<Listener>);

impl Printed {
    /// Standard output so far.
    pub fn text(&self) -> String {
        self.0.heard.lock().unwrap().0.clone()
    }

    /// Waits until the program has printed this; panics after five seconds.
    pub async fn wait_for(&self, text: &str) {
        let waited = async {
            while !self.text().contains(text) {
                tokio::time::sleep(std::time::Duration::from_millis(1)).await;
            }
        };
        let limit = std::time::Duration::from_secs(5);
        tokio::time::timeout(limit, waited).await.unwrap();
    }
}

/// Runs a program to its end, and `meanwhile` beside it.
pub fn run_while(
    standing: &Standing,
    text: &str,
    meanwhile: impl AsyncFnOnce(&Supervisor, &Printed),
) -> Ran {
    let model = Arc::new(RobotModel::built_in(standing.model).unwrap());
    let mut state = RobotState::at_start(JointPositions(standing.q), 0.004);
    state.tcp_offset = RpyPose::from_array(standing.tcp);
    state.digital_in = standing.digital_in;
    let sizes = RingCapacities {
        records: None,
        ..RingCapacities::default()
    };
    let (motion, script) = motion_channel(sizes, &state);
    let listener = Arc::new(Listener::default());
    let timeline = Arc::new(Still(Mutex::new(StillArm {
        end: motion,
        state,
        commands: Vec::new(),
        blend_cycles: standing.blend_cycles,
        on_their_way: Vec::new(),
    })));
    let end = ScriptChannels::from(script);
    let robot = Robot::new(model, end, timeline.clone(), listener.clone())
        .with_safety_bounds(standing.safety_bounds.clone());
    let supervisor = Supervisor::new(TaskSettings {
        robot: Arc::new(robot),
        observer: listener.clone(),
        permissions: standing.permissions.clone(),
        task_folder: elite_runtime::task_folder::TaskFolder::new("/tasks"),
        seed: 0,
        fieldbus: Arc::default(),
        panel: Arc::new(Panel::new(Operator::Absent)),
        faults: supervision::ThreadSupervisor::default(),
        extras: elite_runtime::Instrumentation::default(),
        course: elite_runtime::external::InputMode::Live,
    });
    let program = ProgramText {
        name: "test.script".into(),
        text: text.into(),
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let end = runtime.block_on(async {
        supervisor.submit(program, "a test").await.unwrap();
        meanwhile(&supervisor, &Printed(listener.clone())).await;
        supervisor.ended().await.unwrap()
    });
    let (printed, log, error, report) = std::mem::take(&mut *listener.heard.lock().unwrap());
    let held = std::mem::take(&mut *listener.held.lock().unwrap());
    let commands = std::mem::take(&mut timeline.0.lock().unwrap().commands);
    Ran {
        end,
        printed,
        log,
        error,
        report,
        chinese: std::mem::take(&mut *listener.chinese.lock().unwrap()),
        error_at: *listener.error_at.lock().unwrap(),
        commands,
        held,
        places: std::mem::take(&mut *listener.places.lock().unwrap()),
    }
}
