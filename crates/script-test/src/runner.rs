//! One test: a controller of its own, the test beside whatever program it starts, and what became of it.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use controller::cell_world::facts::WorldFacts;
use controller::clearance::{ClearanceObserver, collision_scene};
use controller::condition::Condition;
use controller::options::{ClockChoice, RecordTarget};
use controller::outcome::ResultCollector;
use controller::program_position::PositionTracker;
use controller::{Controller, ControllerConfig, PreparedController, ProgramOutcome, StartOptions};
use elite_runtime::message::Observer;
use elite_runtime::{
    Instrumentation, LineCountsByText, ProgramText, Supervisor, TaskState, TestTaskConfig,
};
use messages::{Language, Text, text};
use motion_api::{ProgramId, RobotState, Seconds};
use recorder::CycleMessage;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::discover::TestCase;
use crate::files::FileScope;
use crate::golden_path::GoldenMode;
use crate::lockstep::LockstepTimeline;
use crate::simulated_peers::PeerRegistry;
use crate::test_context::{ContextParts, Invariant, InvariantCheck, RunnerRequest, TestContext};
use crate::test_object::functions;
use crate::trace::{CycleTrace, Mover, TestCommands, TraceObserver};

/// What the text of a test holds that asks for distances.
const CLEARANCE: &str = "clearance";
/// Who the sender of programs is, for messages.
const SENDER: &str = "the test";
/// Time between two looks whether a test is stuck.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// A test or a program that was stopped has so long to end.
const ENDING_MAX: Duration = Duration::from_secs(10);
const ENDING_POLL: Duration = Duration::from_micros(50);
/// Cycles that a condition is judged by at a time.
const CYCLES_AT_ONCE: usize = 2000;

/// Simulated time that a test has where nobody says otherwise, s.
pub const TIMEOUT_S: f64 = 60.0;
/// Time of the machine without simulated time that it has.
pub const WALL_TIMEOUT: Duration = Duration::from_secs(30);

/// The usual simulated time.
pub fn usual_timeout() -> Seconds {
    // The constant is above 0 and bounded, so the default of zero is never taken.
    Seconds::new(TIMEOUT_S).unwrap_or_default()
}

/// What every test is run with.
#[derive(Clone)]
pub(crate) struct TestPlan {
    pub config: ControllerConfig,
    pub files: FileScope,
    pub goldens: GoldenMode,
    /// Simulated time of a test.
    pub timeout: Seconds,
    /// Time of the machine without simulated time passing.
    pub wall_timeout: Duration,
    /// Counters of executed lines, if lines are counted.
    pub counts: Option<Arc<Mutex<LineCountsByText>>>,
    /// Path for the recording of a failed test.
    pub recording: Option<PathBuf>,
    /// Nobody waits for the result any more.
    pub stop: Arc<AtomicBool>,
}

/// How a test went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The test ended without a failure.
    Passed,
    /// The test failed.
    Failed,
    /// The test could not be run.
    Error,
}

impl Status {
    /// The word for it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Error => "error",
        }
    }
}

/// What became of a test.
#[derive(Clone, Debug)]
pub struct TestResult {
    /// The test that was run.
    pub case: TestCase,
    /// How it went.
    pub status: Status,
    /// What went wrong, in a line or a few; empty when it passed.
    pub message: Text,
    /// The whole report: the message with places, the call stack and both sides of what was compared.
    pub report: Text,
    /// The line of the test that failed; of one that passed the line of the function.
    pub line: u32,
    /// Simulated time, s.
    pub time: f64,
    /// Time of the machine.
    pub wall: Duration,
    /// Seed of the test.
    pub seed: u64,
    /// Simulated time that it had, where that was not the usual.
    pub timeout: Option<Seconds>,
    /// Time of the machine without simulated time that it had, where that was not the usual.
    pub wall_timeout: Option<Duration>,
    /// What it printed.
    pub prints: Vec<String>,
    /// The recording that was kept of it.
    pub recording: Option<PathBuf>,
}

