"""Everything of Mitsuba's scene but the shapes: camera, film, light and ground of a stage."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.solids import Solids, composed, normalized, own_mesh, solids_of, thinness
from scenelang.backends.pictures.appearance import GLASS, Look, look_of
from scenelang.backends.pictures.camera import Camera
from scenelang.backends.pictures.stage import Stage, Staging
from scenelang.backends.pictures.studio import BRIGHTEST, CHECKER, CHECKER_EDGE, GROUND_EDGE, Studio
from scenelang.interpreter.scene.entity import Entity, descendants, instance_counts
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives.forms import CanonicalForm
from scenelang.interpreter.scene.primitives.mesh import posed

# What is drawn once and placed many times: a cut through the entity DAG, and the solids that stand alone.
#
# Mitsuba has one level of instancing and no lamps inside instances. So each way from the root to a primitive is cut
# once: below the cut lie prototypes, shared entities whose solids become one group of shapes, above it their
# instances.


FloatArray = npt.NDArray[np.float64]

FEW = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Prototype:
    """``solids`` of one shared entity, in its own frame brought to a good size, and where it stands: ``matrices``
    (N, 3, 4) into the stage's frame. ``entity`` is what it was made of."""

    entity: Entity
    solids: Solids
    matrices: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """A frame as prototypes, and the ``loose`` solids in the stage's frame that are no part of one."""

    prototypes: tuple[Prototype, ...]
    loose: Solids


@dataclass(frozen=True, slots=True, eq=False)
class _Counts:
    """Of every distinct entity by ``id``: solids below it, instances of it, whether it may be a prototype."""

    order: tuple[Entity, ...]  # children before parents
    solids: dict[int, int]
    instances: dict[int, int]
    allowed: dict[int, bool]


def parts_of(staging: Staging, frame: int) -> Parts | None:
    """Frame number ``frame`` of a staging as prototypes and loose solids, None where hardly anything is shared."""
    root = staging.roots[frame]
    cut = _best_cut(root, _counted(root))
    if not cut:
        return None
    flat = flatten_entity(root, cut)
    is_cut = np.array([id(entity) in cut for entity in flat.primitives], bool)
    prototypes = []
    index = np.asarray(flat.index)
    for number in np.flatnonzero(is_cut):
        found = _prototype(staging, flat.primitives[number], flat.matrices[index == number])
        if found is not None:
            prototypes.append(found)
    loose = flat.only(~is_cut[index])
    return Parts(tuple(prototypes), normalized(solids_of(loose), staging.center, staging.scale))


def _prototype(staging: Staging, entity: Entity, matrices: FloatArray) -> Prototype | None:
    """The prototype that ``entity`` is under world ``matrices`` (N, 3, 4), None where nothing of it can be drawn."""
    solids = solids_of(flatten_entity(entity))
    if not len(solids):
        return None
    reach = np.abs(solids.matrices[:, :, :3]).sum(axis=2)
    low, high = (solids.matrices[:, :, 3] - reach).min(axis=0), (solids.matrices[:, :, 3] + reach).max(axis=0)
    middle, half = (low + high) / 2.0, 0.5 * float(np.linalg.norm(high - low))
    size = half if half > 1e-300 else 1.0
    own = normalized(solids, middle, 1.0 / size)
    outward = np.concatenate([np.eye(3) * size, middle[:, None]], axis=1)
    to_stage = np.concatenate([np.eye(3) * staging.scale, (-staging.center * staging.scale)[:, None]], axis=1)
    placed = composed(composed(to_stage[None], matrices), outward[None])
    sound = np.isfinite(placed).all(axis=(1, 2)) & (np.abs(np.linalg.det(placed[:, :, :3])) > 1e-30)
    return Prototype(entity, own, placed[sound]) if len(own) and sound.any() else None


def _counted(root: Entity) -> _Counts:
    order = tuple(descendants(root))
    solids: dict[int, int] = {}
    allowed: dict[int, bool] = {}
    for entity in order:
        below = [id(part.car) for part in entity.children]
        solids[id(entity)] = _solids_in(entity) + sum(solids[child] for child in below)
        own = not (entity.is_primitive and any(look_of(entity).emission))  # lamps cannot be instanced
        allowed[id(entity)] = own and all(allowed[child] for child in below)
    return _Counts(order, solids, instance_counts(order), allowed)


