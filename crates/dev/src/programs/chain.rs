//! Chains: a value within a value within a value, of every kind that can hold one, and what is asked of them.

use super::Writer;

/// How `x` gets one deeper.
const LINKS: &[&str] = &[
    "[x]",
    "(x,)",
    "{0: x}",
    "{(x,)}",
    "frozenset([x])",
    "lambda v=x: v",
    "(lambda v: lambda: v)(x)",
    "(lambda *, v=x: v)",
    "iter([x])",
    "map(act, x)",
    "map(x, a)",
    "filter(None, x)",
    "filter(x, a)",
    "zip(x)",
    "enumerate(x)",
    "reversed([x])",
    "itertools.chain(x)",
    "itertools.chain.from_iterable(x)",
    "itertools.cycle(x)",
    "itertools.repeat(x)",
    "itertools.islice(x, 3)",
    "itertools.tee(x)[0]",
    "itertools.starmap(x, a)",
    "itertools.accumulate(x)",
    "itertools.groupby(x)",
    "itertools.takewhile(x, a)",
    "itertools.zip_longest(x)",
    "itertools.pairwise(x)",
    "(v for v in x)",
    "(v for v in [x])",
    "gen(x)",
    "slice(x)",
    "K(x)",
    "J(x)",
    "K(x).__init__",
    "[x].append",
    "ValueError(x)",
    "ExceptionGroup('e', [x])",
    "functools.partial(x)",
    "functools.partial(act, x)",
    "functools.lru_cache(x)",
    "functools.cmp_to_key(x)",
    "functools.partialmethod(x)",
    "functools.singledispatch(x)",
    "property(x)",
    "staticmethod(x)",
    "classmethod(x)",
    "type('C', (), {'x': x})",
    "type('C', (x,), {})",
    "type('C', (), {'__call__': x})()",
    "type('C', (), {'__iter__': x})()",
    "type('C', (), {'__getattr__': x})()",
    "type('C', (), {'__eq__': x})()",
    "type('C', (), {'__class__': x})()",
    "collections.deque([x])",
    "collections.defaultdict(x)",
    "collections.OrderedDict(a=x)",
    "collections.ChainMap(x)",
    "collections.UserList([x])",
    "collections.UserDict(a=x)",
    "collections.Counter([x])",
    "{0: x}.values()",
    "{0: x}.items()",
    "iter({0: x}.values())",
    "iter(x, 0)",
    "iter(act, x)",
    "memoryview(x)",
    "range(x)",
    "super(K, x)",
    "x | int",
    "list[x]",
    "copy.copy(x)",
    "[x, x]",
    "(x, x)",
    "{1: x, 2: x}",
    "threading.Thread(target=x)",
    "contextlib.closing(x)",
    "io.TextIOWrapper(x)",
    "x.__class__",
    "x.__eq__",
    "operator.itemgetter(x)",
    "operator.methodcaller('a', x)",
    "re.compile('a').sub",
    "random.Random(x)",
    "typing.Optional[x]",
    "enum.Enum('E', {'a': x})",
    "dataclasses.make_dataclass('D', ['a'])(x)",
    "collections.namedtuple('N', 'a')(x)",
    "abc.ABCMeta('A', (), {'x': x})",
    "exception(x)",
    "started(x)",
    "cell(x)",
    "wrapped(x)",
];

/// What is asked of the chain.
const QUESTIONS: &[&str] = &[
    "x = None",
    "repr(x)",
    "str(x)",
    "f'{x!s:>9}'",
    "'%s' % (x,)",
    "x == x2",
    "x < x2",
    "hash(x)",
    "copy.copy(x)",
    "copy.deepcopy(x)",
    "json.dumps(x)",
    "x()",
    "next(x)",
    "list(x)",
    "sum(x)",
    "len(x)",
    "bool(x)",
    "isinstance(1, x)",
    "issubclass(int, x)",
    "x.a",
    "x.a = 1",
    "dir(x)",
    "vars(x)",
    "x + x",
    "x[0]",
    "x in x2",
    "sorted([x, x2])",
    "raise x",
    "try: 1 / 0\nexcept x: pass",
    "print(x, file=b)",
    "type(x)(x)",
    "int(x)",
    "getattr(x, 'a', 1)",
    "x.close()",
    "x.send(None)",
    "x.__next__()",
    "iter(x)",
    "a[x:x]",
    "a.sort(key=x)",
    "max(x, x2)",
    "act(*x)",
    "act(**x)",
    "with x: pass",
    "del x",
    "a.append(x); a.clear(); x = None",
    "d[1] = x; x = None; d[1] = 0",
    "x, = x",
    "dataclasses.asdict(x)",
    "statistics.mean(x)",
    "heapq.heapify([x, x2])",
    "functools.reduce(x, a)",
    "e.__cause__ = x; raise e",
    "str.join('', x)",
    "type('C', (x,), {})",
    "pow(x, x2)",
];

impl Writer<'_, '_> {
    /// Builds one and asks it something.
    pub(super) fn chain(&mut self) {
        let links: Vec<&str> = (0..=self.material.below(2))
            .map(|_| self.pick_allowed(LINKS))
            .collect();
        let start = self.material.pick(&[
            "[]",
            "()",
            "1",
            "act",
            "K()",
            "int",
            "iter(a)",
            "ValueError()",
            "'a'",
            "gen()",
            "d",
        ]);
        // What overflows a small stack takes some hundred values, what overflows a large one some ten thousand.
        let length = match (self.uses_library, self.material.below(16)) {
            (false, 0..=13) => self.material.pick(&["20", "60", "150", "400", "900"]),
            _ => self.material.pick(&["150", "900", "3000", "30000", "20"]),
        };
        if links.iter().any(|link| link.starts_with("exception")) {
            self.line("def exception(inner):\n    try: raise ValueError(inner)\n    except ValueError as error:\
                \n        try: raise KeyError(1) from error\n        except KeyError as outer: return outer");
        }
        if links.iter().any(|link| link.starts_with("started")) {
            self.line(
                "def started(inner):\n    def body():\n        yield 1\n        yield inner\
                \n    value = body(); next(value)\n    return value",
            );
        }
        if links.iter().any(|link| link.starts_with("cell")) {
            self.line("def cell(inner):\n    def one(): return inner\n    return one");
        }
        if links.iter().any(|link| link.starts_with("wrapped")) {
            self.line("def wrapped(inner):\n    @functools.wraps(act)\n    def one(*args): return inner(*args)\
                \n    return one");
        }
        self.line("try:");
        self.indent += 1;
        self.line(&format!("x = x2 = {start}"));
        self.line(&format!("for n in range({length}):"));
        for link in &links {
            self.line(&format!("    x = {link}"));
        }
        if self.uses_library && self.material.one_in(2) {
            self.line("x2 = copy.copy(x)");
        }
        self.indent -= 1;
        self.line("except Exception: pass");
        for _ in 0..=self.material.below(3) {
            let question = self.pick_allowed(QUESTIONS);
            self.guarded(question);
        }
    }
}
