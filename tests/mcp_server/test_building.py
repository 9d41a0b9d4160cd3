"""A room built in 16 steps, with a server that is started anew in the middle, and floods of sessions."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import scenelang as sl
from scenelang.mcp.session_files import FOLDER

THAT = [
    '(count "table" 1)',
    '(count "chair" 2)',
    '(count "cup" 2)',
    '(on "cup" "table")',
    '(on "table" "floor")',
    '(on "chair" "floor")',
    '(size "table" :axis "y" :min .7 :max .8)',
    '(left-of "chair[0]" "table")',
    '(right-of "chair[1]" "table")',
    '(clear-of "chair" "table")',
    '(has-color "cup" "red")',
]
FLOOR = '(bind "floor" (lambda () (call "cube" :scale [4 .1 4])))\n'
TABLE = '(bind "table" (lambda () (call "cube" :scale [1 .75 1] :color [.5 .3 .1])))\n'
CHAIR = '(bind "chair" (lambda () (call "cube" :scale [.4 .5 .4] :color [.2 .2 .6])))\n'
CUP = """(bind "cup" (lambda () (union (call "cylinder" :radius .05 :p0 [0 0 0] :p1 [0 .1 0] :color [0 0 1])
  (transform (call "cube" :scale .04 :color [0 1 0]) (translate [.06 .05 0])))))
"""
WHOLE = """(bind "room" (lambda () (union
  (transform (call "floor") (translate [0 -.05 0]))
  (transform (call "table") (translate [0 .375 0])))))
"""


def text(result: Any) -> str:
    return "\n".join(content.text for content in result.content if content.type == "text")


def add(agent: Any, form: str) -> dict[str, Any]:
    """Adds a part to the room, before the table."""
    old = '(transform (call "table")'
    answer: dict[str, Any] = agent.told("replace", session="s1", old=old, new=f"{form}\n  {old}")
    return answer


def test_a_room_in_sixteen_steps(serve: Callable[..., Any]) -> None:
    with serve() as agent:
        assert agent.told("open")["session"] == "s1"  # 1
        assert agent.told("accept", session="s1", that=THAT)["acceptance"]["declared"] == len(THAT)  # 2
        for number, part in enumerate((FLOOR, TABLE, CHAIR, CUP), 1):  # 3 to 6
            assert agent.told("edit", session="s1", line=_end(agent), text=part)["version"] == number
        held = agent.told("edit", session="s1", line=_end(agent), text=WHOLE)["acceptance"]["hold"]  # 7
        more = add(agent, '(transform (call "chair") (translate [-1 .25 0]))')["acceptance"]["hold"]  # 8
        assert 3 <= held < more
    with serve() as agent:
        assert text(agent.call("sessions")) == f"s1  no file  unsaved  {len(THAT)} declarations"
        added = add(agent, '(transform (call "chair") (translate [1 .25 0]))')  # 9
        assert added["version"] == 7
        assert added["acceptance"]["hold"] >= more
        add(agent, '(transform (call "cup") (translate [.2 .9 0]))')  # 10
        add(agent, '(transform (call "cup") (translate [-.2 .75 0]))')  # 11
        red = agent.told("edit_part", session="s1", path="cup", recolor="[1 0 0]")  # 12
        assert red["acceptance"]["hold"] == len(THAT) - 1
        worse = agent.told("edit_part", session="s1", path="chair[1]", move=[-0.7, 0, 0])  # 13
        assert worse["acceptance"]["hold"] < red["acceptance"]["hold"]
        assert agent.told("undo", session="s1")["acceptance"] == red["acceptance"]  # 14
        repaired = agent.told("repair", session="s1", geometry=False)  # 15
        assert repaired["acceptance"] == {"declared": len(THAT), "hold": len(THAT), "tested": True, "fails": []}
        assert agent.told("accept", session="s1", that=THAT)["ok"]  # it says something about the scene
        agent.told("save", session="s1", path="room.scene")  # 16
        saved = sl.load(agent.project / "room.scene")
        assert [saved.violations(that) for that in THAT] == [[]] * len(THAT)
        agent.told("close", session="s1")
        assert os.listdir(agent.project / FOLDER) == []


def _end(agent: Any) -> int:
    """The line after the last one of the program."""
    return int(agent.told("read", session="s1")["lines"]) + 1


def test_floods_of_sessions(serve: Callable[..., Any]) -> None:
    with serve() as agent:
        answers = agent.at_once(*[("open", {"program": f"; {number}"}) for number in range(40)])
        assert sum(not answer.is_error for answer in answers) == 16
        assert all("16 sessions are open" in text(answer) for answer in answers if answer.is_error)
        assert len(os.listdir(agent.project / FOLDER)) == 16
        for _ in range(3):
            agent.at_once(*[("edit", {"session": "s1", "line": 1, "text": "; more\n"})] * 10)
        assert len(os.listdir(agent.project / FOLDER)) == 16
    with serve() as agent:
        assert len(agent.told("sessions")["sessions"]) == 16
        assert agent.told("undo", session="s1", steps=200)["steps"] == 30
