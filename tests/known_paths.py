"""Motions that are known, and whether paths through their poses are as good."""

import numpy as np
from arms import forward


def known_motion(arm, rng, count, step):
    """(count, 7) angles inside the limits: two sines a joint, the largest joint step as given."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -4.0)
    upper = np.minimum(arm.upper, lower + 8.0)
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
    """(n, 4, 4) poses of the tip along joint angles (n, 7)."""
    return np.array([arm.forward_kinematics(q).homogeneous for q in known])


def total(path, seed):
    """Squared joint steps of a path, that from its seed included, rad^2."""
    squares = (path.steps**2).sum()
    return squares if seed is None else squares + ((path.q[0] - seed) ** 2).sum()


def assert_as_good(path, seed, known, room=1e-6):
    """A path is whole, and its squared steps come to no more than those of a known motion, but for a part of them."""
    assert path
    assert total(path, seed) <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + room)


def assert_known_is_no_better(arm, known):
    """Paths through the poses of a known motion are as good, from its first posture and from any."""
    for seed in (known[0], None):
        assert_as_good(arm.solve_path(poses_of(arm, known), seed=seed), seed, known)


def assert_on_poses(name, arm, poses, path):
    """A path meets its poses inside the limits, as Pinocchio has it."""
    assert path.ok.all()
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
    for pose, q in zip(poses, path.q, strict=True):
        assert np.abs(forward(name)(q).homogeneous - pose).max() < 1e-8
