//! The controller's I/O, registers and state as Modbus tables, from address 1000 on (docs/modbus-map.md).
//!
//! Own map; the vendor's is not public. Reads work on one state of one cycle, so the values of a request belong together.
//! Owns the layout and its scaling; what a write sets off is up to the [`Controller`].

use motion_api::{AnalogDomain, IoChange, Registers, RobotState};

/// First address of the map.
pub const FIRST: u16 = 1000;

/// The controller as the map sees it.
pub trait Controller: Send + Sync {
    /// The state after the latest cycle.
    fn state(&self) -> RobotState;
    /// The general purpose registers.
    fn registers(&self) -> &Registers;
    /// Changes an output at the beginning of the next cycle. False when it cannot be passed on now.
    fn change(&self, change: IoChange) -> bool;
}

/// A table without a value at that address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoSuchAddress;

/// A range of registers with one meaning.
pub struct Block {
    /// First address.
    pub first: u16,
    /// How many registers.
    pub count: u16,
    /// True when clients may write it.
    pub is_writable: bool,
    /// What it holds.
    pub meaning: &'static str,
    read: fn(&RobotState, &Registers, usize) -> u16,
}

/// A range of coils or discrete inputs with one meaning.
pub struct BitBlock {
    /// First address.
    pub first: u16,
    /// How many.
    pub count: u16,
    /// True for coils (functions 1, 5, 15), false for discrete inputs (function 2).
    pub is_coil: bool,
    /// What it holds.
    pub meaning: &'static str,
}

const fn block(
    first: u16,
    count: u16,
    meaning: &'static str,
    read: fn(&RobotState, &Registers, usize) -> u16,
) -> Block {
    Block {
        first,
        count,
        is_writable: false,
        meaning,
        read,
    }
}

const fn writable(mut block: Block) -> Block {
    block.is_writable = true;
    block
}

/// A number in steps of `1 / scale`, as a signed word; saturates.
fn scaled(x: f64, scale: f64) -> u16 {
    // The cast saturates and makes NaN 0.
    ((x * scale).round() as i16).cast_unsigned()
}

/// Analog values in mV or µA.
fn analog(value: f64, domain: AnalogDomain) -> u16 {
    let scale = match domain {
        AnalogDomain::Current => 1e6,
        AnalogDomain::Voltage => 1e3,
    };
    (value * scale).round() as u16
}

fn half(word: u32, k: usize) -> u16 {
    if k.is_multiple_of(2) {
        (word >> 16) as u16
    } else {
        word as u16
    }
}

