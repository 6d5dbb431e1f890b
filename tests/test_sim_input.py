"""Wrong things handed to simulations: one error of the package in a line, which names what is wrong."""

import arms
import numpy as np
import pytest
from wrong_things import refuses

import srs_ik
from srs_ik.control import ForceProfile, FractalImpedance, TorqueController

pytest.importorskip("mujoco", "3.14")

from srs_ik.sim import Box, Payload, Peg, Plant, Push, Record, Wall, World, simulate

HOME = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, 0.0])


def arm():
    return arms.load("iiwa14")


def plant():
    return Plant(arm(), damping=0.5)


def controller():
    return TorqueController(arm(), [FractalImpedance("tip", ForceProfile.tanh(1000.0, 60.0))])


def pushed(**figures):
    return simulate(plant(), controller(), 0.002, pushes=[Push(**figures)])


def record():
    return simulate(plant(), controller(), 0.002)


CALLS = {
    "Wall": (lambda: Wall, {"point": [0, 0, 0], "normal": [0, 0, 1], "whole": False}, {}, {}),
    "Peg": (
        lambda: Peg,
        {"start": [1, 0, 0], "end": [1, 0, 1], "radius": 0.1},
        {"start": "end of a peg", "end": "end of a peg"},
        {},
    ),
    "Box": (lambda: Box, {"pose": np.eye(4), "size": [0.1, 0.1, 0.1]}, {}, {}),
    "Payload": (lambda: Payload, {"mass": 1.0, "centre": (0, 0, 0), "radius": 0.1}, {}, {}),
    "World": (
        lambda: World,
        {
            "walls": (),
            "pegs": (),
            "payload": None,
            "tip_radius": 0.02,
            "arm_radius": 0.04,
            "boxes": (),
            "shapes": True,
        },
        {},
        {"walls": "none at all", "pegs": "none at all", "boxes": "none at all", "payload": "None"},
    ),
    "Plant": (
        lambda: Plant,
        {
            "arm": arm(),
            "world": None,
            "damping": "file",
            "armature": 0.0,
            "timestep": 0.00025,
            "joint_limits": True,
            "effort_limits": True,
            "friction": "file",
        },
        {},
        {"world": "None"},
    ),
    "Plant.reset": (lambda: plant().reset, {"q": HOME, "v": None}, {}, {"v": "None"}),
    "Plant.step": (lambda: plant().step, {"torque": np.zeros(7)}, {}, {}),
    "Plant.push": (lambda: plant().push, {"on": "tip", "force": [1.0, 0.0, 0.0]}, {"on": "push is on"}, {}),
    "Push": (lambda: pushed, {"on": "tip", "force": [1.0, 0.0, 0.0], "start": 0.0, "duration": 0.001}, {}, {}),
    "simulate": (
        lambda: simulate,
        {
            "plant": plant(),
            "controller": controller(),
            "duration": 0.002,
            "rate": 4000.0,
            "delay": 0.0,
            "pushes": (),
            "every": 1,
        },
        {},
        {"pushes": "none at all"},
    ),
    "Record.errors": (lambda: record().errors, {"T_base_target": np.eye(4)}, {"T_base_target": "pose"}, {}),
}


@pytest.mark.parametrize("name", CALLS)
def test_wrong_things_are_named(name):
    make, good, names, takes = CALLS[name]
    refuses(make(), good, names, takes)


def test_functions_that_a_loop_calls_are_functions():
    for name in ("target", "stop"):
        for wrong in ("nonsense", 1, [], np.zeros(7)):
            with pytest.raises(srs_ik.InvalidController, match=f"the {name} has to be a function"):
                simulate(plant(), controller(), 0.002, **{name: wrong})


@pytest.mark.parametrize("torque", [None, "nonsense", np.zeros(6), np.full(7, np.nan), np.zeros((7, 1)), [None] * 7])
def test_torques_of_a_controller_are_seven_figures(torque):
    class Wrong:
        def torque(self, q, v):
            return torque

    with pytest.raises(srs_ik.InvalidController, match="7 finite numbers"):
        simulate(plant(), Wrong(), 0.002)


@pytest.mark.parametrize("wrong", [None, "nonsense", np.zeros((3, 6)), [[0.0] * 7] * 3])
def test_a_record_is_made_of_arrays_of_as_many_rows(wrong):
    good = record()
    fields = {name: getattr(good, name) for name in Record.__dataclass_fields__}
    assert Record(**fields).tip.shape == (len(good.t), 3)
    for name in sorted(set(fields) - {"arm", "world"}):
        with pytest.raises(srs_ik.InvalidController, match=name):
            Record(**{**fields, name: wrong})
    for name in ("arm", "world"):
        with pytest.raises(srs_ik.InvalidController, match=name):
            Record(**{**fields, name: wrong})


def test_a_replay_needs_a_path_and_a_rate(tmp_path):
    for wrong in (None, 1, b"page.html", object()):
        with pytest.raises(srs_ik.InvalidController, match="path of a replay"):
            record().replay(wrong)
    for rate in (None, 0.0, -1.0, "30", np.inf, np.nan):
        with pytest.raises(srs_ik.InvalidController, match="rate"):
            record().replay(tmp_path / "page.html", rate=rate)
    with pytest.raises(srs_ik.InvalidPose):
        record().replay(tmp_path / "page.html", target="nonsense")
    assert not list(tmp_path.iterdir())


def test_a_replay_is_a_page_and_no_video(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(srs_ik.PreviewError, match=r"such as scene.html, not 'motion\.mp4'"):
        record().replay("motion.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("start", [0.002, 9.0])
def test_a_push_that_never_begins_is_refused(start):
    with pytest.raises(srs_ik.InvalidController, match=r"a push begins at .* when the simulation of 0.002 s is over"):
        pushed(on="tip", force=[1.0, 0.0, 0.0], start=start, duration=0.3)
    with pytest.raises(srs_ik.InvalidController, match="start of a push"):
        pushed(on="tip", force=[1.0, 0.0, 0.0], start=-start, duration=0.3)


def test_a_controller_of_another_robot_is_refused():
    other = arms.load("gen3")
    hold = TorqueController(other, [])
    with pytest.raises(srs_ik.InvalidController, match="the plant is 'iiwa14' and the controller is of 'gen3'"):
        simulate(plant(), hold, 0.002)
    # Joints of the same names do not make it one.
    same_names = arms.load("made_offsets")
    assert same_names.joint_names == other.joint_names
    with pytest.raises(srs_ik.InvalidController, match="another robot"):
        simulate(Plant(same_names), hold, 0.002)
    # Another tool does not make it another one.
    tool = np.eye(4)
    tool[2, 3] = 0.1
    simulate(plant(), TorqueController(arm().with_tool(tool), []), 0.002)


def test_plants_and_records_are_told_in_a_line():
    made = Plant(arm(), World(walls=(Wall([0, 0, -1], [0, 0, 1]),), payload=Payload(1.0)))
    assert repr(made) == "Plant(iiwa14, 1 wall, payload, at 0 s)"
    assert repr(record()) == "Record(iiwa14: 8 samples, to 0.00175 s)"
