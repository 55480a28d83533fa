"""Port 29999: what the vendor's client does, in its order and with its exact comparisons."""

import socket
import time
import unittest

from elite import Dashboard, Primary, Rtsi
from server import Server

FOREVER = "def wait_program():\n  while True:\n    sleep(0.05)\n  end\nend\n"
TASKS = {
    "wait_program.task": FOREVER,
    "test.script": FOREVER,
    "broken.task": "def broken():\n  movej(\nend\n",
    "default.configuration": "tcp = [0, 0, 0.1, 0, 0, 0]\n",
}


class Commands(unittest.TestCase):
    def test_what_a_command_sets_is_true_in_the_reply_to_the_next_line(self):
        with Server() as server:
            dashboard = Dashboard(server.ports["dashboard"])
            for percent in (55, 10, 100, 2, 73):
                self.assertEqual(dashboard.ask(f"speed -v {percent}"), f"Setting speed: {percent}\r\n")
                self.assertIn(f"Target Speed Fraction: {percent}\r\n", dashboard.ask("status"))

    def test_power_brakes_and_modes(self):
        with Server("--powered-off") as server:
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.expect("echo", "Hello ELITE ROBOTS.\r\n")
            self.assertEqual(dashboard.ask("robotMode"), "robotMode: POWER_OFF\r\n")
            dashboard.power_on()
            self.assertEqual(dashboard.ask("robotMode"), "robotMode: IDLE\r\n")
            dashboard.power_on()  # again: the same reply
            dashboard.expect("brakeRelease", "Brake Releasing\r\n")
            self.assertEqual(dashboard.ask("robotMode"), "robotMode: IDLE\r\n", "brakes take time")
            dashboard.brake_release()
            self.assertEqual(dashboard.ask("brakeRelease"), "Brake is released.\r\n")
            dashboard.power_off()
            dashboard.power_off()

    def test_getters(self):
        with Server() as server:
            dashboard = Dashboard(server.ports["dashboard"])
            for command, pattern in [
                ("closeSafetyDialog", "closing .* dialog\r\n"),
                ("unlockProtectiveStop", r"Protective stop unlocking\.\.\.\r\n"),
                ("safety -m", "^Safety mode: NORMAL\r\n$"),
                ("safety -s", "^Safety status: NORMAL\r\n$"),
                ("robotMode", "^robotMode: RUNNING\r\n$"),
                ("status", "RunningStatus:.*STOP"),
                ("status", "Target Speed Fraction: 100"),
                ("version", r"\d\.\d+\.\d\.\d"),
                ("robot -t", "CS66"),
                ("robot -s", "."),
                ("robot -id", "."),
                (r"log -a first\nsecond", r"Log has been added\.\r\n"),
                ("popup -shello", "Showing popup with text:.*"),
                ("popup -c", "Closing popup\r\n"),
                ("task", "."),
                ("task -ss", "^Task is saved\r\n$"),
                ("stop", "^Stopping task\r\n$"),
                ("task -s", "^Task is stopped\r\n$"),
                ("task -r", "^Task is not running\r\n$"),
                ("help play", "."),
                ("usage task speed", "."),
                ("help", "."),
                ("no such command", "."),
                ("remoteControl -s", "^true\r\n$"),
            ]:
                with self.subTest(command=command):
                    dashboard.expect(command, pattern)

    def test_speed(self):
        with Server() as server:
            dashboard = Dashboard(server.ports["dashboard"])
            primary = Primary(server.ports["primary"])
            dashboard.ask("speed -v 55")
            time.sleep(0.2)
            dashboard.expect("status", "Target Speed Fraction: 55")
            primary.until(lambda s: s.speed_fraction == 0.55)
            self.assertIn("Usage", dashboard.ask("speed -v 1"))
            dashboard.expect("speed", ": 55")

    def test_tasks(self):
        with Server(tasks=TASKS) as server:
            dashboard = Dashboard(server.ports["dashboard"])
            primary = Primary(server.ports["primary"])
            self.assertIn("no task", dashboard.ask("play"))
            dashboard.load("wait_program.task")
            dashboard.load("test.task")  # the file is test.script
            dashboard.play()
            primary.until(lambda s: s.running and not s.paused)
            self.assertEqual(dashboard.ask("play"), "Failed to execute: play\r\n")
            dashboard.pause()
            primary.until(lambda s: s.paused)
            dashboard.play()
            dashboard.stop()
            primary.until(lambda s: not s.running)
            dashboard.stop()  # with nothing running: the same reply
            for outside in ["../x.task", "/etc/passwd", "missing.task"]:
                self.assertNotIn("Loaded task", dashboard.ask(f"task -p {outside}"))
            dashboard.load("broken.task")
            dashboard.ask("play")
            kind, line, _, text = primary.exception()
            self.assertEqual((kind, line), (10, 2), text)
            dashboard.poll("task -s", "Task is stopped")

    def test_popups_and_variables_are_those_of_the_running_task(self):
        program = (
            "def v():\n  global count\n  count = 3\n  popup('go on?', blocking=True)\n  while True:\n"
            "    sleep(0.05)\n  end\nend\n"
        )
        with Server(tasks={"v.task": program}) as server:
            dashboard = Dashboard(server.ports["dashboard"])
            self.assertRegex(dashboard.ask("variable -get count"), "Error|undefined")
            dashboard.load("v.task")
            dashboard.play()
            dashboard.poll("variable -get count", "3", seconds=5)
            self.assertRegex(dashboard.ask("variable -set count [1, 2]"), "Error: .* while a program runs")
            dashboard.ask("popup -c")
            self.assertEqual(dashboard.ask("variable -get count"), "3\r\n")
            dashboard.stop()
            for value in ["((", "1; popup('x')", "1) ; popup((2", "= 2", "2\r3"]:
                self.assertRegex(dashboard.ask(f"variable -set count {value}"), "Error: .* no value")
            self.assertEqual(dashboard.ask("variable -set count [1, 2]"), "count, [1, 2]\r\n")
            self.assertEqual(dashboard.ask("variable -get count"), "[1, 2]\r\n")
            # A task that is written by hand begins with what was set, once.
            dashboard.play()
            dashboard.poll("variable -get count", "[1, 2]", seconds=5)
            dashboard.stop()

    def test_configurations(self):
        with Server(tasks=TASKS) as server:
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.expect("configuration -p default.configuration", "Loading Configuration :.*")
            dashboard.poll("configuration", "configuration: Relative path:default.configuration")
            dashboard.expect("configuration -s", "not modified")
            primary = Primary(server.ports["primary"])
            state = primary.until(lambda s: s.tcp_offset[2] == 0.1)
            self.assertEqual(state.tcp_offset[:2], (0, 0))
        with Server() as server:
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.expect("configuration -p default.configuration", "Loading Configuration :.*")

    def test_local_mode_is_the_same_on_every_port(self):
        with Server(tasks=TASKS) as server:
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.load("test.task")
            dashboard.ask("remoteControl -off")
            for command in ["play", "stop"]:
                self.assertEqual(
                    dashboard.ask(command),
                    f"Command [{command}] is not supported in local control mode. "
                    "Please close local control mode first.\r\n",
                )
            primary = Primary(server.ports["primary"])
            primary.send_script("def p():\n  sleep(1)\nend")
            self.assertIn("remote control", primary.exception()[3])
            dashboard.ask("remoteControl -on")
            dashboard.play()
            primary = Primary(server.ports["primary"])
            dashboard.ask("remoteControl -off")
            self.assertIn("remote control", primary.exception()[3])
            with self.assertRaises(ConnectionError):
                primary.exception()
            self.assertEqual(dashboard.ask("task -s"), "Task is running\r\n")
            dashboard.ask("remoteControl -on")
            primary = Primary(server.ports["primary"])
            primary.send_script("stop task")
            dashboard.poll("task -s", "Task is stopped")

    def test_quit_reboot_and_shutdown(self):
        with Server("--powered-off") as server:
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.power_on()
            self.assertTrue(dashboard.ask("quit").strip())
            with self.assertRaises(ConnectionError):
                dashboard.ask("echo")
            dashboard = Dashboard(server.ports["dashboard"])
            self.assertTrue(dashboard.ask("reboot").strip())
            end = time.monotonic() + 10
            while True:
                try:
                    dashboard = Dashboard(server.ports["dashboard"])
                    break
                except (ConnectionError, socket.timeout):
                    self.assertLess(time.monotonic(), end)
                    time.sleep(0.05)
            self.assertEqual(dashboard.ask("robotMode"), "robotMode: POWER_OFF\r\n", "started anew")
            self.assertTrue(dashboard.ask("shutdown").strip())
            self.assertEqual(server.process.wait(10), 0)


