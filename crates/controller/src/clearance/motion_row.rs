//! What is told of one motion: how near it comes, to what, where and when.

use kinematics::{JointPositions, RobotModel};
use messages::Text;
use motion_api::RobotState;
use nalgebra::Matrix6;
use path_planning::{CollisionScene, NearestPlace};

/// The nearest place of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastDistance {
    /// Distance between the surfaces of the two, m; negative ones are depths.
    pub distance: f64,
    /// What moves with the arm.
    pub a: Text,
    /// What it comes near to: a thing of the cell, or another part of the arm.
    pub b: Text,
    /// Simulated time, s.
    pub time: f64,
    /// The TCP there, in the base frame: m and rad.
    pub tcp: [f64; 6],
}

/// A gripper has taken a part, or let it go.
#[derive(Clone, Debug, PartialEq)]
pub struct GripChange {
    /// The control cycle.
    pub cycle: u64,
    /// Name of the part.
    pub part: String,
    /// Name of the gripper that holds it now, if one does.
    pub held_by: Option<String>,
    /// The place of the part then, in the base frame, m.
    pub place: [f64; 3],
}

/// One motion, or a stream of setpoints from one line of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionClearance {
    /// Line of the program, from 1; 0 for a motion that no program asked for.
    pub line: u32,
    /// Label of the task's node in which the line stands.
    pub node: Option<String>,
    /// Name of the function, `movej` for instance.
    pub kind: &'static str,
    /// Where it comes nearest to something; `None` where nothing can touch.
    pub least: Option<LeastDistance>,
    /// The least distance of a joint to the end of its range, rad.
    pub joint_margin: f64,
    /// The least singular value of the Jacobian of the TCP, in m and rad.
    pub singularity: f64,
    /// Whether force mode was on at any time of it.
    pub in_force_mode: bool,
}

impl MotionClearance {
    /// A motion that has not been seen yet.
    pub(super) const fn new(line: u32, node: Option<String>, kind: &'static str) -> Self {
        Self {
            line,
            node,
            kind,
            least: None,
            joint_margin: f64::INFINITY,
            singularity: f64::INFINITY,
            in_force_mode: false,
        }
    }

    /// The least distance so far, m; infinite before the first.
    pub fn distance(&self) -> f64 {
        self.least
            .as_ref()
            .map_or(f64::INFINITY, |least| least.distance)
    }

    /// Takes a nearer place into account, found on the way to `state`.
    pub(super) fn note_place(
        &mut self,
        place: &NearestPlace,
        scene: &CollisionScene,
        state: &RobotState,
    ) {
        if place.nearest.distance >= self.distance() {
            return;
        }
        let (a, b) = scene.texts(place.nearest.pair);
        let pose = scene.model().tcp_pose(&place.q, scene.flange_from_tcp());
        self.least = Some(LeastDistance {
            distance: place.nearest.distance,
            a,
            b,
            time: state.time - state.step_time * (1.0 - place.fraction),
            tcp: pose.to_rpy().to_array(),
        });
    }

    /// Takes the posture of a cycle into account.
    pub(super) fn note_posture(&mut self, q: &JointPositions, scene: &CollisionScene) {
        let model = scene.model();
        self.joint_margin = self.joint_margin.min(joint_margin(model, q));
        let (_, jacobian) = model.tcp_pose_and_jacobian(q, scene.flange_from_tcp());
        self.singularity = self.singularity.min(least_singular_value(&jacobian));
    }
}

/// The least distance of a joint to the end of its range, rad; negative beyond it.
pub fn joint_margin(model: &RobotModel, q: &JointPositions) -> f64 {
    let limits = model.limits();
    let margins = (0..6).map(|joint| {
        let (min, max) = (limits.position_min[joint], limits.position_max[joint]);
        (q[joint] - min).min(max - q[joint])
    });
    margins.fold(f64::INFINITY, f64::min)
}

/// The least singular value of a Jacobian.
pub fn least_singular_value(jacobian: &Matrix6<f64>) -> f64 {
    jacobian.singular_values().min()
}
