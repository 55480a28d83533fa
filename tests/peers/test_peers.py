"""Chapters 5 to 8 of the manual through `eliteserver run`, against peers that we did not write."""

import json
import os
import socket
import subprocess
import tempfile
import time
import unittest

from pymodbus.client import ModbusTcpClient

from peers import ModbusDevice, RpcServer, RtuDevice, Talker

SERVER = os.environ["ELITESERVER"]


def run(script, cell="", options=(), status=0, timeout=60):
    """Runs a script; what it printed, as lines, and what went to stderr."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "test.script")
        with open(path, "w") as file:
            file.write(script)
        command = [SERVER, "run", path, "--plant", "ideal", *options]
        if cell:
            cell_path = os.path.join(folder, "cell.toml")
            with open(cell_path, "w") as file:
                file.write(cell)
            command += ["--cell", cell_path]
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    if done.returncode != status:
        raise AssertionError(f"status {done.returncode} instead of {status}\n{done.stdout}\n{done.stderr}")
    return done.stdout.splitlines(), done.stderr


class Io(unittest.TestCase):
    def test_outputs_are_seen_at_once_and_wires_after_their_delay(self):
        cell = """
[[wire]]
from = "standard_digital_out[3]"
to = "configurable_digital_in[2]"
delay = 0.02
[[wire]]
from = "standard_analog_out[0]"
to = "standard_analog_in[1]"
[[wire]]
from = "output_integer_register[5]"
to = "input_integer_register[6]"
[[input]]
at = 0.5
set = "standard_digital_in[0]"
value = true
"""
        printed, _ = run(
            """
set_standard_digital_out(3, True)
print(get_standard_digital_out(3), get_configurable_digital_in(2))
set_standard_digital_out(3, False)
sync()
set_standard_digital_out(3, True)
cycles = 0
while not get_configurable_digital_in(2):
    sync()
    cycles += 1
print(cycles)
set_standard_digital_out(3, False)
cycles = 0
while get_configurable_digital_in(2):
    sync()
    cycles += 1
