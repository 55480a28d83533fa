//! Force mode: corrections of the TCP's velocity, laid over whatever moves the arm (manual 4.1).
//!
//! In the force frame each axis has a correction: on a force axis it is the speed that [`force::Admittance`] asks for,
//! on any other the way back to where the motion underneath wants the tool. Corrections change under acceleration and
//! jerk limits, so switching the mode on, off or over to other axes is no jump. Joint speeds are the ones nearest to
//! the sum within the reach of every joint and the user's speed limits ([`force::TwistLimiter`]).
//!
//! What the motion underneath does counts by its increments: only the lag of the tool behind it is kept, and of that
//! only the part on axes that are not force controlled. A setpoint's acceleration here is the mean over its step.

use force::{
    Admittance, AxisReading, LimiterError, SolveMethod, TaskFrame, Tuning, TwistLimiter,
    TwistProblem,
};
use kinematics::bounds::within;
use kinematics::elementary::cube;
use kinematics::rotation::rotvec_from_rotation;
use kinematics::{Frames, JointPositions, JointSpeeds, Pose, Wrench};
use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};

use super::axis::AxisLimits;
use super::{OnlineContext, setpoint, states};
use crate::commanded::PositionHistory;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// Speed of the way back over the lag, 1/s.
const CATCH_UP: f64 = 25.0;
/// Fastest way back, m/s and rad/s.
const CATCH_UP_MAX: [f64; 2] = [0.1, 0.5];
/// Fastest way back when force mode has ended under a running motion, m/s and rad/s: the tool may stand a good way off.
const RETURN_MAX: [f64; 2] = [0.02, 0.2];
/// Share of what the joints can do that a correction is planned with.
const SHARE: f64 = 0.7;
/// Share of a correction's acceleration that a force axis reckons with when it has to stop at its target; the rest is
/// for delays.
const BRAKING_SHARE: f64 = 0.6;
/// Least and largest acceleration of a correction, m/s² or rad/s², for singular positions.
const ACCELERATION: (f64, f64) = (0.05, 10.0);
/// Least jerk of a correction, m/s³ or rad/s³, for singular positions.
const JERK_MIN: f64 = 2.0;
/// Share of the TCP's speed limit that a sum of motion and correction uses.
const TCP_SPEED_SHARE: f64 = 0.95;
/// A limit of 0 m/s is a limit of this: an exact zero would leave the rounding of each cycle to the program.
const LEAST_LIMIT: f64 = 1e-6;
/// Slower than this a frozen arm stands, m/s (rad/s) of what is wanted and rad/s of the joints.
const REST_SPEED: f64 = 1e-4;
/// Nearer than this the tool is back, m and rad.
const RETURN_TOLERANCE: f64 = 1e-6;

/// What force mode is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ForceGoal {
    pub(crate) frame: TaskFrame,
    pub(crate) selection: [bool; 6],
    /// What the tool is to apply, in the force frame: N, Nm.
    pub(crate) wrench: [f64; 6],
    /// m/s, rad/s.
    pub(crate) speed_limits: [f64; 6],
}

/// How far force mode is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ForceModePhase {
    /// On.
    On,
    /// Over, while a motion runs: the tool goes back to it.
    Returning,
}

/// Force mode under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActiveForceMode {
    goal: ForceGoal,
    pub(crate) stage: ForceModePhase,
    axes: [Admittance; 6],
    /// Corrections in the force frame at the last cycle; `position` is not used.
    corrections: [ScalarState; 6],
    /// From the commanded TCP to where the motion underneath wants it: base axes, m and rad.
    lag: Vector6<f64>,
    /// Where the arm was one cycle ago.
    previous_positions: Option<JointPositions>,
    /// Nothing moved underneath in the cycle before.
    was_holding: bool,
    /// How the last joint speeds were found.
    pub(crate) method: SolveMethod,
}

