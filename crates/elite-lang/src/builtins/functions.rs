//! Builtin functions on values of any kind.

use std::rc::Rc;

use elite_syntax::ast::CompareOp;

use super::{Args, Builtin};
use crate::errors::ExceptionKind;
use crate::eval::generator::{GeneratorInput, StepResult};
use crate::eval::{Evaluator, InterpreterState};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::symbol::{TempSymbol, known};
use crate::value::{Class, Iter, R, Symbol, Value};

/// Items that are added up at once.
const SUM_INLINE_MAX: usize = 4096;

/// Puts the builtin functions in place.
pub fn install(core: &Rc<InterpreterState>) {
    let bound: &[(&'static str, &str, super::BoundFn)] = &[
        ("all", "iterable /", all),
        ("any", "iterable /", any),
        ("ascii", "obj /", |ev, args| {
            let text = ev.repr_value(&args[0])?;
            match ev.unwrap_builtin(&text) {
                Value::Str(plain) if !plain.is_ascii() => {
                    ev.new_str(ev.escaped_beyond_ascii(plain.as_str())?)
                }
                _ => Ok(text),
            }
        }),
        ("callable", "obj /", callable),
        ("delattr", "obj name /", delattr),
        ("format", "value format_spec? /", format),
        ("getattr", "object name default? /", getattr),
        ("hasattr", "obj name /", hasattr),
        ("hash", "obj /", |ev, args| {
            ev.hash(&args[0]).map(|hash| Value::Int(hash as i64))
        }),
        ("id", "obj /", id),
        ("isinstance", "obj class_or_tuple /", isinstance),
        ("issubclass", "cls class_or_tuple /", issubclass),
        ("iter", "object sentinel? /", iter),
        ("len", "obj /", |ev, args| {
            ev.len(&args[0]).map(|length| Value::Int(length as i64))
        }),
        ("next", "iterator default? /", next),
        ("repr", "obj /", |ev, args| ev.repr_value(&args[0])),
        ("setattr", "obj name value /", setattr),
        (
            "compile",
            "source filename mode flags? dont_inherit? optimize? * _feature_version?",
            super::compile::compile,
        ),
        ("sorted", "iterable / * key? reverse?", sorted),
        ("sum", "iterable / start?", sum),
    ];
    for (name, signature, body) in bound {
        core.builtins.set(
            core.symbols.intern(name),
            Builtin::bound(core, name, signature, *body),
        );
    }
    let raw: &[(&'static str, super::RawFn)] = &[("print", print), ("max", max), ("min", min)];
    for (name, body) in raw {
        core.builtins
            .set(core.symbols.intern(name), Builtin::raw(name, *body));
    }
    super::numbers::install(core);
    super::scope::install(core);
}

fn print(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let option = |name: Symbol, default: &str| -> R<String> {
        match args.keyword(name) {
            None | Some(Value::None) => Ok(default.to_owned()),
            Some(value) => match ev.unwrap_builtin(value) {
                Value::Str(text) => ev.copy_text(text.as_str()),
                other => {
                    let (name, type_name) =
                        (ev.core.symbols.name(name), ev.core.types.name_of(&other));
                    Err(ev.type_error(format!("{name} must be None or a string, not {type_name}")))
                }
            },
        }
    };
    for (name, _) in args.keywords {
        if ![known::SEP, known::END, known::FILE, known::FLUSH].contains(name) {
            let name = ev.core.symbols.name(*name);
            return Err(ev.type_error(format!(
                "'{name}' is an invalid keyword argument for print()"
            )));
        }
    }
    let (sep, end) = (option(known::SEP, " ")?, option(known::END, "\n")?);
    let file = match args.keyword(known::FILE) {
        None | Some(Value::None) => redirected_stdout(ev),
        Some(file) => Some(file.clone()),
    };
    if let Some(file) = file {
        return print_into(ev, &file, args, Value::str(sep), Value::str(end));
    }
    let mut text = String::new();
    for (index, value) in args.positional.iter().enumerate() {
        ev.push_text(&mut text, if index > 0 { &sep } else { "" })?;
        match value {
            Value::Str(part) => ev.push_text(&mut text, part.as_str())?,
            other => ev.push_text(&mut text, &ev.str(other)?)?,
        }
    }
    ev.push_text(&mut text, &end)?;
    ev.print(&text)?;
    Ok(Value::None)
}

/// `print` into an object of a script: it gets every piece by itself, as from CPython.
fn print_into(ev: &Evaluator<'_>, file: &Value, args: &Args<'_>, sep: Value, end: Value) -> R {
    let put = |piece: Value| -> R {
        let write = ev.attribute(file, ev.core.symbols.intern("write"))?;
        ev.call1(&write, piece)
    };
    for (index, value) in args.positional.iter().enumerate() {
        if index > 0 {
            put(sep.clone())?;
        }
        put(match value {
            Value::Str(_) => value.clone(),
            other => ev.str_value(other)?,
        })?;
    }
    put(end)?;
    if let Some(flag) = args.keyword(known::FLUSH)
        && ev.truth(flag)?
    {
        let flush = ev.attribute(file, known::FLUSH)?;
        ev.call(&flush, &mut [], &[])?;
    }
    Ok(Value::None)
}

/// What a program has put in the place of `sys.stdout`.
fn redirected_stdout(ev: &Evaluator<'_>) -> Option<Value> {
    let modules = ev.core.modules.borrow();
    let sys = modules.iter().find(|module| &*module.name == "sys")?;
    let get = |name| sys.namespace.get(ev.core.symbols.intern(name));
    let (now, own) = (get("stdout")?, get("__stdout__")?);
    (!now.is(&own)).then_some(now)
}

fn all(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let iterator = ev.iter(&args[0])?;
    while let Some(value) = ev.next_at_safepoint(&iterator)? {
        if !ev.truth(&value)? {
            return Ok(Value::Bool(false));
        }
    }
    Ok(Value::Bool(true))
}

fn any(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let iterator = ev.iter(&args[0])?;
    while let Some(value) = ev.next_at_safepoint(&iterator)? {
        if ev.truth(&value)? {
            return Ok(Value::Bool(true));
        }
    }
    Ok(Value::Bool(false))
}

fn callable(_: &Evaluator<'_>, args: &mut [Value]) -> R {
    Ok(Value::Bool(args[0].is_callable()))
}

/// The symbol of an attribute name given as a value.
fn attribute_name<'e>(ev: &'e Evaluator<'_>, name: &Value) -> R<TempSymbol<'e>> {
    match ev.unwrap_builtin(name) {
        Value::Str(text) => ev.temp_symbol(text.as_str()),
        _ => {
            let type_name = ev.core.types.name_of(name);
            let text = format!("attribute name must be string, not '{type_name}'");
            Err(ev.type_error(text))
        }
    }
}

fn getattr(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let name = attribute_name(ev, &args[1])?;
    match args[2].if_given() {
        None => ev.attribute(&args[0], *name),
        Some(default) => {
            let found = ev.attribute_or_none(&args[0], *name)?;
            Ok(found.unwrap_or_else(|| default.clone()))
        }
    }
}

fn hasattr(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let name = attribute_name(ev, &args[1])?;
    let found = ev.attribute_or_none(&args[0], *name)?;
    Ok(Value::Bool(found.is_some()))
}

fn setattr(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let name = attribute_name(ev, &args[1])?;
    ev.set_attribute(&args[0], *name, args[2].clone())
        .map(|()| Value::None)
}

fn delattr(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let name = attribute_name(ev, &args[1])?;
    ev.delete_attribute(&args[0], *name).map(|()| Value::None)
}

fn format(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let spec = match args[1].if_given() {
        None => String::new(),
        Some(given) => match ev.unwrap_builtin(given) {
            Value::Str(text) => ev.copy_text(text.as_str())?,
            _ => {
                let name = ev.core.types.name_of_argument(given);
                return Err(ev.type_error(format!("format() argument 2 must be str, not {name}")));
            }
        },
    };
    ev.format_value(&args[0], &spec)
}

fn id(_: &Evaluator<'_>, args: &mut [Value]) -> R {
    Ok(Value::Int(match &args[0] {
        Value::None => 16,
        Value::Bool(flag) => 32 + i64::from(*flag),
        Value::Int(int) => int.wrapping_mul(32).wrapping_add(1 << 40),
        Value::Float(float) => float.to_bits() as i64 >> 1,
        // What there is once.
        Value::Str(text) if text.as_str().is_empty() => 48,
        Value::Bytes(bytes) if bytes.data().is_empty() => 64,
        Value::Tuple(tuple) if tuple.items().is_empty() => 80,
        other => other.address().unwrap_or(8) as i64,
    }))
}

impl Evaluator<'_> {
    /// Python's `isinstance(value, classes)`.
    pub fn is_instance(&self, value: &Value, classes: &Value) -> R<bool> {
        match classes {
            Value::Class(class) => {
                if !Rc::ptr_eq(self.core.types.of(value), class)
                    && let Some(check) = class.meta_method(known::INSTANCE_CHECK)
                {
                    let answer = self.call_method_value(&check, classes, &mut [value.clone()])?;
                    return self.truth(&answer);
                }
                self.is_plain_instance(value, class)
            }
            Value::Tuple(tuple) => self.with_native_depth(|| {
                for class in tuple.items() {
                    self.charge(WORK_PER_VALUE)?;
                    if self.is_instance(value, class)? {
                        return Ok(true);
                    }
                }
                Ok(false)
            }),
            other => match self.union_types(other).or_else(|| self.tuple_of(other)) {
                Some(types) => self.is_instance(value, &types),
                None => match self.answer_of(other, known::INSTANCE_CHECK, value)? {
                    Some(answer) => Ok(answer),
                    None if self.has_bases(other)? => Ok(false),
                    None => Err(self.type_error(
                        "isinstance() arg 2 must be a type, a tuple of types, or a union",
                    )),
                },
            },
        }
    }

    /// Whether a value is of a class or says with its `__class__` that it is.
    fn is_plain_instance(&self, value: &Value, class: &Class) -> R<bool> {
        let own = self.core.types.of(value);
        if own.is_subclass_of(class) {
            return Ok(true);
        }
        let says = own.is_script
            && matches!(value, Value::Instance(_))
            && (own.lookup(known::CLASS).is_some() || own.lookup(known::GETATTRIBUTE).is_some());
        match says {
            true => match self.attribute_or_none(value, known::CLASS)? {
                Some(Value::Class(said)) => Ok(said.is_subclass_of(class)),
                _ => Ok(false),
            },
            false => Ok(false),
        }
    }

    /// The tuple that an instance of a class derived from it is.
    fn tuple_of(&self, value: &Value) -> Option<Value> {
        Some(self.unwrap_builtin(value)).filter(|plain| matches!(plain, Value::Tuple(_)))
    }

    /// Whether an object says that it has bases, so that it counts as a class of which nothing is an instance.
    fn has_bases(&self, value: &Value) -> R<bool> {
        let found = match value {
            Value::Instance(_) => self.attribute_or_none(value, known::BASES)?,
            _ => None,
        };
        Ok(matches!(found, Some(Value::Tuple(_))))
    }

    /// What an object that stands for a class says of a value; None if it has no such method.
    fn answer_of(&self, judge: &Value, name: Symbol, value: &Value) -> R<Option<bool>> {
        match self.special(judge, name, &mut [value.clone()])? {
            Some(answer) => self.truth(&answer).map(Some),
            None => Ok(None),
        }
    }

    /// Python's `issubclass(class, classes)`.
    pub fn is_subclass(&self, class: &Rc<Class>, classes: &Value) -> R<bool> {
        match classes {
            Value::Class(other) => {
                if let Some(check) = other.meta_method(known::SUBCLASS_CHECK) {
                    let class = Value::Class(class.clone());
                    let answer = self.call_method_value(&check, classes, &mut [class])?;
                    return self.truth(&answer);
                }
                Ok(class.is_subclass_of(other))
            }
            Value::Tuple(tuple) => self.with_native_depth(|| {
                for other in tuple.items() {
                    self.charge(WORK_PER_VALUE)?;
                    if self.is_subclass(class, other)? {
                        return Ok(true);
                    }
                }
                Ok(false)
            }),
            other => match self.union_types(other).or_else(|| self.tuple_of(other)) {
                Some(types) => self.is_subclass(class, &types),
                None => {
                    let class = Value::Class(class.clone());
                    match self.answer_of(other, known::SUBCLASS_CHECK, &class)? {
                        Some(answer) => Ok(answer),
                        None if self.has_bases(other)? => Ok(false),
                        None => Err(self.type_error(
                            "issubclass() arg 2 must be a class, a tuple of classes, or a union",
                        )),
                    }
                }
            },
        }
    }
}

fn isinstance(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    ev.is_instance(&args[0], &args[1]).map(Value::Bool)
}

fn issubclass(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    match &args[0] {
        Value::Class(class) => ev.is_subclass(class, &args[1]).map(Value::Bool),
        // The classes are looked at one by one.
        _ if matches!(&args[1], Value::Tuple(classes) if classes.items().is_empty()) => {
            Ok(Value::Bool(false))
        }
        _ => Err(ev.type_error("issubclass() arg 1 must be a class")),
    }
}

fn iter(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    match args[1].if_given() {
        None => ev.iter(&args[0]),
        Some(sentinel) => {
            if !ev.truth(&callable(ev, &mut [args[0].clone()])?)? {
                return Err(ev.type_error("iter(v, w): v must be callable"));
            }
            let (function, sentinel) = (args[0].clone(), sentinel.clone());
            Ok(Value::Iter(Rc::new(Iter::Callable {
                function,
                sentinel,
                done: false.into(),
            })))
        }
    }
}

fn next(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let result = match &args[0] {
        Value::Generator(generator) => {
            match ev.step_generator(generator, GeneratorInput::Send(Value::None)) {
                Ok(StepResult::Yielded(value)) => return Ok(value),
                Ok(StepResult::Returned(value)) => Err(value),
                Err(raised) => return Err(ev.generator_error(raised)),
            }
        }
        other => {
            let is_iterator = matches!(other, Value::Iter(_))
                || matches!(other, Value::Instance(_))
                    && ev.core.types.of(other).lookup(known::NEXT).is_some();
            if !is_iterator {
                return Err(not_an_iterator(ev, other));
            }
            // The exception of the script's own `__next__`, or of what an iterator calls, is kept with its value.
            match (ev.next_with_end(other), args[1].if_given()) {
                (Ok(value), _) => value.ok_or(Value::None),
                (Err(raised), Some(default))
                    if ev.is_kind(&raised, ExceptionKind::StopIteration) =>
                {
                    return Ok(default.clone());
                }
                (Err(raised), _) => return Err(raised),
            }
        }
    };
    match (result, args[1].if_given()) {
        (Ok(value), _) => Ok(value),
        (Err(_), Some(default)) => Ok(default.clone()),
        (Err(value), None) => ev.stop_iteration(value),
    }
}

fn not_an_iterator(ev: &Evaluator<'_>, value: &Value) -> crate::value::Unwind {
    ev.type_error(format!(
        "'{}' object is not an iterator",
        ev.core.types.name_of(value)
    ))
}

fn sorted(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let mut items = ev.collect(&args[0])?;
    let reverse = match args[2].if_given() {
        Some(value) => ev.c_int(value)? != 0,
        None => false,
    };
    ev.sort(&mut items, args[1].if_given(), reverse)?;
    Ok(items.into_list())
}

fn sum(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let iterator = ev.iter(&args[0])?;
    let mut total = args[1].if_given().cloned().unwrap_or(Value::Int(0));
    let wrong = match ev.unwrap_builtin(&total) {
        Value::Str(_) => Some("sum() can't sum strings [use ''.join(seq) instead]"),
        Value::Bytes(_) => Some("sum() can't sum bytes [use b''.join(seq) instead]"),
        Value::ByteArray(_) => Some("sum() can't sum bytearray [use b''.join(seq) instead]"),
        _ => None,
    };
    if let Some(text) = wrong {
        return Err(ev.type_error(text));
    }
    if let Some(sum) = sum_of_numbers(ev, &args[0], &total)? {
        return Ok(sum);
    }
    while let Some(value) = ev.next_at_safepoint(&iterator)? {
        total = match crate::ops::arith::fast(elite_syntax::ast::BinaryOp::Add, &total, &value) {
            Some(total) => total,
            None => ev.binary(elite_syntax::ast::BinaryOp::Add, &total, &value)?,
        };
    }
    Ok(total)
}

/// The sum of a short list or tuple of nothing but numbers that fit; None for anything else.
fn sum_of_numbers(ev: &Evaluator<'_>, items: &Value, start: &Value) -> R<Option<Value>> {
    let sum = |items: &[Value]| {
        let mut total = start.clone();
        for item in items {
            total = crate::ops::arith::fast(elite_syntax::ast::BinaryOp::Add, &total, item)?;
        }
        Some(total)
    };
    let (sum, length) = match items {
        Value::List(list) if list.len() <= SUM_INLINE_MAX => (sum(&list.borrow()), list.len()),
        Value::Tuple(tuple) if tuple.items().len() <= SUM_INLINE_MAX => {
            (sum(tuple.items()), tuple.items().len())
        }
        _ => return Ok(None),
    };
    ev.charge(length * WORK_PER_VALUE)?;
    Ok(sum)
}

fn max(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    extreme(ev, args, "max", CompareOp::Gt)
}

fn min(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    extreme(ev, args, "min", CompareOp::Lt)
}

/// The first value that compares `better` than all others.
fn extreme(ev: &Evaluator<'_>, args: &mut Args<'_>, name: &str, better: CompareOp) -> R {
    if args.positional.is_empty() {
        return Err(ev.type_error(format!("{name} expected at least 1 argument, got 0")));
    }
    for (keyword, _) in args.keywords {
        if ![known::KEY, known::DEFAULT].contains(keyword) {
            let keyword = ev.core.symbols.name(*keyword);
            return Err(ev.type_error(format!(
                "'{keyword}' is an invalid keyword argument for {name}()"
            )));
        }
    }
    let key = args.keyword(known::KEY).filter(|key| !key.is_none());
    let default = args.keyword(known::DEFAULT);
    let mut best: Option<(Value, Value)> = None;
    let mut consider = |value: Value| -> R<()> {
        let measure = match key {
            Some(key) => ev.call1(key, value.clone())?,
            None => value.clone(),
        };
        let wins = match &best {
            None => true,
            Some((_, other)) => match crate::ops::compare::fast(better, &measure, other) {
                Some(wins) => wins,
                None => ev.compare_truth(better, &measure, other)?,
            },
        };
        if wins {
            best = Some((value, measure));
        }
        Ok(())
    };
    match &*args.positional {
        [iterable] => {
            let iterator = ev.iter(iterable)?;
            while let Some(value) = ev.next_at_safepoint(&iterator)? {
                consider(value)?;
            }
        }
        values => {
            if default.is_some() {
                let text = format!(
                    "Cannot specify a default for {name}() with multiple positional arguments"
                );
                return Err(ev.type_error(text));
            }
            for value in values {
                ev.charge(WORK_PER_VALUE)?;
                consider(value.clone())?;
            }
        }
    }
    match (best, default) {
        (Some((value, _)), _) => Ok(value),
        (None, Some(default)) => Ok(default.clone()),
        (None, None) => Err(ev.value_error(format!("{name}() arg is an empty sequence"))),
    }
}
