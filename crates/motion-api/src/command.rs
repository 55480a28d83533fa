//! What scripts and ports ask of the motion thread.
//!
//! A command is checked for form (numbers finite, ranges of the manual) before it enters the ring; whether the arm can
//! do it is decided on the other side and comes back as an [`Outcome`](crate::Outcome).

use kinematics::{JointPositions, JointSpeeds, Payload, RpyPose};

use crate::online::{EncoderRange, FreedriveFrame, OffsetAxes, PulseDecoding};

use crate::IoChange;

/// Number of a command, in the order in which commands entered the ring, from 1. 0 means "none".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CommandId(pub u64);

impl CommandId {
    /// No command.
    pub const NONE: Self = Self(0);
}

/// Number of a program, in the order in which programs were started, from 1. 0 means "no program" (a port).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ProgramId(pub u32);

/// Number of a script thread inside its task; the main thread is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ThreadNumber(pub u32);

/// The statement from which a command came: program, thread and line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// The program, 0 when a port and not a program asked.
    pub program: ProgramId,
    /// The script thread that called.
    pub thread: ThreadNumber,
    /// Line of the call, from 1; 0 when there is none.
    pub line: u32,
}

/// A numbered request with its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Number in the ring's order.
    pub id: CommandId,
    /// The statement that the command came from.
    pub origin: Origin,
    /// What is asked.
    pub kind: CommandKind,
}