print(cycles)
set_standard_analog_out(0, 0.5)
write_output_integer_register(5, -7)
print(read_output_integer_register(5))
sync(); sync(); sync()
print(get_standard_analog_in(1), read_input_integer_register(6))
set_standard_analog_output_domain(0, 0)
set_standard_analog_out(0, 2)
print(get_standard_analog_out(0))
sleep(0.6)
print(get_standard_digital_in(0))
""",
            cell,
        )
        self.assertEqual(printed, ["True False", "6", "6", "-7", "5.0 -7", "0.02", "True"])

    def test_ranges_are_named(self):
        calls = {
            "set_standard_digital_out(16, True)": "ValueError: set_standard_digital_out(): n must be -1 to 15, got 16",
            "get_configurable_digital_in(8)": "ValueError: get_configurable_digital_in(): n must be 0 to 7, got 8",
            "set_tool_voltage(13)": "ValueError: set_tool_voltage(): voltage must be 0, 12 or 24, got 13",
            "set_standard_digital_input_action(1, 'fly')": (
                'ValueError: set_standard_digital_input_action(): action must be "default" or "freedrive", got "fly"'
            ),
            "write_output_boolean_register(128, True)": (
                "ValueError: write_output_boolean_register(): address must be 0 to 127, got 128"
            ),
            "write_output_integer_register(0, 2**31)": (
                "ValueError: write_output_integer_register(): value must be -2147483648 to 2147483647, got 2147483648"
            ),
            "read_input_float_register(48)": "ValueError: read_input_float_register(): address must be 0 to 47, got 48",
            "set_tool_digital_io_config(0, 3, True, True)": (
                "ValueError: set_tool_digital_io_config(): mode must be 0 to 2, got 3"
            ),
            "set_runstate_gp_boolean_output_to_value(0, 4)": (
                "ValueError: set_runstate_gp_boolean_output_to_value(): runstate must be 0 to 3, got 4"
            ),
            "socket_read_ascii_float(31)": "ValueError: socket_read_ascii_float(): number must be 1 to 30, got 31",
            "socket_read_byte_list(513)": "ValueError: socket_read_byte_list(): number must be 1 to 512, got 513",
            "socket_send_byte('ab')": (
                "ValueError: socket_send_byte(): value must be one ASCII character or an integer, got 'ab'"
            ),
            "modbus_add_signal('127.0.0.1', 256, 0, 3, 's')": (
                "ValueError: modbus_add_signal(): slave_number must be 0 to 255, got 256"
            ),
            "modbus_add_signal('127.0.0.1', 255, 0, 3, 's', False, 124)": (
                "ValueError: modbus_add_signal(): registers_count must be 1 to 123, got 124"
            ),
            "modbus_add_signal('127.0.0.1', 0, 0, 2, 's')": "ValueError: modbus_add_signal(): slave 0 is a broadcast",
            "modbus_get_signal_status('nobody')": (
                'RuntimeError: modbus_get_signal_status(): there is no signal "nobody"'
            ),
            "modbus_set_signal_watchdog('nobody', 301)": (
                "ValueError: modbus_set_signal_watchdog(): timeout must be a number from 0 to 300, got 301"
            ),
            "write_port_register(111, 0)": "ValueError: there is no word 111 in the controller's Modbus map",
            "write_port_register(17, 101)": (
                "ValueError: 101 is not allowed for word 17 (speed slider, %; 2 to 100 can be written)"
            ),
            "write_port_register(73, 0)": (
                "ValueError: word 73 cannot be set to 0: actual joint positions, mrad, signed"
            ),
            "tool_serial_config(True, 9601, 0, 1)": (
                "ValueError: tool_serial_config(): baud_rate must be 9600, 19200, 38400, 57600, 115200, 1000000 "
                "or 2000000, got 9601"
            ),
            "tool_modbus_read_bits(0, 1, 1)": "ValueError: tool_modbus_read_bits(): slave must be 1 to 247, got 0",
            "masterboard_modbus_rtu_read_registers(1, 0, 126)": (
                "ValueError: masterboard_modbus_rtu_read_registers(): read_count must be 1 to 125, got 126"
            ),
            "tool_modbus_write_single_register(1, 1, 65536)": (
                "ValueError: tool_modbus_write_single_register(): data must be an integer from 0 to 65535, got 65536"
            ),
            "rpc_factory('soap', '1.2.3.4:5')": 'ValueError: rpc_factory(): type must be "xmlrpc", got "soap"',
            "rpc_factory('xmlrpc', 'nowhere')": 'ValueError: rpc_factory(): url "nowhere" is no address',
        }
        script = "".join(
            f"try:\n    {call}\nexcept Exception as e:\n    print(type(e).__name__ + ':', e)\nelse:\n"
            "    print('no error')\n"
            for call in calls
        )
        printed, _ = run(script)
        for line, wanted in zip(printed, calls.values(), strict=True):
            self.assertTrue(line.startswith(wanted), f"{line!r} instead of {wanted!r}")

    def test_a_wrong_tool_pin_ends_the_program_with_an_alarm(self):
        _, said = run("try:\n    set_tool_digital(2, True)\nexcept Exception:\n    pass\nprint('went on')\n", status=1)
        self.assertIn("wrong I/O type: tool pin 2 is an input", said)
        printed, _ = run(
            "set_tool_digital_io_config(2, 0, True, True)\nset_tool_digital(2, True)\nprint(get_tool_digital(2))\n"
        )
        self.assertEqual(printed, ["True"])

    def test_scripts_without_the_network_are_refused(self):
        for call in (
            "socket_open('127.0.0.1', 1)",
            "rpc_factory('xmlrpc', '127.0.0.1:1')",
            "modbus_add_signal('127.0.0.1', 255, 0, 3, 's')",
        ):
            _, said = run(call, options=["--allow", "fs"], status=1)
            self.assertIn("PermissionError", said)
            self.assertIn("--allow net", said)


class Sockets(unittest.TestCase):
    def test_every_read_and_send(self):
        received = bytearray()

        def talk(peer):
            peer.sendall(
                b"<111><222>(3.12,,3.11 8.24)" + bytes([0, 0, 0, 100, 255, 255, 255, 156]) + bytes([1, 2, 255])
            )
            while b"END" not in received:
                received.extend(peer.recv(100))
            peer.sendall(b"JOINT_0 99999999999\nline 1\nline 2\n")
            peer.recv(100)

        peer = Talker(talk)
        printed, _ = run(
            f"""
