//! A recorded run, read for its programs to be run again: their texts, what came to them from outside, and the commands
//! that move the arm meanwhile.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::Arc;

use elite_runtime::external::{ExternalInput, ExternalInputKind, Rerun};
use elite_runtime::{Preset, ProgramText};
use kinematics::{Calibration, CalibrationError, ModelError, RobotModel};
use messages::{Localized, Text, text};
use motion_api::ProgramId;
use recorder::{ArgumentError, CommandMessage, ReadError, Recording, RecordingEntry, Setup, Topic};
use thiserror::Error;

use crate::cell::{Cell, CellError};
use crate::cell_world::WorldInputs;
use crate::external_topic;
use crate::register_write::RegisterWrite;
use crate::start_configuration::{ROBOT, SetupError};

/// Most messages of `/external`, commands, and changes of registers that are read, and the bytes of the first.
const MESSAGES_MAX: usize = 20_000_000;
const BYTES_MAX: usize = 512 << 20;
/// Most missing cycles that are run; more are not worth waiting for.
const MISSING_MAX: u64 = 200_000;

/// A reason why the controller of a recording cannot be started with its setup.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum InitialSetupError {
    /// The recording does not say how the controller was started.
    #[error("the recording does not say how the controller was started, it cannot be run again")]
    #[zh("记录没有说明控制器是如何启动的，不能重新运行")]
    NoSetup,
    /// Something of the start is not known in this version.
    #[error("the recording cannot be run again in this version: {0}")]
    #[zh("此版本不能重新运行该记录：{0}")]
    Setup(#[from] SetupError),
    /// The recording does not begin with the controller's start.
    #[error("this is part {0} of a recording in several files; only the first can be run again")]
    #[zh("这是多文件记录的第 {0} 部分；只有第一部分可以重新运行")]
    Part(u32),
    /// A file of the cell is lost or damaged.
    #[error(transparent)]
    Files(ReadError),
}

/// How the controller of a recording was started, where that is known and was a controller of ours.
///
/// # Errors
/// [`InitialSetupError`]
pub fn initial_setup(recording: &Recording) -> Result<&Setup, InitialSetupError> {
    let setup = recording.setup().ok_or(InitialSetupError::NoSetup)?;
    if setup.part > 1 {
        return Err(InitialSetupError::Part(setup.part));
    }
    if setup.plant == ROBOT {
        return Err(SetupError::RemoteRobot.into());
    }
    recording.check_files().map_err(InitialSetupError::Files)?;
    Ok(setup)
}

/// A reason why the programs of a recording cannot be run again.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RecordedRunError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The controller cannot be started as it was.
    #[error(transparent)]
    Beginning(#[from] InitialSetupError),
    /// What came from outside was not recorded.
    #[error(
        "what came to its programs from outside is not in the recording: it was made by an earlier version"
    )]
    #[zh("记录中没有外部传给程序的内容：它由较早的版本生成")]
    NoExternal,
    /// A message is none.
    #[error(
        "message {number} of {} cannot be read: {reason}",
        external_topic::TOPIC
    )]
    #[zh("无法读取 {} 的第 {number} 条消息：{reason}", external_topic::TOPIC)]
    Message {
        /// Number of the message.
        number: usize,
        /// What is wrong with the message.
        reason: Text,
    },
    /// A recorded command is not one of this version.
    #[error("command {id} cannot be given again: {source}")]
    #[zh("命令 {id} 不能再次发出：{source}")]
    Command {
        /// Number of the command.
        id: u64,
        /// What is wrong with its arguments.
        source: ArgumentError,
    },
    /// More cycles are missing than can be run in a bearable time.
    #[error(
        "the recording has {recorded} cycles up to cycle {last}; at most {MISSING_MAX} missing ones are run"
    )]
    #[zh("到第 {last} 周期为止记录有 {recorded} 个周期；缺少的周期最多补运行 {MISSING_MAX} 个")]
    Gap {
        /// Number of cycles in the recording.
        recorded: u64,
        /// Number of the last cycle.
        last: u64,
    },
    /// The recording has more of something than is read.
    #[error("the recording has more of {what} than are run again ({most})")]
    #[zh("记录中的{what}多于可重新运行的数量（{most}）")]
    TooMany {
        /// Kind of the entries.
        what: Text,
        /// Most entries that are run again.
        most: usize,
    },
}

