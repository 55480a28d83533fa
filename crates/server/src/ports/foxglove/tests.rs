//! The port over real sockets, with the WebSocket client of the same library.

use std::net::SocketAddr;
use std::time::Duration;

use futures_util::{SinkExt as _, StreamExt as _};
use kinematics::RobotModel;
use recorder::LogLevel;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::task::JoinHandle;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{WebSocketStream, client_async};

use super::*;
use crate::ports::allowed_hosts::tests::FOREIGN_HOSTS;
use crate::ports::listen::CLIENTS_MAX;
use crate::ports::rtsi::outputs::tests::sample;

struct Rig {
    address: SocketAddr,
    samples: broadcast::Sender<Arc<Sample>>,
    log: broadcast::Sender<LogLine>,
    meter: PortMeter,
    shutdown: CancellationToken,
    port: JoinHandle<()>,
}

async fn rig() -> Rig {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let (samples, log) = (broadcast::Sender::new(64), broadcast::Sender::new(64));
    let view = FoxgloveSource {
        viewer: ViewerMessages::new(RobotModel::built_in("cs66").unwrap(), Vec::new(), 0),
        world: None,
        samples: samples.subscribe(),
        log: log.subscribe(),
    };
    let (meter, shutdown) = (PortMeter::new("foxglove"), CancellationToken::new());
    let callers = AllowedHosts::of(address.ip(), None, &[]);
    let served = serve(listener, view, meter.clone(), callers, shutdown.clone());
    let port = tokio::spawn(served);
    Rig {
        address,
        samples,
        log,
        meter,
        shutdown,
        port,
    }
}

