"""One primitive's embedding as a text: from the table of colours, or from a describer such as a language model.

What the program says comes first. What has no words, in no attribute either, is "typical".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.appearance import MATERIALS, Look, look_of
from scenelang.backends.pictures.studio import from_srgb
from scenelang.grammar.datum import Keyword, Symbol
from scenelang.interpreter.runtime.show import plain_attributes
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives import Box, Point, attributes_read, is_word, items_of
from scenelang.stdlib.colors import named_colors

# The names that people have for colours: words a person would say, with what they mean on a screen (sRGB).


# One family a paragraph; `name:digits`, several digits where a name covers more than one point. Neutral light tones
# that are not quite white are ivory, as in the paper (section 5): [.9 .9 .9] is.
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
    """Every name with the hexadecimal digits of one of its points, in the order of the table."""
    rows = (entry.strip().split(":") for entry in _NAMES.split(","))
    return tuple((name, digits) for name, *points in rows for digits in points)


# From a colour to the word for it: the nearest of the named ones, as people see it.
#
# Scenes hold linear light, and pictures show it encoded: the word is for what a person sees in them, so [.5 .5 .5] is
# a light grey (docs/decisions.md). Distances are those of Oklab, in which equal steps look equally large.


FloatArray = npt.NDArray[np.float64]

_CHUNK = 4096  # colours compared at once, so that memory stays small
# Oklab (Ottosson 2020): linear sRGB to the responses of the cones, their cube roots to lightness and two opponents.
_CONES = np.array([
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
])  # fmt: skip
_OPPONENTS = np.array([
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
])  # fmt: skip


def oklab(linear: npt.ArrayLike) -> FloatArray:
    """Linear sRGB (..., 3) as lightness and two opponent axes (..., 3)."""
    cones = np.asarray(linear, np.float64) @ _CONES.T
    return np.asarray(np.cbrt(cones) @ _OPPONENTS.T, np.float64)


@cache
def named_points() -> tuple[tuple[str, ...], FloatArray]:
    """K names and their points in Oklab (K, 3)."""
    rows = color_names()
    encoded = np.array([[int(digits[at : at + 2], 16) for at in (0, 2, 4)] for _, digits in rows]) / 255.0
    points = oklab(from_srgb(encoded))
    points.setflags(write=False)
    return tuple(name for name, _ in rows), points


def color_words(colors: Sequence[Any] | FloatArray) -> list[str]:
    """The words for N colours (N, 3), linear sRGB; what lies outside 0 to 1 is clipped."""
    names, points = named_points()
    seen = oklab(np.clip(np.asarray(colors, np.float64).reshape(-1, 3), 0.0, 1.0))
    found: list[str] = []
    for start in range(0, len(seen), _CHUNK):
        steps = seen[start : start + _CHUNK, None, :] - points
        found += [names[i] for i in np.einsum("nkc,nkc->nk", steps, steps).argmin(axis=1).tolist()]
    return found


def names_color(text: str) -> bool:
    """Whether a text says what colour something has: a name of the table or of CSS is in it."""
    return _anywhere().search(text.lower()) is not None


@cache
def _anywhere() -> re.Pattern[str]:
    names = {name for name, _ in color_names()} | set(named_colors()) | {"gray", "golden", "colourful", "colorful"}
    return re.compile(rf"\b(?:{'|'.join(map(re.escape, sorted(names, key=len, reverse=True)))})(?:d?ish)?\b")


# Words of programs, kinds of blocks and values of attributes as a person would write them.


MAX_PART = 80  # characters of one part of a text that comes from an attribute
_LARGEST = 1e15  # what is beyond is no number that a person would read

_NAMESPACED = re.compile(r"[a-z_]+:[a-z0-9_]+(\[.*)?\Z")


def has_meaning(word: str) -> bool:
    """Whether a word says what a thing is: `"pawn"` does, `"cube"` only says what it is made of."""
    return not is_word(word)


def thing(entity: Entity) -> str:
    """What an entity is, in words: `"piece_body"` is a piece body, a mesh file with no other word has its own name."""
    shape = entity.shape
    own = None if shape is None else shape.display_name(entity.word)
    if own is not None:
        return spaced(own) or (shape.common_name if shape is not None else None) or "thing"
    return spaced(entity.word) or "thing"


def spaced(name: str) -> str:
    """A name with spaces for its marks, `"oak_planks"` as `"oak planks"`; may be empty."""
    return " ".join(re.sub(r"[^\w'’]|_", " ", name).split())[:MAX_PART].strip()


def block(kind: str) -> str:
    """What blocks are made of: `"minecraft:oak_planks"` is oak planks. States in brackets are left out."""
    return spaced(kind.partition("[")[0].rpartition(":")[2])


def said(value: Any) -> str | None:
    """A string or symbol as it is, on one line, a name such as `minecraft:stone` as blocks have it; None for any other
    value, and for one that says nothing: a single letter is an axis or a label."""
    if not isinstance(value, (str, Symbol, Keyword)):
        return None
    text = " ".join(str(value).split())
    text = block(text) if _NAMESPACED.match(text) else text[:MAX_PART].strip()
    return text if len(text) > 1 else None


def measured(name: str, value: Any) -> str | None:
    """A number under its name, `"window count 4"`; True is the name alone, None is no number that can be read."""
    if value is True:
        return spaced(name) or None
    if type(value) in (int, float) and abs(value) < _LARGEST:
        return f"{spaced(name)} {value:.4g}".strip()
    return None


# What the attributes of one primitive say, part by part: what is written, colour, surface, proportions, numbers.


CLEAR = 3.0  # how many times as long as the others a side is that gets a word
_POLISHED, _ROUGH = 0.35, 0.7  # roughness that reads as glossy, as matte
_SEE_THROUGH, _TRANSLUCENT = 0.3, 0.95  # opacity below which it reads so
_METAL = 0.5
_MAX_READ = 16  # attributes that become words


def written(entity: Entity) -> Iterator[str]:
    """The strings among an entity's attributes, and the kind of its blocks."""
    for name, value in _unread(entity):
        text = said(value)
        if text is not None:
            yield text
        elif name.endswith(("color", "colour")) and (point := _point(value)) is not None:
            yield f"{color_words([point])[0]} {spaced(name.rpartition('-')[0])}".strip()
    kind = entity.embedding.attributes.get("block-type")
    if entity.is_block and "block-type" in attributes_read(entity.word) and isinstance(kind, str) and block(kind):
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
    if entity.shape is None or not (given or entity.shape.is_solid):  # which are white where they name no colour
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
    read = {*attributes_read(entity.word), *MATERIALS}
    return [(name, value) for name, value in entity.embedding.attributes.items() if name not in read][:_MAX_READ]


