"""Entities and scenes show themselves in notebooks."""

from __future__ import annotations

import html
import io
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
