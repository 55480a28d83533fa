"""The scene of the product, built of the shapes of coal."""

import math

import coal
import numpy as np

from arm import LINKS, SKIPPED, TOOL, transform


def _placed(matrix):
    return coal.Transform3s(matrix[:3, :3].copy(), matrix[:3, 3].copy())


def _shape(shape, size):
    if shape == "box":
        return coal.Box(*size)
    if shape == "cylinder":
        return coal.Cylinder(size[0], size[1])
    if shape == "hull":
        return _hull(np.reshape(size, (-1, 3)))
    return coal.Sphere(size if isinstance(size, float) else size[0])


def capsule(radius, length):
    return coal.Capsule(radius, length) if length > 0 else coal.Sphere(radius)


def _cut_capsule(place, radius, length, normal, height):
    """A capsule without what lies beyond a plane, as the hull of many points of its surface."""
    points = []
    count = 60
    for end in [-length / 2, length / 2] if length > 0 else [0.0]:
        centre = (place @ np.array([0, 0, end, 1.0]))[:3]
        below = height - normal @ centre
        first = np.cross(normal, [1, 0, 0])
        first = first / np.linalg.norm(first)
        second = np.cross(normal, first)
        for k in range(count + 1):
            angle = math.pi * (1 - k / count)
            rise, across = radius * math.cos(angle), radius * math.sin(angle)
            if rise > below:
                break
            for j in range(2 * count):
                turn = math.pi * j / count
                points.append(centre + normal * rise + across * (first * math.cos(turn) + second * math.sin(turn)))
        disc = math.sqrt(max(radius**2 - below**2, 0.0))
        for j in range(2 * count):
            turn = math.pi * j / count
            points.append(centre + normal * below + disc * (first * math.cos(turn) + second * math.sin(turn)))
    return _hull(points)


def _hull(points):
    vertices = coal.StdVec_Vec3s()
    for point in points:
        vertices.append(point)
    return coal.Convex.convexHull(vertices, False, None)


class Scene:
    """An arm with its tool among obstacles."""

    def __init__(self, arm, boxes, with_cut=True):
        self.arm = arm
        self.bodies = []
        for link, capsules in enumerate(arm.capsules):
            for place, radius, length in capsules:
                if link == 6 and with_cut:
                    shape = _cut_capsule(place, radius, length, np.array([0.0, 0.0, 1.0]), 0.0)
                    self.bodies.append((link, LINKS[link], shape, np.eye(4)))
                else:
                    self.bodies.append((link, LINKS[link], capsule(radius, length), place))
        shape, size, pose = TOOL
        self.bodies.append((6, "tool", _shape(shape, size), transform(pose[:3], pose[3:])))
        self.obstacles = [
            (name, _shape(shape, size), _placed(transform(pose[:3], pose[3:]))) for name, shape, size, pose in boxes
        ]
        self.pairs = []
        for k, (link, name, _, _) in enumerate(self.bodies):
            for j, (other, other_name, _, _) in enumerate(self.bodies):
                counts = (
                    other < 4 and other_name != "tool"
                    if name == "tool"
                    else (other_name != "tool" and other < link and (other, link) not in SKIPPED)
                )
                if counts:
                    self.pairs.append((k, j, None))
            if name != "base":
                self.pairs.extend((k, None, o) for o in range(len(self.obstacles)))
        self.request = coal.DistanceRequest()
        self.request.enable_signed_distance = True
        self.result = coal.DistanceResult()

    def place(self, q):
        frames = self.arm.frames(q)
        return [_placed(frames[link] @ local) for link, _, _, local in self.bodies]

    def nearest(self, q):
        """The least distance, and the names of the two."""
        places = self.place(q)
        least = (math.inf, "", "")
        for body, other, obstacle in self.pairs:
            if obstacle is None:
                shape, place, name = self.bodies[other][2], places[other], self.bodies[other][1]
            else:
                name, shape, place = self.obstacles[obstacle]
            self.result.clear()
            distance = coal.distance(self.bodies[body][2], places[body], shape, place, self.request, self.result)
            if distance < least[0]:
                least = (distance, self.bodies[body][1], name)
        return least

    def is_clear(self, q, margin):
        places = self.place(q)
        request = coal.CollisionRequest()
        request.security_margin = margin
        result = coal.CollisionResult()
        for body, other, obstacle in self.pairs:
            if obstacle is None:
                shape, place = self.bodies[other][2], places[other]
            else:
                _, shape, place = self.obstacles[obstacle]
            result.clear()
            if coal.collide(self.bodies[body][2], places[body], shape, place, request, result):
                return False
        return True
