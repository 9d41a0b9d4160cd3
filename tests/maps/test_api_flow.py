"""Maps of 4D scenes from Python: the arrays that the command writes, and motions that are known in closed form."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many

import scenelang as sl
from scenelang.cli.main import main

GONE, HIDDEN, VISIBLE = 0, 1, 2
SIZE = (72, 48)
NAMES = ("flow", "flow_world", "flow_state", "path", "local")
FILM = """
(bind "film" (lambda () (frames (for/list ((i (iota 4)))
  (union (call "wall")
         (transform (call "ball") (@ (translate [(- i 1.5) .6 1]) (rotate (* .4 i) [0 0 1])))
         (for/union ((k (iota i))) (transform (call "cube" :scale .3) (translate [k -.5 1.5])))
         (if (= i 2) (union) (transform (call "cone" :radius .3) (translate [1.2 -.8 (* .5 i)]))))))))
(bind "wall" (lambda () (call "cube" :scale [3 2 .2])))
(bind "ball" (lambda () (union (call "sphere" :radius .4) (transform (call "cube" :scale .4) (translate [0 .4 0])))))
"""
CAMERAS = {
    "": None,
    "azimuth=30,elevation=20,fov=40": sl.Camera(azimuth=30.0, elevation=20.0, fov=40.0),
    "azimuth=-70,distance=3": sl.Camera(azimuth=-70.0, distance=3.0),
    "top": sl.Camera(azimuth=0.0, elevation=90.0),
    "isometric": sl.Camera(azimuth=45.0, elevation=math.degrees(math.atan(math.sqrt(0.5))), orthographic=True),
    "follow": sl.Camera(azimuth=30.0, elevation=20.0, follow=True),
}


@pytest.mark.parametrize("name", CAMERAS)
def test_python_has_the_arrays_of_the_command(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(FILM)
    more = ["--camera", name] if name else []
    words = f"labels {tmp_path}/a.scene -o {tmp_path}/out --size 72x48 --tracks 20 --seed 5".split()
    assert main([*words, *more]) == 0
    folders = sorted(path.parent for path in (tmp_path / "out").rglob("maps.npz"))
    assert len(folders) == 4
    (track_file,) = (tmp_path / "out").rglob("tracks.npz")
    written = np.load(track_file)
    scene = sl.load(tmp_path / "a.scene")
    for frame, folder in enumerate(folders):
        maps = scene.maps(CAMERAS[name], size=SIZE, frame=frame, tracks=20, seed=5)
        stored = np.load(folder / "maps.npz")
        assert set(maps) - {"color"} == set(stored), frame
        assert (set(NAMES) <= set(maps)) == (frame < 3)
        for key in stored:
            assert maps[key].dtype == stored[key].dtype
            assert np.array_equal(maps[key], stored[key], equal_nan=stored[key].dtype.kind == "f"), (key, frame)
        tracks = maps.tracks
        assert tracks is not None
        assert set(written) == {"pixels", "world", "state"}
        for key in written:
            assert np.array_equal(getattr(tracks, key), written[key], equal_nan=key != "state"), (key, frame)
        saved = np.load(maps.save(tmp_path / f"saved-{frame}") / "maps.npz")
        assert set(saved) == set(stored)
        assert all(np.array_equal(saved[key], stored[key], equal_nan=saved[key].dtype.kind == "f") for key in stored)
        camera = json.loads((folder / "camera.json").read_text())
        assert np.allclose(maps.camera.world_to_camera, np.array(camera["world_to_camera"]))


def test_a_still_has_no_motion() -> None:
    maps = sl.evaluate('(bind "a" (lambda () (call "cube")))').maps(size=SIZE)
    assert not set(NAMES) & set(maps)
    assert maps.tracks is None
    film = sl.evaluate('(bind "a" (lambda () (list (call "cube"))))').maps(size=SIZE)
    assert "flow" not in film


def test_objects_of_other_words_at_a_place_do_not_correspond() -> None:
    ball, cube = '(transform (call "sphere") (translate [-2 0 0]))', '(transform (call "cube") (translate [2 0 0]))'
    film = sl.evaluate(f'(bind "film" (lambda () (list (union {ball} {cube}) (union {cube} {ball}))))')
    maps = film.maps(size=SIZE, frame=0)
    assert (maps["instance"] >= 0).sum() > 100
    assert (maps["flow_state"] == GONE).all()


# --- closed forms ----------------------------------------------------------------------------------------------------

FOV, DISTANCE = 40.0, 10.0
FOCAL = SIZE[1] / 2.0 / math.tan(math.radians(FOV) / 2.0)
FRONT = sl.Camera(azimuth=0.0, elevation=0.0, distance=DISTANCE, fov=FOV, target=(0.0, 0.0, 0.0))


def moved(pose: str, body: str = '(call "cube" :scale 2)', more: str = "") -> sl.Scene:
    """A body in two frames, in the second under a pose; ``more`` stands still."""
    return sl.evaluate(
        f'(bind "film" (lambda () (list (union {body} {more}) (union (transform {body} {pose}) {more}))))'
    )


def centers() -> tuple[np.ndarray, np.ndarray]:
    """The places of pixel centers from the middle of the picture, to the right and upwards."""
    column, row = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    return column - SIZE[0] / 2.0, SIZE[1] / 2.0 - row


@settings(max_examples=many(80), deadline=None)
@given(st.floats(-1.5, 1.5), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0))
def test_a_translated_cube(x: float, y: float, z: float) -> None:
    """Of its front, which is at z = 1, all points have one depth before and after."""
    maps = moved(f"(translate [{x:.9f} {y:.9f} {z:.9f}])").maps(FRONT, size=SIZE, frame=0)
    seen = maps["instance"] >= 0
    right, up = centers()
    assert (seen == (np.maximum(abs(right), abs(up)) < FOCAL / (DISTANCE - 1.0))).all()
    before, after = DISTANCE - 1.0, DISTANCE - 1.0 - z
    expected = np.stack(
        [(right * before / FOCAL + x) * FOCAL / after - right, up - (up * before / FOCAL + y) * FOCAL / after], axis=2
    )
    assert maps["flow"][seen] == pytest.approx(expected[seen], abs=2e-4)
    assert np.isnan(maps["flow"][~seen]).all()
    assert maps["flow_world"][seen] == pytest.approx(np.broadcast_to([x, y, z], (seen.sum(), 3)), abs=2e-5)
    landed = expected + np.stack([right + SIZE[0] / 2.0, SIZE[1] / 2.0 - up], axis=2)
    inside = ((landed >= 0.0) & (landed < SIZE)).all(axis=2)
    assert (maps["flow_state"][seen] == np.where(inside, VISIBLE, HIDDEN)[seen]).all()
    assert (maps["flow_state"][~seen] == GONE).all()


@pytest.mark.parametrize("angle", [0.1, -0.4, 1.2, 3.0])
def test_a_turn_about_the_axis_of_the_camera(angle: float) -> None:
    maps = moved(f"(rotate {angle} [0 0 1])").maps(FRONT, size=SIZE, frame=0)
    seen = maps["instance"] >= 0
    right, up = centers()
    c, s = math.cos(angle), math.sin(angle)
    expected = np.stack([c * right - s * up - right, up - s * right - c * up], axis=2)
    assert maps["flow"][seen] == pytest.approx(expected[seen], abs=2e-4)


@settings(max_examples=many(60), deadline=None)
@given(
    *[st.floats(-1.0, 1.0)] * 4,
    st.floats(-180.0, 180.0),
    st.floats(-60.0, 80.0),
    st.sampled_from(["cube", "sphere", "cylinder", "cone"]),
)
def test_any_motion_and_camera(
    x: float, y: float, z: float, angle: float, azimuth: float, elevation: float, word: str
) -> None:
    """Every point goes where its pose takes it, and is seen where the camera of the right angles has it."""
    pose = f"(@ (translate [{x:.6f} {y:.6f} {z:.6f}]) (rotate {angle:.6f} [0 1 0]))"
    camera = sl.Camera(azimuth=azimuth, elevation=elevation, distance=9.0, fov=FOV, target=(0.0, 0.0, 0.0))
    maps = moved(pose, f'(call "{word}")').maps(camera, size=SIZE, frame=0)
    seen = maps["instance"] >= 0
    points = maps["position"][seen].astype(float)
    c, s = math.cos(round(angle, 6)), math.sin(round(angle, 6))
    there = points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T + np.round([x, y, z], 6)
    around, upwards = math.radians(azimuth), math.radians(elevation)
    back = np.array([math.sin(around) * math.cos(upwards), math.sin(upwards), math.cos(around) * math.cos(upwards)])
    side = np.array([math.cos(around), 0.0, -math.sin(around)])

    def project(world: np.ndarray) -> np.ndarray:
        depth = 9.0 - world @ back
        return np.stack([world @ side, -(world @ np.cross(back, side))], axis=1) / depth[:, None] * FOCAL

    middle = np.stack([each[seen] for each in centers()], axis=1) * [1.0, -1.0]
    assert project(points) == pytest.approx(middle, abs=2e-3)
    assert maps["flow"][seen] == pytest.approx(project(there) - middle, abs=2e-3)
    assert maps["flow_world"][seen] == pytest.approx(there - points, abs=2e-4)


def test_points_are_hidden_behind_others_and_gone_with_their_parts() -> None:
    wall = '(transform (call "cube" :scale [2 6 .1]) (translate [3 0 3]))'
    maps = moved("(translate [3.2 0 0])", more=wall).maps(FRONT, size=SIZE, frame=0)
    cube = maps["semantic"] == next(number for number, word in maps.words.items() if word == "cube")
    state = maps["flow_state"][(maps["position"][:, :, 2] < 2.0) & cube]
    assert set(np.unique(state)) <= {HIDDEN, VISIBLE}
    assert (state == HIDDEN).mean() > 0.5
    gone = sl.evaluate(
        '(bind "film" (lambda () (list (union (call "cube")) (union (transform (call "sphere") (translate [9 0 0]))))))'
    )
    first = gone.maps(FRONT, size=SIZE, frame=0)
    assert set(np.unique(first["flow_state"])) <= {GONE, HIDDEN}


def test_paths_and_local_places_find_points_again() -> None:
    """A pixel whose point is visible in the next frame has its path and its local place there."""
    scene = moved("(@ (translate [.7 .4 .5]) (rotate .3 [0 0 1]))")
    here, there = (scene.maps(FRONT, size=SIZE, frame=frame) for frame in (0, 1))
    rows = np.argwhere(here["flow_state"] == VISIBLE)
    assert len(rows) > 100
    landed = np.floor(rows[:, ::-1] + 0.5 + here["flow"][tuple(rows.T)]).astype(int)
    same = there["path"][landed[:, 1], landed[:, 0]] == here["path"][tuple(rows.T)]
    assert same.mean() > 0.95
    off = np.linalg.norm(there["local"][landed[:, 1], landed[:, 0]] - here["local"][tuple(rows.T)], axis=1)[same]
    assert off.max() < 1.5 * DISTANCE / FOCAL


def test_tracks_are_the_motion_of_their_points() -> None:
    steps = [(0.0, 0.0, 0.0), (0.8, 0.1, 0.4), (-0.5, 0.2, -2.0), (30.0, 0.0, 0.0)]
    frames = " ".join(f'(union (transform (call "cube" :scale 2) (translate [{x} {y} {z}])))' for x, y, z in steps)
    tracks = sl.evaluate(f'(bind "film" (lambda () (list {frames})))').maps(FRONT, size=SIZE, frame=0, tracks=15).tracks
    assert tracks is not None
    assert tracks.pixels.shape == (4, 15, 2)
    world = tracks.world[0] + np.array(steps)[:, None]
    assert tracks.world == pytest.approx(world, abs=1e-4)
    places = world[:, :, :2] / (DISTANCE - world[:, :, 2:]) * FOCAL * [1.0, -1.0] + np.array(SIZE) / 2.0
    assert tracks.pixels == pytest.approx(places, abs=2e-3)
    assert (tracks.state[:3] == VISIBLE).all()
    assert (tracks.state[3] == HIDDEN).all()
