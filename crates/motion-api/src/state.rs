//! The state of the robot at the end of one cycle: what getters read, ports send and the recording keeps.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds, JointTorques, Payload, RpyPose};

use crate::words::{FixedWords, WordSink, WordSource};
use crate::{CommandId, IoConfig, IoImage, MotionMode, RobotMode, SafetyMode};

macro_rules! state {
    ($(#[$doc:meta])* pub struct $name:ident { $($(#[$fdoc:meta])* pub $field:ident: $type:ty,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name { $($(#[$fdoc])* pub $field: $type,)+ }

        impl FixedWords for $name {
            const COUNT: usize = 0 $(+ <$type as FixedWords>::COUNT)+;
            #[inline]
            fn put(&self, sink: &mut impl WordSink) {
                $(self.$field.put(sink);)+
            }
            fn take(source: &mut impl WordSource) -> Self {
                $(let $field = <$type as FixedWords>::take(source);)+
                Self { $($field),+ }
            }
        }
    };
}

state! {
    /// Everything that is known about the robot after one cycle. Poses are of the TCP in the base frame.
    pub struct RobotState {
        /// Cycle counter from 1; 0 before the first cycle.
        pub cycle: u64,
        /// Simulated time since start, s.
        pub time: f64,
        /// Length of one cycle, s.
        pub step_time: f64,
        /// Commanded joint positions.
        pub target_q: JointPositions,
        /// Commanded joint speeds.
        pub target_qd: JointSpeeds,
        /// Commanded joint accelerations.
        pub target_qdd: JointAccelerations,
        /// Joint positions of the arm.
        pub actual_q: JointPositions,
        /// Joint speeds of the arm.
        pub actual_qd: JointSpeeds,
        /// The model's torque for the commanded motion, gravity and payload included.
        pub target_torque: JointTorques,
        /// What the joints of the plant carry.
        pub actual_torque: JointTorques,
        /// Commanded TCP pose.
        pub target_tcp_pose: RpyPose,
        /// TCP pose of the arm.
        pub actual_tcp_pose: RpyPose,
        /// Commanded TCP velocity, linear m/s then angular rad/s, base frame.
        pub target_tcp_speed: [f64; 6],
        /// TCP velocity of the arm, linear m/s then angular rad/s, base frame.
        pub actual_tcp_speed: [f64; 6],
        /// Wrench of the environment on the tool: N, Nm, TCP frame, moments about the TCP.
        pub tcp_force: [f64; 6],
        /// What the force sensor reads, weight and inertia of the payload included: frame as `tcp_force`.
        pub raw_wrench: [f64; 6],
        /// Position of the elbow (origin of joint 3) in the base frame, m.
        pub elbow_position: [f64; 3],
        /// Active TCP relative to the flange.
        pub tcp_offset: RpyPose,
        /// Active payload.
        pub payload: Payload,
        /// The generator that makes the setpoints.
        pub motion_mode: MotionMode,
        /// The motion command that is running.
        pub command_id: CommandId,
        /// Speed slider, 0 to 1.
        pub target_speed_fraction: f64,
        /// Speed scaling in effect, 0 to 1.
        pub speed_scaling: f64,
        /// State of the machine.
        pub robot_mode: RobotMode,
        /// State of the safety system.
        pub safety_mode: SafetyMode,
        /// Number of the reason of the protective stop, 0 when there is none.
        pub stop_code: u64,
        /// Digital inputs: bits 0-15 standard, 16-23 configurable, 24-27 tool.
        pub digital_in: u64,
        /// Digital outputs, bits as the inputs.
        pub digital_out: u64,
        /// Analog inputs: standard 0, standard 1, tool; A or V by domain.
        pub analog_in: [f64; 3],
        /// Analog outputs: standard 0, standard 1, tool; A or V by domain.
        pub analog_out: [f64; 3],
        /// How inputs and outputs are configured.
        pub io_config: IoConfig,
        /// Records that the recording could not take so far.
        pub records_lost: u64,
        /// Time the cycle before this one took, µs; 0 under the virtual clock.
        pub step_duration_us: f64,
        /// How late the motion thread woke up, µs; 0 under the virtual clock.
        pub wakeup_latency_us: f64,
        /// What the joints carry beyond their own motion, as the collision observer sees it.
        pub external_torque: JointTorques,
        /// Temperatures of the joints, °C.
        pub joint_temperatures: [f64; 6],
        /// Temperature of the mainboard of the control box, °C.
        pub controller_temperature: f64,
        /// Where the motion under way leads: TCP pose; the commanded pose when there is none.
        pub target_waypoint: RpyPose,
        /// Free-fall acceleration in the base frame, m/s².
        pub gravity: [f64; 3],
        /// Counts of the two conveyor encoders, ticks.
        pub encoder_counts: [f64; 2],
        /// Ranges of the two encoders as numbers of [`EncoderRange`](crate::EncoderRange).
        pub encoder_ranges: [u64; 2],
        /// Collision detection is on.
        pub collision_detection: bool,
        /// Sensitivity of collision detection, 10 to 100 %.
        pub collision_sensitivity: u64,
        /// Force mode is on, whatever motion runs under it.
        pub force_mode: bool,
        /// TCP pose that the planned motion asks for, without offsets, belts and forces.
        pub path_pose: RpyPose,
        /// Offset of the path that is in force: translation and roll, pitch, yaw, in base, TCP and motion axes.
        pub path_offsets: [[f64; 6]; 3],
    }
}

state! {
    /// When a state was made: the first fields of [`RobotState`], in its order.
    pub struct CycleTime {
        /// Cycle counter from 1; 0 before the first cycle.
        pub cycle: u64,
        /// Simulated time since start, s.
        pub time: f64,
        /// Length of one cycle, s.
        pub step_time: f64,
    }
}

impl CycleTime {
    /// When a state was made.
    pub const fn of(state: &RobotState) -> Self {
        Self {
            cycle: state.cycle,
            time: state.time,
            step_time: state.step_time,
        }
    }
}

impl RobotState {
    /// The state before the first cycle: standing at `q`, nothing measured yet.
    pub fn at_start(q: JointPositions, step_time: f64) -> Self {
        Self {
            cycle: 0,
            time: 0.0,
            step_time,
            target_q: q,
            target_qd: JointSpeeds::ZERO,
            target_qdd: JointAccelerations::ZERO,
            actual_q: q,
            actual_qd: JointSpeeds::ZERO,
            target_torque: JointTorques::ZERO,
            actual_torque: JointTorques::ZERO,
            target_tcp_pose: RpyPose::default(),
            actual_tcp_pose: RpyPose::default(),
            target_tcp_speed: [0.0; 6],
            actual_tcp_speed: [0.0; 6],
            tcp_force: [0.0; 6],
            raw_wrench: [0.0; 6],
            elbow_position: [0.0; 3],
            tcp_offset: RpyPose::default(),
            payload: Payload::default(),
            motion_mode: MotionMode::Idle,
            command_id: CommandId::NONE,
            target_speed_fraction: 1.0,
            speed_scaling: 1.0,
            robot_mode: RobotMode::Running,
            safety_mode: SafetyMode::Normal,
            stop_code: 0,
            digital_in: 0,
            digital_out: 0,
            analog_in: [0.0; 3],
            analog_out: [0.0; 3],
            io_config: IoConfig::default(),
            records_lost: 0,
            step_duration_us: 0.0,
            wakeup_latency_us: 0.0,
            external_torque: JointTorques::ZERO,
            joint_temperatures: [32.0; 6],
            controller_temperature: 35.0,
            target_waypoint: RpyPose::default(),
            gravity: [0.0, 0.0, -9.81],
            encoder_counts: [0.0; 2],
            encoder_ranges: [0; 2],
            collision_detection: true,
            collision_sensitivity: 50,
            force_mode: false,
            path_pose: RpyPose::default(),
            path_offsets: [[0.0; 6]; 3],
        }
    }

    /// Inputs and outputs as one image.
    pub fn io(&self) -> IoImage {
        IoImage {
            digital_in: self.digital_in as u32,
            digital_out: self.digital_out as u32,
            analog_in: self.analog_in,
            analog_out_ratio: std::array::from_fn(|k| {
                self.io_config.analog_out[k].ratio(self.analog_out[k])
            }),
            config: self.io_config,
        }
    }
}
