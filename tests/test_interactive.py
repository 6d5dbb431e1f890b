"""The page with sliders: every control leaves the arm at the target, inside its limits and in the chosen interval."""

import re
import sys
import threading

import numpy as np
import pinocchio as pin
import pytest

import srs_ik
from srs_ik.errors import install_command

Q = np.array([0.3, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])


@pytest.fixture(params=["iiwa14", "human_arm"])
def arm(request):
    pytest.importorskip("viser")
    return srs_ik.load(request.param)


@pytest.fixture
def page(arm):
    with srs_ik.preview.InteractivePreview(arm) as page:
        yield page


def check(page) -> None:
    arm, solution = page.arm, page.solution
    assert solution
    assert max(arm.verify(page.target, solution.q)) < 1e-9
    assert (solution.q >= arm.lower - 1e-12).all()
    assert (solution.q <= arm.upper + 1e-12).all()
    shown = np.deg2rad(page._slider.value) - solution.arm_angle
    assert abs((shown + np.pi) % (2.0 * np.pi) - np.pi) < 1e-4
    assert f"branch {solution.branch}:" in page._list.value
    assert page._slider.min <= page._slider.value <= page._slider.max


def test_the_slider_runs_through_the_whole_interval(page):
    lower, upper = page._slider.min, page._slider.max
    branch = page.solution.branch
    for share in np.linspace(0.0, 1.0, 9):
        page._slider.value = min(float(lower + share * (upper - lower)), upper)
        check(page)
        assert page.solution.branch == branch
    assert (page._slider.min, page._slider.max) == (lower, upper)


def test_every_interval_can_be_chosen(page):
    names = page._list.options
    expected = page.arm.intervals(page.target)
    assert len(names) == len(expected) > 0
    for name, interval in zip(names, expected, strict=True):
        page._list.value = name
        check(page)
        assert page.solution.branch == interval.branch
        assert page.solution.arm_angle in interval


def test_the_target_can_be_dragged_and_typed(page):
    position = page._xyz.value + np.array([0.0, -0.02, 0.01])
    page._xyz.value = tuple(position)
    check(page)
    assert np.abs(page.target[:3, 3] - position).max() < 1e-9
    page._handles.position = position + 0.01
    page._target_dragged()
    check(page)
    assert np.abs(np.array(page._xyz.value) - position - 0.01).max() < 1e-5
    R = pin.rpy.rpyToMatrix(*np.deg2rad(page._rpy.value))
    assert np.abs(page.target[:3, :3] - R).max() < 1e-5


def test_out_of_reach_the_closest_posture_is_shown_and_said(page):
    T = page.target
    back = T.copy()
    T[:3, 3] += 3.0
    solution = page.show(T)
    assert not solution
    assert solution.status is srs_ik.Status.UNREACHABLE
    assert np.isfinite(solution.q).all()
    assert page._slider.disabled
    assert page._list.options == ("no posture",)
    assert "No posture" in page._text.content
    page._slider.value = 12.0
    assert not page.solution
    page.show(back)
    assert not page._slider.disabled
    check(page)


def test_wrong_input_is_one_clear_error(page):
    with pytest.raises(srs_ik.InvalidPose):
        page.show(np.zeros((4, 4)))
    with pytest.raises(srs_ik.InvalidConfiguration):
        page.show(page.target, seed=[1.0])
    with pytest.raises(srs_ik.InvalidConfiguration):
        srs_ik.preview.InteractivePreview(page.arm, [1.0])
    check(page)
    page.close()
    with pytest.raises(srs_ik.PreviewError, match="is closed"):
        page.show(page.target)


def test_what_is_being_shown_is_shown_before_the_page_closes(page, monkeypatch):
    aim, begun, go_on = page._aim, threading.Event(), threading.Event()
    seen = []

    def slow(*given):
        begun.set()
        go_on.wait(10.0)
        seen.append(page.closed)
        aim(*given)

    monkeypatch.setattr(page, "_aim", slow)
    showing = threading.Thread(target=page.show, args=(page.target,))
    closing = threading.Thread(target=page.close)
    showing.start()
    begun.wait(10.0)
    closing.start()
    closing.join(0.3)
    go_on.set()
    showing.join(20.0)
    closing.join(20.0)
    assert seen == [False]
    assert page.closed


def test_a_page_cannot_be_shared_with_the_world(page):
    assert page._server.request_share_url() is None


def test_without_viser_the_error_names_the_extra_once_a_page_is_made(monkeypatch):
    """Not before: all public names can be imported whatever is installed."""
    monkeypatch.setitem(sys.modules, "viser", None)
    for name in ("srs_ik.preview", "srs_ik.preview.live.page", "srs_ik.preview.live.interactive"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    for name in ("Preview", "preview"):
        monkeypatch.delitem(vars(srs_ik), name, raising=False)
    arm = srs_ik.load("iiwa14")
    assert [name for name in srs_ik.__all__ if not hasattr(srs_ik, name)] == []
    with pytest.raises(srs_ik.MissingExtra, match=re.escape(install_command("interactive"))):
        srs_ik.preview.InteractivePreview(arm)


def test_a_sweep_of_the_slider_turns_no_joint_around():
    pytest.importorskip("viser")
    arm = srs_ik.load("gen3")
    with srs_ik.preview.InteractivePreview(arm, [2.9, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]) as page:
        page._list.value = next(name for name in page._list.options if name.startswith("branch 7"))
        page._interval_chosen()
        before = None
        for angle in np.arange(np.ceil(page._slider.min), page._slider.max, 0.5):
            page._slider.value = float(angle)
            page._turn()
            if before is not None:
                assert np.abs(page.solution.q - before).max() < 1.0
            before = page.solution.q
            assert max(arm.verify(page.target, before)) < 1e-9
