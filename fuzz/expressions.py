"""Random expressions for `differential.py`: a small grammar over the builtin types and a few modules."""

import random

INTS = [
    "0", "1", "-1", "2", "3", "7", "-5", "10", "255", "256", "-128", "1000", "2**31", "2**63", "-2**63", "2**63-1",
    "2**64", "10**20", "-10**30", "True", "False", "3**80", "-2**100", "2**100-1",
]
FLOATS = [
    "0.0", "-0.0", "1.0", "1.5", "-2.5", "0.1", "1e16", "1e22", "1e-7", "123456.789", "1e300", "5e-324", "float('inf')",
    "float('-inf')", "float('nan')", "3.0", "1/3", "2.675",
]
COMPLEX = ["1j", "(1+2j)", "(-0-1j)", "complex(0, float('inf'))", "(2.5-3j)"]
STRS = [
    "''", "'a'", "'abc'", "'Hello, World'", "'  pad '", "'a,b,,c'", "'éß'", "'日本語'", "'ǅ'", "'İI'", "'123'", "'-12'",
    "'1.5e3'", "'٣'", "'²'", "'a\\nb\\r\\nc'", "'\\t\\x00\\x7f'", "'{}'", "'%s'", "'%d'", "'abcabc'", "'ABC'", "'😀x'",
    "'ſ'", "'x'*5", "'0x1f'", "'1_000'", "'nan'", "'ﬁ'", "'aXbXc'", "'_id1'", "'title case'", "'\\u2028'", "'हिन्दी'",
    "'ΑΣ ΌΣΟΣ'", "'ไทยที่'", "'שלום'", "'e\\u0301'", "'\\ud83d'", "'ᾳᾼ'", "'ქართ'", "'१२'", "'Ⅷ½'", "'\\udc80a'",
]
BYTES = [
    "b''", "b'a'", "b'abc'", "b'a,b'", "b'\\xff\\x00'", "b'12'", "bytearray(b'xyz')", "b' a b '", "b'abcabc'",
    "bytearray()",
]
LISTS = [
    "[]", "[1]", "[1, 2, 3]", "[3, 1, 2]", "['a', 'b']", "[1, 'a']", "[[1], [2]]", "[None]", "[1.5, 2]", "[True, 0]",
    "list(range(6))", "[(1, 2), (0, 5)]",
]
TUPLES = ["()", "(1,)", "(1, 2)", "(3, 2, 1)", "('a',)", "(1, 'b')", "((1, 2), 3)", "(1.0, 2)"]
DICTS = ["{}", "{1: 2}", "{'a': 1, 'b': 2}", "{1: 'x', 2.5: 'y'}", "{'k': [1]}", "{None: 0}", "{(1, 2): 3}"]
SETS = ["set()", "{1}", "{1, 2, 3}", "frozenset({1, 2})", "frozenset()", "{5, 3}", "{(1,)}"]
OTHERS = [
    "None", "range(5)", "range(10, 0, -3)", "range(0)", "slice(1, 3)", "...", "NotImplemented", "int", "str", "len",
    "object", "slice(None, None, -1)", "range(3, 30, 4)",
]
TIMES = [
    "timedelta(1)", "timedelta(seconds=1.5)", "timedelta(days=-1, microseconds=5)", "date(2024, 2, 29)",
    "datetime.datetime(2024, 1, 1, 12, 30)", "datetime.time(1, 2, 3)", "datetime.timezone.utc", "date(1, 1, 1)",
    "datetime.datetime(2023, 12, 31, 23, 59, 59, 999999, tzinfo=datetime.timezone.utc)", "timedelta(0)",
]
KINDS = [INTS, FLOATS, COMPLEX, STRS, BYTES, LISTS, TUPLES, DICTS, SETS, OTHERS]
WEIGHTS = [6, 5, 1, 7, 3, 4, 3, 3, 3, 2]

