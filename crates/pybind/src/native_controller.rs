//! A controller in the process of Python, as far as it is native: texts and numbers in, texts and numbers out.
//!
//! Owns that calls exclude each other, that the interpreter lock is given up while time passes, that signals are heard
//! meanwhile, and what a forked child is told. The class that people use is `python/elitescript/_controller.py`.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use controller::CellWorld;
use controller::cell::point::IoPointName;
use controller::cell_world::WorldOrder;
use controller::condition::{Condition, ConditionError};
use controller::io_values::{PointChange, PointReading, PointValue};
use controller::{
    ControllerConfig, ProgramOutcome, ProgramResult, StartError, SteppedController, SteppedError,
    WallTimeout,
};
use elite_runtime::{Preset, ProgramText};
use motion_api::{CommandKind, MachineCommand, Origin, Seconds, SensingCommand, SettingCommand};
use numpy::PyArray1;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyRuntimeError, PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use recorder::CycleMessage;

use crate::ControllerClosed;
use crate::row::Row;
use crate::settings;
use crate::trace::CycleBuffer;

/// Outcome, error, line, time, prints, report.
type ResultParts = (
    &'static str,
    Option<String>,
    Option<u32>,
    f64,
    Vec<String>,
    Option<String>,
);

/// Speed and force of the TCP, moment about it, speeds and torques of the joints.
type PeakParts = (f64, f64, f64, [f64; 6], [f64; 6]);

fn parts(result: ProgramResult) -> ResultParts {
    let ProgramResult {
        outcome,
        error,
        line,
        time,
        prints,
        report,
    } = result;
    let [error, report] = [error, report].map(|text| text.map(|text| text.to_string()));
    (outcome.as_str(), error, line, time, prints, report)
}

/// A wrench that is set acts so long, s: until the next one.
const FOR_GOOD: f64 = 1e9;

/// An input or an output by its name.
fn point_named(name: &str) -> PyResult<IoPointName> {
    name.parse()
        .map_err(|text: messages::Text| PyValueError::new_err(text.to_string()))
}

/// A value from Python, numpy's included.
fn point_value(value: &Bound<'_, PyAny>) -> PointValue {
    if let Ok(level) = value.extract() {
        return PointValue::Level(level);
    }
    if let Ok(whole) = value.extract() {
        return PointValue::Whole(whole);
    }
    if let Ok(number) = value.extract() {
        return PointValue::Number(number);
    }
    let shown = value.repr().map(|text| text.to_string());
    PointValue::Other(shown.unwrap_or_else(|_| "something else".to_owned()))
}

/// What a settings error is in Python: of the arguments, but for what the machine refuses.
pub(crate) fn start_error(error: &StartError) -> PyErr {
    match error {
        StartError::Thread(_) | StartError::Recording(_) => {
            pyo3::exceptions::PyOSError::new_err(error.to_string())
        }
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// A reason why a condition was not answered.
enum RunUntilError {
    Stepped(SteppedError),
    Condition(ConditionError),
}

impl From<SteppedError> for RunUntilError {
    fn from(error: SteppedError) -> Self {
        Self::Stepped(error)
    }
}

fn stepped_error(error: &SteppedError) -> PyErr {
    match error {
        SteppedError::Stuck { .. } => PyTimeoutError::new_err(error.to_string()),
        _ => PyRuntimeError::new_err(error.to_string()),
    }
}

/// Seconds of an argument.
pub(crate) fn seconds(name: &str, given: f64) -> PyResult<Seconds> {
    Seconds::new(given).ok_or_else(|| {
        PyValueError::new_err(format!("{name} must be seconds from 0 on, got {given}"))
    })
}

fn wall(given: f64) -> PyResult<Duration> {
    match Duration::try_from_secs_f64(given) {
        Ok(wall) if given <= 1e9 => Ok(wall),
        _ => Err(PyValueError::new_err(format!(
            "wall_timeout must be seconds from 0 to 1e9, got {given}"
        ))),
    }
}

/// Native part of a controller; `elitescript.Controller` is the class to use.
#[pyclass(frozen, module = "elitescript._elitescript")]
pub(crate) struct NativeController {
    inner: Mutex<Option<Arc<SteppedController>>>,
    trace: Arc<CycleBuffer>,
    busy: AtomicBool,
    process: u32,
}

/// The only call that lets time pass.
struct BusyGuard<'a>(&'a AtomicBool);

impl Drop for BusyGuard<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

impl NativeController {
    fn slot(&self) -> MutexGuard<'_, Option<Arc<SteppedController>>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn open(&self) -> PyResult<Arc<SteppedController>> {
        if std::process::id() != self.process {
            return Err(PyRuntimeError::new_err(format!(
                "this controller belongs to process {}; a forked child has none of its threads: start processes \
                 with the method \"spawn\", or fork while no controller is at work and make one here",
                self.process
            )));
        }
        self.slot()
            .clone()
            .ok_or_else(|| ControllerClosed::new_err("the controller was closed"))
    }

    fn turn(&self) -> PyResult<BusyGuard<'_>> {
        match self.busy.swap(true, Ordering::AcqRel) {
            false => Ok(BusyGuard(&self.busy)),
            true => Err(PyRuntimeError::new_err(
                "another call lets the time of this controller pass just now; \
                 stop(), state, trace and io can be used beside it",
            )),
        }
    }

    /// A call that lets time pass, without the interpreter lock; what a signal raises comes out of it.
    fn passing<T: Send>(
        &self,
        py: Python<'_>,
        wall_timeout: f64,
        call: impl FnOnce(&SteppedController, &mut WallTimeout<'_>) -> T + Send,
    ) -> PyResult<T> {
        let wall = wall(wall_timeout)?;
        let inner = self.open()?;
        let _turn = self.turn()?;
        let mut raised = None;
        let done = py.detach(|| {
            let mut goes_on = || {
                if raised.is_none() {
                    raised = Python::attach(|py| py.check_signals()).err();
                }
                raised.is_none()
            };
            call(
                &inner,
                &mut WallTimeout {
                    wall,
                    keep_going: &mut goes_on,
                },
            )
        });
        match raised {
            None => Ok(done),
            Some(raised) => {
                // The controller can be used afterwards. What stands in the way of that is said by the next call.
                let _ = py.detach(|| inner.stop());
                Err(raised)
            }
        }
    }
}

