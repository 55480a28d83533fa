"""External control end to end: headless start, the three sockets, every mode, stop and restart, and what goes wrong."""

import math
import os
import statistics
import subprocess
import threading
import time
import unittest

from elite import Dashboard, Primary, Rtsi
from external_control import FREEDRIVE, POSE, SERVOJ_QUEUE, SPEEDJ, SPEEDL, TRAJECTORY, Driver, ScriptSender
from server import Server, binary

HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]


def watch(server, names, frequency=250):
    rtsi = Rtsi(server.ports["rtsi"])
    rtsi.set_up_outputs(names, frequency)
    rtsi.start()
    return rtsi


def follow_sine(server, driver, amplitude=0.2, frequency=1.0, seconds=3.0):
    """Leads joint 1 along a sine at 250 Hz. Gives the delay (s) at which the arm fits best, the error (rad, rms) left
    then, and the largest error (rad) without any allowance for delay: all of the arm, so what came late to it, or from
    it, is left out."""
    rtsi = watch(server, ["timestamp", "actual_joint_positions"])
    seen = []
    running = True

    def read():
        while running:
            values = rtsi.read()
            seen.append((time.monotonic(), values["timestamp"], values["actual_joint_positions"][0]))

    reader = threading.Thread(target=read)
    reader.start()
    start = time.monotonic() + 0.05

    def wanted(t):
        # Begins and goes on without a jump of speed.
        ramp = min(1.0, max(0.0, t) / 0.5)
        return amplitude * ramp**2 * (3 - 2 * ramp) * math.sin(2 * math.pi * frequency * t)

    cycle = 0
    late = []
    while True:
        t = cycle * 0.004
        if t > seconds:
            break
        time.sleep(max(0.0, start + t - time.monotonic()))
        if time.monotonic() - start - t > 0.004:
            late.append(t)
        driver.servoj([wanted(t)] + HOME[1:])
        cycle += 1
    running = False
    reader.join()
    rtsi.close()
    # The controller's own time, in this program's: the message that was least on its way.
    offset = min(arrival - timestamp for arrival, timestamp, _ in seen) - start
    moments = [(timestamp + offset, q) for _, timestamp, q in seen]
    settled = [(t, q) for t, q in moments if 1.0 < t < seconds and not any(t - 0.3 < sent < t for sent in late)]
    if len(settled) < 250:
        return None

    def error(delay):
        return math.sqrt(statistics.fmean((q - wanted(t - delay)) ** 2 for t, q in settled))

    delay = min((d * 0.001 for d in range(0, 400)), key=error)
    largest = max(abs(q - wanted(t)) for t, q in settled)
    return delay, error(delay), largest


def listing():
    """The functions that the server under test has."""
    return subprocess.run([binary(), "builtins"], capture_output=True, text=True, check=True).stdout


class NotHeadless(unittest.TestCase):
    def test_the_task_that_comes_with_the_server_asks_for_the_program_and_runs_it(self):
        with Server() as server:
            sender = ScriptSender()
            driver = Driver(server.ports["primary"], sender=sender)
            dashboard = Dashboard(server.ports["dashboard"])
            self.assertIn("Loaded task: external_control.task", dashboard.ask("task -p external_control.task"))
            self.assertIn("127.0.0.1", dashboard.ask("variable -get external_control_host"))
            # The port of a test is any free one; it outlives the plays.
            self.assertNotIn("Error", dashboard.ask(f"variable -set external_control_port {sender.port}"))
            rtsi = watch(server, ["actual_joint_speeds"])
            for plays in (1, 2):
                for listener in (driver.reverse, driver.trajectory, driver.command):
                    listener.connected.clear()
                self.assertEqual(dashboard.ask("play"), "Starting task\r\n")
                driver.wait_connected()
                self.assertEqual(sender.requests, [b"request_program\n"] * plays)
                driver.write(SPEEDJ, [0.2, 0, 0, 0, 0, 0], 1000)
                rtsi.until(lambda v: abs(v["actual_joint_speeds"][0] - 0.2) < 1e-3)
                driver.idle()
                rtsi.until(lambda v: max(map(abs, v["actual_joint_speeds"])) < 1e-3)
                self.assertTrue(driver.stop())
                end = time.monotonic() + 5
                while dashboard.ask("task -s") != "Task is stopped\r\n":
                    self.assertLess(time.monotonic(), end)
            sender.close()

    def test_without_a_sender_or_with_half_a_program_the_task_ends_and_says_why(self):
        with Server() as server:
            sender = ScriptSender()
            dashboard = Dashboard(server.ports["dashboard"])
            primary = Primary(server.ports["primary"])
            dashboard.ask("task -p external_control")
            dashboard.ask(f"variable -set external_control_port {sender.port}")
            sender.script = b"# HEADER_BEGIN\nset_standard_digital_out(0, True)\n"
            self.play(dashboard)
            self.assertIn("no whole control script came from 127.0.0.1", self.error(primary))
            sender.script = b"x = 1\nnobody_knows_this()\n# NODE_CONTROL_LOOP_ENDS\n"
            self.play(dashboard)
            told = self.error(primary)
            self.assertIn("nobody_knows_this", told)
            self.assertIn(f"control script of 127.0.0.1:{sender.port}, line 2", told)
            sender.close()
            self.play(dashboard)
            self.assertIn("nobody sends a control script at 127.0.0.1", self.error(primary))

    def play(self, dashboard):
        """Begins the task once the one before has ended."""
        end = time.monotonic() + 5
        while dashboard.ask("play") != "Starting task\r\n":
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def error(self, primary):
        return primary.exception(10)[3]


