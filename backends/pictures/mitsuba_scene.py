"""Mitsuba scene description: instancing, materials, camera, lighting, ground and meshes of a stage."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.camera import Camera
from scenelang.backends.pictures.mitsuba_materials import bitmap_paint, is_glass, kind_of, relief, rgb, surface
from scenelang.backends.pictures.stage import Stage, Staging
from scenelang.backends.surfaces.appearance import Look, look_of
from scenelang.backends.surfaces.dome import Dome
from scenelang.backends.surfaces.environments import CHECKER, CHECKER_EDGE, GROUND_EDGE, Studio
from scenelang.backends.surfaces.lights import Light, Point
from scenelang.backends.surfaces.solids import Solids, composed, normalized, own_mesh, solids_of, thinness
from scenelang.backends.surfaces.tiles import corner_coordinates
from scenelang.backends.surfaces.unwrapping import divided
from scenelang.interpreter.scene.entity import Entity, descendants, instance_counts
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives.forms import TRIANGLE, CanonicalForm
from scenelang.interpreter.scene.primitives.mesh import inverses_of, posed
from scenelang.interpreter.scene.primitives.textures import Texture

# Instancing: a cut through the entity DAG. Mitsuba has one level of instancing and no emitters inside instances, so
# each path from the root to a primitive is cut once: below the cut are prototypes, shared entities whose solids become
# one shape group; above it are their instances.


FloatArray = npt.NDArray[np.float64]

_SUN_DISTANCE = 1e6  # of the disk that a sun is, in units of the scene's half diagonal
_MIN_BLEND = 1e-3  # Mitsuba divides by the width over which a spot fades
FEW = 20_000  # solids that can all be instances of exact unit shapes; larger scenes are cut into prototypes


@dataclass(frozen=True, slots=True, eq=False)
class Prototype:
    """A shared entity drawn as instances.

    Attributes
    ----------
    entity
        The source.
    solids
        In the entity's frame, scaled to unit size.
    matrices : (N, 3, 4)
        Poses of the instances in the frame of the stage.
    """

    entity: Entity
    solids: Solids
    matrices: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """A frame split into prototypes and the remaining ``loose`` solids, in the stage's frame."""

    prototypes: tuple[Prototype, ...]
    loose: Solids


@dataclass(frozen=True, slots=True, eq=False)
class _Counts:
    """Numbers of every distinct entity, by ``id``.

    Attributes
    ----------
    order
        Entities, children before parents.
    solids, instances
        Its number of solids, and of instances in the scene.
    allowed
        Whether it may be a prototype.
    """

    order: tuple[Entity, ...]
    solids: dict[int, int]
    instances: dict[int, int]
    allowed: dict[int, bool]


def parts_of(staging: Staging, frame: int) -> Parts | None:
    """Split frame number ``frame`` of a staging into prototypes and loose solids; None if there is little sharing."""
    root = staging.roots[frame]
    cut = _best_cut(root, _count(root))
    if not cut:
        return None
    flat = flatten_entity(root, cut)
    is_cut = np.array([id(entity) in cut for entity in flat.primitives], bool)
    prototypes = []
    index = np.asarray(flat.index)
    for number in np.flatnonzero(is_cut):
        prototype = _prototype(staging, flat.primitives[number], flat.matrices[index == number])
        if prototype is not None:
            prototypes.append(prototype)
    loose = flat.select(~is_cut[index])
    return Parts(tuple(prototypes), normalized(solids_of(loose), staging.center, staging.scale))


