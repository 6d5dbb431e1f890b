"""Kernels compiled ahead of time, when a wheel is built: from the table of entries to machine code and its C glue.

`signatures` reads the table, `frontend` has Numba translate the kernels (`passes`, `quick`, `lean` and `borrow` take
out of that what kernels have no use for), `units` divides what comes of it, `backend` has LLVM write object code for
each kind of processor, `glue` writes the C around it, `linking` compiles and links that, `build` does all of it in the
processes of `forks`, and `hook` is where Hatchling calls it. None of this is needed to run what it makes.
"""
