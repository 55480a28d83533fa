//! How hard a motion along a track will speed up and slow down, and what of a motion need not be stepped through to
//! know that.

use super::{MAX_PREDICTION_STEPS, PathProgress, STEPS};
use crate::scalar::{ProgressGoal, VelocityLimitCurve};

impl PathProgress {
    /// The largest acceleration, either way, of the motion from the place `from` on to the end of the track at full
    /// speed.
    pub fn hardest(&self, track: &VelocityLimitCurve, from: f64) -> f64 {
        let mut travel = *self;
        travel.wanted = ProgressGoal::Run(travel.time_scale);
        travel.pace = 1.0;
        if travel.is_at_rest() && travel.knots[0].s < track.end() {
            travel.start_from_rest(1.0, track);
            travel.wanted = ProgressGoal::Run(1.0);
        }
        let window = travel.step * STEPS as f64;
        let mut most = 0.0_f64;
        for _ in 0..MAX_PREDICTION_STEPS {
            if travel.knots[0].s >= track.end() {
                break;
            }
            if travel.middle() >= from {
                let change = travel.knots[STEPS].speed - travel.knots[0].speed;
                most = most.max(change.abs() / window);
            }
            travel.skip_evenly(track, f64::INFINITY);
            travel.advance_knot(track);
        }
        most * travel.time_scale * travel.time_scale
    }

    /// Where the speed stays the same, at most until `s`, nothing has to be stepped through; the time skipped, s.
    pub(super) fn skip_evenly(&mut self, track: &VelocityLimitCurve, place: f64) -> f64 {
        let (first, last) = (self.knots[0], self.knots[STEPS + 1]);
        if first.speed != last.speed || first.speed <= 0.0 {
            return 0.0;
        }
        let even = track.constant_until(last.s, last.speed).min(place);
        let way = even - last.s - last.speed * (track.window() + 2.0 * self.step);
        let steps = (way / (last.speed * self.step)).floor();
        if steps < 1.0 {
            return 0.0;
        }
        let skipped = steps * self.step;
        self.knots
            .iter_mut()
            .for_each(|knot| knot.s += knot.speed * skipped);
        skipped
    }
}
