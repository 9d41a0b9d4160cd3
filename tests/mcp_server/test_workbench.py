"""An agent works: sessions, edits, measures, pictures, files, by the real client over standard input and output."""

from __future__ import annotations

import base64
import io
import json
import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from mcp_server.conftest import ROOM
from PIL import Image

import scenelang as sl

WRONG = ROOM.replace("(transform (call \"cube\"", "(transfrom (call \"cube\"").replace("1.4 0]", "1.4 O]").replace(
    ":color", ":colr"
)  # fmt: skip


def text(result: Any) -> str:
    return "\n".join(content.text for content in result.content if content.type == "text")


def size(result: Any) -> int:
    """Bytes of an answer without its pictures."""
    return len(text(result).encode()) + len(json.dumps(result.structured_content or {}).encode())


def picture(result: Any) -> Any:
    assert not result.is_error, text(result)
    (image,) = (content for content in result.content if content.type == "image")
    return Image.open(io.BytesIO(base64.b64decode(image.data)))


@pytest.mark.slow  # loads torch
def test_a_score_needs_a_model(agent: Any, room: str) -> None:
    Image.new("RGB", (200, 100), "red").save(agent.project / "scored.png")
    said = text(agent.call("compare", session=room, reference="scored.png", score=True))
    assert "no score" in said or "similarity" in said


@pytest.fixture
def room(agent: Any) -> Iterator[str]:
    """A session with a room."""
    name = agent.told("open", program=ROOM)["session"]
    yield name
    agent.call("close", session=name, discard=True)


def test_from_nothing_to_a_saved_and_exported_scene(agent: Any) -> None:
    answers: list[Any] = []

    def told(tool: str, **arguments: Any) -> dict[str, Any]:
        answers.append(agent.call(tool, **arguments))
        assert not answers[-1].is_error, text(answers[-1])
        data: dict[str, Any] = answers[-1].structured_content
        return data

    told("search", query="move a part")
    assert "(translate" in text(answers[-1])
    session = told("open")["session"]
    assert told("edit", session=session, line=1, text=WRONG)["errors"] == 2
    for _ in range(3):  # three fixes by span, as the diagnostics say
        found = told("check", session=session)["diagnostics"][0]
        fix = {"transfrom": "transform", "O": "0", ":colr": ":color"}
        place = {key: found["place"][key] for key in ("line", "column", "end_line", "end_column")}
        old = WRONG.splitlines()[place["line"] - 1][place["column"] - 1 : place["end_column"] - 1]
        told("edit", session=session, text=fix[old], old=old, **place)
    assert told("check", session=session) == {"ok": True, "diagnostics": []}
    assert told("measure", session=session, a="cup", b="chair[0]")["distance"] == pytest.approx(0.3)
    that = '(on "cup" "chair")'
    assert told("measure", session=session, that=[that])["fails"][0]["move"] == pytest.approx([0, -0.3, 0])
    told("replace", session=session, old="[0 1.4 0]", new="[0 14 0]")
    assert told("undo", session=session)["steps"] == 1
    assert [edit["new"] for edit in told("repair", session=session, that=[that])["edits"]] == ["1.1"]
    assert told("measure", session=session, that=[that])["holds"] == [that]
    assert told("save", session=session, path="room.scene")["unsaved"] is False
    assert told("export", session=session, path="room.glb")["files"] == ["room.glb"]
    assert max(map(size, answers)) < 4_096
    saved = sl.load(agent.project / "room.scene")
    assert saved.violations(that) == []
    assert len(saved.flatten()) == 11
    assert (agent.project / "room.glb").read_bytes()[:4] == b"glTF"
    agent.call("close", session=session)


