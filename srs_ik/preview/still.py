"""`StillPage`: a page in Meshcat with an arm on it, served to this machine alone or kept as one file."""

from __future__ import annotations

import html
import os
import weakref
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Self

from srs_ik.errors import PreviewError, quoted
from srs_ik.preview.canvas import Canvas
from srs_ik.preview.server import Window
from srs_ik.system.writing import write_whole

if TYPE_CHECKING:
    from srs_ik.arm import Arm


class StillPage:
    """A page that shows what is drawn on it: an address, an end, and its HTML.

    Attributes:
        arm: the arm.
    """

    def __init__(self, arm: Arm, port: int) -> None:
        self.arm = arm
        self._window = Window(port)
        self._close = weakref.finalize(self, self._window.close)
        self._canvas = Canvas(self._window)

    @property
    def url(self) -> str:
        """Address of the page, on this machine alone; whoever has it sees the scene."""
        return self._window.web_url

    @property
    def closed(self) -> bool:
        """Whether the page is gone."""
        return self._window.closed

    def open(self) -> None:
        """Open the page in the browser of the desktop."""
        webbrowser.open(self.url)

    def close(self) -> None:
        """End the page and free its port; a second time does nothing."""
        self._close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def html(self) -> str:
        """The scene as one HTML page that needs neither this program nor a network.

        Raises:
            PreviewError: the preview is closed.
        """
        return self._canvas.page()

    def save(self, path: str | Path) -> Path:
        """Write the scene, with its motion if it has one, as one HTML file that opens without a server or network.

        The file appears whole or not at all.

        Args:
            path: a file that ends in .html or .htm.

        Returns:
            Where it was written.

        Raises:
            PreviewError: the preview is closed, the path is none or ends otherwise, or the file cannot be written.
        """
        if not isinstance(path, str | os.PathLike):
            raise PreviewError(f"a page is saved under the name of a file, such as scene.html, not {quoted(path)}")
        if Path(path).suffix.lower() not in (".html", ".htm") and not Path(path).is_dir():
            raise PreviewError(f"a page is HTML: give it a name such as scene.html, not {quoted(str(path))}")
        try:
            return write_whole(Path(path), self.html())
        except IsADirectoryError:
            raise PreviewError(f"{path} is a folder: give the name of a file, such as scene.html") from None
        except OSError as error:
            raise PreviewError(f"{path} cannot be written: {error.strerror}") from None

    def _repr_html_(self) -> str | None:
        # A picture of the scene as it is now, which stays with the notebook when the program is gone.
        if self.closed:
            return None
        page = html.escape(self.html())
        style = "width: 100%; height: 420px; border: none"
        return f'<iframe sandbox="allow-scripts" srcdoc="{page}" style="{style}"></iframe>'

    def __repr__(self) -> str:
        return f"<Preview of {self.arm.name}, {'closed' if self.closed else 'at ' + self.url}>"
