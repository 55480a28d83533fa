//! From the tables about parts and what handles them to the description of a world, which knows no file and no names of points.
//!
//! What a kind of an entry needs, and which keys it does not have, is settled here; ranges and names are checked by the world itself.

use kinematics::{Capsule, Pose, RobotModel};
use motion::contact::Obstacle;
use motion_api::IoPoint;
use nalgebra::Vector3;
use world::description::*;
use world::{FLOOR, WorldDescription};

use super::Cell;
use super::check::{InvalidValue, TableCheck};
use super::convert::pose_of;
use super::meshes::Meshes;
use super::point::{IoDirection, IoPointName};
use super::schema::{self, Tables};
use super::shape::{MESH_FILE, ShapeKeys, contact_pieces};
use super::world_schema::{
    ActuatorEnd, ActuatorKindName, ActuatorTable, DetectorKindName, DetectorTable, FaultName,
    FaultTable, GripperBus, GripperKindName, GripperTable, PartTable, SourceTable,
};

/// Friction of an obstacle towards parts where the file gives none.
const OBSTACLE_FRICTION: f64 = 0.5;

/// What decides about a world besides the cell file.
#[derive(Clone, Copy, Debug)]
pub struct WorldSettings<'a> {
    /// The arm.
    pub model: &'a RobotModel,
    /// Length of a control cycle, s.
    pub step_time: f64,
    /// Free-fall acceleration at the arm, base frame, m/s².
    pub gravity: Vector3<f64>,
    /// Seed of all scatter.
    pub seed: u64,
}

impl Cell {
    /// Whether the file has tables about parts or what handles them.
    pub fn has_world(&self) -> bool {
        has_world(self.tables())
    }

    /// The world that the file describes; `None` without such tables.
    pub fn world(&self, settings: &WorldSettings<'_>) -> Option<WorldDescription> {
        if !self.has_world() {
            return None;
        }
        // The tables were converted when the file was read, so they can be again.
        let mut description = description(self.tables(), self.meshes()).ok()?;
        description.arm = self.arm_shape(settings.model);
        description.settings.period = settings.step_time;
        description.settings.seed = settings.seed;
        let own = self.tables().world.unwrap_or_default();
        description.settings.gravity = own.gravity.unwrap_or(settings.gravity.into());
        description.settings.substep = own.substep.unwrap_or(0.001).min(settings.step_time);
        Some(description)
    }

    /// What the arm touches in the world besides the obstacles: floor and conveyors.
    pub(super) fn world_obstacles(&self) -> Vec<Obstacle> {
        let solids = self.world_solids().into_iter();
        let obstacles = solids.flat_map(|(name, solid, pose)| {
            let pieces = contact_pieces(&solid, pose).into_iter();
            pieces.map(move |solid| Obstacle {
                name: name.clone(),
                solid,
                body: None,
                stiffness: None,
                damping: 0.0,
                friction: 0.0,
            })
        });
        obstacles.collect()
    }

    /// What stands still in the cell, floor and conveyors included: name, solid, pose in the base frame.
    pub fn standing_solids(&self) -> Vec<(String, BodyShape, Pose)> {
        let tables = self.tables().obstacle.iter();
        let still = tables.filter(|table| !self.is_moved(&table.name));
        let obstacles = still.filter_map(|table| {
            let solid = table.shape_keys().solid(self.meshes())?;
            Some((table.name.clone(), solid, pose_of(&table.pose)))
        });
        obstacles.chain(self.world_solids()).collect()
    }

    /// `[tool]`: its solid, and the pose in the flange frame.
    pub fn tool_solid(&self) -> Option<(BodyShape, Pose)> {
        let tool = self.tables().tool.as_ref()?;
        let solid = tool.shape_keys().solid(self.meshes())?;
        Some((solid, pose_of(&tool.pose)))
    }

