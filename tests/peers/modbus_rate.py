"""200 Modbus signals at 50 Hz: `python tests/peers/modbus_rate.py PROGRAM SECONDS [PEER ...]`.

PROGRAM is the example `modbus_rate` of io-bus. Peers: `pymodbus`, or `plain`, a device of a few lines that shows how
much of the lateness is the peer's. Addresses are side by side (shared requests) and ten apart (none shared).
"""

import asyncio
import struct
import subprocess
import sys
import threading

REGISTERS = 2000


class Plain(asyncio.Protocol):
    """Answers every read with zeros, as fast as Python can."""

    def connection_made(self, transport):
        self.transport, self.buffer = transport, b""

    def data_received(self, data):
        self.buffer += data
        answers = []
        while len(self.buffer) >= 12:
            transaction, _, _, unit, function, _, count = struct.unpack(">HHHBBHH", self.buffer[:12])
            self.buffer = self.buffer[12:]
            size = 2 * count
            answers.append(struct.pack(">HHHBBB", transaction, 0, 3 + size, unit, function, size) + bytes(size))
        self.transport.write(b"".join(answers))


def plain_device():
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, daemon=True).start()
    start = asyncio.run_coroutine_threadsafe(loop.create_server(Plain, "127.0.0.1", 0), loop)
    return start.result(5).sockets[0].getsockname()[1]


def pymodbus_device():
    from peers import ModbusDevice

    return ModbusDevice().port


def main():
    program, seconds, *peers = sys.argv[1:]
    for peer in peers or ["plain", "pymodbus"]:
        port = {"plain": plain_device, "pymodbus": pymodbus_device}[peer]()
        for spacing in [1, 10]:
            command = [program, "127.0.0.1", str(port), seconds, str(spacing)]
            print(
                f"{peer}: {subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()}",
                flush=True,
            )


if __name__ == "__main__":
    main()