def test_edits_of_text(agent: Any, room: str) -> None:
    assert agent.told("edit", session=room, start=0, old="(bind", text="(bind")["version"] == 0  # nothing changed
    assert agent.told("edit", session=room, line=1, column=1, text="; a room\n")["version"] == 1
    assert agent.told("edit", session=room, start=0, end=9, text="")["version"] == 2
    assert agent.told("replace", session=room, old='(call "chair")', new='(call "leg")', every=True)["replaced"] == 2
    assert agent.told("run", session=room)["primitives"] == 3
    assert agent.told("undo", session=room, steps=9)["steps"] == 3
    assert agent.told("undo", session=room)["steps"] == 0
    assert agent.told("redo", session=room, steps=9)["steps"] == 3
    assert agent.told("undo", session=room)["errors"] == 0
    assert agent.told("run", session=room)["primitives"] == 11


@pytest.mark.parametrize(
    ("tool", "arguments", "part"),
    [
        ("edit", {"text": "x"}, "expected either `line`"),
        ("edit", {"text": "x", "line": 1, "start": 0}, "expected either `line`"),
        ("edit", {"text": "x", "line": 99}, "line 99 does not exist"),
        ("edit", {"text": "x", "line": 1, "column": 500}, "column 500 does not exist"),
        ("edit", {"text": "x", "line": 3, "end_line": 2, "end_column": 1}, "is no range"),
        ("edit", {"text": "x", "line": 1, "end_line": 2}, "needs `end_column`"),
        ("edit", {"text": "x", "start": 5, "end": 2}, "is no range"),
        ("edit", {"text": "x", "start": 9_999_999}, "is no range"),
        ("edit", {"text": "x", "line": -1}, "`line`"),
        ("edit", {"text": "x", "line": 1, "old": "nothing"}, "`old` differs"),
        ("edit", {"text": "x" * 1_000_001, "line": 1}, "1,000,000"),
        ("replace", {"old": "call", "new": "x"}, "occurs 7 times (lines 1, 6, 7, 8, 11)"),
        ("replace", {"old": "(call  \"leg\")", "new": "x"}, "does not occur"),
        ("replace", {"old": "", "new": "x"}, "is empty"),
        ("replace", {"old": "a", "new": "x" * 900_000, "every": True}, "would exceed"),
        ("undo", {"steps": 0}, "`steps`"),
        ("read", {"first": 99}, "line 99 does not exist"),
        ("edit_part", {"path": "chair[0]"}, "expected one of `move`"),
        ("edit_part", {"path": "chair[0]", "move": [1, 2]}, "`move`"),
        ("edit_part", {"path": "x" * 5_000, "remove": True}, "exceeds 4,000"),
        ("edit_part", {"path": "chair[0]", "attribute": "color", "value": "1) (x"}, "must be one form"),
        ("views", {"overlay": "heat"}, "`overlay`"),
        ("views", {"cameras": ["azimut=3"]}, "did you mean `azimuth`?"),
        ("views", {"cameras": ["top"] * 7}, "`cameras`"),
        ("views", {"side": 5000}, "`side`"),
        ("measure", {"that": ["(on"] * 51}, "`that`"),
        ("compare", {"reference": "nothing.png"}, "no file"),
        ("compare", {"reference": "/etc/passwd"}, "outside the project folder"),
        ("repair", {"effort": 1e9}, "`effort`"),
        ("search", {"query": "x" * 501}, "`query`"),
    ],
)  # fmt: skip
@pytest.mark.sampled(3)
def test_calls_that_make_no_sense_are_one_line_with_a_code(
    agent: Any, room: str, tool: str, arguments: dict[str, Any], part: str
) -> None:
    if tool != "search":
        arguments = {"session": room, **arguments}
    said = agent.refused(tool, **arguments)
    assert said.startswith("error[E")
    assert part in said
    assert agent.told("sessions")["sessions"][-1]["version"] == 0


