"""Whole objects, scenes that settle, and strips of films, by the real client."""

from __future__ import annotations

import base64
import io
from importlib.util import find_spec
from typing import Any

import pytest
from PIL import Image

ROOM = """(bind "cup" (lambda () (union (call "cube" :color [1 0 0])
  (transform (call "cube" :scale .5 :color [0 1 0]) (translate [0 .75 0])))))
(bind "room" (lambda () (union
  (call "cup")
  (transform (call "cup") (translate [3 0 0])))))
"""
DROP = """(bind "floor" (lambda () (call "cube" :scale [4 .2 4])))
(bind "box" (lambda () (call "cube" :scale .5)))
(bind "room" (lambda () (union (transform (call "floor") (translate [0 -.1 0]))
  (transform (call "box") (translate [0 .6 0])))))
"""
FILM = '(bind "a" (lambda () (frames (for/list ((i 11)) (union (transform (call "cube") (translate [i 0 0])))))))'


def text(result: Any) -> str:
    return "\n".join(content.text for content in result.content if content.type == "text")


def picture(result: Any) -> Any:
    assert not result.is_error, text(result)
    (image,) = (content for content in result.content if content.type == "image")
    return Image.open(io.BytesIO(base64.b64decode(image.data)))


def opened(agent: Any, program: str) -> str:
    name: str = agent.told("open", program=program)["session"]
    return name


def test_whole_objects(agent: Any) -> None:
    session = opened(agent, ROOM)
    said = text(agent.call("edit_part", session=session, path="cup[1]", recolor="[0 0 1]"))
    assert "(1 instance, nothing else changes)" in said
    found = agent.told("query", session=session, path="cup/cube")["instances"]
    assert [each["attributes"]["color"] for each in found] == [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1]]
    assert agent.told("edit_part", session=session, path="cup[0]", scale=2)["ok"]
    assert agent.told("measure", session=session, a="cup[0]")["boxes"][0]["box"] == [[-1, -0.5, -1], [1, 2.5, 1]]
    assert agent.told("edit_part", session=session, path="cup[0]", rotate=90, axis="x")["ok"]
    assert agent.told("measure", session=session, a="cup[0]")["boxes"][0]["size"] == pytest.approx([2, 2, 3])
    assert agent.told("edit_part", session=session, path="cup[1]", form='(call "cone")')["ok"]
    assert agent.told("count", session=session)["counts"]["cup"] == 1
    assert "three numbers" in agent.refused("edit_part", session=session, path="cup", scale=[1, 2])
    assert "expected one of" in agent.refused("edit_part", session=session, path="cup", scale=[1], rotate=3)
    assert agent.told("undo", session=session, steps=9)["steps"] == 4
    agent.told("close", session=session, discard=True)


@pytest.mark.skipif(find_spec("mujoco") is None, reason="needs scenelang[physics]")
def test_parts_of_programs_with_imports_are_edited_and_repaired(agent: Any) -> None:
    """The procedural macros that an import may bring are tried where no process can be started."""
    lifted = '(bind "room" (lambda () (union (call "cup") (transform (call "cup") (translate [3 1 0])))))'
    session = agent.told("open", program=f'(import "std/kitchen.scene")\n{lifted}')["session"]
    said = text(agent.call("edit_part", session=session, path="cup[1]", move=[1, 0, 0]))
    assert "(translate [4 1 0])" in said
    assert "nothing to repair" in text(agent.call("repair", session=session))


def test_a_scene_settles(agent: Any) -> None:
    session = opened(agent, DROP)
    settled = agent.call("settle", session=session)
    assert settled.structured_content["moved"] == 1, text(settled)
    assert "room/box falls" in text(settled) or "moved: " in text(settled)
    low = agent.told("measure", session=session, a="box")["boxes"][0]["box"][0][1]
    assert low == pytest.approx(0, abs=0.01)
    assert "everything rests" in text(agent.call("settle", session=session))
    assert agent.told("undo", session=session)["steps"] == 1
    agent.told("close", session=session, discard=True)
    film = opened(agent, FILM)
    assert "do not come to rest" in agent.refused("settle", session=film)
    assert "`seconds`" in agent.refused("settle", session=film, seconds=1e9)
    agent.told("close", session=film, discard=True)


def test_settling_without_the_extra_is_one_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    import sys

    from scenelang.interpreter.values.limits import Limits
    from scenelang.mcp.tools import Project, ProjectProgram, WrongArguments
    from scenelang.mcp.workbench import settle

    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(WrongArguments, match=r"pip install 'scenelang\[physics\]'") as error:
        settle(Project(tmp_path, Limits()), ProjectProgram(DROP), 1.0)
    assert error.value.name == "backend"
    assert "\n" not in str(error.value)


def test_a_strip_of_a_film(agent: Any) -> None:
    session = opened(agent, FILM)
    five = agent.call("strip", session=session, side=64)
    assert "frames 0, 2, 5, 8, 10 of 0 to 10" in text(five)
    sheet = picture(five)
    assert sheet.size == (5 * 64, 64 + 14)
    cells = {sheet.crop((64 * k, 14, 64 * k + 64, 78)).tobytes() for k in range(5)}
    assert len(cells) == 5
    assert picture(agent.call("strip", session=session, frames=[3, 4, 1], side=512)).width == 3 * 512
    assert picture(agent.call("strip", session=session, count=8, side=512)).width == 2048
    assert "frame 11 does not exist" in agent.refused("strip", session=session, frames=[0, 1, 11])
    for wrong in ({"count": 2}, {"count": 9}, {"frames": [1, 2]}, {"frames": [1] * 9}, {"side": 5_000}):
        agent.refused("strip", session=session, **wrong)
    agent.told("close", session=session, discard=True)
    still = opened(agent, ROOM)
    assert "call `views`" in agent.refused("strip", session=still)
    agent.told("close", session=still, discard=True)
