"""Port 30004: every variable of the table, set by the plant, a script or a client, and read back through a socket."""

import itertools
import math
import re
import unittest

import cs66
from elite import FORMATS, Primary, Rtsi
from server import REPOSITORY, Server

# Name, type, and how the value is checked: a number, a tuple, or a function of the value. What changes with the motion
# is checked in a test of its own.
CELL = """
[[input]]
at = 0
set = "standard_digital_in[3]"
value = true
[[input]]
at = 0
set = "configurable_digital_in[1]"
value = true
[[input]]
at = 0
set = "tool_digital_in[2]"
value = true
[[input]]
at = 0
set = "standard_analog_in[0]"
value = 2.5
[[input]]
at = 0
set = "standard_analog_in[1]"
value = 0.012
[[input]]
at = 0
set = "tool_analog_in"
value = 3.5
[[wrench]]
at = 0
duration = 1000
wrench = [3, -4, 12, 0, 0, 0]
frame = "tool"
"""

# The script sets what a script can set and then waits in its last line but one.
SCRIPT = """def table():
  set_payload(1.25, [0.01, 0.02, 0.03])
  set_standard_digital_out(2, True)
  set_configurable_digital_out(7, True)
  set_tool_digital_io_config(0, 2, True, True)
  set_tool_digital_io_config(1, 1, True, True)
  set_tool_digital_io_config(2, 0, True, False)
  set_tool_digital(1, True)
  set_standard_analog_output_domain(0, 0)
  set_standard_analog_out(0, 0.5)
  set_standard_analog_out(1, 0.25)
  set_tool_analog_output_domain(1)
  set_tool_voltage(24)
  write_output_boolean_register(0, True)
  write_output_boolean_register(33, True)
  write_output_boolean_register(64, True)
  write_output_boolean_register(127, True)
  write_output_integer_register(0, -7)
  write_output_integer_register(47, 2147483647)
  write_output_float_register(0, 1.5)
  write_output_float_register(47, -2.5)
  write_output_boolean_register(1, True)
  sleep(1000)
end
"""
WAITING_LINE = 23


def near(*wanted):
    return lambda v: all(abs(a - b) < 1e-9 for a, b in zip(v if isinstance(v, tuple) else (v,), wanted))


def about(tolerance, *wanted):
    return lambda v: all(abs(a - b) < tolerance for a, b in zip(v, wanted))


def between(low, high):
    return lambda v: all(low <= x <= high for x in (v if isinstance(v, tuple) else (v,)))


HOME = (0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0)


def at_home(v):
    return all(abs(a - b) < 5e-3 for a, b in zip(v, HOME))


def still(v):
    return all(abs(x) < 1e-3 for x in v)


