"""The example of examples/ros2: a box is on the pallet afterwards."""

import csv
import io
import os
import pathlib
import subprocess
import sys

from conftest import DOMAINS, Controller

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def test_the_example_puts_a_box_onto_the_pallet(tmp_path):
    controller = Controller(
        tmp_path,
        next(DOMAINS),
        "--cell",
        str(EXAMPLES / "cells" / "palletising" / "cell.toml"),
        "--tcp",
        "0,0,0.10,0,0,0",
        record="x.mcap",
    )
    try:
        done = subprocess.run(
            [sys.executable, str(EXAMPLES / "ros2" / "pick.py")],
            capture_output=True,
            text=True,
            timeout=150,
            env={**os.environ, "ROS_DOMAIN_ID": str(controller.domain)},
        )
        assert done.returncode == 0, done.stdout + done.stderr
        assert "a box stands on the pallet" in done.stdout
    finally:
        assert controller.close() == 0, controller.log_text()
    table = subprocess.run(
        [os.environ["ELITESERVER"], "replay", "x.mcap", "--csv", "/world"],
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    box = [row for row in csv.DictReader(io.StringIO(table)) if row["name"] == "box#1"][-1]
    assert not box["held_by"]
    # The first place of the pallet, whose top is at 0.10 m; the box is 0.06 m high.
    for axis, expected, within in (("x", -0.62, 0.02), ("y", 0.15, 0.02), ("z", 0.13, 0.003)):
        assert abs(float(box[axis]) - expected) < within, box
