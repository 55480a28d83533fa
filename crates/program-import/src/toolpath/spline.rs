//! B-splines with weights as lines within a tolerance.

use messages::{Text, text};

use super::{Point, distance, dot, minus, plus, unit};

/// A spline of any degree up to [`DEGREE_MAX`].
#[derive(Clone, Debug, Default)]
pub struct Spline {
    /// Degree, from 1.
    pub degree: usize,
    /// Knots, in order; as many as control points and degree and one.
    pub knots: Vec<f64>,
    /// Control points, m.
    pub points: Vec<Point>,
    /// Weights of the control points; none: all 1.
    pub weights: Vec<f64>,
}

/// Higher degrees are no splines that anybody draws.
pub const DEGREE_MAX: usize = 25;
/// Points of a curve that are nearer to the one before are the same, m.
const FIT_DISTANCE_MIN_M: f64 = 1e-9;
/// Each span of knots is halved this often at most.
const HALVINGS_MAX: u32 = 12;

impl Spline {
    /// The cubic spline through points, as programs for drawings make it: of steady curvature, by the length of chords.
    /// A tangent says the direction at an end; without one the curve is not bent there. `None`: there are no two
    /// points.
    pub fn through(points: &[Point], tangents: [Option<Point>; 2]) -> Option<Self> {
        let mut through: Vec<Point> = Vec::with_capacity(points.len());
        for point in points {
            if through
                .last()
                .is_none_or(|last| distance(*last, *point) >= FIT_DISTANCE_MIN_M)
            {
                through.push(*point);
            }
        }
        let chords: Vec<f64> = through
            .windows(2)
            .map(|pair| distance(pair[0], pair[1]))
            .collect();
        let first = *through.first().filter(|_| !chords.is_empty())?;
        let slopes = slopes(
            &through,
            &chords,
            tangents.map(|tangent| tangent.and_then(unit)),
        );
        // Each span is a Bézier curve: its knots are threefold.
        let (mut knots, mut controls) = (vec![0.0; 4], vec![first]);
        let mut length = 0.0;
        for (index, chord) in chords.iter().enumerate() {
            let (begin, end) = (through[index], through[index + 1]);
            controls.push(plus(begin, slopes[index], chord / 3.0));
            controls.push(plus(end, slopes[index + 1], -chord / 3.0));
            controls.push(end);
            length += chord;
            knots.extend([length; 3]);
        }
        knots.push(length);
        Some(Self {
            degree: 3,
            knots,
            points: controls,
            weights: Vec::new(),
        })
    }

    /// A reason why the data are no spline, if there is one.
    pub fn problem(&self) -> Option<Text> {
        let (count, degree) = (self.points.len(), self.degree);
        if degree == 0 || degree > DEGREE_MAX {
            return Some(text!(
                "a spline of degree {degree}: allowed are 1 to {DEGREE_MAX}",
                "样条曲线的次数为 {degree}：允许 1 到 {DEGREE_MAX}"
            ));
        }
        if count <= degree || self.knots.len() != count + degree + 1 {
            return Some(text!(
                "a spline of degree {degree} with {count} control points has {} knots, and this one {}",
                "{degree} 次、{count} 个控制点的样条曲线有 {} 个节点，而此曲线有 {} 个",
                count + degree + 1,
                self.knots.len()
            ));
        }
        if !self.weights.is_empty() && self.weights.len() != count {
            return Some(text!(
                "{} weights for {count} control points",
                "{count} 个控制点有 {} 个权重",
                self.weights.len()
            ));
        }
        if self.weights.iter().any(|weight| *weight <= 0.0) {
            return Some(text!(
                "a weight of a spline is not above 0",
                "样条曲线有不大于 0 的权重"
            ));
        }
        let is_in_order = self.knots.windows(2).all(|pair| pair[0] <= pair[1]);
        let has_length = self.knots[degree] < self.knots[count];
        (!is_in_order || !has_length).then(|| {
            text!(
                "the knots of a spline are not in order",
                "样条曲线的节点没有按顺序排列"
            )
        })
    }

    /// The point at a parameter, by de Boor's algorithm in homogeneous coordinates.
    pub fn point(&self, parameter: f64) -> Point {
        let (degree, knots) = (self.degree, &self.knots);
        // Knots are in order, and there are more of them than control points.
        let inner = &knots[degree + 1..self.points.len()];
        let span = degree + inner.partition_point(|knot| *knot <= parameter);
        let mut work: Vec<[f64; 4]> = (span - degree..=span)
            .map(|index| {
                let weight = self.weights.get(index).copied().unwrap_or(1.0);
                let [x, y, z] = self.points[index];
                [x * weight, y * weight, z * weight, weight]
            })
            .collect();
        for level in 1..=degree {
            for index in (level..=degree).rev() {
                let left = knots[span - degree + index];
                let right = knots[span + 1 + index - level];
                let part = match right > left {
                    true => (parameter - left) / (right - left),
                    false => 0.0,
                };
                let before = work[index - 1];
                for (value, before) in work[index].iter_mut().zip(before) {
                    *value = (1.0 - part) * before + part * *value;
                }
            }
        }
        let [x, y, z, weight] = work[degree];
        [x / weight, y / weight, z / weight]
    }

