//! Our own addresses, from 1000 on: what the vendor's map lacks, in 32 bits where 16 are too few.

use motion_api::{AnalogDomain, RegisterBank};

use super::super::tables::Space;
use super::{BitRange, Bits, RegisterRange, Write, block, scaled};

/// Analog values in mV or µA.
fn analog(value: f64, domain: AnalogDomain) -> u16 {
    let scale = match domain {
        AnalogDomain::Current => 1e6,
        AnalogDomain::Voltage => 1e3,
    };
    (value * scale).round() as u16
}

fn word_of(word: u32, k: usize) -> u16 {
    if k.is_multiple_of(2) {
        (word >> 16) as u16
    } else {
        word as u16
    }
}

/// The words.
pub(super) const BLOCKS: &[RegisterRange] = &[
    block(
        1000,
        1,
        None,
        "standard digital inputs, bit n is input n",
        |v, _| v.state.digital_in as u16,
    ),
    block(
        1001,
        1,
        None,
        "configurable digital inputs (bits 0-7), tool inputs (bits 8-11)",
        |v, _| (v.state.digital_in >> 16) as u16,
    ),
    block(
        1002,
        1,
        None,
        "standard digital outputs, bit n is output n",
        |v, _| v.state.digital_out as u16,
    ),
    block(
        1003,
        1,
        None,
        "configurable digital outputs (bits 0-7), tool outputs (bits 8-11)",
        |v, _| (v.state.digital_out >> 16) as u16,
    ),
    block(
        1010,
        3,
        None,
        "analog inputs: standard 0, standard 1, tool; mV or µA by domain",
        |v, k| analog(v.state.analog_in[k], v.state.io_config.analog_in[k]),
    ),
    block(
        1013,
        3,
        None,
        "analog outputs: standard 0, standard 1, tool; mV or µA by domain",
        |v, k| analog(v.state.analog_out[k], v.state.io_config.analog_out[k]),
    ),
    block(
        1016,
        1,
        None,
        "domains, 1 is voltage: bits 0-2 analog inputs, bits 3-5 analog outputs",
        |v, _| (v.state.io_config.to_bits() & 0x3F) as u16,
    ),
    block(
        1017,
        1,
        None,
        "supply voltage of the tool connector, V",
        |v, _| v.state.io_config.tool_voltage.into(),
    ),
    block(
        1020,
        1,
        None,
        "robot mode, the vendor's number (7 running)",
        |v, _| v.state.robot_mode.number() as u16,
    ),
    block(
        1021,
        1,
        None,
        "safety mode, the vendor's number (1 normal, 3 protective stop)",
        |v, _| v.state.safety_mode.number() as u16,
    ),
    block(
        1022,
        1,
        None,
        "number of the reason of the protective stop, 0 without one",
        |v, _| v.state.stop_code as u16,
    ),
    block(1023, 1, None, "speed slider, 1/1000", |v, _| {
        scaled(v.state.target_speed_fraction, 1e3)
    }),
    block(1024, 1, None, "speed scaling in effect, 1/1000", |v, _| {
        scaled(v.state.speed_scaling, 1e3)
    }),
    block(1025, 1, None, "1 while a motion command runs", |v, _| {
        (v.state.command_id.0 != 0).into()
    }),
    block(1026, 2, None, "cycle counter, high word first", |v, k| {
        word_of(v.state.cycle as u32, k)
    }),
    block(
        1030,
        6,
        None,
        "actual joint positions, mrad, signed",
        |v, k| scaled(v.state.actual_q[k], 1e3),
    ),
    block(
        1036,
        6,
        None,
        "actual joint speeds, mrad/s, signed",
        |v, k| scaled(v.state.actual_qd[k], 1e3),
    ),
    block(1042, 6, None, "joint torques, 0.1 Nm, signed", |v, k| {
        scaled(v.state.actual_torque[k], 10.0)
    }),
    block(
        1050,
        6,
        None,
        "actual TCP pose: x y z in 0.1 mm, Rx Ry Rz in mrad, signed",
        |v, k| {
            scaled(
                v.state.actual_tcp_pose.to_array()[k],
                if k < 3 { 1e4 } else { 1e3 },
            )
        },
    ),
    block(
        1056,
        6,
        None,
        "actual TCP speed: mm/s and mrad/s, signed",
        |v, k| scaled(v.state.actual_tcp_speed[k], 1e3),
    ),
    block(
        1062,
        6,
        None,
        "force on the tool in the TCP frame: 0.1 N and 0.01 Nm, signed",
        |v, k| scaled(v.state.tcp_force[k], if k < 3 { 10.0 } else { 100.0 }),
    ),
    block(
        1100,
        8,
        None,
        "boolean input registers 0-127, bit n of word w is register 16 w + n",
        |v, k| (v.registers().input.booleans()[k / 4] >> (16 * (k % 4))) as u16,
    )
    .writes(Write::Register(booleans)),
    block(
        1108,
        8,
        None,
        "boolean output registers 0-127, as above",
        |v, k| (v.registers().output.booleans()[k / 4] >> (16 * (k % 4))) as u16,
    ),
    block(
        1200,
        96,
        None,
        "integer input registers 0-47, two words each, high word first",
        |v, k| {
            word_of(
                v.registers().input.integer((k / 2) as u8).cast_unsigned(),
                k,
            )
        },
    )
    .writes(Write::Register(integer_half)),
    block(
        1300,
        96,
        None,
        "integer output registers 0-47, two words each, high word first",
        |v, k| {
            word_of(
                v.registers().output.integer((k / 2) as u8).cast_unsigned(),
                k,
            )
        },
    ),
    block(
        1400,
        96,
        None,
        "float input registers 0-47 as IEEE 754 of 32 bits, high word first",
        |v, k| {
            word_of(
                (v.registers().input.float((k / 2) as u8) as f32).to_bits(),
                k,
            )
        },
    )
    .writes(Write::Register(float_half)),
    block(
        1500,
        96,
        None,
        "float output registers 0-47 as IEEE 754 of 32 bits, high word first",
        |v, k| {
            word_of(
                (v.registers().output.float((k / 2) as u8) as f32).to_bits(),
                k,
            )
        },
    ),
];

