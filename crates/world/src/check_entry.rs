//! One entry of a table while it is checked: ranges of values, and the names and inputs that are taken.

use crate::description::{BodyShape, Trigger};
use crate::error::WorldError;
use kinematics::Pose;
use messages::{Text, text};
use motion_api::PointSet;
use motion_api::io::TOOL_ANALOG;
use motion_api::{DigitalBank, IoPoint};
use std::collections::BTreeMap;
use std::fmt::Display;

/// One entry of one table while it is checked.
pub(crate) struct Entry<'a> {
    pub(crate) table: &'static str,
    pub(crate) name: &'a str,
}

impl Entry<'_> {
    pub(crate) fn refuse(
        &self,
        key: &'static str,
        given: impl Display,
        allowed: Text,
    ) -> WorldError {
        self.refuse_given(key, Text::verbatim(given.to_string()), allowed)
    }

    pub(crate) fn refuse_given(&self, key: &'static str, given: Text, allowed: Text) -> WorldError {
        WorldError::OutOfRange {
            table: self.table,
            name: self.name.to_owned(),
            key,
            given,
            allowed,
        }
    }

    pub(crate) fn positive(&self, key: &'static str, value: f64) -> Result<(), WorldError> {
        self.within(
            key,
            value,
            value > 0.0 && value <= 1e6,
            text!("more than 0, up to 1e6", "大于 0、不超过 1e6"),
        )
    }

    pub(crate) fn not_negative(&self, key: &'static str, value: f64) -> Result<(), WorldError> {
        self.within(
            key,
            value,
            (0.0..=1e6).contains(&value),
            text!("0 to 1e6", "0 到 1e6"),
        )
    }

    pub(crate) fn within(
        &self,
        key: &'static str,
        value: f64,
        holds: bool,
        allowed: Text,
    ) -> Result<(), WorldError> {
        if holds {
            Ok(())
        } else {
            Err(self.refuse(key, value, allowed))
        }
    }

    pub(crate) fn finite(&self, key: &'static str, values: &[f64]) -> Result<(), WorldError> {
        match values.iter().all(|x| x.abs() <= 1e3) {
            true => Ok(()),
            false => Err(self.refuse(
                key,
                format!("{values:?}"),
                text!("numbers between -1000 and 1000", "-1000 到 1000 之间的数"),
            )),
        }
    }

    pub(crate) fn pose(&self, key: &'static str, pose: &Pose) -> Result<(), WorldError> {
        self.finite(key, &pose.to_rpy().to_array())
    }

    pub(crate) fn edges(&self, key: &'static str, size: &[f64; 3]) -> Result<(), WorldError> {
        match size.iter().all(|x| *x > 1e-4 && *x <= 1e3) {
            true => Ok(()),
            false => Err(self.refuse(
                key,
                format!("{size:?}"),
                text!(
                    "lengths of more than 0.0001 m, up to 1000 m",
                    "大于 0.0001 m、不超过 1000 m 的长度"
                ),
            )),
        }
    }

    pub(crate) fn direction(&self, key: &'static str, axis: &[f64; 3]) -> Result<(), WorldError> {
        self.finite(key, axis)?;
        match axis.iter().any(|x| x.abs() > 1e-9) {
            true => Ok(()),
            false => Err(self.refuse(
                key,
                format!("{axis:?}"),
                text!("a direction, not zero", "不为零的方向"),
            )),
        }
    }

    /// `key` is what the lengths of the shape are called.
    pub(crate) fn shape(
        &self,
        key: &'static str,
        shape: &BodyShape,
        may_be_plane: bool,
    ) -> Result<(), WorldError> {
        match shape {
            BodyShape::Box { size } => self.edges(key, size),
            BodyShape::Cylinder { radius, length } => self.edges(key, &[*radius, *length, 1.0]),
            BodyShape::Sphere { radius } => self.edges(key, &[*radius, 1.0, 1.0]),
            // Its size was looked at when it became a solid.
            BodyShape::Mesh(_) => Ok(()),
            BodyShape::Plane if may_be_plane => Ok(()),
            BodyShape::Plane => Err(self.refuse(
                "shape",
                "plane",
                text!(
                    "box, cylinder, sphere or mesh",
                    "box、cylinder、sphere 或 mesh"
                ),
            )),
        }
    }

    pub(crate) fn digital(
        &self,
        key: &'static str,
        point: Option<IoPoint>,
    ) -> Result<(), WorldError> {
        match point {
            None | Some(IoPoint::Digital(0..28) | IoPoint::BooleanRegister(0..128)) => Ok(()),
            Some(other) => Err(self.refuse(
                key,
                format!("{other:?}"),
                text!(
                    "a digital point or a boolean register",
                    "数字点或布尔寄存器"
                ),
            )),
        }
    }

    pub(crate) fn analog(
        &self,
        key: &'static str,
        point: Option<IoPoint>,
    ) -> Result<(), WorldError> {
        match point {
            None | Some(IoPoint::Analog(0..3)) => Ok(()),
            Some(other) => Err(self.refuse(
                key,
                format!("{other:?}"),
                text!("an analog point", "模拟点"),
            )),
        }
    }

    pub(crate) fn trigger(
        &self,
        key: &'static str,
        trigger: &Trigger,
        shortest: f64,
    ) -> Result<(), WorldError> {
        match trigger {
            Trigger::Time(at) => self.within(
                key,
                *at,
                *at >= shortest && *at <= 1e6,
                text!(
                    "a time, not negative, periods not 0",
                    "不小于 0 的时间，周期不为 0"
                ),
            ),
            Trigger::Output(point) | Trigger::Input(point) => self.digital("when", Some(*point)),
        }
    }
}

