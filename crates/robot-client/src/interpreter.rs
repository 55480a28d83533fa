//! A connection to port 30020: statements and command words out, replies in (manual 2.2 to 2.6).
//!
//! Owns lines and what they mean. Which reply belongs to which statement is the order in which they come; only words
//! are answered out of turn. What a statement does is seen elsewhere: on port 30001.

use std::io;
use std::time::Duration;

use messages::Localized;
use thiserror::Error;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::address::{ConnectError, RobotAddress};

/// A robot that takes no bytes for so long takes no statement.
const SEND_PATIENCE: Duration = Duration::from_secs(10);
/// Longest reply: controllers repeat the statement in it.
pub const REPLY_BYTES_MAX: usize = 4 << 20;
/// Longest beginning that is shown of what is no reply, characters.
const SHOWN_CHARS: usize = 40;
/// Read at once.
const READ_BYTES: usize = 16 * 1024;

/// The program that enters interpreter mode, with `body` before it: lines that begin with a tab. What is sent before
/// the mode is entered is kept.
pub fn interpreter_program(name: &str, body: &str) -> String {
    format!(
        "def {name}():\n{body}\tinterpreter_mode(clearQueueOnEnter=False, clearOnEnd=True)\nend\n"
    )
}

/// The statement that leaves it, once what was sent before has been done.
pub const END_INTERPRETER_STATEMENT: &str = "end_interpreter()";

/// A word that is carried out at once (manual 2.3 to 2.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterpreterRequest {
    /// Skip what waits.
    Skip,
    /// Stop a movej or movel.
    Abort,
    /// Number of the statement that is carried out, or was last.
    LastExecuted,
    /// Number of the statement that was accepted last.
    LastInterpreted,
    /// Number of the statement that was cleared last.
    LastCleared,
    /// Number of statements that wait.
    Unexecuted,
}

impl InterpreterRequest {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Skip,
        Self::Abort,
        Self::LastExecuted,
        Self::LastInterpreted,
        Self::LastCleared,
        Self::Unexecuted,
    ];

    /// The word that a line is, if it is one.
    pub fn parse(line: &str) -> Option<Self> {
        let line = line.trim();
        Self::ALL.into_iter().find(|word| word.text() == line)
    }

    /// The word that is sent for this request.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Skip => "skipbuffer",
            Self::Abort => "abort",
            Self::LastExecuted => "statelastexecuted",
            Self::LastInterpreted => "statelastinterpreted",
            Self::LastCleared => "statelastcleared",
            Self::Unexecuted => "stateunexecuted",
        }
    }
}

/// What the controller says on this port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The statement waits for its turn.
    Ack {
        /// Number of the statement.
        id: u64,
        /// Text of the statement.
        statement: String,
    },
    /// The statement is not carried out.
    Discard {
        /// The reason and the statement in one text: the reason may hold colons, which makes it impossible to separate
        /// the two.
        about: String,
    },
    /// The answer to a word.
    State {
        /// A statement's number, or a count.
        number: u64,
        /// The word that it answers, where the controller repeats it.
        word: String,
    },
    /// A line that is none of these.
    Other(String),
}

impl Reply {
    /// Reads a line, without its end.
    pub fn parse(line: &str) -> Self {
        let other = || Self::Other(line.to_owned());
        if let Some(about) = line.strip_prefix("discard:") {
            let about = about.trim().to_owned();
            return Self::Discard { about };
        }
        let Some((kind, rest)) = line.split_once(':') else {
            return other();
        };
        let (number, text) = rest.split_once(':').unwrap_or((rest, ""));
        match (kind, number.trim().parse()) {
            ("ack", Ok(id)) => Self::Ack {
                id,
                statement: text.trim().to_owned(),
            },
            ("state", Ok(number)) => Self::State {
                number,
                word: text.trim().to_owned(),
            },
            _ => other(),
        }
    }

