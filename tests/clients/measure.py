"""Latency figures of external control and RTSI: `python3 tests/clients/measure.py` (a release build, for real numbers).

Prints the time from a command on the reverse socket to the first setpoint that moves, the jitter of the RTSI period,
and that of the machine's own timer at the same rate, all p50 / p99 / max.
"""

import pathlib
import statistics
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))

from elite import Rtsi  # noqa: E402
from external_control import IDLE, SPEEDJ, Driver  # noqa: E402
from server import Server  # noqa: E402


def line(name, seconds):
    ordered = sorted(seconds)

    def at(share):
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] * 1e3

    return f"{name}: p50 {at(0.5):.2f} ms, p99 {at(0.99):.2f} ms, max {ordered[-1] * 1e3:.2f} ms ({len(ordered)} times)"


def timer_jitter(count, period=0.004):
    deviations, due = [], time.monotonic() + period
    for _ in range(count):
        time.sleep(max(0.0, due - time.monotonic()))
        deviations.append(abs(time.monotonic() - due))
        due += period
    return deviations


def rtsi_jitter(port, count):
    rtsi = Rtsi(port)
    rtsi.set_up_outputs(["timestamp", "actual_joint_positions"])
    rtsi.start()
    rtsi.read()
    arrivals, stamps = [], []
    for _ in range(count):
        stamps.append(rtsi.read()["timestamp"])
        arrivals.append(time.monotonic())
    rtsi.close()
    lost = sum(round((b - a) / 0.004) - 1 for a, b in zip(stamps, stamps[1:]))
    # How far each arrival is from an exact schedule through the median.
    offset = statistics.median(t - s for t, s in zip(arrivals, stamps))
    return [abs(t - s - offset) for t, s in zip(arrivals, stamps)], lost


def reaction(server, count):
    driver = Driver(server.ports["primary"])
    driver.wait_connected(10)
    rtsi = Rtsi(server.ports["rtsi"])
    rtsi.set_up_outputs(["target_joint_speeds"])
    rtsi.start()
    times = []
    for _ in range(count):
        driver.write(IDLE, (), 0)
        rtsi.until(lambda v: max(map(abs, v["target_joint_speeds"])) == 0)
        time.sleep(0.05)
        rtsi.latest()
        start = time.monotonic()
        driver.write(SPEEDJ, [0.1, 0, 0, 0, 0, 0], 1000)
        while rtsi.read()["target_joint_speeds"][0] == 0:
            pass
        times.append(time.monotonic() - start)
        driver.write(SPEEDJ, [-0.1, 0, 0, 0, 0, 0], 1000)
        time.sleep(0.05)
    driver.stop()
    return times


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2500
    with Server() as server:
        print(line("timer of this machine, deviation at 250 Hz", timer_jitter(count)))
        jitter, lost = rtsi_jitter(server.ports["rtsi"], count)
        print(line("RTSI, deviation of arrival at 250 Hz", jitter) + f", {lost} packages missing")
        print(
            line(
                "idle to speedj on the reverse socket, until the first changed setpoint is read", reaction(server, 100)
            )
        )


if __name__ == "__main__":
    main()
