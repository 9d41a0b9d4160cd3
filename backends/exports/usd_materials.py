"""UsdPreviewSurface materials, one for each look. USD's colours are linear, as the language's are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from scenelang.backends.appearance import Look
from scenelang.backends.exports.usd_prims import Prims


@dataclass(slots=True)
class Materials:
    """Adds materials below ``scope``; ``painted`` ones take their colour from the mesh's vertices."""

    prims: Prims
    scope: Any
    _made: dict[tuple[Look, bool], Any] = field(default_factory=dict)

    def bind(self, prim: Any, look: Look, painted: bool = False) -> None:
        """Bind the material of ``look`` to the geometry ``prim``."""
        key = (look, painted)
        if key not in self._made:
            self._made[key] = self._add(f"material_{len(self._made) + 1}", look, painted)
        sdf = self.prims.sdf
        prim.SetInfo("apiSchemas", sdf.TokenListOp.Create(prependedItems=["MaterialBindingAPI"]))
        binding = sdf.RelationshipSpec(prim, "material:binding", custom=False, variability=sdf.VariabilityUniform)
        binding.targetPathList.explicitItems = [self._made[key]]

    def _add(self, name: str, look: Look, painted: bool) -> Any:
        prims, gf = self.prims, self.prims.gf
        material = prims.prim(self.scope, name, "Material")
        surface = prims.prim(material, "surface", "Shader")
        prims.attribute(surface, "info:id", "Token", "UsdPreviewSurface")
        color = prims.attribute(surface, "inputs:diffuseColor", "Color3f", gf.Vec3f(*look.color))
        if painted:
            color.connectionPathList.explicitItems = [self._reader(material)]
        prims.attribute(surface, "inputs:roughness", "Float", look.gloss)
        prims.attribute(surface, "inputs:metallic", "Float", look.metallic)
        if look.opacity < 1.0:
            prims.attribute(surface, "inputs:opacity", "Float", look.opacity)
        if any(look.emission):
            prims.attribute(surface, "inputs:emissiveColor", "Color3f", gf.Vec3f(*look.emission))
        if look.ior is not None:
            prims.attribute(surface, "inputs:ior", "Float", look.ior)
        prims.attribute(surface, "outputs:surface", "Token")
        output = prims.attribute(material, "outputs:surface", "Token")
        output.connectionPathList.explicitItems = [surface.path.AppendProperty("outputs:surface")]
        return material.path

    def _reader(self, material: Any) -> Any:
        """The output of a node that reads the colours of vertices."""
        reader = self.prims.prim(material, "color", "Shader")
        self.prims.attribute(reader, "info:id", "Token", "UsdPrimvarReader_float3")
        self.prims.attribute(reader, "inputs:varname", "String", "displayColor")
        self.prims.attribute(reader, "outputs:result", "Float3")
        return reader.path.AppendProperty("outputs:result")
