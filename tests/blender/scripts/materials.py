"""Colors by both spellings of the Principled BSDF, by nodes, and by diffuse_color."""

import bpy
from mathutils import Color

for block in list(bpy.data.objects):
    bpy.data.objects.remove(block, do_unlink=True)


def ball(name, x, look):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.4, location=(x, 0, 0))
    bpy.ops.object.shade_smooth()
    made = bpy.context.object
    made.name = name
    if made.data.materials:
        made.data.materials[0] = look
    else:
        made.data.materials.append(look)


def principled(name, **values):
    made = bpy.data.materials.new(name=name)
    made.use_nodes = True
    shader = made.node_tree.nodes.get("Principled BSDF")
    for key, value in values.items():
        old = key.replace("_", " ").title()
        for spelling in (old, old + " Color", old + " Weight"):
            if spelling in shader.inputs:
                shader.inputs[spelling].default_value = value
                break
    return made


ball("Gold", 0, principled("Gold", base=(1, 0.7, 0.2, 1), base_color=(1, 0.7, 0.2, 1), metallic=1.0, roughness=0.2))
ball("Lamp", 1, principled("Lamp", base_color=(1, 0.9, 0.7, 1), emission=(1, 0.9, 0.7, 1), emission_strength=4.0))
ball("Glass", 2, principled("Glass", base_color=(0.9, 0.95, 1, 1), transmission=1.0, ior=1.45, roughness=0.0))
plain = bpy.data.materials.new("Plain")
plain.diffuse_color = (0.1, 0.5, 0.2, 1)
ball("Plain", 3, plain)
glow = bpy.data.materials.new("Glow")
glow.use_nodes = True
nodes, links = glow.node_tree.nodes, glow.node_tree.links
nodes.clear()
emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
emission.inputs["Color"].default_value = (0.2, 0.4, 1, 1)
emission.inputs["Strength"].default_value = 3
links.new(emission.outputs["Emission"], output.inputs["Surface"])
ball("Glow", 4, glow)
tint = Color((0.5, 0.1, 0.1))
tint.hsv = (0.6, 0.8, 0.5)
ball("Tinted", 5, principled("Tinted", base_color=(*tint, 1)))
ball("Bare", 6, None)
copied = plain.copy()
copied.diffuse_color[0] = 0.9
ball("Copied", 7, copied)
