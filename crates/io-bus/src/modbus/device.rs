//! The connection to one Modbus device over TCP: connects, asks what the schedule says, connects again with growing
//! pauses.
//!
//! One request is under way at a time while that keeps the rates, as the simplest devices need it. When signals come
//! late, up to [`MAX_PENDING`] are (MODBUS Messaging on TCP/IP Implementation Guide V1.0b, 4.2.2), until the device
//! does not answer that once. Ends when no signal and no command uses the device any more.

use std::collections::VecDeque;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt, BufStream};
use tokio::time::{Instant, timeout, timeout_at};

use supervision::injection;

use super::pdu::Reply;
use super::schedule::{PollAction, Schedule, ScheduledRequest, note_reply};
use super::signal::DeviceAddress;
use super::state::{ModbusState, SharedModbusState};
use crate::link::PeerStream;

/// Longest time for a connection, and for an answer.
const CONNECT_TIME: Duration = Duration::from_secs(2);
const ANSWER_TIME: Duration = Duration::from_secs(1);
/// How long an answer to a broadcast is waited for; usually there is none.
const BROADCAST_TIME: Duration = Duration::from_millis(50);
/// First and longest pause between two attempts to connect.
const MIN_RECONNECT_DELAY: Duration = Duration::from_millis(100);
const MAX_RECONNECT_DELAY: Duration = Duration::from_secs(2);
/// Requests under way at most. Devices that take several take up to 16 (same guide); half of that is enough for
/// thousands of requests a second.
const MAX_PENDING: usize = 8;
/// Transaction, protocol, length, unit.
pub(super) const HEADER_BYTES: usize = 7;
/// errno values of Linux for failures that carry none: ETIMEDOUT, ECONNRESET, EPROTO, EIO.
const TIMED_OUT: i32 = 110;
const CONNECTION_RESET: i32 = 104;
const PROTOCOL_ERROR: i32 = 71;
const IO_ERROR: i32 = 5;

/// How a connection was used to its end.
enum ConnectionEnd {
    /// The connection is to be opened anew.
    Reset,
    /// Nobody uses the device.
    Unused,
}

/// The life of a device.
pub(super) async fn serve_device(shared: Arc<SharedModbusState>, address: DeviceAddress) {
    let mut pause = MIN_RECONNECT_DELAY;
    // Kept over connections: a device that does not answer several requests at once never will.
    let mut one_by_one = false;
    while let Some(wake) = begin_connecting(&shared, &address, false) {
        injection::point("modbus");
        // Who stands in for a device is asked by `played`.
        let connecting = PeerStream::open(&address.host, address.port, None);
        let connected = timeout(CONNECT_TIME, connecting).await;
        let failure = match connected {
            Ok(Ok(stream)) => {
                note_connection(&shared, &address, false, true, 0);
                pause = MIN_RECONNECT_DELAY;
                let mut connection = Connection::new(stream, one_by_one);
                let used = connection.serve(&shared, &address).await;
                one_by_one |= used.is_err() && connection.under_way.len() > 1;
                match used {
                    Ok(ConnectionEnd::Unused) => return,
                    Ok(ConnectionEnd::Reset) => {
                        note_connection(&shared, &address, false, false, 0);
                        continue;
                    }
                    Err(error) => error,
                }
            }
            Ok(Err(error)) => error,
            Err(_elapsed) => io::ErrorKind::TimedOut.into(),
        };
        note_connection(&shared, &address, false, false, errno(&failure));
        // A reset or a new signal ends the pause only if it has been asked for; other wakes are for open connections.
        let until = Instant::now() + pause;
        while timeout_at(until, wake.notified()).await.is_ok() {
            let state = shared.state();
            let device = state.devices.get(&address);
            if device.is_none_or(|device| device.is_reset_requested || device.is_simulated) {
                break;
            }
        }
        pause = (2 * pause).min(MAX_RECONNECT_DELAY);
    }
}

