"""A browser of the user's own without a window, for pictures of one page: no network, a profile that is thrown away.

It is driven from a thread of its own, so that Ctrl-C and a time limit end it wherever it is, and notebooks, which have
a loop running, can use it.
"""

from __future__ import annotations

import asyncio
import base64
import os
import shutil
import sys
import tempfile
import threading
import weakref
from collections.abc import Coroutine
from concurrent.futures import TimeoutError as TooLong
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.grammar.diagnostics import SceneError

VARIABLE = "SCENELANG_BROWSER"
PACKAGES, INSTALL = ("playwright",), "scenelang[browser]"
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge")
_PLACES = {
    "darwin": (
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "/Applications/Chromium.app/Contents/MacOS/Chromium",
        "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    ),
    "win32": (
        r"C:\Program Files\Google\Chrome\Application\chrome.exe",
        r"C:\Program Files (x86)\Google\Chrome\Application\chrome.exe",
        r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
    ),
}
_FLAGS = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND",
)
# Bytes of a path: with the browser's own names, some 100 are too many. Below /tmp a folder of a new name is made.
_SHORT_FOLDER, _LONGEST_FOLDER = "/tmp", 50  # noqa: S108  # nosec B108
_ADDRESS = "http://build.invalid/"  # no such host: the page comes from memory
_LIMIT = 120.0  # seconds for the start of a browser with its page, or for one picture
_GRACE = 10.0  # seconds for a browser to end


def find_browser() -> str:
    """The path of a browser that can draw; raises SceneError("backend") where there is none."""
    named = os.environ.get(VARIABLE)
    if named:
        found = shutil.which(named)
        if found is None:
            raise SceneError("backend", f"there is no browser `{named}`, which {VARIABLE} names")
        return found
    known = [path for name in _NAMES if (path := shutil.which(name))]
    known += [path for path in _PLACES.get(sys.platform, ()) if Path(path).is_file()]
    if not known:
        raise SceneError(
            "backend",
            "there is no Chromium or Chrome on this machine",
            hint=f"install one, or name its program in {VARIABLE}",
        )
    return known[0]


def _short_folder() -> str:
    """The folder for passing files: browsers put sockets there, whose paths the system bounds."""
    usual = tempfile.gettempdir()
    is_short = os.name == "nt" or len(os.fsencode(usual)) <= _LONGEST_FOLDER
    return usual if is_short or not os.access(_SHORT_FOLDER, os.W_OK) else _SHORT_FOLDER


def _no_start(executable: str, said: str) -> SceneError:
    """The error for a browser that ended at once; ``said`` is playwright's report, with what the browser wrote."""
    written = [line.partition("[err] ")[2].strip() for line in said.splitlines() if "[err] " in line]
    reason = f": {written[0]}" if written else ""
    return SceneError(
        "backend",
        f"the browser `{executable}` does not start{reason}",
        hint=f"name the program of Chromium, Chrome or Edge in {VARIABLE}",
    )


class Browser:
    """A browser that shows ``page`` (HTML text); it ends with ``close``, with this object, or with the process.

    Raises SceneError("backend") where no browser starts or the page does not come up in time.
    """

    def __init__(self, page: str, limit: float = _LIMIT) -> None:
        self._driving = _Driving(page, find_browser(), need("playwright.async_api", INSTALL))
        self._limit = limit
        self.close = weakref.finalize(self, self._driving.end)
        self._wait(self._driving.start())

    def shoot(self, frame: int, camera: dict[str, Any], factor: int) -> bytes:
        """A PNG of ``frame`` from ``camera`` (JSON), ``factor`` times its size; raises SceneError("backend")."""
        return base64.b64decode(self._wait(self._driving.shoot(frame, camera, factor)))

    def _wait(self, work: Coroutine[Any, Any, Any]) -> Any:
        try:
            return self._driving.submit(work).result(self._limit)
        except TooLong:
            self.close()
            raise SceneError("backend", f"the browser took longer than {self._limit:g} seconds") from None
        except SceneError:
            self.close()
            raise
        except Exception as error:
            self.close()
            (line, *_) = str(error).strip().splitlines() or ["it ended"]
            raise SceneError("backend", f"the browser cannot draw: {line}") from error
        except BaseException:  # Ctrl-C
            self.close()
            raise


class _Driving:
    """What runs in the thread."""

    def __init__(self, page: str, executable: str, playwright: Any) -> None:
        self._html, self._executable, self._playwright = page, executable, playwright
        self._folder = _short_folder()
        self._profile = tempfile.mkdtemp(prefix="scenelang-browser-", dir=self._folder)
        self._driver: Any = None
        self._context: Any = None
        self._page: Any = None
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def submit(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    async def start(self) -> None:
        self._driver = await self._playwright.async_playwright().start()
        try:
            self._context = await self._launched()
        except self._playwright.Error as error:
            raise _no_start(self._executable, str(error)) from error
        await self._context.route("**/*", self._answer)
        self._page = await self._context.new_page()
        self._page.set_default_timeout(0)  # the limit is the one above
        await self._page.goto(_ADDRESS)
        await self._page.wait_for_selector("body[data-ready]", state="attached")
        if await self._page.get_attribute("body", "data-ready") != "yes":
            raise SceneError("backend", await self._page.inner_text("#message"))

    async def _launched(self) -> Any:
        return await self._driver.chromium.launch_persistent_context(
            self._profile,
            executable_path=self._executable,
            headless=True,
            args=list(_FLAGS),
            env={**os.environ, "TMPDIR": self._folder},
            handle_sigint=False,
            service_workers="block",
            accept_downloads=False,
            viewport={"width": 64, "height": 64},
        )

    async def shoot(self, frame: int, camera: dict[str, Any], factor: int) -> str:
        shot = "([frame, camera, factor]) => window.shoot(frame, camera, factor)"
        return str(await self._page.evaluate(shot, [frame, camera, factor]))

    async def _answer(self, route: Any) -> None:
        url = route.request.url
        if url == _ADDRESS:
            await route.fulfill(body=self._html, content_type="text/html; charset=utf-8")
        elif url.startswith("data:"):
            await route.continue_()
        else:
            await route.abort()

    def end(self) -> None:
        """End the browser and remove its profile, whatever it is doing."""
        try:
            self.submit(self._stop()).result(_GRACE)
        except Exception:  # noqa: S110  # nosec B110
            pass  # it is gone, or hangs: its driver ends with the pipe
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_GRACE)
        shutil.rmtree(self._profile, ignore_errors=True)

    async def _stop(self) -> None:
        if self._context is not None:
            await self._context.close()
        if self._driver is not None:
            await self._driver.stop()
