//! Messages of the packages that come with ROS 2.

use super::messages;

messages! {
    /// A moment.
    Time = "builtin_interfaces" / "Time" {
        sec: i32 = "int32 sec",
        nanosec: u32 = "uint32 nanosec",
    }

    /// A span of time.
    Duration = "builtin_interfaces" / "Duration" {
        sec: i32 = "int32 sec",
        nanosec: u32 = "uint32 nanosec",
    }

    /// When and in which frame.
    Header = "std_msgs" / "Header" {
        stamp: Time = "builtin_interfaces/Time stamp",
        frame_id: String = "string frame_id",
    }

    /// A text.
    Text = "std_msgs" / "String" {
        data: String = "string data",
    }

    /// A truth.
    Bool = "std_msgs" / "Bool" {
        data: bool = "bool data",
    }

    /// A number.
    Float64 = "std_msgs" / "Float64" {
        data: f64 = "float64 data",
    }

    /// Simulated time.
    Clock = "rosgraph_msgs" / "Clock" {
        clock: Time = "builtin_interfaces/Time clock",
    }

    /// What the joints do: rad, rad/s, Nm.
    JointState = "sensor_msgs" / "JointState" {
        header: Header = "std_msgs/Header header",
        name: Vec<String> = "string[] name",
        position: Vec<f64> = "float64[] position",
        velocity: Vec<f64> = "float64[] velocity",
        effort: Vec<f64> = "float64[] effort",
    }

    /// A vector.
    Vector3 = "geometry_msgs" / "Vector3" {
        x: f64 = "float64 x",
        y: f64 = "float64 y",
        z: f64 = "float64 z",
    }

    /// A place, m.
    Point = "geometry_msgs" / "Point" {
        x: f64 = "float64 x",
        y: f64 = "float64 y",
        z: f64 = "float64 z",
    }

    /// A rotation.
    Quaternion = "geometry_msgs" / "Quaternion" {
        x: f64 = "float64 x",
        y: f64 = "float64 y",
        z: f64 = "float64 z",
        w: f64 = "float64 w",
    }

    /// A place and a rotation.
    RosPose = "geometry_msgs" / "Pose" {
        position: Point = "geometry_msgs/Point position",
        orientation: Quaternion = "geometry_msgs/Quaternion orientation",
    }

    /// A pose with its moment and frame.
    PoseStamped = "geometry_msgs" / "PoseStamped" {
        header: Header = "std_msgs/Header header",
        pose: RosPose = "geometry_msgs/Pose pose",
    }

    /// A frame in another one.
    Transform = "geometry_msgs" / "Transform" {
        translation: Vector3 = "geometry_msgs/Vector3 translation",
        rotation: Quaternion = "geometry_msgs/Quaternion rotation",
    }

    /// A frame in another one, with their names.
    TransformStamped = "geometry_msgs" / "TransformStamped" {
        header: Header = "std_msgs/Header header",
        child_frame_id: String = "string child_frame_id",
        transform: Transform = "geometry_msgs/Transform transform",
    }

    /// Frames.
    TfMessage = "tf2_msgs" / "TFMessage" {
        transforms: Vec<TransformStamped> = "geometry_msgs/TransformStamped[] transforms",
    }

    /// A speed and an angular speed.
    Twist = "geometry_msgs" / "Twist" {
        linear: Vector3 = "geometry_msgs/Vector3 linear",
        angular: Vector3 = "geometry_msgs/Vector3 angular",
    }

    /// A force, N, and a torque, Nm.
    RosWrench = "geometry_msgs" / "Wrench" {
        force: Vector3 = "geometry_msgs/Vector3 force",
        torque: Vector3 = "geometry_msgs/Vector3 torque",
    }

    /// A wrench with its moment and frame.
    WrenchStamped = "geometry_msgs" / "WrenchStamped" {
        header: Header = "std_msgs/Header header",
        wrench: RosWrench = "geometry_msgs/Wrench wrench",
    }
}

/// Nanoseconds of a second.
const NANOS: i64 = 1_000_000_000;

impl Time {
    /// The moment so many nanoseconds after zero; what does not fit into a message becomes the nearest that does.
    pub fn from_nanos(nanos: i64) -> Self {
        Self {
            sec: clamp_secs(nanos.div_euclid(NANOS)),
            nanosec: nanos.rem_euclid(NANOS) as u32,
        }
    }

    /// Nanoseconds after zero.
    pub fn to_nanos(&self) -> i64 {
        i64::from(self.sec) * NANOS + i64::from(self.nanosec)
    }
}

impl Duration {
    /// The span of `secs` seconds, to a nanosecond.
    pub fn from_secs(secs: f64) -> Self {
        let nanos = (secs * NANOS as f64).round() as i64;
        Self {
            sec: clamp_secs(nanos.div_euclid(NANOS)),
            nanosec: nanos.rem_euclid(NANOS) as u32,
        }
    }

    /// Seconds.
    pub fn to_secs(&self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) * 1e-9
    }
}

fn clamp_secs(secs: i64) -> i32 {
    secs.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}
