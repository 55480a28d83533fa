//! `def` and `class`.

use std::rc::Rc;

use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::code::Code;
use crate::eval::expr::arguments::{CallArg, gather};
use crate::eval::expr::function::{MakeFunction, closure};
use crate::eval::run::with_slots;
use crate::eval::{Evaluator, Expr, Flow, Frame, Located, Statement, attempt};
use crate::resolve::Place;
use crate::source::Span;
use crate::value::class::Base;
use crate::value::symbol::known;
use crate::value::trash::Nodes;
use crate::value::{Class, Function, R, Raised, Symbol, Value, Values};

/// `def`
pub struct DefineFunction {
    /// The function.
    pub function: MakeFunction,
    /// Its decorators, outermost first, with their places.
    pub decorators: Nodes<(Expr, Span)>,
    /// The name it is bound to.
    pub target: Box<dyn Target>,
}

impl Statement for DefineFunction {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let decorators = attempt!(evaluate(&self.decorators, ev, f));
        let mut value = Value::Function(attempt!(self.function.make(ev, f)));
        for (decorator, span) in decorators.iter().rev() {
            value = attempt!(ev.call1(decorator, value).at(ev, f, *span));
        }
        self.target.assign(ev, f, value).into()
    }
}

fn evaluate(
    decorators: &[(Expr, Span)],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> R<Vec<(Value, Span)>> {
    decorators
        .iter()
        .map(|(decorator, span)| Ok((decorator.eval(ev, f)?, *span)))
        .collect()
}

/// `class`
pub struct DefineClass {
    /// The body, run once.
    pub code: Rc<Code>,
    /// Where its closure comes from.
    pub closure: Box<[Place]>,
    /// Base classes and keywords.
    pub args: Nodes<CallArg>,
    /// How many of the leading slots of the body are attributes.
    pub names: usize,
    /// The slot with the cell of `__class__`.
    pub class_cell: Option<u32>,
    /// Its decorators, outermost first, with their places.
    pub decorators: Nodes<(Expr, Span)>,
    /// The name it is bound to.
    pub target: Box<dyn Target>,
    /// `__module__`.
    pub module: Value,
    /// Where the header is written.
    pub span: Span,
}

impl Statement for DefineClass {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let decorators = attempt!(evaluate(&self.decorators, ev, f));
        let (mut bases, mut keywords, mut names) = (Vec::new(), Vec::new(), Vec::new());
        attempt!(gather(
            &self.args,
            &Value::Class(ev.core.types.type_.clone()),
            ev,
            f,
            self.span,
            &mut bases,
            &mut keywords,
            &mut names,
        ));
        let function = Function::plain(self.code.clone(), closure(&self.closure, f));
        let mut value = attempt!(self.build(ev, f, &function, &bases, &keywords));
        for (decorator, span) in decorators.iter().rev() {
            value = attempt!(ev.call1(decorator, value).at(ev, f, *span));
        }
        self.target.assign(ev, f, value).into()
    }
}

