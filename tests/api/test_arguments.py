"""Wrong arguments of the Python API are SceneErrors in the caller's terms, whatever they are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenelang as sl

TEXT = '(bind "a" (lambda () (call "cube")))'
WRONG: dict[str, Callable[[sl.Scene], Any]] = {
    "seed: expected a whole number from 0": lambda _: sl.evaluate(TEXT, seed=-1),
    "seed: expected a whole number, got 1.5": lambda _: sl.evaluate(TEXT, seed=1.5),  # type: ignore[arg-type]
    "path: expected a path": lambda _: sl.load(4),  # type: ignore[arg-type]
    "text: expected a string": lambda _: sl.evaluate(None),  # type: ignore[arg-type]
    "defines: expected a mapping": lambda _: sl.evaluate(TEXT, defines=[1]),  # type: ignore[arg-type]
    "limits: expected Limits": lambda _: sl.evaluate(TEXT, limits={"steps": 3}),  # type: ignore[arg-type]
    "seconds: expected a limit of at least 0": lambda _: sl.Limits(seconds=-3),
    "a: expected a Scene": lambda _: sl.diff("a.scene", "b.scene"),  # type: ignore[arg-type]
    "tolerance: expected a finite number": lambda s: s.diff(s, tolerance=float("nan")),
    "tolerance: expected a number of at least 0": lambda s: s.diff(s, tolerance=-1),
    "word: expected a string": lambda s: s.bounds_of(4),
    "number: expected a whole number": lambda s: s.frame("a"),
    "limit: expected a whole number": lambda s: s.flatten(limit="3"),
    "convention: expected 'opengl' or 'opencv'": lambda _: sl.Camera.from_pose(np.eye(4), convention="zz"),  # type: ignore[arg-type]
    "size: expected a size (width, height)": lambda s: s.render(size=(0, 10)),
    "size: expected a size (width, height) in pixels, such as (640, 480), got 10": lambda s: s.render(size=10),
    "quality: expected a name": lambda s: s.render(quality=None),
    "unknown quality or backend zz (available: draft, final": lambda s: s.render(quality="zz"),
    "camera: expected a camera": lambda s: s.render({"azimuth": 4}),
    "azimuth: expected a finite number": lambda _: sl.Camera(azimuth="x"),  # type: ignore[arg-type]
    "target: expected three finite numbers": lambda _: sl.Camera(target=(1, 2)),  # type: ignore[arg-type]
    "settings: expected a mapping": lambda s: s.render(settings=[1]),
    "progress: expected a function": lambda s: s.render(progress=3),
    "labels: expected True or False": lambda s: s.render(labels="no"),
    "roughness: expected": lambda s: s.restyled("cube", roughness="x"),
    "render: got an unexpected keyword argument": lambda s: s.render(wrong=3),
    "margin: expected at least 0": lambda s: s.maps(size=(8, 8)).crops(margin=-9),
    "nothing is made of the word": lambda s: s.maps(size=(8, 8)).mask("zz"),
}


@pytest.fixture(scope="module")
def scene() -> sl.Scene:
    return sl.evaluate(TEXT)


@pytest.mark.parametrize("expected", WRONG)
def test_a_wrong_argument_is_a_scene_error(expected: str, scene: sl.Scene) -> None:
    with pytest.raises(sl.SceneError) as caught:
        WRONG[expected](scene)
    said = caught.value.message.replace("`", "")
    if not expected.startswith("nothing"):
        assert expected in said


def test_numpy_numbers_and_lists_are_right(scene: sl.Scene) -> None:
    assert scene.render(size=[np.int64(8), 8]).size == (8, 8)  # type: ignore[arg-type]
    assert scene.render(sl.Camera(azimuth=np.float32(3)), size=(8, 8)).size == (8, 8)


def test_maps_are_not_saved_into_a_file(scene: sl.Scene, tmp_path: Path) -> None:
    (tmp_path / "a").write_text("")
    with pytest.raises(sl.SceneError, match="cannot create the folder"):
        scene.maps(size=(8, 8)).save(tmp_path / "a")


def test_representations_are_one_short_line(scene: sl.Scene) -> None:
    for thing in (scene, scene.placed(), scene.flatten(), scene.render(size=(8, 8)), sl.Camera(azimuth=4)):
        assert "\n" not in repr(thing)
        assert len(repr(thing)) < 120
