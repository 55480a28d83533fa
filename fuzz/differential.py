#!/usr/bin/env python3
"""Random programs under CPython and under EliteScript: what they print must be the same.

    cargo build -p elite-lang --example run
    fuzz/differential.py target/debug/examples/run --seconds 60 [--seed 1]

A file is a list of expressions over the builtin types and a few modules, and of programs of several statements
(`programs.py`). Each is run on its own; its value with its type, or its exception with its message, is one line.
Expressions come from a small grammar, seeded, so a difference can be made again with its seed. Differences are printed
with the expression; the exit status is their number, at most 100. Run it with Python 3.11,
which is what EliteScript follows.
"""

import argparse
import math
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import warnings

from expressions import Maker
from programs import Programs

PRELUDE = """
import math, json, re, struct, datetime, itertools, functools, collections, operator, string, copy
import statistics, contextlib
from datetime import timedelta, date
def show(v, depth=0):
    kind = type(v).__name__
    if isinstance(v, (map, filter, zip, enumerate, reversed)) or kind.endswith('iterator') or kind == 'generator':
        return kind + show(list(itertools.islice(v, 20)), depth + 1)
    if isinstance(v, (set, frozenset)):
        return type(v).__name__ + ':' + ' '.join(sorted(map(repr, v)))  # their order means nothing
    if type(v) is tuple and depth < 3:
        return 'tuple:(' + ' | '.join([show(x, depth + 1) for x in v]) + ')'
    return type(v).__name__ + ':' + repr(v)
def t(n, f):
    try:
        print(n, ascii(show(f())))
    except Exception as e:
        print(n, type(e).__name__, ascii(str(e)))
"""

# A file of two thousand programs takes a second or two.
TIMEOUT = 20


# What has an address in it.
NOISE = [
    (re.compile(r"0x[0-9a-f]{6,}"), "0x.."),
    (re.compile(r" at 0x\S*"), ""),
    # The text of an object has an address in it, so its length is that of the address.
    (re.compile(r"element #0 has length [5-9]\d;"), "element #0 has length ..;"),
    # Two NaNs that were made apart are one here (docs/LANGUAGE.md).
    (re.compile(r"\bset:nan( nan)+\b"), "set:nan"),
]


# What differs on purpose (docs/LANGUAGE.md): what CPython shows of its slots, `list.sort` with a function by position,
# and how much memory there is, how long integers may be, and what CPython itself says wrongly of a call it has
# specialised ("-1 given").
MEANT = re.compile(
    r"sort\(\) takes (no positional|at most 2) arguments|MemoryError|the integer would have \d+ bits|mappingproxy|"
    r"GenericAlias|method-wrapper|type '\w+' is not subscriptable|assignment to __class__ is not supported|"
    r"SyntaxError|wrapper_descriptor|<slot wrapper|method_descriptor|\(-1 given\)"
)


# Their last digit is that of the C library CPython was built with.
UNEVEN = re.compile(r"math\.(a?cosh|a?sinh|a?tanh|cbrt|erfc?|gamma|lgamma)\(")
FLOAT = re.compile(r"\d+\.\d+(e[-+]?\d+)?")


def is_meant(text, a, b):
    """Whether what CPython says of a program and what is said here (a, b) may differ."""
    if MEANT.search(a) or MEANT.search(b):
        return True
    # CPython 3.11 reads what is none of its business, or crashes, where `str.replace()`, without any text, stands in
    # code that is warm.
    if "got -1" in a:
        return True
    # A view in CPython, which is compared through what it shows.
    if "groupindex" in text and "not supported between instances of 'dict'" in a:
        return True
    if UNEVEN.search(text):
        one, other = FLOAT.findall(a), FLOAT.findall(b)
        floats = zip(FLOAT.finditer(a), FLOAT.finditer(b))
        if len(one) == len(other) and FLOAT.sub("", a) == FLOAT.sub("", b):
            return all(math.isclose(float(x[0]), float(y[0]), rel_tol=1e-14) for x, y in floats)
    return False


