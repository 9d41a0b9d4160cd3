from helper import *

"""
a cafe price board: each character of a formatted line is a small tile
"""

MENU = [("espresso", 2.4), ("flat white", 3.85), ("tea", 2), ("hot chocolate", 4.125), ("water", 0.5)]


def line(name: str, price: float, width: int = 20) -> str:
    dots = width - len(name) - len(f"{price:.2f}")
    return f"{name.title()}{'.' * dots}{price:.2f}"


def tile_color(ch: str) -> tuple:
    if ch.isupper():
        return (0.95, 0.6, 0.2)
    if ch.islower():
        return (0.95, 0.95, 0.9)
    if ch.isdigit():
        return (0.4, 0.9, 0.5)
    return (0.5, 0.5, 0.5)


@register("text row")
def text_row(text: str, pitch: float = 0.2) -> Shape:
    shapes = []
    for i, ch in enumerate(text):
        if ch == " ":
            continue
        size = 0.05 if ch in ".,:" else 0.16
        tile = primitive_call('cube', color=tile_color(ch), shape_kwargs={'scale': (size, size, 0.04)})
        shapes.append(transform_shape(tile, translation_matrix((pitch * i, 0, 0))))
    return concat_shapes(*shapes)


@register("price board")
def price_board() -> Shape:
    total = sum(price for _, price in MENU)
    average = total / len(MENU)
    rows = [line(*item) for item in MENU]
    rows += [
        f"{'TOTAL':<10}{total:>10.2f}",
        f"{'Mean':^10}{average:*^10.1f}",
        f"{len(MENU):03d} items, {average / total:.1%}",
        f"{1234567:,} {255:#x} {5:b}",
        f"{-3.14159:+.2e}|{2.5:>6}|",
        f"{'wide':>{12}}|{average!r:.6}",
    ]
    shapes = [transform_shape(library_call('text row', text=row), translation_matrix((-2, 3 - 0.4 * k, 0.05))) for k, row in enumerate(rows)]
    longest = max(map(len, rows))
    back = primitive_call('cube', color=(0.12, 0.15, 0.12), shape_kwargs={'scale': (0.2 * longest + 0.4, 0.4 * len(rows) + 0.4, 0.04)})
    shapes.append(transform_shape(back, translation_matrix((0.1 * longest - 2, 3 - 0.2 * len(rows) + 0.2, 0))))
    return concat_shapes(*shapes)
