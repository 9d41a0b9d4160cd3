from helper import *

"""
a skyline: widths and heights come from the lengths of formatted numbers
"""

VALUES = [3.14159, 42, 1e6, 0.001, -7.5, 299792458, 2 / 3]
FORMATS = [">8.2f", "<10", "^+9.1f", "e", ",.0f", ".3g", "08.1f", "%"]


def measure(value: float, spec: str) -> tuple[int, int, int]:
    text = format(value, spec)
    lead = len(text) - len(text.lstrip())
    trail = len(text) - len(text.rstrip())
    return lead, len(text.strip()), trail


@register()
def slab(lead: int, core: int, trail: int, tint: float) -> Shape:
    """Three stacked parts: spaces, characters, spaces."""
    parts, y = [], 0.0
    for n, color in ((trail, (0.3, 0.3, 0.35)), (core, (0.2 + 0.7 * tint, 0.5, 0.9 - 0.6 * tint)), (lead, (0.7, 0.7, 0.7))):
        if n:
            h = 0.15 * n
            parts.append(transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.4, h, 0.4)}), translation_matrix((0, y + h / 2, 0))))
            y += h
    return concat_shapes(*parts)


@register()
def signpost(text: str) -> Shape:
    words = text.split("|")
    post = primitive_call('cylinder', color=(0.4, 0.3, 0.2), shape_kwargs={'radius': 0.05, 'p0': (0, 0, 0), 'p1': (0, 0.3 * len(words) + 0.3, 0)})
    boards = [transform_shape(primitive_call('cube', color=(0.9, 0.85, 0.6), shape_kwargs={'scale': (0.08 * len(w), 0.2, 0.04)}), translation_matrix((0.04 * len(w), 0.3 * k + 0.3, 0))) for k, w in enumerate(words)]
    return concat_shapes(post, *boards)


@register()
def skyline() -> Shape:
    shapes = []
    for i, value in enumerate(VALUES):
        for j, spec in enumerate(FORMATS):
            lead, core, trail = measure(value, spec)
            shapes.append(transform_shape(library_call('slab', lead=lead, core=core, trail=trail, tint=j / len(FORMATS)), translation_matrix((0.6 * i, 0, 0.6 * j))))
    name, width, precision = "north", 10, 3
    texts = [
        f"{name!r:>{width}}|{name:-<{width}}|{value:.{precision}f}",
        f"{{literal}}|{1 == 1}|{None}",
        "%05d|%-8s|%.1f" % (42, name, 2.25),
        "{0}{1}{0}|{key:>6}|{2[1]}".format("ab", "c", [1, 22], key="k"),
        f"{value=:.2f}|{[1, 2.0]}|{(1,)}",
    ]
    for k, text in enumerate(texts):
        shapes.append(transform_shape(library_call('signpost', text=text), translation_matrix((1.6 * k - 1, 0, -1))))
    return concat_shapes(*shapes)
