//! `repr` of values.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::rc::Rc;

use crate::eval::Evaluator;
use crate::format::float;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::class::BuiltinBase;
use crate::value::symbol::known;
use crate::value::{Dict, Instance, Iter, R, Value, ValueVec};

/// The containers whose texts are being made, by thread, to stop at circles: also at those through a `__repr__` of the
/// script, which asks for a text of its own.
#[derive(Default)]
pub struct ReprStack(RefCell<Vec<(u64, usize)>>);

impl ReprStack {
    /// From now on until the answer is dropped this thread is at this container; nothing if it is already.
    fn begin(&self, thread: u64, container: &Value) -> Option<ReprGuard<'_>> {
        let entry = (thread, container.address().unwrap_or(0));
        let mut all = self.0.borrow_mut();
        if all.contains(&entry) {
            return None;
        }
        all.push(entry);
        Some(ReprGuard { all: self, entry })
    }
}

struct ReprGuard<'s> {
    all: &'s ReprStack,
    entry: (u64, usize),
}

impl Drop for ReprGuard<'_> {
    fn drop(&mut self) {
        let mut all = self.all.0.borrow_mut();
        // Other threads may have begun a text since, so the entry need not be the last one.
        if let Some(at) = all.iter().rposition(|entry| *entry == self.entry) {
            all.remove(at);
        }
    }
}

fn code_repr(name: &str, file: &str, line: u32, address: usize) -> String {
    format!("<code object {name} at {address:#x}, file \"{file}\", line {line}>")
}

