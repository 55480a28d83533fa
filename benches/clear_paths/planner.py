"""Planned paths of the product against RRT-Connect of OMPL (PyPI) with the collision checks of coal,
on generated scenes.

    benches/clear_paths/run.sh planner [COUNT] [ROWS.jsonl]

A scene has a start and a goal between which the straight way is not free, one of them near an obstacle. OMPL has 5 s
for the search and 2 s for its shortcutting; its program has the same speeds and stops at every corner, because nothing
tells how large a blend may be. Rows of single scenes go to the file, if one is named;
Ctrl-C ends with what has been measured.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from ompl import base as ob, geometric as og, util as ou

from arm import KINDS, Arm, cell_text, scene
from quick_scene import QuickScene, check_alike

MARGIN = 0.01
TIME = 5.0
SIMPLIFY_TIME = 2.0
#: Steps in which OMPL looks along a line, rad.
STEP = 0.02
#: A start and a goal are looked for this often in one cell; then another one is made.
SAMPLES = 4000


def problem(kind, rng, arm):
    """A cell with a start and a goal that keep the margin, on different sides of something."""
    while True:
        boxes = scene(kind, rng)
        check_alike(arm, boxes, rng)
        known = QuickScene(arm, boxes)
        near = None
        for _ in range(SAMPLES):
            q = rng.uniform([-2.5, -2.6, 0.3, -2.8, -2.0, 0.0], [2.5, -0.4, 2.4, 0.2, 0.5, 0.0])
            if not known.is_clear(q, MARGIN + 0.005):
                continue
            # One end in the obstacle's neighbourhood, the other anywhere.
            if near is None:
                near = q if known.nearest(q) <= 0.06 else None
            elif np.linalg.norm(near - q) > 1.0 and not is_straight_clear(known, near, q):
                return boxes, known, [near, q]


def is_straight_clear(known, start, goal):
    return all(known.is_clear(start + (goal - start) * k / 60, MARGIN) for k in range(61))


def with_ompl(known, ends, seed, limits):
    """The points of OMPL's path and how long it took to find and to shorten, s."""
    space = ob.RealVectorStateSpace(6)
    bounds = ob.RealVectorBounds(6)
    for joint in range(6):
        bounds.setLow(joint, float(max(min(end[joint] for end in ends) - np.pi, limits[0][joint])))
        bounds.setHigh(joint, float(min(max(end[joint] for end in ends) + np.pi, limits[1][joint])))
    space.setBounds(bounds)
    setup = og.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: known.is_clear([state[k] for k in range(6)], MARGIN))
    setup.getSpaceInformation().setStateValidityCheckingResolution(STEP / space.getMaximumExtent())
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
    found = time.process_time()
    if not solved or not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution(SIMPLIFY_TIME)
    shortened = time.process_time()
    path = setup.getSolutionPath()
    points = [np.array([path.getState(i)[k] for k in range(6)]) for i in range(path.getStateCount())]
    return points, found - begun, shortened - found


def driven(eliteserver, folder, points):
    """How long a program of these points without blends takes, simulated s."""
    lines = "".join(f"movej({json.dumps([float(x) for x in q])}, a=1.4, v=1.05)\n" for q in points[1:])
    (folder / "theirs.script").write_text(f"import time\nbegun = time.time()\n{lines}print(time.time() - begun)\n")
    home = ",".join(repr(float(x)) for x in points[0])
    out = subprocess.run(
        [eliteserver, "run", "theirs.script", f"--home={home}", "--plant", "ideal"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    return float(out.stdout.split()[-1]) if out.returncode == 0 else None


def planned(eliteserver, folder, ends, seed):
    """The answer of the product, with the processor time of the whole command, start and driving included, s."""
    start, goal = (",".join(repr(float(x)) for x in end) for end in ends)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    answer = subprocess.run(
        [
            eliteserver,
            "plan",
            f"--from={start}",
            f"--to={goal}",
            "--cell",
            "cell.toml",
            "--margin",
            str(MARGIN),
            "--seed",
            str(seed),
            "--format",
            "json",
        ],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    row = json.loads(answer.stdout) if answer.stdout else {"ok": False, "detail": answer.stderr}
    row["processor"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return row


def of_scene(eliteserver, folder, number, arm):
    """A row: what both say of one scene."""
    kind = KINDS[number % len(KINDS)]
    boxes, known, ends = problem(kind, np.random.default_rng([47, number]), arm)
    (folder / "cell.toml").write_text(cell_text(boxes))
    here = planned(eliteserver, folder, ends, number)
    row = {
        "number": number,
        "kind": kind,
        "ends": [end.tolist() for end in ends],
        "cell": cell_text(boxes),
        "here": here,
        "ompl": None,
    }
    found = with_ompl(known, ends, number, arm.limits())
    if found is not None:
        points, search, shortcutting = found
        length = sum(float(np.linalg.norm(b - a)) for a, b in zip(points, points[1:]))
        row["ompl"] = {
            "length": length,
            "search": search,
            "shortcutting": shortcutting,
            "corners": len(points) - 2,
            "time": driven(eliteserver, folder, points),
        }
    return row


def quantile(values, share):
    return float(np.quantile(values, share)) if values else float("nan")


def tell(rows, name):
    """One line about these scenes."""
    ours = [row["here"] for row in rows if row["here"]["ok"]]
    theirs = [row["ompl"] for row in rows if row["ompl"]]
    both = [(row["here"], row["ompl"]) for row in rows if row["here"]["ok"] and row["ompl"]]
    lengths = [a["length"] / b["length"] for a, b in both]
    times = [a["time"] / b["time"] for a, b in both if b["time"]]
    planning, processor, search = (
        [one[key] for one in of] for key, of in (("planning_time", ours), ("processor", ours), ("search", theirs))
    )
    print(
        f"{name:6} {len(rows):4} scenes: solved {len(ours)} here, {len(theirs)} by OMPL in {TIME:.0f} s; "
        f"length {quantile(lengths, 0.5):.3f} of OMPL's (p95 {quantile(lengths, 0.95):.2f}), "
        f"driven time {quantile(times, 0.5):.3f} (p95 {quantile(times, 0.95):.2f}); planning p50 "
        f"{quantile(planning, 0.5):.2f} s, "
        f"p95 {quantile(planning, 0.95):.2f} s, processor time of the command p50 {quantile(processor, 0.5):.2f} s, "
        f"p95 {quantile(processor, 0.95):.2f} s; OMPL's search p50 {quantile(search, 0.5):.2f} s, p95 "
        f"{quantile(search, 0.95):.2f} s",
        flush=True,
    )


def main(eliteserver, count, rows_file):
    arm, rows = Arm(), []
    ou.setLogLevel(ou.LOG_WARN)
    ou.RNG.setSeed(47)
    eliteserver = str(Path(eliteserver).resolve())
    with tempfile.TemporaryDirectory() as folder, open(rows_file or "/dev/null", "w") as out:
        try:
            for number in range(count):
                rows.append(of_scene(eliteserver, Path(folder), number, arm))
                out.write(json.dumps(rows[-1]) + "\n")
                out.flush()
        except KeyboardInterrupt:
            pass
    for kind in KINDS:
        tell([row for row in rows if row["kind"] == kind], kind)
    tell(rows, "all")
    return 0


if __name__ == "__main__":
    sys.exit(
        main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 200, sys.argv[3] if len(sys.argv) > 3 else None)
    )
