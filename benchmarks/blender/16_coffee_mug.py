"""Create a coffee mug with a hollow interior (boolean) and a torus handle, filled with coffee."""
import bpy
import math

def delete_all():
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete()

def main():
    delete_all()

    # Outer body
    bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=0.5, depth=1.2, location=(0, 0, 0.6))
    mug = bpy.context.active_object
    mug.name = "Mug"

    # Handle
    bpy.ops.mesh.primitive_torus_add(
        align='WORLD',
        location=(0.55, 0, 0.6),
        rotation=(math.pi / 2, 0, 0),
        major_radius=0.3,
        minor_radius=0.06,
        major_segments=48,
        minor_segments=16,
    )
    handle = bpy.context.active_object
    handle.name = "Handle"

    # Union handle
    union = mug.modifiers.new(name="HandleUnion", type='BOOLEAN')
    union.operation = 'UNION'
    union.object = handle

    # Cutter
    bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=0.44, depth=1.2, location=(0, 0, 0.67))
    cutter = bpy.context.active_object
    cutter.name = "Cutter"
    diff = mug.modifiers.new(name="Hollow", type='BOOLEAN')
    diff.operation = 'DIFFERENCE'
    diff.object = cutter
    diff.solver = 'EXACT'

    bpy.context.view_layer.objects.active = mug
    bpy.ops.object.modifier_apply(modifier="HandleUnion")
    bpy.ops.object.modifier_apply(modifier="Hollow")

    # Remove helpers
    bpy.data.objects.remove(handle, do_unlink=True)
    bpy.data.objects.remove(cutter, do_unlink=True)

    # Ceramic
    ceramic = bpy.data.materials.new("Ceramic")
    ceramic.use_nodes = True
    bsdf = ceramic.node_tree.nodes["Principled BSDF"]
    bsdf.inputs["Base Color"].default_value = (0.1, 0.35, 0.6, 1)
    bsdf.inputs["Roughness"].default_value = 0.15
    if "Specular" in bsdf.inputs:
        bsdf.inputs["Specular"].default_value = 0.6
    elif "Specular IOR Level" in bsdf.inputs:
        bsdf.inputs["Specular IOR Level"].default_value = 0.6
    mug.data.materials.append(ceramic)

    # Coffee
    bpy.ops.mesh.primitive_circle_add(vertices=64, radius=0.44, fill_type='NGON', location=(0, 0, 1.05))
    coffee = bpy.context.active_object
    coffee.name = "Coffee"
    cm = bpy.data.materials.new("Coffee")
    cm.use_nodes = True
    cm.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.06, 0.025, 0.01, 1)
    coffee.data.materials.append(cm)

if __name__ == "__main__":
    main()
