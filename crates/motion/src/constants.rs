//! Numbers of the control cycle, each with its reason; relations between them are checked at compile time.

/// Shortest and longest control cycle, s (INTERFACES: `--step-ms` 1 to 8).
pub const STEP_RANGE: (f64, f64) = (0.001, 0.008);

/// Default jerk: the acceleration of a motion is reached in this time, s. 20 to 40 ms are wanted; the middle leaves
/// room on both sides when it is seen in whole cycles.
pub const ACCELERATION_RISE: f64 = 0.030;

/// Hard jerk limit of a joint unless the configuration names one: its largest acceleration in this time, s.
pub const FASTEST_RISE: f64 = 0.020;

/// Most commands taken from the ring in one cycle; the rest wait for the next. A program may set hundreds of things in
/// one cycle, so what only sets something counts once.
pub const COMMANDS_PER_CYCLE: usize = 512;
/// For how many of those a command counts that plans or begins a motion.
pub const MOTION_COMMAND_WEIGHT: usize = 8;
/// Records that one cycle may put out: its commands, the registers and the cycle itself.
pub const RECORDS_PER_CYCLE: usize = COMMANDS_PER_CYCLE + 2;

/// Commands that may wait at the same time for the arm to stand. When as many wait, no further command is taken.
pub const WAITING_COMMANDS: usize = 16;

/// Changes of inputs and outputs that may wait at the same time for motions to enter their blend zones.
pub const ZONE_CHANGES: usize = 64;

/// Most events that one command causes at once: its end, the end of the motion it stops, warnings, a stop.
pub const EVENTS_PER_COMMAND: usize = 8;

/// Room in the event ring that is kept for events no command causes in its own cycle.
pub const EVENT_RESERVE: usize = 4;

/// Smallest event ring with which every event always finds room.
pub const EVENT_RING_MIN: usize =
    EVENTS_PER_COMMAND + WAITING_COMMANDS + ZONE_CHANGES + 1 + EVENT_RESERVE;

/// Length of one step of the servo and of the rigid bodies, s; a cycle has a whole number of them.
pub const SERVO_STEP: f64 = 0.001;

/// Bandwidth of the servo, rad/s: the frequency of the critically damped error.
pub const SERVO_BANDWIDTH: f64 = 250.0;

/// Torque that a joint can give for a moment over the nominal effort of the model, which several arms nearly need to
/// hold their rated payload at full stretch. Our choice; the vendor publishes no peak torque.
pub const PEAK_TORQUE_FACTOR: f64 = 2.0;

/// Share of the peak torque that motions are planned with; the rest is for the servo.
pub const PLANNED_TORQUE_SHARE: f64 = 0.8;

/// Share of a joint's nominal torque that is there for motion even where gravity alone takes more than is planned with:
/// an overloaded arm moves slowly instead of not at all.
pub const LEAST_TORQUE_SHARE: f64 = 0.05;

/// After a protective stop has braked the target, the arm gets this long to come to rest before the brakes hold it, s.
pub const SETTLING_TIME: f64 = 0.5;
/// An arm counts as resting when every joint is slower than this, rad/s.
pub const RESTING_SPEED: f64 = 1e-3;

/// From power off to idle, s. Long enough for a client that asks every 100 ms to see the modes in between; the vendor's
/// own times are longer.
pub const POWER_ON_TIME: f64 = 0.4;
/// From idle to released brakes, s.
pub const BRAKE_RELEASE_TIME: f64 = 0.3;

/// Share of what pushes the arm on besides the drives that the servo holds against. The rest pushes the arm off its
/// target: it stands against obstacles and hands twenty times stiffer than the servo alone, some 400 N/mm at the tool
/// of a CS66, and what is hard does not drive the force up without end. Our choice.
pub const DISTURBANCE_COMPENSATION: f64 = 0.95;
/// Time constant of that compensation, s. What is fed forward lags behind what pushes, so the arm stays passive against
/// any stiffness.
pub const DISTURBANCE_TIME_CONSTANT: f64 = 0.002;
/// Accelerations that differ less from what was asked for are as asked: rounding, rad/s².
pub const DISTURBANCE_DEAD_BAND: f64 = 1e-6;

/// Difference of actual and target position at which the arm counts as not following, rad. Free motion stays below
/// 1 mrad; a joint pressing against something reaches this within a few cycles.
pub const TRACKING_LIMIT: f64 = 0.05;

/// The capsules of two links may overlap by this before it counts as a collision, m: they are rounder than the arm.
pub const LINK_OVERLAP: f64 = 0.015;
/// Places along a joint-space line at which the distance of links is looked at, at most, where they come near.
pub const LINK_PLACES: u32 = 256;

