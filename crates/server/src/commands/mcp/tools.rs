//! The tools of the server: names, texts, schemas of their arguments, and how arguments are read.

use std::sync::Arc;

use rmcp::handler::server::tool::schema_for_input;
use rmcp::model::{JsonObject, Tool as Declared, ToolAnnotations};
use rmcp::schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;

use super::workspace::{CancelFlag, Workspace};
use super::{builtins, paths, programs, recordings, test_tool};

/// What a tool has to say.
#[derive(Debug, Default)]
pub(super) struct ToolOutput {
    /// The answer for people and models.
    pub text: String,
    /// The answer for programs.
    pub structured: Option<Json>,
    /// A picture.
    pub png: Option<Vec<u8>>,
}

impl ToolOutput {
    pub(super) fn text(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }
}

/// A tool.
pub(super) struct ToolSpec {
    pub name: &'static str,
    title: &'static str,
    about: &'static str,
    /// Nothing is changed by calling it.
    only_reads: bool,
    schema: fn() -> Result<Arc<JsonObject>, String>,
    /// An error is a sentence for whoever has called.
    pub call: fn(&Workspace, JsonObject, &CancelFlag) -> Result<ToolOutput, String>,
}

impl ToolSpec {
    /// The tool in the form that clients are told of.
    pub(super) fn declared(&self) -> Declared {
        let hints = ToolAnnotations::with_title(self.title)
            .read_only(self.only_reads)
            .destructive(false)
            .idempotent(true)
            .open_world(false);
        // Every schema is made in a test.
        let schema = (self.schema)().unwrap_or_default();
        Declared::new(self.name, self.about, schema)
            .with_title(self.title)
            .with_annotations(hints)
    }
}

/// Calls a function with arguments of its own type.
macro_rules! tool {
    ($name:literal, $title:literal, $reads:literal, $arguments:ty, $call:path, $about:literal) => {
        ToolSpec {
            name: $name,
            title: $title,
            about: $about,
            only_reads: $reads,
            schema: schema_of::<$arguments>,
            call: |workspace, arguments, stop| {
                $call(workspace, arguments_of::<$arguments>(arguments)?, stop)
            },
        }
    };
}

