"""Motion blur: poses between frames are closed forms, and what moves covers pixels for the share of time it is there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang.backends.pictures import draft
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.draft import Draft
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.pictures.motion_blur import INSTANTS, _poses_between, entities_between
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.flatten import flatten_entity

SIZE = 120


def frames(body: str, count: int = 3) -> str:
    return f'(bind "a" (lambda () (frames (for/list ((i (range {count}))) {body}))))'


def between(one: object, other: object, time: float) -> np.ndarray:
    pair = np.array([one, other], float).reshape(1, 2, 3, 4)
    return _poses_between(pair, [time])[0, 0]


@pytest.mark.parametrize("angle", [0.3, -1.2, 3.0, math.pi])
@pytest.mark.parametrize("time", [0.0, 0.25, 0.5, 1.0, 1.3])
def test_a_rotation_goes_on_by_a_part_of_its_angle(angle: float, time: float) -> None:
    axis = (1.0, 2.0, -0.5)
    start = pose.compose(pose.rotation(0.4, (0, 1, 0), (0, 0, 0)), pose.scaling(1, 2, 3, (0, 0, 0)))
    end = pose.compose(pose.rotation(angle, axis, (0, 0, 0)), start)
    wanted = pose.compose(pose.rotation(angle * time, axis, (0, 0, 0)), start)
    other_way = pose.compose(pose.rotation(-angle * time, axis, (0, 0, 0)), start)
    result = between(start, end, time).reshape(12)
    ways = [wanted, other_way] if angle == math.pi else [wanted]  # a half turn has two
    assert min(np.abs(result - np.array(way)).max() for way in ways) < 1e-9


def test_places_and_sizes_change_evenly() -> None:
    start, end = pose.translation(1, 2, 3), pose.compose(pose.translation(3, 2, -1), pose.scaling(2, 1, 1, (0, 0, 0)))
    assert between(start, end, 0.5) == pytest.approx(np.array([[1.5, 0, 0, 2], [0, 1, 0, 2], [0, 0, 1, 1]]))


@pytest.mark.parametrize("end", [(-1.0, 1, 1), (0.0, 1, 1)])
def test_reflections_and_flat_poses_change_linearly(end: tuple[float, float, float]) -> None:
    result = between(pose.scaling(1, 1, 1, (0, 0, 0)), pose.scaling(*end, (0, 0, 0)), 0.25)
    assert result[0, 0] == pytest.approx(1 + (end[0] - 1) * 0.25)
    assert np.isfinite(result).all()


def test_only_what_moves_is_made_anew_and_depth_has_no_limit() -> None:
    deep = "(letrec ((nest (lambda (n e) (if (= n 0) e (nest (- n 1) (transform e (translate [0 0 0])))))))"
    program = f"""(bind "still" (lambda () (call "cube")))
      (bind "a" (lambda () {deep} (frames (for/list ((i (range 2)))
        (union (call "still") (nest 3000 (transform (call "sphere") (translate (vector i 0 0))))))))))"""
    one, other = sl.evaluate(program).graph.frames
    (middle,) = entities_between(one, other, [0.5])
    assert middle.children[0].car is one.children[0].car
    assert flatten_entity(middle).matrices[1][:, 3] == pytest.approx([0.5, 0, 0])
    assert next(entities_between(one, one, [0.5])) is one


def test_an_entity_that_is_made_differently_stays() -> None:
    scene = sl.evaluate(frames('(call "sphere" :radius (+ 1 i))')).graph
    (middle,) = entities_between(scene.frames[0], scene.frames[1], [0.5])
    assert middle is scene.frames[0]


@pytest.mark.parametrize("quality", ["draft", "final"])
@pytest.mark.parametrize("shutter", [0.5, 1.0])
def test_what_moves_covers_pixels_for_the_share_of_time_that_it_is_there(shutter: float, quality: str) -> None:
    """A white cube of side 1 moves by 1 between frames before black: a trapezoid along x."""
    if quality == "final":
        pytest.importorskip("mitsuba")
    scene = sl.evaluate(frames('(transform (call "cube" :color [1 1 1]) (translate (vector i 0 0)))')).graph
    camera = Viewpoint(0.0, 0.0, orthographic=True, target=(1.0, 0.0, 0.0), distance=6.0)
    options = PictureOptions(width=SIZE, height=SIZE, camera=camera, environment="flat", background="black",
                             shutter=shutter, frame=1)  # fmt: skip
    row = draw(scene, options, picture_backend(quality)).radiance[SIZE // 2].mean(axis=1)
    sharp = draw(scene, PictureOptions(width=SIZE, height=SIZE, camera=camera, environment="flat", frame=1,
                                       background="black"), picture_backend(quality)).radiance[SIZE // 2].mean(axis=1)  # fmt: skip
    columns = np.flatnonzero(sharp > 0.5)
    left, side = columns[0], len(columns)
    x = (np.arange(SIZE) + 0.5 - left) / side  # 0 to 1 on the cube when the shutter opens
    there = np.clip(np.minimum(x, shutter) - np.maximum(x - 1.0, 0.0), 0.0, None) / shutter
    assert np.abs(row - there).max() < 1.0 / INSTANTS + 0.03
    assert np.abs(row - there).mean() < 0.02


def test_a_scene_at_rest_and_a_shutter_of_0_are_sharp() -> None:
    scene = sl.evaluate(frames('(call "cube" :color [.8 .2 .1])')).graph
    pictures = [
        draw(
            scene,
            PictureOptions(width=48, height=48, shutter=shutter, frame=1, ground="seamless"),
            picture_backend("draft"),
        ).picture
        for shutter in (0.0, 0.5)
    ]
    # Sharp images have the mean of tone-mapped samples at edges, blurred ones the tone-mapped mean.
    assert np.abs(pictures[0].astype(int) - pictures[1]).max() <= 2


def test_the_last_frame_goes_on_and_an_orbit_blurs_what_rests() -> None:
    program = frames('(transform (call "cube") (translate (vector (* 2 i) 0 0)))', 2)
    scene = sl.evaluate(program)
    front = sl.Camera(azimuth=0, elevation=0, orthographic=True, target=(2, 0, 0), distance=12)
    last = scene.render(front, size=(120, 90), frame=1, shutter=0.5, environment="flat", background="black")
    columns = np.flatnonzero(last.radiance[45].mean(axis=1) > 0.02)
    sharp = scene.render(front, size=(120, 90), frame=1, environment="flat", background="black")
    at = np.flatnonzero(sharp.radiance[45].mean(axis=1) > 0.02)
    assert abs(columns[0] - at[0]) <= 1
    assert columns[-1] - at[-1] == pytest.approx(len(at), abs=2)  # half of 2 units, the side of the cube
    still = sl.evaluate('(bind "a" (lambda () (call "cube" :scale [3 1 1])))')
    options = {"size": (64, 48), "environment": "flat", "background": "black"}
    moved, plain = (next(iter(still.film(frames=3, orbit=90, shutter=shutter, **options))) for shutter in (0.8, 0.0))
    assert np.abs(np.asarray(moved, int) - np.asarray(plain, int)).max() > 60


def test_images_with_alpha_are_blurred_too() -> None:
    scene = sl.evaluate(frames('(transform (call "cube" :color [.8 .2 .1]) (translate (vector i 0 0)))')).graph
    options = PictureOptions(width=64, height=48, frame=1, shutter=1.0, ground="transparent", environment="flat")
    image = draw(scene, options, picture_backend("draft"))
    assert image.alpha is not None
    assert ((image.alpha > 20) & (image.alpha < 235)).sum() > 100
    assert np.ptp(image.picture[image.alpha > 60].astype(int), axis=0).max() <= 6, "not multiplied by alpha"


@pytest.mark.parametrize("figure", [sl.Figure(style="line"), sl.Figure(callouts=("a",)), sl.Figure(outline=1.5)])
def test_figures_are_drawn_sharp_over_blurred_images(figure: sl.Figure) -> None:
    scene = sl.evaluate(frames('(transform (call "cube" :color [.8 .2 .1]) (translate (vector i 0 0)))')).graph
    sharp, blurred = (
        draw(
            scene,
            PictureOptions(width=120, height=90, frame=1, shutter=shutter, figure=figure),
            picture_backend("draft"),
        ).picture.astype(int)
        for shutter in (0.0, 0.9)
    )
    dark = [(picture.max(axis=2) < 90).sum() for picture in (sharp, blurred)]
    assert min(dark) > 20, "lines and text"
    assert dark[1] > 0.5 * dark[0]
    assert (np.abs(sharp - blurred).max() > 40) == (figure.style != "line")


def test_instants_share_the_points_of_a_lens(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []

    def counted(*arguments: Any, **named: Any) -> Draft:
        """Draw as ``draft.draw`` does."""
        drawn.append(arguments)
        return pinhole(*arguments, **named)

    pinhole = draft.draw
    monkeypatch.setattr(draft, "draw", counted)
    scene = sl.evaluate(frames('(call "cube" :color [.8 .2 .1])')).graph
    camera = Viewpoint(target=(0.0, 0.0, 0.0), distance=4.0, aperture=0.2)
    radiance = []
    for shutter in (0.0, 0.5):
        options = PictureOptions(width=16, height=16, camera=camera, shutter=shutter, frame=1, ground="seamless")
        radiance.append(draw(scene, options, picture_backend("draft")).radiance)
    assert len(drawn) == 2 * 32
    assert radiance[0] == pytest.approx(radiance[1], abs=1e-3)
