"""Clients of the controller's ports, written from the protocol pages alone: no vendor code, only the standard library.

Each class does what the vendor's client of that port does, in the same order and with the same patience, and raises
where that client would give up.
"""

import re
import select
import socket
import struct
import time


class Client:
    """Something with a socket that is closed with it."""

    socket = None

    def close(self):
        if self.socket:
            self.socket.close()

    def __del__(self):
        self.close()


# --- 29999 ------------------------------------------------------------------------------------------------------------


class Dashboard(Client):
    """Port 29999: a line out, one reply in.

    A reply is read like the vendor's client does: bytes until the first line feed, and whatever came with them. A reply
    in two writes would leave its rest for the next command, and fail there.
    """

    def __init__(self, port, host="127.0.0.1"):
        self.socket = socket.create_connection((host, port), timeout=10)
        self.greeting = self._read()

    def _read(self):
        reply = b""
        while b"\n" not in reply:
            part = self.socket.recv(512)
            if not part:
                raise ConnectionError(f"closed after {reply!r}")
            reply += part
        if not reply.endswith(b"\r\n"):
            raise AssertionError(f"a reply must end with CR LF: {reply!r}")
        if len(reply) > 512:
            raise AssertionError(f"a reply of {len(reply)} bytes")
        return reply.decode()

    def ask(self, command):
        self.socket.sendall((command if isinstance(command, bytes) else command.encode()) + b"\n")
        return self._read()

    def replies(self, count):
        """So many replies that may have come in one piece; each of one line."""
        text = ""
        while text.count("\r\n") < count:
            text += self.socket.recv(4096).decode()
        return text.split("\r\n")[:-1]

    def expect(self, command, pattern):
        """Sends a command whose reply must contain `pattern` (a regular expression)."""
        reply = self.ask(command)
        if not re.search(pattern, reply):
            raise AssertionError(f"dashboard: {command!r} was answered {reply!r}, not {pattern!r}")
        return reply

    def poll(self, command, wanted, seconds=30, period=0.1):
        """Asks again and again until the reply is exactly `wanted` (or one of them)."""
        wanted = [wanted] if isinstance(wanted, str) else wanted
        end = time.monotonic() + seconds
        while True:
            reply = self.ask(command)
            if reply in [w + "\r\n" for w in wanted]:
                return reply
            if time.monotonic() > end:
                raise AssertionError(f"dashboard: {command!r} is still {reply!r}, not {wanted!r}")
            time.sleep(period)

    def power_on(self):
        self.expect("robotControl -on", "Powering on\r\n")
        self.poll("robotMode", ["robotMode: IDLE", "robotMode: RUNNING"])

    def power_off(self):
        self.expect("robotControl -off", "Powering off\r\n")
        time.sleep(0.5)
        self.poll("robotMode", "robotMode: POWER_OFF")

    def brake_release(self):
        self.expect("brakeRelease", "Brake (Releasing.*|is released).*")
        self.poll("robotMode", "robotMode: RUNNING")

    def load(self, path):
        self.expect(f"task -p {path}", r"Loaded task: .*")
        self.poll("task", f"Relative path:{path}")

    def play(self):
        if self.ask("play") != "Starting task\r\n":
            raise AssertionError("play was refused")
        self.poll("task -s", "Task is running")

    def pause(self):
        if self.ask("pause") != "Pausing task\r\n":
            raise AssertionError("pause was refused")
        self.poll("task -s", "Task is paused")

    def stop(self):
        if self.ask("stop") != "Stopping task\r\n":
            raise AssertionError("stop was refused")
        self.poll("task -s", "Task is stopped")


# --- 30004 ------------------------------------------------------------------------------------------------------------

FORMATS = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT16": "H",
    "UINT32": "I",
    "INT32": "i",
    "UINT64": "Q",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
    "VECTOR6UINT32": "6I",
}


