"""Textures in USD and OBJ files, read by usd-core and by hand, have the colors of the definition at points of surfaces."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support import evaluate

import scenelang as sl
from exports.gltf_reader import Gltf
from exports.textured import NEAR, Textured, nearest, pixels_at, sampled, textured_scene, worst
from scenelang.backends.base import Backend, BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.exports.mesh_files import OBJ, PLY, STL
from scenelang.backends.exports.threemf import THREE_MF
from scenelang.backends.exports.usd import USD
from scenelang.backends.surfaces.appearance import look_of
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.scene.entity import Scene, descendants

Rows = Iterator[tuple[int, np.ndarray, np.ndarray, np.ndarray]]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Scene, list[Textured]]:
    return textured_scene(tmp_path_factory.mktemp("textured"))


def check(objects: list[Textured], rows: Rows) -> None:
    found = worst(objects, rows)
    assert len(found) == len(objects) == 72
    assert {name: one for name, one in found.items() if one[0] > NEAR} == {}
    assert np.mean([share for _, share in found.values()]) > 0.3


def usd_rows(path: Path) -> Rows:
    """What usd-core says of each textured mesh: the coordinates by the name that its material reads, its image."""
    from pxr import Usd, UsdGeom, UsdShade

    stage = Usd.Stage.Open(str(path))
    places = UsdGeom.XformCache()
    for prim in Usd.PrimRange(stage.GetDefaultPrim(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        if not prim.IsA(UsdGeom.Mesh):
            continue
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        source = material.ComputeSurfaceSource()[0].GetInput("diffuseColor").GetConnectedSources()[0][0].source
        image = UsdShade.Shader(source.GetPrim())
        assert image.GetIdAttr().Get() == "UsdUVTexture"
        assert {image.GetInput(f"wrap{side}").Get() for side in "ST"} == {"repeat"}
        assert image.GetInput("sourceColorSpace").Get() == "sRGB"
        reader = UsdShade.Shader(image.GetInput("st").GetConnectedSources()[0][0].source.GetPrim())
        primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar(reader.GetInput("varname").Get())
        faces = np.array(prim.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3)
        uv = np.array(primvar.ComputeFlattened(), float)
        uv = uv[faces] if primvar.GetInterpolation() == "vertex" else uv.reshape(-1, 3, 2)
        world = np.array(places.GetLocalToWorldTransform(prim)).T
        corners = (np.array(prim.GetAttribute("points").Get(), float) @ world[:3, :3].T + world[:3, 3])[faces]
        points, normals, at = sampled(corners, uv)
        (number,) = np.unique(nearest(points))
        file = opened(image.GetInput("file").Get().resolvedPath)
        yield int(number), points, normals, pixels_at(file, at)


def opened(path: str) -> Image.Image:
    """An image that a stage refers to, also within a package."""
    from pxr import Ar

    return Image.open(io.BytesIO(Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path)).GetBuffer()))


@pytest.mark.parametrize("ending", [".usda", ".usdc", ".usdz"])
def test_usd(ending: str, made: tuple[Scene, list[Textured]], tmp_path: Path) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    from pxr import Usd

    from exports.usd_reader import complaints

    scene, objects = made
    path = tmp_path / f"été 1{ending}"
    USD.run(scene, path, BackendOptions())
    check(objects, usd_rows(path))
    assert complaints(Usd.Stage.Open(str(path))) == []
    assert len(list(tmp_path.iterdir())) == (1 if ending == ".usdz" else 13)


def obj_rows(path: Path) -> Rows:
    """The textured objects of an OBJ file, with the images of its materials."""
    lines = [line.split() for line in path.read_text().splitlines()]
    points, uv = (np.array([line[1:4] for line in lines if line[:1] == [key]], float) for key in ("v", "vt"))
    images, name = {}, ""
    for line in path.with_suffix(".mtl").read_text().splitlines():
        key, _, value = line.partition(" ")
        name = value if key == "newmtl" else name
        if key == "map_Kd":
            images[name] = Image.open(path.parent / value)
    faces: list[tuple[str, list[list[int]]]] = []
    for line in lines:
        if line[:1] == ["usemtl"]:
            faces.append((line[1], []))
        elif line[:1] == ["f"]:
            faces[-1][1].append([int(number) for corner in line[1:] for number in corner.split("/")])
    for material, numbers in faces:
        corner = np.array(numbers).reshape(-1, 3, 3) - 1
        at, normals, coordinates = sampled(points[corner[:, :, 0]], uv[corner[:, :, 1]])
        (number,) = np.unique(nearest(at))
        yield int(number), at, normals, pixels_at(images[material], coordinates)


def test_obj(made: tuple[Scene, list[Textured]], tmp_path: Path) -> None:
    scene, objects = made
    path = tmp_path / "été 1.obj"
    OBJ.run(scene, path, BackendOptions())
    check(objects, obj_rows(path))
    assert len(list(tmp_path.iterdir())) == 14


@pytest.mark.parametrize(
    ("given", "form"),
    [
        (':texture "brick"', '(call "cube" {})'),
        (':material "gold"', '(call "sphere" {})'),
        (':texture "wood" :material "oak"', '(difference (list (call "cube" {})) (list (call "cylinder" :radius .2)))'),
    ],
)
def test_a_body_has_the_mean_color_and_the_surface_of_its_first_part(given: str, form: str, tmp_path: Path) -> None:
    """What `--solid` joins has no textures, which it says, but their colors and the substances' other values."""
    scene = evaluate(f'(bind "it" (lambda () {form.format(given)}))')
    (look,) = {look_of(entity) for entity in descendants(scene.root) if entity.is_primitive}
    warned: list[Diagnostic] = []
    GLTF.run(scene, tmp_path / "a.glb", BackendOptions(settings={"solid": True}, warn=warned.append))
    (one,) = Gltf(tmp_path / "a.glb").seen()
    assert one.colors[0] == pytest.approx(look.color, abs=1e-4)
    values = one.material["pbrMetallicRoughness"]
    assert (values["metallicFactor"], values["roughnessFactor"]) == pytest.approx((look.metallic, look.gloss))
    assert [each.name for each in warned] == (["lost-attribute"] if "texture" in given else [])


