"""Passages of random programs, each about one subject of the language."""

from pieces import (
    ASKS,
    BYTES,
    DICTS,
    ERRORS,
    KEPT,
    LISTS,
    NAMES,
    NUMBERS,
    PERCENTS,
    POOLS,
    SETS,
    SMALL,
    SPECS,
    TEXTS,
    TUPLES,
)


def indented(lines):
    return ["    " + line for line in lines]


class Subjects:
    """Makes passages with the numbers of one generator."""

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

    def asked(self):
        """An object whose special methods give what they should, something derived from it, or something else,
        and who asks for it."""
        r = self.r
        gives = lambda *more: r.choice([*more, *more, self.value(), self.of(SMALL), "NotImplemented", "KeyError('k')"])
        names = r.sample(list(KEPT), r.choice([1, 2, 3]))
        base = r.choice([
            "", "", "", "(list)", "(dict)", "(str)", "(int)", "(float)", "(tuple)", "(set)", "(bytes)",
        ])
        lines = [
            "class S(str): pass", "class Y(bytes): pass", "class I(int): pass", "class F(float): pass",
            "class C(complex): pass", f"class K{base}:",
        ]
        for name in names:
            given = gives(*KEPT[name])
            error = r.choice([
                "ValueError(1)", "TypeError", "KeyError(2)", "StopIteration", "AttributeError", "IndexError",
            ])
            body = r.choice([f"return {given}"] * 7 + [f"raise {error}"])
            lines += [f"    def {name}(self, *x, k=0): {body}"]
        value = r.choice(["K()", "K()", "K()", "K([1, 2])", "K('12')"])
        lines += ["r = []", "try:", f"    o = {value}", "except Exception as e:", "    o, r = 5, [str(e)]"]
        for ask in r.sample(ASKS, 5):
            lines += (
                ["try:"] + ["    " + line for line in (ask.split("; ") if "; " in ask else [f"x = {ask}"])]
                + ["    r.append(x)", "except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
            )
        return lines + [f"{r.choice(NAMES)} = [show(x) for x in r] if '<' not in repr(r) else len(r)"]

    def unbound(self):
        """Methods of builtin types called as functions, by position and by name, with receivers of all kinds."""
        r = self.r
        names = {
            "str": (
                "upper split join replace find count encode format strip center startswith partition splitlines zfill "
                "__len__ __add__ __mul__ __getitem__ __contains__ __eq__ __lt__ __iter__ __mod__"
            ),
            "list": (
                "append extend insert pop remove index count sort reverse copy clear __len__ __add__ __iadd__ __mul__ "
                "__imul__ __getitem__ __setitem__ __delitem__ __contains__ __eq__ __iter__"
            ),
            "dict": (
                "get pop popitem setdefault update items keys values copy clear fromkeys __getitem__ __setitem__ "
                "__contains__ __len__ __or__ __ior__ __eq__ __iter__"
            ),
            "set": (
                "add discard remove union update difference issubset pop copy isdisjoint __and__ __or__ __contains__ "
                "__len__ __ior__ __le__ __eq__"
            ),
            "frozenset": "union intersection issuperset copy __and__ __contains__ __len__ __hash__",
            "tuple": "index count __len__ __add__ __mul__ __getitem__ __contains__ __eq__ __hash__",
            "int": (
                "bit_length to_bytes from_bytes conjugate as_integer_ratio __add__ __sub__ __mul__ __neg__ __eq__ "
                "__lt__ __and__ __bool__ __floordiv__ __mod__ __lshift__ __hash__ __index__"
            ),
            "float": (
                "is_integer hex fromhex as_integer_ratio __add__ __mul__ __neg__ __eq__ __lt__ __truediv__ __int__"
            ),
            "bytes": "hex fromhex decode find join split upper __len__ __add__ __mul__ __getitem__ __contains__",
            "bytearray": "append extend pop insert decode __len__ __iadd__ __imul__ __setitem__ __getitem__ __add__",
            "range": "index count __len__ __getitem__ __contains__ __iter__",
            "complex": "conjugate __add__ __mul__ __neg__",
            "object": "__eq__ __hash__ __getattribute__ __setattr__",
        }
        lines = ["r = []", "class L(list): pass", "class D(dict): pass", "class N(int): pass", "class T(str): pass"]
        for _ in range(5):
            kind = r.choice(list(names))
            name = r.choice(names[kind].split())
            own = {
                "str": TEXTS + ["T('t')"], "list": LISTS + ["L([1, 2])"], "dict": DICTS + ["D(a=1)"], "set": SETS[:4],
                "frozenset": SETS[4:], "tuple": TUPLES, "int": NUMBERS[:15] + ["N(5)"], "float": NUMBERS[15:20],
                "bytes": BYTES[:3], "bytearray": BYTES[3:], "range": ["range(5)", "range(9, 0, -2)"],
                "complex": ["1j", "(2-3j)"], "object": ["5"],
            }[kind]
            receiver = r.choice([*own, *own, self.value(), "L()", "N(5)"])
            args = ", ".join(
                r.choice([r.choice(own), self.value(), self.of(SMALL)]) for _ in range(r.choice([0, 1, 1, 1, 2, 3]))
            )
            if name == "__lshift__":
                # Of a number that fills the memory CPython says only when it is to be shown that it is too long.
                args = self.of(SMALL)
            call = r.choice(
                [f"{kind}.{name}({receiver}{', ' * bool(args)}{args})"] * 4
                + [
                    f"{kind}.{name}({args})", f"({receiver}).{name}({args})",
                    f"list(map({kind}.{name}, [{receiver}, {self.value()}]))",
                    f"functools.partial({kind}.{name}, {receiver})({args})",
                ]
            )
            lines += [
                "try:", f"    r.append({call})", "except Exception as e:", "    r.append((type(e).__name__, str(e)))",
            ]
        return lines + [f"{r.choice(NAMES)} = [show(x) for x in r] if '<' not in repr(r) else len(r)"]

    def copied(self):
        """Iterators and containers that are copied on the way."""
        r = self.r
        start = r.choice([
            f"iter({self.value()})", f"reversed({self.of(LISTS, TUPLES, TEXTS)})", f"enumerate({self.value()})",
            f"zip({self.value()}, {self.value()})", f"map(str, {self.value()})", f"filter(None, {self.value()})",
            "iter({1: 2, 3: 4}.items())", "iter(range(3, 9))", "iter([1, [2], [3]])", "reversed(range(4))",
            "iter('日本語')", "reversed({1: 2, 3: 4})", "[[1, 2], [3]]", "{'a': [1], 'b': {2}}", "([1], (2,))",
            "collections.deque([[1], 2])", "collections.OrderedDict(a=[1])", "collections.Counter('aab')",
            "collections.defaultdict(list, a=[1])", "(x for x in 'abc')", "date(2024, 1, 2)", "timedelta(1)",
            "range(3)", "slice(1, 2)", "len", "{1: 2}.keys()", "ValueError(1, [2])", "bytearray(b'ab')",
            "iter(bytearray(b'ab'))",
        ])
        lines = ["r = []", "try:", f"    i = {start}", "except Exception as e:", "    i, r = [[1]], [str(e)]"]
        for _ in range(4):
            use = r.choice([
                "i = copy.copy(i)", "i = copy.deepcopy(i)", "r.append(next(i))", "j = copy.copy(i); r.append(list(j))",
                "j = copy.deepcopy(i); r.append(list(j))",
                # What type a copy of an iterator at its end has shows how CPython makes it, no more.
                "r.append(operator.length_hint(i, 1) and type(copy.copy(i)).__name__)", "r.append(list(i)[:4])",
                "j = copy.copy(i); r.append(j == i)", "j = copy.deepcopy(i); r.append((j == i, j is i))",
                "j = copy.deepcopy([i, i]); r.append(j[0] is j[1])", "r.append(copy.copy(i))",
                "r.append(operator.length_hint(i))",
            ])
            lines += (
                ["try:"] + ["    " + line for line in use.split("; ")]
                + ["except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
            )
        return lines + [f"{r.choice(NAMES)} = [show(x) for x in r] if '<' not in repr(r) else len(r)"]

    def fields(self):
        """Texts with several fields, of all ways of formatting."""
        r = self.r
        spec = lambda: r.choice(["", "", f":{r.choice(SPECS)}", "!r", "!s:>6", "!a", ":{1}", ":{w}", ":>{w}.{p}"])
        field = lambda: (
            "{"
            + r.choice([
                "", "", "0", "1", "a", "0[0]", "1[k]", "0.real", "a.imag", "2", "0[-1]", "a[b]", "0.__class__", "-1",
                "0]", "a.", " ",
            ])
            + spec() + "}"
        )
        text = "".join(
            r.choice([field(), field(), "x", "{{", "}}", "é", "%", "{", "日"]) if r.random() < 0.9 else "}"
            for _ in range(r.choice([1, 2, 3, 4]))
        )
        args = r.choice([
            f"{self.value()}", f"{self.value()}, {self.value()}", "", f"*{self.value()}",
            f"{self.value()}, a={self.value()}, w=5, p=2", f"a={self.value()}, w='^7'",
        ])
        percents = "".join(
            r.choice([*PERCENTS, "%(a)r", "%-*d|", "%.*f", "%5.1f%%", "x", "é", "%+.2e", "%#x"])
            for _ in range(r.choice([1, 2, 3]))
        )
        return r.choice([
            f"{text!r}.format({args})", f"{text!r}.format({args})", f"{text!r}.format_map({self.of(DICTS)})",
            f"{percents!r} % {self.of(TUPLES, DICTS)}", f"{percents!r} % ({self.value()}, {self.value()})",
            f"{percents!r} % {{'a': {self.value()}, 'b': 1}}",
            f"b{ascii(percents)} % ({self.value()}, {self.value()})" if percents.isascii() else f"{percents!r} % ()",
            f"string.Template({r.choice(['$a', '${a}', '$', '$$a', '${', '$1', '$é', '${a} $b'])!r})"
            f".substitute(a={self.value()})",
        ])

    def mixed(self):
        """One place in a program that meets values of several kinds one after the other."""
        r = self.r
        # Whether equal constants of a function are one object is the compiler's business,
        # so no two texts are compared by `is`.
        use = r.choice([
            f"x = o[{self.of(SMALL)}]", f"x = o[{self.slice()}]", "x = o[k]", f"o[k] = {self.value()}; x = o",
            "o[k] += 1; x = o", "x, y = o; x = y, x", "x, y, *z = o; x = x, z", "x = [y for y in o]", "x = o == k",
            "x = o < k", "x = k in o", "x = o is o", "x = not o", "x = o and k or 5", "x = o + o", "x = o * 2",
            "x = -o", "o += k; x = o", "o -= k; x = o", "x = f'{o}{k!r}'", "x = '%s-%s' % (o, k)", "x = len(o)",
            "x = o.n", "o.n = k; x = o.n", "x = o.get(k, 7)", "o.append(k); x = o",
            "o.add(k); x = sorted(map(repr, o))", "x = o.pop()", "x = o.count(k)", "x = o.upper()",
            "x = o.strip().lower()", "x = o.replace(k, 'q')", "x = o.split(k)", "x = o.join(['a', 'b'])",
            "x = o.startswith(k)", "x = isinstance(o, (int, list)), isinstance(k, str)", "x = str(o), int(o)",
            "x = float(o)", "x = max(o, k)", "x = sum(o)", "x = list(zip(o, o))", "x = dict(enumerate(o))",
            "x = {o: k}[o]", "x = d[o]", "d[o] = k; x = d.get(o), len(d)", "x = d.setdefault(o, []); x.append(k)",
            "x = s.add(o), len(s), o in s", "x = abs(o), bool(o)", "x = o // 7, o % 7", "x = o >> 1, o & 255, o ^ 3",
            "x = o ** 2", "x = 0 <= o < 10", "x = getattr(o, 'real', k)", "x = g(o)", "x = g(o, k)", "x = g(*[o, k])",
            "x = g(y=o)", "x = h(o, k)", "x = h(*o)", "x = (o, k)[::-1]", "x = [*o, k]", "x = next(iter(o))",
            "x = o.real if o else k", "x = yes(o)", "x = o(k)", "del o[k]; x = o",
        ])
        values = ", ".join(self.of(*POOLS) for _ in range(r.choice([3, 4, 6])))
        keys = ", ".join(self.of(SMALL, TEXTS, NUMBERS) for _ in range(3))
        return (
            [
                "r, d, s = [], {1: 2, 'a': 3, (1, 2): 4}, {1}", "def g(x, y=3): return y, x", "def h(*x): return x",
                "def yes(x):", "    if x: return x", "    return 'no'", f"for k in [{keys}]:",
                f"    for o in [{values}]:", "        try:",
            ]
            + ["            " + line for line in use.split("; ")]
            + [
                "            r.append(x)", "        except Exception as e:",
                "            r.append((type(e).__name__, str(e)))", f"{r.choice(NAMES)} = r",
            ]
        )

    def changing(self):
        """Classes that change while one place of a program reads, sets and calls what they have."""
        r = self.r
        value = lambda: self.of(*POOLS[:5])
        start = [
            r.choice([
                "def m(self, x=0): return 'm', x", "m = 5", "m = property(lambda self: 'p')",
                "m = staticmethod(lambda *x: ('s', x))", "m = classmethod(lambda c, x=1: (c.__name__, x))", "n = 4",
                "pass", "def __getattr__(self, name): return 'ga ' + name", "def __init__(self, *x): self.n = x",
                "def __eq__(self, other): return other",
                "def __setattr__(self, k, v): object.__setattr__(self, k, (v, 1))",
            ])
            for _ in range(r.choice([1, 2]))
        ]
        change = lambda: r.choice([
            "K.m = lambda self, *x: ('new', x)", f"K.m = {value()}", "del K.m", "o.m = lambda *x: ('own', x)",
            f"o.m = {value()}", "del o.m", "B.m = lambda self: 'base'", "K.m = property(lambda self: 'late')",
            f"o.n = {value()}", "del o.n", f"K.n = {value()}", "o.__dict__['m'] = 9", "o = C()", "o = K()",
            "K.__getattr__ = lambda self, name: name", "vars(o).clear()", "C.m = 7", "K.__eq__ = lambda self, x: 'eq'",
            "K.__len__ = lambda self: 3", "K.__getitem__ = lambda self, k: k", "K.__call__ = lambda self, *x: x",
            "K.__bool__ = lambda self: False", "o, p = p, o",
        ])
        use = r.choice([
            "o.m", "o.m()", "o.m(i)", "o.m(i, i)", "o.n", "o.m(x=i)", "o.m, o.n", "p.m()", "o == i", "len(o)", "o[i]",
            "o(i)", "bool(o)", "getattr(o, 'm')", "hasattr(o, 'm')", "K.m", "o.m if o else 0",
            "[q.m() for q in (o, p)]", "str(o.n)", "sorted(vars(o))", "K().n", "isinstance(o, C)",
        ])
        lines = (
            ["class B: pass", "class K(B):"] + indented(start)
            + [
                "class C(B):", "    def m(self, *x): return 'C', x", "r = []", "try:", "    o, p = K(), C()",
                "    for i in range(6):", "        try:", f"            x = {use}",
                "            r.append('method' if callable(x) else x)", "        except Exception as e:",
                "            r.append((type(e).__name__, str(e)))", "        try:",
            ]
        )
        for at in range(4):
            lines += [f"            if i == {at}: {change()}"]
        return lines + [
            "        except Exception as e:", "            r.append((type(e).__name__, str(e)))",
            "except Exception as e:", "    r = repr(e)", f"{r.choice(NAMES)} = r if '<' not in repr(r) else len(r)",
        ]

    def calls(self):
        """Functions of all kinds, called in all ways from one place after the other."""
        r = self.r
        params = r.choice([
            "", "x", "x, y", "x, y=2", "x=1, y=2, z=3", "*x", "x, *y", "**x", "x, **y", "*, x", "*, x=1", "x, /",
            "x, /, y=1, *z, k=4, **w", "x=[]", "a1, a2, a3, a4, a5, a6=6", "x, *, y=3",
        ])
        body = r.choice([
            "return sorted(locals().items(), key=repr)", "return x", "x.append(1); return x", "return (lambda: x)()",
            "yield x", "global gg; gg = 1; return gg", "return [x for _ in range(2)]", "try: return x",
            "x += 1; return x", "return 1", "return y, x", "def q(): nonlocal x; x = 5; return x",
        ])
        body = (
            body.split("; ") if not body.startswith(("try", "def"))
            else {
                "try": ["try: return x", "finally: x = 0"],
                "def": ["def q():", "    nonlocal x", "    x = 5", "    return x", "return q(), x"],
            }[body[:3]]
        )
        calls = [
            r.choice([
                "f()", "f(1)", "f(1, 2)", "f(1, 2, 3)", "f(x=1)", "f(1, x=2)", "f(1, y=2)", "f(y=2, x=1)", "f(*(1, 2))",
                "f(*[])", "f(**{'x': 3})", "f(1, *[2], **{'z': 3})", "f(k=1)", "f(*'ab')", "f(**{'x': 1}, y=2)",
                "f(1, 2, 3, 4, 5, 6, 7)", "[f(i) for i in (1, 2)]", "next(f(1))", "list(map(f, [1, 2]))",
                "f.__code__.co_argcount", "functools.partial(f, 1)()", "f(*f.__defaults__ or ())",
                "sorted([2, 1], key=f)", "functools.reduce(f, [1, 2, 3])",
            ])
            for _ in range(4)
        ]
        lines = [f"def f({params}):"] + indented(body) + ["r = []"]
        for call in calls:
            lines += [
                "try:", f"    r.append({call})", "except Exception as e:", "    r.append((type(e).__name__, str(e)))",
            ]
        return lines + [f"{r.choice(NAMES)} = r if '<' not in repr(r) else len(r)"]

    def leaving(self):
        """Ways out of loops, handlers and `finally`, one in another."""
        r = self.r
        out = lambda: r.choice([
            "break", "continue", f"return {self.value()}", "pass",
            f"raise {r.choice(['KeyError(i)', 'ValueError', 'StopIteration(5)'])}", "r.append(i)", "1 // (i % 2)",
            "raise", "del r[5]", "e", "i += 1", "nope", "yield i" if r.random() < 0.2 else "r.append(-i)",
        ])
        lines = [
            "def f():", "    r = []", f"    for i in range({r.choice(['3', '5'])}):", "        try:",
            f"            {out()}", "            try:", f"                {out()}",
        ]
        lines += (
            [f"            except {r.choice(ERRORS)} as e:", f"                {out()}"] if r.random() < 0.7 else []
        )
        lines += ["            finally:", f"                {out()}"] + [
            f"        except {r.choice(ERRORS)} as e:",
            "            r.append((repr(e), repr(e.__context__), repr(e.__cause__)))", f"            {out()}",
        ]
        lines += r.choice([[], ["        else:", f"            {out()}"]])
        lines += r.choice([[], ["        finally:", f"            r.append('f'); {out()}"]])
        return (
            lines + r.choice([[], ["    else:", "        r.append('else')"]])
            + [
                "    return r", "x = f()",
                f"{r.choice(NAMES)} = list(itertools.islice(x, 9)) if hasattr(x, 'send') else x",
            ]
        )

    def inheriting(self):
        """A few classes below each other that hand methods, properties and descriptors on."""
        r = self.r
        v = lambda: self.of(*POOLS[:5])
        parts = lambda: "\n".join(
            r.sample(
                [
                    "def m(self, *x): return type(self).__name__, x", "def m(self): return super().m()",
                    "def m(self): return 'm'", f"n = {v()}", "n = property(lambda self: self.k, None)",
                    "@property\ndef n(self): return self.__dict__.get('k', 0)\n"
                    "@n.setter\ndef n(self, v): self.k = v, v",
                    "@classmethod\ndef c(cls, x=1): return cls.__name__, x", "@staticmethod\ndef s(x=2): return x",
                    f"def __init__(self, k={v()}): self.k = k", "def __init__(self, *x): super().__init__(*x)",
                    f"def __getattr__(self, name): return {v()}",
                    "def __getattribute__(self, name): return super().__getattribute__(name)",
                    "def __setattr__(self, name, v): object.__setattr__(self, name, [v])",
                    f"def __get__(self, o, t=None): return o is None, {v()}", "__slots__ = ('k', 'j')",
                    "def __init_subclass__(cls, **k): cls.made = sorted(k)",
                    "def __set_name__(self, o, name): self.k = name", f"def __eq__(self, o): return {v()}",
                    "def __class_getitem__(cls, k): return cls.__name__, k",
                    "def __new__(cls, *x): return super().__new__(cls)", f"def __len__(self): return {self.of(SMALL)}",
                    "def __delattr__(self, name): self.gone = name",
                    "def __contains__(self, x): return super().__contains__(x)",
                    f"def __iter__(self): yield from {v()}", "__hash__ = None",
                ],
                r.choice([1, 2, 2, 3]),
            )
        ).split("\n")
        base = r.choice(["", "", "(list)", "(dict)", "(int)", "(str)", "(Exception)", "(tuple)"])
        lines = (
            ["r = []", "try:", f"    class A{base}:"] + indented(indented(parts()))
            + [f"    class B({r.choice(['A', 'A', 'A, k=1'])}):"] + indented(indented(parts()))
        )
        lines += [
            f"    class C({r.choice(['A', 'B', 'B, A', 'A, B'])}):", f"        d = {r.choice(['A()', '1', 'B'])}",
        ] + indented(indented(parts()))
        lines += [f"    o = {r.choice('ABC')}(" + r.choice(["", "", "1", "[1, 2]", "'ab'"]) + ")"]
        for _ in range(4):
            use = r.choice([
                "o.m()", "o.n", "o.k", "o.c()", "C.c(3)", "o.s()", "o.d", "C.d", "o.zz", "len(o)", "list(o)", "o == 1",
                "o.__dict__", "C.made", "super(B, o).m()", "A.m(o)", "isinstance(o, A)",
                "[c.__name__ for c in C.__mro__]", "hasattr(o, 'n')", "getattr(o, 'm', 0) and 1", "str(o)[:1]",
                "1 in o", "hash(o) == hash(o)", "sorted(vars(o))", "B.n", "bool(o)", "list(vars(C))",
                "[k for k, v in vars(A).items() if callable(v)]", "C.__base__.__name__",
                "(C.__qualname__, A.__module__)", "[k for k in dir(o) if k[1] != '_']", "hasattr(o, '__weakref__')",
            ])
            change = r.choice([
                "", "", f"o.n = {v()}; ", f"o.k = {v()}; ", "del o.k; ", "o.m = len; ", "B.m = lambda *x: len(x); ",
                "del A.m; ", "C.n = 5; ", "del o.n; ",
            ])
            lines += [
                "    try:", f"        {change}r.append({use})", "    except Exception as e:",
                "        r.append((type(e).__name__, str(e)))",
            ]
        return lines + [
            "except Exception as e:", "    r.append((type(e).__name__, str(e)))",
            f"{r.choice(NAMES)} = r if '<' not in repr(r) else len(r)",
        ]

    def groups(self):
        """Exception groups and `except*`, notes and causes."""
        r = self.r
        leaf = lambda: r.choice(["ValueError(1)", "KeyError('k')", "TypeError()", "OSError(2, 'x')", "IndexError(3)"])
        inner = lambda depth: leaf() if depth > 1 or r.random() < 0.7 else group(depth + 1)
        group = lambda depth: (
            f"ExceptionGroup({self.r.choice(TEXTS[:6])}, "
            f"[{', '.join(inner(depth) for _ in range(r.choice([1, 2, 3])))}])"
        )
        lines = ["r = []", "try:", "    try:", f"        raise {r.choice([group(0), group(0), leaf()])}"]
        for _ in range(r.choice([1, 2])):
            caught = r.choice([
                "ValueError", "KeyError", "(TypeError, IndexError)", "LookupError", "Exception", "OSError",
            ])
            lines += [
                f"    except* {caught} as e:",
                "        "
                + r.choice([
                    "r.append(repr(e))", "raise", "raise ValueError(5)", "raise KeyError from e",
                    "r.append([repr(x) for x in e.exceptions])", "e.add_note(1)", "e.add_note('n')",
                ]),
            ]
        lines += r.choice([[], ["    else:", "        r.append('else')"]])
        lines += r.choice([[], ["    finally:", "        r.append('finally')"]])
        return lines + [
            "except BaseException as e:",
            "    r.append((repr(e), repr(e.__cause__), repr(e.__context__), getattr(e, '__notes__', 0)))",
            "    r.append("
            + r.choice([
                "e.args", "e.subgroup(ValueError)", "repr(e.split(KeyError)) if hasattr(e, 'split') else 0", "str(e)",
                "e.derive([ValueError()]) if hasattr(e, 'derive') else 1",
            ])
            + ")",
            f"{r.choice(NAMES)} = repr(r)",
        ]

    def slicing(self):
        """A sequence whose parts are taken, assigned and deleted."""
        r = self.r
        o = r.choice([
            "list(range(7))", "bytearray(b'abcdefg')", "'a\u00e9\u65e5\U0001f600xyz'", "tuple('abcdef')",
            "range(2, 30, 3)", "b'abcdefg'", "[*'abcdef']", "range(9, -9, -4)",
            "'\u0928\u092e\u0938\u094d\u0924\u0947'", "collections.deque([1, 2, 3, 4])",
        ])
        bound = lambda: r.choice([
            "", "", "0", "1", "3", "-1", "-4", "9", "-9", "None", "2**70", "-2**70", "True", "a", "'1'", "1.0",
        ])
        cut = lambda: (
            f"{bound()}:{bound()}"
            + r.choice(["", "", f":{r.choice(['1', '2', '-1', '-2', '0', '3', '', 'None', '2**65', '-2**65'])}"])
        )
        lines = [f"o = {o}", "r = []"]
        for _ in range(5):
            use = r.choice([
                f"r.append(o[{cut()}])", f"r.append(o[{cut()}][{cut()}])",
                f"o[{cut()}] = "
                + r.choice(["[7, 8]", "b'xy'", "'pq'", "()", "range(3)", "o", "5", "None", "iter([1])", "o[::-1]"]),
                f"del o[{cut()}]",
                f"r.append(slice({self.of(SMALL)}, {self.of(SMALL)}, {self.of(SMALL)})"
                f".indices({r.choice(['5', '0', '2**66', '-1', 'a'])}))",
                "o += o[1:3]", f"o *= {r.choice(['2', '0', '-1'])}",
                f"r.append(o.index(o[{r.choice(['1', '-2'])}], {self.of(SMALL)}, {self.of(SMALL)}))",
                f"r.append(o[{bound() or 0}])", f"o[{bound() or 0}] = 65", "r.append(list(reversed(o)))",
                f"r.append(o.count(o[{r.choice(['0', '2'])}]))", "r.append(o == o[:])", f"o.insert({bound() or 0}, 66)",
                f"r.append(o.pop({r.choice(['', '0', '-2', '50'])}))",
            ])
            lines += ["try:", f"    {use}", "except Exception as e:", "    r.append((type(e).__name__, str(e)))"]
        return lines + ["r.append(o)", f"{r.choice(NAMES)} = repr(r)"]

    def big(self):
        """Arithmetic on numbers of many digits."""
        r = self.r
        number = lambda: r.choice([
            "3**200", "-7**77", "2**64", "2**63", "-2**63", "2**128 - 1", "10**40 + 3", "-10**25", "1", "-1",
            "12345678901234567890", "2**31", "255", "0", "10**18", "1e30", "2.5", "True", "3**41",
        ])
        two = lambda op: f"({number()}) {op} ({number()})"
        small = r.choice(["0", "1", "3", "63", "64", "65", "100", "-1"])
        return r.choice([
            two(r.choice(["+", "-", "*", "//", "%", "/", "&", "|", "^", "==", "<", ">=", "!="])),
            f"({number()}) << {small}", f"({number()}) >> {small}", f"divmod({number()}, {number()})",
            f"pow({number()}, {small}, {number()})", f"math.gcd({number()}, {number()})", f"math.isqrt({number()})",
            f"({number()}).bit_length()",
            f"f'{{({number()}):{r.choice(['x', ',', '_b', '>60', 'e', 'n', '+d', '.3f', 'o', '#X'])}}}'",
            f"int(str({number()}))", f"hash({number()}) % 1000", f"float({number()})",
            f"round({number()}, {r.choice(['-1', '-20', '3', '-60'])})",
            f"({number()}).to_bytes(40, 'little', signed=True)",
            f"int.from_bytes(({number()}).to_bytes(40, 'big', signed=True), 'big', signed=True)",
            f"{r.choice(['hex', 'bin', 'oct', 'repr', 'abs', 'str', 'complex', 'bool'])}({number()})",
            f"'%{r.choice(['d', 'x', 'o', '50d', '+e', '.3g', 'i', 'c'])}' % ({number()},)",
            f"~({number()}), -({number()})", f"({number()}).as_integer_ratio()", f"math.log({number()})",
            f"sum([{number()}, {number()}, {number()}])", f"int({number()}), int(-{number()})",
            f"({number()}) ** {r.choice(['2', '3', '0', '-1', '0.5', '7'])}",
            f"sorted([{number()}, {number()}, {number()}])", f"{{{number()}: 1, {number()}: 2}}",
            f"math.comb({r.choice(['60', '5', '200'])}, {small})",
        ])
