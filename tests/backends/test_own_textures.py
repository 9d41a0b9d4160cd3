"""Mesh files keep their images and texture coordinates: in drafts and final images, the viewer and exports."""

from __future__ import annotations

import io
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
    assert b"geometry0Chart" in packet_of(loaded(tmp_path).graph), "the image of the file is one, too"


@pytest.mark.parametrize("name", ["b.glb", "b.gltf", "b.obj"])
@pytest.mark.parametrize("more", [{}, {"settings": {"depth": 0}}])
def test_exports_carry_the_image_with_the_coordinates_of_the_file(
    name: str, more: dict[str, Any], tmp_path: Path
) -> None:
    square(tmp_path, factor=(0, 255, 255, 255))
    loaded(tmp_path).export(tmp_path / name, **more)
    assert quarters(seen(loaded(tmp_path, name=name))) == [(0, g, b) for _, g, b in CORNERS.values()]


def test_usd_carries_the_image_with_the_coordinates_of_the_file(tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.Usd")
    square(tmp_path)
    loaded(tmp_path).export(tmp_path / "b.usda")
    stage = usd.Stage.Open(str(tmp_path / "b.usda"))
    prims = list(stage.TraverseAll())
    (file,) = [str(a.Get().path) for p in prims if (a := p.GetAttribute("inputs:file")) and a.Get() is not None]
    with Image.open(tmp_path / file) as image:
        assert (np.asarray(image.convert("RGB")) == np.asarray(image_of())).all()
    (mesh,) = [p for p in prims if p.GetTypeName() == "Mesh"]
    points, st = (np.array(mesh.GetAttribute(key).Get())[:, :2] for key in ("points", "primvars:st"))
    assert np.allclose(st, (points + 1) / 2)


def several(folder: Path) -> None:
    """Write a file of two squares with an image each and a green one without, side by side."""
    scene = trimesh.Scene()
    for x, image in enumerate((image_of(), Image.new("RGB", (8, 8), (200, 0, 200)), None)):
        material = trimesh.visual.material.PBRMaterial(baseColorTexture=image, baseColorFactor=[255, 255, 255, 255])
        if image is None:
            material.baseColorFactor = [0, 255, 0, 255]
        material.name = f"m{x}"
        corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
        vertices = np.column_stack([corners[:, 0] + x, corners[:, 1], np.zeros(4)])
        visual = trimesh.visual.TextureVisuals(uv=corners, material=material)
        scene.add_geometry(trimesh.Trimesh(vertices, [[0, 1, 2], [0, 2, 3]], visual=visual, process=False))
    scene.export(folder / "a.glb")


def test_a_file_of_several_images_is_parts_in_exports(tmp_path: Path) -> None:
    several(tmp_path)
    first = loaded(tmp_path)
    camera = "azimuth=0,elevation=0,orthographic"
    drawn = first.render(size=(120, 50), camera=camera, environment="flat")
    first.export(tmp_path / "b.glb")
    parts = trimesh.load(tmp_path / "b.glb").dump()
    assert sorted(getattr(part.visual.material.baseColorTexture, "size", (0, 0)) for part in parts) == [
        (0, 0), (8, 8), (64, 64),
    ]  # fmt: skip
    again = loaded(tmp_path, name="b.glb").render(size=(120, 50), camera=camera, environment="flat")
    assert np.array_equal(np.asarray(drawn), np.asarray(again))


@pytest.mark.parametrize("more", ["", "mirrored"])
def test_3mf_carries_the_image_with_the_coordinates_of_the_file(more: str, tmp_path: Path) -> None:
    lib3mf = pytest.importorskip("lib3mf")
    square(tmp_path)
    pose = "(scale [-1 1 1])" if more else "(translate [1 0 0])"
    call = f'(union (transform (call "mesh" :file "a.glb") {pose}) (call "cube" :texture "brick" :scale .1))'
    (tmp_path / "a.scene").write_text(f'(bind "a" (lambda () {call}))')
    sl.load(tmp_path / "a.scene").export(tmp_path / "b.3mf")
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "b.3mf"))
    assert reader.GetWarningCount() == 0
    meshes, found = model.GetMeshObjects(), {}
    while meshes.MoveNext():
        mesh = meshes.GetCurrentMeshObject()
        found[mesh.GetName()] = mesh
    assert found.keys() == {"mesh", "cube"}
    images = {}
    for name, mesh in found.items():
        properties = mesh.GetTriangleProperties(0)
        group = model.GetTexture2DGroupByID(properties.ResourceID)
        data = bytes(group.GetTexture2D().GetAttachment().WriteToBuffer())
        with Image.open(io.BytesIO(data)) as image:
            images[name] = np.asarray(image.convert("RGB"))
        for triangle in range(mesh.GetTriangleCount() if name == "mesh" else 0):
            properties = mesh.GetTriangleProperties(triangle)
            for corner, place in zip(mesh.GetTriangle(triangle).Indices, properties.PropertyIDs, strict=True):
                x, y, _ = mesh.GetVertex(corner).Coordinates
                at = group.GetTex2Coord(place)
                assert pytest.approx((((-x if more else x) + 1) / 2, (y + 1) / 2)) == (at.U, at.V)
    assert (images["mesh"] == np.asarray(image_of())).all()
    assert images["cube"].shape == (512, 512, 3)


@pytest.mark.parametrize("name", ["b.ply", "b.stl"])
def test_files_without_images_have_the_colors_of_the_triangles(name: str, tmp_path: Path) -> None:
    square(tmp_path)
    assert [path.name for path in loaded(tmp_path).export(tmp_path / name)] == [name]
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize("how", ["draft", "viewer", "export"])
def test_a_file_without_coordinates_says_so(how: str, tmp_path: Path) -> None:
    trimesh.creation.box().export(tmp_path / "a.stl")
    scene = loaded(tmp_path, ':texture (texture "brick" :projection "uv")', "a.stl")
    ways = {
        "draft": lambda: scene.render(size=(16, 16)),
        "viewer": lambda: packet_of(scene.graph),
        "export": lambda: scene.export(tmp_path / "b.glb"),
    }
    with pytest.raises(sl.SceneError, match='the mesh file of "mesh" has no texture coordinates'):
        ways[how]()


def test_only_mesh_files_have_coordinates() -> None:
    scene = sl.evaluate('(bind "a" (lambda () (call "cube" :texture (texture "brick" :projection "uv"))))')
    with pytest.raises(sl.SceneError, match="only mesh files have"):
        scene.render(size=(16, 16))
