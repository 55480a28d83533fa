//! What the motion thread reports: how commands ended, warnings, stops. Numbers only; sentences are made on the other
//! side of the border by the `Display` implementations here.

use core::fmt;

use crate::{CommandId, RobotMode, SafetyMode};
use kinematics::collision::link_name;
use messages::{Localized, Text};
use thiserror::Error;

/// A text of fixed words, or a name that is the same in every language, which lives as long as the process.
#[macro_export]
macro_rules! phrase {
    ($english:literal, $chinese:literal) => {
        const { &messages::Text::fixed($english, $chinese) }
    };
    ($name:literal) => {
        $crate::phrase!($name, $name)
    };
}

/// One thing that happened in the cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A command has ended (every command ends exactly once).
    Ended {
        /// The command that has ended.
        id: CommandId,
        /// How the command ended.
        outcome: Outcome,
        /// The cycle in which the command ended.
        cycle: u64,
    },
    /// A motion with a blend radius is planned and the arm comes so near to its blend that the next motion should
    /// follow: its sender may send that now, although the command has not ended.
    ReadyForNext {
        /// The motion that is planned.
        id: CommandId,
        /// The cycle in which that is so.
        cycle: u64,
    },
    /// The arm has come so near to the blend of a motion, or to its end, that it slows down unless the next motion
    /// comes at once: what its sender does before that he does now, although the command may not have ended.
    Due {
        /// The motion whose blend or end is near.
        id: CommandId,
        /// The cycle in which that is so.
        cycle: u64,
    },
    /// Something a person should read, concerning a command.
    Warned {
        /// The command that the warning concerns.
        id: CommandId,
        /// What there is to say.
        warning: Warning,
        /// The cycle in which the warning was found.
        cycle: u64,
    },
    /// The arm entered a protective stop.
    Stopped {
        /// The reason for the protective stop.
        reason: StopReason,
        /// The cycle in which the reason was found.
        cycle: u64,
    },
}

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Carried out as asked.
    Done,
    /// Not begun: the arm has not moved.
    Refused(Refusal),
    /// Begun and ended by a stop.
    Aborted,
    /// Begun and ended by a protective stop.
    ProtectiveStop(StopReason),
}

