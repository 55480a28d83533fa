"""Durations of movej against the public Python package `ruckig`.

`ELITE_MOVEJ_CSV=movej.csv cargo test -p motion --test programs` writes one line a movej: way of the leading joint, speed,
acceleration, jerk, length of a cycle, duration. Then, with `pip install ruckig==0.15.3`:

    python3 tests/peers/ruckig_durations.py movej.csv

A movej may take 1.001 times the time-optimal duration and one cycle more. Exit status 1 when one takes longer.
"""

import csv
import sys

from ruckig import InputParameter, Result, Ruckig, Trajectory


def optimal(way: float, speed: float, acceleration: float, jerk: float) -> float:
    """The time-optimal duration of one joint from rest to rest, s."""
    asked = InputParameter(1)
    asked.target_position = [way]
    asked.max_velocity = [speed]
    asked.max_acceleration = [acceleration]
    asked.max_jerk = [jerk]
    planned = Trajectory(1)
    if Ruckig(1).calculate(asked, planned) not in (Result.Working, Result.Finished):
        raise RuntimeError(f"no plan for {way} at {speed}, {acceleration}, {jerk}")
    return planned.duration


def main(path: str) -> int:
    """Compares every line of the file."""
    compared, late, most = 0, 0, 0.0
    with open(path, newline="") as lines:
        for row in csv.reader(lines):
            way, speed, acceleration, jerk, cycle, took = map(float, row)
            least = optimal(way, speed, acceleration, jerk)
            over = (took - least) / cycle
            most = max(most, over)
            compared += 1
            if took > 1.001 * least + cycle + 1e-6:
                late += 1
                print(f"{took} s instead of {least} s: {row}")
    print(f"{compared} movej, at most {most:.3f} cycles longer than optimal, {late} too long")
    return 1 if late or not compared else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
