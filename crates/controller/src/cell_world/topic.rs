//! The topic `/world` of a recording: parts that moved, machines that changed, as JSON, and back.
//!
//! Message k is the state after the world's step of cycle k. Only what differs from the message before is in it; the
//! first one (cycle 0) has everything. Numbers come back bit for bit.

use kinematics::Pose;
use messages::Text;
use recorder::{CustomTopic, CustomTopicId, ReadError, RecorderHandle, Recording};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeSet;
use std::sync::Arc;
use world::{ConveyorState, DetectorState, GripperState, PartState};
use world::{WorldDescription, WorldState};

use super::orders::WorldOrder;

/// Name of the topic.
pub const TOPIC: &str = "/world";
/// The second extra topic of a recording of ours.
pub(crate) const NUMBER: CustomTopicId = CustomTopicId(1);

/// One message.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldMessage {
    /// Number of the control cycle.
    pub cycle: u64,
    /// Parts that moved, or that another gripper holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartRow>,
    /// Parts that are not there any more.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<String>,
    /// Removed parts that fell far below the cell, where there is no floor.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lost: Vec<String>,
    /// Numbers of parts that the sinks have removed, in the order of the cell file; where one has changed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub counts: Vec<u64>,
    /// Poses of obstacles, by name, that an actuator has moved; the first message has all that one moves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<ObstacleRow>,
    /// Whether each detector sees something, in the order of the cell file; where one has changed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub detectors: Vec<bool>,
    /// Grippers whose cups or fingers have changed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grippers: Vec<GripperRow>,
    /// Speed of each conveyor, m/s or rad/s, in the order of the cell file; where one has changed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub conveyors: Vec<f64>,
    /// What the world was told from outside after this cycle.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub orders: Vec<WorldOrder>,
    /// Number of the cycle whose result this cycle had, where that is not the one before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen: Option<u64>,
    /// How many of the cycles just before this one the world did not move by: it was too far behind.
    #[serde(default, skip_serializing_if = "is_default")]
    pub missed: u64,
}

impl WorldMessage {
    /// Whether it says nothing of the state.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
            && self.removed.is_empty()
            && self.lost.is_empty()
            && self.counts.is_empty()
            && self.obstacles.is_empty()
            && self.detectors.is_empty()
            && self.grippers.is_empty()
            && self.conveyors.is_empty()
    }
}

/// Whether a value is what a message without it has.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A part in a cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartRow {
    /// Name.
    pub name: String,
    /// x, y, z, Rx, Ry, Rz in the base frame, m and rad.
    pub pose: [f64; 6],
    /// Speed of its centre, m/s.
    #[serde(default, skip_serializing_if = "is_default")]
    pub speed: f64,
    /// Whether it touches the floor.
    #[serde(default, skip_serializing_if = "is_default")]
    pub on_floor: bool,
    /// Name of the gripper that holds it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_by: Option<String>,
}

/// An obstacle that an actuator moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObstacleRow {
    /// Name.
    pub name: String,
    /// x, y, z, Rx, Ry, Rz in the base frame, m and rad.
    pub pose: [f64; 6],
}

/// Cups or fingers in a cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GripperRow {
    /// Name.
    pub name: String,
    /// By cup: it seals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sealed: Vec<bool>,
    /// Opening between the fingers, m.
    #[serde(default, skip_serializing_if = "is_default")]
    pub width: f64,
}

/// The topic, for a recording that is begun.
pub(crate) fn topic() -> CustomTopic {
    let integer = json!({"type": "integer", "minimum": 0});
    let pose = json!({"type": "array", "items": {"type": "number"}});
    let row = json!({
        "type": "object",
        "properties": {
            "name": {"type": "string"},
            "pose": pose,
            "speed": {"type": "number"},
            "on_floor": {"type": "boolean"},
            "held_by": {"type": "string"},
        },
        "required": ["name", "pose"],
    });
    let gripper = json!({
        "type": "object",
        "properties": {
            "name": {"type": "string"},
            "sealed": {"type": "array", "items": {"type": "boolean"}},
            "width": {"type": "number"},
        },
        "required": ["name"],
    });
    CustomTopic {
        name: TOPIC.to_owned(),
        schema_name: "elite.World".to_owned(),
        schema: json!({
            "type": "object",
            "properties": {
                "cycle": integer,
                "parts": {"type": "array", "items": row},
                "removed": {"type": "array", "items": {"type": "string"}},
                "lost": {"type": "array", "items": {"type": "string"}},
                "counts": {"type": "array", "items": integer},
                "obstacles": {"type": "array", "items": row},
                "detectors": {"type": "array", "items": {"type": "boolean"}},
                "grippers": {"type": "array", "items": gripper},
                "conveyors": {"type": "array", "items": {"type": "number"}},
                "orders": {"type": "array", "items": {"type": "object"}},
                "seen": integer,
                "missed": integer,
            },
            "required": ["cycle"],
        })
        .to_string(),
    }
}

