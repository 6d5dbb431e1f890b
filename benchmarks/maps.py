"""Maps and places for a base: rates, what is missed, and a sampled map at equal time.

The sampled map is made by the description of F. Zacharias, C. Borst, G. Hirzinger, Capturing robot workspace structure,
IROS 2007: random joint angles, and each cell of position and orientation that a tip pose falls into is reached.

    python benchmarks/maps.py --arm iiwa14 --poses 1000000
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

import srs_ik
from srs_ik.maps import build_map
from srs_ik.maps.live import turned
from srs_ik.maps.tasks import in_base


def seconds(work):
    begin = time.perf_counter()
    answer = work()
    return time.perf_counter() - begin, answer


def configurations(arm, count, rng):
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    return rng.uniform(lower, upper, (count, 7))


def random_poses(arm, count, rng):
    """Anywhere in a cube about the shoulder that holds all that the arm reaches."""
    T = np.tile(np.eye(4), (count, 1, 1))
    q = rng.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    T[:, :3, :3] = [pin.Quaternion(*each).matrix() for each in q]
    size = arm.limb.upper_arm + arm.limb.forearm + arm.limb.hand
    T[:, :3, 3] = arm.limb.shoulder + rng.uniform(-size, size, (count, 3))
    return T


def live(arm, count, rng):
    by_pinocchio = np.array([arm.forward_kinematics(q).homogeneous for q in configurations(arm, count, rng)])
    arm.reachable_batch(by_pinocchio[:100])
    took, reached = seconds(lambda: arm.reachable_batch(by_pinocchio))
    print(f"random configurations: {count:,} poses, {(~reached).sum()} missed, {1e6 * took / count:.2f} us a pose")
    anywhere = random_poses(arm, min(count, 200_000), rng)
    took, reached = seconds(lambda: arm.reachable_batch(anywhere))
    share = 100.0 * reached.mean()
    print(f"random poses: {share:.1f} % reached, {1e6 * took / len(anywhere):.2f} us a pose")
    grasps = random_poses(arm, 100, rng)
    bases = np.tile(np.eye(4), (1600, 1, 1))
    line = np.linspace(-1.0, 1.0, 40)
    bases[:, :2, 3] = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    for by in ("share", "width"):
        srs_ik.base_placement(arm, grasps[:2], bases[:2], by=by)
        took, _ = seconds(lambda by=by: srs_ik.base_placement(arm, grasps, bases, by=by))
        print(f"base placement by {by}: 160,000 poses, {took:.2f} s")


def empty(arm, chart, count, restarts, rng):
    """Cells called empty: an independent solver finds nothing."""
    values, rotations = chart.measure("reached"), in_base(chart.plan).reshape(-1, 3, 3)
    none = np.argwhere(values == 0)
    # Those within reach are worth a search.
    radius = arm.limb.upper_arm + arm.limb.forearm
    found = tried = 0
    while tried < count:
        at = none[rng.integers(len(none))]
        T = np.eye(4)
        T[:3, :3] = rotations[at[-1]]
        T[:3, 3] = chart.plan.grid.points([slice(i, i + 1) for i in at[:-1]])[0]
        if np.linalg.norm(T[:3, 3] - arm.limb.shoulder) > radius:
            continue
        goal = pin.SE3(turned(chart.plan.grid.pose, rng.uniform(-np.pi, np.pi)) @ T)
        tried += 1
        for _ in range(restarts):
            start = configurations(arm, 1, rng)[0]
            bounds = np.array([arm.lower, arm.upper])
            result = least_squares(_error, start, args=(arm, goal), bounds=bounds, xtol=1e-10, max_nfev=60)
            found += int(np.sqrt(2.0 * result.cost) < 1e-7)
    print(f"empty cells: {tried} searched with {restarts} restarts each, {found} postures found")


def _error(q, arm, goal):
    return pin.log6(arm.forward_kinematics(q).actInv(goal)).vector


def sampled(arm, chart, took, rng):
    """A map of the same cells from random joint angles, in the time that the exact one took."""
    shape, block, samples = chart.measure("reached").shape, 200_000, 0
    hit = np.zeros(shape, bool)
    begin = time.perf_counter()
    while time.perf_counter() - begin < took:
        T = arm.forward_kinematics_batch(configurations(arm, block, rng))
        at, _, inside = _cells(chart, T)
        hit[tuple(at[inside].T)] = True
        samples += block
    truth = chart.measure("reached") > 0
    missed, wrong = (truth & ~hit).sum() / truth.sum(), (hit & ~truth).sum() / hit.sum()
    right = (truth == hit).mean()
    print(
        f"sampled map, {samples:,} samples in {took:.1f} s: {100 * right:.2f} % of cells right, "
        f"{100 * missed:.2f} % of the reached cells missed, {100 * wrong:.2f} % of its cells not reached"
    )


def _cells(chart, T):
    where, rotation, yaw = chart._in_map(T)
    at = np.floor(where).astype(np.int64)
    inside = ((at >= 0) & (at < np.array(chart.plan.grid.shape))).all(axis=1)
    return np.column_stack([at, chart.plan.orientations.index(rotation)]), yaw, inside


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arm", default="iiwa14")
    parser.add_argument("--poses", type=int, default=100_000)
    parser.add_argument("--step", type=float, default=0.05)
    parser.add_argument("--orientations", type=int, default=2304)
    parser.add_argument("--empty", type=int, default=100)
    parser.add_argument("--restarts", type=int, default=50)
    arguments = parser.parse_args()
    arm, rng = srs_ik.load(arguments.arm), np.random.default_rng(0)
    live(arm, arguments.poses, rng)
    with tempfile.TemporaryDirectory() as folder:
        build_map(arm, 0.5, Path(folder, "first.zarr"), orientations=12)
        path = Path(folder, "map.zarr")
        begin = time.process_time()
        took, chart = seconds(lambda: build_map(arm, arguments.step, path, orientations=arguments.orientations))
        disk = sum(each.stat().st_size for each in path.rglob("*") if each.is_file())
        print(f"{chart}: {chart.plan.cells:,} cells in {took:.1f} s, {1e-6 * disk:.1f} MB")
        print(f"{time.process_time() - begin:.1f} s of processor time")
        checked = chart.verify(100_000)
        print(
            f"{checked.rebuilt:,} postures rebuilt, off by {checked.worst:.2g} m or rad; {checked.different} different"
        )
        sampled(arm, chart, took, rng)
        empty(arm, chart, arguments.empty, arguments.restarts, rng)


if __name__ == "__main__":
    main()
