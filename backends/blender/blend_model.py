"""The objects of `bpy` that scripts use: data-blocks, objects with their transforms, materials, and the context.

Every class names the attributes that scripts may read or assign; settings of pictures and of the user interface take
anything and mean nothing. World matrices are those of the last update, as in Blender: assigning a location does not
change ``matrix_world`` before an operator or ``view_layer.update()`` has run.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender import polygons
from scenelang.backends.blender.animating import Animation
from scenelang.backends.blender.pieces import MeshPiece, polygons_of
from scenelang.backends.blender.polygons import Polygons
from scenelang.backends.blender.vectors import (
    Euler,
    MatrixValue,
    Numbers,
    Quaternion,
    VectorValue,
    composed,
    decomposed,
)
from scenelang.interpreter.transpile.evaluation import UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.objects import MISSING, HostObject, Native

FloatArray = npt.NDArray[np.float64]
MAX_OBJECTS = 20_000


class Settings(HostObject):
    """Settings without a meaning for a scene: takes every attribute, item and call."""

    python_name = "bpy_struct"

    def __init__(self, **values: Any) -> None:
        self.values: dict[Any, Any] = values

    def read(self, name: str) -> Any:
        if name.startswith("__"):
            return MISSING
        return self.values.setdefault(name, Settings())

    def assign(self, name: str, value: Any) -> None:
        self.values[name] = value

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return Settings()

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, slice):
            return ()
        return self.values.setdefault(key, Settings())

    def __setitem__(self, key: Any, value: Any) -> None:
        self.values[key] = value

    def __contains__(self, key: Any) -> bool:
        return True

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __bool__(self) -> bool:
        return True


class Struct(HostObject):
    """Struct with attributes of its own: ``shown`` are read, ``assigned`` also written, ``ignored`` mean nothing."""

    python_name = "bpy_struct"
    assigned: frozenset[str] = frozenset()
    ignored: frozenset[str] = frozenset()

    def __init__(self) -> None:
        self.properties: dict[str, Any] = {}
        self.unused: dict[str, Any] = {}

    def read(self, name: str) -> Any:
        if name in self.ignored:
            return self.unused.get(name, False)
        if name in self.assigned:
            return getattr(self, name)
        return super().read(name)

    def assign(self, name: str, value: Any) -> None:
        if name in self.ignored:
            self.unused[name] = value
            return
        if name not in self.assigned:
            super().assign(name, value)
        current = getattr(self, name, None)
        if isinstance(current, Numbers) and not isinstance(type(self).__dict__.get(name), property):
            current.set(value)
        else:
            setattr(self, name, value)

    def get(self, key: str, default: Any = None) -> Any:
        """Return a property of the script's own."""
        return self.properties.get(key, default)

    def keys(self) -> list[str]:
        """Return the names of the script's own properties."""
        return list(self.properties)

    def __getitem__(self, key: str) -> Any:
        return self.properties[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self.properties[key] = value

    def __contains__(self, key: Any) -> bool:
        return key in self.properties

    def __bool__(self) -> bool:
        return True


class DataBlock(Struct):
    """Data-block: a struct with a name that is unique among those of its kind."""

    shown = frozenset(words("get keys name_full users library as_pointer user_clear update_tag id_data"))
    assigned = frozenset(words("name use_fake_user"))

    def __init__(self, blocks: DataBlocks, name: str) -> None:
        super().__init__()
        self.blocks: Any = blocks
        self.use_fake_user = False
        self._name = blocks.unique(name)
        blocks.add(self)

    @property
    def name(self) -> str:
        """Return the name."""
        return self._name

    @name.setter
    def name(self, name: str) -> None:
        if name != self._name:
            self.blocks.by_name.pop(self._name, None)
            self._name = self.blocks.unique(str(name))
            self.blocks.add(self)

    name_full = property(lambda self: self._name)
    users = 1
    library = None
    id_data = property(lambda self: self)

    def as_pointer(self) -> int:
        """Return a number of its own."""
        return id(self)

    def user_clear(self) -> None:
        """Do nothing."""

    def update_tag(self, refresh: Any = None) -> None:
        """Do nothing."""

    def __repr__(self) -> str:
        return f"bpy.data.{self.blocks.kind}['{self._name}']"


class DataBlocks(HostObject):
    """Data-blocks of one kind, in the order of their names."""

    python_name = "bpy_prop_collection"
    shown = frozenset(words("new remove get keys values items find foreach_get foreach_set load active"))

    def __init__(
        self, kind: str, make: Callable[..., Any], removed: Callable[[Any], None] = lambda block: None
    ) -> None:
        self.kind, self._make, self._removed = kind, make, removed
        self.by_name: dict[str, Any] = {}

    def unique(self, name: str) -> str:
        """Return a name that is not used yet."""
        name = name[:255]
        if name not in self.by_name:
            return name
        stem = re.sub(r"\.\d+$", "", name)
        number = 1
        while f"{stem}.{number:03d}" in self.by_name:
            number += 1
        return f"{stem}.{number:03d}"

    def add(self, block: Any) -> None:
        """Add a block by its name."""
        if len(self.by_name) > MAX_OBJECTS:
            raise UnsupportedPython(f"this script makes more than {MAX_OBJECTS:,} {self.kind}")
        self.by_name[block.name] = block

    def new(self, *arguments: Any, **named: Any) -> Any:
        """Create a block."""
        return self._make(*arguments, **named)

    load = new

    def remove(self, block: Any, do_unlink: bool = True, do_id_user: bool = True, do_ui_user: bool = True) -> None:
        """Remove a block."""
        known: Any = self.by_name.get(block.name)
        if known is not block:
            raise ReferenceError("StructRNA of type Object has been removed")
        del self.by_name[block.name]
        self._removed(block)

    def listed(self) -> list[Any]:
        """Return the blocks by name."""
        return [self.by_name[name] for name in sorted(self.by_name, key=str.casefold)]

    def get(self, name: str, default: Any = None) -> Any:
        """Return a block by name."""
        return self.by_name.get(name, default)

    def find(self, name: str) -> int:
        """Return the number of a block."""
        return next((i for i, block in enumerate(self.listed()) if block.name == name), -1)

    def keys(self) -> list[str]:
        """Return the names."""
        return [block.name for block in self.listed()]

    def values(self) -> list[Any]:
        """Return the blocks."""
        return self.listed()

    def items(self) -> list[tuple[str, Any]]:
        """Return names with blocks."""
        return [(block.name, block) for block in self.listed()]

    def __iter__(self) -> Iterator[Any]:
        return iter(self.listed())

    def __len__(self) -> int:
        return len(self.by_name)

    def __contains__(self, name: Any) -> bool:
        return (name in self.by_name) if isinstance(name, str) else name in self.by_name.values()

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            if key not in self.by_name:
                raise KeyError(f'bpy_prop_collection[key]: key "{key}" not found')
            return self.by_name[key]
        return self.listed()[key]

    def __bool__(self) -> bool:
        return bool(self.by_name)


class StructList(HostObject):
    """List of structs that scripts find by name or number, in the order in which they were added."""

    python_name = "bpy_prop_collection"
    shown = frozenset(words("new remove clear get keys values items append pop find active link unlink move"))

    def __init__(self, make: Callable[..., Any] | None = None) -> None:
        self.items_: list[Any] = []
        self._make = make
        self.active: Any = None

    def assign(self, name: str, value: Any) -> None:
        if name != "active":
            super().assign(name, value)
        self.active = value

    def new(self, *arguments: Any, **named: Any) -> Any:
        """Create an item."""
        assert self._make is not None, "only lists with a maker are asked"
        made = self._make(*arguments, **named)
        self.items_.append(made)
        return made

    def append(self, item: Any) -> None:
        """Add an item."""
        self.items_.append(item)

    link = append

    def remove(self, item: Any) -> None:
        """Remove an item."""
        if not any(each is item for each in self.items_):
            raise RuntimeError("the item is not in the collection")
        self.items_ = [each for each in self.items_ if each is not item]

    unlink = remove

    def pop(self, index: int = -1) -> Any:
        """Remove an item by number."""
        return self.items_.pop(index)

    def clear(self) -> None:
        """Remove all items."""
        self.items_.clear()

    def get(self, name: str, default: Any = None) -> Any:
        """Return an item by name."""
        return next((item for item in self.items_ if getattr(item, "name", None) == name), default)

    def find(self, name: str) -> int:
        """Return the number of an item."""
        return next((i for i, item in enumerate(self.items_) if getattr(item, "name", None) == name), -1)

    def keys(self) -> list[str]:
        """Return the names."""
        return [item.name for item in self.items_]

    def values(self) -> list[Any]:
        """Return the items."""
        return list(self.items_)

    def items(self) -> list[tuple[str, Any]]:
        """Return names with items."""
        return [(item.name, item) for item in self.items_]

    def __iter__(self) -> Iterator[Any]:
        return iter(list(self.items_))

    def __len__(self) -> int:
        return len(self.items_)

    def __bool__(self) -> bool:
        return bool(self.items_)

    def __contains__(self, key: Any) -> bool:
        return self.get(key) is not None if isinstance(key, str) else any(key is item for item in self.items_)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            item = self.get(key)
            if item is None:
                raise KeyError(f'bpy_prop_collection[key]: key "{key}" not found')
            return item
        return self.items_[key]

    def __setitem__(self, index: int, value: Any) -> None:
        self.items_[index] = value


# --- materials -------------------------------------------------------------------------------------------------------

# Inputs of the Principled BSDF of Blender 5, in order, with their defaults.
_PRINCIPLED: dict[str, Any] = {
    "Base Color": (0.8, 0.8, 0.8, 1.0), "Metallic": 0.0, "Roughness": 0.5, "IOR": 1.5, "Alpha": 1.0,
    "Normal": (0.0, 0.0, 0.0), "Weight": 0.0, "Diffuse Roughness": 0.0, "Subsurface Weight": 0.0,
    "Subsurface Radius": (1.0, 0.2, 0.1), "Subsurface Scale": 0.05, "Subsurface IOR": 1.4,
    "Subsurface Anisotropy": 0.0, "Specular IOR Level": 0.5, "Specular Tint": (1.0, 1.0, 1.0, 1.0),
    "Anisotropic": 0.0, "Anisotropic Rotation": 0.0, "Tangent": (0.0, 0.0, 0.0), "Transmission Weight": 0.0,
    "Coat Weight": 0.0, "Coat Roughness": 0.03, "Coat IOR": 1.5, "Coat Tint": (1.0, 1.0, 1.0, 1.0),
    "Coat Normal": (0.0, 0.0, 0.0), "Sheen Weight": 0.0, "Sheen Roughness": 0.5,
    "Sheen Tint": (1.0, 1.0, 1.0, 1.0), "Emission Color": (1.0, 1.0, 1.0, 1.0), "Emission Strength": 0.0,
    "Thin Film Thickness": 0.0, "Thin Film IOR": 1.33,
}  # fmt: skip
# Names before Blender 4.0. An index finds them; `in` and `get` do not, as in Blender 5.
_OLD_INPUTS = {
    "Emission": "Emission Color", "Transmission": "Transmission Weight", "Specular": "Specular IOR Level",
    "Subsurface": "Subsurface Weight", "Sheen": "Sheen Weight", "Clearcoat": "Coat Weight",
    "Clearcoat Roughness": "Coat Roughness",
}  # fmt: skip
_EMISSION = {"Color": (1.0, 1.0, 1.0, 1.0), "Strength": 1.0, "Weight": 0.0}
_COLORED = {"Color": (0.8, 0.8, 0.8, 1.0), "Roughness": 0.5, "IOR": 1.5, "Normal": (0.0, 0.0, 0.0)}
_GLASS = {"Color": (1.0, 1.0, 1.0, 1.0), "Roughness": 0.0, "IOR": 1.5, "Normal": (0.0, 0.0, 0.0)}
_OUTPUT = {"Surface": None, "Volume": None, "Displacement": None, "Thickness": 0.0}
NODE_INPUTS: dict[str, dict[str, Any]] = {
    "ShaderNodeBsdfPrincipled": _PRINCIPLED, "ShaderNodeEmission": _EMISSION, "ShaderNodeBsdfDiffuse": _COLORED,
    "ShaderNodeBsdfGlossy": _COLORED, "ShaderNodeBsdfGlass": _GLASS, "ShaderNodeOutputMaterial": _OUTPUT,
    "ShaderNodeBsdfTransparent": {"Color": (1.0, 1.0, 1.0, 1.0)},
}  # fmt: skip
_NODE_NAMES = {
    "ShaderNodeBsdfPrincipled": ("Principled BSDF", "BSDF_PRINCIPLED"), "ShaderNodeEmission": ("Emission", "EMISSION"),
    "ShaderNodeOutputMaterial": ("Material Output", "OUTPUT_MATERIAL"),
    "ShaderNodeBsdfDiffuse": ("Diffuse BSDF", "BSDF_DIFFUSE"), "ShaderNodeBsdfGlass": ("Glass BSDF", "BSDF_GLASS"),
    "ShaderNodeBsdfGlossy": ("Glossy BSDF", "BSDF_GLOSSY"), "ShaderNodeBackground": ("Background", "BACKGROUND"),
    "ShaderNodeTexNoise": ("Noise Texture", "TEX_NOISE"), "ShaderNodeValToRGB": ("Color Ramp", "VALTORGB"),
    "ShaderNodeOutputWorld": ("World Output", "OUTPUT_WORLD"), "ShaderNodeMixShader": ("Mix Shader", "MIX_SHADER"),
}  # fmt: skip


class Socket(Struct):
    """Input or output of a node."""

    python_name = "NodeSocket"
    shown = frozenset(words("name links is_linked node identifier keyframe_insert"))
    assigned = frozenset(("default_value",))
    ignored = frozenset(words("hide show_expanded hide_value enabled type"))

    def __init__(self, node: Any, name: str, default: Any) -> None:
        super().__init__()
        self.node, self.name, self.identifier = node, name, name
        self.default_value: Any = Numbers(default) if isinstance(default, tuple) else default
        if isinstance(self.default_value, Numbers):
            self.default_value.names = "rgba"
        self.links: list[Any] = []
        self.initial = default

    @property
    def is_linked(self) -> bool:
        """Return whether a link leads to it."""
        return bool(self.links)

    @property
    def is_changed(self) -> bool:
        """Return whether its value is not the initial one."""
        value = tuple(self.default_value) if isinstance(self.default_value, Numbers) else self.default_value
        return bool(value != self.initial)

    def assign(self, name: str, value: Any) -> None:
        if name == "default_value" and not isinstance(self.default_value, Numbers) and isinstance(value, (int, float)):
            self.default_value = float(value)
        elif name == "default_value" and isinstance(self.default_value, Numbers) and isinstance(value, (int, float)):
            raise TypeError("bpy_struct: item.attr = val: NodeSocketColor.default_value: expected a sequence")
        else:
            super().assign(name, value)

    def keyframe_insert(self, data_path: str = "", index: int = -1, frame: Any = None, **_: Any) -> bool:
        """Insert a keyframe, which a scene cannot show."""
        self.node.tree.blend.warn("keyframes of materials are left out")
        return True


class Sockets(StructList):
    """Inputs or outputs of a node; a node that is not known has every input that a script asks for."""

    def __init__(self, node: ShaderNode, known: dict[str, Any] | None) -> None:
        super().__init__()
        self._node, self._is_known = node, known is not None
        self.items_ = [Socket(node, name, default) for name, default in (known or {}).items()]

    def __getitem__(self, key: Any) -> Any:
        if not self._is_known:
            socket = next((item for item in self.items_ if item.name == str(key)), None)
            return socket or self.new_socket(str(key))
        if isinstance(key, str):
            return super().__getitem__(key if self.get(key) is not None else _OLD_INPUTS.get(key, key))
        return super().__getitem__(key)

    def get(self, name: str, default: Any = None) -> Any:
        item = super().get(name, None)
        return item if item is not None else default if self._is_known else self.new_socket(name)

    def new_socket(self, name: str) -> Socket:
        """Add a socket."""
        made = Socket(self._node, name, None)
        self.items_.append(made)
        return made


class ShaderNode(Struct):
    """Node of a material."""

    python_name = "Node"
    shown = frozenset(words("inputs outputs type bl_idname id_data keys get"))
    assigned = frozenset(("name", "label", "location"))

    def __init__(self, tree: NodeTree, kind: str) -> None:
        super().__init__()
        name, self.type = _NODE_NAMES.get(
            kind, (kind.removeprefix("ShaderNode"), kind.removeprefix("ShaderNode").upper())
        )
        taken = {node.name for node in tree.nodes.items_}
        self.name = next(n for n in (name, *(f"{name}.{i:03d}" for i in range(1, 10_000))) if n not in taken)
        self.label, self.location, self.bl_idname, self.tree = "", VectorValue((0.0, 0.0)), kind, tree
        self.inputs = Sockets(self, NODE_INPUTS.get(kind))
        self.outputs = Sockets(self, None)
        if kind in ("ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlass", "ShaderNodeBsdfGlossy"):
            self.outputs.items_ = [Socket(self, "BSDF", None)]
        elif kind == "ShaderNodeEmission":
            self.outputs.items_ = [Socket(self, "Emission", None)]
        self._settings = Settings()

    def read(self, name: str) -> Any:
        value = super().read(name)
        return self._settings.read(name) if value is MISSING else value

    def assign(self, name: str, value: Any) -> None:
        if name in self.assigned:
            super().assign(name, value)
        else:
            self._settings.assign(name, value)


@dataclass(eq=False)
class _Link:
    from_socket: Socket
    to_socket: Socket

    from_node = property(lambda self: self.from_socket.node)
    to_node = property(lambda self: self.to_socket.node)


class NodeLink(HostObject, _Link):
    """Link between two sockets."""

    python_name = "NodeLink"
    shown = frozenset(words("from_socket to_socket from_node to_node"))


class Links(StructList):
    """Links of a node tree."""

    def new(self, first: Any, second: Any, **_: Any) -> Any:
        """Link an output with an input, in either order."""
        if not isinstance(first, Socket) or not isinstance(second, Socket):
            return Settings()
        is_output = any(first is each for each in first.node.outputs.items_)
        link = NodeLink(first, second) if is_output else NodeLink(second, first)
        link.to_socket.links = [link]
        self.items_.append(link)
        return link

    def remove(self, item: Any) -> None:
        super().remove(item)
        item.to_socket.links = []


class NodeTree(DataBlock):
    """Nodes of a material."""

    python_name = "ShaderNodeTree"
    shown = DataBlock.shown | frozenset(("nodes", "links"))
    ignored = frozenset(("animation_data",))

    def __init__(self, blend: Blend) -> None:
        super().__init__(DataBlocks("node_groups", NodeTree), "Shader Nodetree")
        self.blend = blend
        self.nodes = StructList(lambda type="", **_: ShaderNode(self, type))
        self.links = Links()

    def with_principled(self) -> NodeTree:
        """Add the nodes of a new material."""
        shader, output = self.nodes.new("ShaderNodeBsdfPrincipled"), self.nodes.new("ShaderNodeOutputMaterial")
        self.links.new(shader.outputs.items_[0], output.inputs["Surface"])
        return self

    def surface(self) -> ShaderNode | None:
        """Return the node that the surface is made with."""
        output = next((n for n in self.nodes.items_ if n.bl_idname == "ShaderNodeOutputMaterial"), None)
        links = output.inputs["Surface"].links if output is not None else []
        node = links[0].from_node if links else None
        return node if node is not None and any(node is each for each in self.nodes.items_) else None


class Material(DataBlock):
    """Material."""

    python_name = "Material"
    shown = DataBlock.shown | frozenset(words("node_tree copy diffuse_color"))
    assigned = DataBlock.assigned | frozenset(words("diffuse_color metallic roughness use_nodes specular_color"))
    ignored = frozenset(
        words(
            "blend_method shadow_method use_backface_culling show_transparent_back use_screen_refraction "
            "surface_render_method alpha_threshold specular_intensity pass_index use_transparency_overlap "
            "use_raytrace_refraction thickness_mode refraction_depth displacement_method use_transparent_shadow "
            "cycles preview_render_type line_color roughness_ use_sss_translucency volume_intersection_method"
        )
    )

    def __init__(self, blend: Blend, name: str = "Material") -> None:
        super().__init__(blend.materials, name)
        self.blend = blend
        self.node_tree = NodeTree(blend).with_principled()
        self.diffuse_color = Numbers((0.8, 0.8, 0.8, 1.0))
        self.specular_color = Numbers((1.0, 1.0, 1.0))
        self.metallic, self.roughness, self.use_nodes = 0.0, 0.4, True

    def read(self, name: str) -> Any:
        if name == "cycles":
            return Settings()
        return super().read(name)

    def copy(self) -> Material:
        """Return a copy."""
        made = Material(self.blend, self.name)
        made.diffuse_color.set(self.diffuse_color)
        made.metallic, made.roughness = self.metallic, self.roughness
        made.node_tree = self._copied_tree()
        return made

    def _copied_tree(self) -> NodeTree:
        tree = NodeTree(self.blend)
        place: dict[int, ShaderNode] = {}
        for node in self.node_tree.nodes.items_:
            made = place[id(node)] = tree.nodes.new(node.bl_idname)
            made.name = node.name
            for old, new in ((node.inputs, made.inputs), (node.outputs, made.outputs)):
                new.items_ = [Socket(made, socket.name, socket.initial) for socket in old.items_]
                for source, target in zip(old.items_, new.items_, strict=True):
                    value = source.default_value
                    target.default_value = Numbers(value) if isinstance(value, Numbers) else value
        for link in self.node_tree.links.items_:
            start, end = place.get(id(link.from_node)), place.get(id(link.to_node))
            if start is not None and end is not None:
                tree.links.new(
                    start.outputs.items_[link.from_node.outputs.items_.index(link.from_socket)],
                    end.inputs.items_[link.to_node.inputs.items_.index(link.to_socket)],
                )
        return tree


# --- meshes ----------------------------------------------------------------------------------------------------------


class MeshVertex(Struct):
    """Corner of a mesh."""

    python_name = "MeshVertex"
    shown = frozenset(words("normal index groups"))
    assigned = frozenset(("co",))
    ignored = frozenset(words("select hide bevel_weight"))

    def __init__(self, mesh: MeshBlock, index: int, point: FloatArray) -> None:
        super().__init__()
        self.mesh, self.index = mesh, index
        self.co = VectorValue(point.tolist())
        self.groups: list[Any] = []

    @property
    def normal(self) -> VectorValue:
        """Return the normal of the corners as they are now."""
        return self.mesh.normal_at(self.index)


class MeshFace(Struct):
    """Face of a mesh."""

    python_name = "MeshPolygon"
    shown = frozenset(words("normal index vertices center area loop_indices loop_total loop_start edge_keys"))
    assigned = frozenset(("material_index", "use_smooth"))
    ignored = frozenset(("select", "hide"))

    def __init__(self, mesh: MeshBlock, index: int, corners: tuple[int, ...], slot: int, is_smooth: bool) -> None:
        super().__init__()
        self.mesh, self.index, self.vertices = mesh, index, corners
        self.material_index, self.use_smooth = slot, is_smooth
        self.loop_indices, self.loop_total, self.loop_start = range(0), len(corners), 0

    def _points(self) -> FloatArray:
        return np.array([self.mesh.corner_list()[c].co.values for c in self.vertices])

    @property
    def center(self) -> VectorValue:
        """Return the mean of the corners."""
        return VectorValue(self._points().mean(axis=0))

    @property
    def normal(self) -> VectorValue:
        """Return the normal."""
        return VectorValue(Polygons(self._points(), (tuple(range(len(self.vertices))),)).face_normals()[0])

    @property
    def area(self) -> float:
        """Return the area."""
        points = self._points()
        return float(np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)) / 2)

    @property
    def edge_keys(self) -> list[tuple[int, int]]:
        """Return the pairs of corners."""
        pairs = zip(self.vertices, (*self.vertices[1:], self.vertices[0]), strict=True)
        return [(min(pair), max(pair)) for pair in pairs]


