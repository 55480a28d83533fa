//! `[[gripper]]`: cups, fingers, and the buses that fingers are told by.

use messages::{Text, text};
use motion_api::IoPoint;
use world::description::*;

use super::keys::{needed, optional, refuse_keys};
use super::parts::solid;
use crate::cell::check::{InvalidValue, TableCheck};
use crate::cell::convert::pose_of;
use crate::cell::meshes::Meshes;
use crate::cell::point::IoDirection;
use crate::cell::schema::{self, Tables};
use crate::cell::world_schema::{GripperBus, GripperKindName, GripperTable};

pub(super) fn gripper(table: &GripperTable, meshes: &Meshes) -> Result<Gripper, InvalidValue> {
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
        return Err(check.wrong(
            "gauge",
            given,
            text!("an analog input is needed", "需要一个模拟输入"),
        ));
    }
    Ok(Vacuum {
        cups: cups.ok_or_else(|| {
            check.missing(
                "cups",
                text!("the middles of the rims are needed", "需要各吸盘口的中心"),
            )
        })?,
        direction: table.direction.unwrap_or([0.0, 0.0, 1.0]),
        radius: table.radius.ok_or_else(|| {
            check.missing(
                "radius",
                text!("cups need their radius, m", "吸盘需要半径，m"),
            )
        })?,
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
            text!(
                "the shape of a finger is needed: {{ size = […], pose = […] }} for a box",
                "需要手指的形状：箱体用 {{ size = […], pose = […] }}"
            ),
        )
    })?;
    let shape = solid(check, &finger.shape_keys(), meshes)?;
    let number = |key: &'static str, value: Option<f64>, what: Text| {
        value.ok_or_else(|| check.missing(key, what))
    };
    Ok(Fingers {
        stroke: number(
            "stroke",
            table.stroke,
            text!("the opening in m is needed", "需要开口宽度，m"),
        )?,
        axis: table.axis.unwrap_or([0.0, 1.0, 0.0]),
        finger: (shape, pose_of(&finger.pose)),
        force: number(
            "force",
            table.force,
            text!("the force in N is needed", "需要力，N"),
        )?,
        speed: number(
            "speed",
            table.speed,
            text!("the speed in m/s is needed", "需要速度，m/s"),
        )?,
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
                return Err(check.needless(
                    key,
                    text!("it goes with protocol", "它与 protocol 一起使用"),
                ));
            }
        }
        let close = optional(check, "close", table.close, IoDirection::Out)?;
        let open = optional(check, "open", table.open, IoDirection::Out)?;
        if close.is_none() && open.is_none() {
            return Err(check.missing(
                "close",
                text!(
                    "an output close or open is needed",
                    "需要输出 close 或 open"
                ),
            ));
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
            return Err(check.wrong(
                key,
                point,
                text!(
                    "a gripper with protocol has no points",
                    "带 protocol 的夹爪没有输入输出点"
                ),
            ));
        }
    }
    let buses = text!(
        "a bus is needed: \"tool\", \"masterboard\" or \"tcp:PORT\"",
        "需要总线：\"tool\"、\"masterboard\" 或 \"tcp:端口\""
    );
    let bus = table.bus.as_ref();
    let bus = bus.ok_or_else(|| check.missing("bus", buses))?;
    if table.modbus_bus().is_none() {
        let allowed = text!(
            "allowed are \"tool\", \"masterboard\" and \"tcp:PORT\" with a port from 1 to 65535",
            "允许 \"tool\"、\"masterboard\" 和 \"tcp:端口\"，端口为 1 到 65535"
        );
        return Err(check.wrong("bus", format_args!("{bus:?}"), allowed));
    }
    if !(1..=247).contains(&table.slave_number()) {
        return Err(check.wrong(
            "slave",
            table.slave_number(),
            text!("allowed are 1 to 247", "允许 1 到 247"),
        ));
    }
    Ok(FingerControl::Orders)
}

/// Refuses two grippers of one number on a bus, and a gripper on a line that leads out.
pub(super) fn check_buses(tables: &Tables) -> Result<(), InvalidValue> {
    for (index, table) in tables.gripper.iter().enumerate() {
        let Some(bus) = table.modbus_bus() else {
            continue;
        };
        let check = TableCheck::named("gripper", &table.name);
        let leads_out = |serial: &schema::Serial| GripperBus::Serial(serial.port) == bus;
        if tables.serial.iter().any(leads_out) {
            let given = format!("{:?}", table.bus.as_deref().unwrap_or_default());
            return Err(check.wrong(
                "bus",
                given,
                text!(
                    "a [[serial]] has this line already",
                    "已有 [[serial]] 使用此串口"
                ),
            ));
        }
        let same = |other: &&GripperTable| {
            other.modbus_bus() == Some(bus) && other.slave_number() == table.slave_number()
        };
        if let Some(other) = tables.gripper[..index].iter().find(same) {
            let allowed = text!(
                "gripper {:?} has this number on the bus already",
                "夹爪 {:?} 已在此总线上使用该号码",
                other.name
            );
            return Err(check.wrong("slave", table.slave_number(), allowed));
        }
    }
    Ok(())
}
