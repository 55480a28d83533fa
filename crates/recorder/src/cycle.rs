//! `elite.CycleMessage`: the protobuf message of one control cycle, its schema, and its way from and to a `RobotState`.
//!
//! One table makes the Rust struct and the schema that goes into the file, so the two cannot drift apart. Field numbers
//! are the file format: a number is never given a new meaning. Fields from 32 on are not part of the published topic
//! description; they make a recording complete, so that a state read back is the state that was recorded.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds, JointTorques, Payload, RpyPose};
use messages::Localized;
use motion_api::{CommandId, IoConfig, MotionMode, RobotMode, RobotState, SafetyMode};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::source_code_info::Location;
use prost_types::{
    DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet, SourceCodeInfo,
};
use thiserror::Error;

macro_rules! message {
    ($(#[$doc:meta])* pub struct $name:ident { $(
        #[doc = $text:literal] $field:ident: $type:ty [$proto:ident $($repeated:ident)?, $tag:literal],
    )+ }) => {
        $(#[$doc])*
        #[derive(Clone, PartialEq, prost::Message)]
        pub struct $name { $(
            #[doc = $text]
            #[prost($proto $(, $repeated)?, tag = $tag)]
            pub $field: $type,
        )+ }

        impl $name {
            /// Every field with its name, in the order of the struct.
            pub fn fields(&self) -> [(&'static str, FieldValue<'_>); FIELDS.len()] {
                [$((stringify!($field), FieldValue::from(&self.$field))),+]
            }
        }

        /// Name, number, type and comment of every field, in the order of the struct.
        const FIELDS: &[Field] = &[$(Field {
            name: stringify!($field),
            number: $tag,
            kind: stringify!($proto),
            repeated: false $(|| stringify!($repeated).len() > 0)?,
            comment: $text,
        }),+];
    };
}

struct Field {
    name: &'static str,
    number: &'static str,
    kind: &'static str,
    repeated: bool,
    comment: &'static str,
}

/// Value of a field of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldValue<'a> {
    /// A counter, a number of a mode, a mask.
    Unsigned(u64),
    /// A number.
    Number(f64),
    /// A vector.
    Numbers(&'a [f64]),
    /// A name.
    Text(&'a str),
}

macro_rules! field_value_from {
    ($($type:ty: $field:ident => $value:expr;)+) => {$(
        impl<'a> From<&'a $type> for FieldValue<'a> {
            fn from($field: &'a $type) -> Self {
                $value
            }
        }
    )+};
}
field_value_from! {
    u64: x => Self::Unsigned(*x);
    u32: x => Self::Unsigned(u64::from(*x));
    f64: x => Self::Number(*x);
    Vec<f64>: x => Self::Numbers(x);
    String: x => Self::Text(x);
}