class MaterialSlot(HostObject):
    """Slot of an object for a material: that of the mesh, or with the link OBJECT the object's own."""

    python_name = "MaterialSlot"
    shown = frozenset(("name", "material", "link", "slot_index"))

    def __init__(self, owner: Any, index: int) -> None:
        self._owner, self.slot_index = owner, index

    @property
    def link(self) -> str:
        """Return whose material it is."""
        return "OBJECT" if self.slot_index in self._owner.own_materials else "DATA"

    @property
    def material(self) -> Any:
        """Return the material."""
        own = self._owner.own_materials
        return own[self.slot_index] if self.slot_index in own else self._owner.data.materials.items_[self.slot_index]

    @property
    def name(self) -> str:
        """Return the name of the material."""
        return self.material.name if self.material is not None else ""

    def assign(self, name: str, value: Any) -> None:
        own = self._owner.own_materials
        if name == "link":
            if value == "OBJECT":
                own.setdefault(self.slot_index, None)
            else:
                own.pop(self.slot_index, None)
        elif name != "material":
            super().assign(name, value)
        elif self.slot_index in own:
            own[self.slot_index] = value
        else:
            self._owner.data.materials.items_[self.slot_index] = value


class MeshBlock(DataBlock):
    """Mesh: pieces, and its corners and faces once a script asks for them."""

    python_name = "Mesh"
    shown = DataBlock.shown | frozenset(
        words(
            "vertices polygons edges loops materials from_pydata update validate copy transform calc_normals "
            "shade_smooth shade_flat uv_layers vertex_colors attributes color_attributes shape_keys flip_normals "
            "clear_geometry calc_loop_triangles loop_triangles set_sharp_from_angle animation_data_create "
            "normals_split_custom_set"
        )
    )
    ignored = frozenset(words("use_auto_smooth auto_smooth_angle has_custom_normals remesh_voxel_size"))

    def __init__(self, blend: Blend, name: str = "Mesh") -> None:
        super().__init__(blend.meshes, name)
        self.blend = blend
        self.pieces: list[MeshPiece] = []
        self.materials = StructList()
        self._shown: tuple[list[MeshVertex], list[MeshFace], Polygons] | None = None
        self._around: list[list[MeshFace]] | None = None  # faces at every corner
        self.shape_keys = None
        self.uv_layers = self.vertex_colors = self.attributes = self.color_attributes = Settings()

    def read(self, name: str) -> Any:
        if name in ("use_auto_smooth", "auto_smooth_angle", "calc_normals"):
            return MISSING  # not in Blender 5
        return super().read(name)

    def assign(self, name: str, value: Any) -> None:
        if name in ("use_auto_smooth", "auto_smooth_angle"):
            raise AttributeError(f"'Mesh' object has no attribute '{name}'")
        super().assign(name, value)

    # --- what scripts see

    def _view(self) -> tuple[list[MeshVertex], list[MeshFace], Polygons]:
        if self._shown is None:
            made = polygons_of(self.pieces)
            self.blend.tick(len(made.points) + len(made.faces))
            vertices = [MeshVertex(self, i, point) for i, point in enumerate(made.points)]
            smooth = [piece.is_smooth for piece in self.pieces for _ in range(len(piece.polygons().faces))]
            rows = zip(made.faces, made.slots(), smooth, strict=True)
            faces = [MeshFace(self, i, face, slot, is_smooth) for i, (face, slot, is_smooth) in enumerate(rows)]
            self._shown = vertices, faces, made
        return self._shown

    def corner_list(self) -> list[MeshVertex]:
        """Return the corners."""
        return self._view()[0]

    @property
    def vertices(self) -> StructList:
        """Return the corners for scripts."""
        elements = _Elements(self)
        elements.items_ = self._view()[0]
        return elements

    @property
    def polygons(self) -> StructList:
        """Return the faces for scripts."""
        elements = _Elements(self)
        elements.items_ = self._view()[1]
        return elements

    @property
    def edges(self) -> list[Any]:
        """Return the edges for scripts."""
        return [_Edge(key) for key in self._view()[2].edges()]

    loops = loop_triangles = ()

    def normal_at(self, index: int) -> VectorValue:
        """Return the normal of a corner, which follows what the script has changed around it."""
        vertices, faces, _ = self._view()
        if self._around is None:
            self._around = [[] for _ in vertices]
            for face in faces:
                for corner in face.vertices:
                    self._around[corner].append(face)
        self.blend.tick(8)
        total = np.zeros(3)
        for face in self._around[index]:
            points = np.array([vertices[c].co.values for c in face.vertices])
            normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
            place = face.vertices.index(index)
            back, ahead = points[place - 1] - points[place], points[(place + 1) % len(points)] - points[place]
            lengths = float(np.linalg.norm(normal)), float(np.linalg.norm(back) * np.linalg.norm(ahead))
            if all(lengths):
                angle = math.acos(min(1.0, max(-1.0, float(back @ ahead) / lengths[1])))
                total += normal * (angle / lengths[0])
        return VectorValue(total).normalized()

    def settle(self) -> None:
        """Take over what a script has changed in corners and faces."""
        if self._shown is None:
            return
        vertices, faces, made = self._shown
        self._shown = self._around = None
        points = np.array([vertex.co.values for vertex in vertices]).reshape(-1, 3)
        slots = tuple(int(face.material_index) for face in faces)
        smooth = [bool(face.use_smooth) for face in faces]
        is_moved = len(points) and not np.allclose(points, made.points, atol=1e-9)
        if is_moved:
            self.blend.check_order(self.pieces)
        if is_moved or slots != made.slots():
            mesh = Polygons(points, made.faces, slots)
            self.pieces = [MeshPiece(np.eye(4), None, mesh, 0, bool(smooth) and all(smooth))]
        elif smooth:
            start = 0
            for i, piece in enumerate(self.pieces):
                count = len(piece.polygons().faces)
                if count:
                    self.pieces[i] = _shaded(piece, is_smooth=smooth[start])
                start += count

    def settled(self) -> list[MeshPiece]:
        """Return the pieces with the script's changes."""
        self.settle()
        return self.pieces

    def become(self, mesh: Polygons, is_smooth: bool = False) -> None:
        """Replace the geometry by polygons."""
        self._shown = self._around = None
        self.pieces = [MeshPiece(np.eye(4), None, mesh, 0, is_smooth)] if len(mesh.points) else []

    def from_pydata(self, vertices: Any, edges: Any, faces: Any, shade_flat: bool = True) -> None:
        """Build the mesh from lists."""
        points = np.array([[float(value) for value in point] for point in vertices]).reshape(-1, 3)
        made = tuple(tuple(int(corner) for corner in face) for face in faces)
        count = len(points)
        if any(not -count <= corner < count for face in made for corner in face):
            raise UnsupportedPython("a face of this mesh has a corner that does not exist")
        self.become(Polygons(points, made))

    def update(self, **_: Any) -> None:
        """Do nothing."""

    calc_normals = calc_loop_triangles = normals_split_custom_set = set_sharp_from_angle = update

    def animation_data_create(self) -> Any:
        """Return animation data that a scene cannot show."""
        raise UnsupportedPython("animations of meshes are not supported")

    def validate(self, verbose: bool = False, clean_customdata: bool = True) -> bool:
        """Return that nothing was wrong."""
        return False

    def clear_geometry(self) -> None:
        """Remove all geometry."""
        self.become(polygons.EMPTY)

    def flip_normals(self) -> None:
        """Turn all faces around."""
        self.become(polygons_of(self.settled()).flipped())

    def transform(self, matrix: Any, shape_keys: bool = False) -> None:
        """Move the geometry."""
        self.pieces = [piece.moved(np.array(matrix.numbers)) for piece in self.settled()]

    def shade_smooth(self) -> None:
        """Shade the mesh smooth."""
        self.pieces = [_shaded(piece, is_smooth=True) for piece in self.settled()]

    def shade_flat(self) -> None:
        """Shade the mesh flat."""
        self.pieces = [_shaded(piece, is_smooth=False) for piece in self.settled()]

    def copy(self) -> MeshBlock:
        """Return a copy."""
        made = MeshBlock(self.blend, self.name)
        made.pieces = list(self.settled())
        made.materials.items_ = list(self.materials.items_)
        return made


