//! `eliteserver replay`: what a recording tells.
//!
//! Owns the questions of the command line and their answers on stdout. Reading the file is the recorder's business,
//! running it again that of [`motion`]; here they are put together.

mod csv;
mod diff;
mod error_line;
mod find;
mod plot;
mod programs;
pub mod rerun;
pub(crate) mod rosbag;
pub(crate) mod script;
mod serve;
mod state;
mod summary;

use std::io::{self, IsTerminal, Write};

use controller::recorded_run::model_of;
use messages::{Language, Localized, Text, text};
use recorder::{FileEnd, ReadError, Recording, Summary};
use thiserror::Error;

use crate::cli::ReplayArgs;
use crate::command::{CommandResult, CommandStatus};
use crate::language;
use crate::ports::escape::EscapingWriter;

pub use controller::condition::ConditionError;
pub use plot::PictureError;
pub use programs::{ProgramsComparison, ProgramsError, rerun_programs};
pub use rerun::{Comparison, RerunError};
pub use rosbag::BagError;
pub use serve::ServeRecordingError;

/// Characters of a sentence; what a file says of itself may be of any length.
const SENTENCE_CHARS: usize = 1000;

/// Exit status: 0 answered, 1 a cycle differs (`--rerun`), 2 the recording cannot be read or the question not answered.
pub fn replay(args: &ReplayArgs) -> CommandResult {
    let stdout = io::stdout();
    let mut out = io::BufWriter::new(stdout.lock());
    let mut notes = Vec::new();
    // A table for another program is passed on as it is; everything else is for people.
    let is_for_people = args.csv.is_none() || stdout.is_terminal();
    let (answered, flushed) = if is_for_people {
        let mut screen = EscapingWriter::new(out);
        let answered = answer_noting(args, language::chosen(), &mut screen, &mut notes);
        (answered, screen.flush())
    } else {
        let answered = answer_noting(args, Language::English, &mut out, &mut notes);
        (answered, out.flush())
    };
    // What was found before an error is shown, too.
    let flushed = flushed.map_err(ReplayError::from);
    for note in notes {
        language::say(&text!(
            "eliteserver: {}",
            "eliteserver: {}",
            printable(&note)
        ));
    }
    match answered.and_then(|status| flushed.map(|()| status)) {
        Ok(status) => Ok(status),
        // Whoever reads the answer has seen enough: `replay --csv /cycle | head`.
        Err(ReplayError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            Ok(CommandStatus::Success)
        }
        Err(error) => Err(printable(&error).into()),
    }
}

/// One sentence, whatever a file made of it.
fn printable(sentence: &impl Localized) -> Text {
    let [english, chinese] = [Language::English, Language::Chinese]
        .map(|language| printable_form(&sentence.in_language(language).to_string()));
    Text::new(english, chinese)
}

/// A form of a sentence. Lines stay: a condition is shown with its place marked.
fn printable_form(sentence: &str) -> String {
    let mut text = String::new();
    for c in sentence.chars().take(SENTENCE_CHARS) {
        match c {
            '\n' => text.push(c),
            c if c.is_control() => text.extend(c.escape_debug()),
            c => text.push(c),
        }
    }
    if sentence.chars().nth(SENTENCE_CHARS).is_some() {
        text.push('…');
    }
    text
}

