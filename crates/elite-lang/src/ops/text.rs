//! `str`, `ascii` and `format` of values, and how strings and bytes are quoted.

use std::fmt::Write as _;
use std::sync::LazyLock;

use elite_syntax::ast::Conversion;
use elite_syntax::surrogate::code_of;

use crate::eval::Evaluator;
use crate::format::Spec;
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE, pieces};
use crate::value::symbol::known;
use crate::value::{Instance, R, Str, Unwind, Value};

/// The `__repr__` of a class that is its `__str__`, too, unless the builtin type it is derived from has a `__str__` of
/// its own.
fn shown_by_repr(instance: &Instance) -> Option<Value> {
    let is_text = instance.exception().is_some()
        || matches!(
            instance.builtin_value(),
            Some(Value::Str(_) | Value::Bytes(_) | Value::ByteArray(_))
        );
    match is_text {
        true => None,
        false => instance.class.lookup(known::REPR),
    }
}

/// Longest specification of a format, in bytes.
const SPEC_MAX: usize = 4096;

impl Evaluator<'_> {
    /// Python's `str(value)`.
    pub fn str(&self, value: &Value) -> R<String> {
        match value {
            Value::Str(text) => self.copy_text(text.as_str()),
            Value::Int(int) => {
                let mut text = String::with_capacity(20);
                push_int(*int, &mut text);
                Ok(text)
            }
            // The text of an exception is that of its argument, which may be an exception.
            Value::Instance(instance) => {
                self.with_native_depth(|| self.instance_str(value, instance))
            }
            Value::Class(class) if class.meta_method(known::STR).is_some() => {
                match self.special(value, known::STR, &mut [])? {
                    Some(text) => self.expect_text(&text, "__str__"),
                    None => self.repr(value),
                }
            }
            _ => self.repr(value),
        }
    }

    /// Like `str`, without copying strings: what `__str__` gives may be an instance of a class derived from `str`.
    pub fn str_value(&self, value: &Value) -> R {
        match value {
            Value::Str(_) => Ok(value.clone()),
            Value::Int(int @ 0..10) => Ok(self.core.ascii[b'0' as usize + *int as usize].clone()),
            Value::Instance(instance) => match instance.class.lookup(known::STR) {
                Some(method) => self.made_text(&method, value, "__str__"),
                None => match shown_by_repr(instance) {
                    Some(method) => self.made_text(&method, value, "__str__"),
                    None => self.new_str(self.str(value)?),
                },
            },
            other => self.new_str(self.str(other)?),
        }
    }

    /// The value of `repr(value)`, as `str_value`.
    pub fn repr_value(&self, value: &Value) -> R {
        if let Value::Instance(instance) = value
            && let Some(method) = instance.class.lookup(known::REPR)
        {
            return self.made_text(&method, value, "__repr__");
        }
        self.new_str(self.repr(value)?)
    }

    /// The text that a method makes of its receiver.
    fn made_text(&self, method: &Value, value: &Value, name: &str) -> R {
        let text = self.with_native_depth(|| self.call_method_value(method, value, &mut []))?;
        match self.unwrap_builtin(&text) {
            Value::Str(_) => Ok(text),
            _ => Err(self.no_text(&text, name)),
        }
    }

    #[cold]
    fn no_text(&self, value: &Value, method: &str) -> Unwind {
        let name = self.core.types.name_of(value);
        self.type_error(format!("{method} returned non-string (type {name})"))
    }

    fn instance_str(&self, value: &Value, instance: &Instance) -> R<String> {
        if let Some(method) = instance.class.lookup(known::STR) {
            let text = self.call_method_value(&method, value, &mut [])?;
            return self.expect_text(&text, "__str__");
        }
        if let Some(method) = shown_by_repr(instance) {
            let text = self.call_method_value(&method, value, &mut [])?;
            return self.expect_text(&text, "__str__");
        }
        self.natural_str(value)
    }

    /// The text of an object whose class defines none.
    pub fn natural_str(&self, value: &Value) -> R<String> {
        let Value::Instance(instance) = value else {
            return self.str(value);
        };
        if let Some(state) = instance.exception() {
            if let Some(group) = state.group.get() {
                return self.group_text(group);
            }
            return match state.plain_message() {
                Some(message) => Ok(message),
                None => self.exception_str(instance, &state.args()),
            };
        }
        match instance.builtin_value() {
            Some(Value::Set(_) | Value::FrozenSet(_) | Value::ByteArray(_)) => {
                self.natural_repr(value)
            }
            Some(extended) => self.str(&extended),
            None => self.repr(value),
        }
    }

    fn exception_str(&self, instance: &Instance, args: &Value) -> R<String> {
        use crate::errors::ExceptionKind;
        let Value::Tuple(tuple) = args else {
            return Ok(String::new());
        };
        let is = |kind| {
            instance
                .class
                .is_subclass_of(self.core.types.exception(kind))
        };
        match tuple.items() {
            [] => Ok(String::new()),
            [encoding, object, Value::Int(start), Value::Int(end), reason]
                if is(ExceptionKind::UnicodeDecodeError)
                    || is(ExceptionKind::UnicodeEncodeError) =>
            {
                self.unicode_error_text(encoding, object, (*start, *end), reason)
            }
            [Value::Str(text), Value::Int(start), Value::Int(end), reason]
                if is(ExceptionKind::UnicodeTranslateError) =>
            {
                self.translate_error_text(text, (*start, *end), reason)
            }
            [message, Value::Tuple(place)]
                if is(ExceptionKind::SyntaxError) && place.items().len() >= 4 =>
            {
                let message = self.str(message)?;
                let place = place.items();
                Ok(match (&place[0], &place[1]) {
                    (Value::Str(file), Value::Int(line)) => {
                        let name = file.as_str().rsplit('/').next().unwrap_or_default();
                        format!("{message} ({name}, line {line})")
                    }
                    (Value::Str(file), _) => format!("{message} ({})", file.as_str()),
                    (_, Value::Int(line)) => format!("{message} (line {line})"),
                    _ => message,
                })
            }
            // The key is shown as it would be written.
            [key] if is(ExceptionKind::KeyError) => self.repr(key),
            [single] => self.str(single),
            [number, text] if is(ExceptionKind::OSError) => {
                let mut out = format!("[Errno {}] {}", self.str(number)?, self.str(text)?);
                for (attribute, before) in [("filename", ": "), ("filename2", " -> ")] {
                    let name = self.core.symbols.intern(attribute);
                    match instance.get(name, &self.core.symbols) {
                        Some(Value::None) | None => break,
                        Some(name) => {
                            out.push_str(before);
                            out.push_str(&self.repr(&name)?);
                        }
                    }
                }
                Ok(out)
            }
            _ => self.repr(args),
        }
    }

    /// How errors of `str.translate` read.
    fn translate_error_text(
        &self,
        text: &Str,
        (start, end): (i64, i64),
        reason: &Value,
    ) -> R<String> {
        let reason = self.str(reason)?;
        let at = usize::try_from(start).ok();
        Ok(match at.and_then(|at| text.char_at(at)) {
            Some(c) if end == start + 1 => {
                let shown = escape_char(code_of(c));
                format!("can't translate character '{shown}' in position {start}: {reason}")
            }
            _ => format!(
                "can't translate characters in position {start}-{}: {reason}",
                end - 1
            ),
        })
    }

    /// How errors of codecs read: the byte or character if it is one, else where they are.
    fn unicode_error_text(
        &self,
        encoding: &Value,
        object: &Value,
        (start, end): (i64, i64),
        reason: &Value,
    ) -> R<String> {
        let (encoding, reason) = (self.str(encoding)?, self.str(reason)?);
        let at = usize::try_from(start).unwrap_or(0);
        let (verb, many, single) = match object {
            Value::Str(text) => {
                let c = text.char_at(at);
                let shown = c.map(|c| format!("character '{}'", escape_char(code_of(c))));
                ("encode", "characters", shown)
            }
            other => {
                let data = self.bytes_like(other).unwrap_or_default();
                let shown = data.get(at).map(|byte| format!("byte {byte:#04x}"));
                ("decode", "bytes", shown)
            }
        };
        Ok(match single {
            Some(shown) if end == start + 1 => {
                format!("'{encoding}' codec can't {verb} {shown} in position {start}: {reason}")
            }
            _ => format!(
                "'{encoding}' codec can't {verb} {many} in position {start}-{}: {reason}",
                end - 1
            ),
        })
    }

    pub(super) fn expect_text(&self, value: &Value, method: &str) -> R<String> {
        match self.unwrap_builtin(value) {
            Value::Str(text) => self.copy_text(text.as_str()),
            _ => Err(self.no_text(value, method)),
        }
    }

    /// An integer of any size in decimal; refused beyond the limit on digits, as in CPython.
    pub fn big_to_text(&self, big: &num_bigint::BigInt) -> R<String> {
        let limit = self.core.limits.int_digits;
        let certainly_too_long = big.bits() as f64 * std::f64::consts::LOG10_2 > limit as f64 + 1.0;
        let text = if certainly_too_long {
            String::new()
        } else {
            big.to_string()
        };
        if certainly_too_long || text.trim_start_matches('-').len() > limit {
            return Err(self.value_error(format!(
                "Exceeds the limit ({limit} digits) for integer string conversion; \
                 use sys.set_int_max_str_digits() to increase the limit"
            )));
        }
        Ok(text)
    }

    /// The value of `ascii(value)`, as `repr_value`.
    pub fn ascii_value(&self, value: &Value) -> R {
        let shown = self.repr_value(value)?;
        match self.unwrap_builtin(&shown) {
            Value::Str(text) if !text.as_str().is_ascii() => {
                self.new_str(self.escaped_beyond_ascii(text.as_str())?)
            }
            _ => Ok(shown),
        }
    }

    /// Python's `ascii(value)`.
    pub fn ascii(&self, value: &Value) -> R<String> {
        let text = self.repr(value)?;
        self.escaped_beyond_ascii(&text)
    }

    /// A text whose characters beyond ASCII are escaped.
    pub fn escaped_beyond_ascii(&self, text: &str) -> R<String> {
        let mut out = String::with_capacity(text.len());
        for c in text.chars() {
            match code_of(c) {
                0..128 => out.push(c),
                code @ ..0x100 => {
                    let _ = write!(out, "\\x{code:02x}");
                }
                code @ ..0x1_0000 => {
                    let _ = write!(out, "\\u{code:04x}");
                }
                code => {
                    let _ = write!(out, "\\U{code:08x}");
                }
            }
        }
        Ok(out)
    }

    /// The value of a replacement field before it is formatted.
    pub fn convert(&self, value: Value, conversion: Conversion) -> R {
        match conversion {
            Conversion::None => Ok(value),
            Conversion::Str => self.str_value(&value),
            Conversion::Repr => self.repr_value(&value),
            Conversion::Ascii => self.ascii_value(&value),
        }
    }

    /// Python's `format(value, spec)`: the text a method made, and one that stays as it is, may be of a class derived
    /// from `str`.
    pub fn format_value(&self, value: &Value, spec: &str) -> R {
        let Value::Instance(instance) = value else {
            if spec.is_empty() && matches!(value, Value::Str(_)) {
                return Ok(value.clone());
            }
            let mut out = String::with_capacity(16);
            self.format_into(value, spec, &mut out)?;
            return self.new_str(out);
        };
        match instance.class.lookup(known::FORMAT) {
            // The text is made by the builtin type that the class is derived from.
            Some(Value::Builtin(_)) if instance.builtin_value().is_some() && spec.is_empty() => {
                return self.str_value(value);
            }
            Some(Value::Builtin(_)) if instance.builtin_value().is_some() => {}
            Some(method) => return self.call_format_method(&method, value, spec),
            None if spec.is_empty() => return self.str_value(value),
            None => {}
        }
        let mut out = String::new();
        self.format_into(value, spec, &mut out)?;
        match instance.builtin_value() {
            Some(Value::Str(text)) if !spec.is_empty() && text.as_str() == out => Ok(value.clone()),
            _ => self.new_str(out),
        }
    }

    /// What the `__format__` of a class makes of a value.
    fn call_format_method(&self, method: &Value, value: &Value, spec: &str) -> R {
        let text = self.call_method_value(method, value, &mut [self.new_str_from(spec)?])?;
        if let Value::Str(_) = self.unwrap_builtin(&text) {
            return Ok(text);
        }
        let name = self.core.types.name_of(&text);
        Err(self.type_error(format!("__format__ must return a str, not {name}")))
    }

    /// Python's `format(value, spec)`, appended to `out`.
    pub fn format_into(&self, value: &Value, spec: &str, out: &mut String) -> R<()> {
        if let Value::Instance(instance) = value {
            if let Some(method) = instance.class.lookup(known::FORMAT)
                && !(spec.is_empty() && matches!(method, Value::Builtin(_)))
            {
                let text = self.unwrap_builtin(&self.call_format_method(&method, value, spec)?);
                return match &text {
                    Value::Str(text) => self.push_text(out, text.as_str()),
                    _ => Ok(()),
                };
            }
            if let (Some(extended), false) = (instance.builtin_value(), spec.is_empty()) {
                let name = self.core.types.name_of(value);
                return self.format_by_spec(&extended, spec, &name, out);
            }
        }
        if spec.is_empty() {
            match value {
                Value::Str(text) => self.push_text(out, text.as_str())?,
                Value::Int(int) => push_int(*int, out),
                Value::Float(float) => crate::format::float::push_repr(*float, out),
                other => self.push_text(out, &self.str(other)?)?,
            }
            return self.check_allocation(out.len());
        }
        let name = self.core.types.name_of(value);
        self.format_by_spec(value, spec, &name, out)
    }

    /// A builtin value by a specification that says something; `name` is its type's in messages.
    pub fn format_by_spec(&self, value: &Value, spec: &str, name: &str, out: &mut String) -> R<()> {
        if spec.len() > SPEC_MAX {
            return Err(self.value_error(format!(
                "a format specification of {} bytes, {SPEC_MAX} are allowed",
                spec.len()
            )));
        }
        let error = |message: String| self.value_error(message);
        match value {
            Value::Int(_)
            | Value::BigInt(_)
            | Value::Bool(_)
            | Value::Float(_)
            | Value::Complex(_)
            | Value::Str(_) => {
                let is_text = matches!(value, Value::Str(_));
                let spec = Spec::parse(spec, name, is_text).map_err(error)?;
                let precision = spec.precision.unwrap_or(0);
                self.check_allocation(spec.width.max(precision))?;
                crate::format::value(value, &spec, name, self, out)
            }
            _ => Err(self.type_error(format!(
                "unsupported format string passed to {name}.__format__"
            ))),
        }
    }
}

