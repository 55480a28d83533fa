//! The vendor's addresses. The vendor's sheet is not public; how many independent sources say the same of an address
//! stands beside it, and 0 is what follows from the others only. Addresses between known ones of which nothing is known
//! read 0.

use motion_api::{CommandKind, RegisterBank, RobotMode, SafetyMode, SettingCommand};

use super::super::tables::ModbusException;
use super::{BitRange, Bits, RegisterRange, Write, block, outputs, scaled};
use crate::port_image::WORDS;

/// Major, minor and bug fix number of the controller software whose manual is followed.
const VERSION: [u16; 3] = [2, 15, 0];

/// Numbers of word 72: neither a selector of modes nor an enabling device is there.
const NO_OPERATION_MODE: i16 = -1;

/// A gap.
const fn unknown(first: u16, count: u16) -> RegisterRange {
    block(first, count, Some(0), "", |_, _| 0)
}

/// A 32-bit register as a word: what does not fit saturates.
fn narrow(value: i32) -> u16 {
    value.clamp(i16::MIN.into(), u16::MAX.into()) as u16
}

/// The speed slider, %.
fn speed(value: u16) -> Result<CommandKind, ModbusException> {
    match value {
        2..=100 => Ok(CommandKind::Setting(SettingCommand::SetSpeedFraction(
            f64::from(value) / 100.0,
        ))),
        _ => Err(ModbusException::IllegalValue),
    }
}

