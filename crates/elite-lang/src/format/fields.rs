//! `str.format`: replacement fields by position, name, attribute and item.

use crate::ast::Conversion;
use crate::builtins::Args;
use crate::eval::Evaluator;
use crate::eval::bulk::EACH;
use crate::value::{R, Value};

/// How fields without a number are counted.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Numbering {
    Undecided,
    Automatic(usize),
    Manual,
}

/// Fields within the specification of a field.
const DEPTH_MAX: u32 = 2;

/// The names at the head of the fields of a format, numbers left out.
pub fn field_names<'f>(ev: &Evaluator<'_>, format: &'f str) -> impl Iterator<Item = R<&'f str>> {
    let mut rest = format;
    std::iter::from_fn(move || {
        loop {
            let brace = match ev.find_bytes(rest.as_bytes(), b"{") {
                Ok(found) => found?,
                Err(raised) => return Some(Err(raised)),
            };
            rest = &rest[brace + 1..];
            if let Some(after) = rest.strip_prefix('{') {
                rest = after;
                continue;
            }
            let end = match ev.position(rest.as_bytes(), |byte| b".[!:}{".contains(&byte)) {
                Ok(end) => end.unwrap_or(rest.len()),
                Err(raised) => return Some(Err(raised)),
            };
            if let Err(raised) = ev.check_name(&rest[..end]) {
                return Some(Err(raised));
            }
            let (name, after) = rest.split_at(end);
            rest = after;
            if !name.is_empty() && !name.bytes().all(|byte| byte.is_ascii_digit()) {
                return Some(Ok(name));
            }
        }
    })
}