impl Evaluator<'_> {
    /// Appends a string as Python writes it.
    pub fn quote(&self, text: &str, out: &mut String) -> R<()> {
        if text.len() <= CHUNK {
            quote(text, out);
            return Ok(());
        }
        let mark = self.quotation_mark(text.as_bytes())?;
        out.push(mark);
        for piece in pieces(text) {
            self.grow(out, piece.len())?;
            escape(piece, mark, out);
            self.charge(2 * piece.len() * WORK_PER_BYTE)?;
        }
        out.push(mark);
        Ok(())
    }

    /// Appends bytes as Python writes them.
    pub fn quote_bytes(&self, data: &[u8], out: &mut String) -> R<()> {
        let mark = self.quotation_mark(data)?;
        self.quote_marked(data, mark, mark, out)
    }

    /// The content of a bytearray as Python writes it: single marks are escaped between double ones, too.
    pub fn quote_bytearray(&self, data: &[u8], out: &mut String) -> R<()> {
        let mark = self.quotation_mark(data)?;
        self.quote_marked(data, mark, '\'', out)
    }

    fn quote_marked(&self, data: &[u8], mark: char, escaped: char, out: &mut String) -> R<()> {
        out.push('b');
        out.push(mark);
        for piece in data.chunks(CHUNK) {
            self.grow(out, piece.len())?;
            escape_bytes(piece, escaped, out);
            self.charge(2 * piece.len() * WORK_PER_BYTE)?;
        }
        out.push(mark);
        Ok(())
    }

    fn quotation_mark(&self, data: &[u8]) -> R<char> {
        let single = self.find_bytes(data, b"'")?.is_some();
        let double = single && self.find_bytes(data, b"\"")?.is_some();
        Ok(if single && !double { '"' } else { '\'' })
    }
}

