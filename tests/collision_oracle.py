"""What collides, told by Pinocchio on the robot's own file, and clearances of spheres told by NumPy and Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import srs_ik


class Truth:
    """The shapes of a robot file, as Pinocchio reads them, with the pairs that an arm watches."""

    def __init__(self, file, arm: srs_ik.Arm, folders=()) -> None:
        self.arm = arm
        self.model = pin.buildModelFromUrdf(str(file))
        visual = any(body.source == "visual" for body in arm.bodies)
        kind = pin.GeometryType.VISUAL if visual else pin.GeometryType.COLLISION
        self.shapes = pin.buildGeomFromUrdf(self.model, str(file), kind, package_dirs=[str(f) for f in folders])
        owner = [self.model.frames[shape.parentFrame].name for shape in self.shapes.geometryObjects]
        kept = {frozenset((pair.first, pair.second)) for pair in arm.pairs if pair.kept}
        for i in range(len(owner)):
            for j in range(i + 1, len(owner)):
                if frozenset((owner[i], owner[j])) in kept:
                    self.shapes.addCollisionPair(pin.CollisionPair(i, j))
        self.owner = owner
        self.beside = np.zeros(self.model.nq)
        self._data()

    def _data(self) -> None:
        self.data, self.shape_data = self.model.createData(), pin.GeometryData(self.shapes)

    def add(self, name: str, T_base: np.ndarray, geometry) -> None:
        """Add an object to the scene, and pairs of it with all that the arm moves."""
        pin.forwardKinematics(self.model, self.data, pin.neutral(self.model))
        pin.updateFramePlacements(self.model, self.data)
        T_world = self.data.oMf[self.model.getFrameId(self.arm.base)].homogeneous @ T_base
        index = self.shapes.addGeometryObject(pin.GeometryObject(name, 0, pin.SE3(T_world), geometry))
        moved = {body.name for body in self.arm.bodies if body.joint > 0}
        for i, link in enumerate(self.owner):
            if link in moved:
                self.shapes.addCollisionPair(pin.CollisionPair(i, index))
        self._data()

    def put_beside(self, other: srs_ik.Arm, q: np.ndarray) -> None:
        """Move another arm of the robot to a posture, and add pairs of its bodies with all that the arm moves."""
        self.beside = other.configuration(q, self.model) - pin.neutral(self.model)
        moved, others = ({body.name for body in arm.bodies if body.joint > 0} for arm in (self.arm, other))
        for i, first in enumerate(self.owner):
            for j, second in enumerate(self.owner):
                if first in moved and second in others:
                    pair = pin.CollisionPair(min(i, j), max(i, j))
                    if not self.shapes.existCollisionPair(pair):
                        self.shapes.addCollisionPair(pair)
        self._data()

    def hold(self, name: str, bare: srs_ik.Arm, arm: srs_ik.Arm, T_tip: np.ndarray, geometry) -> None:
        """Put an object into the hand, with the pairs that `arm`, which holds it, watches; `bare` does not hold it."""
        tip = self.model.frames[self.model.getFrameId(bare.tip)]
        placed = pin.GeometryObject(name, tip.parentJoint, tip.placement * pin.SE3(T_tip), geometry)
        index = self.shapes.addGeometryObject(placed)
        met = {frozenset((pair.first, pair.second)) - {name} for pair in arm.pairs if pair.kept}
        for i, link in enumerate(self.owner):
            if frozenset((link,)) in met:
                self.shapes.addCollisionPair(pin.CollisionPair(i, index))
        self.owner.append(name)
        self.arm = arm
        self._data()

    def deepest(self, q: np.ndarray) -> tuple[float, tuple[str, str]]:
        """How deep the two bodies are in each other that are so most, m, and their names, each pair asked afresh."""
        whole = self.arm.configuration(q, self.model) + self.beside
        fresh = pin.GeometryData(self.shapes)
        pin.updateGeometryPlacements(self.model, self.data, self.shapes, fresh, whole)
        distances = [pin.computeDistance(self.shapes, fresh, k).min_distance for k in range(len(fresh.distanceResults))]
        pair = self.shapes.collisionPairs[int(np.argmin(distances))]
        names = [*self.owner, *(shape.name for shape in self.shapes.geometryObjects[len(self.owner) :])]
        return -min(distances), (names[pair.first], names[pair.second])

    def collides(self, q: np.ndarray) -> bool:
        """Whether bodies meet at a posture.

        Pinocchio starts each check from what the last one found, and so misses one collision in some hundreds: where it
        finds none, it is asked once more, from the beginning.
        """
        whole = self.arm.configuration(q, self.model) + self.beside
        for data in (self.shape_data, None):
            fresh = pin.GeometryData(self.shapes) if data is None else data
            pin.updateGeometryPlacements(self.model, self.data, self.shapes, fresh, whole)
            if pin.computeCollisions(self.shapes, fresh, True):
                return True
        return False


def file_of(arm: srs_ik.Arm):
    """Robot file of an arm, and folders of its meshes."""
    return arm.drawing.file, list(arm.drawing.file.parents)[:-1]


def file_of_and(arm: srs_ik.Arm):
    """What `Truth` takes of an arm."""
    file, folders = file_of(arm)
    return file, arm, folders


def with_a_thick_neck(folder) -> srs_ik.Arm:
    """iiwa14 with a link 5 that its flange meets where joint 6 is turned far: the range of that joint tells."""
    text = srs_ik.load("iiwa14").drawing.file.read_text()
    assert text.count('radius="0.037"') == 2
    file = folder / "thick.urdf"
    file.write_text(text.replace('radius="0.037"', 'radius="0.0755"'))
    return srs_ik.load(file, base="iiwa_link_0", tip="iiwa_link_ee")


def spheres_at(arm: srs_ik.Arm, tables, q: np.ndarray) -> list[np.ndarray]:
    """(n, 4) spheres of every group of some tables at a posture, by Pinocchio; solids are None.

    A group of the upper arm goes with joint 3, one of the forearm with joint 4, and one of the hand with joint 7.
    """
    frames, zero = arm.joint_frames(q), arm.joint_frames(np.zeros(7))
    carriers = (0, 7, 3, 4)
    found = []
    for first, last, place, kind, _ in tables.groups:
        T = frames[carriers[place]] @ np.linalg.inv(zero[carriers[place]])
        rows = tables.bodies[first:last]
        spheres = np.column_stack([rows[:, :3] @ T[:3, :3].T + T[:3, 3], rows[:, 3]])
        found.append(spheres if kind == 0 else None)
    return found


def clearance(arm: srs_ik.Arm, tables, q: np.ndarray) -> float:
    """Least distance of the spheres of all pairs of groups at a posture, m; from a solid, over its highest plane."""
    spheres = spheres_at(arm, tables, q)
    least = np.inf
    for a, b in tables.pairs:
        if spheres[b] is None:
            planes = tables.bodies[tables.groups[b][0] : tables.groups[b][1]]
            heights = (spheres[a][:, :3] @ planes[:, :3].T - planes[:, 3]).max(axis=1)
            least = min(least, float((heights - spheres[a][:, 3]).min()))
            continue
        gap = np.linalg.norm(spheres[a][:, None, :3] - spheres[b][None, :, :3], axis=2)
        least = min(least, float((gap - spheres[a][:, None, 3] - spheres[b][None, :, 3]).min()))
    return least
