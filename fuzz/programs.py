"""Random programs of several statements for `differential.py`: attributes, containers, generators, exceptions, formatting,
classes, slicing, texts in many scripts, big numbers.

A program is the body of a function without parameters; what it returns is shown. Loops are bounded, so every program ends.
"""

NUMBERS = ["0", "1", "-1", "2", "3", "7", "-5", "10", "255", "2**31", "2**63", "-2**63", "10**25", "-10**30 + 1", "True", "1.5", "-2.5", "0.1",
           "1e22", "float('inf')", "1j", "(2-3j)", "0.0", "-0.0", "3**200"]
SMALL = ["0", "1", "2", "3", "-1", "-2", "5", "None", "True"]
TEXTS = ["''", "'a'", "'abc'", "'a,b'", "'  x '", "'12'", "'éß'", "'日本語'", "'Ωμέγα'", "'привет мир'", "'שלום'", "'مرحبا'", "'हिन्दी'",
         "'ไทย'", "'한국어'", "'e\\u0301'", "'😀👍🏽'", "'İı'", "'ǅ'", "'\\udc80'", "'\\ud83dx'", "'\\u10d0\\u10d1'", "'\u03a3\u0391\u03a3'", "'\u1fb3 \u1f88'", "'\u0663\u0967'", "'a\\u200db'", "'\\x00\\x1f'", "'ß' * 3", "'%s {} '", "'tab\\tnew\\nline'"]
# None is alone where it may get into a set: its place in one is that of its address in CPython.
LISTS = ["[]", "[1]", "[3, 1, 2]", "['b', 'a']", "[1, 'a', ()]", "[None]", "[[1], [2, 3]]", "list(range(8))", "[0.5, 2, True]"]
TUPLES = ["()", "(1,)", "(1, 2)", "('a', 2)", "((1, 2), (3, 4))"]
DICTS = ["{}", "{'a': 1}", "{1: 'x', 'b': [2]}", "{'a': 1, 'b': 2, 'c': 3}", "dict(zip('xyz', range(3)))"]
SETS = ["set()", "{1}", "{1, 2, 3}", "{'a'}", "frozenset([1, 2])"]
BYTES = ["b''", "b'abc'", "b'\\xff\\x80'", "bytearray(b'xyz')"]
POOLS = [NUMBERS, TEXTS, LISTS, TUPLES, DICTS, SETS, BYTES, ["None"]]
NAMES = ["a", "b", "c"]
ERRORS = ["ValueError", "TypeError", "KeyError", "IndexError", "ZeroDivisionError", "AttributeError", "Exception", "LookupError", "ArithmeticError",
          "StopIteration", "RuntimeError", "(KeyError, TypeError)", "OverflowError", "NameError"]
BINARY = ["+", "-", "*", "/", "//", "%", "&", "|", "^", "<", "<=", "==", "!=", "is", "in", "and", "or", "<<", "**"]
SPECS = ["", ">8", "<6", "^7", "05", "+", ",", "_", "x", "b", ".3", ".2f", "e", "g", "%", "s", "#x", "*^9", "10.3e", "n", "c", "z.1f", "=+6", "_b"]
PERCENTS = ["%s", "%r", "%a", "%d", "%5d", "%x", "%.2f", "%g", "%-6s|", "%05d", "%c", "%(a)s", "%s %s", "%%", "%i", "%e", "%+d", "%.3s", "%o"]
CODECS = ["utf-8", "ascii", "latin-1", "utf-16", "utf-16-le", "utf-32-be", "cp1252", "gbk", "gb18030", "gb2312", "iso-8859-15", "utf-8-sig",
          "unicode_escape", "raw_unicode_escape", "koi8-r", "cp437"]
HANDLERS = ["strict", "ignore", "replace", "backslashreplace", "surrogateescape", "surrogatepass", "xmlcharrefreplace", "namereplace"]
DUNDERS = [
    "def __len__(self): return {small}", "def __bool__(self): return {value}", "def __eq__(self, other): return {value}",
    "def __lt__(self, other): return {value}", "def __hash__(self): return {small}", "def __iter__(self): return iter({value})",
    "def __getitem__(self, key): return {value} if key != 3 else [][1]", "def __contains__(self, item): return {value}",
    "def __call__(self, *args, **kw): return args, kw", "def __add__(self, other): return {value}", "def __radd__(self, other): return {value}",
    "def __getattr__(self, name): return name * 2", "def __str__(self): return {text}", "def __repr__(self): return {text}",
    "def __index__(self): return {small}", "def __int__(self): return {small}", "def __float__(self): return {value}",
    "def __format__(self, spec): return 'f' + spec", "def __enter__(self): return {value}\n        def __exit__(self, *e): return {value}",
    "def __neg__(self): return {value}", "def __mul__(self, other): return NotImplemented", "def __rmul__(self, other): return {value}",
    "def __setitem__(self, key, v): self.kept = key, v", "def __delitem__(self, key): del self.kept", "def __reversed__(self): return iter({value})",
    "def __round__(self, n=None): return n", "def __missing__(self, key): return key", "def __abs__(self): return {value}",
    "def __iadd__(self, other): self.n = other; return self", "def __eq__(self, other): return NotImplemented", "__hash__ = None",
    "p = property(lambda self: {value})", "@property\n        def q(self): return self.nope", "@classmethod\n        def k(cls, x=1): return cls.__name__, x",
    "@staticmethod\n        def s(*x): return x", "x = {value}", "y: int = {value}", "__slots__ = ('x1', 'y1')",
]

#: Special methods and what they may give, and who asks objects that have them.
KEPT = {"__str__": ["'t'", "S('s')"], "__repr__": ["'r'", "S('ré')"], "__format__": ["'f'", "S('f')"], "__bytes__": ["b'b'", "Y(b'y')"], "__int__": ["5", "I(6)", "True"],
        "__index__": ["2", "I(1)", "True", "-1"], "__float__": ["1.5", "F(2.5)"], "__complex__": ["1j", "C(2)"], "__bool__": ["True", "False"], "__len__": ["2", "-1", "I(3)", "2**70"],
        "__hash__": ["7", "I(8)", "2**70"], "__iter__": ["iter([1, 2])", "iter('ab')", "self"], "__next__": ["1"], "__contains__": ["1", "[]"], "__length_hint__": ["3", "-2", "'x'"],
        "__getitem__": ["'i'", "[][k]"], "__reversed__": ["[2, 1]"], "__round__": ["4"], "__trunc__": ["3", "I(4)", "'x'"], "__floor__": ["2"], "__ceil__": ["9"], "__abs__": ["1"],
        "__dir__": ["['b', 'a']", "'zy'"], "__call__": ["x"], "__eq__": ["'eq'", "[]"], "__lt__": ["'lt'", "0"], "__divmod__": ["(1, 2)"], "__pow__": ["'pow'"], "__neg__": ["-1"],
        "__missing__": ["'missing'"], "__getattr__": ["5", "[][5]"], "__delattr__": ["0"], "__enter__": ["1"], "__exit__": ["[]", "1"], "__instancecheck__": ["1"], "__fspath__": ["'p'"],
        "__set_name__": ["0"], "__get__": ["'got'"], "__matmul__": ["'@'"], "__iadd__": ["'+='"], "__radd__": ["'r+'"], "__rmod__": ["'r%'"], "__mul__": ["'*'"], "__rmul__": ["'r*'"]}
