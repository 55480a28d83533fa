//! A way walked at an uneven pace: the place s on it as a smooth function of a parameter u that moves evenly.
//!
//! Where a way asks much of the joints it is walked slower. Instead of changing the speed there, the parameter changes:
//! s(u) is a uniform cubic B-spline whose slope is at most 1 and small where the way is hard, so that the motion along u
//! keeps one set of limits from beginning to end and the arm slows down and speeds up without a corner in its
//! acceleration. Value and derivatives of such a spline lie between those of its control points (Piegl and Tiller, *The
//! NURBS Book*, 1997, 3.2), which bounds every derivative of s without looking at it in between.

/// Most control points.
pub const PACE_POINTS: usize = 128;

/// s(u), from 0 at u = 0 to the length of the way at the end.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Control points, unit of s; the first belongs to u = -spacing.
    points: [f64; PACE_POINTS],
    count: usize,
    /// Distance of the knots, unit of u.
    spacing: f64,
    /// u at the end of the way.
    length: f64,
    /// s at the end of the way.
    way: f64,
}

/// s and its derivatives with respect to u.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacePoint {
    /// Place on the way.
    pub s: f64,
    /// ds/du.
    pub first: f64,
    /// d²s/du².
    pub second: f64,
}

/// A piece between two places, within one interval of the knots: where it lies and the largest derivatives on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacePiece {
    /// Its length in u.
    pub length: f64,
    /// Largest ds/du.
    pub first: f64,
    /// Largest |d²s/du²|.
    pub second: f64,
    /// |d³s/du³|.
    pub third: f64,
}

