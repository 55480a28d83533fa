//! The controller's own Modbus map (docs/modbus-map.md): the vendor's addresses, and from 1000 on more of our own.
//!
//! Reads work on one state of one cycle, so the values of a request belong together. Owns the layout, its scaling and
//! what a write asks for; carrying that out is up to the [`ControllerAccess`]. Scripts (manual 6.1.11 to 6.1.14) and
//! Modbus clients use the same functions.

mod own;
mod vendor;

use motion_api::{CommandKind, IoChange, RegisterBank, Registers, RobotState, SettingCommand};

use super::tables::{ModbusException, Space, Tables};
use crate::port_image::PortImage;

/// First address of the map that is not the vendor's.
pub const OWN_FIRST: u16 = 1000;

/// The controller as the map shows and changes it.
pub trait ControllerAccess {
    /// The state after the latest cycle, with outputs and settings that wait for the next one.
    fn state(&self) -> RobotState;
    /// The general purpose registers.
    fn registers(&self) -> &Registers;
    /// The general purpose words, and who has control.
    fn image(&self) -> &PortImage;
    /// Motor current of a joint, A.
    fn joint_current(&self, state: &RobotState, joint: usize) -> f64;
    /// Gives commands, which act at the beginning of the next cycle. False when they cannot be passed on now.
    fn give(&self, commands: &[CommandKind]) -> bool;
}

/// The controller as tables.
pub struct Map<C>(pub C);

/// What is read, at one moment.
struct View<'a> {
    state: RobotState,
    controller: &'a dyn ControllerAccess,
}

impl View<'_> {
    fn registers(&self) -> &Registers {
        self.controller.registers()
    }
}

/// A range of words with one meaning.
pub struct RegisterRange {
    /// First address.
    pub first: u16,
    /// Number of words.
    pub count: u16,
    /// What it holds.
    pub meaning: &'static str,
    /// How many independent sources say so; `None` for what is our own.
    pub sources: Option<u8>,
    read: fn(&View<'_>, usize) -> u16,
    write: Write,
}

impl RegisterRange {
    /// True when it can be written.
    pub const fn is_writable(&self) -> bool {
        !matches!(self.write, Write::Never)
    }

    /// False for addresses of whose meaning nothing is known: 0 is read there.
    pub const fn is_known(&self) -> bool {
        !self.meaning.is_empty()
    }
}

/// What a write does.
#[derive(Clone, Copy)]
enum Write {
    /// Every write is refused.
    Never,
    /// A command, where the value is one that is allowed.
    Command(fn(&View<'_>, u16) -> Result<CommandKind, ModbusException>),
    /// A general purpose word.
    Word,
    /// Part of the input registers.
    Register(fn(&RegisterBank, usize, u16)),
}

/// A range of bits with one meaning.
pub struct BitRange {
    /// First address.
    pub first: u16,
    /// Number of bits.
    pub count: u16,
    /// The space it is in; `None` for both.
    pub space: Option<Space>,
    /// What it holds; empty where nothing is known.
    pub meaning: &'static str,
    /// How many independent sources say so; `None` for what is our own.
    pub sources: Option<u8>,
    bits: Bits,
}

impl BitRange {
    /// True when it can be written.
    pub const fn is_writable(&self) -> bool {
        matches!(self.bits, Bits::Output(_) | Bits::InputRegister)
    }
}

/// What is behind bits. Numbers are those of the first point, numbered as in [`RobotState::digital_in`].
#[derive(Clone, Copy)]
enum Bits {
    Nothing,
    Input(u8),
    Output(u8),
    InputRegister,
    OutputRegister,
}

/// All words, in the order of their addresses.
pub fn blocks() -> impl Iterator<Item = &'static RegisterRange> {
    vendor::REGISTER_RANGES.iter().chain(own::BLOCKS)
}

/// All bits, in the order of their addresses.
pub fn bit_blocks() -> impl Iterator<Item = &'static BitRange> {
    vendor::BIT_BLOCKS.iter().chain(own::BIT_RANGES)
}

/// A block without a write.
const fn block(
    first: u16,
    count: u16,
    sources: Option<u8>,
    meaning: &'static str,
    read: fn(&View<'_>, usize) -> u16,
) -> RegisterRange {
    RegisterRange {
        first,
        count,
        meaning,
        sources,
        read,
        write: Write::Never,
    }
}

impl RegisterRange {
    const fn writes(mut self, write: Write) -> Self {
        self.write = write;
        self
    }
}

/// A number in steps of `1 / scale`, as a signed word; saturates.
fn scaled(x: f64, scale: f64) -> u16 {
    // The cast saturates and makes NaN 0.
    ((x * scale).round() as i16).cast_unsigned()
}

fn find(address: u16) -> Result<(&'static RegisterRange, usize), ModbusException> {
    blocks()
        .find(|block| (block.first..block.first + block.count).contains(&address))
        .map(|block| (block, usize::from(address - block.first)))
        .ok_or(ModbusException::IllegalAddress)
}

fn find_bit(space: Space, address: u16) -> Result<(&'static BitRange, u16), ModbusException> {
    bit_blocks()
        .find(|block| {
            block.space.is_none_or(|of| of == space)
                && (block.first..block.first + block.count).contains(&address)
        })
        .map(|block| (block, address - block.first))
        .ok_or(ModbusException::IllegalAddress)
}

/// The addresses of `count` values; all of them must be numbers of an address.
fn span(address: u16, count: usize) -> Result<impl Iterator<Item = u16>, ModbusException> {
    let last = u16::try_from(usize::from(address) + count.saturating_sub(1));
    Ok(address..=last.map_err(|_| ModbusException::IllegalAddress)?)
}

/// What the word at `address` holds, for people; `None` where nobody knows.
pub fn meaning_of_word(address: u16) -> Option<&'static str> {
    let (block, _) = find(address).ok()?;
    block.is_known().then_some(block.meaning)
}

/// What the coil at `address` holds, for people; `None` where nobody knows.
pub fn meaning_of_coil(address: u16) -> Option<&'static str> {
    let (block, _) = find_bit(Space::Outputs, address).ok()?;
    (!block.meaning.is_empty()).then_some(block.meaning)
}

