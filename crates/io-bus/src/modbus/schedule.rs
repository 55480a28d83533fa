//! What a Modbus device is asked next: a round of everything that is due, in order, neighbours together. Knows no
//! socket.
//!
//! A round is made when the one before is used up or something has changed, so that asking for one of 200 signals does
//! not look at the other 199. What is written, and when a signal is due again, is decided when it is asked, not before.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::Instant;

use super::pdu::{PduError, Reply, Request};
use super::signal::{DeviceAddress, Signal, SignalKind};
use super::state::{CustomRequest, ModbusState};

/// A device that nothing uses is left after this time, so that single commands do not connect anew each time.
const IDLE_TIME: Duration = Duration::from_secs(5);
/// Rate of repeated custom commands; also how often a device without due signals is looked at.
const CUSTOM_PERIOD: Duration = Duration::from_millis(100);
/// Most values in one read (specification 6.1, 6.3).
const BITS_MAX: u16 = 2000;
const REGISTERS_MAX: u16 = 125;

/// What to do next on a connection.
#[derive(Debug)]
pub(super) enum PollAction {
    /// Send this to the slave.
    Send(u8, ScheduledRequest),
    /// Nothing before then.
    WaitUntil(Instant),
    /// The connection is to be opened anew.
    Reconnect,
    /// Nobody uses the device.
    Close,
}

/// A request, and whose answer it brings.
#[derive(Debug)]
pub(super) struct ScheduledRequest {
    pub(super) request: Request,
    members: Vec<SignalRef>,
}

/// A signal in a request: its name, its order (it may be replaced meanwhile), its place in the answer.
#[derive(Clone, Debug)]
struct SignalRef {
    name: String,
    order: u64,
    offset: usize,
}

/// Signals that are asked for with one request.
#[derive(Debug)]
struct PollGroup {
    slave: u8,
    /// `None`: the one member is written.
    read: Option<Request>,
    members: Vec<SignalRef>,
}

/// The rounds of one connection.
#[derive(Debug, Default)]
pub(super) struct Schedule {
    poll_queue: VecDeque<PollGroup>,
    /// When the first signal that is not in the round is due.
    next_due: Option<Instant>,
    idle_since: Option<Instant>,
    /// The device is one that a test plays.
    is_simulated: bool,
    /// Signals come late by more than half their period.
    pub(super) is_behind: bool,
}

impl Schedule {
    /// The schedule of a device that a test plays.
    pub(super) fn for_simulated_device() -> Self {
        Self {
            is_simulated: true,
            ..Self::default()
        }
    }

    /// What is to be done now: commands of scripts first, then what is due.
    pub(super) fn next(&mut self, state: &mut ModbusState, address: &DeviceAddress) -> PollAction {
        let now = state.now_of(address);
        let Some(device) = state.devices.get_mut(address) else {
            return PollAction::Close;
        };
        if device.is_simulated != self.is_simulated {
            // Somebody else has taken the device over.
            return PollAction::Close;
        }
        if device.is_reset_requested {
            return PollAction::Reconnect;
        }
        if let Some(place) = device.custom.iter().position(|custom| custom.due <= now) {
            return custom(device.custom.remove(place), &mut device.custom, now);
        }
        let next_custom = device.custom.iter().map(|custom| custom.due).min();
        if core::mem::take(&mut device.has_changes) {
            self.poll_queue.clear();
        }
        if self.poll_queue.is_empty() {
            self.begin_round(state, address, now);
        }
        while let Some(job) = self.poll_queue.pop_front() {
            if let Some(asked) = job.prepare_request(state, now) {
                self.idle_since = None;
                return PollAction::Send(job.slave, asked);
            }
        }
        if let Some(due) = self.next_due.into_iter().chain(next_custom).min() {
            self.idle_since = None;
            return PollAction::WaitUntil(due);
        }
        if state.signals.values().any(|s| s.spec.device == *address) {
            // None of them has a rate.
            self.idle_since = None;
            return PollAction::WaitUntil(now + CUSTOM_PERIOD);
        }
        let since = *self.idle_since.get_or_insert(now);
        if now.duration_since(since) < IDLE_TIME {
            return PollAction::WaitUntil(since + IDLE_TIME);
        }
        state.devices.remove(address);
        PollAction::Close
    }

