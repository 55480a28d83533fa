"""Environment steps beside MuJoCo, controllers a second, what a sweep makes of the cores, what Ray costs a unit.

python3 crates/pybind/bench_simulation.py
"""

import os
import statistics
import time

import elitescript.gym
import gymnasium
import numpy as np
from elitescript import Controller, sweep

#: An arm of six joints with the lengths of a CS66 and links as heavy as such arms' are.
ARM = """
<mujoco>
  <option timestep="{step}" integrator="implicitfast"/>
  <worldbody>
    <body pos="0 0 0.1"><joint name="j1" axis="0 0 1" damping="1"/>
      <geom type="capsule" fromto="0 0 0 0 0.1 0" size="0.06" mass="4"/>
    <body pos="0 0.1 0.06"><joint name="j2" axis="0 1 0" damping="1"/>
      <geom type="capsule" fromto="0 0 0 -0.43 0 0" size="0.05" mass="8"/>
    <body pos="-0.43 0 0"><joint name="j3" axis="0 1 0" damping="1"/>
      <geom type="capsule" fromto="0 0 0 -0.39 0 0" size="0.04" mass="3"/>
    <body pos="-0.39 0 0"><joint name="j4" axis="0 1 0" damping="0.5"/>
      <geom type="capsule" fromto="0 0 0 0 0.1 0" size="0.04" mass="1.5"/>
    <body pos="0 0.1 0"><joint name="j5" axis="0 0 1" damping="0.5"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.1" size="0.04" mass="1.5"/>
    <body pos="0 0 -0.1"><joint name="j6" axis="0 1 0" damping="0.5"/>
      <geom type="capsule" fromto="0 0 0 0 0.08 0" size="0.03" mass="0.5"/>
    </body></body></body></body></body></body>
  </worldbody>
  <actuator>{actuators}</actuator>
</mujoco>
"""
ROUNDS = 5


def median_rate(work, count):
    """How often `work` does one of its `count` a second: median, least and most of some rounds."""
    rates = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        work()
        rates.append(count / (time.perf_counter() - began))
    return statistics.median(rates), min(rates), max(rates)


def told(name, rates):
    print("{}: {:.0f} a second ({:.0f} to {:.0f})".format(name, *rates), flush=True)


def environments(steps=600):
    """A step is 40 ms, as in EliteReach-v0. Actions are small, so that no episode ends."""
    actions = np.random.default_rng(0).uniform(-0.02, 0.02, (steps, 6)).astype(np.float32)
    env = gymnasium.make("EliteReach-v0", disable_env_checker=True).unwrapped

    def ours():
        env.reset(seed=1)
        for action in actions:
            env.step(action)

    told("EliteReach-v0, one arm", median_rate(ours, steps))
    for n in (16,):
        for threads in (1, os.cpu_count()):
            vec = elitescript.gym.make_vec(n, threads=threads)
            many = np.repeat(actions[: steps // 4, None], n, axis=1)

            def together():
                vec.reset(seed=1)
                for action in many:
                    vec.step(action)

            told(f"make_vec({n}), {threads} threads, steps of single arms", median_rate(together, n * len(many)))
            vec.close()
    try:
        import mujoco
    except ImportError:
        return
    for step in (0.001, 0.004):
        actuators = "".join(f'<velocity joint="j{k}" kv="200"/>' for k in range(1, 7))
        model = mujoco.MjModel.from_xml_string(ARM.format(step=step, actuators=actuators))
        data = mujoco.MjData(model)
        substeps = round(0.04 / step)

        def theirs():
            mujoco.mj_resetData(model, data)
            data.qpos[:] = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
            for action in actions:
                data.ctrl[:] = action
                mujoco.mj_step(model, data, substeps)
                np.concatenate([data.qpos, data.qvel, data.xpos[-1]])

        told(f"MuJoCo, steps of 40 ms in {substeps} of {step * 1e3:.0f} ms, one call", median_rate(theirs, steps))

        def theirs_one_by_one():
            mujoco.mj_resetData(model, data)
            data.qpos[:] = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
            for action in actions:
                data.ctrl[:] = action
                for _ in range(substeps):
                    mujoco.mj_step(model, data)
                np.concatenate([data.qpos, data.qvel, data.xpos[-1]])

        told(
            f"MuJoCo, steps of 40 ms in {substeps} of {step * 1e3:.0f} ms, a call each",
            median_rate(theirs_one_by_one, steps),
        )


def controllers(count=200):
    def work():
        for _ in range(count):
            with Controller() as c:
                c.run("pass")

    told("controllers: start, a program of `pass`, end", median_rate(work, count))


PROGRAM = """
for i in range(5):
    movej([0.4, -1.2, 1.4, -1.5, -1.5, angle], a=3, v=1.5)
    movej([-0.4, -1.6, 1.6, -1.5, -1.5, 0], a=3, v=1.5)
end
"""


def sweeps(units=320):
    grid = {"angle": np.linspace(-1, 1, units)}

    def timed(**how):
        began = time.perf_counter()
        table = sweep(PROGRAM, grid, progress=False, **how)
        return time.perf_counter() - began, table

    timed(workers=1)
    cores = os.cpu_count()
    times = {(how, n): [] for how in ("threads", "processes") for n in (1, cores)}
    tables = []
    for _ in range(3):
        for how, n in times:
            seconds, table = timed(executor=how, workers=n)
            times[how, n].append(seconds)
            tables.append(table)
    for (how, n), seconds in times.items():
        print(f"sweep of {units} units, {how}, {n} at once: {statistics.median(seconds):.2f} s", flush=True)
    for how in ("threads", "processes"):
        one, all_of_them = (statistics.median(times[how, n]) for n in (1, cores))
        print(f"  {how}: {one / all_of_them / cores:.1%} of {cores} cores", flush=True)
    try:
        import ray
    except ImportError:
        return
    ray.init(num_cpus=cores, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
    short = {"angle": np.linspace(-1, 1, 400)}
    sweep("pass", short, executor="ray", progress=False)
    rates = {}
    for how in ("threads", "ray"):
        began = time.perf_counter()
        tables_of = sweep("pass", short, executor=how, progress=False)
        rates[how] = (time.perf_counter() - began) / tables_of.num_rows * 1e3
    seconds, table = timed(executor="ray")
    tables.append(table)
    print(f"sweep of {units} units, ray, {cores} at once: {seconds:.2f} s")
    print("a unit of `pass`: " + ", ".join(f"{how} {ms:.2f} ms" for how, ms in rates.items()))
    ray.shutdown()
    print("all tables are the same:", all(table.equals(tables[0]) for table in tables))


if __name__ == "__main__":
    environments()
    controllers()
    sweeps()
