"""Making a map: planned, computed on threads or by Dask, and resumed where it was left."""

from __future__ import annotations

import contextlib
import os
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidMap, MissingExtra, quoted
from srs_ik.kinematics import check_arm
from srs_ik.maps.extras import around_of, task_of
from srs_ik.maps.grid import Grid, box, half_plane
from srs_ik.maps.orientations import orientations_of
from srs_ik.maps.plan import Plan, arcs_of, checked_measures, robot_of, whole
from srs_ik.maps.store import Store, clear_leftovers, create, folder_of, held, refuse_other
from srs_ik.maps.tasks import Job, in_base, job_of, measures_at, run_task
from srs_ik.solve.threads import checked_threads, processors

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.maps.reader import Map

Progress = Callable[[int, int], None]

ARRIVAL = 30.0
"""How long the first worker of a cluster may take until it is there, seconds: who starts both at once need not wait."""

WAITING = 3
"""Tasks for each worker that are handed out at once: none has to wait, and none is lost in a queue."""

PROBED = 2_000
"""Cells that an estimate computes, and at most this long, seconds:"""
PROBE_TIME = 3.0

COMPRESSED = 0.15
"""Part of the bytes of a map that is left of them on disk: between 0.05 and 0.2 as measured."""


@dataclass(frozen=True)
class Estimate:
    """What a map will take.

    Attributes:
        positions: number of positions.
        orientations: number of orientations.
        cells: their product.
        tasks: chunks of the store.
        rate: cells a second on one processor.
        seconds: on all workers.
        workers: so many.
        disk: bytes on disk, about.
        memory: bytes of all workers on one machine beyond Python itself, at most.
    """

    positions: int
    orientations: int
    cells: int
    tasks: int
    rate: float
    seconds: float
    workers: int
    disk: int
    memory: int


def plan_map(
    arm: Arm,
    step: float = 0.05,
    *,
    orientations: int = 2304,
    box_bounds: object = False,
    measures: Iterable[str] = (),
    scene: Scene | None = None,
    velocity: ArrayLike | None = None,
    force: ArrayLike | None = None,
) -> Plan:
    """What `build_map` would make, arguments as there; raises InvalidMap where they fit no map."""
    check_arm(arm)
    chosen = orientations_of(orientations)
    task = task_of(velocity, force)
    if box_bounds is False and (scene is not None or task is not None):
        raise InvalidMap("a half-plane turns about axis 1, and a scene or a task does not turn with it: map a box")
    names = checked_measures(measures, scene is not None, task is not None)
    around = around_of(arm, scene)
    grid: Grid = (
        half_plane(arm, step) if box_bounds is False else box(arm, step, None if box_bounds is True else box_bounds)
    )
    arcs = arcs_of(arm) if box_bounds is False else 0
    return Plan(robot_of(arm), grid, chosen, names, arcs, None if around is None else around.digest, task)


