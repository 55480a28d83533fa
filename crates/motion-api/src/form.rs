//! What a command must look like to be taken, whatever the arm is doing.
//!
//! Both sides of the border ask: the script side at the call, so that what takes no time still raises there, and the
//! motion thread, which relies on nobody. Owns the ranges of numbers that physics survives; whether the arm can do
//! something now is decided where that is known.

use kinematics::{Payload, PayloadError};
use messages::Text;

use crate::{
    CommandKind, EncoderRange, OverlayCommand, Refusal, SensingCommand, SettingCommand, phrase,
};

/// Largest reach of a TCP or a centre of gravity from the flange that is taken, m. This and the bounds below only keep
/// out numbers that no physics survives; the rated payload of the model is checked where scripts are.
pub const TOOL_REACH_MAX: f64 = 10.0;
/// Heaviest payload that is taken, kg.
pub const PAYLOAD_MASS_MAX: f64 = 1000.0;
/// Largest moment of inertia of a payload, kg m²: the heaviest at the farthest.
pub const PAYLOAD_INERTIA_MAX: f64 = PAYLOAD_MASS_MAX * TOOL_REACH_MAX * TOOL_REACH_MAX;
/// Strongest gravity that is taken, m/s².
pub const GRAVITY_MAX: f64 = 30.0;
/// Strongest wrench from outside that is taken, N and Nm.
pub const WRENCH_MAX: f64 = 1e5;
/// Longest push that is taken, s: some thirty years, which is for ever.
pub const PUSH_DURATION_MAX: f64 = 1e9;
/// Farthest a frame may lie from the base, m.
pub const FRAME_REACH_MAX: f64 = 1000.0;

/// Shortest direction of a belt, m.
const DIRECTION_MIN: f64 = 1e-9;
/// Fewest ticks of a belt a metre or a turn.
const TICKS_MIN: f64 = 1e-6;

impl CommandKind {
    /// Checks the numbers of a command that sets something. Those of motions are checked where they are planned.
    ///
    /// # Errors
    /// [`Refusal::BadValue`] with the first number that cannot be.
    pub fn validate(&self) -> Result<(), Refusal> {
        match self {
            Self::Overlay(command) => command.validate(),
            Self::Sensing(command) => command.validate(),
            Self::Setting(command) => command.validate(),
            Self::Motion(_) | Self::Online(_) | Self::Machine(_) => Ok(()),
        }
    }
}

impl OverlayCommand {
    /// Checks frames, wrenches and directions. Offsets of the path are checked where they are laid over it.
    ///
    /// # Errors
    /// [`Refusal::BadValue`] with the first number that cannot be.
    pub fn validate(&self) -> Result<(), Refusal> {
        match self {
            Self::ForceMode {
                frame,
                wrench,
                mode,
                speed_limits,
                ..
            } => {
                if !frame.is_finite() {
                    let needed = phrase!("a pose of finite numbers", "由有限的数组成的位姿");
                    return Err(bad_value(phrase!("reference_frame"), f64::NAN, needed));
                }
                let (most, needed) = (FRAME_REACH_MAX, phrase!("at most 1000 m", "不超过 1000 m"));
                check_magnitude(
                    &frame.xyz,
                    most,
                    phrase!("a coordinate of reference_frame", "reference_frame 的坐标"),
                    needed,
                )?;
                if *mode > 3 {
                    return Err(bad_value(
                        phrase!("mode"),
                        f64::from(*mode),
                        phrase!("0 to 3", "0 到 3"),
                    ));
                }
                let name = phrase!("a component of target_wrench", "target_wrench 的分量");
                check_magnitude(
                    wrench,
                    WRENCH_MAX,
                    name,
                    phrase!("at most 100000 N or Nm", "不超过 100000 N 或 Nm"),
                )?;
                match speed_limits.iter().find(|x| !(0.0..=1000.0).contains(*x)) {
                    None => Ok(()),
                    Some(&bad) => {
                        let needed = phrase!("0 to 1000 m/s or rad/s", "0 到 1000 m/s 或 rad/s");
                        Err(bad_value(
                            phrase!("a component of speed_limits", "speed_limits 的分量"),
                            bad,
                            needed,
                        ))
                    }
                }
            }
            Self::TrackConveyorLinear {
                direction,
                ticks_per_meter,
                ..
            } => {
                let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
                if !(length > DIRECTION_MIN && length.is_finite()) {
                    return Err(bad_value(
                        phrase!("the length of direction", "方向的长度"),
                        length,
                        phrase!("more than 0", "大于 0"),
                    ));
                }
                check_ticks(phrase!("ticks_per_meter"), *ticks_per_meter)
            }
            Self::TrackConveyorCircular {
                center,
                ticks_per_revolution,
                ..
            } => {
                if !center.is_finite() {
                    return Err(bad_value(
                        phrase!("center"),
                        f64::NAN,
                        phrase!("a pose of finite numbers", "由有限的数组成的位姿"),
                    ));
                }
                let (most, needed) = (FRAME_REACH_MAX, phrase!("at most 1000 m", "不超过 1000 m"));
                check_magnitude(
                    &center.xyz,
                    most,
                    phrase!("a coordinate of center", "center 的坐标"),
                    needed,
                )?;
                check_ticks(phrase!("ticks_per_revolution"), *ticks_per_revolution)
            }
            Self::EndForceMode
            | Self::StopConveyorTracking
            | Self::PathOffsetEnable
            | Self::PathOffsetDisable { .. }
            | Self::PathOffsetSet { .. }
            | Self::PathOffsetFilter(_)
            | Self::PathOffsetMax { .. } => Ok(()),
        }
    }
}

