//! When the next motion has to follow, and what the arm does lest it does not.
//!
//! Nothing slows down for a program that is in time. While it is not known what follows a leg with a zone, the arm
//! brakes for a stop exactly at the waypoint, as late and as hard as it can. The sender is told twice: that the next
//! may be sent, and that it is due, before the arm begins to brake, and while it can still be slow enough for any
//! corner. What a program does between two motions it does when the zone is entered, or when the next one is due where
//! that is before: where the zone is short for the speed.

use super::{MotionQueue, PathMotion, QueuedSegment};
use crate::constants::{
    BLEND_ACCELERATION_FACTOR, DUE_SHARE, LATE_CURVE, LATE_TIME, LEAD_TIME, READY_FOR_NEXT_LEAD,
    SLOW_SHARE,
};
use crate::path::Path;
use crate::scalar::Zone;

/// By when, on the route, it has to be known what follows, so that the arm is slow enough for any corner.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    /// The place of the first motion.
    by: f64,
    /// How fast that motion may be at the place, and how hard it can brake for that.
    speed: f64,
    braking: f64,
}

impl MotionQueue {
    /// Keeps the arm able to stop at the end of the last leg, braking as late and as hard as it can, and works out by
    /// when the next has to be known lest a corner comes too late. The leg's pace is set before, speeds are worked out
    /// afterwards.
    pub(super) fn open_zone(&mut self, last: &mut QueuedSegment, rate: f64) {
        if last.leg.radius <= 0.0 {
            return;
        }
        let (end, half) = (self.track.end(), 0.5 * self.track.window());
        let bears = self.track.bears(last.blend_start);
        let least = |[rest, fast]: [f64; 2]| rest.min(fast);
        let asked = least(bears.braking);
        let is_joint = matches!(last.leg.path, Path::Joint(_)) && last.leg.request.duration <= 0.0;
        let times = if is_joint {
            BLEND_ACCELERATION_FACTOR
        } else {
            f64::INFINITY
        };
        let hardest = least(bears.planned).min(times * asked).max(asked);
        let braking = |from: f64, to: f64| (from * from - to * to).max(0.0) / (2.0 * hardest);
        let length = end - last.blend_start;
        let (fast, turning) = (bears.speed, last.leg.blend_entry_speed / rate);
        // How far the arm is ahead of where it seems to be, and goes until the next motion is planned.
        let reach = fast * (half + LATE_TIME);
        let is_process = last.leg.arc_tangent_distance > 0.0;
        let mut zone = Zone {
            hard_from: last.blend_start.min(end - braking(fast, 0.0) - reach),
            times,
            ..Zone::NONE
        };
        // A process move's curve touches at its radius, so it begins with its zone.
        let share = if is_process { 0.0 } else { DUE_SHARE };
        last.corner = Corner {
            by: last.blend_start + share * length,
            speed: f64::INFINITY,
            braking: hardest,
        };
        if fast > turning {
            let slow = LATE_CURVE.1 * turning;
            // What is slow there is so half a window before.
            let from = last.blend_start + LATE_CURVE.0 * length + half * slow;
            let left = end - from;
            let is_unhurried = !is_process
                && last.blend_start + reach + braking(fast, slow) + half * slow <= from
                && slow * slow >= asked * left;
            if is_unhurried {
                // Entered at full speed it is slow enough for any corner where a late curve begins.
                zone.slow_from = from;
                zone.speed = slow;
            } else {
                let by = match is_process {
                    true => last.blend_start - half * turning,
                    false => last.blend_start + SLOW_SHARE * length,
                };
                // A speed at a place bounds the whole cell of the track that the place lies in.
                last.corner.by = self.track.begin_of(by);
                last.corner.speed = slow;
            }
        }
        self.track.set_zone(zone);
    }

    /// The last leg, when the arm is so near to its end that the next had better be there, and its sender does not know
    /// yet.
    pub(crate) fn segment_needing_successor(
        &mut self,
        motion: &PathMotion,
    ) -> Option<&mut QueuedSegment> {
        let window = self.track.window();
        let place = motion.progress.state(&self.track).position;
        let rate = self.route.last()?.rate;
        let has_room = self.has_room();
        let leg = self.legs.last_mut()?;
        let wish = &leg.leg.request;
        let speed = wish.speed / rate;
        let braking = speed * speed * rate / (2.0 * wish.acceleration);
        let ahead = braking + speed * (2.0 * window + READY_FOR_NEXT_LEAD);
        let is_near = leg.leg.radius > 0.0 && (leg.is_urged || leg.blend_start - place < ahead);
        (is_near
            && has_room
            && !leg.is_ready_for_next_sent
            && !leg.has_ended
            && !motion.is_stopping)
            .then_some(leg)
    }

    /// The last leg, when the arm would slow down for its end, or be late for a curve, unless the next comes at once,
    /// and its sender does not know yet.
    pub(crate) fn urges_next(&mut self, motion: &PathMotion) -> Option<&mut QueuedSegment> {
        let travel = &motion.progress;
        let last = self.legs.last()?;
        if last.leg.radius <= 0.0 || last.is_urged || last.has_ended || motion.is_stopping {
            return None;
        }
        let (place, speed) = (travel.committed(), travel.committed_speed());
        let window = self.track.window();
        let asked = self.track.acceleration_at(self.track.index(place), speed);
        let faster = (speed + LATE_TIME * asked).min(self.track.squared_limit(place).sqrt());
        // An arm that still speeds up stops doing so a window before it slows down.
        let ahead = if faster > speed * (1.0 + 1e-9) {
            place + faster * (LATE_TIME + window)
        } else {
            place + speed * LATE_TIME
        };
        let corner = &last.corner;
        let slows_by = if corner.speed.is_finite() {
            let too_fast = (faster * faster - corner.speed * corner.speed).max(0.0);
            too_fast / (2.0 * corner.braking) + faster * (0.5 * window + LEAD_TIME)
        } else {
            0.0
        };
        let is_late_for_curve = ahead + slows_by >= corner.by;
        let slows_down = ahead >= self.track.falls_from()
            && faster * faster >= self.track.squared_limit(ahead) * (1.0 - 1e-9);
        if !is_late_for_curve && !slows_down {
            return None;
        }
        self.legs.last_mut()
    }
}