def _shaded(piece: MeshPiece, *, is_smooth: bool) -> MeshPiece:
    from dataclasses import replace

    return replace(piece, is_smooth=is_smooth)


class _Edge(HostObject):
    python_name = "MeshEdge"
    shown = frozenset(("vertices", "key"))

    def __init__(self, key: tuple[int, int]) -> None:
        self.vertices = self.key = key

    def assign(self, name: str, value: Any) -> None:
        """Marks of edges mean nothing."""


class _Elements(StructList):
    """Corners or faces of a mesh."""

    shown = StructList.shown | frozenset(("foreach_get", "foreach_set", "add"))

    def __init__(self, mesh: MeshBlock) -> None:
        super().__init__()
        self._mesh = mesh

    def foreach_get(self, name: str, target: Any) -> None:
        """Copy an attribute of all into a sequence."""
        values: list[Any] = []
        for item in self.items_:
            value = getattr(item, name) if name in (*type(item).assigned, *type(item).shown) else 0
            values += [*value] if isinstance(value, Numbers) else [value]
        target[:] = values if isinstance(target, list) else np.array(values)

    def foreach_set(self, name: str, values: Any) -> None:
        """Assign an attribute of all from a sequence."""
        flat = [*values]
        size = len(flat) // max(1, len(self.items_))
        for i, item in enumerate(self.items_):
            part = flat[i * size : (i + 1) * size]
            item.assign(name, part if size > 1 else part[0])

    def add(self, count: int) -> None:
        """Add corners or faces without a place."""
        raise UnsupportedPython("`add` of corners is not supported", "use `mesh.from_pydata`")


