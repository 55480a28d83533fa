//! Places in a run. A run of a program under the virtual clock is the same every time, so a number names a place in it.

/// Where a run stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// What the debugger has heard of so far: statements, exceptions, cycles.
    pub moment: u64,
    /// Statements so far.
    pub tick: u64,
    /// Cycles so far.
    pub cycle: u64,
}

/// Where a run is to be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeekTarget {
    /// Before this statement.
    Tick(u64),
    /// At this moment.
    Moment(u64),
    /// Before the cycle after this one passes.
    Cycle(u64),
    /// At the end of the program.
    End,
}

/// What a client has changed in a run, which is done again when the run is repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervention {
    /// When, see [`Position::moment`].
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
