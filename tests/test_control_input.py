"""Wrong things handed to controllers and trackers: one error of the package in a line, which names what is wrong."""

import arms
import numpy as np
import pytest
from wrong_things import refuses

import srs_ik
from srs_ik.control import (
    ForceProfile,
    FractalImpedance,
    JointLimits,
    JointSpeeds,
    TorqueController,
    baselines,
    one_axis,
    planners,
)

HOME = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, 0.0])
PROFILE = ForceProfile.tanh(1000.0, 60.0)
ANY_SHAPE = "5 x 5, 2 x 7, none at all"
POSE = {"pose": "pose", "T_start": "pose", "T_end": "pose"}


def arm():
    return arms.load("iiwa14")


def home():
    return arm().forward_kinematics(HOME)


def task():
    return srs_ik.Task([0.5, 0.2, 0.4], velocity=[1, 0, 0], force=[0, 0, 1])


def controller():
    return TorqueController(arm(), [FractalImpedance("tip", PROFILE), FractalImpedance("elbow", PROFILE)])


def tracker():
    return arm().tracker(HOME, 0.01, velocity=1.0)


def set_elbow(elbow):
    tracker().elbow = elbow


CALLS = {
    "ForceProfile": (
        lambda: ForceProfile,
        {"shape": "tanh", "stiffness": 1.0, "largest": 1.0, "knee": 0.0, "width": 0.0},
        {"knee": "first error"},
        {},
    ),
    "ForceProfile.published": (
        lambda: ForceProfile.published,
        {"stiffness": 1.0, "largest": 1.0, "first": 0.1, "second": 0.2},
        {},
        {},
    ),
    "ForceProfile.force": (lambda: PROFILE.force, {"error": 0.1}, {}, {"error": ANY_SHAPE}),
    "ForceProfile.energy": (lambda: PROFILE.energy, {"error": 0.1}, {}, {"error": ANY_SHAPE}),
    "ForceProfile.converging_force": (
        lambda: PROFILE.converging_force,
        {"peak": 0.1, "error": 0.05, "law": "A"},
        {},
        {"error": ANY_SHAPE},
    ),
    "ForceProfile.injection": (lambda: PROFILE.injection, {"law": "A"}, {}, {}),
    "ForceProfile.row": (lambda: PROFILE.row, {"law": "A", "damping": 0.0}, {}, {}),
    "FractalImpedance": (
        lambda: FractalImpedance,
        {
            "on": "tip",
            "profile": PROFILE,
            "law": "A",
            "per_axis": False,
            "damping": 0.0,
            "switch": 0.0,
            "may_inject": False,
        },
        {},
        {},
    ),
    "JointLimits": (lambda: JointLimits, {"margin": 0.1, "profile": PROFILE, "law": "A", "damping": 0.0}, {}, {}),
    "JointSpeeds": (
        lambda: JointSpeeds,
        {"begin": 1.0, "damping": 1.0, "largest": 1.0, "rate": 1000.0},
        {},
        dict.fromkeys(("begin", "damping", "largest"), "None"),
    ),
    "TorqueController": (
        lambda: TorqueController,
        {
            "arm": arm(),
            "ports": [FractalImpedance("tip", PROFILE)],
            "gravity": True,
            "limits": None,
            "max_torque": None,
            "speeds": None,
        },
        {},
        {"ports": "none at all", "limits": "None", "max_torque": "None", "speeds": "None"},
    ),
    "TorqueController.set_target": (
        lambda: controller().set_target,
        {"pose": home(), "arm_angle": None, "seed": None, "restart": True},
        POSE,
        {"arm_angle": "None", "seed": "None"},
    ),
    "TorqueController.set_task": (
        lambda: controller().set_task,
        {"task": task(), "side": "left", "restart": True, "respect_limits": True, "tie": "lower"},
        {},
        {},
    ),
    "TorqueController.set_posture": (lambda: controller().set_posture, {"q": HOME, "restart": True}, {}, {}),
    "TorqueController.set_elbow": (lambda: controller().set_elbow, {"point": [0.1, 0.1, 0.1]}, {}, {}),
    "TorqueController.torque": (lambda: controller().torque, {"q": HOME, "v": np.zeros(7)}, {}, {}),
    "Gains": (lambda: baselines.Gains, {"point": 1.0, "turn": 1.0, "joints": 1.0, "ratio": 1.0}, {}, {}),
    "OperationalSpace": (
        lambda: baselines.OperationalSpace,
        {"arm": arm(), "gains": None, "inverse": "damped"},
        {},
        {"gains": "None"},
    ),
    "OperationalSpace.set_target": (
        lambda: baselines.OperationalSpace(arm()).set_target,
        {"pose": home(), "arm_angle": None, "seed": None},
        POSE,
        {"arm_angle": "None", "seed": "None"},
    ),
    "OperationalSpace.set_posture": (lambda: baselines.OperationalSpace(arm()).set_posture, {"q": HOME}, {}, {}),
    "OperationalSpace.torque": (lambda: baselines.OperationalSpace(arm()).torque, {"q": HOME, "v": 0 * HOME}, {}, {}),
    "LinearImpedance": (
        lambda: baselines.LinearImpedance,
        {"arm": arm(), "gains": None, "masses": (3.0, 0.01)},
        {},
        {"gains": "None"},
    ),
    "LinearImpedance.torque": (lambda: baselines.LinearImpedance(arm()).torque, {"q": HOME, "v": 0 * HOME}, {}, {}),
    "JointImpedance": (lambda: baselines.JointImpedance, {"arm": arm(), "gains": None}, {}, {"gains": "None"}),
    "JointImpedance.torque": (lambda: baselines.JointImpedance(arm()).torque, {"q": HOME, "v": 0 * HOME}, {}, {}),
    "free_response": (
        lambda: one_axis.free_response,
        {"profile": PROFILE, "mass": 1.0, "start": 0.1, "dt": 0.01, "count": 5, "law": "A"},
        {"dt": "time step"},
        {},
    ),
    "sampled_response": (
        lambda: one_axis.sampled_response,
        {
            "profile": PROFILE,
            "mass": 1.0,
            "start": 0.1,
            "period": 0.01,
            "delay": 0.0,
            "duration": 0.1,
            "law": "A",
        },
        {},
        {},
    ),
    "minimum_jerk": (lambda: planners.minimum_jerk, {"share": 0.5}, {}, {"share": ANY_SHAPE}),
    "harmonic": (lambda: planners.harmonic, {"share": 0.5}, {}, {"share": ANY_SHAPE}),
    "between": (
        lambda: planners.between,
        {"T_start": home(), "T_end": home(), "way": [0.5]},
        POSE,
        {"way": ANY_SHAPE},
    ),
    "passive_motion": (
        lambda: planners.passive_motion,
        {"arm": arm(), "q": HOME, "T_end": home(), "count": 4, "compliance": 1.0, "turning": 0.1},
        POSE,
        {},
    ),
    "tracker": (
        lambda: arm().tracker,
        {
            "q0": HOME,
            "dt": 0.01,
            "velocity": 1.0,
            "acceleration": 1.0,
            "elbow": "keep",
            "smoothing": 0.0,
            "jerk": None,
            "free_axis": None,
        },
        {"elbow": ""},
        {"velocity": "None", "acceleration": "None", "smoothing": "None", "jerk": "None", "free_axis": "None"},
    ),
    "tracker.reset": (lambda: tracker().reset, {"q0": HOME}, {}, {}),
    "tracker.elbow": (lambda: set_elbow, {"elbow": "keep"}, {"elbow": ""}, {}),
}


