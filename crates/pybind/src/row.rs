//! One cycle as a row of fixed size, which numpy reads in place: the fields of `/cycle` by their names.
//!
//! One table makes the row, its bytes and its description, so that they cannot drift apart.

use motion_api::RobotState;
use recorder::CycleMessage;

/// Characters of the name of a motion generator.
const MODE_CHARS: usize = 16;

macro_rules! row {
    ($($name:ident: $type:ty = $format:literal, $from_state:expr, $from_cycle:expr;)+) => {
        /// The published fields of one cycle.
        pub(crate) struct Row { $($name: $type,)+ }

        impl From<&RobotState> for Row {
            fn from(state: &RobotState) -> Self {
                Self { $($name: $from_state(state),)+ }
            }
        }

        impl From<&CycleMessage> for Row {
            /// A vector that a recording does not have, or has too short, is not a number there: it was not measured.
            fn from(cycle: &CycleMessage) -> Self {
                Self { $($name: $from_cycle(cycle),)+ }
            }
        }

        impl Row {
            /// Bytes of a row.
            pub(crate) const BYTES: usize = 0 $(+ size_of::<$type>())+;

            /// Appends the row, field by field without gaps, as the machine has numbers in memory.
            pub(crate) fn write(&self, out: &mut Vec<u8>) {
                $(self.$name.put(out);)+
            }
        }

        /// Name and numpy format of every field of a row, in order.
        #[pyo3::pyfunction]
        pub(crate) fn row_fields() -> Vec<(&'static str, &'static str)> {
            vec![$((stringify!($name), $format)),+]
        }
    };
}

/// A field that can be written.
trait WriteField {
    fn put(&self, out: &mut Vec<u8>);
}

macro_rules! put {
    ($($type:ty),+) => {$(
        impl WriteField for $type {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_ne_bytes());
            }
        }
    )+};
}
put!(u64, u32, f64);

impl<T: WriteField, const N: usize> WriteField for [T; N] {
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|part| part.put(out));
    }
}

row! {
    cycle: u64 = "u8", |s: &RobotState| s.cycle, |c: &CycleMessage| c.cycle;
    time: f64 = "f8", |s: &RobotState| s.time, |c: &CycleMessage| c.time;
    target_q: [f64; 6] = "6f8", |s: &RobotState| s.target_q.0, |c: &CycleMessage| numbers(&c.target_q);
    target_qd: [f64; 6] = "6f8", |s: &RobotState| s.target_qd.0, |c: &CycleMessage| numbers(&c.target_qd);
    target_qdd: [f64; 6] = "6f8", |s: &RobotState| s.target_qdd.0, |c: &CycleMessage| numbers(&c.target_qdd);
    actual_q: [f64; 6] = "6f8", |s: &RobotState| s.actual_q.0, |c: &CycleMessage| numbers(&c.actual_q);
    actual_qd: [f64; 6] = "6f8", |s: &RobotState| s.actual_qd.0, |c: &CycleMessage| numbers(&c.actual_qd);
    target_torque: [f64; 6] = "6f8", |s: &RobotState| s.target_torque.0, |c: &CycleMessage| numbers(&c.target_torque);
    actual_torque: [f64; 6] = "6f8", |s: &RobotState| s.actual_torque.0, |c: &CycleMessage| numbers(&c.actual_torque);
    target_tcp_pose: [f64; 6] = "6f8", |s: &RobotState| s.target_tcp_pose.to_array(),
        |c: &CycleMessage| numbers(&c.target_tcp_pose);
    actual_tcp_pose: [f64; 6] = "6f8", |s: &RobotState| s.actual_tcp_pose.to_array(),
        |c: &CycleMessage| numbers(&c.actual_tcp_pose);
    target_tcp_speed: [f64; 6] = "6f8", |s: &RobotState| s.target_tcp_speed,
        |c: &CycleMessage| numbers(&c.target_tcp_speed);
    actual_tcp_speed: [f64; 6] = "6f8", |s: &RobotState| s.actual_tcp_speed,
        |c: &CycleMessage| numbers(&c.actual_tcp_speed);
    tcp_force: [f64; 6] = "6f8", |s: &RobotState| s.tcp_force, |c: &CycleMessage| numbers(&c.tcp_force);
    raw_wrench: [f64; 6] = "6f8", |s: &RobotState| s.raw_wrench, |c: &CycleMessage| numbers(&c.raw_wrench);
    tcp_offset: [f64; 6] = "6f8", |s: &RobotState| s.tcp_offset.to_array(), |c: &CycleMessage| numbers(&c.tcp_offset);
    gravity: [f64; 3] = "3f8", |s: &RobotState| s.gravity, |c: &CycleMessage| numbers(&c.gravity);
    mode: [u32; MODE_CHARS] = "U16", |s: &RobotState| characters(s.motion_mode.name()),
        |c: &CycleMessage| characters(&c.mode);
    command_id: u64 = "u8", |s: &RobotState| s.command_id.0, |c: &CycleMessage| c.command_id;
    speed_scaling: f64 = "f8", |s: &RobotState| s.speed_scaling, |c: &CycleMessage| c.speed_scaling;
    safety_mode: u32 = "u4", |s: &RobotState| s.safety_mode.number() as u32, |c: &CycleMessage| c.safety_mode;
    robot_mode: u32 = "u4", |s: &RobotState| s.robot_mode.number() as u32, |c: &CycleMessage| c.robot_mode;
    digital_in: u64 = "u8", |s: &RobotState| s.digital_in, |c: &CycleMessage| c.digital_in;
    digital_out: u64 = "u8", |s: &RobotState| s.digital_out, |c: &CycleMessage| c.digital_out;
    analog_in: [f64; 3] = "3f8", |s: &RobotState| s.analog_in, |c: &CycleMessage| numbers(&c.analog_in);
    analog_out: [f64; 3] = "3f8", |s: &RobotState| s.analog_out, |c: &CycleMessage| numbers(&c.analog_out);
    step_duration_us: f64 = "f8", |s: &RobotState| s.step_duration_us, |c: &CycleMessage| c.step_duration_us;
    wakeup_latency_us: f64 = "f8", |s: &RobotState| s.wakeup_latency_us, |c: &CycleMessage| c.wakeup_latency_us;
}

fn numbers<const N: usize>(values: &[f64]) -> [f64; N] {
    core::array::from_fn(|k| values.get(k).copied().unwrap_or(f64::NAN))
}

fn characters(text: &str) -> [u32; MODE_CHARS] {
    let mut characters = [0; MODE_CHARS];
    for (place, character) in characters.iter_mut().zip(text.chars()) {
        *place = u32::from(character);
    }
    characters
}