def _prototype(staging: Staging, entity: Entity, matrices: FloatArray) -> Prototype | None:
    """Return the prototype for ``entity`` under world ``matrices`` (N, 3, 4), None if nothing of it is drawable."""
    solids = solids_of(flatten_entity(entity))
    if not len(solids):
        return None
    reach = np.abs(solids.matrices[:, :, :3]).sum(axis=2)
    low, high = (solids.matrices[:, :, 3] - reach).min(axis=0), (solids.matrices[:, :, 3] + reach).max(axis=0)
    middle, half = (low + high) / 2.0, 0.5 * float(np.linalg.norm(high - low))
    size = half if half > 1e-300 else 1.0
    unit_solids = normalized(solids, middle, 1.0 / size)
    outward = np.concatenate([np.eye(3) * size, middle[:, None]], axis=1)
    to_stage = np.concatenate([np.eye(3) * staging.scale, (-staging.center * staging.scale)[:, None]], axis=1)
    placed = composed(composed(to_stage[None], matrices), outward[None])
    is_valid = np.isfinite(placed).all(axis=(1, 2)) & (np.abs(np.linalg.det(placed[:, :, :3])) > 1e-30)
    return Prototype(entity, unit_solids, placed[is_valid]) if len(unit_solids) and is_valid.any() else None


def _count(root: Entity) -> _Counts:
    """Count the solids and instances of every entity."""
    order = tuple(descendants(root))
    solids: dict[int, int] = {}
    allowed: dict[int, bool] = {}
    for entity in order:
        below = [id(part.car) for part in entity.children]
        solids[id(entity)] = _solids_in(entity) + sum(solids[child] for child in below)
        can_be_instanced = not entity.is_primitive or is_instantiable(look_of(entity))
        allowed[id(entity)] = can_be_instanced and all(allowed[child] for child in below)
    return _Counts(order, solids, instance_counts(order), allowed)


def is_instantiable(look: Look) -> bool:
    """Return whether instances of any size may share a surface: no emitter, and no relief, which has a depth."""
    return not any(look.emission) and (look.texture is None or not look.texture.bump)


def _solids_in(entity: Entity) -> int:
    """Return the number of solids of a primitive: one, or the number of triangles of a mesh."""
    mesh = None if entity.shape is None else own_mesh(entity.shape)
    return int(entity.is_primitive) if mesh is None else len(mesh.faces)


def _best_cut(root: Entity, counts: _Counts) -> frozenset[int]:
    """Return the ids of the prototypes: shared entities up to the size that minimizes the number of stored shapes.

    There are none if half of all solids are distinct, because little would be shared.
    """
    largest = counts.solids[id(root)]
    distinct = sum(counts.solids[id(entity)] for entity in counts.order if entity.is_primitive)
    if 2 * distinct > largest:
        return frozenset()
    sizes = sorted({1 << k for k in range(largest.bit_length())} | set(_sample(sorted(set(counts.solids.values())))))
    best: tuple[int, frozenset[int]] = (largest, frozenset())
    for size in sizes:
        cut, stored = _cut_below(root, counts, size)
        if stored < best[0]:
            best = (stored, cut)
    return best[1]


