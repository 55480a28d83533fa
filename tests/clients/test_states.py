"""What each state of the robot allows, and that every port tells the same of it: a table of states and commands."""

import json
import socket
import struct
import time
import unittest
import urllib.request
from concurrent.futures import ThreadPoolExecutor

from elite import Dashboard, Primary, Rtsi
from server import Server
from test_http import set_inputs

CELL = """
[limits]
tcp_force = 100
[[safety_input]]
function = "emergency_stop"
pair = 0
active = "high"
[[safety_input]]
function = "safeguard_stop"
pair = 1
active = "high"
[[safety_input]]
function = "reduced_mode"
pair = 2
active = "high"
"""
TASKS = {"wait.task": "def wait():\n  while True:\n    sleep(0.05)\n  end\nend\n"}
MOVE = "def move():\n  movej([1.5,-1.5708,1.5708,-1.5708,-1.5708,0])\nend"

POWER_OFF, POWER_ON, IDLE, RUNNING = 3, 4, 5, 7
NORMAL, REDUCED, PROTECTIVE, SAFEGUARD, EMERGENCY = 1, 2, 3, 5, 6
ROBOT_WORDS = {3: "POWER_OFF", 4: "POWER_ON", 5: "IDLE", 7: "RUNNING"}
SAFETY_WORDS = {
    1: "NORMAL",
    2: "REDUCED",
    3: "PROTECTIVE_STOP",
    5: "SAFEGUARD_STOP",
    6: "SYSTEM_EMERGENCY_STOP",
}
SAFETY_BITS = {1: 1 << 0, 2: 1 << 1, 3: 1 << 2 | 1 << 10, 5: 1 << 4 | 1 << 10, 6: 1 << 5 | 1 << 7 | 1 << 10}
JOINT_MODES = {3: 239, 4: 246, 5: 255, 7: 253}
TOOL_MODES = {3: 239, 4: 247, 5: 255, 7: 253}
STOPPED, RUNS, PAUSED = "stopped", "running", "paused"
RUNTIME_STATES = {RUNS: 1, PAUSED: 2, STOPPED: 3}
STATUS_WORDS = {STOPPED: "STOP", RUNS: "RUNNING", PAUSED: "PAUSE"}


