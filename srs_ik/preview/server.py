"""Meshcat's own server, in a thread of this process and on the loopback interface alone.

As a program of its own it listens on every interface, and outlives a process that is killed. Here it lives and dies
with the process, and what draws talks to it inside of it, without a port.
"""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import Future
from typing import Any

import tornado.httpserver
import tornado.netutil
import tornado.web
import zmq
from meshcat.servers.zmqserver import (
    VIEWER_HTML,
    VIEWER_ROOT,
    StaticFileHandlerNoCache,
    WebSocketHandler,
    ZMQWebSocketBridge,
)
from meshcat.visualizer import ViewerWindow

from srs_ik.errors import PreviewError

HOST = "127.0.0.1"

_HOSTS = r"(127\.0\.0\.1|localhost)"
"""Names under which pages are served; a page of another name that resolves to this machine gets nothing."""

_INSIDE = "inproc://srs_ik"
_ANSWER_WITHIN = 20_000
"""Milliseconds after which a silent server counts as gone."""


class _Socket(WebSocketHandler):
    """A browser's connection, without the prints of the original."""

    def open(self) -> None:
        self.bridge.websocket_pool.add(self)
        self.bridge.send_scene(self)

    def on_message(self, message: str | bytes) -> None:
        # Only pictures come this way, and none are asked for.
        pass

    def on_close(self) -> None:
        self.bridge.websocket_pool.discard(self)


class _Bridge(ZMQWebSocketBridge):
    """Meshcat's bridge between drawing commands and browsers, with its page on one loopback port."""

    def __init__(self, context: zmq.Context, port: int) -> None:
        self.context = context
        self.port = port
        self.http_server: tornado.httpserver.HTTPServer | None = None
        super().__init__(zmq_url=_INSIDE, host=HOST, port=port)
        self.web_url = f"http://{HOST}:{self.port}/static/"

    def make_app(self) -> tornado.web.Application:
        app = tornado.web.Application(log_function=lambda handler: None)
        files = {"path": VIEWER_ROOT, "default_filename": VIEWER_HTML}
        app.add_handlers(
            _HOSTS, [(r"/static/(.*)", StaticFileHandlerNoCache, files), (r"/", _Socket, {"bridge": self})]
        )
        app.listen = self._listen  # type: ignore[method-assign, assignment]
        return app

    def _listen(self, port: int, **options: Any) -> None:
        sockets = tornado.netutil.bind_sockets(port, HOST)
        self.port = sockets[0].getsockname()[1]
        self.http_server = tornado.httpserver.HTTPServer(self.app)
        self.http_server.add_sockets(sockets)

    def close(self) -> None:
        for browser in list(self.websocket_pool):
            browser.close()
        if self.http_server is not None:
            self.http_server.stop()
        self.zmq_stream.close(linger=0)


class Window(ViewerWindow):
    """The drawing side: Meshcat's window on a server of its own, which it starts and closes.

    Args:
        port: of the page; 0 for any that is free.

    Raises:
        PreviewError: the port is taken.
    """

    def __init__(self, port: int = 0) -> None:
        self.context = zmq.Context()
        self.closed = False
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
        """Carry out one drawing command.

        Raises:
            PreviewError: the preview is closed, or its server does not answer.
        """
        with self._lock:
            self._check_open()
            try:
                super().send(command)
            except zmq.ZMQError as error:
                raise PreviewError(f"the preview's server does not answer: {error}") from None

    def get_scene(self) -> str:
        """The scene as one HTML page.

        Raises:
            PreviewError: the preview is closed, or its server does not answer.
        """
        with self._lock:
            self._check_open()
            try:
                return str(super().get_scene())
            except zmq.ZMQError as error:
                raise PreviewError(f"the preview's server does not answer: {error}") from None

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
