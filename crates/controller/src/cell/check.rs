//! Values that have the right type but make no sense: what TOML and serde cannot see.

use core::fmt;

use messages::{Localized, Text, text};
use motion::InputPair;
use motion::contact::RIGID_STIFFNESS;
use path_planning::LINK_NAMES;
use path_planning::scene::fits_pattern;

use super::point::{IoDirection, IoPointName};
use super::schema::{Conveyor, InputValue, ModbusSignal, ShapeName, Size, Tables};

/// A value that has the right type but makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
#[error("{table} has {key} = {given}; {allowed}")]
#[zh("{table} 的 {key} = {given}；{allowed}")]
pub struct InvalidValue {
    /// The table with its name, for instance `obstacle "bench"`.
    pub table: Text,
    /// The key.
    pub key: &'static str,
    /// The value.
    pub given: Text,
    /// What is allowed.
    pub allowed: Text,
}

type ValidationResult = Result<(), InvalidValue>;

/// A table under check.
pub(super) struct TableCheck(Text);

impl TableCheck {
    pub(super) fn tool() -> Self {
        Self(Text::verbatim("tool"))
    }

    /// What sentences call the table.
    pub(super) fn words(&self) -> Text {
        self.0.clone()
    }

    pub(super) fn named(kind: &str, name: &str) -> Self {
        Self(Text::verbatim(format!("{kind} \"{name}\"")))
    }

    pub(super) fn numbered(kind: &str, index: usize) -> Self {
        Self(Text::verbatim(format!("{kind} {}", index + 1)))
    }

    /// A key that is not there.
    pub(super) fn missing(&self, key: &'static str, allowed: Text) -> InvalidValue {
        self.wrong_text(key, text!("nothing", "空"), allowed)
    }

    /// A key that is there and must not be.
    pub(super) fn needless(&self, key: &'static str, allowed: Text) -> InvalidValue {
        self.wrong_text(key, text!("given", "已给出"), allowed)
    }

    pub(super) fn wrong(
        &self,
        key: &'static str,
        given: impl fmt::Display,
        allowed: Text,
    ) -> InvalidValue {
        self.wrong_text(key, Text::verbatim(given.to_string()), allowed)
    }

    fn wrong_text(&self, key: &'static str, given: Text, allowed: Text) -> InvalidValue {
        InvalidValue {
            table: self.words(),
            key,
            given,
            allowed,
        }
    }

    fn finite(&self, key: &'static str, values: &[f64]) -> ValidationResult {
        self.all(
            key,
            values,
            text!("finite numbers are needed", "需要有限的数"),
            |x| x.is_finite(),
        )
    }

    fn not_negative(&self, key: &'static str, values: &[f64]) -> ValidationResult {
        self.all(
            key,
            values,
            text!("numbers of at least 0 are needed", "需要不小于 0 的数"),
            |x| x.is_finite() && x >= 0.0,
        )
    }

    fn at_most(&self, key: &'static str, values: &[f64], most: f64) -> ValidationResult {
        self.all(
            key,
            values,
            text!("allowed are 0 to {most}", "允许 0 到 {most}"),
            |x| (0.0..=most).contains(&x),
        )
    }

    fn positive(&self, key: &'static str, values: &[f64]) -> ValidationResult {
        self.all(
            key,
            values,
            text!("numbers above 0 are needed", "需要大于 0 的数"),
            |x| x.is_finite() && x > 0.0,
        )
    }

    fn all(
        &self,
        key: &'static str,
        values: &[f64],
        allowed: Text,
        good: impl Fn(f64) -> bool,
    ) -> ValidationResult {
        match values.iter().find(|x| !good(**x)) {
            Some(bad) => Err(self.wrong(key, bad, allowed)),
            None => Ok(()),
        }
    }

    fn axis(&self, key: &'static str, axis: &[f64; 3]) -> ValidationResult {
        self.finite(key, axis)?;
        if axis.iter().all(|x| *x == 0.0) {
            return Err(self.wrong(
                key,
                "[0, 0, 0]",
                text!("a direction is needed", "需要一个方向"),
            ));
        }
        Ok(())
    }

