"""The PC side of external control: a driver that sends its program to 30001 and leads the arm through three sockets.

Written from the protocol page; does what the vendor's driver does in the same order and with the same patience.
"""

import pathlib
import select
import socket
import struct
import threading
import time

from elite import Primary

HERE = pathlib.Path(__file__).resolve().parent
ZOOM = 1_000_000

STOPPED, IDLE, SERVOJ, SPEEDJ, TRAJECTORY, SPEEDL, POSE, FREEDRIVE = -2, 0, 1, 2, 3, 4, 5, 6
SERVOJ_QUEUE, POSE_QUEUE = 8, 9


class Listener:
    """A TCP server with one connection at a time: a new one replaces the old."""

    def __init__(self):
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.connection = None
        self.connected = threading.Event()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                connection, _ = self.server.accept()
            except OSError:
                return
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            old, self.connection = self.connection, connection
            if old:
                old.close()
            self.connected.set()

    def send_words(self, words):
        self.connection.sendall(struct.pack(f">{len(words)}i", *words))

    def is_closed_by_robot(self):
        """True once the robot has closed; what it sent before is thrown away."""
        if not select.select([self.connection], [], [], 0)[0]:
            return False
        try:
            return self.connection.recv(4096) == b""
        except OSError:
            return True

    def stop(self):
        """Nobody listens on the port any more."""
        self.server.shutdown(socket.SHUT_RDWR)
        self.server.close()

    def close(self):
        self.server.close()
        if self.connection:
            self.connection.close()


class Driver:
    """Headless: the program goes to 30001 at once; with a `sender` it waits there until a task asks for it. Timeouts
    are longer than the vendor's 200 ms: a busy machine may keep this client from its turn for as long."""

    def __init__(self, primary_port, servo_time=0.004, lookahead=0.1, gain=300, listening=True, sender=None):
        self.primary = Primary(primary_port)
        self.reverse, self.trajectory, self.command = Listener(), Listener(), Listener()
        if not listening:
            self.reverse.stop()
            self.trajectory.stop()
            self.command.stop()
        fill = {
            "SERVER_IP": self.primary.local_ip,
            "REVERSE_PORT": self.reverse.port,
            "TRAJECTORY_PORT": self.trajectory.port,
            "COMMAND_PORT": self.command.port,
            "POSITION_ZOOM": ZOOM,
            "TIME_ZOOM": 1000,
            "REVERSE_WORDS": 8,
            "POINT_WORDS": 21,
            "COMMAND_WORDS": 26,
            "STOPJ_ACCELERATION": "8.000000",
            "SERVO_TIME": f"{servo_time:f}",
            "SERVO_ARGUMENTS": f"lookahead_time = {lookahead}, gain={gain}",
            "QUEUE_SIZE": 10,
        }
        text = (HERE / "control.script").read_text()
        for name, value in fill.items():
            text = text.replace("{{%s}}" % name, str(value))
        assert "{{" not in text
        if sender:
            sender.script = (
                f"# HEADER_BEGIN\n# HEADER_END\n# NODE_CONTROL_LOOP_BEGINS\n{text}\n# NODE_CONTROL_LOOP_ENDS\n".encode()
            )
            self.script = None
            return
        self.script = "def externalControl():\n" + "".join(f"\t{line}\n" for line in text.splitlines()) + "end"
        self.send_script()

    def send_script(self):
        self.primary.send_script(self.script)

    def wait_connected(self, seconds=5):
        for listener in (self.reverse, self.trajectory, self.command):
            if not listener.connected.wait(seconds):
                raise TimeoutError("the program has not connected")

    def write(self, mode, values=(), timeout_ms=1000):
        words = [0] * 8
        words[0], words[7] = timeout_ms, mode
        for index, value in enumerate(values):
            words[1 + index] = round(value * ZOOM)
        self.reverse.send_words(words)

    def action(self, mode, action, count=0, timeout_ms=1000):
        self.reverse.send_words([timeout_ms, action, count, 0, 0, 0, 0, mode])

    def servoj(self, joints, timeout_ms=1000):
        self.write(SERVOJ, joints, timeout_ms)

    def idle(self, timeout_ms=0):
        self.write(IDLE, (), timeout_ms)

    def point(self, place, seconds, radius=0.0, cartesian=False):
        words = [round(x * ZOOM) for x in place] + [0] * 12
        self.trajectory.send_words(words + [round(seconds * 1000), round(radius * ZOOM), int(cartesian)])

    def result(self):
        """The result of the trajectory, once it has ended."""
        if not select.select([self.trajectory.connection], [], [], 0)[0]:
            return None
        reply = self.trajectory.connection.recv(4)
        if len(reply) != 4:
            raise ConnectionError("the program has closed the trajectory socket")
        return struct.unpack(">i", reply)[0]

    def run_trajectory(self, points, seconds=20):
        """Start packet, then the points with a no-op after each, then no-ops until the result is there."""
        self.action(TRAJECTORY, 1, len(points))
        for place, duration, radius, cartesian in points:
            self.point(place, duration, radius, cartesian)
            self.action(TRAJECTORY, 0)
        end = time.monotonic() + seconds
        while True:
            result = self.result()
            if result is not None:
                return result
            if time.monotonic() > end:
                raise TimeoutError("the trajectory has not ended")
            self.action(TRAJECTORY, 0)
            time.sleep(0.05)

    def script_command(self, number, values=(), at=None):
        words = [number] + [0] * 25
        for index, value in enumerate(values):
            words[1 + index] = round(value * ZOOM)
        for index, value in (at or {}).items():
            words[index] = value
        self.command.send_words(words)

    def stop(self, seconds=10):
        """Mode -2, then until the reverse and the command socket are closed by the robot."""
        words = [0x7F7F7F7F] * 8  # the driver sends what happens to be in its memory
        words[0], words[7] = 0, STOPPED
        self.reverse.send_words(words)
        end = time.monotonic() + seconds
        while not (self.reverse.is_closed_by_robot() and self.command.is_closed_by_robot()):
            if time.monotonic() > end:
                return False
            time.sleep(0.005)
        return True

    def close(self):
        for part in (self.reverse, self.trajectory, self.command, self.primary):
            part.close()


class ScriptSender:
    """Not headless: the program waits on a port until a task on the controller asks for it, and goes out without its
    wrapper and without an end; the connection stays open, as the vendor's sender leaves it."""

    def __init__(self):
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.requests = []
        self.script = b""
        self.connections = []
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        while True:
            try:
                connection, _ = self.server.accept()
            except OSError:
                return
            self.connections.append(connection)
            request = b""
            while not request.endswith(b"\n"):
                part = connection.recv(64)
                if not part:
                    break
                request += part
            self.requests.append(request)
            # In pieces: nothing says how much comes. Who has heard enough may be gone.
            half = len(self.script) // 2
            try:
                connection.sendall(self.script[:half])
                time.sleep(0.05)
                connection.sendall(self.script[half:])
            except OSError:
                pass

    def close(self):
        """Nobody listens on the port any more."""
        self.server.shutdown(socket.SHUT_RDWR)
        self.server.close()
        for connection in self.connections:
            connection.close()
