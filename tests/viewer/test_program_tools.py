"""What the studio asks about a program besides its picture, through the server."""

from __future__ import annotations

import base64
import io
import json
import math
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from support import wait_until
from viewer.conftest import open_session

from scenelang.grammar.diagnostics import SceneError
from scenelang.viewer.program_tools import TOOLS, SharedProgress, tools
from scenelang.viewer.workspace import SUPERSEDED, Workspace, evaluator

TEXT = """(define height 3)
(bind "ball" (lambda ((:r .5)) (call "sphere" :radius r)))
(bind "a" (lambda () (union
  (call "cube" :scale [4 .2 4])
  (transform (call "ball") (translate [0 1.5 0]))
  (transform (call "ball" :r .3) (translate [3 1.5 4])))))
"""


def ask(tool: str, text: str = TEXT, **data: Any) -> dict[str, Any]:
    """What a tool makes of a program; it must be data of JSON."""
    answer: dict[str, Any] = json.loads(json.dumps(tools(open_session)(tool, "a.scene", text, data)))
    return answer


def test_a_finding_says_where_it_is() -> None:
    """The ball is above the slab by 0.9: its primitive, the slab's, and a line that long straight down."""
    (finding,) = [each for each in ask("examine")["diagnostics"] if "0.9" in each["message"]]
    assert finding["code"] == "W612"
    assert finding["marks"]["frame"] == 0
    (mark,) = finding["marks"]["objects"]
    assert (mark["subject"], mark["other"]) == ([[1, 2]], [[0, 1]])
    ((top, bottom),) = mark["lines"]
    assert top == pytest.approx([0, 1, 0])
    assert bottom == pytest.approx([0, 0.1, 0])


def test_an_overlap_is_marked_at_its_contact() -> None:
    text = """(bind "box" (lambda () (call "cube")))
(bind "crate" (lambda () (call "cube" :scale [1 1.5 1])))
(bind "a" (lambda () (union (call "cube" :scale [9 .1 9]) (transform (call "box") (translate [0 .55 0]))
  (transform (call "crate") (translate [.7 .8 .1])))))
"""
    marked = [each for each in ask("examine", text)["diagnostics"] if "marks" in each]
    points = [point for each in marked for object in each["marks"]["objects"] for point in object["points"]]
    assert points
    assert all(0.2 - 1e-6 <= x <= 0.5 + 1e-6 for x, _, _ in points)  # the common part


def test_the_finding_of_a_film_is_in_a_frame_that_has_it() -> None:
    text = """(bind "film" (lambda () (frames (for/list ((i 4)) (union (call "cube" :scale [4 .2 4])
      (transform (call "sphere" :radius .5) (translate [0 (if (= i 0) .6 1.5) 0])))))))"""
    (finding,) = [each for each in ask("examine", text)["diagnostics"] if "marks" in each]
    assert finding["marks"]["frame"] == 1
    assert "(frame 1)" in finding["message"]


def test_gaps_are_those_of_the_shapes() -> None:
    assert ask("gap", **{"from": "a/cube", "to": "ball[0]"}) == {
        "distance": pytest.approx(0.9, abs=1e-6),
        "exact": True,
    }
    between = ask("gap", **{"from": "ball[0]", "to": "ball[1]"})["distance"]
    assert between == pytest.approx(math.hypot(3, 4) - 0.8, abs=1e-6)
    assert ask("gap", TEXT.replace("[0 1.5 0]", "[0 .5 0]"), **{"from": "cube", "to": "ball[0]"})["distance"] == 0.0


@pytest.mark.parametrize(
    "data", [{"from": "cube"}, {"from": "cube", "to": "horse"}, {"from": "cube", "to": "cube", "frame": 7}, {"from": 3}]
)
def test_a_wrong_gap_is_refused(data: Mapping[str, Any]) -> None:
    with pytest.raises(SceneError):
        ask("gap", **data)


