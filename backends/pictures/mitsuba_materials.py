"""Materials of final images: looks as Mitsuba's own BSDFs, so that exported scenes carry them.

Mitsuba's rough BSDFs lose the light that bounces more than once between facets, and ``principled`` gains up to 7 % on
white dielectrics. Blends of two stock BSDFs conserve it: in a white furnace a white sphere of any material and
roughness returns .97 to 1.03, and glass .9 to 1.1 (``tests/backends/test_furnace.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces import microfacets
from scenelang.backends.surfaces.appearance import GLASS, Look
from scenelang.backends.surfaces.tiles import relief_of, tile_of
from scenelang.interpreter.scene.primitives.textures import Texture

_MIN_ROUGHNESS = 0.03  # below, highlights of the key light are noise that few samples do not average
_MIN_IOR = 1.001  # Mitsuba rejects an index of 1, which does not refract
_COAT_ROUGHNESS = 0.05

# Share of the light of a metal's facets that its microfacet lobe carries; a diffuse lobe carries the rest. At these
# roughnesses the sum would otherwise be above or below 1 by more than .03 where the surface faces the camera.
_ROUGHNESS = (0.0, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
_LOBE = (1.0, 1.0, 0.85, 0.6, 0.75, 1.0, 0.65, 0.42, 0.36)

# How many times too dark the diffuse light of ``roughplastic`` is, by index of refraction (rows) and roughness.
_PLASTIC_IOR = (1.0, 1.15, 1.3, 1.5, 1.8, 2.4, 4.0)
_PLASTIC_ROUGHNESS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
_PLASTIC_LOSS = np.array([
    [0.994, 0.994, 0.998, 1.010, 1.034, 1.075, 1.135],
    [1.022, 1.024, 1.034, 1.064, 1.122, 1.209, 1.320],
    [1.011, 1.013, 1.026, 1.070, 1.156, 1.288, 1.463],
    [1.021, 1.023, 1.040, 1.098, 1.214, 1.399, 1.654],
    [1.038, 1.040, 1.065, 1.147, 1.314, 1.589, 1.979],
    [1.062, 1.074, 1.126, 1.276, 1.580, 2.094, 2.853],
    [1.188, 1.232, 1.386, 1.870, 2.860, 4.614, 7.359],
])  # fmt: skip
_MAX_PLASTIC_LOSS = 1.3  # beyond, a diffuse lobe beside the facets is nearer to an even sphere

# By how much the two lobes of ``roughdielectric`` must grow, by index of refraction (rows) and roughness.
_GLASS_IOR = (1.1, 1.33, 1.5, 1.8, 2.4)
_GLASS_ROUGHNESS = (0.05, 0.2, 0.4, 0.6, 0.8, 1.0)
_GLASS_LOSS = np.array([
    [1.000, 1.006, 1.029, 1.066, 1.149, 1.315],
    [1.000, 1.006, 1.041, 1.130, 1.270, 1.530],
    [1.000, 1.006, 1.053, 1.158, 1.364, 1.727],
    [1.000, 1.006, 1.053, 1.181, 1.465, 1.944],
    [1.000, 1.006, 1.064, 1.215, 1.545, 2.174],
])  # fmt: skip

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
Lobe = Callable[[FloatArray], FloatArray]  # from colors (K, 3) of surfaces to those (K, 3) of one lobe of their BSDF
Paint = Callable[[Lobe], dict[str, Any]]  # returns the texture of a lobe


def rgb(color: Any) -> dict[str, Any]:
    """Return a color for Mitsuba, linear sRGB."""
    return {"type": "rgb", "value": [float(channel) for channel in color]}


def bitmap_paint(texture: Texture, source: Callable[[Float32Array], dict[str, Any]]) -> Paint:
    """Return the paint of a surface with a texture: the lobes of a BSDF are images.

    ``source`` takes an image (H, W, 3), linear sRGB, and returns the entry of a bitmap that holds or names it.
    """
    image = tile_of(texture).image[::-1]  # row 0 of Mitsuba is at v = 0
    reflectance = image.reshape(-1, 3).astype(np.float64)

    def paint(lobe: Lobe) -> dict[str, Any]:
        """Return the image of a lobe."""
        values = np.ascontiguousarray(lobe(reflectance).reshape(image.shape), np.float32)
        return _bitmap(texture, source(values))

    return paint


def _bitmap(texture: Texture, image: dict[str, Any]) -> dict[str, Any]:
    """Return the plug-in of an image that repeats as the texture does."""
    return {"type": "bitmap", **image, "raw": True, "wrap_mode": "clamp" if texture.side else "repeat"}


def relief(texture: Texture, depth: float, source: Callable[[Float32Array], dict[str, Any]]) -> dict[str, Any]:
    """Return the plug-in ``bumpmap``, without its BSDF, of a texture whose relief is ``depth`` deep in the frame of
    the scene; empty without a relief. ``source`` is that of ``bitmap_paint``."""
    if not depth:
        return {}
    heights = np.ascontiguousarray(relief_of(texture).image[::-1].mean(axis=2, keepdims=True), np.float32)
    return {"type": "bumpmap", "scale": float(depth), "heights": _bitmap(texture, source(heights))}


def is_glass(look: Look) -> bool:
    """Return whether light transmitted by the surface is refracted."""
    return look.ior is not None and look.opacity < 1.0


def kind_of(look: Look) -> Look:
    """Return the look with white for its color: what surfaces share that one BSDF with a texture can describe.

    Opacity and emission vary, too, but that of glass does not.
    """
    return replace(
        look,
        color=(1.0, 1.0, 1.0),
        emission=(0.0, 0.0, 0.0),
        opacity=look.opacity if is_glass(look) else 1.0,
        material=None,
    )


def surface(
    look: Look,
    paint: Paint | None = None,
    opacity: dict[str, Any] | None = None,
    bump: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """Return the BSDF of a look.

    Parameters
    ----------
    paint
        Returns the texture of a lobe, for meshes of several colors; by default the lobe has the color of the look.
    opacity
        A texture that replaces the opacity of the look.
    bump
        Result of ``relief``.
    """
    paint = paint or uniform(look.color)
    opaque = _opaque(look, paint)
    if is_glass(look):
        glass = _blend(1.0 - look.opacity, opaque, _glass(look, paint))
        return bump | {"bsdf": glass} if bump else glass
    opaque = bump | {"bsdf": opaque} if bump else opaque
    both = {"type": "twosided", "bsdf": opaque}
    if opacity is None and look.opacity == 1.0:
        return both
    return {"type": "mask", "opacity": float(look.opacity) if opacity is None else opacity, "bsdf": both}


def uniform(color: tuple[float, float, float]) -> Paint:
    """Return the paint of a surface that has one color."""
    reflectance = np.array([color])

    def paint(lobe: Lobe) -> dict[str, Any]:
        """Return the color of a lobe, which may be above 1."""
        shown = lobe(reflectance)[0]
        return rgb(shown) if shown.max() <= 1.0 else {"type": "srgb", "color": rgb(shown), "unbounded": True}

    return paint


def _opaque(look: Look, paint: Paint) -> dict[str, Any]:
    """Return the one-sided BSDF of the part of a surface through which no light passes."""
    if look.is_diffuse:
        base = {"type": "diffuse", "reflectance": paint(_unchanged)}
    else:
        metal = _metal(look.gloss, paint) if look.metallic > 0.0 else {}
        plastic = _plastic(look, paint) if look.metallic < 1.0 else {}
        base = _blend(look.metallic, plastic, metal)
    if look.sheen > 0.0:
        sheen = {"sheen": microfacets.SHEEN_STRENGTH}
        rim = {"type": "principled", "base_color": 0.0, "specular": 0.0, "roughness": 1.0, **sheen}
        base = _blend(microfacets.SHEEN_ALBEDO * look.sheen, base, rim)
    return base if look.coat == 0.0 else _blend(*_facets(look.coat, _COAT_ROUGHNESS, GLASS, base))


def _blend(share: float, base: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Return a BSDF that is ``other`` by a share, and ``base`` by the rest."""
    if share <= 0.0 or share >= 1.0:
        return base if share <= 0.0 else other
    return {"type": "blendbsdf", "weight": float(share), "base": base, "other": other}


