"""Which pairs of bodies are watched: reasons, ranges of joints, SRDF, and what Pinocchio says of those that are not."""

import numpy as np
import pinocchio as pin
import pytest
from arms import generator
from collision_oracle import file_of, with_a_thick_neck
from robot_files import at_hand

import srs_ik
from srs_ik.collision.links.ranges import Bounds
from srs_ik.errors import InvalidRobot, InvalidScene


def touching(arm, wanted, count):
    """For each pair of names, at how many random postures inside the limits their shapes touch, by Pinocchio."""
    file, folders = file_of(arm)
    model = pin.buildModelFromUrdf(str(file))
    shapes = pin.buildGeomFromUrdf(model, str(file), pin.GeometryType.COLLISION, package_dirs=[str(f) for f in folders])
    owner = [model.frames[shape.parentFrame].name for shape in shapes.geometryObjects]
    for i in range(len(owner)):
        for j in range(i + 1, len(owner)):
            if frozenset((owner[i], owner[j])) in wanted:
                shapes.addCollisionPair(pin.CollisionPair(i, j))
    data, shape_data = model.createData(), pin.GeometryData(shapes)
    rng = generator(arm.name, 4)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    found = dict.fromkeys(wanted, 0)
    postures = rng.uniform(lower, upper, (count, 7))
    for q in postures:
        pin.updateGeometryPlacements(model, data, shapes, shape_data, arm.configuration(q, model))
        pin.computeCollisions(shapes, shape_data, False)
        hit = {
            frozenset((owner[pair.first], owner[pair.second]))
            for k, pair in enumerate(shapes.collisionPairs)
            if shape_data.collisionResults[k].isCollision()
        }
        for pair in hit:
            found[pair] += 1
    return found


@pytest.mark.parametrize("name", ["iiwa14", "gen3", "human_arm"])
def test_what_is_proved_never_to_meet_never_does(name):
    arm = srs_ik.load(name)
    never = {frozenset((p.first, p.second)) for p in arm.pairs if p.reason == "never meet (proved)"}
    assert never
    assert set(touching(arm, never, 600).values()) == {0}


def test_adjacent_links_are_those_that_a_joint_connects():
    arm = srs_ik.load("iiwa14")
    adjacent = {(p.first, p.second) for p in arm.pairs if p.reason == "adjacent"}
    assert adjacent == {(f"iiwa_link_{k}", f"iiwa_link_{k + 1}") for k in range(7)}
    assert all(p.kept for p in arm.pairs if (p.first, p.second) == ("iiwa_link_0", "iiwa_link_7"))


@pytest.mark.parametrize(
    ("name", "meeting"), [("iiwa14", {}), ("gen3", {}), ("human_arm", {("upper_arm_link", "forearm_roll_link"): 0.05})]
)
def test_links_of_built_in_robots_with_one_between_them_meet_nowhere_inside_the_limits(name, meeting):
    """The flange of iiwa14 met the link before its wrist at 23 % of all postures; forearms press on upper arms."""
    arm, count = srs_ik.load(name), 1000
    joint_of = {body.name: body.joint for body in arm.bodies}
    # Links that a joint connects touch there, also where one without a shape is between them.
    close = {frozenset((p.first, p.second)): (p.first, p.second) for p in arm.pairs if p.reason != "adjacent"}
    close = {names: pair for names, pair in close.items() if joint_of[pair[1]] - joint_of[pair[0]] == 2}
    assert close
    for names, hits in touching(arm, set(close), count).items():
        assert hits <= meeting.get(close[names], 0.0) * count, names


def test_a_range_of_a_joint_keeps_two_bodies_apart(tmp_path):
    arm = with_a_thick_neck(tmp_path)
    by_range = [p for p in arm.pairs if "by the range" in p.reason]
    assert [(p.first, p.second) for p in by_range] == [("iiwa_link_5", "iiwa_link_7")]
    T = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    free = arm.intervals(T, scene=srs_ik.Scene())
    largest = 0.0
    for each in free:
        for psi in np.linspace(each.lower + 1e-9, each.upper - 1e-9, 60):
            largest = max(largest, abs(arm.solve(T, arm_angle=psi, branch=each.branch).q[5]))
    assert 1.5 < largest < arm.upper[5] - 0.3
    pair = frozenset(("iiwa_link_5", "iiwa_link_7"))
    assert 0 < touching(arm, {pair}, 300)[pair] < 300


@pytest.mark.parametrize("swing", [0.2, 0.0])
def test_bounds_of_ranges_hold_and_are_close_where_bodies_begin_to_meet(swing):
    f = lambda a, b: 0.3 * np.sin(3 * a) + swing * np.cos(2 * b + a)  # noqa: E731
    rows = Bounds(f, (-np.pi, np.pi), (0.9 + swing, 2.0 * swing)).over(-2.0, 2.0)
    assert rows[0, 0] == -2.0
    assert rows[-1, 1] == 2.0
    assert (rows[1:, 0] == rows[:-1, 1]).all()
    for lower, upper, least, most in rows:
        a, b = np.meshgrid(np.linspace(lower, upper, 9), np.linspace(-np.pi, np.pi, 721))
        true = f(a, b)
        assert least <= true.min() + 1e-9
        assert true.max() - 1e-9 <= most
        # Where it is not positive, how much so is not looked for.
        near = 1.1 * (upper - lower) + 0.0025
        assert least >= true.min() - near or true.min() <= near
    sure = rows[rows[:, 2] > 0.0]
    a = np.linspace(-2.0, 2.0, 200001)
    truly = (0.3 * np.sin(3 * a) - swing > 0.0).mean() * 4.0
    assert truly - 6 * 2e-3 <= (sure[:, 1] - sure[:, 0]).sum() <= truly


