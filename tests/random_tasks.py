"""Tasks for tests: random ones, with the directions that are special among them, and a plain one."""

import arms
import numpy as np

COUNT = 100_000
X, Y, Z = np.eye(3)
GOOD = {"position": [0.4, 0, 0], "velocity": X, "force": Z}


def length(a):
    return np.linalg.norm(a, axis=-1)


def unit(a):
    return a / length(a)[..., None]


def dot(a, b):
    return np.sum(a * b, axis=-1)


def tasks_of(name, count=COUNT, salt=0):
    """Positions in 1.2 times the reach, and directions: random, parallel, along the target, in level planes."""
    arm, rng = arms.load(name), arms.generator(name, 900 + salt)
    limb = arm.limb
    reach = limb.upper_arm + limb.forearm + limb.hand
    offset = unit(rng.normal(size=(count, 3))) * (1.2 * reach * rng.uniform(size=count) ** (1 / 3))[:, None]
    v, f, g, phi = (rng.normal(size=(count, 3)) * rng.uniform(1e-3, 1e3, (count, 1)) for _ in range(4))
    kind = np.arange(count) % 16
    f[kind == 1] = -2.5 * v[kind == 1]
    offset[kind == 2] = 0.4 * unit(np.cross(v, f)[kind == 2])
    offset[kind == 3] = 0.0
    offset[kind == 4] = limb.hand * unit(g)[kind == 4]
    v[kind == 5] = Z
    f[kind == 5] = 3.0 * Z
    offset[kind == 6] = [[0.5, 0.0, 0.1]]
    v[kind == 6], f[kind == 6] = X, Z
    offset[kind == 7] *= 1e-14
    offset[kind == 8] *= 1e14
    return limb.shoulder + offset, v, f, g, phi


def grasps(g, phi):
    return {"none": {}, "grasp": {"grasp": g}, "grasp and roll": {"grasp": g, "pronosupination": phi}}
