//! What builtins see of the task they run in.
//!
//! Owns the wait table and the requests that a builtin cannot carry out itself because a script thread is running while
//! it makes them (start a thread, stop a thread): the scheduler does them after the current slice.

mod ahead;
mod clean_up;
mod thread_table;

use std::cell::{Cell, RefCell, RefMut};
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use elite_lang::debug::PendingEval;
use elite_lang::{NativeCall, Unwind, WaitToken};
use io_bus::{Fieldbus, ScriptSocket};
use motion_api::{CommandId, Origin, ProgramId, ThreadNumber};
use platform::sockets::LocalStream;

use self::ahead::AheadOfArm;
use self::clean_up::CleanUp;
pub(crate) use self::thread_table::ThreadLookup;
use self::thread_table::ThreadTable;
use super::handover::HandoverStop;
use super::host::Permissions;
use super::instrumentation::Instrumentation;
use super::jobs::JobSet;
use super::robot_view::RobotView;
use super::scheduler::{TaskEnd, TaskSettings};
use super::wait::{Wait, WaitTable};
use crate::external::{
    AnswerCache, ExternalInput, ExternalInputKind, ExternalInputSink, InputMode, Rerun,
};
use crate::interpreter::InterpreterMode;
use crate::message::Observer;
use crate::micro_line::MicroLines;
use crate::panel::Panel;
use crate::task_folder::TaskFolder;
use crate::test_task::WaitHook;

/// 2026-01-01T00:00:00Z, where simulated time begins.
const VIRTUAL_EPOCH_S: f64 = 1_767_225_600.0;

/// What a program asks of its own task; done after the current slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TaskRequest {
    /// Hold the task.
    Pause,
    /// End the task as a success.
    Halt,
}

/// The task as its builtins see it.
pub(crate) struct TaskContext {
    robot: RobotView,
    observer: Arc<dyn Observer>,
    fieldbus: Arc<Fieldbus>,
    permissions: Permissions,
    task_folder: TaskFolder,
    outside: JobSet,
    sockets: RefCell<BTreeMap<String, Rc<ScriptSocket>>>,
    micro_lines: RefCell<MicroLines>,
    panel: Arc<Panel>,
    interpreter: Arc<InterpreterMode>,
    program: ProgramId,
    requests: RefCell<Vec<TaskRequest>>,
    waits: RefCell<WaitTable>,
    threads: RefCell<ThreadTable>,
    adopted: RefCell<Vec<PendingEval>>,
    running: Cell<CurrentThread>,
    end: Cell<Option<TaskEnd>>,
    warned: RefCell<BTreeSet<String>>,
    clean_up: CleanUp,
    /// What the program before has left moving.
    braking: RefCell<Option<HandoverStop>>,
    extras: Instrumentation,
    /// The task has to do with machines outside of this process.
    uses_real_network: Cell<bool>,
    ahead: AheadOfArm,
    /// Whether what comes from outside is noted, or comes from a recording.
    input_mode: InputMode,
    /// How often the task has looked round.
    turn: Cell<u64>,
    /// Calls of builtins that ask somebody else.
    calls: Cell<u64>,
    memo: RefCell<AnswerCache>,
    /// Waits of such calls that are under way: the turns in which they were over.
    waits_of_calls: RefCell<BTreeMap<ThreadNumber, Vec<u64>>>,
    /// The time of day in this turn.
    clock: Cell<Option<(u64, f64)>>,
    /// A debugger asks something, which is no part of the run.
    in_debugger_evaluation: Cell<bool>,
    /// What a program beside another does while it waits.
    answering: RefCell<Option<Rc<WaitHook>>>,
}

/// The thread that is being resumed right now.
#[derive(Clone, Copy, Default)]
struct CurrentThread {
    number: ThreadNumber,
    bounds: CallRestriction,
}