print(socket_open("127.0.0.1", {peer.port}, "s"), socket_open("127.0.0.1", {peer.port}, "s"), socket_is_connected("s"))
print(socket_read_string("s", "<", ">"), socket_read_string("s", prefix="<", suffix=">"))
print(socket_read_ascii_float(3, "s"))
print(socket_read_binary_integer(3, "s", 0.2))
print(socket_read_byte_list(2, "s"), socket_read_byte_list(2, "s", 0.2))
print(socket_send_byte(65, "s"), socket_send_byte("b", "s"), socket_send_byte(256 + 67, "s"))
print(socket_send_int(-2, "s"), socket_send_byte_list([1, 0x3, 0x2E, 3], "s"))
print(socket_send_line("line", 2, "s"), socket_send_string([1, True], "s"), socket_set_var("V", 1000, "s"))
print(socket_send_string("END", "s"))
print(socket_get_var("JOINT_0", "s"))
print(repr(socket_read_string("s", suffix="\\n")), repr(socket_read_string("s", suffix="\\n")))
print(repr(socket_read_string("s", timeout=0.1)))
socket_close("s")
print(socket_is_connected("s"), socket_send_string("x", "s"), socket_read_binary_integer(1, "s"))
"""
        )
        self.assertEqual(
            printed,
            [
                "True True True",
                "111 222",
                "[3, 3.12, 3.11, 8.24]",
                "[2, 100, -100, -1]",
                "[2, 1, 2] [1, 255, -1]",
                "True True True",
                "True 4",
                "True True None",
                "True",
                "2147483647",
                "'line 1' 'line 2'",
                "''",
                "False False [0, -1]",
            ],
        )
        # The request for JOINT_0 may come in the same piece as the end.
        sent = bytes(received).removesuffix(b"GET JOINT_0\n")
        self.assertEqual(sent, b"AbC" + b"\xff\xff\xff\xfe" + b"\x01\x03\x2e\x03" + b"line\r\n[1,True]SET V 1000\nEND")

    def test_a_peer_that_closes_ends_an_endless_wait_and_can_be_opened_again(self):
        peer = Talker(lambda connection: connection.sendall(b"12"))
        began = time.monotonic()
        printed, _ = run(
            f"""
for k in range(2):
    print(socket_open("127.0.0.1", {peer.port}), socket_read_byte_list(5, timeout=0), socket_is_connected())
"""
        )
        self.assertEqual(printed, ["True [2, 49, 50, -1, -1, -1] False"] * 2)
        self.assertLess(time.monotonic() - began, 3)

    def test_threads_go_on_while_one_waits_and_time_keeps_wall_pace(self):
        def talk(peer):
            time.sleep(0.5)
            peer.sendall(b"x")

        peer = Talker(talk)
        printed, _ = run(
            f"""
count = [0]
def other():
    while True:
        sync()
        count[0] += 1
thread = start_thread(other, ())
socket_open("127.0.0.1", {peer.port})
print(socket_read_string(timeout=5))
print(80 < count[0] < 160)
"""
        )
        self.assertEqual(printed, ["x", "True"])

    def test_twenty_sockets_at_once(self):
        peer = Talker(lambda connection: connection.sendall(connection.recv(10)))
        printed, _ = run(
            f"""
