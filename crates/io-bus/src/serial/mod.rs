//! A serial port of the controller (manual 5.31 to 5.34, chapter 8): RS-485 bytes or Modbus RTU over a device, a pty or
//! TCP.
//!
//! Owns the open line, its settings and the bytes nobody has read yet. A line outlives programs, so it is driven by a
//! thread of its own; functions that wait can be dropped at any time and leave the line usable.

use std::io;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use messages::{Localized, Text, text};
use parking_lot::Mutex as SyncMutex;

use supervision::{ThreadSupervisor, injection};
use thiserror::Error;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::Mutex;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, sleep_until, timeout, timeout_at};
use tokio_serial::{DataBits, Parity, SerialPortBuilderExt, StopBits};

use crate::driver::RuntimeThread;
use crate::modbus::pdu::{PduError, Reply, Request};
use crate::modbus::rtu;
use crate::modbus_server::codec::reply_to;
use crate::modbus_server::tables::Slaves;
use crate::names;

/// How long connecting to a TCP line and writing may take.
const CONNECT_TIME: Duration = Duration::from_secs(2);
const WRITE_TIME: Duration = Duration::from_secs(2);
/// Whoever the line is forwarded to gives it back to programs after so long.
const TURN: Duration = Duration::from_millis(20);
/// Bytes kept for the next read.
const UNREAD_BYTES_MAX: usize = 64 << 10;
/// After so long a silence an answer that has begun is not completed any more.
const REPLY_GAP_TIMEOUT: Duration = Duration::from_millis(250);

/// Where a port leads, from the cell file's `[[serial]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// Path of a device or of a pty.
    Path(String),
    /// `host:port`.
    Tcp(String),
}

impl Endpoint {
    /// `tcp:host:port`, or a path.
    pub fn parse(text: &str) -> Self {
        match text.strip_prefix("tcp:") {
            Some(address) => Self::Tcp(address.to_owned()),
            None => Self::Path(text.to_owned()),
        }
    }
}

/// What the line is used for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SerialMode {
    /// The line is not open.
    #[default]
    Closed,
    /// Bytes without a protocol.
    Raw,
    /// Modbus RTU as master.
    Rtu,
}

/// How the line is set. Ranges are checked by the builtins, which know the port's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialSettings {
    /// Bits a second.
    pub baud_rate: u32,
    /// 0 none, 1 odd, 2 even.
    pub parity: u8,
    /// 1 or 2.
    pub stop_bits: u8,
    /// 7 or 8; 8 for Modbus RTU.
    pub data_bits: u8,
    /// Modbus RTU instead of bytes.
    pub modbus_rtu: bool,
    /// A plug-in and not scripts use the port (manual 5.32, usage 1).
    pub is_daemon_owned: bool,
}

