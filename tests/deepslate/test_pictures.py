"""Pictures from a real browser (`make test-browser`): with a pack that the tests make, and with the game's own looks."""

from __future__ import annotations

import io
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from deepslate.packs import pack_files, scene_of, wet_files, write_zip
from PIL import Image
from support import interruptible

from scenelang.backends.deepslate.backend import Browser, PageSurroundings, find_browser, page_of
from scenelang.backends.deepslate.builds import Builds, seen
from scenelang.backends.deepslate.looks import layers_for, looks_of
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build, load_table
from scenelang.backends.pictures.camera import camera_to_json, parse_viewpoint, place
from scenelang.backends.pictures.film import Picture, PictureOptions, render
from scenelang.grammar.diagnostics import SceneError

pytestmark = pytest.mark.browser
STEPS = """(union (block "stone" 0 0 0 7 1 5) (block "stone" 0 1 0 3 2 5) (block "oak_log" 5 1 1 1 4 1))"""


@pytest.fixture(scope="module", autouse=True)
def _browser() -> None:
    try:
        find_browser()
    except SceneError as error:
        pytest.skip(error.message)
    pytest.importorskip("playwright.async_api")


@pytest.fixture
def draw(pack: Path) -> Callable[..., Picture]:
    def picture(body: str, textures: Path | None = pack, **more: Any) -> Picture:
        settings = {} if textures is None else {"textures": str(textures)}
        return render(scene_of(body), PictureOptions(width=240, height=180, settings=settings, **more), "deepslate")

    return picture


def things(picture: Picture) -> Any:
    """Where a picture with the flat light differs from its white backdrop."""
    return picture.min(axis=2) < 250


@pytest.mark.parametrize("view", ["azimuth=30,elevation=25", "top", "isometric", "azimuth=200,elevation=-30,fov=70"])
def test_framing_is_that_of_draft_pictures(view: str, draw: Callable[..., Picture]) -> None:
    camera = parse_viewpoint(view)
    ours = things(draw(STEPS, camera=camera, environment="flat"))
    options = PictureOptions(width=240, height=180, camera=camera, environment="flat")
    theirs = things(render(scene_of(STEPS), options))
    assert theirs.mean() > 0.1
    assert (ours != theirs).mean() < 0.01, "only edges may differ"


def test_colors_are_those_of_the_textures(draw: Callable[..., Picture]) -> None:
    picture = draw('(block "stone" 0 0 0 1 1 1)', camera=parse_viewpoint("top"), environment="flat")
    assert np.abs(picture[90, 120].astype(int) - 120).max() <= 1


def test_glass_is_seen_through(draw: Callable[..., Picture]) -> None:
    body = '(union (block "oak_log" 0 0 0 3 1 3) (block "glass" 0 3 0 3 1 3))'
    covered = draw(body, camera=parse_viewpoint("top"), environment="flat")[90, 120].astype(int)
    log = np.array([110, 80, 40]) * 80 // 100
    assert (covered > log).all()
    assert covered[0] > covered[2], "the log's brown shows"


def test_water_is_blended_as_in_the_game(draw: Callable[..., Picture], tmp_path: Path) -> None:
    pack = write_zip(tmp_path / "wet.zip", pack_files() | wet_files())
    body = '(union (block "stone" 0 0 0 3 1 3) (block "water" 0 1 0 3 1 3))'
    drawn = draw(body, textures=pack, camera=parse_viewpoint("top"), environment="flat")[90, 120]
    alpha = 180 / 255
    expected = alpha * np.array([0x3F, 0x76, 0xE4]) + (1 - alpha) * np.array([120, 120, 120])
    assert np.abs(drawn - expected).max() <= 2


def test_what_stands_in_water_shows_through(draw: Callable[..., Picture], tmp_path: Path) -> None:
    pack = write_zip(tmp_path / "wet.zip", pack_files() | wet_files())
    top = {"camera": parse_viewpoint("top"), "environment": "flat", "textures": pack}
    alone, wet, drowned = (draw(body, **top) for body in (
        '(block "oak_fence" 1 0 1 1 1 1)',
        """(transform (call "set-cuboid" :block-type "oak_fence" :block-kwargs '(("waterlogged" "true"))) (translate '(1 0 1)))""",
        """(union (block "water" 0 0 0 3 1 3)
             (transform (call "set-cuboid" :block-type "oak_fence" :block-kwargs '(("waterlogged" "true"))) (translate '(1 0 1))))""",
    ))  # fmt: skip
    assert np.abs(alone[90, 120].astype(int) - 120).max() <= 1
    assert (wet[90, 120] == alone[90, 120]).all(), "the post ends above the water"
    assert (drowned[90, 120] == alone[90, 120]).all()


