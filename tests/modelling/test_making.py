"""Exports for making things: 3MF, one watertight body, and triangles by size."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import scenelang as sl
from scenelang.grammar.diagnostics import LimitError, SceneError

ROOT = Path(__file__).parents[2]
BRACKET = """
(bind "bolt" (lambda () (call "cylinder" :radius .2 :p0 [0 -1 0] :p1 [0 1 0] :color [0 0 1])))
(bind "plate" (lambda () (difference (call "cube" :scale [2 .4 2] :color [1 0 0]) (call "bolt"))))
(bind "foot" (lambda () (call "sphere" :radius .3 :color [0 1 0])))
(bind "thing" (lambda ()
  (union (call "plate") (transform (call "foot") (translate [.8 -.2 .8]))
         (transform (call "foot") (@ (scale [-1 1 1]) (translate [.8 -.2 .8]))))))
"""


@pytest.fixture(scope="module")
def thing() -> sl.Scene:
    return sl.evaluate(BRACKET)


def read_3mf(path: Path) -> Any:
    """The model as the consortium's own library reads it, without warnings."""
    lib3mf = pytest.importorskip("lib3mf")
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    return model


def objects_of(model: Any) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    each = model.GetMeshObjects()
    while each.MoveNext():
        mesh = each.GetCurrentMeshObject()
        found.setdefault(mesh.GetName(), []).append(mesh)
    return found


def test_3mf_has_named_parts_that_are_solid(thing: sl.Scene, tmp_path: Path) -> None:
    thing.export(tmp_path / "a.3mf")
    model = read_3mf(tmp_path / "a.3mf")
    meshes = objects_of(model)
    assert set(meshes) == {"difference", "sphere"}
    assert all(mesh.IsManifoldAndOriented() for each in meshes.values() for mesh in each)
    parts = model.GetComponentsObjects()
    names = []
    while parts.MoveNext():
        names.append(parts.GetCurrentComponentsObject().GetName())
    assert names == ["plate", "foot", "foot"]
    assert len(meshes["sphere"]) == 2  # one is mirrored


def test_3mf_is_z_up_with_the_sizes_of_the_scene(thing: sl.Scene, tmp_path: Path) -> None:
    thing.export(tmp_path / "a.3mf", settings={"unit": "centimeter"})
    text = zipfile.ZipFile(tmp_path / "a.3mf").read("3D/3dmodel.model").decode()
    assert 'unit="centimeter"' in text
    mesh = trimesh.load(tmp_path / "a.3mf", force="mesh")
    low, high = np.array(thing.bounds).reshape(2, 3)
    standing = np.array([[low[0], -high[2], low[1]], [high[0], -low[2], high[1]]])
    assert mesh.bounds == pytest.approx(standing, abs=1e-6)


def test_3mf_has_the_colors_of_faces(thing: sl.Scene, tmp_path: Path) -> None:
    thing.export(tmp_path / "a.3mf")
    text = zipfile.ZipFile(tmp_path / "a.3mf").read("3D/3dmodel.model").decode()
    colors = {line.split('"')[1] for line in text.splitlines() if line.startswith("<base ")}
    assert colors == {"#FF0000FF", "#0000FFFF", "#00FF00FF"}
    assert ' p1="' in text


def test_words_of_any_characters_are_names(tmp_path: Path) -> None:
    scene = sl.evaluate(
        '(bind "a<b>&\\"\\x1;c\'" (lambda () (call "cube")))\n(bind "all" (lambda () (call "a<b>&\\"\\x1;c\'")))'
    )
    scene.export(tmp_path / "a.3mf")
    parts = read_3mf(tmp_path / "a.3mf").GetComponentsObjects()
    assert parts.MoveNext()
    assert parts.GetCurrentComponentsObject().GetName() == "a<b>&\"c'"


