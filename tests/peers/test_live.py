"""What watches a running server from outside: a Foxglove client that we did not write, and Prometheus' own parser."""

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

SERVER = os.environ["ELITESERVER"]
SUBPROTOCOL = "foxglove.sdk.v1"

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
        async with websockets.connect(f"ws://127.0.0.1:{port}", subprotocols=[SUBPROTOCOL], max_size=None) as connection:
            follower = Follower(connection)
            await follower.follow(0.5)
            await asyncio.to_thread(first)
            await follower.follow(secs, until)
            return follower

    return asyncio.run(follow())


class Foxglove(unittest.TestCase):
    def test_a_running_arm_is_seen_with_its_cell_and_its_messages(self):
        with Started("serve", "--record", "off", "--plant", "ideal", *ports("primary", "foxglove")) as server:
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
                    client.sendall(nonsense)
                    client.shutdown(socket.SHUT_WR)
                    try:
                        answer = client.recv(100)
                    except ConnectionResetError:
                        answer = b""
                    self.assertTrue(answer == b"" or answer.startswith(b"HTTP/1.1 4"), answer)
            seen = followed(port, 3, lambda messages: "/tf" in messages)
            self.assertIn("/tf", seen.messages)


if __name__ == "__main__":
    unittest.main()
