//! Other processes: started so that they end with this one, signalled, and found with all that they have started.
//!
//! Owns the system's table of processes and the calls around it; who belongs to whom is decided by whoever asks. Only
//! Linux lets one process look after all of its descendants, orphans included, so elsewhere none is started for a
//! program.

use std::collections::BTreeMap;
use std::io;
use std::process::{Command, ExitStatus, Stdio};

/// One line of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProcessEntry {
    /// Number of the process that has it.
    pub parent: i32,
    /// Number of its group.
    pub group: i32,
    /// Number of its session.
    pub session: i32,
    /// The process has ended, and its parent has not asked how.
    pub ended: bool,
}

/// The part of the system's table that descends from this process, by number.
pub type ProcessTable = BTreeMap<i32, ProcessEntry>;

/// Processes that a signal is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalTarget {
    /// One process.
    Process(i32),
    /// All of a group.
    Group(i32),
}

/// Numbers of this process, its parent, and of who runs it: user and group, each real and effective.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// This process.
    pub process: u32,
    /// The one that started it.
    pub parent: u32,
    /// The user, real and effective.
    pub users: [u32; 2],
    /// The group, real and effective.
    pub groups: [u32; 2],
}

pub use imp::{
    adopt_orphans, identity, kill, kill_with_parent, process_table, reap, send_signal,
    set_process_group, signal_of,
};

/// The exit code of a process, the negative number of the signal that ended it, or -1.
pub fn exit_code(status: ExitStatus) -> i32 {
    let by_signal = || signal_of(status).map(|signal| -signal);
    status.code().or_else(by_signal).unwrap_or(-1)
}

/// What this process writes into, for the errors of another one.
///
/// # Errors
/// The system gives no more handles.
pub fn clone_stdout() -> io::Result<Stdio> {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd as _;
        Ok(io::stdout().as_fd().try_clone_to_owned()?.into())
    }
    #[cfg(windows)]
    {
        use std::os::windows::io::AsHandle as _;
        Ok(io::stdout().as_handle().try_clone_to_owned()?.into())
    }
    #[cfg(not(any(unix, windows)))]
    Ok(Stdio::inherit())
}

/// Limits the addresses that this process may have, and with them its memory: whoever asks for more gets nothing.
///
/// # Errors
/// The system refuses, or has no such limit.
pub fn limit_memory(bytes: u64) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use nix::sys::resource::{Resource, setrlimit};
        Ok(setrlimit(Resource::RLIMIT_AS, bytes, bytes)?)
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = bytes;
        Err(crate::needs_linux("limiting the memory of a process"))
    }
}

/// The reading end of a pipe, for tokio.
#[cfg(all(unix, feature = "net"))]
pub type AsyncPipe = tokio::net::unix::pipe::Receiver;
/// The reading end of a pipe, for tokio: there is none.
#[cfg(all(not(unix), feature = "net"))]
pub type AsyncPipe = tokio::io::Empty;

/// Makes the reading end of a pipe tokio's. Needs a tokio runtime.
///
/// # Errors
/// What the system says, or that it has none.
#[cfg(feature = "net")]
pub fn async_pipe(reader: io::PipeReader) -> io::Result<AsyncPipe> {
    #[cfg(unix)]
    {
        let reader: std::os::fd::OwnedFd = reader.into();
        AsyncPipe::from_owned_fd(reader)
    }
    #[cfg(not(unix))]
    {
        drop(reader);
        Err(crate::needs_linux("reading a pipe beside others"))
    }
}

