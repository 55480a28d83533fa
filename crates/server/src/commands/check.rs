//! `eliteserver check`: parses and checks scripts without running them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use controller::clearance::{
    ClearanceRun, LeastDistance, MeasureOptions, MeasuredEnd, TOUCHING, measure,
};
use controller::options::{ControllerOptions, ModelChoice};
use elite_runtime::ProgramText;
use elite_runtime::builtins::TOOL_LENGTH_MAX;
use elite_runtime::task_folder::is_xml;
use elite_syntax::{Diagnostic, KnownNames, Severity, SourceFile, Span};
use kinematics::{ModelError, RobotModel, RpyPose};
use messages::{Language, Text, text};
use serde_json::{Value as Json, json};

use crate::cli::{CheckArgs, ControllerArgs, FindingFormat, RunArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::run::SCRIPT_BYTES_MAX;
use crate::config::RunConfig;
use crate::language;
use crate::ports::escape::{EscapedLines, EscapedText, escaped};

/// Exit status: 0 clean, 1 findings (warnings count), 2 unreadable.
pub fn check(args: &CheckArgs) -> CommandResult {
    let model = args.model.as_ref().map(model_of).transpose()?;
    let mut status = CommandStatus::Success;
    for path in &scripts(&args.files)? {
        match read_script(path) {
            Ok(ProgramText { name, text }) => {
                let file = SourceFile::new(name, text);
                let is_test = script_test::is_test_file(path);
                let known = match &model {
                    Some(model) => known_names_of_arm(
                        model,
                        &args.tcp.map(|tcp| tcp.0).unwrap_or_default(),
                        &file,
                    ),
                    None => elite_runtime::builtins::known_names(),
                };
                let mut findings = findings(&file, known, is_test);
                let compiles = findings
                    .iter()
                    .all(|finding| finding.severity != Severity::Error);
                if let Some(cell) = &args.cell
                    && compiles
                    && !is_test
                {
                    findings.extend(findings_of_run(&file, cell, args)?);
                }
                for finding in &findings {
                    // Whoever reads may have seen enough; the status still tells.
                    let shown = render(finding, &file, args.format);
                    let _ = std::io::stdout().write_all(shown.as_bytes());
                }
                if findings.len() == elite_syntax::DIAGNOSTICS_MAX {
                    let most = elite_syntax::DIAGNOSTICS_MAX;
                    language::complain(&text!(
                        "{}: only the first {most} findings are shown",
                        "{}：只显示前 {most} 个发现",
                        file.name()
                    ));
                }
                if !findings.is_empty() {
                    status = status.max(CommandStatus::Negative);
                }
            }
            Err(sentence) => {
                language::complain(&sentence);
                status = CommandStatus::NotDone;
            }
        }
    }
    Ok(status)
}

/// The motions of a program that run into something in a cell, or come too near to it, as far as it runs.
fn findings_of_run(
    file: &Arc<SourceFile>,
    cell: &Path,
    args: &CheckArgs,
) -> Result<Vec<Diagnostic>, CommandError> {
    let run = RunArgs {
        shared: ControllerArgs {
            options: ControllerOptions {
                cell: Some(cell.to_owned()),
                model: args.model.clone(),
                tcp: args.tcp,
                home: args.home,
                ..ControllerOptions::default()
            },
            ..ControllerArgs::default()
        },
        ..RunArgs::default()
    };
    let config = RunConfig::load(run)?;
    let program = ProgramText {
        name: file.name().to_owned(),
        text: file.text().to_owned(),
    };
    let options = MeasureOptions::default();
    let run = measure(&config.robot, program, &options, &mut || true)?;
    if run.end != MeasuredEnd::Finished {
        language::complain(&text!(
            "{}: distances are known as far as it runs: {}",
            "{}：只有运行到的部分才知道间隙：{}",
            EscapedText(file.name()),
            escaped(&run.end)
        ));
    }
    Ok(clearance_findings(&run, file, args.margin.unwrap_or(0.0)))
}

/// What is to be said about the distances of a run: at each line the nearest of its motions.
pub(crate) fn clearance_findings(
    run: &ClearanceRun,
    file: &SourceFile,
    margin: f64,
) -> Vec<Diagnostic> {
    let mut nearest: BTreeMap<u32, &LeastDistance> = BTreeMap::new();
    for row in run
        .rows
        .iter()
        .filter(|row| row.distance() < margin.max(0.0))
    {
        if let Some(least) = &row.least {
            let found = nearest.entry(row.line).or_insert(least);
            if least.distance < found.distance {
                *found = least;
            }
        }
    }
    let findings = nearest.into_iter().map(|(line, least)| {
        let span = line_span(file, line);
        let (a, b) = (&least.a, &least.b);
        let (a_name, b_name) = (a.to_string(), b.to_string());
        let [x, y, z, ..] = least.tcp;
        let place = text!(
            "at {:.3} s, with the TCP at {x:.3}, {y:.3}, {z:.3} m",
            "{:.3} s 时，TCP 位于 {x:.3}、{y:.3}、{z:.3} m",
            least.time
        );
        if least.distance < -TOUCHING {
            let depth_mm = -least.distance * 1e3;
            let text = text!(
                "{a} runs {depth_mm:.1} mm into {b} {place}",
                "{a}与{b}重叠 {depth_mm:.1} mm，{place}"
            );
            Diagnostic::error("collision", span, text).with_help(text!(
                "`eliteserver plan` finds a way around; what may touch is named by [[touch]] in \
                 the cell file",
                "`eliteserver plan` 可求绕行的路径；允许接触的物体在单元文件的 [[touch]] 中给出"
            ))
        } else if least.distance <= TOUCHING {
            let text = text!("{a} touches {b} {place}", "{a}与{b}接触，{place}");
            Diagnostic::warning("near", span, text).with_help(text!(
                "where it may, the cell file says so: [[touch]], a = {a_name:?}, b = {b_name:?}",
                "允许接触时，请在单元文件中写明：[[touch]]，a = {a_name:?}，b = {b_name:?}"
            ))
        } else {
            let distance_mm = least.distance * 1e3;
            let text = text!(
                "{a} comes within {distance_mm:.1} mm of {b} {place}",
                "{a}与{b}相距不到 {distance_mm:.1} mm，{place}"
            );
            Diagnostic::warning("near", span, text)
        }
    });
    findings.collect()
}

/// The statement that begins in a line, without its indentation.
fn line_span(file: &SourceFile, line: u32) -> Span {
    let before = line.saturating_sub(1) as usize;
    let start: usize = file
        .text()
        .split_inclusive('\n')
        .take(before)
        .map(str::len)
        .sum();
    let text = file.text().get(start..).unwrap_or_default();
    let text = text.lines().next().unwrap_or_default();
    let indent = text.len() - text.trim_start().len();
    Span::new(start + indent, start + text.trim_end().len().max(indent))
}

/// The files that are named, and the scripts of folders that are.
fn scripts(paths: &[PathBuf]) -> Result<Vec<PathBuf>, CommandError> {
    let mut found = Vec::new();
    for path in paths {
        if !path.is_dir() {
            found.push(path.clone());
            continue;
        }
        let below = script_test::scripts_below(path)?;
        if below.is_empty() {
            let text = text!(
                "there is no script (*.script) below {}",
                "{} 之内没有脚本（*.script）",
                path.display()
            );
            return Err(CommandError::sentence(text));
        }
        found.extend(below);
    }
    Ok(found)
}

/// The arm of an option.
pub(crate) fn model_of(choice: &ModelChoice) -> Result<RobotModel, CommandError> {
    match choice {
        ModelChoice::BuiltIn(name) => Ok(RobotModel::built_in(name)?),
        ModelChoice::Urdf(path) => {
            let unusable = |error: ModelError| {
                CommandError::sentence(text!(
                    "cannot use the model {}: {error}",
                    "无法使用型号 {}：{error}",
                    path.display()
                ))
            };
            RobotModel::open(&path.to_string_lossy()).map_err(unusable)
        }
    }
}

/// What `check` knows of the functions when it is known for which arm a program is.
pub(crate) fn known_names_of_arm(
    model: &RobotModel,
    tcp: &RpyPose,
    file: &SourceFile,
) -> KnownNames {
    let [x, y, z] = tcp.xyz;
    let tool = match file.text().contains("set_tcp") {
        // How long the tool is may be known only when the program runs.
        true => TOOL_LENGTH_MAX,
        false => x.hypot(y).hypot(z),
    };
    elite_runtime::builtins::known_names_for(model.clone(), tool)
}

/// What is to be said about a program, or a test of programs.
pub(crate) fn diagnostics_of(file: &Arc<SourceFile>, is_test: bool) -> Vec<Diagnostic> {
    findings(file, elite_runtime::builtins::known_names(), is_test)
}

fn findings(file: &Arc<SourceFile>, known: KnownNames, is_test: bool) -> Vec<Diagnostic> {
    let known = match is_test {
        true => known.with_object(script_test::OBJECT, script_test::function_names()),
        false => known,
    };
    elite_syntax::check(file.clone(), &known)
}

/// A finding with the source line and a caret, for people.
pub(crate) fn render_text(finding: &Diagnostic, file: &SourceFile, language: Language) -> String {
    let picture = elite_syntax::render_human(finding, file, language, false);
    let picture = picture.trim_end_matches('\n');
    picture
        .lines()
        .map(|line| format!("{}\n", EscapedLines(line)))
        .collect()
}

/// A finding for machines.
pub(crate) fn row(finding: &Diagnostic, file: &SourceFile) -> Json {
    let fields = finding.fields(file);
    json!({
        "file": fields.file,
        "line": fields.line,
        "column": fields.column,
        "end_line": fields.end_line,
        "end_column": fields.end_column,
        "code": fields.code,
        "message": fields.message,
        "help": fields.help,
    })
}

fn render(finding: &Diagnostic, file: &SourceFile, format: FindingFormat) -> String {
    match format {
        FindingFormat::Human => render_text(finding, file, language::chosen()),
        FindingFormat::Json => format!("{}\n", row(finding, file)),
    }
}

/// The name of a script in messages.
pub fn display_name(path: &Path) -> String {
    if path == Path::new("-") {
        "<stdin>".to_owned()
    } else {
        EscapedText(&path.display().to_string()).to_string()
    }
}

/// Reads a script, `-` from stdin; the error is a sentence. For the pendant's XML that is the program beside it.
pub fn read_script(path: &Path) -> Result<ProgramText, Text> {
    program_of(path, &|path| -> io::Result<Box<dyn Read>> {
        match path == Path::new("-") {
            true => Ok(Box::new(io::stdin().lock())),
            false => Ok(Box::new(File::open(path)?)),
        }
    })
}

/// Reads a script through `open`; the error is a sentence. For the pendant's XML that is the program beside it.
pub(crate) fn program_of<R: Read>(
    path: &Path,
    open: &dyn Fn(&Path) -> io::Result<R>,
) -> Result<ProgramText, Text> {
    let bytes = read_bytes(path, open)?;
    if !is_xml(&bytes) {
        return text_of(path, bytes);
    }
    let task = display_name(path);
    if path == Path::new("-") {
        return Err(text!(
            "the script {task} is XML, not a program",
            "脚本 {task} 是 XML，不是程序"
        ));
    }
    let mut beside = path.as_os_str().to_owned();
    beside.push(".script");
    let beside = Path::new(&beside);
    let name = display_name(beside);
    if open(beside).is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
        return Err(text!(
            "{task} is a task of the pendant in XML, and {name}, the program that it sends, is not beside it",
            "{task} 是示教器的 XML 任务，而它所发送的程序 {name} 不在旁边"
        ));
    }
    let bytes = read_bytes(beside, open)?;
    match is_xml(&bytes) {
        true => Err(text!(
            "{task} is a task of the pendant in XML, and {name}, the program that it sends, is XML too",
            "{task} 是示教器的 XML 任务，而它所发送的程序 {name} 也是 XML"
        )),
        false => text_of(beside, bytes),
    }
}

