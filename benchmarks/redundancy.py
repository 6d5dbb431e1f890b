"""Whether the redundancy is exact: intervals, seeds, optima and paths against sweeps, against ssik.

python benchmarks/redundancy.py [--scale 1.0] [--urdf openarm_left=FILE] [--parts intervals arcs seeds optima paths]

Prints Markdown tables; docs/redundancy.md and docs/paths.md hold the outcome. Robots whose files are not here are left
out; --urdf says where one is.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from importlib import util

import numpy as np
from optimise import against_scipy, geometric_posture, random_configuration, random_objective
from rich.console import Console
from rich.progress import track
from swept import SAME, TURN, Chain, difference, excess, sweep, swept_values, turned, wrapped

import srs_ik
from srs_ik.bench.report import machine
from srs_ik.bench.timing import time_calls

LIMITED = ("iiwa14", "human_arm", "openarm_left", "romeo_left", "human_left", "icub_left")
SEEDED = ("iiwa14", "gen3", "openarm_left")
OPTIMISED = ("iiwa14", "human_arm", "gen3")


def poses_of(arm: srs_ik.Arm, count: int, seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [arm.forward_kinematics(random_configuration(arm, rng)).homogeneous for _ in range(count)]


# Intervals ----------------------------------------------------------------------------------------------------------


def intervals(arms: Sequence[srs_ik.Arm], count: int) -> None:
    print(f"\n### Intervals against a sweep of 1,440 arm angles in 8 branches, {count} poses an arm\n")
    print("| arm | intervals | narrowest (rad) | swept postures inside the limits | disagreements | us a call |")
    print("|---|--:|--:|--:|--:|--:|")
    for arm in arms:
        found, feasible_count, wrong, narrowest = 0, 0, 0, np.inf
        poses = poses_of(arm, count, 10)
        for pose in poses:
            angles, batch = sweep(arm, pose, 1440)
            feasible = batch.ok & turned(arm, batch.q, np.zeros(7))[1]
            inside, far = np.zeros_like(feasible), np.ones_like(feasible)
            for i in arm.intervals(pose):
                inside[:, i.branch] |= (angles - i.lower) % TURN <= i.width
                for end in (i.lower, i.upper):
                    far[:, i.branch] &= np.abs(wrapped(angles - end)) > SAME
                found, narrowest = found + 1, min(narrowest, i.width)
            feasible_count += int(feasible.sum())
            wrong += int(((feasible != inside) & far).sum())
        times, _ = time_calls(arm.intervals, [(pose,) for pose in poses])
        print(f"| `{arm.name}` | {found} | {narrowest:.1g} | {feasible_count} | {wrong} | {np.median(times):.0f} |")


def arcs(count: int) -> None:
    """Against the charts of ssik; its arm angle has another zero, so ends are compared by their postures."""
    from ssik import Manipulator

    arm, peer = srs_ik.load("iiwa14"), Manipulator.from_prebuilt("iiwa14")
    rng = np.random.default_rng(11)
    given = [random_configuration(arm, rng) for _ in range(count)]
    # Each in its own frames: the flange need not be the same.
    poses = [arm.forward_kinematics(q).homogeneous for q in given]
    peer_poses = [peer.fk(q) for q in given]
    missed, invented, theirs, ours, worst = 0, 0, 0, 0, 0.0
    for pose, peer_pose in zip(poses, peer_poses, strict=True):
        own = arm.intervals(pose)
        arcs = [
            arc_of(arm, chart, arc) for chart in peer.self_motion(peer_pose).charts for arc in joined(chart.in_limits())
        ]
        ours, theirs = ours + len(own), theirs + len(arcs)
        unmatched = list(arcs)
        for i in own:
            gaps = [apart(i, arc) for arc in unmatched]
            best = int(np.argmin(gaps)) if gaps else -1
            if best >= 0 and gaps[best] < 1e-6:
                worst = max(worst, gaps[best])
                unmatched.pop(best)
            else:
                invented += 1
        missed += len(unmatched)

    def seeded(pose: np.ndarray, seed: np.ndarray) -> object:
        return peer.solve(pose, max_solutions=1, q_seed=seed, seed_metric="wrap_l2")

    seeds = [np.clip(q + rng.uniform(-0.3, 0.3, 7), arm.lower, arm.upper) for q in given]
    near, peer_near = list(zip(poses, seeds, strict=True)), list(zip(peer_poses, seeds, strict=True))
    answers = [seeded(pose, seed) for pose, seed in peer_near]
    farther = sum(
        not answer or distance(answer[0].q, seed) > distance(arm.solve(pose, seed=seed).q, seed) + 0.01
        for answer, (pose, seed) in zip(answers, near, strict=True)
    )
    print(
        f"\n### iiwa14 against ssik, {count} poses (times: benchmarks/quick.py)\n\n| | srs_ik | ssik |\n|---|--:|--:|"
    )
    print(f"| feasible arcs | {ours} | {theirs} |\n| arcs that the other does not have | {invented} | {missed} |")
    print(f"| largest distance of two ends (rad) | {worst:.0e} | |")
    print(f"| answers near a seed, farther than the other's by more than 0.01 rad | 0 | {farther} |")


def distance(q: np.ndarray, seed: np.ndarray) -> float:
    return float(np.linalg.norm(np.asarray(q) - seed))


def joined(pieces: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Arcs with the one that ends at half a turn and the one that begins there made one."""
    pieces = sorted(pieces)
    if len(pieces) > 1 and abs(pieces[-1][1] - pieces[0][0] - TURN) < SAME:
        return [*pieces[1:-1], (pieces[-1][0], pieces[0][1] + TURN)]
    return pieces


