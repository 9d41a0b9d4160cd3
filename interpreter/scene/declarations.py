"""Declarations of ``assert-that``: spatial relations that a program states and ``check --run`` verifies.

This is the vocabulary, registered once for the expander, the reference and the prompts. The geometry that decides
whether a declaration holds is in ``backends.geometry.relations``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from scenelang.grammar.datum import Span, dataclass
from scenelang.interpreter.scene.primitives.base import encoded

AXES = ("x", "y", "z")
OBJECT, NUMBER, COLOR, OUTLINE, PATH, MATERIAL = "object", "number", "color", "outline", "path", "material"
OUTLINES = ("round", "oval", "square", "rectangular")
PATHS = ("line", "circle", "closed")
# In which frames of a 4D scene a declaration must hold; in all without one of these. `:never` is that of `not`.
FRAME_FLAGS = ("first", "last", "sometime", "never")
MAX_OBJECTS = 64  # operands of `order`
IN_DEGREES = frozenset({"angle", "facing", "tilt", "turns"})  # relations whose tolerance is an angle


@dataclass(frozen=True, slots=True)
class Relation:
    """Relation that a declaration states.

    Attributes
    ----------
    name, usage, doc, example
        For the reference. The usage shows the operands and options, the example is a declaration.
    operands
        Kinds of the operands: OBJECT, NUMBER, or a text that is a COLOR, an OUTLINE, a PATH or a MATERIAL.
    optional
        Number of operands at the end that may be left out.
    options
        Names of the options that it takes, besides ``message`` and those of frames.
    is_open
        Whether more operands of the last kind may follow.
    """

    name: str
    usage: str
    doc: str
    example: str
    operands: tuple[str, ...]
    options: tuple[str, ...]
    optional: int = 0
    is_open: bool = False

    @property
    def operand_counts(self) -> tuple[int, int]:
        """Least and greatest number of operands."""
        count = len(self.operands)
        return count - self.optional, MAX_OBJECTS if self.is_open else count

    @property
    def keywords(self) -> tuple[str, ...]:
        """All options that a program may write, without ``message``."""
        return self.options if self.name in OVER_FRAMES else (*self.options, *FRAME_FLAGS)

    def wrong_count(self, count: int) -> str | None:
        """Return the message about a wrong number of operands, None for a right one."""
        least, most = self.operand_counts
        if least <= count <= most:
            return None
        several = f"{least} to {most}" if self.is_open else f"{least} or {most}"
        return f"`{self.name}` expects {least if least == most else several} operands, got {count}"

    def kind_of(self, position: int) -> str:
        """Return the kind of the operand at a position."""
        return self.operands[min(position, len(self.operands) - 1)]


OVER_FRAMES = frozenset({"moves", "turns", "path"})  # about all frames together
_QUANTIFIERS = ("any", "all")


def _direction(name: str, where: str) -> Relation:
    """Return a relation of two objects in a direction of the scene."""
    return Relation(
        name,
        f"({name} A B [:any] [:all])",
        f"Every A is {where} some B.",
        f'({name} "cup" "lamp")',
        (OBJECT, OBJECT),
        _QUANTIFIERS,
    )


_RELATIONS = (
    Relation(
        "on",
        "(on A B [:any] [:all] [:within length])",
        "Every A rests on some B: it touches B, and B keeps it from moving down.",
        '(on "cup" "table")',
        (OBJECT, OBJECT),
        (*_QUANTIFIERS, "within"),
    ),
    Relation(
        "inside",
        '(inside A B [:any] [:all] [:share share] [:axis "y"])',
        "Every A is inside the convex hull of some B, or at least a share of its volume (from 0 to 1). With `:axis`, so"
        " are their outlines, seen along that axis of the scene: along y, an A on B does not reach beyond its edge.",
        '(inside "pencil" "mug" :share .5)',
        (OBJECT, OBJECT),
        (*_QUANTIFIERS, "share", "axis"),
    ),
    Relation(
        "touching",
        "(touching A B [:any] [:all] [:within length])",
        "Every A touches some B, and they do not overlap.",
        '(touching "shelf" "wall")',
        (OBJECT, OBJECT),
        (*_QUANTIFIERS, "within"),
    ),
    Relation(
        "clear-of",
        "(clear-of A B [:any] [:min length])",
        "Every A is clear of every B: they do not overlap, and are at least a length apart.",
        '(clear-of "chair" "chair" :min .1)',
        (OBJECT, OBJECT),
        ("any", "min"),
    ),
    Relation(
        "distance",
        '(distance A B [length] [:axis "xy"] [:within length] [:min length] [:max length] [:any] [:all])',
        "The distance of every A from the nearest B is a length, or in a range: between their surfaces, and 0 if they"
        " touch or overlap. With `:axis`, between their centers, along one axis or in the plane of two: a knob is in"
        ' the middle of a front if `(distance "front" "knob" :max .01 :axis "xy")`.',
        '(distance "chair" "table" :max .5)',
        (OBJECT, OBJECT, NUMBER),
        (*_QUANTIFIERS, "axis", "within", "min", "max"),
        1,
    ),
    Relation(
        "angle",
        '(angle A B degrees [:axis "y"] [:within degrees] [:any] [:all])',
        "The angle between an axis of every A, in its own frame, and that of some B is so many degrees.",
        '(angle "door" "wall" 90 :axis "z")',
        (OBJECT, OBJECT, NUMBER),
        (*_QUANTIFIERS, "axis", "within"),
    ),
    Relation(
        "facing",
        "(facing A B [:within degrees] [:any] [:all])",
        "The front of every A, its +z axis, points to some B, within 30 degrees by default, seen from above.",
        '(facing "chair" "table")',
        (OBJECT, OBJECT),
        (*_QUANTIFIERS, "within"),
    ),
    _direction("above", "over"),
    _direction("below", "under"),
    _direction("left-of", "to the left of (nearer to -x than)"),
    _direction("right-of", "to the right of (nearer to +x than)"),
    _direction("in-front-of", "in front of (nearer to +z than)"),
    _direction("behind", "behind (nearer to -z than)"),
    Relation(
        "between",
        "(between A B C [:any])",
        "Every A is between some B and some C: the line between their centers passes through its box.",
        '(between "candle" "cup" "plate")',
        (OBJECT, OBJECT, OBJECT),
        ("any",),
    ),
    Relation(
        "aligned",
        '(aligned A [:along "x"] [:within length])',
        'The centers of all A are on a line, along an axis or, with two axes such as "xz", in a plane.',
        '(aligned "pawn" :along "x")',
        (OBJECT,),
        ("along", "within"),
    ),
    Relation(
        "evenly-spaced",
        '(evenly-spaced A [:along "x"] [:around B [:axis "y"]] [:within length])',
        "The distances between neighboring centers of all A, in the order along a line, are equal; objects at one"
        " position along an axis count once. With `:around`, the angles between neighbors, seen along an axis from the"
        " center of B; `:within` is then in degrees, by default a tenth of the angle, at most 5.",
        '(evenly-spaced "pawn" :along "x")',
        (OBJECT,),
        ("along", "around", "axis", "within"),
    ),
    Relation(
        "rows",
        '(rows A number :along "z" [:each count] [:within length])',
        "The centers of all A have so many different positions along an axis: a field of five rows and nine columns has"
        " 5 along z and 9 along x. With `:each`, so many A are at every position; a list such as '(1 2 3) says how many"
        ' in the order along a direction such as "+z".',
        '(rows "chair" 2 :along "z" :each 3)',
        (OBJECT, NUMBER),
        ("along", "each", "within"),
    ),
    Relation(
        "order",
        '(order A B ... [:along "x"] [:around C])',
        "All A come before all B, and so on, by their centers along an axis, in its direction. With `:around`,"
        " counterclockwise seen from above, from the first A on.",
        '(order "cup" "candle" "plate" :along "x")',
        (OBJECT, OBJECT),
        ("along", "around"),
        is_open=True,
    ),
    Relation(
        "symmetric",
        '(symmetric A [:across "x"] [:about B] [:within length])',
        "All A together are mirror images of themselves across the plane perpendicular to an axis through their center,"
        " or through the common center of all B.",
        '(symmetric "chair" :across "x" :about "table")',
        (OBJECT,),
        ("across", "about", "within"),
    ),
    Relation(
        "supported",
        "(supported A [:any])",
        "Contacts connect every A to the ground, whatever its words say; balance is a matter of `check --geometry`.",
        '(supported "cup")',
        (OBJECT,),
        ("any",),
    ),
    Relation(
        "floating",
        "(floating A [:any])",
        "No contacts connect any A to the ground.",
        '(floating "lamp")',
        (OBJECT,),
        ("any",),
    ),
    Relation(
        "fastened",
        "(fastened A B [:any] [:all])",
        "Every A is fastened to some B: set into it, hung on it, or a part of one body with it.",
        '(fastened "shelf" "wall")',
        (OBJECT, OBJECT),
        _QUANTIFIERS,
    ),
    Relation(
        "size",
        '(size A [length] :axis "y" [:within length] [:min length] [:max length] [:any])',
        'The extent of every A along an axis of the scene is a length, or in a range; with several axes such as "xz"'
        " the largest.",
        '(size "tower" :axis "y" :min 3)',
        (OBJECT, NUMBER),
        ("any", "axis", "within", "min", "max"),
        1,
    ),
    Relation(
        "proportion",
        '(proportion A B [ratio] :axis "y" [:within ratio] [:min ratio] [:max ratio] [:any] [:all])',
        "The extent of every A along an axis of the scene, divided by that of some B, is a number, or in a range; with"
        ' several axes such as "xz" the largest extents.',
        '(proportion "chair" "table" :axis "y" :max 1.2)',
        (OBJECT, OBJECT, NUMBER),
        (*_QUANTIFIERS, "axis", "within", "min", "max"),
        1,
    ),
    Relation(
        "aspect",
        '(aspect A [ratio] :axis "y" :to "x" [:within ratio] [:min ratio] [:max ratio] [:any])',
        "The extent of every A along an axis of the scene, divided by its own along another, is a number or in a range:"
        ' a tower is higher than wide, a domino stands. With several axes such as "xz" the largest extent counts.',
        '(aspect "tower" :axis "y" :to "xz" :min 2)',
        (OBJECT, NUMBER),
        ("any", "axis", "to", "within", "min", "max"),
        1,
    ),
    Relation(
        "elevation",
        "(elevation A [length] [:within length] [:min length] [:max length] [:any])",
        "The lowest point of every A is so high above the ground, or in a range.",
        '(elevation "shelf" :min .5)',
        (OBJECT, NUMBER),
        ("any", "within", "min", "max"),
        1,
    ),
    Relation(
        "encircles",
        '(encircles A B [radius] [:axis "y"] [:within length] [:min length] [:max length])',
        "The centers of all A are at one distance from the axis through the common center of all B, or at a given one;"
        ' `(encircles "stone" "stone")` states a circle.',
        '(encircles "chair" "table" 1.6)',
        (OBJECT, OBJECT, NUMBER),
        ("axis", "within", "min", "max"),
        1,
    ),
    Relation(
        "rising",
        '(rising A [:along "+x"] [:around B])',
        "In the order of their centers along a direction, every A is higher than the one before. With `:around`, in the"
        " order counterclockwise around B, seen from above, from the lowest A on.",
        '(rising "plank" :along "+x")',
        (OBJECT,),
        ("along", "around"),
    ),
    Relation(
        "tilt",
        "(tilt A [degrees] [:within degrees] [:min degrees] [:max degrees] [:any])",
        "Every A is tilted by so many degrees, or in a range: the median of the angles between the vertical and the"
        " nearest principal axis of each of its parts.",
        '(tilt "candle" 10)',
        (OBJECT, NUMBER),
        ("any", "within", "min", "max"),
        1,
    ),
    Relation(
        "outline",
        '(outline A shape [:axis "y"] [:any])',
        "The outline of every A, seen along an axis of the scene, is round, oval, square or rectangular.",
        '(outline "plate" "round")',
        (OBJECT, OUTLINE),
        ("any", "axis"),
    ),
    Relation(
        "made-of",
        "(made-of A block-type [:any])",
        "Most of the volume of the Minecraft blocks of every A is of blocks with that name, or with a name of which it"
        ' is a part between underscores: both "oak" and "planks" are in "oak_planks".',
        '(made-of "brick-wall" "bricks")',
        (OBJECT, MATERIAL),
        ("any",),
    ),
    Relation(
        "visible-from",
        "(visible-from A B [:share share] [:any] [:all])",
        "At least a share of the surface of every A, half by default, is not hidden by other objects, seen from the top"
        " of some B.",
        '(visible-from "candle" "chair")',
        (OBJECT, OBJECT),
        (*_QUANTIFIERS, "share"),
    ),
    Relation(
        "reachable",
        "(reachable A B [:within length] [:any] [:all])",
        "A person can walk on the ground from some B to within arm's reach of every A: over a way that is free to a"
        " height of 1.7 and by a length to each side, .25 by default, in metres.",
        '(reachable "lamp" "door")',
        (OBJECT, OBJECT),
        (*_QUANTIFIERS, "within"),
    ),
    Relation(
        "count",
        "(count A [number] [:min number] [:max number])",
        "There are so many A, or a number in a range.",
        '(count "chair" 6)',
        (OBJECT, NUMBER),
        ("min", "max"),
        1,
    ),
    Relation(
        "has-color",
        "(has-color A color [:any])",
        "More of the surface of every A has a color that is called so than any other: black, white, gray, red, orange,"
        " brown, yellow, green, cyan, blue, purple or pink. A color vector means the one of these that it is called.",
        '(has-color "cup" "blue")',
        (OBJECT, COLOR),
        ("any",),
    ),
    Relation(
        "moves",
        '(moves A [length] [:along "x"] [:within length] [:min length] [:max length] [:any])',
        "Through the frames the center of every A takes places whose extent along an axis (without one, the diagonal of"
        ' the box around them) is a length, or in a range. Along a direction such as "+x" or "-y", the way from its'
        " first place to its last.",
        '(moves "cup" :along "y" :min .2)',
        (OBJECT, NUMBER),
        ("any", "along", "within", "min", "max"),
        1,
    ),
    Relation(
        "turns",
        '(turns A [degrees] [:axis "y"] [:within degrees] [:min degrees] [:max degrees] [:any])',
        "The greatest angle by which every A is turned from its first frame is so many degrees, or in a range. With"
        " `:axis`, the sum of its turns from frame to frame, all about that axis of the scene; about a direction such"
        ' as "+y", counterclockwise seen from there.',
        '(turns "door" 90 :within 5)',
        (OBJECT, NUMBER),
        ("any", "axis", "within", "min", "max"),
        1,
    ),
    Relation(
        "path",
        "(path A shape [:about B] [:within length] [:any])",
        'The center of every A moves on a "line", on a "circle" (with `:about`, one whose axis goes through the center'
        ' of B), or on a "closed" path, which ends where it begins.',
        '(path "cup" "line")',
        (OBJECT, PATH),
        ("any", "about", "within"),
    ),
)
RELATIONS: Mapping[str, Relation] = MappingProxyType({relation.name: relation for relation in _RELATIONS})

# For each relation, a scene of the words below in which its example holds: the tests evaluate them.
SCENES: Mapping[str, str] = MappingProxyType({
    "on": '(call "table") (transform (call "cup") (translate [-.3 1 0]))',
    "inside": '(call "mug") (transform (call "pencil") (@ (translate [.03 .1 0]) (rotate -.1 [0 0 1])))',
    "touching": '(call "wall") (transform (call "shelf") (translate [0 .8 .2]))',
    "clear-of": "(for/union ((x '(-1 -.3 .4))) (transform (call \"chair\") (translate (vector x 0 0))))",
    "distance": '(call "table") (transform (call "chair") (translate [0 0 .9]))',
    "angle": '(call "wall") (transform (call "door") (@ (translate [1 0 .5]) (rotate (/ pi 2) [0 1 0])))',
    "facing": '(call "table") (transform (call "chair") (@ (translate [-1.5 0 .3]) (rotate (/ pi 2) [0 1 0])))',
    "above": '(call "lamp") (transform (call "cup") (translate [0 .8 0]))',
    "below": '(transform (call "lamp") (translate [0 .5 0])) (call "cup")',
    "left-of": '(call "lamp") (transform (call "cup") (translate [-.6 0 0]))',
    "right-of": '(call "lamp") (transform (call "cup") (translate [.6 0 0]))',
    "in-front-of": '(call "lamp") (transform (call "cup") (translate [0 0 .6]))',
    "behind": '(call "lamp") (transform (call "cup") (translate [0 0 -.6]))',
    "between": '(call "candle") (transform (call "cup") (translate [-.6 0 0]))\n'
    '(transform (call "plate") (translate [.6 0 0]))',
    "aligned": "(for/union ((x '(-1 -.4 .7))) (transform (call \"pawn\") (translate (vector x 0 0))))",
    "evenly-spaced": "(for/union ((x '(-1 0 1))) (transform (call \"pawn\") (translate (vector x 0 0))))",
    "rows": "(for*/union ((x '(-1 0 1)) (z '(-.5 .5))) (transform (call \"chair\") (translate (vector x 0 z))))",
    "order": '(call "candle") (transform (call "cup") (translate [-.6 0 0]))\n'
    '(transform (call "plate") (translate [.6 0 0]))',
    "aspect": '(call "tower")',
    "elevation": '(call "wall") (transform (call "shelf") (translate [0 .8 .2]))',
    "encircles": '(call "table") (ring 6 (transform (call "chair") (rotate pi [0 1 0])) :radius 1.6)',
    "rising": "(for/union ((i (iota 4))) (transform (call \"plank\") (translate (vector (* .3 i) (* .2 i) 0))))",
    "proportion": '(call "table") (transform (call "chair") (translate [0 0 .9]))',
    "tilt": '(transform (call "candle") (rotate (deg 10) [0 0 1]))',
    "outline": '(call "plate")',
    "made-of": '(call "brick-wall")',
    "visible-from": '(call "table") (transform (call "candle") (translate [0 1 0]))\n'
    '(transform (call "chair") (translate [0 0 -1.2]))',
    "reachable": '(transform (call "door") (translate [-2 0 0])) (transform (call "lamp") (translate [2 0 0]))',
    "symmetric": '(call "table")\n(for/union ((x \'(-1.3 1.3))) (transform (call "chair") (translate (vector x 0 0))))',
    "supported": '(call "table") (transform (call "plate") (translate [0 1 0]))\n'
    '(transform (call "cup") (translate [0 1.04 0]))',
    "floating": '(call "table") (transform (call "lamp") (translate [0 1.2 0]))',
    "fastened": '(call "wall") (transform (call "shelf") (translate [0 .8 .2]))',
    "size": '(call "tower")',
    "count": "(for*/union ((x '(-1 0 1)) (z '(-.5 .5))) (transform (call \"chair\") (translate (vector x 0 z))))",
    "has-color": '(call "table") (transform (call "cup") (translate [0 1 0]))',
    "moves": '(call "table") (transform (call "cup") (translate (vector 0 (+ 1 (* .4 (sin (* pi t)))) 0)))',
    "path": '(call "table") (transform (call "cup") (translate (vector (- t .5) 1 (* .4 (- t .5)))))',
    "turns": '(call "wall") (transform (call "door") (@ (translate [1 0 .5]) (rotate (* t (/ pi 2)) [0 1 0])))',
})  # fmt: skip

_WORDS = {
    "table": '(union (transform (call "cube" :scale [2 .1 1]) (translate [0 .95 0])) (for*/union ((x \'(-.9 .9)) (z '
    '\'(-.4 .4))) (transform (call "cube" :scale [.1 .9 .1]) (translate (vector x .45 z)))))',
    "cup": '(call "cylinder" :radius .1 :p0 [0 0 0] :p1 [0 .22 0] :color (color "steelblue"))',
    "mug": '(lathe (polygon \'([0 0] [.2 0] [.2 .5] [.17 .5] [.17 .03] [0 .03])) :color (color "steelblue"))',
    "pencil": '(call "cylinder" :radius .015 :p0 [0 0 0] :p1 [0 .7 0] :color (color "gold"))',
    "wall": '(transform (call "cube" :scale [2 1.6 .1]) (translate [0 .8 -.05]))',
    "brick-wall": '(call "set-cuboid" :block-type "stone_bricks" :scale [4 2 1])',
    "shelf": '(call "cube" :scale [1.2 .06 .4] :color (color "peru"))',
    "door": '(transform (call "cube" :scale [.9 1.4 .06] :color (color "peru")) (translate [0 .7 0]))',
    "chair": '(union (transform (call "cube" :scale [.4 .4 .4] :color (color "peru")) (translate [0 .2 0])) (transform '
    '(call "cube" :scale [.4 .5 .06] :color (color "peru")) (translate [0 .65 -.17])))',
    "lamp": '(union (call "cylinder" :radius .15 :p0 [0 0 0] :p1 [0 .05 0]) (call "cylinder" :radius .03 :p0 [0 0 0] '
    ':p1 [0 .5 0]) (call "cone" :radius .2 :p0 [0 .4 0] :p1 [0 .7 0] :color (color "gold")))',
    "candle": '(call "cylinder" :radius .06 :p0 [0 0 0] :p1 [0 .5 0] :color (color "ivory"))',
    "plate": '(call "cylinder" :radius .25 :p0 [0 0 0] :p1 [0 .04 0])',
    "pawn": '(union (call "cone" :radius .2 :p0 [0 0 0] :p1 [0 .6 0]) (transform (call "sphere" :radius .13) '
    "(translate [0 .6 0])))",
    "plank": '(transform (call "cube" :scale [.3 .2 1]) (translate [0 .1 0]))',
    "tower": '(union (transform (call "cube" :scale [1 2.4 1]) (translate [0 1.2 0])) (call "cone" :radius .8 '
    ':p0 [0 2.4 0] :p1 [0 3.4 0] :color (color "tomato")))',
}


# Words that people write for relations, by the names that mean them.
_MEANT = {
    "beside next-to near close-to adjacent-to by far-from apart": ("touching", "distance", "left-of", "right-of"),
    "under underneath beneath": ("below", "on"),
    "over atop on-top on-top-of stacked": ("on", "above"),
    "in within contains encloses": ("inside", "encircles"),
    "parallel perpendicular tilted upright vertical": ("angle", "tilt"),
    "centered centred middle": ("between", "aligned", "symmetric"),
    "equal same-size same taller larger bigger smaller": ("proportion", "size"),
    "overlaps intersects collides": ("clear-of", "touching"),
    "stands stable rests attached": ("supported", "on", "fastened"),
}
_USUAL = ("on", "inside", "touching", "clear-of", "above", "left-of", "distance", "facing", "size", "count")


def relation_hint(name: str) -> str:
    """Return the hint for an unknown relation: those that its name means in other words, else the usual ones."""
    meant = next((names for words, names in _MEANT.items() if name in words.split()), None)
    if meant and not name.startswith("same"):
        others_meant = f", or {' or '.join(f'`{each}`' for each in meant[1:])}" if len(meant) > 1 else ""
        return f"did you mean `{RELATIONS[meant[0]].example}`{others_meant}?"
    listed = ", ".join(f"`{each}`" for each in meant or _USUAL)
    others = "others" if meant else f"{len(RELATIONS) - len(_USUAL)} more"
    return f"relations are {listed}, and {others} (docs/relations.md)"


def example_of(relation: Relation) -> str:
    """Return a program that states the example of a relation, which holds."""
    scene = SCENES[relation.name]
    words = [word for word in _WORDS if f'(call "{word}")' in scene]
    bound = [f'(bind "{word}" (lambda () {_WORDS[word]}))' for word in words]
    scene = f"(union {scene})"
    if relation.name in OVER_FRAMES:
        scene = f"(frames (for/list ((t '(0 .25 .5 .75 1))) {scene}))"
    return "\n".join([*bound, f'(bind "scene" (lambda () (assert-that {relation.example}) {scene}))\n(scene "scene")'])


FLAGS = frozenset({"any", "all", "negated", *FRAME_FLAGS})

# Basic color terms (Berlin and Kay, 1969): the hue in degrees at which each ends, for saturated colors that are neither
# dark nor pale.
_HUES = ((15, "red"), (46, "orange"), (75, "yellow"), (165, "green"), (200, "cyan"), (255, "blue"), (315, "purple"),
         (345, "pink"), (360, "red"))  # fmt: skip
COLORS = ("black", "white", "gray", "red", "orange", "brown", "yellow", "green", "cyan", "blue", "purple", "pink")
_MAX_BLACK_VALUE, _MAX_BLACK_GRAY_VALUE, _MIN_WHITE_VALUE = 0.2, 0.36, 0.85  # the second one of pale colors
_MAX_PALE_SATURATION = 0.15  # of white, grays and black; more saturated colors have a hue
_MAX_BROWN_VALUE, _MAX_BROWN_SATURATION = 0.72, 0.45  # a dark or a dull orange is brown
_MAX_RED_BROWN_VALUE, _MAX_RED_BROWN_SATURATION = 0.7, 0.78  # "brown" of CSS is a dark, dull red; "firebrick" is red
_MAX_OLIVE_VALUE = 0.6  # a dark yellow is green
_MAX_PINK_SATURATION, _MIN_PINK_VALUE = 0.5, 0.8  # a light, dull red is pink
_MAX_MAROON_VALUE = 0.5  # a dark pink is purple


def basic_color(color: Sequence[float]) -> str:
    """Return the name of a color in linear sRGB, one of the twelve ``COLORS``, by hue, saturation and value.

    >>> basic_color((0.0, 0.0, 1.0))
    'blue'
    """
    from colorsys import rgb_to_hsv

    r, g, b = (encoded(min(max(float(x), 0.0), 1.0)) for x in color)
    hue, saturation, value = rgb_to_hsv(r, g, b)
    is_pale = saturation < _MAX_PALE_SATURATION
    if value < (_MAX_BLACK_GRAY_VALUE if is_pale else _MAX_BLACK_VALUE):
        return "black"
    if is_pale:
        return "white" if value > _MIN_WHITE_VALUE else "gray"
    name = next(name for end, name in _HUES if 360.0 * hue <= end)
    if name == "orange" and (value < _MAX_BROWN_VALUE or saturation < _MAX_BROWN_SATURATION):
        return "brown"
    if name == "red" and value < _MAX_RED_BROWN_VALUE and saturation < _MAX_RED_BROWN_SATURATION:
        return "brown"
    if name == "yellow" and value < _MAX_OLIVE_VALUE:
        return "green"
    if name == "red" and saturation < _MAX_PINK_SATURATION and value > _MIN_PINK_VALUE:
        return "pink"
    return "purple" if name == "pink" and value < _MAX_MAROON_VALUE else name


@dataclass(frozen=True, slots=True)
class Declaration:
    """Relation between objects, stated about an entity or the scene.

    Attributes
    ----------
    relation
        Name of the relation, a key of ``RELATIONS``.
    things
        Operands: words, or handles such as "<z1>".
    number, term
        Further operand of relations that take one: a length, an angle, a ratio or a count; the name of a color, an
        outline, a path or a material.
    options
        Options by name; flags that are false are absent.
    span
        Where the program states it.
    """

    relation: str
    things: tuple[str, ...]
    number: float | None
    options: Mapping[str, Any]
    span: Span | None
    term: str | None = None

    def __str__(self) -> str:
        """Return the declaration as it is written."""
        parts = [self.relation, *(_written(name) for name in self.things)]
        if self.number is not None:
            parts.append(f"{self.number:g}")
        if self.term is not None:
            parts.append(_written(self.term))
        for name, value in self.options.items():
            if name in FLAGS:
                parts += [f":{name}"] if name != "negated" else []
            elif name != "message":
                parts += [f":{name}", _shown(value)]
        text = f"({' '.join(parts)})"
        return f"(not {text})" if self.options.get("negated") else text


def _shown(value: Any) -> str:
    """Return the value of an option as it is written."""
    if isinstance(value, tuple):
        return f"'({' '.join(f'{count:g}' for count in value)})"
    return _written(value) if isinstance(value, str) else f"{value:g}"


def _written(name: str) -> str:
    """Return a word in quotes, and a handle as it is."""
    return name if name.startswith("<") else f'"{name}"'