@pytest.mark.parametrize("name", CALLS)
def test_wrong_things_are_named(name):
    make, good, names, takes = CALLS[name]
    refuses(make(), good, names, takes)


def test_a_tracker_takes_poses_that_are_malformed_for_lost_ones_and_refuses_other_things():
    follower = tracker()
    for wrong in ("nonsense", object(), {"a": 1}, 1j, [["a"]], np.zeros((5, 5)), [None] * 7):
        with pytest.raises(srs_ik.InvalidPose, match="a pose is"):
            follower.update(wrong)
        with pytest.raises(srs_ik.InvalidPose, match="a pose is"):
            follower.reconfigure(wrong)
    assert follower.update(np.full((4, 4), np.nan)).status == "HELD"
    assert follower.update(home())


def test_limits_that_a_person_switches_off_are_off():
    for off in (None, False):
        made = TorqueController(arm(), [], limits=off, speeds=off)
        assert made.limits is None
        assert made.speeds is None


@pytest.mark.parametrize("wrong", [np.zeros(7, complex), np.array(list("abcdefg")), np.array([10**400] * 7, object)])
def test_arrays_of_other_things_than_figures_are_no_joint_angles(wrong):
    controller = TorqueController(arms.load("iiwa14"), [])
    for given in ((wrong, np.zeros(7)), (np.zeros(7), wrong)):
        with pytest.raises(srs_ik.InvalidConfiguration):
            controller.torque(*given)


