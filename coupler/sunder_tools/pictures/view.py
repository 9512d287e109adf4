"""`sunder view`: serves a page that plays a run, to this machine only. coupler/viewer has the page."""
from __future__ import annotations

import base64
import errno
import hashlib
import http.server
import json
import os
import re
import shutil
import subprocess
import sys
from http import HTTPStatus
from pathlib import Path
from typing import Any, Callable

from ..errors import DONE, CommandError, Interrupted
from ..launch.folder import existing_run
from ..places import REPOSITORY, npm_folder
from .playback import Playback
from .vtp import VtpError

HOST = "127.0.0.1"
PAGE = REPOSITORY / "coupler" / "viewer"
FILES = {"/": PAGE / "index.html", "/view.css": PAGE / "view.css",
         **{f"/{name}.js": PAGE / f"{name}.js" for name in ("view", "frame", "scene", "colours", "plots")}}
OF_PACKAGES = {"/three.module.js": "three/build/three.module.js", "/three.core.js": "three/build/three.core.js",
               "/OrbitControls.js": "three/examples/jsm/controls/OrbitControls.js",
               "/uplot.js": "uplot/dist/uPlot.esm.js",
               "/uplot.css": "uplot/dist/uPlot.min.css"}  # below packages(); no other file is served
KINDS = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8"}


def ensure_page() -> None:
    """Downloads three.js and uPlot from npm's registry, once, to where `npm_folder` says. Raises CommandError."""
    from ..launch.node import ensure_packages  # it needs no Node.js: these files run in the browser
    folder = npm_folder("viewer", PAGE)
    ensure_packages(folder.parent / "viewer.log", PAGE, folder, "the viewer")


def packages() -> Path:
    """The folder of the packages that the page loads: three.js draws, uPlot plots."""
    return npm_folder("viewer", PAGE) / "node_modules"


def content_policy(page: bytes) -> str:
    """Returns a policy under which a browser fetches from this server only. The one inline script, the import map,
    has a hash."""
    maps = re.findall(rb'<script type="importmap">(.*?)</script>', page, re.DOTALL)
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(m).digest()).decode()}'" for m in maps)
    return ("default-src 'none'; connect-src 'self'; style-src 'self'; img-src 'self' data:; "
            f"script-src 'self' {hashes}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")


class _Handler(http.server.BaseHTTPRequestHandler):
    server: "Server"
    protocol_version = "HTTP/1.1"
    timeout = 60.0  # [s] of silence

    def do_GET(self) -> None:  # noqa: N802: the base class's name
        # a page elsewhere whose name leads here (DNS rebinding) must not read runs
        if self.headers.get("Host", "").rpartition(":")[0] not in (HOST, "localhost"):
            self._answer(HTTPStatus.FORBIDDEN, "text/plain", b"not for this host")
            return
        path = self.path.partition("?")[0]
        try:
            if path in FILES or path in OF_PACKAGES:
                file = FILES[path] if path in FILES else packages() / OF_PACKAGES[path]
                self._answer(HTTPStatus.OK, KINDS[file.suffix], file.read_bytes())
            elif path == "/state":
                self._json(self.server.playback.state())
            elif path == "/curves":
                self._json(self.server.playback.curves())
            elif found := re.fullmatch(r"/frame/([0-9]{1,9})", path):
                packed = self.server.playback.frame(int(found[1]))
                if packed is None:
                    self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"no such frame")
                else:
                    self._answer(HTTPStatus.OK, "application/octet-stream", packed)
            else:
                self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"not here")
        except (VtpError, OSError) as error:  # the run's folder is at fault, or was just replaced: the page says so
            if isinstance(error, (BrokenPipeError, ConnectionError)):
                return
            self._answer(HTTPStatus.INTERNAL_SERVER_ERROR, "text/plain; charset=utf-8", str(error).encode())

    def _json(self, value: Any) -> None:
        self._answer(HTTPStatus.OK, "application/json", json.dumps(value).encode())

    def _answer(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        for key, value in (("Content-Type", kind), ("Content-Length", str(len(body))), ("Cache-Control", "no-store"),
                           ("X-Content-Type-Options", "nosniff"), ("Content-Security-Policy", self.server.policy),
                           ("Cross-Origin-Resource-Policy", "same-origin")):
            self.send_header(key, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Logs nothing: the page shows what goes wrong."""


class Server(http.server.ThreadingHTTPServer):
    """Serves the page and one run at `url`. Raises CommandError where the port cannot be had."""
    daemon_threads = True

    def __init__(self, folder: Path, port: int = 0) -> None:
        self.playback = Playback(folder)
        self.policy = content_policy((PAGE / "index.html").read_bytes())
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            why = "is in use" if error.errno == errno.EADDRINUSE else f"cannot be had: {error.strerror}"
            raise CommandError(f"--port {port}: port {why}; give another one, or leave --port out") from None
        self.url = f"http://{HOST}:{self.server_address[1]}/"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away in the middle of an answer is nothing to tell."""
        if not isinstance(sys.exc_info()[1], (ConnectionError, TimeoutError)):
            super().handle_error(request, client_address)


def view(folder: Path, port: int, open_browser: bool, ready: Callable[[Server], None] | None = None) -> int:
    """Serves until interrupted; returns the exit status. Raises CommandError."""
    existing_run(folder, "view")
    ensure_page()
    with Server(folder, port) as server:
        print(f"sunder: {folder} is shown at {server.url} (Ctrl-C ends)", flush=True)
        if open_browser:
            _open(server.url)
        try:
            if ready is not None:
                ready(server)
            server.serve_forever()
        except (Interrupted, KeyboardInterrupt):
            pass  # the way to end it
    return DONE


def _open(url: str) -> None:
    """Opens the address in the user's browser, where there is a screen."""
    opener = shutil.which("xdg-open")
    if opener and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        subprocess.Popen([opener, url], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                         start_new_session=True)
