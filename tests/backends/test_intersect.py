"""The analytic caster against brute force."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.rays import NOTHING, camera_rays, caster_for, depths_of, ids_of
from scenelang.backends.pictures.stage import Stage, staging_of, still
from scenelang.backends.surfaces.solids import triangle_poses
from scenelang.interpreter.scene.primitives import standard_forms
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, nearest_hit
from scenelang.interpreter.scene.primitives.mesh import inverses_of, posed

BALL, BLOCK, CYLINDER, CONE, TRIANGLE = standard_forms()


def staged(scene: Any, view: Viewpoint, width: int, height: int) -> Stage:
    return staging_of(scene, [0], 1000).stage(still(scene, view, 0, width, height))


def inside(form: CanonicalForm, p: np.ndarray) -> np.ndarray:
    x, y, z = p[..., 0], p[..., 1], p[..., 2]
    if form == BALL:
        return x * x + y * y + z * z <= 1
    if form == BLOCK:
        return np.abs(p).max(axis=-1) <= 1
    radius = 1.0 if form == CYLINDER else (1 - y) / 2
    return (np.abs(y) <= 1) & (x * x + z * z <= radius * radius)


@pytest.mark.parametrize("form", [BALL, BLOCK, CYLINDER, CONE])
def test_intervals_agree_with_marching(form: CanonicalForm) -> None:
    rng = np.random.default_rng(standard_forms().index(form))
    o = rng.normal(size=(400, 3)) * 2
    d = rng.normal(size=(400, 3))
    d[:40, 0] = 0.0  # rays along planes and axes of the solids
    d[:20, 2] = 0.0
    o[:10, 0] = 0.3
    with np.errstate(all="ignore"):
        ((enter, leave),) = form.intervals(tuple(o.T), tuple(d.T), ())
    t = np.linspace(-8, 8, 4001)
    within = inside(form, o[:, None] + t[None, :, None] * d[:, None])
    step = t[1] - t[0]
    for k in range(len(o)):
        hits = t[within[k]]
        if len(hits) > 2:
            assert max(enter[k], -8) == pytest.approx(hits[0], abs=1.01 * step)
            assert min(leave[k], 8) == pytest.approx(hits[-1], abs=1.01 * step)
        elif not len(hits):
            assert not enter[k] < leave[k] - 3 * step or leave[k] < -8 or enter[k] > 8


@pytest.mark.parametrize("form", standard_forms())
def test_normals_stand_on_the_surface_and_point_out(form: CanonicalForm) -> None:
    rng = np.random.default_rng(3)
    mesh = form.mesh(512, ())
    chosen = mesh.faces[rng.integers(len(mesh.faces), size=300)]
    weights = rng.dirichlet(np.ones(3) * 5, size=300)
    points = np.einsum("nk,nki->ni", weights, mesh.vertices[chosen])
    flat = np.cross(
        mesh.vertices[chosen[:, 1]] - mesh.vertices[chosen[:, 0]],
        mesh.vertices[chosen[:, 2]] - mesh.vertices[chosen[:, 0]],
    )
    found = form.normals(points, ())
    cosine = (found * flat).sum(axis=1) / np.linalg.norm(found, axis=1) / np.linalg.norm(flat, axis=1)
    assert cosine.min() > 0.99


def test_every_ray_of_a_picture_sees_what_testing_all_solids_finds(make: Any) -> None:
    stage = staged(make.odd(), Viewpoint(), 64, 48)
    rays = camera_rays(stage.camera)
    keys = caster_for(stage.solids, rays).cast()
    row, column = np.divmod(np.arange(64 * 48), 64)
    o, d = rays.at(column + 0.5, row + 0.5)
    best = np.full(len(o), np.inf)
    who = np.full(len(o), -1)
    inverse = inverses_of(stage.solids.matrices[:, :, :3])
    for i in range(len(stage.solids)):
        local_o = (o - stage.solids.matrices[i, :, 3]) @ inverse[i].T
        local_d = d @ inverse[i].T
        with np.errstate(all="ignore"):
            form, ratios = stage.solids.form(i)
            t = nearest_hit(form, tuple(local_o.T), tuple(local_d.T), ratios, 1e-5)
        who = np.where(t < best, i, who)
        best = np.minimum(best, t)
    assert (ids_of(keys).reshape(-1) == who).all()
    assert depths_of(keys).reshape(-1) == pytest.approx(best, rel=1e-5)
    assert len(np.unique(who)) > 12


def test_batches_agree_with_single_solids(make: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    stage = staged(make.random(300), Viewpoint(), 160, 160)
    caster = caster_for(stage.solids, camera_rays(stage.camera))
    together = caster.cast()
    monkeypatch.setattr("scenelang.backends.pictures.rays._MAX_BATCHED_SAMPLES", 0)
    assert (caster.cast() == together).all()


def test_a_camera_inside_sees_all_around(make: Any) -> None:
    camera = Viewpoint(target=(0.0, 0.0, 0.0), distance=0.01, fov=120)
    for word in ("cube", "sphere"):
        stage = staged(make.scene(make.primitive(word)), camera, 32, 32)
        assert (caster_for(stage.solids, camera_rays(stage.camera)).cast() != NOTHING).all()


def test_triangles_cast_like_their_mesh(make: Any) -> None:
    stage = staged(make.scene(make.primitive("cone")), Viewpoint(), 100, 100)
    poses, _ = triangle_poses(posed(CONE.mesh(200, ()), stage.solids.matrices).corners)
    rows = np.zeros(len(poses), int)
    mesh = stage.solids.take(rows)
    mesh.forms[:] = mesh.kinds.index(TRIANGLE)
    mesh.matrices[:] = poses
    rays = camera_rays(stage.camera)
    solid, triangles = caster_for(stage.solids, rays).cast(), caster_for(mesh, rays).cast()
    assert ((solid == NOTHING) != (triangles == NOTHING)).mean() < 0.003
    both = (solid != NOTHING) & (triangles != NOTHING)
    assert depths_of(solid)[both] == pytest.approx(depths_of(triangles)[both], abs=2e-3)


@pytest.mark.parametrize("form", standard_forms())
def test_meshes_are_closed_and_turned_outwards(form: CanonicalForm) -> None:
    for flip in (1.0, -1.0):
        matrix = np.array([[[2.0 * flip, 0.5, 0, 1], [0, 1, 0.3, 2], [0, 0, 1, 3]]])
        mesh = posed(form.mesh(24, ()), matrix)
        a, b, c = (mesh.corners[:, k] for k in range(3))
        across = np.cross(b - a, c - a)
        assert (np.einsum("ni,ni->n", across, mesh.shading[mesh.faces].mean(axis=1)) > 0).all()
        if form != TRIANGLE:
            volume = np.einsum("ni,ni->n", a - [1, 2, 3], across).sum() / 6
            true = {
                BALL: 4 / 3 * np.pi,
                BLOCK: 8,
                CYLINDER: 2 * np.pi,
                CONE: 2 / 3 * np.pi,
            }[form]
            assert volume == pytest.approx(2 * true, rel=0.03)
