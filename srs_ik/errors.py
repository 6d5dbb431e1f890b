"""Errors that this package raises on purpose; every one is a single sentence, and carries the figures it speaks of.

Out of reach and out of limits are no errors: they are answers with a status.
"""

from __future__ import annotations

import difflib
import json
import math
import re
import reprlib
import shlex
import sys
import warnings
from collections.abc import Iterable, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

from srs_ik.system import bounds

_LISTED = 40
"""Longest list of names that is spelled out in a message; the fields of an error always hold all of them."""

_SPELLED = 16
"""Figures of an array that a message spells as a list, as far as it has room."""

LIKE_FRAMES = 0.8
"""Likeness of a frame's name to one that is suggested: most end in "_link", and that alone makes them alike by 0.6."""

_LONGEST = 2000
"""Characters of a message."""


class SrsIkError(Exception):
    """Base class of all errors of this package."""

    def __init__(self, message: str = "") -> None:
        # What a message quotes may have lines of its own, such as an array that was given for a number.
        super().__init__(_shortened(" ".join(line.strip() for line in message.splitlines()), _LONGEST))

    def __reduce__(self) -> tuple[Any, ...]:
        # The default calls the class with the finished message, which is not what every constructor takes.
        return _restore, (type(self), self.args, self.__dict__)


class InvalidRobot(SrsIkError):
    """A robot description that cannot be read, or that contradicts itself.

    Attributes:
        source: what was read, as the message calls it; empty if unknown.
    """

    def __init__(self, message: str, source: object = "") -> None:
        super().__init__(message)
        self.source = str(source)


class FrameNotFound(SrsIkError):
    """A base or tip frame that the robot does not have.

    Attributes:
        frame: the name that was asked for.
        available: names of the frames that there are, in the order of the robot.
    """

    def __init__(self, frame: str, available: Iterable[str], robot: str = "", source: str = "") -> None:
        self.frame = str(frame)
        self.available = tuple(available)
        where = f" in robot {quoted(robot)}" if robot else ""
        message = f"{source}: " if source else ""
        hint = did_you_mean(self.frame, self.available, LIKE_FRAMES)
        message += f"there is no frame {quoted(self.frame)}{where}{hint}"
        super().__init__(f"{message}; its frames are {listed(self.available)}" if self.available else message)


class NotAnSrsLimb(SrsIkError):
    """A chain of joints that is no shoulder-elbow-wrist limb.

    Attributes:
        joint_names: the joints in question, from the base outwards; seven unless the chain has another number of them.
        misses_mm: for each joint the distance of its axis from the common point it ought to pass, millimetres; empty if
            the chain was refused for another reason than its axes.
        allowed_mm: largest distance that is accepted, millimetres; NaN where there is none.
    """

    def __init__(
        self,
        message: str,
        joint_names: Sequence[str] = (),
        misses_mm: Sequence[float] = (),
        allowed_mm: float = math.nan,
    ) -> None:
        super().__init__(message)
        self.allowed_mm = float(allowed_mm)
        self.joint_names = tuple(joint_names)
        self.misses_mm = tuple(float(miss) for miss in misses_mm)


class AmbiguousLimb(SrsIkError):
    """Several limbs that fit the question.

    Attributes:
        candidates: (base, tip) frame names of each.
    """

    def __init__(self, message: str, candidates: Iterable[tuple[str, str]] = ()) -> None:
        super().__init__(message)
        self.candidates = tuple((str(base), str(tip)) for base, tip in candidates)


class MissingExtra(SrsIkError, ImportError):
    """Something that needs an optional part of the installation.

    Attributes:
        extra: name of the extra of this package that brings it.
    """

    def __init__(self, extra: str, needed_for: str) -> None:
        self.extra = extra
        super().__init__(f"{needed_for} needs an optional part of srs_ik: {self.command}")

    @property
    def command(self) -> str:
        """The pip command that installs the extra from where this package is: a checkout, a folder or an index."""
        return install_command(self.extra)


class MissingLimits(SrsIkError, ValueError):
    """Joint limits that a question needs and that are not given.

    Attributes:
        kind: "velocity" or "effort".
        joints: the joints without a limit.
    """

    def __init__(self, kind: str, joints: Sequence[str], robot: str = "") -> None:
        self.kind = kind
        self.joints = tuple(joints)
        whose = f"the description of {robot} gives no" if robot else "there is no finite"
        unit = "rad/s" if kind == "velocity" else "N m"
        super().__init__(f"{whose} {kind} limit for {listed(self.joints)}; one for every joint is needed, in {unit}")


class InvalidPose(SrsIkError, ValueError):
    """A pose of the wrong shape, with entries that are not finite, or whose rotation is none."""