/// Runs a test.
pub(crate) fn run(case: &TestCase, plan: &TestPlan) -> TestResult {
    let started = Instant::now();
    let mut result = TestResult {
        case: case.clone(),
        status: Status::Error,
        message: Text::verbatim(""),
        report: Text::verbatim(""),
        line: case.line,
        time: 0.0,
        wall: Duration::ZERO,
        seed: plan.config.seed,
        timeout: Some(plan.timeout).filter(|time| *time != usual_timeout()),
        wall_timeout: Some(plan.wall_timeout).filter(|time| *time != WALL_TIMEOUT),
        prints: Vec::new(),
        recording: None,
    };
    if let Err(sentence) = try_run(case, plan, &mut result) {
        result.status = Status::Error;
        result.report.clone_from(&sentence);
        result.message = sentence;
    }
    if let Some(path) = &plan.recording {
        match result.status {
            // A test that passed is not looked at again; a file that is not there is as good.
            Status::Passed => drop(plan.files.remove_file(path)),
            _ if path.exists() => result.recording = Some(path.clone()),
            _ => {}
        }
    }
    result.wall = started.elapsed();
    result
}

fn try_run(case: &TestCase, plan: &TestPlan, result: &mut TestResult) -> Result<(), Text> {
    let mut config = ControllerConfig {
        clock: ClockChoice::Virtual,
        record: RecordTarget::Off,
        ..plan.config.clone()
    };
    if let Some(path) = &plan.recording {
        config.record = RecordTarget::File(path.clone());
    }
    let (trace, peers) = (
        Arc::new(CycleTrace::default()),
        Arc::new(PeerRegistry::default()),
    );
    let follower = Arc::new(PositionTracker::default());
    let commands = Arc::new(TestCommands::default());
    let tracing: Arc<dyn Observer> = Arc::new(TraceObserver {
        trace: trace.clone(),
        follower: follower.clone(),
        commands: commands.clone(),
    });
    // Distances take time in every cycle: they are measured where the test asks for them.
    let clearance = match case.file.text.contains(CLEARANCE) {
        true => {
            let scene = collision_scene(&config).map_err(|error| Text::of(&error))?;
            Some(Arc::new(ClearanceObserver::new(scene, tracing.clone())))
        }
        false => None,
    };
    let said = Arc::new(ResultCollector::new(match &clearance {
        Some(observer) => observer.clone(),
        None => tracing,
    }));
    let extras = Instrumentation {
        attendant: None,
        stand_ins: Some(peers.clone()),
        line_counts: plan.counts.clone(),
        debug: None,
    };
    let prepared = PreparedController::new(&config, StartOptions::for_single_run())
        .map_err(|error| Text::of(&error))?;
    let mut turns = None;
    let controller = prepared.start_with_timeline(said.clone(), extras, |inner| {
        turns.insert(Arc::new(LockstepTimeline::new(inner))).clone()
    });
    let controller = controller.map_err(|error| Text::of(&error))?;
    follower.connect(controller.robot());
    commands.connect(controller.robot());
    if let Some(world) = controller.world() {
        let trace = trace.clone();
        world.follow(Box::new(move |message| trace.take_world(message)));
    }
    if let Some(observer) = &clearance {
        observer.connect(controller.robot());
        if let Some(world) = controller.world() {
            observer.follow_world(world);
        }
        observer.begin();
    }
    // The closure was called, or the start has failed.
    let turns = turns.ok_or_else(|| text!("the clock was not started", "时钟没有启动"))?;
    let (requests, inbox) = unbounded_channel();
    let folder = case.file.path.parent().unwrap_or(Path::new(""));
    let bench = Arc::new(TestContext::new(ContextParts {
        robot: controller.robot().clone(),
        world: controller.world().cloned(),
        fieldbus: controller.fieldbus().clone(),
        programs: controller.supervisor().clone(),
        said,
        turns: turns.clone(),
        trace,
        clearance,
        peers,
        folder: folder.to_owned(),
        files: plan.files.clone(),
        goldens: plan.goldens,
        requests: requests.clone(),
        timeout: plan.timeout,
    }));
    let weak = Arc::downgrade(&bench);
    turns.do_before_cycles(Box::new(move |cycle| {
        if let Some(bench) = weak.upgrade() {
            bench.before_cycle(cycle);
        }
    }));
    let own = bench.clone();
    let attendant = TestTaskConfig {
        object: Some(crate::OBJECT),
        methods: Arc::new(move |attendance| functions(&own, attendance)),
        has_company: turns.program_flag().clone(),
    };
    let told = Arc::new(ResultCollector::new(Arc::new(TestTaskObserver {
        requests,
        commands,
    })));
    let tests = controller
        .supervisor()
        .test_supervisor(told.clone(), attendant);
    bench.set_supervisor(tests.clone());
    let broken = Runner {
        bench: &bench,
        tests: &tests,
        wall_timeout: plan.wall_timeout,
        stop: &plan.stop,
        config: &config,
        watched: Vec::new(),
    }
    .run(case, inbox)?;
    let end = ended(&tests)?;
    bench.programs.stop();
    ended(&bench.programs)?;
    conclude(case, result, &bench, &told, end, broken);
    drop((tests, bench, turns));
    shut_down(controller);
    Ok(())
}

