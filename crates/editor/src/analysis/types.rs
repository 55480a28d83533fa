//! What values are, as far as it costs little to tell: literals, results of builtins, instances of the program's
//! classes.
//!
//! A [`TypeRef`] is what the text says about a value, noted while the tree is walked; a [`Type`] is what that comes to
//! once all names are known.

use elite_runtime::builtins::declare::Builtin;

use super::library;
use super::scopes::{AttributeInfo, NameTables, ScopeId};

/// Steps that are followed to tell a type: names that lead to names end there.
const STEPS_MAX: u32 = 24;
/// Levels of an expression that are noted.
pub(super) const SHAPE_DEPTH_MAX: u32 = 8;

/// What the text says about a value.
#[derive(Clone, Debug)]
pub enum TypeRef {
    /// The text says nothing about the value.
    Unknown,
    /// A value of one of Python's own types.
    Value(&'static str),
    /// A list, tuple or set of such items.
    Container(&'static str, Box<TypeRef>),
    /// What a name stands for in a scope.
    Name(ScopeId, Box<str>),
    /// The result of calling it.
    Call(Box<TypeRef>),
    /// An attribute of it.
    Attribute(Box<TypeRef>, Box<str>),
    /// One of its items.
    Item(Box<TypeRef>),
    /// A function of the program.
    Function(usize),
    /// A class of the program.
    Class(usize),
    /// An instance of a class of the program.
    Instance(usize),
    /// A module.
    Module(Box<str>),
    /// What a module has.
    Member(Box<str>, Box<str>),
}

/// What a value is.
#[derive(Clone)]
pub enum Type {
    /// Nobody knows.
    Unknown,
    /// A value of one of Python's own types.
    Value(Box<str>),
    /// A list, tuple or set of such items.
    Container(Box<str>, Box<Type>),
    /// A function of the program.
    Function(usize),
    /// A class of the program.
    Class(usize),
    /// An instance of a class of the program.
    Instance(usize),
    /// A function of the robot.
    Robot(&'static Builtin),
    /// A function or class of Python's own.
    Python(Box<str>),
    /// A function or class of a module.
    Member(Box<str>, Box<str>),
    /// A method of one of Python's own types.
    Method(Box<str>, Box<str>),
    /// A module.
    Module(Box<str>),
    /// What tests of programs find as `test`.
    Test,
    /// A function of that.
    TestFunction(Box<str>),
}

impl Type {
    /// How people call it.
    pub fn describe(&self, names: &NameTables) -> Option<String> {
        Some(match self {
            Type::Value(name) => name.to_string(),
            Type::Container(name, item) => match item.describe(names) {
                Some(item) => format!("{name}[{item}]"),
                None => name.to_string(),
            },
            Type::Instance(class) => names.classes.get(*class)?.name.to_string(),
            Type::Class(class) => format!("type[{}]", names.classes.get(*class)?.name),
            Type::Module(name) => format!("module {name}"),
            _ => return None,
        })
    }
}

/// The type of a shape.
pub fn infer(names: &NameTables, shape: &TypeRef, is_test: bool) -> Type {
    Inference { names, is_test }.of(shape, STEPS_MAX)
}

/// The attribute `name` of a class, or of those it is derived from, with the class that has it.
pub fn attribute_of<'n>(
    names: &'n NameTables,
    class: usize,
    name: &str,
) -> Option<(usize, &'n AttributeInfo)> {
    class_and_ancestors(names, class)
        .into_iter()
        .find_map(|class| Some((class, names.classes[class].attribute(name)?)))
}

/// A class and those of the program it is derived from, itself first.
pub fn class_and_ancestors(names: &NameTables, class: usize) -> Vec<usize> {
    let mut found = vec![class];
    let mut at = 0;
    while let Some(class) = found.get(at).copied() {
        at += 1;
        let Some(info) = names.classes.get(class) else {
            continue;
        };
        for base in &info.bases {
            if let Type::Class(base) = infer(names, base, false)
                && !found.contains(&base)
            {
                found.push(base);
            }
        }
    }
    found.retain(|class| *class < names.classes.len());
    found
}

struct Inference<'n> {
    names: &'n NameTables,
    is_test: bool,
}

impl Inference<'_> {
    fn of(&self, shape: &TypeRef, steps: u32) -> Type {
        let Some(steps) = steps.checked_sub(1) else {
            return Type::Unknown;
        };
        match shape {
            TypeRef::Unknown => Type::Unknown,
            TypeRef::Value(name) => Type::Value((*name).into()),
            TypeRef::Container(name, item) => {
                Type::Container((*name).into(), Box::new(self.of(item, steps)))
            }
            TypeRef::Name(scope, name) => self.name(*scope, name, steps),
            TypeRef::Call(function) => self.called(&self.of(function, steps), steps),
            TypeRef::Attribute(value, name) => self.attribute(&self.of(value, steps), name, steps),
            TypeRef::Item(value) => match self.of(value, steps) {
                Type::Container(_, item) => *item,
                Type::Value(name) if &*name == "str" => Type::Value(name),
                Type::Value(name) if matches!(&*name, "bytes" | "bytearray" | "range") => {
                    Type::Value("int".into())
                }
                _ => Type::Unknown,
            },
            TypeRef::Function(function) => Type::Function(*function),
            TypeRef::Class(class) => Type::Class(*class),
            TypeRef::Instance(class) => Type::Instance(*class),
            TypeRef::Module(name) => Type::Module(name.clone()),
            TypeRef::Member(module, name) => self.member(module, name),
        }
    }

