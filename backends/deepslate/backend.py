"""The deepslate backend: a headless browser that renders a build page with the game's models and textures."""

from __future__ import annotations

import asyncio
import base64
import gzip
import io
import os
import shutil
import sys
import tempfile
import threading
import weakref
from collections.abc import Coroutine, Mapping, Sequence
from concurrent.futures import TimeoutError as FutureTimeout
from contextlib import suppress
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Accepts, Option, Progress, Work, require
from scenelang.backends.deepslate.builds import WATER_TEXTURES, Builds, builds_of
from scenelang.backends.deepslate.looks import BlockLooks, layers_for, looks_of
from scenelang.backends.pictures.camera import Camera, Viewpoint, camera_to_json, place
from scenelang.backends.pictures.film import (
    STILL_ENDINGS,
    Image,
    Painter,
    Picture,
    PictureBackend,
    PictureOptions,
    write_still,
)
from scenelang.backends.pictures.stage import BELOW, Shot, Staging, box_of, unit_size
from scenelang.backends.surfaces.environments import Studio, studio_for, tone_map
from scenelang.backends.surfaces.image_files import from_srgb, to_srgb
from scenelang.backends.viewer.packet import inline_page
from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.primitives import block_words

# A headless browser installed by the user, for pictures of one page: without network, with a temporary profile. It is
# controlled from a separate thread, so that Ctrl-C and the time limit can interrupt it at any point, and so that it
# works in notebooks, which already run an event loop.


