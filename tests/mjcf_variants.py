"""Made-up MJCF files against MuJoCo itself: python tests/mjcf_variants.py --count 2000

Each seed makes a file, with files that it includes, from everything that moves bodies or joints: notations of
orientations, nested default classes, limits in every combination, several joints a body, frames, references, ties, and
now and then something that makes no sense. `load_model` either refuses it in one line, or agrees with MuJoCo to 1e-9 on
the pose of every body and site at random joint values, on limits, on masses and the mass matrix, and on which joints
are tied. A file that MuJoCo refuses has to be refused.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

from srs_ik import InvalidRobot
from srs_ik.robot.description import load_model

FREE, BALL, SLIDE, HINGE = (
    int(kind)
    for kind in (
        mujoco.mjtJoint.mjJNT_FREE,
        mujoco.mjtJoint.mjJNT_BALL,
        mujoco.mjtJoint.mjJNT_SLIDE,
        mujoco.mjtJoint.mjJNT_HINGE,
    )
)
TOLERANCE = 1e-9
ODD = 0.12
"""Share of files with something in them that makes no sense."""


class Maker:
    """Makes one file from a seed."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.files: dict[str, str] = {}
        self.classes = ["main"]
        self.bodies: list[str] = []
        self.joints: list[str] = []
        self.sites: list[str] = []
        self.odd = self.rng.random() < ODD
        self.autolimits = self.chance(0.75)
        self.balls = self.chance(0.3)
        # Not both: MuJoCo 4.0 makes copies of tendons for each copy of a shape.
        self.replicates = self.chance(0.3)

    def chance(self, share: float) -> bool:
        return self.rng.random() < share

    def numbers(self, count: int, size: float = 1.0) -> str:
        form = self.rng.choice(("{:.3g}", "{!r}", "{:.6f}", "{:+.2e}"))
        return " ".join(form.format(self.rng.uniform(-size, size)) for _ in range(count))

    def whole(self) -> dict[str, str]:
        """Texts by file name; the main file is ``main.xml``."""
        compilers = "".join(self.compiler() for _ in range(self.rng.choice((not self.autolimits, 1, 1, 1, 2))))
        defaults = "".join(self.default(0) for _ in range(self.rng.choice((0, 1, 1, 2))))
        world = self.children(0, self.rng.randint(1, 2))
        if self.chance(0.5):
            world = self.chain() + world
        sections = [compilers, defaults, f"<worldbody>{world}</worldbody>", self.equality()]
        if self.chance(0.3):
            k = self.rng.randrange(len(sections))
            sections[k] = self.included(sections[k])
        self.rng.shuffle(sections)
        text = f"<mujoco{self.maybe('model', 'm', 0.8)}>{''.join(sections)}</mujoco>"
        if self.odd:
            text = self.spoilt(text)
        return {"main.xml": text, **self.files}

    def compiler(self) -> str:
        words = {
            "angle": self.rng.choice(("radian", "degree")),
            "eulerseq": "".join(self.rng.choice("xyzXYZ") for _ in range(3)),
            "inertiafromgeom": self.rng.choice(("auto", "auto", "true")),
            "coordinate": "local",
            "boundmass": "0.01",
            "boundinertia": "0.001",
            "inertiagrouprange": "0 3",
            "fusestatic": "false",
            "balanceinertia": "true",
        }
        return (
            f"<compiler{self.some(words, 0.4)}/>"
            if self.autolimits
            else f'<compiler{self.some(words, 0.4)} autolimits="false"/>'
        )

    def default(self, depth: int, parent: str = "main") -> str:
        name = "main"
        if depth:
            name = f"c{len(self.classes)}"
            self.classes.append(name)
        label = f' class="{name}"' if depth or self.chance(0.3) else ""
        parts = []
        if self.chance(0.7):
            parts.append(f"<joint{self.some(self.joint_words(), 1.0)}/>")
        if self.chance(0.4):
            parts.append(f"<site{self.maybe('pos', self.numbers(3), 0.5)}{self.orientation(0.6)}/>")
        if self.chance(0.3):
            parts.append(
                f'<geom{self.maybe("density", "500", 0.5)}{self.maybe("group", "2", 0.3)} size="0.1 0.2 0.3"/>'
            )
        if depth < 3:
            parts += [self.default(depth + 1, name) for _ in range(self.rng.choice((0, 1, 1, 2)))]
        self.rng.shuffle(parts)
        return f"<default{label}>{''.join(parts)}</default>"

    def joint_words(self) -> dict[str, str]:
        """Attributes of a joint, limits in every combination that makes sense."""
        words = {
            "type": self.rng.choice(("hinge", "hinge", "hinge", "slide", "ball" if self.balls else "hinge")),
            "pos": self.numbers(3, 0.3),
            "axis": self.rng.choice(("1 0 0", "0 1 0", "0 0 1", "0 0 -3", "0.6 0 0.8", self.numbers(3))),
            "ref": self.numbers(1),
            "springref": self.numbers(1),
            "damping": "0.5",
            "stiffness": "2",
        }
        words = {key: value for key, value in words.items() if self.chance(0.4)}
        if self.chance(0.5):
            low = 0.0 if self.balls else self.rng.choice((0.0, self.rng.uniform(-3.0, 0.0)))
            words["range"] = f"{low!r} {self.rng.uniform(0.6, 3)!r}"
        sides = ("true", "false", "auto", "") if "range" in words else ("false", "auto", "")
        limited = self.rng.choice(sides if self.autolimits else ("false", *sides[:-2]))
        if limited:
            words["limited"] = limited
        if self.chance(0.2):
            words |= {"actuatorfrcrange": "-5 7", "actuatorfrclimited": self.rng.choice(("true", "false"))}
        return words

    def orientation(self, share: float = 0.7) -> str:
        if not self.chance(share):
            return ""
        key = self.rng.choice(("quat", "axisangle", "xyaxes", "zaxis", "euler"))
        if key == "zaxis" and self.chance(0.2):
            return f' zaxis="0 0 {self.rng.choice((-1, 2, -0.5))}"'
        size = self.rng.choice((1.0, 3.0, 60.0)) if key in ("euler", "quat") else 2.0
        return f' {key}="{self.numbers({"quat": 4, "axisangle": 4, "xyaxes": 6}.get(key, 3), size)}"'

    def some(self, words: dict[str, str], share: float) -> str:
        return "".join(f' {key}="{value}"' for key, value in words.items() if self.chance(share))

    def maybe(self, key: str, value: str, share: float) -> str:
        return f' {key}="{value}"' if self.chance(share) else ""

    def chain(self) -> str:
        """An arm of seven joints, as most files have one."""
        opening = "".join(self.body_start(joints=1) + self.geoms() for _ in range(7))
        return opening + self.site() + "</body>" * 7

    def body_start(self, joints: int) -> str:
        name = f"b{len(self.bodies)}"
        self.bodies.append(name)
        words = f' name="{name}"{self.maybe("pos", self.numbers(3), 0.8)}{self.orientation()}{self.childclass(0.3)}'
        return f"<body{words}>" + "".join(self.joint() for _ in range(joints))

    def childclass(self, share: float) -> str:
        return self.maybe("childclass", self.rng.choice(self.classes), share)

    def joint(self) -> str:
        name = f"j{len(self.joints)}"
        self.joints.append(name)
        words = self.joint_words()
        return f'<joint name="{name}"{self.some(words, 1.0)}{self.maybe("class", self.rng.choice(self.classes), 0.3)}/>'

    def site(self) -> str:
        name = f"s{len(self.sites)}"
        self.sites.append(name)
        if len(self.classes) == 1 and self.chance(0.1):
            return f'<site name="{name}" type="capsule" size="0.01" fromto="{self.numbers(6)}"/>'
        placed = f"{self.maybe('pos', self.numbers(3), 0.8)}{self.orientation()}"
        return f'<site name="{name}"{placed}{self.maybe("class", self.rng.choice(self.classes), 0.3)}/>'

    def geoms(self) -> str:
        text = ""
        if self.chance(0.3):
            moments = self.rng.choice(('diaginertia="0.3 0.4 0.5"', 'fullinertia="0.3 0.4 0.5 0.01 -0.02 0.03"'))
            turned = self.orientation(0.5) if moments.startswith("d") else ""
            text += f'<inertial mass="{self.rng.uniform(0.1, 3)!r}" pos="{self.numbers(3, 0.2)}"{turned} {moments}/>'
        # One that counts in any case: MuJoCo refuses what moves and weighs nothing.
        text += '<geom type="sphere" size="0.05" mass="0.2" group="0"/>'
        for _ in range(self.rng.choice((0, 1, 2))):
            kind = self.rng.choice(("sphere", "capsule", "cylinder", "box", "ellipsoid"))
            weight = self.rng.choice(("", ' mass="0.5"', ' density="300"', ' group="4"'))
            if kind != "sphere" and self.chance(0.3):
                text += f'<geom type="{kind}" size="0.05" fromto="{self.numbers(6, 0.5)}"{weight}/>'
            else:
                placed = f'pos="{self.numbers(3, 0.3)}"{self.orientation(0.5)}'
                text += f'<geom type="{kind}" size="0.05 0.07 0.09" {placed}{weight}/>'
        return text

    def children(self, depth: int, count: int) -> str:
        text = ""
        for _ in range(count):
            joints = (
                self.rng.choice((0, 1, 1, 1, 2, 3)[: 4 if self.balls else 6]) if depth or not self.chance(0.2) else 0
            )
            inner = self.body_start(joints)
            if not depth and not joints and self.chance(0.3):
                name = f"j{len(self.joints)}"
                self.joints.append(name)
                inner += self.rng.choice((f'<freejoint name="{name}"/>', f'<joint type="free" name="{name}"/>'))
            inner += self.geoms() + (self.site() if self.chance(0.5) else "")
            if self.replicates and self.chance(0.5):
                inner += '<replicate count="3" offset="0 0 0.1"><geom size="0.01" mass="0.001"/></replicate>'
            if self.chance(0.2):
                inner += "<camera/><light/>"
            if depth < 4:
                inner += self.children(depth + 1, self.rng.choice((0, 1, 1, 2)))
            inner += "</body>"
            if self.chance(0.3):
                inner = self.framed(inner, depth)
            if self.chance(0.1):
                inner = self.included(inner)
            text += inner
        return text

    def framed(self, inner: str, depth: int) -> str:
        words = f"{self.maybe('pos', self.numbers(3), 0.8)}{self.orientation()}{self.childclass(0.4)}"
        if self.chance(0.3):
            inner = self.framed(inner, depth)
        if self.chance(0.4):
            inner = self.site() + inner
        if depth and not self.balls and self.chance(0.3):
            inner = self.joint() + inner
        return f"<frame{words}>{inner}</frame>"

    def included(self, inner: str) -> str:
        """The text in a file of its own; MuJoCo refuses one that holds nothing."""
        if not inner:
            return inner
        name = f"{self.rng.choice(('', 'parts/'))}f{len(self.files)}.xml"
        self.files[name] = f"<mujocoinclude>{inner}</mujocoinclude>"
        return f'<include file="{name}"/>'

    def equality(self) -> str:
        parts: list[str] = []
        if self.replicates:
            return ""
        single = list(self.joints)
        if len(single) > 2 and self.chance(0.3):
            one, two = self.rng.sample(single, 2)
            second = self.maybe("joint2", two, 0.7)
            parts.append(f'<joint joint1="{one}"{second} polycoef="0 1"{self.maybe("active", "false", 0.2)}/>')
        if len(self.bodies) > 1 and self.chance(0.3):
            one, two = self.rng.sample(self.bodies, 2)
            kind = self.rng.choice(('connect anchor="0 0 0"', "weld"))
            parts.append(f'<{kind} body1="{one}"{self.maybe("body2", two, 0.7)}/>')
        if len(self.sites) > 1 and self.chance(0.15):
            one, two = self.rng.sample(self.sites, 2)
            parts.append(f'<{self.rng.choice(("connect", "weld"))} site1="{one}" site2="{two}"/>')
        tendon = ""
        if len(single) > 1 and self.chance(0.2):
            coefficients = "".join(f'<joint joint="{name}" coef="1"/>' for name in self.rng.sample(single, 2))
            tendon = f'<tendon><fixed name="t">{coefficients}</fixed></tendon>'
            parts.append('<tendon tendon1="t"/>')
        return f"{tendon}<equality>{''.join(parts)}</equality>" if parts else tendon

    def spoilt(self, text: str) -> str:
        """The text with one thing in it that makes no sense, or that is rarely met."""
        changes = (
            ("<worldbody>", "<worldbody><composite/>"),
            ("<body ", '<body quat="0 0 0 0" '),
            ("<body ", '<body twist="1" '),
            ("<body ", '<body euler="1 2 3" quat="1 0 0 0" '),
            ("<body ", '<body euler="1 2" '),
            ("<body ", '<body pos="1 2 nan" '),
            ("<body ", '<body childclass="nowhere" '),
            ("<joint ", '<joint limited="yes" '),
            ("<joint ", '<joint range="2 1" '),
            ("<joint ", '<joint axis="0 0 0" '),
            ("<joint ", '<joint limited="true" range="1 1" '),
            ("<joint ", '<joint type="screw" '),
            ("<joint ", '<joint class="nowhere" '),
            ("<mujoco", '<mujoco><compiler coordinate="global"/></mujoco><mujoco'),
            ("<worldbody>", '<compiler coordinate="global"/><worldbody>'),
            ("<worldbody>", '<compiler eulerseq="xyw"/><worldbody>'),
            ("<worldbody>", '<compiler angle="grad"/><worldbody>'),
            ("<worldbody>", '<default class="other"/><worldbody>'),
            ("<worldbody>", '<default><default class="c1"/><default class="c1"/></default><worldbody>'),
            ("<worldbody>", '<worldbody><joint type="hinge"/>'),
            ("<worldbody>", '<worldbody><replicate count="2"><body name="r"/></replicate>'),
            ("<worldbody>", '<worldbody><attach body="b0" prefix="p"/>'),
            ("<worldbody>", '<worldbody childclass="main">'),
            ("<worldbody>", '<worldbody><body name="b0"/>'),
            ("<worldbody>", '<worldbody><body name="world"/>'),
            ("<worldbody>", '<include file="nowhere.xml"/><worldbody>'),
            ("<worldbody>", '<include file="main.xml"/><worldbody>'),
            ("<worldbody>", '<worldbody><frame name="f"/><frame name="f"/>'),
            ("<worldbody>", '<worldbody><body><body><freejoint/><geom size="1"/></body></body>'),
            ("<worldbody>", '<worldbody><body><freejoint/><joint/><geom size="1"/></body>'),
            ("<worldbody>", '<worldbody><body><joint type="ball"/><joint/><geom size="1"/></body>'),
            ("<worldbody>", '<worldbody><body><joint/><joint name="k"/><geom size="1"/></body>'),
            ("<worldbody>", '<worldbody><site name="x" fromto="0 0 0 0 0 0" type="box" size="1"/>'),
            ("<worldbody>", '<worldbody><body><inertial mass="-1" pos="0 0 0" diaginertia="1 1 1"/></body>'),
            ("</mujoco>", '<equality><joint joint1="nowhere"/></equality></mujoco>'),
            ("</mujoco>", '<equality><gear joint1="j0"/></equality></mujoco>'),
            ("</mujoco>", '<equality><connect body1="nowhere" anchor="0 0 0"/></equality></mujoco>'),
            ("</mujoco>", "<robot/></mujoco>"),
        )
        there = [change for change in changes if change[0] in text]
        old, new = self.rng.choice(there)
        at = self.rng.choice([k for k in range(len(text)) if text.startswith(old, k)])
        return text[:at] + new + text[at + len(old) :]