    /// Floor and conveyors: name, solid, pose in the base frame.
    pub(super) fn world_solids(&self) -> Vec<(String, BodyShape, Pose)> {
        let floor = self.tables().world.and_then(|world| world.floor);
        let floor = floor.map(|height| {
            let pose = Pose::from_translation(0.0, 0.0, height);
            (FLOOR.to_owned(), BodyShape::Plane, pose)
        });
        let belts = self.tables().conveyor.iter().filter_map(|belt| {
            let (pose, size) = (belt.pose?, belt.size?);
            Some((belt.name.clone()?, BodyShape::Box { size }, pose_of(&pose)))
        });
        floor.into_iter().chain(belts).collect()
    }

    /// The outside of the arm, with the tool.
    fn arm_shape(&self, model: &RobotModel) -> ArmShape {
        ArmShape {
            links: link_capsules(model),
            tool: self.tool_solid(),
        }
    }

    /// Names of obstacles that actuators move: the arm meets them in the world.
    pub(super) fn is_moved(&self, obstacle: &str) -> bool {
        let mut actuators = self.tables().actuator.iter();
        actuators.any(|actuator| actuator.moves.iter().any(|name| name == obstacle))
    }

    /// Ticks for a metre or a radian of the conveyors with a surface that turn encoders 0 and 1.
    pub(crate) fn world_encoders(&self) -> [Option<f64>; 2] {
        core::array::from_fn(|encoder| {
            let mut belts = self
                .tables()
                .conveyor
                .iter()
                .filter(|belt| belt.has_surface());
            let belt = belts.find(|belt| belt.encoder.map(usize::from) == Some(encoder))?;
            super::convert::ticks_per_unit(belt)
        })
    }
}

/// Whether there are tables about parts or what handles them.
pub(super) fn has_world(tables: &Tables) -> bool {
    let Tables {
        world,
        part,
        gripper,
        source,
        sink,
        detector,
        actuator,
        fault,
        ..
    } = tables;
    world.is_some()
        || !(part.is_empty()
            && gripper.is_empty()
            && source.is_empty()
            && sink.is_empty()
            && detector.is_empty()
            && actuator.is_empty()
            && fault.is_empty())
        || tables.conveyor.iter().any(schema::Conveyor::has_surface)
}

/// Everything but the arm, and what the start decides.
///
/// # Errors
/// The first table whose keys do not go together.
pub(super) fn description(
    tables: &Tables,
    meshes: &Meshes,
) -> Result<WorldDescription, InvalidValue> {
    let mut world = WorldDescription::default();
    world.settings.floor = tables.world.and_then(|world| world.floor);
    let obstacles = tables.obstacle.iter();
    world.obstacles = obstacles
        .filter_map(|table| obstacle(table, meshes))
        .collect();
    let parts = tables.part.iter();
    world.parts = parts
        .map(|table| part(table, meshes))
        .collect::<Result<_, _>>()?;
    check_buses(tables)?;
    world.frictions = tables
        .friction
        .iter()
        .map(|pair| PairFriction {
            a: pair.a.clone(),
            b: pair.b.clone(),
            value: pair.value,
        })
        .collect();
    world.grippers = tables
        .gripper
        .iter()
        .map(|table| gripper(table, meshes))
        .collect::<Result<_, _>>()?;
    let belts = tables.conveyor.iter().enumerate();
    world.conveyors = belts
        .filter(|(_, belt)| belt.has_surface())
        .map(|(number, belt)| conveyor(number, belt))
        .collect::<Result<_, _>>()?;
    world.sources = tables.source.iter().map(source).collect::<Result<_, _>>()?;
    world.sinks = tables
        .sink
        .iter()
        .map(|sink| Sink {
            name: sink.name.clone(),
            pose: pose_of(&sink.pose),
            size: sink.size,
        })
        .collect();
    world.detectors = tables
        .detector
        .iter()
        .map(detector)
        .collect::<Result<_, _>>()?;
    world.actuators = tables
        .actuator
        .iter()
        .map(actuator)
        .collect::<Result<_, _>>()?;
    let faults = tables.fault.iter().enumerate();
    world.faults = faults
        .map(|(number, entry)| fault(number, entry))
        .collect::<Result<_, _>>()?;
    Ok(world)
}

