"""Environments for learning, with the gymnasium API: ``EliteReach-v0``, ``EliteContact-v0`` and ``ElitePick-v0``.

>>> import gymnasium, elitescript.gym
>>> env = gymnasium.make("EliteReach-v0")
>>> observation, info = env.reset(seed=1)

``make_vec(n)`` steps n arms on every core, in Rust, without Python in between. The same seed and the same actions give
the same observations, one by one or vectorised.

EliteReach-v0: bring the TCP to a point.
    Action (6,), -1 to 1: joint speeds, in parts of 1 rad/s.
    Observation (18,): joint positions, rad; joint speeds, rad/s; TCP position, m; target position, m.
    Reward: minus the distance in m, minus 0.01 times the squared length of the action; +1 for ending within 2 cm. A
    protective stop (limits, links that meet) costs 5.
    Ends within 2 cm (terminated), at a protective stop (terminated), after 250 steps of 40 ms (truncated).

EliteContact-v0: press on a plate of unknown stiffness, 2 to 50 N/mm, with 20 N.
    Action (3,), -1 to 1: TCP velocity along the base axes, in parts of 50 mm/s.
    Observation (10,): TCP position relative to the start, m; TCP velocity, m/s; force on the tool along the base axes,
    N / 20; how long the force has been within 2 N, in parts of 0.4 s.
    Reward: minus the distance of the pressing force from 20 N in parts of 20 N, at most 2, minus 0.01 times the squared
    length of the action; +1 for ending well. More than 100 N, or a protective stop, costs 5.
    Ends when the force was within 2 N for 0.4 s (terminated), above 100 N or at a protective stop (terminated), after
    250 steps of 40 ms (truncated).

ElitePick-v0: pick a box from a table with a suction cup and lift it by 100 mm.
    The box has sides of 60 to 100 mm, a height of 30 to 80 mm and a mass of 0.1 to 0.5 kg; it stands up to 100 mm aside
    and 100 to 200 mm below the cup, turned by any angle. The cup has a radius of 15 mm and 60 kPa; it seals where its
    whole rim lies on the top of the box, and loses a box that is accelerated or pushed too hard.
    Action (4,), -1 to 1: TCP velocity along the base axes, in parts of 250 mm/s; vacuum, on above 0.
    The cup keeps looking down.
    Observation (9,): from the cup to the middle of the box's top, m; TCP velocity, m/s; how far the box was lifted, m;
    pressure in parts of 60 kPa, 0 where the cup does not seal; 1 where the box is held.
    Reward: minus the distance of the cup from the middle of the top, at most 1 m, minus what is left of the 0.1 m to be
    lifted, minus 0.01 times the squared length of the action; +1 for ending well. A box that falls from the table, or a
    protective stop (the cup was driven into something), costs 5.
    Ends when the box is held and was lifted by 100 mm (terminated), when it falls from the table or at a protective
    stop (terminated), after 250 steps of 40 ms (truncated).
"""

from __future__ import annotations

import os
import tempfile
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

try:
    import gymnasium
    from gymnasium import spaces
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ImportError:
    raise ImportError('environments need gymnasium: pip install "elitescript[gym]"') from None

from ._controller import CYCLE_DTYPE
from ._elitescript import Fleet, Robot
from ._options import option_texts

__all__ = ["ContactTask", "EliteEnv", "EliteVectorEnv", "PickTask", "ReachTask", "make_vec"]

#: Cycles of 4 ms in a step.
STEP_CYCLES = 10
#: Steps until an episode is cut.
STEPS_MAX = 250
#: How fast joints take up their speeds, rad/s^2.
ACCELERATION = 10.0
#: The last safety mode in which the arm may move: 1 normal, 2 reduced.
MOVING_MODES_MAX = 2

_Floats = NDArray[np.float64]