/// A reason why a serial line did not do what was asked.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum SerialError {
    /// No device stands behind the port.
    #[error("no device is connected to this port; name one with [[serial]] in the cell file")]
    #[zh("此端口没有连接设备；请在单元文件中用 [[serial]] 指定")]
    NoDevice,
    /// The port is not open, or open for something else.
    #[error("the port is {}, this needs {}", describe(*.found), describe(*.needed))]
    #[zh("端口为{}，这需要{}", describe(*.found), describe(*.needed))]
    Mode {
        /// What it is.
        found: SerialMode,
        /// What is needed.
        needed: SerialMode,
    },
    /// The device cannot be opened, or broke.
    #[error("the line failed: {0}")]
    #[zh("线路故障：{0}")]
    Line(#[from] io::Error),
    /// No answer.
    #[error("no answer within the timeout")]
    #[zh("超时未应答")]
    NoAnswer,
    /// Bytes came, but no frame with a good checksum.
    #[error("the answer is damaged ({0} bytes without a frame whose checksum fits)")]
    #[zh("应答已损坏（{0} 字节，没有校验和正确的帧）")]
    CorruptReply(usize),
    /// The device refused.
    #[error(transparent)]
    Refused(#[from] PduError),
    /// The operating system gave no thread.
    #[error("cannot start the thread of the serial ports: {0}")]
    #[zh("无法启动串口线程：{0}")]
    NoThread(io::Error),
    /// The line was closed meanwhile.
    #[error("the line was closed meanwhile")]
    #[zh("线路已在此期间关闭")]
    Ended,
    /// Slaves in this process speak Modbus only.
    #[error("simulated Modbus slaves are on this port: it can be used in Modbus RTU mode only")]
    #[zh("此端口上有仿真的 Modbus 从站：只能以 Modbus RTU 方式使用")]
    SlavesOnly,
}

const fn mode_of(settings: Option<SerialSettings>) -> SerialMode {
    match settings {
        None => SerialMode::Closed,
        Some(SerialSettings {
            modbus_rtu: true, ..
        }) => SerialMode::Rtu,
        Some(_) => SerialMode::Raw,
    }
}

const fn describe(mode: SerialMode) -> Text {
    match mode {
        SerialMode::Closed => text!("closed", "关闭的"),
        SerialMode::Raw => text!("in RS-485 mode", "RS-485 模式"),
        SerialMode::Rtu => text!("in Modbus RTU mode", "Modbus RTU 模式"),
    }
}

trait Transport: AsyncRead + AsyncWrite + Unpin + Send {}
impl<T: AsyncRead + AsyncWrite + Unpin + Send> Transport for T {}

/// One serial port.
#[derive(Default)]
pub struct SerialLine {
    endpoint: Option<Endpoint>,
    slaves: Slaves,
    settings: Arc<SyncMutex<Option<SerialSettings>>>,
    line: Arc<Mutex<OpenPort>>,
    driver: OnceLock<RuntimeThread>,
    faults: ThreadSupervisor,
}

#[derive(Default)]
struct OpenPort {
    transport: Option<Box<dyn Transport>>,
    unread: Vec<u8>,
}

/// Ends the work on the driver's thread when nobody waits for it any more.
struct AbortOnDrop<T>(JoinHandle<T>);

impl<T> Drop for AbortOnDrop<T> {
    fn drop(&mut self) {
        self.0.abort();
    }
}

impl SerialLine {
    /// A port that leads to `endpoint`.
    pub fn new(endpoint: Option<Endpoint>) -> Self {
        Self {
            endpoint,
            ..Self::default()
        }
    }

    /// This port with slaves in this process and nothing else behind it.
    pub fn with_slaves(self, slaves: Slaves) -> Self {
        Self { slaves, ..self }
    }

    /// This port with a supervisor, which hears of the faults on its thread.
    pub fn with_supervisor(self, faults: ThreadSupervisor) -> Self {
        Self { faults, ..self }
    }

    /// The settings while the port is open.
    pub fn settings(&self) -> Option<SerialSettings> {
        *self.settings.lock()
    }

    /// What the port is used for.
    pub fn mode(&self) -> SerialMode {
        mode_of(self.settings())
    }

    /// Opens the port anew with these settings, or closes it. A port for a plug-in is not opened here.
    ///
    /// # Errors
    /// [`SerialError::NoDevice`], [`SerialError::OpenPort`]; the port is closed then.
    pub async fn configure(&self, settings: Option<SerialSettings>) -> Result<(), SerialError> {
        *self.settings.lock() = None;
        if !self.slaves.is_empty() {
            if settings.is_some_and(|settings| !settings.modbus_rtu) {
                return Err(SerialError::SlavesOnly);
            }
            *self.settings.lock() = settings;
            return Ok(());
        }
        let line = self.line.clone();
        let endpoint = self.endpoint.clone();
        self.run_on_thread(async move {
            let mut line = line.lock().await;
            *line = OpenPort::default();
            if let Some(settings) = settings.filter(|settings| !settings.is_daemon_owned) {
                let endpoint = endpoint.ok_or(SerialError::NoDevice)?;
                line.transport = Some(open(&endpoint, &settings).await?);
            }
            Ok(())
        })
        .await?;
        *self.settings.lock() = settings;
        Ok(())
    }

    /// Up to `count` bytes; fewer when the time is over or the line broke. `patience` `None` waits for ever.
    ///
    /// # Errors
    /// [`SerialError::Mode`], [`SerialError::OpenPort`]
    pub async fn read(
        &self,
        count: usize,
        patience: Option<Duration>,
    ) -> Result<Vec<u8>, SerialError> {
        let settings = self.require_mode(SerialMode::Raw)?;
        let (line, endpoint) = (self.line.clone(), self.endpoint.clone());
        self.run_on_thread(async move {
            let deadline = patience.and_then(|time| Instant::now().checked_add(time));
            let mut line = with_optional_timeout(deadline, line.lock())
                .await
                .ok_or(SerialError::NoAnswer)?;
            while line.unread.len() < count {
                let mut chunk = [0; 1024];
                let read = with_optional_timeout(
                    deadline,
                    line.receive(endpoint.as_ref(), &settings, &mut chunk),
                );
                match read.await {
                    Some(Ok(received)) => line.unread.extend_from_slice(&chunk[..received]),
                    Some(Err(_)) if !line.unread.is_empty() => break,
                    Some(Err(error)) => return Err(error),
                    None => break,
                }
            }
            let count = count.min(line.unread.len());
            Ok(line.unread.drain(..count).collect())
        })
        .await
    }

    /// Sends bytes; how many went.
    ///
    /// # Errors
    /// [`SerialError::Mode`], [`SerialError::OpenPort`]
    pub async fn write(&self, bytes: Vec<u8>) -> Result<usize, SerialError> {
        let settings = self.require_mode(SerialMode::Raw)?;
        let (line, endpoint) = (self.line.clone(), self.endpoint.clone());
        self.run_on_thread(async move {
            let mut line = line.lock().await;
            line.send(endpoint.as_ref(), &settings, &bytes).await?;
            Ok(bytes.len())
        })
        .await
    }

    /// Passes bytes on between the line and `stream`, both ways, until one of them ends. Programs have their turns
    /// between.
    ///
    /// # Errors
    /// [`SerialError::Mode`] when the port is closed, or in Modbus RTU mode; [`SerialError::OpenPort`].
    pub async fn forward(
        &self,
        mut stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    ) -> Result<(), SerialError> {
        let (line, endpoint) = (self.line.clone(), self.endpoint.clone());
        let settings = self.settings.clone();
        self.run_on_thread(async move {
            let mut from_stream = [0; 1024];
            let mut from_line = [0; 1024];
            loop {
                let settings = *settings.lock();
                let settings = settings
                    .filter(|settings| !settings.modbus_rtu)
                    .ok_or_else(|| SerialError::Mode {
                        found: mode_of(settings),
                        needed: SerialMode::Raw,
                    })?;
                let until = Instant::now() + TURN;
                let mut line = line.lock().await;
                if !line.unread.is_empty() {
                    let unread = core::mem::take(&mut line.unread);
                    stream.write_all(&unread).await?;
                }
                while Instant::now() < until {
                    tokio::select! {
                        read = stream.read(&mut from_stream) => match read? {
                            0 => return Ok(()),
                            count => {
                                let bytes = &from_stream[..count];
                                line.send(endpoint.as_ref(), &settings, bytes).await?;
                            }
                        },
                        received = line.receive(endpoint.as_ref(), &settings, &mut from_line) => {
                            stream.write_all(&from_line[..received?]).await?;
                        }
                        () = sleep_until(until) => {}
                    }
                }
            }
        })
        .await
    }

    /// Drops what was received and not read.
    ///
    /// # Errors
    /// [`SerialError::OpenPort`]
    pub async fn flush(&self) -> Result<(), SerialError> {
        let line = self.line.clone();
        self.run_on_thread(async move {
            line.lock().await.drain().await;
            Ok(())
        })
        .await
    }

    /// One Modbus request and its answer. `patience` `None` waits for ever for the answer to begin.
    ///
    /// # Errors
    /// [`SerialError`]: the mode, the line, no answer, a damaged one, or a refusal of the device.
    pub async fn request(
        &self,
        slave: u8,
        request: Request,
        patience: Option<Duration>,
    ) -> Result<Reply, SerialError> {
        let settings = self.require_mode(SerialMode::Rtu)?;
        if !self.slaves.is_empty() {
            // A number that nobody has stays silent, and simulated time need not pass to know it.
            let tables = self.slaves.get(&slave).ok_or(SerialError::NoAnswer)?;
            let reply = reply_to(&request.encode(), tables.as_ref());
            return Ok(request.decode(&reply)?);
        }
        let (line, endpoint) = (self.line.clone(), self.endpoint.clone());
        self.run_on_thread(async move {
            let mut line = line.lock().await;
            // What is still on its way belongs to an earlier request. 3.5 characters of silence begin a frame.
            line.drain().await;
            sleep(frame_gap(settings.baud_rate)).await;
            let frame = rtu::encode(slave, &request);
            line.send(endpoint.as_ref(), &settings, &frame).await?;
            let deadline = patience.and_then(|time| Instant::now().checked_add(time));
            let mut received = Vec::new();
            loop {
                let mut chunk = [0; rtu::FRAME_BYTES_MAX];
                let until = match received.is_empty() {
                    true => deadline,
                    false => Some(Instant::now() + REPLY_GAP_TIMEOUT),
                };
                let read = with_optional_timeout(
                    until,
                    line.receive(endpoint.as_ref(), &settings, &mut chunk),
                );
                match read.await {
                    Some(Ok(count)) => received.extend_from_slice(&chunk[..count]),
                    Some(Err(error)) => return Err(error),
                    None if received.is_empty() => return Err(SerialError::NoAnswer),
                    None => return Err(SerialError::CorruptReply(received.len())),
                }
                if let Some(reply) = rtu::find_reply(&received, slave, &request) {
                    return Ok(request.decode(reply)?);
                }
                if received.len() > 16 * rtu::FRAME_BYTES_MAX {
                    return Err(SerialError::CorruptReply(received.len()));
                }
            }
        })
        .await
    }

    fn require_mode(&self, needed: SerialMode) -> Result<SerialSettings, SerialError> {
        let settings = self.settings();
        let found = self.mode();
        settings
            .filter(|_| found == needed)
            .ok_or(SerialError::Mode { found, needed })
    }

    /// Does the work on the thread that the line belongs to: a program's own runtime ends with the program.
    async fn run_on_thread<T: Send + 'static>(
        &self,
        work: impl Future<Output = Result<T, SerialError>> + Send + 'static,
    ) -> Result<T, SerialError> {
        let driver = match self.driver.get() {
            Some(driver) => driver,
            None => {
                let started = RuntimeThread::start("serial", self.faults.clone())
                    .map_err(SerialError::NoThread)?;
                self.driver.get_or_init(|| started)
            }
        };
        let mut work = AbortOnDrop(driver.spawn(async move {
            injection::point("serial");
            work.await
        }));
        match (&mut work.0).await {
            Ok(Ok(given)) => given,
            Ok(Err(fault)) => Err(SerialError::Line(io::Error::other(fault))),
            Err(_ended) => Err(SerialError::Ended),
        }
    }
}