def arc_of(arm: srs_ik.Arm, chart: object, arc: tuple[float, float]) -> tuple[int, float, float]:
    """Branch and end arm angles of an arc, by its postures."""
    lower, middle, upper = (np.asarray(chart.q(t)) for t in (arc[0], 0.5 * (arc[0] + arc[1]), arc[1]))
    ends = arm.arm_angle(lower), arm.arm_angle(upper)
    ahead = (arm.arm_angle(middle) - ends[0]) % TURN <= arc[1] - arc[0]
    return arm.branch(middle), *(ends if ahead else ends[::-1])


def apart(interval: srs_ik.Interval, arc: tuple[int, float, float]) -> float:
    if interval.branch != arc[0]:
        return np.inf
    if interval.width > TURN - SAME:  # a whole circle has no ends
        return 0.0 if abs(wrapped(arc[2] - arc[1])) < 1e-6 else np.inf
    return float(max(abs(wrapped(interval.lower - arc[1])), abs(wrapped(interval.upper - arc[2]))))


# Seeds --------------------------------------------------------------------------------------------------------------


def seeds(arms: Sequence[srs_ik.Arm], count: int, swept: int) -> None:
    print(f"\n### {count} random seeds an arm and spread; the sweep is of 8 x 720 postures, for {swept} of them\n")
    print(
        "| arm | within (rad) | not solved | farther than the known posture | by up to (rad) | farther than the sweep |"
    )
    print("|---|--:|--:|--:|--:|--:|")
    for arm in arms:
        for spread in (0.02, 1.0):
            rng = np.random.default_rng(12)
            known = np.array([random_configuration(arm, rng) for _ in range(count)])
            near = known + rng.uniform(-spread, spread, known.shape)
            poses = np.array([arm.forward_kinematics(q).homogeneous for q in known])
            found = arm.solve_batch(poses, seed=near)
            away = np.linalg.norm(found.q - near, axis=1)
            excess = away - np.linalg.norm(known - near, axis=1)
            behind = 0
            for i in range(swept):
                _, batch = sweep(arm, poses[i], 720)
                q, inside = turned(arm, batch.q, near[i])
                rivals = np.linalg.norm(q - near[i], axis=-1)[batch.ok & inside]
                behind += bool(rivals.size and away[i] > rivals.min() + SAME)
            worst = max(0.0, float(excess.max()))
            counts = f"{count - found.solved} | {int((excess > SAME).sum())} | {worst:.0e} | {behind}"
            print(f"| `{arm.name}` | {spread} | {counts} |")