    /// Whether a simple shape has the lengths that it needs.
    pub(super) fn size(&self, shape: ShapeName, size: &Size) -> ValidationResult {
        let numbers = size.numbers();
        if numbers.len() != shape.numbers_of_size() {
            let allowed = match shape {
                ShapeName::Box => text!("a box needs x, y, z", "长方体需要 x、y、z"),
                ShapeName::Cylinder => {
                    text!("a cylinder needs radius, length", "圆柱需要半径和长度")
                }
                ShapeName::Sphere => text!("a sphere needs its radius", "球需要半径"),
                ShapeName::Plane => text!("a plane has no size", "平面没有尺寸"),
                ShapeName::Mesh => MESH_SIZE,
            };
            return Err(self.wrong("size", format_args!("{numbers:?}"), allowed));
        }
        self.positive("size", numbers)
    }

    pub(super) fn direction(
        &self,
        key: &'static str,
        point: IoPointName,
        direction: IoDirection,
    ) -> ValidationResult {
        if point.direction == direction {
            return Ok(());
        }
        let allowed = match direction {
            IoDirection::In => text!("an input is needed", "需要一个输入"),
            IoDirection::Out => text!("an output is needed", "需要一个输出"),
        };
        Err(self.wrong(key, point, allowed))
    }
}

/// Refusal of a `size` beside a mesh.
pub(super) const MESH_SIZE: Text = text!(
    "a mesh has the size of its file; scale changes it",
    "网格的大小取自其文件；用 scale 改变"
);

/// Most obstacles: each is looked at in every step of the servo.
const OBSTACLES_MAX: usize = 200;
/// Largest damping, N s/m, coefficient of friction, and deviations of the sensor, N and Nm: beyond them are typing
/// errors.
const DAMPING_MAX: f64 = 1e7;
const FRICTION_MAX: f64 = 10.0;
const NOISE_MAX: f64 = 1e4;
/// Strongest load, N and Nm.
const LOAD_MAX: f64 = motion_api::form::WRENCH_MAX;

/// Heaviest load on the flange, kg, its farthest centre of gravity, m, largest friction of a joint, Nm and Nm s/rad,
/// and largest inertia of a rotor at the joint, kg m².
const MASS_MAX: f64 = 1000.0;
const COG_MAX: f64 = 10.0;
const FRICTION_TORQUE_MAX: f64 = 1000.0;
const ROTOR_MAX: f64 = 100.0;

/// Longest name of an input or output, characters: what fits beside a button.
const NAME_CHARS_MAX: usize = 40;

/// Longest delay of a wire, s: its delay line holds a number a cycle.
const WIRE_DELAY_MAX: f64 = 600.0;

