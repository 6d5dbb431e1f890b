"""The paper's own equations for its limb (ZYX shoulder, elbow, XYZ wrist), corrected where they do not compute.

Tiseo, Charitos, Mistry, "Geometrical Postural Optimisation of 7-DoF Limb-Like Manipulators": WristPosition, geomOptim,
geomOptimB, IKShoulder, IKElbow, Wrist, and the forward kinematics of its experiment on accuracy. Errata are numbered as
in docs/task.md. NumPy alone; nothing here knows of the package.
"""

from __future__ import annotations

import numpy as np

ARM, FOREARM, HAND = 0.37, 0.32, 0.10


def unit(a):
    return a / np.linalg.norm(a)


def turned(R, q):
    """R rot_z(q)."""
    c, s = np.cos(q), np.sin(q)
    return R @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def angle(a, R):
    """atan2(a . R_y, a . R_x)."""
    return np.arctan2(a @ R[:, 1], a @ R[:, 0])


def columns(x, y, z):
    return np.stack([x, y, z], axis=1)


def geometric_posture(x_d, v, f, g=None, left=True):
    """Elbow and wrist of a target within reach, seen from the shoulder: geomOptim, or geomOptimB without a grasp."""
    n = unit(np.cross(v, f))
    base = x_d if g is None else x_d - HAND * g
    lower = FOREARM + HAND if g is None else FOREARM
    d = np.linalg.norm(base)
    t = base / d  # erratum 7: the elbow's foot lies on the line to x_d where there is no grasp
    h = unit(np.cross(t, n))
    foot = d / 2 + ARM**2 * (1 - (lower / ARM) ** 2) / (2 * d)
    mu = np.sqrt(ARM**2 - foot**2)  # erratum 1
    minus = h[1] < 0  # erratum 2: the two conditions joined by "or", away from the tie h_y = 0
    if not left:
        minus = not minus
    x_e = foot * t + (-mu if minus else mu) * h
    x_w = base if g is not None else x_e + FOREARM * unit(x_d - x_e)
    return x_e, x_w


def inverse(x_e, x_w, g, phi, sign_corrected=True):
    """Seven joint angles for elbow, wrist, grasp and pronosupination direction, phi across g."""
    forearm = x_w - x_e
    R = np.eye(3)
    q = np.zeros(7)
    q[0] = angle(x_e, R)
    R = turned(R, q[0])
    R = columns(R[:, 0], -R[:, 2], R[:, 1])
    q[1] = angle(x_e, R)
    R = turned(R, q[1])
    R = columns(-R[:, 2], R[:, 1], R[:, 0])
    q[2] = angle(forearm, R)  # erratum 3: x_e lies on this axis
    R = turned(R, q[2])
    R = columns(R[:, 2], -R[:, 0], -R[:, 1])
    q[3] = angle(forearm, R)  # erratum 4: no difference of unit vectors
    R_4 = turned(R, q[3])
    R_45 = columns(R_4[:, 2], -R_4[:, 1], R_4[:, 0])
    q[4] = angle(np.cross(g, np.cross(phi, g)), R_45)
    R_7 = wrist(R_45, g, q)
    if sign_corrected and R_7[:, 2] @ phi < 0.0:  # erratum 6: q_5 fixes phi up to its sign
        q[4] += np.pi
        wrist(R_45, g, q)
    return q


def wrist(R_45, g, q):
    """q_6 and q_7 behind a given q_5, into q; R_7."""
    R = turned(R_45, q[4])
    R = columns(R[:, 2], R[:, 0], R[:, 1])  # erratum 5: not printed
    q[5] = angle(g, R)
    R = turned(R, q[5])
    R = columns(R[:, 0], -R[:, 2], R[:, 1])
    q[6] = angle(g, R)
    return turned(R, q[6])


def forward(q):
    """Elbow, wrist and hand seen from the shoulder, and R_7."""
    R = turned(np.eye(3), q[0])
    R = turned(columns(R[:, 0], -R[:, 2], R[:, 1]), q[1])
    R = turned(columns(-R[:, 2], R[:, 1], R[:, 0]), q[2])
    x_e = ARM * R[:, 2]
    R = turned(columns(R[:, 2], -R[:, 0], -R[:, 1]), q[3])
    x_w = x_e + FOREARM * R[:, 0]
    R = turned(columns(R[:, 2], -R[:, 1], R[:, 0]), q[4])
    R = turned(columns(R[:, 2], R[:, 0], R[:, 1]), q[5])
    R = turned(columns(R[:, 0], -R[:, 2], R[:, 1]), q[6])
    return x_e, x_w, x_w + HAND * R[:, 0], R
