"""What the attributes of one primitive say, part by part: what is written, colour, surface, proportions, numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenelang.backends.appearance import MATERIALS, Look
from scenelang.backends.wording.color_words import color_words
from scenelang.backends.wording.readable import block, measured, said, spaced
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.shapes import READ, Box, Kind, Point, items_of

CLEAR = 3.0  # how many times as long as the others a side is that gets a word
_POLISHED, _ROUGH = 0.35, 0.7  # roughness that reads as glossy, as matte
_SEE_THROUGH, _TRANSLUCENT = 0.3, 0.95  # opacity below which it reads so
_METAL = 0.5
_MAX_READ = 16  # attributes that become words
_COLORED = {Kind.CUBE, Kind.SPHERE, Kind.CYLINDER, Kind.CONE}  # white where they name no colour


def written(entity: Entity) -> Iterator[str]:
    """The strings among an entity's attributes, and the kind of its blocks."""
    for name, value in _unread(entity):
        text = said(value)
        if text is not None:
            yield text
        elif name.endswith(("color", "colour")) and (point := _point(value)) is not None:
            yield f"{color_words([point])[0]} {spaced(name.rpartition('-')[0])}".strip()
    kind = entity.embedding.attributes.get("block-type")
    if entity.word == "set-cuboid" and isinstance(kind, str) and block(kind):
        yield block(kind)


def numbers(entity: Entity) -> Iterator[str]:
    """The numbers among the attributes that no geometry reads: `"height 3"`."""
    for name, value in _unread(entity):
        text = measured(name, value)
        if text is not None:
            yield text


def seen_color(entity: Entity, look: Look) -> tuple[Point, bool] | None:
    """The colour that a primitive shows, linear sRGB, and whether the program names it. None where backends only
    choose one to tell things apart: the tint of a semantic primitive, a block or a mesh file."""
    if any(look.emission):
        most = max(1.0, *look.emission)
        red, green, blue = (channel / most for channel in look.emission)
        return (red, green, blue), True
    given = entity.embedding.attributes.get("color") is not None
    if entity.shape is None or not (given or entity.shape.kind in _COLORED):
        return None
    return look.color, given


def surface(look: Look) -> Iterator[str]:
    """How a surface looks besides its colour."""
    if any(look.emission):
        yield "glowing"
    if look.opacity < _TRANSLUCENT:
        yield "transparent" if look.opacity < _SEE_THROUGH or look.ior is not None else "translucent"
    if look.metallic >= _METAL:
        yield "metallic"
    if look.roughness is None:
        if look.ior is not None:
            yield "glossy"
    elif look.roughness <= _POLISHED:
        yield "glossy"
    elif look.roughness >= _ROUGH:
        yield "matte"


def proportions(box: Box | None) -> str | None:
    """A word for a box (y is up) one of whose sides clearly differs from both others; None for all else."""
    if box is None:
        return None
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    low, middle, high = sorted((x, y, z))
    if high <= 0.0:
        return None
    if high > CLEAR * middle:
        return "tall" if y == high else "long"
    if middle > CLEAR * low:
        return "flat" if y == low else "thin"
    return None


def _unread(entity: Entity) -> list[tuple[str, object]]:
    """The attributes that no geometric backend reads, so that only words can tell of them."""
    read = {*READ.get(entity.word, ("scale", "color")), *MATERIALS}
    return [(name, value) for name, value in entity.embedding.attributes.items() if name not in read][:_MAX_READ]


def _point(value: object) -> Sequence[float] | None:
    items = items_of(value)
    if items is None or len(items) != 3 or not all(type(item) in (int, float) and 0 <= item <= 1 for item in items):
        return None
    return items
