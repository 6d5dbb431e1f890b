"""Any description of a robot to a ``pinocchio.Model``."""

from __future__ import annotations

import itertools
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, tostring

import pinocchio as pin

from srs_ik.errors import InvalidRobot, did_you_mean
from srs_ik.robot.description import document, mjcf, xacro
from srs_ik.robot.description.check import check

_LONGEST_LABEL = 300
_MOST_FILES = 1000

_STDERR_LOCK = threading.Lock()


@dataclass(frozen=True, eq=False)
class Drawing:
    """Where the shapes of a robot's links can be read, once somebody wants to see them.

    Attributes:
        file: absolute path of the robot's file, beside which its meshes are looked for; None for text and objects.
        content: URDF text or the ``yourdfpy.URDF``; None if it is what the file holds.
    """

    file: Path | None
    content: Any = None


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A robot as Pinocchio sees it, and what Pinocchio does not keep.

    Attributes:
        model: the ``pinocchio.Model`` of the whole robot. In it an effort or velocity limit of 0 means "not given".
        name: the robot's own name.
        source: where it came from, as error messages call it.
        mimic_joints: names of joints that follow another one. `model` has them as joints of their own, but they cannot
            be joints of a limb.
        drawing: where its shapes are; None for a bare model and for MJCF.
    """

    model: Any
    name: str
    source: str
    mimic_joints: frozenset[str] = frozenset()
    drawing: Drawing | None = None


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
    if xacro_args and not (isinstance(source, str | os.PathLike) and Path(source).suffix == ".xacro"):
        raise InvalidRobot("arguments are for xacro files, whose names end in .xacro")
    if isinstance(source, pin.Model):
        return RobotModel(source, source.name or "robot", "the pinocchio.Model")
    if isinstance(source, str) and is_xml(source):
        return _from_elements(document.parse(source, "the URDF text"), "the URDF text", Drawing(None, source))
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        label = _label(path)
        if path.suffix == ".xacro":
            text = xacro.expand(path, label, xacro_args or {}, packages)
            return _from_elements(document.parse(text, label), label, Drawing(path.absolute(), text))
        content = read(path, label)
        if document.root_tag(content) == "mujoco":
            with _stderr_captured() as printed:
                model = mjcf.build(path, content, label, lambda: _first_complaint(printed()))
            return RobotModel(model, model.name or "robot", label)
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


def _label(path: Path) -> str:
    """A path as one line of a message."""
    text = str(path)
    if len(text) > _LONGEST_LABEL:
        text = text[:_LONGEST_LABEL] + "..."
    return text if text.isprintable() else repr(text)


def read(path: Path, label: str) -> bytes:
    """Content of a file, cut off where it is too large.

    Raises:
        InvalidRobot: there is no such file, or it cannot be read.
    """
    try:
        if path.is_dir():
            raise InvalidRobot(f"{label} is a directory, not a URDF file", label)
        if path.exists() and not path.is_file():
            raise InvalidRobot(f"{label} is not a regular file", label)
        with path.open("rb") as file:
            # One byte more than is read tells a file that is too large from one that just fits.
            return file.read(document.MAX_BYTES + 1)
    except FileNotFoundError:
        raise InvalidRobot(f"there is no file {label}{_close_files(path)}", label) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InvalidRobot(f"{label} cannot be read: {reason}", label) from None


def _close_files(path: Path) -> str:
    """The names of files beside a missing one that are like its own, as a clause."""
    try:
        beside = [entry.name for entry in itertools.islice(path.parent.iterdir(), _MOST_FILES)]
    except (OSError, ValueError):
        return ""
    return did_you_mean(path.name, beside)


def _from_elements(robot: Element, source: str, drawing: Drawing) -> RobotModel:
    mimic_joints = check(robot, source)
    text = tostring(robot, encoding="unicode")
    with _stderr_captured() as printed:
        try:
            model = pin.buildModelFromXML(text)
        except Exception as error:
            complaint = _first_complaint(printed()) or str(error).strip().partition("\n")[0]
            raise InvalidRobot(f"{source}: {complaint}", source) from None
    return RobotModel(model, model.name, source, mimic_joints, drawing)


@contextmanager
def _stderr_captured() -> Iterator[Callable[[], str]]:
    """Keep back what C++ code prints on file descriptor 2; yields a function that returns it.

    The descriptor belongs to the whole process: what other threads print meanwhile is kept back too, so the block has
    to be short. It is restored in any case.
    """
    with _STDERR_LOCK:
        try:
            saved = os.dup(2)
        except OSError:
            # Standard error is closed, as in some services: nothing can reach it.
            yield lambda: ""
            return
        try:
            if sys.stderr is not None:
                sys.stderr.flush()
            with tempfile.TemporaryFile() as file:

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


def _first_complaint(printed: str) -> str:
    for line in printed.splitlines():
        label, colon, message = line.partition(":")
        if colon and label.strip() == "Error" and message.strip():
            return message.strip()
    return ""
