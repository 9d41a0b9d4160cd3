"""Reads the USD files that the tests write with usd-core."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from scenelang.backends.exports.plan import SEGMENTS
from scenelang.interpreter.scene.primitives.capsule import CAPSULE


def seen(stage: Any, moment: float = 0.0) -> Iterator[tuple[tuple[str, ...], np.ndarray, np.ndarray]]:
    """The words down to every visible shape, its world vertices and its colors, in depth-first order."""
    from pxr import Usd, UsdGeom

    places, default = UsdGeom.XformCache(moment), Usd.TimeCode(moment)
    prims = iter(Usd.PrimRange(stage.GetDefaultPrim(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
    for prim in prims:
        if prim.IsA(UsdGeom.Imageable) and UsdGeom.Imageable(prim).GetVisibilityAttr().Get(default) == "invisible":
            prims.PruneChildren()
            continue
        if prim.IsA(UsdGeom.PointInstancer):
            prims.PruneChildren()
            yield from _instances(prim, np.array(places.GetLocalToWorldTransform(prim)).T, places, default)
        if not prim.IsA(UsdGeom.Gprim):
            continue
        world = np.array(places.GetLocalToWorldTransform(prim)).T
        vertices = vertices_of(prim)
        colors = np.array(UsdGeom.Gprim(prim).GetDisplayColorAttr().Get(), float)
        yield _words(prim), vertices @ world[:3, :3].T + world[:3, 3], np.broadcast_to(colors, vertices.shape)


def _instances(
    prim: Any, outer: np.ndarray, places: Any, moment: Any
) -> Iterator[tuple[tuple[str, ...], np.ndarray, np.ndarray]]:
    """What `seen` yields, for the instances of a PointInstancer under a pose."""
    from pxr import Usd, UsdGeom

    instancer = UsdGeom.PointInstancer(prim)
    roots = [prim.GetStage().GetPrimAtPath(path) for path in instancer.GetPrototypesRel().GetTargets()]
    inner = [np.array(places.GetLocalTransformation(root)[0]).T for root in roots]
    assert all((pose == np.eye(4)).all() for pose in inner)
    parts = [_below(root, places, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate), moment) for root in roots]
    transforms = instancer.ComputeInstanceTransformsAtTime(moment, moment)
    indices = instancer.GetProtoIndicesAttr().Get()
    assert len(set(instancer.GetIdsAttr().Get())) == len(indices) == len(transforms)
    for number, transform in zip(indices, transforms, strict=True):
        world = outer @ np.array(transform).T
        for words, vertices, colors in parts[number]:
            yield words, vertices @ world[:3, :3].T + world[:3, 3], colors


def _below(root: Any, places: Any, predicate: Any, moment: Any) -> list[tuple[tuple[str, ...], np.ndarray, np.ndarray]]:
    """What `seen` yields for the prims below a prototype, in its frame."""
    from pxr import Usd, UsdGeom

    found: list[Any] = []
    prims = iter(Usd.PrimRange(root, predicate))
    for prim in prims:
        pose = np.array(places.ComputeRelativeTransform(prim, root)[0]).T
        if prim.IsA(UsdGeom.PointInstancer):
            prims.PruneChildren()
            found += _instances(prim, pose, places, moment)
        elif prim.IsA(UsdGeom.Gprim):
            vertices = vertices_of(prim)
            colors = np.array(UsdGeom.Gprim(prim).GetDisplayColorAttr().Get(), float)
            moved = vertices @ pose[:3, :3].T + pose[:3, 3]
            found.append((_words(prim), moved, np.broadcast_to(colors, vertices.shape)))
    return found


def vertices_of(prim: Any) -> np.ndarray:
    """The points of a mesh; of USD's own capsule, those that one of our meshes would have."""
    if prim.GetTypeName() == "Mesh":
        return np.array(prim.GetAttribute("points").Get(), float)
    assert prim.GetTypeName() == "Capsule"
    assert prim.GetAttribute("axis").Get() == "Y"
    radius = prim.GetAttribute("radius").Get()
    assert radius + prim.GetAttribute("height").Get() / 2 == pytest.approx(1.0)
    return CAPSULE.mesh(SEGMENTS, (radius,)).vertices


def _words(prim: Any) -> tuple[str, ...]:
    words = []
    while prim:
        if prim.HasAttribute("scenelang:word"):
            words.append(prim.GetAttribute("scenelang:word").Get())
        prim = prim.GetParent()
    return tuple(reversed(words))


def complaints(stage: Any) -> list[str]:
    from pxr import UsdValidation

    every = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(every) > 20
    return [error.GetMessage() for error in UsdValidation.ValidationContext(every).Validate(stage)]