ok = 0
for k in range(20):
    ok += socket_open("127.0.0.1", {peer.port}, "s" + str(k))
for k in range(20):
    socket_send_line(str(k), 0, "s" + str(k))
for k in range(20):
    ok += socket_read_string("s" + str(k), suffix="\\n") == str(k)
print(ok)
"""
        )
        self.assertEqual(printed, ["40"])


class ModbusTcp(unittest.TestCase):
    def test_all_kinds_of_signals(self):
        device = ModbusDevice()
        printed, _ = run(
            f"""
def add(at, kind, name, count=1):
    modbus_add_signal("127.0.0.1", 255, at, kind, name, False, count, {device.port})
add(4, 0, "di"); add(5, 1, "do"); add(6, 2, "ri"); add(7, 3, "ro"); add(100, 3, "many", 123); add(11, 1, "coils", 4)
modbus_add_rw_signal("127.0.0.1", 255, 20, 3, 21, 2, "rw", False, {device.port})
status = modbus_get_signal_status
print(status("di"), status("do"), status("ri"), status("ro"))
print(status("many") == list(range(100, 223)), status("coils"), status("rw"))
fault = modbus_get_error
print(fault("ro"), fault("ro", 1), fault("ro", 2), modbus_get_time_since_signal_invalid("ro"))
modbus_set_output_signal("do", False)
modbus_set_output_signal("coils", [False, True])
modbus_set_output_register("ro", 65536 + 300)
modbus_set_output_register("many", [1, 2, 3])
modbus_set_output_register("rw", [500, 501])
modbus_send_custom_command("127.0.0.1", 255, 6, [0, 50, 2, 88], True, {device.port})
sleep(0.5)
print(modbus_get_signal_status("rw"), modbus_get_signal_status("do"), modbus_get_signal_status("ro"))
modbus_add_signal("127.0.0.1", 255, 1999, 3, "beyond", False, 2, {device.port})
sleep(0.3)
print(modbus_get_error("beyond"))
modbus_reset_connection("127.0.0.1", True, {device.port})
print(modbus_get_error("ro"))
modbus_delete_signal("ro")
try:
    modbus_get_signal_status("ro")
except RuntimeError as e:
    print(e)
"""
        )
        self.assertEqual(
            printed,
            [
                "True True 1006 7",
                "True [True, False, True, False] [20, 21, 22]",
                "[0, 0] [0] [0] 0.0",
                "[20, 500, 501] False 300",
                "[2, 0]",
                "[0, 0]",
                'modbus_get_signal_status(): there is no signal "ro"; add it with modbus_add_signal()',
            ],
        )
        self.assertEqual(device.registers(7), [300])
        self.assertEqual(device.registers(100, 4), [1, 2, 3, 103])
        self.assertEqual(device.registers(50), [600])
        self.assertEqual([bool(c) for c in device.coils(11, 4)], [False, True, True, False])
        self.assertEqual(bool(device.coils(5)[0]), False)
        device.stop()

    def test_connection_loss_is_coded_raises_after_the_watchdog_and_heals(self):
        device = ModbusDevice()
        import threading

        def interrupt():
            time.sleep(1.5)
            device.stop()
            time.sleep(2.5)
            device.start()

        threading.Thread(target=interrupt, daemon=True).start()
        printed, _ = run(
            f"""
modbus_add_signal("127.0.0.1", 255, 3, 3, "s", False, 1, {device.port})
modbus_set_signal_watchdog("s", 1)
print(modbus_get_signal_status("s"))
while modbus_get_error("s")[0] == 0:
    sleep(0.02)
print(modbus_get_error("s")[0] < 0, modbus_get_signal_status("s"))
sleep(1.3)
print(modbus_get_time_since_signal_invalid("s") > 1)
try:
    modbus_get_signal_status("s")
