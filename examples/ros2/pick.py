"""Takes a box from the stop of a belt and puts it onto a pallet, through ROS 2 alone.

The controller with the cell of examples/cells/palletising, in another terminal:

    eliteserver serve --ros2 --cell examples/cells/palletising/cell.toml --tcp 0,0,0.10,0,0,0

Needs rclpy, control_msgs, and eli_common_interface of the vendor's driver.
With the driver and a real cell it is the same program.
"""

import sys
import time

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from eli_common_interface.msg import IOState
from eli_common_interface.srv import SetIO, SetPayload
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
]
# Outputs and inputs of the cell.
VACUUM, BELT, BLOW_OFF = 0, 1, 2
PART_HELD, BOX_AT_STOP = 0, 1
# Where the joints are, rad: get_inverse_kin() of the poses in examples/cells/palletising/palletise.script.
OVER_STOP = [0.21848, -1.47912, 1.88926, -1.98094, -1.57080, 1.78927]
NEAR_BOX = [0.21848, -1.38205, 2.00527, -2.19402, -1.57080, 1.78927]
ON_BOX = [0.21848, -1.37902, 2.00779, -2.19956, -1.57080, 1.78927]
BETWEEN = [-0.10703, -1.66068, 1.90848, -1.81859, -1.57080, 1.46376]
OVER_PALLET = [-0.47072, -1.19941, 1.53171, -1.90310, -1.57080, 1.10008]
ON_PALLET = [-0.47072, -1.12189, 1.64237, -2.09128, -1.57080, 1.10008]
# The call for all digital outputs of SetIO.
DIGITAL_OUT = 1


class Cell(Node):
    """The arm, its cups, and the belt."""

    def __init__(self):
        super().__init__("pick")
        self.io = None
        self.create_subscription(IOState, "io_and_status_controller/io_states", self._keep_io, 1)
        self.arm = ActionClient(
            self, FollowJointTrajectory, "scaled_joint_trajectory_controller/follow_joint_trajectory"
        )
        self.outputs = self.create_client(SetIO, "io_and_status_controller/set_io")
        self.payload = self.create_client(SetPayload, "io_and_status_controller/set_payload")

    def _keep_io(self, message):
        self.io = message

    def connect(self):
        for client in (self.outputs, self.payload):
            if not client.wait_for_service(20):
                raise TimeoutError(f"there is no service {client.srv_name}: is the controller running with --ros2?")
        if not self.arm.wait_for_server(20):
            raise TimeoutError("there is no action to move the arm with")
        # What is asked before both sides know each other is lost.
        time.sleep(1)
        self.wait_until(lambda: self.io, 20, "no state of inputs and outputs")

    def wait_until(self, condition, seconds, what):
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"{what} within {seconds} s")
            rclpy.spin_once(self, timeout_sec=0.1)

    def answer(self, future, what):
        self.wait_until(future.done, 60, f"no answer to {what}")
        return future.result()

    def set_output(self, number, level):
        request = SetIO.Request(fun=DIGITAL_OUT, pin=number, state=float(level))
        if not self.answer(self.outputs.call_async(request), "set_io").success:
            raise RuntimeError(f"output {number} cannot be set")

    def set_mass(self, kg, height=0.0):
        request = SetPayload.Request(mass=kg)
        request.center_of_gravity.z = height
        if not self.answer(self.payload.call_async(request), "set_payload").success:
            raise RuntimeError(f"a payload of {kg} kg is refused")

    def wait_for_input(self, number, level, seconds, what):
        self.wait_until(lambda: self.io.standard_in[number] == level, seconds, what)

    def move(self, *points):
        """Through the points, each given as joint positions and the seconds to get there; rest at each."""
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        at = 0.0
        for positions, seconds in points:
            at += seconds
            goal.trajectory.points.append(
                JointTrajectoryPoint(
                    positions=positions,
                    velocities=[0.0] * 6,
                    time_from_start=Duration(sec=int(at), nanosec=round(at % 1 * 1e9)),
                )
            )
        handle = self.answer(self.arm.send_goal_async(goal), "a goal")
        if not handle.accepted:
            raise RuntimeError("the arm takes no goal now; /rosout says why")
        result = self.answer(handle.get_result_async(), "a goal that was accepted").result
        if result.error_code != FollowJointTrajectory.Result.SUCCESSFUL:
            raise RuntimeError(result.error_string)


def pick_and_place(cell):
    cell.set_output(BELT, True)
    cell.move((BETWEEN, 3.0), (OVER_STOP, 1.5))
    cell.wait_for_input(BOX_AT_STOP, True, 30, "no box came")
    cell.move((NEAR_BOX, 0.8))
    cell.set_output(VACUUM, True)
    cell.move((ON_BOX, 0.4))
    cell.wait_for_input(PART_HELD, True, 2, "the vacuum did not build up")
    cell.set_mass(0.25, height=0.13)
    cell.set_output(BELT, False)
    cell.move((OVER_STOP, 0.8), (BETWEEN, 1.5), (OVER_PALLET, 2.0), (ON_PALLET, 1.0))
    cell.set_output(VACUUM, False)
    cell.set_output(BLOW_OFF, True)
    cell.wait_for_input(PART_HELD, False, 2, "the cups do not let go")
    cell.set_output(BLOW_OFF, False)
    cell.set_mass(0.0)
    cell.move((OVER_PALLET, 1.0))


def main():
    rclpy.init()
    cell = Cell()
    try:
        cell.connect()
        pick_and_place(cell)
        print("a box stands on the pallet")
    except (TimeoutError, RuntimeError) as error:
        sys.exit(f"pick: {error}")
    finally:
        cell.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
