//! A connection to port 30004: which variables the controller offers, and their values, cycle by cycle.

use std::io;
use std::time::Duration;

use messages::{Localized, Text, text};
use thiserror::Error;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout, timeout_at};
use wire::rtsi::{
    InvalidPacketLength, PROTOCOL_VERSION, RtsiType, RtsiValue, TextLevel, append_outputs_request,
    append_packet, decode_controller_text, decode_recipe_reply, decode_version, packet_type,
    split_packet,
};

use crate::address::{ConnectError, RobotAddress};

/// Controllers answer within a second.
const ANSWER_PATIENCE: Duration = Duration::from_secs(2);
/// A stream that stands still for so long has ended: controllers send in every state.
const SILENCE_MAX: Duration = Duration::from_secs(3);
/// What controllers send at most, Hz.
pub const FREQUENCY_MAX: f64 = 250.0;
/// Packets have at most 64 KiB; more than this is never held.
const READ_BYTES: usize = 32 * 1024;

/// A reason why there is no data.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RtsiError {
    /// No connection.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The controller closed it.
    #[error("the robot at {address} has closed the connection for data")]
    #[zh("{address} 处的机器人关闭了数据连接")]
    Closed {
        /// Address of the robot.
        address: RobotAddress,
    },
    /// The connection broke.
    #[error("the connection for data to the robot at {address} broke: {source}")]
    #[zh("与 {address} 处机器人的数据连接中断：{source}")]
    Broken {
        /// Address of the robot.
        address: RobotAddress,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Nothing comes.
    #[error("the robot at {address} does not answer on its port for data ({what})")]
    #[zh("{address} 处的机器人在数据端口上没有应答（{what}）")]
    ReceiveTimeout {
        /// Address of the robot.
        address: RobotAddress,
        /// What was waited for.
        what: Text,
    },
    /// Something else listens there.
    #[error("what {address} sends is not RTSI: {source}")]
    #[zh("{address} 发送的不是 RTSI：{source}")]
    NotRtsi {
        /// Address of the robot.
        address: RobotAddress,
        /// What is wrong with the bytes.
        source: InvalidPacketLength,
    },
    /// The robot refuses a request.
    #[error("the robot at {address} refuses {what}")]
    #[zh("{address} 处的机器人拒绝{what}")]
    Refused {
        /// Address of the robot.
        address: RobotAddress,
        /// The request that is refused.
        what: Text,
    },
    /// The answer does not fit the request.
    #[error("the robot at {address} answers {what} with something else")]
    #[zh("{address} 处的机器人对{what}的应答不符")]
    UnexpectedReply {
        /// Address of the robot.
        address: RobotAddress,
        /// The request that was answered.
        what: Text,
    },
}

/// What arrives once data flows.
#[derive(Clone, Debug, PartialEq)]
pub enum RtsiMessage {
    /// Values in the order of [`RtsiClient::offered`].
    Data(Vec<RtsiValue>),
    /// The controller says something.
    Text(TextLevel, String),
}

/// A connection with one recipe of outputs. Dropping it ends it.
#[derive(Debug)]
pub struct RtsiClient {
    address: RobotAddress,
    stream: TcpStream,
    received: Vec<u8>,
    /// When it was heard, or asked, last: whoever waits may begin anew as often as it likes.
    last_received: Instant,
    recipe: u8,
    offered: Vec<(String, RtsiType)>,
    version: [u32; 4],
}

impl RtsiClient {
    /// Connects, asks which of `wanted` the controller offers, and lets it send these. A controller that does not know
    /// a name says so for that name.
    ///
    /// # Errors
    /// [`RtsiError`]
    pub async fn connect(
        address: &RobotAddress,
        frequency: f64,
        wanted: &[&str],
    ) -> Result<Self, RtsiError> {
        let mut names = wanted.to_vec();
        // A recipe with a name that is not known does not count: it is asked for again without.
        loop {
            let mut this = Self {
                address: address.clone(),
                stream: address.connect().await?,
                received: Vec::new(),
                last_received: Instant::now(),
                recipe: 0,
                offered: Vec::new(),
                version: [0; 4],
            };
            this.negotiate_version().await?;
            let unknown = this.request_outputs(frequency, &names).await?;
            if unknown.is_empty() {
                this.start().await?;
                return Ok(this);
            }
            names.retain(|name| !unknown.contains(name));
            if names.is_empty() {
                return Err(this.refused(text!(
                    "every variable that is asked for",
                    "所请求的每个变量"
                )));
            }
        }
    }

    /// Names and types of the values that come.
    pub fn offered(&self) -> &[(String, RtsiType)] {
        &self.offered
    }

    /// The controller's version: major, minor, bug fix, build.
    pub const fn version(&self) -> [u32; 4] {
        self.version
    }

    /// The next data or text. May be dropped before it is there; nothing is lost then.
    ///
    /// # Errors
    /// The stream has ended.
    pub async fn next(&mut self) -> Result<RtsiMessage, RtsiError> {
        loop {
            let (kind, payload) = self.packet(SILENCE_MAX, text!("data", "数据")).await?;
            match kind {
                // Of another recipe than ours: the vendor's client leaves it out as well.
                packet_type::DATA if payload.first() != Some(&self.recipe) => {}
                packet_type::DATA => {
                    if let Some(values) = self.values(&payload) {
                        return Ok(RtsiMessage::Data(values));
                    }
                    return Err(self.garbled(text!("data", "数据")));
                }
                packet_type::TEXT => {
                    if let Some((level, text)) = decode_controller_text(&payload) {
                        return Ok(RtsiMessage::Text(level, text));
                    }
                }
                _ => {}
            }
        }
    }

