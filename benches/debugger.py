"""Times a debugger of Python or EliteScript on the same text: start, stops at breakpoints, pause, steps, looking,
slow-down.

    python3 benches/debugger.py target/release/eliteserver debug
    python3 benches/debugger.py python3 -m debugpy.adapter          # pip install debugpy
    python3 benches/debugger.py --both target/release/eliteserver   # one after the other, and the ratios
    python3 benches/debugger.py --back target/release/eliteserver debug   # stepBack at the end of 60 simulated seconds

Times are those that a client of the Debug Adapter Protocol sees on standard input and output.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from queue import Queue

PROGRAM = """\
def work(n):
    total = 0
    for i in range(n):
        total = total + i
        total = total % 1000003
    return total

class Part:
    def __init__(self, name):
        self.name = name
        self.values = list(range(20))

part = Part("bolt")
table = {"a": 1, "b": [1, 2, 3]}
rounds = 0
while rounds < 1000000:
    rounds = rounds + 1
    size = work(ROUND)
print("done", rounds)
"""
LINE = PROGRAM.splitlines().index("    rounds = rounds + 1") + 1


class Client:
    def __init__(self, command):
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self.number = 0
        self.messages = Queue()
        self.kept = []
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        stream = self.process.stdout
        while True:
            length = 0
            while line := stream.readline().strip():
                name, _, value = line.partition(b":")
                if name.lower() == b"content-length":
                    length = int(value)
            if not length:
                return
            self.messages.put(json.loads(stream.read(length)))

    def send(self, command, arguments=None):
        self.number += 1
        body = json.dumps(
            {"seq": self.number, "type": "request", "command": command, "arguments": arguments or {}}
        ).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self.process.stdin.flush()
        return self.number

    def wait(self, fits):
        for index, message in enumerate(self.kept):
            if fits(message):
                return self.kept.pop(index)
        while True:
            message = self.messages.get(timeout=120)
            if fits(message):
                return message
            self.kept.append(message)

    def ask(self, command, arguments=None):
        number = self.send(command, arguments)
        answer = self.wait(lambda m: m["type"] == "response" and m["request_seq"] == number)
        if not answer["success"]:
            raise SystemExit(f"{command}: {answer.get('message')}")
        return answer.get("body") or {}

    def event(self, name):
        return self.wait(lambda m: m["type"] == "event" and m["event"] == name)

    def close(self):
        self.send("disconnect", {"terminateDebuggee": True})
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()


def timed(count, action):
    times = []
    for _ in range(count):
        begun = time.perf_counter()
        action()
        times.append(1000 * (time.perf_counter() - begun))
    return times


def opened(command, path, line=LINE):
    """A session that is held at the breakpoint in a line, and how long that took, ms."""
    begun = time.perf_counter()
    client = Client(command)
    client.ask(
        "initialize", {"adapterID": "bench", "linesStartAt1": True, "columnsStartAt1": True, "pathFormat": "path"}
    )
    arguments = {
        "type": "python",
        "request": "launch",
        "program": path,
        "console": "internalConsole",
        "justMyCode": True,
    }
    if "debugpy" not in " ".join(command):
        arguments = {"program": path}
    launch = client.send("launch", arguments)
    client.event("initialized")
    client.ask("setBreakpoints", {"source": {"path": path}, "breakpoints": [{"line": line}]})
    client.ask("configurationDone")
    client.wait(lambda m: m["type"] == "response" and m["request_seq"] == launch)
    thread = client.event("stopped")["body"]["threadId"]
    return client, thread, 1000 * (time.perf_counter() - begun)


def measured(command, folder):
    path = os.path.join(folder, "program.py")
    with open(path, "w") as file:
        file.write(PROGRAM.replace("ROUND", "20"))
    client, thread, start = opened(command, path)
    figures = {"start until the first breakpoint holds": [start]}

    def go(request):
        client.ask(request, {"threadId": thread})
        client.event("stopped")

    figures["continue until the next breakpoint holds (a loop of 20 rounds between)"] = timed(
        200, lambda: go("continue")
    )
    figures["step over a statement"] = timed(300, lambda: go("next"))
    figures["step in"] = timed(300, lambda: go("stepIn"))

    def look():
        frames = client.ask("stackTrace", {"threadId": thread, "levels": 20})["stackFrames"]
        for scope in client.ask("scopes", {"frameId": frames[0]["id"]})["scopes"][:2]:
            client.ask("variables", {"variablesReference": scope["variablesReference"]})
        return frames

    def step_and_look():
        go("next")
        look()

    figures["step over, then stack, scopes and variables, as an editor does"] = timed(100, step_and_look)
    frame = look()[0]["id"]
    figures["evaluate a name"] = timed(
        100, lambda: client.ask("evaluate", {"expression": "rounds", "frameId": frame, "context": "hover"})
    )
    client.ask("setBreakpoints", {"source": {"path": path}, "breakpoints": []})
    client.ask("continue", {"threadId": thread})

    def pause():
        time.sleep(0.02)
        begun = time.perf_counter()
        client.ask("pause", {"threadId": thread})
        client.event("stopped")
        waits.append(1000 * (time.perf_counter() - begun))
        client.ask("continue", {"threadId": thread})

    waits = []
    for _ in range(50):
        pause()
    figures["pause until the program holds"] = waits
    client.close()
    figures["the loop of 400,000 rounds to its end, a breakpoint elsewhere"] = [loop(command, folder)]
    return figures


def loop(command, folder):
    """Time of a computing program while it is debugged, ms."""
    path = os.path.join(folder, "loop.py")
    text = PROGRAM.replace("rounds < 1000000", "rounds < 20000").replace("ROUND", "20")
    with open(path, "w") as file:
        file.write(text)
    client, thread, _ = opened(command, path)
    last = len(text.splitlines())
    client.ask("setBreakpoints", {"source": {"path": path}, "breakpoints": [{"line": last}]})
    begun = time.perf_counter()
    client.ask("continue", {"threadId": thread})
    client.event("stopped")
    took = 1000 * (time.perf_counter() - begun)
    client.close()
    return took


def moving():
    """A program whose last line comes after 60 simulated seconds of motions and waits."""
    poses = ["[0.5, -1.2, 1.4, -1.77, -1.57, 0]", "[-0.5, -1.2, 1.4, -1.77, -1.57, 0]"]
    lines = ["k = 0"]
    for n in range(30):
        lines += [f"movej({poses[n % 2]}, a=2, v=1)", "sleep(0.5)", "k = k + 1"]
    return "\n".join(lines + ["print(k)"]) + "\n"


def backwards(command):
    """Times of `stepBack` from the end of that program, ms, and the line to which they lead."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "moving.script")
        with open(path, "w") as file:
            file.write(moving())
        client, thread, _ = opened(command, path, len(moving().splitlines()))

        def back():
            client.ask("stepBack", {"threadId": thread})
            client.event("stopped")

        times = timed(40, back)
        frames = client.ask("stackTrace", {"threadId": thread, "levels": 1})["stackFrames"]
        client.close()
    return times, frames[0]["line"]


