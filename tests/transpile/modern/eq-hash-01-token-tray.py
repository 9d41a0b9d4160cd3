from helper import *

"""
game tokens sorted into stacks by equality and hash
"""

class Token:
    def __init__(self, color: str, value: int):
        self.color = color
        self.value = value

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Token):
            return NotImplemented
        return (self.color, self.value) == (other.color, other.value)

    def __hash__(self) -> int:
        return hash((len(self.color), self.value))

    def __lt__(self, other: "Token") -> bool:
        return (self.value, self.color) < (other.value, other.color)

    def __repr__(self) -> str:
        return f"<{self.color} {self.value}>"

RGB = {"red": (0.8, 0.1, 0.1), "blue": (0.1, 0.2, 0.8), "green": (0.1, 0.6, 0.2), "black": (0.1, 0.1, 0.1)}

DRAWN = [
    Token("red", 5), Token("blue", 10), Token("red", 5), Token("green", 25), Token("blue", 10), Token("black", 100),
    Token("red", 5), Token("green", 25), Token("red", 1), Token("blue", 10), Token("blue", 10), Token("black", 100),
]

@register()
def token(color: str, value: int) -> Shape:
    radius = 0.3 + 0.001 * value
    disc = primitive_call('cylinder', color=RGB[color], shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, 0.1, 0)})
    core = primitive_call('cylinder', color=(1, 1, 1), shape_kwargs={'radius': radius / 2, 'p0': (0, 0.005, 0), 'p1': (0, 0.105, 0)})
    return concat_shapes(disc, core)

@register()
def token_tray() -> Shape:
    stacks: Dict[Token, int] = {}
    for t in DRAWN:
        stacks[t] = stacks.get(t, 0) + 1
    kinds = sorted(set(DRAWN))
    assert kinds == sorted(stacks) and Token("red", 2) not in stacks and Token("red", 5) != "red 5"
    print(kinds, max(kinds), DRAWN.index(Token("green", 25)))
    shapes = []
    for column, kind in enumerate(kinds):
        for level in range(stacks[kind]):
            piece = library_call('token', color=kind.color, value=kind.value)
            shapes.append(transform_shape(piece, translation_matrix((column * 0.9, level * 0.11, 0))))
    tray = primitive_call('cube', color=(0.4, 0.25, 0.15), shape_kwargs={'scale': (0.9 * len(kinds) + 0.2, 0.1, 1.2)})
    first_blue = DRAWN.index(Token("blue", 10))
    marker = primitive_call('sphere', color=(1, 0.9, 0.2), shape_kwargs={'radius': 0.12})
    return concat_shapes(
        transform_shape(tray, translation_matrix((0.45 * (len(kinds) - 1), -0.05, 0))),
        *shapes,
        transform_shape(marker, translation_matrix((0.9 * kinds.index(DRAWN[first_blue]), 0.1, 0.8))),
    )
