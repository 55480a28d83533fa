"""Usual regular expressions on texts of usual size: the least time of fifteen runs of each, in microseconds.

Runs unchanged on CPython and on the language: `python3 benches/regex.py`,
`target/release/examples/run benches/regex.py`.
"""

import re
import time

REPEATS = 15

LOG = "".join(
    "2026-03-%02d 12:%02d:%02d,%03d INFO robot.motion: moved joint %d to %.4f rad (ok)\n"
    % (i % 28 + 1, i % 60, i * 7 % 60, i * 37 % 1000, i % 6 + 1, i * 0.0137)
    for i in range(400)
)
WORDS = "the quick brown fox jumps over the lazy dog and 17 other animals, 3.5 times a day; " * 200
CSV = ",".join("field%d" % i for i in range(3000))
MAIL = " ".join("user%d.name@example%d.com or not@an address," % (i, i % 9) for i in range(400))
NUMBERS = " ".join("%.3f" % (i * 1.37 - 900) for i in range(2000))
CASES = [
    ("find all words", lambda p: p.findall(WORDS), r"\w+"),
    ("find all numbers", lambda p: p.findall(NUMBERS), r"-?\d+\.\d+"),
    (
        "match lines of a log",
        lambda p: [p.match(line).groups() for line in LOG.splitlines()],
        r"(\d{4})-(\d\d)-(\d\d) (\d\d):(\d\d):(\d\d),(\d+) (\w+) ([\w.]+): (.*)",
    ),
    ("search a literal", lambda p: p.search(WORDS + "needle"), r"needle"),
    ("alternatives", lambda p: p.findall(WORDS), r"fox|dog|animals"),
    ("ignoring case", lambda p: p.findall(WORDS), r"(?i)QUICK\s+brown"),
    ("split", lambda p: p.split(CSV), r"\s*,\s*"),
    ("replace", lambda p: p.sub(r"<\1>", WORDS), r"(\d+(?:\.\d+)?)"),
    ("addresses", lambda p: p.findall(MAIL), r"[\w.+-]+@[\w-]+\.[\w.]+"),
    ("lazy, to the end of a line", lambda p: p.findall(LOG), r"(?m)^.*?joint (\d).*$"),
    ("look-ahead", lambda p: p.findall(WORDS), r"\b\w+(?=\s+dog)"),
    ("a repeated word", lambda p: p.search(WORDS), r"\b(\w+) \1\b"),
]
clock = time.perf_counter


def best(act, pattern):
    shortest = 1e9
    for _ in range(REPEATS):
        start = clock()
        act(pattern)
        shortest = min(shortest, clock() - start)
    return shortest


for name, act, text in CASES:
    print("%s\t%.0f" % (name, best(act, re.compile(text)) * 1e6))
