"""xacro files to URDF text, without ROS."""

from __future__ import annotations

import contextlib
import importlib
import io
import threading
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from srs_ik.errors import InvalidRobot, MissingExtra, did_you_mean, quoted
from srs_ik.robot.description.packages import find_package

_LOCK = threading.Lock()
"""xacro keeps its state in globals."""


def expand(path: Path, label: str, arguments: Mapping[str, str], packages: Mapping[str, str] | None = None) -> str:
    """Expand a xacro file.

    Its expressions are run, within the limits that xacro sets them: expand only files that you trust.

    Args:
        path: the file.
        label: what error messages call it.
        arguments: values of its ``<xacro:arg>``; a warning says which it makes no use of.
        packages: folders of ROS packages that cannot be found otherwise, see `srs_ik.robot.description.packages`.

    Raises:
        MissingExtra: xacro is not installed.
        InvalidRobot: the file is faulty, or a package or file that it includes is missing.
    """
    if not path.is_file():
        raise InvalidRobot(f"there is no file {label}", label)
    try:
        xacro, substitution = importlib.import_module("xacro"), importlib.import_module("xacro.substitution_args")
    except ImportError:
        raise MissingExtra("xacro", f"the xacro file {label}") from None

    def find(name: str) -> str:
        folder = (packages or {}).get(name) or find_package(name, near=path)
        if folder is None:
            hint = "put the folder that holds it on ROS_PACKAGE_PATH"
            raise InvalidRobot(f"{label} needs the ROS package {name!r}, which is not here: {hint}", label)
        return str(folder)

    given = _Asked(arguments)
    with _LOCK, _finding(substitution, find), contextlib.redirect_stderr(io.StringIO()):
        try:
            document = xacro.process_file(str(path), mappings=given)
        except Exception as error:
            cause = _cause(error)
            if isinstance(cause, InvalidRobot):
                raise cause from None
            reason = " ".join(str(cause).split()) or type(cause).__name__
            if isinstance(cause, substitution.ArgException):
                reason = f"its argument {reason!r} has no value: give it one, --xacro-arg {reason}:=VALUE"
            raise InvalidRobot(f"{label} cannot be expanded: {reason}", label) from None
        if not document.getElementsByTagName("link"):
            reason = "it has no <link> of its own; if it only defines macros, take the file that uses them"
            raise InvalidRobot(f"{label} expands to nothing: {reason}", label)
    # Outside of what keeps the expansion from printing: a warning is printed, too.
    for name in arguments:
        if name not in given.asked:
            hint = did_you_mean(name, sorted(given.asked))
            warnings.warn(f"{label} makes no use of the argument {quoted(name)}{hint}", UserWarning, stacklevel=2)
    return str(document.toxml())


class _Asked(dict[str, str]):
    """Arguments that know which of them a file has asked for, whether they are there or not."""

    def __init__(self, arguments: Mapping[str, str]) -> None:
        super().__init__(arguments)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


@contextlib.contextmanager
def _finding(module: Any, find: Any) -> Iterator[None]:
    """Let ``$(find package)`` ask this function; xacro itself only asks an installation of ROS."""
    before, in_expressions = module._eval_find, module._eval_dict["find"]
    module._eval_find = module._eval_dict["find"] = find
    try:
        yield
    finally:
        module._eval_find, module._eval_dict["find"] = before, in_expressions


def _cause(error: Exception) -> BaseException:
    """The error that xacro has wrapped, once or more."""
    cause: BaseException = error
    while isinstance(inner := getattr(cause, "exc", None), BaseException):
        cause = inner
    return cause
