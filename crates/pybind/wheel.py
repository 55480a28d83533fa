"""Builds the wheel and installs it into a virtual environment under target/: what test.py and bench.py share.

Needs Rust, a C compiler and Python with venv; the rest is fetched by pip.
"""

import os
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()


def run(*command, cwd=HERE):
    print("+", *command, flush=True)
    subprocess.run([str(part) for part in command], check=True, cwd=cwd)


def with_wheel(name, *tools, debug=False):
    """The Python of the environment `name`, which has the tools (as pip names them) and a wheel built just now."""
    environment = TARGET / "{}-venv-{}.{}".format(name, *sys.version_info)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    if not python.exists():
        venv.create(environment, with_pip=True, symlinks=os.name != "nt")
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    run(*pip, "maturin>=1.9.4,<2", "numpy", *tools)
    wheels = TARGET / "wheels"
    for old in wheels.glob("elitescript-*.whl"):
        old.unlink()
    profile = [] if debug else ["--release"]
    run(python, "-m", "maturin", "build", *profile, "--interpreter", python, "--out", wheels)
    (wheel,) = wheels.glob("elitescript-*.whl")
    run(*pip, "--force-reinstall", "--no-deps", wheel)
    return python


def main(body):
    """Runs a program; a command that failed ends it with that command's status."""
    try:
        body()
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode or 1)