SRDF = """<robot name="r"><disable_collisions link1="iiwa_link_1" link2="iiwa_link_0" reason="Adjacent"/>
<disable_collisions link1="iiwa_link_5" link2="iiwa_link_7" reason="Never"/></robot>"""


def test_an_srdf_says_what_is_not_watched():
    arm = srs_ik.load("iiwa14").with_bodies(srdf=SRDF)
    reasons = {frozenset((p.first, p.second)): p for p in arm.pairs}
    assert reasons[frozenset(("iiwa_link_0", "iiwa_link_1"))].reason == "SRDF: Adjacent"
    assert not reasons[frozenset(("iiwa_link_5", "iiwa_link_7"))].kept
    assert reasons[frozenset(("iiwa_link_2", "iiwa_link_3"))].kept


def test_an_srdf_may_disable_all_pairs_of_a_link_but_some():
    said = """<robot name="r"><disable_default_collisions link="iiwa_link_5"/>
    <enable_collisions link1="iiwa_link_2" link2="iiwa_link_5"/></robot>"""
    pairs = srs_ik.load("iiwa14").with_bodies(srdf=said).pairs
    of_link = {p.first + p.second: p.kept for p in pairs if "iiwa_link_5" in (p.first, p.second)}
    assert [name for name, kept in of_link.items() if kept] == ["iiwa_link_2iiwa_link_5"]
    assert not any("SRDF" in p.reason for p in pairs if "iiwa_link_5" not in (p.first, p.second))


@pytest.mark.parametrize(
    ("srdf", "says"),
    [
        (SRDF.replace("iiwa_link", "arm_link"), "the SRDF is of another robot: iiwa14 has none of arm_link_0"),
        ('<robot name="r"><group name="arm"/></robot>', r"the SRDF disables no pair of links: is it an SRDF\?"),
        (str(srs_ik.load("iiwa14").drawing.file), r"iiwa14.urdf disables no pair of links: is it an SRDF\?"),
    ],
)
def test_what_is_no_srdf_of_this_robot(srdf, says):
    with pytest.raises(InvalidRobot, match=says):
        _ = srs_ik.load("iiwa14").with_bodies(srdf=srdf).bodies


def test_an_srdf_that_chooses_the_arm_says_it_too():
    chain = '<group name="arm"><chain base_link="iiwa_link_0" tip_link="iiwa_link_7"/></group>'
    full, bare = SRDF.replace("</robot>", chain + "</robot>"), f'<robot name="r">{chain}</robot>'
    built_in = srs_ik.load("iiwa14")
    file, expected = built_in.drawing.file, built_in.with_bodies(srdf=SRDF).pairs
    arm = srs_ik.load(file, srdf=full)
    assert arm.pairs == arm.with_bodies(folders=["."]).pairs == expected
    # One of groups alone disables nothing, and does not mean that links next to each other are to be watched.
    assert srs_ik.load(file, srdf=bare).pairs == built_in.pairs


def test_pairs_are_kept_and_dropped_on_the_callers_word(tmp_path):
    thick = with_a_thick_neck(tmp_path)
    arm = thick.with_bodies(drop=[("iiwa_link_7", "iiwa_link_5")], keep=[("iiwa_link_1", "iiwa_link_3")])
    reasons = {frozenset((p.first, p.second)): p for p in arm.pairs}
    dropped = reasons[frozenset(("iiwa_link_5", "iiwa_link_7"))]
    assert not dropped.kept
    assert "asked" in dropped.reason
    assert reasons[frozenset(("iiwa_link_1", "iiwa_link_3"))].kept
    T = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    wide, narrow = (
        sum(i.width for i in each.intervals(T, scene=srs_ik.Scene()))
        for each in (thick.with_bodies(drop=[("iiwa_link_7", "iiwa_link_5")]), thick)
    )
    assert wide > narrow
    with pytest.raises(InvalidScene, match="no body 'nobody'"):
        arm.with_bodies(drop=[("iiwa_link_1", "nobody")]).pairs  # noqa: B018


@pytest.mark.slow
def test_a_pair_of_which_spheres_tell_nothing_is_left_out_and_named():
    if not at_hand("romeo"):
        pytest.skip("example-robot-data is not here")
    arm = srs_ik.load("romeo_left")
    (left,) = [p for p in arm.pairs if p.reason.startswith("spheres always meet")]
    assert (left.first, left.second, left.kept) == ("LElbowYawLink", "l_wrist", False)
    pair = frozenset((left.first, left.second))
    assert touching(arm, {pair}, 300)[pair] == 0
    q = 0.5 * (arm.lower + arm.upper)
    assert arm.intervals(arm.forward_kinematics(q), scene=srs_ik.Scene())
    watched = arm.with_bodies(keep=[(left.first, left.second)])
    # The real shapes do not meet, and where spheres leave nothing they are asked.
    assert watched.intervals(arm.forward_kinematics(q), scene=srs_ik.Scene())
    assert watched.solve(arm.forward_kinematics(q), scene=srs_ik.Scene())
