//! Many arms that are moved together: joint speeds in, rows of cycles out, on every core, without Python in between.
//!
//! Owns the arms of vectorised environments. An arm is begun anew in a place of its own; programs do not run here.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use controller::{NullObserver, SteppedController, SteppedError, WallTimeout};
use kinematics::JointSpeeds;
use motion_api::{CommandKind, IoChange, OnlineCommand, Origin, SafetyMode, SettingCommand};
use numpy::PyArray1;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::arguments::{PyArgument, Rows};
use crate::native_controller::start_error;
use crate::row::Row;
use crate::settings;

/// No cycle of a plant takes so long.
const PATIENCE: Duration = Duration::from_secs(30);
/// Most arms of a fleet.
const ARMS_MAX: usize = 4096;
/// Numbers of a part in [`ArmBatch::part_poses`]: its pose, and whether a gripper holds it.
const PART_NUMBERS: usize = 7;
/// Standard digital outputs.
const OUTPUTS: u8 = 16;

/// Arms that are moved together.
#[pyclass(frozen, name = "Fleet", module = "elitescript._elitescript")]
pub(crate) struct ArmBatch {
    arms: Vec<Mutex<Option<SteppedController>>>,
    threads: usize,
    process: u32,
}

/// One arm for some cycles: speeds that it takes up with the acceleration and holds.
fn drive(
    arm: &SteppedController,
    speeds: [f64; 6],
    acceleration: f64,
    cycles: u64,
) -> Result<(), SteppedError> {
    let robot = arm.controller().robot();
    let kind = CommandKind::Online(OnlineCommand::SpeedJ {
        speeds: JointSpeeds(speeds),
        acceleration,
        duration: None,
    });
    if matches!(
        robot.state().safety_mode,
        SafetyMode::Normal | SafetyMode::Reduced
    ) {
        // A ring that is full takes the next one: speeds are sent every step.
        let _ = robot.send(Origin::default(), kind);
    }
    arm.advance(
        cycles,
        &mut WallTimeout {
            wall: PATIENCE,
            keep_going: &mut || true,
        },
    )
    .map(drop)
}

impl ArmBatch {
    fn of_this_process(&self) -> PyResult<()> {
        match std::process::id() == self.process {
            true => Ok(()),
            false => Err(PyRuntimeError::new_err(format!(
                "these arms belong to process {}; a forked child has none of their threads: start processes \
                 with the method \"spawn\"",
                self.process
            ))),
        }
    }

    /// `work` on every arm, spread over the threads; the first trouble.
    fn each<E: Send>(
        &self,
        work: impl Fn(usize, &Mutex<Option<SteppedController>>) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let threads = self.threads.clamp(1, self.arms.len().max(1));
        let share = self.arms.len().div_ceil(threads).max(1);
        let trouble = Mutex::new(None);
        let (arms, work, trouble_of) = (&self.arms, &work, &trouble);
        let take = move |first: usize| {
            for (index, arm) in arms.iter().enumerate().skip(first).take(share) {
                if let Err(error) = work(index, arm) {
                    let mut trouble = trouble_of.lock().unwrap_or_else(PoisonError::into_inner);
                    trouble.get_or_insert(error);
                }
            }
        };
        std::thread::scope(|scope| {
            for thread in 1..threads {
                scope.spawn(move || take(thread * share));
            }
            take(0);
        });
        let trouble = trouble.into_inner().unwrap_or_else(PoisonError::into_inner);
        trouble.map_or(Ok(()), Err)
    }
}

#[pymethods]
impl ArmBatch {
    /// Places for `arms` arms, none begun, moved on `threads` threads.
    #[new]
    fn new(arms: usize, threads: usize) -> PyResult<Self> {
        if !(1..=ARMS_MAX).contains(&arms) {
            return Err(PyValueError::new_err(format!(
                "n must be from 1 to {ARMS_MAX}, got {arms}"
            )));
        }
        Ok(Self {
            arms: (0..arms).map(|_| Mutex::new(None)).collect(),
            threads,
            process: std::process::id(),
        })
    }

    /// Begins arms anew: their places, and the options of each.
    fn begin(
        &self,
        py: Python<'_>,
        places: Vec<usize>,
        options: Vec<BTreeMap<String, String>>,
    ) -> PyResult<()> {
        self.of_this_process()?;
        let mut configs = BTreeMap::new();
        for (place, options) in places.iter().zip(&options) {
            if *place >= self.arms.len() {
                return Err(PyValueError::new_err(format!(
                    "there is no arm {place}; there are {}",
                    self.arms.len()
                )));
            }
            configs.insert(*place, settings::read(options)?);
        }
        py.detach(|| {
            self.each(|index, arm| {
                let Some(config) = configs.get(&index) else {
                    return Ok(());
                };
                let mut arm = arm.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some(old) = arm.take() {
                    // No program runs on it that could stand in the way.
                    let _ = old.shut_down();
                }
                *arm = Some(SteppedController::open(config, Arc::new(NullObserver))?);
                Ok(())
            })
        })
        .map_err(|error| start_error(&error))
    }

