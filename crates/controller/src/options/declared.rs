//! The options of a controller, each as it was given, and the settings that they make.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use elite_runtime::SandboxRoots;
use kinematics::{Calibration, CalibrationError};
use messages::{Localized, LocalizedHelp, Text};
use thiserror::Error;

use super::slot::OptionSlot;
use super::values::{
    ByteSize, ClockChoice, HomeJoints, ModelChoice, PayloadChoice, Permission, PlantChoice,
    RecordTarget, RotationLimit, StepMillis, Tcp,
};
use crate::config::{ControllerConfig, read_text_within};

/// Options of a controller; `None` is one that was not given.
///
/// A field is an option of the command line, whose help is the field's comment; its key elsewhere is the field's name
/// with dashes.
#[derive(Args, Clone, Debug, Default, PartialEq, LocalizedHelp)]
#[command(next_help_heading = "Robot")]
pub struct ControllerOptions {
    /// The arm: cs63, cs66, cs612, cs616, cs620, cs625, or the path of a URDF file [default: cs66]
    #[zh("机械臂：cs63、cs66、cs612、cs616、cs620、cs625，或 URDF 文件的路径 [默认：cs66]")]
    #[arg(long)]
    pub model: Option<ModelChoice>,
    /// A TOML file with the lengths and twists measured of this very arm; without --model its own counts
    /// [default: as the model]
    #[zh(
        "含有这台机械臂实测长度和扭角的 TOML 文件；没有 --model 时以它的型号为准 [默认：同型号值]"
    )]
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// A TOML file that says what stands around the arm [default: nothing]
    #[zh("说明机械臂周围有什么的 TOML 文件 [默认：无]")]
    #[arg(long, value_name = "FILE")]
    pub cell: Option<PathBuf>,
    /// Wall time, or simulated time as fast as the machine can [default: realtime for serve, virtual for run]
    #[zh("实际时间，或尽机器所能的仿真时间 [默认：serve 为 realtime，run 为 virtual]")]
    #[arg(long, value_name = "realtime|virtual")]
    pub clock: Option<ClockChoice>,
    /// Length of a control cycle, 1 to 8 ms [default: 4]
    #[zh("控制周期的长度，1 到 8 ms [默认：4]")]
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub step_ms: Option<StepMillis>,
    /// Rigid bodies with contact, the same in the rapier engine, or an arm that is always where it should be
    /// [default: rigid]
    #[zh("带接触的刚体、用 rapier 引擎的刚体，或总在应处位置的机械臂 [默认：rigid]")]
    #[arg(long, value_name = "rigid|rapier|ideal")]
    pub plant: Option<PlantChoice>,
    /// Folder of the task files; names in scripts and commands cannot leave it [default: ./tasks]
    #[zh("任务文件夹；脚本和命令中的名称不能越出它 [默认：./tasks]")]
    #[arg(long, value_name = "PATH")]
    pub task_dir: Option<PathBuf>,
    /// The recording of every cycle [default: a new file in ./recordings for serve, off for run]
    #[zh("每个周期的记录 [默认：serve 为 ./recordings 中的新文件，run 为 off]")]
    #[arg(long, value_name = "PATH|off")]
    pub record: Option<RecordTarget>,
    /// Begin a new file of the recording at this size or after this time: 500MB, 8h [default: one file]
    #[zh("达到此大小或经过此时间后换新的记录文件：500MB、8h [默认：一个文件]")]
    #[arg(long, value_name = "SIZE|TIME")]
    pub record_rotate: Option<RotationLimit>,
    /// Keep this much of finished recordings, remove the oldest: files of this run, and with a new file in ./recordings
    /// those of earlier runs [default: all]
    #[zh(
        "保留这么多已完成的记录，删除最旧的：本次运行的文件，以及（记录为 ./recordings 中的新文件时）以前运行的文件 [默认：全部]"
    )]
    #[arg(long, value_name = "SIZE")]
    pub record_budget: Option<ByteSize>,
    /// Tool centre point from the flange, m and rad [default: 0,0,0,0,0,0]
    #[zh("从法兰到工具中心点，m 和 rad [默认：0,0,0,0,0,0]")]
    #[arg(long, value_name = "x,y,z,rx,ry,rz", allow_hyphen_values = true)]
    pub tcp: Option<Tcp>,
    /// Payload, its centre of gravity, and its inertia about that as Ixx,Iyy,Izz,Ixy,Ixz,Iyz: kg, m, kg m²
    /// [default: 0]
    #[zh("负载、其重心及绕重心的惯量 Ixx,Iyy,Izz,Ixy,Ixz,Iyz：kg、m、kg m² [默认：0]")]
    #[arg(long, value_name = "kg[,cx,cy,cz[,Ixx,…]]", allow_hyphen_values = true)]
    pub payload: Option<PayloadChoice>,
    /// Joint positions at start, rad [default: 0,-1.5708,1.5708,-1.5708,-1.5708,0]
    #[zh("开始时的关节位置，rad [默认：0,-1.5708,1.5708,-1.5708,-1.5708,0]")]
    #[arg(long, value_name = "q1,…,q6", allow_hyphen_values = true)]
    pub home: Option<HomeJoints>,
    /// Seed of random() and of every simulated noise [default: 0]
    #[zh("random() 和所有仿真噪声的种子 [默认：0]")]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// What scripts may reach beyond the robot; repeat it for more, the list replaces the default [default: net]
    ///
    /// net: connections to and from anywhere. net=played: to machines that a test plays, and no others. fs: every file
    /// that this user may read or write, nothing is held back. fs=DIR: the files beneath that folder only, no link
    /// leads out of it; relative paths count from it. process: programs of this user, which reach files and network
    /// themselves. env: environment variables.
    #[zh(
        "脚本除机器人之外可以使用什么；可重复给出，所给的列表取代默认值 [默认：net]",
        long = "脚本除机器人之外可以使用什么；可重复给出，所给的列表取代默认值 [默认：net]\n\n\
                net：与任何地方建立连接。net=played：只与测试所扮演的机器连接。fs：此用户可以读写的所有文件，不作限制。fs=DIR：只限该文件夹之内的文件，链接也不能越出；相对路径从它算起。\
                process：以此用户运行的程序，它们自己可以使用文件和网络。env：环境变量。"
    )]
    #[arg(long, value_name = "fs|fs=DIR|process|env|net|net=played")]
    pub allow: Option<Vec<Permission>>,
}

