"""Create a nightstand with three drawers, round knobs, tapered legs; the middle drawer is slightly open."""
import bpy
import bmesh

class Nightstand:
    width = 0.5
    depth = 0.4
    body_height = 0.5
    leg_height = 0.15
    panel = 0.02

    def __init__(self, open_drawer: int = 1, amount: float = 0.12):
        self.open_drawer = open_drawer
        self.amount = amount
        self.parts = []

    # ---- primitives -----------------------------------------------------
    def _panel(self, name, center, size):
        mesh = bpy.data.meshes.new(name)
        bm = bmesh.new()
        bmesh.ops.create_cube(bm, size=1.0)
        for v in bm.verts:
            v.co.x *= size[0]
            v.co.y *= size[1]
            v.co.z *= size[2]
        bm.to_mesh(mesh)
        bm.free()
        obj = bpy.data.objects.new(name, mesh)
        obj.location = center
        bpy.context.collection.objects.link(obj)
        self.parts.append(obj)
        return obj

    # ---- carcass --------------------------------------------------------
    def carcass(self):
        w, d, h, p = self.width, self.depth, self.body_height, self.panel
        z0 = self.leg_height
        self._panel("Bottom", (0, 0, z0 + p / 2), (w, d, p))
        self._panel("Top", (0, 0, z0 + h - p / 2), (w + 0.02, d + 0.02, p))
        for s in (-1, 1):
            self._panel("Side", (s * (w - p) / 2, 0, z0 + h / 2), (p, d, h - 2 * p))
        self._panel("Back", (0, (d - p) / 2, z0 + h / 2), (w - 2 * p, p, h - 2 * p))

    def legs(self):
        for sx in (-1, 1):
            for sy in (-1, 1):
                bpy.ops.mesh.primitive_cone_add(
                    vertices=16, radius1=0.012, radius2=0.022, depth=self.leg_height,
                    location=(sx * (self.width / 2 - 0.04), sy * (self.depth / 2 - 0.04), self.leg_height / 2))
                self.parts.append(bpy.context.object)

    def drawers(self, n=3):
        p = self.panel
        inner_h = self.body_height - 2 * p
        dh = inner_h / n
        for i in range(n):
            z = self.leg_height + p + dh * (i + 0.5)
            dy = -self.amount if i == self.open_drawer else 0.0
            front_y = -self.depth / 2 + p / 2 + dy
            front = self._panel(f"DrawerFront{i}", (0, front_y, z), (self.width - 2 * p - 0.006, p, dh - 0.006))
            if dy:
                bw = self.width - 2 * p - 0.03
                self._panel("DrawerFloor", (0, dy, z - dh / 2 + 0.02), (bw, self.depth - 2 * p, 0.008))
                for s in (-1, 1):
                    self._panel("DrawerSide", (s * bw / 2, dy, z), (0.01, self.depth - 2 * p, dh * 0.7))
            bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.014,
                                                 location=(0, front_y - p / 2 - 0.01, z))
            knob = bpy.context.object
            knob.name = f"Knob{i}"
            knob.parent = front
            knob.matrix_parent_inverse = front.matrix_world.inverted()

    def paint(self):
        wood = bpy.data.materials.new("Walnut")
        wood.use_nodes = True
        wood.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.23, 0.12, 0.06, 1)
        for o in self.parts:
            o.data.materials.append(wood)

    def build(self):
        self.carcass(); self.legs(); self.drawers(); self.paint()
        return self.parts

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()
Nightstand().build()
