"""What talks with a running server from outside: a Foxglove client that we did not write, Prometheus' own parser,
pymodbus."""

import asyncio
import base64
import json
import os
import socket
import struct
import subprocess
import tempfile
import time
import unittest
import urllib.request

import websockets
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from prometheus_client.parser import text_string_to_metric_families
from pymodbus.client import ModbusTcpClient

SERVER = os.environ["ELITESERVER"]
SUBPROTOCOL = "foxglove.sdk.v1"

CELL = """
[[obstacle]]
name = "bench"
shape = "box"
size = [0.4, 0.4, 0.2]
pose = [0.9, 1.0, 0.1, 0, 0, 0]
"""

PROGRAM = """def wave():
  textmsg("waving")
  i = 0
  while i < 3:
    movej([0.4, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
    movej([-0.4, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
    i = i + 1
  end
end
"""


class Started:
    """A program of ours with ports; ended when the block is left."""

    def __init__(self, *arguments):
        self.arguments = arguments

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        ready = os.path.join(self.folder.name, "ready.json")
        self.log = open(os.path.join(self.folder.name, "log"), "w+")
        command = [SERVER, *self.arguments, "--ready-file", ready]
        self.process = subprocess.Popen(command, stderr=self.log, cwd=self.folder.name)
        end = time.monotonic() + 20
        while not os.path.exists(ready):
            if self.process.poll() is not None or time.monotonic() > end:
                self.log.seek(0)
                raise AssertionError(f"the server did not start\n{self.log.read()}")
            time.sleep(0.02)
        with open(ready) as file:
            self.ports = json.load(file)["ports"]
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(10)
        self.log.close()
        self.folder.cleanup()

    def send(self, program):
        with socket.create_connection(("127.0.0.1", self.ports["primary"])) as primary:
            primary.sendall(program.encode())
            time.sleep(0.3)

    def get(self, page):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.ports['http']}{page}", timeout=5) as answer:
            return answer.read().decode()


def ports(*services):
    """Any free port for these services, the others off."""
    everything = ("primary", "interpreter", "rtsi", "dashboard", "modbus", "http", "foxglove")
    return [word for name in everything for word in (f"--{name}-port", "0" if name in services else "off")]


class Follower:
    """A client of the Foxglove protocol: what each topic said, decoded with the schema that the server told."""

    def __init__(self, connection):
        self.connection = connection
        self.info = None
        self.channels = {}
        self.types = {}
        self.messages = {}

    async def follow(self, secs, until=lambda messages: False):
        end = asyncio.get_running_loop().time() + secs
        while not until(self.messages):
            left = end - asyncio.get_running_loop().time()
            if left <= 0:
                return
            try:
                packet = await asyncio.wait_for(self.connection.recv(), left)
            except (asyncio.TimeoutError, websockets.ConnectionClosed):
                return
            if isinstance(packet, str):
                await self.text(json.loads(packet))
            elif packet[0] == 1:
                subscription, stamp = struct.unpack_from("<IQ", packet, 1)
                channel = self.channels[subscription]
                message = self.types[subscription].FromString(packet[13:])
                self.messages.setdefault(channel["topic"], []).append((stamp, message))

    async def text(self, packet):
        if packet["op"] == "serverInfo":
            self.info = packet
        if packet["op"] == "advertise":
            for channel in packet["channels"]:
                self.channels[channel["id"]] = channel
                files = descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["schema"]))
                pool = descriptor_pool.DescriptorPool()
                for file in files.file:
                    pool.Add(file)
                descriptor = pool.FindMessageTypeByName(channel["schemaName"])
                self.types[channel["id"]] = message_factory.GetMessageClass(descriptor)
            subscriptions = [{"id": c["id"], "channelId": c["id"]} for c in packet["channels"]]
            await self.connection.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))


def followed(port, secs, until=lambda messages: False, first=lambda: None):
    async def follow():
        async with websockets.connect(
            f"ws://127.0.0.1:{port}", subprotocols=[SUBPROTOCOL], max_size=None
        ) as connection:
            follower = Follower(connection)
            await follower.follow(0.5)
            await asyncio.to_thread(first)
            await follower.follow(secs, until)
            return follower

    return asyncio.run(follow())


