//! How the controller was started: what a recording must carry so that its commands can be run again.
//!
//! Stands in the file as one MCAP metadata record named `eliteserver`, all values as text, so that any MCAP tool shows
//! it. Numbers are written so that they come back bit for bit. Files of the cell are attachments beside it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::str::FromStr;

use kinematics::{JointPositions, Payload, RpyPose};
use messages::Localized;
use thiserror::Error;

use crate::cycle::{payload_numbers, payload_of};
use crate::files::{self, CellFiles};
use crate::lengths::truncate_marked;

/// Name of the metadata record.
pub(crate) const METADATA_NAME: &str = "eliteserver";
/// Version of the recording's format. A reader refuses newer ones.
const FORMAT: u32 = 1;
/// Entry that names the files of the cell.
const FILES: &str = "files";
/// Bytes of a wrong list of files that a message quotes.
const MAX_QUOTED: usize = 200;

/// How the controller was started.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Version of the program that recorded.
    pub version: String,
    /// The arm: name of a built-in model, or the path that was given.
    pub model: String,
    /// Text of the URDF when the model is not a built-in one.
    pub urdf: Option<String>,
    /// What was measured of the arm, as the text of a calibration file, when something was.
    pub calibration: Option<String>,
    /// Text of the cell file, when there was one.
    pub cell: Option<String>,
    /// Files that the cell file names, by the path as it names them.
    pub files: CellFiles,
    /// Initial joint positions.
    pub home: JointPositions,
    /// Initial TCP relative to the flange.
    pub tcp: RpyPose,
    /// Initial payload.
    pub payload: Payload,
    /// Length of one cycle, s.
    pub step_time: f64,
    /// Seed of every random number.
    pub seed: u64,
    /// Plant: `rigid` or `ideal`.
    pub plant: String,
    /// Clock: `virtual` or `realtime`.
    pub clock: String,
    /// Whether the arm was started without power.
    pub powered_off: bool,
    /// Time stamps in the file are this plus simulated time, ns since 1970. 0 counts them from the start.
    pub epoch_ns: u64,
    /// Number of this file in a recording of several files, from 1. Only the first begins with the controller's start.
    pub part: u32,
}

impl Default for Setup {
    /// The defaults of a controller (`CycleConfig`), but an ideal plant: for tests and tools.
    fn default() -> Self {
        use std::f64::consts::FRAC_PI_2;
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            model: "cs66".to_owned(),
            urdf: None,
            calibration: None,
            cell: None,
            files: CellFiles::new(),
            home: JointPositions([0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, 0.0]),
            tcp: RpyPose::default(),
            payload: Payload::default(),
            step_time: 0.004,
            seed: 0,
            plant: "ideal".to_owned(),
            clock: "virtual".to_owned(),
            powered_off: false,
            epoch_ns: 0,
            part: 1,
        }
    }
}

/// A metadata record that does not say how the controller was started.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum SetupError {
    /// An entry is missing or has a value that does not fit.
    #[error("the start configuration has {key} = {found:?}, which does not fit")]
    #[zh("启动配置中 {key} = {found:?}，不合适")]
    Value {
        /// The entry.
        key: &'static str,
        /// What was found; empty when it is missing.
        found: String,
    },
    /// Written by a newer version.
    #[error(
        "the recording has format {found}, this version reads up to {}",
        FORMAT
    )]
    #[zh("记录的格式为 {found}，此版本最高读取 {}", FORMAT)]
    Format {
        /// The format found.
        found: u32,
    },
}

impl Setup {
    /// The arm in a word or two, for people.
    pub fn arm(&self) -> String {
        match self.calibration {
            Some(_) => format!("{} (calibrated)", self.model),
            None => self.model.clone(),
        }
    }

