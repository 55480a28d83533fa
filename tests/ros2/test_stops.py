"""Goals that something stops: a hand at the arm, people in the cell, the emergency stop, power, orders of the
dashboard."""

import time

import pytest
from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory
from eli_common_interface.msg import RobotMode, SafetyMode
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from conftest import DOMAINS, LATCHED, Controller
from test_trajectories import Arm, goal_of, point

CELL = """
[limits]
tcp_force = 100
[[safety_input]]
function = "safeguard_stop"
pair = 1
active = "high"
"""
VIOLATED = FollowJointTrajectory.Result.PATH_TOLERANCE_VIOLATED
NORMAL, PROTECTIVE, SAFEGUARD, EMERGENCY = 1, 3, 5, 7
POWER_OFF, IDLE, RUNNING = 3, 5, 7


@pytest.fixture(scope="module")
def controller(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stops")
    (folder / "cell.toml").write_text(CELL)
    controller = Controller(folder, next(DOMAINS), "--plant", "ideal", "--cell", "cell.toml")
    yield controller
    status = controller.close()
    assert status == 0, controller.log_text()


class Cell:
    """The arm with the modes of its controller."""

    def __init__(self, controller, peer):
        self.controller, self.peer, self.arm = controller, peer, Arm(peer)
        self.robot_modes = peer.collect(RobotMode, "io_and_status_controller/robot_mode", LATCHED)
        self.safety_modes = peer.collect(SafetyMode, "io_and_status_controller/safety_mode", LATCHED)

    def wait_for_modes(self, robot, safety):
        both = lambda: (self.robot_modes or [(0, None)])[-1][1], lambda: (self.safety_modes or [(0, None)])[-1][1]
        self.peer.wait_for(
            lambda: [m and m.mode for m in (both[0](), both[1]())] == [robot, safety], 30, f"modes {robot}, {safety}"
        )

    def trigger(self, name):
        return self.peer.call(Trigger, f"dashboard_client/{name}")

    def is_moving(self):
        return max(map(abs, self.arm.states[-1][1].velocity)) > 1e-6

    def goal_under_way(self, by=0.6, seconds=6.0):
        """A goal that the arm is in the middle of, and where it leads to."""
        self.wait_for_modes(RUNNING, NORMAL)
        end = [p + by for p in self.arm.now()]
        handle = self.arm.send(goal_of([point(seconds, end, [0.0] * 6)]))
        assert handle.accepted
        self.peer.wait_for(lambda: max(map(abs, self.arm.states[-1][1].velocity)) > 0.05, what="motion")
        return handle, end

    def assert_aborted(self, handle, code, said):
        result = self.arm.result(handle)
        assert result.status == GoalStatus.STATUS_ABORTED
        assert result.result.error_code == code and said in result.result.error_string, result.result
        self.peer.wait_for(lambda: self.arm.now() and not self.is_moving(), what="rest")

    def assert_rejected(self):
        here = self.arm.now()
        assert not self.arm.send(goal_of([point(1.0, [p + 0.1 for p in here])])).accepted
        assert self.arm.now() == here

    def assert_usable(self):
        """The next goal is reached: nothing of the stop is left."""
        self.wait_for_modes(RUNNING, NORMAL)
        end = [p - 0.1 for p in self.arm.now()]
        result = self.arm.go(goal_of([point(1.0, end, [0.0] * 6)]))
        assert result.status == GoalStatus.STATUS_SUCCEEDED, result.result.error_string
        assert max(abs(a - b) for a, b in zip(self.arm.now(), end)) < 1e-3


@pytest.fixture(scope="module")
def cell(controller, peer):
    return Cell(controller, peer)


def test_a_protective_stop_aborts_the_goal_until_it_is_unlocked(cell):
    handle, end = cell.goal_under_way()
    cell.controller.order("push", wrench=[0, 0, 400, 0, 0, 0], duration=0.5)
    cell.assert_aborted(handle, VIOLATED, "protective stop")
    assert max(abs(a - b) for a, b in zip(cell.arm.now(), end)) > 0.05
    cell.wait_for_modes(RUNNING, PROTECTIVE)
    cell.assert_rejected()
    # Whether it may be unlocked yet is the dashboard's to say.
    cell.peer.wait_for(lambda: cell.trigger("unlock_protective_stop").success, 30, "unlocking")
    cell.assert_usable()


def test_a_safeguard_stop_aborts_the_goal_and_ends_with_its_input(cell):
    handle, end = cell.goal_under_way()
    cell.controller.http("/api/inputs", {"configurable_digital_in[2]": True, "configurable_digital_in[3]": True})
    cell.assert_aborted(handle, VIOLATED, "safeguard stop")
    assert max(abs(a - b) for a, b in zip(cell.arm.now(), end)) > 0.05
    cell.wait_for_modes(RUNNING, SAFEGUARD)
    cell.assert_rejected()
    cell.controller.http("/api/inputs", {"configurable_digital_in[2]": False, "configurable_digital_in[3]": False})
    cell.wait_for_modes(RUNNING, NORMAL)
    # The goal has ended: nothing goes on by itself.
    here = cell.arm.now()
    time.sleep(0.5)
    assert cell.arm.now() == here
    cell.assert_usable()


def test_an_emergency_stop_aborts_the_goal(cell):
    handle, _ = cell.goal_under_way()
    cell.controller.order("emergency_stop", pressed=True)
    cell.assert_aborted(handle, VIOLATED, "emergency stop")
    cell.assert_rejected()
    # The dashboard's answer says that the order has come, not that there is power.
    assert [cell.trigger("power_on").message] == cell.controller.dashboard("robotControl -on")
    cell.wait_for_modes(POWER_OFF, EMERGENCY)
    cell.controller.order("emergency_stop", pressed=False)
    cell.wait_for_modes(POWER_OFF, NORMAL)
    assert cell.trigger("brake_release").success
    cell.assert_usable()


def test_power_that_goes_off_aborts_the_goal(cell):
    handle, _ = cell.goal_under_way()
    assert cell.trigger("power_off").success
    cell.assert_aborted(handle, VIOLATED, "robot mode")
    cell.wait_for_modes(POWER_OFF, NORMAL)
    cell.assert_rejected()
    assert cell.trigger("brake_release").success
    cell.assert_usable()


def test_a_goal_that_is_canceled_while_it_is_held_leaves_no_pause_behind(cell):
    for do in ("cancel", "stop"):
        handle, _ = cell.goal_under_way(-0.6 if do == "stop" else 0.6)
        assert cell.trigger("pause").success
        cell.peer.wait_for(lambda: cell.arm.now() and not cell.is_moving(), what="rest")
        if do == "cancel":
            cell.peer.result(cell.peer.ask(handle.cancel_goal_async))
            assert cell.arm.result(handle).status == GoalStatus.STATUS_CANCELED
        else:
            assert cell.trigger("stop").success
            cell.assert_aborted(handle, FollowJointTrajectory.Result.INVALID_GOAL, "dashboard_client/stop")
        cell.assert_usable()


def test_a_goal_that_replaces_a_held_one_moves_the_arm(cell):
    handle, _ = cell.goal_under_way()
    assert cell.trigger("pause").success
    cell.peer.wait_for(lambda: cell.arm.now() and not cell.is_moving(), what="rest")
    second = cell.arm.send(goal_of([point(2.0, [p - 0.2 for p in cell.arm.now()], [0.0] * 6)]))
    assert second.accepted
    assert cell.arm.result(handle).status == GoalStatus.STATUS_CANCELED
    # Whoever has paused decides when the arm moves again.
    time.sleep(0.5)
    assert not cell.is_moving()
    assert cell.trigger("play").success
    assert cell.arm.result(second).status == GoalStatus.STATUS_SUCCEEDED
    cell.assert_usable()


def test_goals_and_programs_keep_each_other_off_the_arm(cell):
    running = cell.peer.collect(Bool, "io_and_status_controller/robot_task_running", LATCHED)
    cell.wait_for_modes(RUNNING, NORMAL)
    q = list(cell.arm.now())
    there = [q[0] + 0.8, *q[1:]]
    text = f"def move():\n  movej({there}, a=1, v=0.2)\nend\n"
    cell.controller.order("run", name="move.script", text=text)
    cell.peer.wait_for(lambda: cell.is_moving() and running[-1][1].data, what="the motion of the program")
    assert not cell.arm.send(goal_of([point(1.0, q)])).accepted
    cell.peer.wait_for(lambda: not running[-1][1].data, 30, "the end of the program")
    assert max(abs(a - b) for a, b in zip(cell.arm.now(), there)) < 1e-3, "the goal has disturbed the program"
    # The other way round the program is refused its motion, and the goal goes on.
    handle, end = cell.goal_under_way(-0.6, 8.0)
    count = len(running)
    for program in (text, "def light():\n  set_standard_digital_out(2, True)\n  sleep(0.2)\nend\n"):
        cell.controller.order("run", name="move.script", text=program)
        cell.peer.wait_for(lambda: any(m.data for _, m in running[count:]) and not running[-1][1].data, what="its end")
        count = len(running)
        assert cell.is_moving()
    assert cell.arm.result(handle).status == GoalStatus.STATUS_SUCCEEDED
    assert max(abs(a - b) for a, b in zip(cell.arm.now(), end)) < 1e-3


@pytest.mark.parametrize("state", ["running", "power off"])
def test_what_cannot_be_done_is_answered_with_the_words_of_the_dashboard(cell, state):
    if state == "power off":
        assert cell.trigger("power_off").success
        cell.wait_for_modes(POWER_OFF, NORMAL)
    for service, line in [
        ("play", "play"),
        ("pause", "pause"),
        ("stop", "stop"),
        ("unlock_protective_stop", "unlockProtectiveStop"),
        ("close_safety_dialog", "closeSafetyDialog"),
        ("get_task_path", "task"),
        ("restart_safety", "safety -r"),
    ]:
        said = cell.trigger(service)
        assert [said.message] == cell.controller.dashboard(line), service
        if service == "play":
            assert not said.success
    if state == "power off":
        assert cell.trigger("brake_release").success
        cell.wait_for_modes(RUNNING, NORMAL)