def test_equal_scenes_are_equal_files(thing: sl.Scene, tmp_path: Path) -> None:
    thing.export(tmp_path / "a.3mf")
    sl.evaluate(BRACKET).export(tmp_path / "b.3mf")
    assert (tmp_path / "a.3mf").read_bytes() == (tmp_path / "b.3mf").read_bytes()


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "3mf"])
def test_solid_exports_are_one_watertight_body(thing: sl.Scene, tmp_path: Path, ending: str) -> None:
    thing.export(tmp_path / f"a.{ending}", settings={"solid": True})
    mesh = trimesh.load(tmp_path / f"a.{ending}", force="mesh")
    mesh.merge_vertices(merge_norm=True, merge_tex=True)
    assert mesh.is_watertight
    assert mesh.body_count == 1
    assert mesh.volume == pytest.approx(sl.evaluate(BRACKET).measure().volume, rel=1e-3)


@pytest.mark.parametrize("ending", ["obj", "ply", "glb", "3mf"])
def test_bodies_are_closed_by_their_numbers_alone(thing: sl.Scene, tmp_path: Path, ending: str) -> None:
    thing.export(tmp_path / f"a.{ending}", settings={"solid": True})
    mesh = trimesh.load(tmp_path / f"a.{ending}", process=False, force="mesh")
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(sl.evaluate(BRACKET).measure().volume, rel=1e-3)


def test_faces_of_a_ply_body_have_their_colors(thing: sl.Scene, tmp_path: Path) -> None:
    thing.export(tmp_path / "a.ply", settings={"solid": True})
    colors = trimesh.load(tmp_path / "a.ply", process=False).visual.face_colors
    assert set(map(tuple, colors.tolist())) == {(255, 0, 0, 255), (0, 0, 255, 255), (0, 255, 0, 255)}


@pytest.mark.parametrize("ending", ["obj", "glb"])
def test_points_of_a_body_have_the_mean_color_of_the_faces_around(tmp_path: Path, ending: str) -> None:
    """At the corner of a half red, half blue cube, whatever its triangles are."""
    scene = sl.evaluate(
        '(bind "half" (lambda () (union (call "cube" :color [1 0 0])'
        '  (transform (call "cube" :color [0 0 1]) (translate [1 0 0])))))'
    )
    scene.export(tmp_path / f"a.{ending}", settings={"solid": True})
    mesh = trimesh.load(tmp_path / f"a.{ending}", process=False, force="mesh", skip_materials=True)
    colors = np.array(mesh.visual.vertex_colors)[:, :3]
    at = np.asarray(mesh.vertices)
    assert (colors[at[:, 0] < 0] == [255, 0, 0]).all()
    assert (colors[at[:, 0] > 1] == [0, 0, 255]).all()
    middle = np.unique(colors[(at[:, 0] > 0) & (at[:, 0] < 1)], axis=0)
    assert len(middle) == 1
    assert middle[0, 0] == middle[0, 2]


def test_bodies_stay_closed_where_readers_join_points_of_single_precision(tmp_path: Path) -> None:
    """Two twisted halves meet in slivers, shorter than the steps of single precision."""
    sl.load(ROOT / "examples" / "making" / "vase.scene").export(tmp_path / "a.stl", settings={"solid": True})
    assert trimesh.load(tmp_path / "a.stl").is_watertight


def test_faces_that_become_each_others_reverse_vanish() -> None:
    """A cube with a pocket in an edge, whose rim is too short."""
    from scenelang.backends.exports.plan import ExportSurface, shared

    pocket = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])  # a tetrahedron, 1 and 2 of which are one place
    cube = trimesh.creation.box()
    points = np.concatenate([np.array([[3.0, 0, 0], [5, 0, 0], [5 + 1e-9, 0, 0], [4, 1, 0]]), cube.vertices])
    faces = np.concatenate([pocket, cube.faces + 4])
    body = shared(ExportSurface(points, np.zeros_like(points), faces, joints=faces))
    assert (len(body.vertices), len(body.faces)) == (8, 12)
    assert trimesh.Trimesh(body.vertices, body.faces, process=False).is_watertight


