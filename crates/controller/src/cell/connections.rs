//! Connections of a cell: every input and output of the controller with the sensor, gripper or belt at its other end.

use super::Cell;
use super::point::{IoDirection, IoPointName};

/// A point, and what of the cell it is connected to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The input or output.
    pub point: IoPointName,
    /// Table of the cell file.
    pub table: &'static str,
    /// Name of the entry, or its number from 1.
    pub entry: String,
    /// Key of the entry.
    pub key: &'static str,
}

impl Cell {
    /// Every connection, in the order of the tables.
    pub fn connections(&self) -> Vec<Connection> {
        let tables = self.tables();
        let mut connections = Vec::new();
        let mut add = |table, entry: &str, points: &[(&'static str, Option<IoPointName>)]| {
            for (key, point) in points {
                let entry = entry.to_owned();
                connections.extend(point.map(|point| Connection {
                    point,
                    table,
                    entry,
                    key,
                }));
            }
        };
        for gripper in &tables.gripper {
            let points = [
                ("on", gripper.on),
                ("blow_off", gripper.blow_off),
                ("close", gripper.close),
                ("open", gripper.open),
                ("switch", gripper.switch),
                ("gauge", gripper.gauge),
                ("opened", gripper.opened),
                ("closed", gripper.closed),
                ("gripping", gripper.gripping),
            ];
            add("gripper", &gripper.name, &points);
        }
        for (number, belt) in (1..).zip(&tables.conveyor) {
            let entry = belt.name.clone().unwrap_or_else(|| format!("{number}"));
            add(
                "conveyor",
                &entry,
                &[("run", belt.run), ("speed_from", belt.speed_from)],
            );
        }
        for source in &tables.source {
            add("source", &source.name, &[("when", source.when)]);
        }
        for detector in &tables.detector {
            add("detector", &detector.name, &[("to", Some(detector.to))]);
        }
        for actuator in &tables.actuator {
            let points = [
                ("extend", Some(actuator.extend)),
                ("retract", actuator.retract),
                ("extended", actuator.extended),
                ("retracted", actuator.retracted),
            ];
            add("actuator", &actuator.name, &points);
        }
        for (number, fault) in (1..).zip(&tables.fault) {
            add("fault", &format!("{number}"), &[("when", fault.when)]);
        }
        for (number, wire) in (1..).zip(&tables.wire) {
            add(
                "wire",
                &format!("{number}"),
                &[("from", Some(wire.from)), ("to", Some(wire.to))],
            );
        }
        for (number, input) in (1..).zip(&tables.input) {
            add("input", &format!("{number}"), &[("set", Some(input.set))]);
        }
        for (points, function) in self.safety_input_pairs() {
            for point in points {
                add("safety_input", function, &[("pair", Some(point))]);
            }
        }
        connections
    }
}

impl Connection {
    /// Whether the entry gives the point its value.
    pub fn drives(&self) -> bool {
        self.point.direction == IoDirection::In
            && !matches!(self.table, "safety_input" | "fault" | "source")
    }
}
