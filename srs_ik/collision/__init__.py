"""Bodies and what they may hit: spheres that cover the links of an arm, pairs of bodies, and scenes."""
