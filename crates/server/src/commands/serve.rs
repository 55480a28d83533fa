//! `eliteserver serve`: the controller with its ports, until SIGINT or SIGTERM.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use controller::cell_world::CellWorld;
use editor::dap::DebugHub;
use messages::text;

pub use super::serve_error::ServeError;
use crate::backend::{Lifetime, PortBackend, forward_messages};
use crate::command::{CommandResult, CommandStatus};
use crate::config::{PortSettings, Ros2Config, ServeConfig};
use crate::controller_host::ControllerHost;
use crate::event_broadcast::PrintTarget;
use crate::options::PortSetting;
use crate::ports::allowed_hosts::AllowedHosts;
use crate::ports::http::HttpService;
use crate::ports::http::page::Page;
use crate::ports::listen::{PortMeter, bind, start_port};
use crate::ports::ros2::keep_node;
use crate::ports::{
    dashboard, foxglove, gripper, http, interpreter, modbus, primary, query, rtsi, state,
    tool_serial,
};
use crate::ready_file;
use crate::shutdown::Shutdown;
use controller::options::{ClockChoice, RecordTarget};
use platform::priority::favour;
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

/// A program that was told to stop has so long, the arm's way to rest included.
const PROGRAM_ENDS: Duration = Duration::from_secs(6);

/// After a fault that ends the controller the ports stay open for so long, to say why.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// Serves until a signal. Exit status 0 when everything was flushed, 1 when the recording was cut short, 3 after a
/// fault of ours in the control cycle.
///
/// # Errors
/// What kept the server from starting.
pub fn serve(config: &ServeConfig) -> CommandResult {
    Ok(serve_until_signal(config)?)
}

