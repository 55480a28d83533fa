"""Environments: gymnasium's own checks, seeds, one by one and together."""

import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from elitescript.gym import make_vec  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

NAMES = ["EliteReach-v0", "EliteContact-v0", "ElitePick-v0"]


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_finds_nothing_wrong(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*spec.*|.*not within.*minimum and maximum.*")
        check_env(gymnasium.make(name).unwrapped)


@pytest.mark.parametrize("name", NAMES)
def test_one_by_one_and_together_are_the_same(name):
    n, steps = 3, 12
    vec = make_vec(n, name, seed=7, threads=2)
    observations, _ = vec.reset()
    actions = np.random.default_rng(1).uniform(-1, 1, (steps, n) + vec.single_action_space.shape).astype(np.float32)
    together = [observations]
    for step in range(steps):
        observations, rewards, ended, cut, _ = vec.step(actions[step])
        together.append((observations, rewards, ended, cut))
    vec.close()
    for k in range(n):
        env = gymnasium.make(name, disable_env_checker=True)
        observation, _ = env.reset(seed=7 + k)
        np.testing.assert_array_equal(observation, together[0][k])
        for step in range(steps):
            observation, reward, ended, cut, _ = env.step(actions[step][k])
            np.testing.assert_array_equal(observation, together[step + 1][0][k])
            assert (reward, ended, cut) == tuple(part[k] for part in together[step + 1][1:])
            if ended or cut:
                break
        env.close()


def test_going_there_pays():
    env = gymnasium.make("EliteReach-v0").unwrapped
    observation, _ = env.reset(seed=2)
    robot = env._arms.task._robot
    first = np.linalg.norm(observation[12:15] - observation[15:18])
    total, ended = 0.0, False
    for _ in range(250):
        jacobian = np.asarray(robot.jacobian(observation[:6].astype(float)))[:3]
        towards = 3.0 * (observation[15:18] - observation[12:15])
        action = np.linalg.lstsq(jacobian, towards, rcond=0.05)[0]
        observation, reward, ended, cut, info = env.step(np.clip(action, -1, 1).astype(np.float32))
        total += reward
        if ended or cut:
            break
    assert ended and info["is_success"] and first > 0.05
    env.close()


def picked(seed, stop_at=250):
    """An episode of a simple policy: over the box, down with the vacuum, up. Its observations, and how it ended."""
    env = gymnasium.make("ElitePick-v0").unwrapped
    observation, _ = env.reset(seed=seed)
    observations, rewards, ended, info = [observation], [], False, {}
    for _ in range(stop_at):
        way, held = observation[:3], observation[8] > 0
        action = np.zeros(4, np.float32)
        if held:
            action[:] = [0, 0, 0.6, 1]
        else:
            over = np.linalg.norm(way[:2]) < 0.004
            action[:2] = np.clip(12 * way[:2], -1, 1)
            action[2] = np.clip(8 * way[2], -0.8, -0.04) if over else 0
            action[3] = 1 if over else -1
        observation, reward, ended, cut, info = env.step(action)
        assert env.observation_space.contains(observation)
        observations.append(observation)
        rewards.append(reward)
        if ended or cut:
            break
    env.close()
    return np.array(observations), rewards, ended, info


@pytest.mark.parametrize("seed", range(6))
def test_a_box_is_picked(seed):
    observations, rewards, ended, info = picked(seed)
    assert ended and info["is_success"]
    assert observations[0][8] == 0 and observations[0][6] == pytest.approx(0, abs=1e-4)
    assert observations[-1][8] == 1 and observations[-1][6] >= 0.1
    # The vacuum had built up, and the end pays.
    assert observations[-1][7] > 0.9 and rewards[-1] > 0.9 and rewards[0] < -0.1


def test_a_seed_gives_the_same_box_every_time():
    first, second, other = picked(3), picked(3), picked(4)
    np.testing.assert_array_equal(first[0], second[0])
    assert first[1] == second[1]
    assert not np.array_equal(first[0][0], other[0][0])


def test_a_box_that_is_let_go_is_not_picked():
    env = gymnasium.make("ElitePick-v0").unwrapped
    observation, _ = env.reset(seed=1)
    held = []
    for step in range(250):
        way = observation[:3]
        action = np.array([0, 0, 0.5, 1], np.float32)
        if len(held) >= 8:
            # Without vacuum the box falls back on the table.
            action[3] = -1
        elif observation[8] == 0:
            over = np.linalg.norm(way[:2]) < 0.004
            action[:2] = np.clip(12 * way[:2], -1, 1)
            action[2] = np.clip(8 * way[2], -0.8, -0.04) if over else 0
        observation, reward, ended, cut, info = env.step(action)
        if observation[8] > 0:
            held.append(observation[6])
        if len(held) >= 8 and observation[8] == 0:
            break
    lifted = observation[6]
    assert 0 < lifted < 0.1 and not ended
    for _ in range(15):
        observation, reward, ended, cut, info = env.step(np.array([0, 0, 0, -1], np.float32))
    assert observation[6] == pytest.approx(0, abs=2e-3) and observation[7] == 0 and not info["is_success"]
    env.close()


def test_a_cup_that_is_driven_into_the_table_costs():
    env = gymnasium.make("ElitePick-v0").unwrapped
    observation, _ = env.reset(seed=1)
    for _ in range(250):
        # Past the box, and down.
        action = np.array([1, 0, 0, -1] if observation[0] > -0.12 else [0, 0, -1, -1], np.float32)
        observation, reward, ended, cut, info = env.step(action)
        if ended or cut:
            break
    assert ended and reward < -5 and not info["is_success"]
    env.close()


def test_an_arm_that_ended_begins_anew():
    vec = make_vec(2, "EliteContact-v0", seed=1)
    vec.reset()
    down = np.tile(np.array([0, 0, -1], np.float32), (2, 1))
    over = np.zeros(2, bool)
    for _ in range(60):
        observations, rewards, ended, cut, info = vec.step(down)
        assert vec.observation_space.contains(observations)
        if over.any():
            assert (rewards[over] == 0).all() and (np.abs(observations[over, :3]) < 1e-3).all()
            break
        over = ended | cut
    assert over.any()
    vec.close()


def test_what_does_not_fit_is_said():
    for call in (
        lambda: make_vec(0),
        lambda: make_vec(2, "EliteFly-v0"),
        lambda: make_vec(2, home=[0] * 6),
        lambda: make_vec(2, model="cs99"),
        lambda: make_vec(2, "ElitePick-v0", tcp=[0, 0, 0.2, 0, 0, 0]),
        lambda: gymnasium.make("EliteReach-v0", plant="soft").reset(),
    ):
        with pytest.raises(ValueError):
            call()
    vec = make_vec(2, plant="ideal")
    with pytest.raises(RuntimeError, match="reset"):
        vec.step(np.zeros((2, 6)))
    vec.reset()
    for wrong in (np.zeros((3, 6)), np.full((2, 6), np.nan)):
        with pytest.raises(ValueError, match="action"):
            vec.step(wrong)
