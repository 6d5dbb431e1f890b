"""xacro files to URDF text, without ROS."""

from __future__ import annotations

import contextlib
import importlib
import io
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from srs_ik.errors import InvalidRobot, MissingExtra
from srs_ik.robot.description.packages import find_package

_LOCK = threading.Lock()
"""xacro keeps its state in globals."""


def expand(path: Path, label: str, arguments: Mapping[str, str], packages: Mapping[str, str] | None = None) -> str:
    """Expand a xacro file.

    Its expressions are run, within the limits that xacro sets them: expand only files that you trust.

    Args:
        path: the file.
        label: what error messages call it.
        arguments: values of its ``<xacro:arg>``.
        packages: folders of ROS packages that cannot be found otherwise, see `srs_ik.robot.description.packages`.

    Raises:
        MissingExtra: xacro is not installed.
        InvalidRobot: the file is faulty, or a package or file that it includes is missing.
    """
    try:
        xacro, substitution = importlib.import_module("xacro"), importlib.import_module("xacro.substitution_args")
    except ImportError:
        raise MissingExtra("xacro", f"the xacro file {label}") from None
    if not path.is_file():
        raise InvalidRobot(f"there is no file {label}", label)

    def find(name: str) -> str:
        folder = (packages or {}).get(name) or find_package(name, near=path)
        if folder is None:
            hint = "put the folder that holds it on ROS_PACKAGE_PATH"
            raise InvalidRobot(f"{label} needs the ROS package {name!r}, which is not here: {hint}", label)
        return str(folder)

    with _LOCK, _finding(substitution, find), contextlib.redirect_stderr(io.StringIO()):
        try:
            document = xacro.process_file(str(path), mappings=dict(arguments))
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
        return str(document.toxml())


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
