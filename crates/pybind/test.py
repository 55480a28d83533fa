#!/usr/bin/env python3
"""Builds the wheel, installs it into a virtual environment under target/ and tests it there.

    python3 crates/pybind/test.py [--debug | --library=FILE] [--quick] [pytest arguments]

--debug builds without optimisation; --library takes what `cargo build -p pybind` has made. --quick leaves out what
fetches more packages: the type stubs held against the binary (mypy), the pictures of examples/python (matplotlib),
sweeps on clusters of this machine (ray, distributed), the form of all Python in the repository (ruff).
"""

import sys

import wheel

#: What the tests of sweeps and environments need, and what a quick run leaves out.
TOOLS = ["pytest==9.2.0", "gymnasium==1.4.0", "pyarrow==26.0.1", "fsspec==2026.9.0"]
MORE = ["mypy==2.4.1", "matplotlib==3.11.2", "ray==2.60.0", "distributed==2026.8.0", "ruff==0.17.6"]


def test():
    arguments = sys.argv[1:]
    debug, quick = ("--debug" in arguments, "--quick" in arguments)
    arguments = [a for a in arguments if a not in ("--debug", "--quick")]
    library = next((a.partition("=")[2] for a in arguments if a.startswith("--library=")), None)
    arguments = [a for a in arguments if not a.startswith("--library=")]
    python = wheel.with_wheel("wheel", *TOOLS, *([] if quick else MORE), debug=debug, library=library)
    wheel.run(python, "-m", "pytest", *arguments)
    if not quick:
        wheel.run(python, "-m", "mypy.stubtest", "elitescript", "--concise")
        wheel.run(python, "-m", "mypy", "--strict", wheel.ROOT / "examples" / "python", "python/elitescript")
        # Of all Python in the repository, as ruff.toml says: here is the environment that fetches checkers.
        wheel.run(python, "-m", "ruff", "check", "--no-cache", wheel.ROOT)
        wheel.run(python, "-m", "ruff", "format", "--no-cache", "--check", wheel.ROOT)


if __name__ == "__main__":
    wheel.main(test)
