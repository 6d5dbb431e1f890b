"""Writes the tables of docs/control_measured.md and the verdicts on control in docs/what_holds.md.

Run: python docs/control.py DIR
DIR is where `srs-ik reproduce control --out DIR` has left its results.
"""

from __future__ import annotations

import argparse
import io
import json
import re
from pathlib import Path

from control_tables import all_tables
from control_verdicts import verdicts

from srs_ik.system.writing import write_whole

DOCS = Path(__file__).resolve().parent
WIDTH = 900
"""Of a picture on the page, dots."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    found = {path.stem: json.loads(path.read_text())["figures"] for path in sorted(folder.glob("control-*.json"))}
    rows = verdicts(found)
    lines = [f"| {row.claim} | **{row.verdict}** | {row.found} | `{row.command}` |" for row in rows]
    fill(DOCS / "what_holds.md", {"control": ["| claim | verdict | measured | by |", "|---|---|---|---|", *lines]})
    fill(DOCS / "control_measured.md", all_tables(found))
    for name in found:
        small_picture(folder / f"{name}.png", DOCS / "pictures" / f"{name}.png")


def fill(page: Path, tables: dict[str, list[str]]) -> None:
    text = page.read_text()
    for name, lines in tables.items():
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        if begin not in text or end not in text:
            raise SystemExit(f"{page.name} has no place for {name}: {begin} ... {end}")
        new = "\n".join([begin, *lines, end])
        text = re.sub(f"{begin}.*?{end}", lambda _, new=new: new, text, flags=re.S)
    write_whole(page, text)


def small_picture(source: Path, target: Path) -> None:
    from PIL import Image

    picture = Image.open(source).convert("RGB")
    picture = picture.resize((WIDTH, round(WIDTH * picture.height / picture.width)), Image.Resampling.LANCZOS)
    buffer = io.BytesIO()
    picture.quantize(128).save(buffer, format="png", optimize=True)
    write_whole(target, buffer.getvalue())


if __name__ == "__main__":
    main()
