"""Bags: what `--ros2-profile` and `replay --rosbag2` write, read by rosbags and mcap-ros2-support; and bags that
rosbags writes as the vendor's driver would, as sides of `compare`."""

import csv
import io
import json
import os
import pathlib
import random
import subprocess

import numpy
import pytest
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from conftest import JOINTS

STORE = get_typestore(Stores.ROS2_JAZZY)
JointState = STORE.types["sensor_msgs/msg/JointState"]
Header = STORE.types["std_msgs/msg/Header"]
Time = STORE.types["builtin_interfaces/msg/Time"]
MOVES = "movej([0.3, -1.2, 1.2, -1.57, -1.57, 0.2], a=2, v=1)\nset_standard_digital_out(3, True)\nsleep(0.1)\n"
# Topics that have one message a cycle.
CYCLIC = {
    "/joint_states",
    "/tf",
    "/force_torque_sensor_broadcaster/wrench",
    "/tcp_pose_broadcaster/pose",
    "/speed_scaling_state_broadcaster/speed_scaling",
    "/io_and_status_controller/io_states",
    "/io_and_status_controller/tool_data",
}
LATCHED = {
    "/robot_description",
    "/tf_static",
    "/io_and_status_controller/robot_mode",
    "/io_and_status_controller/safety_mode",
}


