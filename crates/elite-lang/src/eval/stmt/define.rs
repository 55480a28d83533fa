//! `def` and `class`.

use std::rc::Rc;

use elite_syntax::Span;
use elite_syntax::resolve::Storage;

use super::layout::takes_slots;
use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::code::Code;
use crate::eval::expr::arguments::{CallArg, gather};
use crate::eval::expr::function::{MakeFunction, closure};
use crate::eval::run::with_slots;
use crate::eval::{BoxExpr, Evaluator, Flow, Frame, StmtNode, TraceExt, attempt};
use crate::limits::deferred_drop::NodeList;
use crate::value::class::BuiltinBase;
use crate::value::function::WrappedFunction;
use crate::value::symbol::known;
use crate::value::{Class, Function, R, Symbol, Unwind, Value, ValueVec};

/// `def`
pub struct DefineFunction {
    /// The function.
    pub function: MakeFunction,
    /// The decorators of the function, outermost first, with their places.
    pub decorators: NodeList<(BoxExpr, Span)>,
    /// The name it is bound to.
    pub target: Box<dyn Target>,
}

impl StmtNode for DefineFunction {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let decorators = attempt!(evaluate(&self.decorators, ev, f));
        let mut value = Value::Function(attempt!(self.function.make(ev, f)));
        for (decorator, span) in decorators.iter().rev() {
            value = attempt!(ev.call1(decorator, value).trace_at(ev, f, *span));
        }
        self.target.assign(ev, f, value).into()
    }
}

fn evaluate(
    decorators: &[(BoxExpr, Span)],
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
    pub closure: Box<[Storage]>,
    /// Base classes and keywords.
    pub args: NodeList<CallArg>,
    /// How many of the leading slots of the body are attributes.
    pub names: usize,
    /// The slot with the cell of `__class__`.
    pub class_cell: Option<u32>,
    /// The decorators of the class, outermost first, with their places.
    pub decorators: NodeList<(BoxExpr, Span)>,
    /// The name it is bound to.
    pub target: Box<dyn Target>,
    /// Where the header is written.
    pub span: Span,
}

