//! What makes a thread wake on time: its priority, and memory that stays where it is.

/// Gives the calling thread a real-time priority, 1 to 99: nothing with a lower one runs while it wants to.
///
/// # Errors
/// What the system said, or that it has no such priorities.
pub fn fifo(priority: u8) -> Result<(), String> {
    imp::fifo(priority)
}

/// Keeps the memory of the process that is mapped now from being moved to disk.
///
/// # Errors
/// What the system said, or that it cannot.
pub fn lock_memory() -> Result<(), String> {
    imp::lock_memory()
}

#[cfg(target_os = "linux")]
mod imp {
    use nix::sys::mman::{MlockAllFlags, mlockall};
    use thread_priority::{
        Error, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };

    pub(super) fn fifo(priority: u8) -> Result<(), String> {
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let value = ThreadPriority::try_from(priority.min(99)).map_err(str::to_owned)?;
        set_thread_priority_and_policy(thread_native_id(), value, policy).map_err(|error| {
            match error {
                Error::OS(code) => crate::said(&std::io::Error::from_raw_os_error(code)),
                other => format!("{other:?}"),
            }
        })
    }

    pub(super) fn lock_memory() -> Result<(), String> {
        // Only what is mapped now. Locking future mappings too would make unrelated allocations fail where the limit on locked
        // memory is small.
        mlockall(MlockAllFlags::MCL_CURRENT).map_err(|error| error.desc().to_owned())
    }
}

#[cfg(not(target_os = "linux"))]
mod imp {
    pub(super) fn fifo(_: u8) -> Result<(), String> {
        Err(crate::needs_linux("a FIFO priority").to_string())
    }

    pub(super) fn lock_memory() -> Result<(), String> {
        Err(crate::needs_linux("locking memory").to_string())
    }
}
