"""Exports to scripts: Blender's is imported back to the same scene, the helper API's runs in its reference model."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from transpile import reference_model

from scenelang.backends.base import BackendOptions
from scenelang.backends.blender.importing import imported
from scenelang.backends.blender.script import BPY
from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.session.session import Session
from scenelang.translation.helper_export import HELPER_PYTHON

TABLE = """
(define oak [0.4 0.2 0.1])
(bind "leg" (lambda () (call "cylinder" :radius .05 :p0 [0 -.35 0] :p1 [0 .35 0] :color oak)))
(bind "ball" (lambda () (call "sphere" :radius .2 :color [1 0 0] :roughness .3)))
(bind "table"
  (lambda ()
    (union
      (transform (call "cube" :scale [2 .1 1] :color oak) (translate [0 .75 0]))
      (for*/union ((x '(-.9 .9)) (z '(-.4 .4)))
        (transform (call "leg") (translate [x .35 z])))
      (transform (call "ball") (@ (translate [.3 1.2 0]) (rotate .4 [1 2 3]) (scale [1 2 1]))))))
"""
SOLIDS = """
(bind "parts"
  (lambda ()
    (union
      (call "cone" :radius .5 :p1 [0 2 0])
      (transform (call "torus" :radius 1 :tube .2) (translate [3 0 0]))
      (transform (call "capsule" :radius .3) (translate [0 0 3]))
      (transform (difference (call "cube") (call "cube" :scale [.5 .5 2])) (@ (translate [-3 0 0]) (reflect [1 0 0]))))))
"""


def scene_of(text: str, name: str = "a.scene") -> Scene:
    result = Session().evaluate(Source(name, text))
    assert result.scene is not None, [d.message for d in result.diagnostics]
    return result.scene


@pytest.mark.parametrize("text", [TABLE, SOLIDS], ids=["table", "solids"])
def test_a_script_for_blender_is_imported_back(text: str, tmp_path: Path) -> None:
    scene = scene_of(text)
    BPY.run(scene, tmp_path / "made.py", BackendOptions(settings={"segments": 64}))
    back = scene_of(imported(tmp_path / "made.py")[0])
    wanted, found = entity_box(scene.frames[0]), entity_box(back.frames[0])
    assert wanted is not None
    assert found == pytest.approx(wanted, abs=3e-3)
    assert len(flatten_entity(back.frames[0]).matrices) == len(flatten_entity(scene.frames[0]).matrices)


def test_equal_entities_share_a_mesh_and_words_are_names(tmp_path: Path) -> None:
    BPY.run(scene_of(TABLE), tmp_path / "made.py", BackendOptions())
    text = (tmp_path / "made.py").read_text()
    compile(text, "made.py", "exec")
    assert len(re.findall(r'= cone\("leg"', text)) == 1
    assert len(re.findall(r"^    leg\(own, ", text, re.M)) == 4
    assert 'place("ball", ' in text


def primitives(scene: Scene, frame: int = 0) -> list[tuple[str, Any, Any]]:
    flat = flatten_entity(scene.frames[frame])
    found = []
    for index, matrix in zip(flat.index, flat.matrices, strict=True):
        shape = flat.primitives[index].shape
        assert shape is not None
        placed = shape.placed()
        assert placed is not None
        pose = np.vstack([matrix, [0, 0, 0, 1]]) @ np.vstack([placed.matrix, [0, 0, 0, 1]])
        found.append((type(shape).__name__.lower(), pose, shape.color))
    return found


def test_helper_python_runs_in_the_reference_model(tmp_path: Path) -> None:
    scene = scene_of(TABLE)
    warned: list[Diagnostic] = []
    HELPER_PYTHON.run(scene, tmp_path / "made.py", BackendOptions(warn=warned.append))
    golden = reference_model.flatten((tmp_path / "made.py").read_text())
    own = primitives(scene)
    theirs = golden["frames"][0]["primitives"]
    assert [each["shape"] for each in theirs] == [shape for shape, _, _ in own]
    for each, (shape, pose, color) in zip(theirs, own, strict=True):
        assert each["color"] == pytest.approx(color)
        matrix = np.array(each["matrix"], np.float64).reshape(-1, 4)[:3]
        if shape == "cylinder":
            ends = [matrix[:, :3] @ each[name] + matrix[:, 3] for name in ("p0", "p1")]
            middle = np.mean(ends, axis=0)
            assert np.allclose(middle, pose[:3] @ [0, 0, 0, 1], atol=1e-6) or np.allclose(
                middle[[0, 2]], pose[[0, 2], 3]
            )
        else:
            assert np.allclose(np.abs(matrix[:, 3]), np.abs(pose[:3, 3]), atol=1e-6)
    assert [d.name for d in warned] == ["lost-attribute"]


def test_helper_python_warns_about_all_that_it_leaves_out(tmp_path: Path) -> None:
    text = """
    (bind "leg" (lambda (:height &keys _) (call "cube" "tall" :scale [1 height 1] :fixed #t :foo 3 :roughness .4)))
    (bind "yard" (lambda () (union (call "leg" "oak" :height 2 :mass 3) (call "house" "red" :color [0 1 0]))))
    """
    warned: list[Diagnostic] = []
    HELPER_PYTHON.run(scene_of(text), tmp_path / "made.py", BackendOptions(warn=warned.append))
    assert [(d.name, d.message) for d in warned] == [
        ("lost-attribute", "the helper API has colors only: `:fixed`, `:foo`, `:mass`, `:roughness` left out"),
        ("lost-attribute", 'the helper API has no texts: "oak", "red", "tall" left out'),
        ("lost-attribute", 'the helper API has no semantic primitives: cubes for "house"'),
    ]


def test_helper_python_of_cubes_and_colors_has_no_warning(tmp_path: Path) -> None:
    warned: list[Diagnostic] = []
    text = (
        '(bind "pair" (lambda (:size) (union (call "cube" :scale size :color [1 0 0]) (call "cylinder" :p1 [0 2 0]))))'
    )
    HELPER_PYTHON.run(
        scene_of(text.replace("(:size)", "((:size 2))")), tmp_path / "a.py", BackendOptions(warn=warned.append)
    )
    assert warned == []


def test_helper_python_has_three_primitives(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cone"):
        HELPER_PYTHON.run(scene_of(SOLIDS), tmp_path / "made.py", BackendOptions())


def test_the_command_selects_the_language(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(TABLE)
    for name, first in (("bpy", "import bpy"), ("python", "from helper import *")):
        assert main(["export", str(tmp_path / "a.scene"), "-o", str(tmp_path / "made.py"), "--to", name]) == 0
        assert first in (tmp_path / "made.py").read_text()
