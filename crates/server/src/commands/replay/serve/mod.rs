//! `replay --serve`: a recording through ports 30001, 30004, http and Foxglove, as if the arm ran now.
//!
//! Owns the ports and the pace. [`Playback`] is what the ports see; it is read-only: whoever sends a program or claims
//! an input is told so. The ports close when the recording ends.

mod page;
mod playback;
mod time_line;

use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::time::Duration;

use controller::recorded_run::{InitialSetupError, model_of};
use messages::{Localized, Text};
use recorder::lengths::truncate_marked;
use recorder::{ReadError, Recording, RecordingEntry, Topic, ViewerMessages};
use supervision::{ThreadRole, ThreadSupervisor};
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep_until};
use tokio_util::sync::CancellationToken;

use super::rerun::RerunError;
use crate::cli::ReplayPortArgs;
use crate::command::CommandStatus;
use crate::commands::serve::{Listeners, ServeError, bound_ports, open_ports};
use crate::config::{ConfigError, PRIMARY_PORT, PortSettings, STATE_PORT, port_beside};
use crate::describe::robot_description;
use crate::options::PortSetting;
use crate::ports::allowed_hosts::AllowedHosts;
use crate::ports::foxglove::FoxgloveSource;
use crate::ports::http::HttpService;
use crate::ports::http::page::{Page, PageBroadcast};
use crate::ports::listen::{PortMeter, start_port};
use crate::ports::{foxglove, http, primary, rtsi, state};
use crate::ready_file;
use crate::shutdown::Shutdown;
use controller::cell::{Cell, CellError};
use controller::cell_world::WorldScene;
use controller::start_configuration::cycle_config;
use playback::Playback;
use time_line::PageContent;

/// Messages read ahead from the file.
const READ_AHEAD: usize = 1024;
/// The longest pause between two messages that is played, s. A controller that runs is never silent for so long.
const PAUSE_MAX: f64 = 10.0;
/// Bytes of a text that clients are shown; the program's own text is none of them.
const SHOWN_BYTES: usize = 16 << 10;
/// Clients hear the last state before the ports close.
const FAREWELL: Duration = Duration::from_millis(250);
/// How long a page that is opened, or loaded again, after the end of the recording still finds it.
const PAGE_WITHIN: Duration = Duration::from_secs(30);
/// Playback rate above which the page is not kept after the end, because nobody looks at such a recording.
const RATE_TO_LOOK_AT: f64 = 10.0;

