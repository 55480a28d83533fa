//! Values as text, without running any of the script's own code.
//!
//! Two forms: Python's `repr`, cut to a length, for the variable monitor; and the form of `str_cat` and `to_str`, with
//! six decimals and no blanks (manual 9.4.2). What neither form knows is shown as `<type>`.

use elite_lang::Value;

/// Deepest nesting that is shown; it also ends lists that contain themselves.
const DEPTH_MAX: usize = 8;

/// Python's `repr`, at most about `limit` characters; a longer one ends with `...`.
pub(crate) fn repr_text(value: &Value, limit: usize) -> String {
    let mut text = ValueFormatter {
        out: String::new(),
        limit,
        style: Style::Repr,
        is_too_long: false,
    };
    text.push(value, 0);
    if text.out.chars().count() > limit {
        let cut = text.out.char_indices().nth(limit);
        text.out.truncate(cut.map_or(text.out.len(), |(at, _)| at));
        text.out.push_str("...");
    }
    text.out
}

/// Longest answer, bytes.
const ANSWER_MAX: usize = 64 << 10;

/// Python's notation with six decimals, as answers on port 40011 have it: clients find numbers by their digits and a
/// point, and take an exponent for another number. The error says that it is too long.
pub(crate) fn fixed_text(value: &Value) -> Result<String, String> {
    let mut text = ValueFormatter {
        out: String::new(),
        limit: ANSWER_MAX,
        style: Style::Fixed,
        is_too_long: false,
    };
    text.push(value, 0);
    match text.is_too_long || text.out.len() > ANSWER_MAX {
        true => Err(format!("the value has more than {} KiB", ANSWER_MAX >> 10)),
        false => Ok(text.out),
    }
}

