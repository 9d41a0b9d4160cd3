"""Descriptions of primitives' embeddings as text: from a table of colour names, or from a language model.

Texts of the program come first. A primitive without any text or describable attribute is "typical".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.appearance import MATERIALS, Look, look_of, oklab
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.grammar.datum import Keyword, Symbol
from scenelang.interpreter.runtime.show import plain_attributes
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives import PHYSICS, Box, Point, attributes_read, is_word, items_of
from scenelang.stdlib.colors import named_colors

# Common names of colours, with their sRGB values.


# One family per paragraph; entries are `name:hex`, with several values for a name that covers more than one point.
# Neutral off-white tones are ivory, as in the paper (section 5), where [.9 .9 .9] is "ivory".
_NAMES = """
white:ffffff, ivory:fffff0:f4f4f4:f6f3ea:efefed, cream:fff6d0, eggshell:f0ead6, pearl:eae6df, bone:e3dac9,
light grey:d6d6d6:c9c9c9:bcbcbc, silver:c0c0c0, grey:a8a8a8:9a9a9a:919191:8a8a8a:808080, stone grey:8d897c,
ash grey:b5b8b1, dark grey:707070:606060:525252, charcoal:454545:3d3d3d:333537, graphite:292b2e, soot:201f1d,
black:000000:0b0b0b:151515, very light grey:e4e4e4:eaeaea, slate grey:708090, warm grey:aba39a, gunmetal:4a545c,
steel grey:6f7a83, pale blue grey:c3ccd6, dark slate:3a4752,

red:ff0000:e60000, light red:f05a5a, dark red:8b0000, deep red:b00000, crimson:dc143c, scarlet:ff2400:f03010,
cherry red:c8102e, ruby:9b111e, brick red:a8402f, blood red:7a0a0a, maroon:5e0a14, burgundy:6e0f2c, wine red:722f37,
rose red:c21e56, tomato red:ff6347, coral red:ff5a50, coral:ff7f50, salmon:fa8072, light coral:f08080,
dusty red:b9484e, raspberry:d01c6a, strawberry:fc5a6e, rust:b7410e, dark rust:86310c, vermilion:e34234,
terracotta:cc6a4a, dark terracotta:a85439, clay:b66a50, reddish brown:7f2b0a,

pink:ffc0cb, light pink:ffd6df, hot pink:ff69b4, deep pink:ff1493, rose:ff5c8d, dusty rose:c08081, dusty pink:d58a94,
blush:f4cdc6, baby pink:f9b7d0, bubblegum pink:fd8ac8, salmon pink:ff91a4, fuchsia:e0218a, magenta:ff00ff:e000d0,
dark pink:cb416b, pale rose:f0d5d5, flamingo pink:fc8eac, mauve:ae7181, shell pink:fbe3dc,

orange:ff8c00:ff7f00, bright orange:ff5b00, dark orange:d2600a, light orange:fdaa48, burnt orange:bf5500,
pumpkin:e8711c, tangerine:ff9408, apricot:ffb16d, peach:ffcba4, light peach:ffe0c7, amber:ffbf00, mango:ffa62b,
copper:b87333, dark copper:8a4f23, bronze:a97142, dark bronze:6e5b2a, pale orange:ffc58f, melon:fdb094,

yellow:ffff00:f5e400, bright yellow:fff200, lemon yellow:fdee59:fff44f, pale yellow:fff9b0, light yellow:fffde0,
gold:ffd700:e6b422, dark gold:b5940f, old gold:cfb53b, mustard:d0a41c, dark mustard:a17d10, ochre:cc7722, sand:e2ca94,
dark sand:c2a86c, straw:e4d96f, honey:e0a02c, butter yellow:ffee8c, champagne:f4e3c1, khaki:c3b091, dark khaki:a8995f,
wheat:f5deb3, vanilla:f3e5ab, caramel:c68e4d, banana yellow:ffe135, saffron:f4c430,

