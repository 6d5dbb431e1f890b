"""What a drive with limits makes of what trackers send it (`drive.py`), and that the benchmark says so."""

import runpy
from pathlib import Path

import arms
import numpy as np
import pytest
from drive import SHARE, driven
from motions import motion
from tracked import least_time, passed, velocities

DT = 0.002
ROUNDING = 1e-9
ARMS = arms.here("iiwa14", "gen3")


def limits(arm):
    """The arm's velocity limits, and accelerations that lead to them in 0.1 s."""
    return velocities(arm), 10.0 * velocities(arm)


@pytest.mark.parametrize("name", ARMS)
def test_what_keeps_the_limits_comes_through_as_it_is(name):
    arm = arms.load(name)
    moving = motion(arm, 5, 4.0, DT, "singular", trouble=False)
    tracker = arm.tracker(moving.q0, DT)
    q = np.array([tracker.update(T).q for T in moving.given])
    np.testing.assert_allclose(driven(arm, moving.q0, q, limits(arm), DT), q, atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_a_drive_keeps_its_limits_whatever_it_is_sent(name):
    arm, rng = arms.load(name), np.random.default_rng(0)
    q0 = 0.1 * rng.normal(size=7)
    sent = np.cumsum(rng.choice([-0.02, 0.02], (500, 7)), axis=0)
    q = driven(arm, q0, sent, limits(arm), DT)
    assert passed(arm, q0, q, limits(arm), DT)[1:].max() < ROUNDING


def test_a_step_is_taken_in_the_shortest_time_that_its_share_allows_and_not_passed():
    arm = arms.load("iiwa14")
    fastest, hardest = limits(arm)
    way = np.array([0.01, -0.1, 0.5, -1.0, 1.5, -0.3, 0.05])
    q = driven(arm, np.zeros(7), np.repeat(way[None], 1000, axis=0), (fastest, hardest), DT)
    assert (np.sign(way) * (q - way) < ROUNDING).all()
    there = DT * (1 + np.argmax(np.abs(q - way) < 1e-6, axis=0))
    # The command's own velocity, of the first period, is no more than the limit: it costs some periods.
    assert (there > least_time(np.abs(way), fastest, hardest) - DT).all()
    assert (there < least_time(np.abs(way), fastest, SHARE * hardest) + 0.02).all()


def test_joints_without_ends_go_the_short_way():
    arm = arms.load("gen3")
    turns = np.isinf(arm.upper)
    sent = np.zeros((50, 7))
    sent[:, turns] = 2.0 * np.pi
    np.testing.assert_allclose(driven(arm, np.zeros(7), sent, limits(arm), DT), 0.0, atol=1e-12)


def test_the_benchmark_says_what_a_drive_makes_of_each_tracker(capsys):
    """Without limits of acceleration, ours asks for twice as much as the drive has: it is on target for less."""
    bench = runpy.run_path(str(Path(__file__).parents[1] / "benchmarks" / "tracking.py"), run_name="tracking")
    one = ["--robots", "iiwa14", "--kinds", "joints", "--motions", "1", "--seconds", "2", "--first", "3"]
    bench["main"]([*one, "--trackers", "srs_ik", "srs_ik, velocity"])
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines() if line.startswith("| ")]
    at = rows[0].index("driven")
    with_limits, without = rows[1], rows[2]
    assert with_limits[at] == with_limits[at - 2]
    assert float(without[at].split()[0]) <= float(without[at - 2].split()[0])
