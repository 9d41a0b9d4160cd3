"""What a block state looks like as a few boxes: slabs, stairs, fences, doors and the like in the game's measures.

Boxes are in sixteenths of the cell: x east, y up, z south. Blocks that face somewhere are written as they stand when
they face north, and turned.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from scenelang.backends.minecraft.blocks import SIDES, BlockState
from scenelang.backends.minecraft.table import BlockKind

Point = tuple[float, float, float]
Properties = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Bar:
    """The box from ``low`` to ``high``, turned by ``turn`` degrees about the vertical line through the cell's
    centre."""

    low: Point
    high: Point
    turn: float = 0.0

    def spans(self, axis: int) -> bool:
        """True where the box goes through the whole cell along ``axis``."""
        return self.turn == 0.0 and self.low[axis] == 0.0 and self.high[axis] == 16.0


WHOLE = (Bar((0.0, 0.0, 0.0), (16.0, 16.0, 16.0)),)


def model_of(state: BlockState, kind: BlockKind) -> tuple[Bar, ...]:
    """The boxes of a block with all of its properties; none for what cannot be seen."""
    if kind.color is None:
        return ()
    return _MODELS.get(kind.shape, _box)(kind, dict(state.properties))


def _bar(x0: float, y0: float, z0: float, x1: float, y1: float, z1: float) -> Bar:
    return Bar((x0, y0, z0), (x1, y1, z1))


def _turned(bar: Bar, quarters: int) -> Bar:
    """Quarter turns clockwise from above: what was north is east."""
    for _ in range(quarters % 4):
        (x0, y0, z0), (x1, y1, z1) = bar.low, bar.high
        bar = Bar((16.0 - z1, y0, x0), (16.0 - z0, y1, x1), bar.turn)
    return bar


def _facing(bars: tuple[Bar, ...], side: str) -> tuple[Bar, ...]:
    return tuple(_turned(bar, SIDES.index(side)) for bar in bars)


def _upside_down(bars: tuple[Bar, ...]) -> tuple[Bar, ...]:
    return tuple(_bar(*_with_y(bar.low, 16.0 - bar.high[1]), *_with_y(bar.high, 16.0 - bar.low[1])) for bar in bars)


def _with_y(point: Point, y: float) -> Point:
    return point[0], y, point[2]


# --- shapes of the game ----------------------------------------------------------------------------------------------


def _cube(_: BlockKind, __: Properties) -> tuple[Bar, ...]:
    return WHOLE


def _slab(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    low, high = {"bottom": (0, 8), "top": (8, 16), "double": (0, 16)}[has["type"]]
    return (_bar(0, low, 0, 16, high, 16),)


# The upper boxes of stairs that face north: the step goes up to the north.
_STEPS = {
    "straight": (_bar(0, 8, 0, 16, 16, 8),),
    "outer_left": (_bar(0, 8, 0, 8, 16, 8),),
    "outer_right": (_bar(8, 8, 0, 16, 16, 8),),
    "inner_left": (_bar(0, 8, 0, 16, 16, 8), _bar(0, 8, 8, 8, 16, 16)),
    "inner_right": (_bar(0, 8, 0, 16, 16, 8), _bar(8, 8, 8, 16, 16, 16)),
}


def _stairs(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    bars = _facing((_bar(0, 0, 0, 16, 8, 16), *_STEPS[has["shape"]]), has["facing"])
    return _upside_down(bars) if has["half"] == "top" else bars


def _fence(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    arms = (_bar(7, 6, 0, 9, 9, 6), _bar(7, 12, 0, 9, 15, 6))
    return (_bar(6, 0, 6, 10, 16, 10), *_arms(arms, [side for side in SIDES if has[side] == "true"]))


def _pane(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    return (_bar(7, 0, 7, 9, 16, 9), *_arms((_bar(7, 0, 0, 9, 16, 7),), [s for s in SIDES if has[s] == "true"]))


def _wall(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    post = (_bar(4, 0, 4, 12, 16, 12),) if has["up"] == "true" else (_bar(5, 0, 5, 11, 14, 11),)
    low = _arms((_bar(5, 0, 0, 11, 14, 8),), [side for side in SIDES if has[side] == "low"])
    return (*post, *low, *_arms((_bar(5, 0, 0, 11, 16, 8),), [side for side in SIDES if has[side] == "tall"]))


def _arms(north: tuple[Bar, ...], sides: list[str]) -> tuple[Bar, ...]:
    return tuple(bar for side in sides for bar in _facing(north, side))


def _gate(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    posts = (_bar(0, 5, 7, 2, 16, 9), _bar(14, 5, 7, 16, 16, 9))
    if has["open"] == "true":
        wings = tuple(_bar(x, y, 1, x + 2, y + 3, 7) for x in (0, 14) for y in (6, 12))
    else:
        wings = tuple(_bar(2, y, 7, 14, y + 3, 9) for y in (6, 12))
    return _facing((*posts, *wings), has["facing"])


def _door(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """A shut door stands at the side that it faces away from; an open one at its hinge."""
    turn = 0 if has["open"] == "false" else 1 if has["hinge"] == "left" else 3
    return (_turned(_bar(0, 0, 13, 16, 16, 16), SIDES.index(has["facing"]) + turn),)


def _trapdoor(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    if has["open"] == "true":
        return _facing((_bar(0, 0, 13, 16, 16, 16),), has["facing"])
    return (_bar(0, 13, 0, 16, 16, 16) if has["half"] == "top" else _bar(0, 0, 0, 16, 3, 16),)


def _fluid(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Whole cells, save where it flows; the game's sources are two sixteenths lower where they are open above."""
    level = int(has.get("level", "0"))
    return (_bar(0, 0, 0, 16, round((8 - level) / 8 * 16), 16),) if 0 < level < 8 else WHOLE


