//! A recording as something to debug. The run is repeated, so that everything can be looked at, and in both directions.
//!
//! Where the recording has all that came from outside, that comes from it, whatever the clock and whoever started the
//! programs. Otherwise, or where the user says what is different now, the first program of a recording of `run` is run
//! anew on the robot that the recording describes; permissions, globals that were set and the cell file are then said
//! again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use controller::ControllerConfig;
use controller::options::{MODEL_NAMES, ModelChoice};
use controller::recorded_run::{InitialSetupError, RecordedRun, RecordedRunError};
use controller::start_configuration::recorded_settings;
use editor::dap::{RecordedProgram, RunTarget};
use elite_runtime::ProgramText;
use mesh::MeshFiles;
use messages::{Text, text};
use motion_api::ProgramId;
use recorder::{CellFiles, Recording, RecordingEntry, Setup, Topic};

/// The program and the robot of a recording; `given` is what `launch` says beside it.
///
/// # Errors
/// A sentence.
pub(super) fn open(
    path: &Path,
    given: &ControllerConfig,
) -> Result<(ProgramText, ControllerConfig), Text> {
    let shown = path.display();
    let recording = Recording::open(path).map_err(|error| Text::of(&error))?;
    let setup = recording.setup().ok_or_else(|| {
        text!(
            "{shown} does not say how the controller was started, it cannot be run again",
            "{shown} 没有说明控制器如何启动，不能重新运行"
        )
    })?;
    recording.check_files().map_err(|error| Text::of(&error))?;
    let robot = robot(setup, given).map_err(|why| {
        text!(
            "{shown} cannot be run again: {why}",
            "{shown} 不能重新运行：{why}"
        )
    })?;
    let entries = recording
        .entries(&[Topic::Script])
        .map_err(|error| Text::of(&error))?;
    for entry in entries {
        let (_, entry) = entry.map_err(|error| Text::of(&error))?;
        if let RecordingEntry::Script(script) = entry
            && let Some(text) = script.text
        {
            let name = script.program;
            return Ok((ProgramText { name, text }, robot));
        }
    }
    Err(text!("no program ran in {shown}", "{shown} 中没有程序运行"))
}

/// A program of a recorded run, with all that came to it; `None` where that is not in the recording and the program may
/// be run anew instead.
///
/// # Errors
/// A sentence.
pub(super) fn repeated(
    path: &Path,
    number: Option<u64>,
    given: &ControllerConfig,
) -> Result<Option<RunTarget>, Text> {
    let recording = Recording::open(path).map_err(|error| Text::of(&error))?;
    let run = match RecordedRun::read(&recording) {
        Ok(run) => run,
        Err(
            RecordedRunError::NoExternal | RecordedRunError::Beginning(InitialSetupError::NoSetup),
        ) => return Ok(None),
        Err(error) => return Err(Text::of(&error)),
    };
    if let Some(lost) = run.unrecorded_input() {
        return match run.setup().clock == "virtual" && !run.setup().powered_off {
            true => Ok(None),
            false => Err(lost),
        };
    }
    let programs: Vec<ProgramId> = run.programs().map(|(id, _)| id).collect();
    let index = number.map_or(0, |number| number - 1);
    let found = usize::try_from(index)
        .ok()
        .and_then(|index| programs.get(index));
    let Some(program) = found.copied() else {
        let (path, count) = (path.display(), programs.len());
        return Err(match number {
            Some(number) => text!(
                "{path} has {count} programs, there is no program {number}",
                "{path} 有 {count} 个程序，没有第 {number} 个程序"
            ),
            None => text!("no program ran in {path}", "{path} 中没有程序运行"),
        });
    };
    let text = run.program(program).cloned();
    Ok(text.map(|text| RunTarget {
        program: text,
        robot: given.clone(),
        presets: Vec::new(),
        recorded: Some(RecordedProgram {
            run: Arc::new(run),
            program,
        }),
    }))
}

fn robot(setup: &Setup, given: &ControllerConfig) -> Result<ControllerConfig, Text> {
    if setup.clock != "virtual" {
        return Err(text!(
            "it was recorded under the real clock, where no two runs are the same",
            "它是在真实时钟下记录的，每次运行都不相同"
        ));
    }
    if setup.powered_off {
        return Err(text!(
            "the arm was started without power, by people at its ports",
            "机械臂启动时没有上电，由人通过端口操作"
        ));
    }
    if setup.part != 1 {
        return Err(text!(
            "it is part {} of several files",
            "它是多个文件中的第 {} 部分",
            setup.part
        ));
    }
    let known = MODEL_NAMES.iter().find(|name| **name == setup.model);
    let model = match (known, &setup.urdf) {
        (Some(name), _) => ModelChoice::BuiltIn(name),
        (None, Some(urdf)) => {
            let path = PathBuf::from(&setup.model);
            same_text("model", &path, urdf)?;
            ModelChoice::Urdf(path)
        }
        (None, None) => {
            return Err(text!(
                "the model {} is not known",
                "没有型号 {}",
                setup.model
            ));
        }
    };
    match (&setup.cell, &given.cell) {
        (Some(text), Some(path)) => {
            same_text("cell", path, text)?;
            same_files(path, &setup.files)?;
        }
        (Some(_), None) => {
            return Err(text!(
                "something stood around the arm: say cell, the path of its file",
                "机械臂周围有物体：请给出 cell，即其文件的路径"
            ));
        }
        (None, Some(_)) => {
            return Err(text!(
                "nothing stood around the arm: leave cell out",
                "机械臂周围没有物体：请去掉 cell"
            ));
        }
        (None, None) => {}
    }
    let (cell, others) = (given.cell.clone(), given.clone());
    recorded_settings(setup, model, cell, others).map_err(|error| Text::of(&error))
}

/// Whether the files that a cell names are those of the recording.
fn same_files(cell: &Path, recorded: &CellFiles) -> Result<(), Text> {
    let mut folder = mesh::Folder::new(cell.parent().unwrap_or(Path::new("")));
    for (path, content) in recorded {
        let there = folder.read(path, mesh::MAX_FILE_BYTES).map_err(|error| {
            text!(
                "the file {path} of its cell cannot be read: {error}",
                "无法读取其单元的文件 {path}：{error}"
            )
        })?;
        if there[..] != content[..] {
            return Err(text!(
                "the file {path} of its cell has changed since",
                "其单元的文件 {path} 此后已改变"
            ));
        }
    }
    Ok(())
}

fn same_text(what: &str, path: &Path, recorded: &str) -> Result<(), Text> {
    let shown = path.display();
    let text = kinematics::text_file::read_text_file(path).map_err(|error| {
        text!(
            "its {what} {shown} cannot be read: {error}",
            "无法读取其 {what} {shown}：{error}"
        )
    })?;
    match text == recorded {
        true => Ok(()),
        false => Err(text!(
            "its {what} {shown} has changed since",
            "其 {what} {shown} 此后已改变"
        )),
    }
}
