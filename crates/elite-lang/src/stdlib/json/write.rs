//! Writing JSON text, as CPython's encoder in C does it or, where it has to, the one in Python.

use elite_syntax::surrogate::{code_of, is_surrogate};

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::format::float;
use crate::limits::chunked::{WORK_PER_BYTE, pieces};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::int::Int;
use crate::value::{R, Unwind, Value, ValueVec};

/// `options` is a tuple: skipkeys, ensure_ascii, check_circular, allow_nan, indent, separators, default, sort_keys, and
/// whether CPython would go through what is to be written by its encoder in Python, as it does with an indentation.
pub(super) fn write(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let options = ev.collect(&args[1])?;
    let option = |index: usize| options.get(index).cloned().unwrap_or(Value::None);
    let indent = match option(4) {
        Value::None => None,
        Value::Str(text) => Some(ev.copy_text(text.as_str())?),
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
            Some(Value::Str(text)) => ev.copy_text(text.as_str()),
            _ => Ok(default.to_owned()),
        };
    let item = separator(0, if indent.is_some() { "," } else { ", " })?;
    let asks = indent.is_some() || ev.truth(&option(8))?;
    let mut writer = JsonEncoder {
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
    ev.new_str(writer.out)
}

struct JsonEncoder<'w, 'y> {
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

impl JsonEncoder<'_, '_> {
    fn value(&mut self, value: &Value) -> R<()> {
        let plain = self.ev.unwrap_builtin(value);
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
                self.nested(&plain, |writer| {
                    writer.array(|index| items.get(index).cloned())
                })?;
            }
            Value::List(list) => {
                self.nested(&plain, |writer| writer.array(|index| list.get(index)))?;
            }
            Value::Tuple(tuple) => {
                let item = |index: usize| tuple.items().get(index).cloned();
                self.nested(&plain, |writer| writer.array(item))?;
            }
            Value::Dict(_) if self.asks && !self.ev.truth(value)? => self.out.push_str("{}"),
            Value::Dict(dict) if !self.asks && dict.is_empty() => self.out.push_str("{}"),
            Value::Dict(_) if matches!(value, Value::Instance(_)) => {
                self.nested(&plain, |writer| {
                    let items = writer.given_items(value)?;
                    writer.object(items)
                })?;
            }
            Value::Dict(dict) => {
                let entries = self.ev.collect_entries(dict)?;
                self.nested(&plain, |writer| {
                    let mut pairs = ValueVec::from(writer.ev.try_with_capacity(entries.len())?);
                    for (_, key, value) in entries {
                        pairs.push(Value::pair(key, value));
                        writer.ev.charge(4 * WORK_PER_VALUE)?;
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
                self.nested(value, |writer| {
                    let replacement = writer.ev.call1(&default, value.clone())?;
                    writer.value(&replacement)
                })?;
            }
        }
        self.ev.check_allocation(self.out.len())
    }

    /// Goes one level deeper, into `container`.
    fn nested(&mut self, container: &Value, inner: impl FnOnce(&mut Self) -> R<()>) -> R<()> {
        let address = container.address().unwrap_or(0);
        if self.check_circular && self.open.contains(&address) {
            return Err(self.ev.value_error("Circular reference detected"));
        }
        self.open.push(address);
        let ev = self.ev;
        let result = ev.with_native_depth(|| inner(self));
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
            self.push_escaped(piece);
            self.ev.charge(piece.len() * WORK_PER_BYTE)?;
        }
        self.out.push('"');
        Ok(())
    }

    fn push_escaped(&mut self, text: &str) {
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

    fn is_type_error(&self, raised: &Unwind) -> bool {
        self.ev.is_kind(raised, ExceptionKind::TypeError)
    }

    /// What `items()` of an object of a class derived from `dict` gives.
    fn given_items(&self, value: &Value) -> R<ValueVec> {
        let ev = self.ev;
        let method = ev.attribute(value, ev.core.symbols.intern("items"))?;
        let items = ev.call(&method, &mut [], &[])?;
        let iterator = match self.asks {
            true => ev.iter(&items),
            false => ev.iter_result(value, "items", &items),
        };
        ev.drain(&iterator?)
    }

    /// The key and the value of an item.
    fn pair(&self, item: &Value) -> R<(Value, Value)> {
        if let Value::Tuple(pair) = self.ev.unwrap_builtin(item)
            && (!self.asks || matches!(item, Value::Tuple(_)))
            && let [key, value] = pair.items()
        {
            return Ok((key.clone(), value.clone()));
        }
        if !self.asks {
            return Err(self.ev.value_error("items must return 2-tuples"));
        }
        let mut pair = self.ev.unpack_exact(item, 2)?.into_iter();
        Ok((
            pair.next().unwrap_or_default(),
            pair.next().unwrap_or_default(),
        ))
    }

    fn object(&mut self, mut items: ValueVec) -> R<()> {
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
        let plain = self.ev.unwrap_builtin(key);
        Ok(Some(match &plain {
            Value::Str(text) => self.ev.copy_text(text.as_str())?,
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