def varies(text, expected):
    """Whether CPython says something else of a program when sets have another order."""
    with tempfile.NamedTemporaryFile("w", suffix=".py") as file:
        number = int(re.search(r"^t\((\d+),", text, re.M)[1])
        file.write(PRELUDE + text + "\n")
        file.flush()
        for seed in range(6):
            found, _ = run([sys.executable, "-W", "ignore"], file.name, {number}, seed)
            if found.get(number) != expected:
                return True
    return False


def clean(text):
    for pattern, by in NOISE:
        text = pattern.sub(by, text)
    return text


def run(command, path, numbers, seed=0):
    """What each program of a file, which have these numbers, prints, and what went wrong; the order of sets of texts is
    that of the seed."""
    trouble = ""
    try:
        done = subprocess.run(
            [*command, path],
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
            preexec_fn=limited,
            env={**os.environ, "PYTHONHASHSEED": str(seed), "PYTHONUNBUFFERED": "1"},
        )
        printed = done.stdout
        if done.returncode:
            trouble = done.stderr.strip().split("\n")[0] or f"status {done.returncode}"
    except subprocess.TimeoutExpired as expired:
        printed, trouble = (expired.stdout or b"").decode(), "timeout"
    lines = {}
    number = None
    for line in clean(printed).rstrip("\n").split("\n"):
        head, _, rest = line.partition(" ")
        if head.isdigit() and int(head) in numbers and (number is None or int(head) > number):
            number = int(head)
            lines[number] = rest
        elif number is not None:
            lines[number] += "\n" + line
    return lines, trouble


def run_all(command, texts):
    """What the programs print, run in one file; one that never ends is left out and the rest is run on its own."""
    lines, troubles = {}, []
    while texts:
        with tempfile.NamedTemporaryFile("w", suffix=".script") as file:
            file.write(PRELUDE + "\n".join(texts.values()) + "\n")
            file.flush()
            found, trouble = run(command, file.name, texts.keys())
        lines.update(found)
        if not trouble:
            break
        stopped = next((number for number in texts if number not in found), None)
        troubles.append((stopped, trouble))
        if not found and trouble != "timeout":
            break  # the file as a whole is refused
        texts = {number: text for number, text in texts.items() if stopped is not None and number > stopped}
    return lines, troubles


def texts_of(seed, options):
    """The programs of a seed, each of which prints a line with its number."""
    maker = Maker(seed)
    programs = Programs(random.Random(-seed - 1))
    texts = []
    while len(texts) < options.batch:
        number = len(texts)
        is_program = options.kind == "programs" or options.kind == "both" and number % 2
        text = programs.program(number) if is_program else f"t({number}, lambda: {maker.expression()})"
        try:
            compile(text, "", "exec")
        except (SyntaxError, ValueError):
            continue
        texts.append(text)
    return texts


def limited():
    """A program that takes all memory is stopped."""
    resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))


def main():
    # Whoever ends this ends the programs it has started, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", help="what runs EliteScript files")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--batch", type=int, default=400, help="programs a file")
    parser.add_argument("--kind", choices=["expressions", "programs", "both"], default="both")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    deadline = time.monotonic() + options.seconds
    seed, count, differences, seen = options.seed, 0, 0, set()
    while time.monotonic() < deadline:
        texts = dict(enumerate(texts_of(seed, options)))
        expected, endless = run_all([sys.executable, "-W", "ignore"], texts)
        # A program that does not end under CPython says nothing.
        for number, _ in endless:
            texts.pop(number, None)
        found, troubles = run_all([options.program], texts)
        for number, trouble in troubles:
            differences += 1
            print(f"seed {seed} line {number}: {trouble}\n{texts.get(number)}", flush=True)
        for number, text in texts.items():
            a, b = expected.get(number), found.get(number)
            if a != b and a is not None and b is not None and not is_meant(text, a, b):
                key = re.sub(r"\d+", "0", f"{a[:40]}|{b[:40]}")
                if key in seen or varies(text, a):
                    continue
                seen.add(key)
                differences += 1
                print(f"seed {seed} line {number}: {text}\n  cpython: {a}\n  here:    {b}", flush=True)
        count += len(texts)
        seed += 1
    print(f"{count} programs, {differences} differences, seeds {options.seed} to {seed - 1}")
    return min(differences, 100)


if __name__ == "__main__":
    sys.exit(main())
