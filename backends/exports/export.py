"""Shared functionality of all exports: metadata, animation, options, splitting into parts, and flattening."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import LOOKS, Accepts, Backend, BackendOptions, Option, Progress, Work, check_settings
from scenelang.backends.exports.plan import (
    MAX_VERTICES,
    SEGMENTS,
    WHITE,
    ExportItem,
    ExportPlan,
    ExportSurface,
    Patch,
    chosen,
    crowded_edges_of,
    distinct,
    merged,
    planned,
    points_of,
    segments_for,
    shared,
    sides_within,
    solid_of,
    too_fine,
    translation,
    vertex_count,
)
from scenelang.backends.files import atomic_write_all
from scenelang.backends.surfaces.appearance import Look, look_of
from scenelang.backends.surfaces.convex import clusters
from scenelang.backends.surfaces.cuts import cut, planes_of
from scenelang.backends.surfaces.distance import neighbors
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.backends.surfaces.precision import (
    SINGLE,
    ChangedBody,
    Copies,
    Rounding,
    about,
    changed_bodies,
    chunks_of,
    own_offset,
)
from scenelang.backends.surfaces.restyling import in_mean_colors, with_file_images
from scenelang.backends.surfaces.solids import composed
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.backends.surfaces.tiles import normals_png, pictured, tile_of
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.runtime.show import plain_attributes
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, count_words, descendants, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.modelling.solid import SolidShape
from scenelang.interpreter.scene.modelling.solid import joined as joined_solid
from scenelang.interpreter.scene.primitives.textures import Texture
from scenelang.interpreter.values.values import ANONYMOUS, IDENTITY, Embedding, Matrix, Pair

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

# Metadata of an entity that an export includes besides geometry: word, handle, text, attributes.


_MAX_ATTRIBUTE_LENGTH = 4_000  # characters of an attribute; longer ones are omitted


def facts_of(entity: Entity) -> dict[str, Any]:
    """Return ``word`` and, if present, ``handle`` (without brackets), ``text`` and plain ``attributes``, as JSON
    data."""
    embedding = entity.embedding
    facts: dict[str, Any] = {"word": entity.word}
    if embedding.handle is not None:
        facts["handle"] = embedding.handle
    if embedding.text is not None:
        facts["text"] = embedding.text
    if embedding.attributes:
        attributes = {name: value for name, value in plain_attributes(entity).items() if _is_short(value)}
        if attributes:
            facts["attributes"] = attributes
    return facts


def merged_facts(entity: Entity) -> dict[str, Any]:
    """Return ``facts_of`` plus ``words``, the number of instances of each word below the merged entity, and
    ``primitives``."""
    words = count_words(entity)
    words[entity.word] -= 1
    other_words = {word: count for word, count in words.items() if count}
    return facts_of(entity) | {"words": other_words, "primitives": primitive_count(entity)}


def _is_short(value: Any) -> bool:
    """Return whether a value is short enough to be written."""
    return len(json.dumps(value)) <= _MAX_ATTRIBUTE_LENGTH


# Correspondence between the frames of a 4D scene: entities with the same path (child positions from the root) are one
# object over time. If the word at a path changes, each word is a separate object, present in the frames that have it.


MAX_MOVING = 1_000_000  # changing items of all frames together


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """Object at one path over F frames.

    Attributes
    ----------
    word
        Its word.
    items, poses
        Its item and pose in each frame, None in frames without it.
    fixed
        Its item if that never changes. Then its descendants do not change either, and ``children`` is empty.
    children
        Objects at the child positions.
    """

    word: str
    items: tuple[ExportItem | None, ...]
    poses: tuple[Matrix | None, ...]
    fixed: ExportItem | None
    children: list[Moving] = field(default_factory=list)

    @property
    def first(self) -> ExportItem:
        """Item in the first frame that contains it."""
        return next(item for item in self.items if item is not None)

    @property
    def shown(self) -> tuple[bool, ...]:
        """Whether the object is present, for each frame."""
        return tuple(item is not None for item in self.items)

    @property
    def is_still(self) -> bool:
        """Whether the object is in all frames, with one pose."""
        return None not in self.items and len(set(self.poses)) == 1

    def filled_poses(self) -> tuple[Matrix, ...]:
        """Return a pose for every frame; frames without the object repeat the previous pose."""
        current = next(pose for pose in self.poses if pose is not None)
        filled = []
        for frame_pose in self.poses:
            current = frame_pose if frame_pose is not None else current
            filled.append(current)
        return tuple(filled)


def matched(roots: Sequence[ExportItem]) -> Moving:
    """Match the roots of all frames into one object over time; raises LimitError if too much of it changes."""
    top = _moving(roots[0].word, list(roots), [IDENTITY] * len(roots))
    waiting = [top]
    remaining = MAX_MOVING
    while waiting:
        moving = waiting.pop()
        if moving.fixed is not None:
            continue
        moving.children.extend(_children(moving))
        remaining -= sum(len(item.parts) for item in moving.items if item is not None)
        if remaining < 0:
            raise LimitError(
                "primitives",
                f"more than {MAX_MOVING:,} entities change between frames, too many for an animation",
                hint="export a single frame with --frame N, or merge parts that move together with --depth N",
            )
        waiting.extend(moving.children)
    return top


def _moving(word: str, items: Sequence[ExportItem | None], poses: Sequence[Matrix | None]) -> Moving:
    """Return the object of a word from its items and poses in each frame."""
    kinds = {id(item): item for item in items if item is not None}
    fixed = next(iter(kinds.values())) if len(kinds) == 1 else None
    return Moving(word, tuple(items), tuple(poses), fixed)


def _children(moving: Moving) -> Iterator[Moving]:
    """Yield the objects at each child position, one for each word that occurs there."""
    frames = len(moving.items)
    most = max(len(item.parts) for item in moving.items if item is not None)
    for position in range(most):
        words: dict[str, tuple[list[ExportItem | None], list[Matrix | None]]] = {}
        for frame, item in enumerate(moving.items):
            if item is None or position >= len(item.parts):
                continue
            child, pose = item.parts[position]
            items, poses = words.setdefault(child.word, ([None] * frames, [None] * frames))
            items[frame], poses[frame] = child, pose
        for word, (items, poses) in words.items():
            yield _moving(word, items, poses)


def variants(moving: Moving) -> list[tuple[ExportItem, tuple[bool, ...]]]:
    """Return the distinct meshes of the object over time, each with the frames that show it."""
    shown_by_mesh: dict[Hashable, tuple[ExportItem, list[bool]]] = {}
    for frame, item in enumerate(moving.items):
        if item is None or not item.is_leaf:
            continue
        _, shown = shown_by_mesh.setdefault(leaf_key(item), (item, [False] * len(moving.items)))
        shown[frame] = True
    return [(item, tuple(shown)) for item, shown in shown_by_mesh.values()]


def leaf_key(item: ExportItem) -> Hashable:
    """Return the cache key of a leaf's mesh."""
    solid = None if item.merged else solid_of(item.entity)
    return ("merged", id(item.entity)) if solid is None else solid.key_with(look_of(item.entity))


