"""The robots that have names: one folder each, with a ``robot.toml``, and for built-in ones their URDF beside it."""

from __future__ import annotations

from pathlib import Path

from srs_ik.errors import InvalidRobot, did_you_mean, listed
from srs_ik.robot.card import CARD_FILE, RobotCard, read_card


def robots() -> list[str]:
    """Names of the built-in robots, whose description is in this package, sorted.

    Raises:
        InvalidRobot: the installation has lost its folder of robots.
    """
    return [name for name, here in _folders().items() if here]


def adapters() -> list[str]:
    """Names of the robots whose description comes from elsewhere, sorted; InvalidRobot where their folder is lost."""
    return [name for name, here in _folders().items() if not here]


def card(name: str) -> RobotCard:
    """The card of a robot that has a name; raises InvalidRobot where there is none, or it is damaged."""
    known = _folders()
    if name not in known:
        raise InvalidRobot(
            f"there is no robot of the name {name!r}{did_you_mean(name, known)}; there are {listed(list(known))}",
            source=name,
        )
    path = _folder() / name / CARD_FILE
    found = read_card(path)
    if found.name != name:
        raise InvalidRobot(f"{path}: the name {found.name!r} must be that of its folder, {name!r}", source=path)
    return found


def _folders() -> dict[str, bool]:
    """Every name, and whether there is a URDF in its folder."""
    paths = sorted(_folder().glob(f"*/{CARD_FILE}"))
    return {path.parent.name: any(path.parent.glob("*.urdf")) for path in paths}


def _folder() -> Path:
    package = Path(__file__).resolve().parents[1]
    # A wheel carries the robots inside the package; in a checkout they lie beside it.
    for folder in (package / "robots", package.parent / "robots"):
        if folder.is_dir():
            return folder
    raise InvalidRobot(f"the folder of built-in robots is missing beside or inside {package}", source=package)
