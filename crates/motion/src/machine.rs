//! The robot as a machine: power, brakes, stops. Which request is possible when, and what it leads to.
//!
//! Owns the modes and nothing that moves. Power on and brake release take the time of [`POWER_ON_TIME`] and
//! [`BRAKE_RELEASE_TIME`]; everything else happens at once.
//!
//! | safety mode | what it does | how it ends |
//! |---|---|---|
//! | emergency stop (button, or input) | joints brake, then the power goes off | release, power on, brake release |
//! | protective stop | joints brake, the brakes hold | unlock |
//! | safeguard stop (input) | the arm stops and waits there | the input, or the reset input where there is one |
//! | reduced (input) | reduced limits | the input |
//!
//! Where several apply, the first of the table is the mode that is seen.

use motion_api::{Refusal, RobotMode, SafetyMode, StopReason};

use crate::constants::{BRAKE_RELEASE_TIME, POWER_ON_TIME};

/// Levels of the safety functions that inputs are assigned to; true means that the function asks for something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SafetyRequests {
    /// Emergency stop of the cell.
    pub emergency_stop: bool,
    /// Safeguard stop.
    pub safeguard_stop: bool,
    /// Reset of a safeguard stop: its rising edge counts. `None`: a safeguard stop ends by itself.
    pub safeguard_reset: Option<bool>,
    /// Reduced limits.
    pub reduced_mode: bool,
}

/// Modes of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotStateMachine {
    robot_mode: RobotMode,
    /// Seconds until the power is on or the brakes are released; `None` when neither is under way.
    transition_time_left: Option<f64>,
    /// Brake release was asked for while the power was still being applied.
    release_brakes_after_power_on: bool,
    protective_stop_reason: Option<StopReason>,
    /// The emergency stop button of the pendant is pressed.
    is_emergency_button_pressed: bool,
    safety_requests: SafetyRequests,
    /// A safeguard stop holds until its reset.
    is_safeguard_latched: bool,
}

impl RobotStateMachine {
    /// In `robot_mode`, nothing wrong.
    pub const fn new(robot_mode: RobotMode) -> Self {
        Self {
            robot_mode,
            transition_time_left: None,
            release_brakes_after_power_on: false,
            protective_stop_reason: None,
            is_emergency_button_pressed: false,
            safety_requests: SafetyRequests {
                emergency_stop: false,
                safeguard_stop: false,
                safeguard_reset: None,
                reduced_mode: false,
            },
            is_safeguard_latched: false,
        }
    }

    /// Robot mode.
    pub const fn robot_mode(&self) -> RobotMode {
        self.robot_mode
    }

    /// Safety mode: the most serious of what applies.
    pub const fn safety_mode(&self) -> SafetyMode {
        if self.is_emergency_button_pressed {
            SafetyMode::RobotEmergencyStop
        } else if self.safety_requests.emergency_stop {
            SafetyMode::SystemEmergencyStop
        } else if self.protective_stop_reason.is_some() {
            SafetyMode::ProtectiveStop
        } else if self.is_safeguard_latched {
            SafetyMode::SafeguardStop
        } else if self.safety_requests.reduced_mode {
            SafetyMode::Reduced
        } else {
            SafetyMode::Normal
        }
    }

    /// The reason for which the arm is in a protective or an emergency stop; `None` when it is in neither.
    pub const fn stop_reason(&self) -> Option<StopReason> {
        if self.is_emergency() {
            return Some(StopReason::EmergencyStop);
        }
        self.protective_stop_reason
    }

    /// True while an emergency stop asks for the power to be off.
    pub const fn is_emergency(&self) -> bool {
        self.is_emergency_button_pressed || self.safety_requests.emergency_stop
    }

    /// True while reduced limits are asked for, whatever else applies.
    pub const fn is_reduced(&self) -> bool {
        self.safety_requests.reduced_mode
    }

