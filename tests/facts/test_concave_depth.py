"""Penetration depths of concave bodies: by the translation that separates them where they cross."""

from __future__ import annotations

import pytest

import scenelang as sl
from scenelang.backends.facts.frame import facts_of
from scenelang.grammar.datum import Source
from scenelang.session.session import Session

CUP = "(lathe [[0 0] [4.5 0] [4.5 14] [4.1 14] [4.1 .5] [0 .5]] :opacity {opacity})"


def cups(step: float, opacity: float = 1.0) -> str:
    """Return the program of three thin-walled cups in a row on a board."""
    return f"""
    (bind "cup" (lambda () {CUP.format(opacity=opacity)}))
    (bind "shelf" (lambda () (union
      (transform (call "cube" :scale [80 4 30]) (translate [0 -2 0]))
      (for/union ((i (iota 3))) (transform (call "cup") (translate (vector (* i {step}) 0 0)))))))
    (scene "shelf")"""


def depths(text: str) -> list[float]:
    """Return the penetration depths of the contacts of a program's scene."""
    contacts = facts_of(sl.evaluate(text).root).contacts
    return [contacts.depth(row) for row in range(len(contacts))]


@pytest.mark.parametrize("step", [4.0, 7.0, 8.5])
def test_walls_that_cross_are_as_deep_as_the_cups(step: float) -> None:
    """The mean thickness of what two walls share says .1, however deep the cups are in each other."""
    assert max(depths(cups(step))) == pytest.approx(9.0 - step, rel=0.15)


def test_a_tight_fit_shares_a_layer() -> None:
    """A pin that is .01 thicker than its hole is not as deep in the plate as the plate is thick."""
    layers = depths("""
    (bind "plate" (lambda () (difference (call "cube" :scale [4 1 4]) (call "cylinder" :radius .5 :p0 [0 -1 0]))))
    (bind "pin" (lambda () (call "cylinder" :radius .51 :p0 [0 -2 0] :p1 [0 2 0])))
    (bind "fit" (lambda () (union (call "plate") (call "pin"))))
    (scene "fit")""")
    assert 0.0 < max(layers) < 0.05


def test_a_solid_within_another_leaves_by_the_shortest_way() -> None:
    """A frustum whose base is flush with the top of a case needs its own height."""
    inner = depths("""
    (bind "case" (lambda () (transform (call "cube" :scale [4 2 4]) (translate [0 1 0]))))
    (bind "weight" (lambda () (transform (loft (list (rectangle 1 1) (rectangle .4 .4)) :heights '(0 .8))
      (@ (translate [0 2 0]) (rotate (deg 90) [1 0 0])))))
    (bind "all" (lambda () (union (call "case") (call "weight"))))
    (scene "all")""")
    assert max(inner) == pytest.approx(0.8, rel=0.15)


@pytest.mark.parametrize("opacity", [1.0, 0.4])
def test_glass_is_no_medium(opacity: float) -> None:
    """Vessels in each other are a warning, whether one sees through them; in water it would be a note."""
    names = [diagnostic.name for diagnostic in Session().check_geometry(Source("a.scene", cups(7.0, opacity)))]
    assert "overlap" in names


GROUND = '(bind "ground" (lambda () (transform (call "cube" :scale [8 1 8]) (translate [0 -.5 0]))))'
SLEEVE = """(difference (call "cylinder" :radius {outer} :p1 [0 {high} 0]) (call "cylinder" :radius {inner} :p0 [0 -1 0] :p1 [0 2 0])
  (transform (call "cube" :scale [{slit} 3 4]) (translate [0 0 2])))"""


@pytest.mark.parametrize(
    ("body", "around"),
    [
        ('(call "cylinder" :radius .5 :p1 [0 1.2 0])', SLEEVE.format(outer=0.52, inner=0.49, high=0.6, slit=0.05)),
        ('(call "cylinder" :radius .5 :p1 [0 3 0])', SLEEVE.format(outer=0.57, inner=0.47, high=0.3, slit=0.8)),
        ('(transform (call "sphere" :radius .5) (translate [0 .5 0]))',
         '(transform (difference (call "sphere" :radius .51) (call "sphere" :radius .495)'
         ' (transform (call "cube" :scale [2 2 2]) (translate [0 -.9 0]))) (translate [0 .5 0]))'),
    ],
    ids=["sleeve with a slit", "clip", "helmet"],
)  # fmt: skip
def test_what_is_worn_tightly_is_not_sunk(body: str, around: str) -> None:
    """The way out of a sleeve is its height, however thin the layer that they share."""
    text = f"""{GROUND}
    (bind "body" (lambda () {body}))
    (bind "around" (lambda () {around}))
    (bind "all" (lambda () (union (call "ground") (call "body") (call "around"))))
    (scene "all")"""
    codes = [diagnostic.code for diagnostic in Session().check_geometry(Source("a.scene", text))]
    assert not {"W611", "W613"} & set(codes)
