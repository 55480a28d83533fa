//! Arguments of commands as JSON objects, and back.
//!
//! One table names the arguments of every command. It is exhaustive: a command or an argument added to the contract
//! does not compile until it is listed here. Numbers come back bit for bit, so that a recorded command can be run
//! again.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds, JointTorques, Payload, RpyPose};
use messages::Localized;
use motion_api::{
    CommandId, CommandKind, EncoderRange, FreedriveFrame, IoChange, MachineCommand, MotionCommand,
    OffsetAxes, OnlineCommand, OverlayCommand, PulseDecoding, SensingCommand, SettingCommand,
};
use serde_json::{Map, Value};
use thiserror::Error;

/// Recorded arguments that do not make a command.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum ArgumentError {
    /// No command has that name.
    #[error("there is no command {name:?} in this version")]
    #[zh("此版本没有命令 {name:?}")]
    UnknownCommand {
        /// The name found.
        name: String,
    },
    /// An argument is missing or of another kind.
    #[error("{command}: argument {argument:?} is {found}, which does not fit")]
    #[zh("{command}：参数 {argument:?} 为 {found}，不合适")]
    Argument {
        /// The command.
        command: &'static str,
        /// The argument.
        argument: &'static str,
        /// What was found.
        found: String,
    },
}

macro_rules! commands {
    ($($kind:ident: $family:ident {
        $($name:literal => $variant:ident $({ $($field:ident),+ })? $(( $item:ident ))?;)+
    })+) => {
        /// The arguments of a command by name.
        pub(crate) fn to_json(kind: &CommandKind) -> Map<String, Value> {
            let mut map = Map::new();
            match kind {
                $($(CommandKind::$kind($family::$variant $({ $($field),+ })? $(($item))?) => {
                    $($(map.insert(stringify!($field).to_owned(), $field.write());)+)?
                    $(map.insert(stringify!($item).to_owned(), $item.write());)?
                })+)+
            }
            map
        }

        /// The command with that name and those arguments.
        pub(crate) fn from_json(
            name: &str,
            arguments: &Map<String, Value>,
        ) -> Result<CommandKind, ArgumentError> {
            match name {
                $($($name => {
                    $($(let $field = read(arguments, $name, stringify!($field))?;)+)?
                    $(let $item = read(arguments, $name, stringify!($item))?;)?
                    Ok($family::$variant $({ $($field),+ })? $(($item))?.into())
                })+)+
                _ => Err(ArgumentError::UnknownCommand { name: name.to_owned() }),
            }
        }
    };
}