message! {
    /// The robot at the end of one cycle. Vectors of joints have six elements, base first; poses are
    /// `[x, y, z, Rx, Ry, Rz]` of the TCP in the base frame (m, rad); speeds are linear before angular.
    pub struct CycleMessage {
        /// Cycle counter, from 1.
        cycle: u64 [uint64, "1"],
        /// Simulated time since start, s.
        time: f64 [double, "2"],
        /// Commanded joint positions, rad.
        target_q: Vec<f64> [double repeated, "3"],
        /// Commanded joint speeds, rad/s.
        target_qd: Vec<f64> [double repeated, "4"],
        /// Commanded joint accelerations, rad/s².
        target_qdd: Vec<f64> [double repeated, "5"],
        /// Joint positions of the arm, rad.
        actual_q: Vec<f64> [double repeated, "6"],
        /// Joint speeds of the arm, rad/s.
        actual_qd: Vec<f64> [double repeated, "7"],
        /// The model's torques for the commanded motion, gravity and payload included, Nm.
        target_torque: Vec<f64> [double repeated, "8"],
        /// What the joints of the plant carry, Nm.
        actual_torque: Vec<f64> [double repeated, "9"],
        /// Commanded TCP pose.
        target_tcp_pose: Vec<f64> [double repeated, "10"],
        /// TCP pose of the arm.
        actual_tcp_pose: Vec<f64> [double repeated, "11"],
        /// Commanded TCP velocity in the base frame, m/s and rad/s.
        target_tcp_speed: Vec<f64> [double repeated, "12"],
        /// TCP velocity of the arm in the base frame, m/s and rad/s.
        actual_tcp_speed: Vec<f64> [double repeated, "13"],
        /// Wrench of the environment on the tool in the TCP frame, moments about the TCP, N and Nm.
        tcp_force: Vec<f64> [double repeated, "14"],
        /// Name of the motion generator.
        mode: String [string, "15"],
        /// The motion command that is running, 0 when there is none.
        command_id: u64 [uint64, "16"],
        /// Speed scaling in effect, 0 to 1.
        speed_scaling: f64 [double, "17"],
        /// Safety mode, the vendor's number (1 normal, 2 reduced, 3 protective stop, ...).
        safety_mode: u32 [uint32, "18"],
        /// Robot mode, the vendor's number (3 power off, 5 idle, 7 running, ...).
        robot_mode: u32 [uint32, "19"],
        /// Digital inputs: bits 0-15 standard, 16-23 configurable, 24-27 tool.
        digital_in: u64 [uint64, "20"],
        /// Digital outputs, bits as the inputs.
        digital_out: u64 [uint64, "21"],
        /// Analog inputs: standard 0, standard 1, tool; A or V by domain.
        analog_in: Vec<f64> [double repeated, "22"],
        /// Analog outputs: standard 0, standard 1, tool; A or V by domain.
        analog_out: Vec<f64> [double repeated, "23"],
        /// Time the cycle took, µs; 0 under the virtual clock.
        step_duration_us: f64 [double, "24"],
        /// How late the motion thread woke up, µs; 0 under the virtual clock.
        wakeup_latency_us: f64 [double, "25"],
        /// Length of one cycle, s.
        step_time: f64 [double, "32"],
        /// Position of the elbow (origin of joint 3) in the base frame, m.
        elbow_position: Vec<f64> [double repeated, "33"],
        /// Active TCP relative to the flange.
        tcp_offset: Vec<f64> [double repeated, "34"],
        /// Active payload: mass kg, centre of gravity x y z m, inertia xx yy zz xy xz yz kg m².
        payload: Vec<f64> [double repeated, "35"],
        /// Speed slider, 0 to 1.
        target_speed_fraction: f64 [double, "36"],
        /// Number of the reason of the protective stop, 0 when there is none.
        stop_code: u64 [uint64, "37"],
        /// Cycles that the recording could not take so far.
        records_lost: u64 [uint64, "38"],
        /// How I/O is configured: bits 0-5 domains, 8-23 tool pins, 24-25 tool analog pins, from 32 tool voltage.
        io_config: u64 [uint64, "39"],
        /// What the joints carry beyond their own motion, Nm.
        external_torque: Vec<f64> [double repeated, "40"],
        /// Temperatures of the joints, °C.
        joint_temperatures: Vec<f64> [double repeated, "41"],
        /// Temperature of the control box, °C.
        controller_temperature: f64 [double, "42"],
        /// Where the motion under way leads, TCP pose.
        target_waypoint: Vec<f64> [double repeated, "43"],
        /// Free-fall acceleration in the base frame, m/s².
        gravity: Vec<f64> [double repeated, "44"],
        /// Counts of the conveyor encoders, ticks.
        encoder_counts: Vec<f64> [double repeated, "45"],
        /// Range of the counter of encoder 0, number of the manual.
        encoder_range_0: u64 [uint64, "46"],
        /// Range of the counter of encoder 1, number of the manual.
        encoder_range_1: u64 [uint64, "47"],
        /// Sensitivity of collision detection, %.
        collision_sensitivity: u64 [uint64, "48"],
        /// 1 while collision detection is on.
        collision_detection: u64 [uint64, "49"],
        /// What the force sensor reads, the payload's weight and inertia included; frame as `tcp_force`.
        raw_wrench: Vec<f64> [double repeated, "50"],
        /// 1 while force mode is on.
        force_mode: u64 [uint64, "51"],
        /// TCP pose that the planned motion asks for, without offsets, belts and forces.
        path_pose: Vec<f64> [double repeated, "52"],
        /// Offset of the path in base, TCP and motion axes, six numbers each.
        path_offsets: Vec<f64> [double repeated, "53"],
    }
}

