"""Figures of port 40011: `python3 tests/clients/query_rate.py [questions] [options of serve]`.

One client asks, waits for the answer and asks again: a value of the robot, inverse kinematics, and a value while a
program runs beside. Then four clients ask at once. Prints questions a second and the time of an answer in ms: median,
99 of 100, longest.
"""

import socket
import statistics
import sys
import threading
import time

import server as servers
from elite import Primary
from server import Server

GET = "get_actual_joint_positions()"
INVERSE = "get_inverse_kin([-0.4, -0.3, 0.4, 3.14, 0, 1.57], [0, -1.57, 1.57, -1.57, -1.57, 0])"


class Query:
    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.number = 0

    def ask(self, statement):
        self.number += 1
        self.socket.sendall(f"req {self.number} {statement}\n".encode())
        answer = b""
        while not answer.endswith(b"\n"):
            part = self.socket.recv(4096)
            if not part:
                raise ConnectionError("closed")
            answer += part
        answer = answer.decode()
        if not answer.startswith(f"[{self.number}] [success]"):
            raise AssertionError(answer)


def ask_often(port, statement, count, waits):
    client = Query(port)
    for _ in range(count):
        asked = time.perf_counter()
        client.ask(statement)
        waits.append((time.perf_counter() - asked) * 1e3)


def measure(name, port, statement, count, clients=1):
    waits = []
    begin = time.perf_counter()
    threads = [
        threading.Thread(target=ask_often, args=(port, statement, count // clients, waits)) for _ in range(clients)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    took = time.perf_counter() - begin
    waits.sort()
    print(
        f"{name}: {len(waits) / took:.0f} questions/s, median {statistics.median(waits):.2f}, "
        f"99 of 100 {waits[len(waits) * 99 // 100]:.2f}, longest {waits[-1]:.1f}"
    )


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    servers.SERVICES.append("query")
    with Server(*sys.argv[2:]) as server:
        port = server.ports["query"]
        measure("a value", port, GET, count)
        measure("inverse kinematics", port, INVERSE, count)
        measure("a value, four clients", port, GET, count, 4)
        Primary(server.ports["primary"]).send_script("def busy():\n\twhile True:\n\t\tsync()\n\tend\nend")
        time.sleep(0.5)
        measure("a value beside a program", port, GET, count)
        measure("inverse kinematics beside a program", port, INVERSE, count)


if __name__ == "__main__":
    main()