impl DefineClass {
    fn build(
        &self,
        ev: &Evaluator<'_>,
        f: &Frame<'_>,
        function: &Rc<Function>,
        bases: &[Value],
        keywords: &[(Symbol, Value)],
    ) -> R {
        let metaclass = ev.metaclass_of(bases, keywords).at(ev, f, self.span)?;
        let keywords: &[_] = &keywords
            .iter()
            .filter(|(name, _)| *name != known::METACLASS)
            .cloned()
            .collect::<Vec<_>>();
        let prepared = match &metaclass {
            Some(metaclass) => ev
                .prepared_namespace(metaclass, &self.code.name, bases, keywords)
                .at(ev, f, self.span)?,
            None => Value::None,
        };
        if let (Some(metaclass), Value::Instance(_)) = (&metaclass, &prepared) {
            return self.build_in(ev, f, function, metaclass, prepared, bases, keywords);
        }
        let prepared = ev.prepared_names(&prepared).at(ev, f, self.span)?;
        with_slots(self.code.slots + 1, |slots| {
            for (name, value) in &prepared {
                let names = &self.code.slot_names[..self.names];
                if let Some(slot) = names.iter().position(|other| other == name) {
                    slots[slot] = value.clone();
                }
            }
            ev.run(function, slots).at(ev, f, self.span)?;
            let names = self.code.slot_names[..self.names]
                .iter()
                .zip(slots[..self.names].iter());
            let mut attrs = prepared;
            attrs.retain(|(name, _)| !self.code.slot_names[..self.names].contains(name));
            attrs.push((known::MODULE, self.module.clone()));
            attrs.push((known::QUALNAME, Value::str(&*self.code.qualname)));
            match self.code.doc.as_deref() {
                Some(doc) => attrs.push((known::DOC, Value::str(doc))),
                None if metaclass.is_none() => attrs.push((known::DOC, Value::None)),
                None => {}
            }
            // Names the body shares with functions of it cannot be seen there, so none of them is a cell.
            attrs.extend(
                names
                    .filter(|(_, value)| !value.is_unbound())
                    .map(|(name, value)| (*name, value.clone())),
            );
            if let Some(metaclass) = &metaclass {
                let cell = self.class_cell.map(|slot| slots[slot as usize].clone());
                return ev
                    .call_metaclass(metaclass, &self.code.name, bases, attrs, cell, keywords)
                    .at(ev, f, self.span);
            }
            let class = ev
                .make_class(&self.code.name, bases, attrs)
                .at(ev, f, self.span)?;
            if let Some(Value::Cell(cell)) = self.class_cell.map(|slot| &slots[slot as usize]) {
                drop(cell.replace(Value::Class(class.clone())));
            }
            ev.finish_class(&class, keywords).at(ev, f, self.span)?;
            Ok(Value::Class(class))
        })
    }
}

impl DefineClass {
    /// Builds the class in a namespace of the metaclass's own, which sees each name as it is bound.
    #[allow(clippy::too_many_arguments)] // what `build` has at hand
    fn build_in(
        &self,
        ev: &Evaluator<'_>,
        f: &Frame<'_>,
        function: &Rc<Function>,
        metaclass: &Value,
        namespace: Value,
        bases: &[Value],
        keywords: &[(Symbol, Value)],
    ) -> R {
        let put = |name: Symbol, value: Value| {
            ev.set_item(&namespace, &ev.core.symbols.value(name), value)
                .at(ev, f, self.span)
        };
        with_slots(self.code.slots + 1, |slots| {
            put(known::MODULE, self.module.clone())?;
            put(known::QUALNAME, Value::str(&*self.code.qualname))?;
            if let Some(doc) = self.code.doc.as_deref() {
                put(known::DOC, Value::str(doc))?;
            }
            slots[self.code.slots] = namespace.clone();
            ev.run(function, slots).at(ev, f, self.span)?;
            let names = &self.code.slot_names[..self.names];
            if let Some(slot) = names.iter().position(|name| *name == known::ANNOTATIONS)
                && !slots[slot].is_unbound()
            {
                put(known::ANNOTATIONS, slots[slot].clone())?;
            }
            if let Some(slot) = self.class_cell {
                put(known::CLASSCELL, slots[slot as usize].clone())?;
            }
            let mut args = [
                Value::str(&*self.code.name),
                Value::tuple(bases.to_vec()),
                namespace.clone(),
            ];
            ev.call(metaclass, &mut args, keywords).at(ev, f, self.span)
        })
    }
}

/// Whether `__slots__` says which attributes the instances have.
fn takes_slots(base: Base) -> bool {
    let is_container = matches!(base, Base::List | Base::Dict | Base::Set | Base::FrozenSet);
    is_container
        || matches!(base, Base::Object | Base::Str | Base::Float)
        || without_room(base).is_some()
}

/// The builtin type of this layout, if CPython's has no room for slots behind its items.
fn without_room(base: Base) -> Option<&'static str> {
    match base {
        Base::Int => Some("int"),
        Base::Tuple => Some("tuple"),
        Base::Bytes => Some("bytes"),
        _ => None,
    }
}

/// Work for an attribute of a new class.
pub(super) const ATTRIBUTE: usize = 256;

