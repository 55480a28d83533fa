#!/usr/bin/env python3
"""Times the kinematics in one run on one machine: in Rust, and through Python beside numpy, scipy, pin and eaik.

    python3 crates/pybind/bench.py

The packages are fetched from PyPI into a virtual environment under target/.
"""

import wheel


def bench():
    python = wheel.with_wheel("bench", "scipy", "pin", "eaik")
    # The profile of the wheel but for linking across crates, which takes minutes and changes little here.
    options = ["--config", "profile.bench.lto=false"]
    wheel.run("cargo", "bench", *options, "--package", "kinematics", "--bench", "kinematics", cwd=wheel.ROOT)
    wheel.run(python, "benches/compare.py")


if __name__ == "__main__":
    wheel.main(bench)
