"""How large and how central the objects of a scene are in an image: measured on the map of the seen solids.

``python tests/silhouettes.py`` prints a table of the examples and of the scenes below.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from support import evaluate, session

from scenelang.backends.pictures.backdrops import lightness
from scenelang.backends.pictures.camera import Camera, Viewpoint
from scenelang.backends.pictures.draft import draw as draft_of
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.pictures.stage import Shot, film, staging_of, still
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.interpreter.scene.entity import Scene

SIZES = ((640, 480), (480, 640))
EXAMPLES = Path(__file__).parents[1] / "examples"
LIMIT = 2_000_000

_SPIRAL = """(bind "spiral" (lambda () (union (for/list ((i (iota 40)))
  (transform (call "sphere" :radius .12) (translate [(* 1.5 (cos (* .4 i))) (* .1 i) (* 1.5 (sin (* .4 i)))]))))))"""
_PENDULUM = """(bind "pendulum" (lambda () (frames (for/list ((i (iota 9)))
  (transform (union (call "cylinder" :radius .03 :p1 [0 -2 0])
                    (transform (call "sphere" :radius .2) (translate [0 -2 0])))
    (rotate (* .12 (- i 4)) [0 0 1]))))))"""
_TREE = """(bind "tree" (lambda (:depth) (union (call "cylinder" :radius .08 :p1 [0 1 0])
  (if (> depth 0) (union (for/list ((i (iota 3)))
    (transform (call "tree" :depth (- depth 1)) (@ (translate [0 1 0]) (rotate (* 2.1 i) [0 1 0]) (rotate .5 [1 0 0]) (scale .7)))))
   (union)))))
(bind "root" (lambda () (call "tree" :depth 6)))"""


def _one(expression: str) -> str:
    """Return a program of one expression."""
    return f'(bind "root" (lambda () {expression}))'


SCENES = {
    "cube": _one('(call "cube")'),
    "ball": _one('(call "sphere")'),
    "cone": _one('(call "cone" :p1 [0 3 0])'),
    "cylinder": _one('(call "cylinder" :p1 [0 .2 0])'),
    "torus": _one('(call "torus")'),
    "capsule": _one('(transform (call "capsule" :p1 [0 4 0]) (rotate 1 [1 1 0]))'),
    "needle": _one('(call "cube" :scale [.01 5 .01])'),
    "plank": _one('(call "cube" :scale [6 .1 .3])'),
    "plate": _one('(call "cube" :scale [4 .05 4])'),
    "wall": _one('(call "cube" :scale [5 3 .05])'),
    "turned cube": _one('(transform (call "cube") (rotate .9 [1 2 3]))'),
    "ellipsoid": _one('(transform (call "sphere") (@ (rotate .7 [0 0 1]) (scale [3 .3 .6])))'),
    "sheared": _one('(transform (call "cone") (@ (scale [2 1 .3]) (rotate .6 [0 0 1]) (scale [1 2 1])))'),
    "dumbbell": _one('(union (call "sphere" :radius 1) (transform (call "sphere" :radius .1) (translate [8 0 2])))'),
    "diagonal": _one('(union (for/list ((i (iota 12))) (transform (call "sphere" :radius .2) (translate [i i i]))))'),
    "arch": _one(
        "(union (for/list ((i (iota 13))) "
        '(transform (call "cube" :scale .3) (translate [(* 3 (cos (* .26 i))) (* 3 (sin (* .26 i))) 0]))))'
    ),
    "ghost": _one('(union (call "sphere") (transform (call "cube" :scale 3 :opacity 0) (translate [5 5 0])))'),
    "glass": _one('(union (call "cube") (transform (call "sphere" :opacity .3) (translate [1.5 0 0])))'),
    "bored": _one('(difference (call "cube") (transform (call "cylinder" :radius .3 :p1 [0 3 0]) (rotate 1 [1 0 0])))'),
    "ring of cones": _one(
        '(union (for/list ((i (iota 9))) (transform (call "cone") (@ (rotate (* .7 i) [0 1 0]) (translate [4 0 0])))))'
    ),
    "far from the origin": _one('(transform (call "cone") (translate [1000 200 -300]))'),
    "tiny": _one('(transform (call "torus") (scale 1e-6))'),
    "spiral": _SPIRAL,
    "tree": _TREE,
}
FILMS = {"pendulum": _PENDULUM}


@dataclass(frozen=True)
class Silhouette:
    """Bounding rectangle of the seen objects: its larger side and its distance from the middle, in shares of the
    image."""

    fill: float
    offset: float

    def __str__(self) -> str:
        return f"{100 * self.fill:5.1f} {100 * self.offset:5.2f}"


def mask_of(scene: Scene, shot: Shot) -> npt.NDArray[np.bool_]:
    """Return which pixels (H, W) of a shot show an object."""
    stage = staging_of(scene, [shot.frame], LIMIT, "studio", "none").stage(shot)
    return np.asarray(draft_of(stage, shaded=False).ids >= 0, bool)


def measured(masks: Iterable[npt.NDArray[np.bool_]]) -> Silhouette:
    """Return the silhouette of the union of masks (H, W)."""
    mask = np.any(list(masks), axis=0)
    sides = []
    for axis in (0, 1):
        at = np.flatnonzero(mask.any(axis=1 - axis))
        size = mask.shape[axis]
        sides.append(((at[-1] + 1 - at[0]) / size, abs((at[-1] + 1 + at[0]) / 2 - size / 2) / size))
    return Silhouette(max(fill for fill, _ in sides), max(offset for _, offset in sides))


def of_still(scene: Scene, view: Viewpoint | Camera, size: tuple[int, int], frame: int | None = None) -> Silhouette:
    """Return the silhouette of one image."""
    return measured([mask_of(scene, still(scene, view, frame, *size))])


def of_film(
    scene: Scene, view: Viewpoint | Camera, size: tuple[int, int], frames: int | None = None, orbit: float | None = None
) -> Silhouette:
    """Return the silhouette of a video: of the union over its frames."""
    return measured(mask_of(scene, shot) for shot in film(scene, view, *size, frames, orbit))


def outline_contrast(scene: Scene, options: PictureOptions) -> float:
    """Return the median difference of CIE's L* over the outline of the objects, from 2 pixels inside to 2 outside."""
    quality = "final" if options.settings else "draft"
    shot = still(scene, options.camera or Viewpoint(), None, options.width, options.height)
    mask, light = (
        mask_of(scene, shot),
        lightness(from_srgb(draw(scene, options, picture_backend(quality)).picture / 255.0)),
    )
    steps = []
    for inside, shade in ((mask, light), (mask.T, light.T), (mask[::-1], light[::-1]), (mask.T[::-1], light.T[::-1])):
        edge = inside[:-4] & inside[1:-3] & inside[2:-2] & ~inside[3:-1] & ~inside[4:]
        steps.append((shade[:-4] - shade[4:])[edge])
    return float(np.median(np.abs(np.concatenate(steps))))