# --- objects ---------------------------------------------------------------------------------------------------------


class WorldMatrix(MatrixValue):
    """World matrix of an object, whose translation can be assigned."""

    def __init__(self, owner: Object) -> None:
        super().__init__(owner.world)
        self._owner = owner

    def copy(self) -> MatrixValue:
        return MatrixValue(self.numbers)

    def assign(self, name: str, value: Any) -> None:
        super().assign(name, value)
        self._owner.matrix_world = self

    def __setitem__(self, index: Any, value: Any) -> None:
        super().__setitem__(index, value)
        self._owner.matrix_world = self


class Modifier(Struct):
    """Modifier: settings by name, with Blender's defaults."""

    python_name = "Modifier"
    shown = frozenset(("type", "keyframe_insert"))

    def __init__(self, blend: Blend, name: str, kind: str, defaults: dict[str, Any]) -> None:
        super().__init__()
        self.blend, self.name, self.type, self._defaults = blend, name, kind, defaults
        self.settings: dict[str, Any] = {
            key: (VectorValue(value) if len(value) == 3 and type(value[0]) is float else list(value))
            if isinstance(value, tuple)
            else value
            for key, value in defaults.items()
        }

    _ALWAYS = frozenset(words("show_viewport show_render show_in_editmode show_on_cage show_expanded"))

    def read(self, name: str) -> Any:
        if name == "name":
            return self.name
        if name in self.settings:
            return self.settings[name]
        return True if name in self._ALWAYS else super().read(name)

    def assign(self, name: str, value: Any) -> None:
        if name == "name":
            self.name = str(value)
        elif name in self.settings or name in self._ALWAYS:
            old = self.settings.get(name)
            if isinstance(old, VectorValue):
                old.set(value)
            elif isinstance(old, list):
                old[:] = [*value]
            else:
                self.settings[name] = value
        elif not self._defaults:
            self.settings[name] = value  # of a kind that is refused when it is applied
        else:
            raise AttributeError(f"'{self.type.title()}Modifier' object has no attribute '{name}'")

    def keyframe_insert(self, *_: Any, **__: Any) -> bool:
        """Insert a keyframe, which a scene cannot show."""
        raise UnsupportedPython("keyframes of modifiers are not supported")


