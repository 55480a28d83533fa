//! Path offsets: a small pose laid over whatever moves the TCP, changed by the program while it moves (from controller
//! output, not from the manual).
//!
//! What is asked for is kept in the axes it was given in and turns with them. What is in force is kept in base axes, so
//! that a corner of the path does not make it jump, and is moved along the axes of what is asked for: an offset across
//! the path leads nowhere else, however little the joints leave for it. A stream of offsets is followed like one of
//! joint positions ([`ServoMode`]): evenly, some cycles late, at its full size as far as the limits allow, and never
//! beyond it. Rotations are small: they are kept as rotation vectors.

use kinematics::elementary::{cos, sin};
use kinematics::rotation::{rotation_from_rotvec, rotvec_from_rotation, rpy_from_rotation};
use kinematics::{
    JointAccelerations, JointPositions, JointSpeeds, Pose, RobotModel, RpyPose, Twist,
};
use motion_api::OffsetAxes;
use nalgebra::{Matrix3, Rotation3, Vector3, Vector6};

use super::axis::AxisLimits;
use super::servo::{GAIN_RANGE, LOOKAHEAD_RANGE, ServoMode};
use crate::constants::ACCELERATION_RISE;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// Largest offsets until a program says otherwise, m and rad.
const DEFAULT_MAX_OFFSET: [f64; 2] = [0.1, 0.5];
/// Fastest change of an offset along an axis, m/s and rad/s, where the joints allow it.
const SPEED: [f64; 2] = [0.25, 1.0];
/// Largest acceleration of an offset along an axis, m/s² and rad/s², where the joints allow it.
const ACCELERATION: [f64; 2] = [10.0, 40.0];
/// An offset is given this speed at least, however little is left for it, m/s and rad/s.
const SLOWEST: f64 = 1e-4;
/// The path has a direction above this speed, m/s.
const MOVING: f64 = 1e-4;
/// The filter has arrived when it is this near to what is asked for: m or rad.
const ARRIVAL_TOLERANCE: f64 = 1e-9;
/// Share of the acceleration with which an offset comes to rest within what is asked for: what the joints leave changes
/// meanwhile.
const COMING_TO_REST: f64 = 0.9;
/// Time before and after a moment at which a rotation is looked at for its change there, s.
const NEARBY: f64 = 1e-4;
/// Components that are smaller, m or rad and per second, are none.
const NONE: f64 = 1e-9;

/// Offsets of the path, in force or not.
#[derive(Clone, Copy, Debug)]
pub struct PathOffset {
    is_on: bool,
    is_stopping: bool,
    axes: OffsetAxes,
    /// Asked for, in `axes`: translation and rotation vector.
    requested: Vector6<f64>,
    /// The offset that is asked for, after the filter.
    filtered: Vector6<f64>,
    /// Share of a new offset taken over in a cycle.
    share: f64,
    most: [f64; 2],
    /// The offset in force, base axes.
    current: [ScalarState; 6],
    /// Direction in which the path led last, base axes.
    tangent: Vector3<f64>,
    /// How the offset is led to what is asked for, in the axes of that, and the offsets that were asked for lately,
    /// whose range it does not leave.
    course: ServoMode,
    lately: OffsetHistory,
}

/// Number of spans of time for which the largest and smallest offsets are kept.
const SPANS: usize = 8;
/// Length of a span, s.
const SPAN: f64 = 0.064;

/// The range of what was asked for in the last half second. Where the joints leave too little for a fast weave it would
/// swing beyond it: each turn comes too late.
#[derive(Clone, Copy, Debug)]
struct OffsetHistory {
    spans: [[(f64, f64); 6]; SPANS],
    /// How long the newest span lasts so far, s.
    newest: f64,
}

impl OffsetHistory {
    /// Nothing but `at`.
    fn only(at: &[f64; 6]) -> Self {
        Self {
            spans: [at.map(|x| (x, x)); SPANS],
            newest: 0.0,
        }
    }

