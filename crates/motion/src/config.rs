//! What a controller is made of: model, step time, tool, limits, plant. Checked once, before the first cycle.

use kinematics::dynamics::GRAVITY_UPRIGHT;
use kinematics::{
    JointAccelerations, JointJerks, JointLimits, JointPositions, JointSpeeds, Payload, Pose,
    RobotModel, RpyPose, safety::SafetyBounds,
};
use motion_api::{RobotMode, RobotState};
use nalgebra::Vector3;

pub use crate::config_error::ConfigError;
use crate::constants::{FASTEST_RISE, LINK_OVERLAP, MIN_LIMITS, REDUCED_TCP_SPEED, STEP_RANGE};
use crate::contact::Environment;
use crate::external::TimedWrench;
use crate::io::IoSetup;
use crate::modes::encoder::Belt;
use crate::plant::PlantParameters;
use crate::safety_inputs::SafetyInputs;
use crate::sensor::SensorNoise;

/// The arm that the setpoints move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlantKind {
    /// Rigid bodies under gravity with a servo, moved by our own equations: the arm lags, sags and can be held up.
    #[default]
    Rigid,
    /// Rigid bodies in the rapier engine: slower, and independent of our equations of motion.
    Rapier,
    /// The actual position is the target.
    Ideal,
}

/// Limits below the model's own, as the cell file's `[limits]` gives them. `None` keeps the model's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimitOverrides {
    /// Joint speeds, rad/s.
    pub joint_speed: Option<JointSpeeds>,
    /// Joint accelerations, rad/s².
    pub joint_acceleration: Option<JointAccelerations>,
    /// Joint jerks, rad/s³.
    pub joint_jerk: Option<JointJerks>,
    /// Smallest joint positions, rad.
    pub joint_position_min: Option<JointPositions>,
    /// Largest joint positions, rad.
    pub joint_position_max: Option<JointPositions>,
    /// Speed of the TCP, m/s.
    pub tcp_speed: Option<f64>,
    /// Speed of the elbow, m/s.
    pub elbow_speed: Option<f64>,
    /// Force at the TCP, N.
    pub tcp_force: Option<f64>,
    /// Whether the arm is kept from running into itself; `None`: it is.
    pub self_collision: Option<bool>,
}

/// Everything a [`CycleMessage`](crate::CycleMessage) is made from.
#[derive(Clone, Debug)]
pub struct CycleConfig {
    /// The arm.
    pub model: RobotModel,
    /// Length of a cycle, s: 0.001 to 0.008.
    pub step_time: f64,
    /// Joint positions at the start, rad.
    pub home: JointPositions,
    /// TCP relative to the flange.
    pub tcp: RpyPose,
    /// What hangs on the flange.
    pub payload: Payload,
    /// Free-fall acceleration in the base frame, m/s².
    pub gravity: Vector3<f64>,
    /// The arm that follows.
    pub plant: PlantKind,
    /// Limits below the model's.
    pub limits: LimitOverrides,
    /// Limits of reduced mode, not above those. `None` keeps them; the TCP's speed is [`REDUCED_TCP_SPEED`] then.
    pub reduced_limits: LimitOverrides,
    /// Start with power off and brakes engaged.
    pub powered_off: bool,
    /// Wires and timed inputs.
    pub io: IoSetup,
    /// Inputs that mean something to the safety system.
    pub safety_inputs: SafetyInputs,
    /// Safety planes and the tool they hold back.
    pub safety: SafetyBounds,
    /// Belts that turn the two encoders.
    pub belts: [Option<Belt>; 2],
    /// Loads on the tool by time.
    pub loads: Vec<TimedWrench>,
    /// Obstacles, and the tool that touches them.
    pub surroundings: Environment,
    /// Noise of the force sensor.
    pub sensor_noise: SensorNoise,
    /// What is true of the arm though the controller does not know it.
    pub truth: PlantParameters,
    /// Whether contact stops the arm: collisions, and forces at the TCP above their limit. Who measures how far a
    /// program is from collisions lets it run through them.
    pub contact_stops: bool,
}

/// The limits a motion is planned and checked with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Smallest joint positions, rad.
    pub position_min: JointPositions,
    /// Largest joint positions, rad.
    pub position_max: JointPositions,
    /// Joint speeds, rad/s.
    pub speed: JointSpeeds,
    /// Joint accelerations, rad/s².
    pub acceleration: JointAccelerations,
    /// Joint jerks, rad/s³.
    pub jerk: JointJerks,
    /// Speed of the TCP, m/s; infinite when not limited.
    pub tcp_speed: f64,
    /// Speed of the elbow, m/s; infinite when not limited.
    pub elbow_speed: f64,
    /// Force at the TCP, N; infinite when not limited.
    pub tcp_force: f64,
    /// How far the capsules of two links may overlap, m; infinite when nobody looks.
    pub link_overlap: f64,
}

