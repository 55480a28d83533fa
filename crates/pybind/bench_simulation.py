#!/usr/bin/env python3
"""Times environments beside MuJoCo, controllers and sweeps in one run on one machine, for docs/BENCHMARKS.md.

    python3 crates/pybind/bench_simulation.py

The packages are fetched from PyPI into a virtual environment under target/.
"""

import wheel

PACKAGES = ["gymnasium==1.4.0", "pyarrow==26.0.1", "fsspec==2026.9.0", "ray==2.60.0", "mujoco==4.0.0"]


def bench():
    wheel.run(wheel.with_wheel("bench-simulation", *PACKAGES), "benches/simulation.py")


if __name__ == "__main__":
    wheel.main(bench)
