//! The levels of all points with their configuration, and what a change does to them.

use super::change::IoChange;
use super::config::*;
use super::points::*;

/// Levels, values and configuration of all points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IoImage {
    /// Digital inputs by bit.
    pub digital_in: u32,
    /// Digital outputs by bit.
    pub digital_out: u32,
    /// Analog inputs, A or V by domain.
    pub analog_in: [f64; ANALOG_POINTS],
    /// Analog outputs, 0 to 1 of their range.
    pub analog_out_ratio: [f64; ANALOG_POINTS],
    /// How the points are configured.
    pub config: IoConfig,
}

impl IoImage {
    /// Applies what concerns levels, values and configuration; run-state choices and input actions are the cycle's.
    pub fn apply(&mut self, change: &IoChange) {
        match *change {
            IoChange::DigitalOut { mask, levels } => {
                let mask = mask & self.config.drivable();
                self.digital_out = self.digital_out & !mask | levels & mask;
            }
            IoChange::DigitalIn { mask, levels } => {
                let mask = mask & self.config.readable();
                self.digital_in = self.digital_in & !mask | levels & mask;
            }
            IoChange::AnalogOut { port, ratio } => {
                if let Some(out) = self.analog_out_ratio.get_mut(usize::from(port)) {
                    *out = not_nan(ratio).clamp(0.0, 1.0);
                }
            }
            IoChange::AnalogIn { port, value } => {
                let port = usize::from(port);
                if let (Some(input), Some(domain)) = (
                    self.analog_in.get_mut(port),
                    self.config.analog_in.get(port),
                ) {
                    *input = not_nan(value).clamp(0.0, domain.measurable_max());
                }
            }
            IoChange::AnalogOutDomain { port, domain } => {
                if let Some(of_port) = self.config.analog_out.get_mut(usize::from(port)) {
                    *of_port = domain;
                }
            }
            IoChange::AnalogInDomain { port, domain } => {
                let port = usize::from(port);
                if let (Some(of_port), Some(input)) = (
                    self.config.analog_in.get_mut(port),
                    self.analog_in.get_mut(port),
                ) {
                    *of_port = domain;
                    *input = input.min(domain.measurable_max());
                }
            }
            IoChange::ToolAnalogMode(mode) => self.config.tool_analog_mode = mode & 3,
            IoChange::ToolDigitalMode(mode) => self.config.tool_digital_mode = mode & 3,
            IoChange::SafetyHardness(kind) => self.config.safety_hardness = kind & 1,
            IoChange::ToolPin { index, pin } => {
                if let Some(of_index) = self.config.tool_pins.get_mut(usize::from(index)) {
                    *of_index = pin;
                    self.digital_out &= self.config.drivable();
                    self.digital_in &= self.config.readable();
                }
            }
            IoChange::ToolVoltage(volts) => self.config.tool_voltage = volts,
            IoChange::DigitalOutRunState { .. }
            | IoChange::AnalogOutRunState { .. }
            | IoChange::BooleanRegisterRunState { .. }
            | IoChange::DigitalInAction { .. }
            | IoChange::BooleanRegisterAction { .. }
            | IoChange::InputActionsToDefault
            | IoChange::ProgramRunning(_)
            | IoChange::BooleanRegister { .. }
            | IoChange::FloatRegister { .. }
            | IoChange::IntegerRegister { .. } => {}
        }
    }

    /// The analog outputs, A or V by domain.
    pub fn analog_out(&self) -> [f64; ANALOG_POINTS] {
        std::array::from_fn(|k| self.config.analog_out[k].value(self.analog_out_ratio[k]))
    }

    /// Level of a pin of the tool: the output's or the input's, whichever it is; low beyond the last pin.
    pub fn tool_digital(&self, index: u8) -> bool {
        let Some(pin) = self.config.tool_pins.get(usize::from(index)) else {
            return false;
        };
        let word = if pin.is_output {
            self.digital_out
        } else {
            self.digital_in
        };
        word >> DigitalBank::Tool.bit(index) & 1 == 1
    }
}

