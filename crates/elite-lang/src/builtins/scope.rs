//! Builtins that look at names: `globals`, `locals`, `vars`, `dir`, `eval`, `exec`, and what is refused.

use std::rc::Rc;

use super::{Args, Builtin};
use crate::errors::ExceptionKind;
use crate::eval::code::Code;
use crate::eval::{Core, Evaluator, Frame};
use crate::value::module::Namespace;
use crate::value::symbol::known;
use crate::value::{Dict, Function, R, Symbol, Value};

/// Puts them in place.
pub fn install(core: &Rc<Core>) {
    let raw: &[(&'static str, super::RawFn)] = &[
        ("globals", |ev, _| {
            Ok(Value::Dict(Rc::new(ev.globals_dict())))
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
        ("compile", super::evaluate::compile),
        ("exit", exit),
        ("quit", exit),
        ("__import__", |ev, args| match args.positional.first() {
            Some(Value::Str(name)) => ev.import(name.as_str()),
            _ => Err(ev.type_error("__import__() argument 1 must be str")),
        }),
    ];
    for (name, body) in raw {
        core.builtins
            .set(core.symbols.intern(name), Builtin::raw(name, *body));
    }
    core.builtins
        .set(known::NAME, core.symbols.value(known::MAIN));
}

fn exit(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    Err(ev.raise_args(ExceptionKind::SystemExit, args.positional.to_vec()))
}

impl Evaluator<'_> {
    /// The global variables as a dictionary; changes to it do not reach the program.
    pub fn globals_dict(&self) -> Dict {
        let dict = Dict::new();
        for (name, value) in self.core.globals.entries() {
            dict.set_interned(self.core.symbols.value(name), value);
        }
        dict
    }

    /// Runs the code of a text whose variables are not the globals.
    pub fn run_text(&self, code: &Rc<Code>, namespace: &Rc<Namespace>) -> R {
        self.core
            .texts
            .borrow_mut()
            .push((code.clone(), namespace.clone()));
        let function = Function::plain(code.clone(), Box::default());
        let result = self.call_function(&function, &mut [], &[]);
        // Not simply the last one: another thread may be evaluating a text, too.
        let mut texts = self.core.texts.borrow_mut();
        let place = texts.iter().rposition(|(other, _)| Rc::ptr_eq(other, code));
        let over = place.map(|place| texts.remove(place));
        drop(texts);
        // With the namespace go its values, which may run script code.
        drop(over);
        result
    }

    /// The namespace of the text that the code of `frame` is from, if it is not that of the globals and the text still runs.
    pub fn text_namespace(&self, frame: &Frame<'_>) -> Option<Rc<Namespace>> {
        let texts = self.core.texts.borrow();
        let names = &frame.function.code.names;
        let mut running = texts.iter().rev();
        let (_, namespace) = running.find(|(code, _)| Rc::ptr_eq(&code.names, names))?;
        Some(namespace.clone())
    }

    /// The variables of the evaluated text that `frame` runs, if they are not the globals.
    fn text_variables(&self, frame: &Frame<'_>) -> Option<Dict> {
        let namespace = self.text_namespace(frame)?;
        let dict = Dict::new();
        for (name, value) in namespace.entries() {
            dict.set_interned(self.core.symbols.value(name), value);
        }
        Some(dict)
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

fn locals(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let dict = match &args.caller {
        Some(frame) if !ev.is_module(frame) => {
            let dict = Dict::new();
            for (name, value) in ev.frame_variables(frame) {
                dict.set_interned(ev.core.symbols.value(name), value);
            }
            dict
        }
        Some(frame) => ev
            .text_variables(frame)
            .unwrap_or_else(|| ev.globals_dict()),
        None => ev.globals_dict(),
    };
    Ok(Value::Dict(Rc::new(dict)))
}

impl Evaluator<'_> {
    /// Whether a frame runs top-level code.
    pub fn is_module(&self, frame: &Frame<'_>) -> bool {
        &*frame.function.code.name == "<module>"
    }
}

fn vars(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let Some(object) = args.positional.first() else {
        return locals(ev, args);
    };
    match object {
        Value::Module(module) => {
            let dict = Dict::new();
            for (name, value) in module.namespace.entries() {
                dict.set_interned(ev.core.symbols.value(name), value);
            }
            Ok(Value::Dict(Rc::new(dict)))
        }
        other => match ev.attribute_or_none(other, known::DICT)? {
            Some(dict) => Ok(dict),
            None => Err(ev.type_error("vars() argument must have __dict__ attribute")),
        },
    }
}

fn dir(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let mut names: Vec<Value> = Vec::new();
    match args.positional.first() {
        None => {
            if let Value::Dict(dict) = locals(ev, args)? {
                names = dict.keys();
            }
        }
        Some(object) => {
            if let Some(list) = ev.special(object, known::DIR, &mut [])? {
                names = ev.collect(&list)?;
            } else {
                match object {
                    Value::Instance(instance) => {
                        names.extend(
                            instance
                                .entries(&ev.core.symbols)
                                .into_iter()
                                .map(|(name, _)| name),
                        );
                    }
                    Value::Module(module) => {
                        names.extend(
                            module
                                .namespace
                                .entries()
                                .iter()
                                .map(|(name, _)| ev.core.symbols.value(*name)),
                        );
                    }
                    _ => {}
                }
                let class = match object {
                    Value::Class(class) => class,
                    other => ev.core.types.of(other),
                };
                for class in std::iter::once(class).chain(class.ancestors()) {
                    names.extend(
                        class
                            .own_attrs()
                            .iter()
                            .map(|(name, _)| ev.core.symbols.value(name)),
                    );
                }
            }
        }
    }
    ev.sort(&mut names, None, false)?;
    names.dedup_by(|a, b| crate::ops::hash::quick_equal(a, b) == crate::ops::hash::Equal::Yes);
    Ok(Value::list(names))
}