impl MotionLimits {
    /// These limits with a share of the joint speeds, accelerations and jerks; the position ranges stay.
    pub(crate) fn scaled(&self, share: f64) -> Self {
        Self {
            speed: self.speed.map(|x| x * share),
            acceleration: self.acceleration.map(|x| x * share),
            jerk: self.jerk.map(|x| x * share),
            ..*self
        }
    }

    /// The arm's limits with these in place of its own.
    pub(crate) fn applied_to(&self, own: &JointLimits) -> JointLimits {
        JointLimits {
            position_min: self.position_min,
            position_max: self.position_max,
            speed: self.speed,
            acceleration: self.acceleration,
            effort: own.effort,
        }
    }
}

impl CycleConfig {
    /// A controller for `model` with the defaults of the command line: 4 ms, home over the table, no tool, rigid plant.
    pub fn new(model: RobotModel) -> Self {
        use core::f64::consts::FRAC_PI_2;
        Self {
            model,
            step_time: 0.004,
            home: JointPositions([0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, 0.0]),
            tcp: RpyPose::default(),
            payload: Payload::default(),
            gravity: GRAVITY_UPRIGHT,
            plant: PlantKind::default(),
            limits: LimitOverrides::default(),
            reduced_limits: LimitOverrides::default(),
            powered_off: false,
            io: IoSetup::default(),
            safety_inputs: SafetyInputs::default(),
            safety: SafetyBounds::default(),
            belts: [None; 2],
            loads: Vec::new(),
            surroundings: Environment::default(),
            sensor_noise: SensorNoise::default(),
            truth: PlantParameters::default(),
            contact_stops: true,
        }
    }

    /// The robot mode at the start.
    pub(crate) fn robot_mode(&self) -> RobotMode {
        if self.powered_off {
            RobotMode::PowerOff
        } else {
            RobotMode::Running
        }
    }

    /// The state before the first cycle, for the snapshot cell of the border.
    pub fn first_state(&self) -> RobotState {
        let flange_from_tcp = Pose::from_rpy(&self.tcp);
        let frames = self.model.forward(&self.home);
        let pose = (frames.base_from_flange * flange_from_tcp).to_rpy();
        RobotState {
            target_tcp_pose: pose,
            actual_tcp_pose: pose,
            elbow_position: frames.elbow().into(),
            tcp_offset: self.tcp,
            payload: self.payload,
            robot_mode: self.robot_mode(),
            target_waypoint: pose,
            gravity: self.gravity.into(),
            ..RobotState::at_start(self.home, self.step_time)
        }
    }

    /// The arm with the limits in force: what planning, and whoever checks positions before it, must use.
    ///
    /// # Errors
    /// The errors of [`resolve`](Self::resolve).
    pub fn limited_model(&self) -> Result<RobotModel, ConfigError> {
        let limits = self.resolve()?.applied_to(self.model.limits());
        Ok(self.model.clone().with_limits(limits))
    }

    /// Checks everything and resolves the limits.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting, what was given and what is allowed.
    pub fn resolve(&self) -> Result<MotionLimits, ConfigError> {
        if !(STEP_RANGE.0..=STEP_RANGE.1).contains(&self.step_time) {
            return Err(ConfigError::StepTime {
                given_s: self.step_time,
            });
        }
        if !self.tcp.is_finite() {
            return Err(ConfigError::NotFinite { name: "tcp" });
        }
        if !self.gravity.iter().all(|x| x.is_finite()) {
            return Err(ConfigError::NotFinite { name: "gravity" });
        }
        let limits = self.limits.resolve(self.model.limits(), &NAMES)?;
        self.resolve_reduced()?;
        for joint in 0..6 {
            let (min, max) = (limits.position_min[joint], limits.position_max[joint]);
            if !(min..=max).contains(&self.home[joint]) {
                return Err(ConfigError::Home {
                    joint,
                    value: self.home[joint],
                    min,
                    max,
                });
            }
        }
        Ok(limits)
    }
}

impl CycleConfig {
    /// The safety settings with everything that targets are judged by: planes, the ranges of reduced mode, links that
    /// meet.
    ///
    /// # Errors
    /// [`ConfigError`] for limits that cannot be used.
    pub fn target_safety_bounds(&self) -> Result<SafetyBounds, ConfigError> {
        let (limits, reduced) = (self.resolve()?, self.resolve_reduced()?);
        let bounds = self.safety.clone().with_link_overlap(limits.link_overlap);
        Ok(bounds.with_reduced_range(reduced.position_min, reduced.position_max))
    }