    /// One step later, with what is asked for now.
    fn add(&mut self, asked: &Vector6<f64>, step: f64) {
        self.newest += step;
        if self.newest >= SPAN {
            self.newest -= SPAN;
            self.spans.rotate_right(1);
            self.spans[0] = core::array::from_fn(|k| (asked[k], asked[k]));
        }
        for (k, (low, high)) in self.spans[0].iter_mut().enumerate() {
            (*low, *high) = (low.min(asked[k]), high.max(asked[k]));
        }
    }

    /// The smallest and the largest of a component.
    fn range(&self, k: usize) -> (f64, f64) {
        let spans = self.spans.iter().map(|span| span[k]);
        let all = (f64::INFINITY, f64::NEG_INFINITY);
        spans.fold(all, |(low, high), span| (low.min(span.0), high.max(span.1)))
    }
}

/// What the joints leave for the offset in one cycle, for each component that is in use: m/s or rad/s, and per second².
#[derive(Clone, Copy, Debug)]
pub struct OffsetLimits {
    /// Speeds of translation and rotation.
    pub speed: [f64; 2],
    /// Accelerations of translation and rotation.
    pub acceleration: [f64; 2],
    /// Jerks of translation and rotation.
    pub jerk: [f64; 2],
}

impl PathOffset {
    /// None asked for and none in force.
    pub fn new(step: f64) -> Self {
        Self {
            is_on: false,
            is_stopping: false,
            axes: OffsetAxes::Base,
            requested: Vector6::zeros(),
            filtered: Vector6::zeros(),
            share: 1.0,
            most: DEFAULT_MAX_OFFSET,
            current: [ScalarState::default(); 6],
            tangent: Vector3::x(),
            course: ServoMode::new(&JointPositions([0.0; 6]), step),
            lately: OffsetHistory::only(&[0.0; 6]),
        }
    }

    /// Offsets count from now on.
    pub fn enable(&mut self) {
        self.is_on = true;
        self.is_stopping = false;
    }

    /// Ends the offsets; the arm is wanted where it is.
    pub fn end(&mut self) {
        self.is_on = false;
        self.is_stopping = false;
        self.requested = Vector6::zeros();
        self.filtered = Vector6::zeros();
        self.current = [ScalarState::default(); 6];
        self.course.resume_from(&JointPositions([0.0; 6]));
        self.lately = OffsetHistory::only(&[0.0; 6]);
    }

    /// Sets filter and largest offsets to what a new program finds.
    pub fn reset_settings(&mut self) {
        self.share = 1.0;
        self.most = DEFAULT_MAX_OFFSET;
        if !self.is_on {
            self.end();
        }
    }

    /// True while offsets count.
    pub const fn is_on(&self) -> bool {
        self.is_on
    }

    /// The offset comes to rest wherever it is.
    pub fn stop(&mut self) {
        self.is_stopping = self.is_on;
    }

    /// The offset stands where it is: something else brakes the arm.
    pub fn halt(&mut self) {
        for now in &mut self.current {
            *now = ScalarState::at_rest(now.position);
        }
    }

    /// True when a stop has brought the offset to rest.
    pub fn has_stopped(&self) -> bool {
        self.is_stopping && self.is_standing()
    }

    /// True while the offset comes to rest after a stop, and is not there yet.
    pub fn is_coming_to_rest(&self) -> bool {
        self.is_stopping && !self.is_standing()
    }

    /// True when no axis of the offset moves.
    pub fn is_standing(&self) -> bool {
        self.current
            .iter()
            .all(|x| x.speed == 0.0 && x.acceleration == 0.0)
    }

    /// Asks for an offset; `tool` are the TCP's axes on the path.
    pub fn set(&mut self, offset: &RpyPose, axes: OffsetAxes, tool: &Rotation3<f64>) {
        let pose = Pose::from_rpy(offset);
        let turn = rotvec_from_rotation(&pose.rotation);
        if axes != self.axes {
            let change = self.rotation(axes, tool).inverse() * self.rotation(self.axes, tool);
            self.filtered = rotated(&change, &self.filtered);
            self.course
                .seen_from(|place| rotated(&change, &Vector6::from(*place)).into());
            self.axes = axes;
            let own = self.seen_from(&self.rotation(axes, tool));
            self.lately = OffsetHistory::only(&own.map(|state| state.position));
        }
        let at = pose.translation;
        self.requested = Vector6::new(at.x, at.y, at.z, turn.x, turn.y, turn.z);
    }

