"""MuJoCo as the plant of torque controllers (extra 'sim'): the same robot file, walls, pegs, boxes, pushes, records."""

from srs_ik.sim.plant import Plant
from srs_ik.sim.record import Record
from srs_ik.sim.simulate import Push, simulate
from srs_ik.sim.world import Box, Payload, Peg, Wall, World

__all__ = ["Box", "Payload", "Peg", "Plant", "Push", "Record", "Wall", "World", "simulate"]
