//! The way of the TCP as a polyline of few points: what people look at beside the distances.

use core::mem;

use elite_runtime::message::Observer;
use kinematics::RpyPose;
use motion_api::{CycleFrame, ProgramId};
use parking_lot::Mutex;

/// How far the polyline may be from the way at first, m.
const TOLERANCE: f64 = 0.0005;
/// Most points of the polyline.
const POINTS_MAX: usize = 4000;
/// Most points that one line of the polyline stands for, which bounds the time that a point takes.
const LINE_POINTS_MAX: usize = 200;
/// Most pieces of the polyline. Of a program that changes its TCP more often the rest is left out.
const PIECES_MAX: usize = 400;

/// The way of the TCP, base frame, m.
#[derive(Clone, Debug, PartialEq)]
pub struct TcpPath {
    /// Polylines, one behind the other: a new one begins where the TCP itself has become another one.
    pub pieces: Vec<Vec<[f64; 3]>>,
    /// How far the way is from them at most, m.
    pub tolerance: f64,
}

/// Makes a polyline of few points from many.
#[derive(Debug)]
struct PathReducer {
    pieces: Vec<Vec<[f64; 3]>>,
    /// Points of all pieces.
    count: usize,
    /// Points since the last one that is kept.
    pending: Vec<[f64; 3]>,
    /// There are so many pieces that the rest is left out.
    is_full: bool,
    /// How far a line may be from the points that it stands for now, m.
    step: f64,
    /// What all reductions together may have taken away, m.
    tolerance: f64,
}

impl Default for PathReducer {
    fn default() -> Self {
        Self {
            pieces: Vec::new(),
            count: 0,
            pending: Vec::new(),
            is_full: false,
            step: TOLERANCE,
            tolerance: TOLERANCE,
        }
    }
}

impl PathReducer {
    /// The next point goes on from the last one.
    fn push(&mut self, point: [f64; 3]) {
        if self.is_full {
            return;
        }
        let Some(&last) = self.pieces.last().and_then(|piece| piece.last()) else {
            return self.begin_piece(point);
        };
        if self.pending.last().unwrap_or(&last) == &point {
            return;
        }
        let is_straight = self.pending.len() < LINE_POINTS_MAX
            && self
                .pending
                .iter()
                .all(|passed| distance_to_line(passed, &last, &point) <= self.step);
        if !is_straight {
            self.keep_pending();
        }
        self.pending.push(point);
    }

    /// The next point does not go on from the last one.
    fn begin_piece(&mut self, point: [f64; 3]) {
        self.keep_pending();
        self.is_full |= self.pieces.len() >= PIECES_MAX;
        if !self.is_full {
            self.pieces.push(vec![point]);
            self.count += 1;
        }
    }

    /// Ends the line at the last point.
    fn keep_pending(&mut self) {
        let Some(end) = mem::take(&mut self.pending).pop() else {
            return;
        };
        if let Some(piece) = self.pieces.last_mut() {
            piece.push(end);
            self.count += 1;
        }
        if self.count >= POINTS_MAX {
            self.coarsen();
        }
    }

    /// Takes lines together until there is room again.
    fn coarsen(&mut self) {
        self.step *= 2.0;
        self.tolerance += self.step;
        let mut coarse = Self {
            step: self.step,
            tolerance: self.tolerance,
            ..Self::default()
        };
        for piece in mem::take(&mut self.pieces) {
            let mut points = piece.into_iter();
            if let Some(first) = points.next() {
                coarse.begin_piece(first);
            }
            points.for_each(|point| coarse.push(point));
        }
        coarse.keep_pending();
        *self = coarse;
    }

    fn finish(mut self) -> TcpPath {
        self.keep_pending();
        TcpPath {
            pieces: self.pieces,
            tolerance: self.tolerance,
        }
    }
}

