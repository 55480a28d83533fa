//! What is to be debugged and on which robot, whether an editor's `launch` says it or the command line.

use std::path::{Path, PathBuf};

use controller::options::{ClockChoice, ControllerOptions, keys_of};
use editor::dap::RunTarget;
use elite_runtime::Preset;
use elite_syntax::nearest;
use serde_json::Value as Json;

use super::{literal, recording};
use crate::cli::{ControllerArgs, DebugArgs, RunArgs};
use crate::commands::check::read_script;
use crate::config::RunConfig;
use crate::options::{fill_from_json, plain_text};

/// Keys of `launch` that are no options of the robot.
const OWN_KEYS: [&str; 7] = [
    "config",
    "number",
    "program",
    "recording",
    "set",
    "stopAtEnd",
    "stopOnEntry",
];

/// Keys that clients add to `launch` and `attach`, or may.
const CLIENT_KEYS: [&str; 9] = [
    "name",
    "type",
    "request",
    "cwd",
    "internalConsoleOptions",
    "preLaunchTask",
    "postDebugTask",
    "presentation",
    "noDebug",
];

/// Options that a recording does not hold.
const RECORDING_KEYS: [&str; 4] = ["allow", "cell", "record", "task-dir"];

/// Options of `run` that mean nothing here.
const REFUSED_KEYS: [&str; 5] = ["language", "log-dir", "log-format", "no-check", "timeout"];

/// Whether a key is a client's own.
pub(super) fn is_of_client(key: &str) -> bool {
    CLIENT_KEYS.contains(&key) || key.starts_with("__")
}

/// What is debugged.
enum LaunchSource {
    /// A script.
    Program(PathBuf),
    /// A program of a recording, by its number from 1.
    Recording { path: PathBuf, number: Option<u64> },
}

/// A program and the robot that it runs on, as they are asked for.
pub(super) struct LaunchRequest {
    source: LaunchSource,
    args: ControllerArgs,
    /// Globals that the program finds set; `None` where none were asked for.
    presets: Option<Vec<Preset>>,
}

impl LaunchRequest {
    /// From the command line.
    pub(super) fn from_args(args: &DebugArgs, file: &Path) -> Result<Self, String> {
        let robot = &args.robot;
        let number = match robot.number {
            Some(0) => {
                return Err(
                    "--number is 0; it says which program of the recording, from 1".to_owned(),
                );
            }
            number => number,
        };
        let is_recording = file.extension().is_some_and(|ending| ending == "mcap");
        let source = match (is_recording, number) {
            (true, number) => LaunchSource::Recording {
                path: file.to_owned(),
                number,
            },
            (false, None) => LaunchSource::Program(file.to_owned()),
            (false, Some(_)) => return Err(number_beside_script("--number")),
        };
        Ok(Self {
            source,
            args: ControllerArgs {
                config: robot.config.clone(),
                options: robot.options.clone(),
                ..ControllerArgs::default()
            },
            presets: (!robot.set.is_empty()).then(|| robot.set.clone()),
        })
    }

    /// From the arguments of an editor's `launch`, whose keys are the options of `run` without dashes before them.
    pub(super) fn from_json(arguments: &Json) -> Result<Self, String> {
        let needed = "launch needs program, the path of a script";
        let fields = arguments.as_object().ok_or(needed)?;
        let number = match fields.get("number") {
            None | Some(Json::Null) => None,
            Some(given) => Some(given.as_u64().filter(|n| *n > 0).ok_or_else(|| {
                format!("number is {given}; it says which program of the recording, from 1")
            })?),
        };
        let source = match (fields.get("program"), fields.get("recording")) {
            (Some(_), Some(_)) => {
                return Err(
                    "give either program or recording: a recording has its own program".to_owned(),
                );
            }
            (_, Some(path)) => LaunchSource::Recording {
                path: path
                    .as_str()
                    .ok_or("recording is the path of a recording")?
                    .into(),
                number,
            },
            (Some(Json::String(path)), None) if path == "-" => {
                return Err(
                    "program is the path of a script; standard input is the client's".to_owned(),
                );
            }
            (Some(Json::String(_)), None) if number.is_some() => {
                return Err(number_beside_script("number"));
            }
            (Some(Json::String(path)), None) => LaunchSource::Program(path.into()),
            _ => return Err(needed.to_owned()),
        };
        let mut args = ControllerArgs::default();
        for (key, value) in fields {
            if !OWN_KEYS.contains(&key.as_str()) && !is_of_client(key) {
                fill(&mut args.options, key, value)?;
            }
        }
        args.config = match fields.get("config") {
            None | Some(Json::Null) => None,
            Some(Json::String(path)) => Some(path.into()),
            Some(other) => return Err(format!("config is {other}; the path of a file is needed")),
        };
        Ok(Self {
            source,
            args,
            presets: fields.get("set").map(presets).transpose()?,
        })
    }

    /// The program and the robot. Files are read, and nothing is started.
    pub(super) fn target(&self) -> Result<RunTarget, String> {
        if let LaunchSource::Recording { .. } = self.source {
            self.check_beside_recording()?;
        }
        let config = RunConfig::load(RunArgs {
            file: "-".into(),
            set: self.presets.clone().unwrap_or_default(),
            shared: self.args.clone(),
        });
        let config = config.map_err(|error| error.to_string())?;
        if config.robot.clock == ClockChoice::Realtime {
            return Err(
                "the debugger runs programs under the virtual clock only; leave clock out"
                    .to_owned(),
            );
        }
        match &self.source {
            LaunchSource::Program(path) => Ok(RunTarget {
                program: read_script(path)?,
                robot: config.robot,
                presets: config.presets,
                recorded: None,
            }),
            LaunchSource::Recording { path, number } => self.recorded(path, *number, config),
        }
    }

