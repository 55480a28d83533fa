//! `namedtuple`: classes of tuples whose items have names.
//!
//! A class is made of closures that know its names; its instances are plain tuples of that class.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;
use std::sync::Arc;

use elite_syntax::lexer::{TokenKind, is_name};

use super::method_with;
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::stdlib::define::ModuleBuilder;
use crate::value::function::Property;
use crate::value::function::WrappedFunction;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Dict, Instance, R, ScriptCell, Symbol, Value, ValueVec};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[(
        "namedtuple",
        "typename field_names * rename? defaults? module?",
        |ev, args| {
            let (shape, defaults) = NamedTupleSpec::read(ev, args)?;
            let module = args[4].if_given().filter(|module| !module.is_none());
            Arc::new(shape).class(ev, defaults, module)
        },
    )]);
    Ok(())
}

/// Fields of one class at most. A class with some of them for each of its fields takes as long to make as that many
/// statements.
const FIELDS_MAX: usize = 1 << 16;
/// Work for a field while its class is made.
const FIELD: usize = 512;

/// What the instances of one class have in common. It holds no values: defaults are held by the methods.
struct NamedTupleSpec {
    name: String,
    fields: Vec<String>,
    symbols: Vec<Symbol>,
    /// Where each field is.
    places: HashMap<Symbol, usize>,
    /// Fields before the first one with a default.
    required: usize,
}

impl NamedTupleSpec {
    /// The shape that is asked for, and the defaults of its last fields.
    fn read(ev: &Evaluator<'_>, args: &[Value]) -> R<(Self, ValueVec)> {
        let mut fields = Self::names(ev, &args[1])?;
        let name = ev.str(&args[0])?;
        let renames = args[2]
            .if_given()
            .map_or(Ok(false), |flag| ev.truth(flag))?;
        if renames {
            let mut seen = HashSet::new();
            for (index, field) in fields.iter_mut().enumerate() {
                ev.charge(FIELD)?;
                ev.check_name(field)?;
                let is_good = is_name(field)
                    && !is_keyword(field)
                    && !field.starts_with('_')
                    && !seen.contains(field);
                if is_good {
                    seen.insert(field.clone());
                } else {
                    *field = format!("_{index}");
                }
            }
        }
        for word in [&name].into_iter().chain(&fields) {
            ev.charge(FIELD)?;
            ev.check_name(word)?;
            let problem = match () {
                () if !is_name(word) => "must be valid identifiers",
                () if is_keyword(word) => "cannot be a keyword",
                () => continue,
            };
            let word = ev.repr(&Value::str(&**word))?;
            let text = format!("Type names and field names {problem}: {word}");
            return Err(ev.value_error(text));
        }
        let mut places = HashMap::new();
        let mut symbols = ev.try_with_capacity(fields.len())?;
        for (index, field) in fields.iter().enumerate() {
            ev.charge(FIELD)?;
            let symbol = ev.core.symbols.intern(field);
            let problem = match () {
                () if field.starts_with('_') && !renames => {
                    "Field names cannot start with an underscore"
                }
                () if places.insert(symbol, index).is_some() => "Encountered duplicate field name",
                () => {
                    symbols.push(symbol);
                    continue;
                }
            };
            let field = ev.repr(&Value::str(&**field))?;
            return Err(ev.value_error(format!("{problem}: {field}")));
        }
        let defaults = match args[3].if_given().filter(|given| !given.is_none()) {
            Some(given) => ev.collect(given)?,
            None => ValueVec::default(),
        };
        let Some(required) = fields.len().checked_sub(defaults.len()) else {
            return Err(ev.type_error("Got more default values than field names"));
        };
        let shape = NamedTupleSpec {
            places,
            symbols,
            name,
            fields,
            required,
        };
        Ok((shape, defaults))
    }

    /// The names of the fields: a text with blanks or commas between them, or an iterable.
    fn names(ev: &Evaluator<'_>, given: &Value) -> R<Vec<String>> {
        let mut fields = Vec::new();
        let mut add = |name: String| {
            if fields.len() == FIELDS_MAX {
                return Err(ev.value_error(format!("at most {FIELDS_MAX} fields are allowed")));
            }
            fields.push(name);
            ev.charge(FIELD)
        };
        if let Value::Str(text) = ev.unwrap_builtin(given) {
            let is_between = |c: char| c == ',' || c.is_whitespace();
            let mut rest = text.as_str();
            while !rest.is_empty() {
                let length = ev.prefix_len(rest, |c| !is_between(c))?;
                if length > 0 {
                    add(ev.copy_text(&rest[..length])?)?;
                }
                rest = &rest[length..];
                rest = &rest[ev.prefix_len(rest, is_between)?..];
            }
        } else {
            let names = ev.iter(given)?;
            while let Some(name) = ev.next_at_safepoint(&names)? {
                add(ev.str(&name)?)?;
            }
        }
        Ok(fields)
    }

