//! One Modbus signal: what it is, what it holds, and when it is due.

use std::time::Duration;

use motion_api::RunStateChoice;
use tokio::time::Instant;

use super::pdu::{Request, Table};

/// Rate of a signal without one of its own (as on other makers' arms; the manual is silent), Hz.
const DEFAULT_RATE: u32 = 10;
/// Time without a good answer before reading a signal raises (manual 6.1.10).
const DEFAULT_WATCHDOG: Duration = Duration::from_secs(5);

/// A device: host and TCP port.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DeviceAddress {
    /// Address or name.
    pub host: String,
    /// TCP port.
    pub port: u16,
}

/// What a signal is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalKind {
    /// Type 0: read with function 2.
    DigitalInput,
    /// Type 1: read with 1 until it is set, then written with 5 or 15.
    DigitalOutput,
    /// Type 2: read with 4.
    RegisterInput,
    /// Type 3: read with 3 until it is set, then written with 6 or 16.
    RegisterOutput,
    /// Read with 3 until it is set, then with 23, which writes from `write_address` first (manual 6.1.3).
    ReadWrite {
        /// First register to write.
        write_address: u16,
        /// Number of registers that may be written.
        write_count: u16,
    },
}

/// A signal to add.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignalSpec {
    /// Device that has the signal.
    pub device: DeviceAddress,
    /// Number of the unit behind the device's address.
    pub slave: u8,
    /// Address of the first coil or register.
    pub address: u16,
    /// Number of coils or registers in a row.
    pub count: u16,
    /// Kind of the signal.
    pub kind: SignalKind,
    /// The signal is updated in the order in which signals were added.
    pub is_sequential: bool,
}

impl SignalSpec {
    /// The table the signal is read from.
    pub(super) const fn table(&self) -> Table {
        match self.kind {
            SignalKind::DigitalInput => Table::DiscreteInputs,
            SignalKind::DigitalOutput => Table::Coils,
            SignalKind::RegisterInput => Table::InputRegisters,
            SignalKind::RegisterOutput | SignalKind::ReadWrite { .. } => Table::HoldingRegisters,
        }
    }
}

/// One signal.
pub(super) struct Signal {
    pub(super) spec: SignalSpec,
    /// Values read last, or set; bits are 0 and 1. Empty before the first answer.
    pub(super) values: Vec<u16>,
    /// What is written from now on; empty until it is set for the first time.
    pub(super) output: Vec<u16>,
    pub(super) period: Option<Duration>,
    pub(super) watchdog: Duration,
    pub(super) run_state: RunStateChoice,
    pub(super) added_at: Instant,
    pub(super) last_reply_at: Option<Instant>,
    pub(super) device_error: i32,
    /// The connection was lost, or nothing came: until the next good answer.
    pub(super) is_unheard: bool,
    pub(super) due_at: Instant,
    /// In the order in which signals were added; new for a signal that replaces another.
    pub(super) order: u64,
    /// The device refused it together with its neighbours.
    pub(super) is_polled_alone: bool,
    pub(super) missed: u64,
}

impl Signal {
    /// A signal that is due at once; times of a signal are those of its device.
    pub(super) fn new(spec: SignalSpec, order: u64, now: Instant) -> Self {
        Self {
            values: Vec::new(),
            output: Vec::new(),
            period: Some(Duration::from_secs(1) / DEFAULT_RATE),
            watchdog: DEFAULT_WATCHDOG,
            run_state: RunStateChoice::Keep,
            added_at: now,
            last_reply_at: None,
            device_error: 0,
            is_unheard: false,
            due_at: now,
            order,
            is_polled_alone: false,
            missed: 0,
            spec,
        }
    }

    /// Takes what a script or the run state sets.
    pub(super) fn set(&mut self, values: &[u16], now: Instant) {
        if self.output.len() < values.len() {
            // What lies between was never set, so it is not written.
            self.output.resize(values.len(), 0);
        }
        self.output[..values.len()].copy_from_slice(values);
        if !matches!(self.spec.kind, SignalKind::ReadWrite { .. }) {
            self.values.resize(usize::from(self.spec.count), 0);
            self.values[..values.len()].copy_from_slice(values);
        }
        self.due_at = now;
    }

    /// True when the output is forced.
    pub(super) fn force_run_state(&mut self, running: bool, now: Instant) -> bool {
        let Some(level) = self.run_state.level(running) else {
            return false;
        };
        let levels = vec![u16::from(level); usize::from(self.spec.count)];
        self.set(&levels, now);
        true
    }

    /// How late it is: zero for a signal that has never been heard of.
    pub(super) fn lateness(&self, now: Instant) -> Duration {
        match self.last_reply_at {
            Some(_) => now.saturating_duration_since(self.due_at),
            None => Duration::ZERO,
        }
    }

    /// Sets the time of the next request while this one is due at `now`. The rate is kept on average; a request that is
    /// a whole period late is counted and not made up for.
    pub(super) fn schedule_next(&mut self, now: Instant) {
        let Some(period) = self.period else { return };
        if self.lateness(now) > period {
            self.missed += 1;
        }
        let is_lost = now.saturating_duration_since(self.due_at) > period;
        self.due_at = if is_lost { now } else { self.due_at } + period;
    }

    /// The request that sets it; `None` for a signal that is only read.
    pub(super) fn write_request(&self) -> Option<Request> {
        let (address, output) = (self.spec.address, &self.output);
        let levels = || output.iter().map(|value| *value != 0).collect();
        Some(match (self.spec.kind, output.as_slice()) {
            (_, []) => return None,
            (SignalKind::DigitalOutput, [value]) => Request::WriteCoil(address, *value != 0),
            (SignalKind::DigitalOutput, _) => Request::WriteCoils(address, levels()),
            (SignalKind::RegisterOutput, [value]) => Request::WriteRegister(address, *value),
            (SignalKind::RegisterOutput, _) => Request::WriteRegisters(address, output.clone()),
            (SignalKind::ReadWrite { write_address, .. }, _) => Request::ReadWrite {
                read: address,
                count: self.spec.count,
                write: write_address,
                values: output.clone(),
            },
            (SignalKind::DigitalInput | SignalKind::RegisterInput, _) => return None,
        })
    }
}
