//! The joint positions that a trajectory asks for, at even times.
//!
//! Where lines meet, no joint can change its speed at once: the corner is rounded, half a thousandth of a radian at
//! most beside it, evenly before and after.

use messages::text;

use super::check::{CheckedTrajectory, TrajectoryError, TrajectoryLimits, Waypoint};
use crate::names::JOINTS;

/// Farthest that the first point may be from the arm when it is due at once, rad.
const START_MAX: f64 = 0.1;
/// Most samples: what the motion thread takes.
const SAMPLES_MAX: usize = 100_000;
/// How far beside a corner the arm may pass, rad.
const CORNER_MAX: f64 = 5e-4;
/// Share of a joint's acceleration that a corner takes.
const CORNER_SHARE: f64 = 0.5;
/// A position or a speed may be so much beyond a limit by rounding.
const SLACK: f64 = 1e-6;

/// Where the arm is when a trajectory begins, and what it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmStart {
    /// rad.
    pub position: [f64; 6],
    /// rad/s.
    pub speed: [f64; 6],
    /// Highest accelerations of the joints, rad/s².
    pub accelerations: [f64; 6],
}

/// Positions at even times, the first where the trajectory begins.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionSeries {
    /// rad.
    pub positions: Vec<[f64; 6]>,
    /// s.
    pub interval: f64,
}

impl PositionSeries {
    /// The trajectory's time, s.
    pub fn duration(&self) -> f64 {
        self.interval * self.positions.len().saturating_sub(1) as f64
    }

    /// The positions and speeds at a time.
    pub fn at(&self, time: f64) -> ([f64; 6], [f64; 6]) {
        let last = self.positions.len().saturating_sub(1);
        let place = (time / self.interval).clamp(0.0, last as f64);
        let begin = (place as usize).min(last.saturating_sub(1));
        let (a, b) = (self.positions[begin], self.positions[(begin + 1).min(last)]);
        let share = place - begin as f64;
        let is_moving = time > 0.0 && time < self.duration();
        (
            std::array::from_fn(|joint| a[joint] + share * (b[joint] - a[joint])),
            std::array::from_fn(|joint| match is_moving {
                true => (b[joint] - a[joint]) / self.interval,
                false => 0.0,
            }),
        )
    }
}

/// A piece between two points: coefficients of time from its begin.
struct Piece {
    begin: f64,
    end: f64,
    coefficients: [[f64; 6]; 6],
}

impl Piece {
    /// The polynomial that meets everything both waypoints give: a line for positions, a cubic with speeds, a quintic
    /// with accelerations.
    fn between(from: &Waypoint, to: &Waypoint) -> Self {
        let t = to.time - from.time;
        let coefficients = std::array::from_fn(|joint| {
            let (p0, p1) = (from.position[joint], to.position[joint]);
            match (from.speed, to.speed, from.acceleration, to.acceleration) {
                (Some(v0), Some(v1), Some(a0), Some(a1)) => {
                    quintic(t, [p0, v0[joint], a0[joint]], [p1, v1[joint], a1[joint]])
                }
                (Some(v0), Some(v1), ..) => cubic(t, [p0, v0[joint]], [p1, v1[joint]]),
                _ => [p0, (p1 - p0) / t, 0.0, 0.0, 0.0, 0.0],
            }
        });
        Self {
            begin: from.time,
            end: to.time,
            coefficients,
        }
    }

    fn position(&self, time: f64) -> [f64; 6] {
        let t = time - self.begin;
        self.coefficients
            .map(|k| k[0] + t * (k[1] + t * (k[2] + t * (k[3] + t * (k[4] + t * k[5])))))
    }

    fn speed(&self, time: f64) -> [f64; 6] {
        let t = time - self.begin;
        self.coefficients
            .map(|k| k[1] + t * (2.0 * k[2] + t * (3.0 * k[3] + t * (4.0 * k[4] + t * 5.0 * k[5]))))
    }
}

fn cubic(t: f64, [p0, v0]: [f64; 2], [p1, v1]: [f64; 2]) -> [f64; 6] {
    let by = p1 - p0;
    [
        p0,
        v0,
        (3.0 * by - (2.0 * v0 + v1) * t) / (t * t),
        ((v0 + v1) * t - 2.0 * by) / (t * t * t),
        0.0,
        0.0,
    ]
}

fn quintic(t: f64, [p0, v0, a0]: [f64; 3], [p1, v1, a1]: [f64; 3]) -> [f64; 6] {
    let by = p1 - p0;
    let (t2, t3) = (t * t, t * t * t);
    [
        p0,
        v0,
        a0 / 2.0,
        (20.0 * by - (8.0 * v1 + 12.0 * v0) * t - (3.0 * a0 - a1) * t2) / (2.0 * t3),
        (-30.0 * by + (14.0 * v1 + 16.0 * v0) * t + (3.0 * a0 - 2.0 * a1) * t2) / (2.0 * t3 * t),
        (12.0 * by - 6.0 * (v1 + v0) * t + (a1 - a0) * t2) / (2.0 * t3 * t2),
    ]
}

