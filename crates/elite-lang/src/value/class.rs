//! Classes: builtin types and those of scripts.
//!
//! Owns attribute lookup along the method resolution order and the version numbers that make inline caches safe:
//! a version names one state of one class, and changes whenever a cached answer could.

use std::cell::{Cell, OnceCell, Ref, RefCell};
use std::rc::Rc;

use super::attrs::AttrMap;
use super::by_symbol::{SymbolMap, SymbolSet};
use super::held::ScriptRef;
use super::symbol::known;
use super::weak::WeakList;
use super::{Function, ScriptCell, Symbol, Value};
use crate::limits::deferred_drop;

/// How instances of a class are laid out: which builtin type they extend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum BuiltinBase {
    Object,
    Type,
    NoneType,
    EllipsisType,
    NotImplementedType,
    Bool,
    Int,
    Float,
    Complex,
    Str,
    Bytes,
    ByteArray,
    List,
    Tuple,
    Dict,
    DictKeys,
    DictValues,
    DictItems,
    Set,
    FrozenSet,
    Range,
    Slice,
    Function,
    Method,
    Builtin,
    Module,
    Iterator,
    Generator,
    Property,
    StaticMethod,
    ClassMethod,
    Super,
    Exception,
    /// Instances carry data of the library (`Payload::Object`).
    Native,
}

/// Attributes of instances of one class: which slot holds which.
#[derive(Default)]
pub struct InstanceLayout {
    index: SymbolMap<u32>,
    names: Vec<Symbol>,
}

/// Names in `__slots__`.
struct SlotNames {
    /// In an order that does not depend on that of the script.
    sorted: Box<[Symbol]>,
    /// `__dict__` is among them: instances may have any other attribute, too.
    open: bool,
    /// `__weakref__` is among them.
    referable: bool,
}

impl SlotNames {
    fn has(&self, name: Symbol) -> bool {
        self.sorted.binary_search(&name).is_ok()
    }
}

/// Slots an instance may have; further attributes turn it into dictionary mode.
pub const LAYOUT_MAX: usize = 256;

impl InstanceLayout {
    /// The slot of an attribute.
    pub fn find(&self, name: Symbol) -> Option<usize> {
        if self.names.len() <= 8 {
            return self.names.iter().position(|other| *other == name);
        }
        self.index.get(&name).map(|index| *index as usize)
    }

    /// Attribute names in slot order.
    pub fn names(&self) -> &[Symbol] {
        &self.names
    }

    fn add(&mut self, name: Symbol) -> usize {
        self.index.insert(name, self.names.len() as u32);
        self.names.push(name);
        self.names.len() - 1
    }
}

/// Attributes under their names.
type MemberDescriptors = Box<[(Symbol, Value)]>;

/// A class.
pub struct Class {
    name: RefCell<Rc<str>>,
    /// `__qualname__`, if it is another one.
    qualname: RefCell<Option<Rc<str>>>,
    /// CPython has this class in C, so messages name it with its module.
    pub is_c_type: Cell<bool>,
    /// The builtin type its instances extend.
    pub base: BuiltinBase,
    bases: ScriptCell<Rc<[Rc<Class>]>>,
    /// The method resolution order without the class itself.
    ancestors: ScriptCell<Rc<[Rc<Class>]>>,
    attrs: ScriptCell<AttrMap>,
    /// How many attributes were there when it was made, those that are not written aside.
    body_attr_count: Cell<usize>,
    /// What it shows of the parts that it adds to its instances, once that has been asked for.
    pub member_descriptors: ScriptCell<Option<MemberDescriptors>>,
    version: Cell<u32>,
    subclasses: WeakList<Class>,
    layout: RefCell<InstanceLayout>,
    /// The only attributes instances may have (`__slots__`), those of the ancestors aside.
    slots: RefCell<Option<SlotNames>>,
    /// The class or an ancestor has had slots with names.
    slotted: Cell<bool>,
    /// The class of the class, if that is not `type`.
    metaclass: OnceCell<Rc<Class>>,
    /// A `class` statement made it; only such classes can be changed.
    pub is_script: bool,
    /// How instances are made, and the versions of the class and of its own class which that holds for.
    construct_path: Cell<(u32, u32, ConstructPath)>,
    is_abstract: Cell<bool>,
    /// Makes instances without going through `__new__` and `__init__` of scripts.
    pub constructor: ScriptCell<Value>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

thread_local! {
    static VERSION: Cell<u32> = const { Cell::new(FIRST_VERSION) };
}

/// The version of a class that nobody has asked for its version since it changed: nothing is cached of it, nor of any
/// class derived from it.
const UNKNOWN: u32 = 0;
/// Versions below are tags of builtin values, see `ops::attribute`.
const FIRST_VERSION: u32 = 1 << 8;

fn fresh_version() -> u32 {
    VERSION.with(|version| {
        // After four billion changes the numbers start again; a stale cache would have to survive all of them.
        let next = version.get().checked_add(1).unwrap_or(FIRST_VERSION);
        version.set(next);
        next
    })
}

/// How calling a class of a script makes an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstructPath {
    /// A plain object, then this `__init__`, which is a function.
    Init(AttrLocation),
    /// A plain object without `__init__`.
    NoInit,
    /// By its constructor, which is written in Rust.
    Native,
    /// With more care: `__new__`, a metaclass, a builtin type underneath.
    General,
}