/// What a cycle of force mode looks at.
pub(crate) struct ForceModeInput<'a> {
    /// The arm at `commanded`.
    pub(crate) arm: &'a OnlineContext<'a>,
    pub(crate) commanded: &'a Setpoint,
    pub(crate) commanded_frames: &'a Frames,
    /// Where the arm was led in the last cycles, by whatever led it.
    pub(crate) history: &'a PositionHistory,
    /// The motion underneath, a cycle ago and now.
    pub(crate) nominal_before: &'a Setpoint,
    pub(crate) nominal: &'a Setpoint,
    pub(crate) actual: &'a JointPositions,
    /// What the environment applies to the tool: base axes, about the TCP.
    pub(crate) sensed_wrench: Wrench,
    pub(crate) tuning: Tuning,
    /// m/s.
    pub(crate) tcp_speed: f64,
    /// Paused or stopped by a safeguard: force axes stand still.
    pub(crate) is_frozen: bool,
    /// Nothing moves underneath.
    pub(crate) is_holding: bool,
}

/// A TCP: pose, Jacobian (base axes).
struct TcpKinematics {
    pose: Pose,
    jacobian: Matrix6<f64>,
}

impl TcpKinematics {
    fn of(frames: &Frames, flange_from_tcp: &Pose) -> Self {
        let pose = frames.base_from_flange * *flange_from_tcp;
        Self {
            pose,
            jacobian: frames.jacobian(pose.translation),
        }
    }

    fn twist(&self, qd: &JointSpeeds) -> Vector6<f64> {
        self.jacobian * qd.to_vector()
    }
}

/// One axis in one cycle: the correction now, what it may do, and what is wanted of it.
struct AxisCorrection {
    now: ScalarState,
    axis: AxisLimits,
    speed: f64,
    acceleration: f64,
}

impl ActiveForceMode {
    /// From the present motion, whatever it is.
    pub(crate) fn new(goal: ForceGoal) -> Self {
        Self {
            goal,
            stage: ForceModePhase::On,
            axes: core::array::from_fn(new_axis),
            corrections: [ScalarState::default(); 6],
            lag: Vector6::zeros(),
            previous_positions: None,
            was_holding: true,
            method: SolveMethod::Unconstrained,
        }
    }

    /// New axes and targets. What is known of a contact is kept on axes that stay the same.
    pub(crate) fn retarget(&mut self, goal: ForceGoal) {
        let same = self.stage == ForceModePhase::On && self.goal.frame.is_same(&goal.frame);
        for axis in 0..6 {
            if !(same && self.goal.selection[axis]) {
                self.axes[axis] = new_axis(axis);
            }
        }
        if self.stage != ForceModePhase::On {
            self.lag = Vector6::zeros();
        }
        let frame = if same { self.goal.frame } else { goal.frame };
        self.goal = ForceGoal { frame, ..goal };
        self.stage = ForceModePhase::On;
    }

    /// The arm stands after something else braked it. Meanwhile the TCP of the motion underneath and that of the arm
    /// went from the first to the second of these poses.
    pub(crate) fn resume_from(&mut self, underneath: &[Pose; 2], arm: &[Pose; 2]) {
        self.corrections = [ScalarState::default(); 6];
        self.previous_positions = None;
        self.lag += difference(&underneath[1], &underneath[0]) - difference(&arm[1], &arm[0]);
        for k in 0..6 {
            self.axes[k] = new_axis(k);
        }
    }

    /// Force mode is over while a motion runs. `nominal` and `commanded` are the TCP where that motion wants it and
    /// where it is.
    pub(crate) fn begin_return(&mut self, nominal: &Pose, commanded: &Pose) {
        self.stage = ForceModePhase::Returning;
        self.lag = difference(nominal, commanded);
    }

    /// Has the tool come back to the motion underneath?
    pub(crate) fn has_returned(&self) -> bool {
        self.stage == ForceModePhase::Returning
            && self.lag.amax() < RETURN_TOLERANCE
            && self.corrections.iter().all(|c| c.speed.abs() < REST_SPEED)
    }

