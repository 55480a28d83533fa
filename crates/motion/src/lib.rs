//! The control cycle: generators, limits, safety and the simulated arm.
//!
//! [`ControlLoop::tick`] is one control period and an ordinary function. Who calls it decides what time is: the motion
//! thread of [`realtime`] on absolute deadlines, or [`virtual_time`] on the thread of whoever waits for time to pass.
//! Commands come in and events, records and snapshots go out through `motion-api`; nothing here knows a script or a
//! socket.
//!
//! ```
//! use kinematics::{JointPositions, RobotModel};
//! use motion::{ControlLoop, CycleConfig, CycleTiming};
//! use motion_api::{RingCapacities, CommandKind, MotionCommand, Origin, motion_channel};
//!
//! let config = CycleConfig::new(RobotModel::built_in("cs66")?);
//! let (motion_end, mut script_end) = motion_channel(RingCapacities::default(), &config.first_state());
//! let mut cycle = ControlLoop::new(config, motion_end)?;
//!
//! let target = JointPositions([0.2, -1.5, 1.6, -1.6, -1.5, 0.0]);
//! let movej = CommandKind::Motion(MotionCommand::MoveJ { target, acceleration: 1.4, speed: 1.0, duration: 0.0, radius:
//! 0.0 }); script_end.commands.send(Origin::default(), movej)?;
//! let ended = loop {
//!     cycle.tick(CycleTiming::default());
//!     if let Some(event) = script_end.events.next_event() {
//!         break event;
//!     }
//! };
//! let state = script_end.snapshot.read();
//! assert_eq!(state.target_q, target);
//! println!("{ended:?} after {} s", state.time);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

mod allowed;
mod belt;
pub mod brake;
pub mod collision;
mod commanded;
pub mod config;
mod config_error;
pub mod constants;
pub mod contact;
mod cycle;
mod ending;
pub mod external;
mod force_mode;
pub mod histogram;
mod hold;
mod intake;
pub mod io;
mod laid_over;
mod limits_in_force;
mod load_model;
pub mod machine;
mod micro_points;
pub mod modes;
mod online;
mod outbox;
pub mod path;
mod path_offsets;
pub mod plan;
mod planes;
pub mod plant;
mod queue;
pub mod realtime;
pub mod rehearsal;
mod report;
pub mod safety_inputs;
pub mod scalar;
pub mod self_collision;
mod senses;
mod sensor;
pub mod setpoint;
mod stopping;
mod surroundings;
pub mod thermal;
mod tool;
mod upcoming;
pub mod virtual_time;
mod waiting;
mod zone_changes;

pub use config::{ConfigError, CycleConfig, LimitOverrides, MotionLimits, PlantKind};
pub use cycle::{ControlLoop, CycleTiming};
pub use io::{IoSetup, TimedInput, WireSetup};
pub use plant::{Drivetrain, PlantParameters};
pub use safety_inputs::{InputPair, SafetyInputs};
pub use sensor::SensorNoise;
pub use surroundings::WorldSetup;
