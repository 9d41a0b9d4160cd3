"""Final pictures: path tracing with Mitsuba 3, denoised with Open Image Denoise where it is installed.

Every solid becomes part of a few merged meshes whose faces carry their colours, which loads linearly in the number of
primitives and is right under any affine pose. Round solids are as fine as their size in the picture asks for. Camera,
light, ground and film are those of draft pictures (``studio``), so that both agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.draft import Draft
from scenelang.backends.meshes import posed, unit_mesh
from scenelang.backends.solids import Form, Solids
from scenelang.backends.stage import Stage
from scenelang.backends.studio import AMBIENT, BACKDROP, BRIGHTEST, GROUND_EDGE, KEY, KEY_RADIUS, tone

Float32Array = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]

DEPTH = 8
_LAMP = 1e6  # the distance of the key light, so far that it lights all of the ground alike
_SEGMENTS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192)
_DEVIATION = 0.15  # pixels that a polygon may lie inside the circle that it stands for
_MOST_FACES = 24_000_000
_GLOW_STEPS = 16  # distinct strengths per channel that glowing colours are rounded to, per unit


def draw(
    stage: Stage, draft: Draft, samples: int = 64, seed: int = 0, progress: Callable[[float], None] | None = None
) -> Float32Array:
    """Path trace ``stage``: (H, W, 3) after the film's tone curve, linear sRGB in [0, 1].

    ``draft`` is the unshaded draft of the same stage, which guides the denoiser and tells the backdrop. Raises
    SceneError("backend") when Mitsuba is not installed.
    """
    mi = need("mitsuba", "mitsuba mitsuba-oidn")
    report = progress or (lambda _: None)
    if mi.variant() is None or not str(mi.variant()).startswith("scalar"):
        mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    scene = mi.load_dict(_scene(mi, stage))
    report(0.1)
    total = np.zeros((stage.height, stage.width, 3), np.float64)
    passes = max(1, samples // (8 if samples <= 64 else 16))
    for k in range(passes):
        share = samples // passes + (k < samples % passes)
        image = mi.render(scene, seed=(seed * 4096 + k) % 2**32, spp=share)
        total += share * np.array(image, np.float64).reshape(stage.height, stage.width, -1)[:, :, :3]
        report(0.1 + 0.85 * (k + 1) / passes)
    radiance = np.nan_to_num(total / samples, nan=0.0, posinf=1e4, neginf=0.0)
    # the light that surrounds the scene is dimmer than the backdrop that the camera sees
    radiance += draft.sky[:, :, None] * (np.array(BACKDROP) - np.array(AMBIENT))
    noisy = np.maximum(radiance, 0.0).astype(np.float32)
    clean = np.where(draft.sky[:, :, None] < 1.0, _denoised(noisy, draft), noisy)
    report(1.0)
    return np.asarray(tone(clean), np.float32)


def _denoised(radiance: Float32Array, draft: Draft) -> Float32Array:
    """``radiance`` without noise, or as it is where the denoiser is not installed."""
    try:
        oidn = import_module("mitsuba_oidn")
    except ImportError:
        return radiance
    guides = {"albedo": np.ascontiguousarray(draft.albedo), "normal": np.ascontiguousarray(draft.normal)}
    clean = oidn.denoise(np.ascontiguousarray(radiance), hdr=True, clean_aux=True, **guides)
    return np.maximum(np.asarray(clean, np.float32), 0.0)


# --- the scene -------------------------------------------------------------------------------------------------


def _scene(mi: Any, stage: Stage) -> dict[str, Any]:
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": DEPTH},
        "sensor": _sensor(mi, stage),
        "around": {"type": "constant", "radiance": _rgb(AMBIENT)},
        "key": _key_light(mi, stage),
    }
    if stage.ground is not None:
        raised = mi.ScalarTransform4f().translate([0.0, stage.ground, 0.0])
        scene["ground"] = {
            "type": "disk",
            "to_world": raised.rotate([1, 0, 0], -90.0).scale(GROUND_EDGE),
            "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": _rgb(stage.studio.ground)}},
        }
    for k, mesh in enumerate(_meshes(mi, stage)):
        scene[f"mesh{k}"] = mesh
    return scene


def _rgb(color: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(channel) for channel in color]}


def _sensor(mi: Any, stage: Stage) -> dict[str, Any]:
    view = stage.view
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = -view.right, view.up, view.forward, view.eye
    return {
        "type": "perspective",
        "to_world": mi.ScalarTransform4f(matrix),
        "fov": 2.0 * math.degrees(math.atan(view.tangent)),
        "fov_axis": "y",
        "near_clip": 1e-4,
        "far_clip": 1e5,
        "film": {
            "type": "hdrfilm",
            "width": stage.width,
            "height": stage.height,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},  # the denoiser wants pixels whose noise is independent
        },
        "sampler": {"type": "multijitter"},
    }


def _key_light(mi: Any, stage: Stage) -> dict[str, Any]:
    """A round lamp so far away that its light is nearly parallel, seen under twice ``KEY_RADIUS``."""
    direction = stage.studio.key_direction
    radius = _LAMP * math.tan(KEY_RADIUS)
    # a white surface facing the lamp has the radiance KEY = irradiance / pi = radiance (radius / distance)^2
    radiance = np.array(KEY) / math.sin(KEY_RADIUS) ** 2
    frame = mi.ScalarTransform4f().look_at(
        origin=[float(x) for x in direction * _LAMP], target=[0.0, 0.0, 0.0], up=[0.0, 1.0, 0.0]
    )
    return {
        "type": "disk",
        "to_world": frame.scale(radius),
        "emitter": {"type": "area", "radiance": _rgb(radiance)},
        "bsdf": {"type": "diffuse", "reflectance": _rgb((0.0, 0.0, 0.0))},
    }


def _meshes(mi: Any, stage: Stage) -> Iterator[Any]:
    """Merged meshes: by glow, since an emitter has one radiance, by whether anything is see-through, and by kind."""
    solids = stage.solids
    segments = _segments(stage)
    flat = np.isin(solids.forms, (Form.BLOCK, Form.TRIANGLE))
    clear = solids.opacity < 1.0
    glow = np.rint(solids.emission * _GLOW_STEPS) / _GLOW_STEPS
    kinds, kind = np.unique(glow, axis=0, return_inverse=True)
    for k, radiance in enumerate(kinds):
        for is_flat in (True, False):
            for is_clear in (True, False):
                rows = np.flatnonzero((kind.reshape(-1) == k) & (flat == is_flat) & (clear == is_clear))
                if len(rows):
                    yield _mesh(mi, solids.take(rows), segments[rows], is_flat, is_clear, radiance)


def _segments(stage: Stage) -> npt.NDArray[np.int64]:
    """Sides (N,) of round solids, by their size in the picture; fewer where the meshes would not fit the memory."""
    matrices = stage.solids.matrices
    size = np.sqrt(np.einsum("nij,nij->nj", matrices[:, :, :3], matrices[:, :, :3])).max(axis=1)
    depth = (matrices[:, :, 3] - stage.view.eye) @ stage.view.forward
    focal = stage.height / (2.0 * stage.view.tangent)
    pixels = size * focal / np.maximum(depth - size, 0.02)
    wanted = math.pi * np.sqrt(pixels / (2.0 * _DEVIATION))
    choices = np.array(_SEGMENTS)
    for coarser in range(len(choices)):
        sides = choices[np.clip(np.searchsorted(choices, wanted) - coarser, 0, len(choices) - 1)]
        faces = np.where(stage.solids.forms == Form.BALL, sides * sides, 4 * sides)
        if faces.sum() <= _MOST_FACES:
            break
    return np.asarray(np.where(np.isin(stage.solids.forms, (Form.BLOCK, Form.TRIANGLE)), 0, sides), np.int64)


def _mesh(
    mi: Any, solids: Solids, segments: npt.NDArray[np.int64], is_flat: bool, is_clear: bool, glow: FloatArray
) -> Any:
    """The merged mesh of ``solids`` with their colours, and their opacity where ``is_clear``, as face attributes."""
    vertices, normals, faces, owner = _merged(solids, segments)
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(_surface(is_clear))
    props["face_normals"] = is_flat
    if glow.any():
        props["emitter"] = mi.load_dict({"type": "area", "radiance": _rgb(glow)})
    mesh = mi.Mesh("solids", len(vertices), len(faces), has_vertex_normals=not is_flat, props=props)
    mesh.add_attribute("face_color", 3, (solids.colors[owner] * BRIGHTEST).astype(np.float32).ravel())
    if is_clear:
        mesh.add_attribute("face_opacity", 1, solids.opacity[owner].astype(np.float32))
    params = mi.traverse(mesh)
    params["vertex_positions"] = vertices.astype(np.float32).ravel()
    params["faces"] = faces.astype(np.uint32).ravel()
    if not is_flat:
        params["vertex_normals"] = normals.astype(np.float32).ravel()
    params.update()
    return mesh


def _surface(is_clear: bool) -> dict[str, Any]:
    diffuse = {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "face_color"}}
    both = {"type": "twosided", "bsdf": diffuse}
    if not is_clear:
        return both
    return {"type": "mask", "opacity": {"type": "mesh_attribute", "name": "face_opacity"}, "bsdf": both}


def _merged(
    solids: Solids, segments: npt.NDArray[np.int64]
) -> tuple[FloatArray, FloatArray, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Vertices, normals, faces of all solids, and the number of the solid that each face belongs to."""
    parts: list[tuple[FloatArray, FloatArray, npt.NDArray[np.int64], npt.NDArray[np.int64]]] = []
    start = 0
    for form in Form:
        for sides in np.unique(segments[solids.forms == form]):
            rows = np.flatnonzero((solids.forms == form) & (segments == sides))
            mesh = unit_mesh(form, max(3, int(sides)))
            vertices, normals, faces = posed(mesh, solids.matrices[rows])
            parts.append((vertices, normals, faces + start, np.repeat(rows, len(mesh.faces))))
            start += len(vertices)
    vertices, normals, faces, owner = (np.concatenate(column) for column in zip(*parts, strict=True))
    return vertices, normals, faces, owner
