//! What programs find without defining it: functions of the robot, Python's own types, functions and modules.
//!
//! Everything is asked once, of the declarations and of an interpreter, and kept.

use std::collections::{BTreeMap, HashMap};
use std::sync::LazyLock;

use elite_lang::library::LibraryMember;
use elite_runtime::builtins::declare::Builtin;
use parking_lot::Mutex;

use super::types::Type;
use super::words::Language;

/// Functions of the robot by name, in the order of their names.
pub static ROBOT: LazyLock<BTreeMap<&'static str, &'static Builtin>> = LazyLock::new(|| {
    elite_runtime::builtins::all()
        .map(|builtin| (builtin.name, builtin))
        .collect()
});

/// Python's own names, in the order of the names.
pub static PYTHON: LazyLock<BTreeMap<String, LibraryMember>> = LazyLock::new(|| {
    let found = elite_lang::library::builtins();
    found
        .into_iter()
        .map(|member| (member.name.clone(), member))
        .collect()
});

static TYPES: LazyLock<HashMap<String, &'static [LibraryMember]>> = LazyLock::new(|| {
    let found = elite_lang::library::type_members().into_iter();
    // The members are leaked on purpose: they are needed as long as the process lives.
    found
        .map(|(name, members)| (name, &*members.leak()))
        .collect()
});

/// Members of the modules that were asked for; there are as many as modules.
static MODULES: LazyLock<Mutex<HashMap<String, &'static [LibraryMember]>>> =
    LazyLock::new(Mutex::default);

/// The function of the robot with this name. `print` is Python's, whatever the listing says.
pub fn robot(name: &str) -> Option<&'static Builtin> {
    ROBOT.get(name).copied().filter(|_| name != "print")
}

/// Whether Python has a function, type or constant of this name.
pub fn is_python(name: &str) -> bool {
    elite_syntax::python_names::builtin_names().any(|known| known == name)
}

/// What values of a type of Python's own have.
pub fn members_of_type(name: &str) -> &'static [LibraryMember] {
    TYPES.get(name).copied().unwrap_or(&[])
}

/// What a module has; nothing if programs cannot import it.
pub fn members_of_module(name: &str) -> &'static [LibraryMember] {
    let mut modules = MODULES.lock();
    if let Some(known) = modules.get(name) {
        return known;
    }
    match elite_lang::library::module_members(name) {
        Some(found) => {
            let found: &'static [LibraryMember] = found.leak();
            modules.insert(name.to_owned(), found);
            found
        }
        None => &[],
    }
}

/// Asks for everything that does not depend on a program, before somebody waits for it.
pub fn prepare() {
    LazyLock::force(&ROBOT);
    LazyLock::force(&PYTHON);
    LazyLock::force(&TYPES);
}

/// The type that a function of the robot returns, from the words of its declaration.
pub fn returned(words: &str) -> Type {
    let first = words.split([',', ';', ':', ' ', '.']).next().unwrap_or("");
    let float = || Box::new(Type::Value("float".into()));
    match first {
        "int" | "float" | "bool" | "str" => Type::Value(first.into()),
        "nothing" => Type::Value("NoneType".into()),
        _ if words.starts_with("list of list") => Type::Container(
            "list".into(),
            Box::new(Type::Container("list".into(), float())),
        ),
        _ if first.starts_with("list") && words.contains("float") => {
            Type::Container("list".into(), float())
        }
        _ if first.starts_with("list") && words.contains("bool") => {
            Type::Container("list".into(), Box::new(Type::Value("bool".into())))
        }
        _ if first.starts_with("list[int]") && !words.contains("bytes") => {
            Type::Container("list".into(), Box::new(Type::Value("int".into())))
        }
        _ if first.starts_with("list") && !words.contains("bytes") => Type::Value("list".into()),
        _ => Type::Unknown,
    }
}

/// The type of what a function or type of Python's own returns, where it is always the same.
pub fn result_of(name: &str) -> Type {
    let name = match name {
        "int" | "float" | "complex" | "bool" | "str" | "bytes" | "bytearray" | "list" | "tuple"
        | "dict" | "set" | "frozenset" | "range" | "slice" | "object" => name,
        "len" | "ord" | "hash" | "id" | "round" => "int",
        "repr" | "ascii" | "chr" | "bin" | "hex" | "oct" | "format" | "input" => "str",
        "isinstance" | "issubclass" | "callable" | "hasattr" | "all" | "any" => "bool",
        "sorted" | "dir" => "list",
        "globals" | "locals" | "vars" => "dict",
        "divmod" => "tuple",
        "print" => "NoneType",
        _ if name.ends_with("Error") || name == "Exception" => "Exception",
        _ => return Type::Unknown,
    };
    Type::Value(name.into())
}

/// The type of what a method of a type of Python's own returns, where it is always the same.
pub fn result_of_method(owner: &str, name: &str) -> Type {
    let texts = || Type::Container("list".into(), Box::new(Type::Value("str".into())));
    let result = match (owner, name) {
        ("str", "split" | "rsplit" | "splitlines") => return texts(),
        ("str", "encode") => "bytes",
        ("bytes" | "bytearray", "decode" | "hex") => "str",
        ("str", "find" | "rfind" | "index" | "rindex" | "count") => "int",
        ("str", _) if name.starts_with("is") || name.ends_with("with") => "bool",
        ("str", "partition" | "rpartition") => "tuple",
        ("str", _) => "str",
        (_, "copy") => owner,
        ("list" | "tuple", "index" | "count") => "int",
        ("list", "append" | "extend" | "insert" | "remove" | "clear" | "sort" | "reverse") => {
            "NoneType"
        }
        ("set" | "frozenset", _) if name.ends_with("set") => "bool",
        ("set" | "frozenset", "union" | "intersection" | "difference" | "symmetric_difference") => {
            owner
        }
        _ => return Type::Unknown,
    };
    Type::Value(result.into())
}

/// Everything that is said of a function, in small letters and both languages: what searches look in.
pub fn searched_text(builtin: &Builtin) -> String {
    let mut text = format!(
        "{} {} {} {} {}",
        builtin.signature(),
        builtin.category.name(),
        builtin.section,
        builtin.summary.english(),
        builtin.returns.english()
    );
    for parameter in builtin.params {
        text.push_str(&format!(
            " {} {}",
            parameter.meaning.english(),
            parameter.unit
        ));
    }
    text.push(' ');
    text.push_str(builtin.summary.in_language(Language::Chinese));
    text.to_lowercase()
}
