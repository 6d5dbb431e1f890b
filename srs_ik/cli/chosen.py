"""Which arm of a robot is meant, and how its description is read: the same options in every command."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from srs_ik.cli.options import WrongInput, numbers

Chosen = dict[str, Any]
"""Arguments of `load`, in the parameter `chosen` of a command."""

Base = Annotated[
    str | None, typer.Option(metavar="FRAME", help="Base frame; may be left out where there is one choice.")
]
Tip = Annotated[str | None, typer.Option(metavar="FRAME", help="Tip frame; may be left out where there is one choice.")]
Limb = Annotated[
    str | None, typer.Option(metavar="WORD", help="Which of several arms: left, right, or a part of one of its names.")
]
Srdf = Annotated[
    Path | None, typer.Option(metavar="FILE", help="A MoveIt SRDF file; --limb is then one of its groups.")
]
XacroArg = Annotated[
    list[str] | None, typer.Option("--xacro-arg", metavar="NAME:=VALUE", help="Argument of a xacro file, repeatable.")
]
AllowXacro = Annotated[
    bool, typer.Option("--allow-xacro", help="Run the xacro file that an adapter names; such a file is a program.")
]
Lock = Annotated[
    list[str] | None,
    typer.Option(
        "--lock", metavar="NAME:=VALUE", help="Where another joint stands, always in rad or m; repeatable. Else 0."
    ),
]

READING: Mapping[str, tuple[Any, Any]] = {
    "xacro_arg": (XacroArg, None),
    "allow_xacro": (AllowXacro, False),
    "lock": (Lock, None),
}
"""Options that say how a description is read, by the name of their parameter: type and default."""

CHOOSING: Mapping[str, tuple[Any, Any]] = {
    "base": (Base, None),
    "tip": (Tip, None),
    "limb": (Limb, None),
    "srdf": (Srdf, None),
}
"""Options that say which arm is meant."""


def choosing(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command all these options in place of its parameter `chosen`, which then is what they say to `load`."""
    return _with_options(command, {**CHOOSING, **READING})


def reading(command: Callable[..., None]) -> Callable[..., None]:
    """The same without the choice, for a command that knows which arm is meant."""
    return _with_options(command, READING)


def _with_options(command: Callable[..., None], options: Mapping[str, tuple[Any, Any]]) -> Callable[..., None]:
    # The types are looked up here: in the module of the command, annotations are still text.
    types = get_type_hints(command, include_extras=True)
    signature = inspect.signature(command)
    own = [p.replace(annotation=types[p.name]) for p in signature.parameters.values() if p.name != "chosen"]
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    added = [inspect.Parameter(name, kind, default=usual, annotation=t) for name, (t, usual) in options.items()]
    place = len(own) - (own[-1].name == "as_json")

    @wraps(command)
    def run(**words: Any) -> None:
        command(chosen=_said({name: words.pop(name) for name in options}), **words)

    parameters = own[:place] + added + own[place:]
    run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {p.name: p.annotation for p in parameters}
    return run


def _said(words: dict[str, Any]) -> Chosen:
    """What the options say, as arguments of `load`."""
    xacro_args, lock = _pairs("--xacro-arg", words.pop("xacro_arg")), _pairs("--lock", words.pop("lock"))
    locked = None if lock is None else {name: numbers(f"--lock {name}", [word])[0] for name, word in lock.items()}
    return {**words, "xacro_args": xacro_args, "locked": locked}


def _pairs(option: str, words: list[str] | None) -> dict[str, str] | None:
    pairs = {}
    for word in words or []:
        name, separator, value = word.partition(":=")
        if not separator or not name:
            raise WrongInput(f"{option} takes NAME:=VALUE, not {word!r}")
        if name in pairs:
            raise WrongInput(f"{option} gives {name} twice")
        pairs[name] = value
    return pairs or None