def _metal(gloss: float, paint: Paint) -> dict[str, Any]:
    """Return the BSDF of a metal: facets, and a diffuse lobe for the light that they lose."""
    rough = max(gloss, _MIN_ROUGHNESS)
    lobe, kept = float(np.interp(rough, _ROUGHNESS, _LOBE)), float(microfacets.albedo(rough))
    share = 1.0 - lobe * kept
    facets = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": rough**2}
    if share < 1e-3:
        return facets | {"specular_reflectance": paint(_unchanged)}

    def diffuse(color: FloatArray) -> FloatArray:
        """Return the light of further bounces, and that which the facets' lobe leaves to the diffuse one."""
        return color * kept * (microfacets.later_bounces(color, rough) + 1.0 - lobe) / share

    facets["specular_reflectance"] = paint(lambda color: color * lobe / (1.0 - share))
    return _blend(share, facets, {"type": "diffuse", "reflectance": paint(diffuse)})


def _plastic(look: Look, paint: Paint) -> dict[str, Any]:
    """Return the BSDF of a colored body under facets of a dielectric."""
    rough, ior = max(look.gloss, _MIN_ROUGHNESS), float(max(look.ior or GLASS, _MIN_IOR))
    loss = _table(_PLASTIC_LOSS, _PLASTIC_IOR, _PLASTIC_ROUGHNESS, ior, rough)
    body = paint(_unchanged)
    is_even = rough <= _PLASTIC_ROUGHNESS[-1] and loss <= _MAX_PLASTIC_LOSS
    if is_even and body["type"] != "mesh_attribute":  # of which ``roughplastic`` cannot compute the mean
        return {
            "type": "roughplastic",
            "distribution": "ggx",
            "nonlinear": False,
            "alpha": rough**2,
            "int_ior": ior,
            "diffuse_reflectance": paint(lambda color: color * loss),
        }
    return _blend(*_facets(1.0, rough, ior, {"type": "diffuse", "reflectance": body}))


