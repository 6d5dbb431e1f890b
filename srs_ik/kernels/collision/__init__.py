"""Which arm angles bodies forbid: two spheres, one still and one turning about the line S-W, forbid one arc."""
