//! Lines that peers cause are let into the log at a bounded rate: who floods a port does not flood the disk.
//!
//! Counted by port and by the place in the program that writes the line: a burst of so many, then so many a second.
//! What was left out is said before the next line of the kind. What programs print is not bounded here, debug lines are
//! not either: whoever wants them asks for them.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use tracing::callsite::Identifier;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing::{Event, Level, Metadata, Subscriber};
use tracing_subscriber::layer::{Context, Layer};
use tracing_subscriber::registry::LookupSpan;

/// What may be written of one kind of line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Quota {
    burst: u32,
    interval: Duration,
}

/// Lines about peers: who is turned away, what is not understood, what is ordered.
const OF_PEERS: Quota = Quota {
    burst: 40,
    interval: Duration::from_millis(500),
};

/// Errors of programs, which peers send as well.
const OF_PROGRAMS: Quota = Quota {
    burst: 200,
    interval: Duration::from_millis(50),
};

/// The target of lines about lines.
const TARGET: &str = "server::log";

/// Keeps lines out of the log that peers cause too often.
#[derive(Debug)]
pub struct LogLimit {
    start: Instant,
    kinds: Mutex<HashMap<(Option<PortName>, Identifier), RateState>>,
}

/// The port that a line is about, as its session's span names it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct PortName(String);

/// Finds the port among the fields of a span.
#[derive(Default)]
struct PortFinder(Option<PortName>);

impl Visit for PortFinder {
    fn record_str(&mut self, field: &Field, value: &str) {
        if field.name() == "port" {
            self.0 = Some(PortName(value.to_owned()));
        }
    }

    fn record_debug(&mut self, _: &Field, _: &dyn core::fmt::Debug) {}
}

/// One kind of line (the generic cell rate algorithm).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct RateState {
    /// When everything written so far would have been due at the steady rate.
    due: Duration,
    left_out: u64,
}

impl RateState {
    /// How many were left out before this one; `None` when this one is left out as well.
    fn take(&mut self, now: Duration, quota: Quota) -> Option<u64> {
        let slack = quota.interval * (quota.burst - 1);
        if self.due > now + slack {
            self.left_out += 1;
            return None;
        }
        self.due = self.due.max(now) + quota.interval;
        Some(core::mem::take(&mut self.left_out))
    }
}

impl Default for LogLimit {
    fn default() -> Self {
        Self {
            start: Instant::now(),
            kinds: Mutex::default(),
        }
    }
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for LogLimit {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let mut finder = PortFinder::default();
        attributes.record(&mut finder);
        if let Some(port) = finder.0
            && let Some(span) = context.span(id)
        {
            span.extensions_mut().insert(port);
        }
    }

    fn event_enabled(&self, event: &Event<'_>, context: Context<'_, S>) -> bool {
        let Some(quota) = quota_of(event.metadata()) else {
            return true;
        };
        let spans = context.lookup_current().map(|span| span.scope());
        let port = spans
            .into_iter()
            .flatten()
            .find_map(|span| span.extensions().get::<PortName>().cloned());
        let left_out = {
            // The map stays small: it has an entry for each port and place of the code that writes.
            let mut kinds = self.kinds.lock();
            let kind = kinds
                .entry((port, event.metadata().callsite()))
                .or_default();
            kind.take(self.start.elapsed(), quota)
        };
        if let Some(count @ 1..) = left_out {
            tracing::warn!(target: TARGET, "{count} lines like the next one were left out");
        }
        left_out.is_some()
    }
}

/// What bounds a line; `None` where nothing does.
fn quota_of(metadata: &Metadata<'_>) -> Option<Quota> {
    let (target, level) = (metadata.target(), *metadata.level());
    if level > Level::INFO {
        None
    } else if target.starts_with("server::ports") || target.starts_with("server::backend") {
        Some(OF_PEERS)
    } else if target == "script" && level == Level::ERROR {
        Some(OF_PROGRAMS)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use tracing_subscriber::layer::SubscriberExt as _;

    #[test]
    fn a_burst_goes_through_then_the_steady_rate_and_what_is_missing_is_counted() {
        let mut kind = RateState::default();
        let at = |millis| Duration::from_millis(millis);
        let through = (0..1000).filter(|_| kind.take(at(0), OF_PEERS).is_some());
        assert_eq!(through.count(), 40);
        assert_eq!(kind.take(at(499), OF_PEERS), None);
        assert_eq!(kind.take(at(500), OF_PEERS), Some(961));
        assert_eq!(kind.take(at(501), OF_PEERS), None);
        assert_eq!(kind.take(at(1000), OF_PEERS), Some(1));
        // An hour of silence is one burst, not a thousand.
        let through = (0..1000).filter(|_| kind.take(at(3_600_000), OF_PEERS).is_some());
        assert_eq!(through.count(), 40);
    }

    /// Counts the lines that get through.
    struct Count(Arc<AtomicUsize>);

    impl<S: Subscriber> Layer<S> for Count {
        fn on_event(&self, _: &Event<'_>, _: Context<'_, S>) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    #[test]
    fn lines_of_peers_are_bounded_and_others_are_not() {
        let count = Arc::new(AtomicUsize::new(0));
        let log = tracing_subscriber::registry()
            .with(Count(count.clone()))
            .with(LogLimit::default());
        tracing::subscriber::with_default(log, || {
            for _ in 0..500 {
                tracing::warn!(target: "server::ports::listen", "a flood");
            }
            assert!(count.swap(0, Ordering::Relaxed) < 60);
            for port in ["primary", "rtsi"] {
                let _session = tracing::error_span!("session", port).entered();
                for _ in 0..500 {
                    tracing::warn!(target: "server::ports::listen", "closed");
                }
            }
            assert!((80..120).contains(&count.swap(0, Ordering::Relaxed)));
            for _ in 0..500 {
                tracing::debug!(target: "server::ports::listen", "asked for");
                tracing::info!(target: "script", "printed");
            }
            assert_eq!(count.load(Ordering::Relaxed), 1000);
        });
    }
}