brown:8b5a2b:7b4a24, light brown:b08050, dark brown:4b2e17, reddish chestnut:954535, chestnut:80422c,
chocolate:5a3018, dark chocolate:36200f, coffee:6f4e37, espresso:3b2a22, walnut:5c4033, mahogany:57190f:641d10,
oak:b98a55, light oak:d3ad78, dark oak:80603a, dark oak brown:63472a, light wood:e2be86, birch:ebd9b4, teak:9c6b3a,
ebony:251d18, cinnamon:c0642a, sienna:a0522d, tan:d2b48c, beige:ece0c0, dark beige:b7a582, camel:c19a6b, taupe:8b7d6d,
dark taupe:5f5348, light taupe:b3a191, fawn:dcae7a, hazel:8e7618, golden brown:996515, greyish brown:6b5d52,
buff:e8c48e, sandstone:d6b791, rosy brown:bc8f8f, biscuit:f3d3ae, skin:e8b896, tawny:cd6f1e,

green:008000:00a000:00ff00, lime green:32cd32, lime:b0f000, light green:90ee90, pale green:c4f2bf,
dark green:004d10:005a1c, forest green:228b22, grass green:5a9a32, leaf green:5ca904, olive:808000,
olive green:6b7a2a, dark olive:4b5320, moss green:6f8a4a, sage green:9cae88, fern green:4f7942, emerald green:2fb872,
jade:00a86b, mint green:a0f5cc, pale mint:d8f7e6, sea green:2e8b57, spring green:00ff7f, pine green:1b4d3e,
hunter green:355e3b, bottle green:0f3d2e, avocado:8a9a3a, pear green:cbe05a, yellow green:9acd32, chartreuse:7fff00,
pistachio:b5d99c, apple green:76cd26, light sage:c9d5bd, khaki green:72804a, army green:565a34, dusty green:76a973,
dark sea green:8fbc8f, light olive:acb25c, greenish grey:8a9a86, deep green:02300f, kelly green:3fae2a,
pea green:a3b94c,

turquoise:40e0d0, dark turquoise:0a9a96, pale turquoise:aff0ea, teal:008080, dark teal:0b4d50, light teal:6fbfb6,
cyan:00ffff:1de9ee, dark cyan:0a8a93, light cyan:d5fbff, aqua:3fd9e8, aquamarine:7fffd4, seafoam:80d8b0,
petrol:0f5a68, verdigris:43a39a, lagoon blue:1fa6c0,

blue:0000ff:1a34f0, bright blue:0a65ff, dark blue:00008b, light blue:add8e6:9cc8f0, sky blue:87ceeb:75bbfd,
navy:000060:000080, navy blue:0c2148, midnight blue:141a52, royal blue:2f55d4, cobalt blue:0047ab, azure:0a84f0,
baby blue:bfe2fb, powder blue:c3dfe6, pale blue:dcecfb, ice blue:e6f6ff, steel blue:4682b4, denim blue:3f5f8f,
slate blue:5b74a0, cornflower blue:6495ed, ocean blue:1a6c9c, deep blue:0a2c78, electric blue:2a9cff, cerulean:1f8fcf,
indigo:3c0a82, periwinkle:9a9cf5, ultramarine:2a12b0, sapphire:1848b0, dusty blue:7d9ebf, greyish blue:8097b3,
light steel blue:b0c4de, dark denim:26405f, lavender blue:c5c8f8, ink blue:101c30, medium blue:3c6ec8,