def _point(value: object) -> Sequence[float] | None:
    items = items_of(value)
    if items is None or len(items) != 3 or not all(type(item) in (int, float) and 0 <= item <= 1 for item in items):
        return None
    return items


MAX_TEXT = 300  # characters of a text made here; a program's own text is kept whole
MAX_ANSWER = 120
MAX_QUESTIONS = 256
UNDESCRIBED = "typical"


@dataclass(frozen=True, slots=True)
class AppearanceQuestion:
    """What a describer is asked: words for a thing ``word`` with ``attributes`` (plain data, as in JSON), whose colour
    the table calls ``color`` (None where it has none) and whose text, without an answer, is ``text``."""

    word: str
    attributes: Mapping[str, Any]
    color: str | None
    text: str


Describe = Callable[[Sequence[AppearanceQuestion]], Sequence[str]]


@dataclass(frozen=True, slots=True)
class Member:
    """A primitive and the entity whose word it takes: itself, or the nearest one around it that says what it is."""

    primitive: Entity
    named: Entity


@dataclass(frozen=True, slots=True)
class Description:
    """``word`` is what the thing is, ``text`` how it looks."""

    word: str
    text: str


@dataclass(frozen=True, slots=True)
class _Facts:
    """What is known of a member: the program's own texts (of the primitive, and of what it is a part of), what the
    attributes say in writing, and how it looks."""

    texts: tuple[str, ...]
    written: tuple[str, ...]
    look: Look


def describe_all(members: Sequence[Member], describe: Describe | None = None) -> list[Description]:
    """A description of each member; ``describe`` is asked once for each that reads alike, about those without a text
    in the program. An answer that is no short line of text is not taken. Raises SceneError("attribute")."""
    facts = [_facts(member) for member in members]
    colors = _colors(members, facts)
    found = [Description(thing(m.named), _text(m, fact, color)) for m, fact, color in zip(members, facts, colors)]
    if describe is None:
        return found
    questions: dict[Description, AppearanceQuestion] = {}
    for member, fact, description, color in zip(members, facts, found, colors):
        if not fact.texts and description not in questions and len(questions) < MAX_QUESTIONS:
            attributes = plain_attributes(member.primitive)
            questions[description] = AppearanceQuestion(description.word, attributes, color, description.text)
    answers = describe(tuple(questions.values())) if questions else ()
    better = {asked: text for asked, answer in zip(questions, answers) if (text := _accepted(answer)) is not None}
    return [d if fact.texts else Description(d.word, better.get(d, d.text)) for d, fact in zip(found, facts)]


def _accepted(answer: object) -> str | None:
    text = answer.strip() if isinstance(answer, str) else ""
    return text if 0 < len(text) <= MAX_ANSWER and text.isprintable() else None


def _facts(member: Member) -> _Facts:
    entities = tuple(dict.fromkeys((member.primitive, member.named)))
    texts = (entity.embedding.text for entity in entities)
    given = dict.fromkeys(text.strip() for text in texts if text is not None and text.strip())
    says = (text for entity in entities for text in written(entity))
    return _Facts(tuple(given), tuple(says), look_of(member.primitive))


def _colors(members: Sequence[Member], facts: Sequence[_Facts]) -> list[str | None]:
    """The colour words; None where there is no colour, or the program's words leave no room for one."""
    shown = [_shown(member, fact) for member, fact in zip(members, facts)]
    words = iter(color_words([color for color in shown if color is not None]))
    return [None if color is None else next(words) for color in shown]


def _shown(member: Member, facts: _Facts) -> Point | None:
    seen = seen_color(member.primitive, facts.look)
    said = (*facts.texts, *facts.written)
    if seen is None or (said and (not seen[1] or any(map(names_color, said)))):
        return None
    return seen[0]


def _text(member: Member, facts: _Facts, color: str | None) -> str:
    shape = proportions(entity_box(member.named))
    parts = [
        *facts.written,
        *([color] if color else []),
        *surface(facts.look),
        *([shape] if shape else []),
        *numbers(member.primitive),
    ]
    return _joined(", ".join(facts.texts), parts) or UNDESCRIBED


def _joined(start: str, parts: Iterable[str]) -> str:
    """``start`` and what ``parts`` add to it, as far as there is room; nothing is said twice."""
    text = start
    for part in parts:
        longer = f"{text}, {part}" if text else part
        if not _says(text, part) and len(longer) <= MAX_TEXT:
            text = longer
    return text


def _says(text: str, part: str) -> bool:
    """Whether ``part`` stands in ``text`` as words of its own: "red" is not in "weathered"."""
    return re.search(rf"(?<!\w){re.escape(part.lower())}(?!\w)", text.lower()) is not None
