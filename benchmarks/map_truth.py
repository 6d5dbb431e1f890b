"""Whether maps are right: against Pinocchio, an independent solver, boxes and closed forms, at any size.

    python benchmarks/map_truth.py                                            # all parts, iiwa14
    python benchmarks/map_truth.py poses --robot gen3 --count 1000000 --seed 3
    python benchmarks/map_truth.py empty --robot j2s7s300 --count 10000

Parts, a line each:

    poses   of random configurations by Pinocchio: reached, and their own yaw inside their arcs
    cells   that are called reached: a posture at a random yaw of a random arc, measured by Pinocchio
    empty   cells that are called so although their wrist is within reach: restarts of an independent solver
    box     cells of a box: whether they are what the arcs of the half-plane say of them

Robots are names that `srs_ik.load` knows or `tests/arms.py` does, or FILE:BASE:TIP. Other seeds are other poses and
cells, so a large count can be shared among processes. Exit status 1 if anything is wrong. Nothing is written.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from maps import configurations
from restarts import FOUND, Restarts

import srs_ik
from srs_ik.kernels.layout.maps import CELL_ARCS
from srs_ik.maps.build import plan_map
from srs_ik.maps.live import turned
from srs_ik.maps.plan import YAW, arcs_of
from srs_ik.maps.tasks import in_base, job_of, measures_at
from srs_ik.solve.reachable import measured

TURN = 2.0 * np.pi
AT_ONCE = 20_000
POINT = 200
"""Cells of one position that are looked at together."""

CLOSED = 1e-9
"""A posture rebuilt from a cell is this close to its pose, m and rad."""

COUNTS = {"poses": 100_000, "cells": 10_000, "empty": 1_000, "box": 10_000}


def poses(arm, count, rng, given):
    arcs, lost, outside, where = arcs_of(arm), 0, 0, []
    for first in range(0, count, AT_ONCE):
        Q = configurations(arm, min(AT_ONCE, count - first), rng)
        T = np.array([arm.forward_kinematics(q).homogeneous for q in Q])
        lost += int((~arm.reachable_batch(T)).sum())
        rows = measured(arm.packed, T, arcs=arcs)[:, CELL_ARCS:].reshape(len(T), arcs, 2)
        start, width = rows[..., 0], rows[..., 1]
        # A yaw of zero on the very end of an arc may be off by rounding.
        met = ((width > 0.0) & ((1e-9 - start) % TURN <= width + 2e-9)).any(axis=1)
        outside += int((~met).sum())
        where += Q[~met].tolist()
    shown = f": {where[: given.show]}" if where and given.show else ""
    return lost + outside, f"{count:,}, {lost} missed, {outside} outside their arcs of yaw{shown}"


def some_cells(arm, plan, wanted, count, rng):
    """Random cells that are reached, or that are not: poses at yaw 0, and arcs (n, arcs, 2)."""
    job, rotations = job_of(arm, plan), in_base(plan)
    points = plan.grid.points([slice(0, n) for n in plan.grid.shape])
    wrist = np.linalg.solve(arm.limb.T_base_tip_zero, np.append(arm.limb.wrist, 1.0))[:3]
    T, arcs, found = [], [], 0
    while found < count:
        point = points[rng.integers(len(points))]
        turns = np.ascontiguousarray(rotations[rng.choice(len(rotations), min(POINT, len(rotations)), replace=False)])
        at = turns.reshape(-1, 3, 3) @ wrist + point
        near = np.linalg.norm(at - arm.limb.shoulder, axis=1) < arm.limb.upper_arm + arm.limb.forearm
        if not near.any():
            continue
        turns = turns[near]
        values = measures_at(job, point[None], turns)
        kept = np.flatnonzero((values["reached"] > 0) == wanted)[: count - found]
        each = np.tile(np.eye(4), (len(kept), 1, 1))
        each[:, :3, :3], each[:, :3, 3] = turns[kept].reshape(-1, 3, 3), point
        T.append(each)
        arcs.append(values[YAW][kept])
        found += len(kept)
    return np.concatenate(T), np.concatenate(arcs)


def cells(arm, count, rng, given):
    plan = plan_map(arm, given.step, orientations=given.orientations)
    T, arcs = some_cells(arm, plan, True, count, rng)
    k = np.argmax(rng.uniform(size=arcs.shape[:2]) * (arcs[..., 1] > 0.0), axis=1)
    start, width = arcs[np.arange(len(T)), k].T
    yaws = start + rng.uniform(0.0, 1.0, len(T)) * width
    T = np.array([turned(plan.grid.pose, yaw) for yaw in yaws]) @ T
    found = arm.solve_batch(T)
    worst = out = 0.0
    for pose, q in zip(T[found.ok], found.q[found.ok], strict=True):
        error = arm.verify(pose, q)
        worst = max(worst, error.position, error.orientation)
        out = max(out, float((arm.lower - q).max()), float((q - arm.upper).max()))
    without = int((~found.ok).sum())
    off = f"off by {worst:.2g} m or rad, {max(out, 0.0):.2g} rad outside limits"
    return without + (worst > CLOSED) + (out > 0.0), f"{len(T):,}, {without} without a posture, {off}"


def empty(arm, count, rng, given):
    plan = plan_map(arm, given.step, orientations=given.orientations)
    T, _ = some_cells(arm, plan, False, count, rng)
    solver = Restarts(arm, free=[0])
    error = solver.best(T, given.restarts, rng)
    known = np.array([arm.forward_kinematics(q).homogeneous for q in configurations(arm, 1000, rng)])
    power = int((solver.best(known, given.restarts, rng) < FOUND).sum())
    wrong = int((error < FOUND).sum())
    return wrong, (
        f"{len(T):,} with their wrist within reach, {given.restarts} restarts each: {wrong} postures found, nearest "
        f"{error.min():.2g}; of 1,000 poses that are reached the solver finds {power}"
    )


def box(arm, count, rng, given):
    reach = 0.8 * (arm.limb.upper_arm + arm.limb.forearm)
    bounds = np.stack([arm.limb.shoulder - reach, arm.limb.shoulder + reach], axis=1)
    plan = plan_map(arm, given.step, orientations=given.orientations, box_bounds=bounds.tolist())
    job, rotations, arcs = job_of(arm, plan), in_base(plan), arcs_of(arm)
    points = plan.grid.points([slice(0, n) for n in plan.grid.shape])
    different = inside = 0
    for _ in range(max(1, count // POINT)):
        point = points[rng.integers(len(points))]
        turns = np.ascontiguousarray(rotations[rng.choice(len(rotations), min(POINT, len(rotations)), replace=False)])
        T = np.tile(np.eye(4), (len(turns), 1, 1))
        T[:, :3, :3], T[:, :3, 3] = turns.reshape(-1, 3, 3), point
        rows = measured(arm.packed, T, arcs=arcs)[:, CELL_ARCS:].reshape(len(T), arcs, 2)
        met = ((rows[..., 1] > 0.0) & ((-rows[..., 0]) % TURN <= rows[..., 1])).any(axis=1)
        different += int((met != (measures_at(job, point[None], turns)["reached"] > 0)).sum())
        inside += int(met.sum())
    looked = max(1, count // POINT) * len(turns)
    return different, f"{looked:,} cells, {100.0 * inside / looked:.0f} % reached, {different} different"


PARTS = {"poses": poses, "cells": cells, "empty": empty, "box": box}


def load(name):
    file, *frames = name.split(":")
    if frames:
        return srs_ik.load(file, base=frames[0], tip=frames[1])
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
    import arms

    return arms.load(name) if name in arms.PLACES else srs_ik.load(name)


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", nargs="?", choices=list(PARTS), help="all by default")
    parser.add_argument("--robot", default="iiwa14")
    parser.add_argument("--count", type=int, help="poses or cells of a part")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--restarts", type=int, default=50)
    parser.add_argument("--step", type=float, default=0.1)
    parser.add_argument("--orientations", type=int, default=576)
    parser.add_argument("--show", type=int, default=3, help="configurations to print of poses outside their arcs")
    given = parser.parse_args(words)
    arm, wrong = load(given.robot), 0
    for part in [given.part] if given.part else PARTS:
        rng = np.random.default_rng([given.seed, list(PARTS).index(part)])
        begin = time.perf_counter()
        found, words = PARTS[part](arm, given.count or COUNTS[part], rng, given)
        wrong += found
        print(f"{given.robot}, seed {given.seed}, {part}: {words}; {time.perf_counter() - begin:.1f} s", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