purple:800080:7a1fa0, bright purple:a01ef0, light purple:b98ae8, dark purple:44104f, violet:8a2be2,
pale violet:d8bdf5, lavender:e3e0fa, lilac:cfa5dc, mauve purple:9a6ba8, plum:7f2f63, light plum:dda0dd, orchid:da70d6,
aubergine:3a1230, amethyst:9966cc, grape:6a2f7a, mulberry:a03a74, thistle:d8bfd8, dusty purple:80617f, berry:8c1c50,
deep violet:4a00a0, heather:a78fb3, royal purple:5a2a9a, pale lilac:ecd8ef, iris:5a4fcf, slate purple:5d5480,
dark violet:9400d3"""


@cache
def color_names() -> tuple[tuple[str, str], ...]:
    """Return every name with one of its sRGB values in hexadecimal, in the order of the table."""
    rows = (entry.strip().split(":") for entry in _NAMES.split(","))
    return tuple((name, digits) for name, *points in rows for digits in points)


# Colour naming: the perceptually nearest named colour.
#
# Colours of scenes are linear, those of images are encoded; the name is for the encoded colour, so [.5 .5 .5] is a
# light grey (docs/decisions.md). Distances are Euclidean in Oklab, which is approximately perceptually uniform.


FloatArray = npt.NDArray[np.float64]

_CHUNK = 4096  # colours compared at once, to bound memory


@cache
def named_points() -> tuple[tuple[str, ...], FloatArray]:
    """Return K colour names and their Oklab coordinates (K, 3)."""
    rows = color_names()
    encoded = np.array([[int(digits[at : at + 2], 16) for at in (0, 2, 4)] for _, digits in rows]) / 255.0
    points = oklab(from_srgb(encoded))
    points.setflags(write=False)
    return tuple(name for name, _ in rows), points


def color_words(colors: Sequence[Any] | FloatArray) -> list[str]:
    """Return the names of N colours (N, 3) in linear sRGB, clipped to [0, 1]."""
    names, points = named_points()
    seen = oklab(np.clip(np.asarray(colors, np.float64).reshape(-1, 3), 0.0, 1.0))
    words: list[str] = []
    for start in range(0, len(seen), _CHUNK):
        differences = seen[start : start + _CHUNK, None, :] - points
        words += [names[i] for i in np.einsum("nkc,nkc->nk", differences, differences).argmin(axis=1).tolist()]
    return words


def mentions_color(text: str) -> bool:
    """Return whether a text contains a colour name of the table or of CSS."""
    return _color_pattern().search(text.lower()) is not None


@cache
def _color_pattern() -> re.Pattern[str]:
    names = {name for name, _ in color_names()} | set(named_colors()) | {"gray", "golden", "colourful", "colorful"}
    return re.compile(rf"\b(?:{'|'.join(map(re.escape, sorted(names, key=len, reverse=True)))})(?:d?ish)?\b")


# Words of programs, block names and attribute values as English text.


MAX_PART = 80  # characters of the part of a text from one attribute
_MAX_NUMBER = 1e15  # larger numbers are omitted, since they would not be readable

_NAMESPACED = re.compile(r"[a-z_]+:[a-z0-9_]+(\[.*)?\Z")


def has_meaning(word: str) -> bool:
    """Return whether a word has a meaning beyond geometry: `"pawn"` does, the primitive `"cube"` does not."""
    return not is_word(word)


def noun_of(entity: Entity) -> str:
    """Return the noun of an entity: `"piece_body"` becomes "piece body", a mesh without another word its file name."""
    shape = entity.shape
    own = None if shape is None else shape.display_name(entity.word)
    if own is not None:
        return spaced(own) or (shape.common_name if shape is not None else None) or "thing"
    return spaced(entity.word) or "thing"


def spaced(name: str) -> str:
    """Replace the separators of a name by spaces: `"oak_planks"` becomes "oak planks"; may be empty."""
    return " ".join(re.sub(r"[^\w'’]|_", " ", name).split())[:MAX_PART].strip()


def block_name(kind: str) -> str:
    """Return the name of a block without namespace and state: `"minecraft:oak_planks"` becomes "oak planks"."""
    return spaced(kind.partition("[")[0].rpartition(":")[2])


def text_of(value: Any) -> str | None:
    """Return a string or symbol on one line, or the block name for one such as `minecraft:stone`.

    None for any other value, and for a single character, which is an axis or a label.
    """
    if not isinstance(value, (str, Symbol, Keyword)):
        return None
    text = " ".join(str(value).split())
    text = block_name(text) if _NAMESPACED.match(text) else text[:MAX_PART].strip()
    return text if len(text) > 1 else None


def number_text(name: str, value: Any) -> str | None:
    """Format a numeric attribute: `"window count 4"`; only the name for True, None for any other value."""
    if value is True:
        return spaced(name) or None
    if type(value) in (int, float) and abs(value) < _MAX_NUMBER:
        return f"{spaced(name)} {value:.4g}".strip()
    return None


# Parts of the description of one primitive: texts, colour, surface, proportions, numbers. The thresholds are chosen by
# how renderings look.


ELONGATION = 3.0  # ratio of sides from which proportions are mentioned
_GLOSSY, _MATTE = 0.35, 0.7  # maximum and minimum roughness
_TRANSPARENT, _TRANSLUCENT = 0.3, 0.95  # maximum opacity
_METALLIC = 0.5  # minimum metallic value
_MAX_ATTRIBUTES = 16  # per entity


def attribute_texts(entity: Entity) -> Iterator[str]:
    """Yield the strings among an entity's attributes, and the name of its block."""
    for name, value in _semantic_attributes(entity):
        text = text_of(value)
        if text is not None:
            yield text
        elif name.endswith(("color", "colour")) and (color := _color(value)) is not None:
            yield f"{color_words([color])[0]} {spaced(name.rpartition('-')[0])}".strip()
    kind = entity.embedding.attributes.get("block-type")
    if entity.is_block and "block-type" in attributes_read(entity.word) and isinstance(kind, str) and block_name(kind):
        yield block_name(kind)


