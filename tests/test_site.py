"""The documentation site: it builds without warnings, needs no other host, and finds what it is asked for; pages that are
followed step by step show what their commands print."""

from __future__ import annotations

import functools
import io
import json
import re
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import copies
import pytest
from generator import walkthroughs
from generator.pictures import difference
from PIL import Image
from support import chromium_path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"


PAGES = [
    pytest.param(page, marks=pytest.mark.slow) if page == "tutorials/animation.md" else page
    for page in walkthroughs.PAGES
]


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.sampled(3)
def test_a_page_that_is_followed_shows_what_it_says(page: str) -> None:
    found = walkthroughs.follow(page, lambda words, folder: copies.command(*words, folder=folder))
    assert found.text == (DOCS / page).read_text("utf-8")
    assert found.images or "![" not in found.text
    for name, data in found.images.items():
        shown = DOCS / name
        if shown.suffix == ".png":
            assert difference(Image.open(io.BytesIO(data)).convert("RGB"), shown) < 2.0, name
        else:
            assert shown.stat().st_size == pytest.approx(len(data), rel=0.1), name


def test_a_command_that_fails_unannounced_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text("(")
    with pytest.raises(RuntimeError, match="E101"):
        walkthroughs.output("scenelang check a.scene", tmp_path)
    assert "E101" in walkthroughs.output("scenelang check a.scene # fails", tmp_path)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mkdocs")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("site")
    config = load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder), strict=True)
    config.plugins.on_startup(command="build", dirty=False)
    build(config)
    return folder


def test_every_page_is_in_the_site_and_loads_nothing_from_elsewhere(site: Path) -> None:
    pages = {path.relative_to(DOCS).with_suffix(".html") for path in DOCS.rglob("*.md")}
    built = {path.relative_to(site) for path in site.rglob("*.html")}
    assert pages <= built
    for page in built:
        text = (site / page).read_text("utf-8")
        assert not re.findall(r'<(?:script|img|iframe)[^>]* src="?(?:https?:)?//[^" >]+', text), page
        assert not re.findall(r'<link[^>]*rel="?(?:stylesheet|icon|preconnect)"?[^>]*href="?(?:https?:)?//', text), page


def test_search_works_from_files(site: Path) -> None:
    text = (site / "search" / "search_index.js").read_text("utf-8")
    index = json.loads(text.removeprefix("var __index = "))
    found = [page["location"] for page in index["docs"] if "union-loop" in page["text"]]
    assert any(location.startswith("reference/paper.html") for location in found)
    assert "iframe-worker.js" in (site / "index.html").read_text("utf-8")


def test_the_gallery_has_the_source_of_every_example(site: Path) -> None:
    text = (site / "gallery.html").read_text("utf-8")
    shown = re.findall(r"examples/([\w/-]+)\.scene", text)
    examples = {path.stem for path in (ROOT / "examples").glob("*.scene")}
    assert {Path(name).name for name in shown} >= examples
    for name in ("chessboard", "orrery"):
        assert "<canvas" in (site / "live" / f"{name}.html").read_text("utf-8")


@pytest.mark.slow
def test_questions_lead_to_an_accepted_page(site: Path) -> None:
    """Questions that people typed, in Chromium: at least 42 of 45 have an accepted page among the first three."""
    sync_api = pytest.importorskip("playwright.sync_api")
    executable = chromium_path()
    if executable is None:
        pytest.skip("there is no chromium, so the search was not driven")
    rows = [line.split("\t") for line in (Path(__file__).parent / "site" / "questions.tsv").read_text().splitlines()]
    handler = functools.partial(QuietHandler, directory=str(site))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server, sync_api.sync_playwright() as driver:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}/"
        page = driver.chromium.launch(executable_path=executable, args=["--no-sandbox"]).new_page()
        page.goto(f"{address}index.html")
        missed = [question for question, accepted in rows if not answered(page, address, question, accepted.split())]
        server.shutdown()
    assert len(rows) == 45
    assert len(missed) <= 3, missed


class QuietHandler(SimpleHTTPRequestHandler):
    """Serves files without writing lines about it."""

    def log_message(self, *_: object) -> None:
        """Write nothing."""


def answered(page: Any, address: str, question: str, accepted: list[str]) -> bool:
    """Type a question into the search; whether an accepted page, or section of it, is among the first three results."""
    page.fill(".md-search__input", "")
    page.click(".md-search__input")
    page.keyboard.type(question)
    page.wait_for_timeout(900)  # the search waits for the end of typing, and shows what it has then
    items = page.eval_on_selector_all(
        ".md-search-result__item", "items => items.map(i => [...i.querySelectorAll('a')].map(a => a.href))"
    )
    places = [link.removeprefix(address) for links in items[:3] for link in links]
    places = [re.sub(r"\?[^#]*", "", place) for place in places]
    return any(place in accepted or place.partition("#")[0] in accepted for place in places)
