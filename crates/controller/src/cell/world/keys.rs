//! Keys that one kind of an entry needs and another does not have, and the points that they name.

use messages::text;
use motion_api::IoPoint;
use world::description::Trigger;

use crate::cell::check::{InvalidValue, TableCheck};
use crate::cell::point::{IoDirection, IoPointName};

/// A point that has to be there.
pub(super) fn needed(
    check: &TableCheck,
    key: &'static str,
    point: Option<IoPointName>,
    direction: IoDirection,
) -> Result<IoPoint, InvalidValue> {
    let point = point
        .ok_or_else(|| check.missing(key, text!("this kind needs one", "这一类需要给出它")))?;
    optional(check, key, Some(point), direction).map(|_| point.io_point())
}

/// A point that may be there.
pub(super) fn optional(
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
pub(super) fn refuse_keys(
    check: &TableCheck,
    kind: &str,
    keys: &[(&'static str, bool)],
) -> Result<(), InvalidValue> {
    match keys.iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => Err(check.needless(
            key,
            text!(
                "kind = \"{kind}\" has no such key",
                "kind = \"{kind}\" 没有此键"
            ),
        )),
        None => Ok(()),
    }
}

/// The point of a rising edge.
pub(super) fn edge(
    check: &TableCheck,
    key: &'static str,
    point: IoPointName,
) -> Result<Trigger, InvalidValue> {
    match (point.io_point(), point.direction) {
        (IoPoint::IntegerRegister(_) | IoPoint::FloatRegister(_), _) => Err(check.wrong(
            key,
            point,
            text!("a point with levels is needed", "需要一个数字点"),
        )),
        (at, IoDirection::Out) => Ok(Trigger::Output(at)),
        (at, IoDirection::In) => Ok(Trigger::Input(at)),
    }
}
