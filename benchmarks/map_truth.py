"""Whether maps are right: against Pinocchio, an independent solver, boxes and closed forms, at any size.

    python benchmarks/map_truth.py --arm iiwa14 --poses 1000000 --cells 100000 --empty 10000

Arms are names that `srs_ik.load` knows, or FILE:BASE:TIP.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from maps import configurations
from restarts import FOUND, Restarts

import srs_ik
from srs_ik.kernels.layout.maps import CELL_ARCS
from srs_ik.maps import build_map
from srs_ik.maps.live import turned
from srs_ik.maps.plan import YAW, arcs_of
from srs_ik.maps.tasks import in_base
from srs_ik.solve.reachable import measured

TURN = 2.0 * np.pi
AT_ONCE = 20_000


def missed(arm, count, rng):
    """Poses of random configurations by Pinocchio: reached, and their own yaw inside their arcs."""
    lost = outside = 0
    arcs = arcs_of(arm)
    for first in range(0, count, AT_ONCE):
        Q = configurations(arm, min(AT_ONCE, count - first), rng)
        T = np.array([arm.forward_kinematics(q).homogeneous for q in Q])
        lost += int((~arm.reachable_batch(T)).sum())
        rows = measured(arm.packed, T, arcs=arcs)[:, CELL_ARCS:].reshape(len(T), arcs, 2)
        start, width = rows[..., 0], rows[..., 1]
        # A yaw of zero on the very end of an arc may be off by rounding.
        met = (width > 0.0) & ((1e-9 - start) % TURN <= width + 2e-9)
        outside += int((~met.any(axis=1)).sum())
    print(f"random configurations by Pinocchio: {count:,}, {lost} missed, {outside} outside their arcs of yaw")


def pose_of(chart, at, yaw=0.0):
    T = np.eye(4)
    T[:3, :3] = in_base(chart.plan).reshape(-1, 3, 3)[at[-1]]
    T[:3, 3] = chart.plan.grid.points([slice(i, i + 1) for i in at[:-1]])[0]
    return turned(chart.plan.grid.pose, yaw) @ T if yaw else T


def poses_of(chart, cells, yaws=None):
    points = chart.plan.grid.points([slice(0, n) for n in chart.plan.grid.shape])
    T = np.tile(np.eye(4), (len(cells), 1, 1))
    T[:, :3, :3] = in_base(chart.plan).reshape(-1, 3, 3)[cells[:, -1]]
    T[:, :3, 3] = points[np.ravel_multi_index(cells[:, :-1].T, chart.plan.grid.shape)]
    if yaws is not None:
        T = np.array([turned(chart.plan.grid.pose, yaw) for yaw in yaws]) @ T
    return T


def rebuilt(arm, chart, count, rng):
    """Cells called reached: a posture inside the limits, at a random yaw of a random arc, measured by Pinocchio."""
    cells = np.argwhere(chart.measure("reached") > 0)
    cells = cells[rng.choice(len(cells), min(count, len(cells)), replace=False)]
    arcs = chart.measure(YAW)[tuple(cells.T)]
    k = np.argmax(rng.uniform(size=arcs.shape[:2]) * (arcs[..., 1] > 0.0), axis=1)
    start, width = arcs[np.arange(len(cells)), k].T
    T = poses_of(chart, cells, start + rng.uniform(0.0, 1.0, len(cells)) * width)
    found = arm.solve_batch(T)
    worst = out = 0.0
    for pose, q in zip(T, found.q, strict=True):
        error = arm.verify(pose, q)
        worst = max(worst, error.position, error.orientation)
        out = max(out, float((arm.lower - q).max()), float((q - arm.upper).max()))
    print(
        f"cells called reached: {len(cells):,}, {int((~found.ok).sum())} without a posture, off by {worst:.2g} m or "
        f"rad, {max(out, 0.0):.2g} rad outside the limits"
    )


def empty(arm, chart, count, restarts, rng):
    """Cells called empty whose wrist is within reach: an independent solver finds nothing, at any yaw."""
    cells = np.argwhere(chart.measure("reached") == 0)
    cells = cells[rng.permutation(len(cells))[: 20 * count]]
    T = poses_of(chart, cells)
    wrist = T[:, :3, :3] @ (np.linalg.inv(arm.limb.T_base_tip_zero) @ np.append(arm.limb.wrist, 1.0))[:3] + T[:, :3, 3]
    near = np.linalg.norm(wrist - arm.limb.shoulder, axis=1) < arm.limb.upper_arm + arm.limb.forearm
    T = T[near][:count]
    solver = Restarts(arm, free=[0])
    begin = time.perf_counter()
    error, _ = solver.best(T, restarts, rng)
    took = time.perf_counter() - begin
    known = np.array([arm.forward_kinematics(q).homogeneous for q in configurations(arm, 1000, rng)])
    power, _ = solver.best(known, restarts, rng)
    print(
        f"cells called empty: {len(T):,} with their wrist within reach, {restarts} restarts each in {took:.0f} s: "
        f"{int((error < FOUND).sum())} postures found, nearest {error.min():.2g}; of 1,000 poses that are reached the "
        f"solver finds {int((power < FOUND).sum())}"
    )


def alike(arm, chart, folder, count):
    """Cells of a box: what the arcs of the half-plane say of their poses."""
    size = max(2, round((count / 576) ** (1 / 3)))
    centre, reach = arm.limb.shoulder, 0.8 * (arm.limb.upper_arm + arm.limb.forearm)
    step = 2.0 * reach / size
    bounds = np.round((centre[:, None] + np.array([-reach, reach])) / step) * step
    made = build_map(arm, step, Path(folder, "box.zarr"), orientations=576, box=bounds.tolist())
    box = made.measure("reached")
    cells = np.argwhere(box >= 0)
    T, arcs = poses_of(made, cells), arcs_of(arm)
    rows = measured(arm.packed, T, arcs=arcs)[:, CELL_ARCS:].reshape(len(T), arcs, 2)
    inside = ((rows[..., 1] > 0.0) & ((-rows[..., 0]) % TURN <= rows[..., 1])).any(axis=1)
    different = int((inside != (box.ravel() > 0)).sum())
    print(f"box against half-plane: {len(cells):,} cells, {100.0 * inside.mean():.0f} % reached, {different} different")


def load(name):
    file, *frames = name.split(":")
    return srs_ik.load(file, base=frames[0], tip=frames[1]) if frames else srs_ik.load(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arm", default="iiwa14")
    parser.add_argument("--poses", type=int, default=100_000)
    parser.add_argument("--cells", type=int, default=10_000)
    parser.add_argument("--empty", type=int, default=1_000)
    parser.add_argument("--restarts", type=int, default=50)
    parser.add_argument("--step", type=float, default=0.1)
    parser.add_argument("--orientations", type=int, default=576)
    arguments = parser.parse_args()
    arm, rng = load(arguments.arm), np.random.default_rng(7)
    missed(arm, arguments.poses, rng)
    with tempfile.TemporaryDirectory() as folder:
        chart = build_map(arm, arguments.step, Path(folder, "map.zarr"), orientations=arguments.orientations)
        print(chart)
        rebuilt(arm, chart, arguments.cells, rng)
        empty(arm, chart, arguments.empty, arguments.restarts, rng)
        alike(arm, chart, folder, arguments.cells)


if __name__ == "__main__":
    main()
