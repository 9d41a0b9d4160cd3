'''Make a medieval castle with four towers, crenellated walls, a keep and a gate.'''
import bpy
import math

class CastleBuilder:
    def __init__(self, size=20.0, wall_height=5.0, wall_thickness=1.0):
        self.size = size
        self.wall_height = wall_height
        self.wall_thickness = wall_thickness
        self.stone = self._material("Stone", (0.45, 0.43, 0.4, 1))
        self.roof = self._material("Roof", (0.35, 0.08, 0.06, 1))
        self.wood = self._material("GateWood", (0.2, 0.1, 0.04, 1))
        self.collection = bpy.data.collections.new("Castle")
        bpy.context.scene.collection.children.link(self.collection)

    @staticmethod
    def _material(name, color):
        mat = bpy.data.materials.new(name=name)
        mat.use_nodes = True
        bsdf = mat.node_tree.nodes.get('Principled BSDF')
        bsdf.inputs['Base Color'].default_value = color
        bsdf.inputs['Roughness'].default_value = 0.9
        return mat

    def _register(self, obj, name, mat):
        obj.name = name
        obj.data.materials.append(mat)
        for c in obj.users_collection:
            c.objects.unlink(obj)
        self.collection.objects.link(obj)
        return obj

    def box(self, name, loc, dims, mat):
        bpy.ops.mesh.primitive_cube_add(size=1, location=loc)
        obj = bpy.context.active_object
        obj.scale = dims
        return self._register(obj, name, mat)

    def tower(self, x, y, radius=1.8, height=8.0):
        bpy.ops.mesh.primitive_cylinder_add(radius=radius, depth=height, location=(x, y, height / 2))
        self._register(bpy.context.active_object, "Tower", self.stone)
        bpy.ops.mesh.primitive_cone_add(radius1=radius * 1.25, depth=3, location=(x, y, height + 1.5))
        self._register(bpy.context.active_object, "TowerRoof", self.roof)

    def wall(self, start, end):
        (x1, y1), (x2, y2) = start, end
        length = math.dist(start, end)
        angle = math.atan2(y2 - y1, x2 - x1)
        cx, cy = (x1 + x2) / 2, (y1 + y2) / 2
        w = self.box("Wall", (cx, cy, self.wall_height / 2), (length, self.wall_thickness, self.wall_height), self.stone)
        w.rotation_euler[2] = angle
        count = int(length // 1.5)
        for i in range(count):
            t = (i + 0.5) / count
            m = self.box("Merlon", (x1 + (x2 - x1) * t, y1 + (y2 - y1) * t, self.wall_height + 0.4),
                         (0.7, self.wall_thickness, 0.8), self.stone)
            m.rotation_euler[2] = angle

    def keep(self):
        self.box("Keep", (0, 2, 5), (6, 6, 10), self.stone)
        for sx in (-1, 1):
            for sy in (-1, 1):
                self.box("KeepTurret", (3 * sx, 2 + 3 * sy, 10.5), (1.2, 1.2, 3), self.stone)

    def gate(self):
        y = -self.size / 2
        self.box("GateHouse", (0, y, 3.25), (4.5, 2.4, 6.5), self.stone)
        self.box("GateDoor", (0, y - 1.25, 1.75), (2.4, 0.2, 3.5), self.wood)

    def build(self):
        h = self.size / 2
        corners = [(-h, -h), (h, -h), (h, h), (-h, h)]
        for c in corners:
            self.tower(*c)
        for a, b in zip(corners, corners[1:] + corners[:1]):
            self.wall(a, b)
        self.keep()
        self.gate()


# Clean up
bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete(use_global=False, confirm=False)

CastleBuilder().build()

# Ground
bpy.ops.mesh.primitive_plane_add(size=60, location=(0, 0, 0))
ground = bpy.context.active_object
ground.name = 'Ground'