def _solids_in(entity: Entity) -> int:
    """How many solids a primitive is: one, but as many as it has triangles where it is a mesh."""
    mesh = None if entity.shape is None else own_mesh(entity.shape)
    return int(entity.is_primitive) if mesh is None else len(mesh.faces)


def _best_cut(root: Entity, counts: _Counts) -> frozenset[int]:
    """The ids of the prototypes: entities of at most so many solids that few shapes are stored in all."""
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
    return values[:: max(1, len(values) // 32)]


def _cut_below(root: Entity, counts: _Counts, size: int) -> tuple[frozenset[int], int]:
    """The cut at entities of at most ``size`` solids, and how many shapes it stores: solids and instances."""
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


# Materials of final pictures: looks as Mitsuba's BSDFs, for one look or for the faces of a merged mesh.


FACE_COLOR, FACE_OPACITY, FACE_GLOSS, FACE_METAL = "face_color", "face_opacity", "face_gloss", "face_metal"
_LEAST_IOR = 1.001  # an index of 1 refracts nothing, which Mitsuba refuses


def rgb(color: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(channel) for channel in color]}


def is_glass(look: Look) -> bool:
    """Whether light that passes the surface is refracted."""
    return look.ior is not None and look.opacity < 1.0


def surface(look: Look) -> dict[str, Any]:
    """The BSDF of one look."""
    color = rgb([BRIGHTEST * channel for channel in look.color])
    if look.is_matte:
        return _covering(_both_sides({"type": "diffuse", "reflectance": color}), look.opacity)
    glossy = {
        "type": "principled",
        "base_color": color,
        "roughness": max(look.gloss, 0.03),
        "metallic": look.metallic,
        "eta": max(look.ior or GLASS, _LEAST_IOR),
    }
    if is_glass(look):
        return glossy | {"spec_trans": 1.0 - look.opacity}
    return _covering(_both_sides(glossy), look.opacity)


def face_surface(matte: bool, clear: bool) -> dict[str, Any]:
    """The BSDF of a merged mesh whose faces carry the values of their own looks, but for glass."""
    color = _of_face(FACE_COLOR)
    if matte:
        base: dict[str, Any] = {"type": "diffuse", "reflectance": color}
    else:
        base = {
            "type": "principled",
            "base_color": color,
            "roughness": _of_face(FACE_GLOSS),
            "metallic": _of_face(FACE_METAL),
            "eta": GLASS,
        }
    both = _both_sides(base)
    return {"type": "mask", "opacity": _of_face(FACE_OPACITY), "bsdf": both} if clear else both


def _of_face(name: str) -> dict[str, Any]:
    return {"type": "mesh_attribute", "name": name}


def _both_sides(bsdf: dict[str, Any]) -> dict[str, Any]:
    return {"type": "twosided", "bsdf": bsdf}


def _covering(bsdf: dict[str, Any], opacity: float) -> dict[str, Any]:
    return {"type": "mask", "opacity": float(opacity), "bsdf": bsdf} if opacity < 1.0 else bsdf


_LAMP = 1e6  # the distance of the key light, so far that it lights all of the ground alike
_UNDER = 1e-4  # how far the plain ground lies under the checkerboard


def surroundings(mi: Any, stage: Stage, depth: int) -> dict[str, Any]:
    """The scene without its solids, in the form that Mitsuba loads."""
    environment = stage.studio.environment
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": depth},
        "sensor": sensor(mi, stage.camera),
        "around": {"type": "constant", "radiance": rgb(environment.ambient)},
    }
    if any(environment.key):
        scene["key"] = _key_light(mi, stage.studio)
    if stage.ground is not None and stage.studio.ground is not None:
        scene |= _ground(mi, stage.ground, stage.studio.ground)
    return scene


def sensor(mi: Any, camera: Camera) -> dict[str, Any]:
    """The camera, with a lens where it has an aperture."""
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = -camera.right, camera.up, camera.forward, camera.eye
    (focal, _), (cx, cy) = camera.focal, camera.principal
    found: dict[str, Any] = {
        "type": "perspective",
        "near_clip": 1e-4,
        "far_clip": 1e5,
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},  # the denoiser wants pixels whose noise is independent
        },
        "sampler": {"type": "multijitter"},
    }
    if camera.is_parallel:
        half = camera.width / (2.0 * focal)
        matrix[:3, 3] += (camera.width / 2.0 - cx) / focal * camera.right - (
            camera.height / 2.0 - cy
        ) / focal * camera.up
        to_world = mi.ScalarTransform4f(matrix).scale([half, half, 1.0])
        return found | {"type": "orthographic", "to_world": to_world}
    found |= {
        "to_world": mi.ScalarTransform4f(matrix),
        "fov": 2.0 * math.degrees(math.atan(camera.width / (2.0 * focal))),
        "fov_axis": "x",
        "principal_point_offset_x": cx / camera.width - 0.5,
        "principal_point_offset_y": cy / camera.height - 0.5,
    }
    if camera.aperture > 0.0:
        found |= {"type": "thinlens", "aperture_radius": camera.aperture, "focus_distance": camera.focus}
        del found["principal_point_offset_x"], found["principal_point_offset_y"]
    return found