/// What makes the arm of a recording unusable.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RecordedModelError {
    /// The arm cannot be made.
    #[error("the arm of the recording cannot be made: {0}")]
    #[zh("无法构建记录中的机械臂：{0}")]
    Model(#[from] ModelError),
    /// What was measured of the arm does not fit it.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The cell file is none of this version's.
    #[error(transparent)]
    Cell(#[from] CellError),
}

/// A recorded run.
pub struct RecordedRun {
    pub(crate) setup: Setup,
    pub(crate) commands: VecDeque<CommandMessage>,
    pub(crate) writes: VecDeque<RegisterWrite>,
    programs: BTreeMap<ProgramId, ProgramText>,
    externals: Vec<ExternalInput>,
    pub(crate) world_inputs: WorldInputs,
    decoded: Vec<(u64, motion_api::Command)>,
    last_cycle: u64,
}

impl RecordedRun {
    /// Reads a recording.
    ///
    /// # Errors
    /// [`RecordedRunError`] says why its programs cannot be run again.
    pub fn read(recording: &Recording) -> Result<Self, RecordedRunError> {
        let mut run = Self {
            setup: initial_setup(recording)?.clone(),
            commands: VecDeque::new(),
            writes: VecDeque::new(),
            programs: BTreeMap::new(),
            externals: externals(recording)?,
            world_inputs: WorldInputs::read(recording)?,
            decoded: Vec::new(),
            last_cycle: 0,
        };
        let mut recorded = 0_u64;
        let topics = [Topic::Cycle, Topic::Command, Topic::Io, Topic::Script];
        for entry in recording.entries(&topics)? {
            match entry?.1 {
                RecordingEntry::Cycle(cycle) => {
                    recorded += 1;
                    run.last_cycle = run.last_cycle.max(cycle.cycle);
                }
                RecordingEntry::Command(command) => run.add_command(command)?,
                RecordingEntry::Io(change) => {
                    run.writes.extend(RegisterWrite::from_message(&change))
                }
                RecordingEntry::Script(script) => {
                    if let Some(text) = script.text {
                        let name = script.program;
                        let id = ProgramId(script.program_id);
                        run.programs.insert(id, ProgramText { name, text });
                    }
                }
                RecordingEntry::Log(_) | RecordingEntry::Variable(_) => {}
            }
            if run.commands.len() + run.writes.len() > MESSAGES_MAX {
                return Err(RecordedRunError::TooMany {
                    what: text!("commands and changes of registers", "命令和寄存器变化"),
                    most: MESSAGES_MAX,
                });
            }
        }
        let last = run.last_cycle;
        match last.saturating_sub(recorded) > MISSING_MAX {
            true => Err(RecordedRunError::Gap { recorded, last }),
            false => Ok(run),
        }
    }

    fn add_command(&mut self, message: CommandMessage) -> Result<(), RecordedRunError> {
        let wrong = |source| RecordedRunError::Command {
            id: message.id,
            source,
        };
        let are_points = message.to_points().map_err(wrong)?.is_some();
        if !are_points {
            let command = message.to_command().map_err(wrong)?;
            self.decoded.push((message.cycle, command));
        }
        self.commands.push_back(message);
        Ok(())
    }

    /// How the controller was started.
    pub const fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The programs that ran, in their order.
    pub fn programs(&self) -> impl Iterator<Item = (ProgramId, &ProgramText)> {
        let begun = self.externals.iter().filter_map(|external| {
            matches!(external.what, ExternalInputKind::Started { .. }).then_some(external.program)
        });
        begun.filter_map(|id| Some((id, self.programs.get(&id)?)))
    }

    /// The text of a program.
    pub fn program(&self, id: ProgramId) -> Option<&ProgramText> {
        self.programs.get(&id)
    }

    /// What of the programs is not in the recording, in a sentence; everything is where there is none.
    pub fn unrecorded_input(&self) -> Option<Text> {
        self.externals.iter().find_map(|external| match &external.what {
            ExternalInputKind::Unrecorded(text) => Some(text!(
"program {} cannot be repeated from cycle {} on: {text}, which is not in the recording",
"程序 {} 从第 {} 周期起不能重复：{text}，而记录中没有它",
                external.program.0, external.cycle
            )),
            _ => None,
        })
    }

    /// The globals that a program found set.
    pub fn presets(repeat: &Rerun, program: ProgramId) -> Vec<Preset> {
        let given = repeat.presets(program).into_iter();
        // Written by us; one that is none shows in the program that misses it.
        given
            .filter_map(|given| Preset::parse(&given).ok())
            .collect()
    }

    /// The rerun for the tasks of one repetition.
    pub fn repeat(&self) -> Arc<Rerun> {
        let is_real = self.setup.clock != "virtual";
        let externals = self.externals.iter().cloned();
        let commands = self.decoded.iter().copied();
        Arc::new(Rerun::new(is_real, self.last_cycle, externals, commands))
    }
}

fn externals(recording: &Recording) -> Result<Vec<ExternalInput>, RecordedRunError> {
    let mut externals: Vec<ExternalInput> = Vec::new();
    let (mut bytes, mut last, mut has_programs) = (0, 0, false);
    for message in recording.messages()? {
        has_programs |= message.channel.topic == recorder::Topic::Script.name();
        if message.channel.topic != external_topic::TOPIC {
            continue;
        }
        bytes += message.data.len();
        if bytes > BYTES_MAX || externals.len() >= MESSAGES_MAX {
            return Err(RecordedRunError::TooMany {
                what: text!(
                    "messages of /external, in number or bytes,",
                    "/external 消息（个数或字节）"
                ),
                most: MESSAGES_MAX,
            });
        }
        let number = externals.len() + 1;
        let (given, external) = external_topic::read(&message.data)
            .map_err(|reason| RecordedRunError::Message { number, reason })?;
        if given != last + 1 {
            let text = text!(
                "the recording did not keep up and dropped messages",
                "记录跟不上，丢弃了消息"
            );
            externals.push(ExternalInput {
                what: ExternalInputKind::Unrecorded(text),
                ..external.clone()
            });
        }
        last = given;
        externals.push(external);
    }
    match has_programs && externals.is_empty() {
        true => Err(RecordedRunError::NoExternal),
        false => Ok(externals),
    }
}

/// The arm of a recording: the URDF it carries, or the built-in model it names, with what was measured of it.
///
/// # Errors
/// [`RecordedModelError`]
pub fn model_of(setup: &Setup) -> Result<RobotModel, RecordedModelError> {
    let model = match &setup.urdf {
        Some(urdf) => RobotModel::from_urdf(urdf),
        None => RobotModel::built_in(&setup.model),
    }?;
    let Some(text) = &setup.calibration else {
        return Ok(model);
    };
    let calibration = Calibration::from_text(text, Path::new("the recorded calibration"))?;
    Ok(model.calibrated(&calibration)?)
}

/// The cell of a recording.
///
/// # Errors
/// It is none of this version's.
pub fn cell_of(setup: &Setup) -> Result<Option<Cell>, CellError> {
    Cell::of_recording(setup)
}
