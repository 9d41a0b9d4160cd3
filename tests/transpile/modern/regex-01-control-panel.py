import re
from helper import *

"""
a control panel described by a text specification
"""

SPEC = """
knob volume @ 0,0 size=0.4 color=#cc3333
knob  bass  @ 1,0 size=0.3
slider mix @ 2,0 range=0..10 value=7
slider pan @ 3,0 range=-5..5 value=-2 color=#3366cc
lamp power @ 0,1 color=#33cc33
lamp error@1,1
button go @ 2,1 size=0.5 color=#FFAA00
// button old @ 9,9
"""

LINE = re.compile(r"^(?P<kind>knob|slider|lamp|button)\s+(?P<name>\w+)\s*@\s*(?P<x>\d+),(?P<y>\d+)(?P<rest>.*)$")
OPTION = re.compile(r"(\w+)=(\S+)")


def hex_color(text: str) -> tuple[float, ...]:
    return tuple(int(pair, 16) / 255 for pair in re.findall(r"[0-9a-fA-F]{2}", text))


def parse(spec: str) -> list[dict]:
    items = []
    for line in spec.strip().splitlines():
        if not (m := LINE.match(line)):
            continue
        options = dict(OPTION.findall(m["rest"]))
        item = {**m.groupdict(), **options}
        item["color"] = hex_color(options.get("color", "#888888"))
        item["size"] = float(options.get("size", 0.25))
        if "range" in options:
            low, high = map(float, re.split(r"\.\.", options["range"]))
            item["fraction"] = (float(options["value"]) - low) / (high - low)
        items.append(item)
    return items


@register()
def control(item: dict) -> Shape:
    color, size = item["color"], item["size"]
    kind = item["kind"]
    if kind == "knob":
        cap = primitive_call('cylinder', color=color, shape_kwargs={'radius': size, 'p0': (0, 0, 0), 'p1': (0, 0, 0.2)})
        mark = transform_shape(primitive_call('cube', color=(1, 1, 1), shape_kwargs={'scale': (0.05, size, 0.05)}), translation_matrix((0, size / 2, 0.2)))
        return concat_shapes(cap, mark)
    if kind == "slider":
        track = primitive_call('cube', color=(0.1, 0.1, 0.1), shape_kwargs={'scale': (0.1, 0.8, 0.05)})
        grip = primitive_call('cube', color=color, shape_kwargs={'scale': (0.3, 0.12, 0.15)})
        return concat_shapes(track, transform_shape(grip, translation_matrix((0, 0.8 * (item["fraction"] - 0.5), 0.05))))
    if kind == "lamp":
        return primitive_call('sphere', color=color, shape_kwargs={'radius': size})
    return primitive_call('cube', color=color, shape_kwargs={'scale': (size, size, 0.15)})


@register()
def panel() -> Shape:
    items = parse(SPEC)
    shapes = []
    for item in items:
        x, y = int(item["x"]), int(item["y"])
        label = re.sub(r"[aeiou]", "", item["name"]).upper()
        plate = transform_shape(primitive_call('cube', color=(0.9, 0.9, 0.9), shape_kwargs={'scale': (0.08 * len(label), 0.08, 0.02)}), translation_matrix((0, -0.5, 0)))
        shapes.append(transform_shape(concat_shapes(library_call('control', item=item), plate), translation_matrix((x, -1.2 * y, 0))))
    digits = sum(int(d) for d in re.findall(r"\d", SPEC.split("//")[0]))
    back = primitive_call('cube', color=(0.25, 0.25, 0.28), shape_kwargs={'scale': (4.5, 3, 0.01 * digits)})
    return concat_shapes(transform_shape(back, translation_matrix((1.5, -0.6, -0.5))), *shapes)