DEPTH = Option(
    "depth", "merge the descendants of each entity at level N into one part; the root is level 0", None, minimum=0
)
PARTS = Option("parts", "write one file per part (default --depth 1): OUT-001-word.ext", False)
FPS = Option("fps", "frames per second of a 4D scene", 24.0, minimum=0.01, maximum=1000.0)
INSTANCES = Option(
    "instance-limit",
    "number of nodes beyond which repeated parts are merged into shared meshes with vertex colors",
    100_000,
    minimum=1,
    maximum=1_000_000,
)
SIDES = Option(
    "segments",
    "sides of a full circle (default: 64, fewer in very large files); USD's own capsules stay exact",
    None,
    minimum=3,
    maximum=1024,
)
UNITS = {"micron": 0.001, "millimeter": 1.0, "centimeter": 10.0, "meter": 1000.0, "inch": 25.4, "foot": 304.8}
_SUFFIXES = {"um": "micron", "mm": "millimeter", "cm": "centimeter", "m": "meter", "in": "inch", "ft": "foot"}
_TOLERANCE = re.compile(r"\s*(\d+\.?\d*(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?)\s*(px|[a-z]*)\s*(?:@\s*(\d{1,9}))?\s*", re.I)
_DEFAULT_PIXELS = 1_000  # along the longest side of the scene, for tolerances in pixels without a size


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Maximum distance of round surfaces from their triangles.

    ``unit`` is a key of ``UNITS``, "px" for pixels of an image that the scene fills with ``pixels`` along its longest
    side, or "" for scene units. Lengths and pixels exist because nobody thinks in scene units when printing.
    """

    amount: float
    unit: str = ""
    pixels: int = _DEFAULT_PIXELS

    def in_scene(self, scene: Scene, unit: str) -> float:
        """Return the distance in scene units, each of which is a ``unit``."""
        if self.unit == "px":
            boxes = np.array([box for box in map(entity_box, scene.frames) if box is not None]).reshape(-1, 2, 3)
            size = float((boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)).max()) if len(boxes) else 0.0
            return self.amount * size / self.pixels
        return self.amount * (UNITS[self.unit] / UNITS[unit] if self.unit else 1.0)


def read_tolerance(value: Any) -> Tolerance:
    """Read a number of scene units, or a text such as ``.1mm`` or ``1px@1080``; raises SceneError("value")."""
    if type(value) in (int, float) and math.isfinite(value) and value >= 0.0:
        return Tolerance(float(value))
    match = _TOLERANCE.fullmatch(value) if type(value) is str else None
    name = "" if match is None else match[2].lower()
    unit = name if name in ("", "px") else _SUFFIXES.get(name)
    if match is None or unit is None or (match[3] and (name != "px" or int(match[3]) < 1)):
        units = ", ".join(_SUFFIXES)
        raise SceneError(
            "value",
            f"`--tolerance` must be a number of at least 0, not {value!r}",
            hint=f"in scene units, or with {units}, or in pixels: `.01`, `.1mm`, `1px@1080`",
        )
    return Tolerance(float(match[1]), unit, int(match[3] or _DEFAULT_PIXELS))


TOLERANCE = Option(
    "tolerance",
    "greatest distance of round surfaces from their triangles: a number of scene units, a length such as .1mm (um, mm, "
    "cm, m, in, ft), or pixels of a picture that the scene fills, such as 1px@1080 (1px: of 1,000 pixels). What is "
    "shared (gltf, usd) or merged has it for the largest copy. 0 for --segments",
    "0",
    read=read_tolerance,
)
INSTANCING = Option(
    "instancing",
    "number of copies in one place from which they are one instanced node: EXT_mesh_gpu_instancing (gltf; default "
    "never) or a PointInstancer (usd; default 10,000); 0 for never",
    None,
    minimum=0,
)


def _check_section(text: str) -> None:
    """Raise SceneError("value") for a text that says no planes."""
    if text:
        planes_of(text)


SECTION = Option(
    "section",
    "cut the scene open, as `render` does: y=1.5, -x=0 for the other side, x=50%,z=50% for a corner; svg draws the "
    "section of one plane (default: the silhouette)",
    "",
    check=_check_section,
)
WHOLE = Option("solid", "join everything to one watertight body", False)
MAX_FILES = 10_000  # of an export with a file for each part
Node = TypeVar("Node", ExportItem, Entity)
Links = Sequence[tuple[Node, Matrix]]


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Input of a writer.

    Attributes
    ----------
    plan
        Items to write.
    fps
        Frames per second of an animation.
    instances
        Number of nodes from which repeated parts are merged.
    limit
        Maximum number of expanded primitives.
    progress
        Called with a fraction from 0 to 1.
    segments, tolerance
        Sides of a full circle, or the maximum distance of round surfaces from their triangles in scene units.
    unit
        Unit of the file, a key of ``UNITS``.
    instancing
        Number of copies from which they are one instanced node, 0 for never, None for the format's default.
    solid
        Whether the plan is one body. Its faces share points in formats that number them, because a body is closed by
        its numbers alone: readers split points that have several normals or materials.
    draco
        Whether meshes are compressed.
    warn
        Called with warnings about content that the format cannot hold.
    """

    plan: ExportPlan
    fps: float = 24.0
    instances: int = 100_000
    limit: int = 2_000_000
    progress: Progress = field(default=lambda _: None)
    segments: int | None = None
    tolerance: float | None = None
    unit: str = "millimeter"
    instancing: int | None = None
    solid: bool = False
    draco: bool = False
    warn: Callable[[Diagnostic], None] = field(default=lambda _: None)


