//! The largest values that a run has come to: speed and force of the tool, speed and torque of the joints.
//!
//! Owns which values there are and what they are called. Values are magnitudes and SI.

use messages::{Text, text};
use motion_api::RobotState;

/// The largest values of the cycles that were taken; zeros before the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peaks {
    /// Speed of the TCP, m/s.
    pub tcp_speed: f64,
    /// Force on the tool, N.
    pub tcp_force: f64,
    /// Moment on the tool about the TCP, Nm.
    pub tcp_torque: f64,
    /// Speeds of the joints, rad/s.
    pub joint_speed: [f64; 6],
    /// Torques of the joints, Nm.
    pub joint_torque: [f64; 6],
}

impl Peaks {
    /// Takes a cycle into account: what the arm did, not what it was asked for.
    pub fn update(&mut self, state: &RobotState) {
        let [x, y, z, rx, ry, rz] = state.tcp_force;
        let [vx, vy, vz, ..] = state.actual_tcp_speed;
        self.tcp_speed = self.tcp_speed.max(length([vx, vy, vz]));
        self.tcp_force = self.tcp_force.max(length([x, y, z]));
        self.tcp_torque = self.tcp_torque.max(length([rx, ry, rz]));
        for (peak, speed) in self.joint_speed.iter_mut().zip(state.actual_qd.0) {
            *peak = peak.max(speed.abs());
        }
        for (peak, torque) in self.joint_torque.iter_mut().zip(state.actual_torque.0) {
            *peak = peak.max(torque.abs());
        }
    }

    /// The value of that name: `tcp_speed`, `tcp_force`, `tcp_torque`, `joint_speed`, `joint_torque` (of the joint that
    /// has the largest), or of one joint, counted from 0, as in `joint_speed[2]`.
    ///
    /// # Errors
    /// A sentence with the names there are.
    pub fn by_name(&self, name: &str) -> Result<f64, Text> {
        let largest = |values: [f64; 6]| values.into_iter().fold(0.0, f64::max);
        let one = |values: [f64; 6], index: &str| {
            let index: Option<usize> = index.strip_suffix(']').and_then(|text| text.parse().ok());
            index.and_then(|index| values.get(index).copied())
        };
        let value = match name.split_once('[') {
            None => match name {
                "tcp_speed" => Some(self.tcp_speed),
                "tcp_force" => Some(self.tcp_force),
                "tcp_torque" => Some(self.tcp_torque),
                "joint_speed" => Some(largest(self.joint_speed)),
                "joint_torque" => Some(largest(self.joint_torque)),
                _ => None,
            },
            Some(("joint_speed", index)) => one(self.joint_speed, index),
            Some(("joint_torque", index)) => one(self.joint_torque, index),
            Some(_) => None,
        };
        value.ok_or_else(|| {
            text!(
                "there is no peak {name:?}; allowed are tcp_speed, tcp_force, tcp_torque, joint_speed and \
                 joint_torque, the last two also of one joint, joint_speed[0] to joint_speed[5]",
                "没有峰值 {name:?}；允许 tcp_speed、tcp_force、tcp_torque、joint_speed 和 joint_torque，\
                 后两个也可指一个关节，joint_speed[0] 到 joint_speed[5]"
            )
        })
    }
}

fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use kinematics::{JointPositions, JointSpeeds};

    use super::*;

    #[test]
    fn the_largest_of_each_is_kept_and_found_by_name() {
        let mut state = RobotState::at_start(JointPositions([0.0; 6]), 0.004);
        let mut peaks = Peaks::default();
        state.actual_tcp_speed = [0.3, -0.4, 0.0, 9.0, 9.0, 9.0];
        state.actual_qd = JointSpeeds([0.0, 0.0, -1.5, 0.0, 1.0, 0.0]);
        peaks.update(&state);
        state.actual_tcp_speed = [0.1; 6];
        state.tcp_force = [0.0, 0.0, -7.0, 0.5, 0.0, 0.0];
        state.actual_qd = JointSpeeds([0.0; 6]);
        peaks.update(&state);
        for (name, value) in [
            ("tcp_speed", 0.5),
            ("tcp_force", 7.0),
            ("tcp_torque", 0.5),
            ("joint_speed", 1.5),
            ("joint_speed[2]", 1.5),
            ("joint_speed[4]", 1.0),
            ("joint_torque[0]", 0.0),
        ] {
            assert_eq!(peaks.by_name(name), Ok(value), "{name}");
        }
        for wrong in [
            "speed",
            "joint_speed[6]",
            "joint_speed[-1]",
            "joint_speed[2",
            "tcp_speed[0]",
            "",
        ] {
            assert!(
                peaks
                    .by_name(wrong)
                    .unwrap_err()
                    .english()
                    .contains("joint_speed[5]"),
                "{wrong}"
            );
        }
    }
}