fn obstacle(table: &schema::Obstacle, meshes: &Meshes) -> Option<ObstacleDescription> {
    Some(ObstacleDescription {
        name: table.name.clone(),
        shape: table.shape_keys().solid(meshes)?,
        pose: pose_of(&table.pose),
        friction: table.friction.unwrap_or(OBSTACLE_FRICTION),
    })
}

/// Capsules of the links in the frames of their joints. The last link ends at the flange, whose capsule is rounder than that.
fn link_capsules(model: &RobotModel) -> Vec<(usize, Capsule)> {
    let frames = model.forward(&kinematics::JointPositions::ZERO);
    let flange_from_wrist =
        frames.base_from_flange.inverse() * frames.base_from_joint[kinematics::DOF - 1];
    let mut links = Vec::new();
    for joint in 0..kinematics::DOF {
        for capsule in model.collision().capsules(joint + 1) {
            let mut capsule = *capsule;
            if joint + 1 == kinematics::DOF {
                let back = flange_from_wrist.inverse();
                for end in [&mut capsule.p0, &mut capsule.p1] {
                    let mut at = flange_from_wrist.transform_point(*end);
                    at.z = at.z.min(-capsule.radius);
                    *end = back.transform_point(at);
                }
            }
            links.push((joint, capsule));
        }
    }
    links
}

/// The solid of something that is no plane.
fn solid(
    check: &TableCheck,
    keys: &ShapeKeys<'_>,
    meshes: &Meshes,
) -> Result<BodyShape, InvalidValue> {
    keys.check(check, false)?;
    let solid = keys.solid(meshes);
    solid.ok_or_else(|| check.missing("file", MESH_FILE))
}

fn part(table: &PartTable, meshes: &Meshes) -> Result<PartDescription, InvalidValue> {
    let check = TableCheck::named("part", &table.name);
    let shape = solid(&check, &table.shape_keys(), meshes)?;
    let mass = match (table.mass, table.density) {
        (Some(mass), None) => Mass::Total(mass),
        (None, Some(density)) => Mass::Density(density),
        (Some(mass), Some(_)) => {
            return Err(check.wrong("mass", mass, "either mass or density is needed"));
        }
        (None, None) => return Err(check.missing("mass", "either mass or density is needed")),
    };
    let copies = match (table.copies, table.pitch) {
        (Some(count), Some(pitch)) => Some(Copies { count, pitch }),
        (None, None) => None,
        (Some(count), None) if count.iter().all(|n| *n <= 1) => Some(Copies {
            count,
            pitch: [0.0; 3],
        }),
        (Some(_), None) => return Err(check.missing("pitch", "copies need their distances")),
        (None, Some(pitch)) => {
            return Err(check.wrong("pitch", format_args!("{pitch:?}"), "it goes with copies"));
        }
    };
    if let Some(color) = &table.color
        && !is_color(color)
    {
        return Err(check.wrong(
            "color",
            format_args!("{color:?}"),
            "a text like \"#3a7f00\" is needed",
        ));
    }
    Ok(PartDescription {
        name: table.name.clone(),
        shape,
        mass,
        pose: pose_of(&table.pose),
        friction: table.friction.unwrap_or(0.5),
        restitution: table.restitution.unwrap_or(0.0),
        copies,
    })
}

