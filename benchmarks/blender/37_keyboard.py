"""Mechanical keyboard, 60% layout with variable key widths."""
from __future__ import annotations

import bpy
import bmesh
from typing import NamedTuple, Optional


class Key(NamedTuple):
    label: str
    width: float = 1.0


LAYOUT: list[list[Key]] = [
    [Key("`")] + [Key(c) for c in "1234567890-="] + [Key("Back", 2)],
    [Key("Tab", 1.5)] + [Key(c) for c in "QWERTYUIOP[]"] + [Key("\\", 1.5)],
    [Key("Caps", 1.75)] + [Key(c) for c in "ASDFGHJKL;'"] + [Key("Enter", 2.25)],
    [Key("LShift", 2.25)] + [Key(c) for c in "ZXCVBNM,./"] + [Key("RShift", 2.75)],
    [Key("Ctrl", 1.25), Key("Win", 1.25), Key("Alt", 1.25), Key("Space", 6.25),
     Key("AltGr", 1.25), Key("Fn", 1.25), Key("Menu", 1.25), Key("RCtrl", 1.25)],
]
UNIT = 0.19
CAP_H = 0.1


def keycap_mesh(width: float) -> bpy.types.Mesh:
    """Cached tapered keycap of a given unit width."""
    name = f"Cap_{width:g}u"
    if (me := bpy.data.meshes.get(name)) is not None:
        return me
    bm = bmesh.new()
    bmesh.ops.create_cube(bm, size=1)
    sx, sy = width * UNIT - 0.015, UNIT - 0.015
    for v in bm.verts:
        top = v.co.z > 0
        k = 0.03 if top else 0.0
        v.co.x = (sx / 2 - k) * (1 if v.co.x > 0 else -1)
        v.co.y = (sy / 2 - k) * (1 if v.co.y > 0 else -1)
        v.co.z = CAP_H if top else 0.0
    me = bpy.data.meshes.new(name)
    bm.to_mesh(me)
    bm.free()
    return me


def material(name: str, rgb: tuple[float, float, float], rough: float = 0.5) -> bpy.types.Material:
    m = bpy.data.materials.new(name)
    m.diffuse_color = (*rgb, 1.0)
    m.roughness = rough
    return m


def build(parent: Optional[bpy.types.Object] = None) -> None:
    light, dark, accent = material("Light", (.85, .85, .82)), material("Dark", (.2, .22, .25)), material("Accent", (.9, .35, .1))
    rows = len(LAYOUT)
    total = max(sum(k.width for k in r) for r in LAYOUT)
    for r, row in enumerate(LAYOUT):
        cursor = -total / 2
        for key in row:
            ob = bpy.data.objects.new(f"Key_{key.label}", keycap_mesh(key.width))
            ob.location = ((cursor + key.width / 2) * UNIT, ((rows - 1) / 2 - r) * UNIT, 0.1 + 0.012 * (rows - r))
            bpy.context.collection.objects.link(ob)
            mat = accent if key.label in {"Enter", "`"} else dark if len(key.label) > 1 else light
            if not ob.data.materials:
                ob.data.materials.append(None)
            ob.material_slots[0].link = 'OBJECT'
            ob.material_slots[0].material = mat
            cursor += key.width

    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.05))
    case = bpy.context.object
    case.name = "Case"
    case.dimensions = (total * UNIT + 0.12, rows * UNIT + 0.12, 0.1)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    bevel = case.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.02, 3
    case.data.materials.append(dark)


if __name__ == "__main__":
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    build()
