"""The claims of docs/what_holds.md: each with its verdict, which follows from figures, and the figures in words."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import srs_ik
from srs_ik.paper.experiments.c_grasp import EXTENSIONS, GRASPS
from srs_ik.paper.experiments.ik_accuracy import ANGLES, LENGTHS, reached_tasks

ROOT = Path(__file__).resolve().parents[1]
COMMAND = "python benchmarks/claims.py"

HOLDS, CORRECTED, FAILS = "holds", "holds with a correction", "does not hold"


class Row(NamedTuple):
    """One claim."""

    claim: str
    verdict: str
    found: str
    command: str


def verdict(*conditions: bool, well: str = HOLDS) -> str:
    """What is said of a claim if all conditions are met; else that it does not hold."""
    return well if all(conditions) else FAILS


def small(figure: float) -> str:
    """A rounding error in few digits."""
    return f"{figure:.0e}" if figure > 0.0 else "0"


# The experiments ----------------------------------------------------------------------------------------------------


def rows_of_experiments(figures: dict[str, Any], claims: dict[str, Any], limb: srs_ik.Arm) -> list[Row]:
    return [
        accurate(figures["ik-accuracy"], limb),
        robust(figures["arm-sphere"], claims["robustness"]),
        fast(figures),
        two_arms(figures["lr-arms"]),
        aligned(figures["lr-arms"], figures["arm-sphere"]),
        *grasps(figures["c-grasp"]),
        singular(figures["c-grasp"]["elbow_straight"]),
        walked(figures["walking"]["snapshots"]),
    ]


def accurate(figures: dict[str, Any], limb: srs_ik.Arm) -> Row:
    sides = [figures["left"], figures["right"]]
    errors = [side[name] for side in sides for name in (*LENGTHS, *ANGLES)]
    worst, mean = max(e["worst"] for e in errors), max(e["mean"] for e in errors)
    printed = max(side[f"printed_{name}"]["worst"] for side in sides for name in ANGLES)
    turned, of = printed_signs(limb)
    return Row(
        "The inverse kinematics is accurate: all five errors are negligible",
        verdict(worst < 1e-12, well=CORRECTED),
        f"Largest mean {mean:.1e}, worst {worst:.1e} (m, rad) in {2 * sides[0]['tasks']:,} tasks, with errata 3 to 6. "
        f"With q_5 as printed {turned} of {of:,} hands are turned about, *phi* reversed; by arc cosine as printed, "
        f"angles end at {printed:.1e} rad (erratum 8)",
        "srs-ik reproduce ik-accuracy --out DIR",
    )


def printed_signs(limb: srs_ik.Arm) -> tuple[int, int]:
    """How many tasks end with phi reversed where the sign of q_5 is left as printed, and of how many."""
    paper = runpy.run_path(str(ROOT / "tests" / "paper_posture.py"))
    x_d, v, f = reached_tasks(limb, 1000)
    turned = 0
    for x, g, phi in zip(x_d, v, f, strict=True):
        x_e, x_w = paper["geometric_posture"](x, g, phi, g)
        R = paper["forward"](paper["inverse"](x_e, x_w, g, phi, sign_corrected=False))[3]
        turned += bool(R[:, 2] @ phi < 0.0)
    return turned, len(x_d)


def robust(figures: dict[str, Any], degenerate: dict[str, Any]) -> Row:
    kinds = [figures[grasp][side] for grasp in ("grasp", "no_grasp") for side in ("left", "right")]
    bad = sum(kind["not_finite"] + kind["elbow_on_the_other_side"] for kind in kinds)
    bad += sum(side["not_finite"] for side in figures["joint_angles"].values())
    many = degenerate["postures_not_finite"] + degenerate["joint_angles_not_finite"]
    lengths = max(kind[name]["worst"] for kind in kinds for name in ("upper_arm_error_m", "forearm_error_m"))
    return Row(
        "Postures are robust: no error in 1,000 targets within 1.2 reaches",
        verdict(bad == 0, many == 0, lengths < 1e-12, well=CORRECTED),
        f"{bad} faults in {len(kinds)} x {kinds[0]['postures']:,} postures ({kinds[0]['reached']} reached with a "
        f"grasp, {kinds[2]['reached']} without), links as long as they are to {lengths:.1e} m. Of "
        f"{degenerate['postures']:,} more, half of them degenerate, {many} are not finite. The print is undefined in "
        "those, and needs errata 1, 9 and 10",
        "srs-ik reproduce arm-sphere --out DIR; python benchmarks/claims.py",
    )


def fast(figures: dict[str, Any]) -> Row:
    posture = figures["arm-sphere"]["microseconds_a_posture"]
    both = figures["ik-accuracy"]["microseconds_posture_and_joint_angles"]
    return Row(
        "A posture takes 30 us, posture and joint angles 78 us",
        verdict(posture["single"] < 30.0, both["single"] < 78.0),
        f"{posture['single']:.1f} us and {both['single']:.1f} us one at a time, {posture['batch']:.2f} us and "
        f"{both['batch']:.1f} us in a batch of 1,000; compiled, where the paper's figures are MATLAB's",
        "srs-ik reproduce arm-sphere ik-accuracy --out DIR",
    )


def two_arms(figures: dict[str, Any]) -> Row:
    kinds = [figures[grasp][side] for grasp in ("grasp", "no_grasp") for side in ("left", "right")]
    wrong = sum(kind["elbow_on_the_other_side"] + kind["postures"] - kind["reached"] for kind in kinds)
    apart = max(figures[grasp]["two_elbows_opposite_m"] for grasp in ("grasp", "no_grasp"))
    return Row(
        "Left and right arm, with a grasp and without, use the whole redundancy",
        verdict(wrong == 0, apart < 1e-12, well=CORRECTED),
        f"{wrong} of {len(kinds)} x {kinds[0]['postures']} postures on the wrong side or off the target; both elbows "
        f'lie opposite each other to {small(apart)} m. The condition on the sign has to be read with "or" (erratum 2)',
        "srs-ik reproduce lr-arms --out DIR",
    )


def aligned(lr_arms: dict[str, Any], sphere: dict[str, Any]) -> Row:
    kinds = [e[grasp][side] for e in (lr_arms, sphere) for grasp in ("grasp", "no_grasp") for side in ("left", "right")]
    gains = [kind["alignment_gained_by_a_sweep"] for kind in kinds]
    gain = max(g["worst"] for g in gains)
    return Row(
        "The shoulder aligns the elbow axis with n as well as can be",
        verdict(gain < 1e-12),
        f"None of 720 other elbows around the circle is better by more than {small(gain)} in "
        f"{sum(g['count'] for g in gains):,} postures",
        "srs-ik reproduce lr-arms arm-sphere --out DIR",
    )


def grasps(figures: dict[str, Any]) -> list[Row]:
    compared = figures["tasks_that_all_three_reach"]
    best, tasks = compared["lowest_C"], compared["tasks"]
    rows = {grasp: figures["by_extension"][grasp]["left"] for grasp in GRASPS}
    spans = [row["largest"] / row["least"] for row in rows["N"]]
    inner, outer = (spans[int(np.argmin(np.abs(EXTENSIONS - at)))] for at in (0.45, 0.95))
    pairs = [
        (f["least"], v["least"]) for f, v in zip(rows["F"], rows["V"], strict=True) if f["reached"] and v["reached"]
    ]
    higher = sum(f > v for f, v in pairs)
    C = figures["C"]
    product = C["V"]["left"] * np.roll(C["F"]["left"], -len(figures["theta_deg"]) // 4, axis=1)
    both = np.isfinite(product) & (C["V"]["left"] < 1e9)
    turned = float(np.abs(product[both] - 1.0).max())
    middle = (EXTENSIONS >= 0.35) & (EXTENSIONS <= 0.7)
    means = ", ".join(f"{grasp} {mean:.2f}" for grasp, mean in compared["geometric_mean"].items())
    inside, outside = lowest(C, middle), lowest(C, ~middle)
    command = "srs-ik reproduce c-grasp --out DIR"
    return [
        Row(
            "C is governed by how far the arm reaches out",
            verdict(outer > 10.0 * inner),
            f"Over 36 directions C spans a factor of {inner:.0f} at 0.45 reaches and of {outer:.0f} at 0.95 (N-grasp)",
            command,
        ),
        Row(
            "V-grasp reaches the lowest C",
            verdict(best["V"] > max(best["N"], best["F"])),
            f"Of {tasks} tasks that all three reach it is lowest in {best['V']}, N-grasp in {best['N']}, F-grasp in "
            f"{best['F']}; geometric means {means}",
            command,
        ),
        Row(
            "F-grasp is worst, and has the higher minima",
            verdict(compared["V_below_F"] > 0.5 * tasks, higher > 0.5 * len(pairs)),
            f"V-grasp has a lower C than F-grasp in {compared['V_below_F']} of {tasks} tasks; the minimum of "
            f"F-grasp is the higher one at {higher} of {len(pairs)} extensions. With the hand in the same direction, C "
            f"of the F-grasp is 1/C of the V-grasp, to {turned:.0e}: what one gains the other loses",
            command,
        ),
        Row(
            "N-grasp suits the middle of the reach, V-grasp contracted and extended arms",
            verdict(inside["N"] == max(inside.values()), outside["V"] == max(outside.values())),
            f"Lowest C of 0.35 to 0.7 reaches: {counted(inside)}; nearer and farther: {counted(outside)}",
            command,
        ),
    ]


def lowest(C: dict[str, Any], rows: np.ndarray) -> dict[str, int]:
    """Of the tasks at some extensions that all grasps reach, how many have their lowest C with each."""
    stack = np.stack([C[grasp]["left"][rows] for grasp in GRASPS])
    stack = stack[:, np.isfinite(stack).all(axis=0)]
    return {grasp: int(np.sum(stack.argmin(axis=0) == i)) for i, grasp in enumerate(GRASPS)}


def counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.items())


def singular(straight: dict[str, Any]) -> Row:
    least = {grasp: straight[grasp]["smallest_singular_value_of_Jp_m"] for grasp in GRASPS}
    C = {grasp: straight[grasp]["C"] for grasp in GRASPS}
    keeps = least["V"] > 1e-3 and max(least["N"], least["F"]) < 1e-9
    return Row(
        "V-grasp keeps manipulability at the singularity",
        verdict(keeps, well=HOLDS if C["V"] < min(C["N"], C["F"]) else CORRECTED),
        f"Elbow straight, force along the arm: smallest singular value of Jp {least['V']:.3f} m with V-grasp, "
        f"{small(least['N'])} with N- and {small(least['F'])} with F-grasp: the tip still moves in all "
        f"directions. Its C is the higher one, though: {C['V']:.3f} against {C['N']:.0e}; so aligned, the arm bears "
        "the force without any torque",
        "srs-ik reproduce c-grasp --out DIR",
    )


def walked(snapshots: list[dict[str, Any]]) -> Row:
    reached = sum(s["grasps"]["V"]["reached"] for s in snapshots)
    error = max(max(s["position_error_m"], s["orientation_error_rad"]) for s in snapshots)
    first = [min(GRASPS, key=lambda g, s=s: s["grasps"][g].get("C", np.inf)) for s in snapshots]
    return Row(
        "V-grasp is to be preferred in walking, where the leg is straight",
        verdict(reached == len(snapshots), error < 1e-12, first.count("V") > len(snapshots) / 2),
        f"All snapshots are solved ({reached} of {len(snapshots)}, to {error:.0e} m and rad), the straight ones too. "
        f"But with the toes at the same place C is lowest with V-grasp in {first.count('V')}, N-grasp in "
        f"{first.count('N')}, F-grasp in {first.count('F')} of them",
        "srs-ik reproduce walking --out DIR",
    )


# Other claims -------------------------------------------------------------------------------------------------------


def rows_of_claims(claims: dict[str, Any]) -> list[Row]:
    return [
        optimal_posture(claims["optimality"], claims["printed_optimisation"]),
        planar(claims["planar_arm"]),
        dual(claims["duality"]),
        inner(claims["polytope"]),
        theorem(claims["null_space"]),
    ]


def optimal_posture(figures: dict[str, Any], scipy: dict[str, Any]) -> Row:
    ratio, either = figures["random"]["C_over_best"], figures["random"]["C_of_the_better_side_over_best"]
    others = figures["random"]["share_of_other_elbows_that_are_better"]
    return Row(
        "The geometrical posture is the optimum (of C, or of the numerical optimisation)",
        verdict(ratio["most"] < 1.01),
        f"C over the optimum of its pose: median {ratio['median']:.2f}, 90th percentile {ratio['most']:.1f}, worst "
        f"{ratio['worst']:.0f}; {100 * others:.0f} % of other elbow positions are better. The better of left and right "
        f"arm: median {either['median']:.2f}, 90th percentile {either['most']:.1f}. Over the paper's own optimisation, "
        f"by SciPy from {scipy['starts']} starts: median {scipy['C_over_scipy']['median']:.2f} of "
        f"{scipy['C_over_scipy']['count']} tasks (erratum 11)",
        COMMAND,
    )


def planar(figures: dict[str, Any]) -> Row:
    plain, weighed = figures["relative_difference"], figures["with_the_axes_weighed"]
    least, most = figures["least_and_largest_weight_of_the_shoulder"]
    return Row(
        "In the task's plane the arm's manipulability is that of a planar arm with three links",
        verdict(weighed["worst"] < 1e-9, well=HOLDS if plain["worst"] < 1e-9 else CORRECTED),
        f"C differs by {100 * plain['median']:.1f} % in the median and {100 * plain['worst']:.0f} % at worst. It "
        f"agrees, to {weighed['worst']:.0e}, once each centre counts with the sum of squares of its axes along n, "
        f"which for the shoulder goes from {least:.2f} to {most:.2f}",
        COMMAND,
    )


def dual(figures: dict[str, Any]) -> Row:
    product = max(figures["product_of_eigenvalues_minus_1"], figures["product_of_semi_axes_minus_1"])
    return Row(
        "Force and velocity ellipsoid are dual: same axes, inverse eigenvalues, which scale them",
        verdict(product < 1e-9, figures["axes_apart"] < 1e-9, well=CORRECTED),
        f"Products of eigenvalues and of semi-axes are 1 to {product:.0e}. A semi-axis is one over the *root* of its "
        f"eigenvalue (to {figures['semi_axis_times_root_of_eigenvalue_minus_1']:.0e}), not the eigenvalue itself",
        COMMAND,
    )


def inner(figures: dict[str, Any]) -> Row:
    return Row(
        "An ellipsoid lies in the polytope, and meets it along its axes",
        verdict(figures["least"] > 1.0 - 1e-9, figures["worst"] < 1.0 + 1e-6),
        f"It lies inside. Along the axes the polytope of joint velocities within 1 reaches {figures['least']:.2f} to "
        f"{figures['worst']:.2f} times as far, in the median {figures['median']:.2f} times",
        COMMAND,
    )


def theorem(figures: dict[str, Any]) -> Row:
    share, power, still = (
        figures[name]
        for name in ("share_of_the_joint_velocity", "share_of_the_power", "share_of_gravity_torque_in_the_null_space")
    )
    zero = figures["largest_for_the_least_joint_velocity"]
    return Row(
        "Theorem 1: the optimal posture is the one without power in the null space",
        verdict(zero > 1e-9, share["most"] < 1e-9),
        f"With the least joint velocity for the task there is none in any posture ({zero:.0e} W for a torque of 1 N m "
        f"at 1 m/s), optimal or not: it chooses none. As the geometrical posture follows its target along v, "
        f"{100 * share['median']:.0f} % of the joint velocity is in the null space, and {100 * power['median']:.0f} % "
        f"of gravity's power (medians of {figures['tasks']}); nor is gravity at rest there: "
        f"{100 * still['median']:.0f} % of its torque is in the null space",
        COMMAND,
    )
