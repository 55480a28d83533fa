//! What room the instances of a class have, as CPython lays them out: what its builtin type holds, slots, a dictionary,
//! a weak reference. What is in the slots is the business of `to_value::class`.

use std::collections::HashSet;
use std::rc::Rc;

use super::define::ATTRIBUTE;
use crate::eval::Evaluator;
use crate::value::class::BuiltinBase;
use crate::value::symbol::known;
use crate::value::{Class, R, Symbol, Value};

/// Whether `__slots__` says which attributes the instances have.
pub(super) fn takes_slots(base: BuiltinBase) -> bool {
    let is_container = matches!(
        base,
        BuiltinBase::List | BuiltinBase::Dict | BuiltinBase::Set | BuiltinBase::FrozenSet
    );
    let is_of_library = matches!(base, BuiltinBase::Native | BuiltinBase::Iterator);
    let is_other = matches!(
        base,
        BuiltinBase::Object
            | BuiltinBase::Exception
            | BuiltinBase::Str
            | BuiltinBase::Float
            | BuiltinBase::Complex
            | BuiltinBase::ByteArray
    );
    is_container || is_other || is_of_library || !has_room(base)
}

/// The nearest class that gives instances of a class more than those of its own ancestors have: slots, or what a
/// builtin type holds.
fn layout_owner(class: &Rc<Class>) -> Option<Rc<Class>> {
    let ancestors = class.mro_tail();
    let mut line = std::iter::once(class).chain(&*ancestors);
    let widest = line.find(|class| match class.is_script {
        true => class.has_own_slots(),
        false => class.base != BuiltinBase::Object,
    });
    widest.cloned()
}

/// The one of these bases that a class gets its layout from: that with the widest, `__base__`. None if they do not go
/// together.
pub fn best_base(parents: &[Rc<Class>]) -> Option<Rc<Class>> {
    let mut best = parents.first()?;
    let mut widest = None;
    if parents.len() > 1 {
        for parent in parents {
            let Some(wide) = layout_owner(parent) else {
                continue;
            };
            let is_wider = |wide: &Rc<Class>, than: &Rc<Class>| {
                wide.is_subclass_of(than) || !wide.is_script && wide.base == than.base
            };
            match &widest {
                Some(other) if is_wider(other, &wide) => continue,
                Some(other) if !is_wider(&wide, other) => return None,
                _ => (best, widest) = (parent, Some(wide)),
            }
        }
    }
    Some(best.clone())
}

/// The classes that a class gets its layout from: itself, its best base, that one's, and so on.
fn layout_chain(class: &Rc<Class>) -> impl Iterator<Item = Rc<Class>> {
    std::iter::successors(Some(class.clone()), |class| best_base(&class.bases()))
}

/// Whether CPython's layout of a class has a place for a dictionary of attributes.
pub fn has_dict(class: &Rc<Class>) -> bool {
    layout_chain(class).any(|class| match class.base {
        _ if class.is_script => class.adds_dict() && !is_closed_in_c(&class),
        BuiltinBase::Native => *class.type_name() == *"functools.partial",
        BuiltinBase::Exception
        | BuiltinBase::Type
        | BuiltinBase::Module
        | BuiltinBase::StaticMethod
        | BuiltinBase::ClassMethod => true,
        _ => false,
    })
}

/// Whether CPython has this class in C, without what a class of a script gives its instances.
fn is_closed_in_c(class: &Class) -> bool {
    class.is_c_type.get() && matches!(&*class.type_name(), "_struct.Struct" | "_thread._local")
}

/// Whether it has a place for weak references: some builtin types have one, and classes without `__slots__`.
pub fn is_weakly_referable(class: &Rc<Class>) -> bool {
    layout_chain(class).any(|class| match class.base {
        _ if class.is_script => class.adds_weakref() && has_room(class.base),
        BuiltinBase::Native => matches!(
            &*class.type_name(),
            "functools.partial" | "collections.deque" | "re.Pattern"
        ),
        BuiltinBase::Set | BuiltinBase::FrozenSet | BuiltinBase::Type | BuiltinBase::Module => true,
        _ => false,
    })
}

