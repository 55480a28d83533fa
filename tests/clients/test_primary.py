"""Port 30001: the state stream part by part with live values, exceptions to everybody, control phrases,
quick and dead clients."""

import socket
import struct
import time
import unittest

from elite import Dashboard, Primary, Rtsi
from server import Server

TURN = "def turn():\n  movej([{q},-1.5708,1.5708,-1.5708,-1.5708,0])\nend"


def fields(state, part, layout, start=5):
    return struct.unpack_from(">" + layout, state.parts[part], start)


class States(unittest.TestCase):
    def test_every_part_has_live_values(self):
        cell = '[[input]]\nat = 0\nset = "standard_digital_in[5]"\nvalue = true\n'
        with Server("--tcp", "0,0,0.1,0,0,0", cell=cell) as server:
            primary = Primary(server.ports["primary"])
            first = primary.until(lambda s: s.digital_in != 0)
            self.assertEqual(first.tcp_offset, (0, 0, 0.1, 0, 0, 0))
            self.assertEqual(first.robot_type, 6206)
            self.assertEqual(first.digital_in, 1 << 5)
            primary.send_script(
                "def s():\n  set_standard_digital_out(4, True)\n  set_tool_voltage(12)\n"
                "  set_standard_analog_output_domain(0, 0)\n  set_standard_analog_out(0, 1.0)\n"
                "  movej([0.5,-1.3,1.3,-1.4,-1.4,0.2])\n  sleep(1)\nend"
            )
            moving = primary.until(lambda s: s.running and abs(s.actual_q[0]) > 0.05)
            stamps = [fields(s, 0, "Q")[0] for s in (first, moving)]
            self.assertGreater(stamps[1], stamps[0])
            state = primary.until(lambda s: abs(s.actual_q[0] - 0.5) < 1e-3)
            self.assertEqual(state.digital_out, 1 << 4)
            self.assertEqual(fields(state, 3, "3B", 40)[0], 0, "output 0 is a current")
            self.assertAlmostEqual(fields(state, 3, "d", 43)[0], 0.020)
            self.assertEqual(fields(state, 2, "B", 27)[0], 12)
            self.assertEqual(state.joint_mode, [253] * 6)
            torques = [fields(state, 1, "f", 5 + 57 * j + 48)[0] for j in range(6)]
            currents = [fields(state, 1, "f", 5 + 57 * j + 36)[0] for j in range(6)]
            self.assertGreater(abs(torques[1]), 5)
            self.assertGreater(abs(currents[1]), 0.1)
            elbow = fields(state, 10, "3d", 11)
            rtsi = Rtsi(server.ports["rtsi"])
            rtsi.set_up_outputs(["actual_TCP_pose", "elbow_position", "actual_joint_torques"])
            rtsi.start()
            values = rtsi.latest()
            for ours, theirs in [(state.tcp_pose, values["actual_TCP_pose"]), (elbow, values["elbow_position"])]:
                for a, b in zip(ours, theirs):
                    self.assertAlmostEqual(a, b, places=3)
            self.assertAlmostEqual(torques[1], values["actual_joint_torques"][1], delta=0.5)
            self.assertEqual(first.dh, state.dh, "bit for bit")

    def test_ten_states_a_second_reach_every_client_however_slow_the_others_are(self):
        with Server() as server:
            sleeping = [Primary(server.ports["primary"]) for _ in range(5)]  # never read
            watching = Primary(server.ports["primary"])
            watching.until(
                lambda s: fields(s, 0, "Q")[0] >= 100_000
            )  # before the first tenth there is the very first cycle
            start = time.monotonic()
            stamps = [fields(watching.state(), 0, "Q")[0] for _ in range(10)]
            self.assertAlmostEqual(time.monotonic() - start, 1.0, delta=0.25)
            # They are those of the cycles, not of a timer: a tenth of a second apart to the microsecond. Of states that
            # come too late for this client it sees the latest.
            steps = [later - earlier for earlier, later in zip(stamps, stamps[1:])]
            self.assertTrue(all(step % 100_000 == 0 for step in steps), steps)
            self.assertEqual(sorted(steps)[len(steps) // 2], 100_000)
            del sleeping

    def test_ten_connections_dropped_without_goodbye_disturb_nobody(self):
        with Server() as server:
            watching = Primary(server.ports["primary"])
            for _ in range(10):
                quick = Primary(server.ports["primary"])
                quick.state()
                linger = struct.pack("ii", 1, 0)
                quick.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)  # a reset, no end of stream
                quick.close()
            watching.state()
            dying = Primary(server.ports["primary"])
            dying.send_script(TURN.format(q=0.5))
            watching.until(lambda s: s.running)
            dying.close()
            watching.until(lambda s: not s.running and abs(s.actual_q[0] - 0.5) < 1e-3)


class Programs(unittest.TestCase):
    def test_a_syntax_error_is_told_to_everybody_within_a_second(self):
        with Server() as server:
            sender, other = Primary(server.ports["primary"]), Primary(server.ports["primary"])
            other.state()
            start = time.monotonic()
            sender.send_script("def b():\n  x = = 1\nend")
            for client in (sender, other):
                kind, line, column, text = client.exception()
                self.assertEqual((kind, line), (10, 2))
                self.assertGreater(column, 1)
                self.assertIn("SyntaxError", text)
                self.assertAlmostEqual(client.exception_time, time.time(), delta=5)
            self.assertLess(time.monotonic() - start, 1)
            sender.state()

    def test_control_phrases(self):
        with Server("--powered-off") as server:
            primary = Primary(server.ports["primary"])
            primary.send_script("power on")
            primary.until(lambda s: s.robot_mode == 5)
            primary.send_script("set robotmode run")
            primary.until(lambda s: s.robot_mode == 7)
            primary.send_script("set speed 0.50")
            primary.until(lambda s: s.speed_fraction == 0.5)
            primary.send_script(TURN.format(q=2.0))
            primary.until(lambda s: s.running)
            primary.send_script("pause task")
            primary.until(lambda s: s.paused)
            primary.send_script("resume task")
            primary.until(lambda s: s.running and not s.paused)
            primary.send_script("stop task")
            primary.until(lambda s: not s.running)
            primary.send_script("power off")
            primary.until(lambda s: s.robot_mode == 3 and not s.power_on)

    def test_a_protective_stop_is_unlocked_and_the_same_on_every_port(self):
        blow = "[[wrench]]\nat = 2\nduration = 0.1\nwrench = [400, 0, 0, 0, 0, 0]\nframe = 'base'\n"
        with Server(cell=blow) as server:
            primary = Primary(server.ports["primary"])
            dashboard = Dashboard(server.ports["dashboard"])
            primary.until(lambda s: s.protective, 10)
            self.assertEqual(dashboard.ask("safety -s"), "Safety status: PROTECTIVE_STOP\r\n")
            time.sleep(0.5)  # the blow is over, the arm stands and the brakes hold it: before that nothing is unlocked
            primary.send_script("set unlock protective stop")
            primary.until(lambda s: not s.protective, 5)
            self.assertEqual(dashboard.ask("safety -s"), "Safety status: NORMAL\r\n")


class Senders(unittest.TestCase):
    """The bytes that the known clients send, as they send them."""

    def setUp(self):
        pty = "[[serial]]\nport = 'tool'\ndevice = '/dev/ptmx'\n"
        self.server = Server(cell=pty)
        self.addCleanup(self.server.__exit__)
        self.primary = Primary(self.server.ports["primary"])
        self.rtsi = Rtsi(self.server.ports["rtsi"])
        self.rtsi.set_up_outputs(
            ["runtime_state", "output_int_register0", "actual_digital_output_bits", "actual_joint_positions"]
        )
        self.rtsi.start()

    def send(self, *pieces):
        for piece in pieces:
            self.primary.socket.sendall(piece)

    def register(self, value):
        self.rtsi.until(lambda v: v["output_int_register0"] == value)

    def test_the_serial_helper_of_the_sdk_configures_the_tool_with_and_without_a_program(self):
        helper = (
            b"sec tool_rs485_config():\n    set_tool_analog_io_work_mode(0)\n"
            b"    tool_serial_config(True,%d,0,1)\nend\n\n"
        )
        layout = "?3I?B2f"
        self.assertFalse(fields(self.primary.state(), 11, layout)[0])
        self.send(helper % 115200)
        self.primary.until(lambda s: fields(s, 11, layout)[:4] == (True, 115200, 0, 1))
        self.send(b"def f():\n  sleep(100)\nend\n\n")
        self.primary.until(lambda s: s.running)
        self.send(helper % 9600)
        state = self.primary.until(lambda s: fields(s, 11, layout)[:4] == (True, 9600, 0, 1))
        self.assertTrue(state.running)
        # The helper of the control box: the same words for another port. There is no line: an error, and nothing else.
        self.send(b"sec board_rs485_config():\n    masterboard_serial_config(True,115200,0,1)\nend\n\n")
        self.assertTrue(self.primary.until(lambda s: True).running)

    def test_the_script_node_of_ros(self):
        self.send(b'sec hello():\n\ttextmsg("script_sender connected")\nend\n', b'popup("hello")\n')
        end = time.monotonic() + 5
        while "script_sender connected" not in self.server.stderr():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)
        Dashboard(self.server.ports["dashboard"]).expect("popup -c", "Closing popup")

    def test_a_running_script_is_stopped_and_sent_again(self):
        whole = b"def f():\n\twrite_output_integer_register(0, %d)\n\t\n\tsleep(100)\nend\n"
        self.send(whole % 1)
        self.register(1)
        for number in range(2, 7):
            self.send(b"stop task\n\n")
            self.rtsi.until(lambda v: v["runtime_state"] == 3)
            self.send(whole % number)
            self.register(number)

    def test_bare_lines_of_field_clients(self):
        self.send(b"movel([-0.49,-0.14,0.48,-3.1416,0,1.5708], a=0.8, v=0.1)\r\n")
        self.rtsi.until(lambda v: v["runtime_state"] == 1)
        self.rtsi.until(lambda v: v["runtime_state"] == 3)
        before = self.rtsi.latest()["actual_joint_positions"][5]
        self.send(b"speedj([0,0,0,0,0,0.2], 1.4, 0.2)\n")
        self.rtsi.until(lambda v: v["actual_joint_positions"][5] > before + 0.01)
        self.rtsi.until(lambda v: v["runtime_state"] == 3)
        # A bare `if` is a line of its own, and the line after it too.
        self.send(b"if True:\n  write_output_integer_register(0, 1)\n")
        self.assertEqual(self.primary.exception()[:2], (10, 1))

    def test_blocks_with_inner_ends_and_windows_line_ends_from_a_client_that_is_gone_at_once(self):
        for number, newline in enumerate([b"\n", b"\r\n"], 1):
            lines = [
                b"def f():",
                b"  if True:",
                b"    for n in range(3):",
                b"      sync()",
                b"    end",
                b"  end",
                b"  def g():",
                b"    write_output_integer_register(0, %d)" % number,
                b"  end",
                b"  g()",
                b"end",
                b"",
            ]
            quick = socket.create_connection(("127.0.0.1", self.server.ports["primary"]))
            quick.sendall(newline.join(lines))
            quick.close()
            self.register(number)
            self.rtsi.until(lambda v: v["runtime_state"] == 3)
        self.send(b"f()\n")
        self.assertIn("NameError", self.primary.exception()[3])

    def test_a_second_program_takes_the_place_of_the_first(self):
        self.send(
            b"def f():\n  try:\n    sleep(100)\n  finally:\n    write_output_integer_register(1, 5)\n  end\nend\n"
        )
        self.rtsi.until(lambda v: v["runtime_state"] == 1)
        self.send(b"def broken():\n  g(\nend\n")
        self.assertIn("SyntaxError", self.primary.exception()[3])
        self.assertEqual(self.rtsi.latest()["runtime_state"], 1)
        start = time.monotonic()
        self.send(b"def g():\n  write_output_integer_register(0, 7)\n  sleep(100)\nend\n")
        self.rtsi.until(lambda v: v["output_int_register0"] == 7)
        self.assertLess(time.monotonic() - start, 2)
        # A lone line is a program, too.
        self.send(b"write_output_integer_register(0, 8)\n")
        self.rtsi.until(lambda v: v["output_int_register0"] == 8 and v["runtime_state"] == 3)


if __name__ == "__main__":
    unittest.main()
