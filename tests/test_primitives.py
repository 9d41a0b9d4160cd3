"""The contract that every primitive keeps, in its own methods and in every backend; a package's pyramid too."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib import invalidate_caches
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from later import later
from support import evaluate

from scenelang.backends.base import BackendOptions, find
from scenelang.backends.labels.ground_truth import Truth, boxes_in, truth_of
from scenelang.backends.minecraft.filling import filled
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.draft import draw
from scenelang.backends.pictures.film import PictureOptions
from scenelang.backends.pictures.mitsuba import MitsubaPainter
from scenelang.backends.pictures.stage import Shot, Stage, staging_of, still, unit_size
from scenelang.backends.surfaces.assets import AssetFiles
from scenelang.backends.surfaces.convex import bodies_of
from scenelang.backends.viewer.packet import instances_of
from scenelang.files.scene_json import read_scene, write_scene
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.inspection.difference import compare_frames, compared_frame
from scenelang.interpreter.scene import pose, primitives
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives.base import Primitive
from scenelang.interpreter.scene.primitives.mesh import (
    areas_of,
    first_hits,
    posed,
    sample_surface,
    triangle_normals,
    volume_of,
)
from scenelang.interpreter.values.values import IDENTITY, Embedding, Matrix, Pair, Vector
from scenelang.reference.primer import attribute_doc, attributes_of, description

trimesh = later("trimesh")

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A primitive to be tested. ``other``: one attribute with another value."""

    name: str
    word: str
    given: dict[str, Any] = field(default_factory=dict)
    other: tuple[str, Any] = ("", None)

    def __str__(self) -> str:
        return self.name


SIZE = Vector((1.0, 1.5, 0.7))
P0, P1 = Vector((0.2, -0.4, 0.1)), Vector((0.9, 0.8, 0.4))
CASES = [
    Case("cube", "cube", {"scale": SIZE}, ("scale", 2.0)),
    Case("sphere", "sphere", {"radius": 0.8}, ("radius", 0.9)),
    Case("cylinder", "cylinder", {"radius": 0.4, "p0": P0, "p1": P1}, ("radius", 0.6)),
    Case("cone", "cone", {"radius": 0.6, "p0": P0, "p1": P1}, ("radius", 0.8)),
    Case("capsule", "capsule", {"radius": 0.4, "p0": P0, "p1": P1}, ("radius", 0.5)),
    Case("capsule of one point", "capsule", {"radius": 0.6, "p0": P0, "p1": P0}, ("radius", 0.7)),
    Case("torus", "torus", {"radius": 0.8, "tube": 0.2}, ("tube", 0.3)),
    Case("torus without a hole", "torus", {"radius": 0.5, "tube": 0.6}, ("tube", 0.8)),
    Case("rounded cube", "rounded-cube", {"scale": SIZE, "radius": 0.2}, ("radius", 0.3)),
    Case("rounded cube, quite round", "rounded-cube", {"scale": SIZE, "radius": 9.0}, ("radius", 0.1)),
    Case("semantic", "moai", {"scale": SIZE}, ("scale", 2.0)),
    Case("mesh file", "mesh"),
    Case("block", "set-cuboid", {"block-type": "stone", "scale": Vector((2.0, 3.0, 1.0))}, ("scale", 2.0)),
    Case("pyramid", "pyramid", {"base": 1.2, "height": 0.9}, ("height", 1.4)),
]
BLOCK = next(case for case in CASES if case.word == "set-cuboid")
EXACT = [case for case in CASES if case is not BLOCK]  # blocks stand in whole cells
POSE = pose.compose(
    pose.translation(0.3, 1.1, -0.2),
    pose.compose(
        pose.rotation(0.7, (1.0, 0.4, 0.2), (0.0, 0.0, 0.0)), Matrix((1.3, 0.3, 0, 0, 0, 0.8, 0, 0, 0, 0.2, 1, 0))
    ),
)