commands! {
    Motion: MotionCommand {
        "movej" => MoveJ { target, acceleration, speed, duration, radius };
        "movel" => MoveL { target, acceleration, speed, duration, radius };
        "movec" => MoveC { via, target, acceleration, speed, radius, fixed };
        "movep" => MoveP { target, acceleration, speed, radius };
        "moveml" => MoveMl { count, interval };
    }
    Online: OnlineCommand {
        "servoj" => ServoJ { target, duration, lookahead, gain };
        "follow_points" => FollowPoints { count, interval };
        "speedj" => SpeedJ { speeds, acceleration, duration };
        "speedl" => SpeedL { speed, acceleration, rotation_acceleration, duration };
        "stopj" => StopJ { acceleration };
        "stopl" => StopL { acceleration };
        "freedrive_mode" => Freedrive { free_axes, frame };
        "end_freedrive_mode" => EndFreedrive;
    }
    Overlay: OverlayCommand {
        "force_mode" => ForceMode { frame, selection, wrench, mode, speed_limits };
        "end_force_mode" => EndForceMode;
        "track_conveyor_linear" => TrackConveyorLinear { direction, ticks_per_meter, encoder };
        "track_conveyor_circular" => TrackConveyorCircular { center, ticks_per_revolution, rotate_tool, encoder };
        "stop_conveyor_tracking" => StopConveyorTracking;
        "path_offset_enable" => PathOffsetEnable;
        "path_offset_disable" => PathOffsetDisable { acceleration };
        "path_offset_set" => PathOffsetSet { offset, axes };
        "path_offset_set_alpha_filter" => PathOffsetFilter(share);
        "path_offset_set_max_offset" => PathOffsetMax { translation, rotation };
    }
    Machine: MachineCommand {
        "stop" => Stop { only };
        "pause" => Pause;
        "resume" => Resume;
        "power_on" => PowerOn;
        "power_off" => PowerOff;
        "release_brakes" => ReleaseBrakes;
        "unlock_protective_stop" => UnlockProtectiveStop;
        "protective_stop" => ProtectiveStop;
        "restart_safety_board" => RestartSafetyBoard;
        "emergency_stop" => EmergencyStop { pressed };
    }
    Sensing: SensingCommand {
        "force_mode_set_gain_scaling" => SetForceGain(gain);
        "force_mode_set_damping" => SetForceDamping(damping);
        "set_external_wrench" => SetExternalWrench(wrench);
        "push" => Push { wrench, in_tool_axes, duration, replaces };
        "ft_rtsi_input_enable" => FtRtsiInput { enabled, mass, measuring_offset, cog };
        "zero_ftsensor" => ZeroFtSensor;
        "set_collision_detect_enabled" => SetCollisionDetection(enabled);
        "set_dyn_collision_force_min_ratio" => SetCollisionSensitivity(ratio);
    }
    Setting: SettingCommand {
        "set_tcp" => SetTcp(tcp);
        "set_payload" => SetPayload(payload);
        "set_standard_digital_out" => SetStandardDigitalOut { index, level };
        "set_io" => SetIo(change);
        "set_io_at_zone" => SetIoAtZone { motion, change };
        "set_speed_fraction" => SetSpeedFraction(fraction);
        "set_gravity" => SetGravity(gravity);
        "encoder_enable_set_tick_count" => EncoderEnableSetTickCount { encoder, range };
        "encoder_set_tick_count" => EncoderSetTickCount { encoder, count };
        "encoder_enable_pulse_decode" => EncoderEnablePulseDecode { encoder, decoding, channel_a, channel_b };
        "set_digital_input" => SetDigitalInput { index, level };
    }
}

fn read<T: JsonArgument>(
    arguments: &Map<String, Value>,
    command: &'static str,
    argument: &'static str,
) -> Result<T, ArgumentError> {
    let found = arguments.get(argument);
    found
        .and_then(T::read)
        .ok_or_else(|| ArgumentError::Argument {
            command,
            argument,
            found: found.map_or_else(|| "missing".to_owned(), shortened),
        })
}