    /// Everything that is due, in the order in which it became due; sequential signals in the order in which they were
    /// added.
    fn begin_round(&mut self, state: &ModbusState, address: &DeviceAddress, now: Instant) {
        self.next_due = None;
        self.is_behind = false;
        let mut jobs: Vec<((Instant, u64), PollGroup)> = Vec::new();
        let mut shared: Vec<(&String, &Signal)> = Vec::new();
        for (name, signal) in &state.signals {
            let Some(period) = signal.period.filter(|_| signal.spec.device == *address) else {
                continue;
            };
            if signal.due_at > now {
                let due = signal.due_at;
                self.next_due = Some(self.next_due.map_or(due, |other| other.min(due)));
                continue;
            }
            self.is_behind |= signal.lateness(now) > period / 2;
            if signal.write_request().is_some() {
                let job = PollGroup {
                    slave: signal.spec.slave,
                    read: None,
                    members: vec![SignalRef::new(name, signal, 0)],
                };
                jobs.push((due_order(signal, now), job));
            } else if signal.is_polled_alone || signal.spec.is_sequential {
                jobs.push((due_order(signal, now), read(&[(name, signal)])));
            } else {
                shared.push((name, signal));
            }
        }
        for run in adjacent_groups(shared) {
            // A run is due when the first of its signals is.
            let first = run.iter().map(|(_, signal)| due_order(signal, now)).min();
            jobs.push((first.unwrap_or((now, 0)), read(&run)));
        }
        jobs.sort_by_key(|(key, _)| *key);
        self.poll_queue = jobs.into_iter().map(|(_, job)| job).collect();
    }
}

impl SignalRef {
    fn new(name: &str, signal: &Signal, place: usize) -> Self {
        Self {
            name: name.to_owned(),
            order: signal.order,
            offset: place,
        }
    }

    /// The signal, unless it has been deleted or replaced.
    fn resolve<'s>(&self, state: &'s mut ModbusState) -> Option<&'s mut Signal> {
        let signal = state.signals.get_mut(&self.name)?;
        (signal.order == self.order).then_some(signal)
    }
}

impl PollGroup {
    /// The request as it is now; `None` when nobody is left to ask for.
    fn prepare_request(&self, state: &mut ModbusState, now: Instant) -> Option<ScheduledRequest> {
        let mut request = self.read.clone();
        let mut is_wanted = false;
        for member in &self.members {
            let Some(signal) = member.resolve(state) else {
                continue;
            };
            is_wanted = true;
            signal.schedule_next(now);
            request = request.or_else(|| signal.write_request());
        }
        Some(ScheduledRequest {
            request: request.filter(|_| is_wanted)?,
            members: self.members.clone(),
        })
    }
}

fn custom(command: CustomRequest, waiting: &mut Vec<CustomRequest>, now: Instant) -> PollAction {
    let asked = ScheduledRequest {
        request: command.request.clone(),
        members: Vec::new(),
    };
    let slave = command.slave;
    if command.repeats {
        let due = now + CUSTOM_PERIOD;
        waiting.push(CustomRequest { due, ..command });
    }
    PollAction::Send(slave, asked)
}

/// Sequential signals take their turns in the order in which they were added.
fn due_order(signal: &Signal, now: Instant) -> (Instant, u64) {
    match signal.spec.is_sequential {
        true => (now, signal.order),
        false => (signal.due_at, signal.order),
    }
}

/// Signals of one table of one slave whose ranges touch, as far as one request reaches.
fn adjacent_groups<'s>(
    mut signals: Vec<(&'s String, &'s Signal)>,
) -> Vec<Vec<(&'s String, &'s Signal)>> {
    let table_of = |signal: &Signal| (signal.spec.slave, signal.spec.table());
    signals.sort_by_key(|(_, signal)| (table_of(signal), signal.spec.address, signal.order));
    let mut runs: Vec<Vec<(&String, &Signal)>> = Vec::new();
    let (mut begin, mut end) = (0, 0);
    for (name, signal) in signals {
        let most = u32::from(if signal.spec.table().is_bits() {
            BITS_MAX
        } else {
            REGISTERS_MAX
        });
        let (first, last) = range(signal);
        let run = runs.last_mut().filter(|run| {
            let (_, other) = run[0];
            table_of(other) == table_of(signal) && first <= end && last.max(end) - begin <= most
        });
        match run {
            Some(run) => {
                end = end.max(last);
                run.push((name, signal));
            }
            None => {
                (begin, end) = (first, last);
                runs.push(vec![(name, signal)]);
            }
        }
    }
    runs
}