    /// Takes this share of a new offset over in each cycle.
    pub fn set_share(&mut self, share: f64) {
        self.share = share;
    }

    /// Offsets are at most this large: m and rad.
    pub fn set_most(&mut self, most: [f64; 2]) {
        self.most = most;
    }

    /// What is asked for and what is allowed, where that is less: m and rad.
    pub fn excess(&self) -> Option<([f64; 2], [f64; 2])> {
        let asked = sizes(&self.requested);
        let is_more = self.is_on && (asked[0] > self.most[0] || asked[1] > self.most[1]);
        is_more.then_some((asked, self.most))
    }

    /// Rotation of a kind of axes in the base frame, where the TCP's are `tool`.
    fn rotation(&self, axes: OffsetAxes, tool: &Rotation3<f64>) -> Rotation3<f64> {
        match axes {
            OffsetAxes::Base => Rotation3::identity(),
            OffsetAxes::Tool => *tool,
            OffsetAxes::Motion => {
                // Universal Robots' rule: with a tool that points down Z is up.
                let x = self.tangent;
                let y = x.cross(&(tool * Vector3::z()));
                // Along the tool's own Z any Y across it does.
                let y = y.try_normalize(1e-6).unwrap_or_else(|| {
                    let across = x.cross(&(tool * Vector3::y())).cross(&x);
                    across.try_normalize(1e-6).unwrap_or_else(Vector3::y)
                });
                let axes = Matrix3::from_columns(&[x, y, x.cross(&y)]);
                Rotation3::from_matrix_unchecked(axes)
            }
        }
    }

    /// The offset in force in a kind of axes: translation and roll, pitch, yaw.
    pub fn in_force(&self, axes: OffsetAxes, tool: &Rotation3<f64>) -> [f64; 6] {
        if !self.is_on {
            return [0.0; 6];
        }
        let now = Vector6::from_fn(|k, _| self.current[k].position);
        let own = rotated(&self.rotation(axes, tool).inverse(), &now);
        let turn = rotation_from_rotvec(own.fixed_rows::<3>(3).into());
        let rpy = rpy_from_rotation(&turn);
        [own[0], own[1], own[2], rpy[0], rpy[1], rpy[2]]
    }

    /// The path leads on with the velocity `velocity` of its TCP, base axes.
    pub fn follow(&mut self, velocity: &Vector3<f64>) {
        if velocity.norm() > MOVING {
            self.tangent = velocity.normalize();
        }
    }

    /// The axes of what is asked for, over a path whose TCP has the axes `tool`, and which of its components are in
    /// use.
    pub fn in_use(&self, tool: &Rotation3<f64>) -> (Rotation3<f64>, [bool; 6]) {
        let axes = self.rotation(self.axes, tool);
        let own = self.seen_from(&axes);
        let is_used = core::array::from_fn(|k| {
            self.requested[k] != 0.0
                || self.filtered[k] != 0.0
                || own[k].position.abs() > NONE
                || own[k].speed.abs() > NONE
        });
        (axes, is_used)
    }

    /// What is in force along and about other axes.
    fn seen_from(&self, axes: &Rotation3<f64>) -> [ScalarState; 6] {
        in_axes(&axes.inverse(), &self.current)
    }

