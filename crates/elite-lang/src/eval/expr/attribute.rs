//! `value.name`, with an inline cache.

use std::cell::Cell;
use std::rc::Rc;

use elite_syntax::Span;

use super::names::Readable;
use super::operand::Operand;
use crate::builtins::FastPath;
use crate::eval::words::PairOf;
use crate::eval::{Evaluator, ExprNode, Frame, TraceExt};
use crate::value::class::AttrLocation;
use crate::value::symbol::known;
use crate::value::{BoundMethod, CellVar, Class, Module, R, ScriptCell, Symbol, Value};

/// What a cache knows about an attribute of instances of one class in one state.
#[derive(Clone, Copy)]
pub enum CachedLookup {
    /// In the slot of the instance.
    Slot(u32),
    /// A function of the class; no instance has an attribute of that name.
    Method(AttrLocation),
    /// A property of the class.
    Property(AttrLocation),
    /// A plain value of the class; no instance has an attribute of that name.
    Plain(AttrLocation),
    /// A method of a builtin type that answers some calls at once.
    Quick(FastPath),
    /// A static method of the class; no instance has an attribute of that name.
    Static(AttrLocation),
    /// Something that is looked up each time.
    Other,
}

/// Where a member of a module was found last. Modules are few and last, so the way there is kept for one.
#[derive(Default)]
pub struct ModuleMemberCache(ScriptCell<Option<(Rc<Module>, Rc<CellVar>)>>);

impl ModuleMemberCache {
    /// The variable of this name; None if the module has none.
    #[inline]
    pub fn cell_of(&self, module: &Rc<Module>, name: Symbol) -> Option<Rc<CellVar>> {
        if let Some((known, cell)) = &*self.0.borrow()
            && Rc::ptr_eq(known, module)
            && !cell.value.borrow().is_unbound()
        {
            return Some(cell.clone());
        }
        self.find(module, name)
    }

    #[cold]
    fn find(&self, module: &Rc<Module>, name: Symbol) -> Option<Rc<CellVar>> {
        // What a module says of itself need not be in its namespace.
        if matches!(name, known::NAME | known::DICT | known::CLASS) {
            return None;
        }
        let cell = module.namespace.bound_cell(name)?;
        self.0.put(Some((module.clone(), cell.clone())));
        Some(cell)
    }
}

/// A cache for two classes: methods of a base class see instances of several.
pub struct InlineCache {
    /// The version of a class, which is never 0, and the slot of its instances.
    slots: [Cell<(u32, u32)>; 2],
    /// The version of a class, and what else is known about it.
    entries: [Cell<(u32, CachedLookup)>; 2],
}

impl Default for InlineCache {
    fn default() -> Self {
        InlineCache {
            slots: Default::default(),
            entries: [const { Cell::new((0, CachedLookup::Slot(0))) }; 2],
        }
    }
}

impl InlineCache {
    /// The slot of instances of a class in the state `version`, if that is what is known.
    #[inline(always)]
    pub fn slot(&self, version: u32) -> Option<usize> {
        let (first, second) = (self.slots[0].get(), self.slots[1].get());
        if first.0 == version {
            Some(first.1 as usize)
        } else if second.0 == version {
            Some(second.1 as usize)
        } else {
            None
        }
    }

    /// What is known for a class in the state `version`.
    #[inline(always)]
    pub fn get(&self, version: u32) -> Option<CachedLookup> {
        let [first, second] = &self.entries;
        if first.get().0 == version {
            return Some(first.get().1);
        }
        if second.get().0 == version {
            return Some(second.get().1);
        }
        self.slot(version)
            .map(|slot| CachedLookup::Slot(slot as u32))
    }

    /// The attribute of `value`, if the cache knows where it lies.
    #[inline(always)]
    pub fn read(&self, value: &Value) -> Option<Value> {
        let Value::Instance(instance) = value else {
            return None;
        };
        let version = instance.class.version();
        if let Some(slot) = self.slot(version) {
            return instance.slot(slot);
        }
        match self.get(version)? {
            CachedLookup::Plain(location) if !instance.in_dict.get() => {
                Some(instance.class.at(location))
            }
            CachedLookup::Slot(_)
            | CachedLookup::Method(_)
            | CachedLookup::Property(_)
            | CachedLookup::Quick(_)
            | CachedLookup::Static(_)
            | CachedLookup::Plain(_)
            | CachedLookup::Other => None,
        }
    }

    fn set(&self, version: u32, hint: CachedLookup) {
        if let CachedLookup::Slot(slot) = hint {
            self.slots[1].set(self.slots[0].get());
            self.slots[0].set((version, slot));
            return;
        }
        self.entries[1].set(self.entries[0].get());
        self.entries[0].set((version, hint));
    }

    /// Finds out what can be remembered about reading `name` of instances of `class`, and does.
    pub fn learn(&self, class: &Class, name: Symbol) -> Option<CachedLookup> {
        let hint = CachedLookup::about(class, name)?;
        self.set(class.version(), hint);
        Some(hint)
    }
}