def _sample(values: Sequence[int]) -> Sequence[int]:
    """Return some 32 of many values, evenly spread."""
    return values[:: max(1, len(values) // 32)]


def _cut_below(root: Entity, counts: _Counts, size: int) -> tuple[frozenset[int], int]:
    """Return the cut at entities of at most ``size`` solids, and the number of shapes (solids and instances) it
    stores."""
    cut: set[int] = set()
    stored = 0
    opened = {id(root)}
    for entity in reversed(counts.order):  # parents before children
        if id(entity) not in opened:
            continue
        for part in entity.children:
            child = id(part.car)
            if not counts.solids[child]:
                continue
            shared = counts.allowed[child] and counts.instances[child] > 1
            if shared and counts.solids[child] <= size:
                if child not in cut:
                    cut.add(child)
                    stored += counts.solids[child]
                stored += counts.instances[id(entity)]
            elif part.car.is_primitive:
                stored += counts.instances[id(entity)]
            else:
                opened.add(child)
    return frozenset(cut), stored


# Camera, lighting and ground.


_LIGHT_DISTANCE = 1e6  # distance of the key light, so far that it lights the whole ground evenly
_GROUND_OFFSET = 1e-4  # offset of the plain ground below the checkerboard


def surroundings(mi: Any, stage: Stage, depth: int) -> dict[str, Any]:
    """Return Mitsuba's scene dictionary without the solids."""
    environment = stage.studio.environment
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": depth},
        "sensor": sensor(mi, stage.camera),
        "around": {"type": "envmap", "bitmap": mi.Bitmap(around(stage.studio.dome))},
    }
    if any(environment.key):
        scene["key"] = _key_light(mi, stage.studio)
    if stage.ground is not None and stage.studio.ground is not None:
        scene |= _ground(mi, stage.ground, stage.studio.ground)
    return scene | _emitters(mi, stage.lights)


def _emitters(mi: Any, lights: tuple[Light, ...]) -> dict[str, Any]:
    """Return the lights of a stage as Mitsuba's emitters by name; ``mi`` is its module."""
    return {f"light{number}": _emitter(mi, light) for number, light in enumerate(lights)}


def _emitter(mi: Any, light: Light) -> dict[str, Any]:
    """Return the emitter of a light: shapes for those with an extent, which cameras and mirrors see."""
    position, flux = list(light.position), light.flux
    if light.kind == "sun":
        angle = math.radians(light.radius)
        if angle == 0.0:
            frame = _facing(mi, [0.0, 0.0, 0.0], light.direction)
            return {"type": "directional", "to_world": frame, "irradiance": rgb(flux)}
        away = [-_SUN_DISTANCE * x for x in light.direction]
        frame = _facing(mi, away, light.direction).scale(_SUN_DISTANCE * math.tan(angle))
        return _shining("disk", frame, flux / (math.pi * math.sin(angle) ** 2))
    if light.kind == "spot":
        half, blend = light.angle / 2.0, max(light.blend, _MIN_BLEND)
        return {
            "type": "spot", "to_world": _facing(mi, position, light.direction), "cutoff_angle": half,
            "beam_width": half * (1.0 - blend), "intensity": rgb(flux / (4.0 * math.pi)),
        }  # fmt: skip
    if light.kind == "area":
        width, height = light.size
        frame = _facing(mi, position, light.direction).scale([width / 2.0, height / 2.0, 1.0])
        return _shining("rectangle", frame, light.radiance)
    if light.radius == 0.0:
        return {"type": "point", "position": position, "intensity": rgb(flux / (4.0 * math.pi))}
    return _shining("sphere", mi.ScalarTransform4f().translate(position).scale(light.radius), light.radiance)


def _facing(mi: Any, position: list[float], direction: Point) -> Any:
    """Return the transform that moves the origin to a position and turns +z to a direction."""
    up = [0.0, 1.0, 0.0] if abs(direction[1]) < 0.999 else [0.0, 0.0, 1.0]
    target = [a + b * max(1.0, *map(abs, position)) for a, b in zip(position, direction, strict=True)]
    return mi.ScalarTransform4f().look_at(origin=position, target=target, up=up)


def _shining(shape: str, to_world: Any, radiance: FloatArray) -> dict[str, Any]:
    """Return a black shape that emits ``radiance`` (3,)."""
    emitter = {"type": "area", "radiance": rgb(radiance)}
    bsdf = {"type": "diffuse", "reflectance": rgb(np.zeros(3))}
    return {"type": shape, "to_world": to_world, "emitter": emitter, "bsdf": bsdf}


def sensor(mi: Any, camera: Camera) -> dict[str, Any]:
    """Return Mitsuba's sensor for a camera, a thin lens if it has an aperture."""
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = -camera.right, camera.up, camera.forward, camera.eye
    (focal, _), (cx, cy) = camera.focal, camera.principal
    plugin: dict[str, Any] = {
        "type": "perspective",
        "near_clip": 1e-4,
        "far_clip": 1e5,
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},  # the denoiser expects independent noise per pixel
        },
        "sampler": {"type": "multijitter"},
    }
    if camera.is_parallel:
        half = camera.width / (2.0 * focal)
        matrix[:3, 3] += (camera.width / 2.0 - cx) / focal * camera.right - (
            camera.height / 2.0 - cy
        ) / focal * camera.up
        to_world = mi.ScalarTransform4f(matrix).scale([half, half, 1.0])
        return plugin | {"type": "orthographic", "to_world": to_world}
    plugin |= {
        "to_world": mi.ScalarTransform4f(matrix),
        "fov": 2.0 * math.degrees(math.atan(camera.width / (2.0 * focal))),
        "fov_axis": "x",
        "principal_point_offset_x": cx / camera.width - 0.5,
        "principal_point_offset_y": cy / camera.height - 0.5,
    }
    if camera.aperture > 0.0:
        plugin |= {"type": "thinlens", "aperture_radius": camera.aperture, "focus_distance": camera.focus}
        del plugin["principal_point_offset_x"], plugin["principal_point_offset_y"]
    return plugin


