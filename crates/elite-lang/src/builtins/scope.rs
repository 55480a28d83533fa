//! Builtins that look at names: `globals`, `locals`, `vars`, `dir`, `eval`, `exec`, and what is refused.

use std::rc::Rc;

use super::types::descriptor::hidden_names;
use super::{Args, Builtin};
use crate::errors::ExceptionKind;
use crate::eval::code::Code;
use crate::eval::run::with_slots;
use crate::eval::stmt::layout;
use crate::eval::{Evaluator, Frame, InterpreterState};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::ops::dict::WORK_PER_NAME;
use crate::ops::hash::{Equality, quick_equal};
use crate::value::class::BuiltinBase;
use crate::value::dict::REHASH_CHUNK;
use crate::value::module::Namespace;
use crate::value::symbol::known;
use crate::value::{Dict, Function, Module, R, Symbol, Value, ValueVec};

/// Puts them in place.
pub fn install(core: &Rc<InterpreterState>) {
    let raw: &[(&'static str, super::RawFn)] = &[
        ("globals", |ev, args| {
            takes_none(ev, args, "globals")?;
            Ok(Value::Dict(match &args.caller {
                Some(frame) => ev.globals_of(&frame.function.code),
                None => ev.globals_dict(),
            }))
        }),
        ("locals", locals),
        ("vars", vars),
        ("dir", dir),
        ("input", |ev, _| {
            Err(ev.raise(
                ExceptionKind::EOFError,
                "a script on the controller has no standard input",
            ))
        }),
        // `io` checks the permission.
        ("open", |ev, args| {
            let io = ev.import("io")?;
            let open = ev.attribute(&io, ev.core.symbols.intern("open"))?;
            ev.call(&open, args.positional, args.keywords)
        }),
        ("eval", super::evaluate::eval),
        ("exec", super::evaluate::exec),
        ("exit", exit),
        ("quit", exit),
        ("__import__", import),
    ];
    for (name, body) in raw {
        core.builtins
            .set(core.symbols.intern(name), Builtin::raw(name, *body));
    }
    core.builtins
        .set(known::NAME, core.symbols.to_value(known::MAIN));
    core.builtins.set(known::DOC, Value::None);
    for (name, namespace) in [("__main__", &core.globals), ("builtins", &core.builtins)] {
        let module = Rc::new(Module {
            name: name.into(),
            namespace: namespace.clone(),
        });
        if name == "builtins" {
            let name = core.symbols.intern("__builtins__");
            core.builtins.set(name, Value::Module(module.clone()));
        }
        core.module_table.set_str(name, Value::Module(module));
    }
}

/// `__import__(name, globals, locals, fromlist, level)`: of a dotted name the first part, unless something is asked
/// from it.
fn import(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let named = |wanted: &str| {
        let mut keywords = args.keywords.iter();
        keywords.find(|(name, _)| &*ev.core.symbols.name(*name) == wanted)
    };
    let argument = |place: usize, name: &str| match args.positional.get(place) {
        Some(value) => Some(value.clone()),
        None => named(name).map(|(_, value)| value.clone()),
    };
    let Some(name) = argument(0, "name") else {
        return Err(ev.type_error("__import__() missing required argument 'name' (pos 1)"));
    };
    let Value::Str(name) = ev.unwrap_builtin(&name) else {
        return Err(ev.type_error("module name must be a string"));
    };
    let level = match argument(4, "level") {
        Some(level) => ev.index(&level)?,
        None => 0,
    };
    if level < 0 {
        return Err(ev.value_error("level must be >= 0"));
    }
    if level > 0 {
        return ev.import(".");
    }
    let from_list = match argument(3, "fromlist") {
        Some(list) => ev.truth(&list)?,
        None => false,
    };
    let module = ev.import(name.as_str())?;
    match name.as_str().split_once('.') {
        Some((first, _)) if !from_list => ev.import(first),
        _ => Ok(module),
    }
}

fn exit(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    Err(ev.raise_args(ExceptionKind::SystemExit, args.positional.to_vec()))
}

impl Evaluator<'_> {
    /// The global variables as the dictionary that scripts have of them: both are the same variables.
    pub fn globals_dict(&self) -> Rc<Dict> {
        let globals = &self.core.globals;
        if globals.shown().is_none() {
            let dict = Rc::new(Dict::new());
            let own = [
                ("__name__", self.core.symbols.to_value(known::MAIN)),
                ("__doc__", Value::None),
                ("__builtins__", self.builtins_module()),
            ];
            for (name, value) in &own {
                dict.set_str(name, value.clone());
            }
            globals.attach_dict(dict.clone(), &self.core.symbols);
            // A name that the program mentions has a variable of its own, which was not bound yet.
            for (name, value) in own {
                if dict.get_str(name).is_none() {
                    dict.set_str(name, value);
                }
            }
        }
        self.namespace_dict(globals)
    }

    /// The builtins as the dictionary that scripts have of them.
    pub fn builtins_dict(&self) -> Rc<Dict> {
        self.namespace_dict(&self.core.builtins)
    }

    /// The module `builtins`.
    pub fn builtins_module(&self) -> Value {
        let name = self.core.symbols.intern("__builtins__");
        self.core.builtins.get(name).unwrap_or_default()
    }

    /// The dictionary of a namespace.
    pub fn namespace_dict(&self, namespace: &Namespace) -> Rc<Dict> {
        match namespace.shown() {
            Some(dict) => dict,
            None => {
                let dict = Rc::new(Dict::new());
                namespace.attach_dict(dict.clone(), &self.core.symbols);
                dict
            }
        }
    }

    /// The global variables of some code: those of its text, of its module, or of the program.
    pub fn globals_of(&self, code: &Code) -> Rc<Dict> {
        if let Some(home) = code.refs.home() {
            return home;
        }
        match code.module.as_ref().and_then(std::rc::Weak::upgrade) {
            Some(namespace) if !Rc::ptr_eq(&namespace, &self.core.globals) => {
                self.namespace_dict(&namespace)
            }
            _ => self.globals_dict(),
        }
    }

    /// Runs the code of a text whose variables are not the globals.
    pub fn run_text(
        &self,
        code: &Rc<Code>,
        namespace: &Rc<Namespace>,
        mapping: Option<&Value>,
    ) -> R {
        self.core
            .eval_stack
            .borrow_mut()
            .push((code.clone(), namespace.clone()));
        let function = Function::without_defaults(code.clone(), Box::default());
        let result = with_slots(code.slots, |slots| {
            if let (Some(slot), Some(mapping)) = (slots.last_mut(), mapping) {
                *slot = mapping.clone();
            }
            self.run(&function, slots)
        });
        // Not simply the last one: another thread may be evaluating a text, too.
        let mut texts = self.core.eval_stack.borrow_mut();
        let place = texts.iter().rposition(|(other, _)| Rc::ptr_eq(other, code));
        let over = place.map(|place| texts.remove(place));
        drop(texts);
        // With the namespace go its values, which may run script code.
        drop(over);
        result
    }

    /// The namespace of the text that the code of `frame` is from, if it is not that of the globals and the text still
    /// runs.
    pub fn text_namespace(&self, frame: &Frame<'_>) -> Option<Rc<Namespace>> {
        let texts = self.core.eval_stack.borrow();
        let names = &frame.function.code.names;
        let mut running = texts.iter().rev();
        let (_, namespace) = running.find(|(code, _)| Rc::ptr_eq(&code.names, names))?;
        Some(namespace.clone())
    }

    /// The bound local variables of a frame, cells and closure included.
    pub fn frame_variables(&self, frame: &Frame<'_>) -> Vec<(Symbol, Value)> {
        let code = &frame.function.code;
        let slots = code
            .slot_names
            .iter()
            .copied()
            .zip(frame.slots.iter().cloned());
        let free = code.free_names.iter().copied().zip(&frame.function.closure);
        let free = free.map(|(name, cell)| (name, cell.value.borrow().clone()));
        let opened = |(name, value): (Symbol, Value)| match value {
            Value::Cell(cell) => (name, cell.value.borrow().clone()),
            other => (name, other),
        };
        slots
            .map(opened)
            .chain(free)
            .filter(|(_, value)| !value.is_unbound())
            .collect()
    }
}