pub(crate) fn preset_all(given: &[(String, String)]) -> PyResult<Vec<Preset>> {
    given
        .iter()
        .map(|(name, value)| Preset::new(name, value))
        .collect::<Result<_, _>>()
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

#[pymethods]
impl NativeController {
    /// Options as texts; `trace` is the most cycles that are kept.
    #[new]
    fn new(py: Python<'_>, options: BTreeMap<String, String>, trace: usize) -> PyResult<Self> {
        let config: ControllerConfig = settings::read(&options)?;
        let trace = Arc::new(CycleBuffer::new(trace));
        let observer = trace.clone();
        let inner = py
            .detach(|| SteppedController::open(&config, observer))
            .map_err(|error| start_error(&error))?;
        Ok(Self {
            inner: Mutex::new(Some(Arc::new(inner))),
            trace,
            busy: AtomicBool::new(false),
            process: std::process::id(),
        })
    }

    fn run(
        &self,
        py: Python<'_>,
        name: String,
        text: String,
        presets: Vec<(String, String)>,
        timeout: f64,
        wall_timeout: f64,
    ) -> PyResult<ResultParts> {
        let simulated = seconds("timeout", timeout)?;
        let presets = preset_all(&presets)?;
        let result = self.passing(py, wall_timeout, |inner, patience| {
            inner.controller().supervisor().set_presets(&presets);
            inner.run_program(ProgramText { name, text }, simulated, patience)
        })?;
        result.map(parts).map_err(|error| stepped_error(&error))
    }

    fn start(
        &self,
        py: Python<'_>,
        name: String,
        text: String,
        presets: Vec<(String, String)>,
        wall_timeout: f64,
    ) -> PyResult<()> {
        let presets = preset_all(&presets)?;
        let started = self.passing(py, wall_timeout, |inner, patience| {
            inner.controller().supervisor().set_presets(&presets);
            inner.start(ProgramText { name, text }, patience)
        })?;
        started.map_err(|error| stepped_error(&error))
    }

    fn finish(&self, py: Python<'_>, timeout: f64, wall_timeout: f64) -> PyResult<ResultParts> {
        let simulated = seconds("timeout", timeout)?;
        let result = self.passing(py, wall_timeout, |inner, patience| {
            inner.run_to_end(simulated, patience)
        })?;
        result.map(parts).map_err(|error| stepped_error(&error))
    }

    fn step(&self, py: Python<'_>, cycles: u64, wall_timeout: f64) -> PyResult<()> {
        let passed = self.passing(py, wall_timeout, |inner, patience| {
            inner.advance(cycles, patience)
        })?;
        passed.map(drop).map_err(|error| stepped_error(&error))
    }

    /// Lets time pass until the condition holds.
    fn run_until(
        &self,
        py: Python<'_>,
        condition: String,
        timeout: f64,
        wall_timeout: f64,
    ) -> PyResult<bool> {
        let simulated = seconds("timeout", timeout)?;
        let answer = self.passing(py, wall_timeout, |inner, patience| {
            let condition =
                Condition::new("condition", &condition).map_err(RunUntilError::Condition)?;
            if condition.uses_clearance() {
                condition.set_scene(inner.collision_scene());
            }
            let mut cycle = CycleMessage::default();
            let world = inner
                .controller()
                .world()
                .filter(|_| condition.uses_world());
            inner.advance_until(
                |state| {
                    cycle.set_from_state(state);
                    if let Some(world) = world {
                        condition.set_world(Some(world.facts()));
                    }
                    let held = inner
                        .collector()
                        .follower()
                        .with_position(|doing| condition.holds(&cycle, doing));
                    held.map_err(RunUntilError::Condition)
                },
                simulated,
                patience,
            )
        })?;
        answer.map_err(|error| match error {
            RunUntilError::Stepped(error) => stepped_error(&error),
            RunUntilError::Condition(error) => PyValueError::new_err(error.to_string()),
        })
    }

    /// Ends the program. While another call lets it run, that call ends with its result, and this one gives None.
    fn stop(&self, py: Python<'_>) -> PyResult<Option<ResultParts>> {
        let inner = self.open()?;
        let Ok(_turn) = self.turn() else {
            inner.request_stop();
            return Ok(None);
        };
        let result = py.detach(|| inner.stop());
        let result = result.map_err(|error| stepped_error(&error))?;
        Ok(result.map(parts))
    }

    /// How the newest program ended, None while it runs and before the first.
    fn result(&self) -> PyResult<Option<ResultParts>> {
        let inner = self.open()?;
        match inner.is_running() {
            true => Ok(None),
            false => Ok(inner.result().map(parts)),
        }
    }

    fn is_running(&self) -> PyResult<bool> {
        Ok(self.open()?.is_running())
    }

    /// What the newest program printed so far.
    fn prints(&self) -> PyResult<Vec<String>> {
        Ok(self.open()?.collector().prints())
    }

    /// The bytes of the row of the latest cycle.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let inner = self.open()?;
        let mut bytes = Vec::with_capacity(Row::BYTES);
        Row::from(&inner.state()).write(&mut bytes);
        Ok(PyArray1::from_vec(py, bytes))
    }

    /// The bytes of the rows that are kept, and how many were dropped before them. Also after the end of the
    /// controller.
    fn trace<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray1<u8>>, u64)> {
        if let Ok(inner) = self.open() {
            py.detach(|| inner.controller().robot().pump());
        }
        let (bytes, dropped) = py.detach(|| self.trace.bytes());
        Ok((PyArray1::from_vec(py, bytes), dropped))
    }

    fn peaks(&self) -> PyResult<PeakParts> {
        let inner = self.open()?;
        inner.controller().robot().pump();
        let peaks = inner.collector().peaks();
        Ok((
            peaks.tcp_speed,
            peaks.tcp_force,
            peaks.tcp_torque,
            peaks.joint_speed,
            peaks.joint_torque,
        ))
    }

    fn io_get<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let point = point_named(name)?;
        let inner = self.open()?;
        let robot = inner.controller().robot();
        match PointReading::new(point, &robot.io(), robot.registers()) {
            PointReading::Level(level) => level.into_bound_py_any(py),
            PointReading::Whole(value) => value.into_bound_py_any(py),
            PointReading::Number(value) => value.into_bound_py_any(py),
        }
    }

    fn io_set(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let point = point_named(name)?;
        let inner = self.open()?;
        let robot = inner.controller().robot();
        let change = PointChange::new(point, &point_value(value), &robot.state().io_config);
        match change.map_err(|error| PyValueError::new_err(error.to_string()))? {
            PointChange::Register(direction, value) => {
                value.write(direction, robot.registers());
                Ok(())
            }
            PointChange::Io(change) => {
                let sent = robot.send(Origin::default(), SettingCommand::SetIo(change));
                sent.map(drop)
                    .map_err(|full| PyRuntimeError::new_err(full.to_string()))
            }
        }
    }

    /// A wrench on the tool from now on, about the TCP, N and Nm: in base or tool axes.
    fn set_wrench(&self, wrench: [f64; 6], in_tool_axes: bool) -> PyResult<()> {
        let push = CommandKind::Sensing(SensingCommand::Push {
            wrench,
            in_tool_axes,
            duration: FOR_GOOD,
            replaces: true,
        });
        let inner = self.open()?;
        let sent = inner.controller().robot().send(Origin::default(), push);
        sent.map(drop)
            .map_err(|full| PyRuntimeError::new_err(full.to_string()))
    }

    /// Gives the robot an order as the pendant does.
    fn order(&self, name: &str) -> PyResult<()> {
        let kind = match name {
            "unlock" => CommandKind::Machine(MachineCommand::UnlockProtectiveStop),
            "emergency_stop" => {
                CommandKind::Machine(MachineCommand::EmergencyStop { pressed: true })
            }
            "release_emergency_stop" => {
                CommandKind::Machine(MachineCommand::EmergencyStop { pressed: false })
            }
            "power_on" => CommandKind::Machine(MachineCommand::PowerOn),
            "release_brakes" => CommandKind::Machine(MachineCommand::ReleaseBrakes),
            _ => {
                return Err(PyValueError::new_err(format!(
                    "there is no order {name:?}; allowed are unlock, emergency_stop, release_emergency_stop, \
                     power_on and \
                     release_brakes"
                )));
            }
        };
        let sent = self
            .open()?
            .controller()
            .robot()
            .send(Origin::default(), kind);
        sent.map(drop)
            .map_err(|full| PyRuntimeError::new_err(full.to_string()))
    }

    /// Parts of the cell that are there: name, pose, speed, gripper that holds it. None where the cell has no parts.
    fn parts(&self) -> PyResult<Option<Vec<PartRow>>> {
        let inner = self.open()?;
        let Some(world) = inner.controller().world() else {
            return Ok(None);
        };
        let facts = world.facts();
        let parts = facts.parts();
        let row = |part: &controller::cell_world::topic::PartRow| {
            (
                part.name.clone(),
                part.pose,
                part.speed,
                part.held_by.clone(),
            )
        };
        Ok(Some(parts.map(row).collect()))
    }

    /// Numbers of parts that a sink has removed.
    fn count(&self, sink: &str) -> PyResult<u64> {
        let inner = self.open()?;
        let count = world_of(&inner)?.facts().count(sink);
        count.ok_or_else(|| PyValueError::new_err(format!("there is no sink {sink:?}")))
    }

    /// Puts a part somewhere, at rest.
    fn place(&self, name: String, pose: [f64; 6]) -> PyResult<()> {
        self.world_order(WorldOrder::Place { name, pose }).map(drop)
    }

    /// Takes a part out of the world.
    fn remove(&self, name: String) -> PyResult<()> {
        self.world_order(WorldOrder::Remove { name }).map(drop)
    }

    /// Puts another part of a template into the world; its name.
    fn add(&self, template: String, pose: [f64; 6]) -> PyResult<String> {
        let added = self.world_order(WorldOrder::Add { template, pose })?;
        Ok(added.unwrap_or_default())
    }

    /// Lets something go wrong, for ever without a duration.
    fn fault(&self, what: String, name: String, duration: Option<f64>) -> PyResult<()> {
        let fault = WorldOrder::Fault {
            what,
            name,
            duration,
        };
        self.world_order(fault).map(drop)
    }

    /// The file that is being recorded.
    fn recording_path(&self) -> PyResult<Option<std::path::PathBuf>> {
        let inner = self.open()?;
        Ok(inner.controller().recording_path().map(Into::into))
    }

    /// Ends the controller. True when the recording was written to its end; a second call has nothing to do.
    fn close(&self, py: Python<'_>) -> PyResult<bool> {
        if std::process::id() != self.process {
            // Nothing of it runs here.
            std::mem::forget(self.slot().take());
            return Ok(false);
        }
        let _turn = match self.turn() {
            Ok(turn) => turn,
            Err(_) if self.slot().is_none() => return Ok(true),
            Err(busy) => return Err(busy),
        };
        let Some(inner) = self.slot().take() else {
            return Ok(true);
        };
        py.detach(|| shut_down(inner))
            .map_err(|error| stepped_error(&error))
    }

    /// The words for how programs end.
    #[staticmethod]
    fn outcomes() -> Vec<&'static str> {
        ProgramOutcome::ALL
            .into_iter()
            .map(ProgramOutcome::as_str)
            .collect()
    }
}

