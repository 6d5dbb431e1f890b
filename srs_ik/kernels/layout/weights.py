"""What kernels know of the masses of an arm."""

MASSES = 0  # 7
MOMENTS = 7  # 7 x 3
GRAVITY = 28  # 3
SCALES = 31  # 7
WEIGHTS = 38
