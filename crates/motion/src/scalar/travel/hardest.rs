//! How hard a motion along a track will speed up and slow down, and what of a motion need not be stepped through to know that.

use super::{FORESEEN, STEPS, Travel};
use crate::scalar::{Drive, Track};

impl Travel {
    /// The largest acceleration, either way, of the motion from the place `from` on to the end of the track at full speed.
    pub fn hardest(&self, track: &Track, from: f64) -> f64 {
        let mut travel = *self;
        travel.wanted = Drive::Go(travel.rate);
        travel.pace = 1.0;
        if travel.rests() && travel.knots[0].place < track.end() {
            travel.begin(1.0, track);
            travel.wanted = Drive::Go(1.0);
        }
        let window = travel.step * STEPS as f64;
        let mut most = 0.0_f64;
        for _ in 0..FORESEEN {
            if travel.knots[0].place >= track.end() {
                break;
            }
            if travel.middle() >= from {
                let change = travel.knots[STEPS].speed - travel.knots[0].speed;
                most = most.max(change.abs() / window);
            }
            travel.skip_evenly(track, f64::INFINITY);
            travel.step_on(track);
        }
        most * travel.rate * travel.rate
    }

    /// Where the speed stays the same, at most until `place`, nothing has to be stepped through; the time skipped, s.
    pub(super) fn skip_evenly(&mut self, track: &Track, place: f64) -> f64 {
        let (first, last) = (self.knots[0], self.knots[STEPS + 1]);
        if first.speed != last.speed || first.speed <= 0.0 {
            return 0.0;
        }
        let even = track.even_until(last.place, last.speed).min(place);
        let way = even - last.place - last.speed * (track.window() + 2.0 * self.step);
        let steps = (way / (last.speed * self.step)).floor();
        if steps < 1.0 {
            return 0.0;
        }
        let skipped = steps * self.step;
        self.knots
            .iter_mut()
            .for_each(|knot| knot.place += knot.speed * skipped);
        skipped
    }
}