/// Names and driven inputs so far.
#[derive(Default)]
pub(crate) struct Register<'a> {
    pub(crate) names: BTreeMap<&'a str, &'static str>,
    pub(crate) driven: PointSet,
    pub(crate) drivers: Vec<(IoPoint, String)>,
}

impl<'a> Register<'a> {
    pub(crate) fn name(
        &mut self,
        table: &'static str,
        name: &'a str,
    ) -> Result<Entry<'a>, WorldError> {
        let entry = Entry { table, name };
        if name.is_empty() || name.contains(['#', '[', ']']) {
            return Err(entry.refuse(
                "name",
                format!("{name:?}"),
                text!(
                    "a name without '#', '[' and ']', not empty",
                    "不含 '#'、'[' 和 ']' 的非空名称"
                ),
            ));
        }
        match self.names.insert(name, table) {
            Some(other) => Err(WorldError::DuplicateName {
                table,
                name: name.to_owned(),
                other,
            }),
            None => Ok(entry),
        }
    }

    pub(crate) fn is(&self, name: &str, tables: &[&str]) -> bool {
        self.names
            .get(name)
            .is_some_and(|table| tables.contains(table))
    }

    pub(crate) fn drive(
        &mut self,
        entry: &Entry<'_>,
        key: &'static str,
        point: Option<IoPoint>,
    ) -> Result<(), WorldError> {
        let Some(point) = point else { return Ok(()) };
        if self.driven.insert(point) {
            self.drivers.push((point, entry.name.to_owned()));
            return Ok(());
        }
        let other = self.drivers.iter().find(|(p, _)| *p == point);
        Err(WorldError::DrivenTwice {
            table: entry.table,
            name: entry.name.to_owned(),
            key,
            given: input_name(point),
            other: other.map(|(_, name)| name.clone()).unwrap_or_default(),
        })
    }

    pub(crate) fn known(
        &self,
        entry: &Entry<'_>,
        key: &'static str,
        given: &str,
        tables: &[&str],
        allowed: Text,
    ) -> Result<(), WorldError> {
        match self.is(given, tables) {
            true => Ok(()),
            false => Err(WorldError::UnknownName {
                table: entry.table,
                name: entry.name.to_owned(),
                key,
                given: given.to_owned(),
                allowed,
            }),
        }
    }
}

/// The name of an input in the cell file.
fn input_name(point: IoPoint) -> String {
    let [standard, configurable, tool] = [
        DigitalBank::Standard,
        DigitalBank::Configurable,
        DigitalBank::Tool,
    ]
    .map(|bank| bank.bit(0));
    match point {
        IoPoint::Digital(bit) if bit >= tool => format!("tool_digital_in[{}]", bit - tool),
        IoPoint::Digital(bit) if bit >= configurable => {
            format!("configurable_digital_in[{}]", bit - configurable)
        }
        IoPoint::Digital(bit) => format!("standard_digital_in[{}]", bit - standard),
        IoPoint::Analog(TOOL_ANALOG) => "tool_analog_in".to_owned(),
        IoPoint::Analog(port) => format!("standard_analog_in[{port}]"),
        IoPoint::BooleanRegister(index) => format!("input_boolean_register[{index}]"),
        IoPoint::IntegerRegister(index) => format!("input_integer_register[{index}]"),
        IoPoint::FloatRegister(index) => format!("input_float_register[{index}]"),
    }
}
