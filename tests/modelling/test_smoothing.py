"""Normals of computed surfaces: smooth across what turns little, sharp elsewhere."""

import numpy as np
import pytest

from scenelang.interpreter.scene.primitives.mesh import smoothed

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
                  [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip
ONE = np.zeros(12, np.int64)


def prism(sides: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed prism without inner edges of its ends but those of fans."""
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([np.cos(angle), np.zeros(sides), -np.sin(angle)], axis=1)
    vertices = np.concatenate([ring, ring + np.array([0, 1, 0])])
    here, after = np.arange(sides), (np.arange(sides) + 1) % sides
    walls = np.concatenate(
        [np.stack([here, after, sides + after], 1), np.stack([here, sides + after, sides + here], 1)]
    )
    fan = np.stack([np.zeros(sides - 2, int), np.arange(1, sides - 1), np.arange(2, sides)], 1)
    return vertices, np.concatenate([walls, fan[:, ::-1], fan + sides])


def test_a_cube_has_three_normals_at_each_corner() -> None:
    normals, corner, place = smoothed(CUBE, FACES, ONE, 40.0)
    assert len(normals) == 24
    assert sorted(np.bincount(place).tolist()) == [3] * 8
    assert np.abs(normals).max(axis=1) == pytest.approx(1.0)
    np.testing.assert_array_equal(place[corner], FACES)


def test_all_edges_of_a_cube_are_smooth_at_ninety_degrees() -> None:
    normals, _, place = smoothed(CUBE, FACES, ONE, 90.0)
    assert len(normals) == 8
    np.testing.assert_allclose(normals, (CUBE[place] - 0.5) * 2 / np.sqrt(3), atol=1e-12)


@pytest.mark.parametrize(("sides", "wall_normals"), [(24, 1), (8, 2)])  # 15 and 45 degrees
def test_walls_of_a_prism_are_smooth_from_so_many_sides_on(sides: int, wall_normals: int) -> None:
    vertices, faces = prism(sides)
    normals, corner, place = smoothed(vertices, faces, np.zeros(len(faces), np.int64), 40.0)
    assert np.bincount(place).tolist() == [wall_normals + 1] * len(vertices)
    np.testing.assert_allclose(normals[corner[-1]], [[0, 1, 0]] * 3, atol=1e-12)
    if wall_normals == 1:
        round_about = normals[corner[: 2 * sides]].reshape(-1, 3)
        np.testing.assert_allclose(round_about, vertices[faces[: 2 * sides].reshape(-1)] * [1, 0, 1], atol=1e-9)


def test_surfaces_do_not_share_normals() -> None:
    surface = np.array([0, 1, *[2] * 10])  # the first side is of two surfaces, though flat
    normals, corner, _ = smoothed(CUBE, FACES, surface, 40.0)
    assert len(normals) == 26
    assert not set(corner[0].tolist()) & set(corner[1].tolist())


def test_large_faces_stay_flat_beside_narrow_ones() -> None:
    width = 0.01
    section = np.array([[0, 0], [1, 0], [1, 1 - width], [1 - width * 0.4, 1 - width * 0.3], [1 - width, 1], [0, 1]])
    count = len(section)
    ring = np.stack([section[:, 0], section[:, 1], np.zeros(count)], 1)
    vertices = np.concatenate([ring, ring + np.array([0, 0, 1])])
    here, after = np.arange(count), (np.arange(count) + 1) % count
    walls = np.concatenate(
        [np.stack([here, after, count + after], 1), np.stack([here, count + after, count + here], 1)]
    )
    fan = np.stack([np.zeros(count - 2, int), np.arange(1, count - 1), np.arange(2, count)], 1)
    faces = np.concatenate([walls, fan[:, ::-1], fan + count])
    normals, corner, _ = smoothed(vertices, faces, np.zeros(len(faces), np.int64), 40.0)
    top = normals[corner[4]]  # between the points 4 and 5
    assert top[:, 1] == pytest.approx(1.0, abs=1e-3)


def test_faces_without_area_have_some_normal() -> None:
    faces = np.concatenate([FACES, [[0, 1, 1]]])
    normals, _, _ = smoothed(CUBE, faces, np.zeros(13, np.int64), 40.0)
    assert np.isfinite(normals).all()
