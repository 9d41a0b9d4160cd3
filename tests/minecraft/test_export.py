"""`scenelang export` and `import`: every file of the game's from scenes, and programs from files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from transpile.cases import CORPUS, Case, scene_of, translated

from minecraft.oracle import Cuboid, of_build
from minecraft.scenes import CUBOIDS, placed
from scenelang.backends import base
from scenelang.backends.base import BackendOptions
from scenelang.backends.minecraft.connections import settled
from scenelang.backends.minecraft.export import BLOCKS, LITEMATIC, SCHEM, STRUCTURE, read
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.scene.entity import Scene

HOUSE = """
(bind "house" (lambda ()
  (union (call "set-cuboid" :block-type "stone_bricks" :scale [7 5 7] :fill #f)
         (transform (call "set-cuboid" :block-type "glass_pane" :scale [1 2 3]) (translate [0 2 2]))
         (transform (call "delete-blocks" :scale [1 2 1]) (translate [3 1 6]))
         (transform (call "set-cuboid" :block-type "oak_fence" :scale [9 1 1]) (translate [-1 0 -2])))))
"""
MOVE = """
(bind "move" (lambda () (frames (for/list ((i (range 3)))
  (transform (call "set-cuboid" :block-type "stone" :scale [2 1 1]) (translate [i 0 0]))))))
"""
BALL = '(bind "ball" (lambda () (call "sphere" :radius 2 :color (color "crimson"))))'
READABLE = [(SCHEM, ".schem"), (LITEMATIC, ".litematic"), (STRUCTURE, ".nbt")]
ENDINGS = [".schem", ".litematic", ".nbt", ".zip", ".mcfunction", ".scene"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in (("house", HOUSE), ("move", MOVE), ("ball", BALL)):
        (tmp_path / f"{name}.scene").write_text(text, "utf-8")
    return tmp_path


@settings(max_examples=many(40), deadline=None)
@given(st.lists(CUBOIDS, min_size=1, max_size=12), st.sampled_from(READABLE))
def test_voxelise_write_read_evaluate(
    tmp_path_factory: pytest.TempPathFactory, cuboids: list[Cuboid], kind: tuple[base.Backend, str]
) -> None:
    """The blocks of a scene, of its file, of the program of that file, and of the file of that program are the same."""
    backend, ending = kind
    root = placed(cuboids)
    wanted = of_build(settled(voxelised(root)).build)
    if not wanted:
        return
    folder = tmp_path_factory.mktemp("build")
    (file,) = backend.run(Scene("build", [root], False), folder / f"a{ending}", BackendOptions()) or []
    assert of_build(read(file).build) == wanted
    assert main(["import", str(file), "-o", str(folder / "b.scene"), "--quiet"]) == 0
    again = scene_of("b.scene", (folder / "b.scene").read_text("utf-8"))
    assert of_build(settled(voxelised(again.root)).build) == wanted
    backend.run(again, folder / f"c{ending}", BackendOptions())
    assert of_build(read(folder / f"c{ending}").build) == wanted


@pytest.mark.parametrize("case", [c for c in CORPUS if "set_cuboid" in c.text][:4], ids=lambda case: case.name)
def test_responses_of_the_corpus(case: Case, tmp_path: Path) -> None:
    scene = scene_of(case.name, translated(case).text)
    for backend, ending in READABLE:
        written = backend.run(scene, tmp_path / f"a{ending}", BackendOptions(frame=0)) or []
        if len(written) == 1:
            assert of_build(read(written[0]).build) == of_build(settled(voxelised(scene.root)).build)


@pytest.mark.parametrize("ending", ENDINGS)
def test_every_ending(ending: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "house.scene", "-o", f"out{ending}"]) == 0
    assert capsys.readouterr().out == f"wrote out{ending}\n"
    assert (folder / f"out{ending}").stat().st_size > 100


def test_the_references_json(folder: Path) -> None:
    assert main(["export", "move.scene", "-o", "out.json", "--backend", "minecraft-json"]) == 0
    found = json.loads((folder / "out.json").read_text("utf-8"))
    assert (found["width"], found["height"], found["depth"]) == (4, 1, 1)
    assert [frame[0]["start"] for frame in found["frames"]] == [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    assert {(cuboid["fill"], tuple(cuboid["stack"])) for frame in found["frames"] for cuboid in frame} == {(True, ())}


def test_frames_are_files(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "move.scene", "-o", "out.schem"]) == 0
    assert capsys.readouterr().out.splitlines() == [f"wrote out-00{i}.schem" for i in (1, 2, 3)]
    assert [read(folder / f"out-00{i}.schem").build.origin for i in (1, 2, 3)] == [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    assert main(["export", "move.scene", "-o", "one.schem", "--frame", "2"]) == 0
    assert read(folder / "one.schem").build.origin == (2, 0, 0)


def test_shapes_are_filled(folder: Path) -> None:
    assert main(["export", "ball.scene", "-o", "ball.schem", "--voxelize", "20", "--palette", "wool"]) == 0
    build = read(folder / "ball.schem").build
    assert build.size == (20, 20, 20)
    assert build.origin == (-10, -10, -10)
    assert [state.name for state in build.palette[1:]] == ["minecraft:red_wool"]
    assert np.count_nonzero(build.cells) == pytest.approx(4 / 3 * np.pi * 1000, rel=0.03)


def test_a_filled_scene_becomes_a_program(folder: Path) -> None:
    assert main(["export", "ball.scene", "-o", "blocks.scene", "--voxelize", "12"]) == 0
    again = scene_of("blocks.scene", (folder / "blocks.scene").read_text("utf-8"))
    assert np.count_nonzero(voxelised(again.root).build.cells) == pytest.approx(4 / 3 * np.pi * 216, rel=0.06)


def test_versions(folder: Path) -> None:
    import gzip

    assert main(["export", "house.scene", "-o", "new.schem"]) == 0
    assert main(["export", "house.scene", "-o", "old.schem", "--mc-version", "1.20.4"]) == 0
    new, old = (gzip.decompress((folder / f"{name}.schem").read_bytes()) for name in ("new", "old"))
    assert (4786).to_bytes(4, "big") in new
    assert (3700).to_bytes(4, "big") in old


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["ball.scene", "-o", "a.schem"], "--voxelize 64"),
        (["house.scene", "-o", "a.schem", "--mc-version", "1.12"], "unknown Minecraft version"),
        (["house.scene", "-o", "a.schem", "--voxelize", "0"], "must be 1 or more"),
        (["house.scene", "-o", "a.schem", "--palette", "wol"], "wool"),
        (["house.scene", "-o", "a.glb", "--voxelize", "9"], "no option `--voxelize`"),
    ],
)
def test_mistakes(arguments: list[str], said: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong_program = arguments[0] == "ball.scene"
    assert main(["export", *arguments]) == (1 if wrong_program else 2)
    error = capsys.readouterr().err
    assert said in error
    assert not (folder / "a.schem").exists()


def test_warnings_reach_the_user(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.scene").write_text(
        '(bind "a" (lambda () (union (call "cube") (call "set-cuboid" :block-type "marble"))))', "utf-8"
    )
    assert main(["export", "a.scene", "-o", "a.nbt"]) == 0
    said = capsys.readouterr().err
    assert "W616" in said
    assert "W617" in said
    assert main(["render", "a.scene", "-o", "a.png", "--size", "32x32"]) == 0
    assert "W616" in capsys.readouterr().err
    assert main(["export", "a.scene", "-o", "a.glb", "--quiet"]) == 0
    assert not capsys.readouterr().err


def test_every_backend_of_blocks_can_be_chosen() -> None:
    told: list[Diagnostic] = []
    names = [b.name for b in base.all_backends(base.Work.EXPORT) if any(o.name == "voxelize" for o in b.options)]
    assert names == ["blocks", "datapack", "litematic", "mcfunction", "minecraft-json", "schem", "structure"]
    assert BLOCKS.setting(BackendOptions(warn=told.append), "voxelize") is None


# --- import ----------------------------------------------------------------------------------------------------------


def test_import_prints_a_program(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "house.scene", "-o", "out.litematic", "--quiet"]) == 0
    assert main(["import", "out.litematic"]) == 0
    said = capsys.readouterr()
    assert not said.err
    assert of_build(settled(voxelised(scene_of("a.scene", said.out).root)).build) == of_build(
        read(folder / "out.litematic").build
    )


def test_what_a_file_loses_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import nbtlib

    root = nbtlib.Compound({
        "DataVersion": nbtlib.Int(4786),
        "size": nbtlib.List[nbtlib.Int]([1, 1, 1]),
        "palette": nbtlib.List[nbtlib.Compound]([nbtlib.Compound({"Name": nbtlib.String("minecraft:chest")})]),
        "blocks": nbtlib.List[nbtlib.Compound]([
            nbtlib.Compound({
                "state": nbtlib.Int(0), "pos": nbtlib.List[nbtlib.Int]([0, 0, 0]),
                "nbt": nbtlib.Compound({"id": nbtlib.String("minecraft:chest")}),
            })
        ]),
        "entities": nbtlib.List[nbtlib.Compound]([nbtlib.Compound({"pos": nbtlib.List[nbtlib.Double]([0, 1, 0])})]),
    })  # fmt: skip
    nbtlib.File(root, gzipped=True).save(folder / "chest.nbt")
    assert main(["import", "chest.nbt", "-o", "chest.scene"]) == 0
    said = capsys.readouterr().err
    assert "W618" in said
    assert "the contents of 1 block" in said
    assert "1 entity" in said
    assert main(["check", "chest.scene"]) == 0


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["none.schem"], 1, "none.schem"),
        (["house.scene"], 1, ".schem"),
        (["broken.schem"], 1, "not a valid Sponge schematic"),
        (["broken.schem", "-o", "a.png"], 2, "use .scene"),
        (["broken.schem", "-o", "nowhere/a.scene"], 1, "the folder nowhere does not exist"),
    ],
)
def test_files_that_cannot_be_read(
    arguments: list[str], code: int, said: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "broken.schem").write_bytes(b"\x1f\x8b nothing")
    assert main(["import", *arguments]) == code
    assert said in capsys.readouterr().err
    assert not (folder / "a.scene").exists()


def test_states_that_are_not_known_are_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import nbtlib

    block = nbtlib.Compound({
        "Name": nbtlib.String("minecraft:oak_log"), "Properties": nbtlib.Compound({"foo": nbtlib.String("bar")}),
    })  # fmt: skip
    root = nbtlib.Compound({
        "size": nbtlib.List[nbtlib.Int]([1, 1, 1]),
        "palette": nbtlib.List[nbtlib.Compound]([block]),
        "blocks": nbtlib.List[nbtlib.Compound]([
            nbtlib.Compound({"state": nbtlib.Int(0), "pos": nbtlib.List[nbtlib.Int]([0, 0, 0])})
        ]),
    })  # fmt: skip
    nbtlib.File(root, gzipped=True).save(folder / "odd.nbt")
    assert main(["import", "odd.nbt", "-o", "odd.scene"]) == 0
    said = capsys.readouterr().err
    assert "W618" in said
    assert "`minecraft:oak_log[foo=bar]`" in said


def test_a_file_without_blocks(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import nbtlib

    empty = {"size": nbtlib.List[nbtlib.Int]([0, 0, 0]), "palette": nbtlib.List[nbtlib.Compound]([])}
    root = nbtlib.Compound({**empty, "blocks": nbtlib.List[nbtlib.Compound]([])})
    nbtlib.File(root, gzipped=True).save(folder / "empty.nbt")
    assert main(["import", "empty.nbt"]) == 1
    assert "`empty.nbt` contains no blocks" in capsys.readouterr().err
