"""Durations of movej from rest to rest against PyPI `ruckig`, an independent time-optimal planner.

    ELITE_PROGRAMS=500 tests/peers/movej.sh

A movej is a straight line in joint space, so the oracle plans one axis, the way of the leading joint, under the limits
that the line leaves it: what the script asked, and each joint's own limits divided by its share of the way. By default
an acceleration is reached in 30 ms. Beside it the oracle for six free joints that arrive together: not bound to the
line it can be faster where different joints set the limits. Exit 1 when one motion takes more than 1.001 times the
first, and a cycle.
"""

import csv
import statistics
import sys

from ruckig import InputParameter, Result, Ruckig, Synchronization, Trajectory

RISE = 0.030  # s, the default time in which an acceleration is reached


def duration(way, speed, acceleration, jerk, synchronization=Synchronization.Time):
    """Time from rest to rest, s, for joints that go `way` under limits of their own."""
    count = len(way)
    parameters = InputParameter(count)
    parameters.target_position = way
    parameters.max_velocity = speed
    parameters.max_acceleration = acceleration
    parameters.max_jerk = jerk
    parameters.synchronization = synchronization
    trajectory = Trajectory(count)
    result = Ruckig(count).calculate(parameters, trajectory)
    if result not in (Result.Working, Result.Finished):
        raise SystemExit(f"the oracle fails with {result}: {way} {speed} {acceleration} {jerk}")
    return trajectory.duration


def compare(row):
    """Taken, oracle on the line, oracle of free joints, length of a cycle; all s."""
    step, numbers = float(row[1]), [float(x) for x in row[2:]]
    way, (speed, acceleration), (own_speed, own_acceleration, own_jerk), taken = (
        numbers[:6],
        numbers[6:8],
        (numbers[8:14], numbers[14:20], numbers[20:26]),
        numbers[26],
    )
    lead = max(abs(x) for x in way)
    moving = [j for j in range(6) if abs(way[j]) > 1e-12]

    def on_line(own):
        return min(own[j] * lead / abs(way[j]) for j in moving)

    v = min(speed, on_line(own_speed))
    a = min(acceleration, on_line(own_acceleration))
    j = min(a / RISE, on_line(own_jerk))
    line = duration([lead], [v], [a], [j])
    free = duration(
        [way[k] for k in moving],
        [min(speed, own_speed[k]) for k in moving],
        [min(acceleration, own_acceleration[k]) for k in moving],
        [min(min(acceleration, own_acceleration[k]) / RISE, own_jerk[k]) for k in moving],
    )
    return taken, line, free, step


def main():
    with open(sys.argv[1], newline="") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise SystemExit(f"{sys.argv[1]} has no motions")
    compared = [compare(row) for row in rows]
    late = [(row, c) for row, c in zip(rows, compared) if c[0] > 1.001 * c[1] + c[3] + 1e-9]
    early = [(row, c) for row, c in zip(rows, compared) if c[0] < c[1] - 1e-9]
    excess = [(taken - line) / step for taken, line, _, step in compared]
    ratio = [taken / free for taken, _, free, _ in compared]
    print(
        f"{len(rows)} movej; cycles over the optimum on the line: median {statistics.median(excess):.2f}, largest "
        f"{max(excess):.2f}"
    )
    print(f"duration over that of six free joints: median {statistics.median(ratio):.4f}, largest {max(ratio):.4f}")
    for row, (taken, line, _, step) in late[:5]:
        print(f"late: {row[0]} took {taken:.4f} s, optimum {line:.4f} s, cycle {step} s: {row}")
    for row, (taken, line, _, _) in early[:5]:
        print(f"faster than the optimum: {row[0]} took {taken:.6f} s, optimum {line:.6f} s: {row}")
    sys.exit(1 if late or early else 0)


if __name__ == "__main__":
    main()