# Optima -------------------------------------------------------------------------------------------------------------


def optima(arms: Sequence[srs_ik.Arm], count: int) -> None:
    rng = np.random.default_rng(13)
    print(f"\n### The optimum against the best of 8 x 720 postures inside the limits, {count} poses an arm\n")
    print("| objective | arm | poses | worse than the sweep | by up to | sweep behind, median | NumPy off Pinocchio |")
    print("|---|---|--:|--:|--:|--:|--:|")
    rows = []
    for arm in arms:
        chain = Chain(arm)
        gaps: dict[str, list[float]] = {name: [] for name in srs_ik.OBJECTIVES}
        off = dict.fromkeys(srs_ik.OBJECTIVES, 0.0)
        for _ in track(range(count), arm.name, console=Console(stderr=True)):
            pose = arm.forward_kinematics(random_configuration(arm, rng)).homogeneous
            _, batch = sweep(arm, pose, 720)
            swept = batch.q[batch.ok]
            for name in srs_ik.OBJECTIVES:
                best = arm.optimise(pose, random_objective(name, arm, rng))
                q, inside = turned(arm, swept, best.objective.parameters.get("reference", np.zeros(7)))
                Q = q[inside]
                if not len(Q):
                    continue
                values = swept_values(arm, chain, best.objective, Q)
                some = int(rng.integers(len(Q)))
                off[name] = max(off[name], difference(arm, best.objective, Q[some], [v[some] for v in values]))
                gaps[name].append(excess(arm, pose, best, values) if best else np.inf)
        for name, found in gaps.items():
            worse = sum(gap > SAME for gap in found)
            figures = f"{max(0.0, *found):.0e} | {-np.median(found):.0e} | {off[name]:.0e}"
            rows.append(f"| `{name}` | `{arm.name}` | {len(found)} | {worse} | {figures} |")
    print("\n".join(sorted(rows, key=lambda row: srs_ik.OBJECTIVES.index(row.split("`")[1]))))


# Paths --------------------------------------------------------------------------------------------------------------


