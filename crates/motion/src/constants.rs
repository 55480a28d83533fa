//! Numbers of the control cycle, each with its reason; relations between them are checked at compile time.

/// Shortest and longest control cycle, s (INTERFACES: `--step-ms` 1 to 8).
pub const STEP_RANGE: (f64, f64) = (0.001, 0.008);

/// Default jerk: the acceleration of a motion is reached in this time, s. 20 to 40 ms are wanted; the middle leaves
/// room on both sides when it is seen in whole cycles.
pub const ACCELERATION_RISE: f64 = 0.030;

/// Hard jerk limit of a joint unless the configuration names one: its largest acceleration in this time, s.
pub const FASTEST_RISE: f64 = 0.020;

/// Most commands taken from the ring in one cycle; the rest wait for the next.
pub const COMMANDS_PER_CYCLE: usize = 64;

/// Commands that may wait at the same time for the arm to stand. When as many wait, no further command is taken.
pub const WAITING_COMMANDS: usize = 16;

/// Most events that one command causes at once: its end, the end of the motion it stops, warnings, a stop.
pub const EVENTS_PER_COMMAND: usize = 8;

/// Room in the event ring that is kept for events no command causes in its own cycle.
pub const EVENT_RESERVE: usize = 2;

/// Smallest event ring with which every event always finds room.
pub const EVENT_RING_MIN: usize = EVENTS_PER_COMMAND + WAITING_COMMANDS + 1 + EVENT_RESERVE;

/// Length of one step of the servo and of the rigid bodies, s; a cycle has a whole number of them.
pub const SERVO_STEP: f64 = 0.001;

/// Bandwidth of the servo, rad/s: the frequency of the critically damped error.
pub const SERVO_BANDWIDTH: f64 = 100.0;

/// Torque that a joint can give for a moment over the nominal effort of the model, which several arms nearly need to
/// hold their rated payload at full stretch. Our choice; the vendor publishes no peak torque.
pub const PEAK_TORQUE_FACTOR: f64 = 2.0;

/// Difference of actual and target position at which the arm counts as not following, rad. Free motion stays below
/// 1 mrad; a joint pressing against something reaches this within a few cycles.
pub const TRACKING_LIMIT: f64 = 0.05;

/// Joint positions and speeds may exceed their limits by this (rad, rad/s) through rounding.
pub const LIMIT_SLACK: f64 = 1e-6;

/// A change of position below this (rad, m) is no motion.
pub const NO_MOTION: f64 = 1e-12;

/// Places along a joint-space line at which the speeds of TCP and elbow are looked at when they are limited, and the part
/// of the limits that is used, because between two places a point can be a little faster than at either.
pub const POINT_SPEED_SAMPLES: usize = 64;
/// See [`POINT_SPEED_SAMPLES`].
pub const POINT_SPEED_MARGIN: f64 = 0.98;

/// Numbers of places in `StopReason::Internal`.
pub mod fault {
    /// The inverse kinematics found nothing on a path that was checked before.
    pub const PATH_LOST: u32 = 1;
    /// A setpoint was not a finite number.
    pub const NOT_FINITE: u32 = 2;
    /// The plant's state was not a finite number.
    pub const PLANT_DIVERGED: u32 = 3;
}

const _: () = assert!(STEP_RANGE.0 < STEP_RANGE.1);
const _: () = assert!(FASTEST_RISE <= ACCELERATION_RISE);
const _: () = assert!(ACCELERATION_RISE > 0.02 && ACCELERATION_RISE < 0.04);
// The servo must be slow enough for its own step.
const _: () = assert!(SERVO_STEP * SERVO_BANDWIDTH <= 0.2);
const _: () = assert!(SERVO_STEP <= STEP_RANGE.0);
// A command's own end must fit beside everything it may cause.
const _: () = assert!(EVENTS_PER_COMMAND > EVENT_RESERVE);
