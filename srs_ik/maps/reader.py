"""A map that is made: what it says of poses and positions, and whether it is right."""

from __future__ import annotations

import copy
import math
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidMap, InvalidPose, quoted
from srs_ik.inputs.numbers import as_flag, real_array
from srs_ik.inputs.poses import as_matrices
from srs_ik.kinematics import check_arm
from srs_ik.maps.fingerprint import fingerprint
from srs_ik.maps.placement import refuse_no_poses
from srs_ik.maps.plan import FREE, OF_SCENE, OF_TASK, RATIO, YAW, whole
from srs_ik.maps.store import DONE, Store, folder_of
from srs_ik.maps.tasks import compute, job_of
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene

Indices = NDArray[np.int64]

TURN = 2.0 * math.pi

CELLS_A_POSITION = 50
"""Cells of one position that a check computes again."""

INTERPOLATED = ("width", "widest", "margin", "manipulability", FREE, RATIO)


@dataclass(frozen=True, eq=False)
class MapAnswer:
    """What a map says of N poses.

    Attributes:
        reached: (N,) whether the arm reaches them.
        measures: (N,) of each measure of the map, by name; 0 outside the map and where a pose is not reached.
        inside: (N,) whether they lie inside the map, and in a part of it that is made.
    """

    reached: NDArray[np.bool_]
    measures: dict[str, NDArray]
    inside: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.reached)

    def __repr__(self) -> str:
        return f"MapAnswer({len(self)} poses, {self.reached.sum()} reached, measures {', '.join(self.measures)})"


@dataclass(frozen=True)
class Verified:
    """What checking a map has found.

    Attributes:
        tasks: tasks whose checksums were compared.
        damaged: those whose files do not hold what was written.
        cells: cells that were computed again.
        different: those whose measures differ.
        rebuilt: cells whose posture was rebuilt and measured by Pinocchio.
        worst: largest distance of one from its pose, m or rad.
    """

    tasks: int
    damaged: tuple[int, ...]
    cells: int
    different: int
    rebuilt: int
    worst: float

    def __bool__(self) -> bool:
        return not self.damaged and not self.different and self.worst < 1e-9


def open_map(path: str | os.PathLike[str], arm: Arm | None = None, scene: Scene | None = None) -> Map:
    """Open a map, whole or half made.

    Args:
        path: folder of the store.
        arm: the arm that it is of, for exact answers and checks.
        scene: the scene that it is of, if it is of one, for the same.

    Raises:
        InvalidMap: there is none, or it is that of another robot or scene.
        InvalidRobot: this is no arm.
        InvalidScene: this is no scene.
        MissingExtra: Zarr is not installed.
    """
    if arm is not None:
        check_arm(arm)
    return Map(Store(folder_of(path)), arm, scene)


def check_map(chart: Any) -> None:
    """Raise InvalidMap for what is no map, such as its folder, before anything is asked of it."""
    if not isinstance(chart, Map):
        hint = "; open it first" if isinstance(chart, str | os.PathLike) else ""
        raise InvalidMap(f"a map is what build_map or open_map gives, not {quoted(chart)}{hint}")


