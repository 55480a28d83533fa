//! Manual 3.1.21 to 3.1.24 and 3.1.29 to 3.1.32: conveyor encoders and tracking.

use elite_lang::{ExceptionKind, Unwind, Value};
use messages::text;
use motion_api::{CommandKind, EncoderRange, OverlayCommand, PulseDecoding, SettingCommand};

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Range, phrase,
};

/// The builtins of these sections.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "encoder_enable_set_tick_count",
        section: "3.1.21",
        category: Category::Motion,
        summary: phrase(
            "Prepares an encoder whose count the program gives.",
            "启用由程序给定计数的编码器。",
        ),
        params: &[
            ENCODER,
            Parameter::new(
                "range_id",
                ParameterType::Integer(0, 4),
                "",
                phrase(
                    "counter: 0 signed 32 bit, 1 to 4 unsigned 8, 16, 24, 32 bit",
                    "计数器：0 为有符号 32 位，1 到 4 为无符号 8、16、24、32 位",
                ),
            ),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(encoder_enable_set_tick_count),
    },
    Builtin {
        name: "encoder_get_tick_count",
        section: "3.1.22",
        category: Category::Motion,
        summary: phrase("Count of a conveyor encoder.", "传送带编码器的计数。"),
        params: &[ENCODER],
        returns: phrase("float, ticks", "float，计数"),
        waits: false,
        run: Some(encoder_get_tick_count),
    },
    Builtin {
        name: "encoder_set_tick_count",
        section: "3.1.23",
        category: Category::Motion,
        summary: phrase(
            "Gives the count of an encoder prepared with encoder_enable_set_tick_count().",
            "给出编码器的计数，须先调用 encoder_enable_set_tick_count()。",
        ),
        params: &[
            ENCODER,
            Parameter::new(
                "count",
                ParameterType::Number(Range::Any),
                "ticks",
                phrase(
                    "count, inside the range of the encoder",
                    "计数，须在编码器的量程内",
                ),
            ),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(encoder_set_tick_count),
    },
    Builtin {
        name: "encoder_unwind_delta_tick_count",
        section: "3.1.24",
        category: Category::Motion,
        summary: phrase(
            "A difference of two counts without the wrap of the counter.",
            "两次计数之差，消除计数器回绕的影响。",
        ),
        params: &[
            ENCODER,
            Parameter::new(
                "delta_tick_count",
                ParameterType::Number(Range::Any),
                "ticks",
                phrase("difference of two counts", "两次计数之差"),
            ),
        ],
        returns: phrase(
            "float, ticks, within half a range of zero",
            "float，计数，绝对值不超过量程的一半",
        ),
        waits: false,
        run: Some(encoder_unwind_delta_tick_count),
    },
    Builtin {
        name: "track_conveyor_circular",
        section: "3.1.29",
        category: Category::Motion,
        summary: phrase(
            "Superimposes the motion of a turntable on what the arm does from now on.",
            "从现在起在手臂运动上叠加转盘的运动。",
        ),
        params: &[
            Parameter::new(
                "center",
                ParameterType::Pose,
                "m, rad",
                phrase(
                    "centre of the table in the base frame; it turns about its z axis",
                    "基坐标系下转台的中心；转台绕其 z 轴转动",
                ),
            ),
            Parameter::new(
                "ticks_per_revolution",
                ParameterType::Number(Range::Any),
                "ticks",
                phrase(
                    "encoder ticks a turn, negative when they count against it",
                    "每转的编码器计数，方向相反时为负",
                ),
            ),
            Parameter::new(
                "rotate_tool",
                ParameterType::Boolean,
                "",
                phrase("the tool turns with the table", "工具随转台转动"),
            )
            .or(ParameterDefault::Boolean(false)),
            ENCODER.or(ParameterDefault::Integer(0)),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(track_conveyor_circular),
    },
    Builtin {
        name: "track_conveyor_linear",
        section: "3.1.30",
        category: Category::Motion,
        summary: phrase(
            "Superimposes the motion of a belt on what the arm does from now on.",
            "从现在起在手臂运动上叠加传送带的运动。",
        ),
        params: &[
            Parameter::new(
                "direction",
                ParameterType::Pose,
                "",
                phrase(
                    "where the belt runs to in the base frame: the first three numbers, of any \
                     length",
                    "基坐标系下传送带的运行方向：取前三个数，长度任意",
                ),
            ),
            Parameter::new(
                "ticks_per_meter",
                ParameterType::Number(Range::Any),
                "ticks/m",
                phrase(
                    "encoder ticks a metre, negative when they count against the direction",
                    "每米的编码器计数，方向相反时为负",
                ),
            ),
            ENCODER.or(ParameterDefault::Integer(0)),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(track_conveyor_linear),
    },
    Builtin {
        name: "stop_conveyor_tracking",
        section: "3.1.31",
        category: Category::Motion,
        summary: phrase(
            "Ends tracking and brings the tool to rest.",
            "结束跟踪并让工具停下。",
        ),
        params: &[],
        returns: phrase(
            "nothing; returns when the arm stands",
            "无返回值；手臂停稳后返回",
        ),
        waits: true,
        run: Some(stop_conveyor_tracking),
    },
    Builtin {
        name: "encoder_enable_pulse_decode",
        section: "3.1.32",
        category: Category::Motion,
        summary: phrase(
            "Counts pulses of an incremental encoder on the high-speed inputs.",
            "对接在高速输入上的增量编码器的脉冲计数。",
        ),
        params: &[
            ENCODER,
            Parameter::new(
                "decoder_type",
                ParameterType::Integer(1, 4),
                "",
                phrase(
                    "1 quadrature, 2 both edges, 3 rising edges, 4 falling edges",
                    "1 正交，2 双边沿，3 上升沿，4 下降沿",
                ),
            ),
            Parameter::new(
                "A",
                ParameterType::Integer(16, 17),
                "",
                phrase("input of channel A", "A 通道的输入"),
            ),
            Parameter::new(
                "B",
                ParameterType::Integer(0, 17),
                "",
                phrase(
                    "input of channel B: 16 or 17 in quadrature mode, otherwise 0",
                    "B 通道的输入：正交模式下为 16 或 17，否则为 0",
                ),
            ),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(encoder_enable_pulse_decode),
    },
];

const ENCODER: Parameter = Parameter::new(
    "encoder_index",
    ParameterType::Integer(0, 1),
    "",
    phrase("encoder", "编码器"),
);

fn encoder(call: &mut Call<'_, '_>, index: usize) -> Result<u8, Unwind> {
    // Declared as 0 to 1.
    call.integer(index).map(|n| n as u8)
}

fn encoder_enable_set_tick_count(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let encoder = encoder(call, 0)?;
    let range = EncoderRange::from_number(call.integer(1)? as u64).unwrap_or_default();
    call.set(SettingCommand::EncoderEnableSetTickCount { encoder, range })?;
    Ok(Value::None)
}

fn encoder_get_tick_count(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let encoder = usize::from(encoder(call, 0)?);
    Ok(Value::Float(call.state().encoder_counts[encoder]))
}

fn encoder_set_tick_count(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let encoder = encoder(call, 0)?;
    let count = call.number(1)?;
    call.set(SettingCommand::EncoderSetTickCount { encoder, count })?;
    Ok(Value::None)
}

fn encoder_unwind_delta_tick_count(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let encoder = usize::from(encoder(call, 0)?);
    let delta = call.number(1)?;
    let number = call.state().encoder_ranges[encoder];
    let range = EncoderRange::from_number(number).unwrap_or_default();
    Ok(Value::Float(range.unwrap_delta(delta)))
}

/// Ticks a unit of the belt's way: any number but 0.
fn ticks(call: &mut Call<'_, '_>, index: usize, name: &str) -> Result<f64, Unwind> {
    let ticks = call.number(index)?;
    if ticks != 0.0 {
        return Ok(ticks);
    }
    let text = text!(
        "{name} must be a number other than 0, got {ticks}",
        "{name} 必须是不为 0 的数，给出的是 {ticks}"
    );
    Err(call.error(ExceptionKind::ValueError, text))
}

fn track_conveyor_circular(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
        center: call.pose(0)?,
        ticks_per_revolution: ticks(call, 1, "track_conveyor_circular(): ticks_per_revolution")?,
        rotate_tool: call.boolean(2)?,
        encoder: encoder(call, 3)?,
    });
    call.set(kind)?;
    Ok(Value::None)
}

fn track_conveyor_linear(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
        direction: call.pose(0)?.xyz,
        ticks_per_meter: ticks(call, 1, "track_conveyor_linear(): ticks_per_meter")?,
        encoder: encoder(call, 2)?,
    });
    call.set(kind)?;
    Ok(Value::None)
}

fn stop_conveyor_tracking(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.run_command(OverlayCommand::StopConveyorTracking)?;
    Ok(Value::None)
}

fn encoder_enable_pulse_decode(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let encoder = encoder(call, 0)?;
    // Declared as 1 to 4.
    let decoding =
        PulseDecoding::from_number(call.integer(1)? as u64).unwrap_or(PulseDecoding::Quadrature);
    let (channel_a, channel_b) = (call.integer(2)? as u8, call.integer(3)? as u8);
    let two = decoding == PulseDecoding::Quadrature;
    if two && (channel_b < 16 || channel_b == channel_a) {
        let text = text!(
            "encoder_enable_pulse_decode(): B must be the other one of 16 and 17 in quadrature mode, got {channel_b}",
            "encoder_enable_pulse_decode()：正交模式下 B 必须是 16 和 17 中的另一个，给出的是 {channel_b}"
        );
        return Err(call.error(ExceptionKind::ValueError, text));
    }
    call.set(SettingCommand::EncoderEnablePulseDecode {
        encoder,
        decoding,
        channel_a,
        channel_b,
    })?;
    Ok(Value::None)
}
