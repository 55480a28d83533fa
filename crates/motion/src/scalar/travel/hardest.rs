//! How hard a motion along a track will speed up and slow down.

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
}
