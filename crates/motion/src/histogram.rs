//! How often a time was how long: counters that one thread writes and any thread reads.
//!
//! Fixed size, no lock, no allocation, so that the motion thread can count its own cycles.

use std::sync::atomic::{AtomicU64, Ordering};

/// Upper ends of the buckets, µs; one more bucket takes what is longer.
pub const BUCKETS_US: [u64; 12] = [
    10, 25, 50, 100, 200, 400, 800, 1600, 3200, 6400, 12_800, 100_000,
];

/// Counters by bucket, and the sum of all times.
#[derive(Debug, Default)]
pub struct Histogram {
    counts: [AtomicU64; BUCKETS_US.len() + 1],
    sum_ns: AtomicU64,
}

/// The counters at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HistogramSnapshot {
    /// How often, by bucket; the last one is beyond [`BUCKETS_US`].
    pub counts: [u64; BUCKETS_US.len() + 1],
    /// Sum of all times, ns.
    pub sum_ns: u64,
}

impl Histogram {
    /// Counts one time.
    pub fn record(&self, time: core::time::Duration) {
        let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        // Up to and with the end of a bucket, as Prometheus has it.
        let bucket = BUCKETS_US.partition_point(|end| end * 1000 < ns);
        self.counts[bucket].fetch_add(1, Ordering::Relaxed);
        self.sum_ns.fetch_add(ns, Ordering::Relaxed);
    }

    /// The counters now.
    pub fn snapshot(&self) -> HistogramSnapshot {
        HistogramSnapshot {
            counts: core::array::from_fn(|i| self.counts[i].load(Ordering::Relaxed)),
            sum_ns: self.sum_ns.load(Ordering::Relaxed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::time::Duration;

    #[test]
    fn a_time_is_counted_in_the_bucket_that_it_does_not_exceed() {
        let histogram = Histogram::default();
        for micros in [0, 10, 11, 100_000, 100_001] {
            histogram.record(Duration::from_micros(micros));
        }
        let read = histogram.snapshot();
        assert_eq!((read.counts[0], read.counts[1]), (2, 1));
        assert_eq!(
            (
                read.counts[BUCKETS_US.len() - 1],
                read.counts[BUCKETS_US.len()]
            ),
            (1, 1)
        );
        assert_eq!(read.sum_ns, 200_022_000);
    }
}
