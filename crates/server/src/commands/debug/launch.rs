//! What is to be debugged and on which robot, whether an editor's `launch` says it or the command line.

use std::path::{Path, PathBuf};

use controller::options::{ClockChoice, ControllerOptions, keys_of};
use editor::dap::RunTarget;
use elite_runtime::Preset;
use elite_syntax::nearest;
use messages::{Text, text};
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
    pub(super) fn from_args(args: &DebugArgs, file: &Path) -> Result<Self, Text> {
        let robot = &args.robot;
        let number = match robot.number {
            Some(0) => {
                return Err(text!(
                    "--number is 0; it says which program of the recording, from 1",
                    "--number 为 0；它指定记录中的第几个程序，从 1 起"
                ));
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
    pub(super) fn from_json(arguments: &Json) -> Result<Self, Text> {
        let needed = text!(
            "launch needs program, the path of a script",
            "launch 需要 program，即脚本的路径"
        );
        let fields = arguments.as_object().ok_or(needed.clone())?;
        let number = match fields.get("number") {
            None | Some(Json::Null) => None,
            Some(given) => Some(given.as_u64().filter(|n| *n > 0).ok_or_else(|| {
                text!(
                    "number is {given}; it says which program of the recording, from 1",
                    "number 为 {given}；它指定记录中的第几个程序，从 1 起"
                )
            })?),
        };
        let source = match (fields.get("program"), fields.get("recording")) {
            (Some(_), Some(_)) => {
                return Err(text!(
                    "give either program or recording: a recording has its own program",
                    "只能给出 program 或 recording 之一：记录有自己的程序"
                ));
            }
            (_, Some(path)) => LaunchSource::Recording {
                path: path
                    .as_str()
                    .ok_or(text!(
                        "recording is the path of a recording",
                        "recording 是记录的路径"
                    ))?
                    .into(),
                number,
            },
            (Some(Json::String(path)), None) if path == "-" => {
                return Err(text!(
                    "program is the path of a script; standard input is the client's",
                    "program 是脚本的路径；标准输入属于客户端"
                ));
            }
            (Some(Json::String(_)), None) if number.is_some() => {
                return Err(number_beside_script("number"));
            }
            (Some(Json::String(path)), None) => LaunchSource::Program(path.into()),
            _ => return Err(needed),
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
            Some(other) => {
                return Err(text!(
                    "config is {other}; the path of a file is needed",
                    "config 为 {other}；需要文件的路径"
                ));
            }
        };
        Ok(Self {
            source,
            args,
            presets: fields.get("set").map(presets).transpose()?,
        })
    }

    /// The program and the robot. Files are read, and nothing is started.
    pub(super) fn target(&self) -> Result<RunTarget, Text> {
        if let LaunchSource::Recording { .. } = self.source {
            self.check_beside_recording()?;
        }
        let config = RunConfig::load(RunArgs {
            file: "-".into(),
            set: self.presets.clone().unwrap_or_default(),
            shared: self.args.clone(),
        });
        let config = config.map_err(|error| Text::of(&error))?;
        if config.robot.clock == ClockChoice::Realtime {
            return Err(text!(
                "the debugger runs programs under the virtual clock only; leave clock out",
                "调试器只在虚拟时钟下运行程序；请去掉 clock"
            ));
        }
        match &self.source {
            LaunchSource::Program(path) => Ok(RunTarget {
                program: read_script(path).map_err(|text| Text::of(&text))?,
                robot: config.robot,
                presets: config.presets,
                recorded: None,
            }),
            LaunchSource::Recording { path, number } => self.recorded(path, *number, config),
        }
    }

    /// Refuses what the recording says itself.
    fn check_beside_recording(&self) -> Result<(), Text> {
        let given = self.args.options.given_keys();
        let config = self.args.config.iter().map(|_| "config".to_owned());
        let said = |key: &String| !RECORDING_KEYS.contains(&key.as_str());
        match given.into_iter().chain(config).find(said) {
            Some(key) => Err(text!(
                "{key} is in the recording; beside it there may be {}",
                "{key} 已在记录中；此外可以给出 {}",
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
    ) -> Result<RunTarget, Text> {
        // Who says what programs may reach, or what else is different, wants the program to run anew.
        let is_anew = self.presets.is_some() || !self.args.options.given_keys().is_empty();
        if !is_anew && let Some(found) = recording::repeated(path, number, &config.robot)? {
            return Ok(found);
        }
        if number.is_some_and(|number| number > 1) {
            return Err(text!(
                "only the first program of a recording can be run anew: leave number out",
                "只有记录的第一个程序可以重新运行：请去掉 number"
            ));
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
fn number_beside_script(option: &str) -> Text {
    text!(
        "{option} is for recordings: it says which program of one",
        "{option} 用于记录：它指定其中的第几个程序"
    )
}

/// Sets the option of a key.
fn fill(options: &mut ControllerOptions, key: &str, value: &Json) -> Result<(), Text> {
    if REFUSED_KEYS.contains(&key) {
        return Err(text!(
            "{key} means nothing to the debugger",
            "{key} 对调试器没有意义"
        ));
    }
    let Some(slot) = options.slot(key) else {
        let keys = keys_of::<ControllerOptions>();
        let near = nearest(key, keys.iter().chain(&OWN_KEYS.map(str::to_owned)));
        let near = near.map_or(Text::fixed("", ""), |near| {
            text!(", but {near}", "，但有 {near}")
        });
        return Err(text!(
            "launch knows no key {key}{near}; there are the options of run, without their dashes",
            "launch 没有键 {key}{near}；可用 run 的选项，不带短横线"
        ));
    };
    fill_from_json(slot, value).map_err(|refused| {
        text!(
            "{key} is '{}': {}",
            "{key} 为 '{}'：{}",
            refused.given,
            refused.allowed
        )
    })
}

/// `"set": {"speed": 0.25}` or `"set": ["speed=0.25"]`.
fn presets(set: &Json) -> Result<Vec<Preset>, Text> {
    match set {
        Json::Null => Ok(Vec::new()),
        Json::Object(values) => values
            .iter()
            .map(|(name, value)| {
                let preset = Preset::new(name, &literal(value));
                preset.map_err(|error| text!("set: {name}: {}", "set：{name}：{}", error.why))
            })
            .collect(),
        Json::Array(items) => items
            .iter()
            .map(|item| {
                let text = plain_text(item);
                Preset::parse(&text)
                    .map_err(|error| text!("set is '{text}': {}", "set 为 '{text}'：{}", error.why))
            })
            .collect(),
        other => Err(text!(
            "set is {other}; an object of names and values is needed",
            "set 为 {other}；需要名称和值的对象"
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
            LaunchRequest::from_json(&fields).err().unwrap().to_string()
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
            Err(number_beside_script("number"))
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
