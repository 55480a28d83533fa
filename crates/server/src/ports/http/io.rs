//! Inputs and outputs as JSON: all of them out, inputs in. Pure.
//!
//! Names are those of the cell file. A request sets all of its inputs or none.

use messages::Localized;
use motion_api::registers::{BOOLEAN_REGISTERS, FLOAT_REGISTERS, INTEGER_REGISTERS};
use motion_api::{IoChange, IoConfig, RegisterImages, RobotState};
use serde_json::{Map, Value, json};
use thiserror::Error;

use controller::cell::point::{IoDirection, IoGroup, IoPointName};
use controller::io_values::{PointChange, PointError, PointValue, RegisterValue};

/// What a request wants to be changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IoChanges {
    /// Digital and analog points, to be applied at the beginning of a cycle.
    pub points: Vec<IoChange>,
    /// Registers of the robot's inputs or outputs, which have their value at once.
    pub registers: Vec<(IoDirection, RegisterValue)>,
}

/// A reason why nothing was set: one sentence that names the point, what was given and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
pub enum InputError {
    /// No JSON.
    #[error("the body is no JSON: {0}")]
    #[zh("正文不是 JSON：{0}")]
    NotJson(String),
    /// JSON, but no object.
    #[error(
        "the body must be an object from names of inputs to values, as {{\"standard_digital_in[0]\": true}}"
    )]
    #[zh("正文必须是从输入名到值的对象，例如 {{\"standard_digital_in[0]\": true}}")]
    NotAnObject,
    /// An input cannot be set so.
    #[error(transparent)]
    Input(#[from] PointError),
}

/// Reads a request to set inputs. `config` tells domains and pins.
///
/// # Errors
/// [`InputError`] names the first thing that is wrong.
pub fn read(body: &[u8], config: &IoConfig) -> Result<IoChanges, InputError> {
    let body: Value =
        serde_json::from_slice(body).map_err(|error| InputError::NotJson(error.to_string()))?;
    let Value::Object(members) = body else {
        return Err(InputError::NotAnObject);
    };
    changes(&members, |name, value| {
        PointChange::of_input(name, value, config)
    })
}

/// The inputs of an order. `config` tells domains and pins.
///
/// # Errors
/// [`InputError`] names the first thing that is wrong.
pub fn inputs(values: &Map<String, Value>, config: &IoConfig) -> Result<IoChanges, InputError> {
    changes(values, |name, value| {
        PointChange::of_input(name, value, config)
    })
}

/// The outputs of an order. `config` tells domains and pins.
///
/// # Errors
/// [`InputError`] names the first thing that is wrong.
pub fn outputs(values: &Map<String, Value>, config: &IoConfig) -> Result<IoChanges, InputError> {
    changes(values, |name, value| {
        PointChange::of_output(name, value, config)
    })
}

/// What the members of an object set. Digital points become one change, so that they change in one cycle.
fn changes(
    members: &Map<String, Value>,
    change_of: impl Fn(&str, &PointValue) -> Result<PointChange, PointError>,
) -> Result<IoChanges, InputError> {
    let mut changes = IoChanges::default();
    let (mut inputs, mut outputs) = ((0, 0), (0, 0));
    let join = |(mask, levels): (u32, u32), (one, level)| (mask | one, levels | level);
    for (name, value) in members {
        let value = match value {
            Value::Bool(level) => PointValue::Level(*level),
            Value::Number(number) => match (number.as_i64(), number.as_f64()) {
                (Some(whole), _) => PointValue::Whole(whole),
                (None, Some(number)) => PointValue::Number(number),
                (None, None) => PointValue::Other(shown(value)),
            },
            _ => PointValue::Other(shown(value)),
        };
        match change_of(name, &value)? {
            PointChange::Io(IoChange::DigitalIn { mask, levels }) => {
                inputs = join(inputs, (mask, levels));
            }
            PointChange::Io(IoChange::DigitalOut { mask, levels }) => {
                outputs = join(outputs, (mask, levels));
            }
            PointChange::Io(change) => changes.points.push(change),
            PointChange::Register(direction, value) => changes.registers.push((direction, value)),
        }
    }
    let (mask, levels) = inputs;
    if mask != 0 {
        changes.points.push(IoChange::DigitalIn { mask, levels });
    }
    let (mask, levels) = outputs;
    if mask != 0 {
        changes.points.push(IoChange::DigitalOut { mask, levels });
    }
    Ok(changes)
}

