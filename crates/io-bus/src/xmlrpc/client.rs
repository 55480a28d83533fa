//! One XML-RPC server over HTTP/1.1; the connection is kept between calls. Needs a tokio runtime with `LocalSet`.

use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::Bytes;
use hyper::client::conn::http1::{SendRequest, handshake};
use hyper::{Request, StatusCode, header};
use hyper_util::rt::TokioIo;
use supervision::{Faults, Kind};
use thiserror::Error;
use tokio::sync::Mutex;
use tokio::time::timeout;

use crate::names;

use super::codec::{Fault, NotXmlRpc, RpcValue, decode_response, encode_call};

/// How long a call may take in all (INTERFACES: an RPC call without an answer ends after 10 s).
pub const CALL_TIME: Duration = Duration::from_secs(10);
/// Largest answer.
const ANSWER_BYTES_MAX: usize = 8 << 20;

/// Where a server is: `ip:port`, which means the path /RPC2, or `http://ip:port/path`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Url {
    authority: String,
    path: String,
}

/// A text that is no address of a server.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0:?} is no address; allowed are \"ip:port\" and \"http://ip:port/path\"")]
pub struct NotAUrl(String);

impl std::str::FromStr for Url {
    type Err = NotAUrl;

    fn from_str(text: &str) -> Result<Self, NotAUrl> {
        let wrong = || NotAUrl(text.to_owned());
        let (rest, is_short) = match text.strip_prefix("http://") {
            Some(rest) => (rest, false),
            None => (text, true),
        };
        let (authority, path) = match rest.split_once('/') {
            Some((authority, path)) => (authority, format!("/{path}")),
            None if is_short => (rest, "/RPC2".to_owned()),
            None => (rest, "/".to_owned()),
        };
        let (host, port) = match authority.rsplit_once(':') {
            Some((host, port)) => (host, port.parse::<u16>().map_err(|_| wrong())?),
            None if is_short => return Err(wrong()),
            None => (authority, 80),
        };
        let is_plain = |c: char| c.is_ascii_graphic();
        if host.is_empty() || port == 0 || !rest.chars().all(is_plain) || host.contains("://") {
            return Err(wrong());
        }
        Ok(Self {
            authority: format!("{host}:{port}"),
            path,
        })
    }
}

/// Why a call has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RpcError {
    /// The server's own error.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// The answer cannot be understood.
    #[error(transparent)]
    NotXmlRpc(#[from] NotXmlRpc),
    /// No connection.
    #[error("cannot connect to {address}: {source}")]
    Connect {
        /// Host and port.
        address: String,
        /// Why.
        source: std::io::Error,
    },
    /// The connection broke, or what came is no HTTP.
    #[error("the connection to {address} failed: {reason}")]
    Http {
        /// Host and port.
        address: String,
        /// Why.
        reason: String,
    },
    /// Another status than 200.
    #[error("{address} answered with HTTP status {status}")]
    Status {
        /// Host and port.
        address: String,
        /// The status.
        status: StatusCode,
    },
    /// No answer in time.
    #[error("{address} did not answer within {} s", CALL_TIME.as_secs())]
    NoAnswer {
        /// Host and port.
        address: String,
    },
}

/// A server to call.
pub struct RpcClient {
    url: Url,
    connection: Mutex<Option<SendRequest<Full<Bytes>>>>,
}

impl RpcClient {
    /// Connects at the first call.
    pub fn new(url: Url) -> Self {
        Self {
            url,
            connection: Mutex::default(),
        }
    }

    /// Calls a method.
    ///
    /// # Errors
    /// [`RpcError`] says what went wrong; a fault of the server is one of them.
    pub async fn call(&self, method: &str, arguments: &[RpcValue]) -> Result<RpcValue, RpcError> {
        let body = Bytes::from(encode_call(method, arguments));
        match timeout(CALL_TIME, self.post(body)).await {
            Ok(answer) => Ok(decode_response(&answer?)??),
            Err(_elapsed) => Err(RpcError::NoAnswer {
                address: self.url.authority.clone(),
            }),
        }
    }

