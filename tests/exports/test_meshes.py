"""OBJ, PLY and STL files, read back by trimesh or by hand and compared with ``flatten``."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from sampling import only
from searching import many

from exports.oracle import corners_of, example, expected, obj_corners, on_examples, same_points, scenes
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.mesh_files import OBJ, PLY, STL
from scenelang.backends.surfaces.image_files import from_srgb, to_srgb
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Scene

FEW = [pytest.param(f"{name}.scene") for name in ("jenga", "orrery", "strict", "toys")]


def points_and_colors(scene: Scene) -> np.ndarray:
    """Every vertex with its sRGB color (V, 6)."""
    rows = [np.hstack([o.vertices, np.tile(to_srgb(np.array(o.color)), (len(o.vertices), 1))]) for o in expected(scene)]
    return np.concatenate(rows) if rows else np.zeros((0, 6))


def ply_rows(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """The vertices of a PLY file with their colors (V, 6), and its faces (F, 3)."""
    head, _, body = path.read_bytes().partition(b"end_header\n")
    count, faces = (int(line.split()[-1]) for line in head.decode().splitlines() if line.startswith("element"))
    dtype = np.dtype([("p", "<f4", 3), ("n", "<f4", 3), ("c", "u1", 4)])
    rows = np.frombuffer(body, dtype, count)
    sides = np.frombuffer(body[rows.nbytes :], np.dtype([("k", "u1"), ("v", "<i4", 3)]))
    assert len(sides) == faces
    assert (sides["k"] == 3).all()
    assert np.allclose(np.linalg.norm(rows["n"], axis=1), 1.0, atol=1e-5)
    return np.hstack([rows["p"], rows["c"][:, :3] / 255.0]), sides["v"]


@pytest.mark.parametrize("name", on_examples())
@pytest.mark.sampled(3)
def test_ply_keeps_positions_and_colors(name: str, tmp_path: Path) -> None:
    scene = example(name)
    PLY.run(scene, tmp_path / "a.ply", BackendOptions())
    got, wanted = ply_rows(tmp_path / "a.ply")[0], points_and_colors(scene)
    assert np.allclose(got[:, :3], wanted[:, :3], atol=1e-5 * max(1.0, np.abs(wanted).max()))
    assert np.abs(got[:, 3:] - wanted[:, 3:]).max() <= 0.51 / 255


@settings(max_examples=many(40), deadline=None)
@given(scenes())
def test_ply_of_any_pose(scene: Scene) -> None:
    wanted = points_and_colors(scene)
    with tempfile.TemporaryDirectory() as folder:
        PLY.run(scene, Path(folder) / "a.ply", BackendOptions())
        got = ply_rows(Path(folder) / "a.ply")[0]
        PLY.run(scene, Path(folder) / "b.ply", BackendOptions(settings={"depth": 1}))
        parts = ply_rows(Path(folder) / "b.ply")[0]
    assert np.allclose(got[:, :3], wanted[:, :3], atol=2e-5)
    assert same_points(parts[:, :3], wanted[:, :3], 2e-5)
    assert same_points(np.sort(parts[:, 3:], axis=0), np.sort(got[:, 3:], axis=0), 1e-6)


@pytest.mark.parametrize("word", ["cube", "sphere", "cylinder", "cone"])
def test_trimesh_reads_ply_and_stl_as_closed_solids(word: str, make: Any, tmp_path: Path) -> None:
    import trimesh

    scene = make.scene((make.primitive(word), pose.reflection((0, 0, 0), (1, 2, 3))))
    for backend, ending in ((PLY, "ply"), (STL, "stl")):
        backend.run(scene, tmp_path / f"a.{ending}", BackendOptions())
        mesh = trimesh.load(tmp_path / f"a.{ending}", process=False)
        mesh.merge_vertices(merge_norm=True, merge_tex=True)
        assert mesh.is_watertight
        assert mesh.volume > 0.5  # the mirror image is not inside out


def _surfaces(scene: Scene) -> list[Any]:
    from scenelang.backends.exports.plan import surface_of

    found = [surface_of(one.entity) for one in expected(scene)]
    return [surface for surface in found if surface is not None]


@pytest.mark.parametrize("name", only(FEW, on_examples()))
def test_stl_has_every_triangle(name: str, tmp_path: Path) -> None:
    scene = example(name)
    STL.run(scene, tmp_path / "a.stl", BackendOptions())
    data = (tmp_path / "a.stl").read_bytes()
    dtype = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    rows = np.frombuffer(data[84:], dtype)
    wanted = [one.vertices[surface.faces] for one, surface in zip(expected(scene), _surfaces(scene), strict=True)]
    corners = np.concatenate(wanted)
    assert int.from_bytes(data[80:84], "little") == len(rows) == len(corners)
    centers = rows["v"].mean(axis=1)
    assert same_points(centers, corners.mean(axis=1), 1e-5)


def test_obj_names_objects_by_path_and_paints_them(make: Any, tmp_path: Path) -> None:
    leg = make.group("a leg", make.primitive("cube", color=(0.2, 0.5, 0.8), roughness=0.5))
    scene = make.scene(leg, (leg, make.chain()), make.primitive("sphere", opacity=0.5))
    OBJ.run(scene, tmp_path / "my table.obj", BackendOptions())
    lines = (tmp_path / "my table.obj").read_text().splitlines()
    assert "mtllib my table.mtl" in lines
    assert [line for line in lines if line.startswith("o ")] == [
        "o scene/a_leg/cube", "o scene/a_leg/cube.002", "o scene/sphere",
    ]  # fmt: skip
    materials = (tmp_path / "my table.mtl").read_text().split("newmtl ")[1:]
    kd = [float(x) for x in next(line for line in materials[0].splitlines() if line.startswith("Kd")).split()[1:]]
    assert from_srgb(np.array(kd)) == pytest.approx([0.2, 0.5, 0.8], abs=1e-5)
    assert "d 0.5" in materials[1].splitlines()
    assert "Pr 0.5" in materials[0].splitlines()


@pytest.mark.parametrize("name", ["strict.scene", "orrery.scene", "jenga.scene"])
@pytest.mark.sampled(3)
def test_obj_keeps_positions_and_colors(name: str, tmp_path: Path) -> None:
    import trimesh

    scene = example(name)
    OBJ.run(scene, tmp_path / "a.obj", BackendOptions())
    corners = obj_corners(tmp_path / "a.obj")
    wanted = np.concatenate([corners_of(one) for one in expected(scene)])
    assert np.allclose(corners[:, :3], wanted, rtol=1e-8, atol=1e-8)
    loaded = trimesh.load(tmp_path / "a.obj", process=False, group_material=False, split_objects=True)
    assert len(loaded.geometry) == len(list(expected(scene)))


def test_obj_of_parts_has_colored_vertices(tmp_path: Path) -> None:
    scene = example("jenga.scene")
    OBJ.run(scene, tmp_path / "a.obj", BackendOptions(settings={"depth": 0}))
    lines = (tmp_path / "a.obj").read_text().splitlines()
    corners = [corners_of(one) for one in expected(scene)]
    colors = [to_srgb(np.array(one.color)) for one in expected(scene)]
    wanted = [np.hstack([rows, np.tile(color, (len(rows), 1))]) for rows, color in zip(corners, colors, strict=True)]
    assert same_points(obj_corners(tmp_path / "a.obj")[:, :6], np.concatenate(wanted), 1e-6)
    assert len([line for line in lines if line.startswith("o ")]) == 1


@settings(max_examples=many(30), deadline=None)
@given(scenes())
def test_obj_of_any_pose_has_shared_points_and_outward_normals(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        OBJ.run(scene, Path(folder) / "a.obj", BackendOptions())
        corners = obj_corners(Path(folder) / "a.obj")
    wanted = list(expected(scene))
    points, normals = corners[:, :3].reshape(-1, 3, 3), corners[:, -3:].reshape(-1, 3, 3)
    middles = np.concatenate([corners_of(one).reshape(-1, 3, 3).mean(axis=1) for one in wanted])
    assert same_points(points.mean(axis=1), middles, 1e-6)
    across = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    sized = np.linalg.norm(across, axis=1) > 1e-6
    turned = np.einsum("fki,fki->fk", normals, np.roll(normals, 1, axis=1)).min(axis=1) < 0.0  # the rim of a flat ball
    assert turned.mean() < 0.2
    assert (np.einsum("fi,fi->f", across, normals.mean(axis=1))[sized & ~turned] > 0.0).all()


def test_a_box_in_obj_has_eight_points(make: Any, tmp_path: Path) -> None:
    OBJ.run(make.scene(make.primitive("cube")), tmp_path / "a.obj", BackendOptions())
    lines = (tmp_path / "a.obj").read_text().splitlines()
    assert [sum(line.startswith(f"{kind} ") for line in lines) for kind in ("v", "vn", "f")] == [8, 6, 12]


def test_too_much_is_refused_before_the_memory_is_gone(tmp_path: Path) -> None:
    scene = example("menger-sponge.scene", level=8)
    for backend in (OBJ, PLY, STL):
        with pytest.raises(LimitError, match="primitives"):
            backend.run(scene, tmp_path / f"a{backend.endings[0]}", BackendOptions())
    with pytest.raises(SceneError, match="depth"):
        PLY.run(scene, tmp_path / "a.ply", BackendOptions(settings={"depth": -1}))
    assert not list(tmp_path.iterdir())
