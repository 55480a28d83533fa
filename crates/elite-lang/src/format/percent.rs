//! The `%` operator of strings and bytes.

use std::borrow::Cow;

use elite_syntax::surrogate::code_of;

use super::{Spec, integer, real, text};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::chunked::{WORK_PER_BYTE, pieces};
use crate::value::int::Int;
use crate::value::symbol::known;
use crate::value::{Bytes, Instance, R, Unwind, Value};

/// A conversion specifier: `%[(key)][flags][width][.precision]type`.
#[derive(Default)]
struct PercentSpec {
    left: bool,
    plus: bool,
    blank: bool,
    zero: bool,
    alternate: bool,
    width: usize,
    precision: Option<usize>,
}

/// Where the values come from.
struct PercentArgs<'v> {
    mapping: Option<&'v Value>,
    items: &'v [Value],
    next: usize,
    /// A key has been used: the mapping is no argument of its own any more.
    keyed: bool,
    /// What the result is, `new_str` or `bytes`.
    what: &'static str,
}

impl<'v> PercentArgs<'v> {
    fn of_items(items: &'v [Value], what: &'static str) -> Self {
        PercentArgs {
            mapping: None,
            items,
            next: 0,
            keyed: false,
            what,
        }
    }

    fn of(args: &'v Value, what: &'static str) -> Self {
        if let Value::Tuple(tuple) = args {
            return PercentArgs::of_items(tuple.items(), what);
        }
        // Anything with items counts, as in CPython.
        let is_mapping = matches!(
            args,
            Value::Dict(_) | Value::List(_) | Value::Range(_) | Value::LongRange(_)
        ) || what != "bytes"
            && matches!(args, Value::Bytes(_) | Value::ByteArray(_))
            || matches!(args, Value::Instance(instance) if has_items(instance, what));
        PercentArgs {
            mapping: is_mapping.then_some(args),
            ..PercentArgs::of_items(std::slice::from_ref(args), what)
        }
    }

    fn of_bytes(&self) -> bool {
        self.what == "bytes"
    }
}

