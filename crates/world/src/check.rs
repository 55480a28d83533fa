//! Whether a description is one of a possible cell: ranges, names, points. Geometry (overlaps) is found when the world
//! is built.

use crate::check_entry::{Entry, Register};
use crate::description::*;
use crate::error::WorldError;
use messages::{Text, text};
use motion_api::IoPoint;
use motion_api::PointSet;
use std::collections::BTreeMap;

/// Parts at most.
pub const MAX_PARTS: usize = 200;
/// Entries of every other table, and cups of a gripper, at most.
pub const MAX_ENTRIES: usize = 50;
/// The name of the floor.
pub const FLOOR: &str = "floor";

/// The inputs that the world drives.
///
/// # Errors
/// The first thing that is wrong.
pub fn check(cell: &WorldDescription) -> Result<PointSet, WorldError> {
    settings(&cell.settings)?;
    let mut register = Register::default();
    register.names.insert(FLOOR, "world");
    counts(cell)?;
    for part in &cell.parts {
        check_part(&register.name("part", &part.name)?, part)?;
    }
    for obstacle in &cell.obstacles {
        let entry = register.name("obstacle", &obstacle.name)?;
        entry.shape("size", &obstacle.shape, true)?;
        entry.pose("pose", &obstacle.pose)?;
        entry.not_negative("friction", obstacle.friction)?;
    }
    for gripper in &cell.grippers {
        let entry = register.name("gripper", &gripper.name)?;
        match &gripper.kind {
            GripperKind::Vacuum(vacuum) => check_vacuum(&mut register, &entry, vacuum)?,
            GripperKind::Fingers(fingers) => check_fingers(&mut register, &entry, fingers)?,
        }
    }
    for conveyor in &cell.conveyors {
        check_conveyor(&register.name("conveyor", &conveyor.name)?, conveyor)?;
    }
    for sink in &cell.sinks {
        let entry = register.name("sink", &sink.name)?;
        entry.pose("pose", &sink.pose)?;
        entry.edges("size", &sink.size)?;
    }
    for detector in &cell.detectors {
        check_detector(&mut register, detector)?;
    }
    for actuator in &cell.actuators {
        check_actuator(&mut register, actuator)?;
    }
    for source in &cell.sources {
        let entry = register.name("source", &source.name)?;
        register.known(
            &entry,
            "part",
            &source.part,
            &["part"],
            text!("a [[part]]", "某个 [[part]]"),
        )?;
        entry.pose("pose", &source.pose)?;
        entry.trigger("every", &source.when, 1e-3)?;
        entry.not_negative("start_at", source.start_at)?;
        entry.finite("scatter", &source.scatter)?;
        if source.scatter.iter().any(|x| *x < 0.0) {
            return Err(entry.refuse(
                "scatter",
                format!("{:?}", source.scatter),
                text!("six numbers, not negative", "六个不小于 0 的数"),
            ));
        }
    }
    check_references(cell, &register)?;
    Ok(register.driven)
}

fn settings(settings: &Settings) -> Result<(), WorldError> {
    let entry = Entry {
        table: "world",
        name: "",
    };
    let Settings {
        period, substep, ..
    } = *settings;
    entry.within(
        "period",
        period,
        (0.0005..=0.02).contains(&period),
        text!("0.0005 s to 0.02 s", "0.0005 s 到 0.02 s"),
    )?;
    entry.within(
        "substep",
        substep,
        (0.0001..=period).contains(&substep),
        text!("0.0001 s up to the control cycle", "0.0001 s 到控制周期"),
    )?;
    entry.finite("gravity", &settings.gravity)?;
    entry.finite("floor", &[settings.floor.unwrap_or_default()])
}

fn counts(cell: &WorldDescription) -> Result<(), WorldError> {
    let of = |part: &PartDescription| {
        part.copies.map_or(1, |c| {
            c.count.iter().fold(1, |n: usize, x| n.saturating_mul(*x))
        })
    };
    let parts = cell.parts.iter().map(of).fold(0, usize::saturating_add);
    let tables = [
        ("part", parts, MAX_PARTS),
        ("obstacle", cell.obstacles.len(), MAX_PARTS),
        ("friction", cell.frictions.len(), MAX_PARTS),
        ("gripper", cell.grippers.len(), motion_api::MAX_GRIPPERS),
        ("conveyor", cell.conveyors.len(), MAX_ENTRIES),
        ("source", cell.sources.len(), MAX_ENTRIES),
        ("sink", cell.sinks.len(), MAX_ENTRIES),
        ("detector", cell.detectors.len(), MAX_ENTRIES),
        ("actuator", cell.actuators.len(), MAX_ENTRIES),
        ("fault", cell.faults.len(), MAX_ENTRIES),
    ];
    match tables
        .into_iter()
        .find(|(_, given, allowed)| given > allowed)
    {
        Some((table, given, allowed)) => Err(WorldError::TooMany {
            table,
            given,
            allowed,
        }),
        None => Ok(()),
    }
}

