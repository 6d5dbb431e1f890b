"""Scalar Numba kernels: the geometry, written once, for the single call and for the batch.

Rules of this folder. Functions take and return floats, integers and tuples of floats; arrays appear only as the packed
limb `P` (read only, laid out in `layout`), as the pose matrices given by the caller, and as outputs that the caller
allocated. No allocation, no explicit signatures, nothing but `math`. Nothing here imports from the rest of the package.
"""
