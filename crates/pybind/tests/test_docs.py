"""The examples of docs/python.md and of the docstrings are run and must print what they show."""

import doctest
import inspect
import subprocess
import sys
from pathlib import Path

import elitescript
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("page, least", [("python.md", 30), ("simulation.md", 40)])
def test_examples_of_the_pages(page, least, tmp_path, monkeypatch):
    pytest.importorskip("gymnasium")
    monkeypatch.chdir(tmp_path)
    path = str(ROOT / "docs" / page)
    with np.printoptions():
        failed, tried = doctest.testfile(path, module_relative=False, optionflags=doctest.ELLIPSIS)
    assert tried > least and failed == 0


def test_examples_of_the_docstrings():
    names = {name: getattr(elitescript, name) for name in elitescript.__all__}
    names |= {f"Robot.{name}": member for name, member in inspect.getmembers(elitescript.Robot)}
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner()
    for name, member in names.items():
        if isinstance(member, type) and member.__module__ != "elitescript":
            # Examples of pages stand in docs/simulation.md.
            continue
        if inspect.getdoc(member) and not name.startswith(("__", "Robot.__")):
            text = inspect.getdoc(member)
            runner.run(parser.get_doctest(text, {"elitescript": elitescript}, name, None, 0))
    runner.run(parser.get_doctest(elitescript.__doc__, {}, "elitescript", None, 0))
    assert runner.tries >= 5 and runner.failures == 0


def test_the_reach_map_is_drawn(tmp_path):
    pytest.importorskip("matplotlib", reason="the test was asked to be quick")
    picture = tmp_path / "reach.png"
    example = ROOT / "examples" / "python" / "reach_map.py"
    ran = subprocess.run([sys.executable, str(example), str(picture)], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert "51% of the places can be reached" in ran.stdout
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 20_000


def test_the_force_setting_is_found(tmp_path):
    pytest.importorskip("matplotlib", reason="the test was asked to be quick")
    picture = tmp_path / "force.png"
    example = ROOT / "examples" / "python" / "force_setting.py"
    ran = subprocess.run([sys.executable, str(example), str(picture)], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert "  150 N/mm: gain 0.1, settled after" in ran.stdout, ran.stdout
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 20_000