/// The reason for which a command was not begun. Joints count from 1 in messages, as printed on the arm's label.
#[derive(Clone, Copy, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum Refusal {
    /// Another motion is running.
    #[error("another motion (command {}) is still running; only one motion at a time can move the arm", running.0)]
    #[zh("另一个运动（命令 {}）仍在进行；同一时刻只能有一个运动驱动手臂", running.0)]
    Busy {
        /// The one that runs.
        running: CommandId,
    },
    /// The arm is not ready to move.
    #[error(
        "the robot mode is {robot_mode} and the safety mode {safety_mode}; \
         the arm moves only when they are RUNNING and NORMAL or REDUCED"
    )]
    #[zh(
        "机器人模式为 {robot_mode}，安全模式为 {safety_mode}；只有在 RUNNING 且 NORMAL 或 REDUCED 时手臂才能运动"
    )]
    NotReady {
        /// Robot mode found.
        robot_mode: RobotMode,
        /// Safety mode found.
        safety_mode: SafetyMode,
    },
    /// The request does not fit the robot's state, for example releasing brakes without power.
    #[error("the robot mode is {robot_mode}, this needs {needed}")]
    #[zh("机器人模式为 {robot_mode}，此操作需要 {needed}")]
    WrongMode {
        /// Robot mode found.
        robot_mode: RobotMode,
        /// Robot mode needed.
        needed: RobotMode,
    },
    /// A target lies outside a joint's range.
    #[error("joint {} would go to {} rad, allowed is {min:.4} to {max:.4} rad", joint + 1, ReadableNumber(*value))]
    #[zh("关节 {} 将到达 {} rad，允许 {min:.4} 到 {max:.4} rad", joint + 1, ReadableNumber(*value))]
    JointLimit {
        /// Joint index from 0.
        joint: u8,
        /// Where the joint would go, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// The line or arc cannot be followed.
    #[error("the path cannot be followed {:.1} % of the way along: {fault}", fraction * 100.0)]
    #[zh("路径在 {:.1} % 处无法跟随：{fault}", fraction * 100.0)]
    Path {
        /// Where along the path, 0 to 1.
        fraction: f64,
        /// What is wrong there.
        fault: PathFault,
    },
    /// The arm went in a direction as far as it can, and stands there.
    #[error("the arm can go no further in this direction than {way:.3} m: {fault}")]
    #[zh("手臂沿该方向最多只能前进 {way:.3} m：{fault}")]
    DirectionEnds {
        /// How far the TCP can go, m.
        way: f64,
        /// What is wrong behind that.
        fault: PathFault,
    },
    /// Three points that make no circular arc.
    #[error(
        "start, via point and target make no circular arc: two of them coincide, or they lie on a straight line"
    )]
    #[zh("起点、中间点和目标点不能构成圆弧：有两点重合，或三点共线")]
    NoArc,
    /// A number of the command cannot be used.
    #[error("{name} is {value}; it must be {needed}")]
    #[zh("{name} 为 {value}；应为 {needed}")]
    BadValue {
        /// The name of the number.
        name: &'static Text,
        /// The number as it was given.
        value: f64,
        /// What is allowed.
        needed: &'static Text,
    },
    /// The arm has not come to rest yet.
    #[error("the arm still decelerates; this is possible once it stands")]
    #[zh("手臂仍在减速；停稳后才能进行")]
    StillMoving,
    /// The target lies behind a safety plane.
    #[error("the target lies {depth:.4} m behind safety plane {} of the cell", plane + 1)]
    #[zh("目标点在单元的安全平面 {} 之后 {depth:.4} m", plane + 1)]
    SafetyPlane {
        /// Index of the plane in the cell, from 0.
        plane: u8,
        /// How far the target lies behind the plane, m.
        depth: f64,
    },
    /// A conveyor is tracked already.
    #[error("a conveyor is tracked already; end that first with stop_conveyor_tracking()")]
    #[zh("已在跟踪传送带；请先用 stop_conveyor_tracking() 结束")]
    ConveyorTracking,
    /// Force mode is on.
    #[error("force mode is on; end it first with end_force_mode()")]
    #[zh("力控模式已开启；请先用 end_force_mode() 结束")]
    InForceMode,
    /// Path offsets are enabled.
    #[error("path offsets are enabled; end them first with path_offset_disable()")]
    #[zh("路径偏移已启用；请先用 path_offset_disable() 结束")]
    PathOffset,
    /// The arm is led by hand.
    #[error(
        "the arm is led by hand; this is possible once the input with the action freedrive is low again"
    )]
    #[zh("手臂正在被手动引导；带有自由驱动动作的输入恢复低电平后才能进行")]
    HandGuided,
    /// The TCP cannot be changed on a turntable that does not turn it: the arm would have to jump.
    #[error(
        "a turntable is tracked that does not turn the tool; end that first with stop_conveyor_tracking()"
    )]
    #[zh("正在跟踪不转动工具的转台；请先用 stop_conveyor_tracking() 结束")]
    NonRotatingTurntable,
    /// The planner found nothing.
    #[error("no trajectory found for this target (planner error {code})")]
    #[zh("找不到到达该目标的轨迹（规划器错误 {code}）")]
    Planner {
        /// Number of the planner's error.
        code: u32,
    },
}

/// A number as people read it: four decimals, and not three hundred digits before them.
struct ReadableNumber(f64);

