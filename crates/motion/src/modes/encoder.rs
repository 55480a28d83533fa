//! The two conveyor encoders: where counts come from, and how far the belt really is between two of them.
//!
//! Sources: a simulated belt of the cell, pulses on simulated inputs, or the program (manual 3.1.21 to 3.1.24, 3.1.32).
//! A count is a whole number at most times, too coarse to follow: 1000 ticks a metre are a millimetre each. As motion
//! controllers do, the decoder keeps the time of every edge; position and rate between edges follow from the last ones.

use motion_api::{EncoderRange, PulseDecoding};

/// Edges whose times are kept.
const EDGES: usize = 8;
/// A program's counts are carried on for this long after the last one, s.
const PROGRAM_PATIENCE: f64 = 0.1;
/// Without edges for this long a belt stands, s.
const STANDSTILL: f64 = 1.0;

/// A belt of the cell: what turns an encoder. Where it runs matters to pictures only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belt {
    /// Encoder, 0 or 1.
    pub encoder: usize,
    /// Ticks a second, negative when it runs backwards.
    pub ticks_per_second: f64,
    /// When the belt starts, s.
    pub start_at: f64,
}

impl Belt {
    /// Ticks at a time, with fraction.
    pub fn ticks(&self, time: f64) -> f64 {
        self.ticks_per_second * (time - self.start_at).max(0.0)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CountSource {
    /// Nothing was set up: the belt of the cell, if there is one.
    Belt,
    Program,
    Pulses {
        decoding: PulseDecoding,
        channel_a: u8,
        channel_b: u8,
        before: (bool, bool),
    },
}

#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    count: f64,
    time: f64,
}

/// One encoder.
#[derive(Clone, Copy, Debug)]
pub struct Encoder {
    source: CountSource,
    range: EncoderRange,
    belt: Option<Belt>,
    /// Ticks since the start, not wrapped.
    total: f64,
    /// The ticks of the belt when its pulses were last looked at.
    belt_before: f64,
    /// Ticks with fraction that a world has turned the belt by, and when that was.
    world_ticks: Option<(f64, f64)>,
    edges: [Edge; EDGES],
    count: usize,
    now: f64,
}

impl Encoder {
    /// Turned by `belt`, or by nothing.
    pub fn new(belt: Option<Belt>) -> Self {
        Self {
            source: CountSource::Belt,
            range: EncoderRange::Signed32,
            belt,
            total: 0.0,
            belt_before: 0.0,
            world_ticks: None,
            edges: [Edge::default(); EDGES],
            count: 0,
            now: 0.0,
        }
    }

    /// The program gives the counts from now on.
    pub fn take_from_program(&mut self, range: EncoderRange) {
        self.source = CountSource::Program;
        self.range = range;
        self.restart();
    }

    /// Pulses are counted from now on: of the belt if there is one, of two inputs otherwise.
    pub fn take_pulses(
        &mut self,
        decoding: PulseDecoding,
        channel_a: u8,
        channel_b: u8,
        inputs: u64,
    ) {
        self.source = CountSource::Pulses {
            decoding,
            channel_a,
            channel_b,
            before: levels(inputs, channel_a, channel_b),
        };
        self.range = EncoderRange::Signed32;
        self.restart();
    }

    fn restart(&mut self) {
        self.total = 0.0;
        self.count = 0;
        let ticks = match (self.world_ticks, self.belt) {
            (Some((ticks, _)), _) => ticks,
            (None, Some(belt)) => belt.ticks(self.now),
            (None, None) => 0.0,
        };
        self.belt_before = truncated_ticks(ticks);
    }

    /// True when the program gives the counts.
    pub fn is_from_program(&self) -> bool {
        self.source == CountSource::Program
    }

    /// Range of the counter.
    pub fn range(&self) -> EncoderRange {
        self.range
    }

    /// The count as a program reads it.
    pub fn counts(&self) -> f64 {
        self.range.wrap_count(self.total)
    }

