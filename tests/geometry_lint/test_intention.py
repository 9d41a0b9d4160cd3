"""What is found to be unintended among siblings, and the variation that is left alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.geometry import symmetry
from scenelang.backends.geometry.intention import Intention, intentions
from scenelang.grammar.datum import Source
from scenelang.session.session import Session

session = Session()
WORDS = """
(bind "plim" (lambda ((:s 1) (:h 1)) (union
  (transform (call "cube" :scale (* s [.2 .3 .4])) (translate (* s [0 .15 0])))
  (transform (call "cube" :scale (* s (vector .2 (* .2 h) .1))) (translate (* s (vector 0 (+ .3 (* .1 h)) .15)))))))
(bind "post" (lambda () (call "cylinder" :radius .5 :p1 [0 2 0])))
(bind "peg" (lambda () (call "cylinder" :radius .05 :p0 [-.2 0 0] :p1 [.2 0 0])))
(bind "disc" (lambda () (call "cylinder" :radius .3 :p0 [-.04 0 0] :p1 [.04 0 0])))
(bind "leaf" (lambda () (transform (call "cube" :scale [.8 2 .04]) (translate [.4 1 0]))))
(bind "blade" (lambda (:turn)
  (transform (call "cube" :scale [.1 .8 .03]) (@ (rotate (- turn) [0 0 1]) (translate [0 1 0])))))