    /// Whether it answers this word. The manual prints the word of a neighbour for `statelastcleared`.
    fn answers(&self, asked: InterpreterRequest) -> Option<u64> {
        let Self::State { number, word } = self else {
            return None;
        };
        let is_copied = asked == InterpreterRequest::LastCleared
            && word == InterpreterRequest::LastInterpreted.text();
        (word.is_empty() || word == asked.text() || is_copied).then_some(*number)
    }
}

/// A reason why the conversation ended.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum InterpreterError {
    /// The conversation did not begin.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The robot closed the connection.
    #[error("the robot at {address} has closed the connection for statements")]
    #[zh("机器人 {address} 已关闭语句连接")]
    Closed {
        /// Address of the robot.
        address: RobotAddress,
    },
    /// The connection broke.
    #[error("the connection for statements to the robot at {address} broke: {source}")]
    #[zh("与机器人 {address} 的语句连接中断：{source}")]
    Broken {
        /// Address of the robot.
        address: RobotAddress,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The robot takes no bytes.
    #[error("the robot at {address} takes no statement: {} s", SEND_PATIENCE.as_secs())]
    #[zh("机器人 {address} 不接收语句：{} s", SEND_PATIENCE.as_secs())]
    SendTimeout {
        /// Address of the robot.
        address: RobotAddress,
    },
    /// The robot does not answer a statement.
    #[error("the robot at {address} does not answer on its port for statements: {} s", patience.as_secs())]
    #[zh("机器人 {address} 的语句端口没有应答：{} s", patience.as_secs())]
    ReceiveTimeout {
        /// Address of the robot.
        address: RobotAddress,
        /// Time that was waited.
        patience: Duration,
    },
    /// Something else listens there.
    #[error("what {address} sends is not the stream of port 30020: {begin:?}")]
    #[zh("{address} 发送的不是 30020 端口的数据流：{begin:?}")]
    NotInterpreter {
        /// Address of the robot.
        address: RobotAddress,
        /// How it begins.
        begin: String,
    },
}

/// A connection to port 30020. Dropping it ends it; what was acknowledged is done all the same.
#[derive(Debug)]
pub struct InterpreterClient {
    address: RobotAddress,
    stream: TcpStream,
    received: Vec<u8>,
    /// Number of bytes of `received`, from its beginning, that hold no line end.
    scanned_bytes: usize,
}

impl InterpreterClient {
    /// Connects.
    ///
    /// # Errors
    /// [`InterpreterError::Connect`]
    pub async fn connect(address: &RobotAddress) -> Result<Self, InterpreterError> {
        Ok(Self {
            address: address.clone(),
            stream: address.connect().await?,
            received: Vec::new(),
            scanned_bytes: 0,
        })
    }

    /// Address of the robot.
    pub const fn address(&self) -> &RobotAddress {
        &self.address
    }

