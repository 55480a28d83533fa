//! Answers for people, for programs, and as tables of a cell file.

use core::fmt::Write;

use messages::{Text, text};
use serde_json::{Value as Json, json};

use crate::language::{chosen, padded, shown};

/// What was found.
#[derive(Clone, Debug)]
pub enum Answer {
    /// What hangs on the flange.
    Payload(PayloadAnswer),
    /// Friction of the joints.
    Friction(FrictionAnswer),
    /// Bias of the force sensor.
    Sensor(SensorAnswer),
    /// A tool centre point.
    Tool(ToolAnswer),
    /// A frame from three points.
    Frame(FrameAnswer),
}

#[derive(Clone, Debug)]
pub struct PayloadAnswer {
    pub mass: f64,
    pub cog: [f64; 3],
    /// Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of gravity.
    pub inertia: Option<[f64; 6]>,
    pub sigma_mass: f64,
    pub sigma_cog: [f64; 3],
    pub residual_rms: f64,
    pub samples: usize,
}

#[derive(Clone, Debug)]
pub struct FrictionAnswer {
    pub coulomb: [f64; 6],
    pub viscous: [f64; 6],
    pub sigma_coulomb: [f64; 6],
    pub sigma_viscous: [f64; 6],
    pub residual_rms: f64,
    pub samples: usize,
}

#[derive(Clone, Debug)]
pub struct SensorAnswer {
    pub bias: [f64; 6],
    pub mass: f64,
    pub cog: [f64; 3],
    pub sigma_bias: [f64; 6],
    pub sigma_mass: f64,
    pub sigma_cog: [f64; 3],
    pub residual_rms: f64,
    pub samples: usize,
}

#[derive(Clone, Debug)]
pub struct ToolAnswer {
    pub tcp: [f64; 6],
    pub sigma_position: [f64; 3],
    /// None where no orientation was asked for.
    pub sigma_orientation: Option<f64>,
    pub residual_max: f64,
    pub rests: usize,
}

#[derive(Clone, Debug)]
pub struct FrameAnswer {
    pub frame: [f64; 6],
    /// Of the points, m; None for three rests, which leave nothing over.
    pub rests: usize,
}

/// Numbers with six digits after the point, zeros at the end cut.
fn list(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|x| number(*x)).collect();
    format!("[{}]", texts.join(", "))
}

fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" => "0".to_owned(),
        _ => text.to_owned(),
    }
}

/// A number with a point, as TOML wants it in lists of numbers.
fn toml_list(values: &[f64]) -> String {
    let texts: Vec<String> = values
        .iter()
        .map(|x| format!("{:?}", (x * 1e9).round() / 1e9))
        .collect();
    format!("[{}]", texts.join(", "))
}

/// Rows that several answers have.
const RESIDUAL: Text = text!("residual (rms)", "残差（均方根）");
const SAMPLES: Text = text!("samples", "样本数");
const RESTS: Text = text!("rests", "静止段");

impl Answer {
    /// One object.
    pub fn json(&self) -> Json {
        match self {
            Self::Payload(a) => json!({
                "mass": a.mass, "cog": a.cog, "inertia": a.inertia,
                "sigma": {"mass": a.sigma_mass, "cog": a.sigma_cog},
                "residual_rms": a.residual_rms, "samples": a.samples,
            }),
            Self::Friction(a) => json!({
                "coulomb": a.coulomb, "viscous": a.viscous,
                "sigma": {"coulomb": a.sigma_coulomb, "viscous": a.sigma_viscous},
                "residual_rms": a.residual_rms, "samples": a.samples,
            }),
            Self::Sensor(a) => json!({
                "bias": a.bias, "mass": a.mass, "cog": a.cog,
                "sigma": {"bias": a.sigma_bias, "mass": a.sigma_mass, "cog": a.sigma_cog},
                "residual_rms": a.residual_rms, "samples": a.samples,
            }),
            Self::Tool(a) => json!({
                "tcp": a.tcp,
                "sigma": {"position": a.sigma_position, "orientation": a.sigma_orientation},
                "residual_max": a.residual_max, "samples": a.rests,
            }),
            Self::Frame(a) => json!({"frame": a.frame, "samples": a.rests}),
        }
    }

