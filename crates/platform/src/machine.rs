//! What the machine says of itself and of processes: names, room, memory. `None` where a system does not tell.

use std::io;
use std::path::Path;

/// Bytes that are free where a folder lies.
///
/// # Errors
/// What the system said, or that it is not asked here.
pub fn free_bytes(folder: &Path) -> io::Result<u64> {
    #[cfg(unix)]
    {
        let told = nix::sys::statvfs::statvfs(folder)?;
        // Of different width from system to system.
        #[allow(clippy::useless_conversion, clippy::unnecessary_cast)]
        Ok((told.blocks_available() as u64).saturating_mul(told.fragment_size() as u64))
    }
    #[cfg(not(unix))]
    {
        let _ = folder;
        Err(crate::needs_linux("asking for the room on a disk"))
    }
}

/// The name that this machine goes by.
pub fn host_name() -> Option<String> {
    let name = match std::fs::read_to_string("/proc/sys/kernel/hostname") {
        Ok(name) => name,
        Err(_) => std::env::var("COMPUTERNAME").ok()?,
    };
    Some(name.trim().to_owned())
}

/// Bytes of memory that a process holds.
pub fn resident_bytes(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes * 1024)
}

/// Whether there is no such process any more; where the system does not tell, it is taken to live.
pub fn is_process_gone(process: u32) -> bool {
    let of = |who: &str| Path::new("/proc").join(who);
    of("self").exists() && !of(&process.to_string()).exists()
}

/// What the clocks are read from: "tsc".
pub fn clock_source() -> Option<String> {
    let path = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
    let name = std::fs::read_to_string(path).ok()?;
    Some(name.trim().to_owned())
}

/// How the frequencies of the processors are governed, each way once, in order.
pub fn cpu_governors() -> Vec<String> {
    let Ok(folder) = std::fs::read_dir("/sys/devices/system/cpu") else {
        return Vec::new();
    };
    let governors = folder.filter_map(Result::ok).filter_map(|entry| {
        let name = std::fs::read_to_string(entry.path().join("cpufreq/scaling_governor")).ok()?;
        Some(name.trim().to_owned())
    });
    let mut governors: Vec<String> = governors.collect();
    governors.sort();
    governors.dedup();
    governors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_lives_and_holds_memory() {
        let own = std::process::id();
        assert!(!is_process_gone(own));
        #[cfg(target_os = "linux")]
        {
            assert!(resident_bytes(own).is_some_and(|bytes| bytes > 100_000));
            assert!(is_process_gone(u32::MAX));
            assert!(host_name().is_some());
            assert!(free_bytes(Path::new("/")).is_ok());
        }
    }
}
