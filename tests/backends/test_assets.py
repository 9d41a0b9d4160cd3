"""Mesh files as assets: colors of every kind, limits, and files that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from later import later
from PIL import Image

import scenelang
from scenelang.backends.pictures.camera import PRESETS
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.backends.surfaces import assets
from scenelang.backends.surfaces.assets import load_asset
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.grammar.diagnostics import SceneError

trimesh = later("trimesh")

RED = np.array([200, 40, 20, 255], np.uint8)


def colored(kind: str) -> trimesh.Trimesh:
    box = trimesh.creation.box((2.0, 0.2, 2.0))
    if kind == "vertex":
        box.visual.vertex_colors = RED
    elif kind == "face":
        box.visual.face_colors = RED
    elif kind == "material":
        material = trimesh.visual.material.PBRMaterial(name="paint", baseColorFactor=[0.02, 0.5, 0.9, 1.0])
        box.visual = trimesh.visual.TextureVisuals(material=material)
    else:
        image = Image.new("RGB", (8, 8), (200, 40, 20))
        uv = np.full((len(box.vertices), 2), 0.5)
        material = trimesh.visual.material.PBRMaterial(baseColorTexture=image)
        box.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return box


@pytest.mark.parametrize(
    ("kind", "ending", "expected"),
    [
        ("vertex", ".ply", from_srgb(RED[:3] / 255.0)),
        ("face", ".ply", from_srgb(RED[:3] / 255.0)),
        ("vertex", ".glb", RED[:3] / 255.0),  # glTF's vertex colors are linear
        ("material", ".glb", np.array([0.02, 0.5, 0.9])),
        ("material", ".gltf", np.array([0.02, 0.5, 0.9])),
        ("texture", ".glb", from_srgb(RED[:3] / 255.0)),
        ("texture", ".obj", from_srgb(RED[:3] / 255.0)),
        ("vertex", ".stl", None),
        ("vertex", ".off", None),
    ],
)
def test_colors_of_files(tmp_path: Path, kind: str, ending: str, expected: np.ndarray | None) -> None:
    path = tmp_path / f"a{ending}"
    if ending == ".gltf":
        for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(colored(kind))).items():
            (tmp_path / (path.name if name == "model.gltf" else name)).write_bytes(data)
    else:
        colored(kind).export(path)
    mesh = load_asset(path)
    assert len(mesh.faces) == 12
    if expected is None:
        assert mesh.colors is None or ending == ".off"
        return
    assert mesh.colors is not None
    assert mesh.colors == pytest.approx(np.tile(expected, (12, 1)), abs=3e-3)


def test_parts_of_one_file_keep_their_colors_where_they_touch(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    for name, x, color in (("a", 0.0, (1.0, 0.0, 0.0, 1.0)), ("b", 1.0, (0.0, 0.0, 1.0, 1.0))):
        box = trimesh.creation.box((1, 1, 1), trimesh.transformations.translation_matrix((x, 0, 0)))
        box.visual = trimesh.visual.TextureVisuals(
            material=trimesh.visual.material.PBRMaterial(name=name, baseColorFactor=color)
        )
        scene.add_geometry(box, node_name=name, geom_name=name)
    scene.export(tmp_path / "a.glb")
    mesh = load_asset(tmp_path / "a.glb")
    assert mesh.colors is not None
    first = np.arange(24) < 12  # whichever part comes first
    left = first if mesh.corners[first].mean() < mesh.corners[~first].mean() else ~first
    assert mesh.colors[left] == pytest.approx(np.tile([1.0, 0, 0], (12, 1)))
    assert mesh.colors[~left] == pytest.approx(np.tile([0, 0, 1.0], (12, 1)))


def test_a_color_replaces_the_files_own(tmp_path: Path) -> None:
    colored("material").export(tmp_path / "a.glb")
    middles = []
    for more in ("", ":color [.8 .1 .1]"):
        (tmp_path / "a.scene").write_text(f'(bind "copy" (lambda () (call "mesh" :file "a.glb" {more})))')
        options = PictureOptions(width=32, height=32, environment="flat", camera=PRESETS["top"])
        middles.append(render(scenelang.load(tmp_path / "a.scene").graph, options)[16, 16].astype(int))
    assert middles[0][2] > 200 > middles[0][0]
    assert middles[1][0] > 200 > middles[1][2]


def test_too_large_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    colored("vertex").export(tmp_path / "a.ply")
    monkeypatch.setattr(assets, "MAX_TRIANGLES", 11)
    with pytest.raises(SceneError, match="12 triangles"):
        load_asset(tmp_path / "a.ply")
    monkeypatch.setattr(assets, "MAX_FILE_BYTES", 10)
    with pytest.raises(SceneError, match="bytes, more than"):
        load_asset(tmp_path / "a.ply")


BAD = {
    "empty.glb": b"",
    "short.glb": b"glTF\x02\x00\x00\x00",
    "noise.glb": bytes(range(256)) * 8,
    "noise.ply": b"ply\nformat ascii 1.0\nelement vertex 99999999\nend_header\n",
    "text.obj": b"v 1 2\nf 1 2 3\n",
    "points.obj": b"v 0 0 0\nv 1 0 0\n",
    "nan.obj": b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "half.stl": b"solid x\nfacet",
    "list.gltf": b"[]",
    "deep.gltf": b"[" * 100_000,
}


@pytest.mark.parametrize("name", list(BAD))
def test_files_that_are_no_meshes_are_told_in_one_line(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(BAD[name])
    with pytest.raises(SceneError) as caught:
        load_asset(path)
    assert caught.value.name == "file"
    assert "\n" not in caught.value.message
    assert len(caught.value.message) < 250


@pytest.mark.parametrize("name", ["a.zip", "a.py", "a", "a.xaml", "a.GLB.txt"])
def test_other_endings_are_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(SceneError, match="is not a supported mesh file"):
        load_asset(tmp_path / name)


def test_a_file_that_changes_is_read_again(tmp_path: Path) -> None:
    import os

    colored("vertex").export(tmp_path / "a.ply")
    assert len(load_asset(tmp_path / "a.ply").faces) == 12
    trimesh.creation.icosphere(subdivisions=1).export(tmp_path / "a.ply")
    os.utime(tmp_path / "a.ply", ns=(1, 1))
    assert len(load_asset(tmp_path / "a.ply").faces) == 80
