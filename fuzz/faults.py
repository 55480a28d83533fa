#!/usr/bin/env python3
"""Faults around the controller: it is killed, stopped, its disk fills up, its outputs close,
its clients are slow or mad.

    fuzz/faults.py target/debug/eliteserver                    # the bounded run of CI
    fuzz/faults.py BINARY --kills 200 --seconds 60 --seed 7    # a long one
    fuzz/faults.py BINARY --only kill,stop

Each trial starts the binary on ports of its own. What is random is a function of the seed and the trial's number. The
table at the end says what was tried, how often and with what result; the exit status is 1 when a promise was broken.
Standard library only.
"""

import argparse
import contextlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

SERVICES = ["primary", "interpreter", "rtsi", "dashboard", "modbus", "http", "foxglove"]
HERE = pathlib.Path(__file__).resolve().parent
# SIGTERM ends the process within this (INTERFACES: 2 s); a machine that runs other tests gets a little more.
STOP_MAX = 2.0
# A recording lacks at most this much of what was there when its writer was killed.
LOST_MAX = 1.0

SWING = """def swing():
  while True:
    movej([0.2, -1.57, 0.1, -1.57, 0, 0], a=2, v=1)
    movej([-0.2, -1.57, -0.1, -1.57, 0, 0], a=2, v=1)
    textmsg("swing")
  end
end
"""


class Broken(Exception):
    """A promise was broken."""


def must(holds, text):
    if not holds:
        raise Broken(text)