impl Rig {
    /// A handshake with these further headers.
    async fn connect(
        &self,
        headers: &[(&'static str, &str)],
    ) -> Result<WebSocketStream<TcpStream>, Error> {
        let stream = TcpStream::connect(self.address).await.unwrap();
        let mut request = format!("ws://{}/", self.address)
            .into_client_request()
            .unwrap();
        let own = [("sec-websocket-protocol", protocol::SUBPROTOCOLS[0])];
        for (name, value) in own.iter().chain(headers) {
            request.headers_mut().insert(*name, value.parse().unwrap());
        }
        client_async(request, stream)
            .await
            .map(|(socket, _)| socket)
    }

    /// The status with which a handshake is refused.
    async fn refusal(&self, headers: &[(&'static str, &str)]) -> u16 {
        match self.connect(headers).await {
            Err(Error::Http(response)) => response.status().as_u16(),
            other => panic!("{headers:?}: {other:?}"),
        }
    }
}

async fn text(socket: &mut WebSocketStream<TcpStream>) -> serde_json::Value {
    let message = socket.next().await.unwrap().unwrap();
    serde_json::from_str(message.to_text().unwrap()).unwrap()
}

#[tokio::test]
async fn every_name_of_the_protocol_is_taken_and_given_back() {
    let rig = rig().await;
    for (offered, spoken) in [
        ("foxglove.sdk.v1", "foxglove.sdk.v1"),
        ("foxglove.websocket.v1", "foxglove.websocket.v1"),
        ("foxglove.websocket.v1, foxglove.sdk.v1", "foxglove.sdk.v1"),
        (
            "foxglove.sdk.v2,foxglove.websocket.v1",
            "foxglove.websocket.v1",
        ),
    ] {
        let stream = TcpStream::connect(rig.address).await.unwrap();
        let mut request = format!("ws://{}/", rig.address)
            .into_client_request()
            .unwrap();
        let protocol = offered.parse().unwrap();
        request
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
        let (mut socket, response) = client_async(request, stream).await.unwrap();
        assert_eq!(response.headers()["sec-websocket-protocol"], spoken);
        assert_eq!(text(&mut socket).await["op"], "serverInfo");
    }
    let unknown = [("sec-websocket-protocol", "foxglove.sdk.v2")];
    assert_eq!(rig.refusal(&unknown).await, 400);
}

#[tokio::test]
async fn a_client_is_told_what_there_is_and_shown_what_it_follows() {
    let rig = rig().await;
    let mut socket = rig.connect(&[]).await.unwrap();
    let info = text(&mut socket).await;
    assert_eq!(info["op"], "serverInfo");
    assert_eq!(info["capabilities"], serde_json::json!(["time"]));
    let channels = text(&mut socket).await;
    let topics: Vec<&str> = channels["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|channel| channel["topic"].as_str().unwrap())
        .collect();
    assert_eq!(topics, TOPICS.map(Topic::name));

    let subscribe =
        r#"{"op":"subscribe","subscriptions":[{"id":40,"channelId":1},{"id":60,"channelId":6}]}"#;
    socket.send(Message::text(subscribe)).await.unwrap();
    socket.send(Message::text("stop task")).await.unwrap();
    assert_eq!(text(&mut socket).await["op"], "status");
    rig.samples.send(Arc::new(sample())).unwrap();
    let shown = socket.next().await.unwrap().unwrap().into_data();
    assert_eq!(shown[..5], [1, 40, 0, 0, 0]);
    let cycle = recorder::CycleMessage::decode(&shown[13..]).unwrap();
    assert_eq!(cycle.cycle, sample().state.cycle);
    rig.log
        .send(LogLine {
            time: 1.0,
            level: LogLevel::Info,
            source: "p".to_owned(),
            text: "x".repeat(3 * LOG_BYTES_MAX),
        })
        .unwrap();
    loop {
        let shown = socket.next().await.unwrap().unwrap().into_data();
        if shown[0] == 1 && shown[1] == 60 {
            assert!(shown.len() < LOG_BYTES_MAX + 200, "{}", shown.len());
            break;
        }
    }
    rig.shutdown.cancel();
    tokio::time::timeout(Duration::from_secs(5), rig.port)
        .await
        .unwrap()
        .unwrap();
}

#[tokio::test]
async fn pages_of_others_are_refused_and_viewers_of_this_machine_are_not() {
    let rig = rig().await;
    for origin in ["http://evil.example", "https://app.example", "null"] {
        assert_eq!(rig.refusal(&[("origin", origin)]).await, 403, "{origin}");
    }
    for host in FOREIGN_HOSTS {
        assert_eq!(rig.refusal(&[("host", host)]).await, 403, "{host}");
    }
    assert_eq!(rig.refusal(&[("sec-websocket-protocol", "x")]).await, 400);
    for origin in ["http://localhost:3000", "file://"] {
        rig.connect(&[("origin", origin)]).await.unwrap();
    }
}

#[tokio::test]
async fn what_is_no_handshake_is_answered_with_a_reason() {
    let rig = rig().await;
    for (request, status) in [
        (
            "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
            "400",
        ),
        (
            "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n",
            "403",
        ),
        ("stop task\r\n\r\n", "400"),
    ] {
        let mut stream = TcpStream::connect(rig.address).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut answer = String::new();
        let _ = stream.read_to_string(&mut answer).await;
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {status}")),
            "{answer}"
        );
    }
}

#[tokio::test]
async fn one_client_more_than_the_limit_is_closed_at_once() {
    let rig = rig().await;
    let mut clients = Vec::new();
    for _ in 0..CLIENTS_MAX {
        clients.push(rig.connect(&[]).await.unwrap());
    }
    assert_eq!(rig.meter.clients(), CLIENTS_MAX);
    assert!(rig.connect(&[]).await.is_err());
    drop(clients);
    while rig.meter.clients() > 0 {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    rig.connect(&[]).await.unwrap();
}

#[tokio::test]
async fn a_message_that_is_too_long_ends_the_connection_and_no_other() {
    let rig = rig().await;
    let (mut good, mut bad) = (
        rig.connect(&[]).await.unwrap(),
        rig.connect(&[]).await.unwrap(),
    );
    let long = "x".repeat(protocol::MESSAGE_BYTES_MAX + 1);
    let _ = bad.send(Message::text(long)).await;
    while let Some(Ok(_)) = bad.next().await {}
    assert_eq!(text(&mut good).await["op"], "serverInfo");
}