impl OpenPort {
    /// Waits for bytes. A line that has broken is opened again at the next call.
    async fn receive(
        &mut self,
        endpoint: Option<&Endpoint>,
        settings: &SerialSettings,
        chunk: &mut [u8],
    ) -> Result<usize, SerialError> {
        let transport = self.transport(endpoint, settings).await?;
        let room = chunk.len().min(UNREAD_BYTES_MAX);
        match transport.read(&mut chunk[..room]).await {
            Ok(count @ 1..) => Ok(count),
            ended => {
                self.transport = None;
                ended?;
                Err(io::Error::from(io::ErrorKind::UnexpectedEof).into())
            }
        }
    }

    async fn send(
        &mut self,
        endpoint: Option<&Endpoint>,
        settings: &SerialSettings,
        bytes: &[u8],
    ) -> Result<(), SerialError> {
        let transport = self.transport(endpoint, settings).await?;
        let sending = async {
            transport.write_all(bytes).await?;
            transport.flush().await
        };
        let sent = timeout(WRITE_TIME, sending).await;
        if let Ok(Ok(())) = sent {
            return Ok(());
        }
        self.transport = None;
        match sent {
            Ok(Err(error)) => Err(error.into()),
            _ => Err(io::Error::from(io::ErrorKind::TimedOut).into()),
        }
    }