/// A recorded cycle that is not a state of the robot.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum CycleError {
    /// A vector has the wrong length.
    #[error("cycle {cycle}: {field} has {found} elements, it needs {wanted}")]
    #[zh("周期 {cycle}：{field} 有 {found} 个元素，需要 {wanted} 个")]
    Length {
        /// The cycle it was found in.
        cycle: u64,
        /// The field.
        field: &'static str,
        /// Elements found.
        found: usize,
        /// Elements needed.
        wanted: usize,
    },
    /// The motion generator has a name that this version does not know.
    #[error("cycle {cycle}: the motion generator {mode:?} is not known to this version")]
    #[zh("周期 {cycle}：此版本不认识运动生成器 {mode:?}")]
    Mode {
        /// The cycle it was found in.
        cycle: u64,
        /// The name found.
        mode: String,
    },
}

impl CycleMessage {
    /// Takes over a state. Memory is reused, so that recording a cycle does not allocate.
    pub fn set_from_state(&mut self, state: &RobotState) {
        // Without `..`: a field added to the state is a compile error here until the recording carries it.
        let RobotState {
            cycle,
            time,
            step_time,
            target_q,
            target_qd,
            target_qdd,
            actual_q,
            actual_qd,
            target_torque,
            actual_torque,
            target_tcp_pose,
            actual_tcp_pose,
            target_tcp_speed,
            actual_tcp_speed,
            tcp_force,
            raw_wrench,
            elbow_position,
            tcp_offset,
            payload,
            motion_mode,
            command_id,
            target_speed_fraction,
            speed_scaling,
            robot_mode,
            safety_mode,
            stop_code,
            digital_in,
            digital_out,
            analog_in,
            analog_out,
            io_config,
            records_lost,
            step_duration_us,
            wakeup_latency_us,
            external_torque,
            joint_temperatures,
            controller_temperature,
            target_waypoint,
            gravity,
            encoder_counts,
            encoder_ranges,
            collision_detection,
            collision_sensitivity,
            force_mode,
            path_pose,
            path_offsets,
        } = *state;
        self.cycle = cycle;
        self.time = time;
        put(&mut self.target_q, &target_q.0);
        put(&mut self.target_qd, &target_qd.0);
        put(&mut self.target_qdd, &target_qdd.0);
        put(&mut self.actual_q, &actual_q.0);
        put(&mut self.actual_qd, &actual_qd.0);
        put(&mut self.target_torque, &target_torque.0);
        put(&mut self.actual_torque, &actual_torque.0);
        put(&mut self.target_tcp_pose, &target_tcp_pose.to_array());
        put(&mut self.actual_tcp_pose, &actual_tcp_pose.to_array());
        put(&mut self.target_tcp_speed, &target_tcp_speed);
        put(&mut self.actual_tcp_speed, &actual_tcp_speed);
        put(&mut self.tcp_force, &tcp_force);
        put(&mut self.raw_wrench, &raw_wrench);
        if self.mode != motion_mode.name() {
            self.mode = motion_mode.name().to_owned();
        }
        self.command_id = command_id.0;
        self.speed_scaling = speed_scaling;
        self.safety_mode = safety_mode.number() as u32;
        self.robot_mode = robot_mode.number() as u32;
        self.digital_in = digital_in;
        self.digital_out = digital_out;
        put(&mut self.analog_in, &analog_in);
        put(&mut self.analog_out, &analog_out);
        self.step_duration_us = step_duration_us;
        self.wakeup_latency_us = wakeup_latency_us;
        self.step_time = step_time;
        put(&mut self.elbow_position, &elbow_position);
        put(&mut self.tcp_offset, &tcp_offset.to_array());
        put(&mut self.payload, &payload_numbers(&payload));
        self.target_speed_fraction = target_speed_fraction;
        self.stop_code = stop_code;
        self.records_lost = records_lost;
        self.io_config = io_config.to_bits();
        put(&mut self.external_torque, &external_torque.0);
        put(&mut self.joint_temperatures, &joint_temperatures);
        self.controller_temperature = controller_temperature;
        put(&mut self.target_waypoint, &target_waypoint.to_array());
        put(&mut self.gravity, &gravity);
        put(&mut self.encoder_counts, &encoder_counts);
        [self.encoder_range_0, self.encoder_range_1] = encoder_ranges;
        self.collision_sensitivity = collision_sensitivity;
        self.collision_detection = u64::from(collision_detection);
        self.force_mode = u64::from(force_mode);
        put(&mut self.path_pose, &path_pose.to_array());
        put(&mut self.path_offsets, path_offsets.as_flattened());
    }

