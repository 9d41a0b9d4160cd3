"""What is reported, settled, filmed and exported: commands, the Python API, MJCF, URDF and UsdPhysics."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import scenelang as sl
from scenelang.backends.physics import verdicts
from scenelang.backends.physics.dynamics import TO_MODEL
from scenelang.backends.physics.grouping import bodies_of
from scenelang.backends.physics.verdicts import diagnostics_of
from scenelang.backends.pictures import exhibit
from scenelang.backends.surfaces.marks import Marks
from scenelang.cli.main import main
from scenelang.interpreter.scene.flatten import flatten_entity

mujoco = pytest.importorskip("mujoco")
EXAMPLES = Path(__file__).parents[2] / "examples"
ROOM = """(bind "table"
  (lambda ()
    (union
      (transform (call "cube" :scale [2 .1 1]) (translate [0 .95 0]))
      (for*/union ((x '(-.9 .9)) (z '(-.4 .4)))
        (transform (call "cube" :scale [.1 .9 .1]) (translate [x .45 z]))))))
(bind "vase" (lambda () (call "cylinder" :radius .1 :p1 [0 .4 0])))
(bind "cup" (lambda () (call "cylinder" :radius .06 :p1 [0 .1 0])))
(bind "room"
  (lambda ()
    (union
      (call "table")
      VASE
      (transform (call "cup") (translate [.5 1.2 0])))))
"""
EDGE = ROOM.replace("VASE", '(transform (call "vase") (translate [1.04 1 0]))')
SOUND = ROOM.replace("VASE", '(transform (call "vase") (translate [.5 1 0.2]))').replace("1.2 0", "1 0")
MIXED = """
(bind "lamp" (lambda () (union (call "cylinder" :radius .3 :p1 [0 .1 0]) (call "cone" :radius .1 :p1 [0 1 0])
  (transform (call "sphere" :radius .2) (@ (translate [0 1 0]) (scale [1 .6 1]))))))