/// What the script code that runs may not do.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub enum CallRestriction {
    /// The code may wait and move the arm.
    #[default]
    None,
    /// A secondary program may neither wait nor move the arm.
    Secondary,
    /// Code that a debugger evaluates while the program stands may neither wait nor move the arm.
    Inspection,
}

impl TaskContext {
    pub fn new(
        settings: &TaskSettings,
        interpreter: Arc<InterpreterMode>,
        program: ProgramId,
        braking: Option<HandoverStop>,
    ) -> Rc<Self> {
        Rc::new(Self {
            robot: RobotView::new(settings.robot.clone()),
            observer: settings.observer.clone(),
            fieldbus: settings.fieldbus.clone(),
            permissions: settings.permissions.clone(),
            task_folder: settings.task_folder.clone(),
            outside: JobSet::default(),
            sockets: RefCell::default(),
            micro_lines: RefCell::default(),
            panel: settings.panel.clone(),
            interpreter,
            program,
            requests: RefCell::default(),
            waits: RefCell::default(),
            threads: RefCell::default(),
            adopted: RefCell::default(),
            running: Cell::default(),
            end: Cell::default(),
            warned: RefCell::default(),
            clean_up: CleanUp::default(),
            braking: RefCell::new(braking),
            extras: settings.extras.clone(),
            uses_real_network: Cell::default(),
            ahead: AheadOfArm::default(),
            input_mode: settings.course.clone(),
            turn: Cell::default(),
            calls: Cell::default(),
            memo: RefCell::default(),
            waits_of_calls: RefCell::default(),
            clock: Cell::default(),
            in_debugger_evaluation: Cell::default(),
            answering: RefCell::default(),
        })
    }

    /// A connection to who stands in for a machine. Where nobody does, that machine is meant.
    pub fn stand_in(&self, host: &str, port: u16) -> Option<io::Result<LocalStream>> {
        let stand_ins = self.extras.stand_ins.as_ref()?;
        let connected = stand_ins.connect(host, port);
        if connected.is_none() {
            self.mark_real_network();
        }
        connected
    }

    /// Whether somebody stands in for a machine. Where nobody does, that machine is meant.
    pub fn has_stand_in(&self, host: &str, port: u16) -> bool {
        let stand_ins = self.extras.stand_ins.as_ref();
        let known = stand_ins.is_some_and(|stand_ins| stand_ins.simulates(host, port));
        if !known {
            self.mark_real_network();
        }
        known
    }

    /// Whether somebody in this process answers for a machine.
    pub fn has_responder(&self, host: &str, port: u16) -> bool {
        let stand_ins = self.extras.stand_ins.as_ref();
        stand_ins.is_some_and(|stand_ins| stand_ins.answers(host, port))
    }

    /// Somebody out there is waited for from now on: where time-outs were simulated time, they are time of the machine.
    pub fn mark_real_network(&self) {
        if self.extras.stand_ins.is_some() && !self.uses_real_network.replace(true) {
            tokio::time::resume();
        }
    }

    /// What only tests of programs ask for.
    pub fn extras(&self) -> &Instrumentation {
        &self.extras
    }

    /// The robot as the task sees it in this turn.
    pub fn robot(&self) -> &RobotView {
        &self.robot
    }

    /// The recorder of what comes from outside, while there is one.
    pub fn witness(&self) -> Option<&dyn ExternalInputSink> {
        match &self.input_mode {
            InputMode::Recorded(witness) => Some(&**witness),
            InputMode::Live | InputMode::Repeated(_) => None,
        }
    }

    /// The recorded run that is repeated.
    pub fn repeat(&self) -> Option<&Arc<Rerun>> {
        match &self.input_mode {
            InputMode::Repeated(repeat) => Some(repeat),
            InputMode::Live | InputMode::Recorded(_) => None,
        }
    }

    /// Notes something that has come from outside.
    pub fn note(&self, what: ExternalInputKind) {
        if let Some(witness) = self.witness() {
            task_memory::uncounted(|| {
                witness.record(&ExternalInput {
                    program: self.program,
                    turn: self.turn.get(),
                    cycle: self.robot.moment().cycle,
                    what,
                });
            });
        }
    }

