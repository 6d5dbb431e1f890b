"""Every Python and bash block of the README and the documentation runs as it stands, page by page, as a reader would.

The blocks of a page share one namespace and one empty folder, but for the robots of the checkout. What a block needs
is said by an HTML comment on the line above it: `<!-- not run: WHY -->`, `<!-- exit status 1 -->`,
`<!-- needs: MODULE -->`, or `<!-- command: NAME -->` for what `.ci/run` runs.
"""

import contextlib
import io
import re
import shlex
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from command_line import run

import srs_ik

ROOT = Path(__file__).resolve().parents[1]
FENCE = re.compile(
    r"(?:^<!-- (?P<mark>.+?) -->\n)?^```(?P<language>python|bash)\n(?P<code>.+?)^```", re.DOTALL | re.MULTILINE
)
MARK = re.compile(r"not run: .+|exit status 1|needs: \w+|command: \w+")


class Block(NamedTuple):
    """A fenced block, and the comment above it."""

    mark: str
    language: str
    code: str


def blocks(page: str) -> list[Block]:
    return [Block(*found.group("mark", "language", "code")) for found in FENCE.finditer((ROOT / page).read_text())]


def pages() -> list[str]:
    every = ["README.md", *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))]
    return [page for page in every if blocks(page)]


def run_bash(code: str, status: int) -> None:
    """Run the lines of a block, each a `srs-ik` command, within this process."""
    for line in code.replace("\\\n", " ").splitlines():
        program, *words = shlex.split(line, comments=True) or [""]
        if not program:
            continue
        assert program == "srs-ik", f"{line!r} is no srs-ik command: mark the block as not run"
        result = run(*words)
        assert result.exit_code == status, f"{line!r}: {result.stderr or result.exception!r}"


def run_page(page: str) -> dict:
    """Run the blocks of a page; gives the names that they leave."""
    names: dict = {"__name__": "snippet"}
    for block in blocks(page):
        mark = block.mark or ""
        if mark.startswith(("not run:", "command:")):
            continue
        if mark.startswith("needs:"):
            pytest.importorskip(mark.split()[1])
        if block.language == "bash":
            run_bash(block.code, status=1 if mark == "exit status 1" else 0)
            continue
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(block.code, page, "exec"), names)
    return names


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "robots").symlink_to(ROOT / "robots")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", pages())
def test_blocks_of_a_page_run(page, folder):
    run_page(page)


@pytest.mark.parametrize("page", pages())
def test_marks_above_blocks_are_known(page):
    assert [block.mark for block in blocks(page) if block.mark and not MARK.fullmatch(block.mark)] == []


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_the_first_answer_that_a_reader_sees_reaches_its_pose(page, folder):
    (first, *_) = [block for block in blocks(page) if block.language == "python"]
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(first.code, page, "exec"), names)
    assert printed.getvalue()
    assert names["solution"]
    reached = names["arm"].forward_kinematics(names["solution"].q)
    assert np.allclose(reached.homogeneous, names["pose"].homogeneous, rtol=0.0, atol=1e-11)


def test_blocks_of_the_ellipsoids_draw_what_they_say(folder):
    names = run_page("docs/ellipsoids.md")
    assert names["velocity"].rank == names["strong"].rank == 3
    assert {path.name for path in folder.glob("*.png")} == {"ellipsoids.png", "arm_angle.png", "intervals.png"}


def test_weighted_differences_of_joints_without_end_are_those_of_the_nearest_turn(folder):
    """The recipe of Coming from another solver, on an arm whose joints pass pi: with equal weights it is `seed=`."""
    names = run_page("docs/coming_from.md")
    arm = names["arm"] = srs_ik.load("gen3")
    rng = np.random.default_rng(7)
    for turns in (0.0, 0.0, 6.0, -8.0):
        endless = np.isinf(arm.upper)
        seed = names["seed"] = np.where(endless, np.pi * (1.0 + turns), 0.9) + rng.uniform(-0.1, 0.1, 7)
        pose = arm.forward_kinematics(seed + rng.uniform(-0.15, 0.15, 7))
        best = arm.optimise(pose, lambda q: np.sum(names["away"](q) ** 2))
        nearest = arm.solve(pose, seed=seed)
        np.testing.assert_allclose(seed + names["away"](best.q), nearest.q, rtol=0.0, atol=1e-3)


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_gradients_of_the_recipe_are_those_of_its_joint_angles(name, folder):
    """The recipe of The redundancy for torch and jax: what it does not refuse is right, and most is not refused."""
    names = run_page("docs/redundancy.md")
    arm = names["arm"] = srs_ik.load(name)
    lower, upper, rng = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi), np.random.default_rng(3)
    told, step = [], 1e-6 * np.eye(4)

    def loss(x):
        return np.sum(names["forward"](x[:3], x[3])[0] ** 2)

    for _ in range(100):
        q = names["q"] = rng.uniform(lower, upper)
        names["branch"], names["matrix"] = arm.branch(q), arm.forward_kinematics(q).homogeneous
        x = np.append(names["matrix"][:3, 3], arm.arm_angle(q)) + rng.uniform(-0.1, 0.1, 4)
        try:
            q, found = names["forward"](x[:3], x[3])
            slopes = np.array([(loss(x + h) - loss(x - h)) / 2e-6 for h in step])
        except ValueError:
            continue
        by_position, by_angle = names["backward"](found, 2.0 * q)
        told.append(np.abs(np.append(by_position, by_angle) - slopes).max() / max(1.0, np.abs(slopes).max()))
    assert 50 <= len(told) < 100
    # Of central differences, close to singular poses too.
    assert max(told) < 1e-4


def test_a_block_that_fails_is_not_passed_over(folder, monkeypatch):
    (folder / "page.md").write_text("<!-- exit status 1 -->\n```bash\nsrs-ik robots\n```\n")
    monkeypatch.setattr("test_snippets.ROOT", folder)
    with pytest.raises(AssertionError, match="srs-ik robots"):
        run_page("page.md")
