"""External control when something goes wrong in the middle: the task is killed, bytes are missing,
the arm is stopped."""

import json
import socket
import struct
import time
import unittest
import urllib.request
from concurrent.futures import ThreadPoolExecutor

from elite import Dashboard, Primary, Rtsi
from external_control import FREEDRIVE, POSE, SERVOJ_QUEUE, SPEEDJ, SPEEDL, TRAJECTORY, ZOOM, Driver
from server import Server

HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
AWAY = [0.6, -1.4, 1.4, -1.5, -1.5, 0.1]

SAFETY = """
[limits]
tcp_force = 100
[[safety_input]]
function = "emergency_stop"
pair = 0
active = "high"
[[wire]]
from = "standard_digital_out[0]"
to = "configurable_digital_in[0]"
"""


def watch(server, names):
    rtsi = Rtsi(server.ports["rtsi"])
    rtsi.set_up_outputs(names)
    rtsi.start()
    return rtsi


def lead(driver, rtsi, step=0.002, seconds=0.3):
    """Leads joint 1 away from where it stands, a point a cycle; the arm must follow."""
    q = list(rtsi.latest()["actual_joint_positions"])
    start = q[0]
    for _ in range(round(seconds / 0.004)):
        q[0] += step
        driver.servoj(q, 500)
        time.sleep(0.004)
    rtsi.until(lambda v: abs(v["actual_joint_positions"][0] - q[0]) < abs(q[0] - start) / 2)


def at_rest(v):
    return max(map(abs, v["actual_joint_speeds"])) < 1e-3


# Modes in the middle of which the task is killed, and how each is entered; the arm moves then, or may be moved.
def servoj(driver, rtsi):
    lead(driver, rtsi)


def trajectory(driver, _):
    driver.action(TRAJECTORY, 1, 2)
    driver.point(AWAY, 3.0)
    driver.point(HOME, 3.0)
    driver.action(TRAJECTORY, 0, timeout_ms=5000)


def pose(driver, rtsi):
    target = list(rtsi.latest()["actual_TCP_pose"])
    target[2] -= 0.02  # not a jump
    driver.write(POSE, target, 5000)


def queue(driver, rtsi):
    q = list(rtsi.latest()["actual_joint_positions"])
    for _ in range(50):
        q[5] += 0.002
        driver.write(SERVOJ_QUEUE, q, 5000)


def force(driver, _):
    frame, selection, wrench = [0] * 6, [0, 0, 1, 0, 0, 0], [0, 0, -20, 0, 0, 0]
    driver.idle()
    driver.script_command(3, frame + selection + wrench + [0] + [0.05] * 6, at={19: 2})


MODES = {
    "servoj": servoj,
    "speedj": lambda driver, _: driver.write(SPEEDJ, [0.2, 0, 0, 0, 0, 0], 5000),
    "speedl": lambda driver, _: driver.write(SPEEDL, [0, 0, 0.05, 0, 0, 0], 5000),
    "trajectory": trajectory,
    "pose": pose,
    "queue": queue,
    "freedrive": lambda driver, _: driver.action(FREEDRIVE, 1, timeout_ms=5000),
    "force mode": force,
}


