//! Temperatures: a first-order model of each joint and of the control box.
//!
//! A joint at rest with power is 7 K above the room; its nominal torque heats it by 45 K more, with the square of the
//! torque (copper loss), and it gets there with a time constant of 15 minutes. The box is warmed by its own supply and
//! a little by the load. No public figures exist: plausible ones, so that monitors have something to show.

use kinematics::JointTorques;
use kinematics::elementary::square;

/// The room, °C.
const AMBIENT: f64 = 25.0;
/// Rise with power on, K.
const IDLE_RISE: f64 = 7.0;
/// Rise at nominal torque, K.
const LOAD_RISE: f64 = 45.0;
/// Time constant, s.
const TIME_CONSTANT: f64 = 900.0;
/// The box without power on the arm, and its rises, °C and K.
const BOX: f64 = 30.0;
const BOX_IDLE_RISE: f64 = 5.0;
const BOX_LOAD_RISE: f64 = 10.0;

/// Temperatures of the arm and the box.
#[derive(Clone, Copy, Debug)]
pub struct Thermal {
    /// °C.
    pub joints: [f64; 6],
    /// °C.
    pub controller: f64,
}

impl Thermal {
    /// After a long time at rest, with or without power.
    pub fn new(is_powered: bool) -> Self {
        let power = if is_powered { 1.0 } else { 0.0 };
        Self {
            joints: [AMBIENT + IDLE_RISE * power; 6],
            controller: BOX + BOX_IDLE_RISE * power,
        }
    }

    /// `step` seconds later.
    pub fn advance(
        &mut self,
        torque: &JointTorques,
        effort: &JointTorques,
        is_powered: bool,
        step: f64,
    ) {
        let power = if is_powered { 1.0 } else { 0.0 };
        let share = step / TIME_CONSTANT;
        let mut load = 0.0;
        for joint in 0..6 {
            let square = power * square(torque[joint] / effort[joint]);
            load += square / 6.0;
            let end = AMBIENT + IDLE_RISE * power + LOAD_RISE * square;
            self.joints[joint] += (end - self.joints[joint]) * share;
        }
        let end = BOX + BOX_IDLE_RISE * power + BOX_LOAD_RISE * load;
        self.controller += (end - self.controller) * share;
    }
}
