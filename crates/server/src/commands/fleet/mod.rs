//! `eliteserver fleet`: many controllers on one machine, a process each.
//!
//! Owns the beginning and the end of all, and the restart of one after the other. What a robot is started with is
//! `file`'s business, its process `robot`'s, the page `page`'s.

mod file;
mod log;
mod metrics;
mod page;
mod robot;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use messages::{Localized, text};
use platform::machine;
use platform::signals::Hangups;
use supervision::{ThreadRole, ThreadSupervisor};
use thiserror::Error;
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::cli::FleetArgs;
use crate::command::{CommandResult, CommandStatus};
use crate::language;
use crate::ports::allowed_hosts::AllowedHosts;
use crate::ports::http::{self, HttpService};
use crate::ports::listen::{BindError, PortMeter, bind, start_port};
use crate::shutdown::Shutdown;

use file::{FleetConfig, FleetFileError};
use robot::{READY_WITHIN, RestartRequest, RobotProcess};

/// All robots have so long to bring their arms to rest and to end.
const ORDERLY: Duration = Duration::from_secs(15);

/// A reason why a fleet is not started, told in a sentence.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum FleetError {
    /// The fleet's file cannot be used.
    #[error(transparent)]
    File(#[from] FleetFileError),
    /// The port of the fleet's page cannot be opened.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// Threads, signals, the program itself.
    #[error("the operating system refused what a fleet needs: {0}")]
    #[zh("操作系统拒绝了机器人组所需的资源：{0}")]
    System(#[from] io::Error),
}

/// A robot and how it is told to start anew.
struct FleetMember {
    robot: Arc<RobotProcess>,
    orders: mpsc::Sender<RestartRequest>,
}

/// Exit status 0 after a signal.
///
/// # Errors
/// [`FleetError`]
pub fn fleet(args: &FleetArgs) -> CommandResult {
    Ok(start_fleet(args)?)
}

fn start_fleet(args: &FleetArgs) -> Result<CommandStatus, FleetError> {
    let fleet = FleetConfig::load(&args.file)?;
    if args.check {
        let count = fleet.robots.len();
        language::say(&text!(
            "{}: {count} robots can be started",
            "{}：可以启动 {count} 个机器人",
            args.file.display()
        ));
        return Ok(CommandStatus::Success);
    }
    let program = std::env::current_exe()?;
    let shutdown = Shutdown::start_within(CommandStatus::Success, ORDERLY)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let done = runtime.block_on(run(fleet, &args.file, program, shutdown.token()));
    runtime.shutdown_background();
    done.map(|()| CommandStatus::Success)
}

async fn run(
    fleet: FleetConfig,
    path: &Path,
    program: PathBuf,
    shutdown: &CancellationToken,
) -> Result<(), FleetError> {
    // A page that cannot be opened is told before anything moves.
    let listener = bind("http-port", fleet.bind, fleet.http_port).await?;
    let mut hangups = Hangups::listen()?;
    let mut services = JoinSet::new();
    let mut running = Vec::new();
    let mut kept = Vec::new();
    for plan in fleet.robots {
        let robot = Arc::new(RobotProcess::new(plan));
        let (orders, inbox) = mpsc::channel(1);
        let (in_task, program, token) = (robot.clone(), program.clone(), shutdown.clone());
        running.push(
            ThreadSupervisor::default().spawn(ThreadRole::Service, "robot", async move {
                in_task.supervise(&program, inbox, &token).await;
            }),
        );
        kept.push(FleetMember { robot, orders });
    }
    let robots: page::Robots = Arc::new(kept.iter().map(|kept| kept.robot.clone()).collect());
    if let Some(listener) = listener {
        let address = listener.local_addr()?;
        tracing::info!("{} robots, page on http://{address}/", kept.len());
        let callers = AllowedHosts::of(
            fleet.bind,
            machine::host_name().as_deref(),
            &fleet.trusted_hosts,
        );
        let (meter, token) = (PortMeter::new("http"), shutdown.clone());
        let one = meter.clone();
        start_port(&mut services, listener, &meter, move |listener| {
            let pages = HttpService::over(page::router(robots.clone()));
            http::serve(listener, pages, one.clone(), callers.clone(), token.clone())
        })?;
    }
    loop {
        tokio::select! {
            () = shutdown.cancelled() => break,
            Some(()) = hangups.wait() => {
                tokio::select! {
                    () = shutdown.cancelled() => break,
                    () = restart_all(path, &kept) => {}
                }
            }
        }
    }
    for robot in running {
        // One whose task has met a fault is gone with it.
        let _ = robot.await;
    }
    while services.join_next().await.is_some() {}
    tracing::info!("all robots have ended");
    Ok(())
}

/// Reads the file again and starts one robot after the other anew; the next only when the one before is ready. Where
/// the file is wrong, or one does not come up, the others stay as they are.
async fn restart_all(path: &Path, kept: &[FleetMember]) {
    let fleet = match FleetConfig::load(path) {
        Ok(fleet) => fleet,
        Err(error) => return tracing::error!("nothing is restarted: {error}"),
    };
    let names = |fleet: &[file::RobotPlan]| {
        fleet
            .iter()
            .map(|plan| plan.name.clone())
            .collect::<Vec<_>>()
    };
    let running: Vec<file::RobotPlan> = kept.iter().map(|kept| kept.robot.plan()).collect();
    if names(&fleet.robots) != names(&running) {
        return tracing::error!(
            "nothing is restarted: {} has other robots now; end the fleet and start it again",
            path.display()
        );
    }
    for (kept, plan) in kept.iter().zip(fleet.robots) {
        let name = plan.name.clone();
        tracing::info!("robot {name} is restarted");
        let (answer, answered) = oneshot::channel();
        if kept
            .orders
            .send(RestartRequest(plan, answer))
            .await
            .is_err()
        {
            return;
        }
        let result = tokio::time::timeout(READY_WITHIN * 2, answered).await;
        match result {
            Ok(Ok(Ok(()))) => {}
            Ok(Ok(Err(why))) => {
                return tracing::error!(
                    "robot {name} did not come up, the others are not restarted: {why}"
                );
            }
            _ => {
                return tracing::error!(
                    "robot {name} did not come up, the others are not restarted"
                );
            }
        }
    }
    tracing::info!("all robots are restarted");
}