/// A reason why a recording cannot be served.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ServeRecordingError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording does not tell which arm it is of.
    #[error(transparent)]
    Setup(#[from] RerunError),
    /// The cell file in it is none of this version's.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// The ports do not fit together.
    #[error(transparent)]
    Ports(#[from] ConfigError),
    /// A port cannot be opened.
    #[error(transparent)]
    Serve(#[from] ServeError),
    /// Threads or signals.
    #[error("the operating system refused what a server needs: {0}")]
    #[zh("操作系统拒绝了服务器所需的资源：{0}")]
    System(#[from] std::io::Error),
}

/// Serves the recording at `rate` times its speed until it ends or a signal comes.
pub(super) fn serve(
    recording: &Recording,
    rate: f64,
    args: &ReplayPortArgs,
) -> Result<(), ServeRecordingError> {
    let shutdown = Shutdown::start(CommandStatus::Success)?;
    if let Some(path) = &args.ready_file {
        ready_file::remove(path).map_err(|source| ServeError::stale(path, source))?;
    }
    let setup = recording.setup().ok_or(InitialSetupError::NoSetup);
    let setup = setup.map_err(RerunError::from)?;
    let files = recording.check_files().map_err(InitialSetupError::Files);
    files.map_err(RerunError::from)?;
    let model = model_of(setup).map_err(RerunError::from)?;
    let cell = Cell::of_recording(setup)?;
    let obstacles = cell.as_ref().map(Cell::scene_obstacles).unwrap_or_default();
    let viewer = ViewerMessages::new(model.clone(), obstacles, setup.epoch_ns);
    let config = cycle_config(setup, model.clone(), cell.as_ref()).map_err(InitialSetupError::from);
    let config = config.map_err(RerunError::from)?;
    let description = robot_description(&config).map_err(RerunError::Config)?;
    let mut scene = pendant::scene::describe(&model, cell.as_ref());
    scene.description["home"] = serde_json::json!(setup.home.0);
    let shown = Arc::new(PageContent {
        scene,
        world: cell
            .as_ref()
            .and_then(|cell| WorldScene::of_cell(cell, &model)),
        recording: Some(recording.clone()),
        ..PageContent::default()
    });
    let follow = || Playback::new(recording.name(), model.clone(), description.clone(), setup);
    let playback = Arc::new(follow().with_page(shown.clone()));
    if args.http_port != Some(PortSetting::Off) {
        time_line::read(recording.clone(), follow(), shown)?;
    }
    let page = Arc::new(Page::new(playback.clone(), false)?);

    let fixed =
        |setting: Option<PortSetting>, number| setting.unwrap_or(PortSetting::Number(number));
    let primary = fixed(args.primary_port, PRIMARY_PORT);
    let mut ports = PortSettings {
        primary,
        interpreter: PortSetting::Off,
        rtsi: fixed(args.rtsi_port, 30004),
        dashboard: PortSetting::Off,
        modbus: PortSetting::Off,
        http: fixed(args.http_port, 8080),
        foxglove: args.foxglove_port.unwrap_or(PortSetting::Off),
        state: port_beside(primary, args.state_port, STATE_PORT),
        query: PortSetting::Off,
        tool_serial: PortSetting::Off,
    };
    crate::config::check_distinct_ports(&ports)?;
    let bind = args.bind.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST));
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()?;
    let faults = ThreadSupervisor::default();
    let served = runtime.block_on(async {
        let stop = shutdown.token().child_token();
        let listeners = open_ports(bind, &mut ports).await?;
        let bound = bound_ports(&listeners)?;
        for (name, port) in bound
            .iter()
            .filter_map(|(name, port)| Some((name, (*port)?)))
        {
            tracing::info!("{name} on {bind}:{port}");
        }
        let trusted = crate::config::trusted_hosts(args.trust_host.clone());
        let callers = AllowedHosts::of(bind, platform::machine::host_name().as_deref(), &trusted);
        let services = open_services(listeners, &playback, &page, viewer, &callers, &stop)?;
        if let Some(path) = &args.ready_file {
            ready_file::write(path, std::process::id(), &bound).map_err(|source| {
                ServeError::ReadyFile {
                    path: path.clone(),
                    source,
                }
            })?;
        }
        let (shown, until) = (page.clone(), stop.clone());
        faults.spawn(ThreadRole::Service, "page", async move {
            shown.run(&until).await
        });
        let played = stop
            .run_until_cancelled(play(recording, rate, &playback))
            .await;
        stop.run_until_cancelled(tokio::time::sleep(FAREWELL)).await;
        if played.as_ref().is_some_and(Result::is_ok) && ports.http != PortSetting::Off {
            stop.run_until_cancelled(linger(page.stage(), rate)).await;
        }
        stop.cancel();
        services.join_all().await;
        played.unwrap_or(Ok(()))
    });
    runtime.shutdown_background();
    if let Some(path) = &args.ready_file
        && let Err(error) = ready_file::remove(path)
    {
        tracing::warn!("cannot remove the ready file {}: {error}", path.display());
    }
    served
}

/// A recording that is over is still shown: for a while to whoever opens the page, then for as long as a page is open.
async fn linger(stage: &PageBroadcast, rate: f64) {
    let patience = match rate <= RATE_TO_LOOK_AT {
        true => PAGE_WITHIN,
        false => Duration::ZERO,
    };
    let mut last_seen = Instant::now();
    while stage.pages() > 0 || last_seen.elapsed() < patience {
        if stage.pages() > 0 {
            last_seen = Instant::now();
        }
        tokio::time::sleep(FAREWELL).await;
    }
}

fn open_services(
    listeners: Listeners,
    playback: &Arc<Playback>,
    page: &Arc<Page<Playback>>,
    viewer: ViewerMessages,
    callers: &AllowedHosts,
    stop: &CancellationToken,
) -> std::io::Result<JoinSet<()>> {
    let meters: Vec<PortMeter> = listeners
        .iter()
        .filter(|(_, listener)| listener.is_some())
        .map(|(name, _)| PortMeter::new(name))
        .collect();
    let mut services = JoinSet::new();
    for (name, listener) in listeners {
        let meter = meters.iter().find(|meter| meter.name() == name).cloned();
        let (Some(listener), Some(meter)) = (listener, meter) else {
            continue;
        };
        let (playback, stop) = (playback.clone(), stop.clone());
        let (all, one, callers) = (meters.clone(), meter.clone(), callers.clone());
        let page = page.clone();
        match name {
            "primary" => start_port(&mut services, listener, &meter, move |listener| {
                let (playback, stop) = (playback.clone(), stop.clone());
                let (hub, one) = (playback.hub().clone(), one.clone());
                async move {
                    let publishing = hub.publish_states(&*playback, stop.clone());
                    let served = playback.clone();
                    let serving = primary::serve(listener, served, hub.clone(), one, stop.clone());
                    tokio::join!(publishing, serving);
                }
            })?,
            "state" => start_port(&mut services, listener, &meter, move |listener| {
                let hub = playback.hub().clone();
                state::serve(listener, playback.clone(), hub, one.clone(), stop.clone())
            })?,
            "rtsi" => start_port(&mut services, listener, &meter, move |listener| {
                rtsi::serve(listener, playback.clone(), one.clone(), stop.clone())
            })?,
            "http" => start_port(&mut services, listener, &meter, move |listener| {
                let pages = HttpService::of(playback.clone(), all.clone()).with_page(page.clone());
                http::serve(listener, pages, one.clone(), callers.clone(), stop.clone())
            })?,
            "foxglove" => {
                let viewer = viewer.clone();
                start_port(&mut services, listener, &meter, move |listener| {
                    let view = FoxgloveSource {
                        viewer: viewer.clone(),
                        // The world of a recording is on the page, and in the file itself.
                        world: None,
                        samples: playback.samples(),
                        log: playback.log_lines(),
                    };
                    foxglove::serve(listener, view, one.clone(), callers.clone(), stop.clone())
                })?;
            }
            other => unreachable!("{other} is off in a replay"),
        }
    }
    Ok(services)
}

/// Gives every message of the recording to `playback` when its time has come.
async fn play(
    recording: &Recording,
    rate: f64,
    playback: &Playback,
) -> Result<(), ServeRecordingError> {
    let mut messages = read_ahead(recording.clone())?;
    let begin = Instant::now();
    let mut last = None;
    let mut played = 0.0;
    while let Some(message) = messages.recv().await {
        let (time, entry) = message?;
        // A recording may hold any time stamp; time goes on, and in pauses that somebody can wait for.
        let passed = time - last.unwrap_or(time);
        if passed > 0.0 {
            played += passed.min(PAUSE_MAX);
        }
        if let Ok(elapsed) = Duration::try_from_secs_f64(played / rate)
            && let Some(due) = begin.checked_add(elapsed)
            && due > Instant::now()
        {
            sleep_until(due).await;
        }
        last = Some(time);
        playback.take(time, entry);
    }
    tracing::info!("the recording ends at {:.3} s", last.unwrap_or(0.0));
    Ok(())
}

/// Reads the file on a thread of its own, since reading may wait for the disk.
fn read_ahead(
    recording: Recording,
) -> std::io::Result<mpsc::Receiver<Result<(f64, RecordingEntry), ReadError>>> {
    let (sender, receiver) = mpsc::channel(READ_AHEAD);
    ThreadSupervisor::default().start(ThreadRole::Service, "replay", move || {
        let entries = match recording.entries(&Topic::ALL) {
            Ok(entries) => entries,
            Err(error) => {
                // Nobody to tell any more: the ports are closing.
                let _ = sender.blocking_send(Err(error));
                return;
            }
        };
        for entry in entries {
            let entry = entry.map(|(time, entry)| (time, shown(entry)));
            if sender.blocking_send(entry).is_err() {
                return;
            }
        }
    })?;
    Ok(receiver)
}

/// An entry without what no client is shown, so that those that are read ahead are small.
fn shown(mut entry: RecordingEntry) -> RecordingEntry {
    let shorten = |text: &mut String| {
        if let Some(short) = truncate_marked(text, SHOWN_BYTES) {
            *text = short;
        }
    };
    match &mut entry {
        RecordingEntry::Script(script) => {
            shorten(&mut script.program);
            if let Some(text) = &mut script.text {
                *text = String::new();
            }
        }
        RecordingEntry::Log(log) => {
            shorten(&mut log.source);
            let mut message = log.message.english().to_owned();
            shorten(&mut message);
            log.message = Text::verbatim(message);
        }
        RecordingEntry::Command(command) => {
            command.arguments.clear();
            shorten(&mut command.program);
        }
        RecordingEntry::Cycle(_) | RecordingEntry::Io(_) | RecordingEntry::Variable(_) => {}
    }
    entry
}
