"""How soon SIGINT reaches a program: `ELITESERVER=… python3 tests/clients/signal_latency.py [trials]`.

From the signal until the program's `finally` block prints; p50, p99 and the largest of all trials, in ms.
"""

import os
import pathlib
import signal
import statistics
import subprocess
import sys
import tempfile
import time

SITUATIONS = {
    "busy loop": "pass",
    "sleep": "sleep(100)",
    "movej": "movej([2, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=1, v=0.2)",
}


def trial(binary, body, folder):
    path = pathlib.Path(folder) / "program.script"
    path.write_text(f"try:\n    print('begun')\n    while True:\n        {body}\nfinally:\n    print('ended')\n")
    command = [binary, "run", "--clock", "realtime", str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout.readline() == b"begun\n"
        time.sleep(0.05)
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == b"ended\n"
        return (time.monotonic() - start) * 1e3


def main():
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    binary = os.environ.get("ELITESERVER", "target/release/eliteserver")
    with tempfile.TemporaryDirectory() as folder:
        for name, body in SITUATIONS.items():
            times = sorted(trial(binary, body, folder) for _ in range(trials))
            p99 = times[min(trials - 1, round(0.99 * trials))]
            print(f"{name}: p50 {statistics.median(times):.2f}, p99 {p99:.2f}, max {times[-1]:.2f} ms")


if __name__ == "__main__":
    main()