def build_map(
    arm: Arm,
    step: float = 0.05,
    path: str | os.PathLike[str] = "map.zarr",
    client: Any = None,
    *,
    orientations: int = 2304,
    box: object = False,
    measures: Iterable[str] = (),
    scene: Scene | None = None,
    velocity: ArrayLike | None = None,
    force: ArrayLike | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Map:
    """Make a map of what an arm reaches and how well, or go on with one that was left half made.

    Every cell is a pose that is answered exactly. Killed at any moment, what is done stays done. It is checked before
    anything is made, some 5 ms a task; tasks whose files are damaged are made again, and a warning says so.

    Args:
        arm: the arm.
        step: distance between positions, metres.
        path: folder of the store.
        client: a ``dask.distributed.Client`` whose workers see that folder; threads of this process if not given.
        orientations: how many, 12 x 4^k x rolls.
        box: False for the half-plane through axis 1; True for a box around all that the arm reaches, or (3, 2) lower
            and upper x, y and z in the base frame, metres.
        measures: "margin" and "manipulability" if they are wanted too.
        scene: brings the measure "free", the width of the feasible arm angles that touch nothing; boxes only.
        velocity: (3,) direction in which a task moves, base frame; brings with `force` the measures "ratio", the
            smallest force-velocity ratio C, and "ratio_arm_angle" and "ratio_branch" of that posture; boxes only.
        force: (3,) direction in which the task pushes, base frame.
        threads: at most so many; all processors if not given.
        progress: called with the cells that are done and all cells, after each task that is found whole or made.

    Raises:
        InvalidMap: the arguments fit no map, another process makes it just now, the folder holds another one or cannot
            be written, or a cluster has no worker after 30 s.
        InvalidConfiguration: `threads` is no positive integer.
        InvalidScene: this is no scene.
        NoBodies: with a scene, no shapes of the arm are at hand.
        MissingExtra: Zarr is not installed.
    """
    from srs_ik.maps.reader import open_map

    folder = folder_of(path)
    if progress is not None and not callable(progress):
        raise InvalidMap(f"progress is a function of two numbers, not {quoted(progress)}")
    if client is not None and not hasattr(client, "nthreads"):
        raise InvalidMap(f"client is a dask.distributed.Client, not {quoted(client)}")
    more: dict[str, Any] = {"measures": measures, "scene": scene, "velocity": velocity, "force": force}
    plan = plan_map(arm, step, orientations=orientations, box_bounds=box, **more)
    if not folder.exists():
        with contextlib.suppress(FileExistsError):
            create(folder, plan)
    refuse_other(Store(folder), plan)
    with held(folder):
        clear_leftovers(folder)
        _make(job_of(arm, plan, scene), folder, client, threads, progress)
    return open_map(folder, arm, scene)


def _make(job: Job, folder: Path, client: Any, threads: int | None, progress: Progress | None) -> None:
    """Make what is left to be made of a map."""
    plan, done = job.plan, 0
    sizes = [_size(block) * len(plan.orientations) for block in plan.blocks]

    def tell(task: int) -> None:
        nonlocal done
        done += sizes[task]
        if progress is not None:
            progress(done, plan.cells)

    left = _left(Store(folder, writable=True), tell)
    _warm(job)
    for task in _by_threads(job, folder, left, threads) if client is None else _by_dask(client, job, folder, left):
        tell(task)


def _left(store: Store, tell: Callable[[int], None]) -> list[int]:
    """The tasks that are not done, or whose files are damaged; `tell` is told of each of the others."""
    # A measure that cannot be opened at all is an error: making tasks again does not mend it.
    for name in store.names:
        store.array(name)
    records = store.records()
    done = np.flatnonzero(records).tolist()
    damaged = []
    for task in done:
        if store.is_whole(task, int(records[task])):
            tell(task)
        else:
            damaged.append(task)
            store.forget(task)
    if damaged:
        said = f"{store.path}: {len(damaged)} of {len(done)} tasks that were done are damaged, and made again"
        warnings.warn(said, UserWarning, stacklevel=4)
    return np.flatnonzero(store.records() == 0).tolist()


def estimate(
    arm: Arm,
    step: float = 0.05,
    *,
    orientations: int = 2304,
    box: object = False,
    measures: Iterable[str] = (),
    scene: Scene | None = None,
    velocity: ArrayLike | None = None,
    force: ArrayLike | None = None,
    workers: int | None = None,
) -> Estimate:
    """What `build_map` will take, from the time of some of its cells; arguments as there, and processors to share it.

    Raises:
        InvalidMap: the arguments fit no map.
    """
    more: dict[str, Any] = {"measures": measures, "scene": scene, "velocity": velocity, "force": force}
    plan = plan_map(arm, step, orientations=orientations, box_bounds=box, **more)
    job = job_of(arm, plan, scene)
    _warm(job)
    rng, rotations = np.random.default_rng(0), in_base(plan)
    points = plan.grid.points(tuple(slice(0, n) for n in plan.grid.shape)) if _few(plan) else None
    count, begin = 0, time.perf_counter()
    while count < PROBED or (time.perf_counter() - begin < 0.2 and count < 100 * PROBED):
        point = points[rng.integers(len(points))][None] if points is not None else _random_point(plan, rng)
        some = np.ascontiguousarray(rotations[rng.integers(len(rotations), size=20)])
        measures_at(job, point, some)
        count += 20
        if time.perf_counter() - begin > PROBE_TIME:
            break
    rate = count / (time.perf_counter() - begin)
    workers = processors() if workers is None else whole(workers, "workers", 1)
    largest = max(_size(block) for block in plan.blocks) * len(plan.orientations)
    return Estimate(
        positions=plan.cells // len(plan.orientations),
        orientations=len(plan.orientations),
        cells=plan.cells,
        tasks=len(plan.blocks),
        rate=rate,
        seconds=plan.cells / rate / workers,
        workers=workers,
        disk=int(COMPRESSED * plan.bytes_a_cell * plan.cells),
        memory=2 * workers * largest * plan.bytes_a_cell,
    )


def _few(plan: Plan) -> bool:
    return plan.cells // len(plan.orientations) < 10**6


def _random_point(plan: Plan, rng: np.random.Generator) -> Any:
    at = [int(rng.integers(n)) for n in plan.grid.shape]
    return plan.grid.points(tuple(slice(i, i + 1) for i in at))


def _size(block: tuple[slice, ...]) -> int:
    return int(np.prod([part.stop - part.start for part in block]))


def _warm(job: Job) -> None:
    """Compile before workers begin: each would do it again."""
    measures_at(job, job.plan.grid.points(tuple(slice(0, 1) for _ in job.plan.grid.shape)), in_base(job.plan)[:1])


def _by_threads(job: Job, folder: Path, left: list[int], threads: int | None) -> Iterator[int]:
    count = checked_threads(threads)
    tasks, running, stop = iter(left), set(), Event()
    pool = ThreadPoolExecutor(count)
    try:
        for task in tasks:
            running.add(pool.submit(run_task, job, str(folder), task, stop))
            if len(running) > count:
                finished, running = wait(running, return_when=FIRST_COMPLETED)
                yield from (future.result()[0] for future in finished)
        while running:
            finished, running = wait(running, return_when=FIRST_COMPLETED)
            yield from (future.result()[0] for future in finished)
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


def _by_dask(client: Any, job: Job, folder: Path, left: list[int]) -> Iterator[int]:
    try:
        from dask.distributed import TimeoutError as NoneCame
        from dask.distributed import as_completed
    except ImportError:
        raise MissingExtra("maps", "a map by Dask") from None
    path = str(folder.absolute())
    try:
        client.wait_for_workers(1, timeout=ARRIVAL)
    except NoneCame:
        raise InvalidMap(f"the Dask cluster has no worker, and none came within {ARRIVAL:g} s") from None
    workers = sum(client.nthreads().values())
    tasks = iter(left)

    def more() -> Any:
        task = next(tasks, None)
        return None if task is None else client.submit(run_task, job, path, task, pure=False, retries=2)

    first = [future for future in (more() for _ in range(WAITING * workers)) if future is not None]
    queue = as_completed(first)
    for future in queue:
        task, _ = future.result()
        following = more()
        if following is not None:
            queue.add(following)
        yield task