def test_long_programs_are_read_in_pieces_and_searched_quickly(agent: Any) -> None:
    program = "".join(f"; line {number} \x0c with \u2028 marks {'-' * 60}\n" for number in range(1, 5_001)) + ROOM
    session = agent.told("open", program=program + "; " + "x" * 200_000)["session"]
    first = text(agent.call("read", session=session)).splitlines()
    assert first[-1].startswith("... and 4,")
    following = int(first[-1].rsplit(" ", 1)[1])
    second = text(agent.call("read", session=session, first=following))
    assert second.lstrip().startswith(f"{following}  ; line {following} ")
    assert "does not occur" in agent.refused("replace", session=session, old="x" * 300_000, new="")
    assert 'the nearest line is `(bind "cup"' in agent.refused(
        "replace",
        session=agent.told("open", program=ROOM)["session"],
        old=ROOM.splitlines()[7].replace("cup", "mug"),
        new="",
    )
    agent.told("close", session=session, discard=True)


def test_sessions_that_do_not_exist(agent: Any, room: str) -> None:
    for tool in ("check", "run", "count", "render", "views", "query", "relations", "undo", "save", "repair"):
        assert "no session `s0`" in agent.refused(tool, session="s0")
    assert "expected one of" in agent.refused("run", session=room, program=ROOM)


@pytest.mark.slow
def test_there_are_limits_on_sessions(serve: Callable[..., Any]) -> None:
    with serve() as agent:
        for _ in range(16):
            agent.told("open")
        assert "16 sessions are open" in agent.refused("open")
        agent.told("close", session="s3")
        assert agent.told("open")["session"] == "s17"


def test_edits_at_a_path(agent: Any, room: str) -> None:
    said = agent.call("edit_part", session=room, path="chair[1]", move=[0, 0, 1])
    assert "(translate [3 0 1])) (1 instance, nothing else changes)" in text(said)
    found = agent.told("edit_part", session=room, path="chair[1]/leg[2]", move=[0, 0, 1])
    assert (found["version"], found["others"]) == (2, 0)  # an exception
    shared = agent.told("edit_part", session=room, path="chair[1]/leg[2]", move=[0, 0, 1], shared=True)
    assert (shared["version"], shared["others"]) == (3, 3)  # the legs that have its number
    assert (
        agent.told("edit_part", session=room, path="cup/cylinder", attribute="color", value="[0 0 1]")["version"] == 4
    )
    assert agent.told("edit_part", session=room, path="cup", remove=True)["version"] == 5
    assert "cup" not in agent.told("count", session=room)["counts"]
    assert agent.told("undo", session=room, steps=5)["steps"] == 5


def test_a_slow_edit_does_not_undo_what_happens_meanwhile(agent: Any, room: str) -> None:
    slow = ("repair", {"session": room, "that": ['(on "cup" "chair")']})
    quick = ("replace", {"session": room, "old": "[1 0 0]", "new": "[0 1 0]"})
    answers = agent.at_once(slow, quick)
    if answers[0].is_error:
        assert "was changed while" in text(answers[0])
    assert "[0 1 0]" in text(agent.call("read", session=room))


def test_query_by_path_and_relations(agent: Any, room: str) -> None:
    found = agent.told("query", session=room, path="chair/leg[2]")
    assert [each["path"] for each in found["instances"]] == ["chair[0]/leg[2]", "chair[1]/leg[2]"]
    assert found["instances"][0]["box"] == [[0.35, 0.0, -0.45], [0.45, 1.0, -0.35]]
    assert found["instances"][0]["defined"]["line"] == 1
    assert agent.told("query", session=room)["count"] == 3
    assert "did you mean `chair`?" in text(agent.call("query", session=room, path="chiar"))
    assert agent.told("relations", session=room)["relations"] == []
    agent.told("replace", session=room, old="1.4", new="1.1")
    assert agent.told("relations", session=room)["relations"] == [["cup", "z22", "on", "chair", "z2"]]


