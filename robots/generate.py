#!/usr/bin/env python3
"""Writes robots/<model>/<model>.urdf from a JSON file of figures.

    robots/generate.py tests/vectors/cs_figures.json

The URDF is the single source of truth at run time: the controller embeds it. What URDF has no word for (robot type,
rated payload, joint accelerations, link pairs that cannot collide) stands in one <elite_robot> element, which URDF
readers skip. Collision capsules are written in plain URDF as a cylinder and two spheres. Standard library only.
"""

import json
import math
import sys
from pathlib import Path

# Ours, not the vendor's: no public figure exists (see README.md).
JOINT_ACCELERATION_RAD_S2 = 10.0


def number(value):
    """Shortest decimal that is exact to 1e-15; never '-0'."""
    text = f"{value:.15f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def angle(value):
    """All 17 digits: a quarter turn must come back as the same double."""
    return "0" if value == 0 else repr(float(value))


def vector(values, render=number):
    return " ".join(render(v) for v in values)


def origin(xyz, rpy=(0.0, 0.0, 0.0)):
    return f'<origin xyz="{vector(xyz)}" rpy="{vector(rpy, angle)}"/>'


def capsule(name, p0, p1, radius):
    """The cylinder between p0 and p1 and the two balls at its ends, or one ball if they coincide."""
    axis = [b - a for a, b in zip(p0, p1)]
    length = math.sqrt(sum(x * x for x in axis))
    parts = []
    if length > 0.0:
        middle = [(a + b) / 2 for a, b in zip(p0, p1)]
        # The rotation that takes z to the axis: roll 0, then pitch about y, then yaw about z.
        rpy = (0.0, math.atan2(math.hypot(axis[0], axis[1]), axis[2]), math.atan2(axis[1], axis[0]))
        # A millionth of a radian of axis direction does not matter here, so these are kept short.
        rpy = tuple(round(x, 9) for x in rpy)
        parts.append((name, middle, rpy, f'<cylinder radius="{number(radius)}" length="{number(round(length, 9))}"/>'))
        parts.append((f"{name}_end0", p0, (0.0, 0.0, 0.0), f'<sphere radius="{number(radius)}"/>'))
        parts.append((f"{name}_end1", p1, (0.0, 0.0, 0.0), f'<sphere radius="{number(radius)}"/>'))
    else:
        parts.append((name, p0, (0.0, 0.0, 0.0), f'<sphere radius="{number(radius)}"/>'))
    lines = []
    for part, xyz, rpy, shape in parts:
        lines += [
            f'    <collision name="{part}">',
            f"      {origin(xyz, rpy)}",
            f"      <geometry>{shape}</geometry>",
            "    </collision>",
        ]
    return lines


def link(name, figures):
    inertia = " ".join(f'{k}="{number(v)}"' for k, v in figures["inertia_about_com"].items())
    lines = [
        f'  <link name="{name}">',
        "    <inertial>",
        f"      {origin(figures['com'])}",
        f'      <mass value="{number(figures["mass"])}"/>',
        f"      <inertia {inertia}/>",
        "    </inertial>",
    ]
    for index, c in enumerate(figures["capsules"]):
        lines += capsule(f"{name}_capsule{index}", c["p0"], c["p1"], c["radius"])
    return lines + ["  </link>"]


def joint(figures):
    lower, upper = (math.radians(x) for x in figures["position_deg"])
    rpy = [k * (math.pi / 2) for k in figures["origin_rpy_quarter_turns"]]
    limits = {
        "lower": angle(lower),
        "upper": angle(upper),
        "velocity": angle(math.radians(figures["speed_deg_s"])),
        "effort": number(figures["effort_nm"]),
    }
    return [
        f'  <joint name="{figures["name"]}" type="revolute">',
        f"    {origin(figures['origin_xyz'], rpy)}",
        f'    <parent link="{figures["parent"]}"/>',
        f'    <child link="{figures["child"]}"/>',
        '    <axis xyz="0 0 1"/>',
        "    <limit " + " ".join(f'{k}="{v}"' for k, v in limits.items()) + "/>",
        "  </joint>",
    ]


def fixed(parent, child):
    return [
        f'  <link name="{child}"/>',
        f'  <joint name="{parent}_to_{child}" type="fixed">',
        f"    {origin((0.0, 0.0, 0.0))}",
        f'    <parent link="{parent}"/>',
        f'    <child link="{child}"/>',
        "  </joint>",
    ]


def robot(name, model, pairs, source):
    links = list(model["links"])
    last = model["joints"][-1]["child"]
    lines = [
        '<?xml version="1.0"?>',
        f"<!-- {name}: written by robots/generate.py, do not edit. Lengths, limits and masses: {source}.",
        "     Inertia tensors are about the centre of mass; robots/README.md says how they were derived. -->",
        f'<robot name="{name}">',
        f'  <elite_robot type="{model["robot_type"]}" rated_payload="{number(model["rated_payload_kg"])}">',
    ]
    for j in model["joints"]:
        lines.append(f'    <joint_acceleration joint="{j["name"]}" limit="{number(JOINT_ACCELERATION_RAD_S2)}"/>')
    for a, b in pairs:
        lines.append(f'    <never_collide link1="{a}" link2="{b}"/>')
    lines += ["  </elite_robot>", '  <link name="base_link"/>']
    lines += link(links[0], model["links"][links[0]])
    lines += [
        f'  <joint name="base_link_to_{links[0]}" type="fixed">',
        f"    {origin((0.0, 0.0, 0.0))}",
        '    <parent link="base_link"/>',
        f'    <child link="{links[0]}"/>',
        "  </joint>",
    ]
    for j in model["joints"]:
        lines += link(j["child"], model["links"][j["child"]])
        lines += joint(j)
    lines += fixed(last, "flange") + fixed("flange", "tool0")
    return "\n".join(lines + ["</robot>"]) + "\n"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    figures = json.loads(Path(sys.argv[1]).read_text())
    here = Path(__file__).resolve().parent
    for name, model in figures["models"].items():
        path = here / name / f"{name}.urdf"
        path.parent.mkdir(exist_ok=True)
        path.write_text(robot(name, model, figures["pairs_to_skip"], figures["source"]))
        print(path.relative_to(here.parent))


if __name__ == "__main__":
    main()
