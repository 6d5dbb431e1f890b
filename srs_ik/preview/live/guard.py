"""Viser's server behind a door: it has none of its own, and answers every origin, every name and every message."""

from __future__ import annotations

import http
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import websockets.asyncio.server as websocket_server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from srs_ik.preview.door import HEADERS, HOST, Door
from srs_ik.preview.live.inbox import MESSAGE_BYTES, Inbox

_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; worker-src blob:; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "connect-src 'self' data: blob:; base-uri 'none'; form-action 'none'"
)
"""What the page may load: nothing from elsewhere, and no frames."""

_NO_MESSAGE_OF_OURS = 1008
"""Code with which a connection is closed; the page's own script then connects again and gets the true state."""

_making = threading.Lock()
_log = logging.getLogger("srs_ik.preview.live.guard")
_log.addHandler(logging.NullHandler())
# What strangers send is no news for the program's own output.
_log.propagate = False


class Guarded(str):
    """The address to listen on, which carries the guard through viser to where connections are made."""

    door: Door
    inbox: Inbox
    stands: bool

    def __new__(cls, door: Door, inbox: Inbox) -> Guarded:
        """A guard of one server."""
        self = super().__new__(cls, HOST)
        self.door, self.inbox, self.stands = door, inbox, False
        return self


@contextmanager
def guarding() -> Iterator[None]:
    """While it lasts, servers that listen on a `Guarded` address get its guard, and all others are left alone."""
    with _making:
        serve = websocket_server.serve

        def guarded(handler: Any, host: Any = None, port: Any = None, **options: Any) -> Any:
            if isinstance(host, Guarded):
                options |= _options(host, options["process_request"])
                host.stands = True
            return serve(handler, host, port, **options)

        websocket_server.serve = guarded  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            websocket_server.serve = serve  # type: ignore[misc]


def _options(guard: Guarded, answer: Any) -> dict[str, Any]:
    door, inbox = guard.door, guard.inbox

    def process_request(connection: ServerConnection, request: Request) -> Response | None:
        headers = request.headers
        if not door.admits(request.path, headers.get_all("Host"), headers.get_all("Origin")):
            return connection.respond(http.HTTPStatus.FORBIDDEN, "Open the page by the address that was printed.\n")
        response: Response | None = answer(connection, Request(door.inside(request.path), headers))
        if response is not None:
            response.headers.update(HEADERS | {"Content-Security-Policy": _POLICY})
        return response

    class Connection(ServerConnection):
        """One that hands on what the page may say, and ends with whatever else is said."""

        async def recv(self, decode: bool | None = None) -> Any:
            message = await super().recv(decode)
            if not inbox.accepts(message):
                await self.close(_NO_MESSAGE_OF_OURS, "no message of this page")
                # What has come in behind it is not read.
                raise self.protocol.close_exc
            return message

    return {
        "process_request": process_request,
        "create_connection": Connection,
        "max_size": MESSAGE_BYTES,
        "logger": _log,
    }
