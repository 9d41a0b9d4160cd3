"""DNA double helix with colored base pairs."""
import bpy
import numpy as np
from mathutils import Vector

PAIRS = {"A": "T", "T": "A", "G": "C", "C": "G"}
COLORS = {
    "A": (0.9, 0.2, 0.2, 1), "T": (0.2, 0.4, 0.9, 1),
    "G": (0.2, 0.8, 0.3, 1), "C": (0.95, 0.8, 0.2, 1),
    "backbone": (0.8, 0.8, 0.85, 1),
}
sequence = "ATGCGTACCTGAATCGGCTA"

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

materials = {}
for key, rgba in COLORS.items():
    mat = bpy.data.materials.new(f"DNA_{key}")
    mat.diffuse_color = rgba
    materials[key] = mat

def rod(p, q, r, mat):
    p, q = Vector(p), Vector(q)
    v = q - p
    bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=r, depth=v.length, location=(p + q) / 2)
    o = bpy.context.object
    o.rotation_euler = v.to_track_quat('Z', 'Y').to_euler()
    o.data.materials.append(mat)

n = len(sequence)
theta = np.linspace(0, 4 * np.pi, n)
z = np.linspace(0, 6.8, n)
strand1 = np.stack([np.cos(theta), np.sin(theta), z], axis=1)
strand2 = np.stack([np.cos(theta + np.pi * 0.8), np.sin(theta + np.pi * 0.8), z], axis=1)

for i, base in enumerate(sequence):
    a = tuple(float(c) for c in strand1[i])
    b = tuple(float(c) for c in strand2[i])
    for pos in (a, b):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.16, location=pos)
        bpy.context.object.data.materials.append(materials["backbone"])
    mid = tuple((p + q) / 2 for p, q in zip(a, b))
    rod(a, mid, 0.06, materials[base])
    rod(mid, b, 0.06, materials[PAIRS[base]])
    if i:
        rod(strand1[i - 1].tolist(), a, 0.08, materials["backbone"])
        rod(strand2[i - 1].tolist(), b, 0.08, materials["backbone"])
