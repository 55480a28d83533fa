"""The base pose of `eliteserver place` beside all of a grid of 10,000, judged with the URDF and coal,
without the product's help.

    benches/clear_paths/run.sh place [COUNT]

Every request has a cell and five TCP poses; every fourth one lets the base turn (a grid of 29 x 29 places and 12
turns), the others not (100 x 100). Every eighth has a pose that cannot be reached. `place` has to be at least as far
from the ends of the joints' ranges as the best of the grid, and what it says of its base pose has to be true. Ends with
status 1 where it is not.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from arm import KINDS, TOOL, Arm, cell_text, scene, transform
from inverse import Inverse
from quick_scene import QuickScene

MARGIN = 0.01
AREA = (-0.5, 0.5, -0.5, 0.5)
TCP = transform([0, 0, TOOL[1][1]], [0, 0, 0])
#: How much worse than the grid's best the answer may be, rad: the last step of its search.
WORSE = 1e-3


class Judge:
    """Base poses of one request."""

    def __init__(self, arm, boxes, points):
        self.inverse = Inverse(arm)
        self.low, self.high = arm.limits()
        self.boxes, self.points = boxes, points
        self.scene = QuickScene(arm, boxes)

    def branches(self, bases):
        """Joint positions of every base pose and point (N, points, 8, 6) and their joint margins (N, points, 8)."""
        flange = np.linalg.inv(bases)[:, None] @ np.array(self.points)[None] @ np.linalg.inv(TCP)
        q = self.inverse(flange.reshape(-1, 4, 4)).reshape(len(bases), len(self.points), 8, 6)
        middle = (self.low + self.high) / 2
        q = q - 2 * np.pi * np.round((q - middle) / (2 * np.pi))
        margins = np.minimum(q - self.low, self.high - q).min(axis=-1)
        return q, np.where(margins >= 0, margins, -np.inf)

    def joint_margin(self, base, q, margins):
        """The least joint margin of a base pose with the best branch that keeps clear at every point;
        -inf where one has none."""
        self.scene.stand_at(base)
        least = np.inf
        for point in range(len(self.points)):
            for branch in np.argsort(-margins[point], kind="stable"):
                if np.isinf(margins[point, branch]):
                    return -np.inf
                if self.scene.is_clear(q[point, branch], MARGIN):
                    least = min(least, margins[point, branch])
                    break
            else:
                return -np.inf
        return least

    def best(self, bases):
        """The number of the best base pose, its joint margin and how many were looked at with their cell."""
        q, margins = self.branches(bases)
        # No branch is better than the best that ignores the cell: what cannot win is not looked at.
        bounds = margins.max(axis=2, initial=-np.inf).min(axis=1)
        best, looked = (-1, -np.inf), 0
        for number in np.argsort(-bounds, kind="stable"):
            if bounds[number] <= best[1]:
                break
            looked += 1
            found = self.joint_margin(bases[number], q[number], margins[number])
            if found > best[1]:
                best = (number, found)
        return *best, looked


def request(kind, rng, arm):
    """A cell and five TCP poses, the tool looking down within 0.4 rad, which can all be reached from somewhere."""
    while True:
        boxes, points = scene(kind, rng), []
        base = transform([*rng.uniform(-0.3, 0.3, 2), 0], [0, 0, 0])
        for _ in range(300):
            xyz = [float(rng.uniform(0.2, 0.7)), float(rng.uniform(-0.4, 0.4)), float(rng.uniform(0.12, 0.5))]
            rpy = [np.pi + float(rng.uniform(-0.4, 0.4)), float(rng.uniform(-0.4, 0.4)), float(rng.uniform(-3, 3))]
            judge = Judge(arm, boxes, [transform(xyz, rpy)])
            q, margins = judge.branches(base[None])
            if judge.joint_margin(base, q[0], margins[0]) > 0:
                points.append((xyz, rpy))
            if len(points) == 5:
                return boxes, points


def grid(turns):
    side = 100 if turns == 1 else 29
    return np.array(
        [
            transform([x, y, 0], [0, 0, yaw])
            for yaw in np.arange(turns) * 2 * np.pi / turns
            for x in np.linspace(*AREA[:2], side)
            for y in np.linspace(*AREA[2:], side)
        ]
    )


def answer_of(eliteserver, folder, boxes, points, turns):
    (folder / "cell.toml").write_text(cell_text(boxes))
    (folder / "points.txt").write_text("".join(" ".join(map(repr, xyz + rpy)) + "\n" for xyz, rpy in points))
    area = ",".join(map(str, AREA))
    tcp = ",".join(map(str, [*TCP[:3, 3], 0, 0, 0]))
    call = [
        eliteserver,
        "place",
        "--points",
        "points.txt",
        "--cell",
        "cell.toml",
        f"--area={area}",
        f"--tcp={tcp}",
        "--margin",
        str(MARGIN),
        "--format",
        "json",
        *(["--yaw"] if turns > 1 else []),
    ]
    out = subprocess.run(call, cwd=folder, capture_output=True, text=True)
    return json.loads(out.stdout) if out.stdout else sys.exit(out.stderr)


def main(eliteserver, count):
    arm, eliteserver = Arm(), str(Path(eliteserver).resolve())
    wrong, ahead, none, took = 0, [], 0, []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            turns = 12 if number % 4 == 3 else 1
            boxes, points = request(KINDS[number // 4 % len(KINDS)], np.random.default_rng([48, number]), arm)
            if number % 8 == 7:
                # Nothing reaches this one.
                points[2][0][2] = 1.6
            judge = Judge(arm, boxes, [transform(xyz, rpy) for xyz, rpy in points])
            begun = time.perf_counter()
            answer = answer_of(eliteserver, Path(folder), boxes, points, turns)
            took.append(time.perf_counter() - begun)
            bases = grid(turns)
            at, best, looked = judge.best(bases)
            if "x" not in answer:
                none += 1
                alike = np.isinf(best)
                told = f"no base pose, points {answer['points']} fail"
            else:
                base = transform([answer["x"], answer["y"], 0], [0, 0, answer["yaw"]])[None]
                q, margins = judge.branches(base)
                true = judge.joint_margin(base[0], q[0], margins[0])
                ahead.append(true - best)
                alike = true >= best - WORSE and abs(true - answer["joint_margin"]) < 1e-6
                told = f"joint margin {answer['joint_margin']:.4f} rad (judged {true:.4f})"
            wrong += not alike
            print(
                f"{number:3} {turns:2} turns: {told}; best of the grid {best:.4f}, {len(bases)} poses, {looked} with "
                "their cell"
                f"{'' if alike else '   DIFFERS'}",
                flush=True,
            )
    finite = [one for one in ahead if np.isfinite(one)]
    print(
        f"{count} requests: {wrong} differ; {none} without a base pose here; ahead of the grid by "
        f"{min(finite, default=0):.5f} to "
        f"{max(finite, default=0):.5f} rad; {np.median(took):.2f} s each, at most {max(took):.2f} s"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 16))
