"""Meshcat's own server, in a thread of this process and on the loopback interface alone.

As a program of its own it listens on every interface, and outlives a process that is killed. Here it lives and dies
with the process, and what draws talks to it inside of it, without a port.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import tornado.httpserver
import tornado.netutil
import tornado.web
import tornado.websocket
import umsgpack
import zmq
from meshcat.servers.tree import walk
from meshcat.servers.zmqserver import VIEWER_ROOT, ZMQWebSocketBridge
from meshcat.visualizer import ViewerWindow

from srs_ik.errors import PreviewError
from srs_ik.preview import document
from srs_ik.preview.document import Caption
from srs_ik.preview.door import HEADERS, HOST, Door, as_port

_SCRIPT = Path(VIEWER_ROOT, "main.min.js")

_UNTITLED = Caption("Preview")
_CAPTION, _SCENE = b"caption", b"scene"
_LONGEST = 1024
"""Bytes that a browser may send at once, though nobody listens."""

_INSIDE = "inproc://srs_ik"
_ANSWER_WITHIN = 20_000
"""Milliseconds after which a silent server counts as gone."""


class _Handler(tornado.web.RequestHandler):
    """Answers those whom the door admits."""

    def initialize(self, bridge: _Bridge) -> None:
        self.bridge = bridge

    def prepare(self) -> None:
        """Refuse whoever lacks the address or comes from elsewhere, for whatever is asked."""
        headers = self.request.headers
        admitted = self.bridge.door.admits(self.request.uri or "", headers.get_list("Host"), headers.get_list("Origin"))
        if not admitted:
            raise tornado.web.HTTPError(403)

    def set_default_headers(self) -> None:
        for name, value in (HEADERS | {"Content-Security-Policy": document.POLICY}).items():
            self.set_header(name, value)


class _Page(_Handler):
    """The page, and the script that it runs."""

    def get(self, name: str) -> None:
        self.set_header("Content-Type", "text/javascript" if name else "text/html; charset=utf-8")
        self.write(_SCRIPT.read_bytes() if name else document.live())


class _Nothing(_Handler):
    """Whatever else is asked for."""

    def prepare(self) -> None:
        super().prepare()
        raise tornado.web.HTTPError(404)


class _Socket(_Handler, tornado.websocket.WebSocketHandler):
    """A browser's connection."""

    def open(self) -> None:
        self.bridge.websocket_pool.add(self)
        self.write_message(self.bridge.caption)
        self.bridge.send_scene(self)

    def on_message(self, message: str | bytes) -> None:
        # The page says nothing, and is not listened to.
        pass

    def on_close(self) -> None:
        self.bridge.websocket_pool.discard(self)


class _Bridge(ZMQWebSocketBridge):
    """Meshcat's bridge between drawing commands and browsers, with its page on one loopback port."""

    def __init__(self, context: zmq.Context, port: int) -> None:
        self.context = context
        self.door = Door()
        self.caption = _UNTITLED.json()
        self.http_server: tornado.httpserver.HTTPServer | None = None
        super().__init__(zmq_url=_INSIDE, host=HOST, port=port)
        self.web_url = self.door.url

    def make_app(self) -> tornado.web.Application:
        bridge = {"bridge": self}
        app = tornado.web.Application(
            [(r"/[^/]+/(main\.min\.js)?", _Page, bridge), (r"/[^/]+/scene", _Socket, bridge)],
            default_handler_class=_Nothing,
            default_handler_args=bridge,
            log_function=lambda handler: None,
            websocket_max_message_size=_LONGEST,
        )
        app.listen = self._listen  # type: ignore[method-assign, assignment]
        return app

    def handle_zmq(self, frames: list[bytes]) -> None:
        """Answer the drawing side: a caption, the question for the scene, or a command of Meshcat's."""
        if frames[0] == _CAPTION:
            self.caption = frames[1].decode()
            for browser in self.websocket_pool:
                browser.write_message(self.caption)
            self.zmq_socket.send(b"ok")
        elif frames[0] == _SCENE:
            self.zmq_socket.send_multipart([b"ok", *self._commands()])
        else:
            super().handle_zmq(frames)

    def _commands(self) -> Iterator[bytes]:
        """All that draws the scene, in order."""
        for node in walk(self.tree):
            parts = [node.object, *node.properties, node.transform, node.animation]
            yield from (part for part in parts if part is not None)

    def _listen(self, port: int, **options: Any) -> None:
        sockets = tornado.netutil.bind_sockets(port, HOST)
        self.door.port = sockets[0].getsockname()[1]
        self.http_server = tornado.httpserver.HTTPServer(self.app)
        self.http_server.add_sockets(sockets)

    def close(self) -> None:
        for browser in list(self.websocket_pool):
            browser.close()
        if self.http_server is not None:
            self.http_server.stop()
        self.zmq_stream.close(linger=0)