fn shut_down(controller: Controller) {
    // A recording that was cut short has been told of in the log.
    controller.shut_down();
}

/// Waits until nothing runs any more; the outcome of the last program, if there was one.
fn ended(supervisor: &Supervisor) -> Result<Option<ProgramOutcome>, Text> {
    let since = Instant::now();
    loop {
        let status = supervisor.status();
        if status.state == TaskState::Stopped {
            return Ok(status.end.as_ref().map(ProgramOutcome::from));
        }
        if since.elapsed() > ENDING_MAX {
            let text = text!(
                "a program was stopped and has not ended within {} s",
                "程序被停止，{} s 内没有结束",
                ENDING_MAX.as_secs()
            );
            return Err(text);
        }
        thread::sleep(ENDING_POLL);
    }
}

/// The error of the program under test, which may be why the test failed, unless the test has said so itself.
fn error_of_program(bench: &TestContext, report: &Text) -> Option<Text> {
    let last = bench.close(None)?;
    let error = last.error?;
    if report.english().contains(error.english()) {
        return None;
    }
    let end = match last.outcome {
        ProgramOutcome::Ended => text!("ended", "结束"),
        ProgramOutcome::Failed => text!("failed", "失败"),
        ProgramOutcome::Stopped => text!("was stopped", "被停止"),
        ProgramOutcome::ProtectiveStop => {
            text!("ended by a protective stop", "因保护性停止而结束")
        }
        ProgramOutcome::EmergencyStop => text!("ended by an emergency stop", "因紧急停止而结束"),
        ProgramOutcome::Timeout => text!("did not end in its time", "没有按时结束"),
    };
    let head = match last.line {
        Some(line) => text!(
            "the program under test {end} in line {line}: {error}",
            "被测程序在第 {line} 行{end}：{error}"
        ),
        None => text!(
            "the program under test {end}: {error}",
            "被测程序{end}：{error}"
        ),
    };
    let report = last.report.unwrap_or(Text::fixed("", ""));
    let report = in_each_language(&report, |report| {
        report.lines().map(|line| format!("  {line}\n")).collect()
    });
    Some(text!("{head}\n{report}", "{head}\n{report}"))
}

