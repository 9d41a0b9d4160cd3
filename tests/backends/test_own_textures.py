"""Mesh files keep their images and texture coordinates: in drafts and final images, the viewer and exports."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import scenelang as sl
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.viewer.packet import packet_of

trimesh = pytest.importorskip("trimesh")
SIZE = 96
CORNERS = {(0.25, 0.25): (255, 0, 0), (0.75, 0.25): (0, 255, 0), (0.25, 0.75): (0, 0, 255), (0.75, 0.75): (255, 255, 0)}


def image_of() -> Image.Image:
    """Four squares: red, green above blue, yellow."""
    pixels = np.zeros((64, 64, 3), np.uint8)
    for (x, y), color in CORNERS.items():
        pixels[int(y * 64) - 16 : int(y * 64) + 16, int(x * 64) - 16 : int(x * 64) + 16] = color
    return Image.fromarray(pixels)


def square(
    folder: Path, name: str = "a.glb", image: bool = True, factor: tuple[int, ...] = (255, 255, 255, 255)
) -> Path:
    """Write a square of two triangles that faces +z, from -1 to 1, with the image on all of it."""
    vertices = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=image_of() if image else None, baseColorFactor=list(factor), name="m"
    )
    visual = trimesh.visual.TextureVisuals(uv=np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float), material=material)
    mesh = trimesh.Trimesh(vertices, [[0, 1, 2], [0, 2, 3]], visual=visual, process=False)
    mesh.export(folder / name)
    return folder / name


def loaded(folder: Path, attributes: str = "", name: str = "a.glb") -> sl.Scene:
    (folder / "a.scene").write_text(f'(bind "a" (lambda () (call "mesh" :file "{name}" {attributes})))')
    return sl.load(folder / "a.scene")


def seen(scene: sl.Scene, quality: str = "draft", environment: str = "flat") -> np.ndarray:
    """Return the square, which fills the image."""
    camera = Viewpoint(0.0, 0.0, orthographic=True, target=(0.0, 0.0, 0.0), distance=3.7321)
    settings: dict[str, Any] = {"samples": 64, "bounces": 2} if quality == "final" else {}
    options = PictureOptions(width=SIZE, height=SIZE, camera=camera, environment=environment, ground="none",
                             settings=settings)  # fmt: skip
    return draw(scene.graph, options, picture_backend(quality)).picture


def quarters(picture: np.ndarray) -> list[tuple[int, ...]]:
    return [tuple(picture[int(y * SIZE), int(x * SIZE)].tolist()) for x, y in CORNERS]


@pytest.mark.parametrize("name", ["a.glb", "a.gltf", "a.obj"])
def test_the_image_of_a_file_is_seen_at_every_pixel(name: str, tmp_path: Path) -> None:
    square(tmp_path, name)
    picture = seen(loaded(tmp_path, name=name))
    assert quarters(picture) == list(CORNERS.values())


def test_a_factor_multiplies_the_image_and_a_color_replaces_it(tmp_path: Path) -> None:
    square(tmp_path, factor=(0, 255, 255, 255))
    assert quarters(seen(loaded(tmp_path))) == [(0, g, b) for _, g, b in CORNERS.values()]
    assert quarters(seen(loaded(tmp_path, ":color [1 0 0]"))) == [(255, 0, 0)] * 4


def test_draft_and_final_show_the_same(tmp_path: Path) -> None:
    pytest.importorskip("mitsuba")
    square(tmp_path)
    scene = loaded(tmp_path)
    first, second = (seen(scene, quality, "overcast")[4:-4, 4:-4].astype(float) for quality in ("draft", "final"))
    assert np.corrcoef(first.reshape(-1), second.reshape(-1))[0, 1] > 0.97


def test_an_image_lies_by_the_coordinates_of_the_file(tmp_path: Path) -> None:
    square(tmp_path, image=False)
    image_of().save(tmp_path / "own.png")
    scene = loaded(tmp_path, ':texture (texture "own.png" :projection "uv")')
    assert quarters(seen(scene)) == list(CORNERS.values())
    halved = seen(loaded(tmp_path, ':texture (texture "own.png" :projection "uv" :scale .5)'))
    repeated = [
        tuple(halved[int((y / 2 + down) * SIZE), int((x / 2 + right) * SIZE)].tolist())
        for down, right in ((0, 0), (0, 0.5), (0.5, 0), (0.5, 0.5))
        for x, y in CORNERS
    ]
    assert repeated == list(CORNERS.values()) * 4
    scene.export(tmp_path / "b.glb")
    (back,) = trimesh.load(tmp_path / "b.glb").dump()
    assert np.abs(back.visual.uv - (back.vertices[:, :2] + 1) / 2).max() < 1e-6


def test_the_viewer_has_the_coordinates_of_the_file(tmp_path: Path) -> None:
    square(tmp_path)
    data = packet_of(loaded(tmp_path, ':texture (texture "brick" :projection "uv")').graph)
    assert b"geometry0Chart" in data
    assert b"geometry0Chart" not in packet_of(loaded(tmp_path, ':texture "brick"').graph)


@pytest.mark.parametrize("how", ["draft", "viewer", "export"])
def test_a_file_without_coordinates_says_so(how: str, tmp_path: Path) -> None:
    trimesh.creation.box().export(tmp_path / "a.stl")
    scene = loaded(tmp_path, ':texture (texture "brick" :projection "uv")', "a.stl")
    ways = {
        "draft": lambda: scene.render(size=(16, 16)),
        "viewer": lambda: packet_of(scene.graph),
        "export": lambda: scene.export(tmp_path / "b.glb"),
    }
    with pytest.raises(sl.SceneError, match="coordinates"):
        ways[how]()


def test_only_mesh_files_have_coordinates() -> None:
    scene = sl.evaluate('(bind "a" (lambda () (call "cube" :texture (texture "brick" :projection "uv"))))')
    with pytest.raises(sl.SceneError, match="only mesh files have"):
        scene.render(size=(16, 16))