def p95(times):
    times = sorted(times)
    return times[min(len(times) - 1, int(0.95 * len(times)))]


def main(arguments):
    if arguments[:1] == ["--back"]:
        times, line = backwards(arguments[1:])
        print(
            f"40 times stepBack, to line {line}: median {statistics.median(times):.0f} ms, p95 {p95(times):.0f}, "
            f"most {max(times):.0f}"
        )
        return
    both = arguments[:1] == ["--both"]
    commands = (
        {"ours": [arguments[1], "debug"], "debugpy": [sys.executable, "-m", "debugpy.adapter"]}
        if both
        else {"": arguments}
    )
    with tempfile.TemporaryDirectory() as folder:
        results = {name: measured(command, folder) for name, command in commands.items()}
    first = next(iter(results.values()))
    for what in first:
        cells = []
        for name, figures in results.items():
            times = figures[what]
            cell = (
                f"{statistics.median(times):.2f} ms"
                if len(times) == 1
                else f"median {statistics.median(times):.2f} ms, p95 {p95(times):.2f} ms"
            )
            cells.append(f"{name} {cell}".strip())
        if both:
            ratio = statistics.median(results["debugpy"][what]) / statistics.median(results["ours"][what])
            cells.append(f"debugpy / ours {ratio:.1f}")
        print(f"{what}: {'; '.join(cells)}")


if __name__ == "__main__":
    main(sys.argv[1:] or ["target/release/eliteserver", "debug"])