@pytest.fixture(scope="module", autouse=True)
def _package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The package with the pyramid, installed as pip would."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "pyramids.py").write_text((Path(__file__).parent / "pyramids.py").read_text("utf-8"), "utf-8")
    info = folder / "pyramids-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: pyramids\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[scenelang.primitives]\npyramid = pyramids:Pyramid\nbroken = pyramids:Nothing\n"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        invalidate_caches()
        primitives.clear_package_cache()
        yield
    primitives.clear_package_cache()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the mesh of the asset: an octahedron, uneven."""
    folder = tmp_path_factory.mktemp("meshes")
    mesh = trimesh.creation.icosahedron()
    mesh.vertices *= [1.0, 0.6, 0.8]
    mesh.export(folder / "gem.ply")
    return folder


class Made:
    """A case's primitive, alone and in scenes."""

    def __init__(self, case: Case, folder: Path) -> None:
        self.case = case
        self.given = dict(case.given)
        self.asset = None
        if case.word == "mesh":
            self.asset = AssetFiles(folder, folder, False).measure("gem.ply")
            self.given["file"] = self.asset.path
        self.shape: Primitive = primitives.shape_of(case.word, self.given, self.asset)

    def entity(self, **more: Any) -> Entity:
        given = {**self.given, **more}
        return Entity(
            self.case.word, Embedding(attributes=given), (), primitives.shape_of(self.case.word, given, self.asset)
        )

    def scene(self, at: Matrix = POSE, **more: Any) -> Scene:
        root = Entity("scene", Embedding(), (Pair(self.entity(**more), at),))
        return Scene("scene", [root], False)

    def under(self, at: Matrix) -> tuple[Floats, Floats]:
        """Dense points of the posed surface, and the pose (3, 4)."""
        matrix = np.array(at).reshape(3, 4)
        points, _ = self.shape.sample(20_000, np.random.default_rng(1))
        return points @ matrix[:, :3].T + matrix[:, 3], matrix


@pytest.fixture
def made(request: pytest.FixtureRequest, folder: Path) -> Made:
    return Made(request.param, folder)


every_one = pytest.mark.parametrize("made", CASES, indirect=True, ids=str)
every_exact = pytest.mark.parametrize("made", EXACT, indirect=True, ids=str)


def rays(shape: Primitive, count: int, seed: int) -> tuple[Floats, Floats]:
    """Rays from all round towards the primitive."""
    chance = np.random.default_rng(seed)
    box = np.array(shape.box_under(IDENTITY))
    middle, size = (box[:3] + box[3:]) / 2, np.linalg.norm(box[3:] - box[:3])
    away = chance.normal(size=(count, 3))
    origins = middle + away / np.linalg.norm(away, axis=1, keepdims=True) * size
    return origins, middle + chance.uniform(-0.5, 0.5, (count, 3)) * (box[3:] - box[:3]) - origins


# --- the primitive itself ---------------------------------------------------------------------------------------------


@every_one
def test_boxes_are_those_of_the_samples_under_any_pose(made: Made) -> None:
    chance = np.random.default_rng(2)
    mesh = made.shape.triangulate(1e-4 * made.shape.extent)
    for _ in range(8):
        at = Matrix(chance.normal(size=12).tolist())
        points, matrix = made.under(at)
        corners = mesh.vertices @ matrix[:, :3].T + matrix[:, 3]
        box = np.array(made.shape.box_under(at))
        assert (points >= box[:3] - 1e-9).all()
        assert (points <= box[3:] + 1e-9).all()
        assert [*corners.min(axis=0), *corners.max(axis=0)] == pytest.approx(box, abs=3e-3 * made.shape.extent)


@every_one
@pytest.mark.parametrize("tolerance", [0.3, 0.05, 0.01])
@pytest.mark.sampled(3)
def test_boxes_hold_for_meshes_of_every_level_of_detail(made: Made, tolerance: float) -> None:
    """Under random affine maps no vertex is outside, and every side is as near as the tolerance says."""
    chance = np.random.default_rng(5)
    allowed = tolerance * made.shape.extent
    mesh = made.shape.triangulate(allowed)
    for _ in range(8):
        at = Matrix(chance.normal(size=12).tolist())
        _, matrix = made.under(at)
        corners = mesh.vertices @ matrix[:, :3].T + matrix[:, 3]
        box = np.array(made.shape.box_under(at))
        gaps = np.concatenate([corners.min(axis=0) - box[:3], box[3:] - corners.max(axis=0)])
        assert (gaps >= -1e-9).all()
        assert (gaps <= np.tile(np.linalg.norm(matrix[:, :3], axis=1), 2) * allowed + 1e-9).all()


