"""The source paper: its numerical optimisation as printed, and its experiments."""

from srs_ik.paper.experiments import EXPERIMENTS
from srs_ik.paper.optimum import PrintedOptimum, printed_optimum

__all__ = ["EXPERIMENTS", "PrintedOptimum", "printed_optimum"]