/// Where an attribute was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AttrLocation {
    /// 0 for the class itself, otherwise 1 + the index of the ancestor.
    pub depth: u16,
    /// Index in the attributes of that class.
    pub index: u32,
}

impl Class {
    /// A class with the given linearised ancestors (itself excluded).
    pub fn new(
        name: &str,
        base: BuiltinBase,
        bases: Vec<Rc<Class>>,
        ancestors: Vec<Rc<Class>>,
        is_script: bool,
    ) -> Rc<Class> {
        let slotted = ancestors.iter().any(|class| class.slotted.get());
        let class = Rc::new(Class {
            name: RefCell::new(name.into()),
            qualname: RefCell::default(),
            is_c_type: Cell::new(false),
            base,
            bases: ScriptCell::new(bases.into()),
            ancestors: ScriptCell::new(ancestors.into()),
            attrs: ScriptCell::default(),
            body_attr_count: Cell::new(0),
            member_descriptors: ScriptCell::default(),
            version: Cell::new(UNKNOWN),
            subclasses: WeakList::default(),
            old: Cell::new(false),
            layout: RefCell::default(),
            slots: RefCell::default(),
            slotted: Cell::new(slotted),
            metaclass: OnceCell::new(),
            is_script,
            construct_path: Cell::new((0, 0, ConstructPath::General)),
            is_abstract: Cell::new(false),
            constructor: ScriptCell::default(),
        });
        for parent in &*class.bases() {
            parent.subclasses.push(&class);
        }
        class
    }

    /// `__name__`.
    pub fn name(&self) -> Rc<str> {
        self.name.borrow().clone()
    }

    /// The name in messages: of the library's types as CPython's own in C have it, `datetime.timedelta`.
    pub fn type_name(&self) -> Rc<str> {
        let name = self.name();
        if self.is_c_type.get()
            && let Some(Value::Str(module)) = self.attrs.borrow().get(super::symbol::known::MODULE)
        {
            return format!("{}.{name}", module.as_str()).into();
        }
        name
    }

    /// Whether it or an ancestor is a builtin type that is called `name`; a script may call its own classes so.
    pub fn has_builtin_ancestor(&self, name: &str) -> bool {
        let is_it = |class: &Class| !class.is_script && **class.name.borrow() == *name;
        is_it(self) || self.ancestors.borrow().iter().any(|class| is_it(class))
    }

    /// Whether it or an ancestor is called `name`.
    pub fn has_ancestor(&self, name: &str) -> bool {
        let is_it = |class: &Class| **class.name.borrow() == *name;
        is_it(self) || self.ancestors.borrow().iter().any(|class| is_it(class))
    }

    /// Changes `__name__`, not `__qualname__`.
    pub fn set_name(&self, name: &str) {
        let before = self.name.replace(name.into());
        self.qualname.borrow_mut().get_or_insert(before);
    }

