"""GLB and USD files in Blender have the bounds and colors of the scene. Needs `make test-blender`."""

from __future__ import annotations

import json
import os
import subprocess
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from sampling import one_in
from support import evaluate

from exports.gltf_reader import Gltf
from exports.oracle import EXAMPLES, example, expected
from exports.textured import NEAR, nearest, textured_scene, worst
from scenelang.backends.base import Backend, BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.exports.plan import solid_of, surface_of
from scenelang.backends.exports.usd import USD
from scenelang.backends.surfaces.appearance import look_of
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.primitives.mesh import volume_of

HERE = Path(__file__).parent
PYTHON = Path(os.environ.get("SCENELANG_BLENDER", HERE.parent.parent / ".venv" / "blender" / "bin" / "python"))

pytestmark = pytest.mark.skipif(not PYTHON.exists(), reason="Blender's module is not installed: `make test-blender`")


def imported(frame: int, *files: Path) -> list[dict[str, Any]]:
    return in_blender("blender_bounds.py", str(frame), *map(str, files))


def in_blender(script: str, *arguments: str, text: str = "") -> Any:
    """What a script prints that Blender's Python runs."""
    command = [str(PYTHON), str(HERE / script), *arguments]
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=600)
    lines = [line for line in done.stdout.splitlines() if line.startswith("RESULT ")]
    assert lines, done.stdout[-2000:] + done.stderr[-2000:]
    return json.loads(lines[0].removeprefix("RESULT "))


@pytest.mark.parametrize(
    ("name", "frame", "defines"),
    one_in(
        6,
        [
            ("orrery.scene", 11, {}),
            ("chessboard.scene", 0, {}),
            ("jenga.scene", 0, {}),
            ("nesting-dolls.scene", 0, {}),
            ("orrery.scene", 0, {}),
            ("menger-sponge.scene", 0, {"level": 2}),
        ],
    ),
)
def test_bounds_in_blender(name: str, frame: int, defines: dict[str, Any], tmp_path: Path) -> None:
    scene = example(name, **defines)
    GLTF.run(scene, tmp_path / "a.glb", BackendOptions())
    USD.run(scene, tmp_path / "a.usdc", BackendOptions())
    wanted = entity_box(scene.frames[frame])
    assert wanted is not None
    size = max(high - low for low, high in zip(wanted[:3], wanted[3:], strict=True))
    # Blender makes polygons of USD's exact cylinders and spheres, of as few as ten sides
    near = (0.003, 0.03)
    for found, share in zip(imported(frame, tmp_path / "a.glb", tmp_path / "a.usdc"), near, strict=True):
        assert found["meshes"] == len(list(expected(scene, frame)))
        assert found["box"] == pytest.approx(wanted, abs=share * size)


@pytest.mark.parametrize("name", one_in(4, ["materials.scene", "jenga.scene", "chessboard.scene", "orrery.scene"]))
def test_colors_in_blender(name: str, tmp_path: Path) -> None:
    """Every mesh of a USD file has a material, in the color that the scene says."""
    scene = example(name)
    USD.run(scene, tmp_path / "a.usdc", BackendOptions())
    (found,) = imported(0, tmp_path / "a.usdc")
    wanted = list(expected(scene, 0))
    assert found["meshes"] == len(wanted)
    assert None not in found["colors"]
    assert sorted(np.round(found["colors"], 4).tolist()) == sorted(np.round([one.color for one in wanted], 4).tolist())


