//! What RTSI clients read and write, carried to and from the controller.
//!
//! Changes go to the motion thread as commands, so they take effect in the next cycle; registers are there at once.

use std::sync::Arc;

use motion_api::{CommandKind, DigitalBank, IoChange, RegisterBank};
use tokio::sync::broadcast;

use super::Backend;
use crate::ports::ClientId;
use crate::ports::description::RobotDescription;
use crate::ports::primary;
use crate::ports::rtsi::Controller;
use crate::ports::rtsi::inputs::{Change, Input};
use crate::ports::sample::Sample;

impl Controller for Backend {
    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn samples(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.feed.subscribe()
    }

    fn sample(&self) -> Sample {
        primary::Backend::sample(self)
    }

    fn apply(&self, _client: ClientId, changes: &[Change], written: &[Input]) -> u64 {
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
                    self.set_digital(DigitalBank::Standard, mask.into(), levels.into());
                }
                Change::ConfigurableDigitalOut { mask, levels } => {
                    self.set_digital(DigitalBank::Configurable, mask.into(), levels.into());
                }
                Change::ToolDigitalOut { mask, levels } => {
                    self.set_digital(DigitalBank::Tool, mask.into(), levels.into());
                }
                Change::StandardAnalogOut {
                    index,
                    domain,
                    ratio,
                } => {
                    let port = index;
                    self.set_io(IoChange::AnalogOutDomain { port, domain });
                    self.set_io(IoChange::AnalogOut { port, ratio });
                }
                Change::ExternalForceTorque(wrench) => {
                    self.supervisor
                        .command(CommandKind::SetExternalWrench(wrench));
                }
                register => write_register(&self.robot.registers().input, register),
            }
        }
        // The cycle that runs meanwhile may have looked for commands already; the one after it has not.
        self.robot.state().cycle + 2
    }
}

impl Backend {
    fn set_digital(&self, bank: DigitalBank, mask: u32, levels: u32) {
        let first = bank.first_bit();
        self.set_io(IoChange::DigitalOut {
            mask: mask << first,
            levels: levels << first,
        });
    }

    fn set_io(&self, change: IoChange) {
        self.supervisor.command(CommandKind::SetIo(change));
    }
}

/// One input register, or 32 of the boolean ones.
fn write_register(bank: &RegisterBank, change: Change) {
    match change {
        Change::InputBits { first, levels } => {
            for bit in 0..32 {
                bank.set_boolean(first + bit, levels >> bit & 1 == 1);
            }
        }
        Change::InputBit { index, level } => bank.set_boolean(index, level),
        Change::InputInt { index, value } => bank.set_integer(index, value),
        Change::InputDouble { index, value } => bank.set_float(index, value),
        // Everything else is no register.
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_written_where_they_stand_and_nowhere_else() {
        let bank = RegisterBank::default();
        write_register(
            &bank,
            Change::InputBit {
                index: 127,
                level: true,
            },
        );
        let bits = |first, levels| Change::InputBits { first, levels };
        write_register(&bank, bits(0, u32::MAX));
        write_register(&bank, bits(32, 5));
        assert_eq!(bank.booleans(), [5 << 32 | u64::from(u32::MAX), 1 << 63]);
        write_register(&bank, bits(0, 2));
        assert_eq!(bank.booleans(), [5 << 32 | 2, 1 << 63]);
    }
}
