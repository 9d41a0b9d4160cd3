"""Sessions that outlive their server, and files of sessions that are damaged, links or too many."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from scenelang.mcp.session_files import FOLDER, session_files
from scenelang.mcp.workbench import WorkingProgram

CUBE = '(bind "a" (lambda () (call "cube")))'


def text(result: Any) -> str:
    return "\n".join(content.text for content in result.content if content.type == "text")


def test_a_session_survives_with_its_history(serve: Callable[..., Any]) -> None:
    with serve() as agent:
        assert "sessions end with" not in text(agent.call("open", program=CUBE))
        agent.told("open", program="; second")
        agent.told("replace", session="s1", old="cube", new="sphere")
        agent.told("replace", session="s1", old="sphere", new="cone")
        agent.told("undo", session="s1")
        agent.told("close", session="s2", discard=True)
        assert os.listdir(agent.project / FOLDER) == ["s1.json"]
    with serve() as agent:
        assert [each["session"] for each in agent.told("sessions")["sessions"]] == ["s1"]
        assert "sphere" in text(agent.call("read", session="s1"))
        assert agent.told("redo", session="s1")["steps"] == 1
        assert "cone" in text(agent.call("read", session="s1"))
        assert agent.told("undo", session="s1", steps=9)["steps"] == 2
        assert agent.told("save", session="s1", path="a.scene")["unsaved"] is False
    with serve() as agent:
        assert agent.told("open")["session"] == "s2"
        assert agent.told("sessions")["sessions"][0]["unsaved"] is False
        (agent.project / "a.scene").write_text("; of another")
        agent.told("replace", session="s1", old="cube", new="cone")
        assert "was changed since" in agent.refused("save", session="s1")


def test_only_one_server_keeps_the_sessions(serve: Callable[..., Any]) -> None:
    with serve() as first, serve() as second:
        first.told("open", program=CUBE)
        assert "another server keeps" in text(second.call("open", program="; mine"))
        assert json.loads((first.project / FOLDER / "s1.json").read_text())["text"] == CUBE


def test_without_a_project_and_read_only_nothing_is_kept(serve: Callable[..., Any], tmp_path: Path) -> None:
    with serve("--read-only") as agent:
        assert "which is read-only" in text(agent.call("open", program=CUBE))
        assert os.listdir(agent.project) == []
    request = [
        {"id": 0, "method": "initialize", "params": {
            "protocolVersion": "2025-03-26", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}},
        {"method": "notifications/initialized"},
        {"id": 1, "method": "tools/call", "params": {"name": "open", "arguments": {"program": CUBE}}},
    ]  # fmt: skip
    command = [sys.executable, "-P", "-m", "scenelang", "mcp"]
    folder = tmp_path / "current"
    folder.mkdir()
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        for message in request:
            server.stdin.write(json.dumps({"jsonrpc": "2.0", **message}).encode() + b"\n")
            server.stdin.flush()
        said = [json.loads(server.stdout.readline()) for _ in range(2)]
        server.stdin.close()
    assert "start it with `--project` to keep them" in said[1]["result"]["content"][0]["text"]
    assert os.listdir(folder) == []


GOOD = {"format": 1, "text": CUBE, "path": "", "saved": None, "acceptance": [], "before": [], "after": []}


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "no JSON"),
        (b"\xff\xfe\x00", "no JSON"),
        (b"[" * 1_000_000, "no JSON"),
        (b"[]", "no session"),
        (b'{"format": 2}', "no session"),
        (json.dumps({**GOOD, "text": 3}).encode(), "`text`"),
        (json.dumps({**GOOD, "text": "x" * 1_000_001}).encode(), "`text`"),
        (json.dumps({**GOOD, "before": ["x"] * 201}).encode(), "`before`"),
        (json.dumps({**GOOD, "before": ["x" * 900_000] * 3}).encode(), "`before`"),
        (json.dumps({**GOOD, "after": {}}).encode(), "`after`"),
        (json.dumps({**GOOD, "acceptance": [1]}).encode(), "`acceptance`"),
        (json.dumps({**GOOD, "path": "../a.scene"}).encode(), "`path`"),
        (json.dumps({**GOOD, "path": "/etc/a.scene"}).encode(), "`path`"),
    ],
)
def test_a_damaged_file_is_skipped(tmp_path: Path, content: bytes, reason: str) -> None:
    files = session_files(tmp_path)
    assert files.keep(WorkingProgram("s1", "; first")) == ""
    (tmp_path / FOLDER / "s2.json").write_bytes(content)
    read = files.read()
    assert [draft.text for draft in read.drafts] == ["; first"]
    assert read.number == 2  # s2.json is not overwritten
    (note,) = read.notes
    assert note.startswith("skipped .scenelang/sessions/s2.json: ")
    assert reason in note
    os.close(files.lock)


def test_notes_are_part_of_an_answer(serve: Callable[..., Any], tmp_path: Path) -> None:
    folder = tmp_path / "project" / FOLDER
    folder.mkdir(parents=True)
    for number in range(1, 30):
        (folder / f"s{number}.json").write_text("damaged" if number < 8 else json.dumps(GOOD))
    (folder / "s99999999999999999999.json").write_text(json.dumps(GOOD))
    (folder / "other.txt").write_text("of another")
    with serve() as agent:
        said = text(agent.call("sessions"))
        assert said.count("s1.json: it is no JSON") == 1
        assert "skipped 10 more files" in said
        assert "16 sessions are open" in agent.refused("open")
        agent.told("close", session="s8", discard=True)
        opened = agent.call("open")
        assert "session s30, an empty program\nskipped .scenelang/sessions/s1.json" in text(opened)
    assert (folder / "s1.json").read_text() == "damaged"
    assert (folder / "other.txt").exists()


@pytest.mark.parametrize("part", [".scenelang", "sessions"])
@pytest.mark.parametrize("kind", ["link", "file"])
def test_links_in_place_of_folders(serve: Callable[..., Any], tmp_path: Path, part: str, kind: str) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    at = tmp_path / "project" / (part if part == ".scenelang" else FOLDER)
    at.parent.mkdir(parents=True, exist_ok=True)
    if kind == "link":
        at.symlink_to(outside)
    else:
        at.write_text("a file")
    with serve() as agent:
        assert "sessions end with the server: " in text(agent.call("open", program=CUBE))
        assert agent.told("replace", session="s1", old="cube", new="cone")["version"] == 1
    assert os.listdir(outside) == []


def test_links_and_special_files_in_place_of_sessions(serve: Callable[..., Any], tmp_path: Path) -> None:
    folder = tmp_path / "project" / FOLDER
    folder.mkdir(parents=True)
    secret = tmp_path / "secret.json"
    secret.write_text(json.dumps({**GOOD, "text": "; secret"}))
    (folder / "s1.json").symlink_to(secret)
    os.link(secret, folder / "s2.json")
    os.mkfifo(folder / "s3.json")
    (folder / "s4.json").mkdir()
    with serve() as agent:
        opened = agent.call("open", program=CUBE)
        assert opened.structured_content["session"] == "s5"
        assert "secret" not in text(opened)
        assert text(opened).count("it is a link, a folder or a special file") == 3
        (folder / "s5.json").unlink()
        (folder / "s5.json").symlink_to(secret)
        changed = agent.call("replace", session="s5", old="cube", new="cone")
        assert "not kept for another server" in text(changed)
        assert "not removed" in text(agent.call("close", session="s5", discard=True))
    assert "secret" in secret.read_text()


def test_history_is_kept_within_limits(tmp_path: Path) -> None:
    files = session_files(tmp_path)
    draft = WorkingProgram("s1", "")
    for number in range(6):
        draft.set(f"{number}" + "\ud800x" * 300_000)
    draft.step(1, back=True)
    assert files.keep(draft) == ""
    (read,) = files.read().drafts
    assert [version[0] for version in read.before] == ["1", "2", "3"]
    assert (read.text, read.after) == (draft.text, [])
    os.close(files.lock)
