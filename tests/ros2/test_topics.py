"""Topics, services and parameters as rclpy sees them."""

import math
import pathlib
import subprocess
import sys

import pytest
from eli_common_interface.msg import IOState, RobotMode, SafetyMode, ToolData
from eli_common_interface.srv import SetIO, SetPayload, SetSpeedSliderFraction
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.action import get_action_server_names_and_types_by_node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from conftest import JOINTS, LATCHED


def test_joint_states_come_at_the_rate_of_the_controller(peer):
    found = peer.collect(JointState, "joint_states", 100)
    peer.wait_for(lambda: len(found) >= 500, 30, "half a thousand joint states")
    messages = [message for _, message in found[:500]]
    # A stamp is a moment that has passed: what looks up a transform of it would otherwise wait for the future.
    assert all(at - m.header.stamp.sec - m.header.stamp.nanosec * 1e-9 > 0 for at, m in found)
    assert messages[0].name == JOINTS
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]
    steps = [b - a for a, b in zip(stamps, stamps[1:])]
    assert all(step % 4_000_000 <= 1 or step % 4_000_000 >= 3_999_999 for step in steps)
    # On a machine that does other things as well, some are lost.
    assert sum(abs(step - 4_000_000) <= 1 for step in steps) > 400
    assert all(len(m.position) == len(m.velocity) == len(m.effort) == 6 for m in messages)


def test_every_topic_has_its_type_and_speaks(peer):
    expected = [
        (TFMessage, "/tf", 100),
        (TFMessage, "/tf_static", LATCHED),
        (String, "robot_description", LATCHED),
        (WrenchStamped, "force_torque_sensor_broadcaster/wrench", 10),
        (PoseStamped, "tcp_pose_broadcaster/pose", 10),
        (Float64, "speed_scaling_state_broadcaster/speed_scaling", 10),
        (IOState, "io_and_status_controller/io_states", 10),
        (ToolData, "io_and_status_controller/tool_data", 10),
        (RobotMode, "io_and_status_controller/robot_mode", 10),
        (SafetyMode, "io_and_status_controller/safety_mode", 10),
        (Bool, "io_and_status_controller/robot_task_running", LATCHED),
    ]
    found = {topic: peer.collect(kind, topic, qos) for kind, topic, qos in expected}
    for topic, messages in found.items():
        peer.wait_for(lambda: messages, 20, topic)
    tf = found["/tf"][-1][1].transforms
    assert [t.child_frame_id for t in tf][:3] == ["shoulder_link", "upperarm_link", "forearm_link"]
    assert tf[-1].header.frame_id == "base" and tf[-1].child_frame_id == "tool0_controller"
    fixed = {t.child_frame_id for t in found["/tf_static"][-1][1].transforms}
    assert {"base_link_inertia", "base", "flange", "tool0"} <= fixed
    assert "<robot" in found["robot_description"][-1][1].data
    assert found["speed_scaling_state_broadcaster/speed_scaling"][-1][1].data == 100.0
    assert found["io_and_status_controller/robot_mode"][-1][1].mode == 7
    wrench = found["force_torque_sensor_broadcaster/wrench"][-1][1]
    assert wrench.header.frame_id == "tool0"
    names = dict(peer.node.get_topic_names_and_types())
    assert names["/joint_states"] == ["sensor_msgs/msg/JointState"]
    assert ("elite_controller", "/") in peer.node.get_node_names_and_namespaces()


def test_services_of_the_dashboard_answer_as_it_does(peer):
    state = peer.collect(RobotMode, "io_and_status_controller/robot_mode", LATCHED)
    mode = lambda: state[-1][1].mode if state else None
    peer.wait_for(lambda: mode() == 7, what="running")
    done = peer.call(Trigger, "dashboard_client/power_off")
    assert done.success and "Powering off" in done.message
    peer.wait_for(lambda: mode() == 3, what="power off")
    refused = peer.call(Trigger, "dashboard_client/play")
    assert not refused.success and "no task is loaded" in refused.message
    assert peer.call(Trigger, "dashboard_client/power_on").success
    peer.wait_for(lambda: mode() == 5, what="idle")
    assert peer.call(Trigger, "dashboard_client/brake_release").success
    peer.wait_for(lambda: mode() == 7, what="running")
    assert peer.call(Trigger, "dashboard_client/close_safety_dialog").success
    assert peer.call(Trigger, "io_and_status_controller/zero_ftsensor").success


def test_outputs_payload_and_slider(peer):
    io = peer.collect(IOState, "io_and_status_controller/io_states", 10)
    scaling = peer.collect(Float64, "speed_scaling_state_broadcaster/speed_scaling", 10)
    request = SetIO.Request(fun=1, pin=3, state=1.0)
    assert peer.call(SetIO, "io_and_status_controller/set_io", request).success
    peer.wait_for(lambda: io and io[-1][1].standard_out[3], what="the output")
    assert not peer.call(SetIO, "io_and_status_controller/set_io", SetIO.Request(fun=1, pin=16, state=1.0)).success
    assert not peer.call(SetIO, "io_and_status_controller/set_io", SetIO.Request(fun=9)).success
    slider = lambda x: (
        peer.call(
            SetSpeedSliderFraction,
            "io_and_status_controller/set_speed_slider",
            SetSpeedSliderFraction.Request(speed_slider_fraction=x),
        ).success
    )
    assert slider(0.5)
    peer.wait_for(lambda: scaling and scaling[-1][1].data == 50.0, what="half the speed")
    assert slider(1.0)
    assert not slider(0.0) and not slider(math.nan) and not slider(1.5)
    payload = SetPayload.Request(mass=1.0)
    assert peer.call(SetPayload, "io_and_status_controller/set_payload", payload).success
    payload.mass = -1.0
    assert not peer.call(SetPayload, "io_and_status_controller/set_payload", payload).success