fn serve_until_signal(config: &ServeConfig) -> Result<CommandStatus, ServeError> {
    if config.ros2.is_some() && cfg!(not(feature = "ros2")) {
        return Err(ServeError::NoRos2);
    }
    // Before there is any other thread: all of them have it from this one. Scripts' sockets and the ports would
    // otherwise have to wait for their turn among whatever else the machine does, longer than a driver's time-out.
    if config.robot.clock == ClockChoice::Realtime
        && let Err(reason) = favour()
    {
        tracing::debug!("threads are not favoured over other processes: {reason}");
    }
    let shutdown = Shutdown::start(CommandStatus::Success)?;
    if config.until_stdin_closes {
        end_with_stdin(&shutdown)?;
    }
    if let Some(path) = &config.ready_file {
        ready_file::remove(path).map_err(|source| ServeError::stale(path, source))?;
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()?;
    let mut config = config.clone();
    let status = loop {
        let life = live(&runtime, &mut config, &shutdown);
        match life {
            Ok(life) if life.status == CommandStatus::Success && life.reboots => {
                tracing::info!("rebooting")
            }
            Ok(life) => break Ok(life.status),
            Err(error) => break Err(error),
        }
    };
    // Nothing that is left on it is waited for.
    runtime.shutdown_background();
    status
}

/// Begins the end when whoever has started the server closes its standard input, or is gone.
fn end_with_stdin(shutdown: &Shutdown) -> std::io::Result<()> {
    let shutdown = shutdown.clone();
    ThreadSupervisor::default().start(ThreadRole::Service, "stdin", move || {
        // An error is an end as well; what is written there means nothing.
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        tracing::info!("standard input is closed: the end begins");
        shutdown.begin(CommandStatus::Success);
    })?;
    Ok(())
}

/// Ports that were served.
struct PortService {
    reboots: bool,
    backend: Arc<PortBackend>,
}

/// How a life of the server ended.
struct Life {
    status: CommandStatus,
    reboots: bool,
}

/// One life, from opening the ports to the last byte of the recording. Ports that were free to choose are kept for the
/// next one.
fn live(
    runtime: &Runtime,
    config: &mut ServeConfig,
    shutdown: &Shutdown,
) -> Result<Life, ServeError> {
    // Ports first: a port in use must not leave an empty recording behind.
    let listeners = runtime.block_on(open_ports(config.bind, &mut config.ports))?;
    let log_dir = config.log.dir.as_ref();
    let debuggers = match config.attachable {
        true => DebugHub::of_every_program(),
        false => DebugHub::default(),
    };
    let (robot, powered_off) = (&config.robot, config.powered_off);
    let host = ControllerHost::start(robot, log_dir, PrintTarget::Log, powered_off, debuggers)?;
    let controller = host.controller();
    shutdown.set_recording_closer(controller.closer());
    let served = runtime.block_on(serve_ports(config, &host, listeners, shutdown));
    // Whoever starts something when the file is there must not find a server that is gone.
    if let Some(path) = &config.ready_file
        && let Err(error) = ready_file::remove(path)
    {
        tracing::warn!("cannot remove the ready file {}: {error}", path.display());
    }
    // The ports are closed; a program that still runs has been told to stop. Before a reboot nobody else counts the
    // time.
    let supervisor = controller.supervisor();
    let ended = runtime.block_on(async { timeout(PROGRAM_ENDS, supervisor.ended()).await });
    if ended.is_err() {
        tracing::error!("the program does not end, so the server does");
        shutdown.begin(CommandStatus::Negative);
    }
    let served = served.map(|PortService { reboots, backend }| {
        // What the program has left in its variables is the next one's.
        backend.take_variables();
        reboots
    });
    let fault = controller.faults().fatal().is_some();
    let flushed = host.shut_down();
    shutdown.set_recording_closer(None);
    let reboots = served?;
    if let RecordTarget::File(path) = &config.robot.record {
        // The next life must not write over the recording of this one.
        let folder = path.parent().map(PathBuf::from).unwrap_or_default();
        config.robot.record = RecordTarget::NewFileIn(folder);
    }
    Ok(Life {
        status: if fault {
            CommandStatus::Fault
        } else {
            CommandStatus::of_answer(flushed)
        },
        reboots,
    })
}

/// One entry a service, in the order of the ready file.
pub(crate) type Listeners = Vec<(&'static str, Option<TcpListener>)>;

/// Opens every port that is on; ports that were free to choose are settled from then on.
///
/// # Errors
/// A port cannot be opened.
pub(crate) async fn open_ports(
    address: IpAddr,
    ports: &mut PortSettings,
) -> Result<Listeners, ServeError> {
    let mut listeners = Vec::new();
    for (name, option, setting) in ports.list() {
        let listener = bind(option, address, setting).await?;
        if let Some(listener) = &listener {
            let port = listener.local_addr()?.port();
            ports.set(name, PortSetting::Number(port));
        }
        listeners.push((name, listener));
    }
    Ok(listeners)
}

/// Every service with its port, for the ready file.
///
/// # Errors
/// The operating system does not tell a port.
pub(crate) fn bound_ports(
    listeners: &Listeners,
) -> std::io::Result<Vec<(&'static str, Option<u16>)>> {
    let mut bound = Vec::new();
    for (name, listener) in listeners {
        let address = listener.as_ref().map(TcpListener::local_addr).transpose()?;
        bound.push((*name, address.map(|address| address.port())));
    }
    Ok(bound)
}

/// The pendant page of the controller, which from now on shows what happens.
fn open_page(
    config: &ServeConfig,
    backend: &Arc<PortBackend>,
    faults: &ThreadSupervisor,
    token: &CancellationToken,
) -> std::io::Result<Arc<Page<PortBackend>>> {
    let is_given = config.bind.is_loopback();
    let page = Arc::new(Page::new(backend.clone(), is_given)?);
    if !is_given && config.ports.http != PortSetting::Off {
        // For whoever started the server; pages from other machines are asked for it.
        crate::language::complain(&text!(
            "the token of the pendant page is {}",
            "示教器页面的令牌是 {}",
            page.token().reveal()
        ));
    }
    let (shown, watch, token) = (page.clone(), faults.clone(), token.clone());
    faults.spawn(ThreadRole::Service, "page", async move {
        watch.run_restarting("page", || shown.run(&token)).await;
    });
    Ok(page)
}

/// The task that keeps the ROS 2 node.
type NodeTask = tokio::task::JoinHandle<Result<(), supervision::Fault>>;

/// Starts the ROS 2 node; the task ends with `token`, when the node's process has ended.
fn start_node(
    config: &ServeConfig,
    ros2: &Ros2Config,
    backend: &Arc<PortBackend>,
    faults: &ThreadSupervisor,
    token: &CancellationToken,
) -> Result<NodeTask, ServeError> {
    let plan = backend.node_plan(config, ros2).map_err(ServeError::Ros2)?;
    if !ros2.is_loopback_only() {
        tracing::warn!(
            "the ROS 2 node speaks with the network of {}: everybody there can read the robot's state, move the arm, \
             switch its power and its outputs, and send what keeps the node busy; DDS asks nobody who they are",
            plan.setup.networks.join(", ")
        );
    }
    let (backend, watch, token) = (backend.clone(), faults.clone(), token.clone());
    Ok(faults.spawn(ThreadRole::Service, "ros2", async move {
        let begin = || keep_node(plan.clone(), backend.clone(), token.clone());
        watch.run_restarting("ros2", begin).await;
    }))
}

/// Where a browser of this machine finds the page; none without the http port.
fn page_address(bind: IpAddr, bound: &[(&'static str, Option<u16>)]) -> Option<String> {
    let port = bound.iter().find(|(name, _)| *name == "http")?.1?;
    let host = match bind.is_unspecified() {
        true if bind.is_ipv4() => Ipv4Addr::LOCALHOST.into(),
        true => Ipv6Addr::LOCALHOST.into(),
        false => bind,
    };
    Some(format!("http://{}/", SocketAddr::new(host, port)))
}

async fn serve_ports(
    config: &ServeConfig,
    host: &ControllerHost,
    listeners: Listeners,
    shutdown: &Shutdown,
) -> Result<PortService, ServeError> {
    let controller = host.controller();
    let lifetime = Lifetime::default();
    let token = lifetime.token().clone();
    let hub = primary::StateHub::default();
    let backend = Arc::new(PortBackend::new(
        host,
        config,
        hub.clone(),
        lifetime.clone(),
    ));
    let faults = controller.faults();
    let forwarding = {
        let (announcer, backend, token) =
            (host.announcer().clone(), backend.clone(), token.clone());
        let watch = faults.clone();
        faults.spawn(ThreadRole::Service, "messages", async move {
            let begin = || forward_messages(announcer.subscribe(), backend.clone(), token.clone());
            watch.run_restarting("messages", begin).await;
        })
    };

    {
        let (backend, hub, token) = (backend.clone(), hub.clone(), token.clone());
        let watch = faults.clone();
        faults.spawn(ThreadRole::Service, "states", async move {
            let begin = || hub.publish_states(&*backend, token.clone());
            watch.run_restarting("states", begin).await;
        });
    }

    {
        let (backend, mut status) = (Arc::downgrade(&backend), controller.supervisor().watch());
        faults.spawn(ThreadRole::Service, "variables", async move {
            while status.changed().await.is_ok()
                && let Some(backend) = backend.upgrade()
            {
                backend.take_variables();
            }
        });
    }

    let page = open_page(config, &backend, faults, &token)?;
    let fieldbus = controller.fieldbus().clone();
    let callers = AllowedHosts::of(
        config.bind,
        platform::machine::host_name().as_deref(),
        &config.trusted_hosts,
    );
    let mut services = tokio::task::JoinSet::new();
    let bound = bound_ports(&listeners)?;
    let meters: Vec<PortMeter> = listeners
        .iter()
        .filter(|(_, l)| l.is_some())
        .map(|(name, _)| PortMeter::new(name).with_faults(faults.clone()))
        .collect();
    for (name, listener) in listeners {
        let (Some(listener), Some(meter)) =
            (listener, meters.iter().find(|m| m.name() == name).cloned())
        else {
            continue;
        };
        let (backend, token) = (backend.clone(), token.clone());
        let (all, one, callers) = (meters.clone(), meter.clone(), callers.clone());
        let page = page.clone();
        match name {
            "primary" => {
                let hub = hub.clone();
                start_port(&mut services, listener, &meter, move |listener| {
                    let (backend, hub) = (backend.clone(), hub.clone());
                    primary::serve(listener, backend, hub, one.clone(), token.clone())
                })?;
            }
            "interpreter" => start_port(&mut services, listener, &meter, move |listener| {
                interpreter::serve(listener, backend.clone(), one.clone(), token.clone())
            })?,
            "http" => start_port(&mut services, listener, &meter, move |listener| {
                let pages = HttpService::of(backend.clone(), all.clone()).with_page(page.clone());
                http::serve(listener, pages, one.clone(), callers.clone(), token.clone())
            })?,
            "modbus" => {
                let (fieldbus, robot) = (fieldbus.clone(), controller.robot().clone());
                start_port(&mut services, listener, &meter, move |listener| {
                    let (fieldbus, robot) = (fieldbus.clone(), robot.clone());
                    modbus::serve(listener, fieldbus, robot, one.clone(), token.clone())
                })?;
            }
            "rtsi" => start_port(&mut services, listener, &meter, move |listener| {
                rtsi::serve(listener, backend.clone(), one.clone(), token.clone())
            })?,
            "foxglove" => {
                let (viewer, feed) = (controller.viewer(), host.feed().clone());
                let (log, world) = (controller.log_lines(), controller.world().cloned());
                start_port(&mut services, listener, &meter, move |listener| {
                    let view = foxglove::FoxgloveSource {
                        viewer: viewer.clone(),
                        world: world.as_ref().map(CellWorld::watch_scene),
                        samples: feed.subscribe(),
                        log: log.subscribe(),
                    };
                    foxglove::serve(listener, view, one.clone(), callers.clone(), token.clone())
                })?;
            }
            "dashboard" => start_port(&mut services, listener, &meter, move |listener| {
                dashboard::serve(listener, backend.clone(), one.clone(), token.clone())
            })?,
            "state" => {
                let hub = hub.clone();
                start_port(&mut services, listener, &meter, move |listener| {
                    let (backend, hub) = (backend.clone(), hub.clone());
                    state::serve(listener, backend, hub, one.clone(), token.clone())
                })?;
            }
            "query" => start_port(&mut services, listener, &meter, move |listener| {
                query::serve(listener, backend.clone(), one.clone(), token.clone())
            })?,
            "tool-serial" => {
                let fieldbus = fieldbus.clone();
                start_port(&mut services, listener, &meter, move |listener| {
                    tool_serial::serve(listener, fieldbus.clone(), one.clone(), token.clone())
                })?;
            }
            other => unreachable!("{other} is no entry of PortSettings::list"),
        }
    }
    for (name, port) in &bound {
        if let Some(port) = port {
            tracing::info!("{name} on {}:{port}", config.bind);
        }
    }
    for (port, slaves) in controller.tcp_grippers() {
        let (port, slaves) = (*port, Arc::new(slaves.clone()));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await;
        let listener = listener.map_err(|source| ServeError::Grippers { port, source })?;
        let meter = PortMeter::new("gripper").with_faults(faults.clone());
        let (one, token) = (meter.clone(), token.clone());
        start_port(&mut services, listener, &meter, move |listener| {
            gripper::serve(listener, slaves.clone(), one.clone(), token.clone())
        })?;
        tracing::info!("grippers on {}:{port}", Ipv4Addr::LOCALHOST);
    }
    if let Some(address) = page_address(config.bind, &bound) {
        crate::language::say(&text!(
            "the pendant page: {address}",
            "示教器页面：{address}"
        ));
    }
    if let Some(path) = controller.recording_path() {
        tracing::info!("recording into {}", path.display());
    }
    if let Some(path) = &config.ready_file {
        ready_file::write(path, std::process::id(), &bound).map_err(|source| {
            ServeError::ReadyFile {
                path: path.clone(),
                source,
            }
        })?;
    }

    let node = match &config.ros2 {
        Some(ros2) => Some(start_node(config, ros2, &backend, faults, &token)?),
        None => None,
    };

    tokio::select! {
        () = shutdown.token().cancelled() => {}
        () = token.cancelled() => {}
        () = faults.wait_fatal() => {
            if let Some(fault) = faults.fatal() {
                controller.announce_fault(fault);
            }
            tokio::select! {
                () = shutdown.token().cancelled() => {}
                () = tokio::time::sleep(LAST_WORDS) => {}
            }
            shutdown.begin(CommandStatus::Fault);
        }
    }
    lifetime.shut_down();
    if !lifetime.reboots() {
        // By a client; after a signal it has begun.
        shutdown.begin(CommandStatus::Success);
    }
    controller.supervisor().stop();
    while services.join_next().await.is_some() {}
    if let Some(node) = node {
        // It has said goodbye to its peers then. A fault of its own was told where it came.
        let _ = node.await;
    }
    forwarding.abort();
    let reboots = lifetime.reboots();
    Ok(PortService { reboots, backend })
}
