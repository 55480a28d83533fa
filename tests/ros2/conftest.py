"""A controller with its node, and a node of rclpy beside it, in a domain of their own."""

import itertools
import json
import os
import pathlib
import socket
import subprocess
import sys
import threading
import time
import urllib.request

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))

# Below the ports that the system gives to whoever asks for any (domain 101 is the last one below 32768).
DOMAINS = itertools.count(20 + os.getpid() % 60)
JOINTS = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
]
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Controller:
    """`serve --ros2` with any free ports."""

    def __init__(self, folder, domain, *options, record="off"):
        self.domain = domain
        self.ready = folder / f"ready-{domain}.json"
        ports = itertools.chain.from_iterable(
            (f"--{name}-port", "0") for name in ("primary", "interpreter", "rtsi", "dashboard", "http", "modbus")
        )
        command = [
            os.environ["ELITESERVER"],
            "serve",
            "--record",
            record,
            "--ros2",
            "--ros-domain",
            str(domain),
            "--ready-file",
            str(self.ready),
            *ports,
            *options,
        ]
        self.log = open(folder / f"log-{domain}.txt", "w+")
        self.process = subprocess.Popen(command, cwd=folder, stderr=self.log, stdout=self.log)
        deadline = time.monotonic() + 60
        while not self.ready.exists():
            assert self.process.poll() is None, self.log_text()
            assert time.monotonic() < deadline, "the controller does not begin"
            time.sleep(0.05)
        self.ports = json.loads(self.ready.read_text())["ports"]

    def log_text(self):
        self.log.flush()
        return pathlib.Path(self.log.name).read_text()

    def node_pid(self):
        """The process of the node."""
        children = pathlib.Path(f"/proc/{self.process.pid}/task")
        for task in children.iterdir():
            for child in (task / "children").read_text().split():
                arguments = pathlib.Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
                if arguments[1:2] == [b"ros2"]:
                    return int(child)
        return None

    def http(self, path, value=None, **headers):
        """The JSON that the http port answers to a GET, or to a POST of a value."""
        url = f"http://127.0.0.1:{self.ports['http']}{path}"
        body = None if value is None else json.dumps(value).encode()
        request = urllib.request.Request(url, body, {"Content-Type": "application/json", **headers})
        with urllib.request.urlopen(request, timeout=10) as answer:
            return json.load(answer)

    def order(self, do, **fields):
        """What a button of the pendant page does."""
        token = self.http("/api/v1/session")["token"]
        return self.http("/api/v1/orders", {"do": do, **fields}, Authorization=f"Bearer {token}")

    def dashboard(self, *lines):
        """The replies of the dashboard."""
        with socket.create_connection(("127.0.0.1", self.ports["dashboard"]), 10) as connection:
            stream = connection.makefile("rw", newline="\n")
            stream.readline()
            replies = []
            for line in lines:
                stream.write(line + "\n")
                stream.flush()
                replies.append(stream.readline().strip())
            return replies

    def close(self):
        self.process.terminate()
        try:
            self.process.wait(20)
        finally:
            self.process.kill()
        return self.process.returncode


class Peer:
    """A node of rclpy that spins on a thread of its own."""

    def __init__(self, domain, **options):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("test_peer", context=self.context, **options)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self._spin, daemon=True)
        self.thread.start()

    def _spin(self):
        while self.context.ok():
            try:
                self.executor.spin_once(timeout_sec=0.1)
            except Exception:  # the context ends while it is spun
                if self.context.ok():
                    raise

    def wait_for(self, condition, seconds=20, what="it"):
        deadline = time.monotonic() + seconds
        while True:
            value = condition()
            if value:
                return value
            assert time.monotonic() < deadline, f"{what} does not come within {seconds} s"
            time.sleep(0.01)

    def ask(self, call, *arguments, **options):
        """The future of a call of an action client, made where answers are taken: an answer that comes before the call
        has returned on another thread is lost (ros2/rclpy issue 1123)."""
        return self.result(self.executor.create_task(lambda: call(*arguments, **options)), 20, "a turn to ask")

    def result(self, future, seconds=20, what="an answer"):
        self.wait_for(future.done, seconds, what)
        return future.result()

    def collect(self, kind, topic, qos=10):
        found = []
        self.node.create_subscription(kind, topic, lambda message: found.append((time.time(), message)), qos)
        return found

    def call(self, kind, name, request=None, seconds=20):
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(seconds), f"there is no service {name}"
        # The answer of a server that has not found this client yet is lost.
        time.sleep(1.0)
        answer = self.result(client.call_async(request or kind.Request()), seconds, f"the answer of {name}")
        self.node.destroy_client(client)
        return answer

    def close(self):
        self.context.try_shutdown()
        self.thread.join(5)


@pytest.fixture(scope="module")
def controller(tmp_path_factory):
    controller = Controller(tmp_path_factory.mktemp("controller"), next(DOMAINS), "--plant", "ideal")
    yield controller
    status = controller.close()
    assert status == 0, controller.log_text()


@pytest.fixture(scope="module")
def peer(controller):
    peer = Peer(controller.domain)
    yield peer
    peer.close()
