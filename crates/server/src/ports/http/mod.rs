//! The http port: `/healthz`, `/metrics`, `/panel`, and `/api` for inputs and outputs.
//!
//! Owns routes and limits of the connection; the numbers come from [`Source`], their text form from `metrics`.

pub mod guard;
pub mod io;
pub mod metrics;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::body::to_bytes;
use axum::extract::{Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use motion_api::{RegisterImages, RobotState};
use serde_json::json;
use tokio::net::TcpListener;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::ports::description::TaskStatus;
use crate::ports::listen::{PortMeter, serve_port};
use metrics::{Figures, Measurements, render};

/// A client has so long for the head of a request; also how long an idle connection is kept.
const HEAD_TIMEOUT: Duration = Duration::from_secs(15);

/// Largest head of a request, bytes.
const HEAD_BYTES_MAX: usize = 16 * 1024;

/// Largest body of a request, bytes: several times what all inputs take.
const BODY_BYTES_MAX: usize = 64 * 1024;

/// A client has so long for the body of a request.
const BODY_TIMEOUT: Duration = Duration::from_secs(5);

/// With the cycle counter standing still for this long the controller is not well.
const STANDSTILL: Duration = Duration::from_secs(1);

/// What this port asks of the controller.
pub trait Source: Send + Sync + 'static {
    /// The latest snapshot.
    fn state(&self) -> RobotState;
    /// What the main task is doing.
    fn task_status(&self) -> TaskStatus;
    /// What people see of the program that runs: state, popups, flags, global variables.
    fn panel(&self) -> serde_json::Value;
    /// What the controller counts.
    fn figures(&self) -> Figures;
    /// The fault of ours after which no cycle runs any more.
    fn fault(&self) -> Option<String> {
        None
    }
    /// The registers as they are now.
    fn registers(&self) -> RegisterImages;
    /// Sets inputs, as if somebody had wired them; must not wait.
    ///
    /// # Errors
    /// A sentence that says why they cannot be set here.
    fn set_inputs(&self, changes: &io::InputChanges) -> Result<(), String>;
}

/// What the handlers share.
struct Shared<S> {
    source: Arc<S>,
    ports: Vec<PortMeter>,
    /// The cycle counter when it was last seen to move, and when that was.
    pulse: Mutex<Option<(u64, Instant)>>,
}

/// Serves the port until `shutdown`; returns when every client is closed. `ports` are those whose clients are counted.
pub async fn serve<S: Source>(
    listener: TcpListener,
    source: Arc<S>,
    ports: Vec<PortMeter>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let app = router(source, ports);
    serve_port(listener, meter, shutdown, |stream, client, shutdown| {
        let service = TowerToHyperService::new(app.clone());
        async move {
            let mut http = http1::Builder::new();
            http.timer(TokioTimer::new())
                .header_read_timeout(HEAD_TIMEOUT)
                .max_buf_size(HEAD_BYTES_MAX);
            let mut connection =
                std::pin::pin!(http.serve_connection(TokioIo::new(stream), service));
            let ended = tokio::select! {
                ended = connection.as_mut() => ended,
                () = shutdown.cancelled() => {
                    connection.as_mut().graceful_shutdown();
                    connection.await
                }
            };
            if let Err(error) = ended {
                tracing::debug!(%client, %error, "http: the connection broke");
            }
        }
    })
    .await;
}

impl<S> Shared<S> {
    /// For how long the cycle counter has been seen to stand at `cycle`.
    fn standing(&self, cycle: u64) -> Duration {
        let now = Instant::now();
        // The value is whole at every moment, so a poisoned lock is as good as any.
        let mut pulse = self.pulse.lock().unwrap_or_else(PoisonError::into_inner);
        match *pulse {
            Some((last, since)) if last == cycle => now.duration_since(since),
            _ => {
                *pulse = Some((cycle, now));
                Duration::ZERO
            }
        }
    }
}

fn router<S: Source>(source: Arc<S>, ports: Vec<PortMeter>) -> Router {
    let shared = Arc::new(Shared {
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
async fn healthz<S: Source>(State(shared): State<Arc<Shared<S>>>) -> Response {
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
    let clients: serde_json::Map<String, serde_json::Value> = shared
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
async fn panel_page<S: Source>(State(shared): State<Arc<Shared<S>>>) -> Response {
    let text = format!("{}\n", shared.source.panel());
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

/// Every input and output, as JSON.
async fn io_page<S: Source>(State(shared): State<Arc<Shared<S>>>) -> Response {
    let page = io::describe(&shared.source.state(), &shared.source.registers());
    answer(StatusCode::OK, &page)
}

/// Sets inputs: an object from names to values, all of it or nothing.
async fn set_inputs<S: Source>(State(shared): State<Arc<Shared<S>>>, request: Request) -> Response {
    let refuse = |status, text: String| answer(status, &json!({"error": text}));
    let (head, body) = request.into_parts();
    if let Err(turned_away) = guard::check(&head.headers) {
        return refuse(turned_away.status(), turned_away.to_string());
    }
    let body = match tokio::time::timeout(BODY_TIMEOUT, to_bytes(body, BODY_BYTES_MAX)).await {
        Ok(Ok(body)) => body,
        Ok(Err(_too_long_or_broken)) => {
            let text = format!("the body is cut off or longer than {BODY_BYTES_MAX} bytes");
            return refuse(StatusCode::PAYLOAD_TOO_LARGE, text);
        }
        Err(_elapsed) => {
            let text = format!(
                "the body was not complete after {} s",
                BODY_TIMEOUT.as_secs()
            );
            return refuse(StatusCode::REQUEST_TIMEOUT, text);
        }
    };
    let state = shared.source.state();
    let changes = match io::read(&body, &state.io_config) {
        Ok(changes) => changes,
        Err(error) => return refuse(StatusCode::UNPROCESSABLE_ENTITY, error.to_string()),
    };
    match shared.source.set_inputs(&changes) {
        Ok(()) => answer(StatusCode::OK, &json!({"after_cycle": state.cycle})),
        Err(reason) => refuse(StatusCode::CONFLICT, reason),
    }
}

fn answer(status: StatusCode, page: &serde_json::Value) -> Response {
    let kind = [(header::CONTENT_TYPE, "application/json")];
    (status, kind, format!("{page}\n")).into_response()
}

async fn metrics_page<S: Source>(State(shared): State<Arc<Shared<S>>>) -> Response {
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
