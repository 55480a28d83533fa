//! Places in a run. A run of a program under the virtual clock is the same every time, so a number names a place in it.

/// Position of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// What the debugger has heard of so far: statements, exceptions, cycles.
    pub moment: u64,
    /// Statements so far.
    pub tick: u64,
    /// Cycles so far.
    pub cycle: u64,
}

/// Position at which a run is to be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeekTarget {
    /// Held before this statement.
    Tick(u64),
    /// Held at this moment.
    Moment(u64),
    /// Held before the cycle after this one passes.
    Cycle(u64),
    /// Held at the end of the program.
    End,
}

/// What a client has changed in a run, which is done again when the run is repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervention {
    /// Moment of the intervention, see [`Position::moment`].
    pub moment: u64,
    /// The thread in whose call it was done.
    pub thread: u32,
    /// The call, counted from the innermost one.
    pub call: usize,
    /// What was executed.
    pub text: String,
    /// Executing the text may wait and move the arm.
    pub may_move: bool,
}
