"""The URDF files in robots/ are what robots/generate.py writes from the table of figures."""

import runpy
from pathlib import Path

from conftest import load

ROBOTS = Path(__file__).resolve().parents[3] / "robots"


def test_urdf_files_are_current():
    robot = runpy.run_path(str(ROBOTS / "generate.py"))["robot"]
    figures = load("cs_figures.json")
    for name, model in figures["models"].items():
        wanted = robot(name, model, figures["pairs_to_skip"], figures["source"])
        assert (ROBOTS / name / f"{name}.urdf").read_text() == wanted, name
