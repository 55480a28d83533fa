//! Each method and operator of each container, called with objects whose methods change the container meanwhile, on
//! contents that change it when they are dropped. Nothing panics (a look or change that is open while script code runs
//! does, see `value::held`), and what comes out is what CPython gives, where there is one to ask.

mod differences;
mod kinds;
mod uses;

use differences::{NOT_FOR_CPYTHON, ONLY_HERE, is_meant};
use kinds::{CONTENTS, ContainerKind, KINDS};
use uses::{ARGUMENTS, ONLY_SURVIVED, USES};

use super::{cpython, run, task};
use crate::Value;
use crate::value::Class;

/// The trials of each kind of value, by name; none where nothing can be changed after it was made. There is no
/// wildcard, so a new kind of value has to be put here.
fn trials_of(value: &Value) -> &'static [&'static str] {
    match value {
        Value::List(_) => &["list", "subclass of list"],
        Value::Dict(_) => &["dict", "subclass of dict"],
        // A view shows what its dictionary holds.
        Value::DictView(_) => &["dict"],
        Value::Set(_) => &["set"],
        Value::ByteArray(_) => &["bytearray"],
        // Exceptions, deques and files are instances.
        Value::Instance(_) => &[
            "instance",
            "exception",
            "deque",
            "ordered dict",
            "dict with defaults",
            "counter",
            "file",
            "file of bytes",
        ],
        Value::Class(_) => &["class"],
        Value::Function(_) => &["function"],
        // Iterators change as they are walked through, which every kind is.
        Value::Iter(_) | Value::Generator(_) => &["list", "dict", "set", "deque"],
        Value::Unbound
        | Value::None
        | Value::Ellipsis
        | Value::NotImplemented
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Float(_)
        | Value::BigInt(_)
        | Value::Complex(_)
        | Value::Str(_)
        | Value::Bytes(_)
        | Value::Tuple(_)
        | Value::FrozenSet(_)
        | Value::Range(_)
        | Value::LongRange(_)
        | Value::Slice(_)
        | Value::BoundMethod(_)
        | Value::Builtin(_)
        | Value::Module(_)
        | Value::Property(_)
        | Value::StaticMethod(_)
        | Value::ClassMethod(_)
        | Value::Super(_)
        | Value::Cell(_)
        | Value::Code(_) => &[],
    }
}

const PRELUDE: &str = include_str!("prelude.script");

