//! Machines on the network that a test plays itself: who listens on which port, what came, what was sent back.
//!
//! Connections are pairs of sockets within this process, so that a message is there as soon as it is sent and no port
//! of the machine is used: two tests may play the same one at once. Served before every cycle, on the thread that
//! passes it; what only the test can answer waits for its turn.

mod modbus;

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use io_bus::SimulatedPeers;
use io_bus::modbus_server::codec::message_bytes;
use messages::{Text, text};
use parking_lot::Mutex;
use platform::sockets::{self, LocalStream};

pub(crate) use modbus::{ModbusDevice, ModbusRequest};

/// Bounds of what one test plays.
const SERVERS_MAX: usize = 64;
const CONNECTIONS_MAX: usize = 64;
const UNREAD_BYTES_MAX: usize = 8 << 20;
const UNSENT_BYTES_MAX: usize = 8 << 20;
const ARRIVED_MAX: usize = 100_000;
/// Ports that are given to who asks for any.
const FIRST_FREE_PORT: u16 = 49152;

/// What a server answers.
pub(crate) enum ServerKind {
    /// Messages as they come, each with the next answer.
    Socket(Vec<ReplySource>),
    /// Calls over HTTP; the test answers.
    Rpc,
    /// Requests on tables.
    Modbus(ModbusDevice),
}

/// The answer to a message.
pub(crate) enum ReplySource {
    /// The answer is these bytes.
    Bytes(Vec<u8>),
    /// What the test says.
    Ask,
}

/// One connection of one server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ConnectionId {
    pub server: usize,
    connection: usize,
}

/// Something that came in, in order.
#[derive(Debug, PartialEq)]
pub(crate) struct ReceivedMessage {
    pub whom: ConnectionId,
    /// Number of the message at its server, from 0.
    pub number: usize,
    /// The message, the body of a call, or a request.
    pub data: Vec<u8>,
    /// The sender waits for what the test answers.
    pub asks: bool,
}

/// All servers of one test.
#[derive(Default)]
pub(crate) struct PeerRegistry {
    servers: Mutex<Vec<SimulatedListener>>,
    /// Some answers are the test's to give.
    ask_the_test: AtomicBool,
}

struct SimulatedListener {
    port: u16,
    kind: ServerKind,
    /// Messages so far.
    count: usize,
    connections: Vec<PeerConnection>,
    arrived: VecDeque<ReceivedMessage>,
}

#[derive(Debug)]
struct PeerConnection {
    stream: LocalStream,
    unread: Vec<u8>,
    unsent: Vec<u8>,
    /// The peer waits for what the test says; whatever it sends after that waits as well.
    waits: bool,
    closed: bool,
}

impl PeerRegistry {
    /// A new server; port 0 is any that is free. The number of the server and its port.
    ///
    /// # Errors
    /// A sentence.
    pub(crate) fn open(&self, port: u16, kind: ServerKind) -> Result<(usize, u16), Text> {
        let mut servers = self.servers.lock();
        if servers.len() >= SERVERS_MAX {
            return Err(text!(
                "{SERVERS_MAX} servers are open already",
                "已打开 {SERVERS_MAX} 个服务器"
            ));
        }
        let is_taken = |port: u16| servers.iter().any(|server| server.port == port);
        let port = match port {
            0 => (FIRST_FREE_PORT..=u16::MAX).find(|port| !is_taken(*port)),
            port => Some(port).filter(|port| !is_taken(*port)),
        };
        let port = port.ok_or_else(|| {
            text!(
                "another server of this test has that port",
                "此测试的另一个服务器已占用该端口"
            )
        })?;
        let asks = match &kind {
            ServerKind::Socket(answers) => answers
                .iter()
                .any(|answer| matches!(answer, ReplySource::Ask)),
            ServerKind::Rpc => true,
            ServerKind::Modbus(_) => false,
        };
        if asks {
            self.ask_the_test.store(true, Ordering::Release);
        }
        servers.push(SimulatedListener {
            port,
            kind,
            count: 0,
            connections: Vec::new(),
            arrived: VecDeque::new(),
        });
        Ok((servers.len() - 1, port))
    }

    /// Whether the test has something to do in every cycle.
    pub(crate) fn needs_test(&self) -> bool {
        self.ask_the_test.load(Ordering::Acquire)
    }

    /// Everything that came in since the last call, server by server.
    pub(crate) fn take_arrived(&self) -> Vec<ReceivedMessage> {
        let mut servers = self.servers.lock();
        let arrived = servers.iter_mut();
        arrived
            .flat_map(|server| server.arrived.drain(..))
            .collect()
    }

    /// Sends what the test answers.
    pub(crate) fn reply(&self, whom: ConnectionId, data: &[u8]) {
        let mut servers = self.servers.lock();
        let server = servers.get_mut(whom.server);
        if let Some(connection) = server.and_then(|s| s.connections.get_mut(whom.connection)) {
            connection.waits = false;
            connection.send(data);
        }
        drop(servers);
        // What came meanwhile has its turn.
        self.serve();
    }

    /// Closes a connection that nothing more can come of.
    pub(crate) fn hang_up(&self, whom: ConnectionId) {
        let mut servers = self.servers.lock();
        let server = servers.get_mut(whom.server);
        if let Some(connection) = server.and_then(|s| s.connections.get_mut(whom.connection)) {
            connection.close();
        }
    }
}