/// Marks the device as connecting. `None` when somebody else keeps it, or when nobody uses it; then it is forgotten.
pub(super) fn begin_connecting(
    shared: &SharedModbusState,
    address: &DeviceAddress,
    is_played: bool,
) -> Option<Arc<tokio::sync::Notify>> {
    let mut state = shared.state();
    if state.devices.get(address)?.is_simulated != is_played {
        return None;
    }
    if !is_used(&state, address) {
        state.devices.remove(address);
        return None;
    }
    let device = state.devices.get_mut(address)?;
    device.is_reset_requested = false;
    // A fault may have ended the connection before this one without saying so.
    device.is_connected = false;
    device.is_connecting = true;
    Some(device.wake.clone())
}

fn is_used(state: &ModbusState, address: &DeviceAddress) -> bool {
    let device = state.devices.get(address);
    device.is_some_and(|device| !device.custom.is_empty())
        || state.signals.values().any(|s| s.spec.device == *address)
}

pub(super) fn note_connection(
    shared: &SharedModbusState,
    address: &DeviceAddress,
    is_played: bool,
    connected: bool,
    errno: i32,
) {
    let mut state = shared.state();
    let device = state.devices.get(address);
    if device.is_none_or(|device| device.is_simulated != is_played) {
        return;
    }
    if let Some(device) = state.devices.get_mut(address) {
        device.is_connected = connected;
        device.is_connecting = false;
        device.connections += u64::from(connected);
        // A connection alone makes nothing valid: how the last one failed is told until there is an answer.
        if !connected {
            device.errno = errno;
        }
    }
    if errno != 0 {
        state.note_failure(address);
    }
    drop(state);
    shared.updates.send_modify(|count| *count += 1);
}

pub(super) fn errno(error: &io::Error) -> i32 {
    error.raw_os_error().unwrap_or(match error.kind() {
        io::ErrorKind::TimedOut => TIMED_OUT,
        io::ErrorKind::UnexpectedEof => CONNECTION_RESET,
        io::ErrorKind::InvalidData => PROTOCOL_ERROR,
        _ => IO_ERROR,
    })
}

/// An open connection.
struct Connection {
    stream: BufStream<PeerStream>,
    schedule: Schedule,
    under_way: VecDeque<PendingRequest>,
    is_sequential: bool,
    transaction: u16,
}

/// A request whose answer is waited for.
struct PendingRequest {
    transaction: u16,
    slave: u8,
    asked: ScheduledRequest,
    deadline: Instant,
}

impl Connection {
    fn new(stream: PeerStream, one_by_one: bool) -> Self {
        Self {
            stream: BufStream::new(stream),
            schedule: Schedule::default(),
            under_way: VecDeque::new(),
            is_sequential: one_by_one,
            transaction: 0,
        }
    }

    /// Uses the connection until it breaks (error) or is not needed any more.
    async fn serve(
        &mut self,
        shared: &SharedModbusState,
        address: &DeviceAddress,
    ) -> io::Result<ConnectionEnd> {
        let wake = match shared.state().devices.get(address) {
            Some(device) => device.wake.clone(),
            None => return Ok(ConnectionEnd::Unused),
        };
        loop {
            let sleep_until = match self.send_due(shared, address).await? {
                Some(PollAction::Reconnect) => return Ok(ConnectionEnd::Reset),
                Some(PollAction::Close) => return Ok(ConnectionEnd::Unused),
                Some(PollAction::WaitUntil(until)) => until,
                _ => Instant::now(),
            };
            if let Some(oldest) = self.under_way.front() {
                let answered = timeout_at(oldest.deadline, self.take_answer(shared, address)).await;
                match answered {
                    Ok(answered) => answered?,
                    Err(_elapsed) => self.expire_oldest(shared, address)?,
                }
                continue;
            }
            tokio::select! {
                () = wake.notified() => {}
                () = tokio::time::sleep_until(sleep_until) => {}
                // Nothing is asked, so nothing should come: the peer closes, or a late answer arrives and is dropped.
                read = self.stream.read_u8() => drop(read?),
            }
        }
    }

