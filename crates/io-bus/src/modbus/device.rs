//! The connection to one Modbus device over TCP: connects, asks for what is due, connects again with growing pauses.
//!
//! One request is under way at a time. Neighbouring signals that are due together share a request, until the device
//! refuses that. Ends when no signal and no command uses the device any more.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout, timeout_at};

use super::client::{Custom, DeviceAddress, Shared, Signal, SignalKind, State};
use super::pdu::{PduError, Reply, Request, Table};

/// How long a connection and an answer may take.
const CONNECT_TIME: Duration = Duration::from_secs(2);
const ANSWER_TIME: Duration = Duration::from_secs(1);
/// How long an answer to a broadcast is waited for; usually there is none.
const BROADCAST_TIME: Duration = Duration::from_millis(50);
/// First and longest pause between two attempts to connect.
const PAUSE_MIN: Duration = Duration::from_millis(100);
const PAUSE_MAX: Duration = Duration::from_secs(2);
/// A device that nothing uses is left after this time, so that single commands do not connect anew each time.
const IDLE_TIME: Duration = Duration::from_secs(5);
/// Rate of repeated custom commands.
const CUSTOM_PERIOD: Duration = Duration::from_millis(100);
/// Most values in one read (specification 6.1, 6.3).
const BITS_MAX: u16 = 2000;
const REGISTERS_MAX: u16 = 125;
/// errno values of Linux for failures that carry none: ETIMEDOUT, ECONNRESET, EPROTO, EIO.
const TIMED_OUT: i32 = 110;
const CONNECTION_RESET: i32 = 104;
const PROTOCOL_ERROR: i32 = 71;
const IO_ERROR: i32 = 5;

/// What to do next on a connection.
enum Next {
    /// Ask for the values of these signals at once; each with its place in the answer.
    Read(u8, Request, Vec<(String, u64, usize)>),
    /// Write, or write and read, one signal.
    Write(u8, Request, String, u64),
    /// A command of a script.
    Custom(u8, Request),
    /// Nothing before then.
    Sleep(Instant),
    /// The connection is to be opened anew.
    Reset,
    /// Nobody uses the device.
    Leave,
}

/// The life of a device.
pub(super) async fn run(shared: Arc<Shared>, address: DeviceAddress) {
    let mut pause = PAUSE_MIN;
    let mut idle_since = None;
    while let Some(wake) = begin_connecting(&shared, &address) {
        let connecting = TcpStream::connect((address.host.as_str(), address.port));
        let connected = timeout(CONNECT_TIME, connecting).await;
        let failure = match connected {
            Ok(Ok(stream)) => {
                // Small messages; a system that refuses this only makes them slower.
                let _ = stream.set_nodelay(true);
                note_connection(&shared, &address, true, 0);
                pause = PAUSE_MIN;
                match serve(&shared, &address, stream, &mut idle_since).await {
                    Ok(true) => return,
                    Ok(false) => {
                        note_connection(&shared, &address, false, 0);
                        continue;
                    }
                    Err(error) => error,
                }
            }
            Ok(Err(error)) => error,
            Err(_elapsed) => io::ErrorKind::TimedOut.into(),
        };
        note_connection(&shared, &address, false, errno(&failure));
        // A reset or a new signal ends the pause only if it has been asked for; other wakes are for open connections.
        let until = Instant::now() + pause;
        while timeout_at(until, wake.notified()).await.is_ok() {
            let state = shared.state();
            if state
                .devices
                .get(&address)
                .is_none_or(|device| device.wants_reset)
            {
                break;
            }
        }
        pause = (2 * pause).min(PAUSE_MAX);
    }
}

/// Marks the device as connecting. `None`, and the device is forgotten, when nobody uses it.
fn begin_connecting(shared: &Shared, address: &DeviceAddress) -> Option<Arc<tokio::sync::Notify>> {
    let mut state = shared.state();
    if !is_used(&state, address) {
        state.devices.remove(address);
        return None;
    }
    let device = state.devices.get_mut(address)?;
    device.wants_reset = false;
    device.is_connecting = true;
    Some(device.wake.clone())
}

