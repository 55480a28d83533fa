//! What can be assigned to.

use std::cell::Cell;
use std::rc::Rc;

use elite_syntax::Span;

use crate::errors::ExceptionKind;
use crate::eval::expr::names::Readable;
use crate::eval::expr::operand::Operand;
use crate::eval::run::with_slots;
use crate::eval::words::PairOf;
use crate::eval::{Evaluator, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::value::{CellVar, Instance, R, Symbol, Unwind, Value};

/// A place a value can be put.
pub trait Target {
    /// Puts it there.
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()>;

    /// `assign`, with the value in registers.
    #[inline(never)]
    fn assign_words(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: PairOf<Value>) -> R<()> {
        self.assign(ev, f, value.whole())
    }

    /// Takes it away (`del`).
    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()>;
}

/// A local variable or a name of a class body.
pub struct SlotTarget {
    /// The slot of the name in the frame.
    pub slot: u32,
    /// The place in the text.
    pub span: Span,
}

impl Target for SlotTarget {
    #[inline]
    fn assign(&self, _: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        f.slots[self.slot as usize].put(value);
        Ok(())
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        let value = std::mem::take(&mut f.slots[self.slot as usize]);
        if value.is_unbound() {
            let name = ev
                .core
                .symbols
                .name(f.function.code.slot_names[self.slot as usize]);
            let text = format!(
                "cannot access local variable '{name}' where it is not associated with a value"
            );
            return Err(ev.raise(ExceptionKind::UnboundLocalError, text))
                .trace_at(ev, f, self.span);
        }
        Ok(())
    }
}

/// A name at the top level of a text that runs in a mapping of a script.
pub struct MappingTarget {
    /// The slot with the mapping.
    pub slot: u32,
    /// The name.
    pub key: Value,
    /// The place in the text.
    pub span: Span,
}

impl Target for MappingTarget {
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        let mapping = f.slots[self.slot as usize].clone();
        ev.set_item(&mapping, &self.key, value)
            .trace_at(ev, f, self.span)
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        let mapping = f.slots[self.slot as usize].clone();
        let deleted = ev.delete_item(&mapping, &self.key).map_err(|raised| {
            match ev.is_kind(&raised, ExceptionKind::KeyError) {
                true => {
                    let name = self.key.as_str().unwrap_or_default();
                    ev.raise(
                        ExceptionKind::NameError,
                        format!("name '{name}' is not defined"),
                    )
                }
                false => raised,
            }
        });
        deleted.trace_at(ev, f, self.span)
    }
}

/// A variable in a cell: of this frame, of an outer one, or a global.
pub enum CellRef {
    /// The slot that holds the cell.
    Cell(u32),
    /// Index in the closure.
    Free(u32),
    /// The global.
    Global(Rc<CellVar>, Symbol),
}

/// A shared variable as a target.
pub struct SharedTarget {
    /// The place of the variable.
    pub place: CellRef,
    /// The place in the text.
    pub span: Span,
}

impl SharedTarget {
    #[inline]
    fn cell<'c>(&'c self, f: &'c Frame<'_>) -> Option<&'c Rc<CellVar>> {
        match &self.place {
            CellRef::Cell(slot) => match &f.slots[*slot as usize] {
                Value::Cell(cell) => Some(cell),
                _ => None,
            },
            CellRef::Free(index) => Some(&f.function.closure[*index as usize]),
            CellRef::Global(cell, _) => Some(cell),
        }
    }
}

impl Target for SharedTarget {
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        if let Some(cell) = self.cell(f) {
            // Globals are taken apart anyway.
            let is_global = matches!(self.place, CellRef::Global(..));
            if !is_global && !cell.noted.get() && value.can_hold_values() {
                ev.core.note_cell(cell);
            }
            let old = cell.replace(value);
            drop(old);
        }
        Ok(())
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        let old = self.cell(f).map(|cell| cell.take()).unwrap_or_default();
        if !old.is_unbound() {
            return Ok(());
        }
        let code = &f.function.code;
        let name = match &self.place {
            CellRef::Cell(slot) => code.slot_names[*slot as usize],
            CellRef::Free(index) => code.free_names[*index as usize],
            CellRef::Global(_, name) => *name,
        };
        let name = ev.core.symbols.name(name);
        Err(ev.raise(
            ExceptionKind::NameError,
            format!("name '{name}' is not defined"),
        ))
        .trace_at(ev, f, self.span)
    }
}

/// `value.name`
pub struct AttributeTarget {
    /// The object.
    pub value: Operand,
    /// The name.
    pub name: Symbol,
    /// The place in the text.
    pub span: Span,
    /// Version of the class and slot that were set last.
    pub cache: [Cell<(u32, u32)>; 2],
}

impl AttributeTarget {
    /// Sets the attribute of an instance whose class is known; the value back if more is to be done.
    #[inline(always)]
    pub fn set_fast(&self, instance: &Instance, value: Value) -> Result<(), Value> {
        match self.slot_for(instance, &value) {
            Some(slot) => instance.set_slot(slot, value),
            None => Err(value),
        }
    }