    fn values(&self, payload: &[u8]) -> Option<Vec<RtsiValue>> {
        let (_, mut rest) = payload.split_first()?;
        let values = self
            .offered
            .iter()
            .map(|(_, kind)| RtsiValue::read(*kind, &mut rest));
        let values = values.collect::<Option<Vec<_>>>()?;
        rest.is_empty().then_some(values)
    }

    async fn negotiate_version(&mut self) -> Result<(), RtsiError> {
        let mut request = Vec::new();
        append_packet(&mut request, packet_type::PROTOCOL, |out| {
            out.extend(PROTOCOL_VERSION.to_be_bytes());
        });
        self.send(&request).await?;
        if self
            .wait_for_packet(
                packet_type::PROTOCOL,
                text!("the protocol's version", "协议版本"),
            )
            .await?
            != [1]
        {
            return Err(self.refused(text!("version 1 of the protocol", "协议版本 1")));
        }
        request.clear();
        append_packet(&mut request, packet_type::VERSION, |_| {});
        self.send(&request).await?;
        let what = text!("its own version", "自身版本");
        let answer = self
            .wait_for_packet(packet_type::VERSION, what.clone())
            .await?;
        self.version = decode_version(&answer).ok_or_else(|| self.garbled(what))?;
        Ok(())
    }

    /// Asks for variables; those that it does not have.
    async fn request_outputs<'a>(
        &mut self,
        frequency: f64,
        names: &[&'a str],
    ) -> Result<Vec<&'a str>, RtsiError> {
        let mut request = Vec::new();
        append_outputs_request(&mut request, frequency, names);
        self.send(&request).await?;
        let what = text!("the list of variables", "变量列表");
        let answer = self
            .wait_for_packet(packet_type::OUTPUTS, what.clone())
            .await?;
        let reply = decode_recipe_reply(&answer).ok_or_else(|| self.garbled(what.clone()))?;
        if reply.kinds.len() != names.len() {
            return Err(self.garbled(what));
        }
        self.recipe = reply.id;
        let mut unknown = Vec::new();
        for (name, kind) in names.iter().zip(reply.kinds) {
            match kind {
                Ok(kind) => self.offered.push(((*name).to_owned(), kind)),
                Err(_) => unknown.push(*name),
            }
        }
        Ok(unknown)
    }

    async fn start(&mut self) -> Result<(), RtsiError> {
        let mut request = Vec::new();
        append_packet(&mut request, packet_type::START, |_| {});
        self.send(&request).await?;
        match self
            .wait_for_packet(
                packet_type::START,
                text!("the start of the stream", "数据流的启动"),
            )
            .await?
            .as_slice()
        {
            [1] => Ok(()),
            _ => Err(self.refused(text!("to start", "启动"))),
        }
    }

    /// The payload of the next packet with this letter; others are left out.
    async fn wait_for_packet(&mut self, wanted: u8, what: Text) -> Result<Vec<u8>, RtsiError> {
        let silent = RtsiError::ReceiveTimeout {
            address: self.address.clone(),
            what: what.clone(),
        };
        let reading = async {
            loop {
                let (kind, payload) = self.packet(ANSWER_PATIENCE, what.clone()).await?;
                if kind == wanted {
                    return Ok(payload);
                }
            }
        };
        timeout(ANSWER_PATIENCE, reading)
            .await
            .unwrap_or(Err(silent))
    }

    async fn packet(&mut self, patience: Duration, what: Text) -> Result<(u8, Vec<u8>), RtsiError> {
        loop {
            match split_packet(&self.received) {
                Ok(Some(found)) => {
                    let whole = (found.letter, found.payload.to_vec());
                    let bytes = found.bytes;
                    self.received.drain(..bytes);
                    return Ok(whole);
                }
                Ok(None) => {}
                Err(source) => {
                    let address = self.address.clone();
                    return Err(RtsiError::NotRtsi { address, source });
                }
            }
            let mut piece = [0; READ_BYTES];
            let address = || self.address.clone();
            // What is there is read even when it is late.
            let deadline = self.last_received + patience;
            match timeout_at(deadline, self.stream.read(&mut piece)).await {
                Ok(Ok(0)) => return Err(RtsiError::Closed { address: address() }),
                Ok(Ok(count)) => {
                    self.last_received = Instant::now();
                    self.received.extend_from_slice(&piece[..count]);
                }
                Ok(Err(source)) => {
                    let address = address();
                    return Err(RtsiError::Broken { address, source });
                }
                Err(_) => {
                    let address = address();
                    return Err(RtsiError::ReceiveTimeout { address, what });
                }
            }
        }
    }

    async fn send(&mut self, bytes: &[u8]) -> Result<(), RtsiError> {
        let address = self.address.clone();
        match timeout(ANSWER_PATIENCE, self.stream.write_all(bytes)).await {
            Ok(Ok(())) => {
                self.last_received = Instant::now();
                Ok(())
            }
            Ok(Err(source)) => Err(RtsiError::Broken { address, source }),
            Err(_) => Err(RtsiError::ReceiveTimeout {
                address,
                what: text!("to requests", "对请求"),
            }),
        }
    }

    fn refused(&self, what: Text) -> RtsiError {
        let address = self.address.clone();
        RtsiError::Refused { address, what }
    }

    fn garbled(&self, what: Text) -> RtsiError {
        let address = self.address.clone();
        RtsiError::UnexpectedReply { address, what }
    }
}
