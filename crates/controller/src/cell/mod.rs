//! The cell file: what stands around the arm, how signals are wired, what acts on the arm from outside.
//!
//! Owns the TOML schema and its sentences. Every table is read and checked here; no key is ignored. Whether
//! limits suit the arm is checked with the arm. Poses are
//! `[x, y, z, Rx, Ry, Rz]` in the base frame, m and rad.

mod check;
pub(crate) mod collision_scene;
pub mod connections;
mod convert;
mod meshes;
pub mod point;
mod scene;
pub mod schema;
pub(crate) mod shape;
pub mod world;
pub mod world_schema;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use io_bus::modbus::{DeviceAddress, SignalKind, SignalSpec};
use io_bus::serial::{Endpoint, SerialLine};
use io_bus::{Fieldbus, SimulatedPeers};
use kinematics::SafetyBounds;
use kinematics::safety::SafetySettingError;
use kinematics::{JointAccelerations, JointJerks, JointPositions, JointSpeeds};
use mesh::{MeshBody, MeshFiles};
use messages::{Localized, Text, text};
use motion::contact::Environment;
use motion::external::TimedWrench;
use motion::modes::encoder::Belt;
use motion::{
    InputPair, IoSetup, LimitOverrides, PlantParameters, SafetyInputs, SensorNoise, TimedInput,
    WireSetup,
};
use recorder::Setup;
use supervision::ThreadSupervisor;
use thiserror::Error;
use toml::de::{DeTable, DeValue};

use crate::cell_world::{CellWorld, gripper_bus};
pub use check::InvalidValue;
pub use meshes::{CellMeshError, MeshFacts};
use meshes::{Meshes, NoFiles, RecordedFiles};
use point::IoPointName;
use schema::{ActiveLevel, InputValue, SafetyFunction, SerialPort, Tables};
use world_schema::GripperBus;

/// A reason why there is no cell: one sentence, which ends the program with exit status 2.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum CellError {
    /// The file cannot be read.
    #[error("cannot read the cell file {}: {source}", path.display())]
    #[zh("无法读取单元文件 {}：{source}", path.display())]
    Unreadable {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A key or value that the schema does not have, or no TOML at all.
    #[error("{file} line {line}: {message}")]
    #[zh("{file} 第 {line} 行：{message}")]
    Schema {
        /// The cell file.
        file: Text,
        /// Line from 1.
        line: usize,
        /// What is wrong there.
        message: Text,
    },
    /// A value that has the right type but makes no sense.
    #[error("{file}: {source}")]
    Value {
        /// The cell file.
        file: Text,
        /// What is wrong with it.
        source: Box<InvalidValue>,
    },
    /// A Modbus signal that cannot be added.
    #[error("the cell's modbus signal {name:?} cannot be added: {reason}")]
    #[zh("无法添加单元的 Modbus 信号 {name:?}：{reason}")]
    Signal {
        /// Name of the signal.
        name: String,
        /// What is wrong with the signal.
        reason: Text,
    },
    /// A device that may not be reached.
    #[error(
        "the cell's {what} is of {device}; with --allow net=played no device outside this process is reached"
    )]
    #[zh("单元的{what}属于 {device}；用 --allow net=played 时不连接此进程之外的设备")]
    Device {
        /// The port or the signal.
        what: Text,
        /// What is behind it.
        device: String,
    },
    /// A mesh that cannot be.
    #[error("{file}: {table}: {source}")]
    Mesh {
        /// The cell file.
        file: Text,
        /// The table with its name.
        table: Text,
        /// What is wrong with the mesh.
        source: Box<CellMeshError>,
    },
    /// A world of parts that cannot be.
    #[error("{file}: {source}")]
    World {
        /// The cell file.
        file: Text,
        /// What is impossible.
        source: Box<::world::WorldError>,
    },
    /// A safety setting that cannot be used.
    #[error("{file}: {source}")]
    Safety {
        /// The cell file.
        file: Text,
        /// What is wrong with the setting.
        source: SafetySettingError,
    },
}

/// A cell file that was read and checked, and that this version can act on.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    tables: Tables,
    meshes: Meshes,
    safety: SafetyBounds,
    text: String,
}

/// The line, from 1, in which a byte of a text stands.
pub fn line_of(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|b| *b == b'\n').count()
}

