//! The arguments of a call, checked against the declaration, as what the builtins want.

use std::fmt::Display;

use ::kinematics::{JointPositions, RpyPose};
use elite_lang::{ExceptionKind, Unwind, Value};
use messages::{Text, text};
use motion_api::FreedriveFrame;

use super::super::declare::{ParameterDefault, ParameterType, Range, alternatives};
use super::Call;
use crate::message::{Message, Severity};

impl Call<'_, '_> {
    /// A finite number inside the declared range.
    pub fn number(&mut self, index: usize) -> Result<f64, Unwind> {
        let ParameterType::Number(range) = self.parameter(index).kind else {
            unreachable!("declared as another kind")
        };
        let Some(value) = self.given(index).cloned() else {
            let ParameterDefault::Number(default) = self.parameter(index).default else {
                unreachable!("has no default")
            };
            return Ok(default);
        };
        let x = self.finite(index, &value)?;
        if !range.contains(x) {
            return Err(self.out_of_range(index, range, &value));
        }
        Ok(x)
    }

    /// `value` as a finite number.
    fn finite(&mut self, index: usize, value: &Value) -> Result<f64, Unwind> {
        match value.as_f64() {
            Some(x) if x.is_finite() => Ok(x),
            Some(_) => {
                let range = match self.parameter(index).kind {
                    ParameterType::Number(range) => range,
                    _ => Range::Any,
                };
                Err(self.out_of_range(index, range, value))
            }
            None => Err(self.wrong_type(index, &text!("a number", "数"), value)),
        }
    }

    fn out_of_range(&mut self, index: usize, range: Range, value: &Value) -> Unwind {
        match self.show(value) {
            Ok(shown) => {
                let text = text!(
                    "{} must be {range}, got {shown}",
                    "{} 必须是{range}，给出的是 {shown}",
                    self.place(index)
                );
                self.error(ExceptionKind::ValueError, text)
            }
            Err(raised) => raised,
        }
    }

    /// A whole number inside the declared range.
    pub fn integer(&mut self, index: usize) -> Result<i64, Unwind> {
        let kind = self.parameter(index).kind;
        if let (None, ParameterDefault::Integer(default)) =
            (self.given(index), self.parameter(index).default)
        {
            return Ok(default);
        }
        let value = self.required(index);
        let Some(n) = value.as_i64() else {
            let wanted = match &*value.type_name() {
                "int" => text!("an integer of at most 64 bits", "不超过 64 位的整数"),
                _ => text!("an integer", "整数"),
            };
            return Err(self.wrong_type(index, &wanted, &value));
        };
        let allowed = match kind {
            ParameterType::Integer(min, max) if n < min || n > max => match max {
                i64::MAX => text!("at least {min}", "至少 {min}"),
                _ => text!("{min} to {max}", "{min} 到 {max}"),
            },
            ParameterType::OneOf(numbers) if !numbers.contains(&n) => alternatives(numbers),
            _ => return Ok(n),
        };
        Err(self.not_allowed(index, &allowed, n))
    }

    /// A whole number that fits a byte: the declared range does.
    pub fn byte(&mut self, index: usize) -> Result<u8, Unwind> {
        let n = self.integer(index)?;
        u8::try_from(n).map_err(|_| self.not_allowed(index, &text!("0 to 255", "0 到 255"), n))
    }

    /// `f(): x must be ALLOWED, got GIVEN`.
    pub fn not_allowed(&mut self, index: usize, allowed: &Text, given: impl Display) -> Unwind {
        let text = text!(
            "{} must be {allowed}, got {given}",
            "{} 必须是{allowed}，给出的是 {given}",
            self.place(index)
        );
        self.error(ExceptionKind::ValueError, text)
    }

    /// `f(): x[k] must be ALLOWED, got GIVEN`; a `TypeError` where it is no whole number.
    pub(in crate::builtins) fn item_not_allowed(
        &mut self,
        index: usize,
        k: usize,
        allowed: &Text,
        item: &Value,
    ) -> Unwind {
        let kind = match item.as_i64() {
            Some(_) => ExceptionKind::ValueError,
            None => ExceptionKind::TypeError,
        };
        match self.show(item) {
            Ok(shown) => {
                let text = text!(
                    "{}[{k}] must be {allowed}, got {shown}",
                    "{}[{k}] 必须是{allowed}，给出的是 {shown}",
                    self.place(index)
                );
                self.error(kind, text)
            }
            Err(raised) => raised,
        }
    }

    /// `f(): x must be ALLOWED, not TYPE`.
    pub fn not_this_type(&mut self, index: usize, wanted: &Text) -> Unwind {
        let value = self.required(index);
        self.wrong_type(index, wanted, &value)
    }