@every_one
@pytest.mark.parametrize("tolerance", [0.03, 0.003])
def test_meshes_are_within_their_tolerance(made: Made, tolerance: float) -> None:
    """So far in from the faces is inside, and so far out is outside."""
    allowed = tolerance * made.shape.extent
    mesh = made.shape.triangulate(allowed).faceted()
    weights = np.random.default_rng(6).dirichlet([1.0, 1.0, 1.0], (len(mesh.faces), 8))
    points = np.einsum("fki,fij->fkj", weights, mesh.corners).reshape(-1, 3)
    step = 1.0001 * allowed * np.repeat(triangle_normals(mesh.corners), 8, axis=0)
    assert not made.shape.contains(points + step).any()
    assert made.shape.contains(points - step).mean() > 0.9  # all but what is close to an edge


@every_one
def test_meshes_are_closed_and_their_normals_look_out(made: Made) -> None:
    mesh = made.shape.triangulate(1e-2 * made.shape.extent).faceted()
    _, place = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    faces = place.reshape(-1)[mesh.faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    edges = Counter((int(a), int(b)) for k in range(3) for a, b in zip(faces[:, k], faces[:, (k + 1) % 3]))
    assert all(edges[b, a] == count for (a, b), count in edges.items())
    assert np.linalg.norm(mesh.shading, axis=1) == pytest.approx(1.0)
    across = np.cross(mesh.corners[:, 1] - mesh.corners[:, 0], mesh.corners[:, 2] - mesh.corners[:, 0])
    assert (np.einsum("ni,ni->n", across, mesh.shading[mesh.faces].mean(axis=1)) > 0).all()


@every_one
@pytest.mark.sampled(4)
def test_rays_meet_what_they_meet_of_the_mesh(made: Made) -> None:
    shape, size = made.shape, made.shape.extent
    origins, directions = rays(shape, 400, 3)
    t, normals = shape.intersect(origins, directions)
    corners = shape.triangulate(5e-4 * size).corners
    expected, which = first_hits(corners, origins, directions)
    assert (np.isfinite(t) == np.isfinite(expected)).mean() > 0.99  # one may graze the surface, or pass a facet
    both = np.isfinite(t) & np.isfinite(expected)
    assert both.sum() > 50
    length = np.linalg.norm(directions, axis=1)
    error = np.abs(t[both] - expected[both]) * length[both]
    assert np.quantile(error, 0.97) < 0.01 * size
    assert np.linalg.norm(normals[both], axis=1) == pytest.approx(1.0)
    assert (np.einsum("ni,ni->n", normals, directions)[both] < 1e-6).all()  # the rays begin outside
    assert which[both].min() >= 0
    points = (origins + t[:, None] * directions)[both]
    assert shape.contains(points - 1e-6 * size * normals[both]).mean() > 0.995
    assert not shape.contains(points + 1e-6 * size * normals[both]).any()


@every_one
def test_rays_from_inside_meet_the_surface(made: Made) -> None:
    points, normals = made.shape.sample(200, np.random.default_rng(4))
    t, _ = made.shape.intersect(points - 1e-3 * made.shape.extent * normals, normals)
    assert t == pytest.approx(1e-3 * made.shape.extent, rel=1e-4)


@every_one
@pytest.mark.sampled(2)
def test_samples_lie_evenly_on_the_surface(made: Made) -> None:
    shape, size, count = made.shape, made.shape.extent, 40_000
    points, normals = shape.sample(count, np.random.default_rng(5))
    assert points.shape == normals.shape == (count, 3)
    assert shape.contains(points - 1e-7 * size * normals).mean() > 0.999
    assert shape.contains(points + 1e-7 * size * normals).mean() < 0.001
    others, _ = sample_surface(shape.triangulate(2e-4 * size), count, np.random.default_rng(8))
    for axis in range(3):
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            edge = np.quantile(others[:, axis], share) + 1e-6 * size  # many may lie in one plane
            assert (points[:, axis] < edge).mean() == pytest.approx((others[:, axis] < edge).mean(), abs=0.015)


@every_one
@pytest.mark.sampled(2)
def test_volume_and_area_are_those_of_the_mesh(made: Made) -> None:
    shape = made.shape
    corners = shape.triangulate(1e-4 * shape.extent).corners
    assert shape.volume() == pytest.approx(volume_of(corners), rel=5e-3)
    assert shape.area() == pytest.approx(areas_of(corners).sum(), rel=5e-3)
    box = np.array(shape.box_under(IDENTITY))
    points = np.random.default_rng(6).uniform(box[:3], box[3:], (60_000, 3))
    assert shape.contains(points).mean() * np.prod(box[3:] - box[:3]) == pytest.approx(shape.volume(), rel=0.04)


@every_one
def test_what_is_said_of_it_is_true(made: Made) -> None:
    word, (name, value) = made.case.word, made.case.other
    cls = primitives.class_of(word)
    assert cls.doc
    assert set(made.given) <= set(attributes_of(word))
    assert all(attribute_doc(word, each) for each in attributes_of(word))
    assert made.shape.key == primitives.shape_of(word, {**made.given, "color": Vector((1.0, 0.0, 0.0))}, made.asset).key
    assert not made.shape.is_flat
    if name:
        changed = primitives.shape_of(word, {**made.given, name: value}, made.asset)
        assert changed != made.shape
        assert (changed.volume(), changed.box_under(IDENTITY)) != (made.shape.volume(), made.shape.box_under(IDENTITY))
        with pytest.raises(SceneError, match=rf"the attribute `:{name}` of"):
            primitives.shape_of(word, {name: "wide"}, made.asset)
    if primitives.is_word(word):
        assert description(f'"{word}"')


def test_a_torus_is_met_to_ten_digits() -> None:
    for ring in (0.05, 0.4, 0.5, 0.6, 0.95, 0.999):
        shape = primitives.shape_of("torus", {"radius": ring, "tube": 1.0 - ring})
        origins, directions = rays(shape, 4000, 7)
        t, _ = shape.intersect(origins, directions)
        points = (origins + t[:, None] * directions)[np.isfinite(t)]
        away = np.hypot(np.hypot(points[:, 0], points[:, 2]) - ring, points[:, 1])
        assert len(points) > 40
        assert np.abs(away - (1.0 - ring)).max() < 1e-10


def test_deleted_blocks_say_that_they_have_no_geometry() -> None:
    shape = primitives.shape_of("delete-blocks", {"scale": Vector((2.0, 1.0, 1.0))})
    assert not shape.has_geometry
    assert shape.placed() is None
    assert not len(shape.triangulate(0.1).faces)
    assert shape.volume() == shape.area() == 0.0


# --- pictures, maps ---------------------------------------------------------------------------------------------------


VIEW, WIDTH, HEIGHT = Viewpoint(azimuth=30, elevation=25), 96, 72


def staged(scene: Scene) -> tuple[Stage, Any]:
    staging = staging_of(scene, [0], 10_000)
    return staging.stage(still(scene, VIEW, 0, WIDTH, HEIGHT)), staging


def seen_by(stage: Stage, scene: Scene) -> Floats:
    """The depth (H, W) at which the primitive's own rays see it, infinity elsewhere; blocks as the cubes that they are."""
    camera = stage.camera
    row, column = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
    (fx, fy), (cx, cy) = camera.focal, camera.principal
    directions = (
        camera.forward
        + ((column + 0.5 - cx) / fx)[:, None] * camera.right
        - ((row + 0.5 - cy) / fy)[:, None] * camera.up
    )
    depth = np.full(WIDTH * HEIGHT, np.inf)
    frame = flatten_entity(scene.root)
    for i in range(len(frame)):
        shape = frame.primitives[frame.index[i]].shape
        assert shape is not None
        inverse = np.linalg.inv(frame.matrices[i][:, :3])
        eye = camera.eye / stage.scale + stage.center
        origins = np.tile((eye - frame.matrices[i][:, 3]) @ inverse.T, (len(depth), 1))
        t, _ = shape.intersect(origins, directions @ inverse.T)
        depth = np.minimum(depth, t)
    return depth.reshape(HEIGHT, WIDTH)


def pose_of(made: Made) -> Matrix:
    return pose.translation(2.0, 1.0, -1.0) if made.shape.is_block else POSE


@every_one
def test_draft_pictures_show_its_silhouette(made: Made) -> None:
    scene = made.scene(pose_of(made))
    stage, _ = staged(scene)
    depth = seen_by(stage, scene)
    drawn = draw(stage, shaded=False)
    # a draft's first sample lies a quarter of a pixel from the middle
    assert ((drawn.ids >= 0) == np.isfinite(depth)).mean() > 0.98
    assert abs((drawn.ids >= 0).sum() / np.isfinite(depth).sum() - 1) < 0.03


@every_one
@pytest.mark.sampled(2)
def test_final_pictures_show_its_silhouette_depth_and_normals(made: Made) -> None:
    scene = made.scene(pose_of(made))
    stage, staging = staged(scene)
    painter = MitsubaPainter(staging, PictureOptions(width=WIDTH, height=HEIGHT, settings={"variant": "scalar"}), 1)
    loaded = painter.mitsuba.load_dict({"type": "scene", **painter.shapes_of(0, stage)})
    expected = seen_by(stage, scene)
    assert_meets(painter.mitsuba, loaded, stage.camera, expected * stage.scale, 0.01)


def assert_meets(mi: Any, loaded: Any, camera: Any, expected: Floats, room: float) -> None:
    """Every third pixel's ray meets the loaded scene where it is expected to."""
    (fx, fy), (cx, cy) = camera.focal, camera.principal
    hits, misses, errors = 0, 0, []
    for row in range(0, HEIGHT, 3):
        for column in range(0, WIDTH, 3):
            direction = camera.forward + (column + 0.5 - cx) / fx * camera.right - (row + 0.5 - cy) / fy * camera.up
            hit = loaded.ray_intersect(mi.Ray3f(mi.Point3f(*camera.eye), mi.Vector3f(*direction)))
            misses += hit.is_valid() != np.isfinite(expected[row, column])
            if hit.is_valid() and np.isfinite(expected[row, column]):
                hits += 1
                errors.append(abs(hit.t - expected[row, column]))
    assert hits > 25
    assert misses <= 0.01 * hits + 2
    assert np.quantile(errors, 0.95) < room


def true(scene: Scene) -> Truth:
    shot = Shot(0, still(scene, VIEW, 0, WIDTH, HEIGHT).camera)
    return truth_of(scene, shot, 10_000, *unit_size(scene))


@every_exact
def test_maps_say_its_depth_normals_and_box(made: Made) -> None:
    scene = made.scene()
    truth, (stage, _) = true(scene), staged(scene)
    expected = seen_by(stage, scene)
    both = truth.seen & np.isfinite(expected)
    assert (truth.seen == np.isfinite(expected)).mean() > 0.999
    assert truth.depth[both] == pytest.approx(expected[both], rel=1e-6)
    toward = truth.position - truth.camera.eye
    assert np.linalg.norm(truth.normal[both], axis=1) == pytest.approx(1.0)
    assert (np.einsum("ni,ni->n", truth.normal[both], toward[both]) <= 1e-9).all()
    pixels, _ = truth.camera.project(made.under(POSE)[0])
    full = boxes_in(truth).full[1]
    assert full == pytest.approx([*pixels.min(axis=0), *pixels.max(axis=0)], abs=0.7)
    assert (full[:2] <= pixels.min(axis=0) + 1e-6).all()
    assert (full[2:] >= pixels.max(axis=0) - 1e-6).all()


# --- files ------------------------------------------------------------------------------------------------------------


def written(made: Made, path: Path, scene: Scene | None = None) -> Path:
    backend = {".glb": "gltf", ".obj": "obj", ".ply": "ply", ".stl": "stl", ".usda": "usd", ".xml": "mitsuba-xml"}
    find(backend[path.suffix]).run(scene or made.scene(pose_of(made)), path, BackendOptions())
    return path


def size_of(made: Made) -> tuple[Floats, float, float]:
    """The box (2, 3) of the posed primitive, its volume, and how far a mesh of 64 sides may lie from it."""
    at = pose_of(made)
    linear = np.array(at).reshape(3, 4)[:, :3]
    box = np.array(made.shape.box_under(at)).reshape(2, 3)
    return box, made.shape.volume() * abs(float(np.linalg.det(linear))), 6e-3 * made.shape.extent


@every_one
@pytest.mark.parametrize("ending", [".glb", ".obj", ".ply", ".stl"])
def test_mesh_files_hold_it(made: Made, ending: str, tmp_path: Path) -> None:
    found = trimesh.load(written(made, tmp_path / f"a{ending}"), force="mesh")
    box, volume, room = size_of(made)
    assert found.bounds == pytest.approx(box, abs=room)
    assert volume_of(np.asarray(found.triangles)) == pytest.approx(volume, rel=0.02)


@pytest.mark.parametrize("made", [case for case in CASES if case.name == "torus"], indirect=True, ids=str)
def test_meshes_of_gltf_files_say_what_they_stand_for(made: Made, tmp_path: Path) -> None:
    data = written(made, tmp_path / "a.glb").read_bytes()
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    assert document["meshes"][0]["extras"] == {"form": "torus", "ratios": [pytest.approx(0.8)]}


@every_one
def test_usd_files_hold_it(made: Made, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(written(made, tmp_path / "a.usda")))
    drawn = [p for p in stage.Traverse(Usd.TraverseInstanceProxies()) if UsdGeom.Gprim(p) and p.GetName() == "geometry"]
    assert drawn
    box, volume, room = size_of(made)
    low, high, inside = np.full(3, np.inf), np.full(3, -np.inf), 0.0
    for prim in drawn:
        turn = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)).T[:3]
        corners = usd_corners(prim) @ turn[:, :3].T + turn[:, 3]
        low, high = np.minimum(low, corners.min(axis=(0, 1))), np.maximum(high, corners.max(axis=(0, 1)))
        inside += abs(volume_of(corners))
    assert np.stack([low, high]) == pytest.approx(box, abs=room)
    assert inside == pytest.approx(volume, rel=0.02)


