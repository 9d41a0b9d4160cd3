"""Boxes of mesh files are those of their vertices, whatever the pose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from later import later

import scenelang
from scenelang.backends.surfaces.assets import AssetFiles, PointSupport
from scenelang.interpreter.scene.bounds import entity_box, parts_box
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives import Primitive, shape_of
from scenelang.interpreter.values.values import ANONYMOUS, Matrix, Pair

trimesh = later("trimesh")


def points_of(kind: str, count: int, rng: np.random.Generator) -> np.ndarray:
    points = rng.normal(size=(count, 3)) * [1.0, 3.0, 0.1] + [5.0, -2.0, 0.0]
    if kind == "sphere":
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    elif kind == "flat":
        points[:, 2] = 0.25
    elif kind == "line":
        points[:, 1:] = [2.0, 3.0]
    elif kind == "lattice":
        points = rng.integers(-3, 4, (count, 3)).astype(float)
    elif kind == "far":
        points = points * 1e-3 + 1e6
    return points


@pytest.mark.parametrize("kind", ["cloud", "sphere", "flat", "line", "lattice", "far"])
@pytest.mark.parametrize("count", [1, 2, 63, 64, 65, 4000])
def test_the_reach_of_points_is_exact(kind: str, count: int) -> None:
    rng = np.random.default_rng(count)
    points = points_of(kind, count, rng)
    support = PointSupport(points)
    directions = [*rng.normal(size=(40, 3)) * 10.0 ** rng.integers(-3, 4, (40, 1)), *np.eye(3), np.zeros(3)]
    for a, b, c in np.array(directions).tolist():
        values = a * points[:, 0] + b * points[:, 1] + c * points[:, 2]
        assert support.interval(a, b, c) == (values.min(), values.max())


@pytest.fixture(scope="module")
def star(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    """A mesh with many points of its hull and some within it, and its vertices."""
    rng = np.random.default_rng(7)
    mesh = trimesh.creation.icosphere(subdivisions=3)
    mesh.vertices *= rng.uniform(0.5, 1.5, (len(mesh.vertices), 1)) * [2.0, 1.0, 0.5]
    path = tmp_path_factory.mktemp("assets") / "star.stl"
    mesh.export(path)
    return path, trimesh.load_mesh(path).vertices


def test_boxes_of_posed_meshes_are_those_of_their_vertices(star: tuple[Path, np.ndarray]) -> None:
    """Under any affine map, directly and through entities that are turned again."""
    path, vertices = star
    asset = AssetFiles(path.parent, path.parent, False).measure(path.name)
    shape: Primitive = shape_of("mesh", {"file": asset.path}, asset)
    leaf = Entity("mesh", ANONYMOUS, (), shape, False, ())
    rng = np.random.default_rng(3)
    for _ in range(50):
        first, second = rng.normal(size=(2, 3, 4))
        inner, outer = Matrix(first.ravel().tolist()), Matrix(second.ravel().tolist())
        posed = vertices @ first[:, :3].T + first[:, 3]
        assert shape.box_under(inner) == pytest.approx([*posed.min(axis=0), *posed.max(axis=0)], abs=1e-9)
        twice = posed @ second[:, :3].T + second[:, 3]
        group = Entity("group", ANONYMOUS, (Pair(leaf, inner),), None, False, ())
        found = parts_box((Pair(group, outer),))
        assert found == pytest.approx([*twice.min(axis=0), *twice.max(axis=0)], abs=1e-9)


def test_a_turned_asset_in_a_program(star: tuple[Path, np.ndarray], tmp_path: Path) -> None:
    path, vertices = star
    (path.parent / "a.scene").write_text(
        '(bind "it" (lambda () (transform (call "mesh" :file "star.stl") (rotate 0.7 [1 2 3]))))'
    )
    scene = scenelang.load(path.parent / "a.scene").graph
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])[:3, :3]
    posed = vertices @ turn.T
    assert entity_box(scene.root) == pytest.approx([*posed.min(axis=0), *posed.max(axis=0)], abs=1e-6)


def test_vertices_that_no_face_has_do_not_count(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 50 50 50\nf 1 2 3\n")
    asset = AssetFiles(tmp_path, tmp_path, False).measure("a.obj")
    assert asset.box == (0, 0, 0, 1, 1, 0)


def test_the_work_of_boxes_is_charged(star: tuple[Path, np.ndarray]) -> None:
    path, _ = star
    charged: list[int] = []
    asset = AssetFiles(path.parent, path.parent, False).measure(path.name, charged.append)
    assert sum(charged) >= path.stat().st_size >> 5
    leaf = Entity("mesh", ANONYMOUS, (), shape_of("mesh", {"file": asset.path}, asset), False, ())
    pose = Matrix((0.0, 1.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0))
    charged.clear()
    parts_box([Pair(leaf, pose)] * 100, charged.append)
    assert sum(charged) >= 100 * (len(asset.support) >> 4)


def test_numbers_too_large_are_no_warnings(recwarn: pytest.WarningsRecorder) -> None:
    support = PointSupport(np.array([(1e308, 0.0, 0.0), (1.0, 1e308, 0.0), (0.0, 1.0, 1e308)]))
    assert support.interval(1e150, 1e150, 0.0)[1] == np.inf
    assert not [warning for warning in recwarn if issubclass(warning.category, RuntimeWarning)]
