"""Scenes of one primitive of every kind that are thin, tiny, huge, mirrored or equally named, with their volumes."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, prod

# Programs of forms in about the unit cube; volumes, of the rounded cube by Steiner's formula; for a unit of mass, the
# least principal moment or, of the rounded cube, less.
_FORMS = {
    "cube": ('(call "cube")', 1.0, 1 / 6),
    "sphere": ('(call "sphere" :radius .5)', pi / 6, 0.1),
    "cylinder": ('(call "cylinder" :radius .5 :p0 [0 -.5 0] :p1 [0 .5 0])', pi / 4, 0.125),
    "cone": ('(call "cone" :radius .5 :p0 [0 -.5 0] :p1 [0 .5 0])', pi / 12, 0.075),
    "torus": ('(call "torus" :radius .5 :tube .01)', pi**2 * 1e-4, 0.125),
    "capsule": ('(call "capsule" :radius .25 :p0 [0 -.25 0] :p1 [0 .25 0])', pi / 32 + pi / 48, 0.02875),
    "rounded-cube": ('(call "rounded-cube" :radius .1)', 0.896 + 0.024 * pi + 0.004 / 3 * pi, 0.1),
}
# Poses, and the factors by which they change lengths along each axis.
_POSES = {
    "thin": ("(scale [1 .001 1])", (1, 1e-3, 1)),
    "thinner": ("(scale [1 1e-4 1])", (1, 1e-4, 1)),
    "thin-aslant": ("(@ (rotate .6 [1 2 .5]) (scale [1 .001 1]))", (1, 1e-3, 1)),
    "thinner-aslant": ("(@ (rotate 1.1 [.3 .2 1]) (scale [1 1 1e-4]))", (1, 1, 1e-4)),
    "rod": ("(scale [1 .001 .001])", (1, 1e-3, 1e-3)),
    "tiny": ("(scale .001)", (1e-3, 1e-3, 1e-3)),
    "huge": ("(scale 1000)", (1e3, 1e3, 1e3)),
    "mirrored": ("(@ (rotate .6 [1 2 .5]) (scale [-1 .5 .7]))", (1, 0.5, 0.7)),
    "inverted": ("(scale -1)", (1, 1, 1)),
}
_ROW = ["part", "part", "part.0", "part 0", "part"]


@dataclass(frozen=True)
class Extreme:
    """A program, the volume of all its bodies, their number, and the least principal moment for a unit of mass."""

    text: str
    volume: float
    least: float
    bodies: int = 1


def _posed(kind: str, pose: str) -> Extreme:
    form, volume, least = _FORMS[kind]
    how, factors = _POSES[pose]
    text = f'(bind "part" (lambda () (transform {form} {how})))'
    return Extreme(text, volume * prod(factors), least * min(factors) ** 2)


def _named(kind: str) -> Extreme:
    form, volume, least = _FORMS[kind]
    binds = "".join(f'(bind "{word}" (lambda () {form}))' for word in dict.fromkeys(_ROW))
    parts = " ".join(f'(transform (call "{word}") (translate [{2 * i} 0 0]))' for i, word in enumerate(_ROW))
    return Extreme(f'{binds}(bind "row" (lambda () (union {parts})))', volume * len(_ROW), least, len(_ROW))


EXTREMES = {f"{kind}-{pose}": _posed(kind, pose) for kind in _FORMS for pose in _POSES}
EXTREMES |= {f"{kind}-equal": _named(kind) for kind in _FORMS}
