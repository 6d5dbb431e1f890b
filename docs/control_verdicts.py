"""The verdicts on torque control in docs/what_holds.md, each from the figures that it follows from."""

from __future__ import annotations

from typing import Any

from what_holds_rows import CORRECTED, FAILS, HOLDS, Row

COMMAND = "srs-ik reproduce control --out DIR"


def verdicts(found: dict[str, Any]) -> list[Row]:
    """Of each claim on the future work, with the figures that it follows from."""
    return [
        passive(found["control-passivity"]["injected_share_of_U0"]),
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
    if share <= 0.0:
        return "0 %"
    return f"{100.0 * share:.0f} %" if share >= 1.0 else f"{100.0 * share:.2g} %"


def passive(shares: dict[str, Any]) -> Row:
    names = ("tanh, law A", "tanh, law A, per axis", "published, law A", "tanh, law B")
    radial, axes, published, other = (shares[f"{name}, 4 kHz"]["worst"] for name in names)
    own = max(radial, axes)
    return Row(
        "The Fractal Impedance Controller is passive",
        CORRECTED if own < 0.01 < published else FAILS,
        f"Energy injected at 4 kHz on the arm, of that at the start: at most {percent(own)} with a tanh profile and "
        f"law A, in both forms, {percent(other)} with law B. The published profile and law A inject "
        f"{percent(published)}; the law is passive where force over distance does not grow",
        COMMAND,
    )


def profile(law: dict[str, Any]) -> Row:
    hardware, simulated = (
        [law[f"{kind}, {place}"]["A"] for place in ("tip", "elbow")] for kind in ("published", "published simulation")
    )
    return Row(
        "Stability is independent of the force profile",
        FAILS if hardware[0] > 0.01 else HOLDS,
        "Law A as printed returns more than its profile took: with the published gains of the hardware up to "
        f"{percent(hardware[0])} at the tip and {percent(hardware[1])} at the elbow, with those of the simulation "
        f"{percent(simulated[0])} and {percent(simulated[1])}; law B {percent(law['tanh']['B'])} with a tanh. No "
        "injection: tanh with law A, the published profile with law B",
        COMMAND,
    )


def comes_to_rest(pushes: dict[str, Any]) -> Row:
    bare = [pushes[f"{kind}, damping 0"] for kind in ("per_axis", "radial")]
    own = [pushes[f"{kind}, damping 0.5"] for kind in ("per_axis", "radial")]
    spring = pushes["spring, damping 0"]
    counts = [f"{row['back']} of {row['pushes']}" for row in (*bare, *own)]
    return Row(
        "Asymptotically stable, without any damping",
        HOLDS if all(row["back"] == row["pushes"] for row in (*bare, *own)) else CORRECTED,
        "After pushes of 30 N for 0.3 s back to 1 mm and 0.5 degrees within 2 s, without joint damping: axis by axis "
        f"{counts[0]}, radial {counts[1]}; with 0.5 N m s/rad: {counts[2]} and {counts[3]}. The radial form has to "
        "choose its axes at each peak: a force towards the target alone keeps the angular momentum. Bare springs: "
        f"{spring['back']} of {spring['pushes']}",
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
    reach, far, fast = (stretch[name] for name in ("to the reach, 2 s", "beyond it, 4 s", "beyond it, 2 s"))
    own = [rows[kind] for rows in (reach, far) for kind in ("per_axis", "radial")] + [fast["braked"]]
    plain, damped, linear = (fast[name] for name in ("operational_pinv", "operational", "linear"))
    worst = {name: row["per_axis"]["largest_joint_speed_rad_s"]["worst"] for name, row in stretch.items()}
    braked = fast["braked"]
    return Row(
        "Robust at singular configurations",
        HOLDS if all(row["below_3_rad_s"] == row["seeds"] and not row["flips"] for row in own) else CORRECTED,
        "To the straight elbow and back, 2 s each way: "
        f"{reach['per_axis']['below_3_rad_s']} of {reach['per_axis']['seeds']} below 3 rad/s (fastest "
        f"{worst['to the reach, 2 s']:.2g}), no flip. To 1.05 of the reach: "
        f"{far['per_axis']['below_3_rad_s']} of {far['per_axis']['seeds']} in 4 s ({worst['beyond it, 4 s']:.2g} "
        f"rad/s), {fast['per_axis']['below_3_rad_s']} in 2 s ({worst['beyond it, 2 s']:.2g}), and with brakes at the "
        f"arm's own speeds {braked['below_3_rad_s']} of {braked['seeds']} "
        f"({braked['largest_joint_speed_rad_s']['worst']:.2g}). There, operational space: "
        f"{plain['largest_joint_speed_rad_s']['worst']:.2g} rad/s and {plain['largest_torque_N_m']:,.0f} N m asked for "
        f"with the plain inverse, {damped['largest_joint_speed_rad_s']['worst']:.2g} rad/s and "
        f"{damped['largest_torque_N_m']:,.0f} N m with the damped one. Springs and dampers stay at "
        f"{linear['largest_joint_speed_rad_s']['worst']:.2g} rad/s: it is the transposed Jacobian, not the law",
        COMMAND,
    )


def nearest(forbidden: dict[str, Any]) -> Row:
    alone, soft, every = (forbidden[name] for name in ("tip_alone", "tip_and_repelling_limits", "all_ports"))
    axes = forbidden["tip_alone_per_axis"]
    return Row(
        "Out of reach or limits, the tip goes to the least distance",
        CORRECTED if alone["within_2_mm"] else FAILS,
        f"With a radial port on the tip alone {alone['within_2_mm']} of {forbidden['targets']} targets within 2 mm of "
        f"the least distance that SciPy finds. Axis by axis {axes['within_2_mm']}, "
        f"{1e3 * axes['median_farther_m']:.2g} mm in the median, as another sum is least there; with repelling limits "
        f"{1e3 * soft['median_farther_m']:.2g} mm, with turn and elbow too {1e3 * every['median_farther_m']:.0f} mm",
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
    own, linear, space = (contact["wall"][kind] for kind in ("per_axis", "linear", "operational"))
    pegs = [contact["peg"][kind] for kind in ("per_axis", "linear", "operational")]
    whirl = [contact["peg"][kind]["largest_joint_speed_rad_s"] for kind in ("per_axis", "braked", "linear")]
    sags = {kind: 1e3 * contact["payload"][kind]["2 kg"]["sag_m"] for kind in ("per_axis", "operational", "joint")}
    best = own["peak_N"] <= min(linear["peak_N"], space["peak_N"])
    return Row(
        "Safe in contact and with unknown loads",
        HOLDS if best else CORRECTED,
        f"Target 50 mm behind a wall: the lasting force is that of the profile, {own['lasting_N']:.0f} N within "
        f"{own['change_while_lasting_N']:.1g} N (springs and dampers {linear['lasting_N']:.0f}, operational space "
        f"{space['lasting_N']:.0f} N), but the impact is not softer: {own['peak_N']:.0f} N, and "
        f"{linear['peak_N']:.0f} and {space['peak_N']:.0f} N. A peg in the way of the forearm takes "
        f"{pegs[0]['peak_N']:,.0f} N and then {pegs[0]['lasting_N']:.0f}, where those take "
        f"{pegs[1]['peak_N']:,.0f} and {pegs[1]['lasting_N']:.0f}, {pegs[2]['peak_N']:,.0f} and "
        f"{pegs[2]['lasting_N']:.0f} N; but it makes the wrist whirl, by {whirl[0]:.2g} rad/s, {whirl[1]:.2g} with "
        f"brakes (springs and dampers {whirl[2]:.2g}). 2 kg that no controller knows lower the tip by "
        f"{sags['per_axis']:.0f} mm; operational space {sags['operational']:.0f} mm, "
        f"joint impedance {sags['joint']:.0f} mm",
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
        f"One step a second through the straight knee, without a flip; a target that moves is followed late: "
        f"toes {1e3 * toe['rms']:.2g} mm off (rms), "
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
        f"turned by 90 degrees; least along the geometrical one in {found['geometrical_is_least_in']} of "
        f"{found['tasks']}",
        COMMAND,
    )


def tracked(reaching: dict[str, Any]) -> Row:
    kinds = ("radial", "per_axis", "linear", "operational")
    when = [reaching[kind]["arrival_s"]["median"] for kind in kinds]
    off = [100.0 * reaching[kind]["off_the_line"]["median"] for kind in kinds]
    return Row(
        "In free space no worse than control with dampers",
        FAILS if min(when[:2]) > 1.1 * min(when[2:]) else HOLDS,
        f"Within 1 mm of targets 120 mm away for good after {when[0]:.2f} s and {off[0]:.1f} % off the line in the "
        f"radial form, {when[1]:.2f} s and {off[1]:.1f} % axis by axis; springs and dampers {when[2]:.2f} s and "
        f"{off[2]:.1f} %, operational space {when[3]:.2f} s and {off[3]:.1f} %: the baselines are better here",
        COMMAND,
    )
