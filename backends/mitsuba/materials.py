"""Materials of final pictures: looks as Mitsuba's BSDFs, for one look or for the faces of a merged mesh."""

from __future__ import annotations

from typing import Any

from scenelang.backends.appearance import GLASS, Look
from scenelang.backends.studio import BRIGHTEST

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