/// The requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommandKind {
    /// A straight line in joint space (manual 3.1.1). All joints start and end together.
    MoveJ {
        /// Where to, rad.
        target: JointPositions,
        /// Acceleration of the leading joint, rad/s².
        acceleration: f64,
        /// Speed of the leading joint, rad/s.
        speed: f64,
        /// Duration in seconds; 0 plans from speed and acceleration instead.
        duration: f64,
        /// Blend radius, m: the command ends when the TCP comes this near to the target, and the next motion may follow
        /// without a stop. 0 stops at the target.
        radius: f64,
    },
    /// A straight line of the TCP with rotation about one fixed axis (manual 3.1.3).
    MoveL {
        /// Where to: TCP pose in the base frame.
        target: RpyPose,
        /// TCP acceleration, m/s².
        acceleration: f64,
        /// TCP speed, m/s.
        speed: f64,
        /// Duration in seconds; 0 plans from speed and acceleration instead.
        duration: f64,
        /// Blend radius, m: the command ends when the TCP comes this near to the target, and the next motion may follow
        /// without a stop. 0 stops at the target.
        radius: f64,
    },
    /// A circular arc of the TCP (manual 3.1.2).
    MoveC {
        /// A pose whose position lies on the arc; its orientation is not used.
        via: RpyPose,
        /// Where to: TCP pose in the base frame.
        target: RpyPose,
        /// TCP acceleration, m/s².
        acceleration: f64,
        /// TCP speed, m/s.
        speed: f64,
        /// Blend radius, m, as of `MoveL`.
        radius: f64,
        /// The tool keeps its angle to the arc, and the target's orientation is not used; otherwise it turns to the
        /// target's about one axis.
        fixed: bool,
    },
    /// A line of the TCP as of `MoveL` whose blends are arcs that touch both lines and are driven at the speed of the
    /// lines (from controller output, not from the manual).
    MoveP {
        /// Where to: TCP pose in the base frame.
        target: RpyPose,
        /// TCP acceleration, m/s².
        acceleration: f64,
        /// TCP speed, m/s.
        speed: f64,
        /// Distance from the target at which the arc touches, m; 0 stops at the target.
        radius: f64,
    },
    /// Through the points that were handed over with it, at even times, from the first on, where the arm stands (manual
    /// 3.1.40): see [`CommandSender::send_points`](crate::CommandSender::send_points).
    MoveMl {
        /// The number of points.
        count: u32,
        /// Time from point to point, s.
        interval: f64,
    },
    /// Decelerates on the path and ends the running motion as aborted. A robot at rest stays at rest.
    Stop {
        /// Only if this command is the one running; [`CommandId::NONE`] stops whatever runs.
        only: CommandId,
    },
    /// Decelerates on the path and holds there until `Resume`.
    Pause,
    /// Goes on after `Pause`.
    Resume,
    /// TCP relative to the flange (manual 3.1.20).
    SetTcp(RpyPose),
    /// What hangs on the flange (manual 3.1.17).
    SetPayload(Payload),
    /// One standard digital output (manual 5.13).
    SetStandardDigitalOut {
        /// 0 to 15.
        index: u8,
        /// High or low.
        level: bool,
    },
    /// Any other input or output, or how it is configured (manual chapter 5).
    SetIo(IoChange),
    /// An input or output that changes when a planned motion ends: where the arm enters its blend zone, or stops. At
    /// once where that motion has ended already; never where it is stopped before.
    SetIoAtZone {
        /// The motion.
        motion: CommandId,
        /// The change.
        change: IoChange,
    },
    /// The speed slider, 0 to 1.
    SetSpeedFraction(f64),
    /// Arm power on: power off → idle.
    PowerOn,
    /// Arm power off; the arm decelerates first.
    PowerOff,
    /// Brakes released: idle → running.
    ReleaseBrakes,
    /// Leaves a protective stop.
    UnlockProtectiveStop,
    /// A protective stop without a reason of the arm's own: somebody wants to see what follows from one.
    ProtectiveStop,
    /// Clears a safety fault.
    RestartSafetyBoard,
    /// The emergency stop button of the pendant: the arm brakes and loses its power.
    EmergencyStop {
        /// Pressed, or released again.
        pressed: bool,
    },

    // Online modes and what belongs to them.
    /// One point of a stream of joint positions (manual 3.1.6). The call ends after `duration`.
    ServoJ {
        /// Where to, rad.
        target: JointPositions,
        /// How long this point leads the arm, s.
        duration: f64,
        /// Length of the mean filter, s.
        lookahead: f64,
        /// Tracking gain, 100 to 2000.
        gain: f64,
    },
    /// Joint positions that were handed over with it, at even times, from where the arm is, at rest or not; the list
    /// under way is left for it. The call ends where the list does: see
    /// [`CommandSender::send_trajectory`](crate::CommandSender::send_trajectory).
    FollowPoints {
        /// The number of points.
        count: u32,
        /// Time from point to point, s.
        interval: f64,
    },
    /// Joint speeds, held until the next motion command (manual 3.1.25).
    SpeedJ {
        /// rad/s.
        speeds: JointSpeeds,
        /// Acceleration of the joint that changes most, rad/s².
        acceleration: f64,
        /// When the call ends, s; `None` when the speeds are reached.
        duration: Option<f64>,
    },
    /// A TCP velocity, held until the next motion command (manual 3.1.27).
    SpeedL {
        /// Linear m/s, then angular rad/s, base frame.
        speed: [f64; 6],
        /// m/s².
        acceleration: f64,
        /// rad/s².
        rotation_acceleration: f64,
        /// When the call ends, s; `None` when the velocity is reached.
        duration: Option<f64>,
    },
    /// All joints to rest (manual 3.1.26); a planned motion brakes on its path.
    StopJ {
        /// rad/s².
        acceleration: f64,
    },
    /// The TCP to rest on its line (manual 3.1.28); a planned motion brakes on its path.
    StopL {
        /// m/s².
        acceleration: f64,
    },
    /// Free-fall acceleration in the base frame, m/s² (manual 3.1.16 has the other sign).
    SetGravity([f64; 3]),
    /// The arm follows the hand (manual 3.1.41). Ends with [`EndFreedrive`](Self::EndFreedrive) or a stop.
    Freedrive {
        /// The axes x, y, z, rx, ry, rz in which the arm may move.
        free_axes: [bool; 6],
        /// The frame whose axes are meant.
        frame: FreedriveFrame,
    },
    /// Back to position control (manual 3.1.42); nothing to do when freedrive is off.
    EndFreedrive,
    /// Force control along the selected axes from now on, over whatever moves the arm (manual 4.1). While it is on, the
    /// same command gives it new axes and a new target.
    ForceMode {
        /// The reference frame in the base.
        frame: RpyPose,
        /// The axes of the force frame that are force controlled: x, y, z, rx, ry, rz.
        selection: [bool; 6],
        /// What the tool is to apply to the environment along the selected axes: N and Nm.
        wrench: [f64; 6],
        /// How the force frame follows from the reference frame: 0 fixed, 1 point, 2 motion, 3 TCP.
        mode: u8,
        /// Largest TCP speeds along the selected axes, m/s and rad/s.
        speed_limits: [f64; 6],
    },
    /// Back to position control (manual 4.7); nothing to do when force mode is off.
    EndForceMode,
    /// Gain of force mode, 0 to 2; kept until the controller ends (manual 4.2).
    SetForceGain(f64),
    /// Damping of force mode, 0 to 1; kept until the controller ends (manual 4.3).
    SetForceDamping(f64),
    /// A wrench that acts on the tool from outside until the next one: N and Nm, base axes, about the TCP. Counts while
    /// [`FtRtsiInput`](Self::FtRtsiInput) is on.
    SetExternalWrench([f64; 6]),
    /// A load on the tool from now on, like one of `[[wrench]]` of the cell: felt by the arm, not only by its sensor.
    /// Loads add up.
    Push {
        /// N and Nm, about the TCP.
        wrench: [f64; 6],
        /// True when the wrench has the TCP's axes, otherwise it has the base's.
        in_tool_axes: bool,
        /// How long the load acts, s.
        duration: f64,
        /// Earlier loads end when this one begins.
        replaces: bool,
    },
    /// Whether wrenches from a port count (`ft_rtsi_input_enable`), and the sensor that they come from.
    FtRtsiInput {
        /// True when wrenches from a port count.
        enabled: bool,
        /// Mass of that sensor, kg; its weight is in the readings.
        mass: f64,
        /// The point about which the sensor measures moments, flange frame, m; zero means the TCP.
        measuring_offset: [f64; 3],
        /// Centre of gravity of the sensor, flange frame, m.
        cog: [f64; 3],
    },
    /// What the force sensor reads now counts as nothing (manual 4.4).
    ZeroFtSensor,
    /// Collision detection on or off (manual 3.1.43).
    SetCollisionDetection(bool),
    /// Sensitivity of collision detection, 10 to 100 % (manual 3.1.46).
    SetCollisionSensitivity(u8),
    /// Motion goes along with a belt from now on (manual 3.1.30).
    TrackConveyorLinear {
        /// Where the belt runs to, base frame; its length does not count.
        direction: [f64; 3],
        /// Encoder ticks a metre.
        ticks_per_meter: f64,
        /// 0 or 1.
        encoder: u8,
    },
    /// Motion goes along with a turntable from now on (manual 3.1.29).
    TrackConveyorCircular {
        /// Centre of the table in the base frame; it turns about its z axis.
        center: RpyPose,
        /// Encoder ticks a turn.
        ticks_per_revolution: f64,
        /// The tool turns with the table.
        rotate_tool: bool,
        /// 0 or 1.
        encoder: u8,
    },
    /// Ends tracking and brings the tool to rest (manual 3.1.31).
    StopConveyorTracking,
    /// The count of an encoder comes from the program from now on (manual 3.1.21).
    EncoderEnableSetTickCount {
        /// 0 or 1.
        encoder: u8,
        /// Range of the counter.
        range: EncoderRange,
    },
    /// The count of an encoder (manual 3.1.23).
    EncoderSetTickCount {
        /// 0 or 1.
        encoder: u8,
        /// Ticks, inside the range of the encoder.
        count: f64,
    },
    /// The count of an encoder comes from pulses from now on (manual 3.1.32).
    EncoderEnablePulseDecode {
        /// 0 or 1.
        encoder: u8,
        /// The edges that count.
        decoding: PulseDecoding,
        /// Input of channel A: 16 or 17.
        channel_a: u8,
        /// Input of channel B, 16 or 17; 0 unless quadrature.
        channel_b: u8,
    },
    /// Offsets of the path count from now on (from controller output, not from the manual, as the next four).
    PathOffsetEnable,
    /// Offsets count no more; the joints brake with `acceleration` wherever that leads, and the next motion begins
    /// there.
    PathOffsetDisable {
        /// rad/s².
        acceleration: f64,
    },
    /// The offset laid over the TCP's path from now on.
    PathOffsetSet {
        /// Translation and rotation.
        offset: RpyPose,
        /// Along and about which axes.
        axes: OffsetAxes,
    },
    /// Share of a new offset that is taken over in each cycle, 0 to 1.
    PathOffsetFilter(f64),
    /// Largest offsets; beyond them is a protective stop.
    PathOffsetMax {
        /// m.
        translation: f64,
        /// rad.
        rotation: f64,
    },
    /// A simulated digital input, bit of `RobotState::digital_in`.
    SetDigitalInput {
        /// 0 to 27.
        index: u8,
        /// High or low.
        level: bool,
    },
}

