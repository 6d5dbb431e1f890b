"""Capability maps: which poses an arm reaches and how well; and where to put its base."""

from srs_ik.maps.build import Estimate, build_map, estimate
from srs_ik.maps.export import cloud, to_numpy, to_reuleaux, to_vtk
from srs_ik.maps.live import measures_of, yaw_arcs
from srs_ik.maps.pairs import Compared, combine, compare
from srs_ik.maps.placement import Placement, RankedBase, base_placement
from srs_ik.maps.reader import Map, MapAnswer, Verified, open_map

__all__ = [
    "Compared",
    "Estimate",
    "Map",
    "MapAnswer",
    "Placement",
    "RankedBase",
    "Verified",
    "base_placement",
    "build_map",
    "cloud",
    "combine",
    "compare",
    "estimate",
    "measures_of",
    "open_map",
    "to_numpy",
    "to_reuleaux",
    "to_vtk",
    "yaw_arcs",
]
