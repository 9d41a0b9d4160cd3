"""Framing by the silhouette: measured in images, and against closed forms and exact boxes."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import silhouettes
from silhouettes import FILMS, SCENES, SIZES, example_scenes, of_film, of_still
from support import evaluate

import scenelang as sl
from scenelang.backends.pictures.camera import FILL, PRESETS, Camera, Viewpoint, framed, parse_viewpoint
from scenelang.backends.pictures.stage import CLEAR_GROUNDS, film, still
from scenelang.cli.main import main
from scenelang.console import shell_completion
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.bounds import parts_box
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.supports import Supports
from scenelang.interpreter.values.values import Matrix, Pair

EXAMPLES = example_scenes()
ALL = [*EXAMPLES, *SCENES]


def scene_of(name: str) -> Scene:
    return EXAMPLES[name] if name in EXAMPLES else evaluate(SCENES[name])


def assert_framed(found: silhouettes.Silhouette) -> None:
    assert 0.88 <= found.fill <= 0.94, found
    assert found.offset <= 0.01, found


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", ALL)
@pytest.mark.sampled(12)
def test_objects_fill_the_image_and_are_central(name: str, size: tuple[int, int]) -> None:
    scene = scene_of(name)
    assert_framed(of_still(scene, Viewpoint(), size, len(scene.frames) // 2))


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.sampled(6)
def test_every_preset_frames(preset: str) -> None:
    for name in ("torus", "spiral"):
        if not PRESETS[preset].follow:
            assert_framed(of_still(scene_of(name), PRESETS[preset], (320, 240)))


def test_frames_of_a_film_are_framed_together_and_single_ones_alone() -> None:
    swing = evaluate(FILMS["pendulum"])
    assert_framed(of_film(swing, Viewpoint(), (320, 240)))
    assert_framed(of_film(swing, PRESETS["isometric"], (240, 320)))
    assert_framed(of_still(swing, Viewpoint(), (320, 240), 0))
    assert_framed(of_film(swing, Viewpoint(), (320, 240), None, 180.0))


@pytest.mark.parametrize("name", ["cone", "plank", "spiral"])
def test_turntables_are_framed_over_all_angles(name: str) -> None:
    assert_framed(of_film(scene_of(name), Viewpoint(), (320, 240), 12))


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("fov", [10.0, 35.0, 100.0])
def test_the_distance_to_a_sphere_is_that_of_the_tangent_cone(aspect: float, fov: float) -> None:
    scene = evaluate('(bind "a" (lambda () (transform (call "sphere" :radius 2) (translate [3 4 5]))))')
    camera = still(scene, Viewpoint(20, 10, fov=fov), 0, round(aspect * 500), 500).camera
    k = FILL * math.tan(math.radians(fov) / 2) * min(1.0, aspect)
    assert np.linalg.norm(camera.eye - [3, 4, 5]) == pytest.approx(2 / math.sin(math.atan(k)), rel=1e-9)
    assert camera.project(np.array([[3.0, 4.0, 5.0]]))[0][0] == pytest.approx([aspect * 250, 250], abs=1e-5)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.sampled(8)
def test_supports_are_those_of_the_exact_boxes(name: str) -> None:
    root = scene_of(name).frames[0]
    supports = Supports([(root, np.eye(3, 4))], lambda primitive: True)
    for directions in np.random.default_rng(5).normal(size=(4, 3, 3)):
        matrix = Matrix(np.column_stack([directions, np.zeros(3)]).ravel().tolist())
        box = parts_box([Pair(root, matrix)])
        assert box is not None
        assert [supports.highest(each) for each in directions] == pytest.approx(box[3:], rel=1e-11)
        assert [-supports.highest(-each) for each in directions] == pytest.approx(box[:3], rel=1e-11)


def test_supports_leave_out_what_does_not_count() -> None:
    scene = evaluate(SCENES["ghost"])
    supports = Supports([(scene.root, np.eye(3, 4))], lambda entity: entity.word == "sphere")
    assert supports.highest(np.array([1.0, 0.0, 0.0])) == pytest.approx(1.0)
    assert Supports([(scene.root, np.eye(3, 4))], lambda entity: False).is_empty


def test_a_graph_of_a_billion_parts_is_framed() -> None:
    levels = "".join(
        f'(bind "l{k + 1}" (lambda () (union (call "l{k}") (transform (call "l{k}") '
        f"(@ (translate [.3 .1 0]) (rotate {k} [1 2 3]) (scale .9))))))"
        for k in range(30)
    )
    scene = evaluate(f'(bind "l0" (lambda () (call "cube"))){levels}')
    camera = still(scene, Viewpoint(), 0, 64, 48).camera
    assert np.isfinite(camera.eye).all()


def test_what_the_user_gives_is_kept() -> None:
    scene = scene_of("spiral")
    camera = still(scene, Viewpoint(distance=7.0, target=(1.0, 2.0, 3.0)), 0, 100, 80).camera
    assert np.linalg.norm(camera.eye - [1, 2, 3]) == pytest.approx(7.0)
    camera = still(scene, Viewpoint(target=(0.0, 0.0, 0.0)), 0, 100, 80).camera
    assert camera.project(np.zeros((1, 3)))[0][0] == pytest.approx([50, 40])
    low, high = np.full(3, -1.62), np.array([1.62, 4.02, 1.62])
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, 8).T
    assert (camera.project(corners)[1] > 0).all()


# --- explicit positions -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["eye=1,2,3,target=0,0,0,fov=40", "eye=1:2:3,fov=40,target=0:0:0"])
def test_an_eye_may_be_written_with_commas_or_colons(text: str) -> None:
    assert parse_viewpoint(text) == Viewpoint(eye=(1, 2, 3), target=(0, 0, 0), fov=40)


def test_an_eye_is_where_it_is_said_and_looks_at_its_target() -> None:
    scene = scene_of("cube")
    view = Viewpoint(eye=(1.0, 2.0, 3.0), target=(0.5, 0.0, -0.5), fov=50.0)
    camera = still(scene, view, 0, 120, 80).camera
    assert camera.eye == pytest.approx([1, 2, 3])
    assert camera.project(np.array([[0.5, 0.0, -0.5]]))[0][0] == pytest.approx([60, 40])
    assert camera.focal[1] == pytest.approx(40 / math.tan(math.radians(25)))
    assert camera.focus == pytest.approx(np.linalg.norm([0.5, 2.0, 3.5]))
    assert camera.right[1] == pytest.approx(0.0)
    at_center = still(scene_of("far from the origin"), Viewpoint(eye=(0, 0, 0)), 0, 120, 80).camera
    assert at_center.project(np.array([[1000.0, 200.5, -300.0]]))[0][0] == pytest.approx([60, 40], abs=0.2)
    above = still(scene, Viewpoint(eye=(0, 9, 0)), 0, 64, 64).camera
    assert above.forward == pytest.approx([0, -1, 0])
    parallel = still(scene, replace(view, orthographic=True), 0, 120, 80).camera
    assert parallel.project(np.array([[0.5, 0.0, -0.5]]))[0][0] == pytest.approx([60, 40])


def test_an_eye_orbits_and_follows() -> None:
    swing = evaluate(FILMS["pendulum"])
    shots = film(swing, Viewpoint(eye=(0.0, 0.0, 6.0), target=(0.0, -1.0, 0.0)), 64, 48, 4, 360.0)
    assert [np.hypot(shot.camera.eye[0], shot.camera.eye[2]) for shot in shots] == pytest.approx([6.0] * 4)
    following = film(swing, Viewpoint(eye=(0.0, 0.0, 6.0), follow=True), 64, 48, None, None)
    assert all(shot.camera.eye == pytest.approx([0, 0, 6]) for shot in following)
    assert len({shot.camera.forward.tobytes() for shot in following}) > 4


def test_a_rolled_camera_turns_the_image_the_other_way_and_frames() -> None:
    level = still(scene_of("cone"), Viewpoint(eye=(0, 0, 9), target=(0, 0, 0)), 0, 100, 100).camera
    rolled = still(scene_of("cone"), Viewpoint(eye=(0, 0, 9), target=(0, 0, 0), roll=90.0), 0, 100, 100).camera
    up = np.array([[0.0, 1.0, 0.0]])
    assert level.project(up)[0][0][1] < 50 - 1
    assert rolled.project(up)[0][0] == pytest.approx([50 - (50 - level.project(up)[0][0][1]), 50])
    assert_framed(of_still(scene_of("plank"), Viewpoint(roll=30.0), (320, 240)))


def test_a_lens_is_a_field_of_view_on_36_mm() -> None:
    camera = still(scene_of("cube"), Viewpoint(lens=50.0), 0, 300, 200).camera
    assert 2 * math.degrees(math.atan(150 / camera.focal[0])) == pytest.approx(39.5978, abs=1e-3)  # 50 mm
    assert_framed(of_still(scene_of("spiral"), Viewpoint(lens=85.0), (480, 640)))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("eye=1:2:3,azimuth=20", "`eye` and `azimuth` exclude each other"),
        ("eye=1:2:3,distance=20", "`eye` and `distance` exclude each other"),
        ("top,eye=1:2:3", "`eye` and `azimuth` exclude each other"),
        ("eye=1:2:3,target=1:2:3", "is at the point that it looks at"),
        ("eye=1,2", "three numbers"),
        ("eye=1,2,3,4", "three numbers"),
        ("eye=1,2,nan", "must be finite"),
        ("lens=0", "`lens` must be between"),
        ("lens=50,fov=30", "`lens` and `fov` exclude each other"),
        ("roll=inf", "must be finite"),
    ],
)
def test_bad_positions_are_diagnosed(text: str, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        parse_viewpoint(text)


def test_an_eye_at_the_center_of_the_scene_is_diagnosed() -> None:
    with pytest.raises(SceneError, match="looks at"):
        still(scene_of("cube"), Viewpoint(eye=(0.0, 0.0, 0.0)), 0, 32, 32)


def test_sides_are_views() -> None:
    for name, forward in {"front": (0, 0, -1), "right": (-1, 0, 0), "back": (0, 0, 1), "left": (1, 0, 0),
                          "top": (0, -1, 0), "bottom": (0, 1, 0), "rear": (0, 0, 1), "above": (0, -1, 0)}.items():  # fmt: skip
        view = parse_viewpoint(name)
        assert isinstance(view, Viewpoint)
        assert still(scene_of("cube"), view, 0, 32, 32).camera.forward == pytest.approx(forward)
    assert parse_viewpoint("plan,azimuth=10") == replace(PRESETS["plan"], azimuth=10.0)
    assert parse_viewpoint("elevation").orthographic
    assert parse_viewpoint("elevation=20") == Viewpoint(elevation=20.0)
    assert parse_viewpoint("three-quarter") == Viewpoint()


def test_the_python_api_takes_an_eye() -> None:
    scene = sl.evaluate(SCENES["cube"])
    camera = scene.placed(sl.Camera(eye=(1.0, 2.0, 3.0), target=(0.0, 0.0, 0.0)), (64, 48))
    assert isinstance(camera, Camera)
    assert camera.eye == pytest.approx([1, 2, 3])
    assert repr(sl.Camera(eye=(1, 2, 3))) == "Camera(eye=(1, 2, 3))"
    with pytest.raises(SceneError, match="`eye`: expected three finite numbers"):
        sl.Camera(eye=(1.0, 2.0))  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="exclude"):
        scene.placed(sl.Camera(eye=(1.0, 2.0, 3.0), azimuth=10.0))
    assert np.isfinite(
        framed(Viewpoint(), Supports([(scene.graph.root, np.eye(3, 4))], lambda _: True), 9, 9).eye
    ).all()


def test_every_preset_is_named_where_it_is_offered(capsys: pytest.CaptureFixture[str]) -> None:
    assert set(shell_completion._CAMERAS) == set(PRESETS)
    assert set(shell_completion._CLEAR_GROUNDS) == set(CLEAR_GROUNDS)
    with pytest.raises(SystemExit):
        main(["render", "--help"])
    shown = " ".join(capsys.readouterr().out.split())
    listed = f"({', '.join(PRESETS)})"
    assert listed in shown
    assert "eye=1:2:3" in shown
    assert all(ground in shown for ground in CLEAR_GROUNDS)
    page = (Path(__file__).parents[2] / "docs" / "pictures.md").read_text("utf-8")
    assert all(f"`{preset}`" in page for preset in PRESETS)