class InvalidConfiguration(SrsIkError, ValueError):
    """Joint angles of the wrong number, or with entries that are not finite."""


class InvalidTask(SrsIkError, ValueError):
    """A task whose vectors have the wrong shape, are not finite, or leave a direction undefined."""


class InvalidController(SrsIkError, ValueError):
    """A controller whose figures are malformed, that is not passive, or that an arm cannot have."""


class InvalidMap(SrsIkError, ValueError):
    """A map that cannot be made as it is asked for, or a store that holds none, or that of another robot."""


class InvalidScene(SrsIkError, ValueError):
    """A scene, or an object in it, of wrong sizes, with entries that are not finite, or whose name is not known."""


class NoBodies(SrsIkError):
    """An arm of whose links no shapes are at hand, so that nothing can be said of what they hit."""


class PreviewError(SrsIkError):
    """A preview that cannot be served or written, or that is closed already."""


def install_command(extra: str, package: Path = Path(__file__).parent) -> str:
    """The pip command that brings an extra to the package in a folder, however that was installed."""
    if _is_project(package.parent):
        return f"pip install -e {shlex.quote(f'{package.parent}[{extra}]')}"
    source = _installed_from() or "srs-ik"
    return f"pip install {shlex.quote(f'{source}[{extra}]')}"


def _is_project(folder: Path) -> bool:
    return (folder / "pyproject.toml").is_file()


def _installed_from() -> Path | None:
    """The folder that pip installed this package from, if it was one and is still there."""
    try:
        record = json.loads(metadata.distribution("srs-ik").read_text("direct_url.json") or "{}")
    except (metadata.PackageNotFoundError, ValueError):
        return None
    url = urlsplit(str(record.get("url", "")))
    folder = Path(url2pathname(url.path))
    return folder if url.scheme == "file" and _is_project(folder) else None


def warn_caller(message: str) -> None:
    """Warn as of the line outside of this package that called it, where Python tells a warning once."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).partition(".")[0] == "srs_ik":
        frame, level = frame.f_back, level + 1
    warnings.warn(message, UserWarning, stacklevel=level)


def did_you_mean(name: str, known: Iterable[str], likeness: float = 0.6) -> str:
    """The clause " (did you mean ...?)" for a part of up to three names, or a misspelt one; "" where none is close."""
    if not isinstance(name, str) or len(name) > bounds.COMPARED:
        return ""
    by_folded = {candidate.casefold(): candidate for candidate in known if len(candidate) <= bounds.COMPARED}
    folded = name.casefold()
    matches = [each for each in by_folded if re.search(rf"(^|[_/]){re.escape(folded)}($|[_/])", each)]
    if not 0 < len(matches) <= 3:
        matches = difflib.get_close_matches(folded, by_folded, n=3, cutoff=likeness)
    close = [by_folded[match] for match in matches]
    return f" (did you mean {' or '.join(repr(match) for match in close)}?)" if close else ""


def quoted(value: object) -> str:
    """A name or value in quotation marks, on one line, cut short where it is long."""
    if isinstance(value, str):
        return repr(_shortened(str(value), bounds.SHOWN))
    return _shortened(_spelled(value), bounds.SHOWN)


def listed(names: Sequence[str]) -> str:
    """Names as one comma-separated list, cut short where they are long or very many."""
    shown = ", ".join(_shortened(name, bounds.SHOWN) for name in names[:_LISTED])
    return shown if len(names) <= _LISTED else f"{shown} and {len(names) - _LISTED} more"


class _Spelling(reprlib.Repr):
    """Numbers and small arrays of NumPy as those of Python: np.float64(0.0) is 0.0 to whoever reads a message."""

    def repr_instance(self, x: Any, level: int) -> str:
        # Told by their module: to import NumPy would make every start of the command line wait.
        small = type(x).__module__ == "numpy" and getattr(x, "size", math.inf) <= _SPELLED
        plain = x.tolist() if small else x
        return super().repr_instance(x, level) if isinstance(plain, type(x)) else self.repr1(plain, level)


def _spelled(value: object) -> str:
    try:
        return _Spelling().repr(value)
    except Exception:
        # Python writes no whole number of more than 4300 digits, and an object may write itself as it likes.
        return f"an object of type {type(value).__name__}"


def _shortened(text: str, length: int) -> str:
    return text if len(text) <= length else f"{text[: length - 3]}..."


def _restore(cls: type[SrsIkError], args: tuple[Any, ...], state: dict[str, Any]) -> SrsIkError:
    error = cls.__new__(cls, *args)
    error.args = args
    error.__dict__.update(state)
    return error