impl SensingCommand {
    /// Checks wrenches and the sensor. Gains and sensitivities are checked where they are carried out.
    ///
    /// # Errors
    /// [`Refusal::BadValue`] with the first number that cannot be.
    pub fn validate(&self) -> Result<(), Refusal> {
        match self {
            Self::SetExternalWrench(wrench) => {
                let name = phrase!("a component of the external wrench", "外力旋量的分量");
                check_magnitude(
                    wrench,
                    WRENCH_MAX,
                    name,
                    phrase!("at most 100000 N or Nm", "不超过 100000 N 或 Nm"),
                )
            }
            Self::Push {
                wrench, duration, ..
            } => {
                let name = phrase!("a component of the push", "推力的分量");
                check_magnitude(
                    wrench,
                    WRENCH_MAX,
                    name,
                    phrase!("at most 100000 N or Nm", "不超过 100000 N 或 Nm"),
                )?;
                if !(0.0..=PUSH_DURATION_MAX).contains(duration) {
                    let needed = phrase!("0 to 1e9 s", "0 到 1e9 s");
                    return Err(bad_value(
                        phrase!("the duration of the push", "推力的时长"),
                        *duration,
                        needed,
                    ));
                }
                Ok(())
            }
            Self::FtRtsiInput {
                mass,
                measuring_offset,
                cog,
                ..
            } => {
                if !(0.0..=PAYLOAD_MASS_MAX).contains(mass) {
                    return Err(bad_value(
                        phrase!("sensor_mass"),
                        *mass,
                        phrase!("0 to 1000 kg", "0 到 1000 kg"),
                    ));
                }
                let (most, needed) = (TOOL_REACH_MAX, phrase!("at most 10 m", "不超过 10 m"));
                check_magnitude(
                    measuring_offset,
                    most,
                    phrase!("sensor_measuring_offset"),
                    needed,
                )?;
                check_magnitude(cog, most, phrase!("sensor_cog"), needed)
            }
            Self::SetForceGain(_)
            | Self::SetForceDamping(_)
            | Self::ZeroFtSensor
            | Self::SetCollisionDetection(_)
            | Self::SetCollisionSensitivity(_) => Ok(()),
        }
    }
}

impl SettingCommand {
    /// Checks tool, payload and gravity. The rest is checked where it is carried out.
    ///
    /// # Errors
    /// [`Refusal::BadValue`] with the first number that cannot be.
    pub fn validate(&self) -> Result<(), Refusal> {
        match self {
            Self::SetTcp(tcp) => {
                if let Some(angle) = tcp.rpy.into_iter().find(|x| !x.is_finite()) {
                    return Err(bad_value(
                        phrase!("an angle of the TCP", "TCP 的角度"),
                        angle,
                        phrase!("a finite number", "有限的数"),
                    ));
                }
                let name = phrase!("a coordinate of the TCP", "TCP 的坐标");
                check_magnitude(
                    &tcp.xyz,
                    TOOL_REACH_MAX,
                    name,
                    phrase!("at most 10 m", "不超过 10 m"),
                )
            }
            Self::SetPayload(payload) => check_payload(payload),
            Self::SetGravity(gravity) => {
                let name = phrase!("a component of gravity", "重力的分量");
                check_magnitude(
                    gravity,
                    GRAVITY_MAX,
                    name,
                    phrase!("at most 30 m/s²", "不超过 30 m/s²"),
                )
            }
            Self::SetSpeedFraction(_)
            | Self::SetStandardDigitalOut { .. }
            | Self::SetIo(_)
            | Self::SetIoAtZone { .. }
            | Self::SetDigitalInput { .. }
            | Self::EncoderEnableSetTickCount { .. }
            | Self::EncoderSetTickCount { .. }
            | Self::EncoderEnablePulseDecode { .. } => Ok(()),
        }
    }
}