Writer = Callable[[Job, Path], None]  # writes the file, and its accompanying files in the same directory


def mesh_backend(
    name: str,
    doc: str,
    endings: tuple[str, ...],
    write: Writer,
    animated: bool = False,
    options: tuple[Option, ...] = (),
    packages: tuple[str, ...] = (),
    install: str = "scenelang",
    attributes: tuple[str, ...] = (*LOOKS, "texture"),
    unit: str = "millimeter",
) -> Backend:
    """Return an export backend that writes meshes with ``write``; adds ``--depth``, ``--parts`` and ``--solid``.

    ``unit`` is the unit of the file for its readers, if the format has no option for it.
    """

    def run(scene: Scene, path: Path, settings: BackendOptions) -> list[Path]:
        return _export(backend, write, scene, Path(path), settings, unit)

    accepts = Accepts(attributes=attributes, animated=animated)
    common = (DEPTH, PARTS, WHOLE, SECTION)
    backend = Backend(name, doc, Work.EXPORT, endings, run, (*common, *options), accepts, packages, install)
    return backend


def _export(
    backend: Backend, write: Writer, scene: Scene, path: Path, options: BackendOptions, unit: str
) -> list[Path]:
    """Write the files and return the main ones: one, or one for each part."""
    check_settings(options, [backend])
    depth, parts = backend.setting(options, "depth"), backend.setting(options, "parts")
    frame = options.frame if options.frame is not None or backend.accepts.animated else 0
    tolerance_setting = _setting(backend, options, "tolerance")
    tolerance = None
    if isinstance(tolerance_setting, Tolerance):
        tolerance = tolerance_setting.in_scene(scene, _setting(backend, options, "unit") or unit) or None
    section = backend.setting(options, "section")
    if section:
        if backend.setting(options, "solid"):
            message = "a section opens bodies, so it cannot be one watertight body: leave out `--solid` or `--section`"
            raise SceneError("value", message, hint="`difference` in the program removes a part of a solid")
        scene, frame = cut(chosen(scene, frame), planes_of(section), options.limit, options.warn), None
    reads = backend.accepts.attributes
    if "color" in reads and ("texture" not in reads or backend.setting(options, "solid")):
        _warn_of_textures(scene, path, options.warn or (lambda _: None))
    if backend.setting(options, "solid"):
        scene = drawn_scene(chosen(scene, frame), options.limit, options.warn)
        scene, frame = _as_solids(scene, _setting(backend, options, "segments"), tolerance), None
        _warn_of_crowded_edges(scene, options.warn or (lambda _: None))
    elif "texture" in reads:
        scene = with_file_images(scene)
    plan = planned(scene, frame, 1 if parts and depth is None else depth, options.limit, options.warn)
    fields = {name: name for name in ("fps", "segments", "unit", "instancing", "draco")} | {
        "instances": "instance-limit"
    }
    others = {field: _setting(backend, options, name) for field, name in fields.items()}
    job = Job(
        plan,
        limit=options.limit,
        progress=options.progress or (lambda _: None),
        tolerance=tolerance,
        solid=bool(backend.setting(options, "solid")),
        warn=options.warn or (lambda _: None),
        **{field: value for field, value in others.items() if value is not None},
    )
    with atomic_write_all(path.parent, path) as folder:
        names = _write_parts(write, job, folder, path) if parts else [path.name]
        if not parts:
            write(job, folder / path.name)
    job.progress(1.0)
    return [path.parent / name for name in names]


def _warn_of_crowded_edges(scene: Scene, warn: Callable[[Diagnostic], None]) -> None:
    """Warn once of edges with more than two faces, where bodies only touch and readers join equal points."""
    entities = {entity.shape: entity for entity in descendants(*scene.frames) if entity.is_primitive}  # of all frames
    solids = map(solid_of, entities.values())
    surfaces = (solid.surface() for solid in solids if solid is not None)
    count = sum(crowded_edges_of(surface) for surface in surfaces if surface is not None)
    if count:
        edges = "1 edge belongs" if count == 1 else f"{count:,} edges belong"
        message = f"{edges} to more than two faces, because bodies touch along them"
        warn(Diagnostic("crowded-edge", message, None, "let the bodies overlap, or leave a gap between them"))


def _warn_of_textures(scene: Scene, path: Path, warn: Callable[[Diagnostic], None]) -> None:
    """Warn once of textures that a file cannot have: its meshes have their mean colors."""
    primitives = (entity for entity in descendants(*scene.frames) if entity.is_primitive)
    count = sum(entity.embedding.attributes.get("texture") is not None for entity in primitives)
    if count:
        textures = "the texture of 1 primitive" if count == 1 else f"the textures of {count:,} primitives"
        message = f"{path.name} has the mean color instead of {textures}"
        warn(Diagnostic("lost-attribute", message, None, "write .glb, .usd or .obj, and leave out `--solid`"))


def _setting(backend: Backend, options: BackendOptions, name: str) -> Any:
    """Return the value of a setting, None if the backend lacks it."""
    return backend.setting(options, name) if any(option.name == name for option in backend.options) else None


def _as_solids(scene: Scene, segments: int | None, tolerance: float | None) -> Scene:
    """Return the scene with each frame as one computed solid."""
    frames = in_mean_colors(scene).frames
    return scene.with_frames([_as_solid(scene.word, root, segments or SEGMENTS, tolerance) for root in frames])


