"""Who may open a page: a browser of this machine that was given its address, and no page of another origin."""

from __future__ import annotations

import operator
import secrets
from collections.abc import Sequence
from typing import Any

from srs_ik.errors import PreviewError, quoted

HOST = "127.0.0.1"

_NAMES = (HOST, "localhost")
"""Names of this machine in a browser's address; a page of another name that resolves to it gets nothing."""

HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}
"""With every answer, so that the address stays where it is."""

_TOKEN_BYTES = 24
"""Too many to guess: 192 bits."""


MOST = 65535
"""Number of the last port."""


def as_port(value: Any) -> int:
    """The port of a page, 0 for any that is free; raises PreviewError for what is no port."""
    try:
        port = -1 if isinstance(value, bool) else operator.index(value)
    except TypeError:
        port = -1
    if not 0 <= port <= MOST:
        raise PreviewError(f"the port of a preview is a whole number from 0 to {MOST}, not {quoted(value)}")
    return port


class Door:
    """The address of a page, with a secret in its path, and what each request has to show to be let in.

    The secret is in the path since everything below it, the websocket too, then carries it without a cookie: browsers
    send the cookies of one port to all ports of a machine, those of other users among them.

    Attributes:
        port: of the page; known once the server listens.
    """

    def __init__(self) -> None:
        self.port = 0
        self._token = secrets.token_urlsafe(_TOKEN_BYTES)

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self.port}/{self._token}/"

    def admits(self, target: str, hosts: Sequence[str], origins: Sequence[str]) -> bool:
        """Whether a request for a target, the path from the first slash on, is answered, as a file or as a websocket.

        Its Host headers have to be one, of this machine and port; its Origin headers none, or the page's own.
        """
        # Browsers leave out the port that is a page's by default.
        port = "" if self.port == 80 else f":{self.port}"
        if list(hosts) not in [[name + port] for name in _NAMES]:
            return False
        if list(origins) not in ([], [f"http://{hosts[0]}"]):
            return False
        token = target.partition("?")[0].split("/")[1:2]
        return secrets.compare_digest("".join(token).encode(errors="replace"), self._token.encode())

    def inside(self, target: str) -> str:
        """What a request that is admitted asks for, below the secret."""
        return "/" + "/".join(target.split("/")[2:])