    /// `__qualname__`
    pub fn qualname(&self) -> Rc<str> {
        self.qualname
            .borrow()
            .clone()
            .unwrap_or_else(|| self.name())
    }

    /// Changes `__qualname__`.
    pub fn set_qualname(&self, name: &str) {
        *self.qualname.borrow_mut() = (*name != *self.name()).then(|| name.into());
    }

    /// Notes that its own attributes are there; those that every class has follow.
    pub fn end_body_attrs(&self) {
        self.body_attr_count.set(self.attrs.borrow().index_count());
    }

    /// How many attributes were there then.
    pub fn body_attr_count(&self) -> usize {
        self.body_attr_count.get()
    }

    /// The class of the class, if that is not `type`.
    #[inline]
    pub fn metaclass(&self) -> Option<&Rc<Class>> {
        self.metaclass.get()
    }

    /// Sets the class of a class, once, when it is made.
    pub fn set_metaclass(&self, metaclass: Rc<Class>) {
        let set = self.metaclass.set(metaclass);
        debug_assert!(set.is_ok(), "a class changes its metaclass");
        self.construct_path.set((0, 0, ConstructPath::General));
    }

    /// An attribute that the metaclass has for its own; what `type` itself has does not count.
    pub fn meta_method(&self, name: Symbol) -> Option<Value> {
        let metaclass = self.metaclass()?;
        let of_class = |class: &Class| class.attrs.borrow().get(name).cloned();
        let ancestors = metaclass.ancestors.borrow();
        let mut scripts = ancestors.iter().filter(|class| class.is_script);
        of_class(metaclass).or_else(|| scripts.find_map(|class| of_class(class)))
    }

    /// Whether methods are missing, so that there are no instances.
    pub fn is_abstract(&self) -> bool {
        self.is_abstract.get()
    }

    /// Says whether methods are missing.
    pub fn set_abstract(&self, is_abstract: bool) {
        self.is_abstract.set(is_abstract);
        self.invalidate_versions();
    }

    /// `__bases__`.
    pub fn bases(&self) -> Rc<[Rc<Class>]> {
        self.bases.get()
    }

    /// The method resolution order without the class itself.
    pub fn mro_tail(&self) -> Rc<[Rc<Class>]> {
        self.ancestors.get()
    }

    /// The method resolution order.
    pub fn mro(self: &Rc<Self>) -> Vec<Rc<Class>> {
        let mut line = vec![self.clone()];
        line.extend(self.mro_tail().iter().cloned());
        line
    }

    /// Sets `__bases__`; the resolution order is another matter (`set_ancestors`).
    pub fn set_bases(self: &Rc<Self>, bases: Vec<Rc<Class>>) {
        for parent in &bases {
            if !parent.subclasses.lists(self) {
                parent.subclasses.push(self);
            }
        }
        self.bases.put(bases.into());
    }

    /// Sets the method resolution order without the class itself.
    pub fn set_ancestors(&self, ancestors: Vec<Rc<Class>>) {
        let slotted = ancestors.iter().any(|class| class.slotted.get());
        self.slotted.set(self.slotted.get() || slotted);
        self.ancestors.put(ancestors.into());
        self.invalidate_versions();
    }

    /// Names the present state of the class; equal versions mean that nothing an inline cache relies on has changed.
    #[inline]
    pub fn version(&self) -> u32 {
        match self.version.get() {
            UNKNOWN => self.assign_version(),
            version => version,
        }
    }

    /// The name of the present state, if it has one.
    #[inline(always)]
    pub fn known_version(&self) -> Option<u32> {
        Some(self.version.get()).filter(|version| *version != UNKNOWN)
    }

    /// Names the present state. The classes it is derived from get names, too, so that a change of one of them knows
    /// whether anything below has a name.
    #[cold]
    #[inline(never)]
    fn assign_version(&self) -> u32 {
        for class in self.ancestors.borrow().iter().map(|class| &**class) {
            if class.version.get() == UNKNOWN {
                class.version.set(fresh_version());
            }
        }
        self.version.set(fresh_version());
        self.version.get()
    }