OUTPUTS = [
    ("timestamp", "DOUBLE", between(0.001, 100)),
    ("payload_mass", "DOUBLE", near(1.25)),
    ("payload_cog", "VECTOR3D", near(0.01, 0.02, 0.03)),
    ("script_control_line", "UINT32", WAITING_LINE),
    ("target_joint_positions", "VECTOR6D", at_home),
    ("target_joint_speeds", "VECTOR6D", still),
    ("actual_joint_torques", "VECTOR6D", lambda v: 5 < abs(v[1]) < 200),
    ("actual_joint_positions", "VECTOR6D", at_home),
    ("actual_joint_speeds", "VECTOR6D", still),
    ("actual_joint_current", "VECTOR6D", lambda v: 0.1 < abs(v[1]) < 50),
    ("actual_TCP_pose", "VECTOR6D", lambda v: 0.3 < math.dist(v[:3], (0, 0, 0)) < 1.2),
    ("actual_TCP_speed", "VECTOR6D", still),
    ("actual_TCP_force", "VECTOR6D", about(0.05, 3, -4, 12, 0, 0, 0)),
    ("target_TCP_pose", "VECTOR6D", lambda v: 0.3 < math.dist(v[:3], (0, 0, 0)) < 1.2),
    ("target_TCP_speed", "VECTOR6D", still),
    ("actual_digital_input_bits", "UINT32", 1 << 3 | 1 << 17 | 1 << 26),
    ("actual_digital_output_bits", "UINT32", 1 << 2 | 1 << 23 | 1 << 25),
    ("joint_temperatures", "VECTOR6D", between(15, 60)),
    ("robot_mode", "INT32", 7),
    ("joint_mode", "VECTOR6INT32", (253,) * 6),
    ("safety_status", "INT32", 1),
    ("speed_scaling", "DOUBLE", near(1.0)),
    ("target_speed_fraction", "DOUBLE", near(1.0)),
    ("actual_robot_voltage", "DOUBLE", near(48.0)),
    ("actual_robot_current", "DOUBLE", between(0.1, 100)),
    ("runtime_state", "UINT32", 1),
    ("elbow_position", "VECTOR3D", lambda v: 0.2 < math.dist(v, (0, 0, 0)) < 1.0),
    ("robot_status_bits", "UINT32", 0b011),
    ("safety_status_bits", "UINT32", 1),
    ("analog_io_types", "UINT32", 0b1011),
    ("standard_analog_input0", "DOUBLE", near(2.5)),
    ("standard_analog_input1", "DOUBLE", near(0.012)),
    ("standard_analog_output0", "DOUBLE", near(0.012)),
    ("standard_analog_output1", "DOUBLE", near(2.5)),
    ("io_current", "DOUBLE", near(0.012)),  # what output 0 carries; output 1 is a voltage
    ("tool_mode", "UINT32", 253),
    ("tool_analog_input_types", "UINT32", 1),
    ("tool_analog_output_types", "UINT32", 1),
    ("tool_analog_input", "DOUBLE", near(3.5)),
    ("tool_analog_output", "DOUBLE", near(0.0)),
    ("tool_output_voltage", "DOUBLE", near(24.0)),
    ("tool_output_current", "DOUBLE", near(0.0)),  # its output is a voltage
    ("tool_temperature", "DOUBLE", between(15, 60)),
    ("tool_digital_mode", "UINT8", 0),
    ("tool_digital0_mode", "UINT8", 2),
    ("tool_digital1_mode", "UINT8", 1),
    ("tool_digital2_mode", "UINT8", 0),
    ("tool_digital3_mode", "UINT8", 1),
    ("output_bit_registers0_to_31", "UINT32", 0b11),
    ("output_bit_registers32_to_63", "UINT32", 0b10),
    ("input_bit_registers0_to_31", "UINT32", 0x80000001),
    ("input_bit_registers32_to_63", "UINT32", 0x12345678),
    ("elbow_velocity", "VECTOR3D", still),
    ("output_bit_register64", "BOOL", True),
    ("output_bit_register65", "BOOL", False),
    ("output_bit_register127", "BOOL", True),
    ("output_int_register0", "INT32", -7),
    ("output_int_register47", "INT32", 2147483647),
    ("output_double_register0", "DOUBLE", near(1.5)),
    ("output_double_register47", "DOUBLE", near(-2.5)),
    ("input_bit_register64", "BOOL", True),
    ("input_bit_register127", "BOOL", True),
    ("input_int_register0", "INT32", -1),
    ("input_int_register47", "INT32", 47),
    ("input_double_register0", "DOUBLE", near(0.125)),
    ("input_double_register47", "DOUBLE", near(-47.5)),
    ("safety_mode", "INT32", 1),
    ("actual_joint_voltage", "VECTOR6D", near(*(48.0,) * 6)),
    ("actual_current", "VECTOR6D", lambda v: 0.1 < abs(v[1]) < 50),
    ("ft_raw_wrench", "VECTOR6D", between(-100, 100)),
]

# What the vendor's examples subscribe to: 52 names.
VENDOR_OUTPUTS = [name for name, _, _ in OUTPUTS[:52]]

VENDOR_INPUTS = [
    ("speed_slider_mask", "UINT32"),
    ("speed_slider_fraction", "DOUBLE"),
    ("standard_digital_output_mask", "UINT16"),
    ("standard_digital_output", "UINT16"),
    ("configurable_digital_output_mask", "UINT8"),
    ("configurable_digital_output", "UINT8"),
    ("tool_digital_output_mask", "UINT8"),
    ("tool_digital_output", "UINT8"),
    ("standard_analog_output_mask", "UINT8"),
    ("standard_analog_output_type", "UINT8"),
    ("standard_analog_output_0", "DOUBLE"),
    ("standard_analog_output_1", "DOUBLE"),
    ("external_force_torque", "VECTOR6D"),
    ("input_bit_registers0_to_31", "UINT32"),
    ("input_bit_registers32_to_63", "UINT32"),
]