/// The holding registers (functions 3, 6, 16, 22, 23) and, the same, the input registers (function 4).
pub const BLOCKS: &[Block] = &[
    block(
        1000,
        1,
        "standard digital inputs, bit n is input n",
        |s, _, _| s.digital_in as u16,
    ),
    block(
        1001,
        1,
        "configurable digital inputs (bits 0-7), tool inputs (bits 8-11)",
        |s, _, _| (s.digital_in >> 16) as u16,
    ),
    block(
        1002,
        1,
        "standard digital outputs, bit n is output n",
        |s, _, _| s.digital_out as u16,
    ),
    block(
        1003,
        1,
        "configurable digital outputs (bits 0-7), tool outputs (bits 8-11)",
        |s, _, _| (s.digital_out >> 16) as u16,
    ),
    block(
        1010,
        3,
        "analog inputs: standard 0, standard 1, tool; mV or µA by domain",
        |s, _, k| analog(s.analog_in[k], s.io_config.analog_in[k]),
    ),
    block(
        1013,
        3,
        "analog outputs: standard 0, standard 1, tool; mV or µA by domain",
        |s, _, k| analog(s.analog_out[k], s.io_config.analog_out[k]),
    ),
    block(
        1016,
        1,
        "domains, 1 is voltage: bits 0-2 analog inputs, bits 3-5 analog outputs",
        |s, _, _| (s.io_config.to_bits() & 0x3F) as u16,
    ),
    block(
        1017,
        1,
        "supply voltage of the tool connector, V",
        |s, _, _| s.io_config.tool_voltage.into(),
    ),
    block(
        1020,
        1,
        "robot mode, the vendor's number (7 running)",
        |s, _, _| s.robot_mode.number() as u16,
    ),
    block(
        1021,
        1,
        "safety mode, the vendor's number (1 normal, 3 protective stop)",
        |s, _, _| s.safety_mode.number() as u16,
    ),
    block(
        1022,
        1,
        "number of the reason of the protective stop, 0 without one",
        |s, _, _| s.stop_code as u16,
    ),
    block(1023, 1, "speed slider, 1/1000", |s, _, _| {
        scaled(s.target_speed_fraction, 1e3)
    }),
    block(1024, 1, "speed scaling in effect, 1/1000", |s, _, _| {
        scaled(s.speed_scaling, 1e3)
    }),
    block(1025, 1, "1 while a motion command runs", |s, _, _| {
        (s.command_id.0 != 0).into()
    }),
    block(1026, 2, "cycle counter, high word first", |s, _, k| {
        half(s.cycle as u32, k)
    }),
    block(
        1030,
        6,
        "actual joint positions, mrad, signed",
        |s, _, k| scaled(s.actual_q[k], 1e3),
    ),
    block(1036, 6, "actual joint speeds, mrad/s, signed", |s, _, k| {
        scaled(s.actual_qd[k], 1e3)
    }),
    block(1042, 6, "joint torques, 0.1 Nm, signed", |s, _, k| {
        scaled(s.actual_torque[k], 10.0)
    }),
    block(
        1050,
        6,
        "actual TCP pose: x y z in 0.1 mm, Rx Ry Rz in mrad, signed",
        |s, _, k| {
            scaled(
                s.actual_tcp_pose.to_array()[k],
                if k < 3 { 1e4 } else { 1e3 },
            )
        },
    ),
    block(
        1056,
        6,
        "actual TCP speed: mm/s and mrad/s, signed",
        |s, _, k| scaled(s.actual_tcp_speed[k], 1e3),
    ),
    block(
        1062,
        6,
        "force on the tool in the TCP frame: 0.1 N and 0.01 Nm, signed",
        |s, _, k| scaled(s.tcp_force[k], if k < 3 { 10.0 } else { 100.0 }),
    ),
    writable(block(
        1100,
        8,
        "boolean input registers 0-127, bit n of word w is register 16 w + n",
        |_, r, k| (r.input.booleans()[k / 4] >> (16 * (k % 4))) as u16,
    )),
    block(
        1108,
        8,
        "boolean output registers 0-127, as above",
        |_, r, k| (r.output.booleans()[k / 4] >> (16 * (k % 4))) as u16,
    ),
    writable(block(
        1200,
        96,
        "integer input registers 0-47, two words each, high word first",
        |_, r, k| half(r.input.integer((k / 2) as u8).cast_unsigned(), k),
    )),
    block(
        1300,
        96,
        "integer output registers 0-47, two words each, high word first",
        |_, r, k| half(r.output.integer((k / 2) as u8).cast_unsigned(), k),
    ),
    writable(block(
        1400,
        96,
        "float input registers 0-47 as IEEE 754 of 32 bits, high word first",
        |_, r, k| half((r.input.float((k / 2) as u8) as f32).to_bits(), k),
    )),
    block(
        1500,
        96,
        "float output registers 0-47 as IEEE 754 of 32 bits, high word first",
        |_, r, k| half((r.output.float((k / 2) as u8) as f32).to_bits(), k),
    ),
];

