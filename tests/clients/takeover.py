"""How long a main program takes to follow another: from the write of its text to port 30001 to its first log line.

    ELITESERVER=target/release/eliteserver python3 tests/clients/takeover.py [TRIALS]

The first program is busy, moves the arm, or refuses to leave its `finally` block. Prints milliseconds.
"""

import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time
from datetime import datetime

TRIALS = int(sys.argv[1]) if len(sys.argv) > 1 else 20
BINARY = os.environ.get("ELITESERVER", "target/debug/eliteserver")
FINALLY = "try:\n    while True:\n        sleep(0.01)\nfinally:\n    while True:\n        "
FIRST = {
    "a busy loop": "while True:\n    pass\n",
    "a moving arm": (
        "while True:\n    movej([0, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=1)\n"
        "    movej([1, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=1)\n"
    ),
    "`finally` that computes": FINALLY + "[i for i in range(100)]\n",
    "`finally` that asks the robot": FINALLY + "get_actual_tcp_pose()\n",
    "`finally` that sorts": FINALLY + "sorted(range(1000000))\n",
}


def main() -> None:
    folder = pathlib.Path(tempfile.mkdtemp())
    ready = folder / "ready.json"
    log = folder / "log"
    ports = [f"--{name}-port=0" for name in ("primary", "interpreter", "rtsi", "dashboard", "modbus", "http")]
    command = [BINARY, "serve", *ports, "--record", "off", "--ready-file", ready, "--plant", "ideal"]
    with log.open("wb") as stderr, subprocess.Popen(command, stderr=stderr) as server:
        while not ready.exists():
            time.sleep(0.05)
        port = json.loads(ready.read_text())["ports"]["primary"]

        def send(text: str) -> socket.socket:
            peer = socket.create_connection(("127.0.0.1", port))
            peer.sendall(text.encode())
            peer.shutdown(socket.SHUT_WR)
            return peer

        for name, first in FIRST.items():
            took = []
            for trial in range(TRIALS):
                peers = [send(first)]
                time.sleep(0.5)
                sign = f"second program {len(took)} after {name}"
                begin = time.time()
                peers.append(send(f"textmsg({sign!r})\nsleep(0.1)\n"))
                time.sleep(0.8)
                said = re.search(r"(\S+Z)[^\n]*script: " + re.escape(sign), log.read_text())
                assert said, f"trial {trial}: the second program did not begin within 0.8 s"
                took.append(1000 * (datetime.fromisoformat(said[1]).timestamp() - begin))
                for peer in peers:
                    peer.close()
            took.sort()
            print(f"{name}: p50 {took[len(took) // 2]:.1f} ms, max {took[-1]:.1f} ms of {TRIALS}")
        server.terminate()


main()