    fn is_force_axis(&self, axis: usize) -> bool {
        self.stage != ForceModePhase::Returning && self.goal.selection[axis]
    }

    /// The setpoint one step after `view.commanded`.
    ///
    /// # Errors
    /// A number is not finite; nothing else can fail.
    pub(crate) fn next(
        &mut self,
        view: &ForceModeInput,
        limiter: &mut TwistLimiter,
    ) -> Result<Setpoint, LimiterError> {
        let ForceModeInput { arm, commanded, .. } = view;
        let (step, flange_from_tcp) = (arm.step, arm.flange_from_tcp);
        let tcp = TcpKinematics::of(view.commanded_frames, flange_from_tcp);
        let underneath = [view.nominal_before, view.nominal].map(|nominal| {
            let frames = arm.model.forward(&nominal.q);
            let tcp = TcpKinematics::of(&frames, flange_from_tcp);
            (tcp.pose, tcp.twist(&nominal.qd))
        });
        let [(pose_before, twist_before), (pose_after, twist_after)] = underneath;
        if self.was_holding && !view.is_holding {
            // A motion begins where the tool is.
            self.lag = Vector6::zeros();
        }
        self.was_holding = view.is_holding;
        let increment = difference(&pose_after, &pose_before);

        let velocity: Vector3<f64> = twist_after.fixed_rows::<3>(0).into();
        let rotation = self.goal.frame.rotation(&tcp.pose, &velocity);
        let into = into_axes(&rotation);
        let nominal_before = into * twist_before;
        let nominal = into * twist_after;
        let now = into * tcp.twist(&commanded.qd);
        // Where the tool would be behind the motion if the corrections ended.
        let twist_now = tcp.twist(&commanded.qd);
        let behind = into * (self.lag + increment - 0.5 * step * (twist_now + twist_after));

        let axes = self.correction_limits(arm, &tcp.jacobian, &into);
        let readings = self.readings(view, &into);
        let mut wanted = [0.0; 6];
        let mut limits = [f64::INFINITY; 6];
        let mut next = self.corrections;
        let mut is_resting = view.is_frozen && view.nominal.qd.max_abs() == 0.0;
        for k in 0..6 {
            let underneath_before = if self.is_force_axis(k) {
                0.0
            } else {
                nominal_before[k]
            };
            let correction = AxisCorrection {
                now: self.current_correction(k, now[k] - underneath_before, commanded, &tcp, &into),
                axis: axes[k],
                speed: 0.0,
                acceleration: f64::INFINITY,
            };
            let correction = self.update_correction(k, correction, &readings[k], behind[k], view);
            is_resting &= correction.speed.abs() < REST_SPEED;
            let axis = AxisLimits {
                acceleration: correction
                    .axis
                    .acceleration
                    .min(correction.acceleration)
                    .max(1e-3),
                ..correction.axis
            };
            next[k] = axis.step_towards_speed(&correction.now, correction.speed, step);
            wanted[k] = next[k].speed;
            if self.is_force_axis(k) {
                limits[k] = self.goal.speed_limits[k].max(LEAST_LIMIT);
            } else {
                wanted[k] += nominal[k];
            }
        }
        if is_resting && commanded.qd.max_abs() < REST_SPEED {
            self.corrections = [ScalarState::default(); 6];
            return Ok(Setpoint::standing(commanded.q));
        }
        slow_down(&mut wanted, TCP_SPEED_SHARE * view.tcp_speed);

        let setpoint = self.solve_joint_speeds(view, &into, wanted, limits, limiter)?;
        self.corrections = next;
        let reached = arm.model.forward(&setpoint.q).base_from_flange * *flange_from_tcp;
        let lag = into * (self.lag + increment - difference(&reached, &tcp.pose));
        let kept = Vector6::from_fn(|k, _| if self.is_force_axis(k) { 0.0 } else { lag[k] });
        self.lag = into.transpose() * kept;
        Ok(setpoint)
    }