/// Whether CPython's layout of this builtin type has room for slots behind its items.
fn has_room(base: BuiltinBase) -> bool {
    !matches!(
        base,
        BuiltinBase::Int | BuiltinBase::Tuple | BuiltinBase::Bytes
    )
}

impl Evaluator<'_> {
    /// The names that `__slots__` lists.
    pub(super) fn slot_names(
        &self,
        listed: &Value,
        base: BuiltinBase,
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
        let best = best_base(parents);
        let mut has_dict = best.as_ref().is_some_and(has_dict);
        let mut is_referable = best.as_ref().is_some_and(is_weakly_referable);
        let mut slots = Vec::new();
        for slot in &names {
            let Value::Str(text) = slot else {
                let name = self.core.types.name_of(slot);
                let text = format!("__slots__ items must be strings, not '{name}'");
                return Err(self.type_error(text));
            };
            let name = self.intern_name(text.as_str())?;
            if !elite_syntax::lexer::is_name(text.as_str()) {
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
            self.charge(ATTRIBUTE)?;
        }
        let mut given = HashSet::new();
        for (name, _) in attrs.iter().filter(|_| !slots.is_empty()) {
            given.insert(*name);
            self.charge(ATTRIBUTE)?;
        }
        for name in &slots {
            self.charge(ATTRIBUTE)?;
            if given.contains(name) {
                let name = self.repr(&self.core.symbols.to_value(*name))?;
                let text = format!("{name} in __slots__ conflicts with class variable");
                return Err(self.value_error(text));
            }
        }
        Ok(slots)
    }

    /// The builtin layout that instances of a class with these bases have.
    pub fn layout_base(&self, parents: &[Rc<Class>]) -> R<BuiltinBase> {
        let conflict = || self.type_error("multiple bases have instance lay-out conflict");
        best_base(parents).ok_or_else(conflict)?;
        let mut base = BuiltinBase::Object;
        for parent in parents {
            if parent.base != BuiltinBase::Object && parent.base != base {
                if base != BuiltinBase::Object {
                    return Err(conflict());
                }
                base = parent.base;
            }
        }
        Ok(base)
    }

    /// What stands in the `__dict__` of a class for that which it adds to its instances: members for slots, `__dict__`,
    /// `__weakref__`. They are made when they are first asked for.
    pub fn member_descriptors(&self, class: &Rc<Class>) -> R<Vec<(Symbol, Value)>> {
        if let Some(known) = &*class.member_descriptors.borrow() {
            return Ok(known.to_vec());
        }
        let parts = self.find_added_parts(class)?;
        self.core.note_class(class);
        class.member_descriptors.put(Some(parts.as_slice().into()));
        Ok(parts)
    }

    /// One of them.
    pub fn added_part(&self, class: &Rc<Class>, name: Symbol) -> R<Option<Value>> {
        let parts = self.member_descriptors(class)?;
        let part = parts.into_iter().find(|(other, _)| *other == name);
        Ok(part.map(|(_, part)| part))
    }

    fn find_added_parts(&self, class: &Rc<Class>) -> R<Vec<(Symbol, Value)>> {
        let mut slots = Vec::new();
        for name in class.own_slots() {
            self.charge(ATTRIBUTE)?;
            slots.push((self.core.symbols.name(name), name));
        }
        slots.sort_unstable();
        let mut parts = Vec::new();
        for (_, name) in slots {
            self.charge(ATTRIBUTE)?;
            parts.push((name, self.make_descriptor(class.clone(), name, true, true)));
        }
        let bases = class.bases();
        let Some(best) = best_base(&bases) else {
            return Ok(parts);
        };
        let asked = [
            (
                known::DICT,
                class.adds_dict(),
                has_dict as fn(&Rc<Class>) -> bool,
            ),
            (
                known::WEAKREF,
                class.adds_weakref() && has_room(class.base),
                is_weakly_referable,
            ),
        ];
        for (name, is_asked_for, has) in asked {
            // Where there are `__slots__`, another base may add it.
            if !has(&best) && (is_asked_for || bases.iter().any(has)) {
                parts.push((
                    name,
                    self.make_descriptor(class.clone(), name, false, false),
                ));
            }
        }
        Ok(parts)
    }
}