    /// The limits of reduced mode.
    ///
    /// # Errors
    /// [`ConfigError`] names the limit that is above the one outside of reduced mode, or cannot be.
    pub(crate) fn resolve_reduced(&self) -> Result<MotionLimits, ConfigError> {
        let own = self.model.limits();
        let normal = self.limits.resolve(own, &NAMES)?;
        let asked = &self.reduced_limits;
        let mut reduced = asked.resolve(&normal.applied_to(own), &REDUCED_NAMES)?;
        if asked.joint_jerk.is_none() {
            reduced.jerk = normal.jerk;
        }
        let names = &REDUCED_NAMES;
        let slow = normal.tcp_speed.min(REDUCED_TCP_SPEED);
        for (name, unit, asked, reduced, most, otherwise) in [
            (
                names.tcp_speed,
                "m/s",
                asked.tcp_speed,
                &mut reduced.tcp_speed,
                normal.tcp_speed,
                slow,
            ),
            (
                names.elbow_speed,
                "m/s",
                asked.elbow_speed,
                &mut reduced.elbow_speed,
                normal.elbow_speed,
                normal.elbow_speed,
            ),
            (
                names.tcp_force,
                "N",
                asked.tcp_force,
                &mut reduced.tcp_force,
                normal.tcp_force,
                normal.tcp_force,
            ),
        ] {
            if let Some(given) = asked
                && given > most
            {
                return Err(ConfigError::AboveNormal {
                    name,
                    given,
                    normal: most,
                    unit,
                });
            }
            *reduced = asked.unwrap_or(otherwise);
        }
        reduced.link_overlap = normal.link_overlap;
        Ok(reduced)
    }
}

/// The keys of a table of limits.
struct LimitKeys {
    joint_speed: &'static str,
    joint_acceleration: &'static str,
    joint_jerk: &'static str,
    tcp_speed: &'static str,
    elbow_speed: &'static str,
    tcp_force: &'static str,
}

const NAMES: LimitKeys = LimitKeys {
    joint_speed: "joint_speed",
    joint_acceleration: "joint_acceleration",
    joint_jerk: "joint_jerk",
    tcp_speed: "tcp_speed",
    elbow_speed: "elbow_speed",
    tcp_force: "tcp_force",
};

const REDUCED_NAMES: LimitKeys = LimitKeys {
    joint_speed: "reduced.joint_speed",
    joint_acceleration: "reduced.joint_acceleration",
    joint_jerk: "reduced.joint_jerk",
    tcp_speed: "reduced.tcp_speed",
    elbow_speed: "reduced.elbow_speed",
    tcp_force: "reduced.tcp_force",
};

impl LimitOverrides {
    fn resolve(&self, own: &JointLimits, names: &LimitKeys) -> Result<MotionLimits, ConfigError> {
        let speed = JointSpeeds(joint_limits_within_model(
            names.joint_speed,
            self.joint_speed.map(|x| x.0),
            (MIN_LIMITS.joint_speed, own.speed.0),
        )?);
        let acceleration = JointAccelerations(joint_limits_within_model(
            names.joint_acceleration,
            self.joint_acceleration.map(|x| x.0),
            (MIN_LIMITS.joint_acceleration, own.acceleration.0),
        )?);
        let own_jerk = acceleration.0.map(|a| a / FASTEST_RISE);
        let jerk = JointJerks(joint_limits_within_model(
            names.joint_jerk,
            self.joint_jerk.map(|x| x.0),
            (MIN_LIMITS.joint_jerk, own_jerk),
        )?);
        let position_min = self.joint_position_min.unwrap_or(own.position_min);
        let position_max = self.joint_position_max.unwrap_or(own.position_max);
        for joint in 0..6 {
            let (min, max) = (position_min[joint], position_max[joint]);
            let (own_min, own_max) = (own.position_min[joint], own.position_max[joint]);
            if !(own_min <= min && min < max && max <= own_max) {
                return Err(ConfigError::PositionRange {
                    joint,
                    min,
                    max,
                    own_min,
                    own_max,
                });
            }
        }
        Ok(MotionLimits {
            position_min,
            position_max,
            speed,
            acceleration,
            jerk,
            tcp_speed: optional_limit(
                MIN_LIMITS.point_speed,
                names.tcp_speed,
                self.tcp_speed,
                "m/s",
            )?,
            elbow_speed: optional_limit(
                MIN_LIMITS.point_speed,
                names.elbow_speed,
                self.elbow_speed,
                "m/s",
            )?,
            tcp_force: optional_limit(MIN_LIMITS.tcp_force, names.tcp_force, self.tcp_force, "N")?,
            link_overlap: match self.self_collision {
                Some(false) => f64::INFINITY,
                _ => LINK_OVERLAP,
            },
        })
    }
}

fn optional_limit(
    least: f64,
    name: &'static str,
    given: Option<f64>,
    unit: &'static str,
) -> Result<f64, ConfigError> {
    match given {
        None => Ok(f64::INFINITY),
        Some(given) if given >= least && given.is_finite() => Ok(given),
        Some(given) => Err(ConfigError::Speed {
            name,
            given,
            least,
            unit,
        }),
    }
}

fn joint_limits_within_model(
    name: &'static str,
    given: Option<[f64; 6]>,
    (least, own): (f64, [f64; 6]),
) -> Result<[f64; 6], ConfigError> {
    let Some(values) = given else { return Ok(own) };
    for joint in 0..6 {
        // Rounded figures of the arm itself are not a mistake.
        if !(values[joint] >= least && values[joint] <= own[joint] * (1.0 + 1e-9)) {
            return Err(ConfigError::JointLimit {
                name,
                joint,
                given: values[joint],
                least,
                own: own[joint],
            });
        }
    }
    Ok(values)
}
