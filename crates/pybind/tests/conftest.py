"""Shared vectors and arms for the tests of the wheel."""

import json
import signal
from pathlib import Path

import elitescript
import pytest

# A shell that starts the tests in the background has them ignore Ctrl-C; those that send it would wait for ever.
signal.signal(signal.SIGINT, signal.default_int_handler)

VECTORS = Path(__file__).resolve().parents[3] / "tests" / "vectors"


def load(name):
    return json.loads((VECTORS / name).read_text())


TRUTH = load("truth.json")


@pytest.fixture(params=elitescript.models())
def arm(request):
    """Every built-in arm with its reference values."""
    return elitescript.Robot(request.param), TRUTH["models"][request.param]
