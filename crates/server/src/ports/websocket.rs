//! The change from HTTP to WebSocket (RFC 6455), for every port that makes it: what a client must say, and the answer.
//!
//! Done here and not by axum, so that a connection keeps its place among the clients of its port.

use parking_lot::Mutex;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Request, StatusCode, header};
use axum::response::{IntoResponse, Response};
use hyper::body::Incoming;
use hyper::upgrade::OnUpgrade;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;

/// The connection that becomes a WebSocket, once a request for that was answered.
#[derive(Debug, Default)]
pub struct Upgrade(Mutex<Option<OnUpgrade>>);

impl Upgrade {
    /// Answers a request: with the change, or why not. With `subprotocols` the client must offer one of them.
    pub fn shake_hands(
        &self,
        mut request: Request<Incoming>,
        subprotocols: &[&'static str],
    ) -> Response {
        let (accept, protocol) = match accepted(request.headers(), subprotocols) {
            Ok(accepted) => accepted,
            Err(reason) => return (StatusCode::BAD_REQUEST, format!("{reason}\n")).into_response(),
        };
        *self.0.lock() = Some(hyper::upgrade::on(&mut request));
        let headers = [
            (header::CONNECTION, "Upgrade".to_owned()),
            (header::UPGRADE, "websocket".to_owned()),
            (header::SEC_WEBSOCKET_ACCEPT, accept),
        ];
        let mut response =
            (StatusCode::SWITCHING_PROTOCOLS, headers, Body::empty()).into_response();
        if let Some(protocol) = protocol {
            let protocol = HeaderValue::from_static(protocol);
            response
                .headers_mut()
                .insert(header::SEC_WEBSOCKET_PROTOCOL, protocol);
        }
        response
    }

    /// The connection, if a request for the change was answered with it.
    pub fn take(&self) -> Option<OnUpgrade> {
        self.0.lock().take()
    }
}

/// The answer to the client's key, and the subprotocol that is spoken (RFC 6455, 4.2).
fn accepted(
    headers: &HeaderMap,
    subprotocols: &[&'static str],
) -> Result<(String, Option<&'static str>), String> {
    let has = |name: HeaderName, wanted: &str, exact: bool| {
        let values = headers.get_all(name);
        values.iter().any(|value| {
            let words = value.to_str().unwrap_or_default().split(',').map(str::trim);
            words.into_iter().any(|word| match exact {
                true => word == wanted,
                false => word.eq_ignore_ascii_case(wanted),
            })
        })
    };
    if !has(header::UPGRADE, "websocket", false)
        || !has(header::CONNECTION, "upgrade", false)
        || !has(header::SEC_WEBSOCKET_VERSION, "13", true)
    {
        return Err("this port speaks WebSocket, version 13".to_owned());
    }
    let offered = |protocol: &&&str| has(header::SEC_WEBSOCKET_PROTOCOL, protocol, true);
    let protocol = subprotocols.iter().find(offered).copied();
    if protocol.is_none() && !subprotocols.is_empty() {
        let names = subprotocols.join(" or ");
        return Err(format!("the client must offer the subprotocol {names}"));
    }
    match headers.get(header::SEC_WEBSOCKET_KEY) {
        Some(key) => Ok((derive_accept_key(key.as_bytes()), protocol)),
        None => Err("the header Sec-WebSocket-Key is missing".to_owned()),
    }
}
