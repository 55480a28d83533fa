"""Topics, services and parameters as rclpy sees them."""

import math

from conftest import JOINTS, LATCHED
from eli_common_interface.msg import IOState, RobotMode, SafetyMode, ToolData
from eli_common_interface.srv import SetIO, SetPayload, SetSpeedSliderFraction
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage


def test_joint_states_come_at_the_rate_of_the_controller(peer):
    found = peer.collect(JointState, "joint_states", 100)
    peer.wait_for(lambda: len(found) >= 500, 30, "half a thousand joint states")
    messages = [message for _, message in found[:500]]
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
    slider = lambda x: peer.call(
        SetSpeedSliderFraction, "io_and_status_controller/set_speed_slider",
        SetSpeedSliderFraction.Request(speed_slider_fraction=x)).success
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