class Recipe:
    """Names and types of one recipe."""

    def __init__(self, number, names, types):
        self.number, self.names, self.types = number, names, types
        self.packing = struct.Struct(">" + "".join(FORMATS[t] for t in types))

    def unpack(self, data):
        values = list(self.packing.unpack(data))
        result = {}
        for name, kind in zip(self.names, self.types):
            count = int(re.match(r"VECTOR(\d)", kind).group(1)) if kind.startswith("VECTOR") else 0
            result[name] = tuple(values.pop(0) for _ in range(count)) if count else values.pop(0)
        return result

    def pack(self, values):
        flat = []
        for name in self.names:
            value = values[name]
            flat.extend(value if isinstance(value, (list, tuple)) else [value])
        return self.packing.pack(*flat)


class Rtsi(Client):
    """Port 30004. Replies must come within a second; data packages in between are skipped."""

    def __init__(self, port, host="127.0.0.1"):
        self.socket = socket.create_connection((host, port), timeout=1)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.buffer = b""
        self.outputs = {}
        self.messages = []
        if self.request("V", struct.pack(">H", 1)) != b"\x01":
            raise ConnectionError("protocol version 1 was refused")
        self.version = struct.unpack(">4I", self.request("v"))

    def send(self, letter, payload=b""):
        self.socket.sendall(struct.pack(">HB", 3 + len(payload), ord(letter)) + payload)

    def packet(self, seconds=1.0):
        """The next packet, or None when there is none in time."""
        end = time.monotonic() + seconds
        while True:
            if len(self.buffer) >= 3:
                length = struct.unpack(">H", self.buffer[:2])[0]
                if length <= 3:
                    raise AssertionError("a packet without payload")
                if len(self.buffer) >= length:
                    packet, self.buffer = self.buffer[:length], self.buffer[length:]
                    return chr(packet[2]), packet[3:]
            left = end - time.monotonic()
            if not select.select([self.socket], [], [], max(0.0, left))[0]:
                return None
            part = self.socket.recv(65536)
            if not part:
                raise ConnectionError("rtsi: closed by the controller")
            self.buffer += part

    def request(self, letter, payload=b""):
        self.send(letter, payload)
        end = time.monotonic() + 1
        while True:
            packet = self.packet(end - time.monotonic())
            if packet is None:
                raise TimeoutError(f"rtsi: no reply to {letter} within a second")
            if packet[0] == letter:
                return packet[1]
            if packet[0] == "M":
                self.messages.append(packet[1])

    def _recipe(self, names, reply):
        types = reply[1:].decode().split(",")
        if len(types) != len(names):
            raise AssertionError(f"not match recipe: {types} for {names}")
        unknown = [n for n, t in zip(names, types) if t not in FORMATS]
        if unknown:
            raise LookupError(f"{unknown}: {types}")
        return Recipe(reply[0], names, types)

    def set_up_inputs(self, names):
        return self._recipe(names, self.request("I", ",".join(names).encode()))

    def set_up_outputs(self, names, frequency=250.0):
        payload = struct.pack(">d", frequency) + ",".join(names).encode()
        recipe = self._recipe(names, self.request("O", payload))
        self.outputs[recipe.number] = recipe
        return recipe

    def start(self):
        if self.request("S") != b"\x01":
            raise ConnectionError("start was refused")

    def pause(self):
        if self.request("P") != b"\x01":
            raise ConnectionError("pause was refused")

    def write(self, recipe, values):
        self.send("U", bytes([recipe.number]) + recipe.pack(values))

    def read(self, seconds=1.0):
        """The values of the next data package; the vendor's client gives up after a second without one."""
        end = time.monotonic() + seconds
        while True:
            packet = self.packet(max(0.0, end - time.monotonic()))
            if packet is None:
                raise TimeoutError("rtsi: no data for a second")
            if packet[0] == "U" and packet[1][0] in self.outputs:
                return self.outputs[packet[1][0]].unpack(packet[1][1:])
            if packet[0] == "M":
                self.messages.append(packet[1])

    def latest(self):
        """The next values after everything that has come so far, which is thrown away."""
        while self.packet(0.0):
            pass
        return self.read()

    def until(self, holds, seconds=5.0):
        """The first values for which `holds` is true."""
        while self.packet(0.0):
            pass  # the past does not count
        end = time.monotonic() + seconds
        while True:
            values = self.read()
            if holds(values):
                return values
            if time.monotonic() > end:
                raise AssertionError(f"rtsi: never came: {values}")


