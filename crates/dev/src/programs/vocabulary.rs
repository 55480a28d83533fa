//! What programs can name: asked of the language itself, so that a new builtin, module or method is in the next
//! campaign.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use crate::language::output_of;

/// Names for the generator.
pub struct Vocabulary {
    /// Builtin functions and types.
    pub builtins: Vec<String>,
    /// `module.name` for everything public in the modules that need no permission.
    pub functions: Vec<String>,
    /// Methods by the letter of the variable that is of the type (see `programs`).
    pub methods: BTreeMap<&'static str, Vec<String>>,
}

/// What stays out: it would end or block the generator's own machinery, not the language's.
const LEFT_OUT: &[&str] = &["input", "breakpoint", "exit", "quit", "open", "help"];

/// Modules every program imports.
pub const IMPORTS: &str = "import abc, bisect, collections, contextlib, copy, dataclasses, datetime, enum, functools, \
heapq, io, itertools, json, \
math, operator, queue, random, re, statistics, string, struct, sys, threading, time, typing";

/// Variables of every program, and a value that has the methods each will have.
pub const SAMPLES: &[(&str, &str)] = &[
    ("a", "[]"),
    ("d", "{}"),
    ("s", "set()"),
    ("y", "bytearray()"),
    ("q", "collections.deque()"),
    ("t", "''"),
    ("z", "frozenset()"),
    ("v", "b''"),
    ("u", "()"),
    ("i", "0"),
    ("g", "(x for x in ())"),
    ("e", "ValueError()"),
    ("k", "collections.defaultdict(list)"),
    ("o", "collections.OrderedDict()"),
    ("w", "collections.Counter()"),
    ("r", "range(3)"),
    ("f", "0.5"),
    ("p", "functools.partial(len)"),
    ("b", "io.StringIO()"),
    ("h", "queue.Queue()"),
    ("l", "threading.RLock()"),
    ("m", "re.compile('a')"),
];

/// The names, asked for once.
pub fn vocabulary() -> &'static Vocabulary {
    static NAMES: OnceLock<Vocabulary> = OnceLock::new();
    NAMES.get_or_init(|| {
        let words = |text: String| -> Vec<String> {
            let names = text.split_whitespace().map(str::to_owned);
            names.filter(|name| !LEFT_OUT.contains(&name.as_str())).collect()
        };
        let builtins = elite_syntax::python_names::builtin_names().map(str::to_owned);
        let modules = IMPORTS.trim_start_matches("import ");
        let functions = output_of(&format!(
            "{IMPORTS}\nfor name, module in zip('{modules}'.split(', '), [{modules}]):\
             \n    for member in dir(module):\n        if not member.startswith('_'): print(name + '.' + member)\n"
        ));
        let methods = SAMPLES.iter().map(|(name, sample)| {
            let text = format!("{IMPORTS}\nprint(*dir({sample}))\n");
            (*name, words(output_of(&text)))
        });
        Vocabulary {
            builtins: builtins.filter(|name| !LEFT_OUT.contains(&name.as_str())).collect(),
            functions: words(functions),
            methods: methods.collect(),
        }
    })
}
