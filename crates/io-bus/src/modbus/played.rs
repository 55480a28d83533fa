//! Devices that a test plays: asked on the thread that passes a cycle, before it, so that signals keep simulated time
//! and a test is the same on every machine. Owns the connections to those who play; what is asked is the schedule's.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Read, Write};
use std::time::Duration;

use parking_lot::Mutex;
use platform::sockets::LocalStream;
use tokio::time::Instant;

use super::device::{HEADER_BYTES, begin_connecting, errno, message, note_connection, read_header};
use super::pdu::Reply;
use super::schedule::{PollAction, Schedule, ScheduledRequest, note_reply};
use super::signal::DeviceAddress;
use super::state::SharedModbusState;
use crate::link::SimulatedPeers;

/// Pause after a failure before the device is connected again.
const PAUSE: Duration = Duration::from_millis(100);
/// Replies that are passed over in search of the one that belongs to a request.
const STRAY_REPLIES_MAX: usize = 16;

/// The devices.
#[derive(Default)]
pub(super) struct SimulatedDevices {
    lines: Mutex<BTreeMap<DeviceAddress, SimulatedConnection>>,
}

/// The connection to one device.
#[derive(Default)]
struct SimulatedConnection {
    stream: Option<LocalStream>,
    schedule: Schedule,
    transaction: u16,
    /// Time before which the device is not connected again.
    paused_until: Option<Instant>,
}

impl SimulatedDevices {
    /// Asks what is due before the cycle that begins at `time`.
    pub(super) fn poll_due(&self, shared: &SharedModbusState, time: Duration) {
        let Some(stand_ins) = &shared.stand_ins else {
            return;
        };
        let (now, addresses): (Instant, Vec<DeviceAddress>) = {
            let mut state = shared.state();
            let now = match &mut state.simulated_now {
                Some(played) => played.set(time),
                None => return,
            };
            for (address, device) in &mut state.devices {
                // Signals of the cell are there before the test that plays their device.
                if !device.is_simulated
                    && !device.is_connected
                    && stand_ins.simulates(&address.host, address.port)
                {
                    device.is_simulated = true;
                    device.is_connecting = true;
                    device.has_task = false;
                    device.wake.notify_one();
                }
            }
            let played = state
                .devices
                .iter()
                .filter(|(_, device)| device.is_simulated);
            (now, played.map(|(address, _)| address.clone()).collect())
        };
        if addresses.is_empty() {
            return;
        }
        let mut lines = self.lines.lock();
        lines.retain(|address, _| addresses.contains(address));
        for address in &addresses {
            let line = lines
                .entry(address.clone())
                .or_insert_with(|| SimulatedConnection {
                    schedule: Schedule::for_simulated_device(),
                    ..SimulatedConnection::default()
                });
            line.poll_device(shared, address, stand_ins.as_ref(), now);
        }
        shared.updates.send_modify(|count| *count += 1);
    }
}

impl SimulatedConnection {
    fn poll_device(
        &mut self,
        shared: &SharedModbusState,
        address: &DeviceAddress,
        stand_ins: &dyn SimulatedPeers,
        now: Instant,
    ) {
        if self.paused_until.is_some_and(|until| now < until) {
            return;
        }
        loop {
            if self.stream.is_none() {
                if begin_connecting(shared, address, true).is_none() {
                    return;
                }
                match self.connect(address, stand_ins) {
                    Ok(()) => note_connection(shared, address, true, true, 0),
                    Err(error) => return self.fail(shared, address, now, &error),
                }
            }
            let next = self.schedule.next(&mut shared.state(), address);
            match next {
                PollAction::Send(slave, asked) => match self.exchange(stand_ins, slave, &asked) {
                    Ok(reply) => {
                        let reply = match reply {
                            Some(reply) => asked.request.decode(&reply),
                            None => Ok(Reply::Done),
                        };
                        note_reply(&mut shared.state(), address, &asked, &reply);
                    }
                    Err(error) => return self.fail(shared, address, now, &error),
                },
                PollAction::Reconnect => {
                    self.stream = None;
                    note_connection(shared, address, true, false, 0);
                }
                PollAction::WaitUntil(_) | PollAction::Close => return,
            }
        }
    }

    fn connect(
        &mut self,
        address: &DeviceAddress,
        stand_ins: &dyn SimulatedPeers,
    ) -> io::Result<()> {
        let connected = stand_ins.connect(&address.host, address.port);
        let stream = connected.unwrap_or_else(|| Err(ErrorKind::ConnectionRefused.into()))?;
        stream.set_nonblocking(true)?;
        self.stream = Some(stream);
        Ok(())
    }

    fn fail(
        &mut self,
        shared: &SharedModbusState,
        address: &DeviceAddress,
        now: Instant,
        error: &io::Error,
    ) {
        self.stream = None;
        self.paused_until = Some(now + PAUSE);
        note_connection(shared, address, true, false, errno(error));
    }

    /// One request and its reply; a broadcast has none.
    fn exchange(
        &mut self,
        stand_ins: &dyn SimulatedPeers,
        slave: u8,
        asked: &ScheduledRequest,
    ) -> io::Result<Option<Vec<u8>>> {
        self.transaction = self.transaction.wrapping_add(1);
        let message = message(self.transaction, slave, asked)?;
        let stream = self.stream.as_mut().ok_or(ErrorKind::NotConnected)?;
        stream.write_all(&message)?;
        stand_ins.serve();
        for _ in 0..STRAY_REPLIES_MAX {
            let mut header = [0; HEADER_BYTES];
            match read_exact(stream, &mut header) {
                Err(error) if error.kind() == ErrorKind::TimedOut && slave == 0 => return Ok(None),
                read => read?,
            }
            let (transaction, length) = read_header(header)?;
            let mut reply = vec![0; length];
            read_exact(stream, &mut reply)?;
            if transaction == self.transaction {
                return Ok((slave != 0).then_some(reply));
            }
        }
        Err(ErrorKind::InvalidData.into())
    }
}

/// What is not there now never comes: who plays the device has answered all it will.
fn read_exact(stream: &mut LocalStream, buffer: &mut [u8]) -> io::Result<()> {
    stream
        .read_exact(buffer)
        .map_err(|error| match error.kind() {
            ErrorKind::WouldBlock => ErrorKind::TimedOut.into(),
            _ => error,
        })
}