    /// Points such that the lines between them stay within `tolerance` of the curve; the first one is its begin.
    pub fn lines(&self, tolerance: f64, points_max: usize) -> Vec<Point> {
        let (begin, end) = (self.knots[self.degree], self.knots[self.points.len()]);
        let mut parameters: Vec<f64> = self.knots[self.degree..=self.points.len()].to_vec();
        parameters.dedup();
        let mut lines = vec![self.point(begin)];
        for pair in parameters.windows(2) {
            // Two halves at least, so that a curve that swings about its chord is seen.
            let middle = f64::midpoint(pair[0], pair[1]);
            for span in [[pair[0], middle], [middle, pair[1]]] {
                self.add_lines(span, HALVINGS_MAX, tolerance, points_max, &mut lines);
            }
        }
        debug_assert!(end >= begin, "knots are in order");
        lines
    }

    fn add_lines(
        &self,
        [begin, end]: [f64; 2],
        halvings: u32,
        tolerance: f64,
        points_max: usize,
        lines: &mut Vec<Point>,
    ) {
        let (from, to) = (self.point(begin), self.point(end));
        let is_near = [0.25, 0.5, 0.75].into_iter().all(|part| {
            let point = self.point(begin + part * (end - begin));
            distance_to_line(point, from, to) <= tolerance
        });
        if is_near || halvings == 0 || lines.len() >= points_max {
            lines.push(to);
            return;
        }
        let middle = f64::midpoint(begin, end);
        for span in [[begin, middle], [middle, end]] {
            self.add_lines(span, halvings - 1, tolerance, points_max, lines);
        }
    }
}

/// Derivatives at the points by the length of chords, such that curvature is steady: a tridiagonal system, solved from
/// both ends. There is a chord less than points, and at least one.
fn slopes(points: &[Point], chords: &[f64], tangents: [Option<Point>; 2]) -> Vec<Point> {
    let last = chords.len();
    let secant = |index: usize| {
        plus(
            [0.0; 3],
            minus(points[index + 1], points[index]),
            1.0 / chords[index],
        )
    };
    // Factors of the neighbour before, of the slope itself and of the neighbour behind, and the right side.
    let row = |index: usize| -> ([f64; 3], Point) {
        let scaled = |vector, factor| plus([0.0; 3], vector, factor);
        match (index, tangents) {
            (0, [Some(tangent), _]) => ([0.0, 1.0, 0.0], tangent),
            (0, [None, _]) => ([0.0, 2.0, 1.0], scaled(secant(0), 3.0)),
            (end, [_, Some(tangent)]) if end == last => ([0.0, 1.0, 0.0], tangent),
            (end, [_, None]) if end == last => ([1.0, 2.0, 0.0], scaled(secant(end - 1), 3.0)),
            (inner, _) => {
                let (before, behind) = (chords[inner - 1], chords[inner]);
                let right = scaled(secant(inner - 1), 3.0 * behind);
                let right = plus(right, secant(inner), 3.0 * before);
                ([behind, 2.0 * (before + behind), before], right)
            }
        }
    };
    // The middle factor is larger than the others together in every row, so that no divisor comes near 0.
    let mut behind = vec![0.0; points.len()];
    let mut slopes = vec![[0.0; 3]; points.len()];
    for index in 0..points.len() {
        let ([left, middle, right], value) = row(index);
        let (taken, slope) = match index {
            0 => (0.0, [0.0; 3]),
            _ => (behind[index - 1], slopes[index - 1]),
        };
        let divisor = middle - left * taken;
        behind[index] = right / divisor;
        slopes[index] = plus([0.0; 3], plus(value, slope, -left), 1.0 / divisor);
    }
    for index in (0..last).rev() {
        slopes[index] = plus(slopes[index], slopes[index + 1], -behind[index]);
    }
    slopes
}

/// Distance of a point from a line between two points.
pub fn distance_to_line(point: Point, from: Point, to: Point) -> f64 {
    let Some(direction) = unit(minus(to, from)) else {
        return distance(point, from);
    };
    let along = dot(minus(point, from), direction).clamp(0.0, distance(from, to));
    distance(point, plus(from, direction, along))
}
