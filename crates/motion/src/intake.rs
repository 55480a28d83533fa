//! Commands out of the ring and what each of them sets off.
//!
//! Owns the rule when a command is taken: while there is room for all its consequences, at most a fixed number in a
//! cycle, and none after a Cartesian plan, which is the costliest thing a command can ask for.

use kinematics::{Payload, PayloadError, Pose};
use motion_api::{Command, CommandId, CommandKind, MotionMode, Outcome, Refusal, StopReason};

use crate::constants::COMMANDS_PER_CYCLE;
use crate::cycle::{Cycle, Generator};
use crate::motion::{Motion, Plan};
use crate::plan::{Arm, Warnings, Wish, plan_movej};
use crate::waiting::WaitingFor;

/// Whether a command ends at once, and how.
type Answer = Result<Ending, Refusal>;

enum Ending {
    Now,
    Later,
}

impl Cycle {
    /// Takes commands from the ring.
    pub(crate) fn take_commands(&mut self) {
        for _ in 0..COMMANDS_PER_CYCLE {
            let under_way = self.waiting.count() + usize::from(self.running() != CommandId::NONE);
            if self.waiting.is_full() || !self.out.has_room(under_way) {
                return;
            }
            let Ok(command) = self.commands.pop() else {
                return;
            };
            self.out.taken(&command);
            match self.obey(&command) {
                Ok(Ending::Now) => self.out.ended(command.id, Outcome::Done),
                Ok(Ending::Later) => {}
                Err(refusal) => self.out.ended(command.id, Outcome::Refused(refusal)),
            }
        }
    }

    fn obey(&mut self, command: &Command) -> Answer {
        match command.kind {
            CommandKind::MoveJ {
                target,
                acceleration,
                speed,
                duration,
            } => {
                let wish = Wish {
                    speed,
                    acceleration,
                    duration,
                };
                self.begin(command.id, MotionMode::MoveJ, |cycle, arm| {
                    plan_movej(&cycle.target.q, &target, &wish, arm)
                })
            }
            CommandKind::MoveL { .. } => Err(Refusal::Planner { code: 2 }),
            CommandKind::Stop { only } => Ok(self.stop(command.id, only)),
            CommandKind::Pause => {
                self.is_paused = true;
                self.waiting.add(command.id, WaitingFor::Pause);
                Ok(Ending::Later)
            }
            CommandKind::Resume => {
                self.is_paused = false;
                while let Some(id) = self.waiting.take(|kind| kind == WaitingFor::Pause) {
                    self.out.ended(id, Outcome::Done);
                }
                Ok(Ending::Now)
            }
            CommandKind::SetTcp(tcp) => {
                if let Some(value) = tcp.to_array().into_iter().find(|x| !x.is_finite()) {
                    return Err(bad_value(
                        "a component of the TCP",
                        value,
                        "a finite number",
                    ));
                }
                self.tcp = tcp;
                self.flange_from_tcp = Pose::from_rpy(&tcp);
                Ok(Ending::Now)
            }
            CommandKind::SetPayload(payload) => self.set_payload(&payload),
            CommandKind::SetStandardDigitalOut { index, level } => {
                if index >= 16 {
                    let value = f64::from(index);
                    return Err(bad_value("the index of the output", value, "0 to 15"));
                }
                let bit = 1u64 << index;
                self.digital_out = if level {
                    self.digital_out | bit
                } else {
                    self.digital_out & !bit
                };
                Ok(Ending::Now)
            }
            CommandKind::SetSpeedFraction(fraction) => {
                if !(0.0..=1.0).contains(&fraction) {
                    return Err(bad_value("the speed fraction", fraction, "0 to 1"));
                }
                self.speed_fraction = fraction;
                Ok(Ending::Now)
            }
            CommandKind::PowerOn => {
                self.machine.power_on();
                Ok(Ending::Now)
            }
            CommandKind::PowerOff => {
                self.stop_moving();
                self.waiting.add(command.id, WaitingFor::PowerOff);
                Ok(Ending::Later)
            }
            CommandKind::ReleaseBrakes => {
                if self.machine.release_brakes()? {
                    self.stand_at_actual();
                }
                Ok(Ending::Now)
            }
            CommandKind::UnlockProtectiveStop => {
                if !self.is_standing() && self.machine.stop_reason().is_some() {
                    return Err(Refusal::StillMoving);
                }
                self.machine.unlock();
                Ok(Ending::Now)
            }
            CommandKind::RestartSafetyBoard => {
                self.machine.restart_safety();
                Ok(Ending::Now)
            }
        }
    }

    /// Plans a motion and starts it, unless the arm is busy or not ready.
    fn begin(
        &mut self,
        id: CommandId,
        mode: MotionMode,
        plan: impl FnOnce(&Self, &Arm) -> Result<(Plan, Warnings), Refusal>,
    ) -> Answer {
        self.machine.check_ready()?;
        let running = self.running();
        if running != CommandId::NONE {
            return Err(Refusal::Busy { running });
        }
        let arm = Arm {
            model: &self.model,
            flange_from_tcp: &self.flange_from_tcp,
            limits: &self.limits,
        };
        let (plan, warnings) = plan(self, &arm)?;
        for warning in warnings.iter() {
            self.out.warned(id, warning);
        }
        self.generator = Generator::Path(Motion::new(id, mode, &plan));
        Ok(Ending::Later)
    }

    fn stop(&mut self, id: CommandId, only: CommandId) -> Ending {
        if only != CommandId::NONE && only != self.running() {
            return Ending::Now;
        }
        self.is_paused = false;
        self.stop_moving();
        self.waiting.add(id, WaitingFor::Stop);
        Ending::Later
    }

    fn set_payload(&mut self, payload: &Payload) -> Answer {
        let given = Payload::new(payload.mass, payload.cog.into(), payload.inertia);
        self.payload = given.map_err(|error| match error {
            PayloadError::NegativeMass { mass_kg } => {
                bad_value("the payload mass", mass_kg, "0 or more")
            }
            PayloadError::ImpossibleInertia { principal, .. } => bad_value(
                "the largest principal moment of the payload's inertia",
                principal[2],
                "positive and at most the sum of the other two",
            ),
            _ => bad_value("a component of the payload", f64::NAN, "a finite number"),
        })?;
        self.dynamics = self.model.dynamics(&self.payload, self.gravity);
        self.plant.set_dynamics(&self.dynamics);
        Ok(Ending::Now)
    }

    /// Number of the stop reason for the snapshot, 0 without one.
    pub(crate) fn stop_code(&self) -> u64 {
        self.machine
            .stop_reason()
            .as_ref()
            .map_or(0, |reason: &StopReason| u64::from(reason.code()))
    }
}

fn bad_value(name: &'static str, value: f64, needed: &'static str) -> Refusal {
    Refusal::BadValue {
        name,
        value,
        needed,
    }
}
