//! Modbus signals of the controller (manual 6.1): what scripts add, set and read by name.
//!
//! Owns the table of signals and devices. Each device has one connection, shared by its signals and driven by a task of
//! `device` on a thread of its own; nothing here waits but the functions that say so. Signals outlive programs.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use motion_api::RunStateChoice;
use thiserror::Error;
use tokio::runtime::Handle;
use tokio::sync::{Notify, watch};
use tokio::time::{Instant, timeout_at};

use super::device;
use super::pdu::{Request, Table};

/// Most signals of one controller (manual 6.1.1).
pub const SIGNALS_MAX: usize = 200;
/// Custom commands of one device that wait to be sent.
const CUSTOM_WAITING_MAX: usize = 64;
/// Rate of a signal without one of its own (as on other makers' arms; the manual is silent), Hz.
const DEFAULT_RATE: u32 = 10;
/// Time without a good answer before reading a signal raises (manual 6.1.10).
const DEFAULT_WATCHDOG: Duration = Duration::from_secs(5);
/// How long a blocking reset waits for the connection.
const RESET_TIME: Duration = Duration::from_secs(3);

/// Device codes of table 6-2 that no device sends.
const NOT_CONNECTED: i32 = -2;
const CONNECTING: i32 = -1;

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
        /// How many may be written.
        write_count: u16,
    },
}

/// A signal to add.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignalSpec {
    /// Where.
    pub device: DeviceAddress,
    /// Unit.
    pub slave: u8,
    /// First coil or register.
    pub address: u16,
    /// How many in a row.
    pub count: u16,
    /// What.
    pub kind: SignalKind,
    /// Updated in the order in which signals were added.
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

/// Why something cannot be done with a signal.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModbusError {
    /// Nobody added it.
    #[error("there is no signal {0:?}; add it with modbus_add_signal()")]
    UnknownSignal(String),
    /// No signal uses that device.
    #[error("no signal uses a device at {host}:{port}")]
    UnknownDevice {
        /// Address.
        host: String,
        /// TCP port.
        port: u16,
    },
    /// There are enough.
    #[error("{SIGNALS_MAX} signals exist already, more are not allowed")]
    TooManySignals,
    /// Broadcasts have no answer (MODBUS over TCP, unit 0).
    #[error("slave 0 is a broadcast, which nobody answers: an input cannot be read from it")]
    BroadcastRead,
    /// A signal of another kind is needed.
    #[error("signal {name:?} is not {needed}")]
    WrongKind {
        /// Which.
        name: String,
        /// What is needed.
        needed: &'static str,
    },
    /// A list of the wrong length.
    #[error("signal {name:?} takes 1 to {most} values, got {given}")]
    Length {
        /// Which.
        name: String,
        /// As given.
        given: usize,
        /// Allowed.
        most: u16,
    },
    /// No good answer for longer than the watchdog.
    #[error(
        "signal {name:?} has had no good answer for {invalid:.1} s, its watchdog allows {watchdog:.1} s (device error {device}, connection error {connection})"
    )]
    Invalid {
        /// Which.
        name: String,
        /// s.
        invalid: f64,
        /// s.
        watchdog: f64,
        /// Table 6-2.
        device: i32,
        /// errno.
        connection: i32,
    },
    /// Too many custom commands wait.
    #[error("{CUSTOM_WAITING_MAX} commands wait for {host}:{port} already")]
    DeviceBusy {
        /// Address.
        host: String,
        /// TCP port.
        port: u16,
    },
    /// The operating system gave no thread.
    #[error("cannot start the Modbus client: {0}")]
    NoThread(String),
}

/// The Modbus client of one controller. Starts a thread when the first signal is added.
#[derive(Default)]
pub struct ModbusClient {
    shared: Arc<Shared>,
    runtime: OnceLock<Runtime>,
}

struct Runtime {
    handle: Handle,
    ending: Arc<Notify>,
}

impl Drop for Runtime {
    fn drop(&mut self) {
        self.ending.notify_one();
    }
}

/// What the tasks of devices and the functions for scripts share.
#[derive(Default)]
pub(super) struct Shared {
    state: Mutex<State>,
    /// Counts updates, so that somebody can wait for the next.
    pub(super) updates: watch::Sender<u64>,
}

#[derive(Default)]
pub(super) struct State {
    pub(super) signals: BTreeMap<String, Signal>,
    pub(super) devices: BTreeMap<DeviceAddress, Device>,
    last_order: u64,
    program_running: bool,
}