def around(dome: Dome) -> npt.NDArray[np.float32]:
    """Return the image (K, 2 K, 3) of a dome for Mitsuba's ``envmap``.

    Its columns are in the reverse order, and its first and last rows are the zenith and the nadir themselves. It has
    twice the rows of the dome, because both interpolate.
    """
    height = 2 * len(dome.panorama.image)
    polar = np.arange(height)[:, None] / (height - 1) * math.pi
    turn = ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * -2.0 * math.pi
    directions = [np.sin(polar) * np.sin(turn), np.cos(polar) + 0.0 * turn, np.sin(polar) * np.cos(turn)]
    return dome.radiance(np.stack(directions, axis=2).reshape(-1, 3)).reshape(height, 2 * height, 3).astype(np.float32)


def _key_light(mi: Any, studio: Studio) -> dict[str, Any]:
    """Return a disk emitter so far away that its light is nearly parallel, with the environment's angular radius."""
    angle = math.radians(studio.environment.radius)
    # A white surface facing the lamp has the radiance KEY = irradiance / pi = radiance (radius / distance)^2.
    radiance = np.array(studio.environment.key) / math.sin(angle) ** 2
    frame = mi.ScalarTransform4f().look_at(
        origin=[float(x) for x in studio.key_direction * _LIGHT_DISTANCE], target=[0.0, 0.0, 0.0], up=[0.0, 1.0, 0.0]
    )
    return {
        "type": "disk",
        "to_world": frame.scale(_LIGHT_DISTANCE * math.tan(angle)),
        "emitter": {"type": "area", "radiance": rgb(radiance)},
        "bsdf": {"type": "diffuse", "reflectance": rgb((0.0, 0.0, 0.0))},
    }


def _ground(mi: Any, height: float, colors: Any) -> dict[str, Any]:
    """Return a large disk, below a checkerboard if the ground has two colors."""
    is_plain = bool((colors[0] == colors[1]).all())

    def lying(at: float) -> Any:
        """Return the transform that lays a shape of the xy plane on the height ``at``."""
        return mi.ScalarTransform4f().translate([0.0, at, 0.0]).rotate([1, 0, 0], -90.0)

    disk = lying(height if is_plain else height - _GROUND_OFFSET).scale(GROUND_EDGE)
    parts = {"ground": {"type": "disk", "to_world": disk, "bsdf": _diffuse(rgb(colors.mean(axis=0)))}}
    if not is_plain:
        periods = 2.0 * CHECKER_EDGE / (2.0 * CHECKER)
        texture = {
            "type": "checkerboard",
            "color0": rgb(colors[1]),
            "color1": rgb(colors[0]),
            "to_uv": mi.ScalarTransform3f().scale([periods, periods]),
        }
        square = lying(height).scale(CHECKER_EDGE)
        parts["squares"] = {"type": "rectangle", "to_world": square, "bsdf": _diffuse(texture)}
    return parts


