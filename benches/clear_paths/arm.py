"""The arm and random cells for comparisons: read from the URDF and made with seeds, without the product's help."""

import json
import math
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
LINKS = ["base", "shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"]
#: Links of the URDF in that order.
URDF_LINKS = [
    "base_link_inertia",
    "shoulder_link",
    "upperarm_link",
    "forearm_link",
    "wrist_1_link",
    "wrist_2_link",
    "wrist_3_link",
]
#: Pairs of links that are neighbours, or cannot meet (robots/README.md).
SKIPPED = {(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (4, 6), (0, 2)}


def rotation(rpy):
    roll, pitch, yaw = rpy
    cr, sr, cp, sp, cy, sy = (f(x) for x in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def transform(xyz, rpy):
    matrix = np.eye(4)
    matrix[:3, :3] = rotation(rpy)
    matrix[:3, 3] = xyz
    return matrix


def _numbers(text):
    return [float(word) for word in text.split()]


class Arm:
    """Capsules and joints of a model."""

    def __init__(self, model="cs66"):
        root = xml.parse(ROOT / "robots" / model / f"{model}.urdf").getroot()
        self.capsules = []
        for name in URDF_LINKS:
            capsules = []
            for collision in root.find(f"link[@name='{name}']").findall("collision"):
                cylinder, sphere = (collision.find(f"geometry/{kind}") for kind in ("cylinder", "sphere"))
                origin = collision.find("origin")
                place = transform(_numbers(origin.get("xyz")), _numbers(origin.get("rpy")))
                if cylinder is not None:
                    capsules.append((place, float(cylinder.get("radius")), float(cylinder.get("length"))))
                elif sphere is not None:
                    inside = any(
                        np.linalg.norm(_nearest(where, length, place[:3, 3]) - place[:3, 3])
                        + float(sphere.get("radius"))
                        <= radius + 1e-5
                        for where, radius, length in capsules
                    )
                    if not inside:
                        capsules.append((place, float(sphere.get("radius")), 0.0))
            self.capsules.append(capsules)
        self.joints = []
        for joint in root.findall("joint"):
            if joint.get("type") == "revolute":
                origin, limit = joint.find("origin"), joint.find("limit")
                self.joints.append(
                    (
                        transform(_numbers(origin.get("xyz")), _numbers(origin.get("rpy"))),
                        float(limit.get("lower")),
                        float(limit.get("upper")),
                    )
                )

    def frames(self, q):
        """The frames of the seven links in the base frame; the last is the flange."""
        frames = [np.eye(4)]
        for (origin, _, _), angle in zip(self.joints, q):
            turn = transform([0, 0, 0], [0, 0, angle])
            frames.append(frames[-1] @ origin @ turn)
        return frames

    def limits(self):
        return np.array([low for _, low, _ in self.joints]), np.array([high for _, _, high in self.joints])


def _nearest(place, length, point):
    local = np.linalg.inv(place) @ np.append(point, 1.0)
    along = min(max(local[2], -length / 2), length / 2)
    return (place @ np.array([0, 0, along, 1.0]))[:3]


def scene(kind, rng):
    """Obstacles of a cell of this kind: (name, shape, size, pose)."""
    boxes = []

    def box(name, size, xyz, yaw=0.0):
        boxes.append((name, "box", [float(x) for x in size], [*(float(x) for x in xyz), 0.0, 0.0, float(yaw)]))

    box("table", [2.4, 2.4, 0.1], [0, 0, -0.061])
    side = rng.uniform(-0.6, 0.6)
    far = rng.uniform(0.5, 0.62)
    if kind == "shelf":
        c, s = math.cos(side), math.sin(side)
        for k, height in enumerate([0.25, 0.25 + rng.uniform(0.3, 0.4)]):
            box(f"board {k}", [0.35, 0.7, 0.02], [far * c + 0.1 * c, far * s + 0.1 * s, height], side)
        for k, across in enumerate([-0.36, 0.36]):
            box(
                f"side {k}",
                [0.35, 0.02, 0.8],
                [far * c + 0.1 * c - across * s, far * s + 0.1 * s + across * c, 0.4],
                side,
            )
    elif kind == "bin":
        c, s = math.cos(side), math.sin(side)
        wide, deep, high = rng.uniform(0.35, 0.45), rng.uniform(0.3, 0.4), rng.uniform(0.2, 0.3)
        for k, (x, y, sx, sy) in enumerate(
            [
                (deep / 2, 0, 0.02, wide),
                (-deep / 2, 0, 0.02, wide),
                (0, wide / 2, deep, 0.02),
                (0, -wide / 2, deep, 0.02),
            ]
        ):
            box(f"wall {k}", [sx, sy, high], [far * c + x * c - y * s, far * s + x * s + y * c, high / 2], side)
    elif kind == "posts":
        for k in range(rng.integers(2, 5)):
            angle, away = rng.uniform(-2.5, 2.5), rng.uniform(0.4, 0.65)
            boxes.append(
                (
                    f"post {k}",
                    "cylinder",
                    [float(rng.uniform(0.02, 0.05)), 1.2],
                    [float(away * math.cos(angle)), float(away * math.sin(angle)), 0.6, 0.0, 0.0, 0.0],
                )
            )
    else:
        # A machine with an opening in its front.
        wide, low, high = rng.uniform(0.4, 0.55), rng.uniform(0.15, 0.25), rng.uniform(0.65, 0.8)
        x = far - 0.08
        box("left", [0.05, 0.6, 1.2], [x, side * 0.2 + wide / 2 + 0.3, 0.6])
        box("right", [0.05, 0.6, 1.2], [x, side * 0.2 - wide / 2 - 0.3, 0.6])
        box("sill", [0.05, wide, low], [x, side * 0.2, low / 2])
        box("lintel", [0.05, wide, 1.2 - high], [x, side * 0.2, (1.2 + high) / 2])
    return boxes


KINDS = ["shelf", "bin", "posts", "door"]

#: The tool of all cells: a gripper of 120 mm.
TOOL = ("cylinder", [0.035, 0.12], [0, 0, 0.06, 0, 0, 0])


def cell_text(boxes):
    """The cell file of obstacles and the tool."""
    text = f'[tool]\nshape = "{TOOL[0]}"\nsize = {json.dumps(TOOL[1])}\npose = {json.dumps(TOOL[2])}\n'
    for name, shape, size, pose in boxes:
        text += (
            f'\n[[obstacle]]\nname = "{name}"\nshape = "{shape}"\nsize = {json.dumps(size)}\n'
            f"pose = {json.dumps(pose)}\n"
        )
    return text
