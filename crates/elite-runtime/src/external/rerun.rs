//! A recorded run as its tasks repeat it: what came to them in which turn, and the commands that they are to give.
//!
//! The robot is moved by the recorded commands; what a program gives is compared with them and not carried out. The
//! first departure ends the program: what would follow belongs to another run.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use messages::{Language, Localized, Text, text};
use motion_api::{
    Command, CommandId, CommandKind, DigitalBank, IoChange, Origin, ProgramId, SettingCommand,
};

use super::{ExternalInput, ExternalInputKind, RecordedCall, TaskOrder};

/// A program whose end is not in the recording computes for so many slices at most, seconds of work, while no cycle
/// passes.
const SLICES_WITHOUT_CYCLE_MAX: u32 = 20_000;

/// Where the programs of a repeated run leave what was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Divergence {
    /// The program.
    pub program: ProgramId,
    /// The line of the program that was running; 0 where no single line is to blame.
    pub line: u32,
    /// The cycle before which the difference was seen.
    pub cycle: u64,
    /// What is different, in words.
    pub text: Text,
}

impl Localized for Divergence {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            program,
            line,
            cycle,
            text,
        } = self;
        let told = match line {
            0 => text!(
                "program {} at cycle {cycle}: {text}",
                "程序 {}，周期 {cycle}：{text}",
                program.0
            ),
            _ => text!(
                "program {} at cycle {cycle}, line {line}: {text}",
                "程序 {}，周期 {cycle}，第 {line} 行：{text}",
                program.0
            ),
        };
        told.fmt_in(language, f)
    }
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

/// What the recording has for a call of a builtin that asks somebody else.
pub(crate) enum RecordedAnswer {
    /// The recording leaves the call out, because an earlier one with the same arguments was answered likewise.
    AsBefore,
    /// The recording has an entry for this call.
    So(RecordedCall),
}

/// What came to one program.
#[derive(Default)]
struct ProgramInputs {
    begins: u64,
    /// The last turn of the program; `None` when the recording broke off before its end.
    ends: Option<u64>,
    presets: Vec<String>,
    sees: BTreeMap<u64, u64>,
    orders: BTreeMap<u64, Vec<TaskOrder>>,
    calls: BTreeMap<u64, RecordedCall>,
    woken: BTreeMap<u64, Vec<u64>>,
    clock: BTreeMap<u64, f64>,
    lost: Option<(u64, Text)>,
}

/// How far the repetition is.
#[derive(Default)]
struct RerunProgress {
    commands: BTreeMap<ProgramId, VecDeque<(u64, Command)>>,
    running: Option<ProgramId>,
    /// The latest command that the running program has given.
    given: CommandId,
    commands_given: u64,
    departure: Option<Divergence>,
}

/// A recorded run.
pub struct Rerun {
    is_real: bool,
    last_cycle: u64,
    programs: BTreeMap<ProgramId, ProgramInputs>,
    progress: Mutex<RerunProgress>,
    has_departed: AtomicBool,
    is_over: AtomicBool,
}

impl Rerun {
    /// A run that was recorded under the real clock, or not, up to `last_cycle`; with all that came from outside, and
    /// the commands with the cycles that took them, both in their order.
    pub fn new(
        is_real: bool,
        last_cycle: u64,
        externals: impl IntoIterator<Item = ExternalInput>,
        commands: impl IntoIterator<Item = (u64, Command)>,
    ) -> Self {
        let mut programs: BTreeMap<ProgramId, ProgramInputs> = BTreeMap::new();
        for ExternalInput {
            program,
            turn,
            cycle,
            what,
        } in externals
        {
            let program = programs.entry(program).or_default();
            match what {
                ExternalInputKind::Started { presets } => {
                    program.begins = cycle;
                    program.presets = presets;
                }
                ExternalInputKind::Ends => program.ends = Some(turn),
                ExternalInputKind::CycleObserved => {
                    program.sees.insert(turn, cycle);
                }
                ExternalInputKind::Order(order) => {
                    program.orders.entry(turn).or_default().push(order)
                }
                ExternalInputKind::Call(call) => {
                    program.calls.insert(call.number, call);
                }
                ExternalInputKind::Woken { thread } => {
                    program.woken.entry(turn).or_default().push(thread)
                }
                ExternalInputKind::TimeOfDay(time) => {
                    program.clock.insert(turn, time);
                }
                ExternalInputKind::Unrecorded(text) => {
                    program.lost.get_or_insert((cycle, text));
                }
            }
        }
        let mut progress = RerunProgress::default();
        for (cycle, command) in commands {
            let own = progress.commands.entry(command.origin.program).or_default();
            own.push_back((cycle, command));
        }
        Self {
            is_real,
            last_cycle,
            programs,
            progress: Mutex::new(progress),
            has_departed: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
        }
    }