impl Evaluator<'_> {
    /// A class as the `class` statement and `type(name, bases, dict)` make it.
    pub fn make_class(
        &self,
        name: &str,
        bases: &[Value],
        attrs: Vec<(Symbol, Value)>,
    ) -> R<Rc<Class>> {
        self.check_name(name)?;
        let mut parents: Vec<Rc<Class>> = Vec::new();
        for base in bases {
            let Value::Class(class) = base else {
                let name = self.core.types.name_of(base);
                return Err(self.type_error(format!(
                    "a base of a class must be a class, not '{name}' object"
                )));
            };
            if is_final(class) {
                let text = format!("type '{}' is not an acceptable base type", class.name());
                return Err(self.type_error(text));
            }
            if parents.iter().any(|other| Rc::ptr_eq(other, class)) {
                return Err(self.type_error(format!("duplicate base class {}", class.name())));
            }
            parents.push(class.clone());
        }
        if parents.is_empty() {
            parents.push(self.core.types.object.clone());
        }
        let ancestors = linearise(&parents).map_err(|names| {
            let text = "Cannot create a consistent method resolution\norder (MRO) for bases";
            self.type_error(format!("{text} {}", names.join(", ")))
        })?;
        let base = self.layout_base(&parents)?;
        let class = Class::new(name, base, parents, ancestors, true);
        self.core.note_class(&class);
        let (mut has_eq, mut has_hash) = (false, false);
        let mut slots = Vec::new();
        for (name, value) in attrs {
            has_eq |= name == known::EQ;
            has_hash |= name == known::HASH;
            if name == known::SLOTS && takes_slots(base) {
                let names = match &value {
                    Value::Str(_) => vec![value.clone()].into(),
                    other => self.collect(other)?,
                };
                for slot in &names {
                    let Value::Str(text) = slot else {
                        let name = self.core.types.name_of(slot);
                        return Err(self
                            .type_error(format!("__slots__ items must be strings, not '{name}'")));
                    };
                    slots.push(self.take_name(text.as_str())?);
                    self.worked(ATTRIBUTE)?;
                }
                if let (false, Some(extended)) = (slots.is_empty(), without_room(base)) {
                    let text =
                        format!("nonempty __slots__ not supported for subtype of '{extended}'");
                    return Err(self.type_error(text));
                }
                if !slots.contains(&known::DICT) {
                    class.set_slots(slots.clone().into());
                }
            }
            let value = match (&value, name) {
                // These take the class without a decorator.
                (Value::Function(_), known::INIT_SUBCLASS | known::CLASS_GETITEM) => {
                    Value::ClassMethod(Rc::new(value))
                }
                (Value::Function(_), known::NEW) => Value::StaticMethod(Rc::new(value)),
                _ => value,
            };
            class.set(name, value);
            self.worked(ATTRIBUTE)?;
        }
        let taken = { slots.into_iter() }.find(|name| class.own_attrs().get(*name).is_some());
        if let Some(name) = taken {
            let name = self.repr(&self.core.symbols.value(name))?;
            return Err(
                self.value_error(format!("{name} in __slots__ conflicts with class variable"))
            );
        }
        if has_eq && !has_hash {
            class.set(known::HASH, Value::None);
        }
        Ok(class)
    }

    /// The builtin layout that instances of a class with these bases have.
    pub fn layout_base(&self, parents: &[Rc<Class>]) -> R<crate::value::class::Base> {
        use crate::value::class::Base;
        let mut base = Base::Object;
        for parent in parents {
            if parent.base != Base::Object && parent.base != base {
                if base != Base::Object {
                    return Err(self.type_error("multiple bases have instance lay-out conflict"));
                }
                base = parent.base;
            }
        }
        Ok(base)
    }

    /// Tells attributes their names and the parent about the new class.
    pub fn finish_class(&self, class: &Rc<Class>, keywords: &[(Symbol, Value)]) -> R<()> {
        let is_told = |value: &Value| matches!(value, Value::Property(_) | Value::Instance(_));
        // The look at the class is over before any code runs.
        let told = |class: &Class| -> Vec<(Symbol, Value)> {
            let attrs = class.own_attrs();
            let told = attrs.iter().filter(|(_, value)| is_told(value));
            told.map(|(name, value)| (name, value.clone())).collect()
        };
        let attrs = Values::from(told(class));
        for (name, value) in attrs {
            self.worked(ATTRIBUTE)?;
            if let Value::Property(property) = &value {
                property.name.put(self.core.symbols.value(name));
            }
            if let Value::Instance(descriptor) = &value
                && let Some(set_name) = descriptor.class.lookup(known::SET_NAME)
            {
                let mut args = [Value::Class(class.clone()), self.core.symbols.value(name)];
                self.call_method_value(&set_name, &value, &mut args)
                    .map_err(|raised| self.set_name_error(raised, &value, name, class))?;
            }
        }
        if let Some(hook) = class
            .ancestors()
            .iter()
            .find_map(|parent| parent.own_attrs().get(known::INIT_SUBCLASS).cloned())
        {
            if let Value::ClassMethod(function) = hook {
                self.call(&function, &mut [Value::Class(class.clone())], keywords)?;
            }
        } else if !keywords.is_empty() {
            return Err(self.type_error(format!(
                "{}.__init_subclass__() takes no keyword arguments",
                self.qualname_of(class)
            )));
        }
        Ok(())
    }

    #[cold]
    fn set_name_error(&self, raised: Raised, value: &Value, name: Symbol, class: &Class) -> Raised {
        let Raised::Exception(cause) = &raised else {
            return raised;
        };
        let text = format!(
            "Error calling __set_name__ on '{}' instance '{}' in '{}'",
            self.core.types.name_of(value),
            self.core.symbols.name(name),
            class.name()
        );
        let error = self.raise(ExceptionKind::RuntimeError, text);
        if let Raised::Exception(error) = &error
            && let Some(state) = error.exception()
        {
            state.cause.put(Value::Instance(cause.clone()));
            state.suppress_context.set(true);
        }
        error
    }

    /// `super()` for a class and an object.
    pub fn make_super(&self, class: &Value, receiver: &Value) -> R {
        let Value::Class(class) = class else {
            let name = self.core.types.name_of(class);
            return Err(self.type_error(format!("super() argument 1 must be a type, not {name}")));
        };
        let own = self.core.types.of(receiver);
        let receiver_class = match receiver {
            Value::Class(other) if other.is_subclass_of(class) => other.clone(),
            _ if own.is_subclass_of(class) => own.clone(),
            _ => {
                return Err(
                    self.type_error("super(type, obj): obj must be an instance or subtype of type")
                );
            }
        };
        let (class, receiver) = (class.clone(), receiver.clone());
        Ok(Value::Super(Rc::new(crate::value::function::Super {
            class,
            receiver,
            receiver_class,
        })))
    }
}

