"""Chromium without a screen, driven over the DevTools protocol through a pair of pipes: no port, no further package."""
from __future__ import annotations

import base64
import io
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time
from typing import Any, Callable

import numpy as np
from PIL import Image

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
PATIENCE_S = 1800.0  # after which a browser hangs, whatever else the machine does


def find_browser() -> str | None:
    """Its path, None if there is none."""
    return next((path for name in PROGRAMS if (path := shutil.which(name))), None)


class Browser:
    """One page. `requests` are the addresses that it asked for, `said` what went to its console as errors."""

    def __init__(self, program: str, width: int = 1200, height: int = 760) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="browser-")
        self.requests: list[str] = []
        self.said: list[str] = []
        self._number, self._buffer = 0, b""
        self._answers: dict[int, dict[str, Any]] = {}
        to_read, self._to = os.pipe()
        self._from, from_write = os.pipe()
        arguments = [program, "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--enable-unsafe-swiftshader",
                     "--use-angle=swiftshader", "--no-first-run", "--disable-background-networking", "--disable-sync",
                     "--disable-component-update", "--disable-default-apps", "--disable-extensions", "--hide-scrollbars",
                     "--remote-debugging-pipe", f"--user-data-dir={self._folder.name}", f"--window-size={width},{height}",
                     "about:blank"]
        # the protocol's pipes are descriptors 3 and 4
        script = f'exec "$@" 3<&{to_read} 4>&{from_write} {to_read}<&- {from_write}>&-' if min(to_read, from_write) > 4 else \
            'echo "descriptors 3 and 4 are taken" >&2; exit 1'
        spare = []
        while min(to_read, from_write) <= 4:  # so that one does not close what the other needs
            spare += [to_read, from_write]
            to_read, from_write = os.dup(to_read), os.dup(from_write)
            script = f'exec "$@" 3<&{to_read} 4>&{from_write}'
        self._process = subprocess.Popen(
            ["/bin/bash", "-c", script, "bash", *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, pass_fds=(to_read, from_write), start_new_session=True,
            env={**os.environ, "HOME": self._folder.name})
        for descriptor in (to_read, from_write, *spare):
            os.close(descriptor)
        target = self._call("Target.createTarget", {"url": "about:blank"}, None)["targetId"]
        self._session = self._call("Target.attachToTarget", {"targetId": target, "flatten": True}, None)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self._call(f"{domain}.enable")
        self._call("Emulation.setDeviceMetricsOverride",
                   {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})

    def close(self) -> None:
        """Ends it and all that it started, and removes its folder."""
        os.close(self._to)
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self._process.wait()
        os.close(self._from)
        for _ in range(50):  # its helpers may write for another moment
            try:
                self._folder.cleanup()
                return
            except OSError:
                time.sleep(0.1)
        self._folder.cleanup()

    def open(self, url: str) -> None:
        self._call("Page.navigate", {"url": url})
        self.wait('document.readyState === "complete" && document.body !== null')

    def evaluate(self, script: str) -> Any:
        """The value of an expression in the page; a promise is waited for. Raises RuntimeError where it throws."""
        answer = self._call("Runtime.evaluate", {"expression": script, "returnByValue": True, "awaitPromise": True})
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{script}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait(self, script: str, wanted: Callable[[Any], bool] = bool, patience_s: float = PATIENCE_S) -> Any:
        """The value once it is `wanted`. Raises AssertionError after `patience_s`."""
        end = time.monotonic() + patience_s
        while not wanted(value := self.evaluate(script)):
            if time.monotonic() > end:
                raise AssertionError(f"{script} stays {value!r}; the page said {self.said} and shows "
                                     f"{self.evaluate('document.body?.innerText')!r}")
            time.sleep(0.05)
        return value

    def picture(self) -> np.ndarray:
        """What is on the screen, (height, width, 3) 0..255."""
        return np.asarray(Image.open(io.BytesIO(self.png())).convert("RGB"))

    def png(self) -> bytes:
        return base64.b64decode(self._call("Page.captureScreenshot", {"format": "png"})["data"])

    def _call(self, method: str, parameters: dict[str, Any] | None = None, session: str | None = "") -> dict[str, Any]:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters or {}}
        if session is not None:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + PATIENCE_S
        while self._number not in self._answers:
            self._read(end, method)
        answer = self._answers.pop(self._number)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def _read(self, end: float, method: str) -> None:
        ready, _, _ = select.select([self._from], [], [], max(end - time.monotonic(), 0.0))
        data = os.read(self._from, 1 << 20) if ready else b""
        if not data:
            raise RuntimeError(f"the browser {'has ended' if ready else 'does not answer'} at {method}")
        *messages, self._buffer = (self._buffer + data).split(b"\0")
        for raw in messages:
            message = json.loads(raw)
            if "id" in message:
                self._answers[message["id"]] = message
            elif message["method"] == "Network.requestWillBeSent":
                self.requests.append(message["params"]["request"]["url"])
            elif message["method"] == "Runtime.exceptionThrown":
                self.said.append(str(message["params"]["exceptionDetails"]))
            elif message["method"] == "Runtime.consoleAPICalled" and message["params"]["type"] in ("error", "assert"):
                self.said.append(str([a.get("value", a.get("description")) for a in message["params"]["args"]]))
            elif message["method"] == "Log.entryAdded" and message["params"]["entry"]["level"] == "error":
                self.said.append(message["params"]["entry"]["text"])