def usd_corners(prim: Any) -> Floats:
    """The triangles (F, 3, 3) of a prim in its own frame: of a mesh, or of USD's own capsule as its attributes say."""
    if prim.GetTypeName() == "Mesh":
        points = np.array(prim.GetAttribute("points").Get(), float)
        return points[np.array(prim.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3)]
    assert prim.GetTypeName() == "Capsule"
    assert prim.GetAttribute("axis").Get() == "Y"
    half, radius = prim.GetAttribute("height").Get() / 2, prim.GetAttribute("radius").Get()
    ends = {"p0": Vector((0.0, -half, 0.0)), "p1": Vector((0.0, half, 0.0))}
    return primitives.shape_of("capsule", {"radius": radius, **ends}).triangulate(1e-3).corners


@every_one
def test_mitsuba_files_hold_it(made: Made, tmp_path: Path) -> None:
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    scene = made.scene(pose_of(made))
    loaded = mi.load_file(str(written(made, tmp_path / "a.xml", scene)))
    camera = still(scene, VIEW, 0, WIDTH, HEIGHT).camera
    expected = seen_by(staged(scene)[0], scene)
    (fx, fy), (cx, cy) = camera.focal, camera.principal
    errors = []
    for row, column in np.argwhere(np.isfinite(expected))[::5].tolist():
        direction = camera.forward + (column + 0.5 - cx) / fx * camera.right - (row + 0.5 - cy) / fy * camera.up
        hit = loaded.ray_intersect(mi.Ray3f(mi.Point3f(*camera.eye), mi.Vector3f(*direction)))
        errors.append(abs(hit.t - expected[row, column]) if hit.is_valid() else math.inf)
    assert len(errors) > 50
    assert np.quantile(errors, 0.95) < 0.02 * made.shape.extent


