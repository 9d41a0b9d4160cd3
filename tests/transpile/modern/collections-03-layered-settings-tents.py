from collections import ChainMap, UserDict, deque
from helper import *

"""
a campsite whose tents take their look from layered settings
"""

DEFAULTS = {"color": (0.3, 0.5, 0.3), "width": 1.6, "height": 1.2, "pegs": 4, "flag": False}
GROUPS = {
    "scouts": {"color": (0.8, 0.6, 0.2), "flag": True},
    "families": {"width": 2.4, "height": 1.6},
}
TENTS = [("scouts", {}), ("scouts", {"pegs": 6}), ("families", {"color": (0.7, 0.2, 0.2)}), ("families", {"flag": True, "height": 2.0}), ("solo", {"width": 1.0})]


class Inventory(UserDict):
    """A dictionary that counts how often each key is read."""

    def __init__(self, *args, **kwargs):
        self.reads = {}
        super().__init__(*args, **kwargs)

    def __getitem__(self, key):
        self.reads[key] = self.reads.get(key, 0) + 1
        return super().__getitem__(key)


@register()
def tent(settings: dict) -> Shape:
    w, h, color = (settings[k] for k in ("width", "height", "color"))
    lean = math.atan2(h, w / 2)
    side = math.hypot(h, w / 2)
    walls = [
        transform_shape(primitive_call('cube', color=tuple(c * shade for c in color), shape_kwargs={'scale': (side, 0.04, 2)}),
                        translation_matrix((s * w / 4, h / 2, 0)) @ rotation_matrix(-s * lean, (0, 0, 1), (0, 0, 0)))
        for s, shade in ((-1, 1.0), (1, 0.85))
    ]
    n = settings["pegs"]
    pegs = [primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.03, 'p0': (sx * w / 2, 0, -1 + 4 * i / n), 'p1': (sx * w * 0.6, 0.1, -1 + 4 * i / n)}) for i in range(n // 2) for sx in (-1, 1)]
    flag = [primitive_call('cylinder', color=(0.9, 0.1, 0.1), shape_kwargs={'radius': 0.03, 'p0': (0, h, 1), 'p1': (0, h + 0.8, 1)})] if settings["flag"] else []
    return concat_shapes(*walls, *pegs, *flag)


@register()
def campsite() -> Shape:
    shapes, x = [], 0.0
    for group, own in TENTS:
        settings = ChainMap(own, GROUPS.get(group, {}), DEFAULTS)
        local = settings.new_child({"height": settings["height"] * 0.9} if group == "solo" else None)
        shapes.append(transform_shape(library_call('tent', settings=local), translation_matrix((x + local["width"] / 2, 0, 0))))
        x += local["width"] + 0.6
        if len(local.parents.maps) == 3 and "pegs" in own:
            shapes.append(transform_shape(primitive_call('cube', color=(0.5, 0.3, 0.1), shape_kwargs={'scale': (0.4, 0.3, 0.4)}), translation_matrix((x - 0.3, 0.15, 1.2))))
    stock = Inventory(wood=3, water=2)
    stock["food"] = stock["wood"] + stock["water"]
    logs = deque(range(stock["food"]))
    while len(logs) > 1:
        logs.append(logs.popleft() * 0.5)
        angle = logs.pop() * 2 + len(logs)
        shapes.append(primitive_call('cylinder', color=(0.4, 0.25, 0.15), shape_kwargs={'radius': 0.08, 'p0': (x / 2 + math.cos(angle), 0, 3 + math.sin(angle)), 'p1': (x / 2, 0.5, 3)}))
    fire = transform_shape(primitive_call('sphere', color=(1, 0.5, 0.1), shape_kwargs={'radius': 0.15 * sum(stock.reads.values())}), translation_matrix((x / 2, 0.3, 3)))
    return concat_shapes(*shapes, fire)
