"""Shared vectors and arms for the tests of the wheel."""

import json
from pathlib import Path

import elitescript
import pytest

VECTORS = Path(__file__).resolve().parents[3] / "tests" / "vectors"


def load(name):
    return json.loads((VECTORS / name).read_text())


TRUTH = load("truth.json")


@pytest.fixture(params=elitescript.models())
def arm(request):
    """Every built-in arm with its reference values."""
    return elitescript.Robot(request.param), TRUTH["models"][request.param]