    /// A text.
    pub fn text(&mut self, index: usize) -> Result<String, Unwind> {
        if let (None, ParameterDefault::Text(default)) =
            (self.given(index), self.parameter(index).default)
        {
            return Ok(default.to_owned());
        }
        let value = self.required(index);
        match value.as_str() {
            Some(text) => Ok(text.to_owned()),
            None => Err(self.wrong_type(index, &text!("a string", "字符串"), &value)),
        }
    }

    /// One of the declared words, by its place in the list.
    pub fn word(&mut self, index: usize) -> Result<usize, Unwind> {
        let text = self.text(index)?;
        let ParameterType::Word(words) = self.parameter(index).kind else {
            unreachable!("declared as another kind")
        };
        match words.iter().position(|word| *word == text) {
            Some(place) => Ok(place),
            None => Err(self.not_allowed(index, &alternatives(words), format_args!("{text:?}"))),
        }
    }

    /// A truth value; 0 and 1 are taken too.
    pub fn boolean(&mut self, index: usize) -> Result<bool, Unwind> {
        let Some(value) = self.given(index).cloned() else {
            return Ok(matches!(
                self.parameter(index).default,
                ParameterDefault::Boolean(true)
            ));
        };
        match value.as_bool() {
            Some(b) => Ok(b),
            None => Err(self.wrong_type(index, &text!("True or False", "True 或 False"), &value)),
        }
    }

    /// An argument that the language has already made sure is there.
    pub fn required(&self, index: usize) -> Value {
        self.given(index).cloned().unwrap_or(Value::None)
    }

    /// A list or tuple of exactly `N` finite numbers.
    fn fixed<const N: usize>(
        &mut self,
        index: usize,
        value: &Value,
        wanted: &Text,
    ) -> Result<[f64; N], Unwind> {
        let Some(items) = value.as_items() else {
            return Err(self.wrong_type(index, wanted, value));
        };
        if items.len() != N {
            let text = text!(
                "{} must be {wanted}, got {} numbers",
                "{} 必须是{wanted}，给出了 {} 个数",
                self.place(index),
                items.len()
            );
            return Err(self.error(ExceptionKind::ValueError, text));
        }
        let mut out = [0.0; N];
        for (k, item) in items.iter().enumerate() {
            out[k] = self.finite_item(index, k, item)?;
        }
        Ok(out)
    }

    /// Entry `k` of a list argument, which must be a finite number.
    fn finite_item(&mut self, index: usize, k: usize, item: &Value) -> Result<f64, Unwind> {
        let Some(x) = item.as_f64() else {
            let text = text!(
                "{}[{k}] must be a number, not {} ({})",
                "{}[{k}] 必须是数，不能是 {}（{}）",
                self.place(index),
                item.type_name(),
                self.show(item)?
            );
            return Err(self.error(ExceptionKind::TypeError, text));
        };
        if !x.is_finite() {
            let text = text!(
                "{}[{k}] must be a finite number, got {}",
                "{}[{k}] 必须是有限的数，给出的是 {}",
                self.place(index),
                self.show(item)?
            );
            return Err(self.error(ExceptionKind::ValueError, text));
        }
        Ok(x)
    }

    /// The entries of a list or tuple.
    pub fn list(&mut self, index: usize) -> Result<Vec<Value>, Unwind> {
        let value = self.required(index);
        let wanted = match self.parameter(index).kind {
            ParameterType::NumberOrList => text!("a number or a list of numbers", "数或数的列表"),
            ParameterType::NumberList => text!("a list of numbers", "数的列表"),
            ParameterType::Booleans(_) => text!("a list of True and False", "True 和 False 的列表"),
            ParameterType::ListOrText => text!("a list or a string", "列表或字符串"),
            _ => text!("a list", "列表"),
        };
        value
            .as_items()
            .ok_or_else(|| self.wrong_type(index, &wanted, &value))
    }

    /// Any count of finite numbers; a single one counts as a list where that is declared.
    pub fn number_list(&mut self, index: usize) -> Result<Vec<f64>, Unwind> {
        if self.parameter(index).kind == ParameterType::NumberOrList
            && let Some(value) = self.given(index).cloned()
            && value.as_f64().is_some()
        {
            return Ok(vec![self.finite(index, &value)?]);
        }
        let items = self.list(index)?;
        let numbers = items.iter().enumerate();
        numbers
            .map(|(k, item)| self.finite_item(index, k, item))
            .collect()
    }