    /// The state that was recorded.
    ///
    /// # Errors
    /// [`CycleError`] when a vector has the wrong length or the generator is not known: a file of another version, or
    /// not ours.
    pub fn to_state(&self) -> Result<RobotState, CycleError> {
        let mode = motion_mode(&self.mode).ok_or_else(|| CycleError::Mode {
            cycle: self.cycle,
            mode: self.mode.clone(),
        })?;
        let payload = payload_of(self.fixed_vector("payload", &self.payload)?);
        Ok(RobotState {
            cycle: self.cycle,
            time: self.time,
            step_time: self.step_time,
            target_q: JointPositions(self.fixed_vector("target_q", &self.target_q)?),
            target_qd: JointSpeeds(self.fixed_vector("target_qd", &self.target_qd)?),
            target_qdd: JointAccelerations(self.fixed_vector("target_qdd", &self.target_qdd)?),
            actual_q: JointPositions(self.fixed_vector("actual_q", &self.actual_q)?),
            actual_qd: JointSpeeds(self.fixed_vector("actual_qd", &self.actual_qd)?),
            target_torque: JointTorques(self.fixed_vector("target_torque", &self.target_torque)?),
            actual_torque: JointTorques(self.fixed_vector("actual_torque", &self.actual_torque)?),
            target_tcp_pose: RpyPose::from_array(
                self.fixed_vector("target_tcp_pose", &self.target_tcp_pose)?,
            ),
            actual_tcp_pose: RpyPose::from_array(
                self.fixed_vector("actual_tcp_pose", &self.actual_tcp_pose)?,
            ),
            target_tcp_speed: self.fixed_vector("target_tcp_speed", &self.target_tcp_speed)?,
            actual_tcp_speed: self.fixed_vector("actual_tcp_speed", &self.actual_tcp_speed)?,
            tcp_force: self.fixed_vector("tcp_force", &self.tcp_force)?,
            raw_wrench: self.fixed_vector("raw_wrench", &self.raw_wrench)?,
            elbow_position: self.fixed_vector("elbow_position", &self.elbow_position)?,
            tcp_offset: RpyPose::from_array(self.fixed_vector("tcp_offset", &self.tcp_offset)?),
            payload,
            motion_mode: mode,
            command_id: CommandId(self.command_id),
            target_speed_fraction: self.target_speed_fraction,
            speed_scaling: self.speed_scaling,
            robot_mode: RobotMode::from_number(self.robot_mode as i32),
            safety_mode: SafetyMode::from_number(self.safety_mode as i32),
            stop_code: self.stop_code,
            digital_in: self.digital_in,
            digital_out: self.digital_out,
            analog_in: self.fixed_vector("analog_in", &self.analog_in)?,
            analog_out: self.fixed_vector("analog_out", &self.analog_out)?,
            io_config: IoConfig::from_bits(self.io_config),
            records_lost: self.records_lost,
            step_duration_us: self.step_duration_us,
            wakeup_latency_us: self.wakeup_latency_us,
            external_torque: JointTorques(
                self.fixed_vector("external_torque", &self.external_torque)?,
            ),
            joint_temperatures: self
                .fixed_vector("joint_temperatures", &self.joint_temperatures)?,
            controller_temperature: self.controller_temperature,
            target_waypoint: RpyPose::from_array(
                self.fixed_vector("target_waypoint", &self.target_waypoint)?,
            ),
            gravity: self.fixed_vector("gravity", &self.gravity)?,
            encoder_counts: self.fixed_vector("encoder_counts", &self.encoder_counts)?,
            encoder_ranges: [self.encoder_range_0, self.encoder_range_1],
            collision_detection: self.collision_detection != 0,
            collision_sensitivity: self.collision_sensitivity,
            force_mode: self.force_mode != 0,
            path_pose: RpyPose::from_array(self.fixed_vector("path_pose", &self.path_pose)?),
            path_offsets: {
                let all: [f64; 18] = self.fixed_vector("path_offsets", &self.path_offsets)?;
                core::array::from_fn(|k| core::array::from_fn(|i| all[6 * k + i]))
            },
        })
    }

