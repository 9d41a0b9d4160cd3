"""What each tool answers."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest
from PIL import Image

from scenelang.api import check
from scenelang.mcp.tools import primer_text

if TYPE_CHECKING:
    from mcp.types import CallToolResult

CUBE = '(bind "a" (lambda () (call "cube")))'
MOVED = '(bind "a" (lambda () (transform (call "cube") (translate [1 0 0]))))'
FILM = '(bind "a" (lambda () (frames (for/list ((i 3)) (union (transform (call "cube") (translate [i 0 0])))))))'
PYTHON = """Here it is:
```python
@register()
def scene() -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (1, 1, 1)}, color=(1, 0, 0))
```
"""


def text(result: CallToolResult) -> str:
    (said,) = (content.text for content in result.content if content.type == "text")
    return said


def picture(result: CallToolResult) -> Any:
    """The picture of an answer, decoded."""
    assert not result.is_error, text(result)
    (image,) = (content for content in result.content if content.type == "image")
    assert image.mime_type == "image/png"
    return Image.open(io.BytesIO(base64.b64decode(image.data)))


LOOK = {
    "check", "run", "count", "diff", "render", "views", "strip", "compare", "help", "search", "query", "measure", "relations", "read",
    "sessions",
}  # fmt: skip
WORK = {"accept", "open", "transpile", "close", "edit", "replace", "edit_part", "repair", "settle", "undo", "redo"}


def test_tools_say_what_they_do(agent: Any) -> None:
    tools = agent.portal.call(agent.session.list_tools).tools
    assert {tool.name for tool in tools} == LOOK | WORK | {"save", "export"}
    for tool in tools:
        assert tool.description
        assert tool.annotations.read_only_hint == (tool.name in LOOK)
        assert tool.annotations.destructive_hint == (tool.name in ("save", "export"))
        assert all(each.get("description") for each in tool.input_schema["properties"].values()), tool.name


def test_an_agent_mends_a_program_and_looks_at_it(agent: Any) -> None:
    wrong = CUBE.replace('(call "cube")', '(call "cube" :scale (twice 2))')
    found = agent.told("check", program=wrong)
    assert not found["ok"]
    assert [(d["code"], d["place"]["line"]) for d in found["diagnostics"]] == [("E301", 1)]
    assert "`twice` is not defined" in text(agent.call("check", program=wrong))
    right = wrong.replace("(twice 2)", "(* 2 2)")
    assert agent.told("check", program=right) == {"ok": True, "diagnostics": []}
    facts = agent.told("run", program=right)
    assert (facts["root"], facts["primitives"], facts["bounds"]["max"]) == ("a", 1, [2.0, 2.0, 2.0])
    drawn = picture(agent.call("render", program=right, width=64, height=48))
    assert drawn.size == (64, 48)
    assert len(drawn.getcolors(64 * 48)) > 20
    assert agent.told("diff", program_a=right, program_b=MOVED)["equal"] is False


def test_check_of_the_geometry(agent: Any) -> None:
    twice = '(bind "a" (lambda () (union (call "cube") (call "cube"))))'
    assert agent.told("check", program=twice)["diagnostics"] == []
    found = agent.told("check", program=twice, geometry=True)
    assert found["ok"]
    assert [d["code"][0] for d in found["diagnostics"]] == ["W"]


def test_run_tells_what_was_printed_and_of_frames(agent: Any) -> None:
    facts = agent.told("run", program=FILM)
    assert (facts["frames"], facts["primitives"], facts["bounds"]["max"]) == (3, 3, [2.5, 0.5, 0.5])
    said = agent.told("run", program=f'(print "\x1b[31mhello") {CUBE}')
    assert said["log"] == ["\\x1b;[31mhello"]


def test_a_models_python_is_a_program(agent: Any) -> None:
    assert agent.told("run", program=PYTHON)["primitives"] == 1


def test_a_word_of_ones_own_choice(agent: Any) -> None:
    program = f'{CUBE} (bind "b" (lambda () (union (call "a") (call "sphere"))))'
    assert agent.told("count", program=program)["counts"] == {"b": 1, "a": 1, "cube": 1, "sphere": 1}
    assert agent.told("count", program=program, root="a")["counts"] == {"a": 1, "cube": 1}


def test_a_frame_is_counted_and_drawn(agent: Any) -> None:
    assert agent.told("count", program=FILM, frame=2) == {"ok": True, "frame": 2, "counts": {"a": 1, "cube": 1}}
    first, last = (agent.call("render", program=FILM, frame=n, width=32, height=32) for n in (0, 2))
    assert picture(first).tobytes() != picture(last).tobytes()
    assert "frame 2 of 3" in text(last)
    for tool in ("count", "render"):
        assert "frame 3 does not exist" in agent.refused(tool, program=FILM, frame=3)


def test_a_picture_from_another_side(agent: Any) -> None:
    program = '(bind "a" (lambda () (call "cube" :scale [1 2 3])))'
    seen = [
        picture(agent.call("render", program=program, camera=c, width=32, height=32)) for c in ("top", "azimuth=90")
    ]
    assert seen[0].tobytes() != seen[1].tobytes()
    assert "did you mean `azimuth`?" in agent.refused("render", program=program, camera="azimut=3")


def test_a_scene_that_cannot_be_drawn_is_diagnosed(agent: Any) -> None:
    found = agent.told("render", program='(bind "a" (lambda () (union)))')
    assert [d["name"] for d in found["diagnostics"]] == ["empty-scene"]


def test_diff_names_what_moved(agent: Any) -> None:
    found = agent.told("diff", program_a=CUBE, program_b=MOVED)
    assert (found["moved"], found["missing"], found["extra"]) == (1, 0, 0)
    assert found["changes"][0]["b"]["at"] == [1.0, 0.0, 0.0]
    assert agent.told("diff", program_a=CUBE, program_b=CUBE)["equal"]
    wrong = agent.told("diff", program_a=CUBE, program_b="(")
    assert (wrong["ok"], wrong["side"]) == (False, "b")
    assert "scene B" in agent.refused("diff", program_a=CUBE)


def test_files_of_the_project(agent: Any) -> None:
    (agent.project / "parts").mkdir()
    (agent.project / "parts" / "a.scene").write_text(CUBE)
    (agent.project / "b.scene").write_text('(import "parts/a.scene") (bind "b" (lambda () (call "a")))')
    assert agent.told("run", path="b.scene")["root"] == "b"
    assert agent.told("run", path=str(agent.project / "b.scene"))["root"] == "b"
    assert agent.told("run", program='(import "parts/a.scene") (bind "c" (lambda () (call "a")))')["primitives"] == 1
    assert agent.told("diff", path_a="b.scene", program_b=MOVED)["moved"] == 1
    (agent.project / "parts" / "wrong.scene").write_text("(foo)")
    (found,) = agent.told("check", path="parts/wrong.scene")["diagnostics"]
    assert found["place"]["file"] == "parts/wrong.scene"


@pytest.mark.parametrize(
    ("name", "part"),
    [("translate", "(translate"), ("union", "members"), ("cube", ":scale"), ("facing", "(assert-that (facing A B"), (":color", "read by"), ("E401", "type"),
     ("", "# The Scene Language")],
)  # fmt: skip
def test_help(agent: Any, name: str, part: str) -> None:
    result = agent.call("help", name=name)
    assert not result.is_error
    assert part in text(result)


def test_help_on_nothing_known(agent: Any) -> None:
    assert "did you mean `translate`?" in agent.refused("help", name="translat")


def test_the_primer_is_a_resource_whose_program_is_right(agent: Any) -> None:
    (content,) = agent.portal.call(agent.session.read_resource, "scenelang://primer").contents
    assert content.text == primer_text()
    program = content.text.split("```scene\n")[1].split("```")[0]
    assert check(program).diagnostics == ()
    assert "(union-loop count" in content.text


def test_limits_come_from_the_command_line(serve: Callable[..., Any]) -> None:
    with serve("--max-steps", "10k", "--max-seconds", "5") as agent:
        loop = f"(define (f) (f)) (f) {CUBE}"
        found = agent.told("run", program=loop)
        assert [d["name"] for d in found["diagnostics"] if d["severity"] == "error"] == ["steps"]
        assert agent.told("run", program=CUBE)["ok"]
