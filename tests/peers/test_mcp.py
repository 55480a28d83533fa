"""`eliteserver mcp` with the client of the Python SDK: what an assistant does from
the first question to the picture."""

import asyncio
import base64
import os
import struct
import tempfile
import unittest

from mcp import ClientSession, StdioServerParameters, stdio_client

SERVER = os.environ["ELITESERVER"]

PROGRAM = """\
print("towards", target)
movej([target, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)
"""

TESTS = """\
def test_arrives():
    result = test.run("move.script", timeout=30)
    assert result.outcome == "ended", result.error

def test_is_slow():
    test.run("move.script")
    assert test.peak("joint_speed") < 0.1
"""


def told(result):
    return "\n".join(part.text for part in result.content if part.type == "text")


class Assistant(unittest.IsolatedAsyncioTestCase):
    async def session(self, folder, use):
        parameters = StdioServerParameters(command=SERVER, args=["mcp"], cwd=folder)
        async with stdio_client(parameters) as (read, write):
            async with ClientSession(read, write) as session:
                await session.initialize()
                await use(session)

    async def test_a_program_is_written_checked_run_tested_and_looked_at(self):
        async def use(session):
            tools = {tool.name: tool for tool in (await session.list_tools()).tools}
            self.assertEqual(
                sorted(tools),
                [
                    "builtin",
                    "check",
                    "clearance",
                    "plan_path",
                    "replay_at",
                    "replay_find",
                    "replay_plot",
                    "replay_summary",
                    "run",
                    "test",
                ],
            )
            for tool in tools.values():
                self.assertTrue(tool.description)

            full = told(await session.call_tool("builtin", {"name": "movej"}))
            self.assertIn("movej(q, a=", full)
            found = told(await session.call_tool("builtin", {"search": "joint move"}))
            self.assertIn("movej", found)

            wrong = await session.call_tool("check", {"program": PROGRAM})
            self.assertEqual([f["code"] for f in wrong.structured_content["findings"]], ["undefined-name"] * 2)

            ran = await session.call_tool("run", {"program": PROGRAM, "set": {"target": 0.5}, "record": "run.mcap"})
            self.assertFalse(ran.is_error, told(ran))
            result = ran.structured_content
            self.assertEqual((result["outcome"], result["prints"]), ("ended", "towards 0.5"))
            self.assertAlmostEqual(result["joint_positions"][0], 0.5, places=3)

            summary = told(await session.call_tool("replay_summary", {"recording": "run.mcap"}))
            self.assertIn("movej 1", summary)
            state = told(await session.call_tool("replay_at", {"recording": "run.mcap", "time": 0.3}))
            self.assertIn("line 2", state)
            when = told(
                await session.call_tool("replay_find", {"recording": "run.mcap", "condition": "actual_q[0] > 0.25"})
            )
            self.assertIn("found: 1 time", when)
            plot = await session.call_tool("replay_plot", {"recording": "run.mcap"})
            image = next(part for part in plot.content if part.type == "image")
            png = base64.b64decode(image.data)
            self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(struct.unpack(">II", png[16:24]), (1600, 1500))

            tests = (await session.call_tool("test", {})).structured_content
            self.assertEqual((tests["passed"], tests["failed"]), (1, 1))
            failed = next(test for test in tests["tests"] if test["status"] == "failed")
            self.assertEqual((failed["name"], failed["line"]), ("test_is_slow", 7))

            refused = await session.call_tool("run", {"program": "pass", "time": -1})
            self.assertTrue(refused.is_error)
            self.assertIn("time is -1", told(refused))
            outside = await session.call_tool("check", {"file": "/etc/hostname"})
            self.assertTrue(outside.is_error)
            self.assertIn("is not within", told(outside))

        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "move.script"), "w") as file:
                file.write("target = 0.4\n" + PROGRAM)
            with open(os.path.join(folder, "test_move.script"), "w") as file:
                file.write(TESTS)
            await self.session(folder, use)

    async def test_a_client_that_does_not_wait_gets_its_next_answers(self):
        async def use(session):
            endless = {"program": "while True:\n    pass\n", "time": 3600, "wall_time": 300}
            with self.assertRaises(Exception):
                await session.call_tool("run", endless, read_timeout_seconds=0.5)
            answer = await asyncio.wait_for(session.call_tool("check", {"program": "pass\n"}), 60)
            self.assertEqual(told(answer), "no findings")

        with tempfile.TemporaryDirectory() as folder:
            await self.session(folder, use)


if __name__ == "__main__":
    unittest.main()
