//! A finding made smaller: pieces are taken out for as long as it looks the same from outside.

use std::fs;
use std::io;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// How a target answers an input in a process of its own: the place of a panic, the signal of a death, or nothing.
fn crash_signature(name: &str, input: &[u8], scratch: &Path) -> io::Result<String> {
    fs::write(scratch, input)?;
    let mut command = Command::new(std::env::current_exe()?);
    command
        .args(["file", name])
        .arg(scratch)
        .env("RUST_BACKTRACE", "0");
    let output = command.stdin(Stdio::null()).output()?;
    if let Some(signal) = output.status.signal() {
        return Ok(format!("signal {signal}"));
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let place = said
        .lines()
        .find_map(|line| line.split_once("panicked at "));
    Ok(place.map_or(String::new(), |(_, place)| place.to_owned()))
}

/// The smallest input found that gets the same answer; texts lose lines, anything else bytes.
///
/// # Errors
/// If a child cannot be started, or the input is no finding.
pub fn minimize(name: &str, input: &[u8]) -> io::Result<(Vec<u8>, String)> {
    let scratch = std::env::temp_dir().join(format!("campaign-shrink-{}", std::process::id()));
    let wanted = crash_signature(name, input, &scratch)?;
    if wanted.is_empty() {
        return Err(io::Error::other("this input breaks no promise"));
    }
    let mut parts: Vec<Vec<u8>> = match std::str::from_utf8(input) {
        Ok(text) => text
            .split_inclusive('\n')
            .map(|line| line.as_bytes().to_vec())
            .collect(),
        Err(_) => input.iter().map(|byte| vec![*byte]).collect(),
    };
    let mut size = parts.len() / 2;
    while size > 0 {
        let mut at = 0;
        let before = parts.len();
        while at < parts.len() {
            let end = (at + size).min(parts.len());
            let rest = [&parts[..at], &parts[end..]].concat();
            if crash_signature(name, &rest.concat(), &scratch)? == wanted {
                parts = rest;
            } else {
                at = end;
            }
        }
        // Once more while single parts still go: taking one out may free another.
        if size > 1 || parts.len() == before {
            size /= 2;
        }
    }
    let _ = fs::remove_file(&scratch);
    Ok((parts.concat(), wanted))
}
