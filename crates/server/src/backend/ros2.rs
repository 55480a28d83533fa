//! What the ROS 2 node asks of the controller, and the plan of the node.

use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use controller::options::{ClockChoice, ModelChoice};
use elite_runtime::Robot;
use kinematics::RobotModel;
use motion_api::CommandKind;
use ros2::link::{NodeSetup, VERSION};
use ros2::sample::flange_in_wrist;
use tokio::sync::broadcast;

use super::PortBackend;
use crate::cli::RosMiddleware;
use crate::config::{Ros2Config, ServeConfig};
use crate::ports::ros2::{NodePlan, Ros2Backend};
use crate::ports::sample::Sample;

/// Most memory of the node's process, bytes.
const NODE_MEMORY_MAX: u64 = 512 << 20;

/// Readings of the clock for the epoch of the stamps: of two cycles and a half.
const READINGS: u32 = 40;
/// Readings of the clock in a cycle.
const READINGS_OF_A_CYCLE: f64 = 16.0;

impl Ros2Backend for PortBackend {
    fn samples(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.feed.subscribe()
    }

    fn robot(&self) -> &Robot {
        &self.robot
    }

    async fn command(&self, command: CommandKind) {
        self.send_and_wait_taken(command).await;
    }
}

impl PortBackend {
    /// The plan of a node.
    ///
    /// # Errors
    /// No interface leads to a peer, or the description of the arm cannot be read.
    pub fn node_plan(&self, config: &ServeConfig, ros2: &Ros2Config) -> std::io::Result<NodePlan> {
        let robot = &config.robot;
        let model = self.robot.model();
        let urdf = match &robot.model {
            ModelChoice::BuiltIn(name) => RobotModel::built_in_urdf(name)
                .unwrap_or_default()
                .to_owned(),
            ModelChoice::Urdf(path) => kinematics::text_file::read_text_file(path)?,
        };
        let is_virtual = robot.clock == ClockChoice::Virtual;
        let networks = ros2.interfaces()?;
        let setup = NodeSetup {
            version: VERSION,
            domain: ros2.domain,
            namespace: ros2.namespace.clone(),
            prefix: ros2.prefix.clone(),
            networks: networks.iter().map(ToString::to_string).collect(),
            loopback_only: ros2.is_loopback_only(),
            cyclone: ros2.middleware == RosMiddleware::Cyclonedds,
            simulated_time: is_virtual,
            urdf: prefixed(&urdf, &ros2.prefix),
            flange_in_wrist: flange_in_wrist(model),
            model: robot.model.to_string(),
            step_ms: 1e3 * robot.step.as_secs(),
            memory_max: NODE_MEMORY_MAX,
        };
        let epoch = match is_virtual {
            true => 0,
            false => {
                let pause = robot.step.as_secs() / READINGS_OF_A_CYCLE;
                epoch((0..READINGS).map(|_| {
                    std::thread::sleep(Duration::from_secs_f64(pause));
                    let time = self.robot.moment().time;
                    (unix_nanos(), time)
                }))
            }
        };
        Ok(NodePlan {
            setup,
            rate: ros2.rate,
            epoch,
            time_factor: ros2.time_factor,
        })
    }
}

/// The description with `prefix` before the names of its links and joints.
fn prefixed(urdf: &str, prefix: &str) -> String {
    if prefix.is_empty() {
        return urdf.to_owned();
    }
    [
        "<link name=\"",
        "<joint name=\"",
        "<parent link=\"",
        "<child link=\"",
    ]
    .iter()
    .fold(urdf.to_owned(), |text, begin| {
        text.replace(begin, &format!("{begin}{prefix}"))
    })
}

/// What is added to the time of a cycle, ns, by pairs of UNIX time, ns, and the time of the latest cycle, s. The latest
/// cycle is up to a cycle old, more where the motion thread was late, and no stamp may lie in the future: the pair
/// right after a cycle counts.
fn epoch(readings: impl Iterator<Item = (i64, f64)>) -> i64 {
    let offsets = readings.map(|(unix, time)| unix - (time * 1e9).round() as i64);
    offsets.min().unwrap_or_else(unix_nanos)
}

fn unix_nanos() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |d| i64::try_from(d.as_nanos()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_begin_right_after_a_cycle_and_not_in_the_future() {
        // Cycles of 4 ms end at whole ones, seen 0.1 ms later, and one of them is 3 ms late.
        let begun = 1_800_000_000_000_000_000;
        let reading = |quarter_ms: i64| {
            let nanos = 250_000 * quarter_ms + 100_000;
            let cycle = match nanos / 4_000_000 {
                2 if nanos % 4_000_000 < 3_000_000 => 1,
                cycle => cycle,
            };
            (begun + nanos, 0.004 * cycle as f64)
        };
        for first in 0..16 {
            let offset = epoch((first..first + 40).map(reading)) - begun;
            assert!((0..=350_000).contains(&offset), "{first}: {offset}");
        }
    }

    #[test]
    fn a_prefix_is_before_every_link_and_joint() {
        let urdf = RobotModel::built_in_urdf("cs66").unwrap();
        let text = prefixed(urdf, "left_");
        assert!(text.contains("<link name=\"left_base_link\""));
        assert!(text.contains("<joint name=\"left_elbow_joint\""));
        assert_eq!(text.matches("\"left_").count(), {
            ["<link ", "<joint ", "<parent ", "<child "]
                .iter()
                .map(|tag| urdf.matches(tag).count())
                .sum::<usize>()
        });
    }
}
