"""What stands at the end of each command's help: lines to try."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

_Q = "0.3 0.7 -0.4 -1.1 0.5 0.8 -0.2"
_POSE = "--xyz 0.5 0.1 0.6 --rpy 0 1.5708 0"

EXAMPLES: dict[str, Sequence[str]] = {
    "robots": ("srs-ik robots", "srs-ik robots --json"),
    "inspect": ("srs-ik inspect iiwa14", "srs-ik inspect my_robot.urdf --limb left --write robot.toml"),
    "fk": (f"srs-ik fk iiwa14 --q {_Q}", "srs-ik fk iiwa14 --file joints.csv --out poses.csv"),
    "solve": (
        f"srs-ik solve iiwa14 {_POSE}",
        f"srs-ik solve iiwa14 {_POSE} --seed {_Q}",
        "srs-ik solve iiwa14 --xyz 0.5 0.1 0.6 --rpy 0 90 0 --degrees --arm-angle 20 --all",
        f"srs-ik solve iiwa14 --q {_Q} --objective manipulability --json",
    ),
    "intervals": (f"srs-ik intervals iiwa14 {_POSE}", f"srs-ik intervals iiwa14 --q {_Q} --plot intervals.png"),
    "path": ("srs-ik path iiwa14 poses.csv --dt 0.01 --out joints.csv",),
    "place": ("srs-ik place iiwa14 poses.csv --grid -1 1 21 -1 1 21 --by width",),
    "follow": (
        "srs-ik follow iiwa14 poses.csv --dt 0.002 --out joints.csv",
        "srs-ik follow iiwa14 poses.csv --dt 0.01 --smoothing 0.05 --elbow limit_margin --json",
    ),
    "collisions": (
        f"srs-ik collisions iiwa14 --q {_Q}",
        "srs-ik collisions iiwa14 --file joints.csv --path --scene scene.json --margin 0.01",
    ),
    "ellipsoids": (f"srs-ik ellipsoids iiwa14 --q {_Q} --limits --along 0 0 1",),
    "plot": (
        f"srs-ik plot intervals iiwa14 {_POSE} --output intervals.png",
        f"srs-ik plot ellipsoids iiwa14 --q {_Q} --output ellipsoids.pdf",
    ),
    "preview": (
        "srs-ik preview iiwa14 --interactive",
        "srs-ik preview gen3 --q 0 20 0 -80 0 10 0 --degrees --ellipsoids --save gen3.html",
    ),
    "task": ("srs-ik task human_arm --xyz 0.2 0.1 0.3 --velocity 1 0 0 --force 0 0 -1",),
    "reproduce": ("srs-ik reproduce c-grasp --out results",),
    "bench": ("srs-ik bench iiwa14 --poses 1000 --out bench.json",),
}
"""For each command; those with a name of a built-in robot and no file to read work as they stand."""


def with_examples(help_of: Callable[..., str]) -> Callable[..., str]:
    """The text of a command's help, followed by its examples: not wrapped, so that they can be copied."""

    def help_and_examples(command: Any, context: Any) -> str:
        lines = EXAMPLES.get(command.name, ())
        heading = "Examples:" if len(lines) > 1 else "Example:"
        return "\n".join([help_of(command, context), *(["", heading] if lines else []), *(f"  {x}" for x in lines)])

    return help_and_examples