# Not here (docs/LANGUAGE.md): special names in `dir()`, which in CPython are those of slots of C.
ASKS = ["str(o)", "repr(o)", "f'{o}'", "f'{o!r}'", "f'{o!s:>4}'", "format(o, '>5')", "'%s' % (o,) + ''", "'%r|%s' % (o, o)", "'%d' % o", "'%x' % o", "'%.2f' % o", "'%c' % o", "'%*d' % (o, 3)",
        "'{}|{!r}'.format(o, o)", "'{:d}'.format(o)", "'{0[1]}'.format(o)", "'{0.n}'.format(o)", "ascii(o)", "bytes(o)", "bytearray(o)", "b'%s' % o", "b'%d' % o", "b'%c' % o", "int(o)", "float(o)",
        "complex(o)", "bool(o)", "not o", "1 if o else 2", "len(o)", "hash(o) == hash(o)", "{o: 1}[o]", "o in {1, 2}", "list(o)", "tuple(o)", "set(o)", "dict(o)", "sorted(o)", "[*o]", "{*o}", "{**o}",
        "(lambda *x: x)(*o)", "a1, *b1 = o; x = a1, b1", "x, y = o; x = x, y", "iter(o)", "next(o)", "list(reversed(o))", "list(zip(o, o))[:3]", "list(map(str, o))", "list(enumerate(o))", "sum(o)", "max(o)", "min(o, 1)",
        "any(o)", "all(o)", "1 in o", "o[0]", "o['k']", "o[:2]", "[1, 2, 3][o]", "[1, 2, 3][o:]", "'abc'[o]", "(1, 2)[o]", "range(o)", "range(5)[o]", "'a' * o", "[1] * o", "o * 2", "o + 1", "1 + o", "o += 1; x = o",
        "o == 1", "o != 1", "o < 1", "o <= 1", "1 > o", "o @ 1", "divmod(o, 2)", "pow(o, 2)", "pow(2, o)", "-o", "abs(o)", "round(o)", "round(1.5, o)", "math.floor(o)", "math.ceil(o)", "math.trunc(o)", "math.sqrt(o)",
        "math.gcd(o, 4)", "math.factorial(o)", "math.isqrt(o)", "math.hypot(o, 1)", "math.comb(5, o)", "math.ldexp(1.0, o)", "chr(o)", "hex(o)", "bin(o)", "[x for x in dir(o) if x[0] != '_']", "o()", "o(1)", "o.n", "getattr(o, 'q', 5)",
        "hasattr(o, 'q')", "isinstance(1, o)", "operator.index(o)", "operator.length_hint(o)", "operator.methodcaller(o)(1)", "operator.itemgetter(o)([1, 2, 3])", "operator.attrgetter('n')(o)", "type(o).__reduce_ex__(o, 2)[1][1:]", "','.join(o)", "b''.join(o)", "'abc'.replace('a', o)", "'a,b'.split(',', o)", "'abc'.find('c', o)", "'ab'.center(o)",
        "'ab'.startswith(o)", "'%s' % o", "[].extend(o)", "[0].__iadd__(o)", "[3].insert(o, 1)", "[1, 2].pop(o)", "[1].index(1, o)", "{}.update(o)", "{1}.union(o)", "{1} | o", "dict.fromkeys(o)", "struct.pack('i', o)",
        "struct.pack('d', o)", "struct.pack('?', o)", "collections.Counter(o)", "collections.deque(o, 2)", "functools.reduce(max, o)", "list(itertools.islice(o, 2))", "list(itertools.chain(o, o))[:4]",
        "list(itertools.islice('abc', o))", "list(itertools.repeat(1, o))", "list(itertools.permutations(o, 1))[:2]", "json.dumps(o)", "json.dumps([o])", "copy.copy(o) == o", "int('7', o)", "int.from_bytes(o, 'big')",
        "(5).to_bytes(o, 'big')", "slice(o).indices(4)", "sorted([2, 1], key=o)", "sorted([1, 2], reverse=o)", "statistics.mean(o)", "timedelta(o)", "date(2024, 1, o)", "round(timedelta(1) / 3, o)", "timedelta(1) * o",
        "print(o, end='') or 1", "type(str(o)).__name__, type(f'{o}').__name__", "type(int(o)).__name__, type(float(o)).__name__", "type(repr(o)).__name__", "string.Template('$a').substitute(a=o)", "re.sub('a', o, 'ab')", "string.Formatter().format('{0} {0!r:>5}', o)", "string.Formatter().vformat('{a[0]}', (), {'a': o})", "object.__repr__(o)[:5]", "object.__str__(o)[:5]", "bool.__and__(True, o)", "OSError.__str__(o)", "pow(2, o, 5)",
        "float.fromhex(o)", "o.__len__()", "o.__str__()", "o.__iter__()", "super(K, o).__repr__()[:2]", "zip(o)"]