class Map:
    """A map of what an arm reaches; made by `build_map` or `open_map`.

    Attributes:
        plan: what it holds.
        path: its folder.
        arm: the arm that it is of, or None.
        scene: the scene that it is of, or None.
    """

    def __init__(self, store: Store, arm: Arm | None = None, scene: Scene | None = None) -> None:
        self.store, self.plan, self.path, self.arm = store, store.plan, store.path, arm
        # As it stands now: moved later, it is another one.
        self.scene = copy.copy(scene)
        self._made = np.zeros(len(self.plan.blocks), bool)
        if arm is not None and fingerprint(arm) != self.plan.robot["fingerprint"]:
            robot = self.plan.robot
            raise InvalidMap(
                f"{self.path} is a map of {robot['name']}, tip {robot['tip']}: {arm.name} with these limits and this "
                "tool is another robot"
            )
        if arm is not None and scene is not None and fingerprint(arm, scene) != self.plan.scene:
            raise InvalidMap(
                f"{self.path} is no map of this scene as it stands now, with these bodies and pairs of the arm"
            )

    @property
    def done(self) -> float:
        """Share of the tasks that are done."""
        return float((self.store.records() > 0).mean())

    def measure(self, name: str) -> NDArray:
        """All cells of a measure as an array: positions, then orientations; 0 where they are not made yet.

        Raises:
            InvalidMap: the map has none of that name, or has lost files.
        """
        self._check(name)
        values = self.store.array(name).zeros()
        for task, record in enumerate(self.store.records().tolist()):
            values[self.plan.block(task)] = self.part(name, task, record)
        return values

    def _check(self, name: str) -> None:
        if not isinstance(name, str) or name not in self.store.names:
            raise InvalidMap(f"{self.path} has no measure {quoted(name)}; it has {', '.join(self.store.names)}")

    # Poses ------------------------------------------------------------------------------------------------------

    def cells_of(self, poses: Any) -> tuple[Indices, Array, NDArray[np.bool_]]:
        """The cells in which poses lie.

        Returns:
            (N, d + 1) places along each direction and among the orientations, (N,) yaw of each pose, rad (0 in a box),
            and (N,) whether it lies inside the map, and in a part of it that is made.
        """
        T = as_matrices(poses)
        refuse_no_poses(T)
        where, rotation, yaw = self._in_map(T)
        at = np.floor(where).astype(np.int64)
        shape = np.array(self.plan.grid.shape)
        inside: NDArray[np.bool_] = np.asarray(np.logical_and(at >= 0, at < shape).all(axis=1))
        at = np.clip(at, 0, shape - 1)
        inside[inside] = self._is_made(self.plan.tasks_of(at[inside]))
        return np.column_stack([at, self.plan.orientations.index(rotation)]), yaw, inside

    def _is_made(self, tasks: Indices) -> NDArray[np.bool_]:
        """Whether tasks are done; each is looked up until it is, and its files are checked then."""
        open_ones = np.unique(tasks[~self._made[tasks]])
        if len(open_ones):
            records = self.store.array(DONE).vindex[open_ones]
            for task, record in zip(open_ones[records > 0], records[records > 0], strict=True):
                self.store.refuse_damaged(int(task), int(record))
            self._made[open_ones] = records > 0
        return self._made[tasks]

    def part(self, name: str, task: int, record: int) -> NDArray:
        """What a task, with its record, has found of a measure, an array over its cells: zeros until it is done.

        Raises:
            InvalidMap: zeros are all that is left of lost files.
        """
        values = self.store.array(name)[self.plan.block(task)]
        if not record:
            return np.zeros_like(values)
        if not values.any():
            self.store.refuse_damaged(task, record)
        return values

    def _in_map(self, T: Array) -> tuple[Array, Array, Array]:
        """Places (N, d) in cells, rotations (N, 3, 3) with the yaw taken off, and the yaw (N,)."""
        grid = self.plan.grid
        frame = grid.pose
        p = (T[:, :3, 3] - frame[:3, 3]) @ frame[:3, :3]
        R = frame[:3, :3].T @ T[:, :3, :3]
        if grid.kind == "box":
            return (p - np.array(grid.lower)) / grid.step, R, np.zeros(len(T))
        yaw = np.arctan2(p[:, 1], p[:, 0])
        c, s = np.cos(yaw), np.sin(yaw)
        back = np.zeros((len(T), 3, 3))
        back[:, 0, 0], back[:, 0, 1], back[:, 1, 0], back[:, 1, 1], back[:, 2, 2] = c, s, -s, c, 1.0
        flat = np.stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]], axis=1)
        return (flat - np.array(grid.lower)) / grid.step, back @ R, yaw

    def query(self, poses: Any, exact: bool = False) -> MapAnswer:
        """What the map says of poses, or, exactly, what the arm answers.

        From the map, whether a pose is reached, its branches and its pieces are those of the cell in which it lies, at
        its own yaw; widths and margins are interpolated between the positions around, ratios between those that are
        reached. In a half-plane they set the limits of joint 1 aside.

        Args:
            poses: (N, 4, 4) array or list of poses of the tip in the base frame.
            exact: whether the arm has to answer; slower for near arms only.

        Raises:
            InvalidPose: a pose is no finite rigid transform.
            InvalidMap: files of the part that is asked are damaged, or exact answers are asked for, and the map was
                opened without its arm.
        """
        at, yaw, inside = self.cells_of(poses)
        if as_flag(exact, "exact", InvalidMap):
            return self._exact(as_matrices(poses), inside)
        index = tuple(at.T)
        reached = inside & (self.store.array("reached").vindex[index] > 0)
        if self.plan.arcs:
            reached &= self._at_yaw(index, yaw)
        measures: dict[str, NDArray] = {}
        for name in self.plan.measures:
            values = self._around(name, as_matrices(poses), at) if name in INTERPOLATED else None
            if values is None:
                values = self.store.array(name).vindex[index]
            measures[name] = np.where(reached, values, np.zeros((), values.dtype))
        return MapAnswer(reached, measures, inside)

    def _at_yaw(self, index: tuple[Indices, ...], yaw: Array) -> NDArray[np.bool_]:
        met = np.zeros(len(yaw), bool)
        for arc in range(self.plan.arcs):
            start, width = (self.store.array(YAW).vindex[(*index, _all(arc, yaw), _all(k, yaw))] for k in (0, 1))
            met |= (width > 0.0) & ((yaw - start) % TURN <= width)
        return met

    def _around(self, name: str, T: Array, at: Indices) -> Array:
        """A measure interpolated between the centres around, at the orientation of the cell."""
        where = self._in_map(T)[0] - 0.5
        shape = np.array(self.plan.grid.shape)
        low = np.clip(np.floor(where).astype(np.int64), 0, np.maximum(shape - 2, 0))
        share = np.clip(where - low, 0.0, 1.0)
        total, weights = np.zeros(len(T)), np.zeros(len(T))
        for corner in np.ndindex(*(2,) * len(shape)):
            weight = np.where(corner, share, 1.0 - share).prod(axis=1)
            place = np.minimum(low + corner, shape - 1)
            cells = (*place.T, at[:, -1])
            # Cells that are not made yet count as not reached.
            made = self._is_made(self.plan.tasks_of(place))
            if name == RATIO:
                # Smaller ratios are better ones: the 0 of a cell that is not reached is none.
                weight = weight * (made & (self.store.array("reached").vindex[cells] > 0))
            total += weight * made * self.store.array(name).vindex[cells]
            weights += weight
        return np.divide(total, weights, out=total, where=weights > 0.0)

    def _exact(self, T: Array, inside: NDArray[np.bool_]) -> MapAnswer:
        from srs_ik.maps.live import measures_of

        arm = self._own_arm("exact answers")
        names = [name for name in self.plan.measures if name not in (*OF_SCENE, *OF_TASK)]
        velocity, force = self.plan.task or (None, None)
        measures = measures_of(arm, T, names, scene=self.scene, velocity=velocity, force=force)
        return MapAnswer(measures["reached"] > 0, measures, inside)

    def _own_arm(self, what: str) -> Arm:
        if self.arm is None:
            raise InvalidMap(f"{what} need the arm of the map: open_map(path, arm)")
        if self.plan.scene is not None and self.scene is None:
            raise InvalidMap(f"{what} need the scene of the map: open_map(path, arm, scene)")
        return self.arm

    # Positions --------------------------------------------------------------------------------------------------

    def share(self, points: Any) -> Array:
        """(N,) share of the orientations that are reached at points (N, 3) of the base frame, metres, 0 to 1.

        Raises:
            InvalidPose: a point is not three finite numbers.
        """
        try:
            points = real_array(points)
        except (TypeError, ValueError):
            raise InvalidPose("points are an (N, 3) array of metres") from None
        if points.shape[-1:] != (3,):
            raise InvalidPose(f"points are an (N, 3) array of metres, not an array of shape {points.shape}")
        points = points.reshape(-1, 3)
        T = np.tile(np.eye(4), (len(points), 1, 1))
        T[:, :3, 3] = points
        at, yaw, inside = self.cells_of(T)
        found = np.zeros(len(points))
        cells, which = np.unique(at[:, :-1], axis=0, return_inverse=True)
        for i, cell in enumerate(cells):
            mine = np.flatnonzero((which.ravel() == i) & inside)
            if not len(mine):
                continue
            if not self.plan.arcs:
                found[mine] = self.store.array("reached")[tuple(cell)].mean()
                continue
            arcs = self.store.array(YAW)[tuple(cell)]
            ahead = (yaw[mine, None, None] - arcs[None, ..., 0]) % TURN
            found[mine] = ((arcs[..., 1] > 0.0) & (ahead <= arcs[..., 1])).any(axis=2).mean(axis=1)
        return found

    def mean(self, name: str) -> Array:
        """A measure as an array over all positions: its mean over orientations. For "yaw": the mean share of a turn.

        Smaller ratios are better ones, so "ratio" has its mean over what is reached alone; 0 where nothing is, and
        where the map is not made yet.

        Raises:
            InvalidMap: the map has none of that name, or has lost files.
        """
        self._check(name)
        found = np.zeros(self.plan.grid.shape)
        for task, record in enumerate(self.store.records().tolist()):
            block, values = self.plan.block(task), self.part(name, task, record)
            if name == YAW:
                values = values[..., 1].sum(axis=-1) / TURN
            found[block] = values.mean(axis=len(block))
            if name == RATIO:
                share = (self.store.array("reached")[block] > 0).mean(axis=len(block))
                found[block] /= np.where(share > 0.0, share, 1.0)
        return found

    # Checks -----------------------------------------------------------------------------------------------------

    def verify(self, count: int = 1000, seed: int = 0) -> Verified:
        """Compare all checksums, compute cells again, and measure rebuilt postures by Pinocchio.

        Args:
            count: cells to compute again, of those that are done.
            seed: of the random choice of cells.

        Raises:
            InvalidMap: the map was opened without its arm, or count or seed is no whole number.
        """
        from srs_ik.maps.live import rebuild

        arm = self._own_arm("checks")
        count, seed = (whole(given, what) for given, what in ((count, "count"), (seed, "seed")))
        records = self.store.records()
        done = np.flatnonzero(records)
        damaged = tuple(int(task) for task in done if not self.store.is_whole(int(task), int(records[task])))
        rng, job = np.random.default_rng(seed), job_of(arm, self.plan, self.scene)
        cells = different = rebuilt = 0
        worst = 0.0
        while len(done) and cells < count:
            block = self.plan.block(int(rng.choice(done)))
            one = tuple(slice(i, i + 1) for i in (int(rng.integers(part.start, part.stop)) for part in block))
            there, again = self.store.read(one), compute(job, one)
            n = min(len(self.plan.orientations), CELLS_A_POSITION, count - cells)
            some = rng.choice(len(self.plan.orientations), n, replace=False)
            at = (0,) * len(one)
            for name in self.store.names:
                off = ~np.isclose(there[name][at][some], again[name][at][some], rtol=1e-6, atol=1e-9)
                different += int(off.reshape(n, -1).any(axis=1).sum())
            cells += n
            met = some[there["reached"][at][some] > 0]
            worst = max(worst, rebuild(arm, self.plan, one, met, there))
            rebuilt += len(met)
        return Verified(len(done), damaged, cells, different, rebuilt, worst)

    def __repr__(self) -> str:
        plan = self.plan
        where = " x ".join(str(n) for n in plan.grid.shape)
        what = f"{plan.grid.kind}, {where} positions {plan.grid.step:g} m apart, {len(plan.orientations)} orientations"
        return f"<Map of {plan.robot['name']}: {what}, {100.0 * self.done:.3g} % done>"


def _all(value: int, like: Array) -> Indices:
    return np.full(len(like), value, np.int64)