    /// A count from the program. The way from the last one is the short one round the counter. True when it is the
    /// first, which says where the counter is, not that the belt moved.
    pub fn set_count(&mut self, count: f64) -> bool {
        let way = self.range.unwrap_delta(count - self.counts());
        let is_first = self.count == 0;
        if is_first {
            self.total = count;
        } else {
            self.total += way;
        }
        self.add_edge(self.now);
        is_first
    }

    /// The end of a cycle at `time`, s. `world_ticks` are those that a world has turned the belt by since the start.
    pub fn sample(&mut self, time: f64, inputs: u64, world_ticks: Option<f64>) {
        let before = self.world_ticks;
        self.world_ticks = world_ticks.map(|ticks| (ticks, time));
        self.now = time;
        match &mut self.source {
            CountSource::Program => {}
            CountSource::Pulses {
                decoding,
                channel_a,
                channel_b,
                before,
            } if self.belt.is_none() => {
                let after = levels(inputs, *channel_a, *channel_b);
                let ticks = edges(*decoding, *before, after);
                *before = after;
                if ticks != 0.0 {
                    self.total += ticks;
                    self.add_edge(time);
                }
            }
            CountSource::Belt | CountSource::Pulses { .. } => self.sample_belt(time, before),
        }
    }

    /// `before` is what `world_ticks` was a cycle ago.
    fn sample_belt(&mut self, time: f64, before: Option<(f64, f64)>) {
        let Some(belt) = self.belt else { return };
        let (ticks, edge_time) = match self.world_ticks {
            None => {
                let ticks = truncated_ticks(belt.ticks(time));
                (ticks, belt.start_at + ticks / belt.ticks_per_second)
            }
            Some((now, _)) => {
                let ticks = truncated_ticks(now);
                let (then, at) = before.unwrap_or((now, time));
                let share = if now == then {
                    1.0
                } else {
                    (ticks - then) / (now - then)
                };
                (
                    ticks,
                    at + (time - at) * kinematics::bounds::within(share, 0.0, 1.0),
                )
            }
        };
        let mut moved = ticks - self.belt_before;
        if moved == 0.0 {
            return;
        }
        self.belt_before = ticks;
        // One channel alone does not tell the direction.
        if let CountSource::Pulses { decoding, .. } = self.source
            && decoding != PulseDecoding::Quadrature
        {
            moved = moved.abs();
        }
        self.total += moved;
        self.add_edge(edge_time);
    }

    fn add_edge(&mut self, time: f64) {
        let edge = Edge {
            count: self.total,
            time,
        };
        // The program may give two counts in one cycle: the last one counts.
        if self.count > 0 && self.edges[0].time >= time {
            self.edges[0] = edge;
            return;
        }
        self.edges.rotate_right(1);
        self.edges[0] = edge;
        self.count = (self.count + 1).min(EDGES);
    }