    /// Moves every arm for some cycles with joint speeds, one row an arm.
    fn step(
        &self,
        py: Python<'_>,
        speeds: PyArgument<'_, '_>,
        acceleration: f64,
        cycles: u64,
    ) -> PyResult<()> {
        self.of_this_process()?;
        let speeds = Rows::<6>::read("action", speeds)?;
        if speeds.batch().is_some_and(|rows| rows != self.arms.len()) {
            return Err(PyValueError::new_err(format!(
                "action must have one row for each of the {} arms, got {}",
                self.arms.len(),
                speeds.batch().unwrap_or(1)
            )));
        }
        let rows: Vec<[f64; 6]> = (0..self.arms.len()).map(|i| *speeds.at(i)).collect();
        py.detach(|| {
            self.each(|index, arm| {
                let arm = arm.lock().unwrap_or_else(PoisonError::into_inner);
                match &*arm {
                    Some(arm) => drive(arm, rows[index], acceleration, cycles)
                        .map_err(|error| error.to_string()),
                    None => Err(format!("arm {index} was not begun; reset() begins it")),
                }
            })
        })
        .map_err(PyRuntimeError::new_err)
    }

    /// Sets a standard digital output of every arm, one level an arm; it has it in the next cycle.
    fn set_output(&self, output: u8, levels: Vec<bool>) -> PyResult<()> {
        self.of_this_process()?;
        if output >= OUTPUTS || levels.len() != self.arms.len() {
            return Err(PyValueError::new_err(format!(
                "an output from 0 to {} with one level for each of the {} arms, got output {output} with {} levels",
                OUTPUTS - 1,
                self.arms.len(),
                levels.len()
            )));
        }
        for (arm, level) in self.arms.iter().zip(levels) {
            let arm = arm.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(arm) = &*arm {
                let change = IoChange::DigitalOut {
                    mask: 1 << output,
                    levels: u32::from(level) << output,
                };
                let robot = arm.controller().robot();
                robot
                    .send(Origin::default(), SettingCommand::SetIo(change))
                    .map_err(|full| PyRuntimeError::new_err(full.to_string()))?;
            }
        }
        Ok(())
    }

    /// Pose of a part in every arm's cell and 1 where a gripper holds it, seven numbers an arm; NaN where there is no
    /// such part.
    fn part_poses<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_this_process()?;
        let mut numbers = Vec::with_capacity(self.arms.len() * PART_NUMBERS);
        for arm in &self.arms {
            let arm = arm.lock().unwrap_or_else(PoisonError::into_inner);
            let mut row = [f64::NAN; PART_NUMBERS];
            if let Some(world) = arm.as_ref().and_then(|arm| arm.controller().world()) {
                let world = world.lock();
                let parts = &world.state().parts;
                if let Some(part) = parts.iter().find(|part| &*part.name == name) {
                    row[..6].copy_from_slice(&part.pose.to_rpy().to_array());
                    row[6] = f64::from(part.held_by.is_some());
                }
            }
            numbers.extend(row);
        }
        Ok(PyArray1::from_vec(py, numbers))
    }

    /// The bytes of the rows of the latest cycles, an arm each.
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        self.of_this_process()?;
        let mut bytes = Vec::with_capacity(self.arms.len() * Row::BYTES);
        for (index, arm) in self.arms.iter().enumerate() {
            let arm = arm.lock().unwrap_or_else(PoisonError::into_inner);
            let Some(arm) = &*arm else {
                return Err(PyRuntimeError::new_err(format!(
                    "arm {index} was not begun; reset() begins it"
                )));
            };
            Row::from(&arm.state()).write(&mut bytes);
        }
        Ok(PyArray1::from_vec(py, bytes))
    }

    /// Ends all arms.
    fn close(&self, py: Python<'_>) {
        if std::process::id() != self.process {
            return;
        }
        py.detach(|| self.end());
    }
}

impl ArmBatch {
    fn end(&self) {
        for arm in &self.arms {
            let arm = arm.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(arm) = arm {
                // No program runs on it that could stand in the way.
                let _ = arm.shut_down();
            }
        }
    }
}

impl Drop for ArmBatch {
    fn drop(&mut self) {
        if std::process::id() == self.process {
            self.end();
        } else {
            for arm in &self.arms {
                std::mem::forget(arm.lock().unwrap_or_else(PoisonError::into_inner).take());
            }
        }
    }
}