SOLIDS = """
(bind "plate" (lambda () (call "cube" :scale [3 .4 2] :color [.1 .3 .8])))
(bind "hole" (lambda () (call "cylinder" :radius .3 :p0 [0 -1 0] :p1 [0 1 0] :color [.8 .4 .05])))
(bind "part" (lambda () (difference (call "plate") (call "hole"))))
(bind "bar" (lambda () (extrude (star 5 1 .5) .7 :color [.2 .6 .2])))
(bind "both" (lambda () (solid-union (call "cube" :color [.7 .1 .1]) (call "sphere" :radius .6 :color [.7 .1 .1]))))
(bind "name" (lambda () (text "Ab" :color [.9 .9 .2])))
(bind "peg" (lambda () (call "cone" :radius .5 :p1 [0 1.3 0] :color [.4 .2 .6])))
(bind "scene" (lambda () (union
  (call "part")
  (transform (call "bar") (translate [5 0 0]))
  (transform (call "both") (translate [0 5 0]))
  (transform (call "name") (translate [0 0 5]))
  (transform (call "part") (@ (translate [9 0 0]) (reflect [1 2 0])))
  (transform (call "bar") (@ (translate [0 9 0]) (@ (scale [1 2 1]) (rotate .5 [0 0 1]))))
  (for/union ((i '(0 1 2 3))) (transform (call "peg") (@ (translate (vector (* 2 i) -5 0)) (rotate i [1 1 0]))))
  (for/union ((i '(0 1 2))) (transform (call "part") (@ (translate (vector (* 4 i) -9 0)) (scale [1 2 .5])))))))
"""


@pytest.mark.parametrize(("instancing", "draco"), [(0, False), (2, False), (0, True)])
def test_solids_have_their_volumes_and_colors(instancing: int, draco: bool, tmp_path: Path) -> None:
    """Every solid and primitive, also mirrored, sheared and as an instance, in USD and GLB, also compressed."""
    if draco:
        pytest.importorskip("DracoPy", reason="DracoPy is not installed")
    scene = evaluate(SOLIDS)
    given = BackendOptions(settings={"instancing": instancing})
    GLTF.run(scene, tmp_path / "a.glb", replace(given, settings={**given.settings, "draco": draco}))
    USD.run(scene, tmp_path / "a.usdc", given)
    wanted = sorted(map(_solid, expected(scene)), key=lambda row: row[0])
    for found in imported(0, tmp_path / "a.glb", tmp_path / "a.usdc"):
        rows = sorted(((one["volume"], one["colors"]) for one in found["solids"]), key=lambda row: row[0])
        assert len(rows) == len(wanted)
        for (volume, colors), (true, own) in zip(rows, wanted, strict=True):
            assert volume == pytest.approx(true, rel=0.01)
            # Blender keeps the vertex colors of glTF in 8 bits of sRGB
            assert np.array(sorted(colors)) == pytest.approx(np.array(sorted(own)), abs=4e-3)


def _solid(one: Any) -> tuple[float, list[list[float]]]:
    """The volume and the distinct colors of a primitive."""
    surface = surface_of(one.entity)
    assert surface is not None
    colors = np.array([one.color]) if surface.colors is None else surface.colors * np.array(one.color)
    return abs(volume_of(one.vertices[surface.faces])), np.unique(np.round(colors, 3), axis=0).tolist()


# --- names, materials and animation after a reimport -----------------------------------------------------------------

LARGE = {"fractal-tree.scene", "menger-sponge.scene"}  # a hundred thousand primitives and more
EVERY = sorted({str(path.relative_to(EXAMPLES)) for path in EXAMPLES.rglob("*.scene")} - LARGE)
ATTRIBUTES = """
:material "gold" | :material "glass" | :material "velvet" | :material "water" | :color [.2 .5 .9] :opacity .4
:color [.2 .5 .9] :opacity .4 :ior 1.33 | :ior 1.7 :roughness .2 | :emission [4 2 1] | :emission .5 :color [.2 .9 .1]
:coat .7 :color [.8 .1 .1] | :sheen .6 | :metallic .5 :roughness .25 :color [.02 .03 .9] | :color [0 0 0]
:texture "brick" :roughness .3 :coat .5 | :material "oak" :texture "wood" | :emission 7 :texture "dots"
"""
EACH = ATTRIBUTES.strip().replace("\n", "|").split("|")
LOOKS = f"""(bind "looks" (lambda () (union {
    " ".join(
        f'(transform (call "{word}" {given}) (translate [{column} {row} 0]))'
        for row, given in enumerate(EACH)
        for column, word in enumerate(("cube", "sphere"))
    )
})))"""
MOVING = """
(bind "arm" (lambda () (union (call "cube" :scale [1 .2 .2] :color [.8 .2 .1])
  (transform (call "sphere" :radius .2 :material "chrome") (translate [.6 0 0])))))
(define (machine t) (union (call "cylinder" :color [.3 .3 .3])
  (transform (call "arm") (@ (translate (vector 0 t 0)) (rotate (* 2 t) [0 1 0])))
  (transform (call "arm") (@ (rotate t [1 0 0]) (scale (vector 1 (+ 1 t) 1))))
  (transform (call "cube") (@ (translate [3 0 0]) (@ (scale [1 2 1]) (rotate .5 [0 0 1]))))
  (if (> t .5) (call "cone" :color (vector t 0 0)) (call "sphere" :emission 3))))
(bind "all" (lambda () (frames (map (lambda (k) (machine (/ k 8.0))) (range 9)))))
"""
Row = tuple[np.ndarray, dict[str, Any]]


