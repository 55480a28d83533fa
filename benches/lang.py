"""Times the language against CPython: the same scripts on both, alternating, user time of the whole process.

    python3 benches/lang.py RUNNER [FOLDER] [--rounds N]

RUNNER runs a script file, for example target/release/examples/run (cargo build --release -p elite-lang --examples).
FOLDER holds the scripts (*.py); each prints a line that starts with "checksum", which must be the same on both.
Figures are the least user times of all rounds; only their ratio means anything.
"""

import argparse
import math
import pathlib
import resource
import subprocess
import sys


def user_seconds(command):
    """User CPU seconds of a command, and its checksum line."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    lines = [line for line in done.stdout.splitlines() if line.startswith("checksum")]
    if done.returncode != 0 or not lines:
        sys.exit(f"{' '.join(command)} failed: {done.stderr.strip() or done.stdout.strip()}")
    return seconds, lines[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runner")
    parser.add_argument("folder", nargs="?", default=pathlib.Path(__file__).parent / "lang", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args()
    scripts = sorted(args.folder.glob("*.py"))
    if not scripts:
        sys.exit(f"no scripts in {args.folder}")
    ratios = []
    print(f"{'script':<20} {'CPython s':>10} {'ours s':>10} {'ratio':>7}")
    for script in scripts:
        theirs, ours = [], []
        for _ in range(args.rounds):
            seconds, expected = user_seconds([sys.executable, str(script)])
            theirs.append(seconds)
            seconds, found = user_seconds([args.runner, str(script)])
            ours.append(seconds)
            if expected != found:
                sys.exit(f"{script.name}: {found!r}, CPython says {expected!r}")
        ratio = min(ours) / min(theirs)
        ratios.append(ratio)
        print(f"{script.name:<20} {min(theirs):>10.3f} {min(ours):>10.3f} {ratio:>7.2f}")
    mean = math.exp(sum(map(math.log, ratios)) / len(ratios))
    print(f"{'geometric mean':<42} {mean:>7.2f}    worst {max(ratios):.2f}")


if __name__ == "__main__":
    main()