class Killed(unittest.TestCase):
    NAMES = ["actual_joint_positions", "actual_joint_speeds", "actual_TCP_pose", "robot_status_bits", "runtime_state"]

    def check(self, way):
        kill, prepare = way
        with Server() as server:
            rtsi = watch(server, self.NAMES)
            for name, enter in MODES.items():
                prepare(server)
                driver = Driver(server.ports["primary"])
                driver.wait_connected()
                driver.idle()
                enter(driver, rtsi)
                rtsi.until(lambda v: v["robot_status_bits"] & 4 if name == "freedrive" else not at_rest(v))
                kill(server)
                start = time.monotonic()
                sockets = (driver.reverse, driver.trajectory, driver.command)
                while not all(s.is_closed_by_robot() for s in sockets):
                    self.assertLess(time.monotonic() - start, 2, f"{name}: the sockets of a killed task stay open")
                    time.sleep(0.005)
                rtsi.until(lambda v: v["runtime_state"] == 3 and not v["robot_status_bits"] & 4 and at_rest(v))
                driver.close()
            # After all of that: nothing is left of any of them.
            prepare(server)
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            driver.idle()
            lead(driver, rtsi)
            self.assertTrue(driver.stop())

    def test_a_task_killed_in_any_mode_leaves_its_sockets_closed_the_arm_at_rest_and_room_for_the_next(self):
        def power_on(server):
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.power_on()
            dashboard.brake_release()

        ways = [
            (lambda server: Primary(server.ports["primary"]).send_script("stop task"), lambda server: None),
            (lambda server: Dashboard(server.ports["dashboard"]).stop(), lambda server: None),
            (lambda server: Dashboard(server.ports["dashboard"]).power_off(), power_on),
        ]
        with ThreadPoolExecutor(len(ways)) as pool:
            list(pool.map(self.check, ways))


class Messages(unittest.TestCase):
    def setUp(self):
        self.server = Server()
        self.addCleanup(self.server.__exit__)
        self.rtsi = watch(
            self.server, ["actual_joint_positions", "actual_joint_speeds", "runtime_state", "payload_mass"]
        )
        self.driver = Driver(self.server.ports["primary"])
        self.driver.wait_connected()
        self.driver.idle()

    def in_pieces(self, listener, words):
        """A message in three pieces, none of them at a word's border."""
        data = struct.pack(f">{len(words)}i", *words)
        for piece in (data[:5], data[5:18], data[18:]):
            listener.connection.sendall(piece)
            time.sleep(0.1)

    def ended(self, seconds):
        start = time.monotonic()
        while not (self.driver.reverse.is_closed_by_robot() and self.driver.command.is_closed_by_robot()):
            self.assertLess(time.monotonic() - start, seconds, "the program has not ended")
            time.sleep(0.005)
        self.rtsi.until(lambda v: v["runtime_state"] == 3 and at_rest(v))
        return time.monotonic() - start

    def speed(self):
        return [5000] + [round(0.2 * ZOOM)] + [0] * 5 + [SPEEDJ]

    def test_a_packet_in_pieces_is_waited_for_on_every_socket(self):
        self.in_pieces(self.driver.reverse, self.speed())
        self.rtsi.until(lambda v: abs(v["actual_joint_speeds"][0] - 0.2) < 1e-3)
        self.in_pieces(self.driver.command, [1, 2 * ZOOM, 0, 0, 0] + [0] * 21)
        self.rtsi.until(lambda v: v["payload_mass"] == 2)
        self.driver.idle()
        self.rtsi.until(at_rest)
        self.driver.action(TRAJECTORY, 1, 1, timeout_ms=0)
        point = [round(x * ZOOM) for x in AWAY] + [0] * 12 + [1000, 0, 0]
        self.in_pieces(self.driver.trajectory, point)
        end = time.monotonic() + 5
        while (result := self.driver.result()) is None:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)
        self.assertEqual(result, 0)
        self.rtsi.until(lambda v: abs(v["actual_joint_positions"][0] - AWAY[0]) < 1e-3)
        self.assertTrue(self.driver.stop())

    def test_half_a_packet_and_then_nothing_ends_the_program_at_its_timeout(self):
        words = self.speed()
        words[0] = 300
        self.driver.reverse.send_words(words)
        self.rtsi.until(lambda v: v["actual_joint_speeds"][0] > 0.1)
        self.driver.reverse.connection.sendall(b"\0\0\0\x01\0\0")
        self.assertLess(self.ended(2), 1)

    def test_half_a_packet_and_then_the_end_of_the_connection_ends_the_program_at_once(self):
        self.driver.reverse.send_words(self.speed())
        self.rtsi.until(lambda v: v["actual_joint_speeds"][0] > 0.1)
        self.driver.reverse.connection.sendall(b"\0\0\0\x01\0\0")
        self.driver.reverse.connection.close()
        self.rtsi.until(lambda v: v["runtime_state"] == 3 and at_rest(v), 1)

    def test_a_reset_instead_of_a_goodbye_ends_the_program_too(self):
        self.driver.reverse.send_words(self.speed())
        self.rtsi.until(lambda v: v["actual_joint_speeds"][0] > 0.1)
        self.driver.reverse.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.driver.reverse.connection.close()
        self.rtsi.until(lambda v: v["runtime_state"] == 3 and at_rest(v), 1)

    def test_the_other_two_sockets_may_close_without_an_end_of_the_program(self):
        cpu = self.cpu_seconds()
        for listener in (self.driver.command, self.driver.trajectory):
            listener.connection.sendall(b"\0\0\0")
            listener.connection.close()
        lead(self.driver, self.rtsi, seconds=1)
        self.assertEqual(self.rtsi.latest()["runtime_state"], 1)
        # Its readers find closed sockets again and again, without burning a core.
        self.assertLess(self.cpu_seconds() - cpu, 1.2)
        self.driver.reverse.send_words([0] * 7 + [-2])
        self.rtsi.until(lambda v: v["runtime_state"] == 3)

    def cpu_seconds(self):
        with open(f"/proc/{self.server.process.pid}/stat") as stat:
            user, system = stat.read().rsplit(")", 1)[1].split()[11:13]
        return (int(user) + int(system)) / 100

    def test_modes_that_are_none_and_the_unused_one_stop_the_arm_and_nothing_else(self):
        for mode in (7, 10, 12345, -7, 2**31 - 1, -(2**31)):
            with self.subTest(mode=mode):
                self.driver.reverse.send_words(self.speed())
                self.rtsi.until(lambda v: v["actual_joint_speeds"][0] > 0.1)
                self.driver.reverse.send_words([0] + [2**31 - 1] * 6 + [mode])
                self.rtsi.until(at_rest)
        self.driver.script_command(99)
        lead(self.driver, self.rtsi)
        self.assertTrue(self.driver.stop())

    def test_a_jump_is_ignored_and_told_once(self):
        lead(self.driver, self.rtsi)
        here = list(self.rtsi.latest()["actual_joint_positions"])
        for _ in range(20):
            self.driver.servoj([here[0] + 2.0] + here[1:], 500)
            time.sleep(0.004)
        self.rtsi.until(at_rest)
        self.assertLess(abs(self.rtsi.latest()["actual_joint_positions"][0] - here[0]), 0.2)
        with urllib.request.urlopen(f"http://127.0.0.1:{self.server.ports['http']}/panel", timeout=5) as page:
            popups = json.load(page)["popups"]
        self.assertEqual([(p["style"], p["blocking"]) for p in popups], [("warning", False)])
        self.assertTrue(self.driver.stop())