/// What became of the test.
fn conclude(
    case: &TestCase,
    result: &mut TestResult,
    bench: &TestContext,
    told: &ResultCollector,
    end: Option<ProgramOutcome>,
    broken: Option<(u32, Text)>,
) {
    result.time = bench.robot.state().time;
    let end = end.unwrap_or(ProgramOutcome::Failed);
    let said = told.result(end, result.time, None);
    result.prints = said.prints;
    result.status = Status::Failed;
    let error = said.error.unwrap_or_else(|| end_of_test(end));
    let lines = case.file.text.lines().count() as u32;
    if let Some(reason) = bench.abort_reason() {
        result.message = text!("timeout: {reason}", "超时：{reason}");
        result.report.clone_from(&result.message);
        result.line = said.line.filter(|line| *line <= lines).unwrap_or(case.line);
    } else if end == ProgramOutcome::Failed {
        result.line = said.line.filter(|line| *line <= lines).unwrap_or(case.line);
        let report = said.report.unwrap_or(Text::fixed("", ""));
        result.report = in_each_language(&report, |report| without_call(report, case, lines));
        result.message = match help_of(&result.report) {
            Some(help) => text!("{error} ({help})", "{error}（{help}）"),
            None => error,
        };
        // What was watched and did not hold is often why an assertion at the end fails.
        if let Some((line, sentence)) = broken {
            let report = &result.report;
            result.report = text!(
                "{report}line {line}: {sentence}\n",
                "{report}第 {line} 行：{sentence}\n"
            );
        }
    } else if let Some((line, sentence)) = broken {
        result.line = line;
        result.message = text!("AssertionError: {sentence}", "AssertionError: {sentence}");
        result.report.clone_from(&result.message);
    } else if end == ProgramOutcome::Ended {
        result.status = Status::Passed;
    } else {
        result.message = error;
        result.report.clone_from(&result.message);
    }
    if result.status != Status::Passed
        && let Some(text) = error_of_program(bench, &result.report)
    {
        let report = &result.report;
        result.report = match report.english().ends_with('\n') {
            true => text!("{report}{text}", "{report}{text}"),
            false => text!("{report}\n{text}", "{report}\n{text}"),
        };
    }
}

/// How a test ended that said nothing itself.
fn end_of_test(end: ProgramOutcome) -> Text {
    match end {
        ProgramOutcome::Ended => text!("the test ended", "测试结束"),
        ProgramOutcome::Failed => text!("the test failed", "测试失败"),
        ProgramOutcome::Stopped => text!("the test stopped", "测试被停止"),
        ProgramOutcome::ProtectiveStop => {
            text!("the test protective_stop", "测试因保护性停止而结束")
        }
        ProgramOutcome::EmergencyStop => text!("the test emergency_stop", "测试因紧急停止而结束"),
        ProgramOutcome::Timeout => text!("the test timeout", "测试超时"),
    }
}

/// A change of a text, made to its form in each language.
pub(crate) fn in_each_language(text: &Text, change: impl Fn(&str) -> String) -> Text {
    let [english, chinese] =
        [Language::English, Language::Chinese].map(|language| change(text.in_language(language)));
    Text::new(english, chinese)
}

/// What a report says in its line of advice: the values on both sides of an `assert`.
fn help_of(report: &Text) -> Option<Text> {
    let help = in_each_language(report, |report| {
        let mut lines = report.lines().filter_map(|l| l.strip_prefix("  help: "));
        lines.next().unwrap_or_default().to_owned()
    });
    (!help.is_empty()).then_some(help)
}

/// The report without the call of the test, which is not in its file.
fn without_call(report: &str, case: &TestCase, lines: u32) -> String {
    let head = format!("  {}, line ", case.file.path.display());
    let mut kept = String::new();
    let mut rest = report.lines().peekable();
    while let Some(line) = rest.next() {
        let number = line
            .strip_prefix(&head)
            .and_then(|rest| rest.split(',').next()?.parse::<u32>().ok());
        if number.is_some_and(|number| number > lines) {
            // The text of the line and its mark.
            while rest.next_if(|line| line.starts_with("    ")).is_some() {}
            continue;
        }
        kept.push_str(line);
        kept.push('\n');
    }
    kept
}

/// Does for a test what only another thread can.
struct Runner<'r> {
    bench: &'r Arc<TestContext>,
    tests: &'r Supervisor,
    wall_timeout: Duration,
    stop: &'r AtomicBool,
    /// The settings of the robot, for conditions that ask for distances.
    config: &'r ControllerConfig,
    /// Conditions, and how many cycles each has been judged by.
    watched: Vec<(Invariant, Condition, JudgedCycles)>,
}

