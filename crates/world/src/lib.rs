//! What surrounds the arm: parts that fall and stack, grippers, conveyors, sources, sinks, detectors, actuators,
//! faults.
//!
//! Owns the rigid bodies (rapier, with the same bits on every machine) and the laws of grippers. Knows no script, no
//! port and no file: the cell is a [`WorldDescription`] in SI units, and one call moves it by one control cycle. In
//! goes the arm at the end of the cycle with all outputs ([`WorldInput`](motion_api::WorldInput)); out comes what the
//! next cycle has to know ([`WorldOutput`](motion_api::WorldOutput)): inputs, wrenches, and what hangs on the flange.
//! Both are `Copy` and of fixed size. The step itself allocates, so it runs beside the control loop and not in it.
//!
//! ```
//! use kinematics::{Pose, RpyPose};
//! use motion_api::{IoPoint, WorldInput};
//! use world::description::*;
//! use world::{World, WorldDescription};
//!
//! // A floor, a box of 125 g, and one suction cup 0.1 m below a flange that looks down.
//! let valve = IoPoint::Digital(0);
//! let mut cell = WorldDescription::default();
//! cell.settings.floor = Some(0.0);
//! cell.parts.push(PartDescription {
//!     name: "box".into(),
//!     shape: BodyShape::Box { size: [0.05; 3] },
//!     mass: Mass::Total(0.125),
//!     pose: Pose::from_translation(0.0, 0.0, 0.025),
//!     friction: 0.5,
//!     restitution: 0.0,
//!     copies: None,
//! });
//! cell.grippers.push(Gripper {
//!     name: "cup".into(),
//!     kind: GripperKind::Vacuum(Vacuum {
//!         cups: vec![[0.0, 0.0, 0.1]],
//!         direction: [0.0, 0.0, 1.0],
//!         radius: 0.015,
//!         pressure: 60000.0,
//!         reach: 0.003,
//!         build_up: 0.1,
//!         decay: 0.05,
//!         on: valve,
//!         blow_off: None,
//!         switch: None,
//!         threshold: 0.7,
//!         gauge: None,
//!     }),
//! });
//! let mut world = World::new(&cell)?;
//!
//! // The flange stands above the box until there is a vacuum, and goes up by 0.1 m in half a second.
//! let flange = |z| Pose::from_rpy(&RpyPose { xyz: [0.0, 0.0, z], rpy: [core::f64::consts::PI, 0.0, 0.0] });
//! let mut input = WorldInput::default();
//! input.base_from_joint = [Pose::from_translation(5.0, 0.0, 0.0); 6];
//! for cycle in 0..375 {
//!     input.outputs.set_level(valve, cycle >= 50);
//!     let t = (f64::from(cycle) - 250.0).max(0.0) / 125.0;
//!     input.base_from_flange = flange(0.151 + 0.1 * t * t * (3.0 - 2.0 * t));
//!     world.step(&input);
//! }
//! assert!((world.output().held_body.mass - 0.125).abs() < 1e-12);
//! let part = world.part("box").unwrap().unwrap();
//! assert_eq!(part.held_by, Some(0));
//! assert!((part.pose.translation.z - 0.125).abs() < 1e-3);
//! # Ok::<(), world::WorldError>(())
//! ```
//!
//! - [`World::state`] is the one picture for recording, page, tests and conditions.
//! - [`World::place`], [`World::add`], [`World::remove`], [`World::fail`] and [`World::order_fingers`] act between two
//!   steps.
//! - A clone of a [`World`] is a snapshot: it goes on exactly as the original does.
//! - A part of the arm's contact code moves to the world with an actuator: obstacles that one moves push the arm
//!   through
//!   [`link_wrenches`](motion_api::WorldOutput::link_wrenches) and
//!   [`tool_wrench`](motion_api::WorldOutput::tool_wrench), and must not be in the scene of the arm's own contacts.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod actuator;
mod arm;
mod calm;
mod check;
mod check_entry;
mod conveyor;
mod cup_sharing;
pub mod description;
mod detector;
mod edges;
mod engine;
mod error;
mod fault;
mod fingers;
mod gripper;
mod hold;
mod machine_fault;
mod materials;
mod orders;
mod overlap;
mod part_faults;
mod parts;
mod scatter;
mod source;
mod state;
mod vacuum;
mod world;

pub use check::{FLOOR, MAX_ENTRIES, MAX_PARTS, check};
pub use description::WorldDescription;
pub use error::{OrderError, WorldError};
pub use fingers::FingerOrder;
pub use state::*;
pub use world::World;