/// JSON text for a message, cut where it would fill the screen.
fn shortened(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

/// A value that can be an argument.
trait JsonArgument: Sized {
    fn write(&self) -> Value;
    fn read(value: &Value) -> Option<Self>;
}

impl JsonArgument for bool {
    fn write(&self) -> Value {
        Value::Bool(*self)
    }
    fn read(value: &Value) -> Option<Self> {
        value.as_bool()
    }
}

macro_rules! integers {
    ($($type:ty),+) => {$(
        impl JsonArgument for $type {
            fn write(&self) -> Value {
                Value::from(*self)
            }
            fn read(value: &Value) -> Option<Self> {
                let unsigned = value.as_u64().and_then(|n| n.try_into().ok());
                unsigned.or_else(|| value.as_i64()?.try_into().ok())
            }
        }
    )+};
}
integers!(u8, u16, u32, u64, i32, i64);

impl JsonArgument for f64 {
    /// JSON has no NaN and no infinities; they are written as strings so that nothing is lost.
    fn write(&self) -> Value {
        serde_json::Number::from_f64(*self)
            .map_or_else(|| Value::String(self.to_string()), Value::Number)
    }
    fn read(value: &Value) -> Option<Self> {
        match value {
            Value::Number(number) => number.as_f64(),
            Value::String(text) => text.parse().ok(),
            _ => None,
        }
    }
}

impl<T: JsonArgument, const N: usize> JsonArgument for [T; N] {
    fn write(&self) -> Value {
        Value::Array(self.iter().map(JsonArgument::write).collect())
    }
    fn read(value: &Value) -> Option<Self> {
        let items: Option<Vec<T>> = value.as_array()?.iter().map(T::read).collect();
        items?.try_into().ok()
    }
}

macro_rules! as_other {
    ($($type:ty as $other:ty: $into:expr, $from:expr;)+) => {$(
        impl JsonArgument for $type {
            fn write(&self) -> Value {
                let into: fn(&$type) -> $other = $into;
                into(self).write()
            }
            fn read(value: &Value) -> Option<Self> {
                <$other as JsonArgument>::read(value).map($from)
            }
        }
    )+};
}
as_other! {
    JointPositions as [f64; 6]: |x| x.0, JointPositions;
    JointSpeeds as [f64; 6]: |x| x.0, JointSpeeds;
    JointAccelerations as [f64; 6]: |x| x.0, JointAccelerations;
    JointTorques as [f64; 6]: |x| x.0, JointTorques;
    RpyPose as [f64; 6]: |x| x.to_array(), RpyPose::from_array;
    CommandId as u64: |x| x.0, CommandId;
}

impl JsonArgument for IoChange {
    fn write(&self) -> Value {
        let (name, numbers) = self.to_parts();
        let parts = [("what", Value::from(name)), ("numbers", numbers.write())];
        Value::Object(parts.map(|(k, v)| (k.to_owned(), v)).into_iter().collect())
    }
    fn read(value: &Value) -> Option<Self> {
        let numbers = JsonArgument::read(value.get("numbers")?)?;
        Self::from_parts(value.get("what")?.as_str()?, numbers)
    }
}

impl<T: JsonArgument> JsonArgument for Option<T> {
    fn write(&self) -> Value {
        self.as_ref().map_or(Value::Null, JsonArgument::write)
    }
    fn read(value: &Value) -> Option<Self> {
        match value {
            Value::Null => Some(None),
            value => T::read(value).map(Some),
        }
    }
}

impl JsonArgument for FreedriveFrame {
    fn write(&self) -> Value {
        match self {
            Self::Base => Value::from("base"),
            Self::Tool => Value::from("tool"),
            Self::Pose(pose) => pose.write(),
        }
    }
    fn read(value: &Value) -> Option<Self> {
        match value.as_str() {
            Some("base") => Some(Self::Base),
            Some("tool") => Some(Self::Tool),
            Some(_) => None,
            None => JsonArgument::read(value).map(Self::Pose),
        }
    }
}

impl JsonArgument for EncoderRange {
    fn write(&self) -> Value {
        self.number().write()
    }
    fn read(value: &Value) -> Option<Self> {
        Self::from_number(u64::read(value)?)
    }
}

impl JsonArgument for OffsetAxes {
    fn write(&self) -> Value {
        Value::from(self.number())
    }
    fn read(value: &Value) -> Option<Self> {
        Self::from_number(value.as_u64()?)
    }
}

impl JsonArgument for PulseDecoding {
    fn write(&self) -> Value {
        self.number().write()
    }
    fn read(value: &Value) -> Option<Self> {
        Self::from_number(u64::read(value)?)
    }
}

impl JsonArgument for Payload {
    fn write(&self) -> Value {
        let Self { mass, cog, inertia } = self;
        let parts = [
            ("mass", mass.write()),
            ("cog", <[f64; 3]>::from(*cog).write()),
            ("inertia", inertia.write()),
        ];
        Value::Object(parts.map(|(k, v)| (k.to_owned(), v)).into_iter().collect())
    }
    fn read(value: &Value) -> Option<Self> {
        Some(Self {
            mass: JsonArgument::read(value.get("mass")?)?,
            cog: <[f64; 3]>::read(value.get("cog")?)?.into(),
            inertia: JsonArgument::read(value.get("inertia")?)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// One command of each kind, with numbers that JSON cannot write briefly.
    fn commands(x: f64) -> Vec<CommandKind> {
        let target = JointPositions([x, -x, x / 3.0, x * 1e-300, 0.1 + 0.2, -0.0]);
        let pose = RpyPose::from_array(target.0);
        let payload = Payload {
            mass: x,
            cog: [x, 2.0 * x, 0.1].into(),
            inertia: target.0,
        };
        vec![
            CommandKind::Motion(MotionCommand::MoveJ {
                target,
                acceleration: x,
                speed: x,
                duration: 0.0,
                radius: 0.0,
            }),
            CommandKind::Motion(MotionCommand::MoveL {
                target: pose,
                acceleration: x,
                speed: x,
                duration: x,
                radius: 0.0,
            }),
            CommandKind::Machine(MachineCommand::Stop { only: CommandId(7) }),
            CommandKind::Machine(MachineCommand::Pause),
            CommandKind::Machine(MachineCommand::Resume),
            CommandKind::Setting(SettingCommand::SetTcp(pose)),
            CommandKind::Setting(SettingCommand::SetPayload(payload)),
            CommandKind::Setting(SettingCommand::SetStandardDigitalOut {
                index: 15,
                level: true,
            }),
            CommandKind::Setting(SettingCommand::SetIo(IoChange::AnalogOut {
                port: 1,
                ratio: x,
            })),
            CommandKind::Setting(SettingCommand::SetIo(IoChange::DigitalIn {
                mask: 0x0FFF_FFFF,
                levels: 5,
            })),
            CommandKind::Setting(SettingCommand::SetIoAtZone {
                motion: CommandId(3),
                change: IoChange::FloatRegister {
                    index: 47,
                    value: x,
                },
            }),
            CommandKind::Setting(SettingCommand::SetSpeedFraction(x)),
            CommandKind::Machine(MachineCommand::PowerOn),
            CommandKind::Machine(MachineCommand::PowerOff),
            CommandKind::Machine(MachineCommand::ReleaseBrakes),
            CommandKind::Machine(MachineCommand::EmergencyStop { pressed: true }),
            CommandKind::Machine(MachineCommand::UnlockProtectiveStop),
            CommandKind::Machine(MachineCommand::ProtectiveStop),
            CommandKind::Machine(MachineCommand::RestartSafetyBoard),
            CommandKind::Online(OnlineCommand::ServoJ {
                target,
                duration: x,
                lookahead: 0.1,
                gain: x,
            }),
            CommandKind::Online(OnlineCommand::FollowPoints {
                count: 3,
                interval: x,
            }),
            CommandKind::Online(OnlineCommand::SpeedJ {
                speeds: JointSpeeds(target.0),
                acceleration: x,
                duration: None,
            }),
            CommandKind::Online(OnlineCommand::SpeedL {
                speed: target.0,
                acceleration: x,
                rotation_acceleration: -x,
                duration: Some(x),
            }),
            CommandKind::Online(OnlineCommand::StopJ { acceleration: x }),
            CommandKind::Online(OnlineCommand::StopL { acceleration: x }),
            CommandKind::Setting(SettingCommand::SetGravity([x, 0.0, -9.81])),
            CommandKind::Online(OnlineCommand::Freedrive {
                free_axes: [true, false, true, false, true, false],
                frame: FreedriveFrame::Pose(pose),
            }),
            CommandKind::Online(OnlineCommand::Freedrive {
                free_axes: [false; 6],
                frame: FreedriveFrame::Tool,
            }),
            CommandKind::Online(OnlineCommand::EndFreedrive),
            CommandKind::Overlay(OverlayCommand::ForceMode {
                frame: pose,
                selection: [true, false, true, false, false, true],
                wrench: target.0,
                mode: 3,
                speed_limits: [x.abs(); 6],
            }),
            CommandKind::Overlay(OverlayCommand::EndForceMode),
            CommandKind::Sensing(SensingCommand::SetForceGain(x)),
            CommandKind::Sensing(SensingCommand::SetForceDamping(x)),
            CommandKind::Sensing(SensingCommand::SetExternalWrench(target.0)),
            CommandKind::Sensing(SensingCommand::Push {
                wrench: target.0,
                in_tool_axes: true,
                duration: x.abs(),
                replaces: false,
            }),
            CommandKind::Sensing(SensingCommand::FtRtsiInput {
                enabled: true,
                mass: x,
                measuring_offset: [0.0, x, 0.1],
                cog: [x, 0.0, 0.05],
            }),
            CommandKind::Sensing(SensingCommand::ZeroFtSensor),
            CommandKind::Sensing(SensingCommand::SetCollisionDetection(true)),
            CommandKind::Sensing(SensingCommand::SetCollisionSensitivity(30)),
            CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
                direction: [x, 0.0, 1.0],
                ticks_per_meter: x,
                encoder: 1,
            }),
            CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
                center: pose,
                ticks_per_revolution: x,
                rotate_tool: true,
                encoder: 0,
            }),
            CommandKind::Overlay(OverlayCommand::StopConveyorTracking),
            CommandKind::Setting(SettingCommand::EncoderEnableSetTickCount {
                encoder: 1,
                range: EncoderRange::Unsigned24,
            }),
            CommandKind::Setting(SettingCommand::EncoderSetTickCount {
                encoder: 1,
                count: x,
            }),
            CommandKind::Setting(SettingCommand::EncoderEnablePulseDecode {
                encoder: 0,
                decoding: PulseDecoding::Rising,
                channel_a: 16,
                channel_b: 0,
            }),
            CommandKind::Motion(MotionCommand::MoveP {
                target: pose,
                acceleration: x,
                speed: x,
                radius: x,
            }),
            CommandKind::Overlay(OverlayCommand::PathOffsetEnable),
            CommandKind::Overlay(OverlayCommand::PathOffsetDisable { acceleration: x }),
            CommandKind::Overlay(OverlayCommand::PathOffsetSet {
                offset: pose,
                axes: OffsetAxes::Motion,
            }),
            CommandKind::Overlay(OverlayCommand::PathOffsetFilter(x)),
            CommandKind::Overlay(OverlayCommand::PathOffsetMax {
                translation: x,
                rotation: x,
            }),
            CommandKind::Setting(SettingCommand::SetDigitalInput {
                index: 17,
                level: true,
            }),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn every_command_comes_back_from_its_text(x in proptest::num::f64::NORMAL) {
            for kind in commands(x) {
                let text = Value::Object(to_json(&kind)).to_string();
                let arguments: Map<String, Value> = serde_json::from_str(&text).unwrap();
                prop_assert_eq!(from_json(kind.name(), &arguments).unwrap(), kind);
            }
        }
    }

    #[test]
    fn arguments_that_do_not_fit_are_named() {
        let mut arguments = to_json(&commands(1.0)[0]);
        arguments.insert("target".to_owned(), Value::from("home"));
        let error = from_json("movej", &arguments).unwrap_err();
        assert_eq!(
            error.to_string(),
            "movej: argument \"target\" is \"home\", which does not fit"
        );
        arguments.remove("target");
        let error = from_json("movej", &arguments).unwrap_err();
        assert_eq!(
            error.to_string(),
            "movej: argument \"target\" is missing, which does not fit"
        );
        assert_eq!(
            from_json("fly", &arguments),
            Err(ArgumentError::UnknownCommand {
                name: "fly".to_owned()
            })
        );
    }
}
