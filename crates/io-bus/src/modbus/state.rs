//! What scripts and the tasks of devices share: all signals, all devices, behind one lock that is never held while
//! waiting.

use crate::link::SimulatedPeers;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use parking_lot::{Mutex, MutexGuard};
use tokio::sync::{Notify, watch};
use tokio::time::Instant;

use super::client::ModbusError;
use super::pdu::Request;
use super::signal::{DeviceAddress, Signal};

/// Device codes of table 6-2 that no device sends.
const NOT_CONNECTED: i32 = -2;
const CONNECTING: i32 = -1;

/// What the tasks of devices and the functions for scripts share.
#[derive(Default)]
pub(super) struct SharedModbusState {
    state: Mutex<ModbusState>,
    /// Counts updates, so that somebody can wait for the next.
    pub(super) updates: watch::Sender<u64>,
    /// Consulted before the network is.
    pub(super) stand_ins: Option<Arc<dyn SimulatedPeers>>,
}

#[derive(Default)]
pub(super) struct ModbusState {
    pub(super) signals: BTreeMap<String, Signal>,
    pub(super) devices: BTreeMap<DeviceAddress, DeviceState>,
    pub(super) last_order: u64,
    pub(super) program_running: bool,
    /// The time of devices that a test plays: simulated.
    pub(super) simulated_now: Option<SimulatedInstant>,
}

/// Simulated time as an instant. It begins before any cycle has passed: until then, too, no signal may be due by the
/// clock of the machine, or of the runtime that somebody calls from.
#[derive(Clone, Copy)]
pub(super) struct SimulatedInstant {
    began: Instant,
    now: Instant,
}

impl SimulatedInstant {
    /// The instant at which simulated time begins.
    fn begin() -> Self {
        let began = Instant::now();
        SimulatedInstant { began, now: began }
    }

    /// Moves the instant to `time` after the beginning.
    pub(super) fn set(&mut self, time: Duration) -> Instant {
        self.now = self.began + time;
        self.now
    }
}

/// One connection.
pub(super) struct DeviceState {
    pub(super) wake: Arc<Notify>,
    /// Something has changed since the device's task last looked.
    pub(super) has_changes: bool,
    pub(super) custom: Vec<CustomRequest>,
    pub(super) has_task: bool,
    /// A test plays it: it has no task, and simulated time.
    pub(super) is_simulated: bool,
    pub(super) is_connected: bool,
    pub(super) is_connecting: bool,
    pub(super) errno: i32,
    pub(super) is_reset_requested: bool,
    pub(super) connections: u64,
}

pub(super) struct CustomRequest {
    pub(super) slave: u8,
    pub(super) request: Request,
    /// Sent again and again, at the default rate, until the connection is reset.
    pub(super) repeats: bool,
    pub(super) due: Instant,
}

impl SharedModbusState {
    /// Without signals; stand-ins are asked before the network is.
    pub(super) fn with_simulated_peers(stand_ins: Option<Arc<dyn SimulatedPeers>>) -> Self {
        let state = ModbusState {
            simulated_now: stand_ins.as_ref().map(|_| SimulatedInstant::begin()),
            ..ModbusState::default()
        };
        Self {
            state: Mutex::new(state),
            stand_ins,
            ..Self::default()
        }
    }

    pub(super) fn state(&self) -> MutexGuard<'_, ModbusState> {
        // Every change under the lock is complete before anything that could panic.
        self.state.lock()
    }
}

impl ModbusState {
    /// The signal of that name.
    pub(super) fn signal(&mut self, name: &str) -> Result<&mut Signal, ModbusError> {
        self.signals
            .get_mut(name)
            .ok_or_else(|| ModbusError::UnknownSignal(name.to_owned()))
    }

    /// What time it is for a device.
    pub(super) fn now_of(&self, address: &DeviceAddress) -> Instant {
        let is_played = self.devices.get(address).is_some_and(|it| it.is_simulated);
        match self.simulated_now.filter(|_| is_played) {
            Some(played) => played.now,
            None => Instant::now(),
        }
    }

    /// Tells the device's task that something has changed.
    pub(super) fn wake(&mut self, address: &DeviceAddress) {
        if let Some(device) = self.devices.get_mut(address) {
            device.has_changes = true;
            device.wake.notify_one();
        }
    }

    /// `[device, connection]` error codes of a signal (manual 6.1.15).
    pub(super) fn errors(&self, signal: &Signal) -> [i32; 2] {
        match self.devices.get(&signal.spec.device) {
            // A device that takes connections and answers nothing: what the last one ended with counts until it does.
            Some(device) if device.is_connected && signal.is_unheard => {
                [signal.device_error, device.errno]
            }
            Some(device) if device.is_connected => [signal.device_error, 0],
            Some(device) if device.is_connecting => [CONNECTING, device.errno],
            Some(device) => [NOT_CONNECTED, device.errno],
            None => [NOT_CONNECTED, 0],
        }
    }

    /// Time without a good answer; zero for a valid signal. Once invalid, a signal stays so until the next good answer,
    /// however often the device is connected again meanwhile.
    pub(super) fn invalid_for(&self, signal: &Signal) -> Duration {
        match (self.errors(signal), signal.last_reply_at) {
            ([0, _], Some(_)) if !signal.is_unheard => Duration::ZERO,
            (_, since) => {
                let now = self.now_of(&signal.spec.device);
                now.saturating_duration_since(since.unwrap_or(signal.added_at))
            }
        }
    }

    /// A connection has failed: nothing is heard of the signals of its device.
    pub(super) fn note_failure(&mut self, address: &DeviceAddress) {
        let signals = self.signals.values_mut();
        for signal in signals.filter(|signal| signal.spec.device == *address) {
            signal.is_unheard = true;
        }
    }

    /// Raises after the watchdog's time without a good answer.
    pub(super) fn check_valid(&self, name: &str, signal: &Signal) -> Result<(), ModbusError> {
        let invalid = self.invalid_for(signal);
        if invalid <= signal.watchdog {
            return Ok(());
        }
        let [device, connection] = self.errors(signal);
        Err(ModbusError::Invalid {
            name: name.to_owned(),
            invalid: invalid.as_secs_f64(),
            watchdog: signal.watchdog.as_secs_f64(),
            device,
            connection,
        })
    }

    /// The device at that address, made when it is new.
    pub(super) fn device(&mut self, address: &DeviceAddress) -> &mut DeviceState {
        self.devices
            .entry(address.clone())
            .or_insert_with(|| DeviceState {
                wake: Arc::default(),
                has_changes: false,
                custom: Vec::new(),
                has_task: false,
                is_simulated: false,
                is_connected: false,
                is_connecting: false,
                errno: 0,
                is_reset_requested: false,
                connections: 0,
            })
    }
}
