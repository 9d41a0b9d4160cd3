"""Entities and scenes in a notebook: a picture of themselves, and ``.view()`` for the interactive page.

Notebooks ask a value for ``_repr_png_``. The classes live below the backends and know nothing of pictures, so the front
door gives them these methods (``install``) when it makes the first scene.
"""

from __future__ import annotations

from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Entity, Scene

_WIDTH, _HEIGHT = 480, 360


class View:
    """The interactive page of a scene, for a notebook to show; ``html`` is the whole page, a file of its own."""

    __slots__ = ("_height", "html")

    def __init__(self, html: str, height: int) -> None:
        self.html = html
        self._height = height

    def _repr_html_(self) -> str:
        from scenelang.backends.viewer.page import frame

        return frame(self.html, self._height)

    def __repr__(self) -> str:
        return f"<view, {len(self.html):,} characters of HTML>"


def view(self: Entity | Scene, height: int = 520) -> View:
    """The scene to turn and look into, ``height`` pixels high; raises SceneError for a look that makes no sense."""
    from scenelang.backends.viewer.packet import packet_of
    from scenelang.backends.viewer.page import SavedScene, self_contained

    scene = _scene_of(self)
    state: dict[str, Any] = {"name": scene.word, "version": 1, "ok": True, "picture": 1}
    state |= {"diagnostics": [], "params": []}
    return View(self_contained([SavedScene(scene.word, state, packet_of(scene))]), height)


def install() -> None:
    """Give entities and scenes ``view`` and the method that notebooks look for."""
    for kind in (Entity, Scene):
        setattr(kind, "view", view)  # noqa: B010  the class does not declare what is above it
        setattr(kind, "_repr_png_", _png)  # noqa: B010


def _png(self: Entity | Scene) -> bytes | None:
    """A draft picture as PNG; None, so that the notebook shows the text, where there is nothing to draw."""
    from scenelang.backends.picture import PictureOptions, png_of, render

    try:
        return png_of(render(_scene_of(self), PictureOptions(width=_WIDTH, height=_HEIGHT)))
    except SceneError:
        return None


def _scene_of(value: Entity | Scene) -> Scene:
    return value if isinstance(value, Scene) else Scene(value.word, [value], False)
