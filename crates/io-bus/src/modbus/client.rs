//! Modbus signals of the controller (manual 6.1): what scripts add, set and read by name.
//!
//! Owns the table of signals and devices. Each device has one connection, shared by its signals and driven by a task of
//! `device` on a thread of its own; nothing here waits but the functions that say so. Signals outlive programs.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use messages::{Localized, Text, text};
use motion_api::RunStateChoice;
use parking_lot::MutexGuard;
use supervision::ThreadSupervisor;
use thiserror::Error;
use tokio::time::{Instant, timeout_at};

use super::device;
use super::pdu::Request;
use super::played::SimulatedDevices;
use super::signal::{DeviceAddress, Signal, SignalKind, SignalSpec};
use super::state::{CustomRequest, ModbusState, SharedModbusState};
use crate::driver::RuntimeThread;
use crate::link::SimulatedPeers;

/// Most signals of one controller (manual 6.1.1).
pub const SIGNALS_MAX: usize = 200;
/// Custom commands of one device that wait to be sent.
const CUSTOM_WAITING_MAX: usize = 64;
/// How long a blocking reset waits for the connection.
const RESET_TIME: Duration = Duration::from_secs(3);

/// A reason why something cannot be done with a signal.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum ModbusError {
    /// Nobody added it.
    #[error("there is no signal {0:?}; add it with modbus_add_signal()")]
    #[zh("没有信号 {0:?}；请用 modbus_add_signal() 添加")]
    UnknownSignal(String),
    /// No signal uses that device.
    #[error("no signal uses a device at {host}:{port}")]
    #[zh("没有信号使用 {host}:{port} 处的设备")]
    UnknownDevice {
        /// Address.
        host: String,
        /// TCP port.
        port: u16,
    },
    /// There are enough.
    #[error("{SIGNALS_MAX} signals exist already, more are not allowed")]
    #[zh("已有 {SIGNALS_MAX} 个信号，不允许更多")]
    TooManySignals,
    /// Broadcasts have no answer (MODBUS over TCP, unit 0).
    #[error("slave 0 is a broadcast, which nobody answers: an input cannot be read from it")]
    #[zh("从站 0 是广播，无人应答：不能从它读取输入")]
    BroadcastRead,
    /// A signal of another kind is needed.
    #[error("signal {name:?} is not {needed}")]
    #[zh("信号 {name:?} 不是{needed}")]
    WrongKind {
        /// Name of the signal.
        name: String,
        /// What is needed.
        needed: Text,
    },
    /// A list of the wrong length.
    #[error("signal {name:?} takes 1 to {most} values, got {given}")]
    #[zh("信号 {name:?} 接受 1 到 {most} 个值，给出的是 {given} 个")]
    Length {
        /// Name of the signal.
        name: String,
        /// Number of values that were given.
        given: usize,
        /// Most values that the signal takes.
        most: u16,
    },
    /// No good answer for longer than the watchdog.
    #[error(
        "signal {name:?} has had no good answer for {invalid:.1} s, its watchdog allows {watchdog:.1} s \
         (device error {device}, connection error {connection})"
    )]
    #[zh(
        "信号 {name:?} 已 {invalid:.1} s 没有正确应答，其看门狗允许 {watchdog:.1} s（设备错误 {device}，连接错误 {connection}）"
    )]
    Invalid {
        /// Name of the signal.
        name: String,
        /// Time since the last good answer, s.
        invalid: f64,
        /// Time that the watchdog allows, s.
        watchdog: f64,
        /// Error code of the device (manual, table 6-2).
        device: i32,
        /// Error number of the connection (errno).
        connection: i32,
    },
    /// Too many custom commands wait.
    #[error("{CUSTOM_WAITING_MAX} commands wait for {host}:{port} already")]
    #[zh("已有 {CUSTOM_WAITING_MAX} 条命令等待 {host}:{port}")]
    DeviceBusy {
        /// Address.
        host: String,
        /// TCP port.
        port: u16,
    },
    /// The operating system gave no thread.
    #[error("cannot start the Modbus client: {0}")]
    #[zh("无法启动 Modbus 客户端：{0}")]
    NoThread(Text),
}

/// The Modbus client of one controller. Starts a thread when the first signal is added.
#[derive(Default)]
pub struct ModbusClient {
    shared: Arc<SharedModbusState>,
    driver: OnceLock<RuntimeThread>,
    played: SimulatedDevices,
    faults: ThreadSupervisor,
}

