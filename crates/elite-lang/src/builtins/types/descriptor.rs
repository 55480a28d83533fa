//! What classes show of attributes that lie in their instances: numbers of builtin types (`int.real`) and `__slots__`.

use std::rc::Rc;

use super::methods;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::data::{Contents, NativeData};
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, R, Symbol, Unwind, Value};

/// An attribute of the instances of a class.
struct Descriptor {
    owner: Rc<Class>,
    name: Symbol,
    /// A place in the instance, which in CPython a slot of `__slots__` is, too; otherwise a pair of functions.
    is_member: bool,
    /// A slot of `__slots__`.
    is_slot: bool,
}

impl Contents for Descriptor {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        each(&Value::Class(self.owner.clone()));
    }

    /// Nothing has to be let go of, for the descriptor cannot change.
    fn clear(&self, _: &mut Vec<Value>) {}

    fn take(&mut self, held: &mut Vec<Value>) {
        held.push(Value::Class(self.owner.clone()));
    }
}

pub(super) fn install(core: &Rc<InterpreterState>) {
    for class in [&core.types.getset_descriptor, &core.types.member_descriptor] {
        methods(
            core,
            class,
            &[
                ("__repr__", "", |ev, args| {
                    let descriptor = receiver(ev, &args[0])?;
                    let what = match descriptor.is_member {
                        true => "member",
                        false => "attribute",
                    };
                    ev.new_str(format!("<{what} {}>", descriptor.repr(ev)))
                }),
                ("__get__", "instance owner? /", |ev, args| {
                    let descriptor = receiver(ev, &args[0])?;
                    if args[1].is_none() {
                        if super::function::names_nothing(&args[2]) {
                            return Err(super::function::got_nothing(ev));
                        }
                        return Ok(args[0].clone());
                    }
                    descriptor.check(ev, &args[1])?;
                    match &args[1] {
                        _ if descriptor.name == known::WEAKREF => Ok(Value::None),
                        Value::Instance(instance) if descriptor.is_slot => {
                            let held = instance.get(descriptor.name, &ev.core.symbols);
                            held.ok_or_else(|| ev.attribute_error(&args[1], descriptor.name))
                        }
                        object => ev.attribute(object, descriptor.name),
                    }
                }),
                ("__set__", "instance value /", |ev, args| {
                    let descriptor = receiver(ev, &args[0])?;
                    descriptor.check(ev, &args[1])?;
                    match &args[1] {
                        Value::Instance(instance) if descriptor.is_slot => {
                            instance.set(descriptor.name, args[2].clone(), &ev.core.symbols);
                            if args[2].can_hold_values() {
                                ev.core.gc_track(&args[1]);
                            }
                            Ok(Value::None)
                        }
                        Value::Instance(instance)
                            if instance.exception().is_some() || descriptor.name == known::DICT =>
                        {
                            let new = args[2].clone();
                            ev.set_attribute(&args[1], descriptor.name, new)?;
                            Ok(Value::None)
                        }
                        _ => Err(ev.fixed_error(
                            &descriptor.owner,
                            descriptor.name,
                            descriptor.is_member,
                        )),
                    }
                }),
            ],
        );
    }
}

fn receiver<'v>(ev: &Evaluator<'_>, value: &'v Value) -> R<&'v Descriptor> {
    match value {
        Value::Instance(instance) => instance.object::<Descriptor>(),
        _ => None,
    }
    .ok_or_else(|| super::wrong_receiver(ev, "getset_descriptor", value))
}

impl Descriptor {
    fn repr(&self, ev: &Evaluator<'_>) -> String {
        let name = ev.core.symbols.name(self.name);
        format!("'{name}' of '{}' objects", self.owner.type_name())
    }

