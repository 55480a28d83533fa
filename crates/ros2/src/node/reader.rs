//! Frames of the link as they come: as many bytes as there are, never more than a frame is held.

use std::io::{ErrorKind, Read, Write};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::NodeError;
use crate::link::{self, FRAME_MAX};

/// Bytes that one look takes.
const LOOK: usize = 64 << 10;

/// The link, with what was read of the next frame.
pub(super) struct FrameReader<L> {
    link: L,
    held: Vec<u8>,
    begin: usize,
    is_closed: bool,
}

impl<L: Read + Write> FrameReader<L> {
    pub(super) fn new(link: L) -> Self {
        Self {
            link,
            held: Vec::new(),
            begin: 0,
            is_closed: false,
        }
    }

    /// End of the link: it is closed, and every frame was taken.
    pub(super) fn is_closed(&self) -> bool {
        self.is_closed && !self.has_buffered()
    }

    /// A whole frame is there.
    pub(super) fn has_buffered(&self) -> bool {
        let held = &self.held[self.begin..];
        let head = held.first_chunk::<4>();
        head.is_some_and(|head| link::body_length(*head).is_ok_and(|bytes| held.len() >= 4 + bytes))
    }

    /// The next frame, or none when a look brought no more.
    pub(super) fn next<T: DeserializeOwned>(&mut self) -> Result<Option<T>, NodeError> {
        if !self.has_buffered() {
            self.look()?;
        }
        let held = &self.held[self.begin..];
        let Some(head) = held.first_chunk::<4>() else {
            return Ok(None);
        };
        let bytes = link::body_length(*head)?;
        let Some(body) = held.get(4..4 + bytes) else {
            return Ok(None);
        };
        let value = link::value(body)?;
        self.begin += 4 + bytes;
        Ok(Some(value))
    }

    fn look(&mut self) -> Result<(), NodeError> {
        self.held.drain(..self.begin);
        self.begin = 0;
        if self.held.len() > FRAME_MAX + LOOK {
            return Ok(());
        }
        let before = self.held.len();
        self.held.resize(before + LOOK, 0);
        let read = self.link.read(&mut self.held[before..]);
        let count = match read {
            Ok(0) => {
                self.is_closed = true;
                0
            }
            Ok(count) => count,
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
                ) =>
            {
                0
            }
            Err(error) if error.kind() == ErrorKind::ConnectionReset => {
                self.is_closed = true;
                0
            }
            Err(error) => return Err(error.into()),
        };
        self.held.truncate(before + count);
        Ok(())
    }

    pub(super) fn send<T: Serialize>(&mut self, value: &T) -> Result<(), NodeError> {
        let bytes = link::frame(value)?;
        self.write(&bytes)
    }

    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<(), NodeError> {
        Ok(self.link.write_all(bytes)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::{LinkError, NodeMessage};
    use std::io;

    /// Gives its bytes in pieces, and nothing between them.
    struct Pieces(Vec<Vec<u8>>);

    impl Read for Pieces {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            match self.0.is_empty() {
                true => Ok(0),
                false => {
                    let piece = self.0.remove(0);
                    if piece.is_empty() {
                        return Err(ErrorKind::WouldBlock.into());
                    }
                    into[..piece.len()].copy_from_slice(&piece);
                    Ok(piece.len())
                }
            }
        }
    }

    impl Write for Pieces {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn frames_come_whole_however_the_bytes_come() {
        let ready = NodeMessage::Ready { version: 3 };
        let cancel = NodeMessage::Cancel {
            ids: vec![[1; 16], [2; 16]],
        };
        let mut bytes = link::frame(&ready).unwrap();
        bytes.extend(link::frame(&cancel).unwrap());
        for piece in [1, 3, 7, bytes.len()] {
            let mut pieces: Vec<Vec<u8>> = bytes.chunks(piece).map(<[u8]>::to_vec).collect();
            pieces.insert(1, vec![]);
            let mut reader = FrameReader::new(Pieces(pieces));
            let mut found = Vec::new();
            while !reader.is_closed() {
                found.extend(reader.next::<NodeMessage>().unwrap());
            }
            assert_eq!(found, [ready.clone(), cancel.clone()]);
        }
    }

    #[test]
    fn a_length_that_no_frame_has_is_an_error() {
        let mut reader = FrameReader::new(Pieces(vec![vec![255; 8]]));
        let error = reader.next::<NodeMessage>().unwrap_err();
        assert!(matches!(error, NodeError::Link(LinkError::TooLong { .. })));
    }
}
