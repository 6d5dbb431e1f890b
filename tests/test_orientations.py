"""The grid of orientations: directions against astropy-healpix, and rotations against their own cells."""

import numpy as np
import pytest
from oracles import random_rotation

import srs_ik
from srs_ik.maps.orientations import Orientations, directions, orientations_of, pixels


@pytest.mark.slow
@pytest.mark.parametrize("nside", [1, 2, 4, 8, 64])
def test_directions_are_those_of_healpix(nside):
    healpix = pytest.importorskip("astropy_healpix")
    reference = healpix.HEALPix(nside=nside, order="ring")
    longitude, latitude = reference.healpix_to_lonlat(np.arange(12 * nside**2))
    z, phi = directions(nside)
    np.testing.assert_allclose(z, np.sin(latitude.to_value("rad")), atol=1e-14)
    off = (phi - longitude.to_value("rad") + np.pi) % (2.0 * np.pi) - np.pi
    np.testing.assert_allclose(off, 0.0, atol=1e-13)


@pytest.mark.parametrize("nside", [1, 2, 8, 64])
def test_pixels_are_those_of_healpix(nside):
    healpix = pytest.importorskip("astropy_healpix")
    units = pytest.importorskip("astropy.units")
    vectors = np.random.default_rng(28).normal(size=(20_000, 3))
    vectors /= np.linalg.norm(vectors, axis=1)[:, None]
    longitude, latitude = np.arctan2(vectors[:, 1], vectors[:, 0]), np.arcsin(vectors[:, 2])
    expected = healpix.lonlat_to_healpix(longitude * units.rad, latitude * units.rad, nside, order="ring")
    np.testing.assert_array_equal(pixels(nside, vectors), expected)


@pytest.mark.parametrize("count", [72, 576, 2304, 4608])
def test_every_rotation_lies_in_its_own_cell(count):
    grid = orientations_of(count)
    assert len(grid) == count
    R = grid.matrices()
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (count, 1, 1)), atol=1e-14)
    np.testing.assert_array_equal(grid.index(R), np.arange(count))


def test_any_rotation_is_near_the_centre_of_its_cell():
    grid, rng = orientations_of(4608), np.random.default_rng(29)
    R = np.array([random_rotation(rng) for _ in range(3000)])
    centre = grid.matrices()[grid.index(R)]
    off = np.arccos(np.clip((np.trace(R.transpose(0, 2, 1) @ centre, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
    assert off.max() < grid.spacing + np.pi / grid.rolls
    # Even: no rotation of the grid has more than a few times its share of random ones.
    counts = np.bincount(Orientations(1, 6).index(R), minlength=72)
    assert counts.min() / counts.mean() > 0.4
    assert counts.max() / counts.mean() < 2.0


@pytest.mark.parametrize("count", [0, 13, -12, 12.5, "many", 12 * 10**6])
def test_other_numbers_are_refused(count):
    with pytest.raises(srs_ik.InvalidMap, match="12 x 4\\^k x rolls"):
        orientations_of(count)
