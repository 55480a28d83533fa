//! One cycle as ROS sees it, and the messages that are made of it.
//!
//! Numbers only: the process of the node has no model of the arm, and a recording needs none either.

use kinematics::{Pose, RobotModel};
use motion_api::{DigitalBank, RobotState};
use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

use crate::messages::{
    Analog, Bool, Clock, Float64, Header, IoState, JointState, Point, PoseStamped, Quaternion,
    RosPose, RosRobotMode, RosSafetyMode, RosWrench, TfMessage, Time, ToolData, Transform,
    TransformStamped, Vector3, WrenchStamped,
};
use crate::names::{BASE, BASE_INERTIA, BASE_LINK, JOINTS, LINKS, TCP, TOOL};

/// A pose as seven numbers: x, y, z, and a quaternion x, y, z, w.
pub type PoseNumbers = [f64; 7];

/// What the node shows of one cycle. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeSample {
    /// The cycle.
    pub cycle: u64,
    /// The cycle's time, ns: since 1970 under the real clock, since the start under the virtual one.
    pub stamp: i64,
    /// Positions of the joints.
    pub positions: [f64; 6],
    /// Speeds of the joints.
    pub speeds: [f64; 6],
    /// Torques of the joints.
    pub torques: [f64; 6],
    /// Each link in the one before it, base first.
    pub links: [PoseNumbers; 6],
    /// The TCP in the base.
    pub tcp: PoseNumbers,
    /// The environment on the tool, in the tool's axes: N, Nm.
    pub wrench: [f64; 6],
    /// The speed scaling in effect, 0 to 1.
    pub speed_scaling: f64,
    /// The number of the robot mode.
    pub robot_mode: i8,
    /// The number of the safety mode.
    pub safety_mode: i8,
    /// A task runs.
    pub task_running: bool,
    /// Digital inputs, bits as in the controller.
    pub digital_in: u32,
    /// Digital outputs, bits as the inputs.
    pub digital_out: u32,
    /// Analog inputs: standard 0, standard 1, tool; with the domain, 0 current and 1 voltage.
    pub analog_in: [(u8, f64); 3],
    /// Analog outputs in the order of the inputs.
    pub analog_out: [(u8, f64); 3],
    /// The mode of the tool's digital pins, the voltage of its connector and its temperature in °C.
    pub tool: (u8, f64, f64),
}

impl NodeSample {
    /// The sample of a state.
    pub fn of(state: &RobotState, model: &RobotModel, task_running: bool, stamp: i64) -> Self {
        let frames = model.forward(&state.actual_q);
        let joints = &frames.base_from_joint;
        let io = &state.io_config;
        Self {
            cycle: state.cycle,
            stamp,
            positions: state.actual_q.0,
            speeds: state.actual_qd.0,
            torques: state.actual_torque.0,
            links: std::array::from_fn(|joint| {
                numbers(&match joint {
                    0 => joints[0],
                    _ => joints[joint - 1].inverse() * joints[joint],
                })
            }),
            tcp: numbers(&Pose::from_rpy(&state.actual_tcp_pose)),
            wrench: state.tcp_force,
            speed_scaling: state.speed_scaling,
            robot_mode: small(state.robot_mode.number()),
            safety_mode: small(state.safety_mode.number()),
            task_running,
            digital_in: state.digital_in as u32,
            digital_out: state.digital_out as u32,
            analog_in: std::array::from_fn(|k| (io.analog_in[k] as u8, state.analog_in[k])),
            analog_out: std::array::from_fn(|k| (io.analog_out[k] as u8, state.analog_out[k])),
            tool: (
                io.tool_digital_mode,
                f64::from(io.tool_voltage),
                state.joint_temperatures[5],
            ),
        }
    }

    /// The moment of the cycle.
    pub fn time(&self) -> Time {
        Time::from_nanos(self.stamp)
    }

    fn header(&self, frame: &str, prefix: &str) -> Header {
        Header {
            stamp: self.time(),
            frame_id: format!("{prefix}{frame}"),
        }
    }