/// Ends a controller once those that only look at it have let it go.
/// Name, pose, speed in m/s, and the gripper that holds it.
type PartRow = (String, [f64; 6], f64, Option<String>);

fn world_of(inner: &SteppedController) -> PyResult<&CellWorld> {
    let world = inner.controller().world();
    world.ok_or_else(|| PyRuntimeError::new_err("the cell has no parts"))
}

impl NativeController {
    /// Tells the world something between two cycles.
    fn world_order(&self, order: WorldOrder) -> PyResult<Option<String>> {
        let inner = self.open()?;
        let done = world_of(&inner)?.order(order);
        done.map_err(|error| PyValueError::new_err(error.to_string()))
    }
}

fn shut_down(inner: Arc<SteppedController>) -> Result<bool, SteppedError> {
    let mut shared = inner;
    loop {
        match Arc::try_unwrap(shared) {
            Ok(alone) => return alone.shut_down(),
            Err(still_shared) => shared = still_shared,
        }
        std::thread::sleep(Duration::from_micros(50));
    }
}

impl Drop for NativeController {
    fn drop(&mut self) {
        let Some(inner) = self.slot().take() else {
            return;
        };
        if std::process::id() != self.process {
            return std::mem::forget(inner);
        }
        // Nobody is left to hear of a program that does not end.
        let _ = Python::attach(|py| py.detach(|| shut_down(inner)));
    }
}
