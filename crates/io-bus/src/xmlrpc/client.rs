//! One XML-RPC server over HTTP/1.1; the connection is kept between calls. Needs a tokio runtime with `LocalSet`.
//!
//! A call moves something out there, so it is sent once. A kept connection is looked at before it is used again, and a
//! call goes out on another one only while nothing of it has left. After that an error says that nobody knows.

use std::io::ErrorKind;
use std::mem::MaybeUninit;
use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::client::conn::http1::{SendRequest, handshake};
use hyper::{Request, Response, StatusCode, header};
use hyper_util::rt::TokioIo;
use messages::Localized;
use socket2::Socket;
use supervision::{ThreadRole, ThreadSupervisor};
use thiserror::Error;
use tokio::sync::Mutex;
use tokio::time::timeout;

use crate::link::{PeerStream, SimulatedPeers};

use super::codec::{InvalidXmlRpc, RpcFault, RpcValue, decode_response, encode_call};

/// How long a call may take in all (INTERFACES: an RPC call without an answer ends after 10 s).
pub const CALL_TIME: Duration = Duration::from_secs(10);
/// Largest answer.
const ANSWER_BYTES_MAX: usize = 8 << 20;

/// Where a server is: `ip:port`, which means the path /RPC2, or `http://ip:port/path`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RpcUrl {
    authority: String,
    path: String,
}

/// A text that is no address of a server.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[error("{0:?} is no address; allowed are \"ip:port\" and \"http://ip:port/path\"")]
#[zh("{0:?} 不是地址；允许 \"ip:port\" 和 \"http://ip:port/path\"")]
pub struct InvalidRpcUrl(String);

impl std::str::FromStr for RpcUrl {
    type Err = InvalidRpcUrl;

    fn from_str(text: &str) -> Result<Self, InvalidRpcUrl> {
        let wrong = || InvalidRpcUrl(text.to_owned());
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

impl RpcUrl {
    /// Whom to connect to.
    pub fn host_and_port(&self) -> (&str, u16) {
        let (host, port) = self
            .authority
            .rsplit_once(':')
            .unwrap_or((&self.authority, ""));
        // A port that is none was refused when the text was read.
        let host = host.trim_start_matches('[').trim_end_matches(']');
        (host, port.parse().unwrap_or_default())
    }
}

/// A reason why a call has no result.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RpcError {
    /// The server's own error.
    #[error(transparent)]
    Fault(#[from] RpcFault),
    /// The answer cannot be understood.
    #[error(transparent)]
    NotXmlRpc(#[from] InvalidXmlRpc),
    /// No connection.
    #[error("cannot connect to {address}: {source}")]
    #[zh("无法连接 {address}：{source}")]
    Connect {
        /// Host and port.
        address: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The connection broke before anything of the call was sent.
    #[error("the connection to {address} failed before the call was sent: {reason}")]
    #[zh("在发送调用之前与 {address} 的连接失败：{reason}")]
    NotSent {
        /// Host and port.
        address: String,
        /// What went wrong with the connection.
        reason: String,
    },
    /// The connection broke after the call was sent, or what came is no HTTP.
    #[error(
        "the connection to {address} failed: {reason}; the call may have been executed, it is not sent again"
    )]
    #[zh("与 {address} 的连接失败：{reason}；调用可能已执行，不再发送")]
    Unanswered {
        /// Host and port.
        address: String,
        /// What went wrong with the connection or the answer.
        reason: String,
    },
    /// Another status than 200.
    #[error("{address} answered with HTTP status {status}")]
    #[zh("{address} 以 HTTP 状态 {status} 应答")]
    Status {
        /// Host and port.
        address: String,
        /// The status.
        status: StatusCode,
    },
    /// No answer in time.
    #[error(
        "{address} did not answer within {} s; the call may have been executed",
        CALL_TIME.as_secs()
    )]
    #[zh("{address} 在 {} s 内没有应答；调用可能已执行", CALL_TIME.as_secs())]
    NoAnswer {
        /// Host and port.
        address: String,
    },
}

/// A server to call.
pub struct RpcClient {
    url: RpcUrl,
    stand_ins: Option<Arc<dyn SimulatedPeers>>,
    connection: Mutex<Option<HttpConnection>>,
}

/// An open connection.
struct HttpConnection {
    sender: SendRequest<Full<Bytes>>,
    /// The connection's socket, kept to see whether the server has closed it or sent something.
    socket: Socket,
}

/// What became of a call that has no answer.
enum SendFailure {
    /// Nothing of the request was sent; it comes back so that it can be sent over a new connection.
    NotSent(Box<Request<Full<Bytes>>>, String),
    /// The request was sent, in part at least.
    Unanswered(String),
}