def test_a_body_in_usd_shares_points_and_keeps_colors_of_faces(thing: sl.Scene, tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.UsdGeom")
    thing.export(tmp_path / "a.usda", settings={"solid": True})
    stage = pytest.importorskip("pxr.Usd").Stage.Open(str(tmp_path / "a.usda"))
    (mesh,) = (usd.Mesh(prim) for prim in stage.Traverse() if prim.IsA(usd.Mesh))
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    assert trimesh.Trimesh(mesh.GetPointsAttr().Get(), faces, process=False).is_watertight
    assert mesh.GetNormalsInterpolation() == "faceVarying"
    assert len(mesh.GetNormalsAttr().Get()) == 3 * len(faces)
    colors = mesh.GetDisplayColorPrimvar()
    assert colors.GetInterpolation() == "uniform"
    assert len(np.unique(np.array(colors.Get()), axis=0)) == 3


def test_the_union_of_an_example_is_watertight_and_has_its_bounds(tmp_path: Path) -> None:
    scene = sl.load(ROOT / "examples" / "menger-sponge.scene", defines={"level": 2})
    scene.export(tmp_path / "a.stl", settings={"solid": True})
    mesh = trimesh.load(tmp_path / "a.stl")
    assert mesh.is_watertight
    assert mesh.bounds == pytest.approx(np.array(scene.bounds).reshape(2, 3), abs=1e-6)
    assert mesh.volume == pytest.approx((20 / 27) ** 2, rel=1e-5)


def test_blocks_are_joined_as_their_cubes(tmp_path: Path) -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (union (call "set-cuboid" :block-type "stone" :scale [3 1 1]) '
        '(transform (call "delete-blocks" :scale [1 1 1]) (translate [1 0 0])))))'
    )
    scene.export(tmp_path / "a.stl", settings={"solid": True})
    assert trimesh.load(tmp_path / "a.stl").volume == pytest.approx(2.0)


def test_any_frame_can_be_joined(tmp_path: Path) -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (frames (for/list ((i (iota 3))) (call "cube" :scale (vector (+ 1 i) 1 1))))))'
    )
    for frame in range(3):
        scene.export(tmp_path / "a.stl", frame=frame, settings={"solid": True})
        assert trimesh.load(tmp_path / "a.stl").volume == pytest.approx(frame + 1.0)
    scene.export(tmp_path / "a.glb", settings={"solid": True})
    assert trimesh.load(tmp_path / "a.glb").geometry


def test_nothing_solid_is_an_error(tmp_path: Path) -> None:
    flat = sl.evaluate('(bind "it" (lambda () (call "cube" :scale [1 0 1])))')
    with pytest.raises(SceneError, match="nothing with a volume"):
        flat.export(tmp_path / "a.stl", settings={"solid": True})


def test_segments_and_tolerance_decide_on_triangles(tmp_path: Path) -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (union (call "sphere") (transform (call "sphere") (@ (translate [9 0 0]) (scale .01))))))'
    )
    faces = {}
    for name, settings in (("few", {"segments": 12}), ("many", {"segments": 96}), ("by-size", {"tolerance": 0.002})):
        scene.export(tmp_path / f"{name}.stl", settings=settings)
        faces[name] = trimesh.load(tmp_path / f"{name}.stl")
    assert len(faces["few"].faces) < len(faces["by-size"].faces) < len(faces["many"].faces)
    large, small = sorted(faces["by-size"].split(), key=lambda body: -body.volume)
    assert len(large.faces) > 10 * len(small.faces)
    assert np.abs(np.linalg.norm(large.triangles_center, axis=1) - 1.0).max() < 0.004
    with pytest.raises(SceneError, match="must be 3 or more"):
        scene.export(tmp_path / "x.stl", settings={"segments": 2})


def faces_of(scene: sl.Scene, path: Path, **settings: Any) -> int:
    scene.export(path, settings=settings)
    return len(trimesh.load(path, force="mesh", process=False).faces)