/// 0 for a number that is none.
const fn not_nan(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn changes() -> impl Strategy<Value = IoChange> {
        let names = [
            "digital_out",
            "digital_in",
            "analog_out",
            "analog_in",
            "analog_out_domain",
            "analog_in_domain",
            "tool_analog_mode",
            "tool_pin",
            "tool_voltage",
            "digital_out_run_state",
            "analog_out_run_state",
            "boolean_register_run_state",
            "digital_in_action",
            "boolean_register_action",
            "input_actions_to_default",
            "program_running",
            "safety_hardness",
            "tool_digital_mode",
            "boolean_register",
            "float_register",
            "integer_register",
        ];
        (0..names.len(), 0..3_u8, any::<u32>(), 0..4_u8, 0..2_u8).prop_map(
            move |(n, a, b, c, d)| {
                let name = names[n];
                let (a, b) = match name {
                    "digital_out" | "digital_in" => (b, b.rotate_left(7)),
                    "tool_pin" => (a.into(), b & 1),
                    _ => (u32::from(a), b & 1),
                };
                IoChange::from_parts(name, [a.into(), b.into(), c.into(), d.into()]).unwrap()
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn a_change_comes_back_from_its_parts(change in changes()) {
            let (name, numbers) = change.to_parts();
            prop_assert_eq!(IoChange::from_parts(name, numbers), Some(change));
        }

        #[test]
        fn no_sequence_of_changes_leaves_the_ranges(list in proptest::collection::vec(changes(), 0..40)) {
            let mut image = IoImage::default();
            for change in &list {
                image.apply(change);
                prop_assert_eq!(image.digital_out & !image.config.drivable(), 0);
                prop_assert_eq!(image.digital_in & !image.config.readable(), 0);
                for k in 0..ANALOG_POINTS {
                    prop_assert!((0.0..=1.0).contains(&image.analog_out_ratio[k]));
                    prop_assert!((0.0..=image.config.analog_in[k].measurable_max()).contains(&image.analog_in[k]));
                }
                prop_assert_eq!(IoConfig::from_bits(image.config.to_bits()), image.config);
            }
        }
    }

    #[test]
    fn analog_outputs_are_a_part_of_their_domain() {
        let mut image = IoImage::default();
        image.apply(&IoChange::AnalogOut {
            port: 0,
            ratio: 0.5,
        });
        assert_eq!(image.analog_out()[0], 5.0);
        let domain = AnalogDomain::Current;
        image.apply(&IoChange::AnalogOutDomain { port: 0, domain });
        assert!((image.analog_out()[0] - 0.012).abs() < 1e-15);
        for wrong in [f64::NAN, -1.0, f64::NEG_INFINITY] {
            image.apply(&IoChange::AnalogOut {
                port: 0,
                ratio: wrong,
            });
            assert_eq!(image.analog_out()[0], 0.004);
        }
        image.apply(&IoChange::AnalogOut {
            port: 0,
            ratio: 7.0,
        });
        assert_eq!(image.analog_out()[0], 0.020);
    }

    #[test]
    fn a_tool_pin_is_either_input_or_output() {
        let mut image = IoImage::default();
        let high = |index| IoChange::digital_out(DigitalBank::Tool, index, true);
        image.apply(&high(1));
        image.apply(&high(2));
        assert!(image.tool_digital(1) && !image.tool_digital(2));
        image.apply(&IoChange::digital_in(DigitalBank::Tool, 2, true));
        assert!(image.tool_digital(2));
        let pin = ToolPin {
            is_output: false,
            ..image.config.tool_pins[1]
        };
        image.apply(&IoChange::ToolPin { index: 1, pin });
        assert!(!image.tool_digital(1) && image.digital_out == 0);
    }
}