impl ModbusClient {
    /// A client without signals; `faults` hears of those on its thread, who stands in for devices is asked before the
    /// network is.
    pub fn new(faults: ThreadSupervisor, stand_ins: Option<Arc<dyn SimulatedPeers>>) -> Self {
        let shared = SharedModbusState::with_simulated_peers(stand_ins);
        Self {
            shared: Arc::new(shared),
            faults,
            ..Self::default()
        }
    }

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
        let address = spec.device.clone();
        self.ensure_device(&mut state, &address);
        let signal = Signal::new(spec, state.last_order, state.now_of(&address));
        state.signals.insert(name.to_owned(), signal);
        self.ensure_device_task(state, address)
    }

    /// True while there are signals of devices that nobody plays, so that time in the outside world matters.
    pub fn has_real_devices(&self) -> bool {
        let state = self.shared.state();
        let mut devices = state.signals.values().map(|signal| &signal.spec.device);
        devices.any(|device| state.devices.get(device).is_none_or(|it| !it.is_simulated))
    }

    /// Before a cycle that begins at `time` of the simulated clock: devices that a test plays are asked what is due.
    pub fn poll_simulated_devices(&self, time: Duration) {
        self.played.poll_due(&self.shared, time);
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

    /// The values of a signal, bits as 0 and 1, and whether they are bits. Before the first answer waits for it, at
    /// most as long as the watchdog.
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
                let is_played = state
                    .devices
                    .get(&signal.spec.device)
                    .is_some_and(|device| device.is_simulated);
                // Of a device that is played every cycle brings news.
                (!is_played).then(|| signal.added_at + signal.watchdog + Duration::from_millis(1))
            };
            // The sender lives as long as this client; whether time is over is decided above.
            let _ = match give_up {
                Some(time) => timeout_at(time, updates.changed()).await.unwrap_or(Ok(())),
                None => updates.changed().await,
            };
        }
    }

    /// Sets a digital output; a shorter list leaves the higher coils as they are.
    ///
    /// # Errors
    /// [`ModbusError`] names the signal and what does not fit.
    pub fn set_coils(&self, name: &str, levels: &[bool]) -> Result<(), ModbusError> {
        let values: Vec<u16> = levels.iter().map(|level| u16::from(*level)).collect();
        self.set(
            name,
            &values,
            text!("a digital output", "数字输出"),
            |kind| matches!(kind, SignalKind::DigitalOutput),
        )
    }

    /// Sets a register output or the written part of a read-write signal.
    ///
    /// # Errors
    /// [`ModbusError`] names the signal and what does not fit.
    pub fn set_registers(&self, name: &str, values: &[u16]) -> Result<(), ModbusError> {
        self.set(
            name,
            values,
            text!("a register output", "寄存器输出"),
            |kind| {
                matches!(
                    kind,
                    SignalKind::RegisterOutput | SignalKind::ReadWrite { .. }
                )
            },
        )
    }

    fn set(
        &self,
        name: &str,
        values: &[u16],
        needed: Text,
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
        let device = signal.spec.device.clone();
        let now = state.now_of(&device);
        state.signal(&name)?.set(values, now);
        state.check_valid(&name, &state.signals[&name])?;
        state.wake(&device);
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
            let (name, needed) = (name.to_owned(), text!("a digital output", "数字输出"));
            return Err(ModbusError::WrongKind { name, needed });
        }
        signal.run_state = choice;
        let device = signal.spec.device.clone();
        let now = state.now_of(&device);
        state.signal(name)?.force_run_state(running, now);
        state.wake(&device);
        Ok(())
    }

    /// A program runs, or none does.
    pub fn program_running(&self, running: bool) {
        let mut state = self.shared.state();
        state.program_running = running;
        let devices: Vec<DeviceAddress> = state.devices.keys().cloned().collect();
        let mut changed = Vec::new();
        for device in devices {
            let now = state.now_of(&device);
            let signals = state.signals.values_mut();
            for signal in signals.filter(|signal| signal.spec.device == device) {
                if signal.force_run_state(running, now) {
                    changed.push(device.clone());
                }
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
        let device = signal.spec.device.clone();
        let now = state.now_of(&device);
        state.signal(name)?.due_at = now;
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
        self.ensure_device(&mut state, &device);
        let now = state.now_of(&device);
        let waiting = &mut state.device(&device).custom;
        if waiting.len() >= CUSTOM_WAITING_MAX {
            let DeviceAddress { host, port } = device;
            return Err(ModbusError::DeviceBusy { host, port });
        }
        waiting.push(CustomRequest {
            slave,
            request,
            repeats,
            due: now,
        });
        self.ensure_device_task(state, device)
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
            device.is_reset_requested = true;
            device.custom.clear();
            device.has_changes = true;
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

    /// Makes the device when it is new; a test plays it, or it is a real one.
    fn ensure_device(&self, state: &mut ModbusState, address: &DeviceAddress) {
        let is_new = !state.devices.contains_key(address);
        let device = state.device(address);
        if is_new && let Some(stand_ins) = &self.shared.stand_ins {
            device.is_simulated = stand_ins.simulates(&address.host, address.port);
            device.is_connecting = device.is_simulated;
        }
    }

    /// Makes sure that the device has a task, and wakes it. One that is played is asked when a cycle passes.
    fn ensure_device_task(
        &self,
        mut state: MutexGuard<'_, ModbusState>,
        address: DeviceAddress,
    ) -> Result<(), ModbusError> {
        let device = state.device(&address);
        if device.is_simulated {
            device.has_changes = true;
            return Ok(());
        }
        let driver = match self.driver.get() {
            Some(driver) => driver,
            None => {
                let started = RuntimeThread::start("modbus", self.faults.clone())
                    .map_err(|e| ModbusError::NoThread(Text::of(&e)))?;
                // Under the lock of the state, so nobody else can have set it.
                self.driver.get_or_init(|| started)
            }
        };
        let device = state.device(&address);
        device.has_changes = true;
        device.wake.notify_one();
        if !device.has_task {
            device.has_task = true;
            device.is_connecting = true;
            let shared = self.shared.clone();
            driver.spawn_restarting(move || device::serve_device(shared.clone(), address.clone()));
        }
        Ok(())
    }
}
