"""Port 29999: what people and broken programs type, and names of files that are none."""

import socket
import time
import unittest

from elite import Dashboard, Primary
from server import Server

FOREVER = "def forever():\n  while True:\n    sleep(0.05)\n  end\nend\n"

# Every command with its usage, as `help` tells it.
USAGES = {
    "brakeRelease": "brakeRelease",
    "clear": "clear -a",
    "closeSafetyDialog": "closeSafetyDialog",
    "configuration": "configuration [-p path | -s]",
    "echo": "echo",
    "help": "help [command ...]",
    "log": "log -a text",
    "pause": "pause",
    "play": "play",
    "popup": "popup -s text | -c",
    "quit": "quit",
    "reboot": "reboot",
    "remoteControl": "remoteControl -on | -off | -s",
    "robot": "robot -t | -s | -id",
    "robotControl": "robotControl -on | -off",
    "robotMode": "robotMode",
    "safety": "safety -m | -s | -r",
    "shutdown": "shutdown",
    "speed": "speed [-v percent, 2 to 100]",
    "status": "status",
    "stop": "stop",
    "task": "task [-p path | -s | -r | -ss]",
    "unlockProtectiveStop": "unlockProtectiveStop",
    "usage": "usage [command ...]",
    "variable": "variable -get name | -set name value",
    "version": "version",
}

# Arguments that a command does not have, or not so.
WRONG = [
    "brakeRelease now",
    "clear",
    "clear -b",
    "closeSafetyDialog -x",
    "configuration -x",
    "configuration -p",
    "echo hello",
    "log",
    "log text",
    "pause 5",
    "play test.task",
    "popup",
    "popup hello",
    "popup -c now",
    "quit now",
    "reboot -f",
    "remoteControl",
    "remoteControl on",
    "robot",
    "robot -x",
    "robotControl",
    "robotControl -On",
    "robotControl -on -off",
    "robotMode -s",
    "safety",
    "safety -x",
    "shutdown now",
    "speed 50",
    "speed -v",
    "speed -v 1",
    "speed -v 101",
    "speed -v -5",
    "speed -v 50.5",
    "speed -v many",
    "speed -v 99999999999999999999",
    "status -s",
    "stop it",
    "task test.task",
    "task -p",
    "task -x",
    "unlockProtectiveStop -f",
    "variable",
    "variable -get",
    "variable -set",
    "variable -set a",
    "version 2",
]