/// Joint positions and speeds may exceed their limits by this (rad, rad/s) through rounding.
pub const LIMIT_SLACK: f64 = 1e-6;

/// Smallest limits that a configuration may ask for: far below what moves anything, far above where arithmetic ends.
pub const MIN_LIMITS: MinLimits = MinLimits {
    joint_speed: 1e-4,
    joint_acceleration: 1e-3,
    joint_jerk: 1e-2,
    point_speed: 1e-4,
    tcp_force: 0.1,
};

/// The smallest limits that a cell may set ([`MIN_LIMITS`]).
#[derive(Clone, Copy, Debug)]
pub struct MinLimits {
    /// rad/s.
    pub joint_speed: f64,
    /// rad/s².
    pub joint_acceleration: f64,
    /// rad/s³.
    pub joint_jerk: f64,
    /// Speed of TCP and elbow, m/s.
    pub point_speed: f64,
    /// N.
    pub tcp_force: f64,
}

/// Slowest motion that is planned: speeds and accelerations below (in units of s) are refused. Far outside of use;
/// keeps the arithmetic away from the ends of the number range.
pub const MIN_REQUESTED_RATE: f64 = 1e-6;
/// Longest duration of a motion, s: far outside of use, for the sake of the arithmetic.
pub const MAX_DURATION: f64 = 1e6;

/// Speed fractions below hold the motion, as 0 does.
pub const SLOWEST_FRACTION: f64 = 1e-3;

/// A change of position below this (rad, m) is no motion.
pub const MIN_DISTANCE: f64 = 1e-12;

/// Where the rotation is the larger part of a Cartesian line, a radian counts as this much way, m/rad: a rotation on
/// the spot at the default 0.25 m/s turns at 1 rad/s, about the default speed of a movej. Our choice; the manual is
/// silent.
pub const ROTATION_LENGTH: f64 = 0.25;

/// A Cartesian line is looked at in intervals of this length, m, between 4 and [`LINE_INTERVALS`], each halved up to
/// [`MAX_BISECTIONS`] times where the joints turn fast, with at most [`MAX_PATH_SAMPLES`] places in all and
/// [`PATH_SAMPLES_PER_CYCLE`] in one cycle.
pub const INTERVAL_LENGTH: f64 = 0.002;
/// Most intervals of a Cartesian line before any is halved; at least 4 there are.
pub const LINE_INTERVALS: usize = 64;
/// How often one interval of a path may be halved.
pub const MAX_BISECTIONS: usize = 10;
/// Most places at which one Cartesian line is looked at.
pub const MAX_PATH_SAMPLES: u32 = 2100;
/// Most places at which a way through many points is looked at, for each of its intervals.
pub const SAMPLES_PER_INTERVAL: u32 = 4;
/// Most places of a path that are looked at in one cycle: twice those of a line without refinements.
pub const PATH_SAMPLES_PER_CYCLE: usize = 128;

/// Between two places that are looked at the bend of a joint's way changes by no more than this share of it, as far as
/// an interval may be halved for that; a bend counts where it takes more than a share of the acceleration at the wanted
/// speed.
pub const CURVATURE_REFINEMENT: CurvatureRefinement = CurvatureRefinement {
    change: 0.05,
    halvings: 4,
    last: FinalBisection {
        length: 0.4e-3,
        change: 0.1,
    },
    least: 0.9,
};

/// When a survey halves an interval because a joint's way bends ([`CURVATURE_REFINEMENT`]).
#[derive(Clone, Copy, Debug)]
pub struct CurvatureRefinement {
    /// Share by which the bend may change from one place to the next.
    pub change: f64,
    /// How often an interval may be halved for that.
    pub halvings: usize,
    /// When an interval is halved for the last time.
    pub last: FinalBisection,
    /// A bend counts where it takes more than this share of the acceleration at the wanted speed.
    pub least: f64,
}

/// When an interval that was halved for a bend is halved for the last time ([`CURVATURE_REFINEMENT`]).
#[derive(Clone, Copy, Debug)]
pub struct FinalBisection {
    /// The interval is longer than this, m.
    pub length: f64,
    /// The bend changes over the interval by more than this share of itself.
    pub change: f64,
}

/// Cells of a joint-space line.
pub const JOINT_LINE_INTERVALS: usize = 48;
/// Most cells of one leg.
pub const MAX_INTERVALS_PER_SEGMENT: usize = MAX_PATH_SAMPLES as usize;
/// Most cells of the way of a whole queue.
pub const MAX_QUEUED_INTERVALS: usize = 6000;
/// Cells of a leg that are divided about its blend zone, at most.
pub const CELLS_ABOUT_ZONE: usize = 64;
/// A motion with a duration begins so much later than the one before was to end, at most, to make that good, s.
pub const MADE_GOOD: f64 = 0.012;
/// Most legs of a queue.
pub const MAX_QUEUED_SEGMENTS: usize = 64;
/// A sender is told that the next motion may follow so long before the arm would have to slow down without it, s.
pub const READY_FOR_NEXT_LEAD: f64 = 0.15;