impl Evaluator<'_> {
    /// Python's `repr(value)`.
    pub fn repr(&self, value: &Value) -> R<String> {
        let mut out = String::new();
        self.repr_into(value, &mut out)?;
        Ok(out)
    }

    /// Appends the `repr`.
    fn repr_into(&self, value: &Value, out: &mut String) -> R<()> {
        match value {
            Value::Unbound => out.push_str("<unbound>"),
            Value::None => out.push_str("None"),
            Value::Ellipsis => out.push_str("Ellipsis"),
            Value::NotImplemented => out.push_str("NotImplemented"),
            Value::Bool(flag) => out.push_str(if *flag { "True" } else { "False" }),
            Value::Int(int) => {
                let _ = write!(out, "{int}");
            }
            Value::Float(value) => out.push_str(&float::repr(*value)),
            Value::BigInt(big) => out.push_str(&self.big_to_text(big)?),
            Value::Complex(complex) => out.push_str(&float::complex_repr(complex.0, complex.1)),
            Value::Str(text) => self.quote(text.as_str(), out)?,
            Value::Bytes(bytes) => self.quote_bytes(bytes.data(), out)?,
            Value::ByteArray(bytes) => {
                out.push_str("bytearray(");
                self.quote_bytearray(&bytes.snapshot(), out)?;
                out.push(')');
            }
            Value::Range(range) => {
                let _ = match range.step {
                    1 => write!(out, "range({}, {})", range.start, range.stop),
                    step => write!(out, "range({}, {}, {step})", range.start, range.stop),
                };
            }
            Value::LongRange(range) => {
                let (start, stop) = (
                    self.big_to_text(&range.start)?,
                    self.big_to_text(&range.stop)?,
                );
                let _ = match i64::try_from(&range.step) {
                    Ok(1) => write!(out, "range({start}, {stop})"),
                    _ => write!(
                        out,
                        "range({start}, {stop}, {})",
                        self.big_to_text(&range.step)?
                    ),
                };
            }
            Value::List(_)
            | Value::Tuple(_)
            | Value::Dict(_)
            | Value::DictView(_)
            | Value::Set(_)
            | Value::FrozenSet(_) => self.with_native_depth(|| self.container_repr(value, out))?,
            // Python looks for no circles through these.
            Value::Slice(_) => self.with_native_depth(|| self.container_repr_inside(value, out))?,
            Value::Instance(instance) => {
                let text = self.with_native_depth(|| self.instance_repr(value, instance))?;
                self.push_text(out, &text)?;
            }
            Value::Class(class) if class.meta_method(known::REPR).is_some() => {
                let text = self.with_native_depth(|| self.special(value, known::REPR, &mut []))?;
                if let Some(text) = text {
                    self.push_text(out, &self.expect_text(&text, "__repr__")?)?;
                }
            }
            // Methods show their receiver, which may be a method, and iterators of the library what they hold.
            other => out.push_str(&self.with_native_depth(|| self.object_repr(other))?),
        }
        self.charge(crate::limits::yielding::WORK_PER_VALUE)?;
        self.check_allocation(out.len())
    }

    fn container_repr(&self, value: &Value, out: &mut String) -> R<()> {
        let Some(_shown) = self.core.repr_stack.begin(self.core.thread.get(), value) else {
            out.push_str(match value {
                Value::List(_) => "[...]",
                Value::Tuple(_) => "(...)",
                Value::Dict(_) => "{...}",
                Value::DictView(_) => "...",
                Value::FrozenSet(_) => "frozenset(...)",
                _ => "set(...)",
            });
            return Ok(());
        };
        self.container_repr_inside(value, out)
    }

    fn container_repr_inside(&self, value: &Value, out: &mut String) -> R<()> {
        match value {
            Value::List(list) => {
                out.push('[');
                let mut index = 0;
                // Item by item: a `__repr__` of the script may change the list.
                while let Some(item) = list.get(index) {
                    out.push_str(if index > 0 { ", " } else { "" });
                    self.repr_into(&item, out)?;
                    index += 1;
                }
                out.push(']');
            }
            Value::Tuple(tuple) => {
                out.push('(');
                self.repr_items(tuple.items(), out)?;
                out.push_str(if tuple.items().len() == 1 { ",)" } else { ")" });
            }
            Value::Dict(dict) => self.dict_repr(dict, out)?,
            Value::DictView(view) => {
                let name = self.core.types.name_of(value);
                let _ = write!(out, "{name}([");
                let items = self.collect(&Value::DictView(view.clone()))?;
                self.repr_items(&items, out)?;
                out.push_str("])");
            }
            Value::Set(set) | Value::FrozenSet(set) => {
                let frozen = matches!(value, Value::FrozenSet(_));
                let mut items = ValueVec::from(self.try_with_capacity(set.len())?);
                for (_, key) in self.elements(set)? {
                    items.push(key);
                    self.charge(WORK_PER_VALUE)?;
                }
                match (items.is_empty(), frozen) {
                    (true, false) => out.push_str("set()"),
                    (true, true) => out.push_str("frozenset()"),
                    (false, frozen) => {
                        out.push_str(if frozen { "frozenset({" } else { "{" });
                        self.repr_items(&items, out)?;
                        out.push_str(if frozen { "})" } else { "}" });
                    }
                }
            }
            Value::Slice(slice) => {
                out.push_str("slice(");
                self.repr_items(
                    &[slice.start.clone(), slice.stop.clone(), slice.step.clone()],
                    out,
                )?;
                out.push(')');
            }
            _ => {}
        }
        Ok(())
    }

    fn repr_items(&self, items: &[Value], out: &mut String) -> R<()> {
        for (index, item) in items.iter().enumerate() {
            out.push_str(if index > 0 { ", " } else { "" });
            self.repr_into(item, out)?;
        }
        Ok(())
    }

    fn dict_repr(&self, dict: &Dict, out: &mut String) -> R<()> {
        out.push('{');
        let mut position = 0;
        // Entry by entry: a `__repr__` of the script may change the dictionary.
        while let Some((after, key, value)) = self.next_entry(dict, position)? {
            out.push_str(if position > 0 { ", " } else { "" });
            position = after;
            self.repr_into(&key, out)?;
            out.push_str(": ");
            self.repr_into(&value, out)?;
        }
        out.push('}');
        Ok(())
    }

    fn instance_repr(&self, value: &Value, instance: &Instance) -> R<String> {
        if let Some(method) = instance.class.lookup(known::REPR) {
            let text = self.call_method_value(&method, value, &mut [])?;
            return self.expect_text(&text, "__repr__");
        }
        self.natural_repr(value)
    }

    /// The `repr` of an object whose class defines none.
    pub fn natural_repr(&self, value: &Value) -> R<String> {
        let Value::Instance(instance) = value else {
            return self.repr(value);
        };
        if let Some(state) = instance.exception() {
            let args = self.repr(&state.args())?;
            let single = matches!(&state.args(), Value::Tuple(tuple) if tuple.items().len() == 1);
            let mut text = instance.class.name().to_string();
            match args.strip_suffix(",)") {
                Some(args) if single => {
                    self.push_text(&mut text, args)?;
                    text.push(')');
                }
                _ => self.push_text(&mut text, &args)?,
            }
            return Ok(text);
        }
        match instance.builtin_value() {
            Some(Value::Set(set) | Value::FrozenSet(set)) if !set.is_empty() => {
                // CPython makes a list of it, by the `__iter__` that its class may have.
                let items = self.repr(&self.collect(value)?.into_list())?;
                let inner = &items[1..items.len() - 1];
                Ok(format!("{}({{{inner}}})", instance.class.name()))
            }
            Some(extended @ Value::ByteArray(_)) => {
                let text = self.repr(&extended)?;
                let inner = text.strip_prefix("bytearray").unwrap_or_default();
                Ok(format!("{}{inner}", instance.class.name()))
            }
            Some(extended) => {
                let text = self.repr(&extended)?;
                let named = matches!(extended, Value::Set(_) | Value::FrozenSet(_));
                let inner = text
                    .strip_prefix("frozenset(")
                    .and_then(|text| text.strip_suffix(')'))
                    .unwrap_or(if text == "set()" { "" } else { &text });
                Ok(if named {
                    format!("{}({inner})", instance.class.name())
                } else {
                    text
                })
            }
            None if instance.class.base == BuiltinBase::Module => {
                let part = |name| instance.get(name, &self.core.symbols);
                self.module_repr(
                    part(known::NAME),
                    part(self.core.symbols.intern("__file__")),
                )
            }
            None if Rc::ptr_eq(&instance.class, &self.core.types.code) => {
                let part = |name: &str| {
                    let symbols = &self.core.symbols;
                    instance.get(symbols.intern(name), symbols)
                };
                match (part("co_name"), part("co_filename")) {
                    (Some(Value::Str(name)), Some(Value::Str(file))) => Ok(code_repr(
                        name.as_str(),
                        file.as_str(),
                        1,
                        value.address().unwrap_or(0),
                    )),
                    _ => Ok(self.bare_repr(value)),
                }
            }
            None => Ok(self.bare_repr(value)),
        }
    }

    /// The `repr` of a module that is not the interpreter's own.
    fn module_repr(&self, name: Option<Value>, file: Option<Value>) -> R<String> {
        let name = match name {
            Some(name) => self.repr(&name)?,
            None => "'?'".to_owned(),
        };
        Ok(match file {
            Some(file) => format!("<module {name} from {}>", self.repr(&file)?),
            None => format!("<module {name}>"),
        })
    }

    /// What `object.__repr__` shows of anything: its class and its place.
    pub fn bare_repr(&self, value: &Value) -> String {
        let name = self.full_name_of(self.core.types.of(value));
        let address = value.address().unwrap_or(0);
        format!("<{name} object at {address:#x}>")
    }

    /// A class with its module, as its `repr` and those of its instances have it; just the name if the module has none.
    pub fn full_name_of(&self, class: &crate::value::Class) -> String {
        let is_nameless = match class.own_attrs().get(known::MODULE) {
            Some(Value::Str(module)) => class.is_script && module.as_str() == "builtins",
            Some(_) => true,
            None => false,
        };
        match is_nameless {
            true => class.name().to_string(),
            false => format!("{}{}", self.module_prefix(class), self.qualname_of(class)),
        }
    }

    /// `module.` as it stands before the name of a class; empty for builtin types.
    pub fn module_prefix(&self, class: &crate::value::Class) -> String {
        match class.own_attrs().get(known::MODULE) {
            Some(Value::Str(module)) if module.as_str() == "builtins" => String::new(),
            Some(Value::Str(module)) => format!("{}.", module.as_str()),
            Some(_) => String::new(),
            None if class.is_script => "__main__.".to_owned(),
            None => String::new(),
        }
    }

    /// `__qualname__` of a class.
    pub fn qualname_of(&self, class: &crate::value::Class) -> String {
        class.qualname().to_string()
    }

    /// `repr` of an instance of a subclass of a builtin type as the builtin has it: sets carry the name of the class.
    pub fn extended_repr(&self, value: &Value) -> R<String> {
        match (value, self.unwrap_builtin(value)) {
            (Value::Instance(_), Value::Set(_) | Value::FrozenSet(_) | Value::ByteArray(_)) => {
                self.natural_repr(value)
            }
            (_, plain) => self.repr(&plain),
        }
    }

    /// How a bound method names what it calls if that is no function of a script.
    fn name_to_show(&self, value: &Value) -> R<String> {
        for name in [known::QUALNAME, known::NAME] {
            if let Some(Value::Str(text)) = self.attribute_or_none(value, name)? {
                return Ok(text.as_str().to_owned());
            }
        }
        Ok("?".to_owned())
    }

    pub fn object_repr(&self, value: &Value) -> R<String> {
        let address = value.address().unwrap_or(0);
        Ok(match value {
            Value::Function(function) => {
                format!("<function {} at {address:#x}>", function.qualname())
            }
            Value::BoundMethod(method) => {
                let name = match &method.function {
                    Value::Function(function) => function.qualname().to_string(),
                    Value::Builtin(builtin) if method.is_builtin() => {
                        let owner = self.core.types.name_of(&method.receiver);
                        if builtin.is_slot {
                            let address = method.receiver.address().unwrap_or(0);
                            return Ok(format!(
                                "<method-wrapper '{}' of {owner} object at {address:#x}>",
                                builtin.name
                            ));
                        }
                        return Ok(format!(
                            "<built-in method {} of {owner} object at {address:#x}>",
                            builtin.name
                        ));
                    }
                    other => self.name_to_show(other)?,
                };
                format!("<bound method {name} of {}>", self.repr(&method.receiver)?)
            }
            Value::Builtin(builtin) => match builtin.owner {
                Some(_) => {
                    let what = if builtin.is_slot {
                        "slot wrapper"
                    } else {
                        "method"
                    };
                    let owner = self.owner_of(builtin);
                    format!("<{what} '{}' of '{owner}' objects>", builtin.name)
                }
                None => format!("<built-in function {}>", builtin.name),
            },
            Value::Class(class) => {
                format!("<class '{}'>", self.full_name_of(class))
            }
            Value::Module(module) => {
                match elite_syntax::python_names::is_bundled_module(&module.name) {
                    true => format!("<module '{}' (built-in)>", module.name),
                    false => {
                        let part = |name| module.namespace.get(name);
                        self.module_repr(
                            part(known::NAME),
                            part(self.core.symbols.intern("__file__")),
                        )?
                    }
                }
            }
            Value::Generator(generator) => {
                format!(
                    "<generator object {} at {address:#x}>",
                    generator.qualname().as_str().unwrap_or_default()
                )
            }
            Value::Super(sup) => {
                let (class, receiver) = (sup.class.name(), sup.receiver_class.name());
                match sup.receiver.is_unbound() {
                    true => format!("<super: <class '{class}'>, NULL>"),
                    false => format!("<super: <class '{class}'>, <{receiver} object>>"),
                }
            }
            Value::StaticMethod(inner) => format!("<staticmethod({})>", self.repr(inner)?),
            Value::ClassMethod(inner) => format!("<classmethod({})>", self.repr(inner)?),
            Value::Code(code) => {
                let line = code.file.line_of(code.span.start);
                code_repr(&code.name, code.file.name(), line, address)
            }
            other => {
                if let Value::Iter(iter) = other
                    && let Iter::Native(native) = &**iter
                    && let Some(text) = native.steps.repr(self)?
                {
                    return Ok(text);
                }
                let name = self.core.types.name_of(other);
                format!("<{name} object at {address:#x}>")
            }
        })
    }
}
