//! One robot of a fleet: a process that is started, watched, started again when it ends, and stopped in an orderly way.
//!
//! Owns the process, the pauses before it is started again, its log file and the bound of its memory. Its standard
//! input is held open; when that closes, because it is to stop or because the fleet is gone however it went, it brings
//! its arm to rest and ends.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use messages::{Text, text};
use parking_lot::Mutex;
use platform::{machine, processes};
use serde_json::Value as Json;
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::process::{Child, ChildStdin, Command};
use tokio::sync::{mpsc, oneshot};
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;

use super::file::RobotPlan;
use super::log::copy_lines;

/// How often it is looked whether a robot is ready, and what it holds.
const LOOK_EVERY: Duration = Duration::from_millis(10);
const MEASURE_EVERY: Duration = Duration::from_secs(1);
/// A process has so long to be ready.
pub(super) const READY_WITHIN: Duration = Duration::from_secs(30);
/// A process that was told to end has so long; the arm comes to rest and the recording is closed in less.
const END_WITHIN: Duration = Duration::from_secs(10);
/// First and longest pause before it is started again.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);
/// One that was ready for so long was well: the next pause is the first again.
const WELL_AFTER: Duration = Duration::from_secs(60);

/// What a robot does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProcessState {
    /// The robot's process runs, and its ports do not listen yet.
    Starting,
    /// The robot's ports listen.
    Ready,
    /// The process ended and is started again after a pause.
    Waiting,
    /// The process was stopped.
    Stopped,
}

impl ProcessState {
    /// The word for it.
    pub(super) const fn name(self) -> Text {
        match self {
            Self::Starting => Text::fixed("starting", "启动中"),
            Self::Ready => Text::fixed("ready", "就绪"),
            Self::Waiting => Text::fixed("waiting", "等待重启"),
            Self::Stopped => Text::fixed("stopped", "已停止"),
        }
    }
}

/// What is known of a robot.
#[derive(Clone, Debug)]
pub(super) struct ProcessStatus {
    pub state: ProcessState,
    pub pid: Option<u32>,
    /// Port of each service, from the robot's ready file.
    pub ports: BTreeMap<String, u16>,
    /// Number of restarts that nobody asked for.
    pub restarts: u64,
    /// Bytes it holds.
    pub memory: u64,
    /// How its last process ended.
    pub last_end: Option<Text>,
}

/// Start it anew with this plan; the answer comes when it is ready, or why it is not.
pub(super) struct RestartRequest(pub RobotPlan, pub oneshot::Sender<Result<(), Text>>);

/// A robot.
pub(super) struct RobotProcess {
    plan: Mutex<RobotPlan>,
    seen: Mutex<ProcessStatus>,
}

/// A reason why a process is over.
enum ProcessExit {
    /// The process ended by itself.
    Ended(Text),
    /// The process is to end for good.
    Stopped,
    /// The process is to be started anew.
    Renewed(RestartRequest),
}

/// A process.
struct ServerProcess {
    child: Child,
    /// Closed when it is to end.
    input: Option<ChildStdin>,
    ready_file: PathBuf,
}

impl RobotProcess {
    pub(super) fn new(plan: RobotPlan) -> Self {
        Self {
            plan: Mutex::new(plan),
            seen: Mutex::new(ProcessStatus {
                state: ProcessState::Starting,
                pid: None,
                ports: BTreeMap::new(),
                restarts: 0,
                memory: 0,
                last_end: None,
            }),
        }
    }

    pub(super) fn plan(&self) -> RobotPlan {
        self.plan.lock().clone()
    }

    pub(super) fn seen(&self) -> ProcessStatus {
        self.seen.lock().clone()
    }

    fn update_status(&self, change: impl FnOnce(&mut ProcessStatus)) {
        change(&mut self.seen.lock());
    }

    /// Keeps it running until `shutdown`.
    pub(super) async fn supervise(
        &self,
        program: &Path,
        mut orders: mpsc::Receiver<RestartRequest>,
        shutdown: &CancellationToken,
    ) {
        let name = self.plan().name;
        let mut pause = FIRST_PAUSE;
        let mut asked: Option<oneshot::Sender<Result<(), Text>>> = None;
        loop {
            let begun = Instant::now();
            let over = match start(program, &self.plan()) {
                Ok(process) => self.watch(process, &mut orders, &mut asked, shutdown).await,
                Err(error) => {
                    ProcessExit::Ended(text!("it cannot be started: {error}", "无法启动：{error}"))
                }
            };
            let was_ready = self.seen().state == ProcessState::Ready;
            self.update_status(|seen| {
                (seen.pid, seen.memory) = (None, 0);
                seen.ports.clear();
            });
            let why = match over {
                ProcessExit::Stopped => break,
                ProcessExit::Renewed(RestartRequest(plan, answer)) => {
                    *self.plan.lock() = plan;
                    (asked, pause) = (Some(answer), FIRST_PAUSE);
                    self.update_status(|seen| seen.state = ProcessState::Starting);
                    continue;
                }
                ProcessExit::Ended(why) => why,
            };
            if was_ready && begun.elapsed() >= WELL_AFTER {
                pause = FIRST_PAUSE;
            }
            tracing::error!(
                "robot {name}: {why}; it is started again in {} s",
                pause.as_secs_f64()
            );
            if let Some(answer) = asked.take() {
                // Whoever asked may have gone.
                let _ = answer.send(Err(why.clone()));
            }
            self.update_status(|seen| {
                seen.state = ProcessState::Waiting;
                seen.restarts += 1;
                seen.last_end = Some(why);
            });
            tokio::select! {
                () = sleep(pause) => {}
                () = shutdown.cancelled() => break,
                Some(RestartRequest(plan, answer)) = orders.recv() => {
                    *self.plan.lock() = plan;
                    (asked, pause) = (Some(answer), FIRST_PAUSE);
                    self.update_status(|seen| seen.state = ProcessState::Starting);
                    continue;
                }
            }
            pause = (pause * 2).min(LONGEST_PAUSE);
            self.update_status(|seen| seen.state = ProcessState::Starting);
        }
        self.update_status(|seen| seen.state = ProcessState::Stopped);
    }