/// From when its sender hears that a motion is due until it is planned, s: three cycles of the usual length.
pub const LATE_TIME: f64 = 0.012;
/// A zone that is short for the speed leaves this much more time to brake for a sharp corner, s.
pub const LEAD_TIME: f64 = 0.016;
/// A motion is due at the latest so that its curve can begin when this share of the zone is passed; and the arm goes
/// through no more of it in the time that a command takes that is sent when the zone is entered.
pub const DUE_SHARE: f64 = 0.3;

/// A zone in which the arm cannot both enter at full speed and be slow enough for any corner: at this share of the zone
/// it has to be slow enough, so that the path is left before the rest of the zone is too short for a curve. The later
/// this is, the nearer to the zone act the statements that wait for it, and the more sharp corners end in a stop at the
/// waypoint (of 806 random corners 9 at a share of 0, 15 at 0.6, 28 at 0.75).
pub const SLOW_SHARE: f64 = 0.6;

/// Where an arm that enters a zone at full speed is slow again while it is not known what follows: behind this share of
/// the zone, and to this share of the speed with which any corner can be taken on a curve through the whole zone.
pub const LATE_CURVE: (f64, f64) = (0.75, 0.5);

/// Timed motions of a chain speed up and slow down in this part of their time, about.
pub const RAMPS: f64 = 8.0;
/// A chain that is behind its times makes that good at no more than this times the speed that they ask for.
pub const CATCH_UP: f64 = 1.25;
/// A chain that is ahead of its times is no slower than this times the speed that they ask for.
pub const EASE: f64 = 0.95;
/// Lest one that is followed by nothing ends too late, it is this much faster at most.
pub const EARLY: f64 = 1.1;

/// Shortest and longest time over which a motion is smoothed, s.
pub const WINDOW_RANGE: (f64, f64) = (0.004, 0.5);

/// Shares of the joints' limits that the bends of a path may take up, so that changes of speed have the rest.
pub const CURVATURE_SHARES: CurvatureShares = CurvatureShares {
    acceleration: 0.99,
    jerk: 0.45,
    jerk_of_acceleration: 0.3,
};

/// The shares of a joint's acceleration and jerk that a bend may take ([`CURVATURE_SHARES`]).
#[derive(Clone, Copy, Debug)]
pub struct CurvatureShares {
    /// Share of the acceleration, for |q''| V².
    pub acceleration: f64,
    /// Share of the jerk, for |q'''| V³.
    pub jerk: f64,
    /// Share of the jerk, for 3 |q''| V A.
    pub jerk_of_acceleration: f64,
}

/// Share of what the joints can do that the hardest stop on a path uses.
pub const HARD_STOP_SHARE: f64 = 0.9;
/// Share of what the joints can do that a pause and the slider slow down with at least.
pub const PAUSE_SHARE: f64 = 0.1;

/// Share of the joints' accelerations with which a pause and the speed slider brake streams and hands, which have no
/// acceleration of their own.
pub const PAUSE_OF_STREAMS: f64 = 0.3;
/// A stop keeps the path where that takes no longer than this times what the joints take one by one, and this, s: the
/// motion on a path is smoothed, and may still be speeding up.
pub const STOP_ON_PATH: StopOnPath = StopOnPath {
    times: 1.1,
    longer: 0.03,
};

/// How much longer than its joints' shortest time a stop on the path may take ([`STOP_ON_PATH`]).
#[derive(Clone, Copy, Debug)]
pub struct StopOnPath {
    /// Factor on the joints' shortest time to rest.
    pub times: f64,
    /// s.
    pub longer: f64,
}

/// In a blend between two legs of joints no joint accelerates more than this times the larger acceleration of the two.
pub const BLEND_ACCELERATION_FACTOR: f64 = 2.0;

/// How often the pace of a timed leg is tried.
pub const DURATION_SEARCH_STEPS: usize = 12;
/// How much a timed motion may begin or end beside its time: s, or share of the time.
pub const START_OF_MOTION: f64 = 1e-6;

/// Intervals between the points of a moveml that are looked at in one cycle.
pub const MICRO_INTERVALS_PER_CYCLE: usize = 64;
/// Places at which each interval of a moveml is looked at, its first not counted.
pub const MICRO_PLACES_PER_INTERVAL: usize = 2;

