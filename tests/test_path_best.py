"""Joint paths are the best there are: against brute force, and never worse than a motion that is known."""

import numpy as np
import pytest
from arms import forward, generator, load
from path_oracle import best_path, swept_postures

LONGEST = 0.5


def known_motion(arm, rng, count, step):
    """(count, 7) angles inside the limits: two sines a joint, the largest joint step as given."""
    lower, upper = np.maximum(arm.lower, -4.0), np.minimum(arm.upper, 4.0)
    size = 0.5 * (upper - lower) * rng.uniform(0.3, 1.1, 7)
    middle = 0.5 * (lower + upper)
    middle = middle + np.maximum(0.5 * (upper - lower) - size, 0.0) * rng.uniform(-1.0, 1.0, 7)
    share, rate = rng.uniform(0.2, 0.8, 7), rng.uniform(3.0, 12.0, (2, 7))
    start = rng.uniform(0.0, 6.3, (2, 7))

    def at(t):
        first, second = np.sin(rate[:, None] * t[:, None] + start[:, None])
        return np.clip(middle + size * (share * first + (1.0 - share) * second), lower, upper)

    rough = np.abs(np.diff(at(np.linspace(0.0, 1.0, 400)), axis=0)).max() * 399
    return at(np.linspace(0.0, step * (count - 1) / rough, count))


def poses_of(arm, known):
    return np.array([arm.forward_kinematics(q).homogeneous for q in known])


def total(path, seed):
    squares = (path.steps**2).sum()
    return squares if seed is None else squares + ((path.q[0] - seed) ** 2).sum()


def assert_on_poses(name, arm, poses, path):
    assert path.ok.all()
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
    for pose, q in zip(poses, path.q, strict=True):
        assert np.abs(forward(name)(q).homogeneous - pose).max() < 1e-8


@pytest.mark.parametrize("name", ["iiwa14", "human_left", "sia10f", "openarm_left", "gen3"])
@pytest.mark.parametrize("seeded", [True, False])
def test_a_known_motion_is_never_better(name, seeded):
    arm, rng = load(name), generator(name, 31)
    for _ in range(8 if name != "gen3" else 3):
        known = known_motion(arm, rng, 100, rng.uniform(0.05, 0.14))
        poses = poses_of(arm, known)
        seed = known[0] if seeded else None
        path = arm.solve_path(poses, seed=seed)
        assert not path.breaks
        assert_on_poses(name, arm, poses, path)
        assert total(path, seed) <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + 1e-6)


@pytest.mark.parametrize("name", ["iiwa14", "human_left", "sia10f", "openarm_left"])
def test_brute_force_finds_nothing_better(name):
    """As many breaks as an exhaustive search over a fine sweep, and no larger sum."""
    arm, rng = load(name), generator(name, 32)
    for case in range(4):
        known = known_motion(arm, rng, 10, rng.uniform(0.1, 0.3))
        if case == 3:
            # No motion leads from one half to the other: a break, wherever it costs least.
            known[5:] = known_motion(arm, rng, 5, 0.1)
        poses = poses_of(arm, known)
        seed = known[0] if case % 2 else None
        nodes = [swept_postures(arm, pose, 360) for pose in poses]
        breaks, least = best_path(arm, nodes, seed, LONGEST)
        path = arm.solve_path(poses, seed=seed)
        assert len(path.breaks) <= breaks
        if len(path.breaks) == breaks:
            assert total(path, seed) <= least * (1.0 + 1e-3)
