//! `def` and `class`.

use std::collections::HashSet;
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
use crate::value::function::Wrapped;
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
            let module = ev.name_for_class(&self.code).at(ev, f, self.span)?;
            attrs.retain(|(name, _)| !self.code.slot_names[..self.names].contains(name));
            attrs.push((known::MODULE, module));
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
            let module = ev.name_for_class(&self.code).at(ev, f, self.span)?;
            put(known::MODULE, module)?;
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
    let is_of_library = matches!(base, Base::Native | Base::Iterator);
    let is_other = matches!(
        base,
        Base::Object | Base::Exception | Base::Str | Base::Float | Base::Complex | Base::ByteArray
    );
    is_container || is_other || is_of_library || !has_room(base)
}

/// The nearest class that gives instances of a class more than those of its own ancestors have: slots, or what a builtin type
/// holds.
fn widening(class: &Rc<Class>) -> Option<Rc<Class>> {
    let ancestors = class.ancestors();
    let mut line = std::iter::once(class).chain(&*ancestors);
    let widest = line.find(|class| match class.is_script {
        true => class.has_own_slots(),
        false => class.base != Base::Object,
    });
    widest.cloned()
}

/// Whether CPython's layout of a class has a place for weak references: sets have one, and classes without `__slots__`.
fn is_weakly_referable(class: &Rc<Class>) -> bool {
    let has_place = |class: &Rc<Class>| match class.is_script {
        true => class.is_referable(),
        false => matches!(class.base, Base::Set | Base::FrozenSet),
    };
    has_place(class) || class.ancestors().iter().any(has_place)
}