impl SimulatedPeers for PeerRegistry {
    fn serve(&self) {
        for (number, server) in self.servers.lock().iter_mut().enumerate() {
            server.serve(number);
        }
    }

    fn simulates(&self, _host: &str, port: u16) -> bool {
        self.servers.lock().iter().any(|server| server.port == port)
    }

    fn connect(&self, _host: &str, port: u16) -> Option<io::Result<LocalStream>> {
        let mut servers = self.servers.lock();
        let server = servers.iter_mut().find(|server| server.port == port)?;
        if server.connections.iter().filter(|c| !c.closed).count() >= CONNECTIONS_MAX {
            return Some(Err(ErrorKind::ConnectionRefused.into()));
        }
        Some(sockets::pair().and_then(|(own, other)| {
            own.set_nonblocking(true)?;
            server.connections.push(PeerConnection {
                stream: own,
                unread: Vec::new(),
                unsent: Vec::new(),
                waits: false,
                closed: false,
            });
            Ok(other)
        }))
    }
}

impl SimulatedListener {
    fn serve(&mut self, number: usize) {
        for index in 0..self.connections.len() {
            self.connections[index].exchange();
            while let Some(data) = self.next_message(index) {
                let whom = ConnectionId {
                    server: number,
                    connection: index,
                };
                self.take(whom, data);
            }
        }
    }

    /// The next whole message of a connection.
    fn next_message(&mut self, index: usize) -> Option<Vec<u8>> {
        let connection = &mut self.connections[index];
        if connection.waits || connection.closed && connection.unread.is_empty() {
            return None;
        }
        let length = match &self.kind {
            ServerKind::Socket(_) => line_or_all(&connection.unread),
            ServerKind::Rpc => match http_request(&connection.unread) {
                Ok(length) => length,
                Err(()) => {
                    connection.send(b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n");
                    connection.close();
                    None
                }
            },
            ServerKind::Modbus(_) => match message_bytes(&connection.unread) {
                Ok(length) => length.filter(|length| *length <= connection.unread.len()),
                Err(_) => {
                    connection.close();
                    None
                }
            },
        }?;
        Some(connection.unread.drain(..length).collect())
    }

    fn take(&mut self, whom: ConnectionId, data: Vec<u8>) {
        let number = self.count;
        self.count += 1;
        let connection = &mut self.connections[whom.connection];
        let asks = match &mut self.kind {
            ServerKind::Socket(answers) => match answers.get(number) {
                Some(ReplySource::Bytes(bytes)) => {
                    connection.send(bytes);
                    false
                }
                Some(ReplySource::Ask) => true,
                None => false,
            },
            ServerKind::Rpc => true,
            ServerKind::Modbus(device) => {
                let reply = device.answer(&data);
                connection.send(&reply);
                false
            }
        };
        connection.waits = asks;
        if self.arrived.len() < ARRIVED_MAX || asks {
            self.arrived.push_back(ReceivedMessage {
                whom,
                number,
                data,
                asks,
            });
        }
    }
}

impl PeerConnection {
    fn send(&mut self, data: &[u8]) {
        if self.unsent.len() + data.len() > UNSENT_BYTES_MAX {
            return self.close();
        }
        self.unsent.extend_from_slice(data);
        self.exchange();
    }

    fn close(&mut self) {
        self.closed = true;
        self.unread.clear();
        // A shutdown tells the peer. An error means that the connection is closed already, which is as good.
        let _ = self.stream.shutdown(std::net::Shutdown::Both);
    }

    /// Sends what there is room for, reads what is there.
    fn exchange(&mut self) {
        while !self.closed && !self.unsent.is_empty() {
            match self.stream.write(&self.unsent) {
                Ok(count) => drop(self.unsent.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => self.closed = true,
            }
        }
        let mut chunk = [0; 4096];
        while !self.closed && self.unread.len() < UNREAD_BYTES_MAX {
            match self.stream.read(&mut chunk) {
                Ok(0) => self.closed = true,
                Ok(count) => self.unread.extend_from_slice(&chunk[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => self.closed = true,
            }
        }
    }
}

/// A message of a socket: a line, with its end, or all there is where no line ends.
fn line_or_all(unread: &[u8]) -> Option<usize> {
    let line = unread.iter().position(|byte| *byte == b'\n');
    line.map(|end| end + 1)
        .or((!unread.is_empty()).then_some(unread.len()))
}

/// Length of the request that `unread` begins with, once it is whole.
fn http_request(unread: &[u8]) -> Result<Option<usize>, ()> {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    let httparse::Status::Complete(head) = request.parse(unread).map_err(drop)? else {
        return Ok(None);
    };
    let mut lengths = request
        .headers
        .iter()
        .filter(|header| header.name.eq_ignore_ascii_case("content-length"));
    let body = match lengths.next() {
        None => 0,
        Some(header) => {
            let text = std::str::from_utf8(header.value).map_err(drop)?;
            text.trim().parse::<usize>().map_err(drop)?
        }
    };
    match head.checked_add(body) {
        Some(whole) if whole <= UNREAD_BYTES_MAX => Ok((unread.len() >= whole).then_some(whole)),
        _ => Err(()),
    }
}

/// The body of a whole request.
pub(crate) fn http_body(request: &[u8]) -> &[u8] {
    let head = request.windows(4).position(|bytes| bytes == b"\r\n\r\n");
    head.and_then(|end| request.get(end + 4..))
        .unwrap_or_default()
}