def _as_solid(word: str, root: Entity, sides: int, tolerance: float | None) -> Entity:
    """Return a frame as one computed solid, or as several distant ones, each about its own center."""
    largest = {} if tolerance is None else _largest(list(descendants(root)), [root], _children_of)

    def sides_of(entity: Entity) -> int:
        """Return the sides of full circles of a primitive."""
        if tolerance is None:
            return sides
        return int(sides_within(entity, largest[id(entity)] * np.eye(3, 4)[None], tolerance)[0])

    parts = [(joined_solid(part, sides_of), offset) for part, offset in _near_parts(root)]
    first = next((entity for entity in descendants(root) if entity.is_primitive), None)
    material = {} if first is None else _material_of(first)
    solids = [
        (Entity(word, Embedding(None, None, material), (), SolidShape.of(expression, material)), offset)
        for expression, offset in parts
        if expression is not None
    ]
    if not solids:
        raise SceneError("solid", f'the scene "{word}" has nothing with a volume')
    if len(solids) == 1 and solids[0][1] is None:
        return solids[0][0]
    return Entity(word, ANONYMOUS, tuple(Pair(solid, translation(offset)) for solid, offset in solids))


_OF_BODIES = ("roughness", "metallic", "opacity", "ior", "coat", "sheen")  # what a body takes from its first primitive


def _material_of(entity: Entity) -> dict[str, Any]:
    """Return the attributes of a primitive's look besides its color and texture, those of its substance included."""
    look, emission = look_of(entity), entity.embedding.attributes.get("emission")
    values = {name: getattr(look, name) for name in _OF_BODIES if getattr(look, name) != getattr(Look(WHITE), name)}
    return values if emission is None else values | {"emission": emission}


def _near_parts(root: Entity) -> list[tuple[Entity, FloatArray | None]]:
    """Return a frame in parts that single precision can hold, with their offsets from the origin.

    It is one part about the origin if possible. Boxes that overlap stay in one part.
    """
    frame = flatten_entity(root, snap_blocks=False)
    boxes = [entity_box(primitive) for primitive in frame.primitives]
    has_box = np.array([box is not None for box in boxes])
    rows = np.flatnonzero(has_box[frame.index]) if len(boxes) else np.zeros(0, np.int64)
    if not len(rows):
        return [(root, None)]
    index, matrices = frame.index[rows], np.asarray(frame.matrices[rows])
    copies = Copies.of_boxes(np.array([box or (0.0,) * 6 for box in boxes]).reshape(-1, 2, 3)[index], matrices)
    if copies.thick().fit(SINGLE.error).all():
        return [(root, None)]
    low, high = copies.centers - copies.radii[:, None], copies.centers + copies.radii[:, None]
    near, _ = neighbors(low, high, 0.0, MAX_VERTICES)
    _, group = np.unique(clusters(len(rows), near.tolist()), return_inverse=True)
    near_parts: list[tuple[Entity, FloatArray | None]] = []
    for groups, offset in chunks_of(copies.grouped(group)):
        members = np.flatnonzero(np.isin(group, groups))
        pairs = [
            Pair(frame.primitives[k], Matrix(about(matrix, offset).ravel().tolist()))
            for k, matrix in zip(index[members].tolist(), matrices[members], strict=True)
        ]
        near_parts.append((Entity(root.word, ANONYMOUS, tuple(pairs)), offset))
    return near_parts


def _children_of(entity: Entity) -> Links[Entity]:
    """Return the children of an entity with their poses."""
    return [(part.car, part.cdr) for part in entity.children]


def _largest(order: Sequence[Node], roots: Sequence[Node], parts: Callable[[Node], Links[Node]]) -> dict[int, float]:
    """Return the scale of the largest copy of each node of a DAG, given in an order with children first.

    Scales along the way from a root are multiplied, which is an upper bound where they stretch differently.
    """
    largest = dict.fromkeys(map(id, order), 0.0) | dict.fromkeys(map(id, roots), 1.0)
    for node in reversed(order):
        links = parts(node)
        linear = pose.stacked([place for _, place in links]).reshape(-1, 3, 4)[:, :, :3]
        norms = np.linalg.norm(linear, 2, axis=(1, 2)).tolist() if links else []
        for (child, _), norm in zip(links, norms, strict=True):
            largest[id(child)] = max(largest[id(child)], largest[id(node)] * norm)
    return largest


@dataclass(frozen=True, slots=True, eq=False)
class Fineness:
    """Division of shared items: fixed, or with a tolerance as fine as their largest copies need."""

    sides: int
    tolerance: float | None
    largest: Mapping[int, float]

    def within(self, item: ExportItem) -> float | None:
        """Return the tolerance in the frame of the item, None for a fixed number of sides."""
        return None if self.tolerance is None else self.tolerance / max(self.largest[id(item)], 1e-300)

    def of(self, item: ExportItem) -> int:
        """Return the sides of full circles of a primitive."""
        within = self.within(item)
        return self.sides if within is None else int(sides_within(item.entity, np.eye(3, 4)[None], within)[0])


def fineness(job: Job, roots: Sequence[ExportItem]) -> Fineness:
    """Return the division of the items below and including ``roots``."""
    largest = {} if job.tolerance is None else _largest(list(distinct(*roots)), roots, lambda item: item.parts)
    return Fineness(job.segments or SEGMENTS, job.tolerance, largest)


def merged_sides(job: Job, entities: Sequence[Entity], hint: str | None = None) -> int:
    """Return the sides of full circles of the ``entities``, which are merged, where no tolerance decides."""
    if job.tolerance is not None:
        return SEGMENTS
    return job.segments or segments_for(entities, "the merged meshes", hint)


def _write_parts(write: Writer, job: Job, folder: Path, path: Path) -> list[str]:
    """Write a file for each part and return the names; raises LimitError for too many."""
    plans = list(parts_of(job.plan))
    if len(plans) > MAX_FILES:
        raise LimitError(
            "size", f"the scene has {len(plans):,} parts, more than the limit of {MAX_FILES:,} files of an export"
        )
    digits = max(3, len(str(len(plans))))
    names = []
    for number, plan in enumerate(plans, start=1):
        name = f"{path.stem}-{number:0{digits}d}-{safe_name(plan.word)}{path.suffix}"
        quiet = replace(job, plan=plan, progress=lambda _: None)
        write(quiet, folder / name)
        names.append(name)
        job.progress(0.99 * number / len(plans))
    return names


