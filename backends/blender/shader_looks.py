"""Materials as attributes of primitives: what a scene has of Blender's nodes, with a warning for the rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scenelang.backends.blender.blend_model import Blend, Material, ShaderNode

Color = tuple[float, float, float]
_DEFAULT = 0.8  # Blender's base color, of each channel
_USED = (
    "Base Color", "Metallic", "Roughness", "IOR", "Alpha", "Transmission Weight", "Emission Color",
    "Emission Strength",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class SurfaceLook:
    """Attributes of a material; colors are linear. None stands for what the script leaves at its default."""

    color: Color = (_DEFAULT, _DEFAULT, _DEFAULT)
    roughness: float | None = None
    metallic: float = 0.0
    emission: Color | None = None
    opacity: float = 1.0
    ior: float | None = None
    name: str = ""


def look_of(blend: Blend, material: Material | None) -> SurfaceLook:
    """Return the look of a material, Blender's own without one."""
    if material is None:
        return SurfaceLook()
    node = material.node_tree.surface()
    known = _SHADERS.get(node.bl_idname) if node is not None else None
    if node is None or known is None:
        principled = next(
            (n for n in material.node_tree.nodes.items_ if n.bl_idname == "ShaderNodeBsdfPrincipled"), None
        )
        if node is not None:
            blend.warn(f"the shader `{node.name}` of the material `{material.name}` is replaced by a plain surface")
        node, known = principled, _principled
    if node is None:
        return SurfaceLook(_rgb(material.diffuse_color), name=material.name)
    return known(blend, material, node)


def _rgb(value: Any) -> Color:
    r, g, b = (min(1.0, max(0.0, float(each))) for each in list(value)[:3])
    return r, g, b


def _value(blend: Blend, material: Material, node: ShaderNode, name: str) -> Any:
    """Return the value of an input; a texture is replaced by it, with a warning."""
    socket = node.inputs[name]
    if socket.is_linked:
        source = socket.links[0].from_node
        if source.bl_idname == "ShaderNodeRGB":
            color = source.outputs["Color"].default_value
            if color is not None:
                return color
        blend.warn(f"textures are left out: `{name}` of the material `{material.name}` keeps its plain value")
    return socket.default_value


def _principled(blend: Blend, material: Material, node: ShaderNode) -> SurfaceLook:
    """Return the look of a Principled BSDF node; warn of inputs that a scene cannot express."""
    value: Callable[[str], Any] = lambda name: _value(blend, material, node, name)
    color = node.inputs["Base Color"]
    # a script may set only the viewport color of a material
    is_plain = not color.is_changed and not color.is_linked
    base = _rgb(material.diffuse_color) if is_plain else _rgb(value("Base Color"))
    strength = float(value("Emission Strength"))
    glow = value("Emission Color")
    emission = None
    if strength > 0:
        r, g, b = (float(each) * strength for each in list(glow)[:3])
        emission = (r, g, b) if r or g or b else None
    transmission = min(1.0, max(0.0, float(value("Transmission Weight"))))
    opacity = min(1.0, max(0.0, float(value("Alpha")))) * (1 - transmission)
    roughness = node.inputs["Roughness"]
    for socket in node.inputs.items_:
        if socket.name not in _USED and (socket.is_changed or socket.is_linked) and socket.initial is not None:
            blend.warn(f"`{socket.name}` of materials is left out")
    return SurfaceLook(
        base,
        float(value("Roughness")) if roughness.is_changed or roughness.is_linked else None,
        float(value("Metallic")),
        emission,
        opacity,
        float(value("IOR")) if transmission > 0 else None,
        material.name,
    )


def _emission(blend: Blend, material: Material, node: ShaderNode) -> SurfaceLook:
    color, strength = _value(blend, material, node, "Color"), float(_value(blend, material, node, "Strength"))
    r, g, b = (float(each) * strength for each in list(color)[:3])
    return SurfaceLook(_rgb(color), emission=(r, g, b), name=material.name)


def _diffuse(blend: Blend, material: Material, node: ShaderNode) -> SurfaceLook:
    return SurfaceLook(_rgb(_value(blend, material, node, "Color")), name=material.name)


def _glossy(blend: Blend, material: Material, node: ShaderNode) -> SurfaceLook:
    roughness = float(_value(blend, material, node, "Roughness"))
    return SurfaceLook(_rgb(_value(blend, material, node, "Color")), roughness, 1.0, name=material.name)


def _glass(blend: Blend, material: Material, node: ShaderNode) -> SurfaceLook:
    roughness, ior = (float(_value(blend, material, node, name)) for name in ("Roughness", "IOR"))
    return SurfaceLook(
        _rgb(_value(blend, material, node, "Color")), roughness, opacity=0.0, ior=ior, name=material.name
    )


_SHADERS = {
    "ShaderNodeBsdfPrincipled": _principled, "ShaderNodeEmission": _emission, "ShaderNodeBsdfDiffuse": _diffuse,
    "ShaderNodeBsdfGlossy": _glossy, "ShaderNodeBsdfGlass": _glass,
}  # fmt: skip
