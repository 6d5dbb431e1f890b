"""Draws docs/preview.jpg: what the preview shows of two arms, photographed in a headless browser.

Run: python docs/preview_picture.py (needs playwright and Chromium, see the extra "test")
"""

import io
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, sync_playwright

import srs_ik

SIZE = (600, 560)


def photograph(browser: Browser, view: srs_ik.Preview) -> Image.Image:
    page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
    page.goto(view.url)
    page.add_style_tag(content=".dg { display: none }")
    page.wait_for_timeout(3000)
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    page.close()
    return image


def feasible_arm_angles(browser: Browser) -> Image.Image:
    arm = srs_ik.load("iiwa14")
    with srs_ik.Preview(arm) as view:
        q = np.array([0.3, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])
        view.show(q)
        view.show_intervals(arm.forward_kinematics(q))
        return photograph(browser, view)


def ellipsoids(browser: Browser) -> Image.Image:
    arm = srs_ik.load("gen3")
    with srs_ik.Preview(arm) as view:
        pose = np.diag([1.0, -1.0, -1.0, 1.0])
        pose[:3, 3] = 0.45, -0.1, 0.35
        view.show_ellipsoids(arm.solve(pose).q)
        return photograph(browser, view)


def task(browser: Browser) -> Image.Image:
    arm = srs_ik.load("human_arm")
    task = srs_ik.Task(position=[0.45, 0.15, -0.3], velocity=[1, 0, 0], force=[0, 0, -1], grasp=[1, 0, 0])
    with srs_ik.Preview(arm) as view:
        view.show(arm.solve_task(task).q)
        view.show_posture(arm.posture(task), task)
        return photograph(browser, view)


def side_by_side(*draw: Callable[[Browser], Image.Image]) -> Image.Image:
    """Pictures that are drawn in a browser, in a row."""
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or playwright.chromium.executable_path
        options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=chromium, args=options)
        pictures = [each(browser) for each in draw]
        browser.close()
    whole = Image.new("RGB", (len(pictures) * SIZE[0], SIZE[1]))
    for k, picture in enumerate(pictures):
        whole.paste(picture, (k * SIZE[0], 0))
    return whole


if __name__ == "__main__":
    whole = side_by_side(feasible_arm_angles, ellipsoids, task)
    whole.save(Path(__file__).with_name("preview.jpg"), quality=90, optimize=True)
