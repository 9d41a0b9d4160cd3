"""Scenes written as JSON and read back."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from support import evaluate, geometry

from exports.oracle import EXAMPLES, example, scenes
from scenelang.backends.base import BackendOptions
from scenelang.files import scene_json
from scenelang.files.scene_json import JSON, read_scene, write_scene
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.inspection.outline import outline
from scenelang.interpreter.scene.entity import Entity, Scene, count_words, descendants
from scenelang.interpreter.values.values import IDENTITY, Embedding, Pair

ALL = sorted(path.name for path in EXAMPLES.glob("*.scene"))


def again(scene: Scene, path: Path) -> Scene:
    JSON.run(scene, path, BackendOptions())
    return read_scene(path)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.sampled(3)
def test_examples_come_back_the_same(name: str, tmp_path: Path) -> None:
    scene = example(name)
    back = again(scene, tmp_path / "a.json")
    assert (back.word, back.animated, len(back.frames)) == (scene.word, scene.animated, len(scene.frames))
    assert geometry(back) == geometry(scene)
    assert list(outline(back)) == list(outline(scene))
    assert len(list(descendants(*back.frames))) == len(list(descendants(*scene.frames)))


@settings(max_examples=many(40), deadline=None)
@given(scenes(frames=2))
def test_any_scene_comes_back_the_same(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        back = again(scene, Path(folder) / "a.json")
    assert geometry(back) == geometry(scene)


def test_attributes_handles_and_texts_come_back(tmp_path: Path) -> None:
    scene = evaluate(
        '(bind "a" (lambda () (call "thing" (embedding <z7> "old" :scale [1 2 3] :names \'("x" (1 2.5 #t)) :m [[1 2] [3 4]]'
        ' :t (table "k" [1 2]) :none none))))'
    )
    back = again(scene, tmp_path / "a.json")
    (part,) = back.root.children
    assert (part.car.embedding.handle, part.car.embedding.text) == ("z7", "old")
    assert geometry(back) == geometry(scene)
    write_scene(back, tmp_path / "b.json")
    assert (tmp_path / "b.json").read_text() == (tmp_path / "a.json").read_text()


def test_a_scene_of_billions_is_a_small_file(tmp_path: Path) -> None:
    back = again(example("menger-sponge.scene", level=8), tmp_path / "a.json")
    assert (tmp_path / "a.json").stat().st_size < 60_000
    assert count_words(back.root)["cube"] == 20**8


def test_a_deep_scene_needs_no_recursion(make: Any, tmp_path: Path) -> None:
    entity = make.primitive("cube")
    for _ in range(20_000):
        entity = make.group("nest", entity)
    assert count_words(again(Scene("nest", [entity], False), tmp_path / "a.json").root)["nest"] == 20_000


def test_one_frame_can_be_chosen(tmp_path: Path) -> None:
    scene = example("orrery.scene")
    JSON.run(scene, tmp_path / "a.json", BackendOptions(frame=5))
    back = read_scene(tmp_path / "a.json")
    assert (back.animated, len(back.frames)) == (False, 1)
    assert geometry(back)[0] == geometry(scene)[5]


def test_assets_stay_inside_the_folder(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")

    (tmp_path / "in").mkdir()
    trimesh.creation.box((1, 2, 3)).export(tmp_path / "in" / "box.ply")
    trimesh.creation.box((1, 2, 3)).export(tmp_path / "out.ply")
    for name in ("box.ply", "../out.ply"):
        document = {
            "format": "scenelang-scene", "version": 1, "word": "mesh", "frames": [0],
            "entities": [{"word": "mesh", "primitive": True, "file": name}],
        }  # fmt: skip
        (tmp_path / "in" / "a.json").write_text(json.dumps(document))
        if name == "box.ply":
            shape = read_scene(tmp_path / "in" / "a.json").root.shape
            assert shape is not None
            assert shape.asset is not None
            assert shape.asset.box == pytest.approx((-0.5, -1, -1.5, 0.5, 1, 1.5))
            back = Entity("mesh", Embedding(), (), shape)
            write_scene(Scene("mesh", [back], False), tmp_path / "in" / "b.json")
            assert '"file":"box.ply"' in (tmp_path / "in" / "b.json").read_text()
        else:
            with pytest.raises(SceneError, match="is outside"):
                read_scene(tmp_path / "in" / "a.json")
            assert read_scene(tmp_path / "in" / "a.json", allow_outside=True).root.shape is not None


GOOD: dict[str, Any] = {
    "format": "scenelang-scene",
    "version": 1,
    "word": "a",
    "frames": [1],
    "entities": [
        {"word": "cube", "primitive": True, "attributes": {"scale": {"array": [1, 2, 3]}}},
        {"word": "a", "children": [[0, list(IDENTITY)]]},
    ],
}


def changed(**fields: Any) -> str:
    return json.dumps(GOOD | fields)


def entity(**fields: Any) -> str:
    return changed(entities=[GOOD["entities"][0], GOOD["entities"][1] | fields])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not valid JSON"),
        ("[" * 100_000, "not valid JSON"),
        ("[]", "format"),
        ('{"format": "scenelang-camera"}', "format"),
        (changed(version=2), "version"),
        (changed(word=3), "word of the scene"),
        (changed(entities={}), "must be a list"),
        (changed(entities=[3]), "must be an object"),
        (changed(entities=[]), "a frame must be"),
        (changed(frames=[]), "frames"),
        (changed(frames=[-1]), "a frame must be"),
        (changed(frames=[0, 1], animated=False), "animated"),
        (entity(children=[[1, list(IDENTITY)]]), "earlier entity"),
        (entity(children=[[True, list(IDENTITY)]]), "earlier entity"),
        (entity(children=[[0, [1] * 11]]), "12 numbers"),
        (entity(children=[[0, ["1"] * 12]]), "12 numbers"),
        (entity(children=[[0, [10**400] * 12]]), "finite"),
        (entity(children=[[0, [1e400] * 12]]), "not valid JSON"),
        (entity(children=[0]), "pair"),
        (entity(children="ab"), "list"),
        (entity(primitive=True), "has children"),
        (entity(handle=3), "handle"),
        (entity(text=[]), "text"),
        (entity(attributes=[]), "attributes"),
        (entity(attributes={"a": {"odd": 1}}), "malformed"),
        (entity(attributes={"a": {"array": [[1], [1, 2]]}}), "malformed"),
        (entity(attributes={"a": {"array": 3}}), "malformed"),
        (entity(attributes={"a": {"table": 3}}), "malformed"),
        (entity(attributes={"a": {"embedding": [1]}}), "malformed"),
    ],
)
def test_what_is_no_scene_is_one_clear_line(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(SceneError, match=message) as caught:
        read_scene(tmp_path / "a.json")
    assert "\n" not in caught.value.message


@settings(max_examples=many(150), deadline=None)
@given(st.data())
def test_any_change_is_a_scene_or_an_error(data: Any) -> None:
    """One value somewhere in the document replaced by another."""
    document = json.loads(changed())
    place: Any = document
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = data.draw(st.sampled_from(keys))
        if not isinstance(place[key], (dict, list)) or not place[key] or data.draw(st.booleans()):
            break
        place = place[key]
    place[key] = data.draw(
        st.sampled_from([None, True, -1, 1e300, 2**70, "x", [], {}, [[]], {"array": []}, {"table": []}])
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.json").write_text(json.dumps(document))
        try:
            scene = read_scene(Path(folder) / "a.json")
        except SceneError:
            return
        assert count_words(scene.root)


def test_too_many_entities_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = Entity("a", Embedding(), tuple(Pair(Entity("b", Embedding(), ()), IDENTITY) for _ in range(20)))
    write_scene(Scene("a", [root], False), tmp_path / "a.json")
    for name in ("MAX_ENTITIES", "MAX_PARTS", "MAX_FILE_BYTES"):
        with monkeypatch.context() as patch:
            patch.setattr(scene_json, name, 10)
            with pytest.raises(LimitError):
                read_scene(tmp_path / "a.json")
    with pytest.raises(SceneError, match="there is no file"):
        read_scene(tmp_path / "none.json")