    /// True while a safeguard stop holds the arm on its path.
    pub const fn is_safeguarded(&self) -> bool {
        self.is_safeguard_latched
    }

    /// True when the servos hold the arm, false when the brakes do.
    pub fn is_under_servo(&self) -> bool {
        self.robot_mode == RobotMode::Running
    }

    /// Whether a motion may begin. In a safeguard stop it may, and waits on its path.
    ///
    /// # Errors
    /// [`Refusal::NotReady`] with the modes.
    pub fn check_ready(&self) -> Result<(), Refusal> {
        let safety_mode = self.safety_mode();
        let may_move = safety_mode.allows_motion() || safety_mode == SafetyMode::SafeguardStop;
        if self.is_under_servo() && may_move {
            return Ok(());
        }
        Err(self.not_ready())
    }

    fn not_ready(&self) -> Refusal {
        Refusal::NotReady {
            robot_mode: self.robot_mode,
            safety_mode: self.safety_mode(),
        }
    }

    /// Lets `step` seconds pass. True when the brakes have been released right now.
    pub fn advance(&mut self, step: f64) -> bool {
        let Some(left) = &mut self.transition_time_left else {
            return false;
        };
        *left -= step;
        // Half a step of slack: a time of whole cycles must not take one more through rounding.
        if *left > step / 2.0 {
            return false;
        }
        self.transition_time_left = None;
        if self.robot_mode == RobotMode::PowerOn {
            self.robot_mode = RobotMode::Idle;
            if core::mem::take(&mut self.release_brakes_after_power_on) {
                self.transition_time_left = Some(BRAKE_RELEASE_TIME);
            }
            return false;
        }
        self.robot_mode = RobotMode::Running;
        true
    }

    /// Power on the joints; nothing to do when there is power already.
    ///
    /// # Errors
    /// [`Refusal::NotReady`] in an emergency stop.
    pub fn power_on(&mut self) -> Result<(), Refusal> {
        if self.is_emergency() {
            return Err(self.not_ready());
        }
        if self.robot_mode == RobotMode::PowerOff {
            self.robot_mode = RobotMode::PowerOn;
            self.transition_time_left = Some(POWER_ON_TIME);
        }
        Ok(())
    }

    /// Power off and brakes engaged. The arm must stand.
    pub fn power_off(&mut self) {
        self.robot_mode = RobotMode::PowerOff;
        self.transition_time_left = None;
        self.release_brakes_after_power_on = false;
    }

    /// Begins to release the brakes, or will once the power is on; nothing to do when they are released.
    ///
    /// # Errors
    /// [`Refusal::WrongMode`] without power, [`Refusal::NotReady`] in an emergency or protective stop.
    pub fn release_brakes(&mut self) -> Result<(), Refusal> {
        if self.stop_reason().is_some() {
            return Err(self.not_ready());
        }
        match self.robot_mode {
            RobotMode::Running => {}
            RobotMode::PowerOn => self.release_brakes_after_power_on = true,
            RobotMode::Idle => {
                self.transition_time_left.get_or_insert(BRAKE_RELEASE_TIME);
            }
            robot_mode => {
                return Err(Refusal::WrongMode {
                    robot_mode,
                    needed: RobotMode::Idle,
                });
            }
        }
        Ok(())
    }

    /// Enters a protective stop; true when it is a new one.
    pub fn protective_stop(&mut self, reason: StopReason) -> bool {
        if self.protective_stop_reason.is_some() {
            return false;
        }
        self.protective_stop_reason = Some(reason);
        self.engage_brakes_again();
        true
    }

    /// Leaves a protective stop; nothing to do when there is none. The arm must stand.
    pub fn unlock(&mut self) {
        self.protective_stop_reason = None;
    }

    /// Starts the safety system anew: the power is off afterwards. Emergency stops last as long as what asks for them.
    pub fn restart_safety(&mut self) {
        self.protective_stop_reason = None;
        self.power_off();
    }