impl fmt::Display for ReadableNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.abs() < 1e6 {
            write!(f, "{:.4}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// The reason for which a path cannot be followed at some place.
#[derive(Clone, Copy, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum PathFault {
    /// No joint positions reach the pose.
    #[error("the pose is out of reach")]
    #[zh("位姿不可达")]
    OutOfReach,
    /// A joint would leave its range.
    #[error("joint {} would go to {} rad, allowed is {min:.4} to {max:.4} rad", joint + 1, ReadableNumber(*value))]
    #[zh("关节 {} 将到达 {} rad，允许 {min:.4} 到 {max:.4} rad", joint + 1, ReadableNumber(*value))]
    JointLimit {
        /// Joint index from 0.
        joint: u8,
        /// Where the joint would go, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// The arm passes a singular position, where a joint would have to jump.
    #[error("the arm passes a singular position there, joint {} would have to turn {jump:.3} rad at once", joint + 1)]
    #[zh("手臂在那里经过奇异位置，关节 {} 须瞬间转动 {jump:.3} rad", joint + 1)]
    Singular {
        /// Joint index from 0.
        joint: u8,
        /// Size of the jump, rad.
        jump: f64,
    },
    /// Two links of the arm meet.
    #[error(
        "{} and {} would run into each other there, by {:.1} mm",
        link_name((*links)[0].into()),
        link_name((*links)[1].into()),
        overlap * 1e3
    )]
    #[zh("{}与{}在那里会相撞，重叠 {:.1} mm", link_name((*links)[0].into()), link_name((*links)[1].into()), overlap * 1e3)]
    SelfCollision {
        /// The two links, 0 for the base.
        links: [u8; 2],
        /// How far the capsules of the links overlap, m.
        overlap: f64,
    },
    /// A safety plane would be crossed.
    #[error("safety plane {} of the cell would be crossed there", plane + 1)]
    #[zh("在那里会越过单元的安全平面 {}", plane + 1)]
    SafetyPlane {
        /// Index of the plane in the cell, from 0.
        plane: u8,
    },
}