class Stopped(unittest.TestCase):
    NAMES = ["actual_joint_positions", "actual_joint_speeds", "runtime_state", "safety_status", "robot_mode"]

    def test_a_protective_stop_ends_the_program_and_after_the_unlock_it_is_sent_again(self):
        with Server(cell=SAFETY) as server:
            rtsi = watch(server, self.NAMES)
            inputs = rtsi.set_up_inputs(["external_force_torque"])
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            driver.idle()
            # A `sec` beside the running program, as drivers send them.
            driver.primary.send_script("sec s():\n  ft_rtsi_input_enable(True)\nend")
            lead(driver, rtsi)
            listener = Primary(server.ports["primary"])
            listener.state()  # it hears everything from now on
            rtsi.write(inputs, {"external_force_torque": [200, 0, 0, 0, 0, 0]})
            rtsi.until(lambda v: v["safety_status"] == 3)
            rtsi.write(inputs, {"external_force_torque": [0] * 6})
            self.assertEqual(listener.exception()[0], 6)
            end = time.monotonic() + 2
            while not (driver.reverse.is_closed_by_robot() and driver.command.is_closed_by_robot()):
                self.assertLess(time.monotonic(), end)
                time.sleep(0.005)
            rtsi.until(lambda v: v["runtime_state"] == 3 and at_rest(v))
            time.sleep(0.3)
            Dashboard(server.ports["dashboard"]).expect("unlockProtectiveStop", "unlocking")
            rtsi.until(lambda v: v["safety_status"] == 1)
            self.again(driver, rtsi)

    def test_an_emergency_stop_too_once_there_is_power_again(self):
        with Server(cell=SAFETY) as server:
            rtsi = watch(server, self.NAMES)
            inputs = rtsi.set_up_inputs(["standard_digital_output_mask", "standard_digital_output"])
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            driver.idle()
            driver.write(SPEEDJ, [0.2, 0, 0, 0, 0, 0], 5000)
            rtsi.until(lambda v: not at_rest(v))
            rtsi.write(inputs, {"standard_digital_output_mask": 1, "standard_digital_output": 1})
            rtsi.until(lambda v: v["runtime_state"] == 3 and v["robot_mode"] == 3)
            rtsi.write(inputs, {"standard_digital_output_mask": 1, "standard_digital_output": 0})
            rtsi.until(lambda v: v["safety_status"] == 1)
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.power_on()
            dashboard.brake_release()
            self.again(driver, rtsi)

    def test_in_local_mode_the_program_is_refused_and_taken_once_it_is_left(self):
        with Server() as server:
            rtsi = watch(server, self.NAMES)
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.ask("remoteControl -off")
            listener = Primary(server.ports["primary"])
            self.assertIn("remote control", listener.exception()[3])
            driver = Driver(server.ports["primary"])
            self.assertFalse(driver.reverse.connected.wait(0.5))
            dashboard.ask("remoteControl -on")
            # Its connection is closed, as on the arm: it makes another.
            driver.primary = Primary(server.ports["primary"])
            self.again(driver, rtsi)
            # Left alone, a running program stays: only orders are refused.
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            dashboard.ask("remoteControl -off")
            driver.idle()
            lead(driver, rtsi, -0.002)
            self.assertTrue(driver.stop())

    def test_a_pc_that_does_not_listen_is_given_up_at_once(self):
        with Server() as server:
            start = time.monotonic()
            driver = Driver(server.ports["primary"], listening=False)
            # The program may be over before the next state is sent: what it says is what it leaves behind.
            while "nothing came in time: 0 of 8" not in server.stderr():
                self.assertLess(time.monotonic() - start, 4)
                time.sleep(0.01)
            Primary(server.ports["primary"]).until(lambda s: not s.running, 5)
            driver.close()

    def test_a_motion_without_power_ends_the_program_with_an_error_and_it_is_sent_again(self):
        with Server("--powered-off") as server:
            rtsi = watch(server, self.NAMES)
            listener = Primary(server.ports["primary"])
            listener.state()  # it hears everything from now on
            for enter in (MODES["speedj"], MODES["trajectory"], lambda d, _: d.servoj(HOME, 5000)):
                driver = Driver(server.ports["primary"])
                driver.wait_connected()
                driver.idle()
                enter(driver, rtsi)
                kind, line, _, text = listener.exception()
                self.assertEqual(kind, 10)
                self.assertIn("POWER_OFF", text)
                self.assertGreater(line, 1)
                rtsi.until(lambda v: v["runtime_state"] == 3)
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.power_on()
            dashboard.brake_release()
            self.again(driver, rtsi)

    def again(self, driver, rtsi):
        for listener in (driver.reverse, driver.trajectory, driver.command):
            listener.connected.clear()
        driver.send_script()
        driver.wait_connected()
        driver.idle()
        lead(driver, rtsi)
        self.assertTrue(driver.stop())
        rtsi.until(lambda v: v["runtime_state"] == 3)


if __name__ == "__main__":
    unittest.main()