/// Distance of a point to the line between two others, m.
fn distance_to_line(point: &[f64; 3], from: &[f64; 3], to: &[f64; 3]) -> f64 {
    let minus = |a: &[f64; 3], b: &[f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (line, out) = (minus(to, from), minus(point, from));
    let length = dot(&line, &line);
    let fraction = match length > 0.0 {
        true => (dot(&line, &out) / length).clamp(0.0, 1.0),
        false => 0.0,
    };
    let foot = line.map(|part| part * fraction);
    let off = minus(&out, &foot);
    dot(&off, &off).sqrt()
}

/// Follows the TCP of the newest program.
#[derive(Default)]
pub(super) struct TcpPathObserver {
    followed: Mutex<FollowedTcp>,
}

#[derive(Default)]
struct FollowedTcp {
    has_begun: bool,
    reducer: PathReducer,
    /// The TCP relative to the flange in the cycle before.
    tcp: Option<RpyPose>,
}

impl TcpPathObserver {
    /// The way so far.
    pub(super) fn path(&self) -> TcpPath {
        mem::take(&mut self.followed.lock().reducer).finish()
    }
}

impl Observer for TcpPathObserver {
    fn program_compiled(&self, _: ProgramId, _: &str) {
        self.followed.lock().has_begun = true;
    }

    fn cycle_ended(&self, frame: &CycleFrame) {
        let followed = &mut *self.followed.lock();
        if !followed.has_begun {
            return;
        }
        let state = &frame.state;
        let point = state.actual_tcp_pose.xyz;
        match followed.tcp.replace(state.tcp_offset) {
            Some(tcp) if tcp != state.tcp_offset => followed.reducer.begin_piece(point),
            _ => followed.reducer.push(point),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path of the reducer, and how far the points are from it at most.
    fn reduced(points: &[[f64; 3]]) -> (TcpPath, f64) {
        let mut reducer = PathReducer::default();
        points.iter().for_each(|point| reducer.push(*point));
        let path = reducer.finish();
        let lines = path.pieces.iter().flat_map(|piece| piece.windows(2));
        let lines: Vec<_> = lines.map(|line| (line[0], line[1])).collect();
        let off = points.iter().map(|point| {
            let off = lines
                .iter()
                .map(|(from, to)| distance_to_line(point, from, to));
            off.fold(f64::INFINITY, f64::min)
        });
        let off = off.fold(0.0, f64::max);
        (path, off)
    }

    #[test]
    fn straight_lines_have_few_points_and_turns_are_kept() {
        let there = (0..=100).map(|k| [f64::from(k) * 0.005, 0.0, 0.3]);
        let back = (0..100).rev().map(|k| [f64::from(k) * 0.005, 0.0, 0.3]);
        let points: Vec<_> = there.chain(back).collect();
        let (path, off) = reduced(&points);
        let [piece] = &path.pieces[..] else {
            panic!("{path:?}");
        };
        assert!(piece.len() <= 4, "{piece:?}");
        assert_eq!((piece[0], piece[piece.len() - 1]), (points[0], points[200]));
        assert!(off <= TOLERANCE && path.tolerance == TOLERANCE, "{off}");
    }

    #[test]
    fn a_long_way_stays_bounded_and_says_how_coarse_it_became() {
        let points: Vec<_> = (0..60_000)
            .map(|k| {
                let angle = f64::from(k) * 0.05;
                let radius = 0.05 + f64::from(k) * 1e-5;
                [radius * angle.cos(), radius * angle.sin(), 0.1]
            })
            .collect();
        let mut reducer = PathReducer::default();
        points.iter().for_each(|point| reducer.push(*point));
        let path = reducer.finish();
        let [piece] = &path.pieces[..] else {
            panic!("{} pieces", path.pieces.len());
        };
        assert!(piece.len() <= POINTS_MAX + 1, "{}", piece.len());
        assert!(path.tolerance > TOLERANCE);
        // The lines come in the order of the way: a point is looked for beside those that follow the last one's.
        let mut line = 0;
        for point in &points {
            let near = |line: usize| distance_to_line(point, &piece[line], &piece[line + 1]);
            while near(line) > path.tolerance {
                line += 1;
                assert!(line + 1 < piece.len(), "{point:?} is beside the polyline");
            }
        }
    }

    #[test]
    fn another_tcp_begins_another_piece_up_to_a_bound() {
        let mut reducer = PathReducer::default();
        for k in 0..2 * PIECES_MAX {
            reducer.begin_piece([k as f64, 0.0, 0.0]);
            reducer.push([k as f64, 0.1, 0.0]);
        }
        let path = reducer.finish();
        assert_eq!(path.pieces.len(), PIECES_MAX);
        assert!(path.pieces.iter().all(|piece| piece.len() == 2));
        assert_eq!(path.pieces[7], [[7.0, 0.0, 0.0], [7.0, 0.1, 0.0]]);
    }
}
