//! `eliteserver cell`: what a cell file describes, which point is connected to what, and what is doubtful about it.

mod picture;

use std::io::Write;

use controller::cell::Cell;
use controller::cell::connections::Connection;
use controller::cell::point::{IoDirection, IoGroup};
use controller::cell_world::{WorldStart, check_world};
use kinematics::RobotModel;
use motion::CycleConfig;
use serde_json::{Value as Json, json};

use crate::cli::{CellArgs, FindingFormat};
use crate::command::{CommandResult, CommandStatus};
use crate::language::{pick, told};
use crate::ports::escape::EscapedLines;

/// What is doubtful about a cell that can be used.
struct Finding {
    message: String,
}

/// Exit status: 0 clean, 1 findings, 2 unreadable.
pub fn run(args: &CellArgs) -> CommandResult {
    let cell = Cell::load(&args.file)?;
    // Which arm stands there is not in the file; parts that overlap, and what the picture shows, do not depend on it.
    let config = CycleConfig::new(RobotModel::built_in("cs66")?);
    let start = WorldStart {
        model: &config.model,
        step_time: config.step_time,
        gravity: config.gravity,
        seed: 0,
    };
    let description = check_world(&cell, &start)?;
    let connections = cell.connections();
    let findings = findings(&cell, &connections);
    let shown = match args.format {
        FindingFormat::Human => text(&cell, &connections, &findings),
        FindingFormat::Json => format!("{}\n", to_json(&cell, &connections, &findings)),
    };
    // Whoever reads may have seen enough; the status still tells.
    let _ = std::io::stdout().write_all(shown.as_bytes());
    if let Some(path) = &args.picture {
        picture::figure(&cell, description.as_ref(), &config).save(path)?;
    }
    Ok(CommandStatus::of_answer(findings.is_empty()))
}

/// What each table holds: its word, and how many entries.
fn counts(cell: &Cell) -> Vec<(&'static str, usize)> {
    let tables = cell.tables();
    let copies = |part: &controller::cell::world_schema::PartTable| {
        part.copies.map_or(1, |[x, y, z]| x * y * z)
    };
    let is_template = |name: &str| tables.source.iter().any(|source| source.part == name);
    let parts = tables.part.iter().filter(|part| !is_template(&part.name));
    let counts = [
        ("obstacles", tables.obstacle.len()),
        ("safety planes", tables.safety_plane.len()),
        ("parts", parts.map(copies).sum()),
        ("grippers", tables.gripper.len()),
        ("conveyors", tables.conveyor.len()),
        ("sources", tables.source.len()),
        ("sinks", tables.sink.len()),
        ("detectors", tables.detector.len()),
        ("actuators", tables.actuator.len()),
        ("faults", tables.fault.len()),
        ("wires", tables.wire.len()),
        ("timed inputs", tables.input.len()),
        ("loads", tables.wrench.len()),
        ("serial lines", tables.serial.len()),
        ("Modbus signals", tables.modbus.len()),
    ];
    counts.into_iter().filter(|(_, count)| *count > 0).collect()
}

/// What there is once or not at all: its word, and how it is told.
fn single_things(cell: &Cell) -> impl Iterator<Item = (&'static str, &'static str)> {
    let tables = cell.tables();
    let has_floor = tables.world.is_some_and(|world| world.floor.is_some());
    let things = [
        (has_floor, ("floor", "a floor")),
        (tables.tool.is_some(), ("tool", "a tool on the flange")),
    ];
    things
        .into_iter()
        .filter_map(|(is_there, thing)| is_there.then_some(thing))
}

/// A gripper with a Modbus map, and where it is reached.
struct BusGripper<'a> {
    name: &'a str,
    protocol: &'static str,
    bus: &'a str,
    slave: u8,
}

fn bus_grippers(cell: &Cell) -> impl Iterator<Item = BusGripper<'_>> {
    cell.tables().gripper.iter().filter_map(|gripper| {
        Some(BusGripper {
            name: &gripper.name,
            protocol: gripper.protocol?.word(),
            bus: gripper.bus.as_deref()?,
            slave: gripper.slave_number(),
        })
    })
}

