"""Port 30004: how a conversation goes: set-up, start and pause, owners of inputs, the watchdog,
and data that never stops."""

import time
import unittest

from elite import Dashboard, Primary, Rtsi
from server import Server
from test_rtsi import VENDOR_INPUTS, VENDOR_OUTPUTS


class Watchdog(unittest.TestCase):
    def test_a_program_that_hears_from_its_client_too_rarely_is_held_or_ended(self):
        for action, state in [("pause", 2), ("stop", 3)]:
            with self.subTest(action=action), Server() as server:
                rtsi = Rtsi(server.ports["rtsi"])
                inputs = rtsi.set_up_inputs(["input_int_register0"])
                rtsi.set_up_outputs(["runtime_state"])
                rtsi.start()
                Primary(server.ports["primary"]).send_script(
                    f"def w():\n  rtsi_set_watchdog('input_int_register0', 10, '{action}')\n"
                    "  while True:\n    sync()\n  end\nend"
                )
                rtsi.until(lambda v: v["runtime_state"] == 1)
                end = time.monotonic() + 0.6
                while time.monotonic() < end:
                    rtsi.write(inputs, {"input_int_register0": 1})
                    self.assertEqual(rtsi.latest()["runtime_state"], 1)
                    time.sleep(0.03)
                start = time.monotonic()
                rtsi.until(lambda v: v["runtime_state"] == state)
                self.assertLess(time.monotonic() - start, 0.5)


class Sessions(unittest.TestCase):
    def test_names_that_do_not_exist_or_are_taken_are_said(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            with self.assertRaisesRegex(LookupError, "NOT_FOUND"):
                rtsi.set_up_outputs(["timestamp", "speed_slider_mask"])
            first = Rtsi(server.ports["rtsi"])
            first.set_up_inputs(["speed_slider_mask"])
            second = Rtsi(server.ports["rtsi"])
            with self.assertRaisesRegex(LookupError, "IN_USE"):
                second.set_up_inputs(["speed_slider_mask"])

    def test_six_reconnects_within_a_second_each_get_their_inputs(self):
        with Server() as server:
            for _ in range(6):
                rtsi = Rtsi(server.ports["rtsi"])
                rtsi.set_up_inputs([name for name, _ in VENDOR_INPUTS])
                rtsi.set_up_outputs(VENDOR_OUTPUTS)
                rtsi.start()
                rtsi.read()
                rtsi.close()

    def test_data_and_states_go_on_while_a_virtual_clock_stands_still(self):
        with Server("--clock", "virtual") as server:
            primary, rtsi = Primary(server.ports["primary"]), Rtsi(server.ports["rtsi"])
            rtsi.set_up_outputs(["timestamp", "runtime_state"])
            rtsi.start()
            primary.send_script("def busy():\n  while True:\n    pass\n  end\nend")
            rtsi.until(lambda v: v["runtime_state"] == 1)
            time.sleep(0.2)
            first = rtsi.latest()
            for _ in range(3):
                again = rtsi.read(1.0)  # within the second after which the vendor's client gives up
                primary.state(1.0)
            self.assertEqual(again["timestamp"], first["timestamp"])
            primary.send_script("stop task")
            rtsi.until(lambda v: v["runtime_state"] == 3 and v["timestamp"] > first["timestamp"])

    def test_recipes_are_set_up_while_data_flows(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            rtsi.set_up_outputs(["timestamp"])
            rtsi.start()
            for number in range(2, 12):
                start = time.monotonic()
                if number % 2:
                    recipe = rtsi.set_up_outputs(["robot_mode", "timestamp"], 125)
                else:
                    recipe = rtsi.set_up_inputs([f"input_int_register{number}"])
                    rtsi.write(recipe, {f"input_int_register{number}": number})
                self.assertLess(time.monotonic() - start, 1)
                self.assertEqual(recipe.number, number, "recipes of both kinds are counted together")
            rtsi.start()  # again: nothing to complain about
            seen = set()
            end = time.monotonic() + 5
            while len(seen) < len(rtsi.outputs):
                self.assertLess(time.monotonic(), end, f"{seen}")
                letter, payload = rtsi.packet()
                self.assertEqual(letter, "U")
                seen.add(payload[0])

    def test_an_input_written_while_paused_is_there_after_the_next_start(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            rtsi.set_up_outputs(["target_speed_fraction"], 125)
            rtsi.start()
            rtsi.read()
            rtsi.pause()
            inputs = rtsi.set_up_inputs(["speed_slider_mask", "speed_slider_fraction"])
            rtsi.write(inputs, {"speed_slider_mask": 1, "speed_slider_fraction": 0.25})
            rtsi.start()
            self.assertEqual(rtsi.until(lambda v: True)["target_speed_fraction"], 0.25)

    def test_data_flows_in_every_mode_and_every_client_has_its_own_rate(self):
        with Server("--powered-off") as server:
            fast, slow = Rtsi(server.ports["rtsi"]), Rtsi(server.ports["rtsi"])
            fast.set_up_outputs(["timestamp", "robot_mode"], 250)
            slow.set_up_outputs(["timestamp", "robot_mode"], 50)
            fast.start()
            slow.start()
            dashboard = Dashboard(server.ports["dashboard"])
            modes = []
            dashboard.expect("robotControl -on", "Powering on")
            dashboard.expect("brakeRelease", "Brake")
            end = time.monotonic() + 1.2
            while time.monotonic() < end:
                values = fast.read()
                if values["robot_mode"] not in modes:
                    modes.append(values["robot_mode"])
            self.assertEqual(modes[-3:], [4, 5, 7], "power on, idle, running")
            times = [slow.read()["timestamp"] for _ in range(20)]
            # Every fifth cycle. On a machine that is busy the server may see that cycle late and send a later one
            # instead; the next package is on the beat again, so no error adds up.
            steps = [round((later - earlier) / 0.004) for earlier, later in zip(times, times[1:])]
            self.assertEqual(sorted(steps)[len(steps) // 2], 5, steps)
            self.assertAlmostEqual(sum(steps), 5 * len(steps), delta=4, msg=f"{steps}")
            dashboard.power_off()
            fast.until(lambda v: v["robot_mode"] == 3)
            self.assertEqual(slow.until(lambda v: v["robot_mode"] == 3)["robot_mode"], 3)


if __name__ == "__main__":
    unittest.main()
