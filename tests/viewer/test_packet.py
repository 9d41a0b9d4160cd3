"""The packet: the DAG, instances in the stage's frame, frames that share rows."""

from __future__ import annotations

import json
import struct
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import unchecked

from scenelang import Evaluated, Session, Source
from scenelang.backends.viewer.packet import packet_changes, packet_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.flatten import flatten

TYPES = {"f4": np.float32, "i4": np.int32, "u4": np.uint32, "u1": np.uint8}


class Decoded:
    """A packet as the page reads it."""

    def __init__(self, data: bytes) -> None:
        assert data[:4] == b"SCNV"
        (length,) = struct.unpack("<I", data[4:8])
        self.header: dict[str, Any] = json.loads(data[8 : 8 + length])
        start = 8 + length
        assert start % 8 == 0
        self.columns = {
            name: np.frombuffer(data, TYPES[kind], size, start + offset)
            for name, (kind, offset, size) in self.header["columns"].items()
        }


def changed(old: bytes, changes: bytes) -> bytes:
    """A packet with changes, as the page makes it."""
    assert changes[:4] == b"SCNC"
    (length,) = struct.unpack("<I", changes[4:8])
    made, next_byte = b"", 8 + length
    for at, size in json.loads(changes[8 : 8 + length]):
        made += changes[next_byte : next_byte + size] if at < 0 else old[at : at + size]
        next_byte += size if at < 0 else 0
    assert next_byte == len(changes)
    return made


def evaluate(text: str) -> Evaluated:
    return Session().evaluate(Source("<text>", text))


def packet(text: str, **options: Any) -> Decoded:
    result = evaluate(text)
    assert result.scene is not None, result.diagnostics
    program = result.program
    assert program is not None
    return Decoded(packet_of(result.scene, definitions=program.all_words, **options))


TWO = """(bind "thing" (lambda () (union (transform (transform (call "cube" :color [1 0 0]) (scale 2)) (translate [1 2 3]))
                                          (call "stone" <z9> :note "x"))))
"""


def test_the_graph_is_the_dag_with_words_handles_and_places() -> None:
    found = packet(TWO)
    words = [found.header["words"][i] for i in found.columns["nodeWord"]]
    assert words == ["cube", "stone", "thing"]
    assert found.columns["nodeChild"].tolist() == [0, 1]
    assert found.columns["nodeStart"].tolist() == [0, 0, 0, 2]
    assert found.columns["nodePrimitive"].tolist() == [1, 1, 0]
    stone = found.header["embeddings"][found.columns["nodeEmbedding"][1]]
    assert stone["handle"] == "z9"
    assert ["note", '"x"'] in stone["attributes"]
    assert found.header["taken"] == [1, 9]
    (place,) = found.header["places"][found.columns["nodePlace"][1]]
    assert (place["line"], place["column"]) == (2, 43)
    (bound,) = found.header["places"][found.columns["nodeDefinition"][2]]
    assert (bound["line"], bound["text"][:13]) == (1, '(bind "thing"')


def test_rows_are_poses_in_the_stage_frame() -> None:
    found = packet(TWO)
    box = found.header["box"]
    poses = found.columns["rowPose"].reshape(-1, 3, 4)
    canonical = np.array([[-1, -1, -1, 1], [1, 1, 1, 1]]).T
    low, high = (poses[0] @ canonical).T / box["scale"] + box["center"]
    assert np.allclose([low, high], [[0, 1, 2], [2, 3, 4]], atol=1e-5)
    assert found.columns["primitiveSemantic"].tolist() == [0, 1], "the stone is semantic"
    assert [[found.header["words"][i] for i in path] for path in found.header["paths"]] == [["thing"]]


def test_a_mirrored_and_sheared_pose_comes_through_whole() -> None:
    found = packet('(bind "a" (lambda () (transform (transform (call "cube") (rotate .4 [0 0 1])) (scale [-1 2 1]))))')
    linear = found.columns["rowPose"].reshape(3, 4)[:, :3] / found.header["box"]["scale"] * 2
    turned = np.array([[np.cos(0.4), -np.sin(0.4), 0], [np.sin(0.4), np.cos(0.4), 0], [0, 0, 1]])
    assert np.allclose(linear, np.diag([-1, 2, 1]) @ turned, atol=1e-5)


FILM = """(bind "film" (lambda () (frames (for/list ((i 10)) (union
  (union-loop 50 (lambda (k) (transform (call "sphere") (translate (list k 0 0)))))
  (transform (call "cube") (translate (list 0 i 5))))))))
"""