_IGNORED_OBJECT = words(
    "display_type show_name show_axis show_wire show_in_front show_all_edges show_transparent pass_index color "
    "empty_display_size empty_display_type show_instancer_for_viewport show_instancer_for_render visible_shadow "
    "visible_camera visible_diffuse visible_glossy visible_transmission visible_volume_scatter is_holdout "
    "is_shadow_catcher show_bounds display_bounds_type lock_location lock_rotation lock_scale "
    "hide_select"
)


class Object(DataBlock):
    """Object with a transform; ``data`` is a mesh, or what a scene cannot show."""

    python_name = "Object"
    shown = DataBlock.shown | frozenset(
        words(
            "data type copy select_set select_get hide_set hide_get keyframe_insert keyframe_delete modifiers "
            "children children_recursive users_collection material_slots constraints animation_data "
            "animation_data_create animation_data_clear evaluated_get to_mesh to_mesh_clear bound_box vertex_groups "
            "convert_space dimensions matrix_world matrix_local matrix_basis users_scene visible_get "
            "closest_point_on_mesh shape_key_add ray_cast particle_systems rigid_body soft_body field driver_add "
            "cycles is_evaluated original delta_location delta_rotation_euler delta_scale mode update_from_editmode"
        )
    )
    assigned = DataBlock.assigned | frozenset(
        words(
            "location rotation_euler rotation_quaternion rotation_axis_angle rotation_mode scale parent parent_type "
            "matrix_parent_inverse matrix_world matrix_local matrix_basis dimensions active_material data "
            "active_material_index hide_render hide_viewport instance_type instance_collection delta_location "
            "delta_rotation_euler delta_scale"
        )
    )
    ignored = frozenset(_IGNORED_OBJECT)

    def __init__(self, blend: Blend, name: str, data: Any) -> None:
        super().__init__(blend.objects, name)
        self.blend, self.data = blend, data
        self.origin = tuple(blend.calls)
        self.number = blend.counted()
        self.node = blend.evaluator.node if blend.evaluator is not None else None
        self.location, self.scale = VectorValue(), VectorValue((1.0, 1.0, 1.0))
        self.delta_location, self.delta_scale = VectorValue(), VectorValue((1.0, 1.0, 1.0))
        self.delta_rotation_euler = Euler()
        self.rotation_euler, self.rotation_quaternion = Euler(), Quaternion()
        self.rotation_axis_angle = Numbers((0.0, 0.0, 1.0, 0.0))
        self.rotation_mode = "XYZ"
        self._parent: Object | None = None
        self.parent_type = "OBJECT"
        self.matrix_parent_inverse: Any = MatrixValue()
        self.children_: list[Object] = []
        self.world: FloatArray = np.eye(4)
        self.modifiers = StructList(lambda name="", type="": blend.new_modifier(name, type))
        self.constraints = Constraints(self)
        self.vertex_groups = Settings()
        self.animation: Animation | None = None
        self.own_materials: dict[int, Any] = {}  # of slots whose link is OBJECT
        self.is_selected = False
        self.is_hidden = False
        self.hide_render = self.hide_viewport = False
        self.active_material_index = 0
        self.instance_type, self.instance_collection = "NONE", None
        blend.touched[id(self)] = self

    # --- attributes

    def read(self, name: str) -> Any:
        self.blend.touched[id(self)] = self
        if name in (
            "particle_systems",
            "rigid_body",
            "rigid_body_constraint",
            "soft_body",
            "field",
            "collision",
            "pose",
        ):
            raise UnsupportedPython(f"`{name}` of objects is not supported: simulations are not part of a scene")
        if name == "cycles":
            return Settings()
        return super().read(name)

    def assign(self, name: str, value: Any) -> None:
        self.blend.touched[id(self)] = self
        super().assign(name, value)

    mode = property(lambda self: self.blend.mode if self.blend.active is self else "OBJECT")
    users_scene = property(lambda self: [self.blend.scene])
    is_evaluated = False
    original = property(lambda self: self)

    @property
    def type(self) -> str:
        """Return the kind of object."""
        return (
            "EMPTY" if self.data is None else "MESH" if isinstance(self.data, MeshBlock) else str(self.data.object_type)
        )

    @property
    def children(self) -> tuple[Object, ...]:
        """Return the objects whose parent it is."""
        return tuple(self.children_)

    @property
    def children_recursive(self) -> list[Object]:
        """Return all objects below it."""
        return [each for child in self.children_ for each in (child, *child.children_recursive)]

    @property
    def parent(self) -> Object | None:
        """Return the parent."""
        return self._parent

    @parent.setter
    def parent(self, parent: Object | None) -> None:
        above = parent
        while above is not None:
            if above is self:
                raise UnsupportedPython("an object cannot be its own ancestor")
            above = above.parent
        if self._parent is not None:
            self._parent.children_.remove(self)
        self._parent = parent
        if parent is not None:
            parent.children_.append(self)

    @property
    def users_collection(self) -> tuple[Any, ...]:
        """Return the collections that it is in."""
        every = [self.blend.scene.collection, *self.blend.collections.listed()]
        return tuple(each for each in every if any(o is self for o in each.objects.items_))

    @property
    def material_slots(self) -> list[MaterialSlot]:
        """Return the slots for materials."""
        if not isinstance(self.data, MeshBlock):
            return []
        return [MaterialSlot(self, i) for i in range(len(self.data.materials))]

    def materials(self) -> list[Any]:
        """Return the materials of its slots."""
        return [slot.material for slot in self.material_slots]

    @property
    def active_material(self) -> Any:
        """Return the active material."""
        materials = self.materials()
        return materials[min(self.active_material_index, len(materials) - 1)] if materials else None

    @active_material.setter
    def active_material(self, material: Any) -> None:
        if not isinstance(self.data, MeshBlock):
            return
        materials = self.data.materials.items_
        if materials:
            materials[min(self.active_material_index, len(materials) - 1)] = material
        else:
            materials.append(material)

    # --- transforms

    def rotation(self) -> FloatArray:
        """Return the rotation (3, 3) by the mode."""
        if self.rotation_mode == "QUATERNION":
            turn = self.rotation_quaternion.to_matrix().numbers
        elif self.rotation_mode == "AXIS_ANGLE":
            angle, x, y, z = self.rotation_axis_angle.values
            turn = Quaternion((x, y, z), angle).to_matrix().numbers
        else:
            turn = Euler(self.rotation_euler.values, self.rotation_mode).to_matrix().numbers
        made: FloatArray = self.delta_rotation_euler.to_matrix().numbers @ turn
        return made

    def basis(self) -> FloatArray:
        """Return the matrix of location, rotation and scale."""
        location = self.location.array() + self.delta_location.array()
        return composed(location, self.rotation(), self.scale.array() * self.delta_scale.array())

    def local(self) -> FloatArray:
        """Return the matrix relative to the parent."""
        return self.matrix_parent_inverse.numbers @ self.basis()  # type: ignore[no-any-return]

    def computed_world(self) -> FloatArray:
        """Return the world matrix of the present values."""
        if self._parent is None:
            return self.basis()
        return self._parent.computed_world() @ self.local()

    @property
    def matrix_world(self) -> Any:
        """Return the world matrix of the last update."""
        return WorldMatrix(self)

    @matrix_world.setter
    def matrix_world(self, matrix: Any) -> None:
        numbers = matrix.to_4x4().numbers
        above = self._parent.world @ self.matrix_parent_inverse.numbers if self._parent is not None else np.eye(4)
        self.matrix_basis = MatrixValue(np.linalg.inv(above) @ numbers)
        self.world = np.array(numbers)

    @property
    def matrix_local(self) -> Any:
        """Return the matrix relative to the parent."""
        return MatrixValue(self.local() if self._parent is not None else self.basis())

    @matrix_local.setter
    def matrix_local(self, matrix: Any) -> None:
        self.matrix_basis = MatrixValue(np.linalg.inv(self.matrix_parent_inverse.numbers) @ matrix.to_4x4().numbers)

    @property
    def matrix_basis(self) -> Any:
        """Return the matrix of location, rotation and scale."""
        return MatrixValue(self.basis())

    @matrix_basis.setter
    def matrix_basis(self, matrix: Any) -> None:
        location, rotation, scale = decomposed(matrix.to_4x4().numbers)
        self.location.set(location)
        self.scale.set(scale)
        self.turn(rotation)

    def turn(self, rotation: FloatArray) -> None:
        """Set the rotation (3, 3)."""
        quaternion = MatrixValue(rotation).to_quaternion()
        if self.rotation_mode == "QUATERNION":
            self.rotation_quaternion.set(quaternion)
        elif self.rotation_mode == "AXIS_ANGLE":
            axis, angle = quaternion.to_axis_angle()
            self.rotation_axis_angle.set([angle, *axis])
        else:
            self.rotation_euler.set(MatrixValue(rotation).to_euler(self.rotation_mode).values)

    def box(self) -> FloatArray:
        """Return the lower and the upper corner (2, 3) of the geometry in its own frame."""
        mesh = self.blend.evaluated_polygons(self) if isinstance(self.data, MeshBlock) else None
        if mesh is None or not len(mesh.points):
            return np.zeros((2, 3))
        return np.array([mesh.points.min(axis=0), mesh.points.max(axis=0)])

    @property
    def bound_box(self) -> list[VectorValue]:
        """Return the corners of the box of the geometry."""
        low, high = self.box()
        order = [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)]
        return [
            VectorValue((high[0] if i else low[0], high[1] if j else low[1], high[2] if k else low[2]))
            for i, j, k in order
        ]

    @property
    def dimensions(self) -> VectorValue:
        """Return the sizes of the box under the scale."""
        low, high = self.box()
        return _Dimensions(self, np.abs(self.scale.array()) * (high - low))

    @dimensions.setter
    def dimensions(self, sizes: Any) -> None:
        low, high = self.box()
        for axis, size in enumerate(sizes):
            extent = float(high[axis] - low[axis])
            if extent > 1e-9:
                self.scale[axis] = float(size) / extent

    # --- methods

    def copy(self) -> Object:
        """Return a copy that shares the data and is in no collection."""
        made = Object(self.blend, self.name, self.data)
        for name in ("location", "scale", "rotation_euler", "rotation_quaternion", "rotation_axis_angle",
                     "delta_location", "delta_scale", "delta_rotation_euler"):  # fmt: skip
            getattr(made, name).set(getattr(self, name))
        made.rotation_mode, made.world = self.rotation_mode, self.world.copy()
        made.matrix_parent_inverse = self.matrix_parent_inverse.copy()
        made.parent = self.parent
        made.hide_render, made.hide_viewport, made.is_selected = self.hide_render, self.hide_viewport, self.is_selected
        made.properties = dict(self.properties)
        made.own_materials = dict(self.own_materials)
        made.instance_type, made.instance_collection = self.instance_type, self.instance_collection
        made.animation = self.animation.copy() if self.animation is not None else None
        made.constraints.items_ = list(self.constraints.items_)
        for modifier in self.modifiers.items_:
            copied = self.blend.new_modifier(modifier.name, modifier.type)
            for key, value in modifier.settings.items():
                copied.assign(key, value)
            made.modifiers.items_.append(copied)
        return made

    def select_set(self, state: bool = True, view_layer: Any = None) -> None:
        """Select or deselect it."""
        self.is_selected = bool(state)

    def select_get(self, view_layer: Any = None) -> bool:
        """Return whether it is selected."""
        return self.is_selected

    def hide_set(self, state: bool, view_layer: Any = None) -> None:
        """Hide it in the viewport, which a picture does not show."""
        self.is_hidden = bool(state)

    def hide_get(self, view_layer: Any = None) -> bool:
        """Return whether it is hidden."""
        return self.is_hidden

    def visible_get(self, **_: Any) -> bool:
        """Return whether it is visible."""
        return not self.is_hidden and not self.hide_viewport

    def keyframe_insert(self, data_path: str, index: int = -1, frame: Any = None, **_: Any) -> bool:
        """Insert keyframes of the present values."""
        moment = float(self.blend.scene.frame_current if frame is None else frame)
        if data_path in ("hide_render", "hide_viewport"):
            raise UnsupportedPython(f"keyframes of `{data_path}` are not supported")
        if data_path not in ("location", "rotation_euler", "rotation_quaternion", "scale"):
            raise UnsupportedPython(f"keyframes of `{data_path}` are not supported")
        if self.animation is None:
            self.animation = Animation(self.name)
        values = getattr(self, data_path).values
        for place in range(len(values)) if index < 0 else [index]:
            self.animation.insert(data_path, place, moment, values[place])
        return True

    def keyframe_delete(self, *_: Any, **__: Any) -> bool:
        """Delete keyframes."""
        raise UnsupportedPython("`keyframe_delete` is not supported")

    @property
    def animation_data(self) -> Any:
        """Return the keyframes."""
        return self.animation

    def animation_data_create(self) -> Any:
        """Return new keyframes."""
        self.animation = self.animation or Animation(self.name)
        return self.animation

    def animation_data_clear(self) -> None:
        """Remove all keyframes."""
        self.animation = None

    def driver_add(self, *_: Any) -> Any:
        """Add a driver."""
        raise UnsupportedPython("drivers are not supported")

    def shape_key_add(self, *_: Any, **__: Any) -> Any:
        """Add a shape key."""
        raise UnsupportedPython("shape keys are not supported")

    def ray_cast(self, *_: Any, **__: Any) -> Any:
        """Cast a ray."""
        raise UnsupportedPython("`ray_cast` is not supported")

    closest_point_on_mesh = ray_cast

    def evaluated_get(self, depsgraph: Any) -> Object:
        """Return the object itself."""
        return self

    def to_mesh(self, **_: Any) -> MeshBlock:
        """Return its mesh with all modifiers."""
        made = MeshBlock(self.blend, self.name)
        self.blend.meshes.by_name.pop(made.name)
        made.pieces = self.blend.evaluated(self)
        made.materials.items_ = list(self.data.materials.items_)
        return made

    def to_mesh_clear(self) -> None:
        """Do nothing."""

    def update_from_editmode(self) -> bool:
        """Return that nothing was to be done."""
        return False

    def convert_space(self, *_: Any, **__: Any) -> Any:
        """Convert between spaces."""
        raise UnsupportedPython("`convert_space` is not supported")


