//! Random programs that change containers while something walks, compares, hashes, sorts, slices or prints them.
//!
//! A program has one variable of every kind of value, classes whose special methods call back into `act`, `act` that
//! changes the variables, and statements that use them. Each statement is on its own, so that an exception does not
//! hide the rest. Texts are functions of [`Unstructured`].

mod chain;
mod expression;
mod statement;
mod vocabulary;

pub use vocabulary::{IMPORTS, SAMPLES, vocabulary};

use crate::unstructured::Unstructured;

/// What a program is mostly about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Theme {
    /// Containers that are changed by what they call.
    Containers,
    /// Values nested deep, and texts that nest or repeat.
    Chains,
    /// What grows until something stops it.
    Growth,
    /// Values and texts that are deep, on stacks that are small: in generators and far down in calls.
    Stacks,
}

/// Writes one program.
pub(crate) struct Writer<'m, 'b> {
    theme: Theme,
    /// Whether modules written as scripts may be named: to import one takes longer than all else in most programs.
    uses_library: bool,
    /// The variables of this program.
    names: Vec<&'static str>,
    material: &'m mut Unstructured<'b>,
    text: String,
    indent: usize,
}

/// The module of iterators, which is native and costs no time to import.
const NATIVE_MODULE: &str = "itertools";

/// The program these bytes stand for.
pub fn program(theme: Theme, bytes: &[u8]) -> String {
    let mut material = Unstructured::new(bytes);
    let mut writer = Writer {
        theme,
        uses_library: theme != Theme::Stacks || material.one_in(6),
        names: Vec::new(),
        material: &mut material,
        text: String::new(),
        indent: 0,
    };
    writer.whole();
    let (text, uses_library) = (writer.text, writer.uses_library);
    // Importing takes longer than most programs, so only what is used is imported.
    let modules = IMPORTS.trim_start_matches("import ").split(", ");
    let used: Vec<&str> = modules
        .filter(|module| uses_library || *module == NATIVE_MODULE)
        .filter(|module| text.contains(&format!("{module}.")))
        .collect();
    match used.is_empty() {
        true => text,
        false => format!("import {}\n{text}", used.join(", ")),
    }
}

impl Writer<'_, '_> {
    fn line(&mut self, line: &str) {
        for part in line.split('\n') {
            for _ in 0..self.indent {
                self.text.push_str("    ");
            }
            self.text.push_str(part);
            self.text.push('\n');
        }
    }

    fn whole(&mut self) {
        let is_small = self.theme == Theme::Stacks;
        for (name, sample) in SAMPLES {
            // Those of the library cost an import.
            let of_library = sample.contains('.') && *name != "f";
            // Reading a text takes longer than filling a small stack, so these texts have little around what they are
            // about.
            let is_needed = match (is_small, of_library) {
                (true, false) => matches!(*name, "a" | "d" | "g" | "e") || self.material.one_in(4),
                (true, true) => self.uses_library && self.material.one_in(6),
                (false, of_library) => !of_library || self.material.one_in(6),
            };
            if is_needed {
                self.names.push(name);
            }
        }
        self.line("count = 0");
        self.act();
        self.classes();
        self.fresh();
        self.line("x = c = n = None");
        let statements = match self.theme {
            Theme::Containers => 3 + self.material.below(20),
            Theme::Chains | Theme::Growth | Theme::Stacks => 1 + self.material.below(3),
        };
        if self.theme == Theme::Stacks {
            self.line("def inner():");
            self.indent += 1;
            self.line(&format!(
                "global x, x2, c, n, count, {}",
                self.names.join(", ")
            ));
        }
        for _ in 0..statements {
            if self.material.is_used_up() {
                break;
            }
            // Whatever the last statement left: full containers, and `act` acts again.
            self.line("fresh()");
            match (self.theme, self.material.below(4)) {
                (Theme::Chains | Theme::Stacks, 0) => self.text_of_program(),
                (Theme::Chains, 1 | 2) | (Theme::Stacks, _) => self.chain(),
                (Theme::Growth, 0..=2) => self.grow(),
                _ => self.statement(0),
            }
        }
        if self.theme == Theme::Stacks {
            self.line("pass");
            self.indent -= 1;
            self.descend();
        }
        // What is left meets printing, comparing and dropping.
        if self.material.one_in(3) {
            let name = self.variable();
            self.guarded(&format!("str({name}), {name} == copy.copy({name})"));
        }
    }

