"""Recordings as the public MCAP packages read them: whole ones, and those of a process that was killed."""

import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory

SERVER = os.environ["ELITESERVER"]
CHECK = os.path.join(os.path.dirname(__file__), "..", "check_recording.py")
TENDING = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "cells", "tending")
FIRST_LIGHT = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "first_light.script")

WAVE = """def wave():
  while True:
    movej([0.4, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
    movej([-0.4, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
  end
end
"""


class Recordings(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.recording = os.path.join(self.folder.name, "run.mcap")

    def tearDown(self):
        self.folder.cleanup()

    def test_a_whole_recording_is_what_the_interface_promises(self):
        command = [SERVER, "run", FIRST_LIGHT, "--record", self.recording]
        subprocess.run(command, check=True, capture_output=True, timeout=60)
        checked = subprocess.run([sys.executable, CHECK, self.recording], capture_output=True, text=True, timeout=60)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)

    def test_what_lives_in_a_cell_is_drawn(self):
        command = [
            SERVER,
            "run",
            "--cell",
            os.path.join(TENDING, "cell.toml"),
            os.path.join(TENDING, "tend.script"),
            "--record",
            self.recording,
        ]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        checked = subprocess.run([sys.executable, CHECK, self.recording], capture_output=True, text=True, timeout=60)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)

    def test_recordings_of_killed_processes_are_read_up_to_the_last_chunk(self):
        script = os.path.join(self.folder.name, "wave.script")
        with open(script, "w") as file:
            file.write(WAVE)
        moments = random.Random(10)
        for _ in range(8):
            if os.path.exists(self.recording):
                os.remove(self.recording)
            command = [SERVER, "run", script, "--plant", "ideal", "--record", self.recording]
            run = subprocess.Popen(command, stderr=subprocess.DEVNULL)
            end = time.monotonic() + 20
            # Past the beginning: schemas, the arm and a chunk of cycles.
            while not os.path.exists(self.recording) or os.path.getsize(self.recording) < 100_000:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.005)
            time.sleep(moments.uniform(0, 0.4))
            run.send_signal(signal.SIGKILL)
            run.wait()
            self.assertGreater(self.cycles_read(), 50)

    def cycles_read(self):
        """Cycles up to the place where the file ends; they are 1, 2, 3 ..."""
        with open(self.recording, "rb") as file:
            reader = NonSeekingReader(file, decoder_factories=[DecoderFactory()])
            # The public reader raises where a file ends in the middle of a record.
            reader._stream_reader = StreamReader(file, validate_crcs=True)
            expected = 0
            try:
                for decoded in reader.iter_decoded_messages(topics=["/cycle"], log_time_order=False):
                    expected += 1
                    self.assertEqual(decoded.decoded_message.cycle, expected)
            except (EndOfFile, struct.error):
                pass  # In the middle of a record or of a number, whatever stood there when the process was killed.
        return expected


if __name__ == "__main__":
    unittest.main()
