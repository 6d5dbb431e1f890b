"""Recognition from joint axes as lines."""

import arms
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import limbs, random_limb, random_rotation
from robot_files import at_hand, robot_file
from scipy.optimize import least_squares

import srs_ik
from srs_ik.robot.recognition import recognise

TIP = np.eye(4)


def assert_same_limb(one, other, tolerance=1e-9):
    assert one.kind == other.kind
    for field in ("shoulder", "elbow", "wrist", "misses"):
        assert getattr(one.limb, field) == pytest.approx(getattr(other.limb, field), abs=tolerance)


@given(limbs())
def test_centres_of_random_limbs_are_found(limb):
    found = recognise(limb.axes, limb.points, TIP)
    assert found.kind == "exact"
    assert found.reason == ""
    assert found.limb.kind == "exact"
    assert found.limb.shoulder == pytest.approx(limb.centres[0], abs=1e-9)
    assert found.limb.wrist == pytest.approx(limb.centres[2], abs=1e-9)
    assert found.misses.max() < 1e-9
    # The elbow centre is the point of axis 4 nearest to axes 3 and 5: no other point of it is nearer to both.
    E, a4 = found.limb.elbow, limb.axes[3]
    assert np.linalg.norm(np.cross(a4, E - limb.points[3])) < 1e-9

    def squares(point):
        return sum(np.sum(np.cross(limb.axes[k], point - limb.points[k]) ** 2) for k in (2, 4))

    for step in (1e-3, -1e-3, 0.1, -0.1):
        assert squares(E) <= squares(E + step * a4) + 1e-12
    ways = {k: E - centre for k, centre in ((2, limb.centres[0]), (4, limb.centres[2]))}
    along = [k for k, way in ways.items() if abs(limb.axes[k] @ way) > np.sqrt(0.5) * np.linalg.norm(way)]
    offset = max((np.linalg.norm(np.cross(limb.axes[k], ways[k])) for k in along), default=0.0)
    assert found.elbow_offset == pytest.approx(offset, abs=1e-9)


