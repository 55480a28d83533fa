"""Figures of the node on this machine: rate, jitter, losses, latency of a service, processor time and memory.

Run with the interpreter of environment.sh, ELITESERVER set: measure.py [SECONDS]
"""

import pathlib
import statistics
import sys
import tempfile
import time

from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from conftest import Controller, Peer


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100


def main(seconds):
    with tempfile.TemporaryDirectory() as folder:
        controller = Controller(pathlib.Path(folder), 60, "--plant", "ideal")
        peer = Peer(controller.domain)
        found = peer.collect(JointState, "joint_states", 1000)
        peer.wait_for(lambda: len(found) > 100, 60)
        node = controller.node_pid()
        found.clear()
        own = controller.process.pid
        before, cpu, own_cpu = time.monotonic(), processor_seconds(node), processor_seconds(own)
        time.sleep(seconds)
        took, cpu, own_cpu = time.monotonic() - before, processor_seconds(node) - cpu, processor_seconds(own) - own_cpu
        messages = list(found)
        stamps = [m.header.stamp.sec + m.header.stamp.nanosec * 1e-9 for _, m in messages]
        expected = round((stamps[-1] - stamps[0]) / 0.004) + 1
        late = sorted((at - stamp) * 1e3 for (at, _), stamp in zip(messages, stamps))
        print(f"joint states: {len(messages)} of {expected} in {took:.1f} s")
        print(f"from cycle to callback: p50 {late[len(late) // 2]:.1f} ms, p99 {late[len(late) * 99 // 100]:.1f} ms")
        gaps = sorted(abs(b - a - 0.004) * 1e3 for (a, _), (b, _) in zip(messages, messages[1:]))
        print(
            f"jitter, callback to callback: p50 {gaps[len(gaps) // 2]:.2f} ms, p99 {gaps[len(gaps) * 99 // 100]:.1f} ms"
        )
        client = peer.node.create_client(Trigger, "dashboard_client/close_safety_dialog")
        client.wait_for_service(20)
        time.sleep(1)
        times = []
        for _ in range(50):
            begun = time.monotonic()
            peer.result(client.call_async(Trigger.Request()))
            times.append((time.monotonic() - begun) * 1e3)
        print(f"a Trigger: p50 {statistics.median(times):.1f} ms, highest {max(times):.1f} ms")
        status = pathlib.Path(f"/proc/{node}/status").read_text()
        memory = int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1])
        print(f"the node: {100 * cpu / took:.0f} % of a core, {memory / 1024:.0f} MiB")
        print(f"the controller: {100 * own_cpu / took:.0f} % of a core")
        peer.close()
        controller.close()


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 30)
