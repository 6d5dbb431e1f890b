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
        {"begin": 1.0, "damping": 1.0, "largest": 1.0},
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
