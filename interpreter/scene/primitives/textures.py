"""Textures: patterns and images on surfaces, as plain data. ``backends/surfaces/tiles`` draws them.

The value of ``:texture`` is the name of a pattern, the name of an image file, or the list that ``(texture ...)``
returns: the name, then settings by name and value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import SceneError, suggest, suggest_text

Color = tuple[float, float, float]

IMAGE_ENDINGS = (".png", ".jpg", ".jpeg", ".webp")
PROJECTIONS: Mapping[str, str] = MappingProxyType({
    "box": "on each side along the axis that it faces",
    "planar": "along z, onto the front and through to the back",
    "cylindrical": "around the y axis",
    "spherical": "around the y axis and from pole to pole",
    "uv": "where the texture coordinates of a mesh file put it",
})  # fmt: skip
# The axis that each side faces, and whether it faces its positive end: where ``:side`` puts an image or a text.
SIDES: Mapping[str, tuple[int, bool]] = MappingProxyType({
    "front": (2, True), "back": (2, False), "right": (0, True), "left": (0, False), "top": (1, True),
    "bottom": (1, False),
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class PatternKind:
    """A pattern: what it shows, its two colors, and the share of an object's size that ``:scale`` is by default.

    ``shades`` says that the second color is a shade of the first, which it follows when a surface has another color.
    """

    doc: str
    colors: tuple[Color, Color]
    share: float = 0.25
    projection: str = "box"
    shades: bool = False

    def colors_on(self, color: Color) -> tuple[Color, Color]:
        """Return the two colors of the pattern on a surface of ``color``."""
        first, second = self.colors
        if not self.shades:
            return color, second
        red, green, blue = (own * there / here for own, here, there in zip(color, first, second, strict=True))
        return color, (red, green, blue)


_WHITE, _BLACK, _GRAY = (0.75, 0.75, 0.75), (0.06, 0.06, 0.06), (0.25, 0.25, 0.25)

PATTERNS: Mapping[str, PatternKind] = MappingProxyType({
    "checker": PatternKind("squares of side `:scale`", (_WHITE, _BLACK), 0.125),
    "stripes": PatternKind("stripes of width `:scale` along x", (_WHITE, _BLACK), 0.0625),
    "brick": PatternKind("courses of bricks of length `:scale`", ((0.262, 0.095, 0.061), (0.45, 0.43, 0.40)), 0.2),
    "tiles": PatternKind("square tiles of side `:scale` with joints", ((0.62, 0.64, 0.66), _GRAY), 0.2),
    "planks": PatternKind("boards of width `:scale` along x", ((0.33, 0.19, 0.09), (0.05, 0.03, 0.015)), 0.125,
                      shades=True),
    "wood": PatternKind("grain along x of a board of width `:scale`", ((0.42, 0.26, 0.13), (0.24, 0.13, 0.055)), 1.0,
                    shades=True),
    "marble": PatternKind("veins, `:scale` apart", ((0.83, 0.79, 0.75), (0.30, 0.30, 0.32)), 0.5, shades=True),
    "noise": PatternKind("clouds of size `:scale`", ((0.60, 0.60, 0.60), (0.20, 0.20, 0.20)), 0.25, shades=True),
    "dots": PatternKind("dots, `:scale` apart", (_WHITE, (0.60, 0.03, 0.03)), 0.2),
    "gradient": PatternKind("from the first color to the second and back, over `:scale` along y",
                        (_WHITE, (0.05, 0.10, 0.35)), 2.0),
    "text": PatternKind("the string `:text`, in squares of side `:scale`", (_WHITE, _BLACK), 1.0, "planar"),
})  # fmt: skip

_SETTINGS = ("scale", "turn", "colors", "projection", "text", "side", "at", "bump")
_MAX_TEXT = 200  # characters
_MAX_BUMP = 10.0  # in units of ``:scale``


@dataclass(frozen=True, slots=True)
class Texture:
    """A texture of a surface.

    Attributes
    ----------
    name
        Name of a pattern, or path of an image.
    scale
        Size of one element of the pattern, or width of an image, in scene units in the frame of the primitive; None
        for a share of the primitive's size.
    turn
        Degrees by which the pattern is turned in its plane.
    colors
        Two colors of the pattern, linear sRGB; none for its own, or those of the surface.
    projection
        Name in ``PROJECTIONS``.
    side
        Name in ``SIDES``: the only side that shows the image or the text, once; empty for a texture that repeats.
    at
        Displacement of a decal to the right and upwards from the middle of its side, in scene units.
    source
        For an image inside of the mesh file ``name``: the folder that must contain what the file refers to, and the
        number of the image in the file.
    bump
        Depth of the relief in units of ``scale``: what has the first color, or is white in an image, is so much higher
        than what has the second, or is black.
    """

    name: str
    scale: float | None = None
    turn: float = 0.0
    colors: tuple[Color, ...] = ()
    projection: str = "box"
    text: str = ""
    side: str = ""
    at: tuple[float, float] = (0.0, 0.0)
    bump: float = 0.0
    source: tuple[str, int] | None = None

    @property
    def depth(self) -> float:
        """Depth of the relief in scene units, in the frame of the primitive."""
        return self.bump * (self.scale or 1.0)

    @property
    def is_image(self) -> bool:
        """Whether it is an image rather than a pattern."""
        return self.source is not None or is_image(self.name)


def is_image(name: str) -> bool:
    """Return whether the name of a texture is that of an image file, by its extension."""
    return name.lower().endswith(IMAGE_ENDINGS)


def texture(name: str, settings: Mapping[str, Any], where: str) -> Texture:
    """Return a texture of checked settings; raises SceneError("attribute"), whose message names ``where``.

    ``colors`` among the settings is a tuple of two colors.
    """
    if not is_image(name) and name not in PATTERNS:
        endings = ", ".join(IMAGE_ENDINGS)
        hint = suggest_text(name, PATTERNS) or f"patterns: {', '.join(PATTERNS)}; images end with {endings}"
        raise SceneError("attribute", f'{where} names no pattern or image: "{name[:60]}"', hint)
    unknown = [key for key in settings if key not in _SETTINGS]
    if unknown:
        hint = suggest(unknown[0], _SETTINGS) or f"settings: {', '.join(f':{key}' for key in _SETTINGS)}"
        raise SceneError("attribute", f"{where} has no setting `:{unknown[0][:40]}`", hint)
    pattern = PATTERNS.get(name)
    scale = settings.get("scale")
    if scale is not None and not (type(scale) in (int, float) and 0.0 < scale < math.inf):
        raise SceneError("attribute", f"`:scale` of {where} must be a finite number above 0")
    turn = settings.get("turn") or 0.0
    if type(turn) not in (int, float) or not math.isfinite(turn):
        raise SceneError("attribute", f"`:turn` of {where} must be a finite number of degrees")
    bump = settings.get("bump") or 0.0
    if type(bump) not in (int, float) or not abs(bump) <= _MAX_BUMP:
        raise SceneError("attribute", f"`:bump` of {where} must be a number from -{_MAX_BUMP:g} to {_MAX_BUMP:g}")
    text = settings.get("text") or ""
    if type(text) is not str or len(text) > _MAX_TEXT or (name == "text" and not text.strip()):
        raise SceneError("attribute", f"`:text` of {where} must be a string of 1 to {_MAX_TEXT} characters")
    side, at = _place(name, settings, where)
    projection = settings.get("projection") or ("planar" if side else pattern.projection if pattern else "box")
    if projection not in PROJECTIONS:
        hint = suggest(str(projection), PROJECTIONS) or f"projections: {', '.join(PROJECTIONS)}"
        raise SceneError("attribute", f"`:projection` of {where} must be one of {', '.join(PROJECTIONS)}", hint)
    if side and projection != "planar":
        raise SceneError("attribute", f"{where} has both a `:side` and the projection {projection}", _ONCE)
    scale = None if scale is None else float(scale)
    return Texture(name, scale, float(turn), settings.get("colors") or (), projection, text, side, at, float(bump))


_ONCE = "a `:side` shows an image or a text once, without distortion: leave `:projection` out"


def _place(name: str, settings: Mapping[str, Any], where: str) -> tuple[str, tuple[float, float]]:
    """Return the side of a decal, empty for another texture, and its displacement there; raises SceneError."""
    side, at = settings.get("side") or "", settings.get("at")
    if side and side not in SIDES:
        hint = suggest(str(side), SIDES) or f"sides: {', '.join(SIDES)}"
        raise SceneError("attribute", f"`:side` of {where} must be one of {', '.join(SIDES)}", hint)
    if side and not is_image(name) and name != "text":
        hint = f'another object that is thin has the pattern: `(call "cube" :scale [1 1 .01] :texture "{name}")`'
        raise SceneError("attribute", f"{where} has a `:side`, which only images and texts have", hint)
    if at is None:
        return side, (0.0, 0.0)
    if not side:
        raise SceneError("attribute", f"{where} has `:at` without `:side`", 'write `:side "front" :at [right up]`')
    if len(at) != 2 or not all(type(number) in (int, float) and math.isfinite(number) for number in at):
        raise SceneError("attribute", f"`:at` of {where} must be two numbers: to the right and upwards")
    return side, (float(at[0]), float(at[1]))