def test_an_axis_across_the_forearm_is_no_elbow_offset():
    axes = [[0, 1, 0], [1, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    points = [[0, 0, 0]] * 3 + [[0, 0, -0.28]] + [[0, 0, -0.56]] * 3
    assert recognise(np.array(axes), np.array(points), TIP).elbow_offset == 0.0
    points[3] = [0.05, 0, -0.28]
    assert recognise(np.array(axes), np.array(points), TIP).elbow_offset == pytest.approx(0.05)


@given(st.sampled_from([0.0, 0.004]).flatmap(limbs))
def test_only_the_lines_count(limb):
    """Neither where on an axis its origin is, nor how long its direction, nor where the base is."""
    rng = limb.rng
    found = recognise(limb.axes, limb.points, TIP)
    slid = limb.points + limb.axes * rng.normal(size=(7, 1))
    assert_same_limb(recognise(limb.axes * rng.uniform(0.01, 100.0, (7, 1)), slid, TIP), found)
    R, t = random_rotation(rng), rng.normal(size=3)
    moved = recognise(limb.axes @ R.T, limb.points @ R.T + t, TIP)
    assert moved.kind == found.kind
    assert moved.misses == pytest.approx(found.misses, abs=1e-9)
    assert moved.limb.shoulder == pytest.approx(R @ found.limb.shoulder + t, abs=1e-9)
    assert moved.limb.elbow == pytest.approx(R @ found.limb.elbow + t, abs=1e-9)
    assert moved.limb.wrist == pytest.approx(R @ found.limb.wrist + t, abs=1e-9)


@given(limbs(miss=0.01))
def test_axes_miss_their_least_squares_point_and_centres_rest_on_the_first_and_the_last(limb):
    found = recognise(limb.axes, limb.points, TIP)
    assert found.kind == "near"
    for centre, rests, three in ((found.limb.shoulder, 0, (0, 1, 2)), (found.limb.wrist, 6, (4, 5, 6))):

        def across(point, three=three):
            return np.array([np.cross(limb.axes[k], point - limb.points[k]) for k in three])

        def distances(point, across=across):
            return np.linalg.norm(across(point), axis=1)

        nearest = least_squares(
            lambda x, across=across: across(x).ravel(), centre, xtol=1e-15, ftol=1e-15, gtol=1e-15
        ).x
        assert found.misses[list(three)] == pytest.approx(distances(nearest), abs=1e-9)
        # The centre is the foot of that point on an axis which does not move it.
        assert np.linalg.norm(np.cross(limb.axes[rests], centre - limb.points[rests])) < 1e-12
        assert limb.axes[rests] @ (centre - nearest) == pytest.approx(0.0, abs=1e-9)
        assert found.limb.offsets[list(three)] == pytest.approx(distances(centre), abs=1e-12)
    assert found.misses[3] == found.limb.offsets[3] == 0.0


def straight_arm():
    """Shoulder at the origin, elbow at .5 and wrist at 1 m above it."""
    _, y, z = np.eye(3)
    axes = np.array([z, y, z, y, z, y, z])
    points = np.array([0 * z, 0 * z, 0 * z, 0.5 * z, z, z, z])
    return axes, points


@pytest.mark.parametrize(
    ("shift", "kind"), [(0.0, "exact"), (1.2e-6, "exact"), (1e-5, "near"), (0.02, "near"), (0.1, "refused")]
)
def test_how_far_axes_may_miss(shift, kind):
    axes, points = straight_arm()
    points[1] = points[1] + np.array([shift, 0.0, 0.0])
    found = recognise(axes, points, TIP)
    assert found.kind == kind
    # Axes 1 and 3 are one line, axis 2 passes it at `shift`: the least-squares point is a third of the way.
    assert found.misses == pytest.approx([shift / 3.0, 2.0 * shift / 3.0, shift / 3.0, 0, 0, 0, 0], abs=1e-12)
    assert (found.limb is None) == (kind == "refused")


def test_a_refusal_names_the_axis_and_its_distance():
    axes, points = straight_arm()
    points[5] = points[5] + np.array([0.15, 0.0, 0.0])
    found = recognise(axes, points, TIP)
    assert found.kind == "refused"
    assert found.limb is None
    assert "axis 6" in found.reason
    assert "wrist" in found.reason
    assert "100.0 mm" in found.reason


@pytest.mark.parametrize(
    ("pair", "named"), [((0, 1), "1 and 2"), ((1, 2), "2 and 3"), ((4, 5), "5 and 6"), ((5, 6), "6 and 7")]
)
def test_parallel_neighbours_are_refused(pair, named):
    axes, points = straight_arm()
    axes[pair[1]] = -axes[pair[0]]
    found = recognise(axes, points, TIP)
    assert found.kind == "refused"
    assert found.limb is None
    assert named in found.reason


def test_an_elbow_that_cannot_bend_the_arm_is_refused():
    axes, points = straight_arm()
    axes[3] = [0.0, 0.0, 1.0]
    found = recognise(axes, points, TIP)
    assert found.kind == "refused"
    assert "axis 4" in found.reason
    axes, points = straight_arm()
    points[3] = points[0]
    assert recognise(axes, points, TIP).kind == "refused"


@pytest.mark.parametrize("spoilt", ["no direction", "NaN direction", "NaN point", "infinite point"])
def test_axes_that_are_none_are_refused(spoilt):
    axes, points = straight_arm()
    if "direction" in spoilt:
        axes[2] = 0.0 if spoilt == "no direction" else np.nan
    else:
        points[2] = np.nan if spoilt == "NaN point" else np.inf
    found = recognise(axes, points, TIP)
    assert found.kind == "refused"
    assert found.limb is None
    assert found.reason


def test_everything_in_one_point_is_refused():
    axes, _ = straight_arm()
    assert recognise(axes, np.zeros((7, 3)), TIP).kind == "refused"


def test_what_was_given_is_not_changed():
    axes, points = straight_arm()
    axes *= 3.0
    before = axes.copy(), points.copy()
    limb = recognise(axes, points, TIP).limb
    assert (axes == before[0]).all()
    assert (points == before[1]).all()
    points[0] = 9.0
    assert (limb.points[0] == 0.0).all()


def test_the_default_reference_points_along_axis_1():
    axes, points = straight_arm()
    assert recognise(axes, points, TIP).limb.reference == pytest.approx([0.0, 0.0, 1.0])
    axes[0] *= -1.0
    assert recognise(axes, points, TIP).limb.reference == pytest.approx([0.0, 0.0, 1.0])
    assert recognise(axes, points, TIP, np.array([0.0, 3.0, 4.0])).limb.reference == pytest.approx([0.0, 0.6, 0.8])


@pytest.mark.parametrize(("folded", "kind"), [("z y z y z y z", "XYX"), ("z y z y z y x", "XYZ")])
def test_kinds_of_wrists(folded, kind):
    _, points = straight_arm()
    unit_vectors = dict(zip("xyz", np.eye(3), strict=True))
    axes = np.array([unit_vectors[letter] for letter in folded.split()])
    assert recognise(axes, points, TIP).limb.wrist_kind == kind


def test_folded_and_bent_zeros_are_the_same_arm():
    """An arm described from another zero configuration has the same lengths and poses."""
    limb = random_limb(17, "tilted", "straight", "usual")
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for bend in (0.5, np.pi, -2.0):
        q = np.zeros(7)
        q[[1, 3, 5]] = 0.3, bend, -0.4
        J = arm.jacobian(q)
        axes = J[3:].T
        # A point of each axis from its moment about the tip: v = a x (tip - point).
        tip = arm.forward_kinematics(q)
        points = np.array([tip.translation - np.cross(J[:3, k], axes[k]) for k in range(7)])
        found = recognise(axes, points, tip.homogeneous).limb
        assert found.kind == "exact"
        assert found.upper_arm == pytest.approx(arm.limb.upper_arm)
        assert found.forearm == pytest.approx(arm.limb.forearm)
        assert found.hand == pytest.approx(arm.limb.hand)
        assert found.elbow_offset == pytest.approx(arm.limb.elbow_offset, abs=1e-9)


@pytest.mark.parametrize("file", sorted({arms.PLACES[name][0] for name in arms.FROM_FILES}))
def test_every_limb_of_the_files_is_found(file):
    names = [name for name, (own, _, _) in arms.PLACES.items() if own == file]
    reports = srs_ik.find_limbs(arms.file_of(names[0]))
    found = {(r.base, r.tip): r.kind for r in reports if r.limb is not None}
    assert found == {arms.PLACES[name][1:]: "near" if name in arms.NEAR else "exact" for name in names}


@pytest.mark.parametrize(
    ("files", "millimetres"),
    [
        (("made_fr3", "franka_fr3"), 58.667),
        (("made_xarm7", "xarm7"), 50.667),
        (("made_sawyer", "sawyer"), 104.424),
        (("made_yumi", "abb_yumi"), 20.0),
    ],
)
def test_arms_that_are_none_are_refused_with_their_distances(files, millimetres):
    """Least-squares misses: two thirds of the 88 mm and 76 mm flange offsets of FR3 and xArm 7."""
    reports = [report for file in at_hand(*files) for report in srs_ik.find_limbs(robot_file(file))]
    assert reports
    for report in reports:
        assert report.kind == "refused"
        assert report.limb is None
        assert np.nanmax(report.misses_mm) == pytest.approx(millimetres, abs=1e-3)
