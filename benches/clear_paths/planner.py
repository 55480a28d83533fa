"""Planned paths of the product against RRT-Connect of OMPL (PyPI) with the collision checks of coal, on generated scenes.

    benches/clear_paths/run.sh planner [COUNT]
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from ompl import base as ob
from ompl import geometric as og

from arm import KINDS, Arm, cell_text, scene
from coal_scene import Scene

MARGIN = 0.01
TIME = 5.0


def problem(kind, rng, arm):
    """A cell with a start and a goal that keep the margin, on different sides of something."""
    low, high = arm.limits()
    while True:
        boxes = scene(kind, rng)
        known = Scene(arm, boxes, with_cut=False)
        ends = []
        for _ in range(4000):
            q = np.array([rng.uniform(-2.5, 2.5), rng.uniform(-2.6, -0.4), rng.uniform(0.3, 2.4), rng.uniform(-2.8, 0.2), rng.uniform(-2.0, 0.5), 0.0])
            if not known.is_clear(q, MARGIN + 0.005):
                continue
            # One end in the obstacle's neighbourhood, the other anywhere.
            if not ends and known.nearest(q)[0] > 0.06:
                continue
            ends.append(q)
            if len(ends) == 2 and np.linalg.norm(ends[0] - ends[1]) > 1.0:
                straight = [ends[0] + (ends[1] - ends[0]) * k / 60 for k in range(61)]
                if not all(known.is_clear(q, MARGIN) for q in straight):
                    return boxes, known, ends
            if len(ends) == 2:
                ends.pop()


def with_ompl(known, ends, seed):
    space = ob.RealVectorStateSpace(6)
    bounds = ob.RealVectorBounds(6)
    for joint in range(6):
        bounds.setLow(joint, min(ends[0][joint], ends[1][joint]) - np.pi)
        bounds.setHigh(joint, max(ends[0][joint], ends[1][joint]) + np.pi)
    space.setBounds(bounds)
    setup = og.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: known.is_clear(np.array([state[k] for k in range(6)]), MARGIN))
    setup.getSpaceInformation().setStateValidityCheckingResolution(0.01)
    places = []
    for end in ends:
        place = space.allocState()
        for joint in range(6):
            place[joint] = float(end[joint])
        places.append(place)
    setup.setStartAndGoalStates(*places)
    setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
    begun = time.process_time()
    solved = setup.solve(TIME)
    took = time.process_time() - begun
    if not solved or not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution(2.0)
    path = setup.getSolutionPath()
    points = [np.array([path.getState(i)[k] for k in range(6)]) for i in range(path.getStateCount())]
    return points, took


def driven(program_binary, folder, points):
    """How long a program of these points without blends takes, and with the product's blends nothing is compared."""
    lines = "".join(f"    movej({json.dumps([float(x) for x in q])}, a=1.4, v=1.05)\n" for q in points[1:])
    (folder / "theirs.script").write_text(f"def theirs():\n{lines}end\n")
    home = ",".join(repr(float(x)) for x in points[0])
    out = subprocess.run(
        [program_binary, "run", "theirs.script", f"--home={home}", "--plant", "ideal", "--record", "theirs.mcap"],
        cwd=folder, capture_output=True, text=True,
    )
    text = subprocess.run([program_binary, "replay", "theirs.mcap"], cwd=folder, capture_output=True, text=True).stdout
    duration = next((line for line in text.splitlines() if line.startswith("duration:")), None)
    return float(duration.split()[1]) if out.returncode == 0 and duration else None


def main(binary, count):
    rng = np.random.default_rng(47)
    arm = Arm()
    binary = str(Path(binary).resolve())
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(count):
            boxes, known, ends = problem(KINDS[number % 4], rng, arm)
            (folder / "cell.toml").write_text(cell_text(boxes))
            start, goal = (",".join(repr(float(x)) for x in end) for end in ends)
            answer = subprocess.run(
                [binary, "plan", f"--from={start}", f"--to={goal}", "--cell", "cell.toml", "--margin", str(MARGIN),
                 "--seed", str(number), "--format", "json"],
                cwd=folder, capture_output=True, text=True,
            ).stdout
            answer = json.loads(answer or '{"ok": false}')
            ours.append(answer if answer["ok"] else None)
            found = with_ompl(known, ends, number)
            if found is None:
                theirs.append(None)
                continue
            points, took = found
            length = sum(float(np.linalg.norm(b - a)) for a, b in zip(points, points[1:]))
            theirs.append({"length": length, "planning_time": took, "time": driven(binary, folder, points)})
    both = [(a, b) for a, b in zip(ours, theirs) if a and b]
    lengths = [a["length"] / b["length"] for a, b in both]
    times = [a["time"] / b["time"] for a, b in both if b["time"]]
    planning = sorted(a["planning_time"] for a in ours if a)
    print(f"{count} scenes: solved {sum(map(bool, ours))} here, {sum(map(bool, theirs))} by OMPL in {TIME} s; "
          f"median length {statistics.median(lengths):.3f} of OMPL's, driven time {statistics.median(times):.3f}; "
          f"planning p50 {planning[len(planning) // 2]:.2f} s, p95 {planning[int(len(planning) * 0.95)]:.2f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 200))
