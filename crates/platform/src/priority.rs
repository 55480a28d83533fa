//! What makes a thread wake on time: its priority, and memory that stays where it is.

/// The nice value of favoured threads.
pub const FAVOURED: i32 = -10;

/// Has the calling thread, and every thread that it starts from then on, get the processor before ordinary ones;
/// processes that they start have the value of before. One that was started with another nice value than 0 keeps it:
/// that was somebody's wish. Gives whether that is so now.
///
/// # Errors
/// What the system said, or that it has no such values for threads.
pub fn favour() -> Result<bool, String> {
    imp::favour()
}

#[cfg(target_os = "linux")]
pub(crate) use imp::no_favour;

/// Gives the calling thread a real-time priority, 1 to 99: nothing with a lower one runs while it wants to.
///
/// # Errors
/// What the system said, or that it has no such priorities.
pub fn set_fifo_priority(priority: u8) -> std::io::Result<()> {
    imp::fifo(priority)
}

/// Keeps the memory of the process that is mapped now from being moved to disk.
///
/// # Errors
/// What the system said, or that it cannot.
pub fn lock_memory() -> std::io::Result<()> {
    imp::lock_memory()
}

#[cfg(target_os = "linux")]
mod imp {
    use std::io;

    use nix::sys::mman::{MlockAllFlags, mlockall};
    use thread_priority::{
        Error, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };

    use std::sync::atomic::{AtomicBool, Ordering};

    use super::FAVOURED;

    static FAVOURS: AtomicBool = AtomicBool::new(false);

    /// Sets the nice value of the calling thread.
    fn set_nice(value: i32) -> std::io::Result<()> {
        #[allow(unsafe_code, reason = "no safe crate of ours has this call")]
        // SAFETY: the call takes three numbers and touches no memory. The first is PRIO_PROCESS, whose type differs
        // between C libraries; of the second Linux makes the calling thread.
        let status = unsafe { libc::setpriority(0, 0, value) };
        match status {
            0 => Ok(()),
            _ => Err(std::io::Error::last_os_error()),
        }
    }

    pub(super) fn favour() -> Result<bool, String> {
        #[allow(unsafe_code, reason = "no safe crate of ours has this call")]
        // SAFETY: the call takes two numbers and touches no memory; they are those of `set_nice`.
        let now = unsafe { libc::getpriority(0, 0) };
        if now != 0 {
            return Ok(now == FAVOURED);
        }
        set_nice(FAVOURED).map_err(|error| crate::error_text(&error))?;
        FAVOURS.store(true, Ordering::Relaxed);
        Ok(true)
    }

    /// Takes it back, in a process between fork and exec: one system call, no memory.
    pub(crate) fn no_favour() {
        if FAVOURS.load(Ordering::Relaxed) {
            // To be nicer is always allowed.
            let _ = set_nice(0);
        }
    }

    pub(super) fn fifo(priority: u8) -> io::Result<()> {
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let value = ThreadPriority::try_from(priority.min(99)).map_err(io::Error::other)?;
        set_thread_priority_and_policy(thread_native_id(), value, policy).map_err(|error| {
            match error {
                Error::OS(code) => io::Error::from_raw_os_error(code),
                other => io::Error::other(format!("{other:?}")),
            }
        })
    }

    pub(super) fn lock_memory() -> io::Result<()> {
        // Only what is mapped now. Locking future mappings too would make unrelated allocations fail where the limit on
        // locked memory is small.
        Ok(mlockall(MlockAllFlags::MCL_CURRENT)?)
    }
}

#[cfg(not(target_os = "linux"))]
mod imp {
    pub(super) fn favour() -> Result<bool, String> {
        Err(crate::needs_linux("a nice value for threads").to_string())
    }

    pub(super) fn fifo(_: u8) -> std::io::Result<()> {
        Err(crate::needs_linux("a FIFO priority"))
    }

    pub(super) fn lock_memory() -> std::io::Result<()> {
        Err(crate::needs_linux("locking memory"))
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::process::Command;

    #[allow(clippy::unwrap_used, reason = "helpers of tests")]
    fn nice_of_this_thread() -> i32 {
        let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
        // Behind the name, which may have blanks: the value is the 19th field.
        let fields = stat.rsplit_once(')').unwrap().1;
        fields.split_whitespace().nth(16).unwrap().parse().unwrap()
    }

    #[test]
    fn threads_are_favoured_and_their_processes_are_not() {
        let before = nice_of_this_thread();
        let favoured = std::thread::spawn(|| {
            let favoured = super::favour();
            let thread = std::thread::spawn(nice_of_this_thread).join().unwrap();
            let mut command = Command::new("nice");
            crate::processes::kill_with_parent(&mut command).unwrap();
            let output = command.output().unwrap();
            let process = String::from_utf8(output.stdout).unwrap();
            (favoured, thread, process.trim().parse::<i32>().unwrap())
        });
        let (favoured, thread, process) = favoured.join().unwrap();
        match favoured {
            Ok(true) => assert_eq!((thread, process), (super::FAVOURED, before)),
            // Started with another value, or not allowed.
            Ok(false) | Err(_) => assert_eq!((thread, process), (before, before)),
        }
        assert_eq!(
            nice_of_this_thread(),
            before,
            "only that thread and its own"
        );
    }
}