def attribute_numbers(entity: Entity) -> Iterator[str]:
    """Yield the numeric attributes that the geometry does not use: `"height 3"`."""
    for name, value in _semantic_attributes(entity):
        text = number_text(name, value)
        if text is not None:
            yield text


def visible_color(entity: Entity, look: Look) -> tuple[Point, bool] | None:
    """Return the colour of a primitive in linear sRGB, and whether the program specifies it.

    None if backends choose an arbitrary colour: for a semantic primitive, a block or a mesh file.
    """
    if any(look.emission):
        scale = max(1.0, *look.emission)
        red, green, blue = (channel / scale for channel in look.emission)
        return (red, green, blue), True
    given = entity.embedding.attributes.get("color") is not None
    if entity.shape is None or not (given or entity.shape.is_solid):  # solids without a colour are white
        return None
    return look.color, given


def surface_words(look: Look) -> Iterator[str]:
    """Yield adjectives for the surface's material, without its color; a substance stands for all of them."""
    if any(look.emission):
        yield "glowing"
    if look.material is not None:
        yield look.material
        return
    if look.opacity < _TRANSLUCENT:
        yield "transparent" if look.opacity < _TRANSPARENT or look.ior is not None else "translucent"
    if look.metallic >= _METALLIC:
        yield "metallic"
    if look.roughness is None:
        if look.ior is not None:
            yield "glossy"
    elif look.roughness <= _GLOSSY:
        yield "glossy"
    elif look.roughness >= _MATTE:
        yield "matte"


def proportion_word(box: Box | None) -> str | None:
    """Return an adjective for a box (y is up) if one side clearly differs from both others, else None."""
    if box is None:
        return None
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    low, middle, high = sorted((x, y, z))
    if high <= 0.0:
        return None
    if high > ELONGATION * middle:
        return "tall" if y == high else "long"
    if middle > ELONGATION * low:
        return "flat" if y == low else "thin"
    return None


def _semantic_attributes(entity: Entity) -> list[tuple[str, object]]:
    """Return the attributes that no geometric backend reads, which therefore only text can express."""
    geometric = {*attributes_read(entity.word), *MATERIALS, *(each.name for each in PHYSICS)}
    attributes = [(name, value) for name, value in entity.embedding.attributes.items() if name not in geometric]
    return attributes[:_MAX_ATTRIBUTES]


def _color(value: object) -> Sequence[float] | None:
    items = items_of(value)
    if items is None or len(items) != 3 or not all(type(item) in (int, float) and 0 <= item <= 1 for item in items):
        return None
    return items


MAX_TEXT = 300  # characters of a generated text; texts of the program are not truncated
MAX_ANSWER = 120
MAX_QUESTIONS = 256
UNDESCRIBED = "typical"


@dataclass(frozen=True, slots=True)
class AppearanceQuestion:
    """Question for a describer about the appearance of an entity.

    Attributes
    ----------
    word
        Noun of the entity.
    attributes
        Its attributes as JSON data.
    color
        Name of its colour, or None.
    text
        Description that is used without an answer.
    """

    word: str
    attributes: Mapping[str, Any]
    color: str | None
    text: str