TWICE = [FractalImpedance("tip", PROFILE), FractalImpedance("tip", ForceProfile.tanh(500.0, 30.0))]
UNHELD = {
    "two ports of one place": (lambda: TorqueController(arm(), TWICE), "2 ports are on 'tip': a place has one"),
    "an arm angle": (lambda: on("tip", "orientation").set_target(home(), 0.3), "no port on 'elbow' or 'arm_angle'"),
    "a point of the elbow": (lambda: on("tip", "arm_angle").set_elbow([0.1, 0.1, 0.1]), "no port on 'elbow'"),
    "a pose": (lambda: on().set_target(home()), "no port that would hold a pose"),
    "a task": (lambda: on().set_task(task()), "no port that would hold a task"),
    "a posture": (lambda: on().set_posture(HOME), "no port that would hold a posture"),
}


def on(*places, **options):
    return TorqueController(arm(), [FractalImpedance(place, PROFILE) for place in places], **options)


@pytest.mark.parametrize("what", UNHELD)
def test_targets_that_nothing_would_hold_are_refused(what):
    call, message = UNHELD[what]
    with pytest.raises(srs_ik.InvalidController, match=message):
        call()


def test_an_arm_angle_is_held_by_a_port_on_it_or_on_the_elbow():
    for place in ("elbow", "arm_angle"):
        assert on(place).set_target(home(), 0.3).arm_angle == pytest.approx(0.3, abs=1e-9)


def test_an_arm_without_masses_is_told_how_its_weight_is_left_alone():
    weightless = arms.load("made_near")
    with pytest.raises(srs_ik.InvalidController, match=r"no masses; .*pass gravity=False"):
        TorqueController(weightless, [FractalImpedance("tip", PROFILE)])
    TorqueController(weightless, [FractalImpedance("tip", PROFILE)], gravity=False)


def test_readings_of_joints_name_them():
    made = on("tip", limits=True, speeds=True)
    made.torque(HOME, np.zeros(7))
    names = list(arm().joint_names)
    assert [(port.on, port.joint) for port in made.readings] == [
        ("tip", None),
        *(("joint_limit", name) for name in names),
        *(("joint_speed", name) for name in names),
    ]
    # gen3 has limits at joints 2, 4 and 6 alone; each reading is of the joint whose angle is in the zone.
    gen3 = arms.load("gen3")
    made = TorqueController(gen3, [], gravity=False, limits=True)
    q = np.zeros(7)
    q[3] = gen3.upper[3] - 0.01
    made.torque(q, np.zeros(7))
    bounded = [name for name, upper in zip(gen3.joint_names, gen3.upper, strict=True) if np.isfinite(upper)]
    assert [port.joint for port in made.readings] == bounded
    assert [port.joint for port in made.readings if np.any(port.force)] == [gen3.joint_names[3]]


def test_controllers_and_readings_are_told_in_a_line():
    made = on("tip", "elbow", limits=True)
    assert repr(made) == "TorqueController(iiwa14: tip, elbow, joint limits, weight)"
    made.torque(HOME, np.zeros(7))
    assert [repr(port).split(":")[0] for port in made.readings[:3]] == [
        "PortReading(tip",
        "PortReading(elbow",
        f"PortReading(joint_limit of {arm().joint_names[0]}",
    ]
    assert all(len(repr(port)) < 200 for port in made.readings)