    /// Sets an attribute that an instance of a known class has already; what was there, or the new value back if more
    /// is to be done.
    #[inline(always)]
    pub fn replace_at_once(&self, instance: &Instance, value: Value) -> Result<Value, Value> {
        match self.slot_for(instance, &value) {
            Some(slot) => instance.replace_slot(slot, value),
            None => Err(value),
        }
    }

    /// The slot of an instance whose class is known, if it is noted already where the value demands it.
    #[inline(always)]
    fn slot_for(&self, instance: &Instance, value: &Value) -> Option<usize> {
        match instance.noted.get() || !value.can_hold_values() {
            true => self.slot(instance.class.known_version()?),
            false => None,
        }
    }

    /// `object.name = value` for an object that has been evaluated.
    #[inline(always)]
    pub fn set(&self, ev: &Evaluator<'_>, f: &Frame<'_>, object: &Value, value: Value) -> R<()> {
        let at_once = match object {
            Value::Instance(instance) => self.set_fast(instance, value),
            _ => Err(value),
        };
        match at_once {
            Ok(()) => Ok(()),
            Err(value) => self.set_slowly(ev, f, object, value),
        }
    }

    /// The slot that is known for instances of a class in the state `version`.
    #[inline(always)]
    fn slot(&self, version: u32) -> Option<usize> {
        let (first, second) = (self.cache[0].get(), self.cache[1].get());
        if first.0 == version {
            Some(first.1 as usize)
        } else if second.0 == version {
            Some(second.1 as usize)
        } else {
            None
        }
    }

    #[inline(never)]
    fn set_slowly(&self, ev: &Evaluator<'_>, f: &Frame<'_>, object: &Value, value: Value) -> R<()> {
        let Value::Instance(instance) = object else {
            return ev
                .set_attribute(object, self.name, value)
                .trace_at(ev, f, self.span);
        };
        if !instance.noted.get() && value.can_hold_values() {
            ev.core.note_instance(instance);
        }
        let mut value = value;
        if let Some(slot) = self.slot(instance.class.version()) {
            match instance.set_slot(slot, value) {
                Ok(()) => return Ok(()),
                Err(back) => value = back,
            }
        }
        ev.set_attribute(object, self.name, value)
            .trace_at(ev, f, self.span)?;
        self.learn(ev, object);
        Ok(())
    }

    fn learn(&self, ev: &Evaluator<'_>, object: &Value) {
        let Value::Instance(instance) = object else {
            return;
        };
        let class = &instance.class;
        let plain = class.is_script
            && class.lookup(crate::value::symbol::known::SETATTR).is_none()
            && instance
                .exception()
                .is_none_or(|_| !ev.is_exception_attribute(self.name))
            && class
                .lookup(self.name)
                .is_none_or(|found| !ev.is_data_descriptor(&found));
        if let (true, Some(slot)) = (plain, class.slot(self.name)) {
            self.cache[1].set(self.cache[0].get());
            self.cache[0].set((class.version(), slot as u32));
        }
    }
}

impl Evaluator<'_> {
    /// Attributes that exceptions have by nature are no slots.
    fn is_exception_attribute(&self, name: Symbol) -> bool {
        use crate::value::symbol::known;
        matches!(
            name,
            known::ARGS
                | known::CAUSE
                | known::CONTEXT
                | known::SUPPRESS_CONTEXT
                | known::TRACEBACK
        )
    }
}

impl Target for AttributeTarget {
    #[inline]
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        if let Operand::Local(local) = &self.value {
            local.check(ev, f)?;
            return self.set(ev, f, local.peek(f), value);
        }
        let object = self.value.eval(ev, f)?;
        self.set(ev, f, &object, value)
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        let object = self.value.eval(ev, f)?;
        ev.delete_attribute(&object, self.name)
            .trace_at(ev, f, self.span)
    }
}

/// `value[index]`
pub struct ItemTarget {
    /// The container.
    pub value: Operand,
    /// The index.
    pub index: Operand,
    /// Evaluating the index leaves local variables as they are.
    pub keeps: bool,
    /// The place in the text.
    pub span: Span,
}

impl Target for ItemTarget {
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        let mut value = value;
        if let Some(Value::Int(at)) = self.index.peek(f)
            && let Some(Some(list)) = self.value.with_variable(f, |container| match container {
                Value::List(list) if list.gc_tracked.get() || !value.can_hold_values() => {
                    Some(list.clone())
                }
                _ => None,
            })
        {
            match list.replace_at(*at, value) {
                Ok(old) => {
                    old.drop_inline();
                    return Ok(());
                }
                Err(back) => value = back,
            }
        }
        if let (Operand::Local(local), true) = (&self.value, self.keeps) {
            local.check(ev, f)?;
            let own;
            let index = match self.index.bound_ref(f) {
                Some(index) => index,
                None => {
                    own = self.index.eval(ev, f)?;
                    &own
                }
            };
            return ev
                .set_item(local.peek(f), index, value)
                .trace_at(ev, f, self.span);
        }
        let container = self.value.eval(ev, f)?;
        let index = self.index.eval(ev, f)?;
        ev.set_item(&container, &index, value)
            .trace_at(ev, f, self.span)
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        let container = self.value.eval(ev, f)?;
        let index = self.index.eval(ev, f)?;
        ev.delete_item(&container, &index)
            .trace_at(ev, f, self.span)
    }
}