fn takes_none(ev: &Evaluator<'_>, args: &Args<'_>, name: &str) -> R<()> {
    match args.positional.len() + args.keywords.len() {
        0 => Ok(()),
        given => Err(ev.type_error(format!("{name}() takes no arguments ({given} given)"))),
    }
}

fn locals(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    takes_none(ev, args, "locals")?;
    locals_here(ev, args)
}

/// The local variables of the caller: at the top level those of the module or text, live; in a function a copy.
fn locals_here(ev: &Evaluator<'_>, args: &Args<'_>) -> R {
    let Some(frame) = &args.caller else {
        return Ok(Value::Dict(ev.globals_dict()));
    };
    if let Some(mapping) = ev.mapping_of(frame) {
        return Ok(mapping);
    }
    let code = &frame.function.code;
    if ev.is_module(frame) {
        return Ok(Value::Dict(match ev.text_namespace(frame) {
            Some(namespace) if namespace.shown().is_none() => {
                let dict = Dict::new();
                for name in ev.bound_names(&namespace)? {
                    ev.charge(WORK_PER_NAME)?;
                    if let Some(value) = namespace.get(name) {
                        ev.dict_set(&dict, ev.core.symbols.to_value(name), value)?;
                    }
                }
                Rc::new(dict)
            }
            _ => ev.globals_of(code),
        }));
    }
    let dict = Dict::new();
    for (name, value) in ev.frame_variables(frame) {
        dict.set_interned(ev.core.symbols.to_value(name), value);
    }
    Ok(Value::Dict(Rc::new(dict)))
}

impl Evaluator<'_> {
    /// Whether a frame runs top-level code.
    pub fn is_module(&self, frame: &Frame<'_>) -> bool {
        &*frame.function.code.name == "<module>"
    }

    /// The mapping of a script that a text runs in.
    pub fn mapping_of(&self, frame: &Frame<'_>) -> Option<Value> {
        let code = &frame.function.code;
        let has_one = self.is_module(frame) && code.slots > code.slot_names.len();
        has_one.then(|| frame.slots.last().cloned()).flatten()
    }
}

