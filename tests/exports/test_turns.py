"""Poses as translation, rotation and scale."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exports.gltf_reader import _matrix
from scenelang.backends.exports.gltf import node_fields
from scenelang.backends.surfaces.trs import Decomposition, decompose, decompose_track


def product(turns: Decomposition, index: int) -> np.ndarray:
    out = np.eye(4)
    for fields in node_fields(turns, index):
        out = out @ _matrix({name: np.array(value) for name, value in fields.items()})
    return out[:3]


def some(rng: np.random.Generator, kind: int) -> np.ndarray:
    linear = rng.normal(size=(3, 3))
    if kind == 1:
        linear = np.linalg.qr(linear)[0] * rng.normal(size=3)
    if kind == 2:
        linear[:, rng.integers(3)] = 0.0
    if kind == 3:
        linear = np.linalg.qr(linear)[0] * (rng.normal(size=3) * rng.integers(0, 2, 3))
    if kind == 4:
        linear = np.diag(rng.choice([-1.0, 0.0, 1.0, 1e-9], 3))
    return np.concatenate([linear, rng.normal(size=(3, 1))], axis=1)


@given(st.integers(0, 10_000))
def test_any_affine_pose_is_one_or_two_nodes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = np.stack([some(rng, kind) for kind in (0, 1, 2, 3, 4)])
    turns = decompose(poses)
    for index, pose in enumerate(poses):
        assert product(turns, index) == pytest.approx(pose, abs=1e-9)
    assert turns.shears[0]
    assert not turns.shears[[1, 3, 4]].any()


@given(st.integers(0, 10_000))
def test_a_track_is_exact_whatever_happens_between_frames(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = [(1, 3, 4), (0, 1, 2, 3, 4)][seed % 2]
    poses = np.stack([some(rng, int(kind)) for kind in rng.choice(kinds, 6)])
    track = decompose_track(poses)
    assert track.shears.all() or not track.shears.any()
    for index, pose in enumerate(poses):
        assert product(track, index) == pytest.approx(pose, abs=1e-9)
    assert ((track.rotation[1:] * track.rotation[:-1]).sum(axis=1) >= 0.0).all()


@pytest.mark.parametrize("mirrored", [1.0, -1.0])
@pytest.mark.parametrize("sheared", [False, True])
@pytest.mark.parametrize("step", [0.2, 1.7, 3.0])
def test_turning_changes_no_scale(mirrored: float, sheared: bool, step: float) -> None:
    form = np.array([[mirrored, 0.3 * sheared, 0.0], [0.0, 2.0, 0.5 * sheared], [0.0, 0.0, 3.0]])
    poses = []
    for angle in np.arange(12) * step:
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        poses.append(np.concatenate([turn @ form, np.zeros((3, 1))], axis=1))
    track = decompose_track(np.stack(poses))
    assert np.abs(track.scale - track.scale[0]).max() < 1e-12
    assert np.abs(track.inner - track.inner[0]).max() < 1e-12


def test_growing_from_nothing_and_through_a_mirror_image_keeps_the_rotation() -> None:
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    sizes = [(0, 0, 0), (0, 1, 0), (1, 1, 0.5), (0.2, 1, 1), (-0.4, 1, 1), (-1, 0, 1)]
    poses = np.stack([np.concatenate([turn * size, np.zeros((3, 1))], axis=1) for size in sizes])
    track = decompose_track(poses)
    assert np.abs(track.rotation - track.rotation[0]).max() < 1e-12
    assert track.scale == pytest.approx(np.array(sizes, float), abs=1e-12)
