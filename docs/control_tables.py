"""The tables of docs/control_measured.md, each from the figures of its experiment."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from srs_ik.paper.experiments.control.law import PROFILES
from srs_ik.paper.experiments.control.pushes import RUNS
from srs_ik.paper.experiments.control.reaching import SECONDS
from srs_ik.paper.experiments.control.setting import NAMES


def all_tables(found: dict[str, Any]) -> dict[str, list[str]]:
    """Tables by the name of their place on the page."""
    return {
        "law": law_table(found["control-law"]),
        "energy": energy_table(found["control-passivity"]["injected_share_of_U0"]),
        "price": price_table(found["control-passivity"]["price"]),
        "pushes": push_table(found["control-pushes"]),
        "stretch": stretch_table(found["control-stretch"]["stretch"]),
        "forbidden": forbidden_table(found["control-stretch"]["forbidden"]),
        "contact": contact_table(found["control-contact"]),
        "rate": rate_table(found["control-rate"]),
        "reaching": reaching_table(found["control-reaching"]),
        "human": human_table(found["control-human"]),
        "walking": walking_table(found["control-walking"]),
        "model": model_table(found["control-model"]),
        "time": time_table(found["control-passivity"]),
    }


def table(head: str, rows: Iterable[Iterable[Any]]) -> list[str]:
    """A table whose head names its columns; those after the first one are figures, set to the right."""
    columns = [name.strip() for name in head.split("|")]
    lines = [f"| {' | '.join(columns)} |", "|---|" + "--:|" * (len(columns) - 1)]
    return lines + [f"| {' | '.join(str(cell) for cell in row)} |" for row in rows]


def figure(value: float) -> str:
    """Two digits, without powers of ten where there are more before the point; what is rounding alone is zero."""
    if abs(value) < 1e-6:
        return "0"
    return f"{value:,.0f}" if abs(value) >= 100.0 else f"{value:.2g}"


def percent(share: float) -> str:
    return f"{100.0 * share:,.0f} %" if share >= 1.0 else f"{100.0 * share:.3g} %"


def law_table(found: dict[str, Any]) -> list[str]:
    rows = []
    for name, share in found["injected_share"].items():
        profile = PROFILES[name]
        knee = f"{1e3 * profile.knee:g}, {1e3 * (profile.knee + 20.0 * profile.width):g}" if profile.knee else "none"
        gains = f"{profile.stiffness:g}", f"{profile.largest:g}", knee, f"{profile.steepest:,.0f}"
        rows.append([name, *gains, percent(share["A"]), percent(share["B"])])
    return table(
        "profile | stiffness (N/m) | largest (N) | knee, end (mm) | steepest (N/m) | law A injects | law B", rows
    )


def energy_table(found: dict[str, Any]) -> list[str]:
    return table(
        "controller | injected, mean | worst",
        ([name, percent(row["mean"]), percent(row["worst"])] for name, row in found.items()),
    )


def price_table(found: dict[str, Any]) -> list[str]:
    projected = found["operational_space_largest_tip_error_in_a_jump_m"]
    rows = [
        [
            f"{row['elbow_N_m']:,.0f}",
            figure(1e3 * row["misplaced_tip_error_m"]),
            figure(1e3 * row["largest_tip_error_in_a_jump_m"]),
        ]
        for row in found["superposed"]
    ]
    return table(
        "elbow (N/m) | tip error at rest in the conflict (mm) | largest while the arm angle jumps (mm)",
        [*rows, ["operational space", "", f"{1e3 * projected:.2g}"]],
    )


def push_table(found: dict[str, Any]) -> list[str]:
    lines = [
        "| controller | joint damping (N m s/rad) | back | largest tip error (mm) | after 2 s (mm) | fastest joint "
        "(rad/s) |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for damping in ("0.5", "0"):
        for kind in RUNS:
            row = found[f"{kind}, damping {damping}"]
            off = row["final_tip_error_m"]
            lines.append(
                f"| {NAMES[kind]} | {damping} | {row['back']} of {row['pushes']} | "
                f"{1e3 * row['largest_tip_error_m']['median']:.0f} | {figure(1e3 * off['median'])}, at worst "
                f"{figure(1e3 * off['worst'])} | {row['largest_joint_speed_rad_s']['worst']:.2g} |"
            )
    return lines


def stretch_table(found: dict[str, Any]) -> list[str]:
    rows = []
    for motion, kinds in found.items():
        for kind, row in kinds.items():
            rows.append(
                [
                    motion,
                    NAMES[kind],
                    f"{row['below_3_rad_s']} of {row['seeds']}",
                    f"{row['largest_joint_speed_rad_s']['worst']:.2g}",
                    row["flips"],
                    f"{row['largest_torque_N_m']:,.0f}",
                    f"{1e3 * row['tip_error_at_home_m']['worst']:.2g}",
                ]
            )
    return table(
        "target | controller | below 3 rad/s | fastest joint (rad/s) | flips | largest torque asked for (N m) "
        "| tip at home (mm)",
        rows,
    )


FORBIDDEN = {
    "tip_alone": "radial, on the tip alone",
    "tip_alone_per_axis": "per axis, on the tip alone",
    "tip_and_repelling_limits": "radial, on the tip, and repelling limits",
    "all_ports": "radial, on tip, turn and elbow, and repelling limits",
}


def forbidden_table(found: dict[str, Any]) -> list[str]:
    rows = []
    for kind, name in FORBIDDEN.items():
        row = found[kind]
        within = f"{row['within_2_mm']} of {found['targets']}"
        rows.append([name, within, figure(1e3 * row["median_farther_m"]), figure(1e3 * row["worst_farther_m"])])
    return table("ports | within 2 mm | farther than it has to be, median (mm) | worst (mm)", rows)


def contact_table(found: dict[str, Any]) -> list[str]:
    rows = []
    for kind, wall in found["wall"].items():
        peg = found["peg"][kind]
        sags = ", ".join(f"{1e3 * row['sag_m']:.0f}" for row in found["payload"][kind].values())
        forces = [f"{row[name]:,.0f}" for row in (wall, peg) for name in ("peak_N", "lasting_N")]
        rows.append([NAMES[kind], *forces, f"{peg['largest_joint_speed_rad_s']:.2g}", sags])
    return table(
        "controller | wall: peak (N) | then (N) | peg: peak (N) | then (N) | peg: fastest joint (rad/s) "
        "| sag under 0.5, 1, 2, 3 kg (mm)",
        rows,
    )


def arrival(seconds: float) -> str:
    return f"{seconds:.2f}" if seconds < 0.99 * SECONDS else "not"


def reaching_table(found: dict[str, Any]) -> list[str]:
    lines = [
        "| controller | within 1 mm for good (s) | off the line (%) | speed peaks | tip after 2 s (mm) | turn (deg) |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for kind, row in found.items():
        lines.append(
            f"| {NAMES[kind]} | {arrival(row['arrival_s']['median'])} | {100.0 * row['off_the_line']['median']:.1f} | "
            f"{row['speed_peaks']['median']:.0f} | {1e3 * row['final_tip_error_m']['worst']:.2g} | "
            f"{row['final_turn_error_deg']['worst']:.2g} |"
        )
    return lines


def human_table(found: dict[str, Any]) -> list[str]:
    lines = [
        "| plan | one speed peak | peak over mean speed | R² with minimum jerk | spectral arc length | off the line "
        "(%) |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for plan, row in found["plans"].items():
        lines.append(
            f"| {plan.replace('_', ' ')} | {row['with_one_speed_peak']} of 100 | "
            f"{row['peak_over_mean_speed']['median']:.2f} | {row['R2_with_minimum_jerk']['median']:.3f} | "
            f"{row['spectral_arc_length']['median']:.2f} | {100.0 * row['off_the_line']['median']:.1f} |"
        )
    return lines


def rate_table(found: dict[str, Any]) -> list[str]:
    pairs = len(found["rate_Hz"]) * len(found["delay_s"])
    rows = [
        [
            NAMES[kind],
            f"{found[kind]['at_rest_within']} of {found['cases_within_the_rule']}",
            f"{found[kind]['at_rest']} of {pairs}",
            figure(found[kind]["largest_joint_speed_rad_s"]),
        ]
        for kind in ("per_axis", "radial", "linear", "joint")
    ]
    return table("controller | at rest within the rule | at rest of all pairs | fastest joint (rad/s)", rows)


def walking_table(found: dict[str, Any]) -> list[str]:
    toe = found["toe_error_m"]
    rows = [
        ["toes from their target, rms (mm)", figure(1e3 * toe["rms"])],
        ["toes, largest (mm)", figure(1e3 * toe["largest"])],
        ["knee, largest (mm)", figure(1e3 * found["knee_error_m"]["largest"])],
        ["fastest joint (rad/s)", f"{found['largest_joint_speed_rad_s']:.2g}"],
        ["largest torque (N m)", f"{found['largest_torque_N_m']:.2g}"],
    ]
    rows += [
        [f"power in the null space, elbow turned by {name}, median", f"{100.0 * row['median']:.0f} %"]
        for name, row in found["null_space_share_of_power"].items()
    ]
    return table("walking leg | figure", rows)


def model_table(found: dict[str, Any]) -> list[str]:
    return table(
        "arm | read by | mass matrix, relative | bias torques, relative | after 1 s of fall (rad) | fallen (rad)",
        (
            [
                name,
                "MuJoCo" if row["read_from"] == "urdf" else "Pinocchio",
                f"{row['M']:.0e}",
                f"{row['h']:.0e}",
                f"{row['fall_difference_rad']:.0e}",
                f"{row['fallen_rad']:.1f}",
            ]
            for name, row in found.items()
        ),
    )


def time_table(found: dict[str, Any]) -> list[str]:
    rows = [[NAMES[kind], f"{value:.0f}"] for kind, value in found["microseconds_a_tick"].items()]
    seconds = found["processor_seconds_for_10_s_at_4_kHz"]
    return table(
        "controller | a tick (µs)", [*rows, ["10 s at 4 kHz in MuJoCo, recorded (s of a processor)", f"{seconds:.2g}"]]
    )