def test_expressions_see_the_program() -> None:
    assert ask("evaluate", expression="(+ height 4)") == {"values": ["7"], "log": [], "diagnostics": []}
    assert ask("evaluate", expression='(print "hi") (define (f n) (* 2 n)) (f height)')["values"] == ["6"]
    assert ask("evaluate", expression='(call "ball" :r 1)')["values"][0].startswith("ball  :r 1\n")
    wrong = ask("evaluate", expression="(+ height widht)")
    assert (wrong["values"], wrong["diagnostics"][0]["code"]) == ([], "E301")
    assert ask("evaluate", "(oops", expression="1")["diagnostics"][0]["severity"] == "error"


def test_an_endless_expression_ends() -> None:
    endless = ask("evaluate", expression="(let loop ((i 0)) (loop (+ i 1)))")
    assert endless["diagnostics"][0]["code"] == "E501"
    for wrong in (None, 3, "x" * 30_000):
        with pytest.raises(SceneError):
            ask("evaluate", expression=wrong)


def test_a_newer_request_ends_the_one_that_runs(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    path.write_text(TEXT)
    started, interrupted = threading.Event(), threading.Event()
    answers: list[Any] = []

    def use(tool: str, file: str, text: str, data: Mapping[str, Any]) -> dict[str, Any]:
        if data["n"] == 1:
            started.set()
            assert interrupted.wait(10)
            raise SceneError("interrupted", "interrupted")
        return {"n": data["n"]}

    space = Workspace([str(path)], evaluator(open_session, 1_000), use, lambda what: interrupted.set())

    def first() -> None:
        try:
            answers.append(space.use("evaluate", 0, TEXT, {"n": 1}))
        except SceneError as error:
            answers.append(error.message)

    thread = threading.Thread(target=first)
    thread.start()
    assert started.wait(10)
    interrupted.clear()
    assert space.use("evaluate", 0, TEXT, {"n": 2}) == {"n": 2}
    thread.join(10)
    assert answers == ["interrupted"]


def test_each_tool_that_is_superseded_is_one() -> None:
    assert set(SUPERSEDED) <= set(TOOLS)


VIEW = {"camera": "azimuth=20,elevation=30", "frame": 0, "width": 40, "height": 32}


def test_a_still_image_is_path_traced_with_progress() -> None:
    pytest.importorskip("mitsuba", reason="images are path traced with the package mitsuba")
    progress, said = SharedProgress(), list[float]()

    def report(fraction: float) -> None:
        progress.write(fraction)
        said.append(progress.read())

    answer = tools(open_session, report)("still", "a.scene", TEXT, VIEW)
    with Image.open(io.BytesIO(base64.b64decode(answer["png"]))) as image:
        assert (image.format, image.size) == ("PNG", (40, 32))
        colors = image.convert("RGB").getcolors(40 * 32)
    assert colors is not None
    assert len(colors) > 50
    assert said[0] == 0.0
    assert said == sorted(said)
    assert len(said) > 4


def test_without_mitsuba_a_still_image_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(SceneError) as raised:
        ask("still", **VIEW)
    assert "mitsuba" in raised.value.message + str(raised.value.hint)
    assert "\n" not in raised.value.message


@pytest.mark.parametrize(
    "wrong",
    [{"width": 10**9}, {"height": 0}, {"width": "40"}, {"camera": None}, {"frame": "a"}, {"camera": "azimuth=x"}],
)
def test_a_wrong_still_image_is_refused(wrong: Mapping[str, Any]) -> None:
    with pytest.raises(SceneError):
        ask("still", **{**VIEW, **wrong})


def test_the_command_runs_each_tool_in_a_process(tmp_path: Path) -> None:
    """Values come from a worker's process, an endless one is ended from outside, and the server goes on."""
    from scenelang.sandbox.worker import Worker

    worker = Worker(tools(open_session))
    endless = "(for/list ((i 100000000)) (for/list ((j 1000)) j))"
    found: list[Any] = []

    def run() -> None:
        try:
            found.append(worker.ask("evaluate", "a.scene", TEXT, {"expression": endless}))
        except SceneError as error:
            found.append(error.message)

    thread = threading.Thread(target=run)
    thread.start()
    wait_until(lambda: worker._running > 0)
    worker.interrupt()
    thread.join(30)
    assert "interrupted" in str(found) or "limit" in str(found)
    assert worker.ask("evaluate", "a.scene", TEXT, {"expression": "height"})["values"] == ["3"]
    worker.close()
