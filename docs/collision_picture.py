"""Draws docs/pictures/collisions.png: an arm among objects, photographed in a headless browser.

Run: python docs/collision_picture.py (needs playwright and Chromium, see the extra "test")
"""

import shutil
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, sync_playwright
from preview_picture import SIZE, photograph

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
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or playwright.chromium.executable_path
        options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=chromium, args=options)
        pictures = [in_scene(browser, ball) for ball in (0.25, 0.12)]
        browser.close()
    whole = Image.new("RGB", (len(pictures) * SIZE[0], SIZE[1]))
    for k, picture in enumerate(pictures):
        whole.paste(picture, (k * SIZE[0], 0))
    whole.save(Path(__file__).parent / "pictures" / "collisions.png", optimize=True)