    /// Where the belt is, ticks since the start with fraction, and how fast it runs, ticks/s.
    pub fn position(&self) -> (f64, f64) {
        if self.count < 2 {
            return (self.total, 0.0);
        }
        let newest = self.edges[0];
        let oldest = self.edges[if self.is_from_program() {
            1
        } else {
            self.count - 1
        }];
        let rate = (newest.count - oldest.count) / (newest.time - oldest.time);
        let since = self.now - newest.time;
        if self.is_from_program() {
            return if since > PROGRAM_PATIENCE {
                (self.total, 0.0)
            } else {
                (self.total + rate * since, rate)
            };
        }
        // No edge has come since: the belt has moved by less than a tick, and may be slower than it was.
        let ahead = rate * since;
        if since > STANDSTILL {
            (self.total, 0.0)
        } else if ahead.abs() <= 1.0 {
            (self.total + ahead, rate)
        } else {
            (self.total + ahead.signum(), rate.signum() / since)
        }
    }
}

/// Ticks an encoder has seen: whole ones, counted from zero both ways.
fn truncated_ticks(ticks: f64) -> f64 {
    // The time of an edge is a multiple of the period only up to rounding.
    let nearest = ticks.round();
    if (ticks - nearest).abs() < 1e-9 * (1.0 + ticks.abs()) {
        nearest
    } else {
        ticks.trunc()
    }
}

fn levels(inputs: u64, channel_a: u8, channel_b: u8) -> (bool, bool) {
    let level = |channel: u8| inputs & (1 << u64::from(channel.min(63))) != 0;
    (level(channel_a), level(channel_b))
}

/// Ticks of one change of the two channels.
fn edges(decoding: PulseDecoding, before: (bool, bool), after: (bool, bool)) -> f64 {
    let (rises, falls) = (!before.0 && after.0, before.0 && !after.0);
    let one = |counts: bool| if counts { 1.0 } else { 0.0 };
    match decoding {
        PulseDecoding::BothEdges => one(rises || falls),
        PulseDecoding::Rising => one(rises),
        PulseDecoding::Falling => one(falls),
        PulseDecoding::Quadrature => {
            // A leads B when the belt runs forwards: 00, 10, 11, 01. Both at once is a lost step and counts nothing.
            let phase = |(a, b): (bool, bool)| match (a, b) {
                (false, false) => 0,
                (true, false) => 1,
                (true, true) => 2,
                (false, true) => 3,
            };
            match (phase(after) - phase(before) + 4) % 4 {
                1 => 1.0,
                3 => -1.0,
                _ => 0.0,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_ticks_the_belt_is_where_its_speed_puts_it() {
        for ticks_per_second in [500.0, -500.0, 37.0, 12_345.6] {
            let belt = Belt {
                encoder: 0,
                ticks_per_second,
                start_at: 0.1,
            };
            let mut encoder = Encoder::new(Some(belt));
            for cycle in 1..500 {
                let time = f64::from(cycle) * 0.004;
                encoder.sample(time, 0, None);
                assert_eq!(encoder.counts().fract(), 0.0);
                if time > 0.4 {
                    let (position, rate) = encoder.position();
                    assert!(
                        (position - belt.ticks(time)).abs() < 1e-6,
                        "{time} {position}"
                    );
                    assert!((rate - ticks_per_second).abs() < 1e-6 * ticks_per_second.abs());
                }
            }
        }
    }

    #[test]
    fn quadrature_counts_up_and_down() {
        let turn = [(true, false), (true, true), (false, true), (false, false)];
        let mut before = (false, false);
        let mut sum = 0.0;
        for after in turn {
            sum += edges(PulseDecoding::Quadrature, before, after);
            before = after;
        }
        assert_eq!(sum, 4.0);
        for after in turn.into_iter().rev().skip(1).chain([(false, false)]) {
            sum += edges(PulseDecoding::Quadrature, before, after);
            before = after;
        }
        assert_eq!(sum, 0.0);
    }

    #[test]
    fn one_channel_counts_the_edges_it_is_told_to() {
        let (low, high) = ((false, false), (true, false));
        for (decoding, rise, fall) in [
            (PulseDecoding::BothEdges, 1.0, 1.0),
            (PulseDecoding::Rising, 1.0, 0.0),
            (PulseDecoding::Falling, 0.0, 1.0),
        ] {
            assert_eq!(edges(decoding, low, high), rise);
            assert_eq!(edges(decoding, high, low), fall);
            assert_eq!(edges(decoding, high, high), 0.0);
        }
    }

    #[test]
    fn a_programs_counts_go_on_past_the_end_of_the_range() {
        let mut encoder = Encoder::new(None);
        encoder.take_from_program(EncoderRange::Unsigned16);
        for (cycle, count) in [65_520.0, 65_530.0, 4.0, 14.0].into_iter().enumerate() {
            encoder.sample(cycle as f64 * 0.004, 0, None);
            encoder.set_count(count);
        }
        assert_eq!(encoder.counts(), 14.0);
        let (position, rate) = encoder.position();
        assert_eq!(position, 65_550.0);
        assert!((rate - 2500.0).abs() < 1e-6);
    }
}