fn findings(cell: &Cell, connections: &[Connection]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for connection in connections.iter().filter(|connection| connection.drives()) {
        let Connection {
            point,
            table,
            entry,
            key,
        } = connection;
        // The default of the tool's pins: 0 and 1 are outputs.
        if point.group == IoGroup::ToolDigital && point.index < 2 {
            findings.push(Finding {
                message: format!(
                    "{table} {entry:?}: {key} is {point}, which is an output of the tool unless the program makes it an input \
                     (set_tool_digital_config): nobody reads it"
                ),
            });
        }
        let is_safety =
            |other: &&Connection| other.table == "safety_input" && other.point == *point;
        if let Some(safety) = connections.iter().find(is_safety) {
            findings.push(Finding {
                message: format!(
                    "{table} {entry:?}: {key} is {point}, which is wired to the safety system as {:?}: the program does not see it alone",
                    safety.entry
                ),
            });
        }
    }
    for (point, name) in cell.point_names() {
        let is_connected = connections
            .iter()
            .any(|connection| connection.point == point);
        if !is_connected && cell.has_world() && point.direction == IoDirection::In {
            findings.push(Finding {
                message: format!(
                    "names: {point} is called {name:?}, and nothing of the cell is connected to it"
                ),
            });
        }
    }
    findings
}

fn text(cell: &Cell, connections: &[Connection], findings: &[Finding]) -> String {
    let mut text = String::new();
    let counts: Vec<String> = counts(cell)
        .iter()
        .map(|(words, count)| match (count, words.strip_suffix('s')) {
            (1, Some(word)) => format!("1 {}", pick(word, &told(words))),
            _ => format!("{count} {}", told(words)),
        })
        .chain(single_things(cell).map(|(_, words)| told(words).into_owned()))
        .collect();
    match counts.is_empty() {
        true => text.push_str(&told("nothing stands in the cell\n")),
        false => text.push_str(&format!("{}\n", counts.join(pick(", ", "，")))),
    }
    for mesh in cell.mesh_facts() {
        let said = format!("{}\n", EscapedLines(&format!("  {mesh}")));
        text.push_str(&told(&said));
    }
    let name_of = |connection: &Connection| {
        let mut names = cell.point_names();
        names
            .find(|(point, _)| *point == connection.point)
            .map(|(_, name)| format!(" ({name})"))
            .unwrap_or_default()
    };
    let points: Vec<String> = connections
        .iter()
        .map(|c| format!("{}{}", c.point, name_of(c)))
        .collect();
    let buses = bus_grippers(cell).map(|gripper| gripper.bus.chars().count());
    let width = points
        .iter()
        .map(|point| point.chars().count())
        .chain(buses)
        .max()
        .unwrap_or(0);
    for (connection, point) in connections.iter().zip(&points) {
        let arrow = if connection.drives() { "<-" } else { "->" };
        let Connection {
            table, entry, key, ..
        } = connection;
        let line = format!("  {point:width$}  {arrow} {table} {entry}, {key}");
        text.push_str(&format!("{}\n", EscapedLines(&line)));
    }
    for gripper in bus_grippers(cell) {
        let BusGripper {
            name,
            protocol,
            bus,
            slave,
        } = gripper;
        let (table, key) = ("gripper", "slave");
        let line = format!("  {bus:width$}  <> {table} {name}, {key} {slave}, {protocol}");
        text.push_str(&format!("{}\n", EscapedLines(&line)));
    }
    for finding in findings {
        let said = format!("warning: {}\n", EscapedLines(&finding.message));
        text.push_str(&told(&said));
    }
    text
}

fn to_json(cell: &Cell, connections: &[Connection], findings: &[Finding]) -> Json {
    let counts: serde_json::Map<String, Json> = counts(cell)
        .into_iter()
        .chain(single_things(cell).map(|(word, _)| (word, 1)))
        .map(|(word, count)| (word.replace(' ', "_").to_lowercase(), json!(count)))
        .collect();
    let buses: Vec<Json> = bus_grippers(cell)
        .map(|gripper| {
            json!({
                "gripper": gripper.name,
                "protocol": gripper.protocol,
                "bus": gripper.bus,
                "slave": gripper.slave,
            })
        })
        .collect();
    let connections: Vec<Json> = connections
        .iter()
        .map(|connection| {
            json!({
                "point": connection.point.to_string(),
                "table": connection.table,
                "entry": connection.entry,
                "key": connection.key,
                "drives": connection.drives(),
            })
        })
        .collect();
    let findings: Vec<Json> = findings
        .iter()
        .map(|finding| json!({"severity": "warning", "message": finding.message}))
        .collect();
    let meshes: Vec<Json> = cell
        .mesh_facts()
        .iter()
        .map(|mesh| {
            json!({
                "table": mesh.table,
                "file": mesh.file,
                "triangles": mesh.triangles,
                "volume": mesh.volume,
                "pieces": mesh.pieces,
                "deviation": mesh.deviation,
            })
        })
        .collect();
    json!({
        "counts": counts,
        "meshes": meshes,
        "connections": connections,
        "buses": buses,
        "findings": findings,
    })
}