def _plant(kind: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Two thin sheets across the diagonals."""
    goes_on = kind.name.endswith(("sugar_cane", "_plant")) or has.get("half") == "lower"
    high = 16.0 if goes_on else 13.0
    sheet = (0.0, 0.0, 7.8), (16.0, high, 8.2)
    return Bar(*sheet, turn=45.0), Bar(*sheet, turn=-45.0)


# --- thin things, by their names -------------------------------------------------------------------------------------

_BOARD = _bar(0, 7, 7.4, 16, 16, 8.6)
_THIN: tuple[tuple[str, tuple[Bar, ...]], ...] = (
    ("wall_torch", (_bar(7, 3, 11, 9, 13, 14),)),
    ("torch", (_bar(7, 0, 7, 9, 10, 9),)),
    ("wall_hanging_sign", (_bar(1, 0, 7, 15, 10, 9), _bar(0, 14, 6, 16, 16, 10))),
    ("hanging_sign", (_bar(1, 0, 7, 15, 10, 9), _bar(2, 10, 7.6, 14, 16, 8.4))),
    ("wall_sign", (_bar(0, 4.5, 14, 16, 12.5, 16),)),
    ("_sign", (_BOARD, _bar(7.4, 0, 7.4, 8.6, 7, 8.6))),
    ("wall_banner", (_bar(1, 0, 14, 15, 14, 15),)),
    ("_banner", (_bar(1, 2, 7, 15, 16, 8), _bar(7.5, 0, 8, 8.5, 16, 9))),
    ("pressure_plate", (_bar(1, 0, 1, 15, 1, 15),)),
    ("lever", (_bar(5, 0, 4, 11, 3, 12), _bar(7, 1, 5, 9, 9, 7))),
    ("_button", (_bar(5, 0, 6, 11, 2, 10),)),
    ("tripwire_hook", (_bar(6, 1, 8, 10, 9, 16),)),
    ("fire", (Bar((0, 0, 7.8), (16, 14, 8.2), 45.0), Bar((0, 0, 7.8), (16, 14, 8.2), -45.0))),
    ("coral_wall_fan", (_bar(0, 4, 5, 16, 12, 16),)),
    ("powder_snow", WHOLE),
    ("end_portal", (_bar(0, 6, 0, 16, 12, 16),)),
    ("portal", (_bar(0, 0, 6, 16, 16, 10),)),
    ("end_gateway", WHOLE),
    ("dripleaf", (_bar(5, 0, 5, 11, 13, 11),)),
    ("_stem", (_bar(7, 0, 7, 9, 8, 9),)),
    ("seagrass", (Bar((0, 0, 7.8), (16, 12, 8.2), 45.0), Bar((0, 0, 7.8), (16, 12, 8.2), -45.0))),
    ("spore_blossom", (_bar(1, 13, 1, 15, 16, 15),)),
)
_FLAT = (_bar(0, 0, 0, 16, 1, 16),)  # rails, redstone, petals and the like
_SHEETS = ("up", "down", *SIDES)  # where vines and lichens grow


def _thin(kind: BlockKind, has: Properties) -> tuple[Bar, ...]:
    if kind.name.endswith(("vine", "lichen", "resin_clump")):
        return tuple(_sheet(side) for side in _SHEETS if has.get(side) == "true") or (_sheet("down"),)
    bars = next((bars for name, bars in _THIN if name in kind.name), _FLAT)
    if "face" in has:
        bars = _fixed(bars, has["face"])
    if has.get("facing") in SIDES:
        return _facing(bars, has["facing"])
    if has.get("axis") == "z":
        return _facing(bars, "east")
    if "rotation" in has:  # sixteenths of a full turn, clockwise from south
        return tuple(Bar(bar.low, bar.high, -22.5 * int(has["rotation"])) for bar in bars)
    return bars


def _sheet(side: str) -> Bar:
    if side in ("up", "down"):
        return _bar(0, 15.5, 0, 16, 16, 16) if side == "up" else _bar(0, 0, 0, 16, 0.5, 16)
    return _turned(_bar(0, 0, 0, 16, 16, 0.5), SIDES.index(side))


def _fixed(bars: tuple[Bar, ...], face: str) -> tuple[Bar, ...]:
    """Buttons and levers, which lie on the floor as they are written, at a wall behind them or at the ceiling."""
    if face == "ceiling":
        return _upside_down(bars)
    if face == "wall":
        return tuple(
            _bar(bar.low[0], bar.low[2], 16 - bar.high[1], bar.high[0], bar.high[2], 16 - bar.low[1]) for bar in bars
        )
    return bars


# --- everything else -------------------------------------------------------------------------------------------------


def _box(kind: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """The box that stops a walker, which the table has for the default state, turned to where the block faces."""
    if "layers" in has:
        return (_bar(0, 0, 0, 16, 2 * int(has["layers"]), 16),)
    x0, y0, z0, x1, y1, z1 = (min(16, max(0, side)) for side in kind.box or (0, 0, 0, 16, 2, 16))
    bar = _bar(x0, y0, z0, x1, y1, z1)
    along = {"north": "z", "south": "z", "east": "x", "west": "x"}.get(has.get("facing", ""), has.get("axis", "y"))
    upright = kind.defaults.get("axis") == "y" or kind.defaults.get("facing") in ("up", "down")
    if upright:
        return (_laid(bar, along),)
    if has.get("facing") in SIDES and kind.defaults["facing"] in SIDES:
        return (_turned(bar, SIDES.index(has["facing"]) - SIDES.index(kind.defaults["facing"])),)
    return (bar,)


def _laid(bar: Bar, axis: str) -> Bar:
    """An upright box laid down along x or z."""
    (x0, y0, z0), (x1, y1, z1) = bar.low, bar.high
    if axis == "x":
        return Bar((y0, x0, z0), (y1, x1, z1))
    return Bar((x0, z0, y0), (x1, z1, y1)) if axis == "z" else bar


_MODELS: Mapping[str, Callable[[BlockKind, Properties], tuple[Bar, ...]]] = {
    "cube": _cube, "slab": _slab, "stairs": _stairs, "fence": _fence, "pane": _pane, "wall": _wall, "gate": _gate,
    "door": _door, "trapdoor": _trapdoor, "fluid": _fluid, "plant": _plant, "thin": _thin, "box": _box,
}  # fmt: skip
