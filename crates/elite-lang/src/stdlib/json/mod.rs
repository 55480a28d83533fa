//! `_json`: reading JSON text, and writing it (`write`).
//!
//! Written here rather than on serde_json because Python's module differs from the standard where programs notice:
//! `NaN` and `Infinity`, integers of any size, Python's float texts, and errors that give line, column and position.

mod write;

use std::rc::Rc;

use elite_syntax::surrogate::char_of;

use super::define::ModuleBuilder;
use crate::eval::Evaluator;
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::{Dict, R, Unwind, Value, ValueVec};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("_read", "text options end? /", read),
        ("_write", "value options /", write::write),
    ]);
    Ok(())
}

/// `options` is a tuple: object_hook, parse_float, parse_int, object_pairs_hook, strict, parse_constant, error class.
fn read(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let Value::Str(text) = ev.unwrap_builtin(&args[0]) else {
        return Err(ev.type_error("the JSON object must be str"));
    };
    let options = ev.collect(&args[1])?;
    let option = |index: usize| options.get(index).cloned().unwrap_or(Value::None);
    let mut reader = JsonDecoder {
        ev,
        text: text.as_str(),
        bytes: text.as_str().as_bytes(),
        at: 0,
        object_hook: option(0),
        parse_float: option(1),
        parse_int: option(2),
        pairs_hook: option(3),
        strict: ev.truth(&option(4))?,
        parse_constant: option(5),
        error: option(6),
    };
    if args[2].if_given().is_some() {
        // Only one value, from a position on (`raw_decode`).
        let start = ev.clamped_index(&args[2])?.max(0) as usize;
        ev.index_chars(&text)?;
        reader.at = text.byte_offset(start.min(text.len()));
        let value = reader.value()?;
        let end = text.char_index(reader.at);
        return Ok(Value::tuple(vec![value, Value::Int(end as i64)]));
    }
    reader.blanks()?;
    let value = reader.value()?;
    reader.blanks()?;
    if reader.at < reader.bytes.len() {
        return Err(reader.fail("Extra data", reader.at));
    }
    Ok(value)
}

struct JsonDecoder<'r, 'y> {
    ev: &'r Evaluator<'y>,
    text: &'r str,
    bytes: &'r [u8],
    at: usize,
    object_hook: Value,
    parse_float: Value,
    parse_int: Value,
    pairs_hook: Value,
    strict: bool,
    parse_constant: Value,
    error: Value,
}

impl JsonDecoder<'_, '_> {
    /// A `JSONDecodeError`; the script's class makes the message.
    #[cold]
    fn fail(&self, message: &str, at: usize) -> Unwind {
        let at = at.min(self.text.len());
        let position = match self.ev.count_chars(&self.text[..at]) {
            Ok(position) => Value::Int(position as i64),
            Err(raised) => return raised,
        };
        let text = match self.ev.new_str_from(self.text) {
            Ok(text) => text,
            Err(raised) => return raised,
        };
        let mut args = [Value::str(message), text, position];
        match self.ev.call(&self.error, &mut args, &[]) {
            Ok(Value::Instance(exception)) => Unwind::Exception(exception),
            Ok(_) => self.ev.value_error(message),
            Err(raised) => raised,
        }
    }

    fn blanks(&mut self) -> R<()> {
        let from = self.at;
        while let Some(b' ' | b'\t' | b'\n' | b'\r') = self.bytes.get(self.at) {
            self.at += 1;
            if (self.at - from).is_multiple_of(CHUNK) {
                self.ev.charge(CHUNK * WORK_PER_BYTE)?;
            }
        }
        Ok(())
    }

    fn value(&mut self) -> R {
        let start = self.at;
        match self.bytes.get(self.at) {
            Some(b'"') => {
                self.at += 1;
                let text = self.string()?;
                self.ev.new_str(text)
            }
            Some(b'{' | b'[') => {
                let ev = self.ev;
                let is_object = self.bytes[self.at] == b'{';
                self.at += 1;
                ev.with_native_depth(|| {
                    if is_object {
                        self.object()
                    } else {
                        self.array()
                    }
                })
            }
            Some(b'-' | b'0'..=b'9') => self.number(),
            _ => match self.word() {
                Some(value) => Ok(value),
                None => Err(self.fail("Expecting value", start)),
            },
        }
        .and_then(|value| self.constant(start, value))
    }