/// Appends a short string as Python writes it: with quotes and escapes.
pub fn quote(text: &str, out: &mut String) {
    let quote = if text.contains('\'') && !text.contains('"') {
        '"'
    } else {
        '\''
    };
    out.push(quote);
    escape(text, quote, out);
    out.push(quote);
}

fn escape(text: &str, quote: char, out: &mut String) {
    for c in text.chars() {
        match c {
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            _ if c == quote => {
                out.push('\\');
                out.push(c);
            }
            ' '..='~' => out.push(c),
            _ if is_printable(c) => out.push(c),
            _ => {
                let code = code_of(c);
                let _ = match code {
                    0..0x100 => write!(out, "\\x{code:02x}"),
                    0x100..0x1_0000 => write!(out, "\\u{code:04x}"),
                    _ => write!(out, "\\U{code:08x}"),
                };
            }
        }
    }
}

/// Python's `str.isprintable` of one character: no controls, no separators other than the blank, nothing private or
/// unassigned.
pub fn is_printable(c: char) -> bool {
    match c {
        ' '..='~' => true,
        '\0'..='\u{a0}' => false,
        // Most texts beyond ASCII are of these.
        '\u{4e00}'..='\u{9fff}' => true,
        _ => {
            let code = c as u32;
            let after = HIDDEN.partition_point(|(first, _)| *first <= code);
            HIDDEN[..after].last().is_none_or(|(_, last)| code > *last)
        }
    }
}