def _facets(
    strength: float, rough: float, ior: float, base: dict[str, Any]
) -> tuple[float, dict[str, Any], dict[str, Any]]:
    """Return the blend of ``base`` with the facets of a dielectric over it, which take from it what they reflect.

    The share of the facets is their albedo, so that samples are where the light is.
    """
    share = strength * float(microfacets.dielectric_albedo(rough, ior))
    facets = {
        "type": "roughplastic",
        "distribution": "ggx",
        "alpha": rough**2,
        "int_ior": ior,
        "diffuse_reflectance": 0.0,
        "specular_reflectance": strength / share if share > 0.0 else 0.0,
    }
    return share, base, facets


def _glass(look: Look, paint: Paint) -> dict[str, Any]:
    """Return the BSDF of the part of a surface through which light is refracted, colored by both its passages."""
    rough, ior = max(look.gloss, _MIN_ROUGHNESS), float(max(look.ior or GLASS, _MIN_IOR))
    gain = _table(_GLASS_LOSS, _GLASS_IOR, _GLASS_ROUGHNESS, ior, rough)
    return {
        "type": "roughdielectric",
        "distribution": "ggx",
        "alpha": rough**2,
        "int_ior": ior,
        "specular_reflectance": gain,
        "specular_transmittance": paint(lambda color: gain * np.sqrt(color)),
    }


def _table(values: FloatArray, iors: Sequence[float], roughnesses: Sequence[float], ior: float, rough: float) -> float:
    """Return the value of a table at an index of refraction and a roughness, between its entries by interpolation."""
    columns = [np.interp(ior, iors, column) for column in values.T]
    return float(np.interp(rough, roughnesses, columns))


def _unchanged(color: FloatArray) -> FloatArray:
    """Return the color of a lobe that has that of the surface."""
    return color
