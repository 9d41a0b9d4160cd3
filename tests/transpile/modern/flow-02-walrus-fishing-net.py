import math
from helper import *

"""
a fishing harbor at work: nets, buoys and a queue of crates
"""

CATCH = ["cod 12", "", "herring 30", "crab 4", "# night shift", "cod 7", "squid x", "tuna 2", "end", "shark 99"]

def read_catch(lines):
    pending = lines[::-1]
    landed: dict = {}
    bad = 0
    while (line := pending.pop() if pending else "end") != "end":
        if not line or line.startswith("#"):
            continue
        name, amount = line.split()
        if not amount.isdigit():
            bad += 1
            continue
        landed[name] = landed.get(name, 0) + int(amount)
    return landed, bad, len(pending)

@register()
def net(width: int, drop: float) -> Shape:
    def knot(i, j):
        return (0.4 * i, -0.4 * j + drop * math.sin(i * math.pi / width) * -1, 0)
    cords = []
    for i in range(width + 1):
        for j in range(3):
            here = knot(i, j)
            if i < width:
                cords.append((here, knot(i + 1, j)))
            if j + 1 < 3 and not (i == 0 or i == width):
                cords.append((here, knot(i, j + 1)))
    return concat_shapes(*[primitive_call('cylinder', color=(0.2, 0.5, 0.5), shape_kwargs={'radius': 0.015, 'p0': a, 'p1': b}) for a, b in cords])

@register()
def crate_stack(amount: int, color: tuple) -> Shape:
    crates = []
    level = 0
    while amount > 0:
        take = min(amount, 10)
        amount -= take
        h = 0.05 * take
        crates.append(transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.8, h, 0.6)}), translation_matrix((0, 0.55 * level + h / 2, 0))))
        level += 1
    return concat_shapes(*crates)

@register()
def harbor_quay() -> Shape:
    landed, bad, left = read_catch(CATCH)
    assert (n := len(landed)) == 4 and 0 < bad <= left <= 1 < n
    shapes = [transform_shape(library_call('net', width=w, drop=0.3 * k), translation_matrix((3 * k, 2, -1))) for k, w in enumerate((5, 6))]
    for k, (name, amount) in enumerate(sorted(landed.items(), key=lambda kv: (-kv[1], kv[0]))):
        shapes.append(transform_shape(library_call('crate_stack', amount=amount, color=(0.9 - 0.2 * k, 0.5, 0.1 + 0.2 * k)), translation_matrix((1.2 * k, 0, 0.5))))
    buoys = [b for a in range(12) if (b := round(math.cos(a), 3)) > 0.2]
    shapes += [transform_shape(primitive_call('sphere', color=(1, 0.4, 0.1), shape_kwargs={'radius': 0.1 + 0.1 * b}), translation_matrix((0.9 * i, -0.4, 2))) for i, b in enumerate(buoys)]
    longest = max((len(m), m) for m in landed)[1] if any(v > (top := 25) for v in landed.values()) else "none"
    shapes.append(transform_shape(primitive_call('cube', color=(0.5, 0.5, 0.5), shape_kwargs={'scale': (len(longest), 0.1, top / 10)}), translation_matrix((2, -0.1, 0))))
    return concat_shapes(*shapes)