impl CommandKind {
    /// True for what stops the arm or lets it go on, and for what tells that a program runs no more. Places in the ring
    /// are kept for these, so that no flood of other commands can keep them out.
    pub const fn uses_reserved_slot(&self) -> bool {
        matches!(
            self,
            Self::Stop { .. }
                | Self::Pause
                | Self::Resume
                | Self::PowerOff
                | Self::EmergencyStop { .. }
                | Self::StopJ { .. }
                | Self::StopL { .. }
                | Self::EndFreedrive
                | Self::EndForceMode
                | Self::StopConveyorTracking
                | Self::PathOffsetDisable { .. }
                | Self::SetIo(IoChange::ProgramRunning(_))
        )
    }

    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::MoveJ { .. } => "movej",
            Self::MoveL { .. } => "movel",
            Self::MoveC { .. } => "movec",
            Self::MoveP { .. } => "movep",
            Self::MoveMl { .. } => "moveml",
            Self::Stop { .. } => "stop",
            Self::Pause => "pause",
            Self::Resume => "resume",
            Self::SetTcp(_) => "set_tcp",
            Self::SetPayload(_) => "set_payload",
            Self::SetStandardDigitalOut { .. } => "set_standard_digital_out",
            Self::SetIo(_) => "set_io",
            Self::SetIoAtZone { .. } => "set_io_at_zone",
            Self::SetSpeedFraction(_) => "set_speed_fraction",
            Self::PowerOn => "power_on",
            Self::PowerOff => "power_off",
            Self::ReleaseBrakes => "release_brakes",
            Self::UnlockProtectiveStop => "unlock_protective_stop",
            Self::ProtectiveStop => "protective_stop",
            Self::RestartSafetyBoard => "restart_safety_board",
            Self::EmergencyStop { .. } => "emergency_stop",
            Self::ServoJ { .. } => "servoj",
            Self::FollowPoints { .. } => "follow_points",
            Self::SpeedJ { .. } => "speedj",
            Self::SpeedL { .. } => "speedl",
            Self::StopJ { .. } => "stopj",
            Self::StopL { .. } => "stopl",
            Self::SetGravity(_) => "set_gravity",
            Self::Freedrive { .. } => "freedrive_mode",
            Self::EndFreedrive => "end_freedrive_mode",
            Self::ForceMode { .. } => "force_mode",
            Self::EndForceMode => "end_force_mode",
            Self::SetForceGain(_) => "force_mode_set_gain_scaling",
            Self::SetForceDamping(_) => "force_mode_set_damping",
            Self::SetExternalWrench(_) => "set_external_wrench",
            Self::Push { .. } => "push",
            Self::FtRtsiInput { .. } => "ft_rtsi_input_enable",
            Self::ZeroFtSensor => "zero_ftsensor",
            Self::SetCollisionDetection(_) => "set_collision_detect_enabled",
            Self::SetCollisionSensitivity(_) => "set_dyn_collision_force_min_ratio",
            Self::TrackConveyorLinear { .. } => "track_conveyor_linear",
            Self::TrackConveyorCircular { .. } => "track_conveyor_circular",
            Self::StopConveyorTracking => "stop_conveyor_tracking",
            Self::EncoderEnableSetTickCount { .. } => "encoder_enable_set_tick_count",
            Self::EncoderSetTickCount { .. } => "encoder_set_tick_count",
            Self::EncoderEnablePulseDecode { .. } => "encoder_enable_pulse_decode",
            Self::PathOffsetEnable => "path_offset_enable",
            Self::PathOffsetDisable { .. } => "path_offset_disable",
            Self::PathOffsetSet { .. } => "path_offset_set",
            Self::PathOffsetFilter(_) => "path_offset_set_alpha_filter",
            Self::PathOffsetMax { .. } => "path_offset_set_max_offset",
            Self::SetDigitalInput { .. } => "set_digital_input",
        }
    }

    /// True for what costs the cycle next to nothing: settings, and modes that begin or end without a plan.
    pub const fn is_setting(&self) -> bool {
        !self.is_motion()
            && !matches!(
                self,
                Self::ServoJ { .. }
                    | Self::FollowPoints { .. }
                    | Self::SpeedJ { .. }
                    | Self::SpeedL { .. }
                    | Self::StopJ { .. }
                    | Self::StopL { .. }
                    | Self::PowerOn
                    | Self::PowerOff
                    | Self::ReleaseBrakes
                    | Self::RestartSafetyBoard
            )
    }

    /// True for commands from which on the arm moves, or may move.
    pub const fn starts_motion(&self) -> bool {
        self.is_motion()
            || matches!(
                self,
                Self::ServoJ { .. }
                    | Self::FollowPoints { .. }
                    | Self::SpeedJ { .. }
                    | Self::SpeedL { .. }
                    | Self::Freedrive { .. }
                    | Self::ForceMode { .. }
                    | Self::TrackConveyorLinear { .. }
                    | Self::TrackConveyorCircular { .. }
                    | Self::PathOffsetEnable
            )
    }

    /// True for commands that move the arm and so exclude one another.
    pub const fn is_motion(&self) -> bool {
        matches!(
            self,
            Self::MoveJ { .. }
                | Self::MoveL { .. }
                | Self::MoveC { .. }
                | Self::MoveP { .. }
                | Self::MoveMl { .. }
        )
    }
}