/// The methods of a kind of container, from the table of its type.
fn methods(kind: &ContainerKind) -> Vec<String> {
    let (stage, interpreter) = task();
    let text = format!(
        "{PRELUDE}\ni = []\ntypes = type({}).__mro__[:-1]\n",
        kind.make
    );
    let main = super::begin(&interpreter, &text);
    assert_eq!(super::drive(&stage, main), "");
    let Some(Value::Tuple(classes)) = interpreter.global("types") else {
        panic!("{} has no type", kind.name);
    };
    let own = |class: &Class| -> Vec<String> {
        let attrs = class.own_attrs();
        let symbols = &interpreter.core().symbols;
        attrs
            .iter()
            .filter(|(_, value)| matches!(value, Value::Builtin(_)))
            .map(|(name, _)| symbols.name(name).to_string())
            .collect()
    };
    // What a class of the library does in its own way, and what it has from the builtin type.
    let mut names = Vec::new();
    for class in classes.items() {
        let Value::Class(class) = class else { continue };
        for name in own(class) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// All uses to compare with CPython.
fn compared(kind: &ContainerKind) -> Vec<String> {
    let of_items = if kind.has_items { USES } else { &[] };
    let uses = of_items.iter().chain(kind.uses);
    let mut uses: Vec<String> = uses.map(|use_| (*use_).to_owned()).collect();
    if !kind.has_items {
        return uses;
    }
    let methods = methods(kind);
    assert!(methods.len() > 8, "{}: {methods:?}", kind.name);
    for method in methods {
        uses.extend(ARGUMENTS.iter().map(|args| format!("c.{method}({args})")));
    }
    uses.retain(|use_| !NOT_FOR_CPYTHON.contains(&(kind.name, use_)));
    uses
}

fn program(kind: &ContainerKind, uses: &[String]) -> String {
    let mut text = PRELUDE.to_owned();
    text += &format!("def make_(i): return {}\n", kind.make);
    for (number, content) in CONTENTS.iter().enumerate() {
        text += &format!("def items{number}(): return {content}\n");
    }
    for (number, effect) in kind.effects.iter().enumerate() {
        text += &format!(
            "def effect{number}():\n    if c is not None{}: {effect}\n",
            if kind.has_items {
                " and len(c) < 40"
            } else {
                ""
            },
        );
    }
    text += "uses = [\n";
    for use_ in uses {
        text += &format!("    ({use_:?}, lambda c, i: {use_}),\n");
    }
    text += "]\nfor name, use in uses:\n";
    for content in 0..CONTENTS.len() {
        for effect in 0..kind.effects.len() {
            text += &format!(
                "    trial(make_, items{content}, effect{effect}, use, f'{{name}} | {content} {effect}')\n"
            );
        }
    }
    text
}

fn trials(index: usize) {
    let kind = &KINDS[index];
    let spared = NOT_FOR_CPYTHON
        .iter()
        .filter(|(name, _)| *name == kind.name);
    let survived = ONLY_SURVIVED.iter().chain(spared.map(|(_, use_)| use_));
    let mut survived: Vec<String> = survived.map(|use_| (*use_).to_owned()).collect();
    if !kind.has_items {
        survived.extend(USES.iter().map(|use_| (*use_).to_owned()));
        for method in methods(kind) {
            survived.extend(ARGUMENTS.iter().map(|args| format!("c.{method}({args})")));
        }
    }
    let more = "import statistics, random, struct, re, enum, string, io, queue, dataclasses\n\
                def textwrapped(c): return 'x'.translate(c)\n";
    let count = survived.len() * CONTENTS.len() * kind.effects.len();
    let lines = run(&(more.to_owned() + &program(kind, &survived)));
    assert_eq!(lines.lines().count(), count, "{}: {lines}", kind.name);
    let text = program(kind, &compared(kind));
    if let Ok(folder) = std::env::var("TRIALS") {
        std::fs::write(format!("{folder}/{index}.py"), &text).unwrap();
    }
    let ours = run(&text);
    let count = ours.lines().count();
    assert!(count > 200, "{}: {ours}", kind.name);
    if ONLY_HERE.iter().any(|(name, _)| *name == kind.name) {
        return;
    }
    let Some(theirs) = cpython(&text) else {
        return;
    };
    let differing: Vec<String> = ours
        .lines()
        .zip(theirs.lines())
        .filter(|(ours, theirs)| {
            without_addresses(ours) != without_addresses(theirs) && !is_meant(kind, ours, theirs)
        })
        .map(|(ours, theirs)| format!("ours   {ours}\ntheirs {theirs}"))
        .collect();
    assert!(
        differing.is_empty() && theirs.lines().count() == count,
        "{}: {} of {count} lines differ:\n{}",
        kind.name,
        differing.len(),
        differing[..differing.len().min(400)].join("\n")
    );
}

fn without_addresses(line: &str) -> String {
    let mut parts = line.split(" at 0x");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        out += part.trim_start_matches(|c: char| c.is_ascii_hexdigit());
    }
    out
}

macro_rules! kinds {
    ($($name:ident $index:literal;)*) => {
        $(#[test] fn $name() { trials($index); })*
        const _: () = assert!([$($index,)*].len() == KINDS.len());
    };
}

kinds! {
    a_list_that_changes_meanwhile_does_as_in_cpython 0;
    a_deque_that_changes_meanwhile_does_as_in_cpython 1;
    a_bytearray_that_changes_meanwhile_does_as_in_cpython 2;
    a_dict_that_changes_meanwhile_does_as_in_cpython 3;
    a_set_that_changes_meanwhile_does_as_in_cpython 4;
    a_subclass_of_list_that_changes_meanwhile_does_as_in_cpython 5;
    a_subclass_of_dict_that_changes_meanwhile_does_as_in_cpython 6;
    an_ordered_dict_that_changes_meanwhile_does_as_in_cpython 7;
    a_dict_with_defaults_that_changes_meanwhile_does_as_in_cpython 8;
    a_counter_that_changes_meanwhile_does_as_in_cpython 9;
    an_instance_that_changes_meanwhile_does_as_in_cpython 10;
    a_class_that_changes_meanwhile_does_as_in_cpython 11;
    a_function_that_changes_meanwhile_does_as_in_cpython 12;
    an_exception_that_changes_meanwhile_does_as_in_cpython 13;
    a_file_that_changes_meanwhile_does_as_in_cpython 14;
    a_file_of_bytes_that_changes_meanwhile_does_as_in_cpython 15;
}

#[test]
fn every_kind_that_can_be_changed_has_its_trials() {
    let (stage, interpreter) = task();
    let text = "import io, collections\ndef f(): pass\nclass A: pass\n\
        all = [[], {}, {}.items(), set(), bytearray(), A(), A, f, iter([]), (x for x in []), collections.deque(),\n\
        ValueError(), io.StringIO(), io.BytesIO(), collections.OrderedDict()]\n";
    let main = super::begin(&interpreter, text);
    assert_eq!(super::drive(&stage, main), "");
    let all = interpreter
        .global("all")
        .and_then(|all| all.as_items())
        .unwrap();
    let mut tried: Vec<&str> = all.iter().flat_map(trials_of).copied().collect();
    let mut kinds: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
    tried.sort_unstable();
    tried.dedup();
    kinds.sort_unstable();
    assert_eq!(tried, kinds);
}