(bind "pill" (lambda () (transform (call "capsule" :radius .1 :p1 [.4 0 0] :friction .2) (translate [0 .1 0]))))
(bind "ball" (lambda () (transform (call "sphere" :radius .2 :density "steel") (translate [0 .2 0]))))
(bind "slant" (lambda () (transform (call "cube" :scale .4) (@ (translate [0 .3 0]) (scale [2 1 1]) (rotate .3 [0 0 1])))))
(bind "shelf" (lambda () (union (call "lamp") (transform (call "lamp") (translate [2 0 0])) (call "grass")
  (transform (call "pill") (@ (translate [6 0 0]) (rotate .5 [0 1 0]))) (transform (call "ball") (translate [8 0 0]))
  (transform (call "slant" :mass 3) (translate [10 0 0])) (transform (call "slant" :fixed #t) (translate [12 0 0])))))
"""


def test_a_report() -> None:
    report = sl.evaluate(EDGE).physics()
    kinds = {body.words[-1]: body.kind for body in report.bodies}
    assert kinds == {"table": "rests", "vase": "falls", "cup": "falls"}
    vase, cup = report.bodies[1:]
    assert "0.04 beyond the edge" in vase.why
    assert cup.why == "nothing carries it"
    assert cup.drop == pytest.approx(0.2, abs=1e-3)
    assert not report.stable
    assert json.loads(json.dumps(report.data()))["bodies"][1]["kind"] == "falls"
    assert sl.evaluate(SOUND).physics().stable


def test_what_stands_on_what_falls_goes_with_it() -> None:
    text = """(bind "crate" (lambda () (call "cube")))
    (bind "a" (lambda () (union (call "crate") (transform (call "crate") (translate [.9 1 0]))
      (transform (call "crate") (translate [1.2 2 0])))))"""
    report = sl.evaluate(text).physics(seconds=2.0)
    assert report.bodies[0].kind == "rests"
    assert [body.cause for body in report.bodies] == [None, None, 1]
    (told,) = diagnostics_of(report)
    assert told.message.endswith("beyond the edge of what it stands on; 1 more body goes with it")


def test_settle_keeps_what_rests_and_moves_the_rest() -> None:
    scene = sl.evaluate(EDGE)
    rest = scene.settle()
    assert repr(rest) == "<MovedScene: 2 of 3 bodies moved>"
    before, after = flatten_entity(scene.root).matrices, flatten_entity(rest.scene.root).matrices
    assert np.array_equal(before[:5], after[:5])
    assert after[6, 1, 3] == pytest.approx(1.0, abs=1e-3)
    assert rest.scene.count() == scene.count()
    assert [body.kind for body in rest.scene.physics().bodies] == ["rests"] * 3


def test_a_simulation_is_a_4d_scene() -> None:
    moved = sl.evaluate(EDGE).simulate(seconds=0.5, fps=10, velocities={"cup": (1.0, 0.0, 0.0)})
    assert len(moved.scene.frames) == 6
    x = [flatten_entity(root).matrices[6, 0, 3] for root in moved.scene.frames]
    assert x[0] == pytest.approx(0.5)
    assert x[1] == pytest.approx(0.6, abs=1e-6)
    assert moved.scene.frame(5).bounds is not None


@pytest.mark.parametrize(
    "wrong", [{"seconds": 0.0}, {"seconds": 1e9}, {"metres_per_unit": 0.0}, {"metres_per_unit": float("nan")}]
)
def test_wrong_arguments(wrong: dict[str, Any]) -> None:
    with pytest.raises(sl.SceneError):
        sl.evaluate(SOUND).physics(**wrong)


def test_wrong_velocities() -> None:
    with pytest.raises(sl.SceneError, match="`velocities`: expected a mapping"):
        sl.evaluate(SOUND).simulate(velocities={"cup": (1.0, float("inf"), 0.0)})


# --- commands --------------------------------------------------------------------------------------------------------


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.scene").write_text(EDGE, "utf-8")
    return tmp_path / "room.scene"


def test_check_physics(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "--physics", "--json", "room.scene"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [(each["code"], each["place"]["line"]) for each in found] == [("W633", 7), ("W633", 8)]
    file.write_text("; lint: allow-file body-falls\n" + EDGE, "utf-8")
    assert main(["check", "--physics", "--json", "room.scene"]) == 0
    assert json.loads(capsys.readouterr().out) == []


def test_a_picture_of_what_falls(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The picture itself is drawn as that of ``--geometry`` is; here it is what it shows."""
    shown: list[Marks] = []
    monkeypatch.setattr(exhibit, "save_marked", lambda root, marks, path: shown.append(marks))
    assert main(["check", "--physics", "--picture", "a.png", "-q", "room.scene"]) == 0
    (marks,) = shown
    assert (sorted(marks.subject), sorted(marks.other)) == ([5], [0, 1, 2, 3, 4])  # the vase on the table
    assert marks.points[:, 0].max() == pytest.approx(1.0, abs=1e-3)  # the table's edge
    assert marks.centers == pytest.approx(np.array([[1.04, 1.2, 0.0]]))
    assert [1.04, 1.2, 0.0] in np.round(marks.lines, 6).tolist()[0]  # the plumb line starts at the center of mass
    file.write_text(SOUND, "utf-8")
    assert main(["check", "--physics", "--picture", "b.png", "-q", "room.scene"]) == 0
    assert len(shown) == 1


def test_settle_writes_literals(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["settle", "room.scene", "-o", "out.scene"]) == 0
    assert 'these poses, which are no literals of their own: "vase"' in capsys.readouterr().err
    assert Path("out.scene").read_text("utf-8") == EDGE.replace("[.5 1.2 0]", "[0.5 1 0]")


def test_settle_writes_a_program_where_literals_say_all(file: Path) -> None:
    file.write_text(SOUND.replace("[.5 1 0]", "[.5 1.3 0]"), "utf-8")
    assert main(["settle", "room.scene"]) == 0
    cup = re.search(r'\(call "cup"\) \(translate \[(.*?)\]', Path("room.settled.scene").read_text("utf-8"))
    assert cup is not None
    # the last digits of a simulation differ from one kind of processor to the next
    assert [float(number) for number in cup[1].split()] == pytest.approx([0.5, 1, 0], abs=0.001)
    assert not Path("room.settled.json").exists()


def test_settle_keeps_literals_that_make_other_things_too(file: Path) -> None:
    file.write_text("""(bind "cup" (lambda () (call "cylinder" :radius .06 :p1 [0 .1 0])))
(bind "table" (lambda () (call "cube")))
(define (hung x) (transform (transform (call "cup") (translate [0 .7 0])) (translate [x 0 0])))
(bind "room" (lambda () (union (call "table") (hung 0) (transform (hung 3) (translate [0 .5 0])))))
""", "utf-8")  # fmt: skip
    assert main(["settle", "room.scene"]) == 0
    assert Path("room.settled.json").exists()


def test_settle_writes_a_scene_otherwise(file: Path) -> None:
    assert main(["settle", "room.scene"]) == 0
    assert main(["settle", "room.scene"]) == 0  # its own file may be written again
    assert sl.load("room.settled.json").physics().stable


def test_simulate_writes_scenes_and_films(file: Path) -> None:
    assert main(["simulate", "room.scene", "-o", "out.json", "--seconds", ".2", "--fps", "10"]) == 0
    assert len(sl.load("out.json").frames) == 3
    arguments = ["--seconds", ".2", "--fps", "10", "--size", "32x32", "--velocity", "cup=0,1,0"]
    assert main(["simulate", "room.scene", "-o", "out.gif", *arguments]) == 0
    assert Path("out.gif").read_bytes()[:3] == b"GIF"


@pytest.mark.parametrize(
    "arguments",
    [["simulate", "room.scene", "-o", "a.txt"], ["settle", "room.scene", "-o", "a.txt"],
     ["simulate", "room.scene", "-o", "a.gif", "--velocity", "cup=1,2"],
     ["simulate", "room.scene", "-o", "a.gif", "--velocity", "cup=1,2,nan"],
     ["check", "--physics", "--seconds", "-1", "room.scene"]],
)  # fmt: skip
def test_wrong_usage(file: Path, arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as leaving:  # argparse leaves by itself
        raise SystemExit(main(arguments))
    assert leaving.value.code == 2


def test_the_missing_extra_is_named(file: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert main(["check", "--physics", "room.scene"]) == 1
    assert "pip install 'scenelang[physics]'" in capsys.readouterr().err


# --- exports ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mixed", "chessboard"])
@pytest.mark.sampled(2)
def test_mjcf_loads_with_the_masses_and_the_bounds_of_the_scene(name: str, tmp_path: Path) -> None:
    scene = sl.evaluate(MIXED) if name == "mixed" else sl.load(EXAMPLES / "chessboard.scene")
    bodies = bodies_of(scene.root, 1.0)
    scene.export(tmp_path / "a.mjcf.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.mjcf.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert model.nbody == len(bodies.bodies) + 1
    for number, body in enumerate(bodies.bodies, start=1):
        assert model.body_mass[number] == pytest.approx(body.moments.mass, rel=1e-4)
        assert sorted(model.body_inertia[number]) == pytest.approx(np.linalg.eigvalsh(body.moments.inertia), rel=1e-3)
        assert TO_MODEL.T @ data.xipos[number] == pytest.approx(body.moments.center, abs=1e-4)
        low, high = _bounds(model, data, number)
        # overlaps of a millimetre are cut
        assert low == pytest.approx(body.low, abs=1.1e-3)
        assert high == pytest.approx(body.high, abs=1.1e-3)
    for _ in range(200):
        mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all()


def _bounds(model: Any, data: Any, body: int) -> tuple[np.ndarray, np.ndarray]:
    """The box of a body's geoms in the axes of the scene: of meshes by their vertices."""
    points = []
    for geom in range(model.ngeom):
        if model.geom_bodyid[geom] != body:
            continue
        kind, size = mujoco.mjtGeom(model.geom_type[geom]), model.geom_size[geom]
        rotation, place = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[geom]
            start = model.mesh_vertadr[mesh]
            local = model.mesh_vert[start : start + model.mesh_vertnum[mesh]]
            reach = [local @ rotation.T]
        elif kind in (mujoco.mjtGeom.mjGEOM_ELLIPSOID, mujoco.mjtGeom.mjGEOM_SPHERE):
            half = size if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID else np.full(3, size[0])
            extent = np.linalg.norm(rotation * half, axis=1)
            reach = [np.stack([-extent, extent])]
        elif kind == mujoco.mjtGeom.mjGEOM_BOX:
            extent = np.abs(rotation) @ size
            reach = [np.stack([-extent, extent])]
        else:
            along = np.abs(rotation[:, 2]) * size[1]
            round_ = size[0] * np.sqrt(np.maximum(0, 1 - rotation[:, 2] ** 2))
            extent = along + (size[0] if kind == mujoco.mjtGeom.mjGEOM_CAPSULE else round_)
            reach = [np.stack([-extent, extent])]
        points += [each + place for each in reach]
    found = np.concatenate(points) @ TO_MODEL
    return found.min(axis=0), found.max(axis=0)


def test_urdf_has_the_tree_the_masses_and_the_shapes_of_the_scene(tmp_path: Path) -> None:
    scene = sl.evaluate(MIXED)
    bodies = bodies_of(scene.root, 1.0)
    written = scene.export(tmp_path / "a.urdf")
    robot = ElementTree.parse(tmp_path / "a.urdf").getroot()
    links, joints = robot.findall("link"), robot.findall("joint")
    assert links[0].get("name") == "world"
    assert len(links) == len(joints) + 1 == len(bodies.bodies) + 1
    children = [joint.find("child").get("link") for joint in joints]  # type: ignore[union-attr]
    assert sorted(children) == sorted(str(link.get("name")) for link in links[1:])
    assert {joint.find("parent").get("link") for joint in joints} == {"world"}  # type: ignore[union-attr]
    for link, joint, body in zip(links[1:], joints, bodies.bodies, strict=True):
        assert joint.get("type") == ("fixed" if body.fixed else "floating")
        assert float(link.find("inertial/mass").get("value")) == pytest.approx(body.moments.mass)  # type: ignore
        place = [float(x) for x in str(joint.find("origin").get("xyz")).split()]  # type: ignore[union-attr]
        assert TO_MODEL.T @ place == pytest.approx(body.moments.center, abs=1e-8)
        inertia = link.find("inertial/inertia")
        assert inertia is not None
        matrix = np.array([[float(inertia.get("i" + "".join(sorted(a + b)))) for b in "xyz"] for a in "xyz"])  # type: ignore
        assert TO_MODEL.T @ matrix @ TO_MODEL == pytest.approx(body.moments.inertia, rel=1e-6, abs=1e-9)
        shapes = [shape.kind for part in body.parts for shape in bodies.parts[part].colliders]
        expected = sum(3 if kind == "capsule" else 1 for kind in shapes)
        assert len(link.findall("collision")) == len(link.findall("visual")) == expected
    meshes = {str(mesh.get("filename")) for mesh in robot.iter("mesh")}
    assert {path.name for path in written} == {"a.urdf", *meshes}
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "a.urdf")).nbody == len(bodies.bodies) + 1 - 1 + _fused(bodies)


def _fused(bodies: Any) -> int:
    """MuJoCo keeps the links of fixed joints as bodies of their own only if it is told to."""
    return 1 - sum(body.fixed for body in bodies.bodies)


@pytest.mark.parametrize("ending", ["usda", "usdc", "usdz"])
def test_usd_physics_passes_the_validators(ending: str, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom, UsdPhysics, UsdValidation

    scene = sl.evaluate(MIXED)
    bodies = bodies_of(scene.root, 1.0)
    path = tmp_path / f"a.{ending}"
    scene.export(path, settings={"physics": True})
    stage = Usd.Stage.Open(str(path))
    every = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert [error.GetMessage() for error in UsdValidation.ValidationContext(every).Validate(stage)] == []
    moving = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    free = [body for body in bodies.bodies if not body.fixed]
    assert len(moving) == len(free)
    cache = UsdGeom.XformCache()
    for prim, body in zip(moving, free, strict=True):
        assert UsdPhysics.MassAPI(prim).GetMassAttr().Get() == pytest.approx(body.moments.mass, rel=1e-6)
        place = cache.GetLocalToWorldTransform(prim).ExtractTranslation()
        assert tuple(place) == pytest.approx(tuple(body.moments.center), abs=1e-9)
        assert not prim.IsInstance()
    colliders = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI)]
    assert len(colliders) == 1 + sum(len(part.colliders) for part in bodies.parts)
    plain, drawn = tmp_path / "plain.usdc", UsdGeom.BBoxCache(0.0, ["default"])
    scene.export(plain)
    stages = [stage, Usd.Stage.Open(str(plain))]
    boxes = [drawn.ComputeWorldBound(each.GetDefaultPrim()).ComputeAlignedBox() for each in stages]
    assert tuple(boxes[0].min) == pytest.approx(tuple(boxes[1].min), abs=1e-6)
    assert tuple(boxes[0].max) == pytest.approx(tuple(boxes[1].max), abs=1e-6)


def test_names_of_bodies_are_plain(tmp_path: Path) -> None:
    text = '(bind "a \\"<&>\\u0001 b" (lambda () (call "cube"))) (bind "r & r" (lambda () (call "a \\"<&>\\u0001 b")))'
    scene = sl.evaluate(text, root="r & r")
    for name in ("a.mjcf", "a.urdf"):
        scene.export(tmp_path / name)
        found = ElementTree.parse(tmp_path / name)
        assert re.fullmatch(
            r"a-b\.0|a-u0001-b\.0",
            str(next(iter(found.iter("body" if "mjcf" in name else "joint"))).get("name")).removeprefix("world-"),
        )


def test_geometry_and_physics_together_tell_each_finding_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "a.scene"
    program.write_text(
        '(define spare 3)\n(bind "vase" (lambda () (call "cube")))\n'
        '(bind "room" (lambda () (union (call "vase") (transform (call "vase") (translate [0 1.2 0])))))\n(scene "room")'
    )
    main(["check", "--geometry", "--physics", "--json", str(program)])
    codes = [each["code"] for each in json.loads(capsys.readouterr().out)]
    assert len(codes) == len(set(codes))
    assert {"W612", "W633"} < set(codes)


def test_settle_writes_the_translation_of_python(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = tmp_path / "answer.py"
    answer.write_text(
        '@register()\ndef cup() -> Shape:\n    return primitive_call("cube", scale=1.0)\n\n'
        "@register()\ndef room() -> Shape:\n"
        '    return concat_shapes(\n        transform_shape(library_call("cup"), translation_matrix((0, 0.5, 0))),\n'
        '        transform_shape(library_call("cup"), translation_matrix((3, 1.75, 0))))\n'
    )
    assert main(["settle", str(answer), "-o", str(tmp_path / "out.scene")]) == 0
    text = (tmp_path / "out.scene").read_text("utf-8")
    assert '(bind "room"' in text
    assert "def " not in text
    assert sl.load(tmp_path / "out.scene").bounds[1, 1] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    "asked",
    [
        ["check", "room.scene", "--seconds", "3"],
        ["check", "room.scene", "--physics", "--metres-per-unit", "1e-12"],
        ["check", "room.scene", "--physics", "--metres-per-unit", "1e300"],
        ["simulate", "room.scene", "-o", "a.json", "--fps", "100000"],
        ["simulate", "room.scene", "-o", "a.json", "--velocity", "cup=1e300,0,0"],
    ],
)
def test_settings_without_meaning_are_wrong_usage(file: Path, asked: list[str]) -> None:
    assert exit_code(asked) == 2


def exit_code(asked: list[str]) -> Any:
    try:
        return main(asked)
    except SystemExit as end:
        return end.code


@pytest.mark.parametrize("ending", [".urdf", ".mjcf"])
def test_exports_refuse_what_is_too_light(tmp_path: Path, ending: str) -> None:
    scene = sl.evaluate('(bind "a" (lambda () (call "cube" :scale 1e-7)))')
    with pytest.raises(sl.SceneError, match="too light"):
        scene.export(tmp_path / f"a{ending}")


def test_a_scene_without_solids_passes_with_a_remark() -> None:
    cloud = sl.evaluate('(bind "sky" (lambda () (call "cloud")))')
    assert [d.name for d in verdicts.check_physics(cloud.graph)] == ["not-simulated"]
    film = sl.evaluate('(bind "sky" (lambda () (frames (list (call "cloud") (call "cube")))))')
    [remark] = verdicts.check_physics(film.graph)
    assert "frame 0" in remark.message
