"""Exports as OpenUSD: .usda text, .usdc and .usd binary, .usdz package.

Every distinct entity that stands in several places is a prototype, referenced by instanceable prims wherever it stands,
also inside other prototypes: the file grows with distinct entities, not with instances. All is below the default prim,
the root entity: its hierarchy, ``Prototypes`` and ``Shapes`` (classes, which are not drawn themselves) and
``Materials``. A primitive is an Xform with the entity's attributes over the mesh ``geometry``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scenelang.backends.appearance import look_of
from scenelang.backends.base import need
from scenelang.backends.exports.export import FPS, Job, mesh_backend
from scenelang.backends.exports.items import Item, Plan, distinct
from scenelang.backends.exports.merging import merged, segments_for
from scenelang.backends.exports.surfaces import solid_of
from scenelang.backends.exports.timeline import Moving, matched, variants
from scenelang.backends.exports.usd_materials import Materials
from scenelang.backends.exports.usd_prims import INSTALL, SHAPES, Names, Prims
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.values import IDENTITY, Matrix

MOST_PRIMS = 1_000_000
_DEEPEST = 1_000  # USD composes by recursion


def write(job: Job, path: Path) -> None:
    """Write the plan at ``path``. Raises SceneError("backend") without usd-core, LimitError for too many prims."""
    sdf = need("pxr.Sdf", INSTALL)
    layer = sdf.Layer.CreateAnonymous(".usda" if path.suffix.lower() == ".usda" else ".usdc")
    with sdf.ChangeBlock():
        _fill(layer, job)
    job.progress(0.8)
    if path.suffix.lower() == ".usdz":
        _package(layer, path)
    elif not layer.Export(str(path)):
        raise OSError(5, "USD cannot write it", str(path))


def _package(layer: Any, path: Path) -> None:
    """Write a .usdz: the layer as one binary file in an uncompressed archive."""
    utils, sdf = need("pxr.UsdUtils", INSTALL), need("pxr.Sdf", INSTALL)
    inner = path.with_suffix(".usdc")
    try:
        if not layer.Export(str(inner)) or not utils.CreateNewUsdzPackage(sdf.AssetPath(str(inner)), str(path)):
            raise OSError(5, "USD cannot write it", str(path))
    finally:
        inner.unlink(missing_ok=True)


def _fill(layer: Any, job: Job) -> None:
    plan = job.plan
    whole = [item.entity for item in distinct(*plan.roots) if item.merged]
    prims = Prims(layer)
    root = prims.prim(layer, Names().fresh(plan.word), "Xform")
    root.SetInfo("kind", "component")
    root.SetInfo("apiSchemas", prims.sdf.TokenListOp.Create(prependedItems=["GeomModelAPI"]))
    layer.defaultPrim = root.name
    facts: dict[str, Any] = {"upAxis": "Y", "metersPerUnit": 1.0, "timeCodesPerSecond": job.fps}
    if plan.animated:
        facts |= {"framesPerSecond": job.fps, "startTimeCode": 0.0, "endTimeCode": float(len(plan.roots) - 1)}
    for name, value in facts.items():
        layer.pseudoRoot.SetInfo(name, value)
    prims.hint_extent(root, plan.roots)
    materials = Materials(prims, prims.prim(root, "Materials", "Scope"))
    tree = _Tree(prims, materials, root, segments_for(whole, "the merged meshes"))
    tree.add_frames(matched(plan.roots)) if plan.animated else tree.add_root(plan)


@dataclass(slots=True)
class _Tree:
    """Adds the hierarchy below ``root``; ``repeated`` items become prototypes when they are first met."""

    prims: Prims
    materials: Materials
    root: Any
    segments: int
    repeated: set[int] = field(default_factory=set)
    room: int = MOST_PRIMS
    _prototypes: Any = None
    _paths: dict[int, Any] = field(default_factory=dict)
    _names: dict[Any, Names] = field(default_factory=dict)

    # --- what does not move ---

    def add_root(self, plan: Plan) -> None:
        """A still scene; the root prim is the root entity."""
        self._find_repeated(plan.roots)
        self._inside(plan.roots[0], self.root)

    def _find_repeated(self, roots: Sequence[Item]) -> None:
        """Which items stand in several places; ``roots`` count as often as they are given."""
        seen: set[int] = set()
        for root in roots:
            self.repeated.add(id(root)) if id(root) in seen else seen.add(id(root))
        for item in distinct(*roots):
            for child, _ in item.parts:
                self.repeated.add(id(child)) if id(child) in seen else seen.add(id(child))

    def _inside(self, item: Item, prim: Any, level: int = 0) -> None:
        """What ``item`` is, in ``prim``: its facts, geometry and parts, and the prototypes that these need."""
        waiting = [(item, prim, level)]
        while waiting:
            item, prim, level = waiting.pop()
            self._spend(level)
            self.prims.describe(prim, item)
            if item.is_leaf:
                self._geometry(item, prim)
            for child, pose in item.parts:
                made = self._posed(prim, child, (pose,))
                if id(child) not in self.repeated:
                    waiting.append((child, made, level + 1))
                elif id(child) not in self._paths:
                    waiting.append((child, self._prototype(child), 1))
                    self._refer(made, child)
                else:
                    self._refer(made, child)

    def _spend(self, level: int) -> None:
        self.room -= 1
        if self.room < 0 or level > _DEEPEST:
            what = (
                f"prims are nested deeper than {_DEEPEST:,}"
                if level > _DEEPEST
                else f"it has over {MOST_PRIMS:,} prims"
            )
            raise LimitError("primitives", f"the scene is too large for USD: {what}", hint="merge parts with --depth N")

    def _posed(self, parent: Any, item: Item, poses: Sequence[Matrix]) -> Any:
        prim = self.prims.prim(parent, self._name(parent, item.word), "Xform")
        self.prims.place(prim, poses)
        return prim

    def _name(self, parent: Any, word: str) -> str:
        if parent.path not in self._names:
            reserved = (
                {"Materials": 1, "Prototypes": 1, SHAPES: 1, "geometry": 1} if parent == self.root else {"geometry": 1}
            )
            self._names[parent.path] = Names(reserved)
        return self._names[parent.path].fresh(word)

    def _prototype(self, item: Item) -> Any:
        """A new prim for what stands in several places."""
        if self._prototypes is None:
            self._prototypes = self.prims.prim(self.root, "Prototypes", "", abstract=True)
        made = self.prims.prim(self._prototypes, self._name(self._prototypes, item.word), "Xform")
        self._paths[id(item)] = made.path
        return made

    def _refer(self, prim: Any, item: Item) -> None:
        reference = self.prims.sdf.Reference("", self._paths[id(item)])
        prim.referenceList.prependedItems = [reference]
        prim.instanceable = True

    def _geometry(self, item: Item, prim: Any) -> None:
        """The shape or the meshes of a leaf."""
        if item.merged:
            for number, patch in enumerate(merged(item.entity, self.segments), start=1):
                name = "geometry" if number == 1 else f"geometry_{number}"
                mesh = self.prims.mesh(prim, name, patch.surface, patch.look)
                self.materials.bind(mesh, patch.look, painted=True)
            return
        self._solid(item, prim, "geometry", None)

    def _solid(self, item: Item, prim: Any, name: str, poses: Sequence[Matrix] | None) -> Any:
        """The geometry of a primitive, under its solid's own pose or under one for each frame; None where unseen."""
        solid = solid_of(item.entity)
        if solid is None:
            return None
        look = look_of(item.entity)
        if look.opacity == 0.0:
            return None
        if solid.form is not None:
            made = self.prims.shape(prim, name, solid.form, look)
            self.materials.bind(made, look)
        else:
            surface = solid.surface()
            if surface is None:
                return None
            made = self.prims.mesh(prim, name, surface, look)
            self.materials.bind(made, look, painted=surface.colors is not None)
        self.prims.place(made, poses or (solid.pose,))
        return made

    # --- what moves ---

    def add_frames(self, root: Moving) -> None:
        """The frames of a 4D scene: time code ``i`` is frame ``i``."""
        self._find_repeated(_fixed_items(root))
        waiting: list[tuple[Moving, Any, int]] = [(root, self.root, 0)]
        while waiting:
            moving, prim, level = waiting.pop()
            self._spend(level)
            if moving.fixed is not None:
                self._settle(moving.fixed, prim, level)
                continue
            self.prims.describe(prim, moving.first)
            self._changing(moving, prim)
            for child in moving.children:
                made = self._posed(prim, child.first, child.filled_poses())
                self.prims.show(made, child.shown)
                waiting.append((child, made, level + 1))

    def _settle(self, item: Item, prim: Any, level: int) -> None:
        """Something that never changes, whose prim may move."""
        if id(item) not in self.repeated:
            self._inside(item, prim, level)
            return
        if id(item) not in self._paths:
            self._inside(item, self._prototype(item), 1)
        self._refer(prim, item)

    def _changing(self, moving: Moving, prim: Any) -> None:
        """The geometry of a leaf whose look or shape changes: one prim for each, seen in its frames."""
        for item, shown in variants(moving):
            name = self._name(prim, "geometry")
            if item.merged:
                holder = self.prims.prim(prim, name, "Xform")
                self._geometry(item, holder)
                self.prims.show(holder, _where_there(shown, moving))
                continue
            made = self._solid(item, prim, name, _solid_poses(moving, item, shown))
            if made is not None:
                self.prims.show(made, _where_there(shown, moving))


