"""The same target motions through this package's tracker, ssik's, Pink and Mink: what they make of them, and how fast.

    python benchmarks/tracking.py --motions 4 --seconds 10
    python benchmarks/tracking.py --robots med7 h1_2_left --first 10000 --trouble
    python benchmarks/tracking.py --robots gen3 --kinds hand reach --trouble --picture docs/tracking.png
    python benchmarks/tracking.py --limits --robot gen3 --count 200 --seed 0
    python benchmarks/tracking.py --recovery --robot gen3 --count 60 --seed 0
    python benchmarks/tracking.py --losses --robot gen3 --count 20 --seed 0
    python benchmarks/tracking.py --bound --robot gen3 --count 200 --seed 0

Each gets the joint limits that it knows, which stand beside its name: v for position and velocity, a for acceleration,
too. Pink has both, as ours has; ssik and Mink have velocities alone, and are to be compared with ours without limits of
acceleration. A target that is lost is None for ours and the last one for the
others. On target is a tip within 1 mm and 10 mrad of where the target truly is, by Pinocchio; within is the share of
updates that are so inside the limits that were given, by 1 %; driven is the share of a drive that is sent these joint
angles and has limits of velocity and acceleration, whatever its tracker knows of them; mean and rms are of the
accelerations by those of ours, and jerk is the mean of how fast these change, 1/s; a freeze is 50 ms without a motion
while the tip is off a target; a flip a joint that moves by more than 0.2 rad in a period; back the time from the end
of a loss until the tip is on its target again, 95 % of them. Times are those of the processor; with --runs, each motion
runs so often, and an update counts by its shortest time: what it takes by itself, without what other processes cost it.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import srs_ik
from srs_ik.bench.report import machine

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

import arms  # noqa: E402
from causal import bound_line  # noqa: E402
from drive import driven  # noqa: E402
from motions import KINDS, Motion, motion, off_target  # noqa: E402
from tracked import SMOOTHING, limits_line, losses_line, recovery_line  # noqa: E402

ROBOTS = ("iiwa14", "gen3")
OF_THEIR_OWN = ("ssik", "mink")
"""Trackers that need a robot of ssik's, or its file beside this package."""

HARDEST = 10.0
"""Accelerations lead to full velocity in 0.1 s, 1/s: `Arm.tracker`'s own."""

NEAR_TARGET = (1e-3, 1e-2)
FREEZE = 0.05
FLIP = 0.2

Update = Callable[[np.ndarray | None], np.ndarray]
"""What a tracker is here: from a target to joint angles."""

Make = Callable[[srs_ik.Arm, np.ndarray, float, np.ndarray], Update]
"""Makes one for an arm, from where its joints are, the period and the limits of acceleration."""


def ours(both: bool, smoothing: float | None = None) -> Make:
    """`Arm.tracker`, with limits of acceleration or, as ssik's and Mink, without."""

    def make(arm: srs_ik.Arm, q0: np.ndarray, dt: float, acceleration: np.ndarray) -> Update:
        tracker = arm.tracker(q0, dt, acceleration=acceleration if both else np.inf, smoothing=smoothing)
        return lambda T: tracker.update(T).q

    return make


def ssik(arm: srs_ik.Arm, q0: np.ndarray, dt: float, acceleration: np.ndarray) -> Update:
    """ssik's tracker on its own arm of that name, with its clamp of the speed."""
    from ssik import Manipulator, Tracker

    theirs = Manipulator.from_prebuilt(arm.name)
    tool = np.linalg.inv(arm.forward_kinematics(q0).homogeneous) @ theirs.fk(q0)
    tracker = Tracker(theirs, q0, max_joint_speed=arm.velocity_limit, t0=0.0)
    now = 0.0

    def update(T: np.ndarray | None) -> np.ndarray:
        nonlocal now
        now += dt
        return tracker.q if T is None else tracker.update(T @ tool, now).q

    return update


