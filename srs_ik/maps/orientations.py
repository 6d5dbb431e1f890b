"""An even grid of orientations: HEALPix directions of the tip's z axis, and rolls about each.

Directions: K. M. Gorski et al., HEALPix, ApJ 622, 2005, ring order. Rolls by Hopf's fibration: A. Yershova, S. Jain,
S. M. LaValle, J. C. Mitchell, Generating uniform incremental grids on SO(3), IJRR 29(7), 2010.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidMap, quoted
from srs_ik.system.arrays import Array

Indices = NDArray[np.int64]

TURN = 2.0 * math.pi
MOST = 600_000


@dataclass(frozen=True)
class Orientations:
    """12 nside^2 directions with as many rolls each; orientation k has direction k // rolls and roll k % rolls."""

    nside: int  # HEALPix resolution, a power of two
    rolls: int  # turns about each direction

    def __len__(self) -> int:
        return 12 * self.nside**2 * self.rolls

    @property
    def spacing(self) -> float:
        """Root of the solid angle of a direction, rad."""
        return math.sqrt(4.0 * math.pi / (12 * self.nside**2))

    def matrices(self) -> Array:
        """(n, 3, 3) rotations of the tip."""
        z, phi = directions(self.nside)
        roll = TURN * np.arange(self.rolls) / self.rolls
        theta, phi = np.repeat(np.arccos(z), self.rolls), np.repeat(phi, self.rolls)
        return _about_z(phi) @ _about_y(theta) @ _about_z(np.tile(roll, 12 * self.nside**2) - phi)

    def index(self, rotations: Array) -> Indices:
        """(N,) orientations in whose cells rotations (N, 3, 3) lie."""
        z_axis = rotations[:, :, 2]
        pixel = pixels(self.nside, z_axis)
        z, phi = directions(self.nside)
        z, phi = z[pixel], phi[pixel]
        # The roll that is left once the tip's z axis is brought to the pixel's centre the shortest way.
        centre = np.stack([np.sqrt(1.0 - z * z) * np.cos(phi), np.sqrt(1.0 - z * z) * np.sin(phi), z], axis=1)
        turned = _shortest(z_axis, centre) @ rotations
        rest = (_about_z(phi) @ _about_y(np.arccos(z))).transpose(0, 2, 1) @ turned
        roll = np.arctan2(rest[:, 1, 0], rest[:, 0, 0]) + phi
        k = np.rint(roll * self.rolls / TURN).astype(np.int64) % self.rolls
        found: Indices = pixel * self.rolls + k
        return found


def orientations_of(count: int) -> Orientations:
    """The grid of so many orientations, 12 x 4^k x rolls, whose directions and rolls are spaced most alike."""
    grids = [
        Orientations(2**k, count // (12 * 4**k))
        for k in range(10)
        if isinstance(count, int) and 0 < count <= MOST and count % (12 * 4**k) == 0
    ]
    if not grids:
        raise InvalidMap(
            f"a grid of orientations has 12 x 4^k x rolls of them, up to {MOST:,}; {quoted(count)} is none"
        )
    return min(grids, key=lambda grid: abs(math.log(TURN / grid.rolls / grid.spacing)))


def directions(nside: int) -> tuple[Array, Array]:
    """Height z and longitude, rad, of the centres of all HEALPix pixels in ring order."""
    n = nside
    pixel = np.arange(12 * n * n)
    cap = 2 * n * (n - 1)
    z, phi = np.empty(len(pixel)), np.empty(len(pixel))
    # The southern cap mirrors the northern one, read backwards.
    for part, p, sign in ((pixel < cap, pixel, 1.0), (pixel >= 12 * n * n - cap, 12 * n * n - 1 - pixel, -1.0)):
        p = p[part]
        ring = ((1.0 + np.sqrt(1.0 + 2.0 * p)) / 2.0).astype(np.int64)
        along = p - 2 * ring * (ring - 1)
        along = along if sign > 0.0 else 4 * ring - 1 - along
        z[part] = sign * (1.0 - ring**2 / (3.0 * n * n))
        phi[part] = (along + 0.5) * math.pi / (2.0 * ring)
    belt = (pixel >= cap) & (pixel < 12 * n * n - cap)
    ring, along = np.divmod(pixel[belt] - cap, 4 * n)
    z[belt] = 2.0 * (n - ring) / (3.0 * n)
    phi[belt] = (along + 0.5 * (1 - ring % 2)) * math.pi / (2.0 * n)
    return z, phi


def pixels(nside: int, vectors: Array) -> Indices:
    """(N,) HEALPix pixels, in ring order, in which unit vectors (N, 3) lie."""
    n = nside
    z = np.clip(vectors[:, 2], -1.0, 1.0)
    quarter = (np.arctan2(vectors[:, 1], vectors[:, 0]) % TURN) / (0.5 * math.pi) % 4.0
    # The belt about the equator: lines that rise and fall with longitude part its pixels.
    rising = np.floor(n * (0.5 + quarter - 0.75 * z)).astype(np.int64)
    falling = np.floor(n * (0.5 + quarter + 0.75 * z)).astype(np.int64)
    ring = n + 1 + rising - falling
    along = ((rising + falling - n + 2 - ring % 2) // 2) % (4 * n)
    belt = 2 * n * (n - 1) + (ring - 1) * 4 * n + along
    # The caps: the ring is counted from the pole.
    size = n * np.sqrt(3.0 * (1.0 - np.abs(z)))
    part = quarter % 1.0
    ring = (part * size).astype(np.int64) + ((1.0 - part) * size).astype(np.int64) + 1
    along = (quarter * ring).astype(np.int64) % (4 * ring)
    cap = np.where(z > 0.0, 2 * ring * (ring - 1), 12 * n * n - 2 * ring * (ring + 1)) + along
    return np.where(np.abs(z) <= 2.0 / 3.0, belt, cap)


def _about_z(angle: Array) -> Array:
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.stack([c, -s, o, s, c, o, o, o, i], axis=-1).reshape(-1, 3, 3)


def _about_y(angle: Array) -> Array:
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.stack([c, o, s, o, i, o, -s, o, c], axis=-1).reshape(-1, 3, 3)


def _shortest(a: Array, b: Array) -> Array:
    """(N, 3, 3) shortest rotations that take unit vectors a to b, which are less than half a turn apart."""
    v, c = np.cross(a, b), np.einsum("ni,ni->n", a, b)
    o = np.zeros_like(c)
    K = np.stack([o, -v[:, 2], v[:, 1], v[:, 2], o, -v[:, 0], -v[:, 1], v[:, 0], o], axis=1).reshape(-1, 3, 3)
    return np.eye(3) + K + K @ K / (1.0 + c)[:, None, None]
