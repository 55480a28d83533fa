//! `eliteserver cell`: what a cell file describes, which point is connected to what, and what is doubtful about it.

mod picture;

use std::io::Write;

use controller::cell::Cell;
use controller::cell::connections::Connection;
use controller::cell::point::{IoDirection, IoGroup};
use controller::cell_world::{WorldStart, check_world};
use kinematics::RobotModel;
use messages::{Text, text};
use motion::CycleConfig;
use serde_json::{Value as Json, json};

use crate::cli::{CellArgs, FindingFormat};
use crate::command::{CommandResult, CommandStatus};
use crate::language::{chosen, pick, shown};
use crate::ports::escape::EscapedLines;

/// What is doubtful about a cell that can be used.
struct Finding {
    message: Text,
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
fn counts(cell: &Cell) -> Vec<(Text, usize)> {
    let tables = cell.tables();
    let copies = |part: &controller::cell::world_schema::PartTable| {
        part.copies.map_or(1, |[x, y, z]| x * y * z)
    };
    let is_template = |name: &str| tables.source.iter().any(|source| source.part == name);
    let parts = tables.part.iter().filter(|part| !is_template(&part.name));
    let counts = [
        (text!("obstacles", "个障碍物"), tables.obstacle.len()),
        (
            text!("safety planes", "个安全平面"),
            tables.safety_plane.len(),
        ),
        (text!("parts", "个工件"), parts.map(copies).sum()),
        (text!("grippers", "个夹爪"), tables.gripper.len()),
        (text!("conveyors", "个传送带"), tables.conveyor.len()),
        (text!("sources", "个工件源"), tables.source.len()),
        (text!("sinks", "个工件出口"), tables.sink.len()),
        (text!("detectors", "个检测器"), tables.detector.len()),
        (text!("actuators", "个执行机构"), tables.actuator.len()),
        (text!("faults", "个故障"), tables.fault.len()),
        (text!("wires", "个接线"), tables.wire.len()),
        (text!("timed inputs", "个定时输入"), tables.input.len()),
        (text!("loads", "个载荷"), tables.wrench.len()),
        (text!("serial lines", "个串口"), tables.serial.len()),
        (
            text!("Modbus signals", "个 Modbus 信号"),
            tables.modbus.len(),
        ),
    ];
    counts.into_iter().filter(|(_, count)| *count > 0).collect()
}

/// What there is once or not at all: its word, and how it is told.
fn single_things(cell: &Cell) -> impl Iterator<Item = (&'static str, Text)> {
    let tables = cell.tables();
    let has_floor = tables.world.is_some_and(|world| world.floor.is_some());
    let things = [
        (has_floor, ("floor", text!("a floor", "地面"))),
        (
            tables.tool.is_some(),
            ("tool", text!("a tool on the flange", "法兰上的工具")),
        ),
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
                message: text!(
"{table} {entry:?}: {key} is {point}, which is an output of the tool unless the program makes it an input \
                     (set_tool_digital_config): nobody reads it",
"{table} {entry:?}：{key} 为 {point}，除非程序把它设为输入（set_tool_digital_config），它就是工具的输出：没有人读取它"
                ),
            });
        }
        let is_safety =
            |other: &&Connection| other.table == "safety_input" && other.point == *point;
        if let Some(safety) = connections.iter().find(is_safety) {
            findings.push(Finding {
                message: text!(
"{table} {entry:?}: {key} is {point}, which is wired to the safety system as {:?}: the program does not see it alone",
"{table} {entry:?}：{key} 为 {point}，它作为 {:?} 接到安全系统：不只是程序使用它",
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
                message: text!(
                    "names: {point} is called {name:?}, and nothing of the cell is connected to it",
                    "names：{point} 名为 {name:?}，而单元中没有任何东西与它相连"
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
        .map(|(words, count)| {
            let shown = words.in_language(chosen());
            match (count, shown.strip_suffix('s')) {
                (1, Some(word)) => format!("1 {word}"),
                _ => format!("{count} {shown}"),
            }
        })
        .chain(single_things(cell).map(|(_, words)| shown(&words).to_string()))
        .collect();
    let empty = text!("nothing stands in the cell", "单元中没有任何东西");
    match counts.is_empty() {
        true => text.push_str(&format!("{}\n", shown(&empty))),
        false => text.push_str(&format!("{}\n", counts.join(pick(", ", "，")))),
    }
    for mesh in cell.mesh_facts() {
        let fact = format!("  {}", shown(&mesh.text()));
        text.push_str(&format!("{}\n", EscapedLines(&fact)));
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
        let said = text!("warning: {}", "警告：{}", finding.message);
        text.push_str(&format!("{}\n", EscapedLines(said.in_language(chosen()))));
    }
    text
}

fn to_json(cell: &Cell, connections: &[Connection], findings: &[Finding]) -> Json {
    let counts: serde_json::Map<String, Json> = counts(cell)
        .into_iter()
        .map(|(words, count)| {
            (
                words.english().replace(' ', "_").to_lowercase(),
                json!(count),
            )
        })
        .chain(single_things(cell).map(|(word, _)| (word.to_owned(), json!(1))))
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
