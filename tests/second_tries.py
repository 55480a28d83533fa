#!/usr/bin/env python3
"""Tests that needed a second try, one `SECOND TRY: name` a line for people and grep, from nextest's report.

    tests/second_tries.py target/nextest/default/report.xml

Each is a defect of the test or of what it tests, to be mended; the exit status stays 0.
"""
import sys
import xml.etree.ElementTree as tree
from pathlib import Path


def second_tries(report):
    for case in tree.parse(report).getroot().iter("testcase"):
        if case.find("flakyFailure") is not None or case.find("flakyError") is not None:
            yield f"{case.get('classname')} {case.get('name')}"


path = Path(sys.argv[1])
names = list(second_tries(path)) if path.exists() else []
for name in names:
    print(f"SECOND TRY: {name}")
print(f"second tries: {len(names)}")
