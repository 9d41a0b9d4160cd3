"""Pictures by the backend ``splats`` beside draft ones of the same scene."""

from __future__ import annotations

import numpy as np
import pytest
from later import later
from support import evaluate

from scenelang.backends.base import find
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.grammar.diagnostics import SceneError

torch = later("torch")

SCENE = """(bind "a" (lambda () (union
  (call "cube" :scale [4 0.2 4] :color [0.2 0.5 0.2])
  (transform (call "sphere" :radius 0.8 :color [0.9 0.1 0.1]) (translate [-0.8 0.9 0]))
  (transform (call "cylinder" :radius 0.5 :p0 [0 0 0] :p1 [0 1.5 0] :color [0.1 0.2 0.9]) (translate [1 0.1 0.5])))))"""


def options(**more: object) -> PictureOptions:
    return PictureOptions(width=96, height=80, **more)  # type: ignore[arg-type]


def test_a_picture_is_like_the_draft() -> None:
    """The same framing, shapes, colors, light and shadow: only edges are softer."""
    scene = evaluate(SCENE)
    draft = render(scene, options()).astype(float)
    drawn = render(scene, options(settings={"gaussians": 20_000}), "splats").astype(float)
    assert drawn.shape == (80, 96, 3)
    assert np.abs(drawn - draft).mean() < 5.0
    assert np.median(np.abs(drawn - draft)) < 3.0


def test_an_unlit_picture_has_the_scenes_colors() -> None:
    scene = evaluate('(bind "a" (lambda () (call "cube" :scale 1 :color [0.5 0.25 1])))')
    drawn = render(scene, options(environment="flat"), "splats")
    draft = render(scene, options(environment="flat"))
    assert np.abs(drawn[40, 48].astype(int) - draft[40, 48]).max() <= 4


def test_frames_differ_and_pictures_repeat() -> None:
    scene = evaluate(SCENE)
    first, again = (render(scene, options(settings={"gaussians": 5_000}), "splats") for _ in range(2))
    np.testing.assert_array_equal(first, again)
    other = render(scene, options(settings={"gaussians": 5_000}, seed=1), "splats")
    assert (first != other).any()


def test_see_through_things_show_what_is_behind() -> None:
    text = '(bind "a" (lambda () (call "sphere" :radius 1 :color [1 0 0] :opacity 0.3)))'
    shown = [render(evaluate(text), options(ground="none"), backend).astype(float) for backend in ("draft", "splats")]
    assert np.abs(shown[0] - shown[1])[35:45, 43:53].mean() < 20.0


def test_words_without_geometry_are_labeled() -> None:
    scene = evaluate('(bind "a" (lambda () (call "chair" :scale 1)))')
    plain, labeled = (render(scene, options(labels=labels), "splats") for labels in (False, True))
    assert (plain != labeled).any()


def test_the_number_of_gaussians_is_bounded() -> None:
    with pytest.raises(SceneError, match="gaussians"):
        render(evaluate(SCENE), options(settings={"gaussians": 10**9}), "splats")


def test_the_backends_are_found() -> None:
    assert find("splats").endings[0] == ".png"
    assert find("splat").endings == (".splat",)
    assert find("splats-ply").endings == (".ply",)
