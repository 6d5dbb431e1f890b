"""What takes seconds to find out about the bodies of the built-in arms, written into the package.

python tests/built_in_bodies.py        # after a change of these arms, or of how spheres and ranges are found
"""

from __future__ import annotations

import io
import os

import numpy as np

import srs_ik
from srs_ik.collision.links import store
from srs_ik.system.writing import write_whole

ARMS = ("iiwa14", "gen3", "human_arm")


def find() -> dict[str, np.ndarray]:
    """All that the arms ask, by its key."""
    for name in ARMS:
        srs_ik.load(name).tables(srs_ik.Scene())
    return dict(store._memory)


def main() -> None:
    """Find everything anew, and write it."""
    os.environ["SRS_IK_CACHE"] = ""
    store._built_in.cache_clear()
    store.BUILT_IN.unlink(missing_ok=True)
    content = io.BytesIO()
    np.savez_compressed(content, **find())
    write_whole(store.BUILT_IN, content.getvalue())


if __name__ == "__main__":
    main()
