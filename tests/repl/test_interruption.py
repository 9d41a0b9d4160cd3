"""Ctrl-C while a command of the REPL writes files."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenelang.repl.commands import commands
from scenelang.repl.display import Screen
from scenelang.repl.evaluation import ReplEvaluation
from scenelang.repl.loop import Repl
from scenelang.session.session import Options, Session

INTERRUPTED = [
    (',render (call "cube") -o {}/a.png', "PIL.Image.Image.save"),
    (",export {}/a.glb", "scenelang.backends.files._move_all"),
]


@pytest.mark.parametrize(("command", "interrupted"), INTERRUPTED)
@pytest.mark.sampled(2)
def test_ctrl_c_ends_a_command_and_leaves_no_file(
    command: str, interrupted: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The signal comes when the file is being written or is to be moved to its place."""
    reached: list[str] = []

    def interrupt(*_: object, **__: object) -> None:
        reached.append(interrupted)
        raise KeyboardInterrupt

    said: list[str] = []
    complained: list[str] = []
    repl = Repl(ReplEvaluation(Session(Options())), Screen(said.append, complained.append), commands())
    repl.feed('(bind "a" (lambda () (call "cube")))')
    with monkeypatch.context() as patched:
        patched.setattr(interrupted, interrupt)
        outcome = repl.feed(command.format(tmp_path))
    assert reached
    assert [d.name for d in outcome.diagnostics] == ["interrupted"]
    assert f"`{command.split()[0]}` was interrupted" in complained[0]
    assert list(tmp_path.iterdir()) == []
    repl.feed("(+ 40 2)")
    assert said[-1] == "42"