def safe_name(word: str) -> str:
    """Return ``word`` reduced to letters, digits and dashes for use in a file name; never empty."""
    return re.sub(r"[^A-Za-z0-9]+", "-", word)[:60].strip("-") or "part"


_UNWRITTEN = re.compile("[\x00-\x1f\x7f\ud800-\udfff@\\[\\]]")  # what texts that name files cannot have


class TextureFiles:
    """Writes the images of textures beside the file at ``path``, each once: ``OUT-obj-brick.png``.

    The format is in the name because the same scene in another one may number its images otherwise.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._names: dict[tuple[Texture, float], str] = {}

    def name_of(self, texture: Texture, is_relief: bool = False) -> str:
        """Return the name of the image of one period of a texture, or of the normals of its relief.

        It is written on first use; raises SceneError("file").
        """
        image = pictured(texture), texture.bump if is_relief else 0.0
        if image not in self._names:
            stem, ending = self._path.stem, self._path.suffix[1:]
            base = f"{_UNWRITTEN.sub('_', stem)}-{ending}-{safe_name(Path(texture.name).stem)}"
            base += "-relief" if is_relief else ""
            name, number, taken = f"{base}.png", 1, {name.lower() for name in self._names.values()}
            while name.lower() in taken:
                number += 1
                name = f"{base}-{number}.png"
            self._path.with_name(name).write_bytes(normals_png(texture) if is_relief else tile_of(texture).png())
            self._names[image] = name
        return self._names[image]


# --- parts -----------------------------------------------------------------------------------------------------


def parts_of(plan: ExportPlan) -> Iterator[ExportPlan]:
    """Yield a plan for each part with geometry: the leaves of the hierarchy, posed in the world, over time."""
    frames = len(plan.roots)
    stack: list[tuple[Moving, tuple[Matrix, ...]]] = [(matched(plan.roots), (IDENTITY,) * frames)]
    remaining = MAX_FILES
    while stack:
        moving, parent_poses = stack.pop()
        world = tuple(pose.compose(a, b) for a, b in zip(parent_poses, moving.filled_poses(), strict=True))
        children = moving.children if moving.fixed is None else _still_parts(moving)
        stack.extend((child, world) for child in reversed(children))
        leaves = [item if item is not None and item.is_leaf else None for item in moving.items]
        if any(item is not None and entity_box(item.entity) is not None for item in leaves):
            remaining -= 1
            if remaining < 0:
                raise LimitError("size", f"the scene has more than the limit of {MAX_FILES:,} parts, one file each")
            yield ExportPlan(
                moving.word, tuple(_wrapped(moving.word, i, w) for i, w in zip(leaves, world)), plan.animated
            )


def _still_parts(moving: Moving) -> list[Moving]:
    """Return the parts of an object that never changes, each present in the object's frames."""
    item = moving.first
    return [
        Moving(
            child.word,
            tuple(child if shown else None for shown in moving.shown),
            tuple(place if shown else None for shown in moving.shown),
            child,
        )
        for child, place in item.parts
    ]


def _wrapped(word: str, item: ExportItem | None, world: Matrix) -> ExportItem:
    """Return a root whose only child is ``item``."""
    if item is None:
        return ExportItem(Entity(word, ANONYMOUS, ()))
    return ExportItem(Entity(word, ANONYMOUS, (Pair(item.entity, world),)), ((item, world),))


def unsupported_frames(roots: Sequence[ExportItem], ending: str) -> None:
    """Raise SceneError("unsupported") for several frames in a single-frame format."""
    if len(roots) > 1:
        raise SceneError("unsupported", f"a {ending} file can contain only one frame", hint="select one with --frame N")


# Flattening: the leaves of a scene in world coordinates, for formats without a hierarchy. Leaves are rows of arrays,
# and all copies of a surface in a block of some hundred thousand vertices are computed at once.


_LARGE_FILE_BYTES = 200e6  # an OBJ file of that size takes ten seconds
# computed at a time: time per primitive is a tenth of that of one by one, and only PLY keeps faces in memory
_BLOCK_VERTICES = 1 << 18
_SIDES_BASE = 2048  # more than a full circle has sides, to combine two numbers in one


@dataclass(frozen=True, slots=True, eq=False)
class Leaves:
    """Items of a frame that are meshes, N instances in depth-first order.

    Attributes
    ----------
    items
        Distinct items.
    index, matrices : (N,), (N, 3, 4)
        Item and world pose of each instance.
    paths, path_index : (N,)
        Words from the root to the parent of each instance, ``paths[path_index[i]]``.
    branch : (N,)
        Number of the root's part that contains each instance.
    """

    items: tuple[ExportItem, ...]
    index: IntArray
    matrices: FloatArray
    paths: tuple[tuple[str, ...], ...]
    path_index: IntArray
    branch: IntArray

    def __len__(self) -> int:
        return len(self.index)

    def by_item(self) -> Iterator[tuple[ExportItem, IntArray]]:
        """Yield each item with the numbers of its instances."""
        ends = np.cumsum(np.bincount(self.index, minlength=len(self.items)))
        yield from zip(self.items, np.split(np.argsort(self.index, kind="stable"), ends[:-1]), strict=True)

    def path(self, number: int) -> tuple[str, ...]:
        """Return the words from the root to an instance, its own included."""
        return (*self.paths[self.path_index[number]], self.items[self.index[number]].word)

    def each(self) -> Iterator[WorldLeaf]:
        """Yield the instances one by one."""
        rows = zip(self.index.tolist(), self.matrices.reshape(-1, 12).tolist(), self.branch.tolist(), strict=True)
        for number, (item, place, branch) in enumerate(rows):
            yield WorldLeaf(self.items[item], Matrix(place), self.path(number), branch)


@dataclass(frozen=True, slots=True)
class WorldLeaf:
    """An item that is a mesh, its world pose, the words from the root to it, and the part of the root that it is in."""

    item: ExportItem
    pose: Matrix
    path: tuple[str, ...]
    branch: int = 0