impl Evaluator<'_> {
    /// The tuple that an instance of a class derived from it is; anything else as it is.
    fn arguments<'v>(&self, args: &'v Value) -> Cow<'v, Value> {
        match self.unwrap_builtin(args) {
            tuple @ Value::Tuple(_) => Cow::Owned(tuple),
            _ => Cow::Borrowed(args),
        }
    }

    /// `format % args`: one conversion alone gives the text that the object made, which may be of a class derived from
    /// `str`.
    pub fn percent_value(&self, format: &str, args: &Value) -> R {
        if let (Value::Instance(instance), "%s" | "%r" | "%a") = (args, format)
            && !matches!(instance.builtin_value(), Some(Value::Tuple(_)))
        {
            return match format {
                "%s" => self.str_value(args),
                "%r" => self.repr_value(args),
                _ => self.ascii_value(args),
            };
        }
        self.new_str(self.percent_format(format, args)?)
    }

    /// `format % args`
    fn percent_format(&self, format: &str, args: &Value) -> R<String> {
        let mut out = String::with_capacity(format.len() + 16);
        let args = self.arguments(args);
        self.percent(format, PercentArgs::of(&args, "string"), &mut out)?;
        Ok(out)
    }

    /// `format % (item, …)`
    pub fn percent_format_items(&self, format: &str, items: &[Value]) -> R<String> {
        let mut out = String::with_capacity(format.len() + 16);
        self.percent(format, PercentArgs::of_items(items, "string"), &mut out)?;
        Ok(out)
    }

    /// `bytes % args`: the text of a format in Latin-1 is formatted and goes back to bytes.
    pub fn percent_bytes(&self, format: &Value, args: &Value) -> R {
        let data = self.bytes_like(format).unwrap_or_default();
        let text = self.decode_latin1(&data)?;
        let mut out = String::new();
        let args = self.arguments(args);
        self.percent(&text, PercentArgs::of(&args, "bytes"), &mut out)?;
        let mut data = Vec::new();
        self.grow(&mut data, out.len())?;
        for piece in pieces(&out) {
            data.extend(
                piece
                    .chars()
                    .map(|c| u8::try_from(c as u32).unwrap_or(b'?')),
            );
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(match format {
            Value::ByteArray(_) => {
                Value::ByteArray(std::rc::Rc::new(crate::value::ByteArray::new(data)))
            }
            _ => Value::Bytes(std::rc::Rc::new(Bytes::new(data))),
        })
    }

    fn percent(&self, format: &str, mut source: PercentArgs<'_>, out: &mut String) -> R<()> {
        let mut rest = format;
        while let Some(percent) = self.find_bytes(rest.as_bytes(), b"%")? {
            self.push_text(out, &rest[..percent])?;
            self.charge(WORK_PER_BYTE)?;
            let at = format.len() - rest.len() + percent;
            rest = self.conversion(&rest[percent + 1..], format, at, &mut source, out)?;
        }
        self.push_text(out, rest)?;
        let all_used = source.next >= source.items.len() || source.mapping.is_some();
        if !all_used {
            let what = source.what;
            return Err(self.type_error(format!(
                "not all arguments converted during {what} formatting"
            )));
        }
        self.check_allocation(out.len())
    }

    fn next_argument(&self, source: &mut PercentArgs<'_>) -> R {
        if source.keyed {
            return Err(self.type_error("not enough arguments for format string"));
        }
        let item = source.items.get(source.next).cloned();
        source.next += 1;
        item.ok_or_else(|| self.type_error("not enough arguments for format string"))
    }

    /// One conversion after its `%`, which is at byte `at` of `format`; returns the text after it.
    fn conversion<'t>(
        &self,
        text_after: &'t str,
        format: &str,
        at: usize,
        source: &mut PercentArgs<'_>,
        out: &mut String,
    ) -> R<&'t str> {
        let mut rest = text_after;
        let incomplete = || self.value_error("incomplete format");
        let mut keyed = None;
        if let Some(after) = rest.strip_prefix('(') {
            let end = matching_parenthesis(self, after)?
                .ok_or_else(|| self.value_error("incomplete format key"))?;
            let Some(mapping) = source.mapping else {
                return Err(self.type_error("format requires a mapping"));
            };
            source.keyed = true;
            let key = if source.of_bytes() {
                let bytes = self.to_latin1(&after[..end])?;
                Value::Bytes(std::rc::Rc::new(Bytes::new(bytes)))
            } else {
                self.new_str_from(&after[..end])?
            };
            keyed = Some(self.item(mapping, &key)?);
            rest = &after[end + 1..];
        }
        let mut conversion = PercentSpec::default();
        while let Some(flag) = rest.chars().next() {
            self.charge(WORK_PER_BYTE)?;
            match flag {
                '-' => conversion.left = true,
                '+' => conversion.plus = true,
                ' ' => conversion.blank = true,
                '0' => conversion.zero = true,
                '#' => conversion.alternate = true,
                _ => break,
            }
            rest = &rest[1..];
        }
        let width = self.width(&mut rest, source)?;
        conversion.left |= width < 0;
        // The least of all has no positive counterpart; in C it stays below zero, so nothing is filled.
        conversion.width = usize::try_from(width.wrapping_abs()).unwrap_or(0);
        if let Some(after) = rest.strip_prefix('.') {
            rest = after;
            let precision = self.precision(&mut rest, source)?;
            conversion.precision = Some(usize::try_from(precision).unwrap_or(0));
        }
        rest = &rest[self.prefix_len(rest, |c| matches!(c, 'l' | 'h' | 'L'))?..];
        let kind = rest.chars().next().ok_or_else(incomplete)?;
        rest = &rest[kind.len_utf8()..];
        if kind == '%' && keyed.is_none() && text_after.starts_with('%') {
            out.push('%');
            return Ok(rest);
        }
        let value = match keyed {
            Some(value) => value,
            None => self.next_argument(source)?,
        };
        if !"sradiuoxXeEfFgGcb".contains(kind) || (kind == 'b' && !source.of_bytes()) {
            let end = format.len() - rest.len();
            let index =
                self.count_chars(&format[..at])? + self.count_chars(&format[at + 1..end])?;
            return Err(self.unsupported_conversion(kind, index, source.of_bytes()));
        }
        let value = match (source.of_bytes(), kind) {
            (true, 's' | 'b' | 'c') => self.byte_argument(kind, value)?,
            (true, 'e' | 'E' | 'f' | 'F' | 'g' | 'G') => {
                let float = self.to_f64(&value).map_err(|raised| match raised {
                    Unwind::Stop => raised,
                    _ => {
                        let name = self.core.types.name_of(&value);
                        self.type_error(format!("float argument required, not {name}"))
                    }
                })?;
                Value::Float(float)
            }
            _ => value,
        };
        // Messages of bytes know no `%i`, and what they show of objects is ASCII.
        let kind = match kind {
            'i' if source.of_bytes() => 'd',
            'r' if source.of_bytes() => 'a',
            other => other,
        };
        self.convert_percent(kind, &conversion, &value, out)?;
        Ok(rest)
    }

    #[cold]
    fn unsupported_conversion(&self, kind: char, index: usize, of_bytes: bool) -> Unwind {
        let code = code_of(kind);
        let shown = match code {
            // A `char` of C is below zero here, which is no character.
            128.. if of_bytes => {
                let text = "character argument not in range(0x110000)";
                return self.raise(ExceptionKind::OverflowError, text);
            }
            31..=126 => kind,
            _ if of_bytes => kind,
            _ => '?',
        };
        self.value_error(format!(
            "unsupported format character '{shown}' ({code:#x}) at index {index}"
        ))
    }

    /// An argument of a conversion to bytes, as text of the same codes.
    fn byte_argument(&self, kind: char, value: Value) -> R {
        let value =
            match kind == 'c' && matches!(value, Value::Instance(_)) && self.has_index(&value) {
                true => {
                    let int = self.to_int(&value).map_err(|raised| {
                        match self.is_kind(&raised, ExceptionKind::TypeError) {
                            true => self.type_error(ONE_BYTE),
                            false => raised,
                        }
                    });
                    int?.into_value()
                }
                false => value,
            };
        if kind != 'c'
            && let Value::Instance(instance) = &value
            && self.bytes_like(&value).is_none()
            && instance.class.lookup(known::BYTES).is_some()
        {
            let data = crate::builtins::types::bytes::of_object(self, &value, "bytes")?;
            return self.new_str(self.decode_latin1(&data)?);
        }
        match self.bytes_like(&value) {
            Some(data) if kind == 'c' && data.len() != 1 => Err(self.type_error(ONE_BYTE)),
            Some(data) => self.new_str(self.decode_latin1(&data)?),
            None if kind == 'c'
                && matches!(
                    self.unwrap_builtin(&value),
                    Value::Int(0..=255) | Value::Bool(_)
                ) =>
            {
                Ok(value)
            }
            None if kind == 'c' && Int::of(&self.unwrap_builtin(&value)).is_some() => {
                let kind = ExceptionKind::OverflowError;
                Err(self.raise(kind, "%c arg not in range(256)"))
            }
            None => {
                let name = self.core.types.name_of(&value);
                Err(self.type_error(if kind == 'c' {
                    ONE_BYTE.to_owned()
                } else {
                    format!(
                        "%b requires a bytes-like object, or an object that implements __bytes__, not '{name}'"
                    )
                }))
            }
        }
    }

    /// A width: digits, or `*` for the next argument.
    fn width(&self, rest: &mut &str, source: &mut PercentArgs<'_>) -> R<i64> {
        if let Some(value) = self.take_star_argument(rest, source)? {
            return self.index(&value);
        }
        let width = self.digits(rest)?.try_into();
        width.map_err(|_| self.value_error("width too big"))
    }

    /// A precision, which is an `int` of C.
    fn precision(&self, rest: &mut &str, source: &mut PercentArgs<'_>) -> R<i32> {
        if let Some(value) = self.take_star_argument(rest, source)? {
            return self.c_int(&value);
        }
        let precision = self.digits(rest)?.try_into();
        precision.map_err(|_| {
            self.value_error(match source.of_bytes() {
                true => "prec too big",
                false => "precision too big",
            })
        })
    }

    /// The next argument, if `*` stands here.
    fn take_star_argument(
        &self,
        rest: &mut &str,
        source: &mut PercentArgs<'_>,
    ) -> R<Option<Value>> {
        let Some(after) = rest.strip_prefix('*') else {
            return Ok(None);
        };
        *rest = after;
        let value = self.next_argument(source)?;
        match Int::of(&self.unwrap_builtin(&value)) {
            Some(int) => Ok(Some(int.into_value())),
            None => Err(self.type_error("* wants int")),
        }
    }

    /// The number that stands here, 0 if there is none; the greatest there is if it is greater.
    fn digits(&self, rest: &mut &str) -> R<u64> {
        let length = self.prefix_len(rest, |c| c.is_ascii_digit())?;
        let (digits, after) = rest.split_at(length);
        *rest = after;
        let zeros = self.prefix_len(digits, |c| c == '0')?;
        Ok(match digits[zeros..].parse() {
            Ok(number) => number,
            Err(_) if zeros == length => 0,
            Err(_) => u64::MAX,
        })
    }

    /// Refuses a conversion whose filling alone would take all memory there is; its value is known to be good.
    fn check_room(&self, conversion: &Spec) -> R<()> {
        self.check_allocation(conversion.width.max(conversion.precision.unwrap_or(0)))
    }

    fn convert_percent(
        &self,
        kind: char,
        conversion: &PercentSpec,
        value: &Value,
        out: &mut String,
    ) -> R<()> {
        let numeric = !"srac".contains(kind) && kind != 'b';
        let zero = conversion.zero && numeric && !conversion.left;
        let spec = Spec {
            fill: if zero { '0' } else { ' ' },
            align: Some(match (conversion.left, zero) {
                (true, _) => '<',
                (_, true) => '=',
                _ => '>',
            }),
            sign: match (conversion.plus, conversion.blank) {
                (true, _) if numeric => '+',
                (_, true) if numeric => ' ',
                _ => '-',
            },
            no_negative_zero: false,
            alternate: conversion.alternate,
            width: conversion.width,
            grouping: None,
            precision: conversion.precision,
            kind: Some(kind),
        };
        let as_text = Spec {
            kind: None,
            alternate: false,
            ..spec.clone()
        };
        match kind {
            's' | 'b' => match value {
                Value::Str(value) => text(value.as_str(), &as_text, self, out),
                other => text(&self.str(other)?, &as_text, self, out),
            },
            'r' => text(&self.repr(value)?, &as_text, self, out),
            'a' => text(&self.ascii(value)?, &as_text, self, out),
            'c' => {
                // A text is taken as it is, also one that is a number, too.
                let is_text = matches!(self.unwrap_builtin(value), Value::Str(_));
                let is_object = matches!(value, Value::Instance(_)) && !is_text;
                let value = match is_object && self.has_index(value) {
                    true => match self.to_int(value) {
                        Err(raised) if self.is_kind(&raised, ExceptionKind::TypeError) => {
                            return Err(self.type_error("%c requires int or char"));
                        }
                        int => int?.into_value(),
                    },
                    false => self.unwrap_builtin(value),
                };
                let text_value = match value {
                    Value::Str(text) if text.len() == 1 => text.as_str().to_owned(),
                    Value::Bool(flag) => char::from(u8::from(flag)).to_string(),
                    Value::BigInt(_) => {
                        let kind = ExceptionKind::OverflowError;
                        return Err(self.raise(kind, "%c arg not in range(0x110000)"));
                    }
                    Value::Int(code) => match u32::try_from(code)
                        .ok()
                        .and_then(elite_syntax::surrogate::char_of)
                    {
                        Some(c) => c.to_string(),
                        None => {
                            let kind = ExceptionKind::OverflowError;
                            return Err(self.raise(kind, "%c arg not in range(0x110000)"));
                        }
                    },
                    _ => return Err(self.type_error("%c requires int or char")),
                };
                text(
                    &text_value,
                    &Spec {
                        precision: None,
                        ..as_text
                    },
                    self,
                    out,
                )
            }
            'd' | 'i' | 'u' => self.percent_integer(kind, 'd', &spec, value, out),
            'o' | 'x' | 'X' => self.percent_integer(kind, kind, &spec, value, out),
            _ => {
                let float = self.to_f64(value)?;
                self.check_room(&spec)?;
                real(
                    float,
                    &Spec {
                        kind: Some(kind),
                        ..spec
                    },
                    "float",
                    self,
                    out,
                )
            }
        }
    }

    fn percent_integer(
        &self,
        shown: char,
        kind: char,
        spec: &Spec,
        value: &Value,
        out: &mut String,
    ) -> R<()> {
        let int = match self.unwrap_builtin(value) {
            // What has a way to a number becomes an integer as `int` makes one, from its text at last.
            other if kind == 'd' && Int::of(&other).is_none() && is_number(value) => {
                let int = crate::builtins::types::int_from(self, value).map_err(|raised| {
                    if self.is_kind(&raised, ExceptionKind::TypeError) {
                        let name = self.core.types.name_of(value);
                        return self.type_error(format!(
                            "%{shown} format: a real number is required, not {name}"
                        ));
                    }
                    raised
                })?;
                Int::of(&int).unwrap_or(Int::Small(0))
            }
            Value::Float(float) if kind == 'd' => {
                if !float.is_finite() {
                    let what = if float.is_nan() {
                        "float NaN"
                    } else {
                        "float infinity"
                    };
                    let text = format!("cannot convert {what} to integer");
                    return Err(if float.is_nan() {
                        self.value_error(text)
                    } else {
                        self.raise(ExceptionKind::OverflowError, text)
                    });
                }
                Int::of(&crate::value::int::from_f64(float)).unwrap_or(Int::Small(0))
            }
            other => match Int::of(&other) {
                Some(int) => int,
                None => self.to_int(value).map_err(|raised| {
                    if !self.is_kind(&raised, ExceptionKind::TypeError) {
                        return raised;
                    }
                    let name = self.core.types.name_of(value);
                    let wanted = if kind == 'd' {
                        "a real number"
                    } else {
                        "an integer"
                    };
                    self.type_error(format!("%{shown} format: {wanted} is required, not {name}"))
                })?,
            },
        };
        self.check_room(spec)?;
        let precision = spec.precision;
        let spec = Spec {
            kind: Some(kind),
            precision: None,
            ..spec.clone()
        };
        let Some(precision) = precision else {
            return integer(&int, &spec, "int", self, out);
        };
        // A precision of an integer is its least number of digits.
        let mut digits = String::new();
        let bare = Spec {
            width: 0,
            sign: '-',
            fill: ' ',
            align: None,
            ..spec.clone()
        };
        integer(&int, &bare, "int", self, &mut digits)?;
        let magnitude = digits.trim_start_matches('-');
        let mut filled = String::new();
        self.push_repeated(&mut filled, "0", precision.saturating_sub(magnitude.len()))?;
        self.push_text(&mut filled, magnitude)?;
        let sign = super::sign_of(int.is_negative(), &spec);
        super::pad(sign, &filled, spec.align.unwrap_or('>'), &spec, self, out)
    }
}