fn check_part(entry: &Entry<'_>, part: &PartDescription) -> Result<(), WorldError> {
    entry.shape("size", &part.shape, false)?;
    match part.mass {
        Mass::Total(mass) => entry.within(
            "mass",
            mass,
            (1e-4..=1e4).contains(&mass),
            text!("0.0001 kg to 10000 kg", "0.0001 kg 到 10000 kg"),
        )?,
        Mass::Density(density) => entry.within(
            "density",
            density,
            (1.0..=1e5).contains(&density),
            text!("1 kg/m³ to 100000 kg/m³", "1 kg/m³ 到 100000 kg/m³"),
        )?,
    }
    entry.pose("pose", &part.pose)?;
    entry.not_negative("friction", part.friction)?;
    entry.within(
        "restitution",
        part.restitution,
        (0.0..=1.0).contains(&part.restitution),
        text!("0 to 1", "0 到 1"),
    )?;
    if let Some(copies) = &part.copies {
        if copies.count.contains(&0) {
            return Err(entry.refuse(
                "copies",
                format!("{:?}", copies.count),
                text!("three whole numbers from 1", "三个不小于 1 的整数"),
            ));
        }
        entry.finite("pitch", &copies.pitch)?;
    }
    Ok(())
}

fn check_vacuum(
    register: &mut Register<'_>,
    entry: &Entry<'_>,
    vacuum: &Vacuum,
) -> Result<(), WorldError> {
    let cups = vacuum.cups.len();
    if cups == 0 || cups > MAX_ENTRIES {
        return Err(entry.refuse_given(
            "cups",
            text!("{cups} cups", "{cups} 个吸盘"),
            text!("1 to 50 cups", "1 到 50 个吸盘"),
        ));
    }
    entry.finite("cups", vacuum.cups.as_flattened())?;
    entry.direction("direction", &vacuum.direction)?;
    entry.within(
        "radius",
        vacuum.radius,
        (1e-3..=0.5).contains(&vacuum.radius),
        text!("0.001 m to 0.5 m", "0.001 m 到 0.5 m"),
    )?;
    let pressure = vacuum.pressure;
    entry.within(
        "pressure",
        pressure,
        pressure > 0.0 && pressure <= 101_325.0,
        text!(
            "more than 0 Pa, up to 101325 Pa",
            "大于 0 Pa、不超过 101325 Pa"
        ),
    )?;
    entry.within(
        "reach",
        vacuum.reach,
        (1e-4..=0.1).contains(&vacuum.reach),
        text!("0.0001 m to 0.1 m", "0.0001 m 到 0.1 m"),
    )?;
    entry.positive("build_up", vacuum.build_up)?;
    entry.positive("decay", vacuum.decay)?;
    let threshold = vacuum.threshold;
    entry.within(
        "threshold",
        threshold,
        threshold > 0.0 && threshold <= 1.0,
        text!("more than 0, up to 1", "大于 0、不超过 1"),
    )?;
    entry.digital("on", Some(vacuum.on))?;
    entry.digital("blow_off", vacuum.blow_off)?;
    entry.digital("switch", vacuum.switch)?;
    entry.analog("gauge", vacuum.gauge)?;
    register.drive(entry, "switch", vacuum.switch)?;
    register.drive(entry, "gauge", vacuum.gauge)
}

fn check_fingers(
    register: &mut Register<'_>,
    entry: &Entry<'_>,
    fingers: &Fingers,
) -> Result<(), WorldError> {
    entry.within(
        "stroke",
        fingers.stroke,
        (1e-3..=1.0).contains(&fingers.stroke),
        text!("0.001 m to 1 m", "0.001 m 到 1 m"),
    )?;
    entry.direction("axis", &fingers.axis)?;
    entry.shape("finger", &fingers.finger.0, false)?;
    entry.pose("finger", &fingers.finger.1)?;
    entry.positive("force", fingers.force)?;
    entry.within(
        "speed",
        fingers.speed,
        fingers.speed > 0.0 && fingers.speed <= 2.0,
        text!("more than 0 m/s, up to 2 m/s", "大于 0 m/s、不超过 2 m/s"),
    )?;
    entry.not_negative("friction", fingers.friction)?;
    if let FingerControl::Points { close, open } = fingers.control {
        if close.is_none() && open.is_none() {
            return Err(entry.refuse_given(
                "close",
                text!("missing", "缺失"),
                text!(
                    "an output in close, open or both",
                    "close、open 或两者中的输出"
                ),
            ));
        }
        entry.digital("close", close)?;
        entry.digital("open", open)?;
    }
    for (key, point) in [
        ("opened", fingers.opened),
        ("closed", fingers.closed),
        ("gripping", fingers.gripping),
    ] {
        entry.digital(key, point)?;
        register.drive(entry, key, point)?;
    }
    Ok(())
}