/// Whether CPython's layout of this builtin type has room for slots behind its items.
fn has_room(base: Base) -> bool {
    !matches!(base, Base::Int | Base::Tuple | Base::Bytes)
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
        let held = self.hold_names();
        let class = self.make_with_names_held(name, bases, attrs)?;
        drop(held);
        // What the work on it made due was put off.
        self.sweep_names_if_due()?;
        Ok(class)
    }

    fn make_with_names_held(
        &self,
        name: &str,
        bases: &[Value],
        attrs: Vec<(Symbol, Value)>,
    ) -> R<Rc<Class>> {
        let mut parents: Vec<Rc<Class>> = Vec::new();
        for base in bases {
            let Value::Class(class) = base else {
                return Err(self.type_error("bases must be types"));
            };
            if is_final(class) {
                let text = format!(
                    "type '{}' is not an acceptable base type",
                    class.type_name()
                );
                return Err(self.type_error(text));
            }
            parents.push(class.clone());
        }
        if parents.is_empty() {
            parents.push(self.core.types.object.clone());
        }
        let base = self.layout_base(&parents)?;
        let slots = match attrs.iter().find(|(name, _)| *name == known::SLOTS) {
            Some((_, listed)) if takes_slots(base) => {
                Some(self.slot_names(listed, base, &parents, &attrs)?)
            }
            _ => None,
        };
        let again = (1..parents.len()).find(|at| {
            parents[..*at]
                .iter()
                .any(|other| Rc::ptr_eq(other, &parents[*at]))
        });
        if let Some(at) = again {
            let name = parents[at].name();
            return Err(self.type_error(format!("duplicate base class {name}")));
        }
        let ancestors = linearise(&parents).map_err(|names| {
            let text = "Cannot create a consistent method resolution\norder (MRO) for bases";
            self.type_error(format!("{text} {}", names.join(", ")))
        })?;
        let class = Class::new(name, base, parents, ancestors, true);
        self.core.note_class(&class);
        if let Some(slots) = slots {
            class.set_slots(&slots);
        }
        let (mut has_eq, mut has_hash) = (false, false);
        for (name, value) in attrs {
            has_eq |= name == known::EQ;
            has_hash |= name == known::HASH;
            let value = match (&value, name) {
                // These take the class without a decorator.
                (Value::Function(_), known::INIT_SUBCLASS | known::CLASS_GETITEM) => {
                    Value::ClassMethod(Wrapped::around(value))
                }
                (Value::Function(_), known::NEW) => Value::StaticMethod(Wrapped::around(value)),
                _ => value,
            };
            class.set(name, value);
            self.worked(ATTRIBUTE)?;
        }
        if has_eq && !has_hash {
            class.set(known::HASH, Value::None);
        }
        Ok(class)
    }

    /// The names that `__slots__` lists.
    fn slot_names(
        &self,
        listed: &Value,
        base: Base,
        parents: &[Rc<Class>],
        attrs: &[(Symbol, Value)],
    ) -> R<Vec<Symbol>> {
        let names = match listed {
            Value::Str(_) => vec![listed.clone()].into(),
            other => self.collect(other)?,
        };
        if !names.is_empty() && !has_room(base) {
            let extended = parents.iter().find(|class| class.base == base);
            let extended = extended.map_or_else(|| "object".into(), |class| class.name());
            let text = format!("nonempty __slots__ not supported for subtype of '{extended}'");
            return Err(self.type_error(text));
        }
        let has_dict = |class: &Rc<Class>| {
            class.base == Base::Exception || class.is_script && class.has_dict()
        };
        let mut has_dict = parents.iter().any(has_dict);
        let mut is_referable = parents.iter().all(is_weakly_referable);
        let mut slots = Vec::new();
        for slot in &names {
            let Value::Str(text) = slot else {
                let name = self.core.types.name_of(slot);
                let text = format!("__slots__ items must be strings, not '{name}'");
                return Err(self.type_error(text));
            };
            let name = self.take_name(text.as_str())?;
            if !crate::lexer::names::is_name(text.as_str()) {
                return Err(self.type_error("__slots__ must be identifiers"));
            }
            if name == known::WEAKREF && std::mem::replace(&mut is_referable, true) {
                let text =
                    "__weakref__ slot disallowed: either we already got one, or __itemsize__ != 0";
                return Err(self.type_error(text));
            }
            if name == known::DICT && std::mem::replace(&mut has_dict, true) {
                let text = "__dict__ slot disallowed: we already got one";
                return Err(self.type_error(text));
            }
            slots.push(name);
            self.worked(ATTRIBUTE)?;
        }
        let mut given = HashSet::new();
        for (name, _) in attrs.iter().filter(|_| !slots.is_empty()) {
            given.insert(*name);
            self.worked(ATTRIBUTE)?;
        }
        for name in &slots {
            self.worked(ATTRIBUTE)?;
            if given.contains(name) {
                let name = self.repr(&self.core.symbols.value(*name))?;
                let text = format!("{name} in __slots__ conflicts with class variable");
                return Err(self.value_error(text));
            }
        }
        Ok(slots)
    }

    /// The builtin layout that instances of a class with these bases have.
    pub fn layout_base(&self, parents: &[Rc<Class>]) -> R<crate::value::class::Base> {
        let conflict = || self.type_error("multiple bases have instance lay-out conflict");
        let mut base = Base::Object;
        let mut widest: Option<Rc<Class>> = None;
        for parent in parents {
            if parents.len() > 1
                && let Some(wide) = widening(parent)
            {
                let is_wider = |wide: &Rc<Class>, than: &Rc<Class>| {
                    wide.is_subclass_of(than) || !wide.is_script && wide.base == than.base
                };
                widest = Some(match widest {
                    Some(other) if is_wider(&other, &wide) => other,
                    Some(other) if !is_wider(&wide, &other) => return Err(conflict()),
                    _ => wide,
                });
            }
            if parent.base != Base::Object && parent.base != base {
                if base != Base::Object {
                    return Err(conflict());
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
            let value = Value::Class(class.clone());
            let bound = match &hook {
                Value::ClassMethod(function) => self.bound_to_class(function, &value)?,
                Value::StaticMethod(function) => Value::clone(function),
                Value::Instance(descriptor) => match descriptor.class.lookup(known::GET) {
                    Some(get) => self.call_method_value(&get, &hook, &mut [Value::None, value])?,
                    None => hook,
                },
                _ => hook,
            };
            self.call(&bound, &mut [], keywords)?;
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
        if receiver.is_unbound() {
            return Ok(Value::Super(Rc::new(crate::value::function::Super {
                class: class.clone(),
                receiver: Value::Unbound,
                receiver_class: class.clone(),
            })));
        }
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
        return class.in_c.get() && *class.type_name() == *"datetime.timezone";
    }
    if is_iterator {
        // Those of the library are classes to derive from, too.
        return name.ends_with("iterator") || matches!(&*name, "_tee" | "_grouper");
    }
    if class.in_c.get() {
        return matches!(
            &*class.type_name(),
            "re.Pattern"
                | "re.Match"
                | "_thread.lock"
                | "types.UnionType"
                | "operator.itemgetter"
                | "operator.attrgetter"
                | "operator.methodcaller"
        );
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
            | "method_descriptor"
            | "wrapper_descriptor"
            | "method-wrapper"
            | "code"
            | "cell"
            | "frame"
            | "traceback"
            | "UnionType"
            | "getset_descriptor"
            | "member_descriptor"
    )
}