def test_measures(agent: Any, room: str) -> None:
    assert agent.told("measure", session=room)["boxes"][0]["size"] == [4, 1.6, 1]
    one = agent.told("measure", session=room, a="chair[0]/leg")
    assert (len(one["boxes"]), one["volume"]) == (4, pytest.approx(0.04))
    assert '(symmetric "chair[0]/leg")' in one["holds"]
    two = agent.told("measure", session=room, a="cup", b="chair[1]")
    assert two["nearest"] == ["cup", "chair[1]"]
    assert '(left-of "cup" "chair[1]")' in two["holds"]
    agent.told("replace", session=room, old="[3 0 0]", new="[.5 0 0]")
    assert agent.told("measure", session=room, a="chair[0]", b="chair[1]")["distance"] == pytest.approx(-0.5, abs=0.45)
    assert not agent.told("measure", session=room, a="chair", b="stool")["ok"]
    assert not agent.told("measure", session=room, that=["(near 1 2)"])["ok"]


def test_views_with_overlays(agent: Any, room: str) -> None:
    seen = {}
    for overlay in ("none", "word", "instance", "depth"):
        result = agent.call("views", session=room, overlay=overlay, side=48, cameras=["isometric"])
        seen[overlay] = picture(result).convert("RGB")
        said = text(result)
        if overlay == "word":
            color = next(line.split("#")[1] for line in said.splitlines() if line.startswith("cup"))
            legend = tuple(int(color[k : k + 2], 16) for k in (0, 2, 4))
            assert legend in {pixel for _, pixel in seen[overlay].getcolors(1 << 16)}
    assert len({image.crop((0, 14, 48, 62)).tobytes() for image in seen.values()}) == 4
    part = agent.call("views", session=room, overlay="instance", side=32, part="chair[1]")
    assert "chair[1]/leg[3] #" in text(part)
    assert "chair[0]" not in text(part)
    assert picture(part).width == 64


def test_a_picture_of_one_part(agent: Any, room: str) -> None:
    whole, part = (
        picture(agent.call("render", session=room, width=32, height=32, part=part)) for part in ("", "chair[0]/leg[1]")
    )
    assert whole.tobytes() != part.tobytes()
    assert not agent.told("render", session=room, part="stool")["ok"]


def test_comparing_with_a_reference(agent: Any, room: str) -> None:
    Image.new("RGB", (20, 60), "red").save(agent.project / "reference.png")
    result = agent.call("compare", session=room, reference="reference.png")
    sheet = picture(result)
    assert sheet.size == (256, 384)
    assert sheet.convert("RGB").getpixel((100, 100)) == (255, 0, 0)
    (agent.project / "broken.png").write_bytes(b"no picture")
    assert "cannot read" in agent.refused("compare", session=room, reference="broken.png")


def test_diff_with_the_saved_version(agent: Any) -> None:
    (agent.project / "own.scene").write_text(ROOM)
    session = agent.told("open", path="own.scene")["session"]
    assert text(agent.call("diff", session=session)) == "nothing changed"
    agent.told("replace", session=session, old="[3 0 0]", new="[4 0 0]")
    result = agent.call("diff", session=session)
    assert '+      (transform (call "chair") (translate [4 0 0]))' in text(result)
    assert result.structured_content["moved"] == 5
    assert agent.told("diff", session=session, path_a="own.scene")["moved"] == 5
    assert agent.told("save", session=session)["path"] == "own.scene"  # its own file needs no `overwrite`
    agent.told("replace", session=session, old="[4 0 0]", new="[5 0 0]")
    (agent.project / "own.scene").write_text("; of another")
    assert "was changed since" in agent.refused("save", session=session)
    assert "is not saved" in agent.refused("close", session=session)
    (agent.project / "own.scene").unlink()
    os.mkfifo(agent.project / "own.scene")
    assert "special file" in agent.refused("save", session=session)
    (agent.project / "own.scene").unlink()
    assert agent.told("save", session=session, overwrite=True)["unsaved"] is False
    agent.told("close", session=session)