class Server:
    """`serve` in a folder of its own."""

    def __init__(
        self,
        binary,
        *options,
        record="off",
        clock="realtime",
        stderr=None,
        env=None,
        folder=None,
        before=None,
        tasks=None,
    ):
        self.folder = pathlib.Path(folder or tempfile.mkdtemp(prefix="faults-"))
        (self.folder / "tasks").mkdir(exist_ok=True)
        for name, text in (tasks or {}).items():
            (self.folder / "tasks" / name).write_text(text)
        self.ready = self.folder / "ready.json"
        command = [
            *(before or []),
            str(binary),
            "serve",
            "--ready-file",
            str(self.ready),
            "--record",
            str(record),
            "--clock",
            clock,
        ]
        command += ["--plant", "ideal"]
        for service in SERVICES:
            command += [f"--{service}-port", "0"]
        self.log = self.folder / "stderr.log"
        own = open(self.log, "wb") if stderr is None else None
        environment = {name: value for name, value in os.environ.items() if name != "RUST_LOG"} | (env or {})
        self.process = subprocess.Popen(
            command + list(options),
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=own or stderr,
            env=environment,
        )
        if own:
            own.close()
        end = time.monotonic() + 30
        while True:
            with contextlib.suppress(OSError, ValueError):
                self.ports = json.loads(self.ready.read_text())["ports"]
                break
            must(self.process.poll() is None and time.monotonic() < end, f"does not start: {self.said()[-300:]}")
            time.sleep(0.01)
        self.started = time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def said(self):
        return self.log.read_text(errors="replace") if self.log.exists() else ""

    def connect(self, service, timeout=3.0):
        return socket.create_connection(("127.0.0.1", self.ports[service]), timeout)

    def send(self, text):
        """A program to 30001; the connection stays open."""
        connection = self.connect("primary")
        connection.sendall(text.encode())
        return connection

    def order(self, line):
        """One order to the dashboard, and its reply."""
        with self.connect("dashboard") as connection:
            connection.sendall(line.encode() + b"\n")
            connection.settimeout(3)
            text = b""
            with contextlib.suppress(OSError):
                while not text.endswith(b"\n"):
                    piece = connection.recv(4096)
                    if not piece:
                        break
                    text += piece
            return text.decode(errors="replace").strip()

    def health(self):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.ports['http']}/healthz", timeout=10) as answer:
            return answer.status

    def metric(self, name):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.ports['http']}/metrics", timeout=10) as answer:
            text = answer.read().decode()
        found = re.search(rf"^{re.escape(name)}(?:\{{[^}}]*\}})? ([0-9.e+-]+)$", text, re.M)
        return float(found[1]) if found else None

    def cycle(self):
        """The number of the latest cycle."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.ports['http']}/healthz", timeout=10) as answer:
            return json.loads(answer.read())["cycle"]

    def alive(self, after):
        must(
            self.process.poll() is None,
            f"{after}: the process has ended with status {self.process.poll()}: {self.said()[-300:]}",
        )
        try:
            must(self.health() == 200, f"{after}: not well")
            first = self.cycle()
            time.sleep(0.1)
            must(self.cycle() > first, f"{after}: cycles stand still")
        except OSError as error:
            raise Broken(f"{after}: /healthz says {error}") from error

    def rss_mib(self):
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
        return 0.0

    def ended(self, how=signal.SIGTERM, status=(0,), within=STOP_MAX):
        """Sends the signal; how long the process took, which must be short."""
        begin = time.monotonic()
        self.process.send_signal(how)
        try:
            code = self.process.wait(within + 8)
        except subprocess.TimeoutExpired:
            raise Broken(f"{signal.Signals(how).name}: still there after {within + 8:.0f} s") from None
        took = time.monotonic() - begin
        must(took <= within, f"{signal.Signals(how).name}: took {took:.2f} s")
        must(code in status, f"{signal.Signals(how).name}: status {code}: {self.said()[-300:]}")
        return took


def figures(binary, recording):
    """What `replay` says of a recording, which it must be able to read."""
    done = subprocess.run([binary, "replay", recording], capture_output=True, text=True, timeout=60)
    must(done.returncode == 0, f"replay: status {done.returncode}: {done.stderr.strip()[-200:]}")
    return {
        name: float(value) for name, value in re.findall(r"^(cycles|missing|duration): ([0-9.]+)", done.stdout, re.M)
    }


# Trials: each is given the binary, a random number generator and the options;
# what it returns is a remark for the table.


def kill(binary, rng, options):
    """kill -9 while a program runs and is recorded"""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        recording = pathlib.Path(folder) / "run.mcap"
        with Server(binary, record=recording) as server:
            with server.send(SWING):
                time.sleep(rng.uniform(0.0, 3.0))
                cycles, at = server.cycle(), time.monotonic()
                time.sleep(rng.uniform(0.0, 0.3))
                server.process.kill()
                server.process.wait()
                cycles += int((time.monotonic() - at) / 0.004)
        found = figures(binary, recording)
        must(found["missing"] == 0, f"{found['missing']:.0f} cycles are missing in the middle")
        lost = (cycles - found["cycles"]) * 0.004
        must(lost <= LOST_MAX, f"{lost:.2f} s are lost")
        return lost


def disk_full(binary, rng, options):
    """the recording's disk (a tmpfs of some MiB) fills up while a program runs"""
    inside = os.environ.get("FAULTS_NAMESPACE")
    if not inside:
        arguments = [
            sys.executable,
            __file__,
            str(binary),
            "--only",
            "disk_full",
            "--seed",
            str(rng.randrange(1 << 30)),
            "--times",
            "1",
            "--bare",
        ]
        done = subprocess.run(
            ["unshare", "-m", *arguments], capture_output=True, text=True, env=os.environ | {"FAULTS_NAMESPACE": "1"}
        )
        if "unshare" in done.stderr and "not permitted" in done.stderr:
            return "not tried: no mount namespaces here"
        must(done.returncode == 0, done.stdout.strip()[-300:] + done.stderr.strip()[-300:])
        return None
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        disk = pathlib.Path(folder) / "disk"
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={rng.choice([64, 256, 1024])}k", "none", disk], check=True)
        try:
            recording = disk / "run.mcap"
            with Server(binary, record=recording) as server, server.send(SWING):
                end = time.monotonic() + 40
                while "No space left" not in server.said():
                    must(time.monotonic() < end, "the disk does not fill up")
                    time.sleep(0.1)
                server.alive("disk full")
                time.sleep(1.0)
                lines = server.said().count("No space left")
                must(lines <= 3, f"{lines} lines about a full disk in a second")
                server.ended(status=(0, 1))
            if recording.exists() and recording.stat().st_size > 8000:
                figures(binary, recording)
        finally:
            subprocess.run(["umount", "-l", disk], check=True)