/// A reason why options make no settings: one sentence.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum OptionsError {
    /// The calibration file is not usable, or for another model.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The calibration file is of an arm that is none of ours.
    #[error("{}: `model` is {given:?}; {allowed}", path.display())]
    #[zh("{}：`model` 为 {given:?}；{allowed}", path.display())]
    CalibratedModel {
        /// The calibration file.
        path: PathBuf,
        /// The model that it names.
        given: String,
        /// What is allowed.
        allowed: Text,
    },
}

impl ControllerOptions {
    /// The option of this key; `None` for a key that no option has.
    pub fn slot(&mut self, key: &str) -> Option<&mut dyn OptionSlot> {
        Some(match key {
            "model" => &mut self.model,
            "calibration" => &mut self.calibration,
            "cell" => &mut self.cell,
            "clock" => &mut self.clock,
            "step-ms" => &mut self.step_ms,
            "plant" => &mut self.plant,
            "task-dir" => &mut self.task_dir,
            "record" => &mut self.record,
            "record-rotate" => &mut self.record_rotate,
            "record-budget" => &mut self.record_budget,
            "tcp" => &mut self.tcp,
            "payload" => &mut self.payload,
            "home" => &mut self.home,
            "seed" => &mut self.seed,
            "allow" => &mut self.allow,
            _ => return None,
        })
    }

    /// The keys of the options that were given, in the order in which they are declared.
    pub fn given_keys(&self) -> Vec<String> {
        let mut options = self.clone();
        let mut keys = keys_of::<Self>();
        keys.retain(|key| options.slot(key).is_some_and(|slot| slot.is_given()));
        keys
    }

