"""Declarations of `assert-that`: which hold, for which instances and frames, and what is told where they do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support import calls

import scenelang as sl
from scenelang.backends.geometry.arrangement import Arrangement
from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.declarations import COLORS, OVER_FRAMES, RELATIONS, Relation, basic_color, example_of
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import Options, Session

THINGS = """
(bind "table" (lambda ()
  (union (transform (call "cube" :scale [2 .1 1]) (translate [0 .95 0]))
    (for*/union ((x '(-.9 .9)) (z '(-.4 .4)))
      (transform (call "cube" :scale [.1 .9 .1]) (translate [x .45 z]))))))
(bind "cup" (lambda () (call "cylinder" :radius .1 :p0 [0 0 0] :p1 [0 .2 0])))
(bind "ball" (lambda () (call "sphere" :radius .1)))
(bind "bowl" (lambda ()
  (lathe (polygon '([0 0] [.3 0] [.5 .4] [.45 .4] [.28 .05] [0 .05])))))
(bind "ring" (lambda () (call "torus" :radius .4 :tube .05)))
(bind "post" (lambda () (call "cylinder" :radius .2 :p0 [0 0 0] :p1 [0 2 0])))
(bind "wall" (lambda () (transform (call "cube" :scale [4 3 .2]) (translate [0 1.5 -2]))))
(bind "chair" (lambda () (transform (call "cube" :scale [.5 1 .5]) (translate [0 .5 0]))))
"""


def scene_of(parts: str, before: str = "") -> sl.Scene:
    return sl.evaluate(f'{before}{THINGS}(bind "room" (lambda () (union {parts})))(scene "room")')


def at(word: str, x: float, y: float, z: float, more: str = "") -> str:
    return f'(transform (call "{word}") (@ (translate [{x} {y} {z}]) {more or "(translate [0 0 0])"}))'


TABLE = at("table", 0, 0, 0)
WALL = at("wall", 0, 0, 0)
RING = at("chair", 2, 0, 0) + at("chair", -1, 0, 1.7321) + at("chair", -1, 0, -1.7321)
TURNED = "(rotate (/ pi 2) [0 1 0])"

CASES = [
    # on: contact from above, not at the side, not below, not sunk
    (TABLE + at("cup", 0, 1, 0), '(on "cup" "table")', True),
    (TABLE + at("cup", 0, 1.05, 0), '(on "cup" "table")', False),
    (TABLE + at("cup", 0, 0.9, 0), '(on "cup" "table")', False),
    (TABLE + at("cup", 1.1, 0.9, 0), '(on "cup" "table")', False),
    (TABLE + at("cup", 0, 0.7, 0), '(on "cup" "table")', False),
    (TABLE + at("cup", 0, 1, 0) + at("cup", 0.5, 1.2, 0), '(on "cup" "table")', False),
    (TABLE + at("cup", 0, 1, 0) + at("cup", 0.5, 1.2, 0), '(on "cup" "table" :any)', True),
    (TABLE + at("cup", 0, 1, 0) + at("table", 5, 0, 0), '(on "cup" "table")', True),
    (TABLE + at("cup", 0, 1, 0) + at("table", 5, 0, 0), '(on "cup" "table" :all)', False),
    (TABLE + at("cup", 0, 1.05, 0), '(on "cup" "table" :within .1)', True),
    (at("bowl", 0, 0, 0) + at("ball", 0, 0.15, 0), '(on "ball" "bowl")', True),
    (at("bowl", 0, 0, 0) + at("ball", 0, 0.35, 0), '(on "ball" "bowl")', False),
    # the same under a mirror and a shear of sizes
    (f"(transform (union {TABLE}{at('cup', 0, 1, 0)}) (scale [-2 1 3]))", '(on "cup" "table")', True),
    (f"(transform (union {TABLE}{at('cup', 0, 1, 0)}) (rotate pi [1 0 0]))", '(on "cup" "table")', False),
    # inside
    (at("bowl", 0, 0, 0) + at("ball", 0, 0.2, 0), '(inside "ball" "bowl")', True),
    (at("bowl", 0, 0, 0) + at("ball", 0, 0.4, 0), '(inside "ball" "bowl")', False),
    (at("bowl", 0, 0, 0) + at("ball", 0, 0.4, 0), '(inside "ball" "bowl" :share .4)', True),
    (at("bowl", 0, 0, 0) + at("ball", 0.6, 0.2, 0), '(inside "ball" "bowl" :share .1)', False),
    # inside along an axis: by outlines, at any distance along it, not by boxes
    (TABLE + at("cup", 0.9, 1, 0.4), '(inside "cup" "table" :axis "y")', True),
    (TABLE + at("cup", 0.95, 1, 0), '(inside "cup" "table" :axis "y")', False),
    (TABLE + at("cup", 0.95, 1, 0), '(inside "cup" "table" :axis "y" :share .8)', True),
    (TABLE + at("cup", 1.05, 1, 0), '(inside "cup" "table" :axis "y" :share .8)', False),
    (WALL + at("chair", 1.7, 0, 3), '(inside "chair" "wall" :axis "z")', True),
    (WALL + at("chair", 1.8, 0, 3), '(inside "chair" "wall" :axis "z")', False),
    (WALL + at("chair", 1.7, 0, 3), '(inside "chair" "wall" :axis "x")', False),
    (at("post", 0, 0, 0) + at("chair", 0, 2, 0, "(scale .6)"), '(inside "chair" "post" :axis "y")', False),
    (at("post", 0, 0, 0) + at("chair", 0, 2, 0, "(scale .5)"), '(inside "chair" "post" :axis "y")', True),
    # distance along axes: of the centers, from the nearest
    (WALL + at("chair", 0.3, 1, 0), '(distance "chair" "wall" :max .01 :axis "y")', True),
    (WALL + at("chair", 0.3, 1, 0), '(distance "chair" "wall" :max .01 :axis "xy")', False),
    (WALL + at("chair", 0.3, 1, 0), '(distance "chair" "wall" .3 :axis "xy")', True),
    (at("post", 0, 0, 0) + at("post", 3, 0, 0) + at("cup", 3, 5, 0), '(distance "cup" "post" 0 :axis "x")', True),
    (
        at("post", 0, 0, 0) + at("post", 3, 0, 9) + at("cup", 3, 0, 1),
        '(distance "cup" "post" :min 1 :axis "x")',
        False,
    ),
    (at("post", 0, 0, 0) + at("post", 3, 0, 9) + at("cup", 3, 0, 1), '(distance "cup" "post" :max 1 :axis "x")', True),
    # touching and clear-of, with holes that no box has
    (at("wall", 0, 0, 0) + at("chair", 0, 0, -1.65), '(touching "chair" "wall")', True),
    (at("wall", 0, 0, 0) + at("chair", 0, 0, -1.5), '(touching "chair" "wall")', False),
    (at("wall", 0, 0, 0) + at("chair", 0, 0, -1.75), '(touching "chair" "wall")', False),
    (at("ring", 0, 1, 0) + at("post", 0, 0, 0), '(clear-of "ring" "post")', True),
    (at("ring", 0, 1, 0) + at("post", 0, 0, 0), '(clear-of "ring" "post" :min .14)', True),
    (at("ring", 0, 1, 0) + at("post", 0, 0, 0), '(clear-of "ring" "post" :min .16)', False),
    (at("ring", 0.2, 1, 0) + at("post", 0, 0, 0), '(clear-of "ring" "post")', False),
    (at("chair", 0, 0, 0) + at("chair", 0.5, 0, 0), '(clear-of "chair" "chair")', True),
    (at("chair", 0, 0, 0) + at("chair", 0.4, 0, 0), '(clear-of "chair" "chair")', False),
    (at("chair", 0, 0, 0), '(clear-of "chair" "chair")', True),
    # distances, angles, sizes, counts
    (at("chair", 0, 0, 0) + at("ball", 0.85, 0.5, 0), '(distance "ball" "chair" .5)', True),
    (at("chair", 0, 0, 0) + at("ball", 0.85, 0.5, 0), '(distance "ball" "chair" .52)', False),
    (at("chair", 0, 0, 0) + at("ball", 0.85, 0.5, 0), '(distance "ball" "chair" .52 :within .03)', True),
    (at("chair", 0, 0, 0) + at("ball", 0.85, 0.5, 0), '(distance "ball" "chair" :min .4 :max .6)', True),
    (at("chair", 0, 0, 0) + at("ball", 0.85, 0.5, 0), '(distance "ball" "chair" :max .4)', False),
    (at("chair", 0, 0, 0) + at("wall", 0, 0, 0, TURNED), '(angle "chair" "wall" 90 :axis "z")', True),
    (at("chair", 0, 0, 0) + at("wall", 0, 0, 0, TURNED), '(angle "chair" "wall" 0)', True),
    (at("chair", 0, 0, 0) + at("wall", 0, 0, 0, TURNED), '(angle "chair" "wall" 80 :axis "z")', False),
    (at("chair", 0, 0, 0), '(size "chair" 1 :axis "y")', True),
    (at("chair", 0, 0, 0), '(size "chair" :axis "x" :max .4)', False),
    (at("chair", 0, 0, 0) * 3, '(count "chair" 3)', True),
    (at("chair", 0, 0, 0) * 3, '(count "chair" :min 4)', False),
    (at("chair", 0, 0, 0), '(count "elephant" 0)', True),
    # directions, in the scene's frame
    (at("chair", -2, 0, 0) + TABLE, '(left-of "chair" "table")', True),
    (at("chair", -2, 0, 0) + TABLE, '(right-of "chair" "table")', False),
    (at("chair", 2, 0, 0) + TABLE, '(right-of "chair" "table")', True),
    (at("chair", 0, 0, 2) + TABLE, '(in-front-of "chair" "table")', True),
    (at("chair", 0, 0, -2) + TABLE, '(behind "chair" "table")', True),
    (at("chair", 2, 0, 0) + TABLE, '(left-of "chair" "table")', False),
    (at("chair", 0, 0, -2) + TABLE, '(in-front-of "chair" "table")', False),
    (at("chair", 0, 0, 2) + TABLE, '(behind "chair" "table")', False),
    (at("ball", 0, 3, 0) + TABLE, '(above "ball" "table")', True),
    (at("ball", 3, 3, 0) + TABLE, '(above "ball" "table")', False),
    (at("ball", 0, 0.3, 0) + TABLE, '(below "ball" "table")', False),
    (at("ball", 0, 0.3, 0) + at("bowl", 0, 2, 0), '(below "ball" "bowl")', True),
    (at("cup", 0, 0, 0) + at("ball", -1, 0, 0) + at("chair", 1, 0, 0), '(between "cup" "ball" "chair")', True),
    (at("cup", 0, 0, 1) + at("ball", -1, 0, 0) + at("chair", 1, 0, 0), '(between "cup" "ball" "chair")', False),
    (at("cup", 2, 0, 0) + at("ball", -1, 0, 0) + at("chair", 1, 0, 0), '(between "cup" "ball" "chair")', False),
    # facing: +z is the front
    (at("chair", 0, 0, -2) + TABLE, '(facing "chair" "table")', True),
    (at("chair", 0, 0, 2) + TABLE, '(facing "chair" "table")', False),
    (at("chair", 0, 0, 2, "(rotate pi [0 1 0])") + TABLE, '(facing "chair" "table")', True),
    (at("chair", -2, 0, 0, TURNED) + TABLE, '(facing "chair" "table")', True),
    (at("chair", -2, 0, 0, "(rotate 2 [0 1 0])") + TABLE, '(facing "chair" "table" :within 20)', False),
    # all together
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 0) + at("cup", 3, 0, 0), '(aligned "cup" :along "x")', True),
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 0.2) + at("cup", 3, 0, 0), '(aligned "cup" :along "x")', False),
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 0.2) + at("cup", 3, 0, 0), '(aligned "cup" :along "xz")', True),
    (at("cup", 0, 0, 0) + at("cup", 1, 1, 1) + at("cup", 3, 3, 3), '(aligned "cup")', True),
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 0) + at("cup", 2, 0, 0), '(evenly-spaced "cup")', True),
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 0) + at("cup", 2.5, 0, 0), '(evenly-spaced "cup" :along "x")', False),
    (at("chair", -1, 0, 0) + at("chair", 3, 0, 0), '(symmetric "chair" :across "x")', True),
    (TABLE + at("chair", -1, 0, 0) + at("chair", 3, 0, 0), '(symmetric "chair" :across "x" :about "table")', False),
    (TABLE + at("chair", -3, 0, 0) + at("chair", 3, 0, 0), '(symmetric "chair" :about "table")', True),
    (TABLE, '(symmetric "table" :across "z")', True),
    (at("chair", -1, 0, 0) + at("chair", 3, 0.1, 0), '(symmetric "chair")', False),
    ("".join(at("cup", x, 0, z) for x in (0, 1, 2) for z in (0, 4)), '(evenly-spaced "cup" :along "x")', True),
    ("".join(at("cup", x, 0, z) for x in (0, 1, 3) for z in (0, 4)), '(evenly-spaced "cup" :along "x")', False),
    (at("cup", 0, 0, 0) * 3, '(evenly-spaced "cup" :along "x")', False),
    # around: equal angles, whatever the radii
    (
        TABLE + at("chair", 2, 0, 0) + at("chair", -1, 0, 1.7321) + at("chair", -1.5, 0, -2.5981),
        '(evenly-spaced "chair" :around "table")',
        True,
    ),
    (
        TABLE + at("chair", 2, 0, 0) + at("chair", -1, 0, 1.7321) + at("chair", -1, 0, -1.2),
        '(evenly-spaced "chair" :around "table")',
        False,
    ),
    (TABLE + at("chair", 2, 0, 0) * 3, '(evenly-spaced "chair" :around "table")', False),
    (
        TABLE + at("chair", 2, 0, 0) + at("chair", -1, 0, 1.7321) + at("chair", -1, 0, -1.2),
        '(evenly-spaced "chair" :around "table" :within 20)',
        True,
    ),
    # around several objects: around their common center, which a ring has without an object there
    (RING, '(encircles "chair" "chair" 2)', True),
    (RING, '(evenly-spaced "chair" :around "chair")', True),
    (RING + at("chair", 1, 0, -2), '(encircles "chair" "chair")', False),
    (RING + at("chair", 1, 0, -2), '(evenly-spaced "chair" :around "chair")', False),
    (at("post", -1, 0, 0) + at("post", 3, 0, 0) + at("cup", 1, 0, 0), '(symmetric "cup" :about "post")', True),
    (at("post", -1, 0, 0) + at("post", 3, 0, 0) + at("cup", -1, 0, 0), '(symmetric "cup" :about "post")', False),
    # aspect, elevation, encircles, rising
    (at("post", 0, 0, 0), '(aspect "post" 5 :axis "y" :to "xz")', True),
    (at("post", 0, 0, 0, "(rotate (/ pi 2) [1 0 0])"), '(aspect "post" :axis "y" :to "xz" :min 2)', False),
    (TABLE + at("cup", 0, 1, 0), '(elevation "cup" 1)', True),
    (TABLE + at("cup", 0, 1, 0), '(elevation "table" 0)', True),
    (TABLE + at("cup", 0, 1.2, 0), '(elevation "cup" :max 1.1)', False),
    (TABLE + at("chair", 2, 0, 0) + at("chair", 0, 0, -2), '(encircles "chair" "table")', True),
    (TABLE + at("chair", 2, 0, 0) + at("chair", 0, 0, -2), '(encircles "chair" "table" 2)', True),
    (TABLE + at("chair", 2, 0, 0) + at("chair", 0, 0, -1.5), '(encircles "chair" "table")', False),
    (TABLE + at("chair", 2, 0, 0) + at("chair", 0, 0, -2), '(encircles "chair" "table" :max 1)', False),
    (at("cup", 0, 0, 0) + at("cup", 1, 0.2, 0) + at("cup", 2, 0.4, 0), '(rising "cup" :along "+x")', True),
    (at("cup", 0, 0, 0) + at("cup", 1, 0.2, 0) + at("cup", 2, 0.4, 0), '(rising "cup" :along "-x")', False),
    (
        at("post", 0, 0, 0) + at("cup", 0, 0.2, 1) + at("cup", 1, 0.4, 0) + at("cup", 0, 0.6, -1),
        '(rising "cup" :around "post")',
        True,
    ),
    (
        at("post", 0, 0, 0) + at("cup", 0, 0.2, -1) + at("cup", 1, 0.4, 0) + at("cup", 0, 0.6, 1),
        '(rising "cup" :around "post")',
        False,
    ),
    (
        at("post", 0, 0, 0) + at("cup", 0, 4, 0) + at("cup", 0, -2, 0) + at("cup", 3, 1, 0) + at("cup", -3, 1, 0),
        '(evenly-spaced "cup" :around "post" :axis "z")',
        True,
    ),
    (
        at("post", 0, 0, 0) + at("cup", 0, 4, 0) + at("cup", 2, 3, 0) + at("cup", 3, 1, 0),
        '(evenly-spaced "cup" :around "post" :axis "z")',
        False,
    ),
    # rows: positions along an axis, and how many objects at each
    ("".join(at("cup", x, 0, z) for x in (0, 1, 2) for z in (0, 1)), '(rows "cup" 2 :along "z" :each 3)', True),
    ("".join(at("cup", x, 0, z) for x in (0, 1, 2) for z in (0, 1)), '(rows "cup" 3 :along "z")', False),
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 0) + at("cup", 1, 0, 1), '(rows "cup" 2 :along "z" :each 2)', False),
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 1) + at("cup", 3, 0, 1), '(rows "cup" 2 :along "+z" :each \'(1 2))', True),
    (at("cup", 0, 0, 0) + at("cup", 1, 0, 1) + at("cup", 3, 0, 1), '(rows "cup" 2 :along "-z" :each \'(1 2))', False),
    # order
    (
        at("cup", 0, 0, 0) + at("cup", 0.3, 1, 0) + at("ball", 1, 0, 0) + at("bowl", 2, 0, 0),
        '(order "cup" "ball" "bowl" :along "x")',
        True,
    ),
    (
        at("cup", 0, 0, 0) + at("cup", 1.3, 1, 0) + at("ball", 1, 0, 0) + at("bowl", 2, 0, 0),
        '(order "cup" "ball" "bowl" :along "x")',
        False,
    ),
    (at("cup", 0, 0, 0) + at("ball", 1, 0, 0), '(order "ball" "cup" :along "x")', False),
    (
        TABLE + at("cup", 1, 0, 0) + at("ball", 0, 0, -1) + at("bowl", -1, 0, 0.2),
        '(order "cup" "ball" "bowl" :around "table")',
        True,
    ),
    (
        TABLE + at("cup", 1, 0, 0) + at("ball", 0, 0, 1) + at("bowl", -1, 0, 0.2),
        '(order "cup" "ball" "bowl" :around "table")',
        False,
    ),
    # proportion
    (TABLE + at("chair", 2, 0, 0), '(proportion "chair" "table" 1 :axis "y")', True),
    (TABLE + at("chair", 2, 0, 0, "(scale .1)"), '(proportion "chair" "table" :axis "y" :min .8)', False),
    (TABLE + at("chair", 2, 0, 0), '(proportion "chair" "table" :axis "x" :min .2 :max .3)', True),
    # tilt: the median of the parts; neither turns about the vertical nor lying down are tilts
    (TABLE, '(tilt "table" 0)', True),
    (at("table", 0, 0, 0, TURNED), '(tilt "table" 0)', True),
    (at("cup", 0, 0, 0, "(rotate (/ pi 2) [1 0 0])"), '(tilt "cup" 0)', True),
    (at("post", 0, 0, 0, "(rotate .1 [1 0 0])"), '(tilt "post" :max 3)', False),
    (at("post", 0, 0, 0, "(rotate .1 [1 0 0])"), '(tilt "post" 5.73)', True),
    (at("table", 0, 0, 0, "(rotate .3 [1 0 .5])"), '(tilt "table" :min 15 :max 20)', True),
    (at("ball", 0, 0, 0, "(rotate .3 [1 0 0])"), '(tilt "ball" 17.19 :within .1)', True),
    # outline
    (at("post", 0, 0, 0), '(outline "post" "round")', True),
    (at("post", 0, 0, 0, "(scale [1 1 2])"), '(outline "post" "round")', False),
    (at("post", 0, 0, 0, "(scale [1 1 2])"), '(outline "post" "oval")', True),
    (at("post", 0, 0, 0), '(outline "post" "rectangular" :axis "x")', True),
    (at("chair", 0, 0, 0, "(rotate .4 [0 1 0])"), '(outline "chair" "square")', True),
    (TABLE, '(outline "table" "rectangular")', True),
    (TABLE, '(outline "table" "square")', False),
    (TABLE, '(outline "table" "round")', False),
    # made-of: by most of the volume
    ('(call "set-cuboid" :block-type "oak_planks" :size [2 2 2])', '(made-of "set-cuboid" "planks")', True),
    ('(call "set-cuboid" :block-type "minecraft:stone" :size [2 2 2])', '(made-of "set-cuboid" "stone")', True),
    ('(call "set-cuboid" :block-type "quartz_block" :size [2 2 2])', '(made-of "set-cuboid" "quartz")', True),
    ('(call "set-cuboid" :block-type "cobblestone" :size [2 2 2])', '(made-of "set-cuboid" "stone")', False),
    # visible-from
    (WALL + at("chair", 0, 0, 1) + at("ball", 0, 0.5, -3), '(visible-from "ball" "chair")', False),  # behind the wall
    (WALL + at("chair", 0, 0, 1) + at("ball", 0, 0.5, -1), '(visible-from "ball" "chair")', True),
    # reachable: around the wall, which is 4 wide, but not through a ring of chairs
    (WALL + at("chair", 0, 0, 0) + at("ball", 0, 0.1, -4), '(reachable "ball" "chair")', True),
    (
        at("ball", 0, 0.1, 0)
        + at("cup", 4, 0, 0)
        + "".join(at("chair", x / 2, 0, z / 2) for x in range(-3, 4) for z in range(-3, 4) if max(abs(x), abs(z)) == 3),
        '(reachable "ball" "cup")',
        False,
    ),
    # supported: connected to the ground, in any number of steps
    (TABLE + at("bowl", 0, 1, 0) + at("ball", 0, 1.15, 0), '(supported "ball")', True),
    (TABLE + at("bowl", 0, 1.1, 0) + at("ball", 0, 1.25, 0), '(supported "ball")', False),
    # colors, by most of the surface
    (TABLE + at("cup", 0, 1, 0), '(has-color "table" "white")', True),
    (TABLE + at("cup", 0, 1, 0), '(has-color "table" "red")', False),
    (TABLE + at("cup", 0, 1, 0), '(has-color "table" (color "ivory"))', True),
    # negation
    (TABLE + at("cup", 0, 1, 0), '(not (on "cup" "table"))', False),
    (TABLE + at("cup", 0, 2, 0), '(not (on "cup" "table"))', True),
]


@pytest.mark.parametrize(("parts", "declaration", "holds"), CASES)
@pytest.mark.sampled(4)
def test_what_holds(parts: str, declaration: str, holds: bool) -> None:
    assert (scene_of(parts).violations(declaration) == []) is holds


def test_every_relation_is_tested_both_ways() -> None:
    for holds in (True, False):
        tested = {c.replace("(not (", "(").split()[0].strip("(") for _, c, result in CASES if result is holds}
        assert set(RELATIONS) - OVER_FRAMES - {"floating", "fastened"} <= tested  # those below


@pytest.mark.parametrize("relation", RELATIONS.values(), ids=lambda each: each.name)
def test_examples_hold(relation: Relation) -> None:
    scene = sl.evaluate(example_of(relation))
    assert scene.violations() == []
    assert len(scene.violations(f"(not {relation.example})")) == 1


def movable(parts: str, declaration: str, holds: bool) -> bool:
    """Whether a case fails, and has one subject that is only moved."""
    subject = declaration.split('"')[1]
    return (
        not holds
        and "(not" not in declaration
        and "(transform (union" not in parts
        and ":all" not in declaration
        and parts.count(f'"{subject}"') == 1
    )


# Relations of which no translation is known that makes them hold.
UNMOVED = {"angle", "facing", "size", "count", "symmetric", "between", "has-color", "order", "proportion", "tilt",
           "outline", "made-of", "visible-from", "reachable", "rows", "aspect",
           "elevation", "encircles", "rising"}  # fmt: skip


@pytest.mark.parametrize(("parts", "declaration"), [case[:2] for case in CASES if movable(*case)])
@pytest.mark.sampled(4)
def test_a_move_makes_it_hold(parts: str, declaration: str) -> None:
    """The translation that is told, in the scene's frame, makes a declaration hold."""
    (violation,) = scene_of(parts).violations(declaration)
    if violation.declaration.relation in UNMOVED or "around" in violation.declaration.options:
        assert violation.move is None
        return
    if violation.move is None and "axis" in violation.declaration.options:
        return  # seen along an axis, what does not fit anywhere has no move
    x, y, z = violation.move or (0, 0, 0)
    before, subject, after = parts.partition(f'(transform (call "{violation.subject}")')
    end = after.find("(transform")
    rest = (after, "") if end < 0 else (after[:end], after[end:])
    moved = f"{before}(transform {subject}{rest[0]} (translate [{x:.12f} {y:.12f} {z:.12f}])){rest[1]}"
    assert scene_of(moved).violations(declaration) == []


def test_it_is_about_the_entity_that_states_it() -> None:
    before = '(bind "set" (lambda () (assert-that (on "cup" "table")) (union {})))'
    good, bad = TABLE + at("cup", 0, 1, 0), TABLE + at("cup", 0, 1.5, 0)
    outside = at("cup", 9, 5, 0)
    assert scene_of(at("set", 0, 0, 0) + outside, before.format(good)).violations() == []
    found = scene_of(at("set", 0, 0, 0) + at("set", 5, 0, 0), before.format(bad)).violations()
    assert [v.subject for v in found] == ["cup"]  # equal instances are tested once
    tilted = scene_of(at("set", 0, 0, 0, "(rotate 1 [1 0 0])"), before.format(good)).violations()
    assert len(tilted) == 1  # in world poses


def test_values_may_be_computed() -> None:
    program = '(param n 3 "number")(assert-that (count "chair" n))'
    parts = "(for/union ((i n)) " + at("chair", 0, 0, 0).replace("[0 0 0]", "[i 0 0]", 1) + ")"
    assert scene_of(parts, program).violations() == []
    assert len(scene_of(parts, program.replace('"chair" n', '"chair" (+ n 1)')).violations()) == 1


def test_a_helper_states_for_the_entity_around_it() -> None:
    before = '(define (rule) (assert-that (count "cup" 1)))(bind "set" (lambda () (rule) (call "cup")))'
    assert scene_of(at("set", 0, 0, 0) + at("set", 1, 0, 0), before).violations() == []
    once = '(bind "set" (lambda (z gamma) (for ((i 3)) (assert-that (count "cup" 2))) (call "cup")))'
    assert len(scene_of(at("set", 0, 0, 0), once).violations()) == 3


def test_every_frame_is_tested() -> None:
    program = f"""{THINGS}
    (bind "fall" (lambda (z gamma)
      (assert-that (on "cup" "table"))
      (frames (for/list ((y '(1 1 1.5 2))) (union (call "table") (transform (call "cup") (translate [0 y 0])))))))
    (scene "fall")"""
    found = sl.evaluate(program).violations()
    assert [v.frame for v in found] == [2, 3]


FILM = f"""{THINGS}
(bind "film" (lambda (z gamma)
  (frames (for/list ((t '(0 .5 1)))
    (union
      (call "table")
      (transform (call "cup") (translate [0 (+ 1 (* .4 t)) 0]))
      (transform (call "chair") (@ (translate [2 0 0]) (rotate (* t pi .5) [0 1 0]))))))))
(scene "film")"""


@pytest.mark.parametrize(
    ("declaration", "holds"),
    [
        ('(moves "cup" .4)', True),
        ('(moves "cup" :along "y" .4 :within .01)', True),
        ('(moves "cup" :along "x" :min .1)', False),
        ('(moves "cup" .5)', False),
        ('(moves "table" :min .01)', False),
        ('(not (moves "table" :min .01))', True),
        ('(turns "chair" 90)', True),
        ('(turns "chair" 45)', False),
        ('(turns "chair" :min 60 :max 100)', True),
        ('(turns "cup" :max 1)', True),
        ('(turns "cup" :min 1)', False),
        ('(moves "cup" .4 :along "+y")', True),
        ('(moves "cup" :along "-y" :min .1)', False),
        ('(turns "chair" 90 :axis "y")', True),
        ('(turns "chair" 90 :axis "+y")', True),
        ('(turns "chair" :axis "-y" :min 10)', False),
        ('(turns "chair" 90 :axis "x")', False),
        ('(path "cup" "line")', True),
        ('(path "cup" "closed")', False),
        ('(path "table" "line")', False),  # it does not move
        ('(on "cup" "table")', False),
        ('(on "cup" "table" :first)', True),
        ('(on "cup" "table" :last)', False),
        ('(on "cup" "table" :sometime)', True),
        ('(on "chair" "table" :sometime)', False),
        ('(on "cup" "table" :never)', False),
        ('(on "chair" "table" :never)', True),
        ('(not (on "cup" "table" :last))', True),
    ],
)
def test_motion_through_the_frames(declaration: str, holds: bool) -> None:
    assert (sl.evaluate(FILM).violations(declaration) == []) is holds


WHEEL = f"""{THINGS}
(bind "film" (lambda (z gamma)
  (frames (for/list ((t (linspace 0 WAY 13)))
    (union
      (call "post")
      (transform (call "chair") (@ (rotate t [0 1 0]) (translate [2 0 0]))))))))
(scene "film")"""


@pytest.mark.parametrize(
    ("way", "declaration", "holds"),
    [
        ("(* 2 pi)", '(path "chair" "circle" :about "post")', True),
        ("(* 2 pi)", '(path "chair" "closed")', True),
        ("(* 2 pi)", '(path "chair" "line")', False),
        ("(* 2 pi)", '(turns "chair" 360 :axis "+y")', True),  # more than the half turn that one frame can tell
        ("(* -3 pi)", '(turns "chair" 540 :axis "-y")', True),
        ("1", '(path "chair" "circle" :about "post")', True),
        ("1", '(path "chair" "closed")', False),
        ("(* 2 pi)", '(path "chair" "circle" :about "chair")', False),
    ],
)
def test_paths_around(way: str, declaration: str, holds: bool) -> None:
    assert (sl.evaluate(WHEEL.replace("WAY", way)).violations(declaration) == []) is holds


def test_motion_of_things_that_do_not_stay() -> None:
    program = FILM.replace('(call "table")', '(call "table") (if (> t .4) (call "ball") (union))')
    assert sl.evaluate(FILM.replace('(call "table")', '(call "ball")')).violations('(moves "ball" 0)') == []
    assert refusal(sl.evaluate(program), '(moves "ball" 0)').name == "declaration-subject"


def test_what_turns_about_one_axis_does_not_turn_about_another() -> None:
    scene = sl.evaluate("""(bind "rod" (lambda () (call "cube" :scale [.1 1 .1])))
(bind "film" (lambda () (frames (map (lambda (i) (transform (call "rod") (rotate (* .1 i) [0 0 1]))) (range 5)))))
(scene "film")""")
    assert scene.violations('(turns "rod" 0 :axis "x" :within .5)') == []
    assert len(scene.violations('(turns "rod" 0 :axis "z" :within .5)')) == 1
    assert len(scene.violations('(turns "rod" 20 :axis "x")')) == 1


def test_colors_that_are_called_so() -> None:
    for name in COLORS:
        scene = sl.evaluate(f'(bind "it" (lambda () (call "cube" :color (color "{name}"))))(scene "it")')
        assert scene.violations(f'(has-color "cube" "{name}")') == []
    assert basic_color((0.3, 0.12, 0.04)) == basic_color((0.55, 0.35, 0.2)) == "brown"
    assert basic_color((0.03, 0.03, 0.03)) == "black"
    assert "did you mean `blue`" in str(refusal(scene, '(has-color "cube" "bleu")').hint)


def test_handles_choose_instances() -> None:
    parts = TABLE + '(transform (call "cup" <mine>) (translate [0 1 0]))' + at("cup", 0.5, 2, 0)
    assert scene_of(parts).violations('(on <mine> "table")') == []
    assert len(scene_of(parts).violations('(on "cup" "table")')) == 1


def refusal(scene: sl.Scene, declaration: str) -> SceneError:
    with pytest.raises(SceneError) as caught:
        scene.violations(declaration)
    return caught.value


def test_words_that_do_not_occur() -> None:
    error = refusal(scene_of(TABLE + at("cup", 0, 1, 0)), '(on "cupp" "table")')
    assert error.name == "declaration-subject"
    assert "did you mean `cup`" in str(error.hint)
    inner = '(bind "set" (lambda () (assert-that (on "ball" "table")) (call "table")))'
    error = refusal(scene_of(at("set", 0, 0, 0) + at("ball", 0, 1.1, 0), inner), '(count "set" 1)')
    assert 'outside of "set"' in str(error.hint)


def test_blocks_and_semantic_primitives() -> None:
    blocks = sl.evaluate(
        '(bind "tower" (lambda () (call "set-cuboid" :block-type "minecraft:stone" :scale [2 5 2])))(scene "tower")'
    )
    assert blocks.violations('(size "tower" 5 :axis "y")', '(count "tower" 1)') == []
    assert "Minecraft blocks" in refusal(blocks, '(supported "tower")').message
    boxes = sl.evaluate(
        '(bind "room" (lambda () (union (call "sofa" :scale [2 1 1]) (transform (call "cat" :scale [.4 .4 .4]) '
        '(translate [0 .7 0])))))(scene "room")'
    )
    assert boxes.violations('(on "cat" "sofa")', '(clear-of "cat" "sofa")') == []


MISTAKES = [
    ('(assert-that (onn "a" "b"))', "E201", "did you mean `on`"),
    ('(assert-that "on")', "E201", "write a relation"),
    ('(assert-that (on "a"))', "E201", "write `(on A B"),
    ('(assert-that (on "a" "b" "c"))', "E201", "write `(on A B"),
    ('(assert-that (on "a" "b" :withn 1))', "E201", "did you mean `within`"),
    ('(assert-that (on "a" "b" :within))', "E201", "has no value"),
    ('(assert-that (on "a" 3))', "E401", "expects a word or a handle"),
    ('(assert-that (count "a" 1.5))', "E409", "whole number"),
    ('(assert-that (count "a"))', "E409", ":min"),
    ('(assert-that (size "a" 1))', "E409", ":axis"),
    ('(assert-that (size "a" 1 :axis "w"))', "E409", '"x", "y" or "z"'),
    ('(assert-that (distance "a" "b" 1 :max 2))', "E409", "a number or a range"),
    ('(assert-that (distance "a" "b" :min -1))', "E409", "from 0 to"),
    ('(assert-that (inside "a" "b" :share 2))', "E409", "at most 1"),
    ('(assert-that (on "a" "b" :within 1e400))', "E409", "from 0 to"),
]


@pytest.mark.parametrize(("form", "code", "text"), MISTAKES)
def test_mistakes_have_diagnostics(form: str, code: str, text: str) -> None:
    program = f'{form}(bind "a" (lambda () (call "cube")))(scene "a")'
    (problem,) = [d for d in Session().evaluate(Source("a.scene", program)).diagnostics if d.is_error]
    assert problem.code == code
    assert problem.span is not None
    assert text in f"{problem.message} {problem.hint}"


def test_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program, rules = tmp_path / "room.scene", tmp_path / "rules.scene"
    program.write_text(f'{THINGS}(bind "room" (lambda () (union {TABLE}{at("cup", 0, 1.5, 0)})))(scene "room")')
    rules.write_text('(assert-that (on "cup" "table") "cups stand")\n(assert-that (count "table" 1))\n')
    assert main(["check", "--run", str(program)]) == 0
    assert main(["check", str(program), "--that", '(count "cup" 1)']) == 0
    assert main(["check", str(program), "--that", str(rules)]) == 1
    told = capsys.readouterr().err
    for text in (
        "error[E612]",
        "rules.scene:1:14",
        "cups stand",
        '"cup" floats 0.5 above "table"',
        "(translate [0 -0.5 0])",
    ):
        assert text in told
    shown = tmp_path / "shown.png"
    assert main(["check", str(program), "--that", '(on "cup" "table")', "--picture", str(shown)]) == 1
    assert "the finding is shown in" in capsys.readouterr().err
    with Image.open(shown) as picture:
        red, green, _ = np.asarray(picture.convert("RGB"), float).reshape(-1, 3).T
    assert 100 < int((red > green + 60).sum()) < 200_000  # the cup, marked
    assert main(["check", str(program), "--that", '(on "cup")']) == 1
    assert main(["check", str(program), "--root", "room", "--that", '(count "cup" 1)']) == 0
    assert main(["check", str(program), "--that", "missing.scene"]) == 1


def test_work_grows_with_the_number_of_things() -> None:
    """Things are compared with those near them, not with all."""

    def work(count: int) -> int:
        scene = scene_of(
            f"(for*/union ((i {count}) (j {count})) (transform (union {at('cup', 0, 1, 0)} {TABLE})"
            " (translate (vector (* 3 i) 0 (* 3 j)))))"
        )
        found = []
        made = calls(lambda: found.extend(scene.violations('(on "cup" "table")')))
        assert found == []
        return made

    work(2)
    few, many = work(8), work(16)
    assert many < 5 * few  # four times as many; 16 times if all were compared with all


HOSTILE = [
    '(bind "a" (lambda () (for ((i 10000000)) (assert-that (count "a" 1))) (call "cube")))',
    '(define (f) (assert-that (count "a" 1)) (f)) (bind "a" (lambda () (f) (call "cube")))',
    '(bind "a" (lambda () (assert-that (count "a" (expt 10 4000))) (call "cube")))',
    '(bind "a" (lambda () (assert-that (distance "a" "a" (/ 1.0 1e-320))) (call "cube")))',
    '(bind "a" (lambda () (guard (e (#t none)) (assert-that (on (list) "a"))) (call "cube")))',
    '(assert-that (on (for/list ((i 3)) "a") "a")) (bind "a" (lambda () (call "cube")))',
]


@pytest.mark.parametrize("program", HOSTILE)
def test_hostile_declarations_end_at_limits(program: str) -> None:
    session = Session(Options(limits=Limits(seconds=2.0, steps=2_000_000)))
    result = session.evaluate(Source("a.scene", program + '(scene "a")'))
    assert result.scene is not None or any(d.is_error for d in result.diagnostics)


def test_a_scene_of_nothing_is_judged() -> None:
    scene = sl.evaluate('(bind "scene" (lambda () (union)))')
    assert scene is not None
    assert scene.violations('(count "cone" 0)') == []
    assert [each.message for each in scene.violations('(count "cone" 6)')] == ["there are 0"]
    with pytest.raises(SceneError, match='"cone" does not occur in "scene"'):
        scene.violations('(on "cone" "cone")')


@pytest.mark.parametrize("x", [-0.82, -3.3, 0.123, 7.77])
@pytest.mark.parametrize("z", [-2.02, 0.6, 1.37])
def test_round_feet_on_a_top_that_rounding_lets_overlap(x: float, z: float) -> None:
    """A lathe on a box shared 4e-20 of volume with it, and counted as sunk by the way out of the box."""
    program = f"""(bind "glass" (lambda () (lathe [[0 0] [.03 0] [.035 .12] [.033 .12] [.028 .006] [0 .006]])))
    (bind "board" (lambda () (transform (call "cube" :scale [1.2 .04 .8]) (translate [0 .73 0]))))
    (bind "all" (lambda () (transform
      (union (call "board") (transform (call "glass") (translate [.18 .75 -.02]))) (translate [{x} 0 {z}]))))
    (scene "all")"""
    assert sl.evaluate(program).violations('(on "glass" "board")', '(clear-of "glass" "board")') == []


def test_deleted_blocks_have_no_place_in_a_symmetry() -> None:
    build = """(bind "arch" (lambda ()
      (union (call "set-cuboid" :block-type "stone" :scale [5 5 1])
        (transform (call "delete-blocks" :scale [3 4 1]) (translate [1 0 0])))))
    (bind "all" (lambda () (call "arch")))(scene "all")"""
    assert sl.evaluate(build).violations('(symmetric "arch")') == []


def test_paths_in_an_empty_scene_are_errors() -> None:
    empty = sl.evaluate('(bind "all" (lambda () (union)))(scene "all")')
    assert refusal(empty, '(on "cup[0]" "table")').name == "declaration-subject"


@pytest.mark.parametrize(
    ("height", "declaration", "holds"),
    [
        (3, '(on "rail" "bridge")', True),
        (5, '(on "rail" "bridge")', False),
        (2, '(on "rail" "bridge")', False),
        (3, '(touching "rail" "bridge")', True),
        (4, '(touching "rail" "bridge")', False),
        (3, '(clear-of "rail" "bridge")', True),
        (2, '(clear-of "rail" "bridge")', False),
        (5, '(distance "rail" "bridge" 2)', True),
        (4, '(distance "rail" "bridge" 2)', False),
        (3, '(clear-of "rail" "bridge" :min 1)', False),
    ],
)
def test_contacts_of_blocks(height: int, declaration: str, holds: bool) -> None:
    build = f"""(bind "bridge" (lambda () (call "set-cuboid" :block-type "stone" :scale [3 3 9])))
    (bind "rail" (lambda () (call "set-cuboid" :block-type "oak_fence" :scale [1 1 9])))
    (bind "all" (lambda () (union (call "bridge") (transform (call "rail") (translate [0 {height} 0])))))(scene "all")"""
    assert (sl.evaluate(build).violations(declaration) == []) is holds


def test_symmetry_of_blocks_is_that_of_their_boxes() -> None:
    def towers(xs: str) -> sl.Scene:
        block = '(transform (call "set-cuboid" :block-type "stone" :scale [1 4 1]) (translate [x 0 0]))'
        return sl.evaluate(f'(bind "tower" (lambda (:x) {block}))\n'
                           f'(bind "scene" (lambda () (for/union ((x \'({xs}))) (call "tower" :x x))))')  # fmt: skip

    assert towers("-3 0 3").violations('(symmetric "tower" :across "x")') == []
    assert towers("-3 1 3").violations('(symmetric "tower" :across "x")') != []
    with pytest.raises(SceneError, match="no meaning"):
        towers("0").violations('(has-color "tower" "gray")')


@pytest.mark.parametrize(
    ("stated", "name", "message"),
    [
        ('(count "cupp" 0)', "declaration-subject", '"cupp" does not occur in "room"'),
        ('(distance "cup" "table" :min 5 :max 1)', "value", "`:min` to be at most `:max`"),
        ('(facing "cup" "table" :within 200)', "value", "degrees from 0 to 180"),
        ('(has-color "cup" [300 0 0])', "value", "components from 0 to 1"),
        ("(not)", "syntax", "`not` expects one relation, got 0 operands"),
        ('(on "cup" "table" :any :any)', "syntax", "`:any` is given twice"),
    ],
)
def test_what_a_declaration_does_not_take(stated: str, name: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        scene_of(TABLE + at("cup", 0, 1, 0)).violations(stated)
    assert (error.value.name, message in error.value.message) == (name, True)


def test_no_thing_is_on_its_own_part_and_a_table_is_below_what_is_above_it() -> None:
    scene = scene_of(TABLE + at("cup", 0.6, 1, 0))
    [violation] = scene.violations('(on "room" "table")', '(below "table" "cup")', '(above "cup" "table")')
    assert violation.message == '"table" is a part of "room"'
    assert scene.violations('(count "lamp" 0)') == []


def test_a_wrong_number_in_a_path_has_a_hint() -> None:
    with pytest.raises(SceneError) as error:
        scene_of(TABLE + at("cup", 0, 1, 0)).violations('(on "room/cup[9]" "table")')
    assert "there is only one `cup`" in (error.value.hint or "")


def test_what_is_missing_in_a_frame_names_the_frame() -> None:
    frames = f"(frames (list (union {TABLE}{at('cup', 0, 1, 0)}) {TABLE}))"
    scene = sl.evaluate(f'{THINGS}(bind "room" (lambda () {frames}))(scene "room")')
    assert scene.violations('(count "cup" :max 1)') == []
    with pytest.raises(SceneError, match=r'"cup" does not occur in "room" \(frame 1\)'):
        scene.violations('(on "cup" "table")')


def test_what_is_stated_twice_is_told_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stated = '(distance "cup" "table" 3)'
    for inner in ("", f"(assert-that {stated})"):
        parts = TABLE + at("cup", 0, 1, 0)
        file = tmp_path / "room.scene"
        file.write_text(f'{THINGS}(bind "room" (lambda () {inner} (union {parts})))(scene "room")')
        assert main(["check", str(file), "--that", stated, "--that", stated]) == 1
        told = capsys.readouterr().err
        assert (told.count("does not hold"), told.count("times")) == (1, 0)
        assert '"cup" and "table" are 0 apart' in told


def test_a_least_distance_compares_what_is_near(monkeypatch: pytest.MonkeyPatch) -> None:
    posts = '(for*/union ((i (iota 12)) (j (iota 12))) (transform (call "chair") (translate (vector i 0 j))))'
    scene = scene_of(posts)
    compared: list[int] = []
    alone = Arrangement.separation
    monkeypatch.setattr(Arrangement, "separation", lambda *given: (compared.append(1), alone(*given))[1])
    assert scene.violations('(distance "chair" "chair" :min .4)', '(clear-of "chair" "chair" :min .4)') == []
    assert len(compared) == 0
    assert len(scene.violations('(distance "chair" "chair" :min .9)')) == 144  # the nearest is .5 away


def test_symmetry_of_what_is_not() -> None:
    scene = scene_of(at("chair", -2, 0, 0) + at("chair", 2, 0, 0) + at("table", 0, 0, 0) + at("chair", 1, 0, 0.5))
    [*found] = scene.violations('(symmetric "chair" :across "x" :about "table")')
    assert [round(each.amount, 3) for each in found] == [1.0]


FLYING = """
(bind "panel" (lambda () (transform (call "cube" :scale [3 2 .1]) (translate [0 1 0]))))
(bind "shelf" (lambda () (call "cube" :scale [.8 .03 .2])))
(bind "ball" (lambda () (call "sphere" :radius .1 :floating #t)))
(bind "room" (lambda () (union (call "panel") (transform (call "shelf") (translate [0 1 .15])) (transform (call "ball") (translate [0 1 1])))))
(scene "room")
"""


@pytest.mark.parametrize(
    ("stated", "holds"),
    [
        ('(floating "ball")', True), ('(floating "shelf")', False), ('(supported "ball")', True), ('(supported "shelf")', True),
        ('(fastened "shelf" "panel")', True), ('(fastened "ball" "panel")', False),
    ],
)  # fmt: skip
def test_facts_are_declared_before_attributes_excuse_them(stated: str, holds: bool) -> None:
    scene = sl.evaluate(FLYING)
    assert (scene.violations(stated) == []) is holds


CORNER = '(difference (call "cube" :scale 2) (transform (call "cube" :scale 2) (translate [1 1 1])))'


@pytest.mark.parametrize("away", [0.0, 0.25, 40.0])
def test_the_gap_of_surfaces_is_exact_at_any_distance(away: float) -> None:
    place = f"(translate [{2 + away} .3 -.2])"
    scene = sl.evaluate(
        f'(bind "a" (lambda () {CORNER})) (bind "b" (lambda () {CORNER})) '
        f'(bind "s" (lambda () (union (call "a") (transform (call "b") {place}))))'
    )
    arrangement = Arrangement(scene.graph)
    (a,), (b,) = arrangement.objects("a"), arrangement.objects("b")
    separation = arrangement.separation(a, b)
    assert separation is not None
    assert separation.distance == pytest.approx(away, abs=1e-9)


def test_a_vertex_without_triangles_is_no_surface(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The nearest vertex of a file belongs to no triangle: the gap is that of the triangles, 2 farther."""
    pytest.importorskip("trimesh")
    corners = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 0"
    header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    faces = "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    (tmp_path / "a.ply").write_text(f"{header}{faces}{corners}\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    (tmp_path / "s.scene").write_text(
        f'(bind "a" (lambda () (call "mesh" :file "a.ply"))) (bind "b" (lambda () {CORNER})) '
        '(bind "s" (lambda () (union (call "a") (transform (call "b") (translate [6 0 0])))))'
    )
    arrangement = Arrangement(sl.load(tmp_path / "s.scene").graph)
    (a,), (b,) = arrangement.objects("a"), arrangement.objects("b")
    separation = arrangement.separation(a, b)
    assert separation is not None
    assert separation.distance == pytest.approx(4.0)