VARIABLE = "SCENELANG_BROWSER"
PACKAGES, INSTALL = ("playwright",), "scenelang[browser]"
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge")
_LOCATIONS = {
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
# Maximum bytes of a path: with the names added by the browser, paths over about 100 bytes fail. A new directory is
# created below /tmp.
_SHORT_FOLDER, _MAX_FOLDER = "/tmp", 50  # noqa: S108  # nosec B108
_ADDRESS = "http://build.invalid/"  # no such host: the page is served from memory
_TIMEOUT = 120.0  # seconds for starting a browser with its page, or for one picture
_EXIT_TIMEOUT = 10.0  # seconds for a browser to exit


def find_browser() -> str:
    """Return the path of a Chromium-based browser; raises SceneError("backend") if none is found."""
    named = os.environ.get(VARIABLE)
    if named:
        program = shutil.which(named)
        if program is None:
            raise SceneError("backend", f"the browser `{named}` given by {VARIABLE} does not exist")
        return program
    known = [path for name in _NAMES if (path := shutil.which(name))]
    known += [path for path in _LOCATIONS.get(sys.platform, ()) if Path(path).is_file()]
    if not known:
        raise SceneError(
            "backend",
            "no Chromium, Chrome or Edge was found on this machine",
            hint=f"install one, or set {VARIABLE} to the path of its executable",
        )
    return known[0]


def _short_folder() -> str:
    """Return the directory for temporary files; the paths of the browser's sockets are limited in length."""
    usual = tempfile.gettempdir()
    is_short = os.name == "nt" or len(os.fsencode(usual)) <= _MAX_FOLDER
    return usual if is_short or not os.access(_SHORT_FOLDER, os.W_OK) else _SHORT_FOLDER


def _no_start(executable: str, report: str) -> SceneError:
    """Return the error for a browser that exited at once; ``report`` is playwright's report with the browser's
    output."""
    written = [line.partition("[err] ")[2].strip() for line in report.splitlines() if "[err] " in line]
    reason = f": {written[0]}" if written else ""
    return SceneError(
        "backend",
        f"the browser `{executable}` does not start{reason}",
        hint=f"set {VARIABLE} to the path of the executable of Chromium, Chrome or Edge",
    )


class Browser:
    """A browser that shows ``page`` (HTML text), until ``close``, garbage collection or the end of the process.

    Raises SceneError("backend") if no browser starts or the page does not load in time.
    """

    def __init__(self, page: str, limit: float = _TIMEOUT) -> None:
        self._driving = _Driving(page, find_browser(), require("playwright.async_api", INSTALL))
        self._limit = limit
        self.close = weakref.finalize(self, self._driving.end)
        self._wait(self._driving.start())

    def shoot(self, frame: int, camera: dict[str, Any], factor: int) -> bytes:
        """Return a PNG of ``frame`` from ``camera`` (JSON), scaled by ``factor``; raises SceneError("backend")."""
        return base64.b64decode(self._wait(self._driving.shoot(frame, camera, factor)))

    def _wait(self, work: Coroutine[Any, Any, Any]) -> Any:
        try:
            return self._driving.submit(work).result(self._limit)
        except FutureTimeout:
            self.close()
            raise SceneError("backend", f"the browser took longer than {self._limit:g} seconds") from None
        except SceneError:
            self.close()
            raise
        except Exception as error:
            self.close()
            (line, *_) = str(error).strip().splitlines() or ["it exited"]
            raise SceneError("backend", f"the browser cannot draw: {line}") from error
        except BaseException:  # Ctrl-C
            self.close()
            raise


class _Driving:
    """The part of ``Browser`` that runs in the thread."""

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
        self._page.set_default_timeout(0)  # the limit of ``Browser`` applies
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
        """Stop the browser and remove its profile, whatever its state."""
        try:
            # what has exited has no pipe, and what hangs does not answer: its driver exits when the pipe closes
            with suppress(FutureTimeout, OSError, self._playwright.Error):
                self.submit(self._stop()).result(_EXIT_TIMEOUT)
        finally:
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(_EXIT_TIMEOUT)
            shutil.rmtree(self._profile, ignore_errors=True)

    async def _stop(self) -> None:
        if self._context is not None:
            await self._context.close()
        if self._driver is not None:
            await self._driver.stop()


# The page of a build: a self-contained HTML document that loads nothing.


FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PageSurroundings:
    """Surroundings of a build.

    ``center`` (3,) and ``scale`` bring the scene to unit size, ``lowest`` is its lowest point, all in program units;
    ``environment`` and ``ground`` are names of ``studio``.
    """

    center: FloatArray
    scale: float
    lowest: float
    environment: str = "studio"
    ground: str | None = None


@dataclass(frozen=True, slots=True)
class SavedPage:
    """A page as HTML, and warnings about content that it cannot show faithfully."""

    text: str
    warnings: tuple[Diagnostic, ...]


def page_of_scene(scene: Scene, textures: str = "", limit: int = 2_000_000) -> SavedPage:
    """Return the page of all frames of ``scene`` with the resource pack ``textures`` (empty: the default locations).

    Raises SceneError: for a scene without blocks, for poses that blocks do not support, and if no textures are found.
    """
    layers = layers_for(textures)  # checked first, since computing a build may take long
    builds = builds_of(dict(enumerate(scene.frames)), limit)
    looks = looks_of(builds.palette, layers)
    low, high = box_of(scene)
    around = PageSurroundings(*unit_size(scene), float(low[1]))
    text = page_of(scene.word, builds, looks, around, place(Viewpoint(), low, high, 512, 512))
    return SavedPage(text, (*builds.warnings, *looks.warnings))


def page_of(name: str, builds: Builds, looks: BlockLooks, around: PageSurroundings, camera: Camera) -> str:
    """Return the page that shows all frames of ``builds``; ``camera`` determines the direction of the light."""
    studio = studio_for(camera.rescaled(around.center, around.scale).right, around.environment, around.ground)
    data = _data(name, builds, looks, around, studio)
    return inline_page(_text("page.html"), _text("page.js"), _text("page.css"), "build", data)


@cache
def _text(name: str) -> str:
    return files(__package__).joinpath("static", name).read_text("utf-8")


def _data(name: str, builds: Builds, looks: BlockLooks, around: PageSurroundings, studio: Studio) -> dict[str, Any]:
    """Return the data of the page: block states, models, textures, surroundings, and the blocks of the frames."""
    low, high = builds.box
    has_water = all(name in looks.atlas.places for name in WATER_TEXTURES)
    states = [
        {
            "name": state.name,
            "properties": dict(state.properties),
            "parts": list(look.parts),
            "isSpecial": look.is_special,
            "isWet": look.is_wet and has_water,
        }
        for state, look in zip(builds.palette, looks.states, strict=True)
    ]
    # frames of the same entity share one object, which is written once
    distinct = {id(seen): seen for seen in builds.frames.values()}
    numbers = {key: i for i, key in enumerate(distinct)}
    planes = [
        plane.astype("<i4").tobytes() if plane.dtype == np.int32 else plane.astype("<u4").tobytes()
        for seen in distinct.values()
        for plane in (*seen.cells, seen.states, seen.around)
    ]
    return {
        "name": name,
        "states": states,
        "models": looks.models,
        "atlas": _atlas(looks),
        "corner": list(builds.corner),
        "box": {
            "low": list(low),
            "high": list(high),
            "center": (around.center - np.array(builds.corner)).tolist(),
            "scale": around.scale,
        },
        "studio": _studio(studio, around),
        "counts": [len(seen.states) for seen in distinct.values()],
        "frames": {str(number): numbers[id(seen)] for number, seen in builds.frames.items()},
        "cells": base64.b64encode(gzip.compress(b"".join(planes), 6, mtime=0)).decode(),
    }


def _atlas(looks: BlockLooks) -> dict[str, Any]:
    atlas = looks.atlas
    return {
        "image": "data:image/png;base64," + base64.b64encode(atlas.png).decode(),
        "side": atlas.side,
        "places": dict(atlas.places),
        "translucent": sorted(atlas.translucent),
    }


def _studio(studio: Studio, around: PageSurroundings) -> Mapping[str, Sequence[Any] | float | None]:
    """Return the surroundings as colors: sRGB of backdrop and ground, linear light on upward faces."""
    environment = studio.environment
    light = environment.on_level(studio.key_direction)
    ground = None if studio.ground is None else to_srgb(tone_map(studio.ground * light, environment)).tolist()
    return {
        "backdrop": to_srgb(tone_map(np.array(environment.backdrop), environment)).tolist(),
        "ground": ground,
        "height": float(around.lowest - around.center[1]) * around.scale - BELOW,
        "light": light.tolist(),
    }


_MAX_FACTOR = 3  # samples per pixel and axis
_MAX_SAMPLES = 4096 * 4096


class BuildPainter:
    """Takes pictures of one page in a browser, which is started for the first picture."""

    def __init__(self, staging: Staging, options: PictureOptions) -> None:
        self._staging = staging
        # checked first, since computing a build may take long
        layers = layers_for(DEEPSLATE.setting(options, "textures"))
        self._builds = builds_of(staging.asked, options.limit)
        self._looks = looks_of(self._builds.palette, layers)
        self._browser: Browser | None = None
        for warning in (*self._builds.warnings, *self._looks.warnings):
            if options.warn is not None:
                options.warn(warning)

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        if self._browser is None:
            self._browser = Browser(self._page(shot.camera))
        camera = shot.camera
        factor = next((n for n in range(_MAX_FACTOR, 1, -1) if n * n * camera.width * camera.height <= _MAX_SAMPLES), 1)
        png = self._browser.shoot(shot.frame, camera_to_json(camera), factor)
        if progress is not None:
            progress(1.0)
        return _image(png, camera, factor)

    def _page(self, camera: Camera) -> str:
        stage = self._staging
        around = PageSurroundings(stage.center, stage.scale, stage.lowest, stage.environment, stage.ground)
        return page_of("build", self._builds, self._looks, around, camera)


def _image(png: bytes, camera: Camera, factor: int) -> Image:
    """Return the picture of ``factor`` x ``factor`` samples per pixel, averaged in linear light."""
    with require("PIL.Image", "pillow").open(io.BytesIO(png)) as drawn:
        samples = np.asarray(drawn.convert("RGB"), np.uint8)
    light = from_srgb(np.arange(256) / 255.0).astype(np.float32)[samples]
    radiance = light.reshape(camera.height, factor, camera.width, factor, 3).mean(axis=(1, 3))
    picture: Picture = np.rint(255.0 * to_srgb(radiance)).astype(np.uint8)
    return Image(picture, radiance)


def _painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
    return BuildPainter(staging, options)


DEEPSLATE = PictureBackend(
    name="deepslate",
    doc="Minecraft builds with the game's models and textures, rendered in a browser",
    work=Work.PICTURE,
    endings=STILL_ENDINGS,
    run=write_still("deepslate"),
    options=(
        Option(
            "textures",
            "path of the game's jar, a resource pack or npm's minecraft-assets; by default the installed game",
            "",
        ),
    ),
    accepts=Accepts(words=block_words(), any_word=False, attributes=()),
    packages=(*PACKAGES, "PIL"),
    install=INSTALL,
    painter=_painter,
)