    /// Tables of a cell file, or a pose under its name.
    pub fn toml(&self) -> String {
        match self {
            Self::Payload(a) => {
                let mut text = format!(
                    "[payload]\nmass = {:?}\ncog = {}\n",
                    a.mass,
                    toml_list(&a.cog)
                );
                if let Some(inertia) = a.inertia {
                    let _ = writeln!(text, "inertia = {}", toml_list(&inertia));
                }
                text
            }
            Self::Friction(a) => {
                // A friction below 0 is what noise leaves of none.
                let positive = |values: &[f64; 6]| toml_list(&values.map(|x| x.max(0.0)));
                format!(
                    "[arm]\ncoulomb = {}\nviscous = {}\n",
                    positive(&a.coulomb),
                    positive(&a.viscous)
                )
            }
            Self::Sensor(a) => format!(
                "# bias of the sensor: {}\n[payload]\nmass = {:?}\ncog = {}\n",
                list(&a.bias),
                a.mass.max(0.0),
                toml_list(&a.cog)
            ),
            Self::Tool(a) => format!("# set_tcp({})\ntcp = {}\n", list(&a.tcp), toml_list(&a.tcp)),
            Self::Frame(a) => format!("frame = {}\n", toml_list(&a.frame)),
        }
    }

    /// Lines for people; the last ones are what is pasted elsewhere.
    pub fn human(&self) -> String {
        let mut text = String::new();
        let mut row = |name: Text, value: String, sigma: Option<String>, unit: &str| {
            let sigma = sigma.map_or_else(String::new, |sigma| format!("  ± {sigma}"));
            let name = padded(name.in_language(chosen()), 20);
            let _ = writeln!(text, "{name}{value}{sigma} {unit}");
        };
        match self {
            Self::Payload(a) => {
                row(
                    text!("mass", "质量"),
                    number(a.mass),
                    Some(number(a.sigma_mass)),
                    "kg",
                );
                row(
                    text!("centre of gravity", "重心"),
                    list(&a.cog),
                    Some(list(&a.sigma_cog)),
                    "m",
                );
                match a.inertia {
                    Some(inertia) => row(text!("inertia", "惯量"), list(&inertia), None, "kg m²"),
                    None => row(
                        text!("inertia", "惯量"),
                        shown(&text!("not told by this motion", "此运动无法判断")).to_string(),
                        None,
                        "",
                    ),
                }
                row(RESIDUAL, number(a.residual_rms), None, "");
                row(SAMPLES, a.samples.to_string(), None, "");
                let inertia = a
                    .inertia
                    .map(|i| format!(", {}", list(&i)))
                    .unwrap_or_default();
                let _ = writeln!(
                    text,
                    "\n{}set_payload({}, {}{inertia})",
                    self.toml(),
                    number(a.mass),
                    list(&a.cog)
                );
            }
            Self::Friction(a) => {
                row(
                    text!("dry friction", "干摩擦"),
                    list(&a.coulomb),
                    Some(list(&a.sigma_coulomb)),
                    "Nm",
                );
                row(
                    text!("viscous friction", "粘性摩擦"),
                    list(&a.viscous),
                    Some(list(&a.sigma_viscous)),
                    "Nm s/rad",
                );
                row(RESIDUAL, number(a.residual_rms), None, "Nm");
                row(SAMPLES, a.samples.to_string(), None, "");
                let _ = write!(text, "\n{}", self.toml());
            }
            Self::Sensor(a) => {
                row(
                    text!("bias", "零偏"),
                    list(&a.bias),
                    Some(list(&a.sigma_bias)),
                    "N, Nm",
                );
                row(
                    text!("mass", "质量"),
                    number(a.mass),
                    Some(number(a.sigma_mass)),
                    "kg",
                );
                row(
                    text!("centre of gravity", "重心"),
                    list(&a.cog),
                    Some(list(&a.sigma_cog)),
                    "m",
                );
                row(RESIDUAL, number(a.residual_rms), None, "");
                row(RESTS, a.samples.to_string(), None, "");
            }
            Self::Tool(a) => {
                row(
                    text!("position", "位置"),
                    list(&a.tcp[..3]),
                    Some(list(&a.sigma_position)),
                    "m",
                );
                let sigma = a.sigma_orientation.map(number);
                row(
                    text!("orientation", "姿态"),
                    list(&a.tcp[3..]),
                    sigma,
                    "rad",
                );
                row(
                    text!("largest residual", "最大残差"),
                    number(a.residual_max),
                    None,
                    "m",
                );
                row(RESTS, a.rests.to_string(), None, "");
                let _ = writeln!(text, "\nset_tcp({})", list(&a.tcp));
            }
            Self::Frame(a) => {
                row(text!("frame", "坐标系"), list(&a.frame), None, "m, rad");
                let _ = writeln!(text, "\nframe = {}", list(&a.frame));
            }
        }
        text
    }
}
