//! What comes to its end in a cycle, and whether the arm stands.
//!
//! Owns when commands end and who is told; how a motion comes to its end is in `queue`, `modes` and `brake`.

use motion_api::Outcome;

use crate::constants::RESTING_SPEED;
use crate::cycle::{Cycle, Generator};
use crate::modes::conveyor::Tracking;
use crate::modes::stands;
use crate::waiting::WaitingFor;

impl Cycle {
    /// Ends what has come to its end in this cycle.
    pub(crate) fn settle(&mut self) {
        self.settle_tracking();
        match &self.generator {
            Generator::Online(online) if online.is_over(&self.target) => {
                if !online.has_ended() {
                    self.out.ended(online.id, Outcome::Aborted);
                }
                self.generator = Generator::Hold;
            }
            // What the arm has to make good first belongs to the motion.
            Generator::Path(motion)
                if motion.is_stopping || self.holding.is_none() && !self.is_behind() =>
            {
                self.settle_path();
            }
            Generator::Brake(brake)
                if brake.has_settled(&self.queue, self.actual.qd.max_abs() < RESTING_SPEED) =>
            {
                // The arm may have been held up: from now on it is wanted where it stands, and the brakes hold it there.
                self.generator = Generator::Hold;
                self.stand_at_actual();
            }
            _ => {}
        }
        self.settle_force_mode();
        self.settle_path_offset();
        if !self.is_standing() {
            self.end_stops_before_the_next_motion();
            return;
        }
        if self.waiting.includes(WaitingFor::PowerOff) || self.machine.is_emergency() {
            self.machine.power_off();
        }
        while let Some(id) = self.waiting.take(|_| true) {
            self.out.ended(id, Outcome::Done);
        }
    }

    /// A motion that waits for the arm to stand is about to move it: whoever waits for the stop before need not wait for that.
    fn end_stops_before_the_next_motion(&mut self) {
        let is_braked = self.holding.is_none() && stands(&self.commanded);
        if is_braked && self.deferred.is_some() && matches!(self.generator, Generator::Hold) {
            while let Some(id) = self.waiting.take(|kind| kind == WaitingFor::Stop) {
                self.out.ended(id, Outcome::Done);
            }
        }
    }

    /// Ends the commands whose ends, or zones, the arm has reached on its path, and tells who may send the next one.
    fn settle_path(&mut self) {
        let Generator::Path(motion) = &self.generator else {
            return;
        };
        if motion.is_stopping && self.queue.is_standing(motion) {
            self.end_legs(Outcome::Aborted);
            self.generator = Generator::Hold;
            return;
        }
        while let Some(leg) = self.queue.reached(motion) {
            leg.has_ended = true;
            let (id, outcome) = (leg.id, leg.outcome());
            self.out.ended(id, outcome);
        }
        if self.queue.is_over(motion) {
            self.queue.note_overrun(motion);
            self.generator = Generator::Hold;
            return;
        }
        if self.upcoming.is_some() {
            return;
        }
        let due = self.queue.urges_next(motion).map(|leg| {
            leg.is_urged = true;
            leg.id
        });
        // What is due may be sent.
        if let Some(leg) = self.queue.awaits_next(motion) {
            leg.is_told = true;
            let id = leg.id;
            self.out.queued(id);
        }
        if let Some(id) = due {
            self.out.due(id);
        }
    }

    /// Ends every command whose leg is under way or waits behind it.
    pub(crate) fn end_legs(&mut self, outcome: Outcome) {
        if !matches!(self.generator, Generator::Path(_)) {
            return;
        }
        for leg in self.queue.open() {
            leg.has_ended = true;
            self.out.ended(leg.id, outcome);
        }
    }

    /// True when no setpoint moves: nothing to do, or held on the path.
    pub fn is_standing(&self) -> bool {
        if self.holding.is_some() {
            return stands(&self.commanded) && self.nothing_moves_underneath();
        }
        if self.lag.is_some() {
            return false;
        }
        if self.tracking.as_ref().is_some_and(Tracking::is_stopping) {
            return false;
        }
        let offset = &self.path_offset;
        if offset.is_coming_to_rest() || self.is_held() && !offset.is_standing() {
            return false;
        }
        // While it is held force mode comes to rest as well; otherwise it moves the arm all the time.
        if self.force.is_at_work() && self.is_held() && !stands(&self.commanded) {
            return false;
        }
        self.nothing_moves_underneath()
    }

    /// The same, and nothing that is laid over motions moves the arm either.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.is_standing() && stands(&self.commanded)
    }

    fn nothing_moves_underneath(&self) -> bool {
        match &self.generator {
            Generator::Hold => self.upcoming.is_none() && self.deferred.is_none(),
            Generator::Path(motion) => self.queue.is_standing(motion),
            Generator::Online(_) => self.is_held() && stands(&self.target),
            Generator::Brake(_) => false,
        }
    }
}