    /// True when the run was recorded under the real clock.
    pub const fn is_real(&self) -> bool {
        self.is_real
    }

    /// The programs that were begun, with the cycle that each saw first.
    pub fn programs(&self) -> impl Iterator<Item = (ProgramId, u64)> {
        self.programs
            .iter()
            .map(|(id, program)| (*id, program.begins))
    }

    /// The globals that a program found set.
    pub fn presets(&self, program: ProgramId) -> Vec<String> {
        let known = self.programs.get(&program);
        known.map(|known| known.presets.clone()).unwrap_or_default()
    }

    /// The first thing that a program was given and that is not in the recording, with its cycle.
    pub fn lost(&self) -> Option<(ProgramId, u64, &Text)> {
        self.programs.iter().find_map(|(id, program)| {
            let (cycle, text) = program.lost.as_ref()?;
            Some((*id, *cycle, text))
        })
    }

    /// Where the programs have left what was recorded.
    pub fn departure(&self) -> Option<Divergence> {
        self.progress().departure.clone()
    }

    /// How many commands of programs came out the same.
    pub fn commands_given(&self) -> u64 {
        self.progress().commands_given
    }

    /// The recording has no further cycle.
    pub fn finish(&self) {
        self.is_over.store(true, Ordering::Release);
    }

    /// A cycle is to pass: false where the recording has none after the one with this number.
    pub fn allow_cycle_after(&self, cycle: u64) -> bool {
        if cycle >= self.last_cycle {
            self.finish();
        }
        !self.is_over.load(Ordering::Acquire)
    }

    /// The robot is about to be given a recorded command in this cycle: its program must have given it before.
    pub fn is_due(&self, command: &Command, cycle: u64) {
        let mut progress = self.progress();
        let is_missing = progress.running == Some(command.origin.program)
            && progress.given < command.id
            && progress.departure.is_none();
        if is_missing {
            let name = command.kind.name();
            let text = text!(
                "it has not given {name}, which was taken in this cycle",
                "没有发出本周期取走的 {name}"
            );
            self.record_divergence(&mut progress, command.origin, cycle, text);
        }
    }

    pub(crate) fn begins(&self, program: ProgramId) {
        let mut progress = self.progress();
        progress.running = Some(program);
        progress.given = CommandId::NONE;
    }

    pub(crate) fn ended(&self, program: ProgramId, cycle: u64) {
        let mut progress = self.progress();
        progress.running = None;
        let left = progress.commands.get(&program).and_then(|left| {
            // Commands without a line are the task's own, which it gives while the arm comes to rest.
            left.iter().find(|(_, command)| command.origin.line > 0)
        });
        let left = left.map(|(_, command)| *command);
        if let Some(command) = left.filter(|_| !self.is_over() && progress.departure.is_none()) {
            let name = command.kind.name();
            let text = text!(
                "it has ended without giving {name}, which was recorded",
                "已结束，却没有发出记录中的 {name}"
            );
            self.record_divergence(&mut progress, command.origin, cycle, text);
        }
    }

    /// The number of a command that a program gives.
    pub(crate) fn expect(&self, origin: Origin, kind: &CommandKind, cycle: u64) -> CommandId {
        let mut progress = self.progress();
        let queue = progress.commands.entry(origin.program).or_default();
        let next = queue.pop_front();
        let name = kind.name();
        let text = match next {
            Some((taken_in, command))
                if is_same(&command.kind, kind) && command.origin == origin =>
            {
                if taken_in > cycle {
                    progress.given = command.id;
                    progress.commands_given += 1;
                    return command.id;
                }
                text!(
                    "it gives {name} after cycle {taken_in}, which took it in the recording",
                    "在周期 {taken_in} 之后才发出 {name}，记录中该周期已取走它"
                )
            }
            Some((_, command)) if command.kind.name() == name && command.origin == origin => {
                text!(
                    "it gives {name} with other arguments than recorded: {kind:?}, not {:?}",
                    "发出的 {name} 参数与记录不同：{kind:?}，而不是 {:?}",
                    command.kind
                )
            }
            Some((_, command)) => text!(
                "it gives {name} where {} of line {} was recorded",
                "发出了 {name}，记录中为第 {1} 行的 {0}",
                command.kind.name(),
                command.origin.line
            ),
            None => text!(
                "it gives {name}, and nothing more was recorded of it",
                "发出了 {name}，记录中此后没有它的内容"
            ),
        };
        if !self.is_over() {
            self.record_divergence(&mut progress, origin, cycle, text);
        }
        // A number that no command has: it never ends.
        CommandId(u64::MAX)
    }

