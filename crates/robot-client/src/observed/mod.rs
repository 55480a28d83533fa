//! What a robot somewhere else is doing, put together from what its controller sends over RTSI and port 30001.
//!
//! A variable that the state of our own robot has is taken over into it, a register into the registers, and every other
//! one goes into a message of its own, so that nothing the controller offers is left out. Numbers that it does not send
//! are not numbers here (NaN): a recording of it says what is known and no more.

mod messages;
mod variables;

use kinematics::{JointAccelerations, JointPositions, JointSpeeds, JointTorques, RpyPose};
use motion_api::{
    AnalogDomain, IoConfig, MotionMode, RegisterImages, Registers, RobotMode, RobotState,
    SafetyMode,
};
use wire::primary::state::State;
use wire::rtsi::{RtsiType, RtsiValue};

pub use messages::{outputs_message, outputs_schema, state_message, state_schema};
pub use variables::{IN_A_CYCLE, KNOWN_VARIABLES};
use variables::{VariableTarget, target_of};

/// Takes the values of a recipe where they belong.
#[derive(Debug)]
pub struct RtsiStateMapper {
    targets: Vec<VariableTarget>,
    registers: Registers,
    /// Registers that were handed over last.
    reported_registers: RegisterImages,
}

/// What is new with a packet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PacketExtras {
    /// Time since the controller started, s.
    pub timestamp: Option<f64>,
    /// The registers, if one has another value than before.
    pub registers: Option<RegisterImages>,
}

impl RtsiStateMapper {
    /// A mapper for packets with these variables, in this order.
    pub fn for_recipe(offered: &[(String, RtsiType)]) -> Self {
        Self {
            targets: offered.iter().map(|(name, _)| target_of(name)).collect(),
            registers: Registers::default(),
            reported_registers: RegisterImages::default(),
        }
    }

    /// Takes values over into a state and the registers. One whose type is not that of the protocol is not known.
    pub fn apply_packet(&mut self, state: &mut RobotState, values: &[RtsiValue]) -> PacketExtras {
        let mut timestamp = None;
        for (place, value) in self.targets.iter().zip(values) {
            match (place, *value) {
                (VariableTarget::State(take) | VariableTarget::StateAndMessage(take), value) => {
                    take(state, value)
                }
                (VariableTarget::Timestamp, RtsiValue::F64(time)) => timestamp = Some(time),
                (VariableTarget::Register(register), value) => register.set(&self.registers, value),
                (VariableTarget::Timestamp | VariableTarget::Message, _) => {}
            }
        }
        let images = self.registers.images();
        let registers = (images != self.reported_registers).then_some(images);
        self.reported_registers = images;
        PacketExtras {
            timestamp,
            registers,
        }
    }

    /// Whether the variable at this place of the recipe goes into messages of its own.
    fn has_own_message(&self, index: usize) -> bool {
        matches!(
            self.targets.get(index),
            Some(
                VariableTarget::Message
                    | VariableTarget::StateAndMessage(_)
                    | VariableTarget::Timestamp
            )
        )
    }
}

/// Takes over what states of port 30001 have and RTSI does not.
pub fn apply_primary_state(state: &mut RobotState, told: &State) {
    if let Some(cartesian) = &told.cartesian {
        state.tcp_offset = RpyPose::from_array(cartesian.tcp_offset);
    }
    if let Some(board) = &told.masterboard {
        state.controller_temperature = f64::from(board.temperature);
        state.io_config = IoConfig {
            analog_in: board.analog_in_domains.map(AnalogDomain::from_number),
            analog_out: board.analog_out_domains.map(AnalogDomain::from_number),
            ..state.io_config
        };
    }
    if let Some(additional) = &told.additional {
        state.collision_detection = additional.collision_detection;
        state.io_config.freedrive_by_input = additional.freedrive_by_input;
    }
}

