"""Makes the table of docs/robots_tried.md: python docs/robots_tried.py FOLDER_WITH_URDF_FILES.

Every arm that is found is asked for the poses of random configurations inside its limits. The poses come from Pinocchio
on the file as it is, and what is solved is checked by it; nothing of srs_ik takes part in either.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

import srs_ik

PAGE = Path(__file__).with_name("robots_tried.md")
BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"

UPSTREAM = {
    "abb_yumi": "OrebroUniversity/yumi",
    "franka_fr3": "frankarobotics/franka_description",
    "iiwa14_drake_models": "RobotLocomotion/models",
    "iiwa14_kuka_experimental": "ros-industrial/kuka_experimental",
    "kinova_gen3_7dof": "Kinovarobotics/ros2_kortex",
    "kinova_j2s7s300": "Kinovarobotics/kinova-ros",
    "med7_lbr_stack": "lbr-stack/lbr_fri_ros2_stack",
    "motoman_sia10f": "ros-industrial/motoman",
    "motoman_sia5d": "ros-industrial/motoman",
    "openarm_v10_bimanual": "enactic/openarm_description",
    "realman_rm75": "RealManRobot/ros2_rm_robot",
    "sawyer": "RethinkRobotics/sawyer_robot",
    "unitree_h1_2_handless": "unitreerobotics/unitree_ros",
    "xarm7": "xArm-Developer/xarm_ros2",
}
EXAMPLE_ROBOT_DATA = (
    "human.urdf",
    "simple_humanoid.urdf",
    "romeo.urdf",
    "icub.urdf",
    "alex_nub_hands.urdf",
    "b1-z1.urdf",
    "baxter.urdf",
    "centauro.urdf",
    "g1_29dof_rev_1_0.urdf",
    "panda.urdf",
    "pr2.urdf",
    "talos_full_v2.urdf",
    "tiago.urdf",
    "tiago_dual.urdf",
    "tiago_pro.urdf",
)
"""One file of every robot there that has a chain of seven joints."""


class Measured(NamedTuple):
    """What became of the poses of one arm."""

    solved: int
    asked: int
    position_error: float
    orientation_error: float


class Oracle:
    """Forward kinematics of an arm by Pinocchio on the untouched file, all other joints at their neutral position."""

    def __init__(self, path: Path, arm: srs_ik.Arm) -> None:
        # Pinocchio refuses negative limits, which some makers write for "not given"; they play no part in a pose.
        self.model = pin.buildModelFromXML(re.sub(r'(effort|velocity)="-[\d.]+"', r'\1="0"', path.read_text()))
        self.data = self.model.createData()
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in arm.joint_names]
        self.base, self.tip = self.model.getFrameId(arm.base), self.model.getFrameId(arm.tip)

    def __call__(self, q: np.ndarray) -> pin.SE3:
        configuration = pin.neutral(self.model)
        for angle, joint in zip(q, self.joints, strict=True):
            values = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            configuration[joint.idx_q : joint.idx_q + joint.nq] = values
        pin.framesForwardKinematics(self.model, self.data, configuration)
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip])


def distance(wanted: pin.SE3, reached: pin.SE3) -> tuple[float, float]:
    """Metres and radians between two poses; the angle without the loss of digits of an arc cosine."""
    turn = wanted.rotation.T @ reached.rotation
    skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = np.arctan2(np.linalg.norm(skew), np.trace(turn) - 1.0)
    return float(np.linalg.norm(wanted.translation - reached.translation)), float(angle)


def measure(path: Path, arm: srs_ik.Arm, count: int) -> Measured:
    """Solve the poses of random configurations inside the limits of an arm."""
    rng = np.random.default_rng(7)
    forward = Oracle(path, arm)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    solved, errors = 0, [(0.0, 0.0)]
    for _ in range(count):
        pose = forward(rng.uniform(lower, upper))
        solution = arm.solve(pose)
        inside = bool((solution.q >= arm.lower).all() and (solution.q <= arm.upper).all())
        if solution and inside:
            solved += 1
            errors.append(distance(pose, forward(solution.q)))
    worst = np.max(errors, axis=0)
    return Measured(solved, count, float(worst[0]), float(worst[1]))


def files(folder: Path) -> Iterator[tuple[str, Path]]:
    """Where each file is from, and its path."""
    for path in sorted(folder.glob("*.urdf")):
        yield UPSTREAM.get(path.stem, "-"), path
    for file in metadata.files("example-robot-data") or []:
        if file.name in EXAMPLE_ROBOT_DATA:
            yield "example-robot-data", Path(str(file.locate())).resolve()


def rows(folder: Path, count: int) -> Iterator[str]:
    """The lines of the table."""
    heads = ["file", "from", "base to tip", "recognised as", "elbow offset (mm)", "axes miss by (mm)", "solved"]
    yield f"| {' | '.join([*heads, 'worst error (m)', 'worst error (rad)'])} |"
    yield "|---|---|---|---|--:|--:|--:|--:|--:|"
    for upstream, path in files(folder):
        for report in srs_ik.find_limbs(path):
            ends = f"`{report.base}` to `{report.tip}`"
            # Where axes are parallel there is no centre to miss.
            miss = "" if np.isnan(report.misses_mm).all() else f"{report.misses_mm.max():.3f}"
            start = f"| {path.name} | {upstream} | {ends} |"
            if report.limb is None:
                yield f"{start} refused: {report.reason} | | {miss} | | | |"
                continue
            m = measure(path, srs_ik.load(path, base=report.base, tip=report.tip), count)
            yield (
                f"{start} {report.kind}, {report.wrist_kind} wrist | {1e3 * report.elbow_offset:.3f} | {miss} "
                f"| {m.solved} of {m.asked} | {m.position_error:.1e} | {m.orientation_error:.1e} |"
            )


def main() -> None:
    """Write the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder with .urdf files")
    parser.add_argument("--count", type=int, default=500, help="configurations an arm (default: 500)")
    options = parser.parse_args()
    table = "\n".join(rows(options.folder, options.count))
    before, rest = PAGE.read_text().split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}")
    print(table)


if __name__ == "__main__":
    main()
