"""Hatchling, but for what it says of a wheel before it is built: whether that needs Numba shows only then.

Installers such as uv would ask for it, and leave Numba out. Without it they read the wheel itself, as pip does.
"""

from hatchling.build import (
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]
