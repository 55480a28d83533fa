//! The tools `replay_…`: what `eliteserver replay` answers about a recording.

use std::io::{self, Write};
use std::sync::atomic::Ordering;

use editor::analysis::words::Language;
use recorder::Recording;
use rmcp::schemars::JsonSchema;
use serde::Deserialize;

use super::tools::ToolOutput;
use super::workspace::{CancelFlag, Workspace};
use crate::commands::replay::{Question, answer_of, picture};
use crate::ports::escape::EscapingWriter;

/// Longest answer, bytes; what comes after it is not worked out.
const ANSWER_BYTES_MAX: usize = 150_000;

/// Arguments of `replay_summary`.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct SummaryArguments {
    /// The path of the recording: arm.mcap
    recording: String,
    /// Add the programs, with when each line ran, how often and how long (default false)
    #[serde(default)]
    script: bool,
}

/// Arguments of `replay_at`.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct AtArguments {
    /// The path of the recording: arm.mcap
    recording: String,
    /// The moment, in seconds of the recording
    time: f64,
}

/// Arguments of `replay_find`.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct FindArguments {
    /// The path of the recording: arm.mcap
    recording: String,
    /// An expression: norm(tcp_force[0:3]) > 20
    condition: String,
}

/// Arguments of `replay_plot`.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct PlotArguments {
    /// The path of the recording: arm.mcap
    recording: String,
}

pub(super) fn summary(
    workspace: &Workspace,
    arguments: SummaryArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let recording = workspace.recording(&arguments.recording, stop)?;
    let mut text = answered(&recording, &Question::Summary, stop)?;
    if arguments.script {
        text.push_str(&answered(&recording, &Question::Script, stop)?);
    }
    Ok(ToolOutput::text(text))
}

pub(super) fn at(
    workspace: &Workspace,
    arguments: AtArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let recording = workspace.recording(&arguments.recording, stop)?;
    let question = Question::At(arguments.time);
    Ok(ToolOutput::text(answered(&recording, &question, stop)?))
}

pub(super) fn find(
    workspace: &Workspace,
    arguments: FindArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let recording = workspace.recording(&arguments.recording, stop)?;
    let question = Question::Find(arguments.condition);
    Ok(ToolOutput::text(answered(&recording, &question, stop)?))
}

pub(super) fn plot(
    workspace: &Workspace,
    arguments: PlotArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let recording = workspace.recording(&arguments.recording, stop)?;
    let png = picture(&recording);
    let ending = recording_note(&recording);
    check_running(stop)?;
    Ok(ToolOutput {
        text: format!("{}{ending}", recording.name()),
        structured: None,
        png: Some(png.map_err(|error| error.to_string())?),
    })
}

/// The answer to a question, as text for people.
fn answered(
    recording: &Recording,
    question: &Question,
    stop: &CancelFlag,
) -> Result<String, String> {
    let mut screen = EscapingWriter::new(TruncatingWriter::default());
    let answered = answer_of(recording, question, Language::English, &mut screen);
    let flushed = screen.flush();
    let beginning = screen.into_inner();
    check_running(stop)?;
    let mut text = String::from_utf8_lossy(&beginning.text).into_owned();
    match answered {
        // More than is told has been found.
        _ if beginning.is_full => text.push_str("\n[… the rest is left out …]\n"),
        Err(error) => return Err(error.to_string()),
        Ok(()) => flushed.map_err(|error| error.to_string())?,
    }
    text.push_str(&recording_note(recording));
    Ok(text)
}

fn recording_note(recording: &Recording) -> String {
    match recording.abnormal_end() {
        None | Some(recorder::FileEnd::Complete) => String::new(),
        Some(recorder::FileEnd::Truncated) => {
            "\n(the recording ends in the middle; the answer is about what is there)\n".to_owned()
        }
        Some(recorder::FileEnd::Damaged(reason)) => {
            format!(
                "\n(the recording is damaged, {reason}; the answer is about what comes before)\n"
            )
        }
    }
}

fn check_running(stop: &CancelFlag) -> Result<(), String> {
    match stop.load(Ordering::Relaxed) {
        true => Err("the call was cancelled".to_owned()),
        false => Ok(()),
    }
}

/// The beginning of a text; whoever writes more is told that nobody reads it.
#[derive(Default)]
struct TruncatingWriter {
    text: Vec<u8>,
    is_full: bool,
}

impl Write for TruncatingWriter {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let room = ANSWER_BYTES_MAX - self.text.len();
        let taken = data.len().min(room);
        self.text.extend_from_slice(&data[..taken]);
        if taken == 0 && !data.is_empty() {
            self.is_full = true;
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