/// The positions of a trajectory from where the arm is, at times `step` apart, or a whole multiple of it where those
/// would be too many.
///
/// # Errors
/// The first point is due at once and too far away, or the trajectory leaves what the arm can do between its points.
pub fn sample(
    trajectory: &CheckedTrajectory,
    start: &ArmStart,
    limits: &TrajectoryLimits,
    step: f64,
) -> Result<PositionSeries, TrajectoryError> {
    let points = with_start(trajectory, start)?;
    let pieces: Vec<Piece> = points
        .windows(2)
        .map(|pair| Piece::between(&pair[0], &pair[1]))
        .collect();
    let end = points.last().map_or(0.0, |last| last.time);
    let multiple = (end / (step * (SAMPLES_MAX - 2) as f64)).ceil().max(1.0);
    let interval = step * multiple;
    // A trajectory that ends between two samples ends at the second.
    let count = (end / interval - 1e-9).ceil().max(1.0) as usize + 1;
    let mut positions = Vec::with_capacity(count);
    let mut index = 0;
    for k in 0..count {
        let time = (k as f64 * interval).min(end);
        while index + 1 < pieces.len() && time >= pieces[index].end {
            index += 1;
        }
        let Some(piece) = pieces.get(index) else {
            positions.push(points[0].position);
            continue;
        };
        let position = piece.position(time);
        within_limits(&position, &piece.speed(time), time, limits)?;
        positions.push(position);
    }
    if let (Some(last), Some(point)) = (positions.last_mut(), points.last()) {
        *last = point.position;
    }
    round_corners(&mut positions, &pieces, interval, start);
    Ok(PositionSeries {
        positions,
        interval,
    })
}

/// The points with the arm's own state as the first, where the trajectory does not begin with one that is due at once.
fn with_start(
    trajectory: &CheckedTrajectory,
    start: &ArmStart,
) -> Result<Vec<Waypoint>, TrajectoryError> {
    let mut points = trajectory.points.clone();
    let first = points[0];
    if first.time > 1e-9 {
        points.insert(
            0,
            Waypoint {
                time: 0.0,
                position: start.position,
                // A curve needs of its start whatever the first point tells.
                speed: first.speed.map(|_| start.speed),
                acceleration: first.acceleration.map(|_| [0.0; 6]),
            },
        );
        return Ok(points);
    }
    for (joint, name) in JOINTS.iter().enumerate() {
        let away = (first.position[joint] - start.position[joint]).abs();
        if away > START_MAX {
            return Err(TrajectoryError::Start { joint: name, away });
        }
    }
    points[0].time = 0.0;
    if points.len() == 1 {
        // A single point that is due at once: the arm goes there as it makes good what it is away.
        let mut end = first;
        end.time = 0.5;
        points.push(end);
    }
    Ok(points)
}

fn within_limits(
    position: &[f64; 6],
    speed: &[f64; 6],
    time: f64,
    limits: &TrajectoryLimits,
) -> Result<(), TrajectoryError> {
    for (joint, name) in JOINTS.iter().enumerate() {
        let beyond = |what, value, limit| TrajectoryError::Limit {
            what,
            joint: name,
            value,
            time,
            limit,
        };
        let (low, high) = limits.positions[joint];
        let most = limits.speeds[joint];
        if position[joint] < low - SLACK {
            return Err(beyond(text!("position", "位置"), position[joint], low));
        }
        if position[joint] > high + SLACK {
            return Err(beyond(text!("position", "位置"), position[joint], high));
        }
        if speed[joint].abs() > most + SLACK {
            return Err(beyond(text!("speed", "速度"), speed[joint], most));
        }
    }
    Ok(())
}

/// Rounds every corner between pieces: a mean over as many samples as the change of speed needs.
fn round_corners(positions: &mut [[f64; 6]], pieces: &[Piece], interval: f64, start: &ArmStart) {
    let sharp = positions.to_vec();
    for pair in pieces.windows(2) {
        let at = pair[0].end;
        let (before, after) = (pair[0].speed(at), pair[1].speed(at));
        let room = (pair[0].end - pair[0].begin).min(pair[1].end - pair[1].begin);
        for joint in 0..6 {
            let change = (after[joint] - before[joint]).abs();
            if change < 1e-9 {
                continue;
            }
            let needed = change / (CORNER_SHARE * start.accelerations[joint].max(1e-3));
            // A mean over `width` passes an eighth of the change times the width beside the corner.
            let allowed = 8.0 * CORNER_MAX / change;
            let width = needed.min(allowed).min(room);
            round_corner(&sharp, positions, joint, (at, width), interval);
        }
    }
}

