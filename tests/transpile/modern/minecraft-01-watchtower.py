from __future__ import annotations
from dataclasses import dataclass, field
from enum import Enum
from helper import *

"""
a watchtower with battlements in Minecraft
"""


class Material(str, Enum):
    STONE = "minecraft:stone_bricks"
    COBBLE = "minecraft:cobblestone"
    OAK = "minecraft:oak_planks"
    GLASS = "minecraft:glass_pane"
    TORCH = "minecraft:torch"


@dataclass(frozen=True)
class Box:
    size: tuple[int, int, int]
    at: tuple[int, int, int] = (0, 0, 0)
    hollow: bool = False

    def place(self, material: Material, **properties: str) -> Shape:
        block = primitive_call('set_cuboid', block_type=material.value, block_kwargs=properties, scale=self.size, fill=not self.hollow)
        return transform_shape(block, translation_matrix(self.at))


@dataclass
class Plan:
    width: int = 7
    floors: int = 3
    floor_height: int = 5
    parts: list = field(default_factory=list)

    @property
    def height(self) -> int:
        return self.floors * self.floor_height


@register("tower body")
def body(plan: Plan) -> Shape:
    w = plan.width
    shapes = [Box((w, plan.height, w), hollow=True).place(Material.STONE)]
    for f in range(plan.floors):
        y = f * plan.floor_height
        shapes.append(Box((w - 2, 1, w - 2), (1, y, 1)).place(Material.OAK))
        for x, z in ((w // 2, 0), (w // 2, w - 1), (0, w // 2), (w - 1, w // 2)):
            if f == 0 and z == 0:
                continue
            shapes.append(Box((1, 2, 1), (x, y + 2, z)).place(Material.GLASS, waterlogged="false"))
        shapes.append(Box((1, 1, 1), (1, y + 3, 1)).place(Material.TORCH))
    door = transform_shape(primitive_call('delete_blocks', scale=(1, 2, 1)), translation_matrix((w // 2, 1, 0)))
    return concat_shapes(*shapes, door)


@register("battlements")
def battlements(width: int) -> Shape:
    edge = [(x, z) for x in range(width) for z in range(width) if x in (0, width - 1) or z in (0, width - 1)]
    return concat_shapes(*[Box((1, 1, 1), (x, 1, z)).place(Material.COBBLE) for x, z in edge if (x + z) % 2 == 0], Box((width, 1, width)).place(Material.COBBLE))


@register("watchtower")
def watchtower() -> Shape:
    plan = Plan()
    top = transform_shape(library_call('battlements', width=plan.width + 2), translation_matrix((-1, plan.height, -1)))
    return concat_shapes(library_call('tower body', plan=plan), top)
