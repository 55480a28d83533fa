//! Cells that the tests build.

use kinematics::{Pose, RpyPose};
use motion_api::WorldInput;
use world::description::*;
use world::{World, WorldDescription};

/// A pose as scripts write it.
pub fn pose(p: [f64; 6]) -> Pose {
    Pose::from_rpy(&RpyPose {
        xyz: [p[0], p[1], p[2]],
        rpy: [p[3], p[4], p[5]],
    })
}

/// A cell with a floor at height 0 and nothing else.
pub fn empty() -> WorldDescription {
    WorldDescription {
        settings: Settings {
            floor: Some(0.0),
            ..Settings::default()
        },
        ..WorldDescription::default()
    }
}

/// A cube of 50 mm and 125 g.
pub fn cube(name: &str, p: [f64; 6]) -> PartDescription {
    PartDescription {
        name: name.into(),
        shape: BodyShape::Box { size: [0.05; 3] },
        mass: Mass::Density(1000.0),
        pose: pose(p),
        friction: 0.5,
        restitution: 0.0,
        copies: None,
    }
}

/// An obstacle of friction 0.5.
pub fn obstacle(name: &str, size: [f64; 3], p: [f64; 6]) -> ObstacleDescription {
    ObstacleDescription {
        name: name.into(),
        shape: BodyShape::Box { size },
        pose: pose(p),
        friction: 0.5,
    }
}

/// An arm far away from everything.
pub fn far_away() -> WorldInput {
    WorldInput {
        base_from_joint: [Pose::from_translation(0.0, 0.0, 50.0); 6],
        base_from_flange: Pose::from_translation(0.0, 0.0, 50.0),
        ..WorldInput::default()
    }
}

/// Steps with an arm far away.
pub fn idle(world: &mut World, cycles: usize) {
    for _ in 0..cycles {
        world.step(&far_away());
    }
}

/// The world of a cell that is possible.
pub fn build(cell: &WorldDescription) -> World {
    World::new(cell).unwrap_or_else(|e| panic!("{e}"))
}