/// The words.
pub(super) const REGISTER_RANGES: &[RegisterRange] = &[
    block(
        0,
        1,
        Some(2),
        "standard digital inputs, bit n is input n",
        |v, _| v.state.digital_in as u16,
    ),
    block(
        1,
        1,
        Some(2),
        "configurable digital inputs (bits 0-7), tool inputs (bits 8-11); the order of the two is inferred",
        |v, _| (v.state.digital_in >> 16) as u16,
    ),
    block(
        2,
        1,
        Some(2),
        "standard digital outputs, bit n is output n: a write sets all sixteen",
        |v, _| v.state.digital_out as u16,
    )
    .writes(Write::Command(|v, value| {
        outputs(&v.state, 0xFFFF, value.into()).map(|change| SettingCommand::SetIo(change).into())
    })),
    block(
        3,
        1,
        Some(1),
        "configurable digital outputs (bits 0-7), tool outputs (bits 8-11): a write sets them all",
        |v, _| (v.state.digital_out >> 16) as u16,
    )
    .writes(Write::Command(|v, value| {
        outputs(&v.state, 0xFFF << 16, u32::from(value) << 16).map(|change| SettingCommand::SetIo(change).into())
    })),
    unknown(4, 13),
    block(
        17,
        1,
        Some(1),
        "speed slider, %; 2 to 100 can be written",
        |v, _| scaled(v.state.target_speed_fraction, 100.0),
    )
    .writes(Write::Command(|_, value| speed(value))),
    unknown(18, 45),
    block(
        63,
        3,
        Some(1),
        "version of the controller software: major, minor, bug fix",
        |_, k| VERSION[k],
    ),
    block(
        66,
        1,
        Some(1),
        "robot mode, the number of port 30001 (7 running)",
        |v, _| v.state.robot_mode.number() as u16,
    ),
    block(67, 1, Some(1), "1: the power is on", |v, _| {
        matches!(
            v.state.robot_mode,
            RobotMode::Idle | RobotMode::Backdrive | RobotMode::Running
        )
        .into()
    }),
    block(68, 1, Some(1), "1: protective stop", |v, _| {
        (v.state.safety_mode == SafetyMode::ProtectiveStop).into()
    }),
    block(69, 1, Some(1), "1: emergency stop", |v, _| {
        matches!(
            v.state.safety_mode,
            SafetyMode::SystemEmergencyStop | SafetyMode::RobotEmergencyStop
        )
        .into()
    }),
    block(70, 1, Some(1), "1: reduced mode", |v, _| {
        (v.state.safety_mode == SafetyMode::Reduced).into()
    }),
    block(
        71,
        1,
        Some(1),
        "who has control: 0 remote control is switched off in the settings, 1 local, 2 remote",
        |v, _| v.controller.image().control() as u16,
    ),
    block(
        72,
        1,
        Some(1),
        "operation mode, signed: -1 none, 0 automatic, 1 manual; here -1",
        |_, _| NO_OPERATION_MODE.cast_unsigned(),
    ),
    block(
        73,
        6,
        Some(1),
        "actual joint positions, mrad, signed",
        |v, k| scaled(v.state.actual_q[k], 1e3),
    ),
    unknown(79, 5),
    block(
        84,
        6,
        Some(1),
        "actual joint speeds, mrad/s, signed",
        |v, k| scaled(v.state.actual_qd[k], 1e3),
    ),
    unknown(90, 5),
    block(95, 6, Some(2), "joint currents, mA, signed", |v, k| {
        scaled(v.controller.joint_current(&v.state, k), 1e3)
    }),
    unknown(101, 4),
    block(105, 6, Some(1), "joint temperatures, °C, signed", |v, k| {
        scaled(v.state.joint_temperatures[k], 1.0)
    }),
    block(
        256,
        WORDS as u16,
        Some(4),
        "general purpose words: programs and clients agree on what they mean; they outlive programs",
        |v, k| v.controller.image().words()[k],
    )
    .writes(Write::Word),
    block(
        384,
        6,
        Some(1),
        "actual TCP pose in the base frame: x y z in 0.1 mm, Rx Ry Rz in mrad, signed",
        |v, k| {
            scaled(
                v.state.actual_tcp_pose.to_array()[k],
                if k < 3 { 1e4 } else { 1e3 },
            )
        },
    ),
    unknown(390, 10),
    block(
        400,
        6,
        Some(1),
        "actual TCP speed in the base frame: mm/s and mrad/s, signed",
        |v, k| scaled(v.state.actual_tcp_speed[k], 1e3),
    ),
    unknown(406, 94),
    block(
        500,
        1,
        Some(1),
        "the program: 1 runs, 2 paused, 3 stopped (the arm is reported to answer function 4 only)",
        |v, _| v.controller.image().program() as u16,
    ),
    block(
        600,
        48,
        Some(1),
        "user inputs: integer input register n at 600 + n (inferred), as a signed word",
        |v, k| narrow(v.registers().input.integer(k as u8)),
    )
    .writes(Write::Register(integer)),
    block(
        700,
        48,
        Some(1),
        "user outputs: integer output register n at 700 + n (inferred), as a signed word",
        |v, k| narrow(v.registers().output.integer(k as u8)),
    ),
];

fn integer(bank: &RegisterBank, k: usize, value: u16) {
    bank.set_integer(k as u8, value.cast_signed().into());
}

const fn bits(first: u16, count: u16, sources: u8, meaning: &'static str, bits: Bits) -> BitRange {
    BitRange {
        first,
        count,
        space: None,
        meaning,
        sources: Some(sources),
        bits,
    }
}

/// The bits: each is a coil and a discrete input.
pub(super) const BIT_BLOCKS: &[BitRange] = &[
    bits(0, 16, 2, "standard digital inputs", Bits::Input(0)),
    bits(16, 8, 1, "configurable digital inputs", Bits::Input(16)),
    bits(24, 4, 0, "tool inputs", Bits::Input(24)),
    bits(28, 4, 0, "", Bits::Nothing),
    bits(32, 16, 2, "standard digital outputs", Bits::Output(0)),
    bits(48, 8, 1, "configurable digital outputs", Bits::Output(16)),
    bits(56, 4, 0, "tool outputs", Bits::Output(24)),
    bits(60, 68, 0, "", Bits::Nothing),
    bits(
        300,
        128,
        1,
        "user inputs: boolean input register n at 300 + n (inferred)",
        Bits::InputRegister,
    ),
    bits(
        500,
        128,
        1,
        "user outputs: boolean output register n at 500 + n (inferred)",
        Bits::OutputRegister,
    ),
];
