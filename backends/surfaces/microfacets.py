"""Albedos of rough surfaces, by which all renderers conserve energy.

The microfacet model of renderers (GGX) follows light to its first bounce between the facets of a surface; the light of
further bounces is missing, up to two thirds for a white metal of roughness 1. The tables say how much: they were
measured with Mitsuba 3.9, as the radiance of unit spheres in a white furnace, averaged over the disk that a parallel
camera sees. ``roughness`` is the square root of the model's alpha.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.floating]

_ROUGHNESS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
# Reflectance of facets that reflect all light.
ALBEDO = (1.0, 0.9999, 0.9960, 0.9801, 0.9435, 0.8823, 0.7979, 0.6956, 0.5841, 0.4732, 0.3714)
# The part of it that Fresnel's law adds at grazing angles to the reflectance F0 at normal incidence: facets of index of
# refraction n reflect ``(albedo - grazing) F0 + grazing``, fitted to n = 1.5 and 2.4 (Karis, 2013).
GRAZING = (0.0404, 0.0402, 0.0390, 0.0352, 0.0283, 0.0220, 0.0161, 0.0120, 0.0087, 0.0067, 0.0055)

# The sheen of fabric is that of Mitsuba's ``principled``, which with a sheen of 1 reflects a hundredth of the light,
# nearly all at grazing angles: with a hundred, all. It takes this share of the light from the surface below.
SHEEN_STRENGTH, SHEEN_ALBEDO = 100.0, 0.12


def albedo(roughness: Floats | float) -> Floats:
    """Return the share of light, of the shape of ``roughness``, that perfectly reflecting facets reflect at once."""
    return np.asarray(np.interp(roughness, _ROUGHNESS, ALBEDO), np.float64)


def dielectric_albedo(roughness: Floats | float, ior: Floats | float) -> Floats:
    """Return the share of light that the facets of a dielectric of index of refraction ``ior`` reflect.

    Examples
    --------
    >>> round(float(dielectric_albedo(0.0, 1.5)), 3)
    0.079
    """
    normal = normal_reflectance(ior)
    grazing = np.interp(roughness, _ROUGHNESS, GRAZING)
    return np.asarray((albedo(roughness) - grazing) * normal + grazing * (normal > 0.0), np.float64)


def normal_reflectance(ior: Floats | float) -> Floats:
    """Return the reflectance of a dielectric at normal incidence."""
    return np.asarray(((np.asarray(ior) - 1.0) / (np.asarray(ior) + 1.0)) ** 2, np.float64)


def later_bounces(color: Floats, roughness: Floats | float) -> Floats:
    """Return the light that leaves facets of a metal after further bounces, as a share of that after the first one.

    A geometric series: at each bounce the facets absorb, and ``albedo`` of what they reflect leaves (Kulla and Conty,
    2017). ``color`` and the result are (N, 3); ``roughness`` is one number, or (N, 1).
    """
    missed = 1.0 - albedo(roughness)
    return np.asarray(color * missed / (1.0 - color * missed), np.float64)