    /// Refuses an object that is no instance of the class.
    fn check(&self, ev: &Evaluator<'_>, value: &Value) -> R<()> {
        let class = ev.core.types.of(value);
        if class.is_subclass_of(&self.owner) {
            return Ok(());
        }
        let (name, owner) = (ev.core.symbols.name(self.name), self.owner.type_name());
        Err(ev.type_error(format!(
            "descriptor '{name}' for '{owner}' objects doesn't apply to a '{}' object",
            class.type_name()
        )))
    }
}

/// Attributes of builtin types that are not in the class: of which, whether they are members, their names.
const BUILTIN_MEMBERS: &[(&str, bool, &[&str])] = &[
    ("int", false, &["real", "imag", "numerator", "denominator"]),
    ("float", false, &["real", "imag"]),
    ("complex", true, &["real", "imag"]),
    ("range", true, &["start", "stop", "step"]),
    ("slice", true, &["start", "stop", "step"]),
    ("property", true, &["fget", "fset", "fdel"]),
    ("property", false, &["__isabstractmethod__"]),
    (
        "BaseException",
        false,
        &["args", "__cause__", "__context__", "__traceback__"],
    ),
    ("BaseException", true, &["__suppress_context__"]),
    ("method_descriptor", true, &["__name__", "__objclass__"]),
    ("method_descriptor", false, &["__qualname__"]),
    ("wrapper_descriptor", true, &["__name__", "__objclass__"]),
    ("wrapper_descriptor", false, &["__qualname__"]),
    ("method-wrapper", true, &["__self__"]),
    (
        "method-wrapper",
        false,
        &["__name__", "__objclass__", "__qualname__"],
    ),
    (
        "builtin_function_or_method",
        false,
        &["__name__", "__qualname__", "__self__"],
    ),
    ("staticmethod", true, &["__func__", "__wrapped__"]),
    ("staticmethod", false, &["__isabstractmethod__"]),
    ("classmethod", true, &["__func__", "__wrapped__"]),
    ("classmethod", false, &["__isabstractmethod__"]),
    (
        "super",
        true,
        &["__self__", "__self_class__", "__thisclass__"],
    ),
    ("BaseExceptionGroup", true, &["message", "exceptions"]),
    (
        "OSError",
        true,
        &["errno", "strerror", "filename", "filename2"],
    ),
    ("StopIteration", true, &["value"]),
    ("SystemExit", true, &["code"]),
    ("ImportError", true, &["msg", "name", "path"]),
    ("NameError", true, &["name"]),
    ("AttributeError", true, &["name", "obj"]),
    (
        "generator",
        false,
        &[
            "gi_code",
            "gi_frame",
            "gi_running",
            "gi_suspended",
            "gi_yieldfrom",
        ],
    ),
];

/// Classes of the library that CPython has in C, as messages name them, and those of their properties that are members
/// there.
const IN_LIBRARY: &[(&str, &[&str])] = &[
    ("datetime.date", &[]),
    ("datetime.datetime", &[]),
    ("datetime.time", &[]),
    ("datetime.timedelta", &["days", "seconds", "microseconds"]),
    ("re.Match", &["string", "re", "pos", "endpos"]),
    ("re.Pattern", &["pattern", "flags", "groups"]),
    ("collections.deque", &[]),
    ("_struct.Struct", &[]),
    ("_io.StringIO", &[]),
    ("_io.BytesIO", &[]),
];

/// Whether instances of a builtin type have an attribute that is not in the class, and whether it is a member.
fn of_builtin(class: &Class, name: &str) -> Option<bool> {
    parts_of(class).find_map(|(names, is_member)| names.contains(&name).then_some(is_member))
}

fn parts_of(class: &Class) -> impl Iterator<Item = (&'static [&'static str], bool)> {
    let class_name = class.name();
    BUILTIN_MEMBERS
        .iter()
        .filter(move |(owner, ..)| **owner == *class_name)
        .map(|(_, is_member, names)| (*names, *is_member))
}

