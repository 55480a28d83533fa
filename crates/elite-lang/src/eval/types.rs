//! The builtin types and exceptions of one interpreter.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::value::class::BuiltinBase;
use crate::value::dict::ViewKind;
use crate::value::symbol::Symbols;
use crate::value::{Class, Iter, Value};

macro_rules! builtin_types {
    ($($field:ident = $text:literal, $base:ident;)*) => {
        /// One class for each builtin type.
        #[allow(missing_docs)]
        pub struct Types {
            pub object: Rc<Class>,
            /// Not a type: what every object has unless its class says otherwise (`builtins::types::object`).
            pub natural: Rc<Class>,
            $(pub $field: Rc<Class>,)*
            exceptions: Vec<Rc<Class>>,
        }

        /// The names of these types.
        pub const NAMES: &[&str] = &[$($text,)*];

        impl Types {
            fn make(object: Rc<Class>, exceptions: Vec<Rc<Class>>,
                make: impl Fn(&str, BuiltinBase) -> Rc<Class>) -> Self {
                let natural = Class::new("object", BuiltinBase::Object, Vec::new(), Vec::new(), false);
                Types { object, natural, $($field: make($text, BuiltinBase::$base),)* exceptions }
            }

            /// All types that are no exceptions.
            pub fn all(&self) -> Vec<&Rc<Class>> {
                vec![&self.object, $(&self.$field,)*]
            }
        }
    };
}

builtin_types! {
    type_ = "type", Type;
    none = "NoneType", NoneType;
    ellipsis = "ellipsis", EllipsisType;
    not_implemented = "NotImplementedType", NotImplementedType;
    int = "int", Int;
    float = "float", Float;
    complex = "complex", Complex;
    str = "str", Str;
    bytes = "bytes", Bytes;
    bytearray = "bytearray", ByteArray;
    list = "list", List;
    tuple = "tuple", Tuple;
    dict = "dict", Dict;
    dict_keys = "dict_keys", DictKeys;
    dict_values = "dict_values", DictValues;
    dict_items = "dict_items", DictItems;
    set = "set", Set;
    frozenset = "frozenset", FrozenSet;
    range = "range", Range;
    slice = "slice", Slice;
    function = "function", Function;
    method = "method", Method;
    builtin = "builtin_function_or_method", Builtin;
    method_descriptor = "method_descriptor", Builtin;
    wrapper_descriptor = "wrapper_descriptor", Builtin;
    method_wrapper = "method-wrapper", Builtin;
    module = "module", Module;
    iterator = "iterator", Iterator;
    list_iterator = "list_iterator", Iterator;
    tuple_iterator = "tuple_iterator", Iterator;
    str_iterator = "str_iterator", Iterator;
    str_ascii_iterator = "str_ascii_iterator", Iterator;
    bytes_iterator = "bytes_iterator", Iterator;
    range_iterator = "range_iterator", Iterator;
    longrange_iterator = "longrange_iterator", Iterator;
    dict_keyiterator = "dict_keyiterator", Iterator;
    dict_valueiterator = "dict_valueiterator", Iterator;
    dict_itemiterator = "dict_itemiterator", Iterator;
    dict_reversekeyiterator = "dict_reversekeyiterator", Iterator;
    dict_reversevalueiterator = "dict_reversevalueiterator", Iterator;
    dict_reverseitemiterator = "dict_reverseitemiterator", Iterator;
    bytearray_iterator = "bytearray_iterator", Iterator;
    set_iterator = "set_iterator", Iterator;
    list_reverseiterator = "list_reverseiterator", Iterator;
    callable_iterator = "callable_iterator", Iterator;
    map = "map", Iterator;
    filter = "filter", Iterator;
    zip = "zip", Iterator;
    enumerate = "enumerate", Iterator;
    reversed = "reversed", Iterator;
    generator = "generator", Generator;
    property = "property", Property;
    staticmethod = "staticmethod", StaticMethod;
    classmethod = "classmethod", ClassMethod;
    super_ = "super", Super;
    cell = "cell", Native;
    traceback = "traceback", Native;
    frame = "frame", Native;
    code = "code", Native;
    union = "UnionType", Native;
    getset_descriptor = "getset_descriptor", Native;
    member_descriptor = "member_descriptor", Native;
    bool = "bool", Bool;
}

/// `ExceptionGroup`, the only builtin type with two bases.
fn exception_group(known: &[Rc<Class>]) -> Rc<Class> {
    let bases = [ExceptionKind::BaseExceptionGroup, ExceptionKind::Exception]
        .map(|kind| known[kind as usize].clone());
    let mut ancestors = bases.to_vec();
    ancestors.extend(bases[1].mro_tail().iter().cloned());
    let name = ExceptionKind::ExceptionGroup.name();
    Class::new(name, BuiltinBase::Exception, bases.into(), ancestors, false)
}

impl Types {
    /// The types, without their methods.
    pub fn new(_symbols: &Symbols) -> Self {
        let object = Class::new("object", BuiltinBase::Object, Vec::new(), Vec::new(), false);
        let derive = |name: &str, base: BuiltinBase, parent: &Rc<Class>| {
            let mut ancestors = vec![parent.clone()];
            ancestors.extend(parent.mro_tail().iter().cloned());
            Class::new(name, base, vec![parent.clone()], ancestors, false)
        };
        let mut exceptions: Vec<Rc<Class>> = Vec::new();
        for kind in ExceptionKind::ALL {
            let parent = kind
                .parent()
                .map_or(&object, |parent| &exceptions[parent as usize])
                .clone();
            if *kind == ExceptionKind::ExceptionGroup {
                exceptions.push(exception_group(&exceptions));
                continue;
            }
            exceptions.push(derive(kind.name(), BuiltinBase::Exception, &parent));
        }
        let mut types = Types::make(object.clone(), exceptions, |name, base| {
            derive(name, base, &object)
        });
        types.bool = derive("bool", BuiltinBase::Bool, &types.int);
        types
    }

