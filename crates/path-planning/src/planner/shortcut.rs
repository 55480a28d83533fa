//! Shorter paths: corners that nobody needs go, others move to where the path is shorter.

use kinematics::random::RandomSequence;
use kinematics::{JointLimits, JointPositions};

use super::edge::ClearanceCheck;
use super::length;
use crate::tracker::interpolate;

/// Shortcuts that are tried between random places of a path.
const SHORTCUTS: u32 = 150;

/// Corners nearer to each other than this leave no room for blends, rad.
const NEAR_CORNERS: f64 = 0.25;

/// Shortest gain that is worth a corner, rad.
const LEAST_GAIN: f64 = 1e-3;

/// Makes a path shorter. Its ends stay.
pub(super) fn shorten(
    path: &mut Vec<JointPositions>,
    check: &mut ClearanceCheck<'_>,
    limits: &JointLimits,
    random: &mut RandomSequence,
    should_stop: &mut dyn FnMut() -> bool,
) {
    drop_corners(path, check);
    for _ in 0..SHORTCUTS {
        if path.len() < 3 || should_stop() {
            break;
        }
        let whole = length(path);
        let mut ends = [random.between(0.0, whole), random.between(0.0, whole)];
        ends.sort_by(f64::total_cmp);
        let [first, second] = ends.map(|way| place(path, way));
        if first.0 == second.0 {
            continue;
        }
        let between = length_between(path, first, second);
        let direct = first.1.distance_squared(&second.1).sqrt();
        if between - direct < LEAST_GAIN || !check.is_clear(&first.1, &second.1) {
            continue;
        }
        path.splice(first.0 + 1..=second.0, [first.1, second.1]);
        path.dedup_by(|a, b| a.distance_squared(b) < 1e-18);
    }
    drop_corners(path, check);
    tighten_corners(path, check);
    join_corners(path, check, limits);
    drop_corners(path, check);
}

/// Makes one corner of two that are near each other, in the middle or a little outside of it.
fn join_corners(
    path: &mut Vec<JointPositions>,
    check: &mut ClearanceCheck<'_>,
    limits: &JointLimits,
) {
    let mut at = 1;
    while at + 2 < path.len() {
        let (before, first, second, after) = (path[at - 1], path[at], path[at + 1], path[at + 2]);
        let is_near = first.distance_squared(&second).sqrt() < NEAR_CORNERS;
        let ends = interpolate(&before, &after, 0.5);
        let middle = interpolate(&first, &second, 0.5);
        let outside: &[f64] = match is_near {
            true => &[0.0, 0.05, 0.1, 0.2, 0.3],
            false => &[],
        };
        let joined = outside
            .iter()
            .map(|outside| interpolate(&ends, &middle, 1.0 + outside))
            .filter(|joined| limits.contains(joined))
            .find(|joined| check.is_clear(&before, joined) && check.is_clear(joined, &after));
        match joined {
            Some(joined) => {
                path.splice(at..at + 2, [joined]);
            }
            None => at += 1,
        }
    }
}

/// Leaves out corners between which the joints can go straight, the longest stretches first.
fn drop_corners(path: &mut Vec<JointPositions>, check: &mut ClearanceCheck<'_>) {
    let mut at = 0;
    while at + 2 < path.len() {
        let farthest = (at + 2..path.len()).rev();
        for to in farthest {
            if check.is_clear(&path[at], &path[to]) {
                path.drain(at + 1..to);
                break;
            }
        }
        at += 1;
    }
}

/// Moves every corner towards the line between its neighbours for as long as the lines to them stay clear.
fn tighten_corners(path: &mut [JointPositions], check: &mut ClearanceCheck<'_>) {
    for _ in 0..3 {
        for at in 1..path.len().saturating_sub(1) {
            let (before, corner, after) = (path[at - 1], path[at], path[at + 1]);
            let along = before.distance_squared(&corner).sqrt();
            let whole = along + corner.distance_squared(&after).sqrt();
            if whole == 0.0 {
                continue;
            }
            let straight = interpolate(&before, &after, along / whole);
            let mut share = 0.8;
            while share > 0.05 {
                let moved = interpolate(&corner, &straight, share);
                if check.is_clear(&before, &moved) && check.is_clear(&moved, &after) {
                    path[at] = moved;
                    break;
                }
                share /= 2.0;
            }
        }
    }
}

/// The place so far along a path: the number of the corner before it, and the joint positions.
fn place(path: &[JointPositions], way: f64) -> (usize, JointPositions) {
    let mut left = way;
    for (number, ends) in path.windows(2).enumerate() {
        let [from, to] = ends else { continue };
        let piece = from.distance_squared(to).sqrt();
        if left <= piece && piece > 0.0 {
            return (number, interpolate(from, to, left / piece));
        }
        left -= piece;
    }
    let last = path.len() - 1;
    (last.saturating_sub(1), path[last])
}

/// The way along a path between two places of it, rad.
fn length_between(
    path: &[JointPositions],
    first: (usize, JointPositions),
    second: (usize, JointPositions),
) -> f64 {
    let mut corners = vec![first.1];
    corners.extend_from_slice(&path[first.0 + 1..=second.0]);
    corners.push(second.1);
    length(&corners)
}