impl<C: ControllerAccess> Map<C> {
    fn view(&self) -> View<'_> {
        View {
            state: self.0.state(),
            controller: &self.0,
        }
    }

    fn give(&self, commands: &[CommandKind]) -> Result<(), ModbusException> {
        match commands.is_empty() || self.0.give(commands) {
            true => Ok(()),
            false => Err(ModbusException::DeviceBusy),
        }
    }
}

impl<C: ControllerAccess> Tables for Map<C> {
    fn read_bits(
        &self,
        space: Space,
        address: u16,
        count: u16,
    ) -> Result<Vec<bool>, ModbusException> {
        let state = self.0.state();
        let registers = self.0.registers();
        let bit = |address: u16| {
            let (block, k) = find_bit(space, address)?;
            Ok(match block.bits {
                Bits::Nothing => false,
                Bits::Input(first) => state.digital_in >> (u16::from(first) + k) & 1 == 1,
                Bits::Output(first) => state.digital_out >> (u16::from(first) + k) & 1 == 1,
                Bits::InputRegister => registers.input.boolean(k as u8),
                Bits::OutputRegister => registers.output.boolean(k as u8),
            })
        };
        span(address, count.into())?.map(bit).collect()
    }

    fn write_bits(&self, address: u16, levels: &[bool]) -> Result<(), ModbusException> {
        let state = self.0.state();
        let (mut mask, mut high) = (0_u32, 0_u32);
        let mut stored = Vec::new();
        for (address, level) in span(address, levels.len())?.zip(levels) {
            let (block, k) = find_bit(Space::Outputs, address)?;
            match block.bits {
                Bits::Output(first) => {
                    let bit = 1 << (u16::from(first) + k);
                    mask |= bit;
                    high |= if *level { bit } else { 0 };
                }
                Bits::InputRegister => stored.push((k as u8, *level)),
                _ => return Err(ModbusException::IllegalAddress),
            }
        }
        if mask != 0 {
            let change = outputs(&state, mask, high)?;
            self.give(&[CommandKind::Setting(SettingCommand::SetIo(change))])?;
        }
        for (n, level) in stored {
            self.0.registers().input.set_boolean(n, level);
        }
        Ok(())
    }

    fn read_words(&self, _: Space, address: u16, count: u16) -> Result<Vec<u16>, ModbusException> {
        let view = self.view();
        span(address, count.into())?
            .map(|address| find(address).map(|(block, k)| (block.read)(&view, k)))
            .collect()
    }

    fn write_words(&self, address: u16, values: &[u16]) -> Result<(), ModbusException> {
        let view = self.view();
        let (mut commands, mut words, mut registers) = (Vec::new(), Vec::new(), Vec::new());
        // Nothing is changed before all of it is known to be allowed.
        for (address, value) in span(address, values.len())?.zip(values) {
            let (block, k) = find(address)?;
            match block.write {
                Write::Never => return Err(ModbusException::IllegalAddress),
                Write::Command(command) => commands.push(command(&view, *value)?),
                Write::Word => words.push((k, *value)),
                Write::Register(store) => registers.push((store, k, *value)),
            }
        }
        self.give(&commands)?;
        if !words.is_empty() {
            self.0.image().with_words(|image| {
                for (k, value) in words {
                    image[k] = value;
                }
            });
        }
        for (store, k, value) in registers {
            store(&self.0.registers().input, k, value);
        }
        Ok(())
    }

    /// General purpose words change in one step, whoever else writes.
    fn change_word(
        &self,
        address: u16,
        change: &dyn Fn(u16) -> u16,
    ) -> Result<(), ModbusException> {
        if let (
            RegisterRange {
                write: Write::Word, ..
            },
            k,
        ) = find(address)?
        {
            self.0
                .image()
                .with_words(|image| image[k] = change(image[k]));
            return Ok(());
        }
        let [old] = self.read_words(Space::Outputs, address, 1)?[..] else {
            return Err(ModbusException::IllegalAddress);
        };
        self.write_words(address, &[change(old)])
    }
}

/// A change of digital outputs. A pin of the tool that is no enabled output cannot be switched on.
fn outputs(state: &RobotState, mask: u32, levels: u32) -> Result<IoChange, ModbusException> {
    for (k, pin) in state.io_config.tool_pins.iter().enumerate() {
        let bit = 1 << (TOOL_FIRST + k);
        if levels & bit != 0 && !(pin.enabled && pin.is_output) {
            return Err(ModbusException::IllegalAddress);
        }
    }
    match levels >> OUTPUTS {
        0 => Ok(IoChange::DigitalOut { mask, levels }),
        _ => Err(ModbusException::IllegalAddress),
    }
}

/// The number of the tool's first output among the digital ones, and how many of these there are.
const TOOL_FIRST: usize = 24;
const OUTPUTS: usize = 28;

#[cfg(test)]
mod tests;