impl Evaluator<'_> {
    /// `format.format(*args, **kwargs)`
    pub fn format_fields(&self, format: &str, args: &Args<'_>) -> R<String> {
        let mut out = String::new();
        self.grow(&mut out, format.len() + 16)?;
        let mut numbering = Numbering::Undecided;
        self.fields(format, args, &mut numbering, 0, &mut out)?;
        Ok(out)
    }

    fn fields(
        &self,
        format: &str,
        args: &Args<'_>,
        numbering: &mut Numbering,
        depth: u32,
        out: &mut String,
    ) -> R<()> {
        if depth >= DEPTH_MAX {
            return Err(self.value_error("Max string recursion exceeded"));
        }
        let mut rest = format;
        loop {
            let brace = self.leading(rest, |c| c != '{' && c != '}')?;
            self.push_text(out, &rest[..brace])?;
            self.worked(EACH)?;
            let here = &rest[brace..];
            if here.is_empty() {
                break;
            }
            if here.starts_with("{{") || here.starts_with("}}") {
                out.push_str(&here[..1]);
                rest = &here[2..];
            } else if here.starts_with('}') {
                return Err(self.value_error("Single '}' encountered in format string"));
            } else {
                let Some(end) = field_end(self, &here[1..])? else {
                    let single = here.len() == 1;
                    let text = if single {
                        "Single '{' encountered in format string"
                    } else if here[1 + name_end(self, &here[1..])?..].starts_with(':') {
                        "unmatched '{' in format spec"
                    } else {
                        "expected '}' before end of string"
                    };
                    return Err(self.value_error(text));
                };
                self.field(&here[1..=end], args, numbering, depth, out)?;
                rest = &here[end + 2..];
            }
        }
        Ok(())
    }

    /// A field without its braces: `name!conversion:spec`.
    fn field(
        &self,
        field: &str,
        args: &Args<'_>,
        numbering: &mut Numbering,
        depth: u32,
        out: &mut String,
    ) -> R<()> {
        let split = name_end(self, field)?;
        let (name, tail) = field.split_at(split);
        let (conversion, tail) = match tail.strip_prefix('!') {
            None => (Conversion::None, tail),
            Some(after) => {
                let mut chars = after.chars();
                let conversion = match chars.next() {
                    Some('s') => Conversion::Str,
                    Some('r') => Conversion::Repr,
                    Some('a') => Conversion::Ascii,
                    Some(c) => {
                        return Err(self.value_error(format!("Unknown conversion specifier {c}")));
                    }
                    None => {
                        let text = "unmatched '{' in format spec";
                        return Err(self.value_error(text));
                    }
                };
                (conversion, chars.as_str())
            }
        };
        let spec = match tail.strip_prefix(':') {
            Some(spec) => spec,
            None if tail.is_empty() => "",
            None => return Err(self.value_error("expected ':' after conversion specifier")),
        };
        let value = self.field_value(name, args, numbering)?;
        let value = self.convert(value, conversion)?;
        if !spec.contains('{') {
            return self.format_into(&value, spec, out);
        }
        let mut resolved = String::new();
        self.fields(spec, args, numbering, depth + 1, &mut resolved)?;
        self.format_into(&value, &resolved, out)
    }

    fn field_value(&self, name: &str, args: &Args<'_>, numbering: &mut Numbering) -> R {
        self.check_name(name)?;
        let first_end = name.find(['.', '[']).unwrap_or(name.len());
        let (first, mut path) = name.split_at(first_end);
        let mut value = self.first_value(first, args, numbering)?;
        while !path.is_empty() {
            if let Some(after) = path.strip_prefix('.') {
                let end = after.find(['.', '[']).unwrap_or(after.len());
                if end == 0 {
                    return Err(self.value_error("Empty attribute in format string"));
                }
                value = self.attribute(&value, *self.ask_name(&after[..end])?)?;
                path = &after[end..];
            } else if let Some(after) = path.strip_prefix('[') {
                let end = after
                    .find(']')
                    .ok_or_else(|| self.value_error("Missing ']' in format string"))?;
                let key = &after[..end];
                if key.is_empty() {
                    return Err(self.value_error("Empty attribute in format string"));
                }
                let is_index = key.bytes().all(|byte| byte.is_ascii_digit());
                let key = match key.parse() {
                    Ok(index) if is_index => Value::Int(index),
                    _ if is_index => {
                        let text = "Too many decimal digits in format string";
                        return Err(self.value_error(text));
                    }
                    _ => Value::str(key),
                };
                value = self.item(&value, &key)?;
                path = &after[end + 1..];
            } else {
                return Err(
                    self.value_error("Only '.' or '[' may follow ']' in format field specifier")
                );
            }
        }
        Ok(value)
    }

    fn first_value(&self, name: &str, args: &Args<'_>, numbering: &mut Numbering) -> R {
        let index = if name.is_empty() {
            let next = match numbering {
                Numbering::Undecided => 0,
                Numbering::Automatic(next) => *next,
                Numbering::Manual => {
                    let text = "cannot switch from manual field specification to automatic field numbering";
                    return Err(self.value_error(text));
                }
            };
            *numbering = Numbering::Automatic(next + 1);
            Some(next)
        } else if let Ok(index) = name.parse::<usize>() {
            if let Numbering::Automatic(_) = numbering {
                let text =
                    "cannot switch from automatic field numbering to manual field specification";
                return Err(self.value_error(text));
            }
            *numbering = Numbering::Manual;
            Some(index)
        } else {
            None
        };
        if let Some(index) = index {
            return args.positional.get(index).cloned().ok_or_else(|| {
                let text =
                    format!("Replacement index {index} out of range for positional args tuple");
                self.raise(crate::errors::ExceptionKind::IndexError, text)
            });
        }
        let symbol = self.core.symbols.find(name);
        let found = symbol.and_then(|symbol| args.keyword(symbol).cloned());
        found.ok_or_else(|| self.key_error(&Value::str(name)))
    }
}

/// Index of the `}` that ends the field whose text starts at `text`; braces in the specification nest, brackets of
/// items hide braces.
fn field_end(ev: &Evaluator<'_>, text: &str) -> R<Option<usize>> {
    let mut depth = 0;
    let mut in_item = false;
    ev.position(text.as_bytes(), |byte| {
        match byte {
            b'[' if depth == 0 => in_item = true,
            b']' => in_item = false,
            b'{' if !in_item => depth += 1,
            b'}' if !in_item && depth == 0 => return true,
            b'}' if !in_item => depth -= 1,
            _ => {}
        }
        false
    })
}

fn name_end(ev: &Evaluator<'_>, field: &str) -> R<usize> {
    let mut in_item = false;
    let end = ev.position(field.as_bytes(), |byte| {
        match byte {
            b'[' => in_item = true,
            b']' => in_item = false,
            b'!' | b':' if !in_item => return true,
            _ => {}
        }
        false
    })?;
    Ok(end.unwrap_or(field.len()))
}