    /// The number of the task's current turn: how often the task has looked for news from outside.
    pub fn turn(&self) -> u64 {
        self.turn.get()
    }

    /// Begins the next turn, before the task looks for news from outside; returns its number.
    pub fn next_turn(&self) -> u64 {
        self.turn.set(self.turn.get() + 1);
        self.turn.get()
    }

    /// The number of a call of a builtin that asks somebody else.
    pub fn next_call(&self) -> u64 {
        self.calls.set(self.calls.get() + 1);
        self.calls.get()
    }

    /// The latest answers of builtins that ask somebody else.
    pub fn memo(&self) -> RefMut<'_, AnswerCache> {
        self.memo.borrow_mut()
    }

    /// From now on, records the turns in which waits of the running thread end.
    pub fn log_waits(&self) {
        let mut waits = self.waits_of_calls.borrow_mut();
        waits.insert(self.running.get().number, Vec::new());
    }

    /// The turns in which waits of the running thread have ended since [`TaskContext::log_waits`].
    pub fn take_waits(&self) -> Vec<u64> {
        let mut waits = self.waits_of_calls.borrow_mut();
        waits.remove(&self.running.get().number).unwrap_or_default()
    }

    /// A wait of a thread is over.
    pub fn note_wait_over(&self, thread: ThreadNumber) {
        if let Some(waits) = self.waits_of_calls.borrow_mut().get_mut(&thread) {
            waits.push(self.turn.get());
        }
    }

    /// A debugger asks something, which is no part of the run.
    pub fn is_aside(&self) -> bool {
        self.in_debugger_evaluation.get()
    }

    /// Runs `work` as such.
    pub fn unrecorded<T>(&self, work: impl FnOnce() -> T) -> T {
        let before = self.in_debugger_evaluation.replace(true);
        let done = work();
        self.in_debugger_evaluation.set(before);
        done
    }

    pub fn set_answering(&self, answering: Rc<WaitHook>) {
        self.answering.replace(Some(answering));
    }

    /// Answers whoever waits for this program, which waits itself; false where nobody ever does.
    pub fn run_wait_hook(&self, native: &mut NativeCall<'_>) -> Result<bool, Unwind> {
        let answering = self.answering.borrow().clone();
        answering.map_or(Ok(false), |answer| answer(native))
    }

    pub fn observer(&self) -> &dyn Observer {
        &*self.observer
    }

    /// Modbus devices, serial ports and the controller's own Modbus values.
    pub fn fieldbus(&self) -> &Arc<Fieldbus> {
        &self.fieldbus
    }

    /// Where tasks are kept.
    pub fn task_folder(&self) -> &TaskFolder {
        &self.task_folder
    }

    /// What the program may reach beyond the robot.
    pub fn permissions(&self) -> &Permissions {
        &self.permissions
    }

    /// The waits on the outside world.
    pub fn outside(&self) -> &JobSet {
        &self.outside
    }

    /// The script sockets of this task by name.
    pub fn sockets(&self) -> &RefCell<BTreeMap<String, Rc<ScriptSocket>>> {
        &self.sockets
    }

    /// The micro-line files this task has loaded.
    pub fn micro_lines(&self) -> &RefCell<MicroLines> {
        &self.micro_lines
    }

    pub fn panel(&self) -> &Panel {
        &self.panel
    }

    /// Statements of interpreter mode.
    pub fn interpreter(&self) -> &Arc<InterpreterMode> {
        &self.interpreter
    }

    /// Seconds since 1970-01-01T00:00:00Z; under the virtual clock simulated time since [`VIRTUAL_EPOCH_S`]. Where it
    /// is noted it is the same for a whole turn, which is less than a millisecond of work.
    pub fn unix_time(&self) -> f64 {
        let is_repeated_real = self.repeat().is_some_and(|repeat| repeat.is_real());
        if self.robot.timeline().is_virtual() && !is_repeated_real {
            return VIRTUAL_EPOCH_S + self.robot.moment().time;
        }
        let turn = self.turn.get();
        if let Some((_, time)) = self.clock.get().filter(|(at, _)| *at == turn) {
            return time;
        }
        let time = match self.repeat() {
            // What only a debugger asks for is not in the recording.
            Some(repeat) => repeat
                .clock(self.program, turn)
                .or_else(|| self.clock.get().map(|(_, time)| time))
                .unwrap_or(VIRTUAL_EPOCH_S + self.robot.moment().time),
            None => SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0.0, |d| d.as_secs_f64()),
        };
        if self.witness().is_none() && self.repeat().is_none() || self.is_aside() {
            return time;
        }
        self.clock.set(Some((turn, time)));
        self.note(ExternalInputKind::TimeOfDay(time));
        time
    }

    /// Asks something of the whole task.
    pub fn request(&self, request: TaskRequest) {
        self.requests.borrow_mut().push(request);
    }

    /// What was asked since the last call.
    pub fn take_requests(&self) -> Vec<TaskRequest> {
        self.requests.take()
    }

    /// The stop that ends when the arm has come to rest after the program before; `None` once it has.
    pub fn braking(&self) -> Option<CommandId> {
        let stop = self.braking.borrow().as_ref().map(HandoverStop::stop)?;
        if self.robot.has_ended(stop) {
            drop(self.braking.take());
            return None;
        }
        Some(stop)
    }

    pub fn program(&self) -> ProgramId {
        self.program
    }

    /// The statement at `line` of the thread that runs.
    pub fn origin(&self, line: u32) -> Origin {
        Origin {
            program: self.program,
            thread: self.running.get().number,
            line,
        }
    }

    /// True while a secondary program runs, or what is bounded like one.
    pub fn is_secondary(&self) -> bool {
        self.bounds() != CallRestriction::None
    }

    /// What the code that runs may not do.
    pub fn bounds(&self) -> CallRestriction {
        self.running.get().bounds
    }

    /// Said by the scheduler before it resumes a thread.
    pub fn set_current_thread(&self, number: ThreadNumber, secondary: bool) {
        let bounds = match secondary {
            true => CallRestriction::Secondary,
            false => CallRestriction::None,
        };
        self.running.set(CurrentThread { number, bounds });
    }

    /// The number of the thread that runs.
    pub fn running_thread(&self) -> ThreadNumber {
        self.running.get().number
    }

    /// Runs `work` under the bounds of a look at a program that stands.
    pub fn with_inspection_bounds<T>(&self, work: impl FnOnce() -> T) -> T {
        let running = self.running.get();
        self.running.set(CurrentThread {
            bounds: CallRestriction::Inspection,
            ..running
        });
        let done = work();
        self.running.set(running);
        done
    }

    /// Drives an evaluation of a debugger from now on.
    pub fn adopt(&self, aside: PendingEval) {
        self.adopted.borrow_mut().push(aside);
    }

    /// Evaluations that are to be driven.
    pub fn take_adopted(&self) -> Vec<PendingEval> {
        self.adopted.take()
    }

    /// The task ends after the current slice.
    pub fn end_task(&self, end: TaskEnd) {
        self.end.set(Some(end));
    }

    /// What [`end_task`](Self::end_task) asked for.
    pub fn take_end(&self) -> Option<TaskEnd> {
        self.end.take()
    }

    /// True the first time `what` is warned of in this task.
    pub fn is_first_warning(&self, what: &str) -> bool {
        self.warned.borrow_mut().insert(what.to_owned())
    }

    pub fn register_wait(&self, wait: Wait) -> WaitToken {
        self.waits.borrow_mut().register(wait)
    }

    pub fn wait_of(&self, token: WaitToken) -> Wait {
        self.waits.borrow().get(token)
    }

    pub fn end_wait(&self, token: WaitToken) {
        self.waits.borrow_mut().remove(token);
    }
}
