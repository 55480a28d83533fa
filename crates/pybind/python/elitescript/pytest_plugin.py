"""pytest plugin: the fixture ``controller``, the marker of the same name, recordings of failed tests.

    @pytest.mark.controller(model="cs612", seed=3)
    def test_reach(controller):
        assert controller.run("movej([0, -1, 1, -1, -1, 0])").ok

A failed test keeps the recording of its controller in ``--elite-recordings DIR``, else beside ``--junitxml``.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any, Dict, Generator, Optional

import pytest

from ._controller import Controller

_FAILED = pytest.StashKey[bool]()
_KEPT = pytest.StashKey[Path]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("elitescript")
    group.addoption(
        "--elite-recordings",
        metavar="DIR",
        default=None,
        help="keep the recordings of failed tests with a controller here (default: beside --junitxml)",
    )


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "controller(**options): options of the fixture `controller`, as elitescript.Controller"
    )


def _folder(config: pytest.Config) -> Optional[Path]:
    given = config.getoption("--elite-recordings")
    if given:
        return Path(given)
    report = getattr(config.option, "xmlpath", None)
    return Path(report).parent if report else None


def _name(node: str) -> str:
    """A file name for a test: readable, and no two tests share one."""
    readable = re.sub(r"[^A-Za-z0-9_.-]+", "-", node).strip("-")[-120:]
    return f"{readable}-{hashlib.sha256(node.encode()).hexdigest()[:6]}.mcap"


@pytest.fixture
def controller(request: pytest.FixtureRequest) -> Generator[Controller, None, None]:
    """A controller for this test alone, with the options of ``@pytest.mark.controller``; the nearest marker wins."""
    options: Dict[str, Any] = {}
    for marker in reversed(list(request.node.iter_markers("controller"))):
        if marker.args:
            raise pytest.UsageError(f"{request.node.nodeid}: the marker controller takes options by name only")
        options.update(marker.kwargs)
    folder = _folder(request.config)
    scratch = None
    if folder is not None and options.get("record") is None:
        scratch = tempfile.mkdtemp(prefix="elitescript-")
        options["record"] = os.path.join(scratch, "test.mcap")
        request.node.stash[_KEPT] = folder / _name(request.node.nodeid)
    try:
        made = Controller(**options)
        try:
            yield made
        finally:
            made.close()
            if scratch is not None and request.node.stash.get(_FAILED, False):
                kept = request.node.stash[_KEPT]
                kept.parent.mkdir(parents=True, exist_ok=True)
                shutil.move(str(options["record"]), str(kept))
    finally:
        if scratch is not None:
            shutil.rmtree(scratch, ignore_errors=True)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: Any) -> Generator[None, Any, None]:
    outcome = yield
    report = outcome.get_result()
    if report.failed and report.when in ("setup", "call"):
        item.stash[_FAILED] = True
        kept = item.stash.get(_KEPT, None)
        if kept is not None and report.when == "call":
            report.sections.append(("recording", f"{kept}\neliteserver replay {kept}"))
