"""Voxelization of arbitrary scenes: filled primitives and meshes in a grid of cells.

A cell is filled if its center is inside a solid. Parts thinner than a cell, and the surfaces of meshes, fill every cell
they intersect, so that nothing disappears; the interior of a closed mesh is filled too. Later primitives replace
earlier ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scenelang.backends.base import require
from scenelang.backends.minecraft.blocks import (
    AIR_STATE,
    BlockKind,
    BlockState,
    BlockTable,
    Build,
    Cells,
    load_table,
    trimmed,
    unified,
)
from scenelang.backends.minecraft.voxels import BoolArray, FloatArray, IntArray, namespaced
from scenelang.backends.surfaces.appearance import Looks, oklab
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.backends.surfaces.solids import Solids, solids_of
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import LimitError, SceneError, suggest
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives.forms import CanonicalForm

MAX_CELLS = 200_000_000  # of a voxelized scene
_BATCH_CELLS = 1 << 21  # cells or samples processed per batch
_MIN_THICKNESS = 1.5  # in cells: anything thinner may pass between cell centers
_SAMPLE_STEP = 0.5  # cells between samples, so that no cell of a thin part is missed


@dataclass(frozen=True, slots=True, eq=False)
class Filled:
    """A grid filled with materials.

    ``cells[x, y, z]`` is 0 if empty, else one more than the row in ``looks`` of the material at ``origin + (x, y, z)``,
    in cells; a cell is ``edge`` scene units wide.
    """

    origin: tuple[int, int, int]
    cells: Cells
    looks: Looks
    edge: float


def filled(root: Entity, longest: int, limit: int = 2_000_000) -> Filled:
    """Voxelize a scene with ``longest`` cells along the longest side of its bounding box.

    The corner of the box is at whole cells. Raises SceneError("empty-scene"), and LimitError for more than ``limit``
    primitives or too many cells.
    """
    drawn = drawn_scene(Scene(root.word, [root], False), limit).root
    box = entity_box(drawn)
    if box is None:
        raise SceneError("empty-scene", f'the scene "{root.word}" has no primitives, so there is nothing to fill')
    if primitive_count(drawn) > limit:
        raise LimitError("primitives", f"the scene has more than {limit:,} primitives")
    low, high = np.array(box[:3]), np.array(box[3:])
    edge = float((high - low).max()) / longest or 1.0
    if not np.isfinite(edge) or np.abs(box).max() / edge > 1e9:
        raise SceneError("unsupported", "the scene is too large, or too far from the origin, to be voxelised")
    size = np.maximum(1, np.ceil((high - low) / edge - 1e-9)).astype(np.int64)
    if int(size.prod()) > MAX_CELLS:
        raise LimitError(
            "size", f"the build would have {int(size.prod()):,} cells, more than the limit of {MAX_CELLS:,}"
        )
    solids = solids_of(flatten_entity(drawn))
    matrices = solids.matrices / edge
    matrices[:, :, 3] -= low / edge
    cells = np.zeros(size, np.uint32)
    for first, last in _in_order(solids):
        look = solids.look[first:last] + 1
        form, ratios = solids.form(first)
        if form.is_closed:
            _fill(cells, _Member(form, ratios), matrices[first], int(look[0]))
        else:
            _fill_mesh(cells, matrices[first:last], look)
    x, y, z = np.rint(low / edge).astype(np.int64).tolist()
    return Filled((x, y, z), cells, solids.looks, edge)


def _in_order(solids: Solids) -> list[tuple[int, int]]:
    """Return the start and end rows of each instance's solids, in the order of the instances."""
    begins = np.flatnonzero(np.diff(solids.instance, prepend=-1, append=-1))
    order = np.argsort(solids.instance[begins[:-1]], kind="stable")
    return [(int(begins[i]), int(begins[i + 1])) for i in order.tolist()]


# --- solids ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Member:
    """A canonical form with its ratios."""

    form: CanonicalForm
    ratios: tuple[float, ...]

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray) -> BoolArray:
        """Return the mask of points, in the form's frame, that are inside it."""
        return self.form.contains(u, v, w, self.ratios)

    @property
    def thickness(self) -> float:
        """Minimum thickness relative to the form's bounding cube."""
        return self.form.thickness(self.ratios)


def _fill(cells: Cells, member: _Member, matrix: FloatArray, look: int) -> None:
    """Fill one canonical form under ``matrix`` (3, 4), in cell units."""
    linear, center = matrix[:, :3], matrix[:, 3]
    widths = 2.0 * np.linalg.svd(linear, compute_uv=False)
    if widths[-1] > 1e-9 * widths[0]:
        _fill_inside(cells, member, linear, center, look)
    if member.thickness * widths[-1] < _MIN_THICKNESS:
        for points in _samples(member, linear):
            _mark(cells, points + center, np.full(len(points), look, np.uint32))