BALL = '(bind "it" (lambda () (call "sphere" :radius 10)))'


@pytest.mark.parametrize(
    ("ending", "text", "same", "more"),
    [
        ("stl", ".1mm", 0.1, {}),
        ("stl", "100 um", 0.1, {}),
        ("stl", ".01 in", 0.254, {}),
        ("3mf", "1mm", 0.1, {"unit": "centimeter"}),
        ("3mf", ".1", 0.1, {"unit": "centimeter"}),
        ("glb", "5cm", 0.05, {}),
        ("stl", "2px", 20 * 2 / 1000, {}),
        ("stl", "1PX@200", 0.1, {}),
    ],
)
def test_a_tolerance_is_a_length_or_pixels(
    tmp_path: Path, ending: str, text: str, same: float, more: dict[str, Any]
) -> None:
    scene = sl.evaluate(BALL)
    given, wanted = (faces_of(scene, tmp_path / f"a.{ending}", tolerance=value, **more) for value in (text, same))
    assert given == wanted
    assert given != faces_of(scene, tmp_path / f"a.{ending}", tolerance=same * 3, **more)


@pytest.mark.parametrize("value", ["-1", "1 px@0", "1mm@100", "3 furlongs", "px", "", "nan", -0.5, float("inf"), True])
def test_other_tolerances_are_errors(tmp_path: Path, value: Any) -> None:
    with pytest.raises(SceneError, match="`--tolerance` must be a number of at least 0") as caught:
        sl.evaluate(BALL).export(tmp_path / "a.stl", settings={"tolerance": value})
    assert "1px@1080" in caught.value.hint


@pytest.mark.parametrize("ending", ["stl", "glb", "usdc"])
def test_a_tolerance_reaches_merged_parts(tmp_path: Path, ending: str) -> None:
    """A large and a small ball in one part, which is there at two scales."""
    scene = sl.evaluate(
        '(bind "pair" (lambda () (union (call "sphere") (transform (call "sphere" :radius .01) (translate [3 0 0])))))'
        '(bind "it" (lambda () (union (call "pair") (transform (call "pair") (@ (translate [0 9 0]) (scale .1))))))'
    )

    def count(tolerance: float, depth: int | None) -> int:
        path = tmp_path / f"a.{ending}"
        scene.export(path, settings={"tolerance": tolerance, "depth": depth})
        if ending == "usdc":
            usd, geom = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
            stage = usd.Stage.Open(str(path))
            prims = usd.PrimRange(stage.GetPseudoRoot(), usd.TraverseInstanceProxies())
            return sum(len(geom.Mesh(prim).GetFaceVertexCountsAttr().Get()) for prim in prims if prim.IsA(geom.Mesh))
        return len(trimesh.load(path, force="mesh", process=False).faces)

    fine, coarse = count(0.0005, 1), count(0.02, 1)
    assert coarse * 5 < fine
    if ending == "glb":  # which shares meshes, merged or not
        assert count(0.0005, None) == fine


def test_a_tolerance_holds_for_the_largest_copy_in_a_body(tmp_path: Path) -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (union (call "cube") (transform (call "sphere" :radius .01) (scale 100)))))'
    )
    scene.export(tmp_path / "a.stl", settings={"solid": True, "tolerance": 0.001})
    mesh = trimesh.load(tmp_path / "a.stl")
    assert np.linalg.norm(mesh.triangles_center, axis=1).min() > 1.0 - 0.001 - 1e-6


def test_a_tolerance_that_needs_too_many_triangles_is_an_error(tmp_path: Path) -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (for/union ((i (iota 1000))) (transform (call "sphere") (translate (vector i 0 0))))))'
    )
    for settings in ({"tolerance": 1e-9}, {"tolerance": 1e-9, "depth": 0}):
        with pytest.raises(LimitError, match="24,000,000 vertices"):
            scene.export(tmp_path / "a.stl", settings=settings)


