"""The page around Meshcat's scene: the scene, and a caption that says what is shown.

Text reaches the page as JSON and is shown as text alone, so that no name in a robot file becomes a part of the page.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

from srs_ik.preview.palette import Rgb
from srs_ik.preview.words import css

_ALONE = "default-src 'none'; script-src 'self' 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""What the page may load: its own script and pictures that it makes itself; a saved page is under the same policy."""

POLICY = f"{_ALONE}; connect-src 'self'; base-uri 'none'; form-action 'none'"
"""The same for a page that is served, which talks to its own server."""


@dataclass(frozen=True)
class Caption:
    """What a page says beside its scene."""

    title: str  # what is shown
    lines: Sequence[str] = ()  # more about it, a line each
    legend: Sequence[tuple[Rgb, str]] = ()  # colour and meaning of what is drawn

    def json(self) -> str:
        """As the page takes it, safe in a script too."""
        legend = [(css(colour), text) for colour, text in self.legend]
        return json.dumps(asdict(self) | {"legend": legend}).replace("<", "\\u003c")


def live() -> str:
    """The page that draws what its server sends."""
    return _page("Preview", POLICY, '<script src="main.min.js"></script>', _CONNECT)


def saved(caption: Caption, script: str, commands: Iterable[bytes]) -> str:
    """The page that draws some commands, in their order, by a script, Meshcat's own, and needs nothing else."""
    drawn = json.dumps([base64.b64encode(command).decode() for command in commands])
    return _page(caption.title, _ALONE, f"<script>{script}</script>", f"tell({caption.json()}); draw({drawn});")


def _page(title: str, policy: str, meshcat: str, start: str) -> str:
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{html.escape(title)}</title>
<link rel="icon" href="data:,">
<style>{_STYLE}</style>
</head>
<body>
<div id="scene"></div>
<div id="caption"><b id="title"></b><div id="lines"></div><div id="legend"></div></div>
{meshcat}
<script>{_SHOW}{start}</script>
</body>
</html>
"""


_STYLE = """
body { margin: 0; font: 13px/1.45 system-ui, sans-serif; color: #222; }
#scene { width: 100vw; height: 100vh; overflow: hidden; }
#caption { position: fixed; left: 12px; top: 10px; max-width: 60vw; overflow-wrap: anywhere; pointer-events: none;
  text-shadow: 0 0 3px #fff, 0 0 3px #fff, 0 0 6px #fff; }
@media (max-width: 640px) { #caption { top: 28px; max-width: 94vw; } }
#legend span { display: inline-block; width: 0.8em; height: 0.8em; margin-right: 0.5em; border-radius: 50%; }
"""

_SHOW = """
const viewer = new MeshCat.Viewer(document.getElementById("scene"));
// What is seen fits the height of a window; where that is more than its width, it is to fit the width.
function fit() {
  viewer.camera.zoom = Math.min(1, innerWidth / innerHeight);
  viewer.camera.updateProjectionMatrix();
  viewer.set_dirty();
}
addEventListener("resize", fit);
fit();
function line(text, colour) {
  const line = document.createElement("div");
  if (colour) line.appendChild(document.createElement("span")).style.background = colour;
  line.append(text);
  return line;
}
function tell(caption) {
  document.title = document.getElementById("title").textContent = caption.title;
  document.getElementById("lines").replaceChildren(...caption.lines.map(text => line(text)));
  document.getElementById("legend").replaceChildren(...caption.legend.map(([colour, text]) => line(text, colour)));
}
function draw(commands) {
  for (const command of commands) {
    viewer.handle_command_bytearray(Uint8Array.from(atob(command), letter => letter.charCodeAt(0)));
  }
}
"""

_CONNECT = """
const connection = new WebSocket(new URL("scene", location.href).href.replace("http", "ws"));
connection.binaryType = "arraybuffer";
connection.onmessage = message =>
  typeof message.data === "string" ? tell(JSON.parse(message.data)) : viewer.handle_command_message(message);
"""
