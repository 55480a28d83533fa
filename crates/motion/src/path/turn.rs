//! From one line of the TCP into another: an arc between two pieces on which the curvature grows and falls evenly.
//!
//! So the TCP keeps its speed and its acceleration has no step. s is the distance along the curve, m. The pieces are
//! clothoids (Walton and Meek, "A controlled clothoid spline", *Computers & Graphics* 29, 2005, for corners between
//! lines); their points are integrals of the direction, by Gauss and Legendre's rule.

use kinematics::bounds::within;
use kinematics::elementary::{atan2, sin_cos, tan};
use kinematics::rotation::rotation_from_rotvec;
use kinematics::{JointPositions, Pose, RobotModel};
use nalgebra::Vector3;

use super::cartesian::{CartesianPath, PathTwist, derivatives};
use super::{PathPoint, TcpPath};

/// Longest clothoid, as a share of the arc that it is laid over one end of.
const LONGEST_RAMP: f64 = 0.5;
/// Sharper corners are left to other curves, rad.
const MAX_CORNER_ANGLE: f64 = 2.6;
/// Gauss-Legendre places and weights on -1..1.
const GAUSS: [(f64, f64); 8] = [
    (-0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
    (-0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (-0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (-0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];

/// The curve between two lines.
#[derive(Clone, Copy, Debug)]
pub struct ClothoidBlend {
    start: Vector3<f64>,
    /// Direction of the first line, and across it towards the second; unit vectors.
    along: Vector3<f64>,
    across: Vector3<f64>,
    curvature: f64,
    /// Length of a clothoid, and of the arc without them.
    clothoid_length: f64,
    arc_length: f64,
    /// The plane's coordinates and the direction after the first clothoid and after the arc.
    arc_ends: [[f64; 3]; 2],
    corner: Pose,
    flange_from_tcp: Pose,
    /// Rotation per metre on both lines, base axes, and how far the curve reaches back and on from the corner.
    turn_rates: [Vector3<f64>; 2],
    reach: f64,
    end: JointPositions,
}

/// How the curve lies in a corner of an angle: with its arc of length 1 in all, of which clothoids take a share at
/// either end, how far from the corner it begins.
fn unit_reach(angle: f64, ramp: f64) -> f64 {
    let (curvature, arc) = (angle, 1.0 - ramp);
    let knee = clothoid(curvature / (2.0 * ramp), 0.0, ramp);
    let middle = along_arc(
        [knee[0], knee[1], curvature * ramp / 2.0],
        curvature,
        arc / 2.0,
    );
    middle[0] + middle[1] * tan(angle / 2.0)
}

/// Where the direction a + b s² leads to in s, from 0.
fn clothoid(b: f64, a: f64, s: f64) -> [f64; 2] {
    GAUSS.iter().fold([0.0; 2], |[x, y], (place, weight)| {
        let at = 0.5 * s * (1.0 + place);
        let (sin, cos) = sin_cos(a + b * at * at);
        [x + 0.5 * s * weight * cos, y + 0.5 * s * weight * sin]
    })
}

/// From a point with a direction along an arc.
fn along_arc([x, y, direction]: [f64; 3], curvature: f64, s: f64) -> [f64; 3] {
    let next = direction + curvature * s;
    let (sin, cos) = sin_cos(direction);
    let (sin_next, cos_next) = sin_cos(next);
    [
        x + (sin_next - sin) / curvature,
        y + (cos - cos_next) / curvature,
        next,
    ]
}

impl ClothoidBlend {
    /// The curve over the corner of two lines whose arc touches both at `touch` metres from the corner; it begins and
    /// ends at most `room` metres from it, and where that is less its arc is smaller. The clothoids are
    /// `clothoid_length` metres long, less on short arcs. `None` where the lines meet too sharply, go
    /// straight on, or are turns of the tool rather than lines.
    pub fn between(
        first: &CartesianPath,
        second: &CartesianPath,
        (touch, room): (f64, f64),
        ramp: f64,
    ) -> Option<Self> {
        let (along, next) = (first.direction()?, second.direction()?);
        let angle = atan2(along.cross(&next).norm(), along.dot(&next));
        let across = (next - along * along.dot(&next)).try_normalize(1e-9)?;
        if !(1e-7..=MAX_CORNER_ANGLE).contains(&angle) {
            return None;
        }
        // The arc of radius touch / tan(angle / 2); how long it may be depends a little on its clothoids.
        let touching = touch * angle / tan(angle / 2.0);
        let fits = |share: f64| touching.min(room / unit_reach(angle, share));
        let share = (ramp / fits(LONGEST_RAMP)).min(LONGEST_RAMP);
        let whole = fits(share);
        let unit = unit_reach(angle, share);
        let (curvature, ramp) = (angle / whole, share * whole);
        let arc = whole - ramp;
        let knee = clothoid(curvature / (2.0 * ramp), 0.0, ramp);
        let first_knee = [knee[0], knee[1], curvature * ramp / 2.0];
        let corner = first.pose(first.length());
        let reach = whole * unit;
        Some(Self {
            start: corner.translation - along * reach,
            along,
            across,
            curvature,
            clothoid_length: ramp,
            arc_length: arc,
            arc_ends: [first_knee, along_arc(first_knee, curvature, arc)],
            corner,
            flange_from_tcp: *first.flange_from_tcp(),
            turn_rates: [first.rotation_per_s(), second.rotation_per_s()],
            reach,
            end: second.end(),
        })
    }

    /// The curve with the joint positions at its end.
    #[must_use]
    pub fn ending_at(self, end: JointPositions) -> Self {
        Self { end, ..self }
    }

    /// Joint positions at the end.
    pub fn end(&self) -> JointPositions {
        self.end
    }

    /// Where the curvature stops growing and where it begins to fall, s.
    pub fn arc_bounds(&self) -> [f64; 2] {
        [self.clothoid_length, self.clothoid_length + self.arc_length]
    }

    /// Length of the curve, m.
    pub fn length(&self) -> f64 {
        2.0 * self.clothoid_length + self.arc_length
    }

    /// How far from the corner the curve begins and ends, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Coordinates in the plane, direction and curvature at s.
    fn plane(&self, s: f64) -> [f64; 4] {
        let (ramp, arc, curvature) = (self.clothoid_length, self.arc_length, self.curvature);
        let growth = curvature / ramp;
        if s <= ramp {
            let [x, y] = clothoid(growth / 2.0, 0.0, s);
            return [x, y, growth * s * s / 2.0, growth * s];
        }
        if s <= ramp + arc {
            let [x, y, direction] = along_arc(self.arc_ends[0], curvature, s - ramp);
            return [x, y, direction, curvature];
        }
        // The last piece is the first one mirrored: back from the end, where the direction is all of the angle.
        let [x, y, begun] = self.arc_ends[1];
        let (t, rest) = (s - ramp - arc, self.length() - s);
        let end = begun + curvature * ramp / 2.0;
        let whole = clothoid(-growth / 2.0, end, ramp);
        let left = clothoid(-growth / 2.0, end, ramp - t);
        [
            x + whole[0] - left[0],
            y + whole[1] - left[1],
            end - growth * rest * rest / 2.0,
            growth * rest,
        ]
    }

    /// How far the first line's turning goes on, and how far the second's has come, in metres of them; with
    /// derivatives.
    fn rotation_progress(&self, s: f64) -> [[f64; 3]; 2] {
        // The polynomial of degree five that grows from 0 with slope 0 to the reach with slope 1, with no bend at
        // either end.
        let (length, reach) = (self.length(), self.reach);
        let (c3, c4, c5) = (
            10.0 * reach - 4.0 * length,
            7.0 * length - 15.0 * reach,
            6.0 * reach - 3.0 * length,
        );
        let come = |s: f64| {
            let t = within(s / length, 0.0, 1.0);
            [
                t * t * t * (c3 + t * (c4 + t * c5)),
                t * t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)) / length,
                t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5)) / (length * length),
            ]
        };
        let left = come(length - s);
        [[-left[0], left[1], -left[2]], come(s)]
    }

    /// TCP pose at s.
    pub fn pose(&self, s: f64) -> Pose {
        let [x, y, ..] = self.plane(s);
        let [first, second] = self.rotation_progress(s);
        let rotation = rotation_from_rotvec(self.turn_rates[1] * second[0])
            * rotation_from_rotvec(self.turn_rates[0] * first[0])
            * self.corner.rotation;
        Pose::new(rotation, self.start + self.along * x + self.across * y)
    }

    /// Joint positions at s, nearest to `near`.
    pub fn positions(
        &self,
        model: &RobotModel,
        s: f64,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        model.inverse_continuous(&self.pose(s), &self.flange_from_tcp, near)
    }

    /// The derivatives at joint positions `q` that lie on the way at s; `None` where the Jacobian is singular.
    pub fn point(&self, model: &RobotModel, s: f64, q: JointPositions) -> Option<PathPoint> {
        let [.., direction, curvature] = self.plane(s);
        let (sin, cos) = sin_cos(direction);
        let [first, second] = self.rotation_progress(s);
        let by_second = rotation_from_rotvec(self.turn_rates[1] * second[0]);
        let before = by_second * self.turn_rates[0];
        let omega = self.turn_rates[1] * second[1];
        let bent = PathTwist {
            linear: self.along * cos + self.across * sin,
            linear_rate: (self.across * cos - self.along * sin) * curvature,
            angular: omega + before * first[1],
            angular_rate: self.turn_rates[1] * second[2]
                + omega.cross(&before) * first[1]
                + before * first[2],
        };
        derivatives(model, &self.flange_from_tcp, s, q, |_| bent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: [f64; 3], to: [f64; 3]) -> CartesianPath {
        let pose = |xyz: [f64; 3]| Pose::from_translation(xyz[0], xyz[1], xyz[2]);
        CartesianPath::line(pose(from), pose(to), Pose::IDENTITY, JointPositions::ZERO)
    }

    #[test]
    fn it_leads_from_line_to_line_with_its_derivatives() {
        for (to, room) in [
            ([0.3, 0.2, 0.0], 1.0),
            ([0.2, 0.005, 0.01], 0.02),
            ([0.1, 0.1, 0.1], 0.05),
        ] {
            let first = line([0.0; 3], [0.2, 0.0, 0.0]);
            let second = line([0.2, 0.0, 0.0], [0.2 + to[0], to[1], to[2]]);
            let turn = ClothoidBlend::between(&first, &second, (0.04, room), 0.003).unwrap();
            assert!(turn.reach() <= room + 1e-12);
            let (begin, end) = (
                turn.pose(0.0).translation,
                turn.pose(turn.length()).translation,
            );
            assert!((begin - first.pose(0.2 - turn.reach()).translation).norm() < 1e-12);
            assert!(
                (end - second.pose(turn.reach()).translation).norm() < 1e-10,
                "{end}"
            );
            assert!((turn.rotation_progress(0.0)[0][1] - 1.0).abs() < 1e-12);
            assert!((turn.rotation_progress(turn.length())[1][1] - 1.0).abs() < 1e-12);
            let h = 1e-6;
            for k in 1..100 {
                let s = turn.length() * f64::from(k) / 100.0;
                let (before, after) = (turn.pose(s - h).translation, turn.pose(s + h).translation);
                let [.., direction, curvature] = turn.plane(s);
                let tangent = turn.along * direction.cos() + turn.across * direction.sin();
                assert!(((after - before) / (2.0 * h) - tangent).norm() < 1e-8);
                // What is left of the first line's turning, and what has come of the second's.
                for (k, (before, after)) in turn
                    .rotation_progress(s - h)
                    .iter()
                    .zip(turn.rotation_progress(s + h))
                    .enumerate()
                {
                    let [_, slope, bend] = turn.rotation_progress(s)[k];
                    assert!((slope - (after[0] - before[0]) / (2.0 * h)).abs() < 1e-6);
                    assert!((bend - (after[1] - before[1]) / (2.0 * h)).abs() < 1e-3);
                }
                assert!(curvature >= 0.0 && curvature <= turn.curvature + 1e-12);
            }
        }
    }

    #[test]
    fn with_room_its_arc_touches_both_lines_where_it_was_asked_to() {
        let first = line([0.0; 3], [0.2, 0.0, 0.0]);
        let second = line([0.2, 0.0, 0.0], [0.2, 0.2, 0.0]);
        let turn = ClothoidBlend::between(&first, &second, (0.04, 0.1), 0.003).unwrap();
        // The arc of radius 40 mm about (0.16, 0.04).
        let middle = turn.pose(turn.length() / 2.0).translation;
        let away = (middle - Vector3::new(0.16, 0.04, 0.0)).norm();
        assert!((away - 0.04).abs() < 0.04 * 0.002, "{away}");
    }
}