    /// Sends a statement or a word: one line.
    ///
    /// # Errors
    /// The robot does not take it.
    pub async fn send(&mut self, line: &str) -> Result<(), InterpreterError> {
        let address = self.address.clone();
        let line = format!("{line}\n");
        match timeout(SEND_PATIENCE, self.stream.write_all(line.as_bytes())).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(source)) => Err(InterpreterError::Broken { address, source }),
            Err(_) => Err(InterpreterError::SendTimeout { address }),
        }
    }

    /// The next reply. May be dropped before it is there; nothing is lost then.
    ///
    /// # Errors
    /// Nothing comes any more, or what comes is no line.
    pub async fn next(&mut self) -> Result<Reply, InterpreterError> {
        loop {
            let found = self.received[self.scanned_bytes..]
                .iter()
                .position(|byte| *byte == b'\n');
            if let Some(length) = found {
                let line: Vec<u8> = self
                    .received
                    .drain(..=self.scanned_bytes + length)
                    .collect();
                self.scanned_bytes = 0;
                let line = String::from_utf8_lossy(&line);
                match line.trim() {
                    "" => continue,
                    line => return Ok(Reply::parse(line)),
                }
            }
            self.scanned_bytes = self.received.len();
            if self.scanned_bytes > REPLY_BYTES_MAX {
                let begin = String::from_utf8_lossy(&self.received[..SHOWN_CHARS]).into_owned();
                let address = self.address.clone();
                return Err(InterpreterError::NotInterpreter { address, begin });
            }
            let mut piece = [0; READ_BYTES];
            let address = || self.address.clone();
            match self.stream.read(&mut piece).await {
                Ok(0) => return Err(InterpreterError::Closed { address: address() }),
                Ok(count) => self.received.extend_from_slice(&piece[..count]),
                Err(source) => {
                    let address = address();
                    return Err(InterpreterError::Broken { address, source });
                }
            }
        }
    }

    /// A reply that is there already.
    ///
    /// # Errors
    /// As of [`next`](Self::next).
    pub async fn try_next(&mut self) -> Result<Option<Reply>, InterpreterError> {
        match timeout(Duration::ZERO, self.next()).await {
            Ok(reply) => reply.map(Some),
            Err(_) => Ok(None),
        }
    }

    /// Sends a word and waits for its number; replies to statements that come before it go to `beside`.
    ///
    /// # Errors
    /// The robot does not answer within `patience`, or not with a number.
    pub async fn ask(
        &mut self,
        word: InterpreterRequest,
        patience: Duration,
        beside: &mut Vec<Reply>,
    ) -> Result<u64, InterpreterError> {
        self.send(word.text()).await?;
        let answered = async {
            loop {
                let reply = self.next().await?;
                if let Some(number) = reply.answers(word) {
                    return Ok(number);
                }
                beside.push(reply);
            }
        };
        if let Ok(answer) = timeout(patience, answered).await {
            return answer;
        }
        let address = self.address.clone();
        Err(match beside.first() {
            Some(Reply::Other(line)) => InterpreterError::NotInterpreter {
                address,
                begin: line.chars().take(SHOWN_CHARS).collect(),
            },
            _ => InterpreterError::ReceiveTimeout { address, patience },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replies_are_those_of_the_manual() {
        for (line, wanted) in [
            (
                "ack: 2: set_digital_out(0, True)",
                Reply::Ack {
                    id: 2,
                    statement: "set_digital_out(0, True)".to_owned(),
                },
            ),
            (
                "ack: 3: d = {1: 2}",
                Reply::Ack {
                    id: 3,
                    statement: "d = {1: 2}".to_owned(),
                },
            ),
            (
                "discard: Compile error:name 'a: b' : a",
                Reply::Discard {
                    about: "Compile error:name 'a: b' : a".to_owned(),
                },
            ),
            (
                "state: 7: statelastexecuted",
                Reply::State {
                    number: 7,
                    word: "statelastexecuted".to_owned(),
                },
            ),
            // Without the word.
            (
                "state: 7",
                Reply::State {
                    number: 7,
                    word: String::new(),
                },
            ),
        ] {
            assert_eq!(Reply::parse(line), wanted);
        }
        assert!(
            InterpreterRequest::ALL.map(|word| InterpreterRequest::parse(word.text()))
                == InterpreterRequest::ALL.map(Some)
        );
        assert_eq!(InterpreterRequest::parse("abort()"), None);
        let answers = |line: &str, word| Reply::parse(line).answers(word);
        let last = "state: 4: statelastinterpreted";
        assert_eq!(answers(last, InterpreterRequest::LastInterpreted), Some(4));
        assert_eq!(answers(last, InterpreterRequest::LastCleared), Some(4));
        assert_eq!(answers(last, InterpreterRequest::Unexecuted), None);
        assert_eq!(answers("state: 4", InterpreterRequest::Unexecuted), Some(4));
        assert_eq!(answers("ack: 4: x", InterpreterRequest::Unexecuted), None);
        for line in [
            "",
            "ack",
            "ack: x: y",
            "ack: -1: y",
            "state: : word",
            "HTTP/1.1 400 Bad Request",
            "ack: 18446744073709551616: y",
        ] {
            assert_eq!(Reply::parse(line), Reply::Other(line.to_owned()));
        }
    }
}