def test_no_block_of_the_game_vanishes(pack: Path) -> None:
    """Every block by itself, with the game's own looks."""
    try:
        layers = layers_for("")
    except SceneError as error:
        pytest.skip(error.message)
    kinds = [kind for kind in load_table().blocks.values() if kind.color is not None]
    palette = (AIR_STATE, *(BlockState(kind.name, tuple(sorted(kind.defaults.items()))) for kind in kinds))
    alone = np.ones((1, 1, 1), np.uint32)
    frames = {
        n: replace(seen(Build((0, 0, 0), alone, (AIR_STATE, state)), (0, 0, 0)), states=np.array([n], np.uint32))
        for n, state in enumerate(palette)
        if n > 0
    }
    camera = place(parse_viewpoint("azimuth=30,elevation=25"), np.zeros(3), np.ones(3), 48, 48)
    around = PageSurroundings(np.full(3, 0.5), 1.0, 0.0, "flat", None)
    page = page_of("blocks", Builds(frames, (0, 0, 0), palette, ()), looks_of(palette, layers), around, camera)
    browser = Browser(page)
    for n, state in enumerate(palette):
        if n > 0:
            with Image.open(io.BytesIO(browser.shoot(n, camera_to_json(camera), 1))) as drawn:
                assert (np.asarray(drawn.convert("RGB")).min(axis=2) < 250).any(), state


def test_frames_of_a_film_differ(pack: Path) -> None:
    scene = scene_of('(frames (list (block "stone" 0 0 0 1 1 1) (block "stone" 4 0 0 1 1 1)))')
    pictures = [
        render(scene, PictureOptions(frame=n, width=200, height=100, settings={"textures": str(pack)}), "deepslate")
        for n in (0, 1)
    ]
    assert np.abs(pictures[0].astype(int) - pictures[1]).max() > 50


def test_the_games_own_looks_have_no_missing_textures(draw: Callable[..., Picture]) -> None:
    try:
        layers_for("")
    except SceneError as error:
        pytest.skip(error.message)
    blocks = ["grass_block", "oak_leaves", "oak_stairs", "oak_fence", "glass", "water", "oak_door", "chest", "torch"]
    body = " ".join(f'(block "{name}" {2 * i} 0 0 1 1 1)' for i, name in enumerate(blocks))
    picture = draw(f"(union {body})", textures=None).astype(int)
    magenta = (picture[:, :, 0] > 150) & (picture[:, :, 2] > 150) & (picture[:, :, 1] < 80)
    assert not magenta.any()
    assert (np.ptp(picture, axis=2) > 40).mean() > 0.02


def test_a_page_that_asks_elsewhere_gets_nothing_and_one_that_hangs_is_ended() -> None:
    page = """<!doctype html><body data-ready="yes"><script>
    window.shoot = async () => { try { await fetch("http://127.0.0.1:1/"); return btoa("came"); } catch { return btoa("refused"); } };
    </script>"""
    assert Browser(page).shoot(0, {}, 1) == b"refused"
    before = profiles()
    hanging = Browser("<!doctype html><body data-ready='yes'><script>window.shoot = () => { for (;;); }</script>", 8.0)
    start = time.monotonic()
    with pytest.raises(SceneError, match="took longer than 8 seconds"):
        hanging.shoot(0, {}, 1)
    assert time.monotonic() - start < 40
    assert profiles() <= before


def test_a_page_that_fails_says_why() -> None:
    page = "<!doctype html><body data-ready='no'><p id='message'>no WebGL here</p>"
    with pytest.raises(SceneError, match="no WebGL here"):
        Browser(page)


def test_a_program_that_is_no_browser_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCENELANG_BROWSER", sys.executable)
    with pytest.raises(SceneError, match="does not start") as raised:
        Browser("<!doctype html>")
    assert f"`{sys.executable}`" in raised.value.message
    assert "SCENELANG_BROWSER" in (raised.value.diagnostic.hint or "")


@pytest.mark.skipif(os.name == "nt", reason="folders")
def test_a_temporary_folder_with_a_long_path_is_no_hindrance(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / ("x" * 100)
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    page = "<!doctype html><body data-ready='yes'><script>window.shoot = () => btoa('drawn');</script>"
    assert Browser(page).shoot(0, {}, 1) == b"drawn"


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_an_interruption_ends_the_browser_and_removes_its_profile(
    pack: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "a.scene"
    program.write_text('(bind "b" (lambda () (call "set-cuboid" :block-type "stone" :scale \'(2 2 2))))')
    command = [sys.executable, "-P", "-c", "from scenelang.__main__ import entry; entry()", "render", str(program),
               "--backend", "deepslate", "--textures", str(pack), "-o", str(tmp_path / "a.gif"), "--frames", "400",
               "--size", "900x900"]  # fmt: skip
    temporary = Path(tempfile.mkdtemp(prefix="b-"))  # short: browsers put sockets there
    monkeypatch.setenv("TMPDIR", str(temporary))
    with interruptible(command, tmp_path) as running:
        deadline = time.monotonic() + 60
        while not list(temporary.glob("scenelang-browser-*/Default")) and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(1.0)
        running.send_signal(signal.SIGINT)
        assert running.wait(40) == 130, running.communicate()
    assert not list(temporary.glob("scenelang-browser-*"))
    assert not (tmp_path / "a.gif").exists()
    if shutil.which("ps"):
        assert str(temporary) not in subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True).stdout
    shutil.rmtree(temporary)


def profiles() -> set[Path]:
    return set(Path(tempfile.gettempdir()).glob("scenelang-browser-*"))