    /// The class of an exception kind.
    pub fn exception(&self, kind: ExceptionKind) -> &Rc<Class> {
        &self.exceptions[kind as usize]
    }

    /// All exception classes, in the order of `ExceptionKind::ALL`.
    pub fn exceptions(&self) -> &[Rc<Class>] {
        &self.exceptions
    }

    /// The class of a value.
    #[inline]
    pub fn of<'v>(&'v self, value: &'v Value) -> &'v Rc<Class> {
        match value {
            Value::Instance(instance) => &instance.class,
            Value::Unbound | Value::None => &self.none,
            Value::Ellipsis => &self.ellipsis,
            Value::NotImplemented => &self.not_implemented,
            Value::Bool(_) => &self.bool,
            Value::Int(_) | Value::BigInt(_) => &self.int,
            Value::Float(_) => &self.float,
            Value::Complex(_) => &self.complex,
            Value::Str(_) => &self.str,
            Value::Bytes(_) => &self.bytes,
            Value::ByteArray(_) => &self.bytearray,
            Value::List(_) => &self.list,
            Value::Tuple(_) => &self.tuple,
            Value::Dict(_) => &self.dict,
            Value::DictView(view) => match view.kind {
                ViewKind::Keys => &self.dict_keys,
                ViewKind::Values => &self.dict_values,
                ViewKind::Items => &self.dict_items,
            },
            Value::Set(_) => &self.set,
            Value::FrozenSet(_) => &self.frozenset,
            Value::Range(_) | Value::LongRange(_) => &self.range,
            Value::Slice(_) => &self.slice,
            Value::Function(_) => &self.function,
            Value::BoundMethod(method) => match &method.function {
                Value::Builtin(builtin) if builtin.is_slot => &self.method_wrapper,
                Value::Builtin(builtin) if builtin.owner.is_some() => &self.builtin,
                _ => &self.method,
            },
            Value::Builtin(builtin) if builtin.is_slot => &self.wrapper_descriptor,
            Value::Builtin(builtin) if builtin.owner.is_some() => &self.method_descriptor,
            Value::Builtin(_) => &self.builtin,
            Value::Class(class) => class.metaclass().unwrap_or(&self.type_),
            Value::Module(_) => &self.module,
            Value::Iter(iter) => self.of_iterator(iter),
            Value::Generator(_) => &self.generator,
            Value::Property(_) => &self.property,
            Value::StaticMethod(_) => &self.staticmethod,
            Value::ClassMethod(_) => &self.classmethod,
            Value::Super(_) => &self.super_,
            Value::Cell(_) => &self.cell,
            Value::Code(_) => &self.code,
        }
    }

    fn of_iterator<'v>(&'v self, iter: &'v Iter) -> &'v Rc<Class> {
        match iter {
            Iter::List { .. } => &self.list_iterator,
            Iter::Tuple { .. } => &self.tuple_iterator,
            Iter::Str { text, .. } if text.is_ascii() => &self.str_ascii_iterator,
            Iter::Str { .. } => &self.str_iterator,
            Iter::Bytes { .. } => &self.bytes_iterator,
            Iter::Range { .. } => &self.range_iterator,
            Iter::Dict {
                kind,
                reversed: true,
                ..
            } => match kind {
                ViewKind::Keys => &self.dict_reversekeyiterator,
                ViewKind::Values => &self.dict_reversevalueiterator,
                ViewKind::Items => &self.dict_reverseitemiterator,
            },
            Iter::Dict {
                kind: ViewKind::Keys,
                ..
            } => &self.dict_keyiterator,
            Iter::Dict {
                kind: ViewKind::Values,
                ..
            } => &self.dict_valueiterator,
            Iter::Dict {
                kind: ViewKind::Items,
                ..
            } => &self.dict_itemiterator,
            Iter::Set { .. } => &self.set_iterator,
            Iter::ListReversed { .. } => &self.list_reverseiterator,
            Iter::Callable { .. } => &self.callable_iterator,
            Iter::Map { .. } => &self.map,
            Iter::Filter { .. } => &self.filter,
            Iter::Zip { .. } => &self.zip,
            Iter::Enumerate { .. } => &self.enumerate,
            Iter::Sequence { reversed: true, .. } => &self.reversed,
            Iter::Sequence {
                object: Value::ByteArray(_),
                ..
            } => &self.bytearray_iterator,
            Iter::Sequence { .. } => &self.iterator,
            Iter::Native(native) => &native.class,
        }
    }

    /// All types of iterators.
    pub fn iterators(&self) -> Vec<&Rc<Class>> {
        self.all()
            .into_iter()
            .filter(|class| class.base == BuiltinBase::Iterator)
            .collect()
    }

    /// The name of a value's type for messages about an argument of the wrong type, which say `None` of `None`.
    pub fn name_of_argument(&self, value: &Value) -> Rc<str> {
        match value {
            Value::None => "None".into(),
            other => self.name_of(other),
        }
    }

    /// The name of a value's type, as messages use it.
    pub fn name_of(&self, value: &Value) -> Rc<str> {
        self.of(value).type_name()
    }

    /// Drops the attributes of all types, to break cycles when an interpreter ends.
    pub fn dismantle(&self) {
        for class in self
            .all()
            .into_iter()
            .chain(&self.exceptions)
            .chain([&self.natural])
        {
            class.dismantle();
        }
    }
}
