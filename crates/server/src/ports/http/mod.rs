//! The http port: `/healthz`, `/metrics`, `/panel`, and `/api` for inputs and outputs.
//!
//! Owns the routes; the numbers come from [`HttpBackend`], their text form from `metrics`, the limits of a connection
//! and who may ask at all from `connection`.

pub mod connection;
pub mod cross_site;
pub mod io;
pub mod metrics;
pub mod page;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::body::to_bytes;
use axum::extract::{Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use messages::{Localized, Text, text};
use motion_api::{RegisterImages, RobotState};
use parking_lot::Mutex;
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::ports::allowed_hosts::AllowedHosts;
use crate::ports::description::TaskStatus;
use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::{Peer, PortProtocol};
use crate::ports::websocket::Upgrade;
use metrics::{Figures, Measurements, render};
use page::{LiveEndpoint, Page, PageBackend};

/// Largest body of a request, bytes: several times what all inputs take.
const BODY_BYTES_MAX: usize = 64 * 1024;

/// A client has so long for the body of a request.
const BODY_TIMEOUT: Duration = Duration::from_secs(5);

/// Inputs are set when a cycle has begun; whoever sets them waits no longer than this for one.
const TAKEN_WITHIN: Duration = Duration::from_millis(500);
/// Time between two looks at the cycle's number.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// With the cycle counter standing still for this long the controller is not well.
const STANDSTILL: Duration = Duration::from_secs(1);

/// What this port asks of the controller.
pub trait HttpBackend: Send + Sync + 'static {
    /// The latest snapshot.
    fn state(&self) -> RobotState;
    /// What the main task is doing.
    fn task_status(&self) -> TaskStatus;
    /// What people see of the program that runs: state, popups, flags, global variables.
    fn panel(&self) -> Value;
    /// What the controller counts.
    fn figures(&self) -> Figures;
    /// The fault of ours after which no cycle runs any more.
    fn fault(&self) -> Option<String> {
        None
    }
    /// The registers as they are now.
    fn registers(&self) -> RegisterImages;
    /// Sets inputs, as if somebody had wired them, all or none; must not wait.
    ///
    /// # Errors
    /// [`SetInputsError`]: nothing was changed.
    fn set_inputs(&self, changes: &io::IoChanges) -> Result<(), SetInputsError>;
}

/// A reason why inputs were not set, told in a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SetInputsError {
    /// Inputs can never be set here, for this reason.
    ReadOnly(Text),
    /// Inputs cannot be set now, for this reason.
    Unavailable(Text),
}

/// What the handlers share.
struct HttpContext<S> {
    source: Arc<S>,
    ports: Vec<PortMeter>,
    /// The cycle counter when it was last seen to move, and when that was.
    pulse: Mutex<Option<(u64, Instant)>>,
}

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    pages: HttpService,
    meter: PortMeter,
    callers: AllowedHosts,
    shutdown: CancellationToken,
) {
    let callers = Arc::new(callers);
    serve_port(
        listener,
        PortProtocol::Http,
        meter,
        shutdown,
        |peer, _, shutdown| {
            let (pages, callers) = (pages.clone(), Arc::clone(&callers));
            async move { pages.serve(peer, &callers, &shutdown).await }
        },
    )
    .await;
}

/// Every page, for any number of clients.
#[derive(Clone)]
pub struct HttpService {
    router: Router,
    live: Option<Arc<dyn LiveEndpoint>>,
}

impl HttpService {
    /// The pages of a controller; `ports` are those whose clients are counted.
    pub fn of<S: HttpBackend>(source: Arc<S>, ports: Vec<PortMeter>) -> Self {
        Self {
            router: router(source, ports),
            live: None,
        }
    }

    /// Other pages than those of a controller.
    pub(crate) const fn over(router: Router) -> Self {
        Self { router, live: None }
    }

    /// This service with the pendant page.
    pub fn with_page<C: PageBackend>(self, page: Arc<Page<C>>) -> Self {
        Self {
            router: self.router.merge(page::router(Arc::clone(&page))),
            live: Some(page),
        }
    }