def test_python_becomes_a_session(agent: Any) -> None:
    python = "@register()\ndef scene() -> Shape:\n    return primitive_call('cube', color=(1, 0, 0), shape_kwargs={'scale': 1})\n"
    for tool in ("open", "transpile"):
        session = agent.told(tool, program=python)["session"]
        assert '(call "cube"' in text(agent.call("read", session=session))
        agent.told("close", session=session, discard=True)
    assert not agent.told("transpile", program="@register()\ndef scene(:\n")["ok"]


@pytest.mark.parametrize(
    "path",
    ["../out.scene", "/tmp/out.scene", "sub/../../out.scene", "a.txt", "a.scene.txt", ".hidden.scene", ".git/a.scene", "",
     "nowhere/a.scene", "link.scene", "linked/a.scene", "folder.scene", "pipe.scene", "hard.scene", "there.scene", "a\0.scene",
     "\x1b[31m.scene", "x" * 300 + ".scene", "there.scene/a.scene", "x" * 5_000],
)  # fmt: skip
@pytest.mark.sampled(3)
def test_files_that_are_not_written(agent: Any, room: str, path: str) -> None:
    project, outside = agent.project, agent.project.parent
    (outside / "target").mkdir(exist_ok=True)
    (project / "folder.scene").mkdir(exist_ok=True)
    (project / "there.scene").write_text("; there")
    (outside / "target" / "secret.scene").write_text("; secret")
    for link, target in (("link.scene", "../target/secret.scene"), ("linked", "../target")):
        if not os.path.lexists(project / link):
            (project / link).symlink_to(target)
    if not (project / "pipe.scene").exists():
        os.mkfifo(project / "pipe.scene")
        os.link(outside / "target" / "secret.scene", project / "hard.scene")
    for overwrite in (False, True):
        if path == "there.scene" and overwrite:
            continue
        said = agent.refused("save", session=room, path=path, overwrite=overwrite)
        assert said.startswith("error[E")
        if not (project / path.replace("\0", "")[:100]).exists() or path.startswith("/"):
            said = agent.refused("export", session=room, path=path.replace(".scene", ".glb") or path)
            assert said.startswith("error[E")
    assert (project / "there.scene").read_text() == "; there"
    assert os.listdir(outside / "target") == ["secret.scene"]
    assert (outside / "target" / "secret.scene").read_text() == "; secret"


def test_an_export_replaces_only_when_asked_and_writes_all_or_nothing(agent: Any, room: str) -> None:
    assert agent.told("export", session=room, path="whole.obj")["files"] == ["whole.mtl", "whole.obj"]
    assert "exists" in agent.refused("export", session=room, path="whole.obj")
    assert agent.told("export", session=room, path="whole.obj", overwrite=True)["ok"]
    (agent.project / "part.mtl").symlink_to("whole.mtl")
    before = (agent.project / "whole.mtl").read_bytes()
    agent.refused("export", session=room, path="part.obj", overwrite=True)
    assert not (agent.project / "part.obj").exists()
    assert (agent.project / "whole.mtl").read_bytes() == before
    assert [name for name in os.listdir(agent.project) if name.startswith(".scenelang-")] == []


def test_a_program_does_not_write_when_it_is_exported(agent: Any) -> None:
    """The process that writes exports evaluates without rights, as the command line does."""
    (agent.project.parent / "outside.scene").write_text(ROOM)
    session = agent.told("open", program='(import "../outside.scene")')["session"]
    found = agent.told("export", session=session, path="outside.glb")
    assert [each["name"] for each in found["diagnostics"]][:1] == ["import-outside"]
    agent.told("close", session=session, discard=True)


def test_read_only(serve: Callable[..., Any]) -> None:
    with serve("--read-only") as agent:
        tools = {tool.name for tool in agent.portal.call(agent.session.list_tools).tools}
        assert not {"save", "export"} & tools
        assert {"open", "edit", "check", "views", "measure"} <= tools
        session = agent.told("open", program=ROOM)["session"]
        assert "Unknown tool" in agent.refused("save", session=session, path="a.scene")
        assert os.listdir(agent.project) == []