    pub(crate) fn to_map(&self) -> BTreeMap<String, String> {
        let mut map = BTreeMap::new();
        let mut put = |key: &str, value: String| map.insert(key.to_owned(), value);
        put("format", FORMAT.to_string());
        put("version", self.version.clone());
        put("model", self.model.clone());
        if let Some(urdf) = &self.urdf {
            put("urdf", urdf.clone());
        }
        if let Some(calibration) = &self.calibration {
            put("calibration", calibration.clone());
        }
        if let Some(cell) = &self.cell {
            put("cell", cell.clone());
        }
        put("home", numbers(&self.home.0));
        put("tcp", numbers(&self.tcp.to_array()));
        put("payload", numbers(&payload_numbers(&self.payload)));
        put("step_time", self.step_time.to_string());
        put("seed", self.seed.to_string());
        put("plant", self.plant.clone());
        put("clock", self.clock.clone());
        put("powered_off", self.powered_off.to_string());
        put("epoch_ns", self.epoch_ns.to_string());
        if self.part > 1 {
            put("part", self.part.to_string());
        }
        if !self.files.is_empty() {
            put(FILES, files::paths_to_text(&self.files));
        }
        map
    }

    /// What the entries say. The files of the cell do not stand among them; [`file_paths`] are their names.
    pub(crate) fn from_map(map: &BTreeMap<String, String>) -> Result<Self, SetupError> {
        let format = parse(map, "format")?;
        if format > FORMAT {
            return Err(SetupError::Format { found: format });
        }
        // What a version did not know yet was as it is by default.
        let default = Self::default();
        Ok(Self {
            version: parse_or(map, "version", "unknown".to_owned())?,
            model: parse(map, "model")?,
            urdf: map.get("urdf").cloned(),
            calibration: map.get("calibration").cloned(),
            cell: map.get("cell").cloned(),
            files: CellFiles::new(),
            home: JointPositions(array(map, "home", default.home.0)?),
            tcp: RpyPose::from_array(array(map, "tcp", default.tcp.to_array())?),
            payload: payload_of(array(map, "payload", payload_numbers(&default.payload))?),
            step_time: parse(map, "step_time")?,
            seed: parse_or(map, "seed", default.seed)?,
            plant: parse_or(map, "plant", default.plant)?,
            clock: parse_or(map, "clock", default.clock)?,
            powered_off: parse_or(map, "powered_off", default.powered_off)?,
            epoch_ns: parse_or(map, "epoch_ns", default.epoch_ns)?,
            part: parse_or(map, "part", default.part)?,
        })
    }
}

/// Paths of the files of the cell that a recording has.
pub(crate) fn file_paths(map: &BTreeMap<String, String>) -> Result<BTreeSet<String>, SetupError> {
    let Some(text) = map.get(FILES) else {
        return Ok(BTreeSet::new());
    };
    files::paths_of_text(text).ok_or_else(|| SetupError::Value {
        key: FILES,
        found: truncate_marked(text, MAX_QUOTED).unwrap_or_else(|| text.clone()),
    })
}

/// Numbers separated by commas, each in the shortest form that reads back to the same bits.
fn numbers(values: &[f64]) -> String {
    let mut text = String::new();
    for (i, value) in values.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{}{value}", if i == 0 { "" } else { "," });
    }
    text
}

fn parse<T: FromStr>(map: &BTreeMap<String, String>, key: &'static str) -> Result<T, SetupError> {
    convert(map, key, |text| text.parse().ok())
}

/// Reads an entry that need not be there; `default` stands for a missing one.
fn parse_or<T: FromStr>(
    map: &BTreeMap<String, String>,
    key: &'static str,
    default: T,
) -> Result<T, SetupError> {
    match map.contains_key(key) {
        true => parse(map, key),
        false => Ok(default),
    }
}

fn array<const N: usize>(
    map: &BTreeMap<String, String>,
    key: &'static str,
    default: [f64; N],
) -> Result<[f64; N], SetupError> {
    if !map.contains_key(key) {
        return Ok(default);
    }
    convert(map, key, |text| {
        let values: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
        values.ok()?.try_into().ok()
    })
}

fn convert<T>(
    map: &BTreeMap<String, String>,
    key: &'static str,
    read: impl FnOnce(&str) -> Option<T>,
) -> Result<T, SetupError> {
    let found = map.get(key);
    found
        .and_then(|text| read(text))
        .ok_or_else(|| SetupError::Value {
            key,
            found: found.cloned().unwrap_or_default(),
        })
}
