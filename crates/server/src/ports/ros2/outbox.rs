//! What waits to be written to the node. Samples are left out where the node does not keep up; answers are not.

use std::collections::VecDeque;
use std::io;

use ros2::link::{ControllerMessage, LinkError, frame};
use tokio::io::{AsyncWrite, AsyncWriteExt as _};

/// Bytes above which samples are left out: a quarter of a second at 250 Hz.
const SAMPLE_BYTES_MAX: usize = 64 << 10;
/// Bytes above which the node is beyond help.
const BYTES_MAX: usize = 16 << 20;

/// Frames to write.
#[derive(Default)]
pub(super) struct Outbox {
    frames: VecDeque<Vec<u8>>,
    bytes: usize,
    written: usize,
    /// Samples that were left out.
    pub(super) samples_lost: u64,
}

impl Outbox {
    /// Adds a message.
    ///
    /// # Errors
    /// So much waits that the node must be started anew.
    pub(super) fn push(&mut self, message: &ControllerMessage) -> Result<(), LinkError> {
        if matches!(message, ControllerMessage::Sample(_)) && self.bytes > SAMPLE_BYTES_MAX {
            self.samples_lost += 1;
            return Ok(());
        }
        let bytes = frame(message)?;
        self.bytes += bytes.len();
        self.frames.push_back(bytes);
        match self.bytes <= BYTES_MAX {
            true => Ok(()),
            false => Err(LinkError::TooLong { bytes: self.bytes }),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Writes some of it. Nothing is lost when this is dropped before it returns.
    pub(super) async fn write(&mut self, into: &mut (impl AsyncWrite + Unpin)) -> io::Result<()> {
        let Some(first) = self.frames.front() else {
            return Ok(());
        };
        let count = into.write(&first[self.written..]).await?;
        if count == 0 {
            return Err(io::ErrorKind::WriteZero.into());
        }
        self.written += count;
        if self.written == first.len() {
            self.bytes -= first.len();
            self.written = 0;
            self.frames.pop_front();
        }
        Ok(())
    }
}