class Typing(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()

    def setUp(self):
        self.dashboard = Dashboard(self.server.ports["dashboard"])

    def tearDown(self):
        self.assertEqual(self.dashboard.ask("echo"), "Hello ELITE ROBOTS.\r\n", "the connection lives on")

    def test_help_and_usage_know_every_command(self):
        for word in ("help", "usage"):
            listed = self.dashboard.ask(word).removeprefix("Commands: ").split()
            self.assertEqual(listed, list(USAGES))
            for name, usage in USAGES.items():
                self.assertEqual(self.dashboard.ask(f"{word} {name}"), f"Usage: {usage}\r\n")
            self.assertEqual(
                self.dashboard.ask(f"{word} task nonsense echo"),
                f'Usage: {USAGES["task"]}\r\nCommand [nonsense] is not found. Please use "help".\r\nUsage: echo\r\n',
            )

    def test_wrong_arguments_are_answered_with_the_usage_and_do_nothing(self):
        for line in WRONG:
            with self.subTest(line=line):
                name = line.split()[0]
                self.assertEqual(self.dashboard.ask(line), f"Usage: {USAGES[name]}\r\n")
        self.assertIn("RobotMode: RUNNING", self.dashboard.ask("status"))
        self.assertIn("Fraction: 100", self.dashboard.ask("status"))

    def test_unknown_commands_are_told_so_and_case_counts(self):
        for line in [
            "xyz",
            "Play",
            "ROBOTMODE",
            "robotmode",
            "-on",
            "play;stop",
            "\u8fd0\u884c",
            "task-p a",
            "statusx",
        ]:
            word = line.split()[0]
            self.assertEqual(self.dashboard.ask(line), f'Command [{word}] is not found. Please use "help".\r\n')
        self.assertEqual(self.dashboard.ask("x" * 5000), f'Command [{"x" * 60}] is not found. Please use "help".\r\n')

    def test_blanks_and_line_ends_do_not_matter(self):
        for line in ["  echo", "echo  ", "\techo\t", "echo\r", "robotMode \r", "  task   -s  ", "speed\t-v\t 100 "]:
            with self.subTest(line=line):
                self.assertNotRegex(self.dashboard.ask(line), "Usage|not found")

    def test_several_commands_in_one_piece_have_a_reply_each_in_order(self):
        self.dashboard.socket.sendall(b"echo\nrobot -t\r\n\n \nversion\nnonsense\nspeed\n")
        self.assertEqual(
            self.dashboard.replies(5),
            [
                "Hello ELITE ROBOTS.",
                "CS66",
                "2.15.0.0",
                'Command [nonsense] is not found. Please use "help".',
                "speed: 100",
            ],
        )
        self.dashboard.socket.sendall(b"robot -id\n" * 2000)
        self.assertEqual(self.dashboard.replies(2000), ["1"] * 2000)

    def test_a_command_may_come_byte_by_byte(self):
        for byte in b"robot -t\r":
            self.dashboard.socket.sendall(bytes([byte]))
            time.sleep(0.002)
        self.assertEqual(self.dashboard.ask(b""), "CS66\r\n")

    def test_a_line_that_is_far_too_long_has_one_reply(self):
        for size in (64 * 1024 + 1, 1 << 20):
            self.assertEqual(self.dashboard.ask("x" * size), "The line is longer than 64 KiB.\r\n")

    def test_bytes_that_are_no_text_are_answered(self):
        for line in [
            b"\xff\xfe",
            b"echo\xff",
            b"popup -s\xc3\x28",
            b"\x00\x00",
            b"task -p \xff.task",
            b"log -a \x1b[31m\x07",
        ]:
            with self.subTest(line=line):
                reply = self.dashboard.ask(line)
                self.assertTrue(all(c.isprintable() for c in reply[:-2]), reply)

    def test_a_browser_and_a_client_that_only_sends_disturb_nobody(self):
        browser = Dashboard(self.server.ports["dashboard"])
        browser.socket.sendall(b"GET / HTTP/1.1\r\n\r\n")
        self.assertEqual(browser.socket.recv(100), b"")
        deaf = Dashboard(self.server.ports["dashboard"])
        deaf.socket.settimeout(0.2)
        try:
            for _ in range(100):
                deaf.socket.sendall(b"status\n" * 10_000)
        except socket.timeout:
            pass  # its replies fill the pipe, so nothing more is taken from it
        self.assertEqual(self.dashboard.ask("robot -t"), "CS66\r\n")


class Files(unittest.TestCase):
    TASKS = {
        "\u4efb\u52a1\u4e00.task": FOREVER,
        "with blanks.task": FOREVER,
        "plain.script": FOREVER,
        "broken.configuration": "tcp = [0, 0\n",
        "wrong.configuration": "tcp = [0, 0, 9]\n",
        "quick.configuration": "speed = 0.25\n",
    }

    def test_names_of_tasks(self):
        with Server(tasks=self.TASKS) as server:
            folder = server.task_folder
            (folder / "folder.task").mkdir()
            (folder / "secret").symlink_to("/etc/passwd")
            (folder / "bytes.task").write_bytes(b"\xff\xfe\x00")
            (folder / "below").mkdir()
            (folder / "below" / "deep.task").write_text(FOREVER)
            dashboard = Dashboard(server.ports["dashboard"])
            primary = Primary(server.ports["primary"])
            dashboard.load("plain.task")
            for name, reason in [
                ("../plain.task", "leads out"),
                ("below/../../x", "leads out"),
                ("/etc/passwd", "leads out"),
                (str(folder / "plain.script"), "leads out"),
                ("secret", "leads out"),
                ("missing.task", "there is no"),
                ("folder.task", "there is no"),
                (".", "there is no"),
                ("below", "there is no"),
                ("a\0b.task", "leads out"),
                ("bytes.task", "cannot be read"),
                ("x" * 300, "cannot be read"),
            ]:
                with self.subTest(name=name):
                    reply = dashboard.ask(f"task -p {name}")
                    self.assertTrue(reply.startswith("Failed to load the task: "), reply)
                    self.assertIn(reason, reply)
            self.assertEqual(dashboard.ask("task"), "Relative path:plain.task\r\n", "a failure leaves what was loaded")
            for name in ["\u4efb\u52a1\u4e00.task", "with blanks.task", "plain", "below/deep.task", "./plain.script"]:
                with self.subTest(name=name):
                    dashboard.load(name)
                    dashboard.play()
                    primary.until(lambda s: s.running)
                    dashboard.pause()
                    dashboard.play()
                    dashboard.stop()
                    primary.until(lambda s: not s.running)
            # A file that vanishes after it was loaded.
            dashboard.load("plain.task")
            (folder / "plain.script").unlink()
            self.assertIn("there is no", dashboard.ask("play"))
            self.assertEqual(dashboard.ask("pause"), "Failed to execute: pause\r\n")

    def test_names_and_contents_of_configurations(self):
        with Server(tasks=self.TASKS) as server:
            dashboard = Dashboard(server.ports["dashboard"])
            for name in ["../x", "/etc/passwd", "missing.configuration", "broken.configuration", "wrong.configuration"]:
                reply = dashboard.ask(f"configuration -p {name}")
                self.assertTrue(reply.startswith("Failed to load the configuration: "), reply)
            self.assertEqual(dashboard.ask("configuration"), "configuration: Relative path:\r\n")
            dashboard.expect("configuration -p quick.configuration", "Loading Configuration :.*")
            dashboard.poll("configuration", "configuration: Relative path:quick.configuration")
            dashboard.poll("speed", "speed: 25", 5)

    def test_texts_of_variables_and_popups_stay_on_their_line(self):
        task = (
            "def v():\n  global s\n  s = 'one\\r\\ntwo\\n' + 'x' * 1000\n  while True:\n    sleep(0.05)\n  end\nend\n"
        )
        with Server(tasks={"v.task": task}) as server:
            dashboard = Dashboard(server.ports["dashboard"])
            dashboard.load("v.task")
            dashboard.play()
            end = time.monotonic() + 5
            while "one" not in (reply := dashboard.ask("variable -get s")):
                self.assertLess(time.monotonic(), end)
            self.assertEqual(reply.count("\n"), reply.count("\r\n"))
            popup = dashboard.ask("popup -s \u4f60\u597d " + "\u597d" * 1000)
            self.assertTrue(popup.startswith("Showing popup with text:\u4f60\u597d"), popup)
            self.assertEqual(
                dashboard.ask("task -s"), "Task is running\r\n", "nothing of it is left for the next reply"
            )
            dashboard.stop()


if __name__ == "__main__":
    unittest.main()