    /// One step further over a path whose TCP has the axes `tool`; held, it comes to rest.
    pub fn advance(
        &mut self,
        tool: &Rotation3<f64>,
        room: &OffsetLimits,
        is_held: bool,
        step: f64,
    ) {
        if !is_held {
            self.filtered += (self.requested - self.filtered) * self.share;
            if (self.requested - self.filtered).amax() < ARRIVAL_TOLERANCE {
                self.filtered = self.requested;
            }
        }
        let axes = self.rotation(self.axes, tool);
        let own = self.seen_from(&axes);
        let able: [AxisLimits; 6] = core::array::from_fn(|k| {
            let (part, now) = (k / 3, &own[k]);
            let acceleration = ACCELERATION[part].min(room.acceleration[part]).max(1e-3);
            let jerk = (ACCELERATION[part] / ACCELERATION_RISE)
                .min(room.jerk[part])
                .max(1e-2);
            AxisLimits {
                min: f64::NEG_INFINITY,
                max: f64::INFINITY,
                // An offset that is faster slows down as it can.
                speed: SPEED[part]
                    .min(room.speed[part])
                    .max(SLOWEST)
                    .max(now.speed.abs() - 0.5 * acceleration * step),
                // Where the motion takes more of the joints it has less, as soon as it can; but one that comes to rest
                // does so.
                acceleration: acceleration.max(if now.acceleration * now.speed < 0.0 {
                    now.acceleration.abs()
                } else {
                    now.acceleration.abs() - 0.99 * jerk * step
                }),
                jerk,
            }
        });
        let next = if is_held || self.is_stopping {
            // A held offset comes to rest wherever it can, and goes on from there.
            let next = core::array::from_fn(|k| able[k].step_towards_speed(&own[k], 0.0, step));
            let at = next.map(|state| state.position);
            self.course.resume_from(&JointPositions(at));
            self.lately = OffsetHistory::only(&at);
            next
        } else {
            let goal = JointPositions(self.filtered.into());
            let (lookahead, gain) = (LOOKAHEAD_RANGE.0, GAIN_RANGE.1);
            self.course
                .set_next_point(&goal, step, lookahead, gain, step);
            self.lately.add(&self.filtered, step);
            let wanted = self.course.next_within(&own, [&able, &able], step, step);
            core::array::from_fn(|k| self.within_range(k, &own[k], &wanted[k], &able[k], step))
        };
        self.current = in_axes(&axes, &next);
    }

    /// `requested`, unless it leads beyond what was asked for lately: from where the component is to the nearest it can
    /// do.
    fn within_range(
        &self,
        k: usize,
        own: &ScalarState,
        wanted: &ScalarState,
        able: &AxisLimits,
        step: f64,
    ) -> ScalarState {
        let (low, high) = self.lately.range(k);
        let within = AxisLimits {
            min: low.min(own.position),
            max: high.max(own.position),
            acceleration: (COMING_TO_REST * able.acceleration).max(own.acceleration.abs()),
            ..*able
        };
        if within.can_brake_within_limits(wanted) {
            return *wanted;
        }
        let nearest = within.nearest_safe(own, wanted.acceleration, step);
        if within.can_brake_within_limits(&nearest) {
            nearest
        } else {
            able.brake_step(own, step)
        }
    }

    /// The joints for the path's setpoint with the offset laid over it; `None` when the arm cannot be there.
    pub fn superimpose(
        &self,
        nominal: &Setpoint,
        before: &Setpoint,
        model: &RobotModel,
        flange_from_tcp: &Pose,
    ) -> Option<Setpoint> {
        let frames = model.forward(&nominal.q);
        let pose = frames.base_from_flange * *flange_from_tcp;
        let speed = frames.twist(&nominal.qd, pose.translation);
        let bias = frames.jacobian_rate_times_speeds(&nominal.qd, pose.translation);
        let driven = frames.twist(&JointSpeeds(nominal.qdd.0), pose.translation);
        let part = |k: usize, pick: fn(&ScalarState) -> f64| {
            Vector3::new(
                pick(&self.current[k]),
                pick(&self.current[k + 1]),
                pick(&self.current[k + 2]),
            )
        };
        let turn = part(3, |x| x.position);
        let rotation = rotation_from_rotvec(turn);
        // Velocity and acceleration of the rotation from those of its vector.
        let left = left_jacobian(&turn);
        let rate = part(3, |x| x.speed);
        let omega = left * rate;
        let ahead = left_jacobian(&(turn + rate * NEARBY));
        let behind = left_jacobian(&(turn - rate * NEARBY));
        let alpha = left * part(3, |x| x.acceleration) + (ahead - behind) * rate / (2.0 * NEARBY);
        let own = rotation * speed.angular;
        let pose = Pose::new(
            rotation * pose.rotation,
            pose.translation + part(0, |x| x.position),
        );
        let speed = Twist {
            linear: speed.linear + part(0, |x| x.speed),
            angular: own + omega,
        };
        let change = Twist {
            linear: driven.linear + bias.linear + part(0, |x| x.acceleration),
            angular: rotation * (driven.angular + bias.angular) + omega.cross(&own) + alpha,
        };
        let q = model.inverse_nearest(&pose, flange_from_tcp, &before.q)?;
        let frames = model.forward(&q);
        let lu = frames.jacobian(pose.translation).lu();
        let qd = JointSpeeds(lu.solve(&speed.to_vector())?.into());
        let bias = frames.jacobian_rate_times_speeds(&qd, pose.translation);
        let driven = change.to_vector() - bias.to_vector();
        let qdd = JointAccelerations(lu.solve(&driven)?.into());
        Some(Setpoint { q, qd, qdd })
    }
}