def _diffuse(reflectance: dict[str, Any]) -> dict[str, Any]:
    """Return a two-sided Lambertian BSDF."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}


# Solids as Mitsuba shapes: exact unit shapes for instancing, and merged meshes with per-face colors. A form provides
# its exact shapes (``Form.mitsuba``). Mitsuba's spheres do not support non-uniform scales, so unit shapes are placed as
# instances, which are correct under any invertible affine pose. Merged meshes load in linear time.


IntArray = npt.NDArray[np.int64]

SEGMENTS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192)  # numbers of sides of round solids
UNIT_SEGMENTS = 256  # of unit shapes that are meshes
_MAX_DEVIATION = 0.15  # of a polygon from its circle, in pixels
_MAX_FACES = 24_000_000  # of all merged meshes; beyond, tessellation is coarser
_EMISSION_STEPS = 16  # quantization steps of the radiance of emitters, per channel and unit: few distinct meshes


def unit_parts(form: CanonicalForm, ratios: tuple[float, ...], look: Look) -> list[dict[str, Any]]:
    """Return the exact shapes of a canonical form, without materials, with poses as (4, 4).

    Empty if the form must be a mesh of ``UNIT_SEGMENTS`` sides: Mitsuba has no such shapes, or the form's shapes
    overlap, which transparency would make visible.
    """
    parts = form.mitsuba(ratios)
    return [] if form.overlaps and look.opacity < 1.0 else parts


def unit_group(mi: Any, form: CanonicalForm, ratios: tuple[float, ...], look: Look) -> Any:
    """Return a shape group of the canonical form with the material ``look``."""
    bsdf = mi.load_dict(surface(look))
    parts = {}
    for k, part in enumerate(unit_parts(form, ratios, look)):
        pose = {"to_world": mi.ScalarTransform4f(part["to_world"])} if "to_world" in part else {}
        parts[f"part{k}"] = part | pose | {"bsdf": bsdf}
    if not parts:
        mesh = form.mesh(UNIT_SEGMENTS, ratios)
        parts = {"mesh": _plain_mesh(mi, bsdf, mesh.vertices, mesh.normals, mesh.faces)}
    return mi.load_dict({"type": "shapegroup", **parts})


def _plain_mesh(mi: Any, bsdf: Any, vertices: FloatArray, normals: FloatArray | None, faces: IntArray) -> Any:
    """Return a mesh of one material."""
    props = mi.Properties()
    props["bsdf"] = bsdf
    props["face_normals"] = normals is None
    mesh = mi.Mesh("solids", len(vertices), len(faces), has_vertex_normals=normals is not None, props=props)
    _fill(mi, mesh, vertices, normals, faces)
    return mesh


def _fill(
    mi: Any,
    mesh: Any,
    vertices: FloatArray,
    normals: FloatArray | None,
    faces: IntArray,
    places: FloatArray | None = None,
) -> None:
    """Write vertices, with their texture coordinates ``places`` (V, 2), and faces into a mesh of Mitsuba."""
    params = mi.traverse(mesh)
    values = {"vertex_positions": vertices.astype(np.float32), "faces": faces.astype(np.uint32)}
    if normals is not None:
        values["vertex_normals"] = normals.astype(np.float32)
    if places is not None:
        values["vertex_texcoords"] = places.astype(np.float32)
    is_scalar = str(mi.variant()).startswith("scalar")
    for name, value in values.items():
        if is_scalar:  # into its memory: an assignment compares all values first
            np.asarray(params[name])[:] = value.ravel()
            params.set_dirty(name)
        else:
            params[name] = value.ravel()
    params.update()


# --- merged meshes ---------------------------------------------------------------------------------------------


def merged_meshes(mi: Any, solids: Solids, segments: IntArray) -> Iterator[Any]:
    """Yield merged meshes of all solids, grouped by what must be uniform within a mesh.

    That is the radiance, the kind of material, and flat or smooth shading.

    Parameters
    ----------
    segments : (N,)
        Numbers of sides of round solids.
    """
    flat = ~solids.that_are("is_curved")
    emission = np.rint(solids.emission * _EMISSION_STEPS) / _EMISSION_STEPS
    numbers: dict[Look, int] = {}
    kinds = np.array([numbers.setdefault(kind_of(look), len(numbers)) for look in solids.looks.rows], np.int64)
    looks = tuple(numbers)
    clear = (solids.opacity < 1.0) & ~np.array([is_glass(look) for look in looks], bool)[kinds][solids.look]
    keys = np.column_stack([emission, kinds[solids.look], flat, clear, _depths(solids)])
    groups, group = np.unique(keys, axis=0, return_inverse=True)
    for k, key in enumerate(groups):
        rows = np.flatnonzero(group.reshape(-1) == k)
        radiance = {"type": "area", "radiance": rgb(key[:3])} if key[:3].any() else None
        part = _Part(solids.take(rows), segments[rows], looks[int(key[3])], bool(key[5]), float(key[6]))
        yield _merged_mesh(mi, part, radiance, is_flat=bool(key[4]))


def _depths(solids: Solids) -> FloatArray:
    """Return the depths (N,) of the reliefs of solids in the frame of reference, to a thousandth; 0 without one."""
    depths = np.array([0.0 if look.texture is None else look.texture.depth for look in solids.looks.rows])[solids.look]
    rows = np.flatnonzero(depths)
    if len(rows):
        linear, _ = solids.into_primitives(rows)
        depths[rows] /= np.abs(np.linalg.det(linear)) ** (1.0 / 3.0)
        digit = 10.0 ** (np.floor(np.log10(np.abs(depths[rows]))) - 2.0)
        depths[rows] = np.rint(depths[rows] / digit) * digit
    return depths


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Solids of one mesh: their numbers of sides, what their materials share, whether some are transparent, and the
    depth of their relief."""

    solids: Solids
    segments: IntArray
    look: Look
    is_clear: bool
    depth: float


