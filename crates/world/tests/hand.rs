//! A flange that the tests move by hand, above a floor.

use crate::cells::*;
use kinematics::Pose;
use motion_api::IoPoint;
use motion_api::{PointLevels, WorldInput};
use world::{World, WorldDescription};

/// WorldOutput that closes or sucks.
pub const ON: IoPoint = IoPoint::Digital(0);

/// A world and the flange in it.
pub struct Hand {
    pub world: World,
    pub flange: Pose,
    pub outputs: PointLevels,
}

impl Hand {
    /// The flange looks down from this place.
    pub fn above(cell: &WorldDescription, x: f64, y: f64, z: f64) -> Self {
        let flange = pose([x, y, z, core::f64::consts::PI, 0.0, 0.0]);
        let mut hand = Self {
            world: build(cell),
            flange,
            outputs: PointLevels::default(),
        };
        hand.wait(0.1);
        hand
    }

    fn step(&mut self) {
        let input = WorldInput {
            base_from_flange: self.flange,
            outputs: self.outputs,
            ..far_away()
        };
        self.world.step(&input);
    }

    pub fn wait(&mut self, seconds: f64) {
        for _ in 0..(seconds / 0.004).round() as usize {
            self.step();
        }
    }

    pub fn set(&mut self, point: IoPoint, level: bool) {
        self.outputs.set_level(point, level);
    }

    /// Moves by (x, y, z) in the base frame on a quintic; the largest acceleration is 5.7735 times way over time
    /// squared.
    pub fn shift(&mut self, way: [f64; 3], seconds: f64) {
        let start = self.flange;
        self.along(seconds, |s| {
            Pose::new(
                start.rotation,
                start.translation + nalgebra::Vector3::from(way) * s,
            )
        });
    }

    /// Turns about an axis of the base through the flange by an angle.
    pub fn turn(&mut self, axis: [f64; 3], angle: f64, seconds: f64) {
        let start = self.flange;
        self.along(seconds, |s| {
            let turn = nalgebra::Rotation3::new(nalgebra::Vector3::from(axis) * (angle * s));
            Pose::new(turn * start.rotation, start.translation)
        });
    }

    fn along(&mut self, seconds: f64, place: impl Fn(f64) -> Pose) {
        let cycles = (seconds / 0.004).round() as usize;
        for cycle in 1..=cycles {
            let t = cycle as f64 / cycles as f64;
            self.flange = place(t * t * t * (10.0 + t * (6.0 * t - 15.0)));
            self.step();
        }
    }

    /// Name of the part in the first gripper.
    pub fn holding(&self) -> Option<String> {
        self.world.state().grippers[0]
            .holding
            .as_deref()
            .map(str::to_owned)
    }

    /// Where the part of this number is.
    pub fn part(&self, number: usize) -> nalgebra::Vector3<f64> {
        self.world.state().parts[number].pose.translation
    }
}
