//! Values as people look at them in a debugger: a short text, and what is in them, a page at a time. Circles and great
//! sizes do no harm: texts are cut, and what is in a value is listed only when it is asked for.

use super::PausedProgram;
use crate::eval::InterpreterState;
use crate::value::Value;

/// Longest text of a value, in characters.
const PREVIEW_CHARS_MAX: usize = 300;
/// Elements of a container that its text names.
const ELEMENTS_SHOWN: usize = 20;
/// Containers within containers whose texts are written out.
const DEPTH_SHOWN: usize = 3;
/// Slices that a program's own `__repr__` may take.
const REPR_SLICES: u32 = 10;

/// A value on the screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValuePreview {
    /// The value.
    pub text: String,
    /// The name of its type.
    pub type_name: String,
    /// How many elements it has, counted from 0.
    pub indexed: usize,
    /// How many things in it have names or keys.
    pub named: usize,
}

/// Something in a value.
#[derive(Clone, Debug)]
pub struct ChildValue {
    /// The name, key or index of the part.
    pub name: String,
    /// An expression for it, given one for the whole: `.x`, `[3]`; None where there is none.
    pub suffix: Option<String>,
    /// The value of the part.
    pub value: Value,
}

/// The parts of a value that are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildFilter {
    /// Parts that have an index.
    Indexed,
    /// Parts that have a name or a key.
    Named,
    /// All parts.
    Both,
}

