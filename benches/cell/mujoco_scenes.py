"""Parts of a cell beside MuJoCo, on scenes that no closed form describes: stacks, tipping, rolling, pushing, toppling.

    run.sh [SCENE...]

Each scene is written twice: as a cell file, whose parts `eliteserver run` records, and as a model of MuJoCo with stiff
contacts and steps of 0.1 ms. Prints where and when things end in both. Ends with status 1 where a difference is larger
than the scene allows.
"""

import csv
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

G = 9.81
#: Where the scenes are, m: out of the arm's reach.
AWAY = np.array([3.0, 0.0, 0.0])
STEP_S = 0.0001
CYCLE_S = 0.004


@dataclass
class Body:
    """A part, or an obstacle when its mass is 0. Size as in a cell file; pose x, y, z, Rx, Ry, Rz."""

    name: str
    shape: str
    size: list
    pose: list
    mass: float = 0.0


@dataclass
class Scene:
    """What is there, for how long, and which differences are allowed."""

    bodies: list
    seconds: float
    friction: float = 0.5
    #: Name of an obstacle that moves, its way along x (m) and the time of that (s).
    pusher: tuple = None
    #: Name of the event, and a function of the poses of all parts.
    events: dict = field(default_factory=dict)
    #: Parts whose end is compared.
    ends: list = field(default_factory=list)
    #: mm, degrees, s.
    allowed: tuple = (2.0, 1.0, 0.01)
    #: Coefficients of two things by their names, where not that of the scene.
    pairs: dict = field(default_factory=dict)
    #: Whether parts turn about their axis of symmetry freely, which then is not compared.
    round: bool = False


def rotation(rpy):
    (cx, cy, cz), (sx, sy, sz) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def cell_text(scene):
    """The scene as a cell file."""
    lines = ["[world]", "floor = 0.0"]
    for body in scene.bodies:
        size = body.size[0] if body.shape == "sphere" else body.size
        pose = [float(x) for x in np.array(body.pose) + np.concatenate([AWAY, np.zeros(3)])]
        lines += ["[[part]]" if body.mass else "[[obstacle]]", f'name = "{body.name}"', f'shape = "{body.shape}"']
        lines += [f"size = {size!r}", f"pose = {pose!r}", f"friction = {scene.friction!r}"]
        lines += [f"mass = {body.mass!r}"] if body.mass else []
    # The floor has 0.5 of its own, which a scene must not lower unseen.
    lines += [
        line
        for body in scene.bodies
        if body.mass
        for line in ("[[friction]]", 'a = "floor"', f'b = "{body.name}"', f"value = {scene.friction!r}")
    ]
    for (a, b), value in scene.pairs.items():
        lines += ["[[friction]]", f'a = "{a}"', f'b = "{b}"', f"value = {value!r}"]
    if scene.pusher:
        name, way, seconds = scene.pusher
        lines += ["[[actuator]]", 'name = "pusher"', f'moves = ["{name}"]', 'kind = "linear"', "axis = [1, 0, 0]"]
        lines += [f"stroke = {way!r}", f"time = {seconds!r}", "force = 5000", 'extend = "standard_digital_out[0]"']
    return "\n".join(lines) + "\n"


