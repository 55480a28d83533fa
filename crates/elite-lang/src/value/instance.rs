//! Instances of classes: slots by the layout of their class, and what they extend.

use std::cell::Cell;
use std::rc::Rc;

use smallvec::SmallVec;

use super::data::NativeData;
use super::exception::ExceptionState;
use super::order::SlotOrder;
use super::{Class, Dict, ScriptCell, Symbol, Value};
use crate::limits::deferred_drop;

/// An object with a class.
pub struct Instance {
    /// The class of the object.
    pub class: Rc<Class>,
    attrs: ScriptCell<AttrStorage>,
    /// What the object is beyond its attributes.
    pub payload: InstancePayload,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
    /// The order in which the slots were set.
    order: Cell<SlotOrder>,
    /// The attributes are in a dictionary, which may have any name.
    pub in_dict: Cell<bool>,
}

/// Attributes by slot; as many as most objects have lie in the object itself.
type InlineSlots = SmallVec<[Value; 4]>;

/// Where the attributes are.
enum AttrStorage {
    /// By slot of the class's layout; short if the last ones were never set.
    Slots(InlineSlots),
    /// In a dictionary that scripts can see (`__dict__`), and those of `__slots__` in one that they cannot.
    Dict(Rc<Dict>, Option<Rc<Dict>>),
}

impl AttrStorage {
    /// The dictionary that has or is to have an attribute; None if there is none, or none yet.
    fn dict_with(&self, class: &Class, name: Symbol) -> Option<&Rc<Dict>> {
        match self {
            AttrStorage::Slots(_) => None,
            AttrStorage::Dict(_, hidden) if class.has_slot(name) => hidden.as_ref(),
            AttrStorage::Dict(dict, _) => Some(dict),
        }
    }
}

/// What an instance is beyond its attributes.
pub enum InstancePayload {
    /// Nothing.
    None,
    /// An exception.
    Exception(Box<ExceptionState>),
    /// The builtin value a subclass of a builtin type extends.
    Value(ScriptCell<Value>),
    /// Data of the library.
    Object(NativeData),
}

impl Instance {
    /// An instance without attributes.
    pub fn new(class: Rc<Class>, payload: InstancePayload) -> Rc<Self> {
        let width = class.layout().names().len();
        let attrs = ScriptCell::new(AttrStorage::Slots(InlineSlots::with_capacity(width)));
        Rc::new(Instance {
            class,
            attrs,
            payload,
            noted: Cell::new(false),
            old: Cell::new(false),
            order: Cell::default(),
            in_dict: Cell::new(false),
        })
    }

    /// Drops all attributes, to break cycles when an interpreter ends.
    pub fn dismantle(&self) {
        let attrs = self.attrs.replace(AttrStorage::Slots(InlineSlots::new()));
        self.order.take();
        match attrs {
            AttrStorage::Slots(mut slots) => deferred_drop::drop_slice(&mut slots),
            AttrStorage::Dict(dict, hidden) => {
                dict.clear();
                hidden.iter().for_each(|hidden| hidden.clear());
            }
        }
        match &self.payload {
            InstancePayload::Exception(state) => state.clear(),
            InstancePayload::Object(data) => data.clear(),
            _ => {}
        }
    }