def write(texts: dict[str, str], folder: Path) -> Path:
    """Write the files; the main one."""
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return folder / "main.xml"


def compared(path: Path, seed: int) -> str:
    """What becomes of a file: "agrees", "refused by both: ...", "refused: ..."; all else is an AssertionError."""
    try:
        theirs = mujoco.MjModel.from_xml_path(str(path))
        complaint = ""
    except ValueError as error:
        theirs, complaint = None, " ".join(str(error).split())
    try:
        ours = load_model(path)
    except InvalidRobot as error:
        line = str(error)
        return f"refused{' by both' if theirs is None else ''}: {line.partition(': ')[2]}"
    assert theirs is not None, f"read, though MuJoCo says: {complaint}"
    rng = np.random.default_rng(seed)
    for _ in range(3):
        _compare_poses(ours.model, theirs, rng)
    _compare_limits(ours.model, theirs)
    _compare_ties(frozenset(ours.mimic_joints), theirs)
    return "agrees"


def _compare_poses(model: pin.Model, theirs: mujoco.MjModel, rng: np.random.Generator) -> None:
    data, configuration = mujoco.MjData(theirs), pin.neutral(model)
    names = [theirs.joint(k).name for k in range(theirs.njnt)]
    assert model.njoints == 1 + len(names)
    simple = True
    sizes = {FREE: 7, BALL: 4, SLIDE: 1, HINGE: 1}
    for k, name in enumerate(names):
        joint = model.joints[model.getJointId(name) if name else k + 1]
        assert joint.nq == sizes[int(theirs.jnt_type[k])], f"{name} is of another kind"
        kind, at = int(theirs.jnt_type[k]), theirs.jnt_qposadr[k]
        if kind in (HINGE, SLIDE):
            data.qpos[at] = configuration[joint.idx_q] = rng.uniform(-3, 3)
            continue
        simple = False
        turn = rng.normal(size=4)
        turn /= np.linalg.norm(turn)
        if kind == BALL:
            data.qpos[at : at + 4] = turn
            configuration[joint.idx_q : joint.idx_q + 4] = np.roll(turn, -1)
        else:
            body = theirs.jnt_bodyid[k]
            there = pin.SE3(pin.Quaternion(*theirs.body_quat[body]), theirs.body_pos[body])
            moved = pin.SE3(pin.Quaternion(*turn), rng.normal(size=3))
            configuration[joint.idx_q : joint.idx_q + 7] = pin.SE3ToXYZQUAT(moved)
            data.qpos[at : at + 7] = np.roll(pin.SE3ToXYZQUAT(there * moved), 0)[[0, 1, 2, 6, 3, 4, 5]]
    mujoco.mj_kinematics(theirs, data)
    mujoco.mj_comPos(theirs, data)
    mujoco.mj_makeM(theirs, data)
    mine = model.createData()
    pin.framesForwardKinematics(model, mine, configuration)
    frames = {(f.name, f.type): mine.oMf[k] for k, f in enumerate(model.frames)}
    found = [(theirs.body(k).name, pin.FrameType.BODY, data.xpos[k], data.xmat[k]) for k in range(1, theirs.nbody)]
    found += [
        (theirs.site(k).name, pin.FrameType.OP_FRAME, data.site_xpos[k], data.site_xmat[k]) for k in range(theirs.nsite)
    ]
    for name, kind, position, matrix in found:
        if not name:
            continue
        pose = frames[name, kind]
        miss = max(np.abs(pose.translation - position).max(), np.abs(pose.rotation - matrix.reshape(3, 3)).max())
        assert miss < TOLERANCE, f"{name} misses by {miss:.2e}"
    if any(inertia.mass > 0 for inertia in model.inertias) and theirs.nv:
        weight = sum(inertia.mass for inertia in model.inertias)
        assert abs(weight - theirs.body_mass[1:].sum()) < TOLERANCE * max(1.0, weight), "masses differ"
        if simple:
            M = np.zeros((theirs.nv, theirs.nv))
            mujoco.mj_fullM(theirs, data, M)
            mine_M = pin.crba(model, mine, configuration)
            mine_M = np.triu(mine_M) + np.triu(mine_M, 1).T
            order = [model.joints[model.getJointId(name) if name else k + 1].idx_v for k, name in enumerate(names)]
            miss = np.abs(mine_M[np.ix_(order, order)] - M).max() / max(1.0, np.abs(M).max())
            assert miss < TOLERANCE, f"the mass matrix misses by {miss:.2e}"