/// A state of which nothing is known.
pub fn unknown_state(step_time: f64) -> RobotState {
    let six = [f64::NAN; 6];
    let pose = RpyPose::from_array(six);
    RobotState {
        target_q: JointPositions(six),
        target_qd: JointSpeeds(six),
        target_qdd: JointAccelerations(six),
        actual_q: JointPositions(six),
        actual_qd: JointSpeeds(six),
        target_torque: JointTorques(six),
        actual_torque: JointTorques(six),
        target_tcp_pose: pose,
        actual_tcp_pose: pose,
        target_tcp_speed: six,
        actual_tcp_speed: six,
        tcp_force: six,
        raw_wrench: six,
        elbow_position: [f64::NAN; 3],
        motion_mode: MotionMode::Unknown,
        target_speed_fraction: f64::NAN,
        speed_scaling: f64::NAN,
        robot_mode: RobotMode::NoController,
        safety_mode: SafetyMode::Undefined,
        analog_in: [f64::NAN; 3],
        analog_out: [f64::NAN; 3],
        external_torque: JointTorques(six),
        joint_temperatures: six,
        controller_temperature: f64::NAN,
        target_waypoint: pose,
        path_pose: pose,
        gravity: [f64::NAN; 3],
        encoder_counts: [f64::NAN; 2],
        collision_detection: false,
        path_offsets: [six; 3],
        ..RobotState::at_start(JointPositions(six), step_time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::primary::state::{AdditionalInfo, Cartesian, Masterboard};

    fn offered(names: &[(&str, RtsiType)]) -> Vec<(String, RtsiType)> {
        let owned = names.iter().map(|(name, kind)| ((*name).to_owned(), *kind));
        owned.collect()
    }

    #[test]
    fn every_variable_goes_to_one_place_and_none_is_left_out() {
        let offered = offered(&[
            ("timestamp", RtsiType::F64),
            ("actual_joint_positions", RtsiType::Vector6),
            ("output_int_register7", RtsiType::I32),
            ("input_bit_registers32_to_63", RtsiType::U32),
            ("output_bit_register64", RtsiType::Bool),
            ("actual_current", RtsiType::Vector6),
            ("joint_mode", RtsiType::Vector6I32),
            ("tool_output_voltage", RtsiType::F64),
            ("a_variable_of_tomorrow", RtsiType::U8),
        ]);
        let values = [
            RtsiValue::F64(12.5),
            RtsiValue::Vector6([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
            RtsiValue::I32(-3),
            RtsiValue::U32(2),
            RtsiValue::Bool(true),
            RtsiValue::Vector6([0.5; 6]),
            RtsiValue::Vector6I32([253; 6]),
            RtsiValue::F64(24.0),
            RtsiValue::U8(9),
        ];
        let mut observer = RtsiStateMapper::for_recipe(&offered);
        let mut state = unknown_state(0.004);
        let beside = observer.apply_packet(&mut state, &values);
        assert_eq!(beside.timestamp, Some(12.5));
        let registers = beside.registers.unwrap();
        assert_eq!(registers.output.integer(7), -3);
        assert!(registers.input.boolean(33) && !registers.input.boolean(32));
        assert!(registers.output.boolean(64));
        assert_eq!(state.actual_q[5], 6.0);
        assert_eq!(state.io_config.tool_voltage, 24);
        let message = outputs_message(&observer, &offered, &values);
        assert_eq!(
            String::from_utf8(message).unwrap(),
            concat!(
                r#"{"timestamp":12.5,"actual_current":[0.5,0.5,0.5,0.5,0.5,0.5],"#,
                r#""joint_mode":[253,253,253,253,253,253],"#,
                r#""tool_output_voltage":24.0,"a_variable_of_tomorrow":9}"#
            )
        );
        // The same again is nothing new.
        assert_eq!(observer.apply_packet(&mut state, &values).registers, None);
        let schema: serde_json::Value =
            serde_json::from_str(&outputs_schema(&observer, &offered)).unwrap();
        let properties = schema["properties"].as_object().unwrap();
        assert_eq!(properties.len(), 5);
        assert_eq!(properties["actual_current"]["type"], "array");
        assert_eq!(properties["timestamp"]["type"], "number");
    }

    #[test]
    fn a_variable_of_another_type_is_not_known() {
        for name in KNOWN_VARIABLES.iter() {
            let offered = [(name.clone(), RtsiType::U16)];
            let mut observer = RtsiStateMapper::for_recipe(&offered);
            let mut state = unknown_state(0.004);
            let beside = observer.apply_packet(&mut state, &[RtsiValue::U16(7)]);
            assert_eq!(beside, PacketExtras::default(), "{name}");
            assert_eq!(
                format!("{state:?}"),
                format!("{:?}", unknown_state(0.004)),
                "{name}"
            );
        }
    }

    #[test]
    fn what_fits_into_a_cycle_is_asked_for_before_everything_else() {
        assert_eq!(KNOWN_VARIABLES[..IN_A_CYCLE.len()], *IN_A_CYCLE);
        let mut names = KNOWN_VARIABLES.clone();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), KNOWN_VARIABLES.len(), "a name stands twice");
        for name in IN_A_CYCLE {
            assert!(
                !matches!(
                    target_of(name),
                    VariableTarget::Message | VariableTarget::Register(_)
                ),
                "{name}"
            );
        }
    }

    #[test]
    fn states_of_30001_add_tool_domains_and_temperature() {
        let told = State {
            cartesian: Some(Cartesian {
                tcp_offset: [0.0, 0.0, 0.12, 0.0, 0.0, 0.5],
                ..Cartesian::default()
            }),
            masterboard: Some(Masterboard {
                analog_in_domains: [0, 1, 0],
                temperature: 41.5,
                ..Masterboard::default()
            }),
            additional: Some(AdditionalInfo {
                collision_detection: true,
                ..AdditionalInfo::default()
            }),
            ..State::default()
        };
        let mut state = unknown_state(0.004);
        apply_primary_state(&mut state, &told);
        assert_eq!(state.tcp_offset.to_array()[2], 0.12);
        assert_eq!(state.controller_temperature, 41.5);
        assert!(state.collision_detection);
        assert_eq!(state.io_config.analog_in[0], AnalogDomain::Current);
        assert_eq!(state.io_config.analog_in[1], AnalogDomain::Voltage);
        // What is not told stays as it was.
        apply_primary_state(&mut state, &State::default());
        assert_eq!(state.controller_temperature, 41.5);
    }

    #[test]
    fn messages_of_states_have_the_parts_that_came_and_fit_their_schema() {
        let told = State {
            masterboard: Some(Masterboard::default()),
            ..State::default()
        };
        let message: serde_json::Value = serde_json::from_slice(&state_message(&told)).unwrap();
        let parts: Vec<&String> = message.as_object().unwrap().keys().collect();
        assert_eq!(parts, ["masterboard"]);
        let schema: serde_json::Value = serde_json::from_str(&state_schema()).unwrap();
        let parts = schema["properties"].as_object().unwrap();
        assert_eq!(parts.len(), 9, "{parts:?}");
        let fields = &parts["masterboard"]["properties"];
        assert_eq!(fields["analog_in"]["items"]["type"], "number");
        assert_eq!(fields["is_reduced"]["type"], "boolean");
        for name in message["masterboard"].as_object().unwrap().keys() {
            assert!(fields.get(name).is_some(), "{name}");
        }
    }
}
