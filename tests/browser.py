"""A headless browser for tests: Chromium by playwright, with WebGL in software."""

import io
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

REQUIRED = "SRS_IK_BROWSER_REQUIRED"
"""Set where a test that needs a browser must not be skipped."""

PATIENCE = 300_000
"""Milliseconds for what takes one on a machine at rest: WebGL is drawn by a processor that others use as well."""

SIZE = {"width": 560, "height": 460}
_NAMES = ("chromium", "chromium-browser", "google-chrome")
# No sandbox: it needs rights that containers do not have, and the pages are our own.
_OPTIONS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def _missing(what: str):
    if os.environ.get(REQUIRED):
        pytest.fail(f"{what}, and {REQUIRED} is set")
    pytest.skip(what)


@contextmanager
def chromium() -> Iterator:
    """A browser; skips the test where there is none."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _missing("playwright is not installed")
    with sync_playwright() as playwright:
        found = next(filter(None, map(shutil.which, _NAMES)), None)
        path = found or playwright.chromium.executable_path
        if not Path(path).is_file():
            _missing("there is no Chromium on this machine")
        browser = playwright.chromium.launch(executable_path=path, args=_OPTIONS, timeout=PATIENCE)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def another(browser, *options: str) -> Iterator:
    """A second browser beside a first one, with options of its own."""
    path = next(filter(None, map(shutil.which, _NAMES)), None) or browser.browser_type.executable_path
    second = browser.browser_type.launch(executable_path=path, args=[*_OPTIONS, *options], timeout=PATIENCE)
    try:
        yield second
    finally:
        second.close()


def opened(browser, url: str, offline: bool = False):
    """A page, and the list of what went wrong on it, and of the addresses beyond this machine that it asked for."""
    page = browser.new_page(viewport=SIZE)
    page.faults = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    local = ("file:", "data:", "blob:") if offline else ("http://127.0.0.1:", "ws://127.0.0.1:", "data:", "blob:")
    page.on("request", lambda r: None if r.url.startswith(local) else page.faults.append(r.url))
    if offline:
        page.context.set_offline(True)
    page.set_default_timeout(PATIENCE)
    page.goto(url)
    return page


def pixels(page) -> np.ndarray:
    """(height, width, 3) what the page shows, 0 to 255."""
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(page.screenshot(timeout=PATIENCE))).convert("RGB")).astype(int)


def settled(page) -> np.ndarray:
    """The pixels once they stay as they are while the page draws again and again."""
    last = pixels(page)
    deadline = time.monotonic() + 1e-3 * PATIENCE
    while time.monotonic() < deadline:
        page.evaluate(_FRAMES, 20)
        page.wait_for_timeout(500)
        now = pixels(page)
        if (now == last).all():
            return now
        last = now
    raise AssertionError(f"the page does not come to rest within {1e-3 * PATIENCE} s")


_FRAMES = """count => new Promise(done => {
  const next = () => count-- ? requestAnimationFrame(next) : done();
  next();
})"""


def until(page, condition) -> None:
    """Wait for a condition of this program, while the page goes on."""
    deadline = time.monotonic() + 1e-3 * PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        page.wait_for_timeout(50)


def changed(one: np.ndarray, other: np.ndarray) -> float:
    """Share of the pixels that differ visibly."""
    return float((np.abs(one - other).max(axis=-1) > 24).mean())


def orange(image: np.ndarray) -> float:
    """Share of the pixels in the colour of the joints of the iiwa14, which nothing else in a scene has."""
    r, g, b = np.moveaxis(image, -1, 0)
    return float(((r > 170) & (g > 50) & (g < 150) & (b < 90)).mean())
