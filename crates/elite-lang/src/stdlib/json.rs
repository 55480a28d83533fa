//! `_json`: reading and writing JSON text.
//!
//! Written here rather than on serde_json because Python's module differs from the standard where programs notice: `NaN`
//! and `Infinity`, integers of any size, Python's float texts, and errors that give line, column and position.

use std::rc::Rc;

use super::define::Builder;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::bulk::{EACH, PIECE, pieces};
use crate::eval::pace::VALUE;
use crate::format::float;
use crate::value::int::Int;
use crate::value::surrogate::{char_of, code_of, is_surrogate};
use crate::value::{Dict, R, Raised, Value, Values};

pub(super) fn fill(module: &Builder<'_, '_>) -> R<()> {
    module.functions(&[
        ("_read", "text options end? /", read),
        ("_write", "value options /", write),
    ]);
    Ok(())
}

/// `options` is a tuple: object_hook, parse_float, parse_int, object_pairs_hook, strict, parse_constant, error class.
fn read(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let Value::Str(text) = ev.plain(&args[0]) else {
        return Err(ev.type_error("the JSON object must be str"));
    };
    let options = ev.collect(&args[1])?;
    let option = |index: usize| options.get(index).cloned().unwrap_or(Value::None);
    let mut reader = Reader {
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
    if args[2].given().is_some() {
        // Only one value, from a position on (`raw_decode`).
        let start = ev.clamped_index(&args[2])?.max(0) as usize;
        ev.mark(&text)?;
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

struct Reader<'r, 'y> {
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

impl Reader<'_, '_> {
    /// A `JSONDecodeError`; the script's class makes the message.
    #[cold]
    fn fail(&self, message: &str, at: usize) -> Raised {
        let at = at.min(self.text.len());
        let position = match self.ev.count_chars(&self.text[..at]) {
            Ok(position) => Value::Int(position as i64),
            Err(raised) => return raised,
        };
        let text = match self.ev.string_of(self.text) {
            Ok(text) => text,
            Err(raised) => return raised,
        };
        let mut args = [Value::str(message), text, position];
        match self.ev.call(&self.error, &mut args, &[]) {
            Ok(Value::Instance(exception)) => Raised::Exception(exception),
            Ok(_) => self.ev.value_error(message),
            Err(raised) => raised,
        }
    }

    fn blanks(&mut self) -> R<()> {
        let from = self.at;
        while let Some(b' ' | b'\t' | b'\n' | b'\r') = self.bytes.get(self.at) {
            self.at += 1;
            if (self.at - from).is_multiple_of(PIECE) {
                self.ev.worked(PIECE * EACH)?;
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
                self.ev.string(text)
            }
            Some(b'{' | b'[') => {
                let ev = self.ev;
                let is_object = self.bytes[self.at] == b'{';
                self.at += 1;
                ev.recurse(|| {
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

    /// The rest of a string whose opening quote has been read.
    fn string(&mut self) -> R<String> {
        let begin = self.at - 1;
        let mut out = String::new();
        loop {
            let from = self.at;
            let end = self
                .text
                .ceil_char_boundary((from + PIECE).min(self.text.len()));
            while let Some(byte) = self.bytes[..end].get(self.at)
                && !matches!(byte, b'"' | b'\\')
                && (*byte >= 0x20 || !self.strict)
            {
                self.at += 1;
            }
            self.ev.grow(&mut out, self.at - from)?;
            out.push_str(&self.text[from..self.at]);
            self.ev.worked((self.at - from) * 2 + EACH)?;
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
        let mut pairs = Values::default();
        self.blanks()?;
        if self.bytes.get(self.at) == Some(&b'}') {
            self.at += 1;
            return self.made(pairs);
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
                    return self.made(pairs);
                }
                Some(b',') => self.at += 1,
                _ => return Err(self.fail("Expecting ',' delimiter", self.at)),
            }
            self.blanks()?;
        }
    }

    fn made(&self, pairs: Values<(Value, Value)>) -> R {
        if !self.pairs_hook.is_none() {
            let mut tuples = Values::from(self.ev.room_for(pairs.len())?);
            for (key, value) in pairs {
                tuples.push(Value::pair(key, value));
                self.ev.worked(4 * VALUE)?;
            }
            return self.ev.call1(&self.pairs_hook, tuples.into_list());
        }
        let dict = Dict::new();
        for (key, value) in pairs {
            self.ev.worked(2 * VALUE)?;
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

/// `options` is a tuple: skipkeys, ensure_ascii, check_circular, allow_nan, indent, separators, default, sort_keys, and whether
/// CPython would go through what is to be written by its encoder in Python, as it does with an indentation.
fn write(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let options = ev.collect(&args[1])?;
    let option = |index: usize| options.get(index).cloned().unwrap_or(Value::None);
    let indent = match option(4) {
        Value::None => None,
        Value::Str(text) => Some(ev.copied_text(text.as_str())?),
        count => {
            let count = ev.index(&count)?.clamp(0, 1000) as usize;
            Some(" ".repeat(count))
        }
    };
    let separators = match option(5) {
        Value::None => None,
        given => Some(ev.collect(&given)?),
    };
    let separator =
        |index: usize, default: &str| match separators.as_ref().and_then(|s| s.get(index)) {
            Some(Value::Str(text)) => ev.copied_text(text.as_str()),
            _ => Ok(default.to_owned()),
        };
    let item = separator(0, if indent.is_some() { "," } else { ", " })?;
    let asks = indent.is_some() || ev.truth(&option(8))?;
    let mut writer = Writer {
        ev,
        out: String::new(),
        skip_keys: ev.truth(&option(0))?,
        ascii: ev.truth(&option(1))?,
        check_circular: ev.truth(&option(2))?,
        allow_nan: ev.truth(&option(3))?,
        indent,
        item,
        key: separator(1, ": ")?,
        default: option(6),
        sort_keys: ev.truth(&option(7))?,
        asks,
        open: Vec::new(),
    };
    writer.value(&args[0])?;
    ev.string(writer.out)
}

struct Writer<'w, 'y> {
    ev: &'w Evaluator<'y>,
    out: String,
    skip_keys: bool,
    ascii: bool,
    check_circular: bool,
    allow_nan: bool,
    indent: Option<String>,
    item: String,
    key: String,
    default: Value,
    sort_keys: bool,
    /// Containers of derived classes are asked whether they are empty.
    asks: bool,
    /// The containers around, outermost first.
    open: Vec<usize>,
}

impl Writer<'_, '_> {
    fn value(&mut self, value: &Value) -> R<()> {
        let plain = self.ev.plain(value);
        match &plain {
            Value::None => self.out.push_str("null"),
            Value::Bool(true) => self.out.push_str("true"),
            Value::Bool(false) => self.out.push_str("false"),
            Value::Str(text) => self.string(text.as_str())?,
            Value::Int(_) | Value::BigInt(_) => {
                let text = self.ev.natural_repr(&plain)?;
                self.out.push_str(&text);
            }
            Value::Float(float) => {
                let text = self.float(*float)?;
                self.out.push_str(&text);
            }
            // CPython copies what a subclass gives before it writes it.
            Value::List(_) | Value::Tuple(_) if matches!(value, Value::Instance(_)) => {
                if self.asks && !self.ev.truth(value)? {
                    self.out.push_str("[]");
                    return Ok(());
                }
                let iterator = match self.ev.iter(value) {
                    Err(raised) if !self.asks && self.is_type_error(&raised) => {
                        let text = "_iterencode_list needs a sequence";
                        return Err(self.ev.type_error(text));
                    }
                    iterator => iterator?,
                };
                let items = self.ev.drain(&iterator)?;
                self.within(&plain, |writer| {
                    writer.array(|index| items.get(index).cloned())
                })?;
            }
            Value::List(list) => {
                self.within(&plain, |writer| writer.array(|index| list.get(index)))?;
            }
            Value::Tuple(tuple) => {
                let item = |index: usize| tuple.items().get(index).cloned();
                self.within(&plain, |writer| writer.array(item))?;
            }
            Value::Dict(_) if self.asks && !self.ev.truth(value)? => self.out.push_str("{}"),
            Value::Dict(dict) if !self.asks && dict.is_empty() => self.out.push_str("{}"),
            Value::Dict(_) if matches!(value, Value::Instance(_)) => {
                self.within(&plain, |writer| {
                    let items = writer.given_items(value)?;
                    writer.object(items)
                })?;
            }
            Value::Dict(dict) => {
                let entries = self.ev.entries(dict)?;
                self.within(&plain, |writer| {
                    let mut pairs = Values::from(writer.ev.room_for(entries.len())?);
                    for (_, key, value) in entries {
                        pairs.push(Value::pair(key, value));
                        writer.ev.worked(4 * VALUE)?;
                    }
                    writer.object(pairs)
                })?;
            }
            _ if self.default.is_none() => {
                let name = self.ev.core.types.of(value).name();
                let text = format!("Object of type {name} is not JSON serializable");
                return Err(self.ev.type_error(text));
            }
            _ => {
                let default = self.default.clone();
                self.within(value, |writer| {
                    let replacement = writer.ev.call1(&default, value.clone())?;
                    writer.value(&replacement)
                })?;
            }
        }
        self.ev.check_allocation(self.out.len())
    }

    /// Goes one level deeper, into `container`.
    fn within(&mut self, container: &Value, inner: impl FnOnce(&mut Self) -> R<()>) -> R<()> {
        let address = container.address().unwrap_or(0);
        if self.check_circular && self.open.contains(&address) {
            return Err(self.ev.value_error("Circular reference detected"));
        }
        self.open.push(address);
        let ev = self.ev;
        let result = ev.recurse(|| inner(self));
        self.open.pop();
        result
    }

    fn float(&self, value: f64) -> R<String> {
        if value.is_finite() {
            return Ok(float::repr(value));
        }
        if !self.allow_nan {
            let text = format!(
                "Out of range float values are not JSON compliant: {}",
                float::repr(value)
            );
            // CPython 3.11 names no value.
            let text = text.split(": ").next().unwrap_or("").to_owned();
            return Err(self.ev.value_error(text));
        }
        Ok(match value {
            value if value.is_nan() => "NaN",
            value if value > 0.0 => "Infinity",
            _ => "-Infinity",
        }
        .to_owned())
    }

    fn string(&mut self, text: &str) -> R<()> {
        self.out.push('"');
        for piece in pieces(text) {
            self.ev.grow(&mut self.out, piece.len())?;
            self.escaped(piece);
            self.ev.worked(piece.len() * EACH)?;
        }
        self.out.push('"');
        Ok(())
    }

    fn escaped(&mut self, text: &str) {
        for c in text.chars() {
            match c {
                '"' => self.out.push_str("\\\""),
                '\\' => self.out.push_str("\\\\"),
                '\n' => self.out.push_str("\\n"),
                '\r' => self.out.push_str("\\r"),
                '\t' => self.out.push_str("\\t"),
                '\u{8}' => self.out.push_str("\\b"),
                '\u{c}' => self.out.push_str("\\f"),
                c if (c as u32) < 0x20 || (self.ascii && !(' '..='~').contains(&c)) => {
                    if is_surrogate(c) {
                        self.out.push_str(&format!("\\u{:04x}", code_of(c)));
                        continue;
                    }
                    for unit in c.encode_utf16(&mut [0; 2]) {
                        self.out.push_str(&format!("\\u{unit:04x}"));
                    }
                }
                c => self.out.push(c),
            }
        }
    }

    fn new_line(&mut self, levels: usize) {
        if let Some(indent) = &self.indent {
            self.out.push('\n');
            for _ in 0..levels {
                self.out.push_str(indent);
            }
        }
    }

    /// The items come one by one: `default` of the script may change the list.
    fn array(&mut self, item: impl Fn(usize) -> Option<Value>) -> R<()> {
        if item(0).is_none() {
            self.out.push_str("[]");
            return Ok(());
        }
        self.out.push('[');
        let levels = self.open.len();
        let mut index = 0;
        while let Some(item) = item(index) {
            if index > 0 {
                self.out.push_str(&self.item.clone());
            }
            self.new_line(levels);
            self.value(&item)?;
            self.ev.safepoint()?;
            index += 1;
        }
        self.new_line(levels - 1);
        self.out.push(']');
        Ok(())
    }

    fn is_type_error(&self, raised: &Raised) -> bool {
        self.ev.is_kind(raised, ExceptionKind::TypeError)
    }

    /// What `items()` of an object of a class derived from `dict` gives.
    fn given_items(&self, value: &Value) -> R<Values> {
        let ev = self.ev;
        let method = ev.attribute(value, ev.core.symbols.intern("items"))?;
        let items = ev.call(&method, &mut [], &[])?;
        let iterator = match ev.iter(&items) {
            Err(raised) if !self.asks && self.is_type_error(&raised) => {
                let (class, found) = (ev.core.types.of(value), ev.core.types.name_of(&items));
                let class = class.name();
                let text = format!("{class}.items() returned a non-iterable (type {found})");
                return Err(ev.type_error(text));
            }
            iterator => iterator?,
        };
        ev.drain(&iterator)
    }

    /// The key and the value of an item.
    fn pair(&self, item: &Value) -> R<(Value, Value)> {
        if let Value::Tuple(pair) = self.ev.plain(item)
            && (!self.asks || matches!(item, Value::Tuple(_)))
            && let [key, value] = pair.items()
        {
            return Ok((key.clone(), value.clone()));
        }
        if !self.asks {
            return Err(self.ev.value_error("items must return 2-tuples"));
        }
        let mut pair = self.ev.unpacked(item, 2)?.into_iter();
        Ok((
            pair.next().unwrap_or_default(),
            pair.next().unwrap_or_default(),
        ))
    }

    fn object(&mut self, mut items: Values) -> R<()> {
        if self.sort_keys {
            self.ev.sort(&mut items, None, false)?;
        }
        let levels = self.open.len();
        let mut first = true;
        self.out.push('{');
        self.new_line(levels);
        for item in items {
            let (key, value) = self.pair(&item)?;
            let Some(text) = self.key_text(&key)? else {
                continue;
            };
            if !first {
                self.out.push_str(&self.item.clone());
                self.new_line(levels);
            }
            first = false;
            self.string(&text)?;
            self.out.push_str(&self.key.clone());
            self.value(&value)?;
            self.ev.safepoint()?;
        }
        self.new_line(levels - 1);
        self.out.push('}');
        Ok(())
    }

    /// The text of a key; None if it is to be skipped.
    fn key_text(&self, key: &Value) -> R<Option<String>> {
        let plain = self.ev.plain(key);
        Ok(Some(match &plain {
            Value::Str(text) => self.ev.copied_text(text.as_str())?,
            Value::None => "null".to_owned(),
            Value::Bool(flag) => flag.to_string(),
            Value::Float(float) => self.float(*float)?,
            other if Int::of(other).is_some() => self.ev.natural_repr(other)?,
            _ if self.skip_keys => return Ok(None),
            other => {
                let name = self.ev.core.types.of(other).name();
                let text = format!("keys must be str, int, float, bool or None, not {name}");
                return Err(self.ev.raise(ExceptionKind::TypeError, text));
            }
        }))
    }
}