def pink(arm: srs_ik.Arm, q0: np.ndarray, dt: float, acceleration: np.ndarray) -> Update:
    """Pink's quadratic programme with limits of configuration, velocity and acceleration."""
    import pink as package
    from pink.limits import AccelerationLimit, ConfigurationLimit, VelocityLimit

    model = arm.model.copy()
    task = package.tasks.FrameTask(arm.tip, position_cost=1.0, orientation_cost=0.25)
    configuration = package.Configuration(model, model.createData(), arm.configuration(q0))
    limits = [ConfigurationLimit(model), VelocityLimit(model), AccelerationLimit(model, acceleration)]
    q = q0.copy()

    def update(T: np.ndarray | None) -> np.ndarray:
        if T is not None:
            task.set_target(pin.SE3(T))
        try:
            v = package.solve_ik(configuration, [task], dt, solver="daqp", safety_break=False, limits=limits)
        except Exception:
            v = np.zeros(7)
        limits[2].set_last_integration(v, dt)
        configuration.integrate_inplace(v, dt)
        q[:] += dt * v
        return q.copy()

    return update


def mink(arm: srs_ik.Arm, q0: np.ndarray, dt: float, acceleration: np.ndarray) -> Update:
    """Mink's quadratic programme on MuJoCo with limits of configuration and velocity."""
    import mink as package
    import mujoco

    text = (HERE.parent / "robots" / arm.name / f"{arm.name}.urdf").read_text()
    options = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(text.replace("</robot>", options))
    task = package.FrameTask(arm.tip, "body", position_cost=1.0, orientation_cost=0.25)
    speeds = dict(zip(arm.joint_names, arm.velocity_limit, strict=True))
    limits = [package.ConfigurationLimit(model), package.VelocityLimit(model, speeds)]
    configuration = package.Configuration(model)
    configuration.update(q0)

    def update(T: np.ndarray | None) -> np.ndarray:
        if T is not None:
            task.set_target(package.SE3.from_matrix(T))
        try:
            v = package.solve_ik(configuration, [task], dt, solver="daqp", limits=limits)
        except Exception:
            v = np.zeros(7)
        configuration.integrate_inplace(v, dt)
        return configuration.q.copy()

    return update


TRACKERS: dict[str, Make] = {
    "srs_ik": ours(True),
    "srs_ik, smoothing": ours(True, SMOOTHING),
    "pin-pink": pink,
    "srs_ik, velocity": ours(False),
    "srs_ik, velocity, smoothing": ours(False, SMOOTHING),
    "ssik": ssik,
    "mink": mink,
}
WITH_ACCELERATIONS = ("srs_ik", "srs_ik, smoothing", "pin-pink")
"""Trackers that are given limits of acceleration."""

FOR_JITTER = ("srs_ik, smoothing", "srs_ik, velocity, smoothing")
"""Trackers that run only where targets have jitter, if no others are asked for."""


