"""Writes the figures of docs/control.md and the verdicts on control in docs/what_holds.md: python docs/control.py DIR.

DIR is where `srs-ik reproduce control --out DIR` has left its results.
"""

from __future__ import annotations

import argparse
import io
import json
import re
from pathlib import Path
from typing import Any

from what_holds_rows import CORRECTED, FAILS, HOLDS, Row

from srs_ik.paper.experiments.control.pushes import RUNS
from srs_ik.paper.experiments.control.setting import NAMES
from srs_ik.writing import write_whole

DOCS = Path(__file__).resolve().parent
COMMAND = "srs-ik reproduce control"
WIDTH = 900
"""Of a picture on the page, dots."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    found = {path.stem: json.loads(path.read_text())["figures"] for path in sorted(folder.glob("control-*.json"))}
    rows = verdicts(found)
    lines = [f"| {row.claim} | **{row.verdict}** | {row.found} | `{row.command}` |" for row in rows]
    fill(DOCS / "what_holds.md", {"control": ["| claim | verdict | measured | by |", "|---|---|---|---|", *lines]})
    tables = {
        "pushes": push_table(found["control-pushes"]),
        "stretch": stretch_table(found["control-stretch"]["stretch"]),
        "contact": contact_table(found["control-contact"]),
        "reaching": reaching_table(found["control-reaching"]),
        "human": human_table(found["control-human"]),
    }
    fill(DOCS / "control.md", tables)
    for name in found:
        small_picture(folder / f"{name}.png", DOCS / "pictures" / f"{name}.png")


def fill(page: Path, tables: dict[str, list[str]]) -> None:
    text = page.read_text()
    for name, lines in tables.items():
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        new = "\n".join([begin, *lines, end])
        text = re.sub(f"{begin}.*?{end}", lambda _, new=new: new, text, flags=re.S)
    write_whole(page, text)


def small_picture(source: Path, target: Path) -> None:
    from PIL import Image

    picture = Image.open(source).convert("RGB")
    picture = picture.resize((WIDTH, round(WIDTH * picture.height / picture.width)), Image.Resampling.LANCZOS)
    buffer = io.BytesIO()
    picture.quantize(128).save(buffer, format="png", optimize=True)
    write_whole(target, buffer.getvalue())


# Verdicts -----------------------------------------------------------------------------------------------------------


def verdicts(found: dict[str, Any]) -> list[Row]:
    """Of each claim on the future work, with the figures that it follows from."""
    return [
        passive(found["control-passivity"]["injected_share_of_U0"], found["control-law"]["injected_share"]),
        profile(found["control-law"]["injected_share"]),
        comes_to_rest(found["control-pushes"]),
        late(found["control-law"]["rule"], found["control-rate"], found["control-passivity"]["injected_share_of_U0"]),
        singular(found["control-stretch"]["stretch"]),
        nearest(found["control-stretch"]["forbidden"]),
        undisturbed(found["control-passivity"]["price"]),
        touching(found["control-contact"]),
        human(found["control-human"]),
        walked(found["control-walking"]),
        theorem(found["control-walking"]),
        tracked(found["control-reaching"]),
    ]


def percent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if share > 0.0 else "0 %"


def passive(shares: dict[str, Any], law: dict[str, Any]) -> Row:
    own, published, other = (
        shares[f"{name}, 4 kHz"]["worst"] for name in ("tanh, law A", "published, law A", "tanh, law B")
    )
    return Row(
        "The Fractal Impedance Controller is passive",
        CORRECTED if own < 0.01 < published else FAILS,
        f"Energy injected at 4 kHz on the arm, of that at the start: {percent(own)} with a tanh profile and law A, "
        f"{percent(other)} with law B. The published profile and law A inject {percent(published)}; the law is passive "
        "where force over distance does not grow",
        COMMAND,
    )


def profile(law: dict[str, Any]) -> Row:
    tip, elbow = law["published, tip"]["A"], law["published, elbow"]["A"]
    return Row(
        "Stability is independent of the force profile",
        FAILS if tip > 0.01 else HOLDS,
        f"Law A as printed returns up to {percent(tip)} more than its profile took with the published gains of the "
        "tip, "
        f"{percent(elbow)} with those of the elbow; law B {percent(law['tanh']['B'])} with a tanh. No injection: "
        "tanh with "
        "law A, the published profile with law B",
        COMMAND,
    )


def comes_to_rest(pushes: dict[str, Any]) -> Row:
    own, bare, radial = (pushes[name] for name in ("per_axis, damping 0.5", "per_axis, damping 0", "radial, damping 0"))
    return Row(
        "Asymptotically stable, without any damping",
        CORRECTED if bare["back"] == bare["pushes"] else FAILS,
        f"Axis by axis {bare['back']} of {bare['pushes']} pushes of 30 N for 0.3 s are back to 1 mm and 0.5 degrees "
        "within "
        f"2 s without joint damping, and {own['back']} of {own['pushes']} with 0.5 N m s/rad. The form by distance and "
        f"direction is a central force, which keeps the angular momentum: {radial['back']} of {radial['pushes']} "
        "without "
        f"damping, {1e3 * radial['final_tip_error_m']['median']:.2g} mm off in the median",
        COMMAND,
    )


def late(rule: dict[str, Any], rate: dict[str, Any], shares: dict[str, Any]) -> Row:
    own, linear = rate["per_axis"], rate["linear"]
    delayed = shares["tanh, law A, 4 kHz, 5 ms late"]["worst"]
    return Row(
        "Robust to low rates and to delays",
        CORRECTED if rule["at_rest_within"] == rule["cases_within"] else FAILS,
        f"One axis: at rest in {rule['at_rest_within']} of {rule['cases_within']} cases with w (T/2 + delay) <= 0.3, "
        f"w^2 = 2 K/m, beyond it a limit cycle of {rule['largest_way_m']:.2g} m at most up to 50 ms. On the arm w is "
        f"{rate['w_rad_s']:.0f} rad/s, that of the light wrist: 5 ms of delay inject {delayed:.0f} times the energy "
        "at the "
        f"start. At rest in {own['at_rest']} of {len(rate['rate_Hz']) * len(rate['delay_s'])} pairs of rate and delay, "
        f"springs and dampers in {linear['at_rest']}, joint impedance in {rate['joint']['at_rest']}",
        COMMAND,
    )


def singular(stretch: dict[str, Any]) -> Row:
    own, plain, damped = (stretch[name] for name in ("per_axis", "operational_pinv", "operational"))
    return Row(
        "Robust at singular configurations",
        HOLDS if own["below_3_rad_s"] == own["seeds"] and own["flips"] == 0 else CORRECTED,
        f"Through the straight elbow, beyond the reach and back: {own['below_3_rad_s']} of {own['seeds']} below 3 "
        "rad/s "
        f"(fastest {own['largest_joint_speed_rad_s']['worst']:.2g}), {own['flips']} flips, tip within "
        f"{1e3 * own['tip_error_at_home_m']['worst']:.2g} mm at home. Operational space: "
        f"{plain['largest_joint_speed_rad_s']['worst']:.2g} rad/s and {plain['largest_torque_N_m']:.3g} N m asked "
        "for with "
        f"the plain inverse, {damped['largest_joint_speed_rad_s']['worst']:.2g} rad/s and "
        f"{damped['largest_torque_N_m']:.3g} N m with the damped one",
        COMMAND,
    )


def nearest(forbidden: dict[str, Any]) -> Row:
    alone, soft, every = (forbidden[name] for name in ("tip_alone", "tip_and_repelling_limits", "all_ports"))
    return Row(
        "Out of reach or limits, the tip goes to the least distance",
        HOLDS if alone["within_1_mm"] == forbidden["targets"] else CORRECTED if alone["within_1_mm"] else FAILS,
        f"With a port on the tip alone {alone['within_1_mm']} of {forbidden['targets']} targets within 1 mm of the "
        "least "
        f"distance that SciPy finds, {1e3 * alone['worst_farther_m']:.2g} mm at worst; with repelling limits "
        f"{1e3 * soft['median_farther_m']:.2g} mm farther in the median, with turn and elbow too "
        f"{1e3 * every['median_farther_m']:.2g} mm: superposition is a compromise",
        COMMAND,
    )


def undisturbed(price: dict[str, Any]) -> Row:
    rows = {row["elbow_N_m"]: row for row in price["superposed"]}
    projected = price["operational_space_largest_tip_error_in_a_jump_m"]
    moving, still = rows[1000.0]["largest_tip_error_in_a_jump_m"], rows[1000.0]["misplaced_tip_error_m"]
    return Row(
        "The elbow is controlled without disturbing the tip",
        FAILS if moving > 1e-3 else HOLDS,
        f"While the arm angle jumps by 0.5 rad the tip is {1e3 * moving:.2g} mm off with an elbow of 1,000 N/m, and "
        f"{1e3 * projected:.2g} mm in the null space of operational space. At rest an elbow's target off its circle "
        "costs "
        f"{1e3 * still:.2g} mm at 1,000 N/m and {1e3 * rows[3000.0]['misplaced_tip_error_m']:.2g} mm at 3,000",
        COMMAND,
    )


def touching(contact: dict[str, Any]) -> Row:
    own, space = contact["wall"]["per_axis"], contact["wall"]["operational"]
    sags = {kind: contact["payload"][kind]["2 kg"]["sag_m"] for kind in ("per_axis", "operational", "joint")}
    return Row(
        "Safe in contact and with unknown loads",
        HOLDS if own["change_while_lasting_N"] < 1.0 else CORRECTED,
        f"Target 50 mm behind a wall: peak {own['peak_N']:.0f} N, then {own['lasting_N']:.0f} N within "
        f"{own['change_while_lasting_N']:.2g} N (operational space: {space['peak_N']:.0f} and "
        f"{space['lasting_N']:.0f} N). "
        f"2 kg that no controller knows lower the tip by {1e3 * sags['per_axis']:.0f} mm; operational space "
        f"{1e3 * sags['operational']:.0f} mm, joint impedance {1e3 * sags['joint']:.0f} mm",
        COMMAND,
    )


def human(found: dict[str, Any]) -> Row:
    bare, planned = found["plans"]["none"], found["plans"]["minimum_jerk"]
    spread, jerk = found["arm_angle_spread_deg"], planned["R2_with_minimum_jerk"]
    return Row(
        "Human-like movements",
        CORRECTED
        if planned["R2_with_minimum_jerk"]["median"] > 0.9 > bare["R2_with_minimum_jerk"]["median"]
        else FAILS,
        f"Not by the law itself: told at once, {bare['with_one_speed_peak']} of 100 movements have one speed peak, "
        "R^2 with "
        f"minimum jerk {bare['R2_with_minimum_jerk']['median']:.2f}. Following a plan of minimum jerk: "
        f"{planned['with_one_speed_peak']} of 100, R^2 {jerk['median']:.2f}, "
        f"{100.0 * planned['off_the_line']['median']:.1f} % off the line; a harmonic itself has "
        f"{found['R2_of_the_harmonic_itself']:.3f}. The arm angle at one target spreads by {spread['with_elbow']:.2g} "
        f"degrees with a port on the elbow, by {spread['without_elbow']:.2g} without",
        COMMAND,
    )


def walked(found: dict[str, Any]) -> Row:
    toe = found["toe_error_m"]
    return Row(
        "The walking leg, in dynamics",
        HOLDS if toe["largest"] < 0.02 else CORRECTED,
        f"One step a second through the straight knee: toes {1e3 * toe['rms']:.2g} mm off (rms), "
        f"{1e3 * toe['largest']:.2g} mm at most, joints up to {found['largest_joint_speed_rad_s']:.2g} rad/s",
        COMMAND,
    )


def theorem(found: dict[str, Any]) -> Row:
    shares = found["null_space_share_of_power"]
    own, other = shares["0 deg"], shares["90 deg"]
    return Row(
        "Theorem 1 in dynamics: no power in the null space along the optimal posture",
        FAILS if own["median"] > 0.01 else HOLDS,
        f"Share of the ports' power in the null space of the hand's velocity, medians of {found['tasks']} tasks: "
        f"{100.0 * own['median']:.0f} % along the geometrical posture, {100.0 * other['median']:.0f} % with the elbow "
        f"90 degrees beside it; least along the geometrical one in {found['geometrical_is_least_in']} of "
        f"{found['tasks']}",
        COMMAND,
    )


def tracked(reaching: dict[str, Any]) -> Row:
    own, linear, space = (reaching[kind] for kind in ("per_axis", "linear", "operational"))
    return Row(
        "In free space no worse than control with dampers",
        FAILS if own["arrival_s"]["median"] > 1.1 * space["arrival_s"]["median"] else HOLDS,
        f"Within 1 mm of targets 120 mm away for good after {own['arrival_s']['median']:.2f} s and "
        f"{100.0 * own['off_the_line']['median']:.1f} % off the line; springs and dampers "
        f"{linear['arrival_s']['median']:.2f} s "
        f"and {100.0 * linear['off_the_line']['median']:.1f} %, operational space {space['arrival_s']['median']:.2f} "
        "s and "
        f"{100.0 * space['off_the_line']['median']:.1f} %: the baselines are better here",
        COMMAND,
    )


# Tables -------------------------------------------------------------------------------------------------------------


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
                f"{1e3 * row['largest_tip_error_m']['median']:.0f} | {1e3 * off['median']:.2g}, at worst "
                f"{1e3 * off['worst']:.2g} | {row['largest_joint_speed_rad_s']['worst']:.2g} |"
            )
    return lines


def stretch_table(found: dict[str, Any]) -> list[str]:
    lines = [
        "| controller | seeds | below 3 rad/s | fastest joint (rad/s) | flips | largest torque asked for (N m) "
        "| tip at home (mm) |",
        "|---|--:|--:|--:|--:|--:|--:|",
    ]
    for kind, row in found.items():
        lines.append(
            f"| {NAMES[kind]} | {row['seeds']} | {row['below_3_rad_s']} | "
            f"{row['largest_joint_speed_rad_s']['worst']:.2g} | {row['flips']} | {row['largest_torque_N_m']:.3g} | "
            f"{1e3 * row['tip_error_at_home_m']['worst']:.2g} |"
        )
    return lines


def contact_table(found: dict[str, Any]) -> list[str]:
    lines = [
        "| controller | wall: peak (N) | then (N) | peg: peak (N) | then (N) | sag under 0.5, 1, 2, 3 kg (mm) |",
        "|---|--:|--:|--:|--:|---|",
    ]
    for kind, wall in found["wall"].items():
        peg = found["peg"][kind]
        sags = ", ".join(f"{1e3 * row['sag_m']:.0f}" for row in found["payload"][kind].values())
        lines.append(
            f"| {NAMES[kind]} | {wall['peak_N']:.0f} | {wall['lasting_N']:.0f} | {peg['peak_N']:.0f} | "
            f"{peg['lasting_N']:.0f} | {sags} |"
        )
    return lines


def reaching_table(found: dict[str, Any]) -> list[str]:
    lines = [
        "| controller | within 1 mm for good (s) | off the line (%) | speed peaks | tip after 2 s (mm) | turn (deg) |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for kind, row in found.items():
        lines.append(
            f"| {NAMES[kind]} | {row['arrival_s']['median']:.2f} | {100.0 * row['off_the_line']['median']:.1f} | "
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


if __name__ == "__main__":
    main()