/// The limits of a table; both tables have the same keys.
macro_rules! overrides {
    ($table:expr) => {{
        let limits = &$table;
        LimitOverrides {
            joint_speed: limits.joint_speed.map(JointSpeeds),
            joint_acceleration: limits.joint_acceleration.map(JointAccelerations),
            joint_jerk: limits.joint_jerk.map(JointJerks),
            joint_position_min: limits.joint_position_min.map(JointPositions),
            joint_position_max: limits.joint_position_max.map(JointPositions),
            tcp_speed: limits.tcp_speed,
            elbow_speed: limits.elbow_speed,
            tcp_force: limits.tcp_force,
            self_collision: None,
        }
    }};
}

impl Cell {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// [`CellError`] names the file, the key and what is allowed, or what is not available yet.
    pub fn load(path: &Path) -> Result<Self, CellError> {
        let text = kinematics::text_file::read_text_file(path).map_err(|source| {
            CellError::Unreadable {
                path: path.to_owned(),
                source,
            }
        })?;
        Self::from_text_beside_files(text, path)
    }

    /// Checks the text of a file; `path` is what errors call it, and meshes are read from its folder.
    ///
    /// # Errors
    /// The errors of [`Cell::load`].
    pub fn from_text_beside_files(text: String, path: &Path) -> Result<Self, CellError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::with_files(text, &name_of(path), &mut mesh::Folder::new(folder))
    }

    /// Checks a text that has no folder, so that it cannot name a mesh; `path` is what errors call it.
    ///
    /// # Errors
    /// The errors of [`Cell::load`].
    pub fn from_text(text: String, path: &Path) -> Result<Self, CellError> {
        Self::with_files(text, &name_of(path), &mut NoFiles)
    }

    /// The cell of a recording, whose text and files it holds.
    ///
    /// # Errors
    /// A recorded cell file that this version cannot act on, or one of its meshes that is missing.
    pub fn of_recording(setup: &Setup) -> Result<Option<Self>, CellError> {
        let cell = setup.cell.clone().map(|text| {
            let name = text!("the recorded cell file", "记录的单元文件");
            Self::with_files(text, &name, &mut RecordedFiles(&setup.files))
        });
        cell.transpose()
    }

    fn with_files(text: String, file: &Text, files: &mut dyn MeshFiles) -> Result<Self, CellError> {
        let (tables, meshes) = parse(&text, file, files)?;
        let safety =
            convert::safety_bounds(&tables, &meshes).map_err(|source| CellError::Safety {
                file: file.clone(),
                source,
            })?;
        let cell = Self {
            safety,
            tables,
            meshes,
            text,
        };
        cell.check_drivers(file)?;
        Ok(cell)
    }

    /// Refuses an input that a wire or the clock gives values, and the world of parts as well.
    fn check_drivers(&self, file: &Text) -> Result<(), CellError> {
        let connections = self.connections();
        let drivers: Vec<_> = connections
            .iter()
            .filter(|connection| connection.drives())
            .collect();
        for (index, second) in drivers.iter().enumerate() {
            if !matches!(second.table, "wire" | "input") {
                continue;
            }
            let of_world = |first: &&&connections::Connection| {
                first.point == second.point && !matches!(first.table, "wire" | "input")
            };
            if let Some(first) = drivers[..index].iter().find(of_world) {
                let wrong = InvalidValue {
                    table: Text::verbatim(format!("{} {}", second.table, second.entry)),
                    key: second.key,
                    given: Text::verbatim(second.point.to_string()),
                    allowed: text!(
                        "{} {:?} drives this input already",
                        "{} {:?} 已在驱动此输入",
                        first.table,
                        first.entry
                    ),
                };
                return Err(CellError::Value {
                    file: file.clone(),
                    source: Box::new(wrong),
                });
            }
        }
        Ok(())
    }

    /// Every table of the file.
    pub const fn tables(&self) -> &Tables {
        &self.tables
    }

    /// Every file that the tables name, by the path as they name it, for the recording.
    pub const fn files(&self) -> &BTreeMap<String, Arc<[u8]>> {
        self.meshes.files()
    }

    pub(crate) const fn meshes(&self) -> &Meshes {
        &self.meshes
    }

    /// What there is to say of each mesh of the cell, in the order of the tables.
    pub fn mesh_facts(&self) -> Vec<MeshFacts> {
        let shapes = meshes::shapes(&self.tables);
        let facts = shapes.filter_map(|(table, keys)| {
            let keys = keys.mesh()?;
            let body = self.meshes.body(&keys)?;
            Some(MeshFacts::new(&table, keys.file, &body))
        });
        facts.collect()
    }

    /// The meshes of the cell, each once, in a fixed order.
    pub fn mesh_bodies(&self) -> impl Iterator<Item = &Arc<MeshBody>> {
        self.meshes.bodies()
    }

    /// The file as written, for the recording.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// `[[wire]]` and `[[input]]`.
    pub fn io(&self) -> IoSetup {
        let wires = self.tables.wire.iter().map(|wire| WireSetup {
            from: wire.from.io_point(),
            to: wire.to.io_point(),
            delay: wire.delay,
        });
        let inputs = self.tables.input.iter().map(|input| TimedInput {
            at: input.at,
            to: input.set.io_point(),
            value: match input.value {
                InputValue::Level(level) => f64::from(u8::from(level)),
                InputValue::Number(number) => number,
            },
        });
        IoSetup {
            wires: wires.collect(),
            inputs: inputs.collect(),
        }
    }

    /// `[[safety_input]]`.
    pub fn safety_inputs(&self) -> SafetyInputs {
        let mut inputs = SafetyInputs::default();
        for input in &self.tables.safety_input {
            let pair = InputPair {
                pair: input.pair,
                is_active_low: input.active == ActiveLevel::Low,
            };
            let slot = match input.function {
                SafetyFunction::EmergencyStop => &mut inputs.emergency_stop,
                SafetyFunction::SafeguardStop => &mut inputs.safeguard_stop,
                SafetyFunction::SafeguardReset => &mut inputs.safeguard_reset,
                SafetyFunction::ReducedMode => &mut inputs.reduced_mode,
            };
            *slot = Some(pair);
        }
        inputs
    }

    /// Whether nothing is behind the serial ports, and no Modbus device where nobody `plays` machines.
    ///
    /// # Errors
    /// [`CellError::Device`]
    pub fn check_without_devices(&self, plays: bool) -> Result<(), CellError> {
        if let Some(serial) = self.tables.serial.first() {
            let port = match serial.port {
                SerialPort::Tool => "tool",
                SerialPort::Masterboard => "masterboard",
            };
            return Err(CellError::Device {
                what: text!("serial port {port}", "串口 {port}"),
                device: serial.device.clone(),
            });
        }
        match self.tables.modbus.first() {
            Some(signal) if !plays => Err(CellError::Device {
                what: text!("modbus signal {:?}", "Modbus 信号 {:?}", signal.signal_name),
                device: format!("{}:{}", signal.ip, signal.port),
            }),
            _ => Ok(()),
        }
    }

    /// The devices behind `[[serial]]`, the signals of `[[modbus]]`, and grippers of the world on a bus.
    ///
    /// # Errors
    /// [`CellError::Value`] names the signal that cannot be added.
    pub fn fieldbus(
        &self,
        faults: &ThreadSupervisor,
        stand_ins: Option<Arc<dyn SimulatedPeers>>,
        world: Option<&CellWorld>,
    ) -> Result<Fieldbus, CellError> {
        let line = |wanted| {
            let port = self
                .tables
                .serial
                .iter()
                .find(|serial| serial.port == wanted);
            let bus = GripperBus::Serial(wanted);
            let slaves = world.map(|world| gripper_bus::slaves(self, world, bus));
            SerialLine::new(port.map(|serial| Endpoint::parse(&serial.device)))
                .with_slaves(slaves.unwrap_or_default())
        };
        let (tool, masterboard) = (line(SerialPort::Tool), line(SerialPort::Masterboard));
        let fieldbus = Fieldbus::new(tool, masterboard, faults, stand_ins);
        for signal in &self.tables.modbus {
            let spec = SignalSpec {
                device: DeviceAddress {
                    host: signal.ip.clone(),
                    port: signal.port,
                },
                slave: match signal.slave_number {
                    248..=255 => 255,
                    slave => slave,
                },
                address: signal.signal_address,
                count: signal.registers_count.into(),
                kind: match signal.signal_type {
                    0 => SignalKind::DigitalInput,
                    1 => SignalKind::DigitalOutput,
                    2 => SignalKind::RegisterInput,
                    _ => SignalKind::RegisterOutput,
                },
                is_sequential: signal.is_sequential,
            };
            let added = fieldbus.modbus.add(&signal.signal_name, spec);
            added.map_err(|error| CellError::Signal {
                name: signal.signal_name.clone(),
                reason: Text::of(&error),
            })?;
        }
        Ok(fieldbus)
    }

    /// `[[safety_plane]]` and the tool they hold back.
    pub const fn safety_bounds(&self) -> &SafetyBounds {
        &self.safety
    }

    /// `[[conveyor]]`: what turns the two encoders.
    pub fn belts(&self) -> [Option<Belt>; 2] {
        convert::belts(&self.tables.conveyor)
    }

    /// `[[wrench]]`: loads on the tool by time.
    pub fn loads(&self) -> Vec<TimedWrench> {
        convert::loads(&self.tables.wrench)
    }

    /// `[[obstacle]]` and `[tool]`: what the arm touches, and with what.
    pub fn surroundings(&self) -> Environment {
        convert::surroundings(self)
    }

    /// `[payload]` and `[arm]`: what is true of the arm though the controller does not know it.
    pub fn truth(&self) -> PlantParameters {
        convert::truth(&self.tables)
    }

    /// `[sensor]`, with the seed of its noise.
    pub const fn sensor_noise(&self, seed: u64) -> SensorNoise {
        SensorNoise {
            force: self.tables.sensor.force_noise,
            torque: self.tables.sensor.torque_noise,
            seed,
        }
    }

    /// `[limits]`, for the cycle to check against the model's own.
    pub fn limits(&self) -> LimitOverrides {
        LimitOverrides {
            self_collision: self.tables.limits.self_collision,
            ..overrides!(self.tables.limits)
        }
    }

    /// `[limits.reduced]`, for the cycle to check against those.
    pub fn reduced_limits(&self) -> LimitOverrides {
        overrides!(self.tables.limits.reduced)
    }
}

