"""Scalar Numba kernels: the geometry, written once, for the single call and for the batch.

Rules of this folder. Functions take and return floats, integers and tuples of floats. Arrays appear as the packed limb
`P` (read only, laid out in `layout.limb`), as what the caller gave, as outputs that the caller allocated, and as work
space that one call allocates for itself; no inner loop allocates. No explicit signatures, nothing but `math`. Nothing
here imports from the rest of the package but an error of `errors`, and the rest imports `entries` and `layout` alone.

Names of arguments, here and in all rooms: `P` a packed limb; `family` four of them; `place_` what all configurations of
a pose share; `R`, `p` rotation and position of the wanted tip pose; `psi` an arm angle, `t` the unit direction from
shoulder to wrist and `h0` that of arm angle zero; `q` seven joint angles; `branch` 0 to 7; `seeded`, `seed` whether
nearness to a seed is the goal, and that seed; `respect` whether joint limits count; `J` (6, 7) and `A` (16, 9) work
space of near limbs. Radians, metres, base frame.
"""