def leaves_of(plan: ExportPlan, limit: int) -> Leaves:
    """Return the leaves of the only frame; raises LimitError for more than ``limit``."""
    root = plan.roots[0]
    counts = leaf_counts(root)
    if counts[id(root)] > limit:
        raise LimitError(
            "primitives",
            f"the scene expands to {counts[id(root)]:,} primitives, more than the limit of {limit:,}",
            hint="raise it with --max-primitives, or write .glb or .usd, which share repeated parts",
        )
    entity, items = _as_entities(root)
    merged_ones = {key for key, item in items.items() if item.merged}
    flat = flatten_entity(entity, merged_ones, snap_blocks=False)
    leaf_items = tuple(items[id(primitive)] for primitive in flat.primitives)
    part_counts = [counts[id(child)] for child, _ in root.parts]
    branch = np.repeat(np.arange(len(part_counts)), part_counts) if part_counts else np.zeros(len(flat), np.int64)
    index, path_index = flat.index.astype(np.int64), flat.path_index.astype(np.int64)  # items times sides fit
    return Leaves(leaf_items, index, flat.matrices, flat.paths, path_index, branch)


def leaves(plan: ExportPlan, limit: int) -> Iterator[WorldLeaf]:
    """Yield the leaves of the only frame in depth-first order; raises LimitError for more than ``limit``."""
    return leaves_of(plan, limit).each()


def leaf_counts(root: ExportItem) -> dict[int, int]:
    """Return the number of leaves below and including each distinct item."""
    counts: dict[int, int] = {}
    for item in distinct(root):  # children first
        counts[id(item)] = item.is_leaf + sum([counts[id(child)] for child, _ in item.parts])
    return counts


def _as_entities(root: ExportItem) -> tuple[Entity, dict[int, ExportItem]]:
    """Return the items as entities, in which a merged item is a leaf, and the items of the leaves by ``id``."""
    order = list(distinct(root))
    if not any(item.merged for item in order):
        return root.entity, {id(item.entity): item for item in order if item.is_leaf}
    entities: dict[int, Entity] = {}
    for item in order:
        parts = tuple(Pair(entities[id(child)], place) for child, place in item.parts)
        entity = item.entity
        entities[id(item)] = entity if entity.is_primitive else Entity(entity.word, entity.embedding, parts)
    return entities[id(root)], {id(entities[id(item)]): item for item in order if item.is_leaf}


@dataclass(frozen=True, slots=True, eq=False)
class LeafPiece:
    """A surface with one look, and the pose (3, 4) in the leaf that it belongs to.

    If the surface has colors, they are multiplied by the look's color.
    """

    look: Look
    surface: ExportSurface
    pose: FloatArray

    @property
    def colors(self) -> FloatArray | None:
        """The complete color of every vertex (V, 3), None if it is the look's."""
        return None if self.surface.colors is None else self.surface.colors * np.array(self.look.color)

    @property
    def face_colors(self) -> FloatArray | None:
        """The complete color of every face (F, 3), None if points have the colors."""
        return None if self.surface.face_colors is None else self.surface.face_colors * np.array(self.look.color)

    def srgb(self) -> npt.NDArray[np.uint8]:
        """Return the color of every vertex, or one for all, as 8-bit sRGB (V or 1, 4), with the opacity."""
        return self._srgb(self.colors)

    def face_srgb(self) -> npt.NDArray[np.uint8]:
        """Return the color of every face, or one for all, as ``srgb``."""
        return self._srgb(self.face_colors)

    def _srgb(self, own: FloatArray | None) -> npt.NDArray[np.uint8]:
        linear = np.array([self.look.color]) if own is None else own
        out = np.full((len(linear), 4), round(255 * self.look.opacity), np.uint8)
        out[:, :3] = np.rint(255.0 * to_srgb(np.clip(linear, 0.0, 1.0)))
        return out


@dataclass(frozen=True, slots=True, eq=False)
class WorldBlock:
    """Consecutive pieces of a scene in the world, P of them.

    Attributes
    ----------
    kinds, kind, leaf : (K,), (P,), (P,)
        Distinct pieces, and the kind and leaf number of each piece.
    mirrored : (P,)
        Whether the faces of a piece are reversed.
    first : (P + 1,)
        First vertex of each piece in ``vertices`` and ``normals`` (V, 3).
    """

    kinds: Sequence[LeafPiece]
    kind: IntArray
    leaf: IntArray
    mirrored: npt.NDArray[np.bool_]
    first: IntArray
    vertices: FloatArray
    normals: FloatArray

    @property
    def pieces(self) -> Sequence[LeafPiece]:
        """Kind of each piece."""
        return [self.kinds[kind] for kind in self.kind.tolist()]

    def faces(self) -> IntArray:
        """Return the faces (F, 3) of all pieces, which index the vertices of the block."""
        start = _starts(_face_counts(self.kinds)[self.kind])
        out = np.empty((start[-1], 3), np.int64)
        for surface, rows in _by_surface(self.kinds, self.kind):
            faces = np.where(self.mirrored[rows][:, None, None], surface.faces[:, ::-1], surface.faces)
            out[_spans(start[rows], len(surface.faces))] = faces + self.first[rows][:, None, None]
        return out

    def srgb(self) -> npt.NDArray[np.uint8]:
        """Return the color of every vertex (V, 4) as 8-bit sRGB, with the opacity."""
        out = np.empty((self.first[-1], 4), np.uint8)
        for number, rows in _grouped(self.kind):
            piece = self.kinds[number]
            out[_spans(self.first[rows], len(piece.surface.vertices))] = piece.srgb()
        return out

    def face_srgb(self) -> npt.NDArray[np.uint8]:
        """Return the color of every face (F, 4) of pieces whose faces share points, as ``srgb``."""
        sizes = _face_counts(self.kinds)
        return np.concatenate([np.broadcast_to(self.kinds[k].face_srgb(), (sizes[k], 4)) for k in self.kind.tolist()])