/// One signal.
pub(super) struct Signal {
    pub(super) spec: SignalSpec,
    /// As read last, or as set; bits as 0 and 1. Empty before the first answer.
    pub(super) values: Vec<u16>,
    /// What is written from now on; empty until it is set for the first time.
    pub(super) output: Vec<u16>,
    pub(super) period: Option<Duration>,
    watchdog: Duration,
    run_state: RunStateChoice,
    added: Instant,
    pub(super) last_good: Option<Instant>,
    pub(super) device_error: i32,
    pub(super) due: Instant,
    /// In the order in which signals were added; new for a signal that replaces another.
    pub(super) order: u64,
    /// The device refused it together with its neighbours.
    pub(super) alone: bool,
    pub(super) missed: u64,
}

/// One connection.
pub(super) struct Device {
    pub(super) wake: Arc<Notify>,
    pub(super) custom: Vec<Custom>,
    pub(super) has_task: bool,
    pub(super) is_connected: bool,
    pub(super) is_connecting: bool,
    pub(super) errno: i32,
    pub(super) wants_reset: bool,
    pub(super) connections: u64,
}

pub(super) struct Custom {
    pub(super) slave: u8,
    pub(super) request: Request,
    /// Sent again and again, at the default rate, until the connection is reset.
    pub(super) repeats: bool,
    pub(super) due: Instant,
}

impl Shared {
    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        // Every change under the lock is complete before anything that could panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn signal(&mut self, name: &str) -> Result<&mut Signal, ModbusError> {
        self.signals
            .get_mut(name)
            .ok_or_else(|| ModbusError::UnknownSignal(name.to_owned()))
    }

    fn wake(&self, address: &DeviceAddress) {
        if let Some(device) = self.devices.get(address) {
            device.wake.notify_one();
        }
    }

    /// `[device, connection]` error codes of a signal (manual 6.1.15).
    fn errors(&self, signal: &Signal) -> [i32; 2] {
        match self.devices.get(&signal.spec.device) {
            Some(device) if device.is_connected => [signal.device_error, 0],
            Some(device) if device.is_connecting => [CONNECTING, device.errno],
            Some(device) => [NOT_CONNECTED, device.errno],
            None => [NOT_CONNECTED, 0],
        }
    }

    /// Time without a good answer; zero for a valid signal.
    fn invalid_for(&self, signal: &Signal) -> Duration {
        match (self.errors(signal), signal.last_good) {
            ([0, _], Some(_)) => Duration::ZERO,
            (_, since) => since.unwrap_or(signal.added).elapsed(),
        }
    }

    fn check_valid(&self, name: &str, signal: &Signal) -> Result<(), ModbusError> {
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
}

impl ModbusClient {
    /// Adds a signal, or replaces the one of that name.
    ///
    /// # Errors
    /// [`ModbusError::TooManySignals`], [`ModbusError::BroadcastRead`], [`ModbusError::NoThread`].
    pub fn add(&self, name: &str, spec: SignalSpec) -> Result<(), ModbusError> {
        use SignalKind::{DigitalInput, ReadWrite, RegisterInput};
        if spec.slave == 0 && matches!(spec.kind, DigitalInput | RegisterInput | ReadWrite { .. }) {
            return Err(ModbusError::BroadcastRead);
        }
        let mut state = self.shared.state();
        if state.signals.len() >= SIGNALS_MAX && !state.signals.contains_key(name) {
            return Err(ModbusError::TooManySignals);
        }
        state.last_order += 1;
        let signal = Signal {
            values: Vec::new(),
            output: Vec::new(),
            period: Some(Duration::from_secs(1) / DEFAULT_RATE),
            watchdog: DEFAULT_WATCHDOG,
            run_state: RunStateChoice::Keep,
            added: Instant::now(),
            last_good: None,
            device_error: 0,
            due: Instant::now(),
            order: state.last_order,
            alone: false,
            missed: 0,
            spec,
        };
        let address = signal.spec.device.clone();
        state.signals.insert(name.to_owned(), signal);
        self.open(state, address)
    }

    /// True while there are signals, so that time in the outside world matters.
    pub fn has_signals(&self) -> bool {
        !self.shared.state().signals.is_empty()
    }