/// First address, and the one after the last.
fn range(signal: &Signal) -> (u32, u32) {
    let first = u32::from(signal.spec.address);
    (first, first + u32::from(signal.spec.count))
}

/// The read of a run, which is sorted by address and not empty.
fn read(run: &[(&String, &Signal)]) -> PollGroup {
    let (_, first) = run[0];
    let begin = first.spec.address;
    let end = run.iter().map(|(_, signal)| range(signal).1).max();
    PollGroup {
        slave: first.spec.slave,
        read: Some(Request::Read {
            table: first.spec.table(),
            address: begin,
            // At most what one request reads.
            count: (end.unwrap_or(0) - u32::from(begin)) as u16,
        }),
        members: run
            .iter()
            .map(|(name, signal)| {
                SignalRef::new(name, signal, usize::from(signal.spec.address - begin))
            })
            .collect(),
    }
}

/// Puts an answer into the signals it is for.
pub(super) fn note_reply(
    state: &mut ModbusState,
    address: &DeviceAddress,
    asked: &ScheduledRequest,
    reply: &Result<Reply, PduError>,
) {
    let now = state.now_of(address);
    let is_shared = asked.members.len() > 1;
    let mut has_news = false;
    for member in &asked.members {
        let Some(signal) = member.resolve(state) else {
            continue;
        };
        match reply {
            Ok(reply) => {
                if let Reply::Values(values) = reply
                    && (signal.output.is_empty()
                        || matches!(signal.spec.kind, SignalKind::ReadWrite { .. }))
                {
                    let count = usize::from(signal.spec.count);
                    let values = values.iter().skip(member.offset).take(count);
                    signal.values = values.copied().collect();
                }
                signal.last_reply_at = Some(now);
                signal.device_error = 0;
                signal.is_unheard = false;
            }
            Err(PduError::Exception(_)) if is_shared => {
                // Perhaps the device does not give both at once: each is asked for alone from now on.
                signal.is_polled_alone = true;
                signal.due_at = now;
                has_news = true;
            }
            Err(PduError::Exception(code)) => signal.device_error = i32::from(*code),
            // Not defined (table 6-2).
            Err(PduError::Malformed) => signal.device_error = 9,
        }
    }
    if has_news {
        state.wake(address);
    }
}

#[cfg(test)]
mod tests {
    use super::super::pdu::Table;
    use super::super::signal::SignalSpec;
    use super::*;

    fn address() -> DeviceAddress {
        DeviceAddress {
            host: "device".to_owned(),
            port: 502,
        }
    }

    fn spec(kind: SignalKind, address_on_device: u16, count: u16) -> SignalSpec {
        SignalSpec {
            device: address(),
            slave: 255,
            address: address_on_device,
            count,
            kind,
            is_sequential: false,
        }
    }

    fn state(specs: Vec<SignalSpec>) -> ModbusState {
        let mut state = ModbusState::default();
        state.device(&address());
        for (order, spec) in (1..).zip(specs) {
            let signal = Signal::new(spec, order, Instant::now());
            state.signals.insert(format!("s{order}"), signal);
        }
        state
    }

    /// What is asked until nothing is due: slave, first address and count of each read, or the function written.
    fn round(schedule: &mut Schedule, state: &mut ModbusState) -> Vec<(u8, u16, u16)> {
        let mut asked = Vec::new();
        while let PollAction::Send(slave, ask) = schedule.next(state, &address()) {
            asked.push(match ask.request {
                Request::Read { address, count, .. } => (slave, address, count),
                other => (slave, u16::from(other.function()), 0),
            });
            assert!(asked.len() < 1000, "the round has no end");
        }
        asked
    }

