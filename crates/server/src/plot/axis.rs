//! Ranges of axes, and round numbers on them. Pure.

/// A range with a little room around all values, and at least `half_span_min` to both sides of its middle.
pub(super) fn range(values: impl IntoIterator<Item = f64>, half_span_min: f64) -> (f64, f64) {
    let (low, high) = values
        .into_iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    let least = if half_span_min > 0.0 {
        half_span_min
    } else {
        f64::MIN_POSITIVE
    };
    if low > high {
        let least = if half_span_min > 0.0 { least } else { 1.0 };
        return (-least, least);
    }
    // Halves first: the sum of two very large numbers is not finite.
    let middle = low / 2.0 + high / 2.0;
    let half = (high / 2.0 - low / 2.0) * 1.08;
    // Where numbers are so large that the smallest span vanishes in rounding, a share of them is the span.
    let half = half.max(least).max(middle.abs() * 1e-9);
    // A constant zero without a smallest span.
    let half = if half < 1e-300 { 1.0 } else { half };
    (middle - half, middle + half)
}

/// Round values on an axis.
pub(super) struct Ticks {
    pub(super) values: Vec<f64>,
    digits: usize,
}

impl Ticks {
    /// About `count` multiples of 1, 2 or 5 times a power of ten within the range.
    pub(super) fn new(low: f64, high: f64, count: usize) -> Self {
        let wanted = (high - low) / count as f64;
        let power = 10_f64.powf(wanted.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * power)
            .find(|step| *step >= wanted * 0.999)
            .unwrap_or(10.0 * power);
        Self::every(step, low, high, 2 * count)
    }

    /// The multiples of `step` within the range, at most `count_max` and one.
    pub(super) fn every(step: f64, low: f64, high: f64, count_max: usize) -> Self {
        if !(step.is_finite() && step > 0.0) {
            return Self {
                values: Vec::new(),
                digits: 0,
            };
        }
        let first = (low / step).ceil();
        let values = (0..=count_max)
            .map(|i| (first + i as f64) * step)
            .take_while(|value| *value - high <= step * 1e-6)
            .collect();
        let digits = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        Self { values, digits }
    }

    pub(super) fn label(&self, value: f64) -> String {
        if value.abs() >= 1e7 {
            return format!("{value:.1e}");
        }
        // Without the sign of zero.
        let value = if value == 0.0 { 0.0 } else { value };
        format!("{value:.digits$}", digits = self.digits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let shown = |low, high, count| {
            let ticks = Ticks::new(low, high, count);
            let labels = ticks.values.iter().map(|v| ticks.label(*v));
            labels.collect::<Vec<_>>().join(" ")
        };
        assert_eq!(shown(-1.7, 1.7, 5), "-1 0 1");
        assert_eq!(
            shown(0.0, 2.4, 12),
            "0.0 0.2 0.4 0.6 0.8 1.0 1.2 1.4 1.6 1.8 2.0 2.2 2.4"
        );
        assert_eq!(shown(-0.03, 0.06, 5), "-0.02 0.00 0.02 0.04 0.06");
        assert_eq!(shown(3.0, 3.0, 5), "");
        assert_eq!(shown(0.0, f64::MAX, 5).split(' ').count(), 4);
    }

    #[test]
    fn an_axis_has_room_for_any_finite_values() {
        for (low, high) in [(0.0, 0.0), (5.0, 5.0), (-1e300, 1e300), (1e300, 1e300)] {
            for half_span_min in [0.0, 0.1] {
                let (bottom, top) = range([low, high], half_span_min);
                assert!(
                    bottom < low && high < top && (top - bottom).is_finite(),
                    "{low} {high} {half_span_min}"
                );
            }
        }
        assert_eq!(range([], 0.0), (-1.0, 1.0));
        assert_eq!(range([], 0.1), (-0.1, 0.1));
    }
}
