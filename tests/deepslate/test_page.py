"""The page as text: its data, its policy; the command that writes it; browsers that are not there."""

from __future__ import annotations

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from deepslate.packs import scene_of
from support import chromium_path

from scenelang.backends.base import find
from scenelang.backends.deepslate.backend import find_browser, page_of_scene
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError

PROGRAM = """(bind "build" (lambda () (transform (call "set-cuboid" :block-type "stone" :scale '(2 1 3)) (translate '(4 5 6)))))"""


def data_of(page: str) -> dict[str, Any]:
    (found,) = re.findall(r'<script type="application/json" id="build">(.*?)</script>', page, re.S)
    return dict(json.loads(found))


def test_the_page_holds_the_build(pack: Path) -> None:
    data = data_of(page_of_scene(scene_of('(block "stone" 4 5 6 2 1 3)'), str(pack)).text)
    values = np.frombuffer(gzip.decompress(base64.b64decode(data["cells"])), "<i4").reshape(5, -1)
    assert data["corner"] == [4, 5, 6]
    assert sorted(map(tuple, values[:3].T.tolist())) == [(x, 0, z) for x in range(2) for z in range(3)]
    assert set(values[3].tolist()) == {1}
    assert data["states"][1] == {
        "name": "minecraft:stone",
        "properties": {},
        "parts": [{"model": "minecraft:block/stone", "x": 0, "y": 0}],
        "isSpecial": False,
        "isWet": False,
    }
    assert data["frames"] == {"0": 0}
    assert data["box"]["low"] == [0, 0, 0]
    assert data["box"]["high"] == [2, 1, 3]
    assert data["box"]["center"] == [1.0, 0.5, 1.5]


def test_the_page_asks_for_nothing(pack: Path) -> None:
    text = page_of_scene(scene_of('(block "stone" 0 0 0 1 1 1)'), str(pack)).text
    assert "default-src &#x27;none&#x27;" in text
    assert "connect-src" not in text
    assert not re.search(r"<(?:script|link|img)[^>]+(?:src|href)=\"(?!data:)", text)


def test_markup_in_names_stays_text(pack: Path) -> None:
    text = """(bind "</script><script>x" (lambda () (call "set-cuboid" :block-type "stone" :scale '(1 1 1))))"""
    from scenelang.grammar.datum import Source
    from scenelang.session.session import Options, Session

    scene = Session(Options()).evaluate(Source("<test>", text)).scene
    assert scene is not None
    page = page_of_scene(scene, str(pack)).text
    assert data_of(page)["name"] == "</script><script>x"
    assert page.count("<script>") == 1


def test_view_writes_the_page(pack: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "a.scene"
    program.write_text(PROGRAM)
    out = tmp_path / "a.html"
    assert main(["view", str(program), "--minecraft", "--textures", str(pack), "--html", str(out)]) == 0
    assert data_of(out.read_text("utf-8"))["name"] == "build"
    assert str(out) in capsys.readouterr().out


def test_view_says_what_the_page_leaves_out(pack: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "a.scene"
    program.write_text('(bind "build" (lambda () (union (call "sphere") (call "set-cuboid" :block-type "stone"))))')
    out = tmp_path / "a.html"
    main(["view", str(program), "--minecraft", "--textures", str(pack), "--html", str(out)])
    assert "W617" in capsys.readouterr().err


def test_view_says_which_blocks_have_no_looks(pack: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "a.scene"
    both = '(union (call "set-cuboid" :block-type "stone") (transform (call "set-cuboid" :block-type "dirt") (translate [1 0 0])))'
    program.write_text(f'(bind "build" (lambda () {both}))')
    out = tmp_path / "a.html"
    assert main(["view", str(program), "--minecraft", "--textures", str(pack), "--html", str(out)]) == 0
    error = capsys.readouterr().err
    assert "W619" in error
    assert "`minecraft:dirt`" in error


@pytest.mark.parametrize("room", ["page", "backend"])
def test_looks_are_missed_before_the_build_is_laid(room: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def builds_of(*_: object) -> None:
        raise AssertionError("laid")

    monkeypatch.setattr("scenelang.backends.deepslate.backend.builds_of", builds_of)
    scene = scene_of('(block "stone" 0 0 0 1 1 1)')
    with pytest.raises(SceneError, match="Minecraft's textures were not found on this machine"):
        page_of_scene(scene) if room == "page" else render(scene, backend="deepslate")


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["--textures", "x"], 2, "requires `--minecraft`"),
        (["--minecraft", "--html", "a.png"], 2, "a page must be an .html file"),
        (["--minecraft", "--html", "a.html"], 1, "Minecraft's textures were not found on this machine"),
        (["--minecraft", "--html", "a.html", "--textures", "x"], 1, "the texture path `x` does not exist"),
    ],
)
def test_mistakes_are_said(
    arguments: list[str], code: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "a.scene"
    program.write_text(PROGRAM)
    assert main(["view", str(program), *arguments]) == code
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
    assert not Path("a.html").exists()


def test_the_backend_is_found() -> None:
    backend = find("deepslate")
    assert backend.endings == find("draft").endings
    assert backend.accepts.words == ("set-cuboid", "delete-blocks")


def test_without_textures_nothing_is_drawn() -> None:
    with pytest.raises(SceneError, match="Minecraft's textures were not found on this machine"):
        render(scene_of('(block "stone" 0 0 0 1 1 1)'), backend="deepslate")


def test_without_a_browser_the_user_is_told(pack: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("SCENELANG_BROWSER", raising=False)
    options = PictureOptions(settings={"textures": str(pack)})
    with pytest.raises(SceneError, match="no Chromium") as raised:
        render(scene_of('(block "stone" 0 0 0 1 1 1)'), options, "deepslate")
    assert "SCENELANG_BROWSER" in (raised.value.diagnostic.hint or "")


def test_a_browser_that_is_named_must_be_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCENELANG_BROWSER", "/nowhere/chromium")
    with pytest.raises(SceneError, match="the browser `/nowhere/chromium` given by SCENELANG_BROWSER does not exist"):
        find_browser()


@pytest.mark.browser
def test_the_page_is_turned_by_the_mouse(pack: Path, tmp_path: Path) -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    executable = chromium_path()
    if executable is None:
        pytest.skip("there is no chromium")
    saved = page_of_scene(scene_of('(block "stone" 0 0 0 3 1 1)'), str(pack))
    (tmp_path / "a.html").write_text(saved.text, "utf-8")
    flags = ["--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=executable, args=flags)
        page, errors = browser.new_page(viewport={"width": 300, "height": 200}), []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto((tmp_path / "a.html").as_uri())
        page.wait_for_selector("body[data-ready=yes]", state="attached", timeout=60_000)
        before = page.screenshot()
        page.mouse.move(150, 100)
        page.mouse.down()
        page.mouse.move(220, 110)
        page.mouse.up()
        page.wait_for_timeout(1000)
        after = page.screenshot()
        browser.close()
    assert errors == []
    assert before != after
