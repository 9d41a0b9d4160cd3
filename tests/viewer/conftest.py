"""Programs in a viewer: the workspace and the server in this process, the page in a real browser without a window."""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import chromium_path

from scenelang.session.session import Options, Session
from scenelang.viewer.server import ViewServer
from scenelang.viewer.workspace import Workspace, evaluator

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
WAIT = 60_000  # milliseconds: the picture is drawn by the processor here


def open_session(file: str, values: Any) -> Session:
    return Session(Options(defines=dict(values)))


@pytest.fixture
def program(tmp_path: Path) -> Callable[..., Path]:
    """Writes a program; a second call with the same name replaces it."""

    def write(text: str, name: str = "a.scene") -> Path:
        path = tmp_path / name
        whole = path.with_suffix(".part")  # replaced in one step, as editors do: the watcher never reads half a file
        whole.write_bytes(text.encode())
        whole.replace(path)
        return path

    return write


@pytest.fixture
def workspace() -> Callable[..., Workspace]:
    return lambda *files, limit=2_000_000: Workspace([str(file) for file in files], evaluator(open_session, limit))


@pytest.fixture
def serve(workspace: Callable[..., Workspace]) -> Iterator[Callable[..., ViewServer]]:
    """Starts servers for files; they end with the test."""
    servers: list[ViewServer] = []

    def start(*files: Path, **options: Any) -> ViewServer:
        server = ViewServer(workspace(*files, **options))
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        servers.append(server)
        return server

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium; the tests that want it are skipped where there is none. While its driver is there an event loop runs,
    so that it ends with the module: tests that come next may have a loop of their own."""
    executable = chromium_path()
    if executable is None:
        pytest.skip("there is no chromium, so the page was not driven; `make test` installs it where it may")
    playwright = pytest.importorskip("playwright.sync_api", reason="the page is driven with the package playwright")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=executable, args=FLAGS)
        yield chromium
        chromium.close()


class Shown:
    """A page that shows scenes. It must not complain in its console, nor ask anything but its own server."""

    def __init__(self, browser: Any, address: str, size: tuple[int, int]) -> None:
        self.context = browser.new_context(viewport={"width": size[0], "height": size[1]})
        self.context.grant_permissions(["clipboard-read", "clipboard-write"])
        self.page = self.context.new_page()
        self.page.set_default_timeout(WAIT)
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", lambda said: self.complaints.append(said.text) if said.type == "error" else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)

    def ready(self) -> Shown:
        """Waits until a scene, or its mistakes, are there and the picture stands still."""
        self.page.wait_for_selector("body[data-version]", state="attached")
        return self.settled()

    def settled(self) -> Shown:
        self.page.wait_for_selector("body[data-refined=yes]", state="attached")
        return self

    def version(self) -> int:
        return int(self.page.get_attribute("body", "data-version"))

    def after(self, action: Callable[[], Any]) -> Shown:
        """Does something that changes the scene and waits for the next version."""
        before = self.version()
        action()
        end = time.monotonic() + WAIT / 1000
        while self.version() == before and time.monotonic() < end:
            self.page.wait_for_timeout(30)
        assert self.version() > before
        return self.settled()

    def text(self, selector: str) -> str:
        return str(self.page.locator(selector).inner_text())

    def picture(self) -> Any:
        """The canvas without labels and focus: (H, W, 3), 8-bit sRGB."""
        from PIL import Image

        hide = "() => { document.getElementById('labels').style.visibility = 'hidden'; document.activeElement.blur(); }"
        self.page.evaluate(hide)
        with Image.open(io.BytesIO(self.page.locator("#canvas").screenshot())) as image:
            return np.asarray(image.convert("RGB"))

    def drawn(self) -> int:
        """How many pixels of the canvas differ from the backdrop in hue: things, not their shadows on the ground."""
        picture = self.picture().astype(int)
        return int((picture.max(axis=2) - picture.min(axis=2) > 30).sum())


@pytest.fixture
def show(browser: Any) -> Iterator[Callable[..., Shown]]:
    """Opens addresses; what a page complained of fails the test."""
    pages: list[Shown] = []

    def open_page(address: str, size: tuple[int, int] = (820, 480)) -> Shown:
        pages.append(Shown(browser, address, size))
        return pages[-1]

    yield open_page
    for shown in pages:
        shown.context.close()
        assert shown.complaints == []