class _Dimensions(VectorValue):
    def __init__(self, owner: Object, sizes: FloatArray) -> None:
        super().__init__(sizes)
        self._owner = owner

    def copy(self) -> VectorValue:
        return VectorValue(self.values)

    def __setitem__(self, index: Any, value: Any) -> None:
        super().__setitem__(index, value)
        self._owner.dimensions = self.values

    def assign(self, name: str, value: Any) -> None:
        super().assign(name, value)
        self._owner.dimensions = self.values


class Constraints(StructList):
    """Constraints, which a scene cannot show: of cameras and lights they do not matter."""

    def __init__(self, owner: Object) -> None:
        super().__init__(lambda type="": Settings(type=type))
        self._owner = owner

    def new(self, *arguments: Any, **named: Any) -> Any:
        """Add a constraint."""
        if self._owner.type not in ("CAMERA", "LIGHT"):
            raise UnsupportedPython("constraints are not supported", "set location and rotation instead")
        return super().new(*arguments, **named)


class OtherData(DataBlock):
    """Data of a camera, a light or another kind of object that a scene cannot show."""

    def __init__(self, blocks: DataBlocks, name: str, object_type: str) -> None:
        super().__init__(blocks, name)
        self.object_type = object_type
        self._settings = Settings(energy=10.0, lens=50.0, type="POINT", size=1.0, angle=0.5, color=Numbers((1, 1, 1)))

    def read(self, name: str) -> Any:
        if name == "copy":
            return Native("copy", lambda: OtherData(self.blocks, self.name, self.object_type))
        value = super().read(name)
        return self._settings.read(name) if value is MISSING else value

    def assign(self, name: str, value: Any) -> None:
        if name in self.assigned:
            super().assign(name, value)
        else:
            self._settings.assign(name, value)


# --- collections, scene and context ----------------------------------------------------------------------------------


class CollectionBlock(DataBlock):
    """Collection of objects and other collections."""

    python_name = "Collection"
    shown = DataBlock.shown | frozenset(words("objects children all_objects children_recursive"))
    assigned = DataBlock.assigned | frozenset(("hide_render", "hide_viewport"))
    ignored = frozenset(("color_tag", "hide_select", "instance_offset", "lineart_usage"))

    def __init__(self, blend: Blend, name: str = "Collection", blocks: DataBlocks | None = None) -> None:
        super().__init__(blocks or blend.collections, name)
        self.objects = _CollectionObjects(blend)
        self.children = StructList()
        self.hide_render = self.hide_viewport = False

    @property
    def children_recursive(self) -> list[CollectionBlock]:
        """Return all collections below it."""
        return [each for child in self.children.items_ for each in (child, *child.children_recursive)]

    @property
    def all_objects(self) -> list[Object]:
        """Return all objects in it and below it."""
        objects = dict.fromkeys(o for each in (self, *self.children_recursive) for o in each.objects.items_)
        return list(objects)


