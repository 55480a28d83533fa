//! What moves parts and sees them: `[[conveyor]]`, `[[source]]`, `[[detector]]`, `[[actuator]]`.

use messages::text;
use motion_api::IoPoint;
use world::description::*;

use super::keys::{edge, needed, optional};
use crate::cell::check::{InvalidValue, TableCheck};
use crate::cell::convert::pose_of;
use crate::cell::point::{IoDirection, IoPointName};
use crate::cell::schema;
use crate::cell::world_schema::{
    ActuatorEnd, ActuatorKindName, ActuatorTable, DetectorKindName, DetectorTable, SourceTable,
};

pub(super) fn conveyor(
    number: usize,
    table: &schema::Conveyor,
) -> Result<ConveyorDescription, InvalidValue> {
    let numbered = TableCheck::numbered("conveyor", number);
    let name = table.name.clone();
    let name = name.ok_or_else(|| {
        numbered.missing(
            "name",
            text!(
                "a conveyor that carries needs one",
                "运送工件的传送带需要给出它"
            ),
        )
    })?;
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
                text!("a belt that carries has pose, size and direction, a turntable center and radius",
                    "运送工件的皮带有 pose、size 和 direction，转台有 center 和 radius"),
            ));
        }
    };
    if let Some(point) = table.speed_from {
        check.direction("speed_from", point, IoDirection::Out)?;
        if !matches!(point.io_point(), IoPoint::Analog(_)) {
            return Err(check.wrong(
                "speed_from",
                point,
                text!("an analog output is needed", "需要一个模拟输出"),
            ));
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

pub(super) fn source(table: &SourceTable) -> Result<SourceDescription, InvalidValue> {
    let check = TableCheck::named("source", &table.name);
    let when = match (table.every, table.when) {
        (Some(period), None) => Trigger::Time(period),
        (None, Some(point)) => edge(&check, "when", point)?,
        (Some(period), Some(_)) => {
            return Err(check.wrong(
                "every",
                period,
                text!("either every or when is needed", "需要 every 或 when 之一"),
            ));
        }
        (None, None) => {
            return Err(check.missing(
                "every",
                text!("either every or when is needed", "需要 every 或 when 之一"),
            ));
        }
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

pub(super) fn detector(table: &DetectorTable) -> Result<Detector, InvalidValue> {
    let check = TableCheck::named("detector", &table.name);
    let is_analog = table.kind == DetectorKindName::Distance;
    let to = needed(&check, "to", Some(table.to), IoDirection::In)?;
    match to {
        IoPoint::Analog(_) if is_analog => {}
        IoPoint::Digital(_) | IoPoint::BooleanRegister(_) if !is_analog => {}
        _ => {
            let allowed = if is_analog {
                text!("an analog input is needed", "需要一个模拟输入")
            } else {
                text!("an input with levels is needed", "需要一个数字输入")
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
                DetectorKindName::Beam => (
                    "\"beam\"",
                    text!("a beam has from and until", "光束有 from 和 until"),
                ),
                DetectorKindName::Presence => (
                    "\"presence\"",
                    text!("a presence has pose and size", "存在检测有 pose 和 size"),
                ),
                DetectorKindName::Distance => (
                    "\"distance\"",
                    text!("a distance has pose and range", "测距有 pose 和 range"),
                ),
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

pub(super) fn actuator(table: &ActuatorTable) -> Result<Actuator, InvalidValue> {
    let check = TableCheck::named("actuator", &table.name);
    let axis = table.axis;
    let travel = match (table.kind, table.stroke, table.point, table.angle) {
        (ActuatorKindName::Linear, Some(stroke), None, None) => Travel::Linear { axis, stroke },
        (ActuatorKindName::Rotary, None, Some(point), Some(angle)) => {
            Travel::Rotary { axis, point, angle }
        }
        (kind, ..) => {
            let (word, allowed) = match kind {
                ActuatorKindName::Linear => (
                    "\"linear\"",
                    text!(
                        "a linear one has axis and stroke",
                        "直线型有 axis 和 stroke"
                    ),
                ),
                ActuatorKindName::Rotary => (
                    "\"rotary\"",
                    text!(
                        "a rotary one has axis, point and angle",
                        "旋转型有 axis、point 和 angle"
                    ),
                ),
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