#[cfg(target_os = "linux")]
mod imp {
    use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};

    use nix::sys::prctl::{set_child_subreaper, set_pdeathsig};
    use nix::sys::signal::{Signal, killpg};
    use nix::sys::wait::{WaitPidFlag, waitpid};
    use nix::unistd::{Pid, getegid, geteuid, getgid, getpid, getppid, getuid};

    use super::{Command, ExitStatus, Identity, ProcessEntry, ProcessTable, SignalTarget, io};

    /// The process gets a group of its own, and is killed when the thread that starts it ends in whatever way. What it
    /// has started itself is not.
    ///
    /// # Errors
    /// Where processes cannot be looked after.
    pub fn kill_with_parent(command: &mut Command) -> io::Result<()> {
        command.process_group(0);
        // SAFETY: the closure runs in the child of a `fork`, where only async-signal-safe functions may be called. It
        // makes two system calls (setpriority, prctl) and turns an error number into an `io::Error`, which does not
        // allocate.
        #[allow(
            unsafe_code,
            reason = "what happens between fork and exec is unsafe in std"
        )]
        unsafe {
            command.pre_exec(|| {
                crate::priority::no_favour();
                Ok(set_pdeathsig(Signal::SIGKILL)?)
            });
        }
        Ok(())
    }

    /// The process gets a group of its own: what a terminal sends to this one does not reach it.
    pub fn set_process_group(command: &mut Command) {
        command.process_group(0);
    }

    /// From now on orphans of descendants become children of this process. An old kernel refuses, and they are found by
    /// their group or session as long as they keep one.
    pub fn adopt_orphans() {
        let _ = set_child_subreaper(true);
    }

    /// Sends a signal; 0 only asks whether anybody is there.
    ///
    /// # Errors
    /// There is no such signal or nobody to send it to, or it is not allowed.
    pub fn send_signal(whom: SignalTarget, signal: i32) -> io::Result<()> {
        let signal = match signal {
            0 => None,
            number => Some(Signal::try_from(number)?),
        };
        match whom {
            SignalTarget::Process(number) => nix::sys::signal::kill(Pid::from_raw(number), signal)?,
            SignalTarget::Group(number) => killpg(Pid::from_raw(number), signal)?,
        }
        Ok(())
    }

    /// Kills. Whoever has ended meanwhile is as good.
    pub fn kill(whom: SignalTarget) {
        let _ = send_signal(whom, Signal::SIGKILL as i32);
    }

    /// The signal that ended a process.
    pub fn signal_of(status: ExitStatus) -> Option<i32> {
        status.signal()
    }

    /// Who this process is.
    pub fn identity() -> Identity {
        let process = |pid: Pid| pid.as_raw().unsigned_abs();
        Identity {
            process: process(getpid()),
            parent: process(getppid()),
            users: [getuid().as_raw(), geteuid().as_raw()],
            groups: [getgid().as_raw(), getegid().as_raw()],
        }
    }

    /// Asks a child that has ended how it ended, so that its number is free again.
    pub fn reap(child: i32) {
        let _ = waitpid(Pid::from_raw(child), Some(WaitPidFlag::WNOHANG));
    }

    /// All descendants; those that end while the table is read may be missing.
    pub fn process_table() -> ProcessTable {
        let own = getpid().as_raw();
        let mut found = ProcessTable::new();
        let mut open = vec![own];
        while let Some(number) = open.pop() {
            let Some(children) = children(number) else {
                // Either the process has just ended, or this system does not tell children: then the whole table is
                // read.
                match number == own {
                    true => return whole_table(),
                    false => continue,
                }
            };
            for child in children {
                if let Some(entry) = entry(child)
                    && found.insert(child, entry).is_none()
                {
                    open.push(child);
                }
            }
        }
        found
    }

    /// The children of all threads of a process.
    fn children(number: i32) -> Option<Vec<i32>> {
        let mut found = Vec::new();
        for thread in std::fs::read_dir(format!("/proc/{number}/task")).ok()? {
            let text = std::fs::read_to_string(thread.ok()?.path().join("children"));
            match text {
                Ok(text) => found.extend(
                    text.split_ascii_whitespace()
                        .filter_map(|n| n.parse::<i32>().ok()),
                ),
                // A thread that has just ended has left its children to another one.
                Err(_) if std::path::Path::new("/proc/thread-self/children").exists() => {}
                Err(_) => return None,
            }
        }
        Some(found)
    }

    fn whole_table() -> ProcessTable {
        let Ok(folder) = std::fs::read_dir("/proc") else {
            return ProcessTable::new();
        };
        folder
            .flatten()
            .filter_map(|found| {
                let number = found.file_name().to_str()?.parse().ok()?;
                Some((number, entry(number)?))
            })
            .collect()
    }

    fn entry(number: i32) -> Option<ProcessEntry> {
        // The file is read as bytes, because a process may have any name.
        parse(&std::fs::read(format!("/proc/{number}/stat")).ok()?)
    }

    /// `4711 (any ) name) S PARENT GROUP SESSION …` (proc_pid_stat(5)).
    fn parse(stat: &[u8]) -> Option<ProcessEntry> {
        let behind_the_name = stat.iter().rposition(|c| *c == b')')? + 1;
        let rest = std::str::from_utf8(&stat[behind_the_name..]).ok()?;
        let mut words = rest.split_ascii_whitespace();
        let state = words.next()?;
        let mut number = || words.next()?.parse().ok();
        Some(ProcessEntry {
            parent: number()?,
            group: number()?,
            session: number()?,
            ended: matches!(state, "Z" | "X"),
        })
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn the_line_of_a_process_is_read_whatever_its_name() {
            let stat = b"4711 (a) S 1 \xff) R 10 20 30 0 -1";
            let entry = ProcessEntry {
                parent: 10,
                group: 20,
                session: 30,
                ended: false,
            };
            assert_eq!(parse(stat), Some(entry));
            let ended = parse(b"1 (x) Z 2 3 4 5");
            assert_eq!(ended.map(|entry| entry.ended), Some(true));
            for wrong in [&b""[..], b"4711", b"1 (x) S", b"1 (x) S a b c"] {
                assert_eq!(parse(wrong), None);
            }
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod imp {
    use super::{Command, ExitStatus, Identity, ProcessTable, SignalTarget, io};

    const WHAT: &str = "starting processes for a program";

    /// Refused: descendants of a process would outlive it.
    ///
    /// # Errors
    /// Always.
    pub fn kill_with_parent(_: &mut Command) -> io::Result<()> {
        Err(crate::needs_linux(WHAT))
    }

    /// The process gets a group of its own: what a terminal sends to this one does not reach it.
    pub fn set_process_group(command: &mut Command) {
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt as _;
            command.process_group(0);
        }
        #[cfg(windows)]
        {
            use std::os::windows::process::CommandExt as _;
            // CREATE_NEW_PROCESS_GROUP
            command.creation_flags(0x200);
        }
        #[cfg(not(any(unix, windows)))]
        let _ = command;
    }

    /// There are none: no process is started.
    pub fn adopt_orphans() {}

    /// Refused.
    ///
    /// # Errors
    /// Always.
    pub fn send(_: SignalTarget, _: i32) -> io::Result<()> {
        Err(crate::needs_linux("sending signals from a program"))
    }

    /// There is nobody to kill.
    pub fn kill(_: SignalTarget) {}

    /// The signal that ended a process.
    pub fn signal_of(status: ExitStatus) -> Option<i32> {
        #[cfg(unix)]
        {
            use std::os::unix::process::ExitStatusExt as _;
            status.signal()
        }
        #[cfg(not(unix))]
        {
            let _ = status;
            None
        }
    }

    /// Who this process is; numbers of users and of the parent are not told.
    pub fn identity() -> Identity {
        Identity {
            process: std::process::id(),
            ..Identity::default()
        }
    }

    /// There are no children.
    pub fn reap(_: i32) {}

    /// There are no children.
    pub fn table() -> ProcessTable {
        ProcessTable::new()
    }
}
