"""How much shorter `eliteserver optimize` makes the cycles of five programs, with checks that they still do the same.

    benches/clear_paths/run.sh optimize

Every faster program is run again, with its cell: it has to print what the old one prints, its outputs have to change in
the same order, every part has to be let go where the old program lets it go, and kept lines have to be there as they
were. Ends with status 1 where one is not.
"""

import csv
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OWN = Path(__file__).resolve().parent / "programs"
CELLS = ROOT / "examples" / "cells"
MARGIN = 0.005
#: Let go within this is let go at the same place, m.
SAME_PLACE = 0.005
#: Name, program, cell, kept lines.
PROGRAMS = [
    ("pick and place", OWN / "pick_and_place.script", OWN / "pick_and_place.toml", []),
    ("palletising", ROOT / "examples/palletising/palletise.script", ROOT / "examples/palletising/cell.toml", []),
    ("tending", CELLS / "tending/tend.script", CELLS / "tending/cell.toml", []),
    ("dispensing, beads kept", OWN / "dispensing.script", OWN / "dispensing.toml", [(25, 27), (38, 38)]),
    ("belt picking", CELLS / "belt/pick.script", CELLS / "belt/cell.toml", []),
]


def call(*arguments, folder):
    return subprocess.run([str(a) for a in arguments], cwd=folder, capture_output=True, text=True)


def effects(eliteserver, program, cell, folder):
    """What a run prints, how its outputs change, and where which part is let go."""
    ran = call(eliteserver, "run", program, "--cell", cell, "--plant", "ideal", "--record", "x.mcap", folder=folder)
    if ran.returncode:
        raise SystemExit(f"{program}: {ran.stderr}")
    outputs, released, holder = [], [], {}
    for row in csv.DictReader(
        call(eliteserver, "replay", "x.mcap", "--csv", "/cycle", folder=folder).stdout.splitlines()
    ):
        if not outputs or outputs[-1] != row["digital_out"]:
            outputs.append(row["digital_out"])
    for row in csv.DictReader(
        call(eliteserver, "replay", "x.mcap", "--csv", "/world", folder=folder).stdout.splitlines()
    ):
        name, by = row["name"], row["held_by"]
        if holder.get(name) and not by:
            released.append((name, [float(row[axis]) for axis in "xyz"]))
        holder[name] = by
    return ran.stdout, outputs, released


def differences(before, after):
    """What two runs do not have in common."""
    found = []
    without_numbers = [re.sub(r"\d", "", run[0]) for run in (before, after)]
    if without_numbers[0] != without_numbers[1]:
        found.append("prints")
    if before[1] != after[1]:
        found.append("outputs")
    names = [[name for name, _ in run[2]] for run in (before, after)]
    away = [max(abs(a - b) for a, b in zip(p, q)) for (_, p), (_, q) in zip(before[2], after[2])]
    if names[0] != names[1] or any(distance > SAME_PLACE for distance in away):
        found.append(f"parts let go ({names[0]} and {names[1]}, up to {max(away, default=0) * 1e3:.1f} mm apart)")
    return found


def main(eliteserver):
    eliteserver, wrong = str(Path(eliteserver).resolve()), 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name, program, cell, kept in PROGRAMS:
            keep = [word for first, last in kept for word in ("--keep", f"{first}-{last}")]
            out = call(
                eliteserver,
                "optimize",
                program,
                "--cell",
                cell,
                "--margin",
                MARGIN,
                *keep,
                "-o",
                "fast.script",
                folder=folder,
            )
            said = re.search(
                r"cycle time ([\d.]+) s before, ([\d.]+) s after: ([\d.]+) % shorter \(simulated runs: (\d+)\)",
                out.stderr,
            )
            if out.returncode or not said:
                print(f"{name:24} {out.stderr.strip()}")
                wrong += 1
                continue
            old, new = program.read_text().splitlines(), (folder / "fast.script").read_text().splitlines()
            found = differences(*(effects(eliteserver, one, cell, folder) for one in (program, folder / "fast.script")))
            if any(line not in new for first, last in kept for line in old[first - 1 : last]):
                found.append("kept lines")
            near = [
                json.loads(
                    call(
                        eliteserver, "clearance", one, "--cell", cell, "--format", "json", folder=folder
                    ).stdout.splitlines()[-1]
                )["distance"]
                for one in (program, folder / "fast.script")
            ]
            if near[0] is not None and near[1] < min(MARGIN, near[0]) - 1e-4:
                found.append(f"least distance {near[1] * 1e3:.1f} mm")
            wrong += bool(found)
            before, after, share, runs = said.groups()
            print(
                f"{name:24} {before:>8} s before, {after:>8} s after: {share:>5} % shorter, {runs} "
                f"runs{'; DIFFERS: ' + ', '.join(found) if found else ''}",
                flush=True,
            )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