    #[tokio::test(start_paused = true)]
    async fn neighbours_share_a_request_as_far_as_one_reaches() {
        use SignalKind::{DigitalInput, RegisterInput, RegisterOutput};
        let mut state = state(vec![
            spec(RegisterInput, 10, 2),
            spec(RegisterInput, 12, 1),
            spec(RegisterInput, 14, 1),
            spec(RegisterOutput, 13, 1),
            spec(DigitalInput, 13, 5),
            spec(RegisterInput, 100, 123),
            spec(RegisterInput, 223, 3),
        ]);
        let mut schedule = Schedule::default();
        let asked = round(&mut schedule, &mut state);
        let wanted = [(10, 3), (14, 1), (13, 1), (13, 5), (100, 123), (223, 3)];
        assert_eq!(asked, wanted.map(|(address, count)| (255, address, count)));
    }

    #[tokio::test(start_paused = true)]
    async fn signals_keep_their_rate_on_average_and_late_ones_are_counted() {
        let mut state = state(vec![spec(SignalKind::RegisterInput, 0, 1)]);
        let period = Duration::from_millis(20);
        let mut schedule = Schedule::default();
        if let Some(signal) = state.signals.get_mut("s1") {
            signal.period = Some(period);
            signal.last_reply_at = Some(Instant::now());
        }
        let begin = Instant::now();
        let mut times = Vec::new();
        for wait in [0, 25, 15, 20, 55, 20, 20] {
            tokio::time::advance(Duration::from_millis(wait)).await;
            if !round(&mut schedule, &mut state).is_empty() {
                times.push((Instant::now() - begin).as_millis());
            }
        }
        // At 25 ms it is 5 ms late and due again at 40; at 115 ms it is 35 ms late, which is lost.
        assert_eq!(times, [0, 25, 40, 60, 115, 135, 155]);
        assert_eq!(state.signals["s1"].missed, 1);
    }

    #[tokio::test(start_paused = true)]
    async fn commands_of_scripts_come_first_and_a_value_set_now_is_written_now() {
        let specs = (0..5).map(|n| spec(SignalKind::RegisterOutput, 10 * n, 1));
        let mut state = state(specs.collect());
        let mut schedule = Schedule::default();
        let first = schedule.next(&mut state, &address());
        assert!(matches!(first, PollAction::Send(255, _)), "{first:?}");
        // In the middle of the round.
        if let Some(signal) = state.signals.get_mut("s5") {
            signal.set(&[7], Instant::now());
        }
        state.device(&address()).custom.push(CustomRequest {
            slave: 3,
            request: Request::Custom(0x41, vec![1]),
            repeats: false,
            due: Instant::now(),
        });
        state.wake(&address());
        let asked = round(&mut schedule, &mut state);
        assert_eq!(asked[0], (3, 0x41, 0));
        assert!(asked.contains(&(255, 6, 0)), "{asked:?}");
        assert_eq!(asked.len(), 5, "the first is not asked twice");
    }

    #[tokio::test(start_paused = true)]
    async fn what_a_device_refuses_together_is_asked_for_alone() {
        let both = |n| spec(SignalKind::RegisterInput, n, 1);
        let mut state = state(vec![both(0), both(1)]);
        let mut schedule = Schedule::default();
        let PollAction::Send(_, asked) = schedule.next(&mut state, &address()) else {
            panic!("nothing is due");
        };
        note_reply(&mut state, &address(), &asked, &Err(PduError::Exception(2)));
        let asked = round(&mut schedule, &mut state);
        assert_eq!(asked, [(255, 0, 1), (255, 1, 1)]);
    }

    #[tokio::test(start_paused = true)]
    async fn a_deleted_signal_is_not_asked_for_and_an_unused_device_is_left() {
        let mut state = state(vec![spec(SignalKind::RegisterInput, 0, 1)]);
        let mut schedule = Schedule::default();
        let table = Table::InputRegisters;
        let PollAction::Send(_, asked) = schedule.next(&mut state, &address()) else {
            panic!("nothing is due");
        };
        let (first, count) = (0, 1);
        let wanted = Request::Read {
            table,
            address: first,
            count,
        };
        assert_eq!(asked.request, wanted);
        state.signals.clear();
        state.wake(&address());
        note_reply(&mut state, &address(), &asked, &Ok(Reply::Values(vec![1])));
        assert!(matches!(
            schedule.next(&mut state, &address()),
            PollAction::WaitUntil(_)
        ));
        tokio::time::advance(IDLE_TIME).await;
        assert!(matches!(
            schedule.next(&mut state, &address()),
            PollAction::Close
        ));
        assert!(state.devices.is_empty());
    }
}