def reimported(jobs: list[tuple[Scene, Path, list[int]]]) -> list[dict[str, Any]]:
    """What Blender has of each scene, written to a path, at frames."""
    for scene, path, _ in jobs:
        GLTF.run(scene, path, BackendOptions())
    text = json.dumps([(str(path), frames) for _, path, frames in jobs])
    found: list[dict[str, Any]] = in_blender("blender_contents.py", text=text)
    return found


def wanted_rows(scene: Scene, frame: int) -> list[Row]:
    """The visible primitives of a frame: the world matrix (4, 4) of the mesh of each, and its material in Blender."""
    rows = []
    for one in expected(scene, frame):
        solid, look = solid_of(one.entity), look_of(one.entity)
        assert solid is not None
        clear = 1.0 - look.opacity if look.ior is not None else 0.0
        material = {
            "color": "TEX_IMAGE" if look.texture else "VERTEX_COLOR" if solid.own_colors else look.color,
            "metallic": look.metallic,
            "roughness": look.gloss,
            "transmission": clear,
            "ior": look.ior or 1.5,
            "alpha": 1.0 if clear else look.opacity,
            "coat": look.coat,
            "sheen": look.sheen,
            "emission": look.emission,
        }
        rows.append((_square(one.matrix) @ _square(solid.pose), material))
    return rows


def _square(pose: Any) -> np.ndarray:
    """A pose as (4, 4)."""
    return np.vstack([np.array(pose).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])


def read_rows(found: dict[str, Any], number: int) -> list[Row]:
    """As ``wanted_rows``, of what Blender has at the frame of that number; what is shrunk to nothing is not there."""
    turn = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])  # y up to z up
    rows = []
    for one in found["objects"]:
        world = turn.T @ np.array(one["worlds"][number]) @ turn
        if one["material"] is None or not world[:3, :3].any():
            continue
        shader = found["materials"][one["material"]]
        material = {
            key: shader[key] for key in ("color", "metallic", "roughness", "transmission", "ior", "alpha", "coat")
        }
        material["sheen"] = shader["sheen"] * shader["sheen_tint"][0]
        material["emission"] = [channel * shader["strength"] for channel in shader["emission"]]
        rows.append((world, material))
    return rows


def shares(scene: Scene, path: Path, found: dict[str, Any], frames: list[int]) -> dict[str, tuple[int, int]]:
    """How many names, places and values of materials are as the scene has them, and of how many, by kind."""
    nodes = Gltf(path).nodes
    names = {thing["name"]: thing["word"] for thing in found["objects"]}
    words = {node["name"]: node.get("extras", {}).get("word") for node in nodes}
    out = {"names": (sum(name in names and names[name] == word for name, word in words.items()), len(nodes))}
    assert len(found["objects"]) == len(nodes) == len(words)
    counts: Counter[tuple[str, bool]] = Counter()
    for number, frame in enumerate(frames):
        size = max(1.0, max(map(abs, entity_box(scene.frames[frame]) or (1.0,))))
        left = read_rows(found, number)
        for place, material in wanted_rows(scene, frame):
            away = [np.abs(place - other).max() for other, _ in left]
            near = [k for k in range(len(left)) if away[k] < 1e-5 * size]
            counts["places", bool(near)] += 1
            if not near:
                continue
            agreed = [{key: _close(left[k][1][key], value) for key, value in material.items()} for k in near]
            best = max(range(len(near)), key=lambda k: sum(agreed[k].values()))
            del left[near[best]]
            counts.update(agreed[best].items())
        counts["nothing more", not left] += 1
    kinds = dict.fromkeys(kind for kind, _ in counts)
    return out | {kind: (counts[kind, True], counts[kind, True] + counts[kind, False]) for kind in kinds}