/// The reason for which the arm went into a protective stop. The number of each reason is stable: it is the sub code on
/// port 30001.
#[derive(Clone, Copy, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum StopReason {
    /// The commanded state would leave a joint's range.
    #[error("joint {} was about to leave its range at {value:.4} rad (allowed {min:.4} to {max:.4} rad)", joint + 1)]
    #[zh("关节 {} 即将在 {value:.4} rad 处超出范围（允许 {min:.4} 到 {max:.4} rad）", joint + 1)]
    JointPosition {
        /// Joint index from 0.
        joint: u8,
        /// Commanded, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// The commanded state would exceed a joint's speed.
    #[error("joint {} was about to exceed its speed limit: {value:.4} rad/s, allowed {limit:.4} rad/s", joint + 1)]
    #[zh("关节 {} 即将超速：{value:.4} rad/s，允许 {limit:.4} rad/s", joint + 1)]
    JointSpeed {
        /// Joint index from 0.
        joint: u8,
        /// Commanded, rad/s.
        value: f64,
        /// Limit, rad/s.
        limit: f64,
    },
    /// The arm does not follow: actual and target positions differ too much (a collision, an overload).
    #[error(
        "joint {} does not follow: actual and target differ by {error:.4} rad (allowed {limit:.4} rad); \
         a collision or an overload",
        joint + 1
    )]
    #[zh("关节 {} 没有跟随：实际与目标相差 {error:.4} rad（允许 {limit:.4} rad）；发生碰撞或过载", joint + 1)]
    TrackingError {
        /// Joint index from 0.
        joint: u8,
        /// Difference, rad.
        error: f64,
        /// Limit, rad.
        limit: f64,
    },
    /// The commanded state would exceed the speed limit of the TCP.
    #[error("the TCP was about to exceed its speed limit: {value:.4} m/s, allowed {limit:.4} m/s")]
    #[zh("TCP 即将超速：{value:.4} m/s，允许 {limit:.4} m/s")]
    TcpSpeed {
        /// Commanded, m/s.
        value: f64,
        /// Limit, m/s.
        limit: f64,
    },
    /// The commanded state would exceed the speed limit of the elbow.
    #[error(
        "the elbow was about to exceed its speed limit: {value:.4} m/s, allowed {limit:.4} m/s"
    )]
    #[zh("肘部即将超速：{value:.4} m/s，允许 {limit:.4} m/s")]
    ElbowSpeed {
        /// Commanded, m/s.
        value: f64,
        /// Limit, m/s.
        limit: f64,
    },
    /// Somebody pressed an emergency stop, or an input that means it asked for one.
    #[error("an emergency stop was asked for; release it, then power on and release the brakes")]
    #[zh("紧急停止被触发；请先复位，再上电并松开抱闸")]
    EmergencyStop,
    /// A joint carries more than the motion explains.
    #[error(
        "collision at joint {}: {torque:.1} Nm from outside (allowed {limit:.1} Nm), \
         as a push of {force:.0} N at the TCP makes; the sensor at the tool may read another force",
        joint + 1
    )]
    #[zh("关节 {} 碰撞：外力矩 {torque:.1} Nm（允许 {limit:.1} Nm），相当于 TCP 处 {force:.0} N 的推力；工具上的传感器可能读到不同的力", joint + 1)]
    Collision {
        /// Joint index from 0.
        joint: u8,
        /// Torque from outside, Nm.
        torque: f64,
        /// Threshold, Nm.
        limit: f64,
        /// The force at the TCP that explains the torques of all joints best, N.
        force: f64,
    },
    /// The tool presses harder than the cell allows.
    #[error("the force at the TCP is {force:.1} N (allowed {limit:.1} N)")]
    #[zh("TCP 受力为 {force:.1} N（允许 {limit:.1} N）")]
    TcpForce {
        /// What the sensor reads, N.
        force: f64,
        /// Limit, N.
        limit: f64,
    },
    /// A conveyor carried the TCP out of reach, or to where the joints would have to change their speeds faster than
    /// they can.
    #[error("the conveyor carries the TCP to where the arm cannot follow")]
    #[zh("传送带把 TCP 带到手臂无法跟随之处")]
    ConveyorLost,
    /// The offset of the path is larger than the program allows.
    #[error(
        "the path offset is {translation:.4} m and {rotation:.4} rad; \
         path_offset_set_max_offset() allows {most_translation:.4} m and {most_rotation:.4} rad"
    )]
    #[zh(
        "路径偏移为 {translation:.4} m 和 {rotation:.4} rad；path_offset_set_max_offset() 允许 {most_translation:.4} m 和 \
         {most_rotation:.4} rad"
    )]
    PathOffset {
        /// The translation that was asked for, m.
        translation: f64,
        /// The rotation that was asked for, rad.
        rotation: f64,
        /// Limit, m.
        most_translation: f64,
        /// Limit, rad.
        most_rotation: f64,
    },
    /// The offset of the path led out of reach, or to where the joints would have to change their speeds faster than
    /// they can.
    #[error("the path offset leads the TCP to where the arm cannot follow")]
    #[zh("路径偏移把 TCP 带到手臂无法跟随之处")]
    PathOffsetLost,
    /// TCP or tool were about to cross a safety plane.
    #[error(
        "the tool was about to cross safety plane {} of the cell: it would come to rest {depth:.4} m behind it",
        plane + 1
    )]
    #[zh("工具即将越过单元的安全平面 {}：将停在其后 {depth:.4} m 处", plane + 1)]
    SafetyPlane {
        /// Index of the plane in the cell, from 0.
        plane: u8,
        /// How far behind the plane the tool would come to rest, m.
        depth: f64,
    },
    /// Two links of the arm were about to meet.
    #[error(
        "{} and {} were about to run into each other, by {:.1} mm where the arm would come to rest",
        link_name((*links)[0].into()),
        link_name((*links)[1].into()),
        overlap * 1e3
    )]
    #[zh("{}与{}即将相撞，手臂停下处重叠 {:.1} mm", link_name((*links)[0].into()), link_name((*links)[1].into()), overlap * 1e3)]
    SelfCollision {
        /// The two links, 0 for the base.
        links: [u8; 2],
        /// How far the capsules of the links would overlap, m.
        overlap: f64,
    },
    /// Somebody asked for it: a test, a simulation.
    #[error("a protective stop was asked for")]
    #[zh("保护性停止被触发")]
    Requested,
    /// The controller met a condition it has no rule for; the arm stops. A bug of ours.
    #[error("internal fault {code} in the motion thread; please report it with the recording")]
    #[zh("运动线程内部故障 {code}；请连同记录一起报告")]
    Internal {
        /// Number of the place.
        code: u32,
    },
}

