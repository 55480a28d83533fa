"""Goals of FollowJointTrajectory: followed, refused, canceled, replaced, held, stopped."""

import math
import time

import pytest
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance
from eli_common_interface.msg import RobotMode
from eli_common_interface.srv import SetSpeedSliderFraction
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from conftest import JOINTS, LATCHED

ACTION = "scaled_joint_trajectory_controller/follow_joint_trajectory"
TOPIC = "scaled_joint_trajectory_controller/joint_trajectory"


def span(seconds):
    return Duration(sec=int(seconds), nanosec=round(seconds % 1 * 1e9))


def point(seconds, positions, velocities=(), accelerations=()):
    return JointTrajectoryPoint(
        positions=list(positions),
        velocities=list(velocities),
        accelerations=list(accelerations),
        time_from_start=span(seconds),
    )


def goal_of(points, names=JOINTS):
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = list(names)
    goal.trajectory.points = points
    return goal


def stamp_of(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


class Arm:
    """What tests do with the arm."""

    def __init__(self, peer):
        self.peer = peer
        self.states = peer.collect(JointState, "joint_states", 500)
        self.client = ActionClient(peer.node, FollowJointTrajectory, ACTION)
        assert self.client.wait_for_server(20)
        peer.wait_for(lambda: self.states, what="joint states")
        time.sleep(1.0)

    def now(self):
        """Where the joints are. On a busy machine states queue up here: one that has been sent by now is waited for."""
        asked, best = time.time(), min(at - stamp_of(message) for at, message in self.states[-500:])
        is_simulated = stamp_of(self.states[-1][1]) < 1e9

        def is_fresh():
            at, message = self.states[-1]
            return at > asked and (is_simulated or at - stamp_of(message) < best + 0.1)

        self.peer.wait_for(is_fresh, 60, "a state of now")
        return list(self.states[-1][1].position)

    def send(self, goal, **options):
        return self.peer.result(self.peer.ask(self.client.send_goal_async, goal, **options), 30, "the answer to a goal")

    def result(self, handle, seconds=60):
        return self.peer.result(self.peer.ask(handle.get_result_async), seconds, "the result of a goal")

    def go(self, goal, seconds=60):
        handle = self.send(goal)
        assert handle.accepted
        return self.result(handle, seconds)


@pytest.fixture(scope="module")
def arm(peer):
    return Arm(peer)


def along(points, t):
    """Positions that points with speeds ask for: cubics."""
    for (t0, p0, v0), (t1, p1, v1) in zip(points, points[1:]):
        if t <= t1:
            h = t1 - t0
            s = (t - t0) / h
            return [
                (1 + 2 * s) * (1 - s) ** 2 * a
                + s * (1 - s) ** 2 * h * va
                + s * s * (3 - 2 * s) * b
                + s * s * (s - 1) * h * vb
                for a, b, va, vb in zip(p0, p1, v0, v1)
            ]
    return points[-1][1]


def test_a_goal_with_speeds_is_followed_to_a_thousandth(arm):
    start = arm.now()
    by = [0.4, -0.2, 0.3, 0.1, -0.3, 0.5]
    middle = [a + b for a, b in zip(start, by)]
    zero, speed = [0.0] * 6, [0.3 * b for b in by]
    end = [a + 1.5 * b for a, b in zip(start, by)]
    points = [(0.0, start, zero), (2.0, middle, speed), (4.0, end, zero)]
    feedback = []
    before = len(arm.states)
    handle = arm.send(
        goal_of([point(2.0, middle, speed), point(4.0, end, zero)]),
        feedback_callback=lambda message: feedback.append(message.feedback),
    )
    result = arm.result(handle)
    assert result.status == GoalStatus.STATUS_SUCCEEDED
    assert result.result.error_code == FollowJointTrajectory.Result.SUCCESSFUL
    arm.now()
    states = [m for _, m in arm.states[before:]]
    stamps = [stamp_of(m) for m in states]
    begun = next(i for i, m in enumerate(states) if max(map(abs, m.velocity)) > 1e-2)
    # When the trajectory began: the first joint only goes forward, so its place tells the time.
    low, high = 0.0, 4.0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if along(points, middle)[0] < states[begun].position[0] else (low, middle)
    best = math.inf
    for shift in range(-6, 7):
        first = stamps[begun] - low + shift * 0.001
        compared = [(t - first, m) for t, m in zip(stamps[begun:], states[begun:]) if 0 <= t - first <= 4.0]
        worst = max(max(abs(a - b) for a, b in zip(m.position, along(points, t))) for t, m in compared)
        best = min(best, worst)
    assert len(compared) > 500, "too many states are lost on the way here"
    assert best < 1e-3, best
    assert max(abs(a - b) for a, b in zip(arm.now(), end)) < 1e-3
    assert len(feedback) > 40
    assert feedback[0].joint_names == JOINTS and len(feedback[0].error.positions) == 6


def test_joints_in_another_order_and_positions_alone(arm):
    start = arm.now()
    end = [p - 0.2 for p in start]
    names = JOINTS[::-1]
    result = arm.go(goal_of([point(1.0, [p - 0.1 for p in start][::-1]), point(2.0, end[::-1])], names))
    assert result.status == GoalStatus.STATUS_SUCCEEDED
    assert max(abs(a - b) for a, b in zip(arm.now(), end)) < 1e-3


@pytest.mark.parametrize(
    "change, code, said",
    [
        (lambda g: g.trajectory.joint_names.__setitem__(2, "elbow"), -2, "elbow_joint"),
        (lambda g: g.trajectory.points.clear(), -1, "no point"),
        (lambda g: g.trajectory.points[0].positions.__setitem__(0, math.nan), -1, "NaN"),
        (lambda g: setattr(g.trajectory.points[1], "time_from_start", span(1.0)), -1, "not after"),
        (lambda g: g.trajectory.points[0].positions.__setitem__(0, 100.0), -1, "beyond its limit"),
        (lambda g: setattr(g.trajectory.points[0], "time_from_start", span(0.001)), -1, "speed"),
        (lambda g: setattr(g.trajectory, "points", [g.trajectory.points[0]] * 100_000), -1, "100000 points"),
        (lambda g: g.trajectory.joint_names.clear(), -2, "joint"),
        (lambda g: (g.trajectory.joint_names.clear(), g.trajectory.points.clear()), -2, "joint"),
        (lambda g: g.trajectory.joint_names.__setitem__(1, JOINTS[0]), -2, JOINTS[0]),
        (lambda g: g.trajectory.joint_names.append("finger_joint"), -2, "finger_joint"),
        (lambda g: g.trajectory.points[1].positions.pop(), -1, "5"),
        (lambda g: setattr(g.trajectory.points[0], "velocities", [math.inf] * 6), -1, "inf"),
        (lambda g: setattr(g.trajectory.points[0], "velocities", [0.0] * 5), -1, "5"),
        (lambda g: setattr(g.trajectory.points[1], "time_from_start", span(0.5)), -1, "not after"),
        (lambda g: setattr(g.trajectory.points[0], "time_from_start", Duration(sec=-1)), -1, ""),
        (lambda g: g.path_tolerance.append(JointTolerance(name="finger_joint", position=0.1)), -1, "finger_joint"),
    ],
)
def test_wrong_goals_end_with_their_code_and_a_text(arm, change, code, said):
    before = arm.now()
    goal = goal_of([point(1.0, [p + 0.1 for p in before]), point(2.0, before)])
    change(goal)
    result = arm.go(goal)
    assert result.status == GoalStatus.STATUS_ABORTED
    assert result.result.error_code == code
    assert said in result.result.error_string
    assert arm.now() == before


def test_a_canceled_goal_brakes_on_its_way(arm):
    start = arm.now()
    end = [p + 0.6 for p in start]
    handle = arm.send(goal_of([point(4.0, end, [0.0] * 6)]))
    time.sleep(1.5)
    answer = arm.peer.result(arm.peer.ask(handle.cancel_goal_async))
    assert answer.return_code == CancelGoal.Response.ERROR_NONE and len(answer.goals_canceling) == 1
    result = arm.result(handle)
    assert result.status == GoalStatus.STATUS_CANCELED
    here = arm.now()
    by = [b - a for a, b in zip(start, here)]
    assert 0.01 < by[0] < 0.55 and max(by) - min(by) < 1e-3
    again = arm.peer.result(arm.peer.ask(handle.cancel_goal_async))
    assert again.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED


def test_a_new_goal_replaces_the_old_one_without_a_jump(arm):
    start = arm.now()
    first = arm.send(goal_of([point(8.0, [p - 1.2 for p in start], [0.0] * 6)]))
    time.sleep(2.0)
    before = len(arm.states)
    second = arm.send(goal_of([point(4.0, start, [0.0] * 6)]))
    assert arm.result(first).status in (GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)
    assert arm.result(second).status == GoalStatus.STATUS_SUCCEEDED
    states = [m for _, m in arm.states[before - 5 :]]
    for a, b in zip(states, states[1:]):
        step = stamp_of(b) - stamp_of(a)
        for j in range(6):
            assert abs(b.velocity[j] - a.velocity[j]) < 25.0 * step + 1e-6
    assert max(abs(a - b) for a, b in zip(arm.now(), start)) < 1e-3


def test_the_slider_stretches_time_and_a_pause_holds(arm):
    peer, start = arm.peer, arm.now()
    slider = lambda x: (
        peer.call(
            SetSpeedSliderFraction,
            "io_and_status_controller/set_speed_slider",
            SetSpeedSliderFraction.Request(speed_slider_fraction=x),
        ).success
    )
    assert slider(0.5)
    before = len(arm.states)
    result = arm.go(goal_of([point(1.5, [p + 0.2 for p in start], [0.0] * 6)]))
    assert result.status == GoalStatus.STATUS_SUCCEEDED
    arm.now()
    # Without the slider the cubic has 0.2 rad/s in its middle. States may be missing, their times and speeds are right.
    moving = [stamp_of(m) for _, m in arm.states[before:] if max(map(abs, m.velocity)) > 1e-6]
    fastest = max(max(map(abs, m.velocity)) for _, m in arm.states[before:])
    assert moving[-1] - moving[0] < 3.2 and 0.08 < fastest < 0.101
    assert slider(1.0)
    handle = arm.send(goal_of([point(6.0, start, [0.0] * 6)]))
    assert peer.call(Trigger, "dashboard_client/pause").success
    peer.wait_for(lambda: arm.now() and max(map(abs, arm.states[-1][1].velocity)) == 0.0, what="rest")
    held = arm.now()
    time.sleep(0.5)
    assert arm.now() == held and max(abs(a - b) for a, b in zip(held, start)) > 0.01
    assert peer.call(Trigger, "dashboard_client/play").success
    assert arm.result(handle).status == GoalStatus.STATUS_SUCCEEDED


def test_a_goal_is_rejected_where_the_arm_cannot_move(arm):
    peer, start = arm.peer, arm.now()
    modes = peer.collect(RobotMode, "io_and_status_controller/robot_mode", LATCHED)
    mode = lambda: modes[-1][1].mode if modes else None
    assert peer.call(Trigger, "dashboard_client/power_off").success
    peer.wait_for(lambda: mode() == 3, what="power off")
    handle = arm.send(goal_of([point(1.0, start)]))
    assert not handle.accepted
    assert peer.call(Trigger, "dashboard_client/brake_release").success
    peer.wait_for(lambda: mode() == 7, what="running")


def test_a_trajectory_of_the_topic_is_followed(arm):
    start = arm.now()
    publisher = arm.peer.node.create_publisher(JointTrajectory, TOPIC, 1)
    arm.peer.wait_for(lambda: publisher.get_subscription_count() > 0, what="the subscription")
    time.sleep(1.0)
    message = JointTrajectory(joint_names=JOINTS, points=[point(1.0, [p + 0.1 for p in start], [0.0] * 6)])
    publisher.publish(message)
    arm.peer.wait_for(
        lambda: max(abs(a - b - 0.1) for a, b in zip(arm.now(), start)) < 1e-3, what="the end of the trajectory"
    )


def test_tolerances_of_a_goal_count(arm):
    start = arm.now()
    goal = goal_of([point(1.0, [p - 0.1 for p in start], [0.0] * 6)])
    goal.goal_tolerance = [JointTolerance(name="elbow_joint", position=math.inf)]
    result = arm.go(goal)
    assert result.status == GoalStatus.STATUS_ABORTED and "tolerance" in result.result.error_string