def _compare_limits(model: pin.Model, theirs: mujoco.MjModel) -> None:
    for k in range(theirs.njnt):
        if int(theirs.jnt_type[k]) not in (HINGE, SLIDE):
            continue
        name = theirs.joint(k).name
        at = model.joints[model.getJointId(name) if name else k + 1].idx_q
        limits = np.array([model.lowerPositionLimit[at], model.upperPositionLimit[at]])
        meant = theirs.jnt_range[k] if theirs.jnt_limited[k] else np.array([-np.inf, np.inf])
        assert np.allclose(limits, meant, rtol=0, atol=TOLERANCE), f"{name} has the limits {limits}, not {meant}"


def _compare_ties(tied: frozenset[str], theirs: mujoco.MjModel) -> None:
    """Joints that a constraint couples are tied: those that it names, and those that would tear a connection apart."""
    data = mujoco.MjData(theirs)
    for k in range(theirs.neq):
        if not theirs.eq_active0[k]:
            continue
        kind, one, two = int(theirs.eq_type[k]), theirs.eq_obj1id[k], theirs.eq_obj2id[k]
        if kind == int(mujoco.mjtEq.mjEQ_JOINT):
            needed = {one, two} - {-1}
        elif kind == int(mujoco.mjtEq.mjEQ_TENDON):
            at = theirs.tendon_adr[one]
            needed = set(theirs.wrap_objid[at : at + theirs.tendon_num[one]])
        else:
            by_site = theirs.eq_objtype[k] == int(mujoco.mjtObj.mjOBJ_SITE)
            bodies = [theirs.site_bodyid[one], theirs.site_bodyid[two]] if by_site else [one, two]
            needed = {j for j in range(theirs.njnt) if _moves(theirs, data, j, *bodies)}
        names = {theirs.joint(j).name for j in needed}
        assert names <= tied, f"{sorted(names - tied)} are tied and not known to be"


