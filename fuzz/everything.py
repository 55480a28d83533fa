#!/usr/bin/env python3
"""Everything with everything, under CPython and under EliteScript: what it gives must be the same.

    cargo build --release -p elite-lang --example run
    fuzz/everything.py target/release/examples/run [--only operators|methods|builtins|texts|modules]

Every operator, every method of the builtin types, every builtin function and some of the library, with every one or two
of the values that `expressions.py` draws from: some four million calls, in which random programs would need years to
meet each pair. What differs on purpose is left out as there. Prints each kind of call that differs with its first
cases; the exit status is 1 if there is one. Run it with Python 3.11.
"""

import argparse
import collections
import itertools
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile

import differential
import expressions
import pieces

#: Values of derived classes: what they do, and what messages call them.
DERIVED = {
    "int": "3",
    "float": "1.5",
    "complex": "1j",
    "str": "'a1'",
    "bytes": "b'a'",
    "bytearray": "b'ab'",
    "list": "[1]",
    "tuple": "(1, 2)",
    "dict": "a=1",
    "set": "{1}",
    "frozenset": "{2}",
    "object": "",
}
CLASSES = "".join(f"class My{base}({base}): pass\n" for base in DERIVED)
DERIVED = {base: f"My{base}({content})" for base, content in DERIVED.items()}
BASES = [
    ("", ""),
    ("list", "[1, 2]"),
    ("dict", "[(1, 2)]"),
    ("str", "'12'"),
    ("int", "12"),
    ("float", "12"),
    ("tuple", "[1, 2]"),
    ("set", "[1]"),
    ("bytes", "b'12'"),
]
ANSWERS = [
    "2**70",
    "-2**70",
    "0",
    "None",
    "'a'",
    "[1]",
    "1e400",
    "(1,)",
    "object()",
    "self",
    "I(3)",
    "S('s')",
    "F(2.5)",
    "NotImplemented",
    "raise KeyError('k')",
    "raise AttributeError",
    "raise StopIteration",
    "raise TypeError",
]
VALUES = [value for kind in (*expressions.KINDS, expressions.TIMES, DERIVED.values()) for value in kind] + [
    "Myobject",
    "Myint",
]
#: What a number or a text is repeated by, raised to, shifted by.
FEW = ["0", "1", "2", "-1", "3", "0.5", "'a'", "None", "1.5", "-3", "True", "1j", "[]", "2.0", "0.0", "-2.5", "64"]
SECOND = ["0", "1", "-1", "None", "'a'", "b'a'", "10", "'*'", "'big'", "1.5", "True", "[]"]
RECEIVERS = {
    "str": expressions.STRS,
    "bytes": expressions.BYTES,
    "list": expressions.LISTS,
    "tuple": expressions.TUPLES,
    "dict": expressions.DICTS,
    "set": expressions.SETS,
    "int": expressions.INTS,
    "float": expressions.FLOATS,
    "range": ["range(5)", "range(10, 0, -3)", "range(0)"],
}
#: Whether a value is no number that would fill the memory, or take for ever.
SHORT = "def short(x, most=300): return not isinstance(x, int) or abs(x) <= most\n"
OF_ONE = """
json.dumps(a) json.dumps(a,indent=1,sort_keys=True) json.loads(a) json.dumps(a,ensure_ascii=False,separators=(',',':'))
json.dumps([a],indent='x') json.dumps({'k':a}) copy.deepcopy(a) copy.copy(a) repr(a) str(a) hash(a)and(0)
bytes.fromhex(a) pow(a,2) pow(2,a,7)
""".split()
MATH = """
acos asin atan ceil cos degrees exp exp2 expm1 fabs floor frexp fsum isfinite isinf isnan isqrt log log10 log1p log2
modf prod radians sin sqrt tan trunc ulp
""".split()
MATH_OF_TWO = "atan2 copysign dist fmod gcd hypot isclose lcm ldexp log nextafter pow remainder".split()
OF_TWO = """
operator.itemgetter(b)(a) functools.reduce(operator.add,a,b) collections.Counter(a).most_common(b)
list(itertools.islice(a,b)) list(itertools.permutations(a,b))[:5]if(short(b,3))else(0)
list(itertools.combinations(a,b))[:5]if(short(b,3))else(0) statistics.mean([a,b]) sorted([a,b]) {a:1,b:2}
list(itertools.accumulate(a,initial=b))[:9] list(itertools.zip_longest(a,b))[:9] list(itertools.chain(a,b))[:9]
collections.deque(a,b) dict(a,k=b) dict.fromkeys(a,b) str.maketrans(a,b) int.from_bytes(a,b) getattr(a,'x',b)
list(itertools.compress(a,b)) list(itertools.starmap(max,[(a,b)])) list(itertools.takewhile(a,b)) a[b:] a[:b] a[::b]
a[b] date(2024,a,b) datetime.time(a,b) timedelta(a,b) datetime.datetime(2024,1,1,a,b) datetime.timezone(a,b)
a.replace(b) a.isoformat(b) datetime.datetime.combine(a,b) datetime.datetime.strptime(a,b) operator.concat(a,b)
operator.countOf(a,b) operator.indexOf(a,b) operator.contains(a,b) operator.length_hint(a,b)
string.Template(a).safe_substitute(b) string.Formatter().format(a,b) re.sub('a',a,b) re.match(a,b) re.split(a,b)
bytes(a,b)if(short(a))else(0) str(a,b) slice(a,b).indices(10) setattr(a,'x',b) range(a,b)[:3]
(lambda*x,**k:(x,k))(*a,**b) math.comb(a,b)if(short(a)and(short(b)))else(0)
math.perm(a,b)if(short(a)and(short(b)))else(0) heapq.nlargest(b,a) bisect.bisect(a,b) a.strftime(b) '%s|%r'%(a,b)
f'{a}{b!r:>5}' divmod(a,b) max(a,b) next(iter(a),b) [*a,*b] {**a,**b} (a,*b) a.__format__(b)
""".split()