    async fn post(&self, body: Bytes) -> Result<String, RpcError> {
        let address = || self.url.authority.clone();
        let failed = |reason: String| RpcError::Http {
            address: address(),
            reason,
        };
        let mut kept = self.connection.lock().await;
        // A server may close a kept connection just when it is used again: then once more on a new one.
        let reused = kept.take();
        let was_reused = reused.is_some();
        let mut sender = match reused {
            Some(sender) => sender,
            None => self.connect().await?,
        };
        let mut sent = match sender.ready().await {
            Ok(()) => {
                sender
                    .send_request(self.request(body.clone()).map_err(failed)?)
                    .await
            }
            Err(error) => Err(error),
        };
        if was_reused && sent.is_err() {
            sender = self.connect().await?;
            sent = sender
                .send_request(self.request(body).map_err(failed)?)
                .await;
        }
        let response = sent.map_err(|error| failed(error.to_string()))?;
        let status = response.status();
        let answer = Limited::new(response.into_body(), ANSWER_BYTES_MAX)
            .collect()
            .await;
        let answer = answer
            .map_err(|error| failed(error.to_string()))?
            .to_bytes();
        if status != StatusCode::OK {
            let address = address();
            return Err(RpcError::Status { address, status });
        }
        *kept = Some(sender);
        Ok(String::from_utf8_lossy(&answer).into_owned())
    }

    fn request(&self, body: Bytes) -> Result<Request<Full<Bytes>>, String> {
        Request::post(self.url.path.as_str())
            .header(header::HOST, self.url.authority.as_str())
            .header(header::CONTENT_TYPE, "text/xml")
            .header(header::USER_AGENT, "eliteserver")
            .body(Full::new(body))
            .map_err(|error| error.to_string())
    }

    async fn connect(&self) -> Result<SendRequest<Full<Bytes>>, RpcError> {
        let address = || self.url.authority.clone();
        let stream = names::connect_to(&self.url.authority)
            .await
            .map_err(|source| RpcError::Connect {
                address: address(),
                source,
            })?;
        let (sender, connection) =
            handshake(TokioIo::new(stream))
                .await
                .map_err(|error| RpcError::Http {
                    address: address(),
                    reason: error.to_string(),
                })?;
        // Its end shows at the next call.
        let faults = Faults::default();
        drop(faults.spawn(Kind::Service, "rpc connection", async move {
            drop(connection.await);
        }));
        Ok(sender)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::TcpListener;

    #[test]
    fn both_forms_of_addresses_are_taken() {
        let url = |text: &str| text.parse::<Url>().map(|url| (url.authority, url.path));
        let pair = |a: &str, b: &str| Ok((a.to_owned(), b.to_owned()));
        assert_eq!(url("127.0.0.1:5050"), pair("127.0.0.1:5050", "/RPC2"));
        assert_eq!(
            url("http://10.0.0.1:5050/a/b"),
            pair("10.0.0.1:5050", "/a/b")
        );
        assert_eq!(url("http://camera"), pair("camera:80", "/"));
        for wrong in [
            "",
            "127.0.0.1",
            ":5",
            "h:0",
            "h:99999",
            "https://h:1/",
            "http://h :1/",
        ] {
            assert!(url(wrong).is_err(), "{wrong}");
        }
    }

    #[tokio::test]
    async fn a_connection_is_kept_and_opened_anew_when_the_server_has_closed_it() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let served = tokio::spawn(async move {
            let mut connections = 0;
            for answers in [2, 1] {
                let (mut stream, _) = listener.accept().await.unwrap();
                connections += 1;
                for _ in 0..answers {
                    let mut request = Vec::new();
                    while !request.ends_with(b"</methodCall>") {
                        request.push(stream.read_u8().await.unwrap());
                    }
                    let body = "<methodResponse><params><param><value><int>7</int></value></param></params></methodResponse>";
                    let answer = format!(
                        "HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n{body}",
                        body.len()
                    );
                    stream.write_all(answer.as_bytes()).await.unwrap();
                }
            }
            connections
        });
        let client = RpcClient::new(address.to_string().parse().unwrap());
        for _ in 0..3 {
            assert_eq!(
                client.call("m", &[RpcValue::Nil]).await.unwrap(),
                RpcValue::Int(7)
            );
        }
        assert_eq!(served.await.unwrap(), 2);
        let error = client.call("m", &[]).await.unwrap_err().to_string();
        assert!(error.contains(&address.to_string()), "{error}");
    }
}