fn is_used(state: &State, address: &DeviceAddress) -> bool {
    let has_commands = |device: &super::client::Device| !device.custom.is_empty();
    state.devices.get(address).is_some_and(has_commands)
        || state
            .signals
            .values()
            .any(|signal| signal.spec.device == *address)
}

fn note_connection(shared: &Shared, address: &DeviceAddress, connected: bool, errno: i32) {
    let mut state = shared.state();
    if let Some(device) = state.devices.get_mut(address) {
        device.is_connected = connected;
        device.is_connecting = false;
        device.connections += u64::from(connected);
        device.errno = errno;
    }
    drop(state);
    shared.updates.send_modify(|count| *count += 1);
}

fn errno(error: &io::Error) -> i32 {
    error.raw_os_error().unwrap_or(match error.kind() {
        io::ErrorKind::TimedOut => TIMED_OUT,
        io::ErrorKind::UnexpectedEof => CONNECTION_RESET,
        io::ErrorKind::InvalidData => PROTOCOL_ERROR,
        _ => IO_ERROR,
    })
}

/// Uses a connection until it breaks (error), is to be opened anew (false) or is not needed any more (true).
async fn serve(
    shared: &Shared,
    address: &DeviceAddress,
    mut stream: TcpStream,
    idle_since: &mut Option<Instant>,
) -> io::Result<bool> {
    let wake = match shared.state().devices.get(address) {
        Some(device) => device.wake.clone(),
        None => return Ok(true),
    };
    let mut transaction = 0_u16;
    loop {
        let next = next(&mut shared.state(), address, idle_since);
        let (slave, request) = match &next {
            Next::Read(slave, request, _)
            | Next::Write(slave, request, ..)
            | Next::Custom(slave, request) => (*slave, request),
            Next::Sleep(until) => {
                let mut byte = [0];
                tokio::select! {
                    () = wake.notified() => {}
                    () = tokio::time::sleep_until(*until) => {}
                    // Nothing is asked, so nothing should come: the peer closes, or a late answer arrives and is dropped.
                    read = stream.read(&mut byte) => if read? == 0 {
                        return Err(io::ErrorKind::UnexpectedEof.into());
                    }
                }
                continue;
            }
            Next::Reset => return Ok(false),
            Next::Leave => return Ok(true),
        };
        transaction = transaction.wrapping_add(1);
        let patience = if slave == 0 {
            BROADCAST_TIME
        } else {
            ANSWER_TIME
        };
        let answer = timeout(patience, transact(&mut stream, transaction, slave, request)).await;
        let reply = match answer {
            Ok(reply) => reply?,
            Err(_elapsed) if slave == 0 => Ok(Reply::Done),
            Err(_elapsed) => return Err(io::ErrorKind::TimedOut.into()),
        };
        note_reply(&mut shared.state(), next, reply);
        shared.updates.send_modify(|count| *count += 1);
    }
}