def thunks(name, values):
    return f"{name} = [" + ", ".join(f"(lambda: {value})" for value in values) + "]\n"


def with_two(label, call, first="V", second="V", condition="True"):
    """Asks `call` of fresh values a and b, each time under a name of its own."""
    return (
        f"def call(a, b): return {call}\nfor i, a in enumerate({first}):\n    for j, b in enumerate({second}):\n"
        f"        if {condition}: t({label!r} + ' %d %d' % (i, j), lambda: call(a(), b()))\n"
    )


def with_one(label, call, values="V", condition="True"):
    return (
        f"def call(a): return {call}\nfor i, a in enumerate({values}):\n"
        f"    if {condition}: t({label!r} + ' %d' % i, lambda: call(a()))\n"
    )


def operators():
    for op in expressions.BINARY:
        yield with_two(op, f"a {op} b", second="F" if op in ("**", "<<", "*") else "V")
    yield with_two("few *", "a * b", first="F", condition="short(b(), 1000) or not isinstance(a(), (str, list))")
    for op in expressions.UNARY:
        yield with_one(op, f"{op}a")


def methods():
    yield thunks("T", SECOND)
    for name, pool in RECEIVERS.items():
        yield thunks("P", pool + ([DERIVED[name]] if name in DERIVED else []))
        for method in expressions.METHODS[name]:
            wide = method in ("center", "ljust", "rjust", "zfill", "expandtabs", "to_bytes")
            condition = "short(a())" if wide else "True"
            yield (
                f"def call(v, *a): return v.{method}(*a), v\nfor i, p in enumerate(P):\n"
                f"    t('{name}.{method} %d' % i, lambda: call(p()))\n"
                "    for j, a in enumerate(V):\n"
                f"        if {condition}: t('{name}.{method} %d %d' % (i, j), lambda: call(p(), a()))\n"
                f"    for j, a in enumerate(V[::3] if i < 12 else []):\n        for k, b in enumerate(T):\n"
                f"            if {condition}: t('{name}.{method} %d %d %d' % (i, j, k), lambda: call(p(), a(), b()))\n"
            )


def builtins():
    for name, count in expressions.BUILTINS.items():
        yield with_one(
            name, f"{name}(a)", condition="short(a())" if name in ("range", "bytes", "bytearray") else "True"
        )
        if count >= 2 and name != "pow":
            yield with_two(name, f"{name}(a, b)", condition="short(b())" if name == "round" else "True")


def texts():
    for number, spec in enumerate(expressions.SPECS):
        yield with_one(f"format {spec}", f"(format(a, {spec!r}), ('{{:' + {spec!r} + '}}').format(a))")
    for text in expressions.PERCENTS:
        for label, call in (
            ("alone", f"{text!r} % a"),
            ("one", f"{text!r} % (a,)"),
            ("first", f"{text!r} % (a, 5)"),
            ("last", f"{text!r} % (5, a)"),
            ("bytes", f"b{text!r} % a"),
            ("one of bytes", f"b{text!r} % (a,)"),
        ):
            yield with_one(f"% {text} {label}", call)
    for layout in expressions.STRUCTS:
        for call in (
            "struct.pack({0!r}, a)",
            "struct.pack({0!r}, 0, a)",
            "struct.unpack({0!r}, a)",
            "struct.unpack({0!r}, bytes(range(len(a))))",
        ):
            yield with_one(call.format(layout), call.format(layout))
    for call in OF_ONE:
        yield with_one(call, call)


def modules():
    yield "import bisect, heapq\n"
    for name in MATH:
        yield with_one(f"math.{name}", f"math.{name}(a)")
    yield with_one("math.factorial", "math.factorial(a)", condition="short(a())")
    for call in [f"math.{name}(a, b)" for name in MATH_OF_TWO] + OF_TWO:
        yield with_two(call, call)


