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
use motion_api::ProgramId;
use recorder::{CellFiles, Recording, RecordingEntry, Setup, Topic};

/// The program and the robot of a recording; `given` is what `launch` says beside it.
///
/// # Errors
/// A sentence.
pub(super) fn open(
    path: &Path,
    given: &ControllerConfig,
) -> Result<(ProgramText, ControllerConfig), String> {
    let shown = path.display();
    let recording = Recording::open(path).map_err(|error| error.to_string())?;
    let setup = recording.setup().ok_or_else(|| {
        format!("{shown} does not say how the controller was started, it cannot be run again")
    })?;
    recording.check_files().map_err(|error| error.to_string())?;
    let robot = robot(setup, given).map_err(|why| format!("{shown} cannot be run again: {why}"))?;
    let entries = recording
        .entries(&[Topic::Script])
        .map_err(|error| error.to_string())?;
    for entry in entries {
        let (_, entry) = entry.map_err(|error| error.to_string())?;
        if let RecordingEntry::Script(script) = entry
            && let Some(text) = script.text
        {
            let name = script.program;
            return Ok((ProgramText { name, text }, robot));
        }
    }
    Err(format!("no program ran in {shown}"))
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
) -> Result<Option<RunTarget>, String> {
    let recording = Recording::open(path).map_err(|error| error.to_string())?;
    let run = match RecordedRun::read(&recording) {
        Ok(run) => run,
        Err(
            RecordedRunError::NoExternal | RecordedRunError::Beginning(InitialSetupError::NoSetup),
        ) => return Ok(None),
        Err(error) => return Err(error.to_string()),
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
            Some(number) => format!("{path} has {count} programs, there is no program {number}"),
            None => format!("no program ran in {path}"),
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

fn robot(setup: &Setup, given: &ControllerConfig) -> Result<ControllerConfig, String> {
    if setup.clock != "virtual" {
        return Err(
            "it was recorded under the real clock, where no two runs are the same".to_owned(),
        );
    }
    if setup.powered_off {
        return Err("the arm was started without power, by people at its ports".to_owned());
    }
    if setup.part != 1 {
        return Err(format!("it is part {} of several files", setup.part));
    }
    let known = MODEL_NAMES.iter().find(|name| **name == setup.model);
    let model = match (known, &setup.urdf) {
        (Some(name), _) => ModelChoice::BuiltIn(name),
        (None, Some(urdf)) => {
            let path = PathBuf::from(&setup.model);
            same_text("model", &path, urdf)?;
            ModelChoice::Urdf(path)
        }
        (None, None) => return Err(format!("the model {} is not known", setup.model)),
    };
    match (&setup.cell, &given.cell) {
        (Some(text), Some(path)) => {
            same_text("cell", path, text)?;
            same_files(path, &setup.files)?;
        }
        (Some(_), None) => {
            return Err(
                "something stood around the arm: say cell, the path of its file".to_owned(),
            );
        }
        (None, Some(_)) => return Err("nothing stood around the arm: leave cell out".to_owned()),
        (None, None) => {}
    }
    let (cell, others) = (given.cell.clone(), given.clone());
    recorded_settings(setup, model, cell, others).map_err(|error| error.to_string())
}

/// Whether the files that a cell names are those of the recording.
fn same_files(cell: &Path, recorded: &CellFiles) -> Result<(), String> {
    let mut folder = mesh::Folder::new(cell.parent().unwrap_or(Path::new("")));
    for (path, content) in recorded {
        let there = folder
            .read(path, mesh::MAX_FILE_BYTES)
            .map_err(|error| format!("the file {path} of its cell cannot be read: {error}"))?;
        if there[..] != content[..] {
            return Err(format!("the file {path} of its cell has changed since"));
        }
    }
    Ok(())
}

fn same_text(what: &str, path: &Path, recorded: &str) -> Result<(), String> {
    let shown = path.display();
    let text = kinematics::text_file::read_text_file(path)
        .map_err(|error| format!("its {what} {shown} cannot be read: {error}"))?;
    match text == recorded {
        true => Ok(()),
        false => Err(format!("its {what} {shown} has changed since")),
    }
}
