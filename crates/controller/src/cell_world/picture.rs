//! The world as somebody sees it who gets the messages of `/world` one by one: page, viewers, the time line of a
//! recording.
//!
//! Owns what is drawn at a moment. How it is drawn is the business of whoever draws.

use std::collections::BTreeMap;

use kinematics::{Pose, RpyPose};
use world::WorldDescription;

use super::topic::{GripperRow, PartRow, WorldMessage};

/// The picture.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldPicture {
    templates: Vec<String>,
    gripper_names: Vec<String>,
    /// Parts that are there, by name.
    pub parts: BTreeMap<String, PartPicture>,
    /// Poses of obstacles that actuators move, by name, base frame.
    pub obstacles: BTreeMap<String, Pose>,
    /// Parts that each sink has removed, in the order of the cell file, as are all that follow.
    pub counts: Vec<u64>,
    /// Whether each detector sees something.
    pub detectors: Vec<bool>,
    /// Cups and fingers.
    pub grippers: Vec<GripperRow>,
    /// Speeds of the conveyors, m/s or rad/s.
    pub conveyors: Vec<f64>,
}

/// A part in the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PartPicture {
    /// Number of the part's table.
    pub template: usize,
    /// Number of the gripper that holds it.
    pub held_by: Option<usize>,
    /// In the frame of the flange while a gripper holds it, else in the base frame: so it moves with the arm that is
    /// drawn.
    pub pose: Pose,
}

impl WorldPicture {
    /// Before the first message of the world of a description.
    pub fn new(description: &WorldDescription) -> Self {
        let grippers = description.grippers.iter();
        Self {
            templates: description
                .parts
                .iter()
                .map(|part| part.name.clone())
                .collect(),
            gripper_names: grippers.map(|gripper| gripper.name.clone()).collect(),
            parts: BTreeMap::new(),
            obstacles: BTreeMap::new(),
            counts: vec![0; description.sinks.len()],
            detectors: vec![false; description.detectors.len()],
            grippers: description
                .grippers
                .iter()
                .map(|gripper| GripperRow {
                    name: gripper.name.clone(),
                    sealed: Vec::new(),
                    width: 0.0,
                })
                .collect(),
            conveyors: vec![0.0; description.conveyors.len()],
        }
    }

    /// The picture after a message; the flange is where it was in the message's cycle.
    pub fn apply(&mut self, message: &WorldMessage, base_from_flange: &Pose) {
        for name in &message.removed {
            self.parts.remove(name);
        }
        for row in &message.parts {
            if let Some(part) = self.part(row, base_from_flange) {
                self.parts.insert(row.name.clone(), part);
            }
        }
        for row in &message.obstacles {
            self.obstacles.insert(
                row.name.clone(),
                Pose::from_rpy(&RpyPose::from_array(row.pose)),
            );
        }
        // A message of another cell file changes nothing that this one does not have.
        replace(&mut self.counts, &message.counts);
        replace(&mut self.detectors, &message.detectors);
        replace(&mut self.conveyors, &message.conveyors);
        for row in &message.grippers {
            if let Some(gripper) = self.grippers.iter_mut().find(|one| one.name == row.name) {
                gripper.clone_from(row);
            }
        }
    }

    fn part(&self, row: &PartRow, base_from_flange: &Pose) -> Option<PartPicture> {
        let table = row.name.split(['[', '#']).next().unwrap_or_default();
        let holder = row.held_by.as_ref();
        let held_by =
            holder.and_then(|holder| self.gripper_names.iter().position(|name| name == holder));
        let base_from_part = Pose::from_rpy(&RpyPose::from_array(row.pose));
        Some(PartPicture {
            template: self.templates.iter().position(|name| name == table)?,
            held_by,
            pose: match held_by {
                Some(_) => base_from_flange.inverse() * base_from_part,
                None => base_from_part,
            },
        })
    }

    /// Name of the part that a gripper holds.
    pub fn held_by(&self, gripper: usize) -> Option<&str> {
        let mut parts = self.parts.iter();
        let held = parts.find(|(_, part)| part.held_by == Some(gripper));
        held.map(|(name, _)| name.as_str())
    }
}

/// News in place of what was; an empty message is no news.
fn replace<T: Clone>(old: &mut [T], news: &[T]) {
    if news.len() == old.len() {
        old.clone_from_slice(news);
    }
}
