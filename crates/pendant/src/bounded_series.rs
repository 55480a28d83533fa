//! A series over time that never outgrows its bound: when it is full, what is old is thinned out, or all of it evenly.
//!
//! Owns nothing but the thinning. Times only grow; a much earlier one begins the series again (a controller that was
//! restarted).

/// What a series keeps.
pub trait HeapSize {
    /// Bytes that it holds.
    fn weight(&self) -> usize;
}

impl HeapSize for Box<[u8]> {
    fn weight(&self) -> usize {
        self.len()
    }
}

impl HeapSize for std::sync::Arc<str> {
    fn weight(&self) -> usize {
        self.len()
    }
}

/// What a full series gives up.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ThinningPolicy {
    /// What is old: of something that goes on, the recent part matters most.
    Old,
    /// Every part of the time the same: of something whole. One entry stays in each stretch of so many seconds, and the
    /// latest.
    Evenly(f64),
}

/// The series.
#[derive(Clone, Debug)]
pub struct BoundedSeries<T> {
    entries: Vec<(f64, T)>,
    weight: usize,
    most_entries: usize,
    most_bytes: usize,
    gives: ThinningPolicy,
}

/// The first stretches of a series that is thinned out evenly, s: shorter than any cycle, and a power of two.
const FIRST_STRETCH: f64 = 1.0 / 4096.0;

/// How late an event may be, s.
const LATE_MAX: f64 = 1.0;

impl<T: HeapSize> BoundedSeries<T> {
    /// An empty series of at most so many entries and bytes.
    pub const fn new(most_entries: usize, most_bytes: usize) -> Self {
        Self {
            entries: Vec::new(),
            weight: 0,
            most_entries,
            most_bytes,
            gives: ThinningPolicy::Old,
        }
    }

    /// An empty series that is thinned out evenly: the longest gap is one stretch of time, at most twice the whole time
    /// divided by the number of entries (of entries that come often enough).
    pub fn even(most_entries: usize, most_bytes: usize) -> Self {
        let gives = ThinningPolicy::Evenly(FIRST_STRETCH);
        Self {
            gives,
            ..Self::new(most_entries, most_bytes)
        }
    }

    /// Adds an entry at its end.
    pub fn push(&mut self, time: f64, entry: T) {
        if self.entries.last().is_some_and(|(last, _)| time < *last) {
            self.entries.clear();
            self.weight = 0;
            if let ThinningPolicy::Evenly(stretch) = &mut self.gives {
                *stretch = FIRST_STRETCH;
            }
        }
        self.drop_latest_of_stretch();
        self.insert_at(self.entries.len(), time, entry);
    }

    /// Adds an entry at its time. Events come on several ways, so one may be a little late: it stands before those that
    /// were faster. Later than [`LATE_MAX`] it begins the series again, as with [`Self::push`].
    pub fn insert(&mut self, time: f64, entry: T) {
        let place = self.entries.partition_point(|(at, _)| *at <= time);
        match self.entries.last() {
            Some((last, _)) if place < self.entries.len() && last - time <= LATE_MAX => {
                self.insert_at(place, time, entry);
            }
            _ => self.push(time, entry),
        }
    }

    fn insert_at(&mut self, place: usize, time: f64, entry: T) {
        self.weight += entry.weight();
        self.entries.insert(place, (time, entry));
        while self.entries.len() > self.most_entries
            || (self.weight > self.most_bytes && self.entries.len() > 1)
        {
            match self.gives {
                ThinningPolicy::Old => self.thin(),
                ThinningPolicy::Evenly(stretch) => self.thin_evenly(2.0 * stretch),
            }
        }
    }

    /// In a series that is thinned out evenly, the last entry goes when another one comes, if it is not the first of
    /// its stretch.
    fn drop_latest_of_stretch(&mut self) {
        let ThinningPolicy::Evenly(length) = self.gives else {
            return;
        };
        let stretch = |time: f64| (time / length).floor();
        if let [.., (before, _), (last, entry)] = &self.entries[..]
            && stretch(*before) == stretch(*last)
        {
            self.weight -= entry.weight();
            self.entries.pop();
        }
    }

    /// One entry stays in each stretch of this length, and the latest.
    fn thin_evenly(&mut self, length: f64) {
        let (before, mut place, mut last) = (self.entries.len(), 0, f64::NEG_INFINITY);
        self.entries.retain(|(time, _)| {
            place += 1;
            let stretch = (*time / length).floor();
            let stays = stretch > last || place == before;
            last = stretch;
            stays
        });
        // Stretches that are longer than the whole time keep two entries; more than that may be too heavy only for one.
        let farthest = self
            .span()
            .map_or(0.0, |(first, last)| last.abs().max(first.abs()));
        if self.entries.len() == before && (length > farthest || !length.is_finite()) {
            self.entries.remove(0);
        }
        self.gives = ThinningPolicy::Evenly(length);
        self.weight = self.entries.iter().map(|(_, entry)| entry.weight()).sum();
    }

