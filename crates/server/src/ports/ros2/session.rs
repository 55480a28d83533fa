//! One life of the node: samples and answers out, requests and goals in.

use std::convert::Infallible;
use std::pin::pin;

use elite_runtime::Robot;
use futures_util::StreamExt as _;
use futures_util::stream::FuturesUnordered;
use kinematics::RobotModel;
use motion_api::{CommandKind, MachineCommand};
use ros2::link::{
    ControllerMessage, LinkError, NodeMessage, NodeSetup, Order, Trigger, VERSION, body_length,
    value,
};
use ros2::sample::NodeSample;
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::mpsc;
use tokio::time::{Duration, timeout};
use tokio_util::sync::CancellationToken;

use super::goals::Goals;
use super::orders::carry_out;
use super::outbox::Outbox;
use super::process::NodeEnd;
use super::simulated_time::SimulatedTime;
use super::{NodePlan, Ros2Backend};
use crate::ports::description::TaskStatus;
use crate::ports::sample::Sample;

/// Orders that are carried out at the same time; the node asks for no more than twice as many.
const ORDERS_MAX: usize = 32;
/// The end of the node's process is announced to it within so long.
const FAREWELL: Duration = Duration::from_millis(500);

/// Serves a node until it or the controller ends.
pub(super) async fn serve_link<B: Ros2Backend>(
    link: impl AsyncRead + AsyncWrite + Unpin,
    plan: &NodePlan,
    backend: &B,
    shutdown: &CancellationToken,
) -> Result<Infallible, NodeEnd> {
    let (mut reader, mut writer) = tokio::io::split(link);
    let mut outbox = Outbox::default();
    outbox.push(&ControllerMessage::Setup(NodeSetup {
        version: VERSION,
        ..plan.setup.clone()
    }))?;
    let (came, mut coming) = mpsc::channel(ORDERS_MAX);
    let mut reading = pin!(read_frames(&mut reader, came));
    let mut samples = backend.samples();
    let mut pace = SamplePace::new(plan.rate);
    let mut orders = FuturesUnordered::new();
    let mut goals = AbandonedGoals(
        Goals::new(plan.setup.prefix.clone(), plan.epoch),
        backend.robot(),
    );
    let mut time = None;
    loop {
        let may_pass = outbox.is_empty() && samples.is_empty();
        tokio::select! {
            () = shutdown.cancelled() => {
                outbox.push(&ControllerMessage::End)?;
                let write = async {
                    while !outbox.is_empty() && outbox.write(&mut writer).await.is_ok() {}
                };
                // A node that does not take it is ended anyway.
                let _ = timeout(FAREWELL, write).await;
                return Err(NodeEnd::Asked);
            }
            () = next_cycle(&mut time), if may_pass => {}
            written = outbox.write(&mut writer), if !outbox.is_empty() => written?,
            Err(why) = &mut reading => return Err(why),
            Some((request, (success, message))) = orders.next() => {
                outbox.push(&ControllerMessage::Answer { request, success, message })?;
            }
            Some(frame) = coming.recv(), if orders.len() < ORDERS_MAX => match frame {
                NodeMessage::Ready { version: VERSION } => {
                    if plan.setup.simulated_time {
                        time = Some(SimulatedTime::begin(backend.robot(), plan.time_factor));
                    }
                    tracing::info!("the ROS 2 node is there: domain {}", plan.setup.domain);
                }
                NodeMessage::Ready { version } => {
                    return Err(LinkError::Version { theirs: version }.into());
                }
                NodeMessage::Shown { samples } => {
                    if let Some(time) = &mut time {
                        time.shown(samples);
                    }
                }
                NodeMessage::Request { request, order } => {
                    let of_goal = order_to_goal(&order, &mut goals.0, backend.robot());
                    orders.push(async move {
                        let answer = match of_goal {
                            Some((command, answer)) => {
                                backend.command(command).await;
                                (true, answer.to_owned())
                            }
                            None => carry_out(order, backend).await,
                        };
                        (request, answer)
                    });
                }
                NodeMessage::Goal { id, goal } => {
                    let mut out = Vec::new();
                    goals.0.goal(id, &goal, backend, &mut out);
                    push_all(&mut outbox, &out)?;
                }
                NodeMessage::Cancel { ids } => goals.0.cancel(&ids, backend.robot()),
                NodeMessage::Trajectory(trajectory) => {
                    let mut out = Vec::new();
                    goals.0.trajectory(trajectory, backend, &mut out);
                    push_all(&mut outbox, &out)?;
                }
            },
            sample = samples.recv() => match sample {
                Ok(sample) => {
                    let mut out = Vec::new();
                    goals.0.cycle(&sample.state, backend.robot(), &mut out);
                    push_all(&mut outbox, &out)?;
                    if pace.is_due(sample.state.time) {
                        let model = backend.robot().model();
                        outbox.push(&ControllerMessage::Sample(node_sample(&sample, model, plan.epoch)))?;
                        if let Some(time) = &mut time {
                            time.sent();
                        }
                    }
                }
                Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => return Err(NodeEnd::Asked),
            },
        }
    }
}

