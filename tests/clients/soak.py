"""Many clients for a long time: `python3 tests/clients/soak.py [seconds] [clients of each kind]`.

Reads, writes, reconnects and sends programs all the while; at the end the server must not have grown, and no cycle and
no package may be missing. An hour is the real thing, a minute shows most of it. Memory is told ten times on the way:
what grows with time goes on growing in the second half, what is taken once does not.
"""

import pathlib
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))

from elite import Dashboard, Primary, Rtsi  # noqa: E402
from server import Server  # noqa: E402

FAULTS = []

# KiB that the second half may add; one leak of a connection (visitors make some 50 a second) would be far above.
GROWTH_MAX = 2048


def guarded(work):
    def run(*arguments):
        try:
            work(*arguments)
        except Exception as error:
            FAULTS.append(f"{work.__name__}: {error!r}")

    return run


@guarded
def reader(server, end):
    rtsi = Rtsi(server.ports["rtsi"])
    rtsi.set_up_outputs(["timestamp", "actual_joint_positions", "actual_TCP_pose"])
    rtsi.start()
    last = rtsi.read()["timestamp"]
    missing = 0
    while time.monotonic() < end:
        now = rtsi.read()["timestamp"]
        missing += round((now - last) / 0.004) - 1
        last = now
    if missing:
        FAULTS.append(f"rtsi: {missing} packages missing")


@guarded
def visitor(server, end):
    while time.monotonic() < end:
        dashboard, primary, rtsi = (
            Dashboard(server.ports["dashboard"]),
            Primary(server.ports["primary"]),
            Rtsi(server.ports["rtsi"]),
        )
        dashboard.ask("status")
        primary.state()
        rtsi.set_up_outputs(["timestamp"], 125)
        rtsi.start()
        rtsi.read()
        for client in (dashboard, primary, rtsi):
            client.close()
        time.sleep(0.05)


@guarded
def sender(server, end):
    primary = Primary(server.ports["primary"])
    number = 0
    while time.monotonic() < end:
        number += 1
        q = 0.2 if number % 2 else -0.2
        primary.send_script(f"def p{number}():\n  movej([{q},-1.5708,1.5708,-1.5708,-1.5708,0])\nend")
        primary.until(lambda s: s.running, 5)
        primary.until(lambda s: not s.running, 15)


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60
    clients = int(sys.argv[2]) if len(sys.argv) > 2 else 4
    with Server() as server:
        warm_up, end = time.monotonic() + min(10, seconds / 3), time.monotonic() + seconds
        work = [sender] + [reader] * clients + [visitor] * clients
        threads = [threading.Thread(target=w, args=(server, end)) for w in work]
        sleepers = [Primary(server.ports["primary"]) for _ in range(clients)]  # connected, never reading
        for thread in threads:
            thread.start()
        time.sleep(max(0, warm_up - time.monotonic()))
        memory = [server.rss_kib()]
        for tenth in range(1, 10):
            time.sleep(max(0, warm_up + tenth * (end - warm_up) / 10 - time.monotonic()))
            memory.append(server.rss_kib())
        for thread in threads:
            thread.join()
        memory.append(server.rss_kib())
        growth = max(memory[6:]) - max(memory[:6])
        if growth > GROWTH_MAX:
            FAULTS.append(f"memory: the second half added {growth} KiB")
        missed = server.metric("cycles_missed_total")
        if missed:
            FAULTS.append(f"{missed:.0f} cycles missed")
        cycles = server.metric("cycles_total")
        print(
            f"{seconds:.0f} s, {4 * clients + 1} clients, {cycles:.0f} cycles, {missed:.0f} missed; memory in KiB: "
            f"{memory}"
        )
        print("\n".join(FAULTS) or "no faults")
        del sleepers
        sys.exit(bool(FAULTS))


if __name__ == "__main__":
    main()
