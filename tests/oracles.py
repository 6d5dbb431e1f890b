"""References that share no code with the package: Pinocchio on whole robots, plain NumPy geometry, random limbs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from hypothesis import strategies as st

TURN = 2.0 * np.pi


class Forward:
    """Forward kinematics by Pinocchio on a whole robot as it is described, all other joints at neutral."""

    def __init__(self, source: Path | pin.Model, base: str, tip: str, joint_names: Sequence[str]) -> None:
        self.model = source if isinstance(source, pin.Model) else whole_robot(source)
        self.data = self.model.createData()
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in joint_names]
        self.base, self.tip = (frame_index(self.model, name) for name in (base, tip))
        self._zero = None

    def __call__(self, q: np.ndarray) -> pin.SE3:
        self._place(q)
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip])

    def carried(self, q: np.ndarray, joint: int, point: np.ndarray) -> np.ndarray:
        """Where joint 1 to 7 takes a point of the zero configuration, both in the base frame."""
        if self._zero is None:
            self._place(np.zeros(7))
            self._zero = [self.data.oMi[j.id].copy() for j in self.joints]
        zero = self._zero[joint - 1]
        self._place(q)
        T_world_base = self.data.oMf[self.base]
        now = self.data.oMi[self.joints[joint - 1].id]
        return T_world_base.actInv(now.act(zero.actInv(T_world_base.act(point))))

    def _place(self, q: np.ndarray) -> None:
        configuration = pin.neutral(self.model)
        for angle, joint in zip(q, self.joints, strict=True):
            values = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            configuration[joint.idx_q : joint.idx_q + joint.nq] = values
        pin.framesForwardKinematics(self.model, self.data, configuration)


def whole_robot(path: Path) -> pin.Model:
    """The file as it is, but for negative effort or velocity limits: Pinocchio refuses them, and no pose needs them."""
    text = path.read_text()
    if re.search(r'(effort|velocity)="-', text):
        return pin.buildModelFromXML(re.sub(r'(effort|velocity)="-[\d.]+"', r'\1="0"', text))
    return pin.buildModelFromUrdf(str(path))


def frame_index(model: pin.Model, name: str) -> int:
    """The link of a name, or whatever else bears it."""
    return model.getFrameId(name, pin.BODY) if model.existFrame(name, pin.BODY) else model.getFrameId(name)


def distance(wanted: pin.SE3, reached: pin.SE3) -> tuple[float, float]:
    """Metres and radians between two poses; the angle without the loss of digits of an arc cosine."""
    turn = wanted.rotation.T @ reached.rotation
    skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = np.arctan2(np.linalg.norm(skew), np.trace(turn) - 1.0)
    return float(np.linalg.norm(wanted.translation - reached.translation)), float(angle)


def wrapped(angle: np.ndarray) -> np.ndarray:
    """The turn in [-pi, pi)."""
    return (np.asarray(angle) + np.pi) % TURN - np.pi


def inside(q: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
    return bool((q >= lower).all() and (q <= upper).all())


def room(q: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """How far each angle of (..., 7), in the turn that suits it best, lies inside its limits; negative outside."""
    best = np.full(np.shape(q), -np.inf)
    for turns in range(-4, 5):
        turned = wrapped(q) + TURN * turns
        best = np.maximum(best, np.minimum(turned - lower, upper - turned))
    return best


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    return pin.exp3(np.asarray(axis) * angle)


def geometric_arm_angle(S: np.ndarray, E: np.ndarray, W: np.ndarray, reference: np.ndarray) -> float:
    """Angle about S->W, right-handed, from the half-plane of the reference direction to that of the elbow."""
    along = (W - S) / np.linalg.norm(W - S)
    zero = reference - along * (along @ reference)
    elbow = (E - S) - along * (along @ (E - S))
    return float(np.arctan2(along @ np.cross(zero, elbow), zero @ elbow))


def arm_angle(forward: Forward, limb, q: np.ndarray) -> float:
    """Arm angle of a configuration from the places of elbow and wrist, which Pinocchio gives."""
    return geometric_arm_angle(
        limb.shoulder, forward.carried(q, 4, limb.elbow), forward.carried(q, 7, limb.wrist), limb.reference
    )


def middle_phase(a1: np.ndarray, a2: np.ndarray, a3: np.ndarray) -> float:
    """The angle of the middle joint of three that brings the outer two axes as close to parallel as can be."""
    at = [float(a1 @ rotation(a2, angle) @ a3) for angle in (0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi)]
    return float(np.arctan2(at[1] - at[3], at[0] - at[2]))


def phases(limb):
    """Singular angles of joints 2, 4 and 6."""
    a4, S, E, W = limb.axes[3], limb.shoulder, limb.elbow, limb.wrist
    back, forth = ((p - E) - a4 * (a4 @ (p - E)) for p in (S, W))
    straight = np.arctan2(a4 @ np.cross(forth, -back), forth @ -back)
    found = {1: middle_phase(*limb.axes[:3]), 3: straight, 5: middle_phase(*limb.axes[4:])}
    # Exactly zero where it is zero but for rounding: that is where people put their arms.
    return {joint: 0.0 if abs(angle) < 1e-12 else angle for joint, angle in found.items()}


def reaches(axes: np.ndarray, R: np.ndarray) -> float:
    """How far inside its reach three axes through one point make a rotation: negative where they cannot."""
    a1, a2, a3 = axes
    alpha = np.arctan2(np.linalg.norm(np.cross(a1, a2)), a1 @ a2)
    beta = np.arctan2(np.linalg.norm(np.cross(a2, a3)), a2 @ a3)
    wanted = R @ a3
    gamma = np.arctan2(np.linalg.norm(np.cross(a1, wanted)), a1 @ wanted)
    return float(min(gamma - abs(alpha - beta), min(alpha + beta, TURN - alpha - beta) - gamma))


def other_elbow_reaches(limb, q: np.ndarray) -> float:
    """For a configuration of an exact limb: `reaches` of the posture with the elbow folded the other way."""
    S, E, W, a4 = limb.shoulder, limb.elbow, limb.wrist, limb.axes[3]

    def flat(v: np.ndarray) -> np.ndarray:
        return v - a4 * (a4 @ v)

    e, f = flat(S - E), flat(W - E)
    bend = np.arctan2(a4 @ np.cross(-e, f), -e @ f)
    q4 = -2.0 * bend - q[3]
    Rs = rotation(limb.axes[0], q[0]) @ rotation(limb.axes[1], q[1]) @ rotation(limb.axes[2], q[2])
    Rw = rotation(limb.axes[4], q[4]) @ rotation(limb.axes[5], q[5]) @ rotation(limb.axes[6], q[6])
    hand = Rs @ rotation(a4, q[3]) @ Rw

    def triangle(angle: float) -> np.ndarray:
        along = E + rotation(a4, angle) @ (W - E) - S
        along = along / np.linalg.norm(along)
        side = (E - S) - along * (along @ (E - S))
        side = side / np.linalg.norm(side)
        return np.column_stack([along, side, np.cross(along, side)])

    Rs_other = Rs @ triangle(q[3]) @ triangle(q4).T
    Rw_other = rotation(a4, -q4) @ Rs_other.T @ hand
    return min(reaches(limb.axes[:3], Rs_other), reaches(limb.axes[4:], Rw_other))


@dataclass(frozen=True, eq=False)
class RandomLimb:
    """A limb of random axes as a `pinocchio.Model` with the frames "base" and "tool".

    Attributes:
        model: the model.
        axes: (7, 3) directions at zero in the world frame.
        points: (7, 3) points on the axes at zero in the world frame.
        centres: (3, 3) shoulder centre, a point of axis 4, wrist centre in the world frame.
        lower: (7,) rad, -inf where continuous.
        upper: (7,) rad, inf where continuous.
        rng: where further figures of this case come from.
    """

    model: pin.Model
    axes: np.ndarray
    points: np.ndarray
    centres: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    rng: np.random.Generator

    def configuration(self) -> np.ndarray:
        """Random angles inside the limits."""
        return random_angles(self.rng, self.lower, self.upper)


def closed_by_newton(arm, pose: pin.SE3, q: np.ndarray, t: np.ndarray, place: float) -> np.ndarray | None:
    """The posture for a pose with t'q = place, by Pinocchio's Jacobian; None where steps do not settle."""
    for _ in range(8):
        here = arm.forward_kinematics(q)
        off = np.r_[pose.translation - here.translation, pin.log3(pose.rotation @ here.rotation.T), place - t @ q]
        step = np.linalg.solve(np.vstack([arm.jacobian(q), t]), off)
        q = q + step
        if np.abs(step).max() < 1e-9:
            return q
    return None


def way_of_curve(arm, q: np.ndarray, near: np.ndarray) -> tuple[np.ndarray, float]:
    """The unit vector along the curve through a posture, on the side of a vector, and its orientation."""
    t = np.linalg.solve(np.vstack([arm.jacobian(q), near]), np.eye(7)[6])
    return t / np.linalg.norm(t), np.sign(np.linalg.det(np.vstack([arm.jacobian(q), t])))


def postures_by_steps(arm, pose: pin.SE3, q: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """The closed curve through a posture, followed in steps of at most 0.01 rad: postures, and ways there."""
    start, (t, side) = q, way_of_curve(arm, q, np.linalg.svd(arm.jacobian(q))[2][6])
    postures, ways, step = [q], [t], 1e-3
    while len(postures) < 10 or np.linalg.norm(wrapped(q - start)) > 0.8 * step or t @ ways[0] < 0.0:
        there = closed_by_newton(arm, pose, q + step * t, t, t @ q + step)
        if there is not None:
            next_t, next_side = way_of_curve(arm, there, t)
            if next_t @ t > 0.995 and next_side == side and np.linalg.norm(there - q) < 1.05 * step:
                q, t, step = there, next_t, min(1.4 * step, 0.01)
                postures.append(q)
                ways.append(t)
                continue
        step *= 0.5
        assert step > 1e-10
    return postures, ways


def random_angles(rng: np.random.Generator, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Angles inside limits; where there is none, anywhere within a turn."""
    return rng.uniform(np.where(np.isfinite(lower), lower, -np.pi), np.where(np.isfinite(upper), upper, np.pi))


