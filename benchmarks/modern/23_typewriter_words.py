"""a keyboard with lettered keycaps and highlighted WASD"""
from helper import *
from typing import NamedTuple, Optional
import string


class Key(NamedTuple):
    label: str
    x: float
    row: int
    width: float = 1.0
    accent: Optional[tuple[float, float, float]] = None

    @property
    def is_letter(self) -> bool:
        return len(self.label) == 1 and self.label in string.ascii_uppercase


ROWS = [
    "ESC:1 1 2 3 4 5 6 7 8 9 0 - = BACK:2",
    "TAB:1.5 Q W E R T Y U I O P [ ] \\:1.5",
    "CAPS:1.75 A S D F G H J K L ; ' ENTER:2.25",
    "SHIFT:2.25 Z X C V B N M , . / SHIFT:2.75",
    "CTRL:1.25 WIN:1.25 ALT:1.25 SPACE:6.25 ALT:1.25 FN:1.25 MENU:1.25 CTRL:1.25",
]


def parse_rows(rows: list[str]) -> list[Key]:
    keys = []
    for r, row in enumerate(rows):
        x = 0.0
        for token in row.split():
            label, sep, width = token.partition(':')
            w = float(width) if sep else 1.0
            accent = (0.9, 0.35, 0.1) if label in {*'WASD', 'ESC', 'ENTER'} else None
            keys.append(Key(label, x + w / 2, r, w, accent))
            x += w
    return keys


KEYS = parse_rows(ROWS)


@register()
def keycap(label: str = 'A', width: float = 1.0, color=(0.9, 0.9, 0.88), height: float = 0.4) -> Shape:
    skirt = primitive_call('cube', shape_kwargs={'scale': (width - 0.08, height, 0.92)}, color=tuple(0.85 * c for c in color))
    top = primitive_call('cube', shape_kwargs={'scale': (width - 0.28, 0.1, 0.7)}, color=color)
    parts = [skirt, transform_shape(top, translation_matrix((0, height / 2 + 0.05, 0)))]
    if label in ('F', 'J'):  # homing bumps
        bump = primitive_call('cube', shape_kwargs={'scale': (0.3, 0.04, 0.05)}, color=(0.2, 0.2, 0.2))
        parts.append(transform_shape(bump, translation_matrix((0, height / 2 + 0.12, 0.25))))
    return concat_shapes(*parts)


@register()
def key_row(row: int) -> Shape:
    members = [k for k in KEYS if k.row == row]
    out: list = []
    for k in members:
        color = k.accent or ((0.92, 0.92, 0.9) if k.is_letter else (0.55, 0.57, 0.6))
        out += transform_shape(library_call('keycap', label=k.label, width=k.width, color=color),
                               translation_matrix((k.x, 0.05 * (4 - row), row)))
    return out


@register()
def keyboard() -> Shape:
    rows = loop(len(ROWS), lambda r: library_call('key_row', row=r))
    width = max(k.x + k.width / 2 for k in KEYS)
    chassis = primitive_call('cube', shape_kwargs={'scale': (width + 0.6, 0.4, len(ROWS) + 0.6)}, color=(0.15, 0.15, 0.17))
    chassis = transform_shape(chassis, translation_matrix((width / 2, -0.35, (len(ROWS) - 1) / 2)))
    whole = concat_shapes(chassis, rows)
    return transform_shape(whole, rotation_matrix(0.1, (1, 0, 0), compute_shape_center(whole)))