/// The coils and discrete inputs.
pub const BIT_BLOCKS: &[BitBlock] = &[
    BitBlock {
        first: 1000,
        count: 28,
        is_coil: true,
        meaning: "digital outputs: 0-15 standard, 16-23 configurable, 24-27 tool; a write is applied in the next cycle",
    },
    BitBlock {
        first: 1100,
        count: 128,
        is_coil: true,
        meaning: "boolean input registers 0-127",
    },
    BitBlock {
        first: 1000,
        count: 28,
        is_coil: false,
        meaning: "digital inputs: 0-15 standard, 16-23 configurable, 24-27 tool",
    },
    BitBlock {
        first: 1100,
        count: 128,
        is_coil: false,
        meaning: "boolean output registers 0-127",
    },
];

fn find(address: u16) -> Result<&'static Block, NoSuchAddress> {
    let holds = |block: &&Block| (block.first..block.first + block.count).contains(&address);
    BLOCKS.iter().find(holds).ok_or(NoSuchAddress)
}

/// `count` registers from `address` on; all of them must exist.
///
/// # Errors
/// [`NoSuchAddress`]
pub fn read_registers(
    controller: &dyn Controller,
    address: u16,
    count: u16,
) -> Result<Vec<u16>, NoSuchAddress> {
    let (state, registers) = (controller.state(), controller.registers());
    let value = |offset: u16| {
        let address = address.checked_add(offset).ok_or(NoSuchAddress)?;
        let block = find(address)?;
        Ok((block.read)(
            &state,
            registers,
            usize::from(address - block.first),
        ))
    };
    (0..count).map(value).collect()
}

/// Writes registers from `address` on; all of them must be writable, or none is written.
///
/// # Errors
/// [`NoSuchAddress`]
pub fn write_registers(
    controller: &dyn Controller,
    address: u16,
    values: &[u16],
) -> Result<(), NoSuchAddress> {
    let addresses = address
        ..=address
            .checked_add(values.len() as u16 - 1)
            .ok_or(NoSuchAddress)?;
    for address in addresses.clone() {
        if !find(address)?.is_writable {
            return Err(NoSuchAddress);
        }
    }
    let input = &controller.registers().input;
    for (address, value) in addresses.zip(values) {
        let (k, word) = (address % 100, u32::from(*value));
        // Each word replaces its half; the other half stays.
        let joined = |old: u32| match k % 2 {
            0 => old & 0xFFFF | word << 16,
            _ => old & 0xFFFF_0000 | word,
        };
        let n = (k / 2) as u8;
        match address {
            1100..1108 => (0..16).for_each(|bit| {
                input.set_boolean((16 * k + bit) as u8, value >> bit & 1 == 1);
            }),
            1200..1296 => {
                input.set_integer(n, joined(input.integer(n).cast_unsigned()).cast_signed())
            }
            _ => {
                let bits = joined((input.float(n) as f32).to_bits());
                input.set_float(n, f32::from_bits(bits).into());
            }
        }
    }
    Ok(())
}

fn check_bits(is_coil: bool, address: u16, count: u16) -> Result<(), NoSuchAddress> {
    let holds = |block: &BitBlock| {
        block.is_coil == is_coil
            && address >= block.first
            && u32::from(address) + u32::from(count) <= u32::from(block.first + block.count)
    };
    if BIT_BLOCKS.iter().any(holds) {
        Ok(())
    } else {
        Err(NoSuchAddress)
    }
}

/// `count` coils or discrete inputs from `address` on, all of one block.
///
/// # Errors
/// [`NoSuchAddress`]
pub fn read_bits(
    controller: &dyn Controller,
    is_coil: bool,
    address: u16,
    count: u16,
) -> Result<Vec<bool>, NoSuchAddress> {
    check_bits(is_coil, address, count)?;
    let (state, registers) = (controller.state(), controller.registers());
    let bit = |address: u16| match (address, is_coil) {
        (1000..1100, true) => state.digital_out >> (address - 1000) & 1 == 1,
        (1000..1100, false) => state.digital_in >> (address - 1000) & 1 == 1,
        (_, true) => registers.input.boolean((address - 1100) as u8),
        (_, false) => registers.output.boolean((address - 1100) as u8),
    };
    Ok((address..address + count).map(bit).collect())
}