impl StopReason {
    /// The stable number of the reason.
    pub const fn code(&self) -> u32 {
        match self {
            Self::JointPosition { .. } => 1,
            Self::JointSpeed { .. } => 2,
            Self::TrackingError { .. } => 3,
            Self::TcpSpeed { .. } => 4,
            Self::ElbowSpeed { .. } => 5,
            Self::EmergencyStop => 20,
            Self::Collision { .. } => 11,
            Self::SafetyPlane { .. } => 12,
            Self::ConveyorLost => 13,
            Self::TcpForce { .. } => 14,
            Self::PathOffset { .. } => 15,
            Self::PathOffsetLost => 16,
            Self::SelfCollision { .. } => 17,
            Self::Requested => 18,
            Self::Internal { .. } => 99,
        }
    }
}

/// What the way of a motion is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WayUnit {
    /// Angle of the joint with the longest way.
    Radian,
    /// Way of the TCP.
    Metre,
}

impl fmt::Display for WayUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Radian => "rad",
            Self::Metre => "m",
        })
    }
}

/// What was changed about a motion, so that it could be done.
#[derive(Clone, Copy, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum Warning {
    /// The wanted duration is too short.
    #[error("a duration of {wanted:.3} s is too short, the motion takes {planned:.3} s")]
    #[zh("{wanted:.3} s 的时间太短，运动需要 {planned:.3} s")]
    DurationStretched {
        /// Asked for, s.
        wanted: f64,
        /// Planned, s.
        planned: f64,
    },
    /// The wanted speed is more than the arm can do here.
    #[error(
        "a speed of {wanted:.4} {unit}/s is more than the joints can do here, it is limited to {planned:.4} {unit}/s"
    )]
    #[zh("速度 {wanted:.4} {unit}/s 超出关节在此的能力，限制为 {planned:.4} {unit}/s")]
    SpeedLimited {
        /// Asked for, rad/s or m/s.
        wanted: f64,
        /// What the motion slows down to, rad/s or m/s.
        planned: f64,
        /// The unit of the way.
        unit: WayUnit,
    },
    /// An online mode cannot go on as asked.
    #[error(
        "the arm slows down: joint {} is near the end of its range or turns too fast for the wanted motion",
        joint + 1
    )]
    #[zh("手臂减速：关节 {} 接近其范围的边界，或对所需运动而言转动过快", joint + 1)]
    LimitedByJoint {
        /// Joint index from 0.
        joint: u8,
    },
    /// The blend radius is more than the legs have room for.
    #[error(
        "a blend radius of {wanted:.4} m is more than there is room for here, it is shortened to {planned:.4} m"
    )]
    #[zh("交融半径 {wanted:.4} m 超出此处的余地，缩短为 {planned:.4} m")]
    RadiusShortened {
        /// Asked for, m.
        wanted: f64,
        /// Planned, m.
        planned: f64,
    },
    /// The motion could not go over into the next one without a stop.
    #[error(
        "the motion stopped at its end instead of blending: \
         the next one came too late or turns too sharply for the speed"
    )]
    #[zh("运动在终点停下而没有交融：下一个运动来得太晚，或以此速度转弯过急")]
    NotBlended,
    /// The target is so far away that it only says where to go.
    #[error(
        "the target is {distance:.1} m away, no arm reaches that far: \
         it is taken as a direction, and the arm goes there until something stops it"
    )]
    #[zh("目标在 {distance:.1} m 之外，没有手臂能到达：将其视为方向，手臂沿该方向运动，直到被停止")]
    Direction {
        /// Distance of the target from where the motion begins, m.
        distance: f64,
    },
    /// A blend radius at the end of a direction.
    #[error(
        "a direction has no end that could be blended: the blend radius of {radius:.4} m is not used"
    )]
    #[zh("方向没有可交融的终点：交融半径 {radius:.4} m 不起作用")]
    DirectionNotBlended {
        /// Asked for, m.
        radius: f64,
    },
    /// The wanted acceleration is more than the arm can do here.
    #[error(
        "an acceleration of {wanted:.4} {unit}/s² is more than the joints can do here, \
         it is limited to {planned:.4} {unit}/s²"
    )]
    #[zh("加速度 {wanted:.4} {unit}/s² 超出关节在此的能力，限制为 {planned:.4} {unit}/s²")]
    AccelerationLimited {
        /// Asked for, rad/s² or m/s².
        wanted: f64,
        /// The most that the motion does, rad/s² or m/s².
        planned: f64,
        /// The unit of the way.
        unit: WayUnit,
    },
}