/// What errors call a file.
fn name_of(path: &Path) -> Text {
    Text::verbatim(path.display().to_string())
}

/// Reads the text of a file and checks what each table says; `file` is named in errors.
fn parse(
    text: &str,
    file: &Text,
    files: &mut dyn MeshFiles,
) -> Result<(Tables, Meshes), CellError> {
    let tables: Tables = toml::from_str(text).map_err(|error| schema_error(text, file, &error))?;
    let invalid = |wrong: InvalidValue| CellError::Value {
        file: file.clone(),
        source: Box::new(wrong),
    };
    check::values(&tables).map_err(invalid)?;
    let meshes = Meshes::read(&tables, files).map_err(|(table, source)| CellError::Mesh {
        file: file.clone(),
        table,
        source,
    })?;
    if world::has_world(&tables) {
        let description = world::description(&tables, &meshes).map_err(invalid)?;
        ::world::check(&description).map_err(|source| CellError::World {
            file: file.clone(),
            source: Box::new(source),
        })?;
    }
    Ok((tables, meshes))
}

/// The table that stands at a byte, in words: `obstacle "bench"`, `wire 2`, `tool`.
fn table_at(text: &str, byte: usize) -> Option<String> {
    let tables = DeTable::parse(text).ok()?;
    let mut found = None;
    let mut note = |start: usize, table: String| {
        if start <= byte && found.as_ref().is_none_or(|(best, _)| *best <= start) {
            found = Some((start, table));
        }
    };
    for (key, value) in tables.get_ref() {
        let kind = key.get_ref();
        match value.get_ref() {
            DeValue::Array(entries) => {
                for (entry, number) in entries.iter().zip(1..) {
                    let named = |key: &str| entry.get_ref().get(key)?.get_ref().as_str();
                    let name = named("name").or_else(|| named("signal_name"));
                    let table = match name {
                        Some(name) => format!("{kind} {name:?}"),
                        None => format!("{kind} {number}"),
                    };
                    note(entry.span().start, table);
                }
            }
            _ => note(value.span().start, kind.to_string()),
        }
    }
    found.map(|(_, table)| table)
}

