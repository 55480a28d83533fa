"""What random programs are made of: values of all kinds, names, operators, methods, and who asks objects for what."""

NUMBERS = [
    "0", "1", "-1", "2", "3", "7", "-5", "10", "255", "2**31", "2**63", "-2**63", "10**25", "-10**30 + 1", "True",
    "1.5", "-2.5", "0.1", "1e22", "float('inf')", "1j", "(2-3j)", "0.0", "-0.0", "3**200",
]
SMALL = ["0", "1", "2", "3", "-1", "-2", "5", "None", "True"]
TEXTS = [
    "''", "'a'", "'abc'", "'a,b'", "'  x '", "'12'", "'éß'", "'日本語'", "'Ωμέγα'", "'привет мир'", "'שלום'",
    "'مرحبا'", "'हिन्दी'", "'ไทย'", "'한국어'", "'e\\u0301'", "'😀👍🏽'", "'İı'", "'ǅ'", "'\\udc80'",
    "'\\ud83dx'", "'\\u10d0\\u10d1'", "'\u03a3\u0391\u03a3'", "'\u1fb3 \u1f88'", "'\u0663\u0967'",
    "'a\\u200db'", "'\\x00\\x1f'", "'ß' * 3", "'%s {} '", "'tab\\tnew\\nline'",
]
# None is alone where it may get into a set: its place in one is that of its address in CPython.
LISTS = [
    "[]", "[1]", "[3, 1, 2]", "['b', 'a']", "[1, 'a', ()]", "[None]", "[[1], [2, 3]]", "list(range(8))",
    "[0.5, 2, True]",
]
TUPLES = ["()", "(1,)", "(1, 2)", "('a', 2)", "((1, 2), (3, 4))"]
DICTS = ["{}", "{'a': 1}", "{1: 'x', 'b': [2]}", "{'a': 1, 'b': 2, 'c': 3}", "dict(zip('xyz', range(3)))"]
SETS = ["set()", "{1}", "{1, 2, 3}", "{'a'}", "frozenset([1, 2])"]
BYTES = ["b''", "b'abc'", "b'\\xff\\x80'", "bytearray(b'xyz')"]
POOLS = [NUMBERS, TEXTS, LISTS, TUPLES, DICTS, SETS, BYTES, ["None"]]
NAMES = ["a", "b", "c"]
ERRORS = [
    "ValueError", "TypeError", "KeyError", "IndexError", "ZeroDivisionError", "AttributeError", "Exception",
    "LookupError", "ArithmeticError", "StopIteration", "RuntimeError", "(KeyError, TypeError)", "OverflowError",
    "NameError",
]
BINARY = ["+", "-", "*", "/", "//", "%", "&", "|", "^", "<", "<=", "==", "!=", "is", "in", "and", "or", "<<", "**"]
SPECS = [
    "", ">8", "<6", "^7", "05", "+", ",", "_", "x", "b", ".3", ".2f", "e", "g", "%", "s", "#x", "*^9", "10.3e", "n",
    "c", "z.1f", "=+6", "_b",
]
PERCENTS = [
    "%s", "%r", "%a", "%d", "%5d", "%x", "%.2f", "%g", "%-6s|", "%05d", "%c", "%(a)s", "%s %s", "%%", "%i", "%e", "%+d",
    "%.3s", "%o",
]
CODECS = [
    "utf-8", "ascii", "latin-1", "utf-16", "utf-16-le", "utf-32-be", "cp1252", "gbk", "gb18030", "gb2312",
    "iso-8859-15", "utf-8-sig", "unicode_escape", "raw_unicode_escape", "koi8-r", "cp437",
]
HANDLERS = [
    "strict", "ignore", "replace", "backslashreplace", "surrogateescape", "surrogatepass", "xmlcharrefreplace",
    "namereplace",
]
DUNDERS = [
    "def __len__(self): return {small}", "def __bool__(self): return {value}",
    "def __eq__(self, other): return {value}", "def __lt__(self, other): return {value}",
    "def __hash__(self): return {small}", "def __iter__(self): return iter({value})",
    "def __getitem__(self, key): return {value} if key != 3 else [][1]", "def __contains__(self, item): return {value}",
    "def __call__(self, *args, **kw): return args, kw", "def __add__(self, other): return {value}",
    "def __radd__(self, other): return {value}", "def __getattr__(self, name): return name * 2",
    "def __str__(self): return {text}", "def __repr__(self): return {text}", "def __index__(self): return {small}",
    "def __int__(self): return {small}", "def __float__(self): return {value}",
    "def __format__(self, spec): return 'f' + spec",
    "def __enter__(self): return {value}\n        def __exit__(self, *e): return {value}",
    "def __neg__(self): return {value}", "def __mul__(self, other): return NotImplemented",
    "def __rmul__(self, other): return {value}", "def __setitem__(self, key, v): self.kept = key, v",
    "def __delitem__(self, key): del self.kept", "def __reversed__(self): return iter({value})",
    "def __round__(self, n=None): return n", "def __missing__(self, key): return key",
    "def __abs__(self): return {value}", "def __iadd__(self, other): self.n = other; return self",
    "def __eq__(self, other): return NotImplemented", "__hash__ = None", "p = property(lambda self: {value})",
    "@property\n        def q(self): return self.nope", "@classmethod\n        def k(cls, x=1): return cls.__name__, x",
    "@staticmethod\n        def s(*x): return x", "x = {value}", "y: int = {value}", "__slots__ = ('x1', 'y1')",
]

