//! The Foxglove port: the arm as it moves, for the Foxglove app and everything that speaks its WebSocket protocol.
//!
//! Read-only: no client can publish, set parameters or call services here. The topics are those of a recording, with the
//! same schemas. The protocol is the business of the crate `foxglove`; its server listens on a port of its own on the
//! loopback, and clients reach it through this port, which has the limits of every other one: the crate's own door
//! takes any number of clients and cannot be handed a listener.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use foxglove::websocket::{Capability, ChannelView, Client, ServerListener};
use foxglove::{
    ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServerHandle,
};
use prost::Message as _;
use recorder::{LogLevel, Topic, Viewer};
use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::broadcast;
use tokio_util::sync::CancellationToken;

use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::sample::Sample;

/// Topics that clients can follow.
const TOPICS: [Topic; 6] = [
    Topic::Cycle,
    Topic::JointStates,
    Topic::Tf,
    Topic::Tcp,
    Topic::Scene,
    Topic::Log,
];

/// Messages that wait for a client that is behind; one more pushes the oldest out.
const BACKLOG: usize = 1024;

/// A message for people with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLine {
    /// Simulated time, s.
    pub time: f64,
    /// How much it matters.
    pub level: LogLevel,
    /// Who says it.
    pub source: String,
    /// What.
    pub text: String,
}

/// What is shown.
pub struct View {
    /// Makes the messages; knows arm, obstacles and epoch.
    pub viewer: Viewer,
    /// Every cycle.
    pub samples: broadcast::Receiver<Arc<Sample>>,
    /// Every message for people.
    pub log: broadcast::Receiver<LogLine>,
}

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    view: View,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let mut server = match Server::start().await {
        Ok(server) => server,
        Err(error) => {
            tracing::error!("no live data for Foxglove: {error}");
            return;
        }
    };
    let inner = SocketAddr::from((Ipv4Addr::LOCALHOST, server.handle.port()));
    let clients = serve_port(listener, meter, shutdown.clone(), |stream, _, shutdown| {
        pass_on(stream, inner, shutdown)
    });
    tokio::join!(clients, server.feed(view, &shutdown));
    server.handle.stop().wait().await;
}

/// One client's bytes to the server and back.
async fn pass_on(mut client: TcpStream, inner: SocketAddr, shutdown: CancellationToken) {
    let mut server = match TcpStream::connect(inner).await {
        Ok(server) => server,
        Err(error) => {
            tracing::warn!(%error, "foxglove: the client could not be connected");
            return;
        }
    };
    // Messages are small and a screen waits for them; without the option they only come later.
    let _ = server.set_nodelay(true);
    // How a connection breaks matters to neither side.
    let _ = shutdown
        .run_until_cancelled(copy_bidirectional(&mut client, &mut server))
        .await;
}

/// The crate's server with its channels.
struct Server {
    /// Server and channels hold it only weakly.
    _context: Arc<Context>,
    handle: WebSocketServerHandle,
    channels: [Arc<RawChannel>; TOPICS.len()],
    /// Somebody has begun to follow a topic.
    newcomer: Arc<AtomicBool>,
    cycle: recorder::Cycle,
    encoded: Vec<u8>,
}

impl Server {
    async fn start() -> Result<Self, foxglove::FoxgloveError> {
        // A context of its own: what else in this process uses the crate is not shown.
        let context = Context::new();
        let newcomer = Arc::new(AtomicBool::new(false));
        let mut channels = Vec::with_capacity(TOPICS.len());
        for topic in TOPICS {
            let schema = topic.schema();
            let channel = ChannelBuilder::new(topic.name())
                .context(&context)
                .message_encoding(topic.message_encoding())
                .schema(Schema {
                    name: schema.name,
                    encoding: schema.encoding.to_owned(),
                    data: schema.data,
                })
                .build_raw()?;
            channels.push(channel);
        }
        let handle = context
            .websocket_server()
            .name("eliteserver")
            .bind(Ipv4Addr::LOCALHOST.to_string(), 0)
            // Viewers follow simulated time.
            .capabilities([Capability::Time])
            .message_backlog_size(BACKLOG)
            .listener(Arc::new(Newcomers(newcomer.clone())))
            .start()
            .await?;
        // One channel a topic was pushed above.
        let channels: [Arc<RawChannel>; TOPICS.len()] = channels
            .try_into()
            .unwrap_or_else(|_| unreachable!("one channel a topic"));
        Ok(Self {
            _context: context,
            handle,
            channels,
            newcomer,
            cycle: recorder::Cycle::default(),
            encoded: Vec::new(),
        })
    }

    /// Shows what happens until `shutdown`.
    async fn feed(&mut self, mut view: View, shutdown: &CancellationToken) {
        loop {
            tokio::select! {
                () = shutdown.cancelled() => return,
                sample = view.samples.recv() => match sample {
                    Ok(sample) => self.show(&mut view.viewer, &sample),
                    // A screen does not miss single cycles.
                    Err(broadcast::error::RecvError::Lagged(_)) => {}
                    Err(broadcast::error::RecvError::Closed) => return,
                },
                line = view.log.recv() => match line {
                    Ok(line) => self.log(&mut view.viewer, &line),
                    Err(broadcast::error::RecvError::Lagged(missed)) => {
                        tracing::warn!("foxglove: {missed} messages were not passed on");
                    }
                    Err(broadcast::error::RecvError::Closed) => return,
                },
            }
        }
    }

    fn show(&mut self, viewer: &mut Viewer, sample: &Sample) {
        if !self.channels.iter().any(|channel| channel.has_sinks()) {
            return;
        }
        if self.newcomer.swap(false, Ordering::Relaxed) {
            viewer.draw_scene_next();
        }
        let state = &sample.state;
        let at = viewer.nanos(state.time);
        self.cycle.set(state);
        self.encoded.clear();
        self.cycle.encode_raw(&mut self.encoded);
        self.send(Topic::Cycle, at, &self.encoded);
        let mut shown = false;
        let Ok(()) = viewer.state(state, |topic, message| {
            self.send(topic, at, message);
            shown = true;
            Ok::<(), core::convert::Infallible>(())
        });
        if shown {
            self.handle.broadcast_time(at);
        }
    }

    fn log(&self, viewer: &mut Viewer, line: &LogLine) {
        let at = viewer.nanos(line.time);
        let message = viewer.log(line.time, line.level, &line.source, &line.text);
        self.send(Topic::Log, at, message);
    }

    fn send(&self, topic: Topic, at: u64, message: &[u8]) {
        let place = TOPICS.iter().position(|one| *one == topic);
        // A topic that is not shown here is nobody's.
        if let Some(channel) = place.map(|place| &self.channels[place]) {
            channel.log_with_meta(message, PartialMetadata::with_log_time(at));
        }
    }
}

/// Notes that somebody has come, who is to see the scene.
struct Newcomers(Arc<AtomicBool>);

impl ServerListener for Newcomers {
    fn on_subscribe(&self, _client: Client, _channel: ChannelView) {
        self.0.store(true, Ordering::Relaxed);
    }
}
