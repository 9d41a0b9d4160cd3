"""Recursive fractal tree with foliage, all branches in one collection."""
import bpy
import math
import random
from typing import Iterator
from dataclasses import dataclass, field
from mathutils import Vector, Matrix, Euler


@dataclass
class TreeSettings:
    depth: int = 5
    length: float = 2.0
    radius: float = 0.22
    length_ratio: float = 0.74
    radius_ratio: float = 0.65
    spread: float = math.radians(32)
    children: tuple[int, int] = (2, 3)
    seed: int = 12
    leaf_color: tuple = (0.12, 0.45, 0.1, 1.0)
    rng: random.Random = field(init=False, repr=False)

    def __post_init__(self):
        self.rng = random.Random(self.seed)


@dataclass(frozen=True)
class Branch:
    matrix: Matrix
    length: float
    radius: float
    level: int

    @property
    def tip(self) -> Matrix:
        return self.matrix @ Matrix.Translation((0, 0, self.length))


def grow(branch: Branch, cfg: TreeSettings) -> Iterator[Branch]:
    yield branch
    if branch.level >= cfg.depth:
        return
    n = cfg.rng.randint(*cfg.children)
    twist = cfg.rng.uniform(0, math.tau)
    for k in range(n):
        rot = Euler((cfg.spread * cfg.rng.uniform(0.7, 1.2), 0, twist + math.tau * k / n), 'XYZ').to_matrix().to_4x4()
        child = Branch(branch.tip @ rot, branch.length * cfg.length_ratio * cfg.rng.uniform(0.85, 1.1),
                       branch.radius * cfg.radius_ratio, branch.level + 1)
        yield from grow(child, cfg)


def tapered_mesh(r0: float, r1: float, length: float, sides: int) -> bpy.types.Mesh:
    verts = []
    for r, z in ((r0, 0.0), (r1, length)):
        verts += [(r * math.cos(math.tau * i / sides), r * math.sin(math.tau * i / sides), z) for i in range(sides)]
    faces = [(i, (i + 1) % sides, sides + (i + 1) % sides, sides + i) for i in range(sides)]
    me = bpy.data.meshes.new("Branch")
    me.from_pydata(verts, [], faces)
    return me


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    cfg = TreeSettings()
    coll = bpy.data.collections.new("Tree")
    bpy.context.scene.collection.children.link(coll)

    bark = bpy.data.materials.new("Bark")
    bark.diffuse_color = (0.25, 0.15, 0.08, 1)
    leaf = bpy.data.materials.new("Leaves")
    leaf.diffuse_color = cfg.leaf_color

    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=0.35)
    tmp = bpy.context.object
    leaf_mesh = tmp.data
    leaf_mesh.materials.append(leaf)
    bpy.data.objects.remove(tmp)

    for i, br in enumerate(grow(Branch(Matrix.Identity(4), cfg.length, cfg.radius, 0), cfg)):
        me = tapered_mesh(br.radius, br.radius * cfg.radius_ratio, br.length, max(4, 10 - br.level))
        me.materials.append(bark)
        ob = bpy.data.objects.new(f"Branch_{br.level}_{i}", me)
        ob.matrix_world = br.matrix
        coll.objects.link(ob)
        if br.level == cfg.depth:
            lf = bpy.data.objects.new("Foliage", leaf_mesh)
            lf.location = br.tip.to_translation()
            lf.scale = Vector((1, 1, 0.8)) * cfg.rng.uniform(0.7, 1.4)
            coll.objects.link(lf)
    print("objects:", len(coll.objects))


if __name__ == "__main__":
    main()
