//! Commands that set what motions are made with: tool, payload, gravity, speed, inputs and outputs, encoders.

use kinematics::{Payload, RpyPose};

use crate::{CommandId, EncoderRange, IoChange, PulseDecoding};

/// A value that holds from now on; nothing moves for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingCommand {
    /// TCP relative to the flange (manual 3.1.20).
    SetTcp(RpyPose),
    /// What hangs on the flange (manual 3.1.17).
    SetPayload(Payload),
    /// Free-fall acceleration in the base frame, m/s² (manual 3.1.16 has the other sign).
    SetGravity([f64; 3]),
    /// The speed slider, 0 to 1.
    SetSpeedFraction(f64),
    /// One standard digital output (manual 5.13).
    SetStandardDigitalOut {
        /// 0 to 15.
        index: u8,
        /// High or low.
        level: bool,
    },
    /// Any other input or output, or how it is configured (manual chapter 5).
    SetIo(IoChange),
    /// An input or output that changes when a planned motion ends: where the arm enters its blend zone, or stops. At
    /// once where that motion has ended already; never where it is stopped before.
    SetIoAtZone {
        /// The motion.
        motion: CommandId,
        /// The change.
        change: IoChange,
    },
    /// A simulated digital input, bit of `RobotState::digital_in`.
    SetDigitalInput {
        /// 0 to 27.
        index: u8,
        /// High or low.
        level: bool,
    },
    /// The count of an encoder comes from the program from now on (manual 3.1.21).
    EncoderEnableSetTickCount {
        /// 0 or 1.
        encoder: u8,
        /// Range of the counter.
        range: EncoderRange,
    },
    /// The count of an encoder (manual 3.1.23).
    EncoderSetTickCount {
        /// 0 or 1.
        encoder: u8,
        /// Ticks, inside the range of the encoder.
        count: f64,
    },
    /// The count of an encoder comes from pulses from now on (manual 3.1.32).
    EncoderEnablePulseDecode {
        /// 0 or 1.
        encoder: u8,
        /// The edges that count.
        decoding: PulseDecoding,
        /// Input of channel A: 16 or 17.
        channel_a: u8,
        /// Input of channel B, 16 or 17; 0 unless quadrature.
        channel_b: u8,
    },
}

impl SettingCommand {
    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::SetTcp(_) => "set_tcp",
            Self::SetPayload(_) => "set_payload",
            Self::SetGravity(_) => "set_gravity",
            Self::SetSpeedFraction(_) => "set_speed_fraction",
            Self::SetStandardDigitalOut { .. } => "set_standard_digital_out",
            Self::SetIo(_) => "set_io",
            Self::SetIoAtZone { .. } => "set_io_at_zone",
            Self::SetDigitalInput { .. } => "set_digital_input",
            Self::EncoderEnableSetTickCount { .. } => "encoder_enable_set_tick_count",
            Self::EncoderSetTickCount { .. } => "encoder_set_tick_count",
            Self::EncoderEnablePulseDecode { .. } => "encoder_enable_pulse_decode",
        }
    }

    /// True for what tells that a program runs, or runs no more: a
    /// [reserved slot](crate::CommandKind::uses_reserved_slot) is kept for it.
    pub const fn tells_program_state(&self) -> bool {
        matches!(self, Self::SetIo(IoChange::ProgramRunning(_)))
    }
}
