"""Draws the pictures of docs/maps.md; their figures are in the text."""

import sys
import tempfile
import time
from pathlib import Path

import srs_ik
from srs_ik.maps import build_map
from srs_ik.plots import plot_map, plot_shell, plot_yaw_arcs
from srs_ik.robot import changes

HERE = Path(__file__).parent / "pictures"
STEP, ORIENTATIONS = 0.04, 576


def unlimited(arm):
    """The arm without joint limits."""
    free = {name: {"lower": -float("inf"), "upper": float("inf")} for name in arm.joint_names}
    return arm._again(changes.within_limits(arm._chain, free), arm.limb.reference, arm.hand)


def main(names):
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            arm = srs_ik.load(name)
            step, count = (0.05, 192) if arm.limb.kind == "near" else (STEP, ORIENTATIONS)
            begin = time.process_time()
            chart = build_map(arm, step, Path(folder, f"{name}.zarr"), orientations=count)
            took = time.process_time() - begin
            plot_map(chart, "yaw").savefig(HERE / f"map_{name}.png")
            free = build_map(unlimited(arm), step, Path(folder, f"{name}_free.zarr"), orientations=count)
            plot_shell(free, chart, share=0.1, labels=["without limits", name]).savefig(HERE / f"shell_{name}.png")
            share, without = (100.0 * each.mean("yaw").mean() for each in (chart, free))
            print(
                f"{name}: {chart.plan.cells} cells in {took:.1f} s of processor time, {share:.1f} % reached,", end=" "
            )
            print(f"{without:.1f} % without limits", flush=True)
        arm = srs_ik.load("human_arm")
        pose = arm.forward_kinematics(0.5 * (arm.lower + arm.upper) + 0.1)
        plot_yaw_arcs(arm, pose).savefig(HERE / "yaw_arcs.png")


if __name__ == "__main__":
    main(sys.argv[1:] or ["iiwa14", "human_arm", "gen3"])