def _merged_mesh(mi: Any, part: _Part, emitter: dict[str, Any] | None, *, is_flat: bool) -> Any:
    """Return one mesh of solids with the colors and opacities of its faces as attributes, or with a texture."""
    vertices, normals, faces, owner = _merged(part.solids, part.segments)
    texture, places = part.look.texture, None
    if texture is not None:
        vertices, normals, faces, owner, places = _unwrapped(texture, part.solids, vertices, normals, faces, owner)
    look = part.solids.look[owner]
    attributes: dict[str, FloatArray] = {}

    def of_faces(values: FloatArray) -> dict[str, Any]:
        """Return the texture of values (looks, channels), which becomes an attribute of the mesh."""
        name = f"face_values{len(attributes)}"
        attributes[name] = values[look]
        return {"type": "mesh_attribute", "name": name}

    def bitmap(image: npt.NDArray[np.float32]) -> dict[str, Any]:
        """Return the entry of a bitmap that holds an image."""
        return {"bitmap": mi.Bitmap(image)}

    colors = part.solids.looks.color
    paint = (lambda lobe: of_faces(lobe(colors))) if texture is None else bitmap_paint(texture, bitmap)
    opacity = of_faces(part.solids.looks.opacity[:, None]) if part.is_clear else None
    bump = None if texture is None else relief(texture, part.depth, bitmap)
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(surface(part.look, paint, opacity, bump))
    props["face_normals"] = is_flat
    if emitter is not None:
        props["emitter"] = mi.load_dict(emitter)
    mesh = mi.Mesh(
        "solids", len(vertices), len(faces), has_vertex_normals=not is_flat, has_vertex_texcoords=places is not None,
        props=props,
    )  # fmt: skip
    for name, values in attributes.items():
        mesh.add_attribute(name, values.shape[1], values.astype(np.float32).ravel())
    _fill(mi, mesh, vertices, None if is_flat else normals, faces, places)
    return mesh


def _unwrapped(
    texture: Texture, solids: Solids, vertices: FloatArray, normals: FloatArray, faces: IntArray, owner: IntArray
) -> tuple[FloatArray, FloatArray, IntArray, IntArray, FloatArray]:
    """Return a mesh of solids as ``_merged`` does, with three vertices for each face, and their coordinates (V, 2).

    Corners of one vertex may have different coordinates. Faces are divided where coordinates bend.
    """
    linear, offset = solids.into_primitives(owner)
    mirrored = np.linalg.det(linear) < 0.0  # whose corners go round the primitive as those of its inside do
    faces = _turned(faces, mirrored)
    own = np.einsum("fij,fcj->fci", linear, vertices[faces]) + offset[:, None]
    marks = np.broadcast_to(np.stack([owner, mirrored], 1, dtype=np.float64)[:, None], (len(faces), 3, 2))
    corners = divided(texture, np.concatenate([own, vertices[faces], normals[faces], marks], axis=2))
    flat = corners[:, :, 3:9].reshape(-1, 6)
    shading = flat[:, 3:] / np.linalg.norm(flat[:, 3:], axis=1)[:, None].clip(1e-300)
    places = corner_coordinates(texture, corners[:, :, :3]).reshape(-1, 2)
    owner, mirrored = np.rint(corners[:, 0, 9:]).astype(np.int64).T
    return flat[:, :3], shading, _turned(np.arange(len(flat)).reshape(-1, 3), mirrored > 0), owner, places