#: Special methods and what they may give, and who asks objects that have them.
KEPT = {
    "__str__": ["'t'", "S('s')"], "__repr__": ["'r'", "S('ré')"], "__format__": ["'f'", "S('f')"],
    "__bytes__": ["b'b'", "Y(b'y')"], "__int__": ["5", "I(6)", "True"], "__index__": ["2", "I(1)", "True", "-1"],
    "__float__": ["1.5", "F(2.5)"], "__complex__": ["1j", "C(2)"], "__bool__": ["True", "False"],
    "__len__": ["2", "-1", "I(3)", "2**70"], "__hash__": ["7", "I(8)", "2**70"],
    "__iter__": ["iter([1, 2])", "iter('ab')", "self"], "__next__": ["1"], "__contains__": ["1", "[]"],
    "__length_hint__": ["3", "-2", "'x'"], "__getitem__": ["'i'", "[][k]"], "__reversed__": ["[2, 1]"],
    "__round__": ["4"], "__trunc__": ["3", "I(4)", "'x'"], "__floor__": ["2"], "__ceil__": ["9"], "__abs__": ["1"],
    "__dir__": ["['b', 'a']", "'zy'"], "__call__": ["x"], "__eq__": ["'eq'", "[]"], "__lt__": ["'lt'", "0"],
    "__divmod__": ["(1, 2)"], "__pow__": ["'pow'"], "__neg__": ["-1"], "__missing__": ["'missing'"],
    "__getattr__": ["5", "[][5]"], "__delattr__": ["0"], "__enter__": ["1"], "__exit__": ["[]", "1"],
    "__instancecheck__": ["1"], "__fspath__": ["'p'"], "__set_name__": ["0"], "__get__": ["'got'"],
    "__matmul__": ["'@'"], "__iadd__": ["'+='"], "__radd__": ["'r+'"], "__rmod__": ["'r%'"], "__mul__": ["'*'"],
    "__rmul__": ["'r*'"],
}
# Not here (docs/LANGUAGE.md): special names in `dir()`, which in CPython are those of slots of C.
ASKS = [
    "str(o)", "repr(o)", "f'{o}'", "f'{o!r}'", "f'{o!s:>4}'", "format(o, '>5')", "'%s' % (o,) + ''", "'%r|%s' % (o, o)",
    "'%d' % o", "'%x' % o", "'%.2f' % o", "'%c' % o", "'%*d' % (o, 3)", "'{}|{!r}'.format(o, o)", "'{:d}'.format(o)",
    "'{0[1]}'.format(o)", "'{0.n}'.format(o)", "ascii(o)", "bytes(o)", "bytearray(o)", "b'%s' % o", "b'%d' % o",
    "b'%c' % o", "int(o)", "float(o)", "complex(o)", "bool(o)", "not o", "1 if o else 2", "len(o)",
    "hash(o) == hash(o)", "{o: 1}[o]", "o in {1, 2}", "list(o)", "tuple(o)", "set(o)", "dict(o)", "sorted(o)", "[*o]",
    "{*o}", "{**o}", "(lambda *x: x)(*o)", "a1, *b1 = o; x = a1, b1", "x, y = o; x = x, y", "iter(o)", "next(o)",
    "list(reversed(o))", "list(zip(o, o))[:3]", "list(map(str, o))", "list(enumerate(o))", "sum(o)", "max(o)",
    "min(o, 1)", "any(o)", "all(o)", "1 in o", "o[0]", "o['k']", "o[:2]", "[1, 2, 3][o]", "[1, 2, 3][o:]", "'abc'[o]",
    "(1, 2)[o]", "range(o)", "range(5)[o]", "'a' * o", "[1] * o", "o * 2", "o + 1", "1 + o", "o += 1; x = o", "o == 1",
    "o != 1", "o < 1", "o <= 1", "1 > o", "o @ 1", "divmod(o, 2)", "pow(o, 2)", "pow(2, o)", "-o", "abs(o)", "round(o)",
    "round(1.5, o)", "math.floor(o)", "math.ceil(o)", "math.trunc(o)", "math.sqrt(o)", "math.gcd(o, 4)",
    "math.factorial(o)", "math.isqrt(o)", "math.hypot(o, 1)", "math.comb(5, o)", "math.ldexp(1.0, o)", "chr(o)",
    "hex(o)", "bin(o)", "[x for x in dir(o) if x[0] != '_']", "o()", "o(1)", "o.n", "getattr(o, 'q', 5)",
    "hasattr(o, 'q')", "isinstance(1, o)", "operator.index(o)", "operator.length_hint(o)",
    "operator.methodcaller(o)(1)", "operator.itemgetter(o)([1, 2, 3])", "operator.attrgetter('n')(o)",
    "type(o).__reduce_ex__(o, 2)[1][1:]", "','.join(o)", "b''.join(o)", "'abc'.replace('a', o)", "'a,b'.split(',', o)",
    "'abc'.find('c', o)", "'ab'.center(o)", "'ab'.startswith(o)", "'%s' % o", "[].extend(o)", "[0].__iadd__(o)",
    "[3].insert(o, 1)", "[1, 2].pop(o)", "[1].index(1, o)", "{}.update(o)", "{1}.union(o)", "{1} | o",
    "dict.fromkeys(o)", "struct.pack('i', o)", "struct.pack('d', o)", "struct.pack('?', o)", "collections.Counter(o)",
    "collections.deque(o, 2)", "functools.reduce(max, o)", "list(itertools.islice(o, 2))",
    "list(itertools.chain(o, o))[:4]", "list(itertools.islice('abc', o))", "list(itertools.repeat(1, o))",
    "list(itertools.permutations(o, 1))[:2]", "json.dumps(o)", "json.dumps([o])", "copy.copy(o) == o", "int('7', o)",
    "int.from_bytes(o, 'big')", "(5).to_bytes(o, 'big')", "slice(o).indices(4)", "sorted([2, 1], key=o)",
    "sorted([1, 2], reverse=o)", "statistics.mean(o)", "timedelta(o)", "date(2024, 1, o)", "round(timedelta(1) / 3, o)",
    "timedelta(1) * o", "print(o, end='') or 1", "type(str(o)).__name__, type(f'{o}').__name__",
    "type(int(o)).__name__, type(float(o)).__name__", "type(repr(o)).__name__", "string.Template('$a').substitute(a=o)",
    "re.sub('a', o, 'ab')", "string.Formatter().format('{0} {0!r:>5}', o)",
    "string.Formatter().vformat('{a[0]}', (), {'a': o})", "object.__repr__(o)[:5]", "object.__str__(o)[:5]",
    "bool.__and__(True, o)", "OSError.__str__(o)", "pow(2, o, 5)", "float.fromhex(o)", "o.__len__()", "o.__str__()",
    "o.__iter__()", "super(K, o).__repr__()[:2]", "zip(o)",
]
