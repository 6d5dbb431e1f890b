"""Maps and places for a base: rates, and a sampled map at equal time. What is right, `map_truth.py` checks.

The sampled map is made by the description of F. Zacharias, C. Borst, G. Hirzinger, Capturing robot workspace structure,
IROS 2007: random joint angles, and each cell of position and orientation that a tip pose falls into is reached.

    python benchmarks/maps.py --robot iiwa14 --poses 1000000
    python benchmarks/maps.py dask --robot iiwa14 --workers 2
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import numpy as np
import pinocchio as pin

import srs_ik
from srs_ik.maps import build_map


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
    begin = time.process_time()
    took, reached = seconds(lambda: arm.reachable_batch(by_pinocchio))
    busy = time.process_time() - begin
    print(
        f"random configurations: {count:,} poses, {(~reached).sum()} missed, {1e6 * took / count:.2f} us a pose, "
        f"{1e6 * busy / count:.2f} us of processor time"
    )
    anywhere = random_poses(arm, min(count, 200_000), rng)
    begin = time.process_time()
    took, reached = seconds(lambda: arm.reachable_batch(anywhere))
    busy = time.process_time() - begin
    print(
        f"random poses: {100.0 * reached.mean():.1f} % reached, {1e6 * took / len(anywhere):.2f} us a pose, "
        f"{1e6 * busy / len(anywhere):.2f} us of processor time"
    )
    grasps = random_poses(arm, 100, rng)
    bases = np.tile(np.eye(4), (1600, 1, 1))
    line = np.linspace(-1.0, 1.0, 40)
    bases[:, :2, 3] = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    for by in ("share", "width", "margin"):
        srs_ik.base_placement(arm, grasps[:2], bases[:2], by=by)
        begin = time.process_time()
        took, found = seconds(lambda by=by: srs_ik.base_placement(arm, grasps, bases, by=by))
        print(
            f"base placement by {by}: 160,000 poses, {100.0 * found.reached.mean():.0f} % reached, {took:.2f} s, "
            f"{time.process_time() - begin:.2f} s of processor time"
        )


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
    T = random_poses(arm, 100_000, rng)
    at, _, inside = _cells(chart, T)
    T, at = T[inside], at[inside]
    truth = arm.reachable_batch(T)
    for name, found in (("the map", chart.query(T).reached), ("the sampled map", hit[tuple(at.T)])):
        print(
            f"random poses by the cells of {name}: {100 * (found == truth).mean():.2f} % right, "
            f"{100 * (truth & ~found).sum() / truth.sum():.2f} % of the reached ones missed, "
            f"{100 * (found & ~truth).sum() / found.sum():.2f} % of its answers wrong"
        )


def dask(arm, given, folder):
    """The same map by threads and by Dask workers, in turn: rates by the clock, started and loaded before."""
    from dask.distributed import Client, LocalCluster

    options = {"n_workers": given.workers, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        build_map(arm, 0.25, Path(folder, "first.zarr"), client, orientations=12)
        took, busy = dict.fromkeys(("threads", "Dask"), 0.0), dict.fromkeys(("threads", "Dask"), 0.0)
        for turn in range(given.turns):
            for name in took:
                how = {"client": client} if name == "Dask" else {"threads": given.workers}
                path = Path(folder, f"{name}{turn}.zarr")
                begin, before = time.perf_counter(), _processor_time(client)
                chart = build_map(arm, given.step, path, orientations=given.orientations, **how)
                took[name] += time.perf_counter() - begin
                busy[name] += _processor_time(client) - before
    cells = given.turns * chart.plan.cells
    for name, each in took.items():
        print(f"{name}: {cells / each:,.0f} cells a second, {1e6 * busy[name] / cells:.2f} us of processor time each")
    share, of_processors = took["threads"] / took["Dask"], busy["threads"] / busy["Dask"]
    print(
        f"{given.turns} times {chart.plan.cells:,} cells, {given.workers} at once: Dask has {100 * share:.0f} % of the "
        f"threads' rate, {100 * of_processors:.0f} % by processor time (client, scheduler and workers)"
    )


def _processor_time(client):
    """Seconds of this process, in which the scheduler runs too, and of all workers."""
    return time.process_time() + sum(client.run(time.process_time).values())


def _cells(chart, T):
    where, rotation, yaw = chart._in_map(T)
    at = np.floor(where).astype(np.int64)
    inside = ((at >= 0) & (at < np.array(chart.plan.grid.shape))).all(axis=1)
    return np.column_stack([at, chart.plan.orientations.index(rotation)]), yaw, inside


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", nargs="?", choices=["rates", "dask"], default="rates")
    parser.add_argument("--robot", default="iiwa14")
    parser.add_argument("--workers", type=int, default=2, help="Dask workers, and threads to compare them with")
    parser.add_argument("--turns", type=int, default=3, help="maps by each")
    parser.add_argument("--poses", type=int, default=100_000)
    parser.add_argument("--step", type=float, default=0.05)
    parser.add_argument("--orientations", type=int, default=2304)
    arguments = parser.parse_args()
    arm, rng = srs_ik.load(arguments.robot), np.random.default_rng(0)
    if arguments.part == "dask":
        with tempfile.TemporaryDirectory() as folder:
            dask(arm, arguments, folder)
        return
    live(arm, arguments.poses, rng)
    with tempfile.TemporaryDirectory() as folder:
        build_map(arm, 0.5, Path(folder, "first.zarr"), orientations=12)
        path = Path(folder, "map.zarr")
        begin = time.process_time()
        took, chart = seconds(lambda: build_map(arm, arguments.step, path, orientations=arguments.orientations))
        disk = sum(each.stat().st_size for each in path.rglob("*") if each.is_file())
        print(f"{chart}: {chart.plan.cells:,} cells in {took:.1f} s, {1e-6 * disk:.1f} MB")
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        print(f"{time.process_time() - begin:.1f} s of processor time, {peak:.0f} MB at the peak of the whole process")
        sampled(arm, chart, took, rng)


if __name__ == "__main__":
    main()
