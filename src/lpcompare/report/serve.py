"""A run's page on 127.0.0.1; each result is sent when the page asks for it, so that large runs have a page too."""

from __future__ import annotations

import json
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from lpcompare.benchmark.record import Run
from lpcompare.errors import InputError
from lpcompare.report.clouds3d import Views
from lpcompare.report.page import run_page

HOST = "127.0.0.1"


def make_server(run: Run, port: int = 0) -> ThreadingHTTPServer:
    """A server of the page of a run, which only this machine can reach.

    Parameters
    ----------
    run : Run
    port : int
        0 for any that is free.

    Returns
    -------
    ThreadingHTTPServer
        Call its ``serve_forever``; ``server_port`` says where it listens.

    Raises
    ------
    InputError
        The port is taken, or is none.
    """
    text, views = run_page(run, served=True)
    try:
        return ThreadingHTTPServer((HOST, port), partial(_Answers, text.encode(), views))
    except OverflowError as error:
        raise InputError(f"port is {port}; give an integer from 0 to 65535.") from error
    except OSError as error:
        reason = error.strerror or error
        raise InputError(
            f"Port {port} cannot be used ({reason}); leave --port out for any free one."
        ) from error


class _Answers(BaseHTTPRequestHandler):
    """The page, and one JSON document per result: ``/result/<model>/<number>``."""

    def __init__(self, page: bytes, views: Views, *rest: Any) -> None:
        self._page, self._views = page, views
        super().__init__(*rest)

    def do_GET(self) -> None:
        """Answer the browser; a page of another site that asks through its own name is refused."""
        port = self.server.server_address[1]
        if self.headers.get("Host") not in (f"{HOST}:{port}", f"localhost:{port}"):
            return self.send_error(HTTPStatus.FORBIDDEN)
        if self.path == "/":
            return self._send(self._page, "text/html; charset=utf-8")
        try:
            kind, model, number = self.path.strip("/").split("/")
            found = self._views.result(int(model), int(number)) if kind == "result" else None
        except (ValueError, IndexError):
            found = None
        if found is None:
            return self.send_error(HTTPStatus.NOT_FOUND)
        return self._send(json.dumps(found).encode(), "application/json")

    def _send(self, content: bytes, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: the command has said where the page is."""
