"""Times a language server on a program of 5,000 lines: start, findings after a key, completion, memory.

    python3 benches/language_server.py target/release/eliteserver lsp
    python3 benches/language_server.py pylsp

Each key waits for its findings, as it comes to people. Linux.
"""

import json
import resource
import statistics
import subprocess
import sys
import time


def program(lines):
    """Stations with a class and a function each, in the manner of real programs."""
    out = ["import math", "from time import sleep as nap", ""]
    number = 0
    while len(out) < lines:
        number += 1
        out += [
            f"class Station{number}:",
            "    def __init__(self, name, speed=0.25):",
            "        self.name = name",
            "        self.speed = speed",
            "        self.count = 0",
            "        self.poses = [[0.1, 0.2, 0.3, 0, 3.14, 0], [0.2, 0.2, 0.3, 0, 3.14, 0]]",
            "    def approach(self, index, height=0.05):",
            "        pose = self.poses[index]",
            "        above = pose_add(pose, [0, 0, height, 0, 0, 0])",
            "        movel(above, 1.2, self.speed)",
            "        movel(pose, 1.2, self.speed / 2)",
            "        return above",
            "    def pick(self):",
            "        above = self.approach(0)",
            "        set_standard_digital_out(1, True)",
            "        sleep(0.2)",
            "        movel(above, a=1.2, v=self.speed)",
            "        self.count += 1",
            "        return self.count",
            "",
            f"def run_{number}(limit=10):",
            f"    station = Station{number}('s{number}', speed=0.5)",
            "    done = 0",
            "    while done < limit:",
            "        if get_standard_digital_in(0):",
            "            done = station.pick()",
            "        else:",
            "            sync()",
            "    values = [math.sin(i) for i in range(limit) if i % 2 == 0]",
            "    return sum(values) + done",
            "",
        ]
    return out[:lines]


class Client:
    def __init__(self, command):
        begun = time.perf_counter()
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self.number = 0
        self.notes = []
        self.ask("initialize", {"processId": None, "rootUri": None, "capabilities": {}})
        self.start = time.perf_counter() - begun
        self.note("initialized", {})

    def send(self, message):
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self.process.stdin.flush()

    def receive(self):
        length = 0
        while line := self.process.stdout.readline().strip():
            name, _, value = line.partition(b":")
            if name.lower() == b"content-length":
                length = int(value)
        return json.loads(self.process.stdout.read(length))

    def note(self, method, params):
        self.send({"method": method, "params": params})

    def ask(self, method, params):
        self.number += 1
        self.send({"id": self.number, "method": method, "params": params})
        while True:
            message = self.receive()
            if message.get("id") == self.number and "method" not in message:
                return message
            self.notes.append(message)

    def findings(self, version):
        while True:
            message = self.notes.pop(0) if self.notes else self.receive()
            if message.get("method") == "textDocument/publishDiagnostics":
                if message["params"].get("version", version) == version:
                    return message["params"]["diagnostics"]

    def memory(self):
        with open(f"/proc/{self.process.pid}/status") as status:
            return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmHWM"))

    def processor(self):
        fields = open(f"/proc/{self.process.pid}/stat").read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / 100


def shown(name, times):
    times = sorted(1000 * t for t in times)
    p99 = times[min(len(times) - 1, int(0.99 * len(times)))]
    print(f"{name}: median {statistics.median(times):.1f} ms, p99 {p99:.1f} ms, of {len(times)}")


def main(command):
    keys = 100
    lines = program(5000)
    client = Client(command)
    print(f"start until 'initialize' is answered: {1000 * client.start:.0f} ms")
    uri = "file:///tmp/bench.py"
    text = "\n".join(lines) + "\n"
    client.note(
        "textDocument/didOpen", {"textDocument": {"uri": uri, "languageId": "python", "version": 1, "text": text}}
    )
    client.findings(1)
    at = len(lines) // 2 // 31 * 31 + 3 + 9
    typed, found, completed = "", [], []
    before = client.processor()
    for key in range(keys):
        place = {"line": at, "character": 8 + len(typed)}
        letter = "self.speed + "[key % 13]
        begun = time.perf_counter()
        client.note(
            "textDocument/didChange",
            {
                "textDocument": {"uri": uri, "version": key + 2},
                "contentChanges": [{"range": {"start": place, "end": place}, "text": letter}],
            },
        )
        typed += letter
        client.findings(key + 2)
        found.append(time.perf_counter() - begun)
    after_keys = client.processor()
    for _ in range(keys):
        begun = time.perf_counter()
        client.ask("textDocument/completion", {"textDocument": {"uri": uri}, "position": {"line": at, "character": 8}})
        completed.append(time.perf_counter() - begun)
    shown("findings after a key", found)
    shown("completion", completed)
    shares = [1000 * (after_keys - before) / keys, 1000 * (client.processor() - after_keys) / keys]
    print("processor time of the server: {:.1f} ms a key, {:.1f} ms a completion".format(*shares))
    print(f"largest resident memory: {client.memory():.0f} MB")
    client.ask("shutdown", None)
    client.note("exit", None)
    client.process.wait(10)


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    main(sys.argv[1:] or ["target/release/eliteserver", "lsp"])
