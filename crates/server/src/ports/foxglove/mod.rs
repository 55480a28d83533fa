//! The Foxglove port: the arm as it moves, for the Foxglove app and everything that speaks its WebSocket protocol.
//!
//! Read-only: no client can publish, set parameters or call services here. The topics are those of a recording, with
//! the same schemas. The server of the crate `foxglove` is not used: it opens its own door, which looks at no Host or
//! Origin, takes any number of clients and counts what waits for them in messages; the part of its protocol that shows
//! is small.

pub mod protocol;
mod session;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use controller::cell_world::SceneWatch;
use messages::Text;
use prost::Message as _;
use recorder::{Topic, ViewerMessages};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::sync::broadcast;
use tokio_util::sync::CancellationToken;

use crate::ports::allowed_hosts::AllowedHosts;
use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::{Peer, PortProtocol};
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

/// Messages that wait for clients that are behind; one more pushes the oldest out. All clients share them.
const BACKLOG: usize = 1024;

/// The world of the cell is looked at so often, s: as often as a scene is drawn.
const WORLD_PERIOD: f64 = 0.1;

pub use controller::LogLine;
pub use controller::recording_observer::LOG_BYTES_MAX;

/// What is shown.
pub struct FoxgloveSource {
    /// Makes the messages; knows arm, obstacles and epoch.
    pub viewer: ViewerMessages,
    /// What lives in the cell.
    pub world: Option<SceneWatch>,
    /// Every cycle.
    pub samples: broadcast::Receiver<Arc<Sample>>,
    /// Every message for people.
    pub log: broadcast::Receiver<LogLine>,
}

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    view: FoxgloveSource,
    meter: PortMeter,
    callers: AllowedHosts,
    shutdown: CancellationToken,
) {
    let stage = Arc::new(FoxgloveBroadcast::new(view.viewer.nanos(0.0)));
    // The desktop app of the makers is a page on the disk.
    let callers = Arc::new(callers.with_files());
    let clients = serve_port(
        listener,
        PortProtocol::Http,
        meter,
        shutdown.clone(),
        |peer, _, shutdown| {
            let (stage, callers) = (Arc::clone(&stage), Arc::clone(&callers));
            async move { stage.attend(peer, &callers, &shutdown).await }
        },
    );
    let mut feed = MessageEncoder {
        stage: Arc::clone(&stage),
        cycle: recorder::CycleMessage::default(),
        world_seen: f64::NEG_INFINITY,
        encoded: Vec::new(),
    };
    tokio::join!(clients, feed.run(view, &shutdown));
}

/// One thing that clients are shown.
#[derive(Clone, Debug)]
enum Packet {
    /// A message of the topic at this place of [`TOPICS`].
    Message {
        place: usize,
        at: u64,
        payload: Arc<[u8]>,
    },
    /// The time, ns.
    Time(u64),
}

/// What all clients of the port see.
pub struct FoxgloveBroadcast {
    packets: broadcast::Sender<Packet>,
    /// What every client is told first.
    greeting: [Arc<str>; 2],
    /// Clients that follow something.
    followers: AtomicUsize,
    /// Somebody has begun to follow.
    newcomer: AtomicBool,
}

impl FoxgloveBroadcast {
    /// A stage on which nothing happens yet. Clients tell sessions apart by the number.
    pub fn new(session: u64) -> Self {
        Self {
            packets: broadcast::Sender::new(BACKLOG),
            greeting: [
                protocol::server_info(session).into(),
                protocol::advertise(&TOPICS).into(),
            ],
            followers: AtomicUsize::new(0),
            newcomer: AtomicBool::new(false),
        }
    }

    /// Serves one client, over any stream, until it leaves or `shutdown`.
    pub async fn attend<S>(
        &self,
        peer: Peer<S>,
        callers: &AllowedHosts,
        shutdown: &CancellationToken,
    ) where
        S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        session::serve(peer, callers, self, shutdown).await;
    }

    /// Clients that follow something now.
    pub fn followers(&self) -> usize {
        self.followers.load(Ordering::Relaxed)
    }

    fn subscribe(&self) -> broadcast::Receiver<Packet> {
        self.packets.subscribe()
    }

    const fn greeting(&self) -> &[Arc<str>; 2] {
        &self.greeting
    }

    /// Whoever comes is to see the scene.
    fn somebody_came(&self) {
        self.newcomer.store(true, Ordering::Relaxed);
    }

    fn begin_following(&self) {
        self.followers.fetch_add(1, Ordering::Relaxed);
    }

    fn end_following(&self) {
        self.followers.fetch_sub(1, Ordering::Relaxed);
    }

    fn is_followed(&self) -> bool {
        self.followers() > 0
    }

    fn send(&self, topic: Topic, at: u64, message: &[u8]) {
        // A topic that is not shown here is nobody's; and that nobody listens is fine.
        if let Some(place) = TOPICS.iter().position(|one| *one == topic) {
            let payload = message.into();
            let _ = self.packets.send(Packet::Message { place, at, payload });
        }
    }
}

/// Makes the messages.
struct MessageEncoder {
    stage: Arc<FoxgloveBroadcast>,
    cycle: recorder::CycleMessage,
    /// Simulated time of the last look at the world, s.
    world_seen: f64,
    encoded: Vec<u8>,
}

impl MessageEncoder {
    /// Shows what happens until `shutdown`.
    async fn run(&mut self, mut view: FoxgloveSource, shutdown: &CancellationToken) {
        loop {
            tokio::select! {
                () = shutdown.cancelled() => return,
                sample = view.samples.recv() => match sample {
                    Ok(sample) => self.show(&mut view, &sample),
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

    fn show(&mut self, view: &mut FoxgloveSource, sample: &Sample) {
        if !self.stage.is_followed() {
            return;
        }
        let viewer = &mut view.viewer;
        let since = sample.state.time - self.world_seen;
        if let Some(look) = &mut view.world
            && !(0.0..WORLD_PERIOD).contains(&since)
        {
            self.world_seen = sample.state.time;
            if let Some(bodies) = look() {
                viewer.set_bodies(bodies);
            }
        }
        if self.stage.newcomer.swap(false, Ordering::Relaxed) {
            viewer.request_scene();
        }
        let state = &sample.state;
        let at = viewer.nanos(state.time);
        self.cycle.set_from_state(state);
        self.encoded.clear();
        self.cycle.encode_raw(&mut self.encoded);
        self.stage.send(Topic::Cycle, at, &self.encoded);
        let mut shown = false;
        let Ok(()) = viewer.state(state, |topic, message| {
            self.stage.send(topic, at, message);
            shown = true;
            Ok::<(), core::convert::Infallible>(())
        });
        if shown {
            // That nobody listens is fine.
            let _ = self.stage.packets.send(Packet::Time(at));
        }
    }

    fn log(&self, viewer: &mut ViewerMessages, line: &LogLine) {
        if !self.stage.is_followed() {
            return;
        }
        let end = line.text.floor_char_boundary(LOG_BYTES_MAX);
        let cut = if end < line.text.len() { "…" } else { "" };
        let text = format!("{}{cut}", &line.text[..end]);
        let at = viewer.nanos(line.time);
        let message = viewer.log(line.time, line.level, &line.source, &Text::verbatim(text));
        self.stage.send(Topic::Log, at, message);
    }
}

#[cfg(test)]
mod tests;
