"""A peer in a process of its own, to be stopped or killed. Says "ready" when it is connected.

child.py listen DOMAIN          takes joint states, reliably
child.py goal DOMAIN SECONDS    moves the first joint by 0.4 rad in so long, and says "accepted" when that has begun
child.py subscribe DOMAIN       subscribes to every topic of the node with every usual QoS, and says "well" when all
have spoken child.py network                loses its network for some seconds;
to be run in a network namespace of its own
"""

import importlib
import pathlib
import subprocess
import sys
import tempfile
import time

from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data, qos_profile_system_default
from sensor_msgs.msg import JointState

from conftest import JOINTS, Controller, Peer


def say(word):
    print(word, flush=True)


def listen(domain):
    peer = Peer(domain)
    states = peer.collect(JointState, "joint_states", 1000)
    peer.wait_for(lambda: len(states) > 10, 30, "joint states")
    say("ready")
    while True:
        time.sleep(1)
        states.clear()


def goal(domain, seconds):
    from test_trajectories import ACTION, goal_of, point

    peer = Peer(domain)
    states = peer.collect(JointState, "joint_states", 10)
    client = ActionClient(peer.node, FollowJointTrajectory, ACTION)
    assert client.wait_for_server(30)
    peer.wait_for(lambda: states, 30, "joint states")
    time.sleep(1)
    say("ready")
    positions = list(states[-1][1].position)
    assert list(states[-1][1].name) == JOINTS
    positions[0] += 0.4
    handle = peer.result(peer.ask(client.send_goal_async, goal_of([point(seconds, positions, [0.0] * 6)])), 30)
    assert handle.accepted
    say("accepted")
    peer.result(peer.ask(handle.get_result_async), seconds + 30)
    say("ended")


def class_of(kind):
    package, _, name = kind.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def subscribe(domain):
    peer = Peer(domain)
    own = lambda: {
        topic: kinds[0]
        for topic, kinds in peer.node.get_publisher_names_and_types_by_node("elite_controller", "/")
        # Who has nothing to say there is silent.
        if topic not in ("/rosout", "/parameter_events") and not topic.endswith("/_action/feedback")
    }
    peer.wait_for(lambda: ("elite_controller", "/") in peer.node.get_node_names_and_namespaces(), 30, "the node")
    peer.wait_for(lambda: len(own()) >= 13, 30, "the topics of the node")
    found, warnings = {}, []
    events = SubscriptionEventCallbacks(
        incompatible_qos=lambda event: warnings.append(f"QoS {event}"),
        incompatible_type=lambda event: warnings.append(f"type {event}"),
    )
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    streams = {
        "depth 10": QoSProfile(depth=10),
        "sensor data": qos_profile_sensor_data,
        "system default": qos_profile_system_default,
    }
    of_state = ("robot_mode", "safety_mode", "robot_task_running", "robot_description", "/tf_static", "/_action/status")
    for topic, kind in own().items():
        # What is published once, or on change, is for whoever asks for it.
        profiles = {"latched": latched} if topic.endswith(of_state) else streams
        for name, profile in profiles.items():
            heard = found.setdefault((topic, name), [])
            peer.node.create_subscription(class_of(kind), topic, heard.append, profile, event_callbacks=events)
    silent = lambda: [key for key, heard in found.items() if not heard and not key[0].endswith("/_action/status")]
    try:
        peer.wait_for(lambda: not silent(), 30)
    except AssertionError:
        sys.exit(f"nothing comes on {silent()}")
    assert not warnings, warnings
    peer.close()
    say("well")


def network():
    """Loopback is all the network that the node has: it is taken down and brought up again."""

    def loopback(state):
        subprocess.run(["ip", "link", "set", "lo", state], check=True)

    loopback("up")
    with tempfile.TemporaryDirectory() as folder:
        controller = Controller(pathlib.Path(folder), 7, "--plant", "ideal")
        try:
            peer = Peer(controller.domain)
            states = peer.collect(JointState, "joint_states", 1000)
            peer.wait_for(lambda: len(states) > 250, 30, "joint states")
            node = controller.node_pid()
            loopback("down")
            time.sleep(5)
            during = len(states)
            time.sleep(1)
            assert len(states) == during, "there is still a network"
            loopback("up")
            begun = time.monotonic()
            peer.wait_for(lambda: len(states) > during + 500, 20, "joint states after that")
            say(f"back after {time.monotonic() - begun:.1f} s")
            late = [at - m.header.stamp.sec - m.header.stamp.nanosec * 1e-9 for at, m in states]
            say(
                f"late {late[during - 300]:.3f} {late[during - 1]:.3f} s before, {late[during : during + 500 : 50]} "
                "s after"
            )
            # Cycles went on: nothing is later than before.
            peer.wait_for(lambda: time.time() - states[-1][1].header.stamp.sec < 2.0, 10, "the present")
            assert controller.node_pid() == node, "the node was not needed anew"
            assert controller.process.poll() is None
            peer.close()
        finally:
            status = controller.close()
        assert status == 0, controller.log_text()
    say("well")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["listen", domain]:
            listen(int(domain))
        case ["goal", domain, seconds]:
            goal(int(domain), float(seconds))
        case ["subscribe", domain]:
            subscribe(int(domain))
        case ["network"]:
            network()
        case other:
            sys.exit(f"{other}: see the head of this file")
