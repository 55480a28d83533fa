//! Port 30001: states and exceptions that the controller streams (official SDK, include/Primary).
//!
//! A message is a length (itself included), a type and a body. Owns the frames and which body belongs to which type.

pub mod exception;
mod fields;
pub mod state;

pub use exception::{
    ErrorData, Exception, ExceptionLevel, ExceptionSource, RobotErrorDisplay, RobotException,
};
pub use state::State;

use messages::Localized;
use thiserror::Error;

use fields::FieldReader;

/// Bytes before the body.
pub const HEAD_BYTES: usize = 5;

/// Longest message that is taken from a peer, bytes: many times the longest there is.
pub const MESSAGE_BYTES_MAX: usize = 1 << 20;

/// Type byte of a state message.
pub const ROBOT_STATE: u8 = 16;
/// Type byte of an exception.
pub const ROBOT_EXCEPTION: u8 = 20;

/// A reason why bytes are no message of this port.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum DecodeError {
    /// No message is so short or so long.
    #[error("a message of {length} bytes; one of port 30001 has 6 to {MESSAGE_BYTES_MAX}")]
    #[zh("消息有 {length} 字节；端口 30001 的消息有 6 到 {MESSAGE_BYTES_MAX} 字节")]
    Length {
        /// What it says.
        length: u32,
    },
    /// A part says that it is longer than its message, or shorter than its own head.
    #[error("part {kind} of a state says it has {length} bytes, {left} are there")]
    #[zh("状态的第 {kind} 部分声明有 {length} 字节，实有 {left} 字节")]
    PartLength {
        /// Type of the part.
        kind: u8,
        /// Length that the part claims, bytes.
        length: u32,
        /// What is there.
        left: usize,
    },
    /// An exception ends inside a value; a part of a state that does is an unknown one.
    #[error("an exception ends {missing} bytes too early")]
    #[zh("异常消息提前 {missing} 字节结束")]
    UnexpectedEnd {
        /// Number of bytes that are missing.
        missing: usize,
    },
    /// There are bytes behind the last part.
    #[error("{0} bytes behind the last part of a state are no part")]
    #[zh("状态最后一部分之后的 {0} 字节不属于任何部分")]
    TrailingBytes(usize),
}

/// What the controller says on this port.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// How the robot is.
    State(Box<State>),
    /// Something happened.
    Exception(RobotException),
    /// A type that is not known here; its number.
    Unknown(u8),
}

/// A message in the bytes received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageFrame<'a> {
    /// Type of the message.
    pub kind: u8,
    /// What follows the head.
    pub body: &'a [u8],
    /// Number of bytes that the message takes, head included.
    pub bytes: usize,
}

/// The first whole message of `received`; `None` until it is complete.
///
/// # Errors
/// [`DecodeError::Length`]: the stream is not this port's.
pub fn split_frame(received: &[u8]) -> Result<Option<MessageFrame<'_>>, DecodeError> {
    let Some(&[a, b, c, d, kind]) = received.first_chunk::<HEAD_BYTES>() else {
        return Ok(None);
    };
    let length = u32::from_be_bytes([a, b, c, d]);
    let bytes = length as usize;
    if !(HEAD_BYTES + 1..=MESSAGE_BYTES_MAX).contains(&bytes) {
        return Err(DecodeError::Length { length });
    }
    Ok(received
        .get(HEAD_BYTES..bytes)
        .map(|body| MessageFrame { kind, body, bytes }))
}

/// What a frame says.
///
/// # Errors
/// [`DecodeError`], when its parts do not fit together.
pub fn decode_message(frame: &MessageFrame<'_>) -> Result<Message, DecodeError> {
    match frame.kind {
        ROBOT_STATE => Ok(Message::State(Box::new(State::decode(frame.body)?))),
        ROBOT_EXCEPTION => Ok(
            match exception::decode(&mut FieldReader::new(frame.body))? {
                Some(exception) => Message::Exception(exception),
                None => Message::Unknown(frame.kind),
            },
        ),
        other => Ok(Message::Unknown(other)),
    }
}

#[cfg(test)]
mod tests;
