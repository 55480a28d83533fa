//! Modules that scripts make, and objects of classes derived from `ModuleType`: these have the attributes of a module
//! as their own.

use std::rc::Rc;

use super::{constructor, methods, wrong_receiver};
use crate::eval::{Evaluator, InterpreterState};
use crate::value::symbol::known;
use crate::value::{Module, R, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let class = &core.types.module;
    constructor(core, class, "name doc?", |ev, args| {
        let namespace = ev.core.new_namespace(None);
        let Value::Str(name) = name(ev, &args[0])? else {
            return Ok(Value::None);
        };
        let name = name.as_str().into();
        let module = Value::Module(Rc::new(Module { name, namespace }));
        begin(ev, &module, args)?;
        Ok(module)
    });
    methods(
        core,
        class,
        &[("__init__", "name doc?", |ev, args| {
            name(ev, &args[1])?;
            let (module, rest) = (args[0].clone(), &args[1..]);
            begin(ev, &module, rest)?;
            Ok(Value::None)
        })],
    );
}

/// The name of a module, which is a text.
fn name(ev: &Evaluator<'_>, value: &Value) -> R {
    match ev.unwrap_builtin(value) {
        text @ Value::Str(_) => Ok(text),
        _ => {
            let found = ev.core.types.name_of_argument(value);
            let text = format!("module() argument 'name' must be str, not {found}");
            Err(ev.type_error(text))
        }
    }
}

/// Sets what a module has from the beginning.
fn begin(ev: &Evaluator<'_>, module: &Value, args: &[Value]) -> R<()> {
    let symbols = &ev.core.symbols;
    let doc = args[1].if_given().cloned().unwrap_or(Value::None);
    let parts = [
        (known::NAME, args[0].clone()),
        (known::DOC, doc),
        (symbols.intern("__package__"), Value::None),
        (symbols.intern("__loader__"), Value::None),
        (symbols.intern("__spec__"), Value::None),
    ];
    for (name, value) in parts {
        match module {
            Value::Module(module) => module.namespace.set(name, value),
            Value::Instance(instance) => {
                if value.can_hold_values() {
                    ev.core.note_instance(instance);
                }
                instance.set(name, value, symbols);
            }
            other => return Err(wrong_receiver(ev, "module", other)),
        }
    }
    Ok(())
}
