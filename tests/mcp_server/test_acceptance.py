"""Acceptance: declarations of a session, tested at every change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from mcp_server.conftest import ROOM


def text(result: Any) -> str:
    return "\n".join(content.text for content in result.content if content.type == "text")


THAT = [
    '(count "chair" 2)',
    '(count "cup" 1)',
    '(on "cup" "chair" :any)',
    '(size "chair" :axis "y" :min 1 :max 1.2)',
    '(distance "chair[0]" "chair[1]" 2 :within .2)',
]


@pytest.fixture
def chairs(agent: Any) -> Any:
    name = agent.told("open", program=ROOM)["session"]
    yield name
    agent.call("close", session=name, discard=True)


def test_every_change_is_tested(agent: Any, chairs: str) -> None:
    accepted = agent.call("accept", session=chairs, that=THAT[:2] + THAT[3:4] + ['(on "cup" "chair")'])
    assert accepted.structured_content["ok"], text(accepted)
    assert accepted.structured_content["acceptance"]["hold"] == 3
    assert 'acceptance: 3 of 4 hold\nfails: (on "cup" "chair")' in text(accepted)
    assert len(text(accepted)) < 2_000
    checked = agent.told("check", session=chairs)
    assert [each["name"] for each in checked["diagnostics"]] == ["declaration"]
    repaired = agent.told("repair", session=chairs, geometry=False)
    assert repaired["acceptance"] == {"declared": 4, "hold": 4, "tested": True, "fails": []}
    broken = agent.call("replace", session=chairs, old='(call "cup")', new='(call "cap")')
    assert broken.structured_content["acceptance"]["hold"] == 2
    assert text(broken).count("\nfails: ") == 2
    wrong = agent.call("replace", session=chairs, old='(call "cap")', new='(call "cap"')
    assert "acceptance: none of 4 can be tested" in text(wrong)
    assert agent.told("undo", session=chairs, steps=2)["acceptance"]["hold"] == 4
    assert "acceptance" not in agent.told("accept", session=chairs, that=[])
    assert "acceptance" not in agent.told("redo", session=chairs)


@pytest.mark.parametrize(
    ("that", "part"),
    [
        (['(on "cup"'], ""),
        (['(near "cup" "chair")'], ""),
        (["(error 1)"], ""),
        (["#t"], ""),
        (['(count "cup" 1)', '(count "cup" 2)'], "contradict each other"),
        (['(on "cup" "chair")', '(on "chair" "cup")'], "a cycle of what is on what"),
        (['(count "cup" :max 5)'], "an empty scene fulfills all declarations"),
        (['(count "cup" 1)'], "all lengths times ten"),
    ],
)
def test_declarations_that_are_refused(agent: Any, chairs: str, that: list[str], part: str) -> None:
    said = agent.call("accept", session=chairs, that=that)
    assert said.structured_content["ok"] is False, text(said)
    assert text(said).startswith("error[E")
    assert part in text(said)
    assert "acceptance" not in agent.told("edit", session=chairs, line=1, text="; a room\n")


def test_an_empty_session_has_acceptance_before_its_scene(agent: Any) -> None:
    session = agent.told("open")["session"]
    assert "can be tested" in text(agent.call("accept", session=session, that=THAT))
    assert "contradict" in text(agent.call("accept", session=session, that=[THAT[0], '(count "chair" 3)']))
    assert agent.told("edit", session=session, line=1, text=ROOM)["acceptance"]["declared"] == 5
    agent.told("close", session=session, discard=True)


@pytest.mark.parametrize(
    ("that", "part"),
    [(['(count "a" 1)'] * 51, "`that`"), (["x" * 1_001], "`that.0` exceeds"), ("x", "`that`"), (None, "`that`")],
)
def test_calls_that_make_no_sense(agent: Any, chairs: str, that: Any, part: str) -> None:
    assert part in agent.refused("accept", session=chairs, that=that)


def test_a_word_that_does_not_occur_is_what_fails(agent: Any, chairs: str) -> None:
    said = text(agent.call("accept", session=chairs, that=[*THAT[:2], *THAT[3:], '(on "spoon" "chair")']))
    assert "says nothing" not in said
    assert '"spoon" does not occur' in said


def test_a_saved_scene_states_its_acceptance_and_keeps_it(serve: Callable[..., Any]) -> None:
    """Opened again, the declarations are the session's, and each edit is tested against them."""
    with serve() as agent:
        session = agent.told("open", program=ROOM)["session"]
        agent.told("accept", session=session, that=["(assert-that\n" + THAT[0] + ")", THAT[1], *THAT[3:]])
        agent.told("save", session=session, path="room.scene")
        assert agent.told("diff", session=session)["unsaved"] is False
        agent.told("close", session=session)
        opened = agent.told("open", path="room.scene")
        assert opened["acceptance"]["declared"] == 4
        assert opened["unsaved"] is False
        before = opened["acceptance"]["hold"]
        moved = agent.told("replace", session=opened["session"], old="[3 0 0]", new="[3 9 0]")
        assert moved["acceptance"]["hold"] < before
        agent.told("close", session=opened["session"], discard=True)


def test_acceptance_survives(serve: Callable[..., Any]) -> None:
    with serve() as agent:
        agent.told("open", program=ROOM)
        agent.told("accept", session="s1", that=THAT[:1] + THAT[3:])
    with serve() as agent:
        assert "s1  no file  unsaved  3 declarations" in text(agent.call("sessions"))
        assert agent.told("replace", session="s1", old="[3 0 0]", new="[4 0 0]")["acceptance"]["hold"] == 2