class Stops(unittest.TestCase):
    CELL = """
[[safety_input]]
function = "emergency_stop"
pair = 0
active = "high"
[[safety_input]]
function = "safeguard_stop"
pair = 1
active = "high"
[[wire]]
from = "standard_digital_out[0]"
to = "configurable_digital_in[0]"
[[wire]]
from = "standard_digital_out[1]"
to = "configurable_digital_in[2]"
"""

    def outputs(self, server):
        rtsi = Rtsi(server.ports["rtsi"])
        self.inputs = rtsi.set_up_inputs(["standard_digital_output_mask", "standard_digital_output"])
        rtsi.set_up_outputs(
            ["robot_mode", "safety_status", "safety_status_bits", "target_joint_speeds", "runtime_state"]
        )
        rtsi.start()
        return rtsi

    def set_output(self, rtsi, bit, level):
        values = {"standard_digital_output_mask": 1 << bit, "standard_digital_output": int(level) << bit}
        rtsi.write(self.inputs, values)

    def test_an_emergency_stop_is_the_same_truth_on_every_port(self):
        with Server(cell=self.CELL) as server:
            rtsi = self.outputs(server)
            dashboard = Dashboard(server.ports["dashboard"])
            primary = Primary(server.ports["primary"])
            primary.send_script("def m():\n  movej([2.5,-1.5,1.5,-1.5,-1.5,0])\nend")
            rtsi.until(lambda v: abs(v["target_joint_speeds"][0]) > 0.3)
            self.set_output(rtsi, 0, True)
            values = rtsi.until(lambda v: v["safety_status"] == 6)
            self.assertEqual(values["safety_status_bits"], 1 << 5 | 1 << 7 | 1 << 10)
            rtsi.until(lambda v: v["robot_mode"] == 3 and v["runtime_state"] == 3)
            self.assertEqual(dashboard.ask("safety -s"), "Safety status: SYSTEM_EMERGENCY_STOP\r\n")
            state = primary.until(lambda s: s.emergency and s.robot_mode == 3)
            self.assertEqual((state.safety_mode, state.robot_mode, state.power_on), (6, 3, False))
            dashboard.ask("robotControl -on")
            time.sleep(0.6)
            self.assertEqual(dashboard.ask("robotMode"), "robotMode: POWER_OFF\r\n", "not while it lasts")
            self.set_output(rtsi, 0, False)
            rtsi.until(lambda v: v["safety_status"] == 1)
            dashboard.power_on()
            dashboard.brake_release()

    def test_a_safeguard_stop_holds_the_arm_on_its_path_and_lets_it_go_on(self):
        with Server(cell=self.CELL) as server:
            rtsi = self.outputs(server)
            primary = Primary(server.ports["primary"])
            primary.send_script("def m():\n  movej([1.5,-1.5,1.5,-1.5,-1.5,0])\nend")
            rtsi.until(lambda v: abs(v["target_joint_speeds"][0]) > 0.3)
            self.set_output(rtsi, 1, True)
            values = rtsi.until(lambda v: v["safety_status"] == 5)
            self.assertEqual(values["robot_mode"], 7)
            rtsi.until(lambda v: max(map(abs, v["target_joint_speeds"])) == 0)
            time.sleep(0.2)
            self.assertEqual(rtsi.until(lambda v: True)["runtime_state"], 1, "the program waits in its motion")
            self.set_output(rtsi, 1, False)
            rtsi.until(lambda v: abs(v["target_joint_speeds"][0]) > 0.3)
            rtsi.until(lambda v: v["runtime_state"] == 3)
            primary.until(lambda s: not s.running and abs(s.actual_q[0] - 1.5) < 1e-3)


if __name__ == "__main__":
    unittest.main()
