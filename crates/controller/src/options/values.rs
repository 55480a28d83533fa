//! The values that options of the robot take: one text form each, the same on the command line, in configuration files
//! and wherever else a controller is started.
//!
//! Every type parses itself and says in one sentence what was wrong and what is allowed. Nothing here opens a file or
//! a socket, and nothing knows which option a value belongs to.

use core::fmt;
use core::str::FromStr;
use std::path::PathBuf;

use kinematics::{JointPositions, Payload, PayloadError, RpyPose};
use messages::{Text, text};
use motion_api::{CommandKind, SettingCommand};
use recorder::RotationTrigger;

/// Names of the built-in models.
pub const MODEL_NAMES: [&str; 6] = ["cs63", "cs66", "cs612", "cs616", "cs620", "cs625"];

/// The model of an arm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModelChoice {
    /// One of [`MODEL_NAMES`].
    BuiltIn(&'static str),
    /// A URDF file.
    Urdf(PathBuf),
}

impl FromStr for ModelChoice {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        if let Some(name) = MODEL_NAMES.iter().find(|n| n.eq_ignore_ascii_case(text)) {
            return Ok(Self::BuiltIn(name));
        }
        let looks_like_a_path = text.contains(['/', '\\']) || text.ends_with(".urdf");
        if looks_like_a_path {
            return Ok(Self::Urdf(PathBuf::from(text)));
        }
        Err(text!(
            "allowed are {} or the path of a URDF file (with a `/` in it, or ending in .urdf)",
            "允许 {} 或 URDF 文件的路径（含有 `/`，或以 .urdf 结尾）",
            MODEL_NAMES.join(", ")
        ))
    }
}

impl fmt::Display for ModelChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltIn(name) => f.write_str(name),
            Self::Urdf(path) => write!(f, "{}", path.display()),
        }
    }
}

/// What a second of the controller is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockChoice {
    /// A second of the machine.
    Realtime,
    /// Simulated: as fast as the machine can.
    Virtual,
}

impl FromStr for ClockChoice {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text {
            "realtime" => Ok(Self::Realtime),
            "virtual" => Ok(Self::Virtual),
            _ => Err(text!(
                "allowed are realtime and virtual",
                "允许 realtime 和 virtual"
            )),
        }
    }
}

/// How the arm is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantChoice {
    /// Rigid bodies with contact.
    Rigid,
    /// Rigid bodies with contact, computed by the rapier engine.
    Rapier,
    /// The arm is always where it is told to be.
    Ideal,
}

impl FromStr for PlantChoice {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text {
            "rigid" => Ok(Self::Rigid),
            "rapier" => Ok(Self::Rapier),
            "ideal" => Ok(Self::Ideal),
            _ => Err(text!(
                "allowed are rigid, rapier and ideal",
                "允许 rigid、rapier 和 ideal"
            )),
        }
    }
}

/// Length of the control cycle in whole milliseconds, 1 to 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepMillis(u8);

impl StepMillis {
    /// The default: 4 ms, RTSI's 250 Hz.
    pub const DEFAULT: Self = Self(4);

    /// The step in seconds.
    pub fn as_secs(self) -> f64 {
        f64::from(self.0) / 1000.0
    }
}

impl FromStr for StepMillis {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text.parse() {
            Ok(millis @ 1..=8) => Ok(Self(millis)),
            _ => Err(text!(
                "allowed are whole milliseconds from 1 to 8",
                "允许 1 到 8 的整毫秒数"
            )),
        }
    }
}

/// Target of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordTarget {
    /// Nothing is recorded.
    Off,
    /// A new file in this folder.
    NewFileIn(PathBuf),
    /// This file.
    File(PathBuf),
}

impl FromStr for RecordTarget {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text {
            "" => Err(text!(
                "allowed are off and the path of a file to write",
                "允许 off 和要写的文件的路径"
            )),
            "off" => Ok(Self::Off),
            path => Ok(Self::File(PathBuf::from(path))),
        }
    }
}

/// How long one file of the recording becomes: a size or a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationLimit(pub RotationTrigger);

impl FromStr for RotationLimit {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        if let Ok(size) = text.parse::<ByteSize>() {
            return Ok(Self(RotationTrigger::Bytes(size.0)));
        }
        let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0)];
        let secs = with_unit(text, &units).filter(|secs| (1.0..=31_536_000.0).contains(secs));
        match secs {
            Some(secs) => Ok(Self(RotationTrigger::Secs(secs))),
            None => Err(text!(
                "allowed are sizes from 1 MB and times from 1 s to a year, \
                as in 500MB, 2GB, 90s, 30min or 8h",
                "允许 1 MB 以上的大小和 1 s 到一年的时间，如 500MB、2GB、90s、30min 或 8h"
            )),
        }
    }
}

