//! The robot as a machine: power, brakes, protective stop. Which request is possible when, and what it leads to.
//!
//! Owns the modes and nothing that moves. Transitions take no time: the vendor's boot and brake times are not simulated.

use motion_api::{Refusal, RobotMode, SafetyMode, StopReason};

/// Modes of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    robot_mode: RobotMode,
    safety_mode: SafetyMode,
    stop_reason: Option<StopReason>,
}

impl Machine {
    /// In `robot_mode`, nothing wrong.
    pub const fn new(robot_mode: RobotMode) -> Self {
        Self {
            robot_mode,
            safety_mode: SafetyMode::Normal,
            stop_reason: None,
        }
    }

    /// Robot mode.
    pub const fn robot_mode(&self) -> RobotMode {
        self.robot_mode
    }

    /// Safety mode.
    pub const fn safety_mode(&self) -> SafetyMode {
        self.safety_mode
    }

    /// Why the arm is in a protective stop.
    pub const fn stop_reason(&self) -> Option<StopReason> {
        self.stop_reason
    }

    /// True when the servos hold the arm, false when the brakes do.
    pub fn is_under_servo(&self) -> bool {
        self.robot_mode == RobotMode::Running
    }

    /// Whether a motion may begin.
    ///
    /// # Errors
    /// [`Refusal::NotReady`] with the modes.
    pub fn check_ready(&self) -> Result<(), Refusal> {
        if self.is_under_servo() && self.safety_mode.allows_motion() {
            return Ok(());
        }
        Err(Refusal::NotReady {
            robot_mode: self.robot_mode,
            safety_mode: self.safety_mode,
        })
    }

    /// Power on the joints; nothing to do when there is power already.
    pub fn power_on(&mut self) {
        if self.robot_mode == RobotMode::PowerOff {
            self.robot_mode = RobotMode::Idle;
        }
    }

    /// Power off and brakes engaged. The arm must stand.
    pub fn power_off(&mut self) {
        self.robot_mode = RobotMode::PowerOff;
    }

    /// Brakes released; true when they were engaged.
    ///
    /// # Errors
    /// [`Refusal::WrongMode`] without power, [`Refusal::NotReady`] while the safety system does not allow motion.
    pub fn release_brakes(&mut self) -> Result<bool, Refusal> {
        match self.robot_mode {
            RobotMode::Running => Ok(false),
            RobotMode::Idle if self.safety_mode.allows_motion() => {
                self.robot_mode = RobotMode::Running;
                Ok(true)
            }
            RobotMode::Idle => Err(Refusal::NotReady {
                robot_mode: self.robot_mode,
                safety_mode: self.safety_mode,
            }),
            robot_mode => Err(Refusal::WrongMode {
                robot_mode,
                needed: RobotMode::Idle,
            }),
        }
    }

    /// Enters a protective stop; true when it is a new one.
    pub fn protective_stop(&mut self, reason: StopReason) -> bool {
        if self.safety_mode == SafetyMode::ProtectiveStop {
            return false;
        }
        self.safety_mode = SafetyMode::ProtectiveStop;
        self.stop_reason = Some(reason);
        true
    }

    /// Leaves a protective stop; nothing to do when there is none. The arm must stand.
    pub fn unlock(&mut self) {
        if self.safety_mode == SafetyMode::ProtectiveStop {
            self.safety_mode = SafetyMode::Normal;
            self.stop_reason = None;
        }
    }

    /// Clears a fault or violation of the safety system; nothing to do when there is none. As on the real machine the
    /// power is off afterwards.
    pub fn restart_safety(&mut self) {
        if matches!(self.safety_mode, SafetyMode::Fault | SafetyMode::Violation) {
            self.safety_mode = SafetyMode::Normal;
            self.stop_reason = None;
            self.robot_mode = RobotMode::PowerOff;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REASON: StopReason = StopReason::Internal { code: 0 };

    #[test]
    fn power_on_and_brake_release_lead_from_off_to_running() {
        let mut machine = Machine::new(RobotMode::PowerOff);
        let refused = machine.release_brakes();
        assert!(matches!(
            refused,
            Err(Refusal::WrongMode {
                needed: RobotMode::Idle,
                ..
            })
        ));
        machine.power_on();
        assert_eq!(machine.robot_mode(), RobotMode::Idle);
        assert!(machine.check_ready().is_err());
        assert_eq!(machine.release_brakes(), Ok(true));
        assert_eq!(machine.release_brakes(), Ok(false));
        assert_eq!(machine.check_ready(), Ok(()));
    }

    #[test]
    fn a_protective_stop_keeps_its_first_reason_until_it_is_unlocked() {
        let mut machine = Machine::new(RobotMode::Running);
        assert!(machine.protective_stop(REASON));
        assert!(!machine.protective_stop(StopReason::Internal { code: 7 }));
        assert_eq!(machine.stop_reason(), Some(REASON));
        assert!(machine.check_ready().is_err());
        machine.unlock();
        assert_eq!(machine.check_ready(), Ok(()));
        assert_eq!(machine.stop_reason(), None);
    }

    #[test]
    fn power_survives_neither_a_power_off_nor_a_protective_stop_the_mode() {
        let mut machine = Machine::new(RobotMode::Running);
        machine.protective_stop(REASON);
        machine.power_off();
        machine.power_on();
        assert!(machine.release_brakes().is_err());
        machine.unlock();
        assert_eq!(machine.release_brakes(), Ok(true));
    }
}