except RuntimeError as e:
    print(str(e)[:60])
print(modbus_get_error("s")[1] in (104, 111))
while modbus_get_error("s") != [0, 0]:
    sleep(0.05)
print(modbus_get_signal_status("s"), modbus_get_time_since_signal_invalid("s"))
"""
        )
        self.assertEqual(
            printed,
            ["3", "True 3", "True", 'modbus_get_signal_status(): signal "s" has had no good answe', "True", "3 0.0"],
        )
        device.stop()

    def test_silence_and_garbage_do_not_hold_a_program_up(self):
        silent = Talker(lambda peer: time.sleep(30))
        garbage = Talker(lambda peer: peer.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 20) or time.sleep(1))
        began = time.monotonic()
        printed, _ = run(
            f"""
for port in ({silent.port}, {garbage.port}):
    modbus_add_signal("127.0.0.1", 255, 3, 3, "s", False, 1, port)
    modbus_set_signal_watchdog("s", 1.5)
    try:
        print(modbus_get_signal_status("s"))
    except RuntimeError as e:
        print("connection error" in str(e))
"""
        )
        self.assertEqual(printed, ["True", "True"])
        self.assertLess(time.monotonic() - began, 6)


class OwnServer(unittest.TestCase):
    """The controller's own Modbus server, with pymodbus as client and a script on port 30001."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        ready = os.path.join(self.folder.name, "ready.json")
        ports = [f"--{name}-port=0" for name in ("primary", "interpreter", "rtsi", "dashboard", "modbus", "http")]
        command = [SERVER, "serve", "--plant", "ideal", "--record", "off", "--ready-file", ready, *ports]
        self.server = subprocess.Popen(command, stderr=subprocess.DEVNULL, cwd=self.folder.name)
        deadline = time.monotonic() + 20
        while not os.path.exists(ready):
            self.assertLess(time.monotonic(), deadline, "the server does not start")
            time.sleep(0.02)
        with open(ready) as file:
            self.ports = json.load(file)["ports"]

    def tearDown(self):
        self.server.terminate()
        self.assertEqual(self.server.wait(10), 0)
        self.folder.cleanup()

    def script(self, text):
        with socket.create_connection(("127.0.0.1", self.ports["primary"])) as primary:
            primary.sendall(text.encode())
            time.sleep(0.3)

    def until(self, condition):
        deadline = time.monotonic() + 10
        while not condition():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)

    def test_scripts_and_several_clients_share_the_values(self):
        clients = [ModbusTcpClient("127.0.0.1", port=self.ports["modbus"]) for _ in range(5)]
        for client in clients:
            self.assertTrue(client.connect())
        first, last = clients[0], clients[-1]
        self.script(
            "def f():\n  write_port_bit(35, True)\n  write_port_register(256, -2)\n"
            "  write_output_integer_register(3, -70000)\n  set_configurable_digital_out(1, True)\nend\n"
        )
        self.until(lambda: last.read_coils(35, count=1).bits[0])
        self.until(lambda: first.read_discrete_inputs(49, count=1).bits[0])
        self.assertEqual(last.read_holding_registers(256, count=1).registers, [65534])
        self.assertEqual(last.read_input_registers(2, count=2).registers, [8, 2])
        self.assertEqual(first.read_holding_registers(1306, count=2).registers, [0xFFFE, 0xEE90])
        self.assertEqual(first.read_input_registers(1020, count=2).registers, [7, 1])
        self.assertEqual(first.read_input_registers(66, count=2).registers, [7, 1])
        pose = first.read_input_registers(384, count=6)
        self.assertEqual(pose.registers, first.read_holding_registers(1050, count=6).registers)
        first.write_coil(1002, True)
        first.write_register(256, 42)
        first.write_register(17, 50)
        self.assertEqual(last.read_holding_registers(17, count=1).registers, [50])
        self.script(
            "def f():\n  write_port_register(257, read_port_register(256))\n"
            "  write_port_bit(32, get_standard_digital_out(2))\nend\n"
        )
        self.until(lambda: last.read_holding_registers(257, count=1).registers == [42])
        self.until(lambda: last.read_coils(32, count=1).bits[0])
        # 48 words as a field program asks for them, gaps included; what only shows state is not written.
        self.assertEqual(len(first.read_input_registers(63, count=48).registers), 48)
        self.assertEqual(first.write_register(73, 5).exception_code, 2)
        self.assertEqual(first.read_holding_registers(111, count=1).exception_code, 2)
        self.assertEqual(first.read_holding_registers(1004, count=1).exception_code, 2)
        first.write_register(17, 100)
        for client in clients:
            client.close()

    def test_run_state_outputs_follow_every_end_of_a_program(self):
        client = ModbusTcpClient("127.0.0.1", port=self.ports["modbus"])
        client.connect()
        bodies = {
            "end": "sleep(0.5)",
            "error": "sleep(0.5)\n  1 / 0",
            "stop": "sleep(30)",
            "alarm": "sleep(0.5)\n  set_tool_digital(3, True)",
        }
        for name, body in bodies.items():
            head = (
                "set_runstate_standard_digital_output_to_value(5, 3)\n"
                "  set_runstate_standard_digital_output_to_value(6, 1)\n  set_standard_digital_out(6, True)"
            )
            self.script(f"def f():\n  {head}\n  {body}\nend\n")
            self.until(lambda: client.read_coils(1005, count=2).bits[:2] == [True, True])
            if name == "stop":
                self.script("stop task\n")
            self.until(lambda: client.read_coils(1005, count=2).bits[:2] == [False, False])
        client.close()