fn is_color(text: &str) -> bool {
    let digits = text.strip_prefix('#').unwrap_or_default();
    digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// A point that has to be there.
fn needed(
    check: &TableCheck,
    key: &'static str,
    point: Option<IoPointName>,
    direction: IoDirection,
) -> Result<IoPoint, InvalidValue> {
    let point = point.ok_or_else(|| check.missing(key, "this kind needs one"))?;
    optional(check, key, Some(point), direction).map(|_| point.io_point())
}

fn optional(
    check: &TableCheck,
    key: &'static str,
    point: Option<IoPointName>,
    direction: IoDirection,
) -> Result<Option<IoPoint>, InvalidValue> {
    let Some(point) = point else { return Ok(None) };
    check.direction(key, point, direction)?;
    Ok(Some(point.io_point()))
}

/// Keys that belong to the other kind of an entry.
fn refuse_keys(
    check: &TableCheck,
    kind: &str,
    keys: &[(&'static str, bool)],
) -> Result<(), InvalidValue> {
    match keys.iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => {
            Err(check.wrong(key, "given", format!("kind = \"{kind}\" has no such key")))
        }
        None => Ok(()),
    }
}

fn gripper(table: &GripperTable, meshes: &Meshes) -> Result<Gripper, InvalidValue> {
    let check = TableCheck::named("gripper", &table.name);
    let kind = match table.kind {
        GripperKindName::Vacuum => GripperKind::Vacuum(vacuum(&check, table)?),
        GripperKindName::Fingers => GripperKind::Fingers(fingers(&check, table, meshes)?),
    };
    Ok(Gripper {
        name: table.name.clone(),
        kind,
    })
}

fn vacuum(check: &TableCheck, table: &GripperTable) -> Result<Vacuum, InvalidValue> {
    refuse_keys(
        check,
        "vacuum",
        &[
            ("stroke", table.stroke.is_some()),
            ("axis", table.axis.is_some()),
            ("finger", table.finger.is_some()),
            ("force", table.force.is_some()),
            ("speed", table.speed.is_some()),
            ("friction", table.friction.is_some()),
            ("close", table.close.is_some()),
            ("open", table.open.is_some()),
            ("opened", table.opened.is_some()),
            ("closed", table.closed.is_some()),
            ("gripping", table.gripping.is_some()),
            ("protocol", table.protocol.is_some()),
            ("bus", table.bus.is_some()),
            ("slave", table.slave.is_some()),
        ],
    )?;
    let cups = table.cups.clone();
    let gauge = optional(check, "gauge", table.gauge, IoDirection::In)?;
    if let (Some(IoPoint::Digital(_) | IoPoint::BooleanRegister(_)), Some(given)) =
        (gauge, table.gauge)
    {
        return Err(check.wrong("gauge", given, "an analog input is needed"));
    }
    Ok(Vacuum {
        cups: cups.ok_or_else(|| check.missing("cups", "the middles of the rims are needed"))?,
        direction: table.direction.unwrap_or([0.0, 0.0, 1.0]),
        radius: table
            .radius
            .ok_or_else(|| check.missing("radius", "cups need their radius, m"))?,
        pressure: table.pressure.unwrap_or(60_000.0),
        reach: table.reach.unwrap_or(0.003),
        build_up: table.build_up.unwrap_or(0.1),
        decay: table.decay.unwrap_or(0.05),
        on: needed(check, "on", table.on, IoDirection::Out)?,
        blow_off: optional(check, "blow_off", table.blow_off, IoDirection::Out)?,
        switch: optional(check, "switch", table.switch, IoDirection::In)?,
        threshold: table.threshold.unwrap_or(0.7),
        gauge,
    })
}

fn fingers(
    check: &TableCheck,
    table: &GripperTable,
    meshes: &Meshes,
) -> Result<Fingers, InvalidValue> {
    refuse_keys(
        check,
        "fingers",
        &[
            ("cups", table.cups.is_some()),
            ("direction", table.direction.is_some()),
            ("radius", table.radius.is_some()),
            ("pressure", table.pressure.is_some()),
            ("reach", table.reach.is_some()),
            ("build_up", table.build_up.is_some()),
            ("decay", table.decay.is_some()),
            ("on", table.on.is_some()),
            ("blow_off", table.blow_off.is_some()),
            ("switch", table.switch.is_some()),
            ("threshold", table.threshold.is_some()),
            ("gauge", table.gauge.is_some()),
        ],
    )?;
    let control = finger_control(check, table)?;
    let finger = table.finger.as_ref().ok_or_else(|| {
        check.missing(
            "finger",
            "the shape of a finger is needed: { size = […], pose = […] } for a box",
        )
    })?;
    let shape = solid(check, &finger.shape_keys(), meshes)?;
    let number = |key: &'static str, value: Option<f64>, what: &str| {
        value.ok_or_else(|| check.missing(key, what))
    };
    Ok(Fingers {
        stroke: number("stroke", table.stroke, "the opening in m is needed")?,
        axis: table.axis.unwrap_or([0.0, 1.0, 0.0]),
        finger: (shape, pose_of(&finger.pose)),
        force: number("force", table.force, "the force in N is needed")?,
        speed: number("speed", table.speed, "the speed in m/s is needed")?,
        friction: table.friction.unwrap_or(0.5),
        control,
        opened: optional(check, "opened", table.opened, IoDirection::In)?,
        closed: optional(check, "closed", table.closed, IoDirection::In)?,
        gripping: optional(check, "gripping", table.gripping, IoDirection::In)?,
    })
}

/// Points, or a Modbus map on a bus.
fn finger_control(check: &TableCheck, table: &GripperTable) -> Result<FingerControl, InvalidValue> {
    if table.protocol.is_none() {
        for (key, given) in [
            ("bus", table.bus.is_some()),
            ("slave", table.slave.is_some()),
        ] {
            if given {
                return Err(check.wrong(key, "given", "it goes with protocol"));
            }
        }
        let close = optional(check, "close", table.close, IoDirection::Out)?;
        let open = optional(check, "open", table.open, IoDirection::Out)?;
        if close.is_none() && open.is_none() {
            return Err(check.missing("close", "an output close or open is needed"));
        }
        return Ok(FingerControl::Points { close, open });
    }
    for (key, given) in [
        ("close", table.close),
        ("open", table.open),
        ("opened", table.opened),
        ("closed", table.closed),
        ("gripping", table.gripping),
    ] {
        if let Some(point) = given {
            return Err(check.wrong(key, point, "a gripper with protocol has no points"));
        }
    }
    let buses = "a bus is needed: \"tool\", \"masterboard\" or \"tcp:PORT\"";
    let bus = table.bus.as_ref();
    let bus = bus.ok_or_else(|| check.missing("bus", buses))?;
    if table.modbus_bus().is_none() {
        let allowed =
            "allowed are \"tool\", \"masterboard\" and \"tcp:PORT\" with a port from 1 to 65535";
        return Err(check.wrong("bus", format_args!("{bus:?}"), allowed));
    }
    if !(1..=247).contains(&table.slave_number()) {
        return Err(check.wrong("slave", table.slave_number(), "allowed are 1 to 247"));
    }
    Ok(FingerControl::Orders)
}

/// Refuses two grippers of one number on a bus, and a gripper on a line that leads out.
fn check_buses(tables: &Tables) -> Result<(), InvalidValue> {
    for (index, table) in tables.gripper.iter().enumerate() {
        let Some(bus) = table.modbus_bus() else {
            continue;
        };
        let check = TableCheck::named("gripper", &table.name);
        let leads_out = |serial: &schema::Serial| GripperBus::Serial(serial.port) == bus;
        if tables.serial.iter().any(leads_out) {
            let given = format!("{:?}", table.bus.as_deref().unwrap_or_default());
            return Err(check.wrong("bus", given, "a [[serial]] has this line already"));
        }
        let same = |other: &&GripperTable| {
            other.modbus_bus() == Some(bus) && other.slave_number() == table.slave_number()
        };
        if let Some(other) = tables.gripper[..index].iter().find(same) {
            let allowed = format!(
                "gripper {:?} has this number on the bus already",
                other.name
            );
            return Err(check.wrong("slave", table.slave_number(), allowed));
        }
    }
    Ok(())
}

fn conveyor(number: usize, table: &schema::Conveyor) -> Result<ConveyorDescription, InvalidValue> {
    let numbered = TableCheck::numbered("conveyor", number);
    let name = table.name.clone();
    let name = name.ok_or_else(|| numbered.missing("name", "a conveyor that carries needs one"))?;
    let check = TableCheck::named("conveyor", &name);
    let surface = match (
        table.pose,
        table.size,
        table.radius,
        table.direction,
        table.center,
    ) {
        (Some(pose), Some(size), None, Some(direction), None) => Surface::Belt {
            pose: pose_of(&pose),
            size,
            direction,
        },
        (None, None, Some(radius), None, Some(center)) => Surface::Turntable {
            center: pose_of(&center),
            radius,
        },
        _ => {
            return Err(check.missing(
                "pose",
                "a belt that carries has pose, size and direction, a turntable center and radius",
            ));
        }
    };
    if let Some(point) = table.speed_from {
        check.direction("speed_from", point, IoDirection::Out)?;
        if !matches!(point.io_point(), IoPoint::Analog(_)) {
            return Err(check.wrong("speed_from", point, "an analog output is needed"));
        }
    }
    Ok(ConveyorDescription {
        surface,
        speed: table.speed,
        friction: table.friction.unwrap_or(0.6),
        run: optional(&check, "run", table.run, IoDirection::Out)?,
        speed_from: table.speed_from.map(IoPointName::io_point),
        acceleration: table.acceleration.unwrap_or(2.0),
        start_at: table.start_at,
        encoder: table.encoder,
        name,
    })
}

/// The point of a rising edge.
fn edge(
    check: &TableCheck,
    key: &'static str,
    point: IoPointName,
) -> Result<Trigger, InvalidValue> {
    match (point.io_point(), point.direction) {
        (IoPoint::IntegerRegister(_) | IoPoint::FloatRegister(_), _) => {
            Err(check.wrong(key, point, "a point with levels is needed"))
        }
        (at, IoDirection::Out) => Ok(Trigger::Output(at)),
        (at, IoDirection::In) => Ok(Trigger::Input(at)),
    }
}

fn source(table: &SourceTable) -> Result<SourceDescription, InvalidValue> {
    let check = TableCheck::named("source", &table.name);
    let when = match (table.every, table.when) {
        (Some(period), None) => Trigger::Time(period),
        (None, Some(point)) => edge(&check, "when", point)?,
        (Some(period), Some(_)) => {
            return Err(check.wrong("every", period, "either every or when is needed"));
        }
        (None, None) => return Err(check.missing("every", "either every or when is needed")),
    };
    Ok(SourceDescription {
        name: table.name.clone(),
        part: table.part.clone(),
        pose: pose_of(&table.pose),
        when,
        start_at: table.start_at,
        limit: table.limit,
        scatter: table.scatter,
    })
}

fn detector(table: &DetectorTable) -> Result<Detector, InvalidValue> {
    let check = TableCheck::named("detector", &table.name);
    let is_analog = table.kind == DetectorKindName::Distance;
    let to = needed(&check, "to", Some(table.to), IoDirection::In)?;
    match to {
        IoPoint::Analog(_) if is_analog => {}
        IoPoint::Digital(_) | IoPoint::BooleanRegister(_) if !is_analog => {}
        _ => {
            let allowed = if is_analog {
                "an analog input is needed"
            } else {
                "an input with levels is needed"
            };
            return Err(check.wrong("to", table.to, allowed));
        }
    }
    let kind = match (
        table.kind,
        table.from,
        table.until,
        table.pose,
        table.size,
        table.range,
    ) {
        (DetectorKindName::Beam, Some(from), Some(until), None, None, None) => {
            DetectorKind::Beam { from, until }
        }
        (DetectorKindName::Presence, None, None, Some(pose), Some(size), None) => {
            DetectorKind::Presence {
                pose: pose_of(&pose),
                size,
            }
        }
        (DetectorKindName::Distance, None, None, Some(pose), None, Some(range)) => {
            DetectorKind::Distance {
                pose: pose_of(&pose),
                range,
            }
        }
        (kind, ..) => {
            let (word, allowed) = match kind {
                DetectorKindName::Beam => ("\"beam\"", "a beam has from and until"),
                DetectorKindName::Presence => ("\"presence\"", "a presence has pose and size"),
                DetectorKindName::Distance => ("\"distance\"", "a distance has pose and range"),
            };
            return Err(check.wrong("kind", word, allowed));
        }
    };
    Ok(Detector {
        name: table.name.clone(),
        to,
        delay: table.delay,
        inverted: table.inverted,
        kind,
    })
}

fn actuator(table: &ActuatorTable) -> Result<Actuator, InvalidValue> {
    let check = TableCheck::named("actuator", &table.name);
    let axis = table.axis;
    let travel = match (table.kind, table.stroke, table.point, table.angle) {
        (ActuatorKindName::Linear, Some(stroke), None, None) => Travel::Linear { axis, stroke },
        (ActuatorKindName::Rotary, None, Some(point), Some(angle)) => {
            Travel::Rotary { axis, point, angle }
        }
        (kind, ..) => {
            let (word, allowed) = match kind {
                ActuatorKindName::Linear => ("\"linear\"", "a linear one has axis and stroke"),
                ActuatorKindName::Rotary => {
                    ("\"rotary\"", "a rotary one has axis, point and angle")
                }
            };
            return Err(check.wrong("kind", word, allowed));
        }
    };
    Ok(Actuator {
        name: table.name.clone(),
        travel,
        moves: table.moves.clone(),
        time: table.time.unwrap_or(0.5),
        force: table.force.unwrap_or(200.0),
        extend: needed(&check, "extend", Some(table.extend), IoDirection::Out)?,
        retract: optional(&check, "retract", table.retract, IoDirection::Out)?,
        extended: optional(&check, "extended", table.extended, IoDirection::In)?,
        retracted: optional(&check, "retracted", table.retracted, IoDirection::In)?,
        starts_extended: table.at_start == ActuatorEnd::Extended,
    })
}

fn fault(number: usize, table: &FaultTable) -> Result<FaultDescription, InvalidValue> {
    let check = TableCheck::numbered("fault", number);
    let when = match (table.at, table.when) {
        (Some(at), None) => Trigger::Time(at),
        (None, Some(point)) => edge(&check, "when", point)?,
        (Some(at), Some(_)) => return Err(check.wrong("at", at, "either at or when is needed")),
        (None, None) => return Err(check.missing("at", "either at or when is needed")),
    };
    Ok(FaultDescription {
        when,
        what: fault_kind(&check, table.what, &table.name)?,
        duration: table.duration,
    })
}

/// A fault by its word in the cell file and the name of a thing or an input.
///
/// # Errors
/// A sentence that names the argument, what was given and what is allowed.
pub fn fault_of(what: &str, name: &str) -> Result<FaultKind, String> {
    let Some(kind) = FaultName::ALL.into_iter().find(|kind| kind.word() == what) else {
        let words: Vec<_> = FaultName::ALL
            .iter()
            .map(|kind| format!("{:?}", kind.word()))
            .collect();
        return Err(format!(
            "what is {what:?}; allowed are {}",
            words.join(", ")
        ));
    };
    let check = TableCheck::named("fault", what);
    fault_kind(&check, kind, name)
        .map_err(|wrong| format!("{} is {}; {}", wrong.key, wrong.given, wrong.allowed))
}

/// A fault of a thing or an input that is given by name.
fn fault_kind(check: &TableCheck, what: FaultName, name: &str) -> Result<FaultKind, InvalidValue> {
    if what.is_of_input() {
        let point: IoPointName = name
            .parse()
            .map_err(|reason: String| check.wrong("name", format_args!("{name:?}"), reason))?;
        let point = needed(check, "name", Some(point), IoDirection::In)?;
        return Ok(match what {
            FaultName::Stuck => FaultKind::Stuck(point),
            _ => FaultKind::Open(point),
        });
    }
    let name = name.to_owned();
    Ok(match what {
        FaultName::Missing => FaultKind::Missing(name),
        FaultName::Turned => FaultKind::Turned(name),
        FaultName::Drop => FaultKind::Drop(name),
        FaultName::Leak => FaultKind::Leak(name),
        FaultName::Blocked => FaultKind::Blocked(name),
        FaultName::Slow | FaultName::Stuck | FaultName::Open => FaultKind::Slow(name),
    })
}
