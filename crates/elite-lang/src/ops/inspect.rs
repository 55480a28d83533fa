//! What functions, generators and their code show of themselves: `__code__`, `__closure__`, `gi_frame` and the like.
//!
//! Code objects are the interpreter's own (`Value::Code`); a frame is a picture of one moment.

use std::rc::Rc;

use crate::eval::Evaluator;
use crate::eval::code::{Code, CodeKind};
use crate::eval::generator::Generator;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{CellVar, Dict, Function, Instance, R, Symbol, Value};

/// `co_flags` of CPython: `*args`, `**kwargs`, generator; `CO_OPTIMIZED | CO_NEWLOCALS` are those of every function.
const OF_FUNCTIONS: i64 = 0x03;
const STAR: i64 = 0x04;
const DOUBLE_STAR: i64 = 0x08;
const NESTED: i64 = 0x10;
const GENERATOR: i64 = 0x20;

impl Evaluator<'_> {
    fn name_tuple(&self, names: impl Iterator<Item = Symbol>) -> Value {
        Value::tuple(names.map(|name| self.core.symbols.to_value(name)).collect())
    }

    /// Attributes of code objects. Variables that inner functions share are told from others, as in CPython; so a
    /// parameter that is shared is in `co_varnames` and in `co_cellvars`.
    pub(super) fn code_attribute(&self, code: &Rc<Code>, name: &str) -> Option<Value> {
        let params = &code.params;
        let count = |count: usize| Value::Int(count as i64);
        let parameters = params.names.len()
            + usize::from(params.star.is_some())
            + usize::from(params.double_star.is_some());
        let is_cell = |slot: usize| code.cells.contains(&(slot as u32));
        // Slots the interpreter has for itself have no names a script could have.
        let own = |name: Symbol| !self.core.symbols.name(name).is_empty();
        let varnames = || {
            let slots = code.slot_names.iter().enumerate();
            let plain =
                slots.filter(|(slot, name)| (*slot < parameters || !is_cell(*slot)) && own(**name));
            plain.map(|(_, name)| *name)
        };
        Some(match name {
            "co_name" => Value::str(&*code.name),
            "co_qualname" => Value::str(&*code.qualname),
            "co_argcount" => count(params.positional),
            "co_posonlyargcount" => count(params.positional_only),
            "co_kwonlyargcount" => count(params.names.len() - params.positional),
            "co_nlocals" => count(varnames().count()),
            "co_varnames" => self.name_tuple(varnames()),
            "co_cellvars" => self.name_tuple(
                code.cells
                    .iter()
                    .map(|slot| code.slot_names[*slot as usize]),
            ),
            "co_freevars" => self.name_tuple(code.free_names.iter().copied()),
            "co_filename" => Value::str(code.file.name()),
            "co_firstlineno" => count(code.file.line_of(code.span.start) as usize),
            "co_flags" => {
                let flag = |given: bool, flag: i64| if given { flag } else { 0 };
                Value::Int(
                    OF_FUNCTIONS
                        | flag(params.star.is_some(), STAR)
                        | flag(params.double_star.is_some(), DOUBLE_STAR)
                        | flag(!code.free_names.is_empty(), NESTED)
                        | flag(code.kind == CodeKind::Generator, GENERATOR),
                )
            }
            _ => return None,
        })
    }

    /// Attributes of functions that show how they were made.
    pub(super) fn made_of(&self, function: &Rc<Function>, name: &str) -> Option<Value> {
        Some(match name {
            "__code__" => Value::Code(function.code.clone()),
            "__closure__" if function.closure.is_empty() => Value::None,
            "__closure__" => {
                let cells = function.closure.iter();
                Value::tuple(cells.map(|cell| Value::Cell(cell.clone())).collect())
            }
            "__globals__" => Value::Dict(self.globals_of(&function.code)),
            "__builtins__" => Value::Dict(self.builtins_dict()),
            _ => return None,
        })
    }

    /// The value in a variable that functions share.
    pub(super) fn cell_contents(&self, cell: &CellVar) -> R {
        match cell.value.get() {
            Value::Unbound => Err(self.value_error("Cell is empty")),
            value => Ok(value),
        }
    }

    /// Attributes of generators, code, cells and what wraps functions.
    pub(super) fn inner_attribute(&self, value: &Value, name: Symbol) -> R<Option<Value>> {
        let text = self.core.symbols.name(name);
        let is_abstract = &*text == "__isabstractmethod__";
        Ok(match value {
            Value::Generator(generator) => self.generator_attribute(generator, &text),
            Value::Code(code) => self.code_attribute(code, &text),
            Value::Cell(cell) if &*text == "cell_contents" => Some(self.cell_contents(cell)?),
            Value::Property(property) if is_abstract => {
                let parts = [&property.get, &property.set, &property.delete];
                Some(Value::Bool(self.is_any_abstract(&parts, name)?))
            }
            Value::StaticMethod(function) | Value::ClassMethod(function) if is_abstract => {
                Some(Value::Bool(self.is_any_abstract(&[function], name)?))
            }
            _ => None,
        })
    }

    fn is_any_abstract(&self, parts: &[&Value], name: Symbol) -> R<bool> {
        for part in parts {
            if let Some(flag) = self.with_native_depth(|| self.attribute_or_none(part, name))?
                && self.truth(&flag)?
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Attributes of generators beside their methods.
    pub(super) fn generator_attribute(&self, generator: &Generator, name: &str) -> Option<Value> {
        let code = &generator.function.code;
        Some(match name {
            "gi_running" => Value::Bool(generator.is_running()),
            "gi_suspended" => Value::Bool(generator.is_suspended()),
            "gi_yieldfrom" => generator.delegate(),
            "gi_code" => Value::Code(code.clone()),
            "gi_frame" if generator.is_finished() => Value::None,
            "gi_frame" => {
                let frame = Instance::new(self.core.types.frame.clone(), InstancePayload::None);
                let symbols = &self.core.symbols;
                let line = match (generator.is_running(), generator.line()) {
                    (true, _) => self.core.line.get(),
                    (false, 0) => code.file.line_of(code.span.start),
                    (false, line) => line,
                };
                let locals = Dict::new();
                let names = code.slot_names.iter().zip(generator.variables());
                let names = names.map(|(name, value)| (*name, value));
                let free = code.free_names.iter().zip(&generator.function.closure);
                let free = free.map(|(name, cell)| (*name, cell.value.get()));
                for (name, value) in names.chain(free) {
                    let value = match value {
                        Value::Cell(cell) => cell.value.get(),
                        other => other,
                    };
                    if !value.is_unbound() {
                        locals.set_interned(symbols.to_value(name), value);
                    }
                }
                let entries = [
                    ("f_code", Value::Code(code.clone())),
                    ("f_lineno", Value::Int(i64::from(line))),
                    ("f_locals", Value::Dict(Rc::new(locals))),
                    ("f_globals", Value::Dict(self.globals_of(code))),
                    ("f_back", Value::None),
                ];
                for (name, value) in entries {
                    frame.set(symbols.intern(name), value, symbols);
                }
                Value::Instance(frame)
            }
            _ => return None,
        })
    }

    /// `generator.name = new`
    pub(super) fn rename_generator(
        &self,
        generator: &Generator,
        name: Symbol,
        new: Value,
    ) -> R<()> {
        match &new {
            Value::Str(_) if name == known::NAME => generator.rename(Some(new), None),
            Value::Str(_) => generator.rename(None, Some(new)),
            _ => {
                let text = self.core.symbols.name(name);
                return Err(self.type_error(format!("{text} must be set to a string object")));
            }
        }
        Ok(())
    }

    /// The defaults of keyword-only parameters as a dictionary that the function uses from now on.
    pub(super) fn keyword_defaults_dict(&self, function: &Rc<Function>) -> Value {
        if let Some(dict) = function.keyword_defaults_dict.get() {
            return dict;
        }
        let defaults = &function.keyword_defaults;
        if defaults.iter().all(Value::is_unbound) {
            return Value::None;
        }
        let dict = Dict::new();
        let params = &function.code.params;
        let names = &params.names[params.positional..];
        for (name, value) in names.iter().zip(defaults.iter()) {
            if !value.is_unbound() {
                dict.set_interned(self.core.symbols.to_value(*name), value.clone());
            }
        }
        let dict = Value::Dict(Rc::new(dict));
        self.core.note_function(function);
        function.keyword_defaults_dict.put(Some(dict.clone()));
        dict
    }
}
