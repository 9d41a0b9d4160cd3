"""Comparing flattened scenes: what counts as the same, and how changes are told."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from corpus.compare import compare
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from searching import many
from support import calls, evaluate, peak_bytes

import scenelang as sl
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.inspection.difference import (
    ComparedFrame,
    ComparedSolid,
    FrameDifference,
    compare_frames,
    compared_frame,
    solid_of,
)
from scenelang.interpreter.scene.flatten import flatten
from scenelang.session.scene_changes import compared_frames, read_compared_frames

CORPUS = Path(__file__).parent / "corpus"
Row = tuple[ComparedSolid, Any]  # a solid and the upper rows of its matrix


def frame_of(rows: Sequence[Row], paths: Sequence[tuple[str, ...]] = ()) -> ComparedFrame:
    matrices = np.array([matrix for _, matrix in rows], float).reshape(len(rows), 3, 4)
    known = list(dict.fromkeys(paths)) or [()]
    path_index = np.array([known.index(path) for path in paths] or [0] * len(rows), np.int64)
    return ComparedFrame(tuple(solid for solid, _ in rows), np.arange(len(rows)), matrices, tuple(known), path_index)


def counts(found: FrameDifference) -> tuple[int, int, int, int, int]:
    return found.matched, len(found.moved), len(found.recolored), len(found.missing), len(found.extra)


def pose(*position: float, linear: Any = None) -> Any:
    matrix = np.zeros((3, 4))
    matrix[:, :3] = np.eye(3) if linear is None else linear
    matrix[:, 3] = position
    return matrix


def of_program(text: str) -> ComparedFrame:
    (frame,) = flatten(evaluate(f'(bind "a" (lambda () (union {text})))')).frames
    return compared_frame(frame)


CUBE = ComparedSolid("cube", "cube", "", (1.0, 1.0, 1.0))
RED = ComparedSolid("cube", "cube", "", (1.0, 0.0, 0.0))
FAR = (CUBE, pose(10, 0, 0))  # gives the scene a size


# --- what is the same --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("a", "b", "same"),
    [
        ('(call "cube")', '(transform (call "cube") (rotate (/ pi 2) [0 0 1]))', True),
        ('(call "cube")', '(transform (call "cube") (rotate (/ pi 4) [0 0 1]))', False),
        ('(call "cube" :scale [1 2 1])', '(transform (call "cube" :scale [1 2 1]) (rotate (/ pi 4) [0 1 0]))', False),
        ('(call "cube")', '(transform (call "cube") (@ (rotate pi [1 0 0]) (scale [1 1 -1])))', True),
        ('(call "moai")', '(transform (call "moai") (rotate pi [0 1 0]))', False),
        ('(call "cube" :scale 2)', '(transform (call "cube") (scale 2))', True),
        ('(call "cube" :scale [1 2 3])', '(transform (call "cube" :scale [2 1 3]) (rotate (/ pi 2) [0 0 1]))', True),
        ('(call "sphere" :radius 2)', '(transform (call "sphere") (@ (rotate 1 [1 2 3]) (scale -2)))', True),
        ('(call "cylinder" :radius 2)', '(transform (call "cylinder" :radius 2) (rotate 1 [0 1 0]))', True),
        ('(call "cylinder")', '(transform (call "cylinder" :p0 [0 -1 0] :p1 [0 0 0]) (translate [0 1 0]))', True),
        ('(call "cylinder")', '(call "cone")', False),
        ('(call "cube" :color [1 .5 0])', '(call "cube" :color [1 .501 0])', True),
        ('(call "cube" :color [1 .5 0])', '(call "cube" :color [1 .51 0])', False),
        ('(call "cube" :color [2 .5 -1])', '(call "cube" :color [1 .5 0])', True),
        ('(call "moai" :scale 2)', '(transform (call "moai") (scale 2))', True),
        ('(call "moai")', '(call "tree")', False),
        ('(call "set-cuboid" :block-type "stone" :scale [2 3 4])', '(transform (call "set-cuboid" :block-type "stone") (scale [2 3 4]))', True),
        ('(call "set-cuboid" :block-type "stone")', '(call "set-cuboid" :block-type "dirt")', False),
        ('(call "set-cuboid" :block-type "stone")', '(call "set-cuboid" :block-type "stone" :fill #f)', False),
        ('(call "set-cuboid" :block-type "log" :block-kwargs (table "axis" "x"))', '(call "set-cuboid" :block-type "log" :block-kwargs (table "axis" "y"))', False),
        ('(call "set-cuboid" :block-type "log" :block-kwargs (table "a" "1" "b" "2"))', '(call "set-cuboid" :block-type "log" :block-kwargs (table "b" "2" "a" "1"))', True),
    ],
)  # fmt: skip
def test_same_geometry(a: str, b: str, same: bool) -> None:
    alone = compare_frames(of_program(a), of_program(b))
    far = '(transform (call "sphere") (translate [9 0 0]))'
    beside = compare_frames(of_program(f"{far} {a}"), of_program(f"{b} {far}"))
    assert (alone.equal, beside.equal) == (same, same)


def test_multiplicity_counts() -> None:
    twice, thrice = frame_of([FAR, *[(CUBE, pose(0, 0, 0))] * 2]), frame_of([*[(CUBE, pose(0, 0, 0))] * 3, FAR])
    assert counts(compare_frames(twice, twice)) == (3, 0, 0, 0, 0)
    assert counts(compare_frames(twice, thrice)) == (3, 0, 0, 0, 1)
    assert counts(compare_frames(thrice, twice)) == (3, 0, 0, 1, 0)
    nothing = frame_of([])
    assert counts(compare_frames(nothing, nothing)) == (0, 0, 0, 0, 0)
    assert counts(compare_frames(nothing, twice)) == (0, 0, 0, 0, 3)


def test_tolerance_is_relative() -> None:
    for size in (1e-2, 1.0, 1e6):
        rows = [(CUBE, pose(0, 0, 0, linear=np.eye(3) * size)), (CUBE, pose(size, 0, 0, linear=np.eye(3) * size))]
        near, far = ([rows[0], (CUBE, pose(size * (1 + x), 0, 0, linear=np.eye(3) * size))] for x in (9e-6, 1.2e-5))
        assert compare_frames(frame_of(rows), frame_of(near)).equal
        assert not compare_frames(frame_of(rows), frame_of(far)).equal
        assert compare_frames(frame_of(rows), frame_of(far), tolerance=1e-4).equal


def test_numbers_too_large() -> None:
    huge = frame_of([(CUBE, pose(1e300, 0, 0, linear=np.eye(3) * 1e300)), (CUBE, pose(0, 0, 0))])
    with pytest.raises(SceneError):
        compare_frames(huge, frame_of([(CUBE, pose(-1e308, 0, 0)), (CUBE, pose(1e308, 0, 0))]))


def test_as_many_as_possible_are_paired() -> None:
    """Nearest first would pair 4 with 5 and leave 0 and 9 alone."""
    step = 1e-5 * 10 / 6
    a, b = ([FAR, (CUBE, pose(0, 0, 0))] + [(CUBE, pose(x * step, 0, 0)) for x in xs] for xs in ((5, 9), (0, 4)))
    wanted = compare_frames(frame_of(a[:1] + a[2:]), frame_of(b[:1] + b[2:]))
    assert counts(wanted) == (3, 0, 0, 0, 0)


def test_colors_are_paired_so_that_most_agree() -> None:
    colored = lambda r: (ComparedSolid("cube", "cube", "", (r, 0.0, 0.0)), pose(0, 0, 0))
    found = compare_frames(frame_of([FAR, colored(0.2), colored(0.3)]), frame_of([FAR, colored(0.3), colored(0.1)]))
    assert counts(found) == (2, 0, 1, 0, 0)


# --- how changes are told ----------------------------------------------------------------------------------------------


def test_moved_things_pair_with_the_nearest_alike() -> None:
    before = [FAR, (CUBE, pose(0, 0, 0)), (CUBE, pose(1, 0, 0)), (RED, pose(2, 0, 0))]
    after = [FAR, (RED, pose(2, 1, 0)), (CUBE, pose(1, 0.5, 0)), (CUBE, pose(0, 0.25, 0))]
    found = compare_frames(frame_of(before), frame_of(after))
    assert counts(found) == (1, 3, 0, 0, 0)
    assert found.moved.tolist() == [[1, 3], [2, 2], [3, 1]]
    assert found.positions_a[1].tolist() == [0, 0, 0]
    assert found.positions_b[3].tolist() == [0, 0.25, 0]


def test_small_turned_cubes_are_seen() -> None:
    for angle, same in ((1e-4, True), (0.01, False), (np.pi / 4, False), (np.pi / 2, True)):
        turn = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
        before, after = ([(CUBE, pose(100, 0, 0)), (CUBE, pose(0, 0, 0, linear=m))] for m in (np.eye(3), turn))
        assert compare_frames(frame_of(before), frame_of(after), 2e-6).equal == same, angle


def test_turned_things_have_moved_but_larger_ones_not() -> None:
    turned = pose(0, 0, 0, linear=[[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    assert counts(compare_frames(frame_of([FAR, (CUBE, pose(0, 0, 0))]), frame_of([FAR, (CUBE, turned)]))) == (
        1,
        1,
        0,
        0,
        0,
    )
    larger = pose(0, 0, 0, linear=np.eye(3) * 1.1)
    assert counts(compare_frames(frame_of([FAR, (CUBE, pose(0, 0, 0))]), frame_of([FAR, (CUBE, larger)]))) == (
        1,
        0,
        0,
        1,
        1,
    )


def test_a_block_of_another_type_is_recolored() -> None:
    stone, dirt = (solid_of("block", {"block_type": f"minecraft:{name}"}) for name in ("stone", "dirt"))
    found = compare_frames(frame_of([FAR, (stone, pose(1, 2, 3))]), frame_of([(dirt, pose(1, 2, 3)), FAR]))
    assert counts(found) == (1, 0, 1, 0, 0)


def test_labels() -> None:
    rows = [(CUBE, pose(i, 0, 0)) for i in range(4)]
    made = frame_of(rows, [("a", "b"), ("a",), ("a", "b"), ("c",)])
    assert made.labels([0, 1, 2, 3]) == ["a/b[0]", "a", "a/b[1]", "c"]
    assert frame_of(rows).labels([2]) == ["[2]"]


# --- random scenes -----------------------------------------------------------------------------------------------------

coordinates = st.floats(-10, 10).map(lambda x: round(x, 2))
colors = st.tuples(*[st.sampled_from([0.0, 0.5, 1.0])] * 3)
round_words = st.sampled_from(["cylinder", "cone"])
solids = st.one_of(
    st.builds(lambda c, x: ComparedSolid("cube", "cube", "", c, (x, 1.0, 2.0)), colors, st.sampled_from([1.0, 1.5])),
    st.builds(lambda c, r: ComparedSolid("sphere", "sphere", "", c, (r, r, r)), colors, st.sampled_from([1.0, 2.5])),
    st.builds(lambda w, c, y: ComparedSolid(w, w, "", c, p1=(0.0, y, 0.5), radius=0.5), round_words, colors, st.sampled_from([1.0, 2.0])),
    st.builds(lambda name: solid_of("block", {"block_type": name}), st.sampled_from(["stone", "dirt"])),
)  # fmt: skip


@st.composite
def rows(draw: Any) -> Row:
    solid = draw(solids)
    linear = np.eye(3)
    if not solid.is_block:
        angle = draw(st.sampled_from([0.0, 0.5, 1.1]))
        cosine, sine = np.cos(angle), np.sin(angle)
        linear = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]]) * draw(st.sampled_from([1.0, 2.0]))
    return solid, pose(*draw(st.tuples(coordinates, coordinates, coordinates)), linear=linear)


ENDS = [(CUBE, pose(-20, 0, 0)), (CUBE, pose(20, 0, 0))]
scenes = st.lists(rows(), min_size=1, max_size=12).map(lambda found: [*ENDS, *found])
RUNS = settings(max_examples=many(200), deadline=None)


@RUNS
@given(scenes, st.randoms(use_true_random=False))
def test_order_and_noise_do_not_matter(scene: list[Row], random: Any) -> None:
    noise = lambda: np.array([[random.uniform(-2e-5, 2e-5) for _ in range(4)] for _ in range(3)])
    shuffled = [(solid, matrix + noise()) for solid, matrix in scene]
    random.shuffle(shuffled)
    found = compare_frames(frame_of(scene), frame_of(shuffled))
    assert counts(found) == (len(scene), 0, 0, 0, 0)


@RUNS
@given(scenes, rows(), st.randoms(use_true_random=False))
def test_one_more_and_one_less(scene: list[Row], more: Row, random: Any) -> None:
    grown = [*scene, more]
    random.shuffle(grown)
    size = len(scene)
    assert counts(compare_frames(frame_of(scene), frame_of(grown))) == (size, 0, 0, 0, 1)
    assert counts(compare_frames(frame_of(grown), frame_of(scene))) == (size, 0, 0, 1, 0)


@RUNS
@given(scenes, rows(), st.randoms(use_true_random=False))
def test_one_moved(scene: list[Row], row: Row, random: Any) -> None:
    solid, matrix = row
    moved = matrix.copy()
    moved[random.randrange(3), 3] += random.choice([-1, 1]) * random.uniform(0.01, 5)
    after = [*scene, (solid, moved)]
    random.shuffle(after)
    found = compare_frames(frame_of([*scene, row]), frame_of(after))
    assume(not any(other is solid for other, _ in scene))
    assert counts(found) == (len(scene), 1, 0, 0, 0)
    assert found.moved[0, 0] == len(scene) or scene[found.moved[0, 0]][0] == solid  # an equal one may stand for it


@RUNS
@given(scenes, rows(), colors, st.randoms(use_true_random=False))
def test_one_recolored(scene: list[Row], row: Row, color: Any, random: Any) -> None:
    solid, matrix = row
    painted = solid_of("block", {"block_type": "gold"}) if solid.is_block else replace(solid, color=color)
    assume(painted != solid)
    after = [*scene, (painted, matrix)]
    random.shuffle(after)
    found = compare_frames(frame_of([*scene, row]), frame_of(after))
    assert counts(found) == (len(scene), 0, 1, 0, 0)


def compare_many(count: int) -> None:
    """Scenes of ``count`` parts of 50 kinds: in another order, all moved, all in one place."""
    random = np.random.default_rng(0)
    matrices = np.zeros((count, 3, 4))
    matrices[:, :, :3] = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    matrices[:, :, 3] = random.uniform(-100, 100, (count, 3))
    order = random.permutation(count)
    paths = np.zeros(count, np.int64)
    kinds = tuple(ComparedSolid("cube", "cube", "", tuple(random.random(3)), (1.0, 2.0, 3.0)) for _ in range(50))
    index = random.integers(0, 50, count)
    before = ComparedFrame(kinds, index, matrices, ((),), paths)
    shifted = matrices.copy()
    shifted[:, :, 3] += 1
    assert compare_frames(before, ComparedFrame(kinds, index[order], matrices[order], ((),), paths)).equal
    moved = compare_frames(before, ComparedFrame(kinds, index[order], shifted[order], ((),), paths))
    assert counts(moved) == (0, count, 0, 0, 0)
    stacked = ComparedFrame(kinds, paths, np.repeat(matrices[:1], count, axis=0), ((),), paths)
    assert compare_frames(stacked, stacked).equal


@pytest.mark.parametrize("measure", [calls, peak_bytes])
def test_scenes_of_twice_the_parts_take_twice_the_work(measure: Callable[[Callable[[], object]], int]) -> None:
    compare_many(100)  # what is made once
    half, whole = (measure(lambda n=n: compare_many(n)) for n in (2_000, 4_000))
    assert whole < 2.3 * half


# --- JSON --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("golden", sorted(CORPUS.glob("*.json")), ids=lambda path: path.stem)
@pytest.mark.sampled(6)
def test_equality_agrees_with_the_corpus_tool(golden: Path, tmp_path: Path) -> None:
    data = json.loads(golden.read_text())
    random = np.random.default_rng(1)
    before = read_compared_frames(str(golden), 10**6)
    for amount in (0.0, 1e-7, 1e-5, 1e-3):
        changed = json.loads(golden.read_text())
        for frame in changed["frames"]:
            random.shuffle(frame["primitives"])
            for primitive in frame["primitives"][:3]:
                primitive["matrix"][1][3] += amount * random.uniform(-3, 3)
                primitive["matrix"][0][2] += amount * random.uniform(-3, 3)
        path = tmp_path / "changed.json"
        path.write_text(json.dumps(changed))
        found = [compare_frames(a, b) for a, b in zip(before, read_compared_frames(str(path), 10**6))]
        wanted = compare(data, changed)
        assert all(frame.equal for frame in found) == wanted["equal"], amount
        assert sum(len(frame.moved) + len(frame.missing) for frame in found) == wanted["only_a"]


PRIMITIVE = {"shape": "cube", "matrix": np.eye(4).tolist(), "color": [1, 0, 0], "path": ["a"]}
WRONG = {
    "no JSON": "{",
    "no object": "[]",
    "no text": "\ufeff",
    "a number": "1e999",
    "no frames": "{}",
    "frames of nothing": '{"frames": 5}',
    "a frame of nothing": '{"frames": [5]}',
    "no primitives": '{"frames": [{"primitives": {"a": 1}}]}',
    "deep": '{"frames": ' + "[" * 100_000 + "]" * 100_000 + "}",
    "deep tables": '{"frames": ' + '{"a":' * 50_000 + "1" + "}" * 50_000 + "}",
    "not a number": '{"frames": [{"primitives": [{"shape": "cube", "matrix": [NaN]}]}]}',
    "endless digits": '{"frames": ' + "1" * 10_000 + "}",
}
WRONG_PRIMITIVES: list[Any] = [
    None,
    [],
    {},
    {**PRIMITIVE, "shape": 5},
    {**PRIMITIVE, "matrix": None},
    {**PRIMITIVE, "matrix": [[1, 2], [3, 4]]},
    {**PRIMITIVE, "matrix": [["1"] * 4] * 4},
    {**PRIMITIVE, "matrix": [[1, 0, 0, 0]] * 4},
    {**PRIMITIVE, "matrix": [[10**400, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]},
    {**PRIMITIVE, "matrix": [[True, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]},
    {**PRIMITIVE, "color": "red"},
    {**PRIMITIVE, "color": [1]},
    {**PRIMITIVE, "color": {"r": 1}},
    {**PRIMITIVE, "scale": [1, "2", 3]},
    {**PRIMITIVE, "path": "a"},
    {**PRIMITIVE, "path": [1]},
    {**PRIMITIVE, "attributes": "x"},
    {**PRIMITIVE, "shape": "cylinder", "p0": [0, 0, 0], "p1": [0, 1], "radius": 1},
    {**PRIMITIVE, "shape": "cylinder", "p0": [0, 0, 0], "p1": [0, 1, 0], "radius": 10**400},
    {**PRIMITIVE, "shape": "sphere", "radius": []},
    {**PRIMITIVE, "shape": "block", "block_kwargs": "x"},
    {**PRIMITIVE, "shape": "block", "block_kwargs": [1]},
]


@pytest.mark.parametrize("text", WRONG.values(), ids=WRONG)
def test_malformed_files(text: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.json"
    path.write_text(text)
    with pytest.raises(SceneError) as caught:
        read_compared_frames(str(path), 1000)
    assert caught.value.name == "file"
    assert str(path) in caught.value.message


@pytest.mark.parametrize("primitive", WRONG_PRIMITIVES, ids=range(len(WRONG_PRIMITIVES)))
def test_malformed_primitives(primitive: Any, tmp_path: Path) -> None:
    path = tmp_path / "wrong.json"
    path.write_text(json.dumps({"frames": [{"primitives": [PRIMITIVE, primitive]}]}))
    with pytest.raises(SceneError, match=r"frames\[0\]\.primitives\[1\]"):
        read_compared_frames(str(path), 1000)


def test_files_have_limits(tmp_path: Path) -> None:
    path = tmp_path / "many.json"
    path.write_text(json.dumps({"frames": [{"primitives": [PRIMITIVE] * 6}, {"primitives": [PRIMITIVE] * 5}]}))
    assert [len(frame) for frame in read_compared_frames(str(path), 11)] == [6, 5]
    with pytest.raises(SceneError) as caught:
        read_compared_frames(str(path), 10)
    assert caught.value.name == "primitives"
    (tmp_path / "bytes.json").write_bytes(b'{"frames": "\xff"}')
    for name in ("bytes.json", "nothing.json", "folder.json"):
        (tmp_path / "folder.json").mkdir(exist_ok=True)
        with pytest.raises(SceneError):
            read_compared_frames(str(tmp_path / name), 10)


data = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3), st.just(PRIMITIVE), st.just(10**400)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(st.sampled_from(["frames", "primitives", "shape", "word", "matrix", "attributes", "color", "path", "radius"]), inner),
    ),
    max_leaves=20,
)  # fmt: skip


@settings(max_examples=many(120), deadline=None)
@given(
    data,
    st.lists(st.dictionaries(st.sampled_from([*PRIMITIVE, "attributes", "p0", "radius", "scale", "block_type"]), data)),
)
def test_no_file_crashes_the_reader(anything: Any, changes: list[dict[str, Any]]) -> None:
    import tempfile

    for content in (anything, {"frames": [{"primitives": [{**PRIMITIVE, **change} for change in changes]}]}):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "any.json"
            path.write_text(json.dumps(content))
            try:
                for frame in read_compared_frames(str(path), 1000):
                    assert compare_frames(frame, frame).equal
            except SceneError:
                pass


@pytest.mark.parametrize("attributes", [
    ':material "oak"', ':texture "brick"', ":metallic 1", ":roughness .2", ":opacity .5", ":coat 1",
    ":emission 1", ":ior 1.5 :opacity .3",
])  # fmt: skip
def test_another_material_is_a_difference(attributes: str) -> None:
    plain, other = (
        sl.evaluate(f'(bind "a" (lambda () (call "cube" :color [.5 .5 .5] {more})))') for more in ("", attributes)
    )
    difference = compare_frames(*(compared_frames(scene.graph, 10)[0] for scene in (plain, other)))
    assert (difference.matched, len(difference.recolored)) == (0, 1)


def test_defaults_and_rounding_are_no_difference() -> None:
    plain, other = (
        sl.evaluate(f'(bind "a" (lambda () (call "cube" {more})))')
        for more in (":roughness .3", ":roughness (+ .1 .2) :metallic 0 :opacity 1")
    )
    assert compare_frames(*(compared_frames(scene.graph, 10)[0] for scene in (plain, other))).equal