/// A target that is most often a local variable, which is assigned to without a further node.
pub enum LocalOrTarget {
    /// A local variable.
    Local(SlotTarget),
    /// Anything else.
    Other(Box<dyn Target>),
}

impl LocalOrTarget {
    /// Puts a value there.
    #[inline(always)]
    pub fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        match self {
            LocalOrTarget::Local(local) => {
                f.slots[local.slot as usize].put(value);
                Ok(())
            }
            LocalOrTarget::Other(target) => target.assign(ev, f, value),
        }
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        match self {
            LocalOrTarget::Local(local) => local.delete(ev, f),
            LocalOrTarget::Other(target) => target.delete(ev, f),
        }
    }
}

/// `a, *b, c`
pub struct Unpack {
    /// The targets.
    pub targets: NodeList<LocalOrTarget>,
    /// The number of the target that takes all remaining items, if there is one with a star.
    pub star: Option<usize>,
    /// The place in the text.
    pub span: Span,
}

impl Target for Unpack {
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        if let (Value::Tuple(tuple), None) = (&value, self.star)
            && tuple.items().len() == self.targets.len()
        {
            for (target, item) in self.targets.iter().zip(tuple.items()) {
                target.assign(ev, f, item.clone())?;
            }
            return Ok(());
        }
        if let (Value::List(list), None) = (&value, self.star)
            && list.len() == self.targets.len()
        {
            // All items are taken before the first is assigned, which may change the list.
            return with_slots(self.targets.len(), |items| {
                for (place, item) in items.iter_mut().zip(&*list.borrow()) {
                    place.fill(item.clone());
                }
                for (target, item) in self.targets.iter().zip(items) {
                    target.assign(ev, f, std::mem::take(item))?;
                }
                Ok(())
            });
        }
        let items = self.items(ev, &value).trace_at(ev, f, self.span)?;
        for (target, item) in self.targets.iter().zip(items) {
            target.assign(ev, f, item)?;
        }
        Ok(())
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        self.targets
            .iter()
            .try_for_each(|target| target.delete(ev, f))
    }
}

impl Evaluator<'_> {
    fn iter_to_unpack(&self, value: &Value) -> R {
        self.iter(value).map_err(|raised| {
            if self.is_kind(&raised, ExceptionKind::TypeError) && !self.has_iteration(value) {
                let name = self.core.types.name_of(value);
                return self.type_error(format!("cannot unpack non-iterable {name} object"));
            }
            raised
        })
    }

    /// The items of something that has to have just so many.
    pub fn unpack_exact(&self, value: &Value, wanted: usize) -> R<Vec<Value>> {
        let iterator = self.iter_to_unpack(value)?;
        let mut items = Vec::with_capacity(wanted);
        while let Some(item) = self.next(&iterator)? {
            if items.len() == wanted {
                let text = format!("too many values to unpack (expected {wanted})");
                return Err(self.value_error(text));
            }
            items.push(item);
        }
        if items.len() < wanted {
            let text = format!(
                "not enough values to unpack (expected {wanted}, got {})",
                items.len()
            );
            return Err(self.value_error(text));
        }
        Ok(items)
    }
}

impl Unpack {
    /// One value for each target.
    fn items(&self, ev: &Evaluator<'_>, value: &Value) -> R<Vec<Value>> {
        let wanted = self.targets.len();
        let Some(star) = self.star else {
            return ev.unpack_exact(value, wanted);
        };
        let iterator = ev.iter_to_unpack(value)?;
        let mut items = Vec::with_capacity(wanted);
        while items.len() < star {
            match ev.next(&iterator)? {
                Some(item) => items.push(item),
                None => return Err(self.too_few(ev, items.len())),
            }
        }
        // Many of them stay where they are collected.
        let mut middle = ev.collect_rest(&iterator)?;
        let Some(last) = (star + middle.len() + 1).checked_sub(wanted) else {
            return Err(self.too_few(ev, star + middle.len()));
        };
        let last = middle.split_off(last);
        items.push(middle.into_list());
        items.extend(last);
        Ok(items)
    }

    #[cold]
    fn too_few(&self, ev: &Evaluator<'_>, got: usize) -> Unwind {
        let least = self.targets.len() - 1;
        ev.value_error(format!(
            "not enough values to unpack (expected at least {least}, got {got})"
        ))
    }
}