    /// The correction as it is: the speed that the tool has over the motion, and the acceleration of the last plan if
    /// that is the speed it planned.
    fn current_correction(
        &self,
        k: usize,
        speed: f64,
        commanded: &Setpoint,
        tcp: &TcpKinematics,
        into: &Matrix6<f64>,
    ) -> ScalarState {
        let planned = &self.corrections[k];
        let acceleration = if (planned.speed - speed).abs() <= 1e-5 + 0.01 * speed.abs() {
            planned.acceleration
        } else {
            (into * (tcp.jacobian * commanded.qdd.to_vector()))[k]
        };
        ScalarState {
            position: 0.0,
            speed,
            acceleration,
        }
    }

    /// What is wanted of axis `k`.
    fn update_correction(
        &mut self,
        k: usize,
        mut correction: AxisCorrection,
        reading: &AxisReading,
        behind: f64,
        view: &ForceModeInput,
    ) -> AxisCorrection {
        if !self.is_force_axis(k) {
            let most = match self.stage {
                ForceModePhase::Returning => RETURN_MAX[k / 3],
                _ => CATCH_UP_MAX[k / 3],
            };
            correction.speed = within(CATCH_UP * behind, -most, most);
            return correction;
        }
        let reading = AxisReading {
            speed: correction.now.speed,
            speed_limit: self.goal.speed_limits[k],
            braking: BRAKING_SHARE * correction.axis.acceleration,
            jerk: correction.axis.jerk,
            ..*reading
        };
        let aim = self.axes[k].update(&reading, &view.tuning, view.arm.step);
        if !view.is_frozen && self.stage == ForceModePhase::On {
            correction.speed = aim.speed;
            correction.acceleration = aim.acceleration;
        }
        correction
    }

    /// What the arm can do along each axis of the force frame.
    fn correction_limits(
        &self,
        arm: &OnlineContext,
        jacobian: &Matrix6<f64>,
        into: &Matrix6<f64>,
    ) -> [AxisLimits; 6] {
        let inverse = jacobian
            .try_inverse()
            .map(|inverse| inverse * into.transpose());
        let count = self.goal.selection.iter().filter(|s| **s).count().max(1);
        let share = SHARE / (count as f64).sqrt();
        core::array::from_fn(|k| {
            let (mut acceleration, mut jerk) = (0.0, 0.0);
            if let Some(inverse) = &inverse {
                let least = |limit: &dyn Fn(usize) -> f64| {
                    (0..6).fold(f64::INFINITY, |least, joint| {
                        least.min(limit(joint) / inverse[(joint, k)].abs())
                    })
                };
                acceleration = share * least(&|joint| arm.available_axes[joint].acceleration);
                jerk = share * least(&|joint| arm.axes[joint].jerk);
            }
            AxisLimits {
                min: f64::NEG_INFINITY,
                max: f64::INFINITY,
                speed: f64::INFINITY,
                acceleration: within(acceleration, ACCELERATION.0, ACCELERATION.1),
                jerk: jerk.max(JERK_MIN),
            }
        })
    }

    /// What each axis feels and how it has moved; the rest of the reading is filled in by the axis.
    fn readings(&mut self, view: &ForceModeInput, into: &Matrix6<f64>) -> [AxisReading; 6] {
        let arm = view.arm;
        let pose =
            |q: &JointPositions| arm.model.forward(q).base_from_flange * *arm.flange_from_tcp;
        let way = self
            .previous_positions
            .map_or_else(Vector6::zeros, |before| {
                into * difference(&pose(view.actual), &pose(&before))
            });
        self.previous_positions = Some(*view.actual);
        let felt = into * view.sensed_wrench.to_vector();
        // What a motion underneath does, not what hands and surfaces make of the force axes.
        let sliding = (0..3)
            .filter(|k| !self.is_force_axis(*k))
            .map(|k| way[k] * way[k])
            .sum::<f64>()
            .sqrt();
        core::array::from_fn(|k| AxisReading {
            applied: -felt[k],
            target: self.goal.wrench[k],
            displacement: way[k],
            tangential_displacement: sliding,
            speed: 0.0,
            speed_limit: 0.0,
            braking: 0.0,
            jerk: 0.0,
        })
    }