    /// Refuses what the recording says itself.
    fn check_beside_recording(&self) -> Result<(), String> {
        let given = self.args.options.given_keys();
        let config = self.args.config.iter().map(|_| "config".to_owned());
        let said = |key: &String| !RECORDING_KEYS.contains(&key.as_str());
        match given.into_iter().chain(config).find(said) {
            Some(key) => Err(format!(
                "{key} is in the recording; beside it there may be {}",
                RECORDING_KEYS.join(", ")
            )),
            None => Ok(()),
        }
    }

    fn recorded(
        &self,
        path: &Path,
        number: Option<u64>,
        config: RunConfig,
    ) -> Result<RunTarget, String> {
        // Who says what programs may reach, or what else is different, wants the program to run anew.
        let is_anew = self.presets.is_some() || !self.args.options.given_keys().is_empty();
        if !is_anew && let Some(found) = recording::repeated(path, number, &config.robot)? {
            return Ok(found);
        }
        if number.is_some_and(|number| number > 1) {
            return Err(
                "only the first program of a recording can be run anew: leave number out"
                    .to_owned(),
            );
        }
        let (program, robot) = recording::open(path, &config.robot)?;
        Ok(RunTarget {
            program,
            robot,
            presets: config.presets,
            recorded: None,
        })
    }
}

/// The refusal of a number, by the name of its option, where a script is to be debugged.
fn number_beside_script(option: &str) -> String {
    format!("{option} is for recordings: it says which program of one")
}

/// Sets the option of a key.
fn fill(options: &mut ControllerOptions, key: &str, value: &Json) -> Result<(), String> {
    if REFUSED_KEYS.contains(&key) {
        return Err(format!("{key} means nothing to the debugger"));
    }
    let Some(slot) = options.slot(key) else {
        let keys = keys_of::<ControllerOptions>();
        let near = nearest(key, keys.iter().chain(&OWN_KEYS.map(str::to_owned)));
        let near = near.map_or_else(String::new, |near| format!(", but {near}"));
        return Err(format!(
            "launch knows no key {key}{near}; there are the options of run, without their dashes"
        ));
    };
    fill_from_json(slot, value)
        .map_err(|refused| format!("{key} is '{}': {}", refused.given, refused.allowed))
}

/// `"set": {"speed": 0.25}` or `"set": ["speed=0.25"]`.
fn presets(set: &Json) -> Result<Vec<Preset>, String> {
    match set {
        Json::Null => Ok(Vec::new()),
        Json::Object(values) => values
            .iter()
            .map(|(name, value)| {
                let preset = Preset::new(name, &literal(value));
                preset.map_err(|error| format!("set: {name}: {}", error.why))
            })
            .collect(),
        Json::Array(items) => items
            .iter()
            .map(|item| {
                let text = plain_text(item);
                Preset::parse(&text).map_err(|error| format!("set is '{text}': {}", error.why))
            })
            .collect(),
        other => Err(format!(
            "set is {other}; an object of names and values is needed"
        )),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn keys_are_named_as_the_request_has_them() {
        let said = |key: &str, value: Json| {
            let mut fields = json!({"program": "p.script"});
            fields[key] = value;
            LaunchRequest::from_json(&fields).err().unwrap()
        };
        let unknown = said("nonsens", json!(1));
        assert!(
            unknown.starts_with("launch knows no key nonsens;"),
            "{unknown}"
        );
        let near = said("modle", json!("cs66"));
        assert!(
            near.starts_with("launch knows no key modle, but model;"),
            "{near}"
        );
        let value = said("step-ms", json!(9));
        assert!(value.starts_with("step-ms is '9': "), "{value}");
        let choice = said("clock", json!("sundial"));
        assert!(
            choice.contains("clock is 'sundial': ") && choice.contains("virtual"),
            "{choice}"
        );
        let permission = said("allow", json!(["fs", "all"]));
        assert!(
            permission.starts_with("allow is 'all': allowed are fs"),
            "{permission}"
        );
        for text in [unknown, near, value, choice, permission] {
            assert!(!text.contains("--"), "{text}");
        }
    }

    #[test]
    fn a_script_has_no_number() {
        let said = |fields: Json| LaunchRequest::from_json(&fields).map(|_| ());
        assert_eq!(
            said(json!({"program": "p.script", "number": 2})),
            Err("number is for recordings: it says which program of one".to_owned())
        );
        assert_eq!(said(json!({"program": "p.script", "number": null})), Ok(()));
        assert_eq!(said(json!({"recording": "r.mcap", "number": 2})), Ok(()));
    }

    #[test]
    fn numbers_and_texts_are_as_good() {
        let request = LaunchRequest::from_json(&json!({
            "program": "p.script",
            "home": [0, -1.5, 0, 0, 0, 0.5],
            "tcp": "0,0,0.1,0,0,0",
            "allow": "fs",
            "seed": null,
            "set": {"speed": 0.25},
            "__session": 1,
        }));
        let request = request.unwrap();
        assert_eq!(request.args.options.given_keys(), ["tcp", "home", "allow"]);
        assert_eq!(request.presets.map(|presets| presets.len()), Some(1));
    }
}