def slow_disk(binary, rng, options):
    """the recording goes into a pipe that is read slowly, then not at all"""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        pipe = pathlib.Path(folder) / "run.mcap"
        os.mkfifo(pipe)
        reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
        try:
            with Server(binary, record=pipe) as server, server.send(SWING):
                end = time.monotonic() + rng.uniform(1.0, 2.0)
                while time.monotonic() < end:
                    with contextlib.suppress(BlockingIOError):
                        os.read(reader, 2048)
                    time.sleep(0.02)
                time.sleep(1.0)
                server.alive("nobody reads the recording")
                server.ended(status=(0, 1))
        finally:
            os.close(reader)


def stderr_closed(binary, rng, options):
    """standard error is a closed pipe"""
    reading, writing = os.pipe()
    with Server(binary, stderr=writing, env={"RUST_LOG": "debug"}) as server:
        os.close(writing)
        os.close(reading)
        with server.send(SWING):
            for _ in range(50):
                server.order("nonsense")
            server.alive("standard error closed")
            server.ended(status=(0, 1))


def stderr_full(binary, rng, options):
    """standard error is a full device"""
    with (
        open("/dev/full", "wb") as full,
        Server(binary, stderr=full, env={"RUST_LOG": "debug"}) as server,
        server.send(SWING),
    ):
        for _ in range(50):
            server.order("nonsense")
        server.alive("standard error full")
        server.ended(status=(0, 1))


def stderr_unread(binary, rng, options):
    """standard error is a pipe that nobody reads"""
    reading, writing = os.pipe()
    with Server(binary, stderr=writing, env={"RUST_LOG": "trace"}) as server:
        os.close(writing)
        chatter = (
            'def talk():\n  n = 0\n  while True:\n    textmsg("'
            + "x" * 200
            + '", n)\n    n += 1\n    sync()\n  end\nend\n'
        )
        with server.send(chatter):
            for _ in range(300):
                server.order("nonsense " * 10)
            time.sleep(1.0)
            server.alive("standard error unread")
            server.ended(status=(0, 1))
        os.close(reading)


def stdout_closed(binary, rng, options):
    """`run`, `builtins` and `replay` write into a pipe that closes, or a full device"""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        program = pathlib.Path(folder) / "p.script"
        program.write_text('def p():\n  for n in range(3000):\n    print("line", n, "' + "x" * 60 + '")\n  end\nend\n')
        recording = pathlib.Path(folder) / "a.mcap"
        subprocess.run([binary, "run", program, "--record", recording], capture_output=True, timeout=60, check=True)
        commands = [
            ["run", program],
            ["builtins"],
            ["replay", recording],
            ["replay", recording, "--csv", "/cycle"],
            ["--help"],
            ["check", program],
        ]
        for command in commands:
            for target in ["closed", "full"]:
                if target == "closed":
                    reading, out = os.pipe()
                    os.close(reading)
                else:
                    out = os.open("/dev/full", os.O_WRONLY)
                done = subprocess.run(
                    [binary, *command],
                    stdin=subprocess.DEVNULL,
                    stdout=out,
                    stderr=subprocess.PIPE,
                    text=True,
                    timeout=60,
                )
                os.close(out)
                name = f"{' '.join(map(str, command[:1] + command[2:]))} with stdout {target}"
                must("panicked" not in done.stderr, f"{name} panics: {done.stderr[-300:]}")
                # A signal that says "nobody reads" is the custom of such commands.
                must(done.returncode >= 0 or -done.returncode == signal.SIGPIPE, f"{name}: signal {-done.returncode}")