    /// Sends what is due, as much as may be under way. What else there is to do, if the schedule said it.
    async fn send_due(
        &mut self,
        shared: &SharedModbusState,
        address: &DeviceAddress,
    ) -> io::Result<Option<PollAction>> {
        let most = match self.schedule.is_behind && !self.is_sequential {
            true => MAX_PENDING,
            false => 1,
        };
        // Refilled when half is answered, so that several go in one write.
        if self.under_way.len() > most / 2 {
            return Ok(None);
        }
        let mut other = None;
        while self.under_way.len() < most && !self.waits_for_broadcast() {
            let next = self.schedule.next(&mut shared.state(), address);
            let PollAction::Send(slave, asked) = next else {
                other = Some(next);
                break;
            };
            self.transaction = self.transaction.wrapping_add(1);
            let message = message(self.transaction, slave, &asked)?;
            self.stream.write_all(&message).await?;
            let patience = match slave {
                0 => BROADCAST_TIME,
                _ => ANSWER_TIME,
            };
            self.under_way.push_back(PendingRequest {
                transaction: self.transaction,
                slave,
                asked,
                deadline: Instant::now() + patience,
            });
        }
        timeout(ANSWER_TIME, self.stream.flush())
            .await
            .map_err(|_elapsed| io::ErrorKind::TimedOut)??;
        Ok(other)
    }

    /// A broadcast is over when its time is: what comes then answers nothing.
    fn waits_for_broadcast(&self) -> bool {
        self.under_way.back().is_some_and(|last| last.slave == 0)
    }

    /// Takes one answer; one to a request that nobody made is passed over.
    async fn take_answer(
        &mut self,
        shared: &SharedModbusState,
        address: &DeviceAddress,
    ) -> io::Result<()> {
        // Header and answer are read in one go: when the time is over in between, the connection is given up.
        let mut header = [0; HEADER_BYTES];
        self.stream.read_exact(&mut header).await?;
        let (transaction, length) = read_header(header)?;
        let mut reply = vec![0; length];
        self.stream.read_exact(&mut reply).await?;
        let place = self
            .under_way
            .iter()
            .position(|u| u.transaction == transaction);
        if let Some(found) = place.and_then(|place| self.under_way.remove(place)) {
            let reply = found.asked.request.decode(&reply);
            note_reply(&mut shared.state(), address, &found.asked, &reply);
            shared.updates.send_modify(|count| *count += 1);
        }
        Ok(())
    }

    /// The oldest request has no answer in time: for a broadcast that is how it should be.
    fn expire_oldest(
        &mut self,
        shared: &SharedModbusState,
        address: &DeviceAddress,
    ) -> io::Result<()> {
        match self.under_way.front() {
            Some(oldest) if oldest.slave == 0 => {
                note_reply(
                    &mut shared.state(),
                    address,
                    &oldest.asked,
                    &Ok(Reply::Done),
                );
                self.under_way.pop_front();
                shared.updates.send_modify(|count| *count += 1);
                Ok(())
            }
            _ => Err(io::ErrorKind::TimedOut.into()),
        }
    }
}

/// The transaction that a header names, and the length of the reply behind it.
pub(super) fn read_header(header: [u8; HEADER_BYTES]) -> io::Result<(u16, usize)> {
    let [t1, t0, p1, p0, l1, l0, _unit] = header;
    let length = usize::from(u16::from_be_bytes([l1, l0]));
    if [p1, p0] != [0, 0] || !(2..=254).contains(&length) {
        return Err(io::ErrorKind::InvalidData.into());
    }
    Ok((u16::from_be_bytes([t1, t0]), length - 1))
}

/// A request with its header (same guide, 3.1.3).
pub(super) fn message(
    transaction: u16,
    slave: u8,
    asked: &ScheduledRequest,
) -> io::Result<Vec<u8>> {
    let pdu = asked.request.encode();
    let length = u16::try_from(1 + pdu.len()).map_err(|_| io::ErrorKind::InvalidInput)?;
    let mut message = Vec::with_capacity(7 + pdu.len());
    message.extend(transaction.to_be_bytes());
    message.extend([0, 0]);
    message.extend(length.to_be_bytes());
    message.push(slave);
    message.extend(pdu);
    Ok(message)
}