fn booleans(bank: &RegisterBank, k: usize, word: u16) {
    for bit in 0..16 {
        bank.set_boolean((16 * k) as u8 + bit, word >> bit & 1 == 1);
    }
}

/// A word replaces its half of a number; the other half stays.
fn joined(old: u32, k: usize, word: u16) -> u32 {
    let word = u32::from(word);
    match k % 2 {
        0 => old & 0xFFFF | word << 16,
        _ => old & 0xFFFF_0000 | word,
    }
}

fn integer_half(bank: &RegisterBank, k: usize, word: u16) {
    let n = (k / 2) as u8;
    let old = bank.integer(n).cast_unsigned();
    bank.set_integer(n, joined(old, k, word).cast_signed());
}

fn float_half(bank: &RegisterBank, k: usize, word: u16) {
    let n = (k / 2) as u8;
    let old = (bank.float(n) as f32).to_bits();
    bank.set_float(n, f32::from_bits(joined(old, k, word)).into());
}

const fn bits(first: u16, count: u16, space: Space, meaning: &'static str, bits: Bits) -> BitRange {
    BitRange {
        first,
        count,
        space: Some(space),
        meaning,
        sources: None,
        bits,
    }
}

/// The bits.
pub(super) const BIT_RANGES: &[BitRange] = &[
    bits(
        1000,
        28,
        Space::Outputs,
        "digital outputs: 0-15 standard, 16-23 configurable, 24-27 tool; a write is applied in the next cycle",
        Bits::Output(0),
    ),
    bits(
        1000,
        28,
        Space::Inputs,
        "digital inputs: 0-15 standard, 16-23 configurable, 24-27 tool",
        Bits::Input(0),
    ),
    bits(
        1100,
        128,
        Space::Outputs,
        "boolean input registers 0-127",
        Bits::InputRegister,
    ),
    bits(
        1100,
        128,
        Space::Inputs,
        "boolean output registers 0-127",
        Bits::OutputRegister,
    ),
];