    /// Answers the requests of one client, over any stream, until it leaves, is too slow, or `shutdown`.
    pub async fn serve<T>(
        &self,
        peer: Peer<T>,
        callers: &AllowedHosts,
        shutdown: &CancellationToken,
    ) where
        T: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        let service = TowerToHyperService::new(self.router.clone());
        let upgrade = Upgrade::default();
        let debugs = AtomicBool::new(false);
        connection::serve(peer, callers, shutdown, |request| {
            let path = request.uri().path();
            let is_debug =
                path == page::DEBUG_PATH && request.headers().contains_key(header::UPGRADE);
            debugs.store(is_debug, Ordering::Relaxed);
            let is_live = self.live.is_some() && (is_debug || path == page::LIVE_PATH);
            let answering = match is_live {
                true => Err(page::shake_hands(request, &upgrade)),
                false => Ok(service.call(request)),
            };
            async move {
                match answering {
                    Ok(answering) => {
                        let Ok(response) = answering.await;
                        response
                    }
                    Err(response) => response,
                }
            }
        })
        .await;
        // The connection keeps its place among the clients of the port.
        if let (Some(upgrade), Some(live)) = (upgrade.take(), &self.live) {
            match debugs.load(Ordering::Relaxed) {
                true => live.debug(upgrade, shutdown).await,
                false => live.attend(upgrade, shutdown).await,
            }
        }
    }
}

impl<S> HttpContext<S> {
    /// For how long the cycle counter has been seen to stand at `cycle`.
    fn standing(&self, cycle: u64) -> Duration {
        let now = Instant::now();
        let mut pulse = self.pulse.lock();
        match *pulse {
            Some((last, since)) if last == cycle => now.duration_since(since),
            _ => {
                *pulse = Some((cycle, now));
                Duration::ZERO
            }
        }
    }
}

fn router<S: HttpBackend>(source: Arc<S>, ports: Vec<PortMeter>) -> Router {
    let shared = Arc::new(HttpContext {
        source,
        ports,
        pulse: Mutex::default(),
    });
    Router::new()
        .route("/healthz", get(healthz::<S>))
        .route("/metrics", get(metrics_page::<S>))
        .route("/panel", get(panel_page::<S>))
        .route("/api/io", get(io_page::<S>))
        .route("/api/inputs", post(set_inputs::<S>))
        .with_state(shared)
}

/// 200 while the control cycle runs; 503 once it has been standing still between two requests. Details as JSON.
async fn healthz<S: HttpBackend>(State(shared): State<Arc<HttpContext<S>>>) -> Response {
    let state = shared.source.state();
    let standing = shared.standing(state.cycle);
    let fault = shared.source.fault();
    let (code, status) = if fault.is_some() {
        (StatusCode::SERVICE_UNAVAILABLE, "stopped by a fault")
    } else if standing >= STANDSTILL {
        (StatusCode::SERVICE_UNAVAILABLE, "standing still")
    } else {
        (StatusCode::OK, "ok")
    };
    let recording = shared.source.figures().recording;
    let clients: serde_json::Map<String, Value> = shared
        .ports
        .iter()
        .map(|port| (port.name().to_owned(), port.clients().into()))
        .collect();
    let details = serde_json::json!({
        "status": status,
        "fault": fault,
        "cycle": state.cycle,
        "standing_for_secs": standing.as_secs_f64(),
        "time_secs": state.time,
        "robot_mode": state.robot_mode.number(),
        "safety_mode": state.safety_mode.number(),
        "task": shared.source.task_status().name(),
        "recording": match recording {
            None => "off",
            Some(figures) if figures.has_failed => "stopped",
            Some(_) => "active",
        },
        "records_lost": state.records_lost,
        "clients": clients,
    });
    let json = [(header::CONTENT_TYPE, "application/json")];
    (code, json, format!("{details}\n")).into_response()
}

