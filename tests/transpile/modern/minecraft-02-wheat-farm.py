import random
from functools import partial
from typing import Callable
from helper import *

"""
a wheat farm with irrigation and a barn in Minecraft
"""

def block(name: str, size=(1, 1, 1), at=(0, 0, 0), /, *, fill: bool = True, **state) -> Shape:
    shape = primitive_call("set_cuboid", block_type=f"minecraft:{name}", block_kwargs={k: str(v).lower() for k, v in state.items()}, scale=size, fill=fill)
    return transform_shape(shape, translation_matrix(at))

farmland = partial(block, "farmland", moisture=7)
log: Callable[..., Shape] = partial(block, "oak_log", axis="y")

class Field:
    CROPS = {"wheat": 7, "carrots": 7, "beetroots": 3}

    def __init__(self, width: int, depth: int, crop: str):
        self.width, self.depth, self.crop = width, depth, crop

    @property
    def canal(self) -> int:
        return self.width // 2

    def rows(self):
        for z in range(self.depth):
            for x in range(self.width):
                if x != self.canal:
                    yield x, z

    def render(self) -> Shape:
        top = self.CROPS[self.crop]
        soil = [farmland((self.canal, 1, self.depth), (0, 0, 0)), farmland((self.width - self.canal - 1, 1, self.depth), (self.canal + 1, 0, 0))]
        water = block("water", (1, 1, self.depth), (self.canal, 0, 0), level=0)
        crops = [block(self.crop, (1, 1, 1), (x, 1, z), age=random.randint(top // 2, top)) for x, z in self.rows() if random.random() < 0.7]
        return concat_shapes(*soil, water, *crops)

@register("field with one crop")
def field(width: int, depth: int, crop: str) -> Shape:
    return Field(width, depth, crop).render()

@register("barn")
def barn(w: int = 8, d: int = 6, h: int = 5) -> Shape:
    walls = block("red_terracotta", (w, h, d), fill=False)
    posts = [log((1, h, 1), (x, 0, z)) for x in (0, w - 1) for z in (0, d - 1)]
    roof = [block("dark_oak_planks", (w + 2 - 2 * i, 1, d + 2), (i - 1, h + i, -1)) for i in range(w // 2 + 1) if w + 2 - 2 * i > 0]
    gate = transform_shape(primitive_call("delete_blocks", scale=(2, 3, 1)), translation_matrix((w // 2 - 1, 0, 0)))
    hay = [block("hay_block", (1, random.choice([1, 2]), 1), (random.randint(1, w - 2), 0, d - 2), axis=random.choice("xyz")) for _ in range(3)]
    return concat_shapes(walls, *posts, *roof, gate, *hay)

@register("farm")
def farm() -> Shape:
    ground = block("grass_block", (30, 1, 24), (-2, -1, -2), snowy=False)
    x, shapes = 0, [ground]
    for crop in sorted(Field.CROPS, key=lambda c: (Field.CROPS[c], c)):
        width = random.randrange(5, 8)
        shapes.append(transform_shape(library_call("field", width=width, depth=7, crop=crop), translation_matrix((x, -1, 0))))
        x += width + 2
    return concat_shapes(*shapes, transform_shape(library_call("barn"), translation_matrix((8, 0, 12))))