pub(super) fn values(cell: &Tables) -> ValidationResult {
    if cell.obstacle.len() > OBSTACLES_MAX {
        let table = TableCheck(text!("the cell", "单元"));
        let allowed = text!(
            "at most {OBSTACLES_MAX} of them are simulated",
            "最多仿真 {OBSTACLES_MAX} 个"
        );
        return Err(table.wrong("[[obstacle]]", cell.obstacle.len(), allowed));
    }
    for (index, obstacle) in cell.obstacle.iter().enumerate() {
        let table = TableCheck::named("obstacle", &obstacle.name);
        if cell.obstacle[..index]
            .iter()
            .any(|other| other.name == obstacle.name)
        {
            return Err(table.wrong(
                "name",
                format_args!("{:?}", obstacle.name),
                text!(
                    "every obstacle needs a name of its own",
                    "每个障碍物需要各自的名称"
                ),
            ));
        }
        obstacle.shape_keys().check(&table, true)?;
        table.finite("pose", &obstacle.pose)?;
        if let Some(stiffness) = obstacle.stiffness
            && !(stiffness > 0.0 && stiffness <= RIGID_STIFFNESS)
        {
            let allowed = text!(
                "more than 0 up to {RIGID_STIFFNESS:e} N/m, or none for a hard one",
                "大于 0、不超过 {RIGID_STIFFNESS:e} N/m；坚硬物体不必给出"
            );
            return Err(table.wrong("stiffness", stiffness, allowed));
        }
        table.at_most("damping", obstacle.damping.as_slice(), DAMPING_MAX)?;
        table.at_most("friction", obstacle.friction.as_slice(), FRICTION_MAX)?;
    }
    if let Some(tool) = &cell.tool {
        let table = TableCheck::tool();
        tool.shape_keys().check(&table, false)?;
        table.finite("pose", &tool.pose)?;
    }
    for (index, touch) in cell.touch.iter().enumerate() {
        let table = TableCheck::numbered("touch", index);
        for (key, pattern) in [("a", &touch.a), ("b", &touch.b)] {
            if !names_something(cell, pattern) {
                let allowed = text!(
                    "the name of a link (shoulder, upper_arm, forearm, wrist_1, wrist_2, wrist_3, base), \
                               of the tool, or of something in this cell; * stands for any letters",
                    "应为连杆（shoulder、upper_arm、forearm、wrist_1、wrist_2、wrist_3、base）、工具或此单元中物体的名称；* 代表任意字符"
                );
                return Err(table.wrong(key, format_args!("{pattern:?}"), allowed));
            }
        }
    }
    for (index, plane) in cell.safety_plane.iter().enumerate() {
        let table = TableCheck::named("safety_plane", &plane.name);
        if cell.safety_plane[..index]
            .iter()
            .any(|other| other.name == plane.name)
        {
            return Err(table.wrong(
                "name",
                format_args!("{:?}", plane.name),
                text!(
                    "every plane needs a name of its own",
                    "每个平面需要各自的名称"
                ),
            ));
        }
        table.finite("point", &plane.point)?;
        table.axis("normal", &plane.normal)?;
        if let Some(pair @ 4..) = plane.ci_pair {
            return Err(table.wrong("ci_pair", pair, text!("allowed are 0 to 3", "允许 0 到 3")));
        }
    }
    let sensor = TableCheck(Text::verbatim("sensor"));
    sensor.at_most("force_noise", &[cell.sensor.force_noise], NOISE_MAX)?;
    sensor.at_most("torque_noise", &[cell.sensor.torque_noise], NOISE_MAX)?;
    payload(cell)?;
    let arm = TableCheck(Text::verbatim("arm"));
    arm.at_most("coulomb", &cell.arm.coulomb, FRICTION_TORQUE_MAX)?;
    arm.at_most("viscous", &cell.arm.viscous, FRICTION_TORQUE_MAX)?;
    arm.at_most("rotor_inertia", &cell.arm.rotor_inertia, ROTOR_MAX)?;
    for (index, load) in cell.wrench.iter().enumerate() {
        let table = TableCheck::numbered("wrench", index);
        table.not_negative("at", &[load.at])?;
        table.positive("duration", &[load.duration])?;
        let allowed = text!(
            "numbers of at most {LOAD_MAX} N or Nm are needed",
            "需要不超过 {LOAD_MAX} N 或 Nm 的数"
        );
        table.all("wrench", &load.wrench, allowed, |x| x.abs() <= LOAD_MAX)?;
    }
    for (index, belt) in cell.conveyor.iter().enumerate() {
        let table = TableCheck::numbered("conveyor", index);
        conveyor(&table, belt)?;
        if let Some(encoder) = belt.encoder
            && cell.conveyor[..index]
                .iter()
                .any(|other| other.encoder == belt.encoder)
        {
            return Err(table.wrong(
                "encoder",
                encoder,
                text!(
                    "one conveyor turns an encoder",
                    "一个编码器只由一条传送带带动"
                ),
            ));
        }
    }
    for (index, wire) in cell.wire.iter().enumerate() {
        let table = TableCheck::numbered("wire", index);
        table.direction("from", wire.from, IoDirection::Out)?;
        table.direction("to", wire.to, IoDirection::In)?;
        if wire.from.group.is_digital() != wire.to.group.is_digital() {
            return Err(table.wrong(
                "to",
                wire.to,
                text!(
                    "{} can be wired to its own kind only",
                    "{} 只能与同类的点相连",
                    wire.from
                ),
            ));
        }
        if !(0.0..=WIRE_DELAY_MAX).contains(&wire.delay) {
            let allowed = text!(
                "allowed are 0 to {WIRE_DELAY_MAX} s",
                "允许 0 到 {WIRE_DELAY_MAX} s"
            );
            return Err(table.wrong("delay", wire.delay, allowed));
        }
        if let Some(other) = cell.wire[..index]
            .iter()
            .position(|other| other.to == wire.to)
        {
            let allowed = text!(
                "an input takes one wire, this one has wire {}",
                "一个输入只接一条线，此输入已有接线 {}",
                other + 1
            );
            return Err(table.wrong("to", wire.to, allowed));
        }
    }
    for (index, input) in cell.input.iter().enumerate() {
        let table = TableCheck::numbered("input", index);
        table.not_negative("at", &[input.at])?;
        table.direction("set", input.set, IoDirection::In)?;
        match (input.set.group.is_digital(), input.value) {
            (true, InputValue::Level(_)) => {}
            (false, InputValue::Number(number)) => table.finite("value", &[number])?,
            (true, InputValue::Number(number)) => {
                return Err(table.wrong(
                    "value",
                    number,
                    text!("{} takes true or false", "{} 取 true 或 false", input.set),
                ));
            }
            (false, InputValue::Level(level)) => {
                return Err(table.wrong(
                    "value",
                    level,
                    text!("{} takes a number", "{} 取一个数", input.set),
                ));
            }
        }
    }
    for (index, input) in cell.safety_input.iter().enumerate() {
        let table = TableCheck::numbered("safety_input", index);
        if input.pair >= InputPair::COUNT {
            return Err(table.wrong(
                "pair",
                input.pair,
                text!("allowed are 0 to 3", "允许 0 到 3"),
            ));
        }
        for other in &cell.safety_input[..index] {
            if other.function == input.function {
                let name = input.function.name();
                return Err(table.wrong(
                    "function",
                    name,
                    text!("a function has one pair of inputs", "一个功能只有一对输入"),
                ));
            }
            if other.pair == input.pair {
                let allowed = text!(
                    "this pair asks for {} already",
                    "这一对已用于 {}",
                    other.function.name()
                );
                return Err(table.wrong("pair", input.pair, allowed));
            }
        }
    }
    for (index, serial) in cell.serial.iter().enumerate() {
        if serial.device.is_empty() {
            let table = TableCheck::numbered("serial", index);
            return Err(table.wrong(
                "device",
                "\"\"",
                text!(
                    "a device or pty path or tcp:host:port is needed",
                    "需要设备或 pty 的路径，或 tcp:host:port"
                ),
            ));
        }
    }
    for (index, signal) in cell.modbus.iter().enumerate() {
        modbus(&TableCheck::numbered("modbus", index), signal)?;
    }
    names(cell)
}