def _close(a: Any, b: Any) -> bool:
    return a == b if isinstance(a, str) or isinstance(b, str) else bool(np.allclose(a, b, rtol=1e-6, atol=1e-6))


def _frames(scene: Scene) -> list[int]:
    return sorted({0, len(scene.frames) // 3, len(scene.frames) - 1})


def _complete(counts: dict[str, tuple[int, int]]) -> dict[str, tuple[int, int]]:
    """What is not as the scene has it."""
    return {kind: pair for kind, pair in counts.items() if pair[0] < pair[1]}


@pytest.mark.parametrize("part", one_in(3, range(3)))
def test_examples_keep_names_materials_and_animation(part: int, tmp_path: Path) -> None:
    """After import every object has its name, word, place at several frames, and the material of its look."""
    jobs = [(example(name), tmp_path / f"{k}.glb") for k, name in enumerate(EVERY[part::3])]
    every = [(scene, path, _frames(scene)) for scene, path in jobs]
    for (scene, path, frames), found in zip(every, reimported(every), strict=True):
        assert _complete(shares(scene, path, found, frames)) == {}, path.name


def test_looks_and_motion_of_all_kinds(tmp_path: Path) -> None:
    """Every attribute of looks; objects that move, come and go, and change their looks, also with shear."""
    scenes = [evaluate(text) for text in (LOOKS, MOVING)]
    jobs = [(scene, tmp_path / f"{k}.glb", list(range(len(scene.frames)))) for k, scene in enumerate(scenes)]
    for (scene, path, frames), found in zip(jobs, reimported(jobs), strict=True):
        counts = shares(scene, path, found, frames)
        assert _complete(counts) == {}
        assert counts["places"][1] == (2 * len(EACH) if len(frames) == 1 else 9 * 7)


def test_a_scene_in_motion_is_one_action(tmp_path: Path) -> None:
    """Blender 5 makes one action of an animation of glTF, with a slot for each object; so there must be only one."""
    scene = example("orrery.scene")
    (found,) = reimported([(scene, tmp_path / "a.glb", [0])])
    assert list(found["actions"]) == [scene.word]
    assert found["actions"][scene.word] > 20


# --- textures --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("ending", "backend"), [(".glb", GLTF), (".usdc", USD)])
def test_textures_are_drawn_where_they_are(ending: str, backend: Backend, tmp_path: Path) -> None:
    """Every texture on every shape in an image by Cycles has the colors of the definition, where that is flat."""
    scene, objects = textured_scene(tmp_path)
    backend.run(scene, tmp_path / f"a{ending}", BackendOptions())
    in_blender("blender_textures.py", *(str(tmp_path / name) for name in (f"a{ending}", "drawn.png", "points.npz")))
    drawn = np.asarray(Image.open(tmp_path / "drawn.png").convert("RGBA"), float)
    seen = dict(np.load(tmp_path / "points.npz"))
    colors = drawn[tuple(seen["pixels"].T)]
    inside = colors[:, 3] == 255  # of silhouettes, on which a ray may meet what the image does not show
    assert inside.mean() > 0.999
    points, normals, colors = seen["points"][inside], seen["normals"][inside], colors[inside, :3]
    owner = nearest(points)
    rows = ((k, points[owner == k], normals[owner == k], colors[owner == k]) for k in range(len(objects)))
    found = worst(objects, rows)
    assert {name: one for name, one in found.items() if one[0] > NEAR} == {}
    assert np.mean([share for _, share in found.values()]) > 0.3