def _rotation(rpy: NDArray[np.float64]) -> NDArray[np.float64]:
    """R = Rz(Rz) Ry(Ry) Rx(Rx)."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def _linear_speeds(robot: Robot, rows: NDArray[np.void], twists: _Floats) -> _Floats:
    """Joint speeds for twists of the TCP, base axes, an arm each."""
    jacobian = np.asarray(robot.jacobian(rows["actual_q"])).reshape(-1, 6, 6)
    # Damped: near a singularity the joints stay slow.
    square = jacobian @ jacobian.transpose(0, 2, 1) + 1e-4 * np.eye(6)
    return np.asarray((jacobian.transpose(0, 2, 1) @ np.linalg.solve(square, twists[:, :, None]))[:, :, 0])


class _Task:
    """What environments have in common."""

    #: TCP in the flange frame where the task needs one of its own.
    tcp: Optional[List[float]] = None

    def act(self, fleet: Fleet, actions: _Floats) -> None:
        """What the actions set beside joint speeds."""

    def see(self, fleet: Fleet) -> None:
        """Takes in what is not in the rows of the cycle."""


class ReachTask(_Task):
    """What EliteReach-v0 asks for, for any number of arms at once."""

    action_space = spaces.Box(-1.0, 1.0, (6,), np.float32)
    observation_space = spaces.Box(
        np.array([-7.0] * 6 + [-10.0] * 6 + [-3.0] * 6, np.float32),
        np.array([7.0] * 6 + [10.0] * 6 + [3.0] * 6, np.float32),
    )
    #: rad/s of the action 1.
    speed = 1.0
    #: m.
    near = 0.02
    _home = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])

    def __init__(self, arms: int, robot: Robot) -> None:
        self._robot = robot
        self._targets = np.zeros((arms, 3))

    def begin(self, arm: int, random: np.random.Generator) -> Dict[str, Any]:
        """Options of an arm that begins anew."""
        home = self._home + random.uniform(-0.3, 0.3, 6)
        there = self._home + random.uniform(-0.8, 0.8, 6) * np.array([1, 0.6, 0.6, 1, 1, 1])
        target = np.asarray(self._robot.get_forward_kin(there))[:3]
        target[2] = max(target[2], 0.05)
        self._targets[arm] = target
        return {"home": home}

    def speeds(self, actions: _Floats, rows: NDArray[np.void]) -> _Floats:
        """Joint speeds for the actions, rad/s."""
        return self.speed * actions

    def observe(self, rows: NDArray[np.void]) -> NDArray[np.float32]:
        """One observation an arm."""
        parts = [rows["actual_q"], rows["actual_qd"], rows["actual_tcp_pose"][:, :3], self._targets]
        return np.concatenate(parts, axis=1).astype(np.float32)

    def judge(self, actions: _Floats, rows: NDArray[np.void]) -> Tuple[_Floats, NDArray[np.bool_], NDArray[np.bool_]]:
        """Reward, whether it has ended, and whether well, an arm each."""
        distance = np.sqrt(((rows["actual_tcp_pose"][:, :3] - self._targets) ** 2).sum(axis=1))
        stopped = rows["safety_mode"] > MOVING_MODES_MAX
        well = (distance < self.near) & ~stopped
        reward = -distance - 0.01 * (actions**2).sum(axis=1) + 1.0 * well - 5.0 * stopped
        return reward, well | stopped, well


class ContactTask(_Task):
    """What EliteContact-v0 asks for, for any number of arms at once."""

    action_space = spaces.Box(-1.0, 1.0, (3,), np.float32)
    observation_space = spaces.Box(
        np.array([-3.0] * 3 + [-10.0] * 3 + [-1e3] * 3 + [0.0], np.float32),
        np.array([3.0] * 3 + [10.0] * 3 + [1e3] * 3 + [1.0], np.float32),
    )
    #: m/s of the action 1.
    speed = 0.05
    #: N.
    wanted, within, most = 20.0, 2.0, 100.0
    #: Steps that the force must last.
    lasting = 10
    _home = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])

    def __init__(self, arms: int, robot: Robot) -> None:
        self._robot = robot
        self._start = np.zeros((arms, 3))
        self._held = np.zeros(arms)

    def begin(self, arm: int, random: np.random.Generator) -> Dict[str, Any]:
        """Options of an arm that begins anew."""
        home = self._home.copy()
        home[0] = random.uniform(-0.5, 0.5)
        stiffness = float(np.exp(random.uniform(np.log(2e3), np.log(50e3))))
        position = np.asarray(self._robot.get_forward_kin(home))[:3]
        gap = random.uniform(0.005, 0.03)
        self._start[arm] = position
        self._held[arm] = 0
        plate = (
            '[[obstacle]]\nname = "plate"\nshape = "plane"\n'
            f"pose = [0, 0, {float(position[2] - gap)!r}, 0, 0, 0]\nstiffness = {stiffness!r}\ndamping = 50.0\n"
        )
        return {"home": home, "cell": plate}

    def speeds(self, actions: _Floats, rows: NDArray[np.void]) -> _Floats:
        """Joint speeds for the actions, rad/s."""
        twists = np.zeros((len(actions), 6))
        twists[:, :3] = self.speed * actions
        return _linear_speeds(self._robot, rows, twists)

    def _force(self, rows: NDArray[np.void]) -> _Floats:
        """Force on the tool along the base axes, N."""
        turned = [_rotation(pose[3:]) @ force[:3] for pose, force in zip(rows["actual_tcp_pose"], rows["tcp_force"])]
        return np.array(turned)

    def observe(self, rows: NDArray[np.void]) -> NDArray[np.float32]:
        """One observation an arm."""
        low, high = self.observation_space.low, self.observation_space.high
        parts = [
            rows["actual_tcp_pose"][:, :3] - self._start,
            rows["actual_tcp_speed"][:, :3],
            self._force(rows) / self.wanted,
            self._held[:, None] / self.lasting,
        ]
        return np.asarray(np.clip(np.concatenate(parts, axis=1), low, high), dtype=np.float32)

    def judge(self, actions: _Floats, rows: NDArray[np.void]) -> Tuple[_Floats, NDArray[np.bool_], NDArray[np.bool_]]:
        """Reward, whether it has ended, and whether well, an arm each."""
        force = self._force(rows)
        off = np.abs(force[:, 2] - self.wanted)
        self._held = np.where(off < self.within, self._held + 1, 0).clip(max=self.lasting)
        failed = (rows["safety_mode"] > MOVING_MODES_MAX) | ((force**2).sum(axis=1) > self.most**2)
        well = (self._held >= self.lasting) & ~failed
        effort = 0.01 * (actions**2).sum(axis=1)
        reward = -np.minimum(off / self.wanted, 2.0) - effort + 1.0 * well - 5.0 * failed
        return reward, well | failed, well


class PickTask(_Task):
    """What ElitePick-v0 asks for, for any number of arms at once."""

    action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)
    observation_space = spaces.Box(
        np.array([-5.0] * 3 + [-10.0] * 3 + [-5.0, 0.0, 0.0], np.float32),
        np.array([5.0] * 3 + [10.0] * 3 + [5.0, 1.0, 1.0], np.float32),
    )
    #: The rim of the cup.
    tcp = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]
    #: m/s of the action 1.
    speed = 0.25
    #: How far the box is to be lifted; below its place by more than that it has fallen, m.
    lifted, fallen = 0.1, 0.02
    #: How fast the cup turns back to looking down, 1/s.
    upright = 2.0
    _vacuum = 0
    _home = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])

    def __init__(self, arms: int, robot: Robot) -> None:
        self._robot = robot
        self._looking = np.zeros((arms, 3, 3))
        self._place = np.zeros((arms, 3))
        self._height = np.zeros(arms)
        self._parts = np.zeros((arms, 7))

    def begin(self, arm: int, random: np.random.Generator) -> Dict[str, Any]:
        """Options of an arm that begins anew."""
        home = self._home.copy()
        home[0] = random.uniform(-0.5, 0.5)
        cup = np.asarray(self._robot.get_forward_kin(home))
        size = [float(x) for x in random.uniform([0.06, 0.06, 0.03], [0.10, 0.10, 0.08])]
        mass = float(random.uniform(0.1, 0.5))
        place = cup[:3] + random.uniform([-0.1, -0.1, -0.2], [0.1, 0.1, -0.1])
        place[2] -= size[2] / 2
        turn = float(random.uniform(-np.pi, np.pi))
        table = [float(cup[0]), float(cup[1]), float(place[2] - size[2] / 2 - 0.025), 0.0, 0.0, 0.0]
        self._looking[arm] = _rotation(cup[3:])
        self._place[arm], self._height[arm] = place, size[2]
        floor = table[2] - 0.5
        cell = (
            f"[world]\nfloor = {floor!r}\n"
            '[tool]\nshape = "cylinder"\nsize = [0.02, 0.08]\npose = [0, 0, 0.04, 0, 0, 0]\n'
            f'[[obstacle]]\nname = "table"\nshape = "box"\nsize = [0.5, 0.5, 0.05]\npose = {table!r}\n'
            f'[[part]]\nname = "box"\nshape = "box"\nsize = {size!r}\nmass = {mass!r}\n'
            f"pose = {[float(x) for x in place] + [0.0, 0.0, turn]!r}\n"
            '[[gripper]]\nname = "cup"\nkind = "vacuum"\ncups = [[0, 0, 0.1]]\nradius = 0.015\n'
            'on = "standard_digital_out[0]"\ngauge = "standard_analog_in[0]"\n'
        )
        return {"home": home, "cell": cell, "tcp": self.tcp}

    def act(self, fleet: Fleet, actions: _Floats) -> None:
        """Switches the vacuum."""
        fleet.set_output(self._vacuum, [bool(on) for on in actions[:, 3] > 0])

    def see(self, fleet: Fleet) -> None:
        """Where the boxes are."""
        self._parts = fleet.part_poses("box").reshape(-1, 7)

    def speeds(self, actions: _Floats, rows: NDArray[np.void]) -> _Floats:
        """Joint speeds for the actions, rad/s."""
        twists = np.zeros((len(actions), 6))
        twists[:, :3] = self.speed * actions[:, :3]
        for twist, pose, wanted in zip(twists, rows["actual_tcp_pose"], self._looking):
            looks = _rotation(pose[3:])
            # Half the sum of these is the sine of the angle to go, along its axis.
            twist[3:] = 0.5 * self.upright * np.cross(looks.T, wanted.T).sum(axis=0)
        return _linear_speeds(self._robot, rows, twists)

    def _to_top(self, rows: NDArray[np.void]) -> _Floats:
        """From the cup to the middle of the top, base axes, m."""
        tops = [_rotation(part[3:6])[:, 2] * height / 2 for part, height in zip(self._parts, self._height)]
        return np.asarray(self._parts[:, :3] + np.array(tops) - rows["actual_tcp_pose"][:, :3])

    def _lift(self) -> _Floats:
        """How far the boxes are above where they stood, m."""
        return np.asarray(self._parts[:, 2] - self._place[:, 2])

    def observe(self, rows: NDArray[np.void]) -> NDArray[np.float32]:
        """One observation an arm."""
        low, high = self.observation_space.low, self.observation_space.high
        parts = [
            self._to_top(rows),
            rows["actual_tcp_speed"][:, :3],
            self._lift()[:, None],
            # The gauge shows the whole pressure as 10 V.
            rows["analog_in"][:, :1] / 10.0,
            self._parts[:, 6:],
        ]
        return np.asarray(np.clip(np.concatenate(parts, axis=1), low, high), dtype=np.float32)

    def judge(self, actions: _Floats, rows: NDArray[np.void]) -> Tuple[_Floats, NDArray[np.bool_], NDArray[np.bool_]]:
        """Reward, whether it has ended, and whether well, an arm each."""
        distance = np.minimum(np.sqrt((self._to_top(rows) ** 2).sum(axis=1)), 1.0)
        lift = self._lift()
        failed = (rows["safety_mode"] > MOVING_MODES_MAX) | (lift < -self.fallen)
        well = (self._parts[:, 6] > 0) & (lift >= self.lifted) & ~failed
        left = np.clip(self.lifted - lift, 0.0, self.lifted)
        effort = 0.01 * (actions**2).sum(axis=1)
        reward = -distance - left - effort + 1.0 * well - 5.0 * failed
        return reward, well | failed, well


_TASKS: Dict[str, Any] = {"EliteReach-v0": ReachTask, "EliteContact-v0": ContactTask, "ElitePick-v0": PickTask}


class _Arms:
    """Arms with a task: begin, step, observe."""

    def __init__(self, env: str, arms: int, threads: int, options: Dict[str, Any]) -> None:
        if env not in _TASKS:
            raise ValueError(f"there is no environment {env!r}; allowed are {', '.join(_TASKS)}")
        own_tcp = _TASKS[env].tcp
        allowed = [name for name in ("model", "plant", "tcp", "payload", "calibration") if name != "tcp" or not own_tcp]
        for name in ("home", "cell", "seed", "record", "step_ms", "tcp"):
            if name in options and name not in allowed:
                raise ValueError(f"{name} is the environment's own; allowed are {', '.join(allowed)}")
        self._options = option_texts(options)
        tcp = own_tcp or options.get("tcp")
        robot = Robot(options.get("model") or "cs66", tcp=tcp, calibration=options.get("calibration"))
        self.task = _TASKS[env](arms, robot)
        self.fleet = Fleet(arms, threads)
        self._rows = np.empty(0, CYCLE_DTYPE)
        self.steps = np.zeros(arms, dtype=np.int64)

    def begin(self, arms: List[int], randoms: List[np.random.Generator]) -> None:
        texts = []
        with tempfile.TemporaryDirectory(prefix="elitescript-") as folder:
            for arm in arms:
                random = randoms[arm]
                given = self.task.begin(arm, random)
                given["seed"] = int(random.integers(1 << 32))
                texts.append({**self._options, **option_texts(given, folder)})
            self.fleet.begin(arms, texts)
        self.steps[arms] = 0

    def rows(self) -> NDArray[np.void]:
        """The latest cycle of each arm."""
        self._rows = self.fleet.states().view(CYCLE_DTYPE)
        self.task.see(self.fleet)
        return self._rows

    def step(self, actions: _Floats) -> NDArray[np.void]:
        speeds = np.asarray(self.task.speeds(actions, self._rows))
        self.task.act(self.fleet, actions)
        self.fleet.step(np.ascontiguousarray(speeds), ACCELERATION, STEP_CYCLES)
        self.steps += 1
        return self.rows()


def _clipped(actions: Any, shape: Tuple[int, ...]) -> _Floats:
    array = np.asarray(actions, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"action must have shape {shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("action must be finite")
    # All spaces of actions are -1 to 1.
    return np.minimum(np.maximum(array, -1.0), 1.0)


class EliteEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """One arm. ``gymnasium.make("EliteReach-v0")`` makes it, with options of ``Controller`` for the arm."""

    metadata: Dict[str, Any] = {"render_modes": []}

    def __init__(self, env: str = "EliteReach-v0", render_mode: Optional[str] = None, **options: Any) -> None:
        if render_mode is not None:
            raise ValueError(f"there are no render modes, got {render_mode!r}")
        self._arms = _Arms(env, 1, 1, options)
        self.render_mode = None
        self.action_space = self._arms.task.action_space
        self.observation_space = self._arms.task.observation_space

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[NDArray[np.float32], Dict[str, Any]]:
        super().reset(seed=seed)
        self._arms.begin([0], [self.np_random])
        return self._arms.task.observe(self._arms.rows())[0], {}

    def step(self, action: NDArray[np.float32]) -> Tuple[NDArray[np.float32], float, bool, bool, Dict[str, Any]]:
        actions = _clipped(action, self.action_space.shape)[None]  # type: ignore[arg-type]
        rows = self._arms.step(actions)
        reward, ended, well = self._arms.task.judge(actions, rows)
        cut = bool(self._arms.steps[0] >= STEPS_MAX) and not ended[0]
        observation = self._arms.task.observe(rows)[0]
        return observation, float(reward[0]), bool(ended[0]), cut, {"is_success": bool(well[0])}

    def close(self) -> None:
        self._arms.fleet.close()


class EliteVectorEnv(VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """Many arms that are stepped together; ``make_vec`` makes it. An arm that ended begins anew in the next step."""

    metadata: Dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(self, n: int, env: str, seed: int, threads: Optional[int], options: Dict[str, Any]) -> None:
        if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or not 1 <= n <= 4096:
            raise ValueError(f"n must be a whole number from 1 to 4096, got {n!r}")
        self.num_envs = int(n)
        self._arms = _Arms(env, self.num_envs, threads or os.cpu_count() or 1, options)
        task = self._arms.task
        self.single_action_space, self.single_observation_space = task.action_space, task.observation_space
        self.action_space = batch_space(task.action_space, self.num_envs)
        self.observation_space = batch_space(task.observation_space, self.num_envs)
        self.render_mode = None
        self.spec = None
        self._seed = seed
        self._randoms: List[np.random.Generator] = []
        self._over = np.zeros(self.num_envs, dtype=bool)

    def reset(
        self, *, seed: Optional[Union[int, List[Optional[int]]]] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[NDArray[np.float32], Dict[str, Any]]:
        if seed is None and not self._randoms:
            seed = self._seed
        if seed is not None:
            seeds = [seed + k for k in range(self.num_envs)] if isinstance(seed, (int, np.integer)) else list(seed)
            if len(seeds) != self.num_envs:
                raise ValueError(f"seed must be one number or {self.num_envs}, got {len(seeds)}")
            self._randoms = [np.random.Generator(np.random.PCG64(np.random.SeedSequence(s))) for s in seeds]
        self._arms.begin(list(range(self.num_envs)), self._randoms)
        self._over[:] = False
        return self._arms.task.observe(self._arms.rows()), {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> Tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], Dict[str, Any]]:
        if not self._randoms:
            raise RuntimeError("reset() comes before step()")
        shape = (self.num_envs,) + self.single_action_space.shape  # type: ignore[operator]
        clipped = _clipped(actions, shape)
        again = self._over.copy()
        # Whoever begins anew stands still meanwhile; its action does not count.
        clipped[again] = 0.0
        rows = self._arms.step(clipped)
        task = self._arms.task
        if again.any():
            self._arms.begin([int(k) for k in np.flatnonzero(again)], self._randoms)
            rows = self._arms.rows()
        reward, ended, well = task.judge(clipped, rows)
        reward[again], ended[again], well[again] = 0.0, False, False
        cut = (self._arms.steps >= STEPS_MAX) & ~ended & ~again
        self._over = ended | cut
        return task.observe(rows), reward, ended, cut, {"is_success": well}

    def close_extras(self, **kwargs: Any) -> None:
        self._arms.fleet.close()


def make_vec(
    n: int, env: str = "EliteReach-v0", seed: int = 0, *, threads: Optional[int] = None, **options: Any
) -> EliteVectorEnv:
    """n arms that are stepped together on every core (or ``threads``); the i-th has the seed ``seed + i``.

    options: those of ``Controller`` for the arm: model, plant, tcp, payload, calibration;
    ElitePick-v0 has a TCP of its own.
    """
    return EliteVectorEnv(n, env, seed, threads, options)


for _name in _TASKS:
    if _name not in gymnasium.registry:
        gymnasium.register(id=_name, entry_point="elitescript.gym:EliteEnv", kwargs={"env": _name})
