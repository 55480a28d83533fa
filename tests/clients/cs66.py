"""The geometry of a CS66, written once more for the tests: nominal Denavit-Hartenberg figures,
poses as scripts write them."""

import math

# Standard convention, T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i).
D = (0.1625, 0, 0, 0.1475, 0.0965, 0.092)
A = (0, -0.427, -0.3905, 0, 0, 0)
ALPHA = (math.pi / 2, 0, 0, math.pi / 2, -math.pi / 2, 0)
GRAVITY = 9.81


def times(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def link(q, i):
    c, s, ca, sa = math.cos(q), math.sin(q), math.cos(ALPHA[i]), math.sin(ALPHA[i])
    return [
        [c, -s * ca, s * sa, A[i] * c],
        [s, c * ca, -c * sa, A[i] * s],
        [0, sa, ca, D[i]],
        [0, 0, 0, 1],
    ]


def frames(q):
    """Base from the end of each link, the flange last."""
    found, pose = [], [[float(i == j) for j in range(4)] for i in range(4)]
    for i in range(6):
        pose = times(pose, link(q[i], i))
        found.append(pose)
    return found


def rotation(rpy):
    """Rz(rz) Ry(ry) Rx(rx)."""
    (cx, cy, cz), (sx, sy, sz) = map(math.cos, rpy), map(math.sin, rpy)
    return [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ]


def rotate(r, v):
    return [sum(x * y for x, y in zip(row, v)) for row in r]


def rotate_back(r, v):
    return rotate(list(zip(*r)), v)


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def plus(*vectors):
    return [sum(axis) for axis in zip(*vectors)]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]