@every_one
def test_scene_files_give_it_back(made: Made, tmp_path: Path) -> None:
    scene = made.scene()
    write_scene(scene, tmp_path / "a.json")
    back = read_scene(tmp_path / "a.json", allow_outside=True)
    (again,) = [entity.shape for entity in descendants(back.root) if entity.shape is not None]
    assert again == made.shape
    assert entity_box(back.root) == entity_box(scene.root)


# --- blocks, Gaussians, the viewer, comparing -------------------------------------------------------------------------


@every_exact
def test_cells_are_filled_where_it_is(made: Made) -> None:
    pytest.importorskip("scipy")
    found = filled(made.scene().root, 40)
    _, volume, _ = size_of(made)
    cells = np.count_nonzero(found.cells) * found.edge**3
    # the surface of a mesh fills every cell that it goes through, half a cell more than there is
    shell = 0.0 if made.shape.placed() is not None else 0.6 * found.edge * made.shape.area() * 1.2
    assert volume * 0.97 <= cells <= volume * 1.03 + shell


@every_exact
def test_gaussians_lie_on_it(made: Made) -> None:
    pytest.importorskip("torch")
    from scenelang.backends.neural.splats.initial import cover_of

    cover = cover_of(made.entity(), 2_000)
    assert cover is not None
    places = cover.gaussians.means.numpy()
    assert cover.area == pytest.approx(made.shape.area(), rel=0.01)
    near = 1e-6 * made.shape.extent
    on = made.shape.contains(places - near * cover.normals) & ~made.shape.contains(places + near * cover.normals)
    assert on.mean() > 0.89  # some lie inside, so that nothing shines through
    assert made.shape.contains(places - near * cover.normals).mean() > 0.999