    /// Looks after a process until it is over.
    async fn watch(
        &self,
        mut process: ServerProcess,
        orders: &mut mpsc::Receiver<RestartRequest>,
        asked: &mut Option<oneshot::Sender<Result<(), Text>>>,
        shutdown: &CancellationToken,
    ) -> ProcessExit {
        let pid = process.child.id();
        self.update_status(|seen| (seen.state, seen.pid) = (ProcessState::Starting, pid));
        let begun = Instant::now();
        let (memory_max, mut measured) = (self.plan().memory, Instant::now());
        let mut is_ready = false;
        loop {
            let look = if is_ready { MEASURE_EVERY } else { LOOK_EVERY };
            tokio::select! {
                ended = process.child.wait() => return ProcessExit::Ended(exit_description(ended)),
                () = shutdown.cancelled() => {
                    process.end().await;
                    return ProcessExit::Stopped;
                }
                Some(renew) = orders.recv() => {
                    process.end().await;
                    return ProcessExit::Renewed(renew);
                }
                () = sleep(look) => {}
            }
            if !is_ready {
                if let Some(ports) = ports_of(&process.ready_file, pid) {
                    is_ready = true;
                    self.update_status(|seen| {
                        (seen.state, seen.ports) = (ProcessState::Ready, ports)
                    });
                    if let Some(answer) = asked.take() {
                        let _ = answer.send(Ok(()));
                    }
                } else if begun.elapsed() >= READY_WITHIN {
                    process.end().await;
                    return ProcessExit::Ended(text!(
                        "its ports did not listen within {} s",
                        "其端口在 {} s 内没有监听",
                        READY_WITHIN.as_secs()
                    ));
                }
            }
            if measured.elapsed() >= MEASURE_EVERY || self.seen().memory == 0 {
                measured = Instant::now();
                let held = pid.and_then(machine::resident_bytes).unwrap_or(0);
                self.update_status(|seen| seen.memory = held);
                if let Some(most) = memory_max.filter(|most| held > *most) {
                    process.end().await;
                    return ProcessExit::Ended(text!(
                        "it held {} MB, {} MB are allowed",
                        "占用 {} MB，允许 {} MB",
                        held / 1_000_000,
                        most / 1_000_000
                    ));
                }
            }
        }
    }
}

impl ServerProcess {
    /// Ends it in an orderly way, and by force when that takes too long.
    async fn end(&mut self) {
        drop(self.input.take());
        if timeout(END_WITHIN, self.child.wait()).await.is_err() {
            // One that has just ended is as good.
            let _ = self.child.kill().await;
        }
    }
}

/// Starts a process in the robot's own folder.
fn start(program: &Path, plan: &RobotPlan) -> io::Result<ServerProcess> {
    fs::create_dir_all(&plan.folder)?;
    let config = plan.folder.join("robot.toml");
    crate::ready_file::replace(&config, &plan.config)?;
    let ready_file = plan.folder.join("ready.json");
    crate::ready_file::remove(&ready_file)?;
    let mut command = Command::new(program);
    command
        .arg("serve")
        .arg("--config")
        .arg(&config)
        .arg("--ready-file")
        .arg(&ready_file)
        .arg("--until-stdin-closes")
        .current_dir(&plan.folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .kill_on_drop(true);
    // Ctrl-C at the terminal is the fleet's to hear.
    processes::set_process_group(command.as_std_mut());
    let mut child = command.spawn()?;
    let input = child.stdin.take();
    if let Some(said) = child.stderr.take() {
        let copying = copy_lines(said, plan.folder.join("robot.log"));
        ThreadSupervisor::default().spawn(ThreadRole::Service, "robot-log", copying);
    }
    Ok(ServerProcess {
        child,
        input,
        ready_file,
    })
}

fn exit_description(ended: io::Result<ExitStatus>) -> Text {
    match ended {
        Ok(status) => text!(
            "it ended ({status}); its log says why",
            "已结束（{status}）；原因见其日志"
        ),
        Err(error) => text!(
            "it cannot be waited for: {error}",
            "无法等待其结束：{error}"
        ),
    }
}

/// The ports in a ready file, if this process wrote it.
fn ports_of(file: &Path, pid: Option<u32>) -> Option<BTreeMap<String, u16>> {
    let ready: Json = serde_json::from_slice(&fs::read(file).ok()?).ok()?;
    if ready["pid"].as_u64() != pid.map(u64::from) {
        return None;
    }
    let ports = ready["ports"]
        .as_object()?
        .iter()
        .filter_map(|(name, port)| {
            let port = u16::try_from(port.as_u64()?).ok()?;
            Some((name.clone(), port))
        });
    Some(ports.collect())
}
