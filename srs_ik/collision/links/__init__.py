"""The links of an arm: spheres that cover them, real shapes, and which pairs are watched."""