def test_rows_that_frames_share_are_sent_once() -> None:
    found = packet(FILM)
    assert found.header["frames"] == 10
    assert len(found.columns["rowPrimitive"]) == 50 + 10
    assert len(found.columns["frameRow"]) == 10 * 51
    poses = found.columns["rowPose"].reshape(-1, 3, 4)
    result = evaluate(FILM)
    assert result.scene is not None
    box = found.header["box"]
    for number, frame in enumerate(flatten(result.scene).frames):
        rows = found.columns["frameRow"][found.columns["frameStart"][number] : found.columns["frameStart"][number + 1]]
        assert np.allclose(poses[rows][:, :, 3] / box["scale"] + box["center"], frame.matrices[:, :, 3], atol=1e-4)


def test_what_is_too_much_to_draw_is_a_tree_and_a_line() -> None:
    found = packet(FILM, limit=100)
    assert "510 primitives, more than the limit of 100" in found.header["notice"]
    assert "rowPose" not in found.columns
    assert len(found.columns["nodeWord"]) > 10


def test_size_follows_distinct_entities() -> None:
    levels = "\n".join(
        f'(bind "l{i}" (lambda () (union-loop 100 (lambda (k) (transform (call "{below}") (translate (list k 0 0)))))))'
        for i, below in enumerate(["cube", "l0", "l1", "l2", "l3", "l4"])
    )
    result = evaluate(levels)
    assert result.scene is not None
    assert len(packet_of(result.scene)) < 20_000


@pytest.mark.parametrize("text", ['(bind "a" (lambda () (union)))', '(bind "a" (lambda () (call "delete-blocks")))'])
def test_no_geometry_is_a_notice(text: str) -> None:
    assert "nothing to draw" in packet(text).header["notice"]


def test_a_primitive_without_extent_is_no_trouble() -> None:
    flat = '(bind "a" (lambda () (union (call "cylinder" :p1 [0 0 0]) (call "sphere" :radius 0) (call "cube" :scale [1 0 1]))))'
    found = packet(flat)
    assert np.isfinite(found.columns["rowPose"]).all()


def test_a_look_that_makes_no_sense_is_an_error() -> None:
    with unchecked():
        result = evaluate('(bind "a" (lambda () (call "cube" :ior .5)))')
    assert result.scene is not None
    with pytest.raises(SceneError) as error:
        packet_of(result.scene)
    assert error.value.name == "attribute"


@pytest.mark.parametrize("name", ["viewer.css", "page.html"])
def test_the_built_page_is_that_of_its_source(name: str) -> None:
    folder = Path(__file__).parents[2] / "backends" / "viewer"
    assert (folder / "static" / name).read_bytes() == (folder / "source" / "src" / name).read_bytes(), (
        "run `make viewer`"
    )


STREET = """(bind "house" (lambda ((:size 1)) (call "cube" :scale [size 1 1])))
(bind "street" (lambda () (union-loop 500 (lambda (i)
  (transform (call "house" :size (+ 1 i)) (translate (list (* 2 i) 0 0)))))))
"""
EDITS = {
    "nothing": ("", ""),
    "a color": ('"cube"', '"cube" :color [1 0 0]'),
    "one part": ("(+ 1 i)", "(if (= i 250) 7 (+ 1 i))"),
    "a moved part": ("(list (* 2 i) 0 0)", "(if (= i 250) (list 400 0 0) (list (* 2 i) 0 0))"),
    "more parts": ("union-loop 500", "union-loop 501"),
    "another shape": ('"cube"', '"sphere"'),
    "no scene": ('(call "cube" :scale [size 1 1])', "(list)"),
    "a longer word": ("house", "a house with a longer name"),
}


@pytest.mark.parametrize("edit", EDITS)
@pytest.mark.sampled(3)
def test_changes_make_the_new_packet(edit: str) -> None:
    texts = (STREET, STREET.replace(*EDITS[edit]))
    old, new = (packet_of(found.scene) for found in map(evaluate, texts) if found.scene is not None)
    for before, after in ((old, new), (new, old)):
        assert changed(before, packet_changes(before, after)) == after
    if edit in ("nothing", "one part", "a moved part"):
        assert len(packet_changes(old, new)) < len(new) / 20


def test_changes_between_any_scenes() -> None:
    folder = Path(__file__).parents[2] / "examples"
    packets = [packet_of(found.scene) for path in sorted(folder.glob("*.scene"))[:8]
               if (found := evaluate(path.read_text("utf-8"))).scene is not None]  # fmt: skip
    for old, new in pairwise(packets):
        assert changed(old, packet_changes(old, new)) == new