Describe = Callable[[Sequence[AppearanceQuestion]], Sequence[str]]


@dataclass(frozen=True, slots=True)
class Member:
    """Primitive, and the entity that gives it a noun: itself, or its nearest ancestor with a meaningful word."""

    primitive: Entity
    named: Entity


@dataclass(frozen=True, slots=True)
class Description:
    """Noun ``word`` of an entity, and a ``text`` that describes its appearance."""

    word: str
    text: str


@dataclass(frozen=True, slots=True)
class _Facts:
    """Sources of a member's description: the program's texts of the primitive and of the named entity, the texts of
    their attributes, and the material."""

    texts: tuple[str, ...]
    attribute_texts: tuple[str, ...]
    look: Look


def describe_all(members: Sequence[Member], describe: Describe | None = None) -> list[Description]:
    """Describe each member.

    ``describe`` answers one question for each distinct description of members without a text in the program; answers
    that are not a short line of text are ignored. Raises SceneError("attribute").
    """
    facts = [_facts(member) for member in members]
    colors = _color_names(members, facts)
    descriptions = [
        Description(noun_of(m.named), _text(m, fact, color)) for m, fact, color in zip(members, facts, colors)
    ]
    if describe is None:
        return descriptions
    questions: dict[Description, AppearanceQuestion] = {}
    for member, fact, description, color in zip(members, facts, descriptions, colors):
        if not fact.texts and description not in questions and len(questions) < MAX_QUESTIONS:
            attributes = plain_attributes(member.primitive)
            questions[description] = AppearanceQuestion(description.word, attributes, color, description.text)
    answers = describe(tuple(questions.values())) if questions else ()
    better = {question: text for question, answer in zip(questions, answers) if (text := _valid(answer)) is not None}
    return [d if fact.texts else Description(d.word, better.get(d, d.text)) for d, fact in zip(descriptions, facts)]


def _valid(answer: object) -> str | None:
    text = answer.strip() if isinstance(answer, str) else ""
    return text if 0 < len(text) <= MAX_ANSWER and text.isprintable() else None


def _facts(member: Member) -> _Facts:
    entities = tuple(dict.fromkeys((member.primitive, member.named)))
    texts = (entity.embedding.text for entity in entities)
    given = dict.fromkeys(text.strip() for text in texts if text is not None and text.strip())
    attributes = (text for entity in entities for text in attribute_texts(entity))
    return _Facts(tuple(given), tuple(attributes), look_of(member.primitive))


def _color_names(members: Sequence[Member], facts: Sequence[_Facts]) -> list[str | None]:
    """Return the colour names; None for members whose colour is unknown or already described by a text."""
    shown = [_described_color(member, fact) for member, fact in zip(members, facts)]
    words = iter(color_words([color for color in shown if color is not None]))
    return [None if color is None else next(words) for color in shown]


def _described_color(member: Member, facts: _Facts) -> Point | None:
    seen = visible_color(member.primitive, facts.look)
    texts = (*facts.texts, *facts.attribute_texts)
    if seen is None or (texts and (not seen[1] or any(map(mentions_color, texts)))):
        return None
    return seen[0]


def _text(member: Member, facts: _Facts, color: str | None) -> str:
    shape = proportion_word(entity_box(member.named))
    parts = [
        *facts.attribute_texts,
        *([color] if color else []),
        *surface_words(facts.look),
        *([shape] if shape else []),
        *attribute_numbers(member.primitive),
    ]
    return _join(", ".join(facts.texts), parts) or UNDESCRIBED


def _join(start: str, parts: Iterable[str]) -> str:
    """Append ``parts`` to ``start``, except repetitions and parts that would exceed the maximum length."""
    text = start
    for part in parts:
        longer = f"{text}, {part}" if text else part
        if not _contains(text, part) and len(longer) <= MAX_TEXT:
            text = longer
    return text


def _contains(text: str, part: str) -> bool:
    """Return whether ``text`` contains ``part`` as whole words: "weathered" does not contain "red"."""
    return re.search(rf"(?<!\w){re.escape(part.lower())}(?!\w)", text.lower()) is not None
