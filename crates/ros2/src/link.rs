//! What the controller and the process of the node tell each other over their local socket.
//!
//! Frames: a length of four bytes, little endian, then a value as CDR. Both ends come from one program; a version is
//! told first all the same, since a file on disk may be exchanged while a controller runs. The controller believes
//! nothing that comes from the node's process: sizes are bounded, and what cannot be read ends the process.

use messages::Localized;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::messages::{
    JointTrajectory, SetIoRequest, SetPayloadRequest, TrajectoryFeedback, TrajectoryGoal,
};
use crate::sample::{NodeSample, PoseNumbers};

/// The version of this protocol.
pub const VERSION: u32 = 1;
/// Longest frame, bytes: a trajectory with the most points that are taken is half as long.
pub const FRAME_MAX: usize = 8 << 20;

/// The number of a goal, which its client chooses.
pub type GoalId = [u8; 16];

/// What the node is to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeSetup {
    /// The version of the protocol.
    pub version: u32,
    /// The DDS domain.
    pub domain: u16,
    /// The namespace, with its slash.
    pub namespace: String,
    /// What joints and frames begin with.
    pub prefix: String,
    /// Addresses of the interfaces that are used, as text.
    pub networks: Vec<String>,
    /// Nothing goes out of this machine or comes from outside.
    pub loopback_only: bool,
    /// The mapping of services is that of CycloneDDS, not that of Fast DDS.
    pub cyclone: bool,
    /// Time is simulated: `/clock` is published.
    pub simulated_time: bool,
    /// The description of the arm.
    pub urdf: String,
    /// Where the flange is on the last link.
    pub flange_in_wrist: PoseNumbers,
    /// The name of the model.
    pub model: String,
    /// Length of a cycle, ms.
    pub step_ms: f64,
    /// Most bytes of memory that the process may have.
    pub memory_max: u64,
}

/// From the controller to the node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "nearly every one is a sample")]
pub enum ControllerMessage {
    /// First of all.
    Setup(NodeSetup),
    /// A cycle.
    Sample(NodeSample),
    /// The answer to a request.
    Answer {
        /// The number of the request.
        request: u64,
        /// Success: the request was carried out.
        success: bool,
        /// What there is to say.
        message: String,
    },
    /// Whether a goal is taken.
    GoalTaken {
        /// The goal.
        id: GoalId,
        /// True if the goal is taken.
        accepted: bool,
        /// The reason of a refusal, or nothing.
        message: String,
    },
    /// A goal begins to brake because a client asked for it.
    Canceling {
        /// The goals.
        ids: Vec<GoalId>,
    },
    /// How a goal is getting on.
    Feedback {
        /// The goal.
        id: GoalId,
        /// Positions of the arm, wanted and actual.
        feedback: TrajectoryFeedback,
    },
    /// A goal has ended.
    GoalEnded {
        /// The goal.
        id: GoalId,
        /// The kind of end.
        end: GoalEnd,
        /// The code of control_msgs.
        code: i32,
        /// The reason of the end, or nothing.
        message: String,
    },
    /// A line for `/rosout`.
    Log {
        /// The level of rcl_interfaces/Log: 20 info, 30 warning, 40 error.
        level: u8,
        /// The line.
        text: String,
    },
    /// The end.
    End,
}

/// How a goal ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GoalEnd {
    /// The arm is where the goal leads to.
    Succeeded,
    /// A client canceled the goal.
    Canceled,
    /// A stop, a refusal or a violated tolerance.
    Aborted,
}

/// From the node to the controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum NodeMessage {
    /// The node is there.
    Ready {
        /// The version of the protocol.
        version: u32,
    },
    /// A request of a service.
    Request {
        /// A number for the answer.
        request: u64,
        /// What is asked for.
        order: Order,
    },
    /// A new goal.
    Goal {
        /// Number of the goal.
        id: GoalId,
        /// The goal.
        goal: TrajectoryGoal,
    },
    /// Goals are to be canceled.
    Cancel {
        /// Numbers of the goals.
        ids: Vec<GoalId>,
    },
    /// A trajectory of the topic.
    Trajectory(JointTrajectory),
    /// Samples that were published since the message before; only under simulated time.
    Shown {
        /// Number of published samples.
        samples: u32,
    },
}

/// What a service asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Order {
    /// A service without arguments.
    Trigger(Trigger),
    /// An output.
    SetIo(SetIoRequest),
    /// The speed slider, 0 to 1.
    SetSpeedSlider(f64),
    /// What hangs on the flange.
    SetPayload(SetPayloadRequest),
}