/// One request and its answer; answers to other requests are passed over.
async fn transact(
    stream: &mut TcpStream,
    transaction: u16,
    slave: u8,
    request: &Request,
) -> io::Result<Result<Reply, PduError>> {
    let pdu = request.encode();
    let length = u16::try_from(1 + pdu.len()).map_err(|_| io::ErrorKind::InvalidInput)?;
    let mut message = Vec::with_capacity(7 + pdu.len());
    message.extend(transaction.to_be_bytes());
    message.extend([0, 0]);
    message.extend(length.to_be_bytes());
    message.push(slave);
    message.extend(pdu);
    stream.write_all(&message).await?;
    loop {
        let mut header = [0; 7];
        stream.read_exact(&mut header).await?;
        let [t1, t0, p1, p0, l1, l0, _unit] = header;
        let length = usize::from(u16::from_be_bytes([l1, l0]));
        if [p1, p0] != [0, 0] || !(2..=254).contains(&length) {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let mut reply = vec![0; length - 1];
        stream.read_exact(&mut reply).await?;
        if u16::from_be_bytes([t1, t0]) == transaction {
            return Ok(request.decode(&reply));
        }
    }
}

/// What is due first: commands of scripts, then the signal that is due longest, with the neighbours due together with it.
fn next(state: &mut State, address: &DeviceAddress, idle_since: &mut Option<Instant>) -> Next {
    let now = Instant::now();
    let State {
        signals, devices, ..
    } = state;
    let Some(device) = devices.get_mut(address) else {
        return Next::Leave;
    };
    if device.wants_reset {
        return Next::Reset;
    }
    if let Some(place) = device.custom.iter().position(|custom| custom.due <= now) {
        let custom = device.custom.remove(place);
        let (slave, request) = (custom.slave, custom.request.clone());
        if custom.repeats {
            let due = now + CUSTOM_PERIOD;
            device.custom.push(Custom { due, ..custom });
        }
        return Next::Custom(slave, request);
    }
    let own = || {
        signals
            .iter()
            .filter(|(_, signal)| signal.spec.device == *address)
    };
    let active = own().filter(|(_, signal)| signal.period.is_some());
    // Sequential signals take their turns in the order in which they were added.
    let key = |signal: &Signal| match signal.spec.is_sequential && signal.due <= now {
        true => (now, signal.order),
        false => (signal.due, signal.order),
    };
    let Some((name, first)) = active.min_by_key(|(_, signal)| key(signal)) else {
        if own().next().is_some() || !device.custom.is_empty() {
            *idle_since = None;
            return Next::Sleep(now + CUSTOM_PERIOD);
        }
        let since = *idle_since.get_or_insert(now);
        if now.duration_since(since) < IDLE_TIME {
            return Next::Sleep(since + IDLE_TIME);
        }
        devices.remove(address);
        return Next::Leave;
    };
    *idle_since = None;
    if first.due > now {
        let custom = device.custom.iter().map(|custom| custom.due).min();
        return Next::Sleep(custom.map_or(first.due, |due| due.min(first.due)));
    }
    let (name, slave) = (name.clone(), first.spec.slave);
    let next = match write(first) {
        Some(request) => Next::Write(slave, request, name, first.order),
        None => {
            let (request, members) = together(signals, address, &name, now);
            Next::Read(slave, request, members)
        }
    };
    let members = match &next {
        Next::Read(_, _, members) => members.iter().map(|(name, ..)| name.clone()).collect(),
        Next::Write(_, _, name, _) => vec![name.clone()],
        _ => Vec::new(),
    };
    for name in members {
        if let Some(signal) = signals.get_mut(&name)
            && let Some(period) = signal.period
        {
            let late = now.duration_since(signal.due);
            if late > period && signal.last_good.is_some() {
                signal.missed += 1;
            }
            // The rate is kept on average; what is lost for good is not made up for.
            signal.due = if late > period { now } else { signal.due } + period;
        }
    }
    next
}

/// The request that sets an output; `None` for a signal that is only read.
fn write(signal: &Signal) -> Option<Request> {
    let (address, output) = (signal.spec.address, &signal.output);
    let levels = || output.iter().map(|value| *value != 0).collect();
    Some(match (signal.spec.kind, output.as_slice()) {
        (_, []) => return None,
        (SignalKind::DigitalOutput, [value]) => Request::WriteCoil(address, *value != 0),
        (SignalKind::DigitalOutput, _) => Request::WriteCoils(address, levels()),
        (SignalKind::RegisterOutput, [value]) => Request::WriteRegister(address, *value),
        (SignalKind::RegisterOutput, _) => Request::WriteRegisters(address, output.clone()),
        (SignalKind::ReadWrite { write_address, .. }, _) => Request::ReadWrite {
            read: address,
            count: signal.spec.count,
            write: write_address,
            values: output.clone(),
        },
        (SignalKind::DigitalInput | SignalKind::RegisterInput, _) => return None,
    })
}

/// The read of one signal together with those that are due too and touch it in the same table of the same slave.
fn together(
    signals: &BTreeMap<String, Signal>,
    address: &DeviceAddress,
    name: &str,
    now: Instant,
) -> (Request, Vec<(String, u64, usize)>) {
    let first = &signals[name];
    let table: Table = first.spec.table();
    let is_free = |signal: &Signal| !signal.alone && !signal.spec.is_sequential;
    let end = |signal: &Signal| u32::from(signal.spec.address) + u32::from(signal.spec.count);
    let mut others: Vec<(&String, &Signal)> = if is_free(first) {
        let fits = |signal: &Signal| {
            signal.spec.device == *address
                && signal.spec.slave == first.spec.slave
                && signal.spec.table() == table
                && signal.period.is_some()
                && signal.due <= now
                && is_free(signal)
                && write(signal).is_none()
        };
        signals.iter().filter(|(_, signal)| fits(signal)).collect()
    } else {
        vec![
            signals
                .get_key_value(name)
                .unwrap_or_else(|| unreachable!("it was found above")),
        ]
    };
    others.sort_by_key(|(_, signal)| (signal.spec.address, signal.order));
    let most = u32::from(if table.is_bits() {
        BITS_MAX
    } else {
        REGISTERS_MAX
    });
    // Runs of touching ranges from left to right; the one with the wanted signal counts.
    let mut run: Vec<(&String, &Signal)> = Vec::new();
    let (mut begin, mut stop) = (0, 0);
    for (other, signal) in others {
        let touches = u32::from(signal.spec.address) <= stop;
        if run.is_empty() || !touches || end(signal).max(stop) - begin > most {
            if run.iter().any(|(member, _)| *member == name) {
                break;
            }
            run.clear();
            (begin, stop) = (u32::from(signal.spec.address), end(signal));
        }
        stop = stop.max(end(signal));
        run.push((other, signal));
    }
    let request = Request::Read {
        table,
        address: begin as u16,
        count: (stop - begin) as u16,
    };
    let place = |signal: &Signal| usize::from(signal.spec.address) - begin as usize;
    let members = run
        .iter()
        .map(|(name, signal)| ((*name).clone(), signal.order, place(signal)));
    (request, members.collect())
}

/// Puts an answer into the signals it is for.
fn note_reply(state: &mut State, asked: Next, reply: Result<Reply, PduError>) {
    let members = match asked {
        Next::Read(_, _, members) => members,
        Next::Write(_, _, name, order) => vec![(name, order, 0)],
        _ => return,
    };
    let shared = members.len() > 1;
    for (name, order, place) in members {
        // It may have been deleted or replaced meanwhile.
        let Some(signal) = state
            .signals
            .get_mut(&name)
            .filter(|signal| signal.order == order)
        else {
            continue;
        };
        match &reply {
            Ok(reply) => {
                if let Reply::Values(values) = reply
                    && (signal.output.is_empty()
                        || matches!(signal.spec.kind, SignalKind::ReadWrite { .. }))
                {
                    let count = usize::from(signal.spec.count);
                    let values = values.iter().skip(place).take(count);
                    signal.values = values.copied().collect();
                }
                signal.last_good = Some(Instant::now());
                signal.device_error = 0;
            }
            Err(PduError::Exception(_)) if shared => {
                // Perhaps the device does not give both at once: each is asked for alone from now on.
                signal.alone = true;
                signal.due = Instant::now();
            }
            Err(PduError::Exception(code)) => signal.device_error = i32::from(*code),
            // Not defined (table 6-2).
            Err(PduError::Malformed) => signal.device_error = 9,
        }
    }
}