def _turned(faces: IntArray, which: npt.NDArray[np.bool_]) -> IntArray:
    """Return triangles (F, 3), some with the other orientation."""
    return np.where(which[:, None], faces[:, ::-1], faces)


def segments_for(solids: Solids, pixels: FloatArray) -> IntArray:
    """Return the number of sides (N,) of round solids whose size is ``pixels`` (N,); 0 for flat ones.

    The tessellation is coarser if the meshes would exceed the memory limit.
    """
    target_segments = math.pi * np.sqrt(pixels / (2.0 * _MAX_DEVIATION))
    choices = np.array(SEGMENTS)
    for coarser in range(len(choices)):
        sides = choices[np.clip(np.searchsorted(choices, target_segments) - coarser, 0, len(choices) - 1)]
        faces = sum(
            int(form.face_count(sides[rows], solids.ratios_of(form, rows)).sum()) for form, rows in solids.groups()
        )
        if faces <= _MAX_FACES:
            break
    return np.asarray(np.where(solids.that_are("is_curved"), sides, 0), np.int64)


def is_too_flat(solids: Solids) -> npt.NDArray[np.bool_]:
    """Return which solids (N,) are too flat for the exact shapes of their forms in single precision."""
    min_aspect_ratio = np.array([kind.min_aspect_ratio for kind in solids.kinds])[solids.forms]
    return np.asarray(thinness(solids.matrices) < min_aspect_ratio * sizes_of(solids.matrices), bool)


def dissolves(form: CanonicalForm, matrix: FloatArray) -> bool:
    """Return whether a pose (3, 4) is too flat for the exact shapes of a form in single precision."""
    return bool(thinness(matrix[None])[0] < form.min_aspect_ratio * sizes_of(matrix[None])[0])


def sizes_of(matrices: FloatArray) -> FloatArray:
    """Return the longest half axis (N,) of solids under ``matrices`` (N, 3, 4)."""
    return np.asarray(np.sqrt(np.einsum("nij,nij->nj", matrices[:, :, :3], matrices[:, :, :3])).max(axis=1), np.float64)


def _smooth_triangles(
    solids: Solids, rows: IntArray, start: int
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:  # fmt: skip
    """Return the triangles ``rows`` of smooth surfaces as a part of ``_merged``, with vertices from ``start`` on."""
    matrices = solids.matrices[rows]
    vertices = TRIANGLE.hull(()) @ np.swapaxes(matrices[:, :, :3], 1, 2) + matrices[:, None, :, 3]
    local = solids.ratios[rows, :9].reshape(-1, 3, 3)
    normals = np.einsum("kji,kcj->kci", inverses_of(matrices[:, :, :3]), local)
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-300)
    faces = start + np.arange(3 * len(rows)).reshape(-1, 3)
    mirrored = np.linalg.det(matrices[:, :, :3]) < 0.0
    faces[mirrored] = faces[mirrored][:, ::-1]
    return vertices.reshape(-1, 3), normals.reshape(-1, 3), faces, rows


def _merged(solids: Solids, segments: IntArray) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Return vertices, normals and faces of all solids, and the index of the solid that owns each face."""
    parts: list[tuple[FloatArray, FloatArray, IntArray, IntArray]] = []
    start = 0
    for form, rows in solids.groups():
        if form.shading_ratios:
            parts.append(_smooth_triangles(solids, rows, start))
            start += 3 * len(rows)
    for form, ratios, members in solids.members():
        for sides in np.unique(segments[members]):
            rows = members[segments[members] == sides]
            mesh = form.mesh(max(3, int(sides)), ratios)
            placed = posed(mesh, solids.matrices[rows])
            parts.append((placed.vertices, placed.shading, placed.faces + start, np.repeat(rows, len(mesh.faces))))
            start += len(placed.vertices)
    vertices, normals, faces, owner = (np.concatenate(column) for column in zip(*parts, strict=True))
    return vertices, normals, faces, owner
