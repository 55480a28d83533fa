//! One run of the program: a controller of its own, whose program is held by a probe. A session that steps back gives
//! one run up and starts the next.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};

use controller::options::{ClockChoice, RecordTarget};
use controller::recorded_run::RecordedRun;
use controller::rerun::RerunController;
use controller::{Controller, ControllerConfig, PreparedController, StartOptions};
use elite_runtime::message::{Message, Observer, Severity};
use elite_runtime::{Instrumentation, Preset, ProgramText};
use messages::{Language, Text, text};
use motion_api::ProgramId;
use supervision::{ThreadHandle, ThreadRole, ThreadSupervisor};

use super::breakpoints::Breakpoints;
use super::probe::ProbeFactory;
use super::run_channel::{Purpose, RunChannel, RunCommand, RunEvent, SessionEvent};
use super::run_position::Intervention;

/// Who sends the program, for messages about it.
const SENDER: &str = "the debugger";
/// Orders that may wait for a held program.
const ORDERS_MAX: usize = 1024;

/// What is run.
#[derive(Clone)]
pub struct RunTarget {
    /// The program.
    pub program: ProgramText,
    /// The robot; its clock is taken as virtual.
    pub robot: ControllerConfig,
    /// Globals that the program finds set.
    pub presets: Vec<Preset>,
    /// The recorded run that the program is part of, which is repeated; robot and presets are then those of the
    /// recording.
    pub recorded: Option<RecordedProgram>,
}

/// A program of a recorded run.
#[derive(Clone)]
pub struct RecordedProgram {
    /// The run.
    pub run: Arc<RecordedRun>,
    /// The program.
    pub program: ProgramId,
}

/// A run that was started.
pub(crate) struct Run {
    pub(crate) link: Arc<RunChannel>,
    orders: SyncSender<RunCommand>,
    thread: Option<ThreadHandle<()>>,
    /// Others have started this run: it goes on when this session gives it up.
    is_another: bool,
}

/// What a run is started with, beside the program.
pub(crate) struct RunStart {
    pub generation: u64,
    pub purpose: Purpose,
    pub interventions: Vec<Intervention>,
    pub stop_at_end: bool,
    pub seen: u64,
    pub breakpoints: Arc<Breakpoints>,
    pub events: SyncSender<SessionEvent>,
}

impl Run {
    /// Starts the program on a thread. What keeps it from starting is told as an event.
    ///
    /// # Errors
    /// The operating system gives no thread.
    pub(crate) fn start(
        faults: &ThreadSupervisor,
        what: &RunTarget,
        start: RunStart,
    ) -> std::io::Result<Self> {
        let (orders, receiver) = sync_channel(ORDERS_MAX);
        let is_first = matches!(start.purpose, Purpose::Run { .. });
        let link = Arc::new(RunChannel {
            generation: start.generation,
            is_attached: false,
            is_driven: AtomicBool::new(true),
            program: what.recorded.as_ref().map(|recorded| recorded.program),
            is_muted: AtomicBool::new(!is_first),
            purpose: start.purpose,
            interventions: start.interventions,
            stop_at_end: start.stop_at_end,
            breakpoints: start.breakpoints.into(),
            changes: AtomicU64::new(0),
            pause: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
            is_stopping: AtomicBool::new(false),
            said: AtomicU64::new(0),
            seen: AtomicU64::new(start.seen),
            line: AtomicU32::new(0),
            column: AtomicU32::new(0),
            world: OnceLock::new(),
            events: Box::new(move |note| start.events.send(note).is_ok()),
            orders: Some(receiver).into(),
        });
        let (shared, mut what) = (link.clone(), what.clone());
        what.robot.clock = ClockChoice::Virtual;
        if !is_first {
            // Only the first run is recorded: the others are repetitions of it.
            what.robot.record = RecordTarget::Off;
        }
        let body = move || {
            if let Err(error) = run(&shared, what) {
                shared.tell(RunEvent::Output {
                    category: "stderr",
                    text: text!(
                        "the program cannot be started: {error}\n",
                        "无法启动程序：{error}\n"
                    ),
                    line: 0,
                });
                shared.tell(RunEvent::Ended(None));
            }
        };
        let thread = faults.start(ThreadRole::Service, "debugged run", body)?;
        Ok(Self {
            link,
            orders,
            thread: Some(thread),
            is_another: false,
        })
    }

    /// A run that others have started.
    pub(crate) fn attached(link: Arc<RunChannel>, orders: SyncSender<RunCommand>) -> Self {
        Self {
            link,
            orders,
            thread: None,
            is_another: true,
        }
    }

    /// Gives an order to a held program; false where it takes none: it has ended, or too many wait.
    pub(crate) fn order(&self, order: RunCommand) -> bool {
        self.orders.try_send(order).is_ok()
    }

    /// Asks for a running program to be held.
    pub(crate) fn pause(&self) {
        self.link.pause.store(true, Ordering::Release);
    }

    /// Says what it is to be held for from now on.
    pub(crate) fn set_breakpoints(&self, breakpoints: Arc<Breakpoints>) {
        *self.link.breakpoints.lock() = breakpoints;
        self.link.changes.fetch_add(1, Ordering::AcqRel);
    }

    /// What the program says from now on is new to the client; how much it has said so far.
    pub(crate) fn forget_what_follows(&self) -> u64 {
        let said = self.link.said.load(Ordering::Acquire);
        self.link.seen.store(said, Ordering::Release);
        said
    }