fn vars(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    if args.positional.len() > 1 {
        let given = args.positional.len();
        return Err(ev.type_error(format!("vars expected at most 1 argument, got {given}")));
    }
    let Some(object) = args.positional.first() else {
        return locals_here(ev, args);
    };
    match ev.attribute_or_none(object, known::DICT)? {
        Some(dict) => Ok(dict),
        None => Err(ev.type_error("vars() argument must have __dict__ attribute")),
    }
}

/// Names of attributes that are computed when they are asked for.
fn by_nature(object: &Value) -> &'static [&'static str] {
    match object {
        Value::Function(_) => &[
            "__annotations__",
            "__builtins__",
            "__closure__",
            "__code__",
            "__defaults__",
            "__dict__",
            "__doc__",
            "__globals__",
            "__kwdefaults__",
            "__module__",
            "__name__",
            "__qualname__",
        ],
        Value::Generator(_) => &[
            "__name__",
            "__qualname__",
            "gi_code",
            "gi_frame",
            "gi_running",
            "gi_suspended",
            "gi_yieldfrom",
        ],
        Value::Property(_) => &["__doc__", "__isabstractmethod__", "fdel", "fget", "fset"],
        _ => &[],
    }
}

fn dir(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let mut names = match args.positional.first() {
        None => {
            let here = locals_here(ev, args)?;
            ev.collect(&here)?
        }
        Some(object) => match ev.special(object, known::DIR, &mut [])? {
            Some(list) => ev.collect(&list)?,
            None => attribute_names(ev, object)?,
        },
    };
    ev.sort(&mut names, None, false)?;
    // There may be hundreds of thousands.
    let mut once = ValueVec::from(ev.try_with_capacity(names.len())?);
    for name in names {
        if !once
            .last()
            .is_some_and(|last| quick_equal(last, &name) == Equality::Yes)
        {
            once.push(name);
        }
        ev.charge(2 * WORK_PER_VALUE)?;
    }
    Ok(once.into_list())
}

/// The names of an object's own attributes and those of its class, in no order, some of them twice.
pub fn attribute_names(ev: &Evaluator<'_>, object: &Value) -> R<ValueVec> {
    let symbols = &ev.core.symbols;
    let mut names = ValueVec::default();
    match object {
        Value::Instance(instance) => match instance.dict_if_any() {
            Some(dict) => {
                for (_, name, _) in ev.collect_entries(&dict)? {
                    ev.grow(&mut *names, 1)?;
                    names.push(name);
                    ev.charge(WORK_PER_VALUE)?;
                }
            }
            None => names.extend(instance.entries(symbols).into_iter().map(|(name, _)| name)),
        },
        Value::StaticMethod(wrapped) | Value::ClassMethod(wrapped) => {
            let dict = ev.wrapped_dict(wrapped)?;
            for (_, name, _) in ev.collect_entries(&dict)? {
                ev.grow(&mut *names, 1)?;
                names.push(name);
                ev.charge(WORK_PER_VALUE)?;
            }
        }
        Value::Module(module) => {
            for name in ev.bound_names(&module.namespace)? {
                ev.grow(&mut *names, 1)?;
                names.push(symbols.to_value(name));
                ev.charge(WORK_PER_VALUE)?;
            }
        }
        _ => {}
    }
    let is_module = match object {
        Value::Module(_) => true,
        Value::Instance(instance) => instance.class.base == BuiltinBase::Module,
        _ => false,
    };
    if is_module {
        return Ok(names);
    }
    names.extend(by_nature(object).iter().copied().map(Value::str));
    let class = match object {
        Value::Class(class) => class,
        other => ev.core.types.of(other),
    };
    for class in class.mro() {
        names.extend(hidden_names(&class).map(Value::str));
        if !class.is_script && layout::has_dict(&class) {
            names.push(symbols.to_value(known::DICT));
        }
        if class.is_script {
            let added = ev.member_descriptors(&class)?;
            ev.grow(&mut *names, added.len())?;
            names.extend(added.iter().map(|(name, _)| symbols.to_value(*name)));
        }
        if std::ptr::eq(&*class, &*ev.core.types.object) {
            let natural = ev.core.types.natural.own_attrs();
            let natural = natural.names().iter().copied();
            let all = natural.chain([known::CLASS, known::DOC]);
            names.extend(all.map(|name| symbols.to_value(name)));
        }
        let (mut from, mut more) = (0, true);
        while more {
            let mut some = ValueVec::default();
            more = class
                .own_attrs()
                .entries_chunk(from, REHASH_CHUNK, &mut some);
            from += REHASH_CHUNK;
            ev.grow(&mut *names, some.len())?;
            for (name, _) in some {
                names.push(symbols.to_value(name));
                ev.charge(WORK_PER_NAME)?;
            }
        }
    }
    Ok(names)
}
