"""Substances by name: how a surface of them looks, for ``:material``, and what they weigh, for ``:density``.

Colors are linear sRGB. Those of metals (the reflectance at normal incidence), glass, liquids, stone, paper, brick and
porcelain, and most indices of refraction, are from physicallybased.info (A. Palmqvist, CC0), version 2, read in 2026,
with components above 1 set to 1. A finish is a roughness: polished .05, drawn or cast .3 to .45, brushed .35. The
colors of woods, fabrics and paints are chosen, near the mean of photographs under daylight, because these vary with the
piece. Densities are in kg/m^3, rounded to the digits in which handbooks agree.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from scenelang.grammar.datum import dataclass

Color = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Substance:
    """Appearance and density of a substance; the fields are the values of the attributes of the same name.

    ``roughness`` None is matte; ``density`` None is not known.
    """

    color: Color
    roughness: float | None = None
    metallic: float = 0.0
    ior: float | None = None
    opacity: float = 1.0
    coat: float = 0.0
    sheen: float = 0.0
    density: float | None = None


def _metal(color: Color, roughness: float, density: float) -> Substance:
    return Substance(color, roughness, 1.0, density=density)


def _clear(color: Color, ior: float, density: float, roughness: float = 0.0) -> Substance:
    """Return a substance through which light passes: the twentieth that it hides makes its shape visible."""
    return Substance(color, roughness, ior=ior, opacity=0.05, density=density)


def _varnished(color: Color, density: float) -> Substance:
    """Return a wood under a satin varnish."""
    return Substance(color, 0.4, ior=1.5, density=density)


_ALUMINUM, _STEEL, _COPPER = (0.916, 0.923, 0.924), (0.669, 0.639, 0.598), (0.932, 0.623, 0.522)

SUBSTANCES: Mapping[str, Substance] = MappingProxyType({
    # metals
    "aluminum": _metal(_ALUMINUM, 0.3, 2700.0),
    "aluminium": _metal(_ALUMINUM, 0.3, 2700.0),
    "brushed aluminum": _metal(_ALUMINUM, 0.35, 2700.0),
    "brass": _metal((0.910, 0.778, 0.423), 0.2, 8500.0),
    "bronze": _metal((0.714, 0.428, 0.181), 0.35, 8800.0),
    "cast iron": _metal((0.325, 0.310, 0.297), 0.6, 7200.0),
    "chrome": _metal((0.654, 0.685, 0.701), 0.05, 7200.0),
    "copper": _metal(_COPPER, 0.25, 8960.0),
    "gold": _metal((1.0, 0.773, 0.307), 0.15, 19300.0),
    "iron": _metal((0.530, 0.513, 0.494), 0.45, 7870.0),
    "lead": _metal((0.626, 0.640, 0.693), 0.5, 11340.0),
    "metal": _metal(_STEEL, 0.3, 7850.0),
    "nickel": _metal((0.697, 0.641, 0.563), 0.2, 8900.0),
    "platinum": _metal((0.765, 0.730, 0.676), 0.15, 21450.0),
    "silver": _metal((0.991, 0.985, 0.974), 0.12, 10500.0),
    "steel": _metal(_STEEL, 0.3, 7850.0),
    "brushed steel": _metal(_STEEL, 0.35, 7850.0),
    "polished steel": _metal(_STEEL, 0.05, 7850.0),
    "stainless steel": _metal(_STEEL, 0.2, 8000.0),
    "titanium": _metal((0.441, 0.400, 0.361), 0.35, 4540.0),
    "zinc": _metal((0.808, 0.844, 0.865), 0.45, 7000.0),
    # transparent
    "amber": _clear((0.830, 0.288, 0.036), 1.54, 1080.0),
    "clear plastic": _clear((0.98, 0.98, 0.98), 1.49, 1180.0),
    "crystal": _clear((0.99, 0.99, 0.99), 1.6, 3100.0),
    "diamond": _clear((0.99, 0.99, 0.99), 2.417, 3500.0),
    "frosted glass": _clear((0.984, 0.995, 0.995), 1.52, 2500.0, 0.4),
    "glass": _clear((0.984, 0.995, 0.995), 1.52, 2500.0),
    "ice": _clear((0.973, 0.995, 1.0), 1.31, 917.0, 0.1),
    "water": _clear((0.969, 0.996, 0.997), 1.333, 1000.0),
    # stone, earth, ceramics
    "asphalt": Substance((0.043, 0.041, 0.040), 0.8, ior=1.6, density=2300.0),
    "brick": Substance((0.262, 0.095, 0.061), 0.9, ior=1.5, density=1900.0),
    "ceramic": Substance((0.745, 0.745, 0.723), 0.25, ior=1.5, density=2300.0),
    "chalk": Substance((0.83, 0.83, 0.81), density=2500.0),
    "clay": Substance((0.45, 0.29, 0.19), density=1800.0),
    "concrete": Substance((0.51, 0.51, 0.51), 0.8, ior=1.5, density=2400.0),
    "granite": Substance((0.32, 0.30, 0.29), 0.3, ior=1.55, density=2700.0),
    "marble": Substance((0.830, 0.791, 0.753), 0.15, ior=1.5, density=2700.0),
    "plaster": Substance((0.80, 0.79, 0.77), density=850.0),
    "porcelain": Substance((0.745, 0.745, 0.723), 0.08, ior=1.5, coat=1.0, density=2400.0),
    "sand": Substance((0.440, 0.386, 0.231), density=1500.0),
    "sandstone": Substance((0.50, 0.37, 0.23), 0.9, ior=1.5, density=2200.0),
    "slate": Substance((0.085, 0.095, 0.105), 0.6, ior=1.5, density=2800.0),
    "snow": Substance((0.85, 0.85, 0.85), 0.9, ior=1.31, density=300.0),
    "stone": Substance((0.36, 0.35, 0.33), 0.85, ior=1.5, density=2600.0),
    "terracotta": Substance((0.555, 0.212, 0.110), 0.8, ior=1.5, density=2000.0),
    # wood
    "balsa": Substance((0.66, 0.50, 0.33), density=150.0),
    "bamboo": _varnished((0.56, 0.40, 0.19), 700.0),
    "cork": Substance((0.38, 0.22, 0.11), density=200.0),
    "ebony": _varnished((0.025, 0.019, 0.016), 1100.0),
    "mahogany": _varnished((0.18, 0.058, 0.030), 600.0),
    "oak": _varnished((0.42, 0.26, 0.13), 700.0),
    "pine": _varnished((0.60, 0.40, 0.20), 500.0),
    "walnut": _varnished((0.125, 0.066, 0.036), 650.0),
    "wood": _varnished((0.33, 0.19, 0.09), 600.0),
    # fabric, leather, paper, food
    "bone": Substance((0.793, 0.793, 0.664), 0.9, ior=1.5, density=1500.0),
    "cardboard": Substance((0.351, 0.208, 0.110), density=700.0),
    "chocolate": Substance((0.162, 0.091, 0.060), 0.5, ior=1.5, density=1300.0),
    "cloth": Substance((0.52, 0.50, 0.47), sheen=0.3, density=400.0),
    "denim": Substance((0.045, 0.075, 0.165), sheen=0.3, density=450.0),
    "fabric": Substance((0.52, 0.50, 0.47), sheen=0.3, density=400.0),
    "felt": Substance((0.20, 0.21, 0.22), sheen=0.6, density=200.0),
    "food": Substance((0.55, 0.38, 0.22), 0.6, ior=1.45, density=1000.0),
    "leather": Substance((0.14, 0.062, 0.031), 0.45, ior=1.5, density=900.0),
    "linen": Substance((0.66, 0.59, 0.46), sheen=0.2, density=400.0),
    "paper": Substance((0.794, 0.834, 0.884), density=800.0),
    "silk": Substance((0.72, 0.66, 0.56), 0.35, ior=1.5, sheen=0.6, density=1300.0),
    "velvet": Substance((0.16, 0.012, 0.022), sheen=1.0, density=400.0),
    "wax": Substance((0.78, 0.70, 0.52), 0.4, ior=1.45, density=930.0),
    "wool": Substance((0.60, 0.55, 0.46), sheen=0.5, density=300.0),
    # plastic, rubber, paint
    "car paint": Substance((0.38, 0.012, 0.014), 0.4, 0.3, coat=1.0),
    "foam": Substance((0.839, 0.838, 0.841), density=50.0),
    "lacquer": Substance((0.02, 0.02, 0.022), 0.3, ior=1.5, coat=1.0),
    "pearl": Substance((0.80, 0.75, 0.70), 0.3, ior=1.68, sheen=0.4, density=2700.0),
    "plastic": Substance((0.60, 0.60, 0.60), 0.25, ior=1.5, density=1050.0),
    "matte plastic": Substance((0.60, 0.60, 0.60), 0.6, ior=1.5, density=1050.0),
    "rubber": Substance((0.023, 0.023, 0.023), 0.7, ior=1.52, density=1100.0),
})  # fmt: skip

DENSITIES: Mapping[str, float] = MappingProxyType({
    name: substance.density for name, substance in SUBSTANCES.items() if substance.density is not None
})  # fmt: skip
