//! What builtins see of the task they run in.
//!
//! Owns the wait table and the requests that a builtin cannot carry out itself because a script thread is running while
//! it makes them (start a thread, stop a thread): the scheduler does them after the current slice.

use std::cell::{Cell, RefCell, RefMut};
use std::collections::{BTreeMap, BTreeSet};
use std::io;

use std::rc::Rc;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use elite_lang::debug::PendingEval;
use elite_lang::{NativeCall, NodeCursor, Raised, Value, WaitToken};
use io_bus::{Fieldbus, ScriptSocket};
use motion_api::{CommandId, CommandKind, Origin, ProgramId, ThreadNumber};
use platform::sockets::LocalStream;
use thiserror::Error;

use super::deferred::{DeferredEffects, Effect};
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

/// Most script threads of one task, the main thread not counted.
pub(crate) const THREADS_MAX: usize = 20;

/// Calls of builtins in the `finally` and `with` blocks of a task that is being stopped. The language bounds what its
/// own work costs there; a call may cost far more than one step of that.
const CALLS_OF_UNWINDING: u32 = 20 * CALLS_PER_SAMPLE - 1;
/// What `finally` and `with` blocks of a stopped program may compute, in seconds of the real clock.
const CLEAN_UP: f64 = 0.5;
/// Length of a clean-up where no time passes: looks, each after 4096 steps, which take about 0.3 ms.
const LOOKS_OF_CLEAN_UP: u32 = 1500;
/// Calls of builtins during a clean-up that see the robot of one cycle, as all calls within a turn of a thread do.
const CALLS_PER_SAMPLE: u32 = 256;

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
    /// Calls of builtins that threads may still make while they unwind; `None` while nothing was told to stop.
    unwinding: Cell<Option<u32>>,
    /// What clean-up behind a stop may still compute: looks, and until when.
    looks_of_clean_up: Cell<u32>,
    clean_up_until: Cell<Option<f64>>,
    /// What the program before has left moving.
    braking: RefCell<Option<HandoverStop>>,
    extras: Instrumentation,
    /// The task has to do with machines outside of this process.
    uses_real_network: Cell<bool>,
    /// Motions whose calls have returned before they ended, each with its thread.
    queued_motions: RefCell<Vec<(ThreadNumber, CommandId)>>,
    /// Motions of threads that have ended, on their way to their blends.
    left_behind: RefCell<Vec<CommandId>>,
    /// The latest command that moves the arm on when its call has returned, and whose it is.
    steering: Cell<Option<(ThreadNumber, CommandId)>>,
    /// Changes of points that wait for the blend zone of a motion: which, and how many so far.
    changes_ahead: Cell<(CommandId, usize)>,
    /// What is seen when the arm has caught up.
    deferred: RefCell<DeferredEffects>,
    /// The last change of an output register by each thread that was ahead of the arm.
    register_changes: RefCell<BTreeMap<ThreadNumber, CommandId>>,
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

#[derive(Default)]
struct ThreadTable {
    last: u32,
    alive: BTreeSet<ThreadNumber>,
    to_start: Vec<ThreadStart>,
    to_stop: Vec<ThreadNumber>,
}

/// A thread that is to be started.
pub(crate) struct ThreadStart {
    pub number: ThreadNumber,
    pub function: Value,
    pub args: Vec<Value>,
    /// Where in the pendant's task the thread begins.
    pub node: NodeCursor,
}

/// What is known about a handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ThreadLookup {
    /// The thread runs or is about to.
    Running,
    /// There was such a thread.
    Ended,
    /// There never was.
    Unknown,
}

