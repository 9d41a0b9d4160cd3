"""What the viewer keeps of its files: changes on disk, the last good picture, values that are tried out."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support import rewrite, wait_until

from scenelang import Options, Session, Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.viewer.workspace import FileWatch, evaluator, stamps_of, state_data

GOOD = '(param n 2 :min 1 :max 9)\n(bind "row" (lambda () (union-loop n (lambda (i) (call "cube")))))\n'


def test_a_change_is_seen_and_the_last_good_picture_stays(program: Callable[..., Path], workspace: Any) -> None:
    path = program(GOOD)
    space = workspace(path)
    heard: list[int] = []
    space.listen(heard.append)
    first = space.state(0)
    assert first.ok
    space.refresh()
    assert space.state(0) is first
    path.write_text(GOOD.replace("(call", "(cull"))
    space.refresh()
    broken = space.state(0)
    assert not broken.ok
    assert (broken.picture, broken.packet) == (first.picture, first.packet)
    (told,) = state_data("a", broken)["diagnostics"]
    assert told["severity"] == "error"
    assert "a.scene:2:" in told["text"]
    assert [control.param.name for control in broken.controls] == ["n"]
    path.write_text(GOOD)
    space.refresh()
    assert space.state(0).ok
    assert space.state(0).picture == 3
    assert heard == [0, 0, 0]


def test_imports_are_watched_and_a_missing_one_is_waited_for(program: Callable[..., Path], workspace: Any) -> None:
    space = workspace(program('(import "part.scene")\n(bind "a" (lambda () (call "part")))'))
    assert not space.state(0).ok
    part = program('(bind "part" (lambda () (call "cube")))', "part.scene")
    space.refresh()
    assert space.state(0).ok
    part.write_text("(")
    space.refresh()
    assert not space.state(0).ok


def test_a_file_that_is_gone_or_not_yet_there(program: Callable[..., Path], workspace: Any, tmp_path: Path) -> None:
    space = workspace(tmp_path / "later.scene")
    (problem,) = space.state(0).diagnostics
    assert problem.name == "file"
    program(GOOD, "later.scene")
    space.refresh()
    assert space.state(0).ok
    (tmp_path / "later.scene").unlink()
    space.refresh()
    assert not space.state(0).ok
    assert space.state(0).packet is not None


def test_values_are_tried_out_until_the_file_has_another(program: Callable[..., Path], workspace: Any) -> None:
    path = program(GOOD)
    space = workspace(path)
    before = space.state(0).packet
    space.try_value(0, "n", 7)
    assert space.state(0).packet != before
    path.write_text(GOOD + "; a comment")
    space.refresh()
    assert space.state(0).values == {"n": 7}
    path.write_text(GOOD.replace("n 2", "n 3"))
    space.refresh()
    assert space.state(0).values == {}
    assert space.state(0).controls[0].value == 3
    space.try_value(0, "n", 8)
    path.write_text(GOOD.replace("(param n 2 :min 1 :max 9)", "(define n 2)"))
    space.refresh()
    assert space.state(0).ok
    assert space.state(0).values == {}


def test_a_value_out_of_range_is_told_and_can_be_taken_back(program: Callable[..., Path], workspace: Any) -> None:
    space = workspace(program(GOOD))
    space.state(0)
    space.try_value(0, "n", 100)
    assert [d.name for d in space.state(0).diagnostics] == ["param"]
    space.try_value(0, "n", None)
    assert space.state(0).ok
    for name, value in (("m", 3), ("n", "three"), ("n", [3])):
        with pytest.raises(SceneError):
            space.try_value(0, name, value)


def test_saving_writes_what_is_tried_out(program: Callable[..., Path], workspace: Any) -> None:
    path = program(GOOD)
    space = workspace(path)
    space.state(0)
    with pytest.raises(SceneError):
        space.save(0, "n")
    space.try_value(0, "n", 5)
    space.save(0, "n")
    assert path.read_text() == GOOD.replace("n 2", "n 5")
    assert space.state(0).values == {}
    assert space.state(0).ok


def test_a_change_while_the_file_is_evaluated_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    path.write_text('(bind "a" (lambda () (call "cube")))', "utf-8")

    class Edited(Session):
        def source(self, name: str) -> Source:
            found = super().source(name)
            path.write_text('(bind "a" (lambda () (call "sphere" :radius 2)))', "utf-8")
            return found

    made = evaluator(lambda _, __: Edited(Options()), 1_000)(str(path), {})
    assert made.packet is not None
    assert made.stamps.are_old()


def test_the_folder_of_a_linked_file_is_watched(tmp_path: Path) -> None:
    target = tmp_path / "elsewhere" / "b.scene"
    target.parent.mkdir()
    target.write_text("", "utf-8")
    link = tmp_path / "a.scene"
    link.symlink_to(target)
    assert stamps_of([str(link)]).folders >= {str(tmp_path), str(target.parent)}


def test_a_notification_arrives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenelang.viewer.workspace._MAX_WAIT_MS", 10_000_000)  # without one it would look after hours
    path = tmp_path / "a.scene"
    path.write_text("1", "utf-8")
    changed = threading.Event()

    def look() -> None:
        if path.read_text("utf-8") == "2":
            changed.set()

    def is_noticed() -> bool:
        rewrite(path, "2")  # again, since the first may come before it watches
        return changed.wait(0.1)

    watch = FileWatch(lambda: stamps_of([str(path)]).folders, look)
    try:
        wait_until(is_noticed)
    finally:
        watch.stop()


def test_a_change_on_disk_is_announced_by_an_edit_that_comes_first(workspace: Any, program: Any) -> None:
    """An edit after a change on disk, and before the watcher looks, must not hide the change."""
    path = program('(bind "a" (lambda () (call "cube")))')
    edited = workspace(path)
    edited.state(0)
    heard: list[int] = []
    edited.listen(heard.append)
    edited.edit(0, '(bind "a" (lambda () (call "cone")))')
    assert heard == []
    program('(bind "a" (lambda () (call "sphere")))')
    edited.edit(0, '(bind "a" (lambda () (call "torus")))')
    assert heard == [0]