/// A number of bytes, at least a million.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ByteSize(pub u64);

impl FromStr for ByteSize {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        let units = [
            ("MiB", 1024.0 * 1024.0),
            ("GiB", 1024.0 * 1024.0 * 1024.0),
            ("MB", 1e6),
            ("GB", 1e9),
            ("TB", 1e12),
        ];
        match with_unit(text, &units).filter(|bytes| (1e6..=1e18).contains(bytes)) {
            Some(bytes) => Ok(Self(bytes as u64)),
            None => Err(text!(
                "allowed are sizes from 1 MB, as in 500MB, 20GB or 4GiB",
                "允许 1 MB 以上的大小，如 500MB、20GB 或 4GiB"
            )),
        }
    }
}

/// A number followed by one of the units, in the unit's base.
fn with_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    units.iter().find_map(|(unit, factor)| {
        let number = text.strip_suffix(unit)?.trim_end();
        number.parse::<f64>().ok().map(|number| number * factor)
    })
}

/// What scripts may reach beyond the robot.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Permission {
    /// Every file that the controller itself may reach.
    Fs,
    /// The files beneath a folder.
    FsIn(PathBuf),
    /// Other processes, signals.
    Process,
    /// Environment variables.
    Env,
    /// The network.
    Net,
    /// Machines that a test plays, and no others.
    NetPlayed,
}

impl FromStr for Permission {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text {
            "fs" => Ok(Self::Fs),
            "process" => Ok(Self::Process),
            "env" => Ok(Self::Env),
            "net" => Ok(Self::Net),
            "net=played" => Ok(Self::NetPlayed),
            _ => match text.strip_prefix("fs=") {
                Some("") => Err(text!(
                    "fs= needs a folder, fs=/data for instance",
                    "fs= 需要一个文件夹，例如 fs=/data"
                )),
                Some(folder) => Ok(Self::FsIn(folder.into())),
                None => Err(text!(
                    "allowed are fs, fs=DIR, process, env, net and net=played",
                    "允许 fs、fs=DIR、process、env、net 和 net=played"
                )),
            },
        }
    }
}

/// Largest angle that is read, rad: far beyond every joint, and still short to print.
pub const ANGLE_MAX: f64 = 1000.0;

/// The joint positions at start, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomeJoints(pub JointPositions);

#[allow(
    clippy::approx_constant,
    reason = "the figures as documented, not the constant"
)]
impl Default for HomeJoints {
    fn default() -> Self {
        Self(JointPositions([
            0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0,
        ]))
    }
}

impl FromStr for HomeJoints {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        six_numbers(text)
            .filter(|q| q.iter().all(|angle| angle.abs() <= ANGLE_MAX))
            .map(|q| Self(JointPositions(q)))
            .ok_or_else(|| {
                text!("six joint positions in rad, up to 1000, are needed, separated by commas, \
                 as in 0,-1.57,1.57,-1.57,-1.57,0", "需要六个不超过 1000 的关节位置（rad），以逗号分隔，如 0,-1.57,1.57,-1.57,-1.57,0")
            })
    }
}

/// The tool centre point at start, relative to the flange.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tcp(pub RpyPose);

impl FromStr for Tcp {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        let is_angle = |angle: &f64| angle.abs() <= ANGLE_MAX;
        // What `set_tcp` refuses no start may bring in: the collision check does not survive it.
        six_numbers(text)
            .map(RpyPose::from_array)
            .filter(|tcp| tcp.rpy.iter().all(is_angle))
            .filter(|tcp| CommandKind::Setting(SettingCommand::SetTcp(*tcp)).validate().is_ok())
            .map(Self)
            .ok_or_else(|| {
                text!("x, y, z in m, up to 10, and Rx, Ry, Rz in rad, up to 1000, are needed, separated by commas, \
                 as in 0,0,0.1,0,0,0", "需要以逗号分隔的 x、y、z（m，不超过 10）和 Rx、Ry、Rz（rad，不超过 1000），如 0,0,0.1,0,0,0")
            })
    }
}

/// The payload at start: mass, then centre of gravity, then inertia Ixx, Iyy, Izz, Ixy, Ixz, Iyz about it, kg m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PayloadChoice(pub Payload);