class Window(ViewerWindow):
    """The drawing side: Meshcat's window on a server of its own, which it starts and closes; port 0 is any free.

    Raises:
        PreviewError: the port is taken, or there is none of this number.
    """

    def __init__(self, port: int = 0) -> None:
        port = as_port(port)
        self.context = zmq.Context()
        self.closed = False
        self._caption = _UNTITLED
        self._lock = threading.Lock()
        self._ready: Future[_Bridge] = Future()
        # A daemon: the page goes when the program ends, and does not keep it from ending.
        self._thread = threading.Thread(target=self._serve, args=(port,), name="srs_ik preview", daemon=True)
        self._thread.start()
        try:
            self._bridge = self._ready.result()
        except (OSError, OverflowError) as error:
            self.context.destroy(linger=0)
            reason = getattr(error, "strerror", None) or error
            raise PreviewError(f"the preview cannot be served on port {port} of {HOST}: {reason}") from None
        self.web_url = self._bridge.web_url
        self.zmq_url = self._bridge.zmq_url
        self.connect_zmq()
        self.zmq_socket.setsockopt(zmq.RCVTIMEO, _ANSWER_WITHIN)

    def send(self, command: Any) -> None:
        """Carry out one drawing command."""
        drawn = command.lower()
        self._ask([drawn["type"].encode(), drawn["path"].encode(), umsgpack.packb(drawn)])

    def tell(self, caption: Caption) -> None:
        """Put a caption on the page."""
        self._ask([_CAPTION, caption.json().encode()])
        self._caption = caption

    def get_scene(self) -> str:
        """The scene as one HTML page that needs nothing else."""
        return document.saved(self._caption, _SCRIPT.read_text(encoding="utf-8"), self._ask([_SCENE])[1:])

    def _ask(self, frames: list[bytes]) -> list[bytes]:
        with self._lock:
            self._check_open()
            try:
                self.zmq_socket.send_multipart(frames)
                answer: list[bytes] = self.zmq_socket.recv_multipart()
            except zmq.ZMQError as error:
                raise PreviewError(f"the preview's server does not answer: {error}") from None
        return answer

    def close(self) -> None:
        """Stop the server and free its port; a second time does nothing."""
        with self._lock:
            if self.closed:
                return
            self.closed = True
            self.zmq_socket.close(linger=0)
            self._bridge.ioloop.add_callback(self._bridge.ioloop.stop)
            self._thread.join()
            self.context.destroy(linger=0)

    def _check_open(self) -> None:
        if self.closed:
            raise PreviewError("the preview is closed: make a new one")

    def _serve(self, port: int) -> None:
        asyncio.set_event_loop(loop := asyncio.new_event_loop())
        try:
            try:
                bridge = _Bridge(self.context, port)
            except Exception as error:
                self._ready.set_exception(error)
                return
            self._ready.set_result(bridge)
            bridge.run()
            bridge.close()
            # Connections say goodbye in tasks of their own.
            loop.run_until_complete(asyncio.sleep(0.01))
        finally:
            loop.close()
