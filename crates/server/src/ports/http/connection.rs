//! One connection that speaks HTTP, whichever port it came in on: limits of time and size, and who may ask at all.
//!
//! Every request goes through [`AllowedHosts`] before anything else looks at it, so no page can forget to.

use core::convert::Infallible;
use std::future::Future;
use std::time::Duration;

use axum::http::Request;
use axum::response::Response;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_util::sync::CancellationToken;

use super::refuse;
use crate::ports::allowed_hosts::AllowedHosts;
use crate::ports::peer::Peer;

/// A client has so long for the head of a request; also how long an idle connection is kept.
pub const HEAD_TIMEOUT: Duration = Duration::from_secs(15);

/// Largest head of a request, bytes.
pub const HEAD_BYTES_MAX: usize = 16 * 1024;

/// Answers the requests of one client until it leaves, is too slow, or `shutdown`. A connection may become another
/// protocol's; whoever answered the request has it then.
pub async fn serve<S, F>(
    peer: Peer<S>,
    callers: &AllowedHosts,
    shutdown: &CancellationToken,
    answer: impl Fn(Request<Incoming>) -> F,
) where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    F: Future<Output = Response>,
{
    let local = peer.local_ip();
    let service = service_fn(|request: Request<Incoming>| {
        let (head, body) = request.into_parts();
        let answering = callers
            .admit(&head, local)
            .map(|()| answer(Request::from_parts(head, body)));
        async move {
            Ok::<_, Infallible>(match answering {
                Ok(answering) => answering.await,
                Err(turned_away) => {
                    tracing::warn!("http: {turned_away}");
                    refuse(turned_away.status(), &turned_away)
                }
            })
        }
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(HEAD_BYTES_MAX);
    let connection = http.serve_connection(TokioIo::new(peer), service);
    let mut connection = std::pin::pin!(connection.with_upgrades());
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = shutdown.cancelled() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "http: the connection broke");
    }
}