    /// The emergency stop button was pressed or released. True when an emergency stop begins.
    pub fn press_emergency_stop(&mut self, pressed: bool) -> bool {
        let begins = pressed && !self.is_emergency();
        self.is_emergency_button_pressed = pressed;
        if begins {
            self.engage_brakes_again();
        }
        begins
    }

    /// Looks at the safety inputs. True when an emergency stop begins.
    pub fn update_safety_requests(&mut self, lines: SafetyRequests) -> bool {
        let begins = lines.emergency_stop && !self.is_emergency();
        let is_reset = match (lines.safeguard_reset, self.safety_requests.safeguard_reset) {
            (None, _) => true,
            (Some(now), before) => now && before == Some(false),
        };
        if lines.safeguard_stop {
            self.is_safeguard_latched = true;
        } else if is_reset {
            self.is_safeguard_latched = false;
        }
        self.safety_requests = lines;
        if begins {
            self.engage_brakes_again();
        }
        begins
    }

    /// A stop while the brakes were being released, or were about to be.
    fn engage_brakes_again(&mut self) {
        self.release_brakes_after_power_on = false;
        if self.robot_mode == RobotMode::Idle {
            self.transition_time_left = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REASON: StopReason = StopReason::Internal { code: 0 };
    const STEP: f64 = 0.004;

    /// Cycles until the brakes are released; `None` when they never are.
    fn cycles_until_released(machine: &mut RobotStateMachine) -> Option<u32> {
        (1..1000).find(|_| machine.advance(STEP))
    }

    #[test]
    fn power_on_and_brake_release_lead_from_off_to_running() {
        let mut machine = RobotStateMachine::new(RobotMode::PowerOff);
        let refused = machine.release_brakes();
        assert!(matches!(
            refused,
            Err(Refusal::WrongMode {
                needed: RobotMode::Idle,
                ..
            })
        ));
        machine.power_on().unwrap();
        assert_eq!(machine.robot_mode(), RobotMode::PowerOn);
        assert_eq!(cycles_until_released(&mut machine), None);
        assert_eq!(machine.robot_mode(), RobotMode::Idle);
        assert!(machine.check_ready().is_err());
        machine.release_brakes().unwrap();
        assert_eq!(machine.robot_mode(), RobotMode::Idle);
        let cycles = (BRAKE_RELEASE_TIME / STEP).round() as u32;
        assert_eq!(cycles_until_released(&mut machine), Some(cycles));
        machine.release_brakes().unwrap();
        assert_eq!(cycles_until_released(&mut machine), None, "once");
        assert_eq!(machine.check_ready(), Ok(()));
    }

    #[test]
    fn brakes_asked_for_too_early_are_released_once_there_is_power() {
        let mut machine = RobotStateMachine::new(RobotMode::PowerOff);
        machine.power_on().unwrap();
        machine.release_brakes().unwrap();
        let cycles = ((POWER_ON_TIME + BRAKE_RELEASE_TIME) / STEP).round() as u32;
        assert_eq!(cycles_until_released(&mut machine), Some(cycles));
    }

    #[test]
    fn a_protective_stop_keeps_its_first_reason_until_it_is_unlocked() {
        let mut machine = RobotStateMachine::new(RobotMode::Running);
        assert!(machine.protective_stop(REASON));
        assert!(!machine.protective_stop(StopReason::Internal { code: 7 }));
        assert_eq!(machine.stop_reason(), Some(REASON));
        assert!(machine.check_ready().is_err());
        machine.unlock();
        assert_eq!(machine.check_ready(), Ok(()));
        assert_eq!(machine.stop_reason(), None);
    }

    #[test]
    fn a_power_off_leaves_a_protective_stop_as_it_is() {
        let mut machine = RobotStateMachine::new(RobotMode::Running);
        machine.protective_stop(REASON);
        machine.power_off();
        machine.power_on().unwrap();
        cycles_until_released(&mut machine);
        assert!(machine.release_brakes().is_err());
        machine.unlock();
        machine.release_brakes().unwrap();
        assert!(cycles_until_released(&mut machine).is_some());
    }

    #[test]
    fn a_stop_keeps_brakes_engaged_that_were_about_to_be_released() {
        let stops: [fn(&mut RobotStateMachine) -> bool; 2] = [
            |machine| machine.protective_stop(REASON),
            |machine| machine.press_emergency_stop(true),
        ];
        for stop in stops {
            let mut machine = RobotStateMachine::new(RobotMode::Idle);
            machine.release_brakes().unwrap();
            machine.advance(STEP);
            assert!(stop(&mut machine));
            assert_eq!(cycles_until_released(&mut machine), None);
            assert_eq!(machine.robot_mode(), RobotMode::Idle);
        }
    }

    #[test]
    fn an_emergency_stop_lasts_as_long_as_what_asks_for_it() {
        let mut machine = RobotStateMachine::new(RobotMode::Running);
        let lines = SafetyRequests {
            emergency_stop: true,
            ..SafetyRequests::default()
        };
        assert!(machine.update_safety_requests(lines));
        assert!(
            !machine.update_safety_requests(lines),
            "it has begun already"
        );
        assert_eq!(machine.safety_mode(), SafetyMode::SystemEmergencyStop);
        assert!(!machine.press_emergency_stop(true));
        assert_eq!(machine.safety_mode(), SafetyMode::RobotEmergencyStop);
        machine.power_off();
        machine.restart_safety();
        assert!(machine.power_on().is_err());
        machine.press_emergency_stop(false);
        assert_eq!(machine.safety_mode(), SafetyMode::SystemEmergencyStop);
        machine.update_safety_requests(SafetyRequests::default());
        assert_eq!(machine.safety_mode(), SafetyMode::Normal);
        assert_eq!(machine.power_on(), Ok(()));
    }

    #[test]
    fn a_safeguard_stop_ends_by_itself_or_at_the_edge_of_its_reset() {
        let lines = |safeguard_stop, safeguard_reset| SafetyRequests {
            safeguard_stop,
            safeguard_reset,
            ..SafetyRequests::default()
        };
        let mut machine = RobotStateMachine::new(RobotMode::Running);
        machine.update_safety_requests(lines(true, None));
        assert_eq!(machine.safety_mode(), SafetyMode::SafeguardStop);
        assert_eq!(
            machine.check_ready(),
            Ok(()),
            "a motion may begin and waits"
        );
        machine.update_safety_requests(lines(false, None));
        assert_eq!(machine.safety_mode(), SafetyMode::Normal);

        for (stop, reset, holds) in [
            (true, true, true),
            (false, true, true), // high all the time: no edge
            (false, false, true),
            (true, true, true), // the stop is still asked for
            (true, false, true),
            (false, true, false),
            (false, false, false),
        ] {
            machine.update_safety_requests(lines(stop, Some(reset)));
            assert_eq!(machine.is_safeguarded(), holds, "{stop} {reset}");
        }
    }

    #[test]
    fn the_most_serious_mode_is_seen() {
        let mut machine = RobotStateMachine::new(RobotMode::Running);
        let mut lines = SafetyRequests {
            reduced_mode: true,
            ..SafetyRequests::default()
        };
        machine.update_safety_requests(lines);
        assert_eq!(machine.safety_mode(), SafetyMode::Reduced);
        lines.safeguard_stop = true;
        machine.update_safety_requests(lines);
        assert_eq!(machine.safety_mode(), SafetyMode::SafeguardStop);
        machine.protective_stop(REASON);
        assert_eq!(machine.safety_mode(), SafetyMode::ProtectiveStop);
        lines.emergency_stop = true;
        machine.update_safety_requests(lines);
        assert_eq!(machine.safety_mode(), SafetyMode::SystemEmergencyStop);
        assert_eq!(machine.stop_reason(), Some(StopReason::EmergencyStop));
    }
}
