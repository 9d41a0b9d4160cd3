"""Sound rooms without findings, planted faults that are found, hollow solids, what hangs or tips, and pictures."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support import calls

from scenelang.backends.geometry.lint import CheckedFrame, marked_finding
from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.entity import Scene
from scenelang.session.session import Session

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
sys.path.append(str(BENCHMARKS))  # behind the tests, whose packages have the names of some benchmarks
import faulty
from faulty import Planter, Program
from planted import CODES, Score, score_geometry

session = Session()
PARTS = """
(bind "floor" (lambda () (transform (call "cube" :scale [4 .1 4]) (translate [0 -.05 0]))))
(bind "table" (lambda () (union
  (transform (call "cube" :scale [1 .1 1]) (translate [0 .65 0]))
  (for*/union ((x '(-.4 .4)) (z '(-.4 .4))) (transform (call "cube" :scale [.1 .6 .1]) (translate [x .3 z]))))))
(bind "mug" (lambda () (difference
  (call "cylinder" :radius .1 :p0 [0 0 0] :p1 [0 .2 0]) (call "cylinder" :radius .09 :p0 [0 .01 0] :p1 [0 .3 0]))))
(bind "spoon" (lambda () (call "cylinder" :radius .01 :p0 [0 .012 0] :p1 [.05 .3 0])))
(bind "bowl" (lambda () (lathe '([0 0] [.1 0] [.3 .2] [.28 .2] [.09 .02] [0 .02]))))
(bind "ball" (lambda () (call "sphere" :radius .1)))
(bind "post" (lambda () (call "cylinder" :radius .05 :p0 [0 0 0] :p1 [0 .5 0])))
(bind "ring" (lambda () (call "torus" :radius .15 :tube .04)))
(bind "crate" (lambda () (call "cube" :scale .3)))
(bind "cup" (lambda () (call "cylinder" :radius .05 :p0 [0 0 0] :p1 [0 .1 0])))
"""


def at(word: str, place: str, turn: str = "") -> str:
    pose = f"(translate [{place}])"
    return f'(transform (call "{word}") {f"(@ {pose} (rotate {turn}))" if turn else pose})'


def frame_of(*parts: str) -> CheckedFrame:
    text = f'{PARTS} (bind "room" (lambda () (union (call "floor") (call "table") {" ".join(parts)}))) (scene "room")'
    scene = session.evaluate(Source("room.scene", text)).scene
    assert scene is not None
    return CheckedFrame(scene.root)


def kinds(*parts: str) -> list[str]:
    return [finding.kind for finding in frame_of(*parts).findings]


@pytest.mark.parametrize("path", sorted((BENCHMARKS / "rooms").glob("*.scene")), ids=lambda path: path.stem)
@pytest.mark.sampled(3)
def test_sound_rooms_have_no_findings(path: Path) -> None:
    assert [d for d in session.check_geometry(session.source(str(path))) if d.severity != "note"] == []


def test_planted_faults_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    score = Score()
    path = BENCHMARKS / "rooms" / "party.scene"
    monkeypatch.setattr(faulty, "MAX_CANDIDATES", 12)
    program = Program("party", path.read_text("utf-8"), session, str(path))
    chosen = ("floating", "past the edge", "tilted", "hanging", "twin", "sunk")
    faults = list(Planter(program, seed=5).faults(chosen, dict.fromkeys(chosen, 1)))
    assert {fault.kind for fault in faults} <= set(CODES)
    score_geometry(program, faults, score)
    assert sum(score.planted.values()) >= 4
    assert score.missed == []
    assert score.false == []


@pytest.mark.parametrize(
    "parts",
    [
        [at("bowl", "0 .7 0"), at("ball", "0 .82 0")],
        [at("post", "1.2 0 0"), at("ring", "1.2 .04 0")],
        [at("crate", "1.2 .15 0"), at("crate", "1.2 .45 0", ".4 [0 1 0]")],
    ],
)
def test_hollow_solids_are_not_their_hulls(parts: list[str]) -> None:
    assert kinds(*parts) == []


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ([at("cup", "0 .5 0")], ["falls"]),  # below the top, by contact
        ([at("crate", "1.2 .2121 0", "(/ pi 4) [0 0 1]")], ["tips"]),
        ([at("cup", ".52 .7 0")], ["tips"]),
        ([at("crate", "1.2 -.1 0")], ["sunk"]),
    ],
)
def test_what_is_found(parts: list[str], expected: list[str]) -> None:
    assert kinds(*parts) == expected


def test_a_wrong_offset_of_a_loop_is_one_finding() -> None:
    text = f"""{PARTS} (bind "room" (lambda () (union (call "floor")
      (for/union ((x '(-1.4 0 1.4))) (transform (call "table") (translate [x .3 0])))))) (scene "room")"""
    (finding,) = (d for d in session.check_geometry(Source("room.scene", text)) if d.name != "unreachable-word")
    assert finding.message == (
        '"room/table" floats: it touches nothing that stands, and is 0.3 from "room/floor" (3 times)'
    )


def test_a_picture_shows_both_sides_and_where_they_touch(tmp_path: Path) -> None:
    frame = frame_of(at("cup", ".52 .7 0"))
    marks = frame.marks(frame.findings[0])
    assert len(marks.subject) == 1
    assert len(marks.other) == 5
    assert marks.centers == pytest.approx(np.array([[0.52, 0.75, 0.0]]))
    assert marks.points[:, 0].max() == pytest.approx(0.5)  # the edge of the table
    program = tmp_path / "room.scene"
    program.write_text(
        f'{PARTS} (bind "room" (lambda () (union (call "floor") (call "table") {at("cup", ".52 .7 0")})))'
    )
    picture = tmp_path / "room.png"
    assert main(["check", "--geometry", "--picture", str(picture), "-q", str(program)]) == 0
    pixels = np.asarray(Image.open(picture).convert("RGB")).astype(int)
    red = (pixels[..., 0] - pixels[..., 2] > 60).mean()
    blue = (pixels[..., 2] - pixels[..., 0] > 40).mean()
    assert 0.01 < red < 0.3
    assert blue > 0.05
    scene = session.evaluate(Source("sound.scene", '(bind "a" (lambda () (call "cube")))')).scene
    assert scene is not None
    assert marked_finding(scene) is None


def hall(rows: int) -> Scene:
    """Tables with cups, ``rows`` by ``rows``, as they should stand."""
    text = f"""{PARTS} (bind "place" (lambda () (union (call "table") (for*/union ((x '(-.3 0 .3)) (z '(-.3 0 .3)))
      (transform (call "cup") (translate [x .7 z]))))))
    (bind "row" (lambda () (for/union ((i (iota {rows}))) (transform (call "place") (translate [(* 1.2 i) 0 0])))))
    (bind "hall" (lambda () (union
      (transform (call "cube" :scale [{1.25 * rows} .1 {1.25 * rows}]) (translate [{0.6 * rows} -.05 {0.6 * rows}]))
      (for/union ((i (iota {rows}))) (transform (call "row") (translate [0 0 (* 1.2 i)]))))))
    (scene "hall")"""
    scene = session.evaluate(Source("hall.scene", text)).scene
    assert scene is not None
    return scene


@pytest.mark.slow
def test_four_times_the_primitives_take_four_times_the_work() -> None:
    """Things are compared with those near them, not with all."""

    def work(rows: int) -> int:
        scene, found = hall(rows), []
        made = calls(lambda: found.extend(CheckedFrame(scene.root).findings))
        assert found == []
        return made

    work(2)  # what is made once
    few, many = work(8), work(16)
    assert many < 4.5 * few