def test_parameters_are_listed_read_described_and_not_set(peer):
    names = peer.call(ListParameters, "elite_controller/list_parameters").result.names
    assert {"model", "step_ms", "robot_ip", "tf_prefix"} <= set(names)
    request = GetParameters.Request(names=["model", "step_ms", "nothing"])
    values = peer.call(GetParameters, "elite_controller/get_parameters", request).values
    assert values[0].string_value == "cs66" and values[1].double_value == 4.0
    assert values[2].type == ParameterType.PARAMETER_NOT_SET
    request = DescribeParameters.Request(names=["model"])
    described = peer.call(DescribeParameters, "elite_controller/describe_parameters", request).descriptors[0]
    assert described.read_only and described.description
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="cs63")
    request = SetParameters.Request(parameters=[Parameter(name="model", value=value)])
    result = peer.call(SetParameters, "elite_controller/set_parameters", request).results[0]
    assert not result.successful and "model cannot be set" in result.reason


def test_introspection_finds_all_there_is(peer):
    """What `ros2 node info`, `topic list -t`, `service list -t` and `action list -t` ask."""
    node, name = peer.node, ("elite_controller", "/")
    publishers = {
        "/joint_states": "sensor_msgs/msg/JointState",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/tf_static": "tf2_msgs/msg/TFMessage",
        "/robot_description": "std_msgs/msg/String",
        "/force_torque_sensor_broadcaster/wrench": "geometry_msgs/msg/WrenchStamped",
        "/tcp_pose_broadcaster/pose": "geometry_msgs/msg/PoseStamped",
        "/speed_scaling_state_broadcaster/speed_scaling": "std_msgs/msg/Float64",
        "/io_and_status_controller/io_states": "eli_common_interface/msg/IOState",
        "/io_and_status_controller/tool_data": "eli_common_interface/msg/ToolData",
        "/io_and_status_controller/robot_mode": "eli_common_interface/msg/RobotMode",
        "/io_and_status_controller/safety_mode": "eli_common_interface/msg/SafetyMode",
        "/io_and_status_controller/robot_task_running": "std_msgs/msg/Bool",
        "/rosout": "rcl_interfaces/msg/Log",
        "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
    }
    triggers = [
        "power_on",
        "power_off",
        "brake_release",
        "unlock_protective_stop",
        "play",
        "pause",
        "stop",
        "close_safety_dialog",
        "restart_safety",
        "get_task_path",
    ]
    services = {
        **{f"/dashboard_client/{trigger}": "std_srvs/srv/Trigger" for trigger in triggers},
        "/io_and_status_controller/set_io": "eli_common_interface/srv/SetIO",
        "/io_and_status_controller/set_payload": "eli_common_interface/srv/SetPayload",
        "/io_and_status_controller/set_speed_slider": "eli_common_interface/srv/SetSpeedSliderFraction",
        "/io_and_status_controller/zero_ftsensor": "std_srvs/srv/Trigger",
        **{
            f"/elite_controller/{snake}": f"rcl_interfaces/srv/{kind}"
            for snake, kind in [
                ("describe_parameters", "DescribeParameters"),
                ("get_parameter_types", "GetParameterTypes"),
                ("get_parameters", "GetParameters"),
                ("list_parameters", "ListParameters"),
                ("set_parameters", "SetParameters"),
                ("set_parameters_atomically", "SetParametersAtomically"),
            ]
        },
    }
    trajectories = "/scaled_joint_trajectory_controller"
    missing = lambda expected, found: {n: k for n, k in expected.items() if dict(found).get(n) != [k]}
    peer.wait_for(lambda: name in node.get_node_names_and_namespaces(), what="the node")
    for what, expected, found in [
        ("publishers", publishers, lambda: node.get_publisher_names_and_types_by_node(*name)),
        (
            "subscriptions",
            {f"{trajectories}/joint_trajectory": "trajectory_msgs/msg/JointTrajectory"},
            lambda: node.get_subscriber_names_and_types_by_node(*name),
        ),
        ("services", services, lambda: node.get_service_names_and_types_by_node(*name)),
        ("all services", services, node.get_service_names_and_types),
        (
            "actions",
            {f"{trajectories}/follow_joint_trajectory": "control_msgs/action/FollowJointTrajectory"},
            lambda: get_action_server_names_and_types_by_node(node, *name),
        ),
    ]:
        try:
            peer.wait_for(lambda: not missing(expected, found()), 10)
        except AssertionError:
            raise AssertionError(f"{what}: {missing(expected, found())} of {found()}") from None
    for topic, kind in publishers.items():
        ends = [end for end in node.get_publishers_info_by_topic(topic) if end.node_name == name[0]]
        assert len(ends) == 1 and ends[0].topic_type == kind, (topic, ends)


def test_qos_of_every_usual_kind_is_taken_without_a_warning(controller):
    """A process of its own, whose output is whatever rclpy has to say."""
    done = subprocess.run(
        [sys.executable, str(pathlib.Path(__file__).parent / "child.py"), "subscribe", str(controller.domain)],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.split() == ["well"] and not done.stderr, done.stdout + done.stderr


def test_every_socket_of_the_node_is_held_to_the_loopback_interface(controller, peer):
    peer.wait_for(controller.node_pid, what="the node")
    try:
        table = subprocess.run(["ss", "-H", "-uanp"], capture_output=True, text=True, check=True).stdout
    except FileNotFoundError:
        pytest.skip("ss says what sockets are bound to, and is not installed")
    own = [line.split() for line in table.splitlines() if f"pid={controller.node_pid()}," in line]
    assert len(own) >= 4, table
    assert all(columns[3].partition("%")[2].startswith("lo:") for columns in own), own