    /// Calls `inner` far down, on stacks of several sizes.
    fn descend(&mut self) {
        self.line("def deep(n): return deep(n - 1) if n else inner()");
        // With a clause around its `yield` a generator has a stack of its own.
        self.line("def walk(n):\n    try:\n        yield deep(n)\n    finally:\n        n = None");
        self.line("def nested(n):\n    try:\n        yield list(nested(n - 1)) if n else inner()\n    finally:\
            \n        n = None");
        for _ in 0..=self.material.below(2) {
            let depth = match self.material.below(4) {
                0 => self.material.below(130),
                1 => self.material.below(900),
                _ => self.material.below(40),
            };
            let way = self.material.pick(&[
                "list(walk(N))",
                "list(walk(N))",
                "deep(N)",
                "list(nested(N // 8))",
                "sorted([2, 1], key=lambda v: list(walk(N)))",
                "[v for v in walk(N)]",
            ]);
            self.guarded(&way.replace('N', &depth.to_string()));
        }
    }

    /// `fresh`, which fills the variables.
    fn fresh(&mut self) {
        self.line("def fresh():");
        self.indent += 1;
        self.line(&format!("global count, {}", self.names.join(", ")));
        for name in self.names.clone() {
            let value = self.initial(name);
            self.line("count = 0");
            self.guarded(&format!("{name} = {value}"));
        }
        self.line("count = 0");
        self.indent -= 1;
        // For the first one nothing is there yet.
        self.line(&format!("{} = None", self.names.join(" = ")));
    }

    /// The function that special methods call: it changes a few variables, a bounded number of times.
    fn act(&mut self) {
        let globals = self.names.join(", ");
        self.line("def act(*args, **more):");
        self.indent += 1;
        self.line(&format!("global count, x, n, {globals}"));
        self.line("count += 1");
        self.line("if count > 60: return 1");
        if self.material.one_in(2) {
            let all = [
                "for v in (a, d, s, y): v.clear()",
                "a.clear(); d.clear(); s.clear(); y.clear()",
                "a.pop(); y.pop(); d.popitem(); s.pop()",
                "a[:] = a * 9; y[:] = y * 9; d.update(zip(range(90), range(90))); s.update(range(90))",
                "a = []; d = {}; s = set(); y = bytearray()",
                "del a[:2], y[:2]; d[count] = s.add(count)",
                "a.sort(); a.reverse(); y.reverse(); d.update(a=act); s ^= {1}",
            ];
            let line = self.material.pick(&all);
            self.guarded(line);
        }
        let changes = 1 + self.material.below(3);
        for _ in 0..changes {
            if self.material.one_in(2) {
                self.line("if count % 3 == 1:");
                self.indent += 1;
                self.change();
                self.indent -= 1;
            } else {
                self.change();
            }
        }
        self.line("return count % 3");
        self.indent -= 1;
    }

    /// One change of one variable, as a rule a rough one.
    fn change(&mut self) {
        let container = self
            .material
            .pick(&["a", "d", "s", "y", "q", "k", "o", "w", "a", "d", "y"]);
        let change = match self.material.below(16) {
            0..=3 => format!("{container}.clear()"),
            4 => format!("{container}.pop()"),
            5 => format!("{container} = copy.copy({container})"),
            6 => match container {
                "a" | "q" => format!("{container}.extend(range(50))"),
                "y" => "y.extend(bytes(500))".to_owned(),
                "s" => "s.update(range(50))".to_owned(),
                _ => format!("{container}.update(zip(range(50), range(50)))"),
            },
            7 => match container {
                "a" | "y" => format!("del {container}[1:]"),
                "q" => "q.rotate(1)".to_owned(),
                "s" => "s.discard(1)".to_owned(),
                _ => format!("{container}.popitem()"),
            },
            8 => match container {
                "a" | "y" => format!("{container}[:] = {container}[::-1]"),
                "q" => "q.appendleft(a)".to_owned(),
                "s" => "s.add(K())".to_owned(),
                _ => format!("{container}[K()] = {container}"),
            },
            9 => format!("n = {container}; {container} = type({container})()"),
            10 => "next(g)".to_owned(),
            11 => "g.close()".to_owned(),
            12 => "setattr(K, '__hash__', None)".to_owned(),
            _ => {
                let arguments = self.arguments(2);
                let names = &vocabulary().methods[container];
                let name = &names[self.material.below(names.len())];
                format!("{container}.{name}({arguments})")
            }
        };
        self.guarded(&change);
    }

