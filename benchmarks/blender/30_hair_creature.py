"""A fuzzy monster with big eyes and a hair particle system."""
import bpy
import math

class Monster:
    EYE_OFFSET = 0.38

    def __init__(self, name="Fuzzy", color=(0.4, 0.1, 0.7, 1.0)):
        self.name = name
        self.color = color
        self.objects = {}

    def material(self, name, color, roughness=0.6):
        mat = bpy.data.materials.new(f"{self.name}_{name}")
        mat.use_nodes = True
        node = mat.node_tree.nodes.get("Principled BSDF")
        node.inputs["Base Color"].default_value = color
        node.inputs["Roughness"].default_value = roughness
        return mat

    def body(self):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=1, location=(0, 0, 1.1))
        b = bpy.context.active_object
        b.name = f"{self.name}_Body"
        b.scale = (1, 0.9, 1.1)
        b.data.materials.append(self.material("Fur", self.color, 0.9))
        b.modifiers.new("Fur", type='PARTICLE_SYSTEM')
        settings = b.particle_systems[-1].settings
        settings.type = 'HAIR'
        settings.count = 500
        settings.hair_length = 0.25
        settings.child_type = 'INTERPOLATED'
        self.objects["body"] = b
        return self

    def eyes(self):
        white = self.material("EyeWhite", (1, 1, 1, 1), 0.1)
        black = self.material("Pupil", (0, 0, 0, 1), 0.1)
        for i, sx in enumerate((-1, 1)):
            bpy.ops.mesh.primitive_uv_sphere_add(radius=0.28, location=(sx * self.EYE_OFFSET, -0.72, 1.5))
            e = bpy.context.active_object
            e.data.materials.append(white)
            bpy.ops.object.shade_smooth()
            bpy.ops.mesh.primitive_uv_sphere_add(radius=0.12, location=(sx * self.EYE_OFFSET, -0.93, 1.52))
            p = bpy.context.active_object
            p.data.materials.append(black)
            self.objects[f"eye{i}"] = e
            self.objects[f"pupil{i}"] = p
        return self

    def horns(self):
        bone = self.material("Bone", (0.9, 0.85, 0.7, 1))
        for sx in (-1, 1):
            bpy.ops.mesh.primitive_cone_add(vertices=16, radius1=0.15, radius2=0.01, depth=0.6,
                                            location=(sx * 0.55, 0, 2.2), rotation=(0, sx * math.radians(25), 0))
            bpy.context.active_object.data.materials.append(bone)
        return self

    def feet(self):
        mat = self.material("Feet", tuple(c * 0.5 for c in self.color[:3]) + (1,))
        for sx in (-1, 1):
            bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, location=(sx * 0.4, -0.2, 0.12))
            f = bpy.context.active_object
            f.scale = (1, 1.4, 0.5)
            f.data.materials.append(mat)
        return self

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()
Monster().body().eyes().horns().feet()