impl Pace {
    /// The spline over control points that grow from `-x, 0, x` on, `spacing` apart in u, over a way of the length `way`.
    /// `None` when the points do not reach its end, do not grow, or are too many.
    pub fn new(points: &[f64], spacing: f64, way: f64) -> Option<Self> {
        let grows = points.windows(2).all(|pair| pair[1] > pair[0]);
        if points.len() < 5 || !grows || !(spacing > 0.0 && spacing.is_finite()) {
            return None;
        }
        let mut pace = Self {
            points: [0.0; PACE_POINTS],
            count: points.len(),
            spacing,
            length: 0.0,
            way,
        };
        pace.points.get_mut(..points.len())?.copy_from_slice(points);
        let end = (points.len() - 3) as f64 * spacing;
        if pace.at(end).s < way {
            return None;
        }
        let (mut low, mut high) = (0.0, end);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if pace.at(middle).s < way {
                low = middle;
            } else {
                high = middle;
            }
        }
        pace.length = high;
        (pace.length > 0.0).then_some(pace)
    }

    /// u at the end of the way.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// s and its derivatives at u; s is never outside of the way.
    pub fn at(&self, u: f64) -> PacePoint {
        let h = self.spacing;
        let x = u / h;
        let last = self.count.saturating_sub(4);
        let k = (x.max(0.0) as usize).min(last);
        let t = x - k as f64;
        let [a, b, c, d] = self.support(k);
        // Differences of the control points are those of the derivatives.
        let (v0, v1, v2) = (b - a, c - b, d - c);
        let (e0, e1) = (v1 - v0, v2 - v1);
        let third = e1 - e0;
        let second = e0 + t * third;
        let first = 0.5 * (v0 + v1) + t * (e0 + t * third / 2.0);
        let value =
            (a + 4.0 * b + c) / 6.0 + t * (0.5 * (v0 + v1) + t * (e0 / 2.0 + t * third / 6.0));
        let value = if self.length > 0.0 && u >= self.length {
            self.way
        } else {
            value
        };
        PacePoint {
            s: value,
            first: first / h,
            second: second / (h * h),
        }
    }

    /// The place u where s reaches `way`.
    pub fn reaching(&self, way: f64) -> f64 {
        if way >= self.way {
            return self.length;
        }
        let (mut low, mut high) = (0.0, self.length);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if self.at(middle).s < way {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// The pieces between two places, cut at the knots.
    pub fn pieces(&self, from: f64, to: f64) -> impl Iterator<Item = PacePiece> + '_ {
        let h = self.spacing;
        let first = (from / h) as usize;
        let last = self.count.saturating_sub(4);
        (first.min(last)..=last)
            .map(move |k| {
                let until = if k == last { to } else { (k + 1) as f64 * h };
                (k, from.max(k as f64 * h), until.min(to))
            })
            .take_while(move |(k, begin, _)| *begin < to || *k == first)
            .filter(|(_, begin, end)| begin < end)
            .map(move |(k, begin, end)| {
                let [a, b, c, d] = self.support(k);
                let (e0, e1) = (c - 2.0 * b + a, d - 2.0 * c + b);
                let at = |u: f64| {
                    let t = u / h - k as f64;
                    let first = 0.5 * (c - a) + t * (e0 + t * (e1 - e0) / 2.0);
                    (first / h, (e0 + t * (e1 - e0)) / (h * h))
                };
                let ((first0, second0), (first1, second1)) = (at(begin), at(end));
                let third = (e1 - e0).abs() / (h * h * h);
                let length = end - begin;
                PacePiece {
                    length,
                    // In between, the slope exceeds both ends by no more than a parabola's height.
                    first: first0.max(first1) + third * length * length / 8.0,
                    second: second0.abs().max(second1.abs()),
                    third,
                }
            })
    }

    /// The four control points of interval `k`.
    fn support(&self, k: usize) -> [f64; 4] {
        core::array::from_fn(|i| self.points.get(k + i).copied().unwrap_or(self.way))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uneven() -> Pace {
        let mut points = vec![-0.1, 0.0, 0.1];
        let mut step: f64 = 0.1;
        while points[points.len() - 1] < 2.0 {
            step = if points.len() < 12 {
                step * 0.8
            } else {
                step * 1.2
            };
            points.push(points[points.len() - 1] + step.min(0.1));
        }
        points.push(points[points.len() - 1] + 0.1);
        points.push(points[points.len() - 1] + 0.1);
        Pace::new(&points, 0.1, 2.0).unwrap_or_else(|| panic!("{points:?}"))
    }

    #[test]
    fn it_begins_and_ends_with_the_way_and_its_derivatives_are_its_slopes() {
        let pace = uneven();
        assert_eq!(pace.at(0.0).s, 0.0);
        assert_eq!(pace.at(pace.length()).s, 2.0);
        let h = 1e-5;
        for k in 1..200 {
            let u = pace.length() * f64::from(k) / 201.0;
            let (before, at, after) = (pace.at(u - h), pace.at(u), pace.at(u + h));
            assert!(
                (at.first - (after.s - before.s) / (2.0 * h)).abs() < 1e-6,
                "{u}"
            );
            assert!(
                (at.second - (after.first - before.first) / (2.0 * h)).abs() < 1e-4,
                "{u}"
            );
        }
    }

    #[test]
    fn its_pieces_cover_the_way_and_bound_the_derivatives() {
        let pace = uneven();
        let (from, to) = (pace.reaching(0.33), pace.length());
        assert!((pace.at(from).s - 0.33).abs() < 1e-12);
        let mut begin = from;
        for piece in pace.pieces(from, to) {
            for k in 0..=10 {
                let at = pace.at(begin + piece.length * f64::from(k) / 10.0);
                assert!(at.first <= piece.first + 1e-12 && at.first > 0.0);
                assert!(at.second.abs() <= piece.second + 1e-9);
            }
            begin += piece.length;
        }
        assert!((begin - to).abs() < 1e-12);
        assert_eq!(pace.at(pace.length()).s, 2.0);
    }

    #[test]
    fn points_that_do_not_make_a_way_are_refused() {
        assert!(Pace::new(&[-0.1, 0.0, 0.1, 0.2], 0.1, 0.1).is_none());
        assert!(Pace::new(&[-0.1, 0.0, 0.1, 0.05, 0.3], 0.1, 0.1).is_none());
        assert!(Pace::new(&[-0.1, 0.0, 0.1, 0.2, 0.3], 0.1, 1.0).is_none());
        let many: Vec<f64> = (0..200).map(f64::from).collect();
        assert!(Pace::new(&many, 0.1, 10.0).is_none());
    }
}
