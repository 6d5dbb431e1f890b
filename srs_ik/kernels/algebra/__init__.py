"""Numbers that know no arm: vectors, small systems, roots, minima, eight floats at once."""
