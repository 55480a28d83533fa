"""Many clients for a long time: `python3 tests/clients/soak.py [seconds] [clients of each kind]`.

Reads, writes, reconnects and sends programs all the while; at the end the server must not have grown, and no cycle and no
package may be missing. An hour is the real thing, a minute shows most of it.
"""

import pathlib
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))

from elite import Dashboard, Primary, Rtsi  # noqa: E402
from server import Server  # noqa: E402

FAULTS = []


def guarded(work):
    def run(*arguments):
        try:
            work(*arguments)
        except Exception as error:  # noqa: BLE001
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
        dashboard, primary, rtsi = Dashboard(server.ports["dashboard"]), Primary(server.ports["primary"]), Rtsi(server.ports["rtsi"])
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
        before = server.rss_kib()
        for thread in threads:
            thread.join()
        growth = server.rss_kib() - before
        missed = server.metric("cycles_missed_total")
        print(f"{seconds:.0f} s, {4 * clients + 1} clients: memory {before} KiB, grown by {growth} KiB, {missed:.0f} cycles missed")
        print("\n".join(FAULTS) or "no faults")
        del sleepers
        sys.exit(bool(FAULTS))


if __name__ == "__main__":
    main()
