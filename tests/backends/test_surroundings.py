"""Scenes that are polished metal and glass have an environment for these, unless somebody names one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from silhouettes import EXAMPLES, loaded

import scenelang as sl
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.draft import draw as draft_of
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.pictures.stage import staging_of, still
from scenelang.backends.pictures.surroundings import environment_for, settled
from scenelang.interpreter.scene.entity import Scene


def scene_of(*balls: str, setup: str = "") -> Scene:
    """Return balls of one size in a row, seen from the side, with these attributes."""
    parts = "".join(
        f'(transform (call "sphere" :radius .45 {ball}) (translate [{k} 0 0]))' for k, ball in enumerate(balls)
    )
    return sl.evaluate(f'(bind "balls" (lambda () (union {parts}))) {setup}').graph


@pytest.mark.parametrize(
    "polished", [':material "chrome"', ":metallic 1 :roughness .1", ":metallic 1", ':material "glass"']
)
def test_polished_scenes_have_softboxes(polished: str) -> None:
    assert environment_for(scene_of(polished)) == "softboxes"


@pytest.mark.parametrize(
    "other",
    [
        "",
        ':material "oak"',
        ":metallic 1 :roughness .8",
        ":ior 1.5 :opacity .3 :roughness .7",
        ":opacity .3",
        ":roughness 0",
    ],
)
def test_other_scenes_have_the_studio(other: str) -> None:
    assert environment_for(scene_of(other)) == "studio"


@pytest.mark.parametrize(("matte", "expected"), [(1, "softboxes"), (3, "studio")])
def test_a_third_of_what_is_seen_must_be_polished(matte: int, expected: str) -> None:
    front = '(camera "front" :preset "elevation")'
    assert environment_for(scene_of(':material "gold"', *[""] * matte, setup=front)) == expected


def test_what_is_hidden_does_not_count() -> None:
    inside = sl.evaluate(
        '(bind "box" (lambda () (union (call "cube" :scale 3) (call "sphere" :radius 1 :material "gold"))))'
    ).graph
    assert environment_for(inside) == "studio"


def test_what_somebody_names_stays() -> None:
    gold = ':material "gold"'
    free = PictureOptions(width=8, height=8)
    assert settled(scene_of(gold), free).environment == "softboxes"
    stated = PictureOptions(width=8, height=8, stated=("environment",))
    assert settled(scene_of(gold), stated).environment == "studio"
    assert settled(scene_of(gold, setup='(environment "studio")'), free).environment == "studio"
    assert settled(scene_of(gold, setup='(environment "night")'), free).environment == "night"
    lit = scene_of(gold, setup='(light "lamp" :position [1 2 3])')
    assert settled(lit, free).environment == "studio"


def test_it_does_not_depend_on_the_camera() -> None:
    """A view of the golden half and one of the matte half have the same light, as images of one scene should."""
    half = scene_of(':material "gold"', "")
    names = {settled(half, PictureOptions(width=8, height=8, camera=Viewpoint(a))).environment for a in (-90.0, 90.0)}
    assert names == {"softboxes"}


@pytest.mark.parametrize(
    "program", ['(bind "a" (lambda () (union)))', '(bind "a" (lambda () (call "cube" :opacity 0 :metallic 1)))']
)
def test_a_scene_that_cannot_be_drawn_is_no_mistake_here(program: str) -> None:
    assert environment_for(sl.evaluate(program).graph) == "studio"


def test_both_studios_light_what_faces_up_alike(make: Any) -> None:
    plate = make.scene(make.primitive("cube", scale=(1, 0.02, 1), color=(0.6, 0.5, 0.4)))
    middles = []
    for name in ("studio", "softboxes"):
        options = PictureOptions(
            width=32, height=32, camera=Viewpoint(0, 89, distance=1.2), environment=name, stated=("environment",)
        )
        middles.append(draw(plate, options, picture_backend("draft")).picture[14:18, 14:18].astype(int))
    assert np.abs(middles[0] - middles[1]).max() <= 1


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_softboxes_give_polished_metal_more_shape(quality: str) -> None:
    """From the dark to the bright parts of a ball of chrome is more than twice as far as in the even studio."""
    ball = scene_of(':material "chrome"')
    spans = []
    for name in ("studio", "softboxes"):
        options = PictureOptions(
            width=64, height=64, environment=name, stated=("environment",), ground="none",
            settings={"samples": 16} if quality == "final" else {}, camera=Viewpoint(0, 0),
        )  # fmt: skip
        image = draw(ball, options, picture_backend(quality))
        rows, columns = np.mgrid[:64, :64] - 31.5
        seen = image.radiance[np.hypot(rows, columns) < 26].mean(axis=1)
        low, high = np.quantile(seen, (0.05, 0.95))
        spans.append(high / low)
    assert spans[1] > 2.0 * spans[0]


def test_a_picture_of_the_api_has_it() -> None:
    gold = sl.evaluate('(bind "a" (lambda () (call "sphere" :material "gold")))')
    default, named, studio = (
        np.asarray(gold.render(size=(32, 32), **given))
        for given in ({}, {"environment": "softboxes"}, {"environment": "studio"})
    )
    assert (default == named).all()
    assert (default != studio).any()


def test_all_frames_have_the_light_of_the_first() -> None:
    film = sl.evaluate('(bind "a" (lambda () (frames (list (call "sphere" :material "gold") (call "sphere")))))').graph
    assert settled(film, PictureOptions(width=8, height=8)).environment == "softboxes"


def test_drafts_of_metal_have_no_stripes() -> None:
    """On flat sides of gears, half open to the sky, lightness is nearly linear over four pixels: within two levels.

    The noise by which the light of the sky is sampled left stripes there, of which a tenth were steeper than three.
    """
    gears = loaded(EXAMPLES / "making" / "gear-pair.scene")
    stage = staging_of(gears, [0], 10_000).stage(still(gears, Viewpoint(), 0, 480, 360))
    drawn = draft_of(stage)
    shifted = [np.roll(drawn.normal, step, axis) for step in range(-3, 4) for axis in (0, 1)]
    flat = np.logical_and.reduce([np.abs(one - drawn.normal).max(axis=2) < 1e-4 for one in shifted]) & (drawn.ids >= 0)
    light = 255.0 * drawn.linear.mean(axis=2)
    bend = np.abs(np.roll(light, 2, 0) - 2.0 * light + np.roll(light, -2, 0))[flat]
    assert np.quantile(bend, 0.9) < 2.0