def _moves(theirs: mujoco.MjModel, data: mujoco.MjData, joint: int, one: int, two: int) -> bool:
    relative = []
    for step in (0.0, 0.3):
        data.qpos[:] = theirs.qpos0
        if int(theirs.jnt_type[joint]) == BALL:
            data.qpos[theirs.jnt_qposadr[joint] : theirs.jnt_qposadr[joint] + 4] = [np.cos(step), np.sin(step), 0, 0]
        else:
            data.qpos[theirs.jnt_qposadr[joint]] += step
        mujoco.mj_kinematics(theirs, data)
        poses = [pin.SE3(data.xmat[k].reshape(3, 3), data.xpos[k]) for k in (one, two)]
        relative.append(poses[0].actInv(poses[1]).homogeneous)
    return not np.allclose(*relative, atol=1e-9)


def main() -> int:
    """Compare; the exit status is 1 if a file was read otherwise than by MuJoCo."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--show", action="store_true", help="print what is refused, and why")
    options = parser.parse_args()
    verdicts: Counter[str] = Counter()
    for seed in range(options.first, options.first + options.count):
        with tempfile.TemporaryDirectory() as folder:
            path = write(Maker(seed).whole(), Path(folder))
            try:
                verdict = compared(path, seed)
            except AssertionError as error:
                verdict = "FAILED"
                print(f"seed {seed}: {error}")
            if options.show and verdict.startswith("refused:"):
                print(f"seed {seed}: {verdict}")
            verdicts[verdict.partition(":")[0]] += 1
    print(dict(verdicts))
    return int(verdicts["FAILED"] > 0)


if __name__ == "__main__":
    sys.exit(main())