/// Index of the parenthesis that closes the one before `text`.
fn matching_parenthesis(ev: &Evaluator<'_>, text: &str) -> R<Option<usize>> {
    let mut depth = 1;
    ev.position(text.as_bytes(), |byte| {
        match byte {
            b'(' => depth += 1,
            b')' => depth -= 1,
            _ => {}
        }
        depth == 0
    })
}

/// What `%c` says of an argument of bytes.
const ONE_BYTE: &str = "%c requires an integer in range(256) or a single byte";

/// Whether an object has items by key; texts are taken as a whole, and where bytes are made so are bytes.
fn has_items(instance: &Instance, what: &str) -> bool {
    match instance.builtin_value() {
        Some(Value::Dict(_)) => true,
        Some(Value::Str(_)) => false,
        Some(Value::Bytes(_) | Value::ByteArray(_)) if what == "bytes" => false,
        // A deque gives items by number only.
        _ => match instance.class.lookup(known::GETITEM) {
            Some(Value::Builtin(builtin)) => builtin.owner != Some("deque"),
            found => found.is_some(),
        },
    }
}

/// Whether CPython takes an object of a class for a number, however it becomes one.
fn is_number(value: &Value) -> bool {
    let Value::Instance(instance) = value else {
        return false;
    };
    // A complex number is one, whatever becomes of it; to be turned into one is not enough.
    let has = |name| instance.class.lookup(name).is_some();
    matches!(instance.builtin_value(), Some(Value::Complex(_)))
        || [known::INT, known::INDEX, known::FLOAT]
            .into_iter()
            .any(has)
}