/// The C3 linearisation of a class with these parents, the class itself left out. If there is no order: the names of
/// the classes that stand in each other's way.
pub fn linearise(parents: &[Rc<Class>]) -> Result<Vec<Rc<Class>>, Vec<Rc<str>>> {
    let line = |class: &Rc<Class>| -> Vec<Rc<Class>> {
        let mut line = class.line();
        line.reverse();
        line
    };
    // Reversed, so that heads are popped from the ends.
    let mut lines: Vec<Vec<Rc<Class>>> = parents.iter().map(line).collect();
    lines.push(parents.iter().rev().cloned().collect());
    let mut order = Vec::new();
    loop {
        lines.retain(|line| !line.is_empty());
        if lines.is_empty() {
            return Ok(order);
        }
        let in_tail = |class: &Rc<Class>| {
            lines.iter().any(|line| {
                line[..line.len() - 1]
                    .iter()
                    .any(|other| Rc::ptr_eq(other, class))
            })
        };
        let next = lines
            .iter()
            .filter_map(|line| line.last())
            .find(|class| !in_tail(class))
            .cloned();
        let Some(next) = next else {
            let mut heads: Vec<Rc<str>> = Vec::new();
            for name in lines
                .iter()
                .filter_map(|line| line.last())
                .map(|class| class.name())
            {
                if !heads.contains(&name) {
                    heads.push(name);
                }
            }
            return Err(heads);
        };
        for line in &mut lines {
            if line.last().is_some_and(|class| Rc::ptr_eq(class, &next)) {
                line.pop();
            }
        }
        order.push(next);
    }
}

/// Whether nothing can be derived from a builtin type.
pub fn is_final(class: &Class) -> bool {
    let is_iterator = class.base == Base::Iterator;
    let name = class.name();
    if class.is_script {
        return false;
    }
    if is_iterator {
        // Those of the library are classes to derive from, too.
        return name.ends_with("iterator");
    }
    matches!(
        &*name,
        "bool"
            | "NoneType"
            | "ellipsis"
            | "NotImplementedType"
            | "range"
            | "slice"
            | "function"
            | "method"
            | "builtin_function_or_method"
            | "generator"
            | "dict_keys"
            | "dict_values"
            | "dict_items"
            | "module"
            | "staticmethod"
            | "classmethod"
            | "super"
            | "code"
            | "cell"
            | "frame"
            | "traceback"
            | "UnionType"
    )
}
