"""Draws docs/following.jpg: the page on which a target is dragged, a moment after that, in a headless browser.

Run: python docs/following_picture.py (needs playwright and Chromium, see the extra "test")
"""

import io
import shutil
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

import srs_ik
from srs_ik.preview import FollowingPreview

SIZE = (1100, 760)
START = np.array([-1.9, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])
CHANGES = (0.3, -0.35, 0.5)
"""What joints 1, 2 and 4 of the postures whose poses become the target differ by, rad, one after the other."""

PATIENCE = 150_000
"""Milliseconds that a busy machine may take to draw the page."""

BETWEEN = 900
A_MOMENT = 260
"""Milliseconds from one target to the next, and from the last one to the picture."""


def main() -> None:
    arm = srs_ik.load("iiwa14")
    with FollowingPreview(arm, START) as view, sync_playwright() as playwright:
        chromium = shutil.which("chromium") or playwright.chromium.executable_path
        options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=chromium, args=options)
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        page.set_default_timeout(PATIENCE)
        page.goto(view.url)
        page.add_style_tag(content=".mantine-Notification-root { display: none }")
        page.get_by_text("reconfigure").wait_for()
        page.wait_for_timeout(4000)
        for change in CHANGES:
            goal = START + change * np.array([1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0])
            view.show(arm.forward_kinematics(goal))
            page.wait_for_timeout(BETWEEN if change != CHANGES[-1] else A_MOMENT)
        image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        browser.close()
    image.save(Path(__file__).with_name("following.jpg"), quality=88, optimize=True)


if __name__ == "__main__":
    main()