def _key_light(mi: Any, studio: Studio) -> dict[str, Any]:
    """A round lamp so far away that its light is nearly parallel, seen under twice the environment's radius."""
    angle = math.radians(studio.environment.radius)
    # a white surface facing the lamp has the radiance KEY = irradiance / pi = radiance (radius / distance)^2
    radiance = np.array(studio.environment.key) / math.sin(angle) ** 2
    frame = mi.ScalarTransform4f().look_at(
        origin=[float(x) for x in studio.key_direction * _LAMP], target=[0.0, 0.0, 0.0], up=[0.0, 1.0, 0.0]
    )
    return {
        "type": "disk",
        "to_world": frame.scale(_LAMP * math.tan(angle)),
        "emitter": {"type": "area", "radiance": rgb(radiance)},
        "bsdf": {"type": "diffuse", "reflectance": rgb((0.0, 0.0, 0.0))},
    }


def _ground(mi: Any, height: float, colors: Any) -> dict[str, Any]:
    """A large disk, under a checkerboard where the ground has two colours."""
    is_plain = bool((colors[0] == colors[1]).all())

    def lying(at: float) -> Any:
        return mi.ScalarTransform4f().translate([0.0, at, 0.0]).rotate([1, 0, 0], -90.0)

    disk = lying(height if is_plain else height - _UNDER).scale(GROUND_EDGE)
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
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}


# Solids as Mitsuba's shapes: exact unit shapes to be placed many times, and merged meshes whose faces carry colours.
#
# What exact shapes a form is made of, the form says (``Form.mitsuba``); Mitsuba's spheres are none under uneven scales,
# so units are placed as instances, which is right under any invertible affine pose. Merged meshes load linearly.


IntArray = npt.NDArray[np.int64]

SEGMENTS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192)
UNIT_SEGMENTS = 256  # of a unit that is a mesh
_DEVIATION = 0.15  # pixels that a polygon may lie inside the circle that it stands for
_MOST_FACES = 24_000_000
_GLOW_STEPS = 16  # distinct strengths per channel that glowing colours are rounded to, per unit


def unit_parts(form: CanonicalForm, ratios: tuple[float, ...], look: Look) -> list[dict[str, Any]]:
    """The exact shapes of a canonical form without their material, poses as (4, 4); none where it is a mesh of
    ``UNIT_SEGMENTS`` sides: where Mitsuba has no such shapes, or light would pass those that lie inside one another."""
    parts = form.mitsuba(ratios)
    return [] if form.overlaps and look.opacity < 1.0 else parts


def unit_group(mi: Any, form: CanonicalForm, ratios: tuple[float, ...], look: Look) -> Any:
    """A shape group of the canonical form."""
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
    props = mi.Properties()
    props["bsdf"] = bsdf
    props["face_normals"] = normals is None
    mesh = mi.Mesh("solids", len(vertices), len(faces), has_vertex_normals=normals is not None, props=props)
    _fill(mi, mesh, vertices, normals, faces)
    return mesh


def _fill(mi: Any, mesh: Any, vertices: FloatArray, normals: FloatArray | None, faces: IntArray) -> None:
    params = mi.traverse(mesh)
    params["vertex_positions"] = vertices.astype(np.float32).ravel()
    params["faces"] = faces.astype(np.uint32).ravel()
    if normals is not None:
        params["vertex_normals"] = normals.astype(np.float32).ravel()
    params.update()


# --- merged meshes ---------------------------------------------------------------------------------------------


