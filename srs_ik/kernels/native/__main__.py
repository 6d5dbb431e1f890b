"""What a C or C++ compiler needs to know: python -m srs_ik.kernels.native [--cflags] [--libs]."""

from __future__ import annotations

import sys

from srs_ik.kernels.native import FOLDER

FLAGS = {"--cflags": f"-I{FOLDER}", "--libs": f"-L{FOLDER} -Wl,-rpath,{FOLDER} -lsrs_ik"}


def main(asked: list[str]) -> int:
    """Print the options that are asked for, all by default; exit status 1 where nothing was compiled."""
    if not (FOLDER / "srs_ik.h").is_file():
        print("srs_ik: no compiled kernels here: install a wheel, see docs/cpp.md", file=sys.stderr)
        return 1
    unknown = [each for each in asked if each not in FLAGS]
    if unknown:
        print(f"srs_ik: no option {unknown[0]}; there are {', '.join(FLAGS)}", file=sys.stderr)
        return 2
    print(" ".join(FLAGS[each] for each in asked or FLAGS))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