    /// The serialized `FileDescriptorSet` that goes into the file, comments included.
    pub fn descriptor_set() -> Vec<u8> {
        let mut comments = Vec::new();
        let field = (0_i32..).zip(FIELDS).map(|(index, field)| {
            comments.push(Location {
                // The path to field `index` of message 0, by the field numbers of descriptor.proto.
                path: vec![4, 0, 2, index],
                span: vec![index, 0, 0],
                leading_comments: Some(field.comment.to_owned()),
                ..Location::default()
            });
            let label = if field.repeated {
                Label::Repeated
            } else {
                Label::Optional
            };
            let kind = match field.kind {
                "uint64" => Type::Uint64,
                "uint32" => Type::Uint32,
                "string" => Type::String,
                _ => Type::Double,
            };
            FieldDescriptorProto {
                name: Some(field.name.to_owned()),
                number: field.number.parse().ok(),
                label: Some(label.into()),
                r#type: Some(kind.into()),
                ..FieldDescriptorProto::default()
            }
        });
        let message = DescriptorProto {
            name: Some("Cycle".to_owned()),
            field: field.collect(),
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            name: Some("elite/Cycle.proto".to_owned()),
            package: Some("elite".to_owned()),
            syntax: Some("proto3".to_owned()),
            message_type: vec![message],
            source_code_info: Some(SourceCodeInfo { location: comments }),
            ..FileDescriptorProto::default()
        };
        prost::Message::encode_to_vec(&FileDescriptorSet { file: vec![file] })
    }

    /// Fields of this version that a recorded schema (a serialized `FileDescriptorSet`) does not have. None where the
    /// schema cannot be read: the messages themselves decide then.
    pub(crate) fn fields_missing_in(schema: &[u8]) -> Vec<&'static str> {
        let Ok(set) = <FileDescriptorSet as prost::Message>::decode(schema) else {
            return Vec::new();
        };
        let messages = set.file.iter().flat_map(|file| &file.message_type);
        let Some(cycle) = messages.into_iter().find(|m| m.name() == "Cycle") else {
            return Vec::new();
        };
        let all = FIELDS.iter().map(|field| field.name);
        all.filter(|name| !cycle.field.iter().any(|field| field.name() == *name))
            .collect()
    }

    /// A vector of this length; zeros when there is none, since the version that recorded did not know it.
    fn fixed_vector<const N: usize>(
        &self,
        field: &'static str,
        values: &[f64],
    ) -> Result<[f64; N], CycleError> {
        if values.is_empty() {
            return Ok([0.0; N]);
        }
        values.try_into().map_err(|_| CycleError::Length {
            cycle: self.cycle,
            field,
            found: values.len(),
            wanted: N,
        })
    }
}

impl From<&RobotState> for CycleMessage {
    fn from(state: &RobotState) -> Self {
        let mut cycle = Self::default();
        cycle.set_from_state(state);
        cycle
    }
}

/// The ten numbers of a payload: mass, centre of gravity, inertia.
pub(crate) fn payload_numbers(payload: &Payload) -> [f64; 10] {
    let Payload { mass, cog, inertia } = payload;
    let mut numbers = [0.0; 10];
    numbers[0] = *mass;
    numbers[1..4].copy_from_slice(cog.as_slice());
    numbers[4..].copy_from_slice(inertia);
    numbers
}

/// The payload with these ten numbers, as [`payload_numbers`] gives them. Not checked: a recording may hold any.
pub(crate) fn payload_of([mass, x, y, z, inertia @ ..]: [f64; 10]) -> Payload {
    Payload {
        mass,
        cog: [x, y, z].into(),
        inertia,
    }
}

fn put(field: &mut Vec<f64>, values: &[f64]) {
    field.clear();
    field.extend_from_slice(values);
}

/// The generator of that name. The numbers of the generators are small and start at 0 (motion-api).
fn motion_mode(name: &str) -> Option<MotionMode> {
    (0..256)
        .map(MotionMode::from_number)
        .find(|mode| mode.name() == name)
}