BINARY = [
    "+", "-", "*", "/", "//", "%", "**", "@", "&", "|", "^", "<<", ">>", "==", "!=", "<", "<=", ">", ">=", "in",
    "not in", "and", "or",
]
UNARY = ["-", "+", "~", "not "]
BUILTINS = {
    "abs": 1, "all": 1, "any": 1, "ascii": 1, "bin": 1, "bool": 1, "bytes": 1, "bytearray": 1, "callable": 1, "chr": 1,
    "complex": 2, "dict": 1, "divmod": 2, "enumerate": 2, "filter": 2, "float": 1, "format": 2, "frozenset": 1,
    "hex": 1, "int": 2, "isinstance": 2, "issubclass": 2, "iter": 1, "len": 1, "list": 1, "max": 2, "min": 2, "oct": 1,
    "ord": 1, "pow": 3, "range": 3, "repr": 1, "reversed": 1, "round": 2, "set": 1, "slice": 3, "sorted": 1, "str": 2,
    "sum": 2, "tuple": 1, "type": 1, "zip": 2, "map": 2, "getattr": 2, "hasattr": 2,
}
METHODS = {
    "str": (
        "capitalize casefold center count encode endswith expandtabs find format index isalnum isalpha isascii "
        "isdecimal isdigit isidentifier islower isnumeric isprintable isspace istitle isupper join ljust lower lstrip "
        "partition removeprefix removesuffix replace rfind rindex rjust rpartition rsplit rstrip split splitlines "
        "startswith strip swapcase title translate upper zfill"
    ).split(),
    "bytes": (
        "capitalize center count decode endswith expandtabs find hex index isalnum isalpha isdigit islower isspace "
        "istitle isupper join ljust lower lstrip partition removeprefix removesuffix replace rfind rindex rjust "
        "rpartition rsplit rstrip split splitlines startswith strip swapcase title upper zfill"
    ).split(),
    "list": "append clear copy count extend index insert pop remove reverse sort".split(),
    "tuple": "count index".split(),
    "dict": "clear copy get items keys pop popitem setdefault update values fromkeys".split(),
    "set": (
        "add clear copy difference discard intersection isdisjoint issubset issuperset pop remove "
        "symmetric_difference union update"
    ).split(),
    "int": "as_integer_ratio bit_count bit_length conjugate to_bytes".split(),
    "float": "as_integer_ratio conjugate hex is_integer".split(),
    "range": "count index".split(),
}
SPECS = [
    "", "d", "5", "<5", ">8", "^9", "05", "+", " ", ",", "_", "x", "#x", "b", "o", "c", "e", ".3e", "f", ".2f", "10.3f",
    "g", ".4g", "%", ".1%", "s", ".2s", "*^10", "=+8", "n", "G", "#o", "08.3f", ",.2f", "_x", "10,", "+.0f", "z.1f",
    "<<5", "#.3g", "X", "E", "010d", "abc", "5d5", ".", "1.2.3", ",_", "-", ">", "é^5",
]
PERCENTS = [
    "%d", "%5d", "%-5d|", "%05d", "%+d", "% d", "%x", "%#x", "%o", "%e", "%.2f", "%g", "%10.3g", "%s", "%r", "%a", "%c",
    "%5s", "%.2s", "%%", "%i", "%u", "%*d", "%.*f", "%(a)s", "%(a)d %(b)s", "%z", "%", "%d %d", "%#o", "%X", "%G",
    "%-8.3s|", "%b", "%l", "%ld", "%5%", "%c%c",
]
STRUCTS = [
    "b", "B", "h", "H", "i", "I", "q", "Q", "f", "d", "e", "?", "c", "3s", "5p", "x", "<hi", ">q", "!I", "=b", "@i",
    "2h", "0s", "n", "P", "z", "<n", "3", "hh", " b h", "bq", "<bq",
]
PATTERNS = [
    "a", "a*", "(a)(b)?", "[a-c]+", "\\\\d+", "\\\\w+", "(?P<n>b)", "^a", "c$", "a|b", "(?i)ABC", "x{2,3}", ".",
    "\\\\s*", "(?=b)", "(?<=a)b", "(a", "[", "*", "\\\\b", "a+?", "(?:ab)+", "[^,]*", ",", "()", "(?P<n>a)(?P=n)",
    "\\\\Z", "(?x) a b", "a{", "(?P<1>a)", "\\\\1", "[z-a]", "(?i:A)b",
]
JSONS = [
    repr(text)
    for text in (
        "[1, 2.5, null]", '{"a": [true]}', "[1,]", "{", "1e5", '"\\u00e9"', "nul", "[1 2]", "-", "01", "NaN", '{"a" 1}',
        "{a:1}", '{"a": 1,}', " [ ] ", '"a', "[1]]", '{"a": 1, "a": 2}', "-0", "1.", '"\\x"',
    )
]
STRFTIME = [
    "%Y-%m-%d", "%H:%M:%S.%f", "%a %b %d", "%j", "%U %W", "%y", "%p %I", "%A %B", "%%", "%c", "%x %X", "%z %Z",
    "%G-W%V-%u", "%e",
]

MATH_OF_ONE = (
    "sqrt floor ceil factorial log exp sin isqrt trunc fabs frexp modf gamma degrees log2 erf cbrt ulp"
).split()
MATH_OF_TWO = "gcd lcm pow fmod atan2 hypot copysign comb perm ldexp remainder isclose nextafter dist log".split()
DATES = ["2024-02-29", "2023-02-29", "20240101", "x", "2024-W05", "2024-W05-3"]
MOMENTS = [
    "2024-01-02T03:04:05", "2024-01-02 03:04", "2024-01-02T03:04:05.123+02:00", "z", "2024-01-02T25:00",
    "20240102T030405Z",
]