    /// A word at the present position.
    fn word(&mut self) -> Option<Value> {
        let words = [
            ("null", Value::None),
            ("true", Value::Bool(true)),
            ("false", Value::Bool(false)),
            ("NaN", Value::Float(f64::NAN)),
            ("Infinity", Value::Float(f64::INFINITY)),
        ];
        let rest = &self.text[self.at..];
        let (word, value) = words.into_iter().find(|(word, _)| rest.starts_with(word))?;
        self.at += word.len();
        Some(value)
    }

    /// Lets `parse_constant` replace what JSON does not know.
    fn constant(&self, start: usize, value: Value) -> R {
        if self.parse_constant.is_none() {
            return Ok(value);
        }
        match &self.text[start..self.at] {
            word @ ("NaN" | "Infinity" | "-Infinity") => {
                self.ev.call1(&self.parse_constant, Value::str(word))
            }
            _ => Ok(value),
        }
    }

    fn number(&mut self) -> R {
        let start = self.at;
        if self.text[start..].starts_with("-Infinity") {
            self.at += "-Infinity".len();
            return Ok(Value::Float(f64::NEG_INFINITY));
        }
        let digits = |reader: &mut Self| {
            let from = reader.at;
            while reader.bytes.get(reader.at).is_some_and(u8::is_ascii_digit) {
                reader.at += 1;
            }
            reader.at > from
        };
        if self.bytes[self.at] == b'-' {
            self.at += 1;
        }
        match self.bytes.get(self.at) {
            Some(b'0') => self.at += 1,
            Some(b'1'..=b'9') => {
                digits(self);
            }
            _ => {
                self.at = start;
                return Err(self.fail("Expecting value", start));
            }
        }
        let mut is_float = false;
        let whole = self.at;
        if self.bytes.get(self.at) == Some(&b'.') {
            self.at += 1;
            if digits(self) {
                is_float = true;
            } else {
                self.at = whole;
            }
        }
        let mantissa = self.at;
        if let (Some(b'e' | b'E'), true) = (self.bytes.get(self.at), is_float || self.at == whole) {
            self.at += 1;
            if let Some(b'+' | b'-') = self.bytes.get(self.at) {
                self.at += 1;
            }
            if digits(self) {
                is_float = true;
            } else {
                self.at = mantissa;
            }
        }
        let text = &self.text[start..self.at];
        let hook = if is_float {
            &self.parse_float
        } else {
            &self.parse_int
        };
        if !hook.is_none() {
            return self.ev.call1(hook, Value::str(text));
        }
        if is_float {
            // The text follows the grammar of floats.
            return Ok(Value::Float(text.parse().unwrap_or(f64::NAN)));
        }
        match text.parse() {
            Ok(small) => Ok(Value::Int(small)),
            Err(_) => self.ev.call1(
                &Value::Class(self.ev.core.types.int.clone()),
                Value::str(text),
            ),
        }
    }

    /// Reads a string behind its opening quote, to the closing one.
    fn string(&mut self) -> R<String> {
        let begin = self.at - 1;
        let mut out = String::new();
        loop {
            let from = self.at;
            let end = self
                .text
                .ceil_char_boundary((from + CHUNK).min(self.text.len()));
            while let Some(byte) = self.bytes[..end].get(self.at)
                && !matches!(byte, b'"' | b'\\')
                && (*byte >= 0x20 || !self.strict)
            {
                self.at += 1;
            }
            self.ev.grow(&mut out, self.at - from)?;
            out.push_str(&self.text[from..self.at]);
            self.ev.charge((self.at - from) * 2 + WORK_PER_BYTE)?;
            if self.at == end && end < self.text.len() {
                continue;
            }
            match self.bytes.get(self.at) {
                None => return Err(self.fail("Unterminated string starting at", begin)),
                Some(b'"') => {
                    self.at += 1;
                    return Ok(out);
                }
                Some(b'\\') => self.escape(begin, &mut out)?,
                Some(_) => return Err(self.fail("Invalid control character at", self.at)),
            }
        }
    }