def ours(eliteserver, scene):
    """Times, and for each part its positions and rotations, cycle by cycle."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "cell.toml").write_text(cell_text(scene))
        start = "set_standard_digital_out(0, True)\n" if scene.pusher else ""
        (folder / "p.script").write_text(f"{start}sleep({scene.seconds})\n")
        call = lambda *arguments: (
            subprocess.run(
                [eliteserver, *arguments], cwd=folder, check=True, capture_output=True, text=True, timeout=300
            ).stdout
        )
        call("run", "p.script", "--cell", "cell.toml", "--record", "p.mcap")
        rows = list(csv.DictReader(call("replay", "p.mcap", "--csv", "/world").splitlines()))
    cycles = int(scene.seconds / CYCLE_S)
    tracks = {body.name: ([None] * (cycles + 1), [None] * (cycles + 1)) for body in scene.bodies if body.mass}
    for row in rows:
        cycle = int(row["cycle"])
        if cycle <= cycles:
            places, turns = tracks[row["name"]]
            places[cycle] = np.array([float(row[k]) for k in "xyz"]) - AWAY
            turns[cycle] = rotation([float(row[k]) for k in ("Rx", "Ry", "Rz")])
    for places, turns in tracks.values():
        # A part that does not move has no row.
        for cycle in range(1, cycles + 1):
            if places[cycle] is None:
                places[cycle], turns[cycle] = places[cycle - 1], turns[cycle - 1]
    return np.arange(cycles + 1) * CYCLE_S, {name: tuple(map(np.array, track)) for name, track in tracks.items()}


def model_text(scene):
    """The scene as a model of MuJoCo.

    Twice the critical damping, with which things rebound with 5 % of their speed (13 % with the critical one). Its
    friction pushes sliding things apart; less so with elliptic cones and a large `impratio`,
    which also keeps contacts from creeping.
    """
    springs = 'solref="0.002 2" solimp="0.99 0.999 0.0002"'
    geom = f'friction="{scene.friction} 0 0" condim="3" {springs}'
    lines = [f'<geom type="plane" size="20 20 1" {geom}/>']
    for body in scene.bodies:
        half = [x / 2 for x in body.size]
        kind, size = {
            "box": ("box", half),
            "sphere": ("sphere", body.size[:1]),
            "cylinder": ("cylinder", [body.size[0], body.size[-1] / 2]),
        }[body.shape]
        turn = np.zeros(4)
        mujoco.mju_mat2Quat(turn, rotation(body.pose[3:]).ravel())
        words = lambda numbers: " ".join(repr(float(x)) for x in numbers)
        place = f'pos="{words(body.pose[:3])}" quat="{words(turn)}"'
        solid = f'name="{body.name}" type="{kind}" size="{words(size)}" {geom}'
        if body.mass:
            lines.append(f'<body name="{body.name}" {place}><freejoint/><geom mass="{body.mass}" {solid}/></body>')
        elif scene.pusher and body.name == scene.pusher[0]:
            joint = '<joint name="pusher" type="slide" axis="1 0 0"/>'
            lines.append(f'<body {place} gravcomp="1">{joint}<geom mass="10000" {solid}/></body>')
        else:
            lines.append(f"<geom {place} {solid}/>")
    pairs = [
        f'<pair geom1="{a}" geom2="{b}" condim="3" friction="{value} {value} 0 0 0" {springs}/>'
        for (a, b), value in scene.pairs.items()
    ]
    option = f'timestep="{STEP_S}" gravity="0 0 -{G}" cone="elliptic" impratio="100" iterations="200" tolerance="1e-12"'
    world = f"<worldbody>{''.join(lines)}</worldbody><contact>{''.join(pairs)}</contact>"
    return f"<mujoco><option {option}/>{world}</mujoco>"


def theirs(scene):
    """The same of MuJoCo."""
    model = mujoco.MjModel.from_xml_string(model_text(scene))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    names = [body.name for body in scene.bodies if body.mass]
    bodies = [model.body(name).id for name in names]
    places, turns = [], []
    each = round(CYCLE_S / STEP_S)
    for cycle in range(int(scene.seconds / CYCLE_S) + 1):
        places.append(data.xpos[bodies].copy())
        turns.append(data.xmat[bodies].reshape(-1, 3, 3).copy())
        for _ in range(each):
            if scene.pusher:
                _, way, seconds = scene.pusher
                joint = model.joint("pusher")
                left = way - data.qpos[joint.qposadr[0]]
                data.qvel[joint.dofadr[0]] = min(way / seconds, max(left, 0.0) / STEP_S)
            mujoco.mj_step(model, data)
    places, turns = np.array(places), np.array(turns)
    times = np.arange(len(places)) * CYCLE_S
    return times, {name: (places[:, k], turns[:, k]) for k, name in enumerate(names)}


def first(times, tracks, event):
    """When an event happens first, s; NaN for never. Between two cycles by a straight line."""
    values = np.array([event({n: (p[k], r[k]) for n, (p, r) in tracks.items()}) for k in range(len(times))])
    over = np.flatnonzero(values >= 0)
    if not len(over) or over[0] == 0:
        return np.nan if not len(over) else 0.0
    k = over[0]
    return times[k - 1] + (times[k] - times[k - 1]) * -values[k - 1] / (values[k] - values[k - 1])


def box(name, side, x, z, mass=0.2, y=0.0, turn=0.0):
    return Body(name, "box", [side] * 3, [x, y, z, 0, turn, 0], mass)


def stack(shift, count=5, side=0.05):
    """Boxes, each shifted against the one below."""
    return [box(f"box{k}", side, shift * k, side * (k + 0.5)) for k in range(count)]


def tilt(track):
    """Angle of z to the vertical, rad."""
    return np.arccos(np.clip(track[1][2, 2], -1, 1))


def scenes():
    table = Body("table", "box", [0.4, 0.4, 0.4], [-0.2, 0, 0.2, 0, 0, 0])
    slope_angle, ball = np.radians(15.0), 0.03
    slope = rotation([0, slope_angle, 0])
    # A slope whose upper face ends at the origin, on the floor.
    middle = slope @ np.array([-0.4, 0, -0.05])
    on_slope = slope @ np.array([-0.5, 0, ball])
    height, radius = 0.12, 0.02
    critical = np.arctan(2 * radius / height)
    tilted = lambda angle: (
        # On the lower edge, tilted about y.
        [
            radius - np.cos(angle) * radius + np.sin(angle) * height / 2,
            0,
            np.sin(angle) * radius + np.cos(angle) * height / 2,
            0,
            angle,
            0,
        ]
    )
    leans = lambda angle: [Body("can", "cylinder", [radius, height], tilted(angle), 0.3)]
    fallen = {"lies": lambda parts: tilt(parts["can"]) - np.radians(80)}
    return {
        # The middle of the upper four is 20 mm off the middle of the lowest: it stands.
        "stack, 8 mm each, stands": Scene(
            stack(0.008), 4.0, ends=[f"box{k}" for k in range(5)], allowed=(0.5, 0.2, 0.01)
        ),
        # 37.5 mm: it falls.
        "stack, 15 mm each, falls": Scene(
            stack(0.015),
            2.0,
            events={"top box 50 mm lower": lambda parts: 0.175 - parts["box4"][0][2]},
            allowed=(2, 1, 0.02),
        ),
        "box over an edge by 2 mm": Scene(
            [table, box("box", 0.1, 0.002, 0.45)],
            2.0,
            events={
                "tilted by 30°": lambda parts: tilt(parts["box"]) - np.radians(30),
                "tilted by 60°": lambda parts: tilt(parts["box"]) - np.radians(60),
                "200 mm lower": lambda parts: 0.25 - parts["box"][0][2],
            },
            allowed=(5, 2, 0.03),
        ),
        # Where the turning ball rubs on the box, MuJoCo's friction pushes them apart by an eighth of the speed.
        "ball rolls down and hits a box, smooth": Scene(
            [
                Body("slope", "box", [0.8, 0.4, 0.1], [*middle, 0, slope_angle, 0]),
                Body("ball", "sphere", [ball], [*on_slope, 0, 0, 0], 0.3),
                box("box", 0.06, 0.33, 0.03, 0.1),
            ],
            2.5,
            events={
                "ball 400 mm further": lambda parts: parts["ball"][0][0] - on_slope[0] - 0.4,
                "box moves": lambda parts: parts["box"][0][0] - 0.331,
            },
            ends=["box"],
            pairs={("ball", "box"): 0.0001},
            allowed=(12, 1, 0.01),
        ),
        # In MuJoCo pushed boxes tremble by some 20 mm/s, so the foremost slides further when the pusher stops.
        "row of three boxes pushed at 0.5 m/s": Scene(
            [Body("pusher plate", "box", [0.02, 0.2, 0.06], [-0.06, 0, 0.035, 0, 0, 0])]
            + [box(f"box{k}", 0.06, 0.1 * k, 0.03, 0.2 + 0.1 * k) for k in range(3)],
            2.5,
            pusher=("pusher plate", 0.5, 1.0),
            ends=["box0", "box1", "box2"],
            allowed=(7, 1, 0.01),
        ),
        "row of three boxes pushed slowly, 20 mm/s": Scene(
            [Body("pusher plate", "box", [0.02, 0.2, 0.06], [-0.06, 0, 0.035, 0, 0, 0])]
            + [box(f"box{k}", 0.06, 0.06 * k, 0.03, 0.2) for k in range(3)],
            4.0,
            pusher=("pusher plate", 0.06, 3.0),
            ends=["box0", "box1", "box2"],
            allowed=(0.5, 0.5, 0.01),
        ),
        "box pushed 10 mm off its middle": Scene(
            [Body("pusher plate", "box", [0.02, 0.02, 0.06], [-0.06, 0.01, 0.035, 0, 0, 0]), box("box", 0.06, 0, 0.03)],
            3.0,
            pusher=("pusher plate", 0.15, 1.5),
            ends=["box"],
            allowed=(5, 5, 0.01),
        ),
        "cylinder 1° beyond its balance": Scene(
            leans(critical + np.radians(1)), 2.0, events=fallen, ends=["can"], round=True
        ),
        "cylinder 1° short of its balance": Scene(
            leans(critical - np.radians(1)), 3.0, events=fallen, ends=["can"], round=True
        ),
    }


def compare(eliteserver, name, scene):
    """Prints the rows of a scene; whether all is as close as allowed."""
    (times, our), (their_times, their) = ours(eliteserver, scene), theirs(scene)
    far_mm, turned_degrees, late_s = scene.allowed
    good = True
    print(name)
    for event, value in scene.events.items():
        a, b = first(times, our, value), first(their_times, their, value)
        good &= bool(np.isnan(a) and np.isnan(b)) or bool(abs(a - b) <= late_s)
        print(f"    {event:<24} {a:8.3f} s     {b:8.3f} s     {a - b:+8.3f} s     allowed {late_s:g} s")
    for part in scene.ends:
        (p, r), (q, s) = ((track[part][0][-1], track[part][1][-1]) for track in (our, their))
        far = 1e3 * np.linalg.norm(p - q)
        if scene.round:
            turned = np.degrees(np.arccos(np.clip(r[:, 2] @ s[:, 2], -1, 1)))
        else:
            turned = np.degrees(np.arccos(np.clip((np.trace(r.T @ s) - 1) / 2, -1, 1)))
        good &= bool(far <= far_mm and turned <= turned_degrees)
        where = lambda x: ", ".join(f"{1e3 * v:.1f}" for v in x)
        print(
            f"    {part + ' at the end, mm':<24} ({where(p)})   ({where(q)})   {far:.2f} mm, {turned:.2f}°     "
            f"allowed {far_mm:g} mm, {turned_degrees:g}°"
        )
    return good


def main():
    eliteserver, *wanted = sys.argv[1:]
    table = scenes()
    unknown = [name for name in wanted if name not in table]
    if unknown:
        sys.exit(f"mujoco_scenes.py: there is no scene {unknown[0]!r}; there are: " + "; ".join(table))
    print(f"eliteserver, MuJoCo {mujoco.__version__}, difference")
    results = {name: compare(eliteserver, name, scene) for name, scene in table.items() if not wanted or name in wanted}
    off = [name for name, good in results.items() if not good]
    print(
        f"{len(results) - len(off)} of {len(results)} scenes as close as allowed"
        + (": not " + "; ".join(off) if off else "")
    )
    sys.exit(1 if off else 0)


if __name__ == "__main__":
    main()