def _fill_inside(cells: Cells, member: _Member, linear: FloatArray, center: FloatArray, look: int) -> None:
    """Fill the cells whose centers are inside a form, batch by batch along x."""
    inverse = np.linalg.inv(linear)
    reach = np.abs(linear).sum(axis=1)
    limit = np.array(cells.shape)
    low = np.clip(np.floor(center - reach), 0, limit).astype(np.int64)
    high = np.clip(np.ceil(center + reach), low, limit).astype(np.int64)
    batch = max(1, _BATCH_CELLS // max(1, int((high - low)[1:].prod())))
    for start in range(int(low[0]), int(high[0]), batch):
        stop = min(start + batch, int(high[0]))
        axes = (np.arange(start, stop), np.arange(low[1], high[1]), np.arange(low[2], high[2]))
        x, y, z = np.meshgrid(*((a + 0.5 - c) for a, c in zip(axes, center)), indexing="ij", sparse=True)
        u, v, w = (row[0] * x + row[1] * y + row[2] * z for row in inverse)
        part = cells[start:stop, low[1] : high[1], low[2] : high[2]]
        part[member.contains(u, v, w)] = look


def _samples(member: _Member, linear: FloatArray) -> Iterator[FloatArray]:
    """Yield points (K, 3) inside the solid, relative to its center, at most a step apart."""
    counts = np.maximum(1, np.ceil(2.0 * np.linalg.norm(linear, axis=0) / _SAMPLE_STEP)).astype(np.int64)
    a, b, c = (((np.arange(n) + 0.5) / n) * 2.0 - 1.0 for n in counts.tolist())
    batch = max(1, _BATCH_CELLS // (len(b) * len(c)))
    for start in range(0, len(a), batch):
        u, v, w = (axis.reshape(-1) for axis in np.meshgrid(a[start : start + batch], b, c, indexing="ij"))
        valid = member.contains(u, v, w)
        yield np.stack([u[valid], v[valid], w[valid]], axis=1) @ linear.T


def _mark(cells: Cells, points: FloatArray, look: IntArray) -> None:
    """Fill the cells that contain ``points`` (K, 3)."""
    at = np.minimum(np.floor(points + 1e-9).astype(np.int64), np.array(cells.shape) - 1)
    valid = (at >= 0).all(axis=1)
    x, y, z = at[valid].T
    cells[x, y, z] = look[valid]


# --- meshes ----------------------------------------------------------------------------------------------------------


def _fill_mesh(cells: Cells, matrices: FloatArray, looks: IntArray) -> None:
    """Fill the surface of canonical triangles under ``matrices`` (T, 3, 4), and the enclosed interior."""
    corner = matrices[:, :, 3] - matrices[:, :, 0] - matrices[:, :, 1]
    along, up = 2.0 * matrices[:, :, 0], 2.0 * matrices[:, :, 1]
    spans = np.stack([corner, corner + along, corner + up])
    limit = np.array(cells.shape)
    low = np.clip(np.floor(spans.min(axis=(0, 1))) - 1, 0, limit).astype(np.int64)
    high = np.clip(np.ceil(spans.max(axis=(0, 1))) + 1, low + 1, limit).astype(np.int64)
    shell = np.zeros(high - low, np.uint32)
    for points, index in _on_triangles(corner - low, along, up):
        _mark(shell, points, looks[index].astype(np.uint32))
    surface = shell != 0
    inside = require("scipy.ndimage", "'scenelang[minecraft]'").binary_fill_holes(surface) & ~surface
    values, counts = np.unique(looks, return_counts=True)
    shell[inside] = values[np.argmax(counts)]
    part = cells[tuple(slice(a, b) for a, b in zip(low.tolist(), high.tolist()))]
    np.copyto(part, shell, where=shell != 0)


def _on_triangles(corner: FloatArray, along: FloatArray, up: FloatArray) -> Iterator[tuple[FloatArray, IntArray]]:
    """Yield points (K, 3) on triangles, at most a step apart, and the index of each point's triangle."""
    size = np.maximum(np.linalg.norm(along, axis=1), np.linalg.norm(up, axis=1))
    steps = np.maximum(1, np.ceil(size / _SAMPLE_STEP)).astype(np.int64)
    for count in np.unique(steps).tolist():
        triangles = np.flatnonzero(steps == count)
        i, j = np.tril_indices(count + 1)
        s, t = (i - j) / count, j / count
        chunk = max(1, _BATCH_CELLS // len(s))
        for start in range(0, len(triangles), chunk):
            rows = triangles[start : start + chunk]
            points = corner[rows, None] + s[:, None] * along[rows, None] + t[:, None] * up[rows, None]
            yield points.reshape(-1, 3), np.repeat(rows, len(s))


# Color matching: families of blocks, and the nearest block to a color.


FAMILIES = ("wool", "concrete", "terracotta", "glass", "planks", "logs", "bricks", "leaves", "powder", "glazed", "all")
USUAL = "wool,concrete,terracotta,glass"
_MAX_TRANSLUCENT_OPACITY = 0.5  # opacity below which a translucent block is used
_FALLING = ("_powder", "sand", "gravel", "anvil", "dragon_egg")  # blocks that fall, used only if explicitly requested
# Parts of the names of blocks that the family "all" omits: ores, plants, and blocks with a behavior.
_EXCLUDED_FROM_ALL = (
    "_ore",
    "infested_",
    "shulker_box",
    "_leaves",
    "spawner",
    "tnt",
    "ice",
    "_coral_block",
    "sculk",
    "_head",
)
_ENDINGS = {"logs": ("_log", "_stem"), "bricks": ("bricks", "_bricks"), "powder": ("_concrete_powder",),
            "glazed": ("_glazed_terracotta",), "glass": ("glass",)}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Palette:
    """Blocks with their colors: ``points`` (K, 3) in Oklab, ``opacity`` (K,)."""

    states: tuple[BlockState, ...]
    points: FloatArray
    opacity: FloatArray


def palette_of(text: str, table: BlockTable | None = None) -> Palette:
    """Parse a palette: families and blocks, separated by commas, such as ``wool,oak_planks``.

    Raises SceneError("value") for an unknown name.
    """
    table = table or load_table()
    names = [name.strip().lower() for name in text.split(",") if name.strip()]
    kinds = {kind.name: kind for name in names for kind in _kinds(name, table)}
    if not kinds:
        raise SceneError(
            "value", "a palette must contain at least one block", hint=f"families are {', '.join(FAMILIES)}"
        )
    chosen = list(kinds.values())
    colors = from_srgb(np.array([kind.color for kind in chosen], np.float64) / 255.0)
    states = tuple(BlockState(kind.name, tuple(sorted(_persistent_defaults(kind).items()))) for kind in chosen)
    return Palette(states, oklab(colors), np.array([kind.opacity for kind in chosen]))


def matched(looks: Looks, palette: Palette) -> IntArray:
    """Return the index in ``palette`` of the nearest block of every look (K,), opaque or translucent like the look.

    Distances are in Oklab with hue weighted double and lightness half: in plain Oklab a bright red is nearest to orange
    concrete, and shading changes lightness anyway.
    """
    target = oklab(np.clip(looks.color, 0.0, 1.0))
    is_translucent = palette.opacity < 1.0
    numbers = np.zeros(len(target), np.int64)
    for i, (point, opacity) in enumerate(zip(target, looks.opacity.tolist())):
        group = is_translucent == (opacity < _MAX_TRANSLUCENT_OPACITY)
        candidates = np.flatnonzero(group) if group.any() else np.arange(len(is_translucent))
        numbers[i] = candidates[int(np.argmin(_distances(palette.points[candidates], point)))]
    return numbers


def _distances(points: FloatArray, target: FloatArray) -> FloatArray:
    """Return weighted squared distances from ``points`` (K, 3) to ``target`` (3,) in lightness, chroma and hue."""
    lightness = points[:, 0] - target[0]
    chroma = np.hypot(points[:, 1], points[:, 2]) - np.hypot(target[1], target[2])
    apart = ((points[:, 1:] - target[1:]) ** 2).sum(axis=1)
    hue = np.maximum(0.0, apart - chroma**2)
    away: FloatArray = 0.25 * lightness**2 + chroma**2 + 4.0 * hue
    return away


def in_blocks(filled: Filled, palette: Palette) -> Build:
    """Convert a filled grid to a build of blocks of ``palette``."""
    number = np.concatenate([[0], matched(filled.looks, palette) + 1]).astype(np.uint32)
    return trimmed(unified(filled.origin, number[filled.cells], (AIR_STATE, *palette.states)))


def _kinds(name: str, table: BlockTable) -> Sequence[BlockKind]:
    """Return the blocks of a family, or the block with that name."""
    cubes = [kind for kind in table.blocks.values() if _is_building_block(kind)]
    if name == "all":
        return [kind for kind in cubes if kind.opacity == 1.0 and not _has(kind, (*_FALLING, *_EXCLUDED_FROM_ALL))]
    exact = table.blocks.get(namespaced(name))
    if exact is not None and name not in FAMILIES:
        if not _is_building_block(exact):
            raise SceneError("value", f"`{name}` is not a full cube with a color")
        return [exact]
    endings = _ENDINGS.get(name, (f"_{name}", f":{name}"))
    kinds = [kind for kind in cubes if kind.name.endswith(endings)]
    if name == "terracotta":
        kinds = [kind for kind in kinds if "glazed" not in kind.name]
    if not kinds:
        known = [*FAMILIES, *(kind.name.removeprefix("minecraft:") for kind in cubes)]
        hint = suggest(name, known) or f"expected a family ({', '.join(FAMILIES)}) or a block name"
        raise SceneError("value", f"unknown block or block family `{name}`", hint=hint)
    return kinds


def _is_building_block(kind: BlockKind) -> bool:
    """Return whether a block is a full, visible cube that players can place."""
    return kind.shape == "cube" and kind.color is not None and not kind.is_for_operators and "infested" not in kind.name


def _has(kind: BlockKind, parts: tuple[str, ...]) -> bool:
    """Return whether the name of a block contains one of the parts."""
    return any(part in kind.name for part in parts)


def _persistent_defaults(kind: BlockKind) -> dict[str, str]:
    """Return the block's default state, with leaves that do not decay."""
    return {**kind.defaults, "persistent": "true"} if "persistent" in kind.defaults else dict(kind.defaults)
