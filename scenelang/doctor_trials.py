"""Small works that are really done, one after the other, in a process of their own: a native library that crashes takes
only that process with it. ``python -P -m scenelang.doctor_trials NAME ...`` prints a line of JSON before each and one
after it."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from scenelang.backends import base
from scenelang.backends.base import Backend, Work
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.session import Session

_PROGRAM = '(bind "trial" (lambda () (union (call "cube") (call "sphere" :color [1 0 0]))))'
_SIDE = 16  # pixels
LANGUAGE, PICTURE, VIEWER = "language", "draft", "viewer"
FILMS = {"film .gif": ".gif", "film .mp4": ".mp4"}


def trials() -> Mapping[str, Callable[[Path], str]]:
    """Every trial by name: it works in a folder, says what came out, and raises where nothing did."""
    found: dict[str, Callable[[Path], str]] = {LANGUAGE: _evaluate, PICTURE: _draw, VIEWER: _view}
    found |= {name: partial(_film, ending) for name, ending in FILMS.items()}
    return found | {backend.name: partial(_export, backend) for backend in base.every(Work.EXPORT)}


def _scene() -> Scene:
    return _evaluated(_PROGRAM)


def _evaluated(text: str) -> Scene:
    result = Session().evaluate(Source("<trial>", text))
    if result.scene is None:
        raise SceneError("value", "; ".join(diagnostic.message for diagnostic in result.diagnostics))
    return result.scene


def _build() -> Scene:
    """A scene for backends that write nothing but blocks."""
    return _evaluated('(bind "trial" (lambda () (call "set-cuboid" :block-type "stone" :scale [3 2 1])))')


def _evaluate(folder: Path) -> str:
    return f"evaluates a scene of {len(_scene().root.children)} parts"


def _draw(folder: Path) -> str:
    from scenelang.backends.pictures.film import PictureOptions, render, save_picture

    path = folder / "trial.png"
    save_picture(render(_scene(), PictureOptions(width=_SIDE, height=_SIDE)), path)
    return f"draws a picture of {_SIDE}x{_SIDE} pixels ({path.stat().st_size} bytes)"


def _film(ending: str, folder: Path) -> str:
    from scenelang.backends.pictures.film import PictureOptions, painters, picture_backend, save_film
    from scenelang.backends.pictures.stage import still

    scene, options = _scene(), PictureOptions(width=_SIDE, height=_SIDE)
    shots = [still(scene, options.camera, None, _SIDE, _SIDE)] * 2
    path = folder / f"trial{ending}"
    save_film(painters(scene, options, [picture_backend("draft")], shots), shots, path)
    return f"writes a film ({path.stat().st_size} bytes)"


def _view(folder: Path) -> str:
    from scenelang.backends.viewer.page import STATIC, served_page, static

    size = len(served_page()) + sum(len(static(name)) for name in STATIC)
    return f"its page is complete ({size:,} bytes)"


def _export(backend: Backend, folder: Path) -> str:
    path = folder / f"trial{backend.endings[0]}"
    scene = _scene() if backend.accepts.any_word else _build()
    written = backend.run(scene, path, base.BackendOptions()) or [path]
    return f"writes {' '.join(backend.endings)} ({sum(each.stat().st_size for each in written)} bytes)"


def main(names: list[str]) -> int:
    """Run the trials of these names, or all."""
    known = trials()
    for name in names or known:
        _say({"name": name})
        try:
            with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
                _say({"name": name, "ok": True, "detail": known[name](Path(folder))})
        except SceneError as error:
            _say({"name": name, "ok": False, "detail": error.message})
        except Exception as error:  # a backend may be anybody's
            _say({"name": name, "ok": False, "detail": f"{type(error).__name__}: {error}"})
    return 0


def _say(line: Mapping[str, object]) -> None:
    print(json.dumps(line), flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
