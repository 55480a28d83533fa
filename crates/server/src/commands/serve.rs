//! `eliteserver serve`: the controller with its ports, until SIGINT or SIGTERM.

use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;

use thiserror::Error;
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio_util::sync::CancellationToken;

use crate::announce::Console;
use crate::backend::{Backend, Lifetime};
use crate::config::{PortSettings, ServeConfig};
use crate::controller::{Controller, StartError};
use crate::options::{PortSetting, RecordTarget};
use crate::ports::callers::{Callers, machine_name};
use crate::ports::listen::{BindError, PortMeter, bind};
use crate::ports::{dashboard, foxglove, http, interpreter, modbus, primary, rtsi};
use crate::{ready_file, shutdown};

/// What kept the server from starting.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ServeError {
    /// The controller.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A port.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The ready file.
    #[error("cannot write the ready file {}: {source}", path.display())]
    ReadyFile {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Threads or signals.
    #[error("the operating system refused what a server needs: {0}")]
    System(#[from] std::io::Error),
}

/// Serves until a signal. Exit status 0 when everything was flushed, 1 when the recording was cut short.
///
/// # Errors
/// What kept the server from starting.
pub fn serve(config: &ServeConfig) -> Result<u8, ServeError> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()?;
    let signalled = CancellationToken::new();
    runtime.block_on(async { shutdown::on_signals(signalled.clone()) })?;
    let mut config = config.clone();
    loop {
        let life = live(&runtime, &mut config, &signalled)?;
        if life.status != 0 || !life.reboots {
            return Ok(life.status);
        }
        tracing::info!("rebooting");
    }
}

/// How a life of the server ended.
struct Life {
    status: u8,
    reboots: bool,
}

/// One life, from opening the ports to the last byte of the recording. Ports that were free to choose are kept for the
/// next one.
fn live(
    runtime: &Runtime,
    config: &mut ServeConfig,
    signalled: &CancellationToken,
) -> Result<Life, ServeError> {
    // Ports first: a port in use must not leave an empty recording behind.
    let listeners = runtime.block_on(open_ports(config.bind, &mut config.ports))?;
    let controller = Controller::start(&config.robot, Console::Log, config.powered_off)?;
    let served = runtime.block_on(serve_ports(config, &controller, listeners, signalled));
    // The ports are closed; a program that still runs has been told to stop.
    runtime.block_on(controller.supervisor().ended());
    let flushed = controller.shut_down();
    let reboots = served?;
    if let RecordTarget::File(path) = &config.robot.record {
        // The next life must not write over the recording of this one.
        let folder = path.parent().map(PathBuf::from).unwrap_or_default();
        config.robot.record = RecordTarget::NewFileIn(folder);
    }
    Ok(Life {
        status: u8::from(!flushed),
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

async fn serve_ports(
    config: &ServeConfig,
    controller: &Controller,
    listeners: Listeners,
    signalled: &CancellationToken,
) -> Result<bool, ServeError> {
    let lifetime = Lifetime::default();
    let token = lifetime.token().clone();
    let hub = primary::Hub::default();
    let backend = Arc::new(Backend::new(
        controller,
        config,
        hub.clone(),
        lifetime.clone(),
    ));
    let forwarding = tokio::spawn(crate::backend::forward_messages(
        controller.announcer().subscribe(),
        backend.clone(),
        token.clone(),
    ));

    let image = controller.fieldbus().port_image.clone();
    let callers = Callers::of(
        config.bind,
        machine_name().as_deref(),
        &config.trusted_hosts,
    );
    let mut services = tokio::task::JoinSet::new();
    let bound = bound_ports(&listeners)?;
    let meters: Vec<PortMeter> = listeners
        .iter()
        .filter(|(_, l)| l.is_some())
        .map(|(name, _)| PortMeter::new(name))
        .collect();
    for (name, listener) in listeners {
        let (Some(listener), Some(meter)) =
            (listener, meters.iter().find(|m| m.name() == name).cloned())
        else {
            continue;
        };
        let (backend, token) = (backend.clone(), token.clone());
        match name {
            "primary" => {
                services.spawn(primary::serve(listener, backend, hub.clone(), meter, token))
            }
            "interpreter" => services.spawn(interpreter::serve(listener, backend, meter, token)),
            "http" => {
                let (meters, callers) = (meters.clone(), callers.clone());
                services.spawn(http::serve(
                    listener, backend, meters, meter, callers, token,
                ))
            }
            "modbus" => {
                let robot = controller.robot().clone();
                services.spawn(modbus::serve(listener, image.clone(), robot, meter, token))
            }
            "rtsi" => services.spawn(rtsi::serve(listener, backend, meter, token)),
            "foxglove" => {
                let view = foxglove::View {
                    viewer: controller.viewer(),
                    samples: controller.feed().subscribe(),
                    log: controller.announcer().subscribe_log(),
                };
                services.spawn(foxglove::serve(
                    listener,
                    view,
                    meter,
                    callers.clone(),
                    token,
                ))
            }
            "dashboard" => services.spawn(dashboard::serve(listener, backend, meter, token)),
            other => unreachable!("{other} is no entry of PortSettings::list"),
        };
    }
    for (name, port) in &bound {
        if let Some(port) = port {
            tracing::info!("{name} on {}:{port}", config.bind);
        }
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

    tokio::select! {
        () = signalled.cancelled() => lifetime.shut_down(),
        () = token.cancelled() => {}
    }
    controller.supervisor().stop();
    while services.join_next().await.is_some() {}
    forwarding.abort();
    Ok(lifetime.reboots())
}
