"""Peers that we did not write, for the tests of field buses: pymodbus over TCP and RTU, Python's XML-RPC server,
sockets.

Each peer is started on a free port by the test that needs it and lives in threads of this process.
"""

import asyncio
import logging
import os
import pty
import socket
import threading
import tty
import xmlrpc.server

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.framer import FramerType
from pymodbus.server import ModbusSerialServer, ModbusTcpServer

logging.getLogger("pymodbus").setLevel(logging.CRITICAL)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Loop:
    """An asyncio loop on a thread of its own."""

    def __init__(self):
        self.loop = asyncio.new_event_loop()
        threading.Thread(target=self.loop.run_forever, daemon=True).start()

    def do(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self.loop).result(10)


LOOP = Loop()


def store():
    """A device whose tables hold their own addresses: registers n, input registers 1000 + n, coils odd, inputs even."""
    count = 2000
    return ModbusSlaveContext(
        di=ModbusSequentialDataBlock(1, [n % 2 == 0 for n in range(count)]),
        co=ModbusSequentialDataBlock(1, [n % 2 == 1 for n in range(count)]),
        hr=ModbusSequentialDataBlock(1, list(range(count))),
        ir=ModbusSequentialDataBlock(1, [1000 + n for n in range(count)]),
    )


class ModbusDevice:
    """pymodbus as a Modbus TCP device."""

    def __init__(self, port=None):
        self.port = port or free_port()
        self.store = store()
        self.start()

    def start(self):
        context = ModbusServerContext(slaves=self.store, single=True)

        async def serve():
            self.server = ModbusTcpServer(context, address=("127.0.0.1", self.port))
            asyncio.ensure_future(self.server.serve_forever())
            await asyncio.sleep(0.1)

        LOOP.do(serve())

    def stop(self):
        LOOP.do(self.server.shutdown())

    def registers(self, address, count=1):
        return self.store.getValues(3, address, count)

    def coils(self, address, count=1):
        return self.store.getValues(1, address, count)


class RtuDevice:
    """pymodbus as a Modbus RTU device behind a pty, which is where the robot's serial port leads."""

    def __init__(self):
        ours, theirs = pty.openpty()
        robots, robot_side = pty.openpty()
        for end in (ours, theirs, robots, robot_side):
            tty.setraw(end)
        self.path = os.ttyname(robot_side)
        self.store = store()
        self.damage_next = False
        self.keep = (theirs, robot_side)
        self.device_path = os.ttyname(theirs)
        for source, target, answers in ((robots, ours, False), (ours, robots, True)):
            threading.Thread(target=self.carry, args=(source, target, answers), daemon=True).start()
        context = ModbusServerContext(slaves={7: self.store}, single=False)

        async def serve():
            self.server = ModbusSerialServer(context, framer=FramerType.RTU, port=self.device_path, baudrate=115200)
            asyncio.ensure_future(self.server.serve_forever())
            await asyncio.sleep(0.2)

        LOOP.do(serve())

    def carry(self, source, target, answers):
        while True:
            data = bytearray(os.read(source, 1024))
            if answers and self.damage_next and data:
                data[-1] ^= 0xFF
                self.damage_next = False
            os.write(target, bytes(data))


class RpcServer:
    """Python's own XML-RPC server."""

    def __init__(self):
        handler = xmlrpc.server.SimpleXMLRPCRequestHandler
        handler.protocol_version = "HTTP/1.1"
        self.connections = 0
        outer = self

        class Server(xmlrpc.server.SimpleXMLRPCServer):
            def get_request(self):
                outer.connections += 1
                return super().get_request()

        self.server = Server(
            ("127.0.0.1", 0), requestHandler=handler, allow_none=True, logRequests=False, use_builtin_types=True
        )
        self.port = self.server.server_address[1]
        self.server.register_function(lambda value: value, "echo")
        self.server.register_function(lambda a, b: a + b, "add")
        self.server.register_function(lambda: "seen", "camera.capture")
        self.server.register_function(lambda: 1 // 0, "fail")
        threading.Thread(target=self.server.serve_forever, daemon=True).start()


class Talker:
    """A plain TCP server that runs `talk(connection)` for each client."""

    def __init__(self, talk):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.talk = talk
        self.errors = []
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            connection, _ = self.listener.accept()
            threading.Thread(target=self.guard, args=(connection,), daemon=True).start()

    def guard(self, connection):
        try:
            with connection:
                self.talk(connection)
        except Exception as error:  # shown by the test that looks at it
            self.errors.append(error)