def asked_by_all():
    """What asks objects, as functions."""
    yield (
        "class S(str): pass\nclass Y(bytes): pass\nclass I(int): pass\nclass F(float): pass\n"
        "class C(complex): pass\nASKS = []\n"
    )
    for ask in pieces.ASKS:
        *before, last = ask.split("; ")
        last = last.removeprefix("x = ")
        yield (
            "def ask(o, K):\n"
            + "".join(f"    {line}\n" for line in [*before, f"return {last}"])
            + f"ASKS.append(({ask!r}, ask))\n"
        )


def asking(base, content, answers):
    """A class with these answers of its special methods, and everybody asking an object of it."""
    text = f"class K({base}):\n"
    for name, answer in answers:
        body = answer if answer.startswith("raise") else f"return {answer}"
        # Or who asks for one item after the other never ends.
        if name == "__getitem__":
            body = f"\n        if x[0] == 4: raise IndexError\n        {body}"
        if name == "__next__":
            body = f"\n        k.append(0)\n        if len(k) % 4 == 0: raise StopIteration\n        {body}"
        text += f"    def {name}(self, *x, k={[] if name == '__next__' else 0}): {body}\n"
    names, where = (
        " ".join(name for name, _ in answers),
        f" where {base or 'object'} gives {' and '.join(answer for _, answer in answers)}",
    )
    return (
        f"{text}try: K({content})\nexcept Exception: t({names + where!r}, lambda: K({content}))\n"
        f"else:\n    for text, ask in ASKS: t({names!r} + ' ' + text + {where!r}, lambda: ask(K({content}), K))\n"
    )


def specials():
    """Each special method in a class derived from each builtin type, with each answer it may give, and everybody who
    may ask for it."""
    yield from asked_by_all()
    for name, kept in pieces.KEPT.items():
        for answer in dict.fromkeys([*kept, *ANSWERS]):
            for base, content in BASES:
                yield asking(base, content, [(name, answer)])


def some():
    """Some of them together, drawn at random."""
    yield from asked_by_all()
    r = random.Random(options.seed)
    for _ in range(3000):
        names = r.sample(list(pieces.KEPT), r.choice([2, 2, 3, 4]))
        yield asking(*r.choice(BASES), [(name, r.choice([*pieces.KEPT[name], *ANSWERS])) for name in names])


def output_of(command, path):
    # More memory than this is refused in both, which `is_meant` leaves out.
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
    done = subprocess.run(
        [*command, path],
        capture_output=True,
        text=True,
        errors="replace",
        preexec_fn=limit,
        env={**os.environ, "PYTHONHASHSEED": "0"},
    )
    if done.returncode:
        sys.exit(f"{command[0]} ended with {done.returncode}: {done.stderr[-500:]}")
    lines = done.stdout.split("\n")
    for pattern, replacement in differential.NOISE:
        lines = [pattern.sub(replacement, line) if "0x" in line or "length" in line else line for line in lines]
    return lines


def is_meant(call, expected, actual):
    # Numbers have no identity here (docs/LANGUAGE.md), so that a NaN is found where CPython looks for that very one;
    # methods that are called through a tuple of arguments bear the name of their receiver's type in CPython,
    # `bool.bit_length`.
    return (
        differential.is_meant(call, expected, actual)
        or "nan" in expected
        or expected.replace("str_iterator", "str_ascii_iterator") == actual
        or re.sub(r"(Error [\"'])(?:bool|My(\w+))\.", own_type, expected) == actual
    )


def own_type(match):
    return match[1] + (match[2] or "int") + "."


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runner")
    parser.add_argument("--only", choices=["operators", "methods", "builtins", "texts", "modules", "specials", "some"])
    parser.add_argument("--seed", type=int, default=1, help="of what is drawn at random")
    global options
    options = parser.parse_args()
    if not shutil.which(options.runner):
        parser.error(f"{options.runner} is no program: build it first")
    total, failed = 0, False
    for kind in (operators, methods, builtins, texts, modules, specials, some):
        if options.only not in (None, kind.__name__):
            continue
        with tempfile.NamedTemporaryFile("w", suffix=".py") as file:
            file.write(
                differential.PRELUDE + CLASSES + SHORT + thunks("V", VALUES) + thunks("F", FEW) + "".join(kind())
            )
            file.flush()
            expected, actual = (
                output_of(command, file.name) for command in ([sys.executable, "-W", "ignore"], [options.runner])
            )
        found = collections.defaultdict(list)
        for one, other in itertools.zip_longest(expected, actual, fillvalue=""):
            if one != other and not is_meant(one, one, other):
                found[re.split(r" \d+ | where ", one)[0]].append((one, other))
        total += len(expected)
        failed = failed or bool(found)
        for call, cases in found.items():
            print(f"{call}: {len(cases)} differ")
            for one, other in cases[:3]:
                print(f"  cpython: {one[:300]}\n  here:    {other[:300]}")
        print(f"{kind.__name__}: {len(expected)} calls, {sum(map(len, found.values()))} differences", flush=True)
    print(f"{total} calls; the values: {', '.join(VALUES[:3])}, … {VALUES[-1]}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
