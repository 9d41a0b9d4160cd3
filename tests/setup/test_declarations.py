"""Cameras, lights, environment and render settings as declarations of a program: data, places, names and limits."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import scenelang as sl
from scenelang.files.scene_json import read_scene, write_scene
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.setup import MAX_DECLARED, PROPERTIES, declared_setup
from scenelang.session.editing import Editing
from scenelang.session.session import Options, Session

VASE = '(bind "vase" (lambda () (call "cylinder" :radius .3)))\n'


def graph(text: str, **options: object) -> Scene:
    return Session(Options(**options)).evaluate(Source("<text>", VASE + text)).require()  # type: ignore[arg-type]


def stated(text: str, **options: object) -> list[dict[str, object]]:
    return [item.to_plain() for item in graph(text, **options).setup]


def errors(text: str) -> list[tuple[str, str]]:
    checked = Session().check(Source("<text>", VASE + text))
    return [(d.name, d.message) for d in checked.diagnostics if d.is_error]


def test_plain_data() -> None:
    assert stated(
        '(camera "main" :eye [3 2 5] :look-at "vase" :fov 35 :orthographic #t)\n'
        '(light :position (list 1 2 3) :color "red" :power 10)\n(environment "sunset" :turn 30)\n'
        '(render-settings :size [1280 720] :quality "draft" :samples 64)'
    ) == [
        {"form": "camera", "name": "main", "eye": [3.0, 2.0, 5.0], "look-at": "vase", "fov": 35.0, "orthographic": True},
        {"form": "light", "position": [1.0, 2.0, 3.0], "color": [1.0, 0.0, 0.0], "power": 10.0},
        {"form": "environment", "name": "sunset", "turn": 30.0},
        {"form": "render-settings", "size": [1280, 720], "quality": "draft", "samples": 64},
    ]  # fmt: skip


def test_expressions_params_loops_and_functions() -> None:
    text = (
        "(param height 2)\n(define (lamp x) (light :position [x height 0]))\n"
        "(for ((x (list -1 1))) (lamp x))\n(camera :eye [0 (* 2 height) 5])"
    )
    assert [item.get("position", item.get("eye")) for item in stated(text, defines={"height": "3"})] == [
        [-1.0, 3.0, 0.0], [1.0, 3.0, 0.0], [0.0, 6.0, 5.0],
    ]  # fmt: skip


def test_values_over_the_frames() -> None:
    (camera,) = stated('(camera :eye (list [0 1 5] [0 1 2]) :fov (list 35 50) :look-at (list "vase" [0 1 0]))')
    assert camera["eye"] == [[0.0, 1.0, 5.0], [0.0, 1.0, 2.0]]
    assert camera["fov"] == [35.0, 50.0]
    assert camera["look-at"] == ["vase", [0.0, 1.0, 0.0]]


def test_a_list_of_three_numbers_is_a_point() -> None:
    assert stated("(camera :eye (list 0 1 5))")[0]["eye"] == [0.0, 1.0, 5.0]


@pytest.mark.parametrize("name", PROPERTIES)
def test_a_function_of_the_program_wins(name: str) -> None:
    scene = graph(f'(define ({name} x) (* 2 x))\n(print ({name} 21))\n(bind "b" (lambda ({name}) (call "vase")))')
    assert scene.setup == ()
    assert graph(f'(bind "b" (lambda () (let (({name} .5)) (call "cube" :scale {name}))))(scene "b")').setup == ()
    assert graph(f"(define ({name} . x) 1)\n(define y ({name} 1 2 3))").setup == ()


def test_a_definition_below_wins_too() -> None:
    result = Session().evaluate(Source("<text>", VASE + "(define (f) (camera 4))\n(define (camera x) x)\n(print (f))"))
    assert result.log == ("4",)


def test_words_stay_words() -> None:
    scene = graph('(bind "set" (lambda () (union (call "vase") (call "camera") (call "light"))))(scene "set")')
    assert [part.car.word for part in scene.root.children] == ["vase", "camera", "light"]


def test_the_root_is_not_a_word_that_a_camera_looks_at() -> None:
    text = '(bind "room" (lambda () (call "vase")))\n(camera :look-at "room")'
    assert graph(text).word == "room"


def test_imported_files_keep_theirs(tmp_path: Path) -> None:
    (tmp_path / "vases.scene").write_text(
        VASE + '(camera "theirs" :eye [0 0 9])\n(define (key x) (light "key" :position [x 2 0]))\n(environment "night")'
    )
    main = tmp_path / "main.scene"
    main.write_text(
        '(import "vases.scene")\n(bind "room" (lambda () (call "vase")))\n(camera "ours" :eye [0 0 5])\n(key 3)'
    )
    session = Session()
    checked = session.check(session.source(str(tmp_path / "vases.scene")))
    assert checked.ok
    result = session.evaluate(session.source(str(main)))
    assert [(item.form, item.name) for item in result.require().setup] == [("camera", "ours"), ("light", "key")]
    alone = session.evaluate(session.source(str(tmp_path / "vases.scene")))
    assert [item.form for item in alone.require().setup] == ["camera", "environment"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('(camera :eye [1 2 3] :fovy 3)', [("keyword", "`camera` has no parameter `:fovy`")]),
        ('(camera :fov "wide")', [("type", '`:fov` of `camera` expects a number, or a list of these over the frames, got "wide"')]),
        ('(camera :fov 200)', [("value", "`:fov` of `camera` must be 1 to 150, got 200")]),
        ('(camera :distance 0)', [("value", "`:distance` of `camera` must be above 0 and at most 1e+12, got 0")]),
        ('(camera :eye [1 2])', [("type", "`:eye` of `camera` expects three numbers, or a list of these over the frames, got [1 2]")]),
        ('(camera :eye [1 2 3] :azimuth 3)', [("value", "`camera` takes `:eye` or `:azimuth`, not both")]),
        ('(camera :fov 30 :lens 50)', [("value", "`camera` takes `:fov` or `:lens`, not both")]),
        ('(camera) (camera)', [("duplicate", "two cameras have no name")]),
        ('(camera "a") (camera "a")', [("duplicate", 'the camera "a" is declared twice')]),
        ('(environment "night") (environment "sunny")', [("duplicate", "a program has one `environment`")]),
        ('(environment "night" :strength -1)', [("value", "`:strength` of `environment` must be 0 to 1e+06, got -1")]),
        ('(light)', [("value", "`light` expects a position or a direction")]),
        ('(light :direction [0 -1 0] :power 3)', [("value", "`:power` is of a light with a position")]),
        ('(light :position [0 1 0] :strength 3)', [("value", "`light` takes `:strength` or `:position`, not both")]),
        ('(light :position [0 1 0] :blend .5)', [("value", "`:blend` is of a spot")]),
        ('(light :position [0 1 0] :color "purpel")', []),  # colors by name are read when the program runs
        ('(camera :look-at "vaze")', [("declaration-subject", '`:look-at` of `camera` names "vaze", which is no word of the scene')]),
        ('(camera :look-at "vase/rim[2]")', [("declaration-subject", '`:look-at` of `camera` names "rim", which is no word of the scene')]),
        ('(camera :look-at "vase[0]")', []),
        ('(camera :look-at (string-append "va" "ze"))', []),
        ('(render-settings :size [0 720])', [("value", "`:size` of `render-settings` must be 1 to 8192, got 0")]),
        ('(render-settings :samples 1.5)', [("type", "`:samples` of `render-settings` expects a whole number, got 1.5")]),
        ('(bind "b" (lambda () (union (camera) (call "vase"))))', [("misplaced", "`camera` declares something of the whole scene, in world coordinates: it is no part of an object")]),
    ],
)  # fmt: skip
def test_what_check_reports(text: str, expected: list[tuple[str, str]]) -> None:
    assert errors(text) == expected


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("(camera :eye [0 0 (/ 0. 1e-320)] :fov nan)", None),
        ("(camera :eye (vector 1e300 0 0))", "value"),
        ("(define x (- 1e308 (* -1 1e308)))(light :position [0 0 x])", None),
        ("(camera :fov (string-append \"a\" \"b\"))", "type"),
        ("(define (f) (camera :eye [0 0 1])) (bind \"b\" (lambda () (begin (f) (call \"vase\"))))(scene \"b\")", "misplaced"),
        ("(for ((i (iota 3))) (camera :azimuth i))", "duplicate"),
        ("(for ((i (iota 1000000))) (light :position [i 0 0]))", "size"),
        ("(camera :fov (for/list ((i (iota 100000))) 30))", "size"),
        ("(light :position [0 1 0] :color (list 1 2 car))", "type"),
        ("(camera (car (list 5)))", "type"),
        ("(light :position [0 1 0] :color (string-append \"pur\" \"pel\"))", "value"),
    ],
)  # fmt: skip
def test_what_a_run_reports(text: str, name: str | None) -> None:
    with pytest.raises(SceneError) as caught:
        graph(text)
    assert name is None or caught.value.name == name


def test_limits_are_those_of_the_table() -> None:
    assert len(graph(f"(for ((i (iota {MAX_DECLARED['light']}))) (light :position [i 0 0]))").setup) == 64
    with pytest.raises(SceneError, match="at most 64 lights"):
        graph(f"(for ((i (iota {MAX_DECLARED['light'] + 1}))) (light :position [i 0 0]))")


def test_json_keeps_them(tmp_path: Path) -> None:
    scene = graph('(camera "a" :eye (list [0 1 5] [1 1 1]) :roll 3)\n(light :direction [0 -1 0] :strength 2)')
    write_scene(scene, tmp_path / "a.json")
    read = read_scene(tmp_path / "a.json")
    assert [item.to_plain() for item in read.setup] == [item.to_plain() for item in scene.setup]
    write_scene(graph(""), tmp_path / "b.json")
    assert "setup" not in json.loads((tmp_path / "b.json").read_text())


@pytest.mark.parametrize(
    "setup",
    ['"x"', '[{"form": "lamp"}]', '[{"form": "camera", "eye": [1, 2]}]', '[{"form": "camera", "name": 3}]',
     '[{"form": "environment", "name": "a"}, {"form": "environment", "name": "b"}]', '[{"form": "camera", "fov": 1e999}]',
     '[{"form": "camera", "eye": {"x": 1}}]', '[{"form": "light", "position": [1, 2, 3], "color": [true, 1, 1]}]'],
)  # fmt: skip
def test_json_is_not_trusted(tmp_path: Path, setup: str) -> None:
    write_scene(graph(""), tmp_path / "a.json")
    text = (tmp_path / "a.json").read_text().replace('"entities"', f'"setup": {setup}, "entities"', 1)
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(SceneError):
        read_scene(tmp_path / "a.json")


def test_derived_scenes_keep_them() -> None:
    scene = sl.evaluate(VASE + '(camera "a" :eye [0 0 5])')
    assert scene.restyled("vase", color="red").graph.setup == scene.frame(0).graph.setup == scene.graph.setup


def test_edited_programs_state_them_anew() -> None:
    session, edited = Session(), Editing(Session())
    for text in (
        "(camera :eye [0 0 5])",
        "(camera :eye [0 0 7])",
        "(camera :eye [0 0 7])\n(light :position [0 1 0])",
        "",
    ):
        scene = edited.evaluate(Source("a.scene", VASE + text)).require()
        expected = session.evaluate(Source("a.scene", VASE + text)).require()
        assert [item.to_plain() for item in scene.setup] == [item.to_plain() for item in expected.setup]


def test_values_are_those_of_the_checked_data() -> None:
    item = declared_setup("light", None, {"position": (0, 1, 2), "size": 2}, None)
    assert item.values["size"] == (2.0, 2.0)