@every_exact
def test_the_viewer_gets_its_mesh(made: Made) -> None:
    scene = made.scene()
    nodes = {id(entity): i for i, entity in enumerate(descendants(scene.root))}
    found = instances_of(scene, np.zeros(3), 1.0, nodes)
    geometry = found.geometries[int(found.columns["primitiveGeometry"][0])]
    at = found.columns["rowPose"].reshape(-1, 3, 4)[0]
    corners = geometry.positions.reshape(-1, 3)[geometry.indices.reshape(-1, 3)] @ at[:, :3].T + at[:, 3]
    box, volume, room = size_of(made)
    assert np.stack([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))]) == pytest.approx(box, abs=room)
    assert abs(volume_of(corners.astype(np.float64))) == pytest.approx(volume, rel=0.02)


@every_one
def test_scenes_with_it_are_compared(made: Made) -> None:
    far = (Entity("cube", Embedding(), (), primitives.shape_of("cube", {})), pose.translation(9.0, 0.0, 0.0))

    def sheet(entity: Entity, at: Matrix) -> Any:
        return compared_frame(flatten_entity(Entity("scene", Embedding(), (Pair(entity, at), Pair(*far)))))

    plain = sheet(made.entity(), pose_of(made))
    assert compare_frames(plain, sheet(made.entity(), pose_of(made))).equal
    moved = pose.compose(pose.translation(1.0, 0.0, 0.0), pose_of(made))
    assert not compare_frames(plain, sheet(made.entity(), moved)).equal
    name, value = made.case.other
    if name:
        assert not compare_frames(plain, sheet(made.entity(**{name: value}), pose_of(made))).equal


