"""Times a fleet: start until all robots are ready, then late and missing cycles, processor time and memory of N robots.

    python3 benches/fleet.py target/release/eliteserver --robots 20 --seconds 20 [--plant rigid] [--move]

`--move` has every robot run a program that moves without end. Linux; ports of 127.0.60.0/24.
"""

import argparse
import json
import os
import re
import signal
import socket
import subprocess
import tempfile
import time
import urllib.request

PAGE = 18097
PROGRAM = (
    "def wave():\n    while True:\n        movej([0.5, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n"
    "        movej([-0.5, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\nend\n"
)


def page(path):
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{PAGE}{path}", timeout=20) as answer:
            return answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.read().decode()
    except OSError:
        return "{}"


def samples(text, name):
    return [float(value) for value in re.findall(rf"^{name}{{[^}}]*}} (\S+)$", text, re.M)]


def processor(pids):
    ticks = 0
    for pid in pids:
        fields = open(f"/proc/{pid}/stat").read().rsplit(")", 1)[1].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binary")
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--plant", default="rigid")
    parser.add_argument("--move", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/fleet.toml", "w") as file:
            file.write(f'http-port = {PAGE}\n[defaults]\nplant = "{given.plant}"\nrecord = "off"\n')
            for number in range(given.robots):
                file.write(f'[[robot]]\nname = "r{number}"\nbind = "127.0.60.{11 + number}"\n')
        begun = time.perf_counter()
        fleet = subprocess.Popen(
            [os.path.abspath(given.binary), "fleet", "fleet.toml"], cwd=folder, stderr=subprocess.DEVNULL
        )
        try:
            ready = set()
            while len(ready) < given.robots:
                for number in range(given.robots):
                    if number not in ready and os.path.exists(f"{folder}/fleet/r{number}/ready.json"):
                        ready.add(number)
                time.sleep(0.002)
            print(f"{given.robots} robots ready after {1000 * (time.perf_counter() - begun):.0f} ms")
            while json.loads(page("/healthz")).get("status") != "ok":
                time.sleep(0.05)
            if given.move:
                for number in range(given.robots):
                    with socket.create_connection((f"127.0.60.{11 + number}", 30001)) as port:
                        port.sendall(PROGRAM.encode())
                        time.sleep(0.05)
            pids = [robot["pid"] for robot in json.loads(page("/healthz"))["robots"].values()]
            before, used, since = page("/metrics"), processor(pids), time.perf_counter()
            time.sleep(given.seconds)
            after, took = page("/metrics"), time.perf_counter() - since
            used = processor(pids) - used
            cycles = sum(samples(after, "elite_cycles_total")) - sum(samples(before, "elite_cycles_total"))
            for what, name in [("late", "elite_cycle_overruns_total"), ("missing", "elite_cycles_missed_total")]:
                count = sum(samples(after, name)) - sum(samples(before, name))
                print(f"{what} cycles: {count:.0f} of {cycles:.0f}")
            print(
                f"processor time: {100 * used / took / given.robots:.1f} % of a core a robot, "
                f"{given.robots * 100 / max(100 * used / took, 1e-9):.1f} robots a core by that"
            )
            memory = samples(after, "\\w+_fleet_robot_resident_bytes")
            print(f"memory: {sum(memory) / len(memory) / 1e6:.0f} MB a robot")
        finally:
            fleet.send_signal(signal.SIGTERM)
            fleet.wait(30)


if __name__ == "__main__":
    main()