    /// Has the program stopped, wherever it is: its clean-up runs, and its end is told.
    pub(crate) fn stop(&self) {
        self.link.is_stopping.store(true, Ordering::Release);
        // A program that runs looks at the flag.
        let _ = self.orders.try_send(RunCommand::Stop);
    }

    /// Nobody wants it any more. It ends by itself, soon.
    pub(crate) fn give_up(mut self) -> Option<ThreadHandle<()>> {
        self.link.is_over.store(!self.is_another, Ordering::Release);
        self.thread.take()
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        if !self.is_another {
            self.link.is_over.store(true, Ordering::Release);
        }
    }
}

fn run(link: &Arc<RunChannel>, what: RunTarget) -> Result<(), Box<dyn std::error::Error>> {
    if let Some(recorded) = &what.recorded {
        return repeat(link, recorded);
    }
    let prepared = PreparedController::new(&what.robot, StartOptions::for_single_run())?;
    let teller = Arc::new(OutputObserver(link.clone()));
    let extras = Instrumentation {
        debug: Some(Arc::new(ProbeFactory(link.clone()))),
        ..Instrumentation::default()
    };
    let controller = prepared.start_with_timeline(teller, extras, |timeline| timeline)?;
    show_world(link, &controller);
    controller.supervisor().set_presets(&what.presets);
    let end = controller.run_to_end(what.program, SENDER, std::future::pending());
    let fault = controller.faults().fatal().map(ToString::to_string);
    controller.shut_down();
    if let Some(fault) = fault {
        link.tell(RunEvent::Output {
            category: "stderr",
            text: text!(
                "the controller met a fault of its own: {fault}\n",
                "控制器遇到自身缺陷：{fault}\n"
            ),
            line: 0,
        });
    }
    link.tell(RunEvent::Ended(end?));
    Ok(())
}

/// Lets breakpoints ask for the parts of the cell.
fn show_world(link: &RunChannel, controller: &Controller) {
    if let Some(world) = controller.world() {
        // A run has one controller.
        let _ = link.world.set(world.clone());
    }
}

/// Repeats a recorded run up to the end of the program that is debugged.
fn repeat(
    link: &Arc<RunChannel>,
    recorded: &RecordedProgram,
) -> Result<(), Box<dyn std::error::Error>> {
    let extras = Instrumentation {
        debug: Some(Arc::new(ProbeFactory(link.clone()))),
        ..Instrumentation::default()
    };
    let wanted = link.clone();
    // A run that nobody wants any more ends with the next cycle.
    let look = Box::new(move |_: &_| !wanted.is_over.load(Ordering::Acquire));
    let teller = Arc::new(OutputObserver(link.clone()));
    let repeating = RerunController::start(&recorded.run, teller, extras, look)?;
    show_world(link, repeating.controller());
    let end = repeating.run(&recorded.run, Some(recorded.program));
    let departure = repeating
        .repeat()
        .departure()
        .map(|departure| Text::of(&departure));
    let trouble = departure.or_else(|| repeating.trouble().map(Text::verbatim));
    repeating.shut_down();
    if let Some(trouble) = trouble.filter(|_| !link.is_over.load(Ordering::Acquire)) {
        link.tell(RunEvent::Output {
            category: "stderr",
            text: text!(
                "the program has left the recording: {trouble}\n",
                "程序偏离了记录：{trouble}\n"
            ),
            line: 0,
        });
    }
    link.tell(RunEvent::Ended(end?));
    Ok(())
}

/// Passes on what people are to see.
struct OutputObserver(Arc<RunChannel>);

impl OutputObserver {
    fn say(&self, category: &'static str, text: Text, line: u32) {
        let link = &self.0;
        let number = link.said.fetch_add(1, Ordering::AcqRel) + 1;
        let is_known = number <= link.seen.load(Ordering::Acquire);
        if is_known || link.is_muted.load(Ordering::Acquire) || link.is_over.load(Ordering::Acquire)
        {
            return;
        }
        let line = match line {
            0 => link.line.load(Ordering::Relaxed),
            line => line,
        };
        link.tell(RunEvent::Said(number, category, text, line));
    }
}

impl Observer for OutputObserver {
    fn message(&self, message: &Message) {
        let origin = match message {
            Message::Print { origin, .. } | Message::Log { origin, .. } => Some(origin.program),
            Message::ScriptError { program, .. } => Some(*program),
            Message::Robot { .. } => None,
        };
        // Of other programs of a recorded run nothing is said.
        let is_of_another = |program: ProgramId| {
            program != ProgramId(0) && self.0.program.is_some_and(|own| own != program)
        };
        if origin.is_some_and(is_of_another) {
            return;
        }
        match message {
            Message::Print { origin, text } => {
                self.say("stdout", Text::verbatim(text.clone()), origin.line)
            }
            Message::Log {
                severity,
                origin,
                text,
            } => {
                let category = match severity {
                    Severity::Info => "console",
                    Severity::Warning | Severity::Error => "stderr",
                };
                self.say(category, text!("{text}\n", "{text}\n"), origin.line);
            }
            Message::ScriptError { line, report, .. } => {
                let [english, chinese] = [Language::English, Language::Chinese]
                    .map(|language| format!("{}\n", report.in_language(language).trim_end()));
                self.say("stderr", Text::new(english, chinese), *line);
            }
            Message::Robot { text, .. } => self.say("stderr", text!("{text}\n", "{text}\n"), 0),
        }
    }
}
