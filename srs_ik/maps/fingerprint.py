"""One digest of all that answers depend on: of an arm, or of an arm in a scene."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.collision.forms import Form
from srs_ik.collision.scenes.scene import check_scene
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene


def fingerprint(arm: Arm, scene: Scene | None = None) -> str:
    """SHA-256 of all that answers depend on.

    Of the arm: axes, centres, tip with its tool, limits, reference of the arm angle. In a scene, of this too: bodies of
    the arm and which of them are watched, objects and where they are, margin, whether real shapes count.

    Raises:
        InvalidScene: this is no scene, or an object has the name of a body.
        NoBodies: with a scene, no shapes of the arm are at hand.
    """
    limb = arm.limb
    figures = (limb.axes, limb.points, limb.T_base_tip_zero, arm.lower, arm.upper, limb.reference)
    # In whole picometres and picoradians: the last digits differ between machines.
    whole = [[None if not math.isfinite(x) else round(x * 1e12) for x in np.ravel(each).tolist()] for each in figures]
    digest = hashlib.sha256(json.dumps(whole).encode())
    if scene is not None:
        check_scene(scene)
        for part in _of_scene(arm, scene):
            digest.update(part)
    return digest.hexdigest()


def _of_scene(arm: Arm, scene: Scene) -> Iterator[bytes]:
    yield f"{scene.exact} {scene.margin!r}".encode()
    yield _whole(arm.joint_frames(np.zeros(7)))
    for body in arm.bodies:
        yield repr((body.name, body.joint)).encode() + _whole(body.spheres)
        yield from _of_forms(body.forms)
    for thing in scene:
        yield repr((thing.name, thing.kinds, sorted(thing.replaces))).encode()
        yield from map(_whole, (thing.T, *thing.rows))
        yield from _of_forms((*thing.forms, *(form for _, forms in thing.parts for form in forms)))
    watched = arm.tables(scene)
    yield repr([(watched.names[a], watched.names[b]) for a, b in watched.pairs]).encode()
    yield repr([(watched.names[r.first], watched.names[r.second], r.joint) for r in watched.ranges]).encode()


def _of_forms(forms: Iterable[Form]) -> Iterator[bytes]:
    for form in forms:
        yield repr((form.kind, form.size)).encode() + _whole(form.T)
        if form.vertices is not None and form.faces is not None:
            yield _whole(form.vertices) + form.faces.astype("<i8").tobytes()


def _whole(values: Array) -> bytes:
    """Figures in whole nanometres: the last digits differ between machines."""
    return np.rint(np.clip(values, -1e9, 1e9) * 1e9).astype("<i8").tobytes()