def measured(expression: str) -> float:
    return sl.evaluate(f'(bind "it" (lambda () {expression}))').measure().volume


def test_a_twist_to_the_left_is_the_mirror_image_of_one_to_the_right() -> None:
    """The sides between layers are split along their shorter diagonals."""
    left, right = (measured(f"(extrude (rectangle 10 10) 20 :twist (deg {angle}) :slices 8)") for angle in (90, -90))
    assert left == pytest.approx(right, rel=1e-9)
    assert left == pytest.approx(2117.25, rel=1e-5)  # as OpenSCAD makes it
    assert measured("(extrude (rectangle 2 2) 3 :twist pi :taper 0 :slices 64)") == pytest.approx(4, rel=0.02)


def test_hulls_and_sums_of_profiles() -> None:
    ring = "(profile-difference (rectangle 6 6) (rectangle 2 2))"
    assert measured(f"(extrude (profile-hull {ring}) 1)") == pytest.approx(36)
    assert measured(f"(extrude (profile-minkowski {ring} (rectangle 1 1)) 1)") == pytest.approx(49 - 1)
    assert measured("(extrude (offset-profile [[0 0] [9 0] [1 1]] 1 :join :miter :limit 100) 1)") > 40


# --- drawings --------------------------------------------------------------------------------------------------------


def _area(path: Path) -> float:
    """The area that the path of a drawing fills, by its even-odd rule."""
    import re

    from manifold3d import CrossSection, FillRule

    (data,) = re.findall(r' d="([^"]*)"', path.read_text())
    contours = [
        np.array([list(map(float, point.split())) for point in part.strip("MZ").split("L")])
        for part in re.findall(r"M[^Z]*Z", data)
    ]
    return float(CrossSection(contours, FillRule.EvenOdd).area())


def test_sections_have_the_areas_of_cuts(tmp_path: Path) -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (difference (call "cube" :scale [2 4 6]) (call "cube" :scale [1 1 9]))))'
    )
    for plane, area in (("x=0", 6 * 4 - 6 * 1), ("x=.75", 24), ("y=0", 2 * 6 - 6), ("y=1", 12), ("z=-2.5", 8 - 1)):
        scene.export(tmp_path / "a.svg", settings={"section": plane})
        assert _area(tmp_path / "a.svg") == pytest.approx(area, rel=1e-5)


@pytest.mark.parametrize(("side", "area", "size"), [
    ("front", 8.0 - 1.0, 'width="2mm" height="4mm"'), ("top", 12.0, 'width="2mm" height="6mm"'),
    ("right", 24.0, 'width="6mm" height="4mm"'),
])  # fmt: skip
def test_silhouettes_are_seen_from_a_side(tmp_path: Path, side: str, area: float, size: str) -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (difference (call "cube" :scale [2 4 6]) (call "cube" :scale [1 1 9]))))'
    )
    scene.export(tmp_path / "a.svg", settings={"side": side})
    assert _area(tmp_path / "a.svg") == pytest.approx(area, rel=1e-5)
    assert size in (tmp_path / "a.svg").read_text()


def test_drawings_are_the_right_way_up(tmp_path: Path) -> None:
    scene = sl.evaluate('(bind "it" (lambda () (extrude [[0 0] [2 0] [2 1] [1 1] [1 3] [0 3]] 1)))')
    scene.export(tmp_path / "a.svg")
    text = (tmp_path / "a.svg").read_text()
    assert 'viewBox="0 0 2 3"' in text
    assert "1 0" in text  # the top right corner of the upright is above
    assert "2 0" not in text


def test_planes_that_are_wrong_or_meet_nothing_are_told(thing: sl.Scene, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="`w=2` is no section"):
        thing.export(tmp_path / "a.svg", settings={"section": "w=2"})
    with pytest.raises(SceneError, match="the plane y=9 meets nothing"):
        thing.export(tmp_path / "a.svg", settings={"section": "y=9"})
