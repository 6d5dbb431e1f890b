"""Named columns of every array that travels between Python and kernels, and between kernels."""