def _vertex_counts(kinds: Sequence[LeafPiece]) -> IntArray:
    """Return the number of vertices of each kind of piece."""
    return np.array([len(piece.surface.vertices) for piece in kinds], np.int64)


def _face_counts(kinds: Sequence[LeafPiece]) -> IntArray:
    """Return the number of faces of each kind of piece."""
    return np.array([len(piece.surface.faces) for piece in kinds], np.int64)


def _starts(sizes: Sequence[int] | IntArray) -> IntArray:
    """Return where each of consecutive spans of ``sizes`` starts, and where the last one ends."""
    start = np.zeros(len(sizes) + 1, np.int64)
    np.cumsum(sizes, out=start[1:])
    return start


def _spans(start: IntArray, size: int) -> IntArray:
    """Return the numbers in the spans of ``size`` at each ``start`` (K,), as (K, size)."""
    return start[:, None] + np.arange(size)


def _by_surface(kinds: Sequence[LeafPiece], kind: IntArray) -> Iterator[tuple[ExportSurface, IntArray]]:
    """Yield each distinct surface of pieces with their rows."""
    numbers: dict[int, int] = {}
    surfaces = [numbers.setdefault(id(piece.surface), number) for number, piece in enumerate(kinds)]
    for number, rows in _grouped(np.array(surfaces, np.int64)[kind]):
        yield kinds[number].surface, rows


def _grouped(numbers: IntArray) -> Iterator[tuple[int, IntArray]]:
    """Yield each distinct number with its rows, in order."""
    if not len(numbers):
        return
    order = np.argsort(numbers, kind="stable")
    distinct_numbers, first = np.unique(numbers[order], return_index=True)
    yield from zip(distinct_numbers.tolist(), np.split(order, first[1:]), strict=True)


def _scales_of_merged(scene_leaves: Leaves) -> dict[int, float]:
    """Return the scale of the largest copy of each item that is merged."""
    scales = {}
    for item, rows in scene_leaves.by_item():
        if item.merged:
            norms = np.linalg.norm(scene_leaves.matrices[rows][:, :, :3], 2, axis=(1, 2))
            scales[id(item)] = max(float(norms.max(initial=0.0)), 1e-300)
    return scales