/// The text of `str_cat` and `to_str`; `None` for values they do not take. Cut somewhere beyond `limit` characters.
pub(crate) fn compact_text(value: &Value, limit: usize) -> Option<String> {
    if let Value::Str(text) = value {
        return Some(text.as_str().to_owned());
    }
    let mut text = ValueFormatter {
        out: String::new(),
        limit,
        style: Style::Compact,
        is_too_long: false,
    };
    text.push(value, 0).then_some(text.out)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Style {
    Repr,
    Compact,
    Fixed,
}

struct ValueFormatter {
    out: String,
    limit: usize,
    style: Style,
    /// A text in the value has more than there is room for.
    is_too_long: bool,
}

impl ValueFormatter {
    /// Adds a value. False when it holds something that has no form of its own.
    fn push(&mut self, value: &Value, depth: usize) -> bool {
        if self.out.len() > 4 * self.limit {
            return true; // bytes; the caller counts characters
        }
        match value {
            Value::Unbound | Value::None => self.out.push_str("None"),
            Value::Bool(true) => self.out.push_str("True"),
            Value::Bool(false) => self.out.push_str("False"),
            Value::Int(n) => self.out.push_str(&n.to_string()),
            // Decimal digits of a huge number take quadratic time.
            Value::BigInt(n) if n.bits() <= 4096 => self.out.push_str(&n.to_string()),
            Value::Float(x) if self.style == Style::Compact => {
                self.out.push_str(&six_decimals(*x));
            }
            Value::Float(x) if self.style == Style::Fixed && x.is_finite() && x.abs() < 1e15 => {
                let text = format!("{x:.6}");
                let is_zero = text == "-0.000000";
                self.out.push_str(if is_zero { &text[1..] } else { &text });
            }
            Value::Float(x) => self.out.push_str(&python_float(*x)),
            Value::Str(text) if self.style == Style::Fixed && text.as_str().len() > self.limit => {
                self.is_too_long = true;
            }
            Value::Str(text) => self.quoted(text.as_str()),
            Value::List(_)
            | Value::Tuple(_)
            | Value::Set(_)
            | Value::FrozenSet(_)
            | Value::Dict(_) => return self.container(value, depth),
            other => {
                self.out.push('<');
                self.out.push_str(&other.type_name());
                self.out.push('>');
                return false;
            }
        }
        true
    }

    fn container(&mut self, value: &Value, depth: usize) -> bool {
        if depth >= DEPTH_MAX {
            self.out.push_str("...");
            return true;
        }
        let (open, close) = match value {
            Value::List(_) => ("[", "]"),
            Value::Tuple(_) => ("(", ")"),
            Value::FrozenSet(_) => ("frozenset({", "})"),
            _ => ("{", "}"),
        };
        self.out.push_str(open);
        let mut known = true;
        let mut count = 0;
        match value {
            Value::Dict(dict) => {
                for (_, key, value) in dict.entries() {
                    self.separate(count);
                    count += 1;
                    known &= self.push(&key, depth + 1);
                    self.out.push_str(if self.style == Style::Compact {
                        ":"
                    } else {
                        ": "
                    });
                    known &= self.push(&value, depth + 1);
                }
            }
            Value::Set(set) | Value::FrozenSet(set) => {
                for (_, item) in set.elements() {
                    self.separate(count);
                    count += 1;
                    known &= self.push(&item, depth + 1);
                }
            }
            sequence => {
                for item in sequence.as_items().unwrap_or_default() {
                    self.separate(count);
                    count += 1;
                    known &= self.push(&item, depth + 1);
                }
                if matches!(sequence, Value::Tuple(_)) && count == 1 {
                    self.out.push(',');
                }
            }
        }
        self.out.push_str(close);
        known
    }

    fn separate(&mut self, count: usize) {
        if count > 0 {
            self.out.push_str(if self.style == Style::Compact {
                ","
            } else {
                ", "
            });
        }
    }

    fn quoted(&mut self, text: &str) {
        let quote = if text.contains('\'') && !text.contains('"') {
            '"'
        } else {
            '\''
        };
        self.out.push(quote);
        for c in text.chars().take(self.limit + 1) {
            match c {
                '\\' => self.out.push_str("\\\\"),
                '\n' => self.out.push_str("\\n"),
                '\r' => self.out.push_str("\\r"),
                '\t' => self.out.push_str("\\t"),
                c if c == quote => self.out.extend(['\\', c]),
                c if c.is_control() => self.out.push_str(&format!("\\x{:02x}", u32::from(c))),
                c => self.out.push(c),
            }
        }
        self.out.push(quote);
    }
}

/// Six decimals without the zeros at the end: 1.0 is `1` (manual 9.4.2).
pub(crate) fn six_decimals(x: f64) -> String {
    if !x.is_finite() {
        return python_float(x);
    }
    let text = format!("{x:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

/// `repr` of a float: the shortest digits, an exponent below 1e-4 and from 1e16.
fn python_float(x: f64) -> String {
    if x.is_nan() {
        return "nan".to_owned();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf" } else { "-inf" }.to_owned();
    }
    let scientific = format!("{x:e}");
    let Some((digits, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    match exponent.parse::<i32>() {
        Ok(n) if !(-4..16).contains(&n) => {
            let sign = if n < 0 { '-' } else { '+' };
            format!("{digits}e{sign}{:02}", n.abs())
        }
        _ => format!("{x:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn list(items: Vec<Value>) -> Value {
        Value::list(items)
    }

    #[test]
    fn values_are_written_as_python_writes_them() {
        for (value, text) in [
            (Value::None, "None"),
            (Value::Bool(true), "True"),
            (Value::Int(-3), "-3"),
            (Value::Float(1.0), "1.0"),
            (Value::Float(0.0001), "0.0001"),
            (Value::Float(0.000_01), "1e-05"),
            (Value::Float(1.5e-7), "1.5e-07"),
            (Value::Float(1e16), "1e+16"),
            (Value::Float(f64::NAN), "nan"),
            (Value::str("it's"), "\"it's\""),
            (Value::str("a\n\u{1}"), "'a\\n\\x01'"),
            (list(vec![Value::Int(1), Value::str("x")]), "[1, 'x']"),
            (
                Value::dict_of([("k".to_owned(), Value::Float(2.5))]),
                "{'k': 2.5}",
            ),
        ] {
            assert_eq!(repr_text(&value, 100), text);
        }
    }

    #[test]
    fn long_and_endless_values_are_cut() {
        let long = Value::list_of_i64(&[7; 10_000]);
        let text = repr_text(&long, 20);
        assert_eq!(text, "[7, 7, 7, 7, 7, 7, 7...");
        let mut nested = Value::None;
        for _ in 0..100 {
            nested = list(vec![nested]);
        }
        assert!(repr_text(&nested, 1000).len() < 100);
    }

    #[test]
    fn the_compact_form_has_six_decimals_and_no_blanks() {
        for (value, text) in [
            (Value::list_of_f64(&[1.0, 2.0, 3.0]), "[1,2,3]"),
            (
                list(vec![Value::Bool(true), Value::Bool(false)]),
                "[True,False]",
            ),
            (Value::Float(3.123_456_123_456), "3.123456"),
            (Value::Float(-0.000_000_1), "0"),
            (Value::Float(100.0), "100"),
            (Value::str("as it is"), "as it is"),
        ] {
            assert_eq!(compact_text(&value, 1023).as_deref(), Some(text));
        }
    }

    #[test]
    fn answers_have_six_decimals_and_no_exponent() {
        for (value, text) in [
            (Value::Float(1e-5), "0.000010"),
            (Value::Float(-1e-9), "0.000000"),
            (Value::Float(-1.612_345_64), "-1.612346"),
            (Value::Int(-3), "-3"),
            (Value::Bool(true), "True"),
            (Value::None, "None"),
            (
                list(vec![Value::Float(0.5), Value::str("a")]),
                "[0.500000, 'a']",
            ),
        ] {
            assert_eq!(fixed_text(&value).as_deref(), Ok(text));
        }
        assert!(fixed_text(&Value::str("a".repeat(70_000))).is_err());
        let many = (0..9000).map(|_| Value::Float(1.0)).collect();
        assert!(fixed_text(&list(many)).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]
        #[test]
        fn six_decimals_are_within_half_a_millionth(x in -1e9..1e9_f64) {
            let back: f64 = six_decimals(x).parse().unwrap();
            prop_assert!((back - x).abs() <= 0.5e-6 + x.abs() * 1e-15);
        }

        #[test]
        fn a_float_reads_back_as_itself(x in proptest::num::f64::NORMAL) {
            prop_assert_eq!(python_float(x).parse::<f64>().unwrap(), x);
        }
    }
}
