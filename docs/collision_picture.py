"""Draws docs/pictures/collisions.png: an arm among objects, photographed in a headless browser.

Run: python docs/collision_picture.py (needs playwright and Chromium, see the extra "test")
"""

from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser
from preview_picture import photograph, side_by_side

import srs_ik

Q = np.array([0.3, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])


def in_scene(browser: Browser, elbow_ball: float) -> Image.Image:
    arm = srs_ik.load("iiwa14")
    scene = srs_ik.Scene()
    scene.add_box("table", srs_ik.pose_from_xyz_rpy([0.75, 0.0, 0.1], [0, 0, 0]), [0.6, 0.9, 0.05])
    scene.add_cylinder("can", srs_ik.pose_from_xyz_rpy([0.75, -0.2, 0.225], [0, 0, 0]), 0.05, 0.2)
    scene.add_sphere("lamp", arm.joint_frames(Q)[4, :3, 3] + [0.0, elbow_ball, 0.05], 0.07)
    with srs_ik.Preview(arm) as view:
        view.show(Q)
        view.show_scene(scene, 0.01)
        view.show_intervals(arm.forward_kinematics(Q), scene=scene, margin=0.01)
        return photograph(browser, view)


if __name__ == "__main__":
    whole = side_by_side(*(partial(in_scene, elbow_ball=ball) for ball in (0.25, 0.12)))
    whole.save(Path(__file__).parent / "pictures" / "collisions.png", optimize=True)