fn round_corner(
    sharp: &[[f64; 6]],
    positions: &mut [[f64; 6]],
    joint: usize,
    (at, width): (f64, f64),
    interval: f64,
) {
    let half = (width / interval / 2.0).floor() as usize;
    if half == 0 {
        return;
    }
    let corner = (at / interval).round() as usize;
    let last = sharp.len() - 1;
    for k in corner.saturating_sub(half)..=(corner + half).min(last) {
        let (low, high) = (k.saturating_sub(half), (k + half).min(last));
        // Near an end the mean narrows, so that the end stays where it is.
        let reach = (k - low).min(high - k);
        let window = &sharp[k - reach..=k + reach];
        let sum: f64 = window.iter().map(|position| position[joint]).sum();
        positions[k][joint] = sum / window.len() as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: TrajectoryLimits = TrajectoryLimits {
        positions: [(-6.25, 6.25); 6],
        speeds: [3.0; 6],
    };
    const START: ArmStart = ArmStart {
        position: [0.0; 6],
        speed: [0.0; 6],
        accelerations: [20.0; 6],
    };

    fn waypoint(
        time: f64,
        position: f64,
        speed: Option<f64>,
        acceleration: Option<f64>,
    ) -> Waypoint {
        Waypoint {
            time,
            position: [position; 6],
            speed: speed.map(|v| [v; 6]),
            acceleration: acceleration.map(|a| [a; 6]),
        }
    }

    fn sampled(points: &[Waypoint]) -> Result<PositionSeries, TrajectoryError> {
        let trajectory = CheckedTrajectory {
            points: points.to_vec(),
            order: [0, 1, 2, 3, 4, 5],
        };
        sample(&trajectory, &START, &LIMITS, 0.004)
    }

    #[test]
    fn positions_are_joined_by_lines_speeds_by_cubics_accelerations_by_quintics() {
        let line = sampled(&[
            waypoint(1.0, 0.5, None, None),
            waypoint(2.0, 0.6, None, None),
        ])
        .unwrap();
        assert!((line.positions[125][0] - 0.25).abs() < 1e-12);
        assert!((line.positions[375][0] - 0.55).abs() < 1e-12);
        assert_eq!(line.positions.len(), 501);
        let corner = line.positions[250][0];
        assert!((corner - 0.5).abs() <= 6e-4 && corner < 0.5, "{corner}");
        let cubic = sampled(&[waypoint(2.0, 1.0, Some(0.0), None)]).unwrap();
        // Half way in half the time, a quarter of the time: 3/16 - 2/64.
        assert!((cubic.positions[250][0] - 0.5).abs() < 1e-12);
        assert!((cubic.positions[125][0] - 0.156_25).abs() < 1e-12);
        let quintic = sampled(&[waypoint(2.0, 1.0, Some(0.0), Some(0.0))]).unwrap();
        // 10/64 - 15/256 + 6/1024.
        assert!((quintic.positions[125][0] - 0.103_515_625).abs() < 1e-12);
        assert_eq!(quintic.positions[500], [1.0; 6]);
    }

    #[test]
    fn a_trajectory_that_begins_elsewhere_or_leaves_the_limits_is_refused() {
        let far = sampled(&[
            waypoint(0.0, 0.2, None, None),
            waypoint(1.0, 0.3, None, None),
        ]);
        let error = far.unwrap_err().to_string();
        assert!(
            error.contains("0.2000 rad from where shoulder_pan_joint is"),
            "{error}"
        );
        let near = sampled(&[
            waypoint(0.0, 0.05, None, None),
            waypoint(1.0, 0.3, None, None),
        ]);
        assert_eq!(near.unwrap().positions[0], [0.05; 6]);
        let fast = sampled(&[waypoint(0.1, 1.0, None, None)])
            .unwrap_err()
            .to_string();
        assert!(fast.contains("speed 10.0000"), "{fast}");
        let between = sampled(&[
            waypoint(5.0, 6.2, Some(0.0), None),
            waypoint(6.0, 6.2, Some(-2.9), None),
        ]);
        let between = between.unwrap_err().to_string();
        assert!(between.contains("position 6."), "{between}");
        let single = sampled(&[waypoint(0.0, 0.05, None, None)]).unwrap();
        assert_eq!(single.positions.last().unwrap(), &[0.05; 6]);
    }

    #[test]
    fn a_long_trajectory_has_no_more_samples_than_are_taken() {
        let long = sampled(&[waypoint(3600.0, 1.0, None, None)]).unwrap();
        assert!(long.positions.len() <= SAMPLES_MAX);
        assert!((long.duration() - 3600.0).abs() < long.interval);
        let (position, speed) = long.at(1800.0);
        assert!((position[0] - 0.5).abs() < 1e-9 && (speed[0] - 1.0 / 3600.0).abs() < 1e-9);
    }
}
