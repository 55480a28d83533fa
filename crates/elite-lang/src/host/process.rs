//! Processes that the host starts for programs. No operation waits: who has to is woken by the host.

use std::fmt::Debug;
use std::fs::File;
use std::io;
use std::rc::Rc;

use super::ThreadId;

/// Where a standard stream of a process goes.
#[derive(Debug)]
pub enum StdioTarget {
    /// Where the controller's own goes; for input: nothing.
    Inherit,
    /// Nowhere.
    Null,
    /// To the program.
    Pipe,
    /// Into a file.
    File(File),
    /// Errors only: where the output goes.
    WithOutput,
}

/// A process to start.
#[derive(Debug)]
pub struct ProcessCommand {
    /// The program and its arguments; at least one.
    pub words: Vec<String>,
    /// The folder that the process runs in.
    pub folder: Option<String>,
    /// Environment of the process, if not the controller's.
    pub environment: Option<Vec<(String, String)>>,
    /// Standard input.
    pub input: StdioTarget,
    /// Standard output.
    pub output: StdioTarget,
    /// Standard error.
    pub errors: StdioTarget,
}

/// The processes that programs may start and signal.
#[allow(clippy::missing_errors_doc)]
pub trait HostProcesses {
    /// Starts a process. It is killed at the end of the task, with what it has started.
    fn spawn(&self, command: ProcessCommand) -> io::Result<Rc<dyn HostProcess>>;
    /// Sends a signal to any process.
    fn signal(&self, process: i32, signal: i32) -> io::Result<()>;
    /// Sends a signal to a group of processes.
    fn signal_group(&self, group: i32, signal: i32) -> io::Result<()>;
    /// Numbers of the controller's process, its parent, user, effective user, group and effective group.
    fn identity(&self) -> [u32; 6];
}

/// An output of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputStream {
    /// Standard output.
    Output,
    /// Standard error.
    Errors,
}

/// A process that was started with pipes to the program where it asked for them. Dropping it does not end it.
#[allow(clippy::missing_errors_doc)]
pub trait HostProcess: Debug {
    /// The number that the system gives the process.
    fn number(&self) -> i32;
    /// The exit code of the process, or minus the signal that ended it; None while it runs.
    fn exit_status(&self) -> Option<i32>;
    /// Sends it a signal; one that has ended gets none.
    fn signal(&self, signal: i32) -> io::Result<()>;
    /// Takes what it has written; empty at the end, `WouldBlock` while there is nothing.
    fn read(&self, stream: OutputStream, most: usize) -> io::Result<Vec<u8>>;
    /// Gives it input; `WouldBlock` while there is no room.
    fn write(&self, data: &[u8]) -> io::Result<usize>;
    /// The end of its input.
    fn close_input(&self);
    /// Counts what has happened: output, room for input, its end.
    fn news(&self) -> u64;
    /// Wakes the thread (`Host::wake`) at the next news; asked for before each wait.
    fn watch(&self, thread: ThreadId);
}