    /// Positions, speeds and torques of the joints. The frame is empty, as the driver's broadcaster leaves it.
    pub fn joint_state(&self, prefix: &str) -> JointState {
        JointState {
            header: Header {
                stamp: self.time(),
                frame_id: String::new(),
            },
            name: JOINTS.map(|name| format!("{prefix}{name}")).into(),
            position: self.positions.into(),
            velocity: self.speeds.into(),
            effort: self.torques.into(),
        }
    }

    /// The links, and the TCP in the base.
    pub fn moving_frames(&self, prefix: &str) -> TfMessage {
        let parents = std::iter::once(&BASE_INERTIA).chain(&LINKS);
        let links = parents.zip(&LINKS).zip(&self.links);
        let links = links.map(|((parent, child), pose)| self.frame(prefix, parent, child, pose));
        let tcp = self.frame(prefix, BASE, TCP, &self.tcp);
        TfMessage {
            transforms: links.chain(std::iter::once(tcp)).collect(),
        }
    }

    fn frame(
        &self,
        prefix: &str,
        parent: &str,
        child: &str,
        pose: &PoseNumbers,
    ) -> TransformStamped {
        TransformStamped {
            header: self.header(parent, prefix),
            child_frame_id: format!("{prefix}{child}"),
            transform: transform(pose),
        }
    }

    /// The wrench of the environment on the tool.
    pub fn wrench_stamped(&self, prefix: &str) -> WrenchStamped {
        let [fx, fy, fz, tx, ty, tz] = self.wrench;
        WrenchStamped {
            header: self.header(TOOL, prefix),
            wrench: RosWrench {
                force: Vector3 {
                    x: fx,
                    y: fy,
                    z: fz,
                },
                torque: Vector3 {
                    x: tx,
                    y: ty,
                    z: tz,
                },
            },
        }
    }

    /// The TCP in the base.
    pub fn tcp_pose(&self, prefix: &str) -> PoseStamped {
        let Transform {
            translation: Vector3 { x, y, z },
            rotation: orientation,
        } = transform(&self.tcp);
        PoseStamped {
            header: self.header(BASE, prefix),
            pose: RosPose {
                position: Point { x, y, z },
                orientation,
            },
        }
    }

    /// The speed scaling, per cent.
    pub fn speed_scaling(&self) -> Float64 {
        Float64 {
            data: 100.0 * self.speed_scaling,
        }
    }

    /// Levels of all points.
    pub fn io_state(&self) -> IoState {
        let bits = |word: u32, bank: DigitalBank, count: u8| {
            (0..count)
                .map(|k| word >> bank.bit(k) & 1 == 1)
                .collect::<Vec<bool>>()
        };
        let analog = |points: &[(u8, f64); 3]| {
            points[..2]
                .iter()
                .map(|(domain, value)| Analog {
                    r#type: *domain,
                    value: *value,
                })
                .collect::<Vec<Analog>>()
        };
        let (outs, ins) = (self.digital_out, self.digital_in);
        IoState {
            standard_out: bits(outs, DigitalBank::Standard, 16),
            config_out: bits(outs, DigitalBank::Configurable, 8),
            tool_out: bits(outs, DigitalBank::Tool, 4),
            standard_in: bits(ins, DigitalBank::Standard, 16),
            config_in: bits(ins, DigitalBank::Configurable, 8),
            tool_in: bits(ins, DigitalBank::Tool, 4),
            standard_analog_out: analog(&self.analog_out),
            standard_analog_in: analog(&self.analog_in),
        }
    }

    /// The connector of the tool. Nothing is plugged in, so no current flows.
    pub fn tool_data(&self) -> ToolData {
        let (mode, output_voltage, temperature) = self.tool;
        let ((in_type, analog_input), (out_type, analog_output)) =
            (self.analog_in[2], self.analog_out[2]);
        ToolData {
            mode,
            output_voltage,
            output_current: 0.0,
            temperature,
            analog_input_type: in_type,
            analog_input,
            analog_output_type: out_type,
            analog_output,
        }
    }

    /// The mode of the arm.
    pub fn robot_mode(&self) -> RosRobotMode {
        RosRobotMode {
            mode: self.robot_mode,
        }
    }

    /// The mode of the safety system.
    pub fn safety_mode(&self) -> RosSafetyMode {
        RosSafetyMode {
            mode: self.safety_mode,
        }
    }

    /// Whether a task runs.
    pub fn task_running(&self) -> Bool {
        Bool {
            data: self.task_running,
        }
    }