/// A value for a message, cut where it is long.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text,
    }
}

/// All points with their values, the cycle they are of, and what is kept with them. A float register that is no number
/// is null.
pub fn describe(state: &RobotState, registers: &RegisterImages) -> Value {
    let mut points = Map::new();
    for direction in [IoDirection::In, IoDirection::Out] {
        let (digital, analog, bank) = match direction {
            IoDirection::In => (state.digital_in, &state.analog_in, &registers.input),
            IoDirection::Out => (state.digital_out, &state.analog_out, &registers.output),
        };
        let mut group = |group: IoGroup, count: u8, value: &dyn Fn(u8) -> Value| {
            for index in 0..count {
                let point = IoPointName {
                    group,
                    direction,
                    index,
                };
                points.insert(point.to_string(), value(index));
            }
        };
        for digital_group in [
            IoGroup::StandardDigital,
            IoGroup::ConfigurableDigital,
            IoGroup::ToolDigital,
        ] {
            let first = match digital_group {
                IoGroup::StandardDigital => 0,
                IoGroup::ConfigurableDigital => 16,
                _ => 24,
            };
            group(digital_group, digital_group.points(), &|n| {
                json!(digital >> (first + n) & 1 == 1)
            });
        }
        group(IoGroup::StandardAnalog, 2, &|n| {
            json!(analog[usize::from(n)])
        });
        group(IoGroup::ToolAnalog, 1, &|_| json!(analog[2]));
        group(IoGroup::BooleanRegister, BOOLEAN_REGISTERS, &|n| {
            json!(bank.boolean(n))
        });
        group(IoGroup::IntegerRegister, INTEGER_REGISTERS, &|n| {
            json!(bank.integer(n))
        });
        group(IoGroup::FloatRegister, FLOAT_REGISTERS, &|n| {
            json!(bank.float(n))
        });
    }
    json!({
        "cycle": state.cycle,
        "time": state.time,
        "points": points,
        "tool_digital_io_work_mode": state.io_config.tool_digital_mode,
        "safety_hardness": state.io_config.safety_hardness,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::JointPositions;
    use motion_api::{AnalogDomain, Registers};
    use proptest::prelude::*;

    #[test]
    fn every_kind_of_input_is_read() {
        let mut config = IoConfig::default();
        config.analog_in[1] = AnalogDomain::Current;
        let body = br#"{"standard_digital_in[3]": true, "configurable_digital_in[7]": false, "tool_digital_in[2]": true,
            "standard_analog_in[0]": 10, "standard_analog_in[1]": 0.02, "tool_analog_in": 0,
            "input_boolean_register[127]": true, "input_integer_register[0]": -2147483648,
            "input_float_register[47]": -1e300}"#;
        let changes = read(body, &config).unwrap();
        let analog = |port, value| IoChange::AnalogIn { port, value };
        let (mask, levels) = (1 << 3 | 1 << 23 | 1 << 26, 1 << 3 | 1 << 26);
        let digital = IoChange::DigitalIn { mask, levels };
        for wanted in [analog(0, 10.0), analog(1, 0.02), analog(2, 0.0), digital] {
            assert!(changes.points.contains(&wanted), "{wanted:?}");
        }
        assert_eq!(changes.points.len(), 4);
        let registers = Registers::default();
        changes
            .registers
            .iter()
            .for_each(|(direction, value)| value.write(*direction, &registers));
        let bank = &registers.input;
        assert!(bank.boolean(127));
        assert_eq!((bank.integer(0), bank.float(47)), (i32::MIN, -1e300));
    }

    #[test]
    fn what_does_not_fit_is_said_with_name_value_and_range() {
        for (body, sentence) in [
            (
                "{",
                "the body is no JSON: EOF while parsing an object at line 1 column 1",
            ),
            (
                "[true]",
                "the body must be an object from names of inputs to values, as {\"standard_digital_in[0]\": true}",
            ),
            (
                r#"{"standard_digital_out[0]": true}"#,
                "standard_digital_out[0] is an output; only inputs can be set from outside",
            ),
            (
                r#"{"tool_digital_in[0]": true}"#,
                "tool_digital_in[0] reads nothing: the pin is disabled or an output",
            ),
            (
                r#"{"standard_digital_in[0]": 1}"#,
                "standard_digital_in[0] is 1; it must be true or false",
            ),
            (
                r#"{"standard_digital_in[16]": true}"#,
                "`standard_digital_in[16]` needs a number from 0 to 15, as in standard_digital_in[0]",
            ),
            (
                r#"{"standard_analog_in[0]": 10.5}"#,
                "standard_analog_in[0] is 10.5; it must be a number from 0 to 10 V",
            ),
            (
                r#"{"tool_analog_in": "x"}"#,
                "tool_analog_in is \"x\"; it must be a number from 0 to 10 V",
            ),
            (
                r#"{"input_integer_register[1]": 2147483648}"#,
                "input_integer_register[1] is 2147483648; it must be a whole number from -2147483648 to 2147483647",
            ),
            (
                r#"{"input_integer_register[1]": 0.5}"#,
                "input_integer_register[1] is 0.5; it must be a whole number from -2147483648 to 2147483647",
            ),
            (
                r#"{"input_float_register[1]": null}"#,
                "input_float_register[1] is null; it must be a number",
            ),
        ] {
            let found = read(body.as_bytes(), &IoConfig::default()).unwrap_err();
            assert_eq!(found.to_string(), sentence, "{body}");
        }
        assert_eq!(read(b"{}", &IoConfig::default()), Ok(IoChanges::default()));
    }

    #[test]
    fn outputs_are_set_by_name_and_inputs_are_none() {
        let values = json!({"standard_digital_out[3]": true, "configurable_digital_out[0]": false,
            "standard_analog_out[1]": 5, "output_integer_register[2]": 7});
        let found = outputs(values.as_object().unwrap(), &IoConfig::default()).unwrap();
        let (mask, levels) = (1 << 3 | 1 << 16, 1 << 3);
        let digital = IoChange::DigitalOut { mask, levels };
        let analog = IoChange::AnalogOut {
            port: 1,
            ratio: 0.5,
        };
        assert!(found.points.contains(&digital) && found.points.contains(&analog));
        let register = (IoDirection::Out, RegisterValue::Integer(2, 7));
        assert_eq!(found.registers, [register]);
        let input = json!({"standard_digital_in[3]": true});
        let refused = outputs(input.as_object().unwrap(), &IoConfig::default()).unwrap_err();
        let sentence = "standard_digital_in[3] is an input; only outputs can be set here";
        assert_eq!(refused.to_string(), sentence);
    }

    #[test]
    fn the_page_has_every_point_by_its_name() {
        let mut state = RobotState::at_start(JointPositions::ZERO, 0.004);
        state.digital_out = 1 << 16 | 1 << 27;
        state.analog_in = [1.0, 2.0, 3.0];
        let registers = Registers::default();
        registers.input.set_float(2, f64::NAN);
        registers.output.set_integer(47, -5);
        state.io_config.tool_digital_mode = 3;
        state.io_config.safety_hardness = 1;
        let page = describe(&state, &registers.images());
        assert_eq!(page["tool_digital_io_work_mode"], json!(3));
        assert_eq!(page["safety_hardness"], json!(1));
        let points = page["points"].as_object().unwrap();
        assert_eq!(points.len(), 2 * (16 + 8 + 4 + 2 + 1 + 128 + 48 + 48));
        for name in points.keys() {
            assert_eq!(name.parse::<IoPointName>().unwrap().to_string(), *name);
        }
        let high: Vec<&String> = points
            .iter()
            .filter(|(_, v)| **v == json!(true))
            .map(|(n, _)| n)
            .collect();
        assert_eq!(high, ["configurable_digital_out[0]", "tool_digital_out[3]"]);
        assert_eq!(points["tool_analog_in"], json!(3.0));
        assert_eq!(points["input_float_register[2]"], Value::Null);
        assert_eq!(points["output_integer_register[47]"], json!(-5));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_body_is_read_or_refused(
            body in proptest::collection::vec(any::<u8>(), 0..200),
            text in r#"[{}\[\]":,a-z0-9_ .-]{0,80}"#,
        ) {
            let _ = read(&body, &IoConfig::default());
            let _ = read(text.as_bytes(), &IoConfig::default());
        }
    }
}