fn push_all(outbox: &mut Outbox, messages: &[ControllerMessage]) -> Result<(), LinkError> {
    messages.iter().try_for_each(|message| outbox.push(message))
}

/// What an order means for the goal that moves the arm, where one does: a command, and the answer of the dashboard.
fn order_to_goal(
    order: &Order,
    goals: &mut Goals,
    robot: &Robot,
) -> Option<(CommandKind, &'static str)> {
    if !goals.is_running() {
        return None;
    }
    match order {
        Order::Trigger(Trigger::Pause) => {
            goals.set_paused(true);
            Some((CommandKind::Machine(MachineCommand::Pause), "Pausing task"))
        }
        Order::Trigger(Trigger::Play) => {
            goals.set_paused(false);
            Some((
                CommandKind::Machine(MachineCommand::Resume),
                "Starting task",
            ))
        }
        Order::Trigger(Trigger::Stop) => {
            goals.stop(robot);
            None
        }
        _ => None,
    }
}

/// Goals whose arm is stopped when nobody follows them any more, however that came.
struct AbandonedGoals<'a>(Goals, &'a Robot);

impl Drop for AbandonedGoals<'_> {
    fn drop(&mut self) {
        self.0.abandon(self.1);
    }
}

fn node_sample(sample: &Sample, model: &RobotModel, epoch: i64) -> NodeSample {
    let is_running = sample.task == TaskStatus::Running;
    let stamp = epoch + (sample.state.time * 1e9).round() as i64;
    NodeSample::of(&sample.state, model, is_running, stamp)
}

/// Lets simulated time pass by a cycle when that is due; never where time is not simulated.
async fn next_cycle(time: &mut Option<SimulatedTime<'_>>) {
    match time {
        Some(time) => time.pass().await,
        None => std::future::pending().await,
    }
}

/// Reads frames until the link ends or what comes is none.
async fn read_frames(
    reader: &mut (impl AsyncRead + Unpin),
    came: mpsc::Sender<NodeMessage>,
) -> Result<Infallible, NodeEnd> {
    loop {
        let mut head = [0; 4];
        match reader.read_exact(&mut head).await {
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
                return Err(NodeEnd::Closed);
            }
            other => other?,
        };
        let mut body = vec![0; body_length(head)?];
        reader.read_exact(&mut body).await?;
        if came.send(value(&body)?).await.is_err() {
            return Err(NodeEnd::Closed);
        }
    }
}

/// A rate of messages: the cycles that are published.
struct SamplePace {
    rate: Option<f64>,
    last: Option<u64>,
}

impl SamplePace {
    const fn new(rate: Option<f64>) -> Self {
        Self { rate, last: None }
    }

    /// Whether the cycle that ended at `time`, s, is shown: the first of each interval of the rate.
    fn is_due(&mut self, time: f64) -> bool {
        let Some(rate) = self.rate else { return true };
        // A millionth of slack: a multiple of a step is rarely the exact number.
        let interval = (time * rate + 1e-6) as u64;
        self.last.replace(interval) != Some(interval)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_takes_the_first_cycle_of_each_interval() {
        for (rate, expected) in [
            (None, 1000),
            (Some(250.0), 1000),
            (Some(125.0), 500),
            (Some(10.0), 40),
        ] {
            let mut pace = SamplePace::new(rate);
            let shown = (0..1000).filter(|cycle| pace.is_due(f64::from(*cycle) * 0.004));
            assert_eq!(shown.count(), expected, "{rate:?}");
        }
    }
}
