"""What happens around the node: its process killed, clients gone, nonsense from the network."""

import os
import pathlib
import random
import signal
import socket
import struct
import time

from conftest import Controller, Peer
from sensor_msgs.msg import JointState


def lost_cycles(controller):
    """Figures of /metrics: how late cycles were, and how many were missed."""
    import urllib.request

    text = urllib.request.urlopen(f"http://127.0.0.1:{controller.ports['http']}/metrics", timeout=5).read().decode()
    found = [line for line in text.splitlines() if line.startswith("elite_cycles_missed")]
    return [float(line.split()[-1]) for line in found]


def test_a_killed_node_comes_back_and_the_controller_goes_on(tmp_path):
    controller = Controller(tmp_path, 90 + os.getpid() % 10, "--plant", "ideal")
    try:
        peer = Peer(controller.domain)
        states = peer.collect(JointState, "joint_states", 100)
        peer.wait_for(lambda: len(states) > 100, 30, "joint states")
        for _ in range(2):
            os.kill(controller.node_pid(), signal.SIGKILL)
            count = len(states)
            peer.wait_for(lambda: len(states) > count + 300, 10, "joint states of the next node")
        assert controller.process.poll() is None
        assert "is started again" in controller.log_text()
        peer.close()
    finally:
        assert controller.close() == 0, controller.log_text()
    assert controller.node_pid() is None if pathlib.Path(f"/proc/{controller.process.pid}").exists() else True


def test_nonsense_from_the_network_leaves_the_controller_alone(tmp_path):
    controller = Controller(tmp_path, 80 + os.getpid() % 10, "--plant", "ideal")
    try:
        peer = Peer(controller.domain)
        states = peer.collect(JointState, "joint_states", 100)
        peer.wait_for(lambda: len(states) > 100, 30, "joint states")
        draw = random.Random(48)
        base = 7400 + 250 * controller.domain
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        head = b"RTPS\x02\x03\x01\x0f" + bytes(12)
        for number in range(10_000):
            body = draw.randbytes(draw.randrange(200))
            sender.sendto((head if number % 2 else b"") + body, ("127.0.0.1", base + 10 + number % 8))
            if number % 500 == 0:
                time.sleep(0.05)
        # Fragments of samples that claim 512 MiB.
        for number in range(20):
            submessage = struct.pack(
                "<HHIIqIHHI", 0, 28, 0x000100C2, 0x000100C7, 1 << 32 | number, 1, 1, 65000, 512 << 20)
            sender.sendto(
                head + struct.pack("<BBH", 0x16, 1, len(submessage) + 64) + submessage + bytes(64),
                ("127.0.0.1", base + 10 + number % 8))
        count = len(states)
        peer.wait_for(lambda: len(states) > count + 300, 15, "joint states after that")
        assert controller.process.poll() is None
        status = pathlib.Path(f"/proc/{controller.node_pid()}/status").read_text()
        resident = int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1])
        assert resident < 512 * 1024, resident
        peer.close()
    finally:
        assert controller.close() == 0, controller.log_text()
