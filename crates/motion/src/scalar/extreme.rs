//! What is known of the steps of a motion that lie within a window: its places and speeds, and its hardest changes of
//! speed.

/// The first motion at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Knot {
    pub(super) s: f64,
    pub(super) speed: f64,
}

/// The largest or the smallest change of speed from one knot to the next, 0 included. It is kept from step to step:
/// mostly the newest change is not beyond it, and it is not the one that is forgotten.
#[derive(Clone, Copy, Debug)]
pub(super) struct WindowExtremum {
    /// The change.
    pub(super) change: f64,
    /// The knot from which on it is; the latest of several.
    from: usize,
}

/// The change of speed that counts: the largest or the smallest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extremum {
    /// The larger one.
    Max,
    /// The smaller one.
    Min,
}

impl Extremum {
    fn is_beyond(self, a: f64, b: f64) -> bool {
        match self {
            Self::Max => a >= b,
            Self::Min => a <= b,
        }
    }
}

impl WindowExtremum {
    /// The extremum of so many knots, between which nothing changes.
    pub(super) const fn none(knots: usize) -> Self {
        Self {
            change: 0.0,
            from: knots - 2,
        }
    }

    /// The extremum of these knots.
    pub(super) fn of(knots: &[Knot], kind: Extremum) -> Self {
        let pairs = knots.windows(2).enumerate();
        pairs.fold(Self::none(knots.len()), |found, (from, pair)| {
            let change = pair[1].speed - pair[0].speed;
            if kind.is_beyond(change, found.change) {
                Self { change, from }
            } else {
                found
            }
        })
    }

    /// After the oldest knot was forgotten; the last one stands in two places until it is followed by another.
    pub(super) fn after_shift(self, knots: &[Knot], kind: Extremum) -> Self {
        match self.from.checked_sub(1) {
            Some(from) => Self { from, ..self },
            None => Self::of(knots, kind),
        }
    }

    /// With a change at the end, where none was before.
    pub(super) fn including(self, newest: f64, knots: &[Knot], kind: Extremum) -> Self {
        if kind.is_beyond(newest, self.change) {
            Self {
                change: newest,
                from: knots.len() - 2,
            }
        } else {
            self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(1), failure_persistence: None,
            ..ProptestConfig::default() })]
        #[test]
        fn what_is_kept_from_step_to_step_is_what_the_knots_say(
            steps in proptest::collection::vec((-2..3_i32, 1..20_usize), 1..30),
        ) {
            let mut knots = [Knot::default(); 9];
            let [mut faster, mut slower] = [WindowExtremum::none(9); 2];
            for change in steps.iter().flat_map(|(change, times)| core::iter::repeat_n(change, *times)) {
                let last = knots[8];
                knots.copy_within(1.., 0);
                faster = faster.after_shift(&knots, Extremum::Max);
                slower = slower.after_shift(&knots, Extremum::Min);
                knots[8].speed = (last.speed + f64::from(*change)).max(0.0);
                let newest = knots[8].speed - last.speed;
                faster = faster.including(newest, &knots, Extremum::Max);
                slower = slower.including(newest, &knots, Extremum::Min);
                let changes = || knots.windows(2).map(|pair| pair[1].speed - pair[0].speed);
                prop_assert_eq!(faster.change, changes().fold(0.0, f64::max));
                prop_assert_eq!(slower.change, changes().fold(0.0, f64::min));
            }
        }
    }
}