def slow_clients(binary, rng, options):
    """64 clients a port that read nothing or send half a request; one more each; orders and cycles go on"""
    with Server(binary) as server:
        clients = []
        for service in SERVICES:
            for number in range(64):
                with contextlib.suppress(OSError):
                    client = socket.socket()
                    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                    client.settimeout(3)
                    client.connect(("127.0.0.1", server.ports[service]))
                    half = {
                        "primary": b"def x",
                        "http": b"GET /healthz HT",
                        "dashboard": b"rob",
                        "modbus": b"\0\1\0\0\0\6\1",
                        "rtsi": b"\0\5V",
                        "interpreter": b"x =",
                        "foxglove": b"GET / HTTP/1.1\r\nUpgr",
                    }[service]
                    if number % 2 and not (service in ("dashboard", "http") and number > 60):
                        client.sendall(half)
                    clients.append((service, client))
        for service in SERVICES:
            client = server.connect(service)
            clients.append((service, client))
        # Room for those who look whether it is well.
        for service, client in clients:
            if service in ("http", "dashboard"):
                client.close()
        time.sleep(1.5)
        server.alive("64 slow clients a port")
        begin = time.monotonic()
        reply = server.order("robotMode")
        must(reply, "no reply to robotMode")
        took = time.monotonic() - begin
        must(took < 2.0, f"robotMode took {took:.1f} s")
        rss = server.rss_mib()
        must(rss < 600, f"{rss:.0f} MiB resident")
        for _, client in clients:
            client.close()
        server.ended()
        return f"{rss:.0f} MiB"


SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <sys/time.h>
#include <time.h>
/* The time of day jumps by hours forth and back ten times a second; clocks that only go forward are left alone. */
static long long jump(void) {
    struct timespec now;
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    real(CLOCK_MONOTONIC, &now);
    long long step = now.tv_sec * 10 + now.tv_nsec / 100000000;
    return (step * 2654435761LL % 200000) - 100000;
}
int clock_gettime(clockid_t clock, struct timespec *out) {
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    int result = real(clock, out);
    if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) out->tv_sec += jump();
    return result;
}
int gettimeofday(struct timeval *out, void *zone) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    out->tv_sec = now.tv_sec;
    out->tv_usec = now.tv_nsec / 1000;
    return 0;
}
time_t time(time_t *out) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out) *out = now.tv_sec;
    return now.tv_sec;
}
"""


def clock_jumps(binary, rng, options):
    """the time of day jumps by hours ten times a second under a running program"""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        folder = pathlib.Path(folder)
        (folder / "jump.c").write_text(SHIM)
        if not shutil.which("cc"):
            return "not tried: no C compiler"
        subprocess.run(["cc", "-shared", "-fPIC", "-o", folder / "jump.so", folder / "jump.c"], check=True)
        recording = folder / "a.mcap"
        program = (
            "def p():\n  import time\n  sleep(0.5)\n  a = time.monotonic()\n  time.sleep(0.5)\n  b = time.monotonic()\n"
            "  textmsg('waited ', round(b - a, 1))\n  while True:\n    movej([0.1, -1.57, 0, -1.57, 0, 0])\n"
            "    movej([0, -1.57, 0, -1.57, 0, 0])\n  end\nend\n"
        )
        with (
            Server(binary, record=recording, env={"LD_PRELOAD": str(folder / "jump.so")}) as server,
            server.send(program),
        ):
            begin, first = time.monotonic(), server.cycle()
            time.sleep(3.0)
            cycles, elapsed = server.cycle() - first, time.monotonic() - begin
            must(abs(cycles * 0.004 / elapsed - 1) < 0.2, f"{cycles} cycles in {elapsed:.1f} s")
            must("waited 0.5" in server.said(), "a wait of half a second did not take half a second")
            server.alive("the clock jumps")
            server.ended()
        found = figures(binary, recording)
        must(found["missing"] == 0 and found["cycles"] > 0.8 * cycles, f"{found} of {cycles} cycles")


# What a controller may be doing when it is told to end. Texts go to 30001.
STATES = {
    "idle": None,
    "moving": SWING,
    "busy loop": "def p():\n  while True:\n    pass\n  end\nend\n",
    "busy in one native": "def p():\n  x = 3 ** 2000000\n  while True:\n    x = x * x // (x + 1)\n  end\nend\n",
    "sorting": (
        "def p():\n  a = [(n * 7919) % 100003 for n in range(300000)]\n  while True:\n    sorted(a)\n"
        "    sorted(a, key=lambda x: -x)\n  end\nend\n"
    ),
    "regular expression": (
        "def p():\n  import re\n  while True:\n    try:\n      re.match(r'(a|aa)*\\1b', 'a' * 3000)\n"
        "    except RuntimeError:\n      pass\n    end\n  end\nend\n"
    ),
    "filling memory": (
        "def p():\n  while True:\n    try:\n      a = []\n      while True:\n        a.append([a])\n      end\n"
        "    except MemoryError:\n      pass\n    end\n  end\nend\n"
    ),
    "sleeping": "def p():\n  sleep(100000)\nend\n",
    "waiting for a name": (
        "def p():\n  while True:\n    try:\n      socket_open('name-that-does-not-exist.invalid', 5000, 's')\n"
        "    except Exception:\n      pass\n    end\n    sleep(0.01)\n  end\nend\n"
    ),
    "waiting for a socket": (
        "def p():\n  socket_open('127.0.0.1', {silent}, 's')\n  while True:\n"
        "    socket_read_string('s', timeout=100000)\n  end\nend\n"
    ),
    "waiting for an RPC": "def p():\n  r = rpc_factory('xmlrpc', 'http://127.0.0.1:{silent}/')\n  r.nothing()\nend\n",
    "popup": "def p():\n  popup('text', blocking=True)\n  sleep(1000)\nend\n",
    "finally that goes on": (
        "def p():\n  try:\n    sleep(100000)\n  finally:\n    while True:\n      pass\n    end\n  end\nend\n"
    ),
    "many threads": (
        "def p():\n  def t():\n    while True:\n      x = [1] * 1000\n    end\n  end\n  for n in range(30):\n"
        "    start_thread(t, ())\n  end\n  sleep(1000)\nend\n"
    ),
    "printing": "def p():\n  while True:\n    print('x' * 1000)\n  end\nend\n",
    "generators without end": "def p():\n  def g():\n    while True:\n      yield 1\n    end\n  end\n  sum(g())\nend\n",
    "interpreter mode": "def p():\n  interpreter_mode()\nend\n",
    "force mode": (
        "def p():\n  force_mode([0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, -5, 0, 0, 0], 0, "
        "[0.1, 0.1, 0.1, 0.3, 0.3, 0.3])\n  sleep(1000)\nend\n"
    ),
    "freedrive": "def p():\n  freedrive_mode()\n  sleep(1000)\nend\n",
    "a text that takes long to compile": "def p():\n" + "  x = f(1, 2, 3)\n" * 60000 + "end\n",
    "a text that is not whole": "def p():\n" + "  x = [" * 3000,
    "paused": SWING,
    "powered off": None,
}


def stopped_in(binary, rng, name, silent):
    """How long the process took to end in this state."""
    how, clock = rng.choice([signal.SIGTERM, signal.SIGINT]), rng.choice(["realtime", "virtual"])
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        recording = pathlib.Path(folder) / "a.mcap"
        with Server(binary, record=recording, clock=clock) as server, contextlib.ExitStack() as stack:
            text = STATES[name]
            if text:
                stack.enter_context(server.send(text.replace("{silent}", str(silent.getsockname()[1]))))
            time.sleep(rng.uniform(0.3, 1.0))
            if name == "paused":
                server.order("pause")
            if name == "powered off":
                server.order("robotControl -off")
            try:
                took = server.ended(how, status=(0,))
            except Broken as error:
                raise Broken(f"{clock} clock: {error}") from None
            must(not server.ready.exists(), "the ready file is still there")
        figures(binary, recording)
        return took


def stop(binary, rng, options):
    """SIGTERM or SIGINT in each of two dozen states: gone within 2 s, the recording closed"""
    took, broken = [], []
    with socket.create_server(("127.0.0.1", 0)) as silent:
        for name in [options.state] if options.state else STATES:
            try:
                took.append(stopped_in(binary, rng, name, silent))
            except (Broken, OSError) as error:
                broken.append(f"{name}: {error}")
    must(not broken, "; ".join(broken))
    return max(took)


def stop_while_starting(binary, rng, options):
    """SIGTERM while it starts"""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        command = [
            binary,
            "serve",
            "--record",
            "a.mcap",
            *(part for service in SERVICES for part in (f"--{service}-port", "0")),
        ]
        process = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        )
        time.sleep(rng.uniform(0.0, 0.15))
        begin = time.monotonic()
        process.terminate()
        try:
            process.wait(STOP_MAX + 8)
        except subprocess.TimeoutExpired:
            process.kill()
            raise Broken("still there after 10 s") from None
        took = time.monotonic() - begin
        must(took <= STOP_MAX, f"took {took:.2f} s")
        # Before its handlers stand, the signal ends it as any other process.
        must(process.returncode in (0, -signal.SIGTERM), f"status {process.returncode}")
        return took


BEGINNINGS = {
    "primary": [
        SWING.encode(),
        b"def p():\n  x = 1\nend\n",
        b"sec s():\n  textmsg('a')\nend\n",
        b"x = 1\n",
        b"stop task\n",
        b"1abcd\n",
        b"GET / HTTP/1.1\r\n\r\n",
    ],
    "interpreter": [
        b"x = 1\n",
        b"clear_interpreter()\n",
        b"abort\n",
        b"skipbuffer\n",
        b"statelastexecuted\n",
        b"def f():\n",
    ],
    "rtsi": [
        b"\0\5V\0\1",
        b"\0\x20O\x40\x5f\x40\0\0\0\0\0timestamp,robot_mode",
        b"\0\3S",
        b"\0\3P",
        b"\0\x1cIspeed_slider_mask,x",
        b"\0\4U\1",
    ],
    "dashboard": [
        b"robotMode\n",
        b"help\n",
        b"play\n",
        b"stop\n",
        b"task -p a\n",
        b"popup -s x\n",
        b"log -a x\n",
        b"variable -get x\n",
        b"speed -v 50\n",
    ],
    "modbus": [
        b"\0\1\0\0\0\6\1\1\0\0\0\x08",
        b"\0\1\0\0\0\6\1\3\0\0\0\x7d",
        b"\0\1\0\0\0\x0b\1\x10\0\0\0\2\4\0\1\0\2",
        b"\0\1\0\0\0\6\1\5\0\0\xff\0",
    ],
    "http": [
        b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
        b"GET /panel HTTP/1.0\r\n\r\n",
        b"POST /api/inputs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 13\r\n"
        b'\r\n{"DI0": true}',
        b'POST /api/inputs HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n{"DI0\r\n0\r\n\r\n',
    ],
    "foxglove": [
        b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Version: 13\r\n"
        b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n"
        b'\x81\x85\0\0\0\0{"op"',
        b"GET / HTTP/1.1\r\nUpgrade: websocket\r\n\r\n\x82\xff\xff\xff\xff\xff\xff\xff\xff\xff",
    ],
}


def damaged(rng, data):
    data = bytearray(data)
    for _ in range(rng.randrange(4)):
        at = rng.randrange(len(data) + 1)
        how = rng.randrange(6)
        if how == 0 and at < len(data):
            data[at] ^= 1 << rng.randrange(8)
        elif how == 1:
            del data[at : at + rng.randrange(9)]
        elif how == 2:
            data[at:at] = rng.randbytes(rng.randrange(9))
        elif how == 3:
            data[at:at] = data[at : at + 20] * rng.randrange(50)
        elif how == 4 and at < len(data):
            data[at] = rng.choice([0, 1, 0x7F, 0x80, 0xFF])
        else:
            del data[at:]
    return bytes(data)


def any_bytes(binary, rng, options):
    """damaged requests and noise at every port of a controller, in pieces, for some seconds"""
    with Server(
        binary,
        "--powered-off" if rng.random() < 0.2 else "--local" if rng.random() < 0.2 else "--seed=1",
        clock=rng.choice(["realtime", "virtual"]),
    ) as server:
        base, count, end = server.rss_mib(), [0], time.monotonic() + options.seconds

        def knock(seed):
            own = random.Random(seed)
            while time.monotonic() < end and server.process.poll() is None:
                service = own.choice(SERVICES)
                data = b"".join(damaged(own, own.choice(BEGINNINGS[service])) for _ in range(own.randrange(1, 6)))
                if own.random() < 0.1:
                    data = own.randbytes(own.randrange(3000))
                with contextlib.suppress(OSError):
                    with server.connect(service, timeout=1) as connection:
                        for part in [data[: len(data) // 2], data[len(data) // 2 :]]:
                            connection.sendall(part)
                        connection.settimeout(own.choice([0.001, 0.02]))
                        connection.recv(10000)
                count[0] += 1

        threads = [threading.Thread(target=knock, args=(rng.randrange(1 << 30),)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        server.alive("any bytes")
        must("panicked" not in server.said(), f"a panic: {server.said()[-300:]}")
        grown = server.rss_mib() - base
        must(grown < 400, f"{grown:.0f} MiB more than at the start")
        server.ended()
        return f"{count[0]} connections"


TRIALS = {
    "kill": kill,
    "disk_full": disk_full,
    "slow_disk": slow_disk,
    "stderr_closed": stderr_closed,
    "stderr_full": stderr_full,
    "stderr_unread": stderr_unread,
    "stdout_closed": stdout_closed,
    "slow_clients": slow_clients,
    "clock_jumps": clock_jumps,
    "stop": stop,
    "stop_while_starting": stop_while_starting,
    "any_bytes": any_bytes,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("binary", type=pathlib.Path)
    parser.add_argument("--only", help="names of trials, with commas: " + ", ".join(TRIALS))
    parser.add_argument(
        "--kills", type=int, default=10, help="trials of kill -9 and of stopping while starting (default 10)"
    )
    parser.add_argument("--times", type=int, default=1, help="how often each other trial (default 1)")
    parser.add_argument("--seconds", type=float, default=8, help="length of any_bytes (default 8)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", dest="first", type=int, default=0, help="number of the first trial")
    parser.add_argument("--state", choices=list(STATES), help="only this state of stop")
    parser.add_argument("--bare", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    binary = options.binary.resolve()
    if not binary.exists():
        parser.error(f"there is no {binary}")
    names = options.only.split(",") if options.only else list(TRIALS)
    for name in names:
        if name not in TRIALS:
            parser.error(f"there is no trial {name}")
    rows, is_clean = [], True
    for name in names:
        times = options.kills if name in ("kill", "stop_while_starting") else options.times
        remarks, broken = [], []
        for number in range(options.first, options.first + times):
            rng = random.Random(f"{options.seed} {name} {number}")
            try:
                remark = TRIALS[name](binary, rng, options)
                if remark is not None:
                    remarks.append(remark)
            except (Broken, OSError, subprocess.SubprocessError) as error:
                broken.append(
                    f"{error}\n"
                    f"        fuzz/faults.py {options.binary} --only {name} --seed {options.seed} --from {number} "
                    "--kills 1 --times 1"
                )
        numbers = [remark for remark in remarks if isinstance(remark, float)]
        remark = f"at most {max(numbers):.2f} s" if numbers else ", ".join(map(str, remarks[:2]))
        rows.append((name, times, len(broken), remark, broken))
        if not options.bare:
            print(f"{name}: {times - len(broken)} of {times} held", file=sys.stderr, flush=True)
        is_clean = is_clean and not broken
    print(f"{'trial':20} {'times':>6} {'broken':>7}  {'what':60} remark")
    for name, times, count, remark, broken in rows:
        print(f"{name:20} {times:>6} {count:>7}  {TRIALS[name].__doc__[:60]:60} {remark}")
        for text in broken[:5]:
            print(f"    {text}")
    return 0 if is_clean else 1


if __name__ == "__main__":
    sys.exit(main())
