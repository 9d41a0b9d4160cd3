"""Layouts: boxes, order, what counts as one, what is said of each place."""

from __future__ import annotations

import numpy as np
import pytest
from support import evaluate

from scenelang.backends.labels.dataset import annotations_of
from scenelang.backends.labels.ground_truth import boxes_in
from scenelang.backends.neural.imagine.layout import PictureLayout, layout_json, layout_of, layout_picture
from scenelang.backends.neural.imagine.sampling import ShotLayout, shot_layout_of
from scenelang.backends.neural.prompts import Granularity, PromptContext, prompt_text, units_of
from scenelang.backends.pictures.camera import Viewpoint, parse_viewpoint
from scenelang.backends.pictures.stage import still
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.reference.primer import stated_task

PROGRAM = """
(bind "moai" (lambda ()
  (union (transform (call "cube" :color (color "#aa1111") :scale [1 2 1]) (translate [0 1 0]))
         (transform (call "sphere" :radius .6) (translate [0 2.6 0])))))
(bind "beach" (lambda ()
  (union (call "moai" (embedding <z9> "weathered"))
         (transform (call "moai") (translate [3 0 -2]))
         (transform (call "palm" :scale [1 4 1]) (translate [-3 2 1])))))
"""


def sketch(program: str = PROGRAM, wholes: Granularity | None = None, most: int = 30, view: str = "") -> ShotLayout:
    scene = evaluate(program)
    camera = parse_viewpoint(view) if view else Viewpoint()
    shot = still(scene, camera, None, 96, 64)
    return shot_layout_of(scene, shot, wholes or Granularity(), most, 10_000, told.append)


told: list[Diagnostic] = []


def words(made: ShotLayout) -> list[str]:
    return [made.truth.ancestry.entity(place.instance).word for place in made.layout.instances]


def test_boxes_are_those_of_maps() -> None:
    made = sketch()
    boxes = boxes_in(made.truth)
    listed = {one["instance"]: one for one in annotations_of(made.truth, boxes, made.handles, 100)}
    assert len(made.layout.instances) == 5
    for place in made.layout.instances:
        x, y, wide, high = listed[place.instance]["bbox_full"]
        assert place.box == pytest.approx((x, y, x + wide, y + high), abs=1e-9)
        assert place.area == listed[place.instance]["area"]
        assert place.depth == made.truth.depth[made.truth.instance == place.instance].min()


def test_boxes_hold_the_projected_corners_of_3d_boxes() -> None:
    """Of a cube the rectangle around its corners, computed with nothing of ours but the camera's matrices."""
    made = sketch()
    ancestry, camera = made.truth.ancestry, made.truth.camera
    cube = next(p for p in made.layout.instances if ancestry.entity(p.instance).word == "cube")
    half = np.array([0.5, 1.0, 0.5])
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    pose = ancestry.poses[cube.instance]
    world = corners @ pose[:, :3].T + pose[:, 3]
    seen = world @ camera.world_to_camera[:3, :3].T + camera.world_to_camera[:3, 3]
    pixels = seen @ camera.intrinsics.T
    flat = pixels[:, :2] / pixels[:, 2:]
    assert cube.box == pytest.approx((*flat.min(axis=0), *flat.max(axis=0)), abs=1e-6)


def test_boxes_end_at_the_picture() -> None:
    made = sketch(view="distance=3")
    for x0, y0, x1, y1 in (place.box for place in made.layout.instances):
        assert 0.0 <= x0 < x1 <= 96.0
        assert 0.0 <= y0 < y1 <= 64.0
    fractions = np.array([made.layout.fractions(place) for place in made.layout.instances])
    assert fractions.min() >= 0.0
    assert fractions.max() == 1.0


def test_what_is_hidden_is_left_out() -> None:
    hidden = '(bind "a" (lambda () (union (call "sphere" :radius .2) (call "cube" :scale [2 2 2]))))'
    assert words(sketch(hidden)) == ["cube"]


def test_of_an_entity_only_what_is_its_own_counts() -> None:
    """The cube hides the sphere, and counts as one for itself; nothing is left of what both stand in."""
    program = '(bind "a" (lambda () (union (call "sphere" :radius .2) (call "cube" :scale [2 2 2]))))'
    assert words(sketch(program, Granularity(0, ("cube",)))) == ["cube"]


def test_the_nearest_comes_first() -> None:
    depths = [place.depth for place in sketch().layout.instances]
    assert depths == sorted(depths)
    assert depths[0] < depths[-1]


def test_only_the_largest_are_kept() -> None:
    told.clear()
    made, all_of_them = sketch(most=2), sketch()
    sizes = sorted((size(made.layout, i) for i in range(2)), reverse=True)
    every = sorted((size(all_of_them.layout, i) for i in range(5)), reverse=True)
    assert sizes == every[:2]
    assert made.layout.left_out == 3
    assert [diagnostic.name for diagnostic in told] == ["crowded-layout"]
    assert "3 instances are omitted" in told[0].message


def size(layout: PictureLayout, number: int) -> float:
    x0, y0, x1, y1 = layout.instances[number].box
    return (x1 - x0) * (y1 - y0)


