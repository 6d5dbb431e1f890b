"""Draws the pictures of the documentation from the package itself, into docs/pictures/.

Run: python docs/pictures.py
"""

from pathlib import Path

import concept_pictures
import numpy as np

import srs_ik

FOLDER = Path(__file__).resolve().parent / "pictures"
Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
STRETCHED = np.array([0.3, 0.7, 0.2, 0.0, 0.4, 0.0, -0.2])


def strips(arm: srs_ik.Arm) -> object:
    """A joint motion that takes shoulder and wrist through their singular postures, and the path of its poses."""
    t = np.linspace(0.0, 1.0, 160)[:, None]
    known = Q + np.array([0.6, 1.1, 0.4, 0.5, 0.5, 1.2, 0.6]) * np.sin(2.0 * np.pi * t * np.linspace(0.6, 1.2, 7))
    poses = [arm.forward_kinematics(q) for q in known]
    return srs_ik.plots.plot_path(arm, poses, arm.solve_path(poses, seed=known[0]))


def main() -> None:
    arm = srs_ik.load("iiwa14")
    pose = arm.forward_kinematics(Q)
    figures = {
        "ellipsoids": srs_ik.plots.plot_ellipsoids(arm, Q, limits=True),
        "singular": srs_ik.plots.plot_ellipsoids(arm, STRETCHED, limits=True),
        "arm_angle": srs_ik.plots.plot_arm_angle(arm, pose),
        "intervals": srs_ik.plots.plot_intervals(arm, pose),
        "strips": strips(arm),
        "limb": concept_pictures.limb(),
        "redundancy": concept_pictures.redundancy(),
        "posture": concept_pictures.posture(),
    }
    FOLDER.mkdir(exist_ok=True)
    for name, figure in figures.items():
        # Without the version of Matplotlib in it, the file changes only with the picture.
        figure.savefig(FOLDER / f"{name}.png", dpi=110, metadata={"Software": None}, pil_kwargs={"optimize": True})
        print(FOLDER / f"{name}.png")


if __name__ == "__main__":
    main()