/// All of them.
pub(super) fn all() -> &'static [ToolSpec] {
    const TOOLS: &[ToolSpec] = &[
        tool!(
            "builtin",
            "Look up functions of the robot",
            true,
            builtins::BuiltinArguments,
            builtins::builtin,
            "Functions of the script language: the full text of one (signature, units, ranges, defaults, what comes \
             back, section of the manual), or those that fit a search. Without arguments all names by category."
        ),
        tool!(
            "check",
            "Check a program",
            true,
            programs::CheckArguments,
            programs::check,
            "Parses and checks a program without running it: syntax, unknown names, arguments out of range, degrees \
             where radians are meant, loops that never wait. Findings have line, column, and often the right \
             spelling."
        ),
        tool!(
            "run",
            "Run a program on a simulated arm",
            false,
            programs::RunArguments,
            programs::run,
            "Runs a program to its end on a simulated arm in simulated time, and tells how it ended, what it \
             printed, errors with their lines, where the arm is, peaks of speed and force. With `record` every \
             cycle is written to a recording for the replay tools. Programs reach no network and, without `files`, \
             no file."
        ),
        tool!(
            "test",
            "Run tests of programs",
            false,
            test_tool::TestArguments,
            test_tool::test,
            "Runs test functions (def test_…():) of files test_*.script and *_test.script, each on a simulated arm \
             of its own. In a test the object `test` starts programs, sets inputs, plays machines on the network \
             and checks what happened."
        ),
        tool!(
            "clearance",
            "How near a program comes to anything",
            true,
            paths::ClearanceArguments,
            paths::clearance,
            "Runs a program on an ideal arm that contacts do not stop and tells for every motion the least distance of \
             links, tool and what is held to everything in the cell file and to the arm itself: which two, where, \
             when, in which line. Negative distances are depths of collisions."
        ),
        tool!(
            "plan_path",
            "A path around what is in the way",
            true,
            paths::PlanArguments,
            paths::plan_path,
            "Finds joint positions between a start and a target that keep a distance from everything in the cell file, \
             and writes them as a program of movej with blends that was driven on a simulated arm. Where there is no \
             path it says why: what touches, out of reach, what was in the way."
        ),
        tool!(
            "replay_summary",
            "Summary of a recording",
            true,
            recordings::SummaryArguments,
            recordings::summary,
            "What a recording holds: duration, programs, commands, errors, protective stops, limits that were \
             reached, peaks of speed, torque and force; optionally the program with when each line ran."
        ),
        tool!(
            "replay_at",
            "State at one moment",
            true,
            recordings::AtArguments,
            recordings::at,
            "Everything that is known of one moment of a recording: line of the script, command, joints, TCP, \
             speeds, torques, forces, inputs and outputs."
        ),
        tool!(
            "replay_find",
            "When a condition held",
            true,
            recordings::FindArguments,
            recordings::find,
            "When a condition held in a recording, where the script was then and where the arm. Conditions are \
             expressions over the fields of a cycle: norm(tcp_force[0:3]) > 20, safety_mode != normal, \
             actual_q[1] < -1.5 and line == 7."
        ),
        tool!(
            "replay_plot",
            "Picture of a recording",
            true,
            recordings::PlotArguments,
            recordings::plot,
            "A picture (PNG) of joint positions, speeds, accelerations, torques and force over time, with lines and \
             commands marked."
        ),
    ];
    TOOLS
}

fn schema_of<T: JsonSchema + 'static>() -> Result<Arc<JsonObject>, String> {
    schema_for_input::<T>()
}

/// The arguments of a call; a sentence names the one that is wrong.
fn arguments_of<T: DeserializeOwned>(arguments: JsonObject) -> Result<T, String> {
    serde_path_to_error::deserialize(Json::Object(arguments)).map_err(|error| {
        let place = error.path().to_string();
        match place.as_str() {
            "." => error.inner().to_string(),
            place => format!("{place}: {}", error.inner()),
        }
    })
}

/// A number of an argument within its bounds.
pub(super) fn within(
    name: &str,
    given: Option<f64>,
    default: f64,
    least: f64,
    most: f64,
) -> Result<f64, String> {
    match given {
        None => Ok(default),
        Some(number) if (least..=most).contains(&number) => Ok(number),
        Some(number) => Err(format!(
            "{name} is {number}; allowed are numbers from {least} to {most}"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tool_has_a_schema_whose_arguments_are_explained_and_no_others_allowed() {
        for tool in all() {
            let schema = (tool.schema)().unwrap();
            assert_eq!(schema["type"], "object", "{}", tool.name);
            assert_eq!(schema["additionalProperties"], false, "{}", tool.name);
            for (name, property) in schema["properties"].as_object().unwrap() {
                let text = property["description"].as_str().unwrap_or_default();
                assert!(text.len() > 10, "{}: {name}: {property}", tool.name);
            }
        }
    }

    #[test]
    fn wrong_arguments_are_named() {
        let wrong = |value: Json| {
            let Json::Object(arguments) = value else {
                panic!("no object");
            };
            arguments_of::<programs::RunArguments>(arguments).unwrap_err()
        };
        let sentence = wrong(serde_json::json!({"home": [0, 1]}));
        assert!(sentence.starts_with("home"), "{sentence}");
        let sentence = wrong(serde_json::json!({"time": "long"}));
        assert!(sentence.starts_with("time: invalid type"), "{sentence}");
        let sentence = wrong(serde_json::json!({"speed": 1}));
        assert!(sentence.contains("unknown field `speed`"), "{sentence}");
    }
}
