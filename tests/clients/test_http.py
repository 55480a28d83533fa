"""The http port: inputs set from outside act on the arm's image, and pages of others set nothing."""

import json
import unittest
import urllib.error
import urllib.request

from elite import Primary, Rtsi
from server import Server


def io(server):
    with urllib.request.urlopen(f"http://127.0.0.1:{server.ports['http']}/api/io", timeout=5) as page:
        return json.load(page)["points"]


def set_inputs(server, values, **headers):
    """Status and answer."""
    headers = {"Content-Type": "application/json", **headers}
    url = f"http://127.0.0.1:{server.ports['http']}/api/inputs"
    request = urllib.request.Request(url, json.dumps(values).encode(), headers)
    try:
        with urllib.request.urlopen(request, timeout=5) as answer:
            return answer.status, json.load(answer)
    except urllib.error.HTTPError as error:
        return error.code, json.load(error)


class Inputs(unittest.TestCase):
    def test_inputs_are_seen_by_programs_and_on_every_port(self):
        wanted = {
            "standard_digital_in[3]": True,
            "configurable_digital_in[7]": True,
            "tool_digital_in[2]": True,
            "standard_analog_in[1]": 2.5,
            "tool_analog_in": 7.5,
            "input_boolean_register[64]": True,
            "input_integer_register[47]": -47,
            "input_float_register[0]": 0.125,
        }
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            rtsi.set_up_outputs(
                ["actual_digital_input_bits", "standard_analog_input1", "tool_analog_input", "output_int_register1"]
                + ["input_bit_register64", "input_int_register47", "input_double_register0"]
            )
            rtsi.start()
            Primary(server.ports["primary"]).send_script(
                "def wait():\n while not get_standard_digital_in(3):\n  sync()\n end\n"
                " write_output_integer_register(1, read_input_integer_register(47))\nend"
            )
            status, answer = set_inputs(server, wanted)
            self.assertEqual(status, 200, answer)
            seen = rtsi.until(lambda v: v["output_int_register1"] == -47)
            bits = 1 << 3 | 1 << 23 | 1 << 26
            self.assertEqual([seen[name] for name in seen], [bits, 2.5, 7.5, -47, True, -47, 0.125])
            points = io(server)
            for name, value in wanted.items():
                self.assertEqual(points[name], value, name)
            self.assertEqual(len(points), 510)
            # All or nothing.
            status, answer = set_inputs(server, {"standard_digital_in[3]": False, "standard_analog_in[1]": 10.5})
            self.assertEqual(status, 422)
            self.assertEqual(answer["error"], "standard_analog_in[1] is 10.5; it must be a number from 0 to 10 V")
            self.assertEqual(io(server)["standard_digital_in[3]"], True)

    def test_a_page_of_another_origin_sets_nothing(self):
        with Server() as server:
            own = f"127.0.0.1:{server.ports['http']}"
            high = {"standard_digital_in[0]": True}
            for headers, status in [
                ({"Origin": "http://evil.example"}, 403),
                ({"Origin": "http://evil.example", "Host": "evil.example"}, 403),
                ({"Content-Type": "text/plain"}, 415),
                ({"Origin": f"http://{own}"}, 200),
            ]:
                self.assertEqual(set_inputs(server, high, **headers)[0], status, headers)
                if status != 200:
                    self.assertEqual(io(server)["standard_digital_in[0]"], False)


if __name__ == "__main__":
    unittest.main()