/// Whether a pattern fits anything that can touch.
fn names_something(cell: &Tables, pattern: &str) -> bool {
    let mut names = LINK_NAMES
        .into_iter()
        .chain(["tool", "floor"])
        .chain(cell.obstacle.iter().map(|obstacle| &*obstacle.name))
        .chain(cell.conveyor.iter().filter_map(|belt| belt.name.as_deref()));
    // Copies of a part, and parts of sources, have a number behind its name.
    let mut parts = cell.part.iter().flat_map(|part| {
        let name = &part.name;
        [name.clone(), format!("{name}[0]"), format!("{name}#1")]
    });
    names.any(|name| fits_pattern(pattern, name)) || parts.any(|name| fits_pattern(pattern, &name))
}

/// Names are read on buttons: short, of one line, and each for one point of a direction.
fn names(cell: &Tables) -> ValidationResult {
    for (point, name) in &cell.names {
        let table = TableCheck(Text::verbatim(format!("names \"{point}\"")));
        let chars = name.chars().count();
        let is_good = !name.trim().is_empty()
            && chars <= NAME_CHARS_MAX
            && !name.chars().any(char::is_control);
        if !is_good {
            let mut given: String = name.chars().take(NAME_CHARS_MAX).collect();
            if chars > NAME_CHARS_MAX {
                given.push('…');
            }
            let allowed = text!(
                "a text of 1 to {NAME_CHARS_MAX} characters in one line is needed",
                "需要一行 1 到 {NAME_CHARS_MAX} 个字符的文本"
            );
            return Err(table.wrong("name", format_args!("{given:?}"), allowed));
        }
        let twin = cell.names.iter().find(|(other, called)| {
            *other < point && *called == name && other.direction == point.direction
        });
        if let Some((twin, _)) = twin {
            let allowed = text!("{twin} is called so already", "{twin} 已用此名称");
            return Err(table.wrong("name", format_args!("{name:?}"), allowed));
        }
    }
    Ok(())
}

