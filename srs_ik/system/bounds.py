"""How much of a file is read: every bound on robot files, and its reason.

A file from elsewhere may be made to use up time and memory. Each bound lies well above what real robots need, and low
enough that a file at all of them at once is read in about a second and 300 MB.
"""

XML_BYTES = 8 * 2**20
"""Largest XML text, with all that it includes. Descriptions of whole humanoids have a few hundred kilobytes."""

XML_ELEMENTS = 200_000
"""Most elements of an XML text, skipped ones included; a humanoid with hands has a few thousand."""

XML_ATTRIBUTES = 1000
"""Most attributes of one element; the parser makes all of them at once, before any can be refused."""

XML_DEPTH = 1000
"""Deepest nesting of elements, which some parsers follow by recursion. Bodies of an MJCF file nest, links do not."""

XML_INCLUDES = 20
"""Most files that an MJCF file includes."""

CARD_BYTES = 2**16
"""Largest adapter; a full one has 3 KB."""

CARD_KEYS = 8
"""Most parts of a dotted key of an adapter, of which two are used. The parser's memory grows with their square."""

YAML_BYTES = 2**18
"""Largest YAML text: its parser takes some ten seconds for a megabyte. Larger scenes are for JSON."""

TREE_NODES = 2_000_000
"""Most values of a JSON or YAML file, each counted wherever an alias puts it; lines of aliases multiply them."""

OBJECTS = 10_000
"""Most objects of a scene file, each of which is asked about alone; clouds of points are one."""

CLOUD_BYTES = 2**28
"""Largest file of points: 2,000,000 of them as text."""

LINKS = 2000
"""Most links or bodies."""

CHAIN = 500
"""Longest chain of joints. Pinocchio reads a tree by recursion; far longer chains overflow the stack of a thread."""

FREEDOM = 200
"""Most degrees of freedom. Pinocchio's work space grows with their cube: 0.6 GB here, and 8 GB at 500."""

NAME = 1000
"""Longest name, characters."""

NUMBER = 400
"""Characters of one figure; the longest exact decimal form that programs write has 325."""

FARTHEST = 1e6
"""Largest component of an origin, metres, and where a limit lies out of reach, metres or rad.

Farther out, a position has no micrometres left in double precision.
"""

HEAVIEST = 1e9
"""Largest mass of a link, kg, and largest moment of inertia, kg m^2: sums of a few thousand are finite."""

FILES_BESIDE = 1000
"""Most files of a folder that are looked at for a name like that of a missing one."""

COMPARED = 100
"""Longest name that is compared with others for "did you mean"; the time grows with the square of the length."""

SHOWN = 80
"""Characters of a name or value that a message shows."""