# Registers by number: name without it, numbers, type. A test of its own sets each to a value of its own.
REGISTERS = [
    ("_bit_register", range(64, 128), "BOOL"),
    ("_int_register", range(48), "INT32"),
    ("_double_register", range(48), "DOUBLE"),
]


def page():
    """What docs/RTSI.md says, which is made from the code: name and type of every output, and of every input."""
    text = (REPOSITORY / "docs" / "RTSI.md").read_text()
    directions = []
    for chapter in text.split("\n## ")[1:]:
        variables = {}
        for first, last, kind in re.findall(r"^\| `(\w+)`(?: to `(\w+)`)? \| (\w+) \|$", chapter, re.M):
            group, start = re.fullmatch(r"(.*?)(\d*)", first).groups()
            end = re.search(r"\d+$", last or first)
            names = [f"{group}{n}" for n in range(int(start), int(end[0]) + 1)] if last else [first]
            variables.update({name: kind for name in names})
        directions.append(variables)
    return directions


def zeros(recipe):
    return {n: (0.0,) * 6 if t == "VECTOR6D" else 0 for n, t in zip(recipe.names, recipe.types)}


class Table(unittest.TestCase):
    def test_every_variable_of_the_controller_has_a_row(self):
        outputs, inputs = page()
        self.assertTrue(set(outputs.values()) | set(inputs.values()) <= set(FORMATS))
        rows = {name: kind for name, kind, _ in OUTPUTS}
        registers = {
            f"{side}{group}{n}": kind
            for side in ("input", "output")
            for group, numbers, kind in REGISTERS
            for n in numbers
        }
        self.assertEqual({**rows, **registers}, outputs)
        written = {name: kind for name, kind in registers.items() if name.startswith("input")}
        self.assertEqual({**dict(VENDOR_INPUTS), **written}, inputs)

    def test_places_are_those_of_the_joints_by_the_geometry_of_the_arm(self):
        with Server("--tcp", "0.01,0.02,0.1,0,0,0") as server:
            rtsi = Rtsi(server.ports["rtsi"])
            sides = ("actual", "target")
            names = [f"{side}_{what}" for side in sides for what in ("joint_positions", "TCP_pose", "TCP_speed")]
            rtsi.set_up_outputs(names + ["elbow_position", "timestamp", "actual_joint_speeds"])
            rtsi.start()
            Primary(server.ports["primary"]).send_script("def m():\n movej([0.8,-1.2,1.2,-1.2,-1.4,0.3])\nend")
            rtsi.until(lambda v: v["actual_joint_speeds"][0] > 0.2)
            before, here, after = rtsi.read(), rtsi.read(), rtsi.read()
            for side in sides:
                links = cs66.frames(here[f"{side}_joint_positions"])
                flange = [row[:3] for row in links[5][:3]]
                tcp = cs66.plus([row[3] for row in links[5][:3]], cs66.rotate(flange, (0.01, 0.02, 0.1)))
                pose = here[f"{side}_TCP_pose"]
                for found, wanted in zip(pose[:3], tcp):
                    self.assertAlmostEqual(found, wanted, places=9)
                for found, wanted in zip(itertools.chain(*cs66.rotation(pose[3:])), itertools.chain(*flange)):
                    self.assertAlmostEqual(found, wanted, places=9)
                # The mean of a cycle before and one after: wrong by the jerk alone.
                span = after["timestamp"] - before["timestamp"]
                for axis in range(3):
                    slope = (after[f"{side}_TCP_pose"][axis] - before[f"{side}_TCP_pose"][axis]) / span
                    self.assertAlmostEqual(here[f"{side}_TCP_speed"][axis], slope, delta=2e-3, msg=f"{side} {axis}")
            elbow = [row[3] for row in cs66.frames(here["actual_joint_positions"])[1][:3]]
            for found, wanted in zip(here["elbow_position"], elbow):
                self.assertAlmostEqual(found, wanted, places=9)

    def test_an_external_wrench_acts_only_while_it_is_enabled_and_the_sensor_reads_it_exactly(self):
        mass, cog, tcp = 1.25, [0.01, 0.02, 0.03], [0.0, 0.01, 0.1]
        wrench = [3.0, -4.0, 12.0, 0.5, -0.25, 0.125]
        sensor = {"sensor_mass": 0.5, "sensor_measuring_offset": [0.0, 0.0, 0.04], "sensor_cog": [0.0, 0.0, 0.02]}
        calls = [
            (None, False),
            ("ft_rtsi_input_enable(True)", {}),
            ("ft_rtsi_input_enable(False)", False),
            (f"ft_rtsi_input_enable(True, {', '.join(f'{k}={v}' for k, v in sensor.items())})", sensor),
            ("ft_rtsi_input_enable(False)", False),
        ]
        payload = ",".join(map(str, [mass, *cog]))
        # The ideal arm stands still to the last bit, so nothing but weight and wrench is read.
        with Server("--plant", "ideal", "--tcp", f"{tcp[0]},{tcp[1]},{tcp[2]},0,0,0", "--payload", payload) as server:
            rtsi = Rtsi(server.ports["rtsi"])
            primary = Primary(server.ports["primary"])
            inputs = rtsi.set_up_inputs(["external_force_torque"])
            rtsi.set_up_outputs(["actual_TCP_pose", "actual_TCP_force", "ft_raw_wrench", "output_int_register0"])
            rtsi.start()
            rtsi.write(inputs, {"external_force_torque": wrench})
            for number, (call, enabled) in enumerate(calls):
                if call:
                    primary.send_script(
                        f"def s():\n  {call}\n  sync()\n  write_output_integer_register(0, {number})\nend"
                    )
                rtsi.until(lambda v: v["output_int_register0"] == number)
                rtsi.read()  # a cycle later
                v = rtsi.read()
                r = cs66.rotation(v["actual_TCP_pose"][3:])
                force, moment = [0.0] * 3, [0.0] * 3
                if enabled is not False:
                    own, about, centre = (enabled.get(key) for key in sensor)
                    weight = [0.0, 0.0, -cs66.GRAVITY * (own or 0.0)]
                    about = cs66.rotate(r, cs66.minus(about or tcp, tcp))  # from the TCP, base axes
                    centre = cs66.rotate(r, cs66.minus(centre or tcp, tcp))
                    force = cs66.minus(wrench[:3], weight)
                    itself = cs66.cross(cs66.minus(centre, about), weight)
                    moment = cs66.plus(cs66.minus(wrench[3:], itself), cs66.cross(about, force))
                felt = cs66.rotate_back(r, force) + cs66.rotate_back(r, moment)
                hanging = cs66.rotate_back(r, [0.0, 0.0, -cs66.GRAVITY * mass])
                raw = cs66.plus(felt, hanging + cs66.cross(cs66.minus(cog, tcp), hanging))
                for name, wanted in [("actual_TCP_force", felt), ("ft_raw_wrench", raw)]:
                    for axis in range(6):
                        self.assertAlmostEqual(v[name][axis], wanted[axis], delta=1e-9, msg=f"{call}: {name}[{axis}]")
            # Ownership ends with the connection; what was written last stays.
            rtsi.close()
            other = Rtsi(server.ports["rtsi"])
            other.set_up_inputs(["external_force_torque"])

    def test_every_output_has_its_type_and_its_value(self):
        with Server("--step-ms", "4", cell=CELL) as server:
            rtsi = Rtsi(server.ports["rtsi"])
            inputs = rtsi.set_up_inputs(
                [
                    "input_bit_registers0_to_31",
                    "input_bit_registers32_to_63",
                    "input_bit_register64",
                    "input_bit_register127",
                    "input_int_register0",
                    "input_int_register47",
                    "input_double_register0",
                    "input_double_register47",
                ]
            )
            rtsi.write(
                inputs,
                {
                    "input_bit_registers0_to_31": 0x80000001,
                    "input_bit_registers32_to_63": 0x12345678,
                    "input_bit_register64": True,
                    "input_bit_register127": True,
                    "input_int_register0": -1,
                    "input_int_register47": 47,
                    "input_double_register0": 0.125,
                    "input_double_register47": -47.5,
                },
            )
            primary = Primary(server.ports["primary"])
            primary.send_script(SCRIPT)
            names = [name for name, _, _ in OUTPUTS]
            recipe = rtsi.set_up_outputs(names)
            for (name, kind, _), given in zip(OUTPUTS, recipe.types):
                self.assertEqual(given, kind, name)
            rtsi.start()
            # Until the arm stands against the load.
            rtsi.until(lambda v: v["script_control_line"] == WAITING_LINE and v["timestamp"] > 1.5)
            values = rtsi.read()
            self.assertEqual(values["tool_temperature"], values["joint_temperatures"][5])
            self.assertEqual(len(set(values["joint_temperatures"])), 6, "the more a joint carries, the warmer it is")
            for name, _, wanted in OUTPUTS:
                with self.subTest(name=name):
                    value = values[name]
                    good = wanted(value) if callable(wanted) else value == wanted
                    self.assertTrue(good, f"{name} is {value}")

    def test_every_register_has_a_name_of_its_own_in_both_directions(self):
        of_its_own = {
            "BOOL": lambda n: n % 3 == 0,
            "INT32": lambda n: (-1) ** n * (n + 1) * 12345,
            "DOUBLE": lambda n: n / 7 - 3,
        }
        values = {f"{group}{n}": of_its_own[kind](n) for group, numbers, kind in REGISTERS for n in numbers}
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            inputs = rtsi.set_up_inputs([f"input{name}" for name in values])
            outputs = rtsi.set_up_outputs([f"{side}{name}" for side in ("input", "output") for name in values])
            kinds = [kind for _, numbers, kind in REGISTERS for _ in numbers]
            self.assertEqual((inputs.types, outputs.types), (kinds, 2 * kinds))
            rtsi.start()
            rtsi.write(inputs, {f"input{name}": value for name, value in values.items()})
            Primary(server.ports["primary"]).send_script(
                "def copy():\n while True:\n"
                "  for n in range(128):\n   write_output_boolean_register(n, read_input_boolean_register(n))\n"
                "  for n in range(48):\n   write_output_integer_register(n, read_input_integer_register(n))\n"
                "   write_output_float_register(n, read_input_float_register(n))\n"
                "  sync()\n end\nend"
            )
            last = "output_double_register47"
            rtsi.until(lambda v: v[last] == values["_double_register47"])
            found = rtsi.latest()
            for side in ("input", "output"):
                for name, value in values.items():
                    self.assertEqual(found[side + name], value, side + name)

    def test_states_of_the_robot_are_the_numbers_of_the_page(self):
        cell = "[[wrench]]\nat = 4\nduration = 0.1\nwrench = [400, 0, 0, 0, 0, 0]\nframe = 'base'\n"
        with Server("--powered-off", cell=cell) as server:
            rtsi = Rtsi(server.ports["rtsi"])
            rtsi.set_up_outputs(VENDOR_OUTPUTS + ["safety_mode"])
            rtsi.start()
            off = rtsi.read()
            self.assertEqual((off["robot_mode"], off["joint_mode"], off["tool_mode"]), (3, (239,) * 6, 239))
            self.assertEqual(
                (off["robot_status_bits"], off["actual_robot_voltage"], off["actual_robot_current"]), (0, 0, 0)
            )
            primary = Primary(server.ports["primary"])
            primary.send_script("power on")
            idle = rtsi.until(lambda v: v["robot_mode"] == 5)
            self.assertEqual((idle["joint_mode"], idle["robot_status_bits"] & 1), ((255,) * 6, 1))
            primary.send_script("set robotmode run")
            rtsi.until(lambda v: v["robot_mode"] == 7)
            primary.send_script("set speed 0.50")
            primary.send_script("def f():\n freedrive_mode()\n sleep(100)\nend")
            led = rtsi.until(lambda v: v["robot_status_bits"] == 0b111)
            self.assertEqual((led["runtime_state"], led["target_speed_fraction"], led["speed_scaling"]), (1, 0.5, 0.5))
            primary.send_script("pause task")
            rtsi.until(lambda v: v["runtime_state"] == 2)
            primary.send_script("stop task")
            stopped = rtsi.until(lambda v: v["runtime_state"] == 3)
            self.assertEqual((stopped["script_control_line"], stopped["robot_status_bits"]), (0, 1))
            hit = rtsi.until(lambda v: v["safety_status"] == 3, 10)
            self.assertEqual((hit["safety_mode"], hit["safety_status_bits"]), (3, 1 << 2 | 1 << 10))

    def test_what_moves_is_the_derivative_of_where_it_is(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            pairs = [
                ("actual_joint_positions", "actual_joint_speeds"),
                ("target_joint_positions", "target_joint_speeds"),
                ("elbow_position", "elbow_velocity"),
            ]
            rtsi.set_up_outputs([name for pair in pairs for name in pair] + ["timestamp", "runtime_state"])
            rtsi.start()
            primary = Primary(server.ports["primary"])
            primary.send_script("def m():\n movej([0.8,-1.2,1.2,-1.2,-1.4,0.3])\nend")
            rtsi.until(lambda v: v["target_joint_speeds"][0] > 0.1)
            before, here, after = rtsi.read(), rtsi.read(), rtsi.read()
            span = after["timestamp"] - before["timestamp"]
            self.assertAlmostEqual(span, 0.008)
            for position, speed in pairs:
                for axis, value in enumerate(here[speed]):
                    slope = (after[position][axis] - before[position][axis]) / span
                    self.assertAlmostEqual(value, slope, delta=2e-3, msg=f"{speed}[{axis}]")

    def test_every_input_of_the_vendors_recipe_acts_where_its_mask_says(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            inputs = rtsi.set_up_inputs([name for name, _ in VENDOR_INPUTS])
            self.assertEqual(inputs.types, [kind for _, kind in VENDOR_INPUTS])
            rtsi.set_up_outputs(VENDOR_OUTPUTS)
            rtsi.start()
            before = rtsi.read()
            values = zeros(inputs)
            rtsi.write(inputs, values)  # nothing is masked in: nothing changes
            for _ in range(5):
                after = rtsi.read()
            for name in [
                "target_speed_fraction",
                "actual_digital_output_bits",
                "standard_analog_output0",
                "analog_io_types",
            ]:
                self.assertEqual(before[name], after[name], name)

            values.update(
                speed_slider_mask=1,
                speed_slider_fraction=0.5,
                standard_digital_output_mask=0x8001,
                standard_digital_output=0xFFFF,
                configurable_digital_output_mask=0x81,
                configurable_digital_output=0x80,
                tool_digital_output_mask=0x3,
                tool_digital_output=0x2,
                standard_analog_output_mask=0b11,
                standard_analog_output_type=0b10,
                standard_analog_output_0=0.5,
                standard_analog_output_1=0.5,
                input_bit_registers0_to_31=5,
                input_bit_registers32_to_63=6,
            )
            rtsi.write(inputs, values)
            wanted = {
                "target_speed_fraction": 0.5,
                "actual_digital_output_bits": 0x8001 | 0x80 << 16 | 0x2 << 24,
                "standard_analog_output0": 0.012,
                "standard_analog_output1": 5.0,
                "analog_io_types": 0b1011,
                "input_bit_registers0_to_31": 5,
                "input_bit_registers32_to_63": 6,
            }
            after = rtsi.until(lambda v: v["target_speed_fraction"] == 0.5)
            for name, value in wanted.items():
                self.assertAlmostEqual(after[name], value, places=9, msg=name)

    def test_an_output_is_set_in_the_cycle_after_its_package(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            inputs = rtsi.set_up_inputs(["standard_digital_output_mask", "standard_digital_output"])
            rtsi.set_up_outputs(["timestamp", "actual_digital_output_bits"])
            rtsi.start()
            self.assertEqual(rtsi.read()["actual_digital_output_bits"], 0, "nothing is set at the start")
            cycles = []
            for number in range(41):
                level = number % 2 ^ 1
                before = rtsi.latest()
                rtsi.write(inputs, {"standard_digital_output_mask": 1, "standard_digital_output": level})
                after = rtsi.until(lambda v: v["actual_digital_output_bits"] == level)
                cycles.append(round((after["timestamp"] - before["timestamp"]) / 0.004))
            # The vendor's test allows four. On a busy machine this client may miss some itself, hence the median.
            self.assertLessEqual(sorted(cycles)[len(cycles) // 2], 4, f"{cycles}")

    def test_a_script_reads_what_a_client_wrote(self):
        with Server() as server:
            rtsi = Rtsi(server.ports["rtsi"])
            names = ["input_int_register5", "input_double_register6", "input_bit_register70"]
            inputs = rtsi.set_up_inputs(names)
            rtsi.set_up_outputs(["output_int_register5", "output_double_register6", "output_bit_register70"])
            rtsi.start()
            Primary(server.ports["primary"]).send_script(
                "def echo():\n while True:\n"
                "  write_output_integer_register(5, read_input_integer_register(5))\n"
                "  write_output_float_register(6, read_input_float_register(6))\n"
                "  write_output_boolean_register(70, read_input_boolean_register(70))\n"
                "  sync()\n end\nend"
            )
            rtsi.write(inputs, dict(zip(names, [-123456, 0.1, True])))
            rtsi.until(
                lambda v: (
                    v["output_int_register5"] == -123456
                    and v["output_double_register6"] == 0.1
                    and v["output_bit_register70"]
                )
            )


if __name__ == "__main__":
    unittest.main()