    /// The joints for a wanted twist in the force frame.
    fn solve_joint_speeds(
        &mut self,
        view: &ForceModeInput,
        into: &Matrix6<f64>,
        wanted: [f64; 6],
        limits: [f64; 6],
        limiter: &mut TwistLimiter,
    ) -> Result<Setpoint, LimiterError> {
        let (arm, commanded) = (view.arm, view.commanded);
        let step = arm.step;
        let now = states(commanded);
        let mut lower = JointSpeeds::ZERO;
        let mut upper = JointSpeeds::ZERO;
        for joint in 0..6 {
            let axis = &arm.axes[joint];
            let reachable = axis.reachable_speeds(&now[joint], step);
            // The acceleration of the setpoint before is its mean over that cycle only if it was made here.
            let (nearest, furthest) = view.history.next_within(joint, axis.jerk * cube(step));
            let to_reach =
                |position: f64| 2.0 * (position - now[joint].position) / step - now[joint].speed;
            let keeps_jerk = (to_reach(nearest), to_reach(furthest));
            (lower[joint], upper[joint]) = narrowed(reachable, keeps_jerk);
        }
        // The twist is wanted at the end of the step: the Jacobian is that of the place foreseen.
        let ahead = JointPositions(core::array::from_fn(|joint| {
            now[joint].after(step, 0.0).position
        }));
        let frames = arm.model.forward(&ahead);
        let jacobian = into * TcpKinematics::of(&frames, arm.flange_from_tcp).jacobian;
        let found = limiter.solve(&TwistProblem {
            jacobian,
            desired_twist: wanted,
            weights: [1.0; 6],
            lower,
            upper,
            limits,
            current_speeds: commanded.qd,
        })?;
        self.method = found.method;
        let next = core::array::from_fn(|joint| {
            let even = ScalarState {
                acceleration: (found.qd[joint] - commanded.qd[joint]) / step,
                ..now[joint]
            };
            even.after(step, 0.0)
        });
        Ok(setpoint(&arm.clamp_to_safe(&now, next)))
    }
}

/// The part of `range` that lies in `wish`, or the end of `range` that comes nearest to it.
fn narrowed((low, high): (f64, f64), wish: (f64, f64)) -> (f64, f64) {
    (within(wish.0, low, high), within(wish.1, low, high))
}

fn new_axis(k: usize) -> Admittance {
    Admittance::new(if k < 3 {
        force::AxisKind::Linear
    } else {
        force::AxisKind::Angular
    })
}

/// From base axes into the axes of `rotation`, for both halves of a six-vector.
fn into_axes(rotation: &Rotation3<f64>) -> Matrix6<f64> {
    let back = rotation.matrix().transpose();
    let mut both = Matrix6::zeros();
    both.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
    both.fixed_view_mut::<3, 3>(3, 3).copy_from(&back);
    both
}

/// The way from pose `b` to pose `a`: translation, then rotation vector, base axes.
fn difference(a: &Pose, b: &Pose) -> Vector6<f64> {
    let way = a.translation - b.translation;
    let turn = rotvec_from_rotation(&(a.rotation * b.rotation.inverse()));
    Vector6::new(way.x, way.y, way.z, turn.x, turn.y, turn.z)
}

/// Slows the whole twist down where its linear part is faster than `most`.
fn slow_down(twist: &mut [f64; 6], most: f64) {
    let speed = Vector3::new(twist[0], twist[1], twist[2]).norm();
    if speed > most {
        for component in twist {
            *component *= most / speed;
        }
    }
}