    /// The class.
    fn class(self: Arc<Self>, ev: &Evaluator<'_>, last: ValueVec, module: Option<&Value>) -> R {
        let symbols = &ev.core.symbols;
        let texts: Vec<Value> = self.fields.iter().map(|name| Value::str(&**name)).collect();
        let fields = Value::tuple(texts.clone());
        let defaults = Dict::new();
        for (name, value) in texts[self.required..].iter().zip(&last) {
            ev.dict_set(&defaults, name.clone(), value.clone())?;
        }
        let doc = format!("{}({})", self.name, self.fields.join(", "));
        let mut attrs = vec![
            (known::DOC, Value::str(doc)),
            (symbols.intern("__slots__"), ev.core.empty_tuple.clone()),
            (symbols.intern("_fields"), fields.clone()),
            (
                symbols.intern("_field_defaults"),
                Value::Dict(Rc::new(defaults)),
            ),
            (symbols.intern("__match_args__"), fields),
            (
                known::NEW,
                Value::StaticMethod(WrappedFunction::around(self.making(last.into()))),
            ),
            (
                symbols.intern("_make"),
                Value::ClassMethod(WrappedFunction::around(self.making_of_items())),
            ),
            (symbols.intern("_replace"), self.replacing()),
            (symbols.intern("_asdict"), self.as_dict()),
            (known::REPR, self.showing()),
            (
                symbols.intern("__getnewargs__"),
                method_with("namedtuple", "__getnewargs__", Vec::new(), |ev, _, args| {
                    Ok(ev.unwrap_builtin(receiver(ev, args)?))
                }),
            ),
        ];
        if let Some(module) = module {
            attrs.push((known::MODULE, module.clone()));
        }
        let refuse = method_with("namedtuple", "__set__", Vec::new(), |ev, _, _| {
            Err(ev.raise(ExceptionKind::AttributeError, "can't set attribute"))
        });
        for (index, symbol) in self.symbols.iter().enumerate() {
            ev.charge(FIELD)?;
            symbols.mark_used(*symbol);
            let get = method_with("namedtuple", "__get__", Vec::new(), move |ev, _, args| {
                ev.item(receiver(ev, args)?, &Value::Int(index as i64))
            });
            let doc = Value::str(format!("Alias for field number {index}"));
            let property = Property::of(get, refuse.clone(), refuse.clone(), doc);
            attrs.push((*symbol, Value::Property(Rc::new(property))));
        }
        let tuple = Value::Class(ev.core.types.tuple.clone());
        let class = ev.make_class(&self.name, &[tuple], attrs)?;
        class.set_slots(&[]);
        Ok(Value::Class(class))
    }

    /// `__new__`
    fn making(self: &Arc<Self>, defaults: Vec<Value>) -> Value {
        let shape = self.clone();
        method_with(
            "namedtuple",
            "__new__",
            defaults,
            move |ev, defaults, args| {
                let (class, given) = class_and_rest(ev, args)?;
                let mut values = ValueVec::from(ev.try_with_capacity(shape.fields.len())?);
                ev.copy_values(given, &mut values)?;
                if !args.keywords.is_empty() || values.len() != shape.fields.len() {
                    shape.complete(ev, &mut values, args.keywords, defaults)?;
                }
                Ok(instance(&class, values.into()))
            },
        )
    }

    /// Adds what is given by name or has a default to what is given by position.
    fn complete(
        &self,
        ev: &Evaluator<'_>,
        values: &mut Vec<Value>,
        keywords: &[(Symbol, Value)],
        defaults: &[Value],
    ) -> R<()> {
        let refuse = |text: String| ev.type_error(format!("{}.__new__() {text}", self.name));
        let given = values.len();
        if given > self.fields.len() {
            // The class counts as an argument.
            let most = self.fields.len() + 1;
            let takes = match defaults.len() {
                0 => format!("{most}"),
                _ => format!("from {} to {most}", self.required + 1),
            };
            let (plural, given) = (if most == 1 { "" } else { "s" }, given + 1);
            return Err(refuse(format!(
                "takes {takes} positional argument{plural} but {given} were given"
            )));
        }
        for (name, _) in keywords {
            let (found, text) = (self.places.get(name), ev.core.symbols.name(*name));
            match found {
                Some(index) if *index < given => {
                    return Err(refuse(format!("got multiple values for argument '{text}'")));
                }
                Some(_) => {}
                None => {
                    let text = format!("got an unexpected keyword argument '{text}'");
                    return Err(refuse(text));
                }
            }
        }
        let mut missing = Vec::new();
        let named: HashMap<Symbol, &Value> = keywords
            .iter()
            .map(|(name, value)| (*name, value))
            .collect();
        for index in given..self.fields.len() {
            ev.charge(WORK_PER_VALUE)?;
            let default = index
                .checked_sub(self.required)
                .and_then(|at| defaults.get(at));
            let named = named.get(&self.symbols[index]).copied();
            match named.or(default) {
                Some(value) => values.push(value.clone()),
                None => missing.push(format!("'{}'", self.fields[index])),
            }
        }
        match missing.is_empty() {
            true => Ok(()),
            false => Err(refuse(missing_arguments(&missing))),
        }
    }

