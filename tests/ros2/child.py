"""A peer in a process of its own, to be stopped or killed. Says "ready" when it is connected.

child.py listen DOMAIN          takes joint states, reliably
child.py goal DOMAIN SECONDS    moves the first joint by 0.4 rad in so long, and says "accepted" when that has begun
child.py network                loses its network for some seconds; to be run in a network namespace of its own
"""

import pathlib
import subprocess
import sys
import tempfile
import time

from conftest import JOINTS, Controller, Peer
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState


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
            say(f"late {late[during - 300]:.3f} {late[during - 1]:.3f} s before, {late[during:during + 500:50]} s after")
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
        case ["network"]:
            network()
        case other:
            sys.exit(f"{other}: see the head of this file")