def _where_there(shown: Sequence[bool], moving: Moving) -> tuple[bool, ...]:
    """``shown``, but True in the frames in which the whole thing is hidden anyway."""
    return tuple(seen or not there for seen, there in zip(shown, moving.shown, strict=True))


def _solid_poses(moving: Moving, item: Item, shown: Sequence[bool]) -> tuple[Matrix, ...]:
    """The poses of a leaf's solid in every frame: in frames without it, that of the frame before."""
    solid = None if item.merged else solid_of(item.entity)
    found = IDENTITY if solid is None else solid.pose
    poses = []
    for other, seen in zip(moving.items, shown, strict=True):
        if seen and other is not None:
            solid = solid_of(other.entity)
            found = found if solid is None else solid.pose
        poses.append(found)
    return tuple(poses)


def _fixed_items(root: Moving) -> list[Item]:
    """The items that never change, once for each place where one stands."""
    found, waiting = [], [root]
    while waiting:
        moving = waiting.pop()
        if moving.fixed is not None:
            found.append(moving.fixed)
        waiting.extend(moving.children)
    return found


USD = mesh_backend(
    "usd",
    "OpenUSD with instanceable prototypes, materials, words and 4D time samples",
    (".usd", ".usda", ".usdc", ".usdz"),
    write,
    animated=True,
    options=(FPS,),
    packages=("pxr",),
    install=INSTALL,
)
