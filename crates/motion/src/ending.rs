//! What comes to its end in a cycle, and whether the arm stands.
//!
//! Owns when commands end and who is told; how a motion comes to its end is in `queue`, `modes` and `brake`.

use motion_api::Outcome;

use crate::constants::RESTING_SPEED;
use crate::cycle::{ControlLoop, Generator};
use crate::modes::conveyor::ConveyorTracking;
use crate::modes::is_setpoint_at_rest;
use crate::waiting::RestCommand;

impl ControlLoop {
    /// Ends what has come to its end in this cycle.
    pub(crate) fn complete_finished_commands(&mut self) {
        self.settle_tracking();
        match &self.generator {
            Generator::Online(online) if online.is_over(&self.target) => {
                if !online.has_ended() {
                    self.out.report_end(online.id, Outcome::Aborted);
                }
                self.generator = Generator::Hold;
            }
            // What the arm has to make good first belongs to the motion.
            Generator::Path(motion)
                if motion.is_stopping
                    || self.joint_hold.is_none() && !self.has_lag_to_recover() =>
            {
                self.complete_path_commands();
            }
            Generator::Stop(brake)
                if brake.has_settled(
                    &self.queue,
                    self.actual.state().qd.max_abs() < RESTING_SPEED,
                ) =>
            {
                // The arm may have been held up: from now on it is wanted where it stands, and the brakes hold it
                // there.
                self.generator = Generator::Hold;
                self.reset_target_to_actual();
            }
            _ => {}
        }
        self.settle_force_mode();
        self.settle_path_offset();
        if !self.is_standing() {
            self.end_stops_before_the_next_motion();
            return;
        }
        if self.rest_commands.contains(RestCommand::PowerOff) || self.machine.is_emergency() {
            self.machine.power_off();
        }
        while let Some(id) = self.rest_commands.take(|_| true) {
            self.out.report_end(id, Outcome::Done);
        }
    }

    /// A motion that waits for the arm to stand is about to move it: whoever waits for the stop before need not wait
    /// for that.
    fn end_stops_before_the_next_motion(&mut self) {
        let is_braked = self.joint_hold.is_none() && is_setpoint_at_rest(self.commanded.setpoint());
        if is_braked && self.deferred.is_some() && matches!(self.generator, Generator::Hold) {
            while let Some(id) = self.rest_commands.take(|kind| kind == RestCommand::Stop) {
                self.out.report_end(id, Outcome::Done);
            }
        }
    }

    /// Ends the commands whose ends, or zones, the arm has reached on its path, and tells who may send the next one.
    fn complete_path_commands(&mut self) {
        let Generator::Path(motion) = &self.generator else {
            return;
        };
        if motion.is_stopping && self.queue.is_standing(motion) {
            self.end_legs(Outcome::Aborted);
            self.generator = Generator::Hold;
            return;
        }
        while let Some(leg) = self.queue.newly_reached_segment(motion) {
            leg.has_ended = true;
            let (id, outcome) = (leg.id, leg.outcome());
            self.out.report_end(id, outcome);
        }
        if self.queue.is_over(motion) {
            self.queue.note_overrun(motion);
            self.generator = Generator::Hold;
            return;
        }
        if self.pending_motion.is_some() {
            return;
        }
        let due = self.queue.urges_next(motion).map(|leg| {
            leg.is_urged = true;
            leg.id
        });
        // What is due may be sent.
        if let Some(leg) = self.queue.segment_needing_successor(motion) {
            leg.is_ready_for_next_sent = true;
            let id = leg.id;
            self.out.report_ready_for_next(id);
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
        for leg in self.queue.unfinished_segments() {
            leg.has_ended = true;
            self.out.report_end(leg.id, outcome);
        }
    }

    /// True when no setpoint moves: nothing to do, or held on the path.
    pub fn is_standing(&self) -> bool {
        if self.joint_hold.is_some() {
            return is_setpoint_at_rest(self.commanded.setpoint()) && self.is_base_motion_at_rest();
        }
        if self.lag.is_some() {
            return false;
        }
        if self
            .tracking
            .as_ref()
            .is_some_and(ConveyorTracking::is_stopping)
        {
            return false;
        }
        let offset = &self.path_offset;
        if offset.is_coming_to_rest() || self.is_held() && !offset.is_standing() {
            return false;
        }
        // While it is held force mode comes to rest as well; otherwise it moves the arm all the time.
        if self.force.is_active()
            && self.is_held()
            && !is_setpoint_at_rest(self.commanded.setpoint())
        {
            return false;
        }
        self.is_base_motion_at_rest()
    }

    /// True when the arm stands, and nothing that is laid over motions moves it either.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.is_standing() && is_setpoint_at_rest(self.commanded.setpoint())
    }

    fn is_base_motion_at_rest(&self) -> bool {
        match &self.generator {
            Generator::Hold => self.pending_motion.is_none() && self.deferred.is_none(),
            Generator::Path(motion) => self.queue.is_standing(motion),
            Generator::Online(_) => self.is_held() && is_setpoint_at_rest(&self.target),
            Generator::Stop(_) => false,
        }
    }
}