/// How far the first point of a trajectory may be from the arm, rad.
pub const TRAJECTORY_START: f64 = 0.1;

/// How far from the first point of a moveml the arm may stand, rad; the difference is taken up on the first interval.
pub const MICRO_START: f64 = 1e-4;

/// Three points make no arc when the sine of their angle is below this: the radius would be a million times their
/// distance.
pub const STRAIGHT_ARC: f64 = 1e-6;

/// Share of the speed at which a curve through the whole zone could turn straight back: a motion whose successor is not
/// known yet is no faster some way in the zone, so that the sharpest turn finds it slow enough. The curve begins a
/// cycle or two into the zone and is then a little shorter.
pub const ZONE_TURNING_SHARE: f64 = 0.57;

/// Places at which the beginning of a blend zone is searched before it is narrowed down.
pub const ZONE_PLACES: usize = 16;

/// Cells of a blend; three equal counts for the parts of a curve between two lines.
pub const BLEND_CELLS: usize = 24;

/// Share of the faster neighbour's TCP speed on a curve in joint space, which is looked at in places only.
pub const BLEND_TCP_SHARE: f64 = 0.998;

/// A process move's curve reaches so many times as far from the corner as where its arc touches.
pub const PROCESS_ZONE: f64 = 1.5;

/// Where a blend begins: at these shares of the zone before the waypoint, tried one after the other until one can be
/// done at the speed that the arm has. The path is left at 0.6 of the radius at the latest wherever that is possible.
pub const BLEND_ENTRY_SHARES: [f64; 7] = [1.0, 0.86, 0.74, 0.63, 0.5, 0.37, 0.25];
/// Blend entries that are tried in one cycle.
pub const BLEND_ENTRIES_PER_CYCLE: usize = 2;
/// A blend begins at most this share of the way that is left before the waypoint, so that it lies ahead of the arm.
pub const MAX_ENTRY_SHARE: f64 = 0.97;
/// A blend entry that would have to move nearer to the waypoint than this share of its distance is not tried.
pub const MIN_ENTRY_SHARE: f64 = 0.75;

/// A joint that would turn by more than this on a metre of the line counts as singular, rad/m: at the joint's full
/// speed the TCP would crawl at 3 mm/s.
pub const SINGULAR_TURN_PER_M: f64 = 1000.0;

/// Places along a joint-space line at which the speeds of TCP and elbow are looked at when they are limited.
pub const POINT_SPEED_SAMPLES: usize = 64;
/// Share of the speed limits of TCP and elbow that is used, because a point can be faster between two places than at
/// either.
pub const POINT_SPEED_MARGIN: f64 = 0.98;

/// Places along a joint-space line at which the torques are looked at.
pub const TORQUE_SAMPLES: usize = 32;

/// Part of the torque left by gravity that speed alone may take up, so that acceleration has the rest.
pub const TORQUE_SHARE_OF_SPEED: f64 = 0.5;

/// A servo stream counts as settled when position, speed and acceleration are within this of rest, rad a step.
pub const SERVO_SETTLED: f64 = 1e-10;

/// Speed of the TCP in reduced mode unless the cell says otherwise, m/s (EN ISO 10218-1, 5.6.2).
pub const REDUCED_TCP_SPEED: f64 = 0.25;

/// Acceleration with which online modes come to rest when they are stopped, rad/s² of the leading joint or m/s².
pub const STOP_ACCELERATION: f64 = 5.0;

/// Share of joint speeds, accelerations and jerks that planned motions may use while a conveyor is tracked.
pub const SHARE_ON_BELT: f64 = 0.6;
/// Share of the joint accelerations that changes of the belt's own motion may use.
pub const SHARE_OF_BELT: f64 = 0.3;

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
const _: () = assert!(SERVO_STEP * SERVO_BANDWIDTH <= 0.25);
const _: () = assert!(SERVO_STEP <= STEP_RANGE.0);
const _: () = assert!(BLEND_CELLS.is_multiple_of(3));
const _: () = assert!(PATH_SAMPLES_PER_CYCLE >= 2 * LINE_INTERVALS);
const _: () = assert!(MAX_QUEUED_INTERVALS >= 2 * MAX_INTERVALS_PER_SEGMENT);
const _: () = assert!(CURVATURE_REFINEMENT.halvings <= MAX_BISECTIONS);
const _: () =
    assert!(LINE_INTERVALS << (CURVATURE_REFINEMENT.halvings + 1) <= MAX_PATH_SAMPLES as usize);
const _: () = assert!(SHARE_ON_BELT + SHARE_OF_BELT < 1.0);
// A command's own end must fit beside everything it may cause.
const _: () = assert!(EVENTS_PER_COMMAND > EVENT_RESERVE);