class Surfaces:
    """The leaves of a job with one frame, and their surfaces, each computed once for a number of sides.

    Round primitives have fewer sides if the file would be too large; raises LimitError if that is not enough.
    ``shares``: the faces of a primitive share points (``plan.shared``).
    """

    def __init__(self, job: Job, ending: str, shares: bool = False, textured: bool = False) -> None:
        """Flatten the job's frame and choose the sides of round primitives.

        ``textured``: the surfaces of looks with textures have coordinates, which separates the corners of their faces.
        """
        unsupported_frames(job.plan.roots, ending)
        self.leaves = leaves_of(job.plan, min(job.limit, MAX_VERTICES))
        self._job, self.shares, self._textured = job, shares, textured
        self._merged = _scales_of_merged(self.leaves) if job.tolerance is not None else {}
        self._sides = self._fitting(f"the {ending} file")
        self._row_sides = self._sides_of_rows()
        self._shared: dict[Hashable, ExportSurface | None] = {}
        self._pieces: dict[tuple[int, int], Sequence[LeafPiece]] = {}
        self._patches: dict[tuple[int, int], Sequence[Patch]] = {}

    def _fitting(self, what: str) -> int:
        """Return the number of sides of full circles, as chosen or as fits."""
        hint = "write .glb or .usd, which share repeated parts"
        counts = np.bincount(self.leaves.index, minlength=len(self.leaves.items)).tolist()
        entities = [item.entity for item in self.leaves.items]
        total = sum(count * primitive_count(entity) for count, entity in zip(counts, entities, strict=True))
        if total > self._job.limit:
            message = f"the scene expands to {total:,} primitives, more than the limit of {self._job.limit:,}"
            raise LimitError("primitives", message, hint)
        if self._job.tolerance is not None:
            return SEGMENTS
        return self._job.segments or segments_for(entities, what, hint, counts)

    def sides(self) -> IntArray:
        """Return the number of sides of full circles in each leaf."""
        return self._row_sides

    def _sides_of_rows(self) -> IntArray:
        """Return the sides of full circles of each leaf, as the tolerance needs; raises LimitError."""
        sides = np.full(len(self.leaves), self._sides)
        tolerance = self._job.tolerance
        if tolerance is None:
            return sides
        remaining = MAX_VERTICES
        for item, rows in self.leaves.by_item():
            if item.merged:
                continue
            sides[rows] = sides_within(item.entity, self.leaves.matrices[rows], tolerance)
            for count, times in zip(*np.unique(sides[rows], return_counts=True), strict=True):
                remaining -= int(times) * vertex_count(item.entity, int(count))
        if remaining < 0:
            raise too_fine(self._job.plan.word)
        return sides

    def size(self) -> tuple[int, int]:
        """Return the number of vertices and of faces of all pieces."""
        vertices = faces = 0
        for pieces, count in self.kinds():
            vertices += count * sum(len(piece.surface.vertices) for piece in pieces)
            faces += count * sum(len(piece.surface.faces) for piece in pieces)
        return vertices, faces

    def kinds(self) -> Iterator[tuple[Sequence[LeafPiece], int]]:
        """Yield the pieces of each distinct leaf, and how many instances it has."""
        keys, counts = np.unique(np.stack([self.leaves.index, self.sides()]), axis=1, return_counts=True)
        for number, sides, count in zip(*keys.tolist(), counts.tolist(), strict=True):
            yield self.pieces(self.leaves.items[number], sides), count

    def patches(self, item: ExportItem, sides: int) -> Sequence[Patch]:
        """Return the surface of a leaf, one patch per material, with the pose of each in the leaf."""
        key = id(item), sides
        if key not in self._patches:
            self._patches[key] = [_as_patch(piece) for piece in self.pieces(item, sides)]
        return self._patches[key]

    def announce(self, size: float, ending: str) -> None:
        """Warn, before it is written, of a file of an estimated ``size`` in bytes that is large."""
        if size > _LARGE_FILE_BYTES:
            message = f"the {ending} file will have about {size / 1e6:,.0f} MB"
            self._job.warn(Diagnostic("large-file", message, None, "write .glb or .usd, which share repeated parts"))

    def keeps_shapes(self, rounding: Rounding) -> bool:
        """Return whether all bodies keep their volumes if their world coordinates are rounded."""
        return next(self.changed(rounding), None) is None

    def changed(self, rounding: Rounding) -> Iterator[tuple[str, ChangedBody]]:
        """Yield the words and bodies whose volumes rounded world coordinates change by more than .1 %."""
        for value, rows in _grouped(self.leaves.index * _SIDES_BASE + self.sides()):
            item = self.leaves.items[value // _SIDES_BASE]
            for piece in self.pieces(item, value % _SIDES_BASE):
                poses = composed(self.leaves.matrices[rows], piece.pose)
                fits = Copies.of(piece.surface.vertices, piece.surface.faces, poses).fit(rounding.error)
                if fits.all():
                    continue
                points, faces, _ = points_of(piece.surface)
                for body in changed_bodies(points, faces, poses[~fits], rounding):
                    yield _word_at(item, piece, points[body.corner]), body

    def pieces(self, item: ExportItem, sides: int) -> Sequence[LeafPiece]:
        """Return the surface of a leaf, one piece per material, as surfaces that equal forms share."""
        key = id(item), sides
        if key not in self._pieces:
            self._pieces[key] = self._make_pieces(item, sides)
        return self._pieces[key]

    def _make_pieces(self, item: ExportItem, sides: int) -> Sequence[LeafPiece]:
        """Return the surface of a leaf as pieces that share surfaces by their keys."""
        if item.merged:
            return [LeafPiece(p.look, p.surface, _rows_of(p.pose)) for p in self._patches_of(item, sides)]
        look, solid = look_of(item.entity), solid_of(item.entity)
        if solid is None or look.opacity == 0.0:
            return []
        texture = look.texture if self._textured else None
        key = solid.key_in(texture), sides
        if key not in self._shared:
            unshared = solid.surface(sides, texture)
            self._shared[key] = shared(unshared) if unshared is not None and self.shares else unshared
        surface = self._shared[key]
        return [] if surface is None or not len(surface.faces) else [LeafPiece(look, surface, _rows_of(solid.pose))]

    def _patches_of(self, item: ExportItem, sides: int) -> Sequence[Patch]:
        """Return a merged item as patches, with the tolerance of its largest copy."""
        tolerance = self._job.tolerance
        return merged(item.entity, sides, None if tolerance is None else tolerance / self._merged[id(item)])

    def blocks(self) -> Iterator[WorldBlock]:
        """Yield all visible leaves with their triangles in the world, in order."""
        key, kind_of_row = np.unique(self.leaves.index * _SIDES_BASE + self.sides(), return_inverse=True)
        pieces_of_key = [self.pieces(self.leaves.items[k // _SIDES_BASE], k % _SIDES_BASE) for k in key.tolist()]
        kinds = [piece for pieces in pieces_of_key for piece in pieces]
        first = _starts([len(pieces) for pieces in pieces_of_key])
        sizes = np.diff(_starts(_vertex_counts(kinds))[first])
        kind_of_row = kind_of_row.reshape(-1)
        block_of_row = np.cumsum(sizes[kind_of_row]) // _BLOCK_VERTICES
        for rows in np.split(np.arange(len(kind_of_row)), np.flatnonzero(np.diff(block_of_row)) + 1):
            counts = np.diff(first)[kind_of_row[rows]]
            if counts.any():
                kind = np.repeat(first[kind_of_row[rows]] - _starts(counts)[:-1], counts) + np.arange(counts.sum())
                yield self._block(kinds, kind, np.repeat(rows, counts))

    def _block(self, kinds: Sequence[LeafPiece], kind: IntArray, leaf: IntArray) -> WorldBlock:
        """Return pieces of leaves as vertices and normals in the world."""
        first = _starts(_vertex_counts(kinds)[kind])
        piece_poses = np.array([piece.pose for piece in kinds])[kind]
        poses = composed(self.leaves.matrices[leaf], piece_poses)
        vertices, normals = np.empty((first[-1], 3)), np.empty((first[-1], 3))
        mirrored = np.zeros(len(kind), np.bool_)
        for surface, rows in _by_surface(kinds, kind):
            spans = _spans(first[rows], len(surface.vertices))
            vertices[spans], normals[spans], mirrored[rows] = surface.copies(poses[rows])
        return WorldBlock(kinds, kind, leaf, mirrored, first, vertices, normals)


def _rows_of(place: Matrix) -> FloatArray:
    """Return a pose as an array (3, 4)."""
    return np.array(place).reshape(3, 4)


def _word_at(item: ExportItem, piece: LeafPiece, point: FloatArray) -> str:
    """Return the word of a leaf, or of the part of a computed solid that has a point (3,) of its surface."""
    shape = item.entity.shape
    if item.merged or not isinstance(shape, SolidShape):
        return item.word
    mesh = shape.computed.mesh
    if mesh.part is None:
        return mesh.part_words[0] if mesh.part_words else item.word
    distance = np.linalg.norm(mesh.vertices - (point + piece.pose[:, 3]), axis=1)
    return mesh.part_words[int(mesh.part[np.flatnonzero((mesh.faces == int(distance.argmin())).any(axis=1))[0]])]


def _as_patch(piece: LeafPiece) -> Patch:
    """Return a piece with its complete colors, in the frame of its leaf or about an offset from it."""
    surface = replace(_in_leaf(piece), colors=piece.colors, face_colors=piece.face_colors)
    offset = own_offset(surface.vertices, surface.faces)
    return Patch(piece.look, surface if offset is None else surface.moved(-offset), translation(offset))


def _in_leaf(piece: LeafPiece) -> ExportSurface:
    """Return the surface of a piece in the frame of its leaf; corners keep their joints."""
    if (piece.pose == np.eye(3, 4)).all():
        return piece.surface
    return replace(piece.surface.under(piece.pose[None]), joints=piece.surface.joints)
