#!/usr/bin/env python3
"""What nextest's report says beyond passed and failed: the tests that took longest, and those that needed a second try.

    tests/test_report.py target/nextest/default/report.xml

A second try, one `SECOND TRY: name` a line for people and grep, is a defect of the test or of what it tests, to be
mended; the exit status stays 0.
"""

import collections
import sys
import xml.etree.ElementTree as tree
from pathlib import Path

LONGEST = 15


def report(path):
    cases = list(tree.parse(path).getroot().iter("testcase"))
    took = collections.Counter()
    for case in cases:
        took[case.get("classname")] += float(case.get("time", 0))
    print("seconds of tests, {:.0f} in all; by binary:".format(sum(took.values())))
    for binary, seconds in took.most_common(LONGEST):
        print("{:7.1f}  {}".format(seconds, binary))
    print("the longest:")
    for case in sorted(cases, key=lambda case: -float(case.get("time", 0)))[:LONGEST]:
        print("{:7.1f}  {} {}".format(float(case.get("time", 0)), case.get("classname"), case.get("name")))
    again = [case for case in cases if case.find("flakyFailure") is not None or case.find("flakyError") is not None]
    for case in again:
        print("SECOND TRY: {} {}".format(case.get("classname"), case.get("name")))
    print("second tries: {}".format(len(again)))


path = Path(sys.argv[1])
if path.exists():
    report(path)
else:
    print("second tries: there is no report {}".format(path))
