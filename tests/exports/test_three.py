"""GLB files in three.js, where node is there: its loader keeps names, and its mixer moves every node as the frames do."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from backends.conftest import MIRROR, SHEAR, Make
from extremes import EXTREMES
from PIL import Image
from sampling import one_in
from support import evaluate

from exports.gltf_reader import Gltf
from exports.textured import NEAR, nearest, pixels_at, sampled, textured_scene, worst
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.exports.plan import surface_of
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.values.values import Matrix

HERE = Path(__file__).parent
FOLDER = Path(os.environ.get("SCENELANG_THREE", HERE.parent.parent / ".venv" / "three"))
NODE = shutil.which("node")
FPS = 24.0

pytestmark = pytest.mark.skipif(
    NODE is None or not (FOLDER / "node_modules" / "three").is_dir(),
    reason="three.js is not installed: it needs node and npm, and `make test`",
)


def loaded(*jobs: tuple[Path, Sequence[float]]) -> list[dict[str, Any]]:
    """What three.js has of each file, at each of its times."""
    text = json.dumps([{"file": str(file), "times": list(times)} for file, times in jobs])
    command = [str(NODE), str(HERE / "three.mjs"), str(FOLDER)]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=True, timeout=300)
    found: list[dict[str, Any]] = json.loads(done.stdout)
    assert [one["error"] for one in found if "error" in one] == []
    for one in found:
        for each in one["objects"]:
            each["worlds"] = [np.reshape(world, (4, 4)).T for world in each["worlds"]]
    return found


def written(scene: Scene, path: Path, **settings: Any) -> tuple[Path, list[float]]:
    """A file of a scene, and the times of its frames."""
    GLTF.run(scene, path, BackendOptions(settings=settings))
    return path, [frame / FPS for frame in range(len(scene.frames))]


# --- names -----------------------------------------------------------------------------------------------------------

WORDS = {
    "equal": ["ball", "ball", "ball_1", "ball_2", "ball", "ball_1"],
    "marks": ["a[b].c:d/e", "abcde", "a[b].c:d/e", ".", "/", "x.1", "x/1", "x_1"],
    "spaces": ["a b", "a_b", "a\u00a0b", "a\tb", "a b_1", " ", "_"],
    "spaces-of-one-language": ["a\ufeffb", "a_b", "a_b_1", "a\x1cb", "a\x85b"],
    "scripts": ["世界", "世界", "é", "e\u0301", "😀"],
    "empty": ["", "", "_1", "mesh_0", "mesh_0_1"],
    "members-of-objects": ["toString", "toString", "constructor", "__proto__", "valueOf", "hasOwnProperty"],
    "the-scene": ["scene", "scene_1", "scene_2"],
    "the-primitive": ["cube", "cube_1", "cone", "cone_2", "cone_1"],
    "the-inner": ["ball/shear", "ball", "ball/shown", "ball/1", "ball1", "ball_mesh"],
}
PRIMITIVES = ("cube", "cone")
FORMS = {"moving": {}, "parts": {"depth": 1}, "still": {}}


def in_motion(make: Make, words: Sequence[str]) -> Scene:
    """A 4D scene of a thing for each word, every one of which moves on its own; the last one comes and goes."""
    cube, cone = make.primitive("cube", color=(0.1, 0.2, 0.3)), make.primitive("cone", roughness=0.2)
    things = [make.group(word, cube, (cone, pose.translation(0, 0.5, 0.1 * i))) for i, word in enumerate(words)]
    frames = []
    for frame in range(3):
        places = [
            make.chain(
                pose.translation(2 * i, frame * (i % 3 - 1), 0), pose.rotation(0.1 * frame * i, (0, 1, 1), (0, 0, 0))
            )
            for i in range(len(things))
        ]
        parts = list(zip(things, places, strict=True))
        frames.append(make.group("scene", *(parts[:-1] if frame == 1 else parts)))
    return Scene("scene", frames, True)


Loaded = dict[tuple[str, str], tuple[dict[str, Any], Gltf, Scene]]


@pytest.fixture(scope="module")
def named(make: Make, tmp_path_factory: pytest.TempPathFactory) -> Loaded:
    """Every kind of words in every form, which one process reads."""
    folder = tmp_path_factory.mktemp("named")
    scenes = {(kind, form): in_motion(make, words) for kind, words in WORDS.items() for form in FORMS}
    for key in scenes:
        if key[1] == "still":
            scenes[key] = Scene("scene", scenes[key].frames[:1], False)
    jobs = [written(scene, folder / f"{kind}-{form}.glb", **FORMS[form]) for (kind, form), scene in scenes.items()]
    found = zip(loaded(*jobs), jobs, scenes.values(), strict=True)
    return dict(zip(scenes, ((one, Gltf(path), scene) for one, (path, _), scene in found), strict=True))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", WORDS)
def test_names_are_unique_before_they_are_read(kind: str, form: str, named: Loaded) -> None:
    """The loader has no name to change, but for the characters that it drops; words are in ``userData``."""
    one = named[kind, form][0]
    nodes = [each for each in one["objects"] if each["node"] is not None]
    assert [each["name"] for each in nodes if each["read"]] == [each["read"] for each in nodes if each["read"]]
    names = [each["name"] for each in nodes if each["name"]]
    others = {one["scene"], *(each["name"] for each in one["objects"] if each["node"] is None)}
    assert len(set(names)) == len(names)
    assert not set(names) & others
    assert len(set(one["meshes"])) == len(one["meshes"])
    words = [each["word"] for each in nodes[1:] if each["word"] not in (*PRIMITIVES, None)]
    assert words == [word for word in WORDS[kind] if word not in PRIMITIVES]


@pytest.mark.parametrize("kind", sorted(WORDS.keys() - {"members-of-objects"}))  # three.js gives these to no node
def test_the_first_node_keeps_its_word(kind: str, named: Loaded) -> None:
    kept: dict[str, str] = {}
    for each in named[kind, "moving"][0]["objects"]:
        if each["word"] is not None:
            kept.setdefault(read(each["word"]), each["name"])
    assert kept == {word: word for word in kept}


def read(word: str) -> str:
    """A word as PropertyBinding.sanitizeNodeName returns it: white space of JavaScript is ``_``, and []:./ are nothing."""
    spaces = "\t\n\v\f\r \u00a0\u1680\u2028\u2029\u202f\u205f\u3000\ufeff" + "".join(map(chr, range(0x2000, 0x200B)))
    return "".join("_" if c in spaces else c for c in word if c not in "[].:/")


# --- animation -------------------------------------------------------------------------------------------------------


def walked(entity: Entity, world: np.ndarray) -> Iterator[tuple[Entity, np.ndarray]]:
    """Every instance below and including an entity, depth first, and its matrix in the world."""
    yield entity, world
    for child in entity.children:
        yield from walked(child.car, world @ np.vstack([np.reshape(child.cdr, (3, 4)), [0, 0, 0, 1]]))


def check(one: dict[str, Any], gltf: Gltf, scene: Scene) -> None:
    """Every entity is where each frame has it: groups by their matrices, primitives by the corners of their meshes."""
    instances: list[list[Any]] = []
    for each in one["objects"]:
        if each["word"] is not None:
            instances.append([each["word"]])
        instances[-1].append(each)
    for number, frame in enumerate(scene.frames):
        there = list(walked(frame, np.eye(4)))
        for (entity, world), (word, *objects) in zip(there, instances):
            assert word == entity.word
            found, wanted = objects[-1]["worlds"][number], world  # of the inner one, where two nodes are one pose
            if entity.is_primitive:
                surface = surface_of(entity)
                assert surface is not None
                wanted = surface.vertices @ world[:3, :3].T + world[:3, 3]
                found = corners(gltf, objects[-1], number)
            assert np.allclose(found, wanted, rtol=0, atol=2e-5 * max(1.0, float(np.abs(wanted).max())))
        for _, *objects in instances[len(there) :]:  # what is not in the frame, at the end of the others
            assert np.linalg.det(objects[-1]["worlds"][number]) == 0.0


def corners(gltf: Gltf, object_: dict[str, Any], number: int) -> np.ndarray:
    """The corners (V, 3) of the mesh of an object in the world, at a time."""
    (part,) = gltf.document["meshes"][object_["mesh"]]["primitives"]
    world = object_["worlds"][number]
    return np.asarray(gltf.array(part["attributes"]["POSITION"]) @ world[:3, :3].T + world[:3, 3])


@pytest.mark.parametrize("kind", WORDS)
def test_tracks_of_equal_words_move_their_own_nodes(kind: str, named: Loaded) -> None:
    check(*named[kind, "moving"])


def test_any_motion_is_right_at_every_frame(make: Make, tmp_path: Path) -> None:
    scenes = [tangled(make, seed) for seed in range(12)]
    jobs = [written(scene, tmp_path / f"{seed}.glb") for seed, scene in enumerate(scenes)]
    for one, (path, _), scene in zip(loaded(*jobs), jobs, scenes, strict=True):
        check(one, Gltf(path), scene)


def tangled(make: Make, seed: int) -> Scene:
    """Three levels of groups of few words, whose parts turn, stretch, flip and shear from frame to frame."""
    random = np.random.default_rng(seed)
    words = ["ball", "ball_1", "a b", "a.b"]

    def place() -> Matrix:
        turn = pose.rotation(float(random.uniform(-3, 3)), random.normal(size=3).tolist(), (0, 0, 0))
        more = [(), (MIRROR,), (SHEAR,), (pose.scaling(0.5, 2.0, -1.0, (0, 0, 0)),)][int(random.integers(4))]
        return make.chain(pose.translation(*random.uniform(-2, 2, 3).tolist()), turn, *more)

    leaves = [make.primitive(word, color=(0.1, 0.2, 0.3)) for word in ("cube", "sphere", "cone")]
    frames = []
    for _ in range(4):
        level: list[Entity] = leaves
        for word in words[:2] + words[2 + seed % 2 :]:
            level = [make.group(word, *((each, place()) for each in level[i : i + 2])) for i in range(2)]
        frames.append(make.group("ball", *((each, place()) for each in level)))
    return Scene("ball", frames, True)


FLIPS = {
    "aside": (pose.scaling(1, 1, 1, (0, 0, 0)), pose.scaling(-1, 1, 1, (0, 0, 0))),
    "inside-out": (pose.scaling(2, 1, 1, (0, 0, 0)), pose.scaling(-1, -1, -2, (0, 0, 0))),
    "turned": (pose.rotation(0.5, (1, 2, 0), (0, 0, 0)), MIRROR),
    "quarter": (pose.rotation(np.pi / 2, (0, 1, 0), (0, 0, 0)), pose.scaling(1, -1, 1, (0, 0, 0))),
    "sheared": (SHEAR, pose.compose(MIRROR, SHEAR)),
}


@pytest.mark.parametrize("kind", FLIPS)
def test_a_pose_becomes_its_mirror_image_through_a_flat_one(kind: str, make: Make, tmp_path: Path) -> None:
    ball = make.group("ball", make.primitive("cube", color=(0.1, 0.2, 0.3)))
    before, after = FLIPS[kind]
    frames = [make.group("scene", (ball, place)) for place in (before, before, after, after)]
    path, _ = written(Scene("scene", frames, True), tmp_path / "a.glb")
    times = np.concatenate([np.linspace(0, 1.99, 200), np.linspace(1.99, 2, 401), [2.5, 3]])
    (one,) = loaded((path, (times / FPS).tolist()))
    linear = np.array(next(each["worlds"] for each in one["objects"] if each["mesh"] is not None))[:, :3, :3]
    sizes = np.linalg.det(linear)
    first, last = sizes[0], sizes[-1]
    assert first * last < 0.0
    assert np.allclose(linear[times <= 1.99 - 1e-6], linear[0], atol=1e-5)
    assert np.allclose(linear[times >= 2.0], linear[-1], atol=1e-3)
    assert np.abs(sizes).min() < 0.01 * min(abs(first), abs(last))
    assert np.abs(sizes).max() < 1.001 * max(abs(first), abs(last))
    if kind != "sheared":
        squares = np.swapaxes(linear, 1, 2) @ linear
        assert np.abs(squares - squares * np.eye(3)).max() < 1e-4 * np.abs(squares).max()


# --- shapes ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", one_in(4, range(4)))
def test_extreme_scenes_load(part: int, tmp_path: Path) -> None:
    names = list(EXTREMES)[part::4]
    scenes = [evaluate(EXTREMES[name].text) for name in names]
    jobs = [written(scene, tmp_path / f"{name}.glb") for name, scene in zip(names, scenes, strict=True)]
    for one, (path, _), scene, name in zip(loaded(*jobs), jobs, scenes, names, strict=True):
        gltf = Gltf(path)
        reach = [corners(gltf, each, 0) for each in one["objects"] if each["mesh"] is not None]
        assert len(reach) == EXTREMES[name].bodies
        points, box = np.concatenate(reach), np.reshape(entity_box(scene.root), (2, 3))
        found = np.stack([points.min(axis=0), points.max(axis=0)])
        assert (np.abs(found - box) < 0.01 * np.ptp(box, axis=0)).all(), name  # of round shapes with sides


# --- textures --------------------------------------------------------------------------------------------------------


def test_textures_are_where_they_are(tmp_path: Path) -> None:
    """Every texture on every shape: the coordinates, the image and how it repeats, as the loader has them."""
    scene, objects = textured_scene(tmp_path)
    path, _ = written(scene, tmp_path / "a.glb")
    document = Gltf(path)
    views = [document.document["bufferViews"][image["bufferView"]] for image in document.document["images"]]
    data = [document.buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] for view in views]
    images = [Image.open(io.BytesIO(each)) for each in data]
    command = [str(NODE), str(HERE / "three_textures.mjs"), str(FOLDER), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)

    def rows() -> Iterator[tuple[int, np.ndarray, np.ndarray, np.ndarray]]:
        """The number of each object, points, normals and colors."""
        for one in json.loads(done.stdout):
            state = [one[key] for key in ("color", "flipY", "wrapS", "wrapT", "colorSpace", "repeat", "offset")]
            assert state == [[1, 1, 1], False, 1000, 1000, "srgb", [1, 1], [0, 0]]
            uv = np.reshape(one["places"], (-1, 3, 2)) * [1.0, -1.0] + [0.0, 1.0]  # rows are not upside down
            points, normals, at = sampled(np.reshape(one["corners"], (-1, 3, 3)), uv)
            (number,) = np.unique(nearest(points))
            yield int(number), points, normals, pixels_at(images[one["image"]], at)

    found = worst(objects, rows())
    assert len(found) == 72
    assert {name: one for name, one in found.items() if one[0] > NEAR} == {}