/// Finds what differs from one state to the next.
#[derive(Clone, Debug, Default)]
pub struct WorldChanges {
    grippers: Vec<String>,
    obstacles: Vec<String>,
    /// Obstacles that an actuator moves.
    driven: BTreeSet<String>,
    before: Option<WorldState>,
    /// States have come and gone that nobody asked about.
    is_behind: bool,
}

impl WorldChanges {
    /// For the world of a description.
    pub fn new(description: &WorldDescription) -> Self {
        Self {
            grippers: description
                .grippers
                .iter()
                .map(|gripper| gripper.name.clone())
                .collect(),
            obstacles: description
                .obstacles
                .iter()
                .map(|obstacle| obstacle.name.clone())
                .collect(),
            driven: {
                let actuators = description.actuators.iter();
                actuators
                    .flat_map(|actuator| actuator.moves.iter().cloned())
                    .collect()
            },
            before: None,
            is_behind: false,
        }
    }

    /// A state that nobody wants to know of.
    pub(crate) const fn skip(&mut self) {
        self.is_behind = true;
    }

    /// Goes on from a state that is known as a whole, if others have been skipped.
    pub(crate) fn catch_up(&mut self, state: &WorldState) {
        if self.is_behind {
            self.is_behind = false;
            self.note(state);
        }
    }

    /// What is new in the state after a cycle; `None` when nothing is.
    pub fn next(&mut self, cycle: u64, state: &WorldState) -> Option<WorldMessage> {
        let before = self.before.as_ref();
        let mut message = WorldMessage {
            cycle,
            ..WorldMessage::default()
        };
        let known = before.map_or(&[][..], |before| &before.parts);
        for (index, part) in state.parts.iter().enumerate() {
            // Parts stand in the order of making, so an old one is at its place or, where others were removed, behind
            // it.
            let at_its_place = known
                .get(index)
                .filter(|old| Arc::ptr_eq(&old.name, &part.name));
            let old = at_its_place.or_else(|| known.iter().find(|old| old.name == part.name));
            if !old.is_some_and(|old| is_same(old, part)) {
                message.parts.push(PartRow {
                    name: part.name.to_string(),
                    pose: numbers(&part.pose),
                    speed: part.velocity.linear.norm(),
                    on_floor: part.touches_floor,
                    held_by: part
                        .held_by
                        .and_then(|number| self.grippers.get(number).cloned()),
                });
            }
        }
        if known.len() + message.parts.len() > state.parts.len() || before.is_none() {
            let is_gone = |name: &str| !state.parts.iter().any(|part| &*part.name == name);
            let gone = known.iter().filter(|old| is_gone(&old.name));
            message.removed = gone.map(|old| old.name.to_string()).collect();
        }
        let old_lost = before.map_or(0, |before| before.lost_below.len());
        let lost = state.lost_below.iter().skip(old_lost);
        message.lost = lost.map(|name| name.to_string()).collect();
        if before.is_none_or(|before| before.sinks != state.sinks) {
            message.counts.clone_from(&state.sinks);
        }
        let old_obstacles = before.map_or(&[][..], |before| &before.obstacles);
        for (number, pose) in state.obstacles.iter().enumerate() {
            if let Some(name) = self.obstacles.get(number)
                && old_obstacles.get(number) != Some(pose)
                && (before.is_some() || self.driven.contains(name))
            {
                message.obstacles.push(ObstacleRow {
                    name: name.clone(),
                    pose: numbers(pose),
                });
            }
        }
        self.add_devices(&mut message, state);
        let is_first = before.is_none();
        if message.is_empty() && !is_first {
            return None;
        }
        self.note(state);
        Some(message)
    }

