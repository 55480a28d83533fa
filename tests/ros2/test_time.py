"""Simulated time."""

import csv
import io
import os
import subprocess
import time

from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from conftest import DOMAINS, Controller, Peer
from measure import processor_seconds
from test_trajectories import ACTION, goal_of, point


def drive_a_minute(folder):
    """Drives a trajectory of a minute; seconds of this machine and of its processors (controller and node), and what
    the controller has recorded of the motion."""
    folder.mkdir()
    controller = Controller(
        folder, next(DOMAINS), "--clock", "virtual", "--plant", "ideal", "--ros-rate", "25", record="x.mcap"
    )
    try:
        peer = Peer(controller.domain, parameter_overrides=[Parameter("use_sim_time", value=True)])
        clock = peer.collect(Clock, "/clock", 100)
        states = peer.collect(JointState, "joint_states", 100)
        client = ActionClient(peer.node, FollowJointTrajectory, ACTION)
        assert client.wait_for_server(30)
        peer.wait_for(lambda: clock and states, 20, "time")
        time.sleep(1.0)
        start = list(states[-1][1].position)
        ticks = []
        peer.node.create_timer(1.0, lambda: ticks.append(peer.node.get_clock().now().nanoseconds))
        pids = controller.process.pid, controller.node_pid()
        spent = lambda: sum(map(processor_seconds, pids))
        goal = goal_of([point(30.0, [p + 0.5 for p in start], [0.0] * 6), point(60.0, start, [0.0] * 6)])
        begun, before, first = time.monotonic(), spent(), clock[-1][1].clock
        handle = peer.result(peer.ask(client.send_goal_async, goal), 60)
        assert handle.accepted
        result = peer.result(peer.ask(handle.get_result_async), 120, "the result")
        took, processor = time.monotonic() - begun, spent() - before
        assert result.result.error_code == 0
        assert clock[-1][1].clock.sec - first.sec >= 59
        # A timer of the node follows the same clock; one that is busy leaves some of its turns out.
        assert ticks and all(second >= first.sec for second in (tick * 1e-9 for tick in ticks))
        peer.close()
    finally:
        assert controller.close() == 0, controller.log_text()
    table = subprocess.run(
        [os.environ["ELITESERVER"], "replay", "x.mcap", "--csv", "/cycle"],
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    rows = [[float(row[f"target_q_{k}"]) for k in range(6)] for row in csv.DictReader(io.StringIO(table))]
    moves = [k for k, (a, b) in enumerate(zip(rows, rows[1:])) if a != b]
    return took, processor, rows[moves[0] : moves[-1] + 2]


def test_a_minute_of_simulated_time_takes_a_tenth_of_it_and_is_the_same_twice(tmp_path):
    runs = [drive_a_minute(tmp_path / name) for name in ("first", "second")]
    for took, processor, rows in runs:
        print(f"60 s of simulated time in {took:.1f} s; {processor:.1f} s of the processor, {len(rows)} cycles")
        # By the clock only on a machine that does nothing else.
        assert processor < 6.0
        assert abs(len(rows) - 15_000) < 50
    (_, _, one), (_, _, other) = runs
    assert len(one) == len(other)
    assert max(abs(a - b) for x, y in zip(one, other) for a, b in zip(x, y)) < 1e-9
