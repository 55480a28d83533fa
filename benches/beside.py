"""Two builds of the program beside one another: cycles of a moving robot,
user time of the language's scripts, in turns.

    python3 benches/beside.py STATIC OTHER [--seconds 20] [--rounds 3] [--scripts FOLDER]

Of the cycles it prints the time in the tick and the lateness of the wake-up as `serve` records them (rigid plant, 4
ms), with overruns and missing cycles; of the scripts (*.py, each prints a line that starts with "checksum") the least
user time of all rounds of `run`, less that of an empty script: the command of the wheel has Python to start. Only
ratios, the first over the second, mean anything on a machine that does something else as well.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import time

from lang import user_seconds

PROGRAM = """def wave():
    while True:
        movej([0.5, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)
        movel(get_forward_kin([0.3, -1.4, 1.5, -1.57, -1.57, 0]), a=1, v=0.3)
        movej([-0.5, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)
end
"""
PORTS = [f"--{name}-port=0" for name in ("primary", "interpreter", "rtsi", "dashboard", "modbus", "http")]
COLUMNS = ("step_duration_us", "wakeup_latency_us")


def cycles(program, seconds):
    """Rows of COLUMNS of a server whose robot moves, and what `replay` says of overruns and missing cycles."""
    with tempfile.TemporaryDirectory() as folder:
        ready = pathlib.Path(folder, "ready.json")
        server = subprocess.Popen(
            [program, "serve", "--record", "x.mcap", "--plant", "rigid", "--ready-file", "ready.json", *PORTS],
            cwd=folder,
            stderr=subprocess.DEVNULL,
        )
        while not ready.exists() or not ready.read_text().strip():
            time.sleep(0.01)
        port = json.loads(ready.read_text())["ports"]
        with socket.create_connection(("127.0.0.1", port["primary"])) as connection:
            connection.sendall(PROGRAM.encode())
            time.sleep(seconds)
        server.send_signal(signal.SIGTERM)
        server.wait()
        said = subprocess.run(
            [program, "replay", "x.mcap", "--csv", "/cycle"], cwd=folder, capture_output=True, text=True, check=True
        )
        rows = [[float(row[name]) for name in COLUMNS] for row in csv.DictReader(said.stdout.splitlines())]
        said = subprocess.run([program, "replay", "x.mcap"], cwd=folder, capture_output=True, text=True, check=True)
        return rows, re.findall(r".*(?:overrun|missing).*", said.stdout)


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("programs", nargs=2)
    parser.add_argument("--scripts", default=pathlib.Path(__file__).parent / "lang", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    programs = [os.path.abspath(program) for program in args.programs]
    print(f"load {os.getloadavg()[0]:.1f}")

    rows, said = [[], []], [[], []]
    for _ in range(args.rounds):
        for number, program in enumerate(programs):
            of, lines = cycles(program, args.seconds)
            rows[number] += of
            said[number] += lines
    for column, name in enumerate(COLUMNS):
        for share in (0.5, 0.99, 1):
            first, second = (percentile([row[column] for row in of], share) for of in rows)
            print(f"{name:<20} p{100 * share:<4.0f} {first:>9.1f} {second:>9.1f} {first / second:>7.2f}")
    print(f"cycles {len(rows[0])} {len(rows[1])}")
    for program, lines in zip(args.programs, said):
        print(program, *sorted(set(lines)), sep="\n    ")

    def least(script):
        """Least user seconds of either program; both print the same."""
        times = [[], []]
        for _ in range(args.rounds):
            found = [user_seconds([program, "run", "--record", "off", str(script)]) for program in programs]
            if found[0][1] != found[1][1]:
                raise SystemExit(f"{script.name}: {found[0][1]!r} and {found[1][1]!r}")
            for number in (0, 1):
                times[number].append(found[number][0])
        return list(map(min, times))

    with tempfile.NamedTemporaryFile("w", suffix=".py") as empty:
        empty.write('print("checksum 0")\n')
        empty.flush()
        start = least(empty.name)
    print(f"{'start':<25} {start[0]:>9.3f} {start[1]:>9.3f}")
    ratios = []
    for script in sorted(args.scripts.glob("*.py")):
        first, second = (time - begin for time, begin in zip(least(script), start))
        ratios.append(first / second)
        print(f"{script.name:<25} {first:>9.3f} {second:>9.3f} {first / second:>7.2f}")
    print(
        f"geometric mean {math.exp(sum(map(math.log, ratios)) / len(ratios)):.3f}, worst {max(ratios):.2f}; "
        f"load {os.getloadavg()[0]:.1f}"
    )


if __name__ == "__main__":
    main()