class _CollectionObjects(StructList):
    def __init__(self, blend: Blend) -> None:
        super().__init__()
        self._blend = blend

    def link(self, item: Any) -> None:
        """Link an object."""
        if not isinstance(item, Object):
            raise TypeError('CollectionObjects.link(): error with argument 1, "object" - expected an Object')
        if any(each is item for each in self.items_):
            raise RuntimeError(f"Error: Object '{item.name}' already in collection")
        self.items_.append(item)


class LayerCollection(HostObject):
    """Collection in the view layer."""

    python_name = "LayerCollection"
    shown = frozenset(words("collection children exclude hide_viewport name"))

    def __init__(self, collection: CollectionBlock) -> None:
        self.collection, self.exclude, self.hide_viewport = collection, False, False
        self._children: dict[int, LayerCollection] = {}
        self.name = collection.name

    @property
    def children(self) -> StructList:
        """Return the collections in it."""
        layers = StructList()
        for each in self.collection.children.items_:
            layers.items_.append(self._children.setdefault(id(each), LayerCollection(each)))
        return layers

    def assign(self, name: str, value: Any) -> None:
        if name == "exclude":
            self.collection.hide_render = bool(value)
        elif name != "hide_viewport":
            super().assign(name, value)


class SceneBlock(DataBlock):
    """The scene."""

    python_name = "Scene"
    shown = DataBlock.shown | frozenset(
        words("collection objects frame_set view_layers keyframe_insert timeline_markers cursor")
    )
    assigned = DataBlock.assigned | frozenset(words("camera world frame_current frame_start frame_end frame_step"))

    def __init__(self, blend: Blend) -> None:
        super().__init__(blend.scenes, "Scene")
        self.blend = blend
        self.collection = CollectionBlock(blend, "Scene Collection", DataBlocks("collections", CollectionBlock))
        self.camera: Any = None
        self.world: Any = Settings(name="World")
        self.frame_current, self.frame_start, self.frame_end, self.frame_step = 1, 1, 250, 1
        self.cursor = Settings(location=VectorValue(), rotation_euler=Euler())
        self.timeline_markers = Settings()
        self._settings = Settings()

    def read(self, name: str) -> Any:
        if name in ("frame_current", "frame_start", "frame_end"):
            return int(getattr(self, name))
        if name in ("rigidbody_world",):
            raise UnsupportedPython("rigid bodies are not supported: `scenelang check --physics` simulates a scene")
        value = super().read(name)
        return self._settings.read(name) if value is MISSING else value

    def assign(self, name: str, value: Any) -> None:
        if name in self.assigned:
            super().assign(name, value)
        else:
            self._settings.assign(name, value)

    @property
    def view_layers(self) -> list[Any]:
        """Return the view layers."""
        return [self.blend.context.view_layer]

    @property
    def objects(self) -> StructList:
        """Return all objects of the scene."""
        objects = StructList()
        objects.items_ = self.collection.all_objects
        return objects

    def frame_set(self, frame: int, subframe: float = 0.0) -> None:
        """Go to a frame."""
        self.frame_current = int(frame)
        for each in self.collection.all_objects:
            if each.animation is not None:
                each.animation.apply(each, float(frame) + subframe)
        self.blend.update(is_full=True)

    def keyframe_insert(self, *_: Any, **__: Any) -> bool:
        """Insert a keyframe of a setting."""
        raise UnsupportedPython("keyframes of the scene are not supported")


class ViewLayer(HostObject):
    """The view layer."""

    python_name = "ViewLayer"
    shown = frozenset(words("objects update layer_collection active_layer_collection depsgraph name"))
    name = "ViewLayer"

    def __init__(self, blend: Blend) -> None:
        self._blend = blend
        self.layer_collection = LayerCollection(blend.scene.collection)
        self.depsgraph = Depsgraph(blend)

    @property
    def objects(self) -> Any:
        """Return the objects, with the active and the selected ones."""
        return LayerObjects(self._blend)

    @property
    def active_layer_collection(self) -> LayerCollection:
        """Return the collection to which operators add objects."""
        return LayerCollection(self._blend.collection)

    def assign(self, name: str, value: Any) -> None:
        if name == "active_layer_collection":
            self._blend.collection = value.collection
        elif name not in ("use_pass_z", "samples"):
            super().assign(name, value)

    def update(self) -> None:
        """Update all world matrices."""
        self._blend.update()


class LayerObjects(StructList):
    """Objects of the view layer."""

    shown = StructList.shown | frozenset(("selected",))

    def __init__(self, blend: Blend) -> None:
        self._blend = blend
        super().__init__()
        self.items_ = blend.scene.collection.all_objects
        self.active = blend.active

    @property
    def selected(self) -> list[Object]:
        """Return the selected objects."""
        return self._blend.selected()

    def assign(self, name: str, value: Any) -> None:
        if name != "active":
            super().assign(name, value)
        self._blend.active = value


class Depsgraph(HostObject):
    """Dependency graph: objects are their own evaluated copies."""

    python_name = "Depsgraph"
    shown = frozenset(words("update objects object_instances scene"))

    def __init__(self, blend: Blend) -> None:
        self._blend = blend

    @property
    def objects(self) -> list[Object]:
        """Return the objects."""
        return self._blend.scene.collection.all_objects

    scene = property(lambda self: self._blend.scene)

    @property
    def object_instances(self) -> Any:
        """Return instances."""
        raise UnsupportedPython("`object_instances` is not supported")

    def update(self) -> None:
        """Update all world matrices."""
        self._blend.update()


class BlendContext(HostObject):
    """`bpy.context`."""

    python_name = "Context"
    shown = frozenset(
        words(
            "object active_object selected_objects selected_editable_objects scene collection view_layer mode "
            "evaluated_depsgraph_get preferences window_manager window screen area region space_data blend_data "
            "editable_objects visible_objects selectable_objects temp_override copy tool_settings layer_collection "
            "workspace edit_object"
        )
    )

    def __init__(self, blend: Blend) -> None:
        self._blend = blend
        self.view_layer = ViewLayer(blend)
        self.preferences = blend.preferences
        self.window_manager = self.window = self.screen = self.tool_settings = self.workspace = Settings()
        self.area = self.region = self.space_data = None

    object = active_object = property(lambda self: self._blend.active)
    selected_objects = selected_editable_objects = property(lambda self: self._blend.selected())
    scene = property(lambda self: self._blend.scene)
    collection = property(lambda self: self._blend.collection)
    layer_collection = property(lambda self: LayerCollection(self._blend.collection))
    blend_data = property(lambda self: self._blend.data)
    edit_object = property(lambda self: self._blend.active if self._blend.mode.startswith("EDIT") else None)
    visible_objects = editable_objects = selectable_objects = property(
        lambda self: [o for o in self._blend.scene.collection.all_objects if not o.is_hidden]
    )

    @property
    def mode(self) -> str:
        """Return the mode."""
        return "EDIT_MESH" if self._blend.mode == "EDIT" else str(self._blend.mode)

    def evaluated_depsgraph_get(self) -> Depsgraph:
        """Return the dependency graph, updated."""
        self._blend.update()
        return Depsgraph(self._blend)

    def temp_override(self, **named: Any) -> Any:
        """Return a context manager that overrides the active and the selected objects."""
        return Override(self._blend, named)

    def copy(self) -> dict[str, Any]:
        """Return the context as a dictionary."""
        return {"object": self._blend.active, "selected_objects": self._blend.selected()}


class Override(HostObject):
    """Context manager of `temp_override`."""

    shown = frozenset(("__enter__", "__exit__"))

    def __init__(self, blend: Blend, named: dict[str, Any]) -> None:
        self._blend, self._named = blend, named
        self._before: Any = None

    def __enter__(self) -> Override:
        blend = self._blend
        self._before = blend.active, blend.selected()
        chosen = self._named.get("active_object", self._named.get("object"))
        if chosen is not None:
            blend.active = chosen
        if "selected_objects" in self._named or "selected_editable_objects" in self._named:
            blend.select(self._named.get("selected_editable_objects", self._named.get("selected_objects")))
        return self

    def __exit__(self, *_: Any) -> Literal[False]:
        active, selected = self._before
        alive = set(map(id, self._blend.objects.listed()))
        self._blend.active = active if active is not None and id(active) in alive else self._blend.active
        self._blend.select([each for each in selected if id(each) in alive])
        return False


@dataclass(frozen=True, slots=True)
class ScriptCall:
    """Call of a function of the script: its name, a number of its own, and its arguments."""

    name: str
    number: int
    arguments: dict[str, Any] = field(default_factory=dict)