impl StmtNode for DefineClass {
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
        let function = Function::without_defaults(self.code.clone(), closure(&self.closure, f));
        let mut value = attempt!(self.build(ev, f, &function, &bases, &keywords));
        for (decorator, span) in decorators.iter().rev() {
            value = attempt!(ev.call1(decorator, value).trace_at(ev, f, *span));
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
        let metaclass = ev
            .metaclass_of(bases, keywords)
            .trace_at(ev, f, self.span)?;
        let keywords: &[_] = &keywords
            .iter()
            .filter(|(name, _)| *name != known::METACLASS)
            .cloned()
            .collect::<Vec<_>>();
        let prepared = match &metaclass {
            Some(metaclass) => ev
                .prepared_namespace(metaclass, &self.code.name, bases, keywords)
                .trace_at(ev, f, self.span)?,
            None => Value::None,
        };
        if let (Some(metaclass), Value::Instance(_)) = (&metaclass, &prepared) {
            return self.build_in(ev, f, function, metaclass, prepared, bases, keywords);
        }
        let prepared = ev.prepared_names(&prepared).trace_at(ev, f, self.span)?;
        with_slots(self.code.slots + 1, |slots| {
            for (name, value) in &prepared {
                let names = &self.code.slot_names[..self.names];
                if let Some(slot) = names.iter().position(|other| other == name) {
                    slots[slot] = value.clone();
                }
            }
            ev.run(function, slots).trace_at(ev, f, self.span)?;
            let names = self.code.slot_names[..self.names]
                .iter()
                .zip(slots[..self.names].iter());
            let mut attrs = prepared;
            let module = ev.name_for_class(&self.code).trace_at(ev, f, self.span)?;
            attrs.retain(|(name, _)| !self.code.slot_names[..self.names].contains(name));
            attrs.push((known::MODULE, module));
            attrs.push((known::QUALNAME, Value::str(&*self.code.qualname)));
            let of_body = |(name, value): (&Symbol, &Value)| (*name, value.clone());
            let is_first = |(name, _): &(&Symbol, &Value)| **name == known::ANNOTATIONS;
            let (first, names): (Vec<_>, Vec<_>) = names
                .filter(|(_, value)| !value.is_unbound())
                .partition(is_first);
            attrs.extend(first.into_iter().map(of_body));
            if let Some(doc) = self.code.doc.as_deref() {
                attrs.push((known::DOC, Value::str(doc)));
            }
            // Names the body shares with functions of it cannot be seen there, so none of them is a cell.
            attrs.extend(names.into_iter().map(of_body));
            if let Some(metaclass) = &metaclass {
                let cell = self.class_cell.map(|slot| slots[slot as usize].clone());
                return ev
                    .call_metaclass(metaclass, &self.code.name, bases, attrs, cell, keywords)
                    .trace_at(ev, f, self.span);
            }
            let class = ev
                .make_class(&self.code.name, bases, attrs)
                .trace_at(ev, f, self.span)?;
            if let Some(Value::Cell(cell)) = self.class_cell.map(|slot| &slots[slot as usize]) {
                drop(cell.replace(Value::Class(class.clone())));
            }
            ev.finish_class(&class, keywords)
                .trace_at(ev, f, self.span)?;
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
            ev.set_item(&namespace, &ev.core.symbols.to_value(name), value)
                .trace_at(ev, f, self.span)
        };
        with_slots(self.code.slots + 1, |slots| {
            let module = ev.name_for_class(&self.code).trace_at(ev, f, self.span)?;
            put(known::MODULE, module)?;
            put(known::QUALNAME, Value::str(&*self.code.qualname))?;
            if let Some(doc) = self.code.doc.as_deref() {
                put(known::DOC, Value::str(doc))?;
            }
            slots[self.code.slots] = namespace.clone();
            ev.run(function, slots).trace_at(ev, f, self.span)?;
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
            ev.call(metaclass, &mut args, keywords)
                .trace_at(ev, f, self.span)
        })
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
        let held = self.pause_sweep();
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
        let (mut has_eq, mut has_hash, mut has_doc) = (false, false, false);
        for (name, value) in attrs {
            if name == known::QUALNAME {
                self.take_qualname(&class, &value)?;
                continue;
            }
            has_doc |= name == known::DOC;
            has_eq |= name == known::EQ;
            has_hash |= name == known::HASH;
            let value = match (&value, name) {
                // Python passes the class to `__init_subclass__` and `__class_getitem__` without a decorator.
                (Value::Function(_), known::INIT_SUBCLASS | known::CLASS_GETITEM) => {
                    Value::ClassMethod(WrappedFunction::around(value))
                }
                (Value::Function(_), known::NEW) => {
                    Value::StaticMethod(WrappedFunction::around(value))
                }
                _ => value,
            };
            class.set(name, value);
            self.charge(ATTRIBUTE)?;
        }
        class.end_body_attrs();
        if !has_doc {
            class.set(known::DOC, Value::None);
        }
        if has_eq && !has_hash {
            class.set(known::HASH, Value::None);
        }
        Ok(class)
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
        let attrs = ValueVec::from(told(class));
        for (name, value) in attrs {
            self.charge(ATTRIBUTE)?;
            if let Value::Property(property) = &value {
                property.name.put(self.core.symbols.to_value(name));
            }
            if let Value::Instance(descriptor) = &value
                && let Some(set_name) = descriptor.class.lookup(known::SET_NAME)
            {
                let mut args = [
                    Value::Class(class.clone()),
                    self.core.symbols.to_value(name),
                ];
                self.call_method_value(&set_name, &value, &mut args)
                    .map_err(|raised| self.set_name_error(raised, &value, name, class))?;
            }
        }
        if let Some(hook) = class
            .mro_tail()
            .iter()
            .find_map(|parent| parent.own_attrs().get(known::INIT_SUBCLASS).cloned())
        {
            let value = Value::Class(class.clone());
            let bound = match &hook {
                Value::ClassMethod(function) => self.bind_to_class(function, &value)?,
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
    fn set_name_error(&self, raised: Unwind, value: &Value, name: Symbol, class: &Class) -> Unwind {
        let Unwind::Exception(cause) = &raised else {
            return raised;
        };
        let text = format!(
            "Error calling __set_name__ on '{}' instance '{}' in '{}'",
            self.core.types.name_of(value),
            self.core.symbols.name(name),
            class.name()
        );
        let error = self.raise(ExceptionKind::RuntimeError, text);
        if let Unwind::Exception(error) = &error
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
        let mut line = class.mro();
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
    let is_iterator = class.base == BuiltinBase::Iterator;
    let name = class.name();
    if class.is_script {
        return class.is_c_type.get() && *class.type_name() == *"datetime.timezone";
    }
    if is_iterator {
        // Iterator types of the library are classes to derive from, too.
        return name.ends_with("iterator") || matches!(&*name, "_tee" | "_grouper");
    }
    if class.is_c_type.get() {
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
