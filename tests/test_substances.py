"""Substances by name: what ``:material`` and ``:density`` mean, in looks, files and simulations."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import pytest

import scenelang as sl
from scenelang.backends.surfaces.appearance import look_of
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives.substances import DENSITIES, SUBSTANCES

# Reflectances at normal incidence in linear sRGB, of physicallybased.info, and densities of handbooks.
METALS = {
    "gold": ((1.0, 0.773, 0.307), 19300), "silver": ((0.991, 0.985, 0.974), 10500),
    "copper": ((0.932, 0.623, 0.522), 8960), "aluminum": ((0.916, 0.923, 0.924), 2700),
    "iron": ((0.530, 0.513, 0.494), 7870), "titanium": ((0.441, 0.400, 0.361), 4540),
}  # fmt: skip


def primitive(attributes: str, word: str = "cube") -> Entity:
    scene = sl.evaluate(f'(bind "a" (lambda () (call "{word}" {attributes})))')
    part = scene.root.children[0].car
    assert isinstance(part, Entity)
    return part


def test_there_are_many_and_their_values_are_in_range() -> None:
    assert len(SUBSTANCES) >= 60
    for name, substance in SUBSTANCES.items():
        shares = (*substance.color, substance.metallic, substance.opacity, substance.coat, substance.sheen)
        assert all(0.0 <= share <= 1.0 for share in shares), name
        assert substance.roughness is None or 0.0 <= substance.roughness <= 1.0, name
        assert substance.ior is None or 1.0 <= substance.ior <= 4.0, name
        assert substance.density is None or 40.0 <= substance.density <= 23_000.0, name


@pytest.mark.parametrize("name", METALS)
def test_metals_are_those_of_nature(name: str) -> None:
    color, density = METALS[name]
    assert SUBSTANCES[name].color == color
    assert SUBSTANCES[name].metallic == 1.0
    assert DENSITIES[name] == density


@pytest.mark.parametrize("name", SUBSTANCES)
def test_a_material_sets_the_look(name: str) -> None:
    look, substance = look_of(primitive(f':material "{name}"')), SUBSTANCES[name]
    assert (look.color, look.roughness, look.metallic, look.ior) == (
        substance.color, substance.roughness, substance.metallic, substance.ior
    )  # fmt: skip
    assert (look.opacity, look.coat, look.sheen, look.material) == (
        substance.opacity, substance.coat, substance.sheen, name
    )  # fmt: skip


def test_attributes_beside_a_material_come_first() -> None:
    look = look_of(primitive(':material "gold" :roughness .9 :color [.1 .2 .3]'))
    assert (look.color, look.roughness, look.metallic) == ((0.1, 0.2, 0.3), 0.9, 1.0)


@pytest.mark.parametrize("word", ["sphere", "torus", "chair"])
def test_every_primitive_has_a_material(word: str) -> None:
    assert look_of(primitive(':material "oak"', word)).color == SUBSTANCES["oak"].color


def test_a_computed_solid_has_a_material() -> None:
    scene = sl.evaluate('(bind "a" (lambda () (extrude (circle 1) 1 :material "copper")))')
    part: Any = scene.root.children[0].car if scene.root.children else scene.root
    assert look_of(part).metallic == 1.0


@pytest.mark.parametrize(("value", "words"), [
    ('"gould"', "did you mean `gold`"), ('"unobtainium"', "known substances"), ("3", "must be a string"),
])  # fmt: skip
def test_unknown_materials_are_diagnostics(value: str, words: str) -> None:
    with pytest.raises(sl.SceneError) as caught:
        primitive(f":material {value}")
    assert words in str(caught.value)


def materials_of(path: Path) -> list[dict[str, Any]]:
    data = path.read_bytes()
    (length,) = struct.unpack("<I", data[12:16])
    materials: list[dict[str, Any]] = json.loads(data[20 : 20 + length])["materials"]
    return materials


def test_files_carry_names_glass_varnish_fabric_and_light(tmp_path: Path) -> None:
    parts = [':material "gold"', ':material "glass"', ':material "car paint"', ':material "velvet"',
             ":color [1 0 0] :emission 5", ':material "gold" :roughness .6', ":opacity .5"]  # fmt: skip
    calls = " ".join(f'(transform (call "cube" {given}) (translate [{2 * k} 0 0]))' for k, given in enumerate(parts))
    sl.evaluate(f'(bind "a" (lambda () (union {calls})))').export(tmp_path / "a.glb")
    by_name = {material["name"]: material for material in materials_of(tmp_path / "a.glb")}
    assert {"gold", "gold.001", "glass", "car paint", "velvet", "#ff0000", "#ffffff"} == set(by_name)
    glass = by_name["glass"]
    assert "alphaMode" not in glass
    assert glass["extensions"]["KHR_materials_transmission"]["transmissionFactor"] == pytest.approx(0.95)
    assert glass["extensions"]["KHR_materials_ior"]["ior"] == 1.52
    assert "KHR_materials_volume" in glass["extensions"]
    assert by_name["car paint"]["extensions"]["KHR_materials_clearcoat"]["clearcoatFactor"] == 1.0
    assert by_name["velvet"]["extensions"]["KHR_materials_sheen"]["sheenColorFactor"] == [1.0] * 3
    assert by_name["#ff0000"]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] == 5.0
    assert by_name["#ffffff"]["alphaMode"] == "BLEND"
    assert by_name["gold"]["pbrMetallicRoughness"]["metallicFactor"] == 1.0


def test_obj_and_usd_name_their_materials(tmp_path: Path) -> None:
    parts = [':material "brushed steel"', ':material "brushed steel" :roughness .9', ":color [1 0 0]"]
    calls = " ".join(f'(transform (call "cube" {given}) (translate [{2 * k} 0 0]))' for k, given in enumerate(parts))
    scene = sl.evaluate(f'(bind "a" (lambda () (union {calls})))')
    scene.export(tmp_path / "a.obj")
    lines = (tmp_path / "a.mtl").read_text("ascii").splitlines()
    names = [line.removeprefix("newmtl ") for line in lines if line.startswith("newmtl")]
    assert names == ["brushed_steel", "brushed_steel.001", "color_ff0000"]
    pytest.importorskip("pxr")
    scene.export(tmp_path / "a.usda")
    text = (tmp_path / "a.usda").read_text("utf-8")
    assert all(f'def Material "{name}"' in text for name in ("brushed_steel", "brushed_steel_2", "color_ff0000"))
