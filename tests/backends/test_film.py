"""Films: which shots they are made of, what is shared between frames, and the files."""

from __future__ import annotations

import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support import evaluate

from scenelang.backends.pictures import draft_painter
from scenelang.backends.pictures.camera import PRESETS, Camera, Viewpoint
from scenelang.backends.pictures.draft_painter import DRAFT
from scenelang.backends.pictures.film import Image as DrawnImage
from scenelang.backends.pictures.film import PictureOptions, painters
from scenelang.backends.pictures.mitsuba import MITSUBA
from scenelang.backends.pictures.stage import film, staging_of, still
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene

SWING = """
(bind "film" (lambda () (frames (for/list ((i (iota 5)))
  (union (call "cube" :scale [2 .2 1] :color [.5 .3 .1])
         (transform (call "sphere" :radius .3 :color [.8 .1 .1]) (translate [(- (* .5 i) 1) .6 0])))))))
"""
STATIC = (
    '(bind "pair" (lambda () (union (call "cube" :color [.2 .2 .8]) (transform (call "cone") (translate [1.5 0 0])))))'
)


@pytest.fixture
def swing() -> Scene:
    return evaluate(SWING)


def test_shots_of_a_4d_scene_are_its_frames(swing: Scene) -> None:
    shots = film(swing, Viewpoint(), 32, 24, None, None)
    assert [shot.frame for shot in shots] == [0, 1, 2, 3, 4]
    assert len({shot.camera.world_to_camera.tobytes() for shot in shots}) == 1
    assert [shot.frame for shot in film(swing, Viewpoint(), 32, 24, 10, None)] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]
    assert [shot.frame for shot in film(swing, Viewpoint(), 32, 24, 2, None)] == [0, 2]


def test_a_static_scene_is_turned_once_round() -> None:
    shots = film(evaluate(STATIC), Viewpoint(), 32, 24, 8, None)
    angles = [np.degrees(np.arctan2(-shot.camera.forward[0], -shot.camera.forward[2])) % 360 for shot in shots]
    assert np.diff(np.unwrap(angles, period=360)) == pytest.approx(45.0)
    heights = {round(float(shot.camera.eye[1]), 9) for shot in shots}
    assert len(heights) == 1
    a = np.linspace(0.0, 6.28, 30)  # the cube's corners, the cone's tip and base
    base = np.stack([1.5 + np.cos(a), np.zeros_like(a), np.sin(a)], axis=1)
    cube = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    points = np.concatenate([cube, [[1.5, 1.0, 0.0]], base])
    for shot in shots:
        pixels, depth = shot.camera.project(points)
        assert (depth > 0).all()
        assert (pixels >= 0).all()
        assert (pixels <= [32, 24]).all()


def test_orbits_presets_and_followed_frames(swing: Scene) -> None:
    quarter = film(swing, Viewpoint(), 32, 24, None, 90.0)
    assert len({shot.camera.world_to_camera.tobytes() for shot in quarter}) == 5
    assert film(swing, PRESETS["turntable"], 32, 24, None, None)[1].camera.eye != pytest.approx(quarter[0].camera.eye)
    following = film(swing, PRESETS["follow"], 64, 48, None, None)
    for shot in following:
        box = np.array([[float(shot.frame) * 0.5 - 1, 0.6, 0]])
        assert np.isfinite(shot.camera.project(box)[0]).all()
    assert len({shot.camera.eye.tobytes() for shot in following}) > 1
    placed = still(swing, Viewpoint(), 0, 32, 24).camera
    assert isinstance(placed, Camera)
    turned = film(swing, placed, 32, 24, 4, 360.0)
    assert np.linalg.norm(turned[1].camera.eye - placed.eye) > 0.5
    for count in (0, 10**6):
        with pytest.raises(SceneError, match="1 to 10,000"):
            film(swing, Viewpoint(), 32, 24, count, None)


def test_what_does_not_move_is_fixed(swing: Scene) -> None:
    staging = staging_of(swing, range(5), 100)
    assert staging.fixed is not None
    assert [staging.fixed.words[i] for i in staging.fixed.word] == ["cube"]
    assert all(len(solids) == 1 for solids in staging.moving.values())


@pytest.mark.parametrize("backend", [DRAFT, MITSUBA])
def test_frames_of_a_film_are_the_stills(swing: Scene, backend: Any) -> None:
    """Sharing between frames changes nothing in them."""
    settings = {"samples": 4} if backend is MITSUBA else {}
    options = PictureOptions(width=48, height=36, settings=settings)
    shots = film(swing, Viewpoint(), 48, 36, None, None)
    (painter,) = painters(swing, options, [backend], shots)
    for shot in shots:
        (alone,) = painters(swing, options, [backend], [shot])
        assert np.abs(painter.paint(shot).picture.astype(int) - alone.paint(shot).picture).max() <= 2


@pytest.mark.parametrize("ending", [".gif", ".apng", ".webp", ".png"])
@pytest.mark.sampled(2)
def test_films_are_written(tmp_path: Path, ending: str) -> None:
    (tmp_path / "a.scene").write_text(SWING)
    out = tmp_path / f"a{ending}"
    assert main(["render", str(tmp_path / "a.scene"), "-o", str(out), "--size", "40x30", "--fps", "10"]) == 0
    image = Image.open(out)
    assert (image.n_frames, image.size) == (5, (40, 30))
    total = 0
    pictures = []
    for i in range(5):
        image.seek(i)
        image.load()
        total += round(image.info["duration"])
        pictures.append(np.asarray(image.convert("RGB")).astype(int))
    assert total == 500
    assert min(np.abs(a - b).max() for a, b in pairwise(pictures)) > 50