class Maker:
    """Makes expressions with the numbers of one generator."""

    def __init__(self, seed):
        self.r = random.Random(seed)

    def value(self, depth=0):
        if depth < 2 and self.r.random() < 0.12:
            return self.expression(depth + 1)
        kind = self.r.choices(KINDS, WEIGHTS)[0]
        return self.r.choice(kind)

    def of(self, *kinds):
        return self.r.choice(self.r.choice(kinds))

    def expression(self, depth=0):
        r = self.r
        pick = r.random()
        if pick < 0.24:
            op = r.choice(BINARY)
            a, b = self.value(depth), self.value(depth)
            if r.random() < 0.5:
                # Of one kind, where most of the meaning is.
                kind = r.choices(KINDS, WEIGHTS)[0]
                a, b = r.choice(kind), r.choice(kind)
            if op in ("**", "<<", "*"):
                b = self.of(["0", "1", "2", "-1", "3", "0.5", "'a'", "None", "1.5", "-3", "True", "1j", "[]"])
            return f"({a}) {op} ({b})"
        if pick < 0.28:
            return f"{r.choice(UNARY)}({self.value(depth)})"
        if pick < 0.36:
            box = self.of(STRS, LISTS, TUPLES, DICTS, BYTES, OTHERS, SETS)
            index = r.choice([
                self.of(INTS), self.value(depth),
                ":".join(r.choice(["", "1", "-1", "2", "-3", "10", "0", "None"]) for _ in range(r.choice([2, 3]))),
            ])
            return f"({box})[{index}]"
        if pick < 0.52:
            name = r.choice(list(METHODS))
            pool = {
                "str": STRS, "bytes": BYTES, "list": LISTS, "tuple": TUPLES, "dict": DICTS, "set": SETS, "int": INTS,
                "float": FLOATS, "range": ["range(5)", "range(10, 0, -3)", "range(0)"],
            }[name]
            args = ", ".join(
                r.choice([r.choice(pool), self.value(depth), r.choice(INTS[:10])])
                for _ in range(r.choice([0, 0, 1, 1, 1, 2, 2, 3]))
            )
            method = r.choice(METHODS[name])
            if method in ("center", "ljust", "rjust", "zfill", "expandtabs", "to_bytes"):
                args = ", ".join(
                    [r.choice(["0", "5", "-1", "'a'", "10", "None"])]
                    + [r.choice(["'*'", "b'-'", "'big'", "1", "''"])] * r.choice([0, 1])
                )
            box = r.choice(pool)
            if method in (
                "append", "clear", "extend", "insert", "remove", "reverse", "sort", "update", "add", "discard",
                "setdefault",
            ):
                return f"(lambda v: (v.{method}({args}), v))({box})"
            return f"({box}).{method}({args})"
        if pick < 0.68:
            name = r.choice(list(BUILTINS))
            count = r.choice([1, BUILTINS[name], BUILTINS[name]])
            args = [self.value(depth) for _ in range(count)]
            if name in ("range", "bytes", "bytearray") or name == "pow":
                args = [
                    r.choice(["0", "1", "5", "-2", "3", "'a'", "None", "1.5", "[1, 2]", "b'a'", "True"])
                    for _ in range(count)
                ]
            if name == "sorted" and r.random() < 0.3:
                args.append(r.choice(["reverse=True", "key=str", "key=len", "key=None", "reverse='x'"]))
            if name in ("map", "filter"):
                args[0] = r.choice(["str", "len", "None", "int", "lambda x: x", "abs", "3"])
            if name in ("getattr", "hasattr"):
                args = [
                    self.value(depth),
                    r.choice(["'real'", "'x'", "'__class__'", "'imag'", "'start'", "1", "'denominator'"]),
                ][:count]
            if name in ("isinstance", "issubclass") and count > 1:
                args[1] = r.choice([
                    "int", "str", "(int, str)", "float", "object", "3", "[int]", "int | str", "type", "()",
                ])
            if name in ("int", "float", "complex") and r.random() < 0.6:
                args[0] = r.choice([
                    "'12'", "' 7 '", "'0x1f'", "'1_0'", "'1__0'", "'-0'", "'1e5'", "'inf'", "'1+2j'", "'(1j)'", "'j'",
                    "''", "b'12'", "'٣'", "'0b11'", "'1.'", "'.5'", "'-nan'", "'1e'", "'12\\x00'", "'+5'", "'z'",
                    "'1 2'", "' 1+1j '", "'1_0.5'", "'1e400'",
                ])
                if name == "int" and count > 1:
                    args[1] = r.choice(["0", "2", "8", "10", "16", "36", "37", "1", "-1", "'a'", "16.0"])
            return f"{name}({', '.join(args)})"
        if pick < 0.77:
            value = r.choice([self.of(INTS), self.of(FLOATS), self.of(STRS), self.value(depth), self.of(COMPLEX)])
            spec = r.choice(SPECS)
            return r.choice([
                f"format({value}, {spec!r})", f"'{{:{spec}}}'.format({value})",
                f"f'{{({value})!r:{r.choice(['', '>12', '<3', '.4'])}}}'",
            ])
        if pick < 0.84:
            args = r.choice([
                self.value(depth), f"({self.value(depth)}, {self.value(depth)})", f"({self.of(INTS)},)",
                f"({self.of(FLOATS)},)", "{'a': 1, 'b': 'x'}", f"(5, {self.of(FLOATS)})",
            ])
            template = r.choice([
                repr(r.choice(PERCENTS)), repr(r.choice(PERCENTS)), "b" + repr(r.choice(PERCENTS)),
            ])
            return f"{template} % {args}"
        if pick < 0.88:
            fmt = r.choice(STRUCTS)
            if r.random() < 0.5:
                number = lambda: r.choice([self.of(INTS), self.of(FLOATS), self.of(BYTES), self.value(depth)])
                return f"struct.pack({fmt!r}, {', '.join(number() for _ in range(r.choice([1, 1, 2])))})"
            return r.choice([
                f"struct.unpack({fmt!r}, bytes(range({r.choice([0, 1, 2, 4, 8, 9, 16])})))",
                f"struct.calcsize({fmt!r})",
            ])
        if pick < 0.92:
            pattern, text = r.choice(PATTERNS), self.of(STRS)
            call = r.choice([
                "re.findall({p}, {t})", "re.split({p}, {t})", "re.sub({p}, '<\\\\\\\\g<0>>', {t})",
                "re.match({p}, {t})", "re.search({p}, {t})", "re.fullmatch({p}, {t})",
                "[m.span() for m in re.finditer({p}, {t})]", "re.subn({p}, '-', {t}, 2)",
                "re.search({p}, {t}).groups()", "re.compile({p}).groups", "re.compile({p}).groupindex",
                "re.sub({p}, lambda m: m[0] * 2, {t})", "re.escape({t})", "re.split({p}, {t}, maxsplit=1)",
            ])
            return call.format(p=f"'{pattern}'", t=text).replace("\\\\\\\\", "\\\\")
        if pick < 0.95:
            value = self.value(depth)
            return r.choice([
                f"json.dumps({value})", f"json.dumps({value}, indent=1, sort_keys=True)",
                f"json.loads({r.choice(STRS + JSONS)})",
                f"json.dumps({value}, ensure_ascii=False, separators=(',', ':'))",
            ])
        if pick < 0.98:
            a, b = self.of(TIMES), r.choice([self.of(TIMES), self.of(INTS[:9]), self.of(FLOATS[:8])])
            return r.choice([
                f"({a}) {r.choice(['+', '-', '*', '/', '//', '%', '<', '==', '>='])} ({b})", f"str({a})",
                f"({a}).strftime({r.choice(STRFTIME)!r})", f"({a}).isoformat()", f"abs({a})", f"-({a})",
                f"divmod({a}, {b})", f"({a}).replace(year=2000)", f"hash({a}) == hash({b})",
                f"date.fromisoformat({r.choice(DATES)!r})",
                f"datetime.datetime.strptime({r.choice(['2024-01-02', '1 Jan 24', '12:30', '', '2024'])!r}, "
                f"{r.choice(['%Y-%m-%d', '%d %b %y', '%H:%M', '%Y', '%q'])!r})",
                f"datetime.datetime.fromisoformat({r.choice(MOMENTS)!r})",
            ])
        return r.choice([
            f"list(itertools.{r.choice(['permutations', 'combinations', 'combinations_with_replacement'])}"
            f"({self.of(STRS, LISTS)}, {r.choice(['0', '1', '2', '-1', 'None'])}))[:20]",
            f"math.{r.choice(MATH_OF_ONE)}({self.of(INTS[:12], FLOATS, STRS[:3])})",
            f"math.{r.choice(MATH_OF_TWO)}({self.of(INTS[:12], FLOATS)}, {self.of(INTS[:12], FLOATS)})",
            f"collections.Counter({self.of(STRS, LISTS)}).most_common(2)", f"copy.deepcopy({self.value(depth)})",
            f"functools.reduce({r.choice(['max', 'operator.add', 'operator.mul'])}, {self.of(LISTS, TUPLES, STRS)})",
            f"[x for x in {self.value(depth)} if x]", f"{{x: 1 for x in {self.value(depth)}}}",
            f"[*{self.value(depth)}]", f"{{**{self.value(depth)}}}", f"(lambda a, *b: (a, b))(*{self.value(depth)})",
            f"operator.itemgetter({self.of(INTS[:5])})({self.of(LISTS, STRS, TUPLES)})",
        ])