impl Runner<'_> {
    /// Runs the test to its end; a condition that did not hold, with its line.
    fn run(
        mut self,
        case: &TestCase,
        mut inbox: UnboundedReceiver<RunnerRequest>,
    ) -> Result<Option<(u32, Text)>, Text> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|error| Text::of(&error))?;
        let text = format!(
            "{}\n{}()\n",
            case.file.text.trim_end_matches('\n'),
            case.name
        );
        let program = ProgramText {
            name: case.file.path.display().to_string(),
            text,
        };
        runtime.block_on(async {
            let tests = self.tests.clone();
            let submitting = tests.submit(program, SENDER);
            tokio::pin!(submitting);
            let mut is_submitted = false;
            let (mut seen, mut since) = (0, Instant::now());
            loop {
                tokio::select! {
                    biased;
                    request = inbox.recv() => match request {
                        Some(RunnerRequest::Start(program, reply)) => self.start(program, &reply).await,
                        Some(RunnerRequest::Watch(watched, reply)) => {
                            // Whoever asked waits for it.
                            let _ = reply.send(self.watch(watched));
                        }
                        Some(RunnerRequest::Ended) | None => break,
                    },
                    submitted = &mut submitting, if !is_submitted => {
                        is_submitted = true;
                        submitted.map_err(|error| Text::of(&error))?;
                    }
                    () = tokio::time::sleep(LOOK_EVERY) => {
                        if self.stop.load(Ordering::Relaxed) {
                            self.bench.abort(text!(
                                "nobody waits for the test any more",
                                "不再有人等待这个测试"
                            ));
                        }
                        let now = self.bench.turns.cycles();
                        if now != seen {
                            (seen, since) = (now, Instant::now());
                        } else if since.elapsed() > self.wall_timeout {
                            self.give_up_stuck();
                        }
                    }
                }
            }
            Ok::<(), Text>(())
        })?;
        Ok(self.check_remaining())
    }

    fn give_up_stuck(&self) {
        let wall = self.wall_timeout.as_secs_f64();
        self.bench.abort(text!(
            "no simulated time passed for {wall} s: something computes without waiting (--wall-timeout)",
            "{wall} s 内没有仿真时间流逝：有程序只计算而不等待（--wall-timeout）"
        ));
    }

    /// Starts a program; it has come to its first wait, or is gone, when the test hears of it.
    async fn start(&self, program: ProgramText, reply: &SyncSender<Result<(), Text>>) {
        let turns = &self.bench.turns;
        let before = turns.programs_joined();
        let started = self.bench.programs.submit(program, SENDER).await;
        if started.is_ok() {
            let since = Instant::now();
            // A secondary program is not waited for by who submits it; until it has come nobody would give it a turn.
            while !turns.wait_for_program(before, LOOK_EVERY) && since.elapsed() < ENDING_MAX {}
            while !self.bench.turns.wait_until_program_blocks(LOOK_EVERY) {
                if since.elapsed() > self.wall_timeout {
                    self.give_up_stuck();
                    // What computes on without end cannot be waited for, either.
                    if since.elapsed() > self.wall_timeout + ENDING_MAX {
                        break;
                    }
                }
            }
        }
        let started = started.map(drop).map_err(|error| Text::of(&error));
        // A test that has gone does not hear it.
        let _ = reply.send(started);
    }

    fn watch(&mut self, watched: Invariant) -> InvariantCheck {
        let condition = match Condition::new("condition", &watched.text) {
            Ok(condition) => condition,
            Err(error) => return InvariantCheck::NoCondition(Text::of(&error)),
        };
        let world = self.bench.world.as_ref();
        condition.set_world(world.map(|world| WorldFacts::new(world.description())));
        if condition.uses_clearance() {
            match collision_scene(self.config) {
                Ok(scene) => condition.set_scene(scene),
                Err(error) => return InvariantCheck::NoCondition(Text::of(&error)),
            }
        }
        let mut judged = JudgedCycles::default();
        match check_invariant(&self.bench.trace, &watched, &condition, &mut judged) {
            Ok(None) => {
                self.watched.push((watched, condition, judged));
                InvariantCheck::Kept
            }
            Ok(Some(sentence)) => InvariantCheck::Broken(sentence),
            Err(sentence) => InvariantCheck::NoCondition(sentence),
        }
    }

    /// Judges what came after conditions were asked for.
    fn check_remaining(&mut self) -> Option<(u32, Text)> {
        let trace = &self.bench.trace;
        let mut watched = self.watched.iter_mut();
        watched.find_map(|(watched, condition, judged)| {
            match check_invariant(trace, watched, condition, judged) {
                Ok(broken) => Some((watched.line, broken?)),
                Err(sentence) => Some((watched.line, sentence)),
            }
        })
    }
}

