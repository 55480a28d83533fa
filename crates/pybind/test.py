#!/usr/bin/env python3
"""Builds the wheel, installs it into a virtual environment under target/ and tests it there.

    python3 crates/pybind/test.py [--debug] [--quick] [pytest arguments]

--debug builds without optimisation. --quick leaves out what fetches more packages: the type stubs held against the
binary (mypy), and the pictures of examples/python (matplotlib).
"""

import sys

import wheel


def test():
    arguments = sys.argv[1:]
    debug, quick = ("--debug" in arguments, "--quick" in arguments)
    arguments = [a for a in arguments if a not in ("--debug", "--quick")]
    tools = ["pytest"] if quick else ["pytest", "mypy", "matplotlib"]
    python = wheel.with_wheel("wheel", *tools, debug=debug)
    wheel.run(python, "-m", "pytest", *arguments)
    if not quick:
        wheel.run(python, "-m", "mypy.stubtest", "elitescript", "--concise")
        wheel.run(python, "-m", "mypy", "--strict", wheel.ROOT / "examples" / "python", "python/elitescript")


if __name__ == "__main__":
    wheel.main(test)
