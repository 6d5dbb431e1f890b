"""`srs-ik inspect`: what the package sees in a robot file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli import EXIT_NO_SOLUTION
from srs_ik.cli.chosen import CHOOSING, Chosen, choosing
from srs_ik.cli.options import AsJson, Source, warn
from srs_ik.cli.scenes import Meshes, with_meshes

if TYPE_CHECKING:
    from rich.console import Console

    from srs_ik.arm import Arm
    from srs_ik.errors import NotAnSrsLimb
    from srs_ik.loading import LimbReport


Write = Annotated[
    Path | None, typer.Option(metavar="robot.toml", help="Write an adapter for the arm, which every command takes.")
]
Packed = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Write the one arm as C programs read it; see docs/cpp.md.")
]


@choosing
def inspect(
    source: Source,
    chosen: Chosen,
    write: Write = None,
    bodies: Annotated[
        bool, typer.Option("--bodies", help="Show the bodies of the one arm: spheres, and pairs that are watched.")
    ] = False,
    meshes: Meshes = None,
    packed: Packed = None,
    as_json: AsJson = False,
) -> None:
    """Show the 7-joint arms that are recognised in a robot.

    With each arm: its kind, lengths and joint limits, and by how many millimetres its axes miss the shoulder and wrist
    centres. An arm is exact, near (solved all the same, on its true axes), or refused. Exit status 1 if none is
    accepted. With --write, an adapter for the one arm is written: a file to correct frames, limits and hand in.
    URDF and MJCF files and adapters are data; a xacro file is a program, and runs with what you may do.
    """
    from srs_ik.cli.render import console, print_json

    meant = {name: chosen[name] for name in CHOOSING}
    reading = {name: value for name, value in chosen.items() if name not in meant}
    one = any(value is not None for value in meant.values()) or _names_one_arm(source, reading)
    findings = _chosen(source, meant, reading) if one else _all(source, reading)
    accepted = any(finding["kind"] != "refused" for finding in findings)
    if write is not None and accepted:
        from srs_ik.loading import load
        from srs_ik.loading.adapter import names_xacro, write_adapter

        write_adapter(write, source, load(source, **reading, **meant), reading["xacro_args"])
        allowed = " --allow-xacro" if names_xacro(write) else ""
        warn(f"wrote {write}; check it, then try 'srs-ik inspect {write}{allowed}'")
    answer: dict[str, Any] = {"source": source, "limbs": findings}
    if bodies and accepted:
        from srs_ik.cli.scenes import bodies_of, print_bodies
        from srs_ik.loading import load

        arm = with_meshes(load(source, **reading, **meant), meshes)
        answer |= bodies_of(arm)
    if packed is not None and accepted:
        from srs_ik.loading import load
        from srs_ik.solve.packed import limb_file
        from srs_ik.system.writing import write_whole

        write_whole(packed, limb_file(load(source, **reading, **meant).packed))
        warn(f"wrote {packed}")
    if as_json:
        print_json(answer)
    else:
        out = console()
        for i, finding in enumerate(findings):
            if i:
                out.print()
            _print_finding(out, finding)
        if bodies and accepted:
            print_bodies(out, arm)
    if not findings:
        warn(f"{_why_nothing(source, reading)}.")
    if not accepted:
        raise typer.Exit(EXIT_NO_SOLUTION)


def _names_one_arm(source: str, reading: Chosen) -> bool:
    """True for an adapter and for the name of an arm: of a robot with two they mean one."""
    from srs_ik.robot.sources import describe

    return describe(source, xacro_args=reading["xacro_args"], allow_xacro=reading["allow_xacro"]).tip is not None


def _all(source: str, reading: Chosen) -> list[dict[str, Any]]:
    from srs_ik.loading import find_limbs, load

    findings = []
    for report in find_limbs(source, **reading):
        if report.limb is not None:
            arm = load(source, base=report.base, tip=report.tip, **reading)
            findings.append(_accepted(arm, report))
        else:
            findings.append(_refused(report, report.base, report.tip, report.reason, report.note))
    return findings


def _why_nothing(source: str, reading: Chosen) -> str:
    """Why there is nothing to show."""
    from srs_ik.errors import NotAnSrsLimb
    from srs_ik.loading import load

    try:
        load(source, **reading)
    except NotAnSrsLimb as error:
        return str(error)
    return f"{source} has no chain of 7 consecutive revolute joints"


def _chosen(source: str, meant: dict[str, Any], reading: Chosen) -> list[dict[str, Any]]:
    from srs_ik.errors import NotAnSrsLimb
    from srs_ik.loading import find_limbs, load

    try:
        arm = load(source, **reading, **meant)
        reports = [report for report in find_limbs(source, **reading) if report.joint_names == arm.joint_names]
        return [_accepted(arm, reports[0] if reports else None)]
    except NotAnSrsLimb as error:
        if not error.joint_names:
            # Nothing was found that could be shown: the choice is wrong, not the arm.
            raise
        return [_refused(error, meant["base"], meant["tip"], str(error))]


def _accepted(arm: Arm, report: LimbReport | None) -> dict[str, Any]:
    from srs_ik.loading.adapter import hand_axes

    limb = arm.limb
    # Of another tip than the usual one, joints may be behind the arm as well.
    locked = list(dict.fromkeys([*(report.locked if report else ()), *arm.still_joints]))
    return {
        "base": arm.base,
        "tip": arm.tip,
        "kind": limb.kind,
        "reason": "",
        "note": report.note if report else "",
        "locked": locked,
        "carried_by": [name for name in locked if name not in arm.still_joints],
        "locked_at": {name: at for name, at in arm.locked.items() if name in locked},
        "frames": [name for name in (report.tip, *report.frames) if name != arm.tip] if report else [],
        "joint_names": list(arm.joint_names),
        "misses_mm": 1e3 * limb.misses,
        "wrist_kind": limb.wrist_kind,
        "upper_arm": limb.upper_arm,
        "forearm": limb.forearm,
        "hand": limb.hand,
        "elbow_offset": limb.elbow_offset,
        "hand_axes": None if arm.hand is None else {name: list(axis) for name, axis in arm.hand._asdict().items()},
        "hand_axes_as_drawn": dict(zip(("grasp", "pronosupination"), hand_axes(limb), strict=True)),
        "shoulder": limb.shoulder,
        "elbow": limb.elbow,
        "wrist": limb.wrist,
        "reference": limb.reference,
        "axes": limb.axes,
        "lower": arm.lower,
        "upper": arm.upper,
        "velocity_limit": arm.velocity_limit,
        "effort_limit": arm.effort_limit,
    }


def _refused(
    found: LimbReport | NotAnSrsLimb, base: str | None, tip: str | None, reason: str, note: str = ""
) -> dict[str, Any]:
    return {
        "base": base,
        "tip": tip,
        "kind": "refused",
        "reason": reason,
        "note": note,
        "joint_names": list(found.joint_names),
        "misses_mm": found.misses_mm,
        "allowed_mm": found.allowed_mm,
    }


def _print_refused(out: Console, finding: dict[str, Any], chain: str) -> None:
    from srs_ik.cli.render import fixed, table
    from srs_ik.robot.recognition import NEAR_MISS_RATIO

    names, misses = finding["joint_names"], finding["misses_mm"]
    out.print(f"{chain}: refused, no S-R-S arm")
    out.print(f"  {finding['reason']}")
    if finding["note"]:
        out.print(f"  {finding['note']}")
    if len(misses) != 7 or len(names) != 7:
        return
    centres = ("shoulder",) * 3 + ("-",) + ("wrist",) * 3
    rows = zip(map(str, range(1, 8)), names, centres, (fixed(miss, 3) for miss in misses), strict=True)
    out.print(table(("axis", "joint", "centre", "misses it by (mm)"), rows, left=3))
    if math.isfinite(finding["allowed_mm"]):
        part = f"{100 * NEAR_MISS_RATIO:g} % of the length from shoulder over elbow to wrist"
        out.print(f"Up to {finding['allowed_mm']:.1f} mm would be accepted, {part}.")


def _print_finding(out: Console, finding: dict[str, Any]) -> None:
    from srs_ik.cli.render import direction, fixed, table
    from srs_ik.errors import listed
    from srs_ik.robot.candidates import told_of_locked

    names, misses = finding["joint_names"], finding["misses_mm"]
    chain = f"{finding['base'] or '?'} -> {finding['tip'] or '?'}"
    if finding["kind"] == "refused":
        _print_refused(out, finding, chain)
        return

    out.print(f"{chain}: {finding['kind']} S-R-S arm, {finding['wrist_kind']} wrist")
    if finding["note"]:
        out.print(finding["note"])
    for clause in told_of_locked(finding["locked"], finding["locked_at"], finding["carried_by"]):
        out.print(clause)
    if finding["frames"]:
        out.print(f"other frames on its last joint, for --tip: {listed(finding['frames'])}")
    lengths = [
        (name.replace("_", " "), fixed(1e3 * finding[name], 3))
        for name in ("upper_arm", "forearm", "hand", "elbow_offset")
    ]
    out.print(table(("length", "mm"), lengths))
    out.print()
    centres = [(name, *(fixed(1e3 * x, 3) for x in finding[name])) for name in ("shoulder", "elbow", "wrist")]
    out.print(table(("centre at zero, in the base frame", "x (mm)", "y (mm)", "z (mm)"), centres))
    out.print(
        f"The arm angle is zero where the elbow lies towards ({direction(finding['reference'])}) of the base frame."
    )
    _print_hand(out, finding)
    rows = [
        (name, direction(axis), fixed(miss, 4)) for name, axis, miss in zip(names, finding["axes"], misses, strict=True)
    ]
    out.print()
    out.print(table(("joint", "axis at zero", "misses its centre by (mm)"), rows, left=2))
    out.print()
    out.print(_limits(finding))


def _print_hand(out: Console, finding: dict[str, Any]) -> None:
    """Where the hand points in the tip frame: as it is given, or else as one would draw it."""
    from srs_ik.cli.render import direction

    known = finding["hand_axes"]
    axes = known or finding["hand_axes_as_drawn"]
    grasp, across = direction(axes["grasp"]), direction(axes["pronosupination"])
    if known:
        out.print(f"The hand reaches out along ({grasp}) of the tip frame, with ({across}) across it.")
    else:
        out.print(f"No hand is given. From wrist to tip is ({grasp}) of the tip frame, with ({across}) across it:")
        out.print(f"if the hand points there, 'srs-ik task' takes --hand {grasp} {across}.")


def _limits(finding: dict[str, Any]) -> Any:
    import numpy as np

    from srs_ik.cli.render import fixed, table

    columns = ("joint", "lower (deg)", "upper (deg)", "lower (rad)", "upper (rad)", "velocity (rad/s)", "effort (N m)")
    lower, upper = finding["lower"], finding["upper"]
    rows = [
        (
            name,
            fixed(np.rad2deg(lower[i]), 2),
            fixed(np.rad2deg(upper[i]), 2),
            fixed(lower[i], 5),
            fixed(upper[i], 5),
            fixed(finding["velocity_limit"][i], 4),
            fixed(finding["effort_limit"][i], 2),
        )
        for i, name in enumerate(finding["joint_names"])
    ]
    return table(columns, rows)