class Flow(unittest.TestCase):
    def test_the_program_starts_without_power_and_leads_the_arm_once_it_has_it(self):
        with Server("--powered-off") as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.power_on()
            dashboard.brake_release()
            driver.idle()
            # A machine with other work may keep this client from its cycles, which says nothing about the arm.
            measured = next((found for found in (follow_sine(server, driver) for _ in range(5)) if found), None)
            self.assertIsNotNone(measured, "this client was never in time for a second, in five tries")
            delay, error, largest = measured
            allowed = 0.2 * 2 * math.pi * 0.1  # what the look-ahead of 0.1 s costs at the sine's highest speed
            print(
                f"\nservoj: 1 Hz sine of 0.2 rad through the reverse socket: delay {delay * 1e3:.0f} ms, "
                f"error at that delay {error * 1e3:.1f} mrad rms, largest error at no delay {largest * 1e3:.0f} mrad "
                f"(the look-ahead allows {allowed * 1e3:.0f})"
            )
            self.assertLess(delay, 0.1)
            self.assertLess(largest, allowed * 1.2)
            self.assertTrue(driver.stop())

    def test_speeds_poses_and_queued_points(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            rtsi = watch(
                server, ["actual_joint_speeds", "actual_TCP_speed", "actual_TCP_pose", "actual_joint_positions"]
            )
            driver.write(SPEEDJ, [0.2, 0, 0, 0, 0, 0], 1000)
            rtsi.until(lambda v: abs(v["actual_joint_speeds"][0] - 0.2) < 1e-3)
            driver.idle()
            rtsi.until(lambda v: max(map(abs, v["actual_joint_speeds"])) < 1e-3)
            driver.write(SPEEDL, [0, 0, 0.05, 0, 0, 0], 1000)
            rtsi.until(lambda v: abs(v["actual_TCP_speed"][2] - 0.05) < 1e-3)
            driver.idle()
            here = rtsi.until(lambda v: max(map(abs, v["actual_joint_speeds"])) < 1e-3)
            pose = list(here["actual_TCP_pose"])
            pose[2] -= 0.01
            end = time.monotonic() + 1.5
            while time.monotonic() < end:
                driver.write(POSE, pose)
                time.sleep(0.004)
            after = rtsi.until(lambda v: abs(v["actual_TCP_pose"][2] - pose[2]) < 1e-3)
            driver.idle()
            q = list(rtsi.until(lambda v: max(map(abs, v["actual_joint_speeds"])) < 1e-3)["actual_joint_positions"])
            for _ in range(100):
                q[5] += 0.001
                driver.write(SERVOJ_QUEUE, q)
                time.sleep(0.004)
            rtsi.until(lambda v: abs(v["actual_joint_positions"][5] - q[5]) < 2e-3)
            self.assertTrue(driver.stop())
            del after

    def test_trajectories_end_with_a_result_and_can_be_cancelled(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            rtsi = watch(server, ["actual_joint_positions", "actual_joint_speeds"])
            first = [0.2, -1.4, 1.4, -1.5, -1.5, 0.1]
            second = [0.4, -1.5, 1.5, -1.5, -1.5, 0.0]
            self.assertEqual(driver.run_trajectory([(first, 0.8, 0.0, False), (second, 0.8, 0.0, False)]), 0)
            q = rtsi.until(lambda v: max(map(abs, v["actual_joint_speeds"])) < 1e-3)["actual_joint_positions"]
            for actual, wanted in zip(q, second):
                self.assertAlmostEqual(actual, wanted, places=3)
            driver.action(TRAJECTORY, 1, 1)
            driver.point(first, 5.0)
            end = time.monotonic() + 0.5
            while time.monotonic() < end:
                driver.action(TRAJECTORY, 0)
                time.sleep(0.05)
            driver.action(TRAJECTORY, -1, timeout_ms=0)
            end = time.monotonic() + 5
            while (result := driver.result()) is None:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.01)
            self.assertEqual(result, 1)
            self.assertTrue(driver.stop())

    def test_a_blended_trajectory_does_not_stop_in_between(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            rtsi = watch(server, ["actual_joint_positions", "actual_joint_speeds"])
            way = [
                ([0.1 * k, -1.5708 + 0.05 * (k % 2), 1.5708, -1.5708, -1.5708, 0.0], 0.5, 0.02, False)
                for k in range(1, 6)
            ]
            slowest = []
            running = True

            def read():
                while running:
                    values = rtsi.read()
                    if 0.08 < values["actual_joint_positions"][0] < 0.42:
                        slowest.append(max(map(abs, values["actual_joint_speeds"])))

            reader = threading.Thread(target=read)
            reader.start()
            try:
                self.assertEqual(driver.run_trajectory(way), 0)
            finally:
                running = False
                reader.join()
            self.assertGreater(min(slowest), 0.02)
            self.assertTrue(driver.stop())

    def test_a_trajectory_of_points_takes_its_time(self):
        """Points every 50 ms, as a driver sends them ($ELITE_POINTS of them): how long the arm moves, by the
        controller's own clock, and how evenly. A machine that has other things to do may be late once; what is judged
        is the best of three."""
        count, step = int(os.environ.get("ELITE_POINTS", "60")), 0.05
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            rtsi = watch(server, ["timestamp", "target_joint_speeds", "target_TCP_pose", "target_TCP_speed"])
            pose = rtsi.read()["target_TCP_pose"]
            even = [k / count for k in range(1, count + 1)]
            # Slow at both ends: the speeds of its points change.
            swing = [x - math.sin(math.tau * x) / math.tau for x in even]

            def joints(way):
                return [way, *HOME[1:]]

            def line(way):
                return [pose[0], pose[1] + way, *pose[2:]]

            def run(place, cartesian, shares, way, radius):
                self.assertEqual(driver.run_trajectory([(place(0), 1.5, 0.0, cartesian)]), 0)
                moving = []
                running = True

                def read():
                    while running:
                        values = rtsi.read()
                        speed = max(map(abs, values["target_joint_speeds"]))
                        if speed > 0 and cartesian:
                            speed = math.hypot(*values["target_TCP_speed"][:3])
                        if speed > 0:
                            moving.append((values["timestamp"], speed))

                rtsi.latest()
                reader = threading.Thread(target=read)
                reader.start()
                try:
                    points = [(place(way * share), step, radius, cartesian) for share in shares]
                    self.assertEqual(driver.run_trajectory(points), 0)
                    time.sleep(0.1)
                finally:
                    running = False
                    reader.join()
                begins, ends = moving[0][0], moving[-1][0]
                speeds = [speed for at, speed in moving if begins + 0.5 < at < ends - 0.5]
                return ends - begins, min(speeds) / max(speeds)

            for name, place, cartesian, shares, speed, radius in [
                ("joints, blended", joints, False, even, 0.06, 0.0005),
                ("joints, blended, swing", joints, False, swing, 0.06, 0.0005),
                ("lines, blended", line, True, even, 0.03, 0.0005),
                ("lines, blended, swing", line, True, swing, 0.03, 0.0003),
                ("joints, every point a stop", joints, False, even, 0.01, 0.0),
                ("lines, every point a stop", line, True, even, 0.006, 0.0),
            ]:
                with self.subTest(name):
                    for _ in range(3):
                        took, evenness = run(place, cartesian, shares, speed * count * step, radius)
                        if abs(took - count * step) < 0.02 * count * step:
                            break
                    print(f"{name}: {took:.3f} s of {count * step:.3f} s, slowest {evenness:.2f} of the fastest")
                    # A program that is late behind every point is so by more than the arm can make good.
                    tolerance = 0.02 if radius > 0 else 0.12
                    self.assertLess(abs(took - count * step), tolerance * count * step)
                    if radius > 0 and shares is even:
                        self.assertGreater(evenness, 0.9)
            self.assertTrue(driver.stop())

    def test_script_commands_act_beside_the_motion(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            rtsi = watch(server, ["payload_mass", "payload_cog", "tool_output_voltage"])
            driver.script_command(1, [1.5, 0.01, 0.02, 0.03])
            values = rtsi.until(lambda v: v["payload_mass"] == 1.5)
            self.assertEqual(values["payload_cog"], (0.01, 0.02, 0.03))
            driver.script_command(2, [24])
            rtsi.until(lambda v: v["tool_output_voltage"] == 24)
            self.assertTrue(driver.stop())

    @unittest.skipUnless(" force_mode(" in listing(), "this build has no force_mode()")
    def test_force_mode_gives_way_along_its_axis_within_its_limit_and_ends(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            rtsi = watch(server, ["target_TCP_speed", "actual_TCP_pose"])
            begin = rtsi.read()["actual_TCP_pose"]
            frame, selection, wrench = [0] * 6, [0, 0, 1, 0, 0, 0], [0, 0, -20, 0, 0, 0]
            limits = [0.05] * 3 + [0.1] * 3
            # The type stands unscaled between wrench and limits. Nothing is there to press on.
            driver.script_command(3, frame + selection + wrench + [0] + limits, at={19: 2})
            fastest, end = 0.0, time.monotonic() + 10
            while True:
                values = rtsi.read()
                self.assertLess(time.monotonic(), end, f"{values}: {server.stderr()}")
                fastest = max(fastest, -values["target_TCP_speed"][2])
                if values["actual_TCP_pose"][2] < begin[2] - 0.02:
                    break
            self.assertTrue(0.005 < fastest <= 0.05 + 1e-6, fastest)
            self.assertLess(math.dist(values["actual_TCP_pose"][:2], begin[:2]), 1e-3)
            driver.script_command(4)
            rtsi.until(lambda v: max(map(abs, v["target_TCP_speed"])) < 1e-6)
            self.assertTrue(driver.stop())

    def test_freedrive_is_entered_and_left(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            driver.action(FREEDRIVE, 1, timeout_ms=0)
            primary = Primary(server.ports["primary"])
            primary.until(lambda s: s.parts[8][5] == 1, 5)
            driver.action(FREEDRIVE, -1, timeout_ms=0)
            primary.until(lambda s: s.parts[8][5] == 0, 5)
            self.assertTrue(driver.stop())


class Restarts(unittest.TestCase):
    CYCLES = 100

    def test_a_hundred_drivers_in_a_row_each_connect_at_once_and_stop(self):
        with Server() as server:
            connects, stops, before = [], [], None
            for cycle in range(self.CYCLES):
                start = time.monotonic()
                driver = Driver(server.ports["primary"])
                driver.wait_connected(10)
                connects.append(time.monotonic() - start)
                driver.idle()
                time.sleep(0.05)
                start = time.monotonic()
                self.assertTrue(driver.stop(), f"cycle {cycle}")
                stops.append(time.monotonic() - start)
                driver.close()
                if cycle == 20:  # caches are filled by then
                    before = server.rss_kib()
            growth = server.rss_kib() - before
            print(
                f"\n{self.CYCLES} drivers: connected after {statistics.median(connects) * 1e3:.0f} ms "
                f"(at most {max(connects) * 1e3:.0f}), stopped after {statistics.median(stops) * 1e3:.0f} ms "
                f"(at most {max(stops) * 1e3:.0f}), memory grew by {growth} KiB in the last {self.CYCLES - 21}"
            )
            self.assertLess(growth, 4096)

    def test_the_program_sent_twice_within_milliseconds_runs_once(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.send_script()
            driver.wait_connected()
            driver.idle()
            time.sleep(1.0)  # the second one was refused, or has replaced the first; nothing starts later
            self.assertTrue(driver.stop())
            time.sleep(2.5)
            Primary(server.ports["primary"]).until(lambda s: not s.running, 1)

    def test_a_program_that_hears_nothing_in_time_ends_by_itself(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            driver.servoj(HOME, timeout_ms=100)
            primary = Primary(server.ports["primary"])
            primary.until(lambda s: not s.running, 5)

    def test_a_pc_that_dies_does_not_leave_the_program_hanging(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            driver.idle()  # wait for ever
            time.sleep(0.1)
            driver.close()
            Primary(server.ports["primary"]).until(lambda s: not s.running, 5)

    def test_a_pose_out_of_reach_ends_the_program_with_an_exception(self):
        with Server() as server:
            driver = Driver(server.ports["primary"])
            driver.wait_connected()
            primary = Primary(server.ports["primary"])
            driver.write(POSE, [5.0, 0, 0, 0, 0, 0])
            self.assertEqual(primary.exception()[0], 10)
            primary.until(lambda s: not s.running, 5)


if __name__ == "__main__":
    unittest.main()