@pytest.mark.parametrize(
    ("backend", "ending", "says"),
    [(PLY, ".ply", True), (THREE_MF, ".3mf", False), (STL, ".stl", False), (OBJ, ".obj", False), (GLTF, ".glb", False)],
)
def test_formats_without_textures_say_so_once(backend: Backend, ending: str, says: bool, tmp_path: Path) -> None:
    """An STL file has no colors at all."""
    scene = evaluate('(bind "it" (lambda () (list (call "cube" :texture "brick") (call "cone" :texture "dots"))))')
    warned: list[Diagnostic] = []
    backend.run(scene, tmp_path / f"a{ending}", BackendOptions(warn=warned.append))
    assert [each.message for each in warned] == (
        [f"a{ending} has the mean color instead of the textures of 2 primitives"] if says else []
    )


def test_a_relief_is_a_normal_map_of_its_slopes(tmp_path: Path) -> None:
    """A gradient falls by bump * scale over half of its period of scale and rises again: its slopes are 2 * bump."""
    bump = 0.2
    scene = sl.evaluate(f'(bind "a" (lambda () (call "cube" :texture (texture "gradient" :scale .7 :bump {bump}))))')
    document = gltf_of(scene, tmp_path)
    (material,) = document["materials"]
    images = [picture_in(document, tmp_path, texture["source"]) for texture in document["textures"]]
    normals = images[material["normalTexture"]["index"]].astype(float) / 127.5 - 1.0
    middle = normals[len(normals) // 4, 0], normals[3 * len(normals) // 4, 0]
    # at v = .75 heights rise along v, at v = .25 they fall
    for normal, slope in zip(middle, (2 * bump, -2 * bump), strict=True):
        wanted = np.array([0.0, -slope, 1.0]) / np.hypot(1.0, slope)
        assert np.abs(normal - wanted).max() < 0.02
    assert "sampler" not in document["textures"][0]


def test_a_decal_is_shown_once(tmp_path: Path) -> None:
    scene = sl.evaluate('(bind "a" (lambda () (call "cube" :texture (texture "text" :text "A" :side "front"))))')
    document = gltf_of(scene, tmp_path)
    (texture,) = document["textures"]
    assert document["samplers"][texture["sampler"]] == {"wrapS": 33071, "wrapT": 33071}
    scene.export(tmp_path / "a.obj")
    assert "map_Kd -clamp on a-obj-text.png" in (tmp_path / "a.mtl").read_text()
    pxr = pytest.importorskip("pxr.Usd")
    scene.export(tmp_path / "a.usda")
    stage = pxr.Stage.Open(str(tmp_path / "a.usda"))
    wraps = [p.GetAttribute("inputs:wrapS").Get() for p in stage.Traverse() if p.GetAttribute("inputs:wrapS")]
    assert wraps == ["clamp"]


def gltf_of(scene: sl.Scene, folder: Path) -> dict[str, Any]:
    """Export a scene as .gltf and return its document."""
    scene.export(folder / "a.gltf")
    return json.loads((folder / "a.gltf").read_text())  # type: ignore[no-any-return]


def picture_in(document: dict[str, Any], folder: Path, number: int) -> np.ndarray:
    """Return the pixels (H, W, 3) of an image of a document."""
    view = document["bufferViews"][document["images"][number]["bufferView"]]
    data = (folder / document["buffers"][view["buffer"]]["uri"]).read_bytes()
    start = view.get("byteOffset", 0)
    return np.asarray(Image.open(io.BytesIO(data[start : start + view["byteLength"]])).convert("RGB"))