    fn escape(&mut self, begin: usize, out: &mut String) -> R<()> {
        let escaped = self.bytes.get(self.at + 1);
        let c = match escaped {
            None => return Err(self.fail("Unterminated string starting at", begin)),
            Some(b'u') => {
                self.at += 2;
                let mut code = self.hex()?;
                if (0xd800..0xdc00).contains(&code) && self.text[self.at..].starts_with("\\u") {
                    let back = self.at;
                    self.at += 2;
                    let low = self.hex()?;
                    if (0xdc00..0xe000).contains(&low) {
                        code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
                    } else {
                        self.at = back;
                    }
                }
                out.push(char_of(code).unwrap_or(char::REPLACEMENT_CHARACTER));
                return Ok(());
            }
            Some(b'"') => '"',
            Some(b'\\') => '\\',
            Some(b'/') => '/',
            Some(b'b') => '\u{8}',
            Some(b'f') => '\u{c}',
            Some(b'n') => '\n',
            Some(b'r') => '\r',
            Some(b't') => '\t',
            Some(_) => return Err(self.fail("Invalid \\escape", self.at)),
        };
        out.push(c);
        self.at += 2;
        Ok(())
    }

    fn hex(&mut self) -> R<u32> {
        let digits = self.bytes.get(self.at..self.at + 4);
        let digits = digits.filter(|digits| digits.iter().all(u8::is_ascii_hexdigit));
        let text = digits.and_then(|digits| std::str::from_utf8(digits).ok());
        match text.and_then(|text| u32::from_str_radix(text, 16).ok()) {
            Some(code) => {
                self.at += 4;
                Ok(code)
            }
            None => Err(self.fail("Invalid \\uXXXX escape", self.at - 1)),
        }
    }

    fn array(&mut self) -> R {
        let mut items = Vec::new();
        self.blanks()?;
        if self.bytes.get(self.at) == Some(&b']') {
            self.at += 1;
            return Ok(Value::list(items));
        }
        loop {
            let item = self.value()?;
            self.ev.grow(&mut items, 1)?;
            items.push(item);
            self.ev.safepoint()?;
            self.blanks()?;
            match self.bytes.get(self.at) {
                Some(b']') => {
                    self.at += 1;
                    return Ok(Value::list(items));
                }
                Some(b',') => self.at += 1,
                _ => return Err(self.fail("Expecting ',' delimiter", self.at)),
            }
            self.blanks()?;
        }
    }

    fn object(&mut self) -> R {
        let mut pairs = ValueVec::default();
        self.blanks()?;
        if self.bytes.get(self.at) == Some(&b'}') {
            self.at += 1;
            return self.finish_object(pairs);
        }
        loop {
            if self.bytes.get(self.at) != Some(&b'"') {
                let message = "Expecting property name enclosed in double quotes";
                return Err(self.fail(message, self.at));
            }
            self.at += 1;
            let key = self.string()?;
            self.blanks()?;
            if self.bytes.get(self.at) != Some(&b':') {
                return Err(self.fail("Expecting ':' delimiter", self.at));
            }
            self.at += 1;
            self.blanks()?;
            let pair = (Value::str(key), self.value()?);
            self.ev.grow(&mut *pairs, 1)?;
            pairs.push(pair);
            self.ev.safepoint()?;
            self.blanks()?;
            match self.bytes.get(self.at) {
                Some(b'}') => {
                    self.at += 1;
                    return self.finish_object(pairs);
                }
                Some(b',') => self.at += 1,
                _ => return Err(self.fail("Expecting ',' delimiter", self.at)),
            }
            self.blanks()?;
        }
    }

    fn finish_object(&self, pairs: ValueVec<(Value, Value)>) -> R {
        if !self.pairs_hook.is_none() {
            let mut tuples = ValueVec::from(self.ev.try_with_capacity(pairs.len())?);
            for (key, value) in pairs {
                tuples.push(Value::pair(key, value));
                self.ev.charge(4 * WORK_PER_VALUE)?;
            }
            return self.ev.call1(&self.pairs_hook, tuples.into_list());
        }
        let dict = Dict::new();
        for (key, value) in pairs {
            self.ev.charge(2 * WORK_PER_VALUE)?;
            self.ev.dict_set(&dict, key, value)?;
        }
        let dict = Value::Dict(Rc::new(dict));
        if self.object_hook.is_none() {
            Ok(dict)
        } else {
            self.ev.call1(&self.object_hook, dict)
        }
    }
}