fn check_conveyor(entry: &Entry<'_>, conveyor: &ConveyorDescription) -> Result<(), WorldError> {
    match &conveyor.surface {
        Surface::Belt {
            pose,
            size,
            direction,
        } => {
            entry.pose("pose", pose)?;
            entry.edges("size", size)?;
            entry.direction("direction", direction)?;
        }
        Surface::Turntable { center, radius } => {
            entry.pose("center", center)?;
            entry.positive("radius", *radius)?;
        }
    }
    entry.finite("speed", &[conveyor.speed])?;
    entry.not_negative("friction", conveyor.friction)?;
    entry.positive("acceleration", conveyor.acceleration)?;
    entry.not_negative("start_at", conveyor.start_at)?;
    entry.digital("run", conveyor.run)?;
    entry.analog("speed_from", conveyor.speed_from)?;
    match conveyor.encoder {
        None | Some(0 | 1) => Ok(()),
        Some(other) => Err(entry.refuse("encoder", other, text!("0 or 1", "0 或 1"))),
    }
}

fn check_detector<'a>(
    register: &mut Register<'a>,
    detector: &'a Detector,
) -> Result<(), WorldError> {
    let entry = register.name("detector", &detector.name)?;
    entry.within(
        "delay",
        detector.delay,
        (0.0..=60.0).contains(&detector.delay),
        text!("0 s to 60 s", "0 s 到 60 s"),
    )?;
    match &detector.kind {
        DetectorKind::Beam { from, until } => {
            entry.finite("from", from)?;
            entry.finite("until", until)?;
            if from == until {
                return Err(entry.refuse(
                    "until",
                    format!("{until:?}"),
                    text!("another point than from", "与 from 不同的点"),
                ));
            }
            entry.digital("to", Some(detector.to))?;
        }
        DetectorKind::Presence { pose, size } => {
            entry.pose("pose", pose)?;
            entry.edges("size", size)?;
            entry.digital("to", Some(detector.to))?;
        }
        DetectorKind::Distance { pose, range } => {
            entry.pose("pose", pose)?;
            entry.positive("range", *range)?;
            entry.analog("to", Some(detector.to))?;
        }
    }
    register.drive(&entry, "to", Some(detector.to))
}

fn check_actuator<'a>(
    register: &mut Register<'a>,
    actuator: &'a Actuator,
) -> Result<(), WorldError> {
    let entry = register.name("actuator", &actuator.name)?;
    match &actuator.travel {
        Travel::Linear { axis, stroke } => {
            entry.direction("axis", axis)?;
            entry.within(
                "stroke",
                *stroke,
                (1e-3..=10.0).contains(stroke),
                text!("0.001 m to 10 m", "0.001 m 到 10 m"),
            )?;
        }
        Travel::Rotary { axis, point, angle } => {
            entry.direction("axis", axis)?;
            entry.finite("point", point)?;
            let is_less_than_half_a_turn = (1e-3..=3.1).contains(angle);
            entry.within(
                "angle",
                *angle,
                is_less_than_half_a_turn,
                text!("0.001 rad to 3.1 rad", "0.001 rad 到 3.1 rad"),
            )?;
        }
    }
    entry.within(
        "time",
        actuator.time,
        (0.01..=600.0).contains(&actuator.time),
        text!("0.01 s to 600 s", "0.01 s 到 600 s"),
    )?;
    entry.positive("force", actuator.force)?;
    entry.digital("extend", Some(actuator.extend))?;
    entry.digital("retract", actuator.retract)?;
    for (key, point) in [
        ("extended", actuator.extended),
        ("retracted", actuator.retracted),
    ] {
        entry.digital(key, point)?;
        register.drive(&entry, key, point)?;
    }
    for name in &actuator.moves {
        register.known(
            &entry,
            "moves",
            name,
            &["obstacle"],
            text!("an [[obstacle]]", "某个 [[obstacle]]"),
        )?;
    }
    Ok(())
}

