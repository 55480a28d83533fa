//! Grippers on Modbus TCP within this process: under the virtual clock programs reach them without a port of the
//! machine, so that what they write arrives in the same cycle every time, and tests run side by side.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{IpAddr, Shutdown};
use std::sync::{Arc, OnceLock, Weak};
use std::time::Duration;

use elite_runtime::Robot;
use io_bus::modbus_server::codec::{ADU_BYTES_MAX, build_slave_reply, message_bytes};
use io_bus::modbus_server::tables::Slaves;
use io_bus::{Fieldbus, SimulatedPeers};
use motion_api::Timeline;
use parking_lot::Mutex;
use platform::sockets::{self, LocalStream};

/// Most connections to grippers at a time.
const CONNECTIONS_MAX: usize = 64;

/// The grippers on Modbus TCP, beside machines that somebody else plays.
pub(crate) struct GripperPeers {
    ports: BTreeMap<u16, Slaves>,
    others: Option<Arc<dyn SimulatedPeers>>,
    connections: Mutex<Vec<Connection>>,
}

struct Connection {
    stream: LocalStream,
    port: u16,
    unread: Vec<u8>,
}

impl GripperPeers {
    pub(crate) fn new(
        ports: BTreeMap<u16, Slaves>,
        others: Option<Arc<dyn SimulatedPeers>>,
    ) -> Self {
        Self {
            ports,
            others,
            connections: Mutex::default(),
        }
    }

    fn has_gripper(&self, host: &str, port: u16) -> bool {
        let is_loopback = match host.parse::<IpAddr>() {
            Ok(address) => address.is_loopback(),
            Err(_) => host.eq_ignore_ascii_case("localhost"),
        };
        is_loopback && self.ports.contains_key(&port)
    }

    fn open(&self, port: u16) -> io::Result<LocalStream> {
        let mut connections = self.connections.lock();
        if connections.len() >= CONNECTIONS_MAX {
            return Err(ErrorKind::ConnectionRefused.into());
        }
        let (own, other) = sockets::pair()?;
        own.set_nonblocking(true)?;
        connections.push(Connection {
            stream: own,
            port,
            unread: Vec::new(),
        });
        Ok(other)
    }
}

impl SimulatedPeers for GripperPeers {
    fn simulates(&self, host: &str, port: u16) -> bool {
        let others = self.others.as_ref();
        self.has_gripper(host, port) || others.is_some_and(|others| others.simulates(host, port))
    }

    fn answers(&self, host: &str, port: u16) -> bool {
        let others = self.others.as_ref();
        self.has_gripper(host, port) || others.is_some_and(|others| others.answers(host, port))
    }

    fn connect(&self, host: &str, port: u16) -> Option<io::Result<LocalStream>> {
        match self.has_gripper(host, port) {
            true => Some(self.open(port)),
            false => self.others.as_ref()?.connect(host, port),
        }
    }

    fn serve(&self) {
        self.connections.lock().retain_mut(|connection| {
            let slaves = self.ports.get(&connection.port);
            slaves.is_some_and(|slaves| connection.serve(slaves).is_ok())
        });
        if let Some(others) = &self.others {
            others.serve();
        }
    }
}

impl Connection {
    /// Answers every whole request that has come.
    ///
    /// # Errors
    /// The connection has ended, or what comes is not Modbus TCP.
    fn serve(&mut self, slaves: &Slaves) -> io::Result<()> {
        let mut chunk = [0; ADU_BYTES_MAX];
        loop {
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.unread.extend_from_slice(&chunk[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) => return Err(error),
            }
            while let Some(length) = message_bytes(&self.unread).map_err(io::Error::other)?
                && length <= self.unread.len()
            {
                // A client that does not read what it asked for is none that is waited for.
                self.stream
                    .write_all(&build_slave_reply(&self.unread[..length], slaves))?;
                self.unread.drain(..length);
            }
        }
    }
}

/// The timeline of programs that reach grippers within this process: what they have sent is answered before a cycle
/// passes.
pub(crate) struct GripperTimeline {
    inner: Arc<dyn Timeline>,
    peers: Arc<GripperPeers>,
    /// The robot has this timeline, and so is not kept alive by it.
    robot: OnceLock<(Weak<Robot>, Weak<Fieldbus>)>,
}

impl GripperTimeline {
    pub(crate) fn new(inner: Arc<dyn Timeline>, peers: Arc<GripperPeers>) -> Self {
        Self {
            inner,
            peers,
            robot: OnceLock::new(),
        }
    }

    /// Says whose time it is and which signals keep it.
    pub(crate) fn attach(&self, robot: &Arc<Robot>, fieldbus: &Arc<Fieldbus>) {
        // Told once: a second time changes nothing.
        let _ = self
            .robot
            .set((Arc::downgrade(robot), Arc::downgrade(fieldbus)));
    }
}

impl Timeline for GripperTimeline {
    fn is_virtual(&self) -> bool {
        self.inner.is_virtual()
    }

    fn advance(&self) -> bool {
        self.peers.serve();
        let attached = self.robot.get();
        if let Some((robot, fieldbus)) = attached
            && let (Some(robot), Some(fieldbus)) = (robot.upgrade(), fieldbus.upgrade())
        {
            let time = Duration::from_secs_f64(robot.state().time.max(0.0));
            fieldbus.modbus.poll_simulated_devices(time);
        }
        self.inner.advance()
    }

    fn set_driven(&self, on: bool) {
        self.inner.set_driven(on);
    }

    fn idle_until(&self, cycle: u64) {
        self.inner.idle_until(cycle);
    }

    fn has_ended(&self) -> bool {
        self.inner.has_ended()
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        // An error means that the connection has ended already.
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}
