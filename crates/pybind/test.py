#!/usr/bin/env python3
"""Builds the wheel, installs it into a fresh virtual environment under target/ and runs its tests there.

    python3 crates/pybind/test.py [--debug] [--stubs] [pytest arguments]

Needs Rust, a C compiler and Python with venv; maturin, numpy and pytest are fetched by pip. --debug builds without
optimisation, --stubs also holds the type stubs against the binary (fetches mypy).
"""

import os
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def run(*command):
    print("+", *command, flush=True)
    subprocess.run([str(part) for part in command], check=True, cwd=HERE)


def main():
    arguments = sys.argv[1:]
    flags = {flag: flag in arguments for flag in ("--debug", "--stubs")}
    arguments = [a for a in arguments if a not in flags]
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
    version = "{}.{}".format(*sys.version_info)
    environment = target / f"wheel-venv-{version}"
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    if not python.exists():
        venv.create(environment, with_pip=True, symlinks=os.name != "nt")
    tools = ["maturin>=1.9.4,<2", "numpy", "pytest"] + (["mypy"] if flags["--stubs"] else [])
    run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *tools)
    wheels = target / "wheels"
    for old in wheels.glob("elitescript-*.whl"):
        old.unlink()
    profile = [] if flags["--debug"] else ["--release"]
    run(python, "-m", "maturin", "build", *profile, "--interpreter", python, "--out", wheels)
    (wheel,) = wheels.glob("elitescript-*.whl")
    install = ["install", "--quiet", "--disable-pip-version-check", "--force-reinstall", "--no-deps"]
    run(python, "-m", "pip", *install, wheel)
    run(python, "-m", "pytest", *arguments)
    if flags["--stubs"]:
        run(python, "-m", "mypy.stubtest", "elitescript", "--concise")


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode or 1)
