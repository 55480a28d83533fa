//! How the arm stops: protective and emergency stops, and coming to rest on the path.
//!
//! Owns what ends with a stop and where the braking begins; the braking itself is in `brake` and on the path of the motion.

use motion_api::{CommandId, Outcome, StopReason};

use crate::brake::{Brake, JointBrake};
use crate::cycle::{Cycle, Generator};
use crate::machine::Machine;

impl Cycle {
    /// Enters a protective stop that begins with the next setpoint.
    pub(crate) fn brake(&mut self, reason: StopReason) {
        let brake = self.protective_stop(reason);
        self.generator = Generator::Brake(brake);
    }

    /// A protective stop that somebody asked for; nothing new for an arm that brakes already.
    pub(crate) fn stop_on_request(&mut self) {
        let reason = StopReason::Requested;
        let brakes = matches!(self.generator, Generator::Brake(_));
        if self.is_under_servo() && !brakes {
            self.brake(reason);
        } else if self.machine.protective_stop(reason) {
            self.out.stopped(reason);
        }
    }

    /// Power and brakes take time; safety inputs are looked at.
    pub(crate) fn advance_machine(&mut self) {
        if self.machine.advance(self.step) {
            self.stand_at_actual();
        }
        let lines = self.safety_inputs.lines(self.io.image.digital_in);
        self.look_for_emergency(|machine| machine.observe(lines));
    }

    /// Where `begins` says that an emergency stop begins, the joints brake; once they stand the power goes off.
    pub(crate) fn look_for_emergency(&mut self, begins: impl FnOnce(&mut Machine) -> bool) {
        let is_held_by_servos = self.is_under_servo();
        if !begins(&mut self.machine) {
            return;
        }
        let reason = StopReason::EmergencyStop;
        self.out.stopped(reason);
        if is_held_by_servos && !matches!(self.generator, Generator::Brake(_)) {
            let brake = self.brake_from_target(reason);
            self.generator = Generator::Brake(brake);
        }
    }

    /// Reports a protective stop, ends the motion with it, and gives the braking from the present target.
    pub(crate) fn protective_stop(&mut self, reason: StopReason) -> Brake {
        if self.machine.protective_stop(reason) {
            self.out.stopped(reason);
        }
        self.brake_from_target(reason)
    }

    /// Ends the motion with `reason` and gives the braking from the present target.
    fn brake_from_target(&mut self, reason: StopReason) -> Brake {
        self.end_motions(Outcome::ProtectiveStop(reason));
        let is_for_plane = matches!(reason, StopReason::SafetyPlane { .. });
        let brake = match &self.generator {
            Generator::Path(motion) if is_for_plane && self.must_halt_on_path() => {
                Brake::on_path(*motion)
            }
            _ => Brake::Joints(JointBrake::new(&self.commanded, self.limit_sets.able())),
        };
        self.is_paused = false;
        self.holding = None;
        self.lag = None;
        self.tracking = None;
        self.path_offset.end();
        self.force.pressing = None;
        self.target = self.commanded;
        brake
    }

    /// Ends the commands of every motion under way or to come.
    pub(crate) fn end_motions(&mut self, outcome: Outcome) {
        self.end_legs(outcome);
        if let Generator::Online(online) = &self.generator
            && online.id != CommandId::NONE
            && !online.has_ended()
        {
            self.out.ended(online.id, outcome);
        }
        if let Some(upcoming) = self.upcoming.take() {
            self.out.ended(upcoming.id, outcome);
        }
        if let Some(deferred) = self.deferred.take() {
            self.out.ended(deferred.id, outcome);
        }
    }

    /// Brings a moving arm to rest on its path, as a stop command would; for the end of the controller.
    pub fn stop_moving(&mut self) {
        if let Some(deferred) = self.deferred.take() {
            self.out.ended(deferred.id, Outcome::Aborted);
        }
        if let Some(upcoming) = self.upcoming.take() {
            self.out.ended(upcoming.id, Outcome::Aborted);
        }
        match &mut self.generator {
            Generator::Online(online) => online.stop(&self.target),
            Generator::Path(motion) => motion.is_stopping = true,
            Generator::Hold | Generator::Brake(_) => {}
        }
    }
}