    fn note(&mut self, state: &WorldState) {
        match &mut self.before {
            Some(before) => copy(before, state),
            before @ None => *before = Some(state.clone()),
        }
    }

    /// Detectors, grippers and conveyors that are otherwise than before.
    fn add_devices(&self, message: &mut WorldMessage, state: &WorldState) {
        let before = self.before.as_ref();
        let old = before.map_or(&[][..], |before| &before.detectors);
        let sees = |states: &[DetectorState]| -> Vec<bool> {
            states.iter().map(|detector| detector.sees).collect()
        };
        let seen = sees(&state.detectors);
        if seen != sees(old) {
            message.detectors = seen;
        }
        let old = before.map_or(&[][..], |before| &before.grippers);
        for (number, (gripper, name)) in state.grippers.iter().zip(&self.grippers).enumerate() {
            let is_same = |old: &GripperState| {
                old.sealed == gripper.sealed && old.width.to_bits() == gripper.width.to_bits()
            };
            if !old.get(number).is_some_and(is_same) {
                message.grippers.push(GripperRow {
                    name: name.clone(),
                    sealed: gripper.sealed.clone(),
                    width: gripper.width,
                });
            }
        }
        let old = before.map_or(&[][..], |before| &before.conveyors);
        let speeds = |states: &[ConveyorState]| -> Vec<f64> {
            states.iter().map(|conveyor| conveyor.speed).collect()
        };
        let speed = speeds(&state.conveyors);
        if speed != speeds(old) {
            message.conveyors = speed;
        }
    }
}

/// Whether a part is as it was. Asked for each part in each cycle; slices are compared in a fraction of the time of
/// matrices.
fn is_same(old: &PartState, new: &PartState) -> bool {
    let same = |old: &[f64], new: &[f64]| old == new;
    old.held_by == new.held_by
        && old.touches_floor == new.touches_floor
        && old.template == new.template
        && same(
            old.pose.translation.as_slice(),
            new.pose.translation.as_slice(),
        )
        && same(
            old.velocity.linear.as_slice(),
            new.velocity.linear.as_slice(),
        )
        && same(
            old.velocity.angular.as_slice(),
            new.velocity.angular.as_slice(),
        )
        && same(
            old.pose.rotation.matrix().as_slice(),
            new.pose.rotation.matrix().as_slice(),
        )
}

/// Makes `before` the same as `state`, in the memory that it has.
fn copy(before: &mut WorldState, state: &WorldState) {
    let WorldState {
        cycle,
        parts,
        grippers,
        conveyors,
        sources,
        sinks,
        detectors,
        actuators,
        obstacles,
        lost_below,
    } = state;
    before.cycle = *cycle;
    before.parts.clone_from(parts);
    before.grippers.clone_from(grippers);
    before.conveyors.clone_from(conveyors);
    before.sources.clone_from(sources);
    before.sinks.clone_from(sinks);
    before.detectors.clone_from(detectors);
    before.actuators.clone_from(actuators);
    before.obstacles.clone_from(obstacles);
    before.lost_below.clone_from(lost_below);
}

fn numbers(pose: &Pose) -> [f64; 6] {
    pose.to_rpy().to_array()
}

/// Gives a message to a recording.
pub(crate) fn write(recording: &RecorderHandle, message: &WorldMessage, period: f64) {
    // Only maps with keys that are no texts fail, and there are none.
    if let Ok(bytes) = serde_json::to_vec(message) {
        recording.extra(message.cycle as f64 * period, NUMBER, bytes);
    }
}

/// Reads a message back.
///
/// # Errors
/// What is wrong with it, in words.
pub fn read(bytes: &[u8]) -> Result<WorldMessage, Text> {
    serde_json::from_slice(bytes).map_err(|error| Text::of_library(&error))
}

/// The messages of a recording, in the order of cycles.
///
/// # Errors
/// The recording cannot be read. A message that cannot be read comes as its error.
pub fn messages(
    recording: &Recording,
) -> Result<impl Iterator<Item = Result<WorldMessage, ReadError>>, ReadError> {
    let messages = recording.messages()?;
    let of_topic = messages.filter(|message| message.channel.topic == TOPIC);
    Ok((1..).zip(of_topic).map(|(number, message)| {
        read(&message.data).map_err(|reason| ReadError::Message {
            topic: TOPIC.to_owned(),
            number,
            reason,
        })
    }))
}
