"""Edges of ``--solid`` exports, counted in the files by readers of this test.

By the numbers of their points every edge has two faces, which run along it in opposite directions. Readers that join
points at one place see edges with four faces where bodies only touch, and one warning says how many.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from searching import many

import scenelang as sl
from exports.gltf_reader import Gltf
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import Diagnostic

Cell = tuple[int, int, int]
Mesh = tuple[np.ndarray, np.ndarray]  # points, and faces by their numbers
INDEXED = (".obj", ".ply", ".glb", ".gltf", ".3mf", ".usda")

# --- readers ---------------------------------------------------------------------------------------------------------


def meshes(path: Path) -> Iterator[Mesh]:
    if path.suffix == ".obj":
        rows = [line.split() for line in path.read_text().splitlines()]
        faces = [[int(corner.split("/")[0]) - 1 for corner in row[1:]] for row in rows if row[:1] == ["f"]]
        yield np.array([row[1:4] for row in rows if row[:1] == ["v"]], float), np.array(faces)
    elif path.suffix == ".ply":
        yield ply(path.read_bytes())
    elif path.suffix == ".3mf":
        root = ET.fromstring(zipfile.ZipFile(path).read("3D/3dmodel.model"))
        for mesh in root.findall(".//{*}mesh"):
            points = [[float(v.attrib[axis]) for axis in "xyz"] for v in mesh.findall(".//{*}vertex")]
            faces = [[int(t.attrib[f"v{k}"]) for k in (1, 2, 3)] for t in mesh.findall(".//{*}triangle")]
            yield np.array(points), np.array(faces)
    elif path.suffix == ".usda":
        from pxr import Usd, UsdGeom

        stage = Usd.Stage.Open(str(path))
        for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
            if prim.IsA(UsdGeom.Mesh):
                faces = np.array(UsdGeom.Mesh(prim).GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
                yield np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get()), faces
    else:
        yield from ((seen.vertices, seen.faces) for seen in Gltf(path).seen())


def ply(data: bytes) -> Mesh:
    head, _, body = data.partition(b"end_header\n")
    kinds = {b"float": "<f4", b"double": "<f8", b"uchar": "u1", b"int": "<i4"}
    rows: dict[bytes, list[str]] = {}
    counts: dict[bytes, int] = {}
    for line in head.splitlines():
        match line.split():
            case [b"element", name, number]:
                rows[name], counts[name] = [], int(number)
            case [b"property", b"list", *_]:
                rows[name] += ["u1", "<i4", "<i4", "<i4"]
            case [b"property", kind, _]:
                rows[name].append(kinds[kind])
    points = np.frombuffer(body, ",".join(rows[b"vertex"]), counts[b"vertex"])
    faces = np.frombuffer(body[points.nbytes :], ",".join(rows[b"face"]), counts[b"face"])
    return np.stack([points[f"f{k}"] for k in range(3)], 1), np.stack([faces[f"f{k}"] for k in (1, 2, 3)], 1)


def stl(path: Path) -> Mesh:
    """The triangles of an STL file, whose points are joined by their places."""
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    return welded(np.frombuffer(path.read_bytes()[84:], row)["corners"].reshape(-1, 3), None)


def welded(points: np.ndarray, faces: np.ndarray | None) -> Mesh:
    places, number = np.unique(points + np.float32(0), axis=0, return_inverse=True)
    number = number.reshape(-1)
    return places, (number if faces is None else number[faces]).reshape(-1, 3)


def edge_counts(faces: np.ndarray) -> Counter[tuple[int, int]]:
    """How many faces run along each edge, in each of its directions."""
    return Counter((int(f[k]), int(f[k - 2])) for f in faces for k in range(3))


def check_closed(path: Path) -> None:
    found = list(meshes(path))
    assert found
    for _, faces in found:
        counts = edge_counts(faces)
        assert set(counts.values()) == {1}, path.suffix
        assert all((b, a) in counts for a, b in counts), path.suffix


def crowded(faces: np.ndarray) -> set[tuple[int, int]]:
    counts = Counter(tuple(sorted(edge)) for edge in edge_counts(faces).elements())
    assert all(count % 2 == 0 for count in counts.values())
    return {edge for edge, count in counts.items() if count > 2}


# --- scenes ----------------------------------------------------------------------------------------------------------


def cubes(cells: Iterable[Cell], size: str = "1", more: str = "") -> str:
    """Unit cubes at cells, with colors that differ."""
    parts = (
        f'(transform (call "cube" :scale {size} :color [{k % 3 / 2} .5 {k % 2}]) (translate [{x} {y} {z}]))'
        for k, (x, y, z) in enumerate(cells)
    )
    return f'(bind "it" (lambda () (union {" ".join(parts)} {more})))'


def touching_length(cells: set[Cell]) -> int:
    """How many edges of the grid have two cells around them that are opposite, and nothing else."""
    found = 0
    for x, y, z in product(range(-1, 5), repeat=3):
        for a, b in (((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)), ((0, 0, 1), (1, 0, 0))):
            around = [
                tuple(np.add((x, y, z), np.multiply(a, i) + np.multiply(b, j))) in cells
                for i, j in product((0, 1), repeat=2)
            ]
            found += around in ([True, False, False, True], [False, True, True, False])
    return found


def gear(teeth: int) -> str:
    """A gear along z, the tips of whose teeth are edges at the distance 1."""
    return f"(extrude (star {teeth} 1 .8) .5)"


def stairs(steps: int) -> set[Cell]:
    return {(k, k, 0) for k in range(steps)}


RAIL = '(transform (call "cube" :scale [4 .2 .5]) (translate [0 1.1 .25]))'
SCENES = {
    "two": cubes([(0, 0, 0), (1, 1, 0)]),
    "corner": cubes([(0, 0, 0), (1, 1, 1)]),
    "stairs": cubes(stairs(5)),
    "wide stairs": cubes(stairs(5), "[1 1 3]"),
    "thirds": cubes([(0, 0, 0), (1 / 3, 1 / 3, 0), (2 / 3, 2 / 3, 0)], ".3333333333333333"),
    "checkers": cubes((x, 0, z) for x in range(4) for z in range(4) if (x + z) % 2),
    "box in a corner": cubes([(0, 0, 0), (1, 0, 0), (0, 0, 1), (1, 1, 1)]),
    "gear and rail": f'(bind "it" (lambda () (union {gear(12)} {RAIL})))',
    "two gears": f'(bind "it" (lambda () (union {gear(12)} (transform {gear(12)} (translate [0 2 0])))))',
    "wedges": '(bind "it" (lambda () (union (extrude [[0 0] [1 1] [0 1]] 2) (extrude [[0 0] [-1 -1] [0 -1]] 2))))',
    "bow tie": '(bind "it" (lambda () (extrude [[0 0] [2 2] [2 0] [0 2]] 1 :fill :nonzero)))',
    "pinched ring": '(bind "it" (lambda () (difference (call "cube" :scale 2) (transform (call "cube" :scale [1 3 1] :color [1 0 0]) (@ (translate [1 0 1]) (translate [-1 0 -1]))) (transform (call "cube" :scale [1 3 1]) (translate [1 0 1])))))',
    "turned": '(bind "it" (lambda () (transform (call "two") (rotate .4 [1 2 3]))))' + cubes([(0, 0, 0), (1, 1, 0)]).replace('"it"', '"two"'),
    "far": cubes([(300_000, 0, 0), (300_001, 1, 0)]),
    "far apart": cubes([(0, 0, 0), (1, 1, 0), (10_000_000, 0, 0), (10_000_001, 1, 0)]),
    "balls": '(bind "it" (lambda () (union (call "sphere") (transform (call "sphere") (translate [2 0 0])))))',
    "cylinders": '(bind "it" (lambda () (union (call "cylinder") (transform (call "cylinder") (translate [2 0 0])))))',
}  # fmt: skip
CROWDED = {
    "two": 1,
    "corner": 0,
    "stairs": 4,
    "wide stairs": 4,
    "checkers": 9,
    "box in a corner": 2,
    "bow tie": 1,
    "balls": 0,
}
FRAMES = '(bind "it" (lambda () (list (call "near") (call "near"))))' + SCENES["two"].replace('"it"', '"near"')


def exported(text: str, path: Path) -> list[Diagnostic]:
    """Write a scene as one body, and return what is said of its edges."""
    said: list[Diagnostic] = []
    sl.evaluate(text).export(path, settings={"solid": True}, warn=said.append)
    return [each for each in said if each.code == "W642"]


def check_warning(found: list[Diagnostic], edges: int) -> None:
    assert len(found) == (edges > 0)
    if found:
        assert found[0].message.startswith(f"{edges:,} edge{'s belong' if edges > 1 else ' belongs'} to more than two")


# --- tests -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", INDEXED)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.sampled(3)
def test_every_edge_has_two_faces_by_its_points(name: str, ending: str, tmp_path: Path) -> None:
    if ending == ".usda":
        pytest.importorskip("pxr")
    path = tmp_path / f"a{ending}"
    warned = exported(SCENES[name], path)
    check_closed(path)
    if not name.startswith("far"):
        check_warning(
            warned, sum(len(crowded(welded(points.astype(np.float32), faces)[1])) for points, faces in meshes(path))
        )


@pytest.mark.parametrize("name", SCENES)
def test_a_warning_counts_the_edges_of_stl(name: str, tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    warned = exported(SCENES[name], path)
    edges = len(crowded(stl(path)[1]))
    check_warning(warned, edges)
    assert edges == CROWDED.get(name, edges)


def test_the_command_warns_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also where a file is animated, and where each part is a file."""
    program = tmp_path / "a.scene"
    program.write_text(SCENES["stairs"])
    for ending in (".stl", *INDEXED[:3]):
        assert main(["export", str(program), "--solid", "-o", str(tmp_path / f"a{ending}")]) == 0
        assert capsys.readouterr().err.count("W642") == 1, ending
        assert main(["export", str(program), "-o", str(tmp_path / f"a{ending}")]) == 0
        assert "W642" not in capsys.readouterr().err


