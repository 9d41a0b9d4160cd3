"""Every pattern and an image on six shapes, and the colors that their points have by the definition of textures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.backends.surfaces.tiles import coordinates, tile_of
from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.primitives.textures import PATTERNS, PROJECTIONS
from scenelang.session.session import Session

SHAPES = {
    "cube": '(call "cube" :scale [1.2 .8 1] {})',
    "sphere": '(call "sphere" :radius .6 {})',
    "cylinder": '(call "cylinder" :radius .5 :p0 [0 -.6 0] :p1 [0 .6 0] {})',
    "cone": '(call "cone" :radius .6 :p0 [0 -.5 0] :p1 [.2 .6 0] {})',
    "torus": '(call "torus" :radius .5 :tube .2 {})',
    "holed": '(difference (list {}) (list (call "cylinder" :radius .3 :p0 [0 0 -2] :p1 [.2 0 2])))',
}
BLOCK = '(call "cube" :scale [1.1 1 .7] {})'
IMAGE = "photo.png"
NEAR = 3.0  # of 255
SHIFTS = (-4.0, -2.0, 0.0, 2.0, 4.0)  # pixels

OF_SHAPES = [name for name in PROJECTIONS if name != "uv"]  # which only mesh files have


@dataclass(frozen=True)
class Textured:
    """A primitive with a texture: what it is, its place in the world, and its entity."""

    name: str
    place: np.ndarray  # (3,)
    entity: Entity

    def colors(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sRGB of world points (N, 3) on faces with normals (N, 3), of 255, and where the image is flat (N,).

        It is not at the axis of projections around one, nor where turned patterns do not meet themselves behind it.
        """
        texture = look_of(self.entity).texture
        assert texture is not None
        own = points - self.place
        uv = coordinates(texture, own, normals)
        tile = tile_of(texture)
        height, width = tile.image.shape[:2]

        def srgb(across: float, up: float) -> np.ndarray:
            """The colors that many pixels beside the points."""
            moved = uv + np.array([across / width, up / height])
            return 255.0 * to_srgb(np.clip(tile.at(moved, np.zeros(len(uv))), 0.0, 1.0))

        around = np.stack([srgb(x, y) for x in SHIFTS for y in SHIFTS])
        flat = (np.ptp(around, axis=0) <= NEAR).all(axis=1)
        if texture.projection in ("cylindrical", "spherical"):
            flat &= np.hypot(own[:, 0], own[:, 2]) > 0.06
            flat &= ~((own[:, 2] < 0.0) & (np.abs(own[:, 0]) < 0.08))
        return srgb(0.0, 0.0), flat


def textured_scene(folder: Path) -> tuple[Scene, list[Textured]]:
    """A scene of every texture on every shape, each with another projection and turn, in a row for each shape."""
    ramp = np.indices((96, 64))
    pixels = np.stack([40 + 2 * ramp[0], 250 - 3 * ramp[1], 60 + 100 * (ramp[0] > 48)], axis=2)
    Image.fromarray(pixels.astype(np.uint8)).save(folder / IMAGE)
    parts, names = [], []
    for row, (shape, form) in enumerate(SHAPES.items()):
        for column, name in enumerate([*PATTERNS, IMAGE]):
            projection = OF_SHAPES[(row + column) % len(OF_SHAPES)]
            text = ' :text "Ab"' if name == "text" else ""
            given = f':texture (texture "{name}" :projection "{projection}" :turn {10 * (column % 3)}{text})'
            solid = form.format(BLOCK.format(given) if shape == "holed" else given)
            parts.append(f"(transform {solid} (translate [{2 * column} {2 * row} 0]))")
            names.append(f"{shape}, {name}, {projection}")
    program = f'(bind "all" (lambda () (union {" ".join(parts)})))'
    scene = Session().evaluate(Source(str(folder / "textured.scene"), program)).scene
    assert scene is not None
    places = [np.array(part.cdr).reshape(3, 4)[:, 3] for part in scene.root.children]
    entities = [part.car for part in scene.root.children]
    return scene, [Textured(*row) for row in zip(names, places, entities, strict=True)]


def nearest(points: np.ndarray) -> np.ndarray:
    """The number (N,) of the object of ``textured_scene`` that world points (N, 3) are on."""
    columns = len(PATTERNS) + 1
    cells = np.rint(points / 2.0).astype(int)
    return np.asarray(cells[:, 1] * columns + cells[:, 0])


def sampled(corners: np.ndarray, uv: np.ndarray, count: int = 600) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random points on triangles (F, 3, 3), the normals of these, and the coordinates of textures (N, 2) there."""
    random = np.random.default_rng(1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    rows = random.choice(len(corners), count, p=areas / areas.sum())
    weights = random.dirichlet((1.0, 1.0, 1.0), count)[:, :, None]
    return (corners[rows] * weights).sum(axis=1), normals[rows], (uv[rows] * weights).sum(axis=1)


def pixels_at(image: Image.Image, uv: np.ndarray) -> np.ndarray:
    """The nearest pixels (N, 3) of a repeating image, whose first row is at v = 1."""
    pixels = np.asarray(image.convert("RGB"), float)
    height, width = pixels.shape[:2]
    column = np.floor((uv[:, 0] % 1.0) * width).astype(int) % width
    row = np.floor((1.0 - uv[:, 1] % 1.0) * height).astype(int) % height
    return np.asarray(pixels[row, column])


def worst(
    objects: list[Textured], rows: Iterator[tuple[int, np.ndarray, np.ndarray, np.ndarray]]
) -> dict[str, tuple[float, float]]:
    """The largest difference of colors of each object where its image is flat, and the share of points that are.

    ``rows`` has the number of an object, points, normals and the colors of a file.
    """
    found = {}
    for number, points, normals, colors in rows:
        wanted, flat = objects[number].colors(points, normals)
        found[objects[number].name] = (float(np.abs(colors - wanted)[flat].max(initial=0.0)), float(flat.mean()))
    return found
