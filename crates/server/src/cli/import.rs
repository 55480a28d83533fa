//! Options of the commands that read programs and toolpaths from elsewhere.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use controller::options::{ModelChoice, Tcp};

use super::{FindingFormat, LogArgs};

/// Options of `translate`.
#[derive(Args, Clone, Debug)]
pub struct TranslateArgs {
    /// The program in URScript; - reads it from stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Where to write the translated program [default: standard output]
    #[arg(short, long, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    /// Write a page about what was changed and what is missing
    #[arg(long, value_name = "FILE.md")]
    pub report: Option<PathBuf>,
    /// Remarks for people, or one JSON object a remark: line, kind, name, text
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Options of `import`.
#[derive(Args, Clone, Debug)]
pub struct ImportArgs {
    /// The toolpath: .gcode, .nc, .ngc, .dxf or .csv
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Where to write the program [default: standard output]
    #[arg(short, long, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    /// The frame of the file in the base frame, m and rad [default: 0,0,0,0,0,0]
    #[arg(long, value_name = "x,y,z,rx,ry,rz", allow_hyphen_values = true)]
    pub frame: Option<Tcp>,
    /// Where the tool points, in that frame
    #[arg(long, value_name = "x,y,z", default_value = "0,0,-1", allow_hyphen_values = true, value_parser = axis)]
    pub tool_axis: ToolAxis,
    /// Speed at work, m/s [default: that of the file, else 0.05]
    #[arg(long, value_name = "V", value_parser = speed, allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// Factor of the speeds of the file
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = factor, allow_negative_numbers = true)]
    pub feed_scale: f64,
    /// How far the path may be from that of the file, m
    #[arg(long, value_name = "D", default_value_t = 0.000_05, value_parser = length, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// A layer of a drawing; repeat it for more [default: all]
    #[arg(long, value_name = "NAME")]
    pub layer: Vec<String>,
    /// The line of the program that switches the tool on (M3, M7, M8; begin of a contour)
    #[arg(long, value_name = "LINE")]
    pub on: Option<String>,
    /// The line that switches it off (M5, M9; end of a contour)
    #[arg(long, value_name = "LINE")]
    pub off: Option<String>,
    /// Length of a straight approach against the tool axis, m; in drawings at every contour [default: none]
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true)]
    pub lead_in: Option<f64>,
    /// Unit of the lengths in a table [default: mm]
    #[arg(long, value_enum)]
    pub units: Option<LengthUnit>,
    /// Check the program, and that the arm reaches every point; status 1 where not
    #[arg(long)]
    pub check: bool,
    /// Status 1 where something of the file is not understood
    #[arg(long)]
    pub strict: bool,
    /// The arm that --check asks, and whose rapid moves may go through joint space [default: cs66]
    #[arg(long)]
    pub model: Option<ModelChoice>,
    /// Its tool centre point from the flange, m and rad [default: 0,0,0,0,0,0]
    #[arg(long, value_name = "x,y,z,rx,ry,rz", allow_hyphen_values = true)]
    pub tcp: Option<Tcp>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// A direction of the tool.
#[derive(Clone, Copy, Debug)]
pub struct ToolAxis(pub [f64; 3]);

/// Units of tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LengthUnit {
    /// Millimetres.
    #[default]
    Mm,
    /// Metres.
    M,
    /// Inches.
    Inch,
}

impl LengthUnit {
    /// In metres.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Mm => 0.001,
            Self::M => 1.0,
            Self::Inch => 0.0254,
        }
    }
}

fn axis(text: &str) -> Result<ToolAxis, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|number| number.trim().parse().ok())
        .filter(|number: &f64| number.abs() < 1e6)
        .collect();
    match numbers[..] {
        [x, y, z] if x * x + y * y + z * z > 1e-12 => Ok(ToolAxis([x, y, z])),
        _ => Err("three numbers that are not all 0 are needed, as in 0,0,-1".to_owned()),
    }
}

fn positive(text: &str, unit: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if number > 0.0 && number <= 1000.0 => Ok(number),
        _ => Err(format!("allowed are numbers above 0, up to 1000{unit}")),
    }
}

fn speed(text: &str) -> Result<f64, String> {
    positive(text, " m/s")
}

fn factor(text: &str) -> Result<f64, String> {
    positive(text, "")
}

fn length(text: &str) -> Result<f64, String> {
    positive(text, " m")
}