def run(make: Make, arm: srs_ik.Arm, given: Motion, dt: float, runs: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Joint angles (n, 7) of a motion, and the least microseconds of the processor of each update (n,)."""
    if given.given[0] is None:
        given.given[0] = given.true[0]
    q, took = np.empty((len(given.given), 7)), np.full(len(given.given), np.inf)
    for _ in range(runs):
        update = make(arm, given.q0, dt, HARDEST * arm.velocity_limit)
        for k, T in enumerate(given.given):
            began = time.thread_time_ns()
            q[k] = update(T)
            took[k] = min(took[k], 1e-3 * (time.thread_time_ns() - began))
    return q, took


def account(arm: srs_ik.Arm, given: Motion, q: np.ndarray, dt: float, both: bool = True) -> dict[str, Any]:
    """What a tracker made of a motion; both: whether it was given limits of acceleration, too."""
    on = _on(arm, given, q)
    bounds = arm.velocity_limit, HARDEST * arm.velocity_limit
    steps = np.diff(np.vstack([given.q0, given.q0, q]), axis=0)
    steps = np.where(np.isinf(arm.upper), (steps + np.pi) % (2.0 * np.pi) - np.pi, steps)
    velocity, acceleration = steps / dt, np.diff(steps, axis=0) / dt**2
    still = (np.abs(steps[1:]).max(axis=1) < 1e-9) & ~on
    return {
        "on": float(on.mean()),
        "driven": float(_on(arm, given, driven(arm, given.q0, q, bounds, dt)).mean()),
        "within": float((on & _within(velocity[1:], acceleration, arm, both)).mean()),
        "velocity": float((np.abs(velocity) / arm.velocity_limit).max()),
        "acceleration": float((np.abs(acceleration) / (HARDEST * arm.velocity_limit)).max()),
        "push": float((np.abs(acceleration) / (HARDEST * arm.velocity_limit)).mean()),
        "rms": float(np.sqrt(((acceleration / (HARDEST * arm.velocity_limit)) ** 2).mean())),
        "jerk": float((np.abs(np.diff(acceleration, axis=0)) / dt / (HARDEST * arm.velocity_limit)).mean()),
        "freezes": float(_runs(still, round(FREEZE / dt))),
        "recovery": _recovery(given, on, dt),
        "flips": float((np.abs(steps).max(axis=1) > FLIP).sum()),
    }


def _on(arm: srs_ik.Arm, given: Motion, q: np.ndarray) -> np.ndarray:
    """On which updates the tip is on its target."""
    off, turned = off_target(arm.forward_kinematics, q, given.true)
    return np.asarray((off < NEAR_TARGET[0]) & (turned < NEAR_TARGET[1]))


def _within(velocity: np.ndarray, acceleration: np.ndarray, arm: srs_ik.Arm, both: bool) -> np.ndarray:
    """Which updates keep the limits of velocity, and of acceleration if both count, but for 1 % of them."""
    fast = (np.abs(velocity) / arm.velocity_limit).max(axis=1)
    hard = (np.abs(acceleration) / (HARDEST * arm.velocity_limit)).max(axis=1)
    return np.asarray((fast < 1.01) & ((hard < 1.01) | (not both)))


def _recovery(given: Motion, on: np.ndarray, dt: float) -> list[float]:
    """Seconds from the first target after each loss until the tip is on it; as long as the motion where it never is."""
    lost = np.array([T is None for T in given.given])
    back = np.flatnonzero(lost[:-1] & ~lost[1:]) + 1
    return [dt * float(np.argmax(on[k:])) if on[k:].any() else dt * len(on) for k in back]


def _runs(marks: np.ndarray, length: int) -> int:
    """How many runs of marks are at least so long."""
    ends = np.flatnonzero(np.diff(np.concatenate([[0], marks.astype(int), [0]])))
    return int(((ends[1::2] - ends[::2]) >= length).sum())


def picture(path: Path, arm: srs_ik.Arm, given: Motion, dt: float, names: list[str]) -> None:
    """One motion: distance from the target, and the largest velocity and acceleration by their limits."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(3, 1, sharex=True, figsize=(8.0, 7.0), layout="constrained")
    t = dt * np.arange(1, len(given.given) + 1)
    for name in names:
        q, _ = run(TRACKERS[name], arm, given, dt)
        off = [
            np.linalg.norm(arm.forward_kinematics(x).translation - T[:3, 3]) for x, T in zip(q, given.true, strict=True)
        ]
        steps = np.diff(np.vstack([given.q0, given.q0, q]), axis=0)
        axes[0].semilogy(t, np.maximum(off, 1e-7), label=name, linewidth=1.0)
        axes[1].plot(t, (np.abs(steps[1:]) / dt / arm.velocity_limit).max(axis=1), linewidth=0.8)
        push = (np.abs(np.diff(steps, axis=0)) / dt**2 / (HARDEST * arm.velocity_limit)).max(axis=1)
        axes[2].semilogy(t, np.maximum(push, 1e-4), linewidth=0.6)
    for axis, words in zip(axes, ("tip off target (m)", "velocity / limit", "acceleration / limit"), strict=True):
        axis.set_ylabel(words)
        axis.grid(alpha=0.3)
    for axis in axes[1:]:
        axis.axhline(1.0, color="black", linewidth=0.6)
    axes[0].legend(ncols=4, fontsize="small")
    axes[2].set_xlabel("time (s)")
    figure.savefig(path, dpi=110)


def main(words: list[str] | None = None) -> None:
    """Run the trackers and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=list(ROBOTS), help="built in, or of tests/arms.py")
    parser.add_argument("--trackers", nargs="+", choices=list(TRACKERS), help="all; those that smooth with --trouble")
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=KINDS)
    parser.add_argument("--motions", type=int, default=2, help="of each kind")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--first", type=int, default=0, help="seed of the first motion")
    parser.add_argument("--rate", type=float, default=500.0, help="targets a second")
    parser.add_argument("--runs", type=int, default=1, help="of each motion, for times that others do not disturb")
    parser.add_argument("--trouble", action="store_true", help="jitter, jumps, pauses and lost targets")
    parser.add_argument("--picture", type=Path, help="draw the first motion of the first kind")
    parser.add_argument("--limits", action="store_true", help="one line: what 10 s motions with trouble pass of limits")
    parser.add_argument("--recovery", action="store_true", help="one line: how fast a target that jumped is met again")
    parser.add_argument("--losses", action="store_true", help="one line: when a target is met again that was lost")
    parser.add_argument("--bound", action="store_true", help="one line: how far off the tip is, by what limits imply")
    parser.add_argument("--robot", default="iiwa14", help="of --limits, --recovery, --losses and --bound")
    parser.add_argument("--count", type=int, default=200, help="motions, or jumps")
    parser.add_argument("--seed", type=int, default=0, help="of the first of them")
    given = parser.parse_args(words)
    given.trackers = given.trackers or [t for t in TRACKERS if given.trouble or t not in FOR_JITTER]
    dt = 1.0 / given.rate
    if given.bound:
        print(bound_line(arms.load(given.robot), arms.forward(given.robot), given.robot, given.count, given.seed, dt))
        return
    if given.limits or given.recovery or given.losses:
        measure = limits_line if given.limits else recovery_line if given.recovery else losses_line
        print(measure(arms.load(given.robot), given.robot, given.count, given.seed, dt))
        return
    print(machine())
    columns = [
        "on target",
        "and within",
        "driven",
        "velocity",
        "acceleration",
        "mean",
        "rms",
        "jerk, 1/s",
        "freezes",
        "flips",
        "back, s",
        "us",
        "99.9 %",
    ]
    print(f"| robot | motions | tracker | limits | {' | '.join(columns)} |")
    print("|---|---|---|---|" + "--:|" * len(columns))
    for robot in given.robots:
        arm = arms.load(robot)
        trackers = [t for t in given.trackers if robot in ROBOTS or t not in OF_THEIR_OWN]
        for kind in given.kinds:
            motions = [
                motion(arm, seed, given.seconds, dt, kind, given.trouble)
                for seed in range(given.first, given.first + given.motions)
            ]
            for name in trackers:
                runs = [run(TRACKERS[name], arm, each, dt, given.runs) for each in motions]
                both = name in WITH_ACCELERATIONS
                said = [account(arm, each, q, dt, both) for each, (q, _) in zip(motions, runs, strict=True)]
                took = np.concatenate([took[10:] for _, took in runs])
                slow = np.percentile(took, 99.9)
                back = [seconds for s in said for seconds in s["recovery"]] or [0.0]
                print(
                    f"| `{robot}` | {kind} | {name} | {'v, a' if both else 'v'} "
                    f"| {100.0 * np.mean([s['on'] for s in said]):.1f} % "
                    f"| {100.0 * np.mean([s['within'] for s in said]):.1f} % "
                    f"| {100.0 * np.mean([s['driven'] for s in said]):.1f} % "
                    f"| {max(s['velocity'] for s in said):.2f} | {max(s['acceleration'] for s in said):.3g} "
                    f"| {np.mean([s['push'] for s in said]):.3f} "
                    f"| {np.sqrt(np.mean([s['rms'] ** 2 for s in said])):.3f} "
                    f"| {np.mean([s['jerk'] for s in said]):.1f} | {sum(s['freezes'] for s in said):.0f} "
                    f"| {sum(s['flips'] for s in said):.0f} "
                    f"| {np.percentile(back, 95.0):.2f} | {np.median(took):.1f} | {slow:.0f} |",
                    flush=True,
                )
    if given.picture:
        arm = arms.load(given.robots[0])
        moving = motion(arm, given.first, given.seconds, dt, given.kinds[0], given.trouble)
        picture(given.picture, arm, moving, dt, given.trackers)


if __name__ == "__main__":
    main()