impl HttpConnection {
    /// Whether the server still holds its end, and has said nothing unasked.
    fn is_reusable(&self) -> bool {
        let seen = self.socket.peek(&mut [MaybeUninit::uninit()]);
        !self.sender.is_closed() && seen.is_err_and(|error| error.kind() == ErrorKind::WouldBlock)
    }

    async fn send(
        &mut self,
        request: Request<Full<Bytes>>,
    ) -> Result<Response<Incoming>, SendFailure> {
        if let Err(error) = self.sender.ready().await {
            return Err(SendFailure::NotSent(Box::new(request), error.to_string()));
        }
        self.sender
            .try_send_request(request)
            .await
            .map_err(|mut failed| match failed.take_message() {
                Some(request) => {
                    SendFailure::NotSent(Box::new(request), failed.error().to_string())
                }
                None => SendFailure::Unanswered(failed.error().to_string()),
            })
    }
}

impl RpcClient {
    /// Connects at the first call.
    pub fn new(url: RpcUrl) -> Self {
        Self {
            url,
            stand_ins: None,
            connection: Mutex::default(),
        }
    }

    /// This client with stand-ins, which are asked first: a server that one of them plays is not called over the
    /// network.
    pub fn with_simulated_peers(self, stand_ins: Option<Arc<dyn SimulatedPeers>>) -> Self {
        Self { stand_ins, ..self }
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
        let unanswered = |reason: String| RpcError::Unanswered {
            address: self.url.authority.clone(),
            reason,
        };
        let mut kept = self.connection.lock().await;
        let request = self.request(body).map_err(|reason| self.not_sent(reason))?;
        // Taken out: a call that is given up half-way leaves no connection with an answer on its way.
        let (connection, response) = match kept.take().filter(HttpConnection::is_reusable) {
            Some(mut connection) => match connection.send(request).await {
                Ok(response) => (connection, response),
                // The server has closed it just now, and none of the call has left.
                Err(SendFailure::NotSent(request, _)) => {
                    self.send_on_new_connection(*request).await?
                }
                Err(SendFailure::Unanswered(reason)) => return Err(unanswered(reason)),
            },
            None => self.send_on_new_connection(request).await?,
        };
        let status = response.status();
        let answer = Limited::new(response.into_body(), ANSWER_BYTES_MAX)
            .collect()
            .await;
        let answer = answer
            .map_err(|error| unanswered(error.to_string()))?
            .to_bytes();
        if status != StatusCode::OK {
            let address = self.url.authority.clone();
            return Err(RpcError::Status { address, status });
        }
        *kept = Some(connection);
        Ok(String::from_utf8_lossy(&answer).into_owned())
    }

    async fn send_on_new_connection(
        &self,
        request: Request<Full<Bytes>>,
    ) -> Result<(HttpConnection, Response<Incoming>), RpcError> {
        let mut connection = self.connect().await?;
        match connection.send(request).await {
            Ok(response) => Ok((connection, response)),
            Err(SendFailure::NotSent(_, reason)) => Err(self.not_sent(reason)),
            Err(SendFailure::Unanswered(reason)) => Err(RpcError::Unanswered {
                address: self.url.authority.clone(),
                reason,
            }),
        }
    }

    fn not_sent(&self, reason: String) -> RpcError {
        RpcError::NotSent {
            address: self.url.authority.clone(),
            reason,
        }
    }

    fn request(&self, body: Bytes) -> Result<Request<Full<Bytes>>, String> {
        Request::post(self.url.path.as_str())
            .header(header::HOST, self.url.authority.as_str())
            .header(header::CONTENT_TYPE, "text/xml")
            .header(header::USER_AGENT, "eliteserver")
            .body(Full::new(body))
            .map_err(|error| error.to_string())
    }