fn payload(cell: &Tables) -> ValidationResult {
    let Some(payload) = &cell.payload else {
        return Ok(());
    };
    let table = TableCheck(Text::verbatim("payload"));
    table.at_most("mass", &[payload.mass], MASS_MAX)?;
    let allowed = text!(
        "allowed are -{COG_MAX} to {COG_MAX}",
        "允许 -{COG_MAX} 到 {COG_MAX}"
    );
    table.all("cog", &payload.cog, allowed, |x| x.abs() <= COG_MAX)?;
    table.finite("inertia", &payload.inertia)?;
    match kinematics::Payload::new(payload.mass, payload.cog, payload.inertia) {
        Ok(_) => Ok(()),
        Err(error) => {
            let given = format!("{:?}", payload.inertia);
            Err(table.wrong("inertia", given, Text::of(&error)))
        }
    }
}

fn conveyor(table: &TableCheck, belt: &Conveyor) -> ValidationResult {
    table.finite("speed", &[belt.speed])?;
    table.not_negative("start_at", &[belt.start_at])?;
    if !belt.has_surface() {
        let keys = [
            ("run", belt.run.is_some()),
            ("speed_from", belt.speed_from.is_some()),
            ("acceleration", belt.acceleration.is_some()),
            ("friction", belt.friction.is_some()),
            ("pose", belt.pose.is_some()),
        ];
        if let Some((key, _)) = keys.into_iter().find(|(_, is_given)| *is_given) {
            let allowed = text!(
                "it goes with a surface: pose and size of a belt, radius of a turntable",
                "它需要有表面：皮带的位姿和尺寸，或转台的半径"
            );
            return Err(table.wrong(key, "given", allowed));
        }
    }
    let Some(encoder) = belt.encoder else {
        return match belt.has_surface() {
            true => Ok(()),
            false => Err(table.missing(
                "encoder",
                text!(
                    "a conveyor turns an encoder, or carries parts",
                    "传送带应带动编码器或运送工件"
                ),
            )),
        };
    };
    if encoder > 1 {
        return Err(table.wrong(
            "encoder",
            encoder,
            text!("allowed are 0 and 1", "允许 0 和 1"),
        ));
    }
    match (
        belt.direction,
        belt.ticks_per_meter,
        belt.center,
        belt.ticks_per_revolution,
    ) {
        (Some(direction), Some(ticks), None, None) => {
            table.axis("direction", &direction)?;
            table.positive("ticks_per_meter", &[ticks])
        }
        (None, None, Some(center), Some(ticks)) => {
            table.finite("center", &center)?;
            table.positive("ticks_per_revolution", &[ticks])
        }
        _ => Err(table.wrong(
            "encoder",
            encoder,
            text!("a conveyor is linear, with direction and ticks_per_meter, \
             or circular, with center and ticks_per_revolution",
             "传送带为直线型（direction 和 ticks_per_meter）或圆周型（center 和 ticks_per_revolution）"),
        )),
    }
}

/// Ranges of manual 6.1.1.
fn modbus(table: &TableCheck, signal: &ModbusSignal) -> ValidationResult {
    if signal.signal_type > 3 {
        return Err(table.wrong(
            "signal_type",
            signal.signal_type,
            text!("allowed are 0 to 3", "允许 0 到 3"),
        ));
    }
    if !(1..=123).contains(&signal.registers_count) {
        return Err(table.wrong(
            "registers_count",
            signal.registers_count,
            text!("allowed are 1 to 123", "允许 1 到 123"),
        ));
    }
    Ok(())
}
