//! Questions to the dashboard, port 29999, that other commands need answered.

use std::time::Duration;

use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::time::timeout;

use crate::address::RobotAddress;

/// Who asks waits no longer than this: without an answer it goes on.
const PATIENCE: Duration = Duration::from_millis(800);
/// Longest line that is read.
const LINE_BYTES_MAX: u64 = 4096;

/// Whether the robot takes orders from outside: `Some(false)` in local mode, `None` if nobody says so.
pub async fn is_remote(address: &RobotAddress) -> Option<bool> {
    timeout(PATIENCE, ask(address)).await.ok().flatten()
}

async fn ask(address: &RobotAddress) -> Option<bool> {
    let stream = address.connect().await.ok()?;
    let mut lines = BufReader::new(stream).take(8 * LINE_BYTES_MAX);
    let mut line = String::new();
    // It greets first.
    lines.read_line(&mut line).await.ok()?;
    let stream = lines.get_mut().get_mut();
    stream.write_all(b"remoteControl -s\n").await.ok()?;
    line.clear();
    lines.read_line(&mut line).await.ok()?;
    match line.trim().to_ascii_lowercase().as_str() {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    }
}
