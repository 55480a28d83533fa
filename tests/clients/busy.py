"""How long a client of a busy machine waits.

    python3 tests/clients/busy.py [busy processes] [seconds] [options of serve]

Beside so many processes that only compute, a client asks the dashboard every 10 ms, and a program sends back every
packet that it gets through a socket, every 4 ms. The client itself goes before the others, so that what is measured is
the server. Prints the waits in ms: how many there were, median, 99 of 100, longest, and how many were longer than 100
ms, after which a driver may end external control. Needs a user who may set priorities.
"""

import multiprocessing
import os
import socket
import statistics
import struct
import sys
import threading
import time

from elite import Dashboard, Primary
from server import Server

ECHO = """def echo():
\tsocket_open("127.0.0.1", {port}, "echo")
\twhile True:
\t\tvalues = socket_read_binary_integer(8, "echo", 0)
\t\tif values[0] != 8:
\t\t\treturn
\t\tend
\t\tsocket_send_int(values[1], "echo")
\tend
end
"""


def compute():
    while True:
        sum(range(10000))


def favoured():
    """This thread goes before everything but the control cycle."""
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))


def every(period, seconds, action):
    """How long the action took each time, ms."""
    favoured()
    waits = []
    begin = time.monotonic()
    due = begin
    while due - begin < seconds:
        time.sleep(max(0.0, due - time.monotonic()))
        asked = time.monotonic()
        action()
        waits.append((time.monotonic() - asked) * 1e3)
        # What was missed meanwhile is not caught up with.
        due = max(due + period, time.monotonic())
    return waits


def tell(name, waits):
    waits.sort()
    longest = sum(wait > 100 for wait in waits)
    print(
        f"{name}: {len(waits)}, median {statistics.median(waits):.2f}, 99 of 100 {waits[len(waits) * 99 // 100]:.2f}, "
        f"longest {waits[-1]:.1f}, over 100 ms {longest}"
    )


def main():
    busy = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 20
    with Server(*sys.argv[3:]) as server:
        listener = socket.create_server(("127.0.0.1", 0))
        primary = Primary(server.ports["primary"])
        primary.send_script(ECHO.format(port=listener.getsockname()[1]))
        echo, _ = listener.accept()
        echo.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        dashboard = Dashboard(server.ports["dashboard"])
        others = [multiprocessing.Process(target=compute, daemon=True) for _ in range(busy)]
        for other in others:
            other.start()
        time.sleep(1)

        def packet():
            echo.sendall(struct.pack(">8i", *range(8)))
            got = b""
            while len(got) < 4:
                got += echo.recv(4 - len(got))

        found = {}
        threads = [
            threading.Thread(target=lambda: found.update(script=every(0.004, seconds, packet))),
            threading.Thread(
                target=lambda: found.update(dashboard=every(0.01, seconds, lambda: dashboard.ask("robotMode")))
            ),
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for other in others:
            other.terminate()
        tell("script's socket", found["script"])
        tell("dashboard", found["dashboard"])


if __name__ == "__main__":
    main()