    async fn transport(
        &mut self,
        endpoint: Option<&Endpoint>,
        settings: &SerialSettings,
    ) -> Result<&mut Box<dyn Transport>, SerialError> {
        if self.transport.is_none() {
            let endpoint = endpoint.ok_or(SerialError::NoDevice)?;
            self.transport = Some(open(endpoint, settings).await?);
        }
        self.transport.as_mut().ok_or(SerialError::NoDevice)
    }

    /// Drops what has been received.
    async fn drain(&mut self) {
        self.unread.clear();
        let Some(transport) = &mut self.transport else {
            return;
        };
        let mut chunk = [0; 1024];
        // Bounded: a peer that never stops sending must not hold a request up for ever.
        for _ in 0..64 {
            match timeout(Duration::ZERO, transport.read(&mut chunk)).await {
                Ok(Ok(1..)) => {}
                Ok(_) => {
                    self.transport = None;
                    return;
                }
                Err(_elapsed) => return,
            }
        }
    }
}

async fn open(
    endpoint: &Endpoint,
    settings: &SerialSettings,
) -> Result<Box<dyn Transport>, SerialError> {
    match endpoint {
        Endpoint::Tcp(address) => {
            let stream = timeout(CONNECT_TIME, names::connect_to(address))
                .await
                .map_err(|_| io::Error::from(io::ErrorKind::TimedOut))??;
            // Frames are small; a system that refuses this only makes them slower.
            let _ = stream.set_nodelay(true);
            Ok(Box::new(stream))
        }
        Endpoint::Path(path) => {
            let stream = tokio_serial::new(path, settings.baud_rate)
                .parity(match settings.parity {
                    1 => Parity::Odd,
                    2 => Parity::Even,
                    _ => Parity::None,
                })
                .stop_bits(match settings.stop_bits {
                    2 => StopBits::Two,
                    _ => StopBits::One,
                })
                .data_bits(match settings.data_bits {
                    7 => DataBits::Seven,
                    _ => DataBits::Eight,
                })
                .open_native_async()
                .map_err(io::Error::from)?;
            Ok(Box::new(stream))
        }
    }
}

/// 3.5 characters of 11 bits, at least 1.75 ms (MODBUS over Serial Line V1.02, 2.5.1.1).
fn frame_gap(baud_rate: u32) -> Duration {
    Duration::from_secs_f64((38.5 / f64::from(baud_rate.max(1))).max(0.00175))
}

async fn with_optional_timeout<T>(
    deadline: Option<Instant>,
    future: impl Future<Output = T>,
) -> Option<T> {
    match deadline {
        Some(deadline) => timeout_at(deadline, future).await.ok(),
        None => Some(future.await),
    }
}

#[cfg(test)]
mod tests;