impl PausedProgram<'_> {
    /// What is shown of a value.
    pub fn show(&self, value: &Value) -> ValuePreview {
        let (indexed, named) = sizes(self.core, value);
        ValuePreview {
            text: cut(self.text(value, 0)),
            type_name: value.type_name().to_string(),
            indexed,
            named,
        }
    }

    /// The whole text of a value for a clipboard: strings are not cut, up to `most` bytes.
    pub fn whole_text(&self, value: &Value, most: usize) -> String {
        let mut text = match self.repr_of(value, 10 * REPR_SLICES) {
            Some(text) => text,
            None => self.text(value, 0),
        };
        if text.len() > most {
            let end = (0..=most)
                .rev()
                .find(|end| text.is_char_boundary(*end))
                .unwrap_or(0);
            text.truncate(end);
            text.push('…');
        }
        text
    }

    /// What is in a value: `count` things from number `from` on.
    pub fn children(
        &self,
        value: &Value,
        which: ChildFilter,
        from: usize,
        count: usize,
    ) -> Vec<ChildValue> {
        let element = |(index, value): (usize, Value)| ChildValue {
            name: format!("[{index}]"),
            suffix: Some(format!("[{index}]")),
            value,
        };
        let symbols = &self.core.symbols;
        match value {
            Value::List(_) | Value::Tuple(_) if which == ChildFilter::Named => Vec::new(),
            Value::List(list) => {
                let items = list.borrow();
                let page = items.iter().cloned().enumerate().skip(from).take(count);
                page.map(element).collect()
            }
            Value::Tuple(tuple) => {
                let items = tuple.items().iter().cloned().enumerate();
                items.skip(from).take(count).map(element).collect()
            }
            Value::Set(set) | Value::FrozenSet(set) => {
                let elements = set.elements().into_iter().map(|(_, value)| value);
                let page = elements.enumerate().skip(from).take(count);
                let child = |(index, value)| ChildValue {
                    name: format!("{{{index}}}"),
                    suffix: None,
                    value,
                };
                page.map(child).collect()
            }
            _ if which == ChildFilter::Indexed => Vec::new(),
            Value::Dict(dict) => {
                let entries = dict.entries().into_iter().skip(from).take(count);
                let child = |(_, key, value): (u64, Value, Value)| {
                    let is_plain = matches!(
                        key,
                        Value::Str(_) | Value::Int(_) | Value::Float(_) | Value::Bool(_)
                    );
                    let name = cut(self.text(&key, 1));
                    ChildValue {
                        suffix: is_plain.then(|| format!("[{name}]")),
                        name,
                        value,
                    }
                };
                entries.map(child).collect()
            }
            Value::Instance(instance) => {
                let entries = instance.entries(symbols).into_iter();
                let child = |(key, value): (Value, Value)| {
                    let name = key.as_str().unwrap_or_default().to_owned();
                    ChildValue {
                        suffix: Some(format!(".{name}")),
                        name,
                        value,
                    }
                };
                entries.skip(from).take(count).map(child).collect()
            }
            Value::Module(module) => {
                let entries = module.namespace.entries().into_iter();
                let child = |(name, value)| {
                    let name = symbols.name(name).to_string();
                    ChildValue {
                        suffix: Some(format!(".{name}")),
                        name,
                        value,
                    }
                };
                entries.skip(from).take(count).map(child).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Puts a value in the place of a child; false where that cannot be done.
    pub fn set_child(&self, parent: &Value, child: &str, value: Value) -> bool {
        match parent {
            Value::List(list) => {
                let index = child.trim_start_matches('[').trim_end_matches(']');
                let index = index.parse().ok();
                index.is_some_and(|index: usize| list.replace(index, value).map(drop).is_ok())
            }
            Value::Instance(instance) => {
                let symbols = &self.core.symbols;
                let known = instance.entries(symbols);
                let is_known = known.iter().any(|(name, _)| name.as_str() == Some(child));
                if is_known {
                    instance.set(symbols.intern(child), value, symbols);
                }
                is_known
            }
            Value::Dict(dict) => {
                let entries = dict.entries();
                let place = entries
                    .iter()
                    .find(|(_, key, _)| cut(self.text(key, 1)) == child);
                let Some((hash, key, _)) = place else {
                    return false;
                };
                match dict.find(*hash, key) {
                    crate::value::dict::KeySearch::At(index) => {
                        dict.set_value_at(index, value);
                        true
                    }
                    _ => false,
                }
            }
            _ => false,
        }
    }

    fn text(&self, value: &Value, depth: usize) -> String {
        let list = |open: &str, items: &mut dyn Iterator<Item = Value>, len: usize, close: &str| {
            if depth >= DEPTH_SHOWN && len > 0 {
                return format!("{open}…{close}");
            }
            let mut text = open.to_owned();
            for (index, item) in items.take(ELEMENTS_SHOWN).enumerate() {
                if index > 0 {
                    text.push_str(", ");
                }
                text.push_str(&self.text(&item, depth + 1));
                if text.len() > 4 * PREVIEW_CHARS_MAX {
                    text.push('…');
                    return text;
                }
            }
            if len > ELEMENTS_SHOWN {
                text.push_str(&format!(", … {len} in all"));
            }
            text + close
        };
        match value {
            Value::List(items) => {
                let shown: Vec<Value> = items
                    .borrow()
                    .iter()
                    .take(ELEMENTS_SHOWN)
                    .cloned()
                    .collect();
                list("[", &mut shown.into_iter(), items.len(), "]")
            }
            Value::Tuple(tuple) if tuple.items().len() == 1 => {
                list("(", &mut tuple.items().iter().cloned(), 1, ",)")
            }
            Value::Tuple(tuple) => {
                let items = tuple.items();
                list("(", &mut items.iter().cloned(), items.len(), ")")
            }
            Value::Set(set) | Value::FrozenSet(set) if !set.is_empty() => {
                let mut items = set.elements().into_iter().map(|(_, value)| value);
                list("{", &mut items, set.len(), "}")
            }
            Value::Dict(dict) => {
                if depth >= DEPTH_SHOWN && !dict.is_empty() {
                    return "{…}".to_owned();
                }
                let mut text = "{".to_owned();
                let entries = dict.entries().into_iter().take(ELEMENTS_SHOWN);
                for (index, (_, key, value)) in entries.enumerate() {
                    if index > 0 {
                        text.push_str(", ");
                    }
                    text.push_str(&self.text(&key, depth + 1));
                    text.push_str(": ");
                    text.push_str(&self.text(&value, depth + 1));
                    if text.len() > 4 * PREVIEW_CHARS_MAX {
                        return text + "…";
                    }
                }
                if dict.len() > ELEMENTS_SHOWN {
                    text.push_str(&format!(", … {} in all", dict.len()));
                }
                text + "}"
            }
            Value::Str(string) if string.as_str().len() > 2 * PREVIEW_CHARS_MAX => {
                let start: String = string.as_str().chars().take(PREVIEW_CHARS_MAX).collect();
                format!("{start:?}…")
            }
            other => {
                let text = self.repr_of(other, REPR_SLICES);
                text.unwrap_or_else(|| format!("<{}>", other.type_name()))
            }
        }
    }
}

/// How many things are in a value, by index and by name.
fn sizes(core: &InterpreterState, value: &Value) -> (usize, usize) {
    match value {
        Value::List(list) => (list.len(), 0),
        Value::Tuple(tuple) => (tuple.items().len(), 0),
        Value::Set(set) | Value::FrozenSet(set) => (set.len(), 0),
        Value::Dict(dict) => (0, dict.len()),
        Value::Instance(instance) => (0, instance.entries(&core.symbols).len()),
        Value::Module(module) => (0, module.namespace.entries().len()),
        _ => (0, 0),
    }
}

fn cut(text: String) -> String {
    match text.char_indices().nth(PREVIEW_CHARS_MAX) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