    async fn connect(&self) -> Result<HttpConnection, RpcError> {
        let failed = |source| RpcError::Connect {
            address: self.url.authority.clone(),
            source,
        };
        let (host, port) = self.url.host_and_port();
        let stream = PeerStream::open(host, port, self.stand_ins.as_ref())
            .await
            .map_err(failed)?;
        let socket = stream.socket().try_clone().map_err(failed)?;
        let (sender, connection) = handshake(TokioIo::new(stream))
            .await
            .map_err(|error| self.not_sent(error.to_string()))?;
        // An error that ends the connection shows at the next call.
        let faults = ThreadSupervisor::default();
        drop(
            faults.spawn(ThreadRole::Service, "rpc connection", async move {
                drop(connection.await);
            }),
        );
        Ok(HttpConnection { sender, socket })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::TcpListener;

    #[test]
    fn both_forms_of_addresses_are_taken() {
        let url = |text: &str| text.parse::<RpcUrl>().map(|url| (url.authority, url.path));
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
                    let body = "<methodResponse><params><param><value><int>7</int></value></param></params>\
                                </methodResponse>";
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

    const SEVEN: &str = "<methodResponse><params><param><value><int>7</int></value></param></params></methodResponse>";

    /// How a server treats one call.
    #[derive(Clone, Copy, Debug)]
    enum Treat {
        Answer,
        /// Answers, then closes the connection without having said so.
        AnswerAndClose,
        /// Executes it and goes away.
        CloseUnanswered,
        /// Executes it, begins an answer and goes away.
        CloseInTheAnswer,
        /// Executes it and resets the connection.
        Reset,
    }

    /// A server that treats its calls as told and counts those it has read whole.
    fn server(listener: TcpListener, treats: Vec<Treat>) -> std::rc::Rc<std::cell::Cell<usize>> {
        let executed = std::rc::Rc::new(std::cell::Cell::new(0));
        let count = executed.clone();
        tokio::task::spawn_local(async move {
            let mut treats = treats.into_iter();
            loop {
                let (mut stream, _) = listener.accept().await.unwrap();
                loop {
                    let mut request = Vec::new();
                    while !request.ends_with(b"</methodCall>") {
                        match stream.read_u8().await {
                            Ok(byte) => request.push(byte),
                            Err(_) => break,
                        }
                    }
                    if !request.ends_with(b"</methodCall>") {
                        break;
                    }
                    count.set(count.get() + 1);
                    let length = SEVEN.len();
                    let head = format!("HTTP/1.1 200 OK\r\nContent-Length: {length}\r\n\r\n");
                    match treats.next().unwrap_or(Treat::Answer) {
                        Treat::Answer => {
                            let answer = format!("{head}{SEVEN}");
                            stream.write_all(answer.as_bytes()).await.unwrap();
                        }
                        Treat::AnswerAndClose => {
                            let answer = format!("{head}{SEVEN}");
                            stream.write_all(answer.as_bytes()).await.unwrap();
                            break;
                        }
                        Treat::CloseUnanswered => break,
                        Treat::CloseInTheAnswer => {
                            let answer = format!("{head}{}", &SEVEN[..20]);
                            stream.write_all(answer.as_bytes()).await.unwrap();
                            break;
                        }
                        Treat::Reset => {
                            let linger = Some(Duration::ZERO);
                            socket2::SockRef::from(&stream).set_linger(linger).unwrap();
                            break;
                        }
                    }
                }
            }
        });
        executed
    }

    #[tokio::test]
    async fn a_call_is_executed_once_whatever_becomes_of_the_connection() {
        use Treat::*;
        for (treats, answered) in [
            (vec![CloseUnanswered], [false, true, true]),
            (vec![Answer, CloseUnanswered], [true, false, true]),
            (vec![Answer, CloseInTheAnswer], [true, false, true]),
            (vec![Answer, Reset], [true, false, true]),
            (vec![Answer, Answer, Reset], [true, true, false]),
            (vec![AnswerAndClose, CloseUnanswered], [true, false, true]),
            (vec![AnswerAndClose; 3], [true, true, true]),
        ] {
            tokio::task::LocalSet::new()
                .run_until(async {
                    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
                    let url = listener.local_addr().unwrap().to_string();
                    let executed = server(listener, treats.clone());
                    let client = RpcClient::new(url.parse().unwrap());
                    for (i, answered) in answered.into_iter().enumerate() {
                        match client.call("step", &[]).await {
                            Ok(value) => assert_eq!((value, answered), (RpcValue::Int(7), true)),
                            Err(error) => {
                                assert!(!answered, "{treats:?} call {i}: {error}");
                                let text = error.to_string();
                                assert!(text.contains("may have been executed"), "{text}");
                            }
                        }
                        assert_eq!(executed.get(), i + 1, "{treats:?}");
                    }
                })
                .await;
        }
    }

    #[tokio::test]
    async fn a_server_that_hangs_up_at_once_has_executed_nothing_and_is_not_called_again() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = listener.local_addr().unwrap().to_string();
        let accepted = tokio::spawn(async move {
            let mut accepted = 0;
            while let Ok(Ok((stream, _))) =
                tokio::time::timeout(Duration::from_millis(300), listener.accept()).await
            {
                accepted += 1;
                drop(stream);
            }
            accepted
        });
        let client = RpcClient::new(url.parse().unwrap());
        assert!(client.call("step", &[]).await.is_err());
        assert_eq!(accepted.await.unwrap(), 1);
    }
}