def test_mp4_is_a_film_of_even_size(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    (tmp_path / "a.scene").write_text(STATIC)
    out = tmp_path / "a.mp4"
    assert (
        main(["render", str(tmp_path / "a.scene"), "-o", str(out), "--size", "41x31", "--frames", "6", "--orbit", "90"])
        == 0
    )
    with av.open(str(out)) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
        assert float(container.streams.video[0].average_rate) == 24.0
    assert len(frames) == 6
    assert frames[0].shape == (32, 42, 3)


def test_a_webp_of_a_4d_scene_is_a_film_unless_a_frame_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(SWING)
    command = ["render", str(tmp_path / "a.scene"), "--size", "32x24", "-o"]
    assert main([*command, str(tmp_path / "a.webp")]) == 0
    assert Image.open(tmp_path / "a.webp").n_frames == 5
    assert main([*command, str(tmp_path / "b.webp"), "--frame", "3"]) == 0
    assert Image.open(tmp_path / "b.webp").n_frames == 1
    assert main([*command, str(tmp_path / "c.png"), "--frame", "3"]) == 0
    assert main([*command, str(tmp_path / "d.png")]) == 0
    assert (np.asarray(Image.open(tmp_path / "c.png")) != np.asarray(Image.open(tmp_path / "d.png"))).any()


def test_several_backends_draw_side_by_side(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(STATIC)
    command = [
        "render",
        str(tmp_path / "a.scene"),
        "--backend",
        "draft,mitsuba",
        "--size",
        "40x30",
        "--samples",
        "16",
        "--ground",
        "seamless",
        "-o",
    ]
    assert main([*command, str(tmp_path / "a.png")]) == 0
    picture = np.asarray(Image.open(tmp_path / "a.png")).astype(float)
    assert picture.shape == (30, 80, 3)
    assert np.abs(picture[:, :40] - picture[:, 40:]).mean() < 7
    assert main([*command, str(tmp_path / "a.gif"), "--frames", "2"]) == 0
    assert Image.open(tmp_path / "a.gif").size == (80, 30)


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["-o", "a.gif", "--frame", "1"], 2, "--frame"),
        (["-o", "a.jpg", "--frames", "3"], 2, "single picture"),
        (["-o", "a.bmp"], 2, "does not write `.bmp` files"),
        (["-o", "a"], 2, "without an extension"),
        (["-o", "a.exr", "--backend", "draft,mitsuba"], 2, "one backend"),
        (["-o", "a.png", "--backend", "drft"], 2, "did you mean `draft`"),
        (["-o", "a.png", "--backend", "gltf"], 2, "does not draw pictures"),
        (["-o", "a.png", "--samples", "4"], 2, "no option `--samples`"),
        (["-o", "a.png", "--quality", "final", "--samples", "0"], 2, "1 or more"),
        (["-o", "a.png", "--quality", "final", "--variant", "metal"], 2, "one of auto, scalar"),
        (["-o", "a.png", "--environment", "stdio"], 2, "did you mean `studio`"),
        (["-o", "a.png", "--ground", "lava"], 2, "unknown ground `lava`"),
        (["-o", "a.png", "--camera", "isometrc"], 2, "did you mean `isometric`"),
        (["-o", "a.png", "--frame", "9"], 1, "frame 9 does not exist"),
        (["-o", "no/a.gif"], 1, "the folder no does not exist"),
        (["-o", "folder.png"], 1, "it is a directory"),
        (["-o", "a.gif", "--frames", "0"], 1, "1 to 10,000"),
        (["-o", "a.gif", "--frames", "200", "--size", "4000x4000"], 1, "are too many"),
    ],
)
def test_wrong_uses_are_told_and_leave_nothing(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    code: int,
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "a.scene").write_text(SWING)
    assert main(["render", "a.scene", *arguments]) == code
    shown = capsys.readouterr().err
    assert said in shown
    assert shown.count("error[") == 1
    assert sorted(os.listdir(tmp_path)) == ["a.scene", "folder.png"]


def test_an_interrupted_film_leaves_nothing(tmp_path: Path, swing: Scene) -> None:
    from scenelang.backends.pictures.film import save_film

    class Interrupted:
        def __init__(self) -> None:
            self.left = 2

        def paint(self, shot: Any, progress: Any = None) -> Any:
            self.left -= 1
            if self.left < 0:
                raise KeyboardInterrupt
            return DrawnImage(np.zeros((24, 32, 3), np.uint8), np.zeros((24, 32, 3), np.float32))

    shots = film(swing, Viewpoint(), 32, 24, None, None)
    for name in ("a.gif", "a.mp4"):
        (tmp_path / name).write_text("before")
        with pytest.raises(KeyboardInterrupt):
            save_film([Interrupted()], shots, tmp_path / name)
        assert (tmp_path / name).read_text() == "before"
    assert sorted(os.listdir(tmp_path)) == ["a.gif", "a.mp4"]


@pytest.mark.parametrize(("camera", "count"), [(Viewpoint(), 2), (Viewpoint(orbit=90.0), 6)])
def test_images_that_show_the_same_are_drawn_once(
    camera: Viewpoint, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = []
    original = draft_painter.draw_lens
    monkeypatch.setattr(draft_painter, "draw_lens", lambda stage, *more, **named: (
        drawn.append(stage), original(stage, *more, **named))[1])  # fmt: skip
    scene = evaluate(
        '(bind "a" (lambda () (frames (for/list ((x (list 0 1))) (transform (call "cube") (translate [x 0 0]))))))'
    )
    shots = film(scene, camera, 16, 12, 6, None)
    options = PictureOptions(width=16, height=12, ground="none")
    (painter,) = painters(scene, options, [DRAFT], shots)
    images = [painter.paint(shot).picture for shot in shots]
    assert len(drawn) == count
    assert (images[0] != images[5]).any()
