"""an abacus (soroban) displaying the number 20251"""
from helper import *
from collections import defaultdict
from typing import Iterable

NUMBER = 20_251
RODS = 7
ROD_GAP, BEAD_R, BEAD_H = 0.6, 0.24, 0.2


def bead_layout(number: int, rods: int) -> dict[int, list[tuple[float, bool]]]:
    """rod index -> [(height, is_active)]"""
    layout = defaultdict(list)
    digits = f"{number:0{rods}d}"
    for rod, d in enumerate(map(int, digits)):
        five, ones = divmod(d, 5)
        layout[rod].append((0.35 if five else 0.75, bool(five)))
        for k in range(4):
            active = k < ones
            layout[rod].append((-0.35 - 0.25 * k - (0 if active else 0.3), active))
    return dict(layout)


@register()
def bead(active: bool = False) -> Shape:
    color = (0.85, 0.2, 0.15) if active else (0.55, 0.35, 0.2)
    return concat_shapes(*(primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y0, 0), 'p1': (0, y1, 0)}, color=color)
                           for r, y0, y1 in ((BEAD_R * 0.7, -BEAD_H / 2, 0), (BEAD_R, -BEAD_H / 4, BEAD_H / 4), (BEAD_R * 0.7, 0, BEAD_H / 2))))


@register()
def rod(beads: Iterable[tuple[float, bool]], top: float = 1.0, bottom: float = -1.7) -> Shape:
    wire = primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (0, bottom, 0), 'p1': (0, top, 0)}, color=(0.8, 0.8, 0.8))
    return concat_shapes(wire, *[transform_shape(library_call('bead', active=a), translation_matrix((0, y, 0))) for y, a in beads])


@register()
def frame(width: float, top: float = 1.0, bottom: float = -1.7) -> Shape:
    wood = (0.3, 0.17, 0.1)
    bars = [((width, 0.15, 0.4), (0, y, 0)) for y in (top, 0.08, bottom)]
    posts = [((0.15, top - bottom + 0.15, 0.4), (s * width / 2, (top + bottom) / 2, 0)) for s in (-1, 1)]
    return concat_shapes(*[transform_shape(primitive_call('cube', shape_kwargs={'scale': sc}, color=wood), translation_matrix(at)) for sc, at in bars + posts])


@register()
def abacus(number: int = NUMBER) -> Shape:
    layout = bead_layout(number, RODS)
    rods = [transform_shape(library_call('rod', beads=b), translation_matrix(((i - (RODS - 1) / 2) * ROD_GAP, 0, 0))) for i, b in layout.items()]
    return concat_shapes(library_call('frame', width=(RODS + 1) * ROD_GAP), *rods)