class Programs:
    """Makes programs with the numbers of one generator."""

    def __init__(self, random):
        self.r = random

    def of(self, *pools):
        return self.r.choice(self.r.choice(pools))

    def value(self):
        pick = self.r.random()
        if pick < 0.35:
            return self.r.choice(NAMES)
        return self.of(*POOLS)

    def slice(self):
        r = self.r
        return ":".join(r.choice(["", "0", "1", "2", "-1", "-2", "5", "None", "a"]) for _ in range(r.choice([2, 2, 3])))

    def expression(self, depth=0):
        r = self.r
        sub = self.value if depth > 1 else lambda: self.expression(depth + 1)
        pick = r.randrange(24)
        if pick < 6:
            return self.value()
        if pick == 6:
            op = r.choice(BINARY)
            right = self.of(SMALL) if op in ("**", "<<", "*") else sub()
            return f"({sub()} {op} {right})"
        if pick == 7:
            return f"{self.value()}[{r.choice([self.of(SMALL), self.slice(), self.value()])}]"
        if pick == 8:
            return f"f'{{{self.value()}!r:{r.choice(['', '>9', '.4', '<3'])}}}|{{{self.value()}}}'"
        if pick == 9:
            return f"format({self.value()}, {r.choice(SPECS)!r})"
        if pick == 10:
            return f"{r.choice(PERCENTS)!r} % {r.choice(['(' + self.value() + ',)', self.value(), '(' + self.value() + ', ' + self.value() + ')'])}"
        if pick == 11:
            return f"[{sub()} for x in {self.value()} if x]"
        if pick == 12:
            return f"{{{self.value()}: x for x in {self.value()}}}"
        if pick == 13:
            return f"sorted({self.value()}, key={r.choice(['str', 'repr', 'len', 'None', 'lambda x: x'])}, reverse={r.choice(['True', 'False'])})"
        if pick == 14:
            name = r.choice(["len", "str", "repr", "list", "tuple", "set", "dict", "bool", "int", "float", "abs", "sum", "max", "min", "iter", "any",
                             "all", "ascii", "bytes", "reversed", "enumerate", "round", "complex", "frozenset", "ord", "chr", "hex", "callable", "next"])
            if name == "bytes":
                return f"bytes({self.of(TEXTS)}, {r.choice(CODECS)!r})"
            return f"{name}({self.value()})"
        if pick == 15:
            return f"{self.of(TEXTS)}.encode({r.choice(CODECS)!r}, {r.choice(HANDLERS)!r})"
        if pick == 16:
            return f"{r.choice([self.of(BYTES), self.of(TEXTS) + '.encode(' + repr(r.choice(CODECS)) + ', ' + repr('ignore') + ')'])}.decode({r.choice(CODECS)!r}, {r.choice(HANDLERS[:6])!r})"
        if pick == 17:
            method = r.choice(["upper", "lower", "title", "casefold", "swapcase", "capitalize", "isalpha", "isprintable", "isidentifier", "split", "strip",
                               "splitlines", "isnumeric", "istitle", "expandtabs", "isupper"])
            return f"{self.of(TEXTS)}.{method}()"
        if pick == 18:
            return f"getattr({self.value()}, {r.choice(['real', 'x', 'keys', 'append', '__class__', 'p', 'args', '__len__', 'n'])!r}, {self.value()})"
        if pick == 19:
            return f"({sub()} if {self.value()} else {sub()})"
        if pick == 20:
            return f"(lambda x, *y, z={self.of(SMALL)}: (x, y, z))({', '.join(self.value() for _ in range(r.choice([0, 1, 2, 3])))})"
        if pick == 21:
            return f"[*{self.value()}, {self.value()}]"
        if pick == 22:
            return f"isinstance({self.value()}, {r.choice(['int', '(str, list)', 'dict', 'object', 'int | str', 'type(a)'])})"
        return f"divmod({self.of(NUMBERS)}, {self.of(NUMBERS)})"

    def statement(self, depth=0):
        r = self.r
        pick = r.randrange(34)
        name = r.choice(NAMES)
        if pick < 5 or depth > 2:
            return [f"{name} = {self.expression()}"]
        if pick == 5:
            op = r.choice(["+=", "-=", "*=", "|=", "&=", "//=", "%="])
            # Times a big number a text would take all memory there is.
            return [f"{name} {op} {self.of(SMALL) if op == '*=' else self.of(SMALL, *POOLS)}"]
        if pick == 6:
            return [f"{name}[{r.choice([self.of(SMALL), self.slice()])}] = {self.value()}"]
        if pick == 7:
            return [f"del {name}[{r.choice([self.of(SMALL), self.slice()])}]"]
        if pick == 8:
            call = r.choice(["append({v})", "extend({v})", "pop()", "pop({s})", "insert({s}, {v})", "update({v})", "add({v})", "discard({v})", "clear()", "sort()",
                             "reverse()", "setdefault({v}, {s})", "remove({v})", "popitem()", "index({v})", "count({v})", "copy()", "get({v})", "join({v})",
                             "replace({v}, 'q')", "startswith({v})", "find({v})", "partition({v})", "union({v})", "zfill({s})", "center({s})", "items()"])
            return [f"c = {name}.{call.format(v=self.value(), s=self.of(SMALL))}"]
        if pick == 9:
            return [f"for {r.choice(['x', 'x, y', 'a', 'x, *y'])} in itertools.islice({self.value()}, 5):"] + indented(self.block(depth + 1)) + \
                   r.choice([[], ["else:"] + indented(self.block(depth + 1))])
        if pick == 10:
            lines = ["try:"] + indented(self.block(depth + 1))
            for _ in range(r.choice([1, 1, 2])):
                lines += [f"except {r.choice(ERRORS)} as e:"] + indented([r.choice(["b = type(e).__name__, str(e)", "c = e.args", "b = repr(e)", "raise",
                                                                                  "raise RuntimeError('again') from e", "a = e.__context__"])])
            return lines + r.choice([[], ["else:"] + indented(self.block(depth + 1))]) + r.choice([[], ["finally:"] + indented(self.block(depth + 1))])
        if pick == 11:
            return [f"if {self.expression()}:"] + indented(self.block(depth + 1)) + r.choice([[], ["else:"] + indented(self.block(depth + 1))])
        if pick == 12:
            return [f"raise {r.choice(['ValueError', 'KeyError', 'TypeError'])}({self.value()})"]
        if pick == 13:
            targets = r.choice(["a, b", "a, *b", "*a, b", "(a, b), c", "a, b, c", "a[0]", "[a, b]"])
            return [f"{targets} = {self.value()}"]
        if pick == 14:
            body = [r.choice([f"yield {self.value()}", f"c = yield {self.value()}", f"yield from {self.value()}", f"return {self.value()}",
                              f"b = {self.expression()}"]) for _ in range(r.choice([1, 2, 3]))]
            if r.random() < 0.3:
                body = ["try:"] + indented(body) + [f"except {r.choice(ERRORS)} as e:", f"    yield repr(e)", "finally:", f"    yield {self.value()}"]
            use = r.choice(["list(g)", "next(g), next(g)", "g.send(None)", "next(g), g.send(5)", "next(g), g.throw(KeyError('t'))", "g.close()", "sum(g)",
                            "dict(g)", "sorted(g)", "[*itertools.islice(g, 3)]", "g.gi_frame is None, g.gi_running"])
            return ["def made(a=a, b=b, c=c):"] + indented(body + ["yield 0"]) + ["g = made()", f"{name} = {use}"]
        if pick == 15:
            body = [r.choice(DUNDERS).format(value=self.of(*POOLS[:5]), small=self.of(SMALL), text=self.of(TEXTS)) for _ in range(r.choice([1, 2, 2, 3]))]
            base = r.choice(["", "", "(list)", "(dict)", "(int)", "(str)", "(tuple)", "(Exception)", "(set)"])
            lines = [f"class K{base}:"] + ["    " + line for line in body]
            text = "\n".join(lines).replace("\n        ", "\n    ").split("\n")
            # A class derived from a container can be indexed in CPython, which gives an alias for annotations: not here.
            use = r.choice([f"K()", "K({0})".format(self.of(*POOLS[1:4])), "K" if base in ("", "(int)", "(str)") else "K()"])
            return text + ["a = " + use, r.choice([f"b = {self.expression()}", "b = len(a)", "b = list(a)", "b = a + 1", "b = a[0]", "b = str(a)[:9]", "b = bool(a)", "b = a.p",
                                                   "b = a.q", "b = a.k()", "b = a.x", "b = 2 * a", "b = {a: 1}", "b = a == 1, a != 1", "b = f'{a:>5}'", "b = a.zz", "a.n = 3; b = a.n",
                                                   "b = int(a), float(a)", "b = 3 in a", "b = sorted([a, a])", "a += 1; b = a.n", "b = round(a)", "b = 0 if isinstance(a, type) else vars(a)", "del a[0]", "a[1] = 2",
                                                   "b = [x for x in a][:4]", "b = a()", "b = a < 1", "b = hash(a) == hash(a)", "b = isinstance(a, K), K.__mro__[1].__name__"]),
                           "a = type(a).__name__"]
        if pick == 16:
            return [f"def f({r.choice(['x', 'x, y=1', '*x', 'x, /, y', '*, x=2', 'x=1, *y, **z', ''])}):"] + indented([f"return {r.choice(['locals()', '1', 'a', 'x'])}"]) + \
                   [f"c = f({r.choice(['', '1', '1, 2', 'x=1', '*a', '**b', '1, y=2', 'y=3, x=4'])})", "c = list(c.items()) if isinstance(c, dict) else c"]
        if pick == 17:
            return [f"with contextlib.suppress({r.choice(ERRORS[:6])}):"] + indented(self.block(depth + 1))
        if pick == 18:
            return [f"assert {self.expression()}, {self.value()}"]
        if pick == 19:
            return [f"c = eval({self.value() + ' or ' + self.value()!r}, {{'a': a, 'b': b, 'c': c, 'itertools': itertools}})"]
        if pick == 20:
            # Each loop within another counts for itself.
            n = f"n{depth}"
            return [f"{n} = 0", f"while {self.expression()}:", f"    {n} += 1", f"    if {n} > 3: break"] + indented(self.block(depth + 1))
        if pick == 21:
            return self.mixed()
        if pick == 22:
            return self.changing()
        if pick == 23:
            return self.calls()
        if pick == 24:
            return self.leaving()
        if pick == 25:
            return self.inheriting()
        if pick == 26:
            return self.groups()
        if pick == 27:
            return self.slicing()
        if pick == 28:
            return [f"{name} = {self.big()}"]
        if pick == 29:
            return self.asked()
        if pick == 30:
            return self.unbound()
        if pick == 31:
            return self.copied()
        if pick == 32:
            return [f"{name} = {self.fields()}"]
        return [f"{name} = {self.expression()}, {self.expression()}"]

    def asked(self):
        """An object whose special methods give what they should, something derived from it, or something else, and who asks for it."""
        r = self.r
        gives = lambda *more: r.choice([*more, *more, self.value(), self.of(SMALL), "NotImplemented", "KeyError('k')"])
        names = r.sample(list(KEPT), r.choice([1, 2, 3]))
        lines = ["class S(str): pass", "class Y(bytes): pass", "class I(int): pass", "class F(float): pass", "class C(complex): pass",
                 f"class K{r.choice(['', '', '', '(list)', '(dict)', '(str)', '(int)', '(float)', '(tuple)', '(set)', '(bytes)'])}:"]
        for name in names:
            body = r.choice([f"return {gives(*KEPT[name])}"] * 7 + [f"raise {r.choice(['ValueError(1)', 'TypeError', 'KeyError(2)', 'StopIteration', 'AttributeError', 'IndexError'])}"])
            lines += [f"    def {name}(self, *x, k=0): {body}"]
        value = r.choice(["K()", "K()", "K()", "K([1, 2])", "K('12')"])
        lines += ["r = []", "try:", f"    o = {value}", "except Exception as e:", "    o, r = 5, [str(e)]"]
        for ask in r.sample(ASKS, 5):
            lines += ["try:"] + ["    " + line for line in (ask.split("; ") if "; " in ask else [f"x = {ask}"])] + ["    r.append(x)", "except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
        return lines + [f"{r.choice(NAMES)} = [show(x) for x in r] if '<' not in repr(r) else len(r)"]

    def unbound(self):
        """Methods of builtin types called as functions, by position and by name, with receivers of all kinds."""
        r = self.r
        names = {"str": "upper split join replace find count encode format strip center startswith partition splitlines zfill __len__ __add__ __mul__ __getitem__ __contains__ __eq__ __lt__ __iter__ __mod__",
                 "list": "append extend insert pop remove index count sort reverse copy clear __len__ __add__ __iadd__ __mul__ __imul__ __getitem__ __setitem__ __delitem__ __contains__ __eq__ __iter__",
                 "dict": "get pop popitem setdefault update items keys values copy clear fromkeys __getitem__ __setitem__ __contains__ __len__ __or__ __ior__ __eq__ __iter__",
                 "set": "add discard remove union update difference issubset pop copy isdisjoint __and__ __or__ __contains__ __len__ __ior__ __le__ __eq__",
                 "frozenset": "union intersection issuperset copy __and__ __contains__ __len__ __hash__", "tuple": "index count __len__ __add__ __mul__ __getitem__ __contains__ __eq__ __hash__",
                 "int": "bit_length to_bytes from_bytes conjugate as_integer_ratio __add__ __sub__ __mul__ __neg__ __eq__ __lt__ __and__ __bool__ __floordiv__ __mod__ __lshift__ __hash__ __index__",
                 "float": "is_integer hex fromhex as_integer_ratio __add__ __mul__ __neg__ __eq__ __lt__ __truediv__ __int__", "bytes": "hex fromhex decode find join split upper __len__ __add__ __mul__ __getitem__ __contains__",
                 "bytearray": "append extend pop insert decode __len__ __iadd__ __imul__ __setitem__ __getitem__ __add__", "range": "index count __len__ __getitem__ __contains__ __iter__", "complex": "conjugate __add__ __mul__ __neg__",
                 "object": "__eq__ __hash__ __getattribute__ __setattr__"}
        lines = ["r = []", "class L(list): pass", "class D(dict): pass", "class N(int): pass", "class T(str): pass"]
        for _ in range(5):
            kind = r.choice(list(names))
            name = r.choice(names[kind].split())
            own = {"str": TEXTS + ["T('t')"], "list": LISTS + ["L([1, 2])"], "dict": DICTS + ["D(a=1)"], "set": SETS[:4], "frozenset": SETS[4:], "tuple": TUPLES, "int": NUMBERS[:15] + ["N(5)"], "float": NUMBERS[15:20], "bytes": BYTES[:3],
                   "bytearray": BYTES[3:], "range": ["range(5)", "range(9, 0, -2)"], "complex": ["1j", "(2-3j)"], "object": ["5"]}[kind]
            receiver = r.choice([*own, *own, self.value(), "L()", "N(5)"])
            args = ", ".join(r.choice([r.choice(own), self.value(), self.of(SMALL)]) for _ in range(r.choice([0, 1, 1, 1, 2, 3])))
            if name == "__lshift__":
                # Of a number that fills the memory CPython says only when it is to be shown that it is too long.
                args = self.of(SMALL)
            call = r.choice([f"{kind}.{name}({receiver}{', ' * bool(args)}{args})"] * 4 + [f"{kind}.{name}({args})", f"({receiver}).{name}({args})", f"list(map({kind}.{name}, [{receiver}, {self.value()}]))",
                                                                                    f"functools.partial({kind}.{name}, {receiver})({args})"])
            lines += ["try:", f"    r.append({call})", "except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
        return lines + [f"{r.choice(NAMES)} = [show(x) for x in r] if '<' not in repr(r) else len(r)"]

    def copied(self):
        """Iterators and containers that are copied on the way."""
        r = self.r
        start = r.choice([f"iter({self.value()})", f"reversed({self.of(LISTS, TUPLES, TEXTS)})", f"enumerate({self.value()})", f"zip({self.value()}, {self.value()})", f"map(str, {self.value()})", f"filter(None, {self.value()})",
                          "iter({1: 2, 3: 4}.items())", "iter(range(3, 9))", "iter([1, [2], [3]])", "reversed(range(4))", "iter('日本語')", "reversed({1: 2, 3: 4})", "[[1, 2], [3]]", "{'a': [1], 'b': {2}}", "([1], (2,))",
                          "collections.deque([[1], 2])", "collections.OrderedDict(a=[1])", "collections.Counter('aab')", "collections.defaultdict(list, a=[1])", "(x for x in 'abc')", "date(2024, 1, 2)", "timedelta(1)", "range(3)",
                          "slice(1, 2)", "len", "{1: 2}.keys()", "ValueError(1, [2])", "bytearray(b'ab')", "iter(bytearray(b'ab'))"])
        lines = ["r = []", "try:", f"    i = {start}", "except Exception as e:", "    i, r = [[1]], [str(e)]"]
        for _ in range(4):
            use = r.choice(["i = copy.copy(i)", "i = copy.deepcopy(i)", "r.append(next(i))", "j = copy.copy(i); r.append(list(j))", "j = copy.deepcopy(i); r.append(list(j))", # What type a copy of an iterator at its end has shows how CPython makes it, no more.
                            "r.append(operator.length_hint(i, 1) and type(copy.copy(i)).__name__)", "r.append(list(i)[:4])",
                            "j = copy.copy(i); r.append(j == i)", "j = copy.deepcopy(i); r.append((j == i, j is i))", "j = copy.deepcopy([i, i]); r.append(j[0] is j[1])", "r.append(copy.copy(i))", "r.append(operator.length_hint(i))"])
            lines += ["try:"] + ["    " + line for line in use.split("; ")] + ["except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
        return lines + [f"{r.choice(NAMES)} = [show(x) for x in r] if '<' not in repr(r) else len(r)"]

    def fields(self):
        """Texts with several fields, of all ways of formatting."""
        r = self.r
        spec = lambda: r.choice(["", "", f":{r.choice(SPECS)}", "!r", "!s:>6", "!a", ":{1}", ":{w}", ":>{w}.{p}"])
        field = lambda: "{" + r.choice(["", "", "0", "1", "a", "0[0]", "1[k]", "0.real", "a.imag", "2", "0[-1]", "a[b]", "0.__class__", "-1", "0]", "a.", " "]) + spec() + "}"
        text = "".join(r.choice([field(), field(), "x", "{{", "}}", "é", "%", "{", "日"]) if r.random() < 0.9 else "}" for _ in range(r.choice([1, 2, 3, 4])))
        args = r.choice([f"{self.value()}", f"{self.value()}, {self.value()}", "", f"*{self.value()}", f"{self.value()}, a={self.value()}, w=5, p=2", f"a={self.value()}, w='^7'"])
        percents = "".join(r.choice([*PERCENTS, "%(a)r", "%-*d|", "%.*f", "%5.1f%%", "x", "é", "%+.2e", "%#x"]) for _ in range(r.choice([1, 2, 3])))
        return r.choice([f"{text!r}.format({args})", f"{text!r}.format({args})", f"{text!r}.format_map({self.of(DICTS)})", f"{percents!r} % {self.of(TUPLES, DICTS)}", f"{percents!r} % ({self.value()}, {self.value()})",
                         f"{percents!r} % {{'a': {self.value()}, 'b': 1}}", f"b{ascii(percents)} % ({self.value()}, {self.value()})" if percents.isascii() else f"{percents!r} % ()",
                         f"string.Template({r.choice(['$a', '${a}', '$', '$$a', '${', '$1', '$é', '${a} $b'])!r}).substitute(a={self.value()})"])

    def mixed(self):
        """One place in a program that meets values of several kinds one after the other."""
        r = self.r
        # Whether equal constants of a function are one object is the compiler's business, so no two texts are compared by `is`.
        use = r.choice([
            f"x = o[{self.of(SMALL)}]", f"x = o[{self.slice()}]", f"x = o[k]", f"o[k] = {self.value()}; x = o", f"o[k] += 1; x = o", "x, y = o; x = y, x",
            "x, y, *z = o; x = x, z", "x = [y for y in o]", "x = o == k", "x = o < k", "x = k in o", "x = o is o", "x = not o", "x = o and k or 5", "x = o + o",
            "x = o * 2", "x = -o", "o += k; x = o", "o -= k; x = o", "x = f'{o}{k!r}'", "x = '%s-%s' % (o, k)", "x = len(o)", "x = o.n", "o.n = k; x = o.n",
            "x = o.get(k, 7)", "o.append(k); x = o", "o.add(k); x = sorted(map(repr, o))", "x = o.pop()", "x = o.count(k)", "x = o.upper()", "x = o.strip().lower()",
            "x = o.replace(k, 'q')", "x = o.split(k)", "x = o.join(['a', 'b'])", "x = o.startswith(k)", "x = isinstance(o, (int, list)), isinstance(k, str)",
            "x = str(o), int(o)", "x = float(o)", "x = max(o, k)", "x = sum(o)", "x = list(zip(o, o))", "x = dict(enumerate(o))", "x = {o: k}[o]", "x = d[o]",
            "d[o] = k; x = d.get(o), len(d)", "x = d.setdefault(o, []); x.append(k)", "x = s.add(o), len(s), o in s", "x = abs(o), bool(o)", "x = o // 7, o % 7",
            "x = o >> 1, o & 255, o ^ 3", "x = o ** 2", "x = 0 <= o < 10", "x = getattr(o, 'real', k)", "x = g(o)", "x = g(o, k)", "x = g(*[o, k])", "x = g(y=o)",
            "x = h(o, k)", "x = h(*o)", "x = (o, k)[::-1]", "x = [*o, k]", "x = next(iter(o))", "x = o.real if o else k", "x = yes(o)", "x = o(k)", "del o[k]; x = o",
        ])
        values = ", ".join(self.of(*POOLS) for _ in range(r.choice([3, 4, 6])))
        keys = ", ".join(self.of(SMALL, TEXTS, NUMBERS) for _ in range(3))
        return ["r, d, s = [], {1: 2, 'a': 3, (1, 2): 4}, {1}", "def g(x, y=3): return y, x", "def h(*x): return x", "def yes(x):", "    if x: return x", "    return 'no'",
                f"for k in [{keys}]:", f"    for o in [{values}]:", "        try:"] + ["            " + line for line in use.split("; ")] + \
               ["            r.append(x)", "        except Exception as e:", "            r.append((type(e).__name__, str(e)))", f"{r.choice(NAMES)} = r"]

    def changing(self):
        """Classes that change while one place of a program reads, sets and calls what they have."""
        r = self.r
        value = lambda: self.of(*POOLS[:5])
        start = [r.choice(["def m(self, x=0): return 'm', x", "m = 5", "m = property(lambda self: 'p')", "m = staticmethod(lambda *x: ('s', x))",
                           "m = classmethod(lambda c, x=1: (c.__name__, x))", "n = 4", "pass", "def __getattr__(self, name): return 'ga ' + name",
                           "def __init__(self, *x): self.n = x", "def __eq__(self, other): return other", "def __setattr__(self, k, v): object.__setattr__(self, k, (v, 1))"])
                 for _ in range(r.choice([1, 2]))]
        change = lambda: r.choice(["K.m = lambda self, *x: ('new', x)", f"K.m = {value()}", "del K.m", "o.m = lambda *x: ('own', x)", f"o.m = {value()}", "del o.m", "B.m = lambda self: 'base'",
                                   "K.m = property(lambda self: 'late')", f"o.n = {value()}", "del o.n", f"K.n = {value()}", "o.__dict__['m'] = 9", "o = C()", "o = K()",
                                   "K.__getattr__ = lambda self, name: name", "vars(o).clear()", "C.m = 7", "K.__eq__ = lambda self, x: 'eq'", "K.__len__ = lambda self: 3",
                                   "K.__getitem__ = lambda self, k: k", "K.__call__ = lambda self, *x: x", "K.__bool__ = lambda self: False", "o, p = p, o"])
        use = r.choice(["o.m", "o.m()", "o.m(i)", "o.m(i, i)", "o.n", "o.m(x=i)", "o.m, o.n", "p.m()", "o == i", "len(o)", "o[i]", "o(i)", "bool(o)", "getattr(o, 'm')", "hasattr(o, 'm')",
                        "K.m", "o.m if o else 0", "[q.m() for q in (o, p)]", "str(o.n)", "sorted(vars(o))", "K().n", "isinstance(o, C)"])
        lines = ["class B: pass", "class K(B):"] + indented(start) + ["class C(B):", "    def m(self, *x): return 'C', x", "r = []", "try:", "    o, p = K(), C()",
                 "    for i in range(6):", "        try:", f"            x = {use}", "            r.append('method' if callable(x) else x)",
                 "        except Exception as e:", "            r.append((type(e).__name__, str(e)))", "        try:"]
        for at in range(4):
            lines += [f"            if i == {at}: {change()}"]
        return lines + ["        except Exception as e:", "            r.append((type(e).__name__, str(e)))", "except Exception as e:", "    r = repr(e)",
                        f"{r.choice(NAMES)} = r if '<' not in repr(r) else len(r)"]

    def calls(self):
        """Functions of all kinds, called in all ways from one place after the other."""
        r = self.r
        params = r.choice(["", "x", "x, y", "x, y=2", "x=1, y=2, z=3", "*x", "x, *y", "**x", "x, **y", "*, x", "*, x=1", "x, /", "x, /, y=1, *z, k=4, **w", "x=[]",
                           "a1, a2, a3, a4, a5, a6=6", "x, *, y=3"])
        body = r.choice(["return sorted(locals().items(), key=repr)", "return x", "x.append(1); return x", "return (lambda: x)()", "yield x", "global gg; gg = 1; return gg",
                         "return [x for _ in range(2)]", "try: return x", "x += 1; return x", "return 1", "return y, x", "def q(): nonlocal x; x = 5; return x"])
        body = body.split("; ") if not body.startswith(("try", "def")) else {"try": ["try: return x", "finally: x = 0"],
                                                                            "def": ["def q():", "    nonlocal x", "    x = 5", "    return x", "return q(), x"]}[body[:3]]
        calls = [r.choice(["f()", "f(1)", "f(1, 2)", "f(1, 2, 3)", "f(x=1)", "f(1, x=2)", "f(1, y=2)", "f(y=2, x=1)", "f(*(1, 2))", "f(*[])", "f(**{'x': 3})", "f(1, *[2], **{'z': 3})",
                           "f(k=1)", "f(*'ab')", "f(**{'x': 1}, y=2)", "f(1, 2, 3, 4, 5, 6, 7)", "[f(i) for i in (1, 2)]", "next(f(1))", "list(map(f, [1, 2]))", "f.__code__.co_argcount",
                           "functools.partial(f, 1)()", "f(*f.__defaults__ or ())", "sorted([2, 1], key=f)", "functools.reduce(f, [1, 2, 3])"]) for _ in range(4)]
        lines = [f"def f({params}):"] + indented(body) + ["r = []"]
        for call in calls:
            lines += ["try:", f"    r.append({call})", "except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
        return lines + [f"{r.choice(NAMES)} = r if '<' not in repr(r) else len(r)"]

    def leaving(self):
        """Ways out of loops, handlers and `finally`, one in another."""
        r = self.r
        out = lambda: r.choice(["break", "continue", f"return {self.value()}", "pass", f"raise {r.choice(['KeyError(i)', 'ValueError', 'StopIteration(5)'])}", "r.append(i)",
                                "1 // (i % 2)", "raise", "del r[5]", "e", "i += 1", "nope", f"yield i" if r.random() < 0.2 else "r.append(-i)"])
        lines = ["def f():", "    r = []", f"    for i in range({r.choice(['3', '5'])}):", "        try:", f"            {out()}", "            try:", f"                {out()}"]
        lines += [f"            except {r.choice(ERRORS)} as e:", f"                {out()}"] if r.random() < 0.7 else []
        lines += ["            finally:", f"                {out()}"] + [f"        except {r.choice(ERRORS)} as e:", "            r.append((repr(e), repr(e.__context__), repr(e.__cause__)))",
                                                                    f"            {out()}"]
        lines += r.choice([[], ["        else:", f"            {out()}"]]) + r.choice([[], ["        finally:", f"            r.append('f'); {out()}"]])
        return lines + r.choice([[], ["    else:", f"        r.append('else')"]]) + ["    return r", "x = f()", f"{r.choice(NAMES)} = list(itertools.islice(x, 9)) if hasattr(x, 'send') else x"]

    def inheriting(self):
        """A few classes below each other that hand methods, properties and descriptors on."""
        r = self.r
        v = lambda: self.of(*POOLS[:5])
        parts = lambda: "\n".join(r.sample([
            "def m(self, *x): return type(self).__name__, x", f"def m(self): return super().m()", "def m(self): return 'm'", f"n = {v()}", "n = property(lambda self: self.k, None)",
            "@property\ndef n(self): return self.__dict__.get('k', 0)\n@n.setter\ndef n(self, v): self.k = v, v", "@classmethod\ndef c(cls, x=1): return cls.__name__, x",
            "@staticmethod\ndef s(x=2): return x", f"def __init__(self, k={v()}): self.k = k", "def __init__(self, *x): super().__init__(*x)", f"def __getattr__(self, name): return {v()}",
            "def __getattribute__(self, name): return super().__getattribute__(name)", "def __setattr__(self, name, v): object.__setattr__(self, name, [v])",
            f"def __get__(self, o, t=None): return o is None, {v()}", f"__slots__ = ('k', 'j')", "def __init_subclass__(cls, **k): cls.made = sorted(k)",
            "def __set_name__(self, o, name): self.k = name", f"def __eq__(self, o): return {v()}", "def __class_getitem__(cls, k): return cls.__name__, k",
            f"def __new__(cls, *x): return super().__new__(cls)", f"def __len__(self): return {self.of(SMALL)}", f"def __delattr__(self, name): self.gone = name",
            "def __contains__(self, x): return super().__contains__(x)", f"def __iter__(self): yield from {v()}", f"__hash__ = None"], r.choice([1, 2, 2, 3]))).split("\n")
        base = r.choice(["", "", "(list)", "(dict)", "(int)", "(str)", "(Exception)", "(tuple)"])
        lines = ["r = []", "try:", f"    class A{base}:"] + indented(indented(parts())) + [f"    class B({r.choice(['A', 'A', 'A, k=1'])}):"] + indented(indented(parts()))
        lines += [f"    class C({r.choice(['A', 'B', 'B, A', 'A, B'])}):", f"        d = {r.choice(['A()', '1', 'B'])}"] + indented(indented(parts()))
        lines += [f"    o = {r.choice('ABC')}(" + r.choice(["", "", "1", "[1, 2]", "'ab'"]) + ")"]
        for _ in range(4):
            use = r.choice(["o.m()", "o.n", "o.k", "o.c()", "C.c(3)", "o.s()", "o.d", "C.d", "o.zz", "len(o)", "list(o)", "o == 1", "o.__dict__", "C.made", "super(B, o).m()", "A.m(o)", "isinstance(o, A)",
                            "[c.__name__ for c in C.__mro__]", "hasattr(o, 'n')", "getattr(o, 'm', 0) and 1", "str(o)[:1]", "1 in o", "hash(o) == hash(o)", "sorted(vars(o))", "B.n", "bool(o)",
                            "list(vars(C))", "[k for k, v in vars(A).items() if callable(v)]", "C.__base__.__name__", "(C.__qualname__, A.__module__)", "[k for k in dir(o) if k[1] != '_']", "hasattr(o, '__weakref__')"])
            change = r.choice(["", "", f"o.n = {v()}; ", f"o.k = {v()}; ", "del o.k; ", "o.m = len; ", "B.m = lambda *x: len(x); ", "del A.m; ", "C.n = 5; ", "del o.n; "])
            lines += ["    try:", f"        {change}r.append({use})", "    except Exception as e:", "        r.append((type(e).__name__, str(e)))"]
        return lines + ["except Exception as e:", "    r.append((type(e).__name__, str(e)))", f"{r.choice(NAMES)} = r if '<' not in repr(r) else len(r)"]

    def groups(self):
        """Exception groups and `except*`, notes and causes."""
        r = self.r
        leaf = lambda: r.choice(["ValueError(1)", "KeyError('k')", "TypeError()", "OSError(2, 'x')", "IndexError(3)"])
        group = lambda depth: f"ExceptionGroup({self.r.choice(TEXTS[:6])}, [{', '.join(leaf() if depth > 1 or r.random() < 0.7 else group(depth + 1) for _ in range(r.choice([1, 2, 3])))}])"
        lines = ["r = []", "try:", "    try:", f"        raise {r.choice([group(0), group(0), leaf()])}"]
        for _ in range(r.choice([1, 2])):
            lines += [f"    except* {r.choice(['ValueError', 'KeyError', '(TypeError, IndexError)', 'LookupError', 'Exception', 'OSError'])} as e:",
                      "        " + r.choice(["r.append(repr(e))", "raise", "raise ValueError(5)", "raise KeyError from e", "r.append([repr(x) for x in e.exceptions])", "e.add_note(1)",
                                             "e.add_note('n')"])]
        lines += r.choice([[], ["    else:", "        r.append('else')"]]) + r.choice([[], ["    finally:", "        r.append('finally')"]])
        return lines + ["except BaseException as e:", "    r.append((repr(e), repr(e.__cause__), repr(e.__context__), getattr(e, '__notes__', 0)))",
                        "    r.append(" + r.choice(["e.args", "e.subgroup(ValueError)", "repr(e.split(KeyError)) if hasattr(e, 'split') else 0", "str(e)",
                                                   "e.derive([ValueError()]) if hasattr(e, 'derive') else 1"]) + ")",
                        f"{r.choice(NAMES)} = repr(r)"]

    def slicing(self):
        """A sequence whose parts are taken, assigned and deleted."""
        r = self.r
        o = r.choice(["list(range(7))", "bytearray(b'abcdefg')", "'a\u00e9\u65e5\U0001f600xyz'", "tuple('abcdef')", "range(2, 30, 3)", "b'abcdefg'", "[*'abcdef']", "range(9, -9, -4)",
                      "'\u0928\u092e\u0938\u094d\u0924\u0947'", "collections.deque([1, 2, 3, 4])"])
        bound = lambda: r.choice(["", "", "0", "1", "3", "-1", "-4", "9", "-9", "None", "2**70", "-2**70", "True", "a", "'1'", "1.0"])
        cut = lambda: f"{bound()}:{bound()}" + r.choice(["", "", f":{r.choice(['1', '2', '-1', '-2', '0', '3', '', 'None', '2**65', '-2**65'])}"])
        lines = [f"o = {o}", "r = []"]
        for _ in range(5):
            use = r.choice([f"r.append(o[{cut()}])", f"r.append(o[{cut()}][{cut()}])", f"o[{cut()}] = " + r.choice(["[7, 8]", "b'xy'", "'pq'", "()", "range(3)", "o", "5", "None", "iter([1])", "o[::-1]"]),
                            f"del o[{cut()}]", f"r.append(slice({self.of(SMALL)}, {self.of(SMALL)}, {self.of(SMALL)}).indices({r.choice(['5', '0', '2**66', '-1', 'a'])}))", "o += o[1:3]",
                            f"o *= {r.choice(['2', '0', '-1'])}", f"r.append(o.index(o[{r.choice(['1', '-2'])}], {self.of(SMALL)}, {self.of(SMALL)}))", f"r.append(o[{bound() or 0}])", f"o[{bound() or 0}] = 65",
                            "r.append(list(reversed(o)))", f"r.append(o.count(o[{r.choice(['0', '2'])}]))", "r.append(o == o[:])", f"o.insert({bound() or 0}, 66)", f"r.append(o.pop({r.choice(['', '0', '-2', '50'])}))"])
            lines += ["try:", f"    {use}", "except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
        return lines + ["r.append(o)", f"{r.choice(NAMES)} = repr(r)"]

    def big(self):
        """Arithmetic on numbers of many digits."""
        r = self.r
        number = lambda: r.choice(["3**200", "-7**77", "2**64", "2**63", "-2**63", "2**128 - 1", "10**40 + 3", "-10**25", "1", "-1", "12345678901234567890", "2**31", "255", "0", "10**18", "1e30", "2.5", "True", "3**41"])
        two = lambda op: f"({number()}) {op} ({number()})"
        small = r.choice(["0", "1", "3", "63", "64", "65", "100", "-1"])
        return r.choice([two(r.choice(["+", "-", "*", "//", "%", "/", "&", "|", "^", "==", "<", ">=", "!="])), f"({number()}) << {small}", f"({number()}) >> {small}", f"divmod({number()}, {number()})",
                         f"pow({number()}, {small}, {number()})", f"math.gcd({number()}, {number()})", f"math.isqrt({number()})", f"({number()}).bit_length()", f"f'{{({number()}):{r.choice(['x', ',', '_b', '>60', 'e', 'n', '+d', '.3f', 'o', '#X'])}}}'",
                         f"int(str({number()}))", f"hash({number()}) % 1000", f"float({number()})", f"round({number()}, {r.choice(['-1', '-20', '3', '-60'])})", f"({number()}).to_bytes(40, 'little', signed=True)",
                         f"int.from_bytes(({number()}).to_bytes(40, 'big', signed=True), 'big', signed=True)", f"{r.choice(['hex', 'bin', 'oct', 'repr', 'abs', 'str', 'complex', 'bool'])}({number()})",
                         f"'%{r.choice(['d', 'x', 'o', '50d', '+e', '.3g', 'i', 'c'])}' % ({number()},)", f"~({number()}), -({number()})", f"({number()}).as_integer_ratio()", f"math.log({number()})", f"sum([{number()}, {number()}, {number()}])",
                         f"int({number()}), int(-{number()})", f"({number()}) ** {r.choice(['2', '3', '0', '-1', '0.5', '7'])}", f"sorted([{number()}, {number()}, {number()}])", f"{{{number()}: 1, {number()}: 2}}", f"math.comb({r.choice(['60', '5', '200'])}, {small})"])

    def block(self, depth):
        lines = []
        for _ in range(self.r.choice([1, 1, 2, 3] if depth else [2, 3, 4, 5])):
            lines += self.statement(depth)
        return lines

    def program(self, number):
        """A function of this number, and the call that shows what it gives."""
        start = [f"{name} = {self.of(*POOLS)}" for name in NAMES]
        lines = [f"def p{number}():"] + indented(start + self.block(0) + ["return a, b, c"])
        return "\n".join(lines + [f"t({number}, p{number})", ""])


def indented(lines):
    return ["    " + line for line in lines]