/// Ranges of characters that are not printable, in order, from CPython 3.11 (`str.isprintable`): first and last code
/// point, a line each.
static HIDDEN: LazyLock<Vec<(u32, u32)>> = LazyLock::new(|| {
    let number = |text: &str| u32::from_str_radix(text, 16).ok();
    let range = |line: &str| {
        let (first, last) = line.split_once(' ')?;
        Some((number(first)?, number(last)?))
    };
    let lines = include_str!("hidden_characters.txt").lines();
    lines.filter_map(range).collect()
});

fn escape_bytes(data: &[u8], quote: char, out: &mut String) {
    for byte in data {
        match byte {
            b'\\' => out.push_str("\\\\"),
            b'\n' => out.push_str("\\n"),
            b'\r' => out.push_str("\\r"),
            b'\t' => out.push_str("\\t"),
            _ if char::from(*byte) == quote => {
                out.push('\\');
                out.push(quote);
            }
            b' '..=b'~' => out.push(char::from(*byte)),
            _ => {
                let _ = write!(out, "\\x{byte:02x}");
            }
        }
    }
}

/// Appends an integer in decimal.
fn push_int(int: i64, out: &mut String) {
    if int < 0 {
        out.push('-');
    }
    crate::format::push_digits(int.unsigned_abs(), 1, out);
}

/// A character as an escape in messages of codecs.
fn escape_char(code: u32) -> String {
    match code {
        0..0x100 => format!("\\x{code:02x}"),
        0x100..0x1_0000 => format!("\\u{code:04x}"),
        _ => format!("\\U{code:08x}"),
    }
}