    /// One of several, of the library only where that may be named.
    fn pick_allowed(&mut self, all: &[&'static str]) -> &'static str {
        let modules = || IMPORTS.trim_start_matches("import ").split(", ");
        let names_module = |text: &str| {
            modules().any(|module| module != NATIVE_MODULE && text.contains(&format!("{module}.")))
        };
        // A text without a module is found soon: most have none.
        for _ in 0..20 {
            let one = self.material.pick(all);
            if self.uses_library || !names_module(one) {
                return one;
            }
        }
        all[0]
    }

    /// `try: LINE` with whatever handler.
    fn guarded(&mut self, line: &str) {
        self.line("try:");
        self.indent += 1;
        self.line(line);
        self.indent -= 1;
        match self.material.below(8) {
            7 => self.line("except BaseException as error: n = error"),
            6 => self.line("except Exception as error: e = error"),
            _ => self.line("except Exception: pass"),
        }
    }

    /// `K` and `J`: classes most of whose special methods act.
    fn classes(&mut self) {
        let bases = [
            "",
            "(list)",
            "(dict)",
            "(int)",
            "(str)",
            "(set)",
            "(Exception)",
            "(tuple)",
            "(bytes)",
            "(float)",
        ];
        for class in ["K", "J"] {
            let base = if class == "K" {
                ""
            } else {
                self.material.pick(&bases)
            };
            self.line(&format!("class {class}{base}:"));
            self.indent += 1;
            self.line("n = 0");
            if class == "K" || self.material.one_in(3) {
                self.line("def __init__(self, n=0, *more, **named): self.n = n");
            }
            let most = if self.theme == Theme::Stacks {
                1 + self.material.below(4)
            } else {
                6 + self.material.below(10)
            };
            let mut heads: Vec<usize> = (0..most)
                .map(|_| self.material.below(SPECIAL.len()))
                .collect();
            heads.sort_unstable();
            heads.dedup();
            for (head, results) in heads.into_iter().map(|number| SPECIAL[number]) {
                let result = self.material.pick(results);
                match self.material.below(8) {
                    0 => self.line(&format!("def {head}: return {result}")),
                    1 => self.line(&format!("def {head}: raise StopIteration")),
                    _ => {
                        self.line(&format!("def {head}:"));
                        self.indent += 1;
                        self.line("act()");
                        self.line(&format!("return {result}"));
                        self.indent -= 1;
                    }
                }
            }
            self.indent -= 1;
        }
        self.line("def gen(*args):");
        self.indent += 1;
        self.line("try:");
        self.indent += 1;
        let step = self.expression(2);
        self.line(&format!("x = yield {step}"));
        let rest = self.expression(2);
        self.line(&format!("yield from {rest}"));
        self.line("yield act()");
        self.indent -= 1;
        self.line("finally: act()");
        self.indent -= 1;
    }

    /// What a variable begins with.
    fn initial(&mut self, name: &str) -> String {
        let inner = |writer: &mut Self| {
            let items: Vec<String> = (0..writer.material.below(5))
                .map(|_| writer.expression(2))
                .collect();
            items.join(", ")
        };
        match name {
            "a" => format!("[{}, 1, 2, 3]", self.expression(2)),
            "d" => format!("{{1: {}, K(): 2, 'a': 3}}", self.expression(2)),
            "s" => format!("{{1, 2, {}}}", self.expression(1)),
            "y" => "bytearray(b'0123456789')".to_owned(),
            "q" => format!(
                "collections.deque([{}], {})",
                inner(self),
                self.material.pick(&["None", "4", "100"])
            ),
            "t" => self
                .material
                .pick(&[
                    "'abc'",
                    "'a\\u4e00b' * 9",
                    "'%s{}{0!r:>9}'",
                    "' x,y\\n' * 99",
                ])
                .to_owned(),
            "z" => "frozenset([1, K()])".to_owned(),
            "v" => "bytes(range(40))".to_owned(),
            "u" => format!("(1, {})", inner(self)),
            "i" => self
                .material
                .pick(&["3", "-1", "2 ** 70", "1 << 4000", "True"])
                .to_owned(),
            "g" => self
                .material
                .pick(&[
                    "gen()",
                    "(act() for _ in a)",
                    "iter(act, 7)",
                    "map(K, a)",
                    "gen(gen())",
                ])
                .to_owned(),
            "e" => self
                .material
                .pick(&[
                    "ValueError(a)",
                    "ExceptionGroup('e', [ValueError(), KeyError(d)])",
                    "StopIteration(K())",
                ])
                .to_owned(),
            "k" => self
                .material
                .pick(&[
                    "collections.defaultdict(list)",
                    "collections.defaultdict(act)",
                    "collections.ChainMap(d)",
                ])
                .to_owned(),
            "o" => "collections.OrderedDict(d)".to_owned(),
            "w" => "collections.Counter(a)".to_owned(),
            "r" => "range(0, 10 ** 9, 7)".to_owned(),
            "f" => self
                .material
                .pick(&["0.5", "1e308", "float('nan')", "-0.0", "2j"])
                .to_owned(),
            "p" => format!("functools.partial({}, {})", self.function(), inner(self)),
            "b" => self
                .material
                .pick(&["io.StringIO('a\\nb')", "io.BytesIO(b'abc')"])
                .to_owned(),
            "h" => self
                .material
                .pick(&[
                    "queue.Queue(3)",
                    "queue.PriorityQueue()",
                    "queue.SimpleQueue()",
                ])
                .to_owned(),
            "l" => self
                .material
                .pick(&[
                    "threading.RLock()",
                    "threading.Lock()",
                    "threading.Condition()",
                    "threading.Event()",
                ])
                .to_owned(),
            _ => self
                .material
                .pick(&[
                    "re.compile('(a)(?P<n>b)?|.')",
                    "re.compile(b'.')",
                    "re.match('a(b)', 'ab')",
                ])
                .to_owned(),
        }
    }
}

/// Special methods with their parameters, and what they may return.
const SPECIAL: &[(&str, &[&str])] = &[
    (
        "__index__(self)",
        &["1", "0", "-1", "3", "2 ** 70", "len(a)"],
    ),
    ("__hash__(self)", &["1", "0", "hash(count)", "-1"]),
    (
        "__eq__(self, other)",
        &[
            "True",
            "False",
            "NotImplemented",
            "count % 2",
            "self",
            "self == other",
        ],
    ),
    (
        "__lt__(self, other)",
        &["True", "False", "count % 2", "NotImplemented"],
    ),
    ("__gt__(self, other)", &["True", "False", "count % 2"]),
    ("__le__(self, other)", &["True", "a"]),
    ("__len__(self)", &["1", "0", "3", "10 ** 9", "len(self)"]),
    ("__bool__(self)", &["True", "False"]),
    (
        "__iter__(self)",
        &[
            "iter(a)",
            "self",
            "gen()",
            "iter(d)",
            "iter([self])",
            "iter(self)",
        ],
    ),
    ("__next__(self)", &["1", "self", "count", "next(self)"]),
    (
        "__getitem__(self, key)",
        &["1", "self", "a[key]", "self[key]"],
    ),
    (
        "__setitem__(self, key, value)",
        &["None", "setattr(self, 'n', value)"],
    ),
    ("__delitem__(self, key)", &["None"]),
    (
        "__contains__(self, item)",
        &["True", "item in a", "item in self"],
    ),
    (
        "__repr__(self)",
        &["'K'", "repr(a)", "repr(self)", "'%r' % (d,)", "'x' * 1000"],
    ),
    ("__str__(self)", &["'K'", "str(s)", "str(self)", "t"]),
    (
        "__format__(self, spec)",
        &["'K'", "format(self, spec)", "spec * 9"],
    ),
    (
        "__call__(self, *args, **named)",
        &["self", "1", "self(*args)", "args", "K(*args)"],
    ),
    (
        "__getattr__(self, name)",
        &["1", "act", "getattr(self, name)", "name"],
    ),
    ("__add__(self, other)", &["self", "1", "other + self", "a"]),
    ("__radd__(self, other)", &["self", "1", "other"]),
    ("__iadd__(self, other)", &["self", "a", "other"]),
    ("__mul__(self, other)", &["a", "2"]),
    ("__or__(self, other)", &["d", "s", "other | self"]),
    ("__neg__(self)", &["self", "-self"]),
    ("__int__(self)", &["1", "2 ** 70"]),
    ("__float__(self)", &["1.0", "float(self)"]),
    ("__round__(self, n=None)", &["1"]),
    ("__bytes__(self)", &["b'1'", "bytes(y)"]),
    ("__reversed__(self)", &["iter(a)", "reversed(a)"]),
    ("__length_hint__(self)", &["3", "10 ** 9"]),
    ("__enter__(self)", &["self"]),
    ("__exit__(self, *error)", &["True", "False"]),
    ("__copy__(self)", &["self", "K()", "copy.copy(self)"]),
    (
        "__deepcopy__(self, memo)",
        &["self", "K()", "copy.deepcopy(a, memo)", "memo"],
    ),
    ("__missing__(self, key)", &["1", "self[key]"]),
    (
        "__get__(self, instance, owner)",
        &["1", "instance", "owner"],
    ),
    ("__set__(self, instance, value)", &["None"]),
    (
        "__instancecheck__(self, other)",
        &["True", "isinstance(other, self)"],
    ),
    ("__dir__(self)", &["['a']", "a"]),
    ("keys(self)", &["[1, 2]", "a", "d.keys()"]),
    ("write(self, text)", &["1"]),
    ("read(self, *size)", &["'x'", "b'x'"]),
];
