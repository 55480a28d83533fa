//! Trajectories and the action that runs them (trajectory_msgs, control_msgs 5 of Humble and Jazzy).

use super::{Duration, Header, Transform, Twist, messages};

messages! {
    /// One point of a trajectory; lists that are not given are empty.
    JointTrajectoryPoint = "trajectory_msgs" / "JointTrajectoryPoint" {
        positions: Vec<f64> = "float64[] positions",
        velocities: Vec<f64> = "float64[] velocities",
        accelerations: Vec<f64> = "float64[] accelerations",
        effort: Vec<f64> = "float64[] effort",
        time_from_start: Duration = "builtin_interfaces/Duration time_from_start",
    }

    /// Points in order.
    JointTrajectory = "trajectory_msgs" / "JointTrajectory" {
        header: Header = "std_msgs/Header header",
        joint_names: Vec<String> = "string[] joint_names",
        points: Vec<JointTrajectoryPoint> = "trajectory_msgs/JointTrajectoryPoint[] points",
    }

    /// One point of joints with several degrees of freedom.
    MultiDofJointTrajectoryPoint = "trajectory_msgs" / "MultiDOFJointTrajectoryPoint" {
        transforms: Vec<Transform> = "geometry_msgs/Transform[] transforms",
        velocities: Vec<Twist> = "geometry_msgs/Twist[] velocities",
        accelerations: Vec<Twist> = "geometry_msgs/Twist[] accelerations",
        time_from_start: Duration = "builtin_interfaces/Duration time_from_start",
    }

    /// Points of joints with several degrees of freedom; an arm has none.
    MultiDofJointTrajectory = "trajectory_msgs" / "MultiDOFJointTrajectory" {
        header: Header = "std_msgs/Header header",
        joint_names: Vec<String> = "string[] joint_names",
        points: Vec<MultiDofJointTrajectoryPoint> = "trajectory_msgs/MultiDOFJointTrajectoryPoint[] points",
    }

    /// How far a joint may be away: 0 means the default, a negative number means no limit.
    JointTolerance = "control_msgs" / "JointTolerance" {
        name: String = "string name",
        position: f64 = "float64 position",
        velocity: f64 = "float64 velocity",
        acceleration: f64 = "float64 acceleration",
    }

    /// How far a component of a joint with several degrees of freedom may be away.
    JointComponentTolerance = "control_msgs" / "JointComponentTolerance" {
        joint_name: String = "string joint_name",
        component: u16 = "uint16 component",
        position: f64 = "float64 position",
        velocity: f64 = "float64 velocity",
        acceleration: f64 = "float64 acceleration",
    }

    /// The goal of `FollowJointTrajectory`.
    TrajectoryGoal = "control_msgs" / "FollowJointTrajectory_Goal" {
        trajectory: JointTrajectory = "trajectory_msgs/JointTrajectory trajectory",
        multi_dof_trajectory: MultiDofJointTrajectory = "trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory",
        path_tolerance: Vec<JointTolerance> = "control_msgs/JointTolerance[] path_tolerance",
        component_path_tolerance: Vec<JointComponentTolerance> =
            "control_msgs/JointComponentTolerance[] component_path_tolerance",
        goal_tolerance: Vec<JointTolerance> = "control_msgs/JointTolerance[] goal_tolerance",
        component_goal_tolerance: Vec<JointComponentTolerance> =
            "control_msgs/JointComponentTolerance[] component_goal_tolerance",
        goal_time_tolerance: Duration = "builtin_interfaces/Duration goal_time_tolerance",
    }

    /// The result of `FollowJointTrajectory`.
    TrajectoryResult = "control_msgs" / "FollowJointTrajectory_Result" {
        error_code: i32 = "int32 error_code",
        error_string: String = "string error_string",
    }

    /// The feedback of `FollowJointTrajectory`.
    TrajectoryFeedback = "control_msgs" / "FollowJointTrajectory_Feedback" {
        header: Header = "std_msgs/Header header",
        joint_names: Vec<String> = "string[] joint_names",
        desired: JointTrajectoryPoint = "trajectory_msgs/JointTrajectoryPoint desired",
        actual: JointTrajectoryPoint = "trajectory_msgs/JointTrajectoryPoint actual",
        error: JointTrajectoryPoint = "trajectory_msgs/JointTrajectoryPoint error",
        multi_dof_joint_names: Vec<String> = "string[] multi_dof_joint_names",
        multi_dof_desired: MultiDofJointTrajectoryPoint =
            "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired",
        multi_dof_actual: MultiDofJointTrajectoryPoint =
            "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual",
        multi_dof_error: MultiDofJointTrajectoryPoint = "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error",
    }
}
