"""How much of a robot a preview reads and draws. What is beyond is left out and said, in `Preview.missing`.

A robot file comes from anywhere, and a few bytes of it can ask for gigabytes: a mesh that is named a thousand times, a
node that holds two of the next one, a file that is all holes. The bounds keep what is read below a few hundred
megabytes and a minute, and what is drawn to what a browser can turn.
"""

MESH_BYTES = 32 * 2**20
"""One file. The largest of the 2,331 meshes of example-robot-data has 27.4 MiB (the trunk of a Go1)."""

ALL_BYTES = 256 * 2**20
"""All files of a robot together, each counted once however often it is drawn."""

PIECES = 5_000
"""Pieces in one mesh file, and shapes of a robot: each is an object of its own to the browser."""

TRIANGLES = 1_000_000
"""All that is drawn of a robot: 70 MB for the browser, and some 100 MB in a saved page."""

EXTENT = 1e3
"""Metres from the origin of a link to any point of its shapes: no robot is as large."""