fn read_bytes<R: Read>(
    path: &Path,
    open: &dyn Fn(&Path) -> io::Result<R>,
) -> Result<Vec<u8>, Text> {
    let mut bytes = Vec::new();
    let limit = SCRIPT_BYTES_MAX as u64 + 1;
    let read = open(path).and_then(|file| file.take(limit).read_to_end(&mut bytes));
    let name = display_name(path);
    read.map_err(|error| {
        text!(
            "cannot read the script {name}: {error}",
            "无法读取脚本 {name}：{error}"
        )
    })?;
    if bytes.len() > SCRIPT_BYTES_MAX {
        return Err(text!(
            "the script {name} is larger than the {} MiB allowed",
            "脚本 {name} 超过允许的 {} MiB",
            SCRIPT_BYTES_MAX >> 20
        ));
    }
    Ok(bytes)
}

fn text_of(path: &Path, bytes: Vec<u8>) -> Result<ProgramText, Text> {
    let name = display_name(path);
    match String::from_utf8(bytes) {
        Ok(text) => Ok(ProgramText { name, text }),
        Err(error) => {
            let byte = error.utf8_error().valid_up_to() + 1;
            Err(text!(
                "the script {name} is not UTF-8 text (byte {byte} is not)",
                "脚本 {name} 不是 UTF-8 文本（第 {byte} 个字节不是）"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_for_people_end_with_a_line_end() {
        let file = SourceFile::new("pick.script", "1a");
        let found = elite_syntax::check(file.clone(), &elite_syntax::KnownNames::default());
        let pictures: Vec<String> = found
            .iter()
            .map(|finding| render(finding, &file, FindingFormat::Human))
            .collect();
        assert!(!pictures.is_empty());
        for picture in pictures {
            assert!(
                picture.ends_with('\n') && !picture.ends_with("\n\n"),
                "{picture:?}"
            );
        }
    }

    #[test]
    fn findings_are_one_json_object_a_line() {
        let text = "def f():\n    spee = 1\n    movej([0, -90, 0, 0, 0, 0], v=sped)\n    return 1\n    sync()\n";
        let file = SourceFile::new("pick.script", text);
        let known = elite_runtime::builtins::known_names();
        let found: Vec<(String, u64)> = elite_syntax::check(file.clone(), &known)
            .iter()
            .map(|finding| {
                let line = render(finding, &file, FindingFormat::Json);
                let object: serde_json::Value = serde_json::from_str(line.trim_end())
                    .unwrap_or_else(|error| panic!("{line}: {error}"));
                let code = object["code"].as_str().unwrap_or_default().to_owned();
                (code, object["line"].as_u64().unwrap_or_default())
            })
            .collect();
        let expected = [
            ("unused-variable", 2),
            ("degrees", 3),
            ("undefined-name", 3),
            ("unreachable", 5),
        ];
        assert_eq!(found, expected.map(|(code, line)| (code.to_owned(), line)));
    }
}