/// Names that refer to other tables, once all names are there.
fn check_references(cell: &WorldDescription, register: &Register<'_>) -> Result<(), WorldError> {
    let mut moved = BTreeMap::new();
    for actuator in &cell.actuators {
        let entry = Entry {
            table: "actuator",
            name: &actuator.name,
        };
        if actuator.moves.is_empty() {
            return Err(entry.refuse(
                "moves",
                "[]",
                text!("the name of one obstacle or more", "一个或多个障碍物的名称"),
            ));
        }
        for name in &actuator.moves {
            let obstacle = cell.obstacles.iter().find(|o| o.name == *name);
            if obstacle.is_some_and(|o| o.shape == BodyShape::Plane) {
                return Err(entry.refuse(
                    "moves",
                    name,
                    text!("obstacles that are no planes", "不是平面的障碍物"),
                ));
            }
            if moved.insert(name, &actuator.name).is_some() {
                return Err(entry.refuse(
                    "moves",
                    name,
                    text!(
                        "obstacles that no actuator moves yet",
                        "尚无执行机构移动的障碍物"
                    ),
                ));
            }
        }
    }
    for pair in &cell.frictions {
        let entry = Entry {
            table: "friction",
            name: &pair.a,
        };
        entry.not_negative("value", pair.value)?;
        let tables = ["world", "part", "obstacle", "gripper", "conveyor"];
        for (key, name) in [("a", &pair.a), ("b", &pair.b)] {
            register.known(
                &entry,
                key,
                name,
                &tables,
                text!(
                    "a part, obstacle, gripper or conveyor, or \"floor\"",
                    "工件、障碍物、夹爪或传送带，或 \"floor\""
                ),
            )?;
        }
    }
    for fault in &cell.faults {
        check_fault(cell, register, fault)?;
    }
    Ok(())
}

fn check_fault(
    cell: &WorldDescription,
    register: &Register<'_>,
    fault: &FaultDescription,
) -> Result<(), WorldError> {
    let (name, tables, allowed): (&str, &[&str], _) = match &fault.what {
        FaultKind::Missing(name) | FaultKind::Turned(name) | FaultKind::Drop(name) => {
            (name, &["part"], text!("a [[part]]", "某个 [[part]]"))
        }
        FaultKind::Leak(name) => (
            name,
            &["gripper"],
            text!("a [[gripper]]", "某个 [[gripper]]"),
        ),
        FaultKind::Blocked(name) | FaultKind::Slow(name) => (
            name,
            &["actuator", "conveyor"],
            text!(
                "an [[actuator]] or [[conveyor]]",
                "某个 [[actuator]] 或 [[conveyor]]"
            ),
        ),
        FaultKind::Stuck(_) | FaultKind::Open(_) => ("", &[], Text::verbatim("")),
    };
    let entry = Entry {
        table: "fault",
        name,
    };
    entry.trigger("at", &fault.when, 0.0)?;
    if let Some(duration) = fault.duration {
        entry.positive("duration", duration)?;
    }
    match &fault.what {
        FaultKind::Stuck(point) | FaultKind::Open(point) => match point {
            IoPoint::Analog(_) => entry.analog("name", Some(*point)),
            _ => entry.digital("name", Some(*point)),
        },
        FaultKind::Missing(_) | FaultKind::Turned(_) | FaultKind::Drop(_) => {
            // Parts of a grid and of a source have names that grow out of that of their table.
            let template = name.split(['[', '#']).next().unwrap_or(name);
            let is_copy = part_names(cell).any(|n| n == name)
                || name.contains('#') && register.is(template, tables);
            match is_copy {
                true => Ok(()),
                false => Err(unknown(name, allowed)),
            }
        }
        _ => register.known(&entry, "name", name, tables, allowed),
    }
}

fn unknown(name: &str, allowed: Text) -> WorldError {
    WorldError::UnknownName {
        table: "fault",
        name: name.to_owned(),
        key: "name",
        given: name.to_owned(),
        allowed,
    }
}

/// Names of all parts that are there at the start or are templates, in the order of the file.
fn part_names(cell: &WorldDescription) -> impl Iterator<Item = String> {
    cell.parts.iter().flat_map(|part| {
        let count = part.copies.map(|c| c.count.iter().product::<usize>());
        let grid = (0..count.unwrap_or(0)).map(move |i| format!("{}[{i}]", part.name));
        grid.chain(count.is_none().then(|| part.name.clone()))
    })
}