    fn record_divergence(
        &self,
        progress: &mut RerunProgress,
        origin: Origin,
        cycle: u64,
        text: Text,
    ) {
        let departure = Divergence {
            program: origin.program,
            line: origin.line,
            cycle: cycle + 1,
            text,
        };
        progress.departure.get_or_insert(departure);
        self.has_departed.store(true, Ordering::Release);
    }

    /// Nothing of a program is to go on: it has left the recording, or that is at its end.
    pub(crate) fn is_finished(&self) -> bool {
        self.has_departed.load(Ordering::Acquire) || self.is_over()
    }

    fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Acquire)
    }

    fn program(&self, program: ProgramId) -> Option<&ProgramInputs> {
        self.programs.get(&program)
    }

    /// The cycle that a task sees in this turn, where that does not follow from what it did.
    pub(crate) fn observed_cycle(&self, program: ProgramId, turn: u64) -> Option<u64> {
        self.program(program)?.sees.get(&turn).copied()
    }

    /// Looks whether a program that has this turn, after so many in which no cycle passed, is still what was recorded.
    pub(crate) fn watch(&self, origin: Origin, turn: u64, worked: u32, cycle: u64) {
        match self.program(origin.program).and_then(|known| known.ends) {
            Some(ends) if turn > ends && !self.is_finished() => {
                let text = text!(
                    "it goes on where it had ended when it was recorded",
                    "记录中已结束，这里却继续运行"
                );
                self.record_divergence(&mut self.progress(), origin, cycle, text);
            }
            // The end of the program is not in the recording, which broke off while it computed.
            None if worked > SLICES_WITHOUT_CYCLE_MAX => self.finish(),
            _ => {}
        }
    }

    pub(crate) fn orders(&self, program: ProgramId, turn: u64) -> Vec<TaskOrder> {
        let orders = self
            .program(program)
            .and_then(|known| known.orders.get(&turn));
        orders.cloned().unwrap_or_default()
    }

    pub(crate) fn woken(&self, program: ProgramId, turn: u64) -> &[u64] {
        let woken = self
            .program(program)
            .and_then(|known| known.woken.get(&turn));
        woken.map_or(&[], Vec::as_slice)
    }

    pub(crate) fn clock(&self, program: ProgramId, turn: u64) -> Option<f64> {
        self.program(program)?.clock.get(&turn).copied()
    }

    pub(crate) fn recorded_answer(
        &self,
        program: ProgramId,
        number: u64,
        function: &str,
    ) -> RecordedAnswer {
        let call = self
            .program(program)
            .and_then(|known| known.calls.get(&number));
        match call {
            Some(call) if call.function == function => RecordedAnswer::So(call.clone()),
            None => RecordedAnswer::AsBefore,
            Some(call) => {
                let origin = Origin {
                    program,
                    ..Origin::default()
                };
                let text = text!(
                    "it calls {function}() where {}() was recorded",
                    "调用了 {function}()，记录中为 {}()",
                    call.function
                );
                let mut progress = self.progress();
                self.record_divergence(&mut progress, origin, 0, text);
                RecordedAnswer::AsBefore
            }
        }
    }

    /// Whole at every moment, so a poisoned lock is as good as any.
    fn progress(&self) -> MutexGuard<'_, RerunProgress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Equal, NaN equal to itself, and a change of an output equal to one that waits for a blend zone: the recorded command
/// is the one that is carried out.
fn is_same(a: &CommandKind, b: &CommandKind) -> bool {
    let (a, b) = (made_at_once(a), made_at_once(b));
    a == b || format!("{a:?}") == format!("{b:?}")
}

/// A change of an output without the motion whose blend zone it waits for; other commands as they are.
fn made_at_once(kind: &CommandKind) -> CommandKind {
    match *kind {
        CommandKind::Setting(SettingCommand::SetIoAtZone { change, .. }) => {
            CommandKind::Setting(SettingCommand::SetIo(change))
        }
        CommandKind::Setting(SettingCommand::SetStandardDigitalOut { index, level }) => {
            CommandKind::Setting(SettingCommand::SetIo(IoChange::digital_out(
                DigitalBank::Standard,
                index,
                level,
            )))
        }
        other => other,
    }
}