    /// The settings of a robot: what was given over `defaults`. The calibration file is read; with `within` it, and
    /// every file that is opened later, must be beneath those folders, links followed.
    ///
    /// # Errors
    /// [`OptionsError`]
    pub fn resolve(
        self,
        defaults: ControllerConfig,
        within: Option<&SandboxRoots>,
    ) -> Result<ControllerConfig, OptionsError> {
        let calibration = self.read_calibration(within)?;
        let model = match (&calibration, self.model) {
            (Some(calibration), asked) => model_of(calibration, asked.as_ref())?,
            (None, asked) => asked.unwrap_or(defaults.model),
        };
        Ok(ControllerConfig {
            model,
            calibration,
            cell: self.cell.or(defaults.cell),
            clock: self.clock.unwrap_or(defaults.clock),
            step: self.step_ms.unwrap_or(defaults.step),
            plant: self.plant.unwrap_or(defaults.plant),
            task_dir: self.task_dir.unwrap_or(defaults.task_dir),
            record: self.record.unwrap_or(defaults.record),
            record_rotate: self.record_rotate.or(defaults.record_rotate),
            record_budget: self.record_budget.or(defaults.record_budget),
            tcp: self.tcp.map_or(defaults.tcp, |Tcp(pose)| pose),
            payload: self.payload.map_or(defaults.payload, |given| given.0),
            home: self.home.map_or(defaults.home, |HomeJoints(q)| q),
            seed: self.seed.unwrap_or(defaults.seed),
            allow: self.allow.map_or(defaults.allow, BTreeSet::from_iter),
            sandbox: within.cloned(),
            cycle_phase: defaults.cycle_phase,
        })
    }

    fn read_calibration(
        &self,
        within: Option<&SandboxRoots>,
    ) -> Result<Option<Calibration>, CalibrationError> {
        let Some(path) = self.calibration.as_deref() else {
            return Ok(None);
        };
        let text =
            read_text_within(within, path).map_err(|source| CalibrationError::Unreadable {
                path: path.to_owned(),
                source,
            })?;
        Calibration::from_text(&text, path).map(Some)
    }
}

/// The model of a calibration, which must be the one that was asked for.
fn model_of(
    calibration: &Calibration,
    asked: Option<&ModelChoice>,
) -> Result<ModelChoice, OptionsError> {
    let asked = asked.map(ToString::to_string);
    let name = calibration.model_for(asked.as_deref())?;
    name.parse()
        .map_err(|allowed| OptionsError::CalibratedModel {
            path: calibration.path().to_owned(),
            given: name.to_owned(),
            allowed,
        })
}

/// The keys of options, in the order in which they are declared: their long names on the command line.
pub fn keys_of<O: Args>() -> Vec<String> {
    let command = O::augment_args(clap::Command::new(""));
    let names = command.get_arguments().filter_map(clap::Arg::get_long);
    names.map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_has_its_slot() {
        let mut options = ControllerOptions::default();
        let keys = keys_of::<ControllerOptions>();
        assert!(keys.iter().any(|key| key == "record-budget"), "{keys:?}");
        for key in keys {
            assert!(options.slot(&key).is_some(), "{key}");
        }
        assert!(options.slot("speed").is_none());
    }

    #[test]
    fn who_comes_first_counts_and_what_is_wrong_is_refused_all_the_same() {
        let mut options = ControllerOptions::default();
        let mut fill = |key: &str, texts: &[&str]| {
            let texts: Vec<String> = texts.iter().map(|text| (*text).to_owned()).collect();
            options.slot(key).unwrap().fill(&texts)
        };
        fill("seed", &["7"]).unwrap();
        fill("seed", &["8"]).unwrap();
        let refused = fill("seed", &["-1"]).unwrap_err();
        assert!(refused.allowed.english().contains("from 0"), "{refused:?}");
        assert!(fill("model", &["cs63", "cs66"]).is_err());
        let refused = fill("allow", &["fs", "all"]).unwrap_err();
        assert_eq!(refused.given, "all");
        assert_eq!(options.seed, Some(7));
        assert_eq!(options.allow, None);
    }

    #[test]
    fn what_is_not_given_is_as_in_the_defaults() {
        let defaults = ControllerConfig {
            seed: 3,
            clock: ClockChoice::Realtime,
            ..ControllerConfig::default()
        };
        let options = ControllerOptions {
            seed: Some(4),
            ..ControllerOptions::default()
        };
        let config = options.resolve(defaults.clone(), None).unwrap();
        assert_eq!(config.seed, 4);
        assert_eq!(ControllerConfig { seed: 3, ..config }, defaults);
    }
}
