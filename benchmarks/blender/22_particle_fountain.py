"""Make a water fountain with a particle system emitting droplets."""
import bpy
import math

def setup_scene():
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete(use_global=False)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 200
    scene.gravity = (0, 0, -9.81)

def stone_material():
    mat = bpy.data.materials.new("Stone")
    mat.use_nodes = True
    tree = mat.node_tree
    bsdf = tree.nodes["Principled BSDF"]
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = 12
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color = (0.3, 0.3, 0.3, 1)
    ramp.color_ramp.elements[1].color = (0.6, 0.58, 0.55, 1)
    tree.links.new(noise.outputs["Fac"] if "Fac" in noise.outputs else noise.outputs[0], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], bsdf.inputs["Base Color"])
    return mat

def build_fountain(mat):
    tiers = [(2.0, 0.4, 0.2), (0.3, 1.2, 0.8), (1.1, 0.2, 1.5), (0.2, 0.8, 2.0), (0.5, 0.15, 2.45)]
    objs = []
    for i, (r, d, z) in enumerate(tiers):
        bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=r, depth=d, location=(0, 0, z))
        o = bpy.context.object
        o.name = f"Tier{i}"
        o.data.materials.append(mat)
        objs.append(o)
    bpy.ops.mesh.primitive_torus_add(major_radius=2.0, minor_radius=0.12, location=(0, 0, 0.42))
    rim = bpy.context.object
    rim.data.materials.append(mat)
    return objs

def add_emitter():
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.04, location=(20, 0, 0))
    drop = bpy.context.object
    drop.name = "Droplet"

    bpy.ops.mesh.primitive_circle_add(radius=0.1, fill_type='NGON', location=(0, 0, 2.6))
    emitter = bpy.context.object
    emitter.name = "Emitter"
    emitter.modifiers.new("Water", 'PARTICLE_SYSTEM')
    ps = emitter.particle_systems[0]
    s = ps.settings
    s.count = 2000
    s.frame_start = 1
    s.frame_end = 200
    s.lifetime = 60
    s.normal_factor = 4.0
    s.factor_random = 0.8
    s.render_type = 'OBJECT'
    s.instance_object = drop
    s.particle_size = 1.0
    s.size_random = 0.5

setup_scene()
build_fountain(stone_material())
add_emitter()
