//! What RTSI clients read and write, carried to and from the controller.
//!
//! Changes go to the motion thread as commands, so they take effect in the next cycle; registers are there at once.

use std::sync::Arc;

use motion_api::{
    CommandKind, DigitalBank, IoChange, Origin, RegisterBank, RingFull, SensingCommand,
    SettingCommand,
};
use tokio::sync::broadcast;

use super::PortBackend;
use crate::ports::ClientId;
use crate::ports::description::RobotDescription;
use crate::ports::primary;
use crate::ports::rtsi::RtsiBackend;
use crate::ports::rtsi::inputs::{Change, InputVariable};
use crate::ports::sample::Sample;

impl RtsiBackend for PortBackend {
    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn samples(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.feed.subscribe()
    }

    fn sample(&self) -> Sample {
        primary::PrimaryBackend::sample(self)
    }

    fn apply(
        &self,
        _client: ClientId,
        changes: &[Change],
        written: &[InputVariable],
    ) -> Result<u64, RingFull> {
        let commands: Vec<CommandKind> = changes.iter().copied().flat_map(commands_of).collect();
        self.robot.send_all(Origin::default(), &commands)?;
        for change in changes {
            write_register(&self.robot.registers().input, *change);
        }
        let (panel, now) = (self.supervisor.panel(), self.robot.state().time);
        if panel.has_watchdogs() {
            for input in written {
                panel.rtsi_input_was_set(&input.name(), now);
            }
        }
        // The cycle that runs meanwhile may have looked for commands already; the one after it has not.
        Ok(self.robot.state().cycle + 2)
    }
}

/// What the motion thread has to do for a change; nothing for a register.
fn commands_of(change: Change) -> impl Iterator<Item = CommandKind> {
    let digital = |bank: DigitalBank, mask: u32, levels: u32| {
        let first = bank.first_bit();
        CommandKind::Setting(SettingCommand::SetIo(IoChange::DigitalOut {
            mask: mask << first,
            levels: levels << first,
        }))
    };
    let commands = match change {
        Change::SpeedFraction(fraction) => [
            Some(CommandKind::Setting(SettingCommand::SetSpeedFraction(
                fraction,
            ))),
            None,
        ],
        Change::StandardDigitalOut { mask, levels } => {
            let bank = DigitalBank::Standard;
            [Some(digital(bank, mask.into(), levels.into())), None]
        }
        Change::ConfigurableDigitalOut { mask, levels } => {
            let bank = DigitalBank::Configurable;
            [Some(digital(bank, mask.into(), levels.into())), None]
        }
        Change::ToolDigitalOut { mask, levels } => {
            let bank = DigitalBank::Tool;
            [Some(digital(bank, mask.into(), levels.into())), None]
        }
        Change::StandardAnalogOut {
            index: port,
            domain,
            ratio,
        } => [
            Some(CommandKind::Setting(SettingCommand::SetIo(
                IoChange::AnalogOutDomain { port, domain },
            ))),
            Some(CommandKind::Setting(SettingCommand::SetIo(
                IoChange::AnalogOut { port, ratio },
            ))),
        ],
        Change::ExternalForceTorque(wrench) => [
            Some(CommandKind::Sensing(SensingCommand::SetExternalWrench(
                wrench,
            ))),
            None,
        ],
        _register => [None, None],
    };
    commands.into_iter().flatten()
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
