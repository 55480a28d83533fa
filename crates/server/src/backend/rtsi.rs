//! What RTSI clients read and write, carried to and from the controller.
//!
//! Changes go to the motion thread as commands, so they take effect in the next cycle; registers are there at once.

use std::sync::Arc;

use motion_api::CommandKind;
use tokio::sync::broadcast;

use super::Backend;
use crate::ports::ClientId;
use crate::ports::description::RobotDescription;
use crate::ports::rtsi::Controller;
use crate::ports::rtsi::inputs::{Change, Input};
use crate::ports::rtsi::outputs::{RegisterBank, Sample};

impl Controller for Backend {
    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn samples(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.feed.subscribe()
    }

    fn apply(&self, client: ClientId, changes: &[Change], written: &[Input]) {
        let (panel, now) = (self.supervisor.panel(), self.robot.state().time);
        if panel.has_watchdogs() {
            for input in written {
                panel.rtsi_input_was_set(&input.name(), now);
            }
        }
        for change in changes {
            match *change {
                Change::SpeedFraction(fraction) => {
                    self.supervisor
                        .command(CommandKind::SetSpeedFraction(fraction));
                }
                Change::StandardDigitalOut { mask, levels } => {
                    for index in (0..16).filter(|bit| mask >> bit & 1 == 1) {
                        let level = levels >> index & 1 == 1;
                        self.supervisor
                            .command(CommandKind::SetStandardDigitalOut { index, level });
                    }
                }
                Change::ConfigurableDigitalOut { .. }
                | Change::ToolDigitalOut { .. }
                | Change::StandardAnalogOut { .. }
                | Change::ExternalForceTorque(_) => {
                    tracing::warn!(%client, ?change, "rtsi: not available in this version");
                }
                register => write_register(&mut self.feed.inputs(), register),
            }
        }
    }
}

/// One input register, or 32 of the boolean ones.
fn write_register(bank: &mut RegisterBank, change: Change) {
    match change {
        Change::InputBits { first, levels } => {
            let (mask, levels) = (u128::from(u32::MAX), u128::from(levels));
            bank.bits = bank.bits & !(mask << first) | levels << first;
        }
        Change::InputBit { index, level } => {
            bank.bits = bank.bits & !(1 << index) | u128::from(level) << index;
        }
        Change::InputInt { index, value } => bank.ints[usize::from(index)] = value,
        Change::InputDouble { index, value } => bank.doubles[usize::from(index)] = value,
        // Everything else is no register.
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_written_where_they_stand_and_nowhere_else() {
        let mut bank = RegisterBank::default();
        write_register(
            &mut bank,
            Change::InputBit {
                index: 127,
                level: true,
            },
        );
        let bits = |first, levels| Change::InputBits { first, levels };
        write_register(&mut bank, bits(0, u32::MAX));
        write_register(&mut bank, bits(32, 5));
        assert_eq!(bank.bits, 1 << 127 | 5 << 32 | u128::from(u32::MAX));
        write_register(&mut bank, bits(0, 2));
        assert_eq!(bank.bits, 1 << 127 | 5 << 32 | 2);
    }
}