    fn name(&self, scope: ScopeId, name: &str, steps: u32) -> Type {
        if let Some(symbol) = self.names.lookup(scope, name) {
            let symbol = &self.names.symbols[symbol];
            let values = symbol.values.iter();
            // The first that tells something: programs seldom give a name values of two types.
            let mut types = values.map(|value| self.of(value, steps / 2));
            return types
                .find(|found| !matches!(found, Type::Unknown))
                .unwrap_or(Type::Unknown);
        }
        if self.is_test && name == script_test::OBJECT {
            return Type::Test;
        }
        if let Some(builtin) = library::robot(name) {
            return Type::Robot(builtin);
        }
        match library::is_python(name) {
            true => Type::Python(name.into()),
            false => Type::Unknown,
        }
    }

    fn called(&self, function: &Type, steps: u32) -> Type {
        match function {
            Type::Class(class) => Type::Instance(*class),
            Type::Function(function) => {
                let returns = self.names.functions.get(*function);
                let returns = returns.iter().flat_map(|info| &info.returns);
                let mut types = returns.map(|value| self.of(value, steps / 2));
                types
                    .find(|found| !matches!(found, Type::Unknown))
                    .unwrap_or(Type::Unknown)
            }
            Type::Robot(builtin) => library::returned(builtin.returns.english()),
            Type::Python(name) => library::result_of(name),
            Type::Method(owner, name) => library::result_of_method(owner, name),
            _ => Type::Unknown,
        }
    }

    fn attribute(&self, value: &Type, name: &str, steps: u32) -> Type {
        match value {
            Type::Instance(class) | Type::Class(class) => {
                let Some((_, found)) = attribute_of(self.names, *class, name) else {
                    return Type::Unknown;
                };
                if let Some(function) = found.function {
                    let is_property = self.names.functions[function].is_property;
                    let function = Type::Function(function);
                    return match is_property && matches!(value, Type::Instance(_)) {
                        true => self.called(&function, steps),
                        false => function,
                    };
                }
                let mut types = found.values.iter().map(|value| self.of(value, steps / 2));
                types
                    .find(|found| !matches!(found, Type::Unknown))
                    .unwrap_or(Type::Unknown)
            }
            Type::Value(owner) | Type::Container(owner, _) => {
                let known = library::members_of_type(owner);
                match known.iter().any(|member| member.name == name) {
                    true => Type::Method(owner.clone(), name.into()),
                    false => Type::Unknown,
                }
            }
            Type::Module(module) => self.member(module, name),
            Type::Test => Type::TestFunction(name.into()),
            _ => Type::Unknown,
        }
    }

    fn member(&self, module: &str, name: &str) -> Type {
        let found = library::members_of_module(module);
        let Some(member) = found.iter().find(|member| member.name == name) else {
            let inner = format!("{module}.{name}");
            return match elite_syntax::python_names::module_names().any(|known| known == inner) {
                true => Type::Module(inner.into()),
                false => Type::Unknown,
            };
        };
        match member.kind {
            elite_lang::library::MemberKind::Module => Type::Module(name.into()),
            elite_lang::library::MemberKind::Value => Type::Unknown,
            _ => Type::Member(module.into(), name.into()),
        }
    }
}