    /// `_make`
    fn making_of_items(self: &Arc<Self>) -> Value {
        let count = self.fields.len();
        method_with("namedtuple", "_make", Vec::new(), move |ev, _, args| {
            let (class, given) = class_and_rest(ev, args)?;
            let ([items], []) = (given, args.keywords) else {
                return Err(ev.type_error("_make() takes one iterable"));
            };
            let values = ev.collect(items)?;
            if values.len() != count {
                let got = values.len();
                return Err(ev.type_error(format!("Expected {count} arguments, got {got}")));
            }
            Ok(instance(&class, values.into()))
        })
    }

    /// `_replace`
    fn replacing(self: &Arc<Self>) -> Value {
        let shape = self.clone();
        method_with("namedtuple", "_replace", Vec::new(), move |ev, _, args| {
            let receiver = receiver(ev, args)?.clone();
            if args.positional.len() > 1 {
                let text = "_replace() takes 1 positional argument; give the fields by name";
                return Err(ev.type_error(text));
            }
            let mut values = ev.collect(&ev.unwrap_builtin(&receiver))?;
            let mut unknown = Vec::new();
            for (name, value) in args.keywords {
                let index = shape.places.get(name);
                match index.and_then(|index| values.get_mut(*index)) {
                    Some(place) => *place = value.clone(),
                    None => unknown.push(ev.core.symbols.to_value(*name)),
                }
            }
            if !unknown.is_empty() {
                let names = ev.repr(&Value::list(unknown))?;
                return Err(ev.value_error(format!("Got unexpected field names: {names}")));
            }
            let make = ev.attribute(&receiver, ev.core.symbols.intern("_make"))?;
            ev.call1(&make, values.into_list())
        })
    }

    /// `_asdict`
    fn as_dict(self: &Arc<Self>) -> Value {
        let shape = self.clone();
        method_with("namedtuple", "_asdict", Vec::new(), move |ev, _, args| {
            let values = ev.collect(&ev.unwrap_builtin(receiver(ev, args)?))?;
            let dict = Dict::new();
            for (name, value) in shape.symbols.iter().zip(values) {
                ev.charge(2 * WORK_PER_VALUE)?;
                ev.dict_set(&dict, ev.core.symbols.to_value(*name), value)?;
            }
            let dict = Value::Dict(Rc::new(dict));
            ev.core.gc_track(&dict);
            Ok(dict)
        })
    }

    /// `__repr__`
    fn showing(self: &Arc<Self>) -> Value {
        let shape = self.clone();
        method_with("namedtuple", "__repr__", Vec::new(), move |ev, _, args| {
            let receiver = receiver(ev, args)?;
            let mut text = format!("{}(", ev.core.types.of(receiver).name());
            let values = ev.collect(&ev.unwrap_builtin(receiver))?;
            for (index, (name, value)) in shape.fields.iter().zip(values).enumerate() {
                let before = if index > 0 { ", " } else { "" };
                let value = ev.repr(&value)?;
                ev.push_text(&mut text, before)?;
                ev.push_text(&mut text, name)?;
                ev.push_text(&mut text, "=")?;
                ev.push_text(&mut text, &value)?;
            }
            Ok(Value::str(text + ")"))
        })
    }
}

/// A tuple of the class.
fn instance(class: &Rc<Class>, values: Vec<Value>) -> Value {
    let payload = InstancePayload::Value(ScriptCell::new(Value::tuple(values)));
    Value::Instance(Instance::new(class.clone(), payload))
}

fn receiver<'a>(ev: &Evaluator<'_>, args: &'a Args<'_>) -> R<&'a Value> {
    match args.positional.first() {
        Some(receiver) if matches!(ev.unwrap_builtin(receiver), Value::Tuple(_)) => Ok(receiver),
        _ => Err(ev.type_error("a method of a named tuple needs one as its first argument")),
    }
}

fn class_and_rest<'a>(ev: &Evaluator<'_>, args: &'a Args<'_>) -> R<(Rc<Class>, &'a [Value])> {
    let tuple = &ev.core.types.tuple;
    match args.positional.split_first() {
        Some((Value::Class(class), rest)) if class.is_subclass_of(tuple) && class.is_script => {
            Ok((class.clone(), rest))
        }
        _ => Err(ev.type_error("a class of named tuples is needed as the first argument")),
    }
}

fn is_keyword(text: &str) -> bool {
    TokenKind::keyword(text).is_some()
}

/// What CPython says of arguments that a function needs, by their names in quotes.
pub fn missing_arguments(names: &[impl AsRef<str>]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    let listed = match &names[..] {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [one, two] => format!("{one} and {two}"),
        [more @ .., last] => format!("{}, and {last}", more.join(", ")),
    };
    let plural = if names.len() == 1 { "" } else { "s" };
    let count = names.len();
    format!("missing {count} required positional argument{plural}: {listed}")
}