macro_rules! triggers {
    ($($(#[$doc:meta])* $name:ident = $node:ident / $service:literal,)+) => {
        /// Services without arguments.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Trigger { $($(#[$doc])* $name,)+ }

        impl Trigger {
            /// Every trigger, in the order of the declaration.
            pub const ALL: &[Self] = &[$(Self::$name,)+];

            /// The name of the service, below the namespace.
            pub fn service(self) -> (&'static str, &'static str) {
                match self { $(Self::$name => (crate::names::$node, $service),)+ }
            }
        }
    };
}

triggers! {
    /// Power for the arm.
    PowerOn = DASHBOARD / "power_on",
    /// No power for the arm.
    PowerOff = DASHBOARD / "power_off",
    /// The brakes.
    BrakeRelease = DASHBOARD / "brake_release",
    /// Out of a protective stop.
    UnlockProtectiveStop = DASHBOARD / "unlock_protective_stop",
    /// Starts the loaded task, or goes on.
    Play = DASHBOARD / "play",
    /// Holds the task, or the goal.
    Pause = DASHBOARD / "pause",
    /// Ends the task, or the goal.
    Stop = DASHBOARD / "stop",
    /// Nothing is ever open.
    CloseSafetyDialog = DASHBOARD / "close_safety_dialog",
    /// Out of a safety fault.
    RestartSafety = DASHBOARD / "restart_safety",
    /// The task that is loaded.
    TaskPath = DASHBOARD / "get_task_path",
    /// What the force sensor reads counts as nothing.
    ZeroFtSensor = IO_AND_STATUS / "zero_ftsensor",
}

/// What is wrong with a frame.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum LinkError {
    /// A frame longer than any can be.
    #[error("a frame of {bytes} bytes, {FRAME_MAX} at most are allowed")]
    #[zh("帧有 {bytes} 字节，最多允许 {FRAME_MAX} 字节")]
    TooLong {
        /// Length of the frame.
        bytes: usize,
    },
    /// A frame that is no value.
    #[error("a frame that cannot be read: {0}")]
    #[zh("帧无法读取：{0}")]
    Malformed(#[from] cdr_encoding::Error),
    /// Another program.
    #[error("the other end speaks version {theirs} of the protocol, this one {VERSION}")]
    #[zh("对方使用协议版本 {theirs}，本方为 {VERSION}")]
    Version {
        /// The version of the other end.
        theirs: u32,
    },
}

/// A frame with `value`.
///
/// # Errors
/// [`LinkError::TooLong`] for more than [`FRAME_MAX`] bytes; [`LinkError::Malformed`] for a value without an encoding.
pub fn frame<T: Serialize>(value: &T) -> Result<Vec<u8>, LinkError> {
    let body = cdr_encoding::to_vec::<T, byteorder::LittleEndian>(value)?;
    if body.len() > FRAME_MAX {
        return Err(LinkError::TooLong { bytes: body.len() });
    }
    let mut bytes = Vec::with_capacity(body.len() + 4);
    // At most FRAME_MAX.
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend(body);
    Ok(bytes)
}

/// The length of the frame that begins with `head`.
///
/// # Errors
/// [`LinkError::TooLong`] for more than [`FRAME_MAX`] bytes.
pub fn body_length(head: [u8; 4]) -> Result<usize, LinkError> {
    let bytes = u32::from_le_bytes(head) as usize;
    match bytes <= FRAME_MAX {
        true => Ok(bytes),
        false => Err(LinkError::TooLong { bytes }),
    }
}

/// The value of a frame's body.
///
/// # Errors
/// The bytes are none.
pub fn value<T: DeserializeOwned>(body: &[u8]) -> Result<T, LinkError> {
    Ok(cdr_encoding::from_bytes::<T, byteorder::LittleEndian>(body)?.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    fn roundtrip(value_sent: &NodeMessage) -> NodeMessage {
        let bytes = frame(value_sent).unwrap();
        let head = [bytes[0], bytes[1], bytes[2], bytes[3]];
        assert_eq!(body_length(head).unwrap(), bytes.len() - 4);
        value(&bytes[4..]).unwrap()
    }

    #[test]
    fn what_one_end_says_the_other_reads() {
        let goal = NodeMessage::Goal {
            id: [7; 16],
            goal: TrajectoryGoal::default(),
        };
        assert_eq!(roundtrip(&goal), goal);
        for trigger in Trigger::ALL {
            let request = NodeMessage::Request {
                request: 9,
                order: Order::Trigger(*trigger),
            };
            assert_eq!(roundtrip(&request), request);
        }
    }

    #[test]
    fn a_frame_that_claims_too_much_is_refused_before_anything_is_allocated() {
        let error = body_length(u32::MAX.to_le_bytes()).unwrap_err();
        assert!(error.to_string().contains("8388608 at most"), "{error}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, rng_seed: RngSeed::Fixed(48), ..ProptestConfig::default() })]
        #[test]
        fn any_bytes_are_a_value_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            let _ = value::<NodeMessage>(&bytes);
            let _ = value::<ControllerMessage>(&bytes);
        }
    }
}
