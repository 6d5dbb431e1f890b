"""A look at an arm: in Meshcat, in a file, or on a page with sliders."""

from srs_ik.preview.live.following import FollowingPreview
from srs_ik.preview.live.interactive import InteractivePreview
from srs_ik.preview.reach import show_map, show_yaw_arcs
from srs_ik.preview.view import Preview

__all__ = ["FollowingPreview", "InteractivePreview", "Preview", "show_map", "show_yaw_arcs"]