def test_frames_have_one_warning(tmp_path: Path) -> None:
    check_warning(exported(FRAMES, tmp_path / "a.stl"), 1)
    warned = exported(FRAMES, tmp_path / "a.glb")
    check_closed(tmp_path / "a.glb")
    check_warning(warned, sum(len(crowded(welded(*mesh)[1])) for mesh in meshes(tmp_path / "a.glb")))


CELL = st.tuples(*[st.integers(0, 2)] * 3)


@settings(max_examples=many(150), deadline=None)
@given(st.sets(CELL, min_size=1, max_size=14), st.sampled_from(INDEXED[:5]))
@example({(0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)}, ".3mf")
def test_grids_of_touching_cubes(tmp_path_factory: pytest.TempPathFactory, cells: set[Cell], ending: str) -> None:
    """The edges with four faces are as long as those of the grid that only touch, whichever points they have."""
    folder = tmp_path_factory.mktemp("grid")
    for name in (f"a{ending}", "a.stl"):
        warned = exported(cubes(sorted(cells)), folder / name)
        found = [stl(folder / name)] if name == "a.stl" else [welded(*mesh) for mesh in meshes(folder / name)]
        assert name == "a.stl" or check_closed(folder / name) is None
        check_warning(warned, sum(len(crowded(faces)) for _, faces in found))
        length = sum(math.dist(points[a], points[b]) for points, faces in found for a, b in crowded(faces))
        assert length == pytest.approx(touching_length(cells), abs=1e-4)
