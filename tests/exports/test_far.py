"""Far from the origin a file holds the same bodies as at it, or the export says which it cannot hold.

The volumes are those of closed forms, and of the same scene at the origin, read back by trimesh and usd-core.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from math import pi, sin
from pathlib import Path

import numpy as np
import pytest
import trimesh

import scenelang as sl

BEAM = '(difference (call "cube" :scale [2 .5 2]) (call "cylinder" :radius .3 :p0 [0 -1 0] :p1 [0 1 0]))'
SEGMENTS = 32
CIRCLE = SEGMENTS / 2 * sin(2 * pi / SEGMENTS)  # area of the polygon in a circle of radius 1
BODIES = {
    "beam": BEAM,
    "plate": '(call "cube" :scale [1 .001 1])',
    "ball": '(call "sphere" :radius .05)',
    "ring": '(call "torus" :radius 1 :tube .02)',
    "turned": f"(transform {BEAM} (rotate .4 [1 2 3]))",
    "mirrored": f"(transform {BEAM} (scale [-1 1 1]))",
    "two": '(union (call "cube" :scale .1) (transform (call "sphere" :radius .2) (translate [3 0 0])))',
}
FAR = (1e3, 1e5, 1e6, 8e6, 1e7)
ENDINGS = (".glb", ".usda", ".3mf", ".obj", ".ply")
Piece = tuple[np.ndarray, np.ndarray]  # corners in the world, less the place of the scene; faces


def program(body: str, distance: float) -> str:
    place = f"[{distance:.0f} 0 {distance / 2:.0f}]"
    return f'(bind "part" (lambda () (transform {BODIES.get(body, body)} (translate {place}))))'


def pieces(path: Path, place: np.ndarray) -> Iterator[Piece]:
    """The meshes of a file; places are subtracted in double precision, as a reader does that keeps offsets."""
    if path.suffix == ".usda":
        yield from _prims(path, place)
        return
    loaded = trimesh.load_scene(path, process=False)
    for name in loaded.graph.nodes_geometry:
        pose, geometry = loaded.graph[name]
        mesh = loaded.geometry[geometry]
        own = np.asarray(mesh.vertices, np.float64)
        at = pose[:3, 3] - place
        yield own @ pose[:3, :3].T + at, np.asarray(mesh.faces)


def _prims(path: Path, place: np.ndarray) -> Iterator[Piece]:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            pose = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim)).T
            points = np.array(mesh.GetPointsAttr().Get(), np.float64)
            counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
            assert (counts == 3).all()
            faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
            yield points @ pose[:3, :3].T + (pose[:3, 3] - place), faces


def volume(path: Path, distance: float) -> float:
    """The volume of all that a file holds; a mirrored part may have its faces turned, so each counts positively."""
    place = np.array([distance, 0.0, 0.5 * distance])
    found = 0.0
    for corners, faces in pieces(path, place):
        a, b, c = np.moveaxis(corners[faces] - corners.mean(axis=0), 1, 0)
        found += abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6.0
    return found


def exported(body: str, distance: float, path: Path, solid: bool) -> tuple[float, list[str]]:
    warnings: list[str] = []
    scene = sl.evaluate(program(body, distance))
    scene.export(path, settings={"solid": True} if solid else {}, warn=lambda d: warnings.append(d.message))
    return volume(path, distance), warnings


CELLS = [
    (body, ending, solid)
    for body, ending, solid in itertools.product(BODIES, ENDINGS, (False, True))
    if ending != ".3mf" or solid
]


@pytest.mark.parametrize(("body", "ending", "solid"), CELLS)
@pytest.mark.sampled(4)
def test_a_body_far_away_keeps_its_volume(body: str, ending: str, solid: bool, tmp_path: Path) -> None:
    if ending == ".usda":
        pytest.importorskip("pxr")
        if not solid:
            pytest.skip("spheres and cylinders are no meshes in USD; tests/exports/test_usd.py")
    near, _ = exported(body, 0.0, tmp_path / f"near{ending}", solid)
    for distance in FAR:
        far, warnings = exported(body, distance, tmp_path / f"far{ending}", solid)
        assert far == pytest.approx(near, rel=1e-3), distance
        assert warnings == []


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_beam_has_its_volume_in_every_format(ending: str, tmp_path: Path) -> None:
    if ending == ".usda":
        pytest.importorskip("pxr")
    found, _ = exported("beam", 4e5, tmp_path / f"a{ending}", solid=True)
    assert found == pytest.approx(2.0 - 0.5 * 0.09 * CIRCLE, rel=2e-3)


ALONE = [name for name in BODIES if name != "two"]  # of which the file has one volume


@pytest.mark.parametrize(("body", "distance"), list(itertools.product(ALONE, (0.0, 1e3, 9e3, 1e5, 1e6, 3e6, 8e6, 1e7))))
@pytest.mark.sampled(4)
def test_stl_warns_exactly_where_it_changes_a_volume(body: str, distance: float, tmp_path: Path) -> None:
    near, _ = exported(body, 0.0, tmp_path / "near.stl", True)
    far, warnings = exported(body, distance, tmp_path / "far.stl", True)
    changed = abs(far / near - 1.0) > 1e-3
    assert bool([text for text in warnings if "changes the volume" in text]) == changed, (far / near, warnings)
    assert not changed or distance > 1e4 or body == "ring"  # a tube of .02


def test_the_warning_names_word_and_size(tmp_path: Path) -> None:
    _, warnings = exported('(call "cube" :scale [.3 1 1])', 3e6, tmp_path / "a.stl", False)
    assert warnings == [
        'STL changes the volume of "cube" by 66.7 %: it is [0.3 1 1] large at [3e+06 0 1.5e+06]',
    ]


@pytest.mark.parametrize("distance", [0.0, 1e5, 1e7])
def test_measures_checks_and_labels_do_not_depend_on_the_place(distance: float) -> None:
    def at(place: float) -> sl.Scene:
        return sl.evaluate(program("beam", place))

    scene, near = at(distance), at(0.0)
    assert scene.measure().volume == pytest.approx(near.measure().volume, rel=1e-6)
    maps, own = (each.maps(sl.Camera(azimuth=30), size=(48, 48)) for each in (scene, near))
    assert (maps["instance"] == own["instance"]).mean() > 0.99
    both = np.isfinite(maps["depth"]) & np.isfinite(own["depth"])
    assert np.abs(maps["depth"][both] - own["depth"][both]).max() < 0.02
    image, at_origin = (np.asarray(each.render(sl.Camera(azimuth=30), size=(48, 48))) for each in (scene, near))
    assert np.abs(image.astype(int) - at_origin.astype(int)).mean() < 1.0


PLACED = '(transform (call "cube") (translate [1e7 8e5 -4e6]))'
OPERATIONS = {
    f'(hull {PLACED} (transform (call "sphere" :radius .3) (translate [10000002 8e5 -4e6])))': 2.007,
    f'(minkowski {PLACED} (call "sphere" :radius .1))': 1.694,
    f'(minkowski (call "sphere" :radius .1) {PLACED})': 1.694,
    f"(shell {PLACED} .05)": 0.271,
    f"(offset-solid {PLACED} .1)": 1.694,
    f"(rounded {PLACED} .1)": 0.972,
}


@pytest.mark.parametrize("operation", OPERATIONS)
def test_operations_on_operands_far_away(operation: str) -> None:
    """Not the solid but its operands are far: the volume is that of the same operation at the origin."""
    near = operation.replace("[1e7 8e5 -4e6]", "[0 0 0]").replace("[10000002 8e5 -4e6]", "[2 0 0]")
    far, own = (sl.evaluate(f'(bind "a" (lambda () {text}))').measure().volume for text in (operation, near))
    assert own == pytest.approx(OPERATIONS[operation], rel=0.1)
    assert far == pytest.approx(own, rel=1e-3)
