from helper import *

"""
a sailing ship described by drawing commands
"""

COMMANDS: list = [
    ("box", (4, 0.6, 1.2), (0, 0, 0), "brown"),
    ("box", 0.5, (1.2, 0.5, 0), "white"),
    ("rod", (0, 0, 0), (0, 3, 0)),
    ("rod", (-1.2, 0, 0), (-1.2, 2.4, 0), 0.04),
    ("repeat", 4, (-0.9, 0, 0.62), (0.6, 0, 0), ("ball", 0.1)),
    {"op": "sail", "mast": 0.0, "height": 2.6},
    {"op": "sail", "mast": -1.2, "height": 2.0, "color": "red"},
    ("ball", 0.15, (0, 3, 0), "gold"),
    "anchor",
    ["group", ("ball", 0.2, (2.4, -0.1, 0)), ("rod", (2, 0, 0), (3, 0.5, 0))],
    42,
]

PALETTE = {"brown": (0.4, 0.25, 0.12), "white": (0.95, 0.95, 0.9), "red": (0.8, 0.15, 0.1), "gold": (0.9, 0.7, 0.2)}


def at(shape, offset):
    return transform_shape(shape, translation_matrix(offset))


@register("drawing of one command")
def draw(command) -> Shape:
    match command:
        case ("box", (int() | float() as w, h, d), position, str(color)):
            return at(primitive_call('cube', color=PALETTE[color], shape_kwargs={'scale': (w, h, d)}), position)
        case ("box", size, position, color) if size > 0:
            return at(primitive_call('cube', color=PALETTE[color], shape_kwargs={'scale': (size, size, size)}), position)
        case ("rod", start, end, *rest):
            radius = rest[0] if rest else 0.06
            return primitive_call('cylinder', color=PALETTE["brown"], shape_kwargs={'radius': radius, 'p0': start, 'p1': end})
        case ["ball", r, *options]:
            match options:
                case []:
                    return primitive_call('sphere', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': r})
                case [(x, y, z)]:
                    return at(primitive_call('sphere', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': r}), (x, y, z))
                case [position, color]:
                    return at(primitive_call('sphere', color=PALETTE[color], shape_kwargs={'radius': r}), position)
        case ("repeat", n, start, step, inner):
            return loop(n, lambda i: at(draw(inner), [s + i * d for s, d in zip(start, step)]))
        case {"op": "sail", "mast": x, "height": h, **options}:
            color = PALETTE[options.get("color", "white")]
            return loop(3, lambda i: at(primitive_call('cube', color=color, shape_kwargs={'scale': (0.04, h / 4, 1.4 - 0.3 * i)}), (x + 0.1, 0.6 + (i + 0.5) * h / 3.5, 0)))
        case ["group", *members]:
            return concat_shapes(*map(draw, members))
        case "anchor" | "ballast":
            return at(primitive_call('cube', color=(0.2, 0.2, 0.2), shape_kwargs={'scale': (0.2, 0.4, 0.2)}), (1.8, -0.4, 0.6))
        case _:
            return concat_shapes()


@register("sailing ship")
def ship() -> Shape:
    return concat_shapes(*(library_call('draw', command=c) for c in COMMANDS))
