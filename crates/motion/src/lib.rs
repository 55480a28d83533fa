//! The control cycle: generators, limits, safety and the simulated arm.
//!
//! [`Cycle::tick`] is one control period and an ordinary function. Who calls it decides what time is: the motion thread
//! of [`realtime`] on absolute deadlines, or [`virtual_time`] on the thread of whoever waits for time to pass. Commands
//! come in and events, records and snapshots go out through `motion-api`; nothing here knows a script or a socket.

pub mod brake;
pub mod config;
pub mod constants;
mod cycle;
mod intake;
pub mod machine;
mod motion;
mod outbox;
pub mod path;
pub mod plan;
pub mod plant;
pub mod realtime;
mod report;
pub mod scalar;
pub mod setpoint;
pub mod virtual_time;
mod waiting;

pub use config::{ConfigError, CycleConfig, LimitOverrides, MotionLimits, PlantKind};
pub use cycle::{Cycle, Timing};
pub use motion::Plan;