def server(folder, *arguments, status=0):
    done = subprocess.run(
        [os.environ["ELITESERVER"], *arguments], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == status, (arguments, done.returncode, done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run with its recording x.mcap, the bag x beside it, and the rows of /cycle."""
    folder = tmp_path_factory.mktemp("bags")
    (folder / "move.script").write_text(MOVES)
    server(folder, "run", "move.script", "--record", "x.mcap", "--ros2-profile")
    rows = list(csv.DictReader(io.StringIO(server(folder, "replay", "x.mcap", "--csv", "/cycle"))))
    assert len(rows) > 200
    return folder, rows


def nanos(row):
    secs, fraction = row["log_time"].split(".")
    return int(secs) * 10**9 + int(fraction.ljust(9, "0"))


def six(row, name):
    return [float(row[f"{name}_{k}"]) for k in range(6)]


def test_counts_times_and_values_equal_those_of_the_cycles(recorded):
    folder, rows = recorded
    of_topic = {}
    with AnyReader([folder / "x"]) as reader:
        assert {c.topic for c in reader.connections} == CYCLIC | LATCHED
        for connection, at, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            of_topic.setdefault(connection.topic, []).append((at, message))
        assert reader.message_count == sum(len(found) for found in of_topic.values())
        counts = {c.topic: c.msgcount for c in reader.connections}
        assert counts == {topic: len(found) for topic, found in of_topic.items()}
    epoch = of_topic["/joint_states"][0][0] - nanos(rows[0])
    expected = [epoch + nanos(row) for row in rows]
    for topic in CYCLIC:
        assert [at for at, _ in of_topic[topic]] == expected, topic
    for topic in LATCHED:
        assert of_topic[topic][0][0] == expected[0], topic
    for row, (_, state), (_, wrench), (_, io_state) in zip(
        rows,
        of_topic["/joint_states"],
        of_topic["/force_torque_sensor_broadcaster/wrench"],
        of_topic["/io_and_status_controller/io_states"],
    ):
        assert list(state.name) == JOINTS
        assert state.header.stamp.sec * 10**9 + state.header.stamp.nanosec == nanos(row)
        assert list(state.position) == six(row, "actual_q")
        assert list(state.velocity) == six(row, "actual_qd")
        assert list(state.effort) == six(row, "actual_torque")
        force, torque = wrench.wrench.force, wrench.wrench.torque
        assert [force.x, force.y, force.z, torque.x, torque.y, torque.z] == six(row, "tcp_force")
        assert io_state.standard_out[3] == bool(int(float(row["digital_out"])) >> 3 & 1)
    assert of_topic["/io_and_status_controller/io_states"][-1][1].standard_out[3]
    assert "<robot" in of_topic["/robot_description"][0][1].data
    # The metadata says what the files say.
    text = (folder / "x" / "metadata.yaml").read_text()
    assert f"nanoseconds_since_epoch: {expected[0]}" in text
    assert f"nanoseconds: {expected[-1] - expected[0]}" in text


def test_mcap_ros2_support_decodes_every_message(recorded):
    folder, rows = recorded
    counts = {}
    for message in read_ros2_messages(str(folder / "x" / "x_0.mcap")):
        counts[message.channel.topic] = counts.get(message.channel.topic, 0) + 1
        if message.channel.topic == "/joint_states":
            row = rows[counts["/joint_states"] - 1]
            assert list(message.ros_msg.position) == six(row, "actual_q")
    assert {topic: counts.get(topic) for topic in CYCLIC} == dict.fromkeys(CYCLIC, len(rows))


def test_a_recording_that_is_replayed_makes_the_bag_of_its_run(recorded):
    """Message for message; a driver's client would not tell the two apart."""
    folder, rows = recorded
    server(folder, "replay", "x.mcap", "--rosbag2", "again")
    read = []
    for name in ("x", "again"):
        with AnyReader([folder / name]) as reader:
            begin = reader.start_time
            read.append(
                sorted(
                    (
                        connection.topic,
                        at - begin,
                        connection.msgtype,
                        repr(reader.deserialize(data, connection.msgtype)),
                    )
                    for connection, at, data in reader.messages()
                )
            )
    assert len(read[0]) > len(CYCLIC) * len(rows)
    assert read[0] == read[1]


def write_driver_bag(path, rows, plugin=StoragePlugin.MCAP, prefix="", by=0.0, delay=1.25):
    """A bag as the driver's, which publishes joints by alphabet and stamps of its own clock; another publisher is on
    the same topic. The messages arrive late and unevenly."""
    draw = random.Random(48)
    begin = 1_700_000_000_000_000_000
    order = sorted(range(6), key=lambda k: JOINTS[k])
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/joint_states", JointState.__msgtype__, typestore=STORE)

        def put(at, logged, names, positions):
            state = JointState(
                header=Header(stamp=Time(sec=at // 10**9, nanosec=at % 10**9), frame_id="base_link"),
                name=names,
                position=numpy.array(positions),
                velocity=numpy.zeros(len(names)),
                effort=numpy.zeros(len(names)),
            )
            writer.write(connection, logged, STORE.serialize_cdr(state, JointState.__msgtype__))

        for row in rows:
            at = begin + nanos(row) + round(delay * 1e9)
            q = six(row, "actual_q")
            q[2] += by
            put(at, at + draw.randrange(3_000_000), [prefix + JOINTS[k] for k in order], [q[k] for k in order])
            put(at, at + 3_000_000, ["finger_joint"], [0.04])


def test_a_bag_of_the_driver_is_a_side_of_compare(recorded):
    folder, rows = recorded
    for prefix in ("", "left_"):
        write_driver_bag(folder / f"driver{prefix}", rows, prefix=prefix)
        found = json.loads(
            server(folder, "compare", "x.mcap", f"driver{prefix}", "--format", "json", "--within", "1e-6")
        )
        # A bag begins at its own first message.
        assert abs(found["shift"] + nanos(rows[0]) * 1e-9) < 1e-4
        assert found["joints"][5]["samples"] >= len(rows) - 2
        assert found["tcp_position"] is None and found["force"] is None
        # Both sides may be bags.
        server(folder, "compare", f"driver{prefix}", "x", "--within", "1e-6")
    write_driver_bag(folder / "bent", rows, by=0.01)
    found = json.loads(
        server(folder, "compare", "x", "bent", "--format", "json", "--within", "0.005", status=1).splitlines()[0]
    )
    assert abs(found["joints"][2]["largest"] - 0.01) < 1e-3
    server(folder, "compare", "x", "bent", "--plot", "apart.png")
    assert (folder / "apart.png").read_bytes().startswith(b"\x89PNG")


def test_a_bag_in_sqlite_says_how_it_becomes_one_that_is_read(recorded):
    folder, rows = recorded
    write_driver_bag(folder / "old", rows[:10], plugin=StoragePlugin.SQLITE3)
    assert "ros2 bag convert" in server(folder, "compare", "x.mcap", "old", status=2)


def test_bytes_that_are_no_bag_are_answered_with_one_sentence(recorded):
    """A bag with holes, cut, and with wrong numbers in it: refused, or compared as far as it goes; never more than a
    second or two of the processor, and never a panic."""
    folder, rows = recorded
    write_driver_bag(folder / "whole", rows[:40])
    content = next((folder / "whole").glob("*.mcap")).read_bytes()
    draw = random.Random(49)
    for number in range(60):
        broken = bytearray(content)
        if number % 3 == 0:
            del broken[draw.randrange(len(broken)) :]
        for _ in range(draw.randrange(1, 4) if number % 3 else 0):
            at = draw.randrange(len(broken))
            broken[at : at + 4] = draw.choice([b"\xff\xff\xff\xff", b"\0\0\0\0", draw.randbytes(4)])
        path = pathlib.Path(folder) / "broken.mcap"
        path.write_bytes(broken)
        done = subprocess.run(
            [
                "bash",
                "-c",
                'ulimit -v 1500000; exec "$0" "$@"',
                os.environ["ELITESERVER"],
                "compare",
                "x.mcap",
                str(path),
            ],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.returncode in (0, 2), (number, done)
        if done.returncode == 2:
            assert done.stderr.count("\n") == 1 and done.stderr.startswith("eliteserver: "), (number, done.stderr)
        assert "panicked" not in done.stderr