/// What is wrong with the name of a point. serde hands on the English form alone, so the name is read once more.
fn point_error(text: &str, error: &toml::de::Error) -> Option<Text> {
    let given = text.get(error.span()?)?.trim_matches(['"', '\'']);
    let refusal = given.parse::<IoPointName>().err()?;
    (refusal.english() == error.message()).then_some(refusal)
}

/// serde names unknown keys but not the key of a wrong value: that one is read from the line it stands in.
fn schema_error(text: &str, file: &Text, error: &toml::de::Error) -> CellError {
    let line = error.span().map_or(1, |span| line_of(text, span.start));
    let source = text.lines().nth(line - 1).unwrap_or_default();
    let key = source.split_once('=').map(|(key, _)| key.trim());
    let message = match point_error(text, error) {
        Some(refusal) => refusal,
        None => Text::of_library(&error.message().replace('\n', ", ")),
    };
    let words = message.english();
    let message = match key {
        // What is not there has no line of its own.
        _ if words.starts_with("missing field") => {
            match error.span().and_then(|span| table_at(text, span.start)) {
                Some(table) => text!("{table}: {message}", "{table}：{message}"),
                None => message,
            }
        }
        Some(key) if !words.contains(&format!("`{key}`")) => {
            text!("`{key}`: {message}", "`{key}`：{message}")
        }
        _ => message,
    };
    CellError::Schema {
        file: file.clone(),
        line,
        message,
    }
}

#[cfg(test)]
mod tests;