class Foxglove(unittest.TestCase):
    def test_a_running_arm_is_seen_with_its_cell_and_its_messages(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as cell:
            cell.write(CELL)
            cell.flush()
            with Started("serve", "--record", "off", "--cell", cell.name, *ports("primary", "foxglove")) as server:
                seen = followed(
                    server.ports["foxglove"],
                    6,
                    lambda messages: len(messages.get("/scene", [])) > 12 and "/log" in messages,
                    lambda: server.send(PROGRAM),
                )
        self.assertEqual(seen.connection.subprotocol, SUBPROTOCOL)
        # Nothing can be published, set or called.
        self.assertEqual(seen.info["capabilities"], ["time"])
        topics = {channel["topic"]: channel["schemaName"] for channel in seen.channels.values()}
        self.assertEqual(
            topics,
            {
                "/cycle": "elite.Cycle",
                "/joint_states": "foxglove.JointStates",
                "/tf": "foxglove.FrameTransforms",
                "/tcp": "foxglove.PoseInFrame",
                "/scene": "foxglove.SceneUpdate",
                "/log": "foxglove.Log",
            },
        )
        scene = seen.messages["/scene"][0][1]
        drawn = {entity.id: entity for entity in scene.entities}
        self.assertIn("forearm_link", drawn)
        self.assertAlmostEqual(drawn["obstacle/bench"].cubes[0].size.z, 0.2)
        trace = {entity.id: entity for entity in seen.messages["/scene"][-1][1].entities}["tcp_trace"]
        self.assertGreater(len(trace.lines[0].points), 5)
        joint = [message.joints[0].position for _, message in seen.messages["/joint_states"]]
        self.assertGreater(max(joint) - min(joint), 0.1)
        stamps = [stamp for stamp, _ in seen.messages["/tf"]]
        self.assertEqual(stamps, sorted(stamps))
        frames = [transform.child_frame_id for transform in seen.messages["/tf"][0][1].transforms]
        self.assertEqual(frames[-1], "tcp")
        self.assertIn("waving", [message.message for _, message in seen.messages["/log"]])

    def test_what_is_no_foxglove_client_is_turned_away_and_others_go_on(self):
        with Started("serve", "--record", "off", "--plant", "ideal", *ports("foxglove")) as server:
            port = server.ports["foxglove"]
            for nonsense in (b"stop task\n", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", bytes(range(256)) * 100):
                with socket.create_connection(("127.0.0.1", port), timeout=5) as client:
                    answer = b""
                    try:
                        client.sendall(nonsense)
                        client.shutdown(socket.SHUT_WR)
                        answer = client.recv(100)
                    except TimeoutError:
                        raise
                    except OSError:
                        pass  # turned away before all of it was sent, or before its end was
                    self.assertTrue(answer == b"" or answer.startswith(b"HTTP/1.1 4"), answer)
            seen = followed(port, 3, lambda messages: "/tf" in messages)
            self.assertIn("/tf", seen.messages)


class Metrics(unittest.TestCase):
    def test_prometheus_reads_the_page(self):
        with tempfile.TemporaryDirectory() as folder:
            record = os.path.join(folder, "run.mcap")
            with Started("serve", "--record", record, "--plant", "ideal", *ports("primary", "http")) as server:
                server.send(PROGRAM.replace("i = 0", "nonsense()"))
                time.sleep(1)
                page = server.get("/metrics")
                health = json.loads(server.get("/healthz"))
        families = {family.name: family for family in text_string_to_metric_families(page)}
        self.assertEqual(families["elite_cycle_duration_seconds"].type, "histogram")

        def value(name, **labels):
            family = families[name.removesuffix("_total").removesuffix("_bucket").removesuffix("_count")]
            found = [s.value for s in family.samples if s.name == name and labels.items() <= s.labels.items()]
            self.assertEqual(len(found), 1, (name, labels))
            return found[0]

        cycles = value("elite_cycles_total")
        self.assertGreater(cycles, 100)
        # The counters are read one after the other while cycles go on.
        self.assertAlmostEqual(value("elite_cycle_duration_seconds_count"), cycles, delta=5)
        self.assertEqual(
            value("elite_cycle_duration_seconds_bucket", le="+Inf"), value("elite_cycle_duration_seconds_count")
        )
        counts = [s.value for s in families["elite_cycle_wakeup_latency_seconds"].samples if "le" in s.labels]
        self.assertEqual(counts, sorted(counts))
        self.assertEqual(value("elite_errors_total", kind="script"), 1)
        self.assertGreater(value("elite_recording_bytes_total"), 1000)
        self.assertEqual(value("elite_queue_depth", queue="commands"), 0)
        self.assertEqual(value("elite_task_state", state="stopped"), 1)
        self.assertEqual(health["status"], "ok")
        self.assertEqual(health["recording"], "active")
        self.assertEqual(health["clients"]["http"], 1)


class Gripper(unittest.TestCase):
    CELL = """
[world]
floor = -0.5

[[gripper]]
name = "hand"
kind = "fingers"
stroke = 0.085
finger = {{ size = [0.02, 0.01, 0.04], pose = [0, 0.005, 0.1, 0, 0, 0] }}
force = 100
speed = 0.05
protocol = "robotiq-2f"
bus = "tcp:{port}"
"""

    def test_pymodbus_closes_the_fingers_of_the_cell(self):
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as cell:
            cell.write(self.CELL.format(port=port))
            cell.flush()
            with Started("serve", "--record", "off", "--cell", cell.name, *ports("http")):
                client = ModbusTcpClient("127.0.0.1", port=port, retries=0)
                self.assertTrue(client.connect())

                def words():
                    return client.read_input_registers(2000, count=3, slave=9).registers

                self.assertEqual(words(), [0, 0, 0])
                client.write_registers(1000, [0x0100, 0, 0], slave=9)
                self.assertEqual(words()[0], 0x3100)
                client.write_registers(1000, [0x0900, 0x00FF, 0xFFFF], slave=9)
                end, seen = time.monotonic() + 5, []
                while (seen or [0])[-1] >> 14 != 3 and time.monotonic() < end:
                    seen.append(words()[0])
                    time.sleep(0.01)
                self.assertEqual(sorted(set(seen)), [0x3900, 0xF900])
                self.assertEqual(words()[1:], [0x00FF, 0xFF00])
                refused = [
                    client.read_input_registers(2000, count=1, slave=8),
                    client.read_input_registers(2003, count=1, slave=9),
                    client.read_coils(0, count=1, slave=9),
                    client.write_registers(1000, [0x1100], slave=9),
                ]
                self.assertEqual([answer.exception_code for answer in refused], [11, 2, 1, 3])
                client.close()


def received(connection, count):
    data = b""
    while len(data) < count:
        more = connection.recv(count - len(data))
        if not more:
            raise AssertionError(f"closed after {len(data)} of {count} bytes")
        data += more
    return data


class Replay(unittest.TestCase):
    """A recording through the ports, as if the arm ran now."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.recording = os.path.join(cls.folder.name, "wave.mcap")
        script = os.path.join(cls.folder.name, "wave.script")
        with open(script, "w") as file:
            file.write(PROGRAM)
        subprocess.run(
            [SERVER, "run", script, "--plant", "ideal", "--record", cls.recording], check=True, capture_output=True
        )

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def replayed(self, *services, rate="1"):
        arguments = ["replay", self.recording, "--serve", "--rate", rate]
        for name in ("primary", "rtsi", "http"):
            arguments += [f"--{name}-port", "0" if name in services else "off"]
        if "foxglove" in services:
            arguments += ["--foxglove-port", "0"]
        return Started(*arguments)

    def test_foxglove_sees_what_was_recorded_at_the_rate_asked_for(self):
        with self.replayed("foxglove", rate="4") as server:
            begin = time.monotonic()
            seen = followed(server.ports["foxglove"], 20)
            status = server.process.wait(10)
            took = time.monotonic() - begin
        self.assertEqual(status, 0)
        stamps = [stamp for stamp, _ in seen.messages["/joint_states"]]
        # All but what went by before the client was there, in a quarter of the time.
        recorded = (stamps[-1] - stamps[0]) / 1e9
        self.assertGreater(recorded, 4)
        self.assertLess(took, recorded / 4 + 4)
        joint = [message.joints[0].position for _, message in seen.messages["/joint_states"]]
        self.assertAlmostEqual(max(joint), 0.4, places=3)

    def test_state_goes_out_and_nothing_comes_in(self):
        with self.replayed("primary", "rtsi", "http") as server:
            with socket.create_connection(("127.0.0.1", server.ports["primary"]), timeout=5) as primary:
                primary.sendall(b"def evil():\n  movej([0,0,0,0,0,0])\nend\n")
                is_refused, has_state = False, False
                while not (is_refused and has_state):
                    length, kind = struct.unpack(">IB", received(primary, 5))
                    message = received(primary, length - 5)
                    is_refused |= b"takes no programs" in message
                    has_state |= kind == 16
            with socket.create_connection(("127.0.0.1", server.ports["rtsi"]), timeout=5) as rtsi:

                def send(letter, payload):
                    rtsi.sendall(struct.pack(">HB", 3 + len(payload), ord(letter)) + payload)

                def receive():
                    size, letter = struct.unpack(">HB", received(rtsi, 3))
                    return chr(letter), received(rtsi, size - 3)

                send("V", struct.pack(">H", 1))
                self.assertEqual(receive(), ("V", b"\x01"))
                send("O", struct.pack(">d", 250) + b"timestamp,actual_joint_positions")
                self.assertEqual(receive(), ("O", b"\x01DOUBLE,VECTOR6D"))
                send("S", b"")
                self.assertEqual(receive(), ("S", b"\x01"))
                stamps = [struct.unpack_from(">d", receive()[1], 1)[0] for _ in range(50)]
                self.assertEqual(stamps, sorted(stamps))
                self.assertAlmostEqual(stamps[-1] - stamps[0], 49 * 0.004, delta=0.1)
            with socket.create_connection(("127.0.0.1", server.ports["rtsi"]), timeout=5) as rtsi:
                send("V", struct.pack(">H", 1))
                receive()
                send("I", b"standard_digital_output_mask,standard_digital_output")
                self.assertIn(b"IN_USE", receive()[1])
                letter, text = receive()
                self.assertEqual(letter, "M")
                self.assertIn(b"takes no programs and no inputs", text)
            panel = json.loads(server.get("/panel"))
            self.assertEqual(panel["task"], "running")
            self.assertTrue(panel["replay"].endswith("wave.mcap"))
            self.assertIn("elite_cycles_total", server.get("/metrics"))


if __name__ == "__main__":
    unittest.main()
