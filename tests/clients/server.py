"""Starts an eliteserver on free ports for a test and ends it afterwards."""

import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SERVICES = ["primary", "interpreter", "rtsi", "dashboard", "modbus", "http"]


def binary():
    """The program under test: $ELITESERVER, or the debug build."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
    return os.environ.get("ELITESERVER", str(target / "debug" / "eliteserver"))


class Server:
    """A running server; a context manager."""

    def __init__(self, *options, tasks=None, cell=None):
        self.folder = tempfile.TemporaryDirectory(prefix="eliteserver-")
        folder = pathlib.Path(self.folder.name)
        task_folder = self.task_folder = folder / "tasks"
        task_folder.mkdir()
        for name, text in (tasks or {}).items():
            (task_folder / name).write_text(text)
        if cell:
            (folder / "cell.toml").write_text(cell)
            options += ("--cell", "cell.toml")
        ready = folder / "ready.json"
        command = [binary(), "serve", "--ready-file", str(ready), "--record", "off"]
        for service in SERVICES:
            command += [f"--{service}-port", "0"]
        self.log = open(folder / "stderr.log", "w+")
        self.process = subprocess.Popen(command + list(options), cwd=folder, stderr=self.log, stdout=subprocess.DEVNULL)
        end = time.monotonic() + 20
        while not ready.exists():
            if self.process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"the server did not start: {self.stderr()}")
            time.sleep(0.005)
        self.ports = json.loads(ready.read_text())["ports"]

    def stderr(self):
        self.log.flush()
        return pathlib.Path(self.log.name).read_text()

    def rss_kib(self):
        """Resident memory."""
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmRSS")))

    def metric(self, name):
        """A figure of the metrics page."""
        import urllib.request

        url = f"http://127.0.0.1:{self.ports['http']}/metrics"
        page = urllib.request.urlopen(url, timeout=5).read().decode()
        lines = [line for line in page.splitlines() if name in line and not line.startswith("#")]
        return sum(float(line.rsplit(" ", 1)[1]) for line in lines)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        finally:
            self.log.close()
            self.folder.cleanup()