def merged_meshes(mi: Any, solids: Solids, segments: IntArray) -> Iterator[Any]:
    """Few meshes of all ``solids``: by glow, since an emitter has one radiance, by kind of material, by whether faces
    are flat. ``segments`` (N,) are the sides of round solids."""
    flat = ~solids.that_are("is_curved")
    glow = np.rint(solids.emission * _GLOW_STEPS) / _GLOW_STEPS
    matte, clear = solids.looks.matte[solids.look], solids.opacity < 1.0
    glass = np.array([is_glass(look) for look in solids.looks.rows], bool)[solids.look]
    own = np.where(glass, solids.look, -1)  # refracting materials cannot differ within a mesh
    keys = np.column_stack([glow, own, flat, matte, clear])
    kinds, kind = np.unique(keys, axis=0, return_inverse=True)
    for k, key in enumerate(kinds):
        rows = np.flatnonzero(kind.reshape(-1) == k)
        part = solids.take(rows)
        bsdf = surface(solids.looks.rows[int(key[3])]) if key[3] >= 0 else face_surface(bool(key[5]), bool(key[6]))
        yield _merged_mesh(mi, part, segments[rows], bool(key[4]), bsdf, key[:3])


def _merged_mesh(
    mi: Any, solids: Solids, segments: IntArray, is_flat: bool, bsdf: dict[str, Any], glow: FloatArray
) -> Any:
    vertices, normals, faces, owner = _merged(solids, segments)
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    props["face_normals"] = is_flat
    if glow.any():
        props["emitter"] = mi.load_dict({"type": "area", "radiance": rgb(glow)})
    mesh = mi.Mesh("solids", len(vertices), len(faces), has_vertex_normals=not is_flat, props=props)
    look = solids.look[owner]
    mesh.add_attribute(FACE_COLOR, 3, (solids.looks.color[look] * BRIGHTEST).astype(np.float32).ravel())
    for name, values in (
        (FACE_OPACITY, solids.looks.opacity),
        (FACE_GLOSS, np.maximum(solids.looks.gloss, 0.03)),
        (FACE_METAL, solids.looks.metallic),
    ):
        mesh.add_attribute(name, 1, values[look].astype(np.float32))
    _fill(mi, mesh, vertices, None if is_flat else normals, faces)
    return mesh


def segments_for(solids: Solids, pixels: FloatArray) -> IntArray:
    """Sides (N,) of round solids that are ``pixels`` (N,) large in the picture; fewer where the meshes would not fit
    the memory, 0 for flat ones."""
    wanted = math.pi * np.sqrt(pixels / (2.0 * _DEVIATION))
    choices = np.array(SEGMENTS)
    for coarser in range(len(choices)):
        sides = choices[np.clip(np.searchsorted(choices, wanted) - coarser, 0, len(choices) - 1)]
        faces = sum(
            int(form.face_count(sides[rows], solids.ratios_of(form, rows)).sum()) for form, rows in solids.groups()
        )
        if faces <= _MOST_FACES:
            break
    return np.asarray(np.where(solids.that_are("is_curved"), sides, 0), np.int64)


def is_too_flat(solids: Solids) -> npt.NDArray[np.bool_]:
    """Which solids (N,) are so flat that the exact shapes of their forms, in single precision, dissolve."""
    flattest = np.array([kind.flattest for kind in solids.kinds])[solids.forms]
    return np.asarray(thinness(solids.matrices) < flattest * sizes_of(solids.matrices), bool)


def dissolves(form: CanonicalForm, matrix: FloatArray) -> bool:
    """Whether under the pose (3, 4) the exact shapes of a form are so flat that they dissolve."""
    return bool(thinness(matrix[None])[0] < form.flattest * sizes_of(matrix[None])[0])


def sizes_of(matrices: FloatArray) -> FloatArray:
    """The longest half axis (N,) of solids under ``matrices`` (N, 3, 4)."""
    return np.asarray(np.sqrt(np.einsum("nij,nij->nj", matrices[:, :, :3], matrices[:, :, :3])).max(axis=1), np.float64)


def _merged(solids: Solids, segments: IntArray) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Vertices, normals, faces of all solids, and the number of the solid that each face belongs to."""
    parts: list[tuple[FloatArray, FloatArray, IntArray, IntArray]] = []
    start = 0
    for form, ratios, members in solids.members():
        for sides in np.unique(segments[members]):
            rows = members[segments[members] == sides]
            mesh = form.mesh(max(3, int(sides)), ratios)
            placed = posed(mesh, solids.matrices[rows])
            parts.append((placed.vertices, placed.shading, placed.faces + start, np.repeat(rows, len(mesh.faces))))
            start += len(placed.vertices)
    vertices, normals, faces, owner = (np.concatenate(column) for column in zip(*parts, strict=True))
    return vertices, normals, faces, owner