/// How far a condition has been judged.
#[derive(Clone, Copy, Default)]
struct JudgedCycles {
    cycles: usize,
    world_messages: usize,
}

/// Looks at the cycles that a condition has not been judged by; what is wrong, if something is.
fn check_invariant(
    trace: &CycleTrace,
    watched: &Invariant,
    condition: &Condition,
    judged: &mut JudgedCycles,
) -> Result<Option<Text>, Text> {
    loop {
        let (states, missed) = trace.since(judged.cycles, CYCLES_AT_ONCE);
        if states.is_empty() && missed > 0 {
            return Err(text!(
                "the test is too long for conditions: {missed} cycles were not kept",
                "测试对条件来说太长：有 {missed} 个周期没有保留"
            ));
        }
        if states.is_empty() {
            return Ok(None);
        }
        for state in &states {
            let cycle = CycleMessage::from(state);
            if condition.uses_world() {
                judged.world_messages =
                    trace.each_world_message(judged.world_messages, state.cycle, |message| {
                        condition.advance_world(message);
                    });
            }
            let mover = trace.mover_at(judged.cycles);
            let holds = condition.holds(&cycle, &mover.program);
            judged.cycles += 1;
            if holds.map_err(|error| Text::of(&error))? != watched.always {
                let mut parts = broken(watched, state, &cycle, &mover);
                if let Some(part) = condition.deciding_part() {
                    parts.push(text!("part {part:?}", "工件 {part:?}"));
                }
                if let Some((a, b, distance)) = condition.nearest_pair() {
                    parts.push(text!(
                        "{a} was {distance:.1} mm from {b}",
                        "{a}与{b}相距 {distance:.1} mm",
                        distance = distance * 1e3
                    ));
                }
                return Ok(Some(Text::joined(parts, "; ", "；")));
            }
        }
    }
}

/// What did not hold, where, and the values of what the condition names.
fn broken(
    watched: &Invariant,
    state: &RobotState,
    cycle: &CycleMessage,
    mover: &Mover,
) -> Vec<Text> {
    let what = match watched.always {
        true => text!(
            "always: `{}` did not hold",
            "always：`{}` 不成立",
            watched.text
        ),
        false => text!("never: `{}` held", "never：`{}` 成立", watched.text),
    };
    let place = match (mover.test_line, mover.program.line) {
        (0, 0) => Text::verbatim(""),
        (0, line) => text!(", line {line} of the program", "，程序第 {line} 行"),
        (line, _) => text!(", line {line} of the test", "，测试第 {line} 行"),
    };
    let mut parts = vec![text!(
        "{what} at {:.3} s, cycle {}{place}",
        "{what}，时刻 {:.3} s，周期 {}{place}",
        state.time,
        state.cycle
    )];
    let named = cycle.fields().into_iter().filter(|(name, _)| {
        let words = |c: char| !(c.is_alphanumeric() || c == '_');
        watched.text.split(words).any(|word| word == *name)
    });
    for (name, value) in named {
        let shown = match value {
            recorder::FieldValue::Unsigned(x) => x.to_string(),
            recorder::FieldValue::Number(x) => format!("{x}"),
            recorder::FieldValue::Numbers(values) => {
                let values: Vec<String> = values.iter().map(|x| format!("{x:.4}")).collect();
                format!("[{}]", values.join(", "))
            }
            recorder::FieldValue::Text(text) => text.to_owned(),
        };
        parts.push(text!("{name} was {shown}", "{name} 为 {shown}"));
    }
    parts
}

/// Says which program the test is, and that it has ended.
struct TestTaskObserver {
    requests: UnboundedSender<RunnerRequest>,
    commands: Arc<TestCommands>,
}

impl Observer for TestTaskObserver {
    fn program_started(&self, program: ProgramId, _: &str, _: &str) {
        self.commands.set_test(program);
    }

    fn program_ended(&self, _: ProgramId) {
        // Nobody listens once it has been said.
        let _ = self.requests.send(RunnerRequest::Ended);
    }
}