class Ports:
    """One client of every port of a server."""

    def __init__(self, server):
        self.server = server
        self.dashboard = Dashboard(server.ports["dashboard"])
        self.primary = Primary(server.ports["primary"])
        self.rtsi = Rtsi(server.ports["rtsi"])
        self.inputs = self.rtsi.set_up_inputs(["external_force_torque"])
        names = ["robot_mode", "joint_mode", "tool_mode", "safety_status", "safety_mode", "safety_status_bits"]
        self.rtsi.set_up_outputs(names + ["robot_status_bits", "runtime_state", "actual_robot_voltage"], 50)
        self.rtsi.start()

    def by_rtsi(self):
        """Robot mode, safety mode, task: as 30004 tells them, which must agree within themselves."""
        v = self.rtsi.latest()
        task = {number: name for name, number in RUNTIME_STATES.items()}[v["runtime_state"]]
        mode, safety = v["robot_mode"], v["safety_status"]
        powered = mode in (IDLE, RUNNING)
        found = (v["joint_mode"], v["tool_mode"], v["safety_mode"], v["safety_status_bits"], v["robot_status_bits"])
        bits = powered | (task != STOPPED) << 1
        wanted = ((JOINT_MODES[mode],) * 6, TOOL_MODES[mode], safety, SAFETY_BITS[safety], bits)
        assert found == wanted, f"rtsi: {found}, not {wanted}"
        assert v["actual_robot_voltage"] == (48 if powered else 0), v
        return mode, safety, task

    def by_primary(self):
        """The same as 30001 tells it."""
        while self.primary.message(0.0):
            pass  # the past does not count
        s = self.primary.state(5)  # more patience than ten a second: how often they come is another test's business
        mode, safety = s.robot_mode, s.safety_mode
        task = PAUSED if s.paused else RUNS if s.running else STOPPED
        powered = mode in (IDLE, RUNNING)
        found = (s.power_on, s.emergency, s.protective, s.joint_mode, s.parts[2][36], s.parts[3][84])
        flags = (powered, safety == EMERGENCY, safety == PROTECTIVE)
        wanted = (*flags, [JOINT_MODES[mode]] * 6, TOOL_MODES[mode], safety == REDUCED)
        assert found == wanted, f"primary: {found}, not {wanted}"
        return mode, safety, task

    def by_dashboard(self):
        """The same as 29999 tells it."""
        words = [self.dashboard.ask(c).rstrip() for c in ["robotMode", "safety -m", "safety -s", "task -s", "task -r"]]
        status = dict(line.split(": ") for line in self.dashboard.ask("status").split("\r\n")[:-1])
        mode = {f"robotMode: {word}": number for number, word in ROBOT_WORDS.items()}[words[0]]
        safety = {f"Safety mode: {word}": number for number, word in SAFETY_WORDS.items()}[words[1]]
        task = words[3].removeprefix("Task is ")
        assert words[2] == f"Safety status: {SAFETY_WORDS[safety]}", words
        assert words[4] == ("Task is running" if task == RUNS else "Task is not running"), words
        told = (status["RobotMode"], status["SafetyMode"], status["RunningStatus"])
        assert told == (ROBOT_WORDS[mode], SAFETY_WORDS[safety], STATUS_WORDS[task]), status
        return mode, safety, task

    def by_http(self):
        """The task, as the http port tells it."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.server.ports['http']}/panel", timeout=5) as page:
            return json.load(page)["task"]

    def truth(self):
        """What all ports agree on. While something changes they may differ for a moment."""
        return self.until(lambda _: True)

    def until(self, holds, seconds=5.0):
        """What all ports agree on, once `holds`."""
        end = time.monotonic() + seconds
        while True:
            try:
                views = [self.by_rtsi(), self.by_primary(), self.by_dashboard()]
                assert views[0] == views[1] == views[2] and views[0][2] == self.by_http(), f"{views}"
                if holds(views[0]):
                    return views[0]
                trouble = f"all ports say {views[0]}"
            except AssertionError as disagreement:
                trouble = str(disagreement)
            if time.monotonic() > end:
                raise AssertionError(f"{trouble}\n{self.server.stderr()}")

    def stays(self, wanted, seconds=0.3):
        """That it is so, and still is a moment later."""
        self.until(lambda view: view == wanted)
        time.sleep(seconds)
        assert self.truth() == wanted, f"{self.truth()}, not {wanted} for long"

    def push(self, newtons):
        self.rtsi.write(self.inputs, {"external_force_torque": [newtons, 0, 0, 0, 0, 0]})

    def set_pair(self, pair, level):
        names = [f"configurable_digital_in[{2 * pair + k}]" for k in (0, 1)]
        assert set_inputs(self.server, {name: level for name in names})[0] == 200


def push_too_hard(ports):
    ports.primary.send_script("ft_rtsi_input_enable(True)")
    ports.until(lambda view: view[2] == STOPPED)
    ports.push(200)
    ports.until(lambda view: view[1] == PROTECTIVE)
    ports.push(0)
    time.sleep(0.3)  # until the arm stands


# State, options of the server, how to get there, the view then.
STATES = [
    ("power off", ["--powered-off"], lambda p: None, (POWER_OFF, NORMAL, STOPPED)),
    ("idle", ["--powered-off"], lambda p: p.dashboard.power_on(), (IDLE, NORMAL, STOPPED)),
    ("running", [], lambda p: None, (RUNNING, NORMAL, STOPPED)),
    ("reduced", [], lambda p: p.set_pair(2, True), (RUNNING, REDUCED, STOPPED)),
    ("protective stop", [], push_too_hard, (RUNNING, PROTECTIVE, STOPPED)),
    ("safeguard stop", [], lambda p: p.set_pair(1, True), (RUNNING, SAFEGUARD, STOPPED)),
    ("emergency stop", [], lambda p: p.set_pair(0, True), (POWER_OFF, EMERGENCY, STOPPED)),
]


def dashboard(command):
    return lambda p: p.dashboard.ask(command)


def phrase(text):
    return lambda p: p.primary.send_script(text)


def play(ports):
    ports.dashboard.load("wait.task")
    ports.dashboard.play()


# Command, the ways to give it, and what it makes of a state: robot mode and safety mode, or None where nothing changes.
COMMANDS = [
    (
        "power on",
        [dashboard("robotControl -on"), phrase("power on")],
        {"power off": (IDLE, NORMAL)},
    ),
    (
        "power off",
        [dashboard("robotControl -off"), phrase("power off")],
        {
            "idle": (POWER_OFF, NORMAL),
            "running": (POWER_OFF, NORMAL),
            "reduced": (POWER_OFF, REDUCED),
            "protective stop": (POWER_OFF, PROTECTIVE),
            "safeguard stop": (POWER_OFF, SAFEGUARD),
        },
    ),
    (
        "brake release",
        [dashboard("brakeRelease"), phrase("set robotmode run")],
        {"power off": (RUNNING, NORMAL), "idle": (RUNNING, NORMAL)},
    ),
    (
        "unlock",
        [dashboard("unlockProtectiveStop"), phrase("set unlock protective stop"), dashboard("clear -a")],
        {"protective stop": (RUNNING, NORMAL)},
    ),
    (
        "restart of the safety board",
        [dashboard("safety -r"), phrase("restart safetyboard")],
        {
            "idle": (POWER_OFF, NORMAL),
            "running": (POWER_OFF, NORMAL),
            "reduced": (POWER_OFF, REDUCED),
            "protective stop": (POWER_OFF, NORMAL),
            "safeguard stop": (POWER_OFF, SAFEGUARD),
        },
    ),
    ("speed", [dashboard("speed -v 50"), phrase("set speed 0.50")], {}),
]


def reach(state):
    """A server in this state, and its ports."""
    name, options, go, view = state
    server = Server(*options, cell=CELL, tasks=TASKS)
    ports = Ports(server)
    go(ports)
    ports.stays(view)
    return server, ports


def check_commands(state):
    """Every command in this state, however given. A server is good for as many commands as change nothing."""
    name, _, _, (mode, safety, _) = state
    server = None
    try:
        for command, ways, changes in COMMANDS:
            for number, give in enumerate(ways):
                if server is None:
                    server, ports = reach(state)
                give(ports)
                wanted = changes.get(name)
                try:
                    ports.stays((*(wanted or (mode, safety)), STOPPED), 0.15)
                except AssertionError as error:
                    return [f"{command} (way {number}) in {name}: {error}"]
                if wanted:
                    server.__exit__()
                    server = None
    finally:
        if server:
            server.__exit__()
    return []


def check_programs(state):
    """Programs in this state: one that waits is run and held in each; one that moves only where the arm may."""
    name, _, _, (mode, safety, _) = state
    server, ports = reach(state)
    faults = []
    try:
        play(ports)
        ports.stays((mode, safety, RUNS), 0.1)
        ports.dashboard.pause()
        ports.stays((mode, safety, PAUSED), 0.1)
        ports.dashboard.play()
        ports.until(lambda view: view == (mode, safety, RUNS))
        ports.dashboard.stop()
        ports.stays((mode, safety, STOPPED), 0.1)
        listener = Primary(server.ports["primary"])
        listener.state()  # it hears everything from now on
        listener.send_script(MOVE)
        if name in ("running", "reduced"):
            ports.until(lambda view: view == (mode, safety, RUNS))
            listener.until(lambda s: abs(s.actual_q[0]) > 0.05)
        elif name == "safeguard stop":
            ports.stays((mode, safety, RUNS), 0.5)
            assert abs(listener.state().actual_q[0]) < 1e-3, "the arm must wait"
        else:
            kind, _, _, text = listener.exception()
            assert kind == 10 and ROBOT_WORDS[mode] in text and SAFETY_WORDS[safety] in text, text
            ports.stays((mode, safety, STOPPED), 0.1)
        # A running program goes with the power, whoever takes it.
        listener.send_script("power off")
        safety = NORMAL if name == "running" else safety
        ports.stays((POWER_OFF, safety, STOPPED), 0.1)
    except AssertionError as error:
        faults.append(f"programs in {name}: {error}")
    finally:
        server.__exit__()
    return faults


class Table(unittest.TestCase):
    def check(self, check):
        with ThreadPoolExecutor(3) as pool:
            faults = [fault for found in pool.map(check, STATES) for fault in found]
        self.assertFalse(faults, "\n" + "\n\n".join(faults))

    def test_every_command_in_every_state_leads_where_the_table_says_on_every_port(self):
        self.check(check_commands)

    def test_programs_run_in_every_state_and_move_the_arm_only_where_it_may(self):
        self.check(check_programs)


class Ways(unittest.TestCase):
    def test_from_power_off_to_running_every_port_shows_each_mode_in_turn(self):
        with Server("--powered-off", cell=CELL) as server:
            ports = Ports(server)
            ports.dashboard.expect("robotControl -on", "Powering on")
            ports.until(lambda view: view[0] == POWER_ON, 0.4)
            ports.until(lambda view: view[0] == IDLE)
            ports.dashboard.expect("brakeRelease", "Brake Releasing")
            ports.until(lambda view: view[0] == RUNNING)

    def test_an_emergency_stop_while_the_brakes_are_released_keeps_them_engaged(self):
        with Server("--powered-off", cell=CELL) as server:
            ports = Ports(server)
            ports.dashboard.power_on()
            ports.dashboard.expect("brakeRelease", "Brake Releasing")
            ports.set_pair(0, True)
            ports.stays((POWER_OFF, EMERGENCY, STOPPED))
            ports.set_pair(0, False)
            ports.stays((POWER_OFF, NORMAL, STOPPED))

    def test_a_protective_stop_ends_the_program_and_after_its_unlock_another_one_moves_the_arm(self):
        with Server(cell=CELL) as server:
            ports = Ports(server)
            ports.primary.send_script("ft_rtsi_input_enable(True)")
            ports.until(lambda view: view[2] == STOPPED)
            ports.primary.send_script(MOVE)
            ports.primary.until(lambda s: abs(s.actual_q[0]) > 0.1)
            listener = Primary(server.ports["primary"])
            listener.state()  # it hears everything from now on
            ports.push(200)
            kind, _, _, text = listener.exception()
            self.assertEqual(kind, 6, text)
            ports.push(0)
            ports.until(lambda view: view == (RUNNING, PROTECTIVE, STOPPED))
            time.sleep(0.3)
            ports.dashboard.expect("unlockProtectiveStop", "unlocking")
            ports.until(lambda view: view == (RUNNING, NORMAL, STOPPED))
            ports.primary.send_script(MOVE)
            ports.primary.until(lambda s: abs(s.actual_q[0] - 1.5) < 1e-3)

    def test_clients_that_vanish_in_any_state_leave_the_others_their_truth(self):
        with Server(cell=CELL) as server:
            ports = Ports(server)
            for level in (True, False) * 3:
                quick = [
                    socket.create_connection(("127.0.0.1", server.ports[p])) for p in ("primary", "rtsi", "dashboard")
                ]
                ports.set_pair(0, level)
                for one in quick:
                    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                    one.close()
                ports.until(lambda view: view[1] == (EMERGENCY if level else NORMAL))


if __name__ == "__main__":
    unittest.main()
