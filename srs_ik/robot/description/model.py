"""Any description of a robot to a ``pinocchio.Model``."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any
from xml.etree.ElementTree import Element, tostring

import pinocchio as pin

from srs_ik.errors import InvalidRobot, listed
from srs_ik.robot.description import document, mjcf, xacro
from srs_ik.robot.description.check import Follower, check
from srs_ik.robot.description.files import label_of, read
from srs_ik.system.forks import WHOLE


@dataclass(frozen=True, eq=False)
class Drawing:
    """Where the shapes of a robot's links can be read, once somebody wants to see them."""

    # absolute path of the robot's file, beside which its meshes are looked for; None for text and objects
    file: Path | None
    content: Any = None  # URDF text or the ``yourdfpy.URDF``; None if it is what the file holds


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A robot as Pinocchio sees it, and what Pinocchio does not keep."""

    model: Any  # the ``pinocchio.Model`` of the whole robot. In it an effort or velocity limit of 0 means "not given".
    name: str  # the robot's own name
    source: str  # where it came from, as error messages call it
    # joints that follow another one, or are tied to one, each with a clause that says so, such as "mimics j1". `model`
    # has them as joints of their own, but they cannot be joints of a limb.
    mimic_joints: Mapping[str, str] = field(default_factory=dict)
    followers: Mapping[str, Follower] = field(default_factory=dict)  # those of them of which is known how they follow
    drawing: Drawing | None = None  # where its shapes are; None for a bare model and for MJCF

    @property
    def ties(self) -> dict[str, str]:
        """The joints that are tied to others, of which is not known how, each with a clause that says so."""
        return {name: clause for name, clause in self.mimic_joints.items() if name not in self.followers}


def load_model(
    source: Any, xacro_args: Mapping[str, str] | None = None, packages: Mapping[str, str] | None = None
) -> RobotModel:
    """Read a robot description.

    Meshes are not needed, and nothing is written. A ``pinocchio.Model`` is passed on as it is.

    Args:
        source: path of a URDF, xacro (``.xacro``) or MJCF file (str or path object), URDF text (a str that starts with
            "<"), a ``yourdfpy.URDF``, or a ``pinocchio.Model``.
        xacro_args: arguments of a xacro file.
        packages: folders of ROS packages that a xacro file needs and that cannot be found otherwise.

    Raises:
        InvalidRobot: there is no such file, or it is no valid description; the message says what is wrong.
        MissingExtra: a xacro file, and xacro is not installed.
    """
    if isinstance(source, os.PathLike) and isinstance(os.fspath(source), bytes):
        source = os.fsdecode(source)
    if xacro_args and not (isinstance(source, str | os.PathLike) and Path(source).suffix == ".xacro"):
        raise InvalidRobot("arguments are for xacro files, whose names end in .xacro")
    if isinstance(source, pin.Model):
        return RobotModel(source, source.name or "robot", "the pinocchio.Model", followers=_coupled(source))
    if isinstance(source, str) and is_xml(source):
        return _from_elements(document.parse(source, "the URDF text"), "the URDF text", Drawing(None, source))
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        label = label_of(path)
        if path.suffix == ".xacro":
            text = xacro.expand(path, label, xacro_args or {}, packages)
            return _from_elements(document.parse(text, label), label, Drawing(path.absolute(), text))
        content = read(path, label)
        if document.root_tag(content) == "mujoco":
            model, tied = mjcf.build(path, content, label)
            held = {name: Follower("", 0.0, at) for name, at in tied.items() if at is not None}
            return RobotModel(model, model.name, label, dict.fromkeys(tied, "is tied by an equality"), held)
        return _from_elements(document.parse(content, label), label, Drawing(path.absolute()))
    # Whoever holds such an object has imported its package; for all others the import would be a waste.
    yourdfpy = sys.modules.get("yourdfpy")
    if yourdfpy is not None and isinstance(source, yourdfpy.URDF):
        from srs_ik.robot.description.from_yourdfpy import elements

        label = f"the yourdfpy.URDF {getattr(source.robot, 'name', None)!r}"
        return _from_elements(elements(source, label), label, Drawing(None, source))
    kinds = "a robot's name, the path or text of a description, a pinocchio.Model or a yourdfpy.URDF"
    raise InvalidRobot(f"a robot is given by {kinds}, not by an object of type {type(source).__name__}")


def is_xml(text: str) -> bool:
    """True if a string is XML text rather than a name or a path."""
    return text.lstrip("\ufeff \t\r\n").startswith("<")


def _from_elements(robot: Element, source: str, drawing: Drawing) -> RobotModel:
    followers = check(robot, source)
    text = tostring(robot, encoding="unicode")
    with _stderr_captured() as printed:
        try:
            model = pin.buildModelFromXML(text)
        except Exception as error:
            complaint = _first_complaint(printed()) or str(error).strip().partition("\n")[0]
            raise InvalidRobot(f"{source}: {complaint}", source) from None
    clauses = {name: f"mimics {listed([follower.leader or 'another joint'])}" for name, follower in followers.items()}
    return RobotModel(model, model.name, source, clauses, followers, drawing)


def _coupled(model: Any) -> dict[str, Follower]:
    """The joints of a model that follow others in it; where they are is Pinocchio's affair."""
    pairs = zip(model.mimicking_joints, model.mimicked_joints, strict=True)
    return {model.names[follower]: Follower(model.names[leader]) for follower, leader in pairs}


@contextmanager
def _stderr_captured() -> Iterator[Callable[[], str]]:
    """Keep back what C++ code prints on file descriptor 2; yields a function that returns it.

    The descriptor belongs to the whole process: what other threads print meanwhile is kept back too, so the block has
    to be short. It is restored in any case.
    """
    with WHOLE:
        try:
            saved = os.dup(2)
        except OSError:
            # Standard error is closed, as in some services: nothing can reach it.
            yield lambda: ""
            return
        try:
            if sys.stderr is not None:
                sys.stderr.flush()
            with _scratch_file() as file:

                def printed() -> str:
                    file.seek(0)
                    return file.read(1 << 16).decode(errors="replace")

                os.dup2(file.fileno(), 2)
                try:
                    yield printed
                finally:
                    os.dup2(saved, 2)
        finally:
            os.close(saved)


def _scratch_file() -> IO[bytes]:
    """A file without a name; in memory where the system has that, as there may be no folder to write to."""
    return os.fdopen(os.memfd_create("stderr"), "r+b") if hasattr(os, "memfd_create") else tempfile.TemporaryFile()


def _first_complaint(printed: str) -> str:
    for line in printed.splitlines():
        label, colon, message = line.partition(":")
        if colon and label.strip() == "Error" and message.strip():
            return message.strip()
    return ""