/// The names of the attributes that a builtin type has without having them in the class.
pub fn hidden_names(class: &Class) -> impl Iterator<Item = &'static str> {
    let is_builtin = !class.is_script;
    parts_of(class)
        .filter(move |_| is_builtin)
        .flat_map(|(names, _)| names.iter().copied())
}

impl Evaluator<'_> {
    /// What a class shows of an attribute of its instances; None if it knows of none.
    pub fn descriptor(&self, class: &Rc<Class>, name: Symbol) -> R<Option<Value>> {
        let text = self.core.symbols.name(name);
        for owner in class.mro() {
            if owner.is_script {
                if (name == known::WEAKREF || owner.has_own_slot(name))
                    && let Some(part) = self.added_part(&owner, name)?
                {
                    return Ok(Some(part));
                }
            } else if let Some(is_member) = of_builtin(&owner, &text) {
                return Ok(Some(self.make_descriptor(owner, name, is_member, false)));
            }
        }
        Ok(None)
    }

    /// What a class shows of a property of one of the library that CPython has in C; None for other properties.
    #[cold]
    pub fn shown_property(&self, class: &Rc<Class>, name: Symbol) -> Option<Value> {
        let (owner, is_member) = self.property_in_c(class, name)?;
        Some(self.make_descriptor(owner, name, is_member, false))
    }

    /// The class of the library that has a property which in CPython is one of C, and whether it is a member there.
    fn property_in_c(&self, class: &Rc<Class>, name: Symbol) -> Option<(Rc<Class>, bool)> {
        let owner = class
            .mro()
            .into_iter()
            .find(|owner| owner.own_attrs().get(name).is_some())?;
        if !owner.is_c_type.get() {
            return None;
        }
        let (known, text) = (owner.type_name(), self.core.symbols.name(name));
        let (_, members) = IN_LIBRARY.iter().find(|(name, _)| **name == *known)?;
        let is_member = members.contains(&&*text);
        Some((owner, is_member))
    }

    /// What is said of setting or deleting an attribute that CPython's type in C gives out for reading only; None for
    /// other attributes.
    #[cold]
    pub fn refused_by_type(&self, value: &Value, name: Symbol) -> Option<Unwind> {
        let class = self.core.types.of(value);
        let (owner, is_member) = match class.lookup(name) {
            Some(Value::Property(_)) => self.property_in_c(class, name)?,
            Some(_) => return None,
            None => {
                let text = self.core.symbols.name(name);
                let mut line = class.mro().into_iter().filter(|owner| !owner.is_script);
                line.find_map(|owner| {
                    of_builtin(&owner, &text).map(|is_member| (owner, is_member))
                })?
            }
        };
        Some(self.fixed_error(&owner, name, is_member))
    }

    #[cold]
    fn fixed_error(&self, owner: &Class, name: Symbol, is_member: bool) -> Unwind {
        let text = match is_member {
            true => "readonly attribute".to_owned(),
            false => format!(
                "attribute '{}' of '{}' objects is not writable",
                self.core.symbols.name(name),
                owner.type_name()
            ),
        };
        self.raise(ExceptionKind::AttributeError, text)
    }

    /// What a class shows of an attribute of its instances.
    pub fn make_descriptor(
        &self,
        owner: Rc<Class>,
        name: Symbol,
        is_member: bool,
        is_slot: bool,
    ) -> Value {
        let class = match is_member {
            true => &self.core.types.member_descriptor,
            false => &self.core.types.getset_descriptor,
        };
        let shown = [
            (known::NAME, self.core.symbols.to_value(name)),
            (known::OBJCLASS, Value::Class(owner.clone())),
        ];
        let descriptor = Descriptor {
            owner,
            name,
            is_member,
            is_slot,
        };
        let made = Instance::new(
            class.clone(),
            InstancePayload::Object(NativeData::new(descriptor)),
        );
        for (name, value) in shown {
            made.set(name, value, &self.core.symbols);
        }
        let made = Value::Instance(made);
        self.core.gc_track(&made);
        made
    }
}
