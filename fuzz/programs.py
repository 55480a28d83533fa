"""Random programs of several statements for `differential.py`: attributes, containers, generators, exceptions, formatting,
classes, slicing, texts in many scripts, big numbers.

A program is the body of a function without parameters; what it returns is shown. Loops are bounded, so every program ends.
"""

NUMBERS = ["0", "1", "-1", "2", "3", "7", "-5", "10", "255", "2**31", "2**63", "-2**63", "10**25", "-10**30 + 1", "True", "1.5", "-2.5", "0.1",
           "1e22", "float('inf')", "1j", "(2-3j)", "0.0", "-0.0", "3**200"]
SMALL = ["0", "1", "2", "3", "-1", "-2", "5", "None", "True"]
TEXTS = ["''", "'a'", "'abc'", "'a,b'", "'  x '", "'12'", "'éß'", "'日本語'", "'Ωμέγα'", "'привет мир'", "'שלום'", "'مرحبا'", "'हिन्दी'",
         "'ไทย'", "'한국어'", "'e\\u0301'", "'😀👍🏽'", "'İı'", "'ǅ'", "'\\udc80'", "'\\ud83dx'", "'\\x00\\x1f'", "'ß' * 3", "'%s {} '", "'tab\\tnew\\nline'"]
LISTS = ["[]", "[1]", "[3, 1, 2]", "['b', 'a']", "[1, 'a', None]", "[[1], [2, 3]]", "list(range(8))", "[0.5, 2, True]"]
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
        pick = r.randrange(25)
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
            use = r.choice([f"K()", "K({0})".format(self.of(*POOLS[1:4])), "K"])
            return text + ["a = " + use, r.choice([f"b = {self.expression()}", "b = len(a)", "b = list(a)", "b = a + 1", "b = a[0]", "b = str(a)", "b = bool(a)", "b = a.p",
                                                   "b = a.q", "b = a.k()", "b = a.x", "b = 2 * a", "b = {a: 1}", "b = a == 1, a != 1", "b = f'{a:>5}'", "b = a.zz", "a.n = 3; b = a.n",
                                                   "b = int(a), float(a)", "b = 3 in a", "b = sorted([a, a])", "a += 1; b = a.n", "b = round(a)", "b = vars(a)", "del a[0]", "a[1] = 2",
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
            return [f"n = 0", f"while {self.expression()}:", "    n += 1", "    if n > 3: break"] + indented(self.block(depth + 1))
        if pick == 21:
            return self.mixed()
        if pick == 22:
            return self.changing()
        if pick == 23:
            return self.calls()
        return [f"{name} = {self.expression()}, {self.expression()}"]

    def mixed(self):
        """One place in a program that meets values of several kinds one after the other."""
        r = self.r
        use = r.choice([
            f"x = o[{self.of(SMALL)}]", f"x = o[{self.slice()}]", f"x = o[k]", f"o[k] = {self.value()}; x = o", f"o[k] += 1; x = o", "x, y = o; x = y, x",
            "x, y, *z = o; x = x, z", "x = [y for y in o]", "x = o == k", "x = o < k", "x = k in o", "x = o is k", "x = not o", "x = o and k or 5", "x = o + o",
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
