"""A response's kind of script: classes, dataclasses, defaults, comprehensions, a seed, instances that share meshes."""

import math
import random
from dataclasses import dataclass, field

import bpy


@dataclass
class Palette:
    trunk: tuple = (0.25, 0.12, 0.05, 1)
    leaves: list = field(default_factory=lambda: [(0.05, 0.3, 0.08, 1), (0.1, 0.4, 0.1, 1)])


class Forest:
    def __init__(self, seed: int = 4, palette: Palette | None = None) -> None:
        self.random = random.Random(seed)
        self.palette = palette or Palette()
        self.looks: dict[str, bpy.types.Material] = {}

    def look(self, name: str, color: tuple) -> bpy.types.Material:
        if name not in self.looks:
            made = bpy.data.materials.new(name)
            made.use_nodes = True
            made.node_tree.nodes["Principled BSDF"].inputs[0].default_value = color
            self.looks[name] = made
        return self.looks[name]

    def create_tree(self, x: float, y: float, height: float = 2.0) -> None:
        bpy.ops.mesh.primitive_cylinder_add(vertices=8, radius=0.1, depth=height / 2, location=(x, y, height / 4))
        trunk = bpy.context.object
        trunk.name = f"Trunk_{x:.0f}"
        trunk.data.materials.append(self.look("Bark", self.palette.trunk))
        for i, color in enumerate(self.palette.leaves):
            bpy.ops.mesh.primitive_cone_add(
                vertices=7, radius1=0.6 - 0.15 * i, depth=height / 2, location=(x, y, height * (0.5 + 0.3 * i))
            )
            bpy.context.object.name = "Crown"
            bpy.context.object.data.materials.append(self.look(f"Leaves{i}", color))

    def grow(self, count: int) -> None:
        for _ in range(count):
            self.create_tree(self.random.uniform(-4, 4), self.random.uniform(-4, 4), self.random.choice([1.5, 2.0]))


def clear() -> None:
    [bpy.data.objects.remove(each) for each in list(bpy.data.objects)]


def main() -> None:
    clear()
    Forest().grow(6)
    for angle in (math.radians(a) for a in range(0, 360, 60)):
        bpy.ops.mesh.primitive_cube_add(
            size=0.5, location=(6 * math.cos(angle), 6 * math.sin(angle), 0.25), rotation=(0, 0, angle)
        )
        bpy.context.object.name = "Stone"


if __name__ == "__main__":
    main()
