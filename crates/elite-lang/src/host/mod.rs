//! Everything a program can reach beyond itself.

use std::io;
use std::net::SocketAddr;
use std::rc::Rc;

use crate::interpreter::ScriptThread;

pub mod files;
pub mod process;

use files::HostFiles;
use process::HostProcesses;

/// Number of a script thread within its interpreter; the first is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ThreadId(pub u64);

/// Parts of the surroundings that a program may reach only if the embedder permits it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Capability {
    /// Files and folders.
    Files,
    /// Starting processes, and signals.
    Processes,
    /// Environment variables.
    Environment,
    /// The network.
    Network,
}

impl Capability {
    /// The word for it on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Capability::Files => "fs",
            Capability::Processes => "process",
            Capability::Environment => "env",
            Capability::Network => "net",
        }
    }
}

/// What ends the clean-up of a thread that is being stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CleanupLimit {
    /// The clean-up has computed for as long as it may.
    Time,
    /// The clean-up would have to wait.
    Wait,
}

/// What the embedder provides: output, time, randomness. The evaluator itself reads no clock and opens no file, so a
/// program under a deterministic host is deterministic.
pub trait Host {
    /// `print` was called; `text` ends as the call says, normally with a newline.
    fn print(&self, thread: ThreadId, text: &str);

    /// Seconds since 1970-01-01T00:00:00Z, for `time.time()` and `datetime`.
    fn unix_time(&self) -> f64;

    /// Seconds of a clock that never goes back, for `time.monotonic()`, `sleep` and timeouts.
    fn monotonic(&self) -> f64;

    /// Random bits, for seeding `random`.
    fn random_u64(&self) -> u64;

    /// Takes over a thread that the program has started (`threading.Thread.start`): resume it soon, and go on until it
    /// has ended.
    ///
    /// # Errors
    /// Why no more threads can be started.
    fn start(&self, _thread: ScriptThread) -> Result<(), String> {
        Err("threads cannot be started here".to_owned())
    }

    /// Whether the running thread may sleep and wait for other threads.
    ///
    /// # Errors
    /// Why it may not.
    fn may_wait(&self) -> Result<(), String> {
        Ok(())
    }

    /// Whether a thread that is being stopped may compute on in its `finally` and `with` blocks. Asked now and then,
    /// after some thousand safepoints.
    fn unwinding_goes_on(&self) -> bool {
        true
    }

    /// A `finally` or `with` block of a thread that is being stopped is ended before its end, at a line of the program.
    fn unwinding_is_cut(&self, _thread: ThreadId, _line: u32, _cut: CleanupLimit) {}

    /// A thread that is parked (`Step::Parked`) has become ready: resume it soon.
    fn wake(&self, thread: ThreadId);

    /// Whether programs may reach this part of the surroundings.
    fn permits(&self, _access: Capability) -> bool {
        false
    }

    /// The environment variables, asked for only if they are permitted.
    fn environment(&self) -> Vec<(String, String)> {
        Vec::new()
    }

    /// The files, asked for only if they are permitted.
    fn files(&self) -> Option<&dyn HostFiles> {
        None
    }

    /// How to start processes, asked for only if that is permitted.
    fn processes(&self) -> Option<&dyn HostProcesses> {
        None
    }

    /// A new TCP socket, asked for only if the network is permitted.
    ///
    /// # Errors
    /// The system's, or that there are too many.
    fn open_socket(&self) -> io::Result<Rc<dyn HostSocket>> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// What a thread waits for at a socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interest {
    /// Data, the end of the stream, or a connection to accept.
    Read,
    /// Room for data.
    Write,
    /// The end of `connect`.
    Connect,
}

/// A TCP socket of the host. No operation waits: what cannot be done yet is `WouldBlock`. Closed when dropped.
pub trait HostSocket {
    /// Begins to connect to a host, by name or address.
    ///
    /// # Errors
    /// If the socket is in use already.
    fn connect(&self, host: &str, port: u16) -> io::Result<()>;

    /// How connecting went; `WouldBlock` while it goes on.
    ///
    /// # Errors
    /// Why there is no connection.
    fn connect_result(&self) -> io::Result<()>;

    /// Gives it an address of this machine; port 0 means any.
    ///
    /// # Errors
    /// The system's.
    fn bind(&self, host: &str, port: u16) -> io::Result<()>;

    /// Waits for connections from now on.
    ///
    /// # Errors
    /// The system's.
    fn listen(&self, backlog: u32) -> io::Result<()>;

    /// The next connection.
    ///
    /// # Errors
    /// The system's, or that there are too many sockets.
    fn accept(&self) -> io::Result<(Rc<dyn HostSocket>, SocketAddr)>;

    /// Reads what is there; 0 bytes are the end.
    ///
    /// # Errors
    /// The system's.
    fn read(&self, buffer: &mut [u8]) -> io::Result<usize>;

    /// Writes what there is room for.
    ///
    /// # Errors
    /// The system's.
    fn write(&self, data: &[u8]) -> io::Result<usize>;

    /// Ends reading, writing or both, for the peer to see.
    ///
    /// # Errors
    /// The system's.
    fn shutdown(&self, how: std::net::Shutdown) -> io::Result<()>;

    /// Closes it; further operations fail.
    fn close(&self);

    /// Sends small packets at once.
    ///
    /// # Errors
    /// The system's.
    fn set_nodelay(&self, on: bool) -> io::Result<()>;

    /// The address that the socket itself has.
    ///
    /// # Errors
    /// If it has none.
    fn local_address(&self) -> io::Result<SocketAddr>;

    /// The address of its peer.
    ///
    /// # Errors
    /// If it has none.
    fn peer_address(&self) -> io::Result<SocketAddr>;

    /// Wakes `thread` (`Host::wake`) once `interest` may be served; asked for before each wait.
    fn watch(&self, thread: ThreadId, interest: Interest);
}
