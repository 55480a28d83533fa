"""Builds the wheel and installs it into a virtual environment under target/: what test.py and bench.py share.

Needs Rust, a C compiler and Python with venv; the rest is fetched by pip.
"""

import os
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()


def run(*command, cwd=HERE):
    print("+", *command, flush=True)
    subprocess.run([str(part) for part in command], check=True, cwd=cwd)


def with_wheel(name, *tools, debug=False, library=None):
    """The Python of the environment `name`, which has the tools (as pip names them) and a wheel built just now, or made
    of a library that is built already."""
    environment = TARGET / "{}-venv-{}.{}".format(name, *sys.version_info)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    if not python.exists():
        venv.create(environment, with_pip=True, symlinks=os.name != "nt")
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    run(*pip, "maturin>=1.9.4,<2", "numpy", *tools)
    wheels = TARGET / "wheels"
    for old in wheels.glob("elitescript-*.whl"):
        old.unlink()
    if library is None:
        profile = [] if debug else ["--release"]
        run(python, "-m", "maturin", "build", *profile, "--interpreter", python, "--out", wheels)
    else:
        of_library(python, library, wheels)
    (wheel,) = wheels.glob("elitescript-*.whl")
    run(*pip, "--force-reinstall", "--no-deps", wheel)
    return python


def of_library(python, library, wheels):
    """A wheel around a library that cargo has built: maturin would build it once more,
    with the features of this crate alone."""
    with tempfile.TemporaryDirectory() as told:
        run(python, "-m", "maturin", "pep517", "write-dist-info", "--metadata-directory", told, "--interpreter", python)
        (about,) = Path(told).iterdir()
        fields = dict(line.split(": ", 1) for line in (about / "WHEEL").read_text().splitlines() if ": " in line)
        files = {"elitescript/_elitescript.abi3.so": Path(library)}
        for file in sorted((HERE / "python" / "elitescript").rglob("*")):
            if file.is_file() and file.suffix in (".py", ".pyi", ".typed"):
                files["elitescript/{}".format(file.relative_to(HERE / "python" / "elitescript").as_posix())] = file
        for file in sorted(about.rglob("*")):
            if file.is_file() and file.name != "RECORD":
                files["{}/{}".format(about.name, file.relative_to(about).as_posix())] = file
        wheels.mkdir(exist_ok=True)
        name = "{}-{}.whl".format(about.name[: -len(".dist-info")], fields["Tag"])
        record = "{}/RECORD".format(about.name)
        with zipfile.ZipFile(wheels / name, "w", zipfile.ZIP_STORED) as packed:
            for path, file in files.items():
                packed.write(file, path)
            packed.writestr(record, "".join("{},,\n".format(path) for path in [*files, record]))


def main(body):
    """Runs a program; a command that failed ends it with that command's status."""
    try:
        body()
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode or 1)