def moved(pose: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    poses = np.repeat(pose[None], len(offsets), axis=0)
    poses[:, :3, 3] += offsets
    return poses


def path_poses(arm: srs_ik.Arm, name: str, count: int) -> np.ndarray:
    s = np.linspace(0.0, 1.0, count)[:, None]
    middle = arm.forward_kinematics([0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1]).homogeneous
    if name == "circle":
        return moved(middle, 0.1 * np.hstack([0.0 * s, np.sin(TURN * s), np.cos(TURN * s) - 1.0]))
    if name == "spiral":
        radius = 0.1 * s
        return moved(middle, radius * np.hstack([0.0 * s, np.sin(10 * TURN * s), np.cos(10 * TURN * s)]))
    if name == "line through the shoulder singularity":
        singular = arm.forward_kinematics([0.3, 0.0, 0.2, -1.2, 0.3, 0.7, 0.1]).homogeneous
        return moved(singular, (2.0 * s - 1.0) * [0.08, 0.1, 0.0])
    # In to the stretched arm and out again, along the line from the shoulder, which no straight line passes.
    straight = arm.forward_kinematics([0.3, 0.7, 0.2, 0.0, 0.3, 0.7, 0.1]).homogeneous
    wrist = straight[:3, 3] - straight[:3, 2] * arm.limb.hand
    out = (wrist - arm.limb.shoulder) / np.linalg.norm(wrist - arm.limb.shoulder)
    return moved(straight, -0.05 * (2.0 * s - 1.0) ** 2 * out)


def least_step(arm: srs_ik.Arm, pose: np.ndarray, after: np.ndarray, count: int) -> float:
    """Least distance between any posture of one pose and any of the next, rad."""
    _, batch = sweep(arm, pose, count)
    q, inside = turned(arm, batch.q, np.zeros(7))
    starts = q[batch.ok & inside]
    nearest = arm.solve_batch(np.broadcast_to(after, (len(starts), 4, 4)), seed=starts)
    return float(np.linalg.norm(nearest.q - starts, axis=1)[nearest.ok].min(initial=np.inf))


def paths(arm: srs_ik.Arm, scale: float) -> None:
    print(f"\n### Paths, {arm.name}; a step is the distance of two postures next to each other, all joints together\n")
    print(
        "| path | poses | breaks | largest step (rad) | least possible | ratio | largest of a joint | CPU us a pose |"
    )
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for name, count in (
        ("circle", 200),
        ("line through the shoulder singularity", 201),
        ("line to the straight elbow and back", 201),
        ("spiral", max(50, int(10_000 * scale))),
    ):
        poses = path_poses(arm, name, count)
        arm.solve_path(poses[:20])
        begin = time.process_time()
        path = arm.solve_path(poses)
        taken = 1e6 * (time.process_time() - begin) / count
        steps = np.linalg.norm(path.steps, axis=1)
        # No path can do with less than the step that is longest even where every step is chosen for itself.
        where = np.unique([*np.argsort(steps)[-20:], *range(0, count - 1, max(1, (count - 1) // 20))])
        least = max(least_step(arm, poses[i], poses[i + 1], 180) for i in where)
        figures = f"{steps.max():.4f} | {least:.4f} | {steps.max() / least:.2f} | {path.largest_step:.4f} | {taken:.0f}"
        print(f"| {name} | {count} | {len(path.breaks)} | {figures} |")


def load_all(names: Sequence[str], files: dict[str, str]) -> list[srs_ik.Arm]:
    """The robots whose files are here."""
    arms = []
    for name in names:
        try:
            arms.append(srs_ik.load(name, urdf=files[name]) if name in files else srs_ik.load(name))
        except srs_ik.SrsIkError as error:
            print(f"{name} is left out: {error}\n")
    return arms


def main(arguments: Sequence[str] | None = None) -> None:
    parts = ("intervals", "arcs", "seeds", "optima", "paths")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scale", type=float, default=1.0, help="share of the cases that are tried")
    parser.add_argument("--parts", nargs="+", choices=parts, default=parts, help="what to measure")
    parser.add_argument(
        "--urdf", nargs="*", default=[], metavar="ROBOT=FILE", help="files of robots that are elsewhere"
    )
    chosen = parser.parse_args(arguments)
    if not 0.0 < chosen.scale <= 1.0:
        parser.error("--scale must be above 0 and at most 1")
    files = dict(entry.split("=", 1) for entry in chosen.urdf)

    def share(count: int) -> int:
        return max(1, int(count * chosen.scale))

    print(", ".join(f"{name} {value}" for name, value in machine().items()))
    if "intervals" in chosen.parts:
        intervals(load_all(LIMITED, files), share(100))
    if "arcs" in chosen.parts and util.find_spec("ssik"):
        arcs(share(200))
    if "seeds" in chosen.parts:
        seeds(load_all(SEEDED, files), share(10_000), share(200))
    if "optima" in chosen.parts:
        optima(load_all(OPTIMISED, files), share(300))
        geometric_posture(srs_ik.load("human_arm"), share(300))
        against_scipy(srs_ik.load("iiwa14"), share(60), 20)
    if "paths" in chosen.parts:
        paths(srs_ik.load("iiwa14"), chosen.scale)


if __name__ == "__main__":
    main()
