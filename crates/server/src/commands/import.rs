//! `eliteserver import`: a toolpath as a program.

use std::f64::consts::FRAC_PI_2;
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use elite_syntax::SourceFile;
use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use messages::text;
use program_import::toolpath::program::{ProgramOptions, write as program_of};
use program_import::toolpath::reach::{Reach, work_top};
use program_import::toolpath::{Remark, Toolpath, ToolpathError, csv, dxf, gcode};

use crate::cli::ImportArgs;
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::check::{diagnostics_of, display_name, render_text};
use crate::commands::translate::write;
use crate::language;
use crate::ports::escape::{EscapedText, escaped};

/// Files are read up to this size.
const FILE_BYTES_MAX: u64 = 64 << 20;
/// The posture from which the arm begins.
const HOME_RAD: [f64; 6] = [0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, 0.0];
/// The arm, where none is named.
const MODEL_DEFAULT: &str = "cs66";
/// Share of the tolerance that curves may take which become lines; the rest is for corners.
const CURVE_SHARE: f64 = 0.3;

/// Formats of toolpaths.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Gcode,
    Dxf,
    Csv,
}

/// Exit status: 0 done, 1 impossible or not understood, 2 unreadable.
pub fn import(args: &ImportArgs) -> CommandResult {
    let name = display_name(&args.file);
    let format = format_of(&args.file, &name)?;
    refuse_unused(args, format)?;
    let text = read(&args.file, &name)?;
    let path = path_of(format, &text, args).map_err(|error| {
        CommandError::sentence(text!("{name}: {}", "{name}：{}", escaped(&error)))
    })?;
    let options = options_of(args, format);
    let model = args
        .model
        .as_ref()
        .map_or_else(|| MODEL_DEFAULT.to_owned(), ToString::to_string);
    let model = RobotModel::open(&model)?;
    let reach = Reach {
        model: &model,
        flange_from_tcp: args
            .tcp
            .as_ref()
            .map_or(Pose::IDENTITY, |tcp| Pose::from_rpy(&tcp.0)),
        home: JointPositions(HOME_RAD),
    };
    let top = work_top(&path, &options);
    let short_name = args
        .file
        .file_name()
        .map_or_else(|| name.clone(), |file| file.to_string_lossy().into_owned());
    let (program, mut remarks) = program_of(&path, &short_name, &options, &mut |from, to| {
        reach.is_free(&options, top, from, to)
    });
    let mut status = CommandStatus::Success;
    if args.check {
        remarks.extend(reach.remarks(&path, &options));
        remarks.sort_by_key(|remark| remark.line);
        status = status.max(check(&program));
    }
    let has_errors = remarks.iter().any(|remark| remark.is_error);
    status = status.max(CommandStatus::of_answer(
        !has_errors && (remarks.is_empty() || !args.strict),
    ));
    let said: String = remarks
        .iter()
        .map(|remark: &Remark| {
            let said = language::shown(remark).to_string();
            format!("{name}: {}\n", EscapedText(&said))
        })
        .collect();
    let _ = std::io::stderr().write_all(said.as_bytes());
    match &args.output {
        Some(output) => write(output, &program)?,
        None => {
            // Whoever reads may have seen enough.
            let _ = std::io::stdout().write_all(program.as_bytes());
        }
    }
    Ok(status)
}

fn format_of(path: &Path, name: &str) -> Result<Format, CommandError> {
    let ending = path
        .extension()
        .map(|ending| ending.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default();
    match ending.as_str() {
        "gcode" | "nc" | "ngc" => Ok(Format::Gcode),
        "dxf" => Ok(Format::Dxf),
        "csv" => Ok(Format::Csv),
        _ => Err(CommandError::sentence(text!(
            "{name}: allowed are files that end with .gcode, .nc, .ngc, .dxf or .csv",
            "{name}：只允许以 .gcode、.nc、.ngc、.dxf 或 .csv 结尾的文件"
        ))),
    }
}

/// Options that say nothing about a file of this format.
fn refuse_unused(args: &ImportArgs, format: Format) -> Result<(), CommandError> {
    let refusal = match format {
        Format::Gcode | Format::Csv if !args.layer.is_empty() => {
            text!(
                "--layer is for drawings (.dxf): other files have no layers",
                "--layer 用于图纸（.dxf）：其他文件没有图层"
            )
        }
        Format::Gcode | Format::Dxf if args.units.is_some() => {
            text!(
                "--units is for tables (.csv): G-code and drawings say their unit themselves",
                "--units 用于表格（.csv）：G 代码和图纸自带单位"
            )
        }
        _ => return Ok(()),
    };
    Err(CommandError::sentence(refusal.to_owned()))
}

/// The text of a file. Drawings of older programs have letters of other code pages; what is read of them are numbers.
fn read(path: &Path, name: &str) -> Result<String, CommandError> {
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(FILE_BYTES_MAX + 1).read_to_end(&mut bytes))
        .map_err(|error| {
            CommandError::sentence(text!(
                "cannot read {name}: {error}",
                "无法读取 {name}：{error}"
            ))
        })?;
    if bytes.len() as u64 > FILE_BYTES_MAX {
        return Err(CommandError::sentence(text!(
            "{name} is larger than the {} MiB allowed",
            "{name} 超过允许的 {} MiB",
            FILE_BYTES_MAX >> 20
        )));
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn path_of(format: Format, text: &str, args: &ImportArgs) -> Result<Toolpath, ToolpathError> {
    let tolerance = CURVE_SHARE * args.tolerance;
    match format {
        Format::Gcode => gcode::read(text, tolerance),
        Format::Dxf => dxf::read(text, &args.layer, tolerance),
        Format::Csv => csv::read(text, args.units.unwrap_or_default().metres()),
    }
}

fn options_of(args: &ImportArgs, format: Format) -> ProgramOptions {
    ProgramOptions {
        frame: args
            .frame
            .as_ref()
            .map_or_else(RpyPose::default, |frame| frame.0),
        tool_axis: args.tool_axis.0,
        speed: args.speed,
        speed_factor: args.feed_scale,
        tolerance: args.tolerance,
        on: args.on.clone(),
        off: args.off.clone(),
        lead_in: args.lead_in.unwrap_or_default(),
        lifts: format == Format::Dxf,
    }
}

/// What `check` would say about the program.
fn check(program: &str) -> CommandStatus {
    let file = SourceFile::new(language::pick("the program", "程序"), program);
    let findings = diagnostics_of(&file, false);
    for finding in &findings {
        let shown = render_text(finding, &file, language::chosen());
        let _ = std::io::stderr().write_all(shown.as_bytes());
    }
    CommandStatus::of_answer(findings.is_empty())
}
