"""Simulated time."""

import time

from conftest import DOMAINS, Controller, Peer
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from test_trajectories import goal_of, point


def test_a_minute_of_simulated_time_takes_less(tmp_path):
    controller = Controller(
        tmp_path, next(DOMAINS), "--clock", "virtual", "--plant", "ideal", "--ros-rate", "25")
    try:
        peer = Peer(controller.domain, parameter_overrides=[Parameter("use_sim_time", value=True)])
        clock = peer.collect(Clock, "/clock", 100)
        states = peer.collect(JointState, "joint_states", 100)
        client = ActionClient(peer.node, FollowJointTrajectory, "scaled_joint_trajectory_controller/follow_joint_trajectory")
        assert client.wait_for_server(30)
        peer.wait_for(lambda: clock and states, 20, "time")
        time.sleep(1.0)
        start = list(states[-1][1].position)
        begun, first = time.monotonic(), clock[-1][1].clock
        goal = goal_of([point(30.0, [p + 0.5 for p in start], [0.0] * 6), point(60.0, start, [0.0] * 6)])
        handle = peer.result(peer.ask(client.send_goal_async, goal), 30)
        assert handle.accepted
        result = peer.result(peer.ask(handle.get_result_async), 60, "the result")
        assert result.result.error_code == 0
        took = time.monotonic() - begun
        last = clock[-1][1].clock
        assert last.sec - first.sec >= 59
        print(f"60 s of simulated time in {took:.1f} s")
        assert took < 45
        peer.close()
    finally:
        assert controller.close() == 0, controller.log_text()
