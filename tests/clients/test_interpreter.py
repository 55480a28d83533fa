"""Port 30020: points streamed as blocks, as the vendor's sample does it."""

import json
import math
import select
import socket
import time
import unittest
import urllib.request

from elite import Primary, Rtsi
from server import Server

HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]


def interpreter(server):
    with urllib.request.urlopen(f"http://127.0.0.1:{server.ports['http']}/panel", timeout=5) as page:
        return json.load(page)["interpreter"]


class Streaming(unittest.TestCase):
    def test_blocks_with_a_servoj_each_lead_the_arm_at_125_hz(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            rtsi.set_up_outputs(["actual_joint_positions", "runtime_state"], 125)
            rtsi.start()
            primary = Primary(server.ports["primary"])
            primary.send_script("interpreter_mode(clearQueueOnEnter=True, clearOnEnd=True)")
            end = time.monotonic() + 5
            while interpreter(server) != "active":  # what comes earlier is cleared when the mode begins
                self.assertLess(time.monotonic(), end)
                time.sleep(0.01)
            stream = socket.create_connection(("127.0.0.1", server.ports["interpreter"]))
            stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            count, replies, seen = 250, b"", []
            start = time.monotonic()
            for number in range(count):
                q = [0.3 * (1 - math.cos(math.pi * number / count))] + HOME[1:]
                point = ",".join(f"{x:.6f}" for x in q)
                stream.sendall(f"def a():\n servoj([{point}], t=0.008, lookahead_time=0.1, gain=300)\nend\n".encode())
                # The sample reads its replies too: 500 statements may wait, no more.
                while select.select([stream], [], [], 0)[0]:
                    replies += stream.recv(65536)
                seen.append(rtsi.latest()["actual_joint_positions"][0])
                time.sleep(max(0.0, start + number * 0.008 - time.monotonic()))
            rtsi.until(lambda v: abs(v["actual_joint_positions"][0] - 0.6) < 0.01)
            while replies.count(b"\n") < count:
                replies += stream.recv(65536)
            acks = replies.decode().splitlines()
            self.assertTrue(all(ack.startswith(f"ack: {n}:") for n, ack in enumerate(acks, 1)), acks[:3])
            self.assertTrue(all(b > a - 1e-4 for a, b in zip(seen, seen[1:])), "the arm never goes back")
            stream.sendall(b"end_interpreter()\n")
            rtsi.until(lambda v: v["runtime_state"] == 3)


if __name__ == "__main__":
    unittest.main()