@every_exact
def test_the_lint_knows_how_far_it_reaches(made: Made) -> None:
    bodies = bodies_of(made.scene().root)
    assert len(bodies) == 1
    low, high = bodies.boxes
    box = np.array(made.shape.box_under(POSE))
    if made.shape.placed() is not None:
        assert np.concatenate([low[0], high[0]]) == pytest.approx(box)
    else:  # the box of a mesh, posed
        assert (low[0] <= box[:3] + 1e-9).all()
        assert (high[0] >= box[3:] - 1e-9).all()


# --- programs ---------------------------------------------------------------------------------------------------------


def test_programs_make_the_new_primitives_and_bind_their_words() -> None:
    body = '(union (call "capsule" :radius .2) (call "torus" :tube .1) (call "rounded-cube" :radius .3))'
    words = [part.car.word for part in evaluate(f'(bind "a" (lambda () {body}))').root.children]
    assert words == ["capsule", "torus", "rounded-cube"]
    own = evaluate('(bind "torus" (lambda () (call "cube")))\n(bind "a" (lambda () (call "torus")))\n(scene "a")').root
    assert [entity.word for entity in descendants(own)] == ["cube", "torus", "a"]


def test_a_package_adds_a_word() -> None:
    scene = evaluate('(bind "a" (lambda () (call "pyramid" :height 3)))')
    assert entity_box(scene.root) == pytest.approx((-0.5, 0.0, -0.5, 0.5, 3.0, 0.5))
    assert "pyramid" in primitives.words()
    assert "a pyramid over a square around the origin" in "\n".join(description('"pyramid"'))
    with pytest.raises(SceneError, match='the primitive "broken"'):
        primitives.find("broken")
    assert primitives.find("moai") is None


def test_posed_copies_of_a_mesh_keep_their_volume() -> None:
    shape = primitives.shape_of("torus", {})
    mirror = np.array([[[-1.0, 0, 0, 1], [0, 2, 0, 2], [0, 0, 1, 3]]])
    mesh = posed(shape.triangulate(1e-3), mirror)
    assert volume_of(mesh.corners) == pytest.approx(2.0 * shape.volume(), rel=1e-2)