def loaded(path: Path) -> Scene:
    """Return the scene of a program."""
    run = session()
    scene = run.evaluate(run.source(str(path))).scene
    assert scene is not None, path
    return scene


def example_scenes() -> dict[str, Scene]:
    """Return the scenes of the example programs, by name."""
    return {path.stem: loaded(path) for path in sorted(EXAMPLES.rglob("*.scene"))}


def main(names: Sequence[str]) -> None:
    """Print a table: fill and offset, in percent, for each of ``SIZES``."""
    scenes = example_scenes() | {name: evaluate(text) for name, text in SCENES.items()}
    rows = []
    for name, scene in scenes.items():
        if names and name not in names:
            continue
        frame = len(scene.frames) // 2 if scene.animated else None
        rows.append((name, [of_still(scene, Viewpoint(), size, frame) for size in SIZES]))
        if scene.animated:
            rows.append((f"{name}, film", [of_film(scene, Viewpoint(), size, 6) for size in SIZES]))
    for name, text in FILMS.items():
        scene = evaluate(text)
        rows.append((f"{name}, frame 0", [of_still(scene, Viewpoint(), size, 0) for size in SIZES]))
        rows.append((f"{name}, film", [of_film(scene, Viewpoint(), size) for size in SIZES]))
        rows.append((f"{name}, orbit", [of_film(scene, Viewpoint(), size, None, 180.0) for size in SIZES]))
    for name in ("cone", "plank", "spiral"):
        if not names or name in names:
            rows.append((f"{name}, turntable", [of_film(scenes[name], Viewpoint(), size, 12) for size in SIZES]))
    for name, found in rows:
        print(f"{name:28}", "   ".join(map(str, found)))
    every = [each for _, found in rows for each in found]
    fills = [each.fill for each in every]
    within = sum(0.88 <= each.fill <= 0.94 and each.offset <= 0.01 for each in every)
    print(f"{within} of {len(every)} within; fill {min(fills):.3f} to {max(fills):.3f}, median {np.median(fills):.3f}; "
          f"offset at most {max(each.offset for each in every):.4f}", file=sys.stderr)  # fmt: skip
    assert math.isfinite(sum(fills))


if __name__ == "__main__":
    main(sys.argv[1:])
