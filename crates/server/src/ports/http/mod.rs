//! The http port: `/healthz`, `/metrics` and `/panel`.
//!
//! Owns routes and limits of the connection; the numbers come from [`Source`], their text form from `metrics`.

pub mod metrics;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use motion_api::RobotState;
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
        .with_state(shared)
}

/// 200 while the control cycle runs; 503 once it has been standing still between two requests. Details as JSON.
async fn healthz<S: Source>(State(shared): State<Arc<Shared<S>>>) -> Response {
    let state = shared.source.state();
    let standing = shared.standing(state.cycle);
    let (code, status) = if standing >= STANDSTILL {
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