class Rpc(unittest.TestCase):
    def test_values_go_both_ways_and_faults_are_exceptions(self):
        server = RpcServer()
        printed, _ = run(
            f"""
rpc = rpc_factory("xmlrpc", "127.0.0.1:{server.port}")
for value in (None, True, 7, -3.25, "ä <&>", [1, [2.5, "x"]], {{"a": [1], "b": {{}}}}, b"\\x00\\xff"):
    print(rpc.echo(value))
print(rpc.add(2, 3))
try:
    rpc.fail()
except RuntimeError as e:
    print("division" in str(e), "fault" in str(e))
try:
    rpc.unknown_method(1)
except RuntimeError as e:
    print("not supported" in str(e))
try:
    rpc_factory("xmlrpc", "127.0.0.1:1").hello()
except RuntimeError as e:
    print("cannot connect to 127.0.0.1:1" in str(e))
"""
        )
        self.assertEqual(
            printed,
            [
                "None",
                "True",
                "7",
                "-3.25",
                "ä <&>",
                "[1, [2.5, 'x']]",
                "{'a': [1], 'b': {}}",
                "b'\\x00\\xff'",
                "5",
                "True True",
                "True",
                "True",
            ],
        )
        self.assertEqual(server.connections, 1, "the connection is kept")


class Rtu(unittest.TestCase):
    def test_every_function_on_both_ports(self):
        for port, prefix in (("tool", "tool_modbus_"), ("masterboard", "masterboard_modbus_rtu_")):
            device = RtuDevice()
            config = (
                "tool_serial_config(True, 115200, 0, 1, 8, True)"
                if port == "tool"
                else "masterboard_serial_config(True, 115200, 0, 1, 8, True)"
            )
            mode = f"{port}_serial_mode()"
            p = prefix
            printed, _ = run(
                f"""
print({config}, {mode})
print({p}read_bits(7, 3, 4), {p}read_input_bits(7, 4, 2), {p}read_registers(7, 10, 3), {p}read_input_registers(7, 5, 1))
written = [{p}write_single_bit(7, 20, 1), {p}write_bits(7, 30, [True, 0, 2])]
print(*written, {p}write_single_register(7, 40, 4660), {p}write_registers(7, 50, [1, 65535]))
print({p}read_bits(7, 20, 1), {p}read_bits(7, 30, 3), {p}read_registers(7, 40, 1), {p}read_registers(7, 50, 2))
print({p}read_registers(7, 1999, 5, 1), {p}write_single_register(9, 0, 0, 0.3))
""",
                cell=f'[[serial]]\nport = "{port}"\ndevice = "{device.path}"\n',
            )
            # The manual: True at the tool, the number written at the control box.
            bits, words = ("True", "True") if port == "tool" else ("3", "2")
            self.assertEqual(
                printed,
                [
                    "True MODBUS-RTU" if port == "tool" else "True 2",
                    "[1, 0, 1, 0] [1, 0] [10, 11, 12] [1005]",
                    f"1 {bits} 1 {words}",
                    "[1] [1, 0, 1] [4660] [1, 65535]",
                    "[] 0",
                ],
            )

    def test_a_damaged_answer_is_an_empty_list_and_the_next_is_good(self):
        device = RtuDevice()
        device.damage_next = True
        printed, said = run(
            """
masterboard_serial_config(True, 115200, 0, 1, 8, True)
print(masterboard_modbus_rtu_read_registers(7, 10, 2, 2))
print(masterboard_modbus_rtu_read_registers(7, 10, 2, 2))
""",
            cell=f'[[serial]]\nport = "masterboard"\ndevice = "{device.path}"\n',
        )
        self.assertEqual(printed, ["[]", "[10, 11]"])
        self.assertIn("checksum", said)

    def test_a_port_in_daemon_use_ends_the_program_with_an_alarm(self):
        device = RtuDevice()
        cell = f'[[serial]]\nport = "tool"\ndevice = "{device.path}"\n'
        _, said = run(
            "tool_serial_config(True, 115200, 0, 1, 8, False, 1)\nprint(tool_serial_is_open())\n"
            "tool_serial_write('x')\n",
            cell=cell,
            status=1,
        )
        self.assertIn("Daemon", said)

    def test_a_port_without_a_device_says_so(self):
        printed, said = run(
            "print(tool_serial_config(True, 115200, 0, 1), tool_serial_mode(), tool_serial_read(1, True, 0.1), "
            "tool_serial_write('x'))\n"
        )
        self.assertEqual(printed, ["False CLOSE [] 0"])
        self.assertIn("[[serial]]", said)

    def test_bytes_over_tcp(self):
        def talk(peer):
            data = peer.recv(100)
            peer.sendall(bytes(reversed(data)))
            time.sleep(1)

        peer = Talker(talk)
        printed, _ = run(
            """
print(tool_serial_config(True, 9600, 2, 2), tool_serial_mode())
print(tool_serial_write([255, 0, 266]), tool_serial_read(2, True, 1), tool_serial_read(5, False, 0.2))
""",
            cell=f'[[serial]]\nport = "tool"\ndevice = "tcp:127.0.0.1:{peer.port}"\n',
        )
        self.assertEqual(printed, ["True RS485", "3 [10, 0] b'\\xff'"])


class Stop(unittest.TestCase):
    def test_the_end_of_a_program_ends_every_wait(self):
        peer = Talker(lambda connection: time.sleep(30))
        began = time.monotonic()
        run(
            f"""
def wait():
    socket_open("127.0.0.1", {peer.port})
    socket_read_string(timeout=0)
def call():
    rpc_factory("xmlrpc", "127.0.0.1:{peer.port}").hello()
def serial():
    tool_serial_config(True, 9600, 2, 2)
    tool_serial_read(1, True, 0)
for f in (wait, call, serial):
    start_thread(f, ())
sleep(0.5)
""",
            cell=f'[[serial]]\nport = "tool"\ndevice = "tcp:127.0.0.1:{peer.port}"\n',
        )
        self.assertLess(time.monotonic() - began, 3)


if __name__ == "__main__":
    unittest.main()
