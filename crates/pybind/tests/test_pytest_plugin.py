"""The pytest plugin: fixture, marker, recordings of failed tests."""

import subprocess
import sys

import elitescript

TESTS = """
import pytest

@pytest.mark.controller(model="cs612", plant="ideal")
def test_good(controller):
    assert controller.run("print(get_robot_model() if False else 1)").prints == ["1"]
    assert "cs612" in repr(controller)

@pytest.mark.controller(plant="ideal")
class TestMany:
    @pytest.mark.controller(step_ms=8)
    def test_bad(self, controller):
        controller.step(5)
        assert controller.state.time == 0

@pytest.mark.controller(nothing=1)
def test_wrong(controller):
    pass
"""


def test_failed_tests_keep_their_recording(tmp_path):
    (tmp_path / "test_it.py").write_text(TESTS)
    for arguments, folder in (
        (["--elite-recordings", "kept"], tmp_path / "kept"),
        (["--junitxml", "out/report.xml"], tmp_path / "out"),
    ):
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert "1 passed, 1 failed, 1 error" in done.stdout or "1 failed, 1 passed, 1 error" in done.stdout, done.stdout
        assert "there is no option nothing" in done.stdout and "eliteserver replay" in done.stdout
        (recording,) = folder.glob("*.mcap")
        cycles = elitescript.open_recording(recording)["/cycle"]
        assert "test_bad" in recording.name and cycles["time"].tolist() == [0.008 * k for k in range(1, 6)]