/// A reason why a question about a recording has no answer.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// There is no state at that time.
    #[error("there is no state at {asked} s: {}", covered(*.range))]
    #[zh("{asked} s 处没有状态：{}", covered(*.range))]
    NoSuchTime {
        /// The time asked for, s.
        asked: f64,
        /// First and last time of the recording, s; `None` when it has no cycles.
        range: Option<(f64, f64)>,
    },
    /// The picture cannot be made.
    #[error(transparent)]
    Plot(#[from] PictureError),
    /// The condition of `--find` cannot be answered.
    #[error(transparent)]
    Condition(#[from] ConditionError),
    /// The recording cannot be run again.
    #[error(transparent)]
    Rerun(#[from] RerunError),
    /// There is no bag of the recording.
    #[error(transparent)]
    Bag(Box<rosbag::BagError>),
    /// The recording cannot be served.
    #[error(transparent)]
    Serve(Box<ServeRecordingError>),
    /// The answer cannot be written.
    #[error("cannot write the answer: {0}")]
    #[zh("无法写出回答：{0}")]
    Output(#[from] io::Error),
}

impl From<rosbag::BagError> for ReplayError {
    fn from(error: rosbag::BagError) -> Self {
        ReplayError::Bag(Box::new(error))
    }
}

impl From<ServeRecordingError> for ReplayError {
    fn from(error: ServeRecordingError) -> Self {
        ReplayError::Serve(Box::new(error))
    }
}

fn covered(range: Option<(f64, f64)>) -> Text {
    match range {
        Some((first, last)) => text!(
            "the recording covers {first:.3} s to {last:.3} s",
            "记录的范围是 {first:.3} s 到 {last:.3} s"
        ),
        None => text!("the recording has no cycles", "记录中没有周期"),
    }
}

/// Answers the question of the command line in English; returns the exit status.
///
/// # Errors
/// [`ReplayError`], a sentence for people.
pub fn answer(args: &ReplayArgs, out: &mut impl Write) -> Result<CommandStatus, ReplayError> {
    answer_noting(args, Language::English, out, &mut Vec::new())
}

/// Answers the question of the command line and adds further remarks to `notes`; returns the exit status.
fn answer_noting(
    args: &ReplayArgs,
    language: Language,
    out: &mut impl Write,
    notes: &mut Vec<Text>,
) -> Result<CommandStatus, ReplayError> {
    let recording = Recording::open(&args.file)?;
    // `--diff A B` and `A --diff B` mean the same; A is the one that was given first.
    let other = args.diff.as_ref().map(Recording::open).transpose()?;
    let status = answer_about(&recording, other.as_ref(), args, language, out)?;
    for recording in [Some(&recording), other.as_ref()].into_iter().flatten() {
        let path = recording.name().to_owned();
        match recording.abnormal_end() {
            None | Some(FileEnd::Complete) => {}
            Some(FileEnd::Truncated) => notes.push(text!(
                "{path} ends in the middle, its writer was killed or is still writing; the answer is about \
                 what is there",
                "{path} 在中间结束，写入程序被中止或仍在写入；回答依据已有的内容"
            )),
            Some(FileEnd::Damaged(reason)) => {
                let reason = reason.clone();
                return Err(ReadError::Damaged { path, reason }.into());
            }
        }
    }
    Ok(status)
}

/// What can be asked of one recording and is answered in text.
pub(crate) enum Question {
    /// The whole in figures.
    Summary,
    /// The state at a time, s.
    At(f64),
    /// The times when a condition held.
    Find(String),
    /// The programs and their lines.
    Script,
}

/// Answers a question about a recording.
///
/// # Errors
/// [`ReplayError`], a sentence for people.
pub(crate) fn answer_of(
    recording: &Recording,
    question: &Question,
    language: Language,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    match question {
        Question::At(time) => state::print(recording, *time, language, out),
        Question::Find(condition) => find::print(recording, condition, language, out),
        Question::Script => script::print(recording, language, out),
        Question::Summary => {
            let limits = recording
                .setup()
                .and_then(|setup| model_of(setup).ok())
                .map(|model| *model.limits());
            let summary = Summary::summarize(recording, limits.as_ref())?;
            Ok(summary::print(recording, &summary, language, out)?)
        }
    }
}

/// The recording as a picture, PNG.
///
/// # Errors
/// [`PictureError`]
pub(crate) fn picture(recording: &Recording) -> Result<Vec<u8>, PictureError> {
    plot::png(recording)
}

fn answer_about(
    recording: &Recording,
    other: Option<&Recording>,
    args: &ReplayArgs,
    language: Language,
    out: &mut impl Write,
) -> Result<CommandStatus, ReplayError> {
    if let Some(time) = args.at {
        answer_of(recording, &Question::At(time), language, out)?;
    } else if let Some(topic) = &args.csv {
        csv::print(recording, topic, out)?;
    } else if let Some(path) = &args.plot {
        plot::plot(recording, path, (args.from, args.to))?;
    } else if let Some(folder) = &args.rosbag2 {
        let cycles = rosbag::write_new(recording, folder)?;
        let said = text!(
            "{}: {cycles} cycles as a bag of ROS 2",
            "{}：{cycles} 个周期，写为 ROS 2 的 bag",
            folder.display()
        );
        writeln!(out, "{}", said.in_language(language))?;
    } else if let Some(condition) = &args.find {
        let question = Question::Find(condition.clone());
        answer_of(recording, &question, language, out)?;
    } else if args.script {
        answer_of(recording, &Question::Script, language, out)?;
    } else if let Some(other) = other {
        let report = diff::compare(recording, other)?;
        writeln!(out, "{}", report.in_language(language))?;
        return Ok(CommandStatus::of_answer(report.is_identical()));
    } else if args.serve {
        serve::serve(recording, args.rate, &args.ports)?;
    } else if args.rerun {
        let comparison = rerun::rerun(recording)?;
        return Ok(print_rerun(recording, &comparison, language, out)?);
    } else {
        answer_of(recording, &Question::Summary, language, out)?;
    }
    Ok(CommandStatus::Success)
}

/// What running the commands again showed, and then the programs; what differs first comes first.
fn print_rerun(
    recording: &Recording,
    arm: &Comparison,
    language: Language,
    out: &mut impl Write,
) -> io::Result<CommandStatus> {
    let of_arm = arm.in_language(language);
    let programs = match rerun_programs(recording) {
        Ok(ProgramsComparison::Identical { programs: 0, .. }) => {
            writeln!(out, "{of_arm}")?;
            return Ok(CommandStatus::of_answer(arm.is_identical()));
        }
        Ok(programs) => programs,
        Err(why) => {
            writeln!(out, "{of_arm}")?;
            let said = text!(
                "the programs were not run again: {why}",
                "没有重新运行程序：{why}"
            );
            writeln!(out, "{}", said.in_language(language))?;
            return Ok(CommandStatus::of_answer(arm.is_identical()));
        }
    };
    let is_first = match (arm.cycle(), programs.cycle()) {
        (Some(of_arm), Some(of_programs)) => of_programs < of_arm,
        _ => false,
    };
    let of_programs = programs.in_language(language);
    match is_first {
        true => writeln!(out, "{of_programs}\n{of_arm}")?,
        false => writeln!(out, "{of_arm}\n{of_programs}")?,
    }
    let is_identical = arm.is_identical() && programs.is_identical();
    Ok(CommandStatus::of_answer(is_identical))
}
