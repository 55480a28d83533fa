"""How near identified numbers come to what a cell hides, and how often the stated uncertainty covers it.

    run.sh identify [RUNS]

Each of RUNS (100) seeded runs hides another payload and other friction, with 0.2 N and 0.01 Nm of
noise on the force reading, drives what `excite` writes on the plant with inertia and friction, and asks
`elitescript.identify`. A number counts as covered where it is within two stated standard deviations. For the tool, the
tip rests at one point with 0.02 mm of noise in each axis, in the postures of `excite tool`.
"""

import multiprocessing
import subprocess
import sys
import tempfile
from pathlib import Path

import elitescript
import numpy as np
from elitescript import identify

TCP = [0.01, -0.02, 0.13, 0.0, 0.0, 0.0]
TIP_NOISE_M = 2e-5


def excite(eliteserver, what, folder):
    path = folder / f"{what}.script"
    options = ["--tcp", ",".join(map(str, TCP))] if what == "tool" else []
    subprocess.run([eliteserver, "excite", what, *options, "-o", path], check=True)
    return path


def hidden(seed, folder):
    """What the cell of a run hides: mass, centre of gravity, friction."""
    random = np.random.default_rng(seed)
    mass = random.uniform(0.5, 4.0)
    cog = [*random.uniform(-0.05, 0.05, 2), random.uniform(0.02, 0.1)]
    inertia = [*mass * random.uniform(2e-3, 4e-3, 3), 0.0, 0.0, 0.0]
    share = random.uniform(0.6, 1.4, (2, 6))
    coulomb, viscous = share * [[6.0, 7.0, 5.0, 2.0, 1.5, 1.0], [8.0, 9.0, 6.0, 2.5, 2.0, 1.2]]
    tables = {
        "sensor": {"force_noise": 0.2, "torque_noise": 0.01},
        "payload": {"mass": mass, "cog": cog, "inertia": inertia},
        "arm": {"coulomb": coulomb, "viscous": viscous},
    }
    numbers = lambda x: repr([float(v) for v in x]) if np.ndim(x) else repr(float(x))
    cell = folder / f"{seed}.toml"
    cell.write_text(
        "\n".join(
            f"[{table}]\n" + "\n".join(f"{k} = {numbers(v)}" for k, v in t.items()) for table, t in tables.items()
        )
    )
    return cell, mass, np.array(cog), coulomb, viscous


def of_load(task):
    """Errors and sigmas of one run: rows of (name, error, relative error, error in sigmas)."""
    seed, folder = task
    cell, mass, cog, coulomb, viscous = hidden(seed, folder)
    found = []

    def compare(name, truth, value, sigma):
        for t, v, s in zip(np.atleast_1d(truth), np.atleast_1d(value), np.atleast_1d(sigma)):
            found.append((name, abs(v - t), abs(v - t) / abs(t), abs(v - t) / s))

    robot = elitescript.Robot()
    # A load of which the controller knows nothing looks to it like a collision:
    # it believes one that is a fifth too light.
    options = {"cell": cell, "seed": seed, "payload": (0.8 * mass, cog)}
    with elitescript.Controller(**options) as c:
        c.run(folder / "payload.script", timeout=600).check()
        trace = c.trace
    for name, from_torques in (("forces", False), ("torques", True)):
        load = identify.payload(trace, robot=robot, from_torques=from_torques)
        compare(f"mass from {name}", mass, load.mass, load.sigma.mass)
        compare(f"centre of gravity from {name}", cog, load.cog, load.sigma.cog)
    with elitescript.Controller(**options) as c:
        c.run(folder / "friction.script", timeout=600).check()
        friction = identify.friction(c.trace, robot=robot)
    compare("dry friction", coulomb, friction.coulomb, friction.sigma.coulomb)
    compare("viscous friction", viscous, friction.viscous, friction.sigma.viscous)
    return found


def of_tool(task):
    """The same of a tool whose tip was not put exactly at the point."""
    seed, postures = task
    random = np.random.default_rng(seed)
    robot = elitescript.Robot(tcp=TCP)
    rests = []
    for q in postures:
        pose = robot.get_forward_kin(q)
        pose[:3] += random.normal(0, TIP_NOISE_M, 3)
        rests.append(robot.get_inverse_kin(pose, qnear=q))
    # The noise is in where the tip rests; a rest is 75 cycles.
    cycles = np.zeros(len(rests) * 80, dtype=elitescript._controller.CYCLE_DTYPE)
    cycles["time"] = np.arange(len(cycles)) * 0.004
    cycles["actual_q"] = np.repeat(rests, 80, axis=0)
    cycles["gravity"] = [0, 0, -9.81]
    tool = identify.tool(cycles, robot=elitescript.Robot())
    away = np.subtract(tool.tcp[:3], TCP[:3])
    rows = [("tool, each coordinate", abs(d), abs(d), abs(d) / s) for d, s in zip(away, tool.sigma.position)]
    return [*rows, ("tool, distance", float(np.linalg.norm(away)), 0.0, np.nan)]


def rests_of(eliteserver, folder):
    """Where the arm rests while it drives `excite tool`, but for the start."""
    with elitescript.Controller(plant="ideal", tcp=TCP) as c:
        c.run(excite(eliteserver, "tool", folder), timeout=600).check()
        trace = c.trace
    still = np.abs(trace["actual_qd"]).max(axis=1) < 1e-4
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    places = [trace["actual_q"][(a + b) // 2] for a, b in zip(edges[::2], edges[1::2]) if b - a > 55]
    robot = elitescript.Robot(tcp=TCP)
    tips = [robot.get_forward_kin(q)[:3] for q in places]
    point = np.median(tips, axis=0)
    return [q for q, tip in zip(places, tips) if np.linalg.norm(tip - point) < 1e-3]


def main():
    eliteserver, runs = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100
    with tempfile.TemporaryDirectory() as folder, multiprocessing.Pool() as pool:
        folder = Path(folder)
        for what in ("payload", "friction"):
            excite(eliteserver, what, folder)
        postures = rests_of(eliteserver, folder)
        print(f"{runs} runs; {len(postures)} rests of the tool", flush=True)
        found = [
            *pool.imap(of_load, [(seed, folder) for seed in range(runs)]),
            *pool.imap(of_tool, [(seed, postures) for seed in range(runs)]),
        ]
    rows = {}
    for one in found:
        for name, *values in one:
            rows.setdefault(name, []).append(values)
    print(f"{'':34}{'p95':>12}{'largest':>12}{'largest, %':>12}{'within 2 sigma':>16}{'rms, sigmas':>13}")
    for name, values in rows.items():
        error, share, sigmas = np.array(values).T
        covered = f"{(sigmas <= 2).mean() * 100:.1f} %" if np.isfinite(sigmas).all() else "-"
        rms = np.sqrt((sigmas**2).mean())
        p95, most = np.quantile(error, 0.95), error.max()
        print(f"{name:34}{p95:12.3g}{most:12.3g}{share.max() * 100:12.2f}{covered:>16}{rms:13.2f}")


if __name__ == "__main__":
    main()
