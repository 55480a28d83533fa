"""Distances of the product against those of coal (PyPI), on random joint positions in random cells.

benches/clear_paths/run.sh distances [COUNT]
"""

import subprocess
import sys
import time

import numpy as np

from arm import KINDS, Arm, scene
from coal_scene import Scene


def hulls(rng):
    """Two convex pieces, as meshes have them: random corners, some near the arm."""
    pieces = []
    for number in range(2):
        corners = rng.uniform(-1.0, 1.0, (rng.integers(6, 40), 3)) * rng.uniform(0.03, 0.2, 3)
        turn = rng.uniform(-3.0, 3.0)
        place = [0.5 * np.cos(turn), 0.5 * np.sin(turn), rng.uniform(0.1, 0.8), *rng.uniform(-3.0, 3.0, 3)]
        pieces.append((f"hull {number}", "hull", [float(x) for x in corners.ravel()], [float(x) for x in place]))
    return pieces


def main(program, count):
    rng = np.random.default_rng(47)
    arm = Arm()
    low, high = arm.limits()
    cells = []
    for number in range(40):
        boxes = scene(KINDS[number % 4], rng) + hulls(rng)
        text = ";".join(
            f"{name.replace(' ', '_')} {shape} {' '.join(map(repr, size))} {' '.join(map(repr, pose))}"
            for name, shape, size, pose in boxes
        )
        cells.append((text, Scene(arm, boxes)))
    cases = [
        (number % len(cells), rng.uniform(np.maximum(low, -3.2), np.minimum(high, 3.2))) for number in range(count)
    ]
    cases.sort(key=lambda case: case[0])
    lines = "".join(f"{cells[cell][0]}|{' '.join(map(repr, map(float, q)))}\n" for cell, q in cases)
    begun = time.perf_counter()
    answers = subprocess.run([program], input=lines, capture_output=True, text=True, check=True).stdout.splitlines()
    ours_took = time.perf_counter() - begun
    begun = time.perf_counter()
    worst, wrong, overlaps = 0.0, [], 0
    for (cell, q), answer in zip(cases, answers, strict=True):
        distance, a, b = answer.split()
        theirs = cells[cell][1].nearest(q)
        overlaps += theirs[0] < 0
        apart = abs(float(distance) - theirs[0])
        worst = max(worst, apart)
        if apart > 1e-4:
            wrong.append((apart, float(distance), a, b, theirs, list(map(float, q)), cells[cell][0]))
    took = time.perf_counter() - begun
    print(
        f"{count} configurations, {overlaps} of them in collision: largest difference {worst * 1e3:.4f} mm, "
        f"{len(wrong)} above 0.1 mm; {ours_took / count * 1e6:.0f} µs each here, {took / count * 1e6:.0f} µs with coal"
    )
    for entry in sorted(wrong, reverse=True)[:8]:
        print(*entry)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 10_000))
