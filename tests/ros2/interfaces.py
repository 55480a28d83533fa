"""Writes the interface packages that PyPI does not have as wheels: control_msgs, tf2_msgs, and the vendor's
eli_common_interface. Only what the tests use, in the definitions of Humble and Jazzy.

Usage: interfaces.py FOLDER
"""

import pathlib
import sys

PACKAGES = {
    "tf2_msgs": (["geometry_msgs"], {"msg/TFMessage.msg": "geometry_msgs/TransformStamped[] transforms"}),
    "control_msgs": (
        ["std_msgs", "trajectory_msgs", "builtin_interfaces", "action_msgs"],
        {
            "msg/JointTolerance.msg": "string name\nfloat64 position\nfloat64 velocity\nfloat64 acceleration",
            "msg/JointComponentTolerance.msg": (
                "uint16 X_AXIS=1\nuint16 Y_AXIS=2\nuint16 Z_AXIS=3\nuint16 TRANSLATION=4\nuint16 ROTATION=5\n"
                "string joint_name\nuint16 component\nfloat64 position\nfloat64 velocity\nfloat64 acceleration"
            ),
            "action/FollowJointTrajectory.action": """trajectory_msgs/JointTrajectory trajectory
trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory
JointTolerance[] path_tolerance
JointComponentTolerance[] component_path_tolerance
JointTolerance[] goal_tolerance
JointComponentTolerance[] component_goal_tolerance
builtin_interfaces/Duration goal_time_tolerance
---
int32 error_code
int32 SUCCESSFUL = 0
int32 INVALID_GOAL = -1
int32 INVALID_JOINTS = -2
int32 OLD_HEADER_TIMESTAMP = -3
int32 PATH_TOLERANCE_VIOLATED = -4
int32 GOAL_TOLERANCE_VIOLATED = -5
string error_string
---
std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual
trajectory_msgs/JointTrajectoryPoint error
string[] multi_dof_joint_names
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error""",
        },
    ),
    "eli_common_interface": (
        ["geometry_msgs"],
        {
            "msg/RobotMode.msg": "int8 mode",
            "msg/SafetyMode.msg": "int8 mode",
            "msg/Analog.msg": "uint8 type\nfloat64 value",
            "msg/IOState.msg": "\n".join(
                [
                    f"bool[] {name}"
                    for name in ("standard_out", "config_out", "tool_out", "standard_in", "config_in", "tool_in")
                ]
                + ["Analog[] standard_analog_out", "Analog[] standard_analog_in"]
            ),
            "msg/ToolData.msg": (
                "uint8 mode\nfloat64 output_voltage\nfloat64 output_current\nfloat64 temperature\n"
                "uint8 analog_input_type\nfloat64 analog_input\nuint8 analog_output_type\nfloat64 analog_output"
            ),
            "srv/SetIO.srv": "int8 fun\nint8 pin\nint8 analog_type\nfloat64 state\n---\nbool success",
            "srv/SetSpeedSliderFraction.srv": "float64 speed_slider_fraction\n---\nbool success",
            "srv/SetPayload.srv": "float64 mass\ngeometry_msgs/Vector3 center_of_gravity\n---\nbool success",
        },
    ),
}


def write(folder: pathlib.Path) -> None:
    for name, (needs, files) in PACKAGES.items():
        package = folder / name
        for path, text in files.items():
            (package / path).parent.mkdir(parents=True, exist_ok=True)
            (package / path).write_text(text + "\n")
        depends = "".join(f"  <depend>{need}</depend>\n" for need in needs)
        (package / "package.xml").write_text(
            f'<?xml version="1.0"?>\n<package format="3">\n  <name>{name}</name>\n  <version>5.8.0</version>\n'
            f"  <description>interfaces for tests</description>\n"
            f'  <maintainer email="nobody@example.com">nobody</maintainer>\n  <license>Apache-2.0</license>\n'
            f"  <buildtool_depend>ament_cmake</buildtool_depend>\n"
            f"  <buildtool_depend>rosidl_default_generators</buildtool_depend>\n{depends}"
            f"  <member_of_group>rosidl_interface_packages</member_of_group>\n"
            f"  <export><build_type>ament_cmake</build_type></export>\n</package>\n"
        )
        finds = "".join(f"find_package({need} REQUIRED)\n" for need in needs)
        listed = "\n".join(f'  "{path}"' for path in files)
        (package / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.8)\nproject({name})\nfind_package(ament_cmake REQUIRED)\n"
            f"find_package(rosidl_default_generators REQUIRED)\n{finds}"
            f"rosidl_generate_interfaces(${{PROJECT_NAME}}\n{listed}\n  DEPENDENCIES {' '.join(needs)}\n)\n"
            f"ament_package()\n"
        )


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1]))