/// Lengths of translation and rotation.
fn sizes(offset: &Vector6<f64>) -> [f64; 2] {
    [
        offset.fixed_rows::<3>(0).norm(),
        offset.fixed_rows::<3>(3).norm(),
    ]
}

/// Both halves turned.
fn rotated(by: &Rotation3<f64>, offset: &Vector6<f64>) -> Vector6<f64> {
    let half = |row: usize| by * Vector3::from(offset.fixed_rows::<3>(row));
    let (at, turn) = (half(0), half(3));
    Vector6::new(at.x, at.y, at.z, turn.x, turn.y, turn.z)
}

/// The states of both halves turned.
fn in_axes(by: &Rotation3<f64>, states: &[ScalarState; 6]) -> [ScalarState; 6] {
    let part =
        |pick: fn(&ScalarState) -> f64| rotated(by, &Vector6::from(states.map(|x| pick(&x))));
    let [position, speed, acceleration] = [
        part(|x| x.position),
        part(|x| x.speed),
        part(|x| x.acceleration),
    ];
    core::array::from_fn(|k| ScalarState {
        position: position[k],
        speed: speed[k],
        acceleration: acceleration[k],
    })
}

/// What makes the angular velocity of exp(v) out of the rate of v (Murray, Li and Sastry 1994, 2.2).
fn left_jacobian(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    let cross = v.cross_matrix();
    let (first, second) = if angle < 1e-3 {
        (0.5, 1.0 / 6.0)
    } else {
        let square = angle * angle;
        (
            (1.0 - cos(angle)) / square,
            (angle - sin(angle)) / (square * angle),
        )
    };
    Matrix3::identity() + cross * first + cross * cross * second
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_axes_have_x_along_the_path_and_y_across_it_and_the_tools_z() {
        let mut offset = PathOffset::new(0.004);
        let tool = rotation_from_rotvec(Vector3::new(3.0, 0.2, 0.1));
        for tangent in [
            Vector3::x(),
            Vector3::new(0.3, -0.8, 0.1),
            tool * Vector3::z(),
        ] {
            offset.tangent = tangent.normalize();
            let axes = offset.rotation(OffsetAxes::Motion, &tool);
            assert!((axes.matrix().determinant() - 1.0).abs() < 1e-9);
            assert!((axes * Vector3::x() - offset.tangent).norm() < 1e-12);
            let across = offset.tangent.cross(&(tool * Vector3::z()));
            let y = axes * Vector3::y();
            assert!(y.dot(&offset.tangent).abs() < 1e-9);
            assert!(y.dot(&across) >= across.norm() - 1e-9, "{y}");
        }
    }

    #[test]
    fn the_left_jacobian_gives_the_angular_velocity() {
        let (v, rate, h) = (
            Vector3::new(0.3, -0.2, 0.4),
            Vector3::new(1.0, 0.5, -2.0),
            1e-6,
        );
        let (before, after) = (
            rotation_from_rotvec(v - rate * h),
            rotation_from_rotvec(v + rate * h),
        );
        let omega = rotvec_from_rotation(&(after * before.inverse())) / (2.0 * h);
        assert!((omega - left_jacobian(&v) * rate).norm() < 1e-6);
    }
}