impl CachedLookup {
    /// What can be remembered about reading `name` of instances of `class`.
    fn about(class: &Class, name: Symbol) -> Option<CachedLookup> {
        if class.lookup(known::GETATTRIBUTE).is_some() {
            return None;
        }
        let slot = class.slot(name);
        let hint = match (class.locate(name), slot) {
            (None, Some(slot)) => CachedLookup::Slot(slot as u32),
            (Some((location, Value::Property(_))), _) => CachedLookup::Property(location),
            (Some((_, Value::Instance(_) | Value::Super(_))), _) => return None,
            (Some((_, _)), Some(slot)) => CachedLookup::Slot(slot as u32),
            (Some((location, Value::Function(_))), None) => CachedLookup::Method(location),
            (Some((location, Value::Builtin(builtin))), None) if builtin.owner.is_some() => {
                let is_for = |owner: &str| owner == "object" || class.has_ancestor(owner);
                match builtin.fast_path {
                    Some(quick) if !class.is_script => CachedLookup::Quick(quick),
                    // A function of another type is refused when it is made a method.
                    _ if class.is_script && !builtin.owner.is_some_and(is_for) => {
                        CachedLookup::Other
                    }
                    _ => CachedLookup::Method(location),
                }
            }
            (Some((location, Value::StaticMethod(_))), None) => CachedLookup::Static(location),
            (Some((_, Value::ClassMethod(_))), None) => CachedLookup::Other,
            (Some((location, _)), None) => CachedLookup::Plain(location),
            (None, None) => return None,
        };
        Some(hint)
    }
}

/// What is known about attributes that are asked for by a text, whoever asks: by the class and the name.
pub struct LookupCache([Cell<(u32, Symbol, CachedLookup)>; HINTS]);

const HINTS: usize = 64;

impl Default for LookupCache {
    fn default() -> Self {
        LookupCache([const { Cell::new((0, Symbol(0), CachedLookup::Other)) }; HINTS])
    }
}

impl LookupCache {
    /// What is known about reading `name` of instances of `class`.
    #[inline]
    pub fn about(&self, class: &Class, name: Symbol) -> Option<CachedLookup> {
        let version = class.version();
        let place = &self.0[(version.wrapping_mul(31) ^ name.0) as usize % HINTS];
        let (known, of, hint) = place.get();
        if known == version && of == name {
            return Some(hint);
        }
        let hint = CachedLookup::about(class, name)?;
        place.set((class.version(), name, hint));
        Some(hint)
    }
}

/// `value.name`
pub struct Attribute {
    /// The object.
    pub value: Operand,
    /// The name.
    pub name: Symbol,
    /// The place in the text.
    pub span: Span,
    /// What is known about the attribute from earlier lookups.
    pub cache: InlineCache,
    /// Where the name was found last, if it belongs to a module.
    pub member: ModuleMemberCache,
}

impl ExprNode for Attribute {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match self.try_load(f) {
            Some(found) => Ok(found),
            None => self.find(ev, f).whole(),
        }
    }

    const HAS_TRY_LOAD: bool = true;

    #[inline(always)]
    fn try_load(&self, f: &Frame<'_>) -> Option<Value> {
        // SAFETY: copying a value counts one reference more and does nothing else.
        #[allow(unsafe_code)]
        unsafe { self.reach(f) }.cloned()
    }
}

impl Attribute {
    /// The attribute, wherever it is.
    #[inline(never)]
    fn find(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<R> {
        PairOf::pack(self.find_anywhere(ev, f))
    }

    #[inline(always)]
    fn find_anywhere(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if let Operand::Local(local) = &self.value {
            local.check(ev, f)?;
        }
        // SAFETY: what is found is copied, which counts a reference and does nothing else.
        #[allow(unsafe_code)]
        if let Some(receiver) = unsafe { self.value.value_ref(f) }
            && let Some(found) = self.cache.read(receiver)
        {
            return Ok(found);
        }
        if let Some(found) = self.of_module(f) {
            return Ok(found);
        }
        let value = self.value.eval(ev, f)?;
        self.of(&value, ev, f)
    }

    /// Where the attribute of an instance in a local variable lies, if that is known.
    ///
    /// # Safety
    /// The caller promises what `ScriptCell::get_unguarded` asks.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn reach<'v>(&'v self, f: &'v Frame<'_>) -> Option<&'v Value> {
        let Operand::Local(local) = &self.value else {
            return None;
        };
        let Value::Instance(instance) = local.peek(f) else {
            return None;
        };
        let slot = self.cache.slot(instance.class.known_version()?)?;
        // SAFETY: the caller's promise.
        unsafe { instance.glimpse(slot) }
    }

    /// What `with_value` makes of the attribute of an instance in a local variable, if it is known where it lies.
    #[inline(always)]
    pub fn look<T>(&self, f: &Frame<'_>, look: impl FnOnce(&Value) -> T) -> Option<T> {
        let Operand::Local(local) = &self.value else {
            return None;
        };
        let Value::Instance(instance) = local.peek(f) else {
            return None;
        };
        let slot = self.cache.slot(instance.class.version())?;
        instance.with_slot(slot, look)
    }

    /// The member of a module.
    #[inline]
    fn of_module(&self, f: &Frame<'_>) -> Option<Value> {
        self.value.with_value(f, |value| match value {
            Value::Module(module) => Some(self.member.cell_of(module, self.name)?.value.get()),
            _ => None,
        })?
    }

    #[inline]
    fn of(&self, value: &Value, ev: &Evaluator<'_>, f: &Frame<'_>) -> R {
        if let Some(found) = self.cache.read(value) {
            return Ok(found);
        }
        if let Value::Instance(instance) = value {
            let class = &instance.class;
            match self.cache.get(class.version()) {
                Some(CachedLookup::Property(location)) => {
                    if let Value::Property(property) = class.at(location)
                        && !property.get.is_none()
                    {
                        return ev
                            .call1(&property.get, value.clone())
                            .trace_at(ev, f, self.span);
                    }
                }
                Some(CachedLookup::Method(location)) if !instance.in_dict.get() => {
                    if let Some(function) = class.function_at(location) {
                        return Ok(Value::BoundMethod(Rc::new(BoundMethod {
                            receiver: value.clone(),
                            function: Value::Function(function),
                        })));
                    }
                }
                Some(_) => {}
                None => {
                    self.cache.learn(class, self.name);
                }
            }
        }
        ev.attribute(value, self.name).trace_at(ev, f, self.span)
    }
}
