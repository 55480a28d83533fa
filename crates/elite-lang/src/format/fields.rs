//! `str.format`: replacement fields by position, name, attribute and item.

use elite_syntax::ast::Conversion;
use elite_syntax::surrogate::code_of;

use crate::builtins::Args;
use crate::eval::Evaluator;
use crate::limits::chunked::WORK_PER_BYTE;
use crate::ops::unicode::decimal;
use crate::value::{R, Symbol, Value};

use super::index_of;

/// How fields without a number are counted.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Numbering {
    Undecided,
    Automatic(usize),
    Manual,
}

/// Fields within the specification of a field.
const FIELD_DEPTH_MAX: u32 = 2;

/// Where the values of fields come from.
#[derive(Clone, Copy)]
struct FieldArgs<'a> {
    positional: &'a [Value],
    keywords: &'a [(Symbol, Value)],
    /// The mapping of `format_map`, instead of both.
    mapping: Option<&'a Value>,
}

/// A field of a format, and the text behind it.
struct Field<'t> {
    name: &'t str,
    conversion: Option<char>,
    spec: &'t str,
    rest: &'t str,
}

/// From a value to a part of it.
enum PathStep<'t> {
    Attribute(&'t str),
    Item(Value),
}

impl Evaluator<'_> {
    /// `format.format(*args, **kwargs)`
    pub fn format_fields(&self, format: &str, args: &Args<'_>) -> R {
        let source = FieldArgs {
            positional: args.positional,
            keywords: args.keywords,
            mapping: None,
        };
        self.format_from(format, source)
    }

    /// `format.format_map(mapping)`
    pub fn format_map(&self, format: &str, mapping: &Value) -> R {
        let source = FieldArgs {
            positional: &[],
            keywords: &[],
            mapping: Some(mapping),
        };
        self.format_from(format, source)
    }

    fn format_from(&self, format: &str, source: FieldArgs<'_>) -> R {
        let mut numbering = Numbering::Undecided;
        // A field alone gives the text that the object made, which may be of a class derived from `str`.
        if let Some(inner) = format.strip_prefix('{')
            && inner.ends_with('}')
        {
            let is_brace = |byte| matches!(byte, b'{' | b'}');
            if self.position(inner.as_bytes(), is_brace)? == Some(inner.len() - 1) {
                let field = self.read_field(inner)?;
                let value = self.converted(&field, source, &mut numbering)?;
                return self.format_value(&value, field.spec);
            }
        }
        let mut out = String::new();
        self.grow(&mut out, format.len() + 16)?;
        self.fields(format, source, &mut numbering, 0, &mut out)?;
        self.new_str(out)
    }

    /// A list of what a format is made of: the text before a field, its name, its specification and its conversion;
    /// None for those three where no field follows.
    pub fn format_parts(&self, format: &str) -> R {
        let mut parts: Vec<Value> = Vec::new();
        let (mut rest, mut text) = (format, String::new());
        while !rest.is_empty() {
            let brace = self.prefix_len(rest, |c| c != '{' && c != '}')?;
            self.push_text(&mut text, &rest[..brace])?;
            self.charge(WORK_PER_BYTE)?;
            let here = &rest[brace..];
            let field = self.field_ahead(here)?;
            let [name, spec, conversion] = match &field {
                Some(field) => [
                    self.new_str_from(field.name)?,
                    self.new_str_from(field.spec)?,
                    match field.conversion {
                        Some(c) => Value::str(c.to_string()),
                        None => Value::None,
                    },
                ],
                None => [Value::None, Value::None, Value::None],
            };
            match &field {
                Some(field) => rest = field.rest,
                // Two braces stand for one, which ends a piece.
                None => {
                    text.push_str(&here[..here.len().min(1)]);
                    rest = &here[here.len().min(2)..];
                }
            }
            self.grow(&mut parts, 1)?;
            let literal = self.new_str(std::mem::take(&mut text))?;
            parts.push(Value::tuple(vec![literal, name, spec, conversion]));
        }
        Ok(Value::list(parts))
    }

    /// The name of a field apart: a pair of what comes first, and a list of pairs of whether it is an attribute, and
    /// its name or index.
    pub fn field_path(&self, name: &str) -> R {
        self.check_name(name)?;
        let (first, mut path) = name.split_at(name.find(['.', '[']).unwrap_or(name.len()));
        let first = match index_of(first).and_then(|index| i64::try_from(index).ok()) {
            Some(index) => Value::Int(index),
            None => self.new_str_from(first)?,
        };
        let mut steps: Vec<Value> = Vec::new();
        while let Some((step, rest)) = self.path_step(path)? {
            let (is_attribute, key) = match step {
                PathStep::Attribute(name) => (true, self.new_str_from(name)?),
                PathStep::Item(key) => (false, key),
            };
            self.grow(&mut steps, 1)?;
            steps.push(Value::pair(Value::Bool(is_attribute), key));
            self.charge(WORK_PER_BYTE)?;
            path = rest;
        }
        Ok(Value::pair(first, Value::list(steps)))
    }

    /// The field at the head of a text that begins with a brace or is empty; None if there is none but a doubled brace.
    fn field_ahead<'t>(&self, here: &'t str) -> R<Option<Field<'t>>> {
        if here.is_empty() || here.starts_with("{{") || here.starts_with("}}") {
            return Ok(None);
        }
        let alone = match here {
            "{" => Some("Single '{' encountered in format string"),
            _ if here.starts_with('}') => Some("Single '}' encountered in format string"),
            _ => None,
        };
        match alone {
            Some(text) => Err(self.value_error(text)),
            None => self.read_field(&here[1..]).map(Some),
        }
    }

    fn fields(
        &self,
        format: &str,
        args: FieldArgs<'_>,
        numbering: &mut Numbering,
        depth: u32,
        out: &mut String,
    ) -> R<()> {
        if depth >= FIELD_DEPTH_MAX {
            return Err(self.value_error("Max string recursion exceeded"));
        }
        let mut rest = format;
        loop {
            let brace = self.prefix_len(rest, |c| c != '{' && c != '}')?;
            self.push_text(out, &rest[..brace])?;
            self.charge(WORK_PER_BYTE)?;
            let here = &rest[brace..];
            if here.is_empty() {
                break;
            }
            match self.field_ahead(here)? {
                Some(field) => {
                    self.field(&field, args, numbering, depth, out)?;
                    rest = field.rest;
                }
                None => {
                    out.push_str(&here[..1]);
                    rest = &here[2..];
                }
            }
        }
        Ok(())
    }

    /// The field at the head of a text, behind its brace: `name!conversion:spec}`.
    fn read_field<'t>(&self, text: &'t str) -> R<Field<'t>> {
        let mut in_item = false;
        let end = self.position(text.as_bytes(), |byte| match byte {
            b']' => {
                in_item = false;
                false
            }
            _ if in_item => false,
            b'[' => {
                in_item = true;
                false
            }
            other => matches!(other, b'{' | b'}' | b':' | b'!'),
        })?;
        let error = |text: &str| Err(self.value_error(text));
        let Some(end) = end else {
            return error("expected '}' before end of string");
        };
        let (name, mark, mut rest) = (&text[..end], &text[end..=end], &text[end + 1..]);
        let mut conversion = None;
        match mark {
            "{" => return error("unexpected '{' in field name"),
            "!" => {
                conversion = rest.chars().next();
                let Some(c) = conversion else {
                    return error("end of string while looking for conversion specifier");
                };
                rest = &rest[c.len_utf8()..];
                match rest.chars().next() {
                    Some(':') => rest = &rest[1..],
                    Some('}') | None => {}
                    Some(_) => return error("expected ':' after conversion specifier"),
                }
            }
            _ => {}
        }
        if mark == "}" {
            let spec = "";
            return Ok(Field {
                name,
                conversion,
                spec,
                rest,
            });
        }
        let mut depth = 1;
        let end = self.position(rest.as_bytes(), |byte| {
            match byte {
                b'{' => depth += 1,
                b'}' => depth -= 1,
                _ => {}
            }
            depth == 0
        })?;
        let Some(end) = end else {
            return error("unmatched '{' in format spec");
        };
        let (spec, rest) = (&rest[..end], &rest[end + 1..]);
        Ok(Field {
            name,
            conversion,
            spec,
            rest,
        })
    }

    /// The value of a field, converted if the field says so.
    fn converted(&self, field: &Field<'_>, args: FieldArgs<'_>, numbering: &mut Numbering) -> R {
        let value = self.field_value(field.name, args, numbering)?;
        let conversion = match field.conversion {
            None => Conversion::None,
            Some('s') => Conversion::Str,
            Some('r') => Conversion::Repr,
            Some('a') => Conversion::Ascii,
            Some(c) => {
                let shown = match c {
                    '!'..='~' => c.to_string(),
                    other => format!("\\x{:x}", code_of(other)),
                };
                return Err(self.value_error(format!("Unknown conversion specifier {shown}")));
            }
        };
        self.convert(value, conversion)
    }

    fn field(
        &self,
        field: &Field<'_>,
        args: FieldArgs<'_>,
        numbering: &mut Numbering,
        depth: u32,
        out: &mut String,
    ) -> R<()> {
        let value = self.converted(field, args, numbering)?;
        let spec = field.spec;
        if !spec.contains('{') {
            return self.format_into(&value, spec, out);
        }
        let mut resolved = String::new();
        self.fields(spec, args, numbering, depth + 1, &mut resolved)?;
        self.format_into(&value, &resolved, out)
    }

    fn field_value(&self, name: &str, args: FieldArgs<'_>, numbering: &mut Numbering) -> R {
        self.check_name(name)?;
        let first_end = name.find(['.', '[']).unwrap_or(name.len());
        let (first, mut path) = name.split_at(first_end);
        let mut value = self.first_value(first, args, numbering)?;
        while let Some((step, rest)) = self.path_step(path)? {
            value = match step {
                PathStep::Attribute(name) => self.attribute(&value, *self.temp_symbol(name)?)?,
                PathStep::Item(key) => self.item(&value, &key)?,
            };
            path = rest;
        }
        Ok(value)
    }

    /// The first step of a path from a value to a part of it, and the path behind it; None at its end.
    fn path_step<'t>(&self, path: &'t str) -> R<Option<(PathStep<'t>, &'t str)>> {
        if path.is_empty() {
            return Ok(None);
        }
        if let Some(after) = path.strip_prefix('.') {
            let end = after.find(['.', '[']).unwrap_or(after.len());
            if end == 0 {
                return Err(self.value_error("Empty attribute in format string"));
            }
            return Ok(Some((PathStep::Attribute(&after[..end]), &after[end..])));
        }
        let Some(after) = path.strip_prefix('[') else {
            let text = "Only '.' or '[' may follow ']' in format field specifier";
            return Err(self.value_error(text));
        };
        let end = after
            .find(']')
            .ok_or_else(|| self.value_error("Missing ']' in format string"))?;
        let key = &after[..end];
        if key.is_empty() {
            return Err(self.value_error("Empty attribute in format string"));
        }
        let is_index = key.chars().all(|c| decimal(c).is_some());
        let key = match index_of(key).and_then(|index| i64::try_from(index).ok()) {
            Some(index) => Value::Int(index),
            None if is_index => {
                let text = "Too many decimal digits in format string";
                return Err(self.value_error(text));
            }
            _ => Value::str(key),
        };
        Ok(Some((PathStep::Item(key), &after[end + 1..])))
    }

    fn first_value(&self, name: &str, args: FieldArgs<'_>, numbering: &mut Numbering) -> R {
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
        } else if let Some(index) = index_of(name) {
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
        if let Some(mapping) = args.mapping {
            return match index {
                Some(_) => Err(self.value_error("Format string contains positional fields")),
                None => self.item(mapping, &self.new_str_from(name)?),
            };
        }
        if let Some(index) = index {
            return args.positional.get(index).cloned().ok_or_else(|| {
                let text =
                    format!("Replacement index {index} out of range for positional args tuple");
                self.raise(crate::errors::ExceptionKind::IndexError, text)
            });
        }
        let symbol = self.core.symbols.find(name);
        let found = symbol.and_then(|symbol| {
            let mut keywords = args.keywords.iter();
            let found = keywords.find(|(name, _)| *name == symbol);
            found.map(|(_, value)| value.clone())
        });
        found.ok_or_else(|| self.key_error(&Value::str(name)))
    }
}