impl FromStr for PayloadChoice {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        let payload = match numbers(text).as_deref() {
            Some(&[mass]) => Some((mass, [0.0; 3], [0.0; 6])),
            Some(&[mass, x, y, z]) => Some((mass, [x, y, z], [0.0; 6])),
            Some(&[mass, x, y, z, xx, yy, zz, xy, xz, yz]) => {
                Some((mass, [x, y, z], [xx, yy, zz, xy, xz, yz]))
            }
            _ => None,
        };
        let allowed = text!(
            "a mass from 0 to 1000 kg is needed, then perhaps the centre of gravity in m, up to 10, \
             as in 2.5 or 2.5,0,0,0.08, then perhaps six numbers of inertia in kg m²",
            "需要 0 到 1000 kg 的质量，之后可给出重心（m，不超过 10），如 2.5 或 2.5,0,0,0.08，再之后可给出六个惯量（kg m²）"
        );
        let (mass, cog, inertia) = payload.ok_or_else(|| allowed.clone())?;
        let payload = Payload::new(mass, cog, inertia).map_err(|error| match error {
            PayloadError::ImpossibleInertia { .. } => Text::of(&error),
            _ => allowed.clone(),
        })?;
        match CommandKind::Setting(SettingCommand::SetPayload(payload)).validate() {
            Ok(()) => Ok(Self(payload)),
            Err(_) => Err(allowed),
        }
    }
}

/// Finite numbers separated by commas.
fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',')
        .map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect()
}

fn six_numbers(text: &str) -> Option<[f64; 6]> {
    numbers(text)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn model_names_are_found_in_any_case_and_paths_are_kept() {
        assert_eq!("CS66".parse(), Ok(ModelChoice::BuiltIn("cs66")));
        assert_eq!(
            "./my.urdf".parse(),
            Ok(ModelChoice::Urdf("./my.urdf".into()))
        );
        let error = "cs99".parse::<ModelChoice>().unwrap_err();
        assert!(
            error.english().contains("cs612") && error.english().contains("URDF"),
            "{error}"
        );
    }

    #[test]
    fn the_step_is_one_to_eight_whole_milliseconds() {
        assert_eq!(
            "8".parse::<StepMillis>().map(StepMillis::as_secs),
            Ok(0.008)
        );
        for wrong in ["0", "9", "2.5", "-4", "four", ""] {
            assert!(wrong.parse::<StepMillis>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_payload_is_a_mass_with_or_without_its_centre_of_gravity() {
        let payload: PayloadChoice = "2.5, 0, -0.01, 0.08".parse().unwrap();
        assert_eq!(payload.0.mass, 2.5);
        assert_eq!(payload.0.cog.as_slice(), [0.0, -0.01, 0.08]);
        assert_eq!("1".parse::<PayloadChoice>().unwrap().0.mass, 1.0);
        let payload: PayloadChoice = "2,0,0,0.1,0.02,0.02,0.01,0,0,0.001".parse().unwrap();
        assert_eq!(payload.0.inertia, [0.02, 0.02, 0.01, 0.0, 0.0, 0.001]);
        let error = "2,0,0,0.1,1,0,0,0,0,0".parse::<PayloadChoice>();
        assert!(error.unwrap_err().english().contains("no rigid body"));
        for wrong in [
            "-1",
            "1,2",
            "1,2,3",
            "nan",
            "inf",
            "1,0,0,0,0",
            "",
            "1e300",
            "1,0,11,0",
        ] {
            assert!(wrong.parse::<PayloadChoice>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn home_needs_six_finite_numbers() {
        let home: HomeJoints = "-0.3,0,1e-1,+2, 3 ,4".parse().unwrap();
        assert_eq!(home.0.0, [-0.3, 0.0, 0.1, 2.0, 3.0, 4.0]);
        for wrong in [
            "0,0,0,0,0",
            "0,0,0,0,0,0,0",
            "0,0,0,0,0,nan",
            "0,0,0,0,0,1e300",
            "a",
            "--tcp",
        ] {
            assert!(wrong.parse::<HomeJoints>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_tcp_is_within_what_a_program_may_set() {
        let tcp: Tcp = "0,-10,0.1,0,0,7".parse().unwrap();
        assert_eq!(tcp.0.to_array(), [0.0, -10.0, 0.1, 0.0, 0.0, 7.0]);
        for wrong in [
            "1e300,0,0,0,0,0",
            "10.1,0,0,0,0,0",
            "0,0,0,1e9,0,0",
            "0,0,0,0,0",
        ] {
            let error = wrong.parse::<Tcp>().unwrap_err();
            assert!(error.english().contains("up to 10"), "{wrong}: {error}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
        #[test]
        fn six_written_numbers_are_read_back(q in proptest::array::uniform6(-1e3f64..1e3)) {
            let text = q.map(|x| x.to_string()).join(",");
            prop_assert_eq!(text.parse::<HomeJoints>().unwrap().0.0, q);
        }
    }
}