@pytest.mark.parametrize(
    ("wholes", "wanted"),
    [
        (Granularity(0), ["beach"]),
        (Granularity(1), ["moai", "moai", "palm"]),
        (Granularity(9), ["cube", "cube", "palm", "sphere", "sphere"]),
        (Granularity(named=("moai",)), ["moai", "moai", "palm"]),
        (Granularity(named=("<z9>",)), ["cube", "moai", "palm", "sphere"]),
        (Granularity(named=("0",)), ["cube", "moai", "palm", "sphere"]),
        (Granularity(named=("0", "0/1")), ["cube", "moai", "palm", "sphere"]),
        (Granularity(0, ("0/1",)), ["beach", "sphere"]),
    ],
)
def test_entities_as_one(wholes: Granularity, wanted: list[str]) -> None:
    made = sketch(wholes=wholes)
    assert sorted(words(made)) == wanted
    boxes = boxes_in(made.truth)
    units = units_of(made.truth.ancestry, made.handles, wholes)
    for place in layout_of(made.truth, units).instances:
        full = boxes.full[place.instance]
        assert place.box == pytest.approx(np.clip(full, 0, [96, 64, 96, 64]))


def test_unknown_names() -> None:
    for name in ("castle", "<z99>", "7/7"):
        with pytest.raises(SceneError, match="the scene has no entity"):
            sketch(wholes=Granularity(named=(name,)))


# --- what is said ----------------------------------------------------------------------------------------------------


def said(made: ShotLayout, texts: dict[str, str] | None = None, learned: frozenset[str] = frozenset()) -> list[str]:
    sentences = made.prompts(PromptContext(learned, texts or {}))
    return sorted(prompt_text(condition.prompt) for condition in made.conditions(sentences))


def test_every_place_has_a_sentence() -> None:
    made = sketch(wholes=Granularity(named=("moai",)))
    assert said(made) == [
        "a deep red and white moai, in the style of beach, 3D model",
        "a tall palm, in the style of beach, 3D model",
        "a weathered moai, in the style of beach, 3D model",
    ]
    handles = {c.handles[0] for c in made.conditions(made.prompts(PromptContext()))}
    assert "z9" in handles


def test_z_beats_the_wording_and_vectors_stay_open() -> None:
    made = sketch(wholes=Granularity(named=("moai",)))
    style = made.handles[0]
    found = said(made, {"z9": "golden", style: "oil paint"}, frozenset({style}))
    assert f"a golden moai, in the style of <{style}>, 3D model" in found
    assert f"a <z9> moai, in the style of {'oil paint'}, 3D model" in said(
        made, {style: "oil paint"}, frozenset({"z9"})
    )


def test_the_prompt_may_name_handles() -> None:
    made = sketch()
    sentences = made.prompts(PromptContext(texts={"z9": "golden"}))
    assert sentences.scene_prompt("a <z9> beach") == ("a golden beach",)
    assert made.prompts(PromptContext()).scene_prompt("a <z9> beach") == ("a weathered beach",)
    with pytest.raises(SceneError, match="<q> has neither"):
        sentences.scene_prompt("a <q> beach")


@pytest.mark.parametrize(
    ("text", "task"),
    [
        ("; A red cube.\n(bind ...)", "A red cube"),
        ("; A castle with two towers. It has\n; more to it.\n\n; other\n", "A castle with two towers"),
        ("\n;; Made by a model\n; task: a blue boat. It floats.\n(define x 1)", "a blue boat. It floats."),
        ('(bind "a" 1) ; a comment later', None),
        ("", None),
        (";\n;\n", None),
    ],
)
def test_the_task_in_a_header(text: str, task: str | None) -> None:
    assert stated_task(text) == task


# --- for inspection --------------------------------------------------------------------------------------------------


def test_a_layout_is_drawn() -> None:
    made = sketch(wholes=Granularity(1))
    conditions = made.conditions(made.prompts(PromptContext()))
    picture = layout_picture(made.layout, conditions)
    assert picture.shape == (64, 96, 3)
    for place in made.layout.instances:
        x0, y0, x1, y1 = (round(edge) for edge in place.box)
        assert (picture[y0 + 1 : y1 - 1, x0 + 1 : x1 - 1] != 24).any(axis=2).all()
    outside = np.ones((64, 96), bool)
    for place in made.layout.instances:
        x0, y0, x1, y1 = place.box
        outside[int(y0) : int(y1) + 2, int(x0) : 96] = False  # labels may run over to the right
    assert outside.any()
    assert (picture[outside] == 24).all()


def test_a_layout_as_json() -> None:
    made = sketch(wholes=Granularity(1))
    conditions = made.conditions(made.prompts(PromptContext()))
    data = layout_json(made.layout, conditions, made.truth, "a beach")
    assert data["prompt"] == "a beach"
    assert [tuple(one["path"]) for one in data["instances"]] == [
        made.truth.ancestry.path(place.instance) for place in made.layout.instances
    ]
    assert {one["word"] for one in data["instances"]} == {"moai", "palm"}
    assert all(0 <= edge <= 1 for one in data["instances"] for edge in one["box"])