    /// Of the older three quarters one entry stays in each stretch of time, and the stretches are so long that they are
    /// half as many as there may be entries at most: the beginning stays, and what is recent is dense. Their length is
    /// a power of two, so that what one thinning keeps the next one keeps or halves. Where that takes nothing away,
    /// every other entry goes.
    fn thin(&mut self) {
        let before = self.entries.len();
        let recent = (before * 3).div_ceil(4);
        let span = self.span().map_or(0.0, |(first, last)| last - first);
        let wanted = span / (self.most_entries.min(before) / 2).max(1) as f64;
        // Of entries of one moment only the first is old.
        let length = wanted.max(f64::MIN_POSITIVE).log2().ceil().exp2();
        let (mut place, mut last) = (0, f64::NEG_INFINITY);
        self.entries.retain(|(time, _)| {
            place += 1;
            let stretch = (*time / length).floor();
            let stays = place > recent || stretch > last;
            if stays {
                last = stretch;
            }
            stays
        });
        if self.entries.len() == before {
            let mut place = 0;
            self.entries.retain(|_| {
                place += 1;
                place % 2 == 1
            });
        }
        self.weight = self.entries.iter().map(|(_, entry)| entry.weight()).sum();
    }

    /// First and last time.
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((self.entries.first()?.0, self.entries.last()?.0))
    }

    /// The latest entry at or before `time`; the first one for earlier times.
    pub fn at(&self, time: f64) -> Option<&(f64, T)> {
        let behind = self.entries.partition_point(|(at, _)| *at <= time);
        self.entries.get(behind.saturating_sub(1))
    }

    /// The latest entry that began by `time`, none before the first.
    pub fn by(&self, time: f64) -> Option<&T> {
        let behind = self.entries.partition_point(|(at, _)| *at <= time);
        self.entries
            .get(behind.checked_sub(1)?)
            .map(|(_, entry)| entry)
    }

    /// At most `most` entries from `from` to `to`, evenly chosen, the last one among them.
    pub fn between(&self, from: f64, to: f64, most: usize) -> impl Iterator<Item = &(f64, T)> {
        let begin = self.entries.partition_point(|(at, _)| *at < from);
        let end = self.entries.partition_point(|(at, _)| *at <= to).max(begin);
        let stride = (end - begin).div_ceil(most.max(1)).max(1);
        // Counted from the end, so that the latest is there.
        let first = (end - begin).saturating_sub(1) % stride;
        self.entries[begin..end].iter().skip(first).step_by(stride)
    }

    /// The entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn track(count: usize, most: usize) -> BoundedSeries<Box<[u8]>> {
        let mut track = BoundedSeries::new(most, 1 << 20);
        for n in 0..count {
            track.push(n as f64, vec![0; 4].into());
        }
        track
    }

    #[test]
    fn a_full_series_keeps_its_ends_roughly_and_its_bound_exactly() {
        let track = track(10_000, 100);
        assert!((25..=100).contains(&track.len()), "{}", track.len());
        assert_eq!(track.span(), Some((0.0, 9999.0)));
        let times: Vec<f64> = track.between(0.0, 1e9, 1000).map(|(at, _)| *at).collect();
        let widest = times
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(0.0, f64::max);
        // Two stretches, each twice as long as wanted at most.
        assert!(widest <= 4.0 * 10_000.0 / 50.0, "{widest}");
    }

    #[test]
    fn an_hour_of_cycles_keeps_every_part_alike() {
        let mut track: BoundedSeries<Box<[u8]>> = BoundedSeries::even(60_000, 1 << 30);
        for cycle in 0..900_000 {
            track.push(f64::from(cycle) * 0.004, Box::from([0].as_slice()));
        }
        let times: Vec<f64> = track
            .between(0.0, 1e9, usize::MAX)
            .map(|(at, _)| *at)
            .collect();
        let gaps = times.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(times.len() <= 60_000);
        assert!(gaps.fold(0.0, f64::max) < 0.07);
        assert_eq!(track.span(), Some((0.0, 899_999.0 * 0.004)));
    }

    #[test]
    fn an_even_series_has_its_bounds_whatever_comes() {
        let mut track: BoundedSeries<Box<[u8]>> = BoundedSeries::even(10, 50);
        for time in [0.0, 0.0, 0.0, -5.0, 1.0, 1.0, 1e9, 1e9, 1e300] {
            for bytes in [10, 40, 60] {
                track.push(time, vec![0; bytes].into());
                assert!(
                    track.len() <= 10 && (track.weight <= 50 || track.len() == 1),
                    "{time}"
                );
            }
        }
    }

    #[test]
    fn bytes_have_a_bound_too_and_an_earlier_time_begins_again() {
        let mut track: BoundedSeries<Box<[u8]>> = BoundedSeries::new(1000, 100);
        for n in 0..50 {
            track.push(f64::from(n), vec![0; 10].into());
            assert!(track.len() <= 10);
        }
        track.push(1.0, vec![0; 10].into());
        assert_eq!((track.len(), track.span()), (1, Some((1.0, 1.0))));
    }

    #[test]
    fn what_was_at_a_time_is_found() {
        let track = track(10, 100);
        assert_eq!(track.at(3.5).unwrap().0, 3.0);
        assert_eq!(track.at(-1.0).unwrap().0, 0.0);
        assert!(track.by(-1.0).is_none());
        assert!(track.by(0.0).is_some());
        assert_eq!(track.at(99.0).unwrap().0, 9.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn a_section_is_in_order_within_bounds_and_ends_with_its_last(
            count in 0_usize..300, from in -10.0..310.0_f64, length in 0.0..320.0_f64, most in 0_usize..50,
        ) {
            let track = track(count, 200);
            let times: Vec<f64> = track.between(from, from + length, most).map(|(at, _)| *at).collect();
            prop_assert!(times.len() <= most.max(1));
            prop_assert!(times.is_sorted());
            prop_assert!(times.iter().all(|at| (from..=from + length).contains(at)));
            let last = track.at(from + length).map(|(at, _)| *at).filter(|at| *at >= from && *at <= from + length);
            prop_assert_eq!(times.last().copied(), last);
        }
    }
}
