"""Where a description may be: a path, or an address in a package that brings descriptions.

| address | means |
|---|---|
| ``package://NAME/FILE`` | a file of a ROS package |
| ``example-robot-data://FILE`` | a file of example-robot-data, below its folder of robots |
| ``robot_descriptions://NAME`` | a robot of robot_descriptions, which fetches it on first use |
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import io
import pkgutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from types import ModuleType

import pinocchio as pin

from srs_ik.errors import InvalidRobot, MissingExtra, SrsIkError, did_you_mean, listed
from srs_ik.robot.description.packages import find_package, inside

SCHEMES = ("package", "example-robot-data", "robot_descriptions")
DESCRIPTION = "_description"
"""How the names of robot_descriptions end."""

_DATA = Path("share", "example-robot-data", "robots")


@dataclass(frozen=True)
class Found:
    """A description that is here."""

    path: Path  # its file
    xacro_args: Mapping[str, str] = field(default_factory=dict)  # arguments that its package gives to a xacro file
    packages: Mapping[str, str] = field(default_factory=dict)  # folders of the ROS packages that its package names


def locate(places: Sequence[str], robot: str) -> Found:
    """The first of some places, paths or addresses, at which there is a file.

    Raises:
        InvalidRobot: none is there, or an address is none; the message says what to do for the robot.
        MissingExtra: the only place needs a package that is not installed.
    """
    errors: list[SrsIkError] = []
    for place in places:
        try:
            return _find(place, robot)
        except SrsIkError as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    reasons = "; ".join(f"{place}: {error}" for place, error in zip(places, errors, strict=True))
    raise InvalidRobot(f"the description of {robot!r} is at none of its places ({reasons})", robot)


def missing(places: Sequence[str], robot: str) -> str:
    """What has to be done before a robot can be loaded, without fetching anything; "" if nothing."""
    errors = []
    for place in places:
        try:
            if is_fetched(place):
                _known_description(place.partition("://")[2], robot)
            elif _find(place, robot).path.suffix == ".xacro" and importlib.util.find_spec("xacro") is None:
                raise MissingExtra("xacro", f"the xacro file {place}")
        except MissingExtra as error:
            errors.append(error.command)
        except SrsIkError as error:
            errors.append(str(error))
        else:
            return ""
    # A command is of more use than an explanation.
    return min(errors, key=lambda text: not text.startswith("pip "))


def is_fetched(place: str) -> bool:
    """True if a place is an address of robot_descriptions, which fetches its robots on first use."""
    return place.startswith("robot_descriptions://")


def _find(place: str, robot: str) -> Found:
    scheme, separator, rest = place.partition("://")
    if not separator:
        if not Path(place).is_file():
            raise InvalidRobot(f"there is no file {place}, the description of {robot!r}", place)
        return Found(Path(place))
    if scheme == "package":
        return Found(_in_ros_package(place, rest))
    if scheme == "example-robot-data":
        return Found(_in_example_robot_data(rest, robot))
    if scheme == "robot_descriptions":
        return _in_robot_descriptions(rest, robot)
    hint = did_you_mean(scheme, SCHEMES)
    raise InvalidRobot(f"{place} is no address of a description{hint}; addresses begin with {listed(SCHEMES)}", place)


def _in_ros_package(place: str, rest: str) -> Path:
    name, _, file = rest.partition("/")
    package = find_package(name)
    if package is None:
        reason = f"there is no ROS package {name!r} here: put the folder that holds it on ROS_PACKAGE_PATH"
        raise InvalidRobot(reason, place)
    path = inside(package, file)
    if path is None or not path.is_file():
        advice = "put the folder of one that has it on ROS_PACKAGE_PATH, first"
        raise InvalidRobot(f"the ROS package {package} has no file {file!r}: {advice}", place)
    return path


def _in_example_robot_data(file: str, robot: str) -> Path:
    """A file of example-robot-data, which installs no Python module that could be asked for it."""
    relative = inside(_DATA, file)
    if relative is not None:
        for path in _data_files(relative):
            if path.is_file():
                return path
    raise MissingExtra("robots", f"the robot {robot!r}")


def _data_files(relative: Path) -> Iterator[Path]:
    # Pip and conda both put it below the prefix in which they put Pinocchio's libraries.
    prefixes = [*Path(pin.__file__).resolve().parents, Path(sys.prefix)]
    yield from (prefix / relative for prefix in prefixes)
    try:
        files = metadata.files("example-robot-data") or ()
    except metadata.PackageNotFoundError:
        return
    yield from (Path(str(file.locate())) for file in files if file.match(str(relative)))


def described_names() -> list[str]:
    """Names that robot_descriptions knows; none where it is not installed."""
    try:
        return _names_in(importlib.import_module("robot_descriptions"))
    except ImportError:
        return []


def _names_in(package: ModuleType) -> list[str]:
    return [module.name for module in pkgutil.iter_modules(package.__path__) if module.name.endswith(DESCRIPTION)]


def _known_description(name: str, robot: str) -> None:
    """Check that robot_descriptions is installed and has a robot of this name."""
    try:
        package = importlib.import_module("robot_descriptions")
    except ImportError:
        raise MissingExtra("robots", f"the robot {robot!r} of robot_descriptions") from None
    known = _names_in(package)
    if name not in known:
        message = f"{name!r} is neither a file nor the name of a robot{did_you_mean(name, known)}"
        raise InvalidRobot(f"{message}; there are {listed(known)}", name)


def _in_robot_descriptions(name: str, robot: str) -> Found:
    _known_description(name, robot)
    try:
        with _quiet_unless_watched():
            module = importlib.import_module(f"robot_descriptions.{name}")
    except Exception as error:
        # The module fetches its files on import, which fails in as many ways as there are networks.
        lines = [line for line in str(error).splitlines() if line.strip()]
        # Of git's report the line that says what went wrong; its first one is the command.
        said = next((line for line in lines if "fatal:" in line), lines[0] if lines else type(error).__name__)
        said = said.strip().removeprefix("stderr: ").strip("'").removeprefix("fatal: ")
        raise InvalidRobot(
            f"the files of {name!r} could not be fetched: {said[:200]}; where there is no network, bring the "
            "folder ~/.cache/robot_descriptions of a machine that has one (or name it in ROBOT_DESCRIPTIONS_CACHE)",
            name,
        ) from error
    path = getattr(module, "URDF_PATH", None) or getattr(module, "XACRO_PATH", None)
    if path is None:
        raise InvalidRobot(f"robot_descriptions has {name!r} in other formats than URDF only", name)
    if getattr(module, "URDF_PATH", None):
        return Found(Path(path))
    return Found(Path(path), getattr(module, "XACRO_ARGS", {}), getattr(module, "XACRO_PACKAGE_PATHS", {}))


@contextlib.contextmanager
def _quiet_unless_watched() -> Iterator[None]:
    """Let the progress of a download be seen on a terminal, and keep standard output for answers."""
    stderr = sys.stderr if sys.stderr is not None and sys.stderr.isatty() else io.StringIO()
    with contextlib.redirect_stdout(stderr), contextlib.redirect_stderr(stderr):
        yield
