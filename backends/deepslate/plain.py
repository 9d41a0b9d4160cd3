"""What stands for a block that no looks draw: boxes of its average colour, those of the other renderers."""

from __future__ import annotations

import numpy as np

from scenelang.backends.deepslate.atlas import Pixels
from scenelang.backends.deepslate.models import Json
from scenelang.backends.minecraft.blocks import BlockState
from scenelang.backends.minecraft.models import Bar, model_of
from scenelang.backends.minecraft.table import load_table

_FACES = {"west": (0, 0.0), "down": (1, 0.0), "north": (2, 0.0), "east": (0, 16.0), "up": (1, 16.0), "south": (2, 16.0)}
_SIDE = 16  # pixels


def plain_model(state: BlockState, texture: str) -> Json:
    """The flat model of ``state``, with ``texture`` on every face; without boxes for what cannot be seen."""
    return {"elements": [_element(bar, texture) for bar in model_of(state, load_table().blocks[state.name])]}


def plain_texture(state: BlockState) -> Pixels:
    """One colour everywhere, as opaque as the block is."""
    kind = load_table().blocks[state.name]
    color = [*(kind.color or (0, 0, 0)), round(255 * kind.opacity)]
    return np.tile(np.array(color, np.uint8), (_SIDE, _SIDE, 1))


def _element(bar: Bar, texture: str) -> Json:
    faces: dict[str, Json] = {side: {"texture": texture, "rotation": 0} for side in _FACES}
    for side, (axis, border) in _FACES.items():
        if bar.turn == 0.0 and (bar.low if border == 0.0 else bar.high)[axis] == border:
            faces[side]["cullface"] = side
    element: Json = {"from": list(bar.low), "to": list(bar.high), "faces": faces}
    if bar.turn:
        element["rotation"] = {"origin": [8.0, 8.0, 8.0], "axis": "y", "angle": bar.turn, "rescale": False}
    return element
