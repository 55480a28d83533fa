"""The same scene in Pinocchio (PyPI), which moves the arm and asks coal without a step of Python for each pair."""

import numpy as np
import pinocchio as pin

from arm import LINKS, ROOT, SKIPPED, TOOL, URDF_LINKS, transform
from coal_scene import Scene, _shape, capsule


def _se3(matrix):
    return pin.SE3(matrix[:3, :3].copy(), matrix[:3, 3].copy())


class QuickScene:
    """An arm with its tool among obstacles; capsules of `wrist_3` are not cut at the flange."""

    def __init__(self, arm, boxes, name="cs66"):
        self.model = pin.buildModelFromUrdf(str(ROOT / "robots" / name / f"{name}.urdf"))
        self.data = self.model.createData()
        self.shapes = pin.GeometryModel()
        bodies = []
        for link, capsules in enumerate(arm.capsules):
            frame = self.model.frames[self.model.getFrameId(URDF_LINKS[link], pin.BODY)]
            for place, radius, length in capsules:
                bodies.append(
                    (
                        link,
                        LINKS[link],
                        self._add(frame.parentJoint, frame.placement * _se3(place), capsule(radius, length)),
                    )
                )
        shape, size, pose = TOOL
        flange = self.model.frames[self.model.getFrameId(URDF_LINKS[6], pin.BODY)]
        place = flange.placement * _se3(transform(pose[:3], pose[3:]))
        bodies.append((6, "tool", self._add(flange.parentJoint, place, _shape(shape, size))))
        base = self.model.frames[self.model.getFrameId(URDF_LINKS[0], pin.BODY)].placement
        self.base = base
        self.poses = [_se3(transform(pose[:3], pose[3:])) for _, _, _, pose in boxes]
        obstacles = [
            self._add(0, base * pose, _shape(shape, size)) for pose, (_, shape, size, _) in zip(self.poses, boxes)
        ]
        self.obstacles = obstacles
        for link, name, body in bodies:
            for other_link, other_name, other in bodies:
                counts = (
                    other_link < 4 and other_name != "tool"
                    if name == "tool"
                    else (other_name != "tool" and other_link < link and (other_link, link) not in SKIPPED)
                )
                if counts:
                    self.shapes.addCollisionPair(pin.CollisionPair(body, other))
            if name != "base":
                for obstacle in obstacles:
                    self.shapes.addCollisionPair(pin.CollisionPair(body, obstacle))
        self.places = self.shapes.createData()
        for request in self.places.distanceRequests:
            request.enable_signed_distance = True
        self.margin = 0.0

    def _add(self, joint, place, shape):
        return self.shapes.addGeometryObject(pin.GeometryObject(f"{self.shapes.ngeoms}", joint, place, shape))

    def stand_at(self, base):
        """Puts the base to a pose in the frame of the cell."""
        there = self.base * _se3(np.linalg.inv(base))
        for body, pose in zip(self.obstacles, self.poses):
            self.shapes.geometryObjects[body].placement = there * pose

    def nearest(self, q):
        """The least distance."""
        pair = pin.computeDistances(self.model, self.data, self.shapes, self.places, np.asarray(q, dtype=float))
        return self.places.distanceResults[pair].min_distance

    def is_clear(self, q, margin):
        if margin != self.margin:
            for request in self.places.collisionRequests:
                request.security_margin = margin
            self.margin = margin
        return not pin.computeCollisions(
            self.model, self.data, self.shapes, self.places, np.asarray(q, dtype=float), True
        )


def check_alike(arm, boxes, rng):
    """Ends with an error where the two scenes disagree."""
    slow, quick = Scene(arm, boxes, with_cut=False), QuickScene(arm, boxes)
    for _ in range(40):
        q = rng.uniform(-2.5, 2.5, 6)
        here, there = quick.nearest(q), slow.nearest(q)[0]
        # Depths of overlaps are not alike to the last digit; whether there is one is.
        if (here > 0) != (there > 0) or (here > 0 and abs(here - there) > 1e-4):
            raise SystemExit(f"Pinocchio's scene gives {here} m, coal's {there} m at {q}")
        if abs(there - 0.01) > 1e-5 and quick.is_clear(q, 0.01) != slow.is_clear(q, 0.01):
            raise SystemExit(f"whether {q} keeps the margin is not alike in the two scenes")