def unit(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def angle_sine(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm(np.cross(a, b)))


def _spherical_axes(rng: np.random.Generator, pattern: str) -> np.ndarray:
    """Three axes, each well away from parallel to the one before."""
    while True:
        if pattern == "oblique":
            axes = np.array([unit(rng) for _ in range(3)])
        else:
            Q, _ = np.linalg.qr(rng.normal(size=(3, 3))) if pattern == "tilted" else (np.eye(3), None)
            axes = np.array([rng.choice([-1.0, 1.0]) * Q[:, k] for k in rng.integers(0, 3, 3)])
        if min(angle_sine(axes[0], axes[1]), angle_sine(axes[1], axes[2])) > 0.2:
            return axes


def _limits(rng: np.random.Generator, style: str) -> tuple[float, float]:
    """One joint's limits."""
    if style == "mixed":
        style = str(rng.choice(["usual", "narrow", "wide", "beyond", "continuous"]))
    if style == "usual":
        return -float(rng.uniform(0.5, 3.0)), float(rng.uniform(0.5, 3.0))
    if style == "narrow":
        lower = rng.uniform(-3.0, 3.0)
        return float(lower), float(lower + 10.0 ** rng.uniform(-4.0, 0.0))
    if style == "wide":
        return -float(rng.uniform(3.0, 7.0)), float(rng.uniform(3.0, 7.0))
    if style == "beyond":
        lower = rng.uniform(-9.0, 6.0)
        return float(lower), float(lower + rng.uniform(0.5, 4.0))
    return -np.inf, np.inf


def random_limb(
    seed: int, pattern: str = "oblique", elbow: str = "offset", limits: str = "mixed", miss: float = 0.0
) -> RandomLimb:
    """A random limb.

    Args:
        seed: of the random figures.
        pattern: spherical axes along the "coordinate" axes, in a "tilted" orthogonal frame, or "oblique" to each other.
        elbow: "straight" with axis 4 across the line of upper arm and forearm, "offset" with axis 4 anywhere.
        limits: "usual", "narrow", "wide", "beyond" (half a turn), "continuous", or "mixed" of these.
        miss: how far axes are moved off their centres at most, as a part of the length shoulder-elbow-wrist.
    """
    rng = np.random.default_rng(seed)
    axes = np.vstack([_spherical_axes(rng, pattern), unit(rng)[None], _spherical_axes(rng, pattern)])
    size = 10.0 ** rng.uniform(-0.7, 0.3)
    S = rng.normal(size=3)
    while True:
        upper_arm, forearm = unit(rng) * size * rng.uniform(0.4, 1.0), unit(rng) * size * rng.uniform(0.4, 1.0)
        if elbow == "straight":
            forearm = upper_arm / np.linalg.norm(upper_arm) * np.linalg.norm(forearm)
            across = np.cross(upper_arm, unit(rng))
            axes[3] = across / np.linalg.norm(across)
        if min(np.linalg.norm(np.cross(axes[3], v)) for v in (upper_arm, forearm)) > 0.3 * size:
            break
        axes[3] = unit(rng)
    E, W = S + upper_arm, S + upper_arm + forearm
    centres = np.array([S, E, W])
    points = np.array([(S, S, S, E, W, W, W)[k] + axes[k] * rng.normal() * size for k in range(7)])
    largest = miss * (np.linalg.norm(upper_arm) + np.linalg.norm(forearm))
    for k in (0, 1, 2, 4, 5, 6):
        points[k] += unit(rng) * rng.uniform(0.0, largest)
    bounds = np.array([_limits(rng, limits) for _ in range(7)])
    model = pin.Model()
    model.name = f"random_{seed}"
    parent, T_world_parent = 0, pin.SE3.Identity()
    for k in range(7):
        limited = bool(np.isfinite(bounds[k]).all())
        turn = random_rotation(rng) if limited else x_along(axes[k])
        T_world_joint = pin.SE3(turn, points[k])
        joint = pin.JointModelRevoluteUnaligned(turn.T @ axes[k]) if limited else pin.JointModelRUBX()
        lower, upper = (bounds[k][:1], bounds[k][1:]) if limited else (-1.1 * np.ones(2), 1.1 * np.ones(2))
        placement = T_world_parent.actInv(T_world_joint)
        parent = model.addJoint(parent, joint, placement, f"joint_{k + 1}", np.ones(1), np.ones(1), lower, upper)
        T_world_parent = T_world_joint
    T_world_base = pin.SE3(random_rotation(rng), rng.normal(size=3))
    T_joint_tool = pin.SE3(random_rotation(rng), rng.normal(size=3) * 0.2 * size)
    model.addFrame(pin.Frame("base", 0, 0, T_world_base, pin.OP_FRAME))
    model.addFrame(pin.Frame("tool", parent, 0, T_joint_tool, pin.OP_FRAME))
    return RandomLimb(model, axes, points, centres, bounds[:, 0].copy(), bounds[:, 1].copy(), rng)


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=4)
    return pin.Quaternion(*(v / np.linalg.norm(v))).matrix()


def x_along(axis: np.ndarray) -> np.ndarray:
    """A rotation whose first column is a unit vector."""
    y = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    y /= np.linalg.norm(y)
    return np.column_stack([axis, y, np.cross(axis, y)])


def limbs(miss: float = 0.0, limits: Sequence[str] = ("usual", "narrow", "wide", "beyond", "continuous", "mixed")):
    """Hypothesis: random limbs, simple ones first."""
    return st.builds(
        random_limb,
        seed=st.integers(0, 2**32 - 1),
        pattern=st.sampled_from(["coordinate", "tilted", "oblique"]),
        elbow=st.sampled_from(["straight", "offset"]),
        limits=st.sampled_from(list(limits)),
        miss=st.just(miss),
    )
