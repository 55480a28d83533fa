//! When states go out: with the beat of the cycles, and without one.

use super::*;

/// A publisher of states and a client of its, in paused time.
struct Publisher {
    backend: Arc<Fake>,
    client: DuplexStream,
    shutdown: CancellationToken,
    tasks: (JoinHandle<()>, JoinHandle<SessionEnd>),
}

impl Publisher {
    fn start() -> Self {
        let (backend, hub) = (Fake::new(), StateHub::default());
        let shutdown = CancellationToken::new();
        let (client, server) = duplex(64 * 1024);
        let publishing = tokio::spawn({
            let (backend, hub, shutdown) = (Arc::clone(&backend), hub.clone(), shutdown.clone());
            async move { hub.publish_states(&*backend, shutdown).await }
        });
        let serving = tokio::spawn({
            let (backend, shutdown) = (Arc::clone(&backend), shutdown.clone());
            async move { serve(server, ClientId(1), &*backend, &hub, shutdown).await }
        });
        Self {
            backend,
            client,
            shutdown,
            tasks: (publishing, serving),
        }
    }

    fn beat(&self, time: f64) {
        let mut sample = sample();
        sample.state.time = time;
        self.backend.beats.send_replace(Some(Arc::new(sample)));
    }

    /// Its time stamp, µs.
    async fn state(&mut self) -> u64 {
        let (kind, body) = message(&mut self.client).await;
        assert_eq!((kind, body.len()), (16, STATE_MESSAGE_BYTES - 5));
        u64::from_be_bytes(*body[5..].first_chunk().unwrap())
    }

    async fn end(self) {
        self.shutdown.cancel();
        self.tasks.0.await.unwrap();
        assert_eq!(self.tasks.1.await.unwrap(), SessionEnd::Shutdown);
    }
}

#[tokio::test(start_paused = true)]
async fn a_state_goes_out_in_every_beat_without_any_request() {
    let mut publisher = Publisher::start();
    assert_eq!(publisher.state().await, 0, "at once");
    for beat in 1..=20_u32 {
        // The wall clock wanders; the beat is that of the cycles.
        sleep(Duration::from_millis(if beat % 2 == 0 { 80 } else { 120 })).await;
        publisher.beat(f64::from(beat) * 0.125);
        let before = Instant::now();
        assert_eq!(publisher.state().await, u64::from(beat) * 125_000);
        assert!(before.elapsed() < Duration::from_millis(2));
    }
    publisher.end().await;
}

#[tokio::test(start_paused = true)]
async fn without_a_beat_the_state_is_repeated_and_of_too_many_the_latest_counts() {
    let mut publisher = Publisher::start();
    publisher.beat(1.0);
    assert_eq!(
        publisher.state().await,
        0,
        "the first is that of its moment"
    );
    let start = Instant::now();
    for _ in 0..4 {
        assert_eq!(publisher.state().await, 0, "as the controller is now");
    }
    assert!(start.elapsed() <= Duration::from_secs(1));
    let start = Instant::now();
    for beat in 1..=1000_u32 {
        publisher.beat(f64::from(beat));
        sleep(Duration::from_millis(1)).await;
    }
    let mut count = 0;
    while publisher.state().await != 1_000_000_000 {
        count += 1;
    }
    let rate = f64::from(count) / start.elapsed().as_secs_f64();
    assert!((10.0..=21.0).contains(&rate), "{rate} states a second");
    publisher.end().await;
}