/// Writes coils from `address` on, all of one block.
///
/// # Errors
/// [`NoSuchAddress`]
pub fn write_bits(
    controller: &dyn Controller,
    address: u16,
    levels: &[bool],
) -> Result<bool, NoSuchAddress> {
    check_bits(true, address, levels.len() as u16)?;
    if address >= 1100 {
        for (n, level) in ((address - 1100) as u8..).zip(levels) {
            controller.registers().input.set_boolean(n, *level);
        }
        return Ok(true);
    }
    let first = address - FIRST;
    let bits = |wanted: &dyn Fn(bool) -> bool| {
        let levels = levels.iter().enumerate();
        levels
            .filter(|(_, level)| wanted(**level))
            .fold(0_u32, |mask, (k, _)| mask | 1 << (usize::from(first) + k))
    };
    Ok(controller.change(IoChange::DigitalOut {
        mask: bits(&|_| true),
        levels: bits(&|level| level),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion_api::IoImage;
    use std::sync::Mutex;

    #[derive(Default)]
    struct Fake(Mutex<IoImage>, Registers);

    impl Controller for Fake {
        fn state(&self) -> RobotState {
            let mut state = RobotState::at_start(Default::default(), 0.004);
            state.digital_out = self.0.lock().unwrap().digital_out.into();
            state.actual_q.0[5] = -1.571;
            state.analog_in[1] = 2.5;
            state
        }
        fn registers(&self) -> &Registers {
            &self.1
        }
        fn change(&self, change: IoChange) -> bool {
            self.0.lock().unwrap().apply(&change);
            true
        }
    }

    #[test]
    fn blocks_do_not_overlap() {
        for pair in BLOCKS.windows(2) {
            assert!(
                pair[0].first + pair[0].count <= pair[1].first,
                "{}",
                pair[1].first
            );
        }
    }

    #[test]
    fn what_is_written_is_read_and_state_is_scaled() {
        let fake = Fake::default();
        assert_eq!(
            read_registers(&fake, 1035, 1),
            Ok(vec![(-1571_i16).cast_unsigned()])
        );
        assert_eq!(read_registers(&fake, 1010, 3), Ok(vec![0, 2500, 0]));
        write_registers(&fake, 1294, &[0xFFFF, 0xFFFE]).unwrap();
        assert_eq!(fake.1.input.integer(47), -2);
        write_registers(&fake, 1400, &[0x3FC0, 0]).unwrap();
        assert_eq!(fake.1.input.float(0), 1.5);
        assert_eq!(read_registers(&fake, 1400, 2), Ok(vec![0x3FC0, 0]));
        write_registers(&fake, 1107, &[0x8001]).unwrap();
        assert!(fake.1.input.boolean(127) && fake.1.input.boolean(112));
        assert_eq!(read_bits(&fake, true, 1226, 2), Ok(vec![false, true]));
        assert_eq!(write_bits(&fake, 1002, &[true, false, true]), Ok(true));
        assert_eq!(read_bits(&fake, true, 1002, 3), Ok(vec![true, false, true]));
        assert_eq!(read_registers(&fake, 1002, 1), Ok(vec![0b10100]));
    }

    #[test]
    fn what_does_not_exist_or_is_not_writable_is_refused_whole() {
        let fake = Fake::default();
        assert_eq!(read_registers(&fake, 1004, 1), Err(NoSuchAddress));
        assert_eq!(read_registers(&fake, 1295, 2), Err(NoSuchAddress));
        assert_eq!(read_registers(&fake, 65535, 125), Err(NoSuchAddress));
        assert_eq!(write_registers(&fake, 1300, &[1]), Err(NoSuchAddress));
        assert_eq!(write_registers(&fake, 1107, &[1, 1]), Err(NoSuchAddress));
        assert_eq!(fake.1.input.booleans(), [0, 0]);
        assert_eq!(read_bits(&fake, true, 1027, 2), Err(NoSuchAddress));
        assert_eq!(write_bits(&fake, 1300, &[true]), Err(NoSuchAddress));
    }
}
