"""Entities and scenes show themselves in notebooks."""

from __future__ import annotations

import html
import io
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from scenelang import Scene, evaluate

TEXT = '(bind "a" (lambda () (call "cube" :color [.8 .1 .1])))'


@pytest.mark.slow
def test_a_scene_and_an_entity_are_pictures() -> None:
    scene: Any = evaluate(TEXT)
    for value in (scene, Scene.of(scene.root), Scene.of(scene.root.children[0].car)):
        with Image.open(io.BytesIO(value._repr_png_())) as image:
            pixels = np.asarray(image.convert("RGB")).astype(int)
        assert ((pixels[:, :, 0] - pixels[:, :, 2]) > 60).sum() > 1000


def test_what_has_no_geometry_shows_as_text() -> None:
    scene: Any = evaluate('(bind "a" (lambda () (union)))')
    assert scene._repr_png_() is None
    assert repr(scene.root) == "<entity a>"


@pytest.mark.browser
def test_the_view_is_a_page_in_a_frame_of_its_own(tmp_path: Path, show: Callable[..., Any]) -> None:
    scene: Any = evaluate(TEXT)
    shown = scene.show(height=400)
    frame = shown._repr_html_()
    assert 'sandbox="allow-scripts"' in frame
    assert html.escape(shown.html) in frame
    page = tmp_path / "notebook.html"
    page.write_text(f"<!doctype html><meta charset=utf-8><body>{frame}", encoding="utf-8")
    opened = show(page.as_uri(), (900, 500))
    inner = opened.page.frame_locator("iframe")
    inner.locator("body[data-refined=yes]").wait_for(state="attached")
    with Image.open(io.BytesIO(inner.locator("#canvas").screenshot())) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    assert ((pixels[:, :, 0] - pixels[:, :, 2]) > 60).sum() > 1000


# --- the widget with an editor

WIDGET = (
    '(param size 1.0 :min 0.5 :max 2.0)\n(bind "ball" (lambda () (union (call "sphere" :radius size) (call "cube"))))\n'
)


class _Told:
    """A widget whose messages are kept."""

    def __init__(self, text: str) -> None:
        from scenelang.notebook.widget import StudioWidget

        self.studio = StudioWidget(text)
        self.messages: list[Any] = []
        self.studio.send = lambda content, buffers=None: self.messages.append((content, buffers))

    def ask(self, method: str, *values: Any) -> Any:
        self.studio._asked(self.studio, {"id": 1, "method": method, "values": list(values)}, [])
        content, buffers = self.messages[-1]
        return buffers[0] if buffers else content.get("result", content.get("error"))


def test_widget_answers_its_page() -> None:
    told = _Told(WIDGET)
    assert told.ask("state", 0)["ok"]
    assert told.ask("picture", 0)[:4] == b"SCNV"
    assert told.studio.params == {"size": 1.0}
    told.ask("edit", 0, WIDGET.replace("1.0", "1.5"))
    assert told.studio.text == WIDGET.replace("1.0", "1.5")
    assert told.studio.params == {"size": 1.5}
    assert told.studio.scene.bounds.tolist()[1][0] == 1.5
    told.ask("selected", "ball/cube")
    assert told.studio.selection == "ball/cube"
    assert not told.ask("edit", 0, "(call")["ok"]
    assert "horse" in told.ask("change", 0, WIDGET, {"path": "ball/horse", "move": [0, 1, 0]})
    before = len(told.messages)
    for wrong in ({}, "text", {"method": "_edit"}, {"method": "__init__", "values": []}):
        told.studio._asked(told.studio, wrong, [])
    assert len(told.messages) == before


def test_text_of_a_widget_is_assigned() -> None:
    told = _Told(WIDGET)
    told.studio.text = WIDGET.replace("1.0", "2.0")
    assert told.studio.params == {"size": 2.0}
    assert told.ask("text", 0)["text"] == WIDGET.replace("1.0", "2.0")


def test_widget_without_a_kernel_is_a_page() -> None:
    bundle = _Told(WIDGET).studio._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert "<iframe" in data["text/html"]


@pytest.mark.browser
def test_widget_in_a_browser(show: Any, tmp_path: Path) -> None:
    """The page in its frame, with a model that asks the widget: the kernel's part is played by this test."""
    from scenelang.notebook.widget import _SCRIPT

    told = _Told(WIDGET)
    shell = tmp_path / "index.html"
    shell.write_text("<!doctype html><title>cell</title><body></body>")
    shown = show(shell.as_uri(), (1100, 700))
    page = shown.page

    def answer(message: Any) -> Any:
        count = len(told.messages)
        told.studio._asked(told.studio, message, [])
        return [[content, [list(each) for each in buffers or []]] for content, buffers in told.messages[count:]]

    page.expose_function("kernel", answer)
    page.evaluate(
        """([script, html]) => {
          const handlers = {};
          const model = {
            get: (name) => ({ page: html, height: 560, text: "" })[name],
            on: (name, handler) => { handlers[name] = handler; },
            off: () => {},
            send: async (message) => {
              for (const [content, buffers] of await window.kernel(message)) handlers["msg:custom"](content, buffers.map((each) => new DataView(Uint8Array.from(each).buffer)));
            },
          };
          const url = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
          return import(url).then((module) => module.default.render({ model, el: document.body }));
        }""",
        [_SCRIPT, told.studio.page],
    )
    frame = page.frame_locator("iframe")
    frame.locator("body[data-version]").wait_for(state="attached")
    frame.locator("#summary", has_text="2 primitives").wait_for(state="attached")
    frame.locator(".cm-content").click()
    page.keyboard.press("Control+Home")
    page.keyboard.insert_text("; typed\n")
    end = time.monotonic() + 30
    while not told.studio.text.startswith("; typed") and time.monotonic() < end:
        page.wait_for_timeout(50)
    assert told.studio.text == "; typed\n" + WIDGET