    /// Simulated time.
    pub fn clock(&self) -> Clock {
        Clock { clock: self.time() }
    }
}

/// Frames that never move: parent, child. All of them lie in their parent without a rotation.
const FIXED: [(&str, &str); 5] = [
    (BASE_LINK, BASE_INERTIA),
    (BASE_LINK, BASE),
    ("wrist_3_link", "flange"),
    ("flange", TOOL),
    ("wrist_3_link", "ft_frame"),
];

/// The frames that never move; `flange_in_wrist` is where the flange is on the last link.
pub fn fixed_frames(prefix: &str, flange_in_wrist: &PoseNumbers, stamp: Time) -> TfMessage {
    let frame = |(parent, child): &(&str, &str)| TransformStamped {
        header: Header {
            stamp: stamp.clone(),
            frame_id: format!("{prefix}{parent}"),
        },
        child_frame_id: format!("{prefix}{child}"),
        transform: transform(match *child {
            "flange" => flange_in_wrist,
            _ => &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        }),
    };
    TfMessage {
        transforms: FIXED.iter().map(frame).collect(),
    }
}

/// Where the flange is on the last link.
pub fn flange_in_wrist(model: &RobotModel) -> PoseNumbers {
    let frames = model.forward(&kinematics::JointPositions::ZERO);
    numbers(&(frames.base_from_joint[5].inverse() * frames.base_from_flange))
}

fn transform(&[x, y, z, qx, qy, qz, qw]: &PoseNumbers) -> Transform {
    Transform {
        translation: Vector3 { x, y, z },
        rotation: Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w: qw,
        },
    }
}

fn numbers(pose: &Pose) -> PoseNumbers {
    let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation);
    let at = pose.translation;
    [at.x, at.y, at.z, turn.i, turn.j, turn.k, turn.w]
}

fn small(number: i32) -> i8 {
    i8::try_from(number).unwrap_or(-1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::{JointPositions, RpyPose};

    fn sample() -> (NodeSample, RobotModel) {
        let model = RobotModel::built_in("cs66").unwrap();
        let q = JointPositions([0.3, -1.2, 1.0, -0.4, 0.9, 0.2]);
        let mut state = RobotState::at_start(q, 0.004);
        state.actual_tcp_pose = RpyPose::from_array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
        state.digital_out = 1 << 3 | 1 << 17;
        state.digital_in = 1 << 25;
        state.speed_scaling = 0.4;
        (NodeSample::of(&state, &model, true, 1_500_000_001), model)
    }

    #[test]
    fn the_frames_joined_lead_to_the_flange_of_the_model() {
        let (sample, model) = sample();
        let joined = sample.links.iter().fold(Pose::IDENTITY, |pose, link| {
            let [x, y, z, i, j, k, w] = *link;
            let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k));
            pose * Pose {
                translation: [x, y, z].into(),
                rotation: turn.to_rotation_matrix(),
            }
        });
        let frames = model.forward(&JointPositions(sample.positions));
        let away = (joined.translation - frames.base_from_joint[5].translation).norm();
        assert!(away < 1e-12, "{away}");
        let tf = sample.moving_frames("left_");
        assert_eq!(tf.transforms.len(), 7);
        assert_eq!(tf.transforms[0].header.frame_id, "left_base_link_inertia");
        assert_eq!(tf.transforms[6].child_frame_id, "left_tool0_controller");
    }

    #[test]
    fn levels_modes_and_scaling_are_those_of_the_state() {
        let (sample, _) = sample();
        let io = sample.io_state();
        assert!(io.standard_out[3] && io.config_out[1] && io.tool_in[1]);
        assert_eq!(io.standard_out.iter().filter(|level| **level).count(), 1);
        assert_eq!(
            (io.standard_out.len(), io.config_in.len(), io.tool_in.len()),
            (16, 8, 4)
        );
        assert_eq!(sample.speed_scaling().data, 40.0);
        assert_eq!(sample.robot_mode().mode, 7);
        assert_eq!(sample.safety_mode().mode, 1);
        assert_eq!(
            sample.time(),
            Time {
                sec: 1,
                nanosec: 500_000_001
            }
        );
        assert_eq!(sample.joint_state("").name[5], "wrist_3_joint");
    }
}