class Blend:
    """State of Blender while a script is followed: the startup file, unless the script changes it."""

    def __init__(self) -> None:
        self.evaluator: Any = None
        self.calls: list[ScriptCall] = []
        self.warnings: dict[str, Any] = {}  # messages with the nodes where they arose first
        self.touched: dict[int, Object] = {}
        self.selects_by_number = False  # whether the script draws or counts, so that the order of corners may matter
        self._counter = 0
        self.objects = DataBlocks("objects", self._new_object, self.forget)
        self.meshes = DataBlocks("meshes", lambda name="Mesh": MeshBlock(self, name), self._forget_data)
        self.materials = DataBlocks("materials", lambda name="Material": Material(self, name))
        self.collections = DataBlocks(
            "collections", lambda name="Collection": CollectionBlock(self, name), self._forget_collection
        )
        self.scenes = DataBlocks("scenes", self._no_new("scenes"))
        self.cameras = DataBlocks(
            "cameras", lambda name="Camera": self.other(self.cameras, name, "CAMERA"), self._forget_data
        )
        self.lights = DataBlocks(
            "lights", lambda name="Light", type="POINT": self.other(self.lights, name, "LIGHT"), self._forget_data
        )
        self.worlds = DataBlocks("worlds", lambda name="World": _World(self.worlds, name))
        self.preferences = Settings()
        self.mode = "OBJECT"
        self.active: Object | None = None
        self.scene = SceneBlock(self)
        self.scene.world = _World(self.worlds, "World")
        self.collection = CollectionBlock(self, "Collection")
        self.scene.collection.children.link(self.collection)
        self.context = BlendContext(self)
        self.data = Data(self)
        self.apply_modifiers: Callable[[Blend, Object], list[MeshPiece]] = lambda blend, obj: obj.data.settled()
        self.modifier_defaults: dict[str, dict[str, Any]] = {}
        self.edit: Any = None  # the mesh in edit mode
        self._add_startup_objects()

    def _add_startup_objects(self) -> None:
        from scenelang.backends.blender.pieces import PieceForm

        mesh = MeshBlock(self, "Cube")
        matrix = np.diag([2.0, 2.0, 2.0, 1.0])
        mesh.pieces = [MeshPiece(matrix, PieceForm("cube"))]
        mesh.materials.append(Material(self, "Material"))
        box = Object(self, "Cube", mesh)
        camera = Object(self, "Camera", OtherData(self.cameras, "Camera", "CAMERA"))
        light = Object(self, "Light", OtherData(self.lights, "Light", "LIGHT"))
        camera.location.set((7.3589, -6.9258, 4.9583))
        camera.rotation_euler.set((1.1093, 0.0, 0.8149))
        light.location.set((4.0762, 1.0055, 5.9039))
        for each in (box, light, camera):
            self.collection.objects.link(each)
        box.is_selected = True
        self.active, self.scene.camera = box, camera
        self.update()

    def _no_new(self, kind: str) -> Callable[..., Any]:
        def refuse(*_: Any, **__: Any) -> Any:
            raise UnsupportedPython(f"`bpy.data.{kind}.new` is not supported")

        return refuse

    def other(self, blocks: DataBlocks, name: str, object_type: str) -> OtherData:
        """Create data of a camera or a light, with a warning."""
        self.warn_left_out(object_type)
        return OtherData(blocks, name, object_type)

    def warn_left_out(self, object_type: str) -> None:
        """Warn that cameras or lights are left out."""
        kind = {"CAMERA": "cameras are", "LIGHT": "lights are"}[object_type]
        self.warn(f"{kind} not part of a scene, and are left out; `scenelang render` has options for them")

    def tick(self, count: int = 1) -> None:
        """Count steps."""
        if self.evaluator is not None:
            self.evaluator.tick(count)

    def warn(self, message: str, node: Any = None) -> None:
        """Warn once of what is left out or replaced."""
        at = node if node is not None else self.evaluator.node if self.evaluator is not None else None
        self.warnings.setdefault(message, at)

    def check_order(self, pieces: Sequence[MeshPiece]) -> None:
        """Raise UnsupportedPython if corners are changed whose order is not known, and it may matter."""
        if self.selects_by_number and any(
            piece.form is not None and not piece.form.has_known_order for piece in pieces
        ):
            raise UnsupportedPython("the order of the corners of a sphere of this size is not known")

    def counted(self) -> int:
        """Return the next number."""
        self._counter += 1
        return self._counter

    def new_modifier(self, name: str, kind: str) -> Modifier:
        """Create a modifier."""
        return Modifier(self, name or kind.title(), kind, self.modifier_defaults.get(kind, {}))

    def _new_object(self, name: str, object_data: Any = None) -> Object:
        return Object(self, name, object_data)

    def forget(self, removed: Object) -> None:
        """Remove an object from all collections, and from its children."""
        for each in (self.scene.collection, *self.collections.listed()):
            each.objects.items_ = [o for o in each.objects.items_ if o is not removed]
        for child in list(removed.children_):
            child.parent = None
        removed.parent = None
        if self.active is removed:
            self.active = None
        removed.is_selected = False

    def _forget_data(self, removed: Any) -> None:
        for each in self.objects.listed():
            if each.data is removed:
                self.objects.remove(each)

    def _forget_collection(self, removed: CollectionBlock) -> None:
        for each in (self.scene.collection, *self.collections.listed()):
            each.children.items_ = [c for c in each.children.items_ if c is not removed]
        if self.collection is removed:
            self.collection = self.scene.collection

    def selected(self) -> list[Object]:
        """Return the selected objects of the scene, by name as Blender lists them."""
        return [each for each in self.scene.collection.all_objects if each.is_selected and not each.is_hidden]

    def select(self, chosen: Any) -> None:
        """Select exactly these objects."""
        for each in self.objects.listed():
            each.is_selected = False
        for each in chosen:
            each.is_selected = True

    def update(self, *, is_full: bool = False) -> None:
        """Update the world matrices of the objects that scripts have touched, and of all below them."""
        if is_full:
            self.touched = {id(each): each for each in self.objects.by_name.values()}
        pending = list(self.touched.values())
        self.touched = {}
        done: set[int] = set()
        for each in pending:
            above = each.parent
            while above is not None and id(above) not in self.touched:
                above = above.parent
            self._update(each, each.computed_world(), done)

    def _update(self, obj: Object, world: FloatArray, done: set[int]) -> None:
        obj.world = world
        if id(obj) in done:
            return
        done.add(id(obj))
        self.tick()
        for child in obj.children_:
            self._update(child, world @ child.local(), done)

    def evaluated(self, obj: Object) -> list[MeshPiece]:
        """Return the pieces of an object with its modifiers."""
        return self.apply_modifiers(self, obj) if obj.modifiers.items_ else obj.data.settled()

    def evaluated_polygons(self, obj: Object) -> Polygons:
        """Return the mesh of an object with its modifiers."""
        return polygons_of(self.evaluated(obj))


class _World(DataBlock):
    python_name = "World"
    ignored = frozenset(("use_nodes", "mist_settings", "light_settings"))
    shown = DataBlock.shown | frozenset(("node_tree", "color", "cycles", "cycles_visibility"))

    def __init__(self, blocks: DataBlocks, name: str) -> None:
        super().__init__(blocks, name)
        self.node_tree, self.color, self.cycles = Settings(), Numbers((0.05, 0.05, 0.05)), Settings()
        self.cycles_visibility = Settings()

    def assign(self, name: str, value: Any) -> None:
        if name != "color":
            super().assign(name, value)


_REFUSED_DATA = {
    "curves": "curves", "metaballs": "metaballs", "node_groups": "node groups", "particles": "particle systems",
    "armatures": "armatures", "grease_pencils": "drawings", "volumes": "volumes", "lattices": "lattices",
    "fonts": "fonts", "hair_curves": "hair", "texts": "texts", "actions": "actions",
}  # fmt: skip


class Data(HostObject):
    """`bpy.data`."""

    python_name = "BlendData"
    shown = frozenset(
        words("objects meshes materials collections scenes cameras lights worlds orphans_purge filepath is_saved")
    )
    filepath, is_saved = "", False

    def __init__(self, blend: Blend) -> None:
        self._blend = blend
        for name in words("objects meshes materials collections scenes cameras lights worlds"):
            setattr(self, name, getattr(blend, name))
        self._refused: dict[str, DataBlocks] = {}

    def read(self, name: str) -> Any:
        if name in _REFUSED_DATA:
            return self._refused.setdefault(name, DataBlocks(name, self._refuse(name)))
        if name in (
            "images",
            "textures",
            "libraries",
            "brushes",
            "linestyles",
            "palettes",
            "speakers",
            "lightprobes",
            "shape_keys",
        ):
            return self._refused.setdefault(name, DataBlocks(name, lambda *_, **__: self._ignored(name)))
        return super().read(name)

    def _ignored(self, name: str) -> Settings:
        self._blend.warn(f"{name} are left out")
        return Settings()

    def _refuse(self, name: str) -> Callable[..., Any]:
        def refuse(*_: Any, **__: Any) -> Any:
            raise UnsupportedPython(f"{_REFUSED_DATA[name]} are not supported", "use meshes instead")

        return refuse

    def orphans_purge(self, **_: Any) -> int:
        """Do nothing."""
        return 0