/// What people see of the program that runs, as JSON.
async fn panel_page<S: HttpBackend>(State(shared): State<Arc<HttpContext<S>>>) -> Response {
    let text = format!("{}\n", shared.source.panel());
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

/// Every input and output, as JSON.
async fn io_page<S: HttpBackend>(State(shared): State<Arc<HttpContext<S>>>) -> Response {
    let page = io::describe(&shared.source.state(), &shared.source.registers());
    answer(StatusCode::OK, &page)
}

/// Sets inputs: an object from names to values, all of it or nothing.
async fn set_inputs<S: HttpBackend>(
    State(shared): State<Arc<HttpContext<S>>>,
    request: Request,
) -> Response {
    let (head, body) = request.into_parts();
    if let Err(turned_away) = cross_site::check(&head.headers) {
        return refuse(turned_away.status(), &turned_away);
    }
    let body = match tokio::time::timeout(BODY_TIMEOUT, to_bytes(body, BODY_BYTES_MAX)).await {
        Ok(Ok(body)) => body,
        Ok(Err(_too_long_or_broken)) => {
            let text = text!(
                "the body is cut off or longer than {BODY_BYTES_MAX} bytes",
                "正文不完整或超过 {BODY_BYTES_MAX} 字节"
            );
            return refuse(StatusCode::PAYLOAD_TOO_LARGE, &text);
        }
        Err(_elapsed) => {
            let secs = BODY_TIMEOUT.as_secs();
            let text = text!(
                "the body was not complete after {secs} s",
                "{secs} s 后正文仍不完整"
            );
            return refuse(StatusCode::REQUEST_TIMEOUT, &text);
        }
    };
    let state = shared.source.state();
    let changes = match io::read(&body, &state.io_config) {
        Ok(changes) => changes,
        Err(error) => return refuse(StatusCode::UNPROCESSABLE_ENTITY, &error),
    };
    match shared.source.set_inputs(&changes) {
        Ok(()) => {}
        Err(SetInputsError::ReadOnly(reason)) => return refuse(StatusCode::CONFLICT, &reason),
        Err(SetInputsError::Unavailable(reason)) => {
            return refuse(StatusCode::SERVICE_UNAVAILABLE, &reason);
        }
    }
    if is_taken(&*shared.source, state.cycle).await {
        return answer(StatusCode::OK, &json!({"after_cycle": state.cycle}));
    }
    let millis = TAKEN_WITHIN.as_millis();
    let text = text!(
        "the inputs wait for a cycle, and none has begun for {millis} ms; they are set when the next one begins",
        "输入在等待一个周期，而 {millis} ms 内没有周期开始；下一个周期开始时设置"
    );
    refuse(StatusCode::SERVICE_UNAVAILABLE, &text)
}

/// True once a cycle that began after `cycle` has ended; false when none does.
async fn is_taken(source: &impl HttpBackend, cycle: u64) -> bool {
    let patience = Instant::now() + TAKEN_WITHIN;
    while source.state().cycle <= cycle {
        if Instant::now() >= patience {
            return false;
        }
        tokio::time::sleep(LOOK_AGAIN).await;
    }
    true
}

fn answer(status: StatusCode, page: &Value) -> Response {
    let kind = [(header::CONTENT_TYPE, "application/json")];
    (status, kind, format!("{page}\n")).into_response()
}

/// Says why not.
fn refuse(status: StatusCode, reason: &impl Localized) -> Response {
    answer(status, &refusal(reason))
}

/// A refusal as JSON; in both languages where these differ, since each page has its own.
fn refusal(reason: &impl Localized) -> Value {
    let reason = Text::of(reason);
    let mut refusal = json!({"error": reason.english()});
    if let Some(chinese) = reason.other_chinese() {
        refusal["texts"] = json!({"en": reason.english(), "zh": chinese});
    }
    refusal
}

async fn metrics_page<S: HttpBackend>(State(shared): State<Arc<HttpContext<S>>>) -> Response {
    let text = render(&Measurements {
        state: &shared.source.state(),
        task: shared.source.task_status(),
        figures: &shared.source.figures(),
        ports: &shared.ports,
    });
    ([(header::CONTENT_TYPE, metrics::CONTENT_TYPE)], text).into_response()
}

#[cfg(test)]
mod tests;