    /// Removes a signal.
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`]
    pub fn delete(&self, name: &str) -> Result<(), ModbusError> {
        let mut state = self.shared.state();
        let Some(signal) = state.signals.remove(name) else {
            return Err(ModbusError::UnknownSignal(name.to_owned()));
        };
        state.wake(&signal.spec.device);
        Ok(())
    }

    /// The values of a signal, bits as 0 and 1, and whether they are bits. Before the first answer waits for it, at most
    /// as long as the watchdog.
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`]; [`ModbusError::Invalid`] after the watchdog's time without a good answer.
    pub async fn status(&self, name: &str) -> Result<(Vec<u16>, bool), ModbusError> {
        let mut updates = self.shared.updates.subscribe();
        loop {
            updates.mark_unchanged();
            let give_up = {
                let mut state = self.shared.state();
                state.signal(name)?;
                let signal = &state.signals[name];
                state.check_valid(name, signal)?;
                if !signal.values.is_empty() {
                    return Ok((signal.values.clone(), signal.spec.table().is_bits()));
                }
                signal.added + signal.watchdog + Duration::from_millis(1)
            };
            // The sender lives as long as this client; whether time is over is decided above.
            let _ = timeout_at(give_up, updates.changed()).await;
        }
    }

    /// Sets a digital output; a shorter list leaves the higher coils as they are.
    ///
    /// # Errors
    /// [`ModbusError`] names the signal and what does not fit.
    pub fn set_coils(&self, name: &str, levels: &[bool]) -> Result<(), ModbusError> {
        let values: Vec<u16> = levels.iter().map(|level| u16::from(*level)).collect();
        self.set(name, &values, "a digital output", |kind| {
            matches!(kind, SignalKind::DigitalOutput)
        })
    }

    /// Sets a register output or the written part of a read-write signal.
    ///
    /// # Errors
    /// [`ModbusError`] names the signal and what does not fit.
    pub fn set_registers(&self, name: &str, values: &[u16]) -> Result<(), ModbusError> {
        self.set(name, values, "a register output", |kind| {
            matches!(
                kind,
                SignalKind::RegisterOutput | SignalKind::ReadWrite { .. }
            )
        })
    }

    fn set(
        &self,
        name: &str,
        values: &[u16],
        needed: &'static str,
        fits: impl Fn(SignalKind) -> bool,
    ) -> Result<(), ModbusError> {
        let mut state = self.shared.state();
        let signal = state.signal(name)?;
        let most = match signal.spec.kind {
            SignalKind::ReadWrite { write_count, .. } => write_count,
            _ => signal.spec.count,
        };
        let name = name.to_owned();
        if !fits(signal.spec.kind) {
            return Err(ModbusError::WrongKind { name, needed });
        }
        if values.is_empty() || values.len() > usize::from(most) {
            let given = values.len();
            return Err(ModbusError::Length { name, given, most });
        }
        signal.set(values);
        let signal = &state.signals[&name];
        state.check_valid(&name, signal)?;
        state.wake(&signal.spec.device);
        Ok(())
    }

    /// What a digital output does when no program runs (manual 6.1.8).
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`], [`ModbusError::WrongKind`]
    pub fn set_run_state(&self, name: &str, choice: RunStateChoice) -> Result<(), ModbusError> {
        let mut state = self.shared.state();
        let running = state.program_running;
        let signal = state.signal(name)?;
        if signal.spec.kind != SignalKind::DigitalOutput {
            let (name, needed) = (name.to_owned(), "a digital output");
            return Err(ModbusError::WrongKind { name, needed });
        }
        signal.run_state = choice;
        signal.force_run_state(running);
        let device = signal.spec.device.clone();
        state.wake(&device);
        Ok(())
    }

    /// A program runs, or none does.
    pub fn program_running(&self, running: bool) {
        let mut state = self.shared.state();
        state.program_running = running;
        let mut changed = Vec::new();
        for signal in state.signals.values_mut() {
            if signal.force_run_state(running) {
                changed.push(signal.spec.device.clone());
            }
        }
        changed.iter().for_each(|device| state.wake(device));
    }

    /// How often a signal is updated, Hz; 0 stops.
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`]
    pub fn set_frequency(&self, name: &str, hertz: u32) -> Result<(), ModbusError> {
        let mut state = self.shared.state();
        let signal = state.signal(name)?;
        signal.period = (hertz > 0).then(|| Duration::from_secs(1) / hertz.max(1));
        signal.due = Instant::now();
        let device = signal.spec.device.clone();
        state.wake(&device);
        Ok(())
    }

    /// How long a signal may be without a good answer before reading or setting it raises.
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`]
    pub fn set_watchdog(&self, name: &str, time: Duration) -> Result<(), ModbusError> {
        self.shared.state().signal(name)?.watchdog = time;
        Ok(())
    }

    /// `[device, connection]` error codes (manual 6.1.15).
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`]
    pub fn error_codes(&self, name: &str) -> Result<[i32; 2], ModbusError> {
        let mut state = self.shared.state();
        state.signal(name)?;
        Ok(state.errors(&state.signals[name]))
    }

    /// Time since the last good answer; zero for a valid signal.
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`]
    pub fn time_since_invalid(&self, name: &str) -> Result<Duration, ModbusError> {
        let mut state = self.shared.state();
        state.signal(name)?;
        Ok(state.invalid_for(&state.signals[name]))
    }

    /// Updates that came more than a period late since the signal was added; for tests and measurements.
    ///
    /// # Errors
    /// [`ModbusError::UnknownSignal`]
    pub fn missed_updates(&self, name: &str) -> Result<u64, ModbusError> {
        Ok(self.shared.state().signal(name)?.missed)
    }

    /// Sends a function with its bytes; the answer is not looked at.
    ///
    /// # Errors
    /// [`ModbusError::DeviceBusy`], [`ModbusError::NoThread`]
    pub fn send_custom(
        &self,
        device: DeviceAddress,
        slave: u8,
        request: Request,
        repeats: bool,
    ) -> Result<(), ModbusError> {
        let mut state = self.shared.state();
        let waiting = &mut state.device(&device).custom;
        if waiting.len() >= CUSTOM_WAITING_MAX {
            let DeviceAddress { host, port } = device;
            return Err(ModbusError::DeviceBusy { host, port });
        }
        waiting.push(Custom {
            slave,
            request,
            repeats,
            due: Instant::now(),
        });
        self.open(state, device)
    }

    /// Closes the connection to a device and opens it again; with `wait` until it stands, at most 3 s.
    ///
    /// # Errors
    /// [`ModbusError::UnknownDevice`]
    pub async fn reset(&self, address: &DeviceAddress, wait: bool) -> Result<(), ModbusError> {
        let mut updates = self.shared.updates.subscribe();
        let before = {
            let mut state = self.shared.state();
            let Some(device) = state.devices.get_mut(address) else {
                let DeviceAddress { host, port } = address.clone();
                return Err(ModbusError::UnknownDevice { host, port });
            };
            device.wants_reset = true;
            device.custom.clear();
            device.wake.notify_one();
            device.connections
        };
        let deadline = Instant::now() + RESET_TIME;
        while wait && Instant::now() < deadline {
            updates.mark_unchanged();
            let connections = {
                let state = self.shared.state();
                state.devices.get(address).map(|device| device.connections)
            };
            if connections.is_none_or(|count| count > before) {
                break;
            }
            let _ = timeout_at(deadline, updates.changed()).await;
        }
        Ok(())
    }

    /// Makes sure that the device has a task, and wakes it.
    fn open(
        &self,
        mut state: MutexGuard<'_, State>,
        address: DeviceAddress,
    ) -> Result<(), ModbusError> {
        let runtime = match self.runtime.get() {
            Some(runtime) => runtime,
            None => {
                let started = start_runtime().map_err(|e| ModbusError::NoThread(e.to_string()))?;
                // Under the lock of the state, so nobody else can have set it.
                self.runtime.get_or_init(|| started)
            }
        };
        let device = state.device(&address);
        device.wake.notify_one();
        if !device.has_task {
            device.has_task = true;
            device.is_connecting = true;
            runtime
                .handle
                .spawn(device::run(self.shared.clone(), address));
        }
        Ok(())
    }
}

impl State {
    fn device(&mut self, address: &DeviceAddress) -> &mut Device {
        self.devices
            .entry(address.clone())
            .or_insert_with(|| Device {
                wake: Arc::default(),
                custom: Vec::new(),
                has_task: false,
                is_connected: false,
                is_connecting: false,
                errno: 0,
                wants_reset: false,
                connections: 0,
            })
    }
}

impl Signal {
    fn set(&mut self, values: &[u16]) {
        if self.output.len() < values.len() {
            // What lies between was never set, so it is not written.
            self.output.resize(values.len(), 0);
        }
        self.output[..values.len()].copy_from_slice(values);
        if !matches!(self.spec.kind, SignalKind::ReadWrite { .. }) {
            self.values.resize(usize::from(self.spec.count), 0);
            self.values[..values.len()].copy_from_slice(values);
        }
        self.due = Instant::now();
    }

    /// True when the output is forced.
    fn force_run_state(&mut self, running: bool) -> bool {
        let Some(level) = self.run_state.level(running) else {
            return false;
        };
        self.set(&vec![u16::from(level); usize::from(self.spec.count)]);
        true
    }
}

fn start_runtime() -> io::Result<Runtime> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let handle = runtime.handle().clone();
    let ending = Arc::new(Notify::new());
    let told = ending.clone();
    std::thread::Builder::new()
        .name("modbus".to_owned())
        .spawn(move || runtime.block_on(told.notified()))?;
    Ok(Runtime { handle, ending })
}
