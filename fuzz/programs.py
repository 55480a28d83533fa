"""Random programs of several statements for `differential.py`: attributes, containers, generators, exceptions,
formatting, classes, slicing, texts in many scripts, big numbers.

A program is the body of a function without parameters; what it returns is shown. Loops are bounded,
so every program ends.
"""

from pieces import (
    BINARY,
    BYTES,
    CODECS,
    DUNDERS,
    ERRORS,
    HANDLERS,
    NAMES,
    NUMBERS,
    PERCENTS,
    POOLS,
    SMALL,
    SPECS,
    TEXTS,
)
from subjects import Subjects, indented


class Programs(Subjects):
    """Makes programs with the numbers of one generator."""

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
            template = r.choice(PERCENTS)
            one, two = "(" + self.value() + ",)", self.value()
            values = r.choice([one, two, "(" + self.value() + ", " + self.value() + ")"])
            return f"{template!r} % {values}"
        if pick == 11:
            return f"[{sub()} for x in {self.value()} if x]"
        if pick == 12:
            return f"{{{self.value()}: x for x in {self.value()}}}"
        if pick == 13:
            value, key = self.value(), r.choice(["str", "repr", "len", "None", "lambda x: x"])
            return f"sorted({value}, key={key}, reverse={r.choice(['True', 'False'])})"
        if pick == 14:
            name = r.choice([
                "len", "str", "repr", "list", "tuple", "set", "dict", "bool", "int", "float", "abs", "sum", "max",
                "min", "iter", "any", "all", "ascii", "bytes", "reversed", "enumerate", "round", "complex", "frozenset",
                "ord", "chr", "hex", "callable", "next",
            ])
            if name == "bytes":
                return f"bytes({self.of(TEXTS)}, {r.choice(CODECS)!r})"
            return f"{name}({self.value()})"
        if pick == 15:
            return f"{self.of(TEXTS)}.encode({r.choice(CODECS)!r}, {r.choice(HANDLERS)!r})"
        if pick == 16:
            raw, encoded = self.of(BYTES), f"{self.of(TEXTS)}.encode({r.choice(CODECS)!r}, 'ignore')"
            return f"{r.choice([raw, encoded])}.decode({r.choice(CODECS)!r}, {r.choice(HANDLERS[:6])!r})"
        if pick == 17:
            method = r.choice([
                "upper", "lower", "title", "casefold", "swapcase", "capitalize", "isalpha", "isprintable",
                "isidentifier", "split", "strip", "splitlines", "isnumeric", "istitle", "expandtabs", "isupper",
            ])
            return f"{self.of(TEXTS)}.{method}()"
        if pick == 18:
            value = self.value()
            name = r.choice(["real", "x", "keys", "append", "__class__", "p", "args", "__len__", "n"])
            return f"getattr({value}, {name!r}, {self.value()})"
        if pick == 19:
            return f"({sub()} if {self.value()} else {sub()})"
        if pick == 20:
            start = f"(lambda x, *y, z={self.of(SMALL)}: (x, y, z))"
            return f"{start}({', '.join(self.value() for _ in range(r.choice([0, 1, 2, 3])))})"
        if pick == 21:
            return f"[*{self.value()}, {self.value()}]"
        if pick == 22:
            value, kind = self.value(), r.choice(["int", "(str, list)", "dict", "object", "int | str", "type(a)"])
            return f"isinstance({value}, {kind})"
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
            call = r.choice([
                "append({v})", "extend({v})", "pop()", "pop({s})", "insert({s}, {v})", "update({v})", "add({v})",
                "discard({v})", "clear()", "sort()", "reverse()", "setdefault({v}, {s})", "remove({v})", "popitem()",
                "index({v})", "count({v})", "copy()", "get({v})", "join({v})", "replace({v}, 'q')", "startswith({v})",
                "find({v})", "partition({v})", "union({v})", "zfill({s})", "center({s})", "items()",
            ])
            return [f"c = {name}.{call.format(v=self.value(), s=self.of(SMALL))}"]
        if pick == 9:
            return (
                [f"for {r.choice(['x', 'x, y', 'a', 'x, *y'])} in itertools.islice({self.value()}, 5):"]
                + indented(self.block(depth + 1)) + r.choice([[], ["else:"] + indented(self.block(depth + 1))])
            )
        if pick == 10:
            lines = ["try:"] + indented(self.block(depth + 1))
            for _ in range(r.choice([1, 1, 2])):
                lines += [f"except {r.choice(ERRORS)} as e:"] + indented([
                    r.choice([
                        "b = type(e).__name__, str(e)", "c = e.args", "b = repr(e)", "raise",
                        "raise RuntimeError('again') from e", "a = e.__context__",
                    ])
                ])
            return (
                lines + r.choice([[], ["else:"] + indented(self.block(depth + 1))])
                + r.choice([[], ["finally:"] + indented(self.block(depth + 1))])
            )
        if pick == 11:
            return (
                [f"if {self.expression()}:"] + indented(self.block(depth + 1))
                + r.choice([[], ["else:"] + indented(self.block(depth + 1))])
            )
        if pick == 12:
            return [f"raise {r.choice(['ValueError', 'KeyError', 'TypeError'])}({self.value()})"]
        if pick == 13:
            targets = r.choice(["a, b", "a, *b", "*a, b", "(a, b), c", "a, b, c", "a[0]", "[a, b]"])
            return [f"{targets} = {self.value()}"]
        if pick == 14:
            body = [
                r.choice([
                    f"yield {self.value()}", f"c = yield {self.value()}", f"yield from {self.value()}",
                    f"return {self.value()}", f"b = {self.expression()}",
                ])
                for _ in range(r.choice([1, 2, 3]))
            ]
            if r.random() < 0.3:
                body = (
                    ["try:"] + indented(body)
                    + [
                        f"except {r.choice(ERRORS)} as e:", "    yield repr(e)", "finally:",
                        f"    yield {self.value()}",
                    ]
                )
            use = r.choice([
                "list(g)", "next(g), next(g)", "g.send(None)", "next(g), g.send(5)", "next(g), g.throw(KeyError('t'))",
                "g.close()", "sum(g)", "dict(g)", "sorted(g)", "[*itertools.islice(g, 3)]",
                "g.gi_frame is None, g.gi_running",
            ])
            return ["def made(a=a, b=b, c=c):"] + indented(body + ["yield 0"]) + ["g = made()", f"{name} = {use}"]
        if pick == 15:
            body = [
                r.choice(DUNDERS).format(value=self.of(*POOLS[:5]), small=self.of(SMALL), text=self.of(TEXTS))
                for _ in range(r.choice([1, 2, 2, 3]))
            ]
            base = r.choice(["", "", "(list)", "(dict)", "(int)", "(str)", "(tuple)", "(Exception)", "(set)"])
            lines = [f"class K{base}:"] + ["    " + line for line in body]
            text = "\n".join(lines).replace("\n        ", "\n    ").split("\n")
            # A class derived from a container can be indexed in CPython,
            # which gives an alias for annotations: not here.
            use = r.choice([
                "K()", "K({0})".format(self.of(*POOLS[1:4])), "K" if base in ("", "(int)", "(str)") else "K()",
            ])
            return text + [
                "a = " + use,
                r.choice([
                    f"b = {self.expression()}", "b = len(a)", "b = list(a)", "b = a + 1", "b = a[0]", "b = str(a)[:9]",
                    "b = bool(a)", "b = a.p", "b = a.q", "b = a.k()", "b = a.x", "b = 2 * a", "b = {a: 1}",
                    "b = a == 1, a != 1", "b = f'{a:>5}'", "b = a.zz", "a.n = 3; b = a.n", "b = int(a), float(a)",
                    "b = 3 in a", "b = sorted([a, a])", "a += 1; b = a.n", "b = round(a)",
                    "b = 0 if isinstance(a, type) else vars(a)", "del a[0]", "a[1] = 2", "b = [x for x in a][:4]",
                    "b = a()", "b = a < 1", "b = hash(a) == hash(a)", "b = isinstance(a, K), K.__mro__[1].__name__",
                ]),
                "a = type(a).__name__",
            ]
        if pick == 16:
            return (
                [f"def f({r.choice(['x', 'x, y=1', '*x', 'x, /, y', '*, x=2', 'x=1, *y, **z', ''])}):"]
                + indented([f"return {r.choice(['locals()', '1', 'a', 'x'])}"])
                + [
                    f"c = f({r.choice(['', '1', '1, 2', 'x=1', '*a', '**b', '1, y=2', 'y=3, x=4'])})",
                    "c = list(c.items()) if isinstance(c, dict) else c",
                ]
            )
        if pick == 17:
            return [f"with contextlib.suppress({r.choice(ERRORS[:6])}):"] + indented(self.block(depth + 1))
        if pick == 18:
            return [f"assert {self.expression()}, {self.value()}"]
        if pick == 19:
            text = self.value() + " or " + self.value()
            return [f"c = eval({text!r}, {{'a': a, 'b': b, 'c': c, 'itertools': itertools}})"]
        if pick == 20:
            # Each loop within another counts for itself.
            n = f"n{depth}"
            lines = [f"{n} = 0", f"while {self.expression()}:", f"    {n} += 1", f"    if {n} > 3: break"]
            return lines + indented(self.block(depth + 1))
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