# --- 30001 ------------------------------------------------------------------------------------------------------------

STATE_LENGTHS = [(0, 53), (1, 347), (4, 101), (6, 445), (3, 88), (8, 10), (2, 37), (10, 43), (11, 28)]


class Primary(Client):
    """Port 30001: scripts out; states and exceptions in."""

    def __init__(self, port, host="127.0.0.1"):
        self.socket = socket.create_connection((host, port), timeout=10)
        self.buffer = b""
        self.local_ip = self.socket.getsockname()[0]
        # A connection is made before the controller has taken it, and what happens until then is not told to it. What
        # comes first stays.
        self.socket.recv(1, socket.MSG_PEEK)

    def send_script(self, text):
        self.socket.sendall(text.encode() + b"\n")

    def message(self, seconds=1.0):
        """The next message as (type, body after the five bytes of head), or None when there is none in time."""
        end = time.monotonic() + seconds
        while True:
            if len(self.buffer) >= 5:
                length, kind = struct.unpack(">IB", self.buffer[:5])
                if length <= 5:
                    raise AssertionError("an empty message")
                if len(self.buffer) >= length:
                    body, self.buffer = self.buffer[5:length], self.buffer[length:]
                    return kind, body
            left = end - time.monotonic()
            if not select.select([self.socket], [], [], max(0.0, left))[0]:
                return None
            part = self.socket.recv(65536)
            if not part:
                raise ConnectionError("primary: closed by the controller")
            self.buffer += part

    def state(self, seconds=1.0):
        """The next state, part by part; the fixed order and sizes of field clients are checked."""
        end = time.monotonic() + seconds
        while True:
            message = self.message(end - time.monotonic())
            if message is None:
                raise TimeoutError("primary: no state")
            if message[0] != 16:
                continue
            parts, rest, found = {}, message[1], []
            while rest:
                length, kind = struct.unpack(">IB", rest[:5])
                found.append((kind, length))
                parts[kind], rest = rest[:length], rest[length:]
            if found != STATE_LENGTHS:
                raise AssertionError(f"sub-packages {found}")
            return State(parts)

    def until(self, holds, seconds=10.0):
        end = time.monotonic() + seconds
        while True:
            state = self.state()
            if holds(state):
                return state
            if time.monotonic() > end:
                raise AssertionError(f"primary: never came: {vars(state)}")

    def exception(self, seconds=5.0):
        """The next exception as (kind, line or code, column or sub code, text)."""
        end = time.monotonic() + seconds
        while True:
            message = self.message(end - time.monotonic())
            if message is None:
                raise TimeoutError("primary: no exception")
            if message[0] != 20:
                continue
            self.exception_time = struct.unpack(">Q", message[1][:8])[0] / 1000
            kind = message[1][9]
            first, second = struct.unpack(">ii", message[1][10:18])
            if kind == 10:
                return kind, first, second, message[1][18:].rstrip(b"\0").decode()
            level, data_type = struct.unpack(">iI", message[1][18:26])
            text = message[1][26:].rstrip(b"\0").decode() if data_type == 5 else ""
            return kind, first, second, text


class State:
    """One state message."""

    def __init__(self, parts):
        self.parts = parts
        mode = parts[0]
        self.power_on, self.emergency, self.protective, self.running, self.paused = map(bool, mode[15:20])
        self.robot_mode = mode[20]
        self.speed_fraction, self.speed_scaling, self.fraction_limit = struct.unpack(">3d", mode[22:46])
        joints = [struct.unpack(">3d3i4fBI", parts[1][5 + 57 * j : 62 + 57 * j]) for j in range(6)]
        self.actual_q = [j[0] for j in joints]
        self.target_q = [j[1] for j in joints]
        self.joint_mode = [j[10] for j in joints]
        cartesian = struct.unpack(">12d", parts[4][5:])
        self.tcp_pose, self.tcp_offset = cartesian[:6], cartesian[6:]
        self.dh = struct.unpack(">18d", parts[6][237:381])
        self.robot_type = struct.unpack(">I", parts[6][437:441])[0]
        self.digital_in, self.digital_out = struct.unpack(">II", parts[3][5:13])
        self.safety_mode = parts[3][83]
