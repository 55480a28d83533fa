//! Inputs, outputs and registers by the names of the cell file.
//!
//! Owns reading and setting one of them between two cycles, and the sentence where a value does not fit.

use controller::cell::point::{Direction, Group, Point};
use elite_runtime::Robot;
use motion_api::io::TOOL_ANALOG;
use motion_api::{CommandKind, DigitalBank, IoChange, Origin, RegisterBank};

/// A value of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Level {
    /// Of a digital one.
    Digital(bool),
    /// Of an analog one, or a float register.
    Number(f64),
    /// Of an integer register.
    Whole(i32),
}

fn bank(group: Group) -> Option<DigitalBank> {
    match group {
        Group::StandardDigital => Some(DigitalBank::Standard),
        Group::ConfigurableDigital => Some(DigitalBank::Configurable),
        Group::ToolDigital => Some(DigitalBank::Tool),
        _ => None,
    }
}

fn registers(robot: &Robot, direction: Direction) -> &RegisterBank {
    match direction {
        Direction::In => &robot.registers().input,
        Direction::Out => &robot.registers().output,
    }
}

/// The value as the next read of a program would see it.
pub(crate) fn get(robot: &Robot, point: Point) -> Level {
    let (image, index) = (robot.io(), point.index);
    let registers = registers(robot, point.direction);
    if let Some(bank) = bank(point.group) {
        let levels = match point.direction {
            Direction::In => image.digital_in,
            Direction::Out => image.digital_out,
        };
        return Level::Digital(levels >> bank.bit(index) & 1 == 1);
    }
    match point.group {
        Group::BooleanRegister => Level::Digital(registers.boolean(index)),
        Group::IntegerRegister => Level::Whole(registers.integer(index)),
        Group::FloatRegister => Level::Number(registers.float(index)),
        _ => {
            let port = port(point);
            Level::Number(match point.direction {
                Direction::In => image.analog_in[port],
                Direction::Out => image.config.analog_out[port].value(image.analog_out_ratio[port]),
            })
        }
    }
}

fn port(point: Point) -> usize {
    usize::from(match point.group {
        Group::ToolAnalog => TOOL_ANALOG,
        _ => point.index,
    })
}

/// Sets a value: of an input from outside, of an output as a client of a port would.
pub(crate) fn set(robot: &Robot, point: Point, level: Level) -> Result<(), String> {
    let image = robot.io();
    let change = match (point.group, level) {
        (Group::BooleanRegister, Level::Digital(level)) => {
            registers(robot, point.direction).set_boolean(point.index, level);
            return Ok(());
        }
        (Group::IntegerRegister, Level::Whole(value)) => {
            registers(robot, point.direction).set_integer(point.index, value);
            return Ok(());
        }
        (Group::FloatRegister, Level::Number(value)) => {
            registers(robot, point.direction).set_float(point.index, value);
            return Ok(());
        }
        (group, Level::Digital(level)) => {
            let Some(bank) = bank(group) else {
                return Err(misfit(point));
            };
            let (usable, what, change) = match point.direction {
                Direction::In => (
                    image.config.readable(),
                    "reads",
                    IoChange::digital_in(bank, point.index, level),
                ),
                Direction::Out => (
                    image.config.drivable(),
                    "drives",
                    IoChange::digital_out(bank, point.index, level),
                ),
            };
            if usable >> bank.bit(point.index) & 1 == 0 {
                let other = match point.direction {
                    Direction::In => "an output",
                    Direction::Out => "an input",
                };
                return Err(format!(
                    "{point} {what} nothing: the pin is disabled or {other}"
                ));
            }
            change
        }
        (Group::StandardAnalog | Group::ToolAnalog, Level::Number(value)) => {
            let port = port(point);
            let domain = match point.direction {
                Direction::In => image.config.analog_in[port],
                Direction::Out => image.config.analog_out[port],
            };
            let most = domain.measurable_max();
            if !(0.0..=most).contains(&value) {
                return Err(format!(
                    "{point} is {value}; it must be a number from 0 to {most}"
                ));
            }
            let number = u8::try_from(port).unwrap_or(0);
            match point.direction {
                Direction::In => IoChange::AnalogIn {
                    port: number,
                    value,
                },
                Direction::Out => IoChange::AnalogOut {
                    port: number,
                    ratio: domain.ratio(value),
                },
            }
        }
        _ => return Err(misfit(point)),
    };
    let sent = robot.send(Origin::default(), CommandKind::SetIo(change));
    sent.map(drop).map_err(|full| full.to_string())
}

fn misfit(point: Point) -> String {
    let needed = match point.group {
        Group::IntegerRegister => "a whole number of 32 bits",
        group if group.is_digital() => "True or False",
        _ => "a number",
    };
    format!("{point} takes {needed}")
}