def test_resources_and_prompts(agent: Any, room: str) -> None:
    read = lambda uri: agent.portal.call(agent.session.read_resource, uri).contents[0].text
    assert read(f"scenelang://sessions/{room}") == ROOM
    assert "scenelang://examples/chessboard" in read("scenelang://examples").splitlines()
    assert "(bind" in read("scenelang://examples/chessboard")
    prompts = agent.portal.call(agent.session.list_prompts).prompts
    assert [prompt.name for prompt in prompts] == ["build", "edit", "inspect", "reconstruct"]
    known = {tool.name for tool in agent.portal.call(agent.session.list_tools).tools}
    for prompt in prompts:
        arguments = {each.name: "A TASK" for each in prompt.arguments}
        (message,) = agent.portal.call(agent.session.get_prompt, prompt.name, arguments).messages
        assert "A TASK" in message.content.text
        assert len({word.strip("`") for word in message.content.text.split() if word.strip("`,.;") in known}) >= 1


@pytest.mark.slow
def test_every_answer_is_short(agent: Any) -> None:
    many = '(bind "a" (lambda () (union-loop 120 (lambda (i) (transform (call (format "word-{}" i)) (translate [i 0 0]))))))'
    session = agent.told("open", program=many + "\n" * 200 + "; end")["session"]
    calls: list[tuple[str, dict[str, Any]]] = [
        ("help", {}), ("help", {"name": "for"}), ("help", {"name": "cube"}), ("search", {"query": "color", "limit": 20}),
        ("read", {}), ("query", {}), ("measure", {"a": "*"}), ("count", {}), ("run", {}), ("relations", {}), ("sessions", {}),
        ("check", {"geometry": True}), ("views", {"overlay": "instance", "side": 64}), ("repair", {"effort": 1}),
    ]  # fmt: skip
    for tool, arguments in calls:
        own = {} if tool in ("help", "search", "sessions") else {"session": session}
        result = agent.call(tool, **own, **arguments)
        assert not result.is_error, text(result)
        assert size(result) < 4_096, tool
    assert "more" in text(agent.call("query", session=session))
    wrong = agent.told("open", program="\n".join(f"(f{i})" for i in range(500)))["session"]
    assert "... and 496 more findings" in text(agent.call("edit", session=wrong, start=0, text=";"))
    agent.told("close", session=wrong, discard=True)
    agent.told("close", session=session, discard=True)


def test_text_and_data_are_cut_where_it_is_told() -> None:
    from scenelang.mcp.tools import MAX_ANSWER, ToolAnswer, fitted

    data = {
        "ok": True,
        "items": [{"name": "x" * 300}] * 80,
        "counts": {f"w{i}": i for i in range(900)},
        "items_left_out": 7,
    }
    found = fitted(ToolAnswer("ü" * 9_000, data))
    assert found.data is not None
    assert len(found.text.encode()) + len(json.dumps(found.data)) <= MAX_ANSWER
    assert found.data["items_left_out"] + len(found.data["items"]) == 87
    assert found.data["counts_left_out"] + len(found.data["counts"]) == 900
    assert "more characters" in found.text
    assert fitted(ToolAnswer("", {"ok": False, "a": {"b": {"c": ["x" * 9_000] * 9}}})).data is not None


def test_the_size_of_versions_is_limited() -> None:
    from scenelang.mcp.workbench import WorkingProgram

    draft = WorkingProgram("s1", "")
    for number in range(300):
        draft.set(f"; {number}")
    assert draft.step(1_000, back=True) == 200
    big = WorkingProgram("s1", "")
    for number in range(40):
        big.set(f"{number}" + "x" * 990_000)
    assert sum(map(len, big.before)) <= 20_000_000
    assert len(big.before) >= 10


def test_example_files_are_only_examples() -> None:
    from scenelang.reference.searching import example_names, example_text

    assert "chessboard" in example_names()
    assert [example_text(name) for name in ("../README", "nothing", "", "a/b", "chess\0board")] == [None] * 5