    /// Truth values, as many as declared; 0 and 1 are taken too.
    pub fn booleans(&mut self, index: usize) -> Result<Vec<bool>, Unwind> {
        let items = self.list(index)?;
        if let ParameterType::Booleans(Some(count)) = self.parameter(index).kind
            && items.len() != count
        {
            let text = text!(
                "{} must be a list of {count} entries, each 0 or 1, got {} entries",
                "{} 必须是 {count} 项的列表，每项为 0 或 1，给出了 {} 项",
                self.place(index),
                items.len()
            );
            return Err(self.error(ExceptionKind::ValueError, text));
        }
        let mut flags = Vec::with_capacity(items.len());
        for (k, item) in items.iter().enumerate() {
            match item.as_f64() {
                Some(0.0) => flags.push(false),
                Some(1.0) => flags.push(true),
                known => {
                    let text = text!(
                        "{}[{k}] must be True, False, 0 or 1, got {}",
                        "{}[{k}] 必须是 True、False、0 或 1，给出的是 {}",
                        self.place(index),
                        self.show(item)?
                    );
                    let kind = match known {
                        Some(_) => ExceptionKind::ValueError,
                        None => ExceptionKind::TypeError,
                    };
                    return Err(self.error(kind, text));
                }
            }
        }
        Ok(flags)
    }

    /// `N` numbers; zeros when omitted and declared so.
    pub fn numbers<const N: usize>(&mut self, index: usize) -> Result<[f64; N], Unwind> {
        match self.given(index).cloned() {
            None => Ok([0.0; N]),
            Some(value) => self.fixed(
                index,
                &value,
                &text!("a list of {N} numbers", "{N} 个数的列表"),
            ),
        }
    }

    /// Six joint positions.
    pub fn joints(&mut self, index: usize) -> Result<JointPositions, Unwind> {
        let value = self.required(index);
        self.fixed(
            index,
            &value,
            &text!("six joint positions in rad", "六个关节位置（rad）"),
        )
        .map(JointPositions)
    }

    /// A pose.
    pub fn pose(&mut self, index: usize) -> Result<RpyPose, Unwind> {
        let value = self.required(index);
        self.fixed(
            index,
            &value,
            &text!(
                "a pose [x, y, z, Rx, Ry, Rz] in m and rad",
                "位姿 [x, y, z, Rx, Ry, Rz]（m 和 rad）"
            ),
        )
        .map(RpyPose::from_array)
    }

    /// Six joint positions, or `None` when omitted, `None` or the manual's symbolic empty text.
    pub fn joints_or_default(&mut self, index: usize) -> Result<Option<JointPositions>, Unwind> {
        if self.is_symbolic_default(index) {
            Ok(None)
        } else {
            self.joints(index).map(Some)
        }
    }

    /// A pose, or `None` when omitted, `None` or the manual's symbolic text.
    pub fn pose_or_default(&mut self, index: usize) -> Result<Option<RpyPose>, Unwind> {
        if self.is_symbolic_default(index) {
            Ok(None)
        } else {
            self.pose(index).map(Some)
        }
    }

    /// Whether an argument is omitted, `None`, the empty text or the manual's word for its default. The manual spells
    /// `active tcp` with a blank in some signatures and with an underscore in others; both are taken everywhere.
    pub fn is_symbolic_default(&self, index: usize) -> bool {
        match self.given(index) {
            None | Some(Value::None) => true,
            Some(value) => value.as_str().is_some_and(|text| {
                text.is_empty()
                    || matches!(self.parameter(index).default, ParameterDefault::Symbolic(word)
                        if word.replace('_', " ") == text.replace('_', " "))
            }),
        }
    }

    /// A number inside a range, or the nearest end of the range with a warning, once a task.
    pub fn clamped(&mut self, index: usize, (min, max): (f64, f64)) -> Result<f64, Unwind> {
        let given = self.number(index)?;
        if (min..=max).contains(&given) {
            return Ok(given);
        }
        let used = given.clamp(min, max);
        let place = self.place(index);
        if self.context.is_first_warning(place.english()) {
            let text = text!(
                "{place} is {given}, allowed are {min} to {max}; {used} is used",
                "{place} 为 {given}，允许 {min} 到 {max}；采用 {used}"
            );
            let origin = self.origin();
            self.context
                .observer()
                .message(&Message::log(Severity::Warning, origin, text));
        }
        Ok(used)
    }

    /// A frame of the manual: `"base"`, `"tool"` or a pose relative to the base.
    pub fn frame(&mut self, index: usize) -> Result<FreedriveFrame, Unwind> {
        let Some(value) = self.given(index).cloned() else {
            return Ok(FreedriveFrame::Base);
        };
        match value.as_str().map(str::to_owned).as_deref() {
            Some("base") => Ok(FreedriveFrame::Base),
            Some("tool") => Ok(FreedriveFrame::Tool),
            Some(other) => {
                let text = text!(
                    "{} must be \"base\", \"tool\" or a pose, got {other:?}",
                    "{} 必须是 \"base\"、\"tool\" 或位姿，给出的是 {other:?}",
                    self.place(index)
                );
                Err(self.error(ExceptionKind::ValueError, text))
            }
            None => self.pose(index).map(FreedriveFrame::Pose),
        }
    }
}
