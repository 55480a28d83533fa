//! `re.Match`: what a search found, and its methods.
//!
//! Searching is in the parent module.

use std::rc::Rc;

use super::{GROUP, Pattern, Spans, Subject};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::stdlib::define::{MethodDef, native_class, with_data};
use crate::value::data::{Contents, NativeData};
use crate::value::instance::InstancePayload;
use crate::value::int::Int;
use crate::value::{Dict, Instance, R, Value};

/// What was found.
pub(super) struct Match {
    pub(super) pattern: Value,
    pub(super) compiled: Rc<Pattern>,
    pub(super) text: Subject,
    pub(super) range: (usize, usize),
    pub(super) spans: Spans,
}

/// The text may be an object of a class of the script, and refer to what it likes.
impl Contents for Match {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        each(&self.pattern);
        self.text.visit(each);
    }

    fn clear(&self, _: &mut Vec<Value>) {}

    fn take(&mut self, held: &mut Vec<Value>) {
        held.push(std::mem::take(&mut self.pattern));
        held.push(self.text.take());
    }
}

impl Match {
    pub(super) fn group(&self, ev: &Evaluator<'_>, key: &Value) -> R<usize> {
        let index = match ev.unwrap_builtin(key) {
            Value::Str(name) => self.compiled.parsed.by_name.get(name.as_str()).copied(),
            // Any other key is looked for among the names.
            _ if !ev.has_index(key) => ev.hash(key).map(|_| None)?,
            _ => match ev.to_int(key)? {
                Int::Small(index) => usize::try_from(index).ok(),
                Int::Big(_) => None,
            },
        };
        let index = index.filter(|index| *index < self.spans.len());
        index.ok_or_else(|| ev.raise(ExceptionKind::IndexError, "no such group"))
    }

    pub(super) fn text_of(&self, ev: &Evaluator<'_>, group: usize, default: &Value) -> R {
        ev.charge(GROUP)?;
        match self.spans.get(group).copied().flatten() {
            Some(span) => self.text.slice(ev, span),
            None => Ok(default.clone()),
        }
    }
}

pub(super) fn with_match(ev: &Evaluator<'_>, args: &[Value], act: impl FnOnce(&Match) -> R) -> R {
    with_data(ev, &args[0], act)
}

pub(super) fn make_match(
    ev: &Evaluator<'_>,
    pattern: &Value,
    compiled: &Rc<Pattern>,
    text: &Subject,
    range: (usize, usize),
    spans: Spans,
) -> R {
    let class = match compiled.match_class.get() {
        Some(class) => class.clone(),
        None => {
            let class = native_class(ev, "_re.Match")?;
            compiled.match_class.get_or_init(|| class).clone()
        }
    };
    let found = Match {
        pattern: pattern.clone(),
        compiled: compiled.clone(),
        text: text.clone(),
        range,
        spans,
    };
    let found = InstancePayload::Object(NativeData::new(found));
    Ok(Value::Instance(Instance::new(class, found)))
}

fn side(ev: &Evaluator<'_>, args: &[Value], pick: fn((usize, usize)) -> usize) -> R {
    let zero = Value::Int(0);
    with_match(ev, args, |found| {
        let group = found.group(ev, args[1].if_given().unwrap_or(&zero))?;
        Ok(found.spans[group].map_or(Value::Int(-1), |span| found.text.index(pick(span))))
    })
}

pub(super) const MATCH: &[MethodDef] = &[
    ("group", "*groups", |ev, args| {
        with_match(ev, args, |found| {
            let wanted = args[1].as_items().unwrap_or_default();
            let text = |key: &Value| found.text_of(ev, found.group(ev, key)?, &Value::None);
            match &wanted[..] {
                [] => found.text_of(ev, 0, &Value::None),
                [key] => text(key),
                keys => Ok(Value::tuple(keys.iter().map(text).collect::<R<_>>()?)),
            }
        })
    }),
    ("__getitem__", "group /", |ev, args| {
        with_match(ev, args, |found| {
            found.text_of(ev, found.group(ev, &args[1])?, &Value::None)
        })
    }),
    ("__copy__", "", |_, args| Ok(args[0].clone())),
    ("__deepcopy__", "memo /", |_, args| Ok(args[0].clone())),
    ("groups", "default?", |ev, args| {
        let default = args[1].if_given().cloned().unwrap_or(Value::None);
        with_match(ev, args, |found| {
            Ok(Value::tuple(
                (1..found.spans.len())
                    .map(|group| found.text_of(ev, group, &default))
                    .collect::<R<_>>()?,
            ))
        })
    }),
    ("groupdict", "default?", |ev, args| {
        let default = args[1].if_given().cloned().unwrap_or(Value::None);
        with_match(ev, args, |found| {
            let dict = Dict::new();
            for (name, index) in &found.compiled.parsed.names {
                dict.set_str(name, found.text_of(ev, *index, &default)?);
            }
            Ok(Value::Dict(Rc::new(dict)))
        })
    }),
    ("start", "group? /", |ev, args| {
        side(ev, args, |span| span.0)
    }),
    ("end", "group? /", |ev, args| side(ev, args, |span| span.1)),
    ("span", "group? /", |ev, args| {
        Ok(Value::tuple(vec![
            side(ev, args, |span| span.0)?,
            side(ev, args, |span| span.1)?,
        ]))
    }),
    ("expand", "template /", |ev, args| {
        let module = ev.import("re")?;
        let expand = ev.attribute(&module, ev.core.symbols.intern("_expand"))?;
        ev.call(&expand, &mut [args[0].clone(), args[1].clone()], &[])
    }),
    ("__bool__", "", |_, _| Ok(Value::Bool(true))),
    ("__repr__", "", |ev, args| {
        with_match(ev, args, |found| {
            let (start, end) = found.spans[0].unwrap_or_default();
            let (start, end) = (
                ev.str(&found.text.index(start))?,
                ev.str(&found.text.index(end))?,
            );
            let text: String = ev
                .repr(&found.text_of(ev, 0, &Value::None)?)?
                .chars()
                .take(50)
                .collect();
            Ok(Value::str(format!(
                "<re.Match object; span=({start}, {end}), match={text}>"
            )))
        })
    }),
];