/// More script threads than [`THREADS_MAX`] were to run at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("Thread over the max size: {}", THREADS_MAX)]
pub(crate) struct ThreadCountError;

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
            unwinding: Cell::default(),
            looks_of_clean_up: Cell::new(LOOKS_OF_CLEAN_UP),
            clean_up_until: Cell::default(),
            braking: RefCell::new(braking),
            extras: settings.extras.clone(),
            uses_real_network: Cell::default(),
            queued_motions: RefCell::default(),
            left_behind: RefCell::default(),
            steering: Cell::default(),
            changes_ahead: Cell::default(),
            deferred: RefCell::default(),
            register_changes: RefCell::default(),
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

    /// The call of a motion returns before it has ended.
    pub fn add_queued_motion(&self, id: CommandId) {
        let mut ahead = self.queued_motions.borrow_mut();
        ahead.retain(|(_, id)| {
            let has_ended = self.robot.has_ended(*id);
            if has_ended {
                // Nobody asks for the outcome of such a command.
                self.robot.forget(*id);
            }
            !has_ended
        });
        ahead.push((self.running.get().number, id));
    }

    /// Counts a change of a point that is sent ahead of the arm; how many there are now for that motion.
    pub fn count_change_ahead(&self, motion: CommandId) -> usize {
        let (of, count) = self.changes_ahead.get();
        let count = if of == motion { count + 1 } else { 1 };
        self.changes_ahead.set((motion, count));
        count
    }

    /// Shows something: now, or, where the running thread is ahead of the arm, when that enters the blend zone of the
    /// thread's last motion. False when as much waits for that as may.
    pub fn show(&self, effect: &Effect) -> bool {
        // What waits for a motion that has just ended comes first.
        self.show_due_effects();
        let motion = self.last_ahead();
        let Some(motion) = motion.filter(|motion| !self.robot.has_ended(*motion)) else {
            effect.show(&*self.observer, &self.panel);
            return true;
        };
        let mut deferred = self.deferred.borrow_mut();
        if deferred.is_full(motion) {
            return false;
        }
        deferred.add(self.running.get().number, motion, effect);
        true
    }

    /// Shows what waits for motions that have ended.
    pub fn show_due_effects(&self) {
        self.show_effects_if(|motion| self.robot.has_ended(motion));
    }

    /// Shows what waits for motions that are `over`.
    pub fn show_effects_if(&self, over: impl Fn(CommandId) -> bool) {
        let show = |effect: &Effect| effect.show(&*self.observer, &self.panel);
        self.deferred.borrow_mut().show_if(over, show);
    }

    /// A thread is stopped before the arm has caught up with it.
    pub fn drop_effects(&self, thread: ThreadNumber) {
        self.deferred.borrow_mut().drop_of(thread);
    }

    /// Level of a flag as the running thread sees it.
    pub fn flag(&self, number: u8) -> bool {
        let own = self
            .deferred
            .borrow()
            .flag(self.running.get().number, number);
        own.unwrap_or_else(|| self.panel.flag(number))
    }

    /// The running thread has changed an output register ahead of the arm.
    pub fn note_register_change(&self, id: CommandId) {
        let number = self.running.get().number;
        self.register_changes.borrow_mut().insert(number, id);
    }

    /// The running thread's last change of an output register that was ahead of the arm, told once.
    pub fn take_register_change(&self) -> Option<CommandId> {
        let number = self.running.get().number;
        self.register_changes.borrow_mut().remove(&number)
    }

    /// A thread has ended whose last motions are still on their way to their blends.
    pub fn leave_ahead(&self, thread: ThreadNumber) {
        let left = self.take_ahead(thread);
        self.left_behind.borrow_mut().extend(left);
    }

    /// The first motion on its way whose thread has ended: the next one waits for its call, which nobody waits for any
    /// more.
    pub fn first_left_behind(&self) -> Option<CommandId> {
        let mut left = self.left_behind.borrow_mut();
        left.retain(|id| {
            let has_ended = self.robot.has_ended(*id);
            if has_ended {
                self.robot.forget(*id);
            }
            !has_ended
        });
        left.first().copied()
    }

    /// A command of the running thread moves the arm on when its call has returned, until something ends it.
    pub fn note_steering(&self, kind: &CommandKind, id: CommandId) {
        let steers = matches!(
            kind,
            CommandKind::ServoJ { .. } | CommandKind::SpeedJ { .. } | CommandKind::SpeedL { .. }
        );
        if steers {
            self.steering.set(Some((self.running.get().number, id)));
        }
    }

    /// The command with which a thread that ends moves the arm on.
    pub fn take_steering(&self, thread: ThreadNumber) -> Option<CommandId> {
        let (number, id) = self.steering.get()?;
        (number == thread).then(|| {
            self.steering.set(None);
            id
        })
    }

    /// The last of the running thread's motions whose calls have returned before they ended.
    pub fn last_ahead(&self) -> Option<CommandId> {
        let running = self.running.get().number;
        let ahead = self.queued_motions.borrow();
        let mut own = ahead.iter().filter(|(thread, _)| *thread == running);
        own.next_back().map(|(_, id)| *id)
    }

    /// The first of these motions, if it has ended: somebody has waited for that.
    pub fn take_ended_ahead(&self) -> Option<CommandId> {
        let running = self.running.get().number;
        let mut ahead = self.queued_motions.borrow_mut();
        let first = ahead.iter().position(|(thread, _)| *thread == running)?;
        let (_, id) = ahead[first];
        self.robot.has_ended(id).then(|| ahead.remove(first).1)
    }

    /// Whether a motion is one whose call has returned already.
    pub fn is_queued_motion(&self, id: CommandId) -> bool {
        self.queued_motions
            .borrow()
            .iter()
            .any(|(_, other)| *other == id)
            || self.left_behind.borrow().contains(&id)
    }

    /// The motions of a thread that is stopped.
    pub fn take_ahead(&self, thread: ThreadNumber) -> Vec<CommandId> {
        let mut ahead = self.queued_motions.borrow_mut();
        let (own, others): (Vec<_>, Vec<_>) = ahead.drain(..).partition(|(t, _)| *t == thread);
        *ahead = others;
        own.into_iter().map(|(_, id)| id).collect()
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
    pub fn run_wait_hook(&self, native: &mut NativeCall<'_>) -> Result<bool, Raised> {
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

    /// Said by the scheduler when all threads of the task are about to unwind.
    pub fn begin_unwinding(&self) {
        self.unwinding.set(Some(CALLS_OF_UNWINDING));
        self.clean_up_begins();
    }

    /// Said when a single thread unwinds: what it may compute counts from here, unless the whole task does.
    pub fn thread_unwinds(&self) {
        if self.unwinding.get().is_none() {
            self.clean_up_begins();
        }
    }

    fn clean_up_begins(&self) {
        self.looks_of_clean_up.set(LOOKS_OF_CLEAN_UP);
        // Simulated time does not pass meanwhile, and a run that is repeated ends where it did.
        let is_measured = self.repeat().is_none() && !self.robot.timeline().is_virtual();
        let until = || self.robot.latest().time + CLEAN_UP;
        self.clean_up_until.set(is_measured.then(until));
    }

    /// Whether a task that unwinds may call no more builtins.
    pub fn has_called_enough(&self) -> bool {
        self.unwinding.get() == Some(0)
    }

    /// Whether `finally` and `with` blocks of a stopped program may compute on; asked every few thousand steps of
    /// theirs.
    pub fn may_clean_up(&self) -> bool {
        let left = self.looks_of_clean_up.get();
        self.looks_of_clean_up.set(left.saturating_sub(1));
        let is_late = |until| self.robot.latest().time >= until;
        left > 0 && !self.clean_up_until.get().is_some_and(is_late)
    }

    /// Counts a call of a builtin; false when a task that unwinds may make no more.
    pub fn count_call(&self) -> bool {
        match self.unwinding.get() {
            None => true,
            Some(left) => {
                let left_then = left.saturating_sub(1);
                self.unwinding.set(Some(left_then));
                if left_then > 0 && left_then.is_multiple_of(CALLS_PER_SAMPLE) {
                    self.robot.look();
                    let text = "clean-up behind a stop called very many functions".to_owned();
                    self.note(ExternalInputKind::Unrecorded(text));
                }
                left > 0
            }
        }
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

    /// Takes a number for a new thread; it starts after the current slice.
    pub fn start_thread(
        &self,
        function: Value,
        args: Vec<Value>,
        node: NodeCursor,
    ) -> Result<ThreadNumber, ThreadCountError> {
        let number = self.take_number()?;
        self.threads.borrow_mut().to_start.push(ThreadStart {
            number,
            function,
            args,
            node,
        });
        Ok(number)
    }

    /// A number for a new thread, which counts as alive from now on.
    pub fn take_number(&self) -> Result<ThreadNumber, ThreadCountError> {
        let mut threads = self.threads.borrow_mut();
        if threads.alive.len() >= THREADS_MAX {
            return Err(ThreadCountError);
        }
        threads.last += 1;
        let number = ThreadNumber(threads.last);
        threads.alive.insert(number);
        Ok(number)
    }

    /// The thread is stopped after the current slice.
    pub fn request_thread_stop(&self, number: ThreadNumber) {
        self.threads.borrow_mut().to_stop.push(number);
    }

    pub fn find_thread(&self, number: ThreadNumber) -> ThreadLookup {
        let threads = self.threads.borrow();
        if threads.alive.contains(&number) {
            ThreadLookup::Running
        } else if number.0 >= 1 && number.0 <= threads.last {
            ThreadLookup::Ended
        } else {
            ThreadLookup::Unknown
        }
    }

    /// Whether another script thread runs, or is about to.
    pub fn has_other_threads(&self) -> bool {
        let running = self.running_thread();
        self.threads
            .borrow()
            .alive
            .iter()
            .any(|thread| *thread != running)
    }

    /// What the slice asked for: threads to start.
    pub fn take_starts(&self) -> Vec<ThreadStart> {
        std::mem::take(&mut self.threads.borrow_mut().to_start)
    }

    /// What the slice asked for: threads to stop.
    pub fn take_stops(&self) -> Vec<ThreadNumber> {
        std::mem::take(&mut self.threads.borrow_mut().to_stop)
    }

    /// A thread has ended.
    pub fn thread_ended(&self, number: ThreadNumber) {
        self.threads.borrow_mut().alive.remove(&number);
    }
}