    /// Whether the class is `other` or derived from it.
    pub fn is_subclass_of(&self, other: &Class) -> bool {
        std::ptr::eq(self, other)
            || self
                .ancestors
                .borrow()
                .iter()
                .any(|class| std::ptr::eq(&**class, other))
    }

    /// Classes derived directly from this one that are still alive.
    pub fn subclasses(&self) -> Vec<Rc<Class>> {
        let mut alive = Vec::new();
        self.some_subclasses(usize::MAX, usize::MAX, &mut alive);
        alive.reverse();
        alive
    }

    /// Appends those among the `count` listed ones before number `before`, last ones first; the number to go on with, 0
    /// at the end.
    pub fn some_subclasses(&self, before: usize, count: usize, out: &mut Vec<Rc<Class>>) -> usize {
        self.subclasses.each_alive_in(before, count, |class| {
            // Some may have other bases now.
            let bases = class.bases.borrow();
            if bases.iter().any(|base| std::ptr::eq(&**base, self)) {
                out.push(class.clone());
            }
        })
    }

    /// The attributes of the class itself.
    pub fn own_attrs(&self) -> ScriptRef<'_, AttrMap> {
        self.attrs.borrow()
    }

    /// Looks an attribute up along the method resolution order.
    pub fn lookup(&self, name: Symbol) -> Option<Value> {
        if let Some(value) = self.attrs.borrow().get(name) {
            return Some(value.clone());
        }
        let ancestors = self.ancestors.borrow();
        let of_class = |class: &Rc<Class>| class.attrs.borrow().get(name).cloned();
        ancestors.iter().find_map(of_class)
    }

    /// Like `lookup`, with the place for a cache.
    pub fn locate(&self, name: Symbol) -> Option<(AttrLocation, Value)> {
        let within = |class: &Class, depth: usize| {
            let attrs = class.attrs.borrow();
            let index = attrs.index_of(name)?;
            let value = attrs.get(name)?.clone();
            Some((
                AttrLocation {
                    depth: depth as u16,
                    index: index as u32,
                },
                value,
            ))
        };
        within(self, 0).or_else(|| {
            let ancestors = self.ancestors.borrow();
            let mut numbered = ancestors.iter().enumerate();
            numbered.find_map(|(i, class)| within(class, i + 1))
        })
    }

    /// The value at a place from `locate`, valid while the version is the same.
    #[inline]
    pub fn at(&self, location: AttrLocation) -> Value {
        let index = location.index as usize;
        let found = match location.depth {
            0 => self.attrs.borrow().at(index).cloned(),
            depth => {
                let ancestors = self.ancestors.borrow();
                ancestors[depth as usize - 1]
                    .attrs
                    .borrow()
                    .at(index)
                    .cloned()
            }
        };
        found.unwrap_or_default()
    }

    /// The function at a place from `locate`; None if something else is there.
    #[inline(always)]
    pub fn function_at(&self, location: AttrLocation) -> Option<Rc<Function>> {
        let within = |class: &Class| match class.attrs.borrow().at(location.index as usize) {
            Some(Value::Function(function)) => Some(function.clone()),
            _ => None,
        };
        match location.depth {
            0 => within(self),
            depth => within(&self.ancestors.borrow()[depth as usize - 1]),
        }
    }

    /// How calling the class makes an instance.
    #[inline]
    pub fn construct_path(&self) -> ConstructPath {
        let (version, of_metaclass, making) = self.construct_path.get();
        let metaclass = self.metaclass().map_or(0, |metaclass| metaclass.version());
        if version == self.version() && of_metaclass == metaclass {
            return making;
        }
        let making = self.find_making();
        self.construct_path.set((self.version(), metaclass, making));
        making
    }

    #[cold]
    fn find_making(&self) -> ConstructPath {
        if !self.is_script && self.metaclass().is_none() {
            return ConstructPath::Native;
        }
        let is_plain = self.is_script
            && self.base == BuiltinBase::Object
            && !self.is_abstract()
            && self.meta_method(known::CALL).is_none()
            && self.lookup(known::NEW).is_none();
        match self.locate(known::INIT) {
            Some((location, Value::Function(_))) if is_plain => ConstructPath::Init(location),
            None if is_plain => ConstructPath::NoInit,
            _ => ConstructPath::General,
        }
    }

    /// Looks an attribute up in the classes after `class` in this one's resolution order, as `super` does.
    pub fn lookup_after(&self, class: &Class, name: Symbol) -> Option<Value> {
        let ancestors = self.ancestors.borrow();
        let start = if std::ptr::eq(self, class) {
            0
        } else {
            ancestors
                .iter()
                .position(|other| std::ptr::eq(&**other, class))?
                + 1
        };
        ancestors[start..]
            .iter()
            .find_map(|class| class.attrs.borrow().get(name).cloned())
    }

    /// Sets an attribute of the class itself.
    pub fn set(&self, name: Symbol, value: Value) {
        let plain = is_plain(&value);
        let old = self.attrs.with_mut(|attrs| attrs.insert(name, value));
        // Caches read the value through its place, so a new plain value for an old one needs no new version.
        if old.is_unbound() || !plain || !is_plain(&old) {
            self.invalidate_versions();
        }
    }

    /// Deletes an attribute of the class itself.
    pub fn remove(&self, name: Symbol) -> bool {
        let removed = self.attrs.with_mut(|attrs| attrs.remove(name));
        if removed.is_some() {
            self.invalidate_versions();
        }
        removed.is_some()
    }

    /// The class and all derived from it have other versions from now on, one after the other: they may be derived a
    /// long way.
    fn invalidate_versions(&self) {
        let mut left = Vec::new();
        self.forget_version(&mut left);
        while let Some(class) = left.pop() {
            class.forget_version(&mut left);
        }
    }

    /// Forgets the version; appends the classes derived from this one whose versions are to be forgotten, too.
    fn forget_version(&self, left: &mut Vec<Rc<Class>>) {
        if self.version.replace(UNKNOWN) != UNKNOWN {
            // Subclasses with other bases by now lose nothing but what is cached of them.
            let named = |class: &Class| class.version.get() != UNKNOWN;
            self.subclasses
                .for_each_alive(|class| left.extend(named(class).then(|| class.clone())));
        }
    }

    /// The slot of an instance attribute, if instances of this class have ever had it.
    pub fn slot(&self, name: Symbol) -> Option<usize> {
        self.layout.borrow().find(name)
    }

    /// The slot for an instance attribute that is being set; None if there are too many.
    pub fn slot_for(&self, name: Symbol) -> Option<usize> {
        if let Some(slot) = self.slot(name) {
            return Some(slot);
        }
        let mut layout = self.layout.borrow_mut();
        if layout.names.len() >= LAYOUT_MAX {
            return None;
        }
        // An instance attribute may now hide one of the class that caches point to. Nothing changes for classes below:
        // they have layouts of their own.
        if self.version.get() != UNKNOWN {
            self.version.set(fresh_version());
        }
        Some(layout.add(name))
    }

    /// Sets the names in `__slots__`.
    pub fn set_slots(&self, names: &[Symbol]) {
        let mut names = names.to_vec();
        let open = names.contains(&known::DICT);
        let referable = names.contains(&known::WEAKREF);
        names.retain(|name| !matches!(*name, known::DICT | known::WEAKREF));
        names.sort_unstable();
        self.slotted.set(self.slotted.get() || !names.is_empty());
        *self.slots.borrow_mut() = Some(SlotNames {
            sorted: names.into(),
            open,
            referable,
        });
    }

    /// Whether `__slots__` of this class makes room for values.
    pub fn has_own_slots(&self) -> bool {
        let slots = self.slots.borrow();
        slots.as_ref().is_some_and(|slots| !slots.sorted.is_empty())
    }

    /// Whether this class makes room for any attribute, as those without `__slots__` do.
    pub fn adds_dict(&self) -> bool {
        let slots = self.slots.borrow();
        slots.as_ref().is_none_or(|slots| slots.open)
    }

    /// Whether this class makes room for weak references, as those without `__slots__` do.
    pub fn adds_weakref(&self) -> bool {
        let slots = self.slots.borrow();
        slots.as_ref().is_none_or(|slots| slots.referable)
    }

    /// The names in `__slots__` of this class.
    pub fn own_slots(&self) -> Vec<Symbol> {
        let slots = self.slots.borrow();
        slots
            .as_ref()
            .map_or_else(Vec::new, |slots| slots.sorted.to_vec())
    }

    /// Whether instances have a `__dict__`: exceptions do, others unless the class and all its ancestors have
    /// `__slots__`.
    pub fn has_dict(&self) -> bool {
        let is_open_script = |class: &Rc<Class>| class.is_script && class.adds_dict();
        let ancestors = self.ancestors.borrow();
        self.base == BuiltinBase::Exception
            || self.adds_dict()
            || ancestors.iter().any(is_open_script)
    }

    /// Whether instances may have an attribute of this name.
    pub fn takes_attribute(&self, name: Symbol) -> bool {
        self.has_dict() || self.has_slot(name)
    }

    /// Whether `__slots__` of the class or of an ancestor lists a name.
    pub fn has_slot(&self, name: Symbol) -> bool {
        if !self.slotted.get() {
            return false;
        }
        let ancestors = self.ancestors.borrow();
        self.has_own_slot(name) || ancestors.iter().any(|class| class.has_own_slot(name))
    }

    /// Whether `__slots__` of this class lists a name.
    pub fn has_own_slot(&self, name: Symbol) -> bool {
        let slots = self.slots.borrow();
        slots.as_ref().is_some_and(|slots| slots.has(name))
    }

    /// Adds up to `count` of the names of its attributes and of those of its instances to a set, from number `from` on;
    /// whether there are more.
    pub fn add_some_names_to(&self, set: &mut SymbolSet, from: usize, count: usize) -> bool {
        let (attrs, layout) = (self.attrs.borrow(), self.layout.borrow());
        let slots = self.slots.borrow();
        let slots = slots.as_ref().map_or(&[][..], |slots| &slots.sorted);
        let more = [attrs.names(), layout.names(), slots];
        let mut left = false;
        for names in more {
            let end = names.len().min(from + count);
            set.extend(names.get(from..end).unwrap_or_default().iter().copied());
            left |= end < names.len();
        }
        left
    }

    /// The instance layout.
    pub fn layout(&self) -> Ref<'_, InstanceLayout> {
        self.layout.borrow()
    }

    /// Whether instances have the same layout as those of another class: the same slots, and a `__dict__` or none.
    pub fn has_layout_of(&self, other: &Class) -> bool {
        let slots = |class: &Class| {
            let own = class.slots.borrow();
            own.as_ref().map(|slots| slots.sorted.clone())
        };
        self.base == other.base
            && self.has_dict() == other.has_dict()
            && (self.has_dict() || slots(self) == slots(other))
    }

    /// Runs `for_each_alive` on what it refers to, unless that is being changed.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        let (bases, ancestors) = (self.bases(), self.mro_tail());
        for class in bases.iter().chain(&*ancestors).chain(self.metaclass.get()) {
            each(&Value::Class(class.clone()));
        }
        if let Some(attrs) = self.attrs.try_borrow() {
            attrs.iter().for_each(|(_, value)| each(value));
        }
        if let Some(added) = self.member_descriptors.try_borrow()
            && let Some(added) = &*added
        {
            added.iter().for_each(|(_, value)| each(value));
        }
        if let Some(constructor) = self.constructor.try_borrow() {
            each(&constructor);
        }
    }

    /// Drops all attributes, to break cycles when an interpreter ends.
    pub fn dismantle(&self) {
        let values = self.attrs.with_mut(AttrMap::take_values);
        self.invalidate_versions();
        drop(self.member_descriptors.take());
        drop(values);
    }
}

/// Whether a class attribute is no descriptor, so that lookups through instances return it as it is.
fn is_plain(value: &Value) -> bool {
    !matches!(
        value,
        Value::Function(_)
            | Value::Builtin(_)
            | Value::Property(_)
            | Value::StaticMethod(_)
            | Value::ClassMethod(_)
            | Value::Instance(_)
            | Value::Super(_)
            | Value::Class(_)
    )
}

impl Drop for Class {
    fn drop(&mut self) {
        let mut values = self.attrs.get_mut().take_values();
        deferred_drop::drop_values(&mut values);
    }
}
