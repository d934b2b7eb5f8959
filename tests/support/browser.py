"""A headless Chromium, driven over a pipe by its DevTools protocol.

Nothing needs to be installed for it but the browser itself.
"""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from bt_mission.commands.doctor import BROWSERS

BROWSER = next(filter(None, map(shutil.which, BROWSERS)), None)
IN_BROWSER = [
    pytest.mark.process,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed"),
]
"""The marks of tests that need it."""
PATIENCE_S = 120
"""How long it may say nothing: a page that hangs fails one test, and ends no process of tests."""


class Page:
    """One page of a browser."""

    def __init__(self, send: int, receive: int) -> None:
        self._send, self._receive = send, receive
        self._buffer = b""
        self._number = 0
        self._session: str | None = None
        self._server: str | None = None
        self.problems: list[str] = []
        """What the console was told, errors that nobody caught, and all that was fetched."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def send(self, method: str, **parameters: Any) -> None:
        """Call a method of the protocol, without waiting for its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._send, json.dumps(message).encode() + b"\0")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method of the protocol; gives its result."""
        self.send(method, **parameters)
        while (message := self._next()).get("id") != self._number:
            self._note(message)
        assert "error" not in message, f"{method}: {message['error']}"
        result: dict[str, Any] = message["result"]
        return result

    def open(self, path: Path, *, width: int, height: int, scripts: bool = True) -> None:
        """Open a file, and wait until it is loaded."""
        self.visit(path.resolve().as_uri(), width=width, height=height, scripts=scripts)

    def visit(self, url: str, *, width: int, height: int, scripts: bool = True) -> None:
        """Open a page, and wait until it is loaded; from its server it may fetch more."""
        self._server = "/".join(url.split("/")[:3]) if url.startswith("http") else None
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 600,
        )
        self.call("Emulation.setScriptExecutionDisabled", value=not scripts)
        self.call("Page.navigate", url=url)
        while (message := self._next()).get("method") != "Page.loadEventFired":
            self._note(message)

    def look(self, expression: str) -> Any:
        """The value of an expression of JavaScript."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def until(self, expression: str, seconds: float = 30) -> None:
        """Wait until an expression of JavaScript holds, for no longer than so many seconds."""
        waiting = (
            f"new Promise((done) => {{ const end = Date.now() + {1000 * seconds};"
            f" const look = () => ({expression}) ? done(true)"
            " : Date.now() > end ? done(false) : setTimeout(look, 10);"
            " look(); })"
        )
        answer = self.call(
            "Runtime.evaluate", expression=waiting, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        assert answer["result"]["value"], f"not within {seconds} s: {expression}"

    def prefer(self, scheme: str) -> None:
        """Prefer a ``light`` or a ``dark`` page."""
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self.call("Emulation.setEmulatedMedia", features=[feature])

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Move, press, release or turn the wheel: ``mouseMoved``, ``mouseWheel``, ..."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def key(self, key: str) -> None:
        """Press a key and let it go."""
        text = {"text": key} if len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    def screenshot(self, path: Path, *, whole: bool = False) -> None:
        """Save a picture of what is seen, or of the whole page."""
        taken = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(taken["data"]))

    def _note(self, message: dict[str, Any]) -> None:
        method, parameters = message.get("method", ""), message.get("params", {})
        if method in ("Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"):
            self.problems.append(json.dumps(parameters))
        elif method == "Network.requestWillBeSent":
            url = parameters["request"]["url"]
            is_own = self._server is not None and url.startswith(f"{self._server}/")
            if not is_own and not url.startswith(("file:", "data:")):
                self.problems.append(f"fetched {url}")

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            is_there, _, _ = select.select([self._receive], [], [], PATIENCE_S)
            assert is_there, f"the browser has said nothing for {PATIENCE_S} s"
            some = os.read(self._receive, 1 << 20)
            assert some, "the browser has gone"
            self._buffer += some
        message, _, self._buffer = self._buffer.partition(b"\0")
        parsed: dict[str, Any] = json.loads(message)
        return parsed


@contextmanager
def browser(folder: Path) -> Iterator[Page]:
    """Start a browser with a profile of its own in a folder."""
    assert BROWSER is not None
    theirs_in, ours_out = os.pipe()
    ours_in, theirs_out = os.pipe()
    # The protocol wants its pipes at 3 and 4, and the shell is the shortest way to put them there.
    script = f'exec "$0" "$@" 3<&{theirs_in} 4>&{theirs_out}'
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    process = subprocess.Popen(
        [
            *("bash", "-c", script, BROWSER, *options),
            *("--remote-debugging-pipe", f"--user-data-dir={folder}", "--no-first-run"),
        ],
        pass_fds=(theirs_in, theirs_out),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(theirs_in)
    os.close(theirs_out)
    try:
        yield Page(ours_out, ours_in)
    finally:
        process.kill()
        process.wait()
        os.close(ours_out)
        os.close(ours_in)