    /// Runs `each` on the attributes and on what it holds beyond them, unless they are being changed.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        if let Some(attrs) = self.attrs.try_borrow() {
            match &*attrs {
                AttrStorage::Slots(slots) => slots.iter().for_each(&mut *each),
                AttrStorage::Dict(dict, hidden) => {
                    each(&Value::Dict(dict.clone()));
                    if let Some(hidden) = hidden {
                        each(&Value::Dict(hidden.clone()));
                    }
                }
            }
        }
        match &self.payload {
            InstancePayload::Value(value) => {
                if let Some(value) = value.try_borrow() {
                    each(&value);
                }
            }
            InstancePayload::Exception(state) => state.visit(each),
            InstancePayload::Object(data) => data.visit(each),
            InstancePayload::None => {}
        }
    }

    /// The exception state, if this is an exception.
    #[inline]
    pub fn exception(&self) -> Option<&ExceptionState> {
        match &self.payload {
            InstancePayload::Exception(state) => Some(state),
            _ => None,
        }
    }

    /// The builtin value this instance extends.
    pub fn builtin_value(&self) -> Option<Value> {
        match &self.payload {
            InstancePayload::Value(value) => Some(value.borrow().clone()),
            _ => None,
        }
    }

    /// The library data of type `T`.
    #[inline(always)]
    pub fn object<T: 'static>(&self) -> Option<&T> {
        match &self.payload {
            InstancePayload::Object(object) => object.get(),
            _ => None,
        }
    }

    /// Attribute in slot `slot`; None if not set or if the attributes are in a dictionary.
    #[inline(always)]
    pub fn slot(&self, slot: usize) -> Option<Value> {
        // SAFETY: the attribute is copied, which counts a reference and does nothing else.
        #[allow(unsafe_code)]
        unsafe { self.glimpse(slot) }.cloned()
    }

    /// Where the attribute in slot `slot` lies; None as in `slot`.
    ///
    /// # Safety
    /// The caller promises what `ScriptCell::get_unguarded` asks.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub(crate) unsafe fn glimpse(&self, slot: usize) -> Option<&Value> {
        // SAFETY: the caller's promise.
        match unsafe { self.attrs.get_unguarded() }? {
            AttrStorage::Slots(slots) => slots.get(slot).filter(|value| !value.is_unbound()),
            AttrStorage::Dict(..) => None,
        }
    }

    /// What `look` makes of the attribute in slot `slot`; None as in `slot`. No script code may run meanwhile.
    #[inline(always)]
    pub fn with_slot<T>(&self, slot: usize, look: impl FnOnce(&Value) -> T) -> Option<T> {
        match &*self.attrs.borrow() {
            AttrStorage::Slots(slots) => match slots.get(slot) {
                None | Some(Value::Unbound) => None,
                Some(value) => Some(look(value)),
            },
            AttrStorage::Dict(..) => None,
        }
    }

    /// Puts a value into slot `slot` in place of another one: the one that was there; the new one back if there was
    /// none.
    #[inline(always)]
    pub fn replace_slot(&self, slot: usize, value: Value) -> Result<Value, Value> {
        self.attrs.try_with_mut(value, |attrs, value| match attrs {
            AttrStorage::Slots(slots) => match slots.get_mut(slot) {
                Some(place) if !place.is_unbound() => Ok(std::mem::replace(place, value)),
                _ => Err(value),
            },
            AttrStorage::Dict(..) => Err(value),
        })
    }

    /// Sets the attribute in slot `slot`; the value back if the attributes are in a dictionary or have to be, because
    /// those behind the slot have been set before.
    #[inline(always)]
    pub fn set_slot(&self, slot: usize, value: Value) -> Result<(), Value> {
        match self.replace_slot(slot, value) {
            Ok(old) => {
                // Dropped only now: the old value's last reference may run script code.
                old.drop_inline();
                Ok(())
            }
            Err(value) => self.add_slot(slot, value),
        }
    }

    /// Sets a slot that is empty.
    #[inline(never)]
    fn add_slot(&self, slot: usize, value: Value) -> Result<(), Value> {
        self.attrs.with_mut(|attrs| match attrs {
            AttrStorage::Slots(slots) if !self.keeps_slot_order(slots, slot) => Err(value),
            AttrStorage::Slots(slots) if slot < slots.len() => {
                slots[slot] = value;
                Ok(())
            }
            AttrStorage::Slots(slots) => {
                slots.resize_with(slot, Value::default);
                slots.push(value);
                Ok(())
            }
            AttrStorage::Dict(..) => Err(value),
        })
    }

    /// Whether an empty slot may be set: scripts see attributes in the order in which they were set. That is the order
    /// of the slots, or kept beside them where it has a place; otherwise the attributes have to be in a dictionary.
    fn keeps_slot_order(&self, slots: &InlineSlots, slot: usize) -> bool {
        let before = self.order.get();
        let is_set = |at: &usize| !slots[*at].is_unbound();
        if before.is_natural() && !(slot..slots.len()).any(|at| is_set(&at)) {
            return true;
        }
        let before = match before.is_natural() {
            true => SlotOrder::of((0..slots.len()).filter(is_set)),
            false => Some(before),
        };
        match before.and_then(|before| before.with(slot)) {
            Some(order) => {
                self.order.set(order);
                true
            }
            None => false,
        }
    }

    /// The attribute `name` of the instance itself.
    pub fn get(&self, name: Symbol, symbols: &super::symbol::Symbols) -> Option<Value> {
        let value = match &*self.attrs.borrow() {
            AttrStorage::Slots(slots) => {
                let slot = self.class.slot(name)?;
                slots.get(slot).cloned()
            }
            attrs => attrs
                .dict_with(&self.class, name)?
                .get_str(&symbols.name(name)),
        };
        value.filter(|value| !value.is_unbound())
    }

    /// Sets the attribute `name` of the instance itself.
    pub fn set(&self, name: Symbol, value: Value, symbols: &super::symbol::Symbols) {
        // Slots are named; a dictionary has the text itself as its key.
        let in_dict = matches!(&*self.attrs.borrow(), AttrStorage::Dict(..));
        let slot = match in_dict {
            true => None,
            false => self.class.slot_for(name),
        };
        if slot.is_some() {
            symbols.mark_used(name);
        }
        let value = match slot {
            Some(slot) => match self.set_slot(slot, value) {
                Ok(()) => return,
                Err(value) => value,
            },
            None => value,
        };
        self.dict(symbols);
        let dict = self.attrs.with_mut(|attrs| {
            if let AttrStorage::Dict(_, hidden @ None) = attrs
                && self.class.has_slot(name)
            {
                *hidden = Some(Rc::new(Dict::new()));
            }
            attrs.dict_with(&self.class, name).cloned()
        });
        if let Some(dict) = dict {
            dict.set_interned(symbols.to_value(name), value);
        }
    }

    /// Deletes the attribute `name` of the instance itself; whether it was there.
    pub fn remove(&self, name: Symbol, symbols: &super::symbol::Symbols) -> bool {
        let removed = self.attrs.with_mut(|attrs| match attrs {
            AttrStorage::Slots(slots) => {
                let slot = self.class.slot(name)?;
                self.order.set(self.order.get().without(slot));
                slots.get_mut(slot).map(std::mem::take)
            }
            attrs => {
                let dict = attrs.dict_with(&self.class, name)?;
                let key = symbols.to_value(name);
                let Value::Str(text) = &key else { return None };
                match dict.find(text.hash(), &key) {
                    super::dict::KeySearch::At(index) => Some(dict.delete_at(index).1),
                    _ => None,
                }
            }
        });
        removed.is_some_and(|value| !value.is_unbound())
    }

    /// All attributes of the instance itself, in the order in which they were set.
    pub fn entries(&self, symbols: &super::symbol::Symbols) -> Vec<(Value, Value)> {
        match &*self.attrs.borrow() {
            AttrStorage::Slots(_) => {
                let named = self.named_slots(symbols).into_iter();
                named.map(|(_, key, value)| (key, value)).collect()
            }
            AttrStorage::Dict(dict, hidden) => {
                let hidden = hidden.as_ref().map(|hidden| hidden.entries());
                let entries = dict.entries().into_iter().chain(hidden.unwrap_or_default());
                entries.map(|(_, key, value)| (key, value)).collect()
            }
        }
    }

    /// Replaces all attributes of the instance itself but those of `__slots__` by those in a dictionary, live from now
    /// on.
    pub fn set_dict(&self, dict: Rc<Dict>, symbols: &super::symbol::Symbols) {
        self.dict(symbols);
        let old = self.attrs.with_mut(|attrs| match attrs {
            AttrStorage::Dict(place, _) => Some(std::mem::replace(place, dict)),
            AttrStorage::Slots(_) => None,
        });
        drop(old);
    }

    /// The dictionary its attributes are in, if they are in one.
    pub fn dict_if_any(&self) -> Option<Rc<Dict>> {
        match &*self.attrs.borrow() {
            AttrStorage::Slots(_) => None,
            AttrStorage::Dict(dict, _) => Some(dict.clone()),
        }
    }

    /// The attributes as a dictionary, live from now on (`__dict__`).
    pub fn dict(&self, symbols: &super::symbol::Symbols) -> Rc<Dict> {
        if let AttrStorage::Dict(dict, _) = &*self.attrs.borrow() {
            return dict.clone();
        }
        let (dict, mut hidden) = (Rc::new(Dict::new()), None);
        for (name, key, value) in self.named_slots(symbols) {
            match self.class.has_slot(name) {
                true => hidden.get_or_insert_with(|| Rc::new(Dict::new())),
                false => &dict,
            }
            .set_interned(key, value);
        }
        self.in_dict.set(true);
        self.order.take();
        self.attrs.put(AttrStorage::Dict(dict.clone(), hidden));
        dict
    }

    /// The attributes that lie in slots, with their names, in the order in which they were set.
    fn named_slots(&self, symbols: &super::symbol::Symbols) -> Vec<(Symbol, Value, Value)> {
        let AttrStorage::Slots(slots) = &*self.attrs.borrow() else {
            return Vec::new();
        };
        let layout = self.class.layout();
        let named = |slot: usize| {
            let (name, value) = (layout.names()[slot], &slots[slot]);
            (!value.is_unbound()).then(|| (name, symbols.to_value(name), value.clone()))
        };
        match self.order.get() {
            order if order.is_natural() => (0..slots.len()).filter_map(named).collect(),
            order => order.slots().filter_map(named).collect(),
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let AttrStorage::Slots(slots) = self.attrs.get_mut() {
            deferred_drop::drop_slice(slots);
        }
        match &mut self.payload {
            InstancePayload::Exception(state) => {
                let mut values = state.take_values();
                deferred_drop::drop_values(&mut values);
            }
            InstancePayload::Value(value) => deferred_drop::drop_value(value.get_mut()),
            // Data takes itself apart.
            InstancePayload::None | InstancePayload::Object(_) => {}
        }
    }
}