/// A count that a program gives an encoder.
///
/// # Errors
/// [`Refusal::BadValue`] outside the range, or when the encoder takes its count from elsewhere.
pub fn check_tick_count(
    is_from_program: bool,
    range: EncoderRange,
    count: f64,
) -> Result<(), Refusal> {
    if !is_from_program {
        let needed = phrase!(
            "set after encoder_enable_set_tick_count() for this encoder",
            "在对该编码器调用 encoder_enable_set_tick_count() 之后设置"
        );
        return Err(bad_value(phrase!("the tick count", "计数"), count, needed));
    }
    let (min, max) = range.bounds();
    if (min..=max).contains(&count) {
        return Ok(());
    }
    let needed = match range {
        EncoderRange::Signed32 => phrase!("-2147483648 to 2147483647", "-2147483648 到 2147483647"),
        EncoderRange::Unsigned8 => phrase!("0 to 255", "0 到 255"),
        EncoderRange::Unsigned16 => phrase!("0 to 65535", "0 到 65535"),
        EncoderRange::Unsigned24 => phrase!("0 to 16777215", "0 到 16777215"),
        EncoderRange::Unsigned32 => phrase!("0 to 4294967295", "0 到 4294967295"),
    };
    Err(bad_value(phrase!("the tick count", "计数"), count, needed))
}

/// Checks that all `values` are numbers of at most `most` either way.
///
/// # Errors
/// [`Refusal::BadValue`] with the first that is not.
pub fn check_magnitude(
    values: &[f64],
    most: f64,
    name: &'static Text,
    needed: &'static Text,
) -> Result<(), Refusal> {
    match values.iter().find(|x| !(-most..=most).contains(*x)) {
        None => Ok(()),
        Some(&value) => Err(bad_value(name, value, needed)),
    }
}

/// A number that cannot be used: `name` is `value`, it must be `needed`.
pub const fn bad_value(name: &'static Text, value: f64, needed: &'static Text) -> Refusal {
    Refusal::BadValue {
        name,
        value,
        needed,
    }
}

fn check_ticks(name: &'static Text, ticks: f64) -> Result<(), Refusal> {
    if ticks.is_finite() && ticks.abs() >= TICKS_MIN {
        return Ok(());
    }
    Err(bad_value(
        name,
        ticks,
        phrase!("a finite number other than 0", "不为 0 的有限数"),
    ))
}

fn check_payload(payload: &Payload) -> Result<(), Refusal> {
    let mass = [payload.mass];
    check_magnitude(
        &mass,
        PAYLOAD_MASS_MAX,
        phrase!("the payload mass", "负载质量"),
        phrase!("0 to 1000 kg", "0 到 1000 kg"),
    )?;
    let name = phrase!("a coordinate of the centre of gravity", "重心的坐标");
    check_magnitude(
        payload.cog.as_slice(),
        TOOL_REACH_MAX,
        name,
        phrase!("at most 10 m", "不超过 10 m"),
    )?;
    let name = phrase!("a component of the payload's inertia", "负载惯量的分量");
    let needed = phrase!("at most 100000 kg m²", "不超过 100000 kg m²");
    check_magnitude(&payload.inertia, PAYLOAD_INERTIA_MAX, name, needed)?;
    let checked = Payload::new(payload.mass, payload.cog.into(), payload.inertia);
    checked.map(drop).map_err(|error| match error {
        PayloadError::NegativeMass { mass_kg } => bad_value(
            phrase!("the payload mass", "负载质量"),
            mass_kg,
            phrase!("0 or more", "不小于 0"),
        ),
        PayloadError::ImpossibleInertia { principal, .. } => bad_value(
            phrase!(
                "the largest principal moment of the payload's inertia",
                "负载惯量的最大主矩"
            ),
            principal[2],
            phrase!(
                "positive and at most the sum of the other two",
                "正数，且不超过另两个之和"
            ),
        ),
        _ => bad_value(
            phrase!("a component of the payload", "负载的分量"),
            f64::NAN,
            phrase!("a finite number", "有限的数"),
        ),
    })
}