(bind "lid" (lambda () (call "cube" :scale [.5 .02 .4])))
(bind "box" (lambda () (call "cube" :scale [.5 .2 .4])))
(bind "pawn" (lambda ((:dx 0) (:knob #t)) (union
  (transform (call "cube" :scale [.4 .2 .4]) (translate [0 .1 0]))
  (call "cylinder" :radius .1 :p0 [0 .2 0] :p1 [0 .8 0])
  (transform (call "cube" :scale [.2 .2 .3]) (translate (vector dx .9 0)))
  (if knob (transform (call "cube" :scale .05) (translate [0 .1 .22])) (union)))))
"""


def analyzed(parts: str) -> tuple[FrameFacts, list[Intention]]:
    text = f'{WORDS} (bind "scene" (lambda () (union {parts}))) (scene "scene")'
    facts = FrameFacts(session.evaluate(Source("a.scene", text)).require().frames[0])
    return facts, intentions(facts)


def kinds(parts: str) -> list[str]:
    return [intention.kind for intention in analyzed(parts)[1]]


def placed(x: float, y: float, z: float, angle: float = 0.0, options: str = "", word: str = "plim") -> str:
    return f'(transform (call "{word}" {options}) (@ (translate [{x!r} {y!r} {z!r}]) (rotate {angle!r} [0 1 0])))'


def row(count: int, **changed: str) -> str:
    """Return ``count`` objects 1 apart, those with numbers in ``changed`` (such as n3) as given there."""
    return "".join(changed.get(f"n{i}", placed(i, 0.0, 0.0)) for i in range(count))


def ring(count: int, radius: float = 3.0, inward: float = 0.0, **changed: str) -> str:
    parts = []
    for i in range(count):
        angle = 2.0 * math.pi * i / count
        place = placed(radius * math.sin(angle), 0.0, radius * math.cos(angle), angle + inward)
        parts.append(changed.get(f"n{i}", place))
    return "".join(parts)


FAULTS = {
    "one of a row is turned": (row(7, n3=placed(3.0, 0.0, 0.0, 0.7)), "turn"),
    "one of a ring does not face the middle": (
        '(call "post")' + ring(8, n2=placed(3.0, 0.0, 0.0, 0.3)), "turn"),
    "one breaks the alternation": (
        "".join(placed(i, 0.0, 0.0, math.pi * (i % 2 if i != 5 else 0)) for i in range(9)), "turn"),
    "degrees for radians": (
        "".join(placed(i, 0.0, 0.0, 30.0 if i == 2 else math.radians(30.0)) for i in range(5)), "angle"),
    "an angle in degrees within the siblings": (
        "".join(f'(call "blade" :turn {a})' for a in (0, 90, math.pi, 1.5 * math.pi)), "angle"),
    "one mark of a dial": (
        "".join(f'(call "blade" :turn {120 if i == 4 else math.radians(30 * i)!r})' for i in range(12)), "angle"),
    "one lid beside its box": (
        "".join(placed(x, y, z + dz, word=word) for x, z, shift in ((0, 0, 0), (2.1, .7, .2), (3.3, 2.9, 0))
                for word, y, dz in (("box", 0.1, 0.0), ("lid", 0.21, shift))), "spacing"),
    "one is out of line": (row(6, n2=placed(2.0, 0.0, 0.4)), "spacing"),
    "one is out of its spacing": (row(8, n5=placed(5.4, 0.0, 0.0)), "spacing"),
    "one of two mirrored rows": (
        row(5) + "".join(placed(i + 0.4 * (i == 3), 0.0, 4.0) for i in range(5)), "spacing"),
    "one of four corners": ("".join(placed(x, 0.0, z) for x, z in ((0, 0), (2, 0), (0, 3), (2, 3.6))), "spacing"),
    "one is lower": (row(5, n2=placed(2.0, -0.3, 0.0)), "height"),
    "one step of a stair is higher": (
        "".join(placed(0.0, 0.2 * i + 0.08 * (i == 4), 0.3 * i, word="box") for i in range(8)), "height"),
    "one window is lower": (
        "".join(placed(x, 0.2 * (x == 5.6), 0.0, word="box") for x in (0.0, 1.3, 3.1, 5.6, 7.2, 9.9))
        .replace(" 0.0 0.0]", " 3.0 0.0]").replace(" 0.2 0.0]", " 2.9 0.0]")
        + '(transform (call "cube" :scale [14 4 2]) (translate [5 2 -1.2]))', "height"),
    "an angle of a ring in degrees": (
        ring(9, n4=placed(3.0 * math.sin(160.0), 0.0, 3.0 * math.cos(160.0), 160.0)), "angle"),
    "one chair of a table does not face it": (
        '(transform (call "cube" :scale [3 .7 1.2]) (translate [0 .35 0]))'
        + "".join(placed(x, 0.0, z, a) for x, z, a in (
            (-1, 1, 0.0), (0, 1, 1.2), (1, 1, 0.0), (-1, -1, math.pi), (0, -1, math.pi), (1, -1, math.pi))), "turn"),
    "a ring lacks one": (ring(12, n4=""), "count"),
    "a grid lacks one": (
        "".join(placed(x, 0.0, z) for x in range(5) for z in range(4) if (x, z) != (2, 1)), "count"),
    "one is ten times as large": (row(5, n3=placed(3.0, 0.0, 0.0, options=":s 10")), "size"),
    "one part is ten times as high": (row(5, n3=placed(3.0, 0.0, 0.0, options=":h 10")), "size"),
    "one of three is ten times as large": (row(2) + placed(5.0, 0.0, 3.0, options=":s 10"), "size"),
    "a pair of a grid of pairs": ("".join(placed(x, 0.0, z) for x in (-2.4, -0.8, 0.3, 2.4) for z in (0, 1)), "spacing"),
    "one of four is half as large again": (row(4, n2=placed(2.0, 0.0, 0.0, options=":s 1.5")), "size"),
    "one bare shape of a row is longer": (
        "".join(f'(transform (call "cube" :scale [.1 {h} .02]) (translate [{i} {h / 2} 0]))'
                for i, h in enumerate((1, 1, 1, 1, 1, 1.3, 1, 1, 1))), "size"),
    "one lacks a part": (
        "".join(placed(i, 0.0, 0.0, options=":knob #f" * (i == 2), word="pawn") for i in range(5)), "count"),
    "one has a part elsewhere": (
        "".join(placed(i, 0.0, 0.0, options=":dx .08" * (i == 3), word="pawn") for i in range(5)), "loose part"),
    "one is off its mirror image": (
        '(call "post")' + "".join(placed(x, 0.0, 0.0) for x in (-4.0, -2.1, -1.2, 1.2, 2.1, 4.5)), "symmetry"),
    "a disc beside its peg": (
        '(transform (call "cube" :scale [1 .2 3]) (translate [0 .4 0]))'
        + "".join(placed(x, 0.3, z, word="peg") for x in (-0.6, 0.6) for z in (-1.0, 1.0))
        + "".join(placed(x, 0.3, z, word="disc") for x, z in ((-0.7, -1), (-0.7, 1), (0.7, -1), (1.2, 1.0))), "loose part"),
}  # fmt: skip

SOUND = {
    "a row": row(8),
    "a row whose end is free": row(5) + placed(7.0, 0.0, 0.0),
    "a gap in the middle": row(9, n4=""),
    "a free middle": "".join(placed(x, 0.0, z) for x in range(3) for z in range(3) if (x, z) != (1, 1)),
    "one of three is twelve times as large": row(2) + placed(5.0, 0.0, 3.0, options=":s 12"),
    "a gap in which a post stands": row(9, n6='(transform (call "post") (translate [6 0 0]))'),
    "pushed a little": row(6, n2=placed(2.0, 0.0, 0.08)),
    "turned a little": row(6, n2=placed(2.0, 0.0, 0.0, 0.1)),
    "two out of line": row(8, n2=placed(2.0, 0.0, 0.3), n5=placed(5.0, 0.0, 0.4)),
    "a door ajar": "".join(placed(i, 0.0, 0.0, 0.6 * (i == 2), word="leaf") for i in range(5)),
    "a drawer that is open": (
        "".join(placed(0.0, 0.24 * i + 0.12, 0.2 * (i == 2), word="box") for i in range(5))
        + "".join(f'(transform (call "cube" :scale [.02 1.3 .4]) (translate [{x} .6 0]))' for x in (-0.26, 0.26))
    ),
    "a spiral stair": "".join(
        placed(math.sin(0.4 * i), 0.2 * i, math.cos(0.4 * i), 0.4 * i, word="box") for i in range(14)
    ),
    "each smaller than the one before": "".join(placed(i * 1.5, 0.0, 0.0, options=f":s {0.6**i!r}") for i in range(7)),
    "each farther than the one before": "".join(placed(1.3**i, 0.0, 0.0) for i in range(8)),
    "a round thing turned": "".join(placed(i, 0.0, 0.0, 0.7 * (i == 2), word="post") for i in range(0, 18, 2)),
    "lids that all lie otherwise": "".join(
        placed(x, y, z + dz, word=word)
        for x, z, shift in ((0, 0, 0), (2.1, 0.7, 0.1), (3.3, 2.9, 0.2))
        for word, y, dz in (("box", 0.1, 0.0), ("lid", 0.21, shift))
    ),
    "one of four elsewhere": row(3) + placed(6.0, 1.0, 4.0),
}


def part(x: float, y: float, z: float, shape: str = '"sphere" :radius .1') -> str:
    return f"(transform (call {shape}) (translate [{x} {y} {z}]))"


HEAD = [part(0.0, 0.5, 0.0, '"cube" :scale [.8 1 .6]'), part(0.0, 1.1, 0.0, '"cube" :scale [.5 .3 .4]')]
EARS, EYES = [part(x, 1.2, 0.0) for x in (-0.3, 0.3)], [part(x, 0.7, 0.35) for x in (-0.2, 0.2)]
LOPSIDED = {
    "an arm turned": [
        *HEAD, *EYES, *(f'(transform (call "cube" :scale [.3 .1 .1]) (@ (translate [{x} .6 0]) (rotate {angle} [0 0 1])))'
                        for x, angle in ((-0.5, 0.4), (0.5, 0.4)))],
    "an ear too low": [*HEAD, *EYES, EARS[0], part(0.3, 1.05, 0.0)],
    "an eye too small": [*HEAD, *EARS, EYES[0], part(0.2, 0.7, 0.35, '"sphere" :radius .06')],
    "an arm too thick": [
        *HEAD, *EYES, part(-0.5, 0.6, 0.0, '"cube" :scale [.3 .1 .1]'), part(0.5, 0.6, 0.0, '"cube" :scale [.3 .1 .2]')],
    "a hat beside the middle": [
        *HEAD, *EYES, part(0.04, 1.3, 0.0, '"cube" :scale [.3 .1 .3]')],
}  # fmt: skip
ONE_SIDED = {
    "a face": [*HEAD, *EARS, *EYES],
    "a handle on one side": [*HEAD, *EYES, part(0.45, 0.5, 0.0)],
    "a chimney": [*HEAD, *EYES, part(0.15, 1.3, 0.0, '"cube" :scale [.1 .3 .1]')],
    "parts of all sizes": [
        *HEAD,
        *(part(0.1 * i, 0.3 * i, 0.3, f'"sphere" :radius {0.1 + 0.03 * i}') for i in range(5)),
    ],
}


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize("name", LOPSIDED)
def test_a_part_that_breaks_the_symmetry_of_its_body(name: str, turn: float) -> None:
    _, (asymmetry,) = analyzed(f"(transform (union {' '.join(LOPSIDED[name])}) (rotate {turn} [0 1 0]))")
    assert asymmetry.kind == "symmetry"


def test_equal_objects_do_not_use_up_the_comparisons(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(symmetry, "_MAX_COMPARISONS", 300)
    words = f"""(bind "bear" (lambda () (union {" ".join(LOPSIDED["an ear too low"])})))"""
    copies = "".join(placed(3.0 * i, 0.0, 0.0, word="pawn") for i in range(40))
    text = f'{WORDS} {words} (bind "scene" (lambda () (union {copies} {placed(0.0, 0.0, 5.0, word="bear")})))'
    facts = FrameFacts(session.evaluate(Source("a.scene", text)).require().frames[0])
    assert [intention.kind for intention in intentions(facts)] == ["symmetry"]


@pytest.mark.parametrize("name", ONE_SIDED)
def test_what_is_on_one_side_on_purpose(name: str) -> None:
    assert kinds(" ".join(ONE_SIDED[name])) == []


@pytest.mark.parametrize("name", FAULTS)
def test_faults(name: str) -> None:
    parts, kind = FAULTS[name]
    assert kinds(parts) == [kind]


@pytest.mark.parametrize("name", SOUND)
def test_sound(name: str) -> None:
    assert kinds(SOUND[name]) == []


def test_evidence_names_the_rule_and_what_would_mend_it() -> None:
    facts, (turned,) = analyzed(FAULTS["one of a ring does not face the middle"][0])
    assert turned.evidence == 'is turned by 72.8 degrees: 7 of 8 "plim" face "post"'
    assert facts.ancestry.entity(turned.instance).word == "plim"
    assert facts.ancestry.position[turned.instance] == 3
    assert turned.turn == pytest.approx(math.pi / 2 - 0.3)
    assert turned.confidence >= 0.8
    _, (moved,) = analyzed(FAULTS["one is out of its spacing"][0])
    assert moved.evidence == 'is 0.4 from its place: 7 of 8 "plim" form a row'
    assert moved.move == pytest.approx((-0.4, 0.0, 0.0))
    assert len(moved.rows) == 2


class _Arrangement:
    """A random regular row, ring or grid of objects, at a random place, in a random direction and of a random scale."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        self.form = ("row", "ring", "grid")[seed % 3]
        self.scale = float(10.0 ** random.uniform(-2.0, 2.0))
        self.facing = float(random.uniform(0.0, 6.0))
        self.pose = (
            f"(@ (translate [{self.scale * 3.0!r} 0 {-self.scale!r}]) (rotate {float(random.uniform(0, 6))!r} [0 1 0]))"
        )
        if self.form == "ring":
            count = int(random.integers(6, 15))
            angles = 2.0 * math.pi * np.arange(count) / count
            radius = 0.5 / math.sin(math.pi / count)
            self.places = np.stack([radius * np.sin(angles), 0.0 * angles, radius * np.cos(angles)], axis=1)
            self.angles = angles + self.facing
        else:
            shape = (int(random.integers(6, 15)), 1) if self.form == "row" else tuple(random.integers(3, 7, 2).tolist())
            self.places = np.array([[x, 0.0, z] for x in range(shape[0]) for z in range(shape[1])], np.float64)
            self.angles = np.full(len(self.places), self.facing)
        self.odd = int(random.integers(1, len(self.places) - 1))
        direction = (
            float(random.uniform(0.0, 2.0 * math.pi))
            if self.form != "row"
            else float(random.choice([0.0, math.pi / 2]))
        )
        self.offset = np.array([math.cos(direction), 0.0, math.sin(direction)])

    def result(self, moved: float = 0.0, turned: float = 0.0) -> tuple[FrameFacts, list[Intention]]:
        places, angles = self.places.copy(), self.angles.copy()
        places[self.odd] += moved * self.offset
        angles[self.odd] += turned
        parts = (placed(*at, angle) for at, angle in zip((self.scale * places).tolist(), angles.tolist()))
        parts = (part.replace('"plim" ', f'"plim" :s {self.scale!r}') for part in parts)
        return analyzed(f"(transform (union {' '.join(parts)}) {self.pose})")


@pytest.mark.parametrize("seed", range(24))
def test_any_regular_arrangement(seed: int) -> None:
    arrangement = _Arrangement(seed)
    assert arrangement.result()[1] == []
    for moved, turned in ((0.3, 0.0), (0.0, math.radians(40.0))):
        facts, (odd,) = arrangement.result(moved, turned)
        assert odd.kind == ("turn" if turned else "spacing"), arrangement.form
        assert facts.ancestry.position[odd.instance] == arrangement.odd
        if odd.move is not None:
            assert np.linalg.norm(odd.move) == pytest.approx(moved * arrangement.scale, rel=0.05)


@pytest.mark.parametrize("seed", range(24))
def test_random_places_and_turns_are_left_alone(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(4, 40))
    places, angles = random.uniform(0.0, 10.0, (count, 3)), random.uniform(0.0, 6.0, count)
    flat = places * [1.0, 0.0, 1.0]
    sizes = random.uniform(0.5, 1.5, count)
    assert kinds("".join(placed(*at, angle) for at, angle in zip(flat.tolist(), angles.tolist()))) == []
    assert kinds("".join(placed(*at, 0.0, f":s {size!r}") for at, size in zip(places.tolist(), sizes.tolist()))) == []


def pairs(*turns: float) -> str:
    """Return boxes in two rows with a "plim" before each, turned as given."""
    places = [(-2.0, -1.5), (2.0, -1.5), (-2.0, 2.0), (2.0, 2.0)]
    return "".join(
        placed(x, 0.0, z, word="box") + placed(x, 0.0, z + 0.6, turn)
        for (x, z), turn in zip(places, turns, strict=True)
    )


def test_what_has_its_back_to_its_companion() -> None:
    (intention,) = analyzed(pairs(0.0, math.pi, 0.0, 0.0))[1]
    assert intention.kind == "turn"
    assert intention.evidence == 'is turned by 180 degrees beside "box": 3 of 4 "plim" are turned to theirs alike'
    assert intention.confidence < 0.8  # a note: somebody may have turned the chair


@pytest.mark.parametrize("turns", [(0.0,) * 4, (0.1, 2.0, 3.0, -1.0), (0.0, math.pi, 0.0, math.pi)])
def test_turns_beside_companions_that_are_no_slip(turns: tuple[float, ...]) -> None:
    assert kinds(pairs(*turns)) == []


@pytest.mark.parametrize("member", [0, 1, 2, 3])
@pytest.mark.parametrize("offset", [(0.0, 0.4, 0.0), (0.0, 0.0, -0.4)])
def test_one_of_four_beside_its_row(member: int, offset: tuple[float, float, float]) -> None:
    """Three in a row tell the place of the fourth between them as they do at their end."""
    x, y, z = (start + step for start, step in zip((member, 1.0, 0.0), offset, strict=True))
    assert kinds(
        row(4, **{f"n{i}": placed(i, 1.0, 0.0) for i in range(4) if i != member} | {f"n{member}": placed(x, y, z)})
    ) in (
        ["height"],
        ["spacing"],
    )
